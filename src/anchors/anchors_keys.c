/* anchors_keys.c: checks the keys of anchors against each other and against the stages. */
#include "anchors/anchors.h"
#include "scene/reader.h"

/* Complains about a key of an anchor, unless a misspelt key explains the complaint. */
#define COMPLAIN_OF(r, anchor, ...)                                                                          \
  do {                                                                                                       \
    char of[LABEL_LENGTH];                                                                                   \
    snprintf(of, sizeof of, "anchors.%s", (anchor)->entry.name);                                             \
    Complain((r)->missing, (r)->scene->file, (anchor)->entry.line, of, __VA_ARGS__);                         \
  } while (0)

static PetscInt stage_of(const Scene *scene, const char *name)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (!strcmp(scene->stages[s].name, name)) return s;
  return -1;
}

static void check_shape(Reader *r, const Anchor *a)
{
  const PetscReal length = AnchorLength(a);
  if (!(length > 0.))
    COMPLAIN_OF(r, a, "head and root are the same point");
  else if (a->free_length > length * (1. + 1e-9))
    COMPLAIN_OF(r, a, "free_length %g is more than the %g m from head to root", (double)a->free_length,
                (double)length);
  if (a->breaking_force > a->yield * a->area && a->breaking_force < PETSC_INFINITY)
    COMPLAIN_OF(r, a,
                "breaking_force %g is more than yield area = %g [N]: it yields and never breaks; "
                "expected less, or strain_limit",
                (double)a->breaking_force, (double)(a->yield * a->area));
}

static void check_bond(Reader *r, const Anchor *a)
{
  PetscReal stiffness, strength;
  AnchorDowel(a, &stiffness, &strength);
  if (a->bond_stiffness > 0.) {
    if (a->free_length >= AnchorLength(a) * (1. - 1e-9))
      COMPLAIN_OF(r, a, "free_length %g leaves no bonded length of the %g m from head to root",
                  (double)a->free_length, (double)AnchorLength(a));
    if (a->plate && a->free_length > 0.)
      COMPLAIN_OF(r, a, "plate is for a bar that is bonded from its head on: free_length has one");
    for (PetscInt i = 0; i < a->n_forces; i++)
      if (a->prestress[i] >= a->bond_strength * (AnchorLength(a) - a->free_length))
        COMPLAIN_OF(r, a, "prestress %g is not below the %g N that the bond holds", (double)a->prestress[i],
                    (double)(a->bond_strength * (AnchorLength(a) - a->free_length)));
    if (a->strain_limit < PETSC_INFINITY)
      COMPLAIN_OF(r, a, "strain_limit is for a free length: expected breaking_force for a bonded bar");
    if (AnchorLength(a) > 10000. * AnchorSegment(a))
      COMPLAIN_OF(r, a, "segment: pieces of %g m are more than 10000", (double)AnchorSegment(a));
  } else if (a->bond_strength < PETSC_INFINITY || a->segment > 0. || a->plate) {
    COMPLAIN_OF(r, a, "bond_stiffness is missing: %s is for a bonded bar",
                a->bond_strength < PETSC_INFINITY ? "bond_strength"
                : a->segment > 0.                 ? "segment"
                                                  : "plate");
  } else if (stiffness > 0. || strength < PETSC_INFINITY) {
    COMPLAIN_OF(r, a, "bond_stiffness is missing: a dowel is a bonded bar");
  }
  if (strength < PETSC_INFINITY && !(stiffness > 0.))
    COMPLAIN_OF(r, a, "dowel_strength needs dowel_stiffness or dowel_foundation");
  if (a->dowel_stiffness > 0. && a->dowel_foundation > 0.)
    COMPLAIN_OF(r, a, "expected dowel_stiffness or dowel_foundation, not both");
}

/* Returns whether a stage of type anchor_force pulls the anchor. */
static PetscBool is_pulled(const Scene *scene, const Anchor *a)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (AnchorIsPulled(scene->stages + s, a)) return PETSC_TRUE;
  return PETSC_FALSE;
}

static void check_prestress(Reader *r, const Anchor *a)
{
  if (a->bond_stiffness > 0. && a->n_forces && !(a->free_length > 0.)) {
    COMPLAIN_OF(r, a, "prestress needs a free_length: this bar is bonded from its head on");
    return;
  }
  const PetscReal stiffness = a->young * a->area / PetscMax(AnchorFree(a), 1e-9 * AnchorLength(a)),
                  most = AnchorStrength(a);
  for (PetscInt i = 0; i < a->n_forces; i++) {
    if (a->prestress[i] >= most)
      COMPLAIN_OF(r, a, "prestress %g is not below the %g N at which it yields or breaks",
                  (double)a->prestress[i], (double)most);
    if (a->draw_in * stiffness >= a->prestress[i])
      COMPLAIN_OF(r, a, "draw_in %g loses all of the prestress %g: it stretches by %g m only",
                  (double)a->draw_in, (double)a->prestress[i], (double)(a->prestress[i] / stiffness));
  }
  const PetscBool found = (PetscBool)(a->n_forces == 1 && is_pulled(r->scene, a));
  if (a->n_forces && !a->n_locks && !found)
    COMPLAIN_OF(r, a, "lock is missing: the stage in which it is stressed");
  else if (a->n_locks && !a->n_forces)
    COMPLAIN_OF(r, a, "prestress is missing [N]");
  else if (a->n_locks != a->n_forces && !found)
    COMPLAIN_OF(r, a, "lock names %d stages, prestress has %d forces", (int)a->n_locks, (int)a->n_forces);
  if (a->draw_in > 0. && !a->n_forces) COMPLAIN_OF(r, a, "draw_in is for an anchor with prestress");
  if (a->from[0] && a->n_forces) COMPLAIN_OF(r, a, "from is for a passive anchor: this one has prestress");
}

static void check_stages(Reader *r, const Anchor *a)
{
  const Scene *scene = r->scene;
  const PetscInt from = a->from[0] ? stage_of(scene, a->from) : 0;
  PetscInt before = -1;
  if (from < 0)
    COMPLAIN_OF(r, a, "from: no stage named '%s'", a->from);
  else if (!a->n_forces && StageEvaluates(scene->stages + from)) // it has no loads, so it stresses no anchor
    COMPLAIN_OF(r, a,
                "from: stage %s of type modes does not change the state: expected a stage of another type",
                scene->stages[from].name);
  for (PetscInt i = 0; i < a->n_locks; i++) {
    const PetscInt s = stage_of(scene, a->lock[i]);
    if (s < 0) {
      COMPLAIN_OF(r, a, "lock: no stage named '%s'", a->lock[i]);
      return;
    }
    if (scene->stages[s].kind != STAGE_STATIC) COMPLAIN_OF(r, a, "lock: stage %s is not static", a->lock[i]);
    if (s <= before)
      COMPLAIN_OF(r, a, "lock: stage %s does not come after %s", a->lock[i], scene->stages[before].name);
    for (PetscInt next = s + 1; next < scene->n_stages; next++)
      if (a->draw_in > 0. && StageBase(scene, next) == s && StageInTime(scene->stages + next))
        COMPLAIN_OF(r, a,
                    "draw_in: stage %s in time begins as its head slips: expected a static stage between",
                    scene->stages[next].name);
    before = s;
  }
}

PetscErrorCode CompleteAnchors(Reader *r)
{
  PetscInt n;
  const Anchor *anchors = SceneEntries(r->scene, "anchors", &n);

  PetscFunctionBeginUser;
  for (const Anchor *a = anchors; a < anchors + n && !r->message[0]; a++) {
    check_shape(r, a);
    check_bond(r, a);
    check_prestress(r, a);
    check_stages(r, a);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

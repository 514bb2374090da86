/* anchor_shape.c: computes lengths, strength, dowel stiffness and prestress of an anchor from its keys. */
#include "anchors/anchors.h"

PetscReal AnchorLength(const Anchor *a)
{
  return PetscHypotReal(a->head[0] - a->root[0], a->head[1] - a->root[1]);
}

PetscReal AnchorFree(const Anchor *a)
{
  if (a->free_length > 0. || a->bond_stiffness > 0.) return a->free_length;
  return AnchorLength(a);
}

PetscReal AnchorSegment(const Anchor *a)
{
  const PetscReal part = 0.2; // [-] segment over the length that transfers the force; error: part^2/8
  return a->segment > 0. ? a->segment : part * PetscSqrtReal(a->young * a->area / a->bond_stiffness);
}

PetscReal AnchorStrength(const Anchor *a)
{
  return PetscMin(PetscMin(a->yield * a->area, a->breaking_force), a->strain_limit * a->young * a->area);
}

PetscReal AnchorMostPull(const Anchor *a)
{
  const PetscReal bonded = AnchorLength(a) - AnchorFree(a);
  return a->bond_stiffness > 0. ? PetscMin(AnchorStrength(a), a->bond_strength * bonded) : AnchorStrength(a);
}

const Anchor *AnchorNamed(const Scene *scene, const char *name)
{
  PetscInt n;
  const Anchor *anchors = SceneEntries(scene, "anchors", &n);
  for (PetscInt i = 0; i < n; i++)
    if (!strcmp(anchors[i].entry.name, name)) return anchors + i;
  return NULL;
}

PetscBool AnchorIsPulled(const Stage *stage, const Anchor *a)
{
  if (stage->kind != STAGE_ANCHOR_FORCE) return PETSC_FALSE;
  for (PetscInt i = 0; i < stage->n_anchors; i++)
    if (!strcmp(stage->anchors[i], a->entry.name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscReal AnchorPrestress(const Scene *scene, const Stage *stage, const Anchor *a)
{
  PetscInt s = 0;
  while (s < scene->n_stages && strcmp(scene->stages[s].name, stage->name)) s++;
  for (s = s < scene->n_stages ? StageBase(scene, s) : -1; s >= 0; s = StageBase(scene, s))
    for (PetscInt i = 0; i < a->n_locks; i++)
      if (!strcmp(a->lock[i], scene->stages[s].name)) return a->prestress[i];
  return a->prestress[0];
}

/* Computes the stiffness [N/m] and strength [N] of a dowel: a beam on an elastic foundation. The slip of a
   joint between its halves bends the beam:

     K = E I beta^3,   beta = (foundation/(4 E I))^(1/4),

   with the largest moment V exp(-pi/4) sin(pi/4)/beta at pi/(4 beta) from the joint. */
void AnchorDowel(const Anchor *a, PetscReal *stiffness, PetscReal *strength)
{
  *stiffness = a->dowel_stiffness, *strength = a->dowel_strength;
  if (!(a->dowel_foundation > 0.)) return;
  const PetscReal diameter = PetscSqrtReal(4. * a->area / PETSC_PI),
                  section = PETSC_PI / 32. * diameter * diameter * diameter,
                  bending = a->young * 0.5 * section * diameter,
                  beta = PetscSqrtReal(PetscSqrtReal(a->dowel_foundation / (4. * bending))),
                  moment = PetscExpReal(-0.25 * PETSC_PI) * PetscSinReal(0.25 * PETSC_PI) / beta;
  *stiffness = bending * beta * beta * beta;
  if (a->dowel_strength == PETSC_INFINITY && a->yield < PETSC_INFINITY)
    *strength = a->yield * section / moment;
}

/* corner.c: hides contacts of corners that only seem to meet another face, when connectivity is variable.

   A block that stands on another is pressed in. Its corners lie below the face that carries it: level with
   the sides of blocks beside, and, where faces are flush, over the end of the next face too. None of this is
   a contact, because the face below carries the corner. So a new contact of a corner with a face is hidden if
   a face of the corner was in contact with another face, its ground, and the new face stands nowhere in front
   of that ground. Faces flush with the ground become contacts when the block has slid so far that the old
   contact is measured again.

   The rank that owns the vertex decides, because it is sure to know all faces at the corner, all faces near
   it, and their old contacts. It sends its decision to all ranks. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* [-] in tolerances: length of a face that counts, from the corner on. Steps and kinks farther away are not
   at the corner. */
static const PetscReal REACH = 10.;

static PetscReal tolerance_of(const Scene *scene, const FaceTable *table, PetscInt f, PetscInt g)
{
  return scene->contact_tolerance *
         (scene->contact_relative ? PetscMin(table->length[f], table->length[g]) : 1.);
}

/* Decides whether face g near P stands in front of face `ground`, by a step higher than FLUSH tolerances.
   depth: [m] depth of P in the ground. */
static PetscBool stands_in_front(const FaceTable *table, PetscInt g, PetscInt ground, const PetscReal *P,
                                 PetscReal depth, PetscReal tolerance)
{
  const PetscReal *a = table->x + 4 * g, *b = table->x + 4 * ground;
  const PetscReal reach = (REACH * tolerance + depth) / table->length[g];
  const PetscReal cosine = (a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1]);
  const PetscBool level = (PetscBool)(cosine > FACE_COS_LIMIT * table->length[g] * table->length[ground]);
  PetscReal t, gap, most = -PETSC_MAX_REAL;
  face_project(a, a + 2, P, &t, &gap);
  if (level) { // a face that goes on behind a kink becomes a contact of faces, so where it begins decides
    face_project(b, b + 2, a + 2 * (t > 0.5), &t, &gap);
    return (PetscBool)(gap > FLUSH * tolerance);
  }
  for (int k = -1; k <= 1; k += 2) {
    const PetscReal at = PetscClipInterval(t + k * reach, 0., 1.);
    const PetscReal Q[2] = {a[0] + at * (a[2] - a[0]), a[1] + at * (a[3] - a[1])};
    PetscReal s;
    face_project(b, b + 2, Q, &s, &gap);
    most = PetscMax(most, gap);
  }
  return (PetscBool)(most > FLUSH * tolerance);
}

PetscBool CornerIsHidden(const Scene *scene, const FaceTable *table, PetscInt v, const PetscReal P[2],
                         PetscInt f, PetscInt g)
{
  for (PetscInt r = table->vertex_start[v]; r < table->vertex_start[v + 1]; r++) {
    const PetscInt mine = table->vertex_row[r];
    const char needed = mine == f ? TOUCHES | STAYS : TOUCHES | TOUCHED;
    for (PetscInt p = table->start[mine]; p < table->start[mine + 1]; p++) {
      const PetscInt ground = table->near[p];
      if (ground == g || (table->touch[p] & needed) != needed) continue;
      const PetscReal *x = table->x + 4 * ground, tolerance = tolerance_of(scene, table, mine, ground);
      PetscReal t, gap;
      face_project(x, x + 2, P, &t, &gap);
      if (PetscMin(t, 1. - t) * table->length[ground] < -tolerance || gap > tolerance) continue;
      if (!stands_in_front(table, g, ground, P, PetscMax(0., -gap), tolerance)) return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* ---- face contacts */

typedef struct {
  PetscInt key[2];
} Key;

static PetscBool at_owned_vertex(const Model *m, PetscInt f)
{
  return (PetscBool)(m->faces.vertex[2 * f] < m->mesh.n_owned ||
                     m->faces.vertex[2 * f + 1] < m->mesh.n_owned);
}

/* Decides whether the candidate, a new contact, reaches through a block, or joins two corners of which an
   owned one is hidden. */
static PetscBool is_hidden(const Scene *scene, const Model *m, const FaceTable *table, const Candidate *c)
{
  if (c->before >= 0 || c->kept) return PETSC_FALSE;
  for (int k = 0; k < 2;
       k++) // the layer is near both faces; where groups are not upgradeable only one knows it
    if (at_owned_vertex(m, c->face[k]) && FaceIsScreened(m, table, c->face[k], c->face[1 - k]))
      return PETSC_TRUE;
  if (c->pair.klass != FF2_I && c->pair.klass != FF2_F) return PETSC_FALSE;
  for (int k = 0; k < 2; k++) {
    const PetscInt source = c->pair.source[k], f = c->face[source], g = c->face[1 - source];
    const int corner = c->pair.corner[k];
    const PetscInt v = m->faces.vertex[2 * f + corner];
    if (v < m->mesh.n_owned && CornerIsHidden(scene, table, v, table->x + 4 * f + 2 * corner, f, g))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode CornersHide(const Scene *scene, const Model *m, const FaceTable *table, CandidateList *list)
{
  PetscInt n = 0, stay = 0;
  Key *keys;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(list->n + 1, &keys));
  for (PetscInt i = 0; i < list->n; i++)
    if (is_hidden(scene, m, table, list->item + i))
      keys[n++] = (Key){{list->item[i].key[0], list->item[i].key[1]}};
  PetscCall(GatherSorted(m->comm, n, sizeof(Key), keys, OrderByPair, &n, (void **)&keys));
  for (PetscInt i = 0; i < list->n && n; i++) {
    const Key key = {{list->item[i].key[0], list->item[i].key[1]}};
    if (!bsearch(&key, keys, n, sizeof(Key), OrderByPair)) list->item[stay++] = list->item[i];
  }
  if (n) list->n = stay;
  PetscCall(PetscFree(keys));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* layers.c: finds pairs of near faces that a thin block separates. They are no contact, because the block
   between them carries the force. So a new contact is left out where other faces stand in front of the face
   that it would reach. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* [-] Part of a contact that may lie behind a block. LAYER: behind a whole layer; even a small piece of a
   layer screens the contact. FRONT: behind any face. A face that stands in front by less than half the
   thickness of its block may belong to a block beside, by the rounding of coordinates; then half of the
   contact decides. */
static const PetscReal LAYER = 0.02, FRONT = 0.5;

/* A stretch of face f that lies opposite another face, and the gap at its ends. */
typedef struct {
  PetscReal from, to; /* [-] places along f */
  PetscReal gap[2];   /* [m] gap of the other face over f, at `from` and at `to` */
} Stretch;

/* Finds the stretch of face f that lies opposite face h. Returns PETSC_FALSE if there is none. */
static PetscBool stretch_of(const FaceTable *table, PetscInt f, PetscInt h, Stretch *s)
{
  const PetscReal *a = table->x + 4 * f, *b = table->x + 4 * h;
  PetscReal t[2], gap[2];
  face_project(a, a + 2, b + 2, t, gap); // h runs backwards along f
  face_project(a, a + 2, b, t + 1, gap + 1);
  if (!(t[1] > t[0])) return PETSC_FALSE;
  s->from = PetscMax(0., t[0]), s->to = PetscMin(1., t[1]);
  for (int k = 0; k < 2; k++)
    s->gap[k] = gap[0] + (gap[1] - gap[0]) * ((k ? s->to : s->from) - t[0]) / (t[1] - t[0]);
  return (PetscBool)(s->to > s->from);
}

/* Returns the gap [m] at place t along f. */
static PetscReal gap_at(const Stretch *s, PetscReal t)
{
  return s->gap[0] + (s->gap[1] - s->gap[0]) * (t - s->from) / (s->to - s->from);
}

static PetscBool opposite(const FaceTable *table, PetscInt f, PetscInt g)
{
  const PetscReal *a = table->x + 4 * f, *b = table->x + 4 * g;
  const PetscReal scalar = (a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1]);
  return (PetscBool)(scalar < -FACE_COS_LIMIT * table->length[f] * table->length[g]);
}

PetscBool FaceIsScreened(const Model *m, const FaceTable *table, PetscInt f, PetscInt g)
{
  const Faces *faces = &m->faces;
  const PetscReal step = FACE_MIN_OVERLAP * PetscMin(table->length[f], table->length[g]);
  PetscReal layer = 0., front = 0.;
  Stretch far, near;
  if (!stretch_of(table, f, g, &far) || !(PetscMax(far.gap[0], far.gap[1]) > step)) return PETSC_FALSE;
  for (PetscInt p = table->start[f]; p < table->start[f + 1]; p++) {
    const PetscInt h = table->near[p];
    if (h == g || faces->gid[h] / 4 == faces->gid[g] / 4 || !opposite(table, f, h)) continue;
    if (!stretch_of(table, f, h, &near)) continue;
    const PetscReal from = PetscMax(near.from, far.from), to = PetscMin(near.to, far.to);
    if (!(to > from)) continue;
    const PetscReal gap = gap_at(&near, 0.5 * (from + to)), behind = gap_at(&far, 0.5 * (from + to));
    if (gap < -FACE_DEPTH * PetscMin(faces->thick[f], faces->thick[h]) || gap >= behind - step) continue;
    if (gap + 0.5 * faces->thick[h] < behind) layer += to - from;
    front += to - from;
  }
  return (PetscBool)(layer > LAYER * (far.to - far.from) || front > FRONT * (far.to - far.from));
}

PetscBool PointIsScreened(const FaceTable *table, const PetscReal P[2], PetscInt g, PetscInt h)
{
  const PetscReal *a = table->x + 4 * g, *b = table->x + 4 * h;
  const PetscReal step = FACE_MIN_OVERLAP * PetscMin(table->length[g], table->length[h]);
  const PetscReal cosine = (a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1]);
  PetscReal t, gap, behind;
  face_project(b, b + 2, P, &t, &gap);
  if (t < 0. || t > 1. || cosine < FACE_COS_LIMIT * table->length[g] * table->length[h]) return PETSC_FALSE;
  face_project(a, a + 2, P, &t, &behind);
  return (PetscBool)(behind > step && gap < behind - step);
}

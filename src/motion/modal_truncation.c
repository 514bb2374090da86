/* modal_truncation.c: measures, at checks of a stage in time, the error of condensed bodies
   (coupled_bodies.c): the work of centred damping, and the energy of the modes left out. */
#include "motion/coupled_inertia.h"

void CoupledBodiesCentred(const CoupledInertia *l, const State *s, PetscReal works[COUPLED_WORKS])
{
  for (const CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) {
    const PetscReal beta = CondensedCentred(b->of);
    if (beta == 0.) continue;
    DenseTimes(b->stride, b->stride, b->rows->S, b->kept[V_BEHIND], b->kept[ROOM]);
    for (PetscInt i = 0; i < b->n; i++)
      works[COUPLED_DRAG_AHEAD] -= 0.25 * s->dt * beta * b->kept[V_BEFORE][i] * b->kept[ROOM][i];
  }
}

/* Returns 1/2 x.A x of rows. */
static PetscReal half_product(const CoupledBody *b, const PetscReal *A, const PetscReal *x)
{
  PetscReal sum = 0.;
  DenseTimes(b->stride, b->stride, A, x, b->kept[ROOM]);
  for (PetscInt i = 0; i < b->n; i++) sum += 0.5 * x[i] * b->kept[ROOM][i];
  return sum;
}

/* Finds the displacement of rows since the start of the stage; in the memory of forces. */
static const PetscReal *find_way(const CoupledBody *b, const PetscReal *u, const PetscReal *start)
{
  for (PetscInt i = 0; i < b->n_slots; i++)
    b->slots[SLOT_FORCE][i] = u[b->rows->dof[i]] - start[b->rows->dof[i]];
  CondensedFind(b->rows, b->slots[SLOT_FORCE], b->kept[FORCE]);
  return b->kept[FORCE];
}

/* Adds the sums of one body. */
static void add_body(const Model *m, const CoupledBody *b, const State *s, const PetscReal *start,
                     PetscReal works[COUPLED_WORKS])
{
  const Condensed *c = b->of;
  const PetscInt at = 3 * m->rigid.n;
  const PetscReal *q = s->modes[MODE_PLACE] + c->first_mode, next = 2. * PETSC_PI * c->next;
  works[COUPLED_STORED] += half_product(b, b->rows->S, find_way(b, s->u + at, start + at));
  for (PetscInt k = 0; k < c->n_modes; k++) works[COUPLED_STORED] += 0.5 * c->omega2[k] * q[k] * q[k];
  if (!c->truncated) return;
  for (PetscInt i = 0; i < b->n; i++)
    b->kept[FORCE][i] = (b->kept[V_BEHIND][i] - b->kept[V_BEFORE][i]) / s->dt;
  works[COUPLED_TRUNCATED] += half_product(b, b->truncated, b->kept[FORCE]);
  works[COUPLED_ACCELERATION] += half_product(b, b->rows->S, b->kept[FORCE]) / (next * next);
  works[COUPLED_VELOCITY] += half_product(b, b->rows->S, b->kept[V_BEHIND]);
}

void ModalTruncation(const CoupledInertia *l, const State *s, const PetscReal *start,
                     PetscReal works[COUPLED_WORKS])
{
  for (const CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) add_body(l->m, b, s, start, works);
}

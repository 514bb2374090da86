/* support_forces.c: computes the force of each support on the model at the checks of a dynamic stage. A
   support that holds a degree of freedom adds f - f_ext, as `supports` in summary.json: without the inertia
   of the held mass. A boundary that lets waves out holds nothing: whatever its law, its force is the
   remainder of the equation of motion of its vertices, m a + alpha m (v - ground) + f - f_ext. A vertex where
   several of these meet counts for the last. */
#include "result/result.h"

/* Writes the row of a support at both degrees of freedom of the vertices of its faces. */
static void mark(const Model *m, const Support *s, int16_t *row)
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, s->target, &n), first = 3 * m->rigid.n;
  for (PetscInt i = 0; i < n; i++)
    for (int k = 0; k < 2; k++) {
      const PetscInt v = m->faces.vertex[2 * faces[i] + k];
      if (v < m->mesh.n_deformable) row[first + 2 * v] = row[first + 2 * v + 1] = (int16_t)s->row;
    }
}

PetscErrorCode SupportForcesBegin(const Problem *p)
{
  const Model *m = p->m;
  const Scene *scene = p->scene;
  int16_t *row;
  PetscFunctionBeginUser;
  PetscCall(PetscFree(p->found->histories.lets_through));
  PetscCall(PetscMalloc1(m->n_dof, &row));
  for (PetscInt d = 0; d < m->n_dof; d++) row[d] = -1;
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++)
    if (s->boundary != BOUNDARY_FIXED) mark(m, s, row);
  p->found->histories.lets_through = row;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the force [N] of a support on a degree of freedom it holds; the vibration inside a condensed body
   is not in f. */
static PetscReal resisted(const Problem *p, PetscInt d)
{
  const State *s = p->state;
  return s->f[d] - s->f_ext[d] + (s->inertial && d < p->m->n_dof ? s->inertial[d] : 0.);
}

/* Returns the force [N] of the boundary on a degree of freedom, besides forces and damping. */
static PetscReal left_over(const Problem *p, PetscInt d, PetscReal v_before, const PetscReal ground[2])
{
  const State *s = p->state;
  const PetscReal change = (s->v[d] - v_before) / s->dt,
                  over = 0.5 * (s->v[d] + v_before) - DofGround(p->m, d, ground);
  return s->m[d] * (change + s->alpha * over) + resisted(p, d);
}

/* Returns the support that acts on a degree of freedom, -1: none; not on the rotation of a body, nor on
   vertices of rigid bodies, which move with them. */
static PetscInt support_at(const Problem *p, PetscInt d)
{
  const Model *m = p->m;
  const PetscInt v = (d - 3 * m->rigid.n) / 2;
  if (d < 3 * m->rigid.n ? d % 3 == 2 : v >= m->mesh.n_deformable && v < m->mesh.n_moving) return -1;
  if (Held(m, d)) return SupportRow(m, d);
  return d < m->n_dof ? p->found->histories.lets_through[d] : -1;
}

PetscErrorCode SupportForcesSample(const Problem *p, const PetscReal *v_before, const PetscReal ground[2])
{
  const Model *m = p->m;
  const State *s = p->state;
  Histories *h = &p->found->histories;
  const PetscInt n_dof = 3 * m->rigid.n + 2 * m->mesh.n_owned;
  PetscInt n = 0, *slot;
  PetscReal *term, all[2] = {0., 0.};
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < n_dof; d++) n += support_at(p, d) >= 0;
  PetscCall(PetscMalloc2(n, &slot, n, &term));
  n = 0;
  for (PetscInt d = 0; d < n_dof; d++) {
    const PetscInt x = d < 3 * m->rigid.n ? d % 3 : (d - 3 * m->rigid.n) % 2;
    const PetscInt row = support_at(p, d);
    if (row < 0) continue;
    slot[n] = 2 * row + x;
    term[n++] = Held(m, d) ? resisted(p, d) : left_over(p, d, v_before[d], ground);
  }
  PetscCall(BinnedSums(m->comm, n, slot, term, 2 * h->n_supports, h->support));
  for (PetscInt i = 0; i < 2 * h->n_supports; i++) {
    all[i % 2] += h->support[i];
    PeakTake(h->support_peak + i, h->support[i], s->time - s->dt);
  }
  for (int x = 0; x < 2; x++) PeakTake(h->support_peak + 2 * h->n_supports + x, all[x], s->time - s->dt);
  PetscCall(PetscFree2(slot, term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

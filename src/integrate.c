/* integrate.c: the central difference (11)-(20). One loop over all degrees of freedom: displacements of
   deformable vertices, translations and rotations of rigid bodies alike ((7) and (14) have one form). */
#include "internal.h"
#include "reproducible.h"

/* Terms of the next cycle may be this much larger than the largest of the last before the bins are too small.
 */
static const PetscReal GROWTH = 1048576.;

void Integrate(const Model *m, State *state, const QuotientSums *last, QuotientSums *sums)
{
  const PetscReal dt = state->dt, d1 = 1. - 0.5 * state->alpha * dt,
                  d2 = 1. / (1. + 0.5 * state->alpha * dt); // (12), (13)
  const Bins num_bins = BinsFor(PetscMax(last->num_max * GROWTH, PETSC_MACHINE_EPSILON * PETSC_SMALL));
  const Bins den_bins = BinsFor(PetscMax(last->den_max * GROWTH, PETSC_MACHINE_EPSILON * PETSC_SMALL));
  const PetscReal *restrict f = state->f, *restrict f_old = state->f_old, *restrict f_ext = state->f_ext;
  const PetscReal *restrict mass = state->m, *restrict m_inv = state->m_inv, *restrict in_q = m->in_quotient;
  PetscReal *restrict u = state->u, *restrict v = state->v;
  const PetscReal beta = state->beta;
  PetscReal num[2] = {0., 0.}, den[2] = {0., 0.}, num_max = 0., den_max = 0.;

  for (PetscInt d = 0; d < m->n_dof; d++) {
    // terms of (37) with the velocity that led here: v.(f - f_old) and v.m v, see relax.c
    const PetscReal num_d = in_q[d] * v[d] * (f[d] - f_old[d]), den_d = in_q[d] * mass[d] * v[d] * v[d];
    num_max = PetscMax(num_max, PetscAbsReal(num_d));
    den_max = PetscMax(den_max, den_d);
    BinAdd(&num_bins, num_d, num);
    BinAdd(&den_bins, den_d, den);
    // (11), (16): the new velocity at the half step; (17)-(20): the displacement at the step
    v[d] = (v[d] * d1 + m_inv[d] * (f_ext[d] - f[d] - beta * (f[d] - f_old[d])) * dt) * d2;
    u[d] += v[d] * dt;
  }
  *sums = (QuotientSums){{num[0], num[1]}, {den[0], den[1]}, num_max, den_max};
}

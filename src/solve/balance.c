/* balance.c: unbalanced forces, body by body. */
#include "solve/solve.h"
#include "base/reproducible.h"
#include <float.h>

/* The largest terms of the sums over all ranks: bins need them. bad: > 0 when something is not finite. */
typedef struct {
  PetscReal unbalanced, scale, kinetic, displacement, increment, bad;
} Largest;

static Largest largest_terms(const Model *m, const State *state, const PetscReal *contact_scale)
{
  Largest l = {0., 0., 0., 0., 0., 0.};
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    const PetscReal u = PetscAbsReal(state->u[d]) * length,
                    du = PetscAbsReal(state->v[d]) * state->dt * length;
    l.unbalanced = PetscMax(l.unbalanced, r);
    l.scale = PetscMax(l.scale, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + r);
    l.kinetic = PetscMax(l.kinetic, 0.5 * state->m[d] * state->v[d] * state->v[d]);
    l.displacement = PetscMax(l.displacement, u);
    l.increment = PetscMax(l.increment, du);
    if (!(r < PETSC_MAX_REAL / 4. && u < PETSC_MAX_REAL / 4.)) l.bad = 1.;
  }
  return l;
}

PetscErrorCode Unbalanced(const Model *m, const State *state, const PetscReal *contact_scale,
                          StageResult *result)
{
  const PetscInt nb = m->n_bodies_global;
  Largest l = largest_terms(m, state, contact_scale);
  PetscReal *sum, floor = 0.;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &l, sizeof(l) / sizeof(PetscReal), MPIU_REAL, MPI_MAX, m->comm));
  result->increment = l.increment / PetscMax(l.displacement, DBL_MIN);
  result->displacement = l.displacement;
  result->finite = (PetscBool)(l.bad == 0.);
  if (!result->finite) PetscFunctionReturn(PETSC_SUCCESS);

  // of each macroblock, in two bins each: the sum of |unbalanced| over its free dofs, and the sum of
  // |applied| + |contact| + |reaction|; behind them the kinetic energy
  const Bins r_bins = BinsFor(PetscMax(l.unbalanced, 1e-290)), s_bins = BinsFor(PetscMax(l.scale, 1e-290)),
             k_bins = BinsFor(PetscMax(l.kinetic, 1e-290));
  PetscCall(PetscCalloc1(4 * nb + 2, &sum));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    PetscReal *s = sum + 4 * DofBody(m, d);
    BinAdd(&k_bins, 0.5 * state->m[d] * state->v[d] * state->v[d], sum + 4 * nb);
    if (!Held(m, d)) BinAdd(&r_bins, r, s);
    BinAdd(&s_bins, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + (Held(m, d) ? r : 0.), s + 2);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4 * nb + 2, MPIU_REAL, MPI_SUM, m->comm));
  // the floor keeps rounding noise from judging a body that carries next to nothing
  for (PetscInt b = 0; b < nb; b++) floor = PetscMax(floor, 1e-6 * (sum[4 * b + 2] + sum[4 * b + 3]));
  result->ratio = 0.;
  result->worst_body = -1;
  for (PetscInt b = 0; b < nb; b++) {
    const PetscReal unbalanced = sum[4 * b] + sum[4 * b + 1],
                    scale = PetscMax(sum[4 * b + 2] + sum[4 * b + 3], floor);
    if (unbalanced <= 0.) continue;
    if (unbalanced / scale > result->ratio) result->ratio = unbalanced / scale, result->worst_body = b;
  }
  result->kinetic = sum[4 * nb] + sum[4 * nb + 1];
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

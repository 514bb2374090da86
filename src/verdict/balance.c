/* balance.c: computes the unbalanced ratio of a state, body by body, and whether the state is finite. */
#include "verdict/verdict.h"
#include "base/reproducible.h"
#include <float.h>

enum { SUMS = 6 }; /* sums of a macroblock */

/* The largest term of each sum, from which bins are made. bad: > 0 when a number is not finite. */
typedef struct {
  PetscReal unbalanced, scale, load, start, kinetic, displacement, before, increment, bad;
} Largest;

/* Finds the largest terms of this rank. */
static Largest largest_terms(const Model *m, const State *state, const PetscReal *momentum,
                             const PetscReal *contact_scale, const PetscReal *u_0)
{
  Largest l = {.bad = 0.};
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    const PetscReal u = PetscAbsReal(state->u[d]) * length,
                    du = PetscAbsReal(state->v[d]) * state->dt * length;
    l.unbalanced = PetscMax(l.unbalanced, r);
    l.scale = PetscMax(l.scale, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + r);
    l.load = PetscMax(l.load, PetscAbsReal(state->f_ext[d]) / length);
    l.start = PetscMax(l.start, PetscAbsReal(state->applied.start[d]) / length);
    l.kinetic = PetscMax(l.kinetic, PetscAbsReal(0.5 * momentum[d] * state->v[d]));
    l.displacement = PetscMax(l.displacement, u);
    l.before = PetscMax(l.before, PetscAbsReal(u_0[d]) * length);
    l.increment = PetscMax(l.increment, du);
    if (!(r < PETSC_MAX_REAL / 4. && u < PETSC_MAX_REAL / 4.)) l.bad = 1.;
  }
  return l;
}

PetscErrorCode Unbalanced(const Model *m, const State *state, const PetscReal *contact_scale,
                          const PetscReal *u_0, StageResult *result)
{
  const PetscInt nb = m->mesh.n_bodies_global;
  PetscReal *sum, *momentum, floor = 0.;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_dof, &momentum));
  PetscCall(MassProduct(m, state, state->v, momentum));
  Largest l = largest_terms(m, state, momentum, contact_scale, u_0);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &l, sizeof(l) / sizeof(PetscReal), MPIU_REAL, MPI_MAX, m->comm));
  result->increment = l.increment / PetscMax(PetscMax(l.displacement, SCALE_FLOOR * l.before), DBL_MIN);
  result->displacement = l.displacement;
  result->finite = (PetscBool)(l.bad == 0.);
  result->loaded = (PetscBool)(l.load > 0. || l.start > 0.);
  if (!result->finite) {
    PetscCall(PetscFree(momentum));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  // for each macroblock, in two bins each: sum of |unbalanced| over its free degrees of freedom, sum of
  // |applied| + |contact| + |reaction|, sum of the loads when the ramp began; behind them the kinetic energy
  const Bins r_bins = BinsFor(PetscMax(l.unbalanced, 1e-290)), s_bins = BinsFor(PetscMax(l.scale, 1e-290)),
             b_bins = BinsFor(PetscMax(l.start, 1e-290)), k_bins = BinsFor(PetscMax(l.kinetic, 1e-290));
  PetscCall(PetscCalloc1(SUMS * nb + 2, &sum));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    PetscReal *s = sum + SUMS * DofBody(m, d);
    BinAdd(&k_bins, 0.5 * momentum[d] * state->v[d], sum + SUMS * nb);
    if (!Held(m, d)) BinAdd(&r_bins, r, s);
    BinAdd(&s_bins, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + (Held(m, d) ? r : 0.), s + 2);
    BinAdd(&b_bins, PetscAbsReal(state->applied.start[d]) / length, s + 4);
  }
  PetscCall(PetscFree(momentum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, SUMS * nb + 2, MPIU_REAL, MPI_SUM, m->comm));
  // without the floor rounding would judge a body that carries next to nothing
  for (PetscInt b = 0; b < nb; b++) {
    const PetscReal *s = sum + SUMS * b;
    floor = PetscMax(floor, SCALE_FLOOR * PetscMax(s[2] + s[3], s[4] + s[5]));
  }
  result->ratio = 0.;
  result->worst_body = -1;
  for (PetscInt b = 0; b < nb; b++) {
    const PetscReal unbalanced = sum[SUMS * b] + sum[SUMS * b + 1],
                    scale = PetscMax(sum[SUMS * b + 2] + sum[SUMS * b + 3], floor);
    if (unbalanced <= 0.) continue;
    if (unbalanced / scale > result->ratio) result->ratio = unbalanced / scale, result->worst_body = b;
  }
  result->kinetic = sum[SUMS * nb] + sum[SUMS * nb + 1];
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

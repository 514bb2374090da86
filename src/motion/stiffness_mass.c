/* stiffness_mass.c: moves all degrees of freedom with a mass that is proportional to the elastic stiffness.

   K0 is the stiffness of all terms with joints that neither open nor slip. With M = scale K0 the central
   difference (11)-(20) is

     p = K0 v,   p+ = (p d1 + (f_ext - f - beta (f - f_old)) dt/scale) d2,   v+ = K0^-1 p+,   u+ = u + v+ dt,

   which costs one solve with the factor of K0 a cycle. Keeping p, no cycle multiplies by K0: the sums of the
   Rayleigh quotient (37) are v.(f - f_old) and scale v.p. Every elastic motion has the frequency
   1/sqrt(scale) whatever the mesh, and joints that slip or open only soften: no motion is faster. So the
   step is stable for the same scale on every mesh, and the slowest motion is the motion of the softest
   joints, not a wave through all blocks. */
#include "motion/motion.h"
#include "base/reproducible.h"

PetscErrorCode StiffnessMassBegin(Mat stiffness, PC factor, State *state)
{
  StiffnessMass *s;
  PetscFunctionBeginUser;
  PetscCall(StiffnessMassEnd(state));
  PetscCall(PetscNew(&s));
  s->stiffness = stiffness, s->factor = factor;
  PetscCall(VecDuplicate(state->velocity, &s->impulse));
  PetscCall(VecDuplicate(state->velocity, &s->from));
  PetscCall(VecDuplicate(state->velocity, &s->product));
  PetscCall(VecSet(s->impulse, 0.));
  state->stiffness_mass = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessMassEnd(State *state)
{
  StiffnessMass *s = state->stiffness_mass;
  PetscFunctionBeginUser;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&s->impulse));
  PetscCall(VecDestroy(&s->from));
  PetscCall(VecDestroy(&s->product));
  PetscCall(PetscFree(state->stiffness_mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Changes the impulse by the forces of the cycle, and adds the terms of (37), with the velocity that led
   here. */
static PetscErrorCode push(const Model *m, const State *state, const QuotientSums *last, QuotientSums *sums)
{
  const StiffnessMass *s = state->stiffness_mass;
  const PetscReal half = 0.5 * state->alpha * state->dt, d1 = 1. - half, d2 = 1. / (1. + half),
                  least = PETSC_MACHINE_EPSILON * PETSC_SMALL;
  const Bins num_bins = BinsFor(PetscMax(last->num_max * SUMS_GROWTH, least)),
             den_bins = BinsFor(PetscMax(last->den_max * SUMS_GROWTH, least));
  PetscReal *p;
  PetscFunctionBeginUser;
  PetscCall(VecGetArray(s->impulse, &p));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal df = state->f[d] - state->f_old[d], part = m->in_quotient ? m->in_quotient[d] : 1.,
                    num = part * state->v[d] * df, den = part * s->scale * state->v[d] * p[d];
    if (Held(m, d)) continue;
    BinAdd(&num_bins, num, sums->num);
    BinAdd(&den_bins, den, sums->den);
    sums->num_max = PetscMax(sums->num_max, PetscAbsReal(num));
    sums->den_max = PetscMax(sums->den_max, PetscAbsReal(den));
    const PetscReal r = state->f_ext[d] - state->f[d] - state->beta * df;
    p[d] = (p[d] * d1 + r * state->dt / s->scale) * d2;
  }
  PetscCall(VecRestoreArray(s->impulse, &p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessMassMove(const Model *m, State *state, const QuotientSums *last, QuotientSums *sums)
{
  const StiffnessMass *s = state->stiffness_mass;
  PetscFunctionBeginUser;
  PetscCall(push(m, state, last, sums));
  PetscCall(StateGive(state));
  PetscCall(PCApply(s->factor, s->impulse, state->velocity));
  PetscCall(StateTake(state));
  for (PetscInt d = 0; d < m->n_dof; d++) state->u[d] += state->v[d] * state->dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MassProduct(const Model *m, const State *state, const PetscReal *x, PetscReal *y)
{
  const StiffnessMass *s = state->stiffness_mass;
  PetscReal *from;
  const PetscReal *product;
  PetscFunctionBeginUser;
  if (!s) {
    for (PetscInt d = 0; d < m->n_dof; d++) y[d] = state->m[d] * x[d];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayWrite(s->from, &from));
  PetscCall(PetscArraycpy(from, x, m->n_dof));
  PetscCall(VecRestoreArrayWrite(s->from, &from));
  PetscCall(MatMult(s->stiffness, s->from, s->product));
  PetscCall(VecGetArrayRead(s->product, &product));
  for (PetscInt d = 0; d < m->n_dof; d++) y[d] = s->scale * product[d];
  PetscCall(VecRestoreArrayRead(s->product, &product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessMassKeepVelocity(const Model *m, State *state)
{
  StiffnessMass *s = state->stiffness_mass;
  PetscReal *p;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayWrite(s->impulse, &p));
  PetscCall(MassProduct(m, state, state->v, p));
  for (PetscInt d = 0; d < m->n_dof; d++) p[d] = Held(m, d) ? 0. : p[d] / s->scale;
  PetscCall(VecRestoreArrayWrite(s->impulse, &p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MotionStop(const Model *m, State *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(state->v, m->n_dof));
  if (state->stiffness_mass) PetscCall(VecSet(state->stiffness_mass->impulse, 0.));
  PetscFunctionReturn(PETSC_SUCCESS);
}

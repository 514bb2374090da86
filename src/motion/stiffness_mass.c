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
#include "base/lanes_sums.h"

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

/* State of the loop: constants of the step, and the sums of (37) lane by lane. */
typedef struct {
  PetscReal dt, d1, d2, beta, scale; /* d1, d2: (12), (13) */
  Bins num_bins, den_bins;
  Lanes num[2], den[2], num_max, den_max;
} Sweep;

/* Where degrees of freedom have their values. */
typedef struct {
  const PetscReal *f, *f_old, *f_ext, *v, *part; /* part: NULL when all enter the quotient */
  const int16_t *support;
  PetscReal *p;
} Places;

/* Changes the impulse of LANES degrees of freedom, and adds their terms of (37), with the velocity that led
   here. Those that a support holds keep their impulse and add nothing. */
KERNEL void PushLanes(Sweep *w, Places at)
{
  typedef int16_t Supports __attribute__((vector_size(LANES * sizeof(int16_t)), aligned(2)));
  const Mask moves = __builtin_convertvector(*(const Supports *)at.support < 0, Mask);
  const Lanes f = LoadLanes(at.f), df = f - LoadLanes(at.f_old), v = LoadLanes(at.v), p = LoadLanes(at.p);
  Lanes num = v * df, den = w->scale * v * p;
  if (at.part) num = LoadLanes(at.part) * v * df, den = LoadLanes(at.part) * w->scale * v * p;
  num = Keep(moves, num), den = Keep(moves, den);
  w->num_max = Larger(Absolute(num), w->num_max);
  w->den_max = Larger(Absolute(den), w->den_max);
  BinAddLanes(&w->num_bins, num, w->num);
  BinAddLanes(&w->den_bins, den, w->den);
  const Lanes r = LoadLanes(at.f_ext) - f - w->beta * df;
  StoreLanes(at.p, Select(moves, (p * w->d1 + r * w->dt / w->scale) * w->d2, p));
}

/* Does so for the last n < LANES degrees of freedom, in copies padded with held ones. */
static void push_rest(Sweep *w, Places at, PetscInt n)
{
  const PetscReal *const in[6] = {at.f, at.f_old, at.f_ext, at.v, at.part, at.p};
  PetscReal copy[6][LANES] = {{0.}};
  int16_t support[LANES] = {0};
  for (int i = 0; i < 6; i++)
    if (in[i]) memcpy(copy[i], in[i], n * sizeof(PetscReal));
  memcpy(support, at.support, n * sizeof(int16_t));
  PushLanes(w, (Places){copy[0], copy[1], copy[2], copy[3], at.part ? copy[4] : NULL, support, copy[5]});
  memcpy(at.p, copy[5], n * sizeof(PetscReal));
}

KERNEL void PushLoop_code(const Model *m, const State *state, PetscReal *p, Sweep *w)
{
  const State s = *state; // copies show the compiler that no store changes these pointers
  const PetscReal *part = m->in_quotient;
  const int16_t *support = m->support;
  Sweep sums = *w; // a copy stays in registers
  for (PetscInt d = 0; d < m->n_dof; d += LANES) {
    const PetscReal *of = part ? part + d : NULL;
    const Places at = {s.f + d, s.f_old + d, s.f_ext + d, s.v + d, of, support + d, p + d};
    if (d + LANES <= m->n_dof)
      PushLanes(&sums, at);
    else
      push_rest(&sums, at, m->n_dof - d);
  }
  *w = sums;
}

VARIANTS(PushLoop, (const Model *m, const State *state, PetscReal *p, Sweep *w), (m, state, p, w))

/* Changes the impulse by the forces of the cycle, and adds the terms of (37). */
static PetscErrorCode push(const Model *m, const State *state, const QuotientSums *last, QuotientSums *sums)
{
  const StiffnessMass *s = state->stiffness_mass;
  const PetscReal half = 0.5 * state->alpha * state->dt, least = PETSC_MACHINE_EPSILON * PETSC_SMALL;
  Sweep w = {.dt = state->dt,
             .d1 = 1. - half,
             .d2 = 1. / (1. + half),
             .beta = state->beta,
             .scale = s->scale,
             .num_bins = BinsFor(PetscMax(last->num_max * SUMS_GROWTH, least)),
             .den_bins = BinsFor(PetscMax(last->den_max * SUMS_GROWTH, least))};
  PetscReal *p;
  PetscFunctionBeginUser;
  PetscCall(VecGetArray(s->impulse, &p));
  PushLoop(m, state, p, &w);
  PetscCall(VecRestoreArray(s->impulse, &p));
  for (int lane = 0; lane < LANES; lane++) {
    for (int k = 0; k < 2; k++) sums->num[k] += w.num[k][lane], sums->den[k] += w.den[k][lane];
    sums->num_max = PetscMax(sums->num_max, w.num_max[lane]);
    sums->den_max = PetscMax(sums->den_max, w.den_max[lane]);
  }
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

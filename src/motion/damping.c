/* damping.c: finds the adaptive Rayleigh damping (35)-(38).

   The tangent quotient. With du = v dt the products k_tan du^2 of (37) are df.du, where df is the change of
   the RESISTING force over the step. So

   Q = sum(df.du) / sum(m du.du) = sum(v.(f - f_old)) / (dt sum(v.m v)), alpha = 2 sqrt(Q).

   This is the value of (35)-(37) without a division per dof, which would be 0/0 for dofs at rest. Applied
   loads are not in f, because their ramp must not look like stiffness. Q <= 0 occurs when contacts open; the
   last positive value then stays. alpha dt is capped at 1.9.

   The secant quotient. Where joints slip and open, a few sub-contacts that chatter raise the tangent quotient
   and overdamp the slow modes, 2 to 5 times. The secant over the stage,

   (u - u_0).(f - f_0) / (u - u_0).m (u - u_0),

   measures the motion that matters, so the smaller of the two quotients is taken. Once slip is kept from each
   evaluation (friction_mode.c), the secant counts from where the unbalanced ratio last halved or stalled,
   because the remaining motion is slower than the motion before. */
#include "motion/motion.h"
#include "base/reproducible.h"

static const PetscReal ALPHA_DT_MAX = 1.9;
enum { STALL_CYCLES = 2500, STALL_STIFFNESS = 500 }; /* the latter with stiffness_mass.c */

PetscErrorCode DampingCreate(const Model *m, Damping *damping)
{
  PetscFunctionBeginUser;
  PetscCall(DampingSumsCreate(m, &damping->over_ranks));
  PetscCall(PetscCalloc2(m->n_dof, &damping->u_secant, m->n_dof, &damping->f_secant));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingDestroy(Damping *damping)
{
  PetscFunctionBeginUser;
  PetscCall(DampingSumsDestroy(&damping->over_ranks));
  PetscCall(PetscFree2(damping->u_secant, damping->f_secant));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool is_adaptive(const Scene *scene)
{
  return (PetscBool)(scene->damping == DAMPING_ADAPTIVE || scene->damping == DAMPING_PAPER);
}

void DampingBegin(const Scene *scene, const Model *m, Damping *damping, const QuotientSums *local)
{
  if (is_adaptive(scene)) DampingSumsBegin(m, damping->over_ranks, local);
}

PetscErrorCode DampingEnd(const Scene *scene, const Model *m, State *state, Damping *damping)
{
  QuotientSums total;
  PetscFunctionBeginUser;
  if (scene->damping == DAMPING_FIXED) state->alpha = scene->alpha_dt / state->dt;
  if (!is_adaptive(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DampingSumsEnd(m, damping->over_ranks, &total));
  const PetscReal num = total.num[0] + total.num[1], den = total.den[0] + total.den[1];
  damping->fault = (PetscBool) !(PetscAbsReal(num) + den < PETSC_MAX_REAL);
  const PetscBool fits = (PetscBool)(total.num_max <= SUMS_GROWTH * damping->sums.num_max &&
                                     total.den_max <= SUMS_GROWTH * damping->sums.den_max);
  if (fits && num > 0. && den > 0.) damping->q_ray = num / (den * state->dt); // (37)
  const PetscReal q = damping->q_secant > 0. && scene->damping == DAMPING_ADAPTIVE
                          ? PetscMin(damping->q_ray, damping->q_secant)
                          : damping->q_ray;
  state->alpha = PetscMin(2. * PetscSqrtReal(q), ALPHA_DT_MAX / state->dt); // (38)
  damping->sums = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingStart(const Model *m, const State *state, Damping *damping)
{
  PetscFunctionBeginUser;
  damping->q_secant = 0.;
  damping->tangent_only = PETSC_FALSE;
  damping->best_ratio = PETSC_MAX_REAL;
  damping->best_cycle = state->cycle;
  PetscCall(PetscArraycpy(damping->u_secant, state->u, m->n_dof));
  PetscCall(PetscArraycpy(damping->f_secant, state->f, m->n_dof));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives up the secant for the rest of the stage when the unbalanced ratio has not fallen by a tenth over
   STALL_CYCLES: friction can feed an oscillation that the smaller damping of the secant does not stop.
   springs: slip is kept from each evaluation; then the secant stays, because springs feed no oscillation. */
static void guard_secant(const State *state, PetscReal ratio, PetscBool springs, Damping *damping)
{
  if (state->applied.ramp < 1. || ratio < 0.9 * damping->best_ratio)
    damping->best_ratio = ratio, damping->best_cycle = state->cycle;
  const PetscInt64 wait = state->stiffness_mass ? STALL_STIFFNESS : STALL_CYCLES;
  if (state->cycle - damping->best_cycle > wait && !springs) damping->tangent_only = PETSC_TRUE;
}

PetscErrorCode Secant(const Model *m, const State *state, PetscReal ratio, PetscBool springs,
                      Damping *damping)
{
  PetscReal top[2] = {0., 0.}, sum[4] = {0., 0., 0., 0.}, *way, *mass_way;
  PetscFunctionBeginUser;
  guard_secant(state, ratio, springs, damping);
  if (damping->tangent_only) {
    damping->q_secant = 0.;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2(m->n_dof, &way, m->n_dof, &mass_way));
  // f belongs to the displacements before the step of this cycle
  for (PetscInt d = 0; d < m->n_dof; d++)
    way[d] = state->u[d] - state->v[d] * state->dt - damping->u_secant[d];
  PetscCall(MassProduct(m, state, way, mass_way));
  for (int pass = 0; pass < 2; pass++) { // first the largest terms, then the binned sums
    const Bins num_bins = BinsFor(PetscMax(top[0], 1e-290)), den_bins = BinsFor(PetscMax(top[1], 1e-290));
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscReal num = way[d] * (state->f[d] - damping->f_secant[d]), den = mass_way[d] * way[d];
      if (Held(m, d) || (m->in_quotient && m->in_quotient[d] == 0.)) continue;
      if (pass) {
        BinAdd(&num_bins, num, sum);
        BinAdd(&den_bins, den, sum + 2);
      } else {
        top[0] = PetscMax(top[0], PetscAbsReal(num));
        top[1] = PetscMax(top[1], PetscAbsReal(den));
      }
    }
    if (pass)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 2, MPIU_REAL, MPI_MAX, m->comm));
  }
  PetscCall(PetscFree2(way, mass_way));
  const PetscReal num = sum[0] + sum[1], den = sum[2] + sum[3];
  damping->q_secant = num > 0. && den > 0. ? num / den : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

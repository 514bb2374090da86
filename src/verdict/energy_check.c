/* energy_check.c: checks that the kinetic energy of a static stage comes from its loads. Explicit cycles that
   make energy are unstable, and their outcome is no verdict.

   Whatever masses, damping and friction are, the kinetic energy K is at most the sum of the work W of the
   loads since the account was opened, and of the energy at that time: K_0 in motion and E_0 in blocks and
   joints,

     K <= W + K_0 + E_0,   W <= f_ext . (u - u_0) + R,   E_0 <= sum |f_0 u_0|.

   The forces f_0 include the reactions of supports. Until the ramp ends, W is taken as the larger of
   applied.start . (u - u_0) and f_ext . (u - u_0); R is their difference at its end. The bound of E_0 is the
   work of the forces f_0 at full size over u_0, about twice what is stored. The check allows twice the whole
   bound. Tendons store their prestress at no displacement. Only the part that they have given off since then
   is added to E_0, because prestress that stays moves nothing.

   An account is opened where the cycles of a stage start, where the stage restarts, and where the water in a
   crack changes. W is computed only when K has doubled since it was last in order, so a check costs next to
   nothing. */
#include "verdict/verdict.h"
#include "base/reproducible.h"

/* Collective. Sums f_ext.du, applied.start.du and |f_0 u_0| over all ranks into work [J], by binned terms. */
static PetscErrorCode sums_of_work(const Problem *p, PetscReal work[3])
{
  const Model *m = p->m;
  const State *s = p->state;
  const Relaxation *r = p->relax;
  PetscReal top = 1e-290, sum[6] = {0.};
  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) {
    const Bins bins = BinsFor(top);
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscReal du = s->u[d] - r->account.u[d],
                      term[3] = {s->f_ext[d] * du, s->applied.start[d] * du,
                                 PetscAbsReal(r->account.f[d] * r->account.u[d])};
      for (int i = 0; i < 3 && pass; i++) BinAdd(&bins, term[i], sum + 2 * i);
      for (int i = 0; i < 3 && !pass; i++) top = PetscMax(top, PetscAbsReal(term[i]));
    }
    if (!pass) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPIU_REAL, MPI_MAX, m->comm));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 6, MPIU_REAL, MPI_SUM, m->comm));
  for (int i = 0; i < 3; i++) work[i] = sum[2 * i] + sum[2 * i + 1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the bound of W since the account was opened, done [J], and there = E_0 + K_0 [J]. */
static PetscErrorCode energy_since(const Problem *p, PetscReal *done, PetscReal *there)
{
  const TermView view = ViewOf(p);
  PetscReal work[3], stored = 0.;
  PetscFunctionBeginUser;
  PetscCall(sums_of_work(p, work));
  PetscCall(TermsPrestressed(&view, &stored));
  *done = p->state->applied.ramp < 1. ? PetscMax(work[0], work[1]) : work[0] + p->relax->account.ramp;
  if (PushOf(p->state)) *done += PushOf(p->state)->work;
  *there = work[2] + p->relax->account.start + PetscMax(0., p->relax->account.stored - stored);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyCheckGoBack(const Problem *p)
{
  const TermView view = ViewOf(p);
  State *s = p->state;
  PetscFunctionBeginUser;
  PetscCall(MotionStop(p->m, s));
  PetscCall(TermsHistory(&view, GO_BACK));
  if (!ContactsVary(p->contacts, p->stage)) {
    PetscCall(PetscArraycpy(s->u, p->relax->account.u, p->m->n_dof));
    PetscCall(DisplacementsComplete(p->m, s->u));
    PetscCall(LoadsTarget(p->scene, p->m, p->stage, s));
  }
  LoadsApply(p->m, s, 0.);
  s->applied.ramp = 0.;
  p->result->kinetic = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restarts the stage where the account was opened, with shorter steps. */
static PetscErrorCode restart_stage(const Problem *p)
{
  State *s = p->state;
  PetscFunctionBeginUser;
  PetscCall(EnergyCheckGoBack(p));
  s->beta = RESTART_BETA, s->step_divisor = RESTART_STEP_DIVISOR;
  p->contacts->pull *= RESTART_PULL;
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, s));
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, s, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
PetscErrorCode EnergyCheckStart(const Problem *p)
{
  const TermView view = ViewOf(p);
  PetscFunctionBeginUser;
  PetscCall(TermsPrestressed(&view, &p->relax->account.stored));
  PetscCall(PetscArraycpy(p->relax->account.u, p->state->u, p->m->n_dof));
  PetscCall(PetscArraycpy(p->relax->account.f, p->state->f, p->m->n_dof));
  p->relax->account.start = p->relax->account.most = p->result->kinetic;
  p->relax->account.ramp = p->relax->account.lost = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyCheckRampEnds(const Problem *p)
{
  PetscReal work[3];
  PetscFunctionBeginUser;
  PetscCall(sums_of_work(p, work));
  p->relax->account.ramp = PetscMax(0., work[1] - work[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyCheck(const Problem *p, PetscBool *restarted)
{
  Relaxation *r = p->relax;
  StageResult *result = p->result;
  PetscReal done = 0., there = 0.;
  PetscFunctionBeginUser;
  *restarted = PETSC_FALSE;
  if (result->finite)
    r->account.lost += 2. * p->state->alpha * p->state->dt * result->kinetic * p->scene->check_every;
  if (!result->finite || !(result->kinetic > ENERGY_AGAIN * r->account.most))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(energy_since(p, &done, &there));
  const PetscReal most = PetscMax(0., done) + there;
  if (result->kinetic <= ENERGY_ALLOWED * most) {
    r->account.most = result->kinetic;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (r->account
          .made_energy++) { // the stage goes on, but EnergyCheckVerdict turns a collapse into a divergence
    r->account.most = result->kinetic;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (p->m->rank == 0) {
    Warn("stage %s, cycle %" PetscInt64_FMT ": kinetic energy %.3g J, where loads and stored "
         "energy account for %.3g J at most: restarted with half the step and more damping",
         p->stage->name, result->cycles, (double)result->kinetic, (double)most);
  }
  PetscCall(restart_stage(p));
  PetscCall(EnergyCheckStart(p));
  *restarted = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyLost(const Problem *p, PetscReal *part)
{
  PetscReal work[3];
  PetscFunctionBeginUser;
  PetscCall(sums_of_work(p, work));
  *part = p->relax->account.lost / PetscMax(work[0], PETSC_SMALL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a stress model of the scene has no potential. Such a model makes energy by itself where a
   contact opens, so a kinetic energy that is too large does not show that the cycles are unstable. */
static PetscBool may_make_energy(const Scene *scene)
{
  for (PetscInt j = 0; j < scene->n_joints; j++)
    if (scene->joints[j].stress_model >= STRESS_R2PT && scene->joints[j].stress_model < STRESS_TPTM)
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Warns that blocks have moved against the loads by energy that the stress models have made. */
static void warn_of_models(const Problem *p, PetscReal done, PetscReal there)
{
  StageResult *result = p->result;
  const size_t length = strlen(result->evidence);
  snprintf(
      result->evidence + length, sizeof(result->evidence) - length,
      "; blocks moved against the loads (work %.3g J, energy at the start %.3g J): a stress model without a "
      "potential made energy; use pt or tptm",
      (double)done, (double)there);
  if (p->m->rank) return;
  Warn("stage %s: collapsed by its stress model alone, which has no potential and made "
       "energy: blocks moved against the loads; use pt or tptm",
       p->stage->name);
}

PetscErrorCode EnergyCheckVerdict(const Problem *p)
{
  StageResult *result = p->result;
  PetscReal done = 0., there = 0.;
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_COLLAPSED) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(energy_since(p, &done, &there));
  // K + E <= W + K_0 + E_0: where the right side is negative, no energy was there for the motion
  const PetscBool against = (PetscBool)(done + there < 0.);
  if (may_make_energy(p->scene)) {
    if (against) warn_of_models(p, done, there);
  } else if (against || p->relax->account.made_energy >= 2) {
    result->verdict = VERDICT_DIVERGED;
    snprintf(
        result->evidence, sizeof(result->evidence),
        against
            ? "blocks moved against the loads (work %.3g J, energy at the start %.3g J): the cycles make "
              "energy; try relaxation.method: preconditioned"
            : "kinetic energy exceeds the work of the loads, %.3g J, and the energy at the start, %.3g J, "
              "also with half the step and more damping: the cycles make energy; try relaxation.method: "
              "preconditioned",
        (double)done, (double)there);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

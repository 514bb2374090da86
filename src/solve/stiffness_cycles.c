/* stiffness_cycles.c: gives the cycles of a static stage a mass that is proportional to the elastic stiffness
   (relaxation.method: stiffness_mass; motion/stiffness_mass.c). The factor is the one of Newton's method, so
   it serves all stages and trials with the same contacts and joint stiffnesses. */
#include "solve/newton.h"

/* Gives the cycles K0 and its factor, and momentum zero. Where there is no factor, warns, and the cycles keep
   their diagonal mass. */
static PetscErrorCode attach(const Problem *p)
{
  PetscBool works;
  PetscFunctionBeginUser;
  PetscCall(StiffnessMassEnd(p->state)); // NewtonFactor may destroy what it holds
  PetscCall(NewtonFactor(p, PETSC_TRUE, &works));
  if (!works) {
    if (!p->m->rank && !p->relax->effort.wanted)
      Warn("stage %s: the elastic stiffness has no factor, because it does not hold every body: the stage "
           "goes on by explicit cycles",
           p->stage->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Nested nested = p->relax->newton->nested;
  PetscCall(StiffnessMassBegin(NestedMatrix(nested), NestedSolver(nested), p->state));
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state)); // its scale
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stops all motion, and forgets the damping, which belongs to another mass. */
static PetscErrorCode forget_mass(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  p->state->alpha = p->relax->damping.q_ray = 0.;
  p->relax->evidence.settled_alpha = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesBegin(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(attach(p));
  if (!p->state->stiffness_mass) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(forget_mass(p));
  p->relax->effort.stiffness_mass = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesGoOn(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(StiffnessCyclesBegin(p));
  p->relax->effort.choice.crept = p->state->stiffness_mass ? p->result->cycles : -1;
  if (!p->state->stiffness_mass) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DampingStart(p->m, p->state, &p->relax->damping));
  PetscCall(RelaxationReset(p));
  PetscCall(CheckpointNow(p->checkpoint, p->state->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets explicit cycles go on from the present displacements, at rest. */
static PetscErrorCode go_on_explicitly(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(forget_mass(p));
  p->relax->effort.explicit = PETSC_TRUE;
  PetscCall(DampingStart(p->m, p->state, &p->relax->damping));
  PetscCall(RelaxationReset(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesLeave(const Problem *p)
{
  PetscFunctionBeginUser;
  p->relax->effort.choice.stalled = p->result->cycles;
  PetscCall(StiffnessMassEnd(p->state));
  FrictionModeRestart(p->relax, p->contacts);
  p->relax->follow.half_ratio = PETSC_MAX_REAL, p->relax->follow.half_cycle = p->state->cycle;
  PetscCall(go_on_explicitly(p));
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state));
  PetscCall(CheckpointNow(p->checkpoint, p->state->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesEnd(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(StiffnessMassEnd(p->state));
  PetscCall(forget_mass(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether blocks have jumped since the account was opened: whether they have moved JUMP_FAR times as
   far as all loads would move the model with elastic joints, or JUMP_TIMES as far and damping took JUMP_LOST
   of the work. */
static PetscErrorCode has_jumped(const Problem *p, PetscBool *jumped)
{
  const Model *m = p->m;
  const State *state = p->state;
  const StiffnessMass *mass = state->stiffness_mass;
  PetscReal most[2] = {0., 0.}, lost, *load;
  const PetscReal *elastic;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayWrite(mass->from, &load));
  for (PetscInt d = 0; d < m->n_dof; d++) load[d] = Held(m, d) ? 0. : state->f_ext[d];
  PetscCall(VecRestoreArrayWrite(mass->from, &load));
  PetscCall(PCApply(mass->factor, mass->from, mass->product));
  p->relax->effort.solves++;
  PetscCall(VecGetArrayRead(mass->product, &elastic));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d);
    most[0] = PetscMax(most[0], PetscAbsReal(state->u[d] - p->relax->account.u[d]) * length);
    most[1] = PetscMax(most[1], PetscAbsReal(elastic[d]) * length);
  }
  PetscCall(VecRestoreArrayRead(mass->product, &elastic));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPI_MAX, m->comm));
  *jumped = (PetscBool)(most[0] > JUMP_FAR * most[1]);
  if (*jumped || most[0] <= JUMP_TIMES * most[1]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EnergyLost(p, &lost));
  *jumped = (PetscBool)(lost > JUMP_LOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the cycles are unstable: a number is not finite, they make energy, or a body has left the
   place of the whole model before a collapse was seen. Elastic stiffness bounds no body that turns by a
   radian a cycle, as stones of soft joints do in large strain. */
static PetscBool diverge(const Problem *p)
{
  const StageResult *result = p->result;
  const PetscBool gone = (PetscBool)(result->displacement > p->m->mesh.diameter);
  return (PetscBool)(result->verdict == VERDICT_DIVERGED || p->relax->account.made_energy > 1 ||
                     (result->verdict == VERDICT_COLLAPSED && gone));
}

/* Returns whether the cycles have had their time without a verdict: MOST_STIFFNESS_CYCLES after the ramp, in
   a trial MOST_TRIAL_CYCLES; where they went on with explicit cycles, about as long as those took. */
static PetscBool endless(const Problem *p)
{
  const MethodChoice *c = &p->relax->effort.choice;
  const PetscInt64 crept = c->crept, cycles = p->result->cycles,
                   most = p->stage->kind == STAGE_STATIC ? MOST_STIFFNESS_CYCLES : MOST_TRIAL_CYCLES;
  if (p->result->verdict == VERDICT_UNDECIDED) return PETSC_TRUE;
  if (p->result->verdict != VERDICT_NONE || p->state->applied.ramp < 1.) return PETSC_FALSE;
  if (c->stalled) return (PetscBool)(cycles > crept + MOST_STIFFNESS_CYCLES);
  return (PetscBool)(crept > 0 ? cycles > crept + crept / STIFFNESS_CYCLE : cycles > p->stage->ramp + most);
}

/* Notes why explicit cycles do the stage or trial again, and warns at the first time in a stage. */
static void note_failure(const Problem *p, LeftFor reason)
{
  static const char *const REASONS[] = {"found no equilibrium", "let blocks jump", "diverged"};
  PetscInt64 *left = p->relax->effort.choice.left, before = 0;
  for (int i = 0; i < LEFT_REASONS; i++) before += left[i];
  left[reason]++;
  if (p->m->rank || before || p->scene->method == METHOD_AUTO) return;
  Warn("stage %s: cycles of stiffness_mass have %s: explicit cycles begin again", p->stage->name,
       REASONS[reason]);
}

/* Adds to the evidence of a divergence what a user may try: the stage cannot go back. */
static void name_explicit(StageResult *result)
{
  const size_t n = strlen(result->evidence);
  snprintf(result->evidence + n, sizeof(result->evidence) - n, "; try relaxation.method: explicit");
}

PetscErrorCode StiffnessCyclesFail(const Problem *p, PetscBool *fail)
{
  const Verdict verdict = p->result->verdict;
  PetscBool jumped = PETSC_FALSE;
  PetscFunctionBeginUser;
  *fail = PETSC_FALSE;
  if (!p->state->stiffness_mass) PetscFunctionReturn(PETSC_SUCCESS);
  if (ContactsVary(p->contacts, p->stage)) {
    if (verdict == VERDICT_DIVERGED) name_explicit(p->result);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (verdict == VERDICT_CONVERGED) PetscCall(has_jumped(p, &jumped));
  *fail = (PetscBool)(diverge(p) || jumped || endless(p));
  if (*fail) note_failure(p, diverge(p) ? LEFT_DIVERGED : jumped ? LEFT_JUMPED : LEFT_ENDLESS);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesRenew(const Problem *p)
{
  State *state = p->state;
  PetscFunctionBeginUser;
  if (!state->stiffness_mass) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(attach(p));
  if (state->stiffness_mass)
    PetscCall(StiffnessMassKeepVelocity(p->m, state));
  else
    PetscCall(go_on_explicitly(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesArchive(Archive *a, const Problem *p)
{
  State *state = p->state;
  PetscInt64 at_work = state->stiffness_mass != NULL;
  PetscReal *impulse;
  PetscFunctionBeginUser;
  PetscCall(ArchiveCounts(a, "stiffness_mass", 1, &at_work));
  if (!at_work) PetscFunctionReturn(PETSC_SUCCESS);
  if (a->reading) PetscCall(attach(p));
  StiffnessMass *mass = state->stiffness_mass;
  if (!mass) {
    PetscCall(go_on_explicitly(p));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArray(mass->impulse, &impulse));
  PetscCall(ArchiveDofs(a, p->m, "impulse", impulse));
  PetscCall(VecRestoreArray(mass->impulse, &impulse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

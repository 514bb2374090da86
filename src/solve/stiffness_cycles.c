/* stiffness_cycles.c: gives the cycles of a static stage a mass that is proportional to the elastic stiffness
   (relaxation.method: stiffness_mass; motion/stiffness_mass.c). The factor is the one of Newton's method, so
   it serves all stages and trials with the same contacts and joint stiffnesses. */
#include "solve/newton.h"

/* Gives the cycles K0 and its factor, and momentum zero. Where there is no factor, warns, and the cycles keep
   their diagonal mass. */
static PetscErrorCode attach(const Problem *p)
{
  PC factor;
  PetscBool works;
  PetscFunctionBeginUser;
  PetscCall(StiffnessMassEnd(p->state)); // NewtonFactor may destroy what it holds
  PetscCall(NewtonFactor(p, &works));
  if (!works) {
    if (!p->m->rank && !p->relax->effort.wanted)
      Warn("stage %s: the elastic stiffness has no factor, because it does not hold every body: the stage "
           "goes "
           "on by explicit cycles",
           p->stage->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(AssembleElastic(p)); // Newton's method may have left another tangent
  PetscCall(FactorOnEachRank(p, &factor));
  PetscCall(StiffnessMassBegin(p->relax->newton->stiffness.tangent, factor, p->state));
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state)); // its scale
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCyclesBegin(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  PetscCall(attach(p));
  if (!p->state->stiffness_mass) PetscFunctionReturn(PETSC_SUCCESS);
  p->state->alpha = p->relax->damping.q_ray = 0.; // of another mass, as the next one
  p->relax->evidence.settled_alpha = 0.;
  p->relax->effort.stiffness_mass = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets explicit cycles go on from the present displacements, at rest. */
static PetscErrorCode go_on_explicitly(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  p->state->alpha = p->relax->damping.q_ray = 0.;
  p->relax->evidence.settled_alpha = 0.;
  p->relax->effort.explicit = PETSC_TRUE;
  PetscCall(DampingStart(p->m, p->state, &p->relax->damping));
  PetscCall(RelaxationReset(p));
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

/* stages.c: what runs a stage of each kind. */
#include "stages/stages.h"

PetscErrorCode StageRun(const Problem *p)
{
  static PetscErrorCode (*const runners[])(const Problem *) = {
      [STAGE_STATIC] = StageRelax, [STAGE_STRENGTH_REDUCTION] = ReductionRun, [STAGE_FLOOD] = FloodRun};
  Effort *effort = &p->relax->effort;
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  p->contacts->rate = 0.; // not in time: joints have no dashpots
  PetscCall(PetscMemzero(effort, sizeof(*effort)));
  p->relax->told = PETSC_FALSE;
  PetscCall(runners[p->stage->kind](p));
  if (p->stage->kind == STAGE_STATIC && result->verdict == VERDICT_COLLAPSED)
    PetscCall(MechanismTake(p, NULL));
  result->effort = *effort;
  if (effort->wanted) {
    char more[128];
    PetscCall(PetscSNPrintf(more, sizeof(more),
                            "; no memory for the factor: it takes about %.3g GB, %.3g GB were available",
                            1e-9 * (double)effort->wanted, 1e-9 * (double)effort->available));
    PetscCall(PetscStrlcat(result->evidence, more, sizeof(result->evidence)));
  }
  PetscCall(CondensedRecover(p->m, p->state));
  PetscCall(StageReport(p));
  if (!p->stage->variable) PetscCall(FixedOutgrown(p));
  if (result->verdict == VERDICT_CONVERGED)
    PetscCall(CondensedCheckRotation(p->scene, p->m, p->stage, p->state));
  if (result->verdict == VERDICT_CONVERGED) PetscCall(ConfirmCondensed(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

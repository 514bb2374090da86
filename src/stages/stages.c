/* stages.c: runs a stage of any kind, and reports every stage that has ended. */
#include "stages/stages.h"

/* Runs a stage of each kind; StageMotionOf says what the kind does. */
static PetscErrorCode (*const run_kind[])(const Problem *p) = {[STAGE_STATIC] = StageRelax,
                                                               [STAGE_DYNAMIC] = DynamicRun,
                                                               [STAGE_STRENGTH_REDUCTION] = ReductionRun,
                                                               [STAGE_FLOOD] = RaiseRun,
                                                               [STAGE_TRANSIENT] = TransientRun,
                                                               [STAGE_LOAD_FACTOR] = RaiseRun,
                                                               [STAGE_ANCHOR_FORCE] = AnchorForceRun,
                                                               [STAGE_MODES] = ModesRun,
                                                               [STAGE_PUSHOVER] = PushoverRun};

/* Adds to the evidence of a stage that contacts were found again in it, and which body has moved most, where
   the evidence names none. */
static PetscErrorCode report_outgrown(const Problem *p)
{
  StageResult *result = p->result;
  const PetscReal *at = result->effort.outgrown;
  char more[192];
  PetscFunctionBeginUser;
  if (!strstr(result->evidence, "macroblock")) PetscCall(FarthestBodyAdd(p));
  PetscCall(PetscSNPrintf(more, sizeof(more),
                          "; contact.connectivity auto found contacts again, as one at x = %.4g m, y = %.4g "
                          "m had moved by %.3g of its length",
                          (double)at[0], (double)at[1], (double)at[2]));
  PetscCall(PetscStrlcat(result->evidence, more, sizeof(result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a stage that relaxes, with the parts common to all such stages: effort, mechanism, the inside of
   condensed bodies. */
static PetscErrorCode run_relaxing(const Problem *p)
{
  Effort *effort = &p->relax->effort;
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  p->contacts->rate = 0.; // joints have dashpots in time only
  PetscCall(PetscMemzero(effort, sizeof(*effort)));
  p->relax->path_warned = PETSC_FALSE;
  PetscCall(run_kind[p->stage->kind](p));
  if (p->m->condensed.large && p->stage->kind == STAGE_STATIC && result->verdict != VERDICT_CONVERGED &&
      result->verdict != VERDICT_INTERRUPTED)
    p->m->condensed.leave = "a stage does not stand";
  if (p->m->condensed.leave) PetscFunctionReturn(PETSC_SUCCESS);
  if ((p->stage->kind == STAGE_STATIC || p->stage->kind == STAGE_TRANSIENT ||
       p->stage->kind == STAGE_PUSHOVER) &&
      result->verdict == VERDICT_COLLAPSED)
    PetscCall(MechanismTake(p, NULL));
  result->effort = *effort;
  if (effort->outgrown[2] > 0.) PetscCall(report_outgrown(p));
  if (effort->wanted) {
    char more[128];
    PetscCall(PetscSNPrintf(more, sizeof(more),
                            "; no memory for the factor: it takes about %.3g GB, %.3g GB were available",
                            1e-9 * (double)effort->wanted, 1e-9 * (double)effort->available));
    PetscCall(PetscStrlcat(result->evidence, more, sizeof(result->evidence)));
  }
  if (!p->found->joints_only) PetscCall(CondensedRecover(p->m, p->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a stage, or warns, where condensed bodies have moved farther than their assumptions allow. Where
   neither the inside nor the warning is needed, the inside is found only if the refusal is possible. */
static PetscErrorCode check_condensed(const Problem *p)
{
  PetscBool turned = PETSC_TRUE;
  PetscFunctionBeginUser;
  if (p->m->condensed.large) PetscFunctionReturn(PETSC_SUCCESS);
  if (p->found->joints_only) {
    PetscCall(CondensedMayTurn(p->scene, p->m, p->state, &turned));
    if (turned) PetscCall(CondensedRecover(p->m, p->state));
  }
  if (turned) PetscCall(CondensedCheckRotation(p->scene, p->m, p->stage, p->state));
  if (!p->found->joints_only) PetscCall(CheckCondensedRotation(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StageRun(const Problem *p)
{
  const PetscBool in_time = StageInTime(p->stage), relaxes = StageRelaxes(p->stage);
  PetscFunctionBeginUser;
  PetscCall(LiftsPlace(p));
  PetscCall(relaxes ? run_relaxing(p) : run_kind[p->stage->kind](p));
  if (p->m->condensed.leave) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscBool vary = ContactsVary(p->contacts, p->stage);
  if (in_time) *(vary ? &p->result->effort.variable : &p->result->effort.fixed) = PETSC_TRUE;
  PetscCall(StageReport(p));
  if (!relaxes && !in_time) PetscFunctionReturn(PETSC_SUCCESS);
  if (!vary) PetscCall(FixedConnectivityWarn(p));
  if (p->stage->connectivity == CONNECTIVITY_AUTO)
    p->contacts->outgrown = PETSC_FALSE; // the next stage keeps the contacts that it finds
  if (in_time)
    p->contacts->counted = PETSC_FALSE; // travel of contacts counts from the end of a motion in time
  if (p->result->verdict == VERDICT_CONVERGED) PetscCall(check_condensed(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* static.c: a static stage, or a trial of one: relaxation to a verdict. */
#include "stages/stages.h"
#include <unistd.h>

/* Of explicit cycles: where they are and about how long they still take, from the decay of the ratio since
   they started. */
static void progress(const Problem *p, PetscReal first_ratio, double first_wall)
{
  const StageResult *now = p->result;
  char text[128], rest[32] = "";
  if (!StageShows(p)) return;
  const double decay = log(first_ratio / PetscMax(now->ratio, 1e-300)),
               left = log(now->ratio / p->stage->tolerance);
  if (decay > 0.5 && left > 0.)
    snprintf(rest, sizeof(rest), "  about %.0f s left", (now->wall - first_wall) / decay * left);
  snprintf(text, sizeof(text), "cycle %8" PetscInt64_FMT "  ratio %9.2e  alpha %7.1e%s", now->cycles,
           (double)now->ratio, (double)p->state->alpha, rest);
  StageShow(p, text);
}

/* Variable connectivity: contacts found again when blocks have moved enough (or when `now`), and
   masses to go with them. */
static PetscErrorCode verify(const Problem *p, PetscBool now)
{
  const Joint *joints = p->stage->joints;
  PetscBool need = now;
  PetscFunctionBeginUser;
  if (!now) PetscCall(ContactsNeedVerify(p->scene, p->m, p->state, &need, NULL));
  if (!need) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Forces(p->m, joints, p->contacts, p->state, NULL));
  PetscCall(CondensedRecover(p->m, p->state)); // a contact may come anywhere
  PetscCall(ContactsVerify(p->scene, joints, p->m, p->state, p->contacts, p->result));
  PetscCall(CondensedCheckContacts(p->scene, p->m, p->contacts));
  PetscCall(ScaledMasses(p->scene, p->m, joints, p->contacts, p->state));
  if (!now) PetscCall(JudgeLoose(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At equilibrium, and after each chunk of cycles without one, the open length of a cracked base is measured;
   when it has changed, the new pressure is ramped up and the stage goes on. */
static PetscErrorCode follow_cracks(const Problem *p, PetscInt64 *ramp_start)
{
  State *state = p->state;
  StageResult *result = p->result;
  const PetscBool chunk_ended = (PetscBool)(result->verdict == VERDICT_NONE && state->ramp >= 1. &&
                                            p->relax->evidence.chunk_start == state->cycle);
  PetscBool again;
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_CONVERGED && !chunk_ended) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(UpliftCrack(p->scene, p->stage, p->m, p->contacts, state, result, &again));
  if (!again) PetscFunctionReturn(PETSC_SUCCESS);
  if (result->verdict == VERDICT_CONVERGED && p->contacts->held) ContactsHold(p->contacts);
  PetscCall(PetscArraycpy(state->f_start, state->f_ext, ModelApplied(p->m)));
  PetscCall(LoadsTarget(p->scene, p->m, p->stage, state));
  PetscCall(EnergyAccountOpen(p));
  result->verdict = VERDICT_NONE;
  state->ramp = 0.;
  *ramp_start = result->cycles;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method, again when a crack has grown; verdict none: the explicit loop goes on from where it is. */
static PetscErrorCode precondition(const Problem *p)
{
  PetscInt64 ramp_start;
  PetscBool again = PETSC_TRUE;
  PetscFunctionBeginUser;
  while (again && p->result->verdict == VERDICT_NONE) {
    PetscCall(NewtonRelax(p));
    again = (PetscBool)(p->result->verdict == VERDICT_CONVERGED);
    if (again) PetscCall(follow_cracks(p, &ramp_start));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the loop of cycles remembers, see archive.h. */
typedef struct {
  const Problem *p;
  PetscReal *contact_scale; /* (n_dof,) |contact force| at the last check */
  PetscInt64 ramp_start;    /* cycle of the stage at which the ramp began */
  double start;             /* [s] of MPI_Wtime */
} Loop;

static PetscErrorCode archive_loop(Archive *a, void *context)
{
  Loop *loop = context;
  const Problem *p = loop->p;
  PetscFunctionBeginUser;
  p->result->wall = MPI_Wtime() - loop->start;
  if (a->anew) {
    PetscCall(PetscFree(loop->contact_scale));
    PetscCall(PetscCalloc1(p->m->n_dof, &loop->contact_scale));
  }
  PetscCall(ArchiveResult(a, "result", p->result));
  PetscCall(ArchiveEffort(a, &p->relax->effort));
  PetscCall(ArchiveCounts(a, "ramp_start", 1, &loop->ramp_start));
  if (!a->anew) loop->start = MPI_Wtime() - p->result->wall;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a joint can slip: only then can friction feed an oscillation. */
static PetscErrorCode can_slip(const Problem *p, PetscBool *slips)
{
  const Contacts *c = p->contacts;
  PetscBool mine = p->stage->variable; // contacts of any joint may come
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded && !mine; i++)
    mine = (PetscBool)(p->stage->joints[c->joint[i]].law != LAW_ELASTIC);
  PetscCallMPI(MPI_Allreduce(&mine, slips, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Loads, contacts and masses at the start of a stage, or of a trial of one. */
static PetscErrorCode begin(const Problem *p)
{
  const Scene *scene = p->scene;
  State *state = p->state;
  PetscBool slips;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(state->f_start, state->f_ext, ModelApplied(p->m)));
  PetscCall(UpliftStart(scene, p->stage, state));
  PetscCall(LoadsTarget(scene, p->m, p->stage, state));
  // velocities in time mean nothing here
  if (state->time > 0.) PetscCall(PetscArrayzero(state->v, p->m->n_dof));
  if (p->stage->variable) PetscCall(verify(p, PETSC_TRUE));
  PetscCall(can_slip(p, &slips));
  state->beta = scene->damping == DAMPING_ADAPTIVE && slips ? scene->beta : 0.;
  ContactsHold(p->contacts);
  p->contacts->springs = PETSC_FALSE;
  PetscCall(Forces(p->m, p->stage->joints, p->contacts, state, NULL));
  ContactsGoBack(p->contacts);
  PartingStart(p);
  PetscCall(ScaledMasses(scene, p->m, p->stage->joints, p->contacts, state));
  PetscCall(RelaxationReset(p)); // a mechanism before the ramp ends is counted from here
  PetscCall(RelaxationStart(p->m, p->contacts, state, p->relax));
  PetscCall(EnergyAccountOpen(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Up to the verdict or to the first cycle of the explicit loop. */
static PetscErrorCode before_cycles(const Problem *p, PetscInt64 *ramp_start)
{
  State *state = p->state;
  MethodKind method;
  PetscFunctionBeginUser;
  PetscCall(StageMethod(p->scene, p->m, p->contacts, p->stage, &method));
  if (method == METHOD_PRECONDITIONED) PetscCall(precondition(p));
  if (p->result->verdict == VERDICT_NONE) {
    p->relax->effort.explicit = PETSC_TRUE;
    PetscCall(PetscArraycpy(state->f_start, state->f_ext, ModelApplied(p->m)));
    *ramp_start = p->result->cycles;
    state->ramp = 0.;
    // what the first change of forces is counted from
    PetscCall(Forces(p->m, p->stage->joints, p->contacts, state, NULL));
    if (p->scene->damping != DAMPING_ADAPTIVE) p->contacts->held = PETSC_FALSE; // as in the paper
    p->contacts->pull = p->contacts->held ? FOLLOW_CLOSELY : 0.;
    PetscCall(RelaxationStart(p->m, p->contacts, state, p->relax));
    PetscCall(EnergyAccountOpen(p));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StageRelax(const Problem *p)
{
  const Scene *scene = p->scene;
  const Stage *stage = p->stage;
  Model *m = p->m;
  Contacts *contacts = p->contacts;
  State *state = p->state;
  Relaxation *relax = p->relax;
  StageResult *result = p->result;
  PetscReal first_ratio = 0.;
  double first_wall = 0.;
  Loop loop = {p, NULL, 0, MPI_Wtime()};
  PetscBool resumed, anew;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(result, sizeof(*result)));
  PetscCall(PetscCalloc1(m->n_dof, &loop.contact_scale));
  PetscCall(CheckpointAttach(p->output->checkpoint, "stage", archive_loop, &loop, &resumed));
  if (!resumed) PetscCall(begin(p));
  if (!resumed || relax->step > 0.) PetscCall(before_cycles(p, &loop.ramp_start)); // else it was in the loop
  while (result->verdict == VERDICT_NONE) {
    const PetscBool check = (PetscBool)((result->cycles + 1) % scene->check_every == 0);
    if (state->ramp < 1.) {
      LoadsApply(m, state,
                 stage->ramp ? PetscMin(1., (PetscReal)(result->cycles + 1 - loop.ramp_start) / stage->ramp)
                             : 1.);
      if (state->ramp >= 1.) { // evidence counts from here on
        PetscCall(RelaxationReset(p));
        PetscCall(EnergyRampEnds(p));
      }
    }
    PetscCall(
        Step(scene, m, stage->joints, contacts, state, &relax->damping, check ? loop.contact_scale : NULL));
    result->cycles++, relax->effort.evaluations++;
    if (!check && !relax->damping.fault) continue;
    PetscCall(Unbalanced(m, state, loop.contact_scale, result));
    PetscCall(EnergyGuard(p, &anew));
    if (anew) loop.ramp_start = result->cycles;
    if (anew) continue;
    PetscCall(Secant(m, state, result->ratio, (PetscBool)(relax->follow.stalls >= STALLS_TO_LET_GO),
                     &relax->damping));
    result->wall = MPI_Wtime() - loop.start;
    PetscCall(Judge(p));
    PetscCall(ConfirmByLaw(p, loop.contact_scale));
    FollowElse(m, state, result->ratio, relax, contacts);
    if (relax->evidence.still) PetscCall(RelaxationStill(p));
    if (!stage->variable && result->finite) PetscCall(JudgeContacts(p));
    PetscCall(EnergyVeto(p));
    PartingOfBearing(contacts);
    PetscCall(follow_cracks(p, &loop.ramp_start));
    if (result->cycles % scene->history_every < scene->check_every || result->verdict != VERDICT_NONE)
      PetscCall(OutputHistory(p));
    if (state->ramp >= 1. && first_ratio == 0.) first_ratio = result->ratio, first_wall = result->wall;
    progress(p, first_ratio, first_wall);
    if (stage->variable && result->verdict == VERDICT_NONE) PetscCall(verify(p, PETSC_FALSE));
    PetscCall(LoadsRenew(p->scene, p->m, p->stage, p->state));
    PetscCall(RepartitionPoll(p));
    PetscCall(CheckpointPoll(p->output->checkpoint, state->cycle, result));
  }
  PetscCall(CheckpointDetach(p->output->checkpoint));
  if (result->verdict == VERDICT_CONVERGED && relax->effort.explicit && !contacts->held)
    PetscCall(ConfirmPath(p, loop.contact_scale));
  contacts->pull = 0.;
  // what is written belongs to the last displacements: forces, stresses and joint states once more
  PetscCall(Forces(m, stage->joints, contacts, state, NULL));
  if (result->verdict == VERDICT_CONVERGED) PetscCall(ConfirmWay(p));
  PetscCall(LoadsCarriedSay(p));
  contacts->held = PETSC_FALSE;
  state->beta = state->local = 0., state->caution = 1.;
  relax->effort.evaluations++;
  result->wall = MPI_Wtime() - loop.start;
  PetscCall(PetscFree(loop.contact_scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

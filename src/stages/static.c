/* static.c: relaxes a static stage, or a trial, to a verdict. */
#include "stages/loop.h"

/* Prints a line of progress of explicit cycles. The remaining time is estimated from the decay of the ratio
   since the first check after the ramp. */
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

/* Finds, with variable connectivity, contacts and their masses again, when blocks have moved enough or when
   `now` is set. */
static PetscErrorCode verify(const Problem *p, PetscBool now)
{
  const Joint *joints = p->stage->joints;
  PetscBool need = now;
  PetscFunctionBeginUser;
  if (!now) PetscCall(ContactsNeedVerify(p->m, p->state, &need, NULL));
  if (!need) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Forces(p->scene, p->m, joints, p->contacts, p->state, NULL));
  PetscCall(CondensedRecover(p->m, p->state)); // a contact may come at inner vertices too
  PetscCall(ContactsVerify(p->scene, joints, p->m, p->state, p->contacts, p->result));
  PetscCall(CondensedCheckContacts(p->scene, p->m, p->contacts));
  PetscCall(ScaledMasses(p->scene, p->m, joints, p->contacts, p->state));
  PetscCall(StiffnessCyclesRenew(p));
  if (!now) PetscCall(JudgeLoose(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Starts the ramp to the loads of another round. Where every force changes by less than a tenth of the
   largest, the ramp starts nearer to its end: such a small jump shakes nothing. */
static PetscErrorCode start_ramp(const Problem *p, PetscInt64 *ramp_start)
{
  const Applied *applied = &p->state->applied;
  const PetscReal small = 0.1;
  PetscReal most[2] = {0., 0.};
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < p->m->n_dof; d++) {
    const PetscReal arm = DofLength(p->m, p->state, d);
    most[0] = PetscMax(most[0], PetscAbsReal(applied->target[d] - applied->start[d]) / arm);
    most[1] = PetscMax(most[1], PetscAbsReal(applied->target[d]) / arm);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPI_MAX, p->m->comm));
  const PetscReal part = most[0] < small * most[1] ? most[0] / (small * most[1]) : 1.;
  *ramp_start = p->result->cycles - (PetscInt64)((1. - part) * (PetscReal)p->stage->ramp);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates what depends on openings: cracks and water. When this has changed a load, the stage ramps to the
   new load. */
static PetscErrorCode follow_openings(const Problem *p, PetscInt64 *ramp_start)
{
  State *state = p->state;
  StageResult *result = p->result;
  const PetscBool rests = (PetscBool)(result->verdict == VERDICT_CONVERGED);
  const TermView view = ViewOf(p);
  PetscBool again, commit, corrected = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (!rests && (result->verdict != VERDICT_NONE || state->applied.ramp < 1.))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TermsSettle(&view, rests ? AT_EQUILIBRIUM : AT_CHECK, result, &again, &commit));
  if (rests && result->verdict == VERDICT_CONVERGED)
    PetscCall(CondensedCorrect(p->m, state, p->stage->tolerance, &corrected));
  again = (PetscBool)(again || corrected);
  if (p->m->condensed.leave) result->verdict = VERDICT_INTERRUPTED;
  if (!again || p->m->condensed.leave) PetscFunctionReturn(PETSC_SUCCESS);
  if (commit && rests && ContactsFromCommitted(p->contacts)) PetscCall(TermsHistory(&view, COMMIT));
  PetscCall(LoadsFromNow(p->m, state));
  PetscCall(LoadsTarget(p->scene, p->m, p->stage, state));
  if (commit || corrected)
    PetscCall(DampingStart(p->m, state, &p->relax->damping)); // its secant belongs to the next motion
  if (!commit) PetscCall(CheckRound(p));
  PetscCall(EnergyCheckStart(p));
  FrictionModeRestart(p->relax, p->contacts);
  result->verdict = VERDICT_NONE;
  state->applied.ramp = 0.;
  PetscCall(start_ramp(p, ramp_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs Newton's method, and again each time a crack has grown. When it finds no verdict, the explicit loop
   continues from there. */
static PetscErrorCode precondition(const Problem *p)
{
  PetscInt64 ramp_start;
  PetscBool again = PETSC_TRUE;
  PetscFunctionBeginUser;
  while (again && p->result->verdict == VERDICT_NONE) {
    PetscCall(NewtonRelax(p));
    again = (PetscBool)(p->result->verdict == VERDICT_CONVERGED);
    if (again) PetscCall(follow_openings(p, &ramp_start));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Memory of the loop in a static stage. */
typedef struct {
  PetscReal *contact_scale; /* (n_dof,) |contact force| at the last check */
  PetscInt64 ramp_start;    /* cycle of the stage at which the ramp starts */
  PetscInt64 hurries;       /* cycles of the ramp that a cycle counts for, beside itself */
  PetscReal first_ratio;    /* [-] ratio at the first check after the ramp, 0: none so far; for progress
                               only */
  double first_wall;        /* [s] wall time of that check */
} Static;

static PetscErrorCode archive(Archive *a, Loop *loop)
{
  Static *s = loop->memory;
  PetscFunctionBeginUser;
  PetscCall(ArchiveEffort(a, &loop->p->relax->effort));
  PetscCall(ArchiveCounts(a, "ramp_start", 1, &s->ramp_start));
  PetscCall(ArchiveCounts(a, "hurries", 1, &s->hurries));
  PetscCall(StiffnessCyclesArchive(a, loop->p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether a joint can slip. Only then can friction feed an oscillation, which beta damps. */
static PetscErrorCode can_slip(const Problem *p, PetscBool *slips)
{
  const Contacts *c = p->contacts;
  PetscBool mine = ContactsVary(p->contacts,
                                p->stage); // with variable connectivity contacts of any joint may come
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded && !mine; i++)
    mine = (PetscBool)(c->key[2 * i] >= 0 && p->stage->joints[c->joint[i]].law != LAW_ELASTIC);
  PetscCallMPI(MPI_Allreduce(&mine, slips, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the stiffness-proportional damping with which cycles start. */
static PetscErrorCode set_beta(const Problem *p)
{
  PetscBool slips;
  PetscFunctionBeginUser;
  PetscCall(can_slip(p, &slips));
  p->state->beta = p->scene->damping == DAMPING_ADAPTIVE && slips ? p->scene->beta : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds contacts, where they may vary, masses and forces at an equilibrium from which a stage or trial
   starts. */
static PetscErrorCode start_from_here(const Problem *p)
{
  const Scene *scene = p->scene;
  const TermView view = ViewOf(p);
  State *state = p->state;
  const PetscBool vary = ContactsVary(p->contacts, p->stage);
  PetscFunctionBeginUser;
  // the forces that verification asks for are those of the new stage: what they break is not kept
  PetscCall(TermsHistory(&view, COMMIT));
  if (vary) PetscCall(verify(p, PETSC_TRUE));
  PetscCall(set_beta(p));
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, state, NULL));
  PetscCall(TermsHistory(&view, GO_BACK));
  ContactTravelStart(p);
  PetscCall(ScaledMasses(scene, p->m, p->stage->joints, p->contacts, state));
  PetscCall(RelaxationReset(p)); // a stage may collapse before the ramp ends: its motion counts from here
  PetscCall(RelaxationStart(p->m, p->contacts, state, p->relax));
  *(vary ? &p->relax->effort.variable : &p->relax->effort.fixed) = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets loads, contacts and masses at the start of a stage or trial. */
static PetscErrorCode prepare(const Problem *p)
{
  const TermView view = ViewOf(p);
  State *state = p->state;
  PetscFunctionBeginUser;
  PetscCall(LoadsFromNow(p->m, state));
  PetscCall(TermsBegin(&view));
  PetscCall(LoadsTarget(p->scene, p->m, p->stage, state));
  // the velocities of a dynamic stage mean nothing in fictitious time
  if (state->time > 0.) PetscCall(PetscArrayzero(state->v, p->m->n_dof));
  PetscCall(ContactsSetMargin(p->m, p->stage->joints, state, p->stage->tolerance, p->contacts));
  p->relax->outgrown = PETSC_FALSE;
  p->m->condensed.rounds = 0;
  PetscCall(start_from_here(p));
  p->relax->account.rounds = 0., p->relax->begun = 0;
  PetscCall(EnergyCheckStart(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds contacts again at the last equilibrium, where the stage is, because one has left its range. */
static PetscErrorCode find_anew(const Problem *p)
{
  Relaxation *r = p->relax;
  PetscFunctionBeginUser;
  r->outgrown = PETSC_FALSE;
  if (p->m->condensed.large) {
    p->m->condensed.leave = "a contact has left its range", p->result->verdict = VERDICT_INTERRUPTED;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!(r->effort.outgrown[2] > 0.)) PetscCall(PetscArraycpy(r->effort.outgrown, r->outgrown_at, 3));
  PetscCall(ContactsOutgrow(p->scene, p->m, p->state, p->contacts));
  if (p->state->stiffness_mass) PetscCall(StiffnessCyclesEnd(p));
  p->contacts->friction = FRICTION_KEPT; // as between two stages
  r->begun = p->result->cycles;
  PetscCall(start_from_here(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Starts cycles from the present state, under loads that ramp from those that act now. */
static PetscErrorCode start_cycles(const Problem *p, PetscInt64 *ramp_start)
{
  State *state = p->state;
  PetscFunctionBeginUser;
  if (!state->stiffness_mass) p->relax->effort.explicit = PETSC_TRUE;
  PetscCall(LoadsFromNow(p->m, state));
  *ramp_start = p->result->cycles;
  state->applied.ramp = 0.;
  // the first cycle counts the change of forces from here
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, state, NULL));
  // the other dampings keep slip from each evaluation, as the paper does
  p->contacts->friction = p->scene->damping == DAMPING_ADAPTIVE ? FRICTION_PULLED : FRICTION_KEPT;
  p->contacts->pull = PULL_CLOSE;
  PetscCall(RelaxationStart(p->m, p->contacts, state, p->relax));
  PetscCall(EnergyCheckStart(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the cycles of a stage back to where they started, with the diagonal mass. */
static PetscErrorCode start_explicitly(const Problem *p, PetscInt64 *ramp_start)
{
  PetscFunctionBeginUser;
  PetscCall(EnergyCheckGoBack(p));
  PetscCall(StiffnessCyclesEnd(p));
  PetscCall(set_beta(p));
  p->state->step_divisor = 1.;
  p->relax->begun = p->result->cycles;
  if (p->result->verdict == VERDICT_DIVERGED) // the sums of its last cycle may not be numbers
    PetscCall(PetscMemzero(&p->relax->damping.sums, sizeof(p->relax->damping.sums)));
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state));
  PetscCall(start_cycles(p, ramp_start));
  PetscCall(RelaxationReset(p));
  p->result->verdict = VERDICT_NONE, p->result->evidence[0] = '\0';
  PetscCall(CheckpointNow(p->checkpoint, p->state->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a stage to the verdict, or to the first cycle of the explicit loop. */
static PetscErrorCode before_cycles(const Problem *p, PetscInt64 *ramp_start)
{
  MethodKind method;
  PetscFunctionBeginUser;
  PetscCall(StageMethod(p->scene, p->m, p->contacts, p->stage, &method, &p->relax->effort.choice));
  if (method == METHOD_PRECONDITIONED) PetscCall(precondition(p));
  if (p->result->verdict != VERDICT_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  if (p->relax->outgrown)
    PetscCall(find_anew(p));
  else if (method == METHOD_PRECONDITIONED)
    MethodHandsOver(p);
  if (method == METHOD_STIFFNESS_MASS) PetscCall(StiffnessCyclesBegin(p));
  PetscCall(start_cycles(p, ramp_start));
  if (method == METHOD_PRECONDITIONED) PetscCall(CheckpointNow(p->checkpoint, p->state->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restarts the stage at its last equilibrium by explicit cycles, with contacts that are found again, because
   one has left its range as the stage came to rest. That state is not kept: blocks that had no contact may
   have gone through each other. */
static PetscErrorCode restart_anew(const Problem *p, PetscInt64 *ramp_start)
{
  PetscFunctionBeginUser;
  p->result->verdict = VERDICT_NONE, p->result->evidence[0] = '\0';
  PetscCall(EnergyCheckGoBack(p));
  PetscCall(find_anew(p));
  p->state->alpha = p->relax->damping.q_ray = 0.; // of a motion that is undone
  p->state->step_divisor = 1.;
  PetscCall(start_cycles(p, ramp_start));
  PetscCall(CheckpointNow(p->checkpoint, p->state->cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode begin(Loop *loop)
{
  PetscFunctionBeginUser;
  PetscCall(prepare(loop->p));
  loop->p->relax->work_before = EffortWork(&loop->p->relax->effort);
  PetscCall(before_cycles(loop->p, &((Static *)loop->memory)->ramp_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode resume(Loop *loop)
{
  PetscFunctionBeginUser;
  if (loop->p->relax->step > 0.) // the checkpoint was written within Newton's method, else within the loop
    PetscCall(before_cycles(loop->p, &((Static *)loop->memory)->ramp_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool checks(const Loop *loop)
{
  return (PetscBool)((loop->p->result->cycles + 1) % loop->p->scene->check_every == 0);
}

static PetscBool fault(const Loop *loop)
{
  return loop->p->relax->damping.fault;
}

static PetscErrorCode load(Loop *loop)
{
  const Problem *p = loop->p;
  Static *s = loop->memory;
  PetscFunctionBeginUser;
  if (p->state->applied.ramp >= 1.) PetscFunctionReturn(PETSC_SUCCESS);
  if (p->state->stiffness_mass) s->ramp_start -= s->hurries;
  const PetscInt64 since = p->result->cycles + 1 - s->ramp_start;
  LoadsApply(p->m, p->state, p->stage->ramp ? PetscMin(1., (PetscReal)since / p->stage->ramp) : 1.);
  if (PushOf(p->state)) PetscCall(PushAim(p->m, p->state, p->state->applied.ramp, PushOf(p->state)));
  if (p->state->applied.ramp < 1.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RelaxationReset(p));                    // evidence counts from the full load on
  if (PushOf(p->state) && PushOf(p->state)->acts) { // and damping from where the given motion ends
    PetscCall(DampingStart(p->m, p->state, &p->relax->damping));
    p->relax->damping.q_ray = 0.;
  }
  PetscCall(EnergyCheckRampEnds(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode cycle(Loop *loop)
{
  const Problem *p = loop->p;
  const Static *s = loop->memory;
  PetscFunctionBeginUser;
  PetscCall(Step(p->scene, p->m, p->stage->joints, p->contacts, p->state, &p->relax->damping,
                 loop->checks ? s->contact_scale : NULL));
  if (PushOf(p->state)) PetscCall(PushHold(p->m, p->state, PushOf(p->state)));
  p->relax->effort.evaluations++;
  if (p->state->stiffness_mass) p->relax->effort.solves++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets the ramp hurry where few contacts have slipped, less where blocks crack: both depend on how a load
   came. */
static PetscErrorCode set_pace(const Problem *p, Static *s)
{
  PetscInt n[2];
  PetscBool cracks = LawsCrack(p->m);
  PetscFunctionBeginUser;
  s->hurries = 0;
  if (!p->state->stiffness_mass || p->state->applied.ramp >= 1.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlippedContacts(p, BEARS, n));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cracks, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  if ((PetscReal)n[1] < FEW_SLIP * (PetscReal)n[0])
    s->hurries = PetscMax(cracks ? 1 : RAMP_HURRIES,
                          p->stage->ramp / (cracks ? RAMP_CRACKED : RAMP_HURRIED)) -
                 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode judge(Loop *loop)
{
  const Problem *p = loop->p;
  Static *s = loop->memory;
  Relaxation *relax = p->relax;
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  PetscCall(Unbalanced(p->m, p->state, s->contact_scale, p->relax->evidence.u_0, result));
  PetscCall(EnergyCheck(p, &loop->restarted));
  if (loop->restarted) {
    s->ramp_start = result->cycles, s->hurries = 0;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscBool springs = (PetscBool)(relax->follow.stalls >= STALLS_TO_LET_GO);
  PetscCall(Secant(p->m, p->state, result->ratio, springs, &relax->damping));
  PetscCall(Judge(p));
  PetscCall(CheckFrictionLaw(p, s->contact_scale));
  PetscCall(FrictionModeSwitch(p->m, p->state, result->ratio, relax, p->contacts));
  if (result->verdict == VERDICT_NONE) SlowFlowWarn(p);
  if (relax->evidence.still) PetscCall(RelaxationStill(p));
  if (!ContactsVary(p->contacts, p->stage) && result->finite)
    PetscCall(JudgeContactTravel(p, (PetscBool)(result->verdict == VERDICT_CONVERGED)));
  if (relax->outgrown) {
    PetscCall(restart_anew(p, &s->ramp_start));
    loop->restarted = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(EnergyCheckVerdict(p));
  PetscCall(StiffnessCyclesFail(p, &loop->restarted));
  if (loop->restarted) PetscCall(start_explicitly(p, &s->ramp_start));
  if (MethodStalls(p)) PetscCall(StiffnessCyclesLeave(p));
  if (MethodCreeps(p)) PetscCall(StiffnessCyclesGoOn(p));
  PetscCall(set_pace(p, s));
  ContactTravelStartBearing(p->contacts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode settle(Loop *loop)
{
  PetscFunctionBeginUser;
  PetscCall(follow_openings(loop->p, &((Static *)loop->memory)->ramp_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode report(Loop *loop)
{
  const Problem *p = loop->p;
  const StageResult *result = p->result;
  Static *s = loop->memory;
  PetscFunctionBeginUser;
  const PetscBool often = (PetscBool)(p->stage->kind != STAGE_PUSHOVER &&
                                      result->cycles % p->scene->history_every < p->scene->check_every);
  if (often || result->verdict != VERDICT_NONE) // of a pushover equilibria alone
    PetscCall(OutputHistory(p));
  if (p->state->applied.ramp >= 1. && s->first_ratio == 0.)
    s->first_ratio = result->ratio, s->first_wall = result->wall;
  progress(p, s->first_ratio, s->first_wall);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode follow(Loop *loop)
{
  const Problem *p = loop->p;
  PetscFunctionBeginUser;
  if (ContactsVary(p->contacts, p->stage) && p->result->verdict == VERDICT_NONE)
    PetscCall(verify(p, PETSC_FALSE));
  PetscCall(LoadsRenew(p->scene, p->m, p->stage, p->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode end(Loop *loop)
{
  const Problem *p = loop->p;
  Relaxation *relax = p->relax;
  const PetscBool converged = (PetscBool)(p->result->verdict == VERDICT_CONVERGED),
                  cycles = EffortHasCycles(&relax->effort);
  PetscFunctionBeginUser;
  PetscCall(StiffnessMassEnd(p->state));
  if (converged && cycles && !ContactsFromCommitted(p->contacts))
    PetscCall(CheckPathDependence(p, ((Static *)loop->memory)->contact_scale));
  if (converged) PetscCall(CheckManySlips(p));
  if (p->contacts->friction == FRICTION_PULLED) p->contacts->friction = FRICTION_LAW;
  if (converged)
    PetscCall(ContactsSetMargin(p->m, p->stage->joints, p->state, p->stage->tolerance, p->contacts));
  // forces, stresses and joint states are evaluated once more: results must belong to the last displacements
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, p->state, NULL));
  if (p->result->verdict == VERDICT_CONVERGED) PetscCall(CheckStageIncrement(p));
  if (p->result->verdict == VERDICT_CONVERGED && cycles) PetscCall(CheckLoadStep(p, 0., relax->account.u));
  if (cycles) PetscCall(CheckRampLength(p));
  PetscCall(CheckSteepSlope(p));
  PetscCall(UnsupportedReport(p));
  if (p->contacts->friction == FRICTION_LAW) p->contacts->friction = FRICTION_KEPT;
  p->state->beta = p->state->local = 0., p->state->step_divisor = 1.;
  relax->effort.evaluations++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StageRelax(const Problem *p)
{
  static const LoopKind kind = {.begin = begin,
                                .resume = resume,
                                .load = load,
                                .cycle = cycle,
                                .judge = judge,
                                .settle = settle,
                                .report = report,
                                .follow = follow,
                                .end = end,
                                .archive = archive,
                                .checks = checks,
                                .fault = fault};
  Static s = {.first_ratio = 0.};
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(p->m->n_dof, &s.contact_scale));
  PetscCall(StageLoop(p, &kind, &s));
  PetscCall(PetscFree(s.contact_scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

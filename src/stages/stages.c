/* stages.c: the stages of a scene, one after the other; each ends with a verdict. */
#include "output/output.h"
#include "stages/repartition.h"
#include <unistd.h>

PetscErrorCode StateCreate(const Scene *scene, const Model *m, State *s)
{
  PetscBool variable = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  PetscCall(StateResize(m, s));
  PetscCall(PetscCalloc3(m->n_dof, &s->v, m->n_dof, &s->m, m->n_dof, &s->m_inv));
  for (PetscInt i = 0; i < scene->n_stages; i++)
    variable = (PetscBool)(variable || scene->stages[i].variable);
  if (variable) PetscCall(PetscCalloc1(PetscMax(1, m->n_dof), &s->u_verified));
  PetscCall(VecCreateMPIWithArray(m->comm, 1, m->n_dof, PETSC_DECIDE, s->u, &s->u_vec));
  PetscCall(VecCreateMPIWithArray(m->comm, 1, m->n_dof, PETSC_DECIDE, s->v, &s->v_vec));
  if (m->n_condensed_global) PetscCall(PetscCalloc1(ModelApplied(m), &s->passed));
  s->dt = s->caution = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateDestroy(State *s)
{
  PetscReal **array[6] = {&s->u, &s->f, &s->f_old, &s->f_ext, &s->f_start, &s->f_target};
  PetscFunctionBeginUser;
  PetscCall(VecDestroy(&s->u_vec));
  PetscCall(VecDestroy(&s->v_vec));
  for (int i = 0; i < 6; i++) PetscCall(PetscFree(*array[i]));
  PetscCall(PetscFree3(s->v, s->m, s->m_inv));
  PetscCall(PetscFree(s->u_verified));
  PetscCall(PetscFree(s->passed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a person watches: our stdout is a terminal, and so is that of the parent process, because mpirun
   puts a terminal of its own between its ranks and wherever its output goes. */
static PetscBool on_terminal(void)
{
  char link[64], target[PETSC_MAX_PATH_LEN];
  ssize_t n;
  if (!isatty(STDOUT_FILENO)) return PETSC_FALSE;
  snprintf(link, sizeof(link), "/proc/%d/fd/1", (int)getppid());
  n = readlink(link, target, sizeof(target) - 1);
  if (n < 0) return PETSC_TRUE;
  target[n] = 0;
  return (PetscBool)(!strncmp(target, "/dev/pts/", 9) || !strncmp(target, "/dev/tty", 8));
}

PetscBool StageShows(const Problem *p)
{
  static const double EVERY = 10., EVERY_ON_TERMINAL = 0.5; /* [s] */
  static double last = -1.;
  if (p->m->rank) return PETSC_FALSE;
  if (last < 0.) last = MPI_Wtime(); // the first line is one interval from the start
  if (MPI_Wtime() - last < (on_terminal() ? EVERY_ON_TERMINAL : EVERY)) return PETSC_FALSE;
  last = MPI_Wtime();
  return PETSC_TRUE;
}

void StageShow(const Problem *p, const char *what)
{
  if (on_terminal())
    printf("\r%-12s %-86s", p->stage->name, what);
  else
    printf("  %s: %s\n", p->stage->name, what);
  fflush(stdout);
}

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

const char *EffortMethod(const Effort *e)
{
  return !e->preconditioned ? "explicit" : e->explicit ? "preconditioned, then explicit" : "preconditioned";
}

/* A force evaluation comes with a tangent and counts as a solve. */
PetscReal EffortWork(const Effort *e)
{
  static const PetscReal PER_FACTOR = 15.; /* [solves] what a factorisation takes */
  return (PetscReal)(1 + e->evaluations + e->solves) + PER_FACTOR * (PetscReal)e->factorisations;
}

PetscErrorCode StageReport(const Problem *p)
{
  const MPI_Comm comm = p->m->comm;
  const StageResult *r = p->result;
  PetscFunctionBeginUser;
  if (!p->m->rank && on_terminal()) printf("\r%100s\r", "");
  PetscCall(PetscPrintf(comm, "stage %-12s %s after %" PetscInt64_FMT " cycle%s, %.2f s: %s\n",
                        p->stage->name, VerdictNames[r->verdict], r->cycles, Plural(r->cycles), r->wall,
                        r->evidence));
  if (r->effort.preconditioned)
    PetscCall(PetscPrintf(
        comm,
        "  %s%s: %" PetscInt64_FMT " force evaluations, %" PetscInt64_FMT " solves, %" PetscInt64_FMT
        " factorisation%s\n",
        EffortMethod(&r->effort), p->scene->method == METHOD_AUTO ? " (auto: large, all joints elastic)" : "",
        r->effort.evaluations, r->effort.solves, r->effort.factorisations, Plural(r->effort.factorisations)));
  PetscCall(PartReport(comm, r->cycles));
  PetscFunctionReturn(PETSC_SUCCESS);
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

PetscErrorCode StageLoads(const Problem *p)
{
  PetscFunctionBeginUser;
  if (!LoadsChange(p->scene, p->m, p->stage)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LoadsTarget(p->scene, p->m, p->stage, p->state));
  LoadsApply(p->m, p->state, p->state->ramp);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At equilibrium, and after each chunk of cycles without one, the open length of a cracked base is measured;
   when it has changed, the new pressure is ramped up and the stage goes on. */
static PetscErrorCode follow_cracks(const Problem *p, PetscInt64 *ramp_start)
{
  State *state = p->state;
  StageResult *result = p->result;
  const PetscBool chunk_ended = (PetscBool)(result->verdict == VERDICT_NONE && state->ramp >= 1. &&
                                            p->relax->chunk_start == state->cycle);
  PetscBool again;
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_CONVERGED && !chunk_ended) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(UpliftCrack(p, &again));
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
  PetscCall(SecantStart(p->m, p->contacts, state, p->relax));
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
    PetscCall(SecantStart(p->m, p->contacts, state, p->relax));
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
    PetscCall(Step(scene, m, stage->joints, contacts, state, relax, check ? loop.contact_scale : NULL));
    result->cycles++, relax->effort.evaluations++;
    if (!check && !relax->fault) continue;
    PetscCall(Unbalanced(m, state, loop.contact_scale, result));
    PetscCall(EnergyGuard(p, &anew));
    if (anew) loop.ramp_start = result->cycles;
    if (anew) continue;
    PetscCall(Secant(m, state, result->ratio, relax));
    result->wall = MPI_Wtime() - loop.start;
    PetscCall(Judge(p));
    PetscCall(ConfirmByLaw(p, loop.contact_scale));
    FollowElse(m, state, result->ratio, relax, contacts);
    if (relax->still) PetscCall(RelaxationStill(p));
    if (!stage->variable && result->finite) PetscCall(JudgeContacts(p));
    PetscCall(EnergyVeto(p));
    PartingOfBearing(contacts);
    PetscCall(follow_cracks(p, &loop.ramp_start));
    if (result->cycles % scene->history_every < scene->check_every || result->verdict != VERDICT_NONE)
      PetscCall(OutputHistory(p));
    if (state->ramp >= 1. && first_ratio == 0.) first_ratio = result->ratio, first_wall = result->wall;
    progress(p, first_ratio, first_wall);
    if (stage->variable && result->verdict == VERDICT_NONE) PetscCall(verify(p, PETSC_FALSE));
    PetscCall(StageLoads(p));
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

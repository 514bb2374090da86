/* reduction.c: stages made of trials: strengths reduced, or the water raised, until something gives way.

   A trial is a relaxation to a verdict from the last stable state (an unstable one leaves slip behind):
   equilibrium makes it stable, a mechanism makes it fail, and everything else ends the stage undecided.
   Trials go by steps from the start towards the limit; without a step the limit itself is tried. Between the
   last stable and the first failing value bisection narrows the bracket. The stage ends in the last stable
   state: collapse is a result. */
#include "output.h"
#include "checkpoint.h"
#include "joint_law.h"
#include <float.h>

/* What a trial starts from. */
typedef struct {
  PetscReal *u, *u_verified, *f_ext, *crack;
  Contacts contacts;
  PetscReal alpha, q_ray, contact_depth;
} Snapshot;

typedef struct {
  const Scene *scene; /* as the user wrote it */
  Problem p;          /* the trial, of the two that follow */
  Stage stage;        /* joints and ramp change */
  Scene raised;       /* levels of water change */
  Snapshot snapshot;
  StageResult last_stable;
  PetscInt *has;             /* (n_joints,) joints that are reduced and have contacts; NULL: a flood */
  PetscInt trial;            /* of the steps: 0: the start */
  PetscReal value;           /* of the trial that runs */
  PetscReal stable, failing; /* NaN: none yet */
  PetscInt64 first_cycle;    /* of the stage */
  double start;              /* [s] of MPI_Wtime */
} Driver;

/* ---- the stable state */

static PetscErrorCode snapshot_create(const Problem *p, Snapshot *s)
{
  const Model *m = p->m;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(ModelApplied(m), &s->u, m->n_dof, &s->u_verified, ModelApplied(m), &s->f_ext,
                         p->scene->n_loads, &s->crack));
  PetscCall(PetscArrayzero(s->u_verified, m->n_dof));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode snapshot_destroy(Snapshot *s)
{
  PetscFunctionBeginUser;
  PetscCall(ContactsDestroy(&s->contacts));
  PetscCall(PetscFree4(s->u, s->u_verified, s->f_ext, s->crack));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode snapshot_take(const Problem *p, Snapshot *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(s->u, p->state->u, ModelApplied(p->m)));
  s->contact_depth = p->m->contact_depth;
  if (p->state->u_verified) PetscCall(PetscArraycpy(s->u_verified, p->state->u_verified, p->m->n_dof));
  PetscCall(PetscArraycpy(s->f_ext, p->state->f_ext, ModelApplied(p->m)));
  PetscCall(ContactsDestroy(&s->contacts));
  PetscCall(ContactsCopy(p->contacts, &s->contacts));
  for (PetscInt l = 0; l < p->scene->n_loads; l++) s->crack[l] = p->state->uplift[l].crack;
  s->alpha = p->state->alpha, s->q_ray = p->relax->q_ray;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode snapshot_restore(const Problem *p, const Snapshot *s)
{
  PetscFunctionBeginUser;
  if (p->stage->variable) { // the local numbers in the contacts hold where they were found
    PetscCall(PetscArraycpy(p->state->u_verified, s->u_verified, p->m->n_dof));
    p->m->contact_depth = s->contact_depth;
    PetscCall(NeighboursAt(p->m, p->state, s->u_verified));
  }
  PetscReal *u = p->state->u;
  PetscCall(PetscArraycpy(u, s->u, ModelApplied(p->m)));
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  PetscCall(PetscArraycpy(p->state->f_ext, s->f_ext, ModelApplied(p->m)));
  PetscCall(ContactsDestroy(p->contacts));
  PetscCall(ContactsCopy(&s->contacts, p->contacts));
  for (PetscInt l = 0; l < p->scene->n_loads; l++) p->state->uplift[l].crack = s->crack[l];
  p->state->alpha = s->alpha, p->relax->q_ray = s->q_ray;
  PetscCall(GhostBegin(p->m, u + 3 * p->m->n_bodies));
  PetscCall(GhostEnd(p->m, u + 3 * p->m->n_bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a value means */

static PetscBool is_reduced(const Stage *stage, const Joint *joint)
{
  if (!joint->defined || joint->law == LAW_ELASTIC) return PETSC_FALSE;
  for (PetscInt i = 0; i < stage->n_reduce; i++)
    if (!strcmp(stage->reduce[i], joint->name)) return PETSC_TRUE;
  return (PetscBool)(stage->n_reduce == 0);
}

PetscReal ReducedFriction(const Scene *scene, const Stage *stage, const PetscInt *has)
{
  PetscReal most = NAN;
  for (PetscInt j = 0; j < scene->n_joints; j++)
    if (is_reduced(stage, stage->joints + j) && (!has || has[j]) && !(most >= stage->joints[j].friction[0]))
      most = stage->joints[j].friction[0];
  return most;
}

/* Collective. Adds to `has` the joints that the stage reduces and that have contacts now. */
static PetscErrorCode reduced_joints(const Problem *p, PetscInt *has)
{
  const Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0 && is_reduced(p->stage, p->stage->joints + c->joint[i])) has[c->joint[i]] = 1;
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, has, (PetscMPIInt)p->scene->n_joints, MPIU_INT, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Strengths of the trial: friction no more than `value` degrees, or every strength times `value`. */
static void reduce_joints(const Scene *scene, const Stage *stage, const Joint *full, PetscReal value)
{
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    Joint *joint = stage->joints + j;
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): there is always the default joint
    *joint = full[j];
    if (!is_reduced(stage, joint)) continue;
    for (int i = 0; i < 2; i++) {
      if (stage->what == REDUCE_FRICTION) {
        joint->friction[i] = PetscMin(joint->friction[i], value);
      } else {
        joint->friction[i] = atan(value * joint->tan_phi[i]) * (180. / PETSC_PI);
        joint->cohesion[i] *= value, joint->tension[i] *= value;
      }
    }
    if (stage->what == REDUCE_STRENGTHS) joint->compression = PetscMax(joint->compression * value, DBL_MIN);
    JointPrepare(joint);
  }
}

/* The waters of a flood that rise, risen by `rise`; the others stay. */
static void raise_water(const Scene *scene, const Stage *stage, PetscReal rise, Load *loads)
{
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    Load *load = loads + l;
    *load = scene->loads[l];
    if (stage->tail_rises[l]) load->tailwater += rise;
    if (!stage->level_rises[l]) continue;
    load->level += rise;
    if (load->raise == RAISE_WHOLE) load->drain_level += rise;
  }
}

/* Joints or water as they are at `value`. */
static void set_value(Driver *d, const Joint *full, PetscReal value)
{
  if (d->stage.kind == STAGE_FLOOD)
    raise_water(d->scene, &d->stage, value - d->stage.start, d->raised.loads);
  else
    reduce_joints(d->scene, &d->stage, full, value);
}

/* ---- trials */

/* Runs the trial of d->value from the present state. */
static PetscErrorCode run_trial(Driver *d, const Joint *full)
{
  const PetscReal value = d->value;
  Verdict *verdict = &d->p.result->verdict;
  PetscFunctionBeginUser;
  if (d->trial && d->stage.kind != STAGE_FLOOD) d->stage.ramp = 0; // the loads stay
  set_value(d, full, value);
  PetscCall(StageRelax(&d->p));
  // far away but finite: it fell
  if (*verdict == VERDICT_DIVERGED && d->p.result->finite) *verdict = VERDICT_COLLAPSED;
  PetscCall(TrialsAdd(&d->p, value));
  if (*verdict == VERDICT_CONVERGED) {
    d->stable = value;
    d->last_stable = *d->p.result;
    PetscCall(snapshot_take(&d->p, &d->snapshot));
  } else if (*verdict == VERDICT_COLLAPSED) {
    d->failing = value;
    PetscCall(MechanismTake(&d->p));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool decided(const Driver *d)
{
  return (PetscBool)(d->p.result->verdict == VERDICT_CONVERGED || d->p.result->verdict == VERDICT_COLLAPSED);
}

/* The value after `value` on the way from start to limit. */
static PetscReal next_value(const Stage *s, PetscInt trial)
{
  PetscReal value = s->limit;
  if (s->kind == STAGE_FLOOD && s->step > 0.) value = PetscMin(s->limit, s->start + trial * s->step);
  if (s->kind == STAGE_STRENGTH_REDUCTION && s->step > 0.)
    value = PetscMax(s->limit, s->start - trial * s->step);
  if (s->kind == STAGE_STRENGTH_REDUCTION && s->factor > 0.)
    value = PetscMax(s->limit, s->start * PetscPowReal(s->factor, (PetscReal)trial));
  return value;
}

/* Steps until something fails, then bisection. */
static PetscErrorCode next_trial(Driver *d, PetscBool *go)
{
  PetscFunctionBeginUser;
  *go = PETSC_FALSE;
  if (!decided(d)) PetscFunctionReturn(PETSC_SUCCESS);
  if (PetscIsNanReal(d->failing)) {
    if (d->stable == d->stage.limit) PetscFunctionReturn(PETSC_SUCCESS);
    d->value = next_value(&d->stage, ++d->trial);
  } else {
    if (!(d->stage.bracket > 0. && PetscAbsReal(d->stable - d->failing) > d->stage.bracket))
      PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(snapshot_restore(&d->p, &d->snapshot));
    d->value = 0.5 * (d->stable + d->failing);
  }
  *go = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Back to the last stable state, with forces and joints that belong to it. */
static PetscErrorCode settle(Driver *d, const Joint *full)
{
  PetscFunctionBeginUser;
  set_value(d, full, d->stable);
  PetscCall(snapshot_restore(&d->p, &d->snapshot));
  PetscCall(Forces(d->p.m, d->stage.joints, d->p.contacts, d->p.state, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode refuse_start(const Driver *d)
{
  char message[MESSAGE_LENGTH] = "", where[64] = "";
  PetscFunctionBeginUser;
  if (d->stage.line) PetscCall(PetscSNPrintf(where, sizeof(where), ":%d", d->stage.line));
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                          "%s%s: stages.%s: it does not stand at its start (%.6g): %s", d->scene->file, where,
                          d->stage.name, (double)d->stage.start, d->p.result->evidence));
  PetscCall(CheckMessage(d->p.m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the stage comes to: the last stable state with its numbers; undecided and interrupted trials pass on
   their verdict. */
static PetscErrorCode conclude(const Driver *d)
{
  StageResult *result = d->p.result;
  const PetscInt n = d->p.output->trials.n;
  const char *unit = d->stage.kind == STAGE_FLOOD ? " m" : d->stage.what == REDUCE_FRICTION ? " degree" : "";
  const StageResult last = *result;
  char factor[128];
  PetscFunctionBeginUser;
  if (!decided(d)) {
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "trial %" PetscInt_FMT " is %s, last stable %.8g%s: %s", n,
                            VerdictNames[last.verdict], (double)d->stable, unit, last.evidence));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *result = d->last_stable;
  if (PetscIsNanReal(d->failing))
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "%" PetscInt_FMT " trials: stable at %.8g%s, the limit; nothing fails", n,
                            (double)d->stable, unit));
  else
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "%" PetscInt_FMT " trials: stable at %.8g%s, fails at %.8g%s", n,
                            (double)d->stable, unit, (double)d->failing, unit));
  TrialsSay(&d->p, sizeof(factor), factor);
  PetscCall(PetscStrlcat(result->evidence, factor, sizeof(result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All that the trials remember besides what Output has of them, see archive.h. */
static PetscErrorCode archive_trials(Archive *a, void *context)
{
  Driver *d = context;
  Snapshot *s = &d->snapshot;
  PetscReal reals[] = {d->value,      d->stable, d->failing, s->alpha, s->q_ray, MPI_Wtime() - d->start,
                       d->stage.start};
  PetscInt64 counts[] = {d->trial, d->first_cycle};
  PetscFunctionBeginUser;
  PetscCall(ArchiveReals(a, "reals", 7, reals));
  PetscCall(ArchiveCounts(a, "counts", 2, counts));
  d->value = reals[0], d->stable = reals[1], d->failing = reals[2];
  s->alpha = reals[3], s->q_ray = reals[4], d->start = MPI_Wtime() - reals[5];
  d->stage.start = reals[6];
  d->trial = (PetscInt)counts[0], d->first_cycle = counts[1];
  if (d->has) PetscCall(ArchiveInts(a, "has", d->scene->n_joints, d->has));
  PetscCall(ArchiveEffort(a, &d->p.relax->effort));
  if (PetscIsNanReal(d->stable)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveResult(a, "last_stable", &d->last_stable));
  PetscCall(ArchiveApplied(a, d->p.m, "u", s->u));
  PetscCall(ArchiveDofs(a, d->p.m, "u_verified", s->u_verified));
  PetscCall(ArchiveApplied(a, d->p.m, "f_ext", s->f_ext));
  PetscCall(ArchiveReals(a, "crack", d->scene->n_loads, s->crack));
  const PetscBool moves = (PetscBool)(a->reading && d->p.state->u_verified);
  if (a->reading) RigidMotion(d->p.m, s->u);
  if (moves) PetscCall(NeighboursAt(d->p.m, d->p.state, s->u_verified));
  PetscCall(ArchiveContacts(a, d->scene, d->p.m, "contacts", &s->contacts));
  if (moves) PetscCall(NeighboursAt(d->p.m, d->p.state, d->p.state->u_verified));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Start, search, end; full: of a reduction, its joints before. */
static PetscErrorCode drive(Driver *d, const Joint *full)
{
  Trials *trials = &d->p.output->trials;
  PetscBool go = PETSC_TRUE, resumed;
  PetscFunctionBeginUser;
  d->p.scene = &d->raised, d->p.stage = &d->stage;
  PetscCall(snapshot_create(&d->p, &d->snapshot));
  d->stable = d->failing = NAN;
  d->trial = 0, d->value = d->stage.start, d->first_cycle = d->p.state->cycle, d->start = MPI_Wtime();
  PetscCall(CheckpointAttach(d->p.output->checkpoint, "trials", archive_trials, d, &resumed));
  if (!resumed) PetscCall(TrialsReset(trials));
  while (go) {
    PetscCall(run_trial(d, full));
    if (PetscIsNanReal(d->stable) && d->p.result->verdict == VERDICT_COLLAPSED) PetscCall(refuse_start(d));
    PetscCall(next_trial(d, &go));
    if (!go) break;
    StageResult between = {.verdict = VERDICT_NONE};
    PetscCall(CheckpointPoll(d->p.output->checkpoint, d->p.state->cycle, &between));
    if (between.verdict == VERDICT_NONE) continue;
    *d->p.result = between;
    break;
  }
  PetscCall(CheckpointDetach(d->p.output->checkpoint));
  if (!PetscIsNanReal(d->stable)) PetscCall(settle(d, full));
  trials->stable = d->stable, trials->failing = d->failing;
  if (d->has && d->stage.what == REDUCE_FRICTION) {
    PetscCall(reduced_joints(&d->p, d->has));
    PetscCall(TrialsFactors(&d->p, full, d->has));
  }
  PetscCall(conclude(d));
  d->p.result->cycles = d->p.state->cycle - d->first_cycle;
  d->p.result->wall = MPI_Wtime() - d->start;
  PetscCall(snapshot_destroy(&d->snapshot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the rows of the scene cannot know: which of them have contacts. nominal: largest friction of these. */
static PetscErrorCode check_contacts(const Problem *p, PetscReal nominal)
{
  const Stage *s = p->stage;
  char message[MESSAGE_LENGTH] = "", where[64] = "";
  PetscFunctionBeginUser;
  if (s->line) PetscCall(PetscSNPrintf(where, sizeof(where), ":%d", s->line));
  if (PetscIsNanReal(nominal))
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s%s: stages.%s.reduce: none of the joints that it reduces has a contact",
                            p->scene->file, where, s->name));
  else if (s->what == REDUCE_FRICTION && s->limit >= nominal)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s%s: stages.%s.limit: %.6g is out of range: the joints that have contacts have "
                            "%.6g [degree]",
                            p->scene->file, where, s->name, (double)s->limit, (double)nominal));
  PetscCall(CheckMessage(p->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReductionRun(const Problem *p)
{
  const Stage *stage = p->stage;
  const PetscInt n = p->scene->n_joints;
  Driver d = {.scene = p->scene, .p = *p, .stage = *stage, .raised = *p->scene};
  Joint *full;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &full));
  PetscCall(PetscCalloc1(n, &d.has));
  PetscCall(PetscArraycpy(full, stage->joints, n));
  PetscCall(reduced_joints(p, d.has));
  const PetscReal nominal = ReducedFriction(p->scene, stage, d.has);
  PetscCall(check_contacts(p, nominal));
  if (PetscIsNanReal(stage->start)) d.stage.start = stage->what == REDUCE_FRICTION ? nominal : 1.;
  PetscCall(drive(&d, full)); // d.stage.joints is stage->joints
  PetscCall(PetscFree(d.has));
  PetscCall(PetscFree(full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FloodRun(const Problem *p)
{
  Driver d = {.scene = p->scene, .p = *p, .stage = *p->stage, .raised = *p->scene};
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(p->scene->n_loads, &d.raised.loads));
  PetscCall(drive(&d, NULL));
  PetscCall(PetscFree(d.raised.loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

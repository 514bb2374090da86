/* trial_stage.c: runs stages made of trials: reduces strengths, raises the water or other loads, or lowers
   the force of anchors, until the structure fails.

   A trial is a relaxation to a verdict from the last stable state (an unstable one leaves slip behind):
   equilibrium makes it stable, a mechanism makes it fail, and everything else ends the stage undecided.
   Trials go by steps from the start towards the limit; without a step the limit itself is tried. Between the
   last stable and the first failing value bisection narrows the bracket. The stage ends in the last stable
   state: collapse is a result. */
#include "stages/stages.h"

/* Work of the forces that condensed bodies may lack along the motion of a trial that fails: over that of
   unbalanced forces, or over that of the loads. In dams that slide it is 0.007 to 0.4 of the first, next to
   the limit 1.4, and 9e-5 to 1e-3 of the second; in a dam that tips 0.75 and 0.02, in walls 57 and more. */
static const PetscReal MOST_LACKING = 0.9, LITTLE = 1e-3;

typedef struct {
  const Scene *scene; /* the scene of the user */
  Problem p;          /* the trial as a problem, with the next two members */
  Stage stage;        /* copy of the stage: joints and ramp change */
  Scene raised;       /* copy of the scene: loads change */
  Snapshot snapshot;
  StageResult last_stable;
  PetscInt *has;             /* (n_joints,) whether a reduced joint has contacts; NULL: loads are raised */
  PetscInt trial;            /* number of the step; 0: the start */
  PetscReal value;           /* value of the present trial */
  PetscReal stable, failing; /* last stable and lowest failing value; NaN: none yet */
  PetscReal open;            /* value nearest to stable whose trial ended without a verdict; NaN: none */
  PetscReal moved[2]; /* [m] displacement since the stage started, in the last trial, and in the last stable
                         one */
  PetscReal size;     /* [m] FreeSize */
  PetscReal *u_start; /* (ModelApplied,) displacements at the start of the stage */
  PetscBool sized; /* displacement_limit is not given: it is PART_OF_SIZE of size, from the first trial on */
  PetscBool rests; /* the trial of `failing` has come to rest beyond displacement_limit */
  PetscBool falls; /* the start fails; refused only when all memory is freed, as other scenes may follow */
  PetscInt64 first_cycle; /* of the stage */
  double start;           /* [s] of MPI_Wtime */
} Driver;

/* ---- what a value means */

/* Collective. Adds to `has` the joints that the stage reduces and that have contacts now. */
static PetscErrorCode reduced_joints(const Problem *p, PetscInt *has)
{
  const Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0 && JointIsReduced(p->stage, p->stage->joints + c->joint[i])) has[c->joint[i]] = 1;
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, has, (PetscMPIInt)p->scene->n_joints, MPIU_INT, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the strengths of a trial: friction at most `value` degrees, or every strength times `value`. */
static void reduce_joints(const Scene *scene, const Stage *stage, const Joint *full, PetscReal value)
{
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    Joint *joint = stage->joints + j;
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): there is always the default joint
    *joint = full[j];
    if (!JointIsReduced(stage, joint)) continue;
    if (stage->what == REDUCE_FRICTION)
      JointCapFriction(joint, value);
    else
      JointScale(joint, value);
  }
}

void FloodRaise(const Scene *scene, const Stage *stage, PetscReal rise, Load *loads)
{
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    Load *load = loads + l;
    *load = scene->loads[l];
    if (stage->tail_rises[l]) load->uplift.tailwater += rise;
    if (!stage->level_rises[l]) continue;
    load->level += rise;
    if (load->uplift.raise == RAISE_WHOLE) load->uplift.drain_level += rise;
  }
}

/* Multiplies the loads of a load factor. */
static void multiply_loads(const Scene *scene, const Stage *stage, PetscReal factor, Load *loads)
{
  for (PetscInt i = 0; i < stage->n_rises; i++)
    LoadScale(scene->loads + stage->rises[i], factor, loads + stage->rises[i]);
}

/* Sets joints, loads or jacks to `value`. */
static void set_value(Driver *d, const Joint *full, PetscReal value)
{
  if (d->stage.kind == STAGE_ANCHOR_FORCE)
    d->stage.pull = value;
  else if (d->stage.kind == STAGE_LOAD_FACTOR)
    multiply_loads(d->scene, &d->stage, value, d->raised.loads);
  else if (d->stage.kind == STAGE_FLOOD)
    FloodRaise(d->scene, &d->stage, value - d->stage.start, d->raised.loads);
  else
    reduce_joints(d->scene, &d->stage, full, value);
}

/* ---- trials */

/* Changes the verdict of a trial that has come to rest too far away to failed. */
static PetscErrorCode judge_displacement(Driver *d)
{
  StageResult *result = d->p.result;
  char rest[sizeof(result->evidence)];
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(rest, result->evidence, sizeof(rest)));
  result->verdict = VERDICT_COLLAPSED;
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                          "%.3g m from where the stage began, displacement_limit %.3g m: %.300s",
                          (double)d->moved[0], (double)d->stage.displacement_limit, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds whether a trial that has failed may stand with the blocks of condensed bodies. It fails
   there too if the forces that the bodies lack since their last correction, with those of loads on their
   moved faces, do less work against the motion of the trial than its unbalanced forces do along it, or little
   beside the loads. */
static PetscErrorCode may_stand(Driver *d, PetscBool *may)
{
  const Problem *p = &d->p;
  const Model *m = p->m;
  State *s = p->state;
  const PetscInt at = 3 * m->rigid.n, n = at + 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *lack, *corrected, *target,
      work[3] = {0., 0., 0.}; // of what is lacking, of unbalanced forces, of loads
  PetscFunctionBeginUser;
  PetscCall(CondensedRecover(m, s));
  PetscCall(PetscCalloc3(n, &lack, ModelApplied(m), &corrected, n, &target));
  PetscCall(CondensedLack(m, s, lack + at));
  PetscCall(PetscArraycpy(corrected, s->corrected, ModelApplied(m)));
  PetscCall(PetscArraycpy(target, s->applied.target, n));
  PetscCall(PetscArraycpy(s->corrected, s->u, ModelApplied(m)));
  PetscCall(LoadsTarget(p->scene, m, p->stage, s));
  for (PetscInt i = at; i < m->n_dof; i++)
    if (IsCondensed(m, i)) lack[i] -= s->applied.target[i] - target[i];
  for (PetscInt i = 0; i < m->n_dof; i++) {
    const PetscReal du = s->u[i] - d->snapshot.u[i];
    work[0] += lack[i] * du, work[2] += target[i] * du;
    if (!Held(m, i)) work[1] += (s->f_ext[i] - s->f[i]) * du;
  }
  PetscCall(PetscArraycpy(s->corrected, corrected, ModelApplied(m)));
  PetscCall(PetscArraycpy(s->applied.target, target, n));
  PetscCall(PetscFree3(lack, corrected, target));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 3, MPIU_REAL, MPI_SUM, m->comm));
  const PetscReal most = PetscMax(MOST_LACKING * work[1], LITTLE * PetscAbsReal(work[2]));
  *may = (PetscBool) !(work[0] <= PetscMax(most, 0.)); // also of NaN
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the stage where condensed bodies must be blocks: the first trial fails, which is a fault of the scene,
   or a trial has no verdict, or it has moved them too far for its verdict. */
static PetscErrorCode check_condensed(Driver *d)
{
  Verdict *verdict = &d->p.result->verdict;
  CondensedBodies *bodies = &d->p.m->condensed;
  PetscBool may = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (!bodies->large || *verdict == VERDICT_CONVERGED || *verdict == VERDICT_INTERRUPTED)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (*verdict != VERDICT_COLLAPSED)
    bodies->leave = "a trial has no verdict";
  else if (PetscIsNanReal(d->stable))
    bodies->leave = "the first trial fails";
  else
    PetscCall(may_stand(d, &may));
  if (may) bodies->leave = "a trial fails that may stand with the blocks";
  if (bodies->leave) *verdict = VERDICT_INTERRUPTED;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the trial of d->value from the present state. */
static PetscErrorCode run_trial(Driver *d, const Joint *full)
{
  const PetscReal value = d->value;
  Verdict *verdict = &d->p.result->verdict;
  PetscFunctionBeginUser;
  if (d->trial && d->stage.kind == STAGE_STRENGTH_REDUCTION) d->stage.ramp = 0; // the loads stay
  set_value(d, full, value);
  PetscCall(StageRelax(&d->p));
  // far away but finite: the blocks have fallen
  if (*verdict == VERDICT_DIVERGED && d->p.result->finite) *verdict = VERDICT_COLLAPSED;
  PetscCall(check_condensed(d));
  if (d->p.m->condensed.leave) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FarthestMoved(&d->p, d->u_start, d->moved));
  const PetscBool far = (PetscBool)(*verdict == VERDICT_CONVERGED &&
                                    d->moved[0] > d->stage.displacement_limit);
  if (far) PetscCall(judge_displacement(d));
  PetscCall(OutputTrial(&d->p, value, d->moved[0]));
  if (*verdict == VERDICT_CONVERGED) {
    if (d->sized && PetscIsNanReal(d->stable))
      d->stage.displacement_limit = PART_OF_SIZE * d->size + d->moved[0];
    d->stable = value, d->moved[1] = d->moved[0];
    d->last_stable = *d->p.result;
    PetscCall(SnapshotTake(&d->p, &d->snapshot));
  } else if (*verdict == VERDICT_COLLAPSED) {
    d->failing = value, d->rests = far;
    PetscCall(MechanismTake(&d->p, far ? d->u_start : NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool decided(const Driver *d)
{
  return (PetscBool)(d->p.result->verdict == VERDICT_CONVERGED || d->p.result->verdict == VERDICT_COLLAPSED);
}

/* Returns the failing value or the open one, whichever is nearer to the last stable; NaN: none. */
static PetscReal nearest_end(const Driver *d)
{
  if (PetscIsNanReal(d->failing)) return d->open;
  return PetscAbsReal(d->open - d->stable) < PetscAbsReal(d->failing - d->stable) ? d->open : d->failing;
}

/* Returns the value after `value` between start and limit. */
static PetscReal next_value(const Stage *s, PetscInt trial)
{
  PetscReal value = s->limit;
  if (s->step > 0.)
    value = s->limit > s->start ? PetscMin(s->limit, s->start + trial * s->step)
                                : PetscMax(s->limit, s->start - trial * s->step);
  if (s->kind == STAGE_STRENGTH_REDUCTION && s->factor > 0.)
    value = PetscMax(s->limit, s->start * PetscPowReal(s->factor, (PetscReal)trial));
  return value;
}

/* Chooses the next trial: steps until one fails, then bisection. A trial without a verdict also ends the
   bracket: trials between it and the last stable value may have a verdict. */
static PetscErrorCode next_trial(Driver *d, PetscBool *go)
{
  PetscFunctionBeginUser;
  *go = PETSC_FALSE;
  if (d->p.result->verdict == VERDICT_INTERRUPTED || PetscIsNanReal(d->stable))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!decided(d)) d->open = d->value;
  const PetscReal end = nearest_end(d);
  if (PetscIsNanReal(end)) {
    if (d->stable == d->stage.limit) PetscFunctionReturn(PETSC_SUCCESS);
    d->value = next_value(&d->stage, ++d->trial);
  } else {
    if (!(d->stage.bracket > 0. && PetscAbsReal(d->stable - end) > d->stage.bracket))
      PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(SnapshotRestore(&d->p, &d->snapshot));
    d->value = 0.5 * (d->stable + end);
  }
  *go = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Goes back to the last stable state, with its forces and joints. */
static PetscErrorCode settle(Driver *d, const Joint *full)
{
  PetscFunctionBeginUser;
  set_value(d, full, d->stable);
  PetscCall(SnapshotRestore(&d->p, &d->snapshot));
  PetscCall(Forces(d->p.scene, d->p.m, d->stage.joints, d->p.contacts, d->p.state, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode refuse_start(const Driver *d)
{
  char message[MESSAGE_LENGTH] = "", where[64] = "";
  PetscFunctionBeginUser;
  if (d->stage.line) PetscCall(PetscSNPrintf(where, sizeof(where), ":%d", d->stage.line));
  const char *what = d->stage.kind == STAGE_ANCHOR_FORCE ? " times the prestress" : "";
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                          "%s%s: stages.%s: it does not stand at its start (%.6g%s): %s", d->scene->file,
                          where, d->stage.name, (double)d->stage.start, what, d->p.result->evidence));
  PetscCall(CheckMessage(d->p.m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Describes the bracket, and what it leaves open. */
static void describe_bracket(const Driver *d, size_t size, char *text)
{
  const char *unit = d->stage.kind == STAGE_FLOOD ? " m"
                     : d->stage.kind == STAGE_STRENGTH_REDUCTION && d->stage.what == REDUCE_FRICTION
                         ? " degree"
                     : d->stage.kind == STAGE_ANCHOR_FORCE ? " of the prestress"
                                                           : "";
  char end[96] = "", open[96] = "", limit[96] = "", factor[160];
  const PetscBool stands = (PetscBool)(PetscIsNanReal(d->failing) && PetscIsNanReal(d->open));
  if (!PetscIsNanReal(d->failing))
    snprintf(end, sizeof(end), ", fails at %.8g%s%s", (double)d->failing, unit,
             d->rests ? ", where it rests but beyond displacement_limit" : "");
  else if (stands)
    snprintf(end, sizeof(end), ", the limit; nothing fails");
  if (nearest_end(d) == d->open)
    snprintf(open, sizeof(open), ", no verdict at %.8g%s", (double)d->open, unit);
  if (d->sized)
    snprintf(limit, sizeof(limit), " (displacement_limit %.3g m, 1 %% of the size)",
             (double)d->stage.displacement_limit);
  else if (stands && !(d->stage.displacement_limit < PETSC_INFINITY))
    snprintf(limit, sizeof(limit), " (no displacement_limit: what has found another seat counts as stable)");
  Problem whole = d->p;
  whole.scene = d->scene; // with loads that no factor has raised
  TrialsReport(&whole, sizeof(factor), factor);
  snprintf(text, size, "%d trials: stable at %.8g%s%s%s%s; moved %.3g m since the stage began%s",
           (int)d->p.found->trials.n, (double)d->stable, unit, end, open, factor, (double)d->moved[1], limit);
}

/* Sets the result of the stage: the last stable state with its numbers. Without a failing value a trial
   without a verdict leaves the stage without one; so do an undecided first trial and an interruption. */
static PetscErrorCode conclude(const Driver *d)
{
  StageResult *result = d->p.result;
  const StageResult last = *result;
  char bracket[sizeof(result->evidence)];
  PetscFunctionBeginUser;
  if (last.verdict == VERDICT_INTERRUPTED || PetscIsNanReal(d->stable)) {
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "trial %" PetscInt_FMT " is %s: %.400s", d->p.found->trials.n,
                            VerdictNames[last.verdict], last.evidence));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  describe_bracket(d, sizeof(bracket), bracket);
  *result = d->last_stable;
  if (PetscIsNanReal(d->failing) && !PetscIsNanReal(d->open))
    result->verdict = last.verdict == VERDICT_DIVERGED ? VERDICT_DIVERGED : VERDICT_UNDECIDED;
  PetscCall(PetscStrncpy(result->evidence, bracket, sizeof(result->evidence)));
  if (result->verdict == last.verdict && last.verdict != VERDICT_CONVERGED) {
    PetscCall(PetscStrlcat(result->evidence, ": ", sizeof(result->evidence)));
    PetscCall(PetscStrlcat(result->evidence, last.evidence, sizeof(result->evidence)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Archives the memory of the trials, except the part in Output; see archive.h. */
static PetscErrorCode archive_trials(Archive *a, void *context)
{
  Driver *d = context;
  Snapshot *s = &d->snapshot;
  PetscReal wall = MPI_Wtime() - d->start;
  PetscFunctionBeginUser;
  PetscCall(ArchiveRealMembers(a, "reals", &d->value, &d->stable, &d->failing, &s->alpha, &s->q_ray, &wall,
                               &d->stage.start, &d->open, &d->moved[0], &d->moved[1],
                               &d->stage.displacement_limit));
  PetscCall(
      ArchiveIntMembers(a, "counts", INT_MEMBER(d->trial), INT_MEMBER(d->first_cycle), INT_MEMBER(d->rests)));
  d->start = MPI_Wtime() - wall;
  if (d->has) PetscCall(ArchiveInts(a, "has", d->scene->n_joints, d->has));
  PetscCall(ArchiveEffort(a, &d->p.relax->effort));
  PetscCall(ArchiveApplied(a, d->p.m, "u_start", d->u_start));
  if (a->reading) RigidMotion(d->p.m, d->u_start);
  if (PetscIsNanReal(d->stable)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveResult(a, "last_stable", &d->last_stable));
  PetscCall(SnapshotArchive(a, &d->p, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs start, search and end. full: joints of a reduction before it; NULL: no reduction. */
static PetscErrorCode drive(Driver *d, const Joint *full)
{
  Trials *trials = &d->p.found->trials;
  PetscBool go = PETSC_TRUE, resumed;
  PetscFunctionBeginUser;
  d->p.scene = &d->raised, d->p.stage = &d->stage;
  PetscCall(SnapshotCreate(&d->p, &d->snapshot));
  PetscCall(PetscMalloc1(ModelApplied(d->p.m), &d->u_start));
  PetscCall(PetscArraycpy(d->u_start, d->p.state->u, ModelApplied(d->p.m)));
  d->sized = PetscIsNanReal(d->stage.displacement_limit);
  if (d->sized) PetscCall(FreeSize(&d->p, &d->size));
  d->stable = d->failing = d->open = NAN;
  d->trial = 0, d->value = d->stage.start, d->first_cycle = d->p.state->cycle, d->start = MPI_Wtime();
  PetscCall(CheckpointAttach(d->p.checkpoint, "trials", archive_trials, d, &resumed));
  if (!resumed) PetscCall(TrialsReset(trials));
  while (go) {
    PetscCall(run_trial(d, full));
    d->falls = (PetscBool)(PetscIsNanReal(d->stable) && d->p.result->verdict == VERDICT_COLLAPSED);
    if (d->falls) break;
    PetscCall(next_trial(d, &go));
    if (!go) break;
    StageResult between = {.verdict = VERDICT_NONE};
    PetscCall(CheckpointPoll(d->p.checkpoint, d->p.state->cycle, &between));
    if (between.verdict == VERDICT_NONE) continue;
    *d->p.result = between;
    break;
  }
  PetscCall(CheckpointDetach(d->p.checkpoint));
  if (!PetscIsNanReal(d->stable)) PetscCall(settle(d, full));
  if (!PetscIsNanReal(d->stable) && !PetscIsNanReal(d->failing) && !d->p.m->condensed.leave) {
    PetscCall(WarnOfPaths(&d->p));
    if (d->sized)
      WarnOfShift(&d->p, d->moved[1] + PART_OF_SIZE * d->size - d->stage.displacement_limit, d->size);
  }
  const TermView view = ViewOf(&d->p);
  const PetscBool report = (PetscBool)(d->stage.kind == STAGE_LOAD_FACTOR && !PetscIsNanReal(d->stable));
  if (report) PetscCall(TermsBeforeSummary(&view, PETSC_TRUE)); // of the loads as they are raised
  if (!d->has && !PetscIsNanReal(d->stable)) PetscCall(LoadsTable(&view, &d->p.found->trials.loads));
  trials->stable = d->stable, trials->failing = d->failing, trials->open = d->open,
  trials->moved = d->moved[1], trials->most = d->stage.displacement_limit;
  if (d->has && d->stage.what == REDUCE_FRICTION) {
    PetscCall(reduced_joints(&d->p, d->has));
    PetscCall(TrialsFactors(&d->p, full, d->has));
  }
  if (!d->falls) PetscCall(conclude(d));
  d->p.result->cycles = d->p.state->cycle - d->first_cycle;
  d->p.result->wall = MPI_Wtime() - d->start;
  PetscCall(PetscFree(d->u_start));
  PetscCall(SnapshotDestroy(&d->snapshot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks which rows of the scene have contacts, which the rows themselves do not show. nominal: largest
   friction of these. */
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
  if (d.falls) PetscCall(refuse_start(&d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RaiseRun(const Problem *p)
{
  Driver d = {.scene = p->scene, .p = *p, .stage = *p->stage, .raised = *p->scene};
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(p->scene->n_loads, &d.raised.loads));
  PetscCall(PetscArraycpy(d.raised.loads, p->scene->loads, p->scene->n_loads));
  PetscCall(drive(&d, NULL));
  PetscCall(PetscFree(d.raised.loads));
  if (d.falls) PetscCall(refuse_start(&d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorForceRun(const Problem *p)
{
  Driver d = {.scene = p->scene, .p = *p, .stage = *p->stage, .raised = *p->scene};
  Joint *full;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(p->scene->n_joints, &full));
  PetscCall(PetscArraycpy(full, p->stage->joints, p->scene->n_joints));
  d.stage.what = REDUCE_STRENGTHS;
  reduce_joints(p->scene, &d.stage, full, 1. / p->stage->required);
  PetscCall(drive(&d, full)); // d.stage.joints is p->stage->joints
  PetscCall(PetscFree(full));
  if (d.falls) PetscCall(refuse_start(&d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

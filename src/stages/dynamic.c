/* dynamic.c: runs a stage in time. It has true masses, the central difference of integrate.c with a constant
   mass-proportional damping, supports that move, contacts verified as blocks move, and the energy account. */
#include "stages/loop.h"

enum { VERIFY_EVERY = 8 }; /* steps between checks whether blocks have moved enough to verify contacts */
static const PetscReal PRESSED_THROUGH =
    0.1; /* [-] overlap over contact length that no joint stiffness explains */

/* Memory of the loop in a stage in time. */
typedef struct {
  EnergyAccount energy;
  CoupledInertia *local; /* NULL: not made yet */
  Ground ground;         /* velocity against which alpha damps; at rest: the ground rests */
  StepControl control;
  PetscInt frame;               /* number of the last frame written */
  TimeStep step;                /* how the step was found; empty words after a restart */
  PetscInt64 fault, fault_step; /* first block of this rank that is not finite; step */
} Dynamic;

/* Finds the velocity [m/s] (2,) against which alpha damps at the present time. */
static void ground_now(const Problem *p, const Dynamic *d, PetscReal v[2])
{
  GroundVelocity(&d->ground, p->state->time, v);
}

/* ---- start */

/* Sets the initial velocities of the materials, at the time of the displacements. */
static PetscErrorCode start_velocities(const Scene *scene, const Model *m, State *s)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscReal *centre;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * m->mesh.n_bodies_global, &centre));
  PetscCall(BodyCentres(m, s->u, centre));
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + MOVING_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) {
      const Material *material = scene->materials + list->group[e];
      if (material->velocity[0] == 0. && material->velocity[1] == 0. && material->spin == 0.) continue;
      for (PetscInt k = 0; k < list->n_nodes; k++) {
        const PetscInt v = VertexOf(list, e, k);
        if (v >= m->mesh.n_owned) continue;
        const PetscReal *C = centre + 2 * m->mesh.vertex_body[v];
        if (v < m->mesh.n_deformable) {
          s->v[at + 2 * v] = material->velocity[0] -
                             material->spin * (m->mesh.X[2 * v + 1] + s->u[at + 2 * v + 1] - C[1]);
          s->v[at + 2 * v + 1] = material->velocity[1] +
                                 material->spin * (m->mesh.X[2 * v] + s->u[at + 2 * v] - C[0]);
        } else {
          const PetscInt b = RigidOfVertex(m, v);
          const PetscReal rx = m->rigid.X[2 * b] + s->u[3 * b] - C[0],
                          ry = m->rigid.X[2 * b + 1] + s->u[3 * b + 1] - C[1];
          s->v[3 * b] = material->velocity[0] - material->spin * ry;
          s->v[3 * b + 1] = material->velocity[1] + material->spin * rx;
          s->v[3 * b + 2] = material->spin;
        }
      }
    }
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (Held(m, d)) s->v[d] = 0.;
  PetscCall(PetscFree(centre));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode start(const Problem *p, Dynamic *d)
{
  const Stage *stage = p->stage, *before = StageBefore(p->scene, p->scene->stages + p->number);
  const TermView view = ViewOf(p);
  Model *m = p->m;
  State *s = p->state;
  PetscInt anchors, levels;
  PetscReal factor, v_ground[2];
  PetscFunctionBeginUser;
  if (!before || !StageInTime(before)) {
    PetscCall(PetscArrayzero(s->v, m->n_dof)); // velocities of a static stage are fictitious
    CondensedLoaded(m, s);
    CondensedRest(m, s);
  }
  if (s->time == 0.) PetscCall(start_velocities(p->scene, m, s));
  p->contacts->rate = -1.; // no motion yet that dashpots could damp
  PetscCall(ContactsSetMargin(m, stage->joints, s, 0., p->contacts));
  PetscCall(Forces(p->scene, m, stage->joints, p->contacts, s, NULL));
  if (ContactsVary(p->contacts, stage)) {
    PetscCall(ContactsVerify(p->scene, stage->joints, m, s, p->contacts, p->result));
    PetscCall(Forces(p->scene, m, stage->joints, p->contacts, s, NULL));
  }
  p->contacts->counted = PETSC_FALSE;
  ContactTravelStart(p);
  PetscCall(TermsBegin(&view));
  PetscCall(StepControlFactor(p, &factor, &levels));
  PetscCall(DynamicTimeStep(p->scene, m, stage, p->contacts, factor, s, &d->step)); // of terms, too
  PetscCall(StepControlBegin(p, d->step.dt, levels, &d->control));
  s->alpha = stage->alpha;
  SceneEntries(p->scene, "anchors", &anchors);
  if (anchors) { // includes terms that have just started
    p->contacts->repeats = PETSC_TRUE;
    PetscCall(Forces(p->scene, m, stage->joints, p->contacts, s, NULL));
    p->contacts->repeats = PETSC_FALSE;
  }
  PetscCall(LoadsTarget(p->scene, m, stage, s)); // loads act in full from the first step
  if (LoadsPress(p->scene, stage)) PetscCall(LoadsDead(p->scene, m, stage, s));
  LoadsApply(m, s, 1.);
  CondensedLoaded(m, s);
  ground_now(p, d, v_ground);
  PetscCall(VelocitiesHalfStep(p, d->local, v_ground, -1., &d->energy));
  p->contacts->rate = 1. / s->dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- on the way */

/* Evaluates the forces at the present time, and the work of contacts up to it. */
static PetscErrorCode evaluate(const Problem *p, Dynamic *d)
{
  EnergyAccount *energy = &d->energy;
  State *s = p->state;
  PetscFunctionBeginUser;
  TimerSample(s->cycle);
  StateSwapForces(s);
  s->f_old_clear = PETSC_FALSE;
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, s, NULL));
  PetscCall(StepControlCheck(p, energy, &d->control));
  EnergyOfContacts(p->m, p->contacts, energy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of blocks that moved so far that they may have gone through others between two checks. */
static PetscErrorCode run_over(const Problem *p, PetscReal moved)
{
  PetscReal thinnest = PETSC_MAX_REAL;
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < p->m->faces.n; f++) thinnest = PetscMin(thinnest, p->m->faces.thick[f]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &thinnest, 1, MPIU_REAL, MPI_MIN, p->m->comm));
  if (!(moved > thinnest)) PetscFunctionReturn(PETSC_SUCCESS);
  p->result->verdict = VERDICT_DIVERGED;
  PetscCall(
      PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                    "t = %.6g s: a block has moved %.3g m in %d steps, the thinnest is %.3g m: it may have "
                    "passed through others: the step is too large (%s)",
                    (double)p->state->time, (double)moved, (int)VERIFY_EVERY, (double)thinnest,
                    StepControlRemedy(p->stage)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds contacts again, with their forces, if blocks have moved enough. verified: whether it did. */
static PetscErrorCode verify(const Problem *p, Dynamic *d, PetscBool *verified)
{
  EnergyAccount *energy = &d->energy;
  const Joint *joints = p->stage->joints;
  Model *m = p->m;
  State *s = p->state;
  StageResult *result = p->result;
  PetscReal moved;
  SearchEnergy made;
  PetscFunctionBeginUser;
  PetscCall(ContactsNeedVerify(m, s, verified, &moved));
  if (!*verified) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(run_over(p, moved));
  PetscCall(evaluate(p, d));
  PetscCall(SearchEnergyBegin(p, &made));
  PetscCall(PetscArraycpy(energy->f_before, s->f, m->n_dof));
  PetscCall(JointSlipsCarry(p, 1.));
  PetscCall(ContactsVerify(p->scene, joints, m, s, p->contacts, result));
  p->contacts->repeats = PETSC_TRUE; // without dashpots contacts would lose friction and shear
  PetscCall(Forces(p->scene, m, joints, p->contacts, s, NULL));
  p->contacts->repeats = PETSC_FALSE;
  PetscCall(JointSlipsCarry(p, -1.));
  PetscCall(EnvelopeContactsChanged(p));
  EnergyOfExchange(m, s, energy);
  PetscCall(SearchEnergyEnd(p, &made, &energy->detection));
  PetscCall(EnergyContactsChanged(p->contacts, energy));
  if (result->deepest > PRESSED_THROUGH) {
    result->verdict = VERDICT_DIVERGED;
    PetscCall(PetscSNPrintf(
        result->evidence, sizeof(result->evidence),
        "t = %.6g s: a contact is pressed in by %.2g times what can be, a tenth of its length or "
        "a quarter of the thinner block: the step is too large (%s) or k_n too low",
        (double)s->time, (double)(result->deepest / PRESSED_THROUGH), StepControlRemedy(p->stage)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the applied forces to the displacements of the last evaluation. Water stays normal to its face, and
   as deep as the face is; dead loads keep their direction, but their moments about the centres of rigid
   bodies turn. */
static PetscErrorCode follow_motion(const Problem *p)
{
  State *s = p->state;
  PetscFunctionBeginUser;
  if (LoadsPress(p->scene, p->stage))
    PetscCall(LoadsFollow(p->scene, p->m, p->stage, s));
  else if (s->applied.turn)
    (void)LoadsTurn(p->m, s->u, s->applied.target);
  else
    PetscFunctionReturn(PETSC_SUCCESS);
  LoadsApply(p->m, s, 1.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode change_step(const Problem *p, Dynamic *d, const PetscReal v_ground[2])
{
  StepControl *control = &d->control;
  PetscFunctionBeginUser;
  control->level = control->next, control->stayed = 0, control->changes++;
  const PetscReal dt = ldexp(control->longest, -(int)control->level);
  PetscCall(VelocitiesChange(p, d->local, v_ground, dt, &d->energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Advances to the next time, by the forces just evaluated. */
static PetscErrorCode advance(const Problem *p, Dynamic *d)
{
  EnergyAccount *energy = &d->energy;
  PetscReal v_ground[2];
  const Model *m = p->m;
  State *s = p->state;
  StepWorks works;
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_INTEGRATION));
  PetscCall(follow_motion(p));
  ground_now(p, d, v_ground);
  if (d->control.next != d->control.level) PetscCall(change_step(p, d, v_ground));
  MoveInTime(m, s, v_ground, energy->v_before, energy->f_ext_before, &works);
  TermsAdvance(m, s);
  PetscCall(CoupledStep(d->local, s, energy->v_before, v_ground, 1., energy->local));
  WorksInTime(m, s, v_ground, energy->v_before, &works);
  EnergyOfStep(&works, energy);
  TermsAfterStep(m, s, energy->v_before);
  RigidMotion(m, s->u);
  PetscCall(TimerEnd(TIMER_INTEGRATION));
  s->time += s->dt;
  s->cycle++;
  StepControlAdvance(p, &d->control);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode measure_state(const Problem *p, EnergyAccount *energy, PetscBool first)
{
  const State *s = p->state;
  StageResult *result = p->result;
  PetscReal top[3] = {0., 0., 0.};
  PetscFunctionBeginUser;
  PetscCall(EnergyReport(p, energy, first, &result->energy));
  PetscCall(BodyMotionSample(p->m, s, &p->found->bodies));
  for (PetscInt d = 0; d < p->m->n_dof; d++) {
    if (d < 3 * p->m->rigid.n && d % 3 == 2) continue;
    top[0] = PetscMax(top[0], PetscAbsReal(s->u[d]));
    if (!(PetscAbsReal(s->u[d]) < PETSC_MAX_REAL / 4.)) top[1] = 1.;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, p->m->comm));
  result->displacement = top[0];
  result->kinetic = result->energy.kinetic;
  result->time = s->time - s->dt; // energies belong to the time before the step just made
  result->finite = (PetscBool)(top[1] == 0.);
  if (!result->finite || top[0] > 1e3 * p->m->mesh.diameter) {
    result->verdict = VERDICT_DIVERGED;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "t = %.6g s: displacements are %s: the step is too large (%s)", (double)s->time,
                            result->finite ? "a thousand times the model" : "not finite",
                            StepControlRemedy(p->stage)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Releases supports of quiet boundaries and collects inertias; called again on a new partition. */
static PetscErrorCode prepare(const Problem *p, Dynamic *d)
{
  const TermView view = ViewOf(p);
  char message[MESSAGE_LENGTH] = "", line[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (d->local) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SupportForcesBegin(p));
  PetscCall(SupportsApply(p->scene, PETSC_TRUE, p->m));
  PetscCall(CoupledCreate(&view, d->energy.u_start, &d->local));
  if (p->stage->alpha == 0. || p->stage->frame == FRAME_ABSOLUTE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GroundDestroy(&d->ground));
  PetscCall(GroundCreate(p->scene, &d->ground, message));
  if (message[0])
    PetscCall(PetscSNPrintf(line, sizeof(line), "%s: stages.%s.frame: %s", p->scene->file, p->stage->name,
                            message));
  PetscCall(CheckMessage(p->m->comm, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, Loop *loop)
{
  const Problem *p = loop->p;
  Dynamic *d = loop->memory;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "frame", 1, &d->frame));
  PetscCall(StepControlArchive(a, p, &d->control));
  PetscCall(EnergyArchive(a, p->m, p->contacts, &d->energy));
  PetscCall(ArchiveReals(a, "bodies", BODY_FATES * p->found->bodies.n, p->found->bodies.since));
  PetscCall(RockingHingeArchive(a, &p->found->rocking));
  PetscCall(HistoriesArchive(a, p));
  PetscCall(EnvelopeArchive(a, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode name_fault(const Problem *p, Dynamic *d)
{
  char where[128];
  PetscInt64 first = d->fault_step;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT64, MPI_MIN, p->m->comm));
  if (d->fault < 0) d->fault = FaultFind(p->m, p->state);
  // a rank that met it later has it from a neighbour
  PetscCall(FaultName(p->m, d->fault_step == first ? d->fault : FAULT_NONE, where));
  PetscCall(
      PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                    "t = %.6g s: a force or displacement is not a finite number, first in %s: the step is "
                    "too large (%s)",
                    (double)p->state->time, where, StepControlRemedy(p->stage)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails if blocks with fixed contacts have moved through others, which they do not see. */
static PetscErrorCode passed(const Problem *p)
{
  char message[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  if (ContactsVary(p->contacts, p->stage)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BodiesPassed(p, message));
  if (!message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  p->result->verdict = VERDICT_DIVERGED;
  PetscCall(PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                          "t = %.6g s: %s: connectivity is fixed, bodies pass through each other: use "
                          "contact.connectivity: variable",
                          (double)p->state->time, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool checks(const Loop *loop)
{
  const StepControl *control = &((const Dynamic *)loop->memory)->control;
  const PetscInt64 then = control->done + StepControlTicks(control, control->next),
                   every = control->rows_every * StepControlTicks(control, 0);
  return (PetscBool)(!loop->p->result->cycles || then % every == 0 || then == control->total);
}

static PetscBool over(const Loop *loop)
{
  const StepControl *control = &((const Dynamic *)loop->memory)->control;
  return (PetscBool)(control->done >= control->total);
}

/* Finds the displacements inside condensed bodies; refuses bodies that have turned too far. */
static PetscErrorCode recover(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(CondensedRecover(p->m, p->state));
  PetscCall(CondensedCheckRotation(p->scene, p->m, p->stage, p->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes one step. Frames are written where forces and displacements belong to one time. */
static PetscErrorCode cycle(Loop *loop)
{
  const Problem *p = loop->p;
  const Stage *stage = p->stage;
  Dynamic *d = loop->memory;
  const StepControl *control = &d->control;
  const PetscInt64 i = p->result->cycles;
  PetscBool verified = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(prepare(p, d));
  if (ContactsVary(p->contacts, stage) && i % VERIFY_EVERY == 0) PetscCall(verify(p, d, &verified));
  if (!verified) PetscCall(evaluate(p, d));
  if (d->frame < stage->frames && control->done * (stage->frames + 1) >= control->total * (d->frame + 1)) {
    PetscCall(recover(p));
    PetscCall(passed(p));
    PetscCall(OutputFrame(p, ++d->frame));
  }
  if (loop->checks) PetscCall(EnergyOfBlocks(p, &d->energy));
  if (loop->checks) PetscCall(HistoriesSample(p));
  if (loop->checks) CondensedInertial(p->m, p->state); // for the support reactions
  if (stage->envelope_every && control->done % (control->envelope_every * StepControlTicks(control, 0)) == 0)
    PetscCall(EnvelopeTake(p));
  PetscCall(advance(p, d));
  if (d->fault < 0 && !(d->energy.kinetic < PETSC_MAX_REAL))
    d->fault = FaultFind(p->m, p->state), d->fault_step = i;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode judge(Loop *loop)
{
  const Problem *p = loop->p;
  Dynamic *d = loop->memory;
  PetscReal v_ground[2];
  PetscFunctionBeginUser;
  CoupledBodiesCentred(d->local, p->state, d->energy.local);
  if (d->energy.u_start) ModalTruncation(d->local, p->state, d->energy.u_start, d->energy.local);
  PetscCall(measure_state(p, &d->energy, (PetscBool)(p->result->cycles == 1)));
  GroundVelocity(&d->ground, p->state->time - p->state->dt, v_ground);
  PetscCall(SupportForcesSample(p, d->energy.v_before, v_ground));
  if (!p->result->finite) PetscCall(name_fault(p, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode report(Loop *loop)
{
  PetscFunctionBeginUser;
  PetscCall(OutputHistory(loop->p));
  const StepControl *control = &((const Dynamic *)loop->memory)->control;
  StageShowTime(loop->p, (PetscReal)control->done / (PetscReal)control->total);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode report_steps(Loop *loop)
{
  const Problem *p = loop->p;
  Dynamic *d = loop->memory;
  PetscFunctionBeginUser;
  PetscCall(StepControlDescribe(p, &d->step, &d->control));
  if (p->m->mesh.n_condensed_global) PetscCall(CondensedReportRows(p->m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode begin(Loop *loop)
{
  const Problem *p = loop->p;
  Dynamic *d = loop->memory;
  PetscFunctionBeginUser;
  if (d->energy.u_start) PetscCall(PetscArraycpy(d->energy.u_start, p->state->u, p->m->n_dof));
  PetscCall(prepare(p, d));
  PetscCall(start(p, d));
  PetscCall(EnergyContactsChanged(p->contacts, &d->energy));
  PetscCall(HistoriesBegin(p));
  if (!ContactsVary(p->contacts, p->stage)) PetscCall(BodiesLoose(p));
  PetscCall(report_steps(loop));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Completes the account up to the end of the stage: all checks were some steps earlier. */
static PetscErrorCode close_account(const Problem *p, Dynamic *d)
{
  PetscReal v_ground[2];
  PetscFunctionBeginUser;
  PetscCall(EnergyOfBlocks(p, &d->energy));
  ground_now(p, d, v_ground);
  PetscCall(VelocitiesAccount(p, d->local, v_ground, PETSC_TRUE, NULL, &d->energy));
  CoupledBodiesCentred(d->local, p->state, d->energy.local);
  PetscCall(EnergyReport(p, &d->energy, PETSC_FALSE, &p->result->energy));
  p->result->kinetic = p->result->energy.kinetic;
  p->result->time = p->state->time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode end(Loop *loop)
{
  const Problem *p = loop->p;
  Dynamic *d = loop->memory;
  PetscReal v_ground[2];
  PetscFunctionBeginUser;
  PetscCall(prepare(p, d)); // a restart from the last step makes no other
  p->contacts->rate = -1.;
  PetscCall(evaluate(p, d));
  if (p->result->finite) PetscCall(HistoriesSample(p));
  if (p->result->finite && p->stage->envelope_every) PetscCall(EnvelopeTake(p));
  PetscCall(OutputJointHistory(p));
  PetscCall(follow_motion(p));
  if (p->result->finite) PetscCall(close_account(p, d));
  ground_now(p, d, v_ground);
  PetscCall(VelocitiesHalfStep(p, d->local, v_ground, 1., &d->energy));
  p->state->dt = d->control.longest; // for the summary
  PetscCall(recover(p));
  PetscCall(SupportsApply(p->scene, PETSC_FALSE, p->m)); // as in static stages
  PetscCall(StepControlReport(p, &d->control));
  if (p->result->verdict == VERDICT_NONE) PetscCall(passed(p));
  if (p->result->verdict == VERDICT_NONE) PetscCall(EnergyJudge(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DynamicRun(const Problem *p)
{
  static const LoopKind kind = {.begin = begin,
                                .resume = report_steps,
                                .cycle = cycle,
                                .judge = judge,
                                .report = report,
                                .end = end,
                                .archive = archive,
                                .checks = checks,
                                .over = over};
  Dynamic d = {.fault = -1, .fault_step = PETSC_MAX_INT};
  PetscFunctionBeginUser;
  PetscCall(EnergyCreate(p->m, &d.energy));
  PetscCall(BodyMotionCreate(p->m, &p->found->bodies));
  PetscCall(HistoriesCreate(p, &p->found->histories));
  PetscCall(EnvelopeCreate(p, &p->found->envelope));
  PetscCall(StageLoop(p, &kind, &d));
  PetscCall(EnergyDestroy(&d.energy));
  PetscCall(CoupledDestroy(&d.local));
  PetscCall(StepControlDestroy(&d.control));
  PetscCall(GroundDestroy(&d.ground));
  PetscFunctionReturn(PETSC_SUCCESS);
}

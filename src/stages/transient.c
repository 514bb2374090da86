/* transient.c: runs a transient stage: water in joints flows in time, slowly enough for the blocks to be at
   rest.

   After each step of the water (backward Euler; in pairs, storage.c) the blocks relax to equilibrium, and
   water and openings agree as in a static stage. Without `time_step` a step is so long that pressures change
   by a small part of the largest. Levels follow their files; a step ends at each row of a file. */
#include "stages/stages.h"
#include "scene/reader.h"

typedef struct {
  const Scene *scene; /* the scene of the user */
  Problem p;          /* the step as a problem, with the next two members */
  Stage stage;        /* copy of the stage: water_time and water_step change */
  Scene now;          /* copy of the scene: levels change */
  PetscReal t, next;  /* [s] time since the stage started; length of the next step, from the change of
                         pressure */
  PetscInt64 first_cycle;
  double start; /* [s] of MPI_Wtime */
  PetscReal *u_start;
  PetscInt frame;
  Snapshot before; /* start of the step, from which it is repeated */
  PetscReal least; /* [s] the shortest step to try; 0: none has failed so far */
} Transient;

/* Returns the level [m] of a load at time t. */
static PetscReal level_at(const Load *load, PetscReal t)
{
  return load->levels[0] ? LoadSeries(load, t) : load->level;
}

/* Returns the first time [s] after t that has a row of levels, at most the end of the stage. */
static PetscReal next_row(const Transient *d)
{
  PetscReal end = d->stage.duration;
  for (const Load *load = d->scene->loads; load < d->scene->loads + d->scene->n_loads; load++)
    for (PetscInt i = 0; i < load->n_levels && load->levels[0]; i++)
      if (load->t[i] > d->t * (1. + 1e-12)) end = PetscMin(end, load->t[i]);
  return end;
}

/* Sets up the step that starts at d->t. */
static void set_step(Transient *d)
{
  const PetscReal given = d->stage.time_step, // NaN: none
      wanted = PetscIsNanReal(given) || (d->least > 0. && d->next < given) ? d->next : given,
                  row = next_row(d);
  PetscReal end = d->t + wanted;
  if (end > row - 1e-6 * wanted) end = row; // avoids a very short last step
  d->stage.water_step = end - d->t, d->stage.water_time = end;
  for (PetscInt l = 0; l < d->scene->n_loads; l++) d->now.loads[l].level = level_at(d->scene->loads + l, end);
}

/* Collective. Finds the largest displacement [m] since the stage started. */
static PetscErrorCode find_displacement(const Transient *d, PetscReal *most)
{
  const Model *m = d->p.m;
  const PetscReal *u = d->p.state->u + 3 * m->rigid.n, *from = d->u_start + 3 * m->rigid.n;
  PetscFunctionBeginUser;
  *most = 0.;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++)
    *most = PetscMax(*most, PetscHypotReal(u[2 * v] - from[2 * v], u[2 * v + 1] - from[2 * v + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_transient(Archive *a, void *context)
{
  Transient *d = context;
  PetscReal wall = MPI_Wtime() - d->start;
  PetscFunctionBeginUser;
  PetscCall(ArchiveRealMembers(a, "t_next_end_step_wall", &d->t, &d->next, &d->stage.water_time,
                               &d->stage.water_step, &d->before.alpha, &d->before.q_ray, &d->least, &wall));
  PetscCall(ArchiveIntMembers(a, "counts", INT_MEMBER(d->first_cycle), INT_MEMBER(d->frame)));
  d->start = MPI_Wtime() - wall;
  PetscCall(ArchiveEffort(a, &d->p.relax->effort));
  PetscCall(ArchiveApplied(a, d->p.m, "u_start", d->u_start));
  if (a->reading) RigidMotion(d->p.m, d->u_start);
  PetscCall(SnapshotArchive(a, &d->p, &d->before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a step without an equilibrium is repeated with a shorter length, from its start. Water that
   enters and leaves at once moves blocks far in the first try, and may open or crush joints that a shorter
   step moves little by little. */
static PetscErrorCode try_again(Transient *d, PetscBool *again)
{
  enum {
    SHORTER = 4,
    SHORTEST = 1024
  }; /* divides the step each time; largest division of the first step
                                            that failed */
  const PetscReal step = d->stage.water_step;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  if (d->p.result->verdict == VERDICT_CONVERGED) PetscFunctionReturn(PETSC_SUCCESS);
  if (d->least == 0.) d->least = step / SHORTEST;
  if (step / SHORTER < d->least * (1. - 1e-9)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(d->p.m->comm,
                        "stage %-12s no equilibrium in the step to %.6g s of the water: again, "
                        "%.3g s in place of %.3g s\n",
                        d->stage.name, (double)d->stage.water_time, (double)(step / SHORTER), (double)step));
  PetscCall(SnapshotRestore(&d->p, &d->before));
  d->next = step / SHORTER;
  *again = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the load is a boundary condition of water that flows in joints. */
static PetscBool flows(const Load *load)
{
  return (PetscBool)(load->kind == LOAD_HEAD || load->kind == LOAD_DRAIN || load->kind == LOAD_CURTAIN ||
                     load->kind == LOAD_INFLOW);
}

/* Collective. Relaxes the blocks from the start of the step under its levels, with the steady water, or
   without water in joints. */
static PetscErrorCode relax_otherwise(Transient *d, PetscBool dry)
{
  const Stage wet = d->stage;
  PetscInt *loads;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(wet.n_loads, &loads));
  PetscCall(SnapshotRestore(&d->p, &d->before));
  d->stage.loads = loads, d->stage.n_loads = 0, d->stage.water_step = d->stage.water_time = 0.;
  for (PetscInt i = 0; i < wet.n_loads; i++)
    if (!dry || !flows(d->scene->loads + wet.loads[i])) loads[d->stage.n_loads++] = wet.loads[i];
  PetscCall(StageRelax(&d->p));
  PetscCall(PetscFree(loads));
  d->stage = wet;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts words before the evidence of a result. */
static PetscErrorCode prepend_evidence(StageResult *result, const char *words)
{
  char last[sizeof(result->evidence)];
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(last, result->evidence, sizeof(last)));
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence), "%s (%.150s)", words, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Decides on a step without an equilibrium, however short. Rounds of water and openings can throw
   blocks away with pressures that the water would lose as the joint opens. So blocks are not shown to fall if
   they stand both without water in joints and with the steady water of these levels: the pressures left from
   other levels are lost as joints open. Blocks that fall with the steady water fall. */
static PetscErrorCode decide(Transient *d)
{
  StageResult *result = d->p.result;
  const StageResult found = *result;
  PetscFunctionBeginUser;
  if (found.verdict != VERDICT_COLLAPSED && found.verdict != VERDICT_UNDECIDED)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(relax_otherwise(d, PETSC_FALSE));
  if (result->verdict == VERDICT_COLLAPSED && found.verdict == VERDICT_UNDECIDED) {
    PetscCall(prepend_evidence(result,
                               "water and openings do not agree in this step, and with the water at rest "
                               "at its levels blocks fall"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscBool stands = (PetscBool)(result->verdict == VERDICT_CONVERGED);
  if (stands && found.verdict == VERDICT_COLLAPSED) {
    PetscCall(relax_otherwise(d, PETSC_TRUE));
    stands = (PetscBool)(result->verdict == VERDICT_CONVERGED);
  }
  PetscCall(SnapshotRestore(&d->p, &d->before));
  PetscCall(StageRelax(&d->p)); // the stage shows the step itself
  if (!stands || found.verdict != result->verdict) PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_UNDECIDED;
  PetscCall(prepend_evidence(
      result,
      found.verdict == VERDICT_COLLAPSED
          ? "water and openings do not agree: blocks stand without water in joints, and with the water that "
            "has come to rest at these levels, but the trapped water lifts them in the iteration of water "
            "and openings: neither a collapse nor an equilibrium is found; let the level change in more time"
          : "blocks stand with the water that has come to rest at these levels; let the level change in more "
            "time"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs one step to equilibrium. again: it found none, and is to be repeated with a shorter length. */
static PetscErrorCode run_step(Transient *d, PetscBool *again)
{
  const TermView view = ViewOf(&d->p);
  PetscReal grow, moved;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  set_step(d);
  PetscCall(StageRelax(&d->p));
  if (d->p.result->verdict == VERDICT_INTERRUPTED) PetscFunctionReturn(PETSC_SUCCESS);
  const Verdict relaxed = d->p.result->verdict;
  d->p.result->time = d->stage.water_time;
  PetscCall(TermsStepDone(&view, d->p.result, &grow));
  PetscCall(try_again(d, again));
  if (*again) PetscFunctionReturn(PETSC_SUCCESS);
  if (relaxed != VERDICT_CONVERGED) PetscCall(decide(d));
  d->p.result->time = d->stage.water_time;
  PetscCall(find_displacement(d, &moved));
  PetscCall(OutputTrial(&d->p, d->stage.water_time, moved));
  if (d->p.result->verdict != VERDICT_CONVERGED) PetscFunctionReturn(PETSC_SUCCESS);
  d->t = d->stage.water_time;
  d->next = d->stage.water_step * grow;
  PetscCall(SnapshotTake(&d->p, &d->before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes frames at equal intervals, each after the step that passes its time. */
static PetscErrorCode write_frames(Transient *d)
{
  const PetscInt due = (PetscInt)(d->t / d->stage.duration * (d->stage.frames + 1) + 1e-9);
  PetscFunctionBeginUser;
  if (d->frame >= PetscMin(due, d->stage.frames)) PetscFunctionReturn(PETSC_SUCCESS);
  d->frame = PetscMin(due, d->stage.frames);
  PetscCall(OutputFrame(&d->p, d->frame));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the result of the stage: its last equilibrium, or the step without one. */
static PetscErrorCode conclude(const Transient *d)
{
  StageResult *result = d->p.result;
  char last[sizeof(result->evidence)];
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(last, result->evidence, sizeof(last)));
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                          "%s %.6g s of the water, %" PetscInt_FMT " steps: %.400s",
                          result->verdict == VERDICT_CONVERGED ? "after" : "in the step to",
                          (double)d->stage.water_time, d->p.found->trials.n, last));
  result->cycles = d->p.state->cycle - d->first_cycle;
  result->wall = MPI_Wtime() - d->start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TransientRun(const Problem *p)
{
  enum { FIRST_PART = 1000 }; /* the first step is one part of so many of the duration */
  Transient d = {.scene = p->scene, .p = *p, .stage = *p->stage, .now = *p->scene};
  PetscBool resumed, again;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(p->scene->n_loads, &d.now.loads));
  PetscCall(PetscArraycpy(d.now.loads, p->scene->loads, p->scene->n_loads));
  PetscCall(PetscMalloc1(ModelApplied(p->m), &d.u_start));
  PetscCall(PetscArraycpy(d.u_start, p->state->u, ModelApplied(p->m)));
  d.p.scene = &d.now, d.p.stage = &d.stage;
  d.next = d.stage.duration / FIRST_PART, d.first_cycle = p->state->cycle, d.start = MPI_Wtime();
  PetscCall(SnapshotCreate(&d.p, &d.before));
  PetscCall(SnapshotTake(&d.p, &d.before));
  PetscCall(CheckpointAttach(p->checkpoint, "transient", archive_transient, &d, &resumed));
  if (!resumed) PetscCall(TrialsReset(&p->found->trials));
  while (d.t < d.stage.duration * (1. - 1e-12)) {
    StageResult between = {.verdict = VERDICT_NONE};
    PetscCall(run_step(&d, &again));
    if (again) continue;
    if (p->result->verdict != VERDICT_CONVERGED) break;
    PetscCall(write_frames(&d));
    if (d.t >= d.stage.duration * (1. - 1e-12)) break;
    PetscCall(CheckpointPoll(p->checkpoint, p->state->cycle, &between));
    if (between.verdict == VERDICT_NONE) continue;
    *p->result = between;
    break;
  }
  PetscCall(CheckpointDetach(p->checkpoint));
  PetscCall(conclude(&d));
  const TermView view = ViewOf(&d.p);
  PetscCall(LoadsTable(&view, &p->found->trials.loads));
  PetscCall(SnapshotDestroy(&d.before));
  PetscCall(PetscFree(d.u_start));
  PetscCall(PetscFree(d.now.loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

/* Checks that a transient stage has water that flows and can be stored. */
PetscErrorCode CompleteTransient(Reader *r, const char *path, Stage *stage)
{
  PetscBool given = PETSC_FALSE, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const LoadKind kind = stage->loads[i] < 0 ? LOAD_HEAD : r->scene->loads[stage->loads[i]].kind;
    flows = (PetscBool)(flows || kind == LOAD_HEAD || kind == LOAD_INFLOW || kind == LOAD_DRAIN);
  }
  PetscCall(IsGiven(r, path, "loads", &given));
  if (!flows)
    COMPLAIN(r, "a transient stage needs water that flows in joints: a load of type head, inflow or drain");
  PetscCall(IsGiven(r, path, "type", &given));
  if (r->scene->flow.bulk_modulus >= PETSC_INFINITY) // not the inf of C
    COMPLAIN(r, "a transient stage needs water that stores: flow.bulk_modulus is inf [Pa]");
  if (r->scene->flow.coupling == FLOW_ONE_WAY && stage->connectivity == CONNECTIVITY_VARIABLE)
    COMPLAIN(r, "flow.coupling one_way keeps the joints as they are, but connectivity is variable");
  PetscFunctionReturn(PETSC_SUCCESS);
}

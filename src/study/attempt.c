/* attempt.c: runs a scene in short to measure its cost and its answers. Newton's method, which is short,
   brings its first static stages to equilibrium; then some explicit cycles are timed. Nothing is written.

   The number of cycles follows from the lowest frequency omega. With scaled masses and damping (38) that
   is critical at omega, all motions decay as exp(-omega t), so a stage takes its ramp and
   ln(1/tolerance)/omega cycles. Where contacts slip or open, the frequency is lower than with elastic
   joints, and alpha strays: the cycles grow by LOOSE_FACTOR times the part of such contacts. This fits the
   examples (docs/performance.md) to RANGE. */
#include "study/study.h"

static const PetscReal LOOSE_FACTOR = 4., RANGE = 2.5;
/* The limits of that fit. With more bodies, and more than a few contacts that slip, the upper end is not
   known (20 000 stones took 13 times as many cycles). */
static const PetscReal MOST_BODIES = 1000., FEW_LOOSE = 0.02;
/* The effort of Newton's method, fitted to ten studies (docs/performance.md): force evaluations of a trial,
   solves for each evaluation, how both grow with the number of bodies, and how far a study may be off. */
typedef struct {
  PetscReal evaluations, with_bodies, solves, solves_with_bodies;
} TrialEffort;
static const TrialEffort STANDS = {4.5, 0.12, 1.7, 0.22}, FAILS = {42., 0.2, 6.2, 0.};
static const PetscReal EFFORT_RANGE = 2.5;
static const PetscReal AFFORDABLE = 5e7; /* explicit cycles after Newton's method has failed: blocks plus four
                                            times the contacts, times cycles; some seconds */
static const double TIMED =
    0.001; /* [s] of cycles in a row: long enough for a clock, short enough that some meet no other work */
/* [solves] Limit of Newton's method in a stage: affordable cycles over DEARER, at least LEAST_WORK. */
static const PetscReal DEARER = 3., LEAST_WORK = 300.;
enum { REPEATS = 40, FIRST_CYCLES = 1, DYNAMIC_CYCLES = 50 };

/* Returns the largest processor time [s] of a rank. Other work of the machine does not count in it. A rank
   that waits for another spends processor time, so the slowest rank has the time of a run with a processor
   for each rank. */
static double slowest_rank(MPI_Comm comm, double seconds)
{
  MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, comm);
  return seconds;
}

/* ---- cycles */

/* Measures the time [s] of an explicit cycle from the present state: the least of some repeats. */
static PetscErrorCode time_cycles(const Problem *p, const Stage *stage, double *seconds)
{
  PetscInt n = FIRST_CYCLES;
  PetscFunctionBeginUser;
  PetscCall(ScaledMasses(p->scene, p->m, stage->joints, p->contacts, p->state));
  PetscCall(Forces(p->scene, p->m, stage->joints, p->contacts, p->state, NULL));
  PetscCall(RelaxationStart(p->m, p->contacts, p->state, p->relax));
  *seconds = PETSC_MAX_REAL;
  for (int repeat = 0; repeat < REPEATS;) {
    const double start = ProcessorSeconds();
    for (PetscInt i = 0; i < n; i++)
      PetscCall(Step(p->scene, p->m, stage->joints, p->contacts, p->state, &p->relax->damping, NULL));
    const double taken = slowest_rank(p->m->comm, ProcessorSeconds() - start);
    if (taken < TIMED) {
      n *= 2;
      continue;
    }
    *seconds = PetscMin(*seconds, taken / (double)n);
    repeat++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AttemptContacts(const Model *m, const Contacts *c, PetscInt n[2])
{
  PetscFunctionBeginUser;
  n[0] = n[1] = 0;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscBool real = (PetscBool)(c->owned[i] && c->key[2 * i] >= 0);
    n[0] += real, n[1] += real && (c->state[SUB(i, 0)] || c->state[SUB(i, 1)]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Cost NOTHING = {.effort = {{NAN, NAN, NAN}, {NAN, NAN, NAN}}, .trials = 1.}; /* beside others */
static const Cost UNKNOWN = {NAN, NAN, NAN, {{NAN, NAN, NAN}, {NAN, NAN, NAN}}, NAN, 1.};

/* Returns the cost of `times` relaxations of a stage, each after a ramp of so many cycles. */
static Cost cost_of_relaxations(const Attempt *a, const Stage *stage, PetscReal ramp,
                                const PetscReal times[3])
{
  const PetscReal decay = a->omega > 0. ? (1. + LOOSE_FACTOR * a->loose) *
                                              PetscLogReal(1. / stage->tolerance) / a->omega
                                        : NAN;
  const PetscBool fits = (PetscBool)(a->bodies <= MOST_BODIES || a->loose <= FEW_LOOSE);
  Cost cost = UNKNOWN;
  cost.cycles = times[0] * (ramp + decay);
  cost.least = times[1] * (ramp + decay) / RANGE;
  if (fits) cost.most = times[2] * (ramp + decay) * RANGE;
  cost.trials = times[0];
  return cost;
}

/* Adds the effort of so many trials: [0] force evaluations, [1] solves. */
static void add_trials(const TrialEffort *e, PetscReal trials, PetscReal bodies, PetscReal sum[2])
{
  const PetscReal evaluations = trials * e->evaluations * PetscPowReal(bodies, e->with_bodies);
  sum[0] += evaluations;
  sum[1] += evaluations * e->solves * PetscPowReal(bodies, e->solves_with_bodies);
}

/* Estimates the effort of trials by Newton's method. The likely number assumes that the last of the steps
   fails, and half of the bisections; the least number that all trials up to the limit are stable, or that the
   second one fails. */
static void trial_efforts(const Attempt *a, const PetscReal times[3], PetscReal bisections, PetscReal bodies,
                          Cost *cost)
{
  const PetscReal fail = 1. + 0.5 * bisections;
  PetscReal sum[4][2] = {{0.}};
  for (int i = 0; i < 3; i++) {
    add_trials(&STANDS, PetscMax(0., times[i] - fail), bodies, sum[i]);
    add_trials(&FAILS, fail, bodies, sum[i]);
  }
  add_trials(&STANDS, times[2] - bisections, bodies, sum[3]);
  for (int what = 0; what < 2; what++) {
    cost->effort[what][0] = sum[0][what];
    cost->effort[what][1] = PetscMin(sum[1][what], sum[3][what]) / EFFORT_RANGE;
    cost->effort[what][2] = sum[2][what] * EFFORT_RANGE;
  }
  cost->seconds = (double)(sum[0][0] + sum[0][1]) * a->unit;
}

/* Returns the cost of the trials of a stage: at best the second one fails, at worst the limit is reached;
   bisections are added. */
static Cost cost_of_trials(const Scene *scene, const Attempt *a, PetscReal bodies, const Stage *s)
{
  const PetscReal full = s->what == REDUCE_FRICTION ? ReducedFriction(scene, s, NULL) : 1.,
                  start = PetscIsNanReal(s->start) ? full : s->start, way = PetscAbsReal(s->limit - start);
  PetscReal steps = 1., width = way, bisections = 0.;
  if (s->step > 0.) steps = way / s->step, width = s->step;
  if (s->kind == STAGE_STRENGTH_REDUCTION && s->factor > 0. && s->limit > 0.)
    steps = PetscLogReal(s->limit / start) / PetscLogReal(s->factor), width = 0.5 * start * (1. - s->factor);
  if (s->bracket > 0. && width > s->bracket)
    bisections = PetscCeilReal(PetscLogReal(width / s->bracket) / PetscLogReal(2.));
  const PetscReal least = 2. + bisections, most = 1. + PetscCeilReal(steps) + bisections;
  const PetscReal times[3] = {0.5 * (least + most), least, most};
  Cost cost = cost_of_relaxations(a, s, s->kind == STAGE_STRENGTH_REDUCTION ? 0. : (PetscReal)s->ramp, times);
  if (a->solved && a->unit > 0.) trial_efforts(a, times, bisections, bodies, &cost);
  return cost;
}

/* ---- stages */

/* Takes the cost of a stage that was solved from its effort, which is known. */
static void take_effort(const Effort *e, double seconds, Cost *cost)
{
  for (int i = 0; i < 3; i++)
    cost->effort[0][i] = (PetscReal)e->evaluations, cost->effort[1][i] = (PetscReal)e->solves;
  cost->seconds = seconds;
}

/* Solves the static stages by Newton's method, with the contacts of the start, as long as that is affordable.
   Where it fails, explicit cycles are run to the same limit. */
static PetscErrorCode solve_stages(const Problem *p, Attempt *a)
{
  PetscInt n[2];
  PetscFunctionBeginUser;
  PetscCall(AttemptContacts(p->m, p->contacts, n));
  const PetscReal cycles = 1. + AFFORDABLE / ((PetscReal)p->m->mesh.n_blocks_global + 4. * (PetscReal)n[0]);
  a->solved = (PetscBool)(a->n_solved > 0);
  for (PetscInt s = 0; s < a->n_solved && a->solved; s++) {
    static const PetscReal once[3] = {1., 1., 1.};
    if (!StageRelaxes(p->scene->stages + s)) {
      a->cost[s] = NOTHING;
      continue;
    }
    Stage stage = p->scene->stages[s];
    StageResult result;
    Problem tried = *p;
    const double start = ProcessorSeconds();
    tried.stage = &stage, tried.number = s, tried.result = &result;
    stage.connectivity = CONNECTIVITY_FIXED;
    p->relax->most_work = PetscMax(LEAST_WORK, cycles / DEARER);
    PetscCall(PetscMemzero(&p->relax->spent, sizeof(p->relax->spent)));
    stage.max_cycles = (PetscInt)PetscMin((PetscReal)stage.max_cycles, cycles);
    PetscCall(PetscMemzero(&p->relax->effort, sizeof(p->relax->effort)));
    PetscCall(StageRelax(&tried));
    const double last = slowest_rank(p->m->comm, ProcessorSeconds() - start);
    a->spent = p->relax->spent;
    a->solved = (PetscBool)(result.verdict == VERDICT_CONVERGED);
    PetscCall(AttemptContacts(p->m, p->contacts, n));
    a->loose = (PetscReal)n[1] / (PetscReal)PetscMax(1, n[0]);
    PetscCall(NewtonLowestFrequency(p->m, p->state, p->relax->newton, &a->omega));
    a->cost[s] = cost_of_relaxations(a, &stage, (PetscReal)stage.ramp, once);
    if (!a->solved) { // the stage takes these cycles and more; no frequency tells how many more
      a->cost[s].least = PetscMax((PetscReal)result.cycles, a->omega > 0. ? a->cost[s].least : 0.);
      a->cost[s].cycles = a->cost[s].most = NAN;
    }
    if (a->solved && p->relax->effort.preconditioned) take_effort(&p->relax->effort, last, a->cost + s);
    if (a->solved && p->relax->effort.preconditioned) a->unit = last / (double)EffortWork(&p->relax->effort);
    if (a->solved && p->relax->effort.explicit) // the number is known
      a->cost[s].cycles = a->cost[s].least = a->cost[s].most = (PetscReal)result.cycles;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the time [s] of a step of the first dynamic stage, by some steps that print nothing. */
static PetscErrorCode time_dynamic(const Problem *p, PetscInt s, double *seconds)
{
  FILE *shown = PETSC_STDOUT;
  Stage stage = p->scene->stages[s];
  TimeStep step;
  PetscReal factor;
  PetscInt levels;
  StageResult result;
  Problem tried = *p;
  PetscFunctionBeginUser;
  tried.stage = &stage, tried.number = s, tried.result = &result;
  const TermView view = ViewOf(&tried);
  PETSC_STDOUT = fopen("/dev/null", "w");
  PetscCall(TermsBegin(&view));
  PetscCall(StepControlFactor(&tried, &factor, &levels));
  PetscCall(DynamicTimeStep(p->scene, p->m, &stage, p->contacts, factor, p->state, &step));
  stage.duration = PetscMin(stage.duration, DYNAMIC_CYCLES * step.dt);
  stage.frames = 0;
  const double start = ProcessorSeconds();
  PetscCall(StageRun(&tried));
  *seconds = slowest_rank(p->m->comm, ProcessorSeconds() - start) / (double)PetscMax(1, result.cycles);
  if (PETSC_STDOUT) fclose(PETSC_STDOUT);
  PETSC_STDOUT = shown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the need and the cost of variable connectivity: how far blocks have moved, and the time of a
   search. */
static PetscErrorCode time_search(const Problem *p, const Stage *stage, Attempt *a)
{
  StageResult counts = {.verdict = VERDICT_NONE};
  PetscReal far;
  PetscBool need;
  PetscFunctionBeginUser;
  if (stage->connectivity != CONNECTIVITY_VARIABLE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ContactsNeedVerify(p->m, p->state, &need, &far));
  a->moved = far / (VERIFY_AFTER * p->m->contact_margin);
  PetscCall(Forces(p->scene, p->m, stage->joints, p->contacts, p->state, NULL));
  const double start = ProcessorSeconds();
  PetscCall(ContactsVerify(p->scene, stage->joints, p->m, p->state, p->contacts, &counts));
  a->search = slowest_rank(p->m->comm, ProcessorSeconds() - start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the stages that are not solved: trials, and motion in time, whose longest steps are known. */
static PetscErrorCode estimate_stages(const Problem *p, Attempt *a)
{
  static const PetscReal once[3] = {1., 1., 1.};
  Problem of = *p;
  TimeStep step;
  PetscReal factor;
  PetscInt levels;
  PetscFunctionBeginUser;
  for (PetscInt s = a->n_static; s < p->scene->n_stages; s++) {
    const Stage *stage = p->scene->stages + s;
    if (StageInTime(stage)) {
      if (a->step == 0.) PetscCall(time_dynamic(p, s, &a->step));
      of.stage = stage;
      PetscCall(StepControlFactor(&of, &factor, &levels));
      PetscCall(DynamicTimeStep(p->scene, p->m, stage, p->contacts, factor, p->state, &step));
      const PetscReal steps = PetscCeilReal(stage->duration / step.dt);
      a->cost[s].cycles = StepControlExpected(&of, steps, levels),
      a->cost[s].least = steps; // the rest: unknown
      a->cost[s].most = ldexp(steps, (int)levels - 1);
    } else if (StageEvaluates(stage))
      a->cost[s] = NOTHING;
    else if (stage->kind == STAGE_STATIC)
      a->cost[s] = cost_of_relaxations(a, stage, (PetscReal)stage->ramp, once);
    else
      a->cost[s] = cost_of_trials(p->scene, a, (PetscReal)p->m->mesh.n_bodies_global, stage);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

double AttemptSeconds(const Scene *scene, const Attempt *a, MethodKind method)
{
  double sum = a->condensed;
  for (PetscInt s = 0; s < a->n_stages; s++) {
    const MethodKind used = method == METHOD_AUTO ? a->method[s] : method;
    if (StageRelaxes(scene->stages + s))
      sum += used == METHOD_PRECONDITIONED ? a->cost[s].seconds : a->cost[s].cycles * a->cycle;
  }
  return sum;
}

/* ---- answers */

/* Adds up the end forces [N] of a contact. */
static void resultant(const ContactRow *c, PetscReal F[2])
{
  for (int x = 0; x < 2; x++) F[x] = c->end[0].force[x] + c->end[1].force[x];
}

/* Returns the difference of the contact forces of two stages. Contacts are compared in their order; a
   contact that only one stage has counts in full. */
static PetscReal force_difference(const StageFields *a, const StageFields *b)
{
  PetscReal sum = 0., apart = 0.;
  for (PetscInt i = 0, j = 0; i < a->n_contacts || j < b->n_contacts;) {
    const ContactRow *ca = i < a->n_contacts ? a->contact + i : NULL,
                     *cb = j < b->n_contacts ? b->contact + j : NULL;
    int order = !ca ? 1 : !cb ? -1 : 0;
    for (int k = 0; k < 2 && ca && cb && !order; k++)
      order = (ca->face[k] > cb->face[k]) - (ca->face[k] < cb->face[k]);
    PetscReal Fa[2] = {0., 0.}, Fb[2] = {0., 0.};
    if (ca && order <= 0) resultant(ca, Fa), i++;
    if (cb && order >= 0) resultant(cb, Fb), j++;
    sum += PetscHypotReal(Fb[0], Fb[1]);
    apart += PetscHypotReal(Fa[0] - Fb[0], Fa[1] - Fb[1]);
  }
  return sum > 0. ? apart / sum : 0.;
}

void AttemptDifference(const Attempt *a, const Attempt *b, PetscReal difference[2])
{
  PetscReal most = 0., apart = 0.;
  difference[0] = difference[1] = NAN;
  if (!a->solved || !b->solved) return;
  for (PetscInt v = 0; v < a->mesh.n_vertices; v++) {
    const PetscReal *ua = a->fields.vertex[v].u, *ub = b->fields.vertex[v].u;
    most = PetscMax(most, PetscHypotReal(ub[0], ub[1]));
    apart = PetscMax(apart, PetscHypotReal(ua[0] - ub[0], ua[1] - ub[1]));
  }
  difference[0] = most > 0. ? apart / most : 0.;
  difference[1] = force_difference(&a->fields, &b->fields);
}

/* ---- an attempt */

PetscErrorCode AttemptMeasure(Quoin q, Attempt *a)
{
  Scene *scene;
  Result found = {0};
  Output output = {.lock = -1};
  Problem p = {.found = &found, .output = &output};
  double memory[2];
  PetscBool fits;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(a, sizeof(*a)));
  PetscCall(QuoinGetParts(q, &scene, &p.m, &p.state, &p.contacts, &p.relax));
  p.scene = scene;
  Checkpoint none = {.comm = p.m->comm, .rank = p.m->rank, .scene = scene}; // it catches no signal
  PetscCall(NewtonFits(p.m, PETSC_FALSE, memory, &fits));
  PetscCall(PetscMalloc2(scene->n_stages, &a->cost, scene->n_stages, &a->method));
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    MethodChoice choice = {.given_up = 0};
    PetscCall(StageMethod(scene, p.m, p.contacts, scene->stages + s, a->method + s, &choice));
  }
  scene->method = fits ? METHOD_PRECONDITIONED : METHOD_EXPLICIT;
  scene->checkpoint_minutes = scene->wall_limit = 0.; // so that no checkpoint is due
  scene->checkpoint_every = 0;
  p.checkpoint = output.checkpoint = &none;
  PetscCall(ResultCreate(p.m, &found));
  a->n_stages = scene->n_stages;
  a->bodies = (PetscReal)p.m->mesh.n_bodies_global;
  a->condensed = p.m->condensed.processor;
  while (a->n_static < a->n_stages && !scene->stages[a->n_static].skips &&
         (scene->stages[a->n_static].kind == STAGE_STATIC || StageEvaluates(scene->stages + a->n_static)))
    a->n_static++; // up to the first case that starts from an earlier stage
  a->n_solved = a->n_static;
  if (!a->n_static && !StageInTime(scene->stages + 0)) a->n_solved = 1;
  for (PetscInt s = 0; s < a->n_stages; s++) a->cost[s] = UNKNOWN;
  PetscCall(solve_stages(&p, a));
  const Stage *last = scene->stages + PetscMax(0, a->n_solved - 1);
  PetscCall(CondensedRecover(p.m, p.state));
  PetscCall(GatherMesh(p.m, &a->mesh));
  PetscCall(GatherStage(p.m, p.state, p.contacts, last, &a->mesh, &a->fields));
  if (a->n_solved) {
    PetscCall(time_search(&p, last, a));
    PetscCall(time_cycles(&p, last, &a->cycle));
  }
  PetscCall(estimate_stages(&p, a));
  PetscCall(ResultDestroy(&found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AttemptRun(MPI_Comm comm, const char *scene_file, int argc, char **argv, Attempt *a)
{
  char message[MESSAGE_LENGTH] = "";
  Quoin q;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(a, sizeof(*a)));
  PetscCall(QuoinCreate(comm, &q));
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  PetscErrorCode error = QuoinSetFromOptions(q, scene_file, argc, argv);
  if (!error) error = QuoinSetUp(q);
  PetscCall(PetscPopErrorHandler());
  if (!error)
    PetscCall(AttemptMeasure(q, a));
  else
    PetscCall(PetscStrncpy(a->refused, message, sizeof(a->refused)));
  PetscCall(QuoinDestroy(&q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AttemptDestroy(Attempt *a)
{
  PetscFunctionBeginUser;
  PetscCall(GatherStageDestroy(&a->fields));
  PetscCall(GatherMeshDestroy(&a->mesh));
  PetscCall(PetscFree2(a->cost, a->method));
  PetscFunctionReturn(PETSC_SUCCESS);
}

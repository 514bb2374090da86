/* samples.c: runs one scene many times, with different numbers of joints, loads, anchors and stages.
   They share the mesh, its contacts, the factors of condensed bodies, the elastic factor of Newton's
   method, and the first stages that none of the numbers changes.

   Every sample starts from the state before the first stage that changes, kept in memory as a checkpoint
   would keep it. So a sample is a restart with other options. It takes the steps of a separate run, ends with
   the same bits, and depends on no other sample, whatever their order and whether they fail. A test compares
   the checksums. Samples behind pivots (nearest.c) end with the same verdict, and within the tolerance of the
   stage. */
#include "study/samples.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  Quoin q;
  const char *scene_file;
  int argc; /* arguments of the command line, followed by room for the arguments of the samples */
  char **argv;
  char text[MOST_LINE]; /* of these words */
  SampleTable table;
  Archive kept;   /* the state before stage `first` */
  PetscInt first; /* the first stage that the numbers change */
  PetscBool
      refactors;   /* the elastic factor is made again for each sample, because it depends on the anchors at
                     that time */
  Result found;    /* of the present stage */
  Output output;   /* of stages that write nothing */
  Checkpoint none; /* it writes nothing */
  StageResult result;
  Problem p;             /* the present stage */
  FILE *shown, *dropped; /* PETSC_STDOUT; /dev/null */
  SampleResult before;   /* warnings of the stages that run once */
  Nearest nearest;
  PetscBool is_pivot; /* the present sample */
  PetscInt from;      /* pivot from which it starts, -1: none */
} Sampler;

/* ---- what cannot be shared */

/* Returns why samples cannot run the stages of the scene; NULL: they can. */
static const char *refusal_of(const Scene *scene)
{
  const char *why = NULL;
  if (scene->restart[0]) why = "samples start from the start of the scene, not from a checkpoint";
  if (SceneBuilds(scene)) why = "stages that build groups (build) need a run for each sample";
  if (SceneBranches(scene)) why = "stages that start from another one (from) need a run for each sample";
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++) {
    if (s->connectivity == CONNECTIVITY_VARIABLE)
      why = "contacts that are found again (contact.connectivity) need a run for each sample";
    if (!StageRelaxes(s) || s->kind == STAGE_TRANSIENT)
      why = "stages in time and modes need a run for each sample";
  }
  return why;
}

/* ---- quiet */

/* Adds a warning, unless it is known. */
static void add_warning(const char *text, void *context)
{
  SampleResult *r = context;
  const size_t joint = strlen(WARNING_JOINT), length = strlen(text), used = strlen(r->warned);
  for (const char *w = r->warned; w && *w; w = strstr(w, WARNING_JOINT), w = w ? w + joint : NULL)
    if (!strncmp(w, text, length) && (!w[length] || !strncmp(w + length, WARNING_JOINT, joint))) return;
  r->warnings++;
  if (used + joint + length < sizeof(r->warned))
    snprintf(r->warned + used, sizeof(r->warned) - used, "%s%s", used ? WARNING_JOINT : "", text);
}

/* Keeps lines of stages from the terminal, since they do not show their sample. r: receives the warnings. */
static void be_quiet(Sampler *s, SampleResult *r)
{
  s->shown = PETSC_STDOUT, PETSC_STDOUT = s->dropped;
  WarningsTo(add_warning, r);
}

static void speak(const Sampler *s)
{
  PETSC_STDOUT = s->shown;
  WarningsTo(NULL, NULL);
}

/* ---- a stage, a sample */

/* Reads the bracket of the trials of a stage. */
static void take_bracket(const Sampler *s, SampleResult *r)
{
  const Trials *t = &s->found.trials;
  const Stage *stage = s->p.stage;
  r->stable = r->failing = r->open = r->factor[0] = r->factor[1] = NAN;
  if (!t->n || stage->kind == STAGE_STATIC) return;
  r->stable = t->stable, r->failing = t->failing, r->open = t->open;
  if (stage->kind != STAGE_STRENGTH_REDUCTION) return;
  if (stage->what == REDUCE_STRENGTHS)
    r->factor[0] = 1. / t->stable, r->factor[1] = 1. / t->failing;
  else if (t->joints && t->one >= 0)
    r->factor[0] = t->joints[t->one].stable, r->factor[1] = t->joints[t->one].failing;
}

/* Runs a stage from the present state. falls: its trials fail at their start. */
static PetscErrorCode run_stage(Sampler *s, PetscInt number, char message[MESSAGE_LENGTH], PetscBool *falls)
{
  PetscFunctionBeginUser;
  PetscCall(ResultReset(&s->found));
  s->none = (Checkpoint){.comm = s->p.m->comm, .rank = s->p.m->rank, .scene = s->p.scene};
  s->result = (StageResult){.verdict = VERDICT_NONE};
  s->p.stage = s->p.scene->stages + number, s->p.number = number;
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  const PetscErrorCode error = StageRun(&s->p);
  PetscCall(PetscPopErrorHandler());
  *falls = (PetscBool)(error == PETSC_ERR_USER_INPUT && s->result.verdict == VERDICT_COLLAPSED);
  if (error == PETSC_ERR_USER_INPUT) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!error, PETSC_COMM_SELF, error, "a sample: %s", message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the start of the present sample. */
static PetscErrorCode place(Sampler *s)
{
  const SampleTable *t = &s->table;
  PetscReal x[MOST_COLUMNS];
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (int i = 0; i < t->n_columns; i++)
    if (t->kind[i] == COLUMN_NUMBER) x[n++] = strtod(t->cell[i + 1], NULL);
  s->is_pivot = (PetscBool)!strncmp(t->cell[0], PIVOT, strlen(PIVOT));
  s->from = s->is_pivot ? -1 : NearestOf(&s->nearest, x);
  if (s->is_pivot) PetscCall(NearestAdd(&s->nearest, n, s->p.scene->n_stages, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the stages from the first that changes, until one fails. */
static PetscErrorCode run_stages(Sampler *s, SampleResult *r)
{
  char *paths[MOST_COLUMNS];
  uint64_t terms;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (int i = 0; i < s->table.n_columns; i++)
    if (s->table.kind[i] == COLUMN_ASK) paths[n++] = s->table.column[i];
  r->outcome = "stands";
  for (PetscInt number = s->first; number <= s->table.last && !strcmp(r->outcome, "stands"); number++) {
    PetscBool falls;
    s->p.relax->guess = s->from < 0 ? NULL : s->nearest.u[s->from * s->nearest.n_stages + number];
    PetscCall(run_stage(s, number, r->why, &falls));
    s->p.relax->guess = NULL;
    if (s->is_pivot && s->result.verdict == VERDICT_CONVERGED)
      PetscCall(NearestKeep(&s->nearest, number, s->p.state));
    PetscCall(PetscStrncpy(r->stage, s->p.stage->name, sizeof(r->stage)));
    take_bracket(s, r);
    r->evaluations += s->p.relax->effort.evaluations;
    if (s->result.verdict == VERDICT_CONVERGED && !r->why[0]) continue;
    r->outcome = r->why[0] && !falls                      ? "refused"
                 : s->result.verdict == VERDICT_COLLAPSED ? "fails"
                                                          : "undecided";
    if (!r->why[0])
      PetscCall(PetscSNPrintf(r->why, sizeof(r->why), "%s: %s", VerdictNames[s->result.verdict],
                              s->result.evidence));
  }
  PetscCall(StateChecksumKept(s->p.m, s->p.state, s->p.contacts, &r->checksum));
  PetscCall(StateChecksumTerms(s->p.scene, s->p.m, s->p.state, s->p.contacts, &terms));
  r->checksum += terms;
  PetscReal asked[MOST_COLUMNS];
  if (s->result.verdict == VERDICT_CONVERGED) {
    PetscCall(ResultQuery(&s->p, n, paths, asked));
    for (int i = 0, k = 0; i < s->table.n_columns; i++)
      if (s->table.kind[i] == COLUMN_ASK) r->asked[i] = asked[k++];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the scene the numbers of the present row. refused: they are bad input; message says why. */
static PetscErrorCode take_numbers(Sampler *s, char message[MESSAGE_LENGTH], PetscBool *refused)
{
  const SampleTable *t = &s->table;
  int argc = s->argc;
  char *end = s->text;
  PetscFunctionBeginUser;
  for (int i = 0; i < t->n_columns; i++) {
    const size_t room = sizeof(s->text) - (size_t)(end - s->text);
    if (t->kind[i] != COLUMN_NUMBER) continue;
    snprintf(end, room, "-%s", t->column[i]);
    for (char *c = end; *c; c++) *c = *c == '.' ? '_' : *c;
    s->argv[argc++] = end;
    s->argv[argc++] = t->cell[i + 1];
    end += PetscMin(room - 1, strlen(end) + 1);
  }
  WarningsReset();
  PetscCall(PetscPushErrorHandler(KeepMessage, message));
  const PetscErrorCode error = QuoinTakeNumbers(s->q, s->scene_file, argc, s->argv);
  PetscCall(PetscPopErrorHandler());
  *refused = (PetscBool)(error == PETSC_ERR_USER_INPUT);
  PetscCheck(!error || *refused, PETSC_COMM_SELF, error, "a sample: %s", message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the loads on faces of a stage, with the numbers of the present row. */
static PetscErrorCode list_loads(Sampler *s, SampleResult *r)
{
  const SampleTable *t = &s->table;
  const Scene *scene = s->p.scene;
  const char *name = t->cell[t->loads + 1], *cell = t->rise < 0 ? "0" : t->cell[t->rise + 1];
  char *end;
  const PetscReal rise = strtod(cell, &end);
  Scene raised = *scene; // loads of floods rise
  PetscInt number = 0;
  PetscFunctionBeginUser;
  while (number < scene->n_stages && strcmp(scene->stages[number].name, name) != 0) number++;
  if (number == scene->n_stages) {
    PetscCall(PetscSNPrintf(r->why, sizeof(r->why), "loads: no stage named '%s'", name));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (end == cell || *end || !isfinite(rise)) {
    PetscCall(PetscSNPrintf(r->why, sizeof(r->why), "rise: '%s' is not a number [m]", cell));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Stage *stage = scene->stages + number;
  PetscCall(PetscMalloc1(scene->n_loads, &raised.loads));
  PetscCall(PetscArraycpy(raised.loads, scene->loads, scene->n_loads));
  r->flood = stage->kind == STAGE_FLOOD ? stage : NULL;
  if (r->flood) FloodRaise(scene, stage, rise, raised.loads);
  const TermView view = {
      .scene = &raised, .stage = stage, .m = s->p.m, .contacts = s->p.contacts, .state = s->p.state};
  PetscCall(LoadsTable(&view, &r->loads));
  LoadsNumberFaces(&s->found.mesh, &r->loads);
  r->outcome = "asked";
  PetscCall(PetscFree(raised.loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode run_sample(Sampler *s, SampleResult *r)
{
  const double start = ProcessorSeconds();
  PetscBool refused = PETSC_FALSE;
  PetscFunctionBeginUser;
  *r = (SampleResult){.outcome = "refused", .stable = NAN, .failing = NAN, .open = NAN, .factor = {NAN, NAN}};
  for (int i = 0; i < s->table.n_columns; i++) r->asked[i] = NAN;
  r->warnings = s->before.warnings;
  PetscCall(PetscStrncpy(r->warned, s->before.warned, sizeof(r->warned)));
  be_quiet(s, r);
  if (s->table.loads < 0 || s->table.numbers) PetscCall(take_numbers(s, r->why, &refused));
  if (!refused && s->table.loads >= 0) {
    PetscCall(list_loads(s, r));
  } else if (!refused) {
    WarnAgain(s->p.scene);
    PetscCall(QuoinGoBack(s->q, &s->kept));
    if (s->refactors) PetscCall(NewtonDestroy(&s->p.relax->newton));
    PetscCall(place(s));
    PetscCall(run_stages(s, r));
  }
  speak(s);
  r->seconds = ProcessorSeconds() - start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what they share */

/* Keeps the state before the first stage that the numbers change. Earlier stages run once; if one of them
   fails, all samples run it. */
static PetscErrorCode share(Sampler *s)
{
  const SampleTable *t = &s->table;
  const Scene *scene = s->p.scene;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  PetscCall(QuoinKeep(s->q, &s->kept));
  PetscInt first = t->last, n_anchors;
  SceneEntries(scene, "anchors", &n_anchors);
  s->refactors = (PetscBool)(n_anchors > 0);
  if (s->refactors) first = 0;
  for (int i = 0; i < t->n_columns; i++)
    if (t->kind[i] == COLUMN_NUMBER) first = PetscMin(first, SceneVaries(scene, t->column[i]));
  s->found.joints_only = PETSC_TRUE;
  for (int i = 0; i < t->n_columns; i++)
    if (t->kind[i] == COLUMN_ASK && ResultQueryBeyondJoints(1, &t->column[i]))
      s->found.joints_only = PETSC_FALSE;
  be_quiet(s, &s->before);
  for (PetscInt number = 0; number < first && !message[0]; number++) {
    PetscBool falls;
    PetscCall(run_stage(s, number, message, &falls));
    if (message[0] || s->result.verdict != VERDICT_CONVERGED) break;
    s->first = number + 1;
    PetscCall(QuoinKeep(s->q, &s->kept));
  }
  speak(s);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode run_table(Sampler *s)
{
  char message[MESSAGE_LENGTH] = "";
  const PetscBool streams = (PetscBool)(s->table.lock < 0);
  PetscInt n = 0, fails = 0, undecided = 0;
  const double start = MPI_Wtime();
  PetscFunctionBeginUser;
  for (PetscBool more;; n++) {
    SampleResult r;
    PetscCall(SampleTableNext(&s->table, &more, message));
    PetscCall(CheckMessage(s->p.m->comm, message));
    if (!more) break;
    PetscCall(run_sample(s, &r));
    PetscCall(SampleTableAdd(&s->table, &r, message));
    for (PetscInt c = 0; c < r.loads.n_columns; c++) PetscCall(PetscFree(r.loads.columns[c].values));
    PetscCall(Refuse(s->p.m->comm, ERROR_OUTPUT, message));
    fails += !strcmp(r.outcome, "fails"), undecided += !strcmp(r.outcome, "undecided");
  }
  if (!streams)
    PetscCall(PetscPrintf(s->p.m->comm,
                          "%" PetscInt_FMT " samples in %.2f s: %" PetscInt_FMT " fail, %" PetscInt_FMT
                          " undecided; stages before %s ran once\n",
                          n, MPI_Wtime() - start, fails, undecided, s->p.scene->stages[s->first].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the words of the command line, with room behind them. */
static PetscErrorCode take_words(int argc, char **argv, Sampler *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((size_t)argc + 2 * MOST_COLUMNS + 1, &s->argv));
  for (int i = 0; i < argc; i++) s->argv[i] = argv[i];
  s->argc = argc;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Samples(Quoin q, const char *scene_file, int argc, char **argv, PetscBool *done)
{
  char message[MESSAGE_LENGTH] = "";
  Sampler *s;
  Scene *scene;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  *s = (Sampler){.q = q, .scene_file = scene_file, .output = {.lock = -1}};
  PetscCall(QuoinGetParts(q, &scene, &s->p.m, &s->p.state, &s->p.contacts, &s->p.relax));
  *done = (PetscBool)(scene->samples[0] != '\0');
  if (!*done) {
    PetscCall(PetscFree(s));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  s->p.scene = scene, s->p.found = &s->found, s->p.output = &s->output, s->p.result = &s->result;
  s->p.checkpoint = s->output.checkpoint = &s->none;
  SignalsRelease();
  if (s->p.m->size > 1)
    snprintf(message, sizeof(message),
             "%.500s: samples: samples run on one rank each: start several processes, each with a table",
             scene->file);
  PetscCall(CheckMessage(s->p.m->comm, message));
  PetscCall(SampleTableOpen(scene, QuoinNumber(q), refusal_of(scene), &s->table, message));
  if (!strncmp(message, "output:", strlen("output:"))) PetscCall(Refuse(s->p.m->comm, ERROR_OUTPUT, message));
  PetscCall(CheckMessage(s->p.m->comm, message));
  PetscCall(take_words(argc, argv, s));
  PetscCall(ResultCreate(s->p.m, &s->found));
  PetscCall(PetscCalloc1(scene->n_stages, &s->output.stages));
  PetscCall(GatherMesh(s->p.m, &s->found.mesh));
  PetscCall(ArchiveCreate(s->p.m->comm, &s->kept));
  s->dropped = fopen("/dev/null", "w");
  PetscCheck(s->dropped, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "/dev/null: %s", strerror(errno));
  if (s->table.loads < 0) PetscCall(share(s));
  PetscCall(run_table(s));
  PetscCall(SampleTableClose(&s->table, message));
  PetscCall(Refuse(s->p.m->comm, ERROR_OUTPUT, message));
  PetscCall(OutputDropTrials(&s->output));
  PetscCall(ArchiveDestroy(&s->kept));
  PetscCall(NearestDestroy(&s->nearest));
  PetscCall(ResultDestroy(&s->found));
  fclose(s->dropped);
  PetscCall(PetscFree(s->output.stages));
  PetscCall(PetscFree(s->argv));
  PetscCall(PetscFree(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

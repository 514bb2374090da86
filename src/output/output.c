/* output.c: manages the output folder: history.csv while the run goes on; results.h5, results.xdmf and
   summary.json at the end of each stage. Files are written as <name>.part and get their name when they are
   complete. */
#include "output/output.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Writes scene_echo.yaml, the input beside the results. */
static void write_echo(const char *folder, const Scene *scene, char message[MESSAGE_LENGTH])
{
  FILE *f = PartOpen(folder, "scene_echo.yaml", message);
  if (f) fputs(scene->echo, f);
  if (f && scene->solvers) fprintf(f, "# options of PETSc's solvers: %s\n", scene->solvers);
  if (f) PartFinish(f, folder, "scene_echo.yaml", message);
}

/* ---- what a checkpoint keeps of it, see archive.h */

typedef struct {
  const Scene *scene;
  const Model *model;
  Output *output;
} Memory;

/* Rank 0. Returns whether the histories have their final names. */
static PetscBool named(const Output *o)
{
  return (PetscBool)(o->n_stages > 0);
}

static void check_histories(const Output *o, char message[MESSAGE_LENGTH])
{
  for (int i = 0; i < HISTORY_FILES; i++) HistoryCheck(o->files + i, o->folder, named(o), message);
}

/* Rank 0. Flushes the histories to the disk. */
static void settle_histories(Output *o, char message[MESSAGE_LENGTH])
{
  for (int i = 0; i < HISTORY_FILES; i++) HistorySettle(o->files + i, o->folder, named(o), message);
}

/* Rank 0. Gives the files of all finished stages their names. */
static PetscErrorCode settle(const Scene *scene, const Model *model, Output *o, char message[MESSAGE_LENGTH])
{
  const double start = MPI_Wtime();
  PetscFunctionBeginUser;
  ResultsFileFinish(&o->results, o->n_stages - 1, message);
  for (int i = 0; i < HISTORY_FILES && !o->n_settled; i++) HistoryName(o->files + i, o->folder, message);
  if (!o->n_settled) HistoriesDrop(o->files, o->folder);
  check_histories(o, message);
  settle_histories(o, message);
  PetscCall(SummaryWrite(scene, model, o, message));
  o->n_settled = o->n_stages;
  o->settle_wall = MPI_Wtime() - start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_texts(Archive *a, const char *name, PetscInt n, char ***texts)
{
  char label[NAME_LENGTH];
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n && !a->rank; i++) {
    PetscCall(PetscSNPrintf(label, sizeof(label), "%s_%" PetscInt_FMT, name, i));
    PetscCall(ArchiveText(a, label, *texts + i));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Archives the grids of results.xdmf: their text, and the stage or frame of each piece. n: the same on all
   ranks. Refuses pieces that do not make up the text. */
static PetscErrorCode archive_grids(Archive *a, const Scene *scene, PetscInt n, ResultsFile *results)
{
  PetscInt64 *rows, length = 0;
  PetscFunctionBeginUser;
  PetscCall(ArchiveText(a, "xdmf", &results->xdmf));
  PetscCall(PetscCalloc1(3 * n, &rows));
  if (n && !a->reading && !a->rank) memcpy(rows, results->grids, sizeof(*rows) * 3 * (size_t)n);
  PetscCall(ArchiveCounts(a, "grids", 3 * n, rows));
  if (a->reading && !a->rank) {
    for (PetscInt i = 0; i < n; i++) {
      (void)ArchiveWithin(a, "grids", rows[3 * i], 0, scene->n_stages - 1);
      length += ArchiveWithin(a, "grids", rows[3 * i + 2], 0, PETSC_MAX_INT);
    }
    (void)ArchiveWithin(a, "grids", length, 0, results->xdmf ? (PetscInt64)strlen(results->xdmf) : 0);
    free(results->grids);
    results->grids = malloc(sizeof(*results->grids) * (size_t)(n + 1));
    PetscCheck(results->grids, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the grids of results.xdmf");
    if (n) memcpy(results->grids, rows, sizeof(*rows) * 3 * (size_t)n);
    results->n_grids = n;
  }
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_output(Archive *a, void *context)
{
  Memory *memory = context;
  Output *o = memory->output;
  Trials *t = &o->found->trials;
  const PetscBool waiting = (PetscBool)(!a->reading && !a->rank && o->n_settled < o->n_stages);
  PetscFunctionBeginUser;
  if (waiting)
    PetscCall(settle(memory->scene, memory->model, o, a->message));
  else if (!a->reading && !a->rank)
    settle_histories(o, a->message);
  const PetscInt64 written = a->rank ? 0 : (PetscInt64)o->results.choice;
  PetscInt64 counts[] = {o->n_stages,
                         o->results.n_frames,
                         t->n,
                         t->mechanism != NULL,
                         written,
                         (PetscInt64)o->results.run,
                         o->n_contacts,
                         o->n_dofs,
                         a->rank ? 0 : o->results.n_grids};
  PetscCall(ArchiveCounts(a, "counts", 9, counts));
  PetscCall(HistoryFilesArchive(a, o->files));
  if (a->reading) {
    if (!a->rank && counts[4] != written)
      snprintf(a->message, MESSAGE_LENGTH,
               "its results leave out other groups (materials.<name>.output) than the scene");
    const ArchiveEntry *grids = a->rank ? NULL : ArchiveFind(a, "output/grids");
    PetscInt most[2] = {a->n, grids ? (PetscInt)grids->rows / 3 : 0}; // each trial has a text
    PetscCallMPI(MPI_Bcast(most, 2, MPIU_INT, 0, a->comm));
    counts[0] = ArchiveWithin(a, "stages", counts[0], 0, memory->scene->n_stages);
    counts[1] = ArchiveWithin(a, "frames", counts[1], 0, PETSC_MAX_INT);
    counts[2] = ArchiveWithin(a, "trials", counts[2], 0, most[0]);
    counts[8] = ArchiveWithin(a, "grids", counts[8], 0, most[1]);
    if (!a->rank) o->n_stages = o->n_settled = (PetscInt)counts[0], o->results.n_frames = (PetscInt)counts[1];
    o->results.origin = (uint64_t)counts[5];
    o->results.run = CheckpointGoesOn(o->checkpoint, o->results.origin);
    t->n = (PetscInt)counts[2];
    if (!a->rank) o->n_trials = t->n;
    o->n_contacts = (PetscInt)counts[6], o->n_dofs = (PetscInt)counts[7];
    if (!a->rank) PetscCall(PetscCalloc1((size_t)t->n, &o->trials));
    if (counts[3]) {
      PetscCall(PetscMalloc1(PetscMax(1, 2 * memory->model->mesh.n_owned), &t->mechanism));
      PetscCall(PetscMalloc1(2 * memory->scene->n_joints, &t->joint_motion));
    }
  }
  PetscCall(ArchiveInts(a, "by_factor", (PetscInt)counts[0], o->by_factor)); // of the stages that have ended
  PetscCall(archive_texts(a, "stage", o->n_stages, &o->stages));
  PetscCall(archive_texts(a, "trial", t->n, &o->trials));
  PetscCall(archive_grids(a, memory->scene, (PetscInt)counts[8], &o->results));
  if (counts[3]) {
    PetscCall(ArchiveVertices(a, memory->model, "mechanism", t->mechanism));
    PetscCall(ArchiveReals(a, "joint_motion", 2 * memory->scene->n_joints, t->joint_motion));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Does the same as CheckpointRefuse. The buffers of histories cannot be written either, and
   PETSc would fail over them at the end, so they are dropped. */
static PetscErrorCode refuse(Output *o, const char *message)
{
  char dropped[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (int i = 0; i < HISTORY_FILES && message[0]; i++) HistoryClose(o->files + i, o->folder, dropped);
  PetscCall(CheckpointRefuse(o->checkpoint, ERROR_OUTPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the mesh while a file is being written, and which of it is */

static PetscErrorCode open_mesh(const Scene *scene, const Model *model, Output *o)
{
  PetscFunctionBeginUser;
  PetscCall(GatherMesh(model, &o->found->mesh));
  if (!model->rank) PetscCall(OutputSelectionCreate(scene, &o->found->mesh, &o->results.written));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode close_mesh(Output *o)
{
  PetscFunctionBeginUser;
  PetscCall(OutputSelectionDestroy(&o->results.written));
  PetscCall(GatherMeshDestroy(&o->found->mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- opening */

/* Rank 0. Computes the checksum of the program. */
static uint64_t checksum_of_program(void)
{
  static const char program[] = "/proc/self/exe"; // of Linux
  struct stat status;
  uint64_t sum = 0;
  if (!stat(program, &status)) (void)FileChecksum(program, (size_t)status.st_size, &sum);
  return sum;
}

/* Rank 0. Opens new histories and results.h5.part, or the files of the run that is continued. */
static PetscErrorCode open_files(const Scene *scene, const Model *model, Output *o, PetscBool resumed,
                                 char message[MESSAGE_LENGTH])
{
  PetscBool created[HISTORY_FILES] = {PETSC_FALSE}, any = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (resumed)
    PetscCall(ResultsFileResume(&o->results, o->n_stages, message));
  else
    PetscCall(ResultsFileCreate(&o->results, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  write_echo(o->folder, scene, message);
  MotionsWrite(scene, o->folder, message);
  for (int i = 0; i < HISTORY_FILES; i++) {
    if (o->files[i].name) created[i] = HistoryOpen(o->files + i, o->folder, named(o), resumed, message);
    any = (PetscBool)(any || created[i]);
  }
  if (created[HISTORY]) HistoryHeader(o->files[HISTORY].file, scene, model, o->found);
  if (created[JOINT_HISTORY]) JointHistoryHeader(o->files[JOINT_HISTORY].file);
  if (created[TERM_HISTORY]) TermHistoryHeader(o->files[TERM_HISTORY].file);
  check_histories(o, message);
  if (resumed && o->n_settled && any) { // no later stage may write it
    settle_histories(o, message);
    PetscCall(SummaryWrite(scene, model, o, message));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputLock(MPI_Comm comm, const Scene *scene, Output *output)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(output, sizeof(*output)));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscStrncpy(output->folder, scene->output, sizeof(output->folder)));
  output->lock = -1;
  if (!rank && !FolderMake(output->folder, message)) output->lock = FolderLock(output->folder, message);
  int taken = output->lock == FOLDER_TAKEN;
  PetscCallMPI(MPI_Bcast(&taken, 1, MPI_INT, 0, comm));
  PetscCall(Refuse(comm, taken ? ERROR_LOCKED : ERROR_OUTPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputOpen(const Scene *scene, const Model *model, struct _p_Checkpoint *checkpoint,
                          Result *found, Output *output)
{
  char message[MESSAGE_LENGTH] = "";
  Memory *memory;
  PetscBool resumed;
  PetscFunctionBeginUser;
  output->checkpoint = checkpoint, output->found = found;
  PetscCall(ResultCreate(model, found));
  PetscCall(PetscCalloc1(PetscMax(1, scene->n_stages), &output->by_factor));
  output->results = (ResultsFile){.folder = output->folder, .scene = scene, .model = model};
  HistoriesName(scene, output->files);
  PetscCall(GroundCreate(scene, &found->ground, message));
  found->ground_moves = (PetscBool)(SceneInTime(scene) && !message[0] && MotionMoves(&found->ground.motion));
  message[0] = '\0'; // without a common motion of the supports there is no ground as reference
  PetscCall(open_mesh(scene, model, output));
  if (!model->rank) {
    PetscCall(PetscCalloc1(PetscMax(1, scene->n_stages), &output->stages));
    output->results.stages = output->stages;
    output->program_checksum = checksum_of_program();
    output->results.choice = OutputSelectionChecksum(&output->results.written);
    output->results.run = output->results.origin = CheckpointRun(checkpoint);
  }
  PetscCall(PetscNew(&memory));
  output->memory = memory;
  *memory = (Memory){scene, model, output};
  PetscCall(CheckpointAttach(checkpoint, "output", archive_output, memory, &resumed));
  if (!model->rank && resumed) PetscCall(ResultsFileCheck(&output->results, output->n_stages, message));
  PetscCall(Refuse(model->comm, ERROR_CHECKPOINT, message));
  if (!model->rank) PetscCall(open_files(scene, model, output, resumed, message));
  PetscCall(close_mesh(output)); // frees arrays, a few bytes a block, that only output reads
  PetscCall(refuse(output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputHistory(const Problem *p)
{
  char message[MESSAGE_LENGTH] = "";
  PetscReal u_max;
  PetscFunctionBeginUser;
  PetscCall(ResultProbes(p, &u_max));
  HistoriesOfProbes(p);
  if (p->output->files[HISTORY].file) {
    HistoryRow(p, u_max);
    JointHistoryRows(p);
    TermHistoryRows(p);
    check_histories(p->output, message);
  }
  PetscCall(refuse(p->output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputJointHistory(const Problem *p)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (!p->m->rank) {
    JointHistoryRows(p);
    TermHistoryRows(p);
    check_histories(p->output, message);
  }
  PetscCall(refuse(p->output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time [s]: of stages in time so far, and of the water since a transient stage started. */
static PetscReal time_of(const Problem *p)
{
  return p->state->time + (p->stage->kind == STAGE_TRANSIENT ? p->result->time : 0.);
}

PetscErrorCode OutputFrame(const Problem *p, PetscInt frame)
{
  const TermView view = ViewOf(p);
  Output *output = p->output;
  char message[MESSAGE_LENGTH] = "";
  StageFields fields;
  PetscFunctionBeginUser;
  PetscCall(open_mesh(p->scene, p->m, output));
  PetscCall(GatherStage(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
  fields.time = time_of(p);
  PetscCall(TermsBeforeSummary(&view, PETSC_FALSE));
  if (!p->m->rank && output->n_settled < output->n_stages) PetscCall(settle(p->scene, p->m, output, message));
  if (!p->m->rank) {
    PetscCall(TermsTables(&view, NULL, &fields.n_tables, &fields.tables));
    PetscCall(ResultsFileFrame(&output->results, p->number, frame, p->result, &fields, message));
    PetscCall(TermsTablesDestroy(&fields.n_tables, &fields.tables));
  }
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(close_mesh(output));
  PetscCall(refuse(output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Decides whether to write the files. Files that contain all stages so far, and the checkpoint, are
   written whole; to write them at the end of each of many short stages would cost the square of their number.
   So stages wait while they are few beside the earlier ones, and while they have run for less time than the
   files take. */
static PetscBool settle_now(const Problem *p)
{
  enum { FEW = 16 };
  const Output *o = p->output;
  const Checkpoint *c = o->checkpoint;
  const PetscInt waiting = o->n_stages - o->n_settled;
  const PetscBool last = (PetscBool)(p->number + 1 == p->scene->n_stages ||
                                     (p->result->verdict != VERDICT_CONVERGED &&
                                      p->result->verdict != VERDICT_COMPLETED));
  return (PetscBool)(last || o->results.n_frames || FEW * waiting >= o->n_stages ||
                     MPI_Wtime() - c->last_wall >= o->settle_wall + c->write_wall);
}

void LoadsNumberFaces(const MeshFields *mesh, TermTable *loads)
{
  for (PetscInt i = 0; i < loads->n_rows; i++) {
    PetscReal *block = loads->columns[1].values + 2 * i;
    *block = mesh->file[(PetscInt)*block];
  }
}

PetscErrorCode OutputStage(const Problem *p)
{
  const TermView view = ViewOf(p);
  Output *output = p->output;
  char message[MESSAGE_LENGTH] = "";
  StageFields fields;
  Json json;
  PetscReal u_max;
  uint64_t checksum[2], terms;
  PetscFunctionBeginUser;
  PetscCall(ResultProbes(p, &u_max));
  PetscCall(StateChecksum(p->m, p->state, p->contacts, checksum));
  PetscCall(StateChecksumKept(p->m, p->state, p->contacts, checksum + 1));
  PetscCall(StateChecksumTerms(p->scene, p->m, p->state, p->contacts, &terms));
  checksum[0] += terms, checksum[1] += terms;
  output->by_factor[p->number] = SummaryByFactor(p);
  PetscCall(open_mesh(p->scene, p->m, output));
  PetscCall(GatherStage(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
  fields.time = time_of(p);
  if (p->found->trials.mechanism) // on all ranks, or on none
    PetscCall(GatherVertices(p->m, 2, p->found->trials.mechanism, &fields.mechanism));
  fields.n_modes = p->found->vibration.n;
  if (fields.n_modes)
    PetscCall(GatherVertices(p->m, 2 * fields.n_modes, p->found->vibration.shape, &fields.modes));
  PetscCall(EnvelopeGather(p, &fields));
  PetscCall(TermsBeforeSummary(
      &view, (PetscBool)((p->result->verdict == VERDICT_CONVERGED ||
                          (p->result->verdict == VERDICT_COMPLETED && StageInTime(p->stage))) &&
                         p->stage->kind != STAGE_LOAD_FACTOR))); // which has reported itself
  if (!StageInTime(p->stage)) PetscCall(TermHistorySample(p));
  if (!p->found->trials.loads.name) PetscCall(LoadsTable(&view, &p->found->trials.loads));
  if (!p->m->rank) {
    TermHistoryRows(p);
    PetscCall(SafetyFields(p->scene, &p->found->mesh, &fields));
    LoadsNumberFaces(&p->found->mesh, &p->found->trials.loads);
    PetscCall(TermsTables(&view, &p->found->trials.loads, &fields.n_tables, &fields.tables));
    PetscCall(ResultsFileStage(&output->results, p->number, p->result, checksum[0], &fields));
    PetscCall(JsonToMemory(&json, 2, &output->stages[output->n_stages++]));
    PetscCall(SummaryStage(&json, p, &fields, checksum));
    PetscCall(JsonEnd(&json));
    PetscCall(TermsTablesDestroy(&fields.n_tables, &fields.tables));
    output->n_contacts = fields.n_contacts, output->n_dofs = fields.n_dof;
    output->settled = settle_now(p);
    if (output->settled) PetscCall(settle(p->scene, p->m, output, message));
  }
  PetscCallMPI(MPI_Bcast(&output->settled, 1, MPI_PETSC_BOOL, 0, p->m->comm));
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(close_mesh(output));
  PetscCall(ResultReset(p->found));
  PetscCall(OutputDropTrials(output));
  PetscCall(refuse(output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void OutputPass(Output *output)
{
  if (output->stages) output->stages[output->n_stages++] = NULL;
}

PetscErrorCode OutputSettle(const Scene *scene, const Model *model, Output *output)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (!model->rank && output->n_settled < output->n_stages) PetscCall(settle(scene, model, output, message));
  PetscCall(refuse(output, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputClose(Output *output, char message[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  message[0] = '\0';
  for (int i = 0; i < HISTORY_FILES; i++) HistoryClose(output->files + i, output->folder, message);
  if (output->lock >= 0) FolderUnlock(output->folder, output->lock);
  output->lock = -1;
  PetscCall(PetscFree(output->memory));
  PetscCall(OutputDropTrials(output));
  for (PetscInt s = 0; s < output->n_stages && output->stages; s++) free(output->stages[s]);
  PetscCall(PetscFree(output->stages));
  PetscCall(PetscFree(output->by_factor));
  PetscCall(ResultsFileDestroy(&output->results));
  PetscFunctionReturn(PETSC_SUCCESS);
}

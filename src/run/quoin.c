/* quoin.c: runs a scene from set-up to the last stage. QuoinSetUp alone knows the order of set-up. */
#include "run/run.h"
#include "base/memory.h"

struct _p_Quoin {
  MPI_Comm comm;
  Scene scene;
  Model model;
  State state;
  Contacts contacts;
  Relaxation relax;
  Result found; /* of the present stage */
  Output output;
  Checkpoint checkpoint;
  BlockMesh mesh; /* for stages that go back to an earlier end; else empty */
  Cases cases;
  uint64_t checksum; /* of the mesh; rank 0 */
  PetscInt stage;    /* the present stage, or the next one */
  StageResult last;
  PetscBool has_model, has_output;
  Condensing condensing;
};

int QuoinErrorExitCode(PetscErrorCode error)
{
  static const struct {
    PetscErrorCode error;
    int code;
  } table[] = {{PETSC_ERR_USER_INPUT, QUOIN_BAD_INPUT},
               {ERROR_OUTPUT, QUOIN_OUTPUT},
               {ERROR_LOCKED, QUOIN_LOCKED},
               {ERROR_CHECKPOINT, QUOIN_RESTART}};
  if (!error) return QUOIN_OK;
  if (error == ERROR_MEMORY) return QUOIN_MEMORY;
  for (size_t i = 0; i < sizeof(table) / sizeof(table[0]); i++)
    if (QuoinErrorIsShared(error) && error == table[i].error) return table[i].code;
  return QUOIN_INTERNAL;
}

/* ---- life */

PetscErrorCode QuoinCreate(MPI_Comm comm, Quoin *q)
{
  PetscFunctionBeginUser;
  MemoryReturnFreed();
  PetscCall(PetscNew(q));
  (*q)->comm = comm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinSetFromOptions(Quoin q, const char *scene_file, int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(SceneRead(q->comm, scene_file, argc, argv, &SceneCompletions, &q->scene));
  PetscCall(StateViewsCheck(q->comm, PETSC_FALSE));
  PetscCall(SolverOptionsTake(&q->scene));
  MemorySetLimit(1e9 * (double)q->scene.memory_limit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds all objects that depend on the partition, in the reference state. */
static PetscErrorCode build(Quoin q, BlockMesh *mesh)
{
  char missing[MESSAGE_LENGTH] = "", line[MESSAGE_LENGTH] = "";
  Couplings couplings;
  PetscFunctionBeginUser;
  PetscCall(TermsReads(q->comm, &q->scene, mesh, &couplings));
  PetscCall(ModelCreate(q->comm, &q->scene, mesh, &couplings, &q->model));
  PetscCall(CouplingsDestroy(&couplings));
  CondensingNote(&q->condensing, &q->model);
  PetscCall(BlocksCreate(&q->scene, &q->model));
  PetscCall(TimerBegin(TIMER_FIRST_CONTACTS));
  PetscCall(SupportsApply(&q->scene, PETSC_FALSE, &q->model));
  PetscCall(SupportsCheckMotion(&q->scene, &q->model));
  PetscCall(LiftsCreate(&q->scene, &q->model));
  PetscCall(ContactsCreate(&q->scene, &q->model, &q->contacts));
  PetscCall(JointRowsCheck(&q->scene, &q->model, &q->contacts));
  if (SceneFindsAnew(&q->scene)) PetscCall(LaterJoints(&q->scene, &q->contacts, &q->model, missing));
  if (missing[0])
    PetscCall(PetscSNPrintf(line, MESSAGE_LENGTH, "%s: joints: connectivity is variable, and %.700s",
                            q->scene.file, missing));
  PetscCall(CheckMessage(q->comm, line));
  PetscCall(ContactsCheckSupport(&q->scene, &q->model, &q->contacts));
  PetscCall(CondensedCreate(&q->scene, &q->model));
  PetscCall(CondensedCheckContacts(&q->scene, &q->model, &q->contacts));
  PetscCall(StateCreate(&q->scene, &q->model, &q->state));
  PetscCall(TermsCreate(&q->scene, &q->model, &q->contacts, &q->state));
  PetscCall(PushoverCheck(&q->scene, &q->model, &q->contacts, &q->state));
  PetscCall(RelaxationCreate(&q->scene, &q->model, &q->relax));
  PetscCall(TimerEnd(TIMER_FIRST_CONTACTS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode take_down(Quoin q)
{
  PetscFunctionBeginUser;
  PetscCall(NewtonDestroy(&q->relax.newton));
  PetscCall(RelaxationDestroy(&q->relax));
  PetscCall(TermsDestroy(&q->scene, &q->state));
  PetscCall(StateDestroy(&q->state));
  PetscCall(ContactsDestroy(&q->contacts));
  PetscCall(CondensedDestroy(&q->model));
  PetscCall(LawsDestroy(&q->model));
  PetscCall(LiftsDestroy(&q->model));
  PetscCall(AtRestDestroy(&q->model));
  PetscCall(ModelDestroy(&q->model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds all objects again, on other ranks too, after the groups that are condensed have changed. */
static PetscErrorCode build_again(Quoin q)
{
  PetscFunctionBeginUser;
  PetscCall(take_down(q));
  PetscCall(PetscFree(q->mesh.part));
  PetscCall(build(q, &q->mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds all objects; without condensed bodies where the program chose them and their factors find no
   memory. */
static PetscErrorCode build_first(Quoin q)
{
  PetscFunctionBeginUser;
  PetscCall(build(q, &q->mesh));
  q->has_model = PETSC_TRUE;
  if (!q->model.condensed.lacks) PetscFunctionReturn(PETSC_SUCCESS);
  CondensingUndo(&q->condensing, "their factors found no memory");
  PetscCall(build_again(q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether all objects may be built again. */
static PetscBool keeps_mesh(Quoin q)
{
  return (PetscBool)(SceneBranches(&q->scene) || q->model.condensed.large ||
                     (q->scene.restart[0] && q->condensing.why[0]));
}

PetscErrorCode QuoinSetUp(Quoin q)
{
  BlockMesh *mesh = &q->mesh;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(q->comm, &rank));
  PetscCall(IsaSelect(q->comm, q->scene.isa, q->scene.file));
  PetscCall(TimerBegin(TIMER_READING));
  PetscCall(MeshRead(q->comm, q->scene.model, mesh));
  PetscCall(TimerEnd(TIMER_READING));
  PetscCall(SceneResolve(q->comm, &q->scene, mesh));
  PetscCall(CasesCreate(q->comm, &q->scene, &q->stage, &q->cases));
  PetscCall(SceneReadMotions(q->comm, &q->scene));
  PetscCall(SceneReadLevels(q->comm, &q->scene));
  for (PetscInt g = 0; g < mesh->n_groups; g++)
    mesh->group_rigid[g] = q->scene.materials[g].rigid; // the scene overrides the mesh
  PetscCall(TimerBegin(TIMER_CHECKS));
  PetscCall(MeshCheckRun(q->comm, &q->scene, mesh));
  PetscCall(MeshTakeApart(q->comm, &q->scene, mesh));
  PetscCall(CondensingChoose(q->comm, &q->scene, mesh, &q->condensing));
  PetscCall(TimerEnd(TIMER_CHECKS));
  PetscCall(TimerBegin(TIMER_ORDER));
  if (rank == 0) PetscCall(MeshReorder(mesh));
  PetscCall(TimerEnd(TIMER_ORDER));
  if (rank == 0) q->checksum = MeshChecksum(mesh);
  PetscCall(build_first(q));
  if (!keeps_mesh(q)) PetscCall(MeshDestroy(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinView(Quoin q)
{
  PetscInt n[2] = {q->model.n_dof, 0};
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < q->contacts.n_padded; c++) n[1] += q->contacts.owned[c];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, q->comm));
  PetscCall(PetscPrintf(q->comm,
                        "quoin %s%s%s\n%" PetscInt_FMT " blocks in %" PetscInt_FMT
                        " macroblock%s, %" PetscInt_FMT " of them rigid, %" PetscInt_FMT
                        " contact%s, %" PetscInt_FMT " degrees of freedom on %d rank%s, x86-64 %s code\n",
                        QUOIN_VERSION, *q->scene.title ? ": " : "", q->scene.title,
                        q->model.mesh.n_blocks_global, q->model.mesh.n_bodies_global,
                        Plural(q->model.mesh.n_bodies_global), q->model.mesh.n_rigid_global, n[1],
                        Plural(n[1]), n[0], q->model.size, Plural(q->model.size), IsaName()));
  if (q->scene.solvers)
    PetscCall(
        PetscPrintf(q->comm,
                    "for PETSc's solvers: %s: preconditioned and condensed stages may end in other bits "
                    "than without\n",
                    q->scene.solvers));
  if (q->model.mesh.n_condensed_global)
    PetscCall(PetscPrintf(q->comm,
                          "condensed bodies, %s strain: %" PetscInt_FMT ", %" PetscInt_FMT
                          " free inner degrees of freedom onto %" PetscInt_FMT ", factored once in %.2f s\n",
                          q->model.condensed.large ? "large" : "small", q->model.mesh.n_condensed_global,
                          q->model.condensed.dofs[1], q->model.condensed.dofs[0], q->model.condensed.wall));
  if (q->condensing.shown) PetscCall(PetscPrintf(q->comm, "  chosen: %s\n", q->condensing.why));
  PetscCall(ContactsReportGaps(&q->scene, &q->model, &q->contacts));
  PetscCall(CornersReport(&q->scene, &q->model));
  PetscCall(CondensedReport(&q->model));
  if (!q->model.rank) WarnDoubtful(&q->scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a checkpoint keeps, see archive.h */

/* Lists names in their order, a line each; free the text with free(). */
static char *names_of(size_t stride, PetscInt n, const void *first)
{
  char *text = calloc((size_t)n + 1, NAME_LENGTH + 1), *end = text;
  for (PetscInt i = 0; text && i < n; i++)
    end += snprintf(end, NAME_LENGTH + 2, "%s\n", (const char *)first + (size_t)i * stride);
  return text;
}

/* Archives the position in the run. A scene with other joints, or with other earlier stages, cannot continue
   from it. */
static PetscErrorCode archive_run(Archive *a, void *context)
{
  Quoin q = context;
  const Scene *scene = &q->scene;
  PetscBool within;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "stage", 1, &q->stage));
  q->stage = (PetscInt)ArchiveWithin(a, "stage", q->stage, 0, scene->n_stages);
  PetscCall(ArchiveResult(a, "last", &q->last));
  PetscCall(ArchiveHasPart(a, "stage", &within));
  const PetscInt n = a->reading ? PetscMin(q->stage + (PetscInt)within, scene->n_stages) : scene->n_stages;
  char *const now[2] = {names_of(sizeof(Joint), scene->n_joints, scene->joints),
                        names_of(sizeof(Stage), n, scene->stages)};
  PetscCheck(now[0] && now[1], PETSC_COMM_SELF, PETSC_ERR_MEM,
             "no memory for the names of joints and stages");
  char *old[2] = {strdup(now[0]), strdup(now[1])}, *options = strdup(scene->options);
  PetscCall(ArchiveText(a, "joints", &old[0]));
  PetscCall(ArchiveText(a, "stages", &old[1]));
  PetscCall(ArchiveText(a, "options", &options));
  if (!a->rank && strcmp(old[0] ? old[0] : "", now[0]) != 0)
    snprintf(a->message, MESSAGE_LENGTH, "it has other joints than the scene");
  if (!a->rank && strncmp(old[1] ? old[1] : "", now[1], strlen(now[1])) != 0)
    snprintf(a->message, MESSAGE_LENGTH, "it has come through other stages than those of the scene");
  for (int i = 0; i < 2; i++) free(now[i]), free(old[i]);
  free(options);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_state(Archive *a, void *context)
{
  Quoin q = context;
  PetscFunctionBeginUser;
  PetscCall(StateArchive(a, &q->scene, &q->model, &q->state, &q->contacts));
  PetscCall(LiftsArchive(a, &q->scene, &q->model, &q->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_relaxation(Archive *a, void *context)
{
  Quoin q = context;
  PetscFunctionBeginUser;
  PetscCall(RelaxationArchive(a, &q->model, &q->relax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the condensed groups from a checkpoint. */
static PetscErrorCode resume_condensing(Quoin q)
{
  PetscFunctionBeginUser;
  PetscCall(CondensingResume(&q->condensing, &q->checkpoint));
  if (q->condensing.changed) PetscCall(build_again(q));
  if (!SceneBranches(&q->scene) && !q->model.condensed.large) PetscCall(MeshDestroy(&q->mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a checkpoint has brought the run into the present stage. */
static PetscBool has_begun(Quoin q)
{
  return (PetscBool)(q->stage && q->state.lifts_stage == q->stage);
}

/* Starts the run, from its beginning or from a checkpoint. */
static PetscErrorCode start(Quoin q)
{
  PetscBool resumed, kept = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(OutputLock(q->comm, &q->scene, &q->output)); // before anything in the folder is read
  q->has_output = PETSC_TRUE;
  PetscCall(StateViewsCheck(q->comm, PETSC_TRUE));
  PetscCall(CheckpointCreate(q->comm, &q->scene, q->checksum, &q->checkpoint));
  PetscCall(CheckpointRestart(&q->checkpoint));
  PetscCall(resume_condensing(q));
  PetscCall(CheckpointAttach(&q->checkpoint, "run", archive_run, q, &resumed));
  PetscCall(CheckpointAttach(&q->checkpoint, "state", archive_state, q, &resumed));
  PetscCall(CheckpointAttach(&q->checkpoint, "relaxation", archive_relaxation, q, &resumed));
  if (SceneBranches(&q->scene))
    PetscCall(CheckpointAttach(&q->checkpoint, "cases", CasesArchive, &q->cases, &kept));
  if (resumed) PetscCall(CasesResume(&q->cases, &q->checkpoint, kept, has_begun(q)));
  PetscCall(TimerBegin(TIMER_OUTPUT_START));
  PetscCall(OutputOpen(&q->scene, &q->model, &q->checkpoint, &q->found, &q->output));
  PetscCall(TimerEnd(TIMER_OUTPUT_START));
  PetscCall(TimerReportSetUp(q->comm));
  q->checkpoint.last_cycle = q->state.cycle;
  if (resumed)
    PetscCall(
        PetscPrintf(q->comm, "goes on from %s: stage %s, cycle %" PetscInt64_FMT "\n", q->checkpoint.last,
                    q->stage < q->scene.n_stages ? q->scene.stages[q->stage].name : "none: all are done",
                    q->state.cycle));
  else
    PetscCall(CheckpointWrite(&q->checkpoint, 0)); // older ones in the folder belong to another run
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Skips stages whose start has failed, and brings the state to the start of the next one. */
static PetscErrorCode go_on(Quoin q)
{
  const Scene *scene = &q->scene;
  PetscFunctionBeginUser;
  for (; q->stage < scene->n_stages && !CaseCanRun(&q->cases, q->stage); q->stage++) {
    PetscCall(PetscPrintf(q->comm, "stage %-12s is not run: stage %s, from which it starts, has failed\n",
                          scene->stages[q->stage].name, scene->stages[StageBase(scene, q->stage)].name));
    OutputPass(&q->output);
  }
  if (q->stage == scene->n_stages || has_begun(q)) PetscFunctionReturn(PETSC_SUCCESS);
  if (CaseIsElsewhere(&q->cases, q->stage)) {
    PetscCall(take_down(q));
    PetscCall(build(q, &q->mesh));
    PetscCall(CaseGoBack(&q->cases, &q->checkpoint));
    PetscCall(PetscPrintf(q->comm, "stage %-12s starts from the end of stage %s\n",
                          scene->stages[q->stage].name, scene->stages[q->cases.at].name));
    q->checkpoint.last_cycle = q->state.cycle;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the stage, and chooses the next one if it can start from an equilibrium. */
static PetscErrorCode end_stage(Quoin q)
{
  const PetscBool stands = (PetscBool)(q->last.verdict == VERDICT_CONVERGED ||
                                       q->last.verdict == VERDICT_COMPLETED);
  PetscFunctionBeginUser;
  q->stage++;
  PetscCall(CaseEnd(&q->cases, q->last.verdict));
  if (stands) PetscCall(CaseKeep(&q->cases, &q->checkpoint));
  PetscCall(go_on(q));
  if (q->output.settled && (stands || q->stage < q->scene.n_stages))
    PetscCall(CheckpointWrite(&q->checkpoint, q->state.cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins the run again with the blocks of condensed bodies, because these bodies cannot bear its motion. */
static PetscErrorCode begin_with_blocks(Quoin q)
{
  char message[MESSAGE_LENGTH] = "", why[CONDENSING_LENGTH / 2];
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(why, sizeof(why), "stage %s: %s", q->scene.stages[q->stage].name,
                          q->model.condensed.leave));
  PetscCall(PetscPrintf(q->comm, "%s: the run begins again, nothing condensed\n", why));
  PetscCall(OutputClose(&q->output, message));
  PetscCall(Refuse(q->comm, ERROR_OUTPUT, message));
  PetscCall(ResultDestroy(&q->found));
  PetscCall(PetscMemzero(&q->found, sizeof(q->found)));
  PetscCall(CheckpointDestroy(&q->checkpoint));
  CondensingUndo(&q->condensing, why);
  CondensingJoints(&q->condensing);
  PetscCall(build_again(q));
  q->stage = 0, q->last = (StageResult){.verdict = VERDICT_NONE}, q->scene.restart[0] = '\0';
  PetscCall(CasesDestroy(&q->cases));
  PetscCall(CasesCreate(q->comm, &q->scene, &q->stage, &q->cases));
  PetscCall(start(q));
  PetscCall(go_on(q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinRun(Quoin q)
{
  const PetscBool branches = SceneBranches(&q->scene);
  PetscFunctionBeginUser;
  PetscCall(start(q));
  PetscCall(go_on(q));
  while (q->stage < q->scene.n_stages) {
    const Stage *stage = q->scene.stages + q->stage;
    const Problem p = {&q->model,      &q->contacts, &q->state, &q->relax, &q->found, &q->output,
                       &q->checkpoint, &q->scene,    stage,     q->stage,  &q->last};
    PetscCall(StageRun(&p));
    if (q->model.condensed.leave) {
      PetscCall(begin_with_blocks(q));
      continue;
    }
    // after a stage that failed the next one would not start from an equilibrium
    const PetscBool stands = (PetscBool)(q->last.verdict == VERDICT_CONVERGED ||
                                         q->last.verdict == VERDICT_COMPLETED),
                    ends = (PetscBool)(q->last.verdict == VERDICT_INTERRUPTED || !(branches || stands));
    if (ends || q->stage + 1 == q->scene.n_stages)
      PetscCall(NewtonDestroy(&q->relax.newton)); // results and checkpoint take most memory
    PetscCall(OutputStage(&p));
    PetscCall(StateView(&q->state));
    if (ends) break;
    PetscCall(end_stage(q));
  }
  if (branches && q->last.verdict != VERDICT_INTERRUPTED) PetscCall(CasesReport(&q->cases, q->comm));
  PetscCall(OutputSettle(&q->scene, &q->model, &q->output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int QuoinExitCode(Quoin q)
{
  static const int code[] = {QUOIN_OK,        QUOIN_OK,          QUOIN_COLLAPSED, QUOIN_DIVERGED,
                             QUOIN_UNDECIDED, QUOIN_INTERRUPTED, QUOIN_OK};
  return code[CasesVerdict(&q->cases, q->last.verdict)];
}

PetscErrorCode QuoinDestroy(Quoin *q)
{
  char message[MESSAGE_LENGTH] = "";
  const MPI_Comm comm = *q ? (*q)->comm : MPI_COMM_NULL;
  PetscFunctionBeginUser;
  if (!*q) PetscFunctionReturn(PETSC_SUCCESS);
  if ((*q)->has_output) PetscCall(OutputClose(&(*q)->output, message));
  PetscCall(CheckpointDestroy(&(*q)->checkpoint));
  if ((*q)->has_model) PetscCall(take_down(*q));
  PetscCall(MeshDestroy(&(*q)->mesh));
  PetscCall(CasesDestroy(&(*q)->cases));
  PetscCall(PetscFree((*q)->condensing.joints));
  PetscCall(SceneDestroy(&(*q)->scene));
  PetscCall(PetscFree(*q));
  PetscCall(Refuse(comm, ERROR_OUTPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the same mesh and contacts with other numbers, for studies */

PetscErrorCode QuoinKeep(Quoin q, Archive *kept)
{
  PetscFunctionBeginUser;
  PetscCall(ArchiveDestroy(kept));
  kept->reading = PETSC_FALSE;
  PetscCall(QuoinGoBack(q, kept));
  kept->reading = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinGoBack(Quoin q, Archive *kept)
{
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(kept->part, "state", sizeof(kept->part)));
  PetscCall(archive_state(kept, q));
  PetscCall(PetscStrncpy(kept->part, "relaxation", sizeof(kept->part)));
  PetscCall(archive_relaxation(kept, q));
  PetscCheck(!kept->message[0], PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s", kept->message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the scene again; the data that set-up has made of the mesh replace the mesh. */
static PetscErrorCode read_again(Quoin q, const char *scene_file, int argc, char **argv, Scene *scene)
{
  const Model *m = &q->model;
  BlockMesh names = {.n_groups = m->materials.n_groups,
                     .n_face_sets = m->mesh.n_face_sets,
                     .n_points = m->mesh.n_points,
                     .group_names = m->materials.names,
                     .face_set_names = m->mesh.face_set_names,
                     .point_names = m->mesh.point_names};
  PetscFunctionBeginUser;
  PetscCall(SceneRead(q->comm, scene_file, argc, argv, &SceneCompletions, scene));
  PetscCall(PetscMalloc1(m->materials.n_groups, &names.group_rigid));
  for (PetscInt g = 0; g < m->materials.n_groups; g++) names.group_rigid[g] = q->scene.materials[g].rigid;
  const PetscErrorCode error = SceneResolve(q->comm, scene, &names);
  PetscCall(PetscFree(names.group_rigid));
  PetscCall(error);
  CondensingCopy(&q->scene, scene);
  PetscCall(SceneReadLevels(q->comm, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

uint64_t QuoinNumber(Quoin q)
{
  const Checkpoint of = {.scene = &q->scene, .mesh = q->checksum};
  return CheckpointRun(&of);
}

PetscErrorCode QuoinTakeNumbers(Quoin q, const char *scene_file, int argc, char **argv)
{
  Scene scene;
  PetscFunctionBeginUser;
  const PetscErrorCode error = read_again(q, scene_file, argc, argv, &scene);
  if (error) PetscCall(SceneDestroy(&scene));
  PetscCall(error);
  PetscCall(TermsDestroy(&q->scene, &q->state)); // they contain data of the old numbers
  PetscCall(SceneDestroy(&q->scene));
  q->scene = scene;
  PetscCall(TermsCreate(&q->scene, &q->model, &q->contacts, &q->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives access to the inside of a Quoin, for the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             Relaxation **relax)
{
  PetscFunctionBeginUser;
  *scene = &q->scene, *model = &q->model, *state = &q->state, *contacts = &q->contacts, *relax = &q->relax;
  PetscFunctionReturn(PETSC_SUCCESS);
}

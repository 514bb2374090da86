/* quoin.c: the lifecycle. QuoinSetUp is the one place where the order of set-up is written down. */
#include "base/memory.h"
#include "output/output.h"
#include "stages/repartition.h"

struct _p_Quoin {
  MPI_Comm comm;
  Scene scene;
  Model model;
  State state;
  Contacts contacts;
  Relaxation relax;
  Output output;
  Checkpoint checkpoint;
  Repartition repartition;
  uint64_t mesh;  /* its checksum; rank 0 */
  PetscInt stage; /* that runs, or is next */
  StageResult last;
  PetscBool has_model, has_output;
  const char *scene_file; /* as the scene was asked for: advise.c reads it again */
  int argc;
  char **argv;
};

const char *const VerdictNames[] = {"none",      "converged",   "collapsed", "diverged",
                                    "undecided", "interrupted", "completed"};

/* ---- errors */

/* Why all ranks have given up together; PETSC_SUCCESS: they have not. */
static PetscErrorCode refused = PETSC_SUCCESS;

/* PETSc 3.18 gives the line of the call in place of the code, and its function in place of the message. */
static PetscBool is_of_malloc(const char *function)
{
  return (PetscBool)(function &&
                     (!strcmp(function, "PetscMallocAlign") || !strcmp(function, "PetscReallocAlign")));
}

/* What is refused is one line on stderr of rank 0, want of memory one of the rank it meets; everything else
   is a fault of the program and keeps PETSc's trace. */
static PetscErrorCode on_error(MPI_Comm comm, int line, const char *function, const char *file,
                               PetscErrorCode code, PetscErrorType type, const char *message, void *context)
{
  PetscMPIInt rank = 0;
  if (type == PETSC_ERROR_INITIAL && is_of_malloc(function)) code = ERROR_MEMORY;
  if (code == ERROR_MEMORY && code != refused) {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (type == PETSC_ERROR_INITIAL)
      fprintf(stderr,
              "quoin: error: rank %d has no memory left in %s: %s; take more machines or a smaller mesh\n",
              rank, function, message);
    return code;
  }
  if (code != refused)
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, context);
  if (type == PETSC_ERROR_INITIAL) {
    MPI_Comm_rank(comm, &rank);
    if (rank == 0) {
      fprintf(stderr, "quoin: error: %s\n", message);
      fflush(stderr);
    }
  }
  return code;
}

PetscErrorCode QuoinErrorHandlerPush(void)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPushErrorHandler(on_error, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Refuse(MPI_Comm comm, PetscErrorCode code, const char *message)
{
  char text[MESSAGE_LENGTH];
  PetscMPIInt rank, size, first;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  first = message[0] ? rank : size;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first == size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(text, message, sizeof(text)));
  PetscCallMPI(MPI_Bcast(text, MESSAGE_LENGTH, MPI_CHAR, first, comm));
  refused = code;
  SETERRQ(comm, code, "%s", text);
}

PetscErrorCode CheckMessage(MPI_Comm comm, const char *message)
{
  PetscFunctionBeginUser;
  PetscCall(Refuse(comm, PETSC_ERR_USER_INPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
    if (error == refused && error == table[i].error) return table[i].code;
  return QUOIN_INTERNAL;
}

PetscBool QuoinErrorIsShared(PetscErrorCode error)
{
  return (PetscBool)(error == refused);
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
  q->scene_file = scene_file, q->argc = argc, q->argv = argv;
  PetscCall(SceneRead(q->comm, scene_file, argc, argv, &q->scene));
  PetscCall(SolverOptionsTake(&q->scene));
  MemorySetLimit(1e9 * (double)q->scene.memory_limit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slender blocks are allowed, and told: they set the time step and are stiff in bending. */
static void warn_slender(const BlockMesh *mesh)
{
  static PetscBool told = PETSC_FALSE; // advise.c sets up the same mesh many times
  PetscInt n, worst;
  PetscReal ratio;
  MeshSlender(mesh, &n, &worst, &ratio);
  if (!n || told) return;
  told = PETSC_TRUE;
  fprintf(stderr,
          "quoin: warning: %" PetscInt_FMT
          " block%s with an aspect ratio above 1000; worst is block %" PetscInt_FMT
          ", %.3g: expect many cycles and stresses of little worth there\n",
          n, Plural(n), worst, (double)ratio);
  fflush(stderr);
}

/* Poisson's ratios from which full blocks lock: a cantilever of 20 by 4 of them is 10 % too stiff in bending
   at 0.2, 19 % at 0.45, 49 % at 0.49 (bending blocks: 0, 2 and 3 %). Plane stress never does. */
static const PetscReal LOCKS_FROM = 0.45;

static void warn_locking(const Scene *scene)
{
  static PetscBool told = PETSC_FALSE;
  if (told || scene->plane != PLANE_STRAIN) return;
  told = PETSC_TRUE;
  for (PetscInt g = 0; g < scene->n_materials; g++) {
    const Material *material = scene->materials + g;
    if (material->rigid || material->element != ELEMENT_FULL || material->poisson < LOCKS_FROM) continue;
    fprintf(
        stderr,
        "quoin: warning: materials.%s: at Poisson's ratio %.4g blocks of element: full are much too stiff "
        "in bending: take element: bending, and blocks of 4 vertices\n",
        material->name, (double)material->poisson);
  }
  fflush(stderr);
}

/* Newton's method keeps its contacts. */
static void warn_explicit(const Scene *scene)
{
  static PetscBool told = PETSC_FALSE;
  PetscBool any = PETSC_FALSE;
  if (told || scene->method != METHOD_PRECONDITIONED) return;
  told = PETSC_TRUE;
  for (PetscInt s = 0; s < scene->n_stages; s++) {
    const Stage *stage = scene->stages + s;
    if (stage->kind == STAGE_DYNAMIC || !stage->variable) continue;
    fprintf(stderr, "%s %s",
            any ? "," : "quoin: warning: preconditioned needs fixed connectivity; by explicit cycles:",
            stage->name);
    any = PETSC_TRUE;
  }
  if (any) fprintf(stderr, "\n");
  fflush(stderr);
}

/* What only shows when mesh, scene and ranks are seen together. */
static PetscErrorCode check_mesh(Quoin q, const BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank, size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(q->comm, &rank));
  PetscCallMPI(MPI_Comm_size(q->comm, &size));
  if (rank == 0) {
    char fault[MESSAGE_LENGTH] = "";
    PetscCall(MeshCheck(mesh, q->scene.overlap_tolerance, fault));
    if (fault[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: %s", q->scene.model, fault));
    else if (size > mesh->n_blocks)
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: %d ranks for %" PetscInt_FMT
                              " blocks: expected at most one rank per block",
                              q->scene.model, size, mesh->n_blocks));
  }
  PetscCall(CheckMessage(q->comm, message));
  if (rank == 0) warn_slender(mesh), warn_locking(&q->scene), warn_explicit(&q->scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All that hangs on the partition, at the reference state. */
static PetscErrorCode build(Quoin q, BlockMesh *mesh)
{
  PetscFunctionBeginUser;
  PetscCall(ModelCreate(q->comm, &q->scene, mesh, &q->model));
  PetscCall(PartBegin(PART_FIRST_CONTACTS));
  PetscCall(SupportsApply(&q->scene, &q->model));
  PetscCall(ContactsCreate(&q->scene, &q->model, &q->contacts));
  PetscCall(LaterJoints(&q->scene, &q->contacts, &q->model));
  PetscCall(ContactsCheckSupport(&q->scene, &q->model, &q->contacts));
  PetscCall(CondensedCreate(&q->scene, &q->model));
  PetscCall(CondensedCheckContacts(&q->scene, &q->model, &q->contacts));
  PetscCall(StateCreate(&q->scene, &q->model, &q->state));
  PetscCall(UpliftCreate(&q->scene, &q->model, &q->contacts, &q->state));
  PetscCall(RelaxationCreate(&q->scene, &q->model, &q->relax));
  PetscCall(PartEnd(PART_FIRST_CONTACTS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode take_down(Quoin q)
{
  PetscFunctionBeginUser;
  PetscCall(RelaxationDestroy(&q->relax));
  PetscCall(UpliftDestroy(&q->scene, &q->state));
  PetscCall(StateDestroy(&q->state));
  PetscCall(ContactsDestroy(&q->contacts));
  PetscCall(CondensedDestroy(&q->model));
  PetscCall(ModelDestroy(&q->model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same on the partition that repartition.c has found. */
static PetscErrorCode renew(void *context)
{
  Quoin q = context;
  PetscFunctionBeginUser;
  PetscCall(take_down(q));
  PetscCall(build(q, &q->repartition.mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinSetUp(Quoin q)
{
  BlockMesh mesh;
  SupportMotion *motions;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(q->comm, &rank));
  PetscCall(IsaSelect(q->comm, &q->scene));
  PetscCall(PartBegin(PART_READING));
  PetscCall(MeshRead(q->comm, q->scene.model, &mesh));
  PetscCall(PartEnd(PART_READING));
  PetscCall(SceneResolve(q->comm, &q->scene, &mesh));
  PetscCall(SupportMotionsRead(&q->scene, q->comm, &motions)); // now, not hours later: a file that is none
  PetscCall(SupportMotionsDestroy(&q->scene, &motions));
  for (PetscInt g = 0; g < mesh.n_groups; g++)
    mesh.group_rigid[g] = q->scene.materials[g].rigid; // the scene overrides the mesh
  PetscCall(PartBegin(PART_CHECKS));
  PetscCall(check_mesh(q, &mesh));
  PetscCall(MeshTakeApart(q->comm, &q->scene, &mesh));
  PetscCall(PartEnd(PART_CHECKS));
  PetscCall(PartBegin(PART_ORDER));
  if (rank == 0) PetscCall(MeshReorder(&mesh));
  PetscCall(PartEnd(PART_ORDER));
  if (rank == 0) q->mesh = MeshChecksum(&mesh);
  PetscCall(build(q, &mesh));
  PetscCall(RepartitionCreate(&q->scene, &q->model, &mesh, &q->repartition));
  q->repartition.state = &q->state, q->repartition.contacts = &q->contacts;
  q->repartition.renew = renew, q->repartition.context = q;
  PetscCall(MeshDestroy(&mesh));
  q->has_model = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinView(Quoin q)
{
  PetscInt n[2] = {q->model.n_dof, 0};
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < q->contacts.n_padded; c++) n[1] += q->contacts.owned[c];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, q->comm));
  PetscCall(PetscPrintf(q->comm,
                        "quoin %s: %s\n%" PetscInt_FMT " blocks in %" PetscInt_FMT
                        " macroblock%s, %" PetscInt_FMT " of them rigid, %" PetscInt_FMT
                        " contact%s, %" PetscInt_FMT " degrees of freedom on %d rank%s, x86-64 %s code\n",
                        QUOIN_VERSION, q->scene.title, q->model.n_blocks_global, q->model.n_bodies_global,
                        Plural(q->model.n_bodies_global), q->model.n_rigid_global, n[1], Plural(n[1]), n[0],
                        q->model.size, Plural(q->model.size), IsaName()));
  if (q->scene.solvers)
    PetscCall(
        PetscPrintf(q->comm,
                    "for PETSc's solvers: %s: preconditioned and condensed stages may end in other bits "
                    "than without\n",
                    q->scene.solvers));
  if (q->model.n_condensed_global)
    PetscCall(PetscPrintf(q->comm,
                          "condensed bodies, small strain: %" PetscInt_FMT ", %" PetscInt_FMT
                          " inner degrees of freedom onto %" PetscInt_FMT ", factored once in %.2f s\n",
                          q->model.n_condensed_global, q->model.condensed_dofs[1], q->model.condensed_dofs[0],
                          q->model.condensed_wall));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a checkpoint keeps, see archive.h */

/* Names in their order, a line each; free with free(). */
static char *names_of(size_t stride, PetscInt n, const void *first)
{
  char *text = calloc((size_t)n + 1, NAME_LENGTH + 1), *end = text;
  for (PetscInt i = 0; text && i < n; i++)
    end += snprintf(end, NAME_LENGTH + 2, "%s\n", (const char *)first + (size_t)i * stride);
  return text;
}

/* Where the run is; a scene whose joints, or stages up to there, are others cannot go on from it. */
static PetscErrorCode archive_run(Archive *a, void *context)
{
  Quoin q = context;
  const Scene *scene = &q->scene;
  PetscBool within;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "stage", 1, &q->stage));
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_relaxation(Archive *a, void *context)
{
  Quoin q = context;
  PetscFunctionBeginUser;
  PetscCall(RelaxationArchive(a, &q->model, &q->relax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From the start, or from where a checkpoint left off. */
static PetscErrorCode begin(Quoin q)
{
  PetscBool resumed;
  PetscFunctionBeginUser;
  PetscCall(OutputLock(q->comm, &q->scene, &q->output)); // before anything in the folder is read
  q->has_output = PETSC_TRUE;
  PetscCall(CheckpointCreate(q->comm, &q->scene, q->mesh, &q->checkpoint));
  PetscCall(CheckpointRestart(&q->checkpoint));
  PetscCall(CheckpointAttach(&q->checkpoint, "run", archive_run, q, &resumed));
  PetscCall(CheckpointAttach(&q->checkpoint, "state", archive_state, q, &resumed));
  PetscCall(CheckpointAttach(&q->checkpoint, "relaxation", archive_relaxation, q, &resumed));
  PetscCall(PartBegin(PART_OUTPUT_START));
  PetscCall(OutputOpen(&q->scene, &q->model, &q->checkpoint, &q->output));
  PetscCall(PartEnd(PART_OUTPUT_START));
  PetscCall(PartReportSetUp(q->comm));
  q->checkpoint.last_cycle = q->state.cycle;
  q->checkpoint.repartition = &q->repartition;
  // set-up deals out by where blocks were at the start
  q->repartition.looked = resumed ? q->state.cycle - q->scene.repartition_every : 0;
  if (resumed)
    PetscCall(
        PetscPrintf(q->comm, "goes on from %s: stage %s, cycle %" PetscInt64_FMT "\n", q->checkpoint.last,
                    q->stage < q->scene.n_stages ? q->scene.stages[q->stage].name : "none: all are done",
                    q->state.cycle));
  else
    PetscCall(CheckpointWrite(&q->checkpoint, 0)); // older ones in the folder belong to another run
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinRun(Quoin q)
{
  PetscFunctionBeginUser;
  if (q->scene.advise > 0.) {
    PetscCall(Advise(q, q->scene_file, q->argc, q->argv));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(begin(q));
  while (q->stage < q->scene.n_stages) {
    const Stage *stage = q->scene.stages + q->stage;
    const Problem p = {&q->model, &q->contacts, &q->state, &q->relax, &q->output,
                       &q->scene, stage,        q->stage,  &q->last};
    PetscCall(stage->kind == STAGE_DYNAMIC ? StageRunDynamic(&p) : StageRun(&p));
    PetscCall(OutputStage(&p));
    // after any other verdict the next stage would start from no equilibrium
    if (q->last.verdict != VERDICT_CONVERGED && q->last.verdict != VERDICT_COMPLETED) break;
    q->stage++;
    if (q->output.settled) PetscCall(CheckpointWrite(&q->checkpoint, q->state.cycle));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int QuoinExitCode(Quoin q)
{
  static const int code[] = {QUOIN_OK,        QUOIN_OK,          QUOIN_COLLAPSED, QUOIN_DIVERGED,
                             QUOIN_UNDECIDED, QUOIN_INTERRUPTED, QUOIN_OK};
  return code[q->last.verdict];
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
  PetscCall(RepartitionDestroy(&(*q)->repartition));
  PetscCall(SceneDestroy(&(*q)->scene));
  PetscCall(PetscFree(*q));
  PetscCall(Refuse(comm, ERROR_OUTPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The insides, for the project's own tests and benchmarks (src/internal.h). */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             Relaxation **relax)
{
  PetscFunctionBeginUser;
  *scene = &q->scene, *model = &q->model, *state = &q->state, *contacts = &q->contacts, *relax = &q->relax;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Memory of a factor: foreseen from the size of the model, refused where it does not fit, and, where it runs
   out on the way (CHOLMOD on one rank, MUMPS on several), left for explicit cycles with a line that says so;
   condensed bodies, which are nothing without their factors, are refused. Only small allocations are refused
   here, by the solvers' own settings, or where nothing was asked for yet: nothing can hang. ranks: 1 2 */
#include "archive/archive.h"
#include "base/memory.h"
#include "run/run.h"
#include "scene_fixture.h"
#include <dlfcn.h>
#include <errno.h>
#include <sys/resource.h>

/* they end the program where malloc would give nothing */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

enum { SIDE = 20 };
static Sketch sketch;

/* A wall on the ground, which has some thousand entries in its factor. */
static PetscErrorCode OpenWallOf(int side, const char *stones, const char *limit, Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), stone = SketchGroup(&sketch, "stone", 0);
  const double wall[8] = {0, 0, 4, 0, 4, 4, 0, 4};
  SketchBox(&sketch, ground, -1, -1, 6, 1);
  SketchGrid(&sketch, stone, wall, side, side, QUADS);
  PetscFunctionReturn(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "memory_limit: %s\nmaterials: {ground: {density: 0},\n"
                  "  stone: {density: 2400, young: 2e9, poisson: 0.2%s}}\n"
                  "relaxation: {method: preconditioned}\n"
                  "joints: {default: {k_n: 3e9, k_s: 1e9, friction: 25}}\n"
                  "supports: {ground: {fix: xy}}\nloads: {weight: {type: self_weight}}\n"
                  "stages: [all: {loads: [weight], ramp: 10, tolerance: 1e-4, max_cycles: 20000}]\n",
                  limit, stones));
}

static PetscErrorCode OpenWall(const char *limit, Fixture *f)
{
  return OpenWallOf(SIDE, "", limit, f);
}

/* The stage, nothing written. */
static PetscErrorCode Relax(Fixture *f, StageResult *result)
{
  Output output = {.lock = -1};
  Checkpoint none = {.comm = f->model->comm, .rank = f->model->rank, .scene = f->scene};
  Result found = {.probes = NULL};
  const Problem p = {.m = f->model,
                     .contacts = f->contacts,
                     .state = f->state,
                     .relax = f->relax,
                     .found = &found,
                     .output = &output,
                     .checkpoint = &none,
                     .scene = f->scene,
                     .stage = f->scene->stages,
                     .result = result};
  PetscFunctionBeginUser;
  output.checkpoint = &none;
  PetscCall(ResultCreate(f->model, &found));
  PetscCall(StageRun(&p));
  PetscCall(ResultDestroy(&found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EnsureExplicit(const StageResult *result, PetscBool tried)
{
  PetscFunctionBeginUser;
  ENSURE(result->verdict == VERDICT_CONVERGED);
  ENSURE(result->effort.explicit && result->effort.preconditioned == tried);
  ENSURE(result->effort.wanted > 0);
  ENSURE(strstr(result->evidence, "; no memory for the factor: it takes about ") != NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- foreseen */

static PetscErrorCode FactorOfTheModel(void)
{
  Fixture f;
  double memory[2];
  PetscBool fits;
  PetscFunctionBeginUser;
  PetscCall(OpenWall("0", &f));
  PetscCall(NewtonFits(f.model, PETSC_FALSE, memory, &fits));
  PetscInt n = f.model->n_dof;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  ENSURE(fits && memory[1] > memory[0]);
  ENSURE(PetscAbsReal(memory[0] / MemoryOfFactor((double)n, 0., f.model->size) - 1.) < 1e-12);
  PetscCall(FixtureClose(&f));
  // measured: 1.0e6 blocks in one body took 2.2 kB a degree of freedom on one rank
  ENSURE(PetscAbsReal(MemoryOfFactor(2e6, 0., 1) / 2e6 / 2200. - 1.) < 0.15);
  // condensed bodies fill their part
  ENSURE(MemoryOfFactor(1e4, 1e6, 1) > MemoryOfFactor(1e4, 0., 1) + 8e6);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is asked for counts on all ranks of a machine, and so does what they hold. */
static PetscErrorCode LimitIsOfTheMachine(void)
{
  double sum[2];
  PetscMPIInt size;
  PetscBool fits;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  MemorySetLimit(0.);
  PetscCall(MemoryFits(PETSC_COMM_WORLD, 1e3, sum, &fits));
  ENSURE(fits && sum[0] == 1e3 * size && sum[1] > 1e3 * size);
  PetscCall(MemoryFits(PETSC_COMM_WORLD, 1e18, sum, &fits));
  ENSURE(!fits);
  MemorySetLimit(1e12);
  ENSURE(MemoryAvailable() <= 1e12);
  MemorySetLimit(1e6); // less than a rank holds
  PetscCall(MemoryFits(PETSC_COMM_WORLD, 1., sum, &fits));
  ENSURE(!fits && sum[1] == 0.);
  MemorySetLimit(0.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NoMemoryIsReported(void)
{
  Fixture f;
  StageResult result;
  PetscFunctionBeginUser;
  PetscCall(OpenWall("0", &f));
  MemorySetLimit(1e6); // as if others had taken the rest since
  PetscCall(Relax(&f, &result));
  MemorySetLimit(0.);
  PetscCall(EnsureExplicit(&result, PETSC_FALSE));
  ENSURE(f.relax->newton == NULL);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- run out of on the way */

static size_t largest;
static void *refuse_large(size_t bytes)
{
  if (bytes > largest) errno = ENOMEM;
  return bytes > largest ? NULL : malloc(bytes);
}

static int cholmod_lines;
static int count_line(const char *format, ...)
{
  (void)format;
  return cholmod_lines++;
}

/* SuiteSparse takes its memory, and prints, by functions that a program may set: by a function for each,
   before version 6 in a table malloc, calloc, realloc, free, printf. */
static PetscBool SetOfSuiteSparse(const char *what, int place, void (*function)(void))
{
  char name[64];
  typedef void (*Function)(void);
  (void)snprintf(name, sizeof name, "SuiteSparse_config_%s_func_set", what);
  void (*set)(Function) = (void (*)(Function))dlsym(RTLD_DEFAULT, name);
  Function *table = (Function *)dlsym(RTLD_DEFAULT, "SuiteSparse_config");
  if (set)
    set(function);
  else if (table)
    table[place] = function;
  return (PetscBool)(set || table);
}

static PetscBool SetCholmodMalloc(void *(*function)(size_t))
{
  return SetOfSuiteSparse("malloc", 0, (void (*)(void))function);
}

static PetscBool SetCholmodPrintf(int (*function)(const char *, ...))
{
  return SetOfSuiteSparse("printf", 4, (void (*)(void))function);
}

static PetscErrorCode MemoryOnTheWayIsReported(void)
{
  static const size_t limits[] = {1 << 10, 1 << 14, 1 << 17}; // analysis, ordering, the numbers of the factor
  Fixture f;
  StageResult result;
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  for (size_t i = 0; i < (size > 1 ? 1 : sizeof limits / sizeof limits[0]); i++) {
    PetscCall(OpenWall("0", &f));
    largest = limits[i];
    if (size > 1)
      PetscCall(PetscOptionsSetValue(NULL, "-mat_mumps_icntl_14", "-90"));
    else if (!SetCholmodMalloc(refuse_large)) {
      printf("this SuiteSparse takes no function for its memory: not tested\n");
      PetscCall(FixtureClose(&f));
      break;
    }
    (void)SetCholmodPrintf(count_line);
    LEAKS_ALLOWED(); // PETSc's, when CHOLMOD fails
    PetscCall(Relax(&f, &result));
    LEAKS_COUNT();
    PetscCall(PetscOptionsClearValue(NULL, "-mat_mumps_icntl_14"));
    if (size == 1) (void)SetCholmodMalloc(malloc);
    (void)SetCholmodPrintf(printf);
    ENSURE(cholmod_lines == 0); // the message is ours alone
    PetscCall(EnsureExplicit(&result, PETSC_TRUE));
    // again: not tried once more, but reported
    const PetscInt64 made = f.relax->effort.factorisations;
    PetscCall(Relax(&f, &result));
    PetscCall(EnsureExplicit(&result, PETSC_TRUE));
    ENSURE(result.effort.factorisations == 0 && made <= 1);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MUMPS gives up for a work space that its analysis found too small, or that it may not have. */
static PetscErrorCode CondensedBodiesWithoutFactorsAreRefused(void)
{
  static const char *const options[2][2] = {{"-mat_mumps_icntl_14", "-95"}, {"-mat_mumps_icntl_23", "1"}};
  Fixture f;
  PetscFunctionBeginUser;
  for (int i = 0; i < 2; i++) {
    PetscCall(PetscOptionsSetValue(NULL, options[i][0], options[i][1]));
    fixture_refusal = "";
    LEAKS_ALLOWED();
    const PetscErrorCode code = OpenWallOf(2 * SIDE, ", condensed: true", "0", &f);
    LEAKS_COUNT();
    fixture_refusal = NULL;
    PetscCall(PetscOptionsClearValue(NULL, options[i][0]));
    ENSURE(code == PETSC_ERR_MEM && QuoinErrorIsShared(code));
    ENSURE(strstr(fixture_message,
                  "MUMPS has no memory left for the factors of 1 condensed body, which were ") != NULL);
    PetscCall(FixtureClose(&f));
  }
  PetscCall(OpenWallOf(2 * SIDE, ", condensed: true", "0", &f)); // and with it they are there
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OpenBLAS would ask for its working memory for ever. */
static PetscErrorCode NoFactorWithoutRoomForBlas(void)
{
  struct rlimit before, limit;
  double sum[2], kilobytes = 0.;
  char line[256];
  PetscBool fits;
  PetscFunctionBeginUser;
  FILE *status = fopen("/proc/self/status", "r");
  while (status && fgets(line, sizeof line, status))
    if (!strncmp(line, "VmSize:", 7)) kilobytes = strtod(line + 7, NULL);
  if (status) fclose(status);
  getrlimit(RLIMIT_AS, &before);
  limit = before, limit.rlim_cur = (rlim_t)(1024. * kilobytes + 64e6);
  ENSURE(kilobytes > 0. && !setrlimit(RLIMIT_AS, &limit));
  PetscCall(MemoryFits(PETSC_COMM_WORLD, 1e6, sum, &fits));
  setrlimit(RLIMIT_AS, &before);
  ENSURE(!fits && sum[1] == 0.);
  PetscCall(MemoryFits(PETSC_COMM_WORLD, 1e6, sum, &fits));
  ENSURE(fits && sum[1] > 1e6);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What PETSc itself finds no memory for ends the program with the exit code of want of memory. */
static PetscErrorCode RefuseAnArray(void)
{
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_MEM, "Memory requested 1e18");
}

static PetscErrorCode AskForTooMuch(void)
{
  char *array;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)1 << 50, &array));
  PetscFunctionReturn(PetscFree(array));
}

static PetscErrorCode ExitCodeOfNoMemory(void)
{
  PetscFunctionBeginUser;
  PetscCall(QuoinErrorHandlerPush());
  const PetscErrorCode code = RefuseAnArray();
  if (!SANITIZED) ENSURE(AskForTooMuch() == PETSC_ERR_MEM);
  PetscCall(PetscPopErrorHandler());
  ENSURE(code == PETSC_ERR_MEM && QuoinErrorExitCode(code) == QUOIN_MEMORY && !QuoinErrorIsShared(code));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  if (!SANITIZED) RUN_TEST(NoFactorWithoutRoomForBlas); // first: then it has its memory
  RUN_TEST(FactorOfTheModel);
  RUN_TEST(LimitIsOfTheMachine);
  RUN_TEST(NoMemoryIsReported);
  RUN_TEST(MemoryOnTheWayIsReported);
  RUN_TEST(ExitCodeOfNoMemory);
  RUN_TEST(CondensedBodiesWithoutFactorsAreRefused);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* main.c: reads the command line, and runs a scene, prints help, or makes studies of many runs. */
#include "study/study.h"
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char help[] = "Quoin: discrete elements for masonry gravity dams and their foundations.\n"
                           "  mpirun -n 2 quoin -options_file scene.yaml [-key value ...]\n"
                           "  ... -echo prints the scene with every key in force and runs nothing\n";

/* Takes `words` entries out of argv from position i on. */
static void take_out(int i, int words, int *argc, char **argv)
{
  for (int j = i; j + words <= *argc; j++) argv[j] = argv[j + words];
  *argc -= words;
}

/* Copies argv with one word more, from malloc. The copy is needed because PetscOptionsSetValue before
   PetscInitialize reads memory that it has freed, in PETSc 3.18. */
static char **add_word(int argc, char **argv, const char *word)
{
  char **words = malloc((size_t)(argc + 2) * sizeof(*words));
  if (!words) abort();
  memcpy(words, argv, (size_t)argc * sizeof(*words));
  words[argc] = (char *)word, words[argc + 1] = NULL;
  return words;
}

/* Takes "-options_file FILE" out of argv, because PETSc would read it before our error handler is in
   place. */
static const char *take_scene_file(int *argc, char **argv)
{
  const char *file = NULL;
  for (int i = 1; i < *argc;) {
    if (strcmp(argv[i], "-options_file") || i + 1 >= *argc) {
      i++;
      continue;
    }
    file = argv[i + 1];
    take_out(i, 2, argc, argv);
  }
  return file;
}

/* Takes an option without a value out of argv, with one dash or two: PETSc would print a page of its own for
   -help. */
static PetscBool take_word(const char *word, int *argc, char **argv)
{
  PetscBool found = PETSC_FALSE;
  for (int i = 1; i < *argc;) {
    if (strcmp(argv[i], word + 1) && strcmp(argv[i], word)) {
      i++;
      continue;
    }
    found = PETSC_TRUE;
    take_out(i, 1, argc, argv);
  }
  return found;
}

/* Tells Open MPI that this process runs alone. Without a launcher Open MPI would start a daemon and look for
   networks, which takes half of the time that one process needs to start. All such runs would also share one
   folder, which the first run to end would remove under another that starts. Open MPI also asks hwloc for the
   caches, devices and displays of the machine, which binds no rank here and takes most of what is left; hwloc
   is told to count processors and to stop. What the user has set stays. Other MPI libraries do not read these
   variables. */
static void start_alone(void)
{
  static const char *const launched[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK",  "PMI_RANK", "PMI_FD",
                                         "SLURM_PROCID",         "PALS_RANKID"};
  for (size_t i = 0; i < sizeof(launched) / sizeof(*launched); i++)
    if (getenv(launched[i])) return;
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  setenv("OMPI_MCA_pml", "ob1", 0);
  setenv("OMPI_MCA_btl", "self", 0);
  setenv("OMPI_MCA_sharedfp", "^sm", 0); // a parallel HDF5 file would want that folder
  setenv("HWLOC_COMPONENTS", "no_os,stop", 0);
  setenv("HWLOC_PLUGINS_PATH", "", 0);
}

/* Keeps a run going when a terminal or a pipe goes away. SIGPIPE is ignored, and so is SIGHUP where it was
   ignored before PETSc took it (nohup). Elsewhere SIGHUP stops the run after a checkpoint, as other signals
   do (checkpoint.c); a signal during set-up waits for the first check. */
static void keep_running(PetscBool hangup_ignored)
{
  signal(SIGPIPE, SIG_IGN);
  if (hangup_ignored) signal(SIGHUP, SIG_IGN);
  SignalsCatch();
}

static PetscBool hangup_is_ignored(void)
{
  struct sigaction now;
  return (PetscBool)(!sigaction(SIGHUP, NULL, &now) && now.sa_handler == SIG_IGN);
}

/* Returns the exit code of a command that only prints: 0 when all its text was written, or when the reader of
   a pipe has closed it. */
static int code_of_text(void)
{
  struct stat status;
  errno = 0;
  if ((!fflush(stdout) && !ferror(stdout)) || fstat(STDOUT_FILENO, &status) || S_ISFIFO(status.st_mode) ||
      S_ISSOCK(status.st_mode))
    return QUOIN_OK;
  fprintf(stderr, "quoin: error: output: cannot write what was asked for: %s\n",
          errno ? strerror(errno) : "is the disk full?");
  return QUOIN_OUTPUT;
}

/* Prints the scene with every key in force. */
static PetscErrorCode print_echo(Quoin q)
{
  Scene *scene;
  Model *model;
  State *state;
  Contacts *contacts;
  Relaxation *relax;
  PetscFunctionBeginUser;
  PetscCall(QuoinGetParts(q, &scene, &model, &state, &contacts, &relax));
  if (!model->rank) fputs(scene->echo, stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a scene. echo: only writes the scene with its defaults. */
static PetscErrorCode run(const char *scene_file, int argc, char **argv, PetscBool echo, int *exit_code)
{
  Quoin q;
  PetscBool advised, sampled = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (echo) PETSC_STDOUT = stderr; // what the setup reports is no part of the scene
  PetscCall(QuoinCreate(PETSC_COMM_WORLD, &q));
  PetscCall(QuoinSetFromOptions(q, scene_file, argc, argv));
  PetscCall(QuoinSetUp(q));
  if (echo) {
    PetscCall(print_echo(q));
    *exit_code = code_of_text();
    PetscCall(QuoinDestroy(&q));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(QuoinView(q));
  PetscCall(Advise(q, scene_file, argc, argv, &advised));
  if (!advised) PetscCall(Samples(q, scene_file, argc, argv, &sampled));
  if (!advised && !sampled) PetscCall(QuoinRun(q));
  *exit_code = QuoinExitCode(q);
  if (advised && *exit_code == QUOIN_OK) *exit_code = code_of_text();
  PetscCall(QuoinDestroy(&q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  const char *scene_file = take_scene_file(&argc, argv);
  const PetscBool want_help = take_word("--help", &argc, argv),
                  want_schema = take_word("--schema", &argc, argv),
                  want_echo = take_word("--echo", &argc, argv);
  const PetscBool hangup_ignored = hangup_is_ignored();
  int exit_code = QUOIN_OK;

  SignalsCatch();
  start_alone();
  // a file .petscrc beside a model could write files or start programs, so it is not read
  char **words = add_word(argc, argv, "-skip_petscrc");
  argc++, argv = words;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(QuoinErrorHandlerPush());
  keep_running(hangup_ignored);
  if (want_help) {
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s", help));
    PetscCall(SceneHelp(PETSC_COMM_WORLD));
    exit_code = code_of_text();
  } else if (want_schema) {
    PetscCall(SceneSchema(PETSC_COMM_WORLD));
    exit_code = code_of_text();
  } else {
    const PetscErrorCode error = run(scene_file, argc, argv, want_echo, &exit_code);
    if (!error) PetscCall(SolverOptionsWarnUnread(PETSC_COMM_WORLD));
    if (error) exit_code = QuoinErrorExitCode(error);
    if (error && !QuoinErrorIsShared(error)) MPI_Abort(PETSC_COMM_WORLD, exit_code);
  }
  PetscCall(PetscFinalize());
  free(words);
  return exit_code;
}

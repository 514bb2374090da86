/* petsc_options.c: handles options of the solvers of PETSc and SLEPc. They are no keys of the scene, but they
   change the results of the solvers: -mat_no_inode changes the order of sums, -pc_type the preconditioner. So
   a run with such options reports them, and keeps them with its own options and its results; a restart
   detects a change. Options of viewers of the state, -displacement_view and so on, only print. */
#include "scene/scene.h"
#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static PetscBool begins_with_any(const char *name, const char *const *words)
{
  for (; *words; words++)
    if (!strncmp(name, *words, strlen(*words))) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool is_of_solvers(const char *name)
{
  static const char *const solvers[] = {"ksp_", "pc_", "mat_", "vec_", "sub_", "snes_", "ts_", "tao_",
                                        "dm_",  "is_", "sf_",  "eps_", "st_",  "bv_",   "ds_", NULL};
  return begins_with_any(name, solvers);
}

/* Decides whether an option of a solver only prints. */
static PetscBool prints(const char *name)
{
  static const char *const words[] = {"monitor", "view", "converged_reason", "print", NULL};
  for (const char *const *w = words; *w; w++)
    if (strstr(name, *w)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- viewers of the state */

const char *const StateVecNames[STATE_VEC_NAMES] = {[STATE_DISPLACEMENT] = "displacement",
                                                    [STATE_VELOCITY] = "velocity",
                                                    [STATE_FORCE] = "force",
                                                    [STATE_LOAD] = "load",
                                                    [STATE_MASS] = "mass"};

PetscBool IsStateView(const char *option)
{
  char view[NAME_LENGTH];
  for (int i = 0; i < STATE_VEC_NAMES; i++) {
    snprintf(view, sizeof(view), "%s_view", StateVecNames[i]);
    if (!strcmp(option, view)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Decides whether this build of PETSc has a viewer "type:file:format:mode"; a stage may take hours before it
   uses the viewer. */
static PetscBool has_viewer(const char *value)
{
  static const char *const types[] = {"",     "ascii", "binary", "draw",
#ifdef PETSC_HAVE_HDF5
                                      "hdf5",
#endif
                                      NULL};
  const size_t n = strcspn(value, ":");
  for (const char *const *type = types; *type; type++)
    if (strlen(*type) == n && !strncmp(value, *type, n)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Finds the file of a viewer, "": it prints or draws. PETSc replaces ${NAME} by values of the environment, so
   such a name is not checked. */
static void file_of(const char *value, char file[PETSC_MAX_PATH_LEN])
{
  const size_t type = strcspn(value, ":");
  const char *name = value[type] ? value + type + 1 : "";
  snprintf(file, PETSC_MAX_PATH_LEN, "%.*s", (int)strcspn(name, ":"), name);
  if (!strncmp(value, "draw:", 5) || strchr(file, '$')) file[0] = 0;
}

/* Returns the reason (errno) why a file cannot be written, 0: there is none. */
static int cannot_write(const char *file)
{
  struct stat there;
  char folder[PETSC_MAX_PATH_LEN + 1];
  const char *slash = strrchr(file, '/');
  if (!stat(file, &there)) return S_ISDIR(there.st_mode) ? EISDIR : access(file, W_OK) ? errno : 0;
  snprintf(folder, sizeof(folder), "%.*s.", slash ? (int)(slash - file) + 1 : 0, file);
  return access(folder, W_OK | X_OK) ? errno : 0;
}

PetscErrorCode StateViewsCheck(MPI_Comm comm, PetscBool files)
{
  char message[MESSAGE_LENGTH] = "", file[PETSC_MAX_PATH_LEN];
  PetscMPIInt rank;
  PetscInt n;
  char **names, **values;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values)); // none of them has been read yet
  for (PetscInt i = 0; i < n; i++) {
    const char *value = values[i] ? values[i] : "";
    if (!IsStateView(names[i])) continue;
    if (!has_viewer(value))
      PetscCall(PetscSNPrintf(message, sizeof(message),
                              "command line: -%s %.200s: expected ascii, binary, draw or hdf5, as "
                              "-%s binary:file.bin",
                              names[i], value, names[i]));
    file_of(value, file);
    const int why = files && !rank && file[0] ? cannot_write(file) : 0;
    if (why)
      PetscCall(PetscSNPrintf(message, sizeof(message), "command line: -%s %.800s: cannot write the file: %s",
                              names[i], value, strerror(why)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscCall(CheckMessage(comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- options of solvers */

/* Collects "-name value -name"; free the text with free(). */
static PetscErrorCode solver_options(char **text)
{
  char *all, *end = NULL;
  PetscBool taken = PETSC_FALSE;
  size_t size;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetAll(NULL, &all));
  FILE *f = open_memstream(text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  for (char *word = strtok_r(all, " \n", &end); word; word = strtok_r(NULL, " \n", &end)) {
    const PetscBool is_name = (PetscBool)(word[0] == '-' && isalpha((unsigned char)word[1]));
    if (is_name) taken = (PetscBool)(is_of_solvers(word + 1) && !prints(word + 1));
    if (taken) fprintf(f, "%s%s", ftell(f) ? " " : "", word);
  }
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SolverOptionsTake(Scene *scene)
{
  static const char line[] = "%spetsc_options %s\n";
  PetscFunctionBeginUser;
  PetscCall(solver_options(&scene->solvers));
  if (!scene->solvers[0]) {
    free(scene->solvers);
    scene->solvers = NULL;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const size_t size = sizeof(line) + strlen(scene->options) + strlen(scene->solvers);
  char *text = malloc(size);
  PetscCheck(text, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  snprintf(text, size, line, scene->options, scene->solvers);
  free(scene->options);
  scene->options = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SolverOptionsWarnUnread(MPI_Comm comm)
{
  PetscInt n;
  char **names, **values;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++)
    if (is_of_solvers(names[i]) || IsStateView(names[i]))
      PetscCall(PetscFPrintf(comm, stderr, "quoin: warning: command line: -%s was read by nothing that ran\n",
                             names[i]));
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

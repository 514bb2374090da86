/* petsc_options.c: options of PETSc's solvers. They are no keys of the scene, but they change what the
   solvers return: -mat_no_inode changes the order of sums, -pc_type the preconditioner. So a run with such
   options says so, and keeps them with its own options and its results; a restart tells when they change.
   Options of viewers of the state, -displacement_view and so on, only print. */
#include "scene/scene.h"
#include <ctype.h>
#include <stdlib.h>

static PetscBool begins_with_any(const char *name, const char *const *words)
{
  for (; *words; words++)
    if (!strncmp(name, *words, strlen(*words))) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool is_of_solvers(const char *name)
{
  static const char *const solvers[] = {"ksp_", "pc_",  "mat_", "vec_", "sub_", "snes_",
                                        "ts_",  "tao_", "dm_",  "is_",  "sf_",  NULL};
  return begins_with_any(name, solvers);
}

/* Whether an option of a solver only prints. */
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

/* Whether PETSc, as it was built, has a viewer "type:file:format:mode" of these; a stage may take hours to
   come to it. */
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

PetscErrorCode StateViewsCheck(MPI_Comm comm)
{
  char message[MESSAGE_LENGTH] = "";
  PetscInt n;
  char **names, **values;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values)); // none of them has been read yet
  for (PetscInt i = 0; i < n; i++)
    if (IsStateView(names[i]) && !has_viewer(values[i] ? values[i] : ""))
      PetscCall(PetscSNPrintf(message, sizeof(message),
                              "command line: -%s %.200s: expected ascii, binary, draw or hdf5, as "
                              "-%s binary:file.bin",
                              names[i], values[i], names[i]));
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

PetscErrorCode SolverOptionsTellUnread(MPI_Comm comm)
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

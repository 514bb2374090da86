/* fuzz.h: what the fuzz targets share. A target turns bytes into a scene or a block mesh and sets Quoin up
   with it, on one rank. Whatever the bytes: no report of a sanitizer, no hang, and either a model that is set
   up or PETSC_ERR_USER_INPUT with one line of message. Any other error code is a finding. With QUOIN_FUZZ_SAY
   in the environment messages are shown. Built with -DQUOIN_FUZZ=ON and clang; run by tests/fuzz/run.py. */
#pragma once
#include "internal.h"
#include <stdlib.h>
#include <unistd.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A file in memory (tmpfs) of this process, written anew each time; path receives its name. */
static inline void FuzzFile(const char *what, const void *data, size_t size, char path[64])
{
  snprintf(path, 64, "/dev/shm/quoin-fuzz-%ld.%s", (long)getpid(), what);
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(data, 1, size, file) != size || fclose(file)) abort();
}

static inline PetscErrorCode FuzzQuiet(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message,
                                       void *context)
{
  (void)comm, (void)line, (void)function, (void)file, (void)context;
  if (type == PETSC_ERROR_INITIAL && getenv("QUOIN_FUZZ_SAY")) fprintf(stderr, "%s\n", message);
  if (type == PETSC_ERROR_INITIAL && code == PETSC_ERR_USER_INPUT &&
      (strchr(message, '\n') || strlen(message) < 8))
    abort();
  return code;
}

static inline void FuzzStart(void)
{
  static char *words[] = {"fuzz", "-no_signal_handler", NULL};
  char **argv = words;
  int argc = 2;
  if (PetscInitialize(&argc, &argv, NULL, NULL)) abort();
  if (PetscPushErrorHandler(FuzzQuiet, NULL)) abort();
}

/* From files to a model that is ready to run. */
static inline void FuzzSetUp(const char *scene, const char *model)
{
  char *argv[] = {"quoin", "-model", (char *)(uintptr_t)model, NULL};
  Quoin q = NULL;
  PetscErrorCode code = QuoinCreate(PETSC_COMM_SELF, &q);
  if (!code) code = QuoinSetFromOptions(q, scene, 3, argv);
  if (!code) code = QuoinSetUp(q);
  if (code && code != PETSC_ERR_USER_INPUT) abort();
  if (QuoinDestroy(&q)) abort();
}

/* From files to a model that is ready to run, when it has a block mesh that can be read: most have none, and
   the scene, always the same, is read in vain. */
static inline void FuzzMesh(const char *scene, const char *model)
{
  BlockMesh mesh;
  const PetscErrorCode code = MeshRead(PETSC_COMM_SELF, model, &mesh);
  if (code && code != PETSC_ERR_USER_INPUT) abort();
  if (code) return;
  if (MeshDestroy(&mesh)) abort();
  FuzzSetUp(scene, model);
}

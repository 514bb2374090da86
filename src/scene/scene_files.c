/* scene_files.c: reads the text of a scene, and finds its model. */
#include "scene/reader.h"
#include <errno.h>

enum { LARGEST_SCENE = 1 << 24 }; /* [byte] */

// Gives the text of the file to all ranks; NULL and a message if nobody can read the file. Free it with
// PetscFree.
PetscErrorCode SceneText(MPI_Comm comm, const char *path, char **text, PetscInt *length, char *message)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  *length = -1;
  *text = NULL;
  if (rank == 0) {
    errno = 0;
    FILE *file = fopen(path, "rb");
    long size = file && !fseek(file, 0, SEEK_END) ? ftell(file) : -1;
    if (size >= 0 && size < LARGEST_SCENE) {
      rewind(file);
      PetscCall(PetscMalloc1(size + 1, text));
      if (fread(*text, 1, size, file) == (size_t)size) *length = (PetscInt)size;
    }
    if (size >= LARGEST_SCENE)
      Complain(message, path, -1, "", "cannot read the scene: not a file of up to %d bytes", LARGEST_SCENE);
    else if (*length < 0)
      Complain(message, path, -1, "", "cannot read the scene: %s", errno ? strerror(errno) : "no file");
    if (file) fclose(file);
  }
  PetscCallMPI(MPI_Bcast(length, 1, MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(message, MESSAGE_LENGTH, MPI_CHAR, 0, comm));
  if (*length >= 0 && rank) PetscCall(PetscMalloc1(*length + 1, text));
  if (*length >= 0) PetscCallMPI(MPI_Bcast(*text, *length, MPI_CHAR, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Finds the model in the working directory or beside the scene.
PetscErrorCode SceneFindModel(MPI_Comm comm, Scene *scene)
{
  char beside[PETSC_MAX_PATH_LEN];
  const char *slash = strrchr(scene->file, '/');
  PetscBool here = PETSC_FALSE, there = PETSC_FALSE;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0 && slash && scene->model[0] != '/') {
    int n = snprintf(beside, sizeof beside, "%.*s/%s", (int)(slash - scene->file), scene->file, scene->model);
    PetscCall(PetscTestFile(scene->model, 'r', &here));
    if (!here && n < (int)sizeof beside) PetscCall(PetscTestFile(beside, 'r', &there));
    if (there) memcpy(scene->model, beside, sizeof beside);
  }
  PetscCallMPI(MPI_Bcast(scene->model, PETSC_MAX_PATH_LEN, MPI_CHAR, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

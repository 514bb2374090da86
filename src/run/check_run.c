/* check_run.c: checks what mesh, scene and ranks must fulfil together, and warns of them. */
#include "run/run.h"

PetscErrorCode MeshCheckRun(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank, size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (rank == 0) {
    char fault[MESSAGE_LENGTH] = "";
    PetscCall(MeshCheck(mesh, scene->overlap_tolerance, fault));
    if (fault[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: %s", scene->model, fault));
    else if (size > mesh->n_blocks)
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: %d ranks for %" PetscInt_FMT
                              " blocks: expected at most one rank per block",
                              scene->model, size, mesh->n_blocks));
  }
  PetscCall(CheckMessage(comm, message));
  if (rank == 0)
    WarnSlender(mesh), WarnLocking(scene), WarnExplicit(scene), WarnElastic(scene), WarnShear(scene),
        WarnApex(scene), WarnLaws(scene), WarnImplausible(scene, mesh);
  PetscFunctionReturn(PETSC_SUCCESS);
}

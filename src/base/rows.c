/* rows.c: gathers rows of all ranks on rank 0 or on all ranks. */
#include "base/base.h"

PetscErrorCode GatherBytes(MPI_Comm comm, PetscInt n, size_t unit, const void *rows, PetscInt *n_all,
                           void **all)
{
  PetscMPIInt rank, size, mine, *counts = NULL, *starts = NULL;
  MPI_Datatype row;
  PetscInt total = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMPIIntCast(n, &mine));
  if (!rank) PetscCall(PetscMalloc2(size, &counts, size, &starts));
  PetscCallMPI(MPI_Gather(&mine, 1, MPI_INT, counts, 1, MPI_INT, 0, comm));
  for (PetscMPIInt r = 0; !rank && r < size; r++) {
    PetscCall(PetscMPIIntCast(total, &starts[r]));
    total += counts[r];
  }
  *all = NULL;
  if (!rank) PetscCall(PetscMalloc((size_t)PetscMax(total, 1) * unit, all));
  PetscCallMPI(MPI_Type_contiguous((int)unit, MPI_BYTE, &row));
  PetscCallMPI(MPI_Type_commit(&row));
  PetscCallMPI(MPI_Gatherv(rows, mine, row, *all, counts, starts, row, 0, comm));
  PetscCallMPI(MPI_Type_free(&row));
  if (!rank) PetscCall(PetscFree2(counts, starts));
  *n_all = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherAndFree(MPI_Comm comm, PetscInt n, size_t unit, void *rows, PetscInt *n_all, void **all)
{
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) {
    *n_all = n, *all = rows;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(GatherBytes(comm, n, unit, rows, n_all, all));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherToAll(MPI_Comm comm, PetscInt n, size_t unit, const void *rows, PetscInt *n_all,
                           void **all)
{
  PetscMPIInt size, mine, *counts, *starts;
  MPI_Datatype row;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMPIIntCast(n, &mine));
  PetscCall(PetscMalloc2(size, &counts, size + 1, &starts));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, counts, 1, MPI_INT, comm));
  starts[0] = 0;
  for (PetscMPIInt r = 0; r < size; r++)
    PetscCall(PetscMPIIntCast((PetscInt)starts[r] + counts[r], &starts[r + 1]));
  *n_all = starts[size];
  PetscCall(PetscMalloc((size_t)PetscMax(*n_all, 1) * unit, all));
  PetscCallMPI(MPI_Type_contiguous((int)unit, MPI_BYTE, &row));
  PetscCallMPI(MPI_Type_commit(&row));
  if (*n_all) PetscCallMPI(MPI_Allgatherv(rows, mine, row, *all, counts, starts, row, comm));
  PetscCallMPI(MPI_Type_free(&row));
  PetscCall(PetscFree2(counts, starts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherSorted(MPI_Comm comm, PetscInt n, size_t unit, void *rows,
                            int (*order)(const void *, const void *), PetscInt *n_all, void **all)
{
  PetscFunctionBeginUser;
  PetscCall(GatherToAll(comm, n, unit, rows, n_all, all));
  PetscCall(PetscFree(rows));
  qsort(*all, (size_t)*n_all, unit, order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GatherPlaced(MPI_Comm comm, PetscInt n, const PetscInt *place, size_t unit, const void *rows,
                            PetscInt n_all, void *all)
{
  PetscInt n_places, n_rows, *places;
  char *gathered, *placed = NULL;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(GatherBytes(comm, n, sizeof(PetscInt), place, &n_places, (void **)&places));
  PetscCall(GatherBytes(comm, n, unit, rows, &n_rows, (void **)&gathered));
  if (!rank) PetscCall(PetscCalloc1(8 + (size_t)n_all * unit, &placed));
  for (PetscInt i = 0; i < n_rows && placed; i++)
    PetscCall(PetscMemcpy(placed + (size_t)places[i] * unit, gathered + (size_t)i * unit, unit));
  *(void **)all = placed;
  PetscCall(PetscFree(places));
  PetscCall(PetscFree(gathered));
  PetscFunctionReturn(PETSC_SUCCESS);
}

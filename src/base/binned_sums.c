/* binned_sums.c: sums many terms into few slots, with the same bits on any number of ranks
   (reproducible.h). */
#include "base/reproducible.h"

PetscErrorCode BinnedSums(MPI_Comm comm, PetscInt n, const PetscInt *slot, const PetscReal *term,
                          PetscInt n_slots, PetscReal *sum)
{
  PetscReal *bound, *part; // (n_slots,) largest size of a term; (n_slots,2)
  PetscMPIInt count;
  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(2 * n_slots, &count));
  PetscCall(PetscCalloc2(n_slots, &bound, 2 * n_slots, &part));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = PetscAbsReal(term[i]);
    bound[slot[i]] = size <= PETSC_MAX_REAL ? PetscMax(bound[slot[i]], size) : INFINITY;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, count / 2, MPIU_REAL, MPI_MAX, comm));
  for (PetscInt i = 0; i < n; i++) {
    const Bins bins = BinsFor(PetscMin(bound[slot[i]], PETSC_MAX_REAL));
    BinAdd(&bins, term[i], part + 2 * slot[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, part, count, MPIU_REAL, MPI_SUM, comm));
  for (PetscInt i = 0; i < n_slots; i++)
    sum[i] = bound[i] <= PETSC_MAX_REAL ? part[2 * i] + part[2 * i + 1] : NAN;
  PetscCall(PetscFree2(bound, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

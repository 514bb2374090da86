/* shared.c: windows of MPI's shared memory, and waiting in them. */
#include "shared.h"
#include <sched.h>

PetscErrorCode SharedRanks(MPI_Comm comm, PetscMPIInt *here)
{
  MPI_Comm machine;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_size(machine, here));
  PetscCallMPI(MPI_Comm_free(&machine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start of the first whole line. Every rank sees the window at another address, but all at the start of a
   page: they agree on it. */
static void *first_line(void *part)
{
  return (char *)part + (SHARED_LINE - (uintptr_t)part % SHARED_LINE) % SHARED_LINE;
}

PetscErrorCode SharedCreate(MPI_Comm comm, size_t bytes, Shared *s)
{
  MPI_Info info;
  void *part;
  PetscFunctionBeginUser;
  s->comm = comm, s->bytes = bytes;
  PetscCallMPI(MPI_Info_create(&info));
  // pages of its own for each rank: near the processor that writes them
  PetscCallMPI(MPI_Info_set(info, "alloc_shared_noncontig", "true"));
  PetscCallMPI(
      MPI_Win_allocate_shared((MPI_Aint)(bytes + SHARED_LINE), 1, info, comm, (void *)&part, &s->window));
  PetscCallMPI(MPI_Info_free(&info));
  PetscCallMPI(MPI_Win_lock_all(MPI_MODE_NOCHECK, s->window));
  s->mine = first_line(part);
  PetscCall(PetscMemzero(s->mine, bytes));
  PetscCallMPI(MPI_Win_sync(s->window));
  PetscCallMPI(MPI_Barrier(comm)); // nobody reads what is not yet zero
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SharedDestroy(Shared *s)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Win_unlock_all(s->window));
  PetscCallMPI(MPI_Win_free(&s->window));
  s->mine = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SharedOf(const Shared *s, PetscMPIInt rank, void *part)
{
  MPI_Aint size;
  int unit;
  void *start;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Win_shared_query(s->window, rank, &size, &unit, (void *)&start));
  *(void **)part = first_line(start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A neighbour with as much work comes within a microsecond; one that comes later may want this processor, or
   an answer to a message. */
enum { SPINS = 50 };

PetscErrorCode SharedWait(MPI_Comm comm, const Count *count, uint64_t n)
{
  PetscFunctionBeginUser;
  for (int spin = 0; atomic_load_explicit(count, memory_order_acquire) < n; spin++) {
    if (spin < SPINS) {
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
      continue;
    }
    int found;
    PetscCallMPI(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm, &found, MPI_STATUS_IGNORE));
    sched_yield();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

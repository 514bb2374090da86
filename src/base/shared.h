/* shared.h: memory that the ranks of one machine share, and how one rank waits for another there.

   A rank with something to tell writes it and then sets a counter; a rank that wants to know waits for the
   counter and then reads. Two copies take turns, so nobody waits before writing: to write the same copy
   again, a rank must have seen the counters that its readers set at the exchange between, and a reader sets
   its counter only after it has read. */
#pragma once
#include "base/base.h"
#include <stdatomic.h>
#include <stdint.h>

enum { SHARED_LINE = 128 }; /* [B] processors fetch cache lines in pairs */

typedef _Atomic uint64_t Count;

typedef struct {
  MPI_Comm comm;
  MPI_Win window;
  size_t bytes; /* of each rank's share */
  void *mine;   /* this rank's share, at the start of a line; zero at first */
} Shared;

/* Collective. The number of ranks on this rank's machine, itself included. */
PetscErrorCode SharedRanks(MPI_Comm comm, PetscMPIInt *here);
/* Collective, as is SharedDestroy. bytes: size of this rank's share, the same on all ranks or not. mine stays
   NULL where the system gives no such memory; a warning says so once. */
PetscErrorCode SharedCreate(MPI_Comm comm, size_t bytes, Shared *shared);
PetscErrorCode SharedDestroy(Shared *shared);
/* The share of another rank. */
PetscErrorCode SharedOf(const Shared *shared, PetscMPIInt rank, void *share);

/* Whatever was written before this call is there for all who wait for n, or for less. */
static inline void SharedPublish(Count *count, uint64_t n)
{
  atomic_store_explicit(count, n, memory_order_release);
}
/* Waits until another rank has told n. comm: MPI's progress on its messages goes on meanwhile. */
PetscErrorCode SharedWait(MPI_Comm comm, const Count *count, uint64_t n);

/* shared.h: declares memory that the ranks of one machine share, in which one rank waits for another.

   A sender writes its data and then sets a counter; a receiver waits for the counter and then reads. Two
   copies alternate, so nobody waits before writing: before a rank writes the same copy again, it has seen
   the counters that its readers set at the exchange between, and a reader sets its counter only after
   reading. */
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

/* Collective. Returns the number of ranks on this machine, including this one. */
PetscErrorCode SharedRanks(MPI_Comm comm, PetscMPIInt *here);
/* Collective, as is SharedDestroy. Allocates the share of each rank. bytes: size of this rank's share.
   mine stays NULL if the system gives no such memory; a warning is printed once. */
PetscErrorCode SharedCreate(MPI_Comm comm, size_t bytes, Shared *shared);
PetscErrorCode SharedDestroy(Shared *shared);
/* Returns the share of another rank. */
PetscErrorCode SharedOf(const Shared *shared, PetscMPIInt rank, void *share);

/* Sets the counter to n. Whatever was written before is visible to all who wait for n or less. */
static inline void SharedPublish(Count *count, uint64_t n)
{
  atomic_store_explicit(count, n, memory_order_release);
}
/* Waits until another rank has published n. Messages of MPI on comm progress meanwhile. */
PetscErrorCode SharedWait(MPI_Comm comm, const Count *count, uint64_t n);

/* shared.h: memory that the ranks of one machine share, and how one waits for another there.

   Whoever has something to tell writes it and then sets a counter behind it; whoever wants to know waits for
   the counter and then reads. Two copies take turns: to tell something for the second time after that, a rank
   must have seen the counters of those who read it at the next exchange, and these they set when they have
   read. So nobody waits before writing. */
#pragma once
#include "base/base.h"
#include <stdatomic.h>
#include <stdint.h>

enum { SHARED_LINE = 128 }; /* [B] processors fetch cache lines in pairs */

typedef _Atomic uint64_t Count;

typedef struct {
  MPI_Comm comm;
  MPI_Win window;
  size_t bytes; /* of each rank's part */
  void *mine;   /* this rank's part, at the start of a line; zero at first */
} Shared;

/* Collective. How many ranks run on the machine of this one, itself included. */
PetscErrorCode SharedRanks(MPI_Comm comm, PetscMPIInt *here);
/* Collective, as is its end. bytes: of each rank, the same or not. mine stays NULL where the system gives no
   such memory, which is told once. */
PetscErrorCode SharedCreate(MPI_Comm comm, size_t bytes, Shared *shared);
PetscErrorCode SharedDestroy(Shared *shared);
/* The part of another rank. */
PetscErrorCode SharedOf(const Shared *shared, PetscMPIInt rank, void *part);

/* What was written before is there for all who wait for n, or for less. */
static inline void SharedTell(Count *count, uint64_t n)
{
  atomic_store_explicit(count, n, memory_order_release);
}
/* Until another rank has told n. comm: whose messages go on meanwhile. */
PetscErrorCode SharedWait(MPI_Comm comm, const Count *count, uint64_t n);

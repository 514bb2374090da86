/* shared.c: allocates windows of MPI's shared memory, and lets a rank wait in them. */
#include "base/base.h"
#include "base/shared.h"
#include <sched.h>
#include <sys/statvfs.h>
#include <unistd.h>

PetscErrorCode SharedRanks(MPI_Comm comm, PetscMPIInt *here)
{
  MPI_Comm machine;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_size(machine, here));
  PetscCallMPI(MPI_Comm_free(&machine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the start of the first whole cache line. Every rank sees the window at another address, but
   always from the start of a page, so all ranks find the same line. */
static void *first_line(void *share)
{
  return (char *)share + (SHARED_LINE - (uintptr_t)share % SHARED_LINE) % SHARED_LINE;
}

/* Warns once a run, on rank 0, that ranks exchange messages instead of shared memory. */
static void warn_messages(MPI_Comm comm)
{
  static PetscBool warned;
  PetscMPIInt rank;
  MPI_Comm_rank(comm, &rank);
  if (!rank && !warned)
    Warn("no memory that ranks can share (is /dev/shm too small?): they exchange messages, "
         "which is slower");
  warned = PETSC_TRUE;
}

/* Returns whether the folder in which MPI libraries make the file of the memory has room. If there is no
   /dev/shm to write into, Open MPI takes a folder of its own, whose room is not known; a folder that the user
   has chosen it takes in any case. */
static PetscBool folder_has_room(PetscReal bytes)
{
  const char *chosen = getenv("OMPI_MCA_osc_sm_backing_directory"), *folder = chosen ? chosen : "/dev/shm";
  struct statvfs disk;
  if (access(folder, W_OK) || statvfs(folder, &disk)) return (PetscBool)!chosen;
  const PetscBool name = (PetscBool)(!disk.f_files || disk.f_favail); // for one more file
  return (PetscBool)(name && (PetscReal)disk.f_bavail * (PetscReal)disk.f_frsize > bytes);
}

/* Returns whether this process has addresses left for the memory of all ranks, of which it sees all. */
static PetscBool addresses_left(size_t bytes)
{
  void *volatile probe = malloc(bytes); // volatile: a compiler may omit an unused malloc
  const PetscBool left = (PetscBool) !!probe;
  free(probe);
  return left;
}

/* Collective. Decides whether there is room for the memory on every rank. Open MPI 4.1 leaves its ranks
   waiting for each other if one of them finds none, and a file that is larger than its disk ends the rank
   that writes first. */
static PetscErrorCode has_room(MPI_Comm comm, size_t bytes, int *room)
{
  enum { PAGE = 4096, EACH = 16 * PAGE }; /* upper bound of the library's overhead per rank */
  PetscReal total = (PetscReal)(bytes + EACH);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPIU_REAL, MPI_SUM, comm));
  *room = folder_has_room(total) && addresses_left((size_t)total);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, room, 1, MPI_INT, MPI_MIN, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SharedCreate(MPI_Comm comm, size_t bytes, Shared *s)
{
  MPI_Errhandler kept;
  MPI_Info info;
  void *share;
  int good;
  PetscFunctionBeginUser;
  s->comm = comm, s->bytes = bytes, s->mine = NULL;
  PetscCall(has_room(comm, bytes, &good));
  if (!good) {
    warn_messages(comm);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Info_create(&info));
  // each rank gets its own pages, near the processor that writes them
  PetscCallMPI(MPI_Info_set(info, "alloc_shared_noncontig", "true"));
  PetscCallMPI(MPI_Comm_get_errhandler(comm, &kept));
  PetscCallMPI(MPI_Comm_set_errhandler(comm, MPI_ERRORS_RETURN));
  good = !MPI_Win_allocate_shared((MPI_Aint)(bytes + SHARED_LINE), 1, info, comm, (void *)&share, &s->window);
  PetscCallMPI(MPI_Comm_set_errhandler(comm, kept));
  if (kept != MPI_ERRORS_RETURN && kept != MPI_ERRORS_ARE_FATAL) PetscCallMPI(MPI_Errhandler_free(&kept));
  PetscCallMPI(MPI_Info_free(&info));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, comm));
  if (!good) { // if only some ranks have a window it is not freed: freeing is collective
    warn_messages(comm);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Win_lock_all(MPI_MODE_NOCHECK, s->window));
  s->mine = first_line(share);
  PetscCall(PetscMemzero(s->mine, bytes));
  PetscCallMPI(MPI_Win_sync(s->window));
  PetscCallMPI(MPI_Barrier(comm)); // the zeros are written before anybody reads
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

PetscErrorCode SharedOf(const Shared *s, PetscMPIInt rank, void *share)
{
  MPI_Aint size;
  int unit;
  void *start;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Win_shared_query(s->window, rank, &size, &unit, (void *)&start));
  *(void **)share = first_line(start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A neighbour with equal work arrives within a microsecond. A later one may need this processor, or an
   answer to a message, so the wait yields after these spins. */
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

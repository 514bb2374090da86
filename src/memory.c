/* memory.c: whether a model fits into the memory of this machine, asked before it is read. Linux. */
#include "internal.h"
#include <malloc.h>
#include <sys/resource.h>

/* [byte] The most that an explicit run takes, measured on 1, 2 and 4 ranks, one body of 1e3 to 4e5 blocks and
   bodies of 1, 4 and 16 of them, results and checkpoint included, to -10 and +20 %: a rank by itself; per
   vertex and contact of the whole model on rank 0, which reads, gathers and writes; per vertex and block of
   its own on any other. */
static const double PER_RANK = 52e6, PER_VERTEX = 920., PER_CONTACT = 950., PER_OWN_VERTEX = 530.,
                    PER_OWN_BLOCK = 340.;

/* Number behind a word in a file such as /proc/meminfo, in kB; -1: not there. */
static double kilobytes(const char *path, const char *word)
{
  char line[256];
  double value = -1.;
  FILE *f = fopen(path, "r");
  while (f && fgets(line, sizeof(line), f))
    if (!strncmp(line, word, strlen(word))) value = strtod(line + strlen(word), NULL);
  if (f) fclose(f);
  return value;
}

/* The one number of a file; infinite when it is not there, or says max. */
static double number_in(const char *path)
{
  char line[64] = "max";
  FILE *f = fopen(path, "r");
  if (f && !fgets(line, sizeof(line), f)) line[0] = 'm';
  if (f) fclose(f);
  return line[0] == 'm' ? (double)INFINITY : strtod(line, NULL);
}

double MemoryAvailable(void)
{
  const double free = 1024. * kilobytes("/proc/meminfo", "MemAvailable:"),
               group = number_in("/sys/fs/cgroup/memory.max") - number_in("/sys/fs/cgroup/memory.current");
  double least = free > 0. ? free : (double)INFINITY;
  struct rlimit limit;
  if (group < least) least = group;
  if (!getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur != RLIM_INFINITY) {
    const double left = (double)limit.rlim_cur - 1024. * kilobytes("/proc/self/status", "VmSize:");
    if (left < least) least = left;
  }
  return least;
}

/* Set-up and output take and free arrays larger than what a run keeps. MPI libraries tell the C library to
   hold on to freed memory; arrays with pages of their own go back to the system: from 256 KB on, so that
   those of some 1e4 vertices do. */
void MemoryReturnFreed(void)
{
#ifdef __GLIBC__
  (void)mallopt(M_MMAP_MAX, 65536);
  (void)mallopt(M_MMAP_THRESHOLD, 1 << 18);
#endif
}

double MemoryOfRank(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, PetscMPIInt size,
                    PetscMPIInt rank)
{
  const double vertices = (double)n_vertices, blocks = (double)n_blocks;
  if (rank) return PER_RANK + (PER_OWN_VERTEX * vertices + PER_OWN_BLOCK * blocks) / (double)size;
  return PER_RANK + PER_VERTEX * vertices + PER_CONTACT * n_contacts;
}

/* Contacts before any are known: square bodies of k by k blocks have (1 + 1/k)^2 vertices a block and 2/k
   contacts. */
double MemoryNeeded(PetscInt n_vertices, PetscInt n_blocks, PetscMPIInt size, PetscMPIInt local)
{
  const double side = sqrt((double)n_vertices / PetscMax(1., (double)n_blocks)) - 1.; // 1/k
  double sum = 0.;
  for (PetscMPIInt rank = 0; rank < local; rank++)
    sum += MemoryOfRank(n_vertices, n_blocks, 2. * PetscMax(0., side) * (double)n_blocks, size, rank);
  return sum;
}

/* memory.c: estimates the memory that a model takes, and reads how much this machine has, before the model
   is read. Linux only. */
#include "base/base.h"
#include "base/memory.h"
#include <malloc.h>
#include <math.h>
#include <sys/resource.h>

/* [byte] Peak of an explicit run: of a rank by itself; per vertex and contact of the whole model on rank
   0, which reads, gathers and writes; per own vertex and block on any other rank. The numbers were
   measured on 1 and 2 ranks, with one body of 6e4 and 2.5e5 blocks and with bodies of 1 and 16 blocks,
   results and checkpoint included. They hold to -10 and +25 %. */
static const double PER_RANK = 52e6, PER_VERTEX = 1000., PER_CONTACT = 30., PER_OWN_VERTEX = 530.,
                    PER_OWN_BLOCK = 340.;
/* [byte] Besides, where joints or blocks can fail: the four means of motion and forces by which a collapse is
   judged (rest_point.c), two numbers a vertex each. Per own vertex the means themselves. Per vertex of the
   whole model, on rank 0, a copy for the checkpoint. Measured on one rank with 3.2e4 to 6.3e4 vertices in one
   body and in single blocks: 63 and 133 together. */
static const double PER_FAILING_OWN = 64., PER_FAILING_VERTEX = 64.;

/* [byte] Newton's method, beyond what an explicit run keeps while cycles run: per degree of freedom a + b
   log2 n, for matrices, factor and what makes the factor; per entry of the dense blocks of condensed bodies.
   The form is the fill of a plane mesh after nested dissection. The numbers were measured on 1, 2 and 4
   ranks, with 2e4 to 2e6 degrees of freedom in one body, single blocks and bodies of 4 and 16 blocks. They
   hold to -15 and +10 % (CHOLMOD on one rank, MUMPS on several). */
static const double PER_DOF[2][2] = {{420., 100.}, {1500., 60.}}, PER_DENSE = 40.;
/* [byte] Kept by an explicit run while cycles run: per vertex, block, contact. */
static const double KEPT_VERTEX = 360., KEPT_BLOCK = 29., KEPT_CONTACT = 194.;
/* [byte] Per condensed body, in addition to its factor by MUMPS; and per entry of its reduced matrix, here
   and in MUMPS. */
static const double PER_BODY = 6e4, PER_SCHUR = 16.;

static double limit_set = INFINITY; /* [byte] limit for all ranks of a machine */

/* Returns the number after a word in a file such as /proc/meminfo, in kB; -1: the word is missing. */
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

/* Returns the single number of a file; infinite if the file is missing, or contains max. */
static double number_in(const char *path)
{
  char line[64] = "max";
  FILE *f = fopen(path, "r");
  if (f && !fgets(line, sizeof(line), f)) line[0] = 'm';
  if (f) fclose(f);
  return line[0] == 'm' ? (double)INFINITY : strtod(line, NULL);
}

void MemorySetLimit(double bytes)
{
  limit_set = bytes > 0. ? bytes : (double)INFINITY;
}

double MemoryAvailable(void)
{
  const double free = 1024. * kilobytes("/proc/meminfo", "MemAvailable:"),
               group = number_in("/sys/fs/cgroup/memory.max") - number_in("/sys/fs/cgroup/memory.current");
  double least = free > 0. ? free : (double)INFINITY;
  struct rlimit limit;
  if (group < least) least = group;
  if (limit_set < least) least = limit_set;
  if (!getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur != RLIM_INFINITY) {
    const double left = (double)limit.rlim_cur - 1024. * kilobytes("/proc/self/status", "VmSize:");
    if (left < least) least = left;
  }
  return least;
}

/* Lets freed memory go back to the system. Set-up and output need larger arrays than a run keeps, and MPI
   libraries make the C library keep freed memory. Arrays with pages of their own go back anyway; the
   threshold of 256 KB includes arrays of some 1e4 vertices. */
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

double MemoryOfFailing(PetscInt n_vertices, PetscMPIInt size, PetscMPIInt rank)
{
  return (PER_FAILING_OWN / (double)size + (rank ? 0. : PER_FAILING_VERTEX)) * (double)n_vertices;
}

/* Estimates the number of contacts, which are not known yet: square bodies of k by k blocks have (1 +
   1/k)^2 vertices a block and 2/k contacts. */
double MemoryNeeded(PetscInt n_vertices, PetscInt n_blocks, PetscMPIInt size, PetscMPIInt local)
{
  const double side = sqrt((double)n_vertices / PetscMax(1., (double)n_blocks)) - 1.; // 1/k
  double sum = 0.;
  for (PetscMPIInt rank = 0; rank < local; rank++)
    sum += MemoryOfRank(n_vertices, n_blocks, 2. * PetscMax(0., side) * (double)n_blocks, size, rank);
  return sum;
}

/* Solves with a dense matrix of one entry: this makes BLAS allocate its working memory. */
static PetscErrorCode call_blas(void)
{
  Mat A;
  Vec x, b;
  PetscFunctionBeginUser;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &A));
  PetscCall(MatSetValue(A, 0, 0, 1., INSERT_VALUES));
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatCreateVecs(A, &x, &b));
  PetscCall(MatLUFactor(A, NULL, NULL, NULL));
  PetscCall(MatSolve(A, b, x));
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&b));
  PetscCall(MatDestroy(&A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets OpenBLAS allocate its memory now, if there is room. At its first such call OpenBLAS reserves 128 MB
   of addresses, touches few of them and keeps them; without room it asks for ever. So the room is tested
   here, before a factor is made. */
static PetscErrorCode blas_room(PetscBool *has)
{
  static const size_t ROOM = (size_t)160 << 20;
  static PetscBool taken = PETSC_FALSE;
  void *volatile room = taken ? NULL : malloc(ROOM); // volatile: a compiler may omit an unused malloc
  PetscFunctionBeginUser;
  if (room) {
    free(room);
    PetscCall(call_blas());
    taken = PETSC_TRUE;
  }
  *has = taken;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MemoryFits(MPI_Comm comm, double mine, double sum[2], PetscBool *fits)
{
  double here[2] = {mine, 1024. * kilobytes("/proc/self/status", "VmRSS:")};
  MPI_Comm machine;
  PetscMPIInt rank;
  PetscBool works;
  PetscFunctionBeginUser;
  PetscCall(blas_room(&works));
  double available = works ? MemoryAvailable() : 0.;
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_rank(machine, &rank));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, here, 2, MPI_DOUBLE, MPI_SUM, machine));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &available, 1, MPI_DOUBLE, MPI_MIN, machine));
  PetscCallMPI(MPI_Comm_free(&machine));
  available = PetscMax(0., PetscMin(available, limit_set - here[1]));
  PetscBool good = (PetscBool)(here[0] <= available);
  PetscCallMPI(MPI_Allreduce(&good, fits, 1, MPI_PETSC_BOOL, MPI_LAND, comm));
  sum[0] = mine, sum[1] = rank ? 0. : available; // counted once per machine
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MumpsWants(Mat factor, PetscBool *wants)
{
  /* the values of INFOG(1) in the manual of MUMPS that mean: allocation failed, or a work space or buffer is
     too small */
  static const PetscInt wanting[] = {-5, -7, -8, -9, -11, -12, -13, -14, -15, -17, -19, -20};
  PetscInt info;
  PetscFunctionBeginUser;
  PetscCall(MatMumpsGetInfog(factor, 1, &info));
  *wants = PETSC_FALSE;
  for (size_t i = 0; i < sizeof(wanting) / sizeof(wanting[0]); i++)
    if (info == wanting[i]) *wants = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

double MemoryOfFactor(double n_dof, double n_dense, PetscMPIInt size)
{
  const double *per = PER_DOF[size > 1];
  return n_dof * (per[0] + per[1] * log2(PetscMax(2., n_dof))) + PER_DENSE * n_dense;
}

double MemoryOfBody(double n_inner, double n_kept)
{
  return PER_BODY + MemoryOfFactor(n_inner, 0., 2) + PER_SCHUR * n_kept * n_kept; // by MUMPS on any ranks
}

/* Adds the factor: on several ranks it still exists while rank 0 gathers and writes; on one rank the peak
   is its making. */
double MemoryOfNewton(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, double factor,
                      PetscMPIInt size, PetscMPIInt rank)
{
  const double explicit = MemoryOfRank(n_vertices, n_blocks, n_contacts, size, rank),
               kept = PER_RANK + (KEPT_VERTEX * (double)n_vertices + KEPT_BLOCK * (double)n_blocks +
                                  KEPT_CONTACT * n_contacts) /
                                     (double)size;
  return rank || size == 1 ? PetscMax(explicit, kept + factor / (double)size)
                           : explicit + factor / (double)size;
}

/* Unit tests in three macros.

     static PetscErrorCode TestSum(void)             a test returns PetscErrorCode (PetscCall works) or void
     {
       ENSURE(n > 0);                                true, or file:line, rank and the expression are printed
       ENSURE_NEAR(sum, 3.0, 1e-12);                 |value - expected| <= tol (a NaN fails)
       return 0;
     }
     int main(int argc, char **argv)
     {
       PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
       RUN_TEST(TestSum);
       int failed = CheckSummary();                  sum over ranks; 0 when all held, 1 otherwise
       PetscCall(PetscFinalize());
       return failed;
     }

   A failed check is printed and counted; the test goes on, so that ranks stay together. Tests that need no
   PETSc may leave Initialize and Finalize out. A line "ranks: 1 2 4" in the first 30 lines of the test file
   makes CTest run it on that many ranks. */
#ifndef QUOIN_CHECK_H
#define QUOIN_CHECK_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <petscsys.h>

#define ENSURE(condition) CheckTrue((condition) ? 1 : 0, #condition, __FILE__, __LINE__)
#define ENSURE_NEAR(value, expected, tol) CheckNear((value), (expected), (tol), #value, __FILE__, __LINE__)
#define RUN_TEST(test) _Generic((test), void (*)(void) : CheckRunVoid, default : CheckRunCode)(#test, test)

/* How often a random test draws: n times, the twentieth part where each takes long (QUOIN_SLOW: under
   valgrind and the sanitizers). */
static inline int CheckDraws(int n)
{
  return getenv("QUOIN_SLOW") ? n / 20 : n;
}

/* Between these two, for calls that are to fail: an error ends the program, and on its way out (PetscCall)
   functions free nothing, so what they have allocated counts as no leak. */
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#define LEAKS_ALLOWED() __lsan_disable()
#define LEAKS_COUNT() __lsan_enable()
#else
#define LEAKS_ALLOWED() (void)0
#define LEAKS_COUNT() (void)0
#endif

enum { CHECK_PRINT_MAX = 20 }; /* failures printed per rank */
static long check_count, check_failed;
static const char *check_test = "main";

/* rank and size; 0 and 1 when MPI is not running */
static inline int CheckRank(int *size)
{
  int on = 0, off = 0, rank = 0;
  *size = 1;
  MPI_Initialized(&on);
  MPI_Finalized(&off);
  if (on && !off) {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, size);
  }
  return rank;
}

/* count a failure and print it in one piece, so that lines of different ranks do not mix */
static inline void CheckFail(const char *file, int line, const char *message)
{
  int size, rank = CheckRank(&size);
  check_failed++;
  if (check_failed <= CHECK_PRINT_MAX)
    fprintf(stderr, "%s:%d: [rank %d] %s: %s\n", file, line, rank, check_test, message);
  else if (check_failed == CHECK_PRINT_MAX + 1)
    fprintf(stderr, "[rank %d] more failures, not printed\n", rank);
}

static inline void CheckTrue(int holds, const char *text, const char *file, int line)
{
  char message[512];
  check_count++;
  if (holds) return;
  snprintf(message, sizeof message, "does not hold: %s", text);
  CheckFail(file, line, message);
}

static inline void CheckNear(double value, double expected, double tol, const char *text, const char *file,
                             int line)
{
  double error = fabs(value - expected);
  char message[512];
  check_count++;
  if (value == expected || error <= tol) return;
  snprintf(message, sizeof message, "%.200s = %.17g, expected %.17g, off by %.3g, bound %.3g", text, value,
           expected, error, tol);
  CheckFail(file, line, message);
}

static inline void CheckRunVoid(const char *name, void (*test)(void))
{
  check_test = name;
  test();
  check_test = "main";
}

/* an error code is a failure; on several ranks the others may wait for this one, so end the run */
static inline void CheckRunCode(const char *name, PetscErrorCode (*test)(void))
{
  int size, rank = CheckRank(&size);
  check_test = name;
  PetscErrorCode code = test();
  check_test = "main";
  check_count++;
  if (!code) return;
  check_failed++;
  fprintf(stderr, "[rank %d] %s returned error code %d\n", rank, name, (int)code);
  if (size > 1) MPI_Abort(MPI_COMM_WORLD, 1);
}

/* one line on rank 0; 0 when every check on every rank held and there was at least one */
static inline int CheckSummary(void)
{
  int size, rank = CheckRank(&size);
  long sum[2] = {check_count, check_failed};
  if (size > 1) MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_LONG, MPI_SUM, MPI_COMM_WORLD);
  fflush(stderr);
  if (rank == 0) printf("%ld checks, %ld failed, %d rank%s\n", sum[0], sum[1], size, size > 1 ? "s" : "");
  return sum[1] > 0 || sum[0] == 0;
}

#endif

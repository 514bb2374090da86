/* All unit tests in one program, for runs that are dear to start: under valgrind and under the sanitizers.

   unit_tests test_grid test_check    these one after the other; CTest forms the groups

   Each test is its own file with its main renamed (tests/CMakeLists.txt writes unit_tests.h, a line
   TEST(name) each). MPI starts once here; PETSc starts and ends in each test. The exit code is 1 when a
   test failed, and its name is the last line it leaves behind. */
#include <stdio.h>
#include <string.h>
#include <mpi.h>

#define TEST(name) int main_of_##name(int, char **);
#include "unit_tests.h"
#undef TEST

static const struct {
  const char *name;
  int (*run)(int, char **);
} tests[] = {
#define TEST(name) {#name, main_of_##name},
#include "unit_tests.h"
#undef TEST
};

/* run one test; 0 when it passed */
static int RunTest(const char *name, int rank)
{
  char program[64], *args[] = {program, NULL}; /* no options: those of CTest are names of tests */

  for (size_t i = 0; i < sizeof tests / sizeof *tests; i++) {
    if (strcmp(tests[i].name, name)) continue;
    snprintf(program, sizeof program, "%s", name);
    if (rank == 0) printf("%s: ", name), fflush(stdout);
    const int failed = tests[i].run(1, args);
    if (failed) fprintf(stderr, "%s: failed\n", name);
    return failed != 0;
  }
  fprintf(stderr, "unit_tests: no test named %s\n", name);
  return 1;
}

int main(int argc, char **argv)
{
  int rank, failed = argc < 2; /* nothing run is nothing shown */

  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 1; i < argc; i++)
    if (RunTest(argv[i], rank)) failed = 1;
  MPI_Finalize();
  return failed;
}

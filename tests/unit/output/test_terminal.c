/* Lines about a stage go where PETSC_STDOUT goes. */
#include "output/output.h"
#include "check.h"
#include <unistd.h>

/* Samples turn PETSC_STDOUT elsewhere: a line of progress between their rows was read as a row. */
static void LinesFollowTheStream(void)
{
  Stage stage = {.name = "full"};
  const Problem problem = {.stage = &stage};
  char line[128] = "";
  FILE *shown = PETSC_STDOUT;
  PETSC_STDOUT = tmpfile();
  ENSURE(PETSC_STDOUT != NULL);
  const int out = dup(STDOUT_FILENO);
  int ends[2];
  ENSURE(out >= 0 && !pipe(ends));
  fflush(stdout);
  dup2(ends[1], STDOUT_FILENO);
  StageShow(&problem, "iteration 1");
  fflush(stdout);
  dup2(out, STDOUT_FILENO);
  close(out), close(ends[1]);
  ENSURE(read(ends[0], line, sizeof(line) - 1) == 0); // nothing came out
  close(ends[0]);
  rewind(PETSC_STDOUT);
  ENSURE(fgets(line, sizeof(line), PETSC_STDOUT) && !strcmp(line, "  full: iteration 1\n"));
  fclose(PETSC_STDOUT);
  PETSC_STDOUT = shown;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(LinesFollowTheStream);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

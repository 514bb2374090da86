/* solve.c: runs a scene by the installed library; its exit code is the solver's. */
#include <quoin.h>

int main(int argc, char **argv)
{
  Quoin q = NULL;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(QuoinErrorHandlerPush());
  PetscErrorCode error = QuoinCreate(PETSC_COMM_WORLD, &q);
  if (!error) error = QuoinSetFromOptions(q, argc > 1 ? argv[1] : NULL, 0, NULL);
  if (!error) error = QuoinSetUp(q);
  if (!error) error = QuoinView(q);
  if (!error) error = QuoinRun(q);
  const int code = error ? QuoinErrorExitCode(error) : QuoinExitCode(q);
  PetscCall(QuoinDestroy(&q));
  PetscCall(PetscFinalize());
  return code;
}

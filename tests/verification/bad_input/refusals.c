/* refusals.c: runs many scenes in one process, each as the program does up to its refusal. catalogue.py
   calls it.

     refusals LIST     a line of LIST: a folder with a scene.yaml, then words of the command line

   On stderr a line "refusals: FOLDER" goes before what each run says, and "refusals: exit code N" behind it. */
#include "base/base.h"
#include "check.h"
#include "quoin.h"
#include <string.h>
#include <unistd.h>

enum { LINE = 4096, MOST_WORDS = 32 };

/* Runs the scene of the working folder, as main.c does. What a refused run has allocated stays: the program
   would end. */
static PetscErrorCode run(int argc, char **argv)
{
  Quoin q;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertArgs(NULL, argc - 1, argv + 1));
  PetscCall(QuoinCreate(PETSC_COMM_WORLD, &q));
  PetscCall(QuoinSetFromOptions(q, "scene.yaml", argc, argv));
  PetscCall(QuoinSetUp(q));
  PetscCall(QuoinRun(q));
  PetscCall(QuoinDestroy(&q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs what a line of the list says. Does not return where ranks have not given up together. */
static PetscErrorCode run_line(char *line)
{
  char *words[MOST_WORDS] = {"quoin"};
  int n = 1;
  const char *folder = strtok(line, " \n");
  PetscFunctionBeginUser;
  for (char *word = strtok(NULL, " \n"); word && n < MOST_WORDS - 1; word = strtok(NULL, " \n"))
    words[n++] = word;
  PetscCheck(folder && !chdir(folder), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "no folder %s",
             folder ? folder : "");
  PetscCall(PetscFPrintf(PETSC_COMM_WORLD, stderr, "refusals: %s\n", folder));
  LEAKS_ALLOWED();
  const PetscErrorCode error = run(n, words);
  LEAKS_COUNT();
  const int code = error ? QuoinErrorExitCode(error) : QUOIN_OK;
  PetscCall(PetscFPrintf(PETSC_COMM_WORLD, stderr, "refusals: exit code %d\n", code));
  if (error && !QuoinErrorIsShared(error)) MPI_Abort(PETSC_COMM_WORLD, code);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  char line[LINE];
  const char *list = argc > 1 ? argv[1] : "";
  int none = 1;
  PetscCall(PetscInitialize(&none, &argv, NULL, NULL));
  PetscCall(QuoinErrorHandlerPush());
  FILE *file = fopen(list, "r");
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "no list %s", list);
  while (fgets(line, LINE, file)) PetscCall(run_line(line));
  fclose(file);
  PetscCall(PetscFinalize());
  return 0;
}

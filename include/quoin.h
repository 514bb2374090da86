/* quoin.h: the public interface. A program that runs a scene is src/main.c. */
#pragma once
#include <petscsys.h>

typedef struct _p_Quoin *Quoin;

/* Exit codes of the program, and QuoinExitCode(). */
enum {
  QUOIN_OK = 0,
  QUOIN_BAD_INPUT = 2,
  QUOIN_DIVERGED = 3,
  QUOIN_UNDECIDED = 4,
  QUOIN_INTERRUPTED = 5,
  QUOIN_COLLAPSED = 6,
  QUOIN_INTERNAL = 7,
  QUOIN_OUTPUT = 8,   /* an output file cannot be written */
  QUOIN_LOCKED = 9,   /* another run writes into the output folder */
  QUOIN_RESTART = 10, /* a restart is not possible from what there is */
  QUOIN_MEMORY = 11   /* the model needs more memory than there is */
};

/* Makes a refusal one line on stderr, in place of PETSc's trace, and a lack of memory too. Call it behind
   PetscInitialize. */
PetscErrorCode QuoinErrorHandlerPush(void);
/* Creates a Quoin. All functions are collective on comm. A refusal returns an error, for bad input
   PETSC_ERR_USER_INPUT. */
PetscErrorCode QuoinCreate(MPI_Comm comm, Quoin *q);
/* Reads the scene: the YAML file (or NULL), overridden by "-key value" pairs of argv (argv[0] is skipped). */
PetscErrorCode QuoinSetFromOptions(Quoin q, const char *scene_file, int argc, char **argv);
/* Reads, checks and distributes the block mesh; finds contacts; allocates the state. */
PetscErrorCode QuoinSetUp(Quoin q);
/* Runs all stages and writes results into the output folder. */
PetscErrorCode QuoinRun(Quoin q);
/* Prints the size of the model (blocks, contacts, degrees of freedom, ranks) on stdout of rank 0. */
PetscErrorCode QuoinView(Quoin q);
/* Returns one of the exit codes above, from the verdicts of the stages. Not collective. */
int QuoinExitCode(Quoin q);
/* Returns the exit code for an error that one of the functions above returned; QUOIN_INTERNAL when the ranks
   have not failed together. Not collective. */
int QuoinErrorExitCode(PetscErrorCode error);
PetscErrorCode QuoinDestroy(Quoin *q);

/* samples.h: declares the table of samples and the table of their results, for samples.c and
   sample_table.c. */
#pragma once
#include "study/study.h"

enum { MOST_COLUMNS = 64, MOST_LINE = 8192 };
#define WARNING_JOINT " | "
#define PIVOT "pivot:" /* start of the names of pivots, from which other samples start: nearest.c */

/* The tables. A row of the first has the name of a sample and a cell for each column. */
typedef struct {
  FILE *rows, *results;
  char name[PETSC_MAX_PATH_LEN];         /* of the first, for messages */
  int line;                              /* last line that was read */
  int n_columns;                         /* after the name */
  char header[MOST_LINE];                /* its first line */
  char *column[MOST_COLUMNS];            /* keys; paths of numbers in summary.json; the last stage to run */
  PetscBool until[MOST_COLUMNS];         /* the column names the last stage to run (`until:`) */
  PetscInt last;                         /* that stage */
  PetscBool asks[MOST_COLUMNS];          /* the column asks for a number of the results (`tell:`) */
  char names[MOST_LINE];                 /* their text */
  char row[MOST_LINE], cells[MOST_LINE]; /* the line of the present sample; the same cut into cells */
  char *cell[MOST_COLUMNS + 1];
  void *known; /* tree of tsearch: lines of samples that have results */
  char folder[PETSC_MAX_PATH_LEN];
  int lock;      /* of the folder of results, -1: they go to the terminal */
  double synced; /* [s] of MPI_Wtime, when the results were put on the disk */
} SampleTable;

/* The results of a sample. Numbers: NaN if there is none. */
typedef struct {
  const char *outcome; /* stands, fails, undecided, refused */
  char stage[NAME_LENGTH], why[MESSAGE_LENGTH];
  PetscReal stable, failing, open; /* the last bracket, and the value without a verdict */
  PetscReal factor[2];             /* [-] of strengths, stable and failing */
  PetscInt64 evaluations;          /* of forces, in all stages */
  double seconds;                  /* [s] of the processor */
  uint64_t checksum;               /* StateChecksumKept of its end */
  PetscReal asked[MOST_COLUMNS];   /* numbers of the columns that ask for results */
  PetscInt warnings;               /* number of different warnings */
  char warned[MOST_LINE];          /* their texts, as far as there is room, with WARNING_JOINT between */
} SampleResult;

/* ---- sample_table.c: one rank */
/* Opens the table and reads its header; opens the table of results and continues after its rows. run: number
   of the scene and mesh, to which the results must belong. message: the fault; "". */
PetscErrorCode SampleTableOpen(const Scene *scene, uint64_t run, SampleTable *table,
                               char message[MESSAGE_LENGTH]);
/* Finds the next sample without results. more: there is one. */
PetscErrorCode SampleTableNext(SampleTable *table, PetscBool *more, char message[MESSAGE_LENGTH]);
/* Adds a row of results. */
PetscErrorCode SampleTableAdd(SampleTable *table, const SampleResult *result, char message[MESSAGE_LENGTH]);
/* Closes the tables. message: a write that failed at the end. */
PetscErrorCode SampleTableClose(SampleTable *table, char message[MESSAGE_LENGTH]);

/* Pivots: their numbers, and the displacements at the ends of their stages. */
typedef struct {
  PetscInt n, n_columns, n_stages;
  PetscReal *x; /* (n,n_columns) */
  Vec *u;       /* (n,n_stages) NULL: the stage has not been run, or has failed */
} Nearest;

/* ---- nearest.c */
/* Adds a pivot, which becomes the last one. */
PetscErrorCode NearestAdd(Nearest *nearest, PetscInt n_columns, PetscInt n_stages, const PetscReal *x);
/* Keeps the end of a stage of the last pivot. */
PetscErrorCode NearestKeep(Nearest *nearest, PetscInt stage, State *state);
/* Returns the nearest pivot, the first one of equally near ones; -1: none. */
PetscInt NearestOf(const Nearest *nearest, const PetscReal *x);
PetscErrorCode NearestDestroy(Nearest *nearest);

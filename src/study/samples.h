/* samples.h: declares the table of samples and the table of their results, for samples.c and
   sample_table.c. */
#pragma once
#include "study/study.h"

enum { MOST_COLUMNS = 64, MOST_LINE = 8192 };
#define WARNING_JOINT " | "
#define PIVOT "pivot:" /* start of the names of pivots, from which other samples start: nearest.c */

typedef enum {
  COLUMN_NUMBER, /* sets a number of the scene */
  COLUMN_ASK,    /* asks for a result */
  COLUMN_UNTIL,  /* names the last stage to run */
  COLUMN_LOADS,  /* no stage runs: a cell names the stage whose loads on faces are wanted */
  COLUMN_RISE    /* a cell says by how much [m] the waters of this flood have risen */
} ColumnKind;

/* The tables. A row of the first has the name of a sample and a cell for each column. */
typedef struct {
  FILE *rows, *results;
  char name[PETSC_MAX_PATH_LEN]; /* of the first, for messages */
  int line;                      /* last line that was read */
  int n_columns;                 /* after the name */
  char header[MOST_LINE];        /* its first line */
  char *column[MOST_COLUMNS];    /* keys; paths of numbers in summary.json; the last stage to run */
  ColumnKind kind[MOST_COLUMNS];
  PetscInt last;                         /* the last stage to run */
  int loads, rise;                       /* columns of this kind, -1: none */
  PetscInt n_loads;                      /* of the scene */
  PetscBool numbers;                     /* some columns set numbers */
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
  const char *outcome; /* stands, fails, undecided, refused; asked: for loads */
  char stage[NAME_LENGTH], why[MESSAGE_LENGTH];
  PetscReal stable, failing, open; /* the last bracket, and the value without a verdict */
  PetscReal factor[2];             /* [-] of strengths, stable and failing */
  PetscInt64 evaluations;          /* of forces, in all stages */
  double seconds;                  /* [s] of the processor */
  uint64_t checksum;               /* StateChecksumKept of its end */
  PetscReal asked[MOST_COLUMNS];   /* numbers of the columns that ask for results */
  TermTable loads;                 /* on faces of the stage that the row names; name NULL: not asked for */
  const Stage *flood;              /* that stage, if it is a flood */
  PetscInt warnings;               /* number of different warnings */
  char warned[MOST_LINE];          /* their texts, as far as there is room, with WARNING_JOINT between */
} SampleResult;

/* ---- sample_table.c: one rank */
/* Opens the table and reads its header; opens the table of results and continues after its rows. run: number
   of the scene and mesh, to which the results must belong. why: why samples cannot run the stages, NULL: they
   can. message: the fault; "". */
PetscErrorCode SampleTableOpen(const Scene *scene, uint64_t run, const char *why, SampleTable *table,
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

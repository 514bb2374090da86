/* samples.h: what samples.c and sample_table.c share: the table of samples and that of their results. */
#pragma once
#include "study/study.h"

enum { MOST_COLUMNS = 64, MOST_LINE = 8192 };
#define WARNING_JOINT " | "
#define PIVOT "pivot:" /* names of samples begin so from which others start: nearest.c */

/* The tables. A row of the first has the name of a sample and a cell for each column. */
typedef struct {
  FILE *rows, *results;
  char name[PETSC_MAX_PATH_LEN]; /* of the first, for messages */
  int line;                      /* of it, the last that was read */
  int n_columns;                 /* behind the name */
  char header[MOST_LINE];        /* its first line */
  char *column[MOST_COLUMNS];    /* pieces of names: keys, or, after tell, paths of numbers in summary.json */
  PetscBool says[MOST_COLUMNS];  /* the column is no number, but says which stage is the last to run */
  PetscInt last;                 /* that stage */
  PetscBool tell[MOST_COLUMNS];
  char names[MOST_LINE];                 /* their text */
  char row[MOST_LINE], cells[MOST_LINE]; /* the line of the present sample; the same cut into cells */
  char *cell[MOST_COLUMNS + 1];
  PetscInt n_known, room;
  char **known; /* (n_known,) lines of samples that have results, ascending */
  char folder[PETSC_MAX_PATH_LEN];
  int lock;      /* of the folder of results, -1: they go to the terminal */
  double synced; /* [s] of MPI_Wtime, when the results were put on the disk */
} SampleTable;

/* What a sample came to. Numbers: NaN where there is none. */
typedef struct {
  const char *outcome; /* stands, fails, undecided, refused */
  char stage[NAME_LENGTH], why[MESSAGE_LENGTH];
  PetscReal stable, failing, open; /* the last bracket, and the value that has no verdict */
  PetscReal factor[2];             /* [-] of strengths, stable and failing */
  PetscInt64 evaluations;          /* of forces, in all its stages */
  double seconds;                  /* [s] of the processor */
  uint64_t checksum;               /* StateChecksumKept of its end */
  PetscReal told[MOST_COLUMNS];    /* of the columns that ask for numbers */
  PetscInt warnings;               /* that differ */
  char warned[MOST_LINE];          /* these, as far as there is room, with WARNING_JOINT between */
} SampleResult;

/* ---- sample_table.c: one rank */
/* Opens the table and reads its header; opens the table of results, goes on behind the rows that it has.
   run: number of the scene and mesh, of which results must be. message: what is wrong; "". */
PetscErrorCode SampleTableOpen(const Scene *scene, uint64_t run, SampleTable *table,
                               char message[MESSAGE_LENGTH]);
/* The next sample that has no results; more: there is one. */
PetscErrorCode SampleTableNext(SampleTable *table, PetscBool *more, char message[MESSAGE_LENGTH]);
/* Adds a row of results. */
PetscErrorCode SampleTableAdd(SampleTable *table, const SampleResult *result, char message[MESSAGE_LENGTH]);
/* message: what could not be written at the last moment. */
PetscErrorCode SampleTableClose(SampleTable *table, char message[MESSAGE_LENGTH]);

/* Pivots: their numbers, and the displacements that stages of theirs have ended with. */
typedef struct {
  PetscInt n, n_columns, n_stages;
  PetscReal *x; /* (n,n_columns) */
  Vec *u;       /* (n,n_stages) NULL: the stage has not been run, or does not stand */
} Nearest;

/* ---- nearest.c */
/* Adds a pivot, which is the last one then. */
PetscErrorCode NearestAdd(Nearest *nearest, PetscInt n_columns, PetscInt n_stages, const PetscReal *x);
/* Keeps the end of a stage of the last pivot. */
PetscErrorCode NearestKeep(Nearest *nearest, PetscInt stage, State *state);
/* The nearest pivot, the first one of those that are as near; -1: there is none. */
PetscInt NearestOf(const Nearest *nearest, const PetscReal *x);
PetscErrorCode NearestDestroy(Nearest *nearest);

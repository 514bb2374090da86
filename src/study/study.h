/* study.h: declares studies of many runs: scenes are run to find their cost and their answers; nothing is
   written. */
#pragma once
#include "run/run.h"

/* The cost of a stage. */
typedef struct {
  PetscReal cycles, least, most; /* of the explicit loop: likely number, and its range; NaN: not known */
  PetscReal
      effort[2][3]; /* by Newton's method: force evaluations, solves; likely, least, most; NaN: not known */
  double seconds;   /* [s] preconditioned: measured for static stages, guessed from these for trials; NaN */
  PetscReal trials; /* likely number of trials; 1 for a static or dynamic stage */
} Cost;

typedef struct {
  char refused[MESSAGE_LENGTH]; /* why the scene could not be set up, "": it could */
  PetscInt n_stages, n_static;  /* number of stages of the scene; of static stages at its start */
  PetscInt n_solved;            /* number of solved ones: these, or the start of trials that come first */
  Effort spent;       /* effort after which Newton's method was given up; no evaluations: it was not given
                         up */
  PetscBool solved;   /* all of them have an equilibrium */
  PetscReal bodies;   /* number of bodies of the scene */
  PetscReal loose;    /* [-] part of the contacts that slip, are open or crushed at the end */
  PetscReal omega;    /* [1/cycle] lowest frequency, 0: not known */
  double cycle, step; /* [s] time of an explicit cycle, of a step in time; 0: none */
  double unit;        /* [s] of a solve, or of a force evaluation with its tangent, in the last solution */
  double condensed;   /* [s] time for the factors of condensed bodies */
  PetscReal moved;    /* [-] displacement of the blocks over the displacement after which contacts are
                         searched again */
  double search;      /* [s] of a search; both for scenes of variable connectivity, else 0 */
  Cost *cost;         /* (n_stages,) */
  MethodKind *method; /* (n_stages,) method of each stage in the scene, with its first contacts */
  MeshFields mesh;    /* rank 0 */
  StageFields fields; /* rank 0: at the end of the last static stage */
} Attempt;

/* ---- advise.c */
/* Collective. Prints the cost of a Quoin that is set up, if the scene has the key `advise`; advised: it has.
   The Quoin can only be destroyed afterwards. The arguments are those of QuoinSetFromOptions. */
PetscErrorCode Advise(Quoin q, const char *scene_file, int argc, char **argv, PetscBool *advised);

/* ---- samples.c */
/* One rank. Runs the samples of a table, if the scene has the key `samples` (done). The Quoin is set up,
   has not run, and can only be destroyed afterwards. The arguments are those of QuoinSetFromOptions. */
PetscErrorCode Samples(Quoin q, const char *scene_file, int argc, char **argv, PetscBool *done);

/* ---- attempt.c */
/* Collective. Solves the static stages of a Quoin that is set up and times its cycles. The Quoin can only be
   destroyed afterwards. */
PetscErrorCode AttemptMeasure(Quoin q, Attempt *attempt);
/* Collective. Does the same as AttemptMeasure for a scene with the "-key value" options of argv. A scene
   that is refused leaves its message. */
PetscErrorCode AttemptRun(MPI_Comm comm, const char *scene_file, int argc, char **argv, Attempt *attempt);
PetscErrorCode AttemptDestroy(Attempt *attempt);
/* Collective. Counts the contacts of all ranks: [0] all of them, [1] those that slip, are open or crushed. */
PetscErrorCode AttemptContacts(const Model *model, const Contacts *contacts, PetscInt n[2]);
/* Rank 0. Compares the answers of a and b at the end of the static stages: [0] largest difference of
   displacement over largest displacement, [1] sum of |difference| of contact forces over their sum. NaN: one
   of them has no answer. */
void AttemptDifference(const Attempt *a, const Attempt *b, PetscReal difference[2]);
/* Returns the time [s] of all stages that are not dynamic, with the factors of condensed bodies, by a method;
   METHOD_AUTO: by the scene's own methods. NaN: not known. */
double AttemptSeconds(const Scene *scene, const Attempt *a, MethodKind method);

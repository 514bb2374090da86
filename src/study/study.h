/* study.h: many runs: a scene tried for what it costs and what it answers, nothing written. */
#pragma once
#include "run/run.h"

/* What a stage takes. */
typedef struct {
  PetscReal cycles, least, most; /* of the explicit loop: likely, and the range; NaN: not known */
  PetscReal
      effort[2][3]; /* by Newton's method: force evaluations, solves; likely, least, most; NaN: not known */
  double seconds;   /* [s] preconditioned: measured for static stages, from them for trials; NaN */
  PetscReal trials; /* likely number of them, 1: static or dynamic */
} Cost;

typedef struct {
  char refused[MESSAGE_LENGTH]; /* why it could not be set up, "": it could */
  PetscInt n_stages, n_static;  /* of the scene; the static ones it begins with */
  PetscInt n_solved;            /* the first ones: those, or the start of trials that come first */
  Effort spent;       /* when Newton's method was given up for taking too long; no evaluations: not */
  PetscBool solved;   /* they all have an equilibrium */
  PetscReal bodies;   /* of the scene */
  PetscReal loose;    /* [-] part of the contacts that slip, are open or crushed at its end */
  PetscReal omega;    /* [1/cycle] lowest frequency, 0: not known */
  double cycle, step; /* [s] of an explicit cycle, of a step in time; 0: there is none */
  double unit;        /* [s] of a solve, or a force evaluation with its tangent, in the last solution */
  double condensed;   /* [s] that the factors of condensed bodies took */
  PetscReal moved;    /* [-] way of the blocks over that after which contacts are found again */
  double search;      /* [s] of finding them; both for scenes of variable connectivity, else 0 */
  Cost *cost;         /* (n_stages,) */
  MethodKind *method; /* (n_stages,) as the scene has it, with its first contacts */
  MeshFields mesh;    /* rank 0 */
  StageFields fields; /* rank 0: at the end of the last static stage */
} Attempt;

/* ---- advise.c */
/* Collective. What a Quoin that is set up will cost, with the key `advise`; it is of no use afterwards.
   advised: the scene asks for it. The arguments are those of QuoinSetFromOptions. */
PetscErrorCode Advise(Quoin q, const char *scene_file, int argc, char **argv, PetscBool *advised);

/* ---- attempt.c */
/* Collective. Solves the static stages of a Quoin that is set up and times its cycles; it is of no use
   afterwards. */
PetscErrorCode AttemptMeasure(Quoin q, Attempt *attempt);
/* Collective. The same of a scene with the "-key value" options of argv; one that is refused leaves its
   message. */
PetscErrorCode AttemptRun(MPI_Comm comm, const char *scene_file, int argc, char **argv, Attempt *attempt);
PetscErrorCode AttemptDestroy(Attempt *attempt);
/* Collective. Contacts of all ranks: [0] all of them, [1] those that slip, are open or crushed. */
PetscErrorCode AttemptContacts(const Model *model, const Contacts *contacts, PetscInt n[2]);
/* Rank 0. How far the answers of a are from those of b, at the end of the static stages: [0] largest
   difference of displacement over largest displacement, [1] sum of |difference| over sum of the forces of the
   contacts. NaN: one of them has none. */
void AttemptDifference(const Attempt *a, const Attempt *b, PetscReal difference[2]);
/* [s] All stages that are not dynamic, factors of condensed bodies included, by the explicit loop,
   preconditioned, and each as the scene has it. NaN: not known. */
double AttemptExplicit(const Scene *scene, const Attempt *a);
double AttemptPreconditioned(const Scene *scene, const Attempt *a);
double AttemptAsItIs(const Scene *scene, const Attempt *a);

/* loop.h: the one loop of all stages that move, and what each kind of stage puts into it. */
#pragma once
#include "stages/stages.h"

struct _p_Loop;
typedef PetscErrorCode (*LoopFunction)(struct _p_Loop *loop);

/* What a kind of stage does at each place of the loop. All functions are collective but checks, fault and
   over, whose answers are the same on all ranks. load, settle, follow, fault and over may be NULL. */
typedef struct {
  LoopFunction begin;  /* starts a stage from its beginning */
  LoopFunction resume; /* goes on in a stage that a checkpoint has brought back */
  LoopFunction load;   /* sets the applied forces of the cycle to come */
  LoopFunction cycle;  /* does one cycle or step, and keeps what a look reads where loop->checks */
  LoopFunction judge;  /* gives the verdict; sets loop->anew when the stage has begun anew */
  LoopFunction settle; /* changes what an equilibrium changes: cracks */
  LoopFunction tell;   /* writes history and progress */
  LoopFunction follow; /* takes contacts and loads along with the motion */
  LoopFunction end;    /* after the verdict: evaluates forces once more, completes the evidence */
  PetscErrorCode (*archive)(Archive *archive, struct _p_Loop *loop); /* archives what the stage remembers */
  PetscBool (*checks)(const struct _p_Loop *loop); /* whether a look follows the cycle to come */
  PetscBool (*fault)(const struct _p_Loop *loop);  /* whether a number is not finite, so that a look is due */
  PetscBool (*over)(const struct _p_Loop *loop);   /* whether all cycles are done; NULL: a verdict ends it */
} LoopKind;

typedef struct _p_Loop {
  const Problem *p;
  const LoopKind *kind;
  void *memory;           /* of the kind */
  PetscBool checks, anew; /* a look follows the cycle that runs; judge has begun the stage anew */
  double start;           /* [s] of MPI_Wtime, less what the stage took before a restart */
} Loop;

/* Collective. Runs a stage or trial to its verdict, p->result, from its start or from where a checkpoint left
   off. */
PetscErrorCode StageLoop(const Problem *p, const LoopKind *kind, void *memory);

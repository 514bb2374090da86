/* loop.h: the one loop of stages that move, and what a kind of stage puts into it. */
#pragma once
#include "stages/stages.h"

struct _p_Loop;
typedef PetscErrorCode (*LoopFunction)(struct _p_Loop *loop);

/* What a kind of stage does at each place of the loop; all collective. loop->memory is its own. */
typedef struct {
  LoopFunction begin;  /* of a stage that a checkpoint has not brought back in its midst */
  LoopFunction resume; /* of one that it has */
  LoopFunction load;   /* applied forces of the cycle to come */
  LoopFunction cycle;  /* one cycle or step; loop->looks: what a look reads is kept */
  LoopFunction judge;  /* unbalanced forces, energies, verdict; loop->anew: the stage has begun anew */
  LoopFunction settle; /* what changes at an equilibrium: cracks */
  LoopFunction tell;   /* history, progress */
  LoopFunction follow; /* contacts and loads that go along with the motion */
  LoopFunction end;    /* after the verdict: forces once more, evidence */
  PetscErrorCode (*archive)(Archive *archive, struct _p_Loop *loop); /* all that memory must remember */
  PetscBool (*looks)(const struct _p_Loop *loop);                    /* after the cycle to come */
  PetscBool (*fault)(const struct _p_Loop *loop); /* numbers stopped being numbers: look now; NULL: never */
  PetscBool (*over)(const struct _p_Loop *loop);  /* all cycles are done; NULL: a verdict alone ends it */
} LoopKind;

typedef struct _p_Loop {
  const Problem *p;
  const LoopKind *kind;
  void *memory;
  PetscBool looks, anew;
  double start; /* [s] of MPI_Wtime, less what the stage took before a restart */
} Loop;

/* Collective. From the start of a stage or trial, or from where a checkpoint left off, to its verdict:
   p->result. */
PetscErrorCode StageLoop(const Problem *p, const LoopKind *kind, void *memory);

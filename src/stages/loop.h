/* loop.h: declares the one loop of all stages that move, and the functions that each kind of stage gives
   it. */
#pragma once
#include "stages/stages.h"

struct _p_Loop;
typedef PetscErrorCode (*LoopFunction)(struct _p_Loop *loop);

/* The functions of a kind of stage at each place of the loop. All are collective, except checks, fault and
   over, whose answers are the same on all ranks. load, settle, follow, fault and over may be NULL. */
typedef struct {
  LoopFunction begin;  /* starts a stage */
  LoopFunction resume; /* continues a stage that a checkpoint has restored */
  LoopFunction load;   /* sets the applied forces of the next cycle */
  LoopFunction cycle;  /* makes one cycle or step; where loop->checks, keeps what the check reads */
  LoopFunction judge;  /* finds the verdict; sets loop->restarted when it has restarted the stage */
  LoopFunction settle; /* makes the changes that follow an equilibrium: cracks */
  LoopFunction report; /* writes history and progress */
  LoopFunction follow; /* updates contacts and loads to the motion */
  LoopFunction end;    /* after the verdict: evaluates forces once more, completes the evidence */
  PetscErrorCode (*archive)(Archive *archive, struct _p_Loop *loop); /* archives the memory of the stage */
  PetscBool (*checks)(const struct _p_Loop *loop); /* whether a check follows the next cycle */
  PetscBool (*fault)(const struct _p_Loop *loop);  /* whether a number is not finite, so that a check is
                                                      due */
  PetscBool (*over)(const struct _p_Loop *loop);   /* whether all cycles are done; NULL: a verdict ends the
                                                      stage */
} LoopKind;

typedef struct _p_Loop {
  const Problem *p;
  const LoopKind *kind;
  void *memory; /* memory of the kind of stage */
  PetscBool checks,
      restarted; /* checks: a check follows this cycle; restarted: judge has restarted the stage */
  double start;  /* [s] of MPI_Wtime, less the time of the stage before a restart of the run */
} Loop;

/* Collective. Runs a stage or trial to its verdict, p->result, from its start or from a checkpoint. */
PetscErrorCode StageLoop(const Problem *p, const LoopKind *kind, void *memory);

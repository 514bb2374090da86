/* result.c: what a stage has come to, and what it has taken. */
#include "model/model.h"

const char *const VerdictNames[] = {"none",      "converged",   "collapsed", "diverged",
                                    "undecided", "interrupted", "completed"};

const char *EffortMethod(const Effort *e)
{
  return !e->preconditioned ? "explicit" : e->explicit ? "preconditioned, then explicit" : "preconditioned";
}

/* A force evaluation comes with a tangent and counts as a solve. */
PetscReal EffortWork(const Effort *e)
{
  static const PetscReal PER_FACTOR = 15.; /* [solves] what a factorisation takes */
  return (PetscReal)(1 + e->evaluations + e->solves) + PER_FACTOR * (PetscReal)e->factorisations;
}

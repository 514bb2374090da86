/* stage_result.c: names verdicts and measures the effort of a stage. */
#include "result/stage/stage_result.h"

const char *const VerdictNames[] = {"none",      "converged",   "collapsed", "diverged",
                                    "undecided", "interrupted", "completed"};

PetscBool EffortHasCycles(const Effort *e)
{
  return (PetscBool)(e->explicit || e->stiffness_mass);
}

const char *EffortMethod(const Effort *e)
{
  if (e->stiffness_mass) return e->explicit ? "stiffness_mass, then explicit" : "stiffness_mass";
  return !e->preconditioned ? "explicit" : e->explicit ? "preconditioned, then explicit" : "preconditioned";
}

/* Computes the effort [solves]. A force evaluation includes a tangent and counts as a solve. */
PetscReal EffortWork(const Effort *e)
{
  static const PetscReal PER_FACTOR = 15.; /* [solves] cost of a factorisation */
  return (PetscReal)(1 + e->evaluations + e->solves) + PER_FACTOR * (PetscReal)e->factorisations;
}

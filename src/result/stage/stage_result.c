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
  if (e->stiffness_mass && e->explicit)
    return e->choice.crept > 0 && !e->choice.stalled ? "explicit, then stiffness_mass"
                                                     : "stiffness_mass, then explicit";
  if (e->stiffness_mass) return "stiffness_mass";
  return !e->preconditioned ? "explicit" : e->explicit ? "preconditioned, then explicit" : "preconditioned";
}

/* Reasons without a number. */
static const char *const PlainReasons[] = {
    [CHOICE_VARIABLE] = "explicit: contacts are found anew as blocks move",
    [CHOICE_DAMPING] = "explicit: relaxation.damping is not adaptive",
    [CHOICE_YIELDS] = "explicit: blocks can yield",
    [CHOICE_BREAKS] = "explicit: joints can break or be crushed",
    [CHOICE_WATER] = "explicit: water in joints changes with time",
    [CHOICE_HANDED_OVER] = "preconditioned: the trials that were left by explicit cycles",
    [CHOICE_PUSHED] = "explicit: a given displacement is followed cycle by cycle",
    [CHOICE_LEFT] = "stiffness_mass: the trials after those that it left by explicit cycles",
};

void MethodSentence(const MethodChoice *c, size_t size, char *text)
{
  const long long dofs = c->dofs, bodies = c->bodies, limit = c->limit,
                  again = c->left[0] + c->left[1] + c->left[2];
  char more[512] = "";
  text[0] = 0;
  if (c->given_up && !c->spent)
    snprintf(more, sizeof(more), "; its factor could not be made, and explicit cycles went on");
  else if (c->given_up)
    snprintf(more, sizeof(more),
             "; %lld time%s it found no equilibrium in the work of %lld explicit cycles, and those went on",
             (long long)c->given_up, Plural(c->given_up), (long long)c->spent);
  else if (again)
    snprintf(
        more, sizeof(more),
        "; %lld time%s explicit cycles began again, after a jump of blocks (%lld), a divergence (%lld) or "
        "no end (%lld)",
        again, Plural(again), (long long)c->left[LEFT_JUMPED], (long long)c->left[LEFT_DIVERGED],
        (long long)c->left[LEFT_ENDLESS]);
  if (c->stalled) {
    const size_t n = strlen(more);
    snprintf(more + n, sizeof(more) - n, "; explicit cycles went on after %lld cycles, at the first stall",
             (long long)c->stalled);
  }
  if (c->crept > 0) {
    const size_t n = strlen(more);
    snprintf(more + n, sizeof(more) - n, "; stiffness_mass went on after %lld cycles, where slip was let go",
             (long long)c->crept);
  }
  switch ((MethodReason)c->reason) {
  case CHOICE_GIVEN:
    return;
  case CHOICE_ELASTIC:
    snprintf(text, size, "preconditioned: %lld degrees of freedom, no contact can fail", dofs);
    break;
  case CHOICE_FEW_BODIES:
    snprintf(text, size,
             "preconditioned: %lld degrees of freedom, %lld bodies at contacts that can fail, at most %lld",
             dofs, bodies, limit);
    break;
  case CHOICE_SMALL:
    snprintf(text, size, "explicit: %lld degrees of freedom, fewer than %lld", dofs, limit);
    break;
  case CHOICE_MANY_BODIES:
    snprintf(text, size, "explicit: %lld bodies at contacts that can fail, more than %lld", bodies, limit);
    break;
  case CHOICE_MANY_STONES:
    snprintf(text, size, "stiffness_mass: %lld stones that can slip, %lld or more", bodies, limit);
    break;
  case CHOICE_RUBBLE:
    snprintf(text, size,
             "stiffness_mass: %lld stones of rubble that can slip, %lld or more, four-fold order %.2f",
             bodies, limit, (double)c->order);
    break;
  case CHOICE_CRACKS:
    snprintf(text, size,
             "stiffness_mass: blocks can crack, %lld bodies at contacts that can fail, at most %lld", bodies,
             limit);
    break;
  default:
    snprintf(text, size, "%s", PlainReasons[c->reason]);
  }
  const size_t n = strlen(text);
  snprintf(text + n, size - n, "%s; relaxation.method fixes it", more);
}

const char *EffortConnectivity(const Effort *e)
{
  if (e->variable) return e->fixed ? "fixed, then variable" : "variable";
  return e->fixed ? "fixed" : NULL;
}

/* Computes the effort [solves]. A force evaluation includes a tangent and counts as a solve. */
PetscReal EffortWork(const Effort *e)
{
  static const PetscReal PER_FACTOR = 15.; /* [solves] cost of a factorisation */
  return (PetscReal)(1 + e->evaluations + e->solves) + PER_FACTOR * (PetscReal)e->factorisations;
}

/* friction_mode.c: changes how friction follows its law while a static stage is on its way to equilibrium.

   Friction flutter. Slip is not associated, so the tangent stiffness is unsymmetric, and fast oscillations
   along a sliding joint can grow by some 1e-3 a cycle. Mass-proportional damping hardly damps them: the
   joint never rests, and moves on as if it were shaken. So where joints can slip, adaptive damping also has
   a part proportional to stiffness, a force beta (f - f_old). With beta = 0.25, the default, that is a
   quarter of critical at the highest frequency and nothing at the lowest. When the unbalanced ratio has not
   halved in two chunks (judge.c), beta is raised to 0.5 and the secant is given up: only what moves on
   after that is a collapse.

   Friction on the way. In a static stage every evaluation starts from the committed history (false slip:
   deviations.md, ab), so friction is a force that depends on place alone, tau = f(committed slip, u). Where a
   contact slides,

     d(sigma, tau)/d(u_n, u_s) = [k_n 0; -+ k_n tan(phi) 0].

   Pressure changes shear here, and shear does not change pressure. So the force has a curl, and a closed
   path of opening and sliding gains work, k_n tan(phi) times its area. Where an elastic surrounding couples
   the two, eigenvalues of the tangent are complex, and motions grow by up to a few tenths a cycle. So
   contacts on the way have elastic-plastic springs instead, which keep their slip and take energy. Each
   cycle moves the force of a spring by the fraction `pull` (contacts.h: Contacts) towards the force of the
   law. Motions faster than 1/pull cycles meet springs; slow motions, and every equilibrium, meet the law
   (stress_models.h: RespondFollowing, equilibrium_check.c: CheckFrictionLaw). */
#include "solve/solve.h"

/* Starts the secant of the damping from this state. The forces f belong to the displacements before the
   step of this cycle. */
static void secant_from(const Model *m, const State *state, Relaxation *r)
{
  for (PetscInt d = 0; d < m->n_dof; d++) {
    r->damping.u_secant[d] = state->u[d] - state->v[d] * state->dt;
    r->damping.f_secant[d] = state->f[d];
  }
}

/* Resets pull, because an equilibrium that CheckFrictionLaw has confirmed leaves the friction of the law
   itself, pull 0, whose curl makes later cycles flutter. */
void FrictionModeRestart(Relaxation *r, Contacts *contacts)
{
  if (!ContactsFromCommitted(contacts) || !EffortHasCycles(&r->effort)) return;
  r->follow.stalls = 0;
  contacts->friction = FRICTION_PULLED, contacts->pull = PULL_CLOSE;
}

/* Returns whether explicit cycles that go on from a stall of stiffness_mass chatter: their ratio has risen
   far. They start near an equilibrium, and chatter carries stones away from it. */
static PetscBool chatters(PetscReal ratio, const Relaxation *r, const Contacts *contacts)
{
  return (PetscBool)(r->effort.choice.stalled && !r->begun && contacts->friction == FRICTION_PULLED &&
                     ratio > CHATTERS * r->follow.half_ratio);
}

/* Tries another pull at a stall, and lets slip go at last. Friction that follows the law closely
   (PULL_CLOSE) chatters sooner; friction that follows it from afar (PULL_FAR) is slow to lose slip that
   does not belong to the loads. A stall is an unbalanced ratio that has not halved in one and a half
   periods of the slowest mode. At a stall the other pull is tried. Near a limit load, and where hundreds of
   stones slide, neither comes to rest soon. After STALLS_TO_LET_GO stalls slip is therefore kept as it
   comes for the rest of the stage, by springs as in stages in time. Springs take energy from all motion,
   where the diagram of tptm would make some (deviations.md, m). They feed no oscillation, so the secant damps
   again: the tangent damps ten times too much where a few contacts chatter. */
PetscErrorCode FrictionModeSwitch(const Model *m, const State *state, PetscReal ratio, Relaxation *r,
                                  Contacts *contacts)
{
  const PetscReal wait = STALL_WAIT *
                         PetscMax(ShortestChunk(state), 2. * PETSC_PI / (state->alpha * state->dt));
  const PetscBool halved = (PetscBool)(state->applied.ramp < 1. || ratio < NO_STALL * r->follow.half_ratio),
                  late = (PetscBool)(!halved && (PetscReal)(state->cycle - r->follow.half_cycle) > wait),
                  stalls = (PetscBool)(late || chatters(ratio, r, contacts));
  if (halved || stalls) r->follow.half_ratio = ratio, r->follow.half_cycle = state->cycle;
  PetscFunctionBeginUser;
  if ((halved || stalls) && r->follow.stalls >= STALLS_TO_LET_GO) secant_from(m, state, r);
  if (!stalls || contacts->friction != FRICTION_PULLED) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->pull = contacts->pull == PULL_CLOSE ? PULL_FAR : PULL_CLOSE;
  if (++r->follow.stalls < STALLS_TO_LET_GO) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->friction = FRICTION_SPRINGS;
  r->damping.tangent_only = PETSC_FALSE, r->damping.best_ratio = PETSC_MAX_REAL;
  // springs and the new damping let creeping bodies move: earlier means must not be compared
  r->evidence.steady = 0;
  PetscCall(RestPointForget(m, &r->evidence.rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationStill(const Problem *p)
{
  PetscFunctionBeginUser;
  p->state->beta = BETA_STILL;
  p->relax->damping.tangent_only = (PetscBool)(p->relax->follow.stalls < STALLS_TO_LET_GO);
  p->relax->damping.q_secant = 0.;
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state));
  PetscCall(RelaxationReset(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

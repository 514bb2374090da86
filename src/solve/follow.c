/* follow.c: friction while a static stage is on its way to equilibrium.

   Friction flutter. Slip by a rule that is not associated makes the tangent stiffness unsymmetric: fast
   oscillations along a sliding joint grow by some 1e-3 a cycle and never let it rest, for mass-proportional
   damping hardly touches them, and they carry the joint along as shaking would. So adaptive damping has a
   part proportional to stiffness too where joints can slip, a force beta (f - f_old): a quarter of critical
   at the highest frequency, nothing at the lowest. When the unbalanced ratio has not halved in two periods
   it is doubled and the secant left alone: only what moves on then is a collapse.

   Friction on the way. A static stage has the history of its last equilibrium (false slip: theory.md, ab),
   so its friction is a force that depends on place alone, tau = f(slip held, u). Where a contact slides,

   d(sigma, tau)/d(u_n, u_s) = [k_n 0; -+ k_n tan(phi) 0],

   pressure drives shear and not the other way round: that force has a curl, and a closed path of opening and
   sliding gains work k_n tan(phi) times its area. With an elastic surrounding that couples the two the
   eigenvalues of the tangent are complex, and motions grow by up to a few tenths a cycle. So contacts do not
   have that force on the way: they have elastic-plastic springs that keep their slip and take energy, which
   each cycle draws by `pull` (contacts.h: Contacts) towards the force of the law. What is faster than 1/pull
   cycles meets springs; what is slow, and every equilibrium, meets the law (stress_models.h:
   RespondFollowing, confirm.c: ConfirmByLaw). */
#include "solve/solve.h"

static const PetscReal FOLLOW_FAR = 0.05;

/* f belongs to the displacements before this cycle's step. */
static void secant_from(const Model *m, const State *state, Relaxation *r)
{
  for (PetscInt d = 0; d < m->n_dof; d++) {
    r->damping.u_secant[d] = state->u[d] - state->v[d] * state->dt;
    r->damping.f_secant[d] = state->f[d];
  }
}

/* Friction that follows the law closely chatters sooner; one that follows from afar is slow to lose the slip
   that the way has left behind. Where the unbalanced ratio has not halved in three halves of a period of the
   slowest mode, the other is tried. Near a limit load, and where hundreds of stones slide, neither comes to
   rest soon: after STALLS_TO_LET_GO of these slip is kept as it comes for the rest of the stage, by springs
   as in time, which take energy from whatever moves (tptm would make some with its diagram: theory.md, m).
   They feed no oscillation, so the secant damps again, not the tangent, which is tenfold too much where a
   few contacts chatter. */
void FollowElse(const Model *m, const State *state, PetscReal ratio, Relaxation *r, Contacts *contacts)
{
  const PetscReal wait = 3. * PetscMax(CHUNK_MIN, 2. * PETSC_PI / (state->alpha * state->dt));
  const PetscBool halved = (PetscBool)(state->ramp < 1. || ratio < 0.5 * r->follow.half_ratio),
                  stalls = (PetscBool)(!halved && (PetscReal)(state->cycle - r->follow.half_cycle) > wait);
  if (halved || stalls) r->follow.half_ratio = ratio, r->follow.half_cycle = state->cycle;
  if ((halved || stalls) && r->follow.stalls >= STALLS_TO_LET_GO) secant_from(m, state, r);
  if (!stalls || !contacts->held || contacts->pull == 0.) return;
  contacts->pull = contacts->pull == FOLLOW_CLOSELY ? FOLLOW_FAR : FOLLOW_CLOSELY;
  if (++r->follow.stalls < STALLS_TO_LET_GO) return;
  contacts->held = PETSC_FALSE, contacts->pull = 0., contacts->springs = PETSC_TRUE;
  r->damping.tangent_only = PETSC_FALSE, r->damping.best_ratio = PETSC_MAX_REAL;
}

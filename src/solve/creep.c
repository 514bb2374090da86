/* creep.c: follows the overdamped motion in implicit steps that grow, where Newton's method finds no
   equilibrium.

   Creep. Without its inertia the explicit loop is the motion alpha m du/dt = r(u). A step of backward Euler
   over tau is

     drag m (u - u_creep) = r(u),   drag = alpha/tau.

   That is an equilibrium with springs to where the step began. Newton's method finds this equilibrium,
   because the springs hold blocks whose joints slip or are open. A step that is not found is taken again,
   shorter. tau grows fourfold with each step that is easy, sixteenfold where two iterations were enough. So
   creep ends in one of two ways (for monotone r it is proximal point iteration, Rockafellar 1976). Where
   there is an equilibrium, the drag is soon negligible, and steps are steps of Newton's method. Where there
   is none, the motion goes on for ever and r tends to a constant (Pazy 1971). Then long steps follow the
   mechanism until its faces have parted or slid too far (JudgeContactTravel). The explicit loop has the
   same verdict, on the same path.

   Evidence. Three steps can give the same verdict sooner. Their way grows at least twelvefold, the motion
   keeps its direction, and neither the unbalanced ratio nor the pace falls by a twentieth. The explicit
   loop has the same rule (judge.c: judge_chunk) over a shorter way. Two outcomes prove nothing: an
   equilibrium in large strain farther away than half the travel that is a collapse, and a mechanism that
   turns back. Water that follows its face and a plane that rises can hold a dam again, some centimetres
   beyond the limit of its shape. Then the explicit loop judges.

   Along every step r.du = drag du.m du > 0, to the accuracy asked for (STEP_ERROR). So the loads do more
   work along the mechanism than friction takes and blocks store. A step moves no face by more than half the
   travel that is a collapse. So the mechanism is found from several states, not from one state that an
   iteration happened to reach. Friction starts from the last equilibrium, as everywhere in newton.c.

   The only stiffness of a mechanism comes from bodies and faces that turn under the forces they carry. The
   tangent includes it here (stiffness.c). Loads that follow the motion have their values at the start of
   the step. */
#include "solve/newton.h"

enum { FEWEST_ITERATIONS = 2, FEW_ITERATIONS = 4, SOME_ITERATIONS = 8 };
static const PetscReal LOOSEST = 0.1, TIGHTEST = 1e-3; /* relative residual of a linear solve */
static const PetscReal SHORTER = 8.;                   /* factor on the drag of a step that is repeated */

/* A step, and the state at its end. */
typedef struct {
  PetscReal travel; /* [-] largest travel of a contact: ContactTravel */
  PetscReal ratio;  /* [-] unbalanced ratio */
  PetscReal way;    /* [m] largest displacement of the step */
  PetscReal pace;   /* [m/cycle] way over tau */
  PetscReal cosine; /* [-] cosine between this step and the one before */
} CreepStep;

/* The steps of creep so far. */
typedef struct {
  PetscReal omega;   /* [1/cycle] frequency of the elastic answer at the start: alpha is twice this */
  PetscReal travel;  /* [-] ContactTravel at the start */
  CreepStep seen;    /* the last step with travel within TURN_TRAVEL, or the first step */
  CreepStep last[3]; /* the last steps, the last one first */
  PetscInt steps;
} Course;

/* Takes one step from u_creep, where the norm of the unbalanced force is `force`. */
static PetscErrorCode take_step(const Problem *p, PetscReal force, PetscInt *iterations, PetscBool *found)
{
  PetscReal norm = force, before = force, least = force;
  PetscInt i, least_at = 0;
  PetscFunctionBeginUser;
  for (i = 0;
       i < STEP_ITERATIONS && i - least_at < STEP_STALL && !(norm <= STEP_ERROR * force) && !NewtonSpent(p);
       i++) {
    const PetscReal tolerance = PetscMax(TIGHTEST, 0.5 * PetscPowReal(norm / before, 1.5));
    before = norm;
    PetscCall(NewtonIterate(p, PetscMin(LOOSEST, tolerance), &norm));
    if (norm < 0.5 * least) least = norm, least_at = i;
  }
  *iterations = i, *found = (PetscBool)(norm <= STEP_ERROR * force);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the step just taken. Writes its motion into relax->evidence.du_chunk, which had the motion of
   the step before. */
static PetscErrorCode measure_step(const Problem *p, const Course *c, CreepStep *now)
{
  const Newton *n = p->relax->newton;
  PetscReal *before = p->relax->evidence.du_chunk, sum[3] = {0., 0., 0.};
  const PetscReal *from;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(n->u_creep, &from));
  now->way = 0.;
  for (PetscInt d = 0; d < p->m->n_dof; d++) {
    const PetscReal du = p->state->u[d] - from[d], mass = p->state->m[d];
    now->way = PetscMax(now->way, PetscAbsReal(du) * DofLength(p->m, p->state, d));
    sum[0] += mass * du * before[d], sum[1] += mass * du * du, sum[2] += mass * before[d] * before[d];
    before[d] = du;
  }
  PetscCall(VecRestoreArrayRead(n->u_creep, &from));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &now->way, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPI_SUM, p->m->comm));
  now->cosine = sum[1] > 0. && sum[2] > 0. ? sum[0] / PetscSqrtReal(sum[1] * sum[2]) : 0.;
  now->pace = now->way * n->drag / (2. * c->omega);
  PetscCall(Unbalanced(p->m, p->state, n->contact_scale, p->relax->evidence.u_0, p->result));
  PetscCall(ContactTravel(p, &now->travel));
  now->ratio = p->result->ratio;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether three steps show a mechanism, by the rule of the explicit loop. */
static PetscBool moves_on(const Course *c)
{
  const CreepStep *now = c->last, *first = c->last + 2;
  return (PetscBool)(c->steps > 2 && now->way > MECHANISM_GROWTH * first->way &&
                     now->travel > c->travel + MECHANISM_TRAVEL &&
                     PetscMin(now->cosine, c->last[1].cosine) > MECHANISM_COSINE &&
                     now->ratio > MECHANISM_HOLDS * first->ratio &&
                     now->pace > MECHANISM_HOLDS * first->pace);
}

/* Sets the verdict "collapsed" with its evidence. The mechanism is the motion of the last step: chunk_start
   makes MechanismTake read it from du_chunk. */
static PetscErrorCode collapsed(const Problem *p, const Course *c)
{
  const CreepStep *now = c->last, *from = p->result->verdict == VERDICT_NONE ? now + 2 : &c->seen;
  char *evidence = p->result->evidence;
  PetscFunctionBeginUser;
  p->relax->evidence.chunk_start = p->state->cycle;
  if (p->result->verdict == VERDICT_NONE)
    PetscCall(PetscSNPrintf(evidence, sizeof(p->result->evidence),
                            "a mechanism that has moved faces by %.3g of their length, cosine %.4f",
                            (double)(now->travel - c->travel), (double)now->cosine));
  p->result->verdict = VERDICT_COLLAPSED;
  char more[160];
  PetscCall(PetscSNPrintf(more, sizeof(more),
                          "; %" PetscInt_FMT
                          " steps of creep, from %.3g to %.3g m long: ratio from %.3g to %.3g, "
                          "motion from %.3g to %.3g m a cycle",
                          c->steps, (double)from->way, (double)now->way, (double)from->ratio,
                          (double)now->ratio, (double)from->pace, (double)now->pace));
  PetscCall(PetscStrlcat(evidence, more, sizeof(p->result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Judges a step that was found. again: the step was too long; lost: the mechanism has turned back. */
static PetscErrorCode judge_step(const Problem *p, Course *c, PetscBool *again, PetscBool *lost)
{
  const PetscReal travel = c->steps ? c->last[0].travel : c->travel;
  CreepStep now;
  PetscFunctionBeginUser;
  PetscCall(measure_step(p, c, &now));
  *lost = (PetscBool)(travel > c->travel + TURN_TRAVEL && now.cosine < 0.);
  *again = (PetscBool)(now.travel > travel + STEP_TRAVEL);
  if (*again || *lost) PetscFunctionReturn(PETSC_SUCCESS);
  for (int i = 2; i > 0; i--) c->last[i] = c->last[i - 1];
  c->last[0] = now, c->steps++;
  if (now.travel <= c->travel + TURN_TRAVEL || c->steps == 1) c->seen = now;
  PetscCall(JudgeContactTravel(p, PETSC_FALSE));
  if (p->result->verdict != VERDICT_NONE || moves_on(c)) PetscCall(collapsed(p, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether a step begins at an equilibrium: the ratio is small, and the last step was shorter than the
   one before, while steps of a mechanism grow. found: the equilibrium is near enough; lost: it is too far
   away to prove anything, or a number is not finite. */
static PetscErrorCode at_rest(const Problem *p, const Course *c, PetscBool *found, PetscBool *lost)
{
  const PetscReal travel = c->steps ? c->last[0].travel : c->travel;
  PetscBool rest = (PetscBool)(p->result->ratio <= p->stage->tolerance &&
                               (c->steps < 2 || c->last[0].way < c->last[1].way));
  PetscFunctionBeginUser;
  if (rest) PetscCall(BodiesAreSupported(p, LOAD_MISSING, &rest));
  *found = (PetscBool)(rest && (p->m->materials.strain == STRAIN_SMALL || travel < c->travel + STEP_TRAVEL));
  *lost = (PetscBool)(!p->result->finite || (rest && !*found));
  if (*found)
    PetscCall(PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                            "; %" PetscInt_FMT " steps of creep, joints moved by up to %.2g of a face",
                            c->steps, (double)travel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the drag of the next step, which falls less the more iterations this step took. gain [-]: travel
   of contacts in this step over the allowed one, is the least factor, so that the next step will not be too
   long. */
static PetscReal next_drag(PetscReal drag, PetscInt iterations, PetscReal gain)
{
  const PetscReal factor = iterations <= FEWEST_ITERATIONS ? 1. / 16.
                           : iterations <= FEW_ITERATIONS  ? 0.25
                           : iterations <= SOME_ITERATIONS ? 0.5
                                                           : 1.;
  return drag * PetscMax(factor, gain);
}

/* Finds whether at most one more end of a contact broke in a step. A longer step would pass over equilibria
   between two breaks. ends: number of broken ends at the start of the step; at its end, if in_turn. */
static PetscErrorCode breaks_in_turn(const Problem *p, PetscInt *ends, PetscBool *in_turn)
{
  PetscInt now;
  PetscFunctionBeginUser;
  PetscCall(CountBrokenEnds(p, &now));
  *in_turn = (PetscBool)(now <= *ends + 1);
  if (*in_turn) *ends = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes steps until one of them leads to an equilibrium or a verdict, or a limit is reached. */
static PetscErrorCode creep(const Problem *p, Course *c, PetscBool *found, PetscBool *stop)
{
  Newton *n = p->relax->newton;
  PetscReal drag = c->omega * c->omega, least = 0., force;
  const PetscReal most = MOST_DRAG * drag, fine = FINE_DRAG * drag;
  PetscInt ends = 0;
  PetscBool lost = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < MOST_STEPS && drag < most && !*stop && !NewtonSpent(p); i++) {
    PetscInt iterations = 0;
    PetscBool good = PETSC_FALSE, again = PETSC_FALSE;
    PetscCall(NewtonKeep(p, n->u_creep));
    PetscCall(LoadsRenew(p->scene, p->m, p->stage, p->state));
    n->drag = 0.;
    PetscCall(NewtonEvaluate(p, 0., NULL, &force));
    PetscCall(Unbalanced(p->m, p->state, n->contact_scale, p->relax->evidence.u_0, p->result));
    PetscCall(at_rest(p, c, found, &lost));
    if (*found || lost) break;
    n->drag = drag;
    snprintf(n->progress, sizeof(n->progress), "creep, step %" PetscInt_FMT ", ratio %.2e", i + 1,
             (double)p->result->ratio);
    PetscCall(take_step(p, force, &iterations, &good));
    if (good && n->drag < fine) PetscCall(breaks_in_turn(p, &ends, &good));
    if (good) {
      const PetscReal travel = c->steps ? c->last[0].travel : c->travel;
      PetscCall(judge_step(p, c, &again, &lost));
      if (lost || p->result->verdict != VERDICT_NONE) break;
      drag = next_drag(drag, iterations, c->steps ? (c->last[0].travel - travel) / (0.9 * STEP_TRAVEL) : 0.);
    }
    if (!good || again) {
      PetscCall(NewtonMove(p, n->u_creep));
      least = 2. * n->drag, drag = SHORTER * n->drag;
    }
    drag = PetscMax(drag, least);
    if (good && !again) least *= 0.5;
    PetscCall(CheckpointStop(p->checkpoint, stop));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonCreep(const Problem *p, PetscBool *found, PetscBool *stop)
{
  Newton *n = p->relax->newton;
  Course c = {.steps = 0};
  PetscReal force, omega_2;
  PetscFunctionBeginUser;
  *found = *stop = PETSC_FALSE;
  PetscCall(NewtonFresh(p));
  PetscCall(PetscArrayzero(p->relax->evidence.du_chunk, p->m->n_dof));
  PetscCall(NewtonEvaluate(p, 0., NULL, &force));
  PetscCall(NewtonElasticFrequency(p, &omega_2));
  PetscCall(ContactTravel(p, &c.travel));
  c.omega = PetscSqrtReal(omega_2);
  if (omega_2 > 0.) PetscCall(creep(p, &c, found, stop));
  n->drag = 0.;
  if (n->stiffness.turned) PetscCall(StiffnessBodies(p->m, p->state, PETSC_FALSE, &n->stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

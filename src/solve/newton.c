/* newton.c: finds the equilibrium of a static stage by Newton's method on the assembled stiffness
   (relaxation.method: preconditioned), under fixed connectivity.

   The stiffness K0 of blocks and elastic joints is factorised once (sparse Cholesky through PETSc) and
   serves all stages and trials with the same contacts and joint stiffnesses. An iteration solves K_t du =
   r, where K_t is the tangent with the present state of joints, by flexible GMRES preconditioned with K0.
   K_t differs from K0 only in the joints that slip or are open, so 1 to 10 solves with the factor are
   enough. Fewer solves are needed as long as r is large, because the tolerance follows how fast r falls
   (Eisenstat and Walker 1996).

   Friction has a history. Every evaluation starts from the history of the last committed equilibrium, tau =
   f(tau committed, u - u committed), and only an equilibrium is committed. With a history that advanced at
   every evaluation the iteration would converge to a wrong slip.

   Safeguards. The step is bounded. An increment that does not converge is repeated by creep (creep.c), from
   the last equilibrium. Creep finds the equilibrium, or the mechanism that moves on for ever. When it finds
   neither, or the factor fails (a body that nothing holds), the explicit loop continues.

   Checkpoints are written at equilibria. An increment depends on the state alone: the factor belongs to the
   undeformed scene, the first tangent to the present state of joints. So a restart takes the same steps as
   a run without interruption. A signal within an increment undoes that increment. */
#include "solve/newton.h"
#include <float.h>

static const PetscReal LOOSEST = 0.3; /* relative residual that a linear solve may leave */

/* ---- memory of the method, kept from stage to stage */

/* Finds whether the factor belongs to the present contacts and joint stiffnesses, and to the same use. */
static PetscErrorCode is_current(const Problem *p, PetscBool every_cycle, PetscBool *current)
{
  const Newton *n = p->relax->newton;
  const Contacts *c = p->contacts;
  PetscBool same = (PetscBool)(n->stiffness.n_vertices == p->m->mesh.n_vertices &&
                               n->n_padded == c->n_padded && !n->nested == !every_cycle);
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < CONTACT_ROWS * c->n_padded && same; i++)
    same = (PetscBool)(n->vertex[i] == c->vertex[i]);
  for (PetscInt j = 0; j < n->n_joints; j++) {
    const Joint *joint = p->stage->joints + j;
    if (n->k[2 * j] != joint->k_n || n->k[2 * j + 1] != joint->k_s) same = PETSC_FALSE;
  }
  PetscCallMPI(MPI_Allreduce(&same, current, 1, MPI_PETSC_BOOL, MPI_LAND, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrices and work arrays of Newton's method for the present contacts. */
static PetscErrorCode create(const Problem *p, Newton *n)
{
  PetscFunctionBeginUser;
  PetscCall(StiffnessCreate(p->m, p->state, p->contacts, &n->stiffness));
  PetscCall(MatCreateVecs(n->stiffness.tangent, &n->r, &n->du));
  PetscCall(VecGetSize(n->r, &n->n_dof));
  PetscCall(VecDuplicate(n->r, &n->dragged));
  PetscCall(VecDuplicate(n->r, &n->u));
  PetscCall(VecDuplicate(n->r, &n->u_base));
  PetscCall(VecDuplicate(n->r, &n->u_creep));
  PetscCall(PetscMalloc1(p->m->n_dof, &n->contact_scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the contacts and joints that the factor belongs to. */
static PetscErrorCode note_contacts(const Problem *p, Newton *n)
{
  const PetscInt n_padded = p->contacts->n_padded;
  PetscFunctionBeginUser;
  n->n_padded = n_padded, n->n_joints = p->scene->n_joints;
  PetscCall(PetscMalloc2(CONTACT_ROWS * n_padded, &n->vertex, 2 * n->n_joints, &n->k));
  PetscCall(PetscArraycpy(n->vertex, p->contacts->vertex, CONTACT_ROWS * n_padded));
  for (PetscInt j = 0; j < n->n_joints; j++)
    n->k[2 * j] = p->stage->joints[j].k_n, n->k[2 * j + 1] = p->stage->joints[j].k_s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonDestroy(Newton **newton)
{
  Newton *n = *newton;
  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StiffnessDestroy(&n->stiffness));
  PetscCall(KSPDestroy(&n->elastic));
  PetscCall(KSPDestroy(&n->worn));
  PetscCall(NestedDestroy(&n->nested));
  PetscCall(VecDestroy(&n->r));
  PetscCall(VecDestroy(&n->du));
  PetscCall(VecDestroy(&n->dragged));
  PetscCall(VecDestroy(&n->u));
  PetscCall(VecDestroy(&n->u_base));
  PetscCall(VecDestroy(&n->u_creep));
  PetscCall(PetscFree(n->contact_scale));
  PetscCall(PetscFree2(n->vertex, n->k));
  PetscCall(PetscFree(*newton));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the last equilibrium */

/* Makes the present state the last equilibrium. */
static PetscErrorCode commit(const Problem *p)
{
  const TermView view = ViewOf(p);
  Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  n->result = *p->result, n->effort = p->relax->effort, n->cycle = p->state->cycle;
  PetscCall(NewtonKeep(p, n->u));
  if (!TermsHaveTrial(&view)) PetscCall(TermsHistory(&view, COMMIT));
  ContactTravelStartBearing(p->contacts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores the displacements and the history of the last equilibrium, and the loads that follow the
   motion. */
static PetscErrorCode restore(const Problem *p)
{
  const TermView view = ViewOf(p);
  PetscFunctionBeginUser;
  PetscCall(TermsHistory(&view, GO_BACK));
  PetscCall(NewtonMove(p, p->relax->newton->u));
  if (LoadsChange(p->scene, p->m, p->stage, p->state))
    PetscCall(LoadsTarget(p->scene, p->m, p->stage, p->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the period of the slowest motion, as the right damping alpha = 2 omega (38), for verdicts of the
   explicit loop. */
static PetscErrorCode remember_period(const Problem *p)
{
  PetscReal omega_2;
  PetscFunctionBeginUser;
  PetscCall(NewtonElasticFrequency(p, &omega_2));
  p->relax->evidence.settled_alpha = 2. * PetscSqrtReal((1. + 2. * p->state->beta) * omega_2);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that the work has reached its limit, and warns that explicit cycles go on. */
static void give_up(const Problem *p)
{
  const Effort *e = &p->relax->effort;
  p->relax->spent = *e;
  if (p->m->rank || p->relax->most_work > 0. || p->scene->method == METHOD_AUTO) return;
  Warn("stage %s: preconditioned relaxation found no equilibrium in %" PetscInt64_FMT
       " solves and %" PetscInt64_FMT " factorisations: the stage goes on by explicit cycles",
       p->stage->name, e->solves, e->factorisations);
}

/* ---- increments */

/* Finds whether the loads of the stage differ from the loads at its start. However small the change is, it
   takes at least one iteration. */
static PetscErrorCode loads_change(const Problem *p, PetscBool *change)
{
  PetscBool mine = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < p->m->n_dof && !mine; d++)
    mine = (PetscBool)(p->state->applied.target[d] != p->state->applied.start[d]);
  PetscCallMPI(MPI_Allreduce(&mine, change, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rejects an equilibrium farther away than the travel that is a collapse. Iterations follow no path, so they
   may have jumped over one that is nearer. Creep then follows the motion, or explicit cycles do. */
static PetscErrorCode reject_jump(const Problem *p, PetscBool *found)
{
  PetscFunctionBeginUser;
  PetscCall(JudgeContactTravel(p, (PetscBool)(p->state->applied.ramp >= 1.)));
  if (p->result->verdict == VERDICT_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  p->result->verdict = VERDICT_NONE, p->result->evidence[0] = 0;
  *found = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Iterates to equilibrium under the loads applied. stop: a signal or the limit of wall time has ended the
   iteration. */
static PetscErrorCode equilibrium(const Problem *p, PetscBool *found, PetscBool *stop)
{
  const Newton *n = p->relax->newton;
  PetscReal norm, before = 0., least = PETSC_MAX_REAL;
  PetscInt least_at = 0;
  PetscBool fresh;
  PetscFunctionBeginUser;
  PetscCall(loads_change(p, &fresh));
  *found = *stop = PETSC_FALSE;
  p->result->increment = 0.;
  PetscCall(NewtonFresh(p));
  PetscCall(NewtonEvaluate(p, 0., NULL, &norm));
  if (!(p->relax->evidence.settled_alpha > 0.)) PetscCall(remember_period(p));
  for (PetscInt i = 0; i < NEWTON_ITERATIONS && i - least_at < NEWTON_STALL && !NewtonSpent(p); i++) {
    const PetscReal step = p->result->increment;
    PetscCall(Unbalanced(p->m, p->state, n->contact_scale, p->relax->evidence.u_0, p->result));
    p->result->increment = step / PetscMax(PetscMax(p->result->displacement, step), DBL_MIN);
    *found = (PetscBool)(p->result->finite && p->result->ratio <= p->stage->tolerance &&
                         (i || !fresh || norm == 0.));
    if (*found) PetscCall(BodiesAreSupported(p, LOAD_MISSING, found));
    if (!p->result->finite || *found) break;
    if (norm < 0.5 * least) least = norm, least_at = i;
    if (norm > NEWTON_RISEN * least) break;
    // a solve is as exact as the expected next residual, and as the tolerance of the stage
    PetscReal tolerance = i ? PetscMin(LOOSEST, 0.5 * PetscPowReal(norm / before, 1.5)) : LOOSEST;
    tolerance = PetscMin(PetscMax(tolerance, 0.3 * p->stage->tolerance / p->result->ratio), LOOSEST);
    before = norm;
    snprintf(p->relax->newton->progress, sizeof(n->progress), "iteration %" PetscInt_FMT ", ratio %.2e",
             i + 1, (double)p->result->ratio);
    PetscCall(NewtonIterate(p, tolerance, &norm));
    PetscCall(CheckpointStop(p->checkpoint, stop));
    if (*stop) break;
    PetscCall(LoadsRenew(p->scene, p->m, p->stage, p->state));
  }
  if (*found) PetscCall(reject_jump(p, found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tries the displacements of a similar run first, with the history of the last equilibrium. Where they lead
   to no equilibrium, the increment starts as usual. */
static PetscErrorCode from_guess(const Problem *p, PetscReal target, PetscBool *found, PetscBool *stop)
{
  Vec guess = target == 1. ? p->relax->guess : NULL;
  PetscFunctionBeginUser;
  *found = *stop = PETSC_FALSE;
  if (!guess) PetscFunctionReturn(PETSC_SUCCESS);
  p->relax->guess = NULL;
  PetscCall(NewtonMove(p, guess));
  PetscCall(LoadsRenew(p->scene, p->m, p->stage, p->state));
  PetscCall(equilibrium(p, found, stop));
  if (*found || *stop) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(restore(p));
  LoadsApply(p->m, p->state, target);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonFactor(const Problem *p, PetscBool every_cycle, PetscBool *works)
{
  Newton **newton = &p->relax->newton;
  PetscBool current = PETSC_FALSE, fits;
  double memory[2];
  PetscFunctionBeginUser;
  *works = PETSC_FALSE;
  if (*newton) PetscCall(is_current(p, every_cycle, &current));
  if (!current) {
    PetscCall(NewtonDestroy(newton));
    PetscCall(NewtonFits(p->m, every_cycle, memory, &fits));
    if (!fits) PetscCall(FactorWants(p, memory));
    if (!fits) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscNew(newton));
    PetscCall(note_contacts(p, *newton));
    PetscCall(PetscArraycpy((*newton)->memory, memory, 2));
    if (every_cycle) {
      PetscCall(FactorNested(p));
    } else {
      PetscCall(create(p, *newton));
      PetscCall(FactorElastic(p));
    }
  }
  *works = (PetscBool) !(*newton)->fails;
  if (!*works && (*newton)->wants) PetscCall(FactorWants(p, (*newton)->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Provides the factor for this stage, and makes the present state the last equilibrium. works: as in
   NewtonFactor. */
static PetscErrorCode prepare(const Problem *p, PetscBool *works)
{
  PetscFunctionBeginUser;
  PetscCall(NewtonFactor(p, PETSC_FALSE, works));
  if (!p->relax->newton) PetscFunctionReturn(PETSC_SUCCESS); // there was no memory for it
  p->relax->effort.preconditioned = PETSC_TRUE;
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  PetscCall(commit(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Undoes an increment that was stopped. A restart repeats it. */
static PetscErrorCode undo_increment(const Problem *p)
{
  const Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  PetscCall(restore(p));
  *p->result = n->result, p->relax->effort = n->effort, p->state->cycle = n->cycle;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns that contacts fail within the shortest increment. */
static void warn_of_order(const Problem *p, PetscInt n, PetscReal length)
{
  if (p->m->rank || p->relax->step_warned == p->number + 1) return;
  p->relax->step_warned = p->number + 1;
  Warn("stage %s: %d contacts fail within %.2g of its load: the order in which they fail is not resolved, "
       "and it may decide about the others; compare with more stages or method: explicit",
       p->stage->name, (int)n, (double)length);
}

/* Halves an increment whose end depends on the path of the load, down to INCREMENT_SHORTEST. A ramp breaks
   contacts one after the other: contacts that fail first relieve others, so at most one may fail in an
   increment. Columns also settle and slip one after the other: where contacts slip, an equilibrium that creep
   reached from far is one of many, and a slow load may find none. A mechanism that creep found counts if no
   contact broke on its way. again: the increment must be repeated at half its length. Stages that apply their
   loads at once, and trials that change only strengths, have no shorter increment. */
static PetscErrorCode halve(const Problem *p, PetscReal target, PetscBool crept, PetscReal *step,
                            PetscBool *again)
{
  const PetscReal length = target - p->relax->reached;
  const PetscBool collapsed = (PetscBool)(p->result->verdict != VERDICT_NONE);
  PetscInt n_broken, n_slipping;
  PetscFunctionBeginUser;
  PetscCall(CountFailedContacts(p, &n_broken, &n_slipping));
  const PetscBool one_of_many = (PetscBool)(crept && !collapsed && n_slipping);
  *again = (PetscBool)(p->stage->ramp && (n_broken > (crept ? 0 : 1) || one_of_many));
  if (!*again) PetscFunctionReturn(PETSC_SUCCESS);
  if (length > 1.5 * INCREMENT_SHORTEST / (PetscReal)p->scene->increments)
    PetscCall(loads_change(p, again));
  else
    *again = PETSC_FALSE;
  if (*again) {
    *step = 0.5 * length, p->result->verdict = VERDICT_NONE;
    PetscCall(restore(p));
  } else if (n_broken > 1 && !collapsed)
    warn_of_order(p, n_broken, length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonRelax(const Problem *p)
{
  State *state = p->state;
  StageResult *result = p->result;
  PetscReal *const reached = &p->relax->reached, *const step = &p->relax->step;
  const PetscReal *u_0;
  char creep[128]; // the evidence of creep, if the last increment took any
  PetscBool works;
  PetscFunctionBeginUser;
  if (!(*step > 0.)) *reached = 0., *step = p->stage->ramp ? 1. / (PetscReal)p->scene->increments : 1.;
  PetscCall(prepare(p, &works));
  while (works && *reached < 1.) {
    const PetscReal target = *reached + 1.000001 * *step < 1. ? *reached + *step : 1.;
    PetscBool found, stop, crept, again;
    PetscCall(CheckpointPoll(p->checkpoint, state->cycle, result));
    if (result->verdict != VERDICT_NONE) break;
    LoadsApply(p->m, state, target);
    result->evidence[0] = 0;
    PetscCall(from_guess(p, target, &found, &stop));
    if (!found && !stop) PetscCall(equilibrium(p, &found, &stop));
    crept = (PetscBool)(!found && !stop);
    if (crept) {
      PetscCall(restore(p));
      LoadsApply(p->m, state, target);
      PetscCall(NewtonCreep(p, &found, &stop));
    }
    if (found && result->verdict == VERDICT_NONE) PetscCall(JudgeContactTravel(p, (PetscBool)(target >= 1.)));
    found = (PetscBool)(found && !p->relax->outgrown);
    if (stop) {
      PetscCall(undo_increment(p));
      continue;
    }
    if (!found && result->verdict == VERDICT_NONE) {
      if (NewtonSpent(p)) give_up(p);
      PetscCall(restore(p));
      break;
    }
    PetscCall(halve(p, target, crept, step, &again));
    if (again) continue;
    PetscCall(VecGetArrayRead(p->relax->newton->u, &u_0));
    PetscCall(CheckLoadStep(p, *reached, u_0));
    PetscCall(VecRestoreArrayRead(p->relax->newton->u, &u_0));
    *reached = target;
    PetscCall(commit(p));
    *step = PetscMin(2. * *step, p->stage->ramp ? 1. / (PetscReal)p->scene->increments : 1.);
    PetscCall(OutputHistory(p));
    if (result->verdict != VERDICT_NONE) break;
  }
  *step = 0.;
  if (result->verdict != VERDICT_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  LoadsApply(p->m, state, *reached);
  if (*reached < 1.) PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_CONVERGED;
  PetscCall(PetscStrncpy(creep, result->evidence, sizeof(creep)));
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence), "unbalanced ratio %.3g <= %.3g%s",
                          (double)result->ratio, (double)p->stage->tolerance, creep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Uses inverse iteration, K0 y = m x. It starts from the present displacements, which consist mostly of
   slow motions. The error of the Rayleigh quotient y.m x / y.m y is of second order in the error of y. */
PetscErrorCode NewtonLowestFrequency(const Model *m, const State *state, const Newton *n, PetscReal *omega)
{
  enum { SWEEPS = 8 };
  PetscReal *x, sum[2] = {0., 0.};
  const PetscReal *y;
  PetscFunctionBeginUser;
  *omega = 0.;
  if (!n || n->fails || n->nested) PetscFunctionReturn(PETSC_SUCCESS);
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    const PetscReal *from = sweep ? NULL : state->u, size = sum[1] > 0. ? 1. / PetscSqrtReal(sum[1]) : 1.;
    PetscCall(VecGetArrayWrite(n->r, &x));
    PetscCall(VecGetArrayRead(n->du, &y));
    for (PetscInt d = 0; d < m->n_dof; d++)
      x[d] = Held(m, d) ? 0. : state->m[d] * (from ? from[d] : size * y[d]);
    PetscCall(VecRestoreArrayRead(n->du, &y));
    PetscCall(VecRestoreArrayWrite(n->r, &x));
    PetscCall(PCApply(n->pc, n->r, n->du));
    sum[0] = sum[1] = 0.;
    PetscCall(VecGetArrayWrite(n->r, &x));
    PetscCall(VecGetArrayRead(n->du, &y));
    for (PetscInt d = 0; d < m->n_dof; d++) sum[0] += y[d] * x[d], sum[1] += state->m[d] * y[d] * y[d];
    PetscCall(VecRestoreArrayRead(n->du, &y));
    PetscCall(VecRestoreArrayWrite(n->r, &x));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, m->comm));
  }
  if (sum[0] > 0. && sum[1] > 0.) *omega = PetscSqrtReal(sum[0] / sum[1]) * state->dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

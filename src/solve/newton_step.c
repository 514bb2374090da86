/* newton_step.c: does one iteration of Newton's method: tangent, linear solve, line search. */
#include "solve/newton.h"

enum { MOST_HALVINGS = 6 };
enum { MANY_SOLVES = 20 }; /* solves in one iteration beyond which the factor is out of date */
/* Degrees of freedom of rigid blocks up to which each iteration but the first has a factor of its own, whose
   rows are short. K0 knows nothing of joints that slip or are open: near the limit of walls of 40 to 100
   blocks it took 2 to 7 times the processor time. */
enum { SMALL_TANGENT = 2000 };
static const PetscReal FULL_ROWS = 6.; /* a factor of full rows costs as much as n/6 solves */
static const PetscReal HOLDS_FREE =
    1e-3; /* stiffness of free bodies over the scaled masses, which are of the size of the stiffness */
static const PetscReal LARGEST_STEP =
    0.01; /* [-] displacement in one iteration, over the diameter of the model */
static const PetscReal LARGEST_RISE = 10.,
                       LARGEST_IN_CREEP = 30.; /* [-] growth of the unbalanced force in one iteration */

PetscErrorCode NewtonKeep(const Problem *p, Vec u)
{
  PetscFunctionBeginUser;
  PetscCall(StateGive(p->state));
  PetscCall(VecCopy(p->state->displacement, u));
  PetscCall(StateTake(p->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonMove(const Problem *p, Vec u)
{
  State *state = p->state;
  PetscFunctionBeginUser;
  PetscCall(StateGive(state));
  PetscCall(VecCopy(u, state->displacement));
  PetscCall(StateTake(state));
  RigidMotion(p->m, state->u);
  PetscCall(GhostBegin(p->m, state->u + 3 * p->m->rigid.n));
  PetscCall(GhostEnd(p->m, state->u + 3 * p->m->rigid.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonEvaluate(const Problem *p, PetscReal part, Vec du, PetscReal *norm)
{
  const Newton *n = p->relax->newton;
  const Model *m = p->m;
  State *state = p->state;
  PetscReal *r, sum = 0.;
  const PetscReal *u_creep;
  PetscFunctionBeginUser;
  PetscCall(StateGive(state));
  if (du) PetscCall(VecWAXPY(state->displacement, part, du, n->u_base));
  PetscCall(StateTake(state));
  RigidMotion(m, state->u);
  PetscCall(Forces(p->scene, m, p->stage->joints, p->contacts, state, n->contact_scale));
  p->relax->effort.evaluations++, p->result->cycles++, state->cycle++;
  PetscCall(VecGetArrayWrite(n->r, &r));
  PetscCall(VecGetArrayRead(n->u_creep, &u_creep));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    r[d] = Held(m, d) ? 0. : state->f_ext[d] - state->f[d];
    if (n->drag > 0. && !Held(m, d)) r[d] -= n->drag * state->m[d] * (state->u[d] - u_creep[d]);
    const PetscReal force = r[d] / DofLength(m, state, d);
    sum += force * force;
  }
  PetscCall(VecRestoreArrayRead(n->u_creep, &u_creep));
  PetscCall(VecRestoreArrayWrite(n->r, &r));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPI_SUM, m->comm));
  *norm = PetscSqrtReal(sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the drag of a creep step to the diagonal of the tangent. */
static PetscErrorCode add_drag(const Problem *p)
{
  Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  PetscCall(StateGive(p->state));
  PetscCall(VecCopy(p->state->mass, n->dragged));
  PetscCall(StateTake(p->state));
  PetscCall(VecScale(n->dragged, n->drag));
  PetscCall(MatDiagonalSet(n->stiffness.tangent, n->dragged, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Holds bodies for which the tangent is singular by a little stiffness on their diagonal. */
static PetscErrorCode hold_free_bodies(const Problem *p)
{
  Newton *n = p->relax->newton;
  const Model *m = p->m;
  PetscInt *is_free, n_free;
  PetscReal *diagonal;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->mesh.n_bodies_global, &is_free));
  PetscCall(FreeBodies(p, is_free, &n_free));
  if (n_free) {
    PetscCall(VecGetArrayWrite(n->dragged, &diagonal));
    for (PetscInt d = 0; d < m->n_dof; d++)
      diagonal[d] = is_free[DofBody(m, d)] ? HOLDS_FREE * p->state->m[d] : 0.;
    PetscCall(VecRestoreArrayWrite(n->dragged, &diagonal));
    PetscCall(MatDiagonalSet(n->stiffness.tangent, n->dragged, ADD_VALUES));
  }
  PetscCall(PetscFree(is_free));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether solves with the elastic factor cost more than a new factor of the tangent, whose rows are
   full where bodies are condensed. */
static PetscErrorCode is_worn(const Newton *n, PetscBool *worn)
{
  MatInfo info;
  PetscFunctionBeginUser;
  PetscCall(MatGetInfo(n->stiffness.tangent, MAT_GLOBAL_SUM, &info));
  const PetscReal row = info.nz_used / (PetscReal)n->n_dof;
  *worn = (PetscBool)((PetscReal)n->last_solves > PetscMax((PetscReal)MANY_SOLVES, row / FULL_ROWS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves K_t du = r to the relative residual `tolerance`. */
static PetscErrorCode solve(const Problem *p, PetscReal tolerance)
{
  Newton *n = p->relax->newton;
  const Model *m = p->m;
  const PetscBool small = (PetscBool)(m->size == 1 && m->n_dof == 3 * m->rigid.n &&
                                      m->n_dof <= SMALL_TANGENT);
  PetscBool fails = PETSC_FALSE, worn = (PetscBool)(small && n->last_solves);
  PetscFunctionBeginUser;
  if (n->drag > 0. && m->materials.strain == STRAIN_LARGE)
    PetscCall(StiffnessBodies(m, p->state, PETSC_TRUE, &n->stiffness));
  PetscCall(StiffnessTangent(m, p->state, p->stage->joints, p->contacts, PETSC_FALSE, &n->stiffness));
  PetscCall(n->drag > 0. ? add_drag(p) : hold_free_bodies(p));
  if (!small) PetscCall(is_worn(n, &worn));
  if (worn) PetscCall(Factorise(p, PCLU, small ? MATSOLVERPETSC : MATSOLVERMUMPS, &n->worn, &fails));
  if (fails) PetscCall(KSPDestroy(&n->worn));
  KSP ksp = n->worn ? n->worn : n->elastic;
  n->problem = p;
  PetscCall(KSPSetTolerances(ksp, tolerance, PETSC_SMALL, PETSC_MAX_REAL, NEWTON_MOST_SOLVES));
  PetscCall(KSPSolve(ksp, n->r, n->du));
  PetscCall(KSPGetIterationNumber(ksp, &n->last_solves));
  p->relax->effort.solves += n->last_solves;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonElasticFrequency(const Problem *p, PetscReal *omega_2)
{
  const Newton *n = p->relax->newton;
  const PetscReal *r, *du;
  PetscReal sum[2] = {0., 0.};
  PetscFunctionBeginUser;
  *omega_2 = 0.;
  PetscCall(PCApply(n->pc, n->r, n->du));
  p->relax->effort.solves++;
  PetscCall(VecGetArrayRead(n->r, &r));
  PetscCall(VecGetArrayRead(n->du, &du));
  for (PetscInt d = 0; d < p->m->n_dof; d++) sum[0] += du[d] * r[d], sum[1] += p->state->m[d] * du[d] * du[d];
  PetscCall(VecRestoreArrayRead(n->du, &du));
  PetscCall(VecRestoreArrayRead(n->r, &r));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, p->m->comm));
  if (sum[0] > 0. && sum[1] > 0.) *omega_2 = sum[0] / sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest part of the correction du that moves no point farther than the bound; 0: du is not
   finite. */
static PetscErrorCode bound_step(const Problem *p, Vec correction, PetscReal *part)
{
  const PetscReal bound = LARGEST_STEP * p->m->mesh.diameter, *du;
  PetscReal most = 0.;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(correction, &du));
  for (PetscInt d = 0; d < p->m->n_dof; d++) {
    const PetscReal size = PetscAbsReal(du[d]) * DofLength(p->m, p->state, d);
    if (!(size <= most)) most = size < PETSC_MAX_REAL ? size : PETSC_MAX_REAL;
  }
  PetscCall(VecRestoreArrayRead(correction, &du));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  *part = most >= PETSC_MAX_REAL ? 0. : most > bound ? bound / most : 1.;
  p->result->increment = PetscMin(most, bound);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves along du by its whole length, or halves it until |r| does not grow too much. |r| need not fall:
   while a joint opens farther, forces at the scale of a block rise and say nothing about the error, and
   shorter steps that keep them down took twice the solves. The growth allowed in creep is larger: a step may
   press corners together as a body turns, but must not lift the body off, which the next step does not
   repair. */
static PetscErrorCode line_search(const Problem *p, Vec du, PetscReal *norm)
{
  const Newton *n = p->relax->newton;
  const PetscReal most = *norm * (n->drag > 0. ? LARGEST_IN_CREEP : LARGEST_RISE);
  PetscReal part = 0., trial = PETSC_MAX_REAL;
  PetscFunctionBeginUser;
  PetscCall(bound_step(p, du, &part));
  PetscCall(NewtonKeep(p, n->u_base));
  for (int i = 0; i <= MOST_HALVINGS && !(trial < most); i++, part *= 0.5)
    PetscCall(NewtonEvaluate(p, part, du, &trial));
  *norm = trial;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonIterate(const Problem *p, PetscReal tolerance, PetscReal *norm)
{
  PetscFunctionBeginUser;
  PetscCall(solve(p, tolerance));
  PetscCall(line_search(p, p->relax->newton->du, norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NewtonFresh(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(KSPDestroy(&p->relax->newton->worn));
  p->relax->newton->last_solves = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool NewtonSpent(const Problem *p)
{
  const Relaxation *r = p->relax;
  const PetscReal done = EffortWork(&r->effort), since = done - EffortWork(&r->newton->effort);
  if (since * (PetscReal)r->newton->n_dof > p->scene->effort || MethodSpent(p)) return PETSC_TRUE;
  return (PetscBool)(r->most_work > 0. && done > r->most_work);
}

/* factor.c: factorises the assembled stiffness for Newton's method, if there is memory for the factor.
   Where memory runs out in spite of the estimate, the explicit loop goes on (newton.c). */
#include "base/memory.h"
#include "solve/newton.h"

static const PetscReal WORST_FACTOR = 1e-4; /* relative error of a solution */
enum { CHOLMOD_NO_MEMORY = -2, CHOLMOD_TOO_LARGE = -3 };

/* ---- memory */

/* [-] Memory of a rank with a share of the factor for a solve every cycle, over that of rank 0, which makes
   it. */
static const double PART_OF_FACTOR = 0.25;

PetscErrorCode NewtonFits(const Model *m, PetscBool every_cycle, double memory[2], PetscBool *fits)
{
  PetscInt64 n[2] = {m->n_dof, 0};
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->condensed.n; b++)
    n[1] += (PetscInt64)m->condensed.body[b].n_kept * m->condensed.body[b].n_kept;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT64, MPI_SUM, m->comm));
  const double all = MemoryOfFactor((double)n[0], (double)n[1], every_cycle ? 1 : m->size),
               mine = !every_cycle ? all / (double)m->size
                      : m->rank    ? PART_OF_FACTOR * all
                                   : all;
  PetscCall(MemoryFits(m->comm, mine, memory, fits));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FactorWants(const Problem *p, const double memory[2])
{
  Effort *effort = &p->relax->effort;
  PetscFunctionBeginUser;
  if (!effort->wanted && !p->m->rank) {
    Warn("stage %s: no memory for the factor of preconditioned relaxation: it takes about "
         "%.3g GB, %.3g GB were available before: the stage goes on by explicit cycles; condensed bodies "
         "take less, more machines or a larger memory_limit give more",
         p->stage->name, 1e-9 * memory[0], 1e-9 * memory[1]);
  }
  effort->wanted = (PetscInt64)memory[0], effort->available = (PetscInt64)memory[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Handles an error of CHOLMOD: memory was short, or the matrix has no factor. context: PetscBool, set where
   memory was short. */
static PetscErrorCode keep_status(MPI_Comm comm, int line, const char *function, const char *file,
                                  PetscErrorCode code, PetscErrorType type, const char *message,
                                  void *context)
{
  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_INITIAL) {
    const char *word = strstr(message, "status ");
    const int status = word ? atoi(word + strlen("status ")) : 0;
    *(PetscBool *)context = (PetscBool)(code == PETSC_ERR_MEM || status == CHOLMOD_NO_MEMORY ||
                                        status == CHOLMOD_TOO_LARGE);
  }
  return code;
}

/* Calls KSPSetUp with CHOLMOD silent, because our own warning explains its error better. A user who asks
   for the messages of CHOLMOD gets them. Our option is removed again: with another preconditioner nothing
   would read it, and PETSc would report it as unread. */
static PetscErrorCode set_up_silently(KSP ksp, PetscBool *wants)
{
  PetscErrorCode (*const print)(const char[], ...) = PetscErrorPrintf;
  PetscBool asked;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-mat_cholmod_print", &asked));
  if (!asked) PetscCall(PetscOptionsSetValue(NULL, "-mat_cholmod_print", "0"));
  PetscCall(PetscPushErrorHandler(keep_status, wants));
  PetscErrorPrintf = PetscErrorPrintfNone;
  const PetscErrorCode code = KSPSetUp(ksp);
  PetscErrorPrintf = print;
  PetscCall(PetscPopErrorHandler());
  if (!asked) PetscCall(PetscOptionsClearValue(NULL, "-mat_cholmod_print"));
  PetscFunctionReturn(code);
}

/* ---- the factor */

enum { LARGE_FACTOR = 20000 }; /* degrees of freedom from which on a line of progress precedes the factor */

/* Shows a line of progress at a solve, when it is time for one. */
static PetscErrorCode show_solve(KSP ksp, PetscInt i, PetscReal residual, void *context)
{
  const Newton *n = context;
  char text[160];
  PetscFunctionBeginUser;
  (void)ksp, (void)residual;
  if (!StageShows(n->problem)) PetscFunctionReturn(PETSC_SUCCESS);
  snprintf(text, sizeof(text), "Newton's method: %s, solve %" PetscInt_FMT ", %" PetscInt64_FMT " so far",
           n->progress, i, n->problem->relax->effort.solves + i);
  StageShow(n->problem, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shows a line of progress before a large factor is made. n_mine: degrees of freedom of this rank. */
static PetscErrorCode show_factor(const Problem *p, const char *package, PetscInt n_mine)
{
  char text[128];
  PetscInt n;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(&n_mine, &n, 1, MPIU_INT, MPI_SUM, p->m->comm));
  if (p->m->rank || n < LARGE_FACTOR) PetscFunctionReturn(PETSC_SUCCESS);
  snprintf(text, sizeof(text), "%sfactor %" PetscInt64_FMT " by %s, %" PetscInt_FMT " degrees of freedom",
           p->relax->newton->elastic ? "Newton's method: " : "", p->relax->effort.factorisations + 1, package,
           n);
  StageShow(p, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Factorise(const Problem *p, PCType type, MatSolverType package, KSP *ksp, PetscBool *fails)
{
  const PetscBool refuses = (PetscBool) !!strcmp(package, MATSOLVERMUMPS); // by an error
  Newton *n = p->relax->newton;
  PC pc;
  PCFailedReason failed;
  PetscFunctionBeginUser;
  if (!*ksp) {
    PetscCall(KSPCreate(p->m->comm, ksp));
    PetscCall(KSPSetType(*ksp, KSPFGMRES));
    PetscCall(KSPGMRESSetRestart(*ksp, NEWTON_MOST_SOLVES));
    PetscCall(KSPMonitorSet(*ksp, show_solve, n, NULL));
  }
  PetscCall(KSPGetPC(*ksp, &pc));
  PetscCall(PCSetType(pc, type));
  PetscCall(PCFactorSetMatSolverType(pc, package));
  PetscCall(KSPSetFromOptions(*ksp)); // options may replace the factor: check_factor tests what they give
  PetscCall(KSPSetReusePreconditioner(*ksp, PETSC_FALSE));
  PetscCall(KSPSetOperators(*ksp, n->stiffness.tangent, n->stiffness.tangent));
  n->wants = PETSC_FALSE;
  PetscCall(show_factor(p, package, p->m->n_dof));
  const PetscErrorCode code = refuses ? set_up_silently(*ksp, &n->wants) : KSPSetUp(*ksp);
  *fails = (PetscBool)(refuses && code);
  if (*fails) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(code);
  PetscCall(KSPSetReusePreconditioner(*ksp, PETSC_TRUE));
  PetscCall(PCGetFailedReason(pc, &failed));
  *fails = (PetscBool)(failed != PC_NOERROR);
  if (*fails && !refuses) {
    Mat factor;
    PetscCall(PCFactorGetMatrix(pc, &factor));
    PetscCall(MumpsWants(factor, &n->wants));
  }
  p->relax->effort.factorisations++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factorises a symmetric tangent: on one rank by CHOLMOD, because its solves take half as long as solves of
   MUMPS; on several ranks by MUMPS, and where rounding has left a negative pivot, at which CHOLMOD fails. */
static PetscErrorCode factorise_symmetric(const Problem *p, KSP *ksp, PetscBool *fails)
{
  const Newton *n = p->relax->newton;
  PetscBool there;
  PetscFunctionBeginUser;
  PetscCall(MatGetFactorAvailable(n->stiffness.tangent, MATSOLVERCHOLMOD, MAT_FACTOR_CHOLESKY, &there));
  if (there) PetscCall(Factorise(p, PCCHOLESKY, MATSOLVERCHOLMOD, ksp, fails));
  if (there && (!*fails || n->wants)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPDestroy(ksp));
  PetscCall(Factorise(p, PCCHOLESKY, MATSOLVERMUMPS, ksp, fails));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the factor by solving K0 x = K0 x_0 for a known x_0. A body that can move freely (nothing holds
   it, or a joint has no k_s) leaves a pivot of rounding size, and its motion in a solution is noise. */
static PetscErrorCode check_factor(const Problem *p)
{
  Newton *n = p->relax->newton;
  PetscReal *x, error, size;
  Vec x_0;
  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(n->du, &x_0));
  PetscCall(VecGetArrayWrite(x_0, &x));
  for (PetscInt d = 0; d < p->m->n_dof; d++) x[d] = PetscSinReal((PetscReal)(n->stiffness.first + d + 1));
  PetscCall(VecRestoreArrayWrite(x_0, &x));
  PetscCall(MatMult(n->stiffness.tangent, x_0, n->r));
  PetscCall(PCApply(n->pc, n->r, n->du));
  PetscCall(VecAXPY(n->du, -1., x_0));
  PetscCall(VecNorm(n->du, NORM_INFINITY, &error));
  PetscCall(VecNorm(x_0, NORM_INFINITY, &size));
  PetscCall(VecDestroy(&x_0));
  n->fails = (PetscBool) !(error <= WORST_FACTOR * size);
  p->relax->effort.solves++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AssembleElastic(const Problem *p)
{
  Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  PetscCall(StiffnessBodies(p->m, p->state, PETSC_FALSE, &n->stiffness));
  PetscCall(StiffnessTangent(p->m, p->state, p->stage->joints, p->contacts, PETSC_TRUE, &n->stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FactorElastic(const Problem *p)
{
  Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  PetscCall(AssembleElastic(p));
  PetscCall(MatSetOption(n->stiffness.tangent, MAT_SPD, PETSC_TRUE));
  PetscCall(factorise_symmetric(p, &n->elastic, &n->fails));
  PetscCall(KSPGetPC(n->elastic, &n->pc));
  if (!n->fails) PetscCall(check_factor(p));
  if (!n->wants) PetscFunctionReturn(PETSC_SUCCESS);
  // the explicit loop needs the memory of both
  PetscCall(KSPDestroy(&n->elastic));
  PetscCall(StiffnessDestroy(&n->stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the factor as check_factor does. It is in single precision, so the solution is improved until it is
   exact enough. */
static PetscErrorCode check_nested(const Problem *p)
{
  enum { SWEEPS = 20 };
  Newton *n = p->relax->newton;
  PetscReal *x, error = PETSC_INFINITY, size;
  Vec rest, r, du; // x_0 less the solution so far
  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(NestedMatrix(n->nested), &rest, &r));
  PetscCall(VecDuplicate(r, &du));
  PetscCall(VecGetArrayWrite(rest, &x));
  for (PetscInt d = 0; d < p->m->n_dof; d++) x[d] = PetscSinReal((PetscReal)(n->nested->place[d] + 1));
  PetscCall(VecRestoreArrayWrite(rest, &x));
  PetscCall(VecNorm(rest, NORM_INFINITY, &size));
  for (int sweep = 0; sweep < SWEEPS && !(error <= WORST_FACTOR * size); sweep++) {
    PetscCall(MatMult(NestedMatrix(n->nested), rest, r));
    PetscCall(PCApply(n->pc, r, du));
    PetscCall(VecAXPY(rest, -1., du));
    PetscCall(VecNorm(rest, NORM_INFINITY, &error));
    p->relax->effort.solves++;
  }
  n->fails = (PetscBool) !(error <= WORST_FACTOR * size);
  PetscCall(VecDestroy(&rest));
  PetscCall(VecDestroy(&r));
  PetscCall(VecDestroy(&du));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FactorNested(const Problem *p)
{
  Newton *n = p->relax->newton;
  PetscFunctionBeginUser;
  PetscCall(StiffnessRows(p->m, &n->stiffness));
  PetscCall(show_factor(p, "nested dissection", p->m->n_dof));
  PetscCall(NestedCreate(p, &n->stiffness, &n->nested, &n->fails, &n->wants));
  n->pc = NestedSolver(n->nested);
  p->relax->effort.factorisations++;
  if (!n->fails) PetscCall(check_nested(p));
  if (n->wants) PetscCall(NestedDestroy(&n->nested)); // explicit cycles need the memory
  PetscFunctionReturn(PETSC_SUCCESS);
}

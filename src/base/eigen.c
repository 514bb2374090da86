/* eigen.c: computes the slowest free vibrations of K and M by SLEPc.

   Lanczos' method with (K + s M)^-1 M and the inner product of M finds the eigenvalues nearest to -s. The
   shift s is far above the rounding of K and far below the lowest frequency of interest. So K + s M is
   regular even where bodies float, and their motions have omega^2 = 0.

   Lanczos' method may miss a mode, mostly where several have one frequency. So the modes are counted: the
   number of negative pivots of K - theta M is the number of modes below theta (Sylvester). If modes are
   missing, the search continues orthogonally to those found.

   The search takes CHOLMOD's factor where one rank works and K + s M is positive definite: its solves take
   half as long as solves of MUMPS, which alone counts pivots.

   A model with few rows is solved on the first rank: on several ranks the many short messages of a solve
   cost more than they save. */
#include "base/eigen.h"
#include "base/memory.h"
#include <slepceps.h>

static const PetscReal SHIFT = 1e-9;      /* relative to the bound of omega^2 */
static const PetscReal ROUNDING = 1e-11;  /* of the bound: smaller values are 0 */
static const PetscReal NO_MASS = 1e3;     /* times the bound: faster modes have no mass */
static const PetscReal TOLERANCE = 1e-11; /* of Lanczos' method */
static const PetscReal EQUAL = 1e-6;      /* components of a shape that differ by less are equal */
enum { ROUNDS = 8 };                      /* searches, each after a count that finds modes missing */
enum { FEW_ROWS = 50000 };                /* solved on one rank */

typedef struct {
  Mat K, M;
  PetscReal bound; /* [1/s2] approximate upper bound of omega^2: row sums of K over masses */
  PetscInt size;   /* rows */
  EPS eps;
  PetscInt n;           /* found so far */
  PetscReal *omega2;    /* (n,) */
  Vec *shape;           /* (n,) */
  PetscInt most, below; /* modes requested; modes below omega_max^2, -1: not counted */
} Search;

/* ---- the matrices */

/* Computes the largest row sum of |K| over the mass of the row; 0: no row has mass. */
static PetscErrorCode find_bound(Search *s)
{
  PetscInt first, end, n;
  const PetscInt *column;
  const PetscScalar *value;
  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(s->K, &first, &end));
  for (PetscInt row = first; row < end; row++) {
    PetscReal sum = 0., mass = 0.;
    PetscCall(MatGetRow(s->K, row, &n, NULL, &value));
    for (PetscInt i = 0; i < n; i++) sum += PetscAbsReal(value[i]);
    PetscCall(MatRestoreRow(s->K, row, &n, NULL, &value));
    PetscCall(MatGetRow(s->M, row, &n, &column, &value));
    for (PetscInt i = 0; i < n; i++)
      if (column[i] == row) mass = value[i];
    PetscCall(MatRestoreRow(s->M, row, &n, &column, &value));
    if (mass > 0.) s->bound = PetscMax(s->bound, sum / mass);
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, &s->bound, 1, MPIU_REAL, MPI_MAX, PetscObjectComm((PetscObject)s->K)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the modes with omega^2 < theta; -1: MUMPS gave no factor. */
static PetscErrorCode count_below(const Search *s, PetscReal theta, PetscInt *below, PetscBool *wants)
{
  MatFactorInfo info;
  MatFactorError error;
  Mat A, F;
  PetscFunctionBeginUser;
  PetscCall(MatDuplicate(s->K, MAT_COPY_VALUES, &A));
  PetscCall(MatAXPY(A, -theta, s->M, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(A, MAT_SPD, PETSC_FALSE));
  PetscCall(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &F));
  PetscCall(MatFactorInfoInitialize(&info));
  PetscCall(MatMumpsSetIcntl(F, 13, 1)); // else pivots of the last front are not counted on several ranks
  PetscCall(MatCholeskyFactorSymbolic(F, A, NULL, &info));
  PetscCall(MatCholeskyFactorNumeric(F, A, &info));
  PetscCall(MatFactorGetError(F, &error));
  PetscCall(MumpsWants(F, wants));
  *below = -1;
  if (error == MAT_FACTOR_NOERROR) PetscCall(MatGetInertia(F, below, NULL, NULL));
  PetscCall(MatDestroy(&F));
  PetscCall(MatDestroy(&A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the search */

/* Chooses the package that factors K + s M. */
static PetscErrorCode choose_factor(const Search *s, MatSolverType *package, PetscBool *wants)
{
  PetscInt below = 1;
  PetscBool there = PETSC_FALSE;
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)s->K), &size));
  if (size == 1) PetscCall(MatGetFactorAvailable(s->K, MATSOLVERCHOLMOD, MAT_FACTOR_CHOLESKY, &there));
  if (there) PetscCall(count_below(s, -SHIFT * s->bound, &below, wants));
  *package = there && below == 0 ? MATSOLVERCHOLMOD : MATSOLVERMUMPS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factors K + s M. */
static PetscErrorCode prepare(Search *s, Modes *modes)
{
  MatSolverType package = MATSOLVERMUMPS;
  ST st;
  KSP ksp;
  PC pc;
  Mat factor;
  PCFailedReason failed;
  PetscFunctionBeginUser;
  PetscCall(choose_factor(s, &package, &modes->wants));
  if (modes->wants) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EPSCreate(PetscObjectComm((PetscObject)s->K), &s->eps));
  PetscCall(EPSSetOperators(s->eps, s->K, s->M));
  PetscCall(EPSSetProblemType(s->eps, EPS_GHEP));
  PetscCall(EPSSetWhichEigenpairs(s->eps, EPS_TARGET_MAGNITUDE));
  PetscCall(EPSSetTarget(s->eps, -SHIFT * s->bound));
  PetscCall(EPSSetTolerances(s->eps, TOLERANCE, PETSC_DEFAULT));
  PetscCall(EPSSetFromOptions(s->eps)); // the factor stays ours
  PetscCall(EPSGetST(s->eps, &st));
  PetscCall(STSetType(st, STSINVERT));
  PetscCall(STGetKSP(st, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(pc, package));
  PetscCall(EPSSetDimensions(s->eps, PetscMin(s->most + 1, s->size), PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(EPSSetUp(s->eps));
  PetscCall(PCGetFailedReason(pc, &failed));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  if (failed != PC_NOERROR && !strcmp(package, MATSOLVERMUMPS)) PetscCall(MumpsWants(factor, &modes->wants));
  PetscCheck(failed == PC_NOERROR || modes->wants, PetscObjectComm((PetscObject)s->K), PETSC_ERR_LIB,
             "MUMPS cannot factor the stiffness for the modes");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Normalises a shape to modal mass 1 and to its sign. Computes its omega^2, whose error is of second order in
   the error of the shape. */
static PetscErrorCode normalise(const Search *s, Vec shape, Vec work, PetscReal *omega2)
{
  PetscReal largest;
  PetscScalar mass, stiffness;
  PetscInt first, end, which = PETSC_MAX_INT;
  const PetscScalar *x;
  PetscFunctionBeginUser;
  PetscCall(MatMult(s->M, shape, work));
  PetscCall(VecDot(shape, work, &mass));
  PetscCall(MatMult(s->K, shape, work));
  PetscCall(VecDot(shape, work, &stiffness));
  *omega2 = stiffness / mass;
  PetscCall(VecNorm(shape, NORM_INFINITY, &largest));
  PetscCall(VecGetOwnershipRange(shape, &first, &end));
  PetscCall(VecGetArrayRead(shape, &x));
  for (PetscInt row = first; row < end && which == PETSC_MAX_INT; row++)
    if (PetscAbsReal(x[row - first]) >= (1. - EQUAL) * largest) which = 2 * row + (x[row - first] < 0.);
  PetscCall(VecRestoreArrayRead(shape, &x));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, &which, 1, MPIU_INT, MPI_MIN, PetscObjectComm((PetscObject)shape)));
  PetscCall(VecScale(shape, (which % 2 ? -1. : 1.) / PetscSqrtReal(mass)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Searches for n more modes beside those found, and keeps all that converge, in ascending order. */
static PetscErrorCode search(Search *s, PetscInt n, PetscInt *gained)
{
  PetscInt found;
  Vec work;
  PetscFunctionBeginUser;
  PetscCall(EPSSetDimensions(s->eps, PetscMin(n, s->size), PETSC_DEFAULT, PETSC_DEFAULT));
  if (s->n) PetscCall(EPSSetDeflationSpace(s->eps, s->n, s->shape));
  PetscCall(EPSSolve(s->eps));
  PetscCall(EPSGetConverged(s->eps, &found));
  PetscCall(PetscRealloc((s->n + found) * sizeof(PetscReal), &s->omega2));
  PetscCall(PetscRealloc((s->n + found) * sizeof(Vec), &s->shape)); // NOLINT(bugprone-sizeof-expression)
  PetscCall(MatCreateVecs(s->K, &work, NULL));
  *gained = 0;
  for (PetscInt i = 0; i < found; i++) {
    PetscScalar omega2;
    Vec shape;
    PetscCall(EPSGetEigenvalue(s->eps, i, &omega2, NULL));
    if (!(PetscAbsReal(omega2) < NO_MASS * s->bound)) continue;
    PetscCall(VecDuplicate(work, &shape));
    PetscCall(EPSGetEigenvector(s->eps, i, shape, NULL));
    PetscCall(normalise(s, shape, work, &omega2));
    PetscInt to = s->n++;
    for (; to > 0 && s->omega2[to - 1] > omega2; to--)
      s->omega2[to] = s->omega2[to - 1], s->shape[to] = s->shape[to - 1];
    s->omega2[to] = omega2, s->shape[to] = shape;
    (*gained)++;
  }
  PetscCall(VecDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns theta for the count: in the widest gap behind the last requested mode, or above all modes if
   fewer were found. */
static PetscReal place_of_count(const Search *s)
{
  const PetscReal shift = SHIFT * s->bound;
  PetscReal widest = 0., theta = 0.;
  if (s->n < s->most) return NO_MASS * s->bound;
  for (PetscInt i = s->most; i < s->n; i++) {
    const PetscReal gap = (s->omega2[i] - s->omega2[i - 1]) / (PetscAbsReal(s->omega2[i]) + shift);
    if (gap > widest) widest = gap, theta = 0.5 * (s->omega2[i] + s->omega2[i - 1]);
  }
  const PetscReal last = s->omega2[s->n - 1];
  return widest > EQUAL ? theta : last + 1e-3 * (PetscAbsReal(last) + shift);
}

/* Searches until the count below theta is reached or no more modes come. */
static PetscErrorCode search_all(Search *s, PetscReal omega_max, Modes *modes)
{
  PetscInt gained, below = s->below;
  PetscReal theta = omega_max * omega_max;
  PetscFunctionBeginUser;
  PetscCall(search(s, s->most + 1, &gained));
  if (below != s->most) {
    theta = place_of_count(s);
    PetscCall(count_below(s, theta, &below, &modes->wants));
  }
  modes->missed = -1;
  for (int round = 0; below >= 0; round++) {
    modes->missed = below;
    for (PetscInt i = 0; i < s->n; i++) modes->missed -= s->omega2[i] < theta;
    if (modes->missed <= 0 || round == ROUNDS) break;
    PetscCall(search(s, modes->missed, &gained));
    if (!gained) break;
  }
  if (below >= 0) modes->missed = PetscMax(modes->missed, 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the answer */

/* Copies the slowest modes found to the answer. */
static PetscErrorCode answer(const Search *s, Modes *modes)
{
  PetscFunctionBeginUser;
  modes->n = PetscMin(s->n, s->most);
  modes->rounding = ROUNDING * s->bound;
  PetscCall(PetscMalloc2(modes->n, &modes->omega2, modes->n * modes->rows, &modes->shapes));
  for (PetscInt i = 0; i < modes->n; i++) {
    const PetscScalar *x;
    modes->omega2[i] = s->omega2[i];
    PetscCall(VecGetArrayRead(s->shape[i], &x));
    PetscCall(PetscArraycpy(modes->shapes + i * modes->rows, x, modes->rows));
    PetscCall(VecRestoreArrayRead(s->shape[i], &x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode search_destroy(Search *s)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < s->n; i++) PetscCall(VecDestroy(s->shape + i));
  PetscCall(PetscFree(s->shape));
  PetscCall(PetscFree(s->omega2));
  PetscCall(EPSDestroy(&s->eps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the modes on all ranks of K. */
static PetscErrorCode find(Mat K, Mat M, PetscReal omega_max, PetscInt most, Modes *modes)
{
  Search s = {.K = K, .M = M, .most = most, .below = -1};
  PetscFunctionBeginUser;
  PetscCall(SlepcInitialize(NULL, NULL, NULL, NULL)); // does nothing after the first time
  PetscCall(MatGetLocalSize(K, &modes->rows, NULL));
  PetscCall(MatGetSize(K, &s.size, NULL));
  PetscCall(MatSetOption(K, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(M, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(find_bound(&s));
  if (omega_max > 0. && s.bound > 0.)
    PetscCall(count_below(&s, omega_max * omega_max, &s.below, &modes->wants));
  modes->missed = omega_max > 0. && s.below < 0 ? -1 : 0;
  if (s.below >= 0) s.most = most ? PetscMin(most, s.below) : s.below;
  if (s.bound > 0. && s.most > 0 && !modes->wants) {
    PetscCall(prepare(&s, modes));
    if (!modes->wants) PetscCall(search_all(&s, omega_max, modes));
    if (!modes->wants) PetscCall(answer(&s, modes));
  }
  PetscCall(search_destroy(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- on the first rank */

/* Scatters the shapes found on the first rank to their owners. all: (n, rows of K). */
static PetscErrorCode deal_out(Mat K, const PetscReal *all, Modes *modes)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscInt *start;
  PetscMPIInt size, *first, *count;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(MatGetOwnershipRanges(K, &start));
  PetscCall(PetscMalloc2(size, &first, size, &count));
  for (PetscMPIInt r = 0; r < size; r++)
    first[r] = (PetscMPIInt)start[r], count[r] = (PetscMPIInt)(start[r + 1] - start[r]);
  for (PetscInt i = 0; i < modes->n; i++)
    PetscCallMPI(MPI_Scatterv(all ? all + i * start[size] : NULL, count, first, MPIU_REAL,
                              modes->shapes + i * modes->rows, (PetscMPIInt)modes->rows, MPIU_REAL, 0, comm));
  PetscCall(PetscFree2(first, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode find_on_first(Mat K, Mat M, PetscReal omega_max, PetscInt most, Modes *modes)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)K);
  PetscInt n;
  PetscMPIInt rank;
  IS all;
  Mat *K_all, *M_all;
  Modes of_all = {.n = 0};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatGetSize(K, &n, NULL));
  PetscCall(ISCreateStride(PETSC_COMM_SELF, rank ? 0 : n, 0, 1, &all));
  PetscCall(MatCreateSubMatrices(K, 1, &all, &all, MAT_INITIAL_MATRIX, &K_all));
  PetscCall(MatCreateSubMatrices(M, 1, &all, &all, MAT_INITIAL_MATRIX, &M_all));
  if (!rank) PetscCall(find(K_all[0], M_all[0], omega_max, most, &of_all));
  PetscCall(MatDestroySubMatrices(1, &K_all));
  PetscCall(MatDestroySubMatrices(1, &M_all));
  PetscCall(ISDestroy(&all));
  PetscInt counts[3] = {of_all.n, of_all.missed, of_all.wants};
  PetscCallMPI(MPI_Bcast(counts, 3, MPIU_INT, 0, comm));
  modes->n = counts[0], modes->missed = counts[1], modes->wants = (PetscBool)counts[2];
  PetscCall(MatGetLocalSize(K, &modes->rows, NULL));
  PetscCall(PetscMalloc2(modes->n, &modes->omega2, modes->n * modes->rows, &modes->shapes));
  if (!rank) PetscCall(PetscArraycpy(modes->omega2, of_all.omega2, modes->n));
  modes->rounding = of_all.rounding;
  PetscCallMPI(MPI_Bcast(&modes->rounding, 1, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(modes->omega2, (PetscMPIInt)modes->n, MPIU_REAL, 0, comm));
  PetscCall(deal_out(K, of_all.shapes, modes));
  PetscCall(ModesDestroy(&of_all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LowestModes(Mat K, Mat M, PetscReal omega_max, PetscInt most, Modes *modes)
{
  PetscInt n;
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCheck(omega_max > 0. || most > 0, PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_OUTOFRANGE,
             "no limit to the modes");
  PetscCall(PetscMemzero(modes, sizeof(*modes)));
  PetscCall(MatGetSize(K, &n, NULL));
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)K), &size));
  if (size > 1 && n < FEW_ROWS)
    PetscCall(find_on_first(K, M, omega_max, most, modes));
  else
    PetscCall(find(K, M, omega_max, most, modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModesDestroy(Modes *modes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(modes->omega2, modes->shapes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

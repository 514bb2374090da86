/* Friction counted from the last equilibrium is a force field with a curl (deviations.md, ab). By the law
   alone motion grows as the eigenvalues of that field say. With the springs that follow the law it does not
   grow. */
#include "scene_fixture.h"
#include <complex.h>
#include <petscksp.h>

static Sketch sketch;

enum { FREE = 4 };

/* The smallest scene that grows: one leaning block, its upper face held and moved down and sideways, so that
   the lower one slides on the ground: four degrees of freedom. friction [degree]; no damping. */
static PetscErrorCode OpenSlider(double friction, Fixture *f)
{
  static const double corner[8] = {0, 0, 1, 0, 0.2, 1, -0.8, 1};
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", 0);
  SketchBox(&sketch, ground, -4, -1, 8, 1);
  SketchFace(&sketch, "top", SketchGrid(&sketch, block, corner, 1, 1, QUADS), 2);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "strain: small\n"
                  "materials: {ground: {density: 0}, block: {density: 0, young: 1e9, poisson: 0.2}}\n"
                  "relaxation: {damping: none}\n"
                  "joints: {default: {k_n: 1e9, k_s: 1e9, friction: %g}}\n"
                  "supports: {ground: {fix: xy}, top: {fix: xy}}\nloads: {weight: {type: self_weight}}\n"
                  "stages: [all: {loads: [weight], ramp: 0}]\n",
                  friction));
  PetscCall(StageStart(f, 0));
  for (int v = 6; v < 8; v++)
    f->u_vertex[2 * LocalOfFile(f->model, v)] = 0.02, f->u_vertex[2 * LocalOfFile(f->model, v) + 1] = -0.002;
  ContactsCommit(f->contacts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Place in the dof arrays of the free dof i: vertices 4 and 5 are the lower ones. */
static PetscInt FreeDof(const Fixture *f, int i)
{
  return 3 * f->model->rigid.n + 2 * LocalOfFile(f->model, 4 + i / 2) + i % 2;
}

/* Resisting forces by the law at u, and, by differences, K (by columns). */
static PetscErrorCode Linearise(Fixture *f, double force[FREE], double K[FREE * FREE])
{
  const double h = 1e-9;
  PetscFunctionBeginUser;
  f->contacts->friction = FRICTION_LAW;
  for (int j = 0; j <= FREE; j++) {
    if (j < FREE) f->state->u[FreeDof(f, j)] += h;
    PetscCall(Forces(f->scene, f->model, f->scene->stages->joints, f->contacts, f->state, NULL));
    for (int i = 0; i < FREE; i++) *(j < FREE ? K + j * FREE + i : force + i) = f->state->f[FreeDof(f, i)];
    if (j < FREE) f->state->u[FreeDof(f, j)] -= h;
  }
  for (int i = 0; i < FREE * FREE; i++) K[i] = (K[i] - force[i % FREE]) / h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K (by columns), each row times `scale`, without preconditioner or with a factor. */
static PetscErrorCode SolverOf(const double K[FREE * FREE], const double scale[FREE], PCType pc, KSP *ksp)
{
  Mat A;
  PetscFunctionBeginUser;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, FREE, FREE, NULL, &A));
  for (PetscInt i = 0; i < FREE * FREE; i++)
    PetscCall(MatSetValue(A, i % FREE, i / FREE, scale[i % FREE] * K[i], INSERT_VALUES));
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscCall(KSPCreate(PETSC_COMM_SELF, ksp));
  PetscCall(KSPSetOperators(*ksp, A, A));
  PC own;
  PetscCall(KSPGetPC(*ksp, &own));
  PetscCall(PCSetType(own, pc));
  PetscCall(KSPSetType(*ksp, KSPPREONLY));
  PetscCall(KSPSetUp(*ksp));
  PetscCall(MatDestroy(&A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method to where nothing pulls. K: there. */
static PetscErrorCode ToRest(Fixture *f, double K[FREE * FREE])
{
  static const double ones[FREE] = {1., 1., 1., 1.};
  PetscFunctionBeginUser;
  for (int sweep = 0; sweep < 8; sweep++) {
    double force[FREE];
    KSP ksp;
    Vec du;
    PetscCall(Linearise(f, force, K));
    PetscCall(SolverOf(K, ones, PCLU, &ksp));
    PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, FREE, force, &du));
    PetscCall(KSPSolve(ksp, du, du));
    for (int i = 0; i < FREE; i++) f->state->u[FreeDof(f, i)] -= force[i];
    PetscCall(VecDestroy(&du));
    PetscCall(KSPDestroy(&ksp));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of K x = lambda m x the eigenvalue with the largest imaginary part, and by how much the central difference
   makes its motion grow in a cycle: |z|, z - 2 + 1/z = -lambda dt^2. */
static PetscErrorCode Growth(const Fixture *f, const double K[FREE * FREE], double lambda[2], double *grows)
{
  double per_mass[FREE], re[FREE], im[FREE];
  KSP ksp;
  PetscFunctionBeginUser;
  for (int i = 0; i < FREE; i++) per_mass[i] = f->state->m_inv[FreeDof(f, i)];
  PetscCall(SolverOf(K, per_mass, PCNONE, &ksp));
  PetscCall(KSPComputeEigenvaluesExplicitly(ksp, FREE, re, im));
  PetscCall(KSPDestroy(&ksp));
  lambda[0] = re[0], lambda[1] = 0., *grows = 1.;
  for (int i = 0; i < FREE; i++) {
    const double complex half = 1. -
                                0.5 * (re[i] + I * im[i]) * f->state->dt * f->state->dt, // z + 1/z over 2
        root = csqrt(half * half - 1.);
    *grows = PetscMax(*grows, PetscMax(cabs(half + root), cabs(half - root)));
    if (im[i] > lambda[1]) lambda[0] = re[i], lambda[1] = im[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Growth a cycle from a push of 1e-12 m at rest, between `first` cycles and half as many more. pull: 0 the
   law itself. speed: [m/s] root of the sum of squares at the end. */
static PetscErrorCode Measure(Fixture *f, double pull, int first, double *grows, double *speed)
{
  enum { SWINGS = 30 }; // what moves swings: a mean over some periods
  double size[2] = {0., 0.}, K[FREE * FREE];
  PetscFunctionBeginUser;
  PetscCall(ToRest(f, K));
  PetscCall(PetscArrayzero(f->state->v, f->model->n_dof));
  f->contacts->friction = pull > 0. ? FRICTION_PULLED : FRICTION_LAW, f->contacts->pull = pull;
  f->state->u[FreeDof(f, 0)] += 1e-12;
  for (int part = 0; part < 2; part++) {
    PetscCall(StageCycles(f, 0, part ? first / 2 : first));
    for (int cycle = 0; cycle < SWINGS; cycle++) {
      PetscCall(StageCycles(f, 0, 1));
      for (int i = 0; i < FREE; i++) size[part] += PetscSqr(f->state->v[FreeDof(f, i)]);
    }
  }
  *grows = pow(size[1] / size[0], 0.5 / (first / 2 + SWINGS));
  *speed = sqrt(size[1] / SWINGS);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By friction and beta: growth by the law as its eigenvalues say, none with springs (deviations.md, ab). */
static PetscErrorCode FrictionByTheLawGrowsAsItsEigenvaluesSay(void)
{
  PetscFunctionBeginUser;
  for (int friction = 0; friction <= 75; friction += 15)
    for (int damped = 0; damped < 2; damped++) {
      Fixture f;
      double K[FREE * FREE], lambda[2] = {0., 0.}, expected = 1., law = 0., springs = 0., speed = 0.;
      PetscCall(OpenSlider(friction, &f));
      PetscCall(ToRest(&f, K));
      PetscCall(Growth(&f, K, lambda, &expected));
      const int first = expected > 1.002 ? (int)(8. / log(expected)) : 500;
      if (damped) { // as a stage begins
        f.state->beta = f.scene->beta;
        PetscCall(ScaledMasses(f.scene, f.model, f.scene->stages->joints, f.contacts, f.state));
        PetscCall(Measure(&f, PULL_CLOSE, 4000, &springs, &speed));
        ENSURE(speed < 1e-13);
      } else {
        PetscCall(Measure(&f, 0.05, first, &springs, &speed));
        PetscCall(Measure(&f, 0., first, &law, &speed));
        ENSURE((lambda[1] > 0.) == (friction >= 45));
        if (lambda[1] > 0.) ENSURE_NEAR(law, expected, 1e-3);
        ENSURE(lambda[1] > 0. || law < 1.001);
        ENSURE(log(springs) < 0.05 * log(expected) + 1e-3);
      }
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(FrictionByTheLawGrowsAsItsEigenvaluesSay);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Relaxation: cycles on a chain near the optimum (V11), no false slip with a ramp (V10), the quotient is that
   of the resisting forces only; friction by the law alone grows as its eigenvalues say, springs do not. */
#include "scene_fixture.h"
#include <complex.h>
#include <petscksp.h>

static Sketch sketch;

/* V11: n rigid blocks on top of each other, each pair a spring of 1 N/m, load 1/n on each; they move in y
   only. own_masses: those of V11 instead of Quoin's. */
static PetscErrorCode OpenChain(int n, double safety, int ramp, PetscBool own_masses, Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", 1);
  SketchBox(&sketch, ground, 0, -1, 1, 1);
  for (int i = 0; i < n; i++) SketchBox(&sketch, block, 0, i, 1, 1);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "gravity: 1\nmaterials: {ground: {density: 0}, block: {density: %.17g}}\n"
                        "relaxation: {safety: %g}\n"
                        "joints: {default: {law: elastic, k_n: 1, k_s: 1}}\n"
                        "supports: {ground: {fix: xy}, block: {fix: x}}\n"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight], ramp: %d}]\n",
                        1. / n, safety, ramp));
  PetscCall(StageStart(f, 0));
  for (int i = 0; own_masses && i < n; i++) { // dt^2/4 sum |K| / safety^2
    const PetscInt y = DofOf(f->model, 4 * (i + 1)) + 1;
    f->state->m[y] = 0.25 * (i < n - 1 ? 4 : 2) / (safety * safety);
    f->state->m_inv[y] = 1 / f->state->m[y];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cycles until |r| < 1e-6 |f|; the largest displacement of the top over its static one. */
static PetscErrorCode ChainCycles(Fixture *f, int n, int *cycles, double *overshoot)
{
  const PetscInt top = DofOf(f->model, 4 * n) + 1;
  const double u_static = -0.5 * (n + 1);

  PetscFunctionBeginUser;
  *overshoot = 0;
  for (*cycles = 0; *cycles < 20000;) {
    PetscReal r = 0, load = 0;
    PetscCall(StageCycles(f, 0, 1));
    for (PetscInt d = 0; d < f->model->n_dof; d++) {
      const PetscReal rest = f->state->f_ext[d] - f->state->f[d];
      if (Held(f->model, d)) continue;
      r += rest * rest, load += f->state->f_ext[d] * f->state->f_ext[d];
    }
    if (r < 1e-12 * load) break; // the state before this cycle was it
    (*cycles)++;
    *overshoot = PetscMax(*overshoot, f->state->u[top] / u_static);
  }
  ENSURE_NEAR(f->state->u[top] / u_static, 1, 1e-4);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ChainNeedsTheCyclesOfTheOptimum(void)
{
  static const struct {
    int n, cycles;
    double safety;
  } table[] = {{20, 240, 0.9}, {100, 1192, 0.9}, {20, 430, 0.5}, {100, 2144, 0.5}};

  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++)
    for (int own = 0; own < 2; own++) {
      Fixture f;
      int cycles;
      double overshoot;
      PetscCall(OpenChain(table[i].n, table[i].safety, 0, (PetscBool)own, &f));
      PetscCall(ChainCycles(&f, table[i].n, &cycles, &overshoot));
      ENSURE_NEAR((double)cycles / table[i].cycles, 1, own ? 0.01 : 0.02);
      ENSURE(overshoot < 1.0001);
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The optimum is twice the lowest frequency: alpha settles there, ramp or not. During the ramp forces grow
   all the time; if the load entered the quotient, alpha would go to 0. */
static PetscErrorCode RampDoesNotEnterTheQuotient(void)
{
  const int n = 20;
  // lowest mode of a chain fixed below with masses of 1/safety^2, half as much at the top
  const double omega = 2 * 0.9 * sin(PETSC_PI / (4. * n));

  PetscFunctionBeginUser;
  for (int ramp = 0; ramp <= 1000; ramp += 500) {
    Fixture f;
    double low = 1e9, high = 0;
    PetscCall(OpenChain(n, 0.9, ramp, PETSC_TRUE, &f));
    PetscCall(StageCycles(&f, 0, 100));
    for (int i = 0; i < 200; i++) {
      PetscCall(StageCycles(&f, 0, 1));
      low = PetscMin(low, f.state->alpha / (2 * omega)), high = PetscMax(high, f.state->alpha / (2 * omega));
    }
    ENSURE(low > 0.9 && high < 1.5);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V10: a block on a joint with k = 3 N/m, of strength T_max = 2 N, under 0.6 or 0.9
   T_max; it moves in x only. */
static PetscErrorCode FalseSlip(double load, const char *damping, int ramp, PetscBool own_mass, double *slip)
{
  Fixture f;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", 1);
  SketchBox(&sketch, ground, -1, -1, 4, 1);
  const int b = SketchBox(&sketch, block, 0, 0, 2, 1);
  SketchFace(&sketch, "top", b, 2);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                  "materials: {ground: {density: 1}, block: {density: 1}}\n"
                  "relaxation: {%s}\n"
                  "joints: {default: {k_n: 1.5, k_s: 1.5, friction: 0, cohesion: 1, cohesion_residual: 1}}\n"
                  "supports: {ground: {fix: xy}, block: {fix: y}}\n"
                  "loads: {push: {type: traction, faces: top, value: [%g, 0]}}\n"
                  "stages: [all: {loads: [push]}]\n",
                  damping, load));
  const PetscInt x = DofOf(f.model, 4);
  if (ramp >= 0) f.scene->stages[0].ramp = ramp;
  PetscCall(StageStart(&f, 0));
  if (own_mass) f.state->m[x] = 3 / 0.04, f.state->m_inv[x] = 0.04 / 3; // omega dt = 0.2
  PetscCall(StageCycles(&f, 0, 4000));
  ENSURE_NEAR(f.state->f[x], 2 * load, 1e-6);
  *slip = fabs(f.contacts->slip[SUB(0, 0)]) / (2. / 3); // in units of T_max / k
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DefaultProcedureMakesNoFalseSlip(void)
{
  double slip;

  PetscFunctionBeginUser;
  PetscCall(FalseSlip(0.9, "safety: 0.9", -1, PETSC_FALSE, &slip));
  ENSURE_NEAR(slip, 0, 1e-3);
  // under-damped, a ramp of 200 cycles is enough
  PetscCall(FalseSlip(0.9, "damping: fixed, alpha_dt: 0.04", 200, PETSC_TRUE, &slip));
  ENSURE_NEAR(slip, 0, 1e-3);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Why there is a ramp: loads in one step, damping 0.1 or 0.2 of critical. */
static PetscErrorCode LoadInOneStepMakesFalseSlip(void)
{
  static const struct {
    double load, alpha_dt, slip, bound;
  } table[] = {
      {0.6, 0.04, 0.0404, 0.01}, {0.9, 0.04, 1.424, 0.05}, {0.9, 0.08, 0.703, 0.05}, {0.9, 0.4, 0, 1e-3}};

  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    char damping[64];
    double slip;
    snprintf(damping, sizeof damping, "damping: fixed, alpha_dt: %g", table[i].alpha_dt);
    PetscCall(FalseSlip(table[i].load, damping, 0, PETSC_TRUE, &slip));
    ENSURE_NEAR(slip, table[i].slip, table[i].bound);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DampingOf(Fixture *f, const QuotientSums *sums)
{
  PetscFunctionBeginUser;
  DampingBegin(f->scene, f->model, &f->relax->damping, sums);
  PetscCall(DampingEnd(f->scene, f->model, f->state, &f->relax->damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* alpha dt never exceeds 1.9, and a quotient that is not positive leaves the last one. */
static PetscErrorCode DampingIsCappedAndKeepsTheLastPositiveQuotient(void)
{
  Fixture f;
  QuotientSums sums = {{100, 0}, {1, 0}, 100, 1};

  PetscFunctionBeginUser;
  PetscCall(OpenChain(2, 0.9, 0, PETSC_FALSE, &f));
  for (int i = 0; i < 2; i++) PetscCall(DampingOf(&f, &sums)); // the first sets the bins
  ENSURE_NEAR(f.state->alpha, 1.9, 1e-15);
  sums.num[0] = 0.01;
  PetscCall(DampingOf(&f, &sums));
  ENSURE_NEAR(f.state->alpha, 0.2, 1e-15);
  sums.num[0] = -5;
  PetscCall(DampingOf(&f, &sums));
  ENSURE_NEAR(f.state->alpha, 0.2, 1e-15);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- friction counted from the last equilibrium is a force field with a curl (theory.md, ab) */

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
    f->u_vertex[2 * VertexOf(f->model, v)] = 0.02, f->u_vertex[2 * VertexOf(f->model, v) + 1] = -0.002;
  ContactsHold(f->contacts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Place in the dof arrays of the free dof i: vertices 4 and 5 are the lower ones. */
static PetscInt FreeDof(const Fixture *f, int i)
{
  return 3 * f->model->n_bodies + 2 * VertexOf(f->model, 4 + i / 2) + i % 2;
}

/* Resisting forces by the law at u, and, by differences, K (by columns). */
static PetscErrorCode Linearise(Fixture *f, double force[FREE], double K[FREE * FREE])
{
  const double h = 1e-9;
  PetscFunctionBeginUser;
  f->contacts->pull = 0.;
  for (int j = 0; j <= FREE; j++) {
    if (j < FREE) f->state->u[FreeDof(f, j)] += h;
    PetscCall(Forces(f->model, f->scene->stages->joints, f->contacts, f->state, NULL));
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
  f->contacts->pull = pull;
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

/* The table of theory.md, ab. */
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
        PetscCall(Measure(&f, FOLLOW_CLOSELY, 4000, &springs, &speed));
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
  RUN_TEST(ChainNeedsTheCyclesOfTheOptimum);
  RUN_TEST(RampDoesNotEnterTheQuotient);
  RUN_TEST(DefaultProcedureMakesNoFalseSlip);
  RUN_TEST(LoadInOneStepMakesFalseSlip);
  RUN_TEST(DampingIsCappedAndKeepsTheLastPositiveQuotient);
  RUN_TEST(FrictionByTheLawGrowsAsItsEigenvaluesSay);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

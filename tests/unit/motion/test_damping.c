/* Adaptive damping. A chain takes nearly the optimal number of cycles (V11), a ramp prevents false slip
   (V10), the quotient is that of the resisting forces only, and alpha has a cap. */
#include "scene_fixture.h"

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

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(ChainNeedsTheCyclesOfTheOptimum);
  RUN_TEST(RampDoesNotEnterTheQuotient);
  RUN_TEST(DefaultProcedureMakesNoFalseSlip);
  RUN_TEST(LoadInOneStepMakesFalseSlip);
  RUN_TEST(DampingIsCappedAndKeepsTheLastPositiveQuotient);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

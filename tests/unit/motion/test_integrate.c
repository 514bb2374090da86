/* The central difference: period, amplitude, damping and limit of one degree of freedom (V08), the energy of
   many (V25), and a turning block in free flight (V26). */
#include "scene_fixture.h"

static Sketch sketch;

/* A rigid block that only moves in y, on a joint of stiffness k = k_n L on a held block;
   dt = 1, omega dt = 2 r. */
static PetscErrorCode OpenOneDof(double r, Fixture *f)
{
  static const double k = 3e6;

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", 1);
  SketchBox(&sketch, ground, -1, -1, 4, 1);
  SketchBox(&sketch, block, 0, 0, 2, 1);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "materials: {ground: {density: 1}, block: {density: 1}}\n"
                        "relaxation: {damping: none}\n"
                        "joints: {default: {law: elastic, k_n: %g, k_s: 1}}\n"
                        "supports: {ground: {fix: xy}, block: {fix: x}}\n"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n",
                        k / 2));
  for (PetscInt d = 0; d < f->model->n_dof; d++) {
    f->state->m[d] = k / (4 * r * r);
    f->state->m_inv[d] = Held(f->model, d) ? 0 : 1 / f->state->m[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OneStep(Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(Step(f->scene, f->model, f->scene->joints, f->contacts, f->state, &f->relax->damping, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V08: T_num / T = r / asin(r), by counting; amplitude to 1e-10 over 1e4 steps, by the
   exact discrete solution. */
static PetscErrorCode PeriodAndAmplitudeOfOneDof(void)
{
  static const double table[10][2] = {{0.1, 0.99833}, {0.2, 0.99326}, {0.3, 0}, {0.4, 0},
                                      {0.5, 0.95493}, {0.6, 0},       {0.7, 0}, {0.8, 0.86272},
                                      {0.9, 0.80374}, {0.99, 0}};
  const double u1 = 1e-3;

  PetscFunctionBeginUser;
  for (int i = 0; i < 10; i++) {
    const double r = table[i][0], phase = 2 * asin(r);
    double before = 0, first = 0, last = 0, worst = 0;
    int crossings = 0;
    Fixture f;
    PetscCall(OpenOneDof(r, &f));
    const PetscInt y = DofOf(f.model, 4) + 1;
    f.state->v[y] = u1; // u_0 = 0, and the first step has no force
    for (int n = 1; n <= 10000; n++) {
      PetscCall(OneStep(&f));
      const double u = f.state->u[y];
      worst = PetscMax(worst, fabs(u - u1 * sin(n * phase) / sin(phase)) * sin(phase) / u1);
      if (before < 0 && u >= 0) last = n - u / (u - before), first = crossings++ ? first : last;
      before = u;
    }
    ENSURE(worst < 1e-10);
    const double period = (last - first) / (crossings - 1) * (2 * r) / (2 * PETSC_PI); // over the exact one
    ENSURE_NEAR(period, r / asin(r), 2e-4);
    if (table[i][1] > 0) ENSURE_NEAR(r / asin(r), table[i][1], 5e-6);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* omega dt = 2 is the limit, with and without alpha; with beta it is (1 + 2 beta) (omega dt)^2 = 4. */
static PetscErrorCode AboveTheLimitOneDofDiverges(void)
{
  static const double alpha[3] = {0, 0.1, 0}, beta[3] = {0, 0, 0.5};
  PetscFunctionBeginUser;
  for (int damped = 0; damped < 3; damped++)
    for (int above = 0; above < 2; above++) {
      Fixture f;
      PetscCall(OpenOneDof((above ? 1.01 : 0.99) / sqrt(1 + 2 * beta[damped]), &f));
      const PetscInt y = DofOf(f.model, 4) + 1;
      f.state->v[y] = 1e-10;
      f.state->alpha = alpha[damped], f.state->beta = beta[damped];
      for (int n = 0; n < 400; n++) PetscCall(OneStep(&f));
      ENSURE(above ? fabs(f.state->u[y]) > 1 : fabs(f.state->u[y]) < 1e-8);
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* alpha = 2 z omega: log decrement 2 pi z / sqrt(1 - z^2), within O((omega dt)^2). */
static PetscErrorCode DampingGivesTheLogDecrement(void)
{
  PetscFunctionBeginUser;
  for (double z = 0.02; z < 0.5; z *= 2) {
    const double r = 0.01;
    double peak[4] = {0}, before[2] = {0};
    int n_peaks = 0;
    Fixture f;
    PetscCall(OpenOneDof(r, &f));
    const PetscInt y = DofOf(f.model, 4) + 1;
    f.state->v[y] = 1e-3;
    f.state->alpha = 2 * z * 2 * r;
    for (int n = 0; n < 5000 && n_peaks < 4; n++) {
      PetscCall(OneStep(&f));
      const double u = f.state->u[y];
      if (before[1] > before[0] && before[1] > u) { // the top of the parabola through three points
        const double slope = 0.5 * (u - before[0]), bend = u - 2 * before[1] + before[0];
        peak[n_peaks++] = before[1] - 0.5 * slope * slope / bend;
      }
      before[0] = before[1], before[1] = u;
    }
    ENSURE(n_peaks == 4);
    ENSURE_NEAR(log(peak[0] / peak[3]) / 3 / (2 * PETSC_PI * z / sqrt(1 - z * z)), 1, 1e-3);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A wall of both kinds of blocks on elastic joints, undamped. */
static PetscErrorCode OpenWall(const char *strain, int rigid, Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", rigid);
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 2; i++) {
      const double x = 2 * i + 0.5 * j, corner[8] = {x, j, x + 2, j, x + 2, j + 1, x, j + 1};
      const int first = SketchGrid(&sketch, (i + j) % 2 ? hard : soft, corner, 2, 1, QUADS);
      if (j == 0) SketchFace(&sketch, "base", first, 0), SketchFace(&sketch, "base", first + 1, 0);
    }
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "strain: %s\nmaterials: {soft: {density: 2000, young: 1e9, poisson: 0.2}, hard: {density: "
                  "2000, young: 3e9, poisson: 0.2}}\nrelaxation: {damping: none}\n"
                  "joints: {default: {law: elastic, k_n: 1e9, k_s: 3e8}}\nsupports: {base: {fix: xy}}\n"
                  "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight], ramp: 0}]\n",
                  strain));
  PetscCall(StageStart(f, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V25: 1/2 v-.M v+ + 1/2 u.K u less the work of the weight stays, v- and v+ the velocities around u. */
static PetscErrorCode EnergyIsConserved(int rigid, double size, double bound)
{
  Fixture f;
  PetscReal first = 0, worst = 0, *u_before, *v_before;

  PetscFunctionBeginUser;
  PetscCall(OpenWall("small", rigid, &f));
  State *s = f.state;
  const PetscInt n = f.model->n_dof;
  PetscCall(PetscMalloc2(n, &u_before, n, &v_before));
  for (PetscInt d = 0; d < n; d++) {
    s->v[d] = Held(f.model, d) ? 0 : size * Uniform(-1, 1);
    s->f_ext[d] *= rigid ? 0 : 1; // a body at work would turn out of the linear range
  }
  for (int step = 0; step < 5000; step++) {
    PetscReal energy = 0;
    PetscCall(PetscArraycpy(v_before, s->v, n));
    PetscCall(PetscArraycpy(u_before, s->u, n));
    PetscCall(OneStep(&f));
    for (PetscInt d = 0; d < n; d++)
      if (!Held(f.model, d))
        energy += 0.5 * v_before[d] * s->m[d] * s->v[d] + 0.5 * u_before[d] * s->f[d] -
                  u_before[d] * s->f_ext[d];
    if (step == 0) first = energy;
    worst = PetscMax(worst, fabs(energy - first));
  }
  ENSURE(first > 0);
  ENSURE_NEAR(worst / first, 0, bound);
  PetscCall(PetscFree2(u_before, v_before));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LinearDeformableSystemKeepsItsEnergy(void)
{
  PetscFunctionBeginUser;
  PetscCall(EnergyIsConserved(0, 1e-2, 1e-12));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rotations of order 1e-7 leave as much in the energy */
static PetscErrorCode MixedSystemKeepsItsEnergy(void)
{
  PetscFunctionBeginUser;
  PetscCall(EnergyIsConserved(1, 1e-7, 1e-6));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V26: a spinning block keeps momentum and angular momentum and stays below twice the centrifugal stress. */
static PetscErrorCode SpinningBlockStaysStressFree(void)
{
  const double spin = 5, L = 1, rho = 2000;
  Fixture f;
  PetscReal momentum[2][3], worst = 0, stress[12];

  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const double corner[8] = {0, 0, L, 0, L, L, 0, L};
  SketchGrid(&sketch, SketchGroup(&sketch, "soft", 0), corner, 2, 2, QUADS);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                        "materials: {soft: {density: %g, young: 1e8, poisson: 0}}\n"
                        "relaxation: {damping: none, allow_floating: true}\n"
                        "joints: {default: {k_n: 1, k_s: 1, friction: 0}}\n"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n",
                        rho));
  State *s = f.state;
  const Model *m = f.model;
  s->dt = 2e-4;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    s->m[d] = DofMass(m, d), s->m_inv[d] = 1 / DofMass(m, d);
    s->v[d] = (d % 2 ? 1 : -1) * spin * (m->mesh.X[d - d % 2 + 1 - d % 2] - 0.5 * L);
  }
  const int n_steps = (int)(0.5 * PETSC_PI / spin / s->dt); // a quarter turn
  for (int step = 0; step <= n_steps; step++) {
    PetscReal *p = momentum[step > 0];
    memset(p, 0, sizeof momentum[0]);
    for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
      const PetscReal *u = s->u + 2 * v, *w = s->v + 2 * v, mass = s->m[2 * v];
      for (int i = 0; i < 2; i++) p[i] += mass * w[i];
      // v is half a step behind u here: positions at the half step
      p[2] += mass * ((m->mesh.X[2 * v] + u[0]) * w[1] - (m->mesh.X[2 * v + 1] + u[1]) * w[0]);
    }
    PetscCall(OneStep(&f));
    PetscCall(ElementStress(m, &m->mesh.q4, 4, s->u, stress));
    for (int i = 0; i < 12; i++) worst = PetscMax(worst, fabs(stress[i]));
  }
  const PetscInt corner_at = LocalOfFile(m, 8);
  ENSURE_NEAR(s->u[2 * corner_at], -L, 1e-2); // (L, L) is now at (0, L)
  ENSURE_NEAR(s->u[2 * corner_at + 1], 0, 1e-2);
  ENSURE_NEAR(momentum[1][0], 0, 1e-9);
  ENSURE_NEAR(momentum[1][1], 0, 1e-9);
  ENSURE_NEAR(momentum[1][2] / momentum[0][2], 1, 1e-3);
  ENSURE(worst < 2 * rho * spin * spin * L * L / 8);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(PeriodAndAmplitudeOfOneDof);
  RUN_TEST(AboveTheLimitOneDofDiverges);
  RUN_TEST(DampingGivesTheLogDecrement);
  RUN_TEST(LinearDeformableSystemKeepsItsEnergy);
  RUN_TEST(MixedSystemKeepsItsEnergy);
  RUN_TEST(SpinningBlockStaysStressFree);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

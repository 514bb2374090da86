/* One anchor: its force is the slope of its energy, its stiffness that of its force, in small and in large
   strain; its law; the row sums of the term are above its largest eigenvalue. */
#include "check.h"
#include "anchors/line.h"

enum { N = 8, DOFS = 2 * N };
static const Anchor tendon = {.area = 1e-3,
                              .young = 2e11,
                              .spacing = 2.,
                              .yield = 1e9,
                              .breaking_force = PETSC_INFINITY,
                              .strain_limit = PETSC_INFINITY};

static PetscReal Random(PetscReal low, PetscReal high)
{
  return low + (high - low) * ((PetscReal)rand() / (PetscReal)RAND_MAX);
}

/* A tendon of 3 m between two blocks, without force at `natural`. */
static Line Draw(const Anchor *of, PetscReal natural)
{
  Line line = {.of = of, .here = PETSC_TRUE, .mine = PETSC_TRUE, .n = N, .stiffness = 2e8 / 3., .T_y = 1e6};
  const PetscReal angle = Random(0., 6.28);
  PetscReal sum[2] = {0., 0.};
  for (int i = 0; i < N; i++) {
    line.vertex[i] = i;
    sum[i / 4] += line.weight[i] = Random(0., 1.);
  }
  for (int i = 0; i < N; i++) line.weight[i] *= (i < 4 ? 1. : -1.) / sum[i / 4];
  line.length = line.span = 3., line.per_slice = 0.5;
  line.reference[0] = 3. * cos(angle), line.reference[1] = 3. * sin(angle);
  line.committed = (LineHistory){.phase = LINE_LOCKED, .natural = natural};
  return line;
}

/* What the term gives to whoever asks for the stiffness. */
static PetscErrorCode Take(PetscInt n, const PetscInt *vertices, const PetscReal *k, const PetscReal *carried,
                           void *context)
{
  PetscReal *to = context;
  (void)vertices, (void)carried;
  for (PetscInt i = 0; i < 4 * n * n; i++) to[i] = k[i];
  return PETSC_SUCCESS;
}

static PetscReal EnergyAt(Line *line, const Model *m, const PetscReal *u)
{
  LineEvaluate(line, m, u);
  return line->per_slice * LineStored(line);
}

static void ForceAt(Line *line, const Model *m, const PetscReal *u, PetscReal *f)
{
  for (int d = 0; d < DOFS; d++) f[d] = 0.;
  LineEvaluate(line, m, u);
  LinePull(line, line->T, f);
}

static PetscErrorCode TestForceAndStiffness(void)
{
  const PetscReal h = 1e-5;
  PetscFunctionBeginUser;
  for (int draw = 0; draw < 40; draw++) {
    const Model m = {.materials.strain = draw % 2 ? STRAIN_LARGE : STRAIN_SMALL};
    const Instant at = {.m = &m};
    PetscReal u[DOFS], f[DOFS], less[DOFS], more[DOFS], k[DOFS * DOFS], bound[N] = {0.}, most = 0.;
    Line line = Draw(&tendon, -0.012); // more than the displacements shorten it
    Anchors all = {.n = 1, .line = &line};
    for (int d = 0; d < DOFS; d++) u[d] = Random(-2e-3, 2e-3);
    ForceAt(&line, &m, u, f);
    PetscCall(Anchors_term.tangent(&all, &at, TANGENT_NOW, Take, k));
    PetscCall(Anchors_term.bound(&all, &at, PETSC_FALSE, bound));
    for (int d = 0; d < DOFS; d++) {
      const PetscReal was = u[d];
      PetscReal row = 0.;
      u[d] = was + h;
      ForceAt(&line, &m, u, more);
      const PetscReal above = EnergyAt(&line, &m, u);
      u[d] = was - h;
      ForceAt(&line, &m, u, less);
      ENSURE_NEAR((above - EnergyAt(&line, &m, u)) / (2. * h), f[d], 1e-4 * 1e5);
      u[d] = was;
      for (int e = 0; e < DOFS; e++) {
        ENSURE_NEAR((more[e] - less[e]) / (2. * h), k[DOFS * d + e], 1e-5 * line.stiffness);
        row += PetscAbsReal(k[DOFS * d + e]);
      }
      most = PetscMax(most, row / bound[d / 2]);
    }
    ENSURE(most <= 1. && most > 0.5);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Along x: stretched, yielding, let go, slack; a bar yields both ways. */
static void TestLaw(void)
{
  const Anchor bar = {.area = 1e-3,
                      .young = 2e11,
                      .yield = 1e9,
                      .compression = PETSC_TRUE,
                      .breaking_force = PETSC_INFINITY,
                      .strain_limit = PETSC_INFINITY};
  Line line = Draw(&tendon, 0.001);
  LineHistory now;
  ENSURE_NEAR(LineForce(&line, 0., &now), 0., 0.);
  ENSURE_NEAR(LineForce(&line, 0.004, &now), 2e5, 1e-9);
  ENSURE_NEAR(LineForce(&line, 0.026, &now), 1e6, 1e-9);
  ENSURE_NEAR(now.plastic, 0.010, 1e-12);
  ENSURE_NEAR(now.lost, 1e4, 1e-6);
  ENSURE_NEAR(line.committed.plastic, 0., 0.); // an evaluation commits nothing
  line.committed = now;
  ENSURE_NEAR(LineForce(&line, 0.017, &now), 4e5, 1e-8);
  ENSURE_NEAR(LineForce(&line, 0.010, &now), 0., 0.);
  line.of = &bar;
  ENSURE_NEAR(LineForce(&line, 0.010, &now), -2e5 / 3., 1e-8);
  ENSURE_NEAR(LineForce(&line, -0.010, &now), -1e6, 1e-9);
  ENSURE_NEAR(now.plastic, 0.004, 1e-12);
  line.committed.phase = LINE_STRESSED;
  ENSURE_NEAR(LineForce(&line, 0.1, &now), 0., 0.); // the jack is a load
}

/* A bonded bar breaks by its largest tension, though it is pressed harder elsewhere. */
static void TestPressedAndPulled(void)
{
  Anchor of = {.breaking_force = 1.9e5, .strain_limit = PETSC_INFINITY};
  PetscReal along[] = {1e5, -3e5, 2e5};
  Chain chain = {.n = 4, .N = along};
  const Line line = {.of = &of, .chain = &chain, .now.phase = LINE_LOCKED};
  ENSURE_NEAR(LineLargest(&line), 2e5, 0.);
  ENSURE_NEAR(ChainLargest(&chain), -3e5, 0.);
  ENSURE(LineBreaks(&line));
  of.breaking_force = 2.1e5;
  ENSURE(!LineBreaks(&line));
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestForceAndStiffness);
  RUN_TEST(TestLaw);
  RUN_TEST(TestPressedAndPulled);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Material laws: the return to the Mohr-Coulomb strength against an oracle that tries all sets of planes,
   stresses computed elsewhere (M01), histories, and blocks below their strength against elastic ones. */
#include "blocks/law_kernels.h"
#include "check.h"

static unsigned long long seed = 1;

/* In (-1, 1). */
static PetscReal Random(void)
{
  seed = 6364136223846793005ULL * seed + 1442695040888963407ULL;
  return (PetscReal)(seed >> 11) / 4503599627370496. - 1.;
}

/* ---- the oracle */

/* Planes n.s <= b with flow m: six of shear, three of the cut-off. */
typedef struct {
  PetscReal n[9][3], m[9][3], b[9];
} Planes;

static Planes PlanesOf(const Material *m)
{
  const PetscReal phi = m->friction * PETSC_PI / 180., psi = m->dilation * PETSC_PI / 180.;
  Planes p = {{{0.}}, {{0.}}, {0.}};
  int k = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      if (i == j) continue;
      p.n[k][i] = 1. + sin(phi), p.n[k][j] = -(1. - sin(phi));
      p.m[k][i] = 1. + sin(psi), p.m[k][j] = -(1. - sin(psi));
      p.b[k++] = 2. * m->cohesion * cos(phi);
    }
  for (int i = 0; i < 3; i++) p.n[k][i] = p.m[k][i] = 1., p.b[k++] = m->tension;
  return p;
}

static PetscReal Dot(const PetscReal *a, const PetscReal *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static PetscReal Determinant(PetscReal A[3][3])
{
  return A[0][0] * (A[1][1] * A[2][2] - A[1][2] * A[2][1]) -
         A[0][1] * (A[1][0] * A[2][2] - A[1][2] * A[2][0]) +
         A[0][2] * (A[1][0] * A[2][1] - A[1][1] * A[2][0]);
}

/* The stress that the planes of a set leave of t; whether it is admissible. */
static int SetLeaves(const Planes *p, const Material *m, const int *set, int k, const PetscReal t[3],
                     PetscReal s[3])
{
  const PetscReal mu = m->young / (2. * (1. + m->poisson)),
                  lambda = 2. * mu * m->poisson / (1. - 2. * m->poisson);
  PetscReal A[3][3] = {{1., 0., 0.}, {0., 1., 0.}, {0., 0., 1.}}, r[3] = {0., 0., 0.}, Cm[3][3],
            scale = m->cohesion;
  for (int j = 0; j < k; j++) {
    const PetscReal *flow = p->m[set[j]], trace = flow[0] + flow[1] + flow[2];
    for (int i = 0; i < 3; i++) Cm[j][i] = lambda * trace + 2. * mu * flow[i];
  }
  for (int i = 0; i < k; i++) {
    r[i] = Dot(p->n[set[i]], t) - p->b[set[i]];
    for (int j = 0; j < k; j++) A[i][j] = Dot(p->n[set[i]], Cm[j]) / mu;
  }
  const PetscReal det = Determinant(A);
  if (fabs(det) < 1e-9) return 0;
  for (int i = 0; i < 3; i++) s[i] = t[i], scale = fmax(scale, fabs(t[i]));
  for (int j = 0; j < k; j++) {
    PetscReal B[3][3];
    memcpy(B, A, sizeof B);
    for (int i = 0; i < 3; i++) B[i][j] = r[i];
    const PetscReal l = Determinant(B) / det;
    if (l < -1e-11 * scale) return 0;
    for (int i = 0; i < 3; i++) s[i] -= l * Cm[j][i] / mu;
  }
  for (int q = 0; q < 9; q++)
    if (Dot(p->n[q], s) > p->b[q] + 1e-9 * scale) return 0;
  return 1;
}

/* Principal stresses behind the trial t, by trying all sets of up to three planes; returns how many of them
   are admissible and differ. */
static int Oracle(const Material *m, const PetscReal t[3], PetscReal s[3])
{
  const Planes p = PlanesOf(m);
  int found = 0;
  for (int a = -1; a < 9; a++)
    for (int b = a < 0 ? -1 : a; b < 9; b++)
      for (int c = b < 0 ? -1 : b; c < 9; c++) {
        int set[3], k = 0;
        PetscReal one[3];
        if ((a >= 0 && a == b) || (b >= 0 && b == c)) continue;
        if (a >= 0) set[k++] = a;
        if (b >= 0) set[k++] = b;
        if (c >= 0) set[k++] = c;
        if (!SetLeaves(&p, m, set, k, t, one)) continue;
        PetscReal far = 0.;
        for (int i = 0; i < 3 && found; i++) far = fmax(far, fabs(one[i] - s[i]));
        if (found && far < 1e-6 * (m->cohesion + fabs(t[0]) + fabs(t[1]) + fabs(t[2]))) continue;
        found++;
        memcpy(s, one, sizeof one);
      }
  return found;
}

/* ---- the kernel at a point */

typedef struct {
  PetscReal constant[LAW_CONSTANTS * LANES];
  LanesLaw law;
  Lanes history[HISTORY_MOST];
} Point;

static void PointOf(const Material *m, Point *p)
{
  const PetscReal mu = m->young / (2. * (1. + m->poisson)),
                  lambda = 2. * mu * m->poisson / (1. - 2. * m->poisson);
  memset(p, 0, sizeof *p);
  PetscReal c[LAW_CONSTANTS] = {lambda, mu};
  LawKinds[m->law].constants(m, (Lame){lambda, mu}, c);
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++) p->constant[i] = c[i / LANES];
  p->law = (LanesLaw){p->constant};
}

/* s: xx, yy, zz, xy at the strain E of xx, yy, and half of the shear; the history goes on. */
static void Respond(Point *p, const PetscReal E[3], PetscReal s[4])
{
  const LanesStress strain = {LanesOf(E[0]), LanesOf(E[1]), LanesOf(0.), LanesOf(E[2])};
  Lanes to[HISTORY_MOST], whole;
  const LanesStress S = LawStress(MATERIAL_MOHR_COULOMB, &p->law, &strain, NULL, p->history, to, &whole);
  for (int lane = 1; lane < LANES; lane++)
    ENSURE(S.xx[0] == S.xx[lane] && S.yy[0] == S.yy[lane] && S.zz[0] == S.zz[lane] && S.xy[0] == S.xy[lane]);
  ENSURE(whole[0] > 0. && whole[0] <= 1.);
  for (int i = 0; i < MC_WIDTH; i++) p->history[i] = to[i];
  s[0] = S.xx[0], s[1] = S.yy[0], s[2] = S.zz[0], s[3] = S.xy[0];
}

/* ---- tests */

static const Material P = {.young = 20e9,
                           .poisson = 0.2,
                           .cohesion = 1e6,
                           .friction = 45.,
                           .dilation = 15.,
                           .tension = 0.5e6,
                           .law = MATERIAL_MOHR_COULOMB};

/* One step from zero, and a thousand in proportion, against numbers from another program. */
static void TestPublished(void)
{
  static const struct {
    PetscReal strain[3], one[4], steps[4]; /* 1e-4 xx, yy, gamma; MPa xx, yy, xy, zz */
  } rows[] = {
      {{2, -4, 0}, {-0.3319, -6.7631, 0, -1.4190}, {-0.3363, -6.7887, 0, -1.4250}},
      {{2, -6, 3}, {-1.4927, -11.2609, 1.8315, -2.5507}, {-1.4927, -11.2609, 1.8315, -2.5507}},
      {{-6, -1, 8}, {-13.8677, -5.7617, 6.4848, -3.9259}, {-13.8677, -5.7617, 6.4848, -3.9259}},
      {{0, 0, 2}, {-0.7071, -0.7071, 1.2071, -0.2828}, {-0.7187, -0.7187, 1.2153, -0.2875}},
      {{2, -1, 1}, {0.4381, -1.8523, 0.3817, -0.2828}, {0.4381, -1.8523, 0.3817, -0.2828}},
      {{1, -1, 6}, {-0.9475, -2.0693, 1.6827, -0.6034}, {-1.2587, -2.5597, 1.9515, -0.7637}},
      {{1, 0, 0}, {0.5, 0.125, 0, 0.125}, {0.5, 0.125, 0, 0.125}},
      {{1, 1, 0}, {0.5, 0.5, 0, 0.2}, {0.5, 0.5, 0, 0.2}},
      {{4, 4, -2}, {0.5, 0.5, 0, 0.2}, {0.5, 0.5, 0, 0.2}},
      {{0, -4, 0}, {-2.2222, -8.8889, 0, -2.2222}, {-2.2222, -8.8889, 0, -2.2222}},
  };
  for (size_t row = 0; row < sizeof rows / sizeof *rows; row++)
    for (int steps = 1; steps <= 1000; steps += 999) {
      const PetscReal *expected = steps > 1 ? rows[row].steps : rows[row].one;
      PetscReal s[4] = {0., 0., 0., 0.};
      Point p;
      PointOf(&P, &p);
      for (int i = 1; i <= steps; i++) {
        const PetscReal part = 1e-4 * i / steps, *e = rows[row].strain;
        Respond(&p, (PetscReal[3]){part * e[0], part * e[1], 0.5 * part * e[2]}, s);
      }
      ENSURE_NEAR(1e-6 * s[0], expected[0], 1e-4);
      ENSURE_NEAR(1e-6 * s[1], expected[1], 1e-4);
      ENSURE_NEAR(1e-6 * s[3], expected[2], 1e-4);
      ENSURE_NEAR(1e-6 * s[2], expected[3], 1e-4);
    }
}

static Material RandomMaterial(void)
{
  static const PetscReal nu[] = {0., 0.1, 0.2, 0.3, 0.45}, phi[] = {0., 5., 20., 35., 45., 60.},
                         share[] = {0., 0.3, 1.}, cut[] = {0., 0.1, 0.5, 0.9, 1.};
  Material m = P;
  m.poisson = nu[(int)(2.5 * (1. + Random()))];
  m.friction = phi[(int)(3. * (1. + Random()))];
  m.dilation = m.friction * share[(int)(1.5 * (1. + Random()))];
  const PetscReal apex = m.friction > 0. ? m.cohesion / tan(m.friction * PETSC_PI / 180.) : 5. * m.cohesion;
  m.tension = apex * cut[(int)(2.5 * (1. + Random()))];
  return m;
}

/* Of all regions, corners included: the strain of a random trial stress, whose zz follows. */
static void TestOracle(void)
{
  const int n = CheckDraws(20000);
  int yielded = 0;
  for (int draw = 0; draw < n; draw++) {
    const Material m = RandomMaterial();
    const PetscReal size = draw % 3 ? 1e6 : 1e7, mu = m.young / (2. * (1. + m.poisson)), nu = m.poisson,
                    shift = draw % 2 ? size * Random() : 0.;
    /* plastic strain along z gives every sz */
    const PetscReal t[3] = {size * Random() + shift, size * Random() + shift, size * Random() + shift};
    const PetscReal angle = PETSC_PI * Random(), half = 0.5 * (t[0] - t[1]);
    PetscReal s[4], expected[3], e[3];
    Point p;
    PointOf(&m, &p);
    for (int i = 0; i < 3; i++) e[i] = ((1. + nu) * t[i] - nu * (t[0] + t[1] + t[2])) / m.young;
    p.history[MC_ZZ] = LanesOf(-e[2]);
    const PetscReal strain[3] = {0.5 * (e[0] + e[1]) + half * cos(2. * angle) / (2. * mu),
                                 0.5 * (e[0] + e[1]) - half * cos(2. * angle) / (2. * mu),
                                 half * sin(2. * angle) / (2. * mu)};
    Respond(&p, strain, s);
    const int found = Oracle(&m, t, expected);
    ENSURE(found == 1);
    const PetscReal radius = hypot(0.5 * (s[0] - s[1]), s[3]), sign = half < 0. ? -1. : 1.;
    const PetscReal scale = m.cohesion + fabs(t[0]) + fabs(t[1]) + fabs(t[2]);
    ENSURE_NEAR(0.5 * (s[0] + s[1]) + sign * radius, expected[0], 1e-8 * scale);
    ENSURE_NEAR(0.5 * (s[0] + s[1]) - sign * radius, expected[1], 1e-8 * scale);
    ENSURE_NEAR(s[2], expected[2], 1e-8 * scale);
    ENSURE_NEAR(0.5 * (s[0] - s[1]) * sin(2. * angle), s[3] * cos(2. * angle), 1e-8 * scale); // coaxial
    ENSURE(p.history[HISTORY_LOST][0] >= -1e-9 * scale * scale / m.young);
    yielded += p.history[HISTORY_MEASURE][0] > 0.;
    const Point before = p;
    PetscReal again[4];
    Respond(&p, strain, again); // a second evaluation changes no bit
    ENSURE(!memcmp(s, again, sizeof s) && !memcmp(before.history, p.history, MC_WIDTH * sizeof *p.history));
  }
  ENSURE(yielded > n / 2 && yielded < n);
}

/* What is stored and lost is the work done, to the square of the steps. */
static void TestWork(void)
{
  Point p;
  PetscReal s[4], before[4] = {0., 0., 0., 0.}, work = 0., last[3] = {0., 0., 0.};
  const int steps = 4000;
  PointOf(&P, &p);
  for (int i = 1; i <= steps; i++) {
    const PetscReal a = 6.283185307179586 * i / steps,
                    E[3] = {4e-4 * sin(a), -3e-4 * sin(a) + 2e-4 * (1. - cos(a)), 3e-4 * (1. - cos(a))};
    Respond(&p, E, s);
    for (int k = 0; k < 3; k++)
      work += (k == 2 ? 2. : 1.) * 0.5 * (s[k == 2 ? 3 : k] + before[k == 2 ? 3 : k]) * (E[k] - last[k]);
    memcpy(before, s, sizeof s), memcpy(last, E, sizeof last);
  }
  Lanes opening;
  const LanesStress E = {LanesOf(last[0]), LanesOf(last[1]), LanesOf(0.), LanesOf(last[2])};
  const PetscReal stored = LawStored(MATERIAL_MOHR_COULOMB, &p.law, &E, p.history, &opening)[0],
                  lost = p.history[HISTORY_LOST][0];
  ENSURE(lost > 100.);
  ENSURE_NEAR(work, stored + lost, 1e-3 * work);
}

/* ---- damage */

static const Material CRACKS = {
    .young = 10e9, .poisson = 0., .tension = 1e6, .fracture_energy = 100., .law = MATERIAL_DAMAGE};

/* A rectangle of these sides in all lanes, turned. */
static void Rectangle(PetscReal a, PetscReal b, PetscReal angle, LanesVector X[4])
{
  const PetscReal x[4] = {0., a, a, 0.}, y[4] = {0., 0., b, b}, c = cos(angle), s = sin(angle);
  for (int i = 0; i < 4; i++)
    X[i] = (LanesVector){LanesOf(c * x[i] - s * y[i]), LanesOf(s * x[i] + c * y[i])};
}

static void Crack(Point *p, const LanesVector *X, const PetscReal E[3], PetscReal s[4])
{
  const LanesStress strain = {LanesOf(E[0]), LanesOf(E[1]), LanesOf(0.), LanesOf(E[2])};
  const LanesShape shape = {4, X};
  Lanes to[HISTORY_MOST], whole;
  const LanesStress S = LawStress(MATERIAL_DAMAGE, &p->law, &strain, &shape, p->history, to, &whole);
  for (int i = 0; i < DM_NUMBERS; i++) p->history[i] = to[i];
  s[0] = S.xx[0], s[1] = S.yy[0], s[2] = S.zz[0], s[3] = S.xy[0];
}

static PetscReal Stored(const Point *p, const PetscReal E[3])
{
  const LanesStress strain = {LanesOf(E[0]), LanesOf(E[1]), LanesOf(0.), LanesOf(E[2])};
  Lanes opening;
  return LawStored(MATERIAL_DAMAGE, &p->law, &strain, p->history, &opening)[0];
}

/* Pulled, closed, pulled on: numbers from another program. Closed it has its whole stiffness. */
static void TestCracks(void)
{
  static const PetscReal rows[][3] = {{5e-4, 0.656356e6, 0.868729},
                                      {-3e-4, -3e6, 0.868729},
                                      {3e-4, 0.393813e6, 0.868729},
                                      {1e-3, 0.387760e6, 0.961224},
                                      {1.5e-3, 0.229080e6, 0.984728}};
  for (int turn = 0; turn < 2; turn++) {
    const PetscReal angle = 0.7 * turn, c = cos(angle), n = sin(angle);
    LanesVector X[4];
    Point p;
    PetscReal s[4];
    Rectangle(0.1, 0.37, angle, X);
    PointOf(&CRACKS, &p);
    for (int i = 0; i < 5; i++) {
      const PetscReal e = rows[i][0];
      Crack(&p, X, (PetscReal[3]){e * c * c, e * n * n, e * c * n}, s);
      ENSURE_NEAR(s[0] + s[1], rows[i][1], 1.);
      ENSURE_NEAR(s[0] * c * c + s[1] * n * n + 2. * s[3] * c * n, rows[i][1], 1.);
      ENSURE_NEAR(p.history[HISTORY_MEASURE][0], rows[i][2], 1e-6);
      ENSURE_NEAR(p.history[DM_WIDTH][0], 0.1, 1e-12);
      const Point before = p;
      PetscReal again[4];
      Crack(&p, X, (PetscReal[3]){e * c * c, e * n * n, e * c * n}, again);
      ENSURE(!memcmp(s, again, sizeof s) &&
             !memcmp(before.history, p.history, DM_NUMBERS * sizeof *p.history));
    }
  }
}

/* Linear softening: by hand, sigma = ft (e_u - e)/(e_u - e_0) with e_u = 2 Gf/(h ft) = 2e-3, e_0 = 1e-4. */
static void TestLinearSoftening(void)
{
  static const PetscReal rows[][2] = {
      {1e-4, 1e6}, {5e-4, 1.5 / 1.9 * 1e6}, {2.5e-4, 0.75 / 1.9 * 1e6}, {1.05e-3, 0.5e6}, {2e-3, 0.},
      {3e-3, 0.}};
  Material m = CRACKS;
  LanesVector X[4];
  Point p;
  PetscReal s[4];
  m.softening = SOFTENING_LINEAR;
  Rectangle(0.1, 0.37, 0., X);
  PointOf(&m, &p);
  for (int i = 0; i < 6; i++) {
    Crack(&p, X, (PetscReal[3]){rows[i][0], 0., 0.}, s);
    ENSURE_NEAR(s[0], rows[i][1], 1e-3);
    if (i == 3)
      ENSURE_NEAR(p.history[HISTORY_LOST][0], 1e6 * (1e-3 - 0.25 * 1.9e-3 * 0.5) - 0.25e6 * 1.05e-3, 1e-3);
  }
  ENSURE_NEAR(0.1 * p.history[HISTORY_LOST][0], 100., 1e-6);
  ENSURE(p.history[HISTORY_MEASURE][0] == 1.);
}

/* However many steps and whatever Poisson's ratio, size and softening: the energy of the crack. */
static void TestFractureEnergy(void)
{
  for (int nu = 0; nu < 4; nu++)
    for (int steps = 1; steps <= 1000; steps *= 10) {
      Material m = CRACKS;
      LanesVector X[4];
      Point p;
      PetscReal s[4];
      m.poisson = 0.25 * (nu % 2), m.softening = nu < 2 ? SOFTENING_EXPONENTIAL : SOFTENING_LINEAR;
      Rectangle(0.2, 0.1, 0., X);
      PointOf(&m, &p);
      for (int i = 1; i <= steps; i++) Crack(&p, X, (PetscReal[3]){0.03 * i / steps, 0., 0.}, s);
      ENSURE_NEAR(0.2 * p.history[HISTORY_LOST][0], 100., 1e-6);
      ENSURE(p.history[HISTORY_MEASURE][0] > 0.999999);
    }
}

/* Along any closed way at fixed damage nothing is made or lost; with growing damage the loss is reported. */
static void TestCrackWork(void)
{
  Material m = CRACKS;
  LanesVector X[4];
  Point p;
  const int steps = 20000;
  PetscReal s[4], before[4] = {0., 0., 0., 0.}, last[3] = {0., 0., 0.};
  m.poisson = 0.3;
  Rectangle(0.2, 0.3, 0.4, X);
  PointOf(&m, &p);
  for (int round = 0; round < 2; round++) {
    PetscReal work = 0., first = Stored(&p, last), lost = p.history[HISTORY_LOST][0];
    for (int i = 1; i <= steps; i++) {
      const PetscReal a = 6.283185307179586 * i / steps, b = 1. - cos(a),
                      E[3] = {3e-4 * sin(a), -4e-4 * sin(a) + 2e-4 * b, 3e-4 * sin(2. * a) + 1e-4 * b};
      Crack(&p, X, E, s);
      for (int k = 0; k < 3; k++)
        work += (k == 2 ? 2. : 1.) * 0.5 * (s[k == 2 ? 3 : k] + before[k == 2 ? 3 : k]) * (E[k] - last[k]);
      memcpy(before, s, sizeof s), memcpy(last, E, sizeof last);
    }
    lost = p.history[HISTORY_LOST][0] - lost;
    ENSURE(round ? lost < 1e-9 : lost > 50.);
    ENSURE_NEAR(work, Stored(&p, last) - first + lost, round ? 1e-3 : 0.5);
  }
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestPublished);
  RUN_TEST(TestOracle);
  RUN_TEST(TestWork);
  RUN_TEST(TestCracks);
  RUN_TEST(TestLinearSoftening);
  RUN_TEST(TestFractureEnergy);
  RUN_TEST(TestCrackWork);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

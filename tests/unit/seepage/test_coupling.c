/* The iteration between pressures that act and those that flow leads to: a cell that jumps (W09), a rigid
   dam near its limit (W06), and what the method must do of itself. */
#include "seepage/flow.h"
#include "check.h"

/* ---- a cell that jumps: its inlet opens with its pressure, its outlet is tight */

static const double A0 = 0.05e-3, B = 0.15e-3, K_N = 2e9;

/* [Pa] p1 behind the inlet at which the cell is at rest with p: the branches are its parts of rising p1. */
static double behind(double p)
{
  const double a = A0 + p / K_N;
  return p * (1 + pow(B / a, 3));
}

static double flow_to(double p, double p1)
{
  const double a = A0 + p / K_N;
  return p1 / (1 + pow(B / a, 3));
}

/* [Pa] Where the branch from `low` on, on which p1 rises (or falls), has p1. */
static double on_branch(double low, double high, double p1)
{
  const double up = behind(high) > behind(low) ? 1. : -1.;
  for (int i = 0; i < 200; i++) {
    const double middle = 0.5 * (low + high);
    if (up * (behind(middle) - p1) > 0.)
      high = middle;
    else
      low = middle;
  }
  return 0.5 * (low + high);
}

/* Iterates n cells of pressures x [Pa], each behind p1, to 1e-10, by the method or without it; returns the
   rounds, `most`: it has not ended. */
enum { DEFAULT_ROUNDS = 100, MANY_ROUNDS = 100000 };
static PetscErrorCode settle(PetscInt n, const double *p1, PetscBool mixed, int most, PetscReal *x,
                             int *rounds)
{
  PetscReal g[8];
  Mixer mixer = {0};
  PetscFunctionBegin;
  for (*rounds = 1; *rounds < most; ++*rounds) {
    double change = 0., top = 1e-300;
    for (PetscInt i = 0; i < n; i++) {
      g[i] = flow_to(x[i], p1[i]);
      change = PetscMax(change, fabs(g[i] - x[i])), top = PetscMax(top, g[i]);
    }
    if (change <= 1e-10 * top) break;
    if (mixed)
      PetscCall(MixerNext(&mixer, n, g, x));
    else
      PetscCall(PetscArraycpy(x, g, n));
  }
  PetscCall(MixerReset(&mixer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const double FOLD = 63.1067e3, CREST = 455.77318e3, FOOT = 400e3; // [Pa] p and p1 where branches end

/* W09: as p1 rises the cell stays on its lower branch up to 455.77 kPa, where it has 63.11 kPa, and jumps
   to 353.40 kPa; as it falls it stays up down to 400 kPa, has 200 kPa there and jumps to 30.28 kPa. Steps
   of 0.1 % of p1: the last one on a branch, and the first beyond it, are half of that off its end. */
static PetscErrorCode CellThatJumps(void)
{
  PetscReal x = 0.;
  int rounds, most = 0, n_wrong = 0;
  ENSURE_NEAR(behind(FOLD), CREST, 1e-8 * CREST);
  ENSURE_NEAR(behind(200e3), FOOT, 1e-9 * FOOT);
  ENSURE_NEAR(on_branch(200e3, 1e6, CREST), 353.40e3, 1e-5 * 353.40e3);
  ENSURE_NEAR(on_branch(0., FOLD, FOOT), 30.28e3, 1e-4 * 30.28e3);
  for (int k = 0; k <= 500; k++) {
    const double p1 = CREST * (0.5005 + 1e-3 * k),
                 wanted = p1 < CREST ? on_branch(0., FOLD, p1) : on_branch(200e3, 1e6, p1);
    PetscCall(settle(1, &p1, PETSC_TRUE, DEFAULT_ROUNDS, &x, &rounds));
    most = PetscMax(most, rounds), n_wrong += fabs(x - wanted) > 1e-3 * wanted;
  }
  ENSURE(n_wrong == 0 && most < DEFAULT_ROUNDS);
  x = on_branch(200e3, 1e6, CREST), most = n_wrong = 0;
  for (int k = 0; k <= 300; k++) {
    const double p1 = FOOT * (1.2995 - 1e-3 * k),
                 wanted = p1 > FOOT ? on_branch(200e3, 1e6, p1) : on_branch(0., FOLD, p1);
    PetscCall(settle(1, &p1, PETSC_TRUE, DEFAULT_ROUNDS, &x, &rounds));
    most = PetscMax(most, rounds), n_wrong += fabs(x - wanted) > 1e-3 * wanted;
  }
  ENSURE(n_wrong == 0 && most < DEFAULT_ROUNDS);
  return 0;
}

/* From wherever it begins a cell comes to rest where the water itself would bring it, with 0.5 % to the
   folds; never where a little more pressure leads to still more. */
static PetscErrorCode CellAtRest(void)
{
  int rounds, most = 0, n_wrong = 0;
  for (int k = 0; k < 20; k++)
    for (int j = 0; j < 26; j++) {
      const double p1 = FOOT * 0.955 + k * 0.01 * FOOT;
      PetscReal x = 20e3 * j, wanted = 20e3 * j;
      if (fabs(p1 - FOOT) < 4e-3 * FOOT || fabs(p1 - CREST) < 4e-3 * CREST) continue;
      PetscCall(settle(1, &p1, PETSC_FALSE, MANY_ROUNDS, &wanted, &rounds));
      ENSURE(rounds < MANY_ROUNDS);
      PetscCall(settle(1, &p1, PETSC_TRUE, DEFAULT_ROUNDS, &x, &rounds));
      most = PetscMax(most, rounds), n_wrong += fabs(x - wanted) > 1e-3 * wanted;
    }
  ENSURE(n_wrong == 0);
  ENSURE(most < DEFAULT_ROUNDS);
  return 0;
}

/* Six cells in one iteration, on either branch, as p1 of each rises and falls: none takes another along. */
static PetscErrorCode CellsTogether(void)
{
  enum { CELLS = 6 };
  PetscReal x[CELLS] = {0.}, alone[CELLS] = {0.};
  double p1[CELLS];
  int rounds, most = 0, n_wrong = 0;
  for (int k = 0; k < 160; k++) {
    for (int i = 0; i < CELLS; i++) {
      p1[i] = 425e3 + 50e3 * sin(2 * PETSC_PI * k / 80. + i) + 7e3 * i;
      PetscCall(settle(1, p1 + i, PETSC_FALSE, MANY_ROUNDS, alone + i, &rounds));
    }
    PetscCall(settle(CELLS, p1, PETSC_TRUE, DEFAULT_ROUNDS, x, &rounds));
    most = PetscMax(most, rounds);
    for (int i = 0; i < CELLS; i++) n_wrong += fabs(x[i] - alone[i]) > 1e-3 * alone[i];
  }
  ENSURE(n_wrong == 0);
  ENSURE(most < DEFAULT_ROUNDS);
  return 0;
}

/* ---- a rigid dam on its base (W06), 28 pieces */

enum { PIECES = 28 };
static const double LENGTH = 28., WEIGHT = 12909.96e3, ARM = 65. / 7., GW = 9810., STIFF = 20e9;

/* [m] Pressure heads g, (PIECES + 1,), that follow from those, x, that lift a dam behind water of `level`:
   openings of a rigid body on a joint without tension in closed form, apertures, resistances in a row.
   uplift: [N] of x. */
static void dam(double level, const PetscReal *x, PetscReal *g, double *uplift)
{
  const double d = LENGTH / PIECES;
  double lift = 0., turn = 0., way[PIECES + 1] = {0.}, u[2];
  for (int i = 0; i < PIECES; i++) {
    lift += GW * d * (x[i] + x[i + 1]) / 2.;
    turn += GW * d * (d * i * (x[i] + x[i + 1]) / 2. + d * (x[i] + 2. * x[i + 1]) / 6.);
  }
  const double N = WEIGHT - lift, at = (WEIGHT * ARM + GW * pow(level, 3) / 6. - turn) / N, toe = LENGTH - at;
  if (toe < LENGTH / 3.) { // cracked: a triangle over three times the distance to the toe
    const double bears = PetscMax(3. * toe, 0.1);
    u[1] = -2. * N / bears / STIFF, u[0] = u[1] * (1. - LENGTH / bears);
  } else {
    for (int k = 0; k < 2; k++) u[k] = -N / LENGTH / STIFF * (1. + (k ? 6. : -6.) * (at / LENGTH - 0.5));
  }
  for (int i = 0; i < PIECES; i++) {
    double a[2];
    for (int k = 0; k < 2; k++)
      a[k] = PetscClipInterval(1.5e-4 + u[0] + (u[1] - u[0]) * (i + k) / PIECES, 3e-5, 1e-3);
    way[i + 1] = way[i] + (a[0] + a[1]) / (2. * PetscSqr(a[0] * a[1]));
  }
  for (int i = 0; i <= PIECES; i++) g[i] = level * (1. - way[i] / way[PIECES]);
  *uplift = lift;
}

/* The rounds to 1e-10 grow towards the limit level, 38.865 m: of the plain iteration, and with three old
   rounds, as a reference counted them, or one more. Uplift [N] as by Newton's method for the two unknowns
   of a rigid body. */
static PetscErrorCode RigidDam(void)
{
  static const struct {
    double level, uplift;
    int plain, rounds;
  } known[] = {{35, 5231906.751, 6, 4},    {37, 5780044.371, 7, 5},     {38, 6235002.095, 12, 7},
               {38.5, 6640301.283, 19, 7}, {38.8, 7169728.456, 43, 10}, {38.86, 7503397.218, 144, 21}};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
    for (int mixed = 0; mixed < 2; mixed++) {
      const double level = known[k].level;
      const int most = mixed ? known[k].rounds : known[k].plain;
      PetscReal x[PIECES + 1], g[PIECES + 1];
      Mixer mixer = {0};
      double uplift = 0., change = 1.;
      int rounds = 0;
      for (int i = 0; i <= PIECES; i++) x[i] = level * (1. - (double)i / PIECES);
      while (rounds < 1000) {
        dam(level, x, g, &uplift);
        rounds++, change = 0.;
        for (int i = 0; i <= PIECES; i++) change = PetscMax(change, fabs(g[i] - x[i]) / level);
        if (change <= 1e-10) break;
        if (mixed)
          PetscCall(MixerNext(&mixer, PIECES + 1, g, x));
        else
          PetscCall(PetscArraycpy(x, g, PIECES + 1));
      }
      ENSURE_NEAR(uplift, known[k].uplift, 1e-7 * known[k].uplift);
      ENSURE(rounds <= most + mixed && (mixed || rounds >= 0.95 * most));
      PetscCall(MixerReset(&mixer));
    }
  return 0;
}

/* A linear map whose iteration alone diverges: as many old rounds as it has dimensions lead to its fixed
   point. */
static PetscErrorCode Linear(void)
{
  static const double factor[3] = {-5., 0.6, -0.3}, fixed[3] = {2., 3., 5.};
  PetscReal x[3] = {0.}, g[3];
  Mixer mixer = {0};
  int rounds = 0;
  for (; rounds < DEFAULT_ROUNDS; rounds++) {
    double change = 0.;
    for (int i = 0; i < 3; i++) g[i] = fixed[i] + factor[i] * (x[i] - fixed[i]);
    for (int i = 0; i < 3; i++) change = PetscMax(change, fabs(g[i] - x[i]));
    if (change < 1e-9) break;
    PetscCall(MixerNext(&mixer, 3, g, x));
    for (int i = 0; i < 3; i++) ENSURE(x[i] >= 0.);
  }
  for (int i = 0; i < 3; i++) ENSURE_NEAR(x[i], fixed[i], 1e-8);
  ENSURE(rounds <= 8);
  PetscCall(MixerReset(&mixer));
  return 0;
}

/* The first round takes g as it is; another number of unknowns starts again. */
static PetscErrorCode Beginnings(void)
{
  PetscReal x[3] = {1., 2., 3.}, g[3] = {4., 5., 6.};
  Mixer mixer = {0};
  PetscCall(MixerNext(&mixer, 3, g, x));
  ENSURE(x[0] == 4. && x[1] == 5. && x[2] == 6.);
  ENSURE(mixer.n == 3 && mixer.n_old == 1);
  x[0] = 7., x[1] = 8.;
  PetscCall(MixerNext(&mixer, 2, g, x));
  ENSURE(x[0] == 4. && x[1] == 5. && mixer.n == 2 && mixer.n_old == 1);
  PetscCall(MixerReset(&mixer));
  ENSURE(mixer.n == 0 && mixer.n_old == 0 && !mixer.x[0] && !mixer.g[0]);
  return 0;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(CellThatJumps);
  RUN_TEST(CellAtRest);
  RUN_TEST(CellsTogether);
  RUN_TEST(RigidDam);
  RUN_TEST(Linear);
  RUN_TEST(Beginnings);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

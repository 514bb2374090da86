/* Water whose bottom and wall shake: forces on faces against integrals of the rules, the wall that faces
   make, where the water pulls, what is refused. ranks: 1 2 */
#include "water/hydrodynamic.h"
#include "scene_fixture.h"

static Sketch sketch;

/* The pressure of a rule over rho a, written again; n: x of the outward normal. */
static double Rule(const WetWall *wall, double z, double n)
{
  const double H = wall->depth, s = z / H;
  if (wall->rule == HYDRO_WESTERGAARD) return -n * 7. / 8. * sqrt(H * z);
  return (wall->normal[0] < -wall->normal[1] ? 1 : -1) * H * wall->largest / 2 *
         (s * (2 - s) + sqrt(s * (2 - s)));
}

static void ForcesOnAnyFaceAreIntegrals(void)
{
  enum { N = 20000 };
  for (int trial = 0; trial < 60; trial++) {
    const double side = trial % 4 < 2 ? -1 : 1;
    const WetWall wall = {.rule = trial % 2 ? HYDRO_ZANGAR : HYDRO_WESTERGAARD,
                          .level = 3,
                          .depth = 7,
                          .normal = {side < 0 ? -1 : .2, side < 0 ? -.2 : 1},
                          .largest = Uniform(.2, .8)};
    const double x[4] = {Uniform(-3, 3), Uniform(-4, 4), Uniform(-3, 3), Uniform(-4, 4)};
    const double L = hypot(x[2] - x[0], x[3] - x[1]), n[2] = {(x[3] - x[1]) / L, (x[0] - x[2]) / L};
    double expected[4] = {0};
    PetscReal f[4];
    HydrodynamicOnFace(x, &wall, 50, 1.5, f);
    for (int i = 0; i < N; i++) {
      const double s = (i + .5) / N, z = wall.level - (x[1] + s * (x[3] - x[1]));
      for (int k = 0; k < 4 && z > 0; k++)
        expected[k] -= 50 * 1.5 * L / N * Rule(&wall, z, n[0]) * n[k % 2] * (k < 2 ? 1 - s : s);
    }
    for (int k = 0; k < 4; k++) ENSURE_NEAR(f[k], expected[k], 1e-5 * 50 * 1.5 * 7 * L);
  }
}

/* A vertical wall in any number of faces: 7/12 rho a H^2 at 0.4 H from the bottom; zangar: C (1/3 + pi/8). */
static void WallsHaveTheForceOfTheirRule(void)
{
  for (int rule = 0; rule < 2; rule++)
    for (int n = 1; n < 10; n += 4) {
      const double H = 30, a = 981;
      const WetWall wall = {.rule = rule, .level = 5, .depth = H, .normal = {-1, -1}, .largest = .7412};
      double force = 0, moment = 0;
      for (int i = 0; i < n; i++) { // down the left side of a block
        const PetscReal x[4] = {2, 5 - H * i / n, 2, 5 - H * (i + 1) / n};
        PetscReal f[4];
        HydrodynamicOnFace(x, &wall, a, 1, f);
        force += f[0] + f[2], moment += f[0] * (x[1] - 5 + H) + f[2] * (x[3] - 5 + H);
        ENSURE_NEAR(f[1], 0, 0), ENSURE_NEAR(f[3], 0, 0);
      }
      const double expected = rule ? .7412 * (1. / 3. + PETSC_PI / 8.) : 7. / 12.;
      // integrals of q (1 - s): 7/8 (2/3 - 2/5); C/2 (1/4 + 1/3)
      const double arm = rule ? .7412 / 2 * (1. / 4. + 1. / 3.) : 7. / 8. * (2. / 3. - 2. / 5.);
      ENSURE_NEAR(force, expected * a * H * H, 1e-8 * a * H * H);
      ENSURE_NEAR(moment, arm * a * H * H * H, 1e-8 * a * H * H * H);
    }
}

static void WestergaardIsTooMuchOnFacesThatLean(void)
{
  const double lean[] = {-5, 0, 7.5, 15, 30, 45, 60, 80},
               excess[] = {.075, .075, .151, .238, .349, .400, .385, .385};
  for (int i = 0; i < 8; i++) ENSURE_NEAR(WestergaardExcess(lean[i]), excess[i], 1e-3);
}

/* Where 7/8 k sqrt(H z) = z. */
static void WaterPullsDownToSomeDepth(void)
{
  WetWall wall = {.rule = HYDRO_WESTERGAARD, .depth = 20, .normal = {-1, -1}, .largest = .7412};
  ENSURE_NEAR(SuctionDepth(&wall, .3), 0, 0); // presses
  ENSURE_NEAR(SuctionDepth(&wall, -.3), 20 * .2625 * .2625, 1e-12);
  ENSURE_NEAR(SuctionDepth(&wall, -2), 20, 0);
  wall.normal[1] = .5; // some of the faces look downstream
  ENSURE_NEAR(SuctionDepth(&wall, .3), 20 * .13125 * .13125, 1e-12);
  wall.rule = HYDRO_ZANGAR, wall.normal[1] = -1;
  const PetscReal s = SuctionDepth(&wall, -.3) / 20;
  wall.normal[1] = .05; // a wall with a step in it: its water presses all the same
  ENSURE_NEAR(SuctionDepth(&wall, .3), 0, 0);
  ENSURE_NEAR(SuctionDepth(&wall, -.3), 20 * s, 1e-12);
  ENSURE_NEAR(.3 * HydrodynamicPressure(&wall, s), s, 1e-12);
}

/* ---- the wall that faces make */

/* One block with these corners, counter-clockwise; its faces from corner `from` to corner `to` are wet. */
static void Wall(int n, const double *corner, int from, int to)
{
  memset(&sketch, 0, sizeof sketch);
  const int group = SketchGroup(&sketch, "dam", 1);
  for (int i = 0; i + 1 < n / 2; i++) { // slices between the two sides: corners i and n - 1 - i
    const double box[8] = {corner[2 * i],           corner[2 * i + 1],          corner[2 * i + 2],
                           corner[2 * i + 3],       corner[2 * (n - 2 - i)],    corner[2 * (n - 2 - i) + 1],
                           corner[2 * (n - 1 - i)], corner[2 * (n - 1 - i) + 1]};
    const int b = SketchGrid(&sketch, group, box, 1, 1, QUADS);
    if (i >= from && i < to) SketchFace(&sketch, "wet", b, 0);
  }
  SketchBox(&sketch, group, 100, 0, 1, 1); // company for the other rank
}

static PetscErrorCode EnsureWall(const char *keys, double depth, double lean, double largest)
{
  Fixture f;
  WetWall wall;
  PetscFunctionBeginUser;
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                        "materials: {dam: {density: 2400}}\nrelaxation: {allow_floating: true}\n"
                        "joints: {default: {k_n: 1e9, k_s: 1e9, friction: 30}}\n"
                        "loads: {q: {type: pseudo_static, coefficient: [0.1, 0], faces: wet, %s}}\n"
                        "stages: [a: {loads: [q]}]\n",
                        keys));
  PetscCall(WetWallFind(f.model, f.scene->loads, &wall));
  ENSURE_NEAR(wall.depth, depth, 1e-12);
  ENSURE_NEAR(wall.lean, lean, 1e-9);
  ENSURE_NEAR(wall.largest, largest, 1e-12);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FacesMakeOneWall(void)
{
  const double deg = 180 / PETSC_PI;
  // upstream face from the crest down: vertical for 4 m, then 3 m out over 6 m; downstream side straight
  const double broken[] = {0, 10, 0, 6, -3, 0, 9, 0, 9, 6, 9, 10};
  const double low[] = {0, 10, 0, 4, -3, 0, 9, 0, 9, 4, 9, 10};     // vertical for 6 m of 10
  const double overhung[] = {0, 10, 1, 5, 2, 0, 9, 0, 9, 5, 9, 10}; // the foot is behind the crest
  PetscFunctionBeginUser;
  Wall(6, broken, 0, 2);
  PetscCall(EnsureWall("level: 10, rule: zangar", 10, deg * atan(.3), .7412 - .0073 * deg * atan(.3)));
  PetscCall(EnsureWall("level: 12, rule: zangar", 12, deg * atan(.3), .7412 - .0073 * deg * atan(.3)));
  PetscCall(EnsureWall("level: 3, rule: zangar", 3, deg * atan(.5), .7412 - .0073 * deg * atan(.5)));
  PetscCall(
      EnsureWall("level: 10, rule: zangar, bottom: -5", 15, deg * atan(.3), .7412 - .0073 * deg * atan(.3)));
  Wall(6, low, 0, 2);
  PetscCall(EnsureWall("level: 10, rule: zangar", 10, 0, .7412));
  PetscCall(EnsureWall("level: 10", 10, deg * atan(.3), .7412 - .0073 * deg * atan(.3)));
  PetscCall(EnsureWall("level: 8, rule: zangar", 8, 0, .7412));
  PetscCall(
      EnsureWall("level: 7, rule: zangar", 7, deg * atan(3. / 7.), .7412 - .0073 * deg * atan(3. / 7.)));
  Wall(6, overhung, 0, 2);
  PetscCall(EnsureWall("level: 10", 10, -deg * atan(.2), .7412));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WallsThatAreNone(void)
{
  static const struct {
    const char *keys, *refusal;
  } wrong[] = {{"level: -1", "loads.q.level: -1 is not above the lowest point of the faces, 0 [m]"},
               {"level: 0", "loads.q.level: 0 is not above the lowest point of the faces, 0 [m]"},
               {"level: 8, bottom: 1", "loads.q.bottom: 1 is above the lowest point of the faces, 0 [m]"},
               {"level: 10, rule: zangar",
                "loads.q.rule: zangar has no number for faces that overhang the water, "
                "these by 11.3 degrees"}};
  const double overhung[] = {0, 10, 1, 5, 2, 0, 9, 0, 9, 5, 9, 10};
  char yaml[1024];
  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    Wall(6, overhung, 0, 2);
    snprintf(yaml, sizeof yaml,
             "materials: {dam: {density: 2400}}\nrelaxation: {allow_floating: true}\n"
             "joints: {default: {k_n: 1e9, k_s: 1e9, friction: 30}}\n"
             "loads: {q: {type: pseudo_static, coefficient: [0.1, 0], faces: wet, %s}}\nstages: [a: {loads: "
             "[q]}]\n",
             wrong[i].keys);
    PetscCall(EnsureRefused(&sketch, yaml, wrong[i].refusal));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(ForcesOnAnyFaceAreIntegrals);
  RUN_TEST(WallsHaveTheForceOfTheirRule);
  RUN_TEST(WestergaardIsTooMuchOnFacesThatLean);
  RUN_TEST(WaterPullsDownToSomeDepth);
  RUN_TEST(FacesMakeOneWall);
  RUN_TEST(WallsThatAreNone);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

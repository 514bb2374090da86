/* Water that moves with faces: mass matrices of faces against integrals of the rules; what bodies that are
   rigid, that deform, and that hang on each other get of it. The sums are the same on any number of ranks.
   ranks: 1 2 3 */
#include "water/hydrodynamic.h"
#include "scene_fixture.h"

static Sketch sketch;

/* Pressure over rho a_n [m] at a depth, a rule written again. */
static double Length(const WetWall *wall, double z)
{
  const double H = wall->depth, s = z / H;
  if (wall->rule == HYDRO_WESTERGAARD) return 7. / 8. * sqrt(H * z);
  return H * wall->largest / 2 * (s * (2 - s) + sqrt(s * (2 - s))) / cos(wall->lean * PETSC_PI / 180);
}

static void MatricesOfAnyFaceAreIntegrals(void)
{
  enum { N = 20000 };
  for (int trial = 0; trial < 40; trial++) {
    const WetWall wall = {.rule = trial % 2 ? HYDRO_ZANGAR : HYDRO_WESTERGAARD,
                          .level = 3,
                          .depth = 7,
                          .normal = {-1, -.2},
                          .lean = Uniform(0, 50),
                          .largest = Uniform(.2, .8)};
    const double x[4] = {Uniform(-3, 3), Uniform(-4, 4), Uniform(-3, 3), Uniform(-4, 4)};
    const double L = hypot(x[2] - x[0], x[3] - x[1]), n[2] = {(x[3] - x[1]) / L, (x[0] - x[2]) / L};
    double expected[16] = {0};
    PetscReal k[16];
    HydrodynamicMass(x, &wall, 50, k);
    for (int i = 0; i < N; i++) {
      const double s = (i + .5) / N, z = wall.level - (x[1] + s * (x[3] - x[1]));
      for (int a = 0; a < 16 && z > 0; a++) {
        const int row = a / 4, column = a % 4;
        expected[a] += 50 * L / N * Length(&wall, z) * n[row % 2] * n[column % 2] * (row < 2 ? 1 - s : s) *
                       (column < 2 ? 1 - s : s);
      }
    }
    for (int a = 0; a < 16; a++) {
      ENSURE_NEAR(k[a], expected[a], 1e-5 * 50 * 7 * L);
      ENSURE_NEAR(k[a], k[4 * (a % 4) + a / 4], 1e-12 * 50 * 7 * L);
    }
  }
}

static void FacesAboveTheWaterHaveNone(void)
{
  const WetWall wall = {.rule = HYDRO_WESTERGAARD, .level = 3, .depth = 7, .normal = {-1, -1}};
  const PetscReal flat[4] = {1, 3, 0, 3}, above[4] = {1, 5, 0, 3};
  PetscReal k[16];
  HydrodynamicMass(flat, &wall, 50, k);
  for (int a = 0; a < 16; a++) ENSURE_NEAR(k[a], 0, 0);
  HydrodynamicMass(above, &wall, 50, k);
  for (int a = 0; a < 16; a++) ENSURE_NEAR(k[a], 0, 0);
}

/* ---- what vertices and bodies get */

typedef struct {
  const Model *m;
  double mass[2][2], moment; /* of all vertices of this rank; x times elevation */
  int n_whole, n_rows;       /* matrices of both ends, of one vertex */
} Sum;

static PetscErrorCode collect(PetscInt n, const PetscInt *v, const PetscReal *mass, const PetscReal *dashpot,
                              void *context)
{
  Sum *sum = context;
  const Model *m = sum->m;
  PetscFunctionBeginUser;
  ENSURE(dashpot == NULL);
  sum->n_whole += n == 2, sum->n_rows += n == 1 && v[0] < m->mesh.n_owned;
  ENSURE(n == 1 || (v[0] >= m->mesh.n_deformable && v[1] < m->mesh.n_moving &&
                    RigidOfVertex(m, v[0]) == RigidOfVertex(m, v[1])));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n && v[i] < m->mesh.n_moving; j++)
      for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++) {
          const double k = mass[(2 * i + a) * 2 * n + 2 * j + b];
          sum->mass[a][b] += k;
          if (!a && !b) sum->moment += k * m->mesh.X[2 * v[i] + 1];
          ENSURE_NEAR(k, mass[(2 * j + b) * 2 * n + 2 * i + a], 1e-9 * 2e5); // symmetric
        }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A wall of four blocks, wet on its left; `rigid` of them, from the bottom, are rigid. */
static PetscErrorCode EnsureWall(int rigid, int n_whole, int n_rows)
{
  const double corner[8] = {0, 0, 9, 0, 9, 20, 0, 20};
  Fixture f;
  Sum sum = {.m = NULL};
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  const int block = SketchGrid(&sketch, soft, corner, 1, 4, QUADS);
  for (int i = 0; i < 4; i++) {
    if (i < rigid) sketch.group[block + i] = hard;
    SketchFace(&sketch, "wet", block + i, 3);
  }
  SketchBox(&sketch, hard, 100, 0, 1, 1); // company for the other ranks
  SketchBox(&sketch, soft, 200, 0, 1, 1);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                  "materials: {soft: {density: 2400, young: 1e10, poisson: 0.2}, hard: {density: 2400}}\n"
                  "relaxation: {allow_floating: true}\n"
                  "joints: {default: {k_n: 1e9, k_s: 1e9, friction: 30}}\n"
                  "loads: {q: {type: added_mass, faces: wet, level: 18, density: 1100}}\n"
                  "stages: [a: {type: dynamic, loads: [q], duration: 1}]\n"));
  const TermView view = {
      .scene = f.scene, .stage = f.scene->stages, .m = f.model, .contacts = f.contacts, .state = f.state};
  sum.m = f.model;
  PetscCall(TermsInertia(&view, collect, &sum));
  double all[4] = {sum.mass[0][0], sum.mass[0][1], sum.mass[1][1], sum.moment};
  int counts[2] = {sum.n_whole, sum.n_rows};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 4, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT, MPI_SUM, PETSC_COMM_WORLD));
  const double mass = 7. / 12. * 1100 * 18 * 18;
  ENSURE_NEAR(all[0], mass, 1e-9 * mass);
  ENSURE_NEAR(all[1], 0, 0);
  ENSURE_NEAR(all[2], 0, 0);
  ENSURE_NEAR(all[3], mass * .4 * 18, 1e-9 * mass * 18); // lumped rows keep the elevation
  ENSURE(counts[0] == n_whole && counts[1] == n_rows);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BodiesGetAllOfIt(void)
{
  PetscFunctionBeginUser;
  PetscCall(EnsureWall(0, 0, 8));
  PetscCall(EnsureWall(2, 2, 4)); // a face of the third block hangs on the rigid ones
  PetscCall(EnsureWall(4, 4, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Loads without effect are refused, or warned of. */
static PetscErrorCode ScenesThatMakeNoSense(void)
{
  static const struct {
    const char *load, *stages, *refusal;
  } wrong[] = {{"level: 0", "[a: {type: dynamic, loads: [q], duration: 1}]",
                "loads.q.level: 0 is not above the lowest point of the faces, 0 [m]"},
               {"level: 18, bottom: 1", "[a: {type: dynamic, loads: [q], duration: 1}]",
                "loads.q.bottom: 1 is above the lowest point of the faces, 0 [m]"},
               {"level: 18", "[a: {loads: [q]}]",
                "loads.q: added_mass acts in dynamic stages and modes only, and none of these"},
               {"level: 18", "[a: {loads: [q]}, b: {type: dynamic, loads: [], duration: 1}]",
                "loads.q: added_mass acts in dynamic stages and modes only, and none of these lists it"}};
  char yaml[1024];
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  SketchFace(&sketch, "wet", SketchBox(&sketch, SketchGroup(&sketch, "hard", 1), 0, 0, 9, 20), 3);
  SketchBox(&sketch, 0, 100, 0, 1, 1);
  SketchBox(&sketch, 0, 200, 0, 1, 1);
  for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
    snprintf(yaml, sizeof yaml,
             "materials: {hard: {density: 2400}}\nrelaxation: {allow_floating: true}\n"
             "joints: {default: {k_n: 1e9, k_s: 1e9, friction: 30}}\n"
             "loads: {q: {type: added_mass, faces: wet, %s}}\nstages: %s\n",
             wrong[i].load, wrong[i].stages);
    PetscCall(EnsureRefused(&sketch, yaml, wrong[i].refusal));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(MatricesOfAnyFaceAreIntegrals);
  RUN_TEST(FacesAboveTheWaterHaveNone);
  RUN_TEST(BodiesGetAllOfIt);
  RUN_TEST(ScenesThatMakeNoSense);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Loads and supports: water on faces against exact integrals, weights, tractions, and what a support holds.
   The sums are the same on any number of ranks. ranks: 1 2 */
#include "scene_fixture.h"

static Sketch sketch;

/* ---- water on one face */

/* f: end forces of a pressure that is p at the deeper end and falls linearly, to 0 at the fraction w < 1 of
   the length L, or to q at the other end. */
static void ExactWater(double L, double p, double q, double w, double f[2])
{
  if (w < 1) // integrals of p (1 - s/w) N over s = 0..w, N = 1-s and s
    f[0] = L * p * (w / 2 - w * w / 6), f[1] = L * p * w * w / 6;
  else
    f[0] = L * (2 * p + q) / 6, f[1] = L * (p + 2 * q) / 6;
}

static void WaterOnAnyFaceIsExact(void)
{
  for (int trial = 0; trial < 1000; trial++) {
    const double x[4] = {Uniform(-3, 3), Uniform(-3, 3), Uniform(-3, 3), Uniform(-3, 3)};
    const double level = Uniform(-4, 4), gamma = 9810, thickness = 1.3;
    const double L = hypot(x[2] - x[0], x[3] - x[1]), n[2] = {(x[3] - x[1]) / L, (x[0] - x[2]) / L};
    const int deep = x[1] < x[3] ? 0 : 1; // the deeper end
    const double depth[2] = {level - x[2 * deep + 1], level - x[3 - 2 * deep]};
    double part[2] = {0, 0};
    PetscReal f[4];
    WaterOnFace(x, level, gamma, thickness, f);
    if (depth[0] > 0) {
      const double wet = depth[1] >= 0 ? 1 : depth[0] / (depth[0] - depth[1]);
      ExactWater(L, gamma * depth[0], gamma * depth[1], wet, part);
    }
    for (int k = 0; k < 2; k++)
      for (int i = 0; i < 2; i++) { // into the face
        const PetscReal value = f[2 * (k ? 1 - deep : deep) + i];
        ENSURE_NEAR(value, -part[k] * n[i] * thickness, 1e-10 * gamma);
      }
  }
}

static void FacesAtTheWaterLineAreDry(void)
{
  const PetscReal flat[4] = {1, 2, 0, 2}, above[4] = {1, 3, 0, 2};
  PetscReal f[4];
  WaterOnFace(flat, 2, 1, 1, f);
  for (int i = 0; i < 4; i++) ENSURE_NEAR(f[i], 0, 0);
  WaterOnFace(above, 2, 1, 1, f);
  for (int i = 0; i < 4; i++) ENSURE_NEAR(f[i], 0, 0);
  WaterOnFace(flat, 5, 10, 1, f);
  ENSURE_NEAR(f[0] + f[2], 0, 0);
  ENSURE_NEAR(f[1] + f[3], -30, 1e-14); // a top face: downwards
}

/* Archimedes: a tilted box, whole under water or partly, is lifted by what it displaces,
   through the centre of it. */
static void WaterAroundABodyIsItsBuoyancy(void)
{
  for (int trial = 0; trial < 200; trial++) {
    const double angle = Uniform(0, 7), level = trial % 2 ? 5 : Uniform(-1, 1), c = cos(angle),
                 s = sin(angle);
    const double box[8] = {-1, -.5, 1, -.5, 1, .5, -1, .5};
    double X[8], sum[3] = {0, 0, 0}, displaced[2] = {0, 0}; // area, its first moment in x
    for (int k = 0; k < 4; k++)
      X[2 * k] = c * box[2 * k] - s * box[2 * k + 1], X[2 * k + 1] = s * box[2 * k] + c * box[2 * k + 1];
    for (int k = 0; k < 4; k++) {
      const int l = (k + 1) % 4;
      const PetscReal x[4] = {X[2 * k], X[2 * k + 1], X[2 * l], X[2 * l + 1]};
      PetscReal f[4];
      WaterOnFace(x, level, 1, 1, f);
      for (int e = 0; e < 2; e++) {
        for (int i = 0; i < 2; i++) sum[i] += f[2 * e + i];
        sum[2] += x[2 * e] * f[2 * e + 1] - x[2 * e + 1] * f[2 * e];
      }
      // area under the water line, by the depth integrated along the ring (Green): -x dy and -x^2/2 dy
      // clipped
      double from = 0, to = 1;
      const double za = level - x[1], zb = level - x[3];
      if (za < 0 && zb < 0) continue;
      if (za < 0) from = za / (za - zb);
      if (zb < 0) to = za / (za - zb);
      const double xa = x[0] + from * (x[2] - x[0]), xb = x[0] + to * (x[2] - x[0]);
      const double dy = (to - from) * (x[3] - x[1]);
      displaced[0] += 0.5 * (xa + xb) * dy, displaced[1] += (xa * xa + xa * xb + xb * xb) / 6 * dy;
    }
    ENSURE_NEAR(sum[0], 0, 1e-13);
    ENSURE_NEAR(sum[1], displaced[0], 1e-13);
    ENSURE_NEAR(sum[2], displaced[1], 1e-13);
  }
}

/* ---- loads of a model: a macroblock of 4 x 2 cells of 1 m, soft, hard or half of each, triangles or not */

static void Block(int n_hard, SketchShape shape)
{
  const double corner[8] = {0, 0, 4, 0, 4, 2, 0, 2};
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  const int per_cell = shape == TRIANGLES ? 2 : 1, first = SketchGrid(&sketch, soft, corner, 4, 2, shape);
  for (int b = first; b < sketch.n_blocks; b++)
    if (b / per_cell % 4 < n_hard) sketch.group[b] = hard;
  const int last = (int)sketch.n_blocks - per_cell;
  for (int j = 0; j < 2; j++)
    SketchFace(&sketch, "skin", j * 4 * per_cell + per_cell - 1, shape == TRIANGLES ? 2 : 3);
  for (int j = 0; j < 2; j++) SketchFace(&sketch, "skin", (j * 4 + 3) * per_cell, 1);
  for (int i = 0; i < 4; i++)
    SketchFace(&sketch, "skin", last - (3 - i) * per_cell + per_cell - 1, shape == TRIANGLES ? 1 : 2);
  for (int i = 0; i < 4; i++) SketchFace(&sketch, "skin", i * per_cell, 0);
  for (int j = 0; j < 2; j++)
    SketchFace(&sketch, "left", j * 4 * per_cell + per_cell - 1, shape == TRIANGLES ? 2 : 3);
  for (int i = 0; i < 4; i++)
    SketchFace(&sketch, "top", last - (3 - i) * per_cell + per_cell - 1, shape == TRIANGLES ? 1 : 2);
  for (int i = 0; i < 4; i++) SketchFace(&sketch, "bottom", i * per_cell, 0);
  SketchPoint(&sketch, "corner", 14); // (4, 2)
  // company for the other ranks
  SketchBox(&sketch, soft, 10, 0, 1, 1);
  SketchBox(&sketch, hard, 12, 0, 1, 1);
}

static const char materials[] =
    "thickness: 1.5\ngravity: 10\nrelaxation: {allow_floating: true}\n"
    "materials: {soft: {density: 2000, young: 1e9, poisson: 0.2}, hard: {density: 3000}}\n"
    "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30}}\n";

/* Force and moment about (0,0) of applied.target on everything left of x = 9, over all ranks. */
static PetscErrorCode Resultant(const Fixture *f, PetscReal sum[3])
{
  const Model *m = f->model;
  const PetscReal *load = f->state->applied.target;

  PetscFunctionBeginUser;
  sum[0] = sum[1] = sum[2] = 0;
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    const PetscReal *C = m->rigid.X + 2 * b, *F = load + 3 * b;
    if (C[0] > 9) continue;
    sum[0] += F[0], sum[1] += F[1], sum[2] += F[2] + C[0] * F[1] - C[1] * F[0];
  }
  for (PetscInt v = 0; v < m->mesh.n_deformable; v++) {
    const PetscReal *x = m->mesh.X + 2 * v, *F = load + 3 * m->rigid.n + 2 * v;
    if (x[0] > 9) continue;
    sum[0] += F[0], sum[1] += F[1], sum[2] += x[0] * F[1] - x[1] * F[0];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LoadsSumToTheirResultants(void)
{
  PetscFunctionBeginUser;
  for (int n_hard = 0; n_hard <= 4; n_hard += 2)
    for (SketchShape shape = 0; shape < 2; shape++) {
      const double soft = 2000 * 10 * 1.5 * 2 * (4 - n_hard), hard = 3000 * 10 * 1.5 * 2 * n_hard;
      const double weight = soft + hard, at = soft * (4 + n_hard) / 2 + hard * n_hard / 2; // first moment
      const double water = 0.5 * 1000 * 10 * 1.5 * 1.5 * 1.5;
      const double hydro = 7. / 12. * 1000 * 1.5 * 1.5 * 1.5; // over the horizontal inertia
      const double expected[9][3] = {
          {0, -weight, -at},
          {0, -soft, -soft * (4 + n_hard) / 2},
          {water, 0, -water * 0.5},                            // level 1.5
          {4 * 1.5 * 30, -4 * 1.5 * 40, -180. * 2 - 240. * 2}, // on top
          {1.5 * 5, 1.5 * 7, 1.5 * (4 * 7 - 2 * 5)},
          {.2 * weight + 2 * hydro, -.1 * weight, -.2 * weight - .1 * at - 2 * hydro * .6},
          {-.3 * soft, 0, .3 * soft},
          {0, -4 * 1.5 * 6, -4 * 1.5 * 6 * 2.}, // on top
          {0, 0, 0}};                           // all round
      Fixture f;
      Block(n_hard, shape);
      PetscCall(
          FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                      "%sloads: {weight: {type: self_weight}, part: {type: self_weight, groups: [soft]},"
                      " water: {type: reservoir, faces: left, level: 1.5},"
                      " wind: {type: traction, faces: top, value: [30, -40]},"
                      " point: {type: point_force, point: corner, value: [5, 7]},"
                      " quake: {type: pseudo_static, coefficient: [0.2, -0.1], faces: left, level: 1.5},"
                      " back: {type: pseudo_static, coefficient: [-0.3, 0], groups: [soft]},"
                      " gas: {type: pressure, faces: top, pressure: 6},"
                      " round: {type: pressure, faces: skin, pressure: 1e3}}\n"
                      "stages: [a: {loads: [weight]}, b: {loads: [part]}, c: {loads: [water]}, d: {loads: "
                      "[wind]}, e: {loads: [point]}, f: {loads: [quake]}, g: {loads: [back]}, h: {loads: "
                      "[gas]}, i: {loads: "
                      "[round]}]\n",
                      materials));
      for (int s = 0; s < 9; s++) {
        PetscReal sum[3];
        PetscCall(LoadsTarget(f.scene, f.model, f.scene->stages + s, f.state));
        PetscCall(Resultant(&f, sum));
        for (int i = 0; i < 3; i++) ENSURE_NEAR(sum[i], expected[s][i], 1e-9);
      }
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Loads of a stage come over its ramp; what the stage does not name leaves with it. */
static PetscErrorCode RampGoesFromOldLoadsToNew(void)
{
  Fixture f;

  PetscFunctionBeginUser;
  Block(0, QUADS);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                  "%sloads: {a: {type: traction, faces: top, value: [8, 0]}, b: {type: traction, faces: top, "
                  "value: [0, 4]}}\nstages: [a: {loads: [a], ramp: 0}, b: {loads: [b], ramp: 4}]\n",
                  materials));
  const PetscInt v = LocalOfFile(f.model, 12), d = 3 * f.model->rigid.n + 2 * v; // inside the top
  const PetscBool mine = (PetscBool)(v >= 0 && v < f.model->mesh.n_deformable);
  PetscCall(StageStart(&f, 0));
  if (mine) ENSURE_NEAR(f.state->f_ext[d], 12, 1e-12);
  PetscCall(StageStart(&f, 1));
  for (int i = 0; i <= 4; i++) {
    LoadsApply(f.model, f.state, 0.25 * i);
    if (mine) ENSURE_NEAR(f.state->f_ext[d], 12 - 3 * i, 1e-12);
    if (mine) ENSURE_NEAR(f.state->f_ext[d + 1], 1.5 * i, 1e-12);
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- supports */

/* Number of held dofs over all ranks: x, y, rotation of bodies, x and y of deformable vertices. */
static PetscErrorCode EnsureHeld(int n_hard, const char *supports, int body_x, int body_y, int turn, int x,
                                 int y)
{
  Fixture f;
  PetscInt held[5] = {0}, expected[5] = {body_x, body_y, turn, x, y};

  PetscFunctionBeginUser;
  Block(n_hard, QUADS);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                  "%sloads: {weight: {type: self_weight}}\nstages: [a: {loads: [weight]}]\nsupports: {%s}\n",
                  materials, supports));
  const PetscInt at = 3 * f.model->rigid.n;
  for (PetscInt d = 0; d < at; d++) held[d % 3] += Held(f.model, d);
  for (PetscInt d = at; d < f.model->n_dof; d++) held[3 + (d - at) % 2] += Held(f.model, d);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, held, 5, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  for (int i = 0; i < 5; i++) ENSURE(held[i] == expected[i]);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SupportsHoldWhatTheyName(void)
{
  PetscFunctionBeginUser;
  PetscCall(EnsureHeld(0, "bottom: {fix: xy}", 0, 0, 0, 5, 5));
  PetscCall(EnsureHeld(0, "bottom: {fix: y}", 0, 0, 0, 0, 5));
  PetscCall(EnsureHeld(0, "corner: {fix: x}", 0, 0, 0, 1, 0));
  PetscCall(EnsureHeld(0, "bottom: {fix: y}, left: {fix: x}", 0, 0, 0, 3, 5));
  PetscCall(EnsureHeld(4, "bottom: {fix: xy}", 1, 1, 1, 0, 0)); // a rigid body on its base cannot turn
  PetscCall(EnsureHeld(4, "bottom: {fix: y}", 0, 1, 1, 0, 0));
  PetscCall(EnsureHeld(4, "left: {fix: x}", 1, 0, 1, 0, 0));
  PetscCall(EnsureHeld(0, "hard: {fix: x}", 1, 0, 1, 0, 0)); // the rigid box of the company
  PetscCall(EnsureHeld(4, "hard: {fix: xy}", 2, 2, 2, 0, 0));
  PetscCall(EnsureHeld(2, "bottom: {fix: xy}", 1, 1, 1, 2, 2)); // rigid below x = 2, two soft vertices beyond
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A rigid body held at one place would turn about it, which its three dofs cannot say. */
static PetscErrorCode PinOfARigidBodyIsRefused(void)
{
  char yaml[1024];

  PetscFunctionBeginUser;
  static const char *const supports[] = {"corner: {fix: xy}", "corner: {fix: y}", "bottom: {fix: x}",
                                         "left: {fix: y}"};
  for (int i = 0; i < 4; i++) {
    Block(4, QUADS);
    snprintf(yaml, sizeof yaml,
             "%sloads: {weight: {type: self_weight}}\nstages: [a: {loads: [weight]}]\nsupports: {%s}\n",
             materials, supports[i]);
    PetscCall(EnsureRefused(&sketch, yaml, "at one place only"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without allow_floating a body that nothing holds is refused, and named. */
static PetscErrorCode FloatingBodyIsRefused(void)
{
  PetscFunctionBeginUser;
  Block(4, QUADS);
  PetscCall(
      EnsureRefused(&sketch,
                    "materials: {soft: {density: 2000, young: 1e9, poisson: 0.2}, hard: {density: 3000}}\n"
                    "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30}}\nsupports: {hard: {fix: xy}}\n"
                    "loads: {weight: {type: self_weight}}\nstages: [a: {loads: [weight]}]\n",
                    "has no support"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(WaterOnAnyFaceIsExact);
  RUN_TEST(FacesAtTheWaterLineAreDry);
  RUN_TEST(WaterAroundABodyIsItsBuoyancy);
  RUN_TEST(LoadsSumToTheirResultants);
  RUN_TEST(RampGoesFromOldLoadsToNew);
  RUN_TEST(SupportsHoldWhatTheyName);
  RUN_TEST(PinOfARigidBodyIsRefused);
  RUN_TEST(FloatingBodyIsRefused);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Rigid bodies: mass, centre and inertia of polygons and macroblocks, finite rotation without drift, and
   forces that are work-conjugate to the motion. */
#include "scene_fixture.h"

static Sketch sketch;

static PetscErrorCode OpenBodies(Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(FixtureOpen(
      PETSC_COMM_WORLD, &sketch, f,
      "thickness: 2\nrelaxation: {allow_floating: true}\n"
      "materials: {light: {density: 1000}, heavy: {density: 3000}, soft: {density: 500, young: 1e9, "
      "poisson: 0}}\n"
      "joints: {default: {law: elastic, k_n: 1e9, k_s: 1e9}}\n"
      "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Start(int *light, int *heavy, int *soft)
{
  memset(&sketch, 0, sizeof sketch);
  *light = SketchGroup(&sketch, "light", 1), *heavy = SketchGroup(&sketch, "heavy", 1);
  *soft = SketchGroup(&sketch, "soft", 0);
}

/* row of the rigid body at a vertex of the sketch */
static PetscInt BodyOf(const Fixture *f, int vertex)
{
  return RigidOfVertex(f->model, LocalOfFile(f->model, vertex));
}

static void EnsureBody(const Fixture *f, int vertex, double mass, double x, double y, double inertia)
{
  const PetscInt b = BodyOf(f, vertex);
  ENSURE_NEAR(f->model->rigid.mass[2 * b] / mass, 1, 1e-12);
  ENSURE_NEAR(f->model->rigid.mass[2 * b + 1] / inertia, 1, 1e-9);
  ENSURE_NEAR(f->model->rigid.X[2 * b], x, 1e-12 * (1 + fabs(x)));
  ENSURE_NEAR(f->model->rigid.X[2 * b + 1], y, 1e-12 * (1 + fabs(y)));
}

static PetscErrorCode SingleBlocksHaveTheMassOfTheirPolygon(void)
{
  int light, heavy, soft;
  Fixture f;

  PetscFunctionBeginUser;
  Start(&light, &heavy, &soft);
  SketchBox(&sketch, heavy, 1, 2, 3, 4); // vertices 0 to 3
  const int first = SketchVertex(&sketch, 10, 0);
  SketchVertex(&sketch, 16, 0), SketchVertex(&sketch, 10, 3);
  SketchBlock(&sketch, light, first, first + 1, first + 2, -1);
  const double trapezoid[8] = {20, 0, 24, 0, 23, 2, 21, 2};
  SketchGrid(&sketch, light, trapezoid, 1, 1, QUADS);
  SketchBox(&sketch, soft, 30, 0, 1, 1);
  PetscCall(OpenBodies(&f));
  ENSURE(f.model->rigid.n == 3);
  EnsureBody(&f, 0, 3000. * 2 * 12, 2.5, 4, 3000. * 2 * 12 * (9 + 16) / 12);
  // right triangle of legs a, b: I = m (a^2 + b^2) / 18 about its centroid
  EnsureBody(&f, first, 1000. * 2 * 9, 12, 1, 1000. * 2 * 9 * (36 + 9) / 18.);
  // trapezoid of bases 4 and 2, height 2: A = 6, y_c = 8/9, I_x = 52/27, I_y = 5 (two triangles and a box)
  EnsureBody(&f, first + 3, 1000. * 2 * 6, 22, 8. / 9, 1000. * 2 * (52. / 27 + 5));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A box far from the origin, cut in quadrilaterals and triangles of two densities, is the sum of its halves;
   what touches only through a joint is another body. */
static PetscErrorCode MacroblockIsTheSumOfItsBlocks(void)
{
  int light, heavy, soft;
  Fixture f;

  PetscFunctionBeginUser;
  Start(&light, &heavy, &soft);
  const double box[8] = {1000, 500, 1004, 500, 1004, 502, 1000, 502};
  const int first = SketchGrid(&sketch, light, box, 4, 2, TRIANGLES);
  for (int b = 0; b < 16; b++)
    sketch.group[first + b] = b / 2 % 4 < 2 ? light : heavy; // left half, right half
  SketchBox(&sketch, light, 1004, 500, 1, 2);                // vertices from 15 on
  PetscCall(OpenBodies(&f));
  ENSURE(f.model->rigid.n == 2 && f.model->mesh.n_bodies_global == 2);
  ENSURE(BodyOf(&f, 0) == BodyOf(&f, 14) && BodyOf(&f, 0) != BodyOf(&f, 15));
  const double m1 = 1000. * 2 * 4, m2 = 3000. * 2 * 4, x = (m1 * 1001 + m2 * 1003) / (m1 + m2);
  EnsureBody(&f, 0, m1 + m2, x, 501,
             (m1 + m2) * (4 + 4) / 12 + m1 * (x - 1001) * (x - 1001) + m2 * (x - 1003) * (x - 1003));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks of two rigid groups that share one vertex are one body; a deformable block between two rigid ones of
   the same macroblock leaves them two, each with a quarter of its mass at every shared vertex. */
static PetscErrorCode HangingBlocksLeaveTheirLumpedMass(void)
{
  int light, heavy, soft;
  Fixture f;

  PetscFunctionBeginUser;
  Start(&light, &heavy, &soft);
  const double box[8] = {0, 0, 3, 0, 3, 1, 0, 1};
  const int first = SketchGrid(&sketch, soft, box, 3, 1, QUADS);
  sketch.group[first] = heavy, sketch.group[first + 2] = light;
  PetscCall(OpenBodies(&f));
  ENSURE(f.model->rigid.n == 2 && f.model->mesh.n_bodies_global == 1 && f.model->mesh.n_deformable == 0);
  // 2 of 4 corners of the 1000 kg between them: 500 kg at x = 1, half of it above, half below
  const double m = 6000, x = (m * 0.5 + 500 * 1) / (m + 500);
  EnsureBody(&f, 0, m + 500, x, 0.5,
             m * 2 / 12. + m * (x - 0.5) * (x - 0.5) + 500 * ((1 - x) * (1 - x) + 0.25));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OpenIrregularBody(Fixture *f)
{
  int light, heavy, soft;

  PetscFunctionBeginUser;
  Start(&light, &heavy, &soft);
  const double box[8] = {3, 1, 5, 1.5, 5.5, 3, 2.5, 4};
  SketchGrid(&sketch, light, box, 3, 3, TRIANGLES);
  PetscCall(OpenBodies(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 100 turns in 36000 steps: distances between vertices stay, and the last position is the first. */
static PetscErrorCode ShapeIsKeptOver100Turns(void)
{
  Fixture f;
  PetscReal worst = 0, back = 0;

  PetscFunctionBeginUser;
  PetscCall(OpenIrregularBody(&f));
  const Model *m = f.model;
  PetscReal *u = f.state->u, *w = f.u_vertex;
  for (int step = 1; step <= 36000; step++) {
    u[0] += 1e-4, u[1] -= 2e-4, u[2] = step * (2 * PETSC_PI / 360);
    RigidMotion(m, u);
    if (step % 777 && step != 36000) continue;
    for (PetscInt v = 1; v < m->mesh.n_owned; v++) {
      const double x = m->mesh.X[2 * v] - m->mesh.X[0], y = m->mesh.X[2 * v + 1] - m->mesh.X[1];
      worst = PetscMax(worst, fabs(hypot(x + w[2 * v] - w[0], y + w[2 * v + 1] - w[1]) / hypot(x, y) - 1));
    }
  }
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) back = PetscMax(back, fabs(w[i] - u[i % 2]));
  ENSURE(worst < 1e-14);
  ENSURE(back < 1e-12);
  ENSURE_NEAR(u[0], 3.6, 1e-10);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Small rotations keep their digits: u = theta x r to second order. */
static PetscErrorCode SmallRotationsKeepTheirDigits(void)
{
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenIrregularBody(&f));
  const Model *m = f.model;
  const double theta = 1e-9;
  f.state->u[2] = theta;
  RigidMotion(m, f.state->u);
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    const double x = m->mesh.X[2 * v] - m->rigid.X[0], y = m->mesh.X[2 * v + 1] - m->rigid.X[1];
    ENSURE_NEAR(f.u_vertex[2 * v], -theta * y - 0.5 * theta * theta * x, 1e-15 * theta * 4);
    ENSURE_NEAR(f.u_vertex[2 * v + 1], theta * x - 0.5 * theta * theta * y, 1e-15 * theta * 4);
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Small strain: vertices move by theta x r whatever theta is, and forces do their work on that motion. */
static PetscErrorCode SmallStrainIsLinear(void)
{
  const double theta = 0.4;
  PetscReal moment = 0;
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenIrregularBody(&f));
  Model *m = f.model;
  PetscReal *u = f.state->u, *force = f.state->f;
  m->materials.strain = STRAIN_SMALL;
  u[0] = 2, u[1] = -3, u[2] = theta;
  RigidMotion(m, u);
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    const double x = m->mesh.X[2 * v] - m->rigid.X[0], y = m->mesh.X[2 * v + 1] - m->rigid.X[1];
    ENSURE_NEAR(f.u_vertex[2 * v], 2 - theta * y, 1e-14);
    ENSURE_NEAR(f.u_vertex[2 * v + 1], -3 + theta * x, 1e-14);
    force[3 + 2 * v] = Uniform(-1, 1), force[4 + 2 * v] = Uniform(-1, 1);
    moment += x * force[4 + 2 * v] - y * force[3 + 2 * v];
  }
  RigidForces(m, u, force);
  ENSURE_NEAR(force[2], moment, 1e-12);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* (15): the body's forces do the work of the vertices' forces, in any position. */
static PetscErrorCode BodyForcesDoTheWorkOfVertexForces(void)
{
  const double h = 1e-6;
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenIrregularBody(&f));
  const Model *m = f.model;
  PetscReal *u = f.state->u, *force = f.state->f;
  for (int trial = 0; trial < 20; trial++) {
    PetscReal q[3] = {Uniform(-5, 5), Uniform(-5, 5), Uniform(-9, 9)}, work[2];
    for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) force[3 + i] = Uniform(-1, 1);
    PetscCall(PetscArraycpy(u, q, 3));
    RigidMotion(m, u);
    RigidForces(m, u, force);
    for (int d = 0; d < 3; d++) {
      for (int side = 0; side < 2; side++) {
        u[d] = q[d] + (side ? h : -h);
        RigidMotion(m, u);
        work[side] = 0;
        for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) work[side] += force[3 + i] * f.u_vertex[i];
      }
      u[d] = q[d];
      ENSURE_NEAR(force[d], (work[1] - work[0]) / (2 * h), 1e-8);
    }
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(SingleBlocksHaveTheMassOfTheirPolygon);
  RUN_TEST(MacroblockIsTheSumOfItsBlocks);
  RUN_TEST(HangingBlocksLeaveTheirLumpedMass);
  RUN_TEST(ShapeIsKeptOver100Turns);
  RUN_TEST(SmallRotationsKeepTheirDigits);
  RUN_TEST(SmallStrainIsLinear);
  RUN_TEST(BodyForcesDoTheWorkOfVertexForces);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

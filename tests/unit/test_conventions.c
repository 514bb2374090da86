/* The conventions at the top of base.h: signs, directions, units and the layout of arrays. */
#include "scene_fixture.h"

static Sketch sketch;

/* A 2 x 1 m block of a kind on a held rigid one, thickness 1.5 m, joint 1e6 and 5e5 Pa/m. */
static PetscErrorCode OpenTwo(int rigid, const char *law, Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", rigid);
  SketchBox(&sketch, ground, 0, -1, 2, 1);
  const int b = SketchBox(&sketch, block, 0, 0, 2, 1); // vertices 4 to 7
  SketchFace(&sketch, "right", b, 1);
  SketchPoint(&sketch, "corner", 6);
  PetscCall(
      FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                  "thickness: 1.5\ngravity: 10\n"
                  "materials: {ground: {density: 1}, block: {density: 100, young: 1e6, poisson: 0.25}}\n"
                  "joints: {default: {%s, k_n: 1e6, k_s: 5e5}}\nsupports: {ground: {fix: xy}}\n"
                  "loads: {weight: {type: self_weight}, water: {type: reservoir, faces: right, level: 1},"
                  " pull: {type: traction, faces: right, value: [1e3, 2e3]},"
                  " point: {type: point_force, point: corner, value: [100, -50]}}\n"
                  "stages: [w: {loads: [weight], ramp: 0}, r: {loads: [water], ramp: 0}, t: {loads: "
                  "[pull], ramp: 0}, p: {loads: [point], ramp: 0}]\n",
                  law));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves the upper block by (x, y) and evaluates. */
static PetscErrorCode MoveBlock(Fixture *f, double x, double y)
{
  PetscFunctionBeginUser;
  for (int v = 4; v < 8; v++) {
    const PetscInt at = DofOf(f->model, v);
    f->state->u[at] = x, f->state->u[at + 1] = y;
  }
  RigidMotion(f->model, f->state->u);
  PetscCall(Forces(f->scene, f->model, f->scene->joints, f->contacts, f->state, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* sum over the dofs of the upper block */
static PetscReal OnBlock(const Fixture *f, const PetscReal *force, int i)
{
  if (f->model->mesh.n_deformable == 0) return force[DofOf(f->model, 4) + i];
  PetscReal sum = 0;
  for (int v = 4; v < 8; v++) sum += force[DofOf(f->model, v) + i];
  return sum;
}

/* u_n > 0 and tension > 0 when the faces part; f resists: it is what has to be applied to
   hold the block there. */
static PetscErrorCode OpeningAndTensionArePositive(void)
{
  PetscFunctionBeginUser;
  for (int rigid = 0; rigid < 2; rigid++)
    for (int up = -1; up <= 1; up += 2) {
      Fixture f;
      PetscCall(OpenTwo(rigid, "law: elastic", &f));
      PetscCall(MoveBlock(&f, 0, up * 1e-3));
      for (int k = 0; k < 2; k++) {
        ENSURE_NEAR(f.contacts->u_n[SUB(0, k)], up * 1e-3, 1e-15);
        ENSURE_NEAR(f.contacts->sigma[SUB(0, k)], up * 1e3, 1e-9);
      }
      ENSURE_NEAR(OnBlock(&f, f.state->f, 1), up * 1e3 * 2 * 1.5, 1e-8);
      ENSURE_NEAR(OnBlock(&f, f.state->f, 0), 0, 1e-8);
      PetscCall(FixtureClose(&f));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u_s grows when P moves along A to B of its destination face; the force on the block resists. */
static PetscErrorCode SlidingIsPositiveAlongTheDestinationFace(void)
{
  PetscFunctionBeginUser;
  for (int rigid = 0; rigid < 2; rigid++) {
    Fixture f;
    PetscCall(OpenTwo(rigid, "law: elastic", &f));
    PetscCall(MoveBlock(&f, 1e-3, 0));
    for (int k = 0; k < 2; k++) {
      PetscInt v[3];
      ContactEndVertices(f.contacts, 0, k, v);
      const PetscInt P = v[0], A = v[1], B = v[2];
      const double along = f.model->mesh.X[2 * B] > f.model->mesh.X[2 * A] ? 1 : -1;
      const double moved = f.u_vertex[2 * P] - f.u_vertex[2 * A];
      ENSURE_NEAR(f.contacts->u_s[SUB(0, k)], along * moved, 1e-15);
      ENSURE_NEAR(f.contacts->tau[SUB(0, k)], 5e5 * along * moved, 1e-9);
    }
    ENSURE_NEAR(OnBlock(&f, f.state->f, 0), 5e5 * 1e-3 * 2 * 1.5, 1e-8);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* With f alone the block goes back: r = f_ext - f. */
static PetscErrorCode ResistingForceDrivesTheBlockBack(void)
{
  PetscFunctionBeginUser;
  for (int rigid = 0; rigid < 2; rigid++) {
    Fixture f;
    PetscCall(OpenTwo(rigid, "law: elastic", &f));
    PetscCall(ScaledMasses(f.scene, f.model, f.scene->joints, f.contacts, f.state));
    PetscCall(MoveBlock(&f, 0, 1e-3));
    PetscCall(Step(f.scene, f.model, f.scene->joints, f.contacts, f.state, &f.relax->damping, NULL));
    ENSURE(OnBlock(&f, f.state->v, 1) < 0);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stretched block: tension positive, f = + int B'sigma points outwards at both ends. */
static PetscErrorCode StretchedBlockHasPositiveStress(void)
{
  PetscReal stress[3];
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenTwo(0, "friction: 30", &f));
  for (int v = 4; v < 8; v++) f.state->u[DofOf(f.model, v)] = 1e-4 * sketch.X[2 * v];
  PetscCall(Forces(f.scene, f.model, f.scene->joints, f.contacts, f.state, NULL));
  PetscCall(ElementStress(f.model, &f.model->mesh.q4, 4, f.u_vertex, stress));
  ENSURE(stress[0] > 100 && stress[1] > 0); // plane strain, poisson 0.25
  ENSURE(f.state->f[DofOf(f.model, 6)] < 0 && f.state->f[DofOf(f.model, 7)] > 0); // left, right
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks run counter-clockwise, so the outward normal is to the right of each face: out
   of the block's middle. */
static PetscErrorCode OutwardNormalIsToTheRightOfAFace(void)
{
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenTwo(0, "law: elastic", &f));
  const Faces *faces = &f.model->faces;
  ENSURE(faces->n == 8);
  for (PetscInt i = 0; i < faces->n; i++) {
    const PetscReal *a = f.model->mesh.X + 2 * faces->vertex[2 * i],
                    *b = f.model->mesh.X + 2 * faces->vertex[2 * i + 1];
    const PetscReal n[2] = {b[1] - a[1], a[0] - b[0]};
    const PetscReal middle[2] = {1, f.model->mesh.vertex_file[faces->vertex[2 * i]] < 4 ? -0.5 : 0.5};
    ENSURE(n[0] * (a[0] - middle[0]) + n[1] * (a[1] - middle[1]) > 0);
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Weight acts in -y, water into its face, traction and point force along their values; all per
   metre times thickness. */
static PetscErrorCode LoadsPointWhereTheyShould(void)
{
  static const double expected[4][2] = {
      {0, -100. * 10 * 2 * 1.5}, {-0.5 * 1000 * 10 * 1.5, 0}, {1e3 * 1.5, 2e3 * 1.5}, {100 * 1.5, -50 * 1.5}};

  PetscFunctionBeginUser;
  for (int rigid = 0; rigid < 2; rigid++) {
    Fixture f;
    PetscCall(OpenTwo(rigid, "friction: 30", &f));
    for (int s = 0; s < 4; s++) {
      PetscCall(StageStart(&f, s));
      for (int i = 0; i < 2; i++) ENSURE_NEAR(OnBlock(&f, f.state->f_ext, i), expected[s][i], 1e-9);
    }
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Three dofs per body first, then two per deformable vertex: u_vertex = u + 3 n_bodies.
   Rotation counter-clockwise. */
static PetscErrorCode DofsOfBodiesComeFirst(void)
{
  Fixture f;

  PetscFunctionBeginUser;
  PetscCall(OpenTwo(0, "friction: 30", &f));
  const Model *m = f.model;
  ENSURE(m->rigid.n == 1 && m->mesh.n_deformable == 4 && m->n_dof == 3 + 8 && m->mesh.n_vertices == 8);
  for (int v = 4; v < 8; v++) ENSURE(DofOf(m, v) == 3 + 2 * LocalOfFile(m, v));
  for (int i = 0; i < 3; i++) ENSURE(Held(m, i));
  for (int i = 3; i < 11; i++) ENSURE(!Held(m, i));
  f.state->u[2] = 0.5 * PETSC_PI;
  RigidMotion(m, f.state->u);
  const PetscInt v = LocalOfFile(m, 1); // (2, -1) about (1, -0.5): to (1.5, 0.5)
  ENSURE_NEAR(m->mesh.X[2 * v] + f.u_vertex[2 * v], 1.5, 1e-15);
  ENSURE_NEAR(m->mesh.X[2 * v + 1] + f.u_vertex[2 * v + 1], 0.5, 1e-15);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void SubContactsOfABatchStandSideBySide(void)
{
  PetscBool seen[4 * BATCH] = {PETSC_FALSE};
  ENSURE(SUB(0, 0) == 0 && SUB(0, 1) == BATCH && SUB(1, 0) == 1 && SUB(BATCH, 0) == 2 * BATCH);
  for (int c = 0; c < 2 * BATCH; c++)
    for (int k = 0; k < 2; k++) {
      ENSURE(!seen[SUB(c, k)]);
      seen[SUB(c, k)] = PETSC_TRUE;
    }
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(OpeningAndTensionArePositive);
  RUN_TEST(SlidingIsPositiveAlongTheDestinationFace);
  RUN_TEST(ResistingForceDrivesTheBlockBack);
  RUN_TEST(StretchedBlockHasPositiveStress);
  RUN_TEST(OutwardNormalIsToTheRightOfAFace);
  RUN_TEST(LoadsPointWhereTheyShould);
  RUN_TEST(DofsOfBodiesComeFirst);
  RUN_TEST(SubContactsOfABatchStandSideBySide);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Condensed bodies. Rigid motions give no force and carry the inside along. Loads that are passed on keep
   their resultant. The recovered inside is in equilibrium; how far a body has turned is known without it.
   Motion between condensed, rigid and deformable bodies does not grow, for any stiffness of the joints.
   ranks: 1 2 */
#include "scene_fixture.h"

static Sketch sketch;

/* Ground, a condensed wall of 4 by 4 quadrilaterals, a condensed one of triangles beside it, a rigid block
   and a deformable one on top, all turned. */
static PetscErrorCode OpenWalls(Fixture *f)
{
  const double left[8] = {0, 0, 2, 0, 2, 2, 0, 2}, right[8] = {2, 0, 4.5, 0, 4, 2, 2, 2};
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int hard = SketchGroup(&sketch, "hard", 1), stone = SketchGroup(&sketch, "stone", 0),
            soft = SketchGroup(&sketch, "soft", 0);
  SketchBox(&sketch, hard, -1, -1, 7, 1);
  SketchGrid(&sketch, stone, left, 4, 4, QUADS);
  SketchGrid(&sketch, stone, right, 5, 4, TRIANGLES);
  SketchBox(&sketch, hard, 0.5, 2, 1, 1);
  SketchBox(&sketch, soft, 2.5, 2, 1, 1);
  SketchMove(&sketch, 0, 0.4, 20, -7);
  PetscCall(FixtureOpen(
      PETSC_COMM_WORLD, &sketch, f,
      "strain: small\nthickness: 1.5\nrelaxation: {damping: none, allow_floating: true}\n"
      "materials: {hard: {density: 2400, rigid: true}, soft: {density: 2400, young: 1e10, poisson: 0.2},\n"
      "  stone: {density: 2400, young: 1e10, poisson: 0.2, condensed: true}}\n"
      "joints: {default: {law: elastic, k_n: 1e10, k_s: 3e9}}\n"
      "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertex arrays: two forces, both zero at first. */
static PetscErrorCode Arrays(const Model *m, PetscReal **a, PetscReal **b)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(2 * (m->mesh.n_vertices + DUMMY_VERTICES), a,
                         2 * (m->mesh.n_vertices + DUMMY_VERTICES), b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RigidMotionsCostNothing(void)
{
  static const PetscReal motion[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; // x, y, rotation about (20,-7)
  Fixture f;
  PetscReal *u, *force;
  PetscFunctionBeginUser;
  PetscCall(OpenWalls(&f));
  const Model *m = f.model;
  PetscCall(Arrays(m, &u, &force));
  for (int k = 0; k < 3; k++) {
    PetscCall(PetscArrayzero(force, 2 * m->mesh.n_owned));
    for (PetscInt d = 0; d < 2 * m->mesh.n_moving; d++) {
      const PetscReal *X = m->mesh.X + 2 * (d / 2);
      u[d] = motion[k][d % 2] + motion[k][2] * (d % 2 ? X[0] - 20 : -(X[1] + 7));
    }
    PetscCall(Condensed_term.forces(NULL, &(Instant){.m = m, .u = u}, force));
    for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) ENSURE(PetscAbsReal(force[d]) < 1e-12 * 1e10 * 5);
    PetscCall(CondensedInner(m, NULL, u));
    for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++) {
      const PetscReal *X = m->mesh.X + 2 * (d / 2);
      ENSURE_NEAR(u[d], motion[k][d % 2] + motion[k][2] * (d % 2 ? X[0] - 20 : -(X[1] + 7)), 1e-11);
    }
  }
  PetscCall(PetscFree2(u, force));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Resultant and moment about (20,-7) of forces at vertices [from, to). */
static void Resultant(const Model *m, const PetscReal *force, PetscInt from, PetscInt to, PetscReal sum[3])
{
  for (PetscInt v = from; v < to; v++) {
    sum[0] += force[2 * v], sum[1] += force[2 * v + 1];
    sum[2] += (m->mesh.X[2 * v] - 20) * force[2 * v + 1] - (m->mesh.X[2 * v + 1] + 7) * force[2 * v];
  }
}

static PetscErrorCode LoadsInsideKeepTheirResultant(void)
{
  Fixture f;
  PetscReal *load, *unused, inside[3] = {0}, passed[3] = {0};
  PetscInt n_inner;
  PetscFunctionBeginUser;
  PetscCall(OpenWalls(&f));
  const Model *m = f.model;
  PetscCall(Arrays(m, &load, &unused));
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++) load[d] = Uniform(-1, 1);
  Resultant(m, load, m->mesh.n_moving, m->mesh.n_owned, inside);
  PetscCall(CondensedLoads(m, load));
  Resultant(m, load, 0, m->mesh.n_moving, passed);
  for (int i = 0; i < 3; i++) ENSURE_NEAR(passed[i], inside[i], 1e-10);
  n_inner = m->mesh.n_owned - m->mesh.n_moving;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n_inner, 1, MPIU_INT, MPI_SUM, m->comm));
  ENSURE(n_inner > 20);
  PetscCall(PetscFree2(load, unused));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At any kept displacements the blocks resist inside with the load there. */
static PetscErrorCode TheInsideIsInEquilibrium(void)
{
  Fixture f;
  PetscReal *u, *load, *force, *unused;
  PetscFunctionBeginUser;
  PetscCall(OpenWalls(&f));
  const Model *m = f.model;
  PetscCall(Arrays(m, &u, &load));
  PetscCall(Arrays(m, &force, &unused));
  for (PetscInt d = 0; d < 2 * m->mesh.n_moving; d++) u[d] = 1e-4 * Uniform(-1, 1);
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++) load[d] = 1e5 * Uniform(-1, 1);
  PetscCall(CondensedInner(m, load, u));
  ElementForcesCondensed(m, u, force);
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++)
    ENSURE_NEAR(force[d], load[d], 1e-12 * 1e10 * 1e-2);
  PetscCall(PetscFree2(u, load));
  PetscCall(PetscFree2(force, unused));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Body `number` of the whole, from displacements and forces of all its vertices: [rad] its mean rotation,
   [-] root mean square of its strain. */
static void MotionOfBody(const Model *m, PetscInt number, const PetscReal *u, const PetscReal *force,
                         PetscReal *theta, PetscReal *strain)
{
  PetscReal n = 0, X[2] = {0, 0}, turn = 0, arm = 0, energy = 0, modulus = 0;
  for (int pass = 0; pass < 2; pass++)
    for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
      if (m->mesh.vertex_condensed[v] != number) continue;
      const PetscReal x = m->mesh.X[2 * v] - X[0] / n, y = m->mesh.X[2 * v + 1] - X[1] / n;
      if (!pass)
        n += 1, X[0] += m->mesh.X[2 * v], X[1] += m->mesh.X[2 * v + 1];
      else
        turn += x * u[2 * v + 1] - y * u[2 * v], arm += x * x + y * y,
            energy += 0.5 * (u[2 * v] * force[2 * v] + u[2 * v + 1] * force[2 * v + 1]);
    }
  const Elements *lists[2] = {&m->mesh.condensed_q4, &m->mesh.condensed_t3};
  for (int l = 0; l < 2; l++)
    for (PetscInt e = 0; e < lists[l]->n; e++) {
      PetscInt vertex[4];
      PetscReal area, centroid[2], polar;
      for (int k = 0; k < lists[l]->n_nodes; k++) vertex[k] = VertexOf(lists[l], e, k);
      if (m->mesh.vertex_condensed[vertex[0]] != number) continue;
      BlockGeometry(m->mesh.X, vertex, lists[l]->n_nodes, &area, centroid, &polar);
      const Lame lame = m->materials.lame[lists[l]->group[e]];
      modulus += (lame.lambda + 2 * lame.mu) * area * m->materials.thickness;
    }
  *theta = turn / arm, *strain = PetscSqrtReal(2 * energy / modulus);
}

/* CondensedMayTurn says so from half of what is refused on, in any state of strain, and sooner where it does
   not know what the loads inside store. */
static PetscErrorCode TurningIsSeenFromOutside(void)
{
  Fixture f;
  PetscReal *force, *load;
  PetscInt seen = 0;
  PetscFunctionBeginUser;
  PetscCall(OpenWalls(&f));
  const Model *m = f.model;
  State *s = f.state;
  PetscReal *u = f.u_vertex, *inside = s->f_ext + 3 * m->rigid.n;
  f.scene->strain = STRAIN_LARGE;
  for (PetscInt b = 0; b < m->condensed.n; b++) {
    const Condensed *c = m->condensed.body + b;
    PetscCall(Arrays(m, &force, &load));
    PetscCall(PetscArrayzero(u, 2 * m->mesh.n_owned));
    PetscCall(PetscArrayzero(inside, 2 * m->mesh.n_owned));
    for (PetscInt i = 0; i < c->n_kept; i++) u[c->kept[i]] = 1e-4 * Uniform(-1, 1);
    for (PetscInt i = 0; i < c->n_inner; i++) load[c->inner[i]] = inside[c->inner[i]] = 1e6 * Uniform(-1, 1);
    PetscCall(CondensedLoads(m, load));
    PetscCall(CondensedInner(m, inside, u));
    ElementForcesCondensed(m, u, force);
    PetscReal theta, strain, turned = 0;
    MotionOfBody(m, c->number, u, force, &theta, &strain);
    for (int k = 0; k < 4; k++) { // just below, just above; both again without what is stored
      const PetscReal target = PetscSqrtReal(2 * 0.005 * strain) * (k % 2 ? 1 + 1e-6 : 1 - 1e-6),
                      more = target - theta - turned;
      PetscBool may;
      for (PetscInt i = 0; i < c->n_kept; i++) {
        const PetscReal *X = m->mesh.X + 2 * (c->kept[i] / 2);
        u[c->kept[i]] += more * (c->kept[i] % 2 ? X[0] - 20 : -(X[1] + 7));
      }
      turned += more;
      if (k == 2) c->load[0] += 1.;
      PetscCall(CondensedMayTurn(f.scene, m, s, &may));
      ENSURE(may == (PetscBool)(k > 0));
    }
    seen++;
    PetscCall(PetscFree2(force, load));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &seen, 1, MPIU_INT, MPI_SUM, m->comm));
  ENSURE(seen == 2);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* As in test_masses.c: the kinetic energy stays below the first one over 1 - safety^2. */
static PetscErrorCode UndampedMotionDoesNotGrow(void)
{
  static const PetscReal ratio[] = {0, 0.3, 1};
  Fixture f;
  PetscFunctionBeginUser;
  PetscCall(OpenWalls(&f));
  State *s = f.state;
  for (int i = 0; i < 6; i++) {
    PetscReal energy[2] = {0., 0.}; // first, now
    PetscBool stays = PETSC_TRUE;
    f.scene->joints[0].k_n = 1e8 * PetscPowRealInt(10., i);
    f.scene->joints[0].k_s = ratio[i % 3] * f.scene->joints[0].k_n;
    PetscCall(ScaledMasses(f.scene, f.model, f.scene->joints, f.contacts, s));
    for (PetscInt d = 0; d < f.model->n_dof; d++) s->u[d] = s->f_ext[d] = 0., s->v[d] = 1e-9 * Uniform(-1, 1);
    RigidMotion(f.model, s->u);
    PetscCall(GhostBegin(f.model, f.u_vertex));
    PetscCall(GhostEnd(f.model, f.u_vertex));
    for (int step = 0; step < 2000 && stays; step++) {
      energy[1] = 0.;
      for (PetscInt d = 0; d < f.model->n_dof; d++) energy[1] += s->m[d] * s->v[d] * s->v[d];
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy + 1, 1, MPIU_REAL, MPI_SUM, f.model->comm));
      if (!step) energy[0] = energy[1];
      stays = (PetscBool)(energy[1] <= energy[0] * (1 + 1e-3) / (1 - f.scene->safety * f.scene->safety));
      PetscCall(Step(f.scene, f.model, f.scene->joints, f.contacts, s, &f.relax->damping, NULL));
    }
    ENSURE(stays);
  }
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Uplift in a joint between a condensed wall and a deformable one, in large strain, both faces moved alike
   by a few degrees: it has neither resultant nor moment, because water in a joint presses on both of its
   sides. */
static PetscErrorCode UpliftOnACondensedFaceGoesAlong(void)
{
  const double low[8] = {0, 0, 4, 0, 4, 2, 0, 2}, high[8] = {0, 2, 4, 2, 3, 5, 1, 5}, angle = 0.05;
  PetscReal sum[4] = {0}; // resultant, moment, size
  Fixture f;
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), stone = SketchGroup(&sketch, "stone", 0);
  const int below = SketchGrid(&sketch, soft, low, 4, 2, QUADS);
  SketchGrid(&sketch, stone, high, 4, 3, QUADS);
  for (int i = 0; i < 4; i++) SketchFace(&sketch, "joint", below + 4 + i, 2);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f,
                        "strain: large\nrelaxation: {allow_floating: true}\n"
                        "materials: {soft: {density: 2400, young: 1e10, poisson: 0.2},\n"
                        "  stone: {density: 2400, young: 1e10, poisson: 0.2, condensed: true}}\n"
                        "joints: {joint: {k_n: 1e10, k_s: 3e9, friction: 45}}\n"
                        "loads: {up: {type: uplift, faces: joint, level: 20, tailwater: 5}}\n"
                        "stages: [all: {loads: [up]}]\n"));
  const Model *m = f.model;
  PetscReal *force, *unused;
  PetscCall(Arrays(m, &force, &unused));
  for (PetscInt v = 0; v < m->mesh.n_vertices; v++) {
    f.u_vertex[2 * v] = (cos(angle) - 1) * m->mesh.X[2 * v] - sin(angle) * m->mesh.X[2 * v + 1];
    f.u_vertex[2 * v + 1] = sin(angle) * m->mesh.X[2 * v] + (cos(angle) - 1) * m->mesh.X[2 * v + 1];
  }
  const TermView view = {.scene = f.scene, .stage = f.scene->stages, .m = m, .state = f.state};
  PetscCall(TermApplied(&view, 0, force));
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d += 2) {
    const PetscReal x = m->mesh.X[d] + f.u_vertex[d], y = m->mesh.X[d + 1] + f.u_vertex[d + 1];
    sum[0] += force[d], sum[1] += force[d + 1], sum[2] += x * force[d + 1] - y * force[d];
    sum[3] += PetscHypotReal(force[d], force[d + 1]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_REAL, MPI_SUM, m->comm));
  for (int i = 0; i < 3; i++) ENSURE_NEAR(sum[i], 0, 1e-9 * sum[3]);
  ENSURE_NEAR(sum[3], 2 * 4 * 0.5 * (18 + 3) * 1e3 * 9.81, 1e-6 * sum[3]);
  PetscCall(PetscFree2(force, unused));
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(RigidMotionsCostNothing);
  RUN_TEST(LoadsInsideKeepTheirResultant);
  RUN_TEST(TheInsideIsInEquilibrium);
  RUN_TEST(TurningIsSeenFromOutside);
  RUN_TEST(UndampedMotionDoesNotGrow);
  RUN_TEST(UpliftOnACondensedFaceGoesAlong);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

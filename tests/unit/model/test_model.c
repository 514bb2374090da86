/* The model of each rank: walls of macroblocks of every kind, complete and consistent on any number of ranks,
   and the same bits as the serial twin of the same mesh.
   ranks: 1 2 4 */
#include "scene_fixture.h"
#include "validity.h"

typedef enum { WALL_QUADS, WALL_TRIANGLES, WALL_RIGID, WALL_MIXED, WALL_SHARED, WALLS } WallKind;
enum { ROWS = 3, COLUMNS = 4, CELLS = 2 };
static const double DENSITY = 2000, RIGID_DENSITY = 3000, THICKNESS = 1.5;

static Sketch sketch;

static const char scene[] = "gravity: 10\n"
                            "thickness: 1.5\n"
                            "materials: {soft: {density: 2000, young: 1e9, poisson: 0.2},"
                            " hard: {density: 3000, rigid: true}}\n"
                            "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30}}\n"
                            "supports: {base: {fix: xy}}\n"
                            "loads: {weight: {type: self_weight}, push: {type: traction, faces: side, "
                            "value: [2e4, 0]}, tip: {type: point_force, point: crest, value: [0, -1e3]}}\n"
                            "stages: [all: {loads: [weight, push, tip], ramp: 100}]\n";

/* ROWS x COLUMNS macroblocks of 2 x 1 m in running bond, each of CELLS x CELLS cells */
static void Wall(WallKind kind)
{
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0), hard = SketchGroup(&sketch, "hard", 1);
  for (int j = 0; j < ROWS; j++)
    for (int i = 0; i < COLUMNS; i++) {
      const double x = 2 * i + 0.7 * (j % 2), corner[8] = {x, j, x + 2, j, x + 2, j + 1, x, j + 1};
      const int rigid = kind == WALL_RIGID || (kind == WALL_MIXED && (i + j) % 2);
      const SketchShape shape = kind == WALL_TRIANGLES || (kind == WALL_SHARED && i % 2) ? TRIANGLES : QUADS;
      const int first = SketchGrid(&sketch, rigid ? hard : soft, corner, CELLS, CELLS, shape);
      // the lower cells of a shared macroblock are rigid, the upper ones hang on them
      const int per_row = CELLS * (shape == TRIANGLES ? 2 : 1);
      for (int b = first; kind == WALL_SHARED && b < first + per_row; b++) sketch.group[b] = hard;
      for (int k = 0; k < CELLS && j == 0; k++)
        SketchFace(&sketch, "base", first + (shape == TRIANGLES ? 2 : 1) * k, 0);
      if (i == 0 && j > 0 && shape == QUADS) SketchFace(&sketch, "side", first, 3);
      if (i == 0 && j > 0 && shape == TRIANGLES) SketchFace(&sketch, "side", first + 1, 2);
    }
  SketchPoint(&sketch, "crest", (int)sketch.n_vertices - 1);
  SketchPoint(&sketch, "foot", 0);
}

static PetscReal Total(PetscReal mine)
{
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  return mine;
}

static PetscErrorCode EnsureOwnedOnce(const Fixture *f, WallKind kind)
{
  const Model *m = f->model;
  const PetscInt n_rigid = kind == WALL_RIGID || kind == WALL_SHARED ? ROWS * COLUMNS
                           : kind == WALL_MIXED                      ? ROWS * COLUMNS / 2
                                                                     : 0;
  PetscBool valid;

  PetscFunctionBeginUser;
  PetscCall(ModelIsValid(m, &valid));
  ENSURE(valid);
  PetscCall(ContactsIsValid(m, f->contacts, &valid));
  ENSURE(valid);
  ENSURE(m->mesh.n_vertices_global == sketch.n_vertices && m->mesh.n_blocks_global == sketch.n_blocks);
  ENSURE(m->mesh.n_bodies_global == ROWS * COLUMNS && m->mesh.n_rigid_global == n_rigid);
  ENSURE_NEAR(Total(m->mesh.n_owned), sketch.n_vertices, 0);
  ENSURE_NEAR(Total(m->rigid.n), n_rigid, 0);
  ENSURE(m->n_dof == 3 * m->rigid.n + 2 * m->mesh.n_deformable);
  for (PetscInt v = 0; v < m->mesh.n_vertices; v++)
    for (int i = 0; i < 2; i++) ENSURE(m->mesh.X[2 * v + i] == sketch.X[2 * m->mesh.vertex_file[v] + i]);
  for (PetscInt v = 1; v < m->mesh.n_deformable; v++)
    ENSURE(m->mesh.vertex_gid[v] > m->mesh.vertex_gid[v - 1]);
  for (PetscInt v = m->mesh.n_owned + 1; v < m->mesh.n_vertices;
       v++) // those of elements, then those of contacts
    ENSURE(m->mesh.vertex_gid[v] > m->mesh.vertex_gid[v - 1] || v == m->mesh.n_owned + m->ghosts.n_element);
  for (PetscInt v = m->mesh.n_owned; v < m->mesh.n_vertices; v++)
    ENSURE(LocalOfFile(m, m->mesh.vertex_file[v]) == v); // each once
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WallsOfAllKindsAreOwnedOnce(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f;
    Wall(kind);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", scene));
    PetscCall(EnsureOwnedOnce(&f, kind));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MassesSumToDensityTimesArea(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f;
    PetscReal mass[2] = {0, 0};
    Wall(kind);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", scene));
    const Model *m = f.model;
    for (PetscInt b = 0; b < m->rigid.n; b++)
      for (int i = 0; i < 2; i++) mass[i] += DofMass(m, 3 * b + i);
    for (PetscInt d = 0; d < 2 * m->mesh.n_deformable; d++) mass[d % 2] += DofMass(m, 3 * m->rigid.n + d);
    const double hard = kind == WALL_RIGID ? 1 : kind == WALL_MIXED || kind == WALL_SHARED ? 0.5 : 0;
    const double expected = ROWS * COLUMNS * 2 * THICKNESS * (hard * RIGID_DENSITY + (1 - hard) * DENSITY);
    for (int i = 0; i < 2; i++) ENSURE_NEAR(Total(mass[i]) / expected, 1, 1e-13);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GhostsReceiveWhatTheirOwnersHold(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f;
    Wall(kind);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", scene));
    const Model *m = f.model;
    PetscReal *u = f.u_vertex;
    for (PetscInt i = 0; i < 2 * (m->mesh.n_vertices + DUMMY_VERTICES); i++) u[i] = -1;
    for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) u[i] = 2 * m->mesh.vertex_gid[i / 2] + 0.5 * (i % 2);
    PetscCall(GhostBegin(m, u));
    PetscCall(GhostEnd(m, u));
    for (PetscInt i = 0; i < 2 * m->mesh.n_vertices; i++)
      ENSURE(u[i] == 2 * m->mesh.vertex_gid[i / 2] + 0.5 * (i % 2));
    for (PetscInt i = 2 * m->mesh.n_vertices; i < 2 * (m->mesh.n_vertices + DUMMY_VERTICES); i++)
      ENSURE(u[i] == -1);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nothing is exchanged before a cycle: the one before has seen to it. */
static PetscErrorCode GhostsHoldWhatTheirOwnersHoldAfterACycle(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f;
    PetscReal *held, moved = 0.;
    Wall(kind);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", scene));
    const Model *m = f.model;
    PetscCall(PetscMalloc1(2 * m->mesh.n_vertices, &held));
    PetscCall(LoadsTarget(f.scene, m, f.scene->stages, f.state));
    PetscCall(ScaledMasses(f.scene, m, f.scene->joints, f.contacts, f.state));
    LoadsApply(m, f.state, 1.);
    for (int cycle = 0; cycle < 50; cycle++)
      PetscCall(Step(f.scene, m, f.scene->joints, f.contacts, f.state, &f.relax->damping, NULL));
    PetscCall(PetscArraycpy(held, f.u_vertex, 2 * m->mesh.n_vertices));
    PetscCall(GhostBegin(m, f.u_vertex));
    PetscCall(GhostEnd(m, f.u_vertex));
    ENSURE(!memcmp(held, f.u_vertex, 2 * m->mesh.n_vertices * sizeof *held));
    for (PetscInt i = 2 * m->mesh.n_owned; i < 2 * m->mesh.n_vertices; i++) moved += PetscAbsReal(held[i]);
    ENSURE(moved > 0. || !m->ghosts.n);
    PetscCall(PetscFree(held));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A set is whole at every owned vertex: loads and supports need no word from other ranks. */
static PetscErrorCode SetsAndPointsAreFoundWhereTheyAreNeeded(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f;
    PetscInt found[SKETCH_NAMES] = {0};
    Wall(kind);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", scene));
    const Model *m = f.model;
    ENSURE(m->mesh.n_face_sets == sketch.n_sets && m->mesh.n_points == sketch.n_points);
    for (PetscInt s = 0, k; s < m->mesh.n_face_sets; s++) {
      PetscInt here = 0, expected = 0;
      for (k = 0; strcmp(sketch.set_names[k], m->mesh.face_set_names[s]);) k++;
      for (PetscInt i = m->mesh.face_set_start[s]; i < m->mesh.face_set_start[s + 1]; i++)
        for (int e = 0; e < 2; e++)
          here += m->faces.vertex[2 * m->mesh.face_set_faces[i] + e] < m->mesh.n_owned;
      for (PetscInt i = 0; i < sketch.set_n[k]; i++)
        for (int e = 0; e < 2; e++) {
          const int *face = sketch.set_faces[k] + 2 * i, *ring = sketch.blocks + 4 * face[0];
          const PetscInt v = LocalOfFile(m, ring[(face[1] + e) % (ring[3] < 0 ? 3 : 4)]);
          expected += v >= 0 && v < m->mesh.n_owned;
        }
      ENSURE(here == expected);
    }
    for (PetscInt p = 0; p < m->mesh.n_points; p++) {
      const PetscInt file = sketch.point_vertex[strcmp(m->mesh.point_names[p], "crest") ? 1 : 0];
      if (m->mesh.point_vertex[p] < 0) continue;
      ENSURE(m->mesh.vertex_file[m->mesh.point_vertex[p]] == file);
      found[p] = m->mesh.point_vertex[p] < m->mesh.n_owned;
    }
    for (PetscInt p = 0; p < m->mesh.n_points; p++) ENSURE_NEAR(Total(found[p]), 1, 0);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 300 cycles of a slipping wall: loads, contacts, elements, bodies and damping have the bits of one rank. */
static PetscErrorCode ParallelRunHasTheBitsOfTheSerialOne(void)
{
  PetscFunctionBeginUser;
  for (WallKind kind = 0; kind < WALLS; kind++) {
    Fixture f[2];
    uint64_t sum[2][2];
    Wall(kind);
    for (int i = 0; i < 2; i++) {
      PetscCall(FixtureOpen(i ? PETSC_COMM_SELF : PETSC_COMM_WORLD, &sketch, &f[i], "%s", scene));
      PetscCall(StageStart(&f[i], 0));
      PetscCall(StateChecksum(f[i].model, f[i].state, f[i].contacts, &sum[i][0]));
      PetscCall(StageCycles(&f[i], 0, 300));
      PetscCall(StateChecksum(f[i].model, f[i].state, f[i].contacts, &sum[i][1]));
    }
    ENSURE(sum[0][0] == sum[1][0] && sum[0][1] == sum[1][1] && sum[0][0] != sum[0][1]);
    ENSURE(f[0].state->alpha == f[1].state->alpha && f[0].state->alpha > 0);
    for (PetscInt v = 0; v < f[0].model->mesh.n_owned; v++) {
      const PetscInt twin = LocalOfFile(f[1].model, f[0].model->mesh.vertex_file[v]);
      for (int i = 0; i < 2; i++) ENSURE(f[0].u_vertex[2 * v + i] == f[1].u_vertex[2 * twin + i]);
    }
    for (int i = 0; i < 2; i++) PetscCall(FixtureClose(&f[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(WallsOfAllKindsAreOwnedOnce);
  RUN_TEST(MassesSumToDensityTimesArea);
  RUN_TEST(GhostsReceiveWhatTheirOwnersHold);
  RUN_TEST(GhostsHoldWhatTheirOwnersHoldAfterACycle);
  RUN_TEST(SetsAndPointsAreFoundWhereTheyAreNeeded);
  RUN_TEST(ParallelRunHasTheBitsOfTheSerialOne);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Macroblocks, edges, outer faces and the renumbering. */
#include "small_mesh.h"
#include "check.h"

static PetscErrorCode TestBodies(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  ENSURE(mesh.n_bodies == 2);
  ENSURE(mesh.body[0] == 0 && mesh.body[1] == 0 && mesh.body[2] == 1);
  /* one shared vertex makes one body */
  mesh.blocks[4 * 2] = 1;
  PetscCall(PetscFree(mesh.body));
  PetscCall(MeshBodies(&mesh));
  ENSURE(mesh.n_bodies == 1);
  ENSURE(mesh.body[2] == 0);
  /* entries out of range are passed over */
  mesh.blocks[4 * 2] = -7;
  mesh.blocks[4 * 2 + 1] = 1000;
  PetscCall(PetscFree(mesh.body));
  PetscCall(MeshBodies(&mesh));
  ENSURE(mesh.n_bodies == 2);
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestSeparate(void)
{
  const PetscInt all[12] = {0, 1, 2, 3, 9, 10, 4, -1, 5, 6, 7, 8};
  PetscBool separate[SMALL_GROUPS] = {PETSC_FALSE, PETSC_TRUE};
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(MeshSeparate(&mesh, separate)); /* of one block: nothing to do */
  ENSURE(mesh.n_vertices == SMALL_VERTICES && mesh.n_bodies == 2);
  separate[0] = PETSC_TRUE;
  PetscCall(MeshSeparate(&mesh, separate));
  ENSURE(mesh.n_vertices == SMALL_VERTICES + 2 && mesh.n_bodies == 3);
  for (int i = 0; i < 12; i++) ENSURE(mesh.blocks[i] == all[i]);
  for (int a = 0; a < 2; a++) ENSURE(mesh.X[2 * 9 + a] == small_X[2 * 3 + a]);
  for (PetscInt v = 0; v < mesh.n_vertices; v++) ENSURE(mesh.vertex_file[v] == v);
  ENSURE(mesh.point_vertex[1] == 4);
  PetscCall(MeshDestroy(&mesh));

  /* a vertex that another group has too stays there, whichever block comes first */
  PetscCall(SmallMesh(&mesh));
  mesh.block_group[1] = 1;
  separate[1] = PETSC_FALSE;
  PetscCall(MeshSeparate(&mesh, separate));
  ENSURE(mesh.n_bodies == 3 && mesh.blocks[4] == 3 && mesh.blocks[5] == 2);
  ENSURE(mesh.blocks[0] == 0 && mesh.blocks[1] == 1 && mesh.blocks[2] == 9 && mesh.blocks[3] == 10);
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestEdges(void)
{
  const PetscInt vertices[10][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {2, 4},
                                    {4, 3}, {5, 6}, {6, 7}, {7, 8}, {8, 5}};
  const PetscInt edges[SMALL_BLOCKS][4] = {{0, 1, 2, 3}, {-3, 4, 5, PETSC_MIN_INT}, {6, 7, 8, 9}};
  BlockMesh mesh;
  PetscInt n_edges, *edge_vertices, *block_edges;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(MeshEdges(&mesh, &n_edges, &edge_vertices, &block_edges));
  ENSURE(n_edges == 10);
  for (int e = 0; e < 10; e++)
    for (int i = 0; i < 2; i++) ENSURE(edge_vertices[2 * e + i] == vertices[e][i]);
  for (int b = 0; b < SMALL_BLOCKS; b++)
    for (int k = 0; k < 4; k++) ENSURE(block_edges[4 * b + k] == edges[b][k]);
  ENSURE(EDGE_INDEX(block_edges[4]) == 2);
  PetscCall(PetscFree(edge_vertices));
  PetscCall(PetscFree(block_edges));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestOuterFaces(void)
{
  const PetscInt outer[9][2] = {{0, 0}, {0, 1}, {0, 3}, {1, 1}, {1, 2}, {2, 0}, {2, 1}, {2, 2}, {2, 3}};
  BlockMesh mesh, empty = {0};
  PetscInt n, *faces;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(MeshOuterFaces(&mesh, &n, &faces));
  ENSURE(n == 9);
  for (int i = 0; i < PetscMin(n, 9); i++)
    ENSURE(faces[2 * i] == outer[i][0] && faces[2 * i + 1] == outer[i][1]);
  PetscCall(PetscFree(faces));
  PetscCall(MeshDestroy(&mesh));
  PetscCall(MeshOuterFaces(&empty, &n, &faces));
  ENSURE(n == 0);
  PetscCall(PetscFree(faces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- order */

enum {
  BODY = 6,
  BODIES = 5,
  SIDE = BODY * BODIES
}; /* quads along a side of a body, bodies along a side of the wall */

static PetscInt NextRandom(PetscInt n)
{
  static uint64_t state = 7;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (PetscInt)((state >> 33) % (uint64_t)n);
}

static void Shuffle(PetscInt n, PetscInt *order)
{
  for (PetscInt i = 0; i < n; i++) order[i] = i;
  for (PetscInt i = n - 1; i > 0; i--) {
    const PetscInt j = NextRandom(i + 1), t = order[i];
    order[i] = order[j];
    order[j] = t;
  }
}

enum { WALL_VERTICES = BODIES * BODIES * (BODY + 1) * (BODY + 1), WALL_BLOCKS = SIDE * SIDE };

/* A wall of BODIES x BODIES bodies of BODY x BODY quads, vertices and blocks in random order; some quads at
   the top of a body lose a corner, so that both shapes occur. */
static PetscErrorCode ShuffledWall(BlockMesh *mesh)
{
  static PetscReal X[2 * WALL_VERTICES];
  static PetscInt blocks[4 * WALL_BLOCKS], vertex[WALL_VERTICES], place[WALL_BLOCKS];
  PetscInt first = 0, block = 0;

  PetscFunctionBegin;
  Shuffle(WALL_VERTICES, vertex);
  Shuffle(WALL_BLOCKS, place);
  for (PetscInt body = 0; body < BODIES * BODIES; body++, first += (BODY + 1) * (BODY + 1))
    for (PetscInt j = 0; j <= BODY; j++)
      for (PetscInt i = 0; i <= BODY; i++) {
        const PetscInt v = first + j * (BODY + 1) + i;
        X[2 * vertex[v]] = body % BODIES * BODY + i;
        X[2 * vertex[v] + 1] = body / BODIES * BODY + j;
        if (i == BODY || j == BODY) continue;
        PetscInt *b = blocks + 4 * place[block++];
        b[0] = vertex[v];
        b[1] = vertex[v + 1];
        b[2] = vertex[v + BODY + 2];
        b[3] = i % 3 == 1 && j == BODY - 1 ? -1 : vertex[v + BODY + 1];
      }
  PetscCall(BareMesh(WALL_VERTICES, X, WALL_BLOCKS, blocks, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every block still has its corners, in their order, at their places. */
static void CompareBlocks(const BlockMesh *mesh, const BlockMesh *before)
{
  PetscInt wrong = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *v = mesh->blocks + 4 * b, *w = before->blocks + 4 * mesh->block_file[b];
    for (int k = 0; k < 4; k++) {
      if ((v[k] < 0) != (w[k] < 0)) wrong++;
      if (v[k] < 0 || w[k] < 0) continue;
      if (mesh->vertex_file[v[k]] != w[k]) wrong++;
      for (int a = 0; a < 2; a++) wrong += mesh->X[2 * v[k] + a] != before->X[2 * w[k] + a];
    }
    if (mesh->block_group[b] != before->block_group[mesh->block_file[b]]) wrong++;
  }
  ENSURE(wrong == 0);
}

static PetscBool IsPermutation(PetscInt n, const PetscInt *p)
{
  PetscBool seen[WALL_VERTICES] = {PETSC_FALSE};
  for (PetscInt i = 0; i < n; i++) {
    if (p[i] < 0 || p[i] >= n || seen[p[i]]) return PETSC_FALSE;
    seen[p[i]] = PETSC_TRUE;
  }
  return PETSC_TRUE;
}

static PetscInt LowestVertex(const BlockMesh *mesh, PetscInt b)
{
  PetscInt lowest = PETSC_MAX_INT;
  for (int k = 0; k < 4; k++)
    if (mesh->blocks[4 * b + k] >= 0) lowest = PetscMin(lowest, mesh->blocks[4 * b + k]);
  return lowest;
}

static PetscErrorCode TestReorderWall(void)
{
  BlockMesh mesh, before, again;
  PetscInt wide = 0, unsorted = 0, bodies = 0, same = 0;

  PetscFunctionBegin;
  PetscCall(ShuffledWall(&mesh));
  PetscCall(BareMesh(mesh.n_vertices, mesh.X, mesh.n_blocks, mesh.blocks, &before));
  PetscCall(BareMesh(mesh.n_vertices, mesh.X, mesh.n_blocks, mesh.blocks, &again));
  for (PetscInt b = 0; b < mesh.n_blocks; b++)
    again.block_group[b] = before.block_group[b] = mesh.block_group[b] = b % 4;
  PetscCall(MeshReorder(&mesh));
  PetscCall(MeshReorder(&again));

  ENSURE(IsPermutation(mesh.n_vertices, mesh.vertex_file));
  ENSURE(IsPermutation(mesh.n_blocks, mesh.block_file));
  CompareBlocks(&mesh, &before);
  /* vertices of a block are near each other, blocks ascend, bodies come one after the other */
  for (PetscInt b = 0; b < mesh.n_blocks; b++) {
    for (int k = 0; k < 4; k++)
      if (mesh.blocks[4 * b + k] > LowestVertex(&mesh, b) + 3 * BODY) wide++;
    if (b > 0 && LowestVertex(&mesh, b) < LowestVertex(&mesh, b - 1)) unsorted++;
    if (b > 0 && (mesh.body[b] < mesh.body[b - 1] || mesh.body[b] > mesh.body[b - 1] + 1)) bodies++;
    same += mesh.block_file[b] == again.block_file[b];
  }
  ENSURE(wide == 0);
  ENSURE(unsorted == 0);
  ENSURE(bodies == 0);
  ENSURE(mesh.n_bodies == BODIES * BODIES);
  ENSURE(mesh.body[0] == 0 && mesh.body[mesh.n_blocks - 1] == mesh.n_bodies - 1);
  ENSURE(same == mesh.n_blocks);
  PetscCall(MeshDestroy(&mesh));
  PetscCall(MeshDestroy(&before));
  PetscCall(MeshDestroy(&again));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* In the sweep, bodies that touch are no further apart than a strip is long, whatever
   the order of the file. */
static PetscErrorCode TestBodiesAreNeighbours(void)
{
  enum { LONG = 5, SHORT = 3, N = LONG * SHORT };
  BlockMesh mesh;
  PetscInt blocks[4 * N];
  PetscReal X[8 * N];

  PetscFunctionBegin;
  for (int round = 0; round < 6; round++) {
    PetscInt place[N], apart = 0;
    Shuffle(N, place);
    for (int i = 0; i < N; i++)
      for (int k = 0; k < 4; k++) { // the longer side along x, then along y
        const int upright = round % 2;
        blocks[4 * i + k] = 4 * i + k;
        X[2 * (4 * i + k)] = (upright ? place[i] % SHORT : place[i] / SHORT) + (k == 1 || k == 2);
        X[2 * (4 * i + k) + 1] = (upright ? place[i] / SHORT : place[i] % SHORT) + (k >= 2);
      }
    PetscCall(BareMesh(4 * N, X, N, blocks, &mesh));
    PetscCall(MeshReorder(&mesh));
    PetscReal centre[N][2] = {{0.}};
    for (int i = 0; i < 8 * N; i++)
      centre[mesh.body[i / 8]][i % 2] += mesh.X[2 * mesh.blocks[i / 2] + i % 2] / 4.;
    for (int i = 0; i < N; i++)
      for (int j = 0; j < i; j++)
        if (PetscAbsReal(centre[i][0] - centre[j][0]) + PetscAbsReal(centre[i][1] - centre[j][1]) < 1.5)
          apart = PetscMax(apart, i - j);
    ENSURE(apart == SHORT);
    PetscCall(MeshDestroy(&mesh));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Many bodies of one size, in the order of the sweep already: the worst of a sort that divides by a value. */
static PetscErrorCode TestReorderAlike(void)
{
  enum { N = 200000, ROW = 400 };
  BlockMesh mesh;
  PetscInt *blocks, moved = 0;
  PetscReal *X;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(4 * N, &blocks, 8 * N, &X));
  for (int i = 0; i < 4 * N; i++) {
    const int block = i / 4, k = i % 4;
    blocks[i] = i;
    X[2 * i] = block / ROW + (k == 1 || k == 2), X[2 * i + 1] = block % ROW + (k >= 2);
  }
  PetscCall(BareMesh(4 * N, X, N, blocks, &mesh));
  PetscCall(MeshReorder(&mesh));
  for (PetscInt b = 0; b < N; b++) moved += mesh.block_file[b] != b;
  ENSURE(moved == 0);
  PetscCall(MeshDestroy(&mesh));
  PetscCall(PetscFree2(blocks, X));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets and points keep naming the same faces and places. */
static PetscErrorCode TestReorderSets(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(MeshReorder(&mesh));
  for (int s = 0; s < SMALL_SETS; s++)
    for (int i = 0; i < small_set_n[s]; i++) {
      ENSURE(mesh.block_file[mesh.face_sets[s].faces[2 * i]] == small_faces[s][2 * i]);
      ENSURE(mesh.face_sets[s].faces[2 * i + 1] == small_faces[s][2 * i + 1]);
    }
  for (int p = 0; p < SMALL_POINTS; p++)
    ENSURE(mesh.vertex_file[mesh.point_vertex[p]] == small_point_vertex[p]);
  for (int b = 0; b < SMALL_BLOCKS; b++) ENSURE(mesh.block_group[b] == small_block_group[mesh.block_file[b]]);
  ENSURE(mesh.body[0] == 0);
  PetscCall(MeshDestroy(&mesh));
  /* the empty mesh of the other ranks */
  PetscCall(MeshReorder(&mesh));
  ENSURE(mesh.n_blocks == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestBodies);
  RUN_TEST(TestSeparate);
  RUN_TEST(TestEdges);
  RUN_TEST(TestOuterFaces);
  RUN_TEST(TestReorderWall);
  RUN_TEST(TestBodiesAreNeighbours);
  RUN_TEST(TestReorderAlike);
  RUN_TEST(TestReorderSets);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

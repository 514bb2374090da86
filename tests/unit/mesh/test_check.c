/* Every refusal of docs/mesh_format.md on the content of a mesh, with its words; and
   what must not be refused. */
#include "small_mesh.h"
#include "check.h"

static const PetscReal tolerance = 0.005; /* [m] */

static PetscErrorCode Expect(const BlockMesh *mesh, const char *fragment)
{
  char message[MESSAGE_LENGTH];

  PetscFunctionBegin;
  PetscCall(MeshCheck(mesh, tolerance, message));
  const PetscBool as_expected = *fragment ? (strstr(message, fragment) ? PETSC_TRUE : PETSC_FALSE)
                                          : !message[0];
  if (!as_expected) fprintf(stderr, "expected '%s', found '%s'\n", fragment, message);
  ENSURE(as_expected);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one number of the small mesh changed */

typedef enum { X, BLOCK, GROUP, BASE, JOINT, POINT } Table;

typedef struct {
  Table table;
  PetscInt entry;
  PetscReal value;
  const char *fragment;
} Change;

static const Change changes[] = {
    {X, 0, NAN, "vertex 0: coordinates (nan, 0) are not finite"},
    {X, 13, INFINITY, "vertex 6: coordinates (2, inf) are not finite"},
    {X, 5, -INFINITY, "vertex 2: coordinates (1, -inf) are not finite"},
    {X, 5, 1e200, "vertex 2: coordinates (1, 1e+200) are not finite, or beyond 1e15 m"},
    {BLOCK, 0, -1, "block 0: its vertex 0 is -1, expected 0..8"},
    {BLOCK, 7, -2, "block 1: its vertex 3 is -2, expected 0..8"},
    {BLOCK, 5, 9, "block 1: its vertex 1 is 9, expected 0..8"},
    {BLOCK, 11, PETSC_MAX_INT, "block 2: its vertex 3 is 2147483647"},
    {BLOCK, 11, PETSC_MIN_INT, "block 2: its vertex 3 is -2147483648"},
    {BLOCK, 11, 6, "block 2: vertex 6 is repeated"},
    {BLOCK, 6, 3, "block 1: vertex 3 is repeated"},
    {BLOCK, 11, -1, "vertex 8 at (1, 1): no block uses it"},
    {GROUP, 1, -1, "block 1: group row -1 does not exist, the mesh has 2 groups"},
    {GROUP, 2, 2, "block 2: group row 2 does not exist, the mesh has 2 groups"},
    {X, 9, 1, "block 1 at (0, 1): its area is zero"},
    {X, 9, 1 + 1e-14, "block 1 at (0, 1): its area is zero"},
    {X, 9, 0.5, "block 1 at (0, 1): inverted, its vertices run clockwise (area -0.25 m2)"},
    {X, 14, 1.2, ""},
    {X, 15, -0.5, "block 2: not convex at its vertex 6 (2, 0)"},
    {BASE, 2, -1, "face set 'base', row 1: block -1 does not exist, expected 0..2"},
    {BASE, 2, 3, "face set 'base', row 1: block 3 does not exist, expected 0..2"},
    {BASE, 5, 3, "face set 'base', row 2: block 1 has no face 3, expected 0..2"},
    {BASE, 1, -1, "face set 'base', row 0: block 2 has no face -1, expected 0..3"},
    {BASE, 1, 4, "face set 'base', row 0: block 2 has no face 4, expected 0..3"},
    {BASE, 2, 2, "face set 'base': face 0 of block 2 is listed twice"},
    {BASE, 5, 0, "face set 'base', row 2: face 0 of block 1 is inside its macroblock"},
    {JOINT, 1, 2, "face set 'joint', row 0: face 2 of block 0 is inside its macroblock"},
    {POINT, 1, 9, "point 'crest': vertex 9 does not exist, expected 0..8"},
    {POINT, 0, -1, "point 'corner': vertex -1 does not exist"},
};

static void Apply(const Change *change, BlockMesh *mesh)
{
  PetscInt *const tables[] = {[BLOCK] = mesh->blocks,
                              [GROUP] = mesh->block_group,
                              [BASE] = mesh->face_sets[0].faces,
                              [JOINT] = mesh->face_sets[1].faces,
                              [POINT] = mesh->point_vertex};
  if (change->table == X)
    mesh->X[change->entry] = change->value;
  else
    tables[change->table][change->entry] = (PetscInt)change->value;
}

static PetscErrorCode TestChanges(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
    PetscCall(SmallMesh(&mesh));
    Apply(&changes[i], &mesh);
    /* as MeshRead does it: on the numbers as they come */
    PetscCall(PetscFree(mesh.body));
    PetscCall(MeshBodies(&mesh));
    PetscCall(Expect(&mesh, changes[i].fragment));
    PetscCall(MeshDestroy(&mesh));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestGoodMesh(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(Expect(&mesh, ""));
  /* two groups of one name */
  memcpy(mesh.group_names[1], mesh.group_names[0], NAME_LENGTH);
  PetscCall(Expect(&mesh, "group 'stone': two groups have this name"));
  PetscCall(MeshDestroy(&mesh));
  PetscCall(Expect(&mesh, "the mesh has no blocks"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Renumbered or not, messages have the file's numbers. */
static PetscErrorCode TestFileNumbers(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(SmallMesh(&mesh));
  PetscCall(MeshReorder(&mesh));
  PetscCall(Expect(&mesh, ""));
  for (PetscInt v = 0; v < mesh.n_vertices; v++)
    if (mesh.vertex_file[v] == 7) mesh.X[2 * v + 1] = -0.5;
  PetscCall(Expect(&mesh, "block 2: not convex at its vertex 6 (2, 0)"));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- whole meshes of few blocks; no groups are needed but one */

static PetscErrorCode ExpectOf(PetscInt n_vertices, const PetscReal *x, PetscInt n_blocks,
                               const PetscInt *blocks, const char *fragment)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCall(BareMesh(n_vertices, x, n_blocks, blocks, &mesh));
  mesh.n_groups = 1;
  PetscCall(PetscCalloc1(1, &mesh.group_names));
  PetscCall(PetscCalloc1(1, &mesh.group_rigid));
  PetscCall(Expect(&mesh, fragment));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestEdges(void)
{
  const PetscReal fan[] = {0, 0, 1, 0, 0.5, 1, 0.5, -1, 0.5, 2};

  PetscFunctionBegin;
  PetscCall(ExpectOf(4, fan, 2, (PetscInt[]){0, 1, 2, -1, 1, 0, 3, -1}, ""));
  PetscCall(ExpectOf(5, fan, 3, (PetscInt[]){0, 1, 2, -1, 1, 0, 3, -1, 0, 1, 4, -1},
                     "edge between vertices 0 and 1 is shared by 3 blocks"));
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 0.5, 1, 0.5, 2}, 2, (PetscInt[]){0, 1, 2, -1, 0, 1, 3, -1},
                     "blocks 0 and 1 lie on the same side of their edge between vertices 0 and 1"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestShapes(void)
{
  const PetscInt quad[] = {0, 1, 2, 3};

  PetscFunctionBegin;
  /* a straight corner is allowed, a bow tie and two vertices at one place are not */
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 2, 0, 1, 1}, 1, quad, ""));
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 3, 0, 0, 1, 2, 1}, 1, quad, "block 0: not convex"));
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 1, 0, 0, 1}, 1, quad,
                     "block 0: its vertices 1 and 2 are at the same place"));
  /* slivers: thin, or with a face next to nothing */
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 1, 1e-9, 0, 1e-9}, 1, quad,
                     "block 0 at (0, 0): a sliver of aspect ratio 1e+09, expected at most 1e+06"));
  PetscCall(
      ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 1, 1, 1 - 1e-7, 1}, 1, quad, "block 0 at (0, 0): a sliver"));
  PetscCall(ExpectOf(3, (PetscReal[]){0, 0, 1, 0, 0.5, 9e-7}, 1, (PetscInt[]){0, 1, 2, -1},
                     "a sliver of aspect ratio 1.11e+06"));
  PetscCall(ExpectOf(3, (PetscReal[]){0, 0, 1, 0, 0.5, 1.1e-6}, 1, (PetscInt[]){0, 1, 2, -1}, ""));
  /* thin, tiny and far away is no fault */
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1, 0, 1, 1.01e-6, 0, 1.01e-6}, 1, quad, ""));
  PetscCall(ExpectOf(4, (PetscReal[]){0, 0, 1e-7, 0, 1e-7, 1e-7, 0, 1e-7}, 1, quad, ""));
  PetscCall(ExpectOf(4, (PetscReal[]){1e7, 1e7, 1e7 + 1, 1e7, 1e7 + 1, 1e7 + 1, 1e7, 1e7 + 1}, 1, quad, ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two bodies of one block each, the second a unit square turned by an angle [rad] and moved. */
static PetscErrorCode ExpectOfSquares(PetscReal angle, PetscReal x, PetscReal y, PetscReal size,
                                      const char *fragment)
{
  const PetscReal c = size * cos(angle), s = size * sin(angle);
  const PetscReal X[] = {0, 0, 1, 0, 1, 1, 0, 1, x, y, x + c, y + s, x + c - s, y + s + c, x - s, y + c};

  PetscFunctionBegin;
  PetscCall(ExpectOf(8, X, 2, (PetscInt[]){0, 1, 2, 3, 4, 5, 6, 7}, fragment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestOverlap(void)
{
  const PetscReal diagonal = PETSC_PI / 4;

  PetscFunctionBegin;
  /* side by side, tolerated, too deep */
  PetscCall(ExpectOfSquares(0, 1, 0.3, 1, ""));
  PetscCall(ExpectOfSquares(0, 1 - 0.99 * tolerance, 0.3, 1, ""));
  PetscCall(ExpectOfSquares(0, 1 - 1.01 * tolerance, 0.3, 1,
                            "blocks 0 and 1 of different macroblocks overlap by 0.00505 m"));
  PetscCall(ExpectOfSquares(0, 0.69, 0.1, 1,
                            "blocks 0 and 1 of different macroblocks overlap by 0.31 m (tolerance 0.005 m)"));
  /* on top of each other: the depth is the way out, not the common width */
  PetscCall(ExpectOfSquares(0, 0, 0, 1, "overlap by 1 m"));
  PetscCall(ExpectOfSquares(0, 0.4, 0.4, 0.2, "overlap by 0.6 m"));
  PetscCall(ExpectOfSquares(0, 0.4, 0.4, 0.001, "overlap by 0.401 m"));
  /* a corner over an edge; envelopes overlap, blocks do not */
  PetscCall(ExpectOfSquares(diagonal, 0.5, 0.9, 1, "overlap by 0.1 m"));
  PetscCall(ExpectOfSquares(diagonal, 0.5, 0.996, 1, ""));
  PetscCall(ExpectOfSquares(diagonal, 1.45, 0.6, 1, ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The overlap of a large mesh is found wherever it is: one stone of a wall is moved. */
static PetscErrorCode TestOverlapInWall(void)
{
  enum { N = 20 };
  static PetscReal x[8 * N * N];
  static PetscInt blocks[4 * N * N];

  PetscFunctionBegin;
  for (int b = 0; b < N * N; b++)
    for (int k = 0; k < 4; k++) {
      blocks[4 * b + k] = 4 * b + k;
      x[8 * b + 2 * k] = b % N + (k == 1 || k == 2);
      x[8 * b + 2 * k + 1] = b / N + (k >= 2);
    }
  PetscCall(ExpectOf(4 * N * N, x, N * N, blocks, ""));
  for (int k = 0; k < 4; k++) x[8 * 137 + 2 * k] += 0.02;
  PetscCall(
      ExpectOf(4 * N * N, x, N * N, blocks, "blocks 137 and 138 of different macroblocks overlap by 0.02 m"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestGoodMesh);
  RUN_TEST(TestChanges);
  RUN_TEST(TestFileNumbers);
  RUN_TEST(TestEdges);
  RUN_TEST(TestShapes);
  RUN_TEST(TestOverlap);
  RUN_TEST(TestOverlapInWall);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* topology.c: finds macroblocks, edges and outer faces from the vertices of the blocks alone. Rank 0, before
   the mesh is distributed. */
#include "mesh/mesh.h"
#include <petscmat.h>
#include <stdlib.h>

/* ---- macroblocks */

/* Finds the connected components of blocks over shared vertices, numbered by first appearance, and sets the
   file numbers to identity. Entries out of range are skipped here, because MeshCheck names them. */
PetscErrorCode MeshBodies(BlockMesh *mesh)
{
  const PetscInt n = mesh->n_vertices;
  PetscInt *parent, *label;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &parent, n, &label));
  PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->body));
  mesh->n_bodies = 0;
  for (PetscInt v = 0; v < n; v++) {
    parent[v] = v;
    label[v] = -1;
  }
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    mesh->body[b] = -1; /* a vertex of the block, until the bodies are numbered */
    for (PetscInt k = 0; k < 4; k++) {
      const PetscInt v = mesh->blocks[4 * b + k];
      if (v < 0 || v >= n) continue;
      if (mesh->body[b] < 0)
        mesh->body[b] = v;
      else
        parent[UnionRoot(parent, v)] = UnionRoot(parent, mesh->body[b]);
    }
  }
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt root = mesh->body[b] < 0 ? -1 : UnionRoot(parent, mesh->body[b]);
    if (root >= 0 && label[root] < 0) label[root] = mesh->n_bodies++;
    mesh->body[b] = root < 0 ? mesh->n_bodies++ : label[root];
  }
  PetscCall(PetscFree2(parent, label));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshSeparate(BlockMesh *mesh, const PetscBool *separate)
{
  const PetscInt n = mesh->n_vertices;
  PetscInt *source, count = n; // source: (count,) the vertex that each one is, or is a copy of
  PetscBool *taken;            // (n,) a block keeps the vertex
  PetscReal *X;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)n + 4 * (size_t)mesh->n_blocks, &source));
  PetscCall(PetscCalloc1(n, &taken));
  for (PetscInt v = 0; v < n; v++) source[v] = v;
  for (int pass = 0; pass < 2; pass++) // blocks of other groups come first
    for (PetscInt b = 0; b < mesh->n_blocks; b++)
      for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * b); k++) {
        PetscInt *v = &mesh->blocks[4 * b + k];
        if (separate[mesh->block_group[b]] != (PetscBool)pass) continue;
        if (pass && taken[*v])
          source[count] = *v, *v = count++;
        else
          taken[*v] = PETSC_TRUE;
      }
  PetscCall(PetscMalloc1(2 * (size_t)count, &X));
  for (PetscInt v = 0; v < count; v++)
    for (int a = 0; a < 2; a++) X[2 * v + a] = mesh->X[2 * source[v] + a];
  PetscCall(PetscFree(mesh->X));
  PetscCall(PetscFree(taken));
  PetscCall(PetscFree(mesh->vertex_file));
  for (PetscInt v = 0; v < count; v++) source[v] = v;
  mesh->X = X, mesh->vertex_file = source, mesh->n_vertices = count;
  PetscCall(PetscFree(mesh->body));
  PetscCall(MeshBodies(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- edges */

/* The edges numbered so far, in chains by a hash of their two vertices. */
typedef struct {
  PetscInt n;
  PetscInt *vertices;    /* (n,2) in the direction of the first block */
  PetscInt *head, *next; /* (mask + 1,), (n,) */
  unsigned mask;
} EdgeTable;

/* Returns the edge a-b, a new one if needed; -(edge + 1) when the table has the edge as b-a. */
static PetscInt find_or_add_edge(EdgeTable *table, PetscInt a, PetscInt b)
{
  /* The hash is linear in the vertices, so that a mesh in good order walks through the table. In fans and
     strips the two vertices depend on each other linearly; the odd factor keeps them from sharing one
     chain. */
  const unsigned low = (unsigned)PetscMin(a, b), high = (unsigned)PetscMax(a, b);
  PetscInt *head = &table->head[(low + 7919u * (high - low)) & table->mask];

  for (PetscInt e = *head; e >= 0; e = table->next[e]) {
    if (table->vertices[2 * e] == a && table->vertices[2 * e + 1] == b) return e;
    if (table->vertices[2 * e] == b && table->vertices[2 * e + 1] == a) return -(e + 1);
  }
  const PetscInt e = table->n++;
  table->vertices[2 * e] = a;
  table->vertices[2 * e + 1] = b;
  table->next[e] = *head;
  *head = e;
  return e;
}

PetscErrorCode MeshEdges(const BlockMesh *mesh, PetscInt *n_edges, PetscInt **edge_vertices,
                         PetscInt **block_edges)
{
  EdgeTable table = {.mask = 15};
  size_t n_sides = 0;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) n_sides += (size_t)BlockCorners(mesh->blocks + 4 * b);
  while (table.mask < n_sides / 2) table.mask = 2 * table.mask + 1; /* most edges have two sides */
  PetscCall(PetscMalloc2((size_t)table.mask + 1, &table.head, n_sides, &table.next));
  PetscCall(PetscMalloc1(2 * n_sides, &table.vertices));
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, block_edges));
  for (size_t i = 0; i <= table.mask; i++) table.head[i] = -1;

  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *v = mesh->blocks + 4 * b, corners = BlockCorners(v);
    PetscInt *edges = *block_edges + 4 * b;
    edges[3] = PETSC_MIN_INT;
    for (PetscInt k = 0; k < corners; k++) edges[k] = find_or_add_edge(&table, v[k], v[(k + 1) % corners]);
  }
  PetscCall(PetscFree2(table.head, table.next));
  *n_edges = table.n;
  *edge_vertices = table.vertices;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MeshMeasures(const BlockMesh *mesh, PetscReal *longest, PetscReal *diameter)
{
  PetscReal low[2] = {PETSC_INFINITY, PETSC_INFINITY}, high[2] = {PETSC_NINFINITY, PETSC_NINFINITY};
  *longest = *diameter = 0.;
  for (PetscInt i = 0; i < 2 * mesh->n_vertices; i++)
    low[i % 2] = PetscMin(low[i % 2], mesh->X[i]), high[i % 2] = PetscMax(high[i % 2], mesh->X[i]);
  if (mesh->n_vertices)
    *diameter = PetscSqrtReal((high[0] - low[0]) * (high[0] - low[0]) +
                              (high[1] - low[1]) * (high[1] - low[1]));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (int k = 0, nk = mesh->blocks[4 * b + 3] < 0 ? 3 : 4; k < nk; k++) {
      const PetscReal *p = mesh->X + 2 * mesh->blocks[4 * b + k],
                      *q = mesh->X + 2 * mesh->blocks[4 * b + (k + 1) % nk];
      *longest = PetscMax(*longest,
                          PetscSqrtReal((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1])));
    }
}

PetscErrorCode MeshOuterFaces(const BlockMesh *mesh, PetscInt *n, PetscInt **faces)
{
  PetscInt n_edges, *edge_vertices, *block_edges, *uses, count = 0;

  PetscFunctionBegin;
  PetscCall(MeshEdges(mesh, &n_edges, &edge_vertices, &block_edges));
  PetscCall(PetscCalloc1(n_edges, &uses));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * b); k++)
      uses[EDGE_INDEX(block_edges[4 * b + k])]++;
  for (PetscInt e = 0; e < n_edges; e++) count += uses[e] == 1;

  PetscCall(PetscMalloc1(2 * (size_t)count, faces));
  *n = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * b); k++)
      if (uses[EDGE_INDEX(block_edges[4 * b + k])] == 1) {
        (*faces)[2 * *n] = b;
        (*faces)[2 * *n + 1] = k;
        (*n)++;
      }
  PetscCall(PetscFree(uses));
  PetscCall(PetscFree(edge_vertices));
  PetscCall(PetscFree(block_edges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the blocks at each vertex: (n_vertices + 1) offsets, and the blocks in ascending order. */
PetscErrorCode MeshVertexBlocks(const BlockMesh *mesh, PetscInt **start, PetscInt **blocks)
{
  PetscInt *s, *b, *fill;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(mesh->n_vertices + 1, &s));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) s[mesh->blocks[i] + 1]++;
  for (PetscInt v = 0; v < mesh->n_vertices; v++) s[v + 1] += s[v];
  PetscCall(PetscMalloc1(s[mesh->n_vertices], &b));
  PetscCall(PetscMalloc1(mesh->n_vertices, &fill));
  PetscCall(PetscArraycpy(fill, s, mesh->n_vertices));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) b[fill[mesh->blocks[i]]++] = i / 4;
  PetscCall(PetscFree(fill));
  *start = s;
  *blocks = b;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshOuterBoxes(const BlockMesh *mesh, PetscReal margin, PetscInt *n, PetscInt **faces,
                              PetscReal **box)
{
  PetscFunctionBeginUser;
  PetscCall(MeshOuterFaces(mesh, n, faces));
  PetscCall(PetscMalloc1(4 * *n, box));
  for (PetscInt f = 0; f < *n; f++) {
    const PetscInt *block = mesh->blocks + 4 * (*faces)[2 * f], k = (*faces)[2 * f + 1],
                   nk = block[3] < 0 ? 3 : 4;
    FaceBox(mesh->X + 2 * block[k], mesh->X + 2 * block[(k + 1) % nk], margin, *box + 4 * f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

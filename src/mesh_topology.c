/* mesh_topology.c: what follows from the blocks' vertices alone: edges, outer faces, and the order in which Quoin
   numbers vertices, blocks and macroblocks. All on rank 0, before the mesh is distributed. */
#include "internal.h"
#include <petscmat.h>
#include <stdlib.h>

static inline PetscInt Corners(const PetscInt *block)
{
  return block[3] < 0 ? 3 : 4;
}

/* ---- edges */

/* Edges numbered so far, in chains by a hash of their two vertices. */
typedef struct {
  PetscInt n;
  PetscInt *vertices;    /* (n,2) in the direction of the first block */
  PetscInt *head, *next; /* (mask + 1,), (n,) */
  unsigned mask;
} EdgeTable;

/* The edge a-b, a new one if need be; -(edge + 1) when it is there as b-a. */
static PetscInt FindOrAddEdge(EdgeTable *table, PetscInt a, PetscInt b)
{
  /* linear in the vertices, so that a mesh in good order walks through the table; the odd factor keeps fans and strips,
     where the two vertices depend on each other linearly, from one chain */
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

PetscErrorCode MeshEdges(const BlockMesh *mesh, PetscInt *n_edges, PetscInt **edge_vertices, PetscInt **block_edges)
{
  EdgeTable table = {.mask = 15};
  size_t n_sides = 0;

  PetscFunctionBegin;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) n_sides += (size_t)Corners(mesh->blocks + 4 * b);
  while (table.mask < n_sides / 2) table.mask = 2 * table.mask + 1; /* most edges have two sides */
  PetscCall(PetscMalloc2((size_t)table.mask + 1, &table.head, n_sides, &table.next));
  PetscCall(PetscMalloc1(2 * n_sides, &table.vertices));
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, block_edges));
  for (size_t i = 0; i <= table.mask; i++) table.head[i] = -1;

  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *v = mesh->blocks + 4 * b, corners = Corners(v);
    PetscInt *edges = *block_edges + 4 * b;
    edges[3] = PETSC_MIN_INT;
    for (PetscInt k = 0; k < corners; k++) edges[k] = FindOrAddEdge(&table, v[k], v[(k + 1) % corners]);
  }
  PetscCall(PetscFree2(table.head, table.next));
  *n_edges = table.n;
  *edge_vertices = table.vertices;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshOuterFaces(const BlockMesh *mesh, PetscInt *n, PetscInt **faces)
{
  PetscInt n_edges, *edge_vertices, *block_edges, *uses, count = 0;

  PetscFunctionBegin;
  PetscCall(MeshEdges(mesh, &n_edges, &edge_vertices, &block_edges));
  PetscCall(PetscCalloc1(n_edges, &uses));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < Corners(mesh->blocks + 4 * b); k++) uses[EDGE_INDEX(block_edges[4 * b + k])]++;
  for (PetscInt e = 0; e < n_edges; e++) count += uses[e] == 1;

  PetscCall(PetscMalloc1(2 * (size_t)count, faces));
  *n = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < Corners(mesh->blocks + 4 * b); k++)
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

/* ---- order */

/* Compressed rows: the blocks around each vertex. */
static PetscErrorCode VertexBlocks(const BlockMesh *mesh, PetscInt **start, PetscInt **around)
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc1((size_t)mesh->n_vertices + 2, start));
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, around));
  PetscInt *count = *start + 2, *end = *start + 1; /* after the fill, end[v] is where row v ends: no second array */
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0 && mesh->blocks[i] + 1 < mesh->n_vertices) count[mesh->blocks[i]]++;
  for (PetscInt v = 1; v < mesh->n_vertices; v++) end[v] += end[v - 1];
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) (*around)[end[mesh->blocks[i]]++] = i / 4;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compressed rows: each vertex with all vertices it shares a block with, itself included, ascending. */
static PetscErrorCode VertexGraph(const BlockMesh *mesh, PetscInt **row_start, PetscInt **columns)
{
  PetscInt *start, *around, *seen, n = 0;
  size_t size = 0;

  PetscFunctionBegin;
  PetscCall(VertexBlocks(mesh, &start, &around));
  /* twice a planar graph's need covers quads (9 of 8 + 1) and triangles (7); a row of c blocks has at most 3 c + 1 */
  for (PetscInt v = 0; v < mesh->n_vertices; v++) size += 3 * (size_t)(start[v + 1] - start[v]) + 1;
  PetscCall(PetscMalloc1((size_t)mesh->n_vertices + 1, row_start));
  PetscCall(PetscMalloc1(size, columns));
  PetscCall(PetscMalloc1(mesh->n_vertices, &seen));
  for (PetscInt v = 0; v < mesh->n_vertices; v++) seen[v] = -1;
  for (PetscInt v = 0; v < mesh->n_vertices; v++) {
    (*row_start)[v] = n;
    seen[v] = v;
    (*columns)[n++] = v;
    for (PetscInt i = start[v]; i < start[v + 1]; i++) {
      const PetscInt *block = mesh->blocks + 4 * around[i], corners = Corners(block);
      for (PetscInt k = 0; k < corners; k++)
        if (seen[block[k]] != v) {
          seen[block[k]] = v;
          (*columns)[n++] = block[k];
        }
    }
    PetscCall(PetscSortInt(n - (*row_start)[v], *columns + (*row_start)[v]));
  }
  (*row_start)[mesh->n_vertices] = n;
  PetscCall(PetscFree(seen));
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(around));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* old: (n_vertices,) old number of each new vertex, by reverse Cuthill-McKee. */
static PetscErrorCode OrderVertices(const BlockMesh *mesh, PetscInt *old)
{
  PetscInt *row_start, *columns;
  const PetscInt *order;
  Mat graph;
  IS rows, cols;

  PetscFunctionBegin;
  PetscCall(VertexGraph(mesh, &row_start, &columns));
  PetscCall(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, mesh->n_vertices, mesh->n_vertices, row_start, columns, NULL,
                                      &graph));
  PetscCall(MatSetOption(graph, MAT_STRUCTURALLY_SYMMETRIC, PETSC_TRUE)); /* spares PETSc a copy */
  PetscCall(MatGetOrdering(graph, MATORDERINGRCM, &rows, &cols));
  PetscCall(ISGetIndices(rows, &order));
  PetscCall(PetscArraycpy(old, order, mesh->n_vertices));
  PetscCall(ISRestoreIndices(rows, &order));
  PetscCall(ISDestroy(&rows));
  PetscCall(ISDestroy(&cols));
  PetscCall(MatDestroy(&graph));
  PetscCall(PetscFree(row_start));
  PetscCall(PetscFree(columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* order.c: numbers vertices, blocks and macroblocks in an order of small bandwidth. Rank 0, before the mesh
   is distributed. */
#include "mesh/mesh.h"
#include <petscmat.h>
#include <stdlib.h>

/* Makes compressed rows: each vertex with all vertices that share a block with it, itself included,
   ascending. */
static PetscErrorCode vertex_graph(const BlockMesh *mesh, PetscInt **row_start, PetscInt **columns)
{
  PetscInt *start, *around, *seen, n = 0;
  size_t size = 0;

  PetscFunctionBegin;
  PetscCall(MeshVertexBlocks(mesh, &start, &around));
  /* a vertex of c blocks has at most 3 c neighbours */
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
      const PetscInt *block = mesh->blocks + 4 * around[i], corners = BlockCorners(block);
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

/* Finds old, (n_vertices,), the old number of each new vertex, by reverse Cuthill-McKee within each
   macroblock. */
static PetscErrorCode order_vertices(const BlockMesh *mesh, PetscInt *old)
{
  PetscInt *row_start, *columns;
  const PetscInt *order;
  Mat graph;
  IS rows, cols;

  PetscFunctionBegin;
  PetscCall(vertex_graph(mesh, &row_start, &columns));
  PetscCall(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, mesh->n_vertices, mesh->n_vertices, row_start, columns,
                                      NULL, &graph));
  PetscCall(MatSetOption(graph, MAT_STRUCTURALLY_SYMMETRIC, PETSC_TRUE)); /* saves PETSc a copy */
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

typedef struct {
  PetscReal strip, along; /* [-], [m] */
  PetscInt body;
} BodyKey;

static int compare_body_keys(const void *a, const void *b)
{
  const BodyKey *x = a, *y = b;
  if (x->strip != y->strip) return x->strip < y->strip ? -1 : 1;
  if (x->along != y->along) return x->along < y->along ? -1 : 1;
  return (x->body > y->body) - (x->body < y->body);
}

/* Finds box, (n_bodies,4), lower x, y and upper x, y of each macroblock; all: the box of the whole mesh. */
static void body_boxes(const BlockMesh *mesh, const PetscInt *vertex_body, PetscReal *box, PetscReal all[4])
{
  for (PetscInt i = 0; i < 4 * mesh->n_bodies; i++) box[i] = i % 4 < 2 ? PETSC_INFINITY : PETSC_NINFINITY;
  for (int i = 0; i < 4; i++) all[i] = i < 2 ? PETSC_INFINITY : PETSC_NINFINITY;
  for (PetscInt v = 0; v < mesh->n_vertices; v++)
    for (int a = 0; a < 2; a++) {
      PetscReal *b = box + 4 * vertex_body[v] + a;
      b[0] = PetscMin(b[0], mesh->X[2 * v + a]), b[2] = PetscMax(b[2], mesh->X[2 * v + a]);
      all[a] = PetscMin(all[a], b[0]), all[a + 2] = PetscMax(all[a + 2], b[2]);
    }
}

/* Finds rank, (n_bodies,), the place of each macroblock in a sweep over the mesh. The sweep goes strip after
   strip; strips run across the longer side of the mesh and are as thick as the median body. The sweep is
   needed because joints connect macroblocks, but no block does, so bodies that touch could stand far apart
   in memory. In a sweep the neighbours of a body are within two strips, and a cycle walks through all arrays
   as a few streams, which the prefetcher follows; along a space-filling curve it would jump. */
static PetscErrorCode rank_bodies(const BlockMesh *mesh, const PetscInt *vertex_body, PetscInt *rank)
{
  const PetscInt n = mesh->n_bodies;
  PetscReal *box, *size, all[4];
  BodyKey *key;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(4 * (size_t)n, &box, n, &size, n, &key));
  body_boxes(mesh, vertex_body, box, all);
  const int across = all[2] - all[0] >= all[3] - all[1] ? 0 : 1; /* direction of the sweep */
  for (PetscInt i = 0; i < n; i++) size[i] = box[4 * i + 2 + across] - box[4 * i + across];
  PetscCall(PetscRealSortSemiOrdered(n, size));
  const PetscReal thick = size[n / 2];
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *b = box + 4 * i;
    key[i].strip = PetscFloorReal((0.5 * (b[across] + b[2 + across]) - all[across]) / thick);
    key[i].along = 0.5 * (b[1 - across] + b[3 - across]);
    key[i].body = i;
  }
  qsort(key, (size_t)n, sizeof *key, compare_body_keys);
  for (PetscInt i = 0; i < n; i++) rank[key[i].body] = i;
  PetscCall(PetscFree3(box, size, key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the macroblocks one after the other; within each, vertices keep the order of old. */
static PetscErrorCode group_by_body(const BlockMesh *mesh, PetscInt *old)
{
  const PetscInt n = mesh->n_vertices;
  PetscInt *vertex_body, *rank, *start, *grouped;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(n, &vertex_body, mesh->n_bodies, &rank, n, &grouped));
  PetscCall(PetscCalloc1((size_t)mesh->n_bodies + 1, &start));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) vertex_body[mesh->blocks[i]] = mesh->body[i / 4];
  PetscCall(rank_bodies(mesh, vertex_body, rank));
  for (PetscInt v = 0; v < n; v++) start[rank[vertex_body[v]] + 1]++;
  for (PetscInt i = 0; i < mesh->n_bodies; i++) start[i + 1] += start[i];
  for (PetscInt v = 0; v < n; v++) grouped[start[rank[vertex_body[old[v]]]]++] = old[v];
  PetscCall(PetscArraycpy(old, grouped, n));
  PetscCall(PetscFree(start));
  PetscCall(PetscFree3(vertex_body, rank, grouped));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt vertex[4]; /* ascending; PETSC_MAX_INT for the fourth of a triangle */
  PetscInt old;
} BlockKey;

static int compare_block_keys(const void *a, const void *b)
{
  const BlockKey *x = a, *y = b;
  for (int i = 0; i < 4; i++)
    if (x->vertex[i] != y->vertex[i]) return x->vertex[i] < y->vertex[i] ? -1 : 1;
  return (x->old > y->old) - (x->old < y->old);
}

/* Finds old, (n_blocks,), the old number of each new block. Blocks are ordered by their lowest vertex, then
   by the next ones, then by the old number. */
static PetscErrorCode order_blocks(const BlockMesh *mesh, PetscInt *old)
{
  BlockKey *key;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->n_blocks, &key));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    for (int i = 0; i < 4; i++) {
      const PetscInt v = mesh->blocks[4 * b + i] < 0 ? PETSC_MAX_INT : mesh->blocks[4 * b + i];
      int at = i;
      for (; at > 0 && key[b].vertex[at - 1] > v; at--) key[b].vertex[at] = key[b].vertex[at - 1];
      key[b].vertex[at] = v;
    }
    key[b].old = b;
  }
  qsort(key, (size_t)mesh->n_blocks, sizeof *key, compare_block_keys);
  for (PetscInt b = 0; b < mesh->n_blocks; b++) old[b] = key[b].old;
  PetscCall(PetscFree(key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves row old[i] of a table of integers to row i. */
static PetscErrorCode permute_rows(PetscInt n, PetscInt width, const PetscInt *old, PetscInt **table)
{
  PetscInt *moved;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)n * (size_t)width, &moved));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < width; j++) moved[width * i + j] = (*table)[width * old[i] + j];
  PetscCall(PetscFree(*table));
  *table = moved;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode renumber_vertices(BlockMesh *mesh)
{
  const PetscInt n = mesh->n_vertices;
  PetscInt *old, *new;
  PetscReal *X;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &old, n, &new));
  PetscCall(order_vertices(mesh, old));
  PetscCall(group_by_body(mesh, old));
  for (PetscInt v = 0; v < n; v++) new[old[v]] = v;

  PetscCall(PetscMalloc1(2 * (size_t)n, &X));
  for (PetscInt v = 0; v < n; v++)
    for (int a = 0; a < 2; a++) X[2 * v + a] = mesh->X[2 * old[v] + a];
  PetscCall(PetscFree(mesh->X));
  mesh->X = X;
  PetscCall(permute_rows(n, 1, old, &mesh->vertex_file));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) mesh->blocks[i] = new[mesh->blocks[i]];
  for (PetscInt p = 0; p < mesh->n_points; p++) mesh->point_vertex[p] = new[mesh->point_vertex[p]];
  PetscCall(PetscFree2(old, new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode renumber_blocks(BlockMesh *mesh)
{
  const PetscInt n = mesh->n_blocks;
  PetscInt *old, *new;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &old, n, &new));
  PetscCall(order_blocks(mesh, old));
  for (PetscInt b = 0; b < n; b++) new[old[b]] = b;
  PetscCall(permute_rows(n, 4, old, &mesh->blocks));
  PetscCall(permute_rows(n, 1, old, &mesh->block_group));
  PetscCall(permute_rows(n, 1, old, &mesh->block_file));
  PetscCall(permute_rows(n, 1, old, &mesh->body));
  for (PetscInt s = 0; s < mesh->n_face_sets; s++)
    for (PetscInt i = 0; i < mesh->face_sets[s].n; i++)
      mesh->face_sets[s].faces[2 * i] = new[mesh->face_sets[s].faces[2 * i]];
  PetscCall(PetscFree2(old, new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the macroblocks by first appearance. */
static PetscErrorCode renumber_bodies(BlockMesh *mesh)
{
  PetscInt *new, count = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->n_bodies, &new));
  for (PetscInt i = 0; i < mesh->n_bodies; i++) new[i] = -1;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    PetscInt *number = &new[mesh->body[b]];
    if (*number < 0) *number = count++;
    mesh->body[b] = *number;
  }
  PetscCall(PetscFree(new));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshReorder(BlockMesh *mesh)
{
  PetscFunctionBegin;
  if (mesh->n_blocks == 0) PetscFunctionReturn(PETSC_SUCCESS); /* any rank but 0 */
  PetscCall(renumber_vertices(mesh));
  PetscCall(renumber_blocks(mesh));
  PetscCall(renumber_bodies(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

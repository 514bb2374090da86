/* topology.c: what follows from the blocks' vertices alone: edges, outer faces, and the order in which
   Quoin numbers vertices, blocks and macroblocks. All on rank 0, before the mesh is distributed. */
#include "internal.h"
#include <petscmat.h>
#include <stdlib.h>

static inline PetscInt corners_of(const PetscInt *block)
{
  return block[3] < 0 ? 3 : 4;
}

/* ---- macroblocks */

/* Of a tree of vertices that are known to be connected; halves the path on the way. */
static PetscInt find_root(PetscInt *parent, PetscInt v)
{
  for (; parent[v] != v; v = parent[v]) parent[v] = parent[parent[v]];
  return v;
}

/* Connected components of blocks over shared vertices, numbered by first appearance; identity numbers of
   file. Entries out of range are passed over here: they are for MeshCheck to name. */
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
    mesh->body[b] = -1; /* for now: a vertex of the block */
    for (PetscInt k = 0; k < 4; k++) {
      const PetscInt v = mesh->blocks[4 * b + k];
      if (v < 0 || v >= n) continue;
      if (mesh->body[b] < 0)
        mesh->body[b] = v;
      else
        parent[find_root(parent, v)] = find_root(parent, mesh->body[b]);
    }
  }
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt root = mesh->body[b] < 0 ? -1 : find_root(parent, mesh->body[b]);
    if (root >= 0 && label[root] < 0) label[root] = mesh->n_bodies++;
    mesh->body[b] = root < 0 ? mesh->n_bodies++ : label[root];
  }
  PetscCall(PetscFree2(parent, label));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshSeparate(BlockMesh *mesh, const PetscBool *separate)
{
  const PetscInt n = mesh->n_vertices;
  PetscInt *source, count = n; // source: (count,) vertex that each one is, or copies
  PetscBool *taken;            // (n,) by a block that keeps it
  PetscReal *X;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)n + 4 * (size_t)mesh->n_blocks, &source));
  PetscCall(PetscCalloc1(n, &taken));
  for (PetscInt v = 0; v < n; v++) source[v] = v;
  for (int pass = 0; pass < 2; pass++) // other groups come first
    for (PetscInt b = 0; b < mesh->n_blocks; b++)
      for (PetscInt k = 0; k < corners_of(mesh->blocks + 4 * b); k++) {
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

/* Edges numbered so far, in chains by a hash of their two vertices. */
typedef struct {
  PetscInt n;
  PetscInt *vertices;    /* (n,2) in the direction of the first block */
  PetscInt *head, *next; /* (mask + 1,), (n,) */
  unsigned mask;
} EdgeTable;

/* The edge a-b, a new one if need be; -(edge + 1) when it is there as b-a. */
static PetscInt find_or_add_edge(EdgeTable *table, PetscInt a, PetscInt b)
{
  /* linear in the vertices, so that a mesh in good order walks through the table; the odd factor keeps fans
     and strips, where the two vertices depend on each other linearly, from one chain */
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
  for (PetscInt b = 0; b < mesh->n_blocks; b++) n_sides += (size_t)corners_of(mesh->blocks + 4 * b);
  while (table.mask < n_sides / 2) table.mask = 2 * table.mask + 1; /* most edges have two sides */
  PetscCall(PetscMalloc2((size_t)table.mask + 1, &table.head, n_sides, &table.next));
  PetscCall(PetscMalloc1(2 * n_sides, &table.vertices));
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, block_edges));
  for (size_t i = 0; i <= table.mask; i++) table.head[i] = -1;

  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *v = mesh->blocks + 4 * b, corners = corners_of(v);
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
    for (PetscInt k = 0; k < corners_of(mesh->blocks + 4 * b); k++)
      uses[EDGE_INDEX(block_edges[4 * b + k])]++;
  for (PetscInt e = 0; e < n_edges; e++) count += uses[e] == 1;

  PetscCall(PetscMalloc1(2 * (size_t)count, faces));
  *n = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (PetscInt k = 0; k < corners_of(mesh->blocks + 4 * b); k++)
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

/* Compressed rows: each vertex with all vertices it shares a block with, itself included, ascending. */
static PetscErrorCode vertex_graph(const BlockMesh *mesh, PetscInt **row_start, PetscInt **columns)
{
  PetscInt *start, *around, *seen, n = 0;
  size_t size = 0;

  PetscFunctionBegin;
  PetscCall(MeshVertexBlocks(mesh, &start, &around));
  /* a vertex of c blocks has at most 3 c others */
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
      const PetscInt *block = mesh->blocks + 4 * around[i], corners = corners_of(block);
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

/* old: (n_vertices,) old number of each new vertex, by reverse Cuthill-McKee within each macroblock. */
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

/* box: (n_bodies,4) low x, y and high x, y of each macroblock; all: of the mesh. */
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

/* rank: (n_bodies,) place of each macroblock in a sweep over the mesh: strips across its longer side, as
   thick as the median body, one after the other. Joints connect macroblocks, but no block does: without
   this, bodies that touch could stand far apart in memory. In a sweep the neighbours of a body are within
   two strips, and all arrays are walked through as a few streams, which the prefetcher follows; a
   space-filling curve jumps. */
static PetscErrorCode rank_bodies(const BlockMesh *mesh, const PetscInt *vertex_body, PetscInt *rank)
{
  const PetscInt n = mesh->n_bodies;
  PetscReal *box, *size, all[4];
  BodyKey *key;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(4 * (size_t)n, &box, n, &size, n, &key));
  body_boxes(mesh, vertex_body, box, all);
  const int across = all[2] - all[0] >= all[3] - all[1] ? 0 : 1; /* the sweep goes this way */
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

/* Puts the macroblocks one after the other; within each, the order of old stays. */
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

/* old: (n_blocks,) old number of each new block: by lowest vertex, then the next
   ones, then the old number. */
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

/* Macroblocks in order of first appearance. */
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
  if (mesh->n_blocks == 0) PetscFunctionReturn(PETSC_SUCCESS); /* not rank 0 */
  PetscCall(renumber_vertices(mesh));
  PetscCall(renumber_blocks(mesh));
  PetscCall(renumber_bodies(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

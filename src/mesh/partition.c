/* partition.c: decides which rank owns which block. METIS cuts the graph of blocks, which has an edge for
   every shared vertex and for every pair of outer faces that are near each other across a joint. Works on
   rank 0. */
#include "mesh/mesh.h"
#include <metis.h>

_Static_assert(sizeof(idx_t) == sizeof(PetscInt), "METIS and PETSc must use integers of the same width");

enum {
  VERTEX_WEIGHT = 1,
  CONTACT_WEIGHT = 2
}; /* weights of edges: a ghost of a contact costs more than a shared vertex */

typedef struct {
  const BlockMesh *mesh;
  const PetscInt *faces; /* (n,2) block, k */
} NearContext;

static PetscBool different_bodies(PetscInt f, PetscInt g, const void *context)
{
  const NearContext *near = context;
  return (PetscBool)(near->mesh->body[near->faces[2 * f]] != near->mesh->body[near->faces[2 * g]]);
}

/* Finds pairs of blocks (n_pairs,2) of different macroblocks whose outer faces come within `margin` of each
   other. */
static PetscErrorCode near_blocks(const BlockMesh *mesh, PetscReal margin, PetscInt *n_pairs,
                                  PetscInt **pairs)
{
  PetscInt n_faces, *faces, *start, *near, n = 0;
  PetscReal *box;
  PetscFunctionBeginUser;
  PetscCall(MeshOuterBoxes(mesh, margin, &n_faces, &faces, &box));
  PetscCall(GridRows(n_faces, box, different_bodies, &(NearContext){mesh, faces}, &start, &near));
  PetscCall(PetscFree(box));
  PetscCall(PetscMalloc1(start[n_faces], pairs));
  for (PetscInt f = 0; f < n_faces; f++)
    for (PetscInt p = start[f]; p < start[f + 1]; p++) {
      if (near[p] < f) continue;
      (*pairs)[n++] = faces[2 * f];
      (*pairs)[n++] = faces[2 * near[p]];
    }
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscCall(PetscFree(faces));
  *n_pairs = n / 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a block is part of a rigid or condensed body. */
static PetscBool in_body(const BodyNumbers *bodies, PetscInt b)
{
  return (PetscBool)(bodies->rigid[b] >= 0 || bodies->condensed[b] >= 0);
}

/* Makes the nodes of the graph. A rigid or condensed body and every block that touches one of its vertices
   are one node, so that they stay on one rank; any other block is a node by itself. node: (n_blocks,). */
static PetscErrorCode graph_nodes(const BlockMesh *mesh, const BodyNumbers *bodies, const PetscInt *start,
                                  const PetscInt *blocks, PetscInt *n_nodes, PetscInt *node)
{
  PetscInt *parent;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(mesh->n_blocks, &parent));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) parent[b] = b;
  for (PetscInt v = 0; v < mesh->n_vertices; v++) {
    PetscInt holder = -1;
    for (PetscInt i = start[v]; i < start[v + 1]; i++)
      if (in_body(bodies, blocks[i])) holder = blocks[i];
    if (holder < 0) continue;
    for (PetscInt i = start[v]; i < start[v + 1]; i++)
      parent[UnionRoot(parent, blocks[i])] = UnionRoot(parent, holder);
  }
  *n_nodes = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) node[b] = -1;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt r = UnionRoot(parent, b);
    if (node[r] < 0) node[r] = (*n_nodes)++;
    node[b] = node[r];
  }
  PetscCall(PetscFree(parent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt n, *start, *item;
} Csr;

/* Lists the items of each node: item i belongs to node of[i]. */
static PetscErrorCode csr_invert(PetscInt n_nodes, PetscInt n_items, const PetscInt *of, PetscInt stride,
                                 Csr *csr)
{
  PetscFunctionBeginUser;
  csr->n = n_nodes;
  PetscCall(PetscCalloc1(n_nodes + 2, &csr->start));
  PetscCall(PetscMalloc1(n_items, &csr->item));
  for (PetscInt i = 0; i < n_items; i++) csr->start[of[i * stride] + 2]++;
  for (PetscInt b = 0; b < n_nodes; b++) csr->start[b + 2] += csr->start[b + 1];
  for (PetscInt i = 0; i < n_items; i++) csr->item[csr->start[of[i * stride] + 1]++] = i;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode csr_free(Csr *csr)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(csr->start));
  PetscCall(PetscFree(csr->item));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  idx_t n, *xadj, *adjncy, *adjwgt, *vwgt;
  PetscInt *mark, *where, filled, node; /* used while a row is built */
} Graph;

static void graph_add(Graph *g, PetscInt other, PetscInt weight)
{
  if (other == g->node) return;
  if (g->mark[other] != g->node) {
    g->mark[other] = g->node;
    g->where[other] = g->filled++;
    if (g->adjncy) g->adjncy[g->where[other]] = other;
    if (g->adjncy) g->adjwgt[g->where[other]] = 0;
  }
  if (g->adjncy) g->adjwgt[g->where[other]] += weight;
}

/* Sweeps over all nodes: counts edges while g->adjncy is NULL, fills them afterwards. */
static void graph_sweep(Graph *g, const BlockMesh *mesh, const PetscInt *node, const Csr *members,
                        const Csr *at_vertex, const Csr *near, const PetscInt *pairs)
{
  g->filled = 0;
  for (PetscInt i = 0; i < g->n; i++) g->mark[i] = -1;
  for (g->node = 0; g->node < g->n; g->node++) {
    g->xadj[g->node] = g->filled;
    for (PetscInt m = members->start[g->node]; m < members->start[g->node + 1]; m++) {
      const PetscInt b = members->item[m];
      for (int k = 0; k < 4 && mesh->blocks[4 * b + k] >= 0; k++) {
        const PetscInt v = mesh->blocks[4 * b + k];
        for (PetscInt i = at_vertex->start[v]; i < at_vertex->start[v + 1]; i++)
          graph_add(g, node[at_vertex->item[i]], VERTEX_WEIGHT);
      }
      for (PetscInt i = near->start[b]; i < near->start[b + 1]; i++)
        graph_add(g, node[pairs[near->item[i] ^ 1]], CONTACT_WEIGHT);
    }
  }
  g->xadj[g->n] = g->filled;
}

static PetscErrorCode graph_build(const BlockMesh *mesh, const BodyNumbers *bodies, PetscReal margin,
                                  Graph *g, PetscInt *node)
{
  Csr members, at_vertex = {0}, near;
  PetscInt n_pairs, *pairs;
  PetscFunctionBeginUser;
  PetscCall(MeshVertexBlocks(mesh, &at_vertex.start, &at_vertex.item));
  PetscCall(graph_nodes(mesh, bodies, at_vertex.start, at_vertex.item, &g->n, node));
  PetscCall(near_blocks(mesh, margin, &n_pairs, &pairs));
  PetscCall(csr_invert(g->n, mesh->n_blocks, node, 1, &members));
  PetscCall(csr_invert(mesh->n_blocks, 2 * n_pairs, pairs, 1, &near));
  PetscCall(PetscMalloc1(g->n + 1, &g->xadj));
  PetscCall(PetscMalloc2(g->n, &g->mark, g->n, &g->where));
  graph_sweep(g, mesh, node, &members, &at_vertex, &near, pairs);
  PetscCall(PetscMalloc3(g->filled, &g->adjncy, g->filled, &g->adjwgt, g->n, &g->vwgt));
  graph_sweep(g, mesh, node, &members, &at_vertex, &near, pairs);
  // a deformable block costs as much as its vertices, a rigid or condensed one next to nothing; a contact
  // costs half a block on either side
  PetscCall(PetscArrayzero(g->vwgt, g->n));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    g->vwgt[node[b]] += in_body(bodies, b) ? 1 : (mesh->blocks[4 * b + 3] < 0 ? 3 : 4);
  for (PetscInt i = 0; i < 2 * n_pairs; i++) g->vwgt[node[pairs[i]]] += CONTACT_WEIGHT;
  PetscCall(PetscFree2(g->mark, g->where));
  PetscCall(csr_free(&members));
  PetscCall(csr_free(&near));
  PetscCall(csr_free(&at_vertex));
  PetscCall(PetscFree(pairs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode cut_by_metis(Graph *g, PetscMPIInt n_parts, idx_t *node_part)
{
  idx_t options[METIS_NOPTIONS], one = 1, parts = n_parts, cut;
  int status = METIS_OK;
  PetscFunctionBeginUser;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  if (g->n > n_parts) {
    // recursive bisection leaves fewer ranks empty when there are few nodes for each
    if (g->n < 64 * n_parts)
      status = METIS_PartGraphRecursive(&g->n, &one, g->xadj, g->adjncy, g->vwgt, NULL, g->adjwgt, &parts,
                                        NULL, NULL, options, &cut, node_part);
    else
      status = METIS_PartGraphKway(&g->n, &one, g->xadj, g->adjncy, g->vwgt, NULL, g->adjwgt, &parts, NULL,
                                   NULL, options, &cut, node_part);
  } else {
    for (PetscInt i = 0; i < g->n; i++) node_part[i] = i;
  }
  PetscCheck(status == METIS_OK, PETSC_COMM_SELF, PETSC_ERR_LIB, "METIS returned %d", status);
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscReal x, y; /* [m] lowest corner of the node's blocks, in x, then in y */
  PetscInt node;
} NodePlace;

static int place_order(const void *a, const void *b)
{
  const NodePlace *p = a, *q = b;
  if (p->x != q->x) return p->x < q->x ? -1 : 1;
  if (p->y != q->y) return p->y < q->y ? -1 : 1;
  return (p->node > q->node) - (p->node < q->node);
}

/* Cuts stripes of equal weight, from left to right. This is seldom the best cut, but it is predictable. */
static PetscErrorCode cut_in_stripes(const BlockMesh *mesh, const PetscInt *node, const Graph *g,
                                     PetscMPIInt n_parts, idx_t *node_part)
{
  NodePlace *place;
  PetscInt64 total = 0, before = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(g->n, &place));
  for (PetscInt i = 0; i < g->n; i++) place[i] = (NodePlace){PETSC_INFINITY, PETSC_INFINITY, i};
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++) {
    if (mesh->blocks[i] < 0) continue;
    const PetscReal *X = mesh->X + 2 * mesh->blocks[i];
    NodePlace *p = place + node[i / 4];
    p->x = PetscMin(p->x, X[0]), p->y = PetscMin(p->y, X[1]);
  }
  qsort(place, (size_t)g->n, sizeof *place, place_order);
  for (PetscInt i = 0; i < g->n; i++) total += g->vwgt[i];
  for (PetscInt i = 0; i < g->n; i++) { // a node goes to the stripe that holds the middle of its weight
    const PetscInt64 weight = g->vwgt[place[i].node];
    node_part[place[i].node] = (idx_t)((2 * before + weight) * n_parts / (2 * total));
    before += weight;
  }
  PetscCall(PetscFree(place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartitionBlocks(const BlockMesh *mesh, const BodyNumbers *bodies, PartitionKind kind,
                               PetscReal margin, PetscMPIInt n_parts, PetscInt *part)
{
  Graph g = {0};
  PetscInt *node;
  idx_t *node_part;
  PetscFunctionBeginUser;
  if (n_parts == 1 || !mesh->n_blocks) { // METIS divides by zero for a single rank
    PetscCall(PetscArrayzero(part, mesh->n_blocks));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(mesh->n_blocks, &node));
  PetscCall(graph_build(mesh, bodies, margin, &g, node));
  PetscCall(PetscCalloc1(g.n, &node_part));
  if (kind == PARTITION_STRIPES)
    PetscCall(cut_in_stripes(mesh, node, &g, n_parts, node_part));
  else
    PetscCall(cut_by_metis(&g, n_parts, node_part));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) part[b] = node_part[node[b]];
  PetscCall(PetscFree(g.xadj));
  PetscCall(PetscFree3(g.adjncy, g.adjwgt, g.vwgt));
  PetscCall(PetscFree(node));
  PetscCall(PetscFree(node_part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

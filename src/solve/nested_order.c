/* nested_order.c: finds the order in which the rows of the elastic stiffness are eliminated: nested
   dissection by METIS, the elimination tree, supernodes, and parts of the tree for the ranks.

   Nodes are rigid bodies and deformable vertices. Column j of the factor has the entries of the matrix below
   the diagonal and those of the columns whose parent j is; the parent of a column is its first row below the
   diagonal (Liu, SIAM J. Matrix Anal. Appl. 11, 1990). Columns with the same rows make a supernode. A child
   that stands right before its parent joins it where that adds few zeros. */
#include "solve/nested.h"
#include <metis.h>

/* [-] part of zeros that a supernode of up to this many columns may have */
static const struct {
  PetscInt width;
  PetscReal zeros;
} RELAXED[] = {{6, 0.6}, {18, 0.25}, {PETSC_MAX_INT, 0.08}};
static const PetscReal UNEVEN = 1.15; /* [-] largest work of a subtree over the mean of a part */

typedef struct {
  PetscInt n;
  PetscInt *start, *near; /* neighbours of each node */
  PetscInt *place, *at;   /* place of each node in the order; the node at each place */
} Nodes;

/* ---- the order of nodes */

/* Finds the neighbours of each node of the matrix, each once. */
static PetscErrorCode find_neighbours(const ElasticMatrix *x, Nodes *g)
{
  const PetscInt n = x->n_nodes;
  PetscInt *node, *mark, *count, n_near = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(x->n, &node, n, &mark));
  PetscCall(PetscCalloc1(n, &count));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt row = x->node_start[i]; row < x->node_start[i + 1]; row++) node[row] = i;
  PetscCall(PetscMalloc3(n + 1, &g->start, n, &g->place, n, &g->at));
  for (int pass = 0; pass < 2; pass++) { // counts, then fills
    for (PetscInt i = 0; i < n; i++) mark[i] = -1;
    if (pass) {
      for (PetscInt i = 0; i < n; i++) g->start[i] = n_near, n_near += count[i], count[i] = g->start[i];
      g->start[n] = n_near;
      PetscCall(PetscMalloc1(n_near, &g->near));
    }
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt row = x->node_start[i]; row < x->node_start[i + 1]; row++)
        for (PetscInt e = x->start[row]; e < x->start[row + 1]; e++) {
          const PetscInt j = node[x->column[e]];
          if (j == i || mark[j] == i) continue;
          mark[j] = i;
          if (pass) g->near[count[i]] = j, g->near[count[j]] = i;
          count[i]++, count[j]++;
        }
  }
  g->n = n;
  PetscCall(PetscFree2(node, mark));
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds out whether METIS will have memory, because METIS prints lines where it has none. */
static PetscErrorCode has_memory(const Nodes *g)
{
  enum {
    CORE = 1 << 16,
    PER_NUMBER = 32
  }; // [byte] measured: 50 kB, and 26 bytes for each number of the graph
  char *room;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)CORE + PER_NUMBER * ((size_t)g->n + (size_t)g->start[g->n]), &room));
  PetscCall(PetscFree(room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders the nodes by nested dissection. */
static PetscErrorCode dissect(const ElasticMatrix *x, Nodes *g)
{
  idx_t n = (idx_t)g->n, options[METIS_NOPTIONS], *start, *near, *weight, *at, *place;
  PetscFunctionBeginUser;
  PetscCall(has_memory(g));
  PetscCall(PetscMalloc5(g->n + 1, &start, g->start[g->n], &near, g->n, &weight, g->n, &at, g->n, &place));
  for (PetscInt i = 0; i <= g->n; i++) start[i] = (idx_t)g->start[i];
  for (PetscInt i = 0; i < g->start[g->n]; i++) near[i] = (idx_t)g->near[i];
  for (PetscInt i = 0; i < g->n; i++)
    weight[i] = (idx_t)(x->node_start[i + 1] - x->node_start[i]), place[i] = i;
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const int status = g->start[g->n] ? METIS_NodeND(&n, start, near, weight, options, at, place) : METIS_OK;
  PetscCheck(status == METIS_OK, PETSC_COMM_SELF,
             status == METIS_ERROR_MEMORY ? PETSC_ERR_MEM : PETSC_ERR_LIB, "METIS returned %d", status);
  for (PetscInt i = 0; i < g->n; i++) g->place[i] = (PetscInt)place[i], g->at[place[i]] = i;
  PetscCall(PetscFree5(start, near, weight, at, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the parent of each place in the elimination tree; -1: none. */
static PetscErrorCode find_parents(const Nodes *g, PetscInt *parent)
{
  PetscInt *ancestor;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(g->n, &ancestor));
  for (PetscInt j = 0; j < g->n; j++) {
    parent[j] = ancestor[j] = -1;
    for (PetscInt e = g->start[g->at[j]]; e < g->start[g->at[j] + 1]; e++)
      for (PetscInt i = g->place[g->near[e]], next; i >= 0 && i < j; i = next) {
        next = ancestor[i], ancestor[i] = j;
        if (next < 0) parent[i] = j;
      }
  }
  PetscCall(PetscFree(ancestor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves the nodes so that each subtree of the elimination tree stands right before its root. */
static PetscErrorCode order_subtrees(Nodes *g, PetscInt *parent)
{
  PetscInt *first, *next, *place, *at, *old_parent, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc5(g->n, &first, g->n, &next, g->n, &place, g->n, &at, g->n, &old_parent));
  for (PetscInt i = 0; i < g->n; i++) first[i] = -1;
  for (PetscInt i = g->n; i-- > 0;)
    if (parent[i] >= 0) next[i] = first[parent[i]], first[parent[i]] = i;
  for (PetscInt root = 0; root < g->n; root++) {
    if (parent[root] >= 0) continue;
    for (PetscInt i = root; i >= 0;) {
      if (first[i] >= 0) { // a child first
        const PetscInt child = first[i];
        first[i] = next[child], i = child;
        continue;
      }
      place[i] = n++, i = parent[i];
    }
  }
  PetscCall(PetscArraycpy(old_parent, parent, g->n));
  PetscCall(PetscArraycpy(at, g->at, g->n));
  for (PetscInt i = 0; i < g->n; i++) {
    parent[place[i]] = old_parent[i] < 0 ? -1 : place[old_parent[i]];
    g->at[place[i]] = at[i], g->place[at[i]] = place[i];
  }
  PetscCall(PetscFree5(first, next, place, at, old_parent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- supernodes */

/* A supernode while it is built: places first .. last, and the places of nodes below. */
typedef struct {
  PetscInt first, last, parent; /* parent: a supernode; -1: none */
  PetscInt n, *below;           /* ascending */
  PetscInt columns, rows;       /* of the matrix: its own, and those below */
  PetscReal zeros, work;        /* work: of its subtree */
  PetscInt head;                /* first supernode of its subtree */
} Super;

/* Finds the rows below each column, from its neighbours and its children; *below: (n_below of all,). */
static PetscErrorCode find_columns(const Nodes *g, const PetscInt *parent, PetscInt *start, PetscInt **below)
{
  PetscInt *first, *next, *mark, *to;
  PetscSegBuffer all;
  PetscInt **column;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(g->n, &first, g->n, &next, g->n, &mark, g->n, &column));
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 65536, &all));
  for (PetscInt i = 0; i < g->n; i++) first[i] = mark[i] = -1;
  start[0] = 0;
  for (PetscInt j = 0; j < g->n; j++) {
    PetscInt most = g->start[g->at[j] + 1] - g->start[g->at[j]], n = 0;
    for (PetscInt c = first[j]; c >= 0; c = next[c]) most += start[c + 1] - start[c];
    PetscCall(PetscSegBufferGet(all, (size_t)most, &to));
    mark[j] = j;
    for (PetscInt e = g->start[g->at[j]]; e < g->start[g->at[j] + 1]; e++) {
      const PetscInt i = g->place[g->near[e]];
      if (i > j && mark[i] != j) mark[i] = j, to[n++] = i;
    }
    for (PetscInt c = first[j]; c >= 0; c = next[c])
      for (PetscInt e = 0; e < start[c + 1] - start[c]; e++)
        if (mark[column[c][e]] != j) mark[column[c][e]] = j, to[n++] = column[c][e];
    PetscCall(PetscSortInt(n, to));
    PetscCall(PetscSegBufferUnuse(all, (size_t)(most - n)));
    column[j] = to, start[j + 1] = start[j] + n;
    if (parent[j] >= 0) next[j] = first[parent[j]], first[parent[j]] = j;
  }
  PetscCall(PetscSegBufferExtractAlloc(all, below));
  PetscCall(PetscSegBufferDestroy(&all));
  PetscCall(PetscFree4(first, next, mark, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt width_of(const ElasticMatrix *x, const Nodes *g, PetscInt place)
{
  return x->node_start[g->at[place] + 1] - x->node_start[g->at[place]];
}

/* Makes supernodes of places with the same rows. */
static PetscErrorCode find_supers(const ElasticMatrix *x, const Nodes *g, const PetscInt *parent,
                                  const PetscInt *start, PetscInt *below, PetscInt *n_supers, Super *super)
{
  PetscInt *of, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(g->n, &of));
  for (PetscInt j = 0; j < g->n; j++) {
    if (!j || parent[j - 1] != j || start[j] - start[j - 1] != start[j + 1] - start[j] + 1)
      super[n++] = (Super){.first = j};
    Super *s = super + n - 1;
    of[j] = n - 1, s->last = j, s->columns += width_of(x, g, j);
    s->n = start[j + 1] - start[j], s->below = below + start[j];
  }
  for (PetscInt i = 0; i < n; i++) {
    super[i].parent = super[i].n ? of[super[i].below[0]] : -1;
    for (PetscInt e = 0; e < super[i].n; e++) super[i].rows += width_of(x, g, super[i].below[e]);
  }
  *n_supers = n;
  PetscCall(PetscFree(of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Joins children to the parents that they stand right before, where that adds few zeros. */
static PetscErrorCode join_supers(PetscInt *n_supers, Super *super)
{
  PetscInt *end, *now, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(*n_supers, &end, *n_supers, &now)); // end: last supernode that joined this one
  for (PetscInt i = *n_supers; i-- > 0;) {
    Super *s = super + i, *next = super + i + 1;
    PetscInt limit = 0;
    end[i] = i;
    if (s->parent < 0 || s->parent > end[i + 1]) continue;
    const PetscInt columns = s->columns + next->columns;
    const PetscReal zeros = s->zeros + next->zeros +
                            (PetscReal)s->columns * (PetscReal)(next->columns + next->rows - s->rows),
                    all = (PetscReal)columns * (PetscReal)(columns + next->rows);
    while (columns > RELAXED[limit].width) limit++;
    if (zeros > RELAXED[limit].zeros * all) continue;
    s->last = next->last, s->n = next->n, s->below = next->below, s->columns = columns, s->rows = next->rows;
    s->zeros = zeros, s->parent = next->parent, end[i] = end[i + 1];
  }
  for (PetscInt i = 0; i < *n_supers; i = end[i] + 1, n++)
    for (PetscInt j = i; j <= end[i]; j++) now[j] = n;
  for (PetscInt i = 0, to = 0; i < *n_supers; i = end[i] + 1, to++) {
    super[to] = super[i];
    if (super[to].parent >= 0) super[to].parent = now[super[to].parent];
  }
  *n_supers = n;
  PetscCall(PetscFree2(end, now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- parts */

/* Deals subtrees to parts of about equal work. Where a subtree is too large for a part, its root goes to the
   top. part: (n_supers,) NESTED_PARTS: the top. */
static PetscErrorCode deal_parts(PetscInt n, Super *super, PetscInt *part)
{
  PetscReal total = 0., load[NESTED_PARTS] = {0.};
  PetscInt *order, *rank, n_roots = 0;
  PetscReal *work;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &order, n, &work));
  for (PetscInt i = 0; i < n; i++) super[i].head = i;
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt above = super[i].parent;
    const PetscReal own = (PetscReal)super[i].columns * (PetscReal)(super[i].columns + super[i].rows);
    super[i].work += own, total += own;
    if (above < 0) continue;
    super[above].work += super[i].work;
    super[above].head = PetscMin(super[above].head, super[i].head);
  }
  for (PetscInt i = n; i-- > 0;) {
    const PetscInt above = super[i].parent;
    if (above >= 0 && part[above] != NESTED_PARTS) {
      part[i] = -1; // within the subtree of its parent
      continue;
    }
    part[i] = super[i].work > UNEVEN * total / NESTED_PARTS && super[i].head < i ? NESTED_PARTS : 0;
    if (part[i] != NESTED_PARTS) order[n_roots] = i, work[n_roots++] = -super[i].work;
  }
  PetscCall(PetscMalloc1(n_roots, &rank));
  for (PetscInt i = 0; i < n_roots; i++) rank[i] = i;
  PetscCall(PetscSortRealWithPermutation(n_roots, work, rank));
  for (PetscInt i = 0; i < n_roots; i++) { // the largest first, each to the part with the least work
    PetscInt least = 0;
    for (PetscInt k = 1; k < NESTED_PARTS; k++)
      if (load[k] < load[least]) least = k;
    part[order[rank[i]]] = least, load[least] -= work[rank[i]];
  }
  for (PetscInt i = n; i-- > 0;)
    if (part[i] < 0) part[i] = part[super[i].parent];
  PetscCall(PetscFree(rank));
  PetscCall(PetscFree2(order, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers supernodes and columns part by part, and writes the rows of the matrix that they have. */
static PetscErrorCode write_order(const ElasticMatrix *x, const Nodes *g, PetscInt n, const Super *super,
                                  const PetscInt *part, NestedOrder *o)
{
  PetscInt *now, *column, n_columns = 0, n_rows = 0, to = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) n_rows += super[i].rows;
  o->n = x->n, o->n_supers = n;
  PetscCall(
      PetscMalloc5(x->n, &o->place, n + 1, &o->first, n + 1, &o->row_start, n_rows, &o->row, n, &o->parent));
  PetscCall(PetscMalloc2(n, &now, g->n, &column));
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    o->part[k] = to;
    for (PetscInt i = 0; i < n; i++) {
      if (part[i] != k) continue;
      now[i] = to, o->first[to++] = n_columns;
      for (PetscInt j = super[i].first; j <= super[i].last; j++)
        column[j] = n_columns, n_columns += width_of(x, g, j);
    }
  }
  o->first[n] = n_columns, n_rows = 0, to = 0;
  for (PetscInt k = 0; k <= NESTED_PARTS; k++)
    for (PetscInt i = 0; i < n; i++) {
      if (part[i] != k) continue;
      o->row_start[to] = n_rows, o->parent[to++] = super[i].parent < 0 ? -1 : now[super[i].parent];
      for (PetscInt e = 0; e < super[i].n; e++)
        for (PetscInt w = 0; w < width_of(x, g, super[i].below[e]); w++)
          o->row[n_rows++] = column[super[i].below[e]] + w;
    }
  o->row_start[n] = n_rows;
  for (PetscInt i = 0; i < g->n; i++)
    for (PetscInt row = x->node_start[i]; row < x->node_start[i + 1]; row++)
      o->place[row] = column[g->place[i]] + row - x->node_start[i];
  PetscCall(PetscFree2(now, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedOrderCreate(const ElasticMatrix *x, NestedOrder *o)
{
  Nodes g = {.n = x->n_nodes};
  PetscInt *parent, *start, *below, *part, n;
  Super *super;
  PetscFunctionBeginUser;
  PetscCall(find_neighbours(x, &g));
  PetscCall(dissect(x, &g));
  PetscCall(PetscMalloc3(g.n, &parent, g.n + 1, &start, g.n, &part));
  PetscCall(PetscMalloc1(g.n, &super));
  PetscCall(find_parents(&g, parent));
  PetscCall(order_subtrees(&g, parent));
  PetscCall(find_columns(&g, parent, start, &below));
  PetscCall(find_supers(x, &g, parent, start, below, &n, super));
  PetscCall(join_supers(&n, super));
  PetscCall(deal_parts(n, super, part));
  PetscCall(write_order(x, &g, n, super, part, o));
  PetscCall(PetscFree(below));
  PetscCall(PetscFree(super));
  PetscCall(PetscFree3(parent, start, part));
  PetscCall(PetscFree(g.near));
  PetscCall(PetscFree3(g.start, g.place, g.at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedOrderDestroy(NestedOrder *o)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(o->place, o->first, o->row_start, o->row, o->parent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

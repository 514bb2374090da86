/* grid.c: finds pairs of boxes that overlap or touch. It knows boxes only.

   The boxes are in a hierarchy of cell grids. Every box is filed once, in the cell of its lower left corner,
   in the grid whose cells are just larger than the box; the cells of the next grid are twice as large. A box
   is compared with the boxes of its own grid and of all coarser ones, and meets at most 3 x 3 cells in each.
   So memory is O(n) and time O(n x grids) for any mixture of sizes: one huge box sits alone in a coarse grid
   and costs each small box a search of 9 cells. (A single grid would file the huge box in all cells, or all
   small boxes in one cell.)

   Cells are found by hashing, so cells without boxes take no memory. Copies of the boxes stand in the order
   of the hash, which keeps tiles of 8 x 8 cells together: access to the next cell rarely leaves the cache. */
#include "mesh/mesh.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

enum {
  CELL_BITS = 28, /* the finest grid has at most 2^28 cells in a row */
  MAX_LEVELS = CELL_BITS + 4,
  TILE_BITS = 3,
  SAMPLE = 1000 /* number of boxes that give the proportions of a cell */
};

typedef struct {
  PetscReal box[4];
  uint64_t cell; /* level, row and column in one number */
  PetscInt id, level;
} Entry;

typedef struct {
  PetscInt n;
  const PetscReal *box;
  PetscReal origin[2];
  PetscReal per_cell[MAX_LEVELS][2];     /* [1/m] 1 / size of the cells of each level, finest first */
  PetscInt n_levels, levels[MAX_LEVELS]; /* levels that hold boxes, ascending */
  Entry *entry;                          /* (n,) by bucket */
  PetscInt *start;                       /* (mask + 2,) first entry of each bucket */
  unsigned mask;
} Grid;

static int compare_real(const void *a, const void *b)
{
  const PetscReal x = *(const PetscReal *)a, y = *(const PetscReal *)b;
  return (x > y) - (x < y);
}

/* Returns the mean width or height of a sample of boxes, in which the largest tenth counts as the 90 %
   quantile. So a few huge boxes do not decide alone, and neither do many boxes of zero width (axis-parallel
   faces). */
static PetscReal typical_extent(PetscInt n, const PetscReal *box, int axis)
{
  PetscReal extent[SAMPLE], sum = 0;
  const PetscInt count = PetscMin(n, SAMPLE);
  for (PetscInt s = 0; s < count; s++) {
    /* the sample is scattered, because boxes at equal steps could all be the same side of their blocks */
    const PetscInt i = n > SAMPLE ? (PetscInt)((uint64_t)s * 2654435769u % (uint64_t)n) : s;
    const PetscReal *b = box + 4 * i;
    extent[s] = b[2 + axis] - b[axis];
  }
  qsort(extent, (size_t)count, sizeof *extent, compare_real);
  for (PetscInt s = 0; s < count; s++) sum += PetscMin(extent[s], extent[9 * (count - 1) / 10]);
  return sum / (PetscReal)count;
}

/* Sets origin and cells of all levels: the typical box gives the proportions, the domain the size of the
   finest cells. */
static void set_cells(Grid *g)
{
  PetscReal base[2], low[2] = {PETSC_INFINITY, PETSC_INFINITY}, high[2] = {-PETSC_INFINITY, -PETSC_INFINITY};
  int exponent = 0;

  for (PetscInt i = 0; i < g->n; i++)
    for (int a = 0; a < 2; a++) {
      low[a] = PetscMin(low[a], g->box[4 * i + a]);
      high[a] = PetscMax(high[a], g->box[4 * i + 2 + a]);
    }
  for (int a = 0; a < 2; a++) base[a] = typical_extent(g->n, g->box, a);
  const PetscReal largest = PetscMax(base[0], base[1]);
  /* the factor 1.25 lets boxes a little larger than the typical one share its level */
  for (int a = 0; a < 2; a++) base[a] = largest > 0 ? 1.25 * PetscMax(base[a], 0.01 * largest) : 1;

  frexp(PetscMax((high[0] - low[0]) / base[0], (high[1] - low[1]) / base[1]), &exponent);
  for (int l = 0; l < MAX_LEVELS; l++)
    for (int a = 0; a < 2; a++)
      g->per_cell[l][a] = 1 / PetscMax(ldexp(base[a], exponent - CELL_BITS + l), DBL_MIN);
  for (int a = 0; a < 2; a++) g->origin[a] = low[a];
}

/* Returns the finest level whose cells are larger than the box. A margin of 1 % allows for rounding: a box
   must not reach a third cell. */
static PetscInt level_of(const Grid *g, const PetscReal *b)
{
  const PetscReal ratio = PetscMax((b[2] - b[0]) * g->per_cell[0][0], (b[3] - b[1]) * g->per_cell[0][1]);
  int exponent;
  frexp(1.01 * ratio, &exponent); /* ratio < 2^exponent */
  return PetscMin(PetscMax(exponent, 0), MAX_LEVELS - 1);
}

/* Returns the cell of x along an axis. x is never left of the origin, so cutting off the fraction rounds
   down. */
static inline PetscInt cell_of(const Grid *g, PetscInt level, int axis, PetscReal x)
{
  return (PetscInt)((x - g->origin[axis]) * g->per_cell[level][axis]);
}

static inline uint64_t cell_key(PetscInt level, PetscInt column, PetscInt row)
{
  return ((uint64_t)level << 58) | ((uint64_t)(unsigned)row << 29) | (uint64_t)(unsigned)column;
}

/* Returns the bucket of a cell. A tile lies in one piece; bits of its hash shuffle its cells, so that boxes
   at like places of many tiles do not share a bucket. */
static inline unsigned bucket_of(const Grid *g, PetscInt level, PetscInt column, PetscInt row)
{
  const unsigned c = (unsigned)column, r = (unsigned)row, side = (1u << TILE_BITS) - 1u;
  const unsigned tile = ((c >> TILE_BITS) * 2654435769u) ^
                        (((r >> TILE_BITS) * 2246822519u + (unsigned)level * 3266489917u) * 668265263u);
  const unsigned within = ((r & side) << TILE_BITS) | (c & side);
  return (((tile >> 10) << 2 * TILE_BITS) | (within ^ (tile >> 26))) & g->mask;
}

/* Sorts the boxes by bucket, by counting; within a bucket by number. */
static PetscErrorCode grid_create(PetscInt n, const PetscReal *box, Grid *g)
{
  PetscBool used[MAX_LEVELS] = {PETSC_FALSE};
  unsigned *bucket;
  PetscInt *level;

  PetscFunctionBegin;
  *g = (Grid){.n = n, .box = box, .mask = 63};
  set_cells(g);
  while (g->mask < (unsigned)n) g->mask = 2 * g->mask + 1;
  PetscCall(PetscMalloc2(n, &bucket, n, &level));
  PetscCall(PetscMalloc1(n, &g->entry));
  PetscCall(PetscCalloc1((size_t)g->mask + 3, &g->start));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *b = box + 4 * i;
    level[i] = level_of(g, b);
    used[level[i]] = PETSC_TRUE;
    bucket[i] = bucket_of(g, level[i], cell_of(g, level[i], 0, b[0]), cell_of(g, level[i], 1, b[1]));
    g->start[bucket[i] + 2]++;
  }
  for (unsigned b = 0; b <= g->mask; b++) g->start[b + 2] += g->start[b + 1];
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *b = box + 4 * i;
    const PetscInt l = level[i];
    g->entry[g->start[bucket[i] + 1]++] = (Entry){
        {b[0], b[1], b[2], b[3]}, cell_key(l, cell_of(g, l, 0, b[0]), cell_of(g, l, 1, b[1])), i, l};
  }
  for (PetscInt l = 0; l < MAX_LEVELS; l++)
    if (used[l]) g->levels[g->n_levels++] = l;
  PetscCall(PetscFree2(bucket, level));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the pairs of box a with those entries first .. end of a bucket that lie in one cell. */
static inline PetscErrorCode visit_entries(const Grid *g, const Entry *a, uint64_t cell, PetscInt first,
                                           PetscInt end, GridVisitor visit, PetscBool *stop, void *context)
{
  PetscFunctionBegin;
  for (PetscInt at = first; at < end && !*stop; at++) {
    const Entry *b = g->entry + at;
    if (b->cell == cell && a->box[0] <= b->box[2] && b->box[0] <= a->box[2] && a->box[1] <= b->box[3] &&
        b->box[1] <= a->box[3])
      PetscCall(visit(PetscMin(a->id, b->id), PetscMax(a->id, b->id), stop, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode visit_cell(const Grid *g, const Entry *a, PetscInt level, PetscInt column,
                                        PetscInt row, GridVisitor visit, PetscBool *stop, void *context)
{
  PetscFunctionBegin;
  const unsigned b = bucket_of(g, level, column, row);
  PetscCall(
      visit_entries(g, a, cell_key(level, column, row), g->start[b], g->start[b + 1], visit, stop, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the pairs of box a with boxes of its own level. Each pair is visited once, from the lower box: in
   the rest of its own cell, in the cell to the right, and in the three cells above as far as box a reaches.
   The cell above to the left counts because its boxes may reach over to a. */
static PetscErrorCode visit_own_level(const Grid *g, PetscInt at, GridVisitor visit, PetscBool *stop,
                                      void *context)
{
  const Entry *a = g->entry + at;
  const PetscInt level = a->level, column = cell_of(g, level, 0, a->box[0]),
                 row = cell_of(g, level, 1, a->box[1]);
  const PetscInt right = cell_of(g, level, 0, a->box[2]), top = cell_of(g, level, 1, a->box[3]);

  PetscFunctionBegin;
  PetscCall(visit_entries(g, a, a->cell, at + 1, g->start[bucket_of(g, level, column, row) + 1], visit, stop,
                          context));
  if (right > column) PetscCall(visit_cell(g, a, level, column + 1, row, visit, stop, context));
  for (PetscInt c = PetscMax(0, column - 1); top > row && c <= right; c++)
    PetscCall(visit_cell(g, a, level, c, row + 1, visit, stop, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the pairs of box a with boxes of a coarser level. Boxes that are filed one cell to the left or below
   count too, because they may reach over. */
static PetscErrorCode visit_coarser(const Grid *g, const Entry *a, PetscInt level, GridVisitor visit,
                                    PetscBool *stop, void *context)
{
  PetscFunctionBegin;
  const PetscInt column_0 = PetscMax(0, cell_of(g, level, 0, a->box[0]) - 1),
                 column_1 = cell_of(g, level, 0, a->box[2]);
  const PetscInt row_0 = PetscMax(0, cell_of(g, level, 1, a->box[1]) - 1),
                 row_1 = cell_of(g, level, 1, a->box[3]);
  for (PetscInt row = row_0; row <= row_1; row++)
    for (PetscInt column = column_0; column <= column_1; column++)
      PetscCall(visit_cell(g, a, level, column, row, visit, stop, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GridVisit(PetscInt n, const PetscReal *box, GridVisitor visit, void *context)
{
  Grid grid;
  PetscBool stop = PETSC_FALSE;

  PetscFunctionBegin;
  if (n < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(grid_create(n, box, &grid));
  for (PetscInt at = 0; at < n && !stop; at++) {
    PetscCall(visit_own_level(&grid, at, visit, &stop, context));
    for (PetscInt l = 0; l < grid.n_levels; l++)
      if (grid.levels[l] > grid.entry[at].level)
        PetscCall(visit_coarser(&grid, grid.entry + at, grid.levels[l], visit, &stop, context));
  }
  PetscCall(PetscFree(grid.entry));
  PetscCall(PetscFree(grid.start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- as rows */

typedef struct {
  PetscInt n, capacity;
  PetscInt *pair; /* (capacity,2) */
  GridFilter filter;
  const void *context;
} PairList;

static PetscErrorCode add_pair(PetscInt i, PetscInt j, PetscBool *stop, void *context)
{
  PairList *list = context;
  PetscFunctionBegin;
  (void)stop;
  if (list->filter && !list->filter(i, j, list->context)) PetscFunctionReturn(PETSC_SUCCESS);
  if (list->n == list->capacity) {
    PetscCheck(list->n < PETSC_MAX_INT / 4, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "Too many pairs of overlapping boxes: more than %" PetscInt_FMT, list->n);
    list->capacity *= 2;
    PetscCall(PetscRealloc(sizeof(PetscInt) * 2 * (size_t)list->capacity, &list->pair));
  }
  list->pair[2 * list->n] = i;
  list->pair[2 * list->n + 1] = j;
  list->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds j to row i. start: ends of the rows, shifted by one; it becomes their starts as the rows fill. */
static inline void add_to_row(PetscInt *start, PetscInt *near, PetscInt i, PetscInt j)
{
  near[start[i + 1]++] = j;
}

/* Puts both directions of every pair into rows. The result is turned over once (where row i names j, row j
   names i), which gives the same table with ascending rows. */
static PetscErrorCode pairs_to_rows(PetscInt n, PairList *list, PetscInt **start, PetscInt **near)
{
  PetscInt *unsorted, *ends, *rows;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1((size_t)n + 2, &ends));
  for (PetscInt p = 0; p < 2 * list->n; p++) ends[list->pair[p] + 2]++;
  for (PetscInt i = 0; i < n; i++) ends[i + 2] += ends[i + 1];
  PetscCall(PetscMalloc1((size_t)n + 2, start));
  PetscCall(PetscArraycpy(*start, ends, (size_t)n + 2));
  PetscCall(PetscMalloc1(2 * (size_t)list->n, &unsorted));
  for (PetscInt p = 0; p < list->n; p++) {
    add_to_row(ends, unsorted, list->pair[2 * p], list->pair[2 * p + 1]);
    add_to_row(ends, unsorted, list->pair[2 * p + 1], list->pair[2 * p]);
  }
  PetscCall(PetscFree(list->pair));
  PetscCall(PetscMalloc1(2 * (size_t)list->n, &rows));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt p = ends[i]; p < ends[i + 1]; p++) add_to_row(*start, rows, unsorted[p], i);
  PetscCall(PetscFree(unsorted));
  PetscCall(PetscFree(ends));
  *near = rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GridRows(PetscInt n, const PetscReal *box, GridFilter filter, const void *context,
                        PetscInt **start, PetscInt **near)
{
  PairList list = {.capacity = PetscMax(16, n), .filter = filter, .context = context};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * (size_t)list.capacity, &list.pair));
  PetscCall(GridVisit(n, box, add_pair, &list));
  PetscCall(pairs_to_rows(n, &list, start, near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

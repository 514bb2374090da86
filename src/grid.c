/* grid.c: pairs of boxes that overlap or touch. Knows boxes only.

   A hierarchy of cell grids. Every box is filed once, in the cell of its lower left corner, in the grid whose
   cells are just larger than the box; the cells of the next grid are twice as large. A box is then compared
   with the boxes of its own grid and of all coarser ones, and meets at most 3 x 3 cells in each. So memory is
   O(n) and time O(n x grids) for any mixture of sizes: one huge box sits alone in a coarse grid and costs
   each small one a look at 9 cells. (A single grid would either file the huge box in all cells, or all small
   ones in one cell.) Cells without boxes take no memory: cells are found by hashing. */
#include "internal.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

#define NO_BOX (-1)

enum {
  CELL_BITS = 30, /* the finest grid has at most 2^30 cells in a row */
  MAX_LEVELS = CELL_BITS + 4,
  SAMPLE = 1000 /* boxes looked at to find the proportions of a cell */
};

typedef struct {
  PetscInt n;
  const PetscReal *box;
  PetscReal origin[2];
  PetscReal per_cell[MAX_LEVELS][2];     /* [1/m] 1 / size of the cells of each level, finest first */
  PetscInt n_levels, levels[MAX_LEVELS]; /* the levels that hold boxes, ascending */
  PetscInt *level, *column, *row;        /* (n,) level, and cell there, of each box */
  PetscInt *head, *next;                 /* (mask + 1,), (n,) chain of the boxes of a bucket */
  unsigned mask;
} Grid;

static int CompareReal(const void *a, const void *b)
{
  const PetscReal x = *(const PetscReal *)a, y = *(const PetscReal *)b;
  return (x > y) - (x < y);
}

/* Mean width or height of a sample in which the largest tenth counts as its 90 % quantile, so that neither a
   few huge boxes nor many of zero width (axis-parallel faces) decide alone. */
static PetscReal TypicalExtent(PetscInt n, const PetscReal *box, int axis)
{
  PetscReal extent[SAMPLE], sum = 0;
  const PetscInt count = PetscMin(n, SAMPLE);
  for (PetscInt s = 0; s < count; s++) {
    const PetscReal *b = box + 4 * (PetscInt)((PetscInt64)s * n / count);
    extent[s] = b[2 + axis] - b[axis];
  }
  qsort(extent, (size_t)count, sizeof *extent, CompareReal);
  for (PetscInt s = 0; s < count; s++) sum += PetscMin(extent[s], extent[9 * (count - 1) / 10]);
  return sum / (PetscReal)count;
}

/* Origin and cells of all levels: proportions of the typical box, size of the finest from the domain. */
static void SetCells(Grid *g)
{
  PetscReal base[2], low[2] = {PETSC_INFINITY, PETSC_INFINITY}, high[2] = {-PETSC_INFINITY, -PETSC_INFINITY};
  int exponent = 0;

  for (PetscInt i = 0; i < g->n; i++)
    for (int a = 0; a < 2; a++) {
      low[a] = PetscMin(low[a], g->box[4 * i + a]);
      high[a] = PetscMax(high[a], g->box[4 * i + 2 + a]);
    }
  for (int a = 0; a < 2; a++) base[a] = TypicalExtent(g->n, g->box, a);
  const PetscReal largest = PetscMax(base[0], base[1]);
  /* 1.25: boxes a little larger than the typical one still share its level */
  for (int a = 0; a < 2; a++) base[a] = largest > 0 ? 1.25 * PetscMax(base[a], 0.01 * largest) : 1;

  frexp(PetscMax((high[0] - low[0]) / base[0], (high[1] - low[1]) / base[1]), &exponent);
  for (int l = 0; l < MAX_LEVELS; l++)
    for (int a = 0; a < 2; a++)
      g->per_cell[l][a] = 1 / PetscMax(ldexp(base[a], exponent - CELL_BITS + l), DBL_MIN);
  for (int a = 0; a < 2; a++) g->origin[a] = low[a];
}

/* Finest level whose cells are larger than the box. 1 % is kept back for rounding: a box must not reach a
 * third cell. */
static PetscInt LevelOf(const Grid *g, const PetscReal *b)
{
  const PetscReal ratio = PetscMax((b[2] - b[0]) * g->per_cell[0][0], (b[3] - b[1]) * g->per_cell[0][1]);
  int exponent;
  frexp(1.01 * ratio, &exponent); /* ratio < 2^exponent */
  return PetscMin(PetscMax(exponent, 0), MAX_LEVELS - 1);
}

static inline PetscInt CellOf(const Grid *g, PetscInt level, int axis, PetscReal x)
{
  return (PetscInt)floor((x - g->origin[axis]) * g->per_cell[level][axis]);
}

static inline unsigned Bucket(const Grid *g, PetscInt level, PetscInt column, PetscInt row)
{
  /* neighbours in a row share a cache line; the odd factors keep rows and levels apart */
  return ((unsigned)column + 40503u * (unsigned)row + 2654435769u * (unsigned)level) & g->mask;
}

static PetscErrorCode GridCreate(PetscInt n, const PetscReal *box, Grid *g)
{
  PetscBool used[MAX_LEVELS] = {PETSC_FALSE};

  PetscFunctionBegin;
  *g = (Grid){.n = n, .box = box, .mask = 15};
  SetCells(g);
  while (g->mask < (unsigned)n) g->mask = 2 * g->mask + 1;
  PetscCall(
      PetscMalloc5(n, &g->level, n, &g->column, n, &g->row, n, &g->next, (size_t)g->mask + 1, &g->head));
  for (size_t b = 0; b <= g->mask; b++) g->head[b] = NO_BOX;

  /* backwards, so that chains ascend */
  for (PetscInt i = n - 1; i >= 0; i--) {
    const PetscInt level = LevelOf(g, box + 4 * i);
    g->level[i] = level;
    g->column[i] = CellOf(g, level, 0, box[4 * i]);
    g->row[i] = CellOf(g, level, 1, box[4 * i + 1]);
    const unsigned bucket = Bucket(g, level, g->column[i], g->row[i]);
    g->next[i] = g->head[bucket];
    g->head[bucket] = i;
    used[level] = PETSC_TRUE;
  }
  for (PetscInt l = 0; l < MAX_LEVELS; l++)
    if (used[l]) g->levels[g->n_levels++] = l;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the pairs of box i with boxes filed in one cell of its own or a coarser level. */
static inline PetscErrorCode VisitCell(const Grid *g, PetscInt i, PetscInt level, PetscInt column,
                                       PetscInt row, GridVisitor visit, PetscBool *stop, void *context)
{
  const PetscReal *a = g->box + 4 * i;
  PetscFunctionBegin;
  for (PetscInt j = g->head[Bucket(g, level, column, row)]; j != NO_BOX && !*stop; j = g->next[j]) {
    const PetscReal *b = g->box + 4 * j;
    if (g->column[j] != column || g->row[j] != row || g->level[j] != level)
      continue;                                   /* another cell's, same bucket */
    if (level == g->level[i] && j <= i) continue; /* both boxes come here: one of them counts */
    if (a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3])
      PetscCall(visit(PetscMin(i, j), PetscMax(i, j), stop, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VisitLevel(const Grid *g, PetscInt i, PetscInt level, GridVisitor visit,
                                 PetscBool *stop, void *context)
{
  const PetscReal *b = g->box + 4 * i;
  PetscFunctionBegin;
  /* boxes filed one cell to the left or below may reach over */
  const PetscInt column_0 = CellOf(g, level, 0, b[0]) - 1, column_1 = CellOf(g, level, 0, b[2]);
  const PetscInt row_0 = CellOf(g, level, 1, b[1]) - 1, row_1 = CellOf(g, level, 1, b[3]);
  for (PetscInt row = row_0; row <= row_1; row++)
    for (PetscInt column = column_0; column <= column_1; column++)
      PetscCall(VisitCell(g, i, level, column, row, visit, stop, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GridVisit(PetscInt n, const PetscReal *box, GridVisitor visit, void *context)
{
  Grid grid;
  PetscBool stop = PETSC_FALSE;

  PetscFunctionBegin;
  if (n < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GridCreate(n, box, &grid));
  for (PetscInt i = 0; i < n && !stop; i++)
    for (PetscInt l = 0; l < grid.n_levels; l++)
      if (grid.levels[l] >= grid.level[i])
        PetscCall(VisitLevel(&grid, i, grid.levels[l], visit, &stop, context));
  PetscCall(PetscFree5(grid.level, grid.column, grid.row, grid.next, grid.head));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- as a list */

typedef struct {
  PetscInt n, capacity;
  PetscInt *pair; /* (capacity,2) */
} PairList;

static PetscErrorCode AddPair(PetscInt i, PetscInt j, PetscBool *stop, void *context)
{
  PairList *list = context;
  PetscFunctionBegin;
  (void)stop;
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

/* Counting sort by the first box, then each short row by the second. */
static PetscErrorCode SortPairs(PetscInt n, const PairList *list, PetscInt *sorted)
{
  PetscInt *start, *second;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1((size_t)n + 1, &start));
  PetscCall(PetscMalloc1(list->n, &second));
  for (PetscInt p = 0; p < list->n; p++) start[list->pair[2 * p] + 1]++;
  for (PetscInt i = 0; i < n; i++) start[i + 1] += start[i];
  for (PetscInt p = 0; p < list->n; p++) second[start[list->pair[2 * p]]++] = list->pair[2 * p + 1];
  /* start[i] is the end of row i now */
  for (PetscInt i = 0, p = 0; i < n; i++) {
    PetscCall(PetscSortInt(start[i] - p, second + p));
    for (; p < start[i]; p++) {
      sorted[2 * p] = i;
      sorted[2 * p + 1] = second[p];
    }
  }
  PetscCall(PetscFree(second));
  PetscCall(PetscFree(start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GridPairs(PetscInt n, const PetscReal *box, PetscInt *n_pairs, PetscInt **pairs)
{
  PairList list = {.capacity = PetscMax(16, n)};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(2 * (size_t)list.capacity, &list.pair));
  PetscCall(GridVisit(n, box, AddPair, &list));
  PetscCall(PetscMalloc1(2 * (size_t)list.n, pairs));
  PetscCall(SortPairs(n, &list, *pairs));
  PetscCall(PetscFree(list.pair));
  *n_pairs = list.n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* nested_solve.c: solves with the factor of the elastic stiffness on all ranks, with the same bits on any
   number of them.

   x has the columns of the parts, those of the top, a dummy for padded rows, and a copy of the top for each
   part. Forward, a part adds to its own copy what it does to the top; the copies are added in the order of
   the parts, on every rank. Every rank eliminates the top; backward, each part reads its copy. So all sums
   have one order, whichever rank has which part. */
#include "solve/nested.h"
#include "base/lanes.h"

/* NESTED_LANES numbers, in halves that an instruction converts from single to double precision */
enum { HALF = NESTED_LANES / 2 };
typedef double Half __attribute__((vector_size(HALF * sizeof(double)), aligned(16)));
typedef struct {
  Half low, high;
} Wide;

/* Values in a line of the cache, and values that are asked for ahead. Forward it pays all along, because a
   processor stops reading ahead at each page of memory; backward only at the next supernode. */
enum { LINE = 64 / sizeof(NestedReal), FORWARD_AHEAD = 1024, BACKWARD_AHEAD = 4096 };

/* ---- one supernode */

KERNEL Half half_of(const NestedReal *x)
{
  return (Half){x[0], x[1], x[2], x[3]};
}

KERNEL void add_product(Wide *sum, const NestedReal *x, Wide y)
{
  sum->low += half_of(x) * y.low, sum->high += half_of(x + HALF) * y.high;
}

/* Adds what `columns` columns of B give to the sums of the rows, from NESTED_LANES times `at` on. first:
   whether these are the first columns, before which no sum is set. Returns the next columns of B. */
KERNEL const NestedReal *add_columns(int columns, int first, PetscInt at, PetscInt n, const NestedReal *B,
                                     const PetscReal *own, Wide *sum)
{
  for (; at < n / NESTED_LANES; at++, B += NESTED_LANES * columns) {
    Wide now = {{0.}, {0.}};
    if (!first) now = sum[at];
    for (int i = 0; i < NESTED_LANES * columns; i += LINE) __builtin_prefetch(B + FORWARD_AHEAD + i);
    for (int c = 0; c < columns; c++) {
      const Half one = own[c] - (Half){0.};
      add_product(&now, B + NESTED_LANES * c, (Wide){one, one});
    }
    sum[at] = now;
  }
  return B;
}

/* Does so for the columns from c on. */
KERNEL const NestedReal *add_panel(int columns, PetscInt c, PetscInt n, const NestedReal *B,
                                   const PetscReal *own, Wide *sum)
{
  return c ? add_columns(columns, 0, c / NESTED_LANES, n, B, own + c, sum)
           : add_columns(columns, 1, 0, n, B, own, sum);
}

/* Adds B x_c to x in the rows of a supernode, whose own columns are zero before. */
KERNEL void forward_code(PetscInt width, PetscInt n, const PetscInt *row, const NestedReal *B, PetscReal *x)
{
  Wide sum[n / NESTED_LANES];
  PetscReal own[width];
  PetscInt c = 0;
  for (; c < width; c++) own[c] = x[row[c]], x[row[c]] = 0.;
  for (c = 0; c + NESTED_PANEL <= width; c += NESTED_PANEL) B = add_panel(NESTED_PANEL, c, n, B, own, sum);
  if (width - c == 3) add_panel(3, c, n, B, own, sum);
  if (width - c == 2) add_panel(2, c, n, B, own, sum);
  if (width - c == 1) add_panel(1, c, n, B, own, sum);
  for (PetscInt at = 0; at < n / NESTED_LANES; at++, row += NESTED_LANES) {
    for (int i = 0; i < HALF; i++) x[row[i]] += sum[at].low[i];
    for (int i = 0; i < HALF; i++) x[row[HALF + i]] += sum[at].high[i];
  }
}

KERNEL PetscReal sum_of(Wide a)
{
  const Half sum = a.low + a.high;
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

/* Computes `columns` entries of B' y, from column c on. Returns the next columns of B. */
KERNEL const NestedReal *multiply_panel(int columns, PetscInt c, PetscInt n, const NestedReal *B,
                                        const Wide *y, PetscReal *own)
{
  Wide sum[NESTED_PANEL] = {{{0.}, {0.}}, {{0.}, {0.}}, {{0.}, {0.}}, {{0.}, {0.}}};
  for (PetscInt at = c / NESTED_LANES; at < n / NESTED_LANES; at++, B += NESTED_LANES * columns)
    for (int i = 0; i < columns; i++) add_product(sum + i, B + NESTED_LANES * i, y[at]);
  for (int i = 0; i < columns; i++) own[c + i] = sum_of(sum[i]);
  return B;
}

/* Sets the own columns of x to B' x. */
KERNEL void backward_code(PetscInt width, PetscInt n, const PetscInt *row, const NestedReal *B, PetscReal *x)
{
  Wide y[n / NESTED_LANES];
  PetscReal own[width];
  PetscInt c = 0;
  for (PetscInt at = 0; at < n / NESTED_LANES; at++) {
    const PetscInt *r = row + NESTED_LANES * at;
    y[at].low = (Half){x[r[0]], x[r[1]], x[r[2]], x[r[3]]};
    y[at].high = (Half){x[r[4]], x[r[5]], x[r[6]], x[r[7]]};
  }
  for (; c + NESTED_PANEL <= width; c += NESTED_PANEL) B = multiply_panel(NESTED_PANEL, c, n, B, y, own);
  if (width - c == 3) multiply_panel(3, c, n, B, y, own);
  if (width - c == 2) multiply_panel(2, c, n, B, y, own);
  if (width - c == 1) multiply_panel(1, c, n, B, y, own);
  for (c = 0; c < width; c++) x[row[c]] = own[c];
}

/* ---- pieces */

KERNEL void forward_piece_code(const NestedPiece *p, PetscReal *x)
{
  const NestedReal *B = p->B;
  for (PetscInt s = 0; s < p->n; s++) {
    const PetscInt width = p->first[s + 1] - p->first[s], n = p->row_start[s + 1] - p->row_start[s];
    forward_code(width, n, p->row + p->row_start[s], B, x);
    B += NestedSize(width, n);
  }
}

KERNEL void backward_piece_code(const NestedPiece *p, PetscReal *x)
{
  const NestedReal *B = p->B + p->n_values;
  for (PetscInt s = p->n; s-- > 0;) {
    const PetscInt width = p->first[s + 1] - p->first[s], n = p->row_start[s + 1] - p->row_start[s];
    B -= NestedSize(width, n);
    if (s) { // processors read ahead in ascending order alone
      const size_t next = NestedSize(p->first[s] - p->first[s - 1], p->row_start[s] - p->row_start[s - 1]);
      for (size_t i = 0; i < PetscMin(next, BACKWARD_AHEAD); i += LINE) __builtin_prefetch(B - next + i);
    }
    backward_code(width, n, p->row + p->row_start[s], B, x);
  }
}

VARIANTS(forward_piece, (const NestedPiece *p, PetscReal *x), (p, x))
VARIANTS(backward_piece, (const NestedPiece *p, PetscReal *x), (p, x))

/* ---- the solve */

/* Shows that this rank has come to a step of the present solve, and waits for all others. */
static PetscErrorCode meet(Nested f, int step)
{
  PetscFunctionBeginUser;
  SharedPublish(&f->near[f->rank]->step[step].count, (uint64_t)f->solves);
  for (PetscMPIInt r = 0; r < f->size; r++)
    PetscCall(SharedWait(f->comm, &f->near[r]->step[step].count, (uint64_t)f->solves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills x with the right-hand sides that this rank needs, from b of all ranks. */
static PetscErrorCode give(Nested f, const PetscReal *b)
{
  PetscFunctionBeginUser;
  if (f->size == 1) {
    for (PetscInt d = 0; d < f->n_dof; d++) f->x[f->place[d]] = b[d];
  } else if (f->memory.mine) {
    f->solves++;
    PetscCall(PetscArraycpy(f->near[f->rank]->values, b, f->n_dof));
    PetscCall(meet(f, GIVEN));
    for (PetscInt i = 0; i < f->n_given; i++) f->x[f->given_to[i]] = *f->given[i];
  } else {
    PetscCall(PetscSFBcastBegin(f->give, MPIU_REAL, b, f->x, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(f->give, MPIU_REAL, b, f->x, MPI_REPLACE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the sums of all parts to the top, in the order of the parts. */
static PetscErrorCode add_sums(Nested f)
{
  PetscReal *copies = f->x + f->n + 1, *top = f->x + f->n_below;
  PetscFunctionBeginUser;
  if (f->size > 1 && f->memory.mine) {
    const PetscMPIInt from = f->from[f->rank];
    PetscCall(PetscArraycpy(f->near[f->rank]->values + f->n_dof, copies + from, f->count[f->rank]));
    PetscCall(meet(f, SUMMED));
  } else if (f->size > 1)
    PetscCallMPI(
        MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, copies, f->count, f->from, MPIU_REAL, f->comm));
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    const PetscReal *sum = f->size > 1 && f->memory.mine ? f->sums[k] : f->x + NestedCopy(f, k);
    for (PetscInt i = 0; i < f->n_top; i++) top[i] += sum[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills v with the solutions for the degrees of freedom of this rank, from x of all ranks. */
static PetscErrorCode take(Nested f, PetscReal *v)
{
  PetscFunctionBeginUser;
  if (f->size == 1) {
    for (PetscInt d = 0; d < f->n_dof; d++) v[d] = f->x[f->place[d]];
  } else if (f->memory.mine) {
    PetscCall(meet(f, SOLVED));
    for (PetscInt d = 0; d < f->n_dof; d++) v[d] = *f->solved[d];
  } else {
    PetscCall(PetscSFBcastBegin(f->take, MPIU_REAL, f->x, v, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(f->take, MPIU_REAL, f->x, v, MPI_REPLACE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedSolve(PC pc, Vec from, Vec to)
{
  Nested f;
  const PetscReal *b;
  PetscReal *v;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &f));
  PetscCall(VecGetArrayRead(from, &b));
  PetscCall(VecGetArrayWrite(to, &v));
  f->x[f->n] = 0.; // the dummy: a number that is not finite would stay there, and spoil every later solve
  PetscCall(give(f, b));
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    if (f->owner[k] != f->rank) continue;
    PetscCall(PetscArrayzero(f->x + NestedCopy(f, k), f->n_top));
    forward_piece(f->piece + k, f->x);
  }
  PetscCall(add_sums(f));
  forward_piece(f->piece + NESTED_PARTS, f->x);
  backward_piece(f->piece + NESTED_PARTS, f->x);
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    if (f->owner[k] != f->rank) continue;
    PetscCall(PetscArraycpy(f->x + NestedCopy(f, k), f->x + f->n_below, f->n_top));
    backward_piece(f->piece + k, f->x);
  }
  PetscCall(take(f, v));
  PetscCall(VecRestoreArrayWrite(to, &v));
  PetscCall(VecRestoreArrayRead(from, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedMultiply(Mat matrix, Vec from, Vec to)
{
  Nested f;
  const PetscReal *x;
  PetscReal *y;
  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(matrix, &f));
  PetscCall(VecScatterBegin(f->to_first, from, f->on_first, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(f->to_first, from, f->on_first, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(f->on_first, &x));
  PetscCall(VecGetArrayWrite(f->product, &y));
  if (!f->rank) {
    const ElasticMatrix *k = &f->whole;
    PetscReal *sum = f->product_work, *ordered = f->product_work + k->n;
    for (PetscInt i = 0; i < k->n; i++) ordered[f->number[i]] = x[i], sum[i] = 0.;
    for (PetscInt i = 0; i < k->n; i++)
      for (PetscInt e = k->start[i]; e < k->start[i + 1]; e++) {
        const PetscInt j = k->column[e];
        sum[i] += k->value[e] * ordered[j];
        if (j != i) sum[j] += k->value[e] * ordered[i];
      }
    for (PetscInt i = 0; i < k->n; i++) y[i] = sum[f->number[i]];
  }
  PetscCall(VecRestoreArrayWrite(f->product, &y));
  PetscCall(VecRestoreArrayRead(f->on_first, &x));
  PetscCall(VecScatterBegin(f->to_first, f->product, to, INSERT_VALUES, SCATTER_REVERSE));
  PetscCall(VecScatterEnd(f->to_first, f->product, to, INSERT_VALUES, SCATTER_REVERSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

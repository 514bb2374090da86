/* dense.c: computes products with the dense matrices of condensed bodies, and solves with their factors. */
#include "base/lanes.h"
#include "blocks/blocks.h"
#include <petscmat.h>

enum { ROWS_AT_ONCE = 4 * LANES }; /* their sums stay in registers */

/* Computes n rows of A x from `from` on. */
static void last_rows(PetscInt from, PetscInt n, PetscInt rows, PetscInt columns, const PetscReal *A,
                      const PetscReal *x, PetscReal *y)
{
  for (PetscInt i = from; i < from + n; i++) {
    PetscReal sum = 0.;
    for (PetscInt j = 0; j < columns; j += 4) {
      const PetscReal *a = A + j * rows + i;
      sum += (a[0] * x[j] + a[rows] * x[j + 1]) + (a[2 * rows] * x[j + 2] + a[3 * rows] * x[j + 3]);
    }
    y[i] = sum;
  }
}

/* Computes n LANES rows; callers pass a constant n. */
KERNEL void SomeRows(int n, PetscInt from, PetscInt rows, PetscInt columns, const PetscReal *A,
                     const PetscReal *x, PetscReal *y)
{
  Lanes sum[4] = {LanesOf(0.), LanesOf(0.), LanesOf(0.), LanesOf(0.)};
  for (PetscInt j = 0; j < columns; j += 4) {
    const PetscReal *a = A + j * rows + from;
    for (int k = 0; k < n; k++, a += LANES)
      sum[k] += (LoadLanes(a) * x[j] + LoadLanes(a + rows) * x[j + 1]) +
                (LoadLanes(a + 2 * rows) * x[j + 2] + LoadLanes(a + 3 * rows) * x[j + 3]);
  }
  for (int k = 0; k < n; k++) StoreLanes(y + from + k * LANES, sum[k]);
}

KERNEL void Times_code(PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y)
{
  PetscInt from = 0;
  for (; from + ROWS_AT_ONCE <= rows; from += ROWS_AT_ONCE) SomeRows(4, from, rows, columns, A, x, y);
  for (; from + LANES <= rows; from += LANES) SomeRows(1, from, rows, columns, A, x, y);
  if (from < rows) last_rows(from, rows - from, rows, columns, A, x, y);
}

VARIANTS(Times, (PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y),
         (rows, columns, A, x, y))

/* Computes y = A x, four columns at a time. Every y_i is summed in the order of the columns, whatever the
   width of vectors, so the bits do not depend on the instruction set. */
void DenseTimes(PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y)
{
  Times(rows, columns, A, x, y);
}

PetscErrorCode CondensedSolve(const Condensed *c, const PetscInt *at, const PetscReal *r, PetscReal *x)
{
  PetscScalar *b;
  const PetscScalar *y;
  PetscFunctionBeginUser;
  if (!c->n_inner) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(c->b, &b));
  for (PetscInt i = 0; i < c->n_inner; i++) b[i] = r[at ? at[i] : i];
  for (PetscInt i = 0; i < c->n_kept; i++) b[c->n_inner + i] = 0.;
  PetscCall(VecRestoreArray(c->b, &b));
  PetscCall(MatSolve(c->factor, c->b, c->x));
  PetscCall(VecGetArrayRead(c->x, &y));
  for (PetscInt i = 0; i < c->n_inner; i++) x[at ? at[i] : i] = y[i];
  PetscCall(VecRestoreArrayRead(c->x, &y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedSolveMany(const Condensed *c, PetscInt n, const PetscReal *r, PetscReal *x)
{
  enum { AT_ONCE = 32 };
  const PetscInt rows = c->n_inner + c->n_kept;
  PetscFunctionBeginUser;
  for (PetscInt from = 0; from < n && c->n_inner; from += AT_ONCE) {
    const PetscInt some = PetscMin(AT_ONCE, n - from);
    PetscScalar *b;
    const PetscScalar *y;
    Mat B, X;
    PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, rows, some, NULL, &B));
    PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, rows, some, NULL, &X));
    PetscCall(MatDenseGetArray(B, &b));
    for (PetscInt k = 0; k < some; k++)
      PetscCall(PetscArraycpy(b + k * rows, r + (from + k) * c->n_inner, c->n_inner));
    PetscCall(MatDenseRestoreArray(B, &b));
    PetscCall(MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY));
    PetscCall(MatMatSolve(c->factor, B, X));
    PetscCall(MatDenseGetArrayRead(X, &y));
    for (PetscInt k = 0; k < some; k++)
      PetscCall(PetscArraycpy(x + (from + k) * c->n_inner, y + k * rows, c->n_inner));
    PetscCall(MatDenseRestoreArrayRead(X, &y));
    PetscCall(MatDestroy(&B));
    PetscCall(MatDestroy(&X));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

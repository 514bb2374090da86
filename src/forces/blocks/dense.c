/* dense.c: products with the dense matrices of condensed bodies, and solves with their factors. */
#include "forces/blocks/blocks.h"
#include <petscmat.h>

enum { ROWS_AT_ONCE = 32 };

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&             \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define CLONES
#endif

/* Rows `from` to `from` + n - 1 of A x. */
CLONES static void times_some(PetscInt from, PetscInt n, PetscInt rows, PetscInt columns,
                              const PetscReal *restrict A, const PetscReal *restrict x, PetscReal *restrict y)
{
  PetscReal sum[ROWS_AT_ONCE] = {0.};
  for (PetscInt j = 0; j < columns; j += 4) {
    const PetscReal *restrict a = A + j * rows + from, *restrict b = a + rows, *restrict c = b + rows,
                              *restrict d = c + rows;
    if (n == ROWS_AT_ONCE)
      for (PetscInt i = 0; i < ROWS_AT_ONCE; i++)
        sum[i] += (a[i] * x[j] + b[i] * x[j + 1]) + (c[i] * x[j + 2] + d[i] * x[j + 3]);
    else
      for (PetscInt i = 0; i < n; i++)
        sum[i] += (a[i] * x[j] + b[i] * x[j + 1]) + (c[i] * x[j + 2] + d[i] * x[j + 3]);
  }
  for (PetscInt i = 0; i < n; i++) y[from + i] = sum[i];
}

/* Four columns at a time. Every y_i is summed in the order of the columns, whatever the width of vectors, so
   the bits do not depend on the instruction set. */
void DenseTimes(PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y)
{
  for (PetscInt from = 0; from < rows; from += ROWS_AT_ONCE)
    times_some(from, PetscMin(ROWS_AT_ONCE, rows - from), rows, columns, A, x, y);
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

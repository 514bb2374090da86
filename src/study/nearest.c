/* nearest.c: starts samples from the nearest of a few samples that are solved first, the pivots.

   A pivot leaves its displacements at the end of each stage that stands. A sample takes the displacements of
   the nearest pivot as the first guess of Newton's method. Its history (slip, cracks) starts from the state
   that all share, so the equilibrium is one of its own stage, and fewer iterations find it. Pivots are the
   same in every process and start from no other sample. So a sample depends on its own numbers and on the
   pivots, and on no other sample. */
#include "study/samples.h"

PetscErrorCode NearestAdd(Nearest *n, PetscInt n_columns, PetscInt n_stages, const PetscReal *x)
{
  PetscFunctionBeginUser;
  n->n_columns = n_columns, n->n_stages = n_stages, n->n++;
  PetscCall(PetscRealloc((size_t)(n->n * n_columns) * sizeof(PetscReal), &n->x));
  PetscCall(PetscRealloc((size_t)(n->n * n_stages) * sizeof(Vec), &n->u));
  PetscCall(PetscArraycpy(n->x + (n->n - 1) * n_columns, x, n_columns));
  PetscCall(PetscArrayzero(n->u + (n->n - 1) * n_stages, n_stages));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NearestKeep(Nearest *n, PetscInt stage, State *state)
{
  Vec *u = n->u + (n->n - 1) * n->n_stages + stage;
  PetscFunctionBeginUser;
  PetscCall(StateGive(state));
  PetscCall(VecDuplicate(state->displacement, u));
  PetscCall(VecCopy(state->displacement, *u));
  PetscCall(StateTake(state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the square of the distance, each number over the range of the pivots. */
static PetscReal distance(const Nearest *n, PetscInt pivot, const PetscReal *x)
{
  PetscReal sum = 0.;
  for (PetscInt c = 0; c < n->n_columns; c++) {
    PetscReal low = n->x[c], high = low;
    for (PetscInt p = 1; p < n->n; p++)
      low = PetscMin(low, n->x[p * n->n_columns + c]), high = PetscMax(high, n->x[p * n->n_columns + c]);
    if (high > low) sum += PetscSqr((x[c] - n->x[pivot * n->n_columns + c]) / (high - low));
  }
  return sum;
}

PetscInt NearestOf(const Nearest *n, const PetscReal *x)
{
  PetscInt best = -1;
  PetscReal least = PETSC_INFINITY;
  for (PetscInt p = 0; p < n->n; p++) {
    const PetscReal far = distance(n, p, x);
    if (far < least) least = far, best = p;
  }
  return best;
}

PetscErrorCode NearestDestroy(Nearest *n)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n->n * n->n_stages; i++) PetscCall(VecDestroy(n->u + i));
  PetscCall(PetscFree(n->x));
  PetscCall(PetscFree(n->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* pair.h: computes with x and y at once, where an anchor reads the motion of vertices and adds forces to
   them. */
#pragma once
#include "model/model.h"

/* x and y as a GCC vector: one instruction for both on any processor. */
typedef PetscReal Pair __attribute__((vector_size(2 * sizeof(PetscReal))));
typedef PetscReal PairAnywhere __attribute__((vector_size(2 * sizeof(PetscReal)), aligned(8)));

static inline Pair LoadPair(const PetscReal *x)
{
  return (Pair) * (const PairAnywhere *)x;
}

static inline void StorePair(PetscReal *x, Pair value)
{
  *(PairAnywhere *)x = (PairAnywhere)value;
}

/* Returns the sum of w_i u_i over n vertices. Callers pass a constant n, so that the compiler unrolls the
   loop. */
static inline Pair WeighedSum(PetscInt n, const PetscInt *vertex, const PetscReal *weight, const PetscReal *u)
{
  Pair sum = {0., 0.};
  for (PetscInt i = 0; i < n; i++) sum += weight[i] * LoadPair(u + 2 * vertex[i]);
  return sum;
}

/* Adds w_i force to f at each of n vertices. */
static inline void AddWeighed(PetscInt n, const PetscInt *vertex, const PetscReal *weight, Pair force,
                              PetscReal *f)
{
  for (PetscInt i = 0; i < n; i++)
    StorePair(f + 2 * vertex[i], LoadPair(f + 2 * vertex[i]) + weight[i] * force);
}

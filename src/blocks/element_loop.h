/* element_loop.h: computes the forces of blocks in a loop, for either number of lanes. */
#pragma once
#include "blocks/blocks.h"
#include "blocks/element_kernels.h"

/* Prefetches into the cache what the motion of vertices will read. Forces are mostly arithmetic and the
   motion after them is mostly memory access, so the access overlaps the arithmetic. LINE vertices take a
   line of 64 bytes in each array; that line is fetched with every LINE blocks. */
enum { LINE = 4 };
KERNEL void Fetch(const Ahead *ahead, PetscInt block)
{
  for (int k = 0; k < LANES; k += LINE)
    for (int i = 0; i < AHEAD_ARRAYS; i++) __builtin_prefetch(ahead->array[i] + 2 * (block + k));
}

KERNEL void ForceLoop(const Model *model, const PetscReal *hourglass, const Elements *e, int n_nodes,
                      int large, int placed, PetscInt from, PetscInt to, const Ahead *ahead,
                      const PetscReal *restrict u, PetscReal *restrict f)
{
  for (PetscInt first = from; first < PetscMin(to, e->n_padded); first += LANES) {
    if (ahead) Fetch(ahead, first - from);
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesMaterial material = LoadMaterialOf(model, hourglass, e->group + first);
    LanesVector X[4], U[4], F[4];
    if (placed) {
      GatherBlocks(model, e, n_nodes, first, large, u, X, U);
    } else {
      Gather(n_nodes, model->mesh.X, vertex, X);
      Gather(n_nodes, u, vertex, U);
    }
    ElementForce(n_nodes, X, U, &material, model->materials.thickness, large, F);
    ScatterAdd(n_nodes, F, vertex, f);
  }
}

/* Passes shape and strain measure as constants to ForceLoop, so that each case is a loop without branches.
   Blocks of one point are a separate case. */
KERNEL void ForceCases(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                       PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f)
{
  if (n_nodes == 4 && large)
    ForceLoop(model, NULL, e, 4, 1, 0, from, to, ahead, u, f);
  else if (n_nodes == 4)
    ForceLoop(model, NULL, e, 4, 0, 0, from, to, ahead, u, f);
  else if (large)
    ForceLoop(model, NULL, e, 3, 1, 0, from, to, ahead, u, f);
  else
    ForceLoop(model, NULL, e, 3, 0, 0, from, to, ahead, u, f);
}

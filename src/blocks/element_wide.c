/* element_wide.c: computes forces of blocks in eight lanes, for AVX-512 alone. The bits are those of four
   lanes: lanes are independent, and forces are added to vertices in the same order. */
#define WIDE_LANES
#include "blocks/element_loop.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
__attribute__((target("arch=x86-64-v4"), SCHEDULED))
#endif
void ElementForcesWide(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                       PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f)
{
  ForceCases(model, e, n_nodes, large, from, to, ahead, u, f);
}

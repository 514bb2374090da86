/* element_wide.c: forces of blocks by eight lanes, under AVX-512 alone. A block has the same bits as by four:
   lanes do not see each other, and forces are added to vertices in the same order. */
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

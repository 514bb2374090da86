/* fault.c: finds the block where a force or displacement is no longer finite. */
#include "motion/motion.h"

enum { GROUP_BITS = 16, FILE_BITS = 40 };

static PetscBool is_bad(const PetscReal *x)
{
  return (PetscBool) !(PetscAbsReal(x[0]) < PETSC_MAX_REAL && PetscAbsReal(x[1]) < PETSC_MAX_REAL);
}

/* Finds the block where the fault arose. Blocks with fewer finite vertices go first, then those with the
   lower file id. The block of the fault is among the first: a force that is not finite spoils all vertices of
   its block, but only the shared vertices of a neighbour. Inner vertices of condensed bodies count as finite:
   a cycle does not visit them. */
PetscInt64 FaultFind(const Model *m, const State *s)
{
  const PetscReal *f = s->f + 3 * m->rigid.n, *u = s->u + 3 * m->rigid.n;
  PetscInt64 first = FAULT_NONE;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) {
      PetscInt64 good = 0;
      for (PetscInt k = 0; k < list->n_nodes; k++) {
        const PetscInt v = VertexOf(list, e, k);
        good += !is_bad(f + 2 * v) && !is_bad(u + 2 * v);
      }
      if (good == list->n_nodes) continue;
      const PetscInt64 key = (good << (FILE_BITS + GROUP_BITS)) + ((PetscInt64)list->file[e] << GROUP_BITS) +
                             list->group[e];
      first = PetscMin(first, key);
    }
  return first;
}

PetscErrorCode FaultName(const Model *m, PetscInt64 found, char text[128])
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPIU_INT64, MPI_MIN, m->comm));
  if (found == FAULT_NONE) {
    PetscCall(PetscSNPrintf(text, 128, "no block"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscInt64 block = (found >> GROUP_BITS) & (((PetscInt64)1 << FILE_BITS) - 1);
  PetscCall(PetscSNPrintf(text, 128, "block %" PetscInt64_FMT " of group %s", block,
                          m->materials.names[found & ((1 << GROUP_BITS) - 1)]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

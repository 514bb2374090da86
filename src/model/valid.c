/* valid.c: whether the arrays of a model are consistent; for tests. */
#include "model/model.h"

/* The checks: every vertex, block and rigid body is owned once; element lists ascend; indices are in range;
   ghosts carry their owner's coordinates. */
PetscErrorCode ModelIsValid(const Model *m, PetscBool *valid)
{
  const Elements *list[6] = {&m->q4, &m->t3, &m->rigid_q4, &m->rigid_t3, &m->condensed_q4, &m->condensed_t3};
  PetscInt count[4] = {m->n_owned, 0, m->n_bodies, 0};
  PetscReal *X;
  PetscFunctionBeginUser;
  for (int l = 0; l < 6; l++)
    for (PetscInt e = 0, n_nodes = l % 2 ? 3 : 4; e < list[l]->n; e++) {
      count[1] += list[l]->owned[e];
      count[3] += e && list[l]->gid[e] <= list[l]->gid[e - 1];
      for (PetscInt k = 0; k < n_nodes; k++) {
        const PetscInt v = list[l]->vertex[((e / BATCH) * n_nodes + k) * BATCH + e % BATCH];
        count[3] += v < 0 || v >= m->n_vertices;
      }
    }
  PetscCall(PetscMalloc1(2 * m->n_vertices, &X));
  for (PetscInt i = 0; i < 2 * m->n_vertices; i++) X[i] = i < 2 * m->n_owned ? m->X[i] : PETSC_INFINITY;
  PetscCall(GhostBegin(m, X));
  PetscCall(GhostEnd(m, X));
  for (PetscInt i = 0; i < 2 * m->n_vertices; i++) count[3] += X[i] != m->X[i];
  PetscCall(PetscFree(X));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 4, MPIU_INT, MPI_SUM, m->comm));
  *valid = (PetscBool)(count[0] == m->n_vertices_global && count[1] == m->n_blocks_global &&
                       count[2] == m->n_rigid_global && count[3] == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

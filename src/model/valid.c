/* valid.c: checks whether the arrays of a model are consistent; for tests. */
#include "model/model.h"

/* Checks that every vertex, block and rigid body is owned once, that element lists ascend, that indices are
   in range, and that ghosts carry their owner's coordinates. */
PetscErrorCode ModelIsValid(const Model *m, PetscBool *valid)
{
  const LocalMesh *mesh = &m->mesh;
  PetscInt count[4] = {mesh->n_owned, 0, m->rigid.n, 0};
  PetscReal *X;
  PetscFunctionBeginUser;
  for (const Elements *list = mesh->elements; list < mesh->elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++) {
      count[1] += list->owned[e];
      count[3] += e && list->gid[e] <= list->gid[e - 1];
      for (PetscInt k = 0; k < list->n_nodes; k++) {
        const PetscInt v = VertexOf(list, e, k);
        count[3] += v < 0 || v >= mesh->n_vertices;
      }
    }
  PetscCall(PetscMalloc1(2 * mesh->n_vertices, &X));
  for (PetscInt i = 0; i < 2 * mesh->n_vertices; i++)
    X[i] = i < 2 * mesh->n_owned ? mesh->X[i] : PETSC_INFINITY;
  PetscCall(GhostBegin(m, X));
  PetscCall(GhostEnd(m, X));
  for (PetscInt i = 0; i < 2 * mesh->n_vertices; i++) count[3] += X[i] != mesh->X[i];
  PetscCall(PetscFree(X));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 4, MPIU_INT, MPI_SUM, m->comm));
  *valid = (PetscBool)(count[0] == mesh->n_vertices_global && count[1] == mesh->n_blocks_global &&
                       count[2] == mesh->n_rigid_global && count[3] == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

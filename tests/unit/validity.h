/* validity.h: checks whether the arrays of a model and of its contacts are consistent. */
#pragma once
#include "contacts/contacts.h"

/* Checks that every vertex, block and rigid body is owned once, that element lists ascend, that indices are
   in range, and that ghosts carry their owner's coordinates. */
static inline PetscErrorCode ModelIsValid(const Model *m, PetscBool *valid)
{
  const LocalMesh *mesh = &m->mesh;
  PetscInt count[4] = {mesh->n_owned, 0, m->rigid.n, 0};
  PetscReal *X;
  PetscFunctionBeginUser;
  *valid = PETSC_FALSE;
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

/* Decides whether contact i comes after the one before it: within a stress model keys ascend, and padding is
   last. */
static inline PetscBool keys_ascend(const Contacts *c, PetscInt i)
{
  const PetscInt *key = c->key + 2 * i, *before = key - 2;
  return (PetscBool)(before[0] >= 0 && (before[0] < key[0] || (before[0] == key[0] && before[1] < key[1])));
}

/* Checks that contacts have a length, ends on their faces, known vertices, ascending keys and an owner. */
static inline PetscErrorCode ContactsIsValid(const Model *m, const Contacts *c, PetscBool *valid)
{
  PetscInt bad = 0, n = 0, s = 0;
  PetscFunctionBeginUser;
  *valid = PETSC_FALSE;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    while (i >= c->model_start[s + 1]) s++;
    if (c->key[2 * i] < 0) {
      bad += c->length[i] != 0.;
      continue;
    }
    n++;
    const PetscBool on_vertex = (PetscBool)(c->klass[i] == VERTEX_FACE);
    bad += (c->key[2 * i] >= c->key[2 * i + 1]) != on_vertex || !(c->length[i] > 0.);
    PetscBool owned = PETSC_FALSE;
    for (int k = 0; k < CONTACT_ROWS; k++) {
      const PetscInt v = c->vertex[CONTACT_ROW(i, k)];
      bad += v < 0 || v >= m->mesh.n_vertices;
      owned = (PetscBool)(owned || v < m->mesh.n_owned);
    }
    for (int k = 0; k < 2; k++) bad += !(c->t[SUB(i, k)] > -1e-6 && c->t[SUB(i, k)] < 1. + 1e-6);
    if (i > c->model_start[s] && !keys_ascend(c, i)) bad++;
    bad += c->owned[i] && !owned;
  }
  bad += n != c->n;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPIU_INT, MPI_SUM, m->comm));
  *valid = (PetscBool)(bad == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ghost.c: the one exchange of a step: displacements of owned vertices to the ranks that compute elements or
   contacts with them. Forces never travel: every rank computes all that touches its own vertices. */
#include "internal.h"

PetscErrorCode GhostBegin(const Model *m, PetscReal *u)
{
  PetscFunctionBeginUser;
  if (m->size > 1) PetscCall(PetscSFBcastBegin(m->ghost, m->pair, u, u, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GhostEnd(const Model *m, PetscReal *u)
{
  PetscFunctionBeginUser;
  if (m->size > 1) PetscCall(PetscSFBcastEnd(m->ghost, m->pair, u, u, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

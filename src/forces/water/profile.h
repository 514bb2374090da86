/* profile.h: the contacts of a joint in a row, for uplift.c and crack.c. */
#pragma once
#include "forces/water/water.h"

/* A contact of the joint. */
typedef struct {
  PetscInt key[2];
  PetscReal point[2][2]; /* [m] reference place of its ends */
  PetscReal u_n[2];      /* [m] */
  PetscInt open[2];
} ProfileRow;

/* Collective. Contacts with a face in the ascending list of gids, by their faces; the same on all ranks.
   Free with PetscFree. */
PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows);
/* Collective. All ranks' rows one after the other, on all ranks; free with PetscFree. */
PetscErrorCode GatherAll(MPI_Comm comm, PetscInt n, size_t unit, const void *mine, PetscInt *n_all,
                         void *all);
/* [m] Place of a point along the chord from the heel. */
PetscReal UpliftPlace(const Uplift *u, const PetscReal X[2]);
/* Whether an ascending list of gids has this one. */
PetscBool ProfileHas(PetscInt n, const PetscInt *sorted, PetscInt gid);

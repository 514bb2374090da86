/* vibration.h: what modes of the whole (vibration.c) and those inside condensed bodies (vibration_bodies.c)
   share. */
#pragma once
#include "solve/solve.h"
#include <petscmat.h>

/* The mass: M, and b along x and y. Rows of a rank are its degrees of freedom, then the modes of its
   condensed bodies. */
typedef struct {
  const Model *m;
  PetscInt first, rows; /* of this rank: global number of the first, how many */
  Mat M;
  PetscReal *pull; /* [kg, kg m] (2, rows) b */
} Mass;

/* ---- vibration_bodies.c */
/* Collective. K: the tangent with the rows of modes inside condensed bodies; the tangent itself where there
   are none. */
PetscErrorCode InsideStiffness(const Model *model, Mat tangent, Mat *K);
/* Makes room in M for the inertia of condensed bodies. diagonal: (rows,) entries that other inertia takes. */
PetscErrorCode InsideRoom(const Model *model, PetscInt *diagonal);
/* Adds their inertia to M and to the pull. moving: [kg] (2,) what of the inside moves, added. */
PetscErrorCode InsideMass(Mass *mass, PetscReal moving[2]);
/* Displacements u (vertex array) of a shape at inner vertices, from those of the others. phi: (rows,). */
PetscErrorCode InsideShape(const Model *model, const PetscReal *phi, PetscReal *u);
/* Collective. [-] By what the frequency of a shape is too high, over it, because bodies lack their faster
   modes; NaN: it is not below these. u: the shape, of modal mass 1. */
PetscErrorCode InsideError(const Model *model, const PetscReal *u, PetscReal omega2, PetscReal *error);

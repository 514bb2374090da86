/* vibration.h: declares the mass matrix that vibration.c and vibration_bodies.c share. */
#pragma once
#include "solve/solve.h"
#include <petscmat.h>

/* The mass matrix M, and b along x and y. The rows of a rank are its degrees of freedom, then the modes of
   its condensed bodies. */
typedef struct {
  const Model *m;
  PetscInt first, rows; /* of this rank: global number of the first row, number of rows */
  Mat M;
  PetscReal *pull; /* [kg, kg m] (2, rows) b */
} Mass;

/* ---- vibration_bodies.c */
/* Collective. Makes K: the tangent with the rows of modes inside condensed bodies; the tangent itself where
   there are none. */
PetscErrorCode InsideStiffness(const Model *model, Mat tangent, Mat *K);
/* Raises the numbers of entries of M for the inertia of condensed bodies. diagonal: (rows,) numbers of
   entries. */
PetscErrorCode InsideRoom(const Model *model, PetscInt *diagonal);
/* Adds the inertia of condensed bodies to M and to the pull, and the mass inside that moves to moving (2,)
   [kg]. */
PetscErrorCode InsideMass(Mass *mass, PetscReal moving[2]);
/* Computes the displacements u (vertex array) of a shape phi (rows,) at inner vertices, from the
   displacements of the others. */
PetscErrorCode InsideShape(const Model *model, const PetscReal *phi, PetscReal *u);
/* Collective. Estimates by which fraction [-] the frequency of a shape is too high because bodies lack
   their faster modes; NaN: the frequency is not below these modes. u: the shape, of modal mass 1. */
PetscErrorCode InsideError(const Model *model, const PetscReal *u, PetscReal omega2, PetscReal *error);

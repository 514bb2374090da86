/* eigen.h: declares the slowest free vibrations of K and M (eigen.c). */
#pragma once
#include "base/base.h"
#include <petscmat.h>

/* Modes of K phi = omega^2 M phi, the slowest first. */
typedef struct {
  PetscInt n, rows;   /* modes; rows of K on this rank */
  PetscReal *omega2;  /* (n,) [1/s2], ascending; below 0: a growing motion */
  PetscReal *shapes;  /* (n, rows) phi at the rows of this rank, phi' M phi = 1 */
  PetscInt missed;    /* number of slower modes that were not found; -1: MUMPS gave no count */
  PetscReal rounding; /* [1/s2] smaller values are 0: a motion without stiffness */
  PetscBool wants;    /* MUMPS had too little memory, so there are no modes */
} Modes;

/* Collective on the ranks of K, which may be one rank alone (PETSC_COMM_SELF). Finds the slowest modes:
   all with omega <= omega_max [rad/s] (0: no limit), at most `most` (0: no limit; one of the two must be
   given). K and M are symmetric AIJ matrices of the same layout; both are marked so. K may have motions
   without stiffness. M may have rows without mass where K is regular; these belong to no mode. Each shape
   has its largest component positive; among equal components the first counts. The modes agree on any
   number of ranks to the tolerance of the solver, except for the choice of shapes of equal frequency. */
PetscErrorCode LowestModes(Mat K, Mat M, PetscReal omega_max, PetscInt most, Modes *modes);
PetscErrorCode ModesDestroy(Modes *modes);

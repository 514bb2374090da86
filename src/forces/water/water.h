/* water.h: water on faces and in joints. */
#pragma once
#include "forces/blocks/blocks.h"

/* Rows of the table of force terms. */
extern const TermKind Reservoir_term, Uplift_term;

/* Adds to f what a Gauss point at `at` of the face from x[0..1] to x[2..3] gives its ends. push: [N/m] weight
   times pressure times thickness; the face's length comes to it here. */
void PushOnFace(const PetscReal x[4], PetscReal at, PetscReal push, PetscReal f[4]);
/* Water pressure on one face, see reservoir.c. x: (4) its ends, f: (4) forces at them [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

/* water.h: water on faces and in joints. */
#pragma once
#include "forces/blocks/blocks.h"

/* Rows of the table of force terms. */
extern const TermKind Reservoir_term, Uplift_term;

/* Water pressure on one face, see reservoir.c. x: (4) its ends, f: (4) forces at them [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

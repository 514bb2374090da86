/* loads.h: declares dead loads (weight, traction, point force; the force term to copy), and temperature. */
#pragma once
#include "blocks/blocks.h"

extern const TermKind Loads_term, Temperature_term;

/* Adds the lumped masses (27) of the groups of the load (none named: all groups) times a [m/s2]. f_vertex:
   vertex array. */
PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex);

/* loads.h: dead loads: weight, traction, point force; the force term to copy. Temperature. */
#pragma once
#include "blocks/blocks.h"

extern const TermKind Loads_term, Temperature_term;

/* Adds the lumped masses (27) of the groups that the load names, of all groups when it names none, times a
   [m/s2]. f_vertex: vertex array. */
PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex);

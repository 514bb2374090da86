/* loads.h: declares dead loads (weight, traction, point force; the force term to copy), and temperature. */
#pragma once
#include "blocks/blocks.h"

extern const TermKind Loads_term, Temperature_term;

/* Completes the keys of a load, see reader.h. */
LoadCompletion CompleteTemperature;

/* Results of the blocks of a list, from their total strain until terms have corrected them. NULL: not
   requested. */
typedef struct {
  PetscReal *centre, *gauss; /* [Pa] (n, 3), (n, 1 or 4, 3) Cauchy stress, as from ElementStress and
                                ElementStressGauss */
  PetscReal *energy;         /* [J] (n,) */
  PetscReal *change;         /* [K] (n,) mean change of temperature */
  PetscReal *across;         /* [Pa] (n,) thermal part of the stress across the plane, at the centre */
} BlockAnswers;

/* Corrects the results of the blocks of a list for their temperature. v: of Temperature_term. */
PetscErrorCode TemperatureCorrects(const TermView *v, const Elements *list, BlockAnswers *answers);

/* Adds the lumped masses (27) of the groups of the load (none named: all groups) times a [m/s2]. f_vertex:
   vertex array. */
PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex);

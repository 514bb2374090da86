/* anchors.h: declares the force term of anchors: tendons and bars from block to block. */
#pragma once
#include "term/term.h"

extern const TermKind Anchors_term;

/* Collective. Adds to sum the energy [J] that anchors store at any displacement (prestress); the same on all
   ranks. */
PetscErrorCode AnchorsPrestressed(const TermView *v, PetscReal *sum);
/* Adds to f the forces of jacks, which follow the motion in large strain. any receives whether a jack pulls.
   f NULL: only decides this. */
PetscErrorCode AnchorsPull(const TermView *v, PetscBool *any, PetscReal *f);

/* Histories of anchors: one row each, the same on all ranks. The term owns the memory until the next call. */
typedef struct {
  PetscInt n_rows, n_columns;
  const char *const *names, *const *columns; /* of rows, of columns */
  const PetscReal *values;                   /* (n_rows, n_columns); NaN: not there */
} AnchorRecord;

/* Collective. Gets the histories of anchors; n_rows 0: the scene has none. */
PetscErrorCode AnchorsRecord(const TermView *v, AnchorRecord *record);

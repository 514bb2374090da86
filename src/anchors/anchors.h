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

/* ---- anchors_keys.c */
/* Checks the keys of all anchors, see reader.h. */
PetscErrorCode CompleteAnchors(Reader *r);

/* ---- anchor_shape.c */
/* Returns the length [m] from head to root. */
PetscReal AnchorLength(const Anchor *anchor);
/* Returns the free length [m]. */
PetscReal AnchorFree(const Anchor *anchor);
/* Returns the longest bonded piece [m]. */
PetscReal AnchorSegment(const Anchor *anchor);
/* Returns the force [N] at which it yields or breaks, infinite: never. */
PetscReal AnchorStrength(const Anchor *anchor);
/* Returns the largest force [N] of a jack, above which the anchor would yield, break or come out of its
   bond. */
PetscReal AnchorMostPull(const Anchor *anchor);
/* Returns the anchor of this name, NULL: none. */
const Anchor *AnchorNamed(const Scene *scene, const char *name);
/* Returns whether the stage is of type anchor_force and pulls this anchor. */
PetscBool AnchorIsPulled(const Stage *stage, const Anchor *anchor);
/* Returns the reference force [N] that a stage of type anchor_force scales: the prestress of the last
   stressing before the stage, otherwise of the first. */
PetscReal AnchorPrestress(const Scene *scene, const Stage *stage, const Anchor *anchor);
/* Finds stiffness [N/m] and strength [N] of the anchor as a dowel across a joint; 0: none. */
void AnchorDowel(const Anchor *anchor, PetscReal *stiffness, PetscReal *strength);

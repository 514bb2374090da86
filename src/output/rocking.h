/* rocking.h: declares the hinge about which a free-standing column turns over in a dynamic stage. */
#pragma once
#include "motion/motion.h"

/* The hinge about which a free-standing column turns over in time; part 0: none, or one on a rigid edge. */
typedef struct {
  PetscReal part;     /* [-] of its arm that is missing, because tptm presses the hinge over a length */
  PetscInt body, n;   /* the macroblock that stands on it; macroblocks that turn over together */
  PetscReal point[2]; /* [m] edge of the joint */
} RockingHinge;
/* Collective. Finds it by the contacts of now, after BodyMotionCreate. */
PetscErrorCode RockingHingeFind(const Problem *p, RockingHinge *hinge);
PetscErrorCode RockingHingeArchive(Archive *archive, RockingHinge *hinge);
/* Writes the "rocking_hinge" member of a dynamic stage, if it has one. */
void SummaryRocking(FILE *f, const RockingHinge *hinge);

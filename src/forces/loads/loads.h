/* loads.h: dead loads. */
#pragma once
#include "forces/blocks/blocks.h"

/* ---- loads.c */
/* Each adds the forces [N] of one load to f_vertex: lumped weight (27); pressure normal to the faces where
   they are; the same on the undeformed faces; at a point. */
PetscErrorCode WeightForces(const Scene *scene, const Load *load, const Model *model, PetscReal *f_vertex);
void TractionForces(const Load *load, const Model *model, PetscReal *f_vertex);
void PointForce(const Load *load, const Model *model, PetscReal *f_vertex);

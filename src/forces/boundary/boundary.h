/* boundary.h: supports and their motion. */
#pragma once
#include "model/model.h"

/* ---- supports.c */
/* Collective. Writes model->support from the scene's supports. */
PetscErrorCode SupportsApply(const Scene *scene, Model *model);

/* ---- support_motion.c */
typedef struct {
  PetscInt n;
  PetscReal *t; /* (n,) [s] */
  PetscReal
      *row; /* (n,2,4) along x, y: displacement [m] at a row and, just behind it, its three derivatives */
  PetscReal now[3]; /* [m/s] in this step, along x and y; none about the centre */
} SupportMotion;
/* Collective. (n_supports,) motion of each support that has one; refuses a file that is none. */
PetscErrorCode SupportMotionsRead(const Scene *scene, MPI_Comm comm, SupportMotion **motions);
PetscErrorCode SupportMotionsDestroy(const Scene *scene, SupportMotion **motions);
/* Collective. At the start of a stage: warns of supports whose file ends in motion before its end: they
   stop at once there, which is a blow; an accelerogram without base line correction does so. */
PetscErrorCode SupportMotionsWarn(const Scene *scene, const Stage *stage, MPI_Comm comm, PetscReal time,
                                  const SupportMotion *motions);
/* After Integrate: velocities and displacements of what moving supports hold, of the step and at its end. */
void SupportsMove(const Scene *scene, const Model *model, SupportMotion *motions, State *state);

/* judge.h: declares what judge.c asks the other files of the room about the motion in a chunk of cycles. */
#pragma once
#include "verdict/verdict.h"

/* ---- rest_point.c */
PetscErrorCode RestPointCreate(const Scene *scene, const Model *model, RestPoint *r);
PetscErrorCode RestPointDestroy(RestPoint *r);
/* Collective. Archives the means and steps of chunks, see archive.h. */
PetscErrorCode RestPointArchive(struct _p_Archive *archive, const Model *model, RestPoint *r);
/* Adds the state at a check to the means of the chunk. */
void RestPointAdd(const Model *model, const State *state, RestPoint *r);
/* Collective. Ends a chunk: finds its means, and the step from the means of the chunk before. */
PetscErrorCode RestPointOfChunk(const Model *model, const State *state, RestPoint *r);
/* Returns the least distance [m] to where nothing drives the motion any more that the means of the last
   chunks allow; 0: not known. */
PetscReal RestPointAhead(const RestPoint *r);

/* ---- contact_travel.c */
/* Collective. Finds the largest gain [-] of travel since the last call; -1: no joint can fail. */
PetscErrorCode ContactTravelOfChunk(const Problem *p, PetscReal *gain);

/* ---- failing_motion.c */
/* Collective. Finds the opening [m] of the widest open contact that closes when the degrees of freedom move
   on by `times` times du (n_dof,); 0: none closes. */
PetscErrorCode MotionCloses(const Model *model, const State *state, const Contacts *contacts,
                            const PetscReal *du, PetscReal times, PetscReal *gap);

/* forces.h: what acts on the blocks. */
#pragma once
#include "forces/boundary/boundary.h"
#include "forces/loads/loads.h"
#include "forces/water/water.h"

/* ---- terms.c: the table of force terms (term.h), row by row */
/* Collective. Memory of all terms, into state->terms. */
PetscErrorCode TermsCreate(const Scene *scene, const Model *model, const Contacts *contacts, State *state);
PetscErrorCode TermsDestroy(const Scene *scene, State *state);
/* u, f, k: vertex arrays. Resisting forces besides those of contacts and deformable blocks; row sums; [J]. */
void TermsForces(const Model *model, const State *state, const PetscReal *u, PetscReal *f);
void TermsBound(const Model *model, const State *state, PetscReal *k);
PetscReal TermsEnergy(const Model *model, const State *state, const PetscReal *u);
PetscErrorCode TermsTangent(const Model *model, const State *state, const PetscReal *u, TermAdd add,
                            void *context);
/* Whether the load presses on faces that move. */
PetscBool TermPresses(const Scene *scene, const Load *load);
/* Adds the forces of one load, a row of scene->loads. f: vertex array. */
PetscErrorCode TermApplied(const Scene *scene, const Model *model, const Stage *stage, const State *state,
                           PetscInt load, PetscReal *f);
/* Collective. See term.h. */
PetscErrorCode TermsBegin(const Scene *scene, const Stage *stage, const Model *model,
                          const Contacts *contacts, const State *state);
PetscErrorCode TermsSettle(const Scene *scene, const Stage *stage, const Model *model,
                           const Contacts *contacts, const State *state, StageResult *result,
                           PetscBool *again);
PetscErrorCode TermsSurvey(const Scene *scene, const Stage *stage, const Model *model,
                           const Contacts *contacts, const State *state, PetscBool tell);
void TermsHistory(const Scene *scene, const State *state, TermHistory what);
PetscErrorCode TermsArchive(Archive *archive, const Scene *scene, const Model *model, const State *state);
PetscErrorCode TermsArchiveStable(Archive *archive, const Scene *scene, const Model *model,
                                  const State *state);
/* Rank 0. */
void TermsSummary(FILE *f, const Scene *scene, const Stage *stage, const Model *model, const State *state);

/* ---- applied.c */
/* Sets state->f_target from the stage's loads in the present position (water pressure stays normal to its
   face); again after blocks have moved. */
PetscErrorCode LoadsTarget(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Whether water acts that follows the faces it presses on. */
PetscBool LoadsPress(const Scene *scene, const Stage *stage);
/* Whether applied forces change with the displacements: by such water, or because the arms of forces about
   the mass centre of a rigid body turn with it. */
PetscBool LoadsChange(const Scene *scene, const Model *model, const Stage *stage);
/* For stages in time, which have no ramp: the loads that are not such into state->f_start; and, every step,
   state->f_target from these and the water on the faces as they are. Nothing is allocated. */
PetscErrorCode LoadsDead(const Scene *scene, const Model *model, const Stage *stage, State *state);
PetscErrorCode LoadsFollow(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Forces and present moments on rigid bodies, into the first 3 n_bodies entries of f, from the loads at their
   vertices behind them; no moment where the resultant stands at the mass centre however a body turns. Whether
   a body that may turn has a moment now or when turned. Local. */
PetscBool LoadsTurn(const Model *model, const PetscReal *u, PetscReal *f);
/* Where applied forces change with the displacements: those of now, at the present ramp. */
PetscErrorCode LoadsRenew(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* f_ext = (1 - ramp) f_start + ramp f_target. */
void LoadsApply(const Model *model, State *state, PetscReal ramp);

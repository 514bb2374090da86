/* forces.h: what acts on the blocks. */
#pragma once
#include "anchors/anchors.h"
#include "boundary/boundary.h"
#include "loads/loads.h"
#include "seepage/seepage.h"

/* ---- terms.c: the table of force terms (term.h), row by row */
/* Collective. What all terms couple, from the mesh on rank 0. */
PetscErrorCode TermsReads(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh, Couplings *couplings);
PetscErrorCode CouplingsDestroy(Couplings *couplings);
/* Collective. Creates the memory of all terms in state->terms. */
PetscErrorCode TermsCreate(const Scene *scene, const Model *model, Contacts *contacts, State *state);
PetscErrorCode TermsDestroy(const Scene *scene, State *state);
/* The rows of one phase: TermsForces adds their resisting forces to f, TermsEnergy gives the stored energy of
   this rank [J], TermsTangent gives `add` the stiffness. f: vertex array. */
PetscErrorCode TermsForces(TermPhase phase, const State *state, const Instant *at, PetscReal *f);
PetscErrorCode TermsEnergy(TermPhase phase, const State *state, const Instant *at, PetscReal *sum);
/* [J] What has been lost in terms for good, on this rank. */
PetscReal TermsLost(const State *state);
PetscErrorCode TermsTangent(TermPhase phase, const State *state, const Instant *at, TangentKind kind,
                            TermAdd add, void *context);
/* All rows: TermsAdvance comes after each step in time; TermsBound adds row sums to k, TermsDrag those of
   dampers to c, vertex arrays; TermsDamped gives the work of dampers in the stage so far, of this rank
   [J]. */
void TermsAdvance(const Model *model, State *state);
void TermsMoved(const Model *model, const State *state, const PetscReal *v_before);
PetscErrorCode TermsBound(const State *state, const Instant *at, PetscBool anywhere, PetscReal *k);
PetscErrorCode TermsDrag(const State *state, const Instant *at, PetscBool anywhere, PetscReal *c);
PetscReal TermsDamped(const State *state);
PetscErrorCode TermsInertia(const TermView *view, TermInertia add, void *context);
void TermsIncoming(const Model *model, const State *state, Incoming *in);
/* Whether the load changes on the way: it presses on faces and follows their motion, or has a history. */
PetscBool TermPresses(const Scene *scene, const Load *load);
/* Adds the forces of one load, a row of scene->loads. f: vertex array. */
PetscErrorCode TermApplied(const Scene *scene, const Model *model, const Stage *stage, const State *state,
                           PetscInt load, PetscReal *f);
/* Adds to f the forces that terms apply without a load of the scene; any: there are some; f: NULL: only
   asks. */
PetscErrorCode TermsPull(const TermView *view, PetscBool *any, PetscReal *f);
/* Collective, all but TermsHistory. These call the functions of the same name in each row, see term.h; they
   fill in the memory of the view. */
PetscErrorCode TermsBegin(const TermView *view);
/* commit: what has changed stays, so joints remember the equilibrium. */
PetscErrorCode TermsSettle(const TermView *view, TermMoment when, StageResult *result, PetscBool *again,
                           PetscBool *commit);
/* Whether a row tries in the stage of the view. */
PetscBool TermsTry(const TermView *view);
/* grow: the least that a row asks for. */
PetscErrorCode TermsStepOver(const TermView *view, StageResult *result, PetscReal *grow);
/* [J] What terms store however little they have been displaced. */
PetscErrorCode TermsPrestressed(const TermView *view, PetscReal *sum);
PetscErrorCode TermsSurvey(const TermView *view, PetscBool tell);
PetscErrorCode TermsHistory(const TermView *view, TermHistory what);
PetscErrorCode TermsArchive(Archive *archive, const TermView *view);
/* Collective. A hash of what all terms but contacts remember, the same on any number of ranks; 0: nothing. */
PetscErrorCode TermsDigest(const TermView *view, uint64_t *digest);
PetscErrorCode TermsArchiveStable(Archive *archive, const TermView *view);
/* Corrects what is said of the blocks of a list. */
PetscErrorCode TermsOfBlocks(const TermView *view, const Elements *list, BlockAnswers *answers);
/* Collective. What a term tells of things with names; n_rows 0: none does. */
PetscErrorCode TermsRecord(const TermView *view, TermRecord *look);
/* Rank 0. The tables of all terms that have one. */
PetscErrorCode TermsTables(const TermView *view, PetscInt *n, TermTable **tables);
PetscErrorCode TermsTablesDestroy(PetscInt *n, TermTable **tables);
/* Rank 0. Writes the members of all terms into summary.json. */
void TermsSummary(FILE *f, const TermView *view);

/* ---- applied.c */
/* Sets state->applied.target from the stage's loads in the present position. It must be called again after
   blocks have moved, because water pressure stays normal to its face. */
PetscErrorCode LoadsTarget(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* The loads that act now are those from which a ramp starts. */
PetscErrorCode LoadsFromNow(const Model *model, State *state);
/* Whether loads act that change on the way (TermPresses). */
PetscBool LoadsPress(const Scene *scene, const Stage *stage);
/* Whether applied forces change with the displacements: because of such water, or because the lever arms of
   forces about the mass centre of a rigid body turn with the body. */
PetscBool LoadsChange(const Scene *scene, const Model *model, const Stage *stage, const State *state);
/* For stages in time, which have no ramp and so no other use for applied.start. LoadsDead puts the loads
   that do not follow the motion into state->applied.start. LoadsFollow, called every step, makes
   state->applied.target of these and of the water on the faces as they are; it allocates nothing. */
PetscErrorCode LoadsDead(const Scene *scene, const Model *model, const Stage *stage, State *state);
PetscErrorCode LoadsFollow(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Sums the loads at vertices of rigid bodies into forces and present moments in the first 3 n_bodies entries
   of f. The moment is zero where the resultant stands at the mass centre however the body turns. Returns
   whether a body of this rank that may turn has a moment now or when turned. f: dof array with the vertex
   array behind it. Not collective. */
PetscBool LoadsTurn(const Model *model, const PetscReal *u, PetscReal *f);
/* Takes the applied forces anew, at the present displacements and ramp, where they change with the
   displacements. */
PetscErrorCode LoadsRenew(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Sets f_ext = (1 - ramp) start + ramp target. */
void LoadsApply(const Model *model, State *state, PetscReal ramp);

/* forces.h: declares the table of force terms, and the applied forces. */
#pragma once
#include "anchors/anchors.h"
#include "boundary/boundary.h"
#include "loads/loads.h"
#include "seepage/seepage.h"

/* ---- terms.c: the table of force terms (term.h), row by row */
/* Collective. Collects the couplings of all terms from the mesh on rank 0. */
PetscErrorCode TermsReads(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh, Couplings *couplings);
PetscErrorCode CouplingsDestroy(Couplings *couplings);
/* Collective. Creates the memory of all terms in state->terms. */
PetscErrorCode TermsCreate(const Scene *scene, const Model *model, Contacts *contacts, State *state);
PetscErrorCode TermsDestroy(const Scene *scene, State *state);
/* Rows of one phase: TermsForces adds resisting forces to f, TermsEnergy returns the stored energy [J] of
   this rank, TermsTangent passes the stiffness to `add`. f: vertex array. */
PetscErrorCode TermsForces(TermPhase phase, const State *state, const Instant *at, PetscReal *f);
PetscErrorCode TermsEnergy(TermPhase phase, const State *state, const Instant *at, PetscReal *sum);
/* Returns the energy [J] dissipated in terms so far, on this rank. */
PetscReal TermsDissipated(const State *state);
PetscErrorCode TermsTangent(TermPhase phase, const State *state, const Instant *at, TangentKind kind,
                            TermAdd add, void *context);
/* Follows each step in time. TermsBound adds row sums of stiffness to k; TermsDrag adds row sums of dampers
   to c, vertex arrays. TermsDamped returns the work [J] of dampers in the stage so far, on this rank. All of
   them call all rows. */
void TermsAdvance(const Model *model, State *state);
/* Keeps, after each step in time, the largest acceleration of faces away from the water. */
void TermsAfterStep(const Model *model, const State *state, const PetscReal *v_before);
PetscErrorCode TermsBound(const State *state, const Instant *at, PetscBool anywhere, PetscReal *k);
PetscErrorCode TermsDrag(const State *state, const Instant *at, PetscBool anywhere, PetscReal *c);
PetscReal TermsDamped(const State *state);
PetscErrorCode TermsInertia(const TermView *view, TermInertia add, void *context);
void TermsIncoming(const Model *model, const State *state, Incoming *in);
/* Returns what a stage of type pushover moves. NULL: the scene has no such stage. */
Push *PushOf(const State *state);
/* Returns whether what is moved is on its way within an increment. Local damping damps its motion then:
   alpha would resist it with a force of the scaled masses. */
static inline PetscBool PushWalks(const State *state)
{
  const Push *push = PushOf(state);
  return (PetscBool)(push && push->acts && push->ramp < 1.);
}
#define PUSH_LOCAL 0.8 /* as relaxation.local */
/* Decides whether the load changes with the motion: it presses on faces and follows them, or has a
   history. */
PetscBool TermPresses(const Scene *scene, const Load *load);
/* Adds the forces of one load, a row of scene->loads. f: vertex array. */
PetscErrorCode TermApplied(const TermView *view, PetscInt load, PetscReal *f);
/* Adds to f the forces that terms apply without a load of the scene. any receives whether there are some.
   f NULL: only decides this. */
PetscErrorCode TermsApplyWithoutLoad(const TermView *view, PetscBool *any, PetscReal *f);
/* Calls the function of the same name in each row, see term.h, with the memory of the row in the view; so do
   the following functions. All but TermsHistory are collective. */
PetscErrorCode TermsBegin(const TermView *view);
/* Settles all rows. commit receives whether joints commit the equilibrium, because what has changed is no
   trial. */
PetscErrorCode TermsSettle(const TermView *view, TermMoment when, StageResult *result, PetscBool *again,
                           PetscBool *commit);
/* Decides whether a row has trials in the stage of the view. */
PetscBool TermsHaveTrial(const TermView *view);
/* Ends a step of all rows. grow receives the least factor of all rows. */
PetscErrorCode TermsStepDone(const TermView *view, StageResult *result, PetscReal *grow);
/* Returns the energy [J] that terms store at any displacement (prestress). */
PetscErrorCode TermsPrestressed(const TermView *view, PetscReal *sum);
PetscErrorCode TermsBeforeSummary(const TermView *view, PetscBool report);
PetscErrorCode TermsHistory(const TermView *view, TermHistory what);
PetscErrorCode TermsArchive(Archive *archive, const TermView *view);
/* Collective. Computes a hash of the state of all terms but contacts, the same on any number of ranks; 0:
   no state. */
PetscErrorCode TermsDigest(const TermView *view, uint64_t *digest);
PetscErrorCode TermsArchiveStable(Archive *archive, const TermView *view);
/* Corrects the results of the blocks of a list. */
PetscErrorCode TermsOfBlocks(const TermView *view, const Elements *list, BlockAnswers *answers);
/* Collective. Gets the histories of named things of a term; n_rows 0: none has any. */
PetscErrorCode TermsRecord(const TermView *view, AnchorRecord *record);
/* Collective. Lists the force of each load of the stage on each face, sorted by load and face. Only rank 0
   has rows. */
PetscErrorCode LoadsTable(const TermView *view, TermTable *table);
/* Rank 0. Collects the tables of all terms, and takes over `other`, if it has rows. */
PetscErrorCode TermsTables(const TermView *view, TermTable *other, PetscInt *n, TermTable **tables);
PetscErrorCode TermsTablesDestroy(PetscInt *n, TermTable **tables);
/* Rank 0. Writes the members of all terms into summary.json. */
void TermsSummary(Json *json, const TermView *view);

/* ---- applied.c */
/* Sets state->applied.target from the stage's loads in the present position. Call again after blocks have
   moved, because water pressure stays normal to its face. */
PetscErrorCode LoadsTarget(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Sets the start of a ramp to the present loads. */
PetscErrorCode LoadsFromNow(const Model *model, State *state);
/* Decides whether loads change with the motion (TermPresses). */
PetscBool LoadsPress(const Scene *scene, const Stage *stage);
/* Decides whether applied forces change with displacements: because of such loads, or because the lever
   arms of forces about the mass centre of a rigid body rotate with the body. */
PetscBool LoadsChange(const Scene *scene, const Model *model, const Stage *stage, const State *state);
/* Sets state->applied.start to the loads that do not follow the motion, for dynamic stages, which have no
   ramp and so no other use for applied.start. LoadsFollow, called every step, sets state->applied.target to
   these plus the water on the faces in their present position; it allocates nothing. */
PetscErrorCode LoadsDead(const Scene *scene, const Model *model, const Stage *stage, State *state);
PetscErrorCode LoadsFollow(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Sums the loads at vertices of rigid bodies into forces and present moments in the first 3 rigid.n
   entries of f. The moment is zero if the resultant acts at the mass centre in any rotation. Returns
   whether an owned body that may rotate has a moment now or when rotated. f: dof array with the vertex
   array after it. Not collective. */
PetscBool LoadsTurn(const Model *model, const PetscReal *u, PetscReal *f);
/* Recomputes the applied forces, at present displacements and ramp, if they change with displacements. */
PetscErrorCode LoadsRenew(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Sets f_ext = (1 - ramp) start + ramp target. */
void LoadsApply(const Model *model, State *state, PetscReal ramp);

/* solve.h: declares how a static stage finds its equilibrium, and how modes are found. */
#pragma once
#include "output/output.h"
#include "verdict/verdict.h"

/* ---- method.c */
/* Collective. Chooses the method of a static stage or a trial, the same on any number of ranks.
   choice: has given_up of the stage so far; receives the reason. */
PetscErrorCode StageMethod(const Scene *scene, const Model *model, const Contacts *contacts,
                           const Stage *stage, MethodKind *method, MethodChoice *choice);
/* Returns whether Newton's method, chosen by relaxation.method: auto, has worked as long in this static stage
   or trial as explicit cycles are expected to take. */
PetscBool MethodSpent(const Problem *p);
/* Returns whether explicit cycles, chosen by relaxation.method: auto, have let slip go in a static stage of
   many bodies. From then on blocks creep to where they rest or fall, and cycles with the stiffness as mass
   find that in a tenth of the cycles. */
PetscBool MethodCreeps(const Problem *p);
/* Returns whether cycles with the stiffness as mass of rubble have stalled, so that explicit cycles go on. */
PetscBool MethodStalls(const Problem *p);
/* Notes that Newton's method has handed over to explicit cycles. */
void MethodHandsOver(const Problem *p);

/* ---- friction_mode.c */
/* Changes how fast friction follows its law when the ratio stalls: closely, from afar, at last not at all.
   Call it at a check. */
PetscErrorCode FrictionModeSwitch(const Model *model, const State *state, PetscReal ratio, Relaxation *r,
                                  Contacts *contacts);
/* Restarts the count of stalls after loads have changed within the stage; friction follows its law closely
   again. Does nothing where slip is kept as it comes. */
void FrictionModeRestart(Relaxation *r, Contacts *contacts);
/* Collective. Raises the stiffness-proportional damping for the rest of the stage, and the masses with it. */
PetscErrorCode RelaxationStill(const Problem *p);

/* ---- stiffness_cycles.c */
/* Collective. Gives the cycles of a stage or trial a mass that is proportional to the elastic stiffness,
   from rest. Where there is no factor of the stiffness, warns, and the cycles keep their diagonal mass. The
   mass stays until StiffnessMassEnd. */
PetscErrorCode StiffnessCyclesBegin(const Problem *p);
/* Collective. Does the same behind the ramp, from the present displacements, and writes a checkpoint. */
PetscErrorCode StiffnessCyclesGoOn(const Problem *p);
/* Collective. Lets explicit cycles go on from the present displacements, at rest, with friction that follows
   its law closely again, and writes a checkpoint. */
PetscErrorCode StiffnessCyclesLeave(const Problem *p);
/* Ends such cycles: the next ones have a diagonal mass and start from rest. */
PetscErrorCode StiffnessCyclesEnd(const Problem *p);
/* Collective. Finds, at a check, whether explicit cycles must do the stage again from its start. That is so
   where such cycles have found no verdict in MOST_STIFFNESS_CYCLES after the ramp. It is also so where blocks
   have jumped (thresholds.h) and have come to rest, and where the cycles diverge. Notes in the effort which
   of these it was. With variable connectivity no stage can go back, and the evidence of a divergence names
   explicit cycles. */
PetscErrorCode StiffnessCyclesFail(const Problem *p, PetscBool *fail);
/* Collective. Gives such cycles the stiffness of the contacts that have just been found. Without a factor
   they go on as explicit cycles. */
PetscErrorCode StiffnessCyclesRenew(const Problem *p);
/* Collective. Archives the momentum of such cycles, see archive.h. Reading makes the factor again. */
PetscErrorCode StiffnessCyclesArchive(Archive *archive, const Problem *p);

/* ---- factor.c */
/* Collective. Finds whether there is memory for the factor of NewtonRelax, or of a solve every cycle.
   memory [byte], of all machines together: [0] expected size of the factor, [1] available. */
PetscErrorCode NewtonFits(const Model *model, PetscBool every_cycle, double memory[2], PetscBool *fits);

/* ---- newton.c */
/* Collective. Finds the equilibrium of a static stage or trial with fixed connectivity, under loads that go
   from applied.start to applied.target, by Newton's method with the factor of the elastic stiffness. The
   verdict is converged, collapsed (contacts outgrown, or a mechanism seen by creep) or interrupted. It is
   VERDICT_NONE when no equilibrium was found or the factor cannot be made. Displacements, history and f_ext
   then belong to the last equilibrium, and the explicit loop goes on. */
PetscErrorCode NewtonRelax(const Problem *p);
PetscErrorCode NewtonDestroy(Newton **newton);
/* Collective. Finds the lowest frequency [1/cycle] of the scaled masses on the elastic stiffness that was
   factorised; 0: there is no factor. Call it after NewtonRelax; it overwrites the last correction. */
PetscErrorCode NewtonLowestFrequency(const Model *model, const State *state, const Newton *newton,
                                     PetscReal *omega);

/* ---- vibration.c */
/* Collective. Finds the modes of the stage about the present state, which it leaves as it is. Refuses a body
   without mass. */
PetscErrorCode VibrationFind(const Problem *p, Vibration *vibration);

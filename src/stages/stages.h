/* stages.h: declares the functions that run a stage of any kind, from its start to its verdict. */
#pragma once
#include "solve/solve.h"

/* ---- energy.c */
/* The energy account of a dynamic stage. Unless a comment says otherwise, sums cover this rank. */
typedef struct {
  PetscReal *v_before;     /* (n_dof,) velocity before the step */
  PetscReal *f_before;     /* (n_dof,) resisting force with the contacts before a verification */
  PetscReal *f_ext_before; /* (n_dof,) loads of the step before */
  PetscReal *u_start;      /* [m, rad] (n_dof,) at the start of the stage; NULL: no condensed bodies */
  PetscReal *F_n, *F_s, *d_n, *d_s; /* F_n, F_s, u_n, u_s of Contacts at the step before */
  PetscReal *work;                  /* (n_contacts,) [J] work of each contact since it was found */
  PetscInt n_contacts;              /* padded */
  PetscReal work_before;            /* [J] work of contacts that no longer exist, and of their exchange */
  PetscReal kinetic, strain, outside, supports, damping, damping_ahead,
      detection;                           /* [J] as in Energies; damping_ahead: of the half step after this
                                              time; detection: over all ranks */
  PetscReal lost;                          /* [J] dissipated part of strain */
  PetscReal local[COUPLED_WORKS];          /* [J] works of added mass and dashpots, see motion.h */
  PetscReal handed;                        /* [J] kinetic energy made by changes of the step */
  PetscReal kinetic_0, strain_0, joints_0; /* [J] at the start, over all ranks */
  PetscReal prestress_0;                   /* [J] part of strain_0 in tendons */
  PetscReal given[2]; /* [J] largest loss of strain_0 and of joints_0 at a check, over all ranks */
} EnergyAccount;
PetscErrorCode EnergyCreate(const Model *model, EnergyAccount *e);
PetscErrorCode EnergyDestroy(EnergyAccount *e);
/* Collective. Archives the account, see archive.h. The contacts must have been read before. */
PetscErrorCode EnergyArchive(struct _p_Archive *archive, const Model *model, const Contacts *contacts,
                             EnergyAccount *e);
/* Adds the works of contacts over the step that led to the forces just evaluated. */
void EnergyOfContacts(const Model *model, const Contacts *contacts, EnergyAccount *e);
/* Adds half a step's work of the change of forces since f_before. To be called when contacts were found
   again. */
void EnergyOfExchange(const Model *model, const State *state, EnergyAccount *e);
/* Adds the works of loads and supports over the last step, and sets kinetic energy and damping of this
   time. */
void EnergyOfStep(const StepWorks *works, EnergyAccount *e);
/* Changes the account to a new step. `before` and `closed`: the accounts before and after the old step was
   booked; e: the account in which the new step about the same time is booked too. e becomes an account to
   which the new step has yet to be added. */
void EnergyHandOver(const EnergyAccount *before, const EnergyAccount *closed, EnergyAccount *e);
/* Starts the works of contacts from zero. To be called when the contacts are new, with forces evaluated. */
PetscErrorCode EnergyContactsChanged(const Contacts *contacts, EnergyAccount *e);
/* Sets the strain energy: what blocks and other terms on bodies store or have lost on this rank, at the
   forces just evaluated. To be called before the step, when a report follows. */
PetscErrorCode EnergyOfBlocks(const Problem *p, EnergyAccount *e);
/* Finds the energy [J] that joints store on this rank at the forces just evaluated. */
PetscErrorCode EnergyOfJoints(const Problem *p, PetscReal *stored);
/* Collective. Reports the account at the time of the last evaluation. first: at the start of the stage. */
PetscErrorCode EnergyReport(const Problem *p, EnergyAccount *e, PetscBool first, Energies *out);

/* Collective. Decides the verdict of a stage in time that ran for its duration: completed, or diverged where
   too much of the energy came from nothing. */
PetscErrorCode EnergyJudge(const Problem *p);

/* ---- search_energy.c */
/* The energy that a search for contacts makes. */
typedef struct {
  PetscReal stored[2]; /* [J] in joints, before and after the search */
  PetscReal *sum;      /* of each macroblock, see search_energy.c */
} SearchEnergy;
/* Collective. Measures the energy before a search, SearchEnergyEnd after it, both with forces evaluated.
   SearchEnergyEnd adds the energy made to `detection`. The stage has diverged if contacts of a body start
   with more energy than it and the bodies that it meets have. */
PetscErrorCode SearchEnergyBegin(const Problem *p, SearchEnergy *made);
PetscErrorCode SearchEnergyEnd(const Problem *p, SearchEnergy *made, PetscReal *detection);

/* ---- motion_warnings.c */
/* Collective. Warns on rank 0 of anything that makes the answer of a stage in time doubtful: stress models
   without a potential, joints that nothing damps, ground that moves while the blocks rest. */
PetscErrorCode MotionWarnings(const Problem *p);

/* ---- velocities.c */
/* Moves velocities by half a step of the present forces: -1 back to t - dt/2 at the start of a stage, +1
   forward to t at its end. local: see motion.h; ground: [m/s] velocity against which alpha damps. */
PetscErrorCode VelocitiesHalfStep(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                  PetscReal sign, EnergyAccount *e);
/* Books the step about the present time, by forces just evaluated, without making it. last: no other step
   will book it again. behind: (n_dof,) the velocities after it; NULL: not needed. */
PetscErrorCode VelocitiesAccount(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                 PetscBool last, PetscReal *behind, EnergyAccount *e);
/* Changes to the step dt, when forces are evaluated and the step is not made yet. Not for condensed bodies
   and columns of free ground, which have velocities of their own. */
PetscErrorCode VelocitiesChange(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                PetscReal dt, EnergyAccount *e);

/* ---- step_control.c */
enum { STEP_LEVELS = 5 }; /* dt_factor auto: steps are the longest step over 1, 2, 4, 8, 16 */
/* The step of a stage in time. Time is counted in the shortest steps: a step starts at a multiple of itself,
   so the run meets all multiples of the longest step, and the end of the stage. */
typedef struct {
  PetscInt levels;           /* number of levels of steps; 1: the step is constant */
  PetscInt level, next;      /* level of the present step; of the next step */
  PetscInt wanted;           /* level that the last check of contacts needs */
  PetscInt64 total, done;    /* number of shortest steps in the stage; number of them done */
  PetscInt64 stayed;         /* steps since the level changed */
  PetscInt64 changes;        /* changes of the level so far */
  PetscReal longest;         /* [s] step of level 0 */
  PetscInt64 rows_every;     /* longest steps between rows of the history */
  PetscInt64 envelope_every; /* longest steps between samples of the envelopes; 0: none */
  PetscReal before[2];       /* [s] the two steps before the present one */
  PetscReal fastest;         /* [m/s] largest speed of contacts so far */
  PetscReal *mass;      /* [kg] (n_bodies_global,) masses of free bodies, infinite for the others; NULL: not
                             known yet */
  PetscInt64 *table;    /* (n_bodies_global, ..) sums of a check, impact_step.c */
  PetscInt64 *met;      /* (n_bodies_global,) time at which a body met another on a dashpot, in shortest
                             steps */
  PetscReal speed2;     /* [m^2/s^2] square of V, vibration_step.c */
  PetscReal vibration;  /* [1/s^2] the square of the step is at most its inverse */
  PetscReal *free_mass; /* [kg] (n_bodies_global,) masses that nothing holds; NULL: not known yet */
  PetscInt64 *sums;     /* (n_bodies_global, ..) sums of a check, vibration_step.c */
  PetscInt64 *loose;    /* (n_bodies_global,) 1: the body has slid, see vibration_step.c */
  PetscBool swings;     /* some body has met another, and still oscillates on a dashpot */
} StepControl;
/* Returns the number of shortest steps in a step of the level. */
static inline PetscInt64 StepControlTicks(const StepControl *control, PetscInt level)
{
  return (PetscInt64)1 << (control->levels - 1 - level);
}
/* Collective. Finds the largest part of the stability bound that a dynamic stage takes, by dt_factor, and the
   number of levels below it. */
PetscErrorCode StepControlFactor(const Problem *p, PetscReal *factor, PetscInt *levels);
/* Returns the number of steps to be expected of a stage of `longest` longest steps: the middle of the ladder
   where joints can slide or open. */
PetscReal StepControlExpected(const Problem *p, PetscReal longest, PetscInt levels);
/* Starts with steps of at most dt; the present step is the shortest one. */
PetscErrorCode StepControlBegin(const Problem *p, PetscReal dt, PetscInt levels, StepControl *control);
/* Collective. Checks contacts where it is time to: in a step whose forces have just been evaluated, before
   the account has taken the contacts. */
PetscErrorCode StepControlCheck(const Problem *p, const EnergyAccount *e, StepControl *control);
/* Returns the advice how to make the step of the stage shorter. */
const char *StepControlRemedy(const Stage *stage);
/* Sets the level of the next step after a step has been made. */
void StepControlAdvance(const Problem *p, StepControl *control);
PetscErrorCode StepControlDestroy(StepControl *control);
PetscErrorCode StepControlArchive(Archive *archive, const Problem *p, StepControl *control);
/* Collective. Reports how many steps a dynamic stage makes, what limits them, and its damping; warns of
   joints for which no step is right. */
PetscErrorCode StepControlDescribe(const Problem *p, const TimeStep *step, StepControl *control);

/* Collective. Reports how often the step has changed, where it may. */
PetscErrorCode StepControlReport(const Problem *p, const StepControl *control);

/* ---- impact_step.c */
PetscErrorCode ImpactStepCreate(const Model *model, StepControl *control);
PetscErrorCode ImpactStepDestroy(StepControl *control);
/* Collective. Sets the level that contacts need as they open or close. e: the account of the step before. */
PetscErrorCode ImpactStepCheck(const Problem *p, const EnergyAccount *e, StepControl *control);

/* ---- vibration_step.c */
/* Raises V to the largest speed of the ground in the stage. */
PetscErrorCode VibrationStepBegin(const Problem *p, StepControl *control);
PetscErrorCode VibrationStepCreate(const Model *model, StepControl *control);
PetscErrorCode VibrationStepDestroy(StepControl *control);
/* Collective. Raises the level to the one that the vibrations of bodies need. */
PetscErrorCode VibrationStepCheck(const Problem *p, StepControl *control);

/* ---- dynamic.c */
/* Collective. Runs a dynamic stage for its duration. */
PetscErrorCode DynamicRun(const Problem *p);

/* ---- modes.c */
/* Collective. Finds the modes of the present state, which stays as it is. */
PetscErrorCode ModesRun(const Problem *p);

/* ---- stages.c */
/* Collective. Runs a stage of any kind to its verdict, and reports the verdict. */
PetscErrorCode StageRun(const Problem *p);

/* ---- snapshot.c */
/* The start of a trial: displacements, loads and, kept by the terms, histories. */
typedef struct {
  PetscReal *u, *u_verified, *f_ext, *share, *nonlinear, *corrected;
  PetscReal alpha, q_ray, contact_depth;
} Snapshot;
PetscErrorCode SnapshotCreate(const Problem *p, Snapshot *snapshot);
PetscErrorCode SnapshotDestroy(Snapshot *snapshot);
/* Collective. Keeps the present state; SnapshotRestore goes back to it. */
PetscErrorCode SnapshotTake(const Problem *p, Snapshot *snapshot);
PetscErrorCode SnapshotRestore(const Problem *p, const Snapshot *snapshot);
/* Collective. Archives the snapshot except alpha and q_ray, see archive.h. */
PetscErrorCode SnapshotArchive(Archive *archive, const Problem *p, Snapshot *snapshot);

/* ---- lifts.c */
/* Collective. Makes the groups of the first stage present, after ModelCreate and BlocksCreate. Refuses groups
   without support, and features that lifts cannot be combined with. */
PetscErrorCode LiftsCreate(const Scene *scene, Model *model);
PetscErrorCode LiftsDestroy(Model *model);
/* Collective. Places the groups of a stage at its start, unless a checkpoint has restored them, and sets the
   written displacements to zero. */
PetscErrorCode LiftsPlace(const Problem *p);
/* Collective. Archives the groups that are built, see archive.h. */
PetscErrorCode LiftsArchive(Archive *archive, const Scene *scene, Model *model, State *state);

/* ---- static.c */
/* Collective. Relaxes a static stage, or one trial of another stage, under its loads and joints. The caller
   reports the verdict. */
PetscErrorCode StageRelax(const Problem *p);

/* ---- trial_stage.c */
/* Collective. Runs a strength reduction; RaiseRun runs a flood or a load factor; AnchorForceRun searches for
   the force of anchors. A strength reduction leaves in p->stage->joints the strengths of the last stable
   trial. */
PetscErrorCode ReductionRun(const Problem *p);
PetscErrorCode RaiseRun(const Problem *p);
PetscErrorCode AnchorForceRun(const Problem *p);
/* Raises the waters of a flood by `rise` [m]; other loads stay as the scene has them. loads: (n_loads,) */
void FloodRaise(const Scene *scene, const Stage *stage, PetscReal rise, Load *loads);

/* ---- pushover.c */
/* Collective. Moves a point, a body, a group or what loads act on along the path of the stage, from
   equilibrium to equilibrium. */
PetscErrorCode PushoverRun(const Problem *p);
/* Collective, after TermsCreate. Refuses stages of this type that cannot move what they name. */
PetscErrorCode PushoverCheck(const Scene *scene, Model *model, Contacts *contacts, State *state);

/* ---- trial_warnings.c */
/* Collective. Warns where bodies slip on each other in the present state, the last stable one of a search. */
PetscErrorCode WarnOfPaths(const Problem *p);
/* Warns where, under fixed connectivity, bodies of `size` [m] have moved so far that the limit has shifted.
   moved: [m] from the first trial to the last stable one. */
void WarnOfShift(const Problem *p, PetscReal moved, PetscReal size);

/* ---- transient.c */
/* Collective. Runs equilibria while water in joints flows in time. */
PetscErrorCode TransientRun(const Problem *p);

/* ---- keys of stages, see reader.h: stage_keys.c, trial_keys.c, transient.c */
/* Finds the stage from which a stage of any kind starts, and checks its loads. */
StageCompletion CompleteStage;
/* Complete the keys of the kinds. */
StageCompletion CompleteDamping, CompleteTransient, CompleteReduction, CompleteFlood, CompleteLoadFactor,
    CompleteAnchorForce, CompletePushover;

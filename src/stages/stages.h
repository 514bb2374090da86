/* stages.h: runs a stage of any kind, from its start to its verdict. */
#pragma once
#include "solve/solve.h"

/* ---- energy.c */
/* The energy account of a dynamic stage. Its sums are those of this rank where nothing else is said. */
typedef struct {
  PetscReal *v_before;     /* (n_dof,) velocity before the step */
  PetscReal *f_before;     /* (n_dof,) resisting force with the contacts before a verification */
  PetscReal *f_ext_before; /* (n_dof,) loads of the step before */
  PetscReal *u_start;      /* [m, rad] (n_dof,) at the start of the stage; NULL: no condensed bodies */
  PetscReal *F_n, *F_s, *d_n, *d_s; /* F_n, F_s, u_n, u_s of Contacts at the step before */
  PetscReal *work;                  /* (n_contacts,) [J] of each contact since it was found */
  PetscInt n_contacts;              /* padded */
  PetscReal work_before;            /* [J] of contacts that are no more, and of their exchange */
  PetscReal kinetic, strain, outside, supports, damping, damping_ahead,
      detection;                           /* [J] as in Energies; damping_ahead: of the half step beyond this
                                              time; detection: of all ranks */
  PetscReal lost;                          /* [J] the part of strain that is lost for good */
  PetscReal local[COUPLED_WORKS];          /* [J] of added mass and dashpots, see motion.h */
  PetscReal handed;                        /* [J] kinetic energy that changes of the step have made */
  PetscReal kinetic_0, strain_0, joints_0; /* [J] at the start, of all ranks */
  PetscReal prestress_0;                   /* [J] of strain_0, in tendons */
  PetscReal given[2]; /* [J] the most of strain_0 and of joints_0 that was gone at a look, of all ranks */
} EnergyAccount;
PetscErrorCode EnergyCreate(const Model *model, EnergyAccount *e);
PetscErrorCode EnergyDestroy(EnergyAccount *e);
/* Collective, see archive.h. The contacts must have been read back before. */
PetscErrorCode EnergyArchive(struct _p_Archive *archive, const Model *model, const Contacts *contacts,
                             EnergyAccount *e);
/* Adds the works of contacts over the step that led to the forces just evaluated. */
void EnergyOfContacts(const Model *model, const Contacts *contacts, EnergyAccount *e);
/* Adds half a step's work of the change of forces since f_before. Call it when contacts were found anew. */
void EnergyOfExchange(const Model *model, const State *state, EnergyAccount *e);
/* Adds the works of loads and supports over the step before, and sets kinetic energy and damping of this
   time. */
void EnergyOfStep(const StepWorks *works, EnergyAccount *e);
/* Where the step changes: makes of the accounts before and after the old step was booked (`closed`), and
   of e, in which the new step about the same time is booked too, one to which the new step has yet to be
   added. */
void EnergyHandOver(const EnergyAccount *before, const EnergyAccount *closed, EnergyAccount *e);
/* Starts the works of contacts afresh. Call it when the contacts are new, with forces evaluated. */
PetscErrorCode EnergyContactsChanged(const Contacts *contacts, EnergyAccount *e);
/* Sets the strain energy: what blocks, and what else acts on bodies, store or have lost on this rank at the
   forces just evaluated. Call it before the step, when a report follows. */
PetscErrorCode EnergyOfBlocks(const Problem *p, EnergyAccount *e);
/* Gives the energy [J] that joints store on this rank at the forces just evaluated. */
PetscErrorCode EnergyOfJoints(const Problem *p, PetscReal *stored);
/* Collective. Reports the account at the time of the forces last evaluated. first: at the start of the
   stage. */
PetscErrorCode EnergyReport(const Problem *p, EnergyAccount *e, PetscBool first, Energies *out);

/* Collective. The verdict of a stage in time that ran for its duration: completed, or diverged where too
   much of the energy came from nothing. */
PetscErrorCode EnergyJudge(const Problem *p);

/* ---- search_energy.c */
/* What a search for contacts makes of energy. */
typedef struct {
  PetscReal stored[2]; /* [J] in joints, before and after */
  PetscReal *sum;      /* of each macroblock, see search_energy.c */
} SearchEnergy;
/* Collective. Before and after a search, forces evaluated. Adds what it made to `detection`; the stage has
   diverged where contacts of a body begin with more energy than it and the bodies that it meets have. */
PetscErrorCode SearchEnergyBegin(const Problem *p, SearchEnergy *made);
PetscErrorCode SearchEnergyEnd(const Problem *p, SearchEnergy *made, PetscReal *detection);

/* ---- motion_warnings.c */
/* Collective. Warns on rank 0 of what makes the answer of the stage in time that begins doubtful: stress
   models without a potential, joints that nothing damps, ground that moves while the blocks rest. */
PetscErrorCode MotionWarnings(const Problem *p);

/* ---- velocities.c */
/* Moves velocities by half a step of the present forces: -1 back to t - dt/2 at the start of a stage, +1
   forward to t at its end. local: see motion.h; ground: [m/s] what alpha damps against. */
PetscErrorCode VelocitiesHalfStep(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                  PetscReal sign, EnergyAccount *e);
/* Books the step about the present time, by forces just evaluated, and makes it not. last: no other step will
   book it again. behind: (n_dof,) the velocities behind it; NULL: not asked for. */
PetscErrorCode VelocitiesAccount(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                 PetscBool last, PetscReal *behind, EnergyAccount *e);
/* Goes over to the step dt, when forces are evaluated and the step is not made yet. Not for condensed bodies
   and columns of free ground, whose velocities are their own. */
PetscErrorCode VelocitiesChange(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                PetscReal dt, EnergyAccount *e);

/* ---- step_control.c */
enum { STEP_LEVELS = 5 }; /* dt_factor: auto: steps are the longest over 1, 2, 4, 8, 16 */
/* The step of a stage in time. Time is counted in the shortest steps: a step begins at a multiple of
   itself, so all multiples of the longest, and the end of the stage, are met. */
typedef struct {
  PetscInt rungs;         /* of the ladder; 1: the step is constant */
  PetscInt rung, next;    /* of the state's step; of the step to come */
  PetscInt wanted;        /* what the last look at contacts asks for */
  PetscInt64 total, done; /* shortest steps in the stage; of them those over which it has come */
  PetscInt64 stayed;      /* steps since the rung changed */
  PetscInt64 changes;     /* of the rung so far */
  PetscReal longest;      /* [s] step of rung 0 */
  PetscReal before[2];    /* [s] the steps before that of the state */
  PetscReal fastest;      /* [m/s] at which contacts have moved so far */
  PetscReal *mass;        /* [kg] (n_bodies_global,) of free bodies, others infinite; NULL: not known yet */
  PetscInt64 *table;      /* (n_bodies_global, ..) of a look, impact_step.c */
  PetscInt64 *met;        /* (n_bodies_global,) when a body met another on a dashpot, in shortest steps */
  PetscBool swings;       /* some body has met another, and still swings on a dashpot */
} StepControl;
/* Shortest steps in a step of the rung. */
static inline PetscInt64 StepControlTicks(const StepControl *pace, PetscInt rung)
{
  return (PetscInt64)1 << (pace->rungs - 1 - rung);
}
/* Collective. The part of the stability bound that a dynamic stage takes at most, by dt_factor; how many
   rungs are below it. */
PetscErrorCode StepControlFactor(const Problem *p, PetscReal *factor, PetscInt *rungs);
/* Begins with steps of at most dt, and sets that of the state: the shortest one. */
PetscErrorCode StepControlBegin(const Problem *p, PetscReal dt, PetscInt rungs, StepControl *pace);
/* Collective, in a step whose forces have just been evaluated, before the account has taken the contacts:
   checks at these where it is time to. */
PetscErrorCode StepControlCheck(const Problem *p, const EnergyAccount *e, StepControl *pace);
/* In words: what makes the step of the stage shorter. */
const char *StepControlRemedy(const Stage *stage);
/* A step has been made: sets the rung of the next. */
void StepControlAdvance(const Problem *p, StepControl *pace);
PetscErrorCode StepControlArchive(Archive *archive, const Problem *p, StepControl *pace);
/* Collective. Says how many steps a dynamic stage makes, what set them, and what its damping is; warns of
   joints with which no step is right. */
PetscErrorCode StepControlDescribe(const Problem *p, const TimeStep *step, const StepControl *pace);

/* Collective. Says how often the step has changed, where it may. */
PetscErrorCode StepControlReport(const Problem *p, const StepControl *pace);

/* ---- impact_step.c */
PetscErrorCode ImpactStepCreate(const Model *model, StepControl *pace);
PetscErrorCode ImpactStepDestroy(StepControl *pace);
/* Collective. Sets pace->wanted by the contacts that will open or close. e: the account of the step
   before. */
PetscErrorCode ImpactStepCheck(const Problem *p, const EnergyAccount *e, StepControl *pace);

/* ---- dynamic.c */
/* Collective. Runs a dynamic stage for its duration. */
PetscErrorCode DynamicRun(const Problem *p);

/* ---- modes.c */
/* Collective. Finds the modes of the state as it is, and changes nothing of it. */
PetscErrorCode ModesRun(const Problem *p);

/* ---- stages.c */
/* Collective. Runs a stage of any kind to its verdict, and reports the verdict. */
PetscErrorCode StageRun(const Problem *p);

/* ---- snapshot.c */
/* What a trial starts from: displacements, loads and, kept by the terms, histories. */
typedef struct {
  PetscReal *u, *u_verified, *f_ext, *share;
  PetscReal alpha, q_ray, contact_depth;
} Snapshot;
PetscErrorCode SnapshotCreate(const Problem *p, Snapshot *snapshot);
PetscErrorCode SnapshotDestroy(Snapshot *snapshot);
/* Collective. Keeps the state as it is; goes back to it. */
PetscErrorCode SnapshotTake(const Problem *p, Snapshot *snapshot);
PetscErrorCode SnapshotRestore(const Problem *p, const Snapshot *snapshot);
/* Collective. All of it but alpha and q_ray, see archive.h. */
PetscErrorCode SnapshotArchive(Archive *archive, const Problem *p, Snapshot *snapshot);

/* ---- lifts.c */
/* Collective. After ModelCreate and BlocksCreate: what is there in the first stage. Refuses groups that
   hang in the air, and what lifts cannot be together with. */
PetscErrorCode LiftsCreate(const Scene *scene, Model *model);
PetscErrorCode LiftsDestroy(Model *model);
/* Collective. At the start of a stage, unless a checkpoint has brought it back: places its groups, and
   resets the displacements that are written. */
PetscErrorCode LiftsPlace(const Problem *p);
/* Collective, see archive.h. */
PetscErrorCode LiftsArchive(Archive *archive, const Scene *scene, Model *model, State *state);

/* ---- static.c */
/* Collective. Relaxes a static stage, or one trial of another stage, under its loads and joints. The caller
   reports the verdict. */
PetscErrorCode StageRelax(const Problem *p);

/* ---- trial_stage.c */
/* Collective. Run a strength reduction; a flood or a load factor; a search for the force of anchors. A
   strength reduction leaves in p->stage->joints the strengths of the last stable trial. */
PetscErrorCode ReductionRun(const Problem *p);
PetscErrorCode RaiseRun(const Problem *p);
PetscErrorCode AnchorForceRun(const Problem *p);

/* ---- transient.c */
/* Collective. Runs equilibria while water in joints flows in time. */
PetscErrorCode TransientRun(const Problem *p);

/* ---- repartition.c */
/* What it takes to deal a run with variable connectivity out to the ranks anew when blocks have moved. */
typedef struct _p_Repartition {
  PetscBool possible; /* more than one rank, a static or dynamic stage with variable connectivity, no
                         condensed bodies */
  PetscBool keeps;    /* keeps the mesh: for that, or because a stage goes back to an earlier end */
  const Scene *scene;
  const Model *model;
  const State *state;
  const Contacts *contacts;
  BlockMesh mesh;                         /* as it was read; rank 0 has blocks and part */
  BodyNumbers bodies;                     /* rank 0 */
  PetscErrorCode (*renew)(void *context); /* builds the model and all that depends on it from mesh */
  void *context;
  PetscInt64 looked; /* cycle at which a new partition was last tried */
} Repartition;
/* Collective. Takes over the mesh when the run may build its model anew; *mesh is empty then. */
PetscErrorCode RepartitionCreate(const Scene *scene, const Model *model, BlockMesh *mesh,
                                 Repartition *repartition);
PetscErrorCode RepartitionDestroy(Repartition *repartition);
/* Collective. Tries a partition for where the blocks are now, when scene->repartition_every cycles have
   passed since the last try. If it leaves the busiest rank less to do by more than scene->repartition_gain,
   the run goes on with it, with the same bits. Call it between two cycles, where checkpoints may be written.
   What stages allocate by the size of the model must be attached to the checkpoint. */
PetscErrorCode RepartitionPoll(const Problem *p);

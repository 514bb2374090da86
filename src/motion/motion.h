/* motion.h: declares one cycle (forces, damping, motion), masses and the time step. */
#pragma once
#include "forces/forces.h"
#include <petscpc.h>

struct _p_Relaxation;
struct _p_Output;

/* ---- state_checksum.c */
/* Collective. Sums a hash of (number, bits of the state) over owned vertices, bodies and contacts. The sum is
   the same on any number of ranks when every bit of the state is. */
PetscErrorCode StateChecksum(const Model *model, const State *state, const Contacts *contacts,
                             uint64_t *checksum);
/* Does the same as StateChecksum without the inside of condensed bodies, which follows from the rest and
   from the loads. */
PetscErrorCode StateChecksumKept(const Model *model, const State *state, const Contacts *contacts,
                                 uint64_t *checksum);
/* Collective. Returns the part that both checksums above lack, to be added to them: a hash of all data of a
   checkpoint about anchors, water, histories of materials, temperature, and the ground beside and below; 0:
   there are no such data. */
PetscErrorCode StateChecksumTerms(const Scene *scene, const Model *model, const State *state,
                                  Contacts *contacts, uint64_t *checksum);

/* ---- masses.c */
/* Writes the scaled masses (33)-(34) for dt = 1. With these masses the largest frequency of blocks and
   closed elastic joints, times dt, is at most 2 safety. */
PetscErrorCode ScaledMasses(const Scene *scene, const Model *model, const Joint *joints, Contacts *contacts,
                            State *state);
/* The step of a stage in time and its limits. */
enum { STEP_WORDS = 160 };
#define DAMPED_FACTOR                                                                                        \
  0.9 /* part of the bound with dampers, used where a smaller part of the bound without
                             dampers is enough */
typedef struct {
  PetscReal dt;           /* [s] factor times the limit, or less for dampers */
  PetscReal limit;        /* [s] the largest step that is stable without dampers; the duration if there is no
                             limit */
  PetscReal damped;       /* [s] the same with dampers, of the degrees of freedom that have some */
  PetscReal mesh;         /* [s] step of the same blocks without condensing; 0: not known */
  PetscReal work;         /* [-] time of a step of condensed bodies over the time of a step of their blocks */
  char words[STEP_WORDS]; /* place and cause of the least of these limits */
} TimeStep;
/* Collective. Writes the true masses into state->m, and finds the stable step for them, with contacts
   wherever they may come. Where contacts stay and dt_factor is auto, only present contacts count. Refuses
   free degrees of freedom without mass. */
PetscErrorCode DynamicTimeStep(const Scene *scene, const Model *model, const Stage *stage, Contacts *contacts,
                               PetscReal factor, State *state, TimeStep *step);

/* ---- integrate.c */
typedef struct {
  PetscReal num[2], den[2];   /* binned sums of v.(f - f_old) and v.m v over the dofs in the quotient */
  PetscReal num_max, den_max; /* largest terms: bounds for the bins of the next cycle */
} QuotientSums;
/* The largest terms of a cycle may be this many times the terms of the cycle before; the bins still hold
   them. */
#define SUMS_GROWTH 1048576.
/* Adds the sums of two groups of ranks. `lower` comes from the lower ranks on every rank, so that all ranks
   get the same result even where a number is not finite. */
static inline QuotientSums QuotientSumsOf(const QuotientSums *lower, const QuotientSums *higher)
{
  return (QuotientSums){{lower->num[0] + higher->num[0], lower->num[1] + higher->num[1]},
                        {lower->den[0] + higher->den[0], lower->den[1] + higher->den[1]},
                        PetscMax(lower->num_max, higher->num_max),
                        PetscMax(lower->den_max, higher->den_max)};
}
/* Returns the arrays that IntegrateRange reads from `from` on, besides u and f. */
Ahead IntegrateAhead(const State *state, PetscInt from);
/* Makes one central-difference step (11)-(20) of the degrees of freedom `from` to `to` - 1, and adds their
   terms of the Rayleigh quotient to sums. last: sums of the last cycle, whose largest terms place the
   bins. */
void IntegrateRange(const Model *model, State *state, const QuotientSums *last, PetscInt from, PetscInt to,
                    QuotientSums *sums);

/* ---- stiffness_mass.c */
/* A mass that is proportional to the elastic stiffness K0: M = scale K0 (stiffness_mass.c). The matrix and
   its factor belong to the method of the stage. */
typedef struct _p_StiffnessMass {
  PetscReal scale;   /* [1/s2] M over K0, by the bound of the step; masses.c */
  Mat stiffness;     /* [N/m] K0 */
  PC factor;         /* factor of K0 */
  Vec impulse;       /* [N] (n_dof,) K0 v: momentum over scale */
  Vec from, product; /* (n_dof,) work arrays */
} StiffnessMass;
/* Starts cycles with the mass scale K0, from rest; ScaledMasses sets scale. stiffness, factor: K0 and its
   factor, which must stay until StiffnessMassEnd. */
PetscErrorCode StiffnessMassBegin(Mat stiffness, PC factor, State *state);
PetscErrorCode StiffnessMassEnd(State *state);
/* Collective. Sets the momentum that belongs to the present velocities. */
PetscErrorCode StiffnessMassKeepVelocity(const Model *model, State *state);
/* Collective. Does the same as IntegrateRange, for all degrees of freedom. */
PetscErrorCode StiffnessMassMove(const Model *model, State *state, const QuotientSums *last,
                                 QuotientSums *sums);
/* Collective. Computes the product of the mass and x (n_dof,) into y (n_dof,), another array. */
PetscErrorCode MassProduct(const Model *model, const State *state, const PetscReal *x, PetscReal *y);
/* Stops all motion. */
PetscErrorCode MotionStop(const Model *model, State *state);

/* ---- time_step.c */
/* Works of a step in time on this rank [J]. */
typedef struct {
  PetscReal outside, supports; /* over the step before this time: of loads; of supports on the degrees of
                                  freedom they hold */
  PetscReal kinetic;           /* at this time: m v- v+ / 2 */
  PetscReal damping;           /* lost to alpha in the step about this time */
  PetscReal damping_ahead;     /* part of damping in the half step after this time */
} StepWorks;
/* Makes one central-difference step of all degrees of freedom of this rank. alpha damps against the velocity
   ground [m/s] (2,). Writes the velocities before the step into v_before, and the loads into f_ext_before,
   which contains the loads of the last step; both (n_dof,). Sets the first line of works. */
void MoveInTime(const Model *model, State *state, const PetscReal ground[2], PetscReal *v_before,
                PetscReal *f_ext_before, StepWorks *works);
/* Sets the other works, when supports and coupled inertia have moved too. */
void WorksInTime(const Model *model, const State *state, const PetscReal ground[2], PetscReal *v_before,
                 StepWorks *works);

/* ---- coupled_inertia.c */
typedef struct _p_CoupledInertia CoupledInertia;
/* Works and energies of this rank [J]. Those named ahead cover the half step after the present time. */
enum {
  COUPLED_KINETIC,  /* of added mass, at the present time */
  COUPLED_INCOMING, /* energy that waves have brought in */
  COUPLED_DASHPOTS, /* work of dashpots on the model */
  COUPLED_DASHPOTS_AHEAD,
  COUPLED_SUPPORTS, /* work of moving supports on added mass and on the inside of condensed bodies, and of
                       forces that act beside dashpots */
  COUPLED_SUPPORTS_AHEAD,
  COUPLED_INSIDE, /* kinetic energy inside condensed bodies, at the present time */
  COUPLED_STRAIN, /* strain energy of their modes */
  COUPLED_LOADS,  /* work of loads on their modes */
  COUPLED_DRAG,   /* energy lost to damping inside them */
  COUPLED_DRAG_AHEAD,
  /* of condensed bodies, summed over checks: */
  COUPLED_TRUNCATED,    /* energy [J] that the modes left out would store if they followed at once */
  COUPLED_STORED,       /* energy [J] that the bodies store by the motion since the start of the stage */
  COUPLED_ACCELERATION, /* accelerations of kept vertices, as energy stored, over the square of the first
                           frequency left out [J/s2] */
  COUPLED_VELOCITY,     /* velocities of kept vertices, as energy stored [J/s2] */
  COUPLED_WORKS
};
/* Collects the inertia that terms add to vertices and rigid bodies in the stage of the view. u_start:
   (n_dof,) displacements at its start, where condensed bodies move; NULL: no body is condensed. */
PetscErrorCode CoupledCreate(const TermView *view, const PetscReal *u_start, CoupledInertia **local);
PetscErrorCode CoupledDestroy(CoupledInertia **local);
/* Gives `take` the added mass of each point: its first degree of freedom; their number, 3 of a rigid body or
   2 of a vertex; the matrix between them. */
typedef PetscErrorCode (*CoupledTake)(PetscInt dof, PetscInt n, const PetscReal (*mass)[3], void *context);
PetscErrorCode CoupledMasses(const CoupledInertia *local, CoupledTake take, void *context);
/* Gives the points and condensed bodies the velocities and displacements of their own inertia, after
   MoveInTime and the supports have moved them. v_before: (n_dof,) velocities before the step; ground: [m/s]
   velocity against which alpha damps; part: 1, or 0 where the caller takes the step back, so that only the
   state changes. */
PetscErrorCode CoupledStep(CoupledInertia *local, State *state, const PetscReal *v_before,
                           const PetscReal ground[2], PetscReal part, PetscReal works[COUPLED_WORKS]);
/* Completes the works of a step, once after it, by the works that follow from velocities and are not summed
   step by step. */
void CoupledBodiesCentred(const CoupledInertia *local, const State *state, PetscReal works[COUPLED_WORKS]);
/* Adds to the sums over checks, after a step. start: (n_dof,) displacements at the start of the stage. */
void ModalTruncation(const CoupledInertia *local, const State *state, const PetscReal *start,
                     PetscReal works[COUPLED_WORKS]);
/* Moves their velocities from v_before by half a step of the present forces: sign -1 back, +1 forward. */
PetscErrorCode CoupledHalfStep(CoupledInertia *local, State *state, const PetscReal *v_before,
                               const PetscReal ground[2], PetscReal sign);

/* ---- fault.c */
/* Finds the first block of this rank where a force or displacement is not finite. Returns a number that
   orders such blocks, FAULT_NONE when there is none. In the cycle of the fault it finds the block where the
   fault arose. */
#define FAULT_NONE ((PetscInt64)1 << 62)
PetscInt64 FaultFind(const Model *model, const State *state);
/* Collective. Describes the first of the blocks that the ranks have found. */
PetscErrorCode FaultName(const Model *model, PetscInt64 found, char text[128]);

/* ---- damping_sums.c */
typedef struct _p_DampingSums DampingSums;
/* Collective. Creates the sums. */
PetscErrorCode DampingSumsCreate(const Model *model, DampingSums **sums);
PetscErrorCode DampingSumsDestroy(DampingSums **sums);
/* Collective. Sends the sums of this rank; DampingSumsEnd waits for the sums of all ranks. */
void DampingSumsBegin(const Model *model, DampingSums *sums, const QuotientSums *mine);
PetscErrorCode DampingSumsEnd(const Model *model, DampingSums *sums, QuotientSums *all);

/* ---- damping.c */
/* The damping of static stages, and its memory. */
typedef struct _p_Damping {
  QuotientSums sums;              /* of the last cycle, over all ranks */
  DampingSums *over_ranks;        /* the reduction of a cycle */
  PetscReal q_ray;                /* [1/s2] last positive Rayleigh quotient (37) */
  PetscReal *u_secant, *f_secant; /* (n_dof,) displacement and resisting force that the secant starts from */
  PetscReal q_secant;             /* [1/s2] Rayleigh quotient of the motion since then, 0: none */
  PetscBool tangent_only;         /* the secant damped too little in this stage */
  PetscReal best_ratio;           /* [-] least unbalanced ratio of the stage that counted as progress */
  PetscInt64 best_cycle;          /* the cycle that had best_ratio */
  PetscBool fault;                /* a sum over forces and velocities of this cycle is not a number */
} Damping;
PetscErrorCode DampingCreate(const Model *model, Damping *damping);
PetscErrorCode DampingDestroy(Damping *damping);
/* Starts the secant from the present state. */
PetscErrorCode DampingStart(const Model *model, const State *state, Damping *damping);
/* Collective. Finds the secant quotient at this cycle. ratio: the unbalanced ratio. springs: slip is kept
   from each evaluation, so friction feeds no oscillation. */
PetscErrorCode Secant(const Model *model, const State *state, PetscReal ratio, PetscBool springs,
                      Damping *damping);
/* Collective. Sends the sums of this rank of the cycle just done; DampingEnd waits for the sums of all
   ranks, and finds alpha (35)-(38) from them. */
void DampingBegin(const Scene *scene, const Model *model, Damping *damping, const QuotientSums *local);
PetscErrorCode DampingEnd(const Scene *scene, const Model *model, State *state, Damping *damping);

/* ---- state_archive.c */
/* Collective. Rebuilds the faces and ghosts of the model for displacements u (n_dof,) of the dofs; the state
   keeps its own displacements. Local numbers of vertices in contacts are valid only with the ghosts of the
   state in which the contacts were found. */
PetscErrorCode NeighboursAt(Model *model, State *state, const PetscReal *u);
/* Collective. Writes or reads the state of a run: State, Contacts, and the parts of Model that follow the
   motion. */
PetscErrorCode StateArchive(Archive *archive, const Scene *scene, Model *model, State *state,
                            Contacts *contacts);

/* ---- cycle.c */
/* Collective. Exchanges the ghosts, then finds the resisting forces of all terms at the
   present displacements. Always writes the arrays of contacts for the last evaluation. contact_scale: as in
   Step. */
PetscErrorCode Forces(const Scene *scene, const Model *model, const Joint *joints, Contacts *contacts,
                      State *state, PetscReal *contact_scale);
/* Collective. Makes one cycle. Ghosts must have the displacements of their owners before it, and have them
   after it. contact_scale: NULL, or (n_dof,) receives |contact force| per dof; the arrays of contacts for the
   last evaluation are then written too. */
PetscErrorCode Step(const Scene *scene, const Model *model, const Joint *joints, Contacts *contacts,
                    State *state, Damping *damping, PetscReal *contact_scale);

/* A running stage: the data that its functions share. A Problem owns nothing. Its maker starts a stage:
   quoin.c for a stage of the scene, trial_stage.c for a trial, attempt.c for an attempt. The pointers stay
   the same while the stage runs; the objects change. */
typedef struct {
  /* of the run: the same in all stages; on a new partition the objects are rebuilt in place */
  Model *m;
  Contacts *contacts;
  State *state;
  struct _p_Relaxation *relax; /* static stages and trials only */
  struct _p_Result *found;     /* results of the stage besides `result`: trials, bodies, histories */
  struct _p_Output *output;    /* the writers */
  Checkpoint *checkpoint;
  /* of the stage */
  const Scene *scene;  /* scene of the run; a trial of a flood has a copy with its own levels of water */
  const Stage *stage;  /* the row of the scene, or a copy; a trial has joints and a ramp of its own */
  PetscInt number;     /* the number of that row in scene->stages */
  StageResult *result; /* the result so far, from zero at the start of the stage or trial */
} Problem;

/* Returns the view of a running stage for force terms. */
static inline TermView ViewOf(const Problem *p)
{
  return (TermView){
      .scene = p->scene, .stage = p->stage, .m = p->m, .contacts = p->contacts, .state = p->state};
}
/* Returns the present instant. */
static inline Instant InstantOf(const Problem *p)
{
  return (Instant){.scene = p->scene,
                   .m = p->m,
                   .joints = p->stage->joints,
                   .contacts = p->contacts,
                   .u = p->state->u + 3 * p->m->rigid.n};
}

/* motion.h: one cycle: forces, damping, motion; masses and time step. */
#pragma once
#include "forces/forces.h"

struct _p_Relaxation;
struct _p_Output;

/* ---- state_checksum.c */
/* Collective. Sum over owned vertices, bodies and contacts of a hash of (number, bits of the state): the same
   on any number of ranks when every bit is. */
PetscErrorCode StateChecksum(const Model *model, const State *state, const Contacts *contacts,
                             uint64_t *checksum);

/* ---- masses.c */
/* Scaled masses (33)-(34) for dt = 1: the largest frequency of blocks and closed elastic joints
   times dt is 2 safety. */
PetscErrorCode ScaledMasses(const Scene *scene, const Model *model, const Joint *joints,
                            const Contacts *contacts, State *state);
/* Collective. True masses into state->m, and the largest stable step [s] for them, with contacts wherever
   they may come. Refuses free degrees of freedom without mass. */
PetscErrorCode DynamicTimeStep(const Scene *scene, const Model *model, const Stage *stage, State *state,
                               PetscReal *limit);

/* ---- integrate.c */
typedef struct {
  PetscReal num[2], den[2];   /* binned sums of v.(f - f_old) and v.m v, over the dofs in the quotient */
  PetscReal num_max, den_max; /* largest terms: bounds for the bins of the next cycle */
} QuotientSums;
/* So many times larger than the largest terms of the last cycle may those of the next one be: the bins still
   hold them. */
#define SUMS_GROWTH 1048576.
/* What two ranks, or more, have together; `lower` comes from the lower ranks, so that all get the same even
   where something is not a number. */
static inline QuotientSums QuotientSumsOf(const QuotientSums *lower, const QuotientSums *higher)
{
  return (QuotientSums){{lower->num[0] + higher->num[0], lower->num[1] + higher->num[1]},
                        {lower->den[0] + higher->den[0], lower->den[1] + higher->den[1]},
                        PetscMax(lower->num_max, higher->num_max),
                        PetscMax(lower->den_max, higher->den_max)};
}
/* One central-difference step (11)-(20) of all dofs of this rank; sums of the
   Rayleigh quotient on the way. */
void Integrate(const Model *model, State *state, const QuotientSums *last, QuotientSums *sums);
/* What IntegrateRange reads there, less u and f. */
Ahead IntegrateAhead(const State *state, PetscInt from);
/* The same for the degrees of freedom `from` to `to` - 1; their terms are added to sums. */
void IntegrateRange(const Model *model, State *state, const QuotientSums *last, PetscInt from, PetscInt to,
                    QuotientSums *sums);

/* ---- fault.c */
/* Of this rank: the block where a force or displacement is not finite, as a number that orders them; a large
   one: none. Right at the cycle when it has happened, it is the block where it arose. */
#define FAULT_NONE ((PetscInt64)1 << 62)
PetscInt64 FaultFind(const Model *model, const State *state);
/* Collective. In words, the first of what the ranks have found. */
PetscErrorCode FaultName(const Model *model, PetscInt64 found, char text[128]);

/* ---- sums.c */
typedef struct _p_Sums Sums;
/* Collective. */
PetscErrorCode SumsCreate(const Model *model, Sums **sums);
PetscErrorCode SumsDestroy(Sums **sums);
/* Tells what this rank has. Collective: waits for what all have together. */
void SumsBegin(const Model *model, Sums *sums, const QuotientSums *mine);
PetscErrorCode SumsEnd(const Model *model, Sums *sums, QuotientSums *all);

/* ---- damping.c */
/* The damping of static stages, and its memory. */
typedef struct _p_Damping {
  QuotientSums sums;              /* of the last cycle, over all ranks */
  Sums *over_ranks;               /* the reduction of a cycle */
  PetscReal q_ray;                /* [1/s2] last positive Rayleigh quotient (37) */
  PetscReal *u_secant, *f_secant; /* (n_dof,) displacement and resisting force that the secant starts from */
  PetscReal q_secant;             /* [1/s2] Rayleigh quotient of the motion since then, 0: none */
  PetscBool tangent_only;         /* the secant damped too little in this stage */
  PetscReal best_ratio;           /* [-] least unbalanced ratio of the stage that counted as progress */
  PetscInt64 best_cycle;          /* and its cycle */
  PetscBool fault;                /* a sum over forces and velocities of this cycle is not a number */
} Damping;
PetscErrorCode DampingCreate(const Model *model, Damping *damping);
PetscErrorCode DampingDestroy(Damping *damping);
/* The secant starts from here. */
PetscErrorCode DampingStart(const Model *model, const State *state, Damping *damping);
/* Collective. The secant quotient at this cycle. springs: slip is kept as it comes, and feeds no
   oscillation. */
PetscErrorCode Secant(const Model *model, const State *state, PetscReal ratio, PetscBool springs,
                      Damping *damping);
/* Collective. alpha from (35)-(38), division-free, from the sums of the cycle just done: Begin tells those of
   this rank, End waits for those of the others. */
void DampingBegin(const Scene *scene, const Model *model, Damping *damping, const QuotientSums *local);
PetscErrorCode DampingEnd(const Scene *scene, const Model *model, State *state, Damping *damping);

/* ---- state_archive.c */
/* Collective. Faces and ghosts of model as they are where the dofs have displacements u (n_dof,); the state
   keeps its own. Local numbers of vertices in contacts hold where the contacts were found. */
PetscErrorCode NeighboursAt(Model *model, State *state, const PetscReal *u);
/* The state of a run: State, Contacts, and what of Model follows the motion. */
PetscErrorCode StateArchive(Archive *archive, const Scene *scene, Model *model, State *state,
                            Contacts *contacts);

/* ---- cycle.c */
/* Collective. Ghost exchange, then the resisting forces of all contacts and blocks at the
   present displacements. */
PetscErrorCode Forces(const Model *model, const Joint *joints, Contacts *contacts, State *state,
                      PetscReal *contact_scale);
/* Collective. One cycle, from displacements that ghosts have too, to displacements that ghosts have too.
   contact_scale: NULL, or (n_dof,) receives |contact force| per dof; then the
   contacts' arrays of the last evaluation are written too. */
PetscErrorCode Step(const Scene *scene, const Model *model, const Joint *joints, Contacts *contacts,
                    State *state, Damping *damping, PetscReal *contact_scale);

/* A stage that runs, and all that its functions hand on to each other; owns nothing. Who starts a stage puts
   it together: quoin.c a stage of the scene, trial_stage.c a trial, attempt.c what it tries. None of the
   pointers changes while the stage runs; what they point to does. */
typedef struct {
  /* of the run: the same in all its stages; on a new partition they are built anew in their places */
  Model *m;
  Contacts *contacts;
  State *state;
  struct _p_Relaxation *relax; /* static stages and trials only */
  struct _p_Output *output;    /* has the checkpoint too */
  /* of the stage */
  const Scene *scene;  /* that of the run; a trial of a flood has one with levels of water of its own */
  const Stage *stage;  /* its row, or a copy; a trial has joints and a ramp of its own */
  PetscInt number;     /* of that row in scene->stages */
  StageResult *result; /* so far, from zero at the start of the stage or trial */
} Problem;

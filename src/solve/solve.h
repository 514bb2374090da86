/* solve.h: equilibrium: how it is found, and what a stage is told to have come to. */
#pragma once
#include "output/output.h"

/* ---- judge.c */
typedef struct _p_Newton Newton;
/* What a verdict rests on: the motion, chunk of cycles by chunk. */
typedef struct {
  PetscReal *u_0;    /* (n_dof,) displacement at the start of the stage */
  PetscReal longest; /* [m] contact of the stage: how far is far */
  PetscReal *u_chunk,
      *du_chunk;      /* (n_dof,) displacement at the start of the chunk, increment of the one before */
  PetscReal *r_chunk; /* (n_dof,) [N, N m] unbalanced force at the start of the chunk */
  PetscReal *ratios;  /* (max_ratios,) unbalanced ratios seen in this chunk */
  PetscInt n_ratios, max_ratios, steady; /* steady: chunks in a row that moved on in one direction */
  PetscReal median[4], rate[4];          /* of the last chunks, the last first: ratio [-], motion [m/cycle] */
  PetscReal ahead[3];                    /* [m] and how far ahead of them nothing drove the motion */
  PetscInt64 chunk_start, chunk_length;
  PetscReal alpha_sum; /* since the start of the first chunk, over n_alpha checks */
  PetscInt n_alpha;
  PetscReal
      settled_alpha; /* mean damping of the last stage or trial that converged, for beta = 0; 0: none has */
  PetscBool still;   /* Judge asks for RelaxationStill */
} Evidence;
/* How friction follows its law on the way, see follow.c. */
typedef struct {
  PetscReal half_ratio;  /* [-] the ratio has halved, and halved again, down to this, or has stalled there */
  PetscInt64 half_cycle; /* and that cycle */
  PetscInt stalls;       /* how often it has not halved for long (FollowElse) */
} Following;
/* What the kinetic energy is held against, see guard.c. */
typedef struct {
  PetscReal *u, *f;     /* (n_dof,) displacement and resisting force when it was opened */
  PetscReal start;      /* [J] kinetic energy then */
  PetscReal most;       /* [J] and the largest since that it accounts for */
  PetscReal ramp;       /* [J] what the ramp may have added to the work of the loads at its end */
  PetscInt made_energy; /* times that it was more, in this stage */
} GuardAccount;
/* What the static stages of a run remember. */
typedef struct _p_Relaxation {
  Damping damping;
  Evidence evidence;
  Following follow;
  GuardAccount account;
  Newton *newton;          /* factor and work arrays of newton.c, NULL: not used so far */
  PetscReal reached, step; /* Newton's method: part of the loads at the last equilibrium, the next part; step
                              0: not at work */
  Effort effort;           /* of the stage so far */
  PetscReal most_work;     /* [solves] of the stage by Newton's method, EffortWork; 0: no limit */
  Effort spent;            /* when that limit ended it; no evaluations: it has not */
  PetscBool told;          /* the stage has been warned of slip that is that of the path */
} Relaxation;
PetscErrorCode RelaxationCreate(const Scene *scene, const Model *model, Relaxation *r);
PetscErrorCode RelaxationDestroy(Relaxation *r);
/* Collective, see archive.h: all that the damping and the verdicts remember. */
PetscErrorCode RelaxationArchive(struct _p_Archive *archive, const Model *model, Relaxation *r);
/* Start of a stage: forgets the evidence. */
PetscErrorCode RelaxationReset(const Problem *p);
/* Collective. The start of a stage, forces evaluated: damping, evidence and guard count from here. */
PetscErrorCode RelaxationStart(const Model *model, const Contacts *contacts, const State *state,
                               Relaxation *r);
/* After a check: friction on the way follows the law closely or from afar, the other where the ratio stalls.
   */
enum { CHUNK_MIN = 500, STALLS_TO_LET_GO = 4 };
/* Much more stiffness-proportional damping for the rest of the stage, with masses to go with it. */
PetscErrorCode RelaxationStill(const Problem *p);
/* Collective. The verdict after a check, VERDICT_NONE: go on. */
PetscErrorCode Judge(const Problem *p);

/* ---- follow.c */
static const PetscReal FOLLOW_CLOSELY = 0.5; /* pull at the start of a stage; see the head of follow.c */
void FollowElse(const Model *model, const State *state, PetscReal ratio, Relaxation *r, Contacts *contacts);

/* ---- balance.c */
/* Collective. contact_scale: (n_dof,) |force of contacts| per dof at this cycle. Sets
   ratio, increment, kinetic. */
PetscErrorCode Unbalanced(const Model *model, const State *state, const PetscReal *contact_scale,
                          StageResult *result);

/* ---- parting.c */
/* Of a face: parted or slid so far, a contact that was kept means nothing. */
#define OUTGROWN 0.1
/* At the start of a stage of fixed connectivity, forces evaluated: partings and slidings count from here.
   Nothing in a stage of variable connectivity, nor where they count from a stage before. */
void PartingStart(const Problem *p);
/* At an equilibrium, or between cycles: contacts across a gap that bear by now count from here. */
void PartingOfBearing(Contacts *contacts);
/* Collective. Farthest that two faces in contact have parted or slid, over the length of the
   contact (of the shorter face, where they are staggered), and where [m]. */
PetscErrorCode ContactsParted(const Problem *p, PetscReal *fraction, PetscReal place[2]);
/* Collective. Largest part [-] of its length that a contact has parted or slid farther by since the last
   call; -1: no joint can fail. */
PetscErrorCode PartingOfChunk(const Problem *p, PetscReal *gain);
/* Collective. Fixed connectivity: a mechanism that has carried faces out of their contacts is a collapse,
   before it finds an equilibrium of contacts that are no more. */
PetscErrorCode JudgeContacts(const Problem *p);
/* Collective. Variable connectivity, after contacts were found again: a body that nothing holds any more and
   that falls is a collapse, unless bodies may float. */
PetscErrorCode JudgeLoose(const Problem *p);
/* Collective. Warns when blocks have moved too far for contacts that were kept as they were at the start. */
PetscErrorCode FixedOutgrown(const Problem *p);

/* ---- carried.c */
#define CARRIED 1e-3 /* allowed at an equilibrium: own loads are no better known */
/* Collective. Forces evaluated: whether bodies, and parts of bodies that stick to each other, are held
   against their own loads, but for a part `allowed` of these. */
PetscErrorCode LoadsCarried(const Problem *p, PetscReal allowed, PetscBool *carried);
/* Collective. Forces evaluated: marks bodies (n_bodies_global,) without loads and supports that nothing
   drives, but can move without resistance; how many. */
PetscErrorCode FreeBodies(const Problem *p, PetscInt *free_body, PetscInt *n_free);
/* Collective. Of a stage that ended otherwise than converged: adds to its evidence what is not held, where
   the unbalanced ratio does not show it. */
PetscErrorCode LoadsCarriedSay(const Problem *p);

/* ---- confirm.c */
/* An equilibrium of friction that is still on its way to the law is none: takes the verdict back. Where it is
   one, contacts have afterwards what the law gives. */
PetscErrorCode ConfirmByLaw(const Problem *p, PetscReal *contact_scale);
/* Slip kept as it came may be that of the way loads were applied, and no residual shows it: warns. Forces are
   no longer those of the state. */
PetscErrorCode ConfirmPath(const Problem *p, PetscReal *contact_scale);
/* Forces evaluated: warns of a static stage that ends short of what its own loads do. */
PetscErrorCode ConfirmWay(const Problem *p);
/* Collective, with the displacements inside of condensed bodies. Warns where forces turn linear bodies less
   than they would where these have gone. */
PetscErrorCode ConfirmCondensed(const Problem *p);

/* ---- guard.c */
/* Forces evaluated: from here on the kinetic energy is held against what the loads do. */
PetscErrorCode EnergyAccountOpen(const Problem *p);
/* Collective. From here on the loads are constant. */
PetscErrorCode EnergyRampEnds(const Problem *p);
/* Collective. After Unbalanced: whether the kinetic energy is more than loads can have done and what is
   stored can have given. The first time, the stage begins anew with a shorter step and more damping
   (`anew`). */
PetscErrorCode EnergyGuard(const Problem *p, PetscBool *anew);
/* Collective. Where that did not help, blocks that fly apart have not collapsed: the stage has diverged. So
   it has where blocks moved against the loads by more than was stored. With stress models that make energy
   themselves the verdict stays, and this is told with it. */
PetscErrorCode EnergyVeto(const Problem *p);

/* ---- factor.c */
/* Collective. Whether there is memory for the factor of NewtonRelax. memory: [0] what it is foreseen to
   take, [1] what is available [byte], on all machines together. */
PetscErrorCode NewtonFits(const Model *model, double memory[2], PetscBool *fits);

/* ---- failing_motion.c */
/* Collective. The widest open contact [m] that closes when the degrees of freedom move on by du (n_dof,) so
   many times, 0: none does. */
PetscErrorCode MotionCloses(const Model *model, const State *state, const Contacts *contacts,
                            const PetscReal *du, PetscReal times, PetscReal *gap);
/* Collective. Takes the present motion as the mechanism of p->output->trials; from: not NULL: the way from
   these displacements (ModelApplied,) instead. */
PetscErrorCode MechanismTake(const Problem *p, const PetscReal *from);

/* ---- method.c */
/* Collective. How a static stage or a trial goes to its equilibrium: explicit, or preconditioned first. The
   same on any number of ranks. */
PetscErrorCode StageMethod(const Scene *scene, const Model *model, const Contacts *contacts,
                           const Stage *stage, MethodKind *method);

/* ---- newton.c */
/* Collective. Equilibrium of a static stage or trial with fixed connectivity by Newton's method with the
   factor of the elastic stiffness, under loads that go from f_start to f_target. Verdict: converged,
   collapsed (contacts outgrown), interrupted; or none, when no equilibrium was found, or there is no memory
   for the factor: then displacements, history and f_ext are those of the last one, and the explicit loop
   goes on. */
PetscErrorCode NewtonRelax(const Problem *p);
PetscErrorCode NewtonDestroy(Newton **newton);
/* Collective. Lowest frequency [1/cycle] of the scaled masses with the elastic joints that the factor belongs
   to, after NewtonRelax; 0: there is no factor. Overwrites the last correction. */
PetscErrorCode NewtonLowestFrequency(const Model *model, const State *state, const Newton *newton,
                                     PetscReal *omega);

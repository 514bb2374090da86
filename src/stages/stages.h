/* stages.h: prototypes between the files that run stages: damping and verdicts, Newton's method, motion in
   time, trials. The rest is in internal.h, whose conventions hold. */
#pragma once
#include "internal.h"

struct _p_Archive;

/* A stage that runs, and all that its functions hand on to each other; owns nothing. Who starts a stage puts
   it together: quoin.c a stage of the scene, reduction.c a trial, attempt.c what it tries. None of the
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

/* ---- sums.c: the sums of the damping, over all ranks */
typedef struct _p_Sums Sums;
/* Collective. */
PetscErrorCode SumsCreate(const Model *model, Sums **sums);
PetscErrorCode SumsDestroy(Sums **sums);
/* Tells what this rank has. Collective: waits for what all have together. */
void SumsBegin(const Model *model, Sums *sums, const QuotientSums *mine);
PetscErrorCode SumsEnd(const Model *model, Sums *sums, QuotientSums *all);

/* ---- relax.c */
typedef struct _p_Newton Newton;
typedef struct _p_Relaxation {
  QuotientSums sums; /* of the last cycle, over all ranks */
  PetscReal *u_0;    /* (n_dof,) displacement at the start of the stage */
  PetscReal *u_secant,
      *f_secant;          /* (n_dof,) displacement and resisting force there, or where slip was let go */
  PetscReal q_secant;     /* [1/s2] Rayleigh quotient of the motion since then, 0: none */
  PetscReal longest;      /* [m] contact of the stage: how far is far */
  PetscBool tangent_only; /* the secant damped too little in this stage */
  PetscReal best_ratio; /* [-] least unbalanced ratio of the stage that counted as progress, and its cycle */
  PetscInt64 best_cycle;
  PetscReal q_ray;  /* [1/s2] last positive Rayleigh quotient (37) */
  Sums *over_ranks; /* the reduction of a cycle */
  /* evidence for the verdict, per chunk of cycles */
  PetscReal *u_chunk,
      *du_chunk;      /* (n_dof,) displacement at the start of the chunk, increment of the chunk before */
  PetscReal *r_chunk; /* (n_dof,) [N, N m] unbalanced force at the start of the chunk */
  PetscReal *ratios;  /* unbalanced ratios seen in this chunk */
  PetscInt n_ratios, max_ratios, steady; /* steady: chunks in a row that moved on in one direction */
  PetscReal median[4], rate[4];          /* of the last chunks, the last first: ratio [-], motion [m/cycle] */
  PetscReal ahead[3];                    /* [m] and how far ahead of them nothing drove the motion */
  PetscInt64 chunk_start, chunk_length;
  PetscReal alpha_sum; /* since the start of the first chunk, over n_alpha checks */
  PetscInt n_alpha;
  Newton *newton;          /* factor and work arrays of newton.c, NULL: not used so far */
  Effort effort;           /* of the stage so far */
  PetscReal most_work;     /* [solves] of the stage by Newton's method, EffortWork; 0: no limit */
  Effort spent;            /* when that limit ended it; no evaluations: it has not */
  PetscReal reached, step; /* Newton's method: part of the loads at the last equilibrium, the next part; step
                              0: not at work */
  PetscReal
      settled_alpha; /* mean damping of the last stage or trial that converged, for beta = 0; 0: none has */
  struct {
    PetscReal *u, *f;    /* (n_dof,) displacement and resisting force when it was opened */
    PetscReal start;     /* [J] kinetic energy then */
    PetscReal most;      /* [J] and the largest since that it accounts for */
    PetscReal ramp;      /* [J] what the ramp may have added to the work of the loads at its end */
  } account;             /* of energy; guard.c */
  PetscReal half_ratio;  /* [-] the ratio has halved, and halved again, down to this, or has stalled there */
  PetscInt64 half_cycle; /* and that cycle */
  PetscInt stalls;       /* how often it has not halved for long (FollowElse) */
  PetscInt made_energy;  /* times that it was more, in this stage; guard.c */
  PetscBool told;        /* the stage has been warned of slip that is that of the path */
  PetscBool still;       /* Judge asks for RelaxationStill */
  PetscBool fault;       /* a sum over forces and velocities of this cycle is not a number */
} Relaxation;
/* Length [m] that turns a rotation dof into a displacement and a moment into a force: sqrt(I/m) of the scaled
   masses of its body; 1 for other dofs. */
PetscReal DofLength(const Model *model, const State *state, PetscInt d);
PetscErrorCode RelaxationCreate(const Scene *scene, const Model *model, Relaxation *r);
PetscErrorCode RelaxationDestroy(Relaxation *r);
/* Collective, see archive.h: all that the damping and the verdicts remember. */
PetscErrorCode RelaxationArchive(struct _p_Archive *archive, const Model *model, Relaxation *r);
/* Start of a stage: forgets the evidence. */
PetscErrorCode RelaxationReset(const Problem *p);
/* Collective. The start of a stage (forces evaluated), and the secant quotient at this cycle. */
PetscErrorCode SecantStart(const Model *model, const Contacts *contacts, const State *state, Relaxation *r);
PetscErrorCode Secant(const Model *model, const State *state, PetscReal ratio, Relaxation *r);
/* After a check: friction on the way follows the law closely or from afar, the other where the ratio stalls.
   */
static const PetscReal FOLLOW_CLOSELY = 0.5; /* pull at the start of a stage; see the head of relax.c */
void FollowElse(const Model *model, const State *state, PetscReal ratio, Relaxation *r, Contacts *contacts);
/* Much more stiffness-proportional damping for the rest of the stage, with masses to go with it. */
PetscErrorCode RelaxationStill(const Problem *p);
/* Collective. alpha from (35)-(38), division-free, from the sums of the cycle just done: Begin tells those of
   this rank, End waits for those of the others. */
void DampingBegin(const Scene *scene, const Model *model, Relaxation *r, const QuotientSums *local);
PetscErrorCode DampingEnd(const Scene *scene, const Model *model, State *state, Relaxation *r);
/* Collective. contact_scale: (n_dof,) |force of contacts| per dof at this cycle. Sets
   ratio, increment, kinetic. */
PetscErrorCode Unbalanced(const Model *model, const State *state, const PetscReal *contact_scale,
                          StageResult *result);
/* Collective. The verdict after a check, VERDICT_NONE: go on. */
PetscErrorCode Judge(const Problem *p);

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
/* Collective. Of a stage that ended otherwise than converged: adds to its evidence what is not held, where
   the unbalanced ratio does not show it. */
PetscErrorCode LoadsCarriedSay(const Problem *p);

/* ---- confirm.c. Collective, all of them. contact_scale: (n_dof,), overwritten. */
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

/* ---- mechanism.c; more in output.h */
/* Collective. The widest open contact [m] that closes when the degrees of freedom move on by du (n_dof,) so
   many times, 0: none does. */
PetscErrorCode MotionCloses(const Model *model, const State *state, const Contacts *contacts,
                            const PetscReal *du, PetscReal times, PetscReal *gap);

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

/* ---- energy.c: see there. Sums are of this rank until EnergyReport. */
typedef struct {
  PetscReal *v_before;              /* (n_dof,) velocity before the step */
  PetscReal *f_before;              /* (n_dof,) resisting force with the contacts before a verification */
  PetscReal *f_ext_before;          /* (n_dof,) loads of the step before */
  PetscReal *F_n, *F_s, *d_n, *d_s; /* (contacts as in Contacts) of the cycle before */
  PetscReal *work;                  /* (n_contacts,) [J] of each contact since it is there */
  PetscInt n_contacts;
  PetscReal work_before; /* [J] of contacts that are no more */
  PetscReal kinetic, strain, outside, supports, damping, damping_ahead,
      detection;                           /* [J]; detection is of all ranks */
  PetscReal kinetic_0, strain_0, joints_0; /* [J] at the start, of all ranks */
} EnergyAccount;
PetscErrorCode EnergyCreate(const Model *model, EnergyAccount *e);
PetscErrorCode EnergyDestroy(EnergyAccount *e);
/* Collective, see archive.h. Contacts must have been read back before. */
PetscErrorCode EnergyArchive(struct _p_Archive *archive, const Model *model, const Contacts *contacts,
                             EnergyAccount *e);
/* Works of the contacts over the step that led to the forces just evaluated. */
void EnergyOfContacts(const Model *model, const Contacts *contacts, EnergyAccount *e);
/* Contacts were found anew: half a step's work of what the forces have changed by, from f_before. */
void EnergyOfExchange(const Model *model, const State *state, EnergyAccount *e);
/* Around Integrate: works of loads and supports of the step before; kinetic energy and
   damping at this time. */
void EnergyBeforeStep(const Model *model, const State *state, EnergyAccount *e);
void EnergyAfterStep(const Model *model, const State *state, EnergyAccount *e);
/* The contact arrays are new (forces evaluated): starts their works afresh. */
PetscErrorCode EnergyContactsChanged(const Contacts *contacts, EnergyAccount *e);
/* Energy stored in owned contacts [J]. */
PetscReal EnergyInJoints(const Model *model, const Joint *joints, const Contacts *contacts);
/* Strain energy of owned blocks, at the forces just evaluated: before Integrate, when a report follows. */
PetscErrorCode EnergyOfBlocks(const Model *model, const State *state, EnergyAccount *e);
/* Collective. The account at the time of the forces last evaluated. first: the start of the stage. */
PetscErrorCode EnergyReport(const Model *model, const Joint *joints, const Contacts *contacts,
                            EnergyAccount *e, PetscBool first, Energies *out);

/* ---- support_motion.c */
typedef struct {
  PetscInt n;
  PetscReal *t; /* (n,) [s] */
  PetscReal
      *row; /* (n,2,4) along x, y: displacement [m] at a row and, just behind it, its three derivatives */
  PetscReal now[3]; /* [m/s] in this step, along x and y; none about the centre */
} SupportMotion;
/* Collective. (n_supports,) motion of each support that has one; refuses a file that is none. */
PetscErrorCode SupportMotionsRead(const Scene *scene, MPI_Comm comm, SupportMotion **motions);
PetscErrorCode SupportMotionsDestroy(const Scene *scene, SupportMotion **motions);
/* Collective. At the start of a stage: warns of supports whose file ends in motion before its end: they
   stop at once there, which is a blow; an accelerogram without base line correction does so. */
PetscErrorCode SupportMotionsWarn(const Problem *p, const SupportMotion *motions);
/* After Integrate: velocities and displacements of what moving supports hold, of the step and at its end. */
void SupportsMove(const Scene *scene, const Model *model, SupportMotion *motions, State *state);

/* ---- dynamics.c */
/* Collective. Runs a dynamic stage for its duration. */
PetscErrorCode StageRunDynamic(const Problem *p);

/* ---- uplift.c */
/* Collective. Measures the open lengths of the stage's cracked uplift loads. again: one has changed (before
   equilibrium, grown), so the stage must go on; a crack through the joint sets the verdict. */
PetscErrorCode UpliftCrack(const Problem *p, PetscBool *again);
/* Collective. Finds the open stretches of cracked uplift loads that the full head does not reach as joints
   are now; tell: warns of them. */
PetscErrorCode UpliftSurvey(const Problem *p, PetscBool tell);

/* ---- method.c */
/* Collective. How a static stage or a trial goes to its equilibrium: explicit, or preconditioned first. The
   same on any number of ranks. */
PetscErrorCode StageMethod(const Scene *scene, const Model *model, const Contacts *contacts,
                           const Stage *stage, MethodKind *method);

/* ---- stages.c */
/* Collective. The undeformed state, at rest. */
PetscErrorCode StateCreate(const Scene *scene, const Model *model, State *state);
PetscErrorCode StateDestroy(State *state);
/* "explicit", "preconditioned", or the one and then the other. */
const char *EffortMethod(const Effort *effort);
/* [solves] What it amounts to by Newton's method. */
PetscReal EffortWork(const Effort *effort);
/* Rank 0: whether it is time for a line about where the stage is: every ten seconds, on a terminal twice a
   second; and that line. */
PetscBool StageShows(const Problem *p);
void StageShow(const Problem *p, const char *what);
/* Lines on stdout about how a stage ended. */
PetscErrorCode StageReport(const Problem *p);
/* Loads that follow the motion, anew at the present displacements. */
PetscErrorCode StageLoads(const Problem *p);
/* Collective. Runs one stage that is not dynamic to its verdict. */
PetscErrorCode StageRun(const Problem *p);
/* Collective. Relaxes under the stage's loads and joints, to a verdict that nobody is told yet: a static
   stage, or one trial of another. */
PetscErrorCode StageRelax(const Problem *p);

/* ---- reduction.c: the stages that are made of trials */
/* [degree] Largest friction among the joints whose strength the stage reduces, of those only that `has`
   (n_joints,) marks; NULL: of all. NaN: it reduces none. */
PetscReal ReducedFriction(const Scene *scene, const Stage *stage, const PetscInt *has);
/* Collective. p->stage->joints are left as in the last stable trial. */
PetscErrorCode ReductionRun(const Problem *p);
PetscErrorCode FloodRun(const Problem *p);

/* ---- advise.c */
/* Collective. Prints what a Quoin that is set up will cost and what could be left out of it; writes nothing.
   scene_file, argc, argv: as it was read. It is of no use afterwards. */
PetscErrorCode Advise(Quoin q, const char *scene_file, int argc, char **argv);

/* solve.h: equilibrium: how a static stage finds it, and the verdict that the stage ends with. */
#pragma once
#include "output/output.h"

/* ---- judge.c */
typedef struct _p_Newton Newton;
enum { REST_STEPS = 3 };
/* Where the motion would come to rest, see rest_point.c. */
typedef struct {
  PetscReal *u_sum,
      *r_sum; /* (n_dof,) displacement, unbalanced force [N, N m]: sums over checks of this chunk */
  PetscReal *u_mean, *r_mean; /* (n_dof,) means of the chunk before */
  PetscBool kept;             /* the means, since something can fail; the same on all ranks */
  PetscInt checks;            /* in the sums */
  PetscBool has_mean;         /* there is a chunk before */
  PetscReal drive;            /* [N] what drives the motion at the mean of the last chunk */
  PetscReal way[REST_STEPS],
      loss[REST_STEPS]; /* [m], [N] from mean to mean, the last first: way of what moves
                                                  fastest, fall of the drive; way 0: not known */
} RestPoint;
/* What a verdict rests on. Cycles are cut into chunks, and each chunk is judged as it ends. */
typedef struct {
  PetscReal *u_0;    /* (n_dof,) displacement at the start of the stage */
  PetscReal longest; /* [m] longest contact at the start of the stage: the unit of "far" */
  PetscReal *u_chunk,
      *du_chunk;      /* (n_dof,) displacement at the start of the chunk, increment of the chunk before */
  PetscReal *r_chunk; /* (n_dof,) [N, N m] unbalanced force at the start of the chunk */
  PetscReal *ratios;  /* (max_ratios,) unbalanced ratios seen in this chunk */
  PetscInt n_ratios, max_ratios, steady; /* steady: chunks in a row that moved on in one direction */
  PetscReal median[4], rate[4];          /* of the last chunks, the last first: ratio [-], motion [m/cycle] */
  PetscReal ahead[3]; /* [m] of the last three chunks: how far ahead nothing drives the motion any more */
  PetscInt64 chunk_start, chunk_length;
  PetscReal alpha_sum; /* sum of alpha over the n_alpha checks since the start of the first chunk */
  PetscInt n_alpha;
  PetscReal settled_alpha; /* the right damping for beta = 0: the mean of the last stage or trial that
                              converged, or what Newton's method has found; 0: not known */
  PetscBool still;         /* Judge asks for RelaxationStill */
  RestPoint rest;
} Evidence;
/* How friction follows its law before equilibrium, see friction_mode.c. */
typedef struct {
  PetscReal half_ratio;  /* [-] unbalanced ratio when it last halved or stalled */
  PetscInt64 half_cycle; /* the cycle when it did */
  PetscInt stalls;       /* times that the ratio took too long to halve (FrictionModeSwitch) */
} FrictionProgress;
/* The account against which the kinetic energy is checked, see energy_check.c. */
typedef struct {
  PetscReal *u, *f;     /* (n_dof,) displacement and resisting force when the account was opened */
  PetscReal start;      /* [J] kinetic energy at that time */
  PetscReal stored;     /* [J] in tendons at that time */
  PetscReal most;       /* [J] largest kinetic energy since then that was found in order */
  PetscReal ramp;       /* [J] what the ramp may have added to the work of the loads at its end */
  PetscInt made_energy; /* times in this stage that the kinetic energy was too large */
  PetscReal rounds;     /* [J] largest work of a round of the stage that is over, for CheckStageIncrement */
} EnergyCheckAccount;
/* What the static stages of a run remember. */
typedef struct _p_Relaxation {
  Damping damping;
  Evidence evidence;
  FrictionProgress follow;
  EnergyCheckAccount account;
  Newton *newton;          /* factor and work arrays of newton.c, NULL: not used so far */
  PetscReal reached, step; /* Newton's method: fraction of the loads at the last equilibrium, and by how much
                              the next increment raises it; step 0: the method is not at work */
  Vec guess;           /* displacements that Newton's method tries first, once; NULL: none. Another owns it */
  Effort effort;       /* of the stage so far */
  PetscReal most_work; /* [solves] limit of the stage's work (EffortWork) for Newton's method; 0: none */
  Effort spent;        /* effort when a limit ended Newton's method; no evaluations: none has */
  PetscBool told;      /* a warning has said that the stage's slip depends on the path */
  PetscInt told_step;  /* the stage, counted from 1, whose long step a warning has told of */
} Relaxation;
PetscErrorCode RelaxationCreate(const Scene *scene, const Model *model, Relaxation *r);
PetscErrorCode RelaxationDestroy(Relaxation *r);
/* Collective, see archive.h. Archives all that the damping and the verdicts remember. */
PetscErrorCode RelaxationArchive(struct _p_Archive *archive, const Model *model, Relaxation *r);
/* Collective. Forgets the evidence: at the start of a stage, at the end of its ramp, when damping changes. */
PetscErrorCode RelaxationReset(const Problem *p);
/* Collective. The secant, the evidence, the stalls and the faults of energy count from this state. Call it
   with forces evaluated. */
PetscErrorCode RelaxationStart(const Model *model, const Contacts *contacts, const State *state,
                               Relaxation *r);
enum {
  CHUNK_MIN = 500,     /* cycles of the shortest chunk */
  STALLS_TO_LET_GO = 4 /* stalls after which slip is kept as it comes, see friction_mode.c */
};
/* Collective. Raises the stiffness-proportional damping for the rest of the stage, and the masses with it. */
PetscErrorCode RelaxationStill(const Problem *p);
/* Collective. The verdict at a look; VERDICT_NONE: the stage goes on. */
PetscErrorCode Judge(const Problem *p);

/* ---- rest_point.c */
/* Whether a joint or a block of the scene can fail. */
PetscBool SceneCanFail(const Scene *scene);
/* Where neither a joint nor a block can fail, no motion has to be judged, and all that follows does
   nothing. */
PetscErrorCode RestPointCreate(const Scene *scene, const Model *model, RestPoint *r);
PetscErrorCode RestPointDestroy(RestPoint *r);
/* Collective, see archive.h. */
PetscErrorCode RestPointArchive(struct _p_Archive *archive, const Model *model, RestPoint *r);
/* The means begin with the next look. */
PetscErrorCode RestPointForget(const Model *model, RestPoint *r);
/* Adds the state of a look to the means of the chunk. */
void RestPointAdd(const Model *model, const State *state, RestPoint *r);
/* Collective. A chunk ends. */
PetscErrorCode RestPointOfChunk(const Model *model, const State *state, RestPoint *r);
/* [m] The least way to where nothing drives the motion any more that the means of the last chunks allow; 0:
   not known. */
PetscReal RestPointAhead(const RestPoint *r);

/* ---- friction_mode.c */
static const PetscReal PULL_CLOSE = 0.5; /* pull at the start of a stage; see the head of friction_mode.c */
/* Call it at a look. Friction follows its law closely or from afar; this changes to the other when the ratio
   stalls. */
PetscErrorCode FrictionModeSwitch(const Model *model, const State *state, PetscReal ratio, Relaxation *r,
                                  Contacts *contacts);

/* Loads have changed within the stage: stalls count from here, and friction follows its law closely again. It
   does nothing where slip is kept as it comes. */
void FrictionModeRestart(Relaxation *r, Contacts *contacts);

/* ---- balance.c */
/* Collective. Sets ratio, worst_body, increment, displacement, kinetic, loaded and finite of result.
   contact_scale: (n_dof,) |force of contacts| per dof at this cycle; u_0: (n_dof,) displacement at the start
   of the stage. */
PetscErrorCode Unbalanced(const Model *model, const State *state, const PetscReal *contact_scale,
                          const PetscReal *u_0, StageResult *result);

/* ---- contact_travel.c */
/* A contact that was kept means nothing once its faces have parted or slid by this fraction of their
   length. */
#define TRAVEL_LIMIT 0.1
/* Partings and slidings count from this state. Call it at the start of a stage, with forces evaluated. It
   does nothing in a stage of variable connectivity, nor where they count from a stage before. */
void ContactTravelStart(const Problem *p);
/* Contacts across a gap that bear by now count from this state. Call it at an equilibrium or at a look. */
void ContactTravelStartBearing(Contacts *contacts);
/* Collective. The farthest that two faces in contact have parted or slid, over the length of the contact (of
   the shorter face where the faces are staggered), and the place [m]. */
PetscErrorCode ContactTravel(const Problem *p, PetscReal *fraction, PetscReal place[2]);
/* Collective. The largest fraction of its length by which a contact has parted or slid farther since the
   last call; -1: no joint can fail. */
PetscErrorCode ContactTravelOfChunk(const Problem *p, PetscReal *gain);
/* Collective. Under fixed connectivity a mechanism that has carried faces out of their contacts is a
   collapse. Otherwise it could find an equilibrium of contacts that no longer exist. */
PetscErrorCode JudgeContactTravel(const Problem *p);
/* Collective. Under variable connectivity a body that nothing holds any more and that falls is a collapse,
   unless bodies may float. Call it after contacts were found again. */
PetscErrorCode JudgeLoose(const Problem *p);
/* Collective. Largest displacement [m] since the displacements `from` (ModelApplied,). */
PetscErrorCode FarthestMoved(const Problem *p, const PetscReal *from, PetscReal *most);
/* Collective. Diagonal [m] of the box around all bodies that no support holds, where the mesh has them; of
   the model where supports hold all of them. */
PetscErrorCode FreeSize(const Problem *p, PetscReal *size);
/* Collective. Warns when blocks have moved too far for contacts that were kept as they were at the start. */
PetscErrorCode FixedConnectivityWarn(const Problem *p);

/* ---- load_path.c */
#define CARRIED 1e-3 /* fraction allowed at an equilibrium: loads are not known better than this */
/* Collective, with forces evaluated. Whether all bodies, and all clusters of bodies that stick to each other,
   are held against their own loads. A fraction `allowed` of these loads may be missing. */
PetscErrorCode BodiesAreSupported(const Problem *p, PetscReal allowed, PetscBool *carried);
/* Collective, with forces evaluated. Marks the bodies (n_bodies_global,) that have neither load nor support,
   that nothing drives and that can move without resistance; n_free: how many. */
PetscErrorCode FreeBodies(const Problem *p, PetscInt *free_body, PetscInt *n_free);
/* Collective. Adds to the evidence of a stage that collapsed or is undecided what is not held, where the
   unbalanced ratio does not show it. */
PetscErrorCode UnsupportedReport(const Problem *p);

/* ---- equilibrium_check.c */
/* Collective. Takes the verdict "converged" back where friction is still far from its law. Where the verdict
   stays, the contacts have what the law gives. */
PetscErrorCode CheckFrictionLaw(const Problem *p, PetscReal *contact_scale);
/* Collective. Warns where slip that was kept as it came depends on how the loads were applied, which no
   residual shows. Afterwards the forces are no longer those of the state. */
PetscErrorCode CheckPathDependence(const Problem *p, PetscReal *contact_scale);
/* Collective, with forces evaluated. Warns of a static stage whose own change is still out of balance. */
PetscErrorCode CheckStageIncrement(const Problem *p);
/* Collective. A round of the stage is over, and the next will hardly move: CheckStageIncrement measures by
   the larger one. */
PetscErrorCode CheckRound(const Problem *p);
/* Collective, with the displacements inside condensed bodies recovered. Forces act on condensed bodies where
   these were before they moved. This warns where the moments that are missing so make displacements too
   small. */
PetscErrorCode CheckCondensedRotation(const Problem *p);

/* ---- load_step_check.c */
/* Collective. Warns where blocks would have yielded otherwise if the step from displacements u_0 (n_dof,), of
   the last equilibrium and of ramp_0 in the ramp, had been several. Call it before the history is
   committed. */
PetscErrorCode CheckLoadStep(const Problem *p, PetscReal ramp_0, const PetscReal *u_0);
/* Collective. Warns of a ramp so short that blocks crack by it. */
PetscErrorCode CheckRampLength(const Problem *p);
/* Warns, once a stage, where the unbalanced ratio stalls and blocks yield with dilation below friction. */
void TellSlowFlow(const Problem *p);
/* Collective. How many contacts have failed, and let go of stress, since the history was last committed: at
   an end, over a tenth of their length. Forces must have been evaluated with results. */
PetscErrorCode CountBrokenContacts(const Problem *p, PetscInt *n);

/* ---- energy_check.c */
/* Opens the account: from this state on the kinetic energy is checked against what the loads do. Call it with
   forces evaluated. */
PetscErrorCode EnergyCheckStart(const Problem *p);
/* Collective. Call it at the end of the ramp: the loads are constant from there on. */
PetscErrorCode EnergyCheckRampEnds(const Problem *p);
/* Collective. Checks whether the kinetic energy is more than loads and stored energy account for. The first
   time that it is, the stage begins anew with a shorter step and more damping (`anew`). Call it after
   Unbalanced. */
PetscErrorCode EnergyCheck(const Problem *p, PetscBool *anew);
/* Collective. Turns "collapsed" into "diverged" where the kinetic energy was too large again after the stage
   had begun anew: what made blocks fly apart was no load. The same holds where blocks moved against the loads
   by more than was stored. With stress models that make energy themselves the verdict stays, and the evidence
   says so. */
PetscErrorCode EnergyCheckVerdict(const Problem *p);

/* ---- factor.c */
/* Collective. Whether there is memory for the factor of NewtonRelax. memory [byte]: [0] what the factor is
   expected to take, [1] what is available, on all machines together. */
PetscErrorCode NewtonFits(const Model *model, double memory[2], PetscBool *fits);

/* ---- failing_motion.c */
/* Collective. The opening [m] of the widest open contact that closes when the degrees of freedom move on by
   `times` times du (n_dof,); 0: none closes. */
PetscErrorCode MotionCloses(const Model *model, const State *state, const Contacts *contacts,
                            const PetscReal *du, PetscReal times, PetscReal *gap);
/* Collective. Takes the motion of the last chunk as the mechanism of p->output->trials. from: not NULL: the
   motion since these displacements (ModelApplied,) instead. */
PetscErrorCode MechanismTake(const Problem *p, const PetscReal *from);

/* ---- method.c */
/* Collective. The method of a static stage or a trial: explicit, or preconditioned first. The answer is the
   same on any number of ranks. */
PetscErrorCode StageMethod(const Scene *scene, const Model *model, const Contacts *contacts,
                           const Stage *stage, MethodKind *method);

/* ---- vibration.c */
/* Collective. Finds the modes of the stage about the present state, which it leaves as it is. Refuses what
   has no mass. */
PetscErrorCode VibrationFind(const Problem *p, Vibration *vibration);

/* ---- newton.c */
/* Collective. Finds the equilibrium of a static stage or trial with fixed connectivity, under loads that go
   from applied.start to applied.target, by Newton's method with the factor of the elastic stiffness. The
   verdict is converged, collapsed (contacts outgrown, or a mechanism seen by creep) or interrupted. It is
   none when no equilibrium was found or the factor cannot be made: displacements, history and f_ext are then
   those of the last equilibrium, and the explicit loop goes on. */
PetscErrorCode NewtonRelax(const Problem *p);
PetscErrorCode NewtonDestroy(Newton **newton);
/* Collective. Lowest frequency [1/cycle] of the scaled masses on the elastic stiffness that was factored; 0:
   there is no factor. Call it after NewtonRelax; it overwrites the last correction. */
PetscErrorCode NewtonLowestFrequency(const Model *model, const State *state, const Newton *newton,
                                     PetscReal *omega);

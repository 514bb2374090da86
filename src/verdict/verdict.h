/* verdict.h: declares what is measured of a state in a static stage, and the verdict that follows from it. */
#pragma once
#include "result/result.h"
#include "verdict/thresholds.h"

/* ---- relaxation.c */
typedef struct _p_Newton Newton; /* newton.h */
/* Where the motion would come to rest, see rest_point.c. */
typedef struct {
  PetscReal *u_sum;           /* (n_dof,) displacement, summed over the checks of this chunk */
  PetscReal *r_sum;           /* (n_dof,) [N, N m] unbalanced force, summed likewise */
  PetscReal *u_mean, *r_mean; /* (n_dof,) means of the chunk before */
  PetscBool kept;             /* means are kept, because something can fail; the same on all ranks */
  PetscInt checks;            /* number of checks in the sums */
  PetscBool has_mean;         /* there is a chunk before */
  PetscReal drive;            /* [N] force that drives the motion at the mean of the last chunk */
  PetscReal way[REST_STEPS];  /* [m] largest step from mean to mean, the last first; 0: not known */
  PetscReal loss[REST_STEPS]; /* [N] fall of drive from mean to mean, the last first */
} RestPoint;
/* The evidence of a verdict. Cycles are cut into chunks, and each chunk is judged as it ends. */
typedef struct {
  PetscReal *u_0;      /* (n_dof,) displacement at the start of the stage */
  PetscReal longest;   /* [m] longest contact at the start of the stage: the unit of "far" */
  PetscReal *u_chunk;  /* (n_dof,) displacement at the start of the chunk */
  PetscReal *du_chunk; /* (n_dof,) increment of displacement of the chunk before */
  PetscReal *r_chunk;  /* (n_dof,) [N, N m] unbalanced force at the start of the chunk */
  PetscReal *ratios;   /* (max_ratios,) [-] unbalanced ratios at the n_ratios checks of this chunk */
  PetscInt n_ratios, max_ratios;
  PetscInt steady;         /* chunks in a row that moved on in one direction */
  PetscReal median[4];     /* [-] median ratio of the last chunks, the last first */
  PetscReal rate[4];       /* [m/cycle] motion in the last chunks, the last first */
  PetscReal ahead[3];      /* [m] distance to where nothing drives the motion any more, of the last chunks */
  PetscInt64 chunk_start;  /* cycle at which the chunk began */
  PetscInt64 chunk_length; /* [cycles] */
  PetscReal alpha_sum;     /* sum of alpha over the n_alpha checks since the start of the first chunk */
  PetscInt n_alpha;
  PetscReal settled_alpha; /* the right damping for beta = 0: the mean of the last stage or trial that
                               converged, or what Newton's method has found; 0: not known */
  PetscBool still;         /* Judge asks for RelaxationStill */
  RestPoint rest;
} Evidence;
/* How friction follows its law before equilibrium, see friction_mode.c. */
typedef struct {
  PetscReal half_ratio;  /* [-] unbalanced ratio when it last halved or stalled */
  PetscInt64 half_cycle; /* cycle at which it did */
  PetscInt stalls;       /* times that the ratio took too long to halve (FrictionModeSwitch) */
} FrictionProgress;
/* The account against which the kinetic energy is checked, see energy_check.c. */
typedef struct {
  PetscReal *u, *f;     /* (n_dof,) displacement and resisting force when the account was opened */
  PetscReal start;      /* [J] kinetic energy at that time */
  PetscReal stored;     /* [J] in tendons at that time */
  PetscReal most;       /* [J] largest kinetic energy since then that was in order */
  PetscReal ramp;       /* [J] the most that the ramp may have added to the work of the loads at its end */
  PetscReal lost;       /* [J] to damping since then, from the kinetic energy at checks */
  PetscInt made_energy; /* times in this stage that the kinetic energy was too large */
  PetscReal rounds;     /* [J] largest work of a finished round of the stage, for CheckStageIncrement */
} EnergyCheckAccount;
/* The memory of the static stages of a run. */
typedef struct _p_Relaxation {
  Damping damping;
  Evidence evidence;
  FrictionProgress follow;
  EnergyCheckAccount account;
  Newton *newton;      /* factor and work arrays of newton.c; NULL: not used so far */
  PetscReal reached;   /* [-] Newton's method: fraction of the loads at the last equilibrium */
  PetscReal step;      /* [-] Newton's method: fraction by which the next increment raises the loads; 0: the
                          method is not at work */
  Vec guess;           /* displacements that Newton's method tries first, once; NULL: none. Another owns it */
  Effort effort;       /* of the stage so far */
  PetscReal most_work; /* [solves] limit of the stage's work (EffortWork) for Newton's method; 0: none */
  PetscReal work_before;    /* [solves] work of the stage when the static stage or trial began */
  Effort spent;             /* effort when a limit ended Newton's method; no evaluations: none has */
  PetscInt64 begun;         /* cycles of the stage that were taken back before its present cycles began */
  PetscBool outgrown;       /* a contact has left its range, so that contacts must be found again from the
                               last equilibrium on; JudgeContactTravel */
  PetscReal outgrown_at[3]; /* its place, x and y [m], and how far it has moved over its length [-] */
  PetscBool path_warned;    /* a warning has said that the slip of the stage depends on its path */
  PetscInt step_warned;     /* number, from 1, of the last stage with a warning of a long step of load */
} Relaxation;
PetscErrorCode RelaxationCreate(const Scene *scene, const Model *model, Relaxation *r);
PetscErrorCode RelaxationDestroy(Relaxation *r);
/* Collective, see archive.h. Writes or reads all that the damping and the verdicts remember. */
PetscErrorCode RelaxationArchive(struct _p_Archive *archive, const Model *model, Relaxation *r);
/* Collective. Starts the secant, the evidence, the stalls and the faults of energy from this state. Forces
   must have been evaluated. */
PetscErrorCode RelaxationStart(const Model *model, const Contacts *contacts, const State *state,
                               Relaxation *r);

/* Returns the length [cycles] of the shortest chunk with the mass of the present cycles. */
static inline PetscReal ShortestChunk(const State *state)
{
  return state->stiffness_mass ? CHUNK_MIN_STIFFNESS : CHUNK_MIN;
}

/* ---- judge.c */
/* Collective. Forgets the evidence: at the start of a stage, at the end of its ramp, when damping changes. */
PetscErrorCode RelaxationReset(const Problem *p);
/* Collective. Decides at a check: sets result->verdict and its evidence. VERDICT_NONE: the stage goes on.
   Call it after Unbalanced. */
PetscErrorCode Judge(const Problem *p);

/* ---- rest_point.c */
/* Returns whether a joint or a block of the scene can fail. Where nothing can fail, no motion has to be
   judged, and the other functions of rest_point.c do nothing. */
PetscBool SceneCanFail(const Scene *scene);
/* Forgets the means; new ones begin with the next check. */
PetscErrorCode RestPointForget(const Model *model, RestPoint *r);

/* ---- balance.c */
/* Collective. Sets ratio, worst_body, increment, displacement, kinetic, loaded and finite of result.
   contact_scale: (n_dof,) [N] |force of contacts| at each degree of freedom in this cycle; u_0: (n_dof,)
   displacement at the start of the stage. */
PetscErrorCode Unbalanced(const Model *model, const State *state, const PetscReal *contact_scale,
                          const PetscReal *u_0, StageResult *result);

/* ---- contact_travel.c. The travel of a contact is how far its faces have parted or slid, over its length
   (over the length of the shorter face where the faces are staggered). */
/* Starts the travel of all contacts from this state. Call it at the start of a stage, with forces evaluated.
   It does nothing in a stage of variable connectivity, or where travel counts from a stage before. */
void ContactTravelStart(const Problem *p);
/* Starts the travel of contacts across a gap that bear by now. Call it at an equilibrium or at a check. */
void ContactTravelStartBearing(Contacts *contacts);
/* Collective. Finds the largest travel [-] of a contact whose joint can fail. */
PetscErrorCode ContactTravel(const Problem *p, PetscReal *fraction);
/* Collective. Decides "collapsed" where the travel of a contact is beyond TRAVEL_LIMIT: the structure has
   moved along the contacts that it had, and would go on. Contacts that it meets on the way do not count,
   because limit analysis does not know them either. rests: the state is an equilibrium under all loads. Under
   CONNECTIVITY_AUTO relax->outgrown is then set where a contact has left its range and can be found again. */
PetscErrorCode JudgeContactTravel(const Problem *p, PetscBool rests);
/* Collective. Decides "collapsed" where a body without contact or support falls, under variable connectivity,
   unless bodies may float. Call it after contacts were found again. */
PetscErrorCode JudgeLoose(const Problem *p);
/* Collective. Finds the largest displacement [m] since the displacements `from` (ModelApplied,). */
PetscErrorCode FarthestMoved(const Problem *p, const PetscReal *from, PetscReal *most);
/* Collective. Finds the macroblock that has moved farthest since the stage or trial began, and its way [m];
   of rigid bodies that of the centre. */
PetscErrorCode FarthestBody(const Problem *p, PetscInt *body, PetscReal *way);
/* Collective. Adds to the evidence what FarthestBody finds. */
PetscErrorCode FarthestBodyAdd(const Problem *p);
/* Collective. Finds the bodies that supports hold. held: (n_bodies_global,) 1 where a support holds a
   degree of freedom of the body, else 0; the caller frees it. */
PetscErrorCode HeldBodies(const Model *m, PetscInt **held);
/* Collective. Finds the diagonal [m] of the box around all bodies that no support holds, where the mesh has
   them; where supports hold all bodies, the diagonal of the model. */
PetscErrorCode FreeSize(const Problem *p, PetscReal *size);
/* Collective. Warns when blocks have moved too far for contacts that were kept as they were at the start. */
PetscErrorCode FixedConnectivityWarn(const Problem *p);

/* ---- load_path.c */
/* Collective, with forces evaluated. Finds whether all bodies, and all clusters of bodies that stick to each
   other, are supported against their own loads. A fraction `allowed` of these loads may be missing. */
PetscErrorCode BodiesAreSupported(const Problem *p, PetscReal allowed, PetscBool *carried);
/* Collective, with forces evaluated. Marks the bodies (n_bodies_global,) that have neither load nor support,
   that nothing drives and that can move without resistance, and counts them in n_free. */
PetscErrorCode FreeBodies(const Problem *p, PetscInt *free_body, PetscInt *n_free);
/* Collective. Adds to the evidence of a stage that collapsed or is undecided which body is not supported,
   where the unbalanced ratio does not show it. */
PetscErrorCode UnsupportedReport(const Problem *p);

/* ---- failing_motion.c */
/* Collective. Writes the motion of the last chunk into p->found->trials as the mechanism, with its largest
   displacement 1. from: displacements (ModelApplied,) since which the motion counts instead; NULL: none. */
PetscErrorCode MechanismTake(const Problem *p, const PetscReal *from);

/* ---- load_step_check.c */
/* Collective. Warns where blocks would have yielded otherwise if the load had come in several steps. u_0:
   (n_dof,) displacements of the last equilibrium; ramp_0 [-]: its fraction of the ramp. Call it before the
   history is committed. */
PetscErrorCode CheckLoadStep(const Problem *p, PetscReal ramp_0, const PetscReal *u_0);
/* Collective. Warns of a ramp so short that blocks crack by it. */
PetscErrorCode CheckRampLength(const Problem *p);
/* Collective, with forces evaluated. Warns, once a stage, where joints have softened under a pressure that
   makes their shear strength fall at once. */
PetscErrorCode CheckSteepSlope(const Problem *p);
/* Warns, once a stage, where the unbalanced ratio stalls and blocks yield with dilation below friction. */
void SlowFlowWarn(const Problem *p);
/* Collective. Counts the contacts that have failed, and lost stress, since the history was last committed: at
   an end, over a tenth of their length; and the contacts that slip. Forces must have been evaluated with
   results. */
PetscErrorCode CountFailedContacts(const Problem *p, PetscInt *n_broken, PetscInt *n_slipping);
/* Collective. Counts the ends of contacts that have failed so. Forces must have been evaluated with
   results. */
PetscErrorCode CountBrokenEnds(const Problem *p, PetscInt *n_ends);

/* ---- equilibrium_check.c */
/* Collective. Takes the verdict "converged" back where friction is still far from its law. Where the verdict
   stays, the contacts have the stresses of the law. */
PetscErrorCode CheckFrictionLaw(const Problem *p, PetscReal *contact_scale);
/* Collective. Warns where slip that was kept as it came depends on how the loads were applied, which no
   residual shows. Afterwards the forces no longer belong to the state. */
PetscErrorCode CheckPathDependence(const Problem *p, PetscReal *contact_scale);
/* Collective. Counts the contacts, n[0], and those of them that have slipped at an end whose pressure is more
   than `part` of the largest one, n[1]. part < 0: whatever the pressure. */
PetscErrorCode SlippedContacts(const Problem *p, PetscReal part, PetscInt n[2]);
/* Collective. Warns of a stage of rubble in which many contacts have slipped, where no other warning has
   named the path. Their slip meets the law, so no check of balance speaks; but where many slip there are many
   equilibria, and the path of the loads chooses one. Walls of courses and arches have shown none. */
PetscErrorCode CheckManySlips(const Problem *p);
/* Collective, with forces evaluated. Warns where a static stage changes the forces little, and much of this
   change is still out of balance. */
PetscErrorCode CheckStageIncrement(const Problem *p);
/* Collective. Keeps the work of a round of the stage that is over. CheckStageIncrement measures the next
   round, which may hardly move, by the largest one. */
PetscErrorCode CheckRound(const Problem *p);
/* Collective, with the displacements inside condensed bodies recovered. Warns where displacements are too
   small because forces act on condensed bodies where these were before they moved. */
PetscErrorCode CheckCondensedRotation(const Problem *p);

/* ---- energy_check.c */
/* Collective. Goes back to the displacements, the history and the loads of where the account was opened; the
   ramp starts again. Contacts that were found since stay with their displacements. Forces must be evaluated
   afterwards. */
PetscErrorCode EnergyCheckGoBack(const Problem *p);
/* Collective, with forces evaluated. Opens the account: from this state on the kinetic energy is checked
   against the work of the loads. */
PetscErrorCode EnergyCheckStart(const Problem *p);
/* Collective. Completes the account at the end of the ramp, from where on loads are constant. */
PetscErrorCode EnergyCheckRampEnds(const Problem *p);
/* Collective. Checks whether the kinetic energy is more than loads and stored energy account for. If so for
   the first time in the stage, the stage restarts with a shorter step and more damping. Call it after
   Unbalanced. */
PetscErrorCode EnergyCheck(const Problem *p, PetscBool *restarted);
/* Collective. Finds the part of the work of the present loads since the account was opened that damping took.
   It is hundredths where loads rise slowly and blocks follow them. */
PetscErrorCode EnergyLost(const Problem *p, PetscReal *part);
/* Collective. Goes back to where the account was opened: at rest, with the committed history and the loads of
   that time. With variable connectivity contacts have been found since, and the blocks stay where they are.
   Masses and forces must then be found again. */
PetscErrorCode EnergyCheckGoBack(const Problem *p);
/* Collective. Turns "collapsed" into "diverged" where the kinetic energy was too large again after the
   restart, or where blocks moved against the loads by more energy than was stored: the cycles made that
   energy. With stress models that make energy themselves the verdict stays, and the evidence says so. */
PetscErrorCode EnergyCheckVerdict(const Problem *p);

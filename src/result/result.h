/* result.h: declares what a stage finds: the Result that stages and solvers fill while it runs, and its
   fields gathered on rank 0. output/ writes both. */
#pragma once
#include "motion/motion.h"

/* ---- fields.c */
typedef struct {
  PetscInt n_vertices, n_blocks;
  PetscReal *X;         /* [m] (n_vertices,2) */
  PetscInt *blocks;     /* (n_blocks,4) file vertices, -1 in the last column of a triangle */
  PetscInt *group;      /* (n_blocks,) */
  PetscInt *macroblock; /* (n_blocks,) */
  PetscInt *rank;       /* (n_blocks,) rank that has the block when the run starts */
  PetscInt *file;       /* (n_blocks,) file id of each block gid */
} MeshFields;
/* Rows of StageFields. GatherPlaced moves them between ranks as bytes. */
typedef struct {
  PetscReal u[2];        /* [m] displacement */
  PetscReal reaction[2]; /* [N] of supports along x, y; 0 where free, and at vertices of rigid bodies */
  PetscReal applied[2];  /* [N] likewise */
  PetscInt support[2];   /* row of the support that holds x, y; -1: none */
} VertexRow;
typedef struct {
  PetscReal u[3];        /* [m], [m], [rad] displacement and rotation of a rigid body */
  PetscReal reaction[3]; /* [N], [N], [N m] about its centroid */
  PetscReal applied[3];  /* likewise */
  PetscInt support[2];   /* row of the support that holds x, y; -1: none */
} BodyRow;
enum { LAW_MEASURES = MATERIAL_LAWS - 1 };
typedef struct {
  PetscReal stress[3];             /* [Pa] sxx, syy, sxy at the centre */
  PetscReal s1, s2, angle;         /* [Pa], [Pa], [rad] principal stresses and direction of s1 */
  PetscReal energy;                /* [J] strain energy */
  PetscReal rotation;              /* [rad] of a rigid block */
  PetscReal gauss[4][3];           /* [Pa] stresses at the integration points */
  PetscReal warmer;                /* [K] change of temperature */
  PetscReal stress_z;              /* [Pa] stress across the plane */
  PetscReal built;                 /* [-] 1: the block is built, 0: not yet */
  PetscReal measure[LAW_MEASURES]; /* [-] measure (laws.h) of each law but the elastic one, in their order */
  PetscReal crack_width;           /* [m] */
  PetscReal lost;                  /* [J] energy lost for good */
} BlockRow;                        /* NaN where the kind of block has no such value */
typedef struct {
  PetscReal point[2], displacement[2]; /* [m] of P, reference and displacement */
  PetscReal normal[2];                 /* [-] from side b to side a; force acts along it on side b */
  PetscReal opening, sliding, slip;    /* [m] u_n less rest; u_s; plastic part of u_s */
  PetscReal broken;                    /* [-] */
  PetscReal closure;                   /* [m] plastic part of u_n */
  PetscReal sigma, tau;                /* [Pa] */
  PetscReal force[2];                  /* [N] normal and along the joint, signs of sigma and tau */
  PetscInt state;                      /* bits of ContactState */
} ContactEnd;
enum { FACE_NOT_WRITTEN = -1 }; /* value in ContactRow.face: see SelectedStage */
typedef struct {
  PetscInt face[2]; /* 4 * file id of the block + k; order as in Contacts.key; -2 - file id of a vertex */
  PetscInt body[2]; /* macroblocks of side a, face[0], and side b, face[1] */
  PetscInt klass, joint;
  PetscInt gathered; /* its place among the rows in the order of the ranks */
  PetscReal length;  /* [m] */
  PetscReal control; /* [-] length over a tenth of the shorter face (of a corner: of its face), at most 1 */
  PetscReal open, crushing; /* [m] open and crushing length */
  ContactEnd end[2];        /* a vertex on a face has one end: the other repeats it without force */
} ContactRow;
/* Envelopes of a block; NaN: it has no such stress or strength. */
typedef struct {
  PetscReal s1, s1_time;         /* [Pa] largest s1, [s] */
  PetscReal s2, s2_time;         /* [Pa] least s2, [s] */
  PetscReal factor, factor_time; /* [-] least safety factor, [s] */
  PetscReal mode;                /* SafetyMode of this factor */
} EnvelopeBlock;
/* Envelopes of an end of a contact. */
typedef struct {
  PetscReal sigma_max, sigma_min; /* [Pa] */
  PetscReal opening, slip;        /* [m] largest opening, largest size of the slip */
} EnvelopeEnd;
/* Envelopes of a contact between two faces or of a vertex on a face. */
typedef struct {
  PetscReal key[2]; /* as Contacts.key */
  EnvelopeEnd end[2];
} EnvelopeRow;
typedef struct {
  PetscReal time;                       /* [s] of dynamic stages */
  PetscInt n_contacts, n_bodies, n_dof; /* of the whole model */
  VertexRow *vertex;                    /* (n_vertices,) */
  BodyRow *body;                        /* (n_bodies,) rigid bodies by number */
  BlockRow *block;                      /* (n_blocks,) */
  ContactRow *contact;                  /* (n_contacts,) ascending faces */
  PetscReal *safety;                    /* (n_blocks,) least of (39)-(41), NaN without strengths; safety.c */
  PetscInt *safety_mode;                /* (n_blocks,) SafetyMode; both NULL when no material has strengths */
  PetscReal *mechanism;                 /* (n_vertices,2) velocity at collapse, largest 1; NULL: none */
  PetscInt n_modes;
  PetscReal *modes;                   /* (n_vertices, n_modes, 2) shapes; NULL: none */
  EnvelopeBlock *envelope_block;      /* (n_blocks,); NULL: the stage has no envelopes */
  EnvelopeEnd (*envelope_contact)[2]; /* (n_contacts,) both ends */
  PetscInt64 envelope_samples, envelope_every;
  PetscInt n_tables;
  TermTable *tables; /* (n_tables,) of force terms, TermsTables; rank 0 */
} StageFields;
/* Gathers the mesh. The functions of this part are collective. */
PetscErrorCode GatherMesh(const Model *model, MeshFields *mesh);
PetscErrorCode GatherMeshDestroy(MeshFields *mesh);
PetscErrorCode GatherStage(const Model *model, const State *state, const Contacts *contacts,
                           const Stage *stage, const MeshFields *mesh, StageFields *fields);
/* Gathers only fields->contact and n_contacts of a stage. */
PetscErrorCode GatherContacts(const Model *model, const State *state, const Contacts *contacts,
                              const Stage *stage, const MeshFields *mesh, StageFields *fields);
PetscErrorCode GatherStageDestroy(StageFields *fields);
/* Not collective. Finds the normal at end k of contact i from side b to side a. u: displacements. */
void ContactNormal(const Model *model, const PetscReal *u, const Contacts *contacts, PetscInt i, int k,
                   PetscReal n[2]);
/* Not collective. Finds the length of contact i and its open length [m], as in its row. */
void ContactLengths(const Problem *p, PetscInt i, StressModelKind kind, PetscReal *length, PetscReal *open);
/* Gathers values (n_owned, width) of vertices on rank 0, in file order. */
PetscErrorCode GatherVertices(const Model *model, PetscInt width, const PetscReal *values, PetscReal **all);

/* ---- safety.c */
/* Returns whether the material has a strength, so that blocks have a factor. */
PetscBool MaterialHasStrengths(const Material *material);
typedef enum { SAFETY_NONE, SAFETY_TENSION, SAFETY_COMPRESSION, SAFETY_SHEAR } SafetyMode;
/* Finds the least of (39)-(41) for principal stresses s1 >= s2 [Pa], and its mode; infinite when nothing can
   fail. */
SafetyMode SafetyFactor(const Material *material, PetscReal s1, PetscReal s2, PetscReal *factor);
/* Computes fields->safety and safety_mode when a material has strengths. */
PetscErrorCode SafetyFields(const Scene *scene, const MeshFields *mesh, StageFields *fields);
/* Returns whether some of n blocks have a number in a member of BlockRow. first: the member in the first
   row. */
PetscBool BlocksHave(PetscInt n, const PetscReal *first);
/* Returns the area of a block [m2]. centre: the mean of its vertices [m]. */
PetscReal MeshBlockArea(const MeshFields *mesh, PetscInt block, PetscReal centre[2]);

/* ---- envelope.c */
/* Extremes over the samples of a dynamic stage, of this rank. */
typedef struct {
  PetscInt every; /* steps between samples; 0: none, and all arrays are NULL */
  PetscInt64 samples;
  PetscInt n_blocks;
  PetscInt *gid, *file; /* (n_blocks,) owned blocks, those that deform first */
  EnvelopeBlock *block; /* (n_blocks,) */
  PetscInt n_rows;
  EnvelopeRow *row; /* (n_rows,) contacts that are or were, ascending keys */
  PetscInt *at;     /* (n_padded,) row of each contact, -1: not owned; NULL: contacts have changed */
} Envelope;
PetscErrorCode EnvelopeCreate(const Problem *p, Envelope *envelope);
PetscErrorCode EnvelopeDestroy(Envelope *envelope);
/* Forgets the order of the contacts. To be called when contacts have been found again. */
PetscErrorCode EnvelopeContactsChanged(const Problem *p);
/* Samples the forces just evaluated. */
PetscErrorCode EnvelopeTake(const Problem *p);
/* Collective. Archives the envelope, see archive.h. The contacts must have been read before. */
PetscErrorCode EnvelopeArchive(Archive *archive, const Problem *p);
/* Collective. Fills in the envelopes of a stage whose contacts have been gathered. */
PetscErrorCode EnvelopeGather(const Problem *p, StageFields *fields);

/* ---- joint_resultants.c */
/* The line of the contacts of a joint, and the resultants over it (see the head of the file). */
typedef struct {
  PetscInt n; /* number of contacts */
  PetscBool is_line;
  PetscReal start[2], end[2];     /* [m] ends of the chord */
  PetscReal e[2];                 /* [-] from start to end */
  PetscReal chord, length;        /* [m] length of the chord; sum over contacts */
  const ContactEnd *first, *last; /* the outermost contacts; without slivers, where there are others */
  PetscReal N, T, M;              /* [N], [N m] */
  PetscReal R[2];                 /* [N] */
  PetscReal open, closed, slipping, crushing; /* [m] */
  ContactEnd lowest, highest;                 /* extremes of sigma over a control length */
  PetscInt ends;
} JointResultants;
/* Rank 0. Finds the resultants of a joint from gathered contacts, to which they point. */
JointResultants JointResultantsOf(const StageFields *fields, PetscInt joint);
/* Rank 0. Finds the direction (n_joints,2) from start to end of joints whose contacts are a line; 0, 0: of
   others. */
void JointDirections(PetscInt n_joints, const StageFields *fields, PetscReal *direction);
/* Returns strength over demand [-], for forces N and T [N] and the closed length [m]. residual 0: of the peak
   strength, 1: of the residual strength. NaN of an elastic joint. */
PetscReal SlidingFactor(const Joint *joint, PetscReal N, PetscReal T, PetscReal closed, PetscReal thickness,
                        int residual);

/* ---- hinges.c */
/* Joints between two bodies that are closed over less than half of their face, with tptm. */
typedef struct {
  PetscInt n;
  PetscReal least, point[2]; /* [-] least compressed length of a joint over its face; [m] place of it */
  PetscReal governing;       /* [-] mean of the hinges that turn in a mechanism; NaN: not known */
} Hinges;
Hinges HingesOf(const Problem *p, const StageFields *fields);

/* ---- trials.c */
enum JointMotion { JOINT_SLIDES, JOINT_OPENS }; /* largest speeds, closed and open; of the fastest vertex */
typedef struct {
  PetscReal friction;        /* [degree] before it was reduced */
  PetscReal stable, failing; /* [-] tan(friction) over the one of the last stable, the first failing trial */
  PetscBool reduced;         /* it has contacts and friction, and the stage reduces it */
} JointFactor;
typedef struct {
  PetscInt n;
  PetscReal stable, failing; /* the bracket; NaN: no such trial */
  PetscReal open;            /* value nearest to stable whose trial has no verdict; NaN: there is none */
  PetscReal moved, most;     /* [m] way of the last stable trial; a trial that goes farther fails */
  JointFactor *joints;       /* (n_joints,) after a reduction of friction; NULL: there was none */
  PetscInt one;              /* joint that has the factors of the stage, -1: there is no single factor */
  PetscReal *mechanism;      /* (n_owned,2) velocities of the failing trial, largest 1; NULL: none fails */
  PetscReal *joint_motion;   /* (n_joints,2) JointMotion of each joint in it; NULL likewise */
  TermTable loads;           /* LoadsTable, where trials or steps change loads; name NULL: no table */
} Trials;
/* Finds the factors of a reduction of friction, joint by joint. full: the joints before; has: (n_joints,)
   ReducedJoints. */
PetscErrorCode TrialsFactors(const Problem *p, const Joint *full, const PetscInt *has);
/* Writes the stage's single factor, or why it has none, into text; "" when neither applies. */
void TrialsReport(const Problem *p, size_t size, char *text);
PetscErrorCode TrialsReset(Trials *trials);
/* Returns whether a joint slides, or opens, in the mechanism. */
PetscBool MechanismHas(const Scene *scene, const Trials *trials, PetscInt joint, enum JointMotion motion);

/* ---- modal.c */
/* Small free vibrations, the slowest first. Shapes are scaled: the largest displacement along x or y is 1. */
typedef struct {
  PetscInt n, missed;   /* modes; as in Modes */
  PetscReal *omega2;    /* (n,) [1/s2]; 0: a motion without stiffness; below 0: one that grows */
  PetscReal *mass;      /* (n,) [kg] modal mass */
  PetscReal *factor;    /* (n,2) [-] participation when the ground moves along x, y */
  PetscReal *shape;     /* (n_owned, n, 2) [-] displacements of vertices */
  PetscReal *error;     /* (n,) [-] see InsideError; 0 without condensed bodies */
  PetscBool reduced;    /* there are such bodies */
  PetscReal moving[2];  /* [kg] all mass that can move along x, y, water included */
  PetscInt contacts[3]; /* of all ranks: how many, open in part or whole, slipping */
} Vibration;
PetscErrorCode VibrationDestroy(Vibration *v);
/* Returns the frequency of a mode [Hz]; NaN of a motion that grows. */
PetscReal VibrationHertz(const Vibration *v, PetscInt mode);
/* Returns the effective mass [kg] of a mode along x (0) or y (1). */
PetscReal VibrationMass(const Vibration *v, PetscInt mode, int x);
/* Returns the effective mass [-] of a mode, -1: of all, over the mass that can move; 0 where nothing can
   move. */
PetscReal VibrationPart(const Vibration *v, PetscInt mode, int x);

/* ---- histories.c */
/* Extremes of series in time. */
typedef struct {
  PetscReal first, last;          /* values; NaN: none yet */
  PetscReal least, largest;       /* values */
  PetscReal least_at, largest_at; /* [s] the first time of each */
} Peak;
enum { PEAK_REALS = sizeof(Peak) / sizeof(PetscReal) };
/* Takes a value into a peak; NaN is passed over. */
static inline void PeakTake(Peak *p, PetscReal value, PetscReal time)
{
  if (PetscIsNanReal(value)) return;
  if (PetscIsNanReal(p->first)) *p = (Peak){value, value, value, value, time, time};
  p->last = value;
  if (value < p->least) p->least = value, p->least_at = time;
  if (value > p->largest) p->largest = value, p->largest_at = time;
}
/* Values of a joint at a check; columns of joint_history.csv. */
enum {
  CHECK_N,               /* [N] normal force, compression positive */
  CHECK_T,               /* [N] shear force */
  CHECK_FACTOR_PEAK,     /* [-] against sliding */
  CHECK_FACTOR_RESIDUAL, /* [-] */
  CHECK_SLIP,            /* [m] mean over the length */
  CHECK_SLIP_LARGEST,    /* [m] of an end */
  CHECK_OPENING,         /* [m] largest of an end */
  CHECK_OPEN,            /* [m] open length */
  CHECK_LENGTH,          /* [m]; NaN: the joint has no contacts */
  CHECK_COLUMNS
};
/* Values at the checks of a dynamic stage; the same on all ranks unless a comment says otherwise. */
typedef struct {
  PetscInt n_joints, n_supports, n_points;
  PetscReal *direction; /* (n_joints,2) from start to end of joints that were lines when the stage began;
                            0, 0: of another */
  PetscReal *carried;   /* [m] (n_joints,) mean slip of contacts that have been found again since */
  PetscReal *joint;     /* (n_joints, CHECK_COLUMNS) of the last check */
  PetscReal every, joint_time; /* [s] between checks; of the last one, NaN: its rows are written */
  PetscReal *support;    /* [N] (n_supports,2) force of each on the model at the last check; NULL: no stage in
                            time runs */
  int16_t *lets_through; /* (n_dof,) this rank: row of the support whose boundary lets waves out there, -1:
                            none */
  Peak *joint_peak;      /* (n_joints, CHECK_COLUMNS) */
  Peak *support_peak;    /* (n_supports + 1,2) the last of all together */
  Peak *probe_peak;      /* (n_points,4) u x,y; over the ground x,y */
  PetscInt n_things;     /* number of values at a check of things that terms name */
  AnchorRecord things;   /* these values at the last check */
  PetscReal things_time; /* [s] of it; NaN: its rows are written */
  Peak *things_peak;     /* (n_things,) */
} Histories;
/* Creates empty histories for the dynamic stage that begins. */
PetscErrorCode HistoriesCreate(const Problem *p, Histories *histories);
PetscErrorCode HistoriesDestroy(Histories *histories);
/* Collective. Samples the joints, and what terms record, at the forces just evaluated. */
PetscErrorCode HistoriesSample(const Problem *p);
/* Collective. Samples what terms record (anchors). */
PetscErrorCode TermHistorySample(const Problem *p);
/* Collective. Finds which joints are lines, at the start of the stage. */
PetscErrorCode HistoriesBegin(const Problem *p);
/* Collective. Archives the histories, see archive.h. */
PetscErrorCode HistoriesArchive(Archive *archive, const Problem *p);
/* Takes the probes of now into the peaks of a dynamic stage. */
void HistoriesOfProbes(const Problem *p);

/* ---- joint_history.c */
/* Collective. Samples all joints at the forces just evaluated, which belong to the present displacements. */
PetscErrorCode JointHistorySample(const Problem *p);
/* Collective. Carries the slip of joints over to contacts that are found again: call it with 1 before the
   search, and with -1 after it, forces evaluated. */
PetscErrorCode JointSlipsCarry(const Problem *p, PetscReal sign);

/* ---- support_forces.c */
/* Finds where boundaries let waves out. */
PetscErrorCode SupportForcesBegin(const Problem *p);
/* Collective. Samples the force of each support on the model after a step, at the forces just evaluated.
   v_before: velocities before the step; ground: [m/s] velocity that alpha damps against. */
PetscErrorCode SupportForcesSample(const Problem *p, const PetscReal *v_before, const PetscReal ground[2]);

/* ---- body_motion.c */
extern const char *const FateWords[]; /* (BODY_FATES,) in words */
typedef enum { BODY_OVERTURNED, BODY_FALLEN, BODY_SLID, BODY_FATES } BodyFate;
/* The fate of all macroblocks, the same on all ranks. */
typedef struct {
  PetscInt n;
  PetscReal *centre;  /* [m] (n,2) mass centre in the mesh */
  PetscReal *balance; /* [rad] (n,2) rotations, anticlockwise and clockwise, that lay it on another side */
  PetscReal *mass;    /* [kg] (n,) */
  PetscReal *size;    /* [m] (n,2) width and height in the mesh; 0: a support holds it, so it is not judged */
  PetscReal *since;   /* [s] (n,BODY_FATES) when each happened first; infinite: it has not */
  PetscReal *moved;   /* [m] (n,2) way of the mass centre over the ground, at the last check */
  PetscReal *turned;  /* [rad] (n,) rotation at the last check, anticlockwise */
  PetscInt *group;    /* (n,) group of the bodies that are judged */
} BodyMotion;
/* Collective. Sets up from the mesh; nothing has happened yet. */
PetscErrorCode BodyMotionCreate(const Model *model, BodyMotion *bodies);
PetscErrorCode BodyMotionDestroy(BodyMotion *bodies);
/* Collective. Judges the bodies by the present displacements, at the present time. */
PetscErrorCode BodyMotionSample(const Model *model, const State *state, BodyMotion *bodies);
/* Writes the fates of macroblocks for the evidence; "" when none has any. */
PetscErrorCode BodyMotionReport(const Model *model, const BodyMotion *bodies, size_t size, char *text);
/* Collective, for fixed connectivity. Warns of bodies without contacts, at the start.  Finds the first two
   blocks that overlap deeper than closed joints and the mesh explain, "" when none do. */
PetscErrorCode BodiesLoose(const Problem *p);
PetscErrorCode BodiesPassed(const Problem *p, char message[MESSAGE_LENGTH]);
/* Collective. Computes the mass centre of every macroblock [m] (n_bodies_global,2) with displacements u of
   the dofs; NULL: in the mesh. */
PetscErrorCode BodyCentres(const Model *model, const PetscReal *u, PetscReal *centre);

/* ---- rocking.c */
/* The hinge about which a free-standing column turns over in time; part 0: none, or one on a rigid edge. */
typedef struct {
  PetscReal part;     /* [-] of its arm that is missing, because tptm presses the hinge over a length */
  PetscInt body, n;   /* the macroblock that stands on it; macroblocks that turn over together */
  PetscReal point[2]; /* [m] edge of the joint */
} RockingHinge;
/* Collective. Finds it by the contacts of now, after BodyMotionCreate. */
PetscErrorCode RockingHingeFind(const Problem *p, RockingHinge *hinge);
PetscErrorCode RockingHingeArchive(Archive *archive, RockingHinge *hinge);

/* ---- result.c */
typedef struct {
  PetscReal X[2], u[2]; /* [m] of a named point: reference, displacement */
} Probe;
/* What a stage finds, besides its StageResult. */
typedef struct _p_Result {
  PetscBool joints_only;  /* a request: verdicts and numbers of joints are all that is asked for, so nobody
                             sees the inside of condensed bodies and mechanisms, and none is found */
  Ground ground;          /* of the run: the motion that supports share */
  PetscBool ground_moves; /* all supports that move do so alike, in a scene with a dynamic stage */
  MeshFields mesh;        /* rank 0, while fields are gathered */
  Probe *probes;          /* (n_points,) at the last call of ResultProbes; the same on all ranks */
  Trials trials;          /* of a stage of trials; of any stage its mechanism */
  Vibration vibration;    /* of a stage of modes */
  BodyMotion bodies;      /* of a dynamic stage */
  RockingHinge rocking;   /* likewise, where its bodies turn over */
  Histories histories;    /* likewise */
  Envelope envelope;      /* likewise */
} Result;
/* Makes room for the probes of a zeroed result. */
PetscErrorCode ResultCreate(const Model *model, Result *result);
/* Forgets what the last stage has found; joints_only, ground and probes stay. */
PetscErrorCode ResultReset(Result *result);
PetscErrorCode ResultDestroy(Result *result);
/* Collective. Updates the probes, and finds the largest displacement [m]. */
PetscErrorCode ResultProbes(const Problem *p, PetscReal *u_max);

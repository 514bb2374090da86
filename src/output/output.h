/* output.h: declares all output for users: a stage gathered on rank 0, its safety factors, results.h5,
   results.xdmf, summary.json, history.csv, the results of trials, lines on the terminal. */
#pragma once
#include "output/history_file.h"
#include "output/rocking.h"

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
enum {
  VERTEX_WIDTH = 8, /* u x,y [m]; reaction x,y [N], 0 where free; applied force x,y [N]; forces of rigid
                       vertices: 0; row of the support that holds x, y, -1: none */
  BODY_WIDTH = 11, /* u x,y [m], rotation [rad]; reaction x,y [N], moment [N m]; applied likewise; rows of the
                      supports of x, y */
  BLOCK_MEASURE = 23, /* first column of the results of material laws */
  BLOCK_OPENING = BLOCK_MEASURE + MATERIAL_LAWS - 1,
  BLOCK_LOST,
  BLOCK_WIDTH /* sxx syy sxy s1 s2 [Pa], angle [rad], strain energy [J], rotation [rad], Gauss stresses
                 (4,3) [Pa], change of temperature [K], stress across the plane [Pa], 1: it is built; of each
                 law but the elastic one its measure (laws.h) [-]; width of a crack [m]; energy lost for good
                 [J]; NaN where the kind of block has none */
};
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
typedef struct {
  PetscReal time;                       /* [s] of dynamic stages */
  PetscInt n_contacts, n_bodies, n_dof; /* of the whole model */
  PetscReal *vertex;                    /* (n_vertices, VERTEX_WIDTH) */
  PetscReal *body;                      /* (n_bodies, BODY_WIDTH) rigid bodies by number */
  PetscReal *block;                     /* (n_blocks, BLOCK_WIDTH) */
  ContactRow *contact;                  /* (n_contacts,) ascending faces */
  PetscReal *safety;                    /* (n_blocks,) least of (39)-(41), NaN without strengths; safety.c */
  PetscInt *safety_mode;                /* (n_blocks,) SafetyMode; both NULL when no material has strengths */
  PetscReal *mechanism;                 /* (n_vertices,2) velocity at collapse, largest 1; NULL: none */
  PetscInt n_modes;
  PetscReal *modes;            /* (n_vertices, n_modes, 2) shapes; NULL: none */
  PetscReal *envelope_block;   /* (n_blocks, ENVELOPE_BLOCK); NULL: the stage has no envelopes */
  PetscReal *envelope_contact; /* (n_contacts, 2 ends, ENVELOPE_END) */
  PetscInt64 envelope_samples, envelope_every;
  PetscInt n_tables;
  TermTable *tables; /* (n_tables,) of force terms, TermsTables; rank 0 */
} StageFields;
/* These functions are collective. */
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
/* Gathers the mechanism of the trials: (n_owned,2) on each rank; does nothing if NULL on all ranks. */
PetscErrorCode GatherMechanism(const Model *model, const PetscReal *mechanism, StageFields *fields);

/* ---- envelope.c */
/* Columns of a block; NaN: it has no such stress or strength. */
enum {
  ENVELOPE_S1,         /* [Pa] largest s1, its time [s] */
  ENVELOPE_S2 = 2,     /* [Pa] least s2, its time */
  ENVELOPE_FACTOR = 4, /* [-] least safety factor, its time */
  ENVELOPE_MODE = 6,   /* SafetyMode of that */
  ENVELOPE_BLOCK
};
/* Columns of the end of a contact. */
enum {
  ENVELOPE_SIGMA_MAX, /* [Pa] */
  ENVELOPE_SIGMA_MIN, /* [Pa] */
  ENVELOPE_OPENING,   /* [m] largest */
  ENVELOPE_SLIP,      /* [m] largest size */
  ENVELOPE_END
};
/* Extremes over the samples of a dynamic stage, of this rank. */
typedef struct {
  PetscInt every; /* steps between samples; 0: none, and all arrays are NULL */
  PetscInt64 samples;
  PetscInt n_blocks;
  PetscInt *gid, *file; /* (n_blocks,) owned blocks, those that deform first */
  PetscReal *block;     /* (n_blocks, ENVELOPE_BLOCK) */
  PetscInt n_rows;
  PetscReal *row; /* (n_rows, 2 keys and 2 ENVELOPE_END) of contacts that are or were, ascending keys */
  PetscInt *at;   /* (n_padded,) row of each contact, -1: not owned; NULL: contacts have changed */
} Envelope;
PetscErrorCode EnvelopeCreate(const Problem *p, Envelope *envelope);
PetscErrorCode EnvelopeDestroy(Envelope *envelope);
/* To be called when contacts have been found again. */
PetscErrorCode EnvelopeContactsChanged(const Problem *p);
/* Samples the forces just evaluated. */
PetscErrorCode EnvelopeTake(const Problem *p);
/* Collective. Archives the envelope, see archive.h. The contacts must have been read before. */
PetscErrorCode EnvelopeArchive(Archive *archive, const Problem *p);
/* Collective. Fills in the envelopes of a stage whose contacts have been gathered. */
PetscErrorCode EnvelopeGather(const Problem *p, StageFields *fields);

/* ---- safety.c */
/* Returns whether the material has a strength, so that blocks have a factor. */
PetscBool MaterialHasStrengths(const Material *material);
typedef enum { SAFETY_NONE, SAFETY_TENSION, SAFETY_COMPRESSION, SAFETY_SHEAR } SafetyMode;
/* Finds the least of (39)-(41) for principal stresses s1 >= s2 [Pa], and its mode; infinite when nothing can
   fail. */
SafetyMode SafetyFactor(const Material *material, PetscReal s1, PetscReal s2, PetscReal *factor);
/* Computes fields->safety and safety_mode when a material has strengths. */
PetscErrorCode SafetyFields(const Scene *scene, const MeshFields *mesh, StageFields *fields);
/* Writes the "safety" member of a stage's object. */
void SummarySafety(FILE *f, const Scene *scene, const MeshFields *mesh, const StageFields *fields);
/* Returns the area of a block [m2]. centre: the mean of its vertices [m]. */
PetscReal MeshBlockArea(const MeshFields *mesh, PetscInt block, PetscReal centre[2]);

/* ---- yielding.c */
/* Returns whether some of the n blocks have a number in a column of StageFields.block. */
PetscBool BlockHas(PetscInt n, const PetscReal *block, int column);
/* Rank 0. Writes the state of blocks with a law that is not elastic, by group, into summary.json. */
void SummaryLaws(FILE *f, const Scene *scene, const MeshFields *mesh, const StageFields *fields);

/* ---- output_selection.c */
typedef struct {
  PetscBool partly;         /* some rows are left out; false: mesh is *all, and the lists are NULL */
  MeshFields mesh;          /* rows that are written, in the order of model.h5; file: NULL when partly */
  PetscInt *block, *vertex; /* (mesh.n_blocks,), (mesh.n_vertices,) selected numbers in model.h5 */
  PetscInt *block_row, *vertex_row; /* (all blocks,), (all vertices,) row among the written ones, -1: none */
} OutputSelection;
/* `all` must live as long as `written`. */
PetscErrorCode OutputSelectionCreate(const Scene *scene, const MeshFields *all, OutputSelection *written);
PetscErrorCode OutputSelectionDestroy(OutputSelection *written);
/* Selects the rows of a stage; a face or vertex of a contact that is not selected gets the number -1. */
PetscErrorCode SelectedStage(const OutputSelection *written, const StageFields *all, StageFields *some);
PetscErrorCode SelectedStageDestroy(const OutputSelection *written, StageFields *some);
/* Returns a checksum of the selection of blocks; 0: everything is written. */
uint64_t OutputSelectionChecksum(const OutputSelection *written);

/* ---- results_file.c */
typedef struct {
  const char *folder;
  const Scene *scene;
  const Model *model;      /* names only */
  OutputSelection written; /* while a file is being written */
  uint64_t choice;         /* OutputSelectionChecksum */
  uint64_t run;            /* the run that writes: CheckpointRun, after a restart CheckpointGoesOn */
  uint64_t origin;         /* the run of the checkpoint, whose files it takes over; else run */
  char *xdmf;              /* grids of the stages written so far */
  char **stages;           /* texts of Output; NULL: the stage was skipped */
  PetscInt n_frames;       /* frames of the present stage, each in a file of its own until the stage ends */
  PetscBool has_part;      /* results.h5.part has all stages so far, results.h5 has fewer */
  int64_t part;            /* results.h5.part, open while stages are added (hid_t); 0: closed */
  int failed;              /* errno of the first write into it that failed */
} ResultsFile;
/* Writes the mesh into results.h5.part. */
PetscErrorCode ResultsFileCreate(ResultsFile *file, char message[MESSAGE_LENGTH]);
/* Writes a frame into <stage>_<frame>.h5, where it stays until the stage ends; not while stages wait for
   ResultsFileFinish. */
PetscErrorCode ResultsFileFrame(ResultsFile *file, PetscInt stage, PetscInt frame, const StageResult *result,
                                const StageFields *fields, char message[MESSAGE_LENGTH]);
/* Adds the end of a stage and its frames to results.h5.part. ResultsFileFinish reports a failure. */
PetscErrorCode ResultsFileStage(ResultsFile *file, PetscInt stage, const StageResult *result,
                                uint64_t checksum, const StageFields *fields);
/* Replaces results.h5 by the finished file if stages have been added, then writes results.xdmf. stage: the
   last one in the file. */
void ResultsFileFinish(ResultsFile *file, PetscInt stage, char message[MESSAGE_LENGTH]);
/* Continues results.h5 after a restart if it has any of the first n stages, else starts a new file; warns of
   stages and frames that are lost and forgets their grids. */
PetscErrorCode ResultsFileResume(ResultsFile *file, PetscInt n, char message[MESSAGE_LENGTH]);
PetscErrorCode ResultsFileDestroy(ResultsFile *file);

/* ---- results_there.c */
/* To be called before a restart continues after n stages. Refuses results.h5 of another run, and by `auto`
   also a loss of stages or frames. Frames of another run do not count. */
PetscErrorCode ResultsFileCheck(const ResultsFile *file, PetscInt n, char message[MESSAGE_LENGTH]);

/* ---- xdmf.c */
/* Returns the number of entries of the mixed topology: the cell type before the vertices of each block. */
PetscInt XdmfTopologySize(const MeshFields *mesh);
/* Appends the grids of a stage, or of a frame of it, to results->xdmf; 0 or -1. name: its group in
   results.h5. */
int XdmfAddStage(ResultsFile *results, PetscInt stage, const char *name, const StageFields *fields);
/* Whether it has the grids of that group (a walk in order checks from *from on first); and takes them out. */
PetscBool XdmfHas(const ResultsFile *results, const char *name, const char **from);
void XdmfDrop(ResultsFile *results, const char *name);
/* Writes results.xdmf from all grids so far, in one replacement. */
void XdmfWrite(const ResultsFile *results, char message[MESSAGE_LENGTH]);
/* ---- trials.c */
typedef struct {
  PetscReal friction;        /* [degree] before it was reduced */
  PetscReal stable, failing; /* [-] tan(friction) over that of the last stable, the first failing trial */
  PetscBool reduced;         /* it has contacts and friction, and the stage reduces it */
} JointFactor;
typedef struct {
  PetscInt n;
  char **json;               /* rank 0: (n,) one object each */
  PetscReal stable, failing; /* the bracket; NaN: no such trial */
  PetscReal open;            /* value nearest to stable whose trial has no verdict; NaN: there is none */
  PetscReal moved, most;     /* [m] way of the last stable trial; a trial that goes farther fails */
  JointFactor *joints;       /* (n_joints,) after a reduction of friction; NULL: there was none */
  PetscInt one;              /* joint whose factors are those of the stage, -1: there is no single factor */
  PetscReal *mechanism;      /* (n_owned,2) velocities of the failing trial, largest 1; NULL: none fails */
  PetscReal *joint_motion;   /* (n_joints,2) JointMotion of each joint in it; NULL likewise */
  TermTable loads;           /* LoadsTable, where trials or steps change loads; name NULL: no table */
} Trials;
/* Collective. Keeps the result of the trial of this value, which has just run, in p->output and prints it.
   moved: largest displacement [m] since the stage began. */
PetscErrorCode TrialsAdd(const Problem *p, PetscReal value, PetscReal moved);
/* Finds the factors of a reduction of friction, joint by joint. full: the joints before; has: (n_joints,)
   ReducedJoints. */
PetscErrorCode TrialsFactors(const Problem *p, const Joint *full, const PetscInt *has);
/* Says what the stage's single factor is, or why it has none; "" when there is nothing to say. */
void TrialsReport(const Problem *p, size_t size, char *text);
PetscErrorCode TrialsReset(Trials *trials);
/* Writes the members of a stage's object in summary.json; of a transient stage its steps. */
void SummaryTrials(FILE *f, const Scene *scene, const Stage *stage, const Trials *trials);

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
/* [Hz]; NaN of a motion that grows. */
PetscReal VibrationHertz(const Vibration *v, PetscInt mode);
/* [kg] The effective mass of a mode along x (0) or y (1). */
PetscReal VibrationMass(const Vibration *v, PetscInt mode, int x);
/* Rank 0. Prints the modes of a stage that is over, and what they belong to. */
void VibrationReport(const Problem *p);
/* Writes the "modes" member of a stage's object, if it has any. */
void SummaryVibration(FILE *f, const Vibration *v);
/* Collective. The shapes to rank 0. */
PetscErrorCode GatherVibration(const Model *model, const Vibration *v, StageFields *fields);

/* ---- mechanism.c */
enum JointMotion { JOINT_SLIDES, JOINT_OPENS }; /* largest speeds, closed and open; of the fastest vertex */
/* Whether a joint slides, or opens, in the mechanism. */
PetscBool MechanismHas(const Scene *scene, const Trials *trials, PetscInt joint, enum JointMotion motion);
void SummaryMechanism(FILE *f, const Scene *scene, const Trials *trials);

/* ---- ground_motions.c */
/* Rank 0. Writes motion_<name>.csv for each motion that the scene scales or corrects. */
void MotionsWrite(const Scene *scene, const char *folder, char message[MESSAGE_LENGTH]);

/* ---- hinges.c */
/* Joints between two bodies that are closed over less than half of their face, with tptm. */
typedef struct {
  PetscInt n;
  PetscReal least, point[2]; /* [-] least compressed length of a joint over its face; [m] place of it */
  PetscReal governing;       /* [-] mean of the hinges that turn in a mechanism; NaN: not known */
} Hinges;
Hinges HingesOf(const Problem *p, const StageFields *fields);
/* Writes the "hinges" member of a stage or trial, if it has hinges. */
void SummaryHinges(FILE *f, const Hinges *hinges);

/* ---- peaks.c */
/* Extremes of series in time. */
typedef struct {
  PetscReal first, last;          /* values; NaN: none yet */
  PetscReal least, largest;       /* values */
  PetscReal least_at, largest_at; /* [s] the first time of each */
} Peak;
enum { PEAK_REALS = sizeof(Peak) / sizeof(PetscReal) };
/* value: NaN is passed over. */
void PeakTake(Peak *peak, PetscReal value, PetscReal time);
/* Write "name": {...} and what follows: least and largest with their times; the largest, where `ends` is
   true in size, beside the first and last value; the least alone. */
void PeakRange(FILE *f, const char *name, const Peak *peak, const char *tail);
void PeakLargest(FILE *f, const char *name, const Peak *peak, PetscBool ends, const char *tail);
void PeakLeast(FILE *f, const char *name, const Peak *peak, const char *tail);

/* ---- histories.c */
/* What checks of a joint see; columns of joint_history.csv. */
enum {
  LOOK_N,               /* [N] normal force, compression positive */
  LOOK_T,               /* [N] shear force */
  LOOK_FACTOR_PEAK,     /* [-] against sliding */
  LOOK_FACTOR_RESIDUAL, /* [-] */
  LOOK_SLIP,            /* [m] mean over the length */
  LOOK_SLIP_LARGEST,    /* [m] of an end */
  LOOK_OPENING,         /* [m] largest of an end */
  LOOK_OPEN,            /* [m] open length */
  LOOK_LENGTH,          /* [m]; NaN: the joint has no contacts */
  LOOK_COLUMNS
};
/* What checks of a dynamic stage have seen; alike on all ranks where nothing else is said. */
typedef struct {
  PetscInt n_joints, n_supports, n_points;
  PetscReal *direction; /* (n_joints,2) from start to end of joints that were lines when the stage began;
                            0, 0: of another */
  PetscReal *carried;   /* [m] (n_joints,) mean slip of contacts that have been found anew since */
  PetscReal *joint;     /* (n_joints, LOOK_COLUMNS) of the last look */
  PetscReal every, joint_time; /* [s] between checks; of the last one, NaN: its rows are written */
  PetscReal *support;    /* [N] (n_supports,2) force of each on the model at the last look; NULL: no stage in
                            time runs */
  int16_t *lets_through; /* (n_dof,) this rank: row of the support whose boundary lets waves out there, -1:
                            none */
  Peak *joint_peak;      /* (n_joints, LOOK_COLUMNS) */
  Peak *support_peak;    /* (n_supports + 1,2) the last of all together */
  Peak *probe_peak;      /* (n_points,4) u x,y; over the ground x,y */
  PetscInt n_things;     /* numbers of a look at things that terms have names of */
  TermRecord things;     /* the last look at them */
  PetscReal things_time; /* [s] of it; NaN: its rows are written */
  Peak *things_peak;     /* (n_things,) */
} Histories;
/* Empty ones for the dynamic stage that begins. */
PetscErrorCode HistoriesCreate(const Problem *p, Histories *histories);
PetscErrorCode HistoriesDestroy(Histories *histories);
/* Collective. Looks at joints, and at what else has names, at the forces just evaluated. */
PetscErrorCode HistoriesSample(const Problem *p);
/* Rank 0. Writes the rows of the last look, once. */
void HistoriesRows(const Problem *p);
/* Collective. Finds which joints are lines, at the start of the stage. */
PetscErrorCode HistoriesBegin(const Problem *p);
/* Collective, see archive.h. */
PetscErrorCode HistoriesArchive(Archive *archive, const Problem *p);
/* Takes the probes of now into the peaks of a dynamic stage. */
void HistoriesOfProbes(const Problem *p);
/* Writes the "peaks" member of a stage's object. */
void SummaryPeaks(FILE *f, const Problem *p);

/* ---- joint_history.c */
void JointHistoryHeader(FILE *f);
/* Collective. Looks at all joints, at the forces just evaluated; their present place is that of these
   forces. */
PetscErrorCode JointHistorySample(const Problem *p);
/* Collective. Call it with 1 before contacts are found anew, with -1 after it, forces evaluated: slip goes on
   from where it was. */
PetscErrorCode JointSlipsCarry(const Problem *p, PetscReal sign);
/* Rank 0. Writes the rows of the last look, once. */
void JointHistoryRows(const Problem *p);

/* ---- term_history.c */
/* Collective. Looks at what terms have names of. */
PetscErrorCode TermHistorySample(const Problem *p);
/* Rank 0. */
void TermHistoryHeader(FILE *f);
void TermHistoryRows(const Problem *p);
/* Writes the "anchors" member of the peaks. */
void TermHistoryPeaks(FILE *f, const Problem *p);

/* ---- support_forces.c */
/* Finds where boundaries let waves out; again on a new partition. */
PetscErrorCode SupportForcesBegin(const Problem *p);
/* Collective. After a step: the force of each support on the model at the forces just evaluated. v_before:
   velocities before the step; ground: [m/s] what alpha damps against. */
PetscErrorCode SupportForcesSample(const Problem *p, const PetscReal *v_before, const PetscReal ground[2]);

/* ---- body_motion.c */
typedef enum { BODY_OVERTURNED, BODY_FALLEN, BODY_SLID, BODY_FATES } BodyFate;
/* What has become of all macroblocks, the same on all ranks. */
typedef struct {
  PetscInt n;
  PetscReal *centre;  /* [m] (n,2) mass centre in the mesh */
  PetscReal *balance; /* [rad] (n,2) rotations, anticlockwise and clockwise, that lay it on another side */
  PetscReal *mass;    /* [kg] (n,) */
  PetscReal *size;    /* [m] (n,2) width and height in the mesh; 0: a support holds it, so it is not judged */
  PetscReal *since;   /* [s] (n,BODY_FATES) when each happened first; infinite: it has not */
  PetscReal *moved;   /* [m] (n,2) way of the mass centre over the ground, at the last look */
  PetscReal *turned;  /* [rad] (n,) rotation at the last look, anticlockwise */
  PetscInt *group;    /* (n,) group of the bodies that are judged */
} BodyMotion;
/* Collective. Sets up from the mesh; nothing has happened yet. */
PetscErrorCode BodyMotionCreate(const Model *model, BodyMotion *bodies);
PetscErrorCode BodyMotionDestroy(BodyMotion *bodies);
/* Collective. Judges the bodies by the present displacements, at the present time. */
PetscErrorCode BodyMotionSample(const Model *model, const State *state, BodyMotion *bodies);
/* The macroblock to which this happened first, -1: to none. n: to how many it happened. */
PetscInt BodyMotionFirst(const BodyMotion *bodies, BodyFate fate, PetscInt *n);
/* Says it for the evidence; "" when nothing has happened. */
PetscErrorCode BodyMotionReport(const Model *model, const BodyMotion *bodies, size_t size, char *text);
/* Collective, for fixed connectivity. Warns of bodies without contacts, at the start.  Finds the first two
   blocks that overlap deeper than closed joints and the mesh explain, "" when none do. */
PetscErrorCode BodiesLoose(const Problem *p);
PetscErrorCode BodiesPassed(const Problem *p, char message[MESSAGE_LENGTH]);
/* Writes the "bodies" member of a stage's object. */
void SummaryBodies(FILE *f, const Model *model, const BodyMotion *bodies);
/* Collective. Mass centre of every macroblock [m] (n_bodies_global,2) with displacements u of the dofs; NULL:
   in the mesh. */
PetscErrorCode BodyCentres(const Model *model, const PetscReal *u, PetscReal *centre);

/* ---- terminal.c */
/* Rank 0. Whether it is time for a line that says where the stage is: every ten seconds, on a terminal twice
   a second. Prints that line; takes it off a terminal. */
PetscBool StageShows(const Problem *p);
void StageShow(const Problem *p, const char *what);
void StageShowEnd(const Problem *p);
/* Rank 0, when it is time: how far a stage in time is, [-] of its duration, its speed, what is left. */
void StageShowTime(const Problem *p, PetscReal part);
/* Prints how a stage ended. */
PetscErrorCode StageReport(const Problem *p);

/* ---- output.c */
typedef struct _p_Output {
  char folder[PETSC_MAX_PATH_LEN];
  PetscInt n_stages;                /* stages that are over */
  PetscInt n_settled;               /* rank 0: finished stages that the files with their final names hold */
  PetscBool settled;                /* the files hold all finished stages: a checkpoint is due */
  double settle_wall;               /* rank 0: [s] that these files took to write last */
  PetscInt n_contacts;              /* contacts at the end of the last stage */
  PetscInt n_dofs;                  /* degrees of freedom at that end */
  char **stages;                    /* rank 0: (n_stages,) their objects in summary.json; NULL: it was not
                                         run, because the stage from which it starts has failed */
  PetscReal *probes;                /* (n_points,4) x y [m], u_x u_y [m]; the same on all ranks */
  MeshFields mesh;                  /* while a file is being written */
  ResultsFile results;              /* rank 0 */
  HistoryFile files[HISTORY_FILES]; /* rank 0; name NULL: this run has none */
  Histories histories;              /* of the dynamic stage that runs */
  Envelope envelope;                /* likewise */
  Ground ground;                    /* that supports move */
  PetscBool ground_moves;           /* all supports that move do so alike, in a scene with a dynamic stage */
  uint64_t program_checksum;        /* rank 0: FileChecksum of the program that runs; 0: it cannot be read */
  int lock;                         /* rank 0: lock of the folder, -1: none */
  PetscBool joints_only;            /* verdicts and numbers of joints are all that is asked for: nobody sees
                                       the inside of condensed bodies and mechanisms, and none is found */
  Trials trials;                    /* trials of the stage that runs */
  BodyMotion bodies;                /* bodies of the dynamic stage that runs */
  RockingHinge rocking;             /* likewise, where its bodies turn over */
  Vibration vibration;              /* of the stage of modes that runs */
  struct _p_Checkpoint *checkpoint;
  void *memory; /* output.c: memory for the checkpoint */
} Output;
/* Makes the folder of the scene and keeps other runs out of it until OutputClose. A folder that cannot be
   written, or that another run writes into, is refused. `output` must be zero before. */
PetscErrorCode OutputLock(MPI_Comm comm, const Scene *scene, Output *output);
/* Starts results.h5.part and the histories; after a restart, goes on with the files that are there. Call
   after OutputLock, when set-up has succeeded. Results of an older run stay until the first stage is
   complete. `output` must not move in memory. */
PetscErrorCode OutputOpen(const Scene *scene, const Model *model, struct _p_Checkpoint *checkpoint,
                          Output *output);
/* Writes a row of history.csv and the rows of joint_history.csv that a check has left, or these alone. */
PetscErrorCode OutputHistory(const Problem *p);
PetscErrorCode OutputJointHistory(const Problem *p);
/* Writes a frame of a dynamic stage, from 1. The contacts must be those of the present displacements. */
PetscErrorCode OutputFrame(const Problem *p, PetscInt frame);
/* Writes the end of a stage, whatever its verdict: results.h5, results.xdmf, summary.json; history.csv
   takes its name. Many short stages wait for a later stage or a checkpoint: then the files are not
   `settled`. */
PetscErrorCode OutputStage(const Problem *p);
/* The stage that comes next is not run. */
void OutputPass(Output *output);
/* Collective. Writes the files, where they do not hold all stages yet. */
PetscErrorCode OutputSettle(const Scene *scene, const Model *model, Output *output);
/* message: what could not be written at the last moment; "" when nothing failed. */
PetscErrorCode OutputClose(Output *output, char message[MESSAGE_LENGTH]);

/* ---- result_query.c */
/* One rank. Numbers of the stage that is over, by their paths in its object in summary.json, such as
   joints.base.sliding_factor_peak; NaN: there is none. */
PetscErrorCode ResultQuery(const Problem *p, PetscInt n, char *const *paths, PetscReal *values);
/* Whether a path asks for more than a number of a joint. */
PetscBool ResultQueryBeyondJoints(PetscInt n, char *const *paths);

/* ---- summary.c */
/* Makes the JSON object of a stage with mesh, probes and trials of p->output; free it with free(). checksum:
   of the whole state, and without what is inside condensed bodies. */
PetscErrorCode SummaryStage(const Problem *p, const StageFields *fields, const uint64_t checksum[2],
                            char **json);
PetscErrorCode SummaryWrite(const Scene *scene, const Model *model, const struct _p_Output *output,
                            char message[MESSAGE_LENGTH]);

/* ---- summary_joints.c */
/* Rank 0. direction: (n_joints,2) from start to end of joints whose contacts are a line; 0, 0: of others. */
void JointDirections(PetscInt n_joints, const StageFields *fields, PetscReal *direction);
/* [-] Strength over demand, for forces N and T [N] and the closed length [m]; residual 0: of the peak
   strength, 1: of the residual; NaN of an elastic joint. */
PetscReal SlidingFactor(const Joint *joint, PetscReal N, PetscReal T, PetscReal closed, PetscReal thickness,
                        int residual);
/* Writes the "joints" member of a stage's or trial's object, from its joints table; factors only at rest. */
PetscErrorCode SummaryJoints(FILE *f, const Problem *p, const StageFields *fields);

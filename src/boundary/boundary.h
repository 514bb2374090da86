/* boundary.h: declares supports, their motion, and boundaries that let waves out. */
#pragma once
#include "term/term.h"

/* ---- support_keys.c */
/* Checks the keys of a motion; completes the keys of a support, see reader.h. */
PetscErrorCode CompleteMotion(Reader *r, const char *path, const GroundMotion *motion);
PetscErrorCode CompleteSupport(Reader *r, const char *path, Support *support);

/* ---- supports.c */
/* Collective. Writes model->support from the scene's supports. in_time: supports whose boundary lets waves
   out do not hold. */
PetscErrorCode SupportsApply(const Scene *scene, PetscBool in_time, Model *model);
/* Collective, while supports hold as in static stages. Refuses dynamic stages in which nothing can move:
   they would have no time step. */
PetscErrorCode SupportsCheckMotion(const Scene *scene, const Model *model);

/* ---- motion.c */
/* Motion of the ground from a file, over time [s] since the start of the file. */
typedef struct {
  PetscInt n;         /* rows; 0: no motion */
  const PetscReal *t; /* (n,) [s]; owned by the scene */
  PetscReal *row;     /* (n,4) displacement [m] at a row and, just after it, its three derivatives */
} MotionTrack;
typedef struct {
  MotionTrack along[2]; /* x, y */
} Motion;

/* Creates the motion of a support; one without a motion is at rest. */
PetscErrorCode MotionCreate(const Support *support, Motion *motion);
PetscErrorCode MotionDestroy(Motion *motion);
PetscBool MotionMoves(const Motion *motion);
/* Decides whether all numbers are finite: sums of finite numbers may overflow. */
PetscBool MotionIsFinite(const Motion *motion);
/* Returns the displacement [m] along x (k = 0) or y (1); MotionVelocity returns the velocity [m/s]. The
   ground is at rest before the first row and from the last row on. */
PetscReal MotionPlace(const Motion *motion, PetscReal t, int k);
PetscReal MotionVelocity(const Motion *motion, PetscReal t, int k);
/* Returns the velocity [m/s] that moves the ground in a step dt from its place at time `from` to that at
   `to`. So displacements follow the record whatever the step. */
PetscReal MotionMean(const Motion *motion, PetscReal from, PetscReal to, PetscReal dt, int k);

/* Extreme and final values of a record. Accelerations are rows, or slopes of velocities. */
typedef struct {
  PetscReal largest[3]; /* displacement [m], velocity [m/s], acceleration [m/s2] */
  PetscReal end[2];     /* displacement, velocity at the last row */
  PetscReal t_end;      /* [s] */
} MotionFacts;
MotionFacts MotionSample(const MotionTrack *track);

/* ---- ground.c */
/* Motion of the ground as a whole: the one motion of all moving supports. */
typedef struct {
  Motion motion;
  PetscReal part; /* [-] factor of the motion: GroundPart */
} Ground;
/* Returns the factor [-] of free ground over the motion of a support: 2 for an incident wave, else 1. */
PetscReal GroundPart(const Support *support);
/* Creates the motion of the ground. message receives a refusal if supports move differently. */
PetscErrorCode GroundCreate(const Scene *scene, Ground *ground, char message[MESSAGE_LENGTH]);
PetscErrorCode GroundDestroy(Ground *ground);
/* Returns the velocity [m/s] (2,) at a time since the start of the motion. */
void GroundVelocity(const Ground *ground, PetscReal t, PetscReal v[2]);
/* Returns the displacement [m] (2,) at this time. */
void GroundPlace(const Ground *ground, PetscReal t, PetscReal u[2]);

/* ---- support_motion.c */
/* Force term: supports that move in dynamic stages. */
extern const TermKind Supports_term;

/* ---- quiet.c */
/* Force term: supports that let waves out in dynamic stages. */
extern const TermKind Quiet_term;
/* Returns the group of the ground behind a support that lets waves out; -1: the group of each of its
   faces. */
PetscInt HalfSpaceOf(const Model *model, const Support *support);
/* Adds the dashpots [N s/m] of a support that lets waves out, or of all (NULL), to sum (2 n_deformable,
   2): two rows per owned vertex. */
void QuietDashpots(const Scene *scene, const Model *model, const Support *only, PetscReal (*sum)[2]);

/* ---- column.c */
typedef struct {
  PetscReal density; /* [kg/m3] */
  Lame lame;
  PetscReal beta; /* [s] of its group; NaN: beta of the stage */
} Layer;
/* Free ground beside a side of the model, the same on all ranks. */
typedef struct {
  PetscInt n;             /* levels, lowest first */
  PetscReal x, *y;        /* [m] x of the side; (n,) y of the levels */
  PetscInt *gid;          /* (n,) vertices of the side at the levels */
  Layer *layer;           /* (n - 1,) between levels */
  PetscInt support, base; /* rows of scene->supports: the side; the base through which the earthquake comes */
  PetscBool quiet;        /* the base lets waves out and in; else it prescribes the motion */
  PetscReal times;        /* [-] GroundPart of the base */
  Layer half_space;       /* ground below the base; density 0: as the lowest layer */
  PetscReal *u, *v;       /* [m], [m/s] (2 n,) x and y of levels: now, and half a step before */
  PetscReal peak[2];      /* [m/s] largest velocity of the top in this stage */
  PetscReal beta;         /* [s] stiffness-proportional damping of the stage */
  PetscInt moved;         /* 1: moved in this stage, so v is a valid velocity for this damping */
  /* at the time of the last move */
  PetscReal *mean;   /* [m/s] (2 n,) */
  PetscReal *drive;  /* [m/s2] (2 n,) acceleration plus mass-proportional damping */
  PetscReal *stress; /* [Pa] (3 (n - 1),) xx, yy, xy */
} Column;
/* Input of a step of a column. */
typedef struct {
  PetscReal dt, part;  /* [s], [-] step, and fraction of it for velocities: Incoming */
  PetscReal alpha;     /* [1/s] */
  PetscReal ground[2]; /* [m/s] velocity relative to which alpha damps */
  PetscReal base[2];   /* [m/s] quiet base: velocity in its dashpots; else velocity of the base */
} ColumnStep;
PetscErrorCode ColumnCreate(PetscInt n, Column *column);
PetscErrorCode ColumnDestroy(Column *column);
void ColumnMove(Column *column, const ColumnStep *step);

/* ---- side.c */
/* Collective. Creates the columns beside all free-field sides. Refuses sides that a column cannot
   represent. */
PetscErrorCode ColumnsFind(const Scene *scene, const Model *model, PetscInt *n, Column **columns);
/* Returns the level of a column at local vertex v, -1: none. */
PetscInt ColumnLevel(const Model *model, const Column *column, PetscInt v);

/* ---- free_field.c */
/* Force term: sides beside which free ground continues in dynamic stages. */
extern const TermKind Free_field_term;

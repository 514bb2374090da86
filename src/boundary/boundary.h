/* boundary.h: supports and their motion. */
#pragma once
#include "term/term.h"

/* ---- supports.c */
/* Collective. Writes model->support from the scene's supports. in_time: those whose boundary lets waves
   out do not hold. */
PetscErrorCode SupportsApply(const Scene *scene, PetscBool in_time, Model *model);
/* Collective, when supports hold what they do at rest. Refuses dynamic stages in which nothing could move:
   nothing would set their step. */
PetscErrorCode SupportsCheckMotion(const Scene *scene, const Model *model);

/* ---- motion.c */
/* How the ground moves by a file, in time [s] since the start of the file. */
typedef struct {
  PetscInt n;         /* rows; 0: it does not move */
  const PetscReal *t; /* (n,) [s]; the scene's */
  PetscReal *row;     /* (n,4): displacement [m] at a row and, just behind it, its three derivatives */
} MotionTrack;
typedef struct {
  MotionTrack along[2]; /* x, y */
} Motion;

/* A support without a motion gives one that rests. */
PetscErrorCode MotionCreate(const Support *support, Motion *motion);
PetscErrorCode MotionDestroy(Motion *motion);
PetscBool MotionMoves(const Motion *motion);
/* Numbers that are finite may still add up to more than there are numbers. */
PetscBool MotionIsFinite(const Motion *motion);
/* Along x (k = 0) or y (1): how far it has moved [m], and how fast it moves [m/s]. Before the first row and
   from the last one on it rests. */
PetscReal MotionPlace(const Motion *motion, PetscReal t, int k);
PetscReal MotionVelocity(const Motion *motion, PetscReal t, int k);
/* [m/s] That carries it in a step dt from its place at one time to that at another, so that displacements are
   those of the record whatever the step. */
PetscReal MotionMean(const Motion *motion, PetscReal from, PetscReal to, PetscReal dt, int k);

/* What a record says of itself; accelerations are those of rows, or the slope of velocities. */
typedef struct {
  PetscReal largest[3]; /* displacement [m], velocity [m/s], acceleration [m/s2] */
  PetscReal end[2];     /* displacement, velocity of the last row */
  PetscReal t_end;      /* [s] */
} MotionFacts;
MotionFacts MotionSample(const MotionTrack *track);

/* ---- ground.c */
/* The motion of the ground as a whole: that of the supports that move. */
typedef struct {
  Motion motion;
  PetscReal part; /* [-] times it; GroundPart */
} Ground;
/* [-] How much free ground moves over the motion of a support: twice as much as a wave that comes in. */
PetscReal GroundPart(const Support *support);
/* Refuses, in message, supports that move differently: there is no one ground then. */
PetscErrorCode GroundCreate(const Scene *scene, Ground *ground, char message[MESSAGE_LENGTH]);
PetscErrorCode GroundDestroy(Ground *ground);
/* [m/s] (2,) at a time since the start of the motion. */
void GroundVelocity(const Ground *ground, PetscReal t, PetscReal v[2]);
/* [m] (2,) How far it has moved by then. */
void GroundPlace(const Ground *ground, PetscReal t, PetscReal u[2]);

/* ---- support_motion.c */
/* Supports that move in dynamic stages, as a force term. */
extern const TermKind Supports_term;

/* ---- quiet.c */
/* Supports that let waves out in dynamic stages, as a force term. */
extern const TermKind Quiet_term;
/* The group whose ground goes on behind a support that lets waves out; -1: that of each of its faces. */
PetscInt HalfSpaceOf(const Model *model, const Support *support);
/* [N s/m] (2 n_deformable, 2) Adds the dashpots of a support that lets waves out, or of all (NULL), at this
   rank's vertices: two rows each. */
void QuietDashpots(const Scene *scene, const Model *model, const Support *only, PetscReal (*sum)[2]);

/* ---- column.c */
typedef struct {
  PetscReal density; /* [kg/m3] */
  Lame lame;
  PetscReal beta; /* [s] of its group; NaN: that of the stage */
} Layer;
/* Free ground beside a side of the model, the same on all ranks. */
typedef struct {
  PetscInt n;             /* levels, lowest first */
  PetscReal x, *y;        /* [m] place of the side; (n,) of the levels */
  PetscInt *gid;          /* (n,) vertex of the side at a level */
  Layer *layer;           /* (n - 1,) between levels */
  PetscInt support, base; /* rows of scene->supports: its own; that from which the earthquake comes */
  PetscBool quiet;        /* that base lets waves out and in; else it holds and moves */
  PetscReal times;        /* [-] GroundPart of the base */
  Layer half_space;       /* ground below that base; density 0: that of the lowest layer */
  PetscReal *u, *v;       /* [m], [m/s] (2 n,) x and y of levels: now, and half a step before */
  PetscReal peak[2];      /* [m/s] largest velocity of the top in the stage */
  PetscReal beta;         /* [s] of the stage, damping by stiffness */
  PetscInt moved;         /* 1: in this stage, so v is a motion that such damping knows */
  /* of the last move, at its time */
  PetscReal *mean;   /* [m/s] (2 n,) */
  PetscReal *drive;  /* [m/s2] (2 n,) acceleration, with what takes the damping by mass */
  PetscReal *stress; /* [Pa] (3 (n - 1),) xx, yy, xy */
} Column;
/* What moves it. */
typedef struct {
  PetscReal dt, part;  /* [s], [-] the step, and how much of it velocities go on by: Incoming */
  PetscReal alpha;     /* [1/s] */
  PetscReal ground[2]; /* [m/s] what alpha damps against */
  PetscReal base[2];   /* [m/s] of a quiet base what its dashpots hold against, else its velocity */
} ColumnStep;
PetscErrorCode ColumnCreate(PetscInt n, Column *column);
PetscErrorCode ColumnDestroy(Column *column);
void ColumnMove(Column *column, const ColumnStep *step);

/* ---- side.c */
/* Collective. The columns beside all sides that are free fields; refuses what they cannot stand for. */
PetscErrorCode ColumnsFind(const Scene *scene, const Model *model, PetscInt *n, Column **columns);
/* Level of a column at which local vertex v is that of the side, -1: none. */
PetscInt ColumnLevel(const Model *model, const Column *column, PetscInt v);

/* ---- free_field.c */
/* Sides beside which free ground goes on in dynamic stages, as a force term. */
extern const TermKind Free_field_term;

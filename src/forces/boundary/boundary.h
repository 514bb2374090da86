/* boundary.h: supports and their motion. */
#pragma once
#include "forces/term/term.h"

/* ---- supports.c */
/* Collective. Writes model->support from the scene's supports. in_time: those whose boundary lets waves
   out do not hold. */
PetscErrorCode SupportsApply(const Scene *scene, PetscBool in_time, Model *model);

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

/* What a record says of itself; accelerations are those of rows, or the slope of velocities. */
typedef struct {
  PetscReal largest[3]; /* displacement [m], velocity [m/s], acceleration [m/s2] */
  PetscReal end[2];     /* displacement, velocity of the last row */
  PetscReal t_end;      /* [s] */
} MotionFacts;
MotionFacts MotionLook(const MotionTrack *track);

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

/* ---- support_motion.c */
/* Supports that move in dynamic stages, as a force term. */
extern const TermKind Supports_term;

/* ---- quiet.c */
/* Supports that let waves out in dynamic stages, as a force term. */
extern const TermKind Quiet_term;

/* bodies.h: declares the bodies that a rank owns as a whole: rigid ones and condensed ones. */
#pragma once
#include "mesh/mesh.h"

/* Rigid bodies owned here, with all their vertices. Owner: blocks/rigid.c. */
typedef struct {
  PetscInt n;
  PetscInt *gid;   /* (n,) macroblock-like number 0 .. n_rigid_global - 1, ascending */
  PetscInt *start; /* (n + 1,) first local vertex of each body */
  PetscReal *X;    /* [m] (n,2) mass centre in the reference state; lumped masses of deformable blocks at its
                      vertices count */
  PetscReal *mass; /* [kg, kg m2] (n,2) mass and moment of inertia about that centre (30) */
  PetscInt *body;  /* (n,) macroblock */
} RigidBodies;

enum { CONDENSING_LENGTH = 320 }; /* length of the text why groups are condensed, or not */
/* Condensed bodies owned here. Owner: blocks/condense.c; of the modes: blocks/condense_in_time.c. */
typedef struct {
  PetscInt n;
  struct _p_Condensed *body; /* (n,) ascending number */
  PetscInt dofs[2];          /* kept and inner degrees of freedom of the condensed bodies of all ranks */
  double wall;               /* [s] time for their factors, which are made once per run */
  double processor;          /* [s] time of the slowest rank's processor for them */
  PetscInt *mode_start; /* (n_condensed_global + 1,) number of modes of all bodies before each one; NULL: the
                           scene has no dynamic stage */
  PetscInt n_modes;     /* modes of the bodies owned here, body after body */
  PetscBool chosen;     /* the scene left the choice open, and groups are condensed */
  PetscBool large;      /* bodies are corrected for large strain: condense_large.c */
  PetscInt rounds;      /* corrections in the present stage or trial */
  const char *leave;    /* why the run must begin again with the blocks of the bodies; NULL: it need not */
  PetscBool lacks;      /* chosen, and MUMPS has no memory for the factors: no body can be used */
  char why[CONDENSING_LENGTH]; /* why groups are condensed, or not; empty: the scene leaves no choice open */
} CondensedBodies;

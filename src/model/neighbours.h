/* neighbours.h: declares the outer faces that a rank knows and the vertices that it reads from other ranks.
 */
#pragma once
#include "mesh/mesh.h"

/* An outer face as ranks send it to each other. */
typedef struct {
  PetscInt gid, group, body, rigid, joint; /* as in Faces */
  PetscInt v_gid[2], v_file[2], v_owner[2],
      v_index[2];       /* its two vertices: owner rank, and local index on that rank */
  PetscReal thick;      /* [m] reach of its block behind the face */
  PetscReal X[4], x[4]; /* [m] reference and present coordinates */
} FaceRecord;

/* A vertex that this rank reads but does not own. */
typedef struct {
  PetscInt gid, file, body, rigid, owner, index; /* owner rank, and local index on that rank */
  PetscReal X[2];                                /* [m] */
} GhostRecord;

/* Outer faces known here: of local blocks, then remote ones near them. Owner: neighbours.c. */
typedef struct {
  PetscInt n;        /* number of faces */
  PetscInt n_local;  /* the first n_local faces belong to blocks at owned vertices; loads and sets name
                        these */
  PetscInt capacity; /* allocated rows */
  PetscInt *vertex;  /* (n,2) local vertices, in the order of the block's ring */
  PetscInt *gid;     /* (n,) 4 * block gid + k, ascending among local and among remote faces */
  PetscInt *group;   /* (n,) group of the block */
  PetscInt *body;    /* (n,) macroblock of the block */
  PetscInt *rigid;   /* (n,) rigid body the block belongs to, -1: none */
  PetscInt *joint;   /* (n,) row of Scene.joints whose face set has the face, by joint_turn; -1: none */
  PetscReal *thick;  /* [m] (n,) reach of its block behind the face, in the reference state */
  PetscInt n_remembered;
  FaceRecord *remembered; /* (n_remembered,) far faces of groups that are not upgradeable */
} Faces;

/* Vertices of other ranks that this rank reads. Owner: neighbours.c; of the exchange: ghost.c. */
typedef struct {
  PetscInt n, n_element;     /* all; the first n_element belong to elements and couplings */
  GhostRecord *record;       /* (n,) in the order of their local vertices */
  struct _p_Ghost *exchange; /* the exchange of a cycle, NULL: one rank */
} Ghosts;

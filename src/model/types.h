/* types.h: the data dictionary of Quoin. Every array with its meaning, [unit], (shape) and who writes it.

   Conventions, stated once (tests/unit/test_conventions.c holds them):
   - SI units: m, N, Pa, kg, s; two dimensions, loads per metre of thickness times `thickness`.
   - Stress: tension positive. Contact opening u_n: positive when the faces part; sigma = k_n u_n.
   - Blocks run counter-clockwise; face k of a block runs from its vertex k to vertex k+1; its outward normal
     is to the right of that direction.
   - f is the RESISTING nodal force (what the model pushes back with: f = +int B'sigma dA for blocks), so the
     unbalanced force is r = f_ext - f. The paper's (8) and (10) use opposite signs; this is ours everywhere.
   - gid: number of a vertex, block or face in Quoin's own global order (bandwidth-reducing, the same for
     every number of ranks). Every sum over elements, contacts and bodies runs in ascending gid, so that
     results have the same bits on any number of ranks. "file id": the number in model.h5. */
#pragma once
#include "scene/scene.h"
#include <petscvec.h>
#include <petscsf.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE)
#error "Quoin needs a PETSc with real double-precision scalars"
#endif
/* PETSc 3.18 and what has changed since */
#if !defined(PETSC_SUCCESS) && PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#endif
#if PETSC_VERSION_LT(3, 22, 0)
typedef size_t SegmentCount; /* of a PetscSegBuffer */
#else
typedef PetscCount SegmentCount;
#endif
#if PETSC_VERSION_LT(3, 24, 0)
#define MPI_PETSC_BOOL MPIU_BOOL
#else
#define MPI_PETSC_BOOL MPI_C_BOOL
#endif

enum { BATCH = 8 }; /* elements and contacts are padded to whole batches of this many */

/* ------------------------------------------------------------------------------------------ BlockMesh
   model.h5 as it is, on rank 0 only (elsewhere only names and their counts are set, n_vertices and n_blocks
   are 0); written by MeshRead, renumbered by MeshReorder. */

typedef struct {
  char name[NAME_LENGTH];
  PetscInt n;
  PetscInt *faces; /* (n,2) block, k */
} FaceSet;

typedef struct {
  PetscInt n_vertices, n_blocks, n_groups, n_face_sets, n_points;
  PetscReal *X;          /* [m] (n_vertices,2) */
  PetscInt *blocks;      /* (n_blocks,4) ccw, -1 in the last column of a triangle */
  PetscInt *block_group; /* (n_blocks,) */
  PetscInt *body;        /* (n_blocks,) macroblock = connected component of blocks over shared vertices */
  PetscInt n_bodies;     /* number of macroblocks */
  PetscInt *part;        /* (n_blocks,) rank of each block, NULL: not dealt out yet */
  PetscInt *block_file, *vertex_file; /* file id of each block and vertex (identity until MeshReorder) */
  char (*group_names)[NAME_LENGTH];   /* on all ranks */
  PetscInt *group_rigid;              /* (n_groups,) on all ranks; the scene's override applied */
  FaceSet *face_sets;
  char (*point_names)[NAME_LENGTH];    /* on all ranks */
  PetscInt *point_vertex;              /* (n_points,) */
  char (*face_set_names)[NAME_LENGTH]; /* (n_face_sets) on all ranks */
} BlockMesh;

/* Which body a block belongs to, on rank 0: bodies of connected rigid blocks (MeshConnected), and of
   connected condensed ones (MeshCondensed). Either kind stays whole on one rank. */
typedef struct {
  PetscInt n_rigid, n_condensed;
  PetscInt *rigid, *condensed; /* (n_blocks,) number of the body, -1: none */
  PetscBool *inner;            /* (n_vertices,) of a condensed body, and not kept */
} BodyNumbers;

/* An outer face as it travels between ranks. */
typedef struct {
  PetscInt gid, group, body, rigid, joint; /* as in Faces */
  PetscInt v_gid[2], v_file[2], v_owner[2],
      v_index[2];       /* its two vertices: owner rank, and local index there */
  PetscReal thick;      /* [m] of its block behind the face */
  PetscReal X[4], x[4]; /* [m] reference and present coordinates */
} FaceRecord;

/* A vertex this rank reads but does not own. */
typedef struct {
  PetscInt gid, file, body, rigid, owner, index; /* owner rank, and local index there */
  PetscReal X[2];                                /* [m] */
} GhostRecord;

/* ---------------------------------------------------------------------------------------------- Model
   Flat arrays of one rank, constant during the run; written by model.c. Local order of vertices:
     [ owned deformable, by gid | owned rigid, by body then gid | owned inner of condensed bodies, by body
   then gid | ghosts of elements, by gid | further ghosts of contacts, by gid | DUMMY_VERTICES unit square ]
   The ghosts of contacts change when blocks move (neighbours.c); nothing before them does. Kept vertices of
   condensed bodies are deformable (or rigid) ones like any other. Degrees of freedom (what integrate.c
   steps): [ 3 per owned rigid body | 2 per owned deformable vertex ]. A dof array has the vertex array right
   behind its bodies: u_vertex = u + 3 n_bodies, so that for deformable vertices the dof IS the vertex entry.
   Inner vertices stand behind all that moves: no loop of a cycle meets them; condense.c fills them in
   afterwards. The dummies are where padding lanes of a batch point to. */

enum { DUMMY_VERTICES = 4 };

typedef struct {
  PetscInt n;           /* elements of this shape that touch an owned vertex */
  PetscInt n_padded;    /* n rounded up to a whole batch */
  StrainMeasure strain; /* as the scene says; condensed ones: small */
  PetscInt *vertex;     /* (n_padded / BATCH, 3 or 4, BATCH) local vertices */
  PetscInt *group;      /* (n_padded,) */
  PetscInt *gid;        /* (n,) block, ascending */
  PetscInt *file;       /* (n,) file id */
  bool *owned;          /* (n,) this rank writes it (its lowest-gid vertex is owned) */
} Elements;

typedef struct {
  PetscInt n;        /* outer faces known here: of local blocks, then of remote blocks near them */
  PetscInt capacity; /* rows that there is room for */
  PetscInt *vertex;  /* (n,2) local vertices, first and second along the block's ring */
  PetscInt *gid;     /* (n,) global number, ascending within each of the two; 4 * block gid + k */
  PetscInt *group;   /* (n,) of the block */
  PetscInt *body;    /* (n,) macroblock of the block */
  PetscInt *rigid;   /* (n,) rigid body the block belongs to, -1: none */
  PetscInt *joint;   /* (n,) row of Scene.joints whose face set holds it (the first such row), -1: none */
  PetscReal *thick;  /* [m] (n,) reach of its block behind the face, reference state */
} Faces;

/* Lame constants of the plane problem [Pa]: in plane stress lambda is reduced. */
typedef struct {
  PetscReal lambda, mu;
} Lame;

typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank, size;
  PetscInt n_vertices_global, n_blocks_global, n_bodies_global, n_rigid_global;
  PetscReal diameter;       /* [m] of the bounding box of the whole mesh */
  PetscReal contact_margin; /* [m] faces nearer than this may be in contact */
  PetscReal
      contact_depth; /* [m] deepest overlap or widest opening of a contact when contacts were last looked
                                for, 0: within the margin */
  PetscReal contact_pressed; /* [m] the overlap alone */

  /* vertices */
  PetscInt n_deformable;      /* owned, of deformable blocks */
  PetscInt n_moving;          /* n_deformable + owned rigid vertices: all that a cycle moves */
  PetscInt n_owned;           /* n_moving + inner vertices of condensed bodies */
  PetscInt n_vertices;        /* n_owned + ghosts; arrays have DUMMY_VERTICES more */
  PetscReal *X;               /* [m] (n_vertices + DUMMY_VERTICES, 2) reference coordinates */
  PetscInt *vertex_gid;       /* (n_vertices,) */
  PetscInt *vertex_file;      /* (n_vertices,) */
  PetscInt *vertex_body;      /* (n_vertices,) macroblock */
  PetscInt *vertex_rigid;     /* (n_vertices,) rigid body (global number), -1: deformable */
  PetscInt *vertex_condensed; /* (n_owned,) condensed body (global number), -1: none; NULL: no such bodies */

  /* rigid bodies owned here (all their vertices are owned here too) */
  PetscInt n_bodies;
  PetscInt *body_gid;   /* (n_bodies,) macroblock-like number 0.. n_rigid_global-1, ascending */
  PetscInt *body_start; /* (n_bodies + 1,) first local vertex of each body */
  PetscReal *body_X;    /* [m] (n_bodies,2) mass centre, reference; with the lumped mass of deformable
                           blocks at its vertices */
  PetscReal *body_mass; /* [kg] (n_bodies,2) mass and moment of inertia about that centre (30) */
  PetscInt *body_body;  /* (n_bodies,) macroblock */

  PetscInt n_dof;         /* 3 n_bodies + 2 n_deformable */
  PetscReal *vertex_mass; /* [kg] (n_deformable,) true lumped masses (26)-(27) */
  int16_t *support;       /* (3 n_bodies + 2 n_owned,) row of Scene.supports that holds the dof, -1: it is
                             free; behind n_dof: inner vertices */
  PetscReal *in_quotient; /* (n_dof,) 1: the dof enters the Rayleigh quotient, 0: not; NULL: all do */

  Elements t3, q4;
  PetscInt *chunk_done; /* (chunks of elements,) see element.c: so many deformable vertices, the first ones,
                           have all their forces after this chunk */
  Elements rigid_t3, rigid_q4;              /* rigid blocks: for masses, loads and output only; no forces */
  Elements condensed_t3, condensed_q4;      /* for set-up, loads and output; no force in a cycle */
  PetscInt n_condensed, n_condensed_global; /* condensed bodies owned here, and in all */
  PetscInt condensed_dofs[2];     /* kept and inner degrees of freedom of all ranks' condensed bodies */
  double condensed_wall;          /* [s] that their factors took, once per run */
  struct _p_Condensed *condensed; /* (n_condensed,) ascending number; condense.c */
  Faces faces;                    /* neighbours.c */
  PetscInt n_faces_local;         /* the first so many faces belong to blocks at owned vertices:
                                     loads and sets name these */
  FaceRecord *face_held;          /* (n_held,) far faces of groups that are not upgradeable: known for good */
  PetscInt n_held;
  GhostRecord *ghosts; /* (n_ghosts,) in the order of the local vertices; neighbours.c */
  PetscInt n_ghosts, n_element_ghosts;
  PetscInt vertex_capacity; /* vertices, dummies included, that the arrays of vertices have room for */

  /* materials by group (n_groups,) */
  PetscInt n_groups;
  char (*group_names)[NAME_LENGTH];
  PetscInt *group_rigid;
  PetscBool *group_condensed;
  PetscReal *hourglass; /* [Pa] (n_groups,3) ElementHourglass of each group; NULL: all are ELEMENT_FULL */
  Lame *lame;           /* of each group */
  PetscReal *density;   /* [kg/m3] */
  PetscInt
      *later_joint; /* (n_groups, n_groups) row of joints, in place of default, of contacts that come later;
                            NULL: default, joint_rows.c */
  PetscBool *group_upgradeable;
  PetscReal thickness; /* [m] */
  StrainMeasure strain;

  /* named sets, local part */
  PetscInt n_face_sets, n_points;
  char (*face_set_names)[NAME_LENGTH];
  char (*point_names)[NAME_LENGTH];
  PetscInt *face_set_start; /* (n_face_sets + 1,) into face_set_faces */
  PetscInt *face_set_faces; /* rows of `faces` (local blocks only), ascending gid within a set */
  PetscInt *point_vertex;   /* (n_points,) local vertex, -1: not on this rank */

  PetscBool one_machine;  /* ranks tell each other through the memory they share */
  struct _p_Ghost *ghost; /* the exchange of a cycle, NULL: one rank; ghost.c */
} Model;

/* ------------------------------------------------------------------------------------------- Contacts
   Face-to-face contacts that touch an owned vertex, ascending (stress model, lower face gid, higher face
   gid), padded per stress model to whole batches. Sub-contact k = 0,1 of contact c stands at index SUB(c,k)
   of every (.., 2, BATCH) array. A sub-contact is a vertex P of one face opposite the edge A-B of the other
   (its destination); sub-contacts 0 and 1 are the two ends of the contact, and stress runs linearly between
   them. Two faces have four vertices: P A B of sub-contact 0 and Q, the other vertex of P's face; which of
   them are P A B of sub-contact 1 follows from the class (ContactEndVertices). A vertex on a face has no end
   1: Q is A, and t = 0 there, so that nothing opens or slides. With tptm both ends stand at the vertex:
   Q is P, and `rest` makes of the two the diagram of a face. */

#define SUB(c, k) (((c) / BATCH) * 2 * BATCH + (k)*BATCH + (c) % BATCH)
enum { ROW_P, ROW_A, ROW_B, ROW_Q, CONTACT_ROWS };
#define CONTACT_ROW(c, row) (((c) / BATCH) * CONTACT_ROWS * BATCH + (row)*BATCH + (c) % BATCH)

typedef enum { FF1_21, FF1_12, FF2_I, FF2_F, VERTEX_FACE } ContactClass; /* Fig. 3 and 5b of the paper */
typedef enum {
  CONTACT_ELASTIC = 0,
  CONTACT_OPEN = 1,
  CONTACT_SLIPPING = 2,
  CONTACT_CRUSHING = 4
} ContactState; /* bits, per sub-contact */

typedef struct {
  PetscInt n;                              /* real contacts: padding lanes are not counted */
  PetscInt n_padded;                       /* size of the arrays in contacts */
  PetscInt model_start[STRESS_MODELS + 1]; /* first contact (in the padded numbering) of each stress model */
  /* identity, written by contact.c */
  PetscInt *key;  /* (n_padded,2) gid of the two faces, lower first; a vertex on a face: gid of the face, -2 -
                     gid of the vertex; -1 -1: padding */
  uint8_t *klass; /* (n_padded,) ContactClass */
  PetscInt *joint; /* (n_padded,) row of the joints table */
  bool *owned;     /* (n_padded,) this rank writes it */
  /* geometry, hot */
  PetscInt *vertex;  /* (n_padded/BATCH, 4, BATCH) local vertices: rows P A B Q */
  PetscReal *t;      /* [-] (.., 2, BATCH) L_d over the length of A-B: P projects on (1-t) A + t B */
  PetscReal *rest;   /* [m] (.., 2, BATCH) opening at which sigma = 0: initial overlap (<= 0), so that a
                        contact starts stress-free */
  PetscReal *length; /* [m] (n_padded,) L = L_i,0 + L_i,1; the two are equal */
  uint16_t *traits;  /* what few contacts at a time have in common; contact_force.c */
  /* history, written by contact_force.c */
  PetscReal *slip;        /* [m] (.., 2, BATCH) plastic part of u_s */
  PetscReal *broken;      /* [-] (.., 2, BATCH) part of L, from this end, where the joint has failed: residual
                        strength there; LOOSE: has met in motion and never held together */
  PetscReal *closure;     /* [m] (.., 2, BATCH) plastic part of u_n, <= 0: what was crushed, as it is at this
                             end: the lower envelope of 0 and two lines, one by each end */
  PetscReal *closure_far; /* [m] (.., 2, BATCH) where the line by this end is at the other one */
  PetscBool held;         /* every evaluation starts from slip_0, broken_0, closure_0; if not, from where the
                             last one ended */
  PetscReal *slip_0, *broken_0, *closure_0, *closure_far_0; /* (as above) of the last equilibrium */
  PetscReal pull; /* [-] while held: part of the way per evaluation by which friction, kept as it comes, goes
                     to what the history held gives; 0: friction is that at once. relax.c */
  PetscBool
      springs; /* tptm in a static stage: end forces of shear are springs that keep their slip, as in time */
  PetscReal *u_n_0, *u_s_0; /* [m] (as u_n, u_s) where partings and slidings count from: where the
                               contact first bore, u_n_0 = PETSC_MAX_REAL: it has not; parting.c */
  PetscReal
      *moved; /* [-] (as u_n) parted or slid by since then, over the length, when the last chunk began */
  PetscBool counted; /* u_n_0 and u_s_0 are those of now; a motion in time takes that away */
  PetscReal rate;    /* [1/s] 1/dt in a dynamic stage, -1 there with dashpots idle, 0 in a static one */
  PetscBool repeats; /* the next evaluation is of the instant of the last: dashpots keep their speed */
  /* last evaluation, written by contact_force.c */
  PetscReal *u_n, *u_s;   /* [m] (.., 2, BATCH) */
  PetscReal *speed;       /* [m/s] (.., 2, BATCH) of opening, over the step that led here; dynamic stages */
  PetscReal *sigma, *tau; /* [Pa] (.., 2, BATCH) at the control points that are the two ends */
  PetscReal *F_n, *F_s;   /* [N/m] (.., 2, BATCH) end forces per metre of thickness, signs of sigma and tau */
  uint8_t *state;         /* (.., 2, BATCH) ContactState bits */
} Contacts;

/* Ends of contact i: one of a vertex on a face. */
static inline int ContactEnds(const Contacts *c, PetscInt i)
{
  return c->klass[i] == VERTEX_FACE ? 1 : 2;
}

/* Local vertices P A B of end k of contact i. */
static inline void ContactEndVertices(const Contacts *c, PetscInt i, int k, PetscInt vertex[3])
{
  static const int first[3] = {ROW_P, ROW_A, ROW_B}, second[][3] = {[FF1_21] = {ROW_Q, ROW_A, ROW_B},
                                                                    [FF1_12] = {ROW_Q, ROW_A, ROW_B},
                                                                    [FF2_I] = {ROW_A, ROW_P, ROW_Q},
                                                                    [FF2_F] = {ROW_B, ROW_Q, ROW_P},
                                                                    [VERTEX_FACE] = {ROW_Q, ROW_A, ROW_B}};
  const int *row = k ? second[c->klass[i]] : first;
  for (int v = 0; v < 3; v++) vertex[v] = c->vertex[CONTACT_ROW(i, row[v])];
}

/* ---------------------------------------------------------------------------------------------- State
   What a step changes. u, v, f, f_old, f_ext share one layout (see Model): n_dof entries of this rank's dofs,
   then the other vertices (u only). Vecs share the memory of the first n_dof entries. */

typedef struct {
  PetscReal *u;     /* [m, rad] (3 n_bodies + 2 (n_vertices + DUMMY_VERTICES),) displacement; integrate.c,
                       rigid.c, ghost.c */
  PetscReal *v;     /* [m/s, rad/s] velocity at the half step; integrate.c */
  PetscReal *f;     /* [N, N m] resisting force; element.c, contact_force.c, rigid.c */
  PetscReal *f_old; /* [N, N m] that of the cycle before (the two pointers swap); integrate.c clears it */
  PetscBool f_old_clear; /* f_old is zero at all degrees of freedom */
  PetscReal *f_ext;      /* [N, N m] applied force, what acts inside condensed bodies passed on to their kept
                            vertices; at inner vertices what acts there; loads.c, condense.c */
  PetscReal
      *passed;  /* [N, N m] (3 n_bodies + 2 n_owned,) f_ext plus this is what acts at a kept vertex itself;
                   NULL: no condensed bodies; written at the end of a stage or trial by condense.c */
  PetscReal *m; /* [kg, kg m2] (n_dof,) scaled mass (33)-(34); timestep.c */
  PetscReal *m_inv;              /* (n_dof,) 1/m, 0 where held */
  PetscInt capacity;             /* numbers that u, f, f_old, f_ext, f_start, f_target have room for */
  Vec u_vec, v_vec;              /* (n_dof,) views of u and v for PETSc */
  PetscReal dt;                  /* [s] 1 in a static stage: time is fictitious */
  PetscReal alpha;               /* [1/s] Rayleigh damping (38) */
  PetscReal beta;                /* [-] stiffness-proportional damping over dt, in static stages; relax.c */
  PetscReal local;               /* [-] local non-viscous damping, of Step, in static stages */
  PetscReal caution;             /* [-] static stages: times by which the step is shorter; guard.c */
  PetscInt64 cycle;              /* cycles since the start of the run */
  PetscReal *f_start, *f_target; /* [N, N m] applied force at the start of the stage and that it ramps to;
                                    loads.c. f_target has those at vertices of rigid bodies behind its dofs;
                                    in a dynamic stage f_start are the loads that do not follow the motion */
  PetscBool loads_turn;          /* a rigid body has loads whose moment changes as it turns; loads.c */
  PetscReal time;                /* [s] of dynamic stages */
  PetscReal
      *u_verified; /* (n_dof,) u when contacts were last verified; contact_verify.c; NULL: they never are */
  PetscReal ramp;  /* [-] 0..1: f_ext = (1 - ramp) f_start + ramp f_target */
  struct _p_Uplift *uplift; /* (n_loads,) joint line, faces and open length of each uplift load; uplift.c */
} State;

/* ------------------------------------------------------------------------------------------ Verdict */

typedef enum {
  VERDICT_NONE,
  VERDICT_CONVERGED,
  VERDICT_COLLAPSED,
  VERDICT_DIVERGED,
  VERDICT_UNDECIDED,
  VERDICT_INTERRUPTED,
  VERDICT_COMPLETED /* a dynamic stage that ran for its duration */
} Verdict;

/* Energy account of a dynamic stage [J]; all but the first three are sums since its start. */
typedef struct {
  PetscReal kinetic, strain, joints; /* present */
  PetscReal outside;                 /* work of applied forces, weight included */
  PetscReal supports;                /* work of moving supports */
  PetscReal friction;                /* lost in joints, dashpots included: their work less what they store */
  PetscReal damping;                 /* lost to mass-proportional damping */
  PetscReal detection;               /* change of stored joint energy when contacts were verified */
  PetscReal balance;                 /* what came in less what is there or lost: 0 when nothing is amiss */
} Energies;

/* What a stage, with all its trials, has taken. */
typedef struct {
  PetscInt64 evaluations; /* of the forces of the whole model */
  PetscInt64 solves;      /* with a factor of the stiffness */
  PetscInt64 factorisations;
  PetscBool preconditioned, explicit; /* which methods ran */
  PetscInt64 wanted, available; /* [byte] a factor was not made for want of memory: what it takes, what there
                                   was; 0: none was wanting */
} Effort;

enum { EVIDENCE_LENGTH = PETSC_MAX_PATH_LEN + 256 }; /* it may name a checkpoint */

typedef struct {
  Verdict verdict;
  char evidence[EVIDENCE_LENGTH]; /* why, in one line of numbers */
  PetscInt64 cycles;      /* of this stage: force evaluations of its explicit loop and its iterations */
  Effort effort;          /* what they cost */
  PetscReal ratio;        /* [-] largest unbalanced ratio over bodies */
  PetscInt worst_body;    /* macroblock with that ratio */
  PetscReal increment;    /* [-] largest displacement increment of a cycle over largest displacement */
  PetscReal kinetic;      /* [J] with scaled masses */
  double wall;            /* [s] */
  PetscReal displacement; /* [m] largest */
  PetscBool finite;       /* no NaN or infinity among forces and displacements */
  PetscReal time;         /* [s] since the start of the first dynamic stage */
  PetscInt64 verifications, contacts_made, contacts_lost; /* variable connectivity */
  PetscReal deepest; /* [-] deepest overlap of a contact over its shorter face, at the last verification */
  Energies energy;
} StageResult;

/* types.h: the data dictionary of Quoin. Every array with its meaning, [unit], (shape) and who writes it.

   Conventions, stated once (tests/unit/test_conventions.c holds them):
   - SI units: m, N, Pa, kg, s; two dimensions, loads per metre of thickness times `thickness`.
   - Stress: tension positive. Contact opening u_n: positive when the faces part; sigma = k_n u_n.
   - Blocks run counter-clockwise; face k of a block runs from its vertex k to vertex k+1; its outward normal
   is to the right of that direction.
   - f is the RESISTING nodal force (what the model pushes back with: f = +int B'sigma dA for blocks), so the
     unbalanced force is r = f_ext - f. The paper's (8) and (10) use opposite signs; this is ours everywhere.
   - gid: number of a vertex, block or face in Quoin's own global order (bandwidth-reducing, the same for
   every number of ranks). Every sum over elements, contacts and bodies runs in ascending gid, so that results
   have the same bits on any number of ranks. "file id": the number in model.h5. */
#pragma once
#include <petscsys.h>
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

enum {
  NAME_LENGTH = 64, /* of groups, sets, points, joints, loads, stages; 63 characters and the closing zero */
  MESSAGE_LENGTH = 1024, /* of one error line */
  BATCH = 8              /* elements and contacts are padded to whole batches of this many */
};

/* ---------------------------------------------------------------------------------------------- Scene
   What the user asked for: read by scene.c from the YAML scene and the command line, constant afterwards. */

typedef enum { PLANE_STRAIN, PLANE_STRESS } PlaneState;
typedef enum { STRAIN_LARGE, STRAIN_SMALL } StrainMeasure;
typedef enum { ELEMENT_FULL, ELEMENT_BENDING, ELEMENT_REDUCED } Formulation; /* of blocks of 4 vertices */
typedef enum { LAW_MOHR_COULOMB, LAW_ELASTIC } JointLawKind;
typedef enum {
  STRESS_PT,
  STRESS_R2PT,
  STRESS_R3PT,
  STRESS_T2PT,
  STRESS_T3PT,
  STRESS_TPTM,
  STRESS_MODELS
} StressModelKind;
typedef enum { LOAD_SELF_WEIGHT, LOAD_RESERVOIR, LOAD_TRACTION, LOAD_POINT_FORCE, LOAD_UPLIFT } LoadKind;
typedef enum { UPLIFT_LINEAR, UPLIFT_NPB, UPLIFT_USBR, UPLIFT_USACE, UPLIFT_FERC } UpliftRule;
typedef enum { UPLIFT_BOTH, UPLIFT_VERTICAL } UpliftComponent;
typedef enum { HEEL_START, HEEL_END } UpliftHeel;
typedef enum { RAISE_WHOLE, RAISE_TO_DRAIN } UpliftRaise;
typedef enum { METHOD_EXPLICIT, METHOD_PRECONDITIONED } MethodKind;
typedef enum { DAMPING_ADAPTIVE, DAMPING_PAPER, DAMPING_FIXED, DAMPING_NONE } DampingKind;
typedef enum { STAGE_STATIC, STAGE_DYNAMIC, STAGE_STRENGTH_REDUCTION, STAGE_FLOOD } StageKind;
typedef enum { REDUCE_FRICTION, REDUCE_STRENGTHS } ReductionKind;
typedef enum { CONNECTIVITY_FIXED, CONNECTIVITY_VARIABLE } Connectivity;
typedef enum { PARTITION_METIS, PARTITION_STRIPES } PartitionKind;
typedef enum { REPARTITION_AUTO, REPARTITION_NEVER } RepartitionKind;
typedef enum { MOTION_VELOCITY, MOTION_ACCELERATION } MotionQuantity;
typedef enum { ISA_WIDEST, ISA_BASE, ISA_V3, ISA_V4 } InstructionSet; /* of x86-64 */

typedef struct {
  char name[NAME_LENGTH];   /* group of the mesh it belongs to */
  PetscReal density;        /* [kg/m3] >= 0 (0: weightless; a static stage scales masses anyway) */
  PetscReal young, poisson; /* [Pa], [-]; not needed for a rigid group */
  Formulation element;      /* see element_kernels.h */
  PetscReal hourglass;      /* [-] ELEMENT_REDUCED: stiffness against hourglass modes */
  PetscInt rigid;           /* -1: as the mesh says, 0: deformable, 1: rigid; 0 or 1 after SceneResolve */
  PetscBool condensed;      /* deformable, and reduced onto the vertices where it meets others: condense.c */
  PetscReal velocity[2];    /* [m/s] at the start of the first dynamic stage */
  PetscReal spin;           /* [rad/s] likewise, about each body's mass centre */
  PetscBool upgradeable;    /* its contacts are verified and searched for when connectivity is variable */
  PetscBool output;         /* its blocks are written into results.h5 */
  PetscReal tension, compression, cohesion, friction; /* [Pa], [Pa], [Pa], [degree] strengths for the local
                                                         failure factors (39)-(41); NaN: not given */
  int line; /* in the scene file, for messages, here and below; 0: command line */
} Material;

/* Properties of one joint; also of a pair of groups, or the default. Index [0]: peak, [1]: residual (after
   the joint has failed in tension or shear at that place). */
typedef struct {
  char name[NAME_LENGTH]; /* face set of the mesh, or "groupA+groupB", or "default" */
  JointLawKind law;
  StressModelKind stress_model;
  PetscReal k_n, k_s;    /* [Pa/m] */
  PetscReal friction[2]; /* [degree] */
  PetscReal tan_phi[2];  /* [-] of friction; JointPrepare in joint_law.h writes it */
  PetscReal cohesion[2]; /* [Pa] */
  PetscReal tension[2];  /* [Pa] tensile strength, >= 0 */
  PetscReal compression; /* [Pa] compressive strength, > 0, PETSC_INFINITY: none */
  PetscReal damping;     /* [s] dynamic stages: normal dashpot, damping * k_n per unit area, while closed */
  PetscBool defined;     /* false only for row 0 when the scene gives no "default": all else is 0 then */
  int line;
} Joint;

typedef struct {
  char name[NAME_LENGTH];
  char target[NAME_LENGTH]; /* face set, group or point of the mesh; the name of the support itself by default
                             */
  PetscBool fix[2];         /* x, y */
  char motion[PETSC_MAX_PATH_LEN]; /* dynamic stages: CSV file of t [s], x, y; "": does not move */
  PetscInt row;                    /* of this support in Scene.supports */
  MotionQuantity quantity;         /* what x, y are: [m/s] or [m/s2] */
  int line;
} Support;

typedef struct {
  char name[NAME_LENGTH];
  LoadKind kind;
  PetscInt n_groups; /* self_weight: groups it acts on; 0: all */
  char (*groups)[NAME_LENGTH];
  char target[NAME_LENGTH]; /* reservoir, traction: face set; point_force: point */
  PetscReal level;          /* [m] reservoir: elevation of the water surface */
  PetscReal density;        /* [kg/m3] reservoir: of water */
  PetscReal traction[2];    /* [Pa] traction x, y; point_force: [N/m of thickness] */
  /* uplift: level, density and target as the reservoir's; see uplift.c */
  UpliftRule rule;
  UpliftComponent component;
  UpliftHeel heel;           /* which end of the joint is upstream */
  UpliftRaise raise;         /* what a flood stage raises: all, or nothing beyond the drain */
  PetscBool cracked;         /* full head along the open part of the joint */
  PetscReal crack_tolerance; /* [m] of the iteration for the open length */
  PetscReal tailwater;       /* [m] elevation downstream, NaN: none */
  PetscReal drain;           /* [m] from the heel along the joint, NaN: none */
  PetscReal gallery;         /* [m] elevation where the drain opens, NaN: none */
  PetscReal efficiency;      /* [-] of the drain, NaN until the rule has set it */
  PetscReal drain_level;     /* [m] level that the pressure at the drain belongs to (level, but for floods) */
  int line;
} Load;

typedef struct {
  char name[NAME_LENGTH];
  StageKind kind;
  PetscInt
      n_loads; /* loads acting at the end of the stage; loads of the stage before that are not named leave */
  PetscInt *loads;     /* (n_loads,) rows of Scene.loads */
  PetscInt ramp;       /* [cycles] over which loads go linearly from what acted before to this stage's */
  PetscInt max_cycles; /* [cycles] then the verdict is "undecided" */
  PetscReal tolerance; /* [-] unbalanced ratio, largest over bodies, below which the stage has converged */
  PetscReal velocity_tolerance; /* [-] largest displacement increment of a cycle over largest displacement,
                                   likewise */
  PetscInt variable;   /* 1: connectivity is variable in this stage, 0: fixed, -1: as Scene.connectivity */
  PetscReal duration;  /* [s] of a dynamic stage */
  PetscReal dt_factor; /* [-] dynamic: time step over the stability bound */
  PetscReal alpha;     /* [1/s] dynamic: mass-proportional damping */
  PetscInt frames;     /* dynamic: results written on the way, at equal intervals */
  Joint *joints;       /* (n_joints,) the joints table of this stage: Scene.joints plus all changes so far; a
                          strength reduction leaves the strengths of its last stable trial here */
  /* strength_reduction, flood: trials from start towards limit, see reduction.c */
  ReductionKind what;
  PetscInt n_reduce; /* joints reduced; 0: all */
  char (*reduce)[NAME_LENGTH];
  PetscReal start, step, limit; /* [degree], [-] or [m]; NaN: not given */
  PetscReal factor;  /* [-] strengths: each trial leaves this part of the strengths of the one before */
  PetscReal bracket; /* [degree], [-] or [m] width at which bisection ends; 0: none */
  int line;
} Stage;

typedef struct {
  char file[PETSC_MAX_PATH_LEN];   /* the YAML file, for messages; "" when there is none */
  char model[PETSC_MAX_PATH_LEN];  /* path of model.h5 */
  char output[PETSC_MAX_PATH_LEN]; /* folder for results */
  char title[256];
  PetscReal advise; /* [-] accuracy for which advise.c says what could be left out, 0: the scene is run */
  PlaneState plane;
  StrainMeasure strain;
  PartitionKind partition;
  InstructionSet isa;  /* asked for; instruction_set of lanes.h is what runs */
  PetscReal thickness; /* [m] */
  PetscReal gravity;   /* [m/s2] acts in -y */
  /* contacts */
  PetscReal contact_tolerance; /* [m] activation tolerance on the opening of both sub-contacts */
  PetscBool contact_relative;  /* contact_tolerance is a fraction of the smaller face instead */
  Connectivity connectivity;   /* of stages that do not say */
  PetscReal verify_after;  /* [-] verification when a vertex has moved this part of the contact tolerance */
  PetscReal vertex_length; /* [-] least influence length of a vertex on a face, over the shorter face */
  PetscReal overlap_tolerance; /* [m] two macroblocks may overlap this deep in the mesh */
  /* relaxation */
  MethodKind method;   /* of static stages */
  PetscInt increments; /* preconditioned: steps in which loads that are ramped are applied */
  DampingKind damping;
  PetscReal alpha_dt;        /* [-] fixed damping: alpha dt */
  PetscReal beta;            /* [-] adaptive damping: State.beta */
  PetscInt n_damping_groups; /* groups that enter the Rayleigh quotient; 0: all */
  char (*damping_groups)[NAME_LENGTH];
  PetscReal safety;         /* [-] of the time step: masses are those of a step 1/safety times longer */
  PetscBool allow_floating; /* accept bodies without support */
  PetscInt check_every;     /* [cycles] between tests of convergence */
  PetscInt history_every;   /* [cycles] between rows of history.csv */
  RepartitionKind repartition;
  PetscInt repartition_every; /* [cycles] between looks for a better partition */
  PetscReal repartition_gain; /* [-] part of the busiest rank's work that it must save */
  /* checkpoints */
  char restart[PETSC_MAX_PATH_LEN]; /* file, folder or "auto"; "": a run from the start */
  PetscReal checkpoint_minutes;     /* [min] of wall time between checkpoints, 0: none by time */
  PetscInt checkpoint_every;        /* [cycles] between checkpoints, 0: none by cycles */
  PetscInt checkpoint_keep;         /* newest files kept */
  PetscReal wall_limit;             /* [min] of wall time, 0: none */
  char *options;                    /* "key value" lines: all that the scene and the command line say */
  /* tables */
  PetscInt n_materials, n_joints, n_supports, n_loads, n_stages;
  Material *materials;
  Joint *joints; /* row 0 is "default" */
  Support *supports;
  Load *loads;
  Stage *stages;
  char *echo; /* every key in force, as YAML: scene_echo.yaml */
} Scene;

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

typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank, size;
  PetscInt n_vertices_global, n_blocks_global, n_bodies_global, n_rigid_global;
  PetscReal diameter;       /* [m] of the bounding box of the whole mesh */
  PetscReal contact_margin; /* [m] faces nearer than this may be in contact */

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
  PetscReal *body_X; /* [m] (n_bodies,2) mass centre, reference; with the lumped mass of deformable blocks at
                        its vertices */
  PetscReal *body_mass; /* [kg] (n_bodies,2) mass and moment of inertia about that centre (30) */
  PetscInt *body_body;  /* (n_bodies,) macroblock */

  PetscInt n_dof;         /* 3 n_bodies + 2 n_deformable */
  PetscReal *vertex_mass; /* [kg] (n_deformable,) true lumped masses (26)-(27) */
  int16_t *support; /* (3 n_bodies + 2 n_owned,) row of Scene.supports that holds the dof, -1: it is free;
                       behind n_dof: inner vertices */
  PetscReal *in_quotient; /* (n_dof,) 1: the dof enters the Rayleigh quotient, 0: not; NULL: all do */

  Elements t3, q4;
  PetscInt *chunk_done; /* (chunks of elements,) see element.c: so many deformable vertices, the first ones,
                           have all their forces after this chunk */
  Elements rigid_t3, rigid_q4; /* rigid blocks: for masses, loads and output only; no forces */
  Elements condensed_t3,
      condensed_q4; /* of condensed bodies: for set-up, loads and output; no force in a cycle */
  PetscInt n_condensed, n_condensed_global; /* condensed bodies owned here, and in all */
  PetscInt condensed_dofs[2];     /* kept and inner degrees of freedom of all ranks' condensed bodies */
  double condensed_wall;          /* [s] that their factors took, once per run */
  struct _p_Condensed *condensed; /* (n_condensed,) ascending number; condense.c */
  Faces faces;                    /* neighbours.c */
  PetscInt n_faces_local; /* the first so many faces belong to blocks at owned vertices: loads and sets name
                             these */
  FaceRecord *face_held;  /* (n_held,) far faces of groups that are not upgradeable: known for good */
  PetscInt n_held;
  GhostRecord *ghosts; /* (n_ghosts,) in the order of the local vertices; neighbours.c */
  PetscInt n_ghosts, n_element_ghosts;
  PetscInt vertex_capacity; /* vertices, dummies included, that the arrays of vertices have room for */

  /* materials by group (n_groups,) */
  PetscInt n_groups;
  char (*group_names)[NAME_LENGTH];
  PetscInt *group_rigid;
  PetscBool *group_condensed;
  PetscReal *hourglass;   /* [Pa] (n_groups,3) ElementHourglass of each group; NULL: all are ELEMENT_FULL */
  PetscReal *lambda, *mu; /* [Pa] Lame constants of the plane problem (plane stress: lambda reduced) */
  PetscReal *density;     /* [kg/m3] */
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

  PetscSF ghost;     /* leaves: ghost vertices; roots: owned vertices of their owners */
  MPI_Datatype pair; /* its unit: 2 doubles */
} Model;

/* ------------------------------------------------------------------------------------------- Contacts
   Face-to-face contacts that touch an owned vertex, ascending (stress model, lower face gid, higher face
   gid), padded per stress model to whole batches. Sub-contact k = 0,1 of contact c stands at index SUB(c,k)
   of every (.., 2, BATCH) array. A sub-contact is a vertex P of one face opposite the edge A-B of the other
   (its destination); sub-contacts 0 and 1 are the two ends of the contact, and stress runs linearly between
   them. */

#define SUB(c, k) (((c) / BATCH) * 2 * BATCH + (k)*BATCH + (c) % BATCH)

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
  PetscInt *key; /* (n_padded,2) gid of the two faces, lower first; a vertex on a face: gid of the face, -2 -
                    gid of the vertex; -1 -1: padding */
  ContactClass *klass; /* (n_padded,) */
  PetscInt *joint;     /* (n_padded,) row of the joints table */
  PetscBool *owned;    /* (n_padded,) this rank writes it */
  /* geometry, hot */
  PetscInt *vertex;  /* (n_padded/BATCH, 6, BATCH) local vertices: P A B of sub-contact 0, then of 1 */
  PetscReal *t;      /* [-] (.., 2, BATCH) L_d over the length of A-B: P projects on (1-t) A + t B */
  PetscReal *gap;    /* [m] (.., 2, 2, BATCH) P - ((1-t) A + t B) in the reference state, x then y */
  PetscReal *rest;   /* [m] (.., 2, BATCH) opening at which sigma = 0: initial overlap (<= 0), so a contact
                        starts stress-free */
  PetscReal *length; /* [m] (n_padded,) L = L_i,0 + L_i,1; the two are equal */
  /* history, written by contact_force.c */
  PetscReal *slip;   /* [m] (.., 2, BATCH) plastic part of u_s */
  PetscReal *broken; /* [-] (.., 2, BATCH) part of L, from this end, where the joint has failed (residual
                        strength) */
  PetscBool held; /* every evaluation starts from slip_0, broken_0; if not, from where the last one ended */
  PetscReal *slip_0, *broken_0; /* (as slip, broken) of the last equilibrium; ContactsHold */
  PetscReal rate; /* [1/s] 1/dt in a dynamic stage, -1 there with dashpots idle, 0 in a static one */
  /* last evaluation, written by contact_force.c */
  PetscReal *u_n, *u_s;   /* [m] (.., 2, BATCH) */
  PetscReal *speed;       /* [m/s] (.., 2, BATCH) of opening, over the step that led here; dynamic stages */
  PetscReal *sigma, *tau; /* [Pa] (.., 2, BATCH) at the control points that are the two ends */
  PetscReal *F_n, *F_s;   /* [N/m] (.., 2, BATCH) end forces per metre of thickness, signs of sigma and tau */
  PetscInt *state;        /* (.., 2, BATCH) ContactState bits */
} Contacts;

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
} Effort;

typedef struct {
  Verdict verdict;
  char evidence[256];     /* why, in one line of numbers */
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

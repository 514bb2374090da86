/* model.h: declares the data of a rank: its model and its state. Each array has its
   meaning, [unit], (shape) and writer. Conventions: base.h. */
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

/* ---------------------------------------------------------------------------------------------- Model
   Flat arrays of one rank, constant during the run; written by model.c. Local order of vertices:
     [ owned deformable, by gid | owned rigid, by body then gid | owned inner of condensed bodies, by body
   then gid | ghosts of elements and couplings, by gid | further ghosts of contacts, by gid | DUMMY_VERTICES
   unit square ]
   The ghosts of contacts change when blocks move (neighbours.c); nothing before them does. Kept vertices of
   condensed bodies are deformable (or rigid) ones like any other. Degrees of freedom (what integrate.c
   steps): [ 3 per owned rigid body | 2 per owned deformable vertex ]. A dof array has the vertex array right
   behind its bodies: u_vertex = u + 3 n_bodies, so that for deformable vertices the dof IS the vertex entry.
   Inner vertices stand behind all that moves: no loop of a cycle meets them; condense.c fills them in
   afterwards. The dummies are where padding lanes of a batch point to. */

enum { DUMMY_VERTICES = 4 };

typedef struct {
  PetscInt n;           /* elements of this shape that touch an owned vertex */
  int n_nodes;          /* 3 or 4 */
  PetscInt n_padded;    /* n rounded up to a whole batch */
  StrainMeasure strain; /* as in the scene; small for condensed blocks */
  PetscInt *vertex;     /* (n_padded / BATCH, n_nodes, BATCH) local vertices: VertexOf */
  PetscInt *group;      /* (n_padded,) */
  PetscInt *gid;        /* (n,) gid of the block, ascending */
  PetscInt *file;       /* (n,) file id */
  bool *owned;          /* (n,) this rank writes the block, because it owns the lowest-gid vertex */
  PetscReal *placed;    /* [m] (2, n_padded / BATCH, n_nodes, BATCH) x, y: displacements from which strain
                           counts; NULL: from zero; lifts.c, at_rest.c */
  MaterialLaw law;      /* law of all elements of the list */
  struct _p_LawHistory *history; /* NULL: the law is elastic and has no history; laws.c */
} Elements;

/* Returns local vertex k of element e, and its place in elements->vertex. Kernels, which take whole batches,
   compute it themselves. */
static inline PetscInt VertexPlace(const Elements *elements, PetscInt e, PetscInt k)
{
  return ((e / BATCH) * elements->n_nodes + k) * BATCH + e % BATCH;
}
static inline PetscInt VertexOf(const Elements *elements, PetscInt e, PetscInt k)
{
  return elements->vertex[VertexPlace(elements, e, k)];
}

/* The lists of Model.elements: deformable ones, law by law; rigid ones; condensed ones. Each kind has
   quadrilaterals, then triangles. */
enum {
  ELASTIC_LISTS = 2,
  DEFORMABLE_LISTS = 2 * MATERIAL_LAWS,
  MOVING_LISTS = DEFORMABLE_LISTS + 2,
  ELEMENT_LISTS = MOVING_LISTS + 2
};

typedef struct {
  PetscInt n;        /* number of outer faces known here: of local blocks, then remote ones near them */
  PetscInt capacity; /* allocated rows */
  PetscInt *vertex;  /* (n,2) local vertices, in the order of the block's ring */
  PetscInt *gid;     /* (n,) 4 * block gid + k, ascending among local and among remote faces */
  PetscInt *group;   /* (n,) group of the block */
  PetscInt *body;    /* (n,) macroblock of the block */
  PetscInt *rigid;   /* (n,) rigid body the block belongs to, -1: none */
  PetscInt *joint;   /* (n,) row of Scene.joints whose face set has the face, by joint_turn; -1: none */
  PetscReal *thick;  /* [m] (n,) reach of its block behind the face, in the reference state */
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
      contact_depth; /* [m] deepest overlap or widest opening of a contact at the last search, 0: within the
                        margin */
  PetscReal contact_pressed; /* [m] deepest overlap at the last search */

  /* vertices */
  PetscInt n_deformable;      /* owned vertices of deformable blocks */
  PetscInt n_moving;          /* n_deformable + owned rigid vertices: all vertices that move in a cycle */
  PetscInt n_owned;           /* n_moving + inner vertices of condensed bodies */
  PetscInt n_vertices;        /* n_owned + ghosts; arrays have DUMMY_VERTICES more */
  PetscReal *X;               /* [m] (n_vertices + DUMMY_VERTICES, 2) reference coordinates */
  PetscInt *vertex_gid;       /* (n_vertices,) */
  PetscInt *vertex_file;      /* (n_vertices,) */
  PetscInt *vertex_body;      /* (n_vertices,) macroblock */
  PetscInt *vertex_rigid;     /* (n_vertices,) rigid body (global number), -1: deformable */
  PetscBool *vertex_calm;     /* (n_owned,) whether a vertex of a condensed body is kept only for a support,
                                 water or a probe */
  PetscInt *vertex_condensed; /* (n_owned,) condensed body (global number), -1: none; NULL: no such bodies */

  /* rigid bodies owned here, with all their vertices */
  PetscInt n_bodies;
  PetscInt *body_gid;   /* (n_bodies,) macroblock-like number 0.. n_rigid_global-1, ascending */
  PetscInt *body_start; /* (n_bodies + 1,) first local vertex of each body */
  PetscReal *body_X;    /* [m] (n_bodies,2) mass centre in the reference state; lumped masses of deformable
                           blocks at its vertices count */
  PetscReal *body_mass; /* [kg] (n_bodies,2) mass and moment of inertia about that centre (30) */
  PetscInt *body_body;  /* (n_bodies,) macroblock */

  PetscInt n_dof;         /* 3 n_bodies + 2 n_deformable */
  PetscReal *vertex_mass; /* [kg] (n_owned,) true lumped masses (26)-(27) of deformable blocks */
  int16_t *support;       /* (3 n_bodies + 2 n_owned,) row of Scene.supports that holds the dof, -1: it is
                             free; inner vertices come after n_dof */
  PetscReal *in_quotient; /* (n_dof,) 1: the dof enters the Rayleigh quotient, 0: not; NULL: all enter */

  union {
    Elements elements[ELEMENT_LISTS]; /* all lists, by the numbers above */
    struct {
      Elements q4, t3;                                    /* elastic */
      Elements of_laws[DEFORMABLE_LISTS - ELASTIC_LISTS]; /* blocks that yield or crack */
      Elements rigid_q4, rigid_t3;         /* rigid blocks: for masses, loads and output only; no forces */
      Elements condensed_q4, condensed_t3; /* for set-up, loads and output; no forces in a cycle */
    };
  };
  PetscInt *chunk_done; /* (chunks of elements,) number of deformable vertices, from the first on, that have
                           all their forces after this chunk; see element.c */
  PetscInt n_condensed, n_condensed_global; /* number of condensed bodies owned here; on all ranks */
  PetscInt condensed_dofs[2];     /* kept and inner degrees of freedom of the condensed bodies of all ranks */
  double condensed_wall;          /* [s] time for their factors, which are made once per run */
  double condensed_processor;     /* [s] time of the slowest rank's processor for them */
  struct _p_Condensed *condensed; /* (n_condensed,) ascending number; condense.c */
  PetscInt *mode_start; /* (n_condensed_global + 1,) number of modes of all bodies before each one; NULL: the
                       scene has no dynamic stage; condense_in_time.c */
  PetscInt n_modes;     /* modes of the condensed bodies owned here, body after body */
  Faces faces;          /* neighbours.c */
  PetscInt n_faces_local;      /* the first n_faces_local faces belong to blocks at owned vertices; loads
                                     and sets name these */
  FaceRecord *remembered_face; /* (n_remembered_faces,) far faces of groups that are not upgradeable */
  PetscInt n_remembered_faces;
  GhostRecord *ghosts; /* (n_ghosts,) in the order of their local vertices; neighbours.c */
  PetscInt n_ghosts, n_element_ghosts;
  PetscInt vertex_capacity; /* number of vertices, dummies included, that the arrays have room for */

  /* materials by group (n_groups,) */
  PetscInt n_groups;
  char (*group_names)[NAME_LENGTH];
  PetscInt *group_rigid;
  PetscBool *group_condensed;
  PetscReal *hourglass; /* [Pa] (n_groups,3) ElementHourglass of each group; NULL: all are ELEMENT_FULL */
  Lame *lame;           /* of each group */
  PetscReal *density;   /* [kg/m3] */
  PetscInt
      *later_joint; /* (n_groups, n_groups) row of joints for contacts that come later, in place of default;
                       NULL: default; joint_rows.c */
  PetscInt *joint_turn; /* (n_joints,) order of the rows of Scene.joints: where their face sets share a face,
                           the row of the lowest turn counts; joint_turns.c */
  PetscBool *group_upgradeable;
  bool *absent;           /* (n_groups,) not built yet; NULL: the scene builds nothing; lifts.c */
  struct _p_Lifts *lifts; /* times at which groups are built; NULL: none is */
  PetscReal thickness;    /* [m] */
  StrainMeasure strain;

  /* named sets, local part */
  PetscInt n_face_sets, n_points;
  char (*face_set_names)[NAME_LENGTH];
  char (*point_names)[NAME_LENGTH];
  PetscInt *face_set_start; /* (n_face_sets + 1,) into face_set_faces */
  PetscInt *face_set_faces; /* rows of `faces`, local blocks only, in ascending gid within a set */
  PetscInt *point_vertex;   /* (n_points,) local vertex, a ghost too; -1: not on this rank */

  PetscBool one_machine;  /* the ranks share memory and exchange through it */
  struct _p_Ghost *ghost; /* the exchange of a cycle, NULL: one rank; ghost.c */
} Model;

/* ---------------------------------------------------------------------------------------------- State
   What a step changes. The numbers of a state belong to Vecs on the model's communicator. A Vec has the
   n_dof entries of this rank's degrees of freedom. Behind them in the Vec's memory u, f, f_old and f_ext have
   those of the other vertices (see Model). The loop holds the arrays: u, v, f, f_old, f_ext and m point into
   the Vecs. Code that checks at a Vec itself (a norm, a viewer, an operation of PETSc) calls StateGive first
   and StateTake afterwards. That tells PETSc that the numbers may have changed, so it drops the norms that it
   has kept. */

enum { SHARE_START, SHARE_TARGET, SHARE_NOW, SHARES };
/* The loads of a stage: f_ext = (1 - ramp) start + ramp target; applied.c. */
typedef struct {
  PetscReal *start, *target; /* [N, N m] applied force at the start of the ramp and at its end. target has the
                                forces at vertices of rigid bodies behind its dofs. In a dynamic stage with
                                water on faces start has the loads that keep their direction */
  PetscReal ramp;            /* [-] 0..1 */
  PetscInt n_loads;          /* of the scene where one is a temperature, else 0 */
  PetscReal *share[SHARES]; /* [-] (n_loads,) part of each load at the start of the ramp, at its end, and now:
                         blocks that expand need it beside their forces */
  PetscBool turn;           /* a rigid body has loads whose moment changes as the body turns */
} Applied;

/* State of each mode inside a condensed body; its modal mass is 1 kg. */
enum {
  MODE_PLACE, /* [m] distance from the equilibrium of the loads inside */
  MODE_SPEED, /* [m/s] at the half step */
  MODE_LOAD,  /* [N] loads inside for this equilibrium */
  MODE_ARRAYS
};

typedef struct {
  PetscReal *u;          /* [m, rad] (3 n_bodies + 2 (n_vertices + DUMMY_VERTICES),) displacement;
                            integrate.c, rigid.c, ghost.c, newton_step.c; at inner vertices condense.c */
  PetscReal *v;          /* [m/s, rad/s] (n_dof,) velocity at the half step; integrate.c */
  PetscReal *f;          /* [N, N m] resisting force; element.c, force.c, rigid.c, force terms */
  PetscReal *f_old;      /* [N, N m] resisting force of the last cycle (StateSwapForces); integrate.c clears
                            it */
  PetscBool f_old_clear; /* f_old is zero at all degrees of freedom */
  PetscReal *f_ext;      /* [N, N m] applied force. Kept vertices of condensed bodies also have the part that
                            they take over from inner vertices; applied.c, condense.c */
  PetscReal *passed;     /* [N, N m] (3 n_bodies + 2 n_owned,) f_ext plus this is the force that acts at a
                            kept vertex itself; NULL: no condensed bodies; condense.c, at the end of a
                            stage */
  PetscReal *m;          /* [kg, kg m2] (n_dof,) scaled mass (33)-(34), in time the true mass; masses.c */
  PetscReal *m_inv;      /* (n_dof,) 1/m, 0 where held */
  PetscInt capacity;     /* numbers that u, f, f_old, f_ext and the arrays of applied have room for */
  PetscReal dt;          /* [s] 1 in a static stage: time is fictitious */
  PetscReal alpha;       /* [1/s] Rayleigh damping (38) */
  PetscReal beta;        /* [-] stiffness-proportional damping over dt, in static stages; friction_mode.c */
  PetscReal local;       /* [-] local non-viscous damping, in static stages; cycle.c */
  PetscReal *modes[MODE_ARRAYS]; /* (n_modes,) each: vibrations inside condensed bodies; condense_in_time.c */
  PetscReal *inertial;   /* [N] (n_dof,) resisting force that these vibrations add at kept vertices, at the
                            last check or recovery; not in f. NULL: no condensed bodies; condense_in_time.c */
  PetscInt lifts_stage;  /* the present stage: its groups are placed; lifts.c */
  PetscReal *reset;      /* [m, rad] as u: displacements that output counts from; NULL: from 0; lifts.c */
  PetscReal caution;     /* [-] factor by which the step of a static stage is shortened; energy_check.c */
  PetscInt64 cycle;      /* cycles since the start of the run */
  PetscReal time;        /* [s] since the start of the first dynamic stage */
  PetscReal *u_verified; /* (n_dof,) u at the last verification of contacts; NULL: never verified; verify.c */
  Applied applied;       /* the parts of f_ext */
  void **terms;          /* memory of each force term; terms.c */
  Vec displacement, velocity; /* (n_dof,) own the memory of u, v */
  Vec force, force_old;       /* own that of f, f_old, and change places with them */
  Vec load, mass;             /* own that of f_ext, m */
} State;

/* ---- model.c */
/* Row of the owned rigid body of the owned rigid vertex v, by bisection. */
PetscInt RigidOfVertex(const Model *model, PetscInt v);
/* Vertices that force terms couple, besides those that meet in blocks and contacts, on all ranks. A rank that
   owns a vertex of a group has the others of the group as ghosts, whose local numbers never change. */
typedef struct {
  PetscInt n;      /* groups */
  PetscInt *start; /* (n + 1,) group i is gid[start[i]] .. gid[start[i + 1] - 1] */
  PetscInt *gid;
} Couplings;
/* Collective. Builds the flat arrays of this rank and the ghost exchange from the mesh on rank 0; finds
   mesh->part if it is NULL. */
PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, const Couplings *couplings,
                           Model *model);
PetscErrorCode ModelDestroy(Model *model);
/* ---- joint_turns.c */
/* Collective. Fills joint_turn. mesh: face sets on rank 0. */
PetscErrorCode JointTurns(const Scene *scene, const BlockMesh *mesh, Model *model);

/* ---- distribute.c */
/* The description of a point of the Plex. */
typedef struct {
  PetscInt gid;       /* number of the block or vertex */
  PetscInt file;      /* file id */
  PetscInt owner;     /* rank; of a vertex, the rank that moves it */
  PetscInt body;      /* macroblock */
  PetscInt rigid;     /* rigid body, -1: none */
  PetscInt condensed; /* condensed body, -1: none */
  PetscInt group;     /* of a block */
  PetscInt outer;     /* of a block: bit k is set when face k is an outer one */
  PetscInt inner;     /* of a vertex: 1: it belongs to a condensed body and is not kept */
  PetscInt calm;      /* as inner, or it is kept only for a support, water or a probe */
  PetscReal X[2];     /* [m] of a vertex */
} PointRecord;
/* The part of the mesh that a rank gets: the blocks that touch a vertex it owns, and all vertices of these
   blocks. */
struct _p_DM;
typedef struct {
  PetscInt n_blocks, n_points; /* the points are blocks, then vertices, each by ascending gid */
  struct _p_DM *dm;            /* the cone of a block is its vertices along the ring */
  PointRecord *record;         /* (n_points,) */
  PetscSF migration;           /* from the points of the whole mesh on rank 0; NULL: one rank, which has all
                                  points */
} DealtMesh;
/* Collective. Numbers the bodies, finds mesh->part if it is NULL, and distributes the mesh. model, with its
   comm, gets the ranks and the numbers that describe the whole mesh. */
PetscErrorCode MeshDistribute(const Scene *scene, BlockMesh *mesh, Model *model, DealtMesh *dealt);

/* ---- neighbours.c */
/* Collective. Finds the outer faces of other ranks near those of this rank in the present state (state NULL:
   in the reference state), then the ghosts and the exchange for them. Rewrites model->faces, the contact
   ghosts and model->ghost; lengthens the state's arrays. */
PetscErrorCode NeighboursUpdate(Model *model, State *state);
/* Makes the faces of local blocks, by ascending gid. To be called before the first NeighboursUpdate; the
   element ghosts must be known. */
PetscErrorCode FacesCreate(Model *model, PetscInt n, const FaceRecord *face);
PetscErrorCode FacesDestroy(Model *model);
/* Returns the local number of the vertex with this gid, owner rank and local index there; -1: this rank
   neither owns it nor has it as a ghost. */
PetscInt LocalVertex(const Model *model, PetscInt gid, PetscMPIInt owner, PetscInt index);
/* Sorts by gid and drops repetitions; returns the remaining number. */
PetscInt GhostsUnique(PetscInt n, GhostRecord *ghosts);
/* Makes room for n_owned + n_ghosts vertices and the dummies; keeps the values. */
PetscErrorCode VerticesResize(Model *model);
PetscErrorCode VerticesFree(Model *model);

/* ---- state.c */
/* Makes room for `new` entries of `size` bytes in *array (NULL: it has none so far). The first `old` entries
   stay, the others are zero. */
PetscErrorCode ArrayGrow(size_t size, PetscInt old, PetscInt new, void *array);
/* Makes room for model->vertex_capacity vertices in the arrays of the state, in the same way. */
PetscErrorCode StateResize(const Model *model, State *state);
/* Returns whether a support holds the degree of freedom d. */
static inline PetscBool Held(const Model *m, PetscInt d)
{
  return (PetscBool)(m->support[d] >= 0);
}
/* Returns the row of the support that holds d, -1: none; vertices that are not built yet have no support. */
enum { NOT_BUILT = INT16_MAX };
static inline PetscInt SupportRow(const Model *m, PetscInt d)
{
  return m->support[d] == NOT_BUILT ? -1 : m->support[d];
}
/* Returns whether the block of a face is not built yet. */
static inline PetscBool FaceAbsent(const Model *m, PetscInt face)
{
  return (PetscBool)(m->absent && m->absent[m->faces.group[face]]);
}
/* Returns the displacement [m, rad] that is written. */
static inline PetscReal Shown(const State *state, PetscInt d)
{
  return state->reset ? state->u[d] - state->reset[d] : state->u[d];
}
/* Returns the macroblock, or the true mass [kg, kg m2], of a degree of freedom < n_dof. */
static inline PetscInt DofBody(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->n_bodies;
  return d < at ? m->body_body[d / 3] : m->vertex_body[(d - at) / 2];
}
static inline PetscReal DofMass(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->n_bodies;
  return d < at ? m->body_mass[2 * (d / 3) + (d % 3 == 2)] : m->vertex_mass[(d - at) / 2];
}
/* Returns whether a list of Model.elements has rigid bodies. */
static inline PetscBool ListIsRigid(const Model *m, const Elements *list)
{
  return (PetscBool)(list >= m->elements + DEFORMABLE_LISTS && list < m->elements + MOVING_LISTS);
}
/* Returns whether a degree of freedom belongs to a kept vertex of a condensed body. */
static inline PetscBool IsCondensed(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->n_bodies;
  return (PetscBool)(m->vertex_condensed && d >= at && m->vertex_condensed[(d - at) / 2] >= 0);
}
static inline PetscInt ModelApplied(const Model *m)
{ // number of entries of f_ext and support on this rank, including inner vertices
  return 3 * m->n_bodies + 2 * m->n_owned;
}
/* Length [m] that turns a rotation dof into a displacement and a moment into a force: sqrt(I/m) of the scaled
   masses of its body; 1 for other dofs. */
PetscReal DofLength(const Model *model, const State *state, PetscInt d);
/* The component along degree of freedom d of a vector (2,); 0 along rotations. */
static inline PetscReal DofGround(const Model *m, PetscInt d, const PetscReal vector[2])
{
  const PetscInt at = 3 * m->n_bodies;
  if (d >= at) return vector[(d - at) % 2];
  return d % 3 < 2 ? vector[d % 3] : 0.;
}
/* Collective. Creates the undeformed state, at rest. */
PetscErrorCode StateCreate(const Scene *scene, const Model *model, State *state);
PetscErrorCode StateDestroy(State *state);
/* Gives the arrays back to the Vecs, which may then be read and changed; u, v, ... are NULL. */
PetscErrorCode StateGive(State *state);
/* Takes the arrays of the Vecs for the loop. */
PetscErrorCode StateTake(State *state);
/* Collective. Shows by PETSc's viewers the Vecs that the user's options name (-displacement_view and so
   on). */
PetscErrorCode StateView(State *state);
/* Makes the present force the force of the last cycle; the next force takes its memory. */
static inline void StateSwapForces(State *s)
{
  PetscReal *const f = s->f;
  const Vec force = s->force;
  s->f = s->f_old, s->f_old = f;
  s->force = s->force_old, s->force_old = force;
}

/* ---- valid.c */
/* Check internal consistency, for tests and debug builds; collective. */
PetscErrorCode ModelIsValid(const Model *model, PetscBool *valid);

/* ---- ghost.c */
/* Prepares the exchange for the present model->ghosts. */
PetscErrorCode GhostConnect(Model *model);
PetscErrorCode GhostDestroy(Model *model);
PetscErrorCode GhostBegin(const Model *model, PetscReal *u);
PetscErrorCode GhostEnd(const Model *model, PetscReal *u);

/* Returns the row of the face with this gid, -1: this rank does not know it. */
PetscInt FaceRow(const Model *m, PetscInt gid);
/* Finds the ends of a face: present ones with u (vertex array), reference ones if u is NULL. */
static inline void FaceCoordinates(const Model *m, const PetscReal *u, PetscInt f, PetscReal x[4])
{
  for (int i = 0; i < 4; i++) {
    const PetscInt at = 2 * m->faces.vertex[2 * f + i / 2] + i % 2;
    x[i] = u ? m->X[at] + u[at] : m->X[at];
  }
}

/* model.h: declares the model of a rank: its mesh, materials, bodies, faces and ghosts. Each array has its
   meaning, [unit], (shape) and, where it is not the owner of the part, its writer. Conventions: base.h. */
#pragma once
#include "model/bodies.h"
#include "model/local_mesh.h"
#include "model/materials.h"
#include "model/neighbours.h"
#include "model/state.h"

/* Flat arrays of one rank, constant during the run but for the ghosts of contacts. Degrees of freedom (what
   integrate.c steps): [ 3 per owned rigid body | 2 per owned deformable vertex ]. A dof array has the vertex
   array right behind its bodies: u_vertex = u + 3 rigid.n, so that for deformable vertices the dof IS the
   vertex entry. */
typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank, size;
  PetscBool one_machine; /* the ranks share memory and exchange through it */

  LocalMesh mesh;
  Materials materials;
  RigidBodies rigid;
  CondensedBodies condensed;
  Faces faces;
  Ghosts ghosts;

  /* degrees of freedom; create.c */
  PetscInt n_dof;         /* 3 rigid.n + 2 n_deformable */
  PetscReal *vertex_mass; /* [kg] (n_owned,) true lumped masses (26)-(27) of deformable blocks */
  int16_t *support; /* (3 rigid.n + 2 n_owned,) row of Scene.supports that holds the dof, -1: it is free;
                             inner vertices come after n_dof; supports.c */
  PetscReal *in_quotient; /* (n_dof,) 1: the dof enters the Rayleigh quotient, 0: not; NULL: all enter */

  PetscReal contact_margin; /* [m] faces nearer than this may be in contact; distribute.c */
  PetscReal contact_depth; /* [m] deepest overlap or widest opening of a contact at the last search, 0: within
                                the margin; verify.c */
  PetscReal contact_pressed; /* [m] deepest overlap at the last search; verify.c */
  struct _p_Lifts *lifts;    /* times at which groups are built; NULL: none is; lifts.c */
} Model;

/* ---- model.c */
/* Returns the row of the owned rigid body that has the owned rigid vertex v. */
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
/* Collective. Finds the outer faces of other ranks near the outer faces of this rank in the present state
   (state NULL: in the reference state), then the ghosts and the exchange for them. Rewrites model->faces, the
   contact ghosts and their exchange; lengthens the state's arrays. */
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
/* Makes room for model->mesh.vertex_capacity vertices in the arrays of the state, in the same way. */
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
  return (PetscBool)(m->materials.absent && m->materials.absent[m->faces.group[face]]);
}
/* Returns the macroblock, or the true mass [kg, kg m2], of a degree of freedom < n_dof. */
static inline PetscInt DofBody(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->rigid.n;
  return d < at ? m->rigid.body[d / 3] : m->mesh.vertex_body[(d - at) / 2];
}
static inline PetscReal DofMass(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->rigid.n;
  return d < at ? m->rigid.mass[2 * (d / 3) + (d % 3 == 2)] : m->vertex_mass[(d - at) / 2];
}
/* Returns whether a list of LocalMesh.elements has rigid bodies. */
static inline PetscBool ListIsRigid(const Model *m, const Elements *list)
{
  return (PetscBool)(list >= m->mesh.elements + DEFORMABLE_LISTS && list < m->mesh.elements + MOVING_LISTS);
}
/* Returns whether a degree of freedom belongs to a kept vertex of a condensed body. */
static inline PetscBool IsCondensed(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->rigid.n;
  return (PetscBool)(m->mesh.vertex_condensed && d >= at && m->mesh.vertex_condensed[(d - at) / 2] >= 0);
}
/* Returns the number of entries of f_ext and support on this rank, including inner vertices. */
static inline PetscInt ModelApplied(const Model *m)
{
  return 3 * m->rigid.n + 2 * m->mesh.n_owned;
}
/* Returns the length [m] that turns a rotation dof into a displacement and a moment into a force:
   sqrt(I/m) of the scaled masses of its body; 1 for other dofs. */
PetscReal DofLength(const Model *model, const State *state, PetscInt d);
/* Returns the component of a vector (2,) along the degree of freedom d; 0 for rotations. */
static inline PetscReal DofGround(const Model *m, PetscInt d, const PetscReal vector[2])
{
  const PetscInt at = 3 * m->rigid.n;
  if (d >= at) return vector[(d - at) % 2];
  return d % 3 < 2 ? vector[d % 3] : 0.;
}
/* Collective. Creates the undeformed state, at rest. */
PetscErrorCode StateCreate(const Scene *scene, const Model *model, State *state);
/* Makes u_verified, with zeros, where it is not there yet. */
PetscErrorCode StateVerifies(const Model *model, State *state);
PetscErrorCode StateDestroy(State *state);

/* ---- ghost.c */
/* Prepares the exchange for the present ghosts. */
PetscErrorCode GhostConnect(Model *model);
PetscErrorCode GhostDestroy(Model *model);
/* Begins the exchange of u (vertex array); GhostEnd ends it and fills in the ghosts. */
PetscErrorCode GhostBegin(const Model *model, PetscReal *u);
PetscErrorCode GhostEnd(const Model *model, PetscReal *u);

/* Returns the row of the face with this gid, -1: this rank does not know it. */
PetscInt FaceRow(const Model *m, PetscInt gid);
/* Returns the rows of the faces of a set that this rank knows, (*n,); none if no set has this name. */
static inline const PetscInt *FacesOfSet(const Model *m, const char *name, PetscInt *n)
{
  const PetscInt set = NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, name),
                 from = set < 0 ? 0 : m->mesh.face_set_start[set];
  *n = set < 0 ? 0 : m->mesh.face_set_start[set + 1] - from;
  return *n ? m->mesh.face_set_faces + from : NULL;
}
/* Finds the ends of a face: present ones with u (vertex array), reference ones if u is NULL. */
static inline void FaceCoordinates(const Model *m, const PetscReal *u, PetscInt f, PetscReal x[4])
{
  for (int i = 0; i < 4; i++) {
    const PetscInt at = 2 * m->faces.vertex[2 * f + i / 2] + i % 2;
    x[i] = u ? m->mesh.X[at] + u[at] : m->mesh.X[at];
  }
}

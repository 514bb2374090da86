/* local_mesh.h: declares the part of the mesh that one rank has: its vertices, elements and named sets. */
#pragma once
#include "mesh/mesh.h"

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

/* The lists of LocalMesh.elements: deformable ones, law by law; rigid ones; condensed ones. Each kind has
   quadrilaterals, then triangles. */
enum {
  ELASTIC_LISTS = 2,
  DEFORMABLE_LISTS = 2 * MATERIAL_LAWS,
  MOVING_LISTS = DEFORMABLE_LISTS + 2,
  ELEMENT_LISTS = MOVING_LISTS + 2
};

/* Local order of vertices:
     [ owned deformable, by gid | owned rigid, by body then gid | owned inner of condensed bodies, by body
   then gid | ghosts of elements and couplings, by gid | further ghosts of contacts, by gid | DUMMY_VERTICES
   unit square ]
   The ghosts of contacts change when blocks move (neighbours.c); nothing before them does. Kept vertices of
   condensed bodies are deformable (or rigid) ones like any other. Inner vertices stand behind all that moves:
   no loop of a cycle meets them; condense.c fills them in afterwards. Padding lanes of a batch point to the
   dummies. */
enum { DUMMY_VERTICES = 4 };

/* Owner: model.c, from the mesh that distribute.c deals out; neighbours.c appends the ghosts. */
typedef struct {
  /* the whole mesh, on all ranks; bodies: macroblocks */
  PetscInt n_vertices_global, n_blocks_global, n_bodies_global, n_rigid_global, n_condensed_global;
  PetscReal diameter; /* [m] of the bounding box of the whole mesh */

  PetscInt n_deformable;      /* owned vertices of deformable blocks */
  PetscInt n_moving;          /* n_deformable + owned rigid vertices: all vertices that move in a cycle */
  PetscInt n_owned;           /* n_moving + inner vertices of condensed bodies */
  PetscInt n_vertices;        /* n_owned + ghosts; arrays have DUMMY_VERTICES more */
  PetscInt vertex_capacity;   /* number of vertices, dummies included, that the arrays have room for */
  PetscReal *X;               /* [m] (n_vertices + DUMMY_VERTICES, 2) reference coordinates */
  PetscInt *vertex_gid;       /* (n_vertices,) */
  PetscInt *vertex_file;      /* (n_vertices,) */
  PetscInt *vertex_body;      /* (n_vertices,) macroblock */
  PetscInt *vertex_rigid;     /* (n_vertices,) rigid body (global number), -1: deformable */
  PetscBool *vertex_calm;     /* (n_owned,) whether a vertex of a condensed body is kept only for a support,
                                 water or a probe */
  PetscInt *vertex_condensed; /* (n_owned,) condensed body (global number), -1: none; NULL: no such bodies */

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
                           all their forces after this chunk; element.c */

  /* named sets, local part */
  PetscInt n_face_sets, n_points;
  char (*face_set_names)[NAME_LENGTH];
  char (*point_names)[NAME_LENGTH];
  PetscInt *face_set_start; /* (n_face_sets + 1,) into face_set_faces */
  PetscInt *face_set_faces; /* rows of Model.faces, local blocks only, in ascending gid within a set */
  PetscInt *point_vertex;   /* (n_points,) local vertex, a ghost too; -1: not on this rank */
} LocalMesh;

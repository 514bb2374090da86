/* mesh.h: declares the block mesh on rank 0: reading, checks, numbering and distribution. */
#pragma once
#include "scene/scene.h"

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
  PetscInt *blocks;      /* (n_blocks,4) counter-clockwise, -1 in the last column of a triangle */
  PetscInt *block_group; /* (n_blocks,) */
  PetscInt *body;        /* (n_blocks,) macroblock = connected component of blocks over shared vertices */
  PetscInt n_bodies;     /* number of macroblocks */
  PetscInt *part;        /* (n_blocks,) rank of each block, NULL: not distributed yet */
  PetscInt *block_file, *vertex_file; /* file id of each block and vertex (identity until MeshReorder) */
  char (*group_names)[NAME_LENGTH];   /* on all ranks */
  PetscInt *group_rigid;              /* (n_groups,) on all ranks; 1: rigid, after the scene's override */
  FaceSet *face_sets;
  char (*point_names)[NAME_LENGTH];    /* on all ranks */
  PetscInt *point_vertex;              /* (n_points,) */
  char (*face_set_names)[NAME_LENGTH]; /* (n_face_sets) on all ranks */
} BlockMesh;

/* The body of each block, on rank 0: a body of connected rigid blocks (MeshConnected), or of connected
   condensed ones (MeshCondensed). Each body stays whole on one rank. */
typedef struct {
  PetscInt n_rigid, n_condensed;
  PetscInt *rigid, *condensed; /* (n_blocks,) number of the body, -1: none */
  PetscBool *inner;            /* (n_vertices,) the vertex belongs to a condensed body and is not kept */
  PetscBool *calm; /* (n_vertices,) as inner, or the vertex is kept only for a support, water or a probe */
} BodyNumbers;

/* ---- resolve.c */
/* Collective. Checks the names in the scene against the mesh and completes the materials; see resolve.c. */
PetscErrorCode SceneResolve(MPI_Comm comm, Scene *scene, const BlockMesh *mesh);

/* ---- mesh_file.c */
/* Collective. Reads the file on rank 0. */
PetscErrorCode MeshRead(MPI_Comm comm, const char *path, BlockMesh *mesh);
/* Collective. Calls MeshSeparate for the groups whose material says macroblocks: false; for a sound mesh. */
PetscErrorCode MeshTakeApart(MPI_Comm comm, const Scene *scene, BlockMesh *mesh);
PetscErrorCode MeshDestroy(BlockMesh *mesh);

/* ---- check.c */
/* Rank 0. Makes all checks of docs/mesh_format.md; message: the first fault, "" when the mesh is good. */
PetscErrorCode MeshCheck(const BlockMesh *mesh, PetscReal overlap_tolerance, char message[MESSAGE_LENGTH]);
/* Rank 0. Finds the first two macroblocks that overlap deeper than the tolerance [m], at the present places
   of vertices; "" when none do. The mesh must be sound. */
PetscErrorCode MeshOverlap(const BlockMesh *mesh, PetscReal tolerance, char message[MESSAGE_LENGTH]);
/* Rank 0. Counts the blocks with an aspect ratio above 1000, and finds the file id and ratio of the worst;
   -1: none. The mesh must be sound. */
void MeshSlender(const BlockMesh *mesh, PetscInt *n, PetscInt *worst, PetscReal *ratio);

/* ---- order.c */
/* Puts vertices, blocks and macroblocks into an order of small bandwidth; on rank 0 only. */
PetscErrorCode MeshReorder(BlockMesh *mesh);

/* ---- topology.c */
/* Returns the number of vertices of a block: 4, or 3 of a triangle. */
static inline PetscInt BlockCorners(const PetscInt *block)
{
  return block[3] < 0 ? 3 : 4;
}
/* Writes body and n_bodies, numbered by first appearance. */
PetscErrorCode MeshBodies(BlockMesh *mesh);
/* Rank 0. Gives the blocks of the marked groups, (n_groups,), vertices of their own. A vertex of several
   blocks stays with the blocks of other groups, else with the first block; the others get copies, after all
   vertices. A named point stays with the old vertex. */
PetscErrorCode MeshSeparate(BlockMesh *mesh, const PetscBool *separate);
/* Numbers the edges of all blocks by first appearance. edge_vertices: (n_edges,2) in the direction of the
   first block that has the edge. block_edges: (n_blocks,4) edge of face k; -(edge + 1) when the block runs it
   the other way, PETSC_MIN_INT for the missing fourth of a triangle. Free both with PetscFree. */
PetscErrorCode MeshEdges(const BlockMesh *mesh, PetscInt *n_edges, PetscInt **edge_vertices,
                         PetscInt **block_edges);
#define EDGE_INDEX(e) ((e) < 0 ? -((e) + 1) : (e)) /* edge of an entry of block_edges */
/* Lists the faces that only one block has. faces: (n,2) block, k, ascending; free with PetscFree. */
PetscErrorCode MeshOuterFaces(const BlockMesh *mesh, PetscInt *n, PetscInt **faces);
/* Finds the longest face and the diameter of the bounding box [m]; both 0 without a mesh. */
void MeshMeasures(const BlockMesh *mesh, PetscReal *longest, PetscReal *diameter);
PetscErrorCode MeshVertexBlocks(const BlockMesh *mesh, PetscInt **start, PetscInt **blocks);
/* Lists outer faces (n,2) block, k, and their boxes (n,4) grown by `margin` [m]; free both with PetscFree. */
PetscErrorCode MeshOuterBoxes(const BlockMesh *mesh, PetscReal margin, PetscInt *n, PetscInt **faces,
                              PetscReal **box);

/* ---- locate.c */
/* Returns how far [m] outside a block a point of the scene may lie and still be in it, for a mesh of this
   diameter. */
PetscReal LocateTolerance(PetscReal diameter);
/* Decides whether a block, n corners x (n,2) counter-clockwise, contains the point. weight: (4,) its shape
   functions there, 0 for the fourth corner of a triangle. */
PetscBool LocateInBlock(PetscInt n, const PetscReal *x, const PetscReal point[2], PetscReal tolerance,
                        PetscReal weight[4]);
/* Decides whether more than a point of the line from a to b is in a block. t: start and end of this part, 0
   at a, 1 at b; leaves: face through which the line leaves, -1: it ends inside. */
PetscBool LocateLine(PetscInt n, const PetscReal *x, const PetscReal a[2], const PetscReal b[2],
                     PetscReal tolerance, PetscReal t[2], PetscInt *leaves);
/* Rank 0. Calls `take` for each block on which an anchor acts: those at its ends, or all blocks along a
   bonded anchor. */
PetscErrorCode LocateAnchor(const BlockMesh *mesh, const Anchor *anchor,
                            PetscErrorCode (*take)(const BlockMesh *mesh, PetscInt block, void *context),
                            void *context);

/* ---- grid.c */
/* Computes the box of the face from a to b, grown by margin on all sides. */
static inline void FaceBox(const PetscReal a[2], const PetscReal b[2], PetscReal margin, PetscReal box[4])
{
  box[0] = PetscMin(a[0], b[0]) - margin, box[1] = PetscMin(a[1], b[1]) - margin;
  box[2] = PetscMax(a[0], b[0]) + margin, box[3] = PetscMax(a[1], b[1]) + margin;
}
/* Visits each pair i < j of boxes that overlap or touch, in an order of its own, until the visitor stops it.
   box: [m] (n,4) xmin ymin xmax ymax, finite. The cost is O(n), and a little more for each power of two
   between the sizes. */
typedef PetscErrorCode (*GridVisitor)(PetscInt i, PetscInt j, PetscBool *stop, void *context);
PetscErrorCode GridVisit(PetscInt n, const PetscReal *box, GridVisitor visit, void *context);
/* Puts the same pairs, both ways, into rows: near[start[i] .. start[i + 1] - 1] are the boxes near box i,
   ascending. filter: keeps the pairs (i < j) for which it is true; NULL: all. Free both with PetscFree. */
typedef PetscBool (*GridFilter)(PetscInt i, PetscInt j, const void *context);
PetscErrorCode GridRows(PetscInt n, const PetscReal *box, GridFilter filter, const void *context,
                        PetscInt **start, PetscInt **near);

/* ---- bodies.c */
/* Rank 0. Finds bodies of blocks of the chosen groups, (n_groups,), that are connected by vertices. body:
   (n_blocks,) number of the block's body, -1: its group is not chosen; free with PetscFree. */
PetscErrorCode MeshConnected(const BlockMesh *mesh, const PetscInt *chosen, PetscInt *n_bodies,
                             PetscInt **body);
/* Rank 0. Finds the condensed bodies and their inner vertices: bodies->condensed, inner,
   calm. */
PetscErrorCode MeshCondensed(const Scene *scene, const BlockMesh *mesh, PetscReal margin,
                             BodyNumbers *bodies);

/* ---- partition.c */
/* Finds the rank of each block. part: (n_blocks,). margin [m]: faces nearer than this are neighbours. */
PetscErrorCode PartitionBlocks(const BlockMesh *mesh, const BodyNumbers *bodies, PartitionKind kind,
                               PetscReal margin, PetscMPIInt n_parts, PetscInt *part);

/* ---- mesh_checksum.c */
/* Rank 0. Returns the checksum of a renumbered mesh: another mesh, or another rigid group, changes it. */
uint64_t MeshChecksum(const BlockMesh *mesh);

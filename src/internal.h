/* internal.h: prototypes between the files of src/, in data-flow order. "Collective" is said where it holds; all else is
   local to the rank. Functions return a PETSc error code. */
#pragma once
#include "quoin.h"
#include "types.h"

/* ---- quoin.c: errors. One line on stderr from rank 0, no trace; returns PETSC_ERR_USER_INPUT on all ranks. */
/* Collective. message: what is wrong, as found by rank 0 or any rank ("" where nothing is); fails on all ranks with the
   message of the lowest rank that has one. */
PetscErrorCode CheckMessage(MPI_Comm comm, const char *message);
PetscErrorCode QuoinErrorHandlerPush(void);

/* ---- scene.c */
/* Collective. file: YAML scene or NULL; argv: "-key value" pairs that override it. Fails on unknown keys. */
PetscErrorCode SceneRead(MPI_Comm comm, const char *file, int argc, char **argv, Scene *scene);
/* Collective. Checks the names in the scene against the mesh and completes materials; see scene.c. */
PetscErrorCode SceneResolve(MPI_Comm comm, Scene *scene, const BlockMesh *mesh);
/* Prints every key with meaning, unit and default (what -help shows and docs/scene.md contains). */
PetscErrorCode SceneHelp(MPI_Comm comm);
PetscErrorCode SceneDestroy(Scene *scene);

/* ---- mesh.c */
/* Collective; the file is read on rank 0. */
PetscErrorCode MeshRead(MPI_Comm comm, const char *path, BlockMesh *mesh);
/* Rank 0: every check of docs/mesh_format.md; message receives the first fault, "" when the mesh is good. */
PetscErrorCode MeshCheck(const BlockMesh *mesh, PetscReal overlap_tolerance, char message[MESSAGE_LENGTH]);
/* Rank 0 (elsewhere nothing happens): vertices, blocks and macroblocks into an order of small bandwidth. */
PetscErrorCode MeshReorder(BlockMesh *mesh);
PetscErrorCode MeshDestroy(BlockMesh *mesh);

/* ---- mesh_topology.c (with MeshReorder) */
/* Writes body and n_bodies, numbered by first appearance. */
PetscErrorCode MeshBodies(BlockMesh *mesh);
/* Edges of all blocks, numbered by first appearance. edge_vertices: (n_edges,2) in the direction of the first block that
   has the edge. block_edges: (n_blocks,4) edge of face k, -(edge + 1) when the block runs it the other way, PETSC_MIN_INT
   for the missing fourth of a triangle. Free both with PetscFree. */
PetscErrorCode MeshEdges(const BlockMesh *mesh, PetscInt *n_edges, PetscInt **edge_vertices, PetscInt **block_edges);
#define EDGE_INDEX(e) ((e) < 0 ? -((e) + 1) : (e)) /* of an entry of block_edges */
/* faces: (n,2) block, k of the faces that one block only has, ascending; free with PetscFree. */
PetscErrorCode MeshOuterFaces(const BlockMesh *mesh, PetscInt *n, PetscInt **faces);

/* ---- grid.c: knows boxes only */
/* Box of the face from a to b, grown by margin on all sides. */
static inline void FaceBox(const PetscReal a[2], const PetscReal b[2], PetscReal margin, PetscReal box[4])
{
  box[0] = PetscMin(a[0], b[0]) - margin, box[1] = PetscMin(a[1], b[1]) - margin;
  box[2] = PetscMax(a[0], b[0]) + margin, box[3] = PetscMax(a[1], b[1]) + margin;
}
/* box: [m] (n,4) xmin ymin xmax ymax. pairs: (n_pairs,2) i < j, ascending, of boxes that overlap or touch; free with
   PetscFree. Boxes are finite; cost O(n), a little more for each power of two between the sizes. */
PetscErrorCode GridPairs(PetscInt n, const PetscReal *box, PetscInt *n_pairs, PetscInt **pairs);

/* ---- rigid.c (numbering at set-up) */
/* Rank 0. rigid: (n_blocks,) number of the rigid body a block belongs to (connected rigid blocks), -1: deformable. */
PetscErrorCode MeshRigidBodies(const BlockMesh *mesh, PetscInt *n_rigid, PetscInt **rigid);

/* ---- partition.c: rank 0 only */
PetscErrorCode MeshVertexBlocks(const BlockMesh *mesh, PetscInt **start, PetscInt **blocks);
PetscErrorCode MeshNearBlocks(const BlockMesh *mesh, PetscReal margin, PetscInt *n_pairs, PetscInt **pairs);
/* part: (n_blocks,) rank of each block. rigid: see MeshRigidBodies. margin [m]: faces nearer than this are neighbours. */
PetscErrorCode PartitionBlocks(const BlockMesh *mesh, const PetscInt *rigid, PetscReal margin, PetscMPIInt n_parts, PetscInt *part);

/* ---- distribute.c: what a point of the Plex (block, vertex, face) is */
typedef struct {
  PetscInt gid;   /* block, vertex: its number; outer face: 4 * block gid + k; inner face: -1 */
  PetscInt file;  /* block, vertex: file id */
  PetscInt group; /* block */
  PetscInt body;  /* block, vertex: macroblock */
  PetscInt rigid; /* block, vertex: rigid body, -1: none */
} PointRecord;
struct _p_DM;
/* Collective. mesh, rigid on rank 0. plex: distributed with one layer of overlap; records: (points of its chart,). */
PetscErrorCode MeshDistribute(MPI_Comm comm, const BlockMesh *mesh, const PetscInt *rigid, PetscReal margin, struct _p_DM **plex,
                              PointRecord **records);

/* ---- model.c */
/* Collective. Builds the flat arrays of this rank (see types.h) and the ghost exchange from the mesh on rank 0. */
PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, Model *model);
PetscErrorCode ModelDestroy(Model *model);
/* Collective. Sum over owned vertices, bodies and contacts of a hash of (number, bits of the state): the same on any number
   of ranks when every bit is. */
PetscErrorCode StateChecksum(const Model *model, const State *state, const Contacts *contacts, uint64_t *checksum);
/* Collective checks of internal consistency, for tests and debug builds. */
PetscErrorCode ModelIsValid(const Model *model, PetscBool *valid);

/* ---- element.c */
/* Adds the resisting force (10) of deformable elements to f. u, f: vertex arrays [m], [N] (n_vertices + dummies, 2). */
PetscErrorCode ElementForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Adds row sums (28) to k [N/m] and lumped masses (26)-(27) to m [kg], both (n_vertices + dummies,). */
PetscErrorCode ElementStiffness(const Model *model, PetscReal *k);
PetscErrorCode ElementMasses(const Model *model, PetscReal *m);
/* Cauchy stress sxx syy sxy [Pa] (n,3) at the centre of each element of the list. */
PetscErrorCode ElementStress(const Model *model, const Elements *e, int n_nodes, const PetscReal *u, PetscReal *stress);
/* Cauchy stress at the Gauss points: T3 (n,1,3), Q4 (n,4,3) in the order (-,-), (+,-), (+,+), (-,+). */
PetscErrorCode ElementStressGauss(const Model *model, const Elements *e, int n_nodes, const PetscReal *u, PetscReal *stress);
/* Strain energy [J] of one element list's owned elements (n,). */
PetscErrorCode ElementEnergy(const Model *model, const Elements *e, int n_nodes, const PetscReal *u, PetscReal *energy);
/* Principal stresses s1 >= s2 of (sxx,syy,sxy) and angle [rad] of s1 from x. */
void PrincipalStress(const PetscReal s[3], PetscReal principal[2], PetscReal *angle);

/* ---- stress_models.c */
extern const char *const StressModels[]; /* PetscEnum-style list of names: pt r2pt r3pt t2pt t3pt tptm, "StressModelKind", "STRESS_" , NULL */
/* The elastic row of a model: F_end0 = L (a s0 + b s1), F_end1 = L (b s0 + a s1). */
void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b);
/* Response of ONE contact whose joint law is broken somewhere (or has residual parts); see stress_models.c. */
typedef struct {
  PetscReal u_n[2], u_s[2];     /* in: [m] at the two ends, openings already reduced by `rest` */
  PetscReal slip[2], broken[2]; /* in: history at the start of the step; out: at its end */
  PetscReal sigma[2], tau[2];   /* out: [Pa] at the ends */
  PetscReal F_n[2], F_s[2];     /* out: [N/m] end forces per metre of thickness, same sign as sigma, tau */
  PetscInt state[2];            /* out: ContactState bits */
} ContactPoint;
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p);
/* True when the law holds elastically at both ends and nothing is broken: then the elastic row gives the same answer. */
/* (the vectorised form of this test stands in contact_force.c) */
PetscBool JointIsElastic(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2], const PetscReal broken[2]);

/* internal.h: prototypes between the files of src/, in data-flow order. "Collective" is said where it holds;
   all else is local to the rank. Functions return a PETSc error code. */
#pragma once
#include "quoin.h"
#include "model/types.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct _p_Archive;
struct _p_Checkpoint;
struct _p_Relaxation;
struct _p_Output;

/* ---- quoin.c: errors. One line on stderr from rank 0, no trace; returns
   PETSC_ERR_USER_INPUT on all ranks. */
/* Collective. message: what is wrong, as found by rank 0 or any rank ("" where nothing is); fails on all
   ranks with the message of the lowest rank that has one. */
PetscErrorCode CheckMessage(MPI_Comm comm, const char *message);
/* The same for reasons of other kinds, each with an exit code of its own. */
#define ERROR_OUTPUT PETSC_ERR_FILE_WRITE          /* what the run is to write cannot be written */
#define ERROR_LOCKED PETSC_ERR_FILE_OPEN           /* another run writes into the output folder */
#define ERROR_CHECKPOINT PETSC_ERR_FILE_UNEXPECTED /* a restart is not possible */
#define ERROR_MEMORY PETSC_ERR_MEM                 /* the model needs more memory than there is */
PetscErrorCode Refuse(MPI_Comm comm, PetscErrorCode code, const char *message);
PetscErrorCode QuoinErrorHandlerPush(void);
/* Whether all ranks return this error, so that the program can end in order. */
PetscBool QuoinErrorIsShared(PetscErrorCode error);
extern const char *const VerdictNames[];
/* What follows a noun after a count of n. */
static inline const char *Plural(PetscInt64 n)
{
  return n == 1 ? "" : "s";
}
/* The insides of a Quoin, for the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             struct _p_Relaxation **relax);

/* ---- petsc_options.c */
/* Into scene->solvers and, where there are any, as a line of scene->options. */
PetscErrorCode SolverOptionsTake(Scene *scene);
/* Those that nobody has asked for are misspelt, or of a solver that did not run. */
PetscErrorCode SolverOptionsTellUnread(MPI_Comm comm);

/* ---- isa.c */
/* Collective. Sets instruction_set, on which hot loops branch; refuses one that the processor has not. */
PetscErrorCode IsaSelect(MPI_Comm comm, const Scene *scene);
const char *IsaName(void);                  /* of what is set: base, v3 or v4 */
extern const char *const InstructionSets[]; /* PetscEnum-style names: widest base v3 v4 */

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
/* Rank 0, of a sound mesh, wherever its vertices are: the first two macroblocks that overlap deeper than the
   tolerance [m], "" when none do. */
PetscErrorCode MeshOverlap(const BlockMesh *mesh, PetscReal tolerance, char message[MESSAGE_LENGTH]);
/* Rank 0, of a sound mesh: how many blocks have an aspect ratio above 1000, the file id and the ratio of the
   worst (-1: none). */
void MeshSlender(const BlockMesh *mesh, PetscInt *n, PetscInt *worst, PetscReal *ratio);
/* Rank 0 (elsewhere nothing happens): vertices, blocks and macroblocks into an order of small bandwidth. */
PetscErrorCode MeshReorder(BlockMesh *mesh);
/* Collective. MeshSeparate for the groups whose material says macroblocks: false; of a sound mesh. */
PetscErrorCode MeshTakeApart(MPI_Comm comm, const Scene *scene, BlockMesh *mesh);
PetscErrorCode MeshDestroy(BlockMesh *mesh);

/* ---- mesh_topology.c (with MeshReorder) */
/* Writes body and n_bodies, numbered by first appearance. */
PetscErrorCode MeshBodies(BlockMesh *mesh);
/* Rank 0. Blocks of the groups that are marked, (n_groups,), share no vertex with any other block: a vertex
   that several blocks have stays with those of other groups, or else with the first, and the others get
   copies of it behind the rest. A named point stays with the vertex. */
PetscErrorCode MeshSeparate(BlockMesh *mesh, const PetscBool *separate);
/* Edges of all blocks, numbered by first appearance. edge_vertices: (n_edges,2) in the direction of the first
   block that has the edge. block_edges: (n_blocks,4) edge of face k, -(edge + 1) when the block runs it the
   other way, PETSC_MIN_INT for the missing fourth of a triangle. Free both with PetscFree. */
PetscErrorCode MeshEdges(const BlockMesh *mesh, PetscInt *n_edges, PetscInt **edge_vertices,
                         PetscInt **block_edges);
#define EDGE_INDEX(e) ((e) < 0 ? -((e) + 1) : (e)) /* of an entry of block_edges */
/* faces: (n,2) block, k of the faces that one block only has, ascending; free with PetscFree. */
PetscErrorCode MeshOuterFaces(const BlockMesh *mesh, PetscInt *n, PetscInt **faces);
/* Longest face and diameter of the bounding box [m]; 0 where there is no mesh. */
void MeshMeasures(const BlockMesh *mesh, PetscReal *longest, PetscReal *diameter);

/* ---- grid.c: knows boxes only */
/* Box of the face from a to b, grown by margin on all sides. */
static inline void FaceBox(const PetscReal a[2], const PetscReal b[2], PetscReal margin, PetscReal box[4])
{
  box[0] = PetscMin(a[0], b[0]) - margin, box[1] = PetscMin(a[1], b[1]) - margin;
  box[2] = PetscMax(a[0], b[0]) + margin, box[3] = PetscMax(a[1], b[1]) + margin;
}
/* Pairs i < j of boxes that overlap or touch, one by one, in an order of its own, until the visitor
   stops it. box: [m] (n,4) xmin ymin xmax ymax, finite; cost O(n), a little more for each power of
   two between the sizes. */
typedef PetscErrorCode (*GridVisitor)(PetscInt i, PetscInt j, PetscBool *stop, void *context);
PetscErrorCode GridVisit(PetscInt n, const PetscReal *box, GridVisitor visit, void *context);
/* The same pairs as rows: near[start[i] .. start[i + 1] - 1] are the boxes near box i, ascending; each pair
   is in both rows. filter: keeps the pairs (i < j) it says true to; NULL: all. Free both with PetscFree. */
typedef PetscBool (*GridFilter)(PetscInt i, PetscInt j, const void *context);
PetscErrorCode GridRows(PetscInt n, const PetscReal *box, GridFilter filter, const void *context,
                        PetscInt **start, PetscInt **near);

/* ---- rigid.c (numbering at set-up) */
/* Rank 0. Bodies of blocks of the chosen groups, (n_groups,), that hang together by vertices. body:
   (n_blocks,) number of the body of a block, -1: its group is not chosen; free with PetscFree. */
PetscErrorCode MeshConnected(const BlockMesh *mesh, const PetscInt *chosen, PetscInt *n_bodies,
                             PetscInt **body);

/* Owned bodies, their vertices, mass centres and masses, from the vertices' rigid numbers. */
PetscErrorCode RigidBodiesCreate(Model *model);
/* Row of the owned rigid body that holds the owned rigid vertex v (bisection). */
PetscInt RigidOfVertex(const Model *model, PetscInt v);
/* Sums the forces at vertices of rigid bodies into force and moment at the mass centre,
   (14)-(15). u, f: dof arrays. */
void RigidForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Displacements of vertices from those of the bodies, (21)-(22) in finite form. u: dof array. */
void RigidMotion(const Model *model, PetscReal *u);

/* ---- partition.c: rank 0 only */
PetscErrorCode MeshVertexBlocks(const BlockMesh *mesh, PetscInt **start, PetscInt **blocks);
PetscErrorCode MeshNearBlocks(const BlockMesh *mesh, PetscReal margin, PetscInt *n_pairs, PetscInt **pairs);
/* Outer faces (n,2) block, k, and their boxes (n,4) grown by `margin` [m]; free both with PetscFree. */
PetscErrorCode MeshOuterBoxes(const BlockMesh *mesh, PetscReal margin, PetscInt *n, PetscInt **faces,
                              PetscReal **box);
/* part: (n_blocks,) rank of each block. margin [m]: faces nearer than this are neighbours. work: NULL, or
   what the busiest rank computes in a cycle (four a deformable quadrilateral or contact) with part as it
   comes in and as it goes out. */
PetscErrorCode PartitionBlocks(const BlockMesh *mesh, const BodyNumbers *bodies, PartitionKind kind,
                               PetscReal margin, PetscMPIInt n_parts, PetscInt *part, PetscReal work[2]);

/* ---- distribute.c */
/* What a point of the Plex is. */
typedef struct {
  PetscInt gid;       /* block, vertex: its number */
  PetscInt file;      /* file id */
  PetscInt owner;     /* rank: of a vertex, the one that moves it */
  PetscInt body;      /* macroblock */
  PetscInt rigid;     /* rigid body, -1: none */
  PetscInt condensed; /* condensed body, -1: none */
  PetscInt group;     /* block */
  PetscInt outer;     /* block: bit k is set when face k is an outer one */
  PetscInt inner;     /* vertex: 1: of a condensed body, and not kept */
  PetscReal X[2];     /* [m] vertex */
} PointRecord;
/* What a rank was dealt: the blocks that touch a vertex it owns, and all their vertices. */
struct _p_DM;
typedef struct {
  PetscInt n_blocks, n_points; /* points: blocks, then vertices, by ascending gid each */
  struct _p_DM *dm;            /* cone of a block: its vertices along the ring */
  PointRecord *record;         /* (n_points,) */
  PetscSF migration;           /* from the whole mesh's points on rank 0; NULL: one rank, that has them all */
} DealtMesh;
/* Collective. Numbers the bodies, finds mesh->part when there is none, and deals the mesh out. model, with
   its comm: its ranks and the numbers that describe the whole mesh. */
PetscErrorCode MeshDistribute(const Scene *scene, BlockMesh *mesh, Model *model, DealtMesh *dealt);

/* ---- neighbours.c: what contacts need from other ranks */
/* Collective. Which outer faces of other ranks are near ours, in the present state (state NULL: the reference
   state), and the ghosts and exchange that follow. Rewrites model->faces, the contact ghosts and
   model->ghost; grows the state's arrays. */
PetscErrorCode NeighboursUpdate(Model *model, State *state);
/* The faces of local blocks, ascending gid; element ghosts must be known. Before the
   first NeighboursUpdate. */
PetscErrorCode FacesCreate(Model *model, PetscInt n, const FaceRecord *face);
PetscErrorCode FacesDestroy(Model *model);
/* Local number of the vertex with this gid, owner rank and local index there; -1:
   neither owned nor a ghost. */
PetscInt LocalVertex(const Model *model, PetscInt gid, PetscMPIInt owner, PetscInt index);
/* Sorts by gid, drops repetitions, returns how many remain. */
PetscInt GhostsUnique(PetscInt n, GhostRecord *ghosts);
/* Makes room for n_owned + n_ghosts vertices and the dummies; keeps what is there. */
PetscErrorCode VerticesResize(Model *model);
PetscErrorCode VerticesFree(Model *model);
/* The state's vertex arrays, likewise. */
PetscErrorCode StateResize(const Model *model, State *state);

/* ---- model.c */
/* Collective. Builds the flat arrays of this rank (see types.h) and the ghost exchange from the mesh on rank
   0; finds mesh->part when there is none. */
PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, Model *model);
PetscErrorCode ModelDestroy(Model *model);

/* ---- checksum.c */
/* Collective. Sum over owned vertices, bodies and contacts of a hash of (number, bits of the state): the same
   on any number of ranks when every bit is. */
PetscErrorCode StateChecksum(const Model *model, const State *state, const Contacts *contacts,
                             uint64_t *checksum);
/* Any change of a bit changes it. */
uint64_t HashBytes(uint64_t seed, const void *data, size_t bytes);
/* Rank 0. Of all that a renumbered mesh holds: another mesh, or another group that is rigid, has another. */
uint64_t MeshChecksum(const BlockMesh *mesh);
/* Collective checks of internal consistency, for tests and debug builds. */
PetscErrorCode ModelIsValid(const Model *model, PetscBool *valid);

/* ---- element.c */
/* Adds the resisting force (10) of deformable elements to f. u, f: vertex arrays [m], [N]
   (n_vertices + dummies, 2). */
PetscErrorCode ElementForces(const Model *model, const PetscReal *u, PetscReal *f);
/* The same of condensed ones, small strain. */
void ElementForcesCondensed(const Model *model, const PetscReal *u, PetscReal *f);
/* Stiffness [N/m] of four elements from `first` (a multiple of 4) on: entry (i,j) of element first + l is
   K[l][i * 2 n_nodes + j], rows x, y of vertex 0, x, y of vertex 1, ... u: vertex array [m]: the tangent
   there in large strain; NULL: that of the reference state. */
void ElementMatrices(const Model *model, const Elements *e, int n_nodes, PetscInt first, const PetscReal *u,
                     PetscReal K[][64]);
/* What is to be in the cache soon. */
enum { AHEAD_ARRAYS = 5 };
typedef struct {
  const PetscReal *array[AHEAD_ARRAYS];
} Ahead;
/* The same, one chunk of elements after the other, so that vertices can be moved as soon
   as model->chunk_done[chunk] says that their forces are complete. ahead: what will be
   read then, NULL: nothing. */
PetscInt ElementChunks(const Model *model);
void ElementForcesOfChunk(const Model *model, PetscInt chunk, const Ahead *ahead, const PetscReal *u,
                          PetscReal *f);
/* Set-up: writes model->chunk_done. */
PetscErrorCode ElementChunksDone(Model *model);
/* Stiffness [Pa] of a one-point block against its hourglass modes, see element_kernels.h: Q4OnePointForce;
   zero for ELEMENT_FULL. coefficient: of ELEMENT_REDUCED. */
void ElementHourglass(Formulation element, Lame lame, PetscReal coefficient, PetscReal hourglass[3]);
/* Adds row sums (28) to k [N/m] and lumped masses (26)-(27) to m [kg], both (n_vertices + dummies,). */
PetscErrorCode ElementStiffness(const Model *model, PetscReal *k);
PetscErrorCode ElementMasses(const Model *model, PetscReal *m);
/* Cauchy stress sxx syy sxy [Pa] (n,3) at the centre of each element of the list. */
PetscErrorCode ElementStress(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *stress);
/* Cauchy stress at the Gauss points: T3 (n,1,3), Q4 (n,4,3) in the order (-,-), (+,-), (+,+), (-,+). */
PetscErrorCode ElementStressGauss(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                                  PetscReal *stress);
/* Strain energy [J] of one element list's owned elements (n,). */
PetscErrorCode ElementEnergy(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *energy);
/* Principal stresses s1 >= s2 of (sxx,syy,sxy) and angle [rad] of s1 from x. */
void PrincipalStress(const PetscReal s[3], PetscReal principal[2], PetscReal *angle);
/* Exact area [m2], centroid [m] and polar second moment about the centroid [m4] of one block; vertices:
   (n_nodes,) ccw rows of X (n,2) [m]. */
void BlockGeometry(const PetscReal *X, const PetscInt *vertices, int n_nodes, PetscReal *area,
                   PetscReal centroid[2], PetscReal *polar);

/* ---- condense.c: condensed bodies. Vertex arrays throughout. */
/* Entries of u, f_ext, support that belong to this rank, those of inner vertices included. */
static inline PetscBool Held(const Model *m, PetscInt d)
{
  return (PetscBool)(m->support[d] >= 0);
}
/* Macroblock, and true mass [kg, kg m2], of a degree of freedom < n_dof. */
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
static inline PetscInt ModelApplied(const Model *m)
{
  return 3 * m->n_bodies + 2 * m->n_owned;
}
/* Rank 0. Which bodies are condensed and which of their vertices are inner: bodies->condensed, inner. */
PetscErrorCode MeshCondensed(const Scene *scene, const BlockMesh *mesh, PetscReal margin,
                             BodyNumbers *bodies);
/* A condensed body: K of its blocks reduced onto its kept degrees of freedom. */
typedef struct _p_Condensed {
  PetscInt number;          /* of all ranks' */
  PetscInt n_kept, *kept;   /* (n_kept,) entries 2 v + i of a vertex array, ascending */
  PetscInt n_inner, *inner; /* (n_inner,) likewise, those that no support holds */
  PetscInt stride;          /* n_kept rounded up to a whole batch */
  PetscReal *S;             /* [N/m] (stride, stride) Schur complement, symmetric, padded with zeros */
  PetscReal *u, *f;         /* (stride,) room for a cycle: gathered displacements, forces S u */
  PetscReal *load, *g;      /* [N] (n_inner,), (n_kept,) loads inside that were last passed on, and as what */
  struct _p_Mat *factor;    /* of K_II, NULL: no inner ones; rows: inner, then kept */
  struct _p_Vec *x, *b;     /* of its solves */
} Condensed;
/* Collective. Factors the bodies of this rank; supports must be known. Refuses a body
   that could move alone. */
PetscErrorCode CondensedCreate(const Scene *scene, Model *model);
PetscErrorCode CondensedDestroy(Model *model);
/* Adds S u to f. */
void CondensedForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Adds row sums of |S| to k [N/m] (vertices,): larger of the two directions, as ElementStiffness. */
void CondensedStiffness(const Model *model, PetscReal *k);
/* f: applied forces at all vertices; those at inner vertices are passed on to the kept ones. */
PetscErrorCode CondensedLoads(const Model *model, PetscReal *f);
/* u at inner vertices from u at the kept ones and the loads f at the inner ones (NULL: none). */
PetscErrorCode CondensedInner(const Model *model, const PetscReal *f, PetscReal *u);
/* Displacements and resisting forces at inner vertices, and state->passed, from the present state. */
PetscErrorCode CondensedRecover(const Model *model, State *state);
/* ---- condense_limits.c */
/* Collective. Refuses contacts at inner vertices. */
PetscErrorCode CondensedCheckContacts(const Scene *scene, const Model *model, const Contacts *contacts);
/* Collective. After CondensedRecover: warns about bodies that have turned too far for small strain, and
   refuses those that have turned much too far, unless the whole scene is in small strain. */
PetscErrorCode CondensedCheckRotation(const Scene *scene, const Model *model, const Stage *stage,
                                      const State *state);

/* ---- contact.c */
/* Collective. Finds all face-to-face contacts that touch an owned vertex, in the
   reference state (section 2.2). */
PetscErrorCode ContactsCreate(const Scene *scene, const Model *model, Contacts *contacts);
PetscErrorCode ContactsDestroy(Contacts *contacts);
/* A deep copy; its vertices are local numbers, which hold until NeighboursUpdate. */
PetscErrorCode ContactsCopy(const Contacts *contacts, Contacts *copy);
/* The (.., 2, BATCH) arrays of reals; last the four of closure, mostly zero. */
enum { CLOSURE_ARRAYS = 4, END_ARRAYS = 16 + CLOSURE_ARRAYS };
void ContactsEndArrays(const Contacts *contacts, PetscReal *array[END_ARRAYS]);
PetscErrorCode ContactsIsValid(const Model *model, const Contacts *contacts, PetscBool *valid);
/* Collective. Fails when macroblocks that touch are not held, together, in x, in y and against turning. */
PetscErrorCode ContactsCheckSupport(const Scene *scene, const Model *model, const Contacts *contacts);

/* ---- joint_rows.c */
/* Collective. Variable connectivity without a `default` row: contacts that come later between two groups, on
   faces without a named joint, have the weakest row of those that the groups have at the start. Refuses
   groups that have none and may meet. */
PetscErrorCode LaterJoints(const Scene *scene, const Contacts *contacts, Model *model);

/* ---- contact_force.c */
/* Openings and slips from positions, stresses by each contact's model, forces added to f; updates history and
   the arrays of the last evaluation. joints: the stage's table. u, f: vertex arrays. */
PetscErrorCode ContactForces(const Model *model, const Joint *joints, Contacts *contacts, const PetscReal *u,
                             PetscReal *f);
/* The same forces and history; leaves the arrays of the last evaluation as they are: most cycles of a static
   stage ask for no more. */
PetscErrorCode ContactForcesOnly(const Model *model, const Joint *joints, Contacts *contacts,
                                 const PetscReal *u, PetscReal *f);
/* After any other change of class, joint, rest or history: writes contacts->traits, by which the loop leaves
   out what a few contacts at a time do not need. */
void ContactsSetTraits(const Model *model, Contacts *contacts);
/* The history as it is now is what every evaluation starts from, until `held` is taken away: then each starts
   from where the last one ended. Call it at an equilibrium, forces evaluated with results. */
void ContactsHold(Contacts *contacts);
/* The present history is again the one held. */
void ContactsGoBack(Contacts *contacts);

/* ---- contact_verify.c */
/* Collective. Finds contacts anew in the present state and gives them the history of those before (variable
   connectivity). The last evaluation of forces must belong to the present displacements. joints: the stage's
   table. Counts go to result. */
PetscErrorCode ContactsVerify(const Scene *scene, const Joint *joints, Model *model, State *state,
                              Contacts *contacts, StageResult *result);
/* Collective. Whether blocks have moved enough since the last verification. */
PetscErrorCode ContactsNeedVerify(const Scene *scene, const Model *model, const State *state, PetscBool *need,
                                  PetscReal *far);

/* ---- ghost.c: owned vertices' displacements to the ranks that read them. Collective. u: vertex array. */
/* Prepares the exchange for the present model->ghosts. */
PetscErrorCode GhostConnect(Model *model);
PetscErrorCode GhostDestroy(Model *model);
PetscErrorCode GhostBegin(const Model *model, PetscReal *u);
PetscErrorCode GhostEnd(const Model *model, PetscReal *u);

/* ---- loads.c */
/* Collective. Writes model->support from the scene's supports. */
PetscErrorCode SupportsApply(const Scene *scene, Model *model);
/* Sets state->f_target from the stage's loads in the present position (water pressure stays normal to its
   face); again after blocks have moved. */
PetscErrorCode LoadsTarget(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Whether water acts that follows the faces it presses on. */
PetscBool LoadsPress(const Scene *scene, const Stage *stage);
/* Whether applied forces change with the displacements: by such water, or because the arms of forces about
   the mass centre of a rigid body turn with it. */
PetscBool LoadsChange(const Scene *scene, const Model *model, const Stage *stage);
/* For stages in time, which have no ramp: the loads that are not such into state->f_start; and, every step,
   state->f_target from these and the water on the faces as they are. Nothing is allocated. */
PetscErrorCode LoadsDead(const Scene *scene, const Model *model, const Stage *stage, State *state);
PetscErrorCode LoadsFollow(const Scene *scene, const Model *model, const Stage *stage, State *state);
/* Forces and present moments on rigid bodies, into the first 3 n_bodies entries of f, from the loads at their
   vertices behind them; no moment where the resultant stands at the mass centre however a body turns. Whether
   a body that may turn has a moment now or when turned. Local. */
PetscBool LoadsTurn(const Model *model, const PetscReal *u, PetscReal *f);
/* f_ext = (1 - ramp) f_start + ramp f_target. */
void LoadsApply(const Model *model, State *state, PetscReal ramp);
/* Water pressure on one face, see loads.c. x: (4) its ends, f: (4) forces at them [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

/* ---- uplift.c */
/* Water pressure along a joint: straight lines between points, s[0] = 0 at the heel. */
typedef struct {
  PetscInt n;
  PetscReal s[4], p[4]; /* [m] from the heel, [Pa] */
} UpliftDiagram;
/* A stretch that is open without the full head; from closed_from to it the joint is closed, by `closure` at
   most. */
typedef struct {
  PetscReal from, to, closed_from, closure; /* [m] */
  PetscBool at_toe;
} UpliftDry;
enum { UPLIFT_MOST_DRY = 8 };
typedef struct _p_Uplift {
  PetscReal heel[2], toe[2], length; /* [m] reference; length 0: the load is no uplift */
  PetscReal crack;                   /* [m] from the heel, where the full head acts */
  PetscInt rounds;                   /* of the iteration for it, in this stage */
  PetscInt n_dry;                    /* the first of them; of the last measurement */
  UpliftDry dry[UPLIFT_MOST_DRY];
  PetscInt n_gids, *gids;   /* outer faces in the joint, ascending; the same on all ranks */
  PetscInt n_faces, *faces; /* rows of model->faces, local blocks only, ascending gid */
} Uplift;
/* Collective. Finds the joint lines of the uplift loads; refuses sets that are no
   joint and drains outside. */
PetscErrorCode UpliftCreate(const Scene *scene, const Model *model, const Contacts *contacts, State *state);
PetscErrorCode UpliftDestroy(const Scene *scene, State *state);
/* The diagram of a load whose joint is open from the heel over uplift->crack. */
void UpliftPressure(const Load *load, const Uplift *uplift, PetscReal gravity, UpliftDiagram *diagram);
/* Pressure on one face: s: (2) place of its ends along the joint, x: (4) their
   coordinates, f: (4) forces [N]. */
void UpliftOnFace(const UpliftDiagram *diagram, const PetscReal s[2], const PetscReal x[4],
                  PetscReal thickness, PetscReal f[4]);
/* Start of a stage: the iterations begin anew; cracks of loads that do not act in it close. */
PetscErrorCode UpliftStart(const Scene *scene, const Stage *stage, State *state);
/* Adds the forces of the load to f. u, f: vertex arrays. */
void UpliftForces(const Scene *scene, const Load *load, const Uplift *uplift, const Model *model,
                  const PetscReal *u, PetscReal *f);

/* ---- timestep.c */
/* Adds the contacts' part of the stiffness bound (29), corrected, to k [N/m] (n_vertices + dummies,). */
PetscErrorCode ContactStiffness(const Joint *joints, const Contacts *contacts, PetscReal thickness,
                                PetscReal *k);
/* Scaled masses (33)-(34) for dt = 1: the largest frequency of blocks and closed elastic joints
   times dt is 2 safety. */
PetscErrorCode ScaledMasses(const Scene *scene, const Model *model, const Joint *joints,
                            const Contacts *contacts, State *state);
/* Collective. True masses into state->m, and the largest stable step [s] for them, with contacts wherever
   they may come. Refuses free degrees of freedom without mass. */
PetscErrorCode DynamicTimeStep(const Scene *scene, const Model *model, const Stage *stage, State *state,
                               PetscReal *limit);

/* ---- integrate.c */
typedef struct {
  PetscReal num[2], den[2];   /* binned sums of v.(f - f_old) and v.m v, over the dofs in the quotient */
  PetscReal num_max, den_max; /* largest terms: bounds for the bins of the next cycle */
} QuotientSums;
/* What two ranks, or more, have together; `lower` comes from the lower ranks, so that all get the same even
   where something is not a number. */
static inline QuotientSums QuotientSumsOf(const QuotientSums *lower, const QuotientSums *higher)
{
  return (QuotientSums){{lower->num[0] + higher->num[0], lower->num[1] + higher->num[1]},
                        {lower->den[0] + higher->den[0], lower->den[1] + higher->den[1]},
                        PetscMax(lower->num_max, higher->num_max),
                        PetscMax(lower->den_max, higher->den_max)};
}
/* One central-difference step (11)-(20) of all dofs of this rank; sums of the
   Rayleigh quotient on the way. */
void Integrate(const Model *model, State *state, const QuotientSums *last, QuotientSums *sums);
/* What IntegrateRange reads there, less u and f. */
Ahead IntegrateAhead(const State *state, PetscInt from);
/* The same for the degrees of freedom `from` to `to` - 1; their terms are added to sums. */
void IntegrateRange(const Model *model, State *state, const QuotientSums *last, PetscInt from, PetscInt to,
                    QuotientSums *sums);

/* ---- fault.c */
/* Of this rank: the block where a force or displacement is not finite, as a number that orders them; a large
   one: none. Right at the cycle when it has happened, it is the block where it arose. */
#define FAULT_NONE ((PetscInt64)1 << 62)
PetscInt64 FaultFind(const Model *model, const State *state);
/* Collective. In words, the first of what the ranks have found. */
PetscErrorCode FaultName(const Model *model, PetscInt64 found, char text[128]);

/* ---- step.c */
/* Parts of a cycle, for -log_view and for the line about cost under each stage. Sampled:
   PartSample says which cycles. */
typedef enum {
  PART_EXCHANGE,
  PART_CONTACTS,
  PART_BLOCKS,
  PART_RIGID,
  PART_INTEGRATION,
  PART_DAMPING,
  PART_REPARTITION,  /* from here on timed whole */
  PART_VERIFICATION, /* the next five are parts of it */
  PART_FAR_FACES,
  PART_NEAR_FACES,
  PART_FACE_CONTACTS,
  PART_VERTEX_CONTACTS,
  PART_HISTORY,
  PART_READING, /* from here on set-up */
  PART_CHECKS,
  PART_ORDER,
  PART_PARTITION,
  PART_DISTRIBUTION,
  PART_MODEL,
  PART_FIRST_CONTACTS,
  PART_OUTPUT_START,
  PARTS
} Part;
PetscErrorCode PartBegin(Part part);
PetscErrorCode PartEnd(Part part);
void PartSample(PetscInt64 cycle);
/* Prints the shares since the last report (those of rank 0) and forgets them. */
PetscErrorCode PartReport(MPI_Comm comm, PetscInt64 cycles);
/* Likewise of the set-up, until the first cycle. */
PetscErrorCode PartReportSetUp(MPI_Comm comm);
/* Collective. Ghost exchange, then the resisting forces of all contacts and blocks at the
   present displacements. */
PetscErrorCode Forces(const Model *model, const Joint *joints, Contacts *contacts, State *state,
                      PetscReal *contact_scale);
/* Collective. One cycle, from displacements that ghosts have too, to displacements that ghosts have too.
   contact_scale: NULL, or (n_dof,) receives |contact force| per dof; then the
   contacts' arrays of the last evaluation are written too. */
PetscErrorCode Step(const Scene *scene, const Model *model, const Joint *joints, Contacts *contacts,
                    State *state, struct _p_Relaxation *relax, PetscReal *contact_scale);

/* ---- stress_models.c */
extern const char *const StressModels[]; /* PetscEnum-style list of names: pt r2pt r3pt t2pt t3pt tptm,
                                            "StressModelKind", "STRESS_" , NULL */
/* The elastic row of a model: F_end0 = L (a s0 + b s1), F_end1 = L (b s0 + a s1). */
void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b);
/* Response of one contact, as contact_force.c has it of a batch; see stress_models.h. */
typedef struct {
  PetscReal u_n[2], u_s[2];             /* in: [m] at the two ends, openings already reduced by `rest` */
  PetscReal slip[2], broken[2];         /* in: history at the start of the step; out: at its end */
  PetscReal closure[2], closure_far[2]; /* the same of a joint of finite compression */
  PetscBool in_time;                    /* in: of a dynamic stage, where partial slip may make no energy */
  PetscReal speed[2];                   /* in: [m/s] of opening, for dashpots of a dynamic stage */
  PetscReal sigma[2], tau[2];           /* out: [Pa] at the ends */
  PetscReal F_n[2], F_s[2]; /* out: [N/m] end forces per metre of thickness, same sign as sigma, tau */
  PetscInt state[2];        /* out: ContactState bits */
} ContactPoint;
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p);
/* [m] Plastic part of u_n at end k. */
PetscReal StressModelClosure(const ContactPoint *p, int k);
/* Of tptm: the parts of the length where the trial stress opens the joint and where it crushes it. */
void StressModelParts(const Joint *joint, const ContactPoint *p, PetscReal *open, PetscReal *crushing);
/* [J/m] Of tptm: what its normal springs store, sigma^2/(2 k_n) over the length. */
PetscReal StressModelStored(const Joint *joint, PetscReal length, const ContactPoint *p);
/* Whether the law holds elastically at both ends and nothing is broken or crushed, for the trial stresses
   sigma, tau. */
PetscBool JointIsElastic(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2],
                         const PetscReal broken[2], const PetscReal closure[2]);

/* blocks.h: declares deformable, rigid and condensed blocks. */
#pragma once
#include "contacts/contacts.h"

/* ---- material_keys.c */
/* Completes the keys of a material, see reader.h. */
PetscErrorCode CompleteMaterial(Reader *r, const char *path, Material *material);

/* ---- rigid.c */
/* Finds the owned bodies, their vertices, mass centres and masses, from the vertices' rigid numbers. */
PetscErrorCode RigidBodiesCreate(Model *model);
/* Sums the forces at vertices of rigid bodies into force and moment at the mass centre,
   (14)-(15). u, f: dof arrays. */
void RigidForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Computes displacements of vertices from the displacements of the bodies, (21)-(22) in finite form. u: dof
   array. */
void RigidMotion(const Model *model, PetscReal *u);
/* Collective. Completes displacements u (dof array) from the displacements of this rank's degrees of freedom:
   of vertices of rigid bodies by RigidMotion, of ghosts by exchange. */
PetscErrorCode DisplacementsComplete(const Model *model, PetscReal *u);

/* ---- create.c */
/* Collective. Creates rigid bodies, masses and chunks of elements after ModelCreate, and so sets n_dof. */
PetscErrorCode BlocksCreate(const Scene *scene, Model *model);

/* ---- element.c */
/* Adds the resisting force (10) of deformable elements to f. u, f: vertex arrays [m], [N]
   (n_vertices + dummies, 2). */
PetscErrorCode ElementForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Adds the resisting force of condensed elements to f, in small strain. */
void ElementForcesCondensed(const Model *model, const PetscReal *u, PetscReal *f);
/* Adds their forces in large strain. */
void ElementForcesTurned(const Model *model, const PetscReal *u, PetscReal *f);
/* Computes the stiffness [N/m] of four elements from `first` (a multiple of 4) on. Entry (i,j) of element
   first + l is K[l][i * 2 n_nodes + j], with rows x, y of vertex 0, x, y of vertex 1, ... u: vertex array
   [m]: the tangent there in large strain; NULL: the stiffness of the reference configuration. */
void ElementMatrices(const Model *model, const Elements *e, int n_nodes, PetscInt first, const PetscReal *u,
                     PetscReal K[][64]);
/* Arrays to prefetch into the cache. */
enum { AHEAD_ARRAYS = 5 };
typedef struct {
  const PetscReal *array[AHEAD_ARRAYS];
} Ahead;
/* Computes forces of elements `from` (a multiple of 8) to `to` - 1 of blocks of ELEMENT_FULL, eight at
   once: AVX-512. */
void ElementForcesWide(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                       PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f);
/* Computes the same forces chunk by chunk, so that vertices can move as soon as model->chunk_done[chunk]
   says that their forces are complete. ahead: arrays to prefetch, NULL: none. */
PetscInt ElementChunks(const Model *model);
void ElementForcesOfChunk(const Model *model, PetscInt chunk, const Ahead *ahead, const PetscReal *u,
                          PetscReal *f);
/* Computes model->chunk_done, at set-up. */
PetscErrorCode ElementChunksDone(Model *model);
/* Computes the stiffness [Pa] of a one-point block against its hourglass modes, see element_kernels.h:
   Q4OnePointForce; zero for ELEMENT_FULL. coefficient: of ELEMENT_REDUCED. */
void ElementHourglass(Formulation element, Lame lame, PetscReal coefficient, PetscReal hourglass[3]);
/* Adds row sums (28) to k [N/m] and lumped masses (26)-(27) to m [kg], both (n_vertices + dummies,). */
PetscErrorCode ElementStiffness(const Model *model, PetscReal *k);
/* Adds row sums of condensed elements to k, as if they were not condensed. */
PetscErrorCode ElementStiffnessCondensed(const Model *model, PetscReal *k);
/* Adds sum_j |K_ij| x_j to rows [N/m], over the blocks at each vertex; x: weights [-] of x and y there, both
   vertex arrays with dummies. */
void ElementWeightedRows(const Model *model, const PetscReal *x, PetscReal *rows);
PetscErrorCode ElementMasses(const Model *model, PetscReal *m);
/* Computes the Cauchy stress sxx syy sxy [Pa] (n,3) at the centre of each element of the list. */
PetscErrorCode ElementStress(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *stress);
/* Computes the Cauchy stress at the Gauss points: T3 (n,1,3), Q4 (n,4,3) in the order (-,-), (+,-), (+,+),
   (-,+). */
PetscErrorCode ElementStressGauss(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                                  PetscReal *stress);
/* Computes the strain energy [J] (n,) of the owned elements of one list. */
PetscErrorCode ElementEnergy(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *energy);
/* Computes principal stresses s1 >= s2 of (sxx,syy,sxy) and the angle [rad] of s1 from x. */
void PrincipalStress(const PetscReal s[3], PetscReal principal[2], PetscReal *angle);
/* Computes the exact area [m2], centroid [m] and polar second moment about the centroid [m4] of one block;
   vertices: (n_nodes,) ccw rows of X (n,2) [m]. */
void BlockGeometry(const PetscReal *X, const PetscInt *vertices, int n_nodes, PetscReal *area,
                   PetscReal centroid[2], PetscReal *polar);

/* ---- laws.c: material laws that have a history, laws.h */
/* Collective. Creates the histories of the laws in the lists of the model. Refuses groups that never
   deform by themselves. */
PetscErrorCode LawsCreate(const Scene *scene, Model *model);
PetscErrorCode LawsDestroy(Model *model);
/* Adds one more temperature, of row `load` of the scene, to blocks with a history. change: [K] at the
   vertices of the list's blocks, in the lanes of Elements.vertex; share: State.applied.share. The caller
   owns both. */
PetscErrorCode LawsFeel(const Elements *e, PetscInt load, const PetscReal *change, PetscReal *const *share);

/* Updates the constants of blocks whose groups are absent, which have no stiffness (lifts.c). */
void LawsPresent(const Model *model);

/* ---- at_rest.c */
/* Collective. Allocates the initial strain of ground under stress. Refuses groups that never deform by
   themselves. */
PetscErrorCode AtRestCreate(const Scene *scene, Model *model);
/* Adds the initial strain. */
void AtRest(const Scene *scene, Model *model);
PetscErrorCode AtRestDestroy(Model *model);

/* Results of a block with a history: the worst of its points. */
typedef struct {
  PetscReal measure; /* [-] plastic strain or damage */
  PetscReal opening; /* [m] of its crack; -1: the law has no cracks */
  PetscReal lost;    /* [J] dissipated */
} LawReported;
/* Computes the results of the blocks of a list at u. reports: (n,). */
void LawReport(const Model *model, const Elements *e, const PetscReal *u, LawReported *reports);
/* The error of large load steps, for blocks of this rank that have dissipated since the last equilibrium: the
   difference between their forces and those after LAW_STEPS equal steps from u_0 to u and to the present
   temperatures. */
enum { LAW_STEPS = 8 };
typedef struct {
  PetscReal warns;          /* larger fractions count */
  PetscReal fraction;       /* largest difference over the largest force of the block */
  PetscReal plastic;        /* [-] largest plastic strain */
  PetscInt block;           /* file id of the worst block */
  PetscInt n[2];            /* number of blocks that have dissipated; number that count */
  const PetscReal *share_0; /* [-] share of each load of the scene at u_0; NULL: no temperatures */
  PetscReal *share;         /* work space of the same size */
} LawSteps;
void LawsInSteps(const Model *model, const PetscReal *u_0, const PetscReal *u, LawSteps *steps);
/* Decides whether a block of this rank has cracked further since the last equilibrium. */
PetscBool LawsCrack(const Model *model);
/* Returns the name of the measure of a law. */
const char *LawMeasure(MaterialLaw law);

/* ---- laws_term.c */
/* Force term: blocks with a material law that has a history. Blocks_term does what is common to all
   blocks. */
extern const TermKind Laws_term;

/* ---- thermal.c Blocks with thermal expansion, whose stress is reduced by the isotropic stress s = s_1
   change. s_1: [Pa/K] by group; change: [K] at the vertices of the list's blocks, in the lanes of
   Elements.vertex. */
/* Adds factor times the thermal expansion forces at owned vertices. They belong to the applied forces,
   because the mechanical strain is the total strain minus the thermal strain. u, f: vertex arrays. */
void ThermalForces(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   PetscReal factor, const PetscReal *u, PetscReal *f);
/* Subtracts s from the stresses of ElementStress (n_points 1) or ElementStressGauss. */
void ThermalStress(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   const PetscReal *u, int n_points, PetscReal *stress);
/* Corrects the energies of ElementEnergy to the energies of the mechanical strain. own_1: [1/K] by group,
   work of s per s when the change comes: three times the expansion, in plane stress twice. */
void ThermalEnergy(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *own_1,
                   const PetscReal *change, const PetscReal *u, PetscReal *energy);
/* Computes the mean change of temperature of each block at its centre. */
void ThermalMean(const Elements *e, const PetscReal *change, PetscReal *mean);

/* ---- blocks_term.c */
/* Force term: deformable blocks. */
extern const TermKind Blocks_term;

/* ---- block_damping.c */
/* Force term: stiffness-proportional damping of blocks in dynamic stages. */
extern const TermKind Block_damping_term;
/* Returns the work [J] of the damping in this stage, on this rank. memory: of Block_damping_term. */
PetscReal BlockDampingWork(const void *memory);

/* ---- condense.c */
/* A condensed body: K of its blocks reduced to its kept degrees of freedom. */
/* Coordinates of a condensed body in a dynamic stage; condense_rows.c. Slots are the free degrees of
   freedom, firm ones first, then calm ones, and after them the supports. Rows have shapes in place of the
   calm ones. */
typedef struct {
  PetscInt n_firm, n_calm, n_slots, n_shapes, n_rows;
  PetscInt *slot;   /* (n_kept,) slots of the kept degrees of freedom */
  PetscInt *dof;    /* (n_slots,) entry of a vertex array; for a support the entry of its first vertex */
  PetscReal *mass;  /* [kg] (n_slots,) lumped */
  PetscReal *share; /* (n_kept,) share of a kept degree of freedom in the force on its slot */
  PetscInt calm_width, shape_width, width; /* n_calm, n_shapes, n_rows rounded up to whole batches */
  PetscReal *shapes, *across;              /* [1/kg^1/2] Q by columns, by rows; 0 in padding */
  PetscReal *S;                            /* [N/m] (width, width) T'S T */
  PetscReal *u_start, *f_start;            /* (n_kept,) displacements from which du counts, and S u_start */
  PetscReal *calm, *by_shape, *at_slots, *x, *f; /* work space */
} CondensedRows;

typedef struct _p_Condensed {
  PetscInt number;          /* number among the bodies of all ranks */
  PetscInt n_kept, *kept;   /* (n_kept,) entries 2 v + i of a vertex array, ascending */
  PetscInt n_inner, *inner; /* (n_inner,) likewise, without those held by supports */
  PetscInt stride;          /* n_kept rounded up to a whole batch */
  PetscReal *S;             /* [N/m] (stride, stride) Schur complement, symmetric, padded with zeros */
  PetscReal *u, *f;         /* (stride,) work space of a cycle: gathered displacements, forces S u */
  PetscReal *load, *g;      /* [N] (n_inner,), (n_kept,) inner loads last passed on; their equivalent
                               forces */
  PetscReal *corrects;      /* [N] (n_kept,) e of condense_large.c; NULL: small strain */
  PetscReal stored;         /* [J] energy of these loads in the inner equilibrium */
  PetscReal *turn;          /* [1/m], [rad/N] (n_kept + n_inner,) mean rotation per displacement of kept
                               vertices and per load on inner vertices: condense_limits.c; NULL: not
                               computed yet */
  PetscReal modulus,
      sum_S; /* [N m] int E dV with the modulus of add_elements; [N/m] sum of |S|; both with `turn` */
  struct _p_Mat *factor; /* of K_II, NULL: no inner ones; rows: inner, then kept */
  struct _p_Vec *x, *b;  /* vectors of its solves */

  /* dynamic stages, condense_in_time.c */
  PetscInt n_modes, size, first_mode; /* number of modes; n_kept + n_modes; first row in State.modes */
  PetscInt n_gathered;                /* number of gathered modes, the last ones; condense_left_out.c */
  PetscReal *omega2, *shapes;         /* [1/s2] (n_modes,) ascending; (n_modes, n_inner) of modal mass 1 */
  PetscReal *damper;                  /* [1/s] (n_modes,) dashpots of the gathered modes, of modal mass 1 */
  PetscReal *inertia;                 /* [kg] (size, size) of kept dofs, then modes; without the lumped
                                         masses of kept vertices */
  PetscReal *along;                   /* [kg] (size, 2) inertia for a rigid motion along x, y */
  PetscReal inside[2], left_out[2];   /* [kg] inner mass that moves along x, y; part of it without modes */
  PetscReal *truncated;               /* [kg s2] (stride, stride) of modes left out; NULL: none */
  PetscReal next;                     /* [Hz] lowest frequency of the modes left out; inf: none is left out */
  CondensedRows *rows;                /* of the stage; NULL: not dynamic */
  PetscReal *given, *given_before;    /* [N] (n_kept,) S u of the last evaluation; one step before */
  PetscBool given_known;              /* given_before is valid */
  PetscReal beta, beta_now; /* [s] stiffness-proportional damping: of the stage; of the last evaluation */
} Condensed;
/* Collective. Factors the bodies of this rank; supports must be set. Refuses a body whose inside could
   move alone. */
PetscErrorCode CondensedCreate(const Scene *scene, Model *model);
PetscErrorCode CondensedDestroy(Model *model);
/* Force term: adds S u to f, and row sums of |S| to k, the larger of the two directions, as
   ElementStiffness. */
extern const TermKind Condensed_term;
/* Adds S u, and the correction for large strain, to f for the bodies of this rank. Vertex arrays. */
void CondensedAddForces(const Model *model, const PetscReal *u, PetscReal *f);

/* ---- condense_inside.c */
/* Passes the applied forces f at inner vertices on to the kept ones. f: at all vertices. */
PetscErrorCode CondensedLoads(const Model *model, PetscReal *f);
/* Recomputes, after a restart, the energy and the equivalent forces of the loads on inner vertices.
   target: vertex array [N] of the loads. CondensedLoads has treated it before, so it keeps its values. */
PetscErrorCode CondensedLoadsFind(const Model *model, const PetscReal *target);
/* Computes u at inner vertices from u at the kept ones and the loads f at the inner ones (NULL: none). */
PetscErrorCode CondensedInner(const Model *model, const PetscReal *f, PetscReal *u);
/* Computes displacements and resisting forces at inner vertices, and state->passed, from the present
   state. */
PetscErrorCode CondensedRecover(const Model *model, State *state);

/* ---- condense_large.c */
/* Collective. Recovers the inside at an equilibrium, and corrects the bodies for large strain there. again:
   the correction has changed, so the stage must go on. Sets model->condensed.leave after too many rounds. */
PetscErrorCode CondensedCorrect(Model *model, State *state, PetscReal tolerance, PetscBool *again);
/* Collective. Adds to `lack`, at kept vertices, the resisting force of the blocks at the recovered state that
   the last correction lacks. Vertex array. */
PetscErrorCode CondensedLack(const Model *model, const State *state, PetscReal *lack);
/* Takes the correction that state->nonlinear holds. */
PetscErrorCode CondensedTakeNonlinear(const Model *model, const State *state);

/* ---- dense.c */
/* Computes y = A x for dense A, (rows, columns) by columns; columns is a multiple of 4. */
void DenseTimes(PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y);
/* Computes x = K_II^-1 r. at: entries of the inner degrees of freedom in r and x; NULL: r and x are
   packed. */
PetscErrorCode CondensedSolve(const Condensed *body, const PetscInt *at, const PetscReal *r, PetscReal *x);

/* Computes n packed solutions, r and x: (n, n_inner); several at once take less time. */
PetscErrorCode CondensedSolveMany(const Condensed *body, PetscInt n, const PetscReal *r, PetscReal *x);

/* ---- condense_in_time.c */
/* Computes the modes of a body from its factor and K. wants receives whether MUMPS has too little memory. */
PetscErrorCode CondensedModes(const Scene *scene, const Model *model, struct _p_Mat *K, Condensed *body,
                              PetscBool *wants);
PetscErrorCode CondensedModesDestroy(Condensed *body);
/* Collective. Numbers the modes of all bodies. Refuses bodies that share vertices with rigid ones. */
PetscErrorCode CondensedModesNumber(const Scene *scene, Model *model);
/* Collective. Prints the modes, and the mass of the modes left out. */
PetscErrorCode CondensedReport(const Model *model);
/* Sets the modes to rest: inner vertices follow the kept ones statically. */
void CondensedRest(const Model *model, const State *state);
/* Applies the loads in f_ext while inner vertices keep their places. */
void CondensedLoaded(const Model *model, State *state);
/* Collective. Archives the modes, see archive.h. Refuses modes that differ from the modes of this run,
   because q belongs to its modes. */
PetscErrorCode CondensedArchive(Archive *archive, const Model *model, State *state);
/* Stores the resisting force of the modes at kept vertices: state->inertial. */
void CondensedInertial(const Model *model, const State *state);
/* Returns the damping [1/s] of mode k of a body: its dashpot, and beta of the stage. */
static inline PetscReal CondensedDamper(const Condensed *body, PetscInt k)
{
  return body->damper[k] + body->beta_now * body->omega2[k];
}
/* Returns the part [s] of beta that is centred, as dashpots are: all of it in a body with modes left out,
   which has a dense inverse anyway. A body with all modes is equivalent to the mesh, and is damped as
   blocks are, by the velocity before. */
static inline PetscReal CondensedCentred(const Condensed *body)
{
  return body->next < PETSC_INFINITY ? body->beta : 0.;
}
/* Adds the modes: u += Phi q. q: (n_modes,) of the model; u: vertex array. */
void CondensedAddModes(const Model *model, const PetscReal *q, PetscReal *u);

/* ---- condense_rows.c */
/* Creates the rows of bodies. calms: calm vertices move by shapes, if modes are left out. mass: [kg]
   (n_kept, n_kept) of kept vertices without the inner mass; u_start: vertex array. */
PetscErrorCode CondensedRowsCreate(const Model *model, PetscBool calms, const PetscReal *mass,
                                   const PetscReal *u_start, Condensed *body);
PetscErrorCode CondensedRowsDestroy(Condensed *body);
/* Sums forces of slots to rows by T'. */
void CondensedSum(const CondensedRows *rows, const PetscReal *slots, PetscReal *of_rows);
/* Computes the motion of rows from the motion of slots, which is overwritten; and the motion of slots from
   the motion of rows. */
void CondensedFind(const CondensedRows *rows, PetscReal *slots, PetscReal *of_rows);
void CondensedSpread(const CondensedRows *rows, const PetscReal *of_rows, PetscReal *slots);
/* Returns the row of T of a slot, times scale: (n_rows,). */
void CondensedRowOf(const CondensedRows *rows, PetscInt slot, PetscReal scale, PetscReal *row);
/* Computes T'A, (n_rows, width), of A, (n_kept, width) in rows of length `apart`; and T'A T of A, (n_kept,
   n_kept). */
PetscErrorCode CondensedFold(const CondensedRows *rows, PetscInt n_kept, PetscInt width, PetscInt apart,
                             const PetscReal *A, PetscReal *folded);
PetscErrorCode CondensedFoldBoth(const CondensedRows *rows, PetscInt n_kept, PetscInt apart,
                                 const PetscReal *A, PetscReal *folded);
/* Collective. Prints how many degrees of freedom move by how many shapes. */
PetscErrorCode CondensedReportRows(const Model *model);
/* Returns the number of multiplications in a step in time. */
PetscReal CondensedProducts(const Condensed *body);
/* Computes f = S u, (n_kept,). u: vertex array. */
void CondensedForces(const Condensed *body, const PetscReal *u, PetscReal *f);

/* ---- condense_bound.c */
/* A stable time step of a free body, and what limits it. */
typedef struct {
  PetscReal dt;     /* [s] */
  PetscInt dof;     /* the kept degree of freedom that moves most in the limiting motion */
  PetscReal joints; /* [-] share of springs or dampers in its stiffness or damping */
} CondensedStep;
/* Computes the steps without damping, and with beta of the stage and dampers (infinite where nothing
   damps). springs: [N/m], dampers: [N s/m] (vertices,) to the ground at kept vertices; dampers act on the
   velocity before. */
PetscErrorCode CondensedBound(const Model *model, const Condensed *body, const PetscReal *springs,
                              const PetscReal *dampers, CondensedStep step[2]);

/* ---- condense_left_out.c */
/* Gathers the modes left out of a body into a few, after its own. rows: (size, n_inner) Psi', Phi', times
   the roots of the masses; overwritten. */
PetscErrorCode CondensedGather(const Model *model, PetscReal *rows, Condensed *body);

/* ---- condense_limits.c */
/* Collective. Refuses contacts at inner vertices. */
PetscErrorCode CondensedCheckContacts(const Scene *scene, const Model *model, const Contacts *contacts);
/* Collective. Warns, after CondensedRecover, of bodies rotated too far for small strain. Refuses those
   rotated much too far, unless the whole scene is in small strain. */
PetscErrorCode CondensedCheckRotation(const Scene *scene, const Model *model, const Stage *stage,
                                      const State *state);
/* One rank. Decides whether CondensedCheckRotation might refuse the present state. Uses kept vertices and
   inner loads only, so inner vertices need not be recovered. */
PetscErrorCode CondensedMayTurn(const Scene *scene, const Model *model, const State *state, PetscBool *may);

/* blocks.h: deformable, rigid and condensed blocks. */
#pragma once
#include "contacts/contacts.h"

/* ---- rigid.c */
/* Owned bodies, their vertices, mass centres and masses, from the vertices' rigid numbers. */
PetscErrorCode RigidBodiesCreate(Model *model);
/* Sums the forces at vertices of rigid bodies into force and moment at the mass centre,
   (14)-(15). u, f: dof arrays. */
void RigidForces(const Model *model, const PetscReal *u, PetscReal *f);
/* Displacements of vertices from those of the bodies, (21)-(22) in finite form. u: dof array. */
void RigidMotion(const Model *model, PetscReal *u);

/* ---- create.c */
/* Collective. After ModelCreate: rigid bodies, masses, chunks of elements, and with them n_dof. */
PetscErrorCode BlocksCreate(const Scene *scene, Model *model);

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
/* Elements from `from` (a multiple of 8) to `to` - 1 of blocks of ELEMENT_FULL, eight at once: AVX-512. */
void ElementForcesWide(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                       PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f);
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
/* The same of condensed ones, as if they were not condensed. */
PetscErrorCode ElementStiffnessCondensed(const Model *model, PetscReal *k);
/* Adds sum_j |K_ij| x_j to rows [N/m], over the blocks at each vertex; x: weights [-] of x and y there, both
   vertex arrays with dummies. */
void ElementWeightedRows(const Model *model, const PetscReal *x, PetscReal *rows);
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

/* ---- laws.c: material laws that have a history, laws.h */
/* Collective. Their history, in the lists of the model; refuses groups that never deform by themselves. */
PetscErrorCode LawsCreate(const Scene *scene, Model *model);
PetscErrorCode LawsDestroy(Model *model);
/* Blocks with a history feel one more temperature, of row `load` of the scene. change: [K] at the vertices of
   the list's blocks, in the lanes of Elements.vertex; share: State.applied.share. Both belong to others. */
PetscErrorCode LawsFeel(const Elements *e, PetscInt load, const PetscReal *change, PetscReal *const *share);

/* Blocks of groups that are absent have no stiffness (lifts.c): their constants follow the model's. */
void LawsPresent(const Model *model);

/* ---- at_rest.c */
/* Collective. Room for what strain counts from in ground under stress; refuses groups that never deform by
   themselves. */
PetscErrorCode AtRestCreate(const Scene *scene, Model *model);
/* Adds it. */
void AtRest(const Scene *scene, Model *model);
PetscErrorCode AtRestDestroy(Model *model);

/* What a block with a history has to tell: the worst of its points. */
typedef struct {
  PetscReal measure; /* [-] plastic strain or damage */
  PetscReal opening; /* [m] of its crack; -1: the law knows none */
  PetscReal lost;    /* [J] for good */
} LawReported;
/* told: (n,) of the list, at u. */
void LawReport(const Model *model, const Elements *e, const PetscReal *u, LawReported *told);
/* How far the forces of blocks that have lost something since the last equilibrium are from those that they
   would have if they had come to u from u_0, and to their temperatures, in LAW_STEPS even steps; of this
   rank. */
enum { LAW_STEPS = 8 };
typedef struct {
  PetscReal warns;          /* a larger fraction counts */
  PetscReal fraction;       /* of the largest force of a block: the worst one */
  PetscReal plastic;        /* [-] largest plastic strain */
  PetscInt block;           /* of the mesh */
  PetscInt n[2];            /* blocks that have lost something; of them, those that count */
  const PetscReal *share_0; /* [-] of each load of the scene, at u_0; NULL: no temperatures */
  PetscReal *share;         /* room for as many */
} LawSteps;
void LawsInSteps(const Model *model, const PetscReal *u_0, const PetscReal *u, LawSteps *steps);
/* Whether a block of this rank has cracked further since the last equilibrium. */
PetscBool LawsCrack(const Model *model);
/* The name of the measure of a law. */
const char *LawMeasure(MaterialLaw law);

/* ---- laws_term.c */
/* Their blocks as a force term; what blocks of all laws have alike is that of Blocks_term. */
extern const TermKind Laws_term;

/* ---- thermal.c
   Blocks that have become warmer, by an isotropic stress s = s_1 change that they lack. s_1: [Pa/K] by group;
   change: [K] at the vertices of the list's blocks, in the lanes of Elements.vertex. */
/* Adds factor times the forces at owned vertices that expand the blocks: part of the applied ones, because
   their mechanical strain is what is left of the total one. u, f: vertex arrays. */
void ThermalForces(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   PetscReal factor, const PetscReal *u, PetscReal *f);
/* Takes s from stresses as ElementStress (n_points 1) and ElementStressGauss have found them. */
void ThermalStress(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   const PetscReal *u, int n_points, PetscReal *stress);
/* Makes of the energies of ElementEnergy those of the mechanical strain. own_1: [1/K] by group, what s does
   work along when the change comes: three times the expansion, in plane stress twice. */
void ThermalEnergy(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *own_1,
                   const PetscReal *change, const PetscReal *u, PetscReal *energy);
/* The mean change of each block at its centre. */
void ThermalMean(const Elements *e, const PetscReal *change, PetscReal *mean);

/* ---- blocks_term.c */
/* Deformable blocks as a force term. */
extern const TermKind Blocks_term;

/* ---- block_damping.c */
/* Their damping in proportion to their stiffness, in time. */
extern const TermKind Block_damping_term;

/* ---- condense.c */
/* A condensed body: K of its blocks reduced onto its kept degrees of freedom. */
/* By what a condensed body moves in a stage in time; condense_rows.c. Slots are the degrees of freedom that
   nothing holds, firm ones first, then calm ones, and behind them the supports; rows have shapes in place of
   the calm ones. */
typedef struct {
  PetscInt n_firm, n_calm, n_slots, n_shapes, n_rows;
  PetscInt *slot;   /* (n_kept,) of each kept degree of freedom */
  PetscInt *dof;    /* (n_slots,) entry of a vertex array; of a support that of its first vertex */
  PetscReal *mass;  /* [kg] (n_slots,) lumped */
  PetscReal *share; /* (n_kept,) what of the force on its slot a kept degree of freedom gets */
  PetscInt calm_width, shape_width, width; /* n_calm, n_shapes, n_rows rounded up to whole batches */
  PetscReal *shapes, *across;              /* [1/kg^1/2] Q by columns, by rows; 0 in padding */
  PetscReal *S;                            /* [N/m] (width, width) T'S T */
  PetscReal *u_start, *f_start; /* (n_kept,) displacements that du is counted from, and S u_start */
  PetscReal *calm, *by_shape, *at_slots, *x, *f; /* room */
} CondensedRows;

typedef struct _p_Condensed {
  PetscInt number;          /* of all ranks' */
  PetscInt n_kept, *kept;   /* (n_kept,) entries 2 v + i of a vertex array, ascending */
  PetscInt n_inner, *inner; /* (n_inner,) likewise, those that no support holds */
  PetscInt stride;          /* n_kept rounded up to a whole batch */
  PetscReal *S;             /* [N/m] (stride, stride) Schur complement, symmetric, padded with zeros */
  PetscReal *u, *f;         /* (stride,) room for a cycle: gathered displacements, forces S u */
  PetscReal *load, *g;      /* [N] (n_inner,), (n_kept,) loads inside that were last passed on, and as what */
  PetscReal stored;         /* [J] that these loads store by the equilibrium inside */
  PetscReal *turn;          /* [1/m], [rad/N] (n_kept + n_inner,) its mean rotation by displacements of kept
                               vertices and by loads inside: condense_limits.c; NULL: not yet asked for */
  PetscReal modulus,
      sum_S; /* [N m] int E dV with the modulus of add_elements; [N/m] sum of |S|; both with `turn` */
  struct _p_Mat *factor; /* of K_II, NULL: no inner ones; rows: inner, then kept */
  struct _p_Vec *x, *b;  /* of its solves */

  /* in time, condense_in_time.c */
  PetscInt n_modes, size, first_mode; /* its modes; n_kept + n_modes; its first row in State.modes */
  PetscInt n_gathered;                /* of its modes: the last ones; condense_left_out.c */
  PetscReal *omega2, *shapes;         /* [1/s2] (n_modes,) ascending; (n_modes, n_inner) of modal mass 1 */
  PetscReal *damper;                  /* [1/s] (n_modes,) dashpots of the gathered ones, of modal mass 1 */
  PetscReal *inertia;                 /* [kg] (size, size) of kept degrees of freedom, then modes; without the
                                         lumped masses of kept vertices */
  PetscReal *along;                   /* [kg] (size, 2) what of it a motion of the whole along x, y takes */
  PetscReal inside[2], left_out[2];   /* [kg] mass inside that moves along x, y; what of it has no modes */
  PetscReal *lacking;                 /* [kg s2] (stride, stride) of modes left out; NULL: none is */
  PetscReal next;                     /* [Hz] the modes left out are no slower; inf: none is left out */
  CondensedRows *rows;                /* of the stage; NULL: none is in time */
  PetscReal *given, *given_before;    /* [N] (n_kept,) S u of the forces last evaluated, and a step before */
  PetscBool given_known;              /* the latter is */
  PetscReal beta, beta_now; /* [s] damping by stiffness of the stage; of the forces last evaluated */
} Condensed;
/* Collective. Factors the bodies of this rank; supports must be known. Refuses a body
   that could move alone. */
PetscErrorCode CondensedCreate(const Scene *scene, Model *model);
PetscErrorCode CondensedDestroy(Model *model);
/* Adds S u to f, and row sums of |S| to k: the larger of the two directions, as ElementStiffness. */
extern const TermKind Condensed_term;
/* f: applied forces at all vertices; those at inner vertices are passed on to the kept ones. */
PetscErrorCode CondensedLoads(const Model *model, PetscReal *f);
/* Finds what bodies store by the loads inside them, and what they pass on of these, after a restart. target:
   vertex array [N] of the loads; CondensedLoads has been through it before, so it keeps its values. */
PetscErrorCode CondensedLoadsFind(const Model *model, const PetscReal *target);
/* u at inner vertices from u at the kept ones and the loads f at the inner ones (NULL: none). */
PetscErrorCode CondensedInner(const Model *model, const PetscReal *f, PetscReal *u);
/* Displacements and resisting forces at inner vertices, and state->passed, from the present state. */
PetscErrorCode CondensedRecover(const Model *model, State *state);

/* ---- dense.c */
/* y = A x for dense A, (rows, columns) by columns, which are a multiple of 4. */
void DenseTimes(PetscInt rows, PetscInt columns, const PetscReal *A, const PetscReal *x, PetscReal *y);
/* x = K_II^-1 r. at: the entries of the inner degrees of freedom in r and x; NULL: they are packed. */
PetscErrorCode CondensedSolve(const Condensed *body, const PetscInt *at, const PetscReal *r, PetscReal *x);

/* The same of n packed ones, r and x: (n, n_inner); several at once take less time. */
PetscErrorCode CondensedSolveMany(const Condensed *body, PetscInt n, const PetscReal *r, PetscReal *x);

/* ---- condense_in_time.c */
/* Of a body with its factor and K; wants: MUMPS has too little memory. */
PetscErrorCode CondensedModes(const Scene *scene, const Model *model, struct _p_Mat *K, Condensed *body,
                              PetscBool *wants);
PetscErrorCode CondensedModesDestroy(Condensed *body);
/* Collective. Numbers the modes of all bodies; refuses bodies that share vertices with rigid ones. */
PetscErrorCode CondensedModesNumber(const Scene *scene, Model *model);
/* Collective. Prints which modes there are, and what those left out would carry. */
PetscErrorCode CondensedReport(const Model *model);
/* What is inside follows its kept vertices, at rest. */
void CondensedRest(const Model *model, const State *state);
/* Takes the loads in f_ext; what is inside stays where it is. */
void CondensedLoaded(const Model *model, State *state);
/* Collective, see archive.h. Refuses modes that are not those of this run: q belongs to its modes. */
PetscErrorCode CondensedArchive(Archive *archive, const Model *model, State *state);
/* Notes the resisting force that these vibrations add at kept vertices: state->inertial. */
void CondensedInertial(const Model *model, const State *state);
/* [1/s] What damps mode k of a body: its dashpot, and beta of the stage. */
static inline PetscReal CondensedDamper(const Condensed *body, PetscInt k)
{
  return body->damper[k] + body->beta_now * body->omega2[k];
}
/* [s] What of beta is centred, as dashpots are: all of it in a body that lacks modes, which has a dense
   inverse anyway. A body with all modes is the mesh itself, and is damped as blocks are, by the velocity
   before. */
static inline PetscReal CondensedCentred(const Condensed *body)
{
  return body->next < PETSC_INFINITY ? body->beta : 0.;
}
/* u += Phi q; q: (n_modes,) of the model; u: vertex array. */
void CondensedAddModes(const Model *model, const PetscReal *q, PetscReal *u);

/* ---- condense_rows.c */
/* calms: calm vertices move by shapes, where modes are left out. mass: [kg] (n_kept, n_kept) of kept vertices
   beside what is inside; u_start: vertex array. */
PetscErrorCode CondensedRowsCreate(const Model *model, PetscBool calms, const PetscReal *mass,
                                   const PetscReal *u_start, Condensed *body);
PetscErrorCode CondensedRowsDestroy(Condensed *body);
/* Forces on rows: T' of those on slots. */
void CondensedSum(const CondensedRows *rows, const PetscReal *slots, PetscReal *of_rows);
/* The motion of rows from that of slots, which is overwritten; and the motion of slots from that of rows. */
void CondensedFind(const CondensedRows *rows, PetscReal *slots, PetscReal *of_rows);
void CondensedSpread(const CondensedRows *rows, const PetscReal *of_rows, PetscReal *slots);
/* The row of T of a slot, times scale: (n_rows,). */
void CondensedRowOf(const CondensedRows *rows, PetscInt slot, PetscReal scale, PetscReal *row);
/* T'A, (n_rows, width), of A, (n_kept, width) in rows of length `apart`; T'A T of A, (n_kept, n_kept). */
PetscErrorCode CondensedFold(const CondensedRows *rows, PetscInt n_kept, PetscInt width, PetscInt apart,
                             const PetscReal *A, PetscReal *folded);
PetscErrorCode CondensedFoldBoth(const CondensedRows *rows, PetscInt n_kept, PetscInt apart,
                                 const PetscReal *A, PetscReal *folded);
/* Collective. Prints how many degrees of freedom move by how many shapes. */
PetscErrorCode CondensedReportRows(const Model *model);
/* How many products of numbers a step in time takes. */
PetscReal CondensedProducts(const Condensed *body);
/* f: (n_kept,) S u; u: vertex array. */
void CondensedForces(const Condensed *body, const PetscReal *u, PetscReal *f);

/* ---- condense_bound.c */
/* A step that a body bears, nothing held moving, and what sets it. */
typedef struct {
  PetscReal dt;     /* [s] */
  PetscInt dof;     /* where its kept vertices move most */
  PetscReal joints; /* [-] what of the stiffness, or of the damping, comes from springs or dampers */
} CondensedStep;
/* Without damping, and with beta of the stage and dampers (infinite where nothing damps). springs: [N/m],
   dampers: [N s/m] (vertices,) to the ground at its kept vertices, which know the velocity before. */
PetscErrorCode CondensedBound(const Model *model, const Condensed *body, const PetscReal *springs,
                              const PetscReal *dampers, CondensedStep step[2]);

/* ---- condense_left_out.c */
/* Gathers the modes that a body leaves out into a few, behind its own. rows: (size, n_inner) Psi', Phi',
   times the roots of the masses; overwritten. */
PetscErrorCode CondensedGather(const Model *model, PetscReal *rows, Condensed *body);

/* ---- condense_limits.c */
/* Collective. Refuses contacts at inner vertices. */
PetscErrorCode CondensedCheckContacts(const Scene *scene, const Model *model, const Contacts *contacts);
/* Collective. After CondensedRecover: warns about bodies that have turned too far for small strain, and
   refuses those that have turned much too far, unless the whole scene is in small strain. */
PetscErrorCode CondensedCheckRotation(const Scene *scene, const Model *model, const Stage *stage,
                                      const State *state);
/* One rank. may: whether CondensedCheckRotation might refuse the present state; no work but on kept vertices
   and loads inside, so the inside need not be recovered. */
PetscErrorCode CondensedMayTurn(const Scene *scene, const Model *model, const State *state, PetscBool *may);

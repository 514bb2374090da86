/* chain.h: declares a bar that is bonded to the blocks it runs through: a chain of pieces between places
   in blocks.

   Piece j runs from place j to place j + 1, counted from the head. s_i is the slip of the steel at place i
   along the bar, towards its root. With the elongation g_j of the line between the places

     N_j = E A/l_j (g_j + s_{j+1} - s_j - natural_j - plastic_j),   |N_j| <= T_y,
     b_i = c_i (s_i - slid_i),   |b_i| <= bond strength l_i,        N_i - N_{i-1} = b_i.

   The slips are eliminated: they minimise the energy of bar and bond. So they are no degrees of freedom,
   and the bar acts on the blocks as a truss with the forces N_j. All ranks that have a block of the bar
   solve for the same slips. A place is the middle of a bonded piece, so no place is on a joint. Place 0 of
   a bar with a head is the head, where s = 0.

   Where a bar crosses a joint it also acts as a dowel: V = K (d - sheared) along the face through which it
   leaves the block, d the slip of the joint there, and (N/T_y)^2 + (V/V_y)^2 <= 1. */
#pragma once
#include "anchors/anchors.h"

/* A place in a block, as a weighted mean of its vertices. */
enum { PLACE_VERTICES = 4 };
typedef struct {
  PetscInt n, vertex[4],
      at[4];           /* local vertices; their rows in Chain.vertex; entries from n on repeat the first */
  PetscReal weight[4]; /* 0 from n on */
} Place;

typedef struct {
  PetscInt piece;                  /* the piece that crosses the joint */
  Place on[2];                     /* where the bar leaves a block, and where it enters the next */
  Place face;                      /* its two vertices, weights 1 and -1 */
  PetscReal along[2], face_length; /* [-], [m] its direction and length in the reference configuration */
  PetscReal gap[2];                /* [m] between the two places of `on`, in the reference configuration */
  PetscReal K, V_y;                /* [N/m], [N] */
  PetscReal t[2], length;          /* face direction and length [m] of the last evaluation */
  PetscReal slip, across;          /* [m] slip of the joint along its face; opening */
  PetscReal trial, V;              /* [N] elastic trial force; force after yield */
  PetscReal beyond;                /* [-] sqrt((N/T_y)^2 + (V/V_y)^2) of the trial forces */
} Dowel;

typedef enum { CHAIN_COMMITTED, CHAIN_NOW, CHAIN_STABLE, CHAIN_STATES } ChainState;

/* State of a piece or its bond. */
typedef enum { ELASTIC, YIELDS, YIELDS_BACK, WITH_DOWEL, IS_SLACK, IS_PULLED } ChainBranch;

/* History of a chain, in the order of its archive. */
typedef struct {
  PetscReal *natural, *plastic; /* [m] (n - 1,) elongations without force; plastic elongations */
  PetscReal *slid, *slip;       /* [m] (n,) plastic slip of the bond; slip s */
  PetscReal *upright, *sheared; /* [m] (n_dowels,) slip of a joint without dowel force; plastic slip */
  PetscReal *lost;              /* [J] CHAIN_LOSSES energies dissipated by one bar */
} ChainMemory;
enum { LOST_IN_YIELD, LOST_IN_BOND, LOST_IN_DOWELS, CHAIN_LOSSES };

typedef struct {
  PetscInt n, n_dowels, n_vertices;
  PetscInt reach;     /* pieces over which stiffness couples them, see chain_tangent.c */
  PetscBool head;     /* place 0 is fixed to its block */
  PetscBool turns;    /* large strain */
  PetscBool slack;    /* piece 0 is unbonded and goes slack rather than take compression */
  PetscReal T_y;      /* [N] yield force */
  PetscReal EA;       /* [N] axial stiffness */
  PetscInt *vertex;   /* (n_vertices,) local vertices of all places */
  Place *place;       /* (n,) places, from the head on */
  PetscReal *from;    /* [m] (n,) distances of places from the head */
  PetscReal *bonded;  /* [m] (n,) bonded lengths of places; 0: the head */
  PetscReal *c, *B;   /* [N/m], [N] (n,) stiffness and strength of the bond of a place */
  PetscReal *length;  /* [m] (n - 1,) lengths of pieces */
  PetscReal *k;       /* [N/m] (n - 1,) axial stiffness of pieces */
  PetscReal *towards; /* [-] (n - 1, 2) directions from place j to j + 1 in the reference configuration */
  Dowel *dowel;
  PetscInt *crossing;               /* (n - 1,) dowel of a piece, -1: none */
  PetscReal *numbers[CHAIN_STATES]; /* (n_numbers,) each */
  ChainMemory memory[CHAIN_STATES]; /* pointers into `numbers` */
  PetscInt n_numbers;
  PetscReal jack;                    /* [N] force of a jack at place 0; < 0: no jack */
  PetscReal *g, *e, *span;           /* elongations, directions and lengths of the last evaluation: (n -
                                        1,), (n - 1, 2), (n - 1,) */
  PetscReal *N, *b;                  /* [N] (n - 1,) forces of pieces; (n,) of bonds */
  PetscReal *k_now, *c_now;          /* [N/m] (n - 1,), (n,) tangent stiffnesses */
  PetscInt *branch, *before;         /* (2n - 1,) ChainBranch of pieces, then bonds: now; one step before */
  PetscReal *r, *step, *pivot, *try; /* (n,) work space of the solver */
  PetscReal *elastic;                /* (n,) inverse pivots of the elastic matrix */
  PetscBool is_elastic;              /* last evaluation: nothing yields, slips, goes slack or is pulled */
  PetscReal *report;                 /* gathered results on all ranks, see chain_output.c; NULL: none yet */
} Chain;

/* ---- chain.c */
/* Computes the geometry of the bar at displacements u, a vertex array, with all forces zero. */
void ChainPlace(Chain *c, const PetscReal *u);
/* Computes geometry and forces from the committed history. Returns whether the slips have been found. */
PetscBool ChainEvaluate(Chain *c, const PetscReal *u);
/* Installs the bar without force at its present geometry. */
void ChainComes(Chain *c);
/* Adds the forces of the bar on blocks times `times` to f, a vertex array. */
void ChainPull(const Chain *c, PetscReal times, PetscReal *f);
/* Adds the same forces, only of pieces `from` to before `to` and their dowels. f: (2 n_vertices,) in the
   order of c->vertex. */
void ChainPullAt(const Chain *c, PetscInt from, PetscInt to, PetscReal times, PetscReal *f);
/* Returns the energy [J] stored in steel, bond and dowels. */
PetscReal ChainStored(const Chain *c);
/* Returns the force [N] of the largest size along the bar; ChainTension returns the largest tension. The bar
   breaks by its tension, even if compression is larger elsewhere. */
PetscReal ChainLargest(const Chain *c);
PetscReal ChainTension(const Chain *c);
/* Returns the elongation [m] of the first piece from the reference configuration. */
PetscReal ChainElongation(const Chain *c);
/* Returns the plastic elongation [m] of all pieces together. */
PetscReal ChainPlastic(const Chain *c);
/* Returns the energy [J] dissipated in steel, bond and dowels. */
PetscReal ChainLost(const Chain *c);
void ChainCopy(Chain *c, ChainState from, ChainState to);
/* Adds bounds of the row sums of the stiffness, times `times`, to k, a vertex array. */
void ChainBound(const Chain *c, PetscReal times, PetscReal *k);

/* ---- chain_solve.c */
/* Computes slips and forces for the elongations g and the elastic trial forces of the dowels. Returns
   whether the solution was found. */
PetscBool ChainSolve(Chain *c);
/* Factors the elastic matrix, with which ChainSolve begins. */
void ChainPrepare(Chain *c);
/* Factors the tridiagonal tangent matrix. */
void ChainFactor(Chain *c);

/* ---- chain_tangent.c: the stiffness of the bar as a sum over windows */
/* Returns the number of pieces over which forces interact. strongest: [N] largest force that the bar can
   carry. */
PetscInt ChainReach(const Chain *c, PetscReal strongest);
PetscInt ChainWindows(const Chain *c);
/* Finds the vertices of a window, as rows of c->vertex. at needs room for the vertices of all places. */
PetscErrorCode ChainWindow(const Chain *c, PetscInt window, PetscInt *n, PetscInt *at);
/* Adds the stiffness of a window times `times` to k, (2 n)^2 in the order of these vertices. */
PetscErrorCode ChainTangent(Chain *c, PetscInt window, PetscBool elastic, PetscBool turned, PetscReal times,
                            PetscInt n, const PetscInt *at, PetscReal *k);
/* Adds the forces of a window to f, as ChainPullAt does. Each force belongs to one window. */
void ChainCarried(const Chain *c, PetscInt window, PetscReal times, PetscReal *f);

/* ---- chain_output.c: results of a bonded bar */
/* Collective. Gathers c->report from the rank that owns the bar. */
PetscErrorCode ChainGather(MPI_Comm comm, PetscBool mine, Chain *c);
/* Returns by how much [m] a joint that the bar crosses, or its free length, may open further until the
   force rises from T to `most`. Assumes that the steel is bonded over more than it needs at both ends. */
PetscReal ChainReserve(const Chain *c, const Anchor *of, PetscReal T, PetscReal most);
/* Returns the stiffness [N/m] against this opening while the bond is elastic. */
PetscReal ChainStiffness(const Chain *c, const Anchor *of);
/* Writes members of the summary. */
void ChainSummary(Json *json, const Chain *c, const Anchor *of);
/* Table of bars: ChainRows rows with BAR_NUMBERS numbers each. */
enum { BAR_NUMBERS = 9 };
PetscInt ChainRows(const Chain *c);
void ChainRow(const Chain *c, const Anchor *of, PetscInt row, PetscReal *x);

/* ---- chain_setup.c */
/* Returns whether a bonded bar has a plate or a free length at its head. */
PetscBool AnchorHasHead(const Anchor *anchor);
/* Returns whether a group is present in a stage. */
PetscBool GroupIsBuilt(const Scene *scene, const char *group, PetscInt stage);
/* Collective. Creates the chains of the bonded anchors. chains: (n,), NULL: not bonded. message receives
   what is wrong. */
PetscErrorCode ChainsCreate(const Scene *scene, const Model *m, PetscInt n, const Anchor *anchors,
                            Chain **chains, char *message);
/* Refuses an anchor that begins before its group is built. key: of its place in the scene. */
void CheckBuilt(const Scene *scene, const Anchor *of, const char *group, const char *key, char *message);
PetscErrorCode ChainDestroy(Chain **chain);

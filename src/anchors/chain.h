/* chain.h: a bar that is bonded to the blocks it runs through, as a chain of pieces between places in blocks.

   Piece j runs from place j to place j + 1, counted from the head. The steel at place i has slipped by s_i
   along the bar, to its root. With the elongation g_j of the line between the places

     N_j = E A/l_j (g_j + s_{j+1} - s_j - natural_j - plastic_j),   |N_j| <= T_y,
     b_i = c_i (s_i - slid_i),   |b_i| <= bond strength l_i,        N_i - N_{i-1} = b_i.

   The slips are eliminated: they make the energy of bar and bond least, so they are no degrees of freedom and
   the blocks feel a truss with the forces N_j. All ranks that have a block of the bar solve for the same
   slips. A place is the middle of a bonded piece, so none is on a joint; place 0 of a bar with a head is the
   head, where s = 0.

   Where a bar crosses a joint it is a dowel, too: V = K (d - sheared) along the face behind which it leaves
   the block, d the slip of the joint there, and (N/T_y)^2 + (V/V_y)^2 <= 1. */
#pragma once
#include "model/model.h"

/* A place in a block. */
enum { PLACE_VERTICES = 4 };
typedef struct {
  PetscInt n, vertex[4],
      at[4];           /* local vertices; where these are in Chain.vertex; behind n the first again */
  PetscReal weight[4]; /* behind n: 0 */
} Place;

typedef struct {
  PetscInt piece;                  /* that crosses the joint */
  Place on[2];                     /* where the bar leaves a block, and where it enters the next */
  Place face;                      /* its two vertices, weights 1 and -1 */
  PetscReal along[2], face_length; /* [-], [m] of that face, in the reference state */
  PetscReal gap[2];                /* [m] between the two places of `on`, in the reference state */
  PetscReal K, V_y;                /* [N/m], [N] */
  PetscReal t[2], length;          /* of the last evaluation: of the face now, */
  PetscReal slip, across;          /* [m] of the joint there: along its face, by which it has opened */
  PetscReal trial, V;              /* [N] without yield, with it */
  PetscReal beyond;                /* [-] root of the sum of squares without yield */
} Dowel;

typedef enum { CHAIN_HELD, CHAIN_NOW, CHAIN_STABLE, CHAIN_STATES } ChainState;

/* What a piece or its bond does. */
typedef enum { ELASTIC, YIELDS, YIELDS_BACK, WITH_DOWEL, IS_SLACK, IS_PULLED } ChainBranch;

/* What a chain remembers, in the order of its archive. */
typedef struct {
  PetscReal *natural, *plastic; /* [m] (n - 1,) */
  PetscReal *slid, *slip;       /* [m] (n,) of the bond for good; s */
  PetscReal *upright, *sheared; /* [m] (n_dowels,) slip of a joint without force; plastic */
  PetscReal *lost;              /* [J] CHAIN_LOSSES, of one bar */
} ChainMemory;
enum { LOST_IN_YIELD, LOST_IN_BOND, LOST_IN_DOWELS, CHAIN_LOSSES };

typedef struct {
  PetscInt n, n_dowels, n_vertices;
  PetscInt reach;     /* pieces over which their stiffness couples them, see chain_tangent.c */
  PetscBool head;     /* place 0 is held by its block */
  PetscBool turns;    /* strain is large */
  PetscBool slack;    /* piece 0 lies free in a sheath and goes slack rather than press */
  PetscReal T_y;      /* [N] */
  PetscReal EA;       /* [N] */
  PetscInt *vertex;   /* (n_vertices,) local vertices of all places */
  Place *place;       /* (n,) */
  PetscReal *from;    /* [m] (n,) from the head to the place */
  PetscReal *bonded;  /* [m] (n,) length that is bonded there; 0: the head */
  PetscReal *c, *B;   /* [N/m], [N] (n,) of the bond there */
  PetscReal *length;  /* [m] (n - 1,) of a piece */
  PetscReal *k;       /* [N/m] (n - 1,) */
  PetscReal *towards; /* [-] (n - 1, 2) direction from place j to j + 1 in the reference state */
  Dowel *dowel;
  PetscInt *crossing;               /* (n - 1,) dowel of a piece, -1: none */
  PetscReal *numbers[CHAIN_STATES]; /* (n_numbers,) each */
  ChainMemory memory[CHAIN_STATES]; /* pointers into numbers */
  PetscInt n_numbers;
  PetscReal jack;                    /* [N] with which a jack pulls at place 0; < 0: none does */
  PetscReal *g, *e, *span;           /* of the last evaluation: (n - 1,), (n - 1, 2), (n - 1,) */
  PetscReal *N, *b;                  /* [N] (n - 1,), (n,) */
  PetscReal *k_now, *c_now;          /* [N/m] (n - 1,), (n,) slopes */
  PetscInt *branch, *before;         /* (2n - 1,) a ChainBranch of pieces, then bonds */
  PetscReal *r, *step, *pivot, *try; /* (n,) room of the solver */
  PetscReal *elastic;                /* (n,) pivots of the elastic matrix */
  PetscBool is_elastic;              /* the last evaluation: nothing yields, slips, goes slack or is pulled */
  PetscReal *told;                   /* (ChainToldSize,) on all ranks, see chain_output.c; NULL: not yet */
} Chain;

/* ---- chain.c */
/* Where it runs at displacements u, a vertex array; it carries nothing. */
void ChainPlace(Chain *c, const PetscReal *u);
/* Also what it carries, from the history held. Whether its slips have been found. */
PetscBool ChainEvaluate(Chain *c, const PetscReal *u);
/* It is there from now on, without force: but for a free piece that is stressed. */
void ChainComes(Chain *c);
/* Adds its forces on blocks to f, a vertex array, each times `times`. */
void ChainPull(const Chain *c, PetscReal times, PetscReal *f);
/* The same of pieces from `from` to before `to`, and their dowels, with f (2 n_vertices,) in the order of
   c->vertex. */
void ChainPullAt(const Chain *c, PetscInt from, PetscInt to, PetscReal times, PetscReal *f);
/* [J] stored in steel, bond and dowels. */
PetscReal ChainStored(const Chain *c);
/* [N] force of the largest size along it; largest tension, by which it breaks though it may be pressed harder
   elsewhere. */
PetscReal ChainLargest(const Chain *c);
PetscReal ChainTension(const Chain *c);
/* [m] by which its first piece is longer than in the reference state. */
PetscReal ChainElongation(const Chain *c);
/* [m] for good, of all pieces together. */
PetscReal ChainPlastic(const Chain *c);
/* [J] in yield, bond and dowels. */
PetscReal ChainLost(const Chain *c);
void ChainCopy(Chain *c, ChainState from, ChainState to);
/* Adds row sums to k, a vertex array. */
void ChainBound(const Chain *c, PetscReal times, PetscReal *k);

/* ---- chain_solve.c */
/* Finds slips and forces for the elongations g; the forces that would move the dowels elastically are
   known. Whether it has. */
PetscBool ChainSolve(Chain *c);
/* Factors the matrix of elastic slopes, which ChainSolve begins with. */
void ChainPrepare(Chain *c);
/* Factors the tridiagonal matrix of the present slopes, and solves it for the right side x. */
void ChainFactor(Chain *c);
void ChainBack(const Chain *c, PetscReal *x);

/* ---- chain_tangent.c: the stiffness of the bar, a window at a time; their sum is all of it */
/* strongest: [N] most that the bar carries. */
PetscInt ChainReach(const Chain *c, PetscReal strongest);
PetscInt ChainWindows(const Chain *c);
/* The vertices that meet in a window, as their numbers in c->vertex; at has room for those of all places. */
PetscErrorCode ChainWindow(const Chain *c, PetscInt window, PetscInt *n, PetscInt *at);
/* Adds (2 n)^2 in the order of these vertices to k, times `times`. */
PetscErrorCode ChainTangent(Chain *c, PetscInt window, PetscBool elastic, PetscBool turned, PetscReal times,
                            PetscInt n, const PetscInt *at, PetscReal *k);
/* Adds the forces of a window, of which each belongs to one, to f as ChainPullAt does. */
void ChainCarried(const Chain *c, PetscInt window, PetscReal times, PetscReal *f);

/* ---- chain_output.c: what is told of a bonded bar, see there */
/* Collective. Writes c->told from the rank whose own it is. */
PetscErrorCode ChainGather(MPI_Comm comm, PetscBool mine, Chain *c);
/* [m] by which a joint that it crosses, or its free length, may open further until it carries `most` instead
   of T, both ends of the steel bonded over more than they need. */
PetscReal ChainReserve(const Chain *c, const Anchor *of, PetscReal T, PetscReal most);
/* [N/m] against that, while the bond is elastic. */
PetscReal ChainStiffness(const Chain *c, const Anchor *of);
/* Members of the summary, each with a comma behind. */
void ChainSummary(FILE *f, const Chain *c, const Anchor *of);
/* Rows of the table of bars: ChainRows numbers of them, BAR_NUMBERS each. */
enum { BAR_NUMBERS = 9 };
PetscInt ChainRows(const Chain *c);
void ChainRow(const Chain *c, const Anchor *of, PetscInt row, PetscReal *x);

/* ---- chain_setup.c */
/* Collective. Chains of the bonded anchors; chains: (n,), NULL: it is not bonded. message: what is wrong. */
PetscErrorCode ChainsCreate(const Scene *scene, const Model *m, PetscInt n, const Anchor *anchors,
                            Chain **chains, char *message);
/* Refuses an anchor that is there before the group is which holds it; key: of its place in the scene. */
void CheckBuilt(const Scene *scene, const Anchor *of, const char *group, const char *key, char *message);
PetscErrorCode ChainDestroy(Chain **chain);

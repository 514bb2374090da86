/* nested.h: declares the factor of the elastic stiffness K0 for a solve every cycle, with the same bits on
   any number of ranks.

   elastic_matrix.c adds up K0 on rank 0, in an order and with sums that no partition changes. nested_order.c
   orders it by nested dissection. nested_factor.c factorises it there; nested_solve.c deals the factor out to
   the ranks and solves with it. Rows are eliminated supernode by supernode: columns with the same rows below
   them, which make a dense matrix. */
#pragma once
#include "base/shared.h"
#include "solve/stiffness.h"

/* K0 on rank 0. Rows stand in the order of their bodies and vertices in the mesh, which no partition
   changes. A node is a rigid body with 3 rows or a deformable vertex with 2. */
typedef struct {
  PetscInt n, n_nodes;
  PetscInt *node_start; /* (n_nodes + 1,) first row of each node */
  PetscInt *start;      /* (n + 1,) entries of each row: the upper triangle, in ascending columns */
  PetscInt *column;
  PetscReal *value; /* [N/m] */
} ElasticMatrix;

/* The order of elimination. The supernodes of part i are part[i] .. part[i + 1] - 1: parts do not couple. The
   supernodes from part[NESTED_PARTS] on separate them. */
enum { NESTED_PARTS = 4 };
typedef struct {
  PetscInt n, n_supers;
  PetscInt *place;     /* (n,) place of each row of the matrix in the order of elimination */
  PetscInt *first;     /* (n_supers + 1,) first column of each supernode */
  PetscInt *row_start; /* (n_supers + 1,) into row */
  PetscInt *row;       /* rows of each supernode below its columns, ascending */
  PetscInt *parent;    /* (n_supers,) supernode that has the first of these rows; -1: none */
  PetscInt part[NESTED_PARTS + 1];
} NestedOrder;

/* The dense matrices of supernodes, B = [L^-1; -L_below L^-1], L the factor of the supernode. In single
   precision: the mass may be any matrix near K0, as long as all cycles have the same one, and half of the
   memory is read. They lie in memory as a solve reads them, forward and backward: NESTED_PANEL columns after
   NESTED_PANEL columns, in these NESTED_LANES rows after NESTED_LANES rows, in these column after column. The
   rows above the first columns of a panel, where L^-1 is zero, are left out. */
enum { NESTED_LANES = 8, NESTED_PANEL = 4 };
typedef float NestedReal;

typedef struct _p_Nested *Nested;
/* Consecutive supernodes on this rank: a part, or the top. */
typedef struct {
  PetscInt n;          /* supernodes */
  PetscInt *first;     /* (n + 1,) place of the first column in x */
  PetscInt *row_start; /* (n + 1,) into row, multiples of NESTED_LANES */
  PetscInt *row;       /* places in x of the rows, own columns first */
  size_t n_values;     /* in B */
  NestedReal *B;       /* one after the other */
} NestedPiece;

/* What a rank shows to the other ranks of its machine. Every rank waits for all others three times a solve,
   so nobody still reads what is written next. */
enum { GIVEN, SUMMED, SOLVED, STEPS };
typedef struct {
  struct {
    _Alignas(SHARED_LINE) Count count; /* number of solves that have come so far */
  } step[STEPS];
  PetscReal values[]; /* right-hand side (n_dof,), sums for the top of each part here, x */
} NestedShown;

struct _p_Nested {
  MPI_Comm comm;
  PetscMPIInt size, rank;
  PetscInt n, n_dof, n_below, n_top; /* rows; of this rank; columns of the parts; of the top */
  NestedPiece piece[NESTED_PARTS + 1];
  NestedReal *values;                                  /* on one rank, those of all pieces */
  PetscMPIInt owner[NESTED_PARTS], slot[NESTED_PARTS]; /* rank of each part; its copy of the top */
  PetscInt *place;                                     /* (n_dof,) place of each degree of freedom in x */
  PetscInt room;
  PetscReal *x; /* (room,) right-hand side, then solution; see nested_solve.c */

  /* exchange through shared memory */
  PetscInt64 solves;                   /* solves that this rank has begun */
  Shared memory;                       /* mine is NULL where there is none: messages */
  NestedShown **near;                  /* (size,) of all ranks */
  PetscInt n_given, *given_to;         /* right-hand sides that this rank needs, their places in x */
  const PetscReal **given, **solved;   /* (n_given,), (n_dof,) where they, and solutions, are shown */
  const PetscReal *sums[NESTED_PARTS]; /* where the sums for the top of each part are shown */
  /* and by messages */
  PetscMPIInt *count, *from; /* (size,) of the copies of the top on each rank */
  PetscSF give, take;

  Mat matrix;
  PC pc;
  ElasticMatrix whole;     /* on rank 0 */
  PetscInt *number;        /* (n,) on rank 0, row of each degree of freedom in PETSc's order */
  PetscReal *product_work; /* (2, n) on rank 0 */
  VecScatter to_first;     /* all degrees of freedom to rank 0 */
  Vec on_first, product;
};

/* ---- elastic_matrix.c */
/* Collective. Writes the number of each degree of freedom of all ranks, in PETSc's parallel order, in the
   order of the mesh. *number: (all degrees of freedom,), free with PetscFree. */
PetscErrorCode ElasticNumbers(const Model *model, PetscInt **number);
/* Collective. Adds up K0 on rank 0; other ranks get an empty matrix. wants: the memory ran out. */
PetscErrorCode ElasticMatrixCreate(const Instant *at, const State *state, const Stiffness *s,
                                   const PetscInt *number, ElasticMatrix *matrix, PetscBool *wants);
PetscErrorCode ElasticMatrixDestroy(ElasticMatrix *matrix);

/* ---- nested_order.c. Rank 0 */
PetscErrorCode NestedOrderCreate(const ElasticMatrix *matrix, NestedOrder *order);
PetscErrorCode NestedOrderDestroy(NestedOrder *order);

/* ---- nested_factor.c */
/* Returns the number of values of a supernode of `width` columns with `n` rows, its own included. */
static inline size_t NestedSize(PetscInt width, PetscInt n)
{
  const PetscInt times = (n + NESTED_LANES - 1) / NESTED_LANES, panels = width / NESTED_PANEL,
                 rest = width % NESTED_PANEL, left_out = panels / 2 * ((panels - 1) / 2); // sum of panel / 2
  return (size_t)NESTED_LANES *
         (NESTED_PANEL * ((size_t)panels * times - left_out) + (size_t)rest * (times - panels / 2));
}
_Static_assert(NESTED_LANES == 2 * NESTED_PANEL, "the rows above a panel, see NestedSize");
/* Rank 0. Factorises the matrix. *values: the B of all supernodes, one after the other. positive: FALSE:
   there is no factor. */
PetscErrorCode NestedFactorise(const ElasticMatrix *matrix, const NestedOrder *order, NestedReal **values,
                               PetscBool *positive);

/* ---- nested_solve.c */
/* Returns the place in x of the copy of the top that a part has. */
static inline PetscInt NestedCopy(Nested f, PetscInt part)
{
  return f->n + 1 + f->slot[part] * f->n_top;
}
/* Collective. Solves with the factor: PCShellSetApply. */
PetscErrorCode NestedSolve(PC pc, Vec from, Vec to);
/* Collective. Multiplies by K0, on rank 0 for all, because checks alone need the product: MATOP_MULT. */
PetscErrorCode NestedMultiply(Mat matrix, Vec from, Vec to);

/* ---- nested_share.c */
/* Collective. Makes the factor of K0 for the present contacts. s: its rows are numbered. fails: K0 is not
   positive definite, or, wants, the memory ran out. */
PetscErrorCode NestedCreate(const Problem *p, const Stiffness *s, Nested *nested, PetscBool *fails,
                            PetscBool *wants);
PetscErrorCode NestedDestroy(Nested *nested);
/* Return K0 and the solver with its factor. They stay until NestedDestroy. */
Mat NestedMatrix(Nested nested);
PC NestedSolver(Nested nested);

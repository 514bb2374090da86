/* laws.h: declares material laws of deformable blocks with a history (not elastic).

   A law is a row of the table in laws.c and a kernel that law_kernels.h calls. It gives the stress at a
   point from the strain there and from the history of the point. In a static stage every evaluation starts
   from the history of the last equilibrium (`committed`), as for joints, so the path of relaxation has no
   effect. In a dynamic stage the history advances with every step. */
#pragma once
#include "blocks/blocks.h"

/* Every history begins with these three numbers; the rest belongs to its law. */
enum {
  HISTORY_LOST,    /* [J/m3] dissipated so far, per reference volume */
  HISTORY_MEASURE, /* [-] measure of damage: plastic strain */
  HISTORY_SOFT,    /* [-] lost fraction of the stiffness against bending of a one-point block */
  HISTORY_OWN,
  HISTORY_MOST = 8 /* numbers of a point, at most */
};

/* Constants of a group for the kernel: moduli, stiffness against bending, then the constants of its law. */
enum {
  LAW_LAMBDA,                        /* [Pa] */
  LAW_MU,                            /* [Pa] */
  LAW_HOURGLASS,                     /* [Pa] 3 of them */
  LAW_EXPANSION = LAW_HOURGLASS + 3, /* [1/K] */
  LAW_ACROSS, /* [-] restraint of the expansion across the plane: 1; 0: blocks are free there */
  LAW_OWN,
  LAW_CONSTANTS = LAW_OWN + 20
};

/* Temperatures of the blocks of a list: the sum of all temperatures of the scene, each times its share.
   The arrays belong to temperature.c and the state. */
typedef struct {
  PetscInt n;               /* temperatures; 0: none for these blocks */
  const PetscReal **change; /* [K] (n,) each at the vertices of the blocks, in the lanes of Elements.vertex */
  PetscInt *load;           /* (n,) rows of the scene */
  PetscReal *const *share;  /* State.applied.share */
} LawHeat;

/* The history of one list of elements, ordered by point, number and lane, so that a kernel loads a number
   of LANES blocks at once. */
typedef struct _p_LawHistory {
  PetscInt n; /* numbers in each array */
  int points; /* points of a block with a history: 4 if one block is ELEMENT_FULL, else
                                     1 */
  int width;  /* numbers of a point */
  PetscReal *committed, *now, *stable; /* (n_padded / LANES, points, width, LANES) history of the last
                                     equilibrium; of the last evaluation with results; of the last stable
                                     trial */
  PetscReal *constants;                /* (n_groups, LAW_CONSTANTS, LANES) each number in all lanes */
  LawHeat heat;
  PetscBool in_time; /* dynamic stage: every evaluation starts from the one before */
} LawHistory;

typedef struct {
  const char *name;
  const char *measure; /* name of HISTORY_MEASURE in results.h5 */
  int width;           /* numbers of a point's history */
  /* Fills in the constants from LAW_OWN on. */
  void (*constants)(const Material *material, Lame lame, PetscReal constant[LAW_CONSTANTS]);
  /* Returns the largest width [m] of a block across a crack, from its constants; NULL: no limit. */
  PetscReal (*widest)(const PetscReal constant[LAW_CONSTANTS]);
} LawKind;

/* By MaterialLaw; the row of elastic blocks is empty. */
extern const LawKind LawKinds[MATERIAL_LAWS];

/* Adds the resisting forces of a list to f. keep: store the history of the result in `now`. */
void LawForces(const Model *model, const Elements *e, PetscBool keep, const PetscReal *u, PetscReal *f);
/* Computes the tangent [N/m] of four elements at u by differences of forces from the committed history:
   see ElementMatrices. It is not symmetric. For cracking blocks it is the secant, with damage as at u. */
void LawMatrices(const Model *model, const Elements *e, PetscInt first, const PetscReal *u,
                 PetscReal K[][64]);
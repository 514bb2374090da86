/* laws.h: material laws of deformable blocks that are not elastic: those with a history.

   A law is a row of the table in laws.c and a kernel that law_kernels.h calls. It gives the stress at a point
   from the strain there and from the history of the point. In a static stage every evaluation starts from the
   history of the last equilibrium (`held`), as that of joints does, so how a stage relaxes leaves no trace.
   In a stage in time it goes on from step to step. */
#pragma once
#include "blocks/blocks.h"

/* Every history begins with these three; what else it has is its law's own. */
enum {
  HISTORY_LOST,    /* [J/m3] dissipated so far, per reference volume */
  HISTORY_MEASURE, /* [-] of what is lost for good: plastic strain */
  HISTORY_SOFT,    /* [-] what is gone of the stiffness against bending of a block of one point */
  HISTORY_OWN,
  HISTORY_MOST = 8 /* numbers of a point */
};

/* What the kernel needs of a group: moduli and stiffness against bending, then what its law adds. */
enum {
  LAW_LAMBDA,                        /* [Pa] */
  LAW_MU,                            /* [Pa] */
  LAW_HOURGLASS,                     /* [Pa] 3 of them */
  LAW_EXPANSION = LAW_HOURGLASS + 3, /* [1/K] */
  LAW_ACROSS, /* [-] of it, what the plane holds of it across: 1; 0: blocks are free there */
  LAW_OWN,
  LAW_CONSTANTS = LAW_OWN + 20
};

/* How warm the blocks of a list are: the sum of all temperatures of the scene, each times its share. The
   arrays are those of temperature.c and of the state. */
typedef struct {
  PetscInt n;               /* temperatures; 0: none that these blocks feel */
  const PetscReal **change; /* [K] (n,) each at the vertices of the blocks, in the lanes of Elements.vertex */
  PetscInt *load;           /* (n,) rows of the scene */
  PetscReal *const *share;  /* State.applied.share */
} LawHeat;

/* The history of one list of elements; by point, number and lane, so that a kernel loads a number of LANES
   blocks at once. */
typedef struct _p_LawHistory {
  PetscInt n;                     /* numbers in each array */
  int points;                     /* of a block that have a history: 4 where one is ELEMENT_FULL, else 1 */
  int width;                      /* numbers of a point */
  PetscReal *held, *now, *stable; /* (n_padded / LANES, points, width, LANES) of the last equilibrium, of the
                                     last evaluation that somebody checks at, of the last stable trial */
  PetscReal *constants;           /* (n_groups, LAW_CONSTANTS, LANES) each number in all lanes */
  LawHeat heat;
  PetscBool in_time; /* every evaluation goes on from the one before */
} LawHistory;

typedef struct {
  const char *name;
  const char *measure; /* name of HISTORY_MEASURE in results.h5 */
  int width;           /* numbers of a point's history */
  /* Fills in the constants from LAW_OWN on. */
  void (*constants)(const Material *material, Lame lame, PetscReal constant[LAW_CONSTANTS]);
  /* [m] How wide a block may not be across a crack, from its constants; NULL: as wide as it likes. */
  PetscReal (*widest)(const PetscReal constant[LAW_CONSTANTS]);
} LawKind;

/* By MaterialLaw; the row of elastic blocks is empty. */
extern const LawKind LawKinds[MATERIAL_LAWS];

/* Adds the resisting forces of a list to f. keep: somebody checks at the result, so `now` has its history. */
void LawForces(const Model *model, const Elements *e, PetscBool keep, const PetscReal *u, PetscReal *f);
/* Tangent [N/m] of four elements at u by differences of the forces, from the held history: see
   ElementMatrices. It is not symmetric. Of blocks that crack: the secant, with damage as it is at u. */
void LawMatrices(const Model *model, const Elements *e, PetscInt first, const PetscReal *u,
                 PetscReal K[][64]);
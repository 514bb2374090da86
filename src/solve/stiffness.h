/* stiffness.h: declares the assembled stiffness of the model. */
#pragma once
#include "solve/solve.h"
#include <petscksp.h>

/* The places of the values of one coupling in the tangent. */
enum { STIFFNESS_VERTICES = 6 }; /* vertices of a contact; an element has four */
typedef struct {
  PetscInt n, vertices[STIFFNESS_VERTICES];                 /* vertices that it couples; n 0: not yet known */
  PetscInt at[4 * STIFFNESS_VERTICES * STIFFNESS_VERTICES]; /* (2n,2n) places; -1: held */
} StiffnessPlace;

/* Rows of the matrix are the dofs of State in PETSc's parallel numbering. A vertex acts through up to three
   rows: x, y, and, on a rigid body, its rotation. Held dofs have row -1 (nothing is added there) and a
   diagonal of their own. */
typedef struct _p_Stiffness {
  PetscInt n_vertices; /* number of local vertices with rows */
  PetscInt first;      /* global row of the first degree of freedom of this rank */
  PetscInt *row;       /* (n_vertices + dummies, 3) global rows; -1: held, or none */
  PetscReal *arm;      /* [m] (n_vertices + dummies, 2) from the centre of the rigid body the vertex is on */
  PetscBool turned;    /* the matrices include the rotation of bodies and faces under the forces they carry */
  PetscBool small;     /* motions are so small that no joint slips; set before StiffnessTangent */
  PetscBool fixed;     /* only condensed bodies deform, and none is rigid: `bodies` never changes */
  PetscBool made;      /* `bodies` has been assembled */
  PetscInt n_places;   /* if `fixed`, on one rank: number of couplings of joints with a place */
  StiffnessPlace *places; /* (n_places,) in the order of joints; NULL: none */
  Mat bodies;             /* [N/m] stiffness of all terms but joints, with the pattern of all terms */
  Mat tangent;            /* [N/m] `bodies` and the tangent of joints; same pattern */
} Stiffness;

/* ---- stiffness_pattern.c */
/* Collective. Gives an AIJ matrix with its sizes set exactly the entries that StiffnessAdd will fill, as
   zeros. The rows of s must be numbered. */
PetscErrorCode StiffnessPattern(const Model *model, const State *state, Contacts *contacts,
                                const Stiffness *s, Mat matrix);

/* ---- stiffness.c */
/* Collective. Numbers the rows; there are no matrices. */
PetscErrorCode StiffnessRows(const Model *model, Stiffness *s);
/* Collective. Numbers the rows and lays out both matrices for the model and its present contacts. */
PetscErrorCode StiffnessCreate(const Model *model, const State *state, Contacts *contacts, Stiffness *s);
PetscErrorCode StiffnessDestroy(Stiffness *s);
/* Adds a dense stiffness k [N/m] (2n,2n), row after row, symmetric or not, that couples x and y of n local
   vertices. Not collective; StiffnessBodies ends the assembly. */
PetscErrorCode StiffnessAdd(const Model *model, const Stiffness *s, Mat matrix, PetscInt n,
                            const PetscInt *vertices, const PetscReal *k);
/* Collective. Assembles s->bodies: in the reference state, or, `turned`, in large strain at the
   displacements of the state. The tangent of joints then includes their rotation too. */
PetscErrorCode StiffnessBodies(const Model *model, const State *state, PetscBool turned, Stiffness *s);
/* Collective. Assembles s->tangent: s->bodies and the joints as they were last evaluated, from the
   committed history; `elastic`: joints that neither open nor slip, in the reference state. */
PetscErrorCode StiffnessTangent(const Model *model, const State *state, const Joint *joints,
                                Contacts *contacts, PetscBool elastic, Stiffness *s);

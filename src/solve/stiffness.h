/* stiffness.h: the assembled stiffness of the model and what is solved with it. */
#pragma once
#include "solve/solve.h"
#include <petscksp.h>

/* Where the values of one coupling stand in the tangent. */
enum { STIFFNESS_VERTICES = 6 }; /* of a contact; those of an element are four */
typedef struct {
  PetscInt n, vertices[STIFFNESS_VERTICES];                 /* what it couples; 0: not yet known */
  PetscInt at[4 * STIFFNESS_VERTICES * STIFFNESS_VERTICES]; /* of (2n,2n), -1: held */
} StiffnessPlace;

/* Rows of the matrix are the dofs of State in PETSc's parallel numbering. A vertex acts through up to three
   rows: x, y, and, on a rigid body, its rotation. Held dofs have row -1 (nothing is added there) and a
   diagonal of their own. */
typedef struct _p_Stiffness {
  PetscInt n_vertices; /* the rows are those of this many local vertices */
  PetscInt first;      /* global row of this rank's first dof */
  PetscInt *row;       /* (n_vertices + dummies, 3) global rows, -1: held, or none */
  PetscReal *arm;      /* [m] (n_vertices + dummies, 2) from the centre of the rigid body the vertex is on */
  PetscBool turned;    /* the matrices are those of turned bodies and faces under the forces they carry */
  PetscBool small;     /* and of motions so small that no joint slips: set it before StiffnessTangent */
  PetscBool fixed;     /* no block deforms but in condensed bodies, and no body is rigid: the stiffness of
                          bodies hangs on no motion */
  PetscBool made;      /* `bodies` has been assembled */
  PetscInt n_places;   /* `fixed`, on one rank: how many couplings of joints have had a place */
  StiffnessPlace *places; /* (n_places,) in the order in which joints come, NULL: none */
  Mat bodies;             /* [N/m] of all terms but joints, with the pattern of all */
  Mat tangent;            /* bodies and the tangent of the joints; same pattern */
} Stiffness;

/* ---- stiffness_pattern.c */
/* Collective. Gives an AIJ matrix, its sizes set, exactly the rows that StiffnessAdd will fill, with zeros.
   s: its rows are numbered. */
PetscErrorCode StiffnessPattern(const Model *model, const State *state, Contacts *contacts,
                                const Stiffness *s, Mat matrix);

/* ---- stiffness.c */
/* Collective. Numbers the rows and lays out both matrices for the model and its contacts as they are. */
PetscErrorCode StiffnessCreate(const Model *model, const State *state, Contacts *contacts, Stiffness *s);
PetscErrorCode StiffnessDestroy(Stiffness *s);
/* Adds a dense stiffness k [N/m] (2n,2n), row after row, symmetric or not, that couples x and y of n local
   vertices: the one way into the matrix. Not collective; StiffnessBodies ends the assembly. */
PetscErrorCode StiffnessAdd(const Model *model, const Stiffness *s, Mat matrix, PetscInt n,
                            const PetscInt *vertices, const PetscReal *k);
/* Collective. s->bodies: in the reference state or, `turned`, in large strain at the displacements of the
   state. Then the tangent of the joints, too, has what comes of their turning. */
PetscErrorCode StiffnessBodies(const Model *model, const State *state, PetscBool turned, Stiffness *s);
/* Collective. s->tangent: s->bodies and the joints, as they were last evaluated, from the history committed;
   or, `elastic`, whole and in the reference state. */
PetscErrorCode StiffnessTangent(const Model *model, const State *state, const Joint *joints,
                                Contacts *contacts, PetscBool elastic, Stiffness *s);

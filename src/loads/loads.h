/* loads.h: declares dead loads (weight, traction, point force; the force term to copy), and temperature. */
#pragma once
#include "blocks/blocks.h"

extern const TermKind Loads_term, Temperature_term, Push_term;

/* Completes the keys of a load, see reader.h. */
LoadCompletion CompleteTemperature;

/* Results of the blocks of a list, from their total strain until terms have corrected them. NULL: not
   requested. */
typedef struct {
  PetscReal *centre, *gauss; /* [Pa] (n, 3), (n, 1 or 4, 3) Cauchy stress, as from ElementStress and
                                ElementStressGauss */
  PetscReal *energy;         /* [J] (n,) */
  PetscReal *change;         /* [K] (n,) mean change of temperature */
  PetscReal *across;         /* [Pa] (n,) thermal part of the stress across the plane, at the centre */
} BlockAnswers;

/* Corrects the results of the blocks of a list for their temperature. v: of Temperature_term. */
PetscErrorCode TemperatureCorrects(const TermView *v, const Elements *list, BlockAnswers *answers);

/* Adds the lumped masses (27) of the groups of the load (none named: all groups) times a [m/s2]. f_vertex:
   vertex array. */
PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex);

/* ---- push.c */
/* c [m]; R [N]; unbalanced ratio [-]; 1 where an equilibrium was found, else 0 */
enum { PUSH_MOVED, PUSH_FORCE, PUSH_RATIO, PUSH_RESTS, PUSH_COLUMNS };
/* The displacement that a pushover prescribes, c = sum w . (u - u at the start) over vertices, and the force
   R w that keeps c on the path. The memory of Push_term. */
typedef struct {
  PetscBool acts;          /* R acts */
  PetscInt n;              /* number of owned vertices with a weight */
  PetscInt *vertex;        /* (n,) */
  PetscReal *w;            /* (n,2) [-] */
  PetscInt *slot;          /* (2n,) and */
  PetscReal *term;         /* (2n,) room for sums */
  PetscReal load;          /* [N] resultant of the loads that push, at factor 1; 0: no loads do */
  PetscReal start;         /* [m] sum w . u at the start of the path */
  PetscReal force;         /* [N] R */
  PetscReal from, to, aim; /* [m] c at the start and at the end of the increment; at the present cycle */
  PetscReal ramp;          /* [-] fraction of the increment */
  PetscReal mass;          /* [kg] scaled mass that R moves */
  PetscReal scale;         /* [N] sum of the sizes of all applied forces where the path starts */
  PetscReal work;          /* [J] work of R in the increment, each part of it taken as positive */
  PetscInt n_rows;
  PetscReal *rows; /* (n_rows, PUSH_COLUMNS) equilibria so far */
} Push;
/* Collective. Sets the weights: w is f, forces at owned vertices (vertex array), over the resultant of f
   along direction (a unit vector). rows: largest number of equilibria. message: receives the reason why these
   vertices cannot be moved along w, on all ranks. */
PetscErrorCode PushBegin(const Scene *scene, const Model *m, const State *state, const PetscReal *f,
                         const PetscReal direction[2], PetscInt rows, Push *push,
                         char message[MESSAGE_LENGTH]);
PetscErrorCode PushEnd(Push *push);
/* Returns the row of the largest force, in either sense, at which an equilibrium was found. */
const PetscReal *PushPeak(const Push *push);
/* Collective. Counts c from the present displacements: the path starts here. */
PetscErrorCode PushFromHere(const Model *m, const State *state, Push *push);
/* Collective. Sets the aim of c after the next cycle, at a fraction `ramp` of the increment. */
PetscErrorCode PushAim(const Model *m, const State *state, PetscReal ramp, Push *push);
/* Collective. Corrects the motion of the cycle just made so that c meets its aim, and R by the force that
   does this. */
PetscErrorCode PushHold(const Model *m, State *state, Push *push);

/* water.h: declares water pressure on faces and in joints. */
#pragma once
#include "blocks/blocks.h"

/* Rows of the table of force terms. */
extern const TermKind Reservoir_term, Wave_term, Pseudo_static_term, Added_mass_term, Uplift_term,
    Pressure_term;

/* Complete the keys of loads, see reader.h. */
LoadCompletion CompleteOverflow, CompleteTailwater, CompleteSilt, CompleteWave, CompletePseudoStatic,
    CompleteUplift;

/* Keeps the largest acceleration of faces away from the water, in a dynamic stage, with all velocities after
   a step. memory: of Added_mass_term. v_before: (n_dof,) velocities before the step. */
void AddedMassRecord(void *memory, const Model *m, const State *s, const PetscReal *v_before);

/* Adds to f the forces of a Gauss point at `at` (0..1) of the face from x[0..1] to x[2..3]. push: [N/m]
   weight of the point times pressure times thickness; the function multiplies by the length of the face. */
void PushOnFace(const PetscReal x[4], PetscReal at, PetscReal push, PetscReal f[4]);
/* Adds to f the forces of a pressure that varies linearly from p[0] [Pa] at t[0] of the face to p[1] at
   t[1]. x, f: (4) ends of the face, forces there [N]. */
void PushAlongFace(const PetscReal t[2], const PetscReal p[2], const PetscReal x[4], PetscReal thickness,
                   PetscReal f[4]);
/* Computes the forces of a load on one face. x: (4) present ends of the face, f: (4) receives the forces
   there [N]. */
typedef void (*PressFace)(const PetscReal x[4], const void *context, PetscReal f[4]);
/* Adds to f_vertex the forces of `press` on each face of a set. In large strain faces move; those of
   condensed bodies with each correction (condense_large.c), or not. */
void PressOnFaces(const TermView *v, const char *set, PressFace press, const void *context,
                  PetscReal *f_vertex);
/* Collective. Computes the lowest and highest elevation [m] of the faces of a set in the mesh. For an
   empty set the lowest exceeds the highest. */
PetscErrorCode FacesEnd(const Model *m, const char *set, PetscReal ends[2]);
/* Computes the hydrostatic forces on one face, of water with its surface at `level`: pressure rho_g (level
   - y), normal to the face. x: (4) present ends of the face. f: (4) receives the forces [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

/* ---- heel.c */
/* Returns the end of a joint at which a water stands: 0 its start, 1 its end, -1: undecided, or dry.
   faces: (4 n) ends of the faces under pressure, ends: (4) start and end of the joint. */
int WaterSide(PetscInt n, const PetscReal *faces, PetscReal level, const PetscReal ends[4]);
/* Collective. Finds start and end of the joint on which a face set lies, its outermost points. ends: (4). */
PetscErrorCode JointEnds(const Model *m, const char *set, PetscReal ends[4]);
/* Collective. Decides which end of a joint is the heel, for an uplift or a drain at a distance: from the
   key heel and from the waters that act together with the load. message receives a contradiction between
   the two. */
PetscErrorCode HeelOf(const Scene *scene, const Model *m, PetscInt load, const PetscReal ends[4],
                      PetscBool *at_end, char message[MESSAGE_LENGTH]);

/* water.h: water on faces and in joints. */
#pragma once
#include "blocks/blocks.h"

/* Rows of the table of force terms. */
extern const TermKind Reservoir_term, Wave_term, Pseudo_static_term, Added_mass_term, Uplift_term,
    Pressure_term;

/* Adds to f the forces that a Gauss point at `at` (0..1) of the face from x[0..1] to x[2..3] gives to the
   ends of the face. push: [N/m] weight of the point times pressure times thickness; the function multiplies
   it by the length of the face. */
void PushOnFace(const PetscReal x[4], PetscReal at, PetscReal push, PetscReal f[4]);
/* Adds to f the forces of pressure that runs from p[0] [Pa] at t[0] of the face to p[1] at t[1]. x, f: (4)
   ends of the face, forces at them [N]. */
void PushAlongFace(const PetscReal t[2], const PetscReal p[2], const PetscReal x[4], PetscReal thickness,
                   PetscReal f[4]);
/* What presses on one face: x: (4) present ends of the face, f: (4) receives the forces at them [N]. */
typedef void (*PressFace)(const PetscReal x[4], const void *context, PetscReal f[4]);
/* Adds to f_vertex what `press` gives on each face of a set. Faces of condensed bodies stay where the mesh
   has them, the others move in large strain. */
void PressOnFaces(const TermView *v, const char *set, PressFace press, const void *context,
                  PetscReal *f_vertex);
/* Collective. Lowest and highest elevation [m] of the faces of a set in the mesh; of an empty set the lowest
   is the larger one. ends: receives them. */
PetscErrorCode FacesEnd(const Model *m, const char *set, PetscReal ends[2]);
/* Finds the forces of water with its surface at `level` on one face: pressure rho_g (level - y), normal to
   the face. x: (4) present ends of the face. f: (4) forces at the two ends [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

/* ---- heel.c */
/* At which end of a joint a water stands: 0 its start, 1 its end, -1: nobody can tell, or it is dry. faces:
   (4 n) ends of the faces on which it presses, ends: (4) start and end of the joint. */
int WaterSide(PetscInt n, const PetscReal *faces, PetscReal level, const PetscReal ends[4]);
/* Collective. Start and end of the joint on which a face set lies: its outermost places. ends: (4). */
PetscErrorCode JointEnds(const Model *m, const char *set, PetscReal ends[4]);
/* Collective. Whether the heel of the joint of an uplift, or of a drain at a distance, is its end, by the key
   heel and by the waters that act together with the load. message: what is wrong where both differ. */
PetscErrorCode HeelOf(const Scene *scene, const Model *m, PetscInt load, const PetscReal ends[4],
                      PetscBool *at_end, char message[MESSAGE_LENGTH]);

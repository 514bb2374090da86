/* hydrodynamic.h: pressure of water whose bottom and wall shake together, over depth. */
#pragma once
#include "water/water.h"

/* The wet faces of a load taken as one wall. */
typedef struct {
  HydroRule rule;
  PetscReal level, depth; /* [m] elevation of the water; from there to the bottom */
  PetscReal lowest;       /* [m] elevation of the lowest point of the faces */
  PetscReal lean;         /* [degree] of the line from the water's edge to the lowest point, off the vertical;
                             negative: it overhangs the water */
  PetscReal
      normal[2];     /* [-] least and largest x of the outward normals of the wet faces; 1, -1: none is wet */
  PetscReal largest; /* [-] zangar: pressure coefficient C_m */
} WetWall;
/* Collective. Looks at the faces in their reference position. */
PetscErrorCode WetWallFind(const Model *m, const Load *load, WetWall *wall);
/* Says what is wrong with the wall; "": nothing. */
void WetWallRefuse(const Scene *scene, const Load *load, const WetWall *wall, char message[MESSAGE_LENGTH]);
/* Rank 0. Warns where westergaard gives much more than the water can press. */
void WetWallWarn(const Load *load, const WetWall *wall);
/* [-] Pressure over density, acceleration normal to a vertical wall and depth; s: place below the water over
   the depth. */
PetscReal HydrodynamicPressure(const WetWall *wall, PetscReal s);
/* [-] By how much westergaard exceeds potential flow on a straight wall that leans so much. */
PetscReal WestergaardExcess(PetscReal lean);
/* [m] Down to which depth the pressure of a coefficient that moves the wall off the water pulls more than the
   water at rest presses; 0: nowhere. */
PetscReal SuctionDepth(const WetWall *wall, PetscReal k_h);
/* Along the half of a face from its end x (2) to its middle, whose motion along its normal has come to the
   acceleration a_n [m/s2], negative away from the water: the least pressure [Pa] of the water at rest and
   in motion together and the length [m] over which it is below 0. density [kg/m3], g [m/s2]; at: (2) place
   of the least. */
PetscReal PressureOfHalf(const PetscReal x[2], const PetscReal middle[2], const WetWall *wall,
                         PetscReal density, PetscReal g, PetscReal a_n, PetscReal at[2], PetscReal *below);
/* Finds the forces on one face. push: [N/m2] density of the water times horizontal inertia k_h g, positive
   along +x. x: (4) ends of the face. f: (4) forces at the ends [N]. */
void HydrodynamicOnFace(const PetscReal x[4], const WetWall *wall, PetscReal push, PetscReal thickness,
                        PetscReal f[4]);
/* Finds the mass matrix of the water at one face, in x and y of its ends: int N_i N_j rho q dl n n', rho q
   the pressure over an acceleration along the normal n. density: [kg/m2] of the water times thickness. x: (4)
   ends of the face. k: (4,4) [kg]. */
void HydrodynamicMass(const PetscReal x[4], const WetWall *wall, PetscReal density, PetscReal k[16]);

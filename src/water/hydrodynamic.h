/* hydrodynamic.h: computes the hydrodynamic pressure over depth, of water whose bottom and wall move
   together. */
#pragma once
#include "water/water.h"

/* The wet faces of a load, as one wall. */
typedef struct {
  HydroRule rule;
  PetscReal level, depth; /* [m] elevation of the surface; depth from there to the bottom */
  PetscReal lowest;       /* [m] elevation of the lowest point of the faces */
  PetscReal lean;         /* [degree] angle from the vertical of the line from the water's edge to the
                             lowest point; negative: the wall overhangs the water */
  PetscReal normal[2]; /* [-] least and largest x of the outward normals of the wet faces; 1, -1: no face is
                        wet */
  PetscReal largest;   /* [-] pressure coefficient C_m of zangar */
} WetWall;
/* Collective. Computes the wall from the faces of a load in the reference configuration. */
PetscErrorCode WetWallFind(const Model *m, const Load *load, WetWall *wall);
/* Checks a wall. message receives what is wrong; "": nothing. */
void WetWallRefuse(const Scene *scene, const Load *load, const WetWall *wall, char message[MESSAGE_LENGTH]);
/* Rank 0. Warns if westergaard gives much more than potential flow. */
void WetWallWarn(const Load *load, const WetWall *wall);
/* Returns the pressure [-] over density, acceleration normal to a vertical wall and depth. s: distance
   below the surface over the depth. */
PetscReal HydrodynamicPressure(const WetWall *wall, PetscReal s);
/* Returns by how much [-] westergaard exceeds potential flow on a straight wall of this angle [degree]. */
PetscReal WestergaardExcess(PetscReal lean);
/* Returns the depth [m] down to which the hydrodynamic suction of a coefficient k_h exceeds the
   hydrostatic pressure; 0: nowhere. */
PetscReal SuctionDepth(const WetWall *wall, PetscReal k_h);
/* Returns the least total pressure [Pa], hydrostatic plus hydrodynamic, along the half of a face from its
   end x (2) to its middle. a_n: [m/s2] acceleration along the normal, negative away from the water.
   density [kg/m3], g [m/s2]. at: (2) receives the place of the least pressure, below the length [m] with
   negative pressure. */
PetscReal PressureOfHalf(const PetscReal x[2], const PetscReal middle[2], const WetWall *wall,
                         PetscReal density, PetscReal g, PetscReal a_n, PetscReal at[2], PetscReal *below);
/* Computes the hydrodynamic forces on one face. push: [N/m3] density of the water times horizontal inertia
   k_h g, positive along +x. x: (4) ends of the face. f: (4) receives the forces at the ends [N]. */
void HydrodynamicOnFace(const PetscReal x[4], const WetWall *wall, PetscReal push, PetscReal thickness,
                        PetscReal f[4]);
/* Computes the mass matrix of the water at one face, in x and y of its ends: int N_i N_j rho q dl n n',
   where rho q is the pressure over an acceleration along the normal n. density: [kg/m2] of the water times
   thickness. x: (4) ends of the face. k: (4,4) receives it [kg]. */
void HydrodynamicMass(const PetscReal x[4], const WetWall *wall, PetscReal density, PetscReal k[16]);

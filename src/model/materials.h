/* materials.h: declares the materials of the blocks, by group. */
#pragma once
#include "mesh/mesh.h"

/* Lame constants of the plane problem [Pa]: in plane stress lambda is reduced. */
typedef struct {
  PetscReal lambda, mu;
} Lame;

/* Owner: model.c, from the scene. While a group is absent, lifts.c sets its stiffness and density to zero. */
typedef struct {
  PetscInt n_groups;
  char (*names)[NAME_LENGTH]; /* (n_groups,) */
  PetscInt *rigid;            /* (n_groups,) whether the blocks are rigid */
  PetscBool *condensed;       /* (n_groups,) whether the bodies of the group are condensed */
  PetscBool *upgradeable; /* (n_groups,) whether its contacts are searched for again when blocks have moved */
  Lame *lame;             /* [Pa] (n_groups,) */
  PetscReal *density;     /* [kg/m3] (n_groups,) */
  PetscReal *hourglass;   /* [Pa] (n_groups,3) ElementHourglass; NULL: all are ELEMENT_FULL; create.c */
  bool *absent;           /* (n_groups,) not built yet; NULL: the scene builds nothing; lifts.c */
  PetscInt *later_joint;  /* (n_groups, n_groups) row of joints for contacts that come later, in place of
                                 default; NULL: default; joint_rows.c */
  PetscInt *joint_turn; /* (n_joints,) order of the rows of Scene.joints: where their face sets share a face,
                           the row of the lowest turn counts; joint_turns.c */
  PetscReal thickness;  /* [m] */
  StrainMeasure strain;
} Materials;

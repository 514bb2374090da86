/* material_keys.c: completes the keys of materials: strengths, laws, stress at rest. */
#include "blocks/blocks.h"
#include "scene/reader.h"
#include <math.h>

static PetscErrorCode complete_mohr_coulomb(Reader *r, const char *path, const Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "dilation", &given));
  if (given && m->dilation > m->friction)
    COMPLAIN(r, "larger than friction, %g degree: such plastic flow would create energy",
             (double)m->friction);
  PetscCall(IsGiven(r, path, "tension", &given));
  const double apex = m->cohesion / tan(m->friction * PETSC_PI / 180.);
  if (given && m->friction > 0. && m->tension > apex * (1. + 1e-12))
    COMPLAIN(r, "beyond the apex of the shear strength, cohesion / tan(friction) = %.6g Pa", apex);
  PetscCall(IsGiven(r, path, "law", &given));
  if (isnan(m->cohesion)) COMPLAIN(r, "mohr_coulomb needs cohesion [Pa] and friction [degree]");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the keys of a material law. Blocks of a law that is not elastic get one integration point, unless
   the scene chooses otherwise: blocks of four points lock. */
static PetscErrorCode complete_law(Reader *r, const char *path, Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "dilation", &given));
  if (m->dilation > 0. && m->law != MATERIAL_MOHR_COULOMB)
    COMPLAIN(r, "it is for a law that yields: law: mohr_coulomb");
  PetscCall(IsGiven(r, path, "fracture_energy", &given));
  if (given && m->law != MATERIAL_DAMAGE) COMPLAIN(r, "it is for a law that cracks: law: damage");
  PetscCall(IsGiven(r, path, "softening", &given));
  if (m->softening == SOFTENING_LINEAR && m->law != MATERIAL_DAMAGE)
    COMPLAIN(r, "it is for a law that cracks: law: damage");
  if (m->law == MATERIAL_ELASTIC) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(IsGiven(r, path, "element", &given));
  if (!given) m->element = ELEMENT_BENDING;
  if (m->law == MATERIAL_MOHR_COULOMB) PetscCall(complete_mohr_coulomb(r, path, m));
  PetscCall(IsGiven(r, path, "law", &given));
  if (m->law == MATERIAL_DAMAGE && !(m->tension > 0. && m->fracture_energy > 0.))
    COMPLAIN(r, "damage needs tension > 0 [Pa] and fracture_energy [N/m]");
  if (r->scene->plane == PLANE_STRESS) COMPLAIN(r, "in plane: stress all blocks must be elastic");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the keys of the stress at rest: the stress of the ground before anything is built. */
static PetscErrorCode complete_ground(Reader *r, const char *path, const Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "surface", &given));
  if (given && isnan(m->k0)) COMPLAIN(r, "it is for ground with k0");
  PetscCall(IsGiven(r, path, "k0", &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  if (isnan(m->surface)) COMPLAIN(r, "it needs surface [m]: the level up to which the ground stands");
  if (!(m->density > 0.)) COMPLAIN(r, "ground without density has no stress at rest");
  if (r->scene->plane == PLANE_STRESS) COMPLAIN(r, "k0 needs plane: strain");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteMaterial(Reader *r, const char *path, Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(complete_ground(r, path, m));
  PetscCall(IsGiven(r, path, "cohesion", &given));
  if (given && isnan(m->friction)) COMPLAIN(r, "the shear strength needs friction [degree] too");
  PetscCall(IsGiven(r, path, "friction", &given));
  if (given && isnan(m->cohesion)) COMPLAIN(r, "the shear strength needs cohesion [Pa] too");
  PetscCall(complete_law(r, path, m));
  PetscCall(IsGiven(r, path, "free_across", &given));
  if (m->free_across && !(m->expansion > 0.)) COMPLAIN(r, "it is for blocks that expand: expansion [1/K]");
  if (m->free_across && r->scene->plane == PLANE_STRESS)
    COMPLAIN(r, "in plane: stress blocks are free across the plane anyway");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* joint_keys.c: completes the keys of joints: friction, residual strengths, fracture energies, widths for
   water. */
#include "contacts/contacts.h"
#include "scene/reader.h"

/* Checks that a joint has both widths for water or neither, and that the largest width bounds them. */
static void complete_aperture(Reader *r, const Joint *joint)
{
  const PetscBool open = (PetscBool)!PetscIsNanReal(joint->aperture),
                  closed = (PetscBool)!PetscIsNanReal(joint->aperture_residual);
  if (open && !closed)
    COMPLAIN_MISSING(r, "aperture_residual is missing [m]: the width for water of a closed joint");
  if (!open && (closed || joint->aperture_max < PETSC_INFINITY || joint->water == LETS_IN_AFTER_FAILURE))
    COMPLAIN_MISSING(r, "aperture is missing [m]: the width for water where the normal stress is zero");
  if (joint->aperture_max < PetscMax(joint->aperture, joint->aperture_residual))
    COMPLAIN(r, "aperture_max %g is less than aperture or aperture_residual [m]",
             (double)joint->aperture_max);
}

/* Checks a fracture energy. k: 0 tension, 1 shear. The strength that is lost must need more energy than the
   springs store at that strength, or the stress of the joint would have to fall faster than they unload. */
static void check_fracture_energy(Reader *r, const Joint *joint, int k)
{
  static const char *const energies[] = {"fracture_energy", "fracture_energy_shear"},
                           *const strengths[] = {"tension", "cohesion"}, *const springs[] = {"k_n", "k_s"};
  const PetscReal *strength = k ? joint->cohesion : joint->tension, G = joint->fracture_energy[k],
                  lost = strength[0] - strength[1],
                  stored = lost * lost / (2. * (k ? joint->k_s : joint->k_n));
  if (!(G > 0.)) return;
  if (joint->stress_model != STRESS_PT)
    COMPLAIN(r, "%s needs stress_model: pt, where each end of a contact softens by itself", energies[k]);
  if (!(lost > 0.))
    COMPLAIN(r, "%s needs %s above %s_residual; %s: 0 is none", energies[k], strengths[k], strengths[k],
             energies[k]);
  if (lost > 0. && !(G > stored))
    COMPLAIN(r,
             "%s %g N/m is not above (%s - %s_residual)^2 / (2 %s) = %g N/m, what the joint stores at its "
             "strength, so it cannot soften: give more, raise %s, or leave it out",
             energies[k], (double)G, strengths[k], strengths[k], springs[k], (double)stored, springs[k]);
}

PetscErrorCode CompleteJoint(Reader *r, Joint *joint)
{
  const PetscBool limited = (PetscBool)(joint->law == LAW_MOHR_COULOMB);

  PetscFunctionBeginUser;
  if (limited && PetscIsNanReal(joint->friction[0]))
    COMPLAIN_MISSING(r, "friction is missing [degree] (or law: elastic)");
  if (PetscIsNanReal(joint->friction[0])) joint->friction[0] = 0;
  complete_aperture(r, joint);
  if (PetscIsNanReal(joint->friction[1])) joint->friction[1] = joint->friction[0];
  if (!limited) PetscFunctionReturn(PETSC_SUCCESS);
  if (joint->friction[1] > joint->friction[0]) COMPLAIN(r, "friction_residual is larger than friction");
  if (joint->cohesion[1] > joint->cohesion[0]) COMPLAIN(r, "cohesion_residual is larger than cohesion");
  if (joint->tension[1] > joint->tension[0]) COMPLAIN(r, "tension_residual is larger than tension");
  if (JointSoftens(joint) && joint->tension[1] > 0.)
    COMPLAIN(r, "tension_residual %g Pa: a joint with a fracture energy needs 0", (double)joint->tension[1]);
  for (int k = 0; k < 2; k++) check_fracture_energy(r, joint, k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

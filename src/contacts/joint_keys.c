/* joint_keys.c: completes the keys of joints: friction, residual strengths, widths for water. */
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

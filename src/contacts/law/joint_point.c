/* joint_point.c: evaluates the strength of a joint in scalars: at one point by the law of joint_law.h, and of
   a whole joint. */
#include "contacts/law/law.h"
#include "contacts/law/softening.h"
#include <float.h>

PetscReal JointLimitAt(const Joint *joint, PetscReal broken, PetscReal far, PetscReal sigma)
{
  const PetscInt same[LANES] = {0};
  const Lanes of_ends[2] = {LanesOf(broken), LanesOf(far)};
  LanesJoint J;
  LoadJoints(joint, same, 0., &J);
  const LanesStrength strength = StrengthOf(&J, EndIsResidual(of_ends, 0));
  const Lanes stress = LanesOf(sigma);
  if (joint->law == LAW_ELASTIC) return PETSC_INFINITY;
  if (!J.softens) return JointShearLimit(&J, &strength, stress)[0];
  const Lanes kappa = Softened(of_ends, 0);
  return Keep(~SoftenedIsOpen(&J, stress, kappa), SoftenedLimit(&J, stress, kappa))[0];
}

PetscReal JointResultantStrength(const Joint *joint, int residual, PetscReal N, PetscReal area)
{
  return joint->law == LAW_ELASTIC
             ? PETSC_INFINITY
             : PetscMax(0., N) * joint->tan_phi[residual] + joint->cohesion[residual] * area;
}

PetscReal JointApex(const Joint *joint, int residual)
{
  return joint->tan_phi[residual] > 0. ? joint->cohesion[residual] / joint->tan_phi[residual]
                                       : PETSC_INFINITY;
}

PetscBool JointBreaks(const Joint *joint)
{
  return (PetscBool)(joint->law == LAW_MOHR_COULOMB &&
                     (joint->tension[0] > joint->tension[1] || joint->cohesion[0] > joint->cohesion[1] ||
                      joint->tan_phi[0] > joint->tan_phi[1]));
}

PetscBool JointSoftens(const Joint *joint)
{
  return (PetscBool)(joint->law == LAW_MOHR_COULOMB &&
                     (joint->fracture_energy[0] > 0. || joint->fracture_energy[1] > 0.));
}

PetscReal JointSteepPressure(const Joint *joint)
{
  const PetscReal cohesion = joint->cohesion[0] - joint->cohesion[1],
                  friction = joint->tan_phi[0] - joint->tan_phi[1], G = joint->fracture_energy[1],
                  springs = G > 0. && cohesion > 0. ? joint->k_s * 2. * G / cohesion : 0.;
  if (!(cohesion > 0. || friction > 0.)) return PETSC_INFINITY;
  if (!(springs > cohesion)) return 0.;
  return friction > 0. ? (springs - cohesion) / friction : PETSC_INFINITY;
}

PetscBool JointHoldsTogether(const Joint *joint)
{
  return (PetscBool)(joint->law == LAW_ELASTIC || joint->tension[1] > 0.);
}

PetscBool JointIsWeaker(const Joint *a, const Joint *b)
{
  if ((a->law == LAW_ELASTIC) != (b->law == LAW_ELASTIC)) return (PetscBool)(b->law == LAW_ELASTIC);
  if (a->tan_phi[0] != b->tan_phi[0]) return (PetscBool)(a->tan_phi[0] < b->tan_phi[0]);
  if (a->cohesion[0] != b->cohesion[0]) return (PetscBool)(a->cohesion[0] < b->cohesion[0]);
  return (PetscBool)(a->tension[0] < b->tension[0]);
}

void JointCapFriction(Joint *joint, PetscReal degrees)
{
  for (int i = 0; i < 2; i++)
    joint->tan_phi[i] = PetscMin(joint->tan_phi[i], tan(degrees * (PETSC_PI / 180)));
}

void JointScale(Joint *joint, PetscReal factor)
{
  for (int i = 0; i < 2; i++)
    joint->tan_phi[i] *= factor, joint->cohesion[i] *= factor, joint->tension[i] *= factor;
  if (joint->compression < PETSC_INFINITY) // else there is no limit to scale
    joint->compression = PetscMax(joint->compression * factor, DBL_MIN);
}

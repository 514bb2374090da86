/* joint_law.h: the law of a joint at ONE point (section 2.5 of the paper): elastic, or Mohr-Coulomb with
   cut-offs in tension and compression, with peak and residual strength. stress_models.c integrates it over a
   contact.

   Trial stresses (5)-(6) from TOTAL opening and slip:  sigma = k_n u_n,  tau = k_s (u_s - slip).  The paper
   writes them in increments of stress; then a joint that has been cut off in tension forgets its gap and
   carries compression before it closes. So u_n is total, and the plastic part of u_s is the only history of
   shear.

   strength 0 (peak): until the place fails; strength 1 (residual): ever after. With t = tan_phi, C =
   compression: fails   when sigma_trial > tension[0] or |tau_trial| > limit with peak strength open    when
   sigma_trial > tension[strength]: sigma = tension[strength], tau = 0 else    sigma = max(sigma_trial, -C),
   |tau| <= limit = max(0, cohesion[strength] - sigma t[strength])

   A NaN passes through all of this (comparisons, not fmin), so that divergence is seen. */
#pragma once
#include <math.h>
#include "types.h"

/* Call after any change of friction: once when the scene is read and for every stage that changes a joint. */
static inline void JointPrepare(Joint *joint)
{
  for (int i = 0; i < 2; i++) joint->tan_phi[i] = tan(joint->friction[i] * (PETSC_PI / 180));
}

/* (5): the fast path in contact_force.c must use these very expressions, or lanes lose their bits */
static inline PetscReal JointNormalTrial(const Joint *joint, PetscReal u_n)
{
  return joint->k_n * u_n;
}

/* (6) */
static inline PetscReal JointShearTrial(const Joint *joint, PetscReal u_s, PetscReal slip)
{
  return joint->k_s * (u_s - slip);
}

/* Whether failing changes anything; if not, `broken` stays 0 and contacts return to the fast path after
 * slipping. */
static inline PetscBool JointIsBrittle(const Joint *joint)
{
  return (PetscBool)(joint->cohesion[0] != joint->cohesion[1] || joint->tan_phi[0] != joint->tan_phi[1] ||
                     joint->tension[0] != joint->tension[1]);
}

static inline PetscReal JointClip(PetscReal value, PetscReal limit)
{
  return value > limit ? limit : value < -limit ? -limit : value;
}

static inline PetscBool JointIsOpen(const Joint *joint, int strength, PetscReal sigma_trial)
{
  return (PetscBool)(sigma_trial > joint->tension[strength]);
}

static inline PetscBool JointIsCrushing(const Joint *joint, PetscReal sigma_trial)
{
  return (PetscBool)(sigma_trial < -joint->compression);
}

static inline PetscReal JointNormal(const Joint *joint, int strength, PetscReal sigma_trial)
{
  if (JointIsOpen(joint, strength, sigma_trial)) return joint->tension[strength];
  return JointIsCrushing(joint, sigma_trial) ? -joint->compression : sigma_trial;
}

/* c - sigma tan(phi) for a stress already cut off; negative beyond the apex of the cone */
static inline PetscReal JointCone(const Joint *joint, int strength, PetscReal sigma)
{
  return joint->cohesion[strength] - sigma * joint->tan_phi[strength];
}

static inline PetscReal JointShearLimit(const Joint *joint, int strength, PetscReal sigma_trial)
{
  PetscReal cone;

  if (JointIsOpen(joint, strength, sigma_trial)) return 0;
  cone = JointCone(joint, strength, JointNormal(joint, strength, sigma_trial));
  return cone < 0 ? 0 : cone;
}

/* Whether an unbroken place breaks. */
static inline PetscBool JointFails(const Joint *joint, PetscReal sigma_trial, PetscReal tau_trial)
{
  return (PetscBool)(JointIsOpen(joint, 0, sigma_trial) ||
                     fabs(tau_trial) > JointShearLimit(joint, 0, sigma_trial));
}

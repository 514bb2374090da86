/* joint_law.h: evaluates the law of a joint at ONE point (section 2.5 of the paper), for LANES contacts at
   once: elastic, or Mohr-Coulomb with cut-offs in tension and compression, with peak and residual strength.
   stress_models.h integrates it over a contact.

   Trial stresses (5)-(6) come from TOTAL opening and slip:  sigma = k_n (u_n - closure),
   tau = k_s (u_s - slip).  The paper writes them in increments of stress; then a joint that has been cut off
   in tension forgets its gap and carries compression before it closes. So u_n is total. The history is the
   plastic part of u_s, `slip`, and the plastic part of u_n, `closure` <= 0, which only a joint of finite
   compression has (ends.h).

   Strength is the peak strength until the place fails and the residual strength ever after. With t = tan_phi,
   C = compression:
     fails   when sigma_trial > peak tension or |tau_trial| > limit with peak strength
     open    when sigma_trial > tension: sigma = tension, tau = 0
     else    sigma = max(sigma_trial, -C),  |tau| <= limit = max(0, cohesion - sigma t)

   A NaN passes through all functions here, because they compare and do not call fmin; so divergence is
   seen. */
#pragma once
#include <math.h>
#include "contacts/law/law.h"
#include "base/lanes.h"

typedef struct {
  Lanes tension, cohesion, tan_phi;
} LanesStrength;

typedef struct {
  Lanes k_n, k_s, compression, damping;
  LanesStrength peak, residual;
  Mask elastic;           /* the joint has no limits at all */
  int crushes;            /* the compression of some lane is finite, or softens: both take the same way */
  int damps;              /* some lane has a dashpot */
  Mask brittle;           /* failure changes the strength; if not, `broken` stays 0 and contacts can return to
                   elastic */
  int softens;            /* some lane loses a strength along a slope; only then the next three are set */
  Mask soft;              /* which lanes do */
  Lanes opening, sliding; /* [m] plastic opening and slip that take all of the strength; 0: at once */
} LanesJoint;

/* The number that stands for no limit, because infinity would make NaN of a difference or a product. */
#define NO_LIMIT 1e300

/* Loads what softening needs. more: margin of tension [0] and of shear [1]; what softens needs none. */
KERNEL void LoadSoftening(const Joint *joints, const PetscInt *joint, LanesJoint *J, Lanes more[2])
{
  for (int lane = 0; lane < LANES; lane++) {
    const PetscReal *G = joints[joint[lane]].fracture_energy;
    const PetscReal tension = J->peak.tension[lane] - J->residual.tension[lane],
                    cohesion = J->peak.cohesion[lane] - J->residual.cohesion[lane];
    J->opening[lane] = G[0] > 0. && tension > 0. ? 2. * G[0] / tension : 0.;
    J->sliding[lane] = G[1] > 0. && cohesion > 0. ? 2. * G[1] / cohesion : 0.;
  }
  J->soft = ~J->elastic & ((J->opening > 0.) | (J->sliding > 0.));
  J->softens = Any(J->soft);
  J->crushes |= J->softens;
  more[0] = Keep(~(J->soft & (J->opening > 0.)), more[0]);
  more[1] = Keep(~(J->soft & (J->sliding > 0.)), more[1]);
}

/* Loads the joints of LANES contacts. joint: rows of the joints table, mostly the same row. margin: [Pa]
   added to the peak strength of a joint that can break, in tension and at every normal stress in shear
   (Contacts.margin). */
KERNEL void LoadJoints(const Joint *joints, const PetscInt *joint, PetscReal margin, LanesJoint *J)
{
  for (int lane = 0; lane < LANES; lane++) {
    const Joint *j = joints + joint[lane];
    J->k_n[lane] = j->k_n, J->k_s[lane] = j->k_s;
    J->compression[lane] = PetscMin(j->compression, NO_LIMIT);
    J->damping[lane] = j->damping;
    J->peak.tension[lane] = PetscMin(j->tension[0], NO_LIMIT), J->peak.cohesion[lane] = j->cohesion[0];
    J->residual.tension[lane] = PetscMin(j->tension[1], NO_LIMIT),
    J->residual.cohesion[lane] = j->cohesion[1];
    J->peak.tan_phi[lane] = j->tan_phi[0], J->residual.tan_phi[lane] = j->tan_phi[1];
    J->elastic[lane] = -(long long)(j->law == LAW_ELASTIC);
  }
  J->damps = Any(J->damping > 0.);
  J->crushes = Any(J->compression < NO_LIMIT);
  J->brittle = (J->peak.cohesion != J->residual.cohesion) | (J->peak.tan_phi != J->residual.tan_phi) |
               (J->peak.tension != J->residual.tension);
  Lanes more[2] = {Keep(J->brittle, LanesOf(margin)), Keep(J->brittle, LanesOf(margin))};
  J->softens = 0;
  if (Any(J->brittle)) LoadSoftening(joints, joint, J, more);
  J->peak.tension += more[0], J->peak.cohesion += more[1] + more[1] * J->peak.tan_phi;
}

static const PetscReal LOOSE_TAN = 1e6; /* a tan_phi so large that a pressed joint has no limit */

/* Returns the strength of loose contacts (law.h: LOOSE) in the lanes of the mask, `whole` in the others. */
KERNEL LanesStrength LooseStrength(const LanesJoint *J, Mask loose, const LanesStrength *whole)
{
  const Lanes cohesion = Keep(~J->elastic, J->residual.cohesion),
              tan_phi = Select(J->elastic, LanesOf(LOOSE_TAN), J->residual.tan_phi);
  return (LanesStrength){Keep(~loose, whole->tension), Select(loose, cohesion, whole->cohesion),
                         Select(loose, tan_phi, whole->tan_phi)};
}

/* Returns the joint J with the strengths of loose contacts in the lanes of the mask. */
KERNEL LanesJoint LooseJoint(const LanesJoint *J, Mask loose)
{
  LanesJoint now = *J;
  now.peak = LooseStrength(J, loose, &J->peak);
  now.residual = LooseStrength(J, loose, &J->residual);
  now.compression = Select(loose & J->elastic, LanesOf(NO_LIMIT), J->compression);
  now.elastic &= ~loose;
  now.brittle &= ~loose;
  if (J->softens) now.soft &= ~loose;
  return now;
}

KERNEL LanesStrength StrengthOf(const LanesJoint *J, Mask residual)
{
  return (LanesStrength){Select(residual, J->residual.tension, J->peak.tension),
                         Select(residual, J->residual.cohesion, J->peak.cohesion),
                         Select(residual, J->residual.tan_phi, J->peak.tan_phi)};
}

KERNEL Lanes JointClip(Lanes value, Lanes limit)
{
  return Select(value > limit, limit, Select(value < -limit, -limit, value));
}

KERNEL Mask JointIsOpen(const LanesStrength *strength, Lanes sigma)
{
  return sigma > strength->tension;
}

KERNEL Mask JointIsCrushing(const LanesJoint *J, Lanes sigma)
{
  return sigma < -J->compression;
}

KERNEL Lanes JointNormal(const LanesJoint *J, const LanesStrength *strength, Lanes sigma)
{
  return Select(JointIsOpen(strength, sigma), strength->tension,
                Select(JointIsCrushing(J, sigma), -J->compression, sigma));
}

/* Returns c - sigma tan(phi), for a stress already cut off. It is negative beyond the apex of the cone. */
KERNEL Lanes JointCone(const LanesStrength *strength, Lanes sigma)
{
  return strength->cohesion - sigma * strength->tan_phi;
}

KERNEL Lanes JointShearLimit(const LanesJoint *J, const LanesStrength *strength, Lanes sigma)
{
  return Keep(~JointIsOpen(strength, sigma),
              NotNegative(JointCone(strength, JointNormal(J, strength, sigma))));
}

/* Decides whether a place that has not failed fails. */
KERNEL Mask JointFails(const LanesJoint *J, Lanes sigma, Lanes tau)
{
  return JointIsOpen(&J->peak, sigma) | (Absolute(tau) > JointShearLimit(J, &J->peak, sigma));
}

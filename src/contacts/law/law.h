/* law.h: stress models and joint laws of one contact, arithmetic only. The kernels that the loop over
   contacts runs, for LANES contacts at once, are in stress_models.h. */
#pragma once
#include "scene/scene.h"

typedef enum {
  CONTACT_ELASTIC = 0,
  CONTACT_OPEN = 1,
  CONTACT_SLIPPING = 2,
  CONTACT_CRUSHING = 4
} ContactState; /* bits, per sub-contact */

/* Whether a joint loses strength where it fails. */
static inline PetscBool JointBreaks(const Joint *j)
{
  return (PetscBool)(j->law == LAW_MOHR_COULOMB &&
                     (j->tension[0] > j->tension[1] || j->cohesion[0] > j->cohesion[1] ||
                      j->friction[0] > j->friction[1]));
}

/* ---- stress_models.c */
/* The value of `broken` that marks a loose contact: one that has met in motion, in a joint that is elastic or
   has a residual tension. A loose contact carries no tension. In shear it has no limit where it is pressed if
   the joint is elastic; otherwise it has the residual strength. */
static const PetscReal LOOSE = 2.;

/* Response of one contact, with the bits that force.c finds for a batch; see stress_models.h. */
typedef struct {
  PetscReal u_n[2], u_s[2];             /* in: [m] at the two ends, openings already reduced by `rest` */
  PetscReal slip[2], broken[2];         /* in: history at the start of the step; out: at its end */
  PetscReal closure[2], closure_far[2]; /* in and out: history of a joint of finite compression */
  PetscReal margin;                     /* in: [Pa] of a joint that can break, see Contacts.margin */
  PetscBool in_time;          /* in: partial slip may make no energy: dynamic stages, and Contacts.springs */
  PetscReal speed[2];         /* in: [m/s] of opening, for dashpots of a dynamic stage */
  PetscReal sigma[2], tau[2]; /* out: [Pa] at the ends */
  PetscReal F_n[2], F_s[2];   /* out: [N/m] end forces per metre of thickness, same sign as sigma, tau */
  PetscInt state[2];          /* out: ContactState bits */
} ContactPoint;
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p);
/* The same of n points of the contact, up to MOST_POINTS, that differ in u_n and u_s alone; it takes as
   long as one. */
enum { MOST_POINTS = 4 };
void StressModelRespondAll(StressModelKind model, const Joint *joint, PetscReal length, int n,
                           ContactPoint *p);
/* [m] Plastic part of u_n at end k. */
PetscReal StressModelClosure(const ContactPoint *p, int k);
/* For tptm: the fractions of the length that are open, where the trial stress is above the tensile
   strength, and where it crushes the joint. */
void StressModelParts(const Joint *joint, const ContactPoint *p, PetscReal *open, PetscReal *crushing);
/* [J/m] For tptm: the energy of the normal springs, sigma^2/(2 k_n) over the length. */
PetscReal StressModelStored(const Joint *joint, PetscReal length, const ContactPoint *p);
/* Whether the law holds elastically at both ends and nothing is broken or crushed, for the trial stresses
   sigma, tau. margin: see Contacts. */
PetscBool JointIsElastic(const Joint *joint, PetscReal margin, const PetscReal sigma[2],
                         const PetscReal tau[2], const PetscReal broken[2], const PetscReal closure[2]);

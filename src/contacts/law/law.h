/* law.h: declares the stress models and joint laws of one contact, arithmetic only. The kernels for LANES
   contacts, which the force loop runs, are in stress_models.h. */
#pragma once
#include "scene/scene.h"

typedef enum {
  CONTACT_ELASTIC = 0,
  CONTACT_OPEN = 1,
  CONTACT_SLIPPING = 2,
  CONTACT_CRUSHING = 4
} ContactState; /* bits, per sub-contact */

/* Decides whether a joint loses strength where it fails. */
static inline PetscBool JointBreaks(const Joint *j)
{
  return (PetscBool)(j->law == LAW_MOHR_COULOMB &&
                     (j->tension[0] > j->tension[1] || j->cohesion[0] > j->cohesion[1] ||
                      j->friction[0] > j->friction[1]));
}

/* ---- stress_models.c */
/* The value of `broken` that marks a loose contact: one made by an impact, in a joint that is elastic or has
   a residual tension. A loose contact carries no tension. Where it is pressed it has no limit in shear if the
   joint is elastic, and the residual strength otherwise. */
static const PetscReal LOOSE = 2.;

/* State of one contact and its response, which has the bits that force.c finds for a batch; see
   stress_models.h. */
typedef struct {
  PetscReal u_n[2], u_s[2];             /* in: [m] at the two ends, openings already reduced by `rest` */
  PetscReal slip[2], broken[2];         /* in: history at the start of the step; out: at its end */
  PetscReal closure[2], closure_far[2]; /* in and out: history of a joint of finite compression */
  PetscReal margin;                     /* in: [Pa] margin of a joint that can break, see Contacts.margin */
  PetscBool in_time;                    /* in: partial slip must not make energy: dynamic stages, and
                                 FRICTION_SPRINGS */
  PetscReal speed[2];                   /* in: [m/s] of opening, for dashpots of a dynamic stage */
  PetscReal sigma[2], tau[2];           /* out: [Pa] at the ends */
  PetscReal F_n[2], F_s[2]; /* out: [N/m] end forces per metre of thickness, same sign as sigma, tau */
  PetscInt state[2];        /* out: ContactState bits */
} ContactPoint;
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p);
/* As StressModelRespond, for n points of the contact, up to MOST_POINTS, that differ in u_n and u_s alone. It
   takes as long as one point. */
enum { MOST_POINTS = 4 };
void StressModelRespondAll(StressModelKind model, const Joint *joint, PetscReal length, int n,
                           ContactPoint *p);
/* Returns the plastic part [m] of u_n at end k. */
PetscReal StressModelClosure(const ContactPoint *p, int k);
/* Computes for tptm the fractions of the length that are open, where the trial stress is above the tensile
   strength, and crushing. */
void StressModelParts(const Joint *joint, const ContactPoint *p, PetscReal *open, PetscReal *crushing);
/* Computes for tptm the energy [J/m] of the normal springs, sigma^2/(2 k_n) over the length. */
PetscReal StressModelStored(const Joint *joint, PetscReal length, const ContactPoint *p);
/* Decides whether the law holds elastically at both ends and nothing is broken or crushed, for the trial
   stresses sigma, tau. margin: see Contacts. */
PetscBool JointIsElastic(const Joint *joint, PetscReal margin, const PetscReal sigma[2],
                         const PetscReal tau[2], const PetscReal broken[2], const PetscReal closure[2]);

/* law.h: stress models and joint laws of one contact: arithmetic only. The lanes that the loop runs are in
   stress_models.h. */
#pragma once
#include "scene/scene.h"

typedef enum {
  CONTACT_ELASTIC = 0,
  CONTACT_OPEN = 1,
  CONTACT_SLIPPING = 2,
  CONTACT_CRUSHING = 4
} ContactState; /* bits, per sub-contact */

/* ---- stress_models.c */
/* `broken` of a contact that has met in motion in a joint that holds together, elastic or with a residual
   tension: it carries none. In shear an elastic joint has no limit where it is pressed; others have their
   residual strength. */
static const PetscReal LOOSE = 2.;

/* Response of one contact, as force.c has it of a batch; see stress_models.h. */
typedef struct {
  PetscReal u_n[2], u_s[2];             /* in: [m] at the two ends, openings already reduced by `rest` */
  PetscReal slip[2], broken[2];         /* in: history at the start of the step; out: at its end */
  PetscReal closure[2], closure_far[2]; /* the same of a joint of finite compression */
  PetscBool in_time;                    /* in: of a dynamic stage, where partial slip may make no energy */
  PetscReal speed[2];                   /* in: [m/s] of opening, for dashpots of a dynamic stage */
  PetscReal sigma[2], tau[2];           /* out: [Pa] at the ends */
  PetscReal F_n[2], F_s[2]; /* out: [N/m] end forces per metre of thickness, same sign as sigma, tau */
  PetscInt state[2];        /* out: ContactState bits */
} ContactPoint;
void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p);
/* [m] Plastic part of u_n at end k. */
PetscReal StressModelClosure(const ContactPoint *p, int k);
/* Of tptm: the parts of the length where the trial stress opens the joint and where it crushes it. */
void StressModelParts(const Joint *joint, const ContactPoint *p, PetscReal *open, PetscReal *crushing);
/* [J/m] Of tptm: what its normal springs store, sigma^2/(2 k_n) over the length. */
PetscReal StressModelStored(const Joint *joint, PetscReal length, const ContactPoint *p);
/* Whether the law holds elastically at both ends and nothing is broken or crushed, for the trial stresses
   sigma, tau. */
PetscBool JointIsElastic(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2],
                         const PetscReal broken[2], const PetscReal closure[2]);

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

/* ---- joint_point.c: the strength of a joint. residual: 0 before, 1 after the joint has failed there. */
/* Decides whether a joint loses strength where it fails. */
PetscBool JointBreaks(const Joint *joint);
/* Decides whether a joint loses a strength along a slope, by a fracture energy (softening.h). */
PetscBool JointSoftens(const Joint *joint);
/* Returns the pressure [Pa] from which a joint that softens loses its shear strength at once, because falling
   friction makes the slope as steep as its springs; PETSC_INFINITY: none. */
PetscReal JointSteepPressure(const Joint *joint);
/* Decides whether a joint has a tension that no failure takes away; a contact made by an impact must not have
   it. */
PetscBool JointHoldsTogether(const Joint *joint);
/* Decides whether joint a is weaker than joint b. Friction decides, then cohesion, then tension; an elastic
   joint is stronger than any other. */
PetscBool JointIsWeaker(const Joint *a, const Joint *b);
/* Returns the largest |tau| [Pa] at an end of a contact that is not loose, for its normal stress sigma;
   PETSC_INFINITY: the joint is elastic. broken, far: failed fractions from this end and from the other
   one. */
PetscReal JointLimitAt(const Joint *joint, PetscReal broken, PetscReal far, PetscReal sigma);
/* Returns the shear force [N] that a joint bears with the normal force N [N, compression positive] and the
   closed area [m2]; PETSC_INFINITY: the joint is elastic. */
PetscReal JointResultantStrength(const Joint *joint, int residual, PetscReal N, PetscReal area);
/* Returns the tension [Pa] at which the shear strength ends, PETSC_INFINITY without friction. */
PetscReal JointApex(const Joint *joint, int residual);
/* Lowers friction to at most this angle. */
void JointCapFriction(Joint *joint, PetscReal degrees);
/* Multiplies friction (its tangent), cohesion, tensile and compressive strength. Fracture energies stay. */
void JointScale(Joint *joint, PetscReal factor);

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

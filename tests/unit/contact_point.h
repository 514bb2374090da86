/* contact_point.h: what test_joint_law.c and test_stress_models.c share. */
#pragma once
#include "check.h"
#include "motion/motion.h"
#include "contacts/law/joint_law.h"

/* a joint with equal peak and residual strength; friction in degrees */
static inline Joint MakeJoint(double k_n, double k_s, double friction, double cohesion, double tension)
{
  Joint joint = {.law = LAW_MOHR_COULOMB, .k_n = k_n, .k_s = k_s, .compression = PETSC_INFINITY};

  for (int i = 0; i < 2; i++) {
    joint.friction[i] = friction;
    joint.cohesion[i] = cohesion;
    joint.tension[i] = tension;
  }
  JointPrepare(&joint);
  return joint;
}

/* normal force (and shear force) of the whole contact */
static inline double SumN(const ContactPoint *p)
{
  return p->F_n[0] + p->F_n[1];
}

static inline double SumS(const ContactPoint *p)
{
  return p->F_s[0] + p->F_s[1];
}

/* uniform numbers in [a,b], the same on every machine */
static inline double Random(double a, double b)
{
  static uint64_t state = 88172645463325252u;

  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* a joint of order 1 in everything: brittle or not, crushing or not */
static inline Joint RandomJoint(void)
{
  Joint joint = MakeJoint(Random(0.5, 2), Random(0.3, 2), Random(0, 50), 0, 0);
  double kind = Random(0, 3);

  if (kind > 1) joint.cohesion[0] = joint.cohesion[1] = Random(0, 0.5);
  if (kind > 1) joint.tension[0] = joint.tension[1] = Random(0, 0.4);
  if (kind > 2) {
    joint.friction[1] = joint.friction[0] * Random(0.5, 1);
    joint.cohesion[1] *= Random(0, 1) < 0.5 ? 0 : Random(0, 1);
    joint.tension[1] *= Random(0, 1) < 0.5 ? 0 : Random(0, 1);
  }
  if (Random(0, 1) < 0.3) joint.compression = Random(0.5, 2);
  JointPrepare(&joint);
  return joint;
}

/* some state; history: broken parts and slips from before */
static inline ContactPoint RandomPoint(PetscBool history)
{
  ContactPoint p = {.u_n = {0, 0}};

  for (int k = 0; k < 2; k++) {
    p.u_n[k] = Random(-2, 0.8);
    p.u_s[k] = Random(-1.5, 1.5);
    if (history) p.slip[k] = Random(-1, 1);
    if (history && Random(0, 1) < 0.5) p.broken[k] = Random(0, 0.5);
  }
  return p;
}

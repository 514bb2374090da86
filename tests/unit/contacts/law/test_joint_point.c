/* test_joint_point.c: the strength of a joint in scalars: the limit at a point, of a resultant, what a trial
   lowers, and the order of strength. */
#include "contact_point.h"

static const double kPa = 1e3;

/* c = 100 kPa, phi = 45, tension 50 kPa, compression 2 MPa; residual 0, phi = 30, 0 */
static Joint Brittle(void)
{
  Joint joint = MakeJoint(1e9, 1e9, 45, 100 * kPa, 50 * kPa);
  joint.cohesion[1] = joint.tension[1] = 0, joint.friction[1] = 30, joint.compression = 2e6;
  JointPrepare(&joint);
  return joint;
}

static void TestLimit(void)
{
  Joint joint = Brittle(), elastic = {.law = LAW_ELASTIC};
  ENSURE_NEAR(JointLimitAt(&joint, 0, 0, -200 * kPa), 300 * kPa, 1e-6);
  ENSURE_NEAR(JointLimitAt(&joint, 0.1, 0, -300 * kPa), 300 * kPa / sqrt(3), 1e-6);
  ENSURE_NEAR(JointLimitAt(&joint, 0, 0.9, -200 * kPa), 300 * kPa, 1e-6); /* this end has not failed */
  ENSURE_NEAR(JointLimitAt(&joint, 0, 1, -300 * kPa), 300 * kPa / sqrt(3), 1e-6);
  ENSURE_NEAR(JointLimitAt(&joint, 0, 0, 40 * kPa), 60 * kPa, 1e-6);
  ENSURE(JointLimitAt(&joint, 0, 0, 51 * kPa) == 0);               /* it is open */
  ENSURE_NEAR(JointLimitAt(&joint, 0, 0, -3e6), 2100 * kPa, 1e-3); /* it is crushed at 2 MPa */
  ENSURE(JointLimitAt(&elastic, 0, 0, 1e9) == PETSC_INFINITY);
}

/* The resultant of an even stress has the strength of its points; a pulled joint keeps cohesion alone. */
static void TestResultant(void)
{
  Joint joint = Brittle();
  ENSURE_NEAR(JointResultantStrength(&joint, 0, 3 * 200 * kPa, 3), 3 * JointLimitAt(&joint, 0, 0, -200 * kPa),
              1e-6);
  ENSURE_NEAR(JointResultantStrength(&joint, 1, 900 * kPa, 3), 900 * kPa / sqrt(3), 1e-6);
  ENSURE_NEAR(JointResultantStrength(&joint, 0, -1e6, 2), 200 * kPa, 1e-9);
  ENSURE_NEAR(JointApex(&joint, 0), 100 * kPa, 1e-6);
  ENSURE(JointApex(&joint, 1) == 0);
  joint.tan_phi[0] = 0;
  ENSURE(JointApex(&joint, 0) == PETSC_INFINITY);
}

/* A factor divides every strength: the limit at a point goes with it, in shear, tension and compression. */
static void TestTrials(void)
{
  const Joint whole = Brittle();
  Joint half = whole, capped = whole;
  JointScale(&half, 0.5);
  ENSURE(half.tan_phi[0] == 0.5 * whole.tan_phi[0] && half.tension[0] == 25 * kPa && half.compression == 1e6);
  ENSURE_NEAR(JointLimitAt(&half, 0, 0, -200 * kPa), 150 * kPa, 1e-6);
  ENSURE_NEAR(JointLimitAt(&half, 1, 0, -300 * kPa), 150 * kPa / sqrt(3), 1e-6);
  ENSURE(JointBreaks(&whole) && JointBreaks(&half));

  JointCapFriction(&capped, 40);
  ENSURE_NEAR(capped.tan_phi[0], tan(40 * PETSC_PI / 180), 1e-15);
  ENSURE(capped.tan_phi[1] == whole.tan_phi[1] && capped.cohesion[0] == whole.cohesion[0]);
  capped = MakeJoint(1e9, 1e9, 45, 0, 0), capped.friction[1] = 35, JointPrepare(&capped);
  ENSURE(JointBreaks(&capped));
  JointCapFriction(&capped, 30); /* peak and residual friction are one now: it no longer breaks */
  ENSURE(!JointBreaks(&capped) && capped.tan_phi[0] == capped.tan_phi[1]);
}

static void TestOrder(void)
{
  const Joint a = MakeJoint(1, 1, 40, 0, 0), more_phi = MakeJoint(1, 1, 41, 0, 0),
              more_c = MakeJoint(1, 1, 40, 1, 0), more_t = MakeJoint(1, 1, 40, 0, 1),
              elastic = {.law = LAW_ELASTIC};
  ENSURE(JointIsWeaker(&a, &more_phi) && JointIsWeaker(&a, &more_c) && JointIsWeaker(&a, &more_t));
  ENSURE(JointIsWeaker(&more_c, &more_phi) && JointIsWeaker(&more_t, &more_c));
  ENSURE(JointIsWeaker(&a, &elastic) && !JointIsWeaker(&elastic, &a) && !JointIsWeaker(&a, &a));
  ENSURE(JointHoldsTogether(&more_t) && JointHoldsTogether(&elastic) && !JointHoldsTogether(&a));
}

int main(int argc, char **argv)
{
  (void)argc, (void)argv;
  RUN_TEST(TestLimit);
  RUN_TEST(TestResultant);
  RUN_TEST(TestTrials);
  RUN_TEST(TestOrder);
  return CheckSummary();
}

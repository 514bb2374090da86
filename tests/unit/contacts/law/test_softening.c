/* test_softening.c: joints that lose strength along a slope: stresses along a way of opening and slip, what
   both take of one strength, the work they take, and joints beside them that do not soften. */
#include "contact_point.h"

/* c = 2, c_r = 0.5, f_t = 1, tan(phi) = 1; G_I = 1 and G_II = 1.5: w_u = 2 with a slope of k_n/4, s_u = 2
   with a slope of k_s/3 */
static Joint Soft(void)
{
  Joint joint = MakeJoint(2.5, 3, 45, 2, 1);
  joint.tension[1] = 0, joint.cohesion[1] = 0.5, joint.stress_model = STRESS_PT;
  joint.fracture_energy[0] = 1, joint.fracture_energy[1] = 1.5;
  return joint;
}

/* Moves both ends of a contact of length 2, so that forces are stresses. */
static void Move(const Joint *joint, double u_n, double u_s, ContactPoint *p)
{
  for (int k = 0; k < 2; k++) p->u_n[k] = u_n, p->u_s[k] = u_s;
  StressModelRespond(STRESS_PT, joint, 2, p);
  for (int k = 0; k < 2; k++) {
    ENSURE_NEAR(p->F_n[k], p->sigma[k], 1e-14);
    ENSURE_NEAR(p->F_s[k], p->tau[k], 1e-14);
  }
}

static void TestOpening(void)
{
  Joint joint = Soft();
  ContactPoint p = {.margin = 1e-3};
  Move(&joint, 0.4, 0, &p);
  ENSURE_NEAR(p.sigma[0], 1, 1e-14);
  ENSURE(p.broken[0] == 0);
  Move(&joint, 1.2, 0, &p); /* half: 1.2 = 0.5/2.5 + 0.5 2 */
  ENSURE_NEAR(p.sigma[0], 0.5, 1e-14);
  ENSURE_NEAR(p.broken[0], 0.25, 1e-14);
  /* on the slope, wherever rounding puts it, the place bears the shear of its kappa */
  for (int side = -1; side <= 1; side++)
    ENSURE_NEAR(JointLimitAt(&joint, p.broken[0], p.broken[1], 0.5 + side * 1e-15), 0.75, 1e-14);
  ENSURE(JointLimitAt(&joint, 0.5, 0.5, 1e-3) == 0);
  Move(&joint, 0.6, 0, &p); /* back on the line to the origin */
  ENSURE_NEAR(p.sigma[0], 0.25, 1e-14);
  Move(&joint, -1, 0, &p); /* pressed as if it were sound */
  ENSURE_NEAR(p.sigma[0], -2.5, 1e-14);
  Move(&joint, 1.2, 0, &p);
  ENSURE_NEAR(p.sigma[0], 0.5, 1e-14);
  ENSURE(p.state[0] == CONTACT_ELASTIC);
  Move(&joint, 2.1, 0.1, &p);
  ENSURE(p.sigma[0] == 0 && p.tau[0] == 0 && p.broken[0] == 0.5 && p.state[0] == CONTACT_OPEN);
}

static void TestSlip(void)
{
  Joint joint = Soft();
  ContactPoint p = {.margin = 1e-3};
  Move(&joint, -0.4, 1, &p); /* at its limit, 2 + 1 */
  ENSURE_NEAR(p.tau[0], 3, 1e-14);
  ENSURE(p.broken[0] == 0);
  Move(&joint, -0.4, 1.75, &p); /* slip 1, which takes half: 1.25 + 1 */
  ENSURE_NEAR(p.tau[0], 2.25, 1e-14);
  ENSURE_NEAR(p.slip[0], 1, 1e-14);
  ENSURE_NEAR(p.broken[0], 0.25, 1e-14);
  ENSURE(p.state[0] == CONTACT_SLIPPING);
  Move(&joint, -0.4, 1.5, &p); /* back by k_s */
  ENSURE_NEAR(p.tau[0], 1.5, 1e-14);
  ENSURE(p.state[0] == CONTACT_ELASTIC);
  ENSURE_NEAR(JointLimitAt(&joint, p.broken[0], p.broken[1], -1), 2.25, 1e-14);
  Move(&joint, -0.4, 0.25 - 1.5, &p); /* on the other side: tau -2.25 and slip back by 1, so all is taken */
  ENSURE_NEAR(p.tau[0], -1.5, 1e-13);
  ENSURE(p.broken[0] == 0.5);
  Move(&joint, 0.1, 5, &p); /* opening sets it free */
  ENSURE(p.sigma[0] == 0 && p.tau[0] == 0);
}

/* Opening takes cohesion too, and slip takes tension. */
static void TestTogether(void)
{
  Joint joint = Soft();
  ContactPoint p = {.margin = 1e-3}, q = p;
  Move(&joint, 1.2, 0, &p);
  Move(&joint, -0.4, 5, &p);
  ENSURE_NEAR(p.tau[0], 1.5, 1e-14); /* slip of 4.5, more than the rest takes */
  Move(&joint, -0.4, 1.75, &q);
  Move(&joint, 0.6, 1, &q);
  ENSURE_NEAR(q.sigma[0], 0.25, 1e-14);
  Move(&joint, 1.2, 1, &q);
  ENSURE_NEAR(q.sigma[0], 0.5, 1e-14);
}

/* Without its energy a strength that is passed, by more than the margin, takes all. */
static void TestAtOnce(void)
{
  Joint joint = Soft();
  ContactPoint p = {.margin = 1e-3}, q = p;
  joint.fracture_energy[0] = 0;
  Move(&joint, 0.4002, 0, &p);
  ENSURE(p.broken[0] == 0 && p.sigma[0] > 1);
  Move(&joint, 0.41, 0, &p);
  ENSURE(p.broken[0] == 0.5 && p.sigma[0] == 0);
  joint = Soft(), joint.fracture_energy[1] = 0;
  Move(&joint, -0.4, 1.001, &q);
  ENSURE_NEAR(q.tau[0], 1.5, 1e-14);
  ENSURE(q.broken[0] == 0.5);
}

/* Returns the energy stored per area. */
static double Stored(const Joint *joint, const ContactPoint *p)
{
  const double u = p->sigma[0] > 0 ? p->u_n[0] : p->sigma[0] / joint->k_n;
  return 0.5 * p->sigma[0] * u + 0.5 * p->tau[0] * p->tau[0] / joint->k_s;
}

/* On random ways every step takes work or none. */
static void TestWork(void)
{
  Joint joint = Soft();
  for (int way = 0; way < 40; way++) {
    ContactPoint p = {.margin = 1e-3};
    double taken = 0, n = 0, s = 0, broken = 0;
    for (int leg = 0; leg < 10; leg++) {
      const double to_n = Random(-0.5, 1), to_s = Random(-1.5, 1.5);
      enum { STEPS = 2000 };
      for (int i = 0; i < STEPS; i++) {
        const double sigma = p.sigma[0], tau = p.tau[0], before = Stored(&joint, &p);
        const double d_n = (to_n - n) / STEPS, d_s = (to_s - s) / STEPS;
        Move(&joint, p.u_n[0] + d_n, p.u_s[0] + d_s, &p);
        const double work = 0.5 * (sigma + p.sigma[0]) * d_n + 0.5 * (tau + p.tau[0]) * d_s;
        ENSURE(work - (Stored(&joint, &p) - before) > -1e-4); /* the last step before it is free jumps down */
        taken += work - (Stored(&joint, &p) - before);
        ENSURE(p.broken[0] >= broken);
        broken = p.broken[0];
      }
      n = to_n, s = to_s;
    }
    ENSURE(taken > -1e-3);
  }
}

/* A joint that does not soften has in a batch with one that does the bits that it has alone. */
static void TestBatch(void)
{
  Joint joints[2] = {Soft(), Soft()};
  const PetscInt rows[LANES] = {0, 1, 0, 1};
  LanesJoint J;
  joints[1].fracture_energy[0] = joints[1].fracture_energy[1] = 0;
  LoadJoints(joints, rows, 1e-3, &J);
  ENSURE(J.softens && J.crushes && J.soft[0] && !J.soft[1] && J.soft[2] && !J.soft[3]);
  ENSURE(J.peak.tension[0] == 1 && J.peak.tension[1] == 1 + 1e-3);
  ENSURE_NEAR(J.opening[0], 2, 1e-15);
  ENSURE_NEAR(J.sliding[2], 2, 1e-15);
  ENSURE(J.opening[1] == 0 && J.sliding[3] == 0);
  const PetscInt brittle[LANES] = {1, 1, 1, 1};
  LoadJoints(joints, brittle, 1e-3, &J);
  ENSURE(!J.softens && !J.crushes);
}

int main(int argc, char **argv)
{
  (void)argc, (void)argv;
  RUN_TEST(TestOpening);
  RUN_TEST(TestSlip);
  RUN_TEST(TestTogether);
  RUN_TEST(TestAtOnce);
  RUN_TEST(TestWork);
  RUN_TEST(TestBatch);
  return CheckSummary();
}

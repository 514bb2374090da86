/* test_joint_law.c: the joint law on one contact, in all six stress models: direct shear (V07 of the
   verification plan), memory of the gap, brittle failure, the envelope, the cut-off in compression, crushing,
   dashpots, NaN. */
#include "contact_point.h"

static const double MPa = 1e6, mm = 1e-3;

/* V07: k_n = 10, k_s = 3 GPa/m, c = 0.1 MPa, phi = 35, tension 0.05 MPa */
static Joint ShearBox(double cohesion_residual, double friction_residual)
{
  Joint joint = MakeJoint(10e9, 3e9, 35, 0.1 * MPa, 0.05 * MPa);

  joint.cohesion[1] = cohesion_residual;
  joint.friction[1] = friction_residual;
  joint.tension[1] = 0;
  JointPrepare(&joint);
  return joint;
}

/* shears the contact to u_s in steps; the largest shear force on the way */
static double Shear(int model, const Joint *joint, double u_s, int steps, ContactPoint *p)
{
  double start = p->u_s[0], peak = 0;

  for (int i = 1; i <= steps; i++) {
    p->u_s[0] = p->u_s[1] = start + (u_s - start) * i / steps;
    StressModelRespond(model, joint, 1, p);
    peak = fmax(peak, SumS(p));
  }
  return peak;
}

static void SetNormal(int model, const Joint *joint, double u_n0, double u_n1, ContactPoint *p)
{
  p->u_n[0] = u_n0;
  p->u_n[1] = u_n1;
  StressModelRespond(model, joint, 1, p);
}

/* a) sigma_n = 0.5 MPa: peak 450.1 kPa at u_s = 0.1500 mm; then 288.7 kPa (c = 0, phi = 30),
   or 450.1 when ductile */
static void TestDirectShear(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint brittle = ShearBox(0, 30), ductile = MakeJoint(10e9, 3e9, 35, 0.1 * MPa, 0);
    ContactPoint p = {.broken = {0}}, q = {.broken = {0}};

    SetNormal(model, &brittle, -0.05 * mm, -0.05 * mm, &p);
    ENSURE_NEAR(Shear(model, &brittle, 0.1500 * mm, 150, &p), 450.0e3, 1);
    ENSURE(p.broken[0] == 0 && p.broken[1] == 0 && p.slip[0] == 0);
    ENSURE_NEAR(Shear(model, &brittle, 0.1501 * mm, 1, &p), 288.675e3, 1);
    ENSURE(p.broken[0] + p.broken[1] >= 1 && p.state[0] == CONTACT_SLIPPING &&
           p.state[1] == CONTACT_SLIPPING);
    Shear(model, &brittle, 1 * mm, 37, &p);
    ENSURE_NEAR(SumS(&p), 0.5 * MPa * tan(PETSC_PI / 6), 1e-6);
    ENSURE_NEAR(p.slip[0], 1 * mm - 288.675e3 / 3e9, 1e-9);

    SetNormal(model, &ductile, -0.05 * mm, -0.05 * mm, &q);
    ENSURE_NEAR(Shear(model, &ductile, 1 * mm, 100, &q), 450.104e3, 1);
    ENSURE(q.broken[0] == 0 && q.broken[1] == 0);
    Shear(model, &ductile, 0.9 * mm, 1, &q); /* elastic on the way back */
    ENSURE_NEAR(SumS(&q), 450.104e3 - 300e3, 1);
  }
}

/* b) pull: opens at 0.005 mm; then neither tension nor cohesion, 350.1 kPa of shear at 0.5 MPa */
static void TestPull(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint joint = ShearBox(0, 35);
    ContactPoint p = {.broken = {0}};

    SetNormal(model, &joint, 0.00499 * mm, 0.00499 * mm, &p);
    ENSURE_NEAR(SumN(&p), 0.0499 * MPa, 1e-6);
    ENSURE(p.state[0] == CONTACT_ELASTIC);
    SetNormal(model, &joint, 0.00501 * mm, 0.00501 * mm, &p);
    ENSURE(SumN(&p) == 0 && SumS(&p) == 0 && p.state[0] == CONTACT_OPEN && p.state[1] == CONTACT_OPEN);
    SetNormal(model, &joint, 0.003 * mm, 0.003 * mm, &p);
    ENSURE(SumN(&p) == 0);
    SetNormal(model, &joint, -0.05 * mm, -0.05 * mm, &p);
    ENSURE_NEAR(Shear(model, &joint, 1 * mm, 50, &p), 350.104e3, 1);
  }
}

/* c) memory: open to 1.0 mm, back to a gap of 0.4 mm: no stress; contact again only when the
   gap is 0, without shear */
static void TestMemoryOfGap(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint joint = ShearBox(0, 35);
    ContactPoint p = {.broken = {0}};

    SetNormal(model, &joint, -0.05 * mm, -0.05 * mm, &p);
    for (int i = 0; i <= 100; i++) SetNormal(model, &joint, 0.01 * i * mm, 0.01 * i * mm, &p);
    Shear(model, &joint, 2 * mm, 10, &p);
    ENSURE(SumS(&p) == 0 && p.slip[0] == 2 * mm && p.slip[1] == 2 * mm);
    for (int i = 100; i > 0; i--) {
      SetNormal(model, &joint, 0.01 * i * mm, 0.01 * i * mm, &p);
      ENSURE(SumN(&p) == 0 && SumS(&p) == 0 && p.sigma[0] == 0 && p.tau[1] == 0);
    }
    SetNormal(model, &joint, -0.05 * mm, -0.05 * mm, &p);
    ENSURE_NEAR(SumN(&p), -0.5 * MPa, 1e-6);
    ENSURE_NEAR(SumS(&p), 0, 1e-6);
  }
}

/* d) e = 0.3 L: tptm is closed over 0.6 m and bears c 0.6 + N tan(phi); pt keeps the cohesion of 1.0 m */
static void TestEccentricShear(void)
{
  double N = 1 * MPa, t = tan(35 * PETSC_PI / 180);

  for (int steps = 1; steps <= 1000; steps += 999) {
    Joint joint = MakeJoint(10e9, 3e9, 35, 0.1 * MPa, 0);
    ContactPoint p = {.broken = {0}}, q = {.broken = {0}};

    SetNormal(STRESS_TPTM, &joint, -2 * N / 0.6 / 10e9, 2 * N / 0.6 / 10e9 * 0.4 / 0.6, &p);
    ENSURE_NEAR(SumN(&p), -N, 1e-6);
    ENSURE_NEAR(p.F_n[0], -0.8 * N, 1e-6);
    ENSURE_NEAR(Shear(STRESS_TPTM, &joint, 5 * mm, steps, &p), 0.1 * MPa * 0.6 + N * t, 1e-4);
    SetNormal(STRESS_PT, &joint, -1.6 * N / 10e9, -0.4 * N / 10e9, &q);
    ENSURE_NEAR(q.F_n[0], -0.8 * N, 1e-6);
    ENSURE_NEAR(Shear(STRESS_PT, &joint, 5 * mm, steps, &q), 0.1 * MPa * 1.0 + N * t, 1e-4);
  }
}

/* after tension has broken 0.4 m, tptm keeps the cohesion of the other 0.6 m, and nothing more
   after failing in shear */
static void TestCohesionLeft(void)
{
  double t = tan(35 * PETSC_PI / 180);

  for (int steps = 2; steps <= 2000; steps *= 10) {
    Joint joint = ShearBox(0, 35);
    ContactPoint p = {.broken = {0}};

    SetNormal(STRESS_TPTM, &joint, -0.010 * mm, 0.015 * mm, &p); /* sigma = 0.05 MPa at 0.6 m */
    ENSURE_NEAR(p.broken[1], 0.4, 1e-14);
    ENSURE(p.broken[0] == 0);
    SetNormal(STRESS_TPTM, &joint, -0.05 * mm, -0.05 * mm, &p);
    ENSURE_NEAR(p.broken[1], 0.4, 1e-14);
    ENSURE_NEAR(Shear(STRESS_TPTM, &joint, 0.45010 * mm / 3, steps, &p), 0.06 * MPa + 0.5 * MPa * t, 20);
    Shear(STRESS_TPTM, &joint, 0.46 * mm / 3, 2, &p);
    ENSURE_NEAR(SumS(&p), 0.5 * MPa * t, 1e-4);
    ENSURE(p.broken[0] == 1 && p.broken[1] == 1);
  }
}

/* a tptm contact in monotonic shear, brittle or not, gives the same answer whatever the step */
static void TestStepSize(void)
{
  for (int n = 0; n < CheckDraws(2000); n++) {
    Joint joint = RandomJoint();
    ContactPoint coarse = RandomPoint(PETSC_FALSE), fine;
    double u_s = Random(0, 2);

    coarse.u_s[0] = coarse.u_s[1] = 0;
    fine = coarse;
    Shear(STRESS_TPTM, &joint, u_s, 1, &coarse);
    Shear(STRESS_TPTM, &joint, u_s, 500, &fine);
    ENSURE_NEAR(SumN(&fine), SumN(&coarse), 1e-12);
    ENSURE_NEAR(SumS(&fine), SumS(&coarse), 1e-9);
  }
}

/* on any path: ends within the law, fronts within [0,1] and never back, the same question
   gives the same answer */
static void TestEnvelope(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    for (int n = 0; n < 50; n++) {
      Joint joint = RandomJoint();
      ContactPoint p = RandomPoint(PETSC_FALSE), old, again;

      for (int step = 0; step < 200; step++) {
        for (int k = 0; k < 2; k++) p.u_n[k] += Random(-0.1, 0.1), p.u_s[k] += Random(-0.2, 0.2);
        old = p;
        StressModelRespond(model, &joint, 1.5, &p);
        for (int k = 0; k < 2; k++) {
          int strength = p.broken[k] > 0;
          ENSURE(p.sigma[k] <= joint.tension[strength] && p.sigma[k] >= -joint.compression);
          ENSURE(fabs(p.tau[k]) <= fmax(0, joint.cohesion[strength] - p.sigma[k] * joint.tan_phi[strength]));
          ENSURE(p.broken[k] >= old.broken[k] && p.broken[k] <= 1);
          if (p.state[k] & CONTACT_OPEN) ENSURE(p.tau[k] == 0);
        }
        again = p;
        StressModelRespond(model, &joint, 1.5, &again);
        for (int k = 0; k < 2; k++) {
          ENSURE_NEAR(again.F_n[k], p.F_n[k], 1e-12);
          ENSURE_NEAR(again.F_s[k], p.F_s[k], 1e-11);
          ENSURE_NEAR(again.slip[k], p.slip[k], 1e-11);
          ENSURE(again.broken[k] == p.broken[k]);
        }
      }
    }
  }
}

/* compression is cut off at its strength, friction is that of the stress cut off, and what was crushed stays
   crushed: pressed 0.5 mm with C/k_n = 0.2 mm the joint closes again at -0.3 mm */
static void TestCrushing(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint joint = MakeJoint(10e9, 3e9, 30, 0, 0);
    ContactPoint p = {.broken = {0}};

    joint.compression = 2 * MPa;
    SetNormal(model, &joint, -0.5 * mm, -0.5 * mm, &p);
    ENSURE_NEAR(SumN(&p), -2 * MPa, 1e-6);
    ENSURE(p.state[0] == CONTACT_CRUSHING && p.state[1] == CONTACT_CRUSHING);
    ENSURE_NEAR(Shear(model, &joint, 2 * mm, 10, &p), 2 * MPa * tan(PETSC_PI / 6), 1e-6);
    ENSURE(p.state[0] == (CONTACT_CRUSHING | CONTACT_SLIPPING));
    for (int k = 0; k < 2; k++) ENSURE_NEAR(StressModelClosure(&p, k), -0.3 * mm, 1e-12);
    SetNormal(model, &joint, -0.35 * mm, -0.35 * mm, &p);
    ENSURE_NEAR(SumN(&p), -0.5 * MPa, 1e-6);
    SetNormal(model, &joint, -0.29 * mm, -0.29 * mm, &p);
    ENSURE(SumN(&p) == 0 && p.state[0] == CONTACT_OPEN);
    SetNormal(model, &joint, -0.5 * mm, -0.5 * mm, &p);
    ENSURE_NEAR(SumN(&p), -2 * MPa, 1e-6);
    ENSURE_NEAR(StressModelClosure(&p, 0), -0.3 * mm, 1e-12);
  }
}

/* 1 MN on 1 m of 4 MPa, 0.35 m out of the middle, then in the middle. Crushed are a = (0.5 - sqrt(0.15))/2 m
   next to b = 0.5 - 2 a of a triangle. Back in the middle that toe of depth w = a C/(k b) is set back: the
   joint closes by N/k + w a/2 and turns by 6 w a (1/2 - a/3); 0.1064 and 0.0969 mm at its edges, not 0.1000.
   */
static void TestCrushedToe(void)
{
  const double k_n = 10e9, C = 4 * MPa, N = 1 * MPa, a = (0.5 - sqrt(0.15)) / 2, b = 0.5 - 2 * a,
               theta = C / k_n / b, w = theta * a, mean = N / k_n + w * a / 2,
               turn = 6 * w * a * (0.5 - a / 3);
  for (int end = 0; end < 2; end++) {
    Joint joint = MakeJoint(k_n, 3e9, 30, 0, 0);
    ContactPoint p = {.broken = {0}};
    double u[2], open, crushing;

    joint.compression = C;
    u[end] = -C / k_n - w, u[1 - end] = u[end] + theta;
    SetNormal(STRESS_TPTM, &joint, u[0], u[1], &p);
    ENSURE_NEAR(SumN(&p), -N, 1e-6);
    ENSURE_NEAR(p.F_n[1 - end], -0.15 * N, 1e-6);
    StressModelParts(&joint, &p, &open, &crushing);
    ENSURE_NEAR(crushing, a, 1e-9);
    ENSURE_NEAR(open, 1 - a - b, 1e-12);
    ENSURE_NEAR(StressModelStored(&joint, 1, &p), C * C / (2 * k_n) * (a + b / 3), 1e-9);
    u[end] = -mean - turn / 2, u[1 - end] = -mean + turn / 2;
    SetNormal(STRESS_TPTM, &joint, u[0], u[1], &p);
    for (int k = 0; k < 2; k++) ENSURE_NEAR(p.F_n[k], -0.5 * N, 1e-6);
    ENSURE_NEAR(p.sigma[end], -k_n * (mean + turn / 2 - w), 1e-6);
    StressModelParts(&joint, &p, &open, &crushing);
    ENSURE(open == 0 && crushing == 0);
  }
}

/* A contact crushed at one end, with u_n of 0.05 mm and then of 0.2 mm at the other: 0.5 MPa of tension,
   which 1 MPa of strength holds, so nothing is open; then 2 MPa, and open is what is above 1 MPa, a
   seventh. So it is where the joint has no strength left once it has failed, because the rest has not
   failed. A loose contact and one that has failed all along are open wherever they are in tension, a third
   with what was crushed. */
static void TestCrushedJointInTension(void)
{
  for (int end = 0; end < 2; end++)
    for (int brittle = 0; brittle < 2; brittle++) {
      Joint joint = MakeJoint(10e9, 3e9, 30, 0, 1 * MPa);
      ContactPoint p = {.broken = {0}};
      double u[2], open, crushing;

      joint.compression = 2 * MPa;
      if (brittle) joint.tension[1] = 0;
      u[end] = -0.5 * mm, u[1 - end] = -0.1 * mm;
      SetNormal(STRESS_TPTM, &joint, u[0], u[1], &p);
      ENSURE(p.closure[end] < 0);
      u[1 - end] = 0.05 * mm;
      SetNormal(STRESS_TPTM, &joint, u[0], u[1], &p);
      ENSURE(!(p.state[1 - end] & CONTACT_OPEN));
      StressModelParts(&joint, &p, &open, &crushing);
      ENSURE(open == 0 && crushing > 0);
      u[1 - end] = 0.2 * mm;
      SetNormal(STRESS_TPTM, &joint, u[0], u[1], &p);
      ENSURE(p.state[1 - end] & CONTACT_OPEN);
      StressModelParts(&joint, &p, &open, &crushing);
      ENSURE_NEAR(open, 1. / 7, 1e-12);
      for (int loose = 0; loose < 2; loose++) {
        p.broken[0] = p.broken[1] = loose ? LOOSE : 1;
        StressModelParts(&joint, &p, &open, &crushing);
        ENSURE_NEAR(open, brittle || loose ? 1. / 3 : 1. / 7, 1e-12);
      }
    }
}

/* One contact of tptm beside fibres that each keep their own closure; C = k_n = L = 1. */
enum { FIBRES = 400 };
static double fibre_force(const double u[2], double closure[FIBRES], double F[2], PetscBool keep)
{
  F[0] = F[1] = 0;
  for (int i = 0; i < FIBRES; i++) {
    const double x = (i + 0.5) / FIBRES, u_n = u[0] * (1 - x) + u[1] * x, least = fmin(closure[i], u_n + 1),
                 sigma = fmin(0, u_n - least) / FIBRES;
    if (keep) closure[i] = least;
    F[0] += (1 - x) * sigma, F[1] += x * sigma;
  }
  return F[0] + F[1];
}

/* Rocking to and fro, ever wider, under a load of a quarter of the strength, constant or changing by 60 %:
   exact up to the fibres, and within 2 % of the strength; any opening of the ends: within a quarter. */
static void TestCrushingPaths(void)
{
  const double bound[3] = {1e-3, 0.02, 0.25};
  Joint joint = MakeJoint(1, 1, 30, 0, 0);

  joint.compression = 1;
  for (int path = 0; path < 3; path++) {
    double closure[FIBRES] = {0}, F[2], worst = 0;
    ContactPoint p = {.broken = {0}};
    for (int step = 0; step < 400; step++) {
      const double t = step / 400., turn = 8 * t * sin(20 * PETSC_PI * t);
      const double load = 0.25 + (path ? 0.15 * sin(14 * PETSC_PI * t) : 0);
      double low = -20, high = 5;
      for (int i = 0; i < 40 && path < 2; i++) {
        const double middle = 0.5 * (low + high), u[2] = {middle - turn / 2, middle + turn / 2};
        *(fibre_force(u, closure, F, PETSC_FALSE) < -load ? &low : &high) = middle;
      }
      p.u_n[0] = path < 2 ? low - turn / 2 : Random(-2, 0.5);
      p.u_n[1] = path < 2 ? low + turn / 2 : Random(-2, 0.5);
      fibre_force(p.u_n, closure, F, PETSC_TRUE);
      StressModelRespond(STRESS_TPTM, &joint, 1, &p);
      for (int k = 0; k < 2; k++) worst = fmax(worst, fabs(p.F_n[k] - F[k]));
    }
    ENSURE_NEAR(worst, 0, bound[path]);
  }
}

/* On any path the work done on a joint less what it stores is never given back. */
static void TestCrushingLoses(void)
{
  const int models[2] = {STRESS_PT, STRESS_TPTM};

  for (int n = 0; n < CheckDraws(100); n++) {
    Joint joint = MakeJoint(1, 1, 0, 0, 0);
    ContactPoint p = {.u_n = {0, 0}}, old;
    const int model = models[n % 2];
    double lost = 0, most = 0;

    joint.compression = 1;
    StressModelRespond(model, &joint, 1, &p);
    for (int leg = 0; leg < 20; leg++) {
      const double to[2] = {Random(-2, 0.5), Random(-2, 0.5)}, from[2] = {p.u_n[0], p.u_n[1]};
      for (int i = 1; i <= 200; i++) {
        double stored[2];
        old = p;
        for (int k = 0; k < 2; k++) p.u_n[k] = from[k] + (to[k] - from[k]) * i / 200;
        StressModelRespond(model, &joint, 1, &p);
        for (int now = 0; now < 2; now++) {
          const ContactPoint *q = now ? &p : &old;
          stored[now] = model == STRESS_PT ? 0.25 * (PetscSqr(q->sigma[0]) + PetscSqr(q->sigma[1]))
                                           : StressModelStored(&joint, 1, q);
        }
        for (int k = 0; k < 2; k++) lost += 0.5 * (p.F_n[k] + old.F_n[k]) * (p.u_n[k] - old.u_n[k]);
        lost -= stored[1] - stored[0];
        most = fmax(most, lost);
        ENSURE(lost > most - 1e-4);
      }
    }
    ENSURE(lost > 0.1);
  }
}

/* Dashpots: sigma from -1 to 1, so that tptm is closed over a half and the others at one end; damping k_n v
   = -0.4. They add 0.4 times what is closed, friction counts it; leaving fast the contact bears nothing,
   ever. */
static void TestDashpots(void)
{
  const double closed[STRESS_MODELS] = {[STRESS_PT] = 0.5,   [STRESS_R2PT] = 0.5,  [STRESS_R3PT] = 0.25,
                                        [STRESS_T2PT] = 0.5, [STRESS_T3PT] = 0.25, [STRESS_TPTM] = 0.5};
  const double slide = 9;

  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint joint = MakeJoint(1, 1, 30, 0, 0);
    ContactPoint spring = {.u_n = {-1, 1}, .u_s = {slide, slide}, .in_time = PETSC_TRUE}, both;

    joint.damping = 0.2;
    both = spring;
    both.speed[0] = both.speed[1] = -2;
    StressModelRespond(model, &joint, 1, &spring);
    StressModelRespond(model, &joint, 1, &both);
    ENSURE_NEAR(SumN(&both), SumN(&spring) - 0.4 * closed[model], 1e-12);
    ENSURE_NEAR(SumS(&both), -joint.tan_phi[0] * SumN(&both), 1e-12);
    ENSURE_NEAR(both.sigma[0], spring.sigma[0], 0); /* stresses are those of the springs */
    both = (ContactPoint){.u_n = {-1, 1}, .u_s = {slide, slide}, .in_time = PETSC_TRUE, .speed = {9, 9}};
    StressModelRespond(model, &joint, 1, &both);
    ENSURE_NEAR(SumN(&both), 0, 1e-12);
    ENSURE_NEAR(SumS(&both), 0, 1e-12);
    both = (ContactPoint){.u_n = {1, 2}, .in_time = PETSC_TRUE, .speed = {-99, -99}}; /* open: nothing yet */
    StressModelRespond(model, &joint, 1, &both);
    ENSURE(SumN(&both) == 0);
  }
}

/* the middle of a three-point model fails with the more violated end */
static void TestBrokenParts(void)
{
  const StressModelKind models[] = {STRESS_PT, STRESS_R2PT, STRESS_T2PT, STRESS_R3PT, STRESS_T3PT};

  for (int i = 0; i < 5; i++) {
    Joint joint = ShearBox(0, 30);
    ContactPoint p = {.broken = {0}};
    PetscBool three = (PetscBool)(i >= 3);

    SetNormal(models[i], &joint, -0.05 * mm, 0.02 * mm, &p); /* middle in compression */
    ENSURE(p.broken[0] == 0 && p.broken[1] == (three ? 0.25 : 0.5));
    SetNormal(models[i], &joint, -0.01 * mm, 0.04 * mm, &p); /* middle above the tension strength */
    ENSURE(p.broken[0] == 0 && p.broken[1] == (three ? 0.75 : 0.5));
    SetNormal(models[i], &joint, 0.01 * mm, 0.04 * mm, &p);
    ENSURE(p.broken[0] == (three ? 0.25 : 0.5));
    ENSURE(SumN(&p) == 0);
  }
}

/* an elastic joint has no strength; a NaN is not lost in a clip */
static void TestElasticAndNaN(void)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    Joint joint = ShearBox(0, 30);
    ContactPoint p = {.u_n = {1, 2}, .u_s = {3, -4}}, q = {.u_n = {NAN, -1}},
                 r = {.u_n = {-1, -1}, .u_s = {0, NAN}};

    StressModelRespond(model, &joint, 1, &q);
    ENSURE(isnan(SumN(&q)));
    StressModelRespond(model, &joint, 1, &r);
    ENSURE(isnan(SumS(&r)));
    joint.law = LAW_ELASTIC;
    StressModelRespond(model, &joint, 2, &p);
    ENSURE_NEAR(SumN(&p), 30e9, 1e-3);
    ENSURE_NEAR(SumS(&p), -3e9, 1e-3);
    ENSURE(p.broken[0] == 0 && p.slip[0] == 0);
  }
}

/* A stress that passes the peak by less than the margin, which is rounding of the stresses around, breaks
   nothing: in tension, in shear at no stress and under pressure. By twice as much it does. A joint that
   cannot break, and one without a margin, answer as they did. */
static void TestMargin(void)
{
  const double margin = 0.5, k_n = 10e9, k_s = 3e9;
  for (int model = 0; model < STRESS_MODELS; model++)
    for (int bonded = 0; bonded < 2; bonded++) {
      const double c = bonded ? 13e3 : 0;
      Joint breaks = MakeJoint(k_n, k_s, 45, c, 0), ductile = breaks;
      breaks.cohesion[1] = 0, breaks.friction[1] = 30;
      JointPrepare(&breaks);
      for (int how = 0; how < 3; how++)
        for (int times = 1; times < 3; times++) {
          const double over = (1.4 * times - 0.6) * margin; /* 0.8 and 2.2 margins */
          const double sigma = how == 0 ? over : how == 1 ? 0 : -20e3, tau = how == 0 ? 0 : c - sigma + over;
          ContactPoint p = {.margin = margin}, q = {.margin = margin}, r = {.margin = 0};
          p.u_n[0] = p.u_n[1] = sigma / k_n, p.u_s[0] = p.u_s[1] = tau / k_s;
          for (int k = 0; k < 2; k++) q.u_n[k] = r.u_n[k] = p.u_n[k], q.u_s[k] = r.u_s[k] = p.u_s[k];
          StressModelRespond(model, &breaks, 1, &p);
          ENSURE((p.broken[0] > 0) == (times == 2) && (p.broken[1] > 0) == (times == 2));
          StressModelRespond(model, &ductile, 1, &q);
          StressModelRespond(model, &ductile, 1, &r);
          ENSURE(SumN(&q) == SumN(&r) && SumS(&q) == SumS(&r));
        }
    }
}

int main(int argc, char **argv)
{
  (void)argc, (void)argv;
  RUN_TEST(TestDirectShear);
  RUN_TEST(TestPull);
  RUN_TEST(TestMemoryOfGap);
  RUN_TEST(TestEccentricShear);
  RUN_TEST(TestCohesionLeft);
  RUN_TEST(TestStepSize);
  RUN_TEST(TestEnvelope);
  RUN_TEST(TestCrushing);
  RUN_TEST(TestCrushedToe);
  RUN_TEST(TestCrushedJointInTension);
  RUN_TEST(TestCrushingPaths);
  RUN_TEST(TestCrushingLoses);
  RUN_TEST(TestDashpots);
  RUN_TEST(TestBrokenParts);
  RUN_TEST(TestElasticAndNaN);
  RUN_TEST(TestMargin);
  return CheckSummary();
}

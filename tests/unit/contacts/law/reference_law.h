/* reference_law.h: the law of ONE contact, written to be read. Begin here. The kernels of
   src/contacts/law/ do the same for four contacts at once; test_reference.c holds them against these
   pages.

   A contact is a line of length L between two faces. x runs along it, from 0 at end 0 to 1 at end 1.
   Openings, slips and trial stresses are linear in x, and so known from their values at the two ends. Numbers
   in brackets are equations of the paper; its section 2.5 is about all of this. Stress is positive in
   tension.

     1. opening and slip of each end     (1)-(4)    EndOf
     2. stress, as if the joint held     (5), (6)   TrialSigma, TrialTau
     3. what a place can bear                       NormalStress, ShearLimit: Mohr-Coulomb with cut-offs
     4. what crushes, fails and slips               reference.c: Crush, BreakPoints, ReturnShear
     5. forces at the two ends                      reference.c: PointForces, RespondDiagram
     6. forces at the vertices                      reference.c: ReferenceVertexForces

   Then read reference.c from its end: Respond is 2 to 5, in the order in which they happen.
   reference_diagram.h has the control points of the model tptm. docs/deviations.md, i to m and y, says why
   each step is as it is. */
#pragma once
#include "reference.h"

/* Strength of a place: tension [Pa], cohesion [Pa], tangent of the friction angle. */
typedef struct {
  double T, c, tan_phi;
} Strength;

typedef struct {
  StressModelKind model;
  double L, k_n, k_s, C;   /* length [m], stiffness [Pa/m], compressive strength [Pa] */
  Strength peak, residual; /* before and after a place has failed */
  double u_n[2], u_s[2];   /* [m] opening and tangential displacement of the two ends */
  double slip[2];          /* [m] history: plastic part of u_s */
  double broken[2];        /* [-] history: failed fraction of the length, from each end */
  double closure[2][2];    /* [m] history: two lines, each by its values at end 0 and end 1; see ClosureAt */
  double tau[2];           /* [Pa] the line of shear stress: trial, then what is left of it */
  double dashpot[2];       /* [Pa] damping * k_n * speed of opening */
} OneContact;

/* ----------------------------------------------------------------- 1. opening and slip of an end, (1)-(4) */

/* Positions X and displacements u of P, A, B. */
static inline FaceEnd EndOf(const double *const X[3], const double *const u[3], double t, double moving)
{
  FaceEnd end = {.t = t, .moving = moving};
  double d[2], face[2];
  for (int i = 0; i < 2; i++) {
    const double P = X[0][i] + u[0][i], A = X[1][i] + u[1][i], B = X[2][i] + u[2][i];
    d[i] = P - ((1 - t) * A + t * B); /* (1), (2), summed over all steps */
    face[i] = X[2][i] - X[1][i] + moving * (u[2][i] - u[1][i]);
  }
  end.length = hypot(face[0], face[1]);
  end.s[0] = face[0] / end.length, end.s[1] = face[1] / end.length;
  end.n[0] = end.s[1], end.n[1] = -end.s[0];
  end.u_n = d[0] * end.n[0] + d[1] * end.n[1]; /* (3) */
  end.u_s = d[0] * end.s[0] + d[1] * end.s[1]; /* (4) */
  return end;
}

/* ---------------------------------------------------------------------------- 2. trial stresses, (5), (6) */

static inline double Along(const double ends[2], double x)
{
  return (1 - x) * ends[0] + x * ends[1];
}

/* Plastic part of u_n, which is what was crushed: the lower of two lines, and never above 0. */
static inline double ClosureAt(const OneContact *c, double x)
{
  return fmin(0, fmin(Along(c->closure[0], x), Along(c->closure[1], x)));
}

static inline double TrialSigma(const OneContact *c, double x)
{
  return c->k_n * (Along(c->u_n, x) - ClosureAt(c, x)); /* (5), of the total opening, which knows of a gap */
}

static inline double TrialTau(const OneContact *c, double x)
{
  return c->k_s * (Along(c->u_s, x) - Along(c->slip, x)); /* (6) */
}

/* ----------------------------------------------------- 3. what a place of a given strength can bear (2.5) */

static inline double NormalStress(const OneContact *c, const Strength *s, double sigma)
{
  return sigma > s->T ? s->T : fmax(sigma, -c->C);
}

/* |tau| <= c - sigma tan(phi); an open place bears no shear. */
static inline double ShearLimit(const OneContact *c, const Strength *s, double sigma)
{
  return sigma > s->T ? 0 : fmax(0, s->c - fmax(sigma, -c->C) * s->tan_phi);
}

static inline double Clip(double value, double limit)
{
  return fmax(-limit, fmin(limit, value));
}

static inline bool Fails(const OneContact *c, double sigma, double tau)
{
  return sigma > c->peak.T || fabs(tau) > ShearLimit(c, &c->peak, sigma);
}

/* Whether failing changes anything. */
static inline bool Brittle(const OneContact *c)
{
  return c->peak.T != c->residual.T || c->peak.c != c->residual.c || c->peak.tan_phi != c->residual.tan_phi;
}

static inline bool IsBroken(const OneContact *c, double x)
{
  return x < c->broken[0] || x > 1 - c->broken[1];
}

static inline const Strength *StrengthAt(const OneContact *c, double x)
{
  return IsBroken(c, x) ? &c->residual : &c->peak;
}

/* Stress that the dashpot adds to a pressed spring. The two together do not pull, and do not pass C. */
static inline double DashpotAt(const OneContact *c, double x)
{
  const double spring = TrialSigma(c, x);
  if (spring >= 0) return 0;
  return fmax(-c->C, fmin(0, spring + Along(c->dashpot, x))) - fmax(-c->C, spring);
}

static inline double NormalAt(const OneContact *c, double x)
{
  return NormalStress(c, StrengthAt(c, x), TrialSigma(c, x));
}

static inline double LimitAt(const OneContact *c, double x)
{
  return ShearLimit(c, StrengthAt(c, x), TrialSigma(c, x));
}

/* Spring and dashpot together limit the shear of a control point. */
static inline double DampedSigma(const OneContact *c, double x)
{
  return TrialSigma(c, x) + DashpotAt(c, x);
}

static inline double DampedLimit(const OneContact *c, double x)
{
  return ShearLimit(c, StrengthAt(c, x), DampedSigma(c, x));
}

static inline double ShearAt(const OneContact *c, double x)
{
  return Clip(Along(c->tau, x), LimitAt(c, x));
}

/* law_point.h: declares the input of a material law at a point, in lanes. */
#pragma once
#include "blocks/laws.h"
#include "blocks/thermal_kernels.h"

/* Stress or strain in plane strain, z included. */
typedef struct {
  Lanes xx, yy, zz, xy;
} LanesStress;

typedef struct {
  const PetscReal *constant; /* (LAW_CONSTANTS, LANES) */
} LanesLaw;

KERNEL Lanes LawConstant(const LanesLaw *law, int k)
{
  return LoadLanes(law->constant + LANES * k);
}

/* Returns the constants of LANES blocks: the constants of their group, or, for several groups, gathered into
   `mixed`, (LAW_CONSTANTS, LANES). */
KERNEL LanesLaw LoadLaw(const LawHistory *h, const PetscInt *group, PetscReal *mixed)
{
  const PetscReal *first = h->constants + LAW_CONSTANTS * LANES * (ptrdiff_t)group[0];
  if (group[0] == group[1] && group[0] == group[2] && group[0] == group[3]) return (LanesLaw){first};
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++)
    mixed[i] = h->constants[LAW_CONSTANTS * LANES * (ptrdiff_t)group[i % LANES] + i];
  return (LanesLaw){mixed};
}

KERNEL LanesMaterial MaterialOf(const LanesLaw *law)
{
  const Lanes c0 = LawConstant(law, LAW_HOURGLASS);
  return (LanesMaterial){LawConstant(law, LAW_LAMBDA),
                         LawConstant(law, LAW_MU),
                         {c0, LawConstant(law, LAW_HOURGLASS + 1), LawConstant(law, LAW_HOURGLASS + 2)},
                         c0 > 0.};
}

KERNEL Lanes Smaller(Lanes a, Lanes b)
{
  return Select(a < b, a, b);
}

/* ---- principal axes */

typedef struct {
  Lanes s1, s2, s3; /* s1 >= s2 >= s3 */
} LanesPrincipal;

/* Principal stresses in the plane, hi >= lo, and the direction of hi: its x, y over twice the angle. */
typedef struct {
  Lanes hi, lo, cos2, sin2;
} LanesPlane;

KERNEL LanesPlane PlaneOf(const LanesStress *s)
{
  const Lanes mean = 0.5 * (s->xx + s->yy), half = 0.5 * (s->xx - s->yy),
              radius = SquareRoot(half * half + s->xy * s->xy);
  const Mask none = radius == 0.;
  const Lanes r = 1. / Select(none, LanesOf(1.), radius);
  return (LanesPlane){mean + radius, mean - radius, half * r, s->xy * r};
}

/* The three principal stresses in order; z is the first (top), the last (bottom) or the middle one. */
typedef struct {
  LanesPlane plane;
  LanesPrincipal t;
  Mask top, bottom;
} LanesAxes;

KERNEL LanesAxes AxesOf(const LanesPlane *p, Lanes zz)
{
  const Mask top = zz > p->hi, bottom = ~top & (zz < p->lo);
  return (LanesAxes){
      *p,
      {Select(top, zz, p->hi), Select(top, p->hi, Select(bottom, p->lo, zz)), Select(bottom, zz, p->lo)},
      top,
      bottom};
}

/* Returns the elastic strain of a stress with these axes. soft: 1/E. */
KERNEL LanesStress StrainOf(const LanesAxes *a, LanesPrincipal s, Lanes soft, Lanes nu)
{
  const Lanes s_hi = Select(a->top, s.s2, s.s1), s_lo = Select(a->bottom, s.s2, s.s3),
              s_zz = Select(a->top, s.s1, Select(a->bottom, s.s3, s.s2));
  const Lanes hi = soft * (s_hi - nu * (s_lo + s_zz)), lo = soft * (s_lo - nu * (s_hi + s_zz)),
              zz = soft * (s_zz - nu * (s_hi + s_lo));
  const Lanes mean = 0.5 * (hi + lo), half = 0.5 * (hi - lo);
  return (LanesStress){mean + half * a->plane.cos2, mean - half * a->plane.cos2, zz, half * a->plane.sin2};
}

/* Returns C e. */
KERNEL LanesStress StressOf(const LanesLaw *law, const LanesStress *e)
{
  const Lanes pressure = LawConstant(law, LAW_LAMBDA) * (e->xx + e->yy + e->zz),
              two_mu = LawConstant(law, LAW_MU) + LawConstant(law, LAW_MU);
  return (LanesStress){pressure + two_mu * e->xx, pressure + two_mu * e->yy, pressure + two_mu * e->zz,
                       two_mu * e->xy};
}

/* Returns s : e. */
KERNEL Lanes TensorDot(const LanesStress *s, const LanesStress *e)
{
  return s->xx * e->xx + s->yy * e->yy + s->zz * e->zz + 2. * (s->xy * e->xy);
}

/* The blocks in the reference configuration. */
typedef struct {
  int n_nodes;
  const LanesVector *X;
} LanesShape;

/* Returns the width of the blocks across a crack with normal hi: area over projection on the crack. A
   crack that crosses triangles goes through two of them side by side, so their width is doubled. */
KERNEL Lanes WidthAcross(const LanesShape *shape, const LanesPlane *p)
{
  const Lanes c = SquareRoot(NotNegative(0.5 + 0.5 * p->cos2)),
              s = SquareRoot(NotNegative(0.5 - 0.5 * p->cos2)), sine = Select(p->sin2 < 0., -s, s);
  const LanesVector *X = shape->X;
  Lanes most = LanesOf(0.), least = LanesOf(0.), twice = LanesOf(0.);
  for (int i = 1; i < shape->n_nodes; i++) {
    const LanesVector d = VectorSubtract(X[i], X[0]);
    const Lanes along = c * d.y - sine * d.x;
    most = Larger(most, along), least = Smaller(least, along);
    if (i + 1 < shape->n_nodes) twice += VectorCross(d, VectorSubtract(X[i + 1], X[0]));
  }
  return (shape->n_nodes == 3 ? 1. : 0.5) * twice / (most - least);
}

/* ---- thermal strain

   A law sees only the strain E - E_t. The resisting stress is the stress of the law plus s I, because s I is
   applied as a load to blocks of all laws (thermal.c). */
typedef struct {
  Lanes along, across; /* E_t in the plane; across it */
  Lanes s;             /* [Pa] stress of C E_t in the plane */
} LanesThermal;

KERNEL LanesThermal ThermalOf(const LanesLaw *law, Lanes along)
{
  const Lanes across = LawConstant(law, LAW_ACROSS) * along, mu = LawConstant(law, LAW_MU);
  return (LanesThermal){along, across,
                        LawConstant(law, LAW_LAMBDA) * (along + along + across) + (mu + mu) * along};
}

/* Returns the strain that the law sees, E less the thermal strain. thermal NULL: none. Then zz is a constant
   zero. */
KERNEL LanesStress StrainOfLaw(const LanesTensor *E, const LanesThermal *thermal)
{
  if (!thermal) return (LanesStress){E->xx, E->yy, LanesOf(-0.), E->xy};
  return (LanesStress){E->xx - thermal->along, E->yy - thermal->along, -thermal->across, E->xy};
}

/* Returns the energy of s I in the strain E, so that the energy of E - E_t plus this is the energy of E in
   elastic blocks. */
KERNEL Lanes ThermalStored(const LanesTensor *E, const LanesThermal *t)
{
  return t->s * (E->xx + E->yy) - 0.5 * t->s * (t->along + t->along + t->across);
}

/* ---- laws.c, for LANES blocks from `first` on, with the present history */
/* Computes S at a point of the blocks from the strain E there. */
void LawPointStress(const Elements *e, PetscInt first, int point, const LanesTensor *E, LanesTensor *S);
/* Computes the energy [J] per thickness stored in the blocks. X, u: their modes. */
void LawEnergy(const Elements *e, PetscInt first, const LanesModes *X, const LanesModes *u, Lanes *stored);

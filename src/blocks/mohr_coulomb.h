/* mohr_coulomb.h: computes the stress of blocks that yield at the Mohr-Coulomb strength with a tension
   cut-off, in plane strain.

   Stresses are positive in tension. With principal stresses s1 >= s2 >= s3, the one along z among them, a
   point may not have

   (1 + sin phi) s1 - (1 - sin phi) s3 > 2 c cos phi,   s1 > ft.

   Plastic flow is e1 (1 + sin psi) - e3 (1 - sin psi) at the shear planes and e1 at the cut-off. The
   return of a trial stress t to the strength is implicit and exact: it ends on a plane, or where two or
   three meet. In each region two or three equations are linear, so all regions are closed forms:

     face      t - l C m
     edge      s1 = s2 or s2 = s3, on the face, where the flow has no other part than those of its planes
     cut-off   one, two or three principal stresses are ft
     corner    s1 = ft, s3 on the face, e2 = 0, unless s2 meets one of them

   An elastic point keeps what it has. The strain along z is zero, its plastic part is not. No apex is
   needed: ft is at most c cot phi, where the cut-off has its corner at the apex. */
#pragma once
#include "blocks/law_point.h"

enum { MC_XX = HISTORY_OWN, MC_YY, MC_ZZ, MC_XY, MC_WIDTH }; /* plastic strain; xy: half of the shear */

enum {
  MC_PLUS = LAW_OWN, /* 1 + sin phi */
  MC_MINUS,          /* 1 - sin phi */
  MC_SHEAR,          /* [Pa] 2 c cos phi */
  MC_CUT,            /* [Pa] ft */
  MC_FLOW1,          /* C m of the face over the size of C m in its normal */
  MC_FLOW2,
  MC_FLOW3,
  MC_SLOPE, /* on the face s3 = slope s1 - step */
  MC_STEP,  /* [Pa] */
  MC_A12,   /* edge s1 = s2: s1 = a12 (t1 + t2) + a3 (t3 + step) */
  MC_A3,
  MC_B23, /* edge s2 = s3: s1 = b23 (t2 + t3 + 2 step) + b1 t1 */
  MC_B1,
  MC_NU,
  MC_SIDE, /* nu / (1 - nu) */
  MC_SOFT  /* [1/Pa] 1/E */
};

static const PetscReal MC_SHARP = 1e-11; /* of the stresses: a point yields beyond this excess */
static const PetscReal MC_ROUND = 1e-14; /* of stiffness times strain: smaller stresses are rounding */
static const PetscReal MC_NONE = 1e-9;   /* of the stiffness against bending: a smaller one is zero */
static const PetscReal MC_LEAST = 0.01;  /* of the stress at a point: least bending force */

/* Returns the stress of the elastic part of a strain. */
KERNEL LanesStress McElastic(const LanesLaw *law, const LanesStress *E, const LanesStress *plastic)
{
  const LanesStress e = {E->xx - plastic->xx, E->yy - plastic->yy, E->zz - plastic->zz, E->xy - plastic->xy};
  return StressOf(law, &e);
}

/* Returns the stress to the shear planes alone. */
KERNEL LanesPrincipal McShear(const LanesLaw *law, LanesPrincipal t)
{
  const Lanes excess = NotNegative(LawConstant(law, MC_PLUS) * t.s1 - LawConstant(law, MC_MINUS) * t.s3 -
                                   LawConstant(law, MC_SHEAR)),
              slope = LawConstant(law, MC_SLOPE), step = LawConstant(law, MC_STEP);
  const LanesPrincipal face = {t.s1 - LawConstant(law, MC_FLOW1) * excess,
                               t.s2 - LawConstant(law, MC_FLOW2) * excess,
                               t.s3 - LawConstant(law, MC_FLOW3) * excess};
  const Mask upper = face.s2 > face.s1, lower = ~upper & (face.s3 > face.s2);
  const Lanes a = LawConstant(law, MC_A12) * (t.s1 + t.s2) + LawConstant(law, MC_A3) * (t.s3 + step),
              b = LawConstant(law, MC_B23) * (t.s2 + t.s3 + step + step) + LawConstant(law, MC_B1) * t.s1;
  const Lanes s1 = Select(upper, a, Select(lower, b, face.s1)), on_face = slope * s1 - step;
  return (LanesPrincipal){s1, Select(upper, a, Select(lower, on_face, face.s2)),
                          Select(upper | lower, on_face, face.s3)};
}

/* Returns to the cut-off, and to the shear planes that it meets, where the return to the shear planes was
   not enough. */
KERNEL LanesPrincipal McCut(const LanesLaw *law, LanesPrincipal t)
{
  const Lanes ft = LawConstant(law, MC_CUT), nu = LawConstant(law, MC_NU), over = t.s1 - ft,
              side = LawConstant(law, MC_SIDE) * over,
              corner = LawConstant(law, MC_SLOPE) * ft - LawConstant(law, MC_STEP);
  const Lanes one2 = t.s2 - side, one3 = t.s3 - side, two3 = t.s3 - nu * (over + (t.s2 - ft));
  const Mask two = one2 > ft;
  const Lanes s3 = Select(two, Smaller(two3, ft), one3);
  const Lanes middle = t.s2 - nu * (over + (t.s3 - corner));
  const Mask meets = s3 < corner;
  return (LanesPrincipal){ft, Select(meets, Smaller(Larger(middle, corner), ft), Select(two, ft, one2)),
                          Select(meets, corner, s3)};
}

KERNEL LanesPrincipal McReturn(const LanesLaw *law, LanesPrincipal t)
{
  const LanesPrincipal shear = McShear(law, t);
  const Mask cut = shear.s1 > LawConstant(law, MC_CUT);
  if (!Any(cut)) return shear;
  const LanesPrincipal at = McCut(law, t);
  return (LanesPrincipal){Select(cut, at.s1, shear.s1), Select(cut, at.s2, shear.s2),
                          Select(cut, at.s3, shear.s3)};
}

/* Computes the plastic strain that returns the trial stress to the strength, in lanes that yield; else 0. */
KERNEL LanesStress McPlastic(const LanesLaw *law, const LanesStress *trial, const LanesPlane *p, Mask yields)
{
  const LanesAxes a = AxesOf(p, trial->zz);
  const LanesPrincipal s = McReturn(law, a.t);
  const LanesStress e = StrainOf(&a, (LanesPrincipal){a.t.s1 - s.s1, a.t.s2 - s.s2, a.t.s3 - s.s3},
                                 LawConstant(law, MC_SOFT), LawConstant(law, MC_NU));
  return (LanesStress){Keep(yields, e.xx), Keep(yields, e.yy), Keep(yields, e.zz), Keep(yields, e.xy)};
}

KERNEL Lanes StrainSize(const LanesStress *e)
{
  return SquareRoot(TensorDot(e, e));
}

/* Returns the remaining fraction of the stiffness against bending of a one-point block: the square of
   elastic over total deviatoric strain. So bending forces fade as the block flows. With the first power
   they would keep the size of the stress at the point, which in bands of flow one block wide is a fifth of
   the resistance. A hundredth of the stress is allowed to remain; a fixed least stiffness would in the end
   carry a mechanism. */
KERNEL Lanes McWhole(const LanesLaw *law, const LanesStress *s, const LanesStress *plastic)
{
  const Lanes third = (s->xx + s->yy + s->zz) * (1. / 3.),
              two_mu = LawConstant(law, LAW_MU) + LawConstant(law, LAW_MU);
  const LanesStress deviator = {s->xx - third, s->yy - third, s->zz - third, s->xy};
  const Lanes elastic = StrainSize(&deviator), lost = two_mu * StrainSize(plastic);
  const Mask none = lost == 0.;
  const Lanes share = elastic / Select(none, LanesOf(1.), elastic + lost);
  return Select(none, LanesOf(1.), Larger(LanesOf(MC_NONE), share * Larger(LanesOf(MC_LEAST), share)));
}

KERNEL LanesStress McLoad(const Lanes *from)
{
  return (LanesStress){from[MC_XX], from[MC_YY], from[MC_ZZ], from[MC_XY]};
}

/* Computes the stress of the strain E from the history `from`. to receives the new history; NULL: not
   needed. whole: see McWhole. */
KERNEL LanesStress McStress(const LanesLaw *law, const LanesStress *E, const Lanes *from, Lanes *to,
                            Lanes *whole)
{
  LanesStress plastic = McLoad(from), s = McElastic(law, E, &plastic);
  const LanesPlane p = PlaneOf(&s);
  const Lanes most = Larger(p.hi, s.zz), least = Smaller(p.lo, s.zz);
  const Lanes excess = LawConstant(law, MC_PLUS) * most - LawConstant(law, MC_MINUS) * least -
                       LawConstant(law, MC_SHEAR),
              over = Larger(excess, most - LawConstant(law, MC_CUT));
  *whole = LanesOf(1.);
  if (to)
    for (int i = 0; i < MC_WIDTH; i++) to[i] = from[i];
  if (Any(over > 0.)) {
    const Lanes strain = Absolute(E->xx) + Absolute(E->yy) + Absolute(E->xy) + Absolute(E->zz - plastic.zz),
                stiff = LawConstant(law, LAW_LAMBDA) + LawConstant(law, LAW_MU) + LawConstant(law, LAW_MU),
                sharp = MC_SHARP * (Absolute(most) + Absolute(least)) + MC_ROUND * stiff * strain;
    const LanesStress d = McPlastic(law, &s, &p, over > sharp);
    plastic = (LanesStress){plastic.xx + d.xx, plastic.yy + d.yy, plastic.zz + d.zz, plastic.xy + d.xy};
    s = McElastic(law, E, &plastic);
    if (to) {
      to[HISTORY_LOST] += TensorDot(&s, &d);
      to[HISTORY_MEASURE] += SquareRoot(LanesOf(2. / 3.)) * StrainSize(&d);
      to[MC_XX] = plastic.xx, to[MC_YY] = plastic.yy, to[MC_ZZ] = plastic.zz, to[MC_XY] = plastic.xy;
    }
  }
  if (Any(((Mask)plastic.xx | (Mask)plastic.yy | (Mask)plastic.zz | (Mask)plastic.xy) != 0))
    *whole = McWhole(law, &s, &plastic);
  return s;
}

/* Returns the stored energy [J/m3], S : e / 2 of the elastic strain e. */
KERNEL Lanes McStored(const LanesLaw *law, const LanesStress *E, const Lanes *from)
{
  const LanesStress plastic = McLoad(from), s = McElastic(law, E, &plastic);
  return 0.5 * (s.xx * (E->xx - plastic.xx) + s.yy * (E->yy - plastic.yy) + s.zz * (E->zz - plastic.zz)) +
         s.xy * (E->xy - plastic.xy);
}

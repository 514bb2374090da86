/* damage.h: computes the stress of blocks that crack in tension with a given fracture energy (crack band).

   A material without tension would open by the fracture strain e_f >= 0 that leaves no stress in tension:
   C (E - e_f) <= 0, and no stress where it opens. It is the return to a cut-off at 0 (mohr_coulomb.h).
   Damage d, 0 to 1, lets the block open by a part of it,

   S = C (E - d e_f),   stored energy (E.C E - d e_f.C e_f)/2.

   At fixed d that energy is a potential of S, so a block that opens and closes makes nothing of nothing.
   Compression sees the whole stiffness; with d = 1 there is no tension left.

   Damage grows with the largest principal stress of C E so far, over E: kappa. From e_0 = ft/E on

   1 - d = (e_0/kappa) exp(-(kappa - e_0)/B),   B = Gf M/(E h ft) - e_0/2,

   where h is the width of the block across the crack, as it is when it first cracks: then the block loses
   Gf for each square metre of the crack, whatever its size. M = lambda + 2 mu is the stiffness across one
   crack, whose energy is (M e_f) e_f/2 with M e_f = E kappa. B > 0 is needed: a wider block would give
   back more than the crack takes. With softening: linear, (e_0/kappa) (1 - (kappa - e_0)/(2 B)), 0 from
   kappa = e_0 + 2 B on: the same energy, the same B > 0. */
#pragma once
#include "blocks/law_point.h"

enum { DM_KAPPA = HISTORY_OWN, DM_WIDTH, DM_NUMBERS }; /* kappa [-]; h [m], 0: has not cracked */

enum {
  DM_ONSET = LAW_OWN, /* e_0 */
  DM_BAND,            /* [m] Gf M/(E ft) */
  DM_STRENGTH,        /* [Pa] ft */
  DM_YOUNG,           /* [Pa] */
  DM_SOFT,            /* [1/Pa] 1/E */
  DM_NU,
  DM_SIDE,  /* nu/(1 - nu) */
  DM_LINEAR /* 1: softening: linear; 0: exponential */
};

static const PetscReal DM_SHARP = 1e-12; /* of kappa: beyond it damage grows */
static const PetscReal DM_LEAST = 1e-6;  /* that is left of the stiffness against bending */

KERNEL Lanes LanesExp(Lanes a)
{
  return (Lanes){exp(a[0]), exp(a[1]), exp(a[2]), exp(a[3])};
}

/* Returns the fracture strain of the stress s at full damage. */
KERNEL LanesStress DmFracture(const LanesLaw *law, const LanesStress *s, const LanesPlane *p)
{
  const LanesAxes a = AxesOf(p, s->zz);
  const Lanes side = LawConstant(law, DM_SIDE), nu = LawConstant(law, DM_NU);
  const Lanes two = a.t.s2 - side * a.t.s1, three = a.t.s3 - nu * (a.t.s1 + a.t.s2);
  const Mask first = a.t.s1 > 0., second = first & (two > 0.), third = second & (three > 0.);
  /* what is taken from the stress */
  const LanesPrincipal t = {
      Keep(first, a.t.s1), Keep(first, Select(second, a.t.s2, side * a.t.s1)),
      Keep(first, Select(third, a.t.s3, Select(second, nu * (a.t.s1 + a.t.s2), side * a.t.s1)))};
  return StrainOf(&a, t, LawConstant(law, DM_SOFT), nu);
}

/* Returns the stress that one crack still carries, over the tensile strength. */
KERNEL Lanes DmRemaining(const LanesLaw *law, Lanes kappa, Lanes band)
{
  const Lanes over = (kappa - LawConstant(law, DM_ONSET)) / band;
  const Mask linear = LawConstant(law, DM_LINEAR) > 0.;
  if (!Any(linear)) return LanesExp(-over);
  return Select(linear, NotNegative(1. - 0.5 * over), LanesExp(-over));
}

/* Returns the energy [J/m3] dissipated at a point with one crack, times E/M. */
KERNEL Lanes DmDissipated(const LanesLaw *law, Lanes kappa, Lanes band, Lanes left)
{
  const Lanes onset = LawConstant(law, DM_ONSET), strength = LawConstant(law, DM_STRENGTH),
              bears = left * kappa / onset;
  const Lanes gone = 1. - Select(LawConstant(law, DM_LINEAR) > 0., bears * bears, bears),
              work = strength * (0.5 * onset + band * gone);
  return Keep(kappa > onset, work - 0.5 * left * LawConstant(law, DM_YOUNG) * kappa * kappa);
}

/* Computes the history for a larger kappa, in lanes where it grows. shape: of the blocks. energy: e_f.C
   e_f/2. */
KERNEL void DmGrow(const LanesLaw *law, const LanesShape *shape, const LanesPlane *p, Lanes kappa,
                   Lanes energy, Mask grows, Lanes *h)
{
  const Lanes onset = LawConstant(law, DM_ONSET);
  const Lanes width = Select(h[DM_WIDTH] > 0., h[DM_WIDTH], WidthAcross(shape, p));
  const Lanes band = LawConstant(law, DM_BAND) / width - 0.5 * onset;
  const Lanes left = onset / kappa * DmRemaining(law, kappa, band);
  const Lanes spent = DmDissipated(law, kappa, band, left) -
                      DmDissipated(law, h[DM_KAPPA], band, 1. - h[HISTORY_MEASURE]);
  const Lanes share = energy / (0.5 * LawConstant(law, DM_YOUNG) * kappa * kappa);
  h[HISTORY_LOST] += Keep(grows, share * spent);
  h[HISTORY_MEASURE] = Select(grows, 1. - left, h[HISTORY_MEASURE]);
  h[DM_KAPPA] = Select(grows, kappa, h[DM_KAPPA]);
  h[DM_WIDTH] = Select(grows, width, h[DM_WIDTH]);
}

/* Computes the stress as McStress. shape NULL: the history does not change. */
KERNEL LanesStress DmStress(const LanesLaw *law, const LanesStress *E, const LanesShape *shape,
                            const Lanes *from, Lanes *to, Lanes *whole)
{
  LanesStress s = StressOf(law, E);
  const LanesPlane p = PlaneOf(&s);
  Lanes h[DM_NUMBERS];
  for (int i = 0; i < DM_NUMBERS; i++) h[i] = from[i];
  const Lanes most = Larger(p.hi, s.zz), kappa = LawConstant(law, DM_SOFT) * most,
              so_far = Larger(h[DM_KAPPA], LawConstant(law, DM_ONSET));
  const Mask grows = (kappa > so_far + DM_SHARP * so_far) & (shape ? ~(Mask){0} : (Mask){0});
  if (Any(grows | ((h[HISTORY_MEASURE] > 0.) & (most > 0.)))) {
    const LanesStress f = DmFracture(law, &s, &p), open = StressOf(law, &f);
    if (Any(grows)) DmGrow(law, shape, &p, kappa, 0.5 * TensorDot(&open, &f), grows, h);
    const Lanes d = h[HISTORY_MEASURE];
    s = (LanesStress){s.xx - d * open.xx, s.yy - d * open.yy, s.zz - d * open.zz, s.xy - d * open.xy};
  }
  for (int i = 0; i < DM_NUMBERS && to; i++) to[i] = h[i];
  *whole = Larger(LanesOf(DM_LEAST), 1. - h[HISTORY_MEASURE]);
  return s;
}

/* Returns the stored energy [J/m3]. opening receives the opening [m] of the crack: largest d e_f times h. */
KERNEL Lanes DmStored(const LanesLaw *law, const LanesStress *E, const Lanes *from, Lanes *opening)
{
  const LanesStress s = StressOf(law, E);
  const LanesPlane p = PlaneOf(&s);
  const LanesStress f = DmFracture(law, &s, &p), open = StressOf(law, &f);
  *opening = from[DM_WIDTH] * from[HISTORY_MEASURE] * Larger(PlaneOf(&f).hi, LanesOf(0.));
  return 0.5 * (TensorDot(&s, E) - from[HISTORY_MEASURE] * TensorDot(&open, &f));
}

/* law_kernels.h: computes the forces of blocks with a material law that has a history. The law is a
   constant where these kernels are used, so each law has its own loops without the branches below. */
#pragma once
#include "blocks/damage.h"
#include "blocks/mohr_coulomb.h"

/* Computes S at a point, from the mechanical strain E and the history `from`. shape: of the blocks; NULL:
   the history does not change. to receives the new history; NULL: not needed. whole: [-] remaining
   fraction of the stiffness against bending of a one-point block. */
KERNEL LanesStress LawStress(int law, const LanesLaw *c, const LanesStress *E, const LanesShape *shape,
                             const Lanes *from, Lanes *to, Lanes *whole)
{
  if (law == MATERIAL_DAMAGE) return DmStress(c, E, shape, from, to, whole);
  if (law == MATERIAL_MOHR_COULOMB) return McStress(c, E, from, to, whole);
  __builtin_unreachable();
}

/* Returns the stored energy [J/m3] at a point with history `from`. opening: [m] of a crack there, -1: the
   law has none. */
KERNEL Lanes LawStored(int law, const LanesLaw *c, const LanesStress *E, const Lanes *from, Lanes *opening)
{
  *opening = LanesOf(-1.);
  if (law == MATERIAL_DAMAGE) return DmStored(c, E, from, opening);
  if (law == MATERIAL_MOHR_COULOMB) return McStored(c, E, from);
  __builtin_unreachable();
}

KERNEL int LawWidth(int law)
{
  if (law == MATERIAL_DAMAGE) return DM_NUMBERS;
  if (law == MATERIAL_MOHR_COULOMB) return MC_WIDTH;
  __builtin_unreachable();
}

/* The history of LANES blocks at one point. here: lanes that have this point. */
typedef struct {
  const PetscReal *from;
  PetscReal *to; /* NULL: not needed */
  Mask here;
} LanesHistory;

/* Computes the natural stress J g_a . S g_b at a point, with the reference tangents dual to g1 and g2. */
KERNEL LanesTensor LawNatural(int law, const LanesLaw *c, Lanes J, LanesVector g1, LanesVector g2,
                              const LanesGradient *G, int large, const LanesShape *shape,
                              const LanesThermal *thermal, const LanesHistory *history, Lanes *whole)
{
  const LanesTensor total = BlockStrain(G, large);
  const LanesStress E = StrainOfLaw(&total, thermal);
  const int width = LawWidth(law);
  Lanes from[HISTORY_MOST], to[HISTORY_MOST];
  for (int i = 0; i < width; i++) from[i] = LoadLanes(history->from + LANES * i);
  LanesStress S = LawStress(law, c, &E, shape, from, history->to ? to : NULL, whole);
  if (thermal) S.xx += thermal->s, S.yy += thermal->s;
  for (int i = 0; i < width && history->to; i++)
    StoreLanes(history->to + LANES * i, Select(history->here, to[i], LoadLanes(history->to + LANES * i)));
  const LanesVector S1 = {S.xx * g1.x + S.xy * g1.y, S.xy * g1.x + S.yy * g1.y},
                    S2 = {S.xx * g2.x + S.xy * g2.y, S.xy * g2.x + S.yy * g2.y};
  return (LanesTensor){J * VectorDot(g1, S1), J * VectorDot(g2, S2), J * VectorDot(g1, S2)};
}

/* Computes the same from the tangents. */
KERNEL LanesTensor LawPoint(int law, const LanesLaw *c, LanesVector X1, LanesVector X2, LanesVector u1,
                            LanesVector u2, int large, const LanesShape *shape, const LanesThermal *thermal,
                            const LanesHistory *history)
{
  LanesVector g1, g2;
  Lanes whole;
  const Lanes J = DualBasis(X1, X2, &g1, &g2);
  const LanesGradient G = DisplacementGradient(u1, u2, g1, g2);
  return LawNatural(law, c, J, g1, g2, &G, large, shape, thermal, history, &whole);
}

KERNEL LanesHistory HistoryOfPoint(const LanesHistory *block, int point, int width)
{
  return (LanesHistory){block->from + LANES * width * point,
                        block->to ? block->to + LANES * width * point : NULL, block->here};
}

KERNEL void LawT3(int law, const LanesLaw *c, const LanesVector *X, const LanesVector *u, PetscReal thickness,
                  int large, const LanesScalar *warm, const LanesHistory *history, LanesVector *f)
{
  const LanesShape shape = {3, X};
  LanesThermal thermal;
  if (warm) thermal = ThermalOf(c, warm->mean);
  const LanesModes XM = T3Modes(X), uM = T3Modes(u);
  const LanesVector x1 = large ? VectorAdd(XM.a, uM.a) : XM.a, x2 = large ? VectorAdd(XM.b, uM.b) : XM.b;
  const LanesTensor T = LawPoint(law, c, XM.a, XM.b, uM.a, uM.b, large, &shape, warm ? &thermal : NULL,
                                 history);
  T3Sum(&T, x1, x2, thickness, f);
}

/* Reduces the bending force to the fraction `whole`, and applies P of a block with thermal strain. */
KERNEL void SoftenBending(const LanesLaw *c, const LanesMaterial *m, const LanesScalar *warm, Lanes whole,
                          LanesHourglass *o)
{
  LanesVector P = {LanesOf(0.), LanesOf(0.)};
  if (warm) {
    const LanesScalar s = ScalarTimes(warm, ThermalOf(c, LanesOf(1.)).s);
    P = ThermalBending(&s, o, m);
    o->c = VectorSubtract(o->c, P);
  }
  o->c = (LanesVector){whole * o->c.x, whole * o->c.y};
  if (warm) o->c = VectorAdd(o->c, P);
}

/* Returns twice the bending energy p.C p without the thermal bending. */
KERNEL Lanes BendingStored(const LanesLaw *c, const LanesMaterial *m, const LanesScalar *warm,
                           const LanesHourglass *o)
{
  const Lanes all = VectorDot(o->p, o->c);
  if (!warm) return all;
  const LanesScalar s = ScalarTimes(warm, ThermalOf(c, LanesOf(1.)).s);
  return all + 2. * ThermalBendingEnergy(&s, o, m);
}

/* Adds the energy dissipated as the stiffness against bending decreases. density: [J/m3] energy at full
   stiffness. */
KERNEL void KeepSoft(const LanesHistory *history, Lanes before, Lanes whole, Lanes density)
{
  PetscReal *lost = history->to + LANES * HISTORY_LOST, *soft = history->to + LANES * HISTORY_SOFT;
  const Lanes now = 1. - whole;
  StoreLanes(lost, LoadLanes(lost) + Keep(history->here, (now - before) * density));
  StoreLanes(soft, Select(history->here, now, LoadLanes(soft)));
}

KERNEL void LawOnePoint(int law, const LanesLaw *c, const LanesMaterial *m, const LanesVector *X,
                        const LanesVector *u, PetscReal thickness, int large, const LanesScalar *warm,
                        const LanesHistory *history, LanesVector *f)
{
  const LanesShape shape = {4, X};
  LanesThermal thermal;
  if (warm) thermal = ThermalOf(c, warm->mean);
  const LanesModes XM = Q4Modes(X), uM = Q4Modes(u);
  const LanesModes x = large ? ModesAdd(&XM, &uM) : XM;
  LanesHourglass o = Hourglass(&XM, &uM, &x, m);
  const Lanes soft = LoadLanes(history->from + LANES * HISTORY_SOFT);
  Lanes whole;
  const LanesTensor T = LawNatural(law, c, o.J, o.g1, o.g2, &o.G, large, &shape, warm ? &thermal : NULL,
                                   history, &whole);
  if (history->to) KeepSoft(history, soft, whole, BendingStored(c, m, warm, &o) / (8. * o.J));
  SoftenBending(c, m, warm, whole, &o);
  Q4OnePointSum(&XM, &x, &o, &T, thickness, large, f);
}

/* Computes forces as Q4Force: a, b, h are four times the modes, and the common factor is in T. */
KERNEL void LawFull(int law, const LanesLaw *c, const LanesVector *X, const LanesVector *u,
                    PetscReal thickness, int large, const LanesScalar *warm, const LanesHistory *history,
                    LanesVector *f)
{
  const LanesShape shape = {4, X};
  LanesThermal thermal;
  const LanesModes XM = Q4FourModes(X), uM = Q4FourModes(u);
  const LanesModes x = large ? ModesAdd(&XM, &uM) : XM;
  const PetscReal w = 0.0625 * thickness;
  LanesTensor T[4];
#pragma GCC unroll 1
  for (int p = 0; p < 4; p++) {
    const PetscReal xi = p == 0 || p == 3 ? -GAUSS : GAUSS, eta = p < 2 ? -GAUSS : GAUSS;
    const LanesHistory at = HistoryOfPoint(history, p, LawWidth(law));
    if (warm) thermal = ThermalOf(c, ScalarAt(warm, xi, eta));
    const LanesTensor t = LawPoint(law, c, TangentXi(&XM, eta), TangentEta(&XM, xi), TangentXi(&uM, eta),
                                   TangentEta(&uM, xi), large, &shape, warm ? &thermal : NULL, &at);
    T[p] = (LanesTensor){w * t.xx, w * t.yy, w * t.xy};
  }
  Q4Sum(T, x.a, x.b, VectorScale(GAUSS, x.h), f);
}

/* Computes forces of LANES blocks. warm: the strain E_t, NULL: none. In a batch with both formulations
   each lane keeps its own history. */
KERNEL void LawBlock(int law, int n_nodes, const LanesLaw *c, const LanesMaterial *m, const LanesVector *X,
                     const LanesVector *u, PetscReal thickness, int large, const LanesScalar *warm,
                     LanesHistory *history, LanesVector *f)
{
  history->here = ~(Mask){0};
  if (n_nodes == 3) {
    LawT3(law, c, X, u, thickness, large, warm, history, f);
    return;
  }
  if (!Any(m->one_point)) {
    LawFull(law, c, X, u, thickness, large, warm, history, f);
    return;
  }
  const int both = Any(~m->one_point);
  LanesVector full[4];
  if (both) {
    history->here = ~m->one_point;
    LawFull(law, c, X, u, thickness, large, warm, history, full);
    history->here = m->one_point;
  }
  LawOnePoint(law, c, m, X, u, thickness, large, warm, history, f);
  for (int i = 0; i < 4 && both; i++)
    f[i] = (LanesVector){Select(m->one_point, f[i].x, full[i].x), Select(m->one_point, f[i].y, full[i].y)};
}

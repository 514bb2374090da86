/* thermal_kernels.h: computes thermal stress and bending for blocks of all laws; see thermal.c. */
#pragma once
#include "blocks/element_kernels.h"

typedef struct { /* s(xi, eta) = mean + xi a + eta b + xi eta h */
  Lanes mean, a, b, h;
} LanesScalar;

/* Returns the field of numbers at the vertices. */
KERNEL LanesScalar ScalarOf(int n_nodes, const Lanes x[4])
{
  if (n_nodes == 3) return (LanesScalar){(x[0] + x[1] + x[2]) / 3., {0.}, {0.}, {0.}};
  return (LanesScalar){0.25 * (x[0] + x[1] + x[2] + x[3]), 0.25 * (x[1] + x[2] - x[0] - x[3]),
                       0.25 * (x[2] + x[3] - x[0] - x[1]), 0.25 * (x[0] + x[2] - x[1] - x[3])};
}

KERNEL LanesScalar ScalarTimes(const LanesScalar *s, Lanes k)
{
  return (LanesScalar){k * s->mean, k * s->a, k * s->b, k * s->h};
}

KERNEL Lanes ScalarAt(const LanesScalar *s, PetscReal xi, PetscReal eta)
{
  return s->mean + xi * s->a + eta * s->b + xi * eta * s->h;
}

/* Returns P of a block that bends freely; 0 for the others. */
KERNEL LanesVector ThermalBending(const LanesScalar *s, const LanesHourglass *o, const LanesMaterial *m)
{
  const Mask bends = (m->hourglass[0] > 0.) & (m->hourglass[1] == 0.);
  const Lanes k = Keep(bends, (1. + m->hourglass[2] / m->hourglass[0]) * o->J * (4. / 3.));
  return (LanesVector){k * (s->b * o->g1.x + s->a * o->g2.x), k * (s->b * o->g1.y + s->a * o->g2.y)};
}

/* Returns the thermal correction of the bending energy, from p.C p/2 to (p.C p/2 - P.p + P.C^-1 P/2); the
   latter is zero for free thermal bending. */
KERNEL Lanes ThermalBendingEnergy(const LanesScalar *s, const LanesHourglass *o, const LanesMaterial *m)
{
  const LanesVector P = ThermalBending(s, o, m);
  const Lanes third = o->J * (4. / 3.), c0 = third * m->hourglass[0], c2 = third * m->hourglass[2];
  const Lanes xx = c0 * (o->g1.x * o->g1.x + o->g2.x * o->g2.x),
              yy = c0 * (o->g1.y * o->g1.y + o->g2.y * o->g2.y),
              xy = c2 * (o->g1.x * o->g1.y + o->g2.x * o->g2.y), det = xx * yy - xy * xy;
  const Lanes own = (yy * P.x * P.x - 2. * xy * P.x * P.y + xx * P.y * P.y) / det;
  return Keep(det > 0., 0.5 * own) - VectorDot(o->p, P);
}

/* softening.h: computes the stresses of joints that lose their strength along a slope, for LANES contacts of
   the stress model pt, whose ends are points of their own.

   The history is kappa, from 0 (peak strength) to 1 (residual strength), kept as broken = kappa/2, the failed
   part of the half of L that an end owns. Tensile strength, cohesion and tan(phi) fall together and linearly,
   T(kappa) = (1 - kappa) f_t and so on, as those of Lourenco and Rots (1997). With

     w_u = 2 G_I / f_t,   s_u = 2 G_II / (c - c_r)

   kappa is at least w/w_u, where w is the opening beyond that of the springs, and slip adds abs(d(slip))/s_u.
   G_I is the area under sigma(u_n); G_II is the work of cohesion beyond its residual value. An energy that is
   not given makes the strength fall at once: w_u or s_u is 0, and a place that passes its limit has kappa 1.

   Tension. An opening u_n carries T(kappa) where u_n = T(kappa)/k_n + kappa w_u =: e(kappa). This gives kappa
   of a first loading. Below e(kappa) the stress is T(kappa) u_n / e(kappa): a crack closes along the line to
   the origin, and a closed joint is pressed as if it were sound.

   Shear. Where abs(tau_trial) passes limit = c - sigma t by `over`, slip d and kappa obey

     limit + slope d(kappa) = abs(tau_trial) - k_s d,   d = s_u d(kappa),
     slope = sigma (t - t_r) - (c - c_r),

   so d(kappa) = over / (k_s s_u + slope). Springs unload with k_s. In tension sigma is that before the slip,
   which is not below that after it. A slope as steep as the springs breaks at once. */
#pragma once
#include "contacts/law/ends.h"

enum { CLOSES = 1, SOFTENS = 2 }; /* bits of the argument `closes`; what softens also handles closure */

/* Returns kappa at end k. */
KERNEL Lanes Softened(const Lanes broken[2], int k)
{
  const Lanes kappa = 2. * broken[k], one = LanesOf(1.);
  return Select((kappa > 1.) | (broken[1 - k] >= 1.), one, kappa);
}

KERNEL LanesStrength SoftenedStrength(const LanesJoint *J, Lanes kappa)
{
  const LanesStrength *p = &J->peak, *r = &J->residual;
  const Mask whole = kappa >= 1.;
  return (LanesStrength){Select(whole, r->tension, p->tension + kappa * (r->tension - p->tension)),
                         Select(whole, r->cohesion, p->cohesion + kappa * (r->cohesion - p->cohesion)),
                         Select(whole, r->tan_phi, p->tan_phi + kappa * (r->tan_phi - p->tan_phi))};
}

/* Returns k_n e(kappa), the trial stress at which a place with kappa softens on. */
KERNEL Lanes SofteningStress(const LanesJoint *J, Lanes kappa, Lanes tension)
{
  return J->k_n * J->opening * kappa + tension;
}

/* Returns kappa after the trial stress sigma. */
KERNEL Lanes SoftenByOpening(const LanesJoint *J, Lanes sigma, Lanes kappa)
{
  const LanesStrength strength = SoftenedStrength(J, kappa);
  const Lanes reach = J->k_n * J->opening - (J->peak.tension - J->residual.tension), one = LanesOf(1.);
  const Mask past = sigma > SofteningStress(J, kappa, strength.tension), slopes = reach > 0.;
  const Lanes now = Select(slopes, (sigma - J->peak.tension) / Select(slopes, reach, one), one);
  return Select(past & (now > kappa), Select(now < 1., now, one), kappa);
}

/* Returns the normal stress of a place with kappa. */
KERNEL Lanes SoftenedNormal(const LanesJoint *J, Lanes sigma, Lanes kappa)
{
  const Lanes tension = SoftenedStrength(J, kappa).tension, end = SofteningStress(J, kappa, tension);
  const Lanes part = tension / Select(end > 0., end, LanesOf(1.));
  return Select(sigma > 0., Select(sigma > end, tension, sigma * part),
                Select(JointIsCrushing(J, sigma), -J->compression, sigma));
}

/* Decides whether a place with kappa, and the normal stress sigma, is open. One on the slope of tension has
   all of its tensile strength, and bears shear. */
KERNEL Mask SoftenedIsOpen(const LanesJoint *J, Lanes sigma, Lanes kappa)
{
  return (kappa >= 1.) & JointIsOpen(&J->residual, sigma);
}

/* Returns the largest abs(tau) of a place with kappa that is not open, at the normal stress sigma. */
KERNEL Lanes SoftenedLimit(const LanesJoint *J, Lanes sigma, Lanes kappa)
{
  const LanesStrength strength = SoftenedStrength(J, kappa);
  return NotNegative(JointCone(&strength, sigma));
}

/* Returns kappa after the trial stress tau, at the normal stress sigma. */
KERNEL Lanes SoftenBySlip(const LanesJoint *J, Lanes sigma, Lanes tau, Lanes kappa)
{
  const Lanes limit = SoftenedLimit(J, sigma, kappa), over = Absolute(tau) - limit, one = LanesOf(1.);
  const Lanes slope = Keep(limit > 0., sigma * (J->peak.tan_phi - J->residual.tan_phi) -
                                           (J->peak.cohesion - J->residual.cohesion));
  const Lanes rate = J->k_s * J->sliding + slope;
  const Mask slopes = rate > 0.;
  const Lanes now = Select(slopes, kappa + over / Select(slopes, rate, one), one);
  return Select((over > 0.) & (kappa < 1.), Select(now < 1., now, one), kappa);
}

/* Computes stresses, history, state and end forces from trial stresses. A place is open when no tensile
   strength is left there. bounds: whether the caller needs c->most. */
KERNEL void RespondSoftening(const LanesJoint *J, int damped, int bounds, LanesContact *c)
{
  Lanes kappa[2];
  for (int k = 0; k < 2; k++) kappa[k] = Softened(c->broken, k);
  for (int k = 0; k < 2; k++) {
    const Lanes spring = c->sigma[k], tau = c->tau[k],
                sigma = damped ? spring + DashpotStress(J, spring, c->dashpot[k]) : spring;
    const Lanes opened = SoftenByOpening(J, sigma, kappa[k]), normal = SoftenedNormal(J, sigma, opened),
                now = SoftenBySlip(J, normal, tau, opened);
    const Mask open = SoftenedIsOpen(J, sigma, now);
    const Lanes limit = Keep(~open, SoftenedLimit(J, normal, now)), kept = JointClip(tau, limit),
                slip = Select(kept == 0., c->u_s[k], c->slip[k] + (tau - kept) / J->k_s);
    c->slip[k] = Select(kept == tau, c->slip[k], slip);
    c->broken[k] = Select(now > kappa[k], 0.5 * now, c->broken[k]);
    c->sigma[k] = SoftenedNormal(J, spring, now), c->tau[k] = kept;
    c->state[k] = (open & CONTACT_OPEN) | (~open & (Absolute(tau) > limit) & CONTACT_SLIPPING) |
                  (JointIsCrushing(J, sigma) & CONTACT_CRUSHING);
    c->F_n[k] = 0.5 * c->length * c->sigma[k], c->F_s[k] = 0.5 * c->length * kept;
    if (bounds) c->most[k] = 0.5 * c->length * limit;
  }
}

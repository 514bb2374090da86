/* ends.h: finds the stresses at the ends of LANES contacts from trial stresses, the part that all six stress
   models share.

   Along a contact xi runs from -1 (end 0) to 1 (end 1); the trial stresses are linear. Exchanging the ends
   is xi -> -xi, exact in floating point, and every sum is built so that it exchanges F_0 and F_1 bit for bit.

   Failure. The trial stresses before any return decide which places fail. broken[k] is the failed fraction of
   L, counted from end k. In a model of two points an end owns half of L. In a model of three the ends own a
   quarter each and the middle owns the rest, which counts to the end that is more violated. In tptm the
   front is exact: sigma, tau and the peak limit are linear in xi, so the places that do not fail are those
   where five linear functions are >= 0. These are one interval, so fronts run in from the ends only.

   Return of shear. The plastic slip is kept at the ends only, and so is linear between them. A slipping end
   returns to its limit; an open end returns to zero, so that it closes again without shear. A stronger place
   may begin inside, behind an open or broken end or at the middle. A return by the weak limit of the end
   would unload that place too: in small steps a partly open contact would never reach its cohesion times its
   closed length, and a front of failure would stop. So the return is scaled back, by one factor 1 - theta for
   both ends, until every such place has the stress of its own law for the trial field (ReturnShear). The ends
   may then lie above their limit; the diagram is clipped there. With cohesion 0 and nothing brittle no such
   place exists, and theta = 0. Full sliding gives F_s = tan(phi) F_n + c (closed length). A brittle tptm
   contact gives the same whether it is sheared in one step or in many, and the answer for the same
   displacement is the same when it is asked again.

   Crushing. A place pressed past C keeps a plastic closure, u_n + C/k_n where that is lower than before. The
   field along the contact is the lower envelope of 0 and of all such lines there have been. Two of the lines
   are kept, one by each end that was crushed, and the closure is min(0, line 0, line 1) (AdvanceClosure).
   sigma is then the largest of three lines, k_n times u_n less each of 0, line 0 and line 1, and so it is
   convex. The places that do not fail or open are still one interval, because every limit is concave.
   Functions that handle closure have an argument `closes`, a constant.

   Dashpots act where the spring is pressed. Spring and dashpot together neither pull nor pass C, and their
   sum is the normal stress that limits shear. Functions that handle dashpots have an argument `damped`, a
   constant. */
#pragma once
#include "contacts/law/law.h"
#include "contacts/law/joint_law.h"

typedef struct {
  Lanes length;
  Lanes u_n[2], u_s[2];     /* in */
  Lanes slip[2], broken[2]; /* in and out: history */
  Lanes closure[2], far[2]; /* in and out, of a joint that can crush: line k at end k and at the other end */
  Lanes dashpot[2];         /* in, of a joint with dashpots: k_n damping d(u_n)/dt */
  Lanes sigma[2], tau[2];   /* in: trial stresses; out: stresses at the ends, of the springs alone */
  Lanes F_n[2], F_s[2];     /* out */
  Lanes most[2];            /* out, where the law does not strong elastically: the largest F_s that the joint
                               can carry */
  Mask state[2];            /* out: ContactState bits */
} LanesContact;

/* Returns the value at xi of the line through the end values v. */
KERNEL Lanes Line(const Lanes v[2], Lanes xi)
{
  return 0.5 * ((1. - xi) * v[0] + (1. + xi) * v[1]);
}

/* Returns the place xi where the line from h0 to h1 changes sign; outside [-1,1] when it does not. */
KERNEL Lanes Crossing(Lanes h0, Lanes h1)
{
  return Select((h0 < 0.) ^ (h1 < 0.), (h0 + h1) / (h0 - h1), LanesOf(2.));
}

/* Decides whether end k has residual strength. */
KERNEL Mask EndIsResidual(const Lanes broken[2], int k)
{
  return (broken[k] > 0.) | (broken[1 - k] >= 1.);
}

/* Computes the end forces by the elastic row of the model, from the trial stresses. */
KERNEL void RespondElastic(const PetscReal row[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * (row[0] * c->sigma[k] + row[1] * c->sigma[1 - k]);
    c->F_s[k] = c->length * (row[0] * c->tau[k] + row[1] * c->tau[1 - k]);
    c->state[k] = (Mask){CONTACT_ELASTIC};
  }
}

/* Decides whether the law holds elastically at both ends and nothing is broken or crushed. */
KERNEL Mask IsElastic(const LanesJoint *J, int closes, const LanesContact *c)
{
  Mask elastic = {-1, -1, -1, -1};
  for (int k = 0; k < 2; k++) {
    elastic &= (c->sigma[k] <= J->peak.tension) & (c->sigma[k] >= -J->compression) &
               (Absolute(c->tau[k]) <= JointCone(&J->peak, c->sigma[k])) & (c->broken[k] <= 0.);
    if (closes) elastic &= c->closure[k] >= 0.;
  }
  return elastic | J->elastic;
}

/* ------------------------------------------------------------------------------------ return of shear */

/* A place inside the contact that limits the return of the ends, because it is stronger than they are. */
typedef struct {
  Mask counts;
  Lanes xi, limit;
} StrongPlace;

KERNEL StrongPlace StrongPlaceAt(Mask counts, Lanes xi, Lanes limit)
{
  return (StrongPlace){counts & (xi > -1.) & (xi < 1.) & (limit > 0.), xi, limit};
}

/* Returns the line of shear stress to the limits of its ends, as far as every StrongPlace keeps the stress
   clip(trial). kept: the line after the return, kept = returned + theta (trial - returned). theta is the
   smallest factor that does not change an elastic StrongPlace and leaves a slipping StrongPlace at its limit
   or above; theta = 1 always does. A theta near 1 counts as 1, because rounding would creep into the slip
   otherwise. */
KERNEL void ReturnShear(int n_places, const StrongPlace *places, const Lanes trial[2], const Lanes limit[2],
                        Lanes kept[2])
{
  const Lanes returned[2] = {JointClip(trial[0], limit[0]), JointClip(trial[1], limit[1])};
  Lanes theta = {0.};
  for (int i = 0; i < n_places; i++) {
    const Lanes most = places[i].limit, t = Line(trial, places[i].xi), r = Line(returned, places[i].xi);
    const Lanes size = Absolute(t), back = Select(t < 0., -r, r);
    const Mask whole = ((size <= most) & (back != size)) | (~(size <= most) & (back > size));
    const Mask part = ~whole & (size > most) & (back < most);
    const Lanes needed = Select(whole, LanesOf(1.), Keep(part, (most - back) / (size - back)));
    theta = Select(places[i].counts & (theta < needed), needed, theta);
  }
  for (int k = 0; k < 2; k++)
    kept[k] = Select(theta > 1. - 1e-12, trial[k], returned[k] + theta * (trial[k] - returned[k]));
}

/* Adds the returned shear to the plastic slip. Where nothing was returned the slip keeps its bits, so that it
   cannot drift by rounding. */
KERNEL void AdvanceSlip(const LanesJoint *J, const Lanes trial[2], const Lanes kept[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    const Lanes slip = Select(kept[k] == 0., c->u_s[k], c->slip[k] + (trial[k] - kept[k]) / J->k_s);
    c->slip[k] = Select(kept[k] == trial[k], c->slip[k], slip);
  }
}

/* Returns the end forces `trial` to the box |F| <= most: F is its point nearest to trial, in the metric of
   the elastic row L [a b; b a], where `coupling` is b/a. Slip is then normal to the box; the box contains F =
   0, and so F . d(slip) >= 0. The point is found from one end: this end is put to its limit, then the other
   end. The result is right when the first end would stay where it is; otherwise the result from the other end
   is. */
KERNEL void ReturnForces(PetscReal coupling, const Lanes trial[2], const Lanes most[2], Lanes F[2])
{
  Lanes from[2][2];
  Mask right[2];
  for (int a = 0; a < 2; a++) {
    const int b = 1 - a;
    from[a][a] = JointClip(trial[a], most[a]);
    from[a][b] = JointClip(trial[b] + coupling * (from[a][a] - trial[a]), most[b]);
    right[a] = JointClip(trial[a] + coupling * (from[a][b] - trial[b]), most[a]) == from[a][a];
  }
  /* the result from the end that is farther out is taken first */
  const Mask second = Absolute(trial[1]) - most[1] > Absolute(trial[0]) - most[0];
  const Mask from_0 = (~second & right[0]) | (second & ~right[1]);
  for (int k = 0; k < 2; k++) F[k] = Select(from_0, from[0][k], from[1][k]);
}

/* Finds sigma, tau and state at the ends, from the trial stresses and the strengths there. */
KERNEL void EndStresses(const LanesJoint *J, const Lanes sigma[2], const Lanes tau[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    const Lanes limit = JointShearLimit(J, &strength, sigma[k]);
    const Mask open = JointIsOpen(&strength, sigma[k]);
    c->sigma[k] = JointNormal(J, &strength, sigma[k]);
    c->tau[k] = JointClip(tau[k], limit);
    c->state[k] = (open & CONTACT_OPEN) | (~open & (Absolute(tau[k]) > limit) & CONTACT_SLIPPING) |
                  (JointIsCrushing(J, sigma[k]) & CONTACT_CRUSHING);
  }
}

/* --------------------------------------------------------------------------------------- crushing */

/* Returns the plastic part of u_n at the place xi. */
KERNEL Lanes ClosureAt(const LanesContact *c, Lanes xi)
{
  const Lanes line[2][2] = {{c->closure[0], c->far[0]}, {c->far[1], c->closure[1]}};
  const Lanes a = Line(line[0], xi), b = Line(line[1], xi), least = Select(a < b, a, b);
  return Select(least < 0., least, LanesOf(0.));
}

/* Returns the plastic part of u_n at end k. */
KERNEL Lanes ClosureOfEnd(const LanesContact *c, int k)
{
  const Lanes least = Select(c->closure[k] < c->far[1 - k], c->closure[k], c->far[1 - k]);
  return Select(least < 0., least, LanesOf(0.));
}

/* Returns the depth, at the other end, of the new line of an end that is pressed deeper than ever. Depths are
   closures with the sign changed; [0] is at this end, [1] at the other end. b: the line that this end has
   kept; a: the present line, deeper than b at this end; q: the line that the other end keeps. The new line
   has the depth of a at this end and the crushed area of a and b together, so that crushing at C does the
   right work. It is a itself where b is nowhere deeper than a, or only where q is deeper still, so that a
   second evaluation of the same u_n changes nothing. */
KERNEL Lanes FarDepth(const Lanes a[2], const Lanes b[2], const Lanes q[2])
{
  const Lanes x = (a[0] - b[0]) / ((a[0] - b[0]) + (b[1] - a[1])), y = a[0] + x * (a[1] - a[0]);
  const Lanes beyond = Select(b[1] < 0., y * y / (b[0] - b[1]), (1. - x) * (y + b[1]));
  const Lanes twice = x * (a[0] + y) + beyond; /* the area */
  /* b and q at x by the same operations: they are one line where both ends were crushed at once */
  const Mask covered = (q[0] + x * (q[1] - q[0]) >= b[0] + x * (b[1] - b[0])) & (q[1] >= b[1]);
  const Lanes far = Select(twice < a[0], a[0] - a[0] * a[0] / twice, twice - a[0]);
  const Lanes most = Select(q[1] > a[1], q[1], a[1]); /* the present depth at the other end */
  return Select((b[1] > a[1]) & (y > 0.) & ~covered, Select(far > most, most, far), a[1]);
}

/* Updates the closure from u_n. An end that is pressed deeper than ever gets a new line. Crushing inside,
   between ends that were crushed deeper before, is not kept. */
KERNEL void AdvanceClosure(const LanesJoint *J, LanesContact *c)
{
  const Lanes closure[2] = {c->closure[0], c->closure[1]}, far[2] = {c->far[0], c->far[1]};
  const Lanes now[2] = {c->u_n[0] + J->compression / J->k_n, c->u_n[1] + J->compression / J->k_n};
  for (int k = 0; k < 2; k++) {
    const Lanes a[2] = {-now[k], -now[1 - k]}, b[2] = {-closure[k], -far[k]},
                q[2] = {-far[1 - k], -closure[1 - k]};
    const Mask deeper = ~J->elastic & (now[k] < closure[k]);
    c->far[k] = Select(deeper, -FarDepth(a, b, q), far[k]);
    c->closure[k] = Select(deeper, now[k], closure[k]);
  }
}

/* --------------------------------------------------------------------------------------- dashpots */

KERNEL Lanes CutAtCompression(const LanesJoint *J, Lanes sigma)
{
  return Select(~J->elastic & JointIsCrushing(J, sigma), -J->compression, sigma);
}

/* Returns the stress that the dashpot adds at a place to a spring of trial stress s. */
KERNEL Lanes DashpotStress(const LanesJoint *J, Lanes s, Lanes dashpot)
{
  const Lanes both = s + dashpot, kept = Select(both > 0., LanesOf(0.), CutAtCompression(J, both));
  return Keep(s < 0., kept - CutAtCompression(J, s));
}

/* Replaces stresses with dashpots, from EndStresses, by the stresses of the springs alone. */
KERNEL void SpringStresses(const LanesJoint *J, const Lanes spring[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    c->sigma[k] = JointNormal(J, &strength, spring[k]);
  }
}

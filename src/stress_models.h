/* stress_models.h: from openings and slips at the two ends of LANES contacts to the forces at their ends; the
   six integration procedures of section 2.5 of the paper, free of branches but for what no lane needs.

   Along a contact xi runs from -1 (end 0) to 1 (end 1); the trial stresses are linear. Exchanging the ends
   is xi -> -xi, exact in floating point, and every sum below is built so that it exchanges F_0 and F_1 bit
   for bit.

   pt, r2pt, r3pt, t2pt, t3pt: the law holds at fixed control points, the ends and for two of them the middle.
   With stresses s0, sm, s1 there,  F_0 = L (c1 s0 + cm sm + c2 s1), and F_1 with s0 and s1 exchanged. Only pt
   derives from a potential; r2pt, r3pt, t2pt, t3pt make or lose energy on a partly open contact. tptm:
   control points where the law is violated; the piecewise linear diagram is integrated exactly.

   Failure. The trial field before any return decides which places fail; broken[k] is the part of L, from end
   k, that has. Two points: an end owns half of L. Three: the ends own a quarter each, the middle the rest,
   booked with the more violated end. tptm: the front is exact. With sigma, tau and the peak limit linear in
   xi, the places that do not fail are those where five linear functions are >= 0, i.e. one interval: fronts
   run in from the ends only.

   Return of shear. The plastic slip is kept at the ends only and so is linear between; a slipping end returns
   to its limit, an open end to zero, so that it closes again without shear. Where a stronger place begins
   inside (behind an open or broken end, or at the middle), a return by the weak limit of the end would unload
   the strong place too: in small steps a partly open contact would never reach its cohesion times its closed
   length, and a front of failure would stop. So the return is scaled back, by one factor 1 - theta for both
   ends, until every such place has what its own law gives for the trial field (ReturnShear). The ends may
   then lie above their limit; the diagram is clipped there. With cohesion 0 and nothing brittle no such place
   exists and theta = 0. Full sliding gives F_s = tan(phi) F_n + c (closed length), a brittle tptm contact
   sheared in one step or in many gives the same, and the answer for the same displacement is the same when
   asked again. */
#pragma once
#include "joint_law.h"

typedef struct {
  Lanes length;
  Lanes u_n[2], u_s[2];     /* in */
  Lanes slip[2], broken[2]; /* in and out: history */
  Lanes sigma[2], tau[2];   /* in: trial stresses; out: stresses at the ends */
  Lanes F_n[2], F_s[2];     /* out */
  Mask state[2];            /* out: ContactState bits */
} LanesContact;

/* A model: shares of end 0 in the stresses s0, sm, s1; the same for a linear field, where the middle is the
   mean of the ends; whether its control points move (tptm). */
typedef struct {
  PetscReal row[3], elastic[2];
  int moving;
} LanesModel;
extern const LanesModel LanesModels[]; /* stress_models.c */

/* value at xi of the line through the end values v */
KERNEL Lanes Line(const Lanes v[2], Lanes xi)
{
  return 0.5 * ((1. - xi) * v[0] + (1. + xi) * v[1]);
}

/* where a line changes sign; outside [-1,1] when it does not */
KERNEL Lanes Crossing(Lanes h0, Lanes h1)
{
  return Select((h0 < 0.) ^ (h1 < 0.), (h0 + h1) / (h0 - h1), LanesOf(2.));
}

/* whether end k has residual strength */
KERNEL Mask EndIsResidual(const Lanes broken[2], int k)
{
  return (broken[k] > 0.) | (broken[1 - k] >= 1.);
}

/* The elastic row, from the trial stresses. */
KERNEL void RespondElastic(const PetscReal row[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * (row[0] * c->sigma[k] + row[1] * c->sigma[1 - k]);
    c->F_s[k] = c->length * (row[0] * c->tau[k] + row[1] * c->tau[1 - k]);
    c->state[k] = (Mask){CONTACT_ELASTIC};
  }
}

/* True where the law holds elastically at both ends and nothing is broken. */
KERNEL Mask IsElastic(const LanesJoint *J, const LanesContact *c)
{
  Mask holds = {-1, -1, -1, -1};
  for (int k = 0; k < 2; k++)
    holds &= (c->sigma[k] <= J->peak.tension) & (c->sigma[k] >= -J->compression) &
             (Absolute(c->tau[k]) <= JointCone(&J->peak, c->sigma[k])) & (c->broken[k] <= 0.);
  return holds | J->elastic;
}

/* ------------------------------------------------------------------------------------ return of shear */

/* A place inside that has its own say in the return of the ends. */
typedef struct {
  Mask counts;
  Lanes xi, limit;
} Hold;

KERNEL Hold HoldAt(Mask counts, Lanes xi, Lanes limit)
{
  return (Hold){counts & (xi > -1.) & (xi < 1.) & (limit > 0.), xi, limit};
}

/* Returns the line tau to the limits of its ends, as far as no hold gets another stress than clip(trial):
   with held = returned + theta (trial - returned), the smallest theta that leaves an elastic hold alone and a
   slipping one at its limit or above. theta = 1 always does; nearly 1 is 1, or rounding would creep into the
   slip. */
KERNEL void ReturnShear(int n_holds, const Hold *holds, const Lanes trial[2], const Lanes limit[2],
                        Lanes held[2])
{
  const Lanes returned[2] = {JointClip(trial[0], limit[0]), JointClip(trial[1], limit[1])};
  Lanes theta = {0.};
  for (int i = 0; i < n_holds; i++) {
    const Lanes most = holds[i].limit, t = Line(trial, holds[i].xi), r = Line(returned, holds[i].xi);
    const Lanes size = Absolute(t), back = Select(t < 0., -r, r);
    const Mask whole = ((size <= most) & (back != size)) | (~(size <= most) & (back > size));
    const Mask part = ~whole & (size > most) & (back < most);
    const Lanes needed = Select(whole, LanesOf(1.), Keep(part, (most - back) / (size - back)));
    theta = Select(holds[i].counts & (theta < needed), needed, theta);
  }
  for (int k = 0; k < 2; k++)
    held[k] = Select(theta > 1. - 1e-12, trial[k], returned[k] + theta * (trial[k] - returned[k]));
}

/* Books what was returned as plastic slip; untouched where nothing was, so that it cannot drift by rounding.
 */
KERNEL void AdvanceSlip(const LanesJoint *J, const Lanes trial[2], const Lanes held[2], LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    const Lanes slip = Select(held[k] == 0., c->u_s[k], c->slip[k] + (trial[k] - held[k]) / J->k_s);
    c->slip[k] = Select(held[k] == trial[k], c->slip[k], slip);
  }
}

/* sigma, tau and state at the ends, from the trial stresses and the strengths there */
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

/* --------------------------------------------------------------------- models with fixed control points */

/* Updates broken[] from the trial stresses; middle: the model has a third control point. */
KERNEL void BreakPoints(const LanesJoint *J, int middle, const Lanes sigma[2], const Lanes tau[2],
                        Lanes broken[2])
{
  const Lanes part = LanesOf(middle ? 0.25 : 0.5);
  const Mask whole = (broken[0] > 0.5) | (broken[1] > 0.5);
  for (int k = 0; k < 2; k++)
    broken[k] = Select(J->brittle & (broken[k] < part) & JointFails(J, sigma[k], tau[k]), part, broken[k]);
  if (!middle) return;

  /* the middle goes with the end more violated by the criterion that fails there; with both when there is
     none, to treat them alike */
  const Lanes sm = Line(sigma, LanesOf(0.)), tm = Line(tau, LanesOf(0.));
  const Mask fails = J->brittle & ~whole & JointFails(J, sm, tm), opens = JointIsOpen(&J->peak, sm);
  Lanes violation[2];
  for (int k = 0; k < 2; k++)
    violation[k] = Select(opens, sigma[k] - J->peak.tension,
                          Absolute(tau[k]) - JointCone(&J->peak, JointNormal(J, &J->peak, sigma[k])));
  for (int k = 0; k < 2; k++)
    broken[k] = Select(fails & (violation[k] >= violation[1 - k]) & (broken[k] < 0.75), LanesOf(0.75),
                       broken[k]);
}

/* The middle has a say when its state differs from an end's and it can bear more than the line between the
   ends. */
KERNEL Hold HoldMiddle(const LanesJoint *J, const Lanes sigma[2], const Lanes broken[2], Mask residual,
                       const Lanes limit[2])
{
  const LanesStrength strength = StrengthOf(J, residual);
  const Lanes sm = Line(sigma, LanesOf(0.)), most = JointShearLimit(J, &strength, sm);
  Mask differs = {0};
  for (int k = 0; k < 2; k++) {
    const Mask end = EndIsResidual(broken, k);
    const LanesStrength there = StrengthOf(J, end);
    differs |= (end ^ residual) | (JointIsOpen(&there, sigma[k]) ^ JointIsOpen(&strength, sm)) |
               (JointIsCrushing(J, sigma[k]) ^ JointIsCrushing(J, sm));
  }
  return HoldAt(differs & ((J->brittle & ~residual) | (most > 0.5 * (limit[0] + limit[1]))), LanesOf(0.),
                most);
}

KERNEL void RespondFixed(const LanesJoint *J, const PetscReal row[3], LanesContact *c)
{
  const int middle = row[1] > 0.;
  const Lanes sigma[2] = {c->sigma[0], c->sigma[1]}, tau[2] = {c->tau[0], c->tau[1]};
  Lanes limit[2], held[2], sm = {0.}, tm = {0.};
  Hold hold = {{0}, {0.}, {0.}};

  /* failure, with the trial stresses */
  if (Any(J->brittle)) BreakPoints(J, middle, sigma, tau, c->broken);
  const Mask residual = (c->broken[0] > 0.5) | (c->broken[1] > 0.5);
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    limit[k] = JointShearLimit(J, &strength, sigma[k]);
  }

  /* return of shear */
  if (middle) hold = HoldMiddle(J, sigma, c->broken, residual, limit);
  ReturnShear(middle, &hold, tau, limit, held);
  EndStresses(J, sigma, tau, c);
  AdvanceSlip(J, tau, held, c);

  /* forces */
  if (middle) {
    const LanesStrength strength = StrengthOf(J, residual);
    const Lanes s = Line(sigma, LanesOf(0.));
    sm = JointNormal(J, &strength, s);
    tm = JointClip(Line(held, LanesOf(0.)), JointShearLimit(J, &strength, s));
  }
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * (row[0] * c->sigma[k] + row[1] * sm + row[2] * c->sigma[1 - k]);
    c->F_s[k] = c->length * (row[0] * c->tau[k] + row[1] * tm + row[2] * c->tau[1 - k]);
  }
}

/* ------------------------------------------------------------------------------------------- tptm */

/* Moving points: a contact that slips in part keeps its slip; the diagram is cut where it exceeds the limit.
   Slip linear between the ends cannot follow a part that slips beside one that holds, and returning the
   slipping end would relieve the holding part as well (5 % of tau near the heel of a dam). Only when both
   ends are at their limits, one way, does the whole line return. */
KERNEL Mask SlidesWhole(const Lanes trial[2], const Lanes limit[2])
{
  return ((limit[0] <= 0.) | (Absolute(trial[0]) > limit[0])) &
         ((limit[1] <= 0.) | (Absolute(trial[1]) > limit[1])) & (trial[0] * trial[1] >= 0.);
}

/* The unbroken part is within h >= 0, h linear with end values h0, h1: moves the fronts up to there. */
KERNEL void GrowFronts(Mask counts, Lanes h0, Lanes h1, Lanes broken[2])
{
  const Mask low[2] = {h0 < 0., h1 < 0.};
  const Lanes xi = Crossing(h0, h1);
  const Lanes part[2] = {Select(low[1], LanesOf(1.), 0.5 * (1. + xi)),
                         Select(low[0], LanesOf(1.), 0.5 * (1. - xi))};
  for (int k = 0; k < 2; k++) broken[k] = Select(counts & low[k] & (broken[k] < part[k]), part[k], broken[k]);
}

/* Fronts of failure: tension, both signs of shear, and shear where compression is cut off. */
KERNEL void BreakFronts(const LanesJoint *J, const Lanes s[2], const Lanes t[2], Lanes broken[2])
{
  const Lanes T = J->peak.tension, c[2] = {JointCone(&J->peak, s[0]), JointCone(&J->peak, s[1])};
  const Lanes most = JointCone(&J->peak, -J->compression);
  const Mask sheared = J->brittle & ((t[0] != 0.) | (t[1] != 0.));
  const Mask crushing = sheared & (JointIsCrushing(J, s[0]) | JointIsCrushing(J, s[1]));
  GrowFronts(J->brittle, T - s[0], T - s[1], broken);
  GrowFronts(sheared, c[0] - t[0], c[1] - t[1], broken);
  GrowFronts(sheared, c[0] + t[0], c[1] + t[1], broken);
  GrowFronts(crushing, most - t[0], most - t[1], broken);
  GrowFronts(crushing, most + t[0], most + t[1], broken);
  const Mask through = J->brittle & (broken[0] + broken[1] >= 1.);
  for (int k = 0; k < 2; k++) broken[k] = Select(through, LanesOf(1.), broken[k]);
}

/* Places with a say in the return of shear: a closing point or a front behind which the limit steps up, and
   the kink of the limit at crushing. Returns how many. */
KERNEL int FindHolds(const LanesJoint *J, const Lanes s[2], const Lanes front[2], Hold holds[4])
{
  const Lanes T = J->residual.tension, C = J->compression;
  const Mask broken = front[0] >= front[1]; /* all of it */
  Lanes xi = Crossing(T - s[0], T - s[1]);
  int n = 0;
  holds[n++] = HoldAt(~J->brittle | (xi < front[0]) | (xi > front[1]), xi, JointCone(&J->residual, T));
  const Mask crushing = JointIsCrushing(J, s[0]) ^ JointIsCrushing(J, s[1]);
  if (Any(crushing)) {
    xi = Crossing(C + s[0], C + s[1]);
    const LanesStrength strength = StrengthOf(J, (xi < front[0]) | (xi > front[1]));
    holds[n++] = HoldAt(crushing, xi, JointCone(&strength, -C));
  }
  if (Any(J->brittle))
    for (int k = 0; k < 2; k++)
      holds[n++] = HoldAt(~broken, front[k],
                          JointCone(&J->peak, JointNormal(J, &J->peak, Line(s, front[k]))));
  return n;
}

/* Shares of the two ends in a diagram over a length of 1: what a force of linear density a .. b gives to each
   end by the lever, int v (1 - x) dx and int v x dx. */
typedef struct {
  Lanes at[2];
} Shares;

KERNEL Shares LinearShares(Lanes a, Lanes b)
{
  return (Shares){{(1. / 6.) * (2. * a + b), (1. / 6.) * (a + 2. * b)}};
}

/* Length of the part of [0,1] where the line from a to b is positive; 0 where neither end is. */
KERNEL Lanes PositivePart(Lanes a, Lanes b)
{
  const Mask first = a > b;
  const Lanes high = NotNegative(Select(first, a, b)), low = NotNegative(-Select(first, b, a));
  return high / (high + low + 1e-300);
}

/* Shares of the positive part of a line. With a > 0 > b it is a triangle of length w: a w (3 - w)/6 and a
   w^2/6; with both positive w = 1, and the two triangles add up to LinearShares. */
KERNEL Shares PositiveShares(Lanes a, Lanes b)
{
  const Lanes w = PositivePart(a, b), near = (1. / 6.) * w * (3. - w), far = (1. / 6.) * w * w;
  const Lanes p = NotNegative(a), q = NotNegative(b);
  return (Shares){{p * near + q * far, p * far + q * near}};
}

/* A part of [0,1], with its distances from the other end: 1 - (1 - x) is not x in floating point. */
typedef struct {
  Lanes from, to, length;
  Lanes after, before; /* 1 - from, 1 - to */
} Interval;

/* Shares over a part, in terms of the whole. */
KERNEL Shares SharesOfPart(const Interval *part, Shares local)
{
  return (Shares){{part->length * (local.at[0] * part->after + local.at[1] * part->before),
                   part->length * (local.at[0] * part->from + local.at[1] * part->to)}};
}

/* Shear over the part of a piece where the line h is positive: tau cut at the cone, both given at the ends of
   the piece. int clip(tau) = int tau - int (tau - cone)+ + int (-tau - cone)+ . most: shares of the cone. */
KERNEL Shares ShearShares(const Lanes h[2], const Lanes tau[2], const Lanes cone[2], Shares *most)
{
  const Mask not_at[2] = {h[0] < 0., h[1] < 0.};
  const Lanes w = PositivePart(h[0], h[1]), one = LanesOf(1.);
  const Interval part = {.from = Keep(not_at[0], 1. - w),
                         .after = Select(not_at[0], w, one),
                         .to = Select(not_at[1], w, one),
                         .before = Keep(not_at[1], 1. - w),
                         .length = Select(not_at[0] | not_at[1], w, one)};
  const Lanes t[2] = {part.after * tau[0] + part.from * tau[1], part.before * tau[0] + part.to * tau[1]};
  const Lanes c[2] = {part.after * cone[0] + part.from * cone[1], part.before * cone[0] + part.to * cone[1]};
  *most = SharesOfPart(&part, LinearShares(c[0], c[1]));
  const Shares line = LinearShares(t[0], t[1]), over = PositiveShares(t[0] - c[0], t[1] - c[1]),
               under = PositiveShares(-t[0] - c[0], -t[1] - c[1]);
  return SharesOfPart(
      &part, (Shares){{line.at[0] + (under.at[0] - over.at[0]), line.at[1] + (under.at[1] - over.at[1])}});
}

/* Diagrams of one piece of one strength, lines sigma and tau given at its ends. sigma = T - (T - sigma)+ +
   (-C - sigma)+ ; shear is zero where the joint is open or beyond the apex of the cone. */
KERNEL void PieceShares(const LanesJoint *J, const LanesStrength *strength, const Lanes sigma[2],
                        const Lanes tau[2], Shares *normal, Shares *shear, Shares *most)
{
  const Lanes T = strength->tension, C = J->compression;
  const Mask sloped = strength->tan_phi > 0.;
  const Lanes apex = Select(sloped, strength->cohesion / Select(sloped, strength->tan_phi, LanesOf(1.)), T);
  const Lanes end = Select(apex < T, apex, T); /* of shear */
  const Lanes h[2] = {end - sigma[0], end - sigma[1]};
  const Lanes cone[2] = {JointCone(strength, sigma[0]), JointCone(strength, sigma[1])};
  const Shares below = PositiveShares(T - sigma[0], T - sigma[1]);
  for (int k = 0; k < 2; k++) normal->at[k] = 0.5 * T - below.at[k];
  *shear = ShearShares(h, tau, cone, most);
  if (!Any(JointIsCrushing(J, sigma[0]) | JointIsCrushing(J, sigma[1]))) return;

  /* where it is crushed the cone is that of -C: the shear there is taken out and put in again */
  const Lanes crushed[2] = {-C - sigma[0], -C - sigma[1]}, limit = JointCone(strength, -C);
  const Shares under = PositiveShares(crushed[0], crushed[1]);
  const Lanes limits[2] = {limit, limit};
  Shares most_out, most_in;
  const Shares out = ShearShares(crushed, tau, cone, &most_out),
               in = ShearShares(crushed, tau, limits, &most_in);
  for (int k = 0; k < 2; k++) {
    normal->at[k] += under.at[k];
    shear->at[k] += in.at[k] - out.at[k];
    most->at[k] += most_in.at[k] - most_out.at[k];
  }
}

/* The whole diagram: in the middle what has not failed, at the ends what has. Each end sums from its own
   side, so that exchanged ends sum alike. sum: shares of sigma, of tau, and of the most that tau can be. */
KERNEL void DiagramShares(const LanesJoint *J, const Lanes sigma[2], const Lanes tau[2], const Lanes front[2],
                          Shares sum[3])
{
  if (!Any(J->brittle)) {
    PieceShares(J, &J->peak, sigma, tau, &sum[0], &sum[1], &sum[2]);
    return;
  }
  /* a contact broken through is one piece of residual strength */
  const Mask through = front[0] >= front[1];
  const Lanes cut[4] = {LanesOf(-1.), Select(through, LanesOf(1.), front[0]),
                        Select(through, LanesOf(1.), front[1]), LanesOf(1.)};
  Shares of[3][3]; /* [piece][what] */
  for (int i = 0; i < 3; i++) {
    const Interval part = {.from = 0.5 * (1. + cut[i]),
                           .after = 0.5 * (1. - cut[i]),
                           .to = 0.5 * (1. + cut[i + 1]),
                           .before = 0.5 * (1. - cut[i + 1]),
                           .length = 0.5 * (cut[i + 1] - cut[i])};
    const Lanes s[2] = {Line(sigma, cut[i]), Line(sigma, cut[i + 1])};
    const Lanes t[2] = {Line(tau, cut[i]), Line(tau, cut[i + 1])};
    PieceShares(J, i == 1 ? &J->peak : &J->residual, s, t, &of[i][0], &of[i][1], &of[i][2]);
    for (int what = 0; what < 3; what++) of[i][what] = SharesOfPart(&part, of[i][what]);
  }
  for (int what = 0; what < 3; what++)
    for (int k = 0; k < 2; k++)
      sum[what].at[k] = (of[2 * k][what].at[k] + of[1][what].at[k]) + of[2 - 2 * k][what].at[k];
}

/* In time: each end force F_s is an elastic-plastic spring with the limit of its share of the joint, because
   clipping a line that keeps its slip has no memory and makes energy where N changes while a part slips. The
   nearest point of the box |F_s| <= most to the trial forces in the metric of the elastic row L/6 [2 1; 1 2]:
   slip is then normal to the box, which holds F_s = 0, and F_s . d(slip) >= 0. From either end: that end at
   its limit, then the other; right when the first stays where it is, and else from the other end. held: the
   line of shear that has these end forces. */
KERNEL void ReturnForces(Lanes length, const Lanes trial[2], const Lanes most[2], Lanes F[2], Lanes held[2])
{
  Lanes T[2], from[2][2];
  Mask right[2];
  for (int k = 0; k < 2; k++) T[k] = length * (2. * trial[k] + trial[1 - k]) * (1. / 6.);
  for (int a = 0; a < 2; a++) {
    const int b = 1 - a;
    from[a][a] = JointClip(T[a], most[a]);
    from[a][b] = JointClip(T[b] + 0.5 * (from[a][a] - T[a]), most[b]);
    right[a] = JointClip(T[a] + 0.5 * (from[a][b] - T[b]), most[a]) == from[a][a];
  }
  /* the end that is farther out first */
  const Mask second = Absolute(T[1]) - most[1] > Absolute(T[0]) - most[0];
  const Mask from_0 = (~second & right[0]) | (second & ~right[1]);
  for (int k = 0; k < 2; k++) F[k] = Select(from_0, from[0][k], from[1][k]);
  const Mask same = (F[0] == T[0]) & (F[1] == T[1]);
  for (int k = 0; k < 2; k++) held[k] = Select(same, trial[k], (4. * F[k] - 2. * F[1 - k]) / length);
}

/* in_time: of a dynamic stage, where partial slip may make no energy. A joint that can still break keeps the
   diagram, which the fronts of failure need. */
KERNEL void RespondMoving(const LanesJoint *J, int in_time, LanesContact *c)
{
  const Lanes sigma[2] = {c->sigma[0], c->sigma[1]}, tau[2] = {c->tau[0], c->tau[1]};
  const Mask forces = in_time ? ~J->brittle | (c->broken[0] >= 1.) : (Mask){0};
  Lanes limit[2], held[2] = {tau[0], tau[1]}, most[2];
  Shares sum[3];

  /* failure, with the trial stresses */
  if (Any(J->brittle)) BreakFronts(J, sigma, tau, c->broken);
  const Lanes front[2] = {2. * c->broken[0] - 1., 1. - 2. * c->broken[1]};

  /* return of shear */
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    limit[k] = JointShearLimit(J, &strength, sigma[k]);
  }
  const Mask slides = SlidesWhole(tau, limit) & ~forces;
  if (Any(slides)) {
    Hold holds[4];
    Lanes returned[2];
    const int n = FindHolds(J, sigma, front, holds);
    ReturnShear(n, holds, tau, limit, returned);
    for (int k = 0; k < 2; k++) held[k] = Select(slides, returned[k], tau[k]);
  }
  EndStresses(J, sigma, tau, c);

  /* forces */
  DiagramShares(J, sigma, held, front, sum);
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * sum[0].at[k];
    c->F_s[k] = c->length * sum[1].at[k];
    most[k] = c->length * sum[2].at[k];
  }
  if (in_time) {
    Lanes F[2], line[2];
    ReturnForces(c->length, tau, most, F, line);
    for (int k = 0; k < 2; k++) {
      c->F_s[k] = Select(forces, F[k], c->F_s[k]);
      held[k] = Select(forces, line[k], held[k]);
    }
  }
  AdvanceSlip(J, tau, held, c);
}

/* ------------------------------------------------------------------------------------------------ */

/* Stresses, history, state and end forces from u_n, u_s and the history. All lanes take the elastic row; only
   when a lane's law does not hold elastically is the model asked, and answers for those lanes. Returns
   whether the history may have changed. */
KERNEL int RespondContacts(const LanesJoint *J, const LanesModel *model, int in_time, LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->sigma[k] = J->k_n * c->u_n[k];              /* (5) */
    c->tau[k] = J->k_s * (c->u_s[k] - c->slip[k]); /* (6) */
  }
  const Mask elastic = IsElastic(J, c);
  LanesContact other = *c;
  RespondElastic(model->elastic, c);
  if (!Any(~elastic)) return 0;
  if (model->moving)
    RespondMoving(J, in_time, &other);
  else
    RespondFixed(J, model->row, &other);
  for (int k = 0; k < 2; k++) {
    c->slip[k] = Select(elastic, c->slip[k], other.slip[k]);
    c->broken[k] = Select(elastic, c->broken[k], other.broken[k]);
    c->sigma[k] = Select(elastic, c->sigma[k], other.sigma[k]);
    c->tau[k] = Select(elastic, c->tau[k], other.tau[k]);
    c->F_n[k] = Select(elastic, c->F_n[k], other.F_n[k]);
    c->F_s[k] = Select(elastic, c->F_s[k], other.F_s[k]);
    c->state[k] = (elastic & c->state[k]) | (~elastic & other.state[k]);
  }
  return 1;
}

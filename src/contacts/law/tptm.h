/* tptm.h: computes the response of the stress model tptm, whose control points are where the law is violated.
   It integrates the piecewise linear diagram of stress exactly. The part common to all models is in
   ends.h. */
#pragma once
#include "contacts/law/law.h"
#include "contacts/law/ends.h"

/* Decides whether a contact slides as a whole: both ends are at their limits, in the same direction. Only
   then does the line of shear return. A contact that slips in part keeps its slip, and its diagram is cut
   where it exceeds the limit. The reason: slip that is linear between the ends cannot follow one piece that
   slips beside another that sticks, and a return of the slipping end would relieve the sticking piece as well
   (5 % of tau near the heel of a dam). */
KERNEL Mask SlidesWhole(const Lanes trial[2], const Lanes limit[2])
{
  return ((limit[0] <= 0.) | (Absolute(trial[0]) > limit[0])) &
         ((limit[1] <= 0.) | (Absolute(trial[1]) > limit[1])) & (trial[0] * trial[1] >= 0.);
}

/* Moves the fronts up to where the line h with end values h0, h1 changes sign; places where h < 0 fail. */
KERNEL void GrowFronts(Mask counts, Lanes h0, Lanes h1, Lanes broken[2])
{
  const Mask low[2] = {h0 < 0., h1 < 0.};
  const Lanes xi = Crossing(h0, h1);
  const Lanes part[2] = {Select(low[1], LanesOf(1.), 0.5 * (1. + xi)),
                         Select(low[0], LanesOf(1.), 0.5 * (1. - xi))};
  for (int k = 0; k < 2; k++) broken[k] = Select(counts & low[k] & (broken[k] < part[k]), part[k], broken[k]);
}

/* Moves the fronts of failure by tension, by shear of both signs, and by shear where compression is cut
   off. */
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

/* Finds the places that limit the return of shear: the point where the joint closes or a front, behind which
   the limit steps up, and the kink of the limit where crushing begins. Returns how many. */
KERNEL int FindStrongPlaces(const LanesJoint *J, const Lanes s[2], const Lanes front[2],
                            StrongPlace places[4])
{
  const Lanes T = J->residual.tension, C = J->compression;
  const Mask broken = front[0] >= front[1]; /* along the whole length */
  Lanes xi = Crossing(T - s[0], T - s[1]);
  int n = 0;
  places[n++] = StrongPlaceAt(~J->brittle | (xi < front[0]) | (xi > front[1]), xi,
                              JointCone(&J->residual, T));
  const Mask crushing = JointIsCrushing(J, s[0]) ^ JointIsCrushing(J, s[1]);
  if (Any(crushing)) {
    xi = Crossing(C + s[0], C + s[1]);
    const LanesStrength strength = StrengthOf(J, (xi < front[0]) | (xi > front[1]));
    places[n++] = StrongPlaceAt(crushing, xi, JointCone(&strength, -C));
  }
  if (Any(J->brittle))
    for (int k = 0; k < 2; k++)
      places[n++] = StrongPlaceAt(~broken, front[k],
                                  JointCone(&J->peak, JointNormal(J, &J->peak, Line(s, front[k]))));
  return n;
}

/* Shares of the two ends in a diagram v over a length of 1, by the lever rule: int v (1 - x) dx and int v x
   dx. */
typedef struct {
  Lanes at[2];
} Shares;

/* Returns the shares of a line from a to b. */
KERNEL Shares LinearShares(Lanes a, Lanes b)
{
  return (Shares){{(1. / 6.) * (2. * a + b), (1. / 6.) * (a + 2. * b)}};
}

/* Returns the length of the stretch of [0,1] where the line from a to b is positive; 0 where neither end
   is. */
KERNEL Lanes PositivePart(Lanes a, Lanes b)
{
  const Mask first = a > b;
  const Lanes high = NotNegative(Select(first, a, b)), low = NotNegative(-Select(first, b, a));
  return high / (high + low + 1e-300);
}

/* Returns the shares of the positive values of a line. With a > 0 > b they are a triangle of length w, which
   has the shares a w (3 - w)/6 and a w^2/6. With both ends positive w = 1, and two triangles add up to
   LinearShares. */
KERNEL Shares PositiveShares(Lanes a, Lanes b)
{
  const Lanes w = PositivePart(a, b), near = (1. / 6.) * w * (3. - w), far = (1. / 6.) * w * w;
  const Lanes p = NotNegative(a), q = NotNegative(b);
  return (Shares){{p * near + q * far, p * far + q * near}};
}

/* A stretch of [0,1]. It keeps its distances from both ends, because 1 - (1 - x) is not x in floating
   point. */
typedef struct {
  Lanes from, to, length;
  Lanes after, before; /* 1 - from, 1 - to */
} Interval;

/* Converts the shares `local` of the ends of the stretch `part` to shares of the ends of [0,1]. */
KERNEL Shares SharesOfPart(const Interval *part, Shares local)
{
  return (Shares){{part->length * (local.at[0] * part->after + local.at[1] * part->before),
                   part->length * (local.at[0] * part->from + local.at[1] * part->to)}};
}

/* Returns the shares of shear on the stretch of a piece where the line h is positive: tau cut off at the
   cone. tau and cone are given at the ends of the piece. int clip(tau) = int tau - int (tau - cone)+ + int
   (-tau - cone)+ . most: shares of the cone. */
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

/* Computes the shares of normal stress, of shear and of the largest possible shear on one piece of one
   strength. sigma and tau are lines given at the ends of the piece. The normal stress is T - (T - sigma)+ +
   (-C - sigma)+ . Shear is zero where the joint is open and beyond the apex of the cone. */
KERNEL void PieceShares(const LanesJoint *J, const LanesStrength *strength, const Lanes sigma[2],
                        const Lanes tau[2], Shares *normal, Shares *shear, Shares *most)
{
  const Lanes T = strength->tension, C = J->compression;
  const Mask sloped = strength->tan_phi > 0.;
  const Lanes apex = Select(sloped, strength->cohesion / Select(sloped, strength->tan_phi, LanesOf(1.)), T);
  const Lanes end = Select(apex < T, apex, T); /* the sigma at which shear ends */
  const Lanes h[2] = {end - sigma[0], end - sigma[1]};
  const Lanes cone[2] = {JointCone(strength, sigma[0]), JointCone(strength, sigma[1])};
  const Shares below = PositiveShares(T - sigma[0], T - sigma[1]);
  for (int k = 0; k < 2; k++) normal->at[k] = 0.5 * T - below.at[k];
  *shear = ShearShares(h, tau, cone, most);
  if (!Any(JointIsCrushing(J, sigma[0]) | JointIsCrushing(J, sigma[1]))) return;

  /* where the piece is crushed the cone has the height at -C: the shear there is subtracted and added
     again */
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

/* Computes the shares of the whole diagram. sum: shares of sigma, of tau, and of the largest possible tau.
   The diagram has three pieces: the middle has not failed, the ends have. Each end sums from its own side, so
   that exchanged ends have the same sum. */
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

/* -------------------------------------------------------------------------------- what was crushed */

/* The trial stress of a contact that was crushed, in three pieces: line i from cut[i] to cut[i+1], where it
   is the largest of the three. */
typedef struct {
  Lanes sigma[3][2], cut[4];
} Pieces;

KERNEL Pieces PiecesOf(const LanesJoint *J, const LanesContact *c)
{
  const Lanes one = LanesOf(1.), p[2] = {-c->closure[0], -c->far[0]}, q[2] = {-c->far[1], -c->closure[1]};
  const Mask first = (p[0] > 0.) & ((p[0] > q[0]) | ((p[0] == q[0]) & (p[1] >= q[1])));
  const Mask last = (q[1] > 0.) & ((q[1] > p[1]) | ((q[1] == p[1]) & (q[0] > p[0])));
  const Mask meet = first & last & (p[0] > q[0]) & (q[1] > p[1]);
  const Lanes meeting = Crossing(p[0] - q[0], p[1] - q[1]);
  Lanes a = Select(p[1] < 0., Crossing(p[0], p[1]), one), b = Select(q[0] < 0., Crossing(q[0], q[1]), -one);
  a = Select(meet & (meeting < a), meeting, a), b = Select(meet & (meeting > b), meeting, b);
  Pieces pieces = {.cut = {-one, Select(first, a, -one), Select(last, b, one), one}};
  for (int k = 0; k < 2; k++) {
    pieces.sigma[0][k] = J->k_n * (c->u_n[k] + p[k]);
    pieces.sigma[1][k] = J->k_n * c->u_n[k];
    pieces.sigma[2][k] = J->k_n * (c->u_n[k] + q[k]);
  }
  return pieces;
}

/* Finds places as FindStrongPlaces in each piece, and the kinks between the pieces, where the limit bends. */
KERNEL int FindStrongPlacesOfPieces(const LanesJoint *J, const Pieces *pieces, const Lanes front[2],
                                    StrongPlace places[14])
{
  int n = 0;
  for (int i = 0; i < 3; i++)
    for (const int end = n + FindStrongPlaces(J, pieces->sigma[i], front, places + n); n < end; n++)
      places[n].counts &= (places[n].xi >= pieces->cut[i]) & (places[n].xi <= pieces->cut[i + 1]);
  for (int i = 0; i < 3; i += 2) {
    const Lanes xi = pieces->cut[i ? 2 : 1];
    const LanesStrength strength = StrengthOf(J, J->brittle & ((xi < front[0]) | (xi > front[1])));
    places[n++] = StrongPlaceAt((Mask){-1, -1, -1, -1}, xi,
                                JointShearLimit(J, &strength, Line(pieces->sigma[i], xi)));
  }
  return n;
}

/* Computes the shares of both ends of the contact in a piece of one strength between the places `from` and
   `to`; zero where `to` is before `from`. */
KERNEL void SharesBetween(const LanesJoint *J, const LanesStrength *strength, const Lanes sigma[2],
                          const Lanes tau[2], Lanes from, Lanes to, Shares sum[3])
{
  const Lanes end = Select(to < from, from, to);
  const Interval part = {.from = 0.5 * (1. + from),
                         .after = 0.5 * (1. - from),
                         .to = 0.5 * (1. + end),
                         .before = 0.5 * (1. - end),
                         .length = 0.5 * (end - from)};
  const Lanes s[2] = {Line(sigma, from), Line(sigma, end)}, t[2] = {Line(tau, from), Line(tau, end)};
  PieceShares(J, strength, s, t, &sum[0], &sum[1], &sum[2]);
  for (int what = 0; what < 3; what++) sum[what] = SharesOfPart(&part, sum[what]);
}

/* Does the same as DiagramShares for a contact that was crushed: sums over every piece of the trial stress,
   and in each over the parts that have and have not failed. */
KERNEL void SharesOfPieces(const LanesJoint *J, const Pieces *pieces, const Lanes tau[2],
                           const Lanes front[2], Shares sum[3])
{
  const Mask through = front[0] >= front[1];
  const Lanes one = LanesOf(1.), zero = LanesOf(0.);
  const Lanes cut[4] = {-one, Select(through, one, Select(J->brittle, front[0], -one)),
                        Select(through, one, Select(J->brittle, front[1], one)), one};
  Shares total[3][3] = {{{{zero, zero}}}}, of[3][3]; /* [piece][what] */
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      const Lanes from = Select(pieces->cut[i] > cut[j], pieces->cut[i], cut[j]),
                  to = Select(pieces->cut[i + 1] < cut[j + 1], pieces->cut[i + 1], cut[j + 1]);
      SharesBetween(J, j == 1 ? &J->peak : &J->residual, pieces->sigma[i], tau, from, to, of[j]);
    }
    for (int what = 0; what < 3; what++)
      for (int k = 0; k < 2; k++)
        total[i][what].at[k] = (of[2 * k][what].at[k] + of[1][what].at[k]) + of[2 - 2 * k][what].at[k];
  }
  for (int what = 0; what < 3; what++)
    for (int k = 0; k < 2; k++)
      sum[what].at[k] = (total[2 * k][what].at[k] + total[1][what].at[k]) + total[2 - 2 * k][what].at[k];
}

/* ------------------------------------------------------------------------------------------ dashpots */

/* Returns the shares of the stress that dashpots add where the line s of the springs is negative. */
KERNEL Shares DashpotShares(const LanesJoint *J, const Lanes s[2], const Lanes dashpot[2])
{
  const Mask open[2] = {s[0] >= 0., s[1] >= 0.};
  const Lanes w = PositivePart(-s[0], -s[1]), one = LanesOf(1.),
              C = Select(J->elastic, LanesOf(NO_LIMIT), J->compression);
  const Interval part = {.from = Keep(open[0], 1. - w),
                         .after = Select(open[0], w, one),
                         .to = Select(open[1], w, one),
                         .before = Keep(open[1], 1. - w),
                         .length = Select(open[0] | open[1], w, one)};
  Lanes in[2], d[2], both[2];
  in[0] = part.after * s[0] + part.from * s[1], in[1] = part.before * s[0] + part.to * s[1];
  d[0] = part.after * dashpot[0] + part.from * dashpot[1];
  d[1] = part.before * dashpot[0] + part.to * dashpot[1];
  for (int k = 0; k < 2; k++) both[k] = in[k] + d[k];
  const Shares line = LinearShares(d[0], d[1]), pulls = PositiveShares(both[0], both[1]),
               beyond = PositiveShares(-C - both[0], -C - both[1]),
               before = PositiveShares(-C - in[0], -C - in[1]);
  Shares sum;
  for (int k = 0; k < 2; k++) sum.at[k] = (line.at[k] - pulls.at[k]) + (beyond.at[k] - before.at[k]);
  return SharesOfPart(&part, sum);
}

/* Does the same as DashpotShares for a contact that was crushed. */
KERNEL Shares DashpotSharesOfPieces(const LanesJoint *J, const Pieces *pieces, const Lanes dashpot[2])
{
  Shares of[3], sum;
  for (int i = 0; i < 3; i++) {
    const Lanes from = pieces->cut[i], to = pieces->cut[i + 1], end = Select(to < from, from, to);
    const Interval part = {.from = 0.5 * (1. + from),
                           .after = 0.5 * (1. - from),
                           .to = 0.5 * (1. + end),
                           .before = 0.5 * (1. - end),
                           .length = 0.5 * (end - from)};
    const Lanes s[2] = {Line(pieces->sigma[i], from), Line(pieces->sigma[i], end)};
    const Lanes d[2] = {Line(dashpot, from), Line(dashpot, end)};
    of[i] = SharesOfPart(&part, DashpotShares(J, s, d));
  }
  for (int k = 0; k < 2; k++) sum.at[k] = (of[2 * k].at[k] + of[1].at[k]) + of[2 - 2 * k].at[k];
  return sum;
}

/* -------------------------------------------------------------------------------------------------- */

/* Returns the shear in time. Each end force F_s is an elastic-plastic spring, limited by its share `most` of
   the joint. Clipping a line that keeps its slip would have no memory, and would make energy where N changes
   while a piece slips. kept: the line of shear that has these end forces. */
KERNEL void ReturnInTime(Lanes length, const Lanes trial[2], const Lanes most[2], Lanes F[2], Lanes kept[2])
{
  Lanes T[2];
  for (int k = 0; k < 2; k++) T[k] = length * (2. * trial[k] + trial[1 - k]) * (1. / 6.);
  ReturnForces(0.5, T, most, F);
  const Mask same = (F[0] == T[0]) & (F[1] == T[1]);
  for (int k = 0; k < 2; k++) kept[k] = Select(same, trial[k], (4. * F[k] - 2. * F[1 - k]) / length);
}

/* Computes the response of tptm. in_time: partial slip must not make energy (see law.h), so end forces are
   the forces of springs. A joint that can still break keeps the diagram instead, which the fronts of failure
   need. */
KERNEL void RespondMoving(const LanesJoint *J, int in_time, int closes, int damped, LanesContact *c)
{
  const Lanes sigma[2] = {c->sigma[0], c->sigma[1]}, tau[2] = {c->tau[0], c->tau[1]};
  Lanes total[2] = {sigma[0], sigma[1]}; /* stresses with dashpots */
  const Mask forces = in_time ? ~J->brittle | (c->broken[0] >= 1.) : (Mask){0};
  Lanes limit[2], kept[2] = {tau[0], tau[1]};
  Shares sum[3];
  Shares dashpots;
  Pieces pieces;
  if (closes) pieces = PiecesOf(J, c);
  if (damped) {
    for (int k = 0; k < 2; k++) total[k] += DashpotStress(J, sigma[k], c->dashpot[k]);
    dashpots = closes ? DashpotSharesOfPieces(J, &pieces, c->dashpot) : DashpotShares(J, sigma, c->dashpot);
  }

  /* failure, by the trial stresses */
  if (Any(J->brittle)) {
    if (closes)
      for (int i = 0; i < 3; i++) BreakFronts(J, pieces.sigma[i], tau, c->broken);
    else
      BreakFronts(J, sigma, tau, c->broken);
  }
  const Lanes front[2] = {2. * c->broken[0] - 1., 1. - 2. * c->broken[1]};

  /* return of shear */
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    limit[k] = JointShearLimit(J, &strength, total[k]);
  }
  const Mask slides = SlidesWhole(tau, limit) & ~forces;
  if (Any(slides)) {
    StrongPlace places[14];
    Lanes returned[2];
    const int n = closes ? FindStrongPlacesOfPieces(J, &pieces, front, places)
                         : FindStrongPlaces(J, sigma, front, places);
    ReturnShear(n, places, tau, limit, returned);
    for (int k = 0; k < 2; k++) kept[k] = Select(slides, returned[k], tau[k]);
  }
  EndStresses(J, total, tau, c);
  if (damped) SpringStresses(J, sigma, c);

  /* forces */
  if (closes)
    SharesOfPieces(J, &pieces, kept, front, sum);
  else
    DiagramShares(J, sigma, kept, front, sum);
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * sum[0].at[k];
    c->F_s[k] = c->length * sum[1].at[k];
    c->most[k] = c->length * sum[2].at[k];
    if (damped) {
      const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
      c->most[k] = NotNegative(c->most[k] - c->length * strength.tan_phi * dashpots.at[k]);
      const Mask works = (c->dashpot[0] != 0.) | (c->dashpot[1] != 0.);
      c->F_s[k] = Select(works, JointClip(c->F_s[k], c->most[k]), c->F_s[k]);
    }
  }
  if (in_time) {
    Lanes F[2], line[2];
    ReturnInTime(c->length, tau, c->most, F, line);
    for (int k = 0; k < 2; k++) {
      c->F_s[k] = Select(forces, F[k], c->F_s[k]);
      kept[k] = Select(forces, line[k], kept[k]);
    }
  }
  AdvanceSlip(J, tau, kept, c);
}

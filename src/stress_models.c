/* stress_models.c: from openings and slips at the two ends of ONE contact to the forces at its ends; the six
   integration procedures of section 2.5 of the paper. The slow path: contact_force.c has the vectorised
   elastic row.

   Along the contact xi runs from -1 (end 0) to 1 (end 1); the trial stresses are linear. Exchanging the ends
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
#include "internal.h"
#include "joint_law.h"

const char *const StressModels[] = {"pt",      "r2pt", "r3pt", "t2pt", "t3pt", "tptm", "StressModelKind",
                                    "STRESS_", NULL};

/* Share of end 0 in a stress s0, sm, s1: c1, cm, c2.
   pt:   forces s L/2 at the ends themselves.
   r2pt: s L/2 at L/4 and 3L/4, shared by the lever: 1/2 (3/4, 1/4).
   r3pt: s L/4, s L/2, s L/4 at L/8, L/2, 7L/8: (1/4 7/8, 1/2 1/2, 1/4 1/8).
   t2pt: integral of (1-x)(1-x) and x (1-x).
   t3pt: two trapezoids of L/2: integral of (1-2x)(1-x) over the first half, 1/4 by symmetry, and the rest of
   1/2. tptm: as t2pt where nothing is violated. */
static const PetscReal rows[STRESS_MODELS][3] = {
    [STRESS_PT] = {1. / 2, 0, 0},
    [STRESS_R2PT] = {3. / 8, 0, 1. / 8},
    [STRESS_R3PT] = {7. / 32, 8. / 32, 1. / 32},
    [STRESS_T2PT] = {2. / 6, 0, 1. / 6},
    [STRESS_T3PT] = {5. / 24, 6. / 24, 1. / 24},
    [STRESS_TPTM] = {2. / 6, 0, 1. / 6},
};

void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b)
{
  const PetscReal *row = rows[model];

  /* linear field: the middle is the mean of the ends */
  *a = row[0] + row[1] / 2;
  *b = row[2] + row[1] / 2;
}

PetscBool JointIsElastic(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2],
                         const PetscReal broken[2])
{
  PetscBool holds = PETSC_TRUE;

  if (joint->law == LAW_ELASTIC) return PETSC_TRUE;
  for (int k = 0; k < 2; k++) {
    if (!(sigma[k] <= joint->tension[0] && sigma[k] >= -joint->compression &&
          fabs(tau[k]) <= joint->cohesion[0] - sigma[k] * joint->tan_phi[0] && broken[k] <= 0))
      holds = PETSC_FALSE;
  }
  return holds;
}

/* value at xi of the line through the end values v */
static inline PetscReal Line(const PetscReal v[2], PetscReal xi)
{
  return 0.5 * ((1 - xi) * v[0] + (1 + xi) * v[1]);
}

/* where a line changes sign; outside [-1,1] when it does not */
static inline PetscReal Crossing(PetscReal h0, PetscReal h1)
{
  return (h0 < 0) != (h1 < 0) ? (h0 + h1) / (h0 - h1) : 2;
}

static inline int EndStrength(const PetscReal broken[2], int k)
{
  return broken[k] > 0 || broken[1 - k] >= 1;
}

/* ------------------------------------------------------------------------------------ Return of shear */

/* places inside that have their own say in the return of the ends */
typedef struct {
  int n;
  PetscReal xi[4], limit[4];
} Holds;

static inline void HoldAt(Holds *holds, PetscReal xi, PetscReal limit)
{
  if (!(xi > -1 && xi < 1 && limit > 0)) return;
  holds->xi[holds->n] = xi;
  holds->limit[holds->n++] = limit;
}

/* Returns the line tau to the limits of its ends, as far as no hold gets another stress than clip(trial):
   with held = returned + theta (trial - returned), the smallest theta that leaves an elastic hold alone and a
   slipping one at its limit or above. theta = 1 always does; nearly 1 is 1, or rounding would creep into the
   slip. */
static inline void ReturnShear(const Holds *holds, const PetscReal trial[2], const PetscReal limit[2],
                               PetscReal held[2])
{
  PetscReal returned[2], theta = 0;

  for (int k = 0; k < 2; k++) returned[k] = JointClip(trial[k], limit[k]);
  for (int i = 0; i < holds->n; i++) {
    PetscReal t = Line(trial, holds->xi[i]), r = Line(returned, holds->xi[i]), most = holds->limit[i];

    if (t < 0) t = -t, r = -r;
    if (t <= most ? r != t : r > t)
      theta = 1;
    else if (t > most && r < most && theta < (most - r) / (t - r))
      theta = (most - r) / (t - r);
  }
  for (int k = 0; k < 2; k++) {
    held[k] = theta > 1 - 1e-12 ? trial[k] : returned[k] + theta * (trial[k] - returned[k]);
  }
}

/* Moving points: a contact that slips in part keeps its slip; the diagram is cut where it exceeds the limit.
   Slip linear between the ends cannot follow a part that slips beside one that holds, and returning the
   slipping end would relieve the holding part as well (5 % of tau near the heel of a dam). Only when both
   ends are at their limits, one way, does the whole line return. */
static inline PetscBool SlidesWhole(const PetscReal trial[2], const PetscReal limit[2])
{
  for (int k = 0; k < 2; k++)
    if (!(limit[k] <= 0 || fabs(trial[k]) > limit[k])) return PETSC_FALSE;
  return (PetscBool)(trial[0] * trial[1] >= 0);
}

/* Books what was returned as plastic slip; untouched where nothing was, so that it cannot drift by rounding.
 */
static inline void AdvanceSlip(const Joint *joint, const PetscReal trial[2], const PetscReal held[2],
                               ContactPoint *p)
{
  for (int k = 0; k < 2; k++) {
    if (held[k] == trial[k]) continue;
    p->slip[k] = held[k] == 0 ? p->u_s[k] : p->slip[k] + (trial[k] - held[k]) / joint->k_s;
  }
}

/* In time, tptm: each end force F_s is an elastic-plastic spring with the limit of its share of the joint,
   because clipping a line that keeps its slip has no memory and makes energy where N changes while a part
   slips. The nearest point of the box |F_s| <= most to the trial forces in the metric of the elastic row
   L/6 [2 1; 1 2]: slip is then normal to the box, which holds F_s = 0, and F_s . d(slip) >= 0. */
static void ReturnForces(PetscReal length, const PetscReal trial[2], const PetscReal most[2], PetscReal F[2],
                         PetscReal tau[2])
{
  PetscReal T[2];
  int a;

  for (int k = 0; k < 2; k++) T[k] = length * (2 * trial[k] + trial[1 - k]) / 6;
  a = fabs(T[1]) - most[1] > fabs(T[0]) - most[0]; // the end that is farther out first
  for (int pass = 0; pass < 2; pass++, a = 1 - a) {
    F[a] = JointClip(T[a], most[a]);
    F[1 - a] = JointClip(T[1 - a] + 0.5 * (F[a] - T[a]), most[1 - a]);
    if (JointClip(T[a] + 0.5 * (F[1 - a] - T[1 - a]), most[a]) == F[a]) break; // it stays at its limit
  }
  for (int k = 0; k < 2; k++)
    tau[k] = F[0] == T[0] && F[1] == T[1] ? trial[k] : (4 * F[k] - 2 * F[1 - k]) / length;
}

/* sigma, tau and state at the ends, from the trial stresses and the strengths there */
static inline void EndStresses(const Joint *joint, const PetscReal sigma[2], const PetscReal tau[2],
                               ContactPoint *p)
{
  for (int k = 0; k < 2; k++) {
    int strength = EndStrength(p->broken, k);
    PetscReal limit = JointShearLimit(joint, strength, sigma[k]);

    p->sigma[k] = JointNormal(joint, strength, sigma[k]);
    p->tau[k] = JointClip(tau[k], limit);
    p->state[k] = CONTACT_ELASTIC;
    if (JointIsOpen(joint, strength, sigma[k]))
      p->state[k] |= CONTACT_OPEN;
    else if (fabs(tau[k]) > limit)
      p->state[k] |= CONTACT_SLIPPING;
    if (JointIsCrushing(joint, sigma[k])) p->state[k] |= CONTACT_CRUSHING;
  }
}

/* --------------------------------------------------------------------- Models with fixed control points */

/* how far end k violates the peak strength, by the criterion that fails at the middle */
static PetscReal Violation(const Joint *joint, PetscBool opens, PetscReal sigma, PetscReal tau)
{
  if (opens) return sigma - joint->tension[0];
  return fabs(tau) - JointCone(joint, 0, JointNormal(joint, 0, sigma));
}

/* Updates broken[] from the trial stresses; middle: the model has a third control point. */
static void BreakPoints(const Joint *joint, PetscBool middle, const PetscReal sigma[2],
                        const PetscReal tau[2], PetscReal broken[2])
{
  PetscReal part = middle ? 0.25 : 0.5, v[2];
  PetscBool opens, whole = (PetscBool)(broken[0] > 0.5 || broken[1] > 0.5);

  for (int k = 0; k < 2; k++) {
    if (broken[k] < part && JointFails(joint, sigma[k], tau[k])) broken[k] = part;
  }
  if (!middle || whole || !JointFails(joint, Line(sigma, 0), Line(tau, 0))) return;

  /* the middle goes with the more violated end; with both when there is none, to treat them alike */
  opens = JointIsOpen(joint, 0, Line(sigma, 0));
  for (int k = 0; k < 2; k++) v[k] = Violation(joint, opens, sigma[k], tau[k]);
  for (int k = 0; k < 2; k++) {
    if (v[k] >= v[1 - k] && broken[k] < 0.75) broken[k] = 0.75;
  }
}

/* The middle has a say when its state differs from an end's and it can bear more than the line between the
 * ends. */
static void HoldMiddle(const Joint *joint, const PetscReal sigma[2], const PetscReal broken[2], int strength,
                       const PetscReal limit[2], Holds *holds)
{
  PetscReal sm = Line(sigma, 0), lm = JointShearLimit(joint, strength, sm);
  PetscBool differs = PETSC_FALSE;

  for (int k = 0; k < 2; k++) {
    int end = EndStrength(broken, k);
    if (end != strength || JointIsOpen(joint, end, sigma[k]) != JointIsOpen(joint, strength, sm) ||
        JointIsCrushing(joint, sigma[k]) != JointIsCrushing(joint, sm))
      differs = PETSC_TRUE;
  }
  if (differs && ((JointIsBrittle(joint) && strength == 0) || lm > 0.5 * (limit[0] + limit[1])))
    HoldAt(holds, 0, lm);
}

static void RespondFixed(StressModelKind model, const Joint *joint, PetscReal length,
                         const PetscReal sigma[2], const PetscReal tau[2], ContactPoint *p)
{
  const PetscReal *row = rows[model];
  PetscBool middle = (PetscBool)(row[1] > 0);
  PetscReal limit[2], held[2], sm = 0, tm = 0;
  Holds holds = {.n = 0};
  int strength;

  /* failure, with the trial stresses */
  if (JointIsBrittle(joint)) BreakPoints(joint, middle, sigma, tau, p->broken);
  strength = p->broken[0] > 0.5 || p->broken[1] > 0.5;
  for (int k = 0; k < 2; k++) limit[k] = JointShearLimit(joint, EndStrength(p->broken, k), sigma[k]);

  /* return of shear */
  if (middle) HoldMiddle(joint, sigma, p->broken, strength, limit, &holds);
  ReturnShear(&holds, tau, limit, held);
  EndStresses(joint, sigma, tau, p);
  AdvanceSlip(joint, tau, held, p);

  /* forces */
  if (middle) {
    sm = JointNormal(joint, strength, Line(sigma, 0));
    tm = JointClip(Line(held, 0), JointShearLimit(joint, strength, Line(sigma, 0)));
  }
  for (int k = 0; k < 2; k++) {
    p->F_n[k] = length * (row[0] * p->sigma[k] + row[1] * sm + row[2] * p->sigma[1 - k]);
    p->F_s[k] = length * (row[0] * p->tau[k] + row[1] * tm + row[2] * p->tau[1 - k]);
  }
}

/* ------------------------------------------------------------------------------------------- tptm */

enum { STATIONS = 6, PIECES = 5 };

/* The unbroken part is within h >= 0, h linear with end values h0, h1: moves the fronts up to there. */
static inline void GrowFronts(PetscReal h0, PetscReal h1, PetscReal broken[2])
{
  PetscReal xi;

  if (!(h0 < 0 || h1 < 0)) return;
  if (h0 < 0 && h1 < 0) {
    broken[0] = broken[1] = 1;
    return;
  }
  xi = Crossing(h0, h1);
  if (h0 < 0 && broken[0] < 0.5 * (1 + xi)) broken[0] = 0.5 * (1 + xi);
  if (h1 < 0 && broken[1] < 0.5 * (1 - xi)) broken[1] = 0.5 * (1 - xi);
}

/* Fronts of failure: tension, both signs of shear, and shear where compression is cut off. */
static void BreakFronts(const Joint *joint, const PetscReal s[2], const PetscReal t[2], PetscReal broken[2])
{
  PetscReal c[2] = {JointCone(joint, 0, s[0]), JointCone(joint, 0, s[1])};

  GrowFronts(joint->tension[0] - s[0], joint->tension[0] - s[1], broken);
  if (t[0] != 0 || t[1] != 0) {
    GrowFronts(c[0] - t[0], c[1] - t[1], broken);
    GrowFronts(c[0] + t[0], c[1] + t[1], broken);
    if (JointIsCrushing(joint, s[0]) || JointIsCrushing(joint, s[1])) {
      PetscReal most = JointCone(joint, 0, -joint->compression);
      GrowFronts(most - t[0], most - t[1], broken);
      GrowFronts(most + t[0], most + t[1], broken);
    }
  }
  if (broken[0] + broken[1] >= 1) broken[0] = broken[1] = 1;
}

/* The contact cut where the law changes: xi[0] = -1 .. xi[n] = 1, and the trial normal stress. */
typedef struct {
  int n;
  PetscReal xi[STATIONS];
  PetscReal front[2]; /* ends of the unbroken part */
} Cuts;

static inline int StrengthAt(const Cuts *cuts, PetscReal xi)
{
  return xi < cuts->front[0] || xi > cuts->front[1];
}

static inline void CutAt(Cuts *cuts, PetscReal xi)
{
  int i;

  if (!(xi > -1 && xi < 1)) return;
  for (i = ++cuts->n; cuts->xi[i - 1] > xi; i--) cuts->xi[i] = cuts->xi[i - 1];
  cuts->xi[i] = xi;
}

/* Cuts at the fronts, where sigma passes the residual tension (the peak one can only be passed where nothing
   is brittle, and then they are equal) and where it passes the compression strength. Of these, the places
   with a say in the return of shear: a closing point or a front behind which the limit steps up, and the kink
   of the limit at crushing. */
static inline void MakeCuts(const Joint *joint, const PetscReal s[2], const PetscReal broken[2], Cuts *cuts,
                            Holds *holds)
{
  PetscReal T = joint->tension[1], C = joint->compression, xi;

  cuts->n = 0;
  cuts->xi[0] = -1;
  cuts->front[0] = 2 * broken[0] - 1;
  cuts->front[1] = 1 - 2 * broken[1];
  xi = Crossing(T - s[0], T - s[1]);
  CutAt(cuts, xi);
  if (StrengthAt(cuts, xi) || !JointIsBrittle(joint)) HoldAt(holds, xi, JointCone(joint, 1, T));
  if (JointIsCrushing(joint, s[0]) != JointIsCrushing(joint, s[1])) {
    xi = Crossing(C + s[0], C + s[1]);
    CutAt(cuts, xi);
    HoldAt(holds, xi, JointCone(joint, StrengthAt(cuts, xi), -C));
  }
  for (int k = 0; k < 2 && broken[0] + broken[1] < 1; k++) {
    CutAt(cuts, cuts->front[k]);
    HoldAt(holds, cuts->front[k], JointCone(joint, 0, JointNormal(joint, 0, Line(s, cuts->front[k]))));
  }
  cuts->xi[++cuts->n] = 1;
}

/* Shares of the two ends, in units of L, of a trapezoid v[0], v[1] over xi[0], xi[1]: integral of v (1-x) and
 * v x. */
static inline void Trapezoid(const PetscReal *xi, const PetscReal *v, PetscReal share[2])
{
  PetscReal h = (xi[1] - xi[0]) *
                (1. / 24); /* half of its length, over 6, and 1/2 of the two weights 1 -+ xi */
  PetscReal a0 = 1 - xi[0], b0 = 1 - xi[1], a1 = 1 + xi[0], b1 = 1 + xi[1];

  share[0] = h * (v[0] * (2 * a0 + b0) + v[1] * (a0 + 2 * b0));
  share[1] = h * (v[0] * (2 * a1 + b1) + v[1] * (a1 + 2 * b1));
}

/* Each end sums from its own side, so that exchanged ends sum alike. */
static inline void SumShares(int n, PetscReal f[][2], PetscReal share[2])
{
  share[0] = share[1] = 0;
  for (int i = 0; i < n; i++) share[0] += f[i][0], share[1] += f[n - 1 - i][1];
}

/* Shear of one piece: the line tau clipped to +-max(0, cone), cut where it meets the one or the other. */
static void ShearPiece(const PetscReal xi[2], const PetscReal tau[2], const PetscReal cone[2],
                       PetscReal share[2])
{
  PetscReal up = Crossing(cone[0] - tau[0], cone[1] - tau[1]),
            down = Crossing(cone[0] + tau[0], cone[1] + tau[1]);
  PetscReal apex = Crossing(cone[0], cone[1]), v[STATIONS], f[PIECES][2];
  Cuts cuts = {.n = 0, .xi[0] = -1};

  for (int k = 0; k < 2; k++) v[k] = JointClip(tau[k], cone[k] < 0 ? 0 : cone[k]);
  if (up > 1 && down > 1 && apex > 1) {
    Trapezoid(xi, v, share);
    return;
  }
  CutAt(&cuts, up);
  CutAt(&cuts, down);
  CutAt(&cuts, apex);
  v[cuts.n + 1] = v[1];
  for (int i = 1; i <= cuts.n; i++) {
    PetscReal limit = Line(cone, cuts.xi[i]);
    v[i] = JointClip(Line(tau, cuts.xi[i]), limit < 0 ? 0 : limit);
    cuts.xi[i] = Line(xi, cuts.xi[i]);
  }
  cuts.xi[0] = xi[0];
  cuts.xi[++cuts.n] = xi[1];
  for (int i = 0; i < cuts.n; i++) Trapezoid(cuts.xi + i, v + i, f[i]);
  SumShares(cuts.n, f, share);
}

static void RespondMoving(const Joint *joint, PetscReal length, const PetscReal sigma[2],
                          const PetscReal tau[2], ContactPoint *p)
{
  PetscReal limit[2], held[2], most[2], f_n[PIECES][2], f_s[PIECES][2], f_most[PIECES][2];
  // a joint that can still break keeps the diagram, which the fronts of failure need
  PetscBool in_time = (PetscBool)(p->in_time && (!JointIsBrittle(joint) || p->broken[0] >= 1));
  Holds holds = {.n = 0};
  Cuts cuts;

  /* failure, with the trial stresses */
  if (JointIsBrittle(joint)) BreakFronts(joint, sigma, tau, p->broken);
  MakeCuts(joint, sigma, p->broken, &cuts, &holds);

  /* return of shear */
  for (int k = 0; k < 2; k++) limit[k] = JointShearLimit(joint, EndStrength(p->broken, k), sigma[k]);
  if (SlidesWhole(tau, limit) && !in_time) {
    ReturnShear(&holds, tau, limit, held);
  } else {
    held[0] = tau[0], held[1] = tau[1];
  }
  EndStresses(joint, sigma, tau, p);

  /* diagrams; strength and state of a piece are those of its middle, so that rounding at a cut does not
   * spread */
  for (int i = 0; i < cuts.n; i++) {
    const PetscReal *xi = cuts.xi + i, middle = 0.5 * (xi[0] + xi[1]), sm = Line(sigma, middle);
    int strength = StrengthAt(&cuts, middle);
    PetscBool open = JointIsOpen(joint, strength, sm), flat = (PetscBool)(open || JointIsCrushing(joint, sm));
    PetscReal s[2], t[2], cone[2], most_at[2];

    for (int k = 0; k < 2; k++) {
      s[k] = JointNormal(joint, strength, flat ? sm : Line(sigma, xi[k]));
      t[k] = Line(held, xi[k]);
      cone[k] = JointCone(joint, strength, s[k]);
    }
    Trapezoid(xi, s, f_n[i]);
    ShearPiece(xi, t, cone, f_s[i]);
    for (int k = 0; k < 2; k++) most_at[k] = cone[k] < 0 ? 0 : cone[k];
    Trapezoid(xi, most_at, f_most[i]);
    for (int k = 0; k < 2 && open; k++) f_s[i][k] = f_most[i][k] = 0;
  }

  /* forces */
  SumShares(cuts.n, f_n, p->F_n);
  SumShares(cuts.n, f_s, p->F_s);
  SumShares(cuts.n, f_most, most);
  for (int k = 0; k < 2; k++) p->F_n[k] *= length, p->F_s[k] *= length, most[k] *= length;
  if (in_time) ReturnForces(length, tau, most, p->F_s, held);
  AdvanceSlip(joint, tau, held, p);
}

/* ------------------------------------------------------------------------------------------------ */

/* Bit for bit what the vectorised path does. */
static void RespondElastic(StressModelKind model, PetscReal length, const PetscReal sigma[2],
                           const PetscReal tau[2], ContactPoint *p)
{
  PetscReal a, b;

  StressModelElastic(model, &a, &b);
  for (int k = 0; k < 2; k++) {
    p->sigma[k] = sigma[k];
    p->tau[k] = tau[k];
    p->state[k] = CONTACT_ELASTIC;
  }
  p->F_n[0] = length * (a * sigma[0] + b * sigma[1]);
  p->F_n[1] = length * (b * sigma[0] + a * sigma[1]);
  p->F_s[0] = length * (a * tau[0] + b * tau[1]);
  p->F_s[1] = length * (b * tau[0] + a * tau[1]);
}

void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p)
{
  PetscReal sigma[2], tau[2];

  for (int k = 0; k < 2; k++) {
    sigma[k] = JointNormalTrial(joint, p->u_n[k]);
    tau[k] = JointShearTrial(joint, p->u_s[k], p->slip[k]);
  }
  if (JointIsElastic(joint, sigma, tau, p->broken))
    RespondElastic(model, length, sigma, tau, p);
  else if (model == STRESS_TPTM)
    RespondMoving(joint, length, sigma, tau, p);
  else
    RespondFixed(model, joint, length, sigma, tau, p);
}

/* reference.c: one contact from opening and slip to the forces at its ends, with its history. Read
   reference_law.h first. */
#include "reference_diagram.h"

/* ----------------------------------------------------------------- 4. history: crushing, failure and slip */

/* Area between 0 and the deeper of two lines of closure, per length: what the two have crushed together. */
static double CrushedArea(const double a[2], const double b[2])
{
  const OneContact c = {.L = 1, .closure = {{a[0], a[1]}, {b[0], b[1]}}};
  Points p = {2, {0, 1}};
  double F[2];
  AddEvents(&c, LINE_0, LINES_MEET, &p);
  IntegrateDiagram(&c, &p, ClosureAt, F);
  return -(F[0] + F[1]);
}

/* line: the new line of closure by end k. The closure of now, a, is deeper at this end than the line before,
   b. The new line has the depth of a at this end and the crushed area of a and b together. It is a itself
   where b is nowhere below both a and the line of the other end. */
static void DeepenLine(int k, const double a[2], const double b[2], const double other[2], double line[2])
{
  const int far = 1 - k;
  const double gain = b[k] - a[k], loss = a[far] - b[far], y = loss > 0 ? gain / (gain + loss) : 1;
  const double x = k ? 1 - y : y, meet = Along(a, x);
  const bool covered = Along(other, x) <= Along(b, x) && other[far] <= b[far];
  line[k] = a[k], line[far] = a[far];
  if (loss <= 0 || meet >= 0 || covered) return;
  const double twice = 2 * CrushedArea(a, b), depth = -a[k];
  const double reach = twice >= depth ? twice - depth : depth - depth * depth / twice; /* depth at far */
  line[far] = -fmin(reach, fmax(-other[far], -a[far]));
}

/* Keeps what is crushed: an end pressed past C gets a new line of closure. */
static void Crush(OneContact *c)
{
  const double now[2] = {c->u_n[0] + c->C / c->k_n, c->u_n[1] + c->C / c->k_n};
  const OneContact old = *c;
  for (int k = 0; k < 2; k++)
    if (now[k] < old.closure[k][k]) DeepenLine(k, now, old.closure[k], old.closure[1 - k], c->closure[k]);
}

/* By how much a place violates the criterion by which the middle fails. */
static double Violation(const OneContact *c, double x)
{
  const double sigma = DampedSigma(c, x);
  if (DampedSigma(c, 0.5) > c->peak.T) return sigma - c->peak.T;
  return fabs(TrialTau(c, x)) - (c->peak.c - NormalStress(c, &c->peak, sigma) * c->peak.tan_phi);
}

/* Breaks the control points that fail. The ends own half of the length each, or a quarter where there is a
   middle. The failed middle is booked with the end that is more violated. */
static void BreakPoints(OneContact *c, bool middle)
{
  const bool middle_fails = middle && !IsBroken(c, 0.5) && Fails(c, DampedSigma(c, 0.5), TrialTau(c, 0.5));
  for (int k = 0; k < 2; k++)
    if (Fails(c, DampedSigma(c, k), TrialTau(c, k))) c->broken[k] = fmax(c->broken[k], middle ? 0.25 : 0.5);
  for (int k = 0; k < 2; k++)
    if (middle_fails && Violation(c, k) >= Violation(c, 1 - k)) c->broken[k] = fmax(c->broken[k], 0.75);
}

/* Breaks every place of a contact of tptm that fails by its spring. The places that do not fail are one
   interval, so fronts run in from both ends. */
static void BreakFronts(OneContact *c)
{
  OneContact whole = *c;
  double low = 1, high = 0;
  whole.broken[0] = whole.broken[1] = 0;
  Points p = LimitPoints(&whole);
  AddEvents(&whole, SLIPS_UP, SLIPS_DOWN, &p);
  for (int i = 0; i + 1 < p.n; i++) {
    const double x = 0.5 * (p.x[i] + p.x[i + 1]);
    if (!Fails(c, TrialSigma(c, x), TrialTau(c, x))) low = fmin(low, p.x[i]), high = fmax(high, p.x[i + 1]);
  }
  c->broken[0] = fmax(c->broken[0], low), c->broken[1] = fmax(c->broken[1], 1 - high);
  if (c->broken[0] + c->broken[1] >= 1) c->broken[0] = c->broken[1] = 1;
}

/* A place inside the contact that limits the return of the ends, see ReturnShear. */
typedef struct {
  double x, limit;
} Hold;

/* Share of the trial line that must stay, so that the place keeps the stress that its own law gives it and is
   not loaded by the return. */
static double ShareToKeep(double trial, double returned, double limit)
{
  const double sign = trial < 0 ? -1 : 1, t = sign * trial, r = sign * returned;
  if (t <= limit) return r == t ? 0 : 1;
  if (r > t) return 1;
  return r < limit ? (limit - r) / (t - r) : 0;
}

/* Returns the ends to their limits. Shear stays a line between them, so the return may unload a stronger
   place inside. Then the return is scaled back, for both ends alike, until no such place is unloaded. */
static void ReturnShear(OneContact *c, int n, const Hold *holds)
{
  const double trial[2] = {c->tau[0], c->tau[1]};
  const double returned[2] = {Clip(trial[0], DampedLimit(c, 0)), Clip(trial[1], DampedLimit(c, 1))};
  double share = 0;
  for (int i = 0; i < n; i++)
    if (holds[i].limit > 0)
      share = fmax(share, ShareToKeep(Along(trial, holds[i].x), Along(returned, holds[i].x), holds[i].limit));
  for (int k = 0; k < 2 && share <= 1 - 1e-12; k++)
    c->tau[k] = returned[k] + share * (trial[k] - returned[k]);
}

static const double HAIR = 1e-9; /* relative margin, so that rounding does not decide */

/* Return of shear in a model of fixed points. The middle of three limits it when it is in another state than
   an end and bears more than the mean of the ends. */
static void ReturnOfPoints(OneContact *c, bool middle)
{
  const Hold hold = {0.5, DampedLimit(c, 0.5)};
  const double sigma = DampedSigma(c, 0.5), mean = 0.5 * (DampedLimit(c, 0) + DampedLimit(c, 1));
  const double crushed = -c->C * (1 - HAIR); /* a crushed place stands at -C up to rounding */
  bool differs = false;
  for (int k = 0; k < 2; k++) {
    const double end = DampedSigma(c, k);
    differs |= IsBroken(c, k) != IsBroken(c, 0.5) || (end < crushed) != (sigma < crushed) ||
               (end > StrengthAt(c, k)->T) != (sigma > StrengthAt(c, 0.5)->T);
  }
  const bool holds = middle && differs &&
                     ((Brittle(c) && !IsBroken(c, 0.5)) || hold.limit > mean * (1 + 2 * HAIR));
  ReturnShear(c, holds, &hold);
}

/* Return of shear in tptm. The line returns only when both ends slip in one direction; every point where the
   limit bends or jumps then limits the return. A contact that slips in part keeps its line, and its diagram
   is cut at the limit. */
static void ReturnOfDiagram(OneContact *c)
{
  const Points p = LimitPoints(c);
  Hold holds[MAX_POINTS];
  for (int k = 0; k < 2; k++)
    if (DampedLimit(c, k) > 0 && fabs(c->tau[k]) <= DampedLimit(c, k)) return;
  if (c->tau[0] * c->tau[1] < 0) return;
  for (int i = 1; i + 1 < p.n; i++) {
    double side[2];
    for (int k = 0; k < 2; k++) { /* the limit on both sides of x: a line within each piece */
      const double x = p.x[i], h = p.x[i - 1 + 2 * k] - x;
      side[k] = 2 * LimitAt(c, x + 0.25 * h) - LimitAt(c, x + 0.5 * h);
    }
    holds[i - 1] = (Hold){p.x[i], fmax(side[0], side[1])};
  }
  ReturnShear(c, p.n - 2, holds);
}

/* ---------------------------------------------------------------------------------- 5. forces at the ends */

/* F: end forces in a model of fixed control points. s: stresses at end 0, in the middle and at end 1. */
static void PointForces(const OneContact *c, const double s[3], double F[2])
{
  static const struct {
    int n, stress[3];
    double at[3], width[3];
  } rectangles[] = {[STRESS_PT] = {2, {0, 2}, {0, 1}, {1. / 2, 1. / 2}},
                    [STRESS_R2PT] = {2, {0, 2}, {1. / 4, 3. / 4}, {1. / 2, 1. / 2}},
                    [STRESS_R3PT] = {3, {0, 1, 2}, {1. / 8, 1. / 2, 7. / 8}, {1. / 4, 1. / 2, 1. / 4}}};
  F[0] = F[1] = 0;
  if (c->model <= STRESS_R3PT)
    for (int i = 0; i < rectangles[c->model].n; i++) { /* the lever shares each force */
      const double x = rectangles[c->model].at[i];
      const double force = c->L * rectangles[c->model].width[i] * s[rectangles[c->model].stress[i]];
      F[0] += (1 - x) * force, F[1] += x * force;
    }
  else
    for (int i = 0; i < 4; i++) { /* Gauss points of two trapezoids, which are one line in t2pt */
      const double middle = c->model == STRESS_T3PT ? s[1] : 0.5 * (s[0] + s[2]);
      const double x = 0.5 * (i / 2 + GAUSS[i % 2]), half[2][2] = {{s[0], middle}, {middle, s[2]}};
      const double force = 0.25 * c->L * Along(half[i / 2], GAUSS[i % 2]);
      F[0] += (1 - x) * force, F[1] += x * force;
    }
}

/* row: a and b of F_k = L (a s_k + b s_other), for stresses that are linear between the ends. */
static void ElasticRow(StressModelKind model, double row[2])
{
  const OneContact unit = {.model = model, .L = 1};
  PointForces(&unit, (const double[3]){1, 0.5, 0}, row);
}

/* F: the point of the box |F| <= most that is nearest to T, in the energy of the elastic row: d0^2 - 2 b/a d0
   d1 + d1^2. The point is T itself, or it is the nearest point of a side. */
static void NearestInBox(StressModelKind model, const double T[2], const double most[2], double F[2])
{
  double row[2], nearest = INFINITY;
  ElasticRow(model, row);
  if (fabs(T[0]) <= most[0] && fabs(T[1]) <= most[1]) nearest = 0, F[0] = T[0], F[1] = T[1];
  for (int side = 0; side < 4 && nearest > 0; side++) {
    const int k = side / 2;
    double G[2], d[2];
    G[k] = side % 2 ? most[k] : -most[k], d[k] = G[k] - T[k];
    G[1 - k] = Clip(T[1 - k] + row[1] / row[0] * d[k], most[1 - k]), d[1 - k] = G[1 - k] - T[1 - k];
    const double far = d[0] * d[0] - 2 * row[1] / row[0] * d[0] * d[1] + d[1] * d[1];
    if (far < nearest) nearest = far, F[0] = G[0], F[1] = G[1];
  }
}

/* tau: the line of shear stress that has the forces F by the elastic row. */
static void LineOfForces(const OneContact *c, const double F[2], double tau[2])
{
  double row[2];
  ElasticRow(c->model, row);
  for (int k = 0; k < 2; k++)
    tau[k] = (row[0] * F[k] - row[1] * F[1 - k]) / (row[0] * row[0] - row[1] * row[1]) / c->L;
}

/* Forces of a contact at the end of a step, and the most that its shear forces can be. */
typedef struct {
  double n[2], s[2], most[2];
} EndForces;

static EndForces RespondPoints(OneContact *c)
{
  const bool middle = c->model == STRESS_R3PT || c->model == STRESS_T3PT;
  double normal[3], shear[3], limit[3];
  EndForces F;
  if (Brittle(c)) BreakPoints(c, middle);
  ReturnOfPoints(c, middle);
  for (int i = 0; i < 3; i++) {
    const double x = 0.5 * i;
    normal[i] = NormalAt(c, x) + DashpotAt(c, x);
    limit[i] = DampedLimit(c, x);
    shear[i] = Clip(Along(c->tau, x), limit[i]);
  }
  PointForces(c, normal, F.n), PointForces(c, shear, F.s), PointForces(c, limit, F.most);
  return F;
}

/* In time the two shear forces are elastic-plastic springs, each with its share of the limit. A joint that
   can still break when the step begins keeps its diagram. */
static EndForces RespondDiagram(OneContact *c, bool in_time)
{
  const double trial[2] = {c->tau[0], c->tau[1]};
  const Points dashpot_points = DashpotPoints(c);
  double dashpots[2];
  EndForces F;
  const bool springs = in_time && (!Brittle(c) || c->broken[0] >= 1);
  if (Brittle(c)) BreakFronts(c);
  if (!springs) ReturnOfDiagram(c);
  Points p = LimitPoints(c);
  AddEvents(c, SLIPS_UP, SLIPS_DOWN, &p);
  IntegrateDiagram(c, &p, NormalAt, F.n), IntegrateDiagram(c, &p, ShearAt, F.s),
      IntegrateDiagram(c, &p, LimitAt, F.most);
  IntegrateDiagram(c, &dashpot_points, DashpotAt, dashpots);
  for (int k = 0; k < 2; k++) {
    F.n[k] += dashpots[k];
    F.most[k] = fmax(0, F.most[k] - StrengthAt(c, k)->tan_phi * dashpots[k]);
    if (c->dashpot[0] != 0 || c->dashpot[1] != 0) F.s[k] = Clip(F.s[k], F.most[k]);
  }
  if (springs) {
    const double T[2] = {c->L * (2 * trial[0] + trial[1]) / 6, c->L * (trial[0] + 2 * trial[1]) / 6};
    NearestInBox(c->model, T, F.most, F.s);
    if (F.s[0] != T[0] || F.s[1] != T[1]) LineOfForces(c, F.s, c->tau);
  }
  return F;
}

/* ----------------------------------------------------------------------------------------- 2 to 5 at once */

static const double LOOSE_TAN = 1e6;   /* tan_phi of an elastic joint that has met in motion */
static const double UNLIMITED = 1e300; /* stands for no limit; infinity would make NaN of a difference */

/* Sets the joint of a contact. An elastic joint has no limits. A contact that has met in motion (LOOSE) bears
   no tension; in shear it has the residual strength or, in an elastic joint, no limit where it is pressed. */
static void SetJoint(const Joint *joint, bool loose, OneContact *c)
{
  const bool elastic = joint->law == LAW_ELASTIC;
  Strength *strength[2] = {&c->peak, &c->residual};
  c->k_n = joint->k_n, c->k_s = joint->k_s;
  c->C = elastic ? UNLIMITED : fmin(joint->compression, UNLIMITED);
  for (int i = 0; i < 2; i++) {
    const int which = loose ? 1 : i;
    *strength[i] = (Strength){fmin(joint->tension[which], UNLIMITED), joint->cohesion[which],
                              joint->tan_phi[which]};
    if (loose) strength[i]->T = 0;
    if (elastic) *strength[i] = loose ? (Strength){0, 0, LOOSE_TAN} : (Strength){UNLIMITED, UNLIMITED, 0};
  }
}

static OneContact BeginStep(StressModelKind model, const Joint *joint, double L, const ContactPoint *p)
{
  OneContact c = {.model = model, .L = L};
  SetJoint(joint, p->broken[0] >= LOOSE, &c);
  for (int k = 0; k < 2; k++) {
    c.u_n[k] = p->u_n[k], c.u_s[k] = p->u_s[k], c.slip[k] = p->slip[k], c.broken[k] = p->broken[k];
    c.closure[k][k] = p->closure[k], c.closure[k][1 - k] = p->closure_far[k];
    c.dashpot[k] = p->in_time ? joint->damping * joint->k_n * p->speed[k] : 0;
  }
  return c;
}

/* Writes the answer to p. Slip is the part of u_s that the remaining shear stress does not explain. */
static void EndStep(const OneContact *c, const EndForces *F, ContactPoint *p)
{
  for (int k = 0; k < 2; k++) {
    const double total = DampedSigma(c, k), limit = DampedLimit(c, k), tau = TrialTau(c, k);
    const bool open = total > StrengthAt(c, k)->T;
    const bool crushing = total < -c->C || TrialSigma(c, k) <= -c->C * (1 - HAIR);
    p->state[k] = (open                ? CONTACT_OPEN
                   : fabs(tau) > limit ? CONTACT_SLIPPING
                                       : 0) |
                  (crushing ? CONTACT_CRUSHING : 0);
    p->sigma[k] = NormalAt(c, k), p->tau[k] = Clip(tau, limit);
    p->F_n[k] = F->n[k], p->F_s[k] = F->s[k];
    if (c->tau[k] != tau) p->slip[k] = c->u_s[k] - c->tau[k] / c->k_s;
    p->broken[k] = c->broken[k];
    p->closure[k] = c->closure[k][k], p->closure_far[k] = c->closure[k][1 - k];
  }
}

/* Answers in p what stress_models.c: StressModelRespond answers. Returns the forces with the most that the
   shear forces can be. */
static EndForces Respond(StressModelKind model, const Joint *joint, double L, ContactPoint *p)
{
  OneContact c = BeginStep(model, joint, L, p);
  Crush(&c);
  for (int k = 0; k < 2; k++) c.tau[k] = TrialTau(&c, k);
  const EndForces F = model == STRESS_TPTM ? RespondDiagram(&c, p->in_time) : RespondPoints(&c);
  EndStep(&c, &F, p);
  return F;
}

void ReferenceRespond(StressModelKind model, const Joint *joint, double L, ContactPoint *p)
{
  Respond(model, joint, L, p);
}

/* Friction on the way to an equilibrium. The end forces are springs with a slip of their own. Each evaluation
   draws it, by `pull` of the way, towards the slip that the law asks for with the committed history in p. */
void ReferenceFollow(StressModelKind model, const Joint *joint, double L, double pull, double own[2],
                     ContactPoint *p)
{
  OneContact c = BeginStep(model, joint, L, p);
  const EndForces law = Respond(model, joint, L, p);
  const double fraction = pull / fmax(1, fmax(c.peak.tan_phi, c.residual.tan_phi));
  double row[2], asked[2], tau[2], T[2], F[2];
  ElasticRow(model, row);
  LineOfForces(&c, law.s, asked);
  for (int k = 0; k < 2; k++) {
    own[k] += fraction * (c.u_s[k] - asked[k] / c.k_s - own[k]);
    tau[k] = c.k_s * (c.u_s[k] - own[k]);
  }
  for (int k = 0; k < 2; k++) T[k] = L * (row[0] * tau[k] + row[1] * tau[1 - k]);
  NearestInBox(model, T, law.most, F);
  LineOfForces(&c, F, tau);
  for (int k = 0; k < 2; k++) own[k] = c.u_s[k] - tau[k] / c.k_s, p->F_s[k] = F[k];
}

/* --------------------------------------------------------------------------------- 6. forces at the vertices
   The forces on P, A, B, for a thickness of 1, are the derivatives of F_n u_n + F_s u_s with u_n, u_s of
   EndOf. A and B share the force by the lever. Where s and n turn with the face, they also get a couple. */
FaceEnd ReferenceEnd(const double *const X[3], const double *const u[3], double t, double moving)
{
  return EndOf(X, u, t, moving);
}

void ReferenceVertexForces(const FaceEnd *end, double F_n, double F_s, double f[3][2])
{
  const double couple = end->moving * (F_n * end->u_s - F_s * end->u_n) / end->length;
  for (int i = 0; i < 2; i++) {
    const double F = F_n * end->n[i] + F_s * end->s[i];
    f[0][i] = F;
    f[1][i] = -(1 - end->t) * F + couple * end->n[i];
    f[2][i] = -end->t * F - couple * end->n[i];
  }
}

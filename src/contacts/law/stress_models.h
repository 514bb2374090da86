/* stress_models.h: computes the forces at the ends of LANES contacts from openings and slips there, by the
   six integration procedures of section 2.5 of the paper. The only branches are those that skip what no lane
   needs.

   In pt, r2pt, r3pt, t2pt and t3pt the law holds at fixed control points: the ends and, for two models, the
   middle. With stresses s0, sm, s1 there,  F_0 = L (c1 s0 + cm sm + c2 s1), and F_1 has s0 and s1 exchanged.
   Only pt derives from a potential; r2pt, r3pt, t2pt and t3pt make or lose energy on a partly open contact.
   tptm has control points where the law is violated, and integrates the piecewise linear diagram exactly. */
#pragma once
#include "contacts/law/law.h"
#include "contacts/law/ends.h"
#include "contacts/law/tptm.h"
#include "contacts/law/softening.h"

/* A stress model. row: shares of end 0 in the stresses s0, sm, s1. elastic: shares in s0 and s1 of a linear
   field, where sm is the mean of the ends. moving: whether its control points move (tptm). */
typedef struct {
  PetscReal row[3], elastic[2];
  int moving;
} LanesModel;
extern const LanesModel LanesModels[]; /* stress_models.c */

/* --------------------------------------------------------------------- models with fixed control points */

/* Updates broken[] from the trial stresses. middle: whether the model has a third control point. */
KERNEL void BreakPoints(const LanesJoint *J, int middle, const Lanes sigma[2], Lanes sm, const Lanes tau[2],
                        Lanes broken[2])
{
  const Lanes fraction = LanesOf(middle ? 0.25 : 0.5);
  const Mask whole = (broken[0] > 0.5) | (broken[1] > 0.5);
  for (int k = 0; k < 2; k++)
    broken[k] = Select(J->brittle & (broken[k] < fraction) & JointFails(J, sigma[k], tau[k]), fraction,
                       broken[k]);
  if (!middle) return;

  /* the failed middle counts to the end that violates the criterion of the failure more, and to both ends
     when they violate it alike */
  const Lanes tm = Line(tau, LanesOf(0.));
  const Mask fails = J->brittle & ~whole & JointFails(J, sm, tm), opens = JointIsOpen(&J->peak, sm);
  Lanes violation[2];
  for (int k = 0; k < 2; k++)
    violation[k] = Select(opens, sigma[k] - J->peak.tension,
                          Absolute(tau[k]) - JointCone(&J->peak, JointNormal(J, &J->peak, sigma[k])));
  for (int k = 0; k < 2; k++)
    broken[k] = Select(fails & (violation[k] >= violation[1 - k]) & (broken[k] < 0.75), LanesOf(0.75),
                       broken[k]);
}

/* Returns the middle as a place that limits the return of the ends. It does so when its state differs from an
   end's and it can carry more than the line between the ends. With `closes` the comparisons have a margin of
   1e-9: a crushed place stands at -C only up to rounding, and rounding must not decide whether the middle
   counts. */
KERNEL StrongPlace StrongMiddle(const LanesJoint *J, int closes, const Lanes sigma[2], Lanes sm,
                                const Lanes broken[2], Mask residual, const Lanes limit[2])
{
  const PetscReal hair = closes ? 1e-9 : 0.;
  const LanesStrength strength = StrengthOf(J, residual);
  const Lanes most = JointShearLimit(J, &strength, sm), crushed = (hair - 1.) * J->compression;
  Mask differs = {0};
  for (int k = 0; k < 2; k++) {
    const Mask end = EndIsResidual(broken, k);
    const LanesStrength there = StrengthOf(J, end);
    differs |= (end ^ residual) | (JointIsOpen(&there, sigma[k]) ^ JointIsOpen(&strength, sm)) |
               ((sigma[k] < crushed) ^ (sm < crushed));
  }
  const Mask stronger = most > (0.5 + hair) * (limit[0] + limit[1]);
  return StrongPlaceAt(differs & ((J->brittle & ~residual) | stronger), LanesOf(0.), most);
}

/* Returns the trial normal stress in the middle. */
KERNEL Lanes MiddleTrial(const LanesJoint *J, int closes, const LanesContact *c)
{
  const Lanes line[2] = {J->k_n * c->u_n[0], J->k_n * c->u_n[1]}, middle = LanesOf(0.);
  return closes ? Line(line, middle) - J->k_n * ClosureAt(c, middle) : Line(line, middle);
}

KERNEL void RespondFixed(const LanesJoint *J, const PetscReal row[3], int closes, int damped, int bounds,
                         LanesContact *c)
{
  const int middle = row[1] > 0.;
  const Lanes spring[3] = {c->sigma[0], c->sigma[1], MiddleTrial(J, closes, c)};
  const Lanes tau[2] = {c->tau[0], c->tau[1]};
  Lanes sigma[2] = {spring[0], spring[1]}, sm = spring[2]; /* stresses with dashpots */
  if (damped) {
    for (int k = 0; k < 2; k++) sigma[k] += DashpotStress(J, spring[k], c->dashpot[k]);
    sm += DashpotStress(J, sm, Line(c->dashpot, LanesOf(0.)));
  }
  Lanes limit[2], kept[2], normal = {0.}, tm = {0.}, limit_m = {0.};
  StrongPlace strong = {{0}, {0.}, {0.}};

  /* failure, by the trial stresses */
  if (Any(J->brittle)) BreakPoints(J, middle, sigma, sm, tau, c->broken);
  const Mask residual = (c->broken[0] > 0.5) | (c->broken[1] > 0.5);
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    limit[k] = JointShearLimit(J, &strength, sigma[k]);
  }

  /* return of shear */
  if (middle) strong = StrongMiddle(J, closes, sigma, sm, c->broken, residual, limit);
  ReturnShear(middle, &strong, tau, limit, kept);
  EndStresses(J, sigma, tau, c);
  if (damped) SpringStresses(J, spring, c);
  AdvanceSlip(J, tau, kept, c);

  /* forces */
  if (middle) {
    const LanesStrength strength = StrengthOf(J, residual);
    normal = JointNormal(J, &strength, spring[2]);
    limit_m = JointShearLimit(J, &strength, sm);
    tm = JointClip(Line(kept, LanesOf(0.)), limit_m);
  }
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * (row[0] * c->sigma[k] + row[1] * normal + row[2] * c->sigma[1 - k]);
    c->F_s[k] = c->length * (row[0] * c->tau[k] + row[1] * tm + row[2] * c->tau[1 - k]);
    if (bounds) c->most[k] = c->length * (row[0] * limit[k] + row[1] * limit_m + row[2] * limit[1 - k]);
  }
}

/* ------------------------------------------------------------------------------------------------ */

/* Sets sigma and tau to the trial stresses, from u_n, u_s and the history. */
KERNEL void TrialStresses(const LanesJoint *J, int closes, LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->sigma[k] = J->k_n * (closes ? c->u_n[k] - ClosureOfEnd(c, k) : c->u_n[k]); /* (5) */
    c->tau[k] = J->k_s * (c->u_s[k] - c->slip[k]);                                /* (6) */
  }
}

/* Returns whether the law holds elastically in all lanes, for contacts without history. If it does, c has
   the answer of RespondContacts; otherwise c has trial stresses only. */
KERNEL int RespondElastically(const LanesJoint *J, const LanesModel *model, LanesContact *c)
{
  TrialStresses(J, 0, c);
  if (Any(~IsElastic(J, 0, c))) return 0;
  RespondElastic(model->elastic, c);
  return 1;
}

/* Decides whether the law holds elastically at both ends, and in the middle where the model checks there,
   when the stresses of dashpots are added. Springs alone need no check in the middle: their stresses are
   lines, and so are the limits. A dashpot acts only where the joint is closed, so its stress is no line. */
KERNEL Mask IsElasticDamped(const LanesJoint *J, const LanesModel *model, int closes, const LanesContact *c)
{
  const Lanes middle = LanesOf(0.);
  LanesContact total;
  for (int k = 0; k < 2; k++) {
    total.sigma[k] = c->sigma[k] + DashpotStress(J, c->sigma[k], c->dashpot[k]);
    total.tau[k] = c->tau[k], total.broken[k] = c->broken[k];
    if (closes) total.closure[k] = c->closure[k];
  }
  const Mask ends = IsElastic(J, closes, &total);
  if (model->moving || model->row[1] == 0.) return ends;
  const Lanes spring = MiddleTrial(J, closes, c), shear = Line(c->tau, middle),
              stress = spring + DashpotStress(J, spring, Line(c->dashpot, middle));
  for (int k = 0; k < 2; k++) total.sigma[k] = stress, total.tau[k] = shear;
  return ends & IsElastic(J, closes, &total);
}

/* Adds the forces of dashpots to F_n, which has the forces of the springs. spring: trial stresses of the
   springs at the ends. */
KERNEL void AddDashpots(const LanesJoint *J, const LanesModel *model, int closes, const Lanes spring[2],
                        LanesContact *c)
{
  if (model->moving) {
    Pieces pieces;
    if (closes) pieces = PiecesOf(J, c);
    const Shares dashpots = closes ? DashpotSharesOfPieces(J, &pieces, c->dashpot)
                                   : DashpotShares(J, spring, c->dashpot);
    for (int k = 0; k < 2; k++) c->F_n[k] += c->length * dashpots.at[k];
    return;
  }
  Lanes add[3];
  for (int k = 0; k < 2; k++) add[k] = DashpotStress(J, spring[k], c->dashpot[k]);
  add[2] = DashpotStress(J, MiddleTrial(J, closes, c), Line(c->dashpot, LanesOf(0.)));
  for (int k = 0; k < 2; k++)
    c->F_n[k] += c->length * (model->row[0] * add[k] + model->row[1] * add[2] + model->row[2] * add[1 - k]);
}

/* Copies the lanes of the mask from one contact to another: what a response computes. */
KERNEL void TakeLanes(Mask mask, int bounds, const LanesContact *from, LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->slip[k] = Select(mask, from->slip[k], c->slip[k]);
    c->broken[k] = Select(mask, from->broken[k], c->broken[k]);
    c->sigma[k] = Select(mask, from->sigma[k], c->sigma[k]),
    c->tau[k] = Select(mask, from->tau[k], c->tau[k]);
    c->F_n[k] = Select(mask, from->F_n[k], c->F_n[k]), c->F_s[k] = Select(mask, from->F_s[k], c->F_s[k]);
    c->state[k] = (mask & from->state[k]) | (~mask & c->state[k]);
    if (bounds) c->most[k] = Select(mask, from->most[k], c->most[k]);
  }
}

/* Computes the response by the model in lanes that are not elastic, and by the elastic row in all others.
   closes, damped: see RespondJoint. bounds: a constant, whether the caller needs c->most. */
KERNEL void RespondByModel(const LanesJoint *J, const LanesModel *model, int in_time, int closes, int damped,
                           int bounds, Mask elastic, LanesContact *c)
{
  LanesContact trial;
  Mask crushing[2];
  trial.length = c->length;
  for (int k = 0; k < 2; k++) {
    trial.sigma[k] = c->sigma[k], trial.tau[k] = c->tau[k];
    trial.slip[k] = c->slip[k], trial.broken[k] = c->broken[k];
    if (closes) trial.closure[k] = c->closure[k], trial.far[k] = c->far[k];
  }
  RespondElastic(model->elastic, &trial);
  if (closes) {
    AdvanceClosure(J, c);
    TrialStresses(J, closes, c);
    for (int k = 0; k < 2; k++)
      crushing[k] = (c->sigma[k] <= (-1. + 1e-9) * J->compression) & CONTACT_CRUSHING;
  }
  const Lanes spring[2] = {c->sigma[0], c->sigma[1]};
  LanesContact soft;
  if (closes & SOFTENS) {
    soft = *c;
    RespondSoftening(J, damped, bounds, &soft);
  }
  if (model->moving && !(closes & SOFTENS))
    RespondMoving(J, in_time, closes, damped, c);
  else
    RespondFixed(J, model->row, closes, damped, bounds, c);
  if (closes & SOFTENS) TakeLanes(J->soft, bounds, &soft, c);
  if (closes)
    for (int k = 0; k < 2; k++) c->state[k] |= crushing[k];
  for (int k = 0; k < 2; k++) {
    c->slip[k] = Select(elastic, trial.slip[k], c->slip[k]);
    c->broken[k] = Select(elastic, trial.broken[k], c->broken[k]);
    if (closes) c->closure[k] = Select(elastic, trial.closure[k], c->closure[k]);
    if (closes) c->far[k] = Select(elastic, trial.far[k], c->far[k]);
    c->sigma[k] = Select(elastic, trial.sigma[k], c->sigma[k]);
    c->tau[k] = Select(elastic, trial.tau[k], c->tau[k]);
    c->F_n[k] = Select(elastic, trial.F_n[k], c->F_n[k]);
    c->F_s[k] = Select(elastic, trial.F_s[k], c->F_s[k]);
    c->state[k] = (elastic & trial.state[k]) | (~elastic & c->state[k]);
  }
  if (damped) AddDashpots(J, model, closes, spring, c);
}

/* Computes stresses, history, state and end forces from u_n, u_s and the history. All lanes take the elastic
   row; when the law of some lanes does not strong elastically, the model answers for those lanes. closes: a
   constant, 0 where no joint can crush or soften and nothing has been crushed; bits of CLOSES and SOFTENS.
   damped: a constant, 0 where there are no dashpots. in_time: see law.h. Returns whether the history may have
   changed. */
KERNEL int RespondJoint(const LanesJoint *J, const LanesModel *model, int in_time, int closes, int damped,
                        LanesContact *c)
{
  TrialStresses(J, closes, c);
  Mask elastic = IsElastic(J, closes, c);
  if (damped) elastic &= IsElasticDamped(J, model, closes, c);
  if (!Any(~elastic)) {
    RespondElastic(model->elastic, c);
    if (damped) AddDashpots(J, model, closes, c->sigma, c);
    return 0;
  }
  RespondByModel(J, model, in_time, closes, damped, 0, elastic, c);
  return 1;
}

/* Does the same as RespondJoint for contacts that may be loose (law.h: LOOSE). */
KERNEL int RespondContacts(const LanesJoint *J, const LanesModel *model, int in_time, int closes, int damped,
                           LanesContact *c)
{
  const Mask loose = c->broken[0] >= LOOSE;
  if (!Any(loose)) return RespondJoint(J, model, in_time, closes, damped, c);
  const LanesJoint now = LooseJoint(J, loose);
  return RespondJoint(&now, model, in_time, closes, damped, c);
}

/* Finds the slip of both ends at which the elastic row gives the end forces F: u_s - tau/k_s, where the line
   tau has the end forces F. */
KERNEL void SlipOfForces(const LanesJoint *J, const PetscReal row[2], const LanesContact *c, const Lanes F[2],
                         Lanes slip[2])
{
  const PetscReal determinant = row[0] * row[0] - row[1] * row[1];
  for (int k = 0; k < 2; k++)
    slip[k] = c->u_s[k] - (row[0] * F[k] - row[1] * F[1 - k]) / (determinant * c->length * J->k_s);
}

/* [m] slip without a trace, far below the rounding of any displacement. Springs that are drawn to no slip
   would halve it for ever: down to numbers so small that a processor takes a hundred times as long for
   them. */
static const PetscReal NO_SLIP = 1e-30;

/* Computes friction on the way to an equilibrium (head of friction_mode.c). The end forces F_s belong to
   elastic-plastic springs that keep their slip. They are drawn towards the end forces of the law with the
   history c->slip, c->broken, by `pull` times the difference; by pull/tan(phi) where tan(phi) is above 1,
   because the curl of friction grows with tan(phi). own: slip of the springs, in and out. A contact is
   elastic when the law holds elastically and its springs have no other slip. Returns whether any contact is
   not elastic. */
KERNEL int FollowJoint(const LanesJoint *J, const LanesModel *model, PetscReal pull, int closes, Lanes own[2],
                       LanesContact *c)
{
  const PetscReal *row = model->elastic;
  const Lanes from[2] = {c->slip[0], c->slip[1]},
              steep = Select(J->peak.tan_phi < J->residual.tan_phi, J->residual.tan_phi, J->peak.tan_phi),
              fraction = pull / Select(steep > 1., steep, LanesOf(1.));
  Lanes slip[2], tau[2], T[2], F[2];
  TrialStresses(J, closes, c);
  const Mask elastic = IsElastic(J, closes, c),
             springs = elastic & (((own[0] == from[0]) & (own[1] == from[1])) | J->elastic);
  if (!Any(~springs)) {
    RespondElastic(row, c);
    return 0;
  }
  RespondByModel(J, model, 0, closes, 0, 1, elastic, c);
  SlipOfForces(J, row, c, c->F_s, slip);
  for (int k = 0; k < 2; k++) {
    slip[k] = own[k] + fraction * (Select(elastic, from[k], slip[k]) - own[k]);
    slip[k] = Select(elastic & (Absolute(slip[k] - from[k]) < NO_SLIP), from[k], slip[k]);
    tau[k] = J->k_s * (c->u_s[k] - slip[k]);
  }
  for (int k = 0; k < 2; k++) T[k] = c->length * (row[0] * tau[k] + row[1] * tau[1 - k]);
  ReturnForces(row[1] / row[0], T, c->most, F);
  const Mask whole = (F[0] == T[0]) & (F[1] == T[1]),
             plain = springs | (J->k_s <= 0.); // springs without stiffness carry nothing and have no slip
  Lanes returned[2];
  SlipOfForces(J, row, c, F, returned);
  for (int k = 0; k < 2; k++) {
    own[k] = Select(plain, own[k], Select(whole, slip[k], returned[k]));
    c->F_s[k] = Select(plain, c->F_s[k], F[k]);
  }
  return 1;
}

/* Does the same as FollowJoint for contacts that may be loose. */
KERNEL int RespondFollowing(const LanesJoint *J, const LanesModel *model, PetscReal pull, int closes,
                            Lanes own[2], LanesContact *c)
{
  const Mask loose = c->broken[0] >= LOOSE;
  if (!Any(loose)) return FollowJoint(J, model, pull, closes, own, c);
  const LanesJoint now = LooseJoint(J, loose);
  return FollowJoint(&now, model, pull, closes, own, c);
}

/* stress_models.h: from openings and slips at the two ends of LANES contacts to the forces at their ends; the
   six integration procedures of section 2.5 of the paper, free of branches but for what no lane needs.

   pt, r2pt, r3pt, t2pt, t3pt: the law holds at fixed control points, the ends and for two of them the middle.
   With stresses s0, sm, s1 there,  F_0 = L (c1 s0 + cm sm + c2 s1), and F_1 with s0 and s1 exchanged. Only pt
   derives from a potential; r2pt, r3pt, t2pt, t3pt make or lose energy on a partly open contact. tptm:
   control points where the law is violated; the piecewise linear diagram is integrated exactly. */
#pragma once
#include "forces/contacts/law/law.h"
#include "forces/contacts/law/ends.h"
#include "forces/contacts/law/tptm.h"

/* A model: shares of end 0 in the stresses s0, sm, s1; the same for a linear field, where the middle is the
   mean of the ends; whether its control points move (tptm). */
typedef struct {
  PetscReal row[3], elastic[2];
  int moving;
} LanesModel;
extern const LanesModel LanesModels[]; /* stress_models.c */

/* --------------------------------------------------------------------- models with fixed control points */

/* Updates broken[] from the trial stresses; middle: the model has a third control point. */
KERNEL void BreakPoints(const LanesJoint *J, int middle, const Lanes sigma[2], Lanes sm, const Lanes tau[2],
                        Lanes broken[2])
{
  const Lanes part = LanesOf(middle ? 0.25 : 0.5);
  const Mask whole = (broken[0] > 0.5) | (broken[1] > 0.5);
  for (int k = 0; k < 2; k++)
    broken[k] = Select(J->brittle & (broken[k] < part) & JointFails(J, sigma[k], tau[k]), part, broken[k]);
  if (!middle) return;

  /* the middle goes with the end more violated by the criterion that fails there; with both when there is
     none, to treat them alike */
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

/* The middle has a say when its state differs from an end's and it can bear more than the line between the
   ends. What is crushed stands at -C up to rounding, and rounding is not to decide who has a say: closes. */
KERNEL Hold HoldMiddle(const LanesJoint *J, int closes, const Lanes sigma[2], Lanes sm, const Lanes broken[2],
                       Mask residual, const Lanes limit[2])
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
  return HoldAt(differs & ((J->brittle & ~residual) | stronger), LanesOf(0.), most);
}

/* Trial stress in the middle. */
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
  Lanes sigma[2] = {spring[0], spring[1]}, sm = spring[2]; /* with dashpots */
  if (damped) {
    for (int k = 0; k < 2; k++) sigma[k] += DashpotStress(J, spring[k], c->dashpot[k]);
    sm += DashpotStress(J, sm, Line(c->dashpot, LanesOf(0.)));
  }
  Lanes limit[2], held[2], normal = {0.}, tm = {0.}, limit_m = {0.};
  Hold hold = {{0}, {0.}, {0.}};

  /* failure, with the trial stresses */
  if (Any(J->brittle)) BreakPoints(J, middle, sigma, sm, tau, c->broken);
  const Mask residual = (c->broken[0] > 0.5) | (c->broken[1] > 0.5);
  for (int k = 0; k < 2; k++) {
    const LanesStrength strength = StrengthOf(J, EndIsResidual(c->broken, k));
    limit[k] = JointShearLimit(J, &strength, sigma[k]);
  }

  /* return of shear */
  if (middle) hold = HoldMiddle(J, closes, sigma, sm, c->broken, residual, limit);
  ReturnShear(middle, &hold, tau, limit, held);
  EndStresses(J, sigma, tau, c);
  if (damped) SpringStresses(J, spring, c);
  AdvanceSlip(J, tau, held, c);

  /* forces */
  if (middle) {
    const LanesStrength strength = StrengthOf(J, residual);
    normal = JointNormal(J, &strength, spring[2]);
    limit_m = JointShearLimit(J, &strength, sm);
    tm = JointClip(Line(held, LanesOf(0.)), limit_m);
  }
  for (int k = 0; k < 2; k++) {
    c->F_n[k] = c->length * (row[0] * c->sigma[k] + row[1] * normal + row[2] * c->sigma[1 - k]);
    c->F_s[k] = c->length * (row[0] * c->tau[k] + row[1] * tm + row[2] * c->tau[1 - k]);
    if (bounds) c->most[k] = c->length * (row[0] * limit[k] + row[1] * limit_m + row[2] * limit[1 - k]);
  }
}

/* ------------------------------------------------------------------------------------------------ */

/* sigma, tau: trial stresses, from u_n, u_s and the history */
KERNEL void TrialStresses(const LanesJoint *J, int closes, LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->sigma[k] = J->k_n * (closes ? c->u_n[k] - ClosureOfEnd(c, k) : c->u_n[k]); /* (5) */
    c->tau[k] = J->k_s * (c->u_s[k] - c->slip[k]);                                /* (6) */
  }
}

/* Of contacts without history: returns whether the law holds elastically in all lanes, and then what
   RespondContacts answers; otherwise nothing. */
KERNEL int RespondElastically(const LanesJoint *J, const LanesModel *model, LanesContact *c)
{
  TrialStresses(J, 0, c);
  if (Any(~IsElastic(J, 0, c))) return 0;
  RespondElastic(model->elastic, c);
  return 1;
}

/* Whether the law holds elastically at both ends with dashpots as well. */
KERNEL Mask IsElasticDamped(const LanesJoint *J, int closes, const LanesContact *c)
{
  LanesContact total;
  for (int k = 0; k < 2; k++) {
    total.sigma[k] = c->sigma[k] + DashpotStress(J, c->sigma[k], c->dashpot[k]);
    total.tau[k] = c->tau[k], total.broken[k] = c->broken[k];
    if (closes) total.closure[k] = c->closure[k];
  }
  return IsElastic(J, closes, &total);
}

/* Adds forces of dashpots to those of springs, whose trial stresses at the ends are `spring`. */
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

/* By the model, in lanes that are not elastic; all others take the elastic row. closes, damped: see
   RespondJoint; bounds: a constant, whether c->most is asked for. */
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
  if (model->moving)
    RespondMoving(J, in_time, closes, damped, c);
  else
    RespondFixed(J, model->row, closes, damped, bounds, c);
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

/* Stresses, history, state and end forces from u_n, u_s and the history. All lanes take the elastic row;
   only when a lane's law does not hold elastically is the model asked, and answers for those lanes. closes,
   damped: constants, 0 where no joint can crush and nothing has been crushed, and where there are no
   dashpots. Returns whether the history may have changed. */
KERNEL int RespondJoint(const LanesJoint *J, const LanesModel *model, int in_time, int closes, int damped,
                        LanesContact *c)
{
  TrialStresses(J, closes, c);
  Mask elastic = IsElastic(J, closes, c);
  if (damped) elastic &= IsElasticDamped(J, closes, c);
  if (!Any(~elastic)) {
    RespondElastic(model->elastic, c);
    if (damped) AddDashpots(J, model, closes, c->sigma, c);
    return 0;
  }
  RespondByModel(J, model, in_time, closes, damped, 0, elastic, c);
  return 1;
}

/* The same of contacts that may have met in motion. */
KERNEL int RespondContacts(const LanesJoint *J, const LanesModel *model, int in_time, int closes, int damped,
                           LanesContact *c)
{
  const Mask loose = c->broken[0] >= LOOSE;
  if (!Any(loose)) return RespondJoint(J, model, in_time, closes, damped, c);
  const LanesJoint now = LooseJoint(J, loose);
  return RespondJoint(&now, model, in_time, closes, damped, c);
}

/* Slip of both ends at which the elastic row gives the end forces F: u_s - tau/k_s with the line tau of F. */
KERNEL void SlipOfForces(const LanesJoint *J, const PetscReal row[2], const LanesContact *c, const Lanes F[2],
                         Lanes slip[2])
{
  const PetscReal determinant = row[0] * row[0] - row[1] * row[1];
  for (int k = 0; k < 2; k++)
    slip[k] = c->u_s[k] - (row[0] * F[k] - row[1] * F[1 - k]) / (determinant * c->length * J->k_s);
}

/* Friction on the way to an equilibrium (head of follow.c): end forces F_s of elastic-plastic springs, which
   keep their slip, drawn by `pull` of the difference towards those of the law with the history c->slip,
   c->broken; by pull/tan(phi) where friction is steeper than 1, as its curl is. own: slip of the springs, in
   and out. A contact that the law holds elastically, and whose springs have no other slip, is elastic.
   Returns whether any is not. */
KERNEL int FollowJoint(const LanesJoint *J, const LanesModel *model, PetscReal pull, int closes, Lanes own[2],
                       LanesContact *c)
{
  const PetscReal *row = model->elastic;
  const Lanes from[2] = {c->slip[0], c->slip[1]},
              steep = Select(J->peak.tan_phi < J->residual.tan_phi, J->residual.tan_phi, J->peak.tan_phi),
              part = pull / Select(steep > 1., steep, LanesOf(1.));
  Lanes slip[2], tau[2], T[2], F[2];
  TrialStresses(J, closes, c);
  const Mask elastic = IsElastic(J, closes, c),
             plain = elastic & (((own[0] == from[0]) & (own[1] == from[1])) | J->elastic | (J->k_s <= 0.));
  if (!Any(~plain)) {
    RespondElastic(row, c);
    return 0;
  }
  RespondByModel(J, model, 0, closes, 0, 1, elastic, c);
  SlipOfForces(J, row, c, c->F_s, slip);
  for (int k = 0; k < 2; k++) {
    slip[k] = own[k] + part * (Select(elastic, from[k], slip[k]) - own[k]);
    tau[k] = J->k_s * (c->u_s[k] - slip[k]);
  }
  for (int k = 0; k < 2; k++) T[k] = c->length * (row[0] * tau[k] + row[1] * tau[1 - k]);
  ReturnForces(row[1] / row[0], T, c->most, F);
  const Mask whole = (F[0] == T[0]) & (F[1] == T[1]);
  Lanes returned[2];
  SlipOfForces(J, row, c, F, returned);
  for (int k = 0; k < 2; k++) {
    own[k] = Select(plain, own[k], Select(whole, slip[k], returned[k]));
    c->F_s[k] = Select(plain, c->F_s[k], F[k]);
  }
  return 1;
}

KERNEL int RespondFollowing(const LanesJoint *J, const LanesModel *model, PetscReal pull, int closes,
                            Lanes own[2], LanesContact *c)
{
  const Mask loose = c->broken[0] >= LOOSE;
  if (!Any(loose)) return FollowJoint(J, model, pull, closes, own, c);
  const LanesJoint now = LooseJoint(J, loose);
  return FollowJoint(&now, model, pull, closes, own, c);
}

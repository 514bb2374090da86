/* storage.c: computes the storage of water in joints during transient flow, and its discharges.

   An end of a piece stores the volume a (chi + p / K_w) over half the piece's length. Over a step this
   volume changes by the inflow, with

   a = a_r + (p - p_r) c where it is wet.

   a_r is the aperture measured at pressure p_r, and c the compliance of the joint. The rest of the change
   of aperture comes from the next equilibrium (fixed-stress split). With c = 1/k_n independent blocks take
   one round; at the end of the rounds p = p_r, whatever c is.

   Backward Euler alone lags: where pressures decay as exp(-t / T), steps h give an error of h t / (2 T^2),
   4 % after 3 T with steps that change the largest pressure by a fortieth. So steps whose length is free
   come in pairs. A pair is one L-stable step of second order (Alexander's, with g = 1 - 1 / sqrt(2)): over
   h,

   V_1 = V_0 + g h q_1,   V_2 = [V_0 + (1 - g) h q_1] + g h q_2,

   both by backward Euler over g h. The second begins from the bracket, V_0 + (V_1 - V_0) (1 - g) / g. A
   pair needs full joints. Where a joint is partly filled, or a prescribed time of a level shortens the
   second step, steps stay single. */
#include "seepage/flow.h"

PetscReal FlowCompliance(const Scene *scene, const Stage *stage, const FlowNetwork *net, PetscInt i, int k)
{
  const FlowPiece *piece = net->piece + i;
  const FlowRow *row = net->row + piece->row;
  const Joint *joint = stage->joints + row->joint;
  const PetscReal opening = row->opening[0] + piece->s[k] * (row->opening[1] - row->opening[0]),
                  a = joint->aperture + opening;
  (void)scene;
  if (row->parted || a <= joint->aperture_residual || a >= joint->aperture_max) return 0.;
  return piece->a[k] / a / joint->k_n; // a curtain reduces the aperture
}

static int water_order(const FlowWater *w, const PetscInt key[2])
{
  for (int i = 0; i < 2; i++)
    if (w->key[i] != key[i]) return w->key[i] < key[i] ? -1 : 1;
  return 0;
}

/* Returns the first entry of a list that belongs to a contact, or n if none does. */
static PetscInt first_of(const FlowWater *past, PetscInt n, const PetscInt key[2])
{
  PetscInt low = 0, high = n;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;
    if (water_order(past + middle, key) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low < n && !water_order(past + low, key) ? low : n;
}

PetscBool FlowWaterAt(const FlowWater *past, PetscInt n, const PetscInt key[2], PetscReal s, PetscReal within,
                      FlowWater *water)
{
  const PetscReal tie = 1e-9;
  const FlowWater *piece = NULL;
  for (PetscInt i = first_of(past, n, key); i + 1 < n && !water_order(past + i, key); i += 2) {
    if (past[i].s > s + tie || past[i + 1].s < s - tie) continue;
    const PetscBool inside = (PetscBool)(past[i].s <= within && within <= past[i + 1].s);
    if (!piece || inside) piece = past + i;
  }
  if (!piece) return PETSC_FALSE;
  const FlowWater *a = piece, *b = piece + 1;
  const PetscReal at = b->s > a->s ? PetscClipInterval((s - a->s) / (b->s - a->s), 0., 1.) : 0.;
  *water = at > 0.5 ? *b : *a;
  water->a = (1. - at) * a->a + at * b->a; // exact at the ends
  water->psi = (1. - at) * a->psi + at * b->psi, water->chi = (1. - at) * a->chi + at * b->chi;
  return PETSC_TRUE;
}

/* Returns the earlier volume [m] per length at end k of a stretch of a contact that is now `length` long.
   Each half of an earlier piece contributes its common part, so no water is lost where cuts have moved or
   a contact has become longer. */
static PetscReal volume_at(const FlowWater *past, PetscInt n, const PetscInt key[2], const PetscReal s[2],
                           int k, PetscReal length)
{
  const PetscReal middle = 0.5 * (s[0] + s[1]), from = k ? middle : s[0], to = k ? s[1] : middle;
  PetscReal volume = 0.;
  for (PetscInt i = first_of(past, n, key); i + 1 < n && !water_order(past + i, key); i += 2)
    for (int half = 0; half < 2; half++) {
      const FlowWater *end = past + i + half;
      const PetscReal between = 0.5 * (past[i].s + past[i + 1].s), low = half ? between : past[i].s,
                      high = half ? past[i + 1].s : between,
                      common = PetscMin(high, to) - PetscMax(low, from);
      if (common > 0. && high > low) volume += common / (high - low) * (end->length / length) * end->volume;
    }
  return volume;
}

void FlowAhead(const FlowWater *start, PetscInt n_start, FlowWater *middle, PetscInt n_middle)
{
  for (PetscInt e = 0; e < n_middle; e++) {
    FlowWater *end = middle + e;
    const int k = e % 2;
    const PetscReal s[2] = {middle[e - k].s, middle[e - k + 1].s},
                    was = volume_at(start, n_start, end->key, s, k, end->length);
    end->volume = was + FLOW_SECOND * (end->volume - was);
  }
}

void FlowStore(const Scene *scene, const Stage *stage, const FlowWater *past, PetscInt n,
               const PetscReal *reference, FlowNetwork *net)
{
  // one-way coupling: apertures are constant, so a stage begins with its own, not with those of the stage
  // before
  const PetscBool as_measured = (PetscBool)(scene->flow.coupling == FLOW_ONE_WAY &&
                                            stage->water_time <= stage->water_step);
  const PetscReal rho_g = scene->flow.density * scene->gravity, K_w = scene->flow.bulk_modulus;
  for (PetscInt e = 0; e < 2 * net->n_pieces && net->step > 0.; e++) {
    const FlowPiece *piece = net->piece + e / 2;
    const int k = e % 2;
    FlowNode *node = net->node + piece->node[k];
    const PetscInt *key = net->row[piece->row].key;
    const PetscReal w = 0.5 * piece->length / net->step, a = piece->a[k],
                    c = FlowCompliance(scene, stage, net, e / 2, k);
    PetscReal before = volume_at(past, n, key, piece->s, k, piece->length);
    if (as_measured) {
      FlowWater was = {.psi = 0., .chi = 0.};
      FlowWaterAt(past, n, key, piece->s[k], piece->s[1 - k], &was);
      before = a * was.chi + a * rho_g * was.psi / K_w;
    }
    node->wet[0] += w * rho_g * (c + a / K_w);
    node->wet[1] += w * (a - c * rho_g * reference[piece->node[k]] - before);
    node->part[0] += w * a;
    node->part[1] -= w * before;
  }
}

PetscReal FlowVolumeError(const Flow *flow)
{
  const PetscReal rounding = 1e-7; // relative to the volume: less counts as no motion
  const PetscReal made = flow->sums.volume - flow->sums.volume_0 - flow->sums.taken,
                  moved = PetscMax(flow->sums.entered, PetscAbsReal(flow->sums.taken)),
                  least = rounding * PetscMax(flow->sums.volume, flow->sums.volume_0);
  return moved > 0. ? made / PetscMax(moved, least) : 0.;
}

PetscErrorCode FlowJudgeVolume(const Flow *flow, StageResult *result)
{
  const PetscReal error = FlowVolumeError(flow);
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_CONVERGED || PetscAbsReal(error) <= FLOW_VOLUME_WRONG)
    PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_UNDECIDED;
  PetscCall(
      PetscSNPrintf(result->evidence, sizeof(result->evidence),
                    "water does not balance: joints hold %.4g m2 %s than flowed in, %.3g of what moved, "
                    "at most %g is allowed: use shorter steps, time_step",
                    (double)PetscAbsReal(flow->sums.volume - flow->sums.volume_0 - flow->sums.taken),
                    error > 0. ? "more" : "less", (double)PetscAbsReal(error), (double)FLOW_VOLUME_WRONG));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void FlowReportVolume(const TermView *v)
{
  const Flow *flow = v->memory;
  const PetscReal error = FlowVolumeError(flow);
  printf("stage %-12s water in joints: %.4g m2, %.4g m2 taken in, balance %.1e of what moved\n",
         v->stage->name, (double)flow->sums.volume, (double)flow->sums.taken, (double)error);
  fflush(stdout);
  if (PetscAbsReal(error) > FLOW_VOLUME_WARN)
    Warn("stage %s: water in joints does not balance: %.4g m2 were %s, %.2g of what moved, "
         "expected at most %g",
         v->stage->name, (double)PetscAbsReal(flow->sums.volume - flow->sums.volume_0 - flow->sums.taken),
         error > 0. ? "made" : "lost", (double)PetscAbsReal(error), (double)FLOW_VOLUME_WARN);
}

/* Returns the discharge [m2/s] into a drain with resistance. */
static PetscReal taken_by(const Flow *flow, const FlowDrain *drain)
{
  const FlowNode *node = flow->net.node + drain->node;
  if (node->conductance == drain->conductance) return flow->now.drained[drain->node]; // its only drain
  return drain->conductance * (flow->now.pressure[drain->node] + node->x[1] - drain->head);
}

PetscReal FlowDischarge(const Flow *flow, PetscInt load, PetscInt *n)
{
  const FlowNetwork *net = &flow->net;
  PetscReal sum = 0.;
  *n = 0;
  for (const FlowDrain *drain = net->drain; drain < net->drain + net->n_drains; drain++) {
    if (drain->load != load) continue;
    ++*n;
    sum += taken_by(flow, drain);
  }
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    if (net->node[i].load != load || net->node[i].conductance > 0.) continue;
    ++*n;
    sum += flow->now.outflow[i] - (net->node[i].kind == NODE_FREE ? net->node[i].inflow : 0.);
  }
  return sum;
}

/* coupling.c: couples acting pressures and flow by Anderson's method. */
#include "seepage/flow.h"

PetscErrorCode MixerReset(Mixer *mixer)
{
  PetscFunctionBeginUser;
  for (int k = 0; k < MIXED; k++) {
    PetscCall(PetscFree(mixer->x[k]));
    PetscCall(PetscFree(mixer->g[k]));
  }
  mixer->n = mixer->n_old = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal dot(PetscInt n, const PetscReal *a, const PetscReal *b)
{
  PetscReal sum = 0.;
  for (PetscInt i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* Finds the weights w that minimise |r - sum w_j columns_j| by Gram-Schmidt. Overwrites columns; a
   linearly dependent column gets weight 0. */
static void least_squares(PetscInt n, int m, PetscReal *columns[MIXED], const PetscReal *r,
                          PetscReal w[MIXED])
{
  PetscReal R[MIXED][MIXED] = {{0.}}, y[MIXED] = {0.};
  for (int j = 0; j < m; j++) {
    const PetscReal before = dot(n, columns[j], columns[j]);
    for (int k = 0; k < j; k++) {
      R[k][j] = dot(n, columns[k], columns[j]);
      for (PetscInt i = 0; i < n; i++) columns[j][i] -= R[k][j] * columns[k][i];
    }
    const PetscReal after = dot(n, columns[j], columns[j]);
    R[j][j] = after > 1e-16 * before && after > 0. ? PetscSqrtReal(after) : 0.;
    for (PetscInt i = 0; i < n; i++) columns[j][i] = R[j][j] > 0. ? columns[j][i] / R[j][j] : 0.;
    y[j] = dot(n, columns[j], r);
  }
  for (int j = m - 1; j >= 0; j--) {
    w[j] = y[j];
    for (int k = j + 1; k < m; k++) w[j] -= R[j][k] * w[k];
    w[j] = R[j][j] > 0. ? w[j] / R[j][j] : 0.;
  }
}

/* Stores the present round as the newest. */
static PetscErrorCode remember(Mixer *mixer, PetscInt n, const PetscReal *x, const PetscReal *g)
{
  PetscReal *const x_oldest = mixer->x[MIXED - 1], *const g_oldest = mixer->g[MIXED - 1];
  PetscFunctionBeginUser;
  for (int k = MIXED - 1; k > 0; k--) mixer->x[k] = mixer->x[k - 1], mixer->g[k] = mixer->g[k - 1];
  mixer->x[0] = x_oldest, mixer->g[0] = g_oldest;
  if (!mixer->x[0]) PetscCall(PetscMalloc1(n, &mixer->x[0]));
  if (!mixer->g[0]) PetscCall(PetscMalloc1(n, &mixer->g[0]));
  PetscCall(PetscArraycpy(mixer->x[0], x, n));
  PetscCall(PetscArraycpy(mixer->g[0], g, n));
  mixer->n = n, mixer->n_old = PetscMin(mixer->n_old + 1, MIXED);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MixerNext(Mixer *mixer, PetscInt n, const PetscReal *g, PetscReal *x)
{
  PetscReal *columns[MIXED], *r, *now, w[MIXED] = {0.};
  PetscFunctionBeginUser;
  PetscReal before = 0., after = 0., along = 0., part = 1.;
  if (mixer->n != n) PetscCall(MixerReset(mixer));
  for (PetscInt i = 0; i < n && mixer->n_old; i++) {
    const PetscReal was = mixer->g[0][i] - mixer->x[0][i], is = g[i] - x[i];
    before += was * was, after += is * is, along += was * is;
  }
  if (mixer->n_old && after > before) {
    // The last step increased the residual: discard the stored rounds. If it was a plain step that overshot,
    // the iteration oscillates: take half a step.
    if (mixer->n_old == 1 && along < 0.) part = 0.5;
    PetscCall(MixerReset(mixer));
  }
  const int m = mixer->n_old;
  PetscCall(PetscMalloc2(n, &r, n, &now));
  for (PetscInt i = 0; i < n; i++) r[i] = g[i] - x[i];
  for (int j = 0; j < m; j++) {
    PetscCall(PetscMalloc1(n, columns + j));
    for (PetscInt i = 0; i < n; i++) columns[j][i] = r[i] - (mixer->g[j][i] - mixer->x[j][i]);
  }
  least_squares(n, m, columns, r, w);
  PetscCall(PetscArraycpy(now, x, n));
  for (PetscInt i = 0; i < n; i++) {
    x[i] = part < 1. ? x[i] + part * (g[i] - x[i]) : g[i];
    for (int j = 0; j < m; j++) x[i] -= w[j] * (g[i] - mixer->g[j][i]);
    x[i] = PetscMax(x[i], 0.);
  }
  PetscCall(remember(mixer, n, now, g));
  for (int j = 0; j < m; j++) PetscCall(PetscFree(columns[j]));
  PetscCall(PetscFree2(r, now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Limits the next pressures to the highest head of the flow. Higher pressures belong to no flow, and
   damage that they cause would stay. */
static void limit_acting(Flow *flow)
{
  PetscReal top = -PETSC_INFINITY;
  for (PetscInt i = 0; i < flow->net.n_nodes; i++)
    top = PetscMax(top, flow->now.pressure[i] + flow->net.node[i].x[1]);
  for (PetscInt i = 0; i < flow->net.n_nodes; i++)
    flow->acting[i] = PetscMin(flow->acting[i], PetscMax(0., top - flow->net.node[i].x[1]));
}

/* Limits, in transient flow, the change of pressure in a round to a fraction of the largest head or earlier
   pressure. Joints that open faster than 1 / k_n predicts make rounds overshoot, and unphysical pressures
   would throw blocks away. before: (n_nodes,) pressure heads of the last round. */
static void limit_round(Flow *flow, const PetscReal *before)
{
  const PetscReal part = 0.25;
  PetscReal top = 0., most = 0.;
  for (PetscInt i = 0; i < flow->net.n_nodes; i++) {
    const FlowNode *node = flow->net.node + i;
    if (node->kind == NODE_HEAD) top = PetscMax(top, node->head - node->x[1]);
    most = PetscMax(most, PetscAbsReal(flow->acting[i] - before[i]));
  }
  for (PetscInt e = 0; e < flow->n_past; e++) top = PetscMax(top, flow->past[e].psi);
  if (!(flow->net.step > 0.) || top <= 0. || most <= part * top) return;
  for (PetscInt i = 0; i < flow->net.n_nodes; i++)
    flow->acting[i] = before[i] + part * top / most * (flow->acting[i] - before[i]);
}

PetscErrorCode FlowNextRound(Flow *flow)
{
  PetscReal *acted;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(flow->net.n_nodes, &acted));
  PetscCall(PetscArraycpy(acted, flow->acting, flow->net.n_nodes));
  PetscCall(MixerNext(&flow->mixer, flow->net.n_nodes, flow->now.pressure, flow->acting));
  limit_acting(flow);
  limit_round(flow, acted);
  PetscCall(PetscFree(acted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

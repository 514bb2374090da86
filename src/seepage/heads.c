/* heads.c: solves the flow in a network with a free surface: steady, or over a time step (storage.c,
   backward Euler).

   A node has one of three states. Wet: its unknown is the pressure head psi >= 0. Partly filled (transient
   flow only): psi = 0, its unknown is the saturation 0 <= chi <= 1. Dry: its unknown is the fraction 0 <=
   phi <= 1 of a full stream that falls from it. phi = 1 where it holds water, and a steady stream leaves
   the saturation phi. The discharge from node i to node j is

   q = c [(psi_i - psi_j) + phi_up (z_i - z_j)],  phi_up of the upper node,

   and inflow into a free node equals outflow plus storage. A node at a seepage face has psi = 0 and
   discharges water while it is wet; it is not wet where it would take water in. The search begins with all
   nodes wet, or with the states found before. Nodes that violate a bound change their state, until none
   does. A node that has no way down never falls dry; one that has only pockets below is empty when it is
   dry.

   Every rank solves the same equations in the same order with a sequential factor, so all have the same
   bits. */
#include "seepage/flow.h"
#include <petscksp.h>

typedef struct {
  const FlowNetwork *net;
  PetscInt *unknown;    /* (n_nodes,) row of the node's unknown, -1: none */
  FlowWetness *wetness; /* (n_nodes,) */
  PetscBool *pit;       /* (n_nodes,) no path leads down */
  PetscInt n;
  PetscInt *start, *piece; /* (n_nodes + 1,): the pieces at each node */
  PetscInt *queue;         /* (n_nodes,) */
  PetscBool *drains;       /* (n_nodes,) water that enters the node leaves the joints */
  PetscReal eps;           /* [m] smaller pressure heads are zero */
  PetscReal *tiny;         /* (n_nodes,) [m2/s] smaller discharges are rounding */
} Surface;

/* Returns the upper end of a piece; 0 for a level piece. */
static int upper(const FlowNetwork *net, const FlowPiece *piece)
{
  return net->node[piece->node[1]].x[1] > net->node[piece->node[0]].x[1] ? 1 : 0;
}

/* Returns the difference in height [m] of the ends of a piece. */
static PetscReal fall(const FlowNetwork *net, const FlowPiece *piece)
{
  return PetscAbsReal(net->node[piece->node[1]].x[1] - net->node[piece->node[0]].x[1]);
}

/* ---- nodes without water */

PetscErrorCode FlowFindCutOff(const FlowNetwork *net, PetscBool *cut_off, char message[MESSAGE_LENGTH])
{
  enum { SOURCE = 1, OUTLET = 2 };
  PetscInt *parent, *has;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(net->n_nodes, &parent));
  PetscCall(PetscCalloc1(net->n_nodes, &has));
  for (PetscInt i = 0; i < net->n_nodes; i++) parent[i] = i;
  for (PetscInt e = 0; e < net->n_pieces; e++) {
    const PetscInt a = UnionRoot(parent, net->piece[e].node[0]), b = UnionRoot(parent, net->piece[e].node[1]);
    parent[PetscMax(a, b)] = PetscMin(a, b);
  }
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const FlowNode *node = net->node + i;
    const PetscBool drains = (PetscBool)(node->conductance > 0.), stores = (PetscBool)(net->step > 0.);
    if (node->kind == NODE_HEAD || node->inflow > 0. || (drains && node->head > node->x[1]) || stores)
      has[UnionRoot(parent, i)] |= SOURCE;
    if (node->kind != NODE_FREE || drains || stores) has[UnionRoot(parent, i)] |= OUTLET;
  }
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const PetscInt of = has[UnionRoot(parent, i)];
    cut_off[i] = (PetscBool) !(of & SOURCE);
    if (!(of & OUTLET) && net->node[i].inflow > 0. && !message[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              ": an inflow at (%.6g, %.6g) m has no way to a head, a seepage face or a drain",
                              (double)net->node[i].x[0], (double)net->node[i].x[1]));
  }
  PetscCall(PetscFree(parent));
  PetscCall(PetscFree(has));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one linear system */

/* Decides whether the pressure of a node is prescribed. */
static PetscBool is_given(const Surface *s, PetscInt i)
{
  return (PetscBool)(s->net->node[i].kind != NODE_FREE && s->wetness[i] == WET);
}

/* Finds the nodes whose water leaves the joints: through wet nodes in any direction, from a dry node only
   downwards. The other nodes have at most pockets below them. */
static void find_drained(Surface *s)
{
  PetscInt n = 0;
  for (PetscInt i = 0; i < s->net->n_nodes; i++) {
    s->drains[i] = (PetscBool)(is_given(s, i) || s->net->node[i].conductance > 0. || s->net->step > 0.);
    if (s->drains[i]) s->queue[n++] = i;
  }
  for (PetscInt at = 0; at < n; at++)
    for (PetscInt p = s->start[s->queue[at]]; p < s->start[s->queue[at] + 1]; p++) {
      const FlowPiece *piece = s->net->piece + s->piece[p];
      const int end = piece->node[0] == s->queue[at] ? 1 : 0;
      const PetscInt i = piece->node[end];
      const PetscBool falls = (PetscBool)(fall(s->net, piece) > 0. && upper(s->net, piece) == end);
      if (s->drains[i] || (s->wetness[i] == DRY && !falls)) continue;
      s->drains[i] = PETSC_TRUE, s->queue[n++] = i;
    }
}

/* Numbers the unknowns. A node with prescribed pressure has none, nor a dry node with only pockets below:
   nothing falls from it. Returns whether the numbers are unchanged. */
static PetscBool number_unknowns(const FlowSolution *flow, Surface *s)
{
  PetscBool same = PETSC_TRUE;
  s->n = 0;
  find_drained(s);
  for (PetscInt i = 0; i < s->net->n_nodes; i++) {
    const PetscBool empty = (PetscBool)(s->wetness[i] == DRY && !s->drains[i]);
    const PetscInt before = s->unknown[i];
    s->unknown[i] = is_given(s, i) || empty || flow->cut_off[i] ? -1 : s->n++;
    same = (PetscBool)(same && s->unknown[i] == before);
  }
  return same;
}

/* Returns the pressure head [m] of a node without an unknown. */
static PetscReal given_pressure(const FlowNode *node)
{
  return node->kind == NODE_HEAD ? node->head - node->x[1] : 0.;
}

/* Adds the discharge out of node `from` of a piece to the row of this node. */
static PetscErrorCode add_flow(const Surface *s, const FlowPiece *piece, int from, Mat A, PetscReal *b)
{
  const PetscInt i = piece->node[from], row = s->unknown[i];
  PetscFunctionBeginUser;
  if (row < 0) PetscFunctionReturn(PETSC_SUCCESS);
  const int up = upper(s->net, piece);
  for (int k = 0; k < 2; k++) {
    const PetscInt j = piece->node[k], column = s->unknown[j];
    const PetscReal sign = k == from ? 1. : -1.,
                    weight = k == up ? (up == from ? 1. : -1.) * fall(s->net, piece) : 0.;
    const PetscReal psi = column < 0 ? given_pressure(s->net->node + j) : 0.; // known pressure head
    if (s->wetness[j] != DRY) b[row] -= piece->conductance * (sign * psi + weight);
    if (column >= 0 && s->wetness[j] == WET)
      PetscCall(MatSetValue(A, row, column, piece->conductance * sign, ADD_VALUES));
    if (column >= 0 && s->wetness[j] == DRY)
      PetscCall(MatSetValue(A, row, column, piece->conductance * weight, ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode assemble(const Surface *s, Mat *A, PetscReal *b)
{
  const FlowNetwork *net = s->net;
  PetscInt *nnz;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(s->n, &nnz));
  for (PetscInt i = 0; i < s->n; i++) nnz[i] = 1, b[i] = 0.;
  for (PetscInt e = 0; e < net->n_pieces; e++)
    for (int k = 0; k < 2; k++)
      if (s->unknown[net->piece[e].node[k]] >= 0) nnz[s->unknown[net->piece[e].node[k]]]++;
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, s->n, s->n, 0, nnz, A));
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const FlowNode *node = net->node + i;
    const PetscInt row = s->unknown[i];
    if (row < 0) continue;
    const PetscBool wet = (PetscBool)(s->wetness[i] == WET);
    const PetscReal own = wet                       ? node->wet[0] + node->conductance
                          : s->wetness[i] == PARTLY ? node->part[0]
                                                    : 0.;
    b[row] += node->inflow - (wet ? node->wet[1] : node->part[1]) +
              node->conductance * (node->head - node->x[1]);
    PetscCall(MatSetValue(*A, row, row, own, ADD_VALUES));
  }
  for (PetscInt e = 0; e < net->n_pieces; e++)
    for (int k = 0; k < 2; k++) PetscCall(add_flow(s, net->piece + e, k, *A, b));
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscFree(nnz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factors A sequentially: Cholesky if no node is dry, otherwise LU. *factor: a factor of a matrix with the
   same pattern, whose symbolic analysis is reused, or NULL. */
static PetscErrorCode factorise(Mat A, PetscBool symmetric, Mat *factor)
{
  const MatFactorType type = symmetric ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU;
  MatFactorInfo info;
  IS rows, columns;
  PetscFunctionBeginUser;
  PetscCall(MatFactorInfoInitialize(&info));
  info.fill = 5., info.dtcol = 1e-6, info.shifttype = (PetscReal)MAT_SHIFT_NONZERO,
  info.shiftamount = PETSC_MACHINE_EPSILON;
  if (*factor) {
    PetscCall(MatLUFactorNumeric(*factor, A, &info));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatGetOrdering(A, MATORDERINGND, &rows, &columns));
  PetscCall(MatGetFactor(A, MATSOLVERPETSC, type, factor));
  if (symmetric) {
    PetscCall(MatCholeskyFactorSymbolic(*factor, A, rows, &info));
    PetscCall(MatCholeskyFactorNumeric(*factor, A, &info));
  } else {
    PetscCall(MatLUFactorSymbolic(*factor, A, rows, columns, &info));
    PetscCall(MatLUFactorNumeric(*factor, A, &info));
  }
  PetscCall(ISDestroy(&rows));
  PetscCall(ISDestroy(&columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode solve(Mat factor, PetscInt n, PetscReal *b, PetscReal *x)
{
  Vec rhs, solution;
  PetscFunctionBeginUser;
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, b, &rhs));
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, x, &solution));
  PetscCall(MatSolve(factor, rhs, solution));
  PetscCall(VecDestroy(&rhs));
  PetscCall(VecDestroy(&solution));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- discharges, and node states */

/* Computes at each node inflow minus storage. */
static void add_up(const FlowNetwork *net, FlowSolution *flow)
{
  for (PetscInt i = 0; i < net->n_nodes; i++) flow->outflow[i] = net->node[i].inflow - flow->stored[i];
  for (PetscInt e = 0; e < net->n_pieces; e++)
    for (int k = 0; k < 2; k++) flow->outflow[net->piece[e].node[k]] += (k ? 1. : -1.) * flow->discharge[e];
}

static void take_solution(const Surface *s, const PetscReal *x, FlowSolution *flow)
{
  const FlowNetwork *net = s->net;
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const PetscReal value = s->unknown[i] < 0 ? 0. : x[s->unknown[i]];
    const PetscBool wet = (PetscBool)(s->wetness[i] == WET);
    flow->pressure[i] = flow->cut_off[i] || !wet ? 0.
                        : s->unknown[i] < 0      ? given_pressure(net->node + i)
                                                 : value;
    flow->stream[i] = flow->cut_off[i] ? 0. : s->wetness[i] == DRY ? value : 1.;
    flow->saturation[i] = flow->cut_off[i]                         ? 0.
                          : wet                                    ? 1.
                          : s->wetness[i] == DRY && net->step > 0. ? 0.
                                                                   : value;
  }
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const FlowNode *node = net->node + i;
    flow->stored[i] = s->wetness[i] == WET      ? node->wet[0] * flow->pressure[i] + node->wet[1]
                      : s->wetness[i] == PARTLY ? node->part[0] * flow->saturation[i] + node->part[1]
                                                : node->part[1];
    flow->drained[i] = node->conductance * (flow->pressure[i] + node->x[1] - node->head);
  }
  for (PetscInt e = 0; e < net->n_pieces; e++) {
    const FlowPiece *piece = net->piece + e;
    const PetscInt *node = piece->node;
    const int up = upper(net, piece);
    flow->discharge[e] = piece->conductance * ((flow->pressure[node[0]] - flow->pressure[node[1]]) +
                                               (up ? -1. : 1.) * flow->stream[node[up]] * fall(net, piece));
  }
  add_up(net, flow);
}

/* Returns the state that a node should have according to its solution. beyond receives the violation of
   its bound [m or -]. */
static FlowWetness wetness_of(const Surface *s, const FlowSolution *flow, PetscInt i, PetscReal *beyond)
{
  const FlowNode *node = s->net->node + i;
  const PetscBool stores = (PetscBool)(s->net->step > 0.);
  const PetscReal part = s->wetness[i] == DRY ? flow->stream[i] : flow->saturation[i];
  *beyond = 0.;
  if (flow->cut_off[i] || node->kind == NODE_HEAD) return s->wetness[i];
  if (s->wetness[i] == WET) {
    const PetscReal lack = node->kind == NODE_SEEP ? (flow->outflow[i] < -s->tiny[i] ? 1. : 0.)
                                                   : -flow->pressure[i];
    if (lack <= (node->kind == NODE_SEEP ? 0. : s->eps) || (s->pit[i] && !stores)) return WET;
    *beyond = lack;
    return stores ? PARTLY : DRY;
  }
  if (part > 1. + 1e-9) *beyond = part - 1.;
  if (s->unknown[i] < 0 && flow->outflow[i] > s->tiny[i])
    *beyond = 1.; // water that cannot leave fills the node
  if (s->wetness[i] == DRY) return *beyond > 0. ? (stores ? PARTLY : WET) : DRY;
  if (part < -1e-9 && !s->pit[i]) *beyond = -part;
  return *beyond == 0. ? PARTLY : part > 1. ? WET : DRY;
}

/* Changes the state of the nodes that violate a bound; after many rounds only of the worst one. Returns
   the number of violations. */
static PetscInt change_sides(const Surface *s, const FlowSolution *flow, PetscInt round)
{
  enum { ALL_AT_ONCE = 40 };
  PetscInt n = 0, worst = -1;
  FlowWetness worst_wetness = WET;
  PetscReal most = 0., beyond;
  for (PetscInt i = 0; i < s->net->n_nodes; i++) {
    const FlowWetness wetness = wetness_of(s, flow, i, &beyond);
    if (wetness == s->wetness[i]) continue;
    n++;
    if (beyond > most) most = beyond, worst = i, worst_wetness = wetness;
    if (round < ALL_AT_ONCE) s->wetness[i] = wetness;
  }
  if (n && round >= ALL_AT_ONCE) s->wetness[worst] = worst_wetness;
  return n;
}

/* Decides whether the discharges must balance at a node. */
static PetscBool balances(const Surface *s, PetscInt i)
{
  return (PetscBool)(s->net->node[i].kind == NODE_FREE || s->wetness[i] != WET);
}

/* Corrects discharges by the imbalance of the nodes. Heads alone are not accurate enough: where a wide
   joint meets a tight one, the last digit of a head in the wide joint is more water than the tight one
   takes. largest receives the largest correction of an unknown [m or -]. x, b: (n_nodes,) */
static PetscErrorCode refine(const Surface *s, Mat factor, PetscReal *x, PetscReal *b, FlowSolution *flow,
                             PetscReal *largest)
{
  const FlowNetwork *net = s->net;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < net->n_nodes; i++)
    if (s->unknown[i] >= 0) b[s->unknown[i]] = flow->outflow[i] - flow->drained[i];
  PetscCall(solve(factor, s->n, b, x));
  *largest = 0.;
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const PetscReal d = s->unknown[i] >= 0 ? x[s->unknown[i]] : 0.;
    const FlowNode *node = net->node + i;
    *largest = PetscMax(*largest, PetscAbsReal(d));
    if (s->wetness[i] == WET) flow->pressure[i] += d, flow->drained[i] += node->conductance * d;
    if (s->wetness[i] == DRY) flow->stream[i] += d;
    if (s->wetness[i] == PARTLY || (s->wetness[i] == DRY && net->step == 0.)) flow->saturation[i] += d;
    flow->stored[i] += (s->wetness[i] == WET      ? node->wet[0]
                        : s->wetness[i] == PARTLY ? node->part[0]
                                                  : 0.) *
                       d;
  }
  for (PetscInt e = 0; e < net->n_pieces; e++) {
    const FlowPiece *piece = net->piece + e;
    const PetscInt *node = piece->node;
    const int up = upper(net, piece);
    PetscReal d[2] = {0., 0.}, fallen = 0.;
    for (int k = 0; k < 2; k++)
      if (s->unknown[node[k]] >= 0) d[k] = x[s->unknown[node[k]]];
    if (s->wetness[node[up]] == DRY) fallen = (up ? -1. : 1.) * d[up] * fall(net, piece);
    for (int k = 0; k < 2; k++)
      if (s->wetness[node[k]] != WET) d[k] = 0.;
    flow->discharge[e] += piece->conductance * (d[0] - d[1] + fallen);
  }
  add_up(net, flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes inflow, storage and the largest imbalance of a node. resolution: [-] of heads. */
static void balance(const Surface *s, PetscReal resolution, FlowSolution *flow)
{
  const FlowNetwork *net = s->net;
  PetscReal worst = 0., rounding = 0.;
  flow->inflow = flow->taken = 0.;
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const FlowNode *node = net->node + i;
    if (flow->cut_off[i]) flow->outflow[i] = 0.;
    if (balances(s, i)) {
      worst = PetscMax(worst, PetscAbsReal(flow->outflow[i] - flow->drained[i]));
      flow->outflow[i] = flow->drained[i];
    }
    flow->inflow += PetscMax(0., -flow->outflow[i]) + node->inflow;
    flow->taken += flow->stored[i];
    flow->pressure[i] = PetscMax(flow->pressure[i], 0.);
    rounding = PetscMax(rounding, 1e-2 * s->tiny[i]);
  }
  const PetscReal moves = PetscMax(flow->inflow, PetscAbsReal(flow->taken));
  flow->error = PetscMax(resolution, moves > rounding ? worst / moves : 0.);
}

/* Sets the thresholds below which values are rounding. Returns the range of heads [m]. */
static PetscReal set_rounding(Surface *s)
{
  const FlowNetwork *net = s->net;
  PetscReal low = PETSC_INFINITY, high = -PETSC_INFINITY;
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    const FlowNode *node = net->node + i;
    low = PetscMin(low, node->x[1]),
    high = PetscMax(high, PetscMax(node->x[1], node->load >= 0 ? node->head : node->x[1]));
  }
  const PetscReal head = PetscMax(high - low, PETSC_SMALL);
  s->eps = 1e-10 * head;
  for (PetscInt e = 0; e < net->n_pieces; e++)
    for (int k = 0; k < 2; k++) s->tiny[net->piece[e].node[k]] += 1e-13 * net->piece[e].conductance * head;
  return head;
}

/* Finds the nodes without a path downwards. */
static PetscErrorCode find_pits(Surface *s)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < s->net->n_nodes; i++) s->pit[i] = PETSC_TRUE;
  for (PetscInt e = 0; e < s->net->n_pieces; e++)
    if (fall(s->net, s->net->piece + e) > 0.)
      s->pit[s->net->piece[e].node[upper(s->net, s->net->piece + e)]] = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode surface_create(const FlowNetwork *net, Surface *s)
{
  const PetscInt n = net->n_nodes;
  PetscFunctionBeginUser;
  s->net = net;
  PetscCall(PetscCalloc5(n, &s->unknown, n, &s->pit, n, &s->tiny, n, &s->queue, n, &s->drains));
  PetscCall(PetscCalloc2(n + 2, &s->start, 2 * net->n_pieces, &s->piece));
  for (PetscInt e = 0; e < 2 * net->n_pieces; e++) s->start[net->piece[e / 2].node[e % 2] + 2]++;
  for (PetscInt i = 0; i < n; i++) s->start[i + 2] += s->start[i + 1];
  for (PetscInt e = 0; e < 2 * net->n_pieces; e++)
    s->piece[s->start[net->piece[e / 2].node[e % 2] + 1]++] = e / 2;
  PetscCall(find_pits(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode surface_destroy(Surface *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(s->unknown, s->pit, s->tiny, s->queue, s->drains));
  PetscCall(PetscFree2(s->start, s->piece));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowSolutionDestroy(FlowSolution *flow)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree7(flow->pressure, flow->saturation, flow->stream, flow->outflow, flow->stored,
                       flow->cut_off, flow->discharge));
  PetscCall(PetscFree2(flow->drained, flow->wetness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the state with which the search begins: one that the search could also reach. */
static FlowWetness first_state(const Surface *s, const PetscBool *cut_off, PetscInt i)
{
  const FlowNode *node = s->net->node + i;
  if (node->first == WET || cut_off[i] || node->kind == NODE_HEAD) return WET;
  if (s->net->step > 0.) return node->first == DRY && !s->pit[i] ? DRY : PARTLY;
  return s->pit[i] ? WET : DRY;
}

PetscErrorCode FlowSolve(const FlowNetwork *net, FlowSolution *flow, char message[MESSAGE_LENGTH])
{
  enum { MOST_ROUNDS = 1000, MOST_PASSES = 20 };
  const PetscReal RESOLVED = 1e-9; /* [-] smaller corrections of heads are rounding */
  const PetscInt n = net->n_nodes;
  Surface s = {0};
  PetscReal *x, *b, largest = 0.;
  Mat factor = NULL;
  PetscFunctionBeginUser;
  PetscCall(FlowSolutionDestroy(flow));
  PetscCall(PetscCalloc7(n, &flow->pressure, n, &flow->saturation, n, &flow->stream, n, &flow->outflow, n,
                         &flow->stored, n, &flow->cut_off, net->n_pieces, &flow->discharge));
  PetscCall(PetscCalloc2(n, &flow->drained, n, &flow->wetness));
  PetscCall(FlowFindCutOff(net, flow->cut_off, message));
  PetscCall(surface_create(net, &s));
  s.wetness = flow->wetness;
  for (PetscInt i = 0; i < n; i++) s.wetness[i] = first_state(&s, flow->cut_off, i);
  PetscCall(PetscMalloc2(n, &x, n, &b));
  const PetscReal head = set_rounding(&s);
  for (PetscInt round = 0, left = 1; left && !message[0]; round++) {
    const PetscBool same = number_unknowns(flow, &s);
    PetscBool symmetric = PETSC_TRUE;
    Mat A;
    for (PetscInt i = 0; i < n; i++) symmetric = (PetscBool)(symmetric && s.wetness[i] == WET);
    // Steady flow: wet and dry nodes have the same matrix pattern, so the analysis is reused. Partly filled
    // nodes have another.
    if (!same || symmetric || net->step > 0.) PetscCall(MatDestroy(&factor));
    PetscCall(assemble(&s, &A, b));
    if (s.n) PetscCall(factorise(A, symmetric, &factor));
    if (s.n) PetscCall(solve(factor, s.n, b, x));
    PetscCall(MatDestroy(&A));
    take_solution(&s, x, flow);
    for (int i = 0; i < MOST_PASSES && s.n && (!i || largest > 1e-12 * head); i++)
      PetscCall(refine(&s, factor, x, b, flow, &largest));
    if (symmetric) PetscCall(MatDestroy(&factor));
    left = change_sides(&s, flow, round);
    flow->rounds = round + 1;
    if (left && round >= MOST_ROUNDS)
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, ": the free surface is not found in %d rounds",
                              MOST_ROUNDS));
  }
  PetscCall(MatDestroy(&factor));
  balance(&s, largest > RESOLVED * head ? largest / head : 0., flow);
  PetscCall(PetscFree2(x, b));
  PetscCall(surface_destroy(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* coarse.c: estimates where the free surface of a large network lies, from a network of fewer nodes. All
   nodes of a square become one node; each coarser network begins with the estimate of a still coarser one.
   With 1e5 joints, a search that begins with all nodes wet takes ten rounds, a search from this estimate
   four. The estimate is only where the search begins: a square may join nodes that no joint connects. */
#include "seepage/flow.h"

/* Computes the least coordinates of the nodes, the extent from there, and the side of a square that
   contains about NODES_EACH nodes. Works for nodes in a plane and in a row. */
static void measure(const FlowNetwork *net, PetscReal low[2], PetscReal size[2], PetscReal *side)
{
  enum { NODES_EACH = 16 };
  const PetscReal part = (PetscReal)NODES_EACH / (PetscReal)net->n_nodes;
  PetscReal high[2] = {-PETSC_INFINITY, -PETSC_INFINITY};
  low[0] = low[1] = PETSC_INFINITY;
  for (PetscInt i = 0; i < net->n_nodes; i++)
    for (int k = 0; k < 2; k++)
      low[k] = PetscMin(low[k], net->node[i].x[k]), high[k] = PetscMax(high[k], net->node[i].x[k]);
  for (int k = 0; k < 2; k++) size[k] = high[k] - low[k];
  *side = PetscMax(PetscSqrtReal(part * size[0] * size[1]),
                   PetscMax(part * PetscMax(size[0], size[1]), PETSC_SMALL));
}

/* Assigns the nodes to numbered squares: (n_nodes,). n receives the number of squares with nodes. */
static PetscErrorCode find_squares(const FlowNetwork *net, PetscInt *square, PetscInt *n)
{
  PetscReal low[2], size[2], side;
  PetscInt *number, across[2];
  PetscFunctionBeginUser;
  measure(net, low, size, &side);
  for (int k = 0; k < 2; k++) across[k] = 1 + (PetscInt)(size[k] / side);
  PetscCall(PetscMalloc1(across[0] * across[1], &number));
  for (PetscInt i = 0; i < across[0] * across[1]; i++) number[i] = -1;
  *n = 0;
  for (PetscInt i = 0; i < net->n_nodes; i++) {
    PetscInt at[2];
    for (int k = 0; k < 2; k++) at[k] = (PetscInt)((net->node[i].x[k] - low[k]) / side);
    PetscInt *of = number + across[0] * at[1] + at[0];
    if (*of < 0) *of = (*n)++;
    square[i] = *of;
  }
  PetscCall(PetscFree(number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a node to the node of its square, whose coordinates are sums until coarsen divides them. */
static void add_node(const FlowNode *from, FlowNode *to)
{
  for (int k = 0; k < 2; k++)
    to->x[k] += from->x[k], to->wet[k] += from->wet[k], to->part[k] += from->part[k];
  to->inflow += from->inflow, to->conductance += from->conductance;
  if (from->kind == NODE_HEAD || (to->kind != NODE_HEAD && from->load >= 0))
    to->load = from->load, to->head = from->head;
  if (from->kind == NODE_HEAD || to->kind == NODE_FREE) to->kind = from->kind;
}

/* Builds the network with one node per square. square: (n_nodes,) of `net`; n squares. */
static PetscErrorCode coarsen(const FlowNetwork *net, const PetscInt *square, PetscInt n, FlowNetwork *coarse)
{
  PetscInt *members;
  PetscFunctionBeginUser;
  *coarse = (FlowNetwork){.n_nodes = n, .step = net->step};
  PetscCall(PetscCalloc2(n, &coarse->node, net->n_pieces, &coarse->piece));
  PetscCall(PetscCalloc1(n, &members));
  for (PetscInt i = 0; i < n; i++) coarse->node[i].load = -1;
  for (PetscInt i = 0; i < net->n_nodes; i++)
    add_node(net->node + i, coarse->node + square[i]), members[square[i]]++;
  for (PetscInt i = 0; i < n; i++) {
    FlowNode *node = coarse->node + i;
    for (int k = 0; k < 2; k++) node->x[k] /= members[i];
    if (node->kind == NODE_HEAD && node->head <= node->x[1]) node->kind = NODE_SEEP;
  }
  for (PetscInt e = 0; e < net->n_pieces; e++) {
    const FlowPiece *piece = net->piece + e;
    const PetscInt a = square[piece->node[0]], b = square[piece->node[1]];
    const PetscReal *x = coarse->node[a].x, *y = coarse->node[b].x;
    const PetscReal distance = PetscSqrtReal(PetscSqr(x[0] - y[0]) + PetscSqr(x[1] - y[1]));
    if (a == b || distance <= 0.) continue;
    coarse->piece[coarse->n_pieces++] = (FlowPiece){
        .node = {a, b}, .length = distance, .conductance = piece->conductance * piece->length / distance};
  }
  PetscCall(PetscFree(members));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowGuess(FlowNetwork *net)
{
  enum { FEW = 1000 }; /* nodes; a network with no more is searched directly */
  char message[MESSAGE_LENGTH] = "";
  PetscInt *square, n;
  FlowNetwork coarse;
  FlowSolution flow = {0};
  PetscFunctionBeginUser;
  if (net->n_nodes <= FEW) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(net->n_nodes, &square));
  PetscCall(find_squares(net, square, &n));
  PetscCall(coarsen(net, square, n, &coarse));
  PetscCall(FlowGuess(&coarse));
  PetscCall(FlowSolve(&coarse, &flow, message));
  for (PetscInt i = 0; i < net->n_nodes && !message[0]; i++) {
    const PetscInt of = square[i];
    const PetscBool under = (PetscBool)(net->node[i].x[1] <= coarse.node[of].x[1] + flow.pressure[of]);
    net->node[i].first = flow.wetness[of] == WET && !under ? PARTLY : flow.wetness[of];
  }
  PetscCall(FlowSolutionDestroy(&flow));
  PetscCall(PetscFree2(coarse.node, coarse.piece));
  PetscCall(PetscFree(square));
  PetscFunctionReturn(PETSC_SUCCESS);
}

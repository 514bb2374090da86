/* Heads of water in a network: a bridge by hand, free surfaces, pits, what no head reaches, drains, random
   networks, searches that begin with what is known. */
#include "seepage/flow.h"
#include "check.h"
#include <string.h>

enum { MOST_NODES = 1296, MOST_PIECES = 2592 };
/* A network by hand. */
typedef struct {
  FlowNode node[MOST_NODES];
  FlowPiece piece[MOST_PIECES];
  FlowNetwork net;
} Pipes;

static void start(Pipes *p)
{
  memset(p, 0, sizeof *p);
  p->net.node = p->node, p->net.piece = p->piece;
}

static PetscInt free_node(Pipes *p, double x, double z)
{
  p->node[p->net.n_nodes] = (FlowNode){.kind = NODE_FREE, .load = -1, .x = {x, z}};
  return p->net.n_nodes++;
}

/* A node under water, or, where the level is lower, at a seepage face. */
static PetscInt held_node(Pipes *p, double x, double z, double level)
{
  const PetscInt i = free_node(p, x, z);
  p->node[i].kind = level > z ? NODE_HEAD : NODE_SEEP, p->node[i].load = 0,
  p->node[i].head = level > z ? level : z;
  return i;
}

static PetscInt pipe(Pipes *p, PetscInt a, PetscInt b, double conductance)
{
  p->piece[p->net.n_pieces] = (FlowPiece){.node = {a, b}, .conductance = conductance, .length = 1};
  return p->net.n_pieces++;
}

/* W03: z of A, B, C, D: 1, 0, 3, 0 m; five joints; 300 kPa at A, none at D. Values of a reference of its
   own. */
static PetscErrorCode Bridge(void)
{
  enum { A, B, C, D };
  static const struct {
    int from, to;
    double a, length, q;
  } joint[] = {{A, B, 2e-4, 5, 1.43877e-5},
               {A, C, 1e-4, 5, 4.54419e-6},
               {B, C, 1.5e-4, 4, 1.15835e-5},
               {B, D, 1e-4, 6, 2.80419e-6},
               {C, D, 2.5e-4, 3, 1.61277e-5}};
  const double gw = 9810., mu = 1e-3;
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  held_node(&p, 0, 1, 1 + 300e3 / gw), free_node(&p, 3, 0), free_node(&p, 4.5, 3), held_node(&p, 4.5, 0, 0);
  for (int i = 0; i < 5; i++)
    pipe(&p, joint[i].from, joint[i].to, gw * pow(joint[i].a, 3) / (12 * mu * joint[i].length));
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE(!message[0]);
  ENSURE_NEAR(gw * flow.pressure[B], 201.902e3, 1e-5 * 201.902e3);
  ENSURE_NEAR(gw * flow.pressure[C], 7.7283e3, 1e-5 * 7.7283e3);
  for (int i = 0; i < 5; i++) ENSURE_NEAR(flow.discharge[i], joint[i].q, 1e-5 * joint[i].q);
  ENSURE_NEAR(flow.inflow, 1.89319e-5, 1e-5 * 1.89319e-5);
  ENSURE_NEAR(-flow.outflow[A], flow.outflow[D], 1e-8 * flow.inflow);
  ENSURE(flow.error <= 1e-8);
  for (int i = 0; i < 4; i++) ENSURE(flow.saturation[i] == 1 && !flow.cut_off[i]);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* A joint of four metres stands in water of 1.5 m and takes in `inflow` at its top; c = 1 for each metre. Its
   water table is by hand: above it q = chi, below it psi rises by 1 - q for each metre. */
static PetscErrorCode falls(double inflow, const double psi[5], const double chi[5])
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  held_node(&p, 0, 0, 1.5);
  for (int i = 1; i < 5; i++) pipe(&p, free_node(&p, 0, i), i - 1, 1.);
  p.node[4].inflow = inflow;
  PetscCall(FlowSolve(&p.net, &flow, message));
  for (int i = 0; i < 5; i++) {
    ENSURE_NEAR(flow.pressure[i], psi[i], 1e-12);
    ENSURE_NEAR(flow.saturation[i], chi[i], 1e-12);
  }
  ENSURE_NEAR(flow.outflow[0], inflow, 1e-12);
  ENSURE(!message[0] && flow.error <= 1e-8);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

static PetscErrorCode WaterTable(void)
{
  PetscCall(falls(0.1, (double[]){1.5, 0.6, 0, 0, 0}, (double[]){1, 1, 0.7, 0.1, 0.1}));
  PetscCall(falls(0.4, (double[]){1.5, 0.9, 0.3, 0, 0}, (double[]){1, 1, 1, 0.7, 0.4}));
  PetscCall(falls(2., (double[]){1.5, 2.5, 3.5, 4.5, 5.5}, (double[]){1, 1, 1, 1, 1}));
  PetscCall(falls(0., (double[]){1.5, 0.5, 0, 0, 0}, (double[]){1, 1, 0.5, 0, 0}));
  return 0;
}

/* A joint from a reservoir forks to a seepage face a metre above and one a metre below; c = 1 each. The upper
   end gives off water only when the fork has more than a metre of pressure. */
static PetscErrorCode SeepageFace(void)
{
  static const struct {
    double level, psi, upper_chi, upper_out, lower_out;
  } known[] = {{2, 0.5, 0.5, 0, 1.5}, {4, 4. / 3., 1, 1. / 3., 7. / 3.}};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
    char message[MESSAGE_LENGTH] = "";
    Pipes p;
    FlowSolution flow = {0};
    start(&p);
    const PetscInt up = held_node(&p, 0, 0, known[k].level), fork = free_node(&p, 1, 0),
                   high = held_node(&p, 2, 1, 0), low = held_node(&p, 2, -1, -5);
    pipe(&p, up, fork, 1), pipe(&p, high, fork, 1), pipe(&p, fork, low, 1);
    PetscCall(FlowSolve(&p.net, &flow, message));
    ENSURE_NEAR(flow.pressure[fork], known[k].psi, 1e-12);
    ENSURE_NEAR(flow.saturation[high], known[k].upper_chi, 1e-12);
    ENSURE_NEAR(flow.outflow[high], known[k].upper_out, 1e-12);
    ENSURE_NEAR(flow.outflow[low], known[k].lower_out, 1e-12);
    ENSURE(flow.pressure[high] == 0 && flow.pressure[low] == 0);
    ENSURE(!message[0] && flow.error <= 1e-8);
    PetscCall(FlowSolutionDestroy(&flow));
  }
  return 0;
}

/* Nodes without a way down: in a bend that water passes; at the end of a blind joint under water; at the
   end of one that hangs from a dry joint, where no pressure comes about. */
static PetscErrorCode Pits(void)
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  const PetscInt in = held_node(&p, 0, 0, 0.5), bend = free_node(&p, 1, -2), out = held_node(&p, 2, 0, 0),
                 blind = free_node(&p, 0, -3);
  pipe(&p, in, bend, 1), pipe(&p, bend, out, 1), pipe(&p, in, blind, 1);
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE_NEAR(flow.pressure[bend], 2.25, 1e-12);
  ENSURE_NEAR(flow.outflow[out], 0.25, 1e-12);
  ENSURE_NEAR(flow.pressure[blind], 3.5, 1e-12);
  start(&p);
  const PetscInt top = free_node(&p, 0, 1), pit = free_node(&p, 0, 0), gate = held_node(&p, 1, -1, -1);
  pipe(&p, top, pit, 1), pipe(&p, top, gate, 1);
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE_NEAR(flow.pressure[pit], 0., 1e-12);
  ENSURE_NEAR(flow.saturation[top], 0., 1e-12);
  ENSURE_NEAR(flow.outflow[gate], 0., 1e-12);
  ENSURE(!message[0] && flow.error <= 1e-8);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* What has no way to a head stays without pressure, and water may not be pumped into it. */
static PetscErrorCode CutOff(void)
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  const PetscInt up = held_node(&p, 0, 0, 6), middle = free_node(&p, 1, 0), down = held_node(&p, 2, 0, 2),
                 lost = free_node(&p, 7, -4), end = free_node(&p, 8, -5);
  pipe(&p, up, middle, 1), pipe(&p, middle, down, 1), pipe(&p, lost, end, 1);
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE(!message[0]);
  ENSURE_NEAR(flow.pressure[middle], 4, 1e-12);
  ENSURE(flow.cut_off[lost] && flow.cut_off[end] && !flow.cut_off[middle] && !flow.cut_off[up]);
  ENSURE(flow.pressure[lost] == 0 && flow.pressure[end] == 0 && flow.discharge[2] == 0);
  ENSURE(flow.error <= 1e-8);
  p.node[end].inflow = 1e-6;
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE(strstr(message, "(8, -5) m has no way to") != NULL);
  message[0] = 0;
  p.node[lost].conductance = 1, p.node[lost].head = -4, p.node[lost].load = 0; // a drain lets it out
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE(!message[0] && !flow.cut_off[end]);
  ENSURE_NEAR(flow.outflow[lost], 1e-6, 1e-14);
  ENSURE_NEAR(flow.pressure[end], 1 + 2e-6, 1e-12);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* A drain of conductance 3 half way between heads of 9 and 1 m, c = 1 and 2; its gallery stands at 2 m. */
static PetscErrorCode DrainThatResists(void)
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  const PetscInt up = held_node(&p, 0, 0, 9), drain = free_node(&p, 1, 0), down = held_node(&p, 2, 0, 1);
  pipe(&p, up, drain, 1), pipe(&p, drain, down, 2);
  p.node[drain].load = 1, p.node[drain].conductance = 3, p.node[drain].head = 2;
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE_NEAR(flow.pressure[drain], (9. + 2. * 1. + 3. * 2.) / 6., 1e-12);
  ENSURE_NEAR(flow.outflow[drain], 3. * (17. / 6. - 2.), 1e-12);
  ENSURE_NEAR(flow.outflow[down], 2. * (17. / 6. - 1.), 1e-12);
  ENSURE_NEAR(flow.inflow, 9. - 17. / 6., 1e-12);
  ENSURE(!message[0] && flow.error <= 1e-8);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* A gallery under water feeds a joint that falls to a seepage face: more slowly than the joint could
   carry. */
static PetscErrorCode DrainThatFeeds(void)
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  const PetscInt low = held_node(&p, 0, 0, 0), gate = free_node(&p, 0, 4);
  pipe(&p, gate, low, 1);
  p.node[gate].load = 1, p.node[gate].conductance = 0.1, p.node[gate].head = 6;
  PetscCall(FlowSolve(&p.net, &flow, message));
  ENSURE_NEAR(flow.outflow[low], 0.2, 1e-12); // 0.1 times 2 m: no pressure in the joint
  ENSURE_NEAR(flow.outflow[gate], -0.2, 1e-12);
  ENSURE_NEAR(flow.inflow, 0.2, 1e-12);
  ENSURE_NEAR(flow.saturation[gate], 0.05, 1e-12);
  ENSURE(!message[0] && flow.error <= 1e-8);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* Water that stands still is in balance, however rounding moves it. */
static PetscErrorCode StillWater(void)
{
  char message[MESSAGE_LENGTH] = "";
  Pipes p;
  FlowSolution flow = {0};
  start(&p);
  for (int i = 0; i < 8; i++)
    if (i % 7)
      free_node(&p, i, 0.3 * i);
    else
      held_node(&p, i, 0.3 * i, 7.7);
  for (int i = 1; i < 8; i++) pipe(&p, i - 1, i, 1e-6 * (1 + 0.1 * i)), pipe(&p, (3 * i) % 8, i, 1e-5);
  PetscCall(FlowSolve(&p.net, &flow, message));
  for (int i = 0; i < 8; i++) ENSURE_NEAR(flow.pressure[i], 7.7 - 0.3 * i, 1e-12);
  ENSURE(!message[0] && flow.error <= 1e-8);
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

static double draw(double a, double b)
{
  static uint64_t state = 88172645463325252u;
  state ^= state << 13, state ^= state >> 7, state ^= state << 17;
  return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* What must hold of any network: bounds, no pressure in what is not full, cubic law with gravity, balance. */
static void check_all(const Pipes *p, const FlowSolution *flow)
{
  PetscReal left[MOST_NODES], scale = 1e-6, in = 0., out = 0.;
  for (PetscInt i = 0; i < p->net.n_nodes; i++) left[i] = p->node[i].inflow;
  for (PetscInt e = 0; e < p->net.n_pieces; e++) {
    const PetscInt a = p->piece[e].node[0], b = p->piece[e].node[1],
                   top = p->node[b].x[1] > p->node[a].x[1] ? b : a;
    const PetscReal q = p->piece[e].conductance *
                        (flow->pressure[a] - flow->pressure[b] +
                         flow->saturation[top] * (p->node[a].x[1] - p->node[b].x[1]));
    left[a] -= q, left[b] += q, scale = PetscMax(scale, PetscAbsReal(q));
    ENSURE_NEAR(flow->discharge[e], q, 1e-9 * scale + 1e-14 * p->piece[e].conductance); // heads are rounded
  }
  for (PetscInt i = 0; i < p->net.n_nodes; i++) {
    const FlowNode *node = p->node + i;
    const PetscReal psi = flow->pressure[i], chi = flow->saturation[i];
    ENSURE(psi >= 0 && chi >= -1e-9 && chi <= 1 + 1e-9);
    ENSURE(flow->cut_off[i] || psi == 0 || chi == 1);
    if (node->kind == NODE_HEAD) ENSURE_NEAR(psi, node->head - node->x[1], 1e-12);
    if (node->kind == NODE_SEEP) ENSURE(psi == 0 && left[i] >= -1e-9 * scale);
    if (node->kind == NODE_FREE)
      ENSURE_NEAR(left[i], node->conductance * (psi + node->x[1] - node->head), 1e-8 * scale);
    ENSURE_NEAR(flow->outflow[i], node->kind == NODE_FREE && node->conductance == 0. ? 0. : left[i],
                1e-8 * scale);
    in += PetscMax(0., -flow->outflow[i]) + node->inflow, out += PetscMax(0., flow->outflow[i]);
  }
  ENSURE_NEAR(flow->inflow, in, 1e-9 * scale);
  ENSURE_NEAR(in, out, 1e-8 * scale);
  ENSURE(in < 1e-6 || flow->error <= 1e-8);
}

/* Random grids of joints, some level, some steep, of widths that differ a thousandfold in conductance, with
   waters on both sides, springs and drains. */
static PetscErrorCode AnyNetwork(void)
{
  enum { WIDE = 7, HIGH = 8 };
  FlowSolution flow = {0};
  const int draws = CheckDraws(400);
  for (int k = 0; k < draws; k++) {
    char message[MESSAGE_LENGTH] = "";
    const double up = draw(0, 9), down = draw(-1, up), lean = draw(0, 1) < 0.5 ? 0. : draw(-0.3, 0.3);
    Pipes p;
    start(&p);
    for (int j = 0; j < HIGH; j++)
      for (int i = 0; i < WIDE; i++) {
        const double z = j + lean * i;
        if (i == 0 || i == WIDE - 1)
          held_node(&p, i, z, i ? down : up);
        else
          free_node(&p, i, z);
        FlowNode *node = p.node + p.net.n_nodes - 1;
        if (node->kind != NODE_FREE) continue;
        if (draw(0, 1) < 0.04) node->inflow = draw(0, 1);
        if (draw(0, 1) < 0.06)
          node->load = 1, node->conductance = pow(10., draw(-3, 1)), node->head = z + fabs(draw(-2, 2));
      }
    for (int j = 0; j < HIGH; j++)
      for (int i = 0; i < WIDE; i++) {
        const int n = j * WIDE + i;
        if (i + 1 < WIDE && draw(0, 1) < 0.9) pipe(&p, n, n + 1, pow(10., draw(-2, 1)));
        if (j && draw(0, 1) < 0.8) pipe(&p, n, n - WIDE, pow(10., draw(-2, 1)));
      }
    for (PetscInt i = 0; i < p.net.n_nodes; i++) // what is pumped in has a way out
      if (p.node[i].inflow > 0.) pipe(&p, i, i % WIDE ? i - 1 : i + 1, 0.1);
    PetscCall(FlowSolve(&p.net, &flow, message));
    if (strstr(message, "has no way")) continue;
    if (message[0]) fprintf(stderr, "draw %d: %s\n", k, message);
    ENSURE(!message[0]);
    check_all(&p, &flow);
  }
  PetscCall(FlowSolutionDestroy(&flow));
  return 0;
}

/* A grid of joints between two waters. spread: powers of ten by which conductances differ. in_time: over a
   step in which voids fill that were partly full. */
static void grid(Pipes *p, int wide, int high, double spread, bool in_time)
{
  start(p);
  p->net.step = in_time;
  for (int n = 0; n < wide * high; n++) {
    const int i = n % wide, j = n / wide;
    free_node(p, i, j);
    if (i) pipe(p, n - 1, n, pow(10., draw(0, spread)));
    if (j) pipe(p, n, n - wide, pow(10., draw(0, spread)));
    const double holds = in_time ? pow(10., draw(-3, 0)) : 0., held = holds * draw(0, 1);
    FlowNode *node = p->node + n;
    node->wet[0] = 1e-3 * holds, node->wet[1] = holds - held, node->part[0] = holds, node->part[1] = -held;
  }
}

/* Sets the levels of the waters at both ends of a grid. */
static void set_levels(Pipes *p, double up, double down)
{
  const double end = p->node[p->net.n_nodes - 1].x[0];
  for (FlowNode *node = p->node; node < p->node + p->net.n_nodes; node++) {
    const double x = node->x[0], z = node->x[1], level = x > 0. ? down : up;
    if (x > 0. && x < end) continue;
    node->kind = level > z ? NODE_HEAD : NODE_SEEP, node->load = 0, node->head = PetscMax(level, z);
  }
}

static void begin_with(Pipes *p, const FlowSolution *flow)
{
  for (PetscInt i = 0; i < p->net.n_nodes; i++) p->node[i].first = flow->wetness[i];
}

static bool same_bits(const FlowNetwork *net, const FlowSolution *a, const FlowSolution *b)
{
  const size_t nodes = (size_t)net->n_nodes * sizeof(PetscReal),
               pieces = (size_t)net->n_pieces * sizeof(PetscReal);
  return !memcmp(a->pressure, b->pressure, nodes) && !memcmp(a->saturation, b->saturation, nodes) &&
         !memcmp(a->stream, b->stream, nodes) && !memcmp(a->stored, b->stored, nodes) &&
         !memcmp(a->outflow, b->outflow, nodes) && !memcmp(a->discharge, b->discharge, pieces);
}

/* A search that begins with the sides of its answer ends at once. One that begins with those of other levels
   ends sooner than one that begins with all wet. All have the same bits. */
static PetscErrorCode KnownSides(void)
{
  FlowSolution cold = {0}, warm = {0};
  const int draws = CheckDraws(200);
  int from_wet = 0, from_near = 0;
  for (int k = 0; k < draws; k++) {
    const double up = draw(1, 9), down = draw(-1, up);
    char message[MESSAGE_LENGTH] = "";
    Pipes p;
    grid(&p, 7, 8, 3, k % 2);
    set_levels(&p, up, down);
    PetscCall(FlowSolve(&p.net, &cold, message));
    begin_with(&p, &cold);
    PetscCall(FlowSolve(&p.net, &warm, message));
    ENSURE(warm.rounds == 1 && same_bits(&p.net, &cold, &warm));
    set_levels(&p, up + draw(-0.3, 0.3), down + draw(-0.3, 0.3));
    PetscCall(FlowSolve(&p.net, &warm, message));
    begin_with(&p, &warm);
    set_levels(&p, up, down);
    PetscCall(FlowSolve(&p.net, &warm, message));
    ENSURE(!message[0] && same_bits(&p.net, &cold, &warm));
    from_wet += cold.rounds, from_near += warm.rounds;
  }
  ENSURE(from_near < 0.5 * from_wet);
  PetscCall(FlowSolutionDestroy(&cold));
  PetscCall(FlowSolutionDestroy(&warm));
  return 0;
}

/* A search that begins with the guess of a coarse network ends sooner than one that begins with all wet, with
   the same bits; also where all is wet, and in a network without height. */
static PetscErrorCode Guess(void)
{
  static const struct {
    int wide, high;
    double up, down;
    bool in_time;
  } known[] = {{36, 36, 33.3, 5, false}, {36, 36, 20.3, 12, false}, {36, 36, 30.3, -1, false},
               {36, 36, 25.3, 5, true},  {36, 36, 50, 40, false},   {1296, 1, 3, 1, false}};
  FlowSolution cold = {0}, guessed = {0};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
    const bool full = known[k].down > known[k].high - 1;
    char message[MESSAGE_LENGTH] = "";
    Pipes p;
    grid(&p, known[k].wide, known[k].high, 1, known[k].in_time);
    set_levels(&p, known[k].up, known[k].down);
    PetscCall(FlowSolve(&p.net, &cold, message));
    PetscCall(FlowGuess(&p.net));
    PetscCall(FlowSolve(&p.net, &guessed, message));
    ENSURE(!message[0] && same_bits(&p.net, &cold, &guessed));
    ENSURE(full ? guessed.rounds == 1 : guessed.rounds < cold.rounds);
  }
  PetscCall(FlowSolutionDestroy(&cold));
  PetscCall(FlowSolutionDestroy(&guessed));
  return 0;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(Bridge);
  RUN_TEST(WaterTable);
  RUN_TEST(SeepageFace);
  RUN_TEST(Pits);
  RUN_TEST(CutOff);
  RUN_TEST(DrainThatResists);
  RUN_TEST(DrainThatFeeds);
  RUN_TEST(StillWater);
  RUN_TEST(AnyNetwork);
  RUN_TEST(KnownSides);
  RUN_TEST(Guess);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

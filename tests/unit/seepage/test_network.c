/* The network of water: ends of contacts that share a void, cuts by drains and curtains, what contradicts
   itself, conductances. */
#include "seepage/flow.h"
#include "check.h"
#include <string.h>

enum { MOST_ROWS = 8, MOST_LOADS = 6 };
static const double GW = 9810., MU = 1e-3;

/* A scene of one joint, a stage in which all its loads act, and contacts by hand. */
typedef struct {
  Joint joint;
  Load load[MOST_LOADS];
  PetscInt acts[MOST_LOADS], gids[MOST_LOADS][4]; /* faces of the joint of a drain, else vertices */
  FlowTarget target[MOST_LOADS];
  FlowRow row[MOST_ROWS];
  Scene scene;
  Stage stage;
  FlowNetwork net;
  char unmet[MESSAGE_LENGTH], message[MESSAGE_LENGTH];
} Work;

static void start(Work *w, double aperture)
{
  memset(w, 0, sizeof *w);
  w->joint = (Joint){.name = "base",
                     .aperture = aperture,
                     .aperture_residual = 1e-5,
                     .aperture_max = PETSC_INFINITY,
                     .roughness = 1.};
  w->scene = (Scene){.file = "scene.yaml",
                     .gravity = 9.81,
                     .flow = {.density = 1000., .viscosity = MU},
                     .loads = w->load,
                     .n_joints = 1};
  w->stage = (Stage){.name = "full", .loads = w->acts, .joints = &w->joint};
  w->net.row = w->row;
}

/* A contact from (x0, y0) to (x1, y1) between faces 2 row and 2 row + 1; vertices of its ends: a, b, -1:
   none. */
static FlowRow *contact(Work *w, double x0, double y0, double x1, double y1, PetscInt a, PetscInt b)
{
  const PetscInt i = w->net.n_rows++;
  w->row[i] = (FlowRow){.key = {2 * i, 2 * i + 1},
                        .vertex = {{a, -1}, {b, -1}},
                        .x = {{x0, y0}, {x1, y1}},
                        .t = {{0., 1.}, {1., 0.}},
                        .length = hypot(x1 - x0, y1 - y0)};
  return w->row + i;
}

static Load *add_load(Work *w, LoadKind kind, const char *name)
{
  const PetscInt l = w->scene.n_loads++;
  w->acts[w->stage.n_loads++] = l;
  w->target[l].faces = w->target[l].vertices = w->gids[l];
  w->load[l] = (Load){.kind = kind,
                      .uplift.gallery = NAN,
                      .flow = {.from = {NAN, NAN},
                               .distance = NAN,
                               .conductance = PETSC_INFINITY,
                               .factor = NAN,
                               .aperture = NAN}};
  snprintf(w->load[l].name, NAME_LENGTH, "%s", name);
  snprintf(w->load[l].target, NAME_LENGTH, "set");
  return w->load + l;
}

/* Water of a level at a vertex. */
static Load *head(Work *w, const char *name, double level, PetscInt vertex)
{
  Load *load = add_load(w, LOAD_HEAD, name);
  load->level = level;
  w->target[load - w->load].n_vertices = 1, w->gids[load - w->load][0] = vertex;
  return load;
}

static Load *line_drain(Work *w, const char *name, double x, double low, double high, double gallery)
{
  Load *load = add_load(w, LOAD_DRAIN, name);
  load->flow.from[0] = load->flow.to[0] = x, load->flow.from[1] = low, load->flow.to[1] = high;
  load->uplift.gallery = gallery;
  return load;
}

static Load *curtain(Work *w, const char *name, double x, double width)
{
  Load *load = add_load(w, LOAD_CURTAIN, name);
  load->flow.from[0] = load->flow.to[0] = x, load->flow.from[1] = -1., load->flow.to[1] = 1.;
  load->flow.width = width;
  return load;
}

static PetscErrorCode build(Work *w, double reach)
{
  PetscFunctionBegin;
  w->message[0] = 0;
  PetscCall(FlowNetworkBuild(&w->scene, &w->stage, w->target, reach, &w->net, w->unmet, w->message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static double transmissivity(double a)
{
  return GW * a * a * a / (12. * MU);
}

/* The node at (x, y), -1: none, -2: several. */
static PetscInt node_at(const Work *w, double x, double y)
{
  PetscInt found = -1;
  for (PetscInt i = 0; i < w->net.n_nodes; i++)
    if (hypot(w->net.node[i].x[0] - x, w->net.node[i].x[1] - y) < 1e-9) found = found == -1 ? i : -2;
  return found;
}

/* A crossing of two joints: four contacts, whose ends there have vertices of their own, 0.1 mm apart. */
static PetscErrorCode SharedByPlace(void)
{
  const double d = 1e-4;
  Work w;
  start(&w, 1e-4);
  contact(&w, -1, 0, -d, 0, 0, 1), contact(&w, d, 0, 1, 0, 2, 3);
  contact(&w, 0, -1, 0, -d, 4, 5), contact(&w, 0, d, 0, 1, 6, 7);
  PetscCall(build(&w, 1e-9));
  ENSURE(w.net.n_nodes == 8 && w.net.n_pieces == 4);
  PetscCall(build(&w, 3e-4));
  ENSURE(w.net.n_nodes == 5 && w.net.n_pieces == 4);
  const PetscInt middle = w.net.piece[0].node[1];
  for (int i = 0; i < 4; i++) ENSURE(w.net.piece[i].node[i % 2 ? 0 : 1] == middle);
  ENSURE(!w.message[0] && !w.unmet[0]);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

static double draw(double a, double b)
{
  static uint64_t state = 88172645463325252u;
  state ^= state << 13, state ^= state >> 7, state ^= state << 17;
  return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* Random places, negative ones too, against a test of every pair. */
static PetscErrorCode AnyPlaces(void)
{
  enum { ROWS = 120 };
  const int draws = CheckDraws(40);
  const double reach = 0.07;
  for (int k = 0; k < draws; k++) {
    static FlowRow rows[ROWS];
    PetscInt parent[2 * ROWS], node[2 * ROWS], n_wrong = 0;
    Work w;
    start(&w, 1e-4);
    for (int i = 0; i < ROWS; i++) {
      rows[i] = (FlowRow){.vertex = {{4 * i, -1}, {4 * i + 1, -1}}, .length = draw(0.02, 1.)};
      for (int x = 0; x < 4; x++) rows[i].x[x / 2][x % 2] = draw(-1., 1.);
    }
    w.net.row = rows, w.net.n_rows = ROWS;
    PetscCall(build(&w, reach));
    for (int e = 0; e < 2 * ROWS; e++) parent[e] = e, node[e] = w.net.piece[e / 2].node[e % 2];
    for (int e = 0; e < 2 * ROWS; e++)
      for (int f = 0; f < e; f++) {
        const FlowRow *p = rows + e / 2, *q = rows + f / 2;
        const double off = hypot(p->x[e % 2][0] - q->x[f % 2][0], p->x[e % 2][1] - q->x[f % 2][1]);
        if (p == q || off > PetscMin(reach, 0.25 * PetscMin(p->length, q->length))) continue;
        const PetscInt a = UnionRoot(parent, e), b = UnionRoot(parent, f);
        parent[PetscMax(a, b)] = PetscMin(a, b);
      }
    for (int e = 0; e < 2 * ROWS; e++)
      for (int f = 0; f < e; f++)
        n_wrong += (node[e] == node[f]) != (UnionRoot(parent, e) == UnionRoot(parent, f));
    ENSURE(w.net.n_pieces == ROWS && n_wrong == 0);
    PetscCall(FlowNetworkDestroy(&w.net));
  }
  return 0;
}

/* Ends at one vertex are one void, however far it has opened; a chain of places within reach is one, too. */
static PetscErrorCode SharedByVertex(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 0, 1, 0, 10, 11), contact(&w, 1.2, 0.3, 2, 0, 11, 12);
  contact(&w, 2, 0, 3, 0, 13, 14)->vertex[0][1] = 12; // an end has the vertices of both faces
  PetscCall(build(&w, 1e-9));
  ENSURE(w.net.n_nodes == 4);
  for (int i = 0; i < 2; i++) ENSURE(w.net.piece[i].node[1] == w.net.piece[i + 1].node[0]);
  PetscCall(FlowNetworkDestroy(&w.net));
  start(&w, 1e-4);
  for (int i = 0; i < 5; i++)
    contact(&w, 0.8 * i, 0, 0.8 * i, 5, 2 * i, 2 * i + 1); // feet 0.8 m apart, reach 1 m
  PetscCall(build(&w, 1.));
  ENSURE(w.net.n_nodes == 2);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* A contact much shorter than the reach breaks no joint, and the resistance changes by no more than its
   own; one as short as its neighbours keeps its ends apart. */
static PetscErrorCode ShortContacts(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 0, 1, 0, 0, 1), contact(&w, 1, 0, 1.002, 0, 2, 3), contact(&w, 1.002, 0, 2, 0, 4, 5);
  PetscCall(build(&w, 5e-3));
  double resistance = 0;
  for (PetscInt i = 0; i < w.net.n_pieces; i++) {
    const FlowPiece *piece = w.net.piece + i;
    if (i) ENSURE(piece->node[0] == piece[-1].node[1]);
    if (piece->node[0] != piece->node[1]) resistance += 1 / piece->conductance;
  }
  ENSURE_NEAR(resistance * transmissivity(1e-4), 2, 2.1e-3);
  PetscCall(FlowNetworkDestroy(&w.net));
  start(&w, 1e-4);
  for (int i = 0; i < 3; i++) contact(&w, 2e-3 * i, 0, 2e-3 * (i + 1), 0, 2 * i, 2 * i + 1);
  PetscCall(build(&w, 5e-3));
  ENSURE(w.net.n_nodes == 4);
  for (int i = 0; i < 2; i++) ENSURE(w.net.piece[i].node[1] == w.net.piece[i + 1].node[0]);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* A drain within a contact cuts it; one where contacts meet is their void; a gallery below it runs freely. */
static PetscErrorCode CutsByDrains(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 1, 10, 1, 0, 1), contact(&w, 10, 1, 20, 1, 1, 2);
  head(&w, "up", 30, 0);
  line_drain(&w, "within", 4, 0, 2, 5.);
  line_drain(&w, "between", 10, 0, 2, NAN);
  line_drain(&w, "poor", 16, 0, 2, -3)->flow.conductance = 2e-7;
  line_drain(&w, "clogged", 18, 0, 2, NAN)->flow.conductance = 0.;
  PetscCall(build(&w, 1e-9));
  ENSURE(!w.message[0] && !w.unmet[0]);
  ENSURE(w.net.n_pieces == 5 && w.net.n_nodes == 6);
  static const double length[] = {4, 6, 6, 2, 2};
  for (int i = 0; i < 5; i++) {
    ENSURE_NEAR(w.net.piece[i].length, length[i], 1e-12);
    ENSURE_NEAR(w.net.piece[i].conductance, transmissivity(1e-4) / length[i], 1e-12 * transmissivity(1e-4));
    if (i) ENSURE(w.net.piece[i].node[0] == w.net.piece[i - 1].node[1]);
  }
  ENSURE_NEAR(w.net.piece[1].s[0], 0.4, 1e-12);
  const FlowNode *within = w.net.node + node_at(&w, 4, 1), *between = w.net.node + node_at(&w, 10, 1),
                 *poor = w.net.node + node_at(&w, 16, 1), *clogged = w.net.node + node_at(&w, 18, 1),
                 *up = w.net.node + node_at(&w, 0, 1);
  ENSURE(up->kind == NODE_HEAD && up->head == 30 && up->load == 0);
  ENSURE(within->kind == NODE_HEAD && within->head == 5 && within->load == 1);
  ENSURE(between->kind == NODE_SEEP && between->head == 1 && between->load == 2);
  ENSURE(poor->kind == NODE_FREE && poor->head == 1 && poor->conductance == 2e-7 && poor->load == 3);
  ENSURE(clogged->kind == NODE_FREE && clogged->conductance == 0 && clogged->load == -1);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* A drain at a distance from the heel, which is the left end or the right one; outside its joint it is
   refused. */
static PetscErrorCode DrainAtADistance(void)
{
  static const struct {
    double distance, x;
    UpliftHeel heel;
  } known[] = {
      {3, 3, HEEL_START}, {10, 10, HEEL_START}, {0, 0, HEEL_START}, {3, 17, HEEL_END}, {20, 0, HEEL_END}};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
    Work w;
    start(&w, 1e-4);
    contact(&w, 10, 0, 0, 0, 1, 0), contact(&w, 10, 0, 20, 0, 1, 2);
    Load *drain = add_load(&w, LOAD_DRAIN, "line");
    drain->flow.distance = known[k].distance, drain->uplift.heel = known[k].heel;
    w.target[0].n_faces = 2, w.gids[0][0] = 0, w.gids[0][1] = 3; // a face of each contact
    PetscCall(build(&w, 1e-9));
    ENSURE(!w.message[0] && !w.unmet[0]);
    const PetscInt at = node_at(&w, known[k].x, 0);
    ENSURE(at >= 0 && w.net.node[PetscMax(at, 0)].kind == NODE_SEEP);
    drain->flow.distance = 20.5;
    PetscCall(build(&w, 1e-9));
    ENSURE(strstr(w.unmet, "loads.line.distance: 20.5 is outside the joint 'set': expected 0 to 20 [m]") !=
           NULL);
    w.target[0].n_faces = 0;
    PetscCall(build(&w, 1e-9));
    ENSURE(strstr(w.unmet, "loads.line.joint: no water flows in 'set'") != NULL);
    PetscCall(FlowNetworkDestroy(&w.net));
  }
  return 0;
}

/* A curtain narrows what is within it, over the end of a contact and beside a drain, and nothing else. */
static PetscErrorCode CutsByCurtains(void)
{
  Work w;
  start(&w, 2e-4);
  contact(&w, 0, 0, 5, 0, 0, 1), contact(&w, 5, 0, 10, 0, 1, 2), contact(&w, 0, 3, 10, 3, 3, 4);
  curtain(&w, "grout", 5, 2)->flow.factor = 0.2;
  line_drain(&w, "drain", 5.5, -1, 1, NAN);
  PetscCall(build(&w, 1e-9));
  ENSURE(!w.message[0] && !w.unmet[0]);
  static const double from[] = {0, 4, 5, 5.5, 6, 0}, to[] = {4, 5, 5.5, 6, 10, 10},
                      a[] = {2, .4, .4, .4, 2, 2};
  ENSURE(w.net.n_pieces == 6);
  for (int i = 0; i < PetscMin(6, w.net.n_pieces); i++) {
    const FlowPiece *piece = w.net.piece + i;
    ENSURE_NEAR(w.net.node[piece->node[0]].x[0], from[i], 1e-12);
    ENSURE_NEAR(w.net.node[piece->node[1]].x[0], to[i], 1e-12);
    ENSURE_NEAR(piece->conductance * (to[i] - from[i]), transmissivity(1e-4 * a[i]),
                1e-12 * transmissivity(2e-4));
  }
  w.load[0].flow.factor = NAN, w.load[0].flow.aperture = 3e-5; // in place of the joint's
  PetscCall(build(&w, 1e-9));
  ENSURE_NEAR(w.net.piece[1].conductance, transmissivity(3e-5), 1e-12 * transmissivity(3e-5));
  w.load[0].flow.from[0] = w.load[0].flow.to[0] = 12;
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.unmet, "loads.grout.from: from (12, -1) to (12, 1) m it meets no joint") != NULL);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* Waters and drains that ask for different heads of one void are refused; those that agree are not. */
static PetscErrorCode Conflicts(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 0, 10, 0, 0, 1), contact(&w, 0, 5, 10, 5, 2, 3);
  head(&w, "up", 8, 0), head(&w, "lake", 8, 0);
  PetscCall(build(&w, 1e-9));
  ENSURE(!w.message[0] && !w.unmet[0]);
  w.load[1].level = 8.5;
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.message, "loads.lake: a head of 8.5 m at (0, 0) m, where loads.up gives 8 m") != NULL);
  w.load[0].level = -3, w.load[1].level = -7; // a seepage face for both
  PetscCall(build(&w, 1e-9));
  ENSURE(!w.message[0] && !w.unmet[0]);
  w.load[1].level = 8; // under one water and above the other
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.message, "loads.lake: a head of 8 m at (0, 0) m, where loads.up gives 0 m") != NULL);
  w.load[1].level = -3;
  w.load[0].level = 8, w.gids[1][0] = 9;
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.unmet, "loads.lake.faces: no joint in which water flows ends at 'set'") != NULL);
  w.gids[1][0] = 1;
  Load *drain = line_drain(&w, "drain", 0, -1, 1, 8.);
  PetscCall(build(&w, 1e-9));
  ENSURE(!w.message[0] && !w.unmet[0]);
  drain->uplift.gallery = 2;
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.message, "loads.up: a head of 8 m at (0, 0) m, where loads.drain gives 2 m") != NULL);
  drain->flow.from[0] = drain->flow.to[0] = 5, drain->flow.from[1] = 6,
  drain->flow.to[1] = 9; // above both joints
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.unmet, "loads.drain.from: from (5, 6) to (5, 9) m it meets no joint") != NULL);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* Drains that resist act together where they meet: the sum of c_i (h - h_i). */
static PetscErrorCode DrainsThatResist(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 0, 10, 0, 0, 1);
  line_drain(&w, "new", 4, -1, 1, 1.)->flow.conductance = 2e-6;
  line_drain(&w, "old", 4, -1, 1, 3.)->flow.conductance = 3e-6;
  line_drain(&w, "dry", 4, -1, 1, NAN)->flow.conductance = 5e-6;
  PetscCall(build(&w, 1e-9));
  const PetscInt i = node_at(&w, 4, 0);
  ENSURE(i >= 0 && !w.message[0] && !w.unmet[0] && w.net.n_drains == 3);
  ENSURE(i >= 0 && w.net.node[i].kind == NODE_FREE);
  ENSURE_NEAR(i >= 0 ? w.net.node[i].conductance : 0., 1e-5, 1e-18);
  ENSURE_NEAR(i >= 0 ? w.net.node[i].head : 0., (2. * 1. + 3. * 3. + 5. * 0.) / 10., 1e-12);
  w.load[1].flow.conductance = 0.; // clogged
  PetscCall(build(&w, 1e-9));
  ENSURE(w.net.n_drains == 2 && !w.message[0]);
  w.load[1].flow.conductance = PETSC_INFINITY; // it holds a head
  PetscCall(build(&w, 1e-9));
  ENSURE(strstr(w.message, "loads.old: a head of 3 m at (4, 0) m, where loads.new gives 1 m") != NULL);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* An inflow is shared by the voids of its faces. */
static PetscErrorCode Inflow(void)
{
  Work w;
  start(&w, 1e-4);
  contact(&w, 0, 0, 10, 0, 0, 1), contact(&w, 0, 5, 10, 5, 2, 3), contact(&w, 0, 5, 5, 9, 2, 4);
  Load *spring = add_load(&w, LOAD_INFLOW, "spring");
  spring->flow.discharge = 6e-6;
  w.target[0].n_vertices = 3, w.gids[0][0] = 0, w.gids[0][1] = 2, w.gids[0][2] = 4;
  PetscCall(build(&w, 1e-9));
  static const double at[][2] = {{0, 0}, {0, 5}, {5, 9}};
  double sum = 0;
  for (PetscInt i = 0; i < w.net.n_nodes; i++) sum += w.net.node[i].inflow;
  for (int i = 0; i < 3; i++) ENSURE_NEAR(w.net.node[node_at(&w, at[i][0], at[i][1])].inflow, 2e-6, 1e-18);
  ENSURE_NEAR(sum, 6e-6, 1e-18);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* A tapered contact: exact, and the same in any number of pieces; apertures within their bounds;
   roughness. */
static PetscErrorCode Conductances(void)
{
  Work w;
  start(&w, 2e-4);
  FlowRow *row = contact(&w, 0, 0, 8, 0, 0, 1);
  row->opening[0] = 1e-4, row->opening[1] = -1e-4; // 0.3 to 0.1 mm
  const double wedge = GW / (12 * MU * 8) * 2 * pow(3e-4, 2) * pow(1e-4, 2) / (3e-4 + 1e-4);
  PetscCall(build(&w, 1e-9));
  ENSURE_NEAR(w.net.piece[0].conductance, wedge, 1e-12 * wedge);
  for (int n = 0; n < 4; n++) line_drain(&w, "cut", 1.7 * (n + 1), -1, 1, NAN)->flow.conductance = 0.;
  PetscCall(build(&w, 1e-9));
  double resistance = 0;
  for (PetscInt i = 0; i < w.net.n_pieces; i++) resistance += 1 / w.net.piece[i].conductance;
  ENSURE(w.net.n_pieces == 5);
  ENSURE_NEAR(resistance * wedge, 1, 1e-12);
  w.scene.n_loads = w.stage.n_loads = 0;
  w.joint.aperture_residual = 1.5e-4, w.joint.aperture_max = 2.5e-4, w.joint.roughness = 1.3;
  PetscCall(build(&w, 1e-9));
  ENSURE_NEAR(w.net.piece[0].a[0], 2.5e-4, 1e-18);
  ENSURE_NEAR(w.net.piece[0].a[1], 1.5e-4, 1e-18);
  double bounded = 0; // the line between the limits, by the midpoint rule
  for (int i = 0; i < 100000; i++) {
    const double a = 3e-4 - (i + 0.5) / 100000 * 2e-4;
    bounded += 1e-5 / pow(PetscClipInterval(a, 1.5e-4, 2.5e-4), 3);
  }
  bounded = GW / (12 * MU * 8) / bounded / 1.3;
  ENSURE_NEAR(w.net.piece[0].conductance, bounded, 1e-9 * bounded);
  row->shut = 1; // no water yet
  PetscCall(build(&w, 1e-9));
  ENSURE(w.net.n_pieces == 0 && w.net.n_nodes == 0);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

/* The water that ends of pieces held, from the apertures of now at saturation chi. */
static PetscInt full(const Work *w, double chi, FlowWater *water)
{
  for (PetscInt e = 0; e < 2 * w->net.n_pieces; e++) {
    const FlowPiece *piece = w->net.piece + e / 2;
    const PetscInt *key = w->net.row[piece->row].key;
    water[e] = (FlowWater){.key = {key[0], key[1]},
                           .s = piece->s[e % 2],
                           .a = piece->a[e % 2],
                           .psi = 0.,
                           .chi = chi,
                           .length = piece->length,
                           .volume = chi * piece->a[e % 2]};
  }
  return 2 * w->net.n_pieces;
}

/* What a list holds, [m2], and what a step of the network starts from. */
static double held_before(const FlowWater *water, PetscInt n)
{
  double sum = 0;
  for (PetscInt e = 0; e < n; e++) sum += 0.5 * water[e].length * water[e].volume;
  return sum;
}

static double held_by_nodes(Work *w, const FlowWater *water, PetscInt n)
{
  static const double reference[16];
  double sum = 0;
  FlowStore(&w->scene, &w->stage, water, n, reference, &w->net);
  for (PetscInt i = 0; i < w->net.n_nodes; i++) sum -= w->net.step * w->net.node[i].part[1];
  return sum;
}

/* Water is neither made nor lost where the aperture jumps within a contact, nor where a curtain moves. At
   its edge a node takes in what either side held. */
static PetscErrorCode HeldByPieces(void)
{
  FlowWater water[16];
  Work w;
  start(&w, 2e-4);
  w.joint.k_n = 1e10, w.scene.flow.bulk_modulus = 2e9, w.scene.flow.coupling = FLOW_TWO_WAY;
  contact(&w, 0, 0, 10, 0, 0, 1), contact(&w, 10, 0, 20, 0, 1, 2);
  Load *grout = curtain(&w, "grout", 5, 2);
  grout->flow.factor = 0.25;
  PetscCall(build(&w, 1e-9));
  w.net.step = 10.;
  PetscInt n = full(&w, 0.5, water);
  const double volume = held_before(water, n);
  ENSURE_NEAR(volume, 0.5 * (18 * 2e-4 + 2 * 5e-5), 1e-15);
  ENSURE_NEAR(held_by_nodes(&w, water, n), volume, 1e-15);
  ENSURE_NEAR(-10. * w.net.node[node_at(&w, 4, 0)].part[1], 0.5 * (2 * 2e-4 + 1 * 5e-5), 1e-15);
  FlowWater at;
  ENSURE(FlowWaterAt(water, n, w.row[0].key, 0.4, 0.2, &at) && at.a == 2e-4);
  ENSURE(FlowWaterAt(water, n, w.row[0].key, 0.4, 0.5, &at) && at.a == 5e-5);
  for (int i = 0; i < 3; i++) {
    grout->flow.from[0] = grout->flow.to[0] = i == 0 ? 5.3 : i == 1 ? 10 : 21; // at last it is nowhere
    PetscCall(build(&w, 1e-9));
    w.net.step = 10.;
    ENSURE_NEAR(held_by_nodes(&w, water, n), volume, 1e-15);
  }
  w.row[0].length = 10.5; // the same water in a longer contact
  PetscCall(build(&w, 1e-9));
  ENSURE_NEAR(held_by_nodes(&w, water, n), volume, 1e-15);
  PetscCall(FlowNetworkDestroy(&w.net));
  return 0;
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(SharedByPlace);
  RUN_TEST(AnyPlaces);
  RUN_TEST(SharedByVertex);
  RUN_TEST(ShortContacts);
  RUN_TEST(CutsByDrains);
  RUN_TEST(DrainAtADistance);
  RUN_TEST(CutsByCurtains);
  RUN_TEST(HeldByPieces);
  RUN_TEST(Conflicts);
  RUN_TEST(DrainsThatResist);
  RUN_TEST(Inflow);
  RUN_TEST(Conductances);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* network.c: builds the nodes and pieces of the network in which water flows, from contacts.

   Ends of contacts that share a void become one node: ends at one vertex of the mesh, or nearer to each
   other than `reach` (the distance at which faces make a contact). The distance must also be below a
   quarter of a contact's length, so that the ends of a short contact stay apart. */
#include "seepage/flow.h"

/* ---- cuts: where a drain crosses a contact, and where a curtain begins and ends on it */

typedef struct {
  PetscInt row, drain; /* drain: row of the scene's loads, -1: end of a curtain */
  PetscReal s;         /* [-] along the contact */
} Cut;
typedef struct {
  PetscInt n, capacity;
  Cut *cut;
} Cuts;
static const PetscReal TIE = 1e-9; /* [-] positions along a contact closer than this are one */

static PetscErrorCode add_cut(Cuts *cuts, PetscInt row, PetscReal s, PetscInt drain)
{
  PetscFunctionBeginUser;
  PetscCall(MakeRoom(sizeof(Cut), cuts->n, &cuts->capacity, &cuts->cut));
  cuts->cut[cuts->n++] = (Cut){row, drain, PetscClipInterval(s, 0., 1.)};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int cut_order(const void *a, const void *b)
{
  const Cut *p = a, *q = b;
  if (p->row != q->row) return p->row < q->row ? -1 : 1;
  if (p->s != q->s) return p->s < q->s ? -1 : 1;
  return (p->drain > q->drain) - (p->drain < q->drain);
}

/* Decides whether the line of a load crosses a contact; s receives the position. */
static PetscBool crosses(const FlowRow *row, const FlowKeys *keys, PetscReal *s)
{
  const PetscReal ex = row->x[1][0] - row->x[0][0], ey = row->x[1][1] - row->x[0][1],
                  dx = keys->to[0] - keys->from[0], dy = keys->to[1] - keys->from[1],
                  rx = keys->from[0] - row->x[0][0], ry = keys->from[1] - row->x[0][1],
                  det = ex * dy - ey * dx;
  if (PetscAbsReal(det) <=
      1e-12 * (PetscAbsReal(ex) + PetscAbsReal(ey)) * (PetscAbsReal(dx) + PetscAbsReal(dy)))
    return PETSC_FALSE; // parallel
  const PetscReal at = (rx * ey - ry * ex) / det;
  *s = (rx * dy - ry * dx) / det;
  return (PetscBool)(*s >= -TIE && *s <= 1. + TIE && at >= -TIE && at <= 1. + TIE);
}

/* Finds the part s[0] to s[1] of a contact inside a curtain [-]. Returns false if no part is inside. */
static PetscBool within(const FlowRow *row, const FlowKeys *keys, PetscReal s[2])
{
  PetscReal e[2], length;
  for (int x = 0; x < 2; x++) e[x] = keys->to[x] - keys->from[x];
  length = PetscHypotReal(e[0], e[1]);
  s[0] = 0., s[1] = 1.;
  for (int side = 0; side < 2; side++) { // along the axis, then across it
    PetscReal at[2];
    const PetscReal low = side ? -0.5 * keys->width : 0., high = side ? 0.5 * keys->width : length;
    for (int k = 0; k < 2; k++) {
      const PetscReal rx = row->x[k][0] - keys->from[0], ry = row->x[k][1] - keys->from[1];
      at[k] = (side ? e[0] * ry - e[1] * rx : e[0] * rx + e[1] * ry) / length;
    }
    const PetscReal span = at[1] - at[0];
    if (PetscAbsReal(span) <= TIE * row->length) {
      if (at[0] < low || at[0] > high) return PETSC_FALSE;
      continue;
    }
    const PetscReal one = (low - at[0]) / span, other = (high - at[0]) / span;
    s[0] = PetscMax(s[0], PetscMin(one, other)), s[1] = PetscMin(s[1], PetscMax(one, other));
  }
  return (PetscBool)(s[1] - s[0] > TIE);
}

static PetscBool is_among(PetscInt gid, PetscInt n, const PetscInt *gids)
{
  PetscInt at = -1;
  PetscCallAbort(PETSC_COMM_SELF, PetscFindInt(gid, n, gids, &at));
  return (PetscBool)(at >= 0);
}

static PetscBool is_of_joint(const FlowTarget *target, const FlowRow *row)
{
  return (PetscBool)(is_among(row->key[0], target->n_faces, target->faces) ||
                     is_among(row->key[1], target->n_faces, target->faces));
}

/* Finds the direction e of a joint from its heel, and the coordinates of heel and toe along e. Returns
   false if no water flows in the joint. */
static PetscBool joint_axis(const Load *load, const FlowTarget *target, const FlowNetwork *net,
                            PetscReal e[2], PetscReal ends[2])
{
  PetscReal n = 0., mean[2] = {0., 0.}, xx = 0., xy = 0., yy = 0.;
  for (PetscInt i = 0; i < 2 * net->n_rows; i++) {
    const PetscReal *x = net->row[i / 2].x[i % 2];
    if (!is_of_joint(target, net->row + i / 2)) continue;
    mean[0] += x[0], mean[1] += x[1], n += 1.;
    xx += x[0] * x[0], xy += x[0] * x[1], yy += x[1] * x[1];
  }
  if (n == 0.) return PETSC_FALSE;
  JointDirection(xx - mean[0] * mean[0] / n, xy - mean[0] * mean[1] / n, yy - mean[1] * mean[1] / n, e);
  if (load->uplift.heel == HEEL_END || target->from_end) e[0] = -e[0], e[1] = -e[1];
  ends[0] = PETSC_INFINITY, ends[1] = -PETSC_INFINITY;
  for (PetscInt i = 0; i < 2 * net->n_rows; i++) {
    const PetscReal *x = net->row[i / 2].x[i % 2], at = x[0] * e[0] + x[1] * e[1];
    if (!is_of_joint(target, net->row + i / 2)) continue;
    ends[0] = PetscMin(ends[0], at), ends[1] = PetscMax(ends[1], at);
  }
  return PETSC_TRUE;
}

/* Cuts a joint at the distance of a drain along it. length receives the length [m] of the joint. */
static PetscErrorCode cut_at_distance(const Load *load, PetscInt l, const FlowTarget *target,
                                      const FlowNetwork *net, Cuts *cuts, PetscReal *length)
{
  PetscReal e[2], ends[2];
  PetscFunctionBeginUser;
  *length = 0.;
  if (!joint_axis(load, target, net, e, ends)) PetscFunctionReturn(PETSC_SUCCESS);
  *length = ends[1] - ends[0];
  for (PetscInt i = 0; i < net->n_rows; i++) {
    const FlowRow *row = net->row + i;
    if (row->shut || !is_of_joint(target, row)) continue;
    const PetscReal from = row->x[0][0] * e[0] + row->x[0][1] * e[1] - ends[0],
                    to = row->x[1][0] * e[0] + row->x[1][1] * e[1] - ends[0],
                    s = (load->flow.distance - from) / (to - from);
    if (!(s >= -TIE && s <= 1. + TIE)) continue;
    PetscCall(add_cut(cuts, i, s, l));
    break; // the end of the next contact is the same void
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode cut_by_load(const Load *load, PetscInt l, const FlowTarget *target,
                                  const FlowNetwork *net, Cuts *cuts, char unmet[MESSAGE_LENGTH])
{
  PetscReal s[2], length;
  PetscInt met = 0;
  const PetscInt n_before = cuts->n;
  PetscFunctionBeginUser;
  if (load->kind == LOAD_DRAIN && !PetscIsNanReal(load->flow.distance)) {
    PetscCall(cut_at_distance(load, l, target, net, cuts, &length));
    if (cuts->n > n_before || unmet[0]) PetscFunctionReturn(PETSC_SUCCESS);
    if (length > 0.)
      snprintf(unmet, MESSAGE_LENGTH,
               ":%d: loads.%s.distance: %.10g is outside the joint '%s': expected 0 to %.10g [m]", load->line,
               load->name, (double)load->flow.distance, load->target, (double)length);
    else
      snprintf(unmet, MESSAGE_LENGTH,
               ":%d: loads.%s.joint: no water flows in '%s': expected a joint with contacts and "
               "an aperture",
               load->line, load->name, load->target);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt i = 0; i < net->n_rows; i++) {
    if (net->row[i].shut) continue;
    if (load->kind == LOAD_DRAIN && crosses(net->row + i, &load->flow, s)) {
      PetscCall(add_cut(cuts, i, s[0], l));
      met++;
    }
    if (load->kind != LOAD_CURTAIN || !within(net->row + i, &load->flow, s)) continue;
    met++;
    for (int k = 0; k < 2; k++) PetscCall(add_cut(cuts, i, s[k], -1));
  }
  if (!met && !unmet[0])
    snprintf(unmet, MESSAGE_LENGTH,
             ":%d: loads.%s.from: from (%g, %g) to (%g, %g) m it meets no joint in which water "
             "flows",
             load->line, load->name, (double)load->flow.from[0], (double)load->flow.from[1],
             (double)load->flow.to[0], (double)load->flow.to[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- voids */

/* A key by which ends are found: a vertex, or a square of the plane. */
typedef struct {
  PetscInt64 tag;
  PetscInt end;
} Tag;

static int tag_order(const void *a, const void *b)
{
  const Tag *p = a, *q = b;
  if (p->tag != q->tag) return p->tag < q->tag ? -1 : 1;
  return (p->end > q->end) - (p->end < q->end);
}

static void unite(PetscInt *parent, PetscInt a, PetscInt b)
{
  const PetscInt p = UnionRoot(parent, a), q = UnionRoot(parent, b);
  parent[PetscMax(p, q)] = PetscMin(p, q);
}

static void unite_at_vertices(const FlowNetwork *net, Tag *tags, PetscInt *parent)
{
  PetscInt n = 0;
  for (PetscInt e = 0; e < 2 * net->n_rows; e++)
    for (int k = 0; k < 2; k++) {
      const PetscInt gid = net->row[e / 2].vertex[e % 2][k];
      if (gid >= 0 && !net->row[e / 2].shut) tags[n++] = (Tag){gid, e};
    }
  qsort(tags, n, sizeof(Tag), tag_order);
  for (PetscInt i = 1; i < n; i++)
    if (tags[i].tag == tags[i - 1].tag) unite(parent, tags[i].end, tags[i - 1].end);
}

static PetscInt64 square_of(const PetscReal x[2], PetscReal width, int right, int up)
{
  const PetscInt64 column = (PetscInt64)floor(x[0] / width) + right,
                   line = (PetscInt64)floor(x[1] / width) + up;
  // Two squares may share a number; the distance decides later. Unsigned arithmetic may overflow.
  return (PetscInt64)((uint64_t)column * 0x9E3779B1u + (uint64_t)line);
}

/* Decides whether two ends are within reach of each other. */
static PetscBool one_void(const FlowNetwork *net, PetscReal reach, PetscInt a, PetscInt b)
{
  const FlowRow *p = net->row + a / 2, *q = net->row + b / 2;
  const PetscReal *x = p->x[a % 2], *y = q->x[b % 2];
  return (PetscBool)(a / 2 != b / 2 && PetscHypotReal(x[0] - y[0], x[1] - y[1]) <=
                                           PetscMin(reach, 0.25 * PetscMin(p->length, q->length)));
}

static void unite_by_place(const FlowNetwork *net, PetscReal reach, Tag *tags, PetscInt *parent)
{
  PetscInt n = 0;
  for (PetscInt e = 0; e < 2 * net->n_rows; e++)
    if (!net->row[e / 2].shut) tags[n++] = (Tag){square_of(net->row[e / 2].x[e % 2], reach, 0, 0), e};
  qsort(tags, n, sizeof(Tag), tag_order);
  for (PetscInt e = 0; e < 2 * net->n_rows; e++)
    for (int near = 0; near < 9 && !net->row[e / 2].shut; near++) {
      const PetscInt64 tag = square_of(net->row[e / 2].x[e % 2], reach, near % 3 - 1, near / 3 - 1);
      PetscInt low = LowerBound(&(Tag){tag, -1}, tags, n, sizeof(Tag), tag_order);
      for (; low < n && tags[low].tag == tag; low++)
        if (tags[low].end < e && one_void(net, reach, e, tags[low].end)) unite(parent, e, tags[low].end);
    }
}

/* ---- nodes and pieces */

/* Returns the node at end k of a row; makes it at first use. number: (2 n_rows,) node of each void, at the
   root of its ends. */
static PetscInt node_of_end(FlowNetwork *net, PetscInt *parent, PetscInt *number, PetscInt row, int k)
{
  const PetscInt root = UnionRoot(parent, 2 * row + k);
  if (number[root] < 0) {
    number[root] = net->n_nodes;
    net->node[net->n_nodes++] = (FlowNode){
        .kind = NODE_FREE, .load = -1, .x = {net->row[row].x[k][0], net->row[row].x[k][1]}};
  }
  return number[root];
}

static PetscInt node_within(FlowNetwork *net, PetscInt row, PetscReal s)
{
  const FlowRow *r = net->row + row;
  FlowNode node = {.kind = NODE_FREE, .load = -1};
  for (int x = 0; x < 2; x++) node.x[x] = r->x[0][x] + s * (r->x[1][x] - r->x[0][x]);
  net->node[net->n_nodes] = node;
  return net->n_nodes++;
}

static void report_conflict(const Load *loads, const FlowNode *node, PetscInt l, PetscReal head,
                            char message[MESSAGE_LENGTH])
{
  if (message[0]) return;
  snprintf(message, MESSAGE_LENGTH,
           ":%d: loads.%s: a head of %.6g m at (%.6g, %.6g) m, where loads.%s gives %.6g m: "
           "expected one head there, and no conductance",
           loads[l].line, loads[l].name, (double)head, (double)node->x[0], (double)node->x[1],
           loads[node->load].name, (double)node->head);
}

/* Adds a drain with resistance to the drains of a node. */
static void add_drain(PetscInt l, PetscReal head, PetscReal conductance, PetscInt i, FlowNetwork *net)
{
  FlowNode *node = net->node + i;
  for (PetscInt d = 0; d < net->n_drains; d++)
    if (net->drain[d].node == i && net->drain[d].load == l) return; // the line crosses where contacts meet
  net->drain[net->n_drains++] = (FlowDrain){.node = i, .load = l, .head = head, .conductance = conductance};
  const PetscReal all = node->conductance + conductance;
  node->head = node->conductance > 0. ? (node->conductance * node->head + conductance * head) / all : head;
  node->conductance = all;
  if (node->load < 0) node->load = l;
}

/* Prescribes the condition of a head or drain at node i. level: [m] of the water there, NaN: none. */
static void prescribe_node(const Load *loads, PetscInt l, PetscReal level, PetscReal conductance, PetscInt i,
                           FlowNetwork *net, char message[MESSAGE_LENGTH])
{
  FlowNode *node = net->node + i;
  const PetscBool under = (PetscBool)(level >= node->x[1]); // water enters at its surface too
  const FlowNodeKind kind = under ? NODE_HEAD : NODE_SEEP;
  const PetscReal head = under ? level : node->x[1];
  const PetscBool resists = (PetscBool)(conductance < PETSC_INFINITY);
  if (conductance == 0.) return; // clogged
  if (resists && (node->load < 0 || node->conductance > 0.)) {
    add_drain(l, head, conductance, i, net);
    return;
  }
  if (node->load == l) return; // the line crosses where contacts meet
  if (node->load < 0)
    node->load = l, node->head = head, node->kind = kind;
  else if (resists || node->conductance > 0. || node->kind != kind ||
           PetscAbsReal(node->head - head) > 1e-9 * PetscMax(1., PetscAbsReal(head)))
    report_conflict(loads, node, l, head, message);
}

/* Makes the pieces of row i, between its ends and the cuts from *at on. */
static void add_pieces(const Load *loads, const Cuts *cuts, PetscInt i, PetscInt *parent, PetscInt *number,
                       PetscInt *at, FlowNetwork *net, char message[MESSAGE_LENGTH])
{
  PetscReal s = 0.;
  PetscInt node = node_of_end(net, parent, number, i, 0);
  for (PetscBool last = PETSC_FALSE; !last;) {
    const PetscBool cut = (PetscBool)(*at < cuts->n && cuts->cut[*at].row == i &&
                                      cuts->cut[*at].s < 1. - TIE);
    const PetscReal to = cut ? cuts->cut[*at].s : 1.;
    last = (PetscBool)!cut;
    if (last || to > s + TIE) {
      const PetscInt next = last ? node_of_end(net, parent, number, i, 1) : node_within(net, i, to);
      net->piece[net->n_pieces++] = (FlowPiece){
          .row = i, .node = {node, next}, .s = {s, to}, .length = (to - s) * net->row[i].length};
      node = next, s = to;
    }
    while (*at < cuts->n && cuts->cut[*at].row == i && (last || cuts->cut[*at].s <= s + TIE)) {
      const PetscInt l = cuts->cut[(*at)++].drain;
      if (l >= 0)
        prescribe_node(loads, l, loads[l].uplift.gallery, loads[l].flow.conductance, node, net, message);
    }
  }
}

/* Prescribes heads and inflows at ends whose void has a vertex of the load's faces. */
static PetscErrorCode prescribe_faces(const Load *loads, PetscInt l, const FlowTarget *target,
                                      PetscInt *parent, const PetscInt *number, FlowNetwork *net,
                                      char unmet[MESSAGE_LENGTH], char message[MESSAGE_LENGTH])
{
  PetscInt n = 0;
  PetscBool *touched;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(net->n_nodes, &touched));
  for (PetscInt e = 0; e < 2 * net->n_rows; e++) {
    const PetscInt *gid = net->row[e / 2].vertex[e % 2], node = number[UnionRoot(parent, e)];
    if (net->row[e / 2].shut || touched[node] ||
        !(is_among(gid[0], target->n_vertices, target->vertices) ||
          is_among(gid[1], target->n_vertices, target->vertices)))
      continue;
    touched[node] = PETSC_TRUE, n++;
    if (loads[l].kind == LOAD_HEAD)
      prescribe_node(loads, l, loads[l].level, PETSC_INFINITY, node, net, message);
  }
  for (PetscInt i = 0; i < net->n_nodes && loads[l].kind == LOAD_INFLOW; i++) {
    if (!touched[i]) continue;
    net->node[i].inflow += loads[l].flow.discharge / n;
    if (net->node[i].load < 0) net->node[i].load = l;
  }
  if (!n && !unmet[0])
    snprintf(unmet, MESSAGE_LENGTH, ":%d: loads.%s.faces: no joint in which water flows ends at '%s'",
             loads[l].line, loads[l].name, loads[l].target);
  PetscCall(PetscFree(touched));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowNetworkDestroy(FlowNetwork *net)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(net->piece));
  PetscCall(PetscFree(net->node));
  PetscCall(PetscFree(net->drain));
  net->n_pieces = net->n_nodes = net->n_drains = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode make_cuts(const Scene *scene, const Stage *stage, const FlowTarget *target,
                                const FlowNetwork *net, Cuts *cuts, char unmet[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const PetscInt l = stage->loads[i];
    const LoadKind kind = scene->loads[l].kind;
    if (kind == LOAD_DRAIN || kind == LOAD_CURTAIN)
      PetscCall(cut_by_load(scene->loads + l, l, target + l, net, cuts, unmet));
  }
  if (cuts->n) qsort(cuts->cut, cuts->n, sizeof(Cut), cut_order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowNetworkBuild(const Scene *scene, const Stage *stage, const FlowTarget *target,
                                PetscReal reach, FlowNetwork *net, char unmet[MESSAGE_LENGTH],
                                char message[MESSAGE_LENGTH])
{
  const PetscInt n_ends = 2 * net->n_rows;
  Cuts cuts = {0};
  PetscInt *parent, *number, at = 0;
  Tag *tags;
  PetscFunctionBeginUser;
  PetscCall(FlowNetworkDestroy(net));
  unmet[0] = '\0';
  PetscCall(make_cuts(scene, stage, target, net, &cuts, unmet));
  PetscCall(PetscMalloc3(n_ends, &parent, n_ends, &number, 2 * n_ends, &tags));
  PetscCall(PetscMalloc1(net->n_rows + cuts.n + 1, &net->piece));
  PetscCall(PetscMalloc1(n_ends + cuts.n + 1, &net->node));
  PetscCall(PetscMalloc1(cuts.n + 1, &net->drain));
  for (PetscInt e = 0; e < n_ends; e++) parent[e] = e, number[e] = -1;
  unite_at_vertices(net, tags, parent);
  if (reach > 0.) unite_by_place(net, reach, tags, parent);
  for (PetscInt i = 0; i < net->n_rows; i++)
    if (!net->row[i].shut) add_pieces(scene->loads, &cuts, i, parent, number, &at, net, message);
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const PetscInt l = stage->loads[i];
    if (scene->loads[l].kind == LOAD_HEAD || scene->loads[l].kind == LOAD_INFLOW)
      PetscCall(prescribe_faces(scene->loads, l, target + l, parent, number, net, unmet, message));
  }
  PetscCall(PetscFree3(parent, number, tags));
  PetscCall(PetscFree(cuts.cut));
  FlowConduct(scene, stage, net);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- conductance */

/* Returns the aperture [m] at a position along a contact, before its limits. */
static PetscReal opening_at(const Joint *joint, const FlowRow *row, PetscReal s)
{
  return joint->aperture + row->opening[0] + s * (row->opening[1] - row->opening[0]);
}

static PetscReal within_limits(const Joint *joint, PetscReal a)
{
  return PetscMin(PetscMax(a, joint->aperture_residual), joint->aperture_max);
}

/* Returns the cube of the hydraulic aperture of a wedge between apertures a[0] and a[1], exact: a_h^3 = 2
   a0^2 a1^2 / (a0 + a1). */
static PetscReal wedge_cube(const PetscReal a[2])
{
  return 2. * a[0] * a[0] * a[1] * a[1] / (a[0] + a[1]);
}

/* Returns the same cube where the line from open[0] to open[1] passes a limit of the joint. The stretches
   resist in series. */
static PetscReal limited_cube(const Joint *joint, const PetscReal open[2])
{
  const PetscReal limit[2] = {joint->aperture_residual, joint->aperture_max}, rise = open[1] - open[0];
  PetscReal at[4] = {0., 0., 0., 1.}, resistance = 0.;
  int n = 1;
  for (int k = 0; k < 2; k++) {
    const int which = rise > 0. ? k : 1 - k; // in the order in which the line passes them
    if ((open[0] < limit[which]) != (open[1] < limit[which])) at[n++] = (limit[which] - open[0]) / rise;
  }
  at[n] = 1.;
  for (int k = 0; k < n; k++) {
    const PetscReal a[2] = {within_limits(joint, open[0] + at[k] * rise),
                            within_limits(joint, open[0] + at[k + 1] * rise)};
    if (n == 1) return wedge_cube(a);
    resistance += (at[k + 1] - at[k]) / wedge_cube(a);
  }
  return 1. / resistance;
}

void FlowConduct(const Scene *scene, const Stage *stage, FlowNetwork *net)
{
  const PetscReal gravity = scene->flow.density * scene->gravity / (12. * scene->flow.viscosity);
  for (FlowPiece *piece = net->piece; piece < net->piece + net->n_pieces; piece++) {
    const FlowRow *row = net->row + piece->row;
    const Joint *joint = stage->joints + row->joint;
    PetscReal s[2];
    PetscReal open[2];
    for (int k = 0; k < 2; k++) {
      open[k] = opening_at(joint, row, piece->s[k]);
      piece->a[k] = within_limits(joint, open[k]);
    }
    PetscReal cube = limited_cube(joint, open);
    for (PetscInt i = 0; i < stage->n_loads; i++) {
      const Load *load = scene->loads + stage->loads[i];
      if (load->kind != LOAD_CURTAIN || !within(row, &load->flow, s)) continue;
      const PetscReal middle = 0.5 * (piece->s[0] + piece->s[1]);
      if (middle < s[0] || middle > s[1]) continue;
      const PetscReal factor = load->flow.factor, given = load->flow.aperture;
      for (int k = 0; k < 2; k++) piece->a[k] = PetscIsNanReal(given) ? factor * piece->a[k] : given;
      cube = PetscIsNanReal(given) ? factor * factor * factor * cube : given * given * given;
    }
    piece->conductance = gravity * cube / (joint->roughness * piece->length);
  }
}

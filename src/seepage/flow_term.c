/* flow_term.c: makes the flow of water in joints a force term, with its summary, warnings and results. */
#include "seepage/flow.h"
#include "scene/reader.h"

/* Adds the forces of flowing water. The first condition of the stage represents all conditions in the list of
   loads. */
static PetscErrorCode applied(const TermView *v, PetscInt load, PetscReal *f)
{
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (!FlowActs(v->scene, v->stage, &carrier) || carrier != load) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  FlowForces(v->memory, v->scene, v->m, v->state->u + 3 * v->m->rigid.n, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool FlowIsTrial(const TermView *v)
{
  PetscInt carrier;
  return (PetscBool)(FlowActs(v->scene, v->stage, &carrier) && v->scene->flow.coupling == FLOW_TWO_WAY &&
                     !StageInTime(v->stage));
}

/* ---- results */

static void put_conditions(Json *json, const TermView *v)
{
  const Flow *flow = v->memory;
  JsonOpen(json, "conditions");
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const PetscInt l = v->stage->loads[i];
    const Load *load = v->scene->loads + l;
    PetscInt n;
    if (load->kind != LOAD_HEAD && load->kind != LOAD_DRAIN && load->kind != LOAD_INFLOW) continue;
    const PetscReal q = FlowDischarge(flow, l, &n);
    JsonObject(json, load->name, {"nodes", n}, {"discharge", q}, {"litres_per_minute", 6e4 * q});
  }
  JsonClose(json);
}

/* Sums over the pieces of a joint. */
typedef struct {
  PetscInt n;
  PetscReal length, force, centre[2], residual, largest, widest, reynolds;
} JointWaterSum;

static void add_piece(const Flow *flow, const Scene *scene, const Joint *joint, PetscInt i,
                      JointWaterSum *sum)
{
  const FlowSettings *water = &scene->flow;
  const FlowPiece *piece = flow->net.piece + i;
  const FlowRow *row = flow->net.row + piece->row;
  PetscReal p[2];
  for (int k = 0; k < 2; k++) p[k] = FlowPressure(flow, scene, i, k);
  const PetscReal force = 0.5 * (p[0] + p[1]) * piece->length,
                  at = p[0] + p[1] > 0. ? (p[0] + 2. * p[1]) / (3. * (p[0] + p[1])) : 0.5,
                  s = piece->s[0] + at * (piece->s[1] - piece->s[0]);
  sum->n++, sum->length += piece->length, sum->force += force;
  for (int x = 0; x < 2; x++) sum->centre[x] += force * (row->x[0][x] + s * (row->x[1][x] - row->x[0][x]));
  for (int k = 0; k < 2; k++) {
    if (piece->a[k] <= joint->aperture_residual) sum->residual += 0.5 * piece->length;
    if (piece->a[k] >= joint->aperture_max) sum->largest += 0.5 * piece->length;
    sum->widest = PetscMax(sum->widest, piece->a[k]);
  }
  sum->reynolds = PetscMax(sum->reynolds,
                           2. * water->density * PetscAbsReal(flow->now.discharge[i]) / water->viscosity);
}

static void put_joints(Json *json, const TermView *v, PetscReal *reynolds)
{
  const Flow *flow = v->memory;
  JsonOpen(json, "joints");
  for (PetscInt j = 0; j < v->scene->n_joints; j++) {
    JointWaterSum sum = {0};
    for (PetscInt i = 0; i < flow->net.n_pieces; i++)
      if (flow->net.row[flow->net.piece[i].row].joint == j)
        add_piece(flow, v->scene, v->stage->joints + j, i, &sum);
    *reynolds = PetscMax(*reynolds, sum.reynolds);
    if (!sum.n) continue;
    JsonObject(json, v->scene->joints[j].name, {"length", sum.length},
               {"uplift", sum.force * v->m->materials.thickness},
               {"centre_x", sum.force > 0. ? sum.centre[0] / sum.force : 0.},
               {"centre_y", sum.force > 0. ? sum.centre[1] / sum.force : 0.},
               {"at_residual", sum.residual / sum.length}, {"at_max", sum.largest / sum.length},
               {"widest", sum.widest}, {"reynolds", sum.reynolds});
  }
  JsonClose(json);
}

static void summary(Json *json, const TermView *v)
{
  const Flow *flow = v->memory;
  PetscReal reynolds = 0., length = 0.;
  PetscInt carrier;
  if (!FlowActs(v->scene, v->stage, &carrier) || !flow->net.n_rows) return;
  PetscCallAbort(PETSC_COMM_SELF, FlowFresh(v));
  for (PetscInt i = 0; i < flow->net.n_pieces; i++)
    if (flow->now.cut_off[flow->net.piece[i].node[0]]) length += flow->net.piece[i].length;
  JsonOpen(json, "flow");
  JsonText(json, "state", flow->frozen ? "frozen" : flow->net.step > 0. ? "transient" : "steady");
  JsonNumbers(json, {"rounds", flow->rounds}, {"change", flow->sums.change}, {"nodes", flow->net.n_nodes},
              {"pieces", flow->net.n_pieces}, {"inflow", flow->now.inflow}, {"error", flow->now.error},
              {"volume", flow->sums.volume});
  if (flow->net.step > 0.) {
    JsonNumbers(json, {"step", flow->net.step}, {"taken", flow->sums.taken},
                {"volume_error", FlowVolumeError(flow)});
  }
  JsonNumber(json, "cut_off_length", length);
  put_conditions(json, v);
  put_joints(json, v, &reynolds);
  JsonNumber(json, "reynolds", reynolds);
  JsonClose(json);
}

/* Rank 0. Warns of a flow outside the range of the cubic law, and of a drain that feeds the joints. */
static void warn(const TermView *v)
{
  enum { FAST = 500, TURBULENT = 2000 };
  const Flow *flow = v->memory;
  const FlowSettings *water = &v->scene->flow;
  PetscReal most = 0.;
  PetscInt n;
  if (flow->net.step > 0.) FlowReportVolume(v);
  for (PetscInt i = 0; i < flow->net.n_pieces; i++)
    most = PetscMax(most, 2. * water->density * PetscAbsReal(flow->now.discharge[i]) / water->viscosity);
  if (most > FAST)
    Warn("stage %s: the largest Reynolds number of the water in joints is %.3g: %s", v->stage->name,
         (double)most,
         most > TURBULENT ? "it is not laminar, and less water flows than the cubic law says"
                          : "it is laminar up to some 500 to 2000");
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const Load *load = v->scene->loads + v->stage->loads[i];
    const PetscReal q = load->kind == LOAD_DRAIN ? FlowDischarge(flow, v->stage->loads[i], &n) : 0.;
    if (-q > 1e-6 * flow->now.inflow)
      Warn("stage %s: the drain %s gives %.3g m2/s to the joints: its gallery stands higher", v->stage->name,
           load->name, (double)-q);
  }
}

static PetscErrorCode before_summary(const TermView *v, PetscBool report)
{
  const Flow *flow = v->memory;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (!report || v->m->rank || !FlowActs(v->scene, v->stage, &carrier) || !flow->net.n_rows || flow->frozen ||
      StageInTime(v->stage)) // nothing is discharged in a dynamic stage
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  warn(v);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the table of results with one row per piece: see results_format.md. */
static PetscErrorCode table(const TermView *v, PetscInt which, TermTable *t)
{
  enum { POINT, HEAD, PRESSURE, APERTURE, SATURATION, DISCHARGE, LENGTH, JOINT };
  static const TermColumn columns[TERM_COLUMNS] = {
      [POINT] = {"point", 4, NULL},           [HEAD] = {"head", 2, NULL},
      [PRESSURE] = {"pressure", 2, NULL},     [APERTURE] = {"aperture", 2, NULL},
      [SATURATION] = {"saturation", 2, NULL}, [DISCHARGE] = {"discharge", 1, NULL},
      [LENGTH] = {"length", 1, NULL},         [JOINT] = {"joint", 1, NULL}};
  const Flow *flow = v->memory;
  const FlowNetwork *net = &flow->net;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (which || !FlowActs(v->scene, v->stage, &carrier)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  if (!net->n_pieces) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TermTableCreate("flow", net->n_pieces, TERM_COLUMNS, columns, t));
  for (PetscInt i = 0; i < net->n_pieces; i++) {
    const FlowPiece *piece = net->piece + i;
    for (int k = 0; k < 2; k++) {
      const PetscInt node = piece->node[k];
      for (int x = 0; x < 2; x++) t->columns[POINT].values[4 * i + 2 * k + x] = net->node[node].x[x];
      t->columns[HEAD].values[2 * i + k] = net->node[node].x[1] + flow->now.pressure[node];
      t->columns[PRESSURE].values[2 * i + k] = FlowPressure(flow, v->scene, i, k);
      t->columns[APERTURE].values[2 * i + k] = piece->a[k];
      t->columns[SATURATION].values[2 * i + k] = flow->now.saturation[node];
    }
    t->columns[DISCHARGE].values[i] = flow->now.discharge[i];
    t->columns[LENGTH].values[i] = piece->length;
    t->columns[JOINT].values[i] = (PetscReal)net->row[piece->row].joint;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

/* Returns whether a drain or a curtain has an axis, from `from` to `to`. */
static PetscBool has_axis(const FlowKeys *flow)
{
  return (PetscBool) !(isnan(flow->from[0]) || isnan(flow->to[0]));
}

/* Checks that the axis of a drain or a curtain is a line. */
static PetscErrorCode complete_axis(Reader *r, const char *path, const FlowKeys *flow)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "to", &given));
  if (has_axis(flow) && hypot(flow->to[0] - flow->from[0], flow->to[1] - flow->from[1]) == 0.)
    COMPLAIN(r, "from and to are one point");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteCurtain(Reader *r, const char *path, Load *load)
{
  const FlowKeys *flow = &load->flow;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "from", &given));
  if (!has_axis(flow)) COMPLAIN_MISSING(r, "missing [m]: a curtain needs from and to, the ends of its axis");
  PetscCall(IsGiven(r, path, "factor", &given));
  if (isnan(flow->factor) == isnan(flow->aperture))
    COMPLAIN_MISSING(r, "a curtain needs a factor [-] or an aperture [m], one of them");
  PetscCall(complete_axis(r, path, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteDrain(Reader *r, const char *path, Load *load)
{
  const FlowKeys *flow = &load->flow;
  const PetscBool line = has_axis(flow);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "distance", &given));
  if ((PetscBool)!isnan(flow->distance) == line || (given && !load->target[0]))
    COMPLAIN_MISSING(r, "a drain needs joint and distance [m], or from and to [m], one of these pairs");
  PetscCall(IsGiven(r, path, "joint", &given));
  if (given && line)
    COMPLAIN(r, "a drain with from and to meets every joint that it crosses: expected joint and distance [m] "
                "without them");
  PetscCall(complete_axis(r, path, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Flow_term = {.name = "flow",
                            .loads = 1u << LOAD_HEAD | 1u << LOAD_DRAIN | 1u << LOAD_CURTAIN |
                                     1u << LOAD_INFLOW,
                            .presses = PETSC_TRUE,
                            .create = FlowCreate,
                            .destroy = FlowDestroy,
                            .applied = applied,
                            .begin = FlowBegin,
                            .settle = FlowSettle,
                            .before_summary = before_summary,
                            .history = FlowHistory,
                            .archive = FlowArchive,
                            .archive_stable = FlowArchiveStable,
                            .table = table,
                            .summary = summary};

/* flow_term.c: water that flows in joints as a force term: what it remembers, and what it tells. */
#include "forces/water/flow.h"

static PetscErrorCode create(const TermView *v, void **memory)
{
  Flow *flow;
  PetscFunctionBeginUser;
  PetscCall(FlowCreate(v, &flow));
  *memory = flow;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  Flow *flow = *memory;
  PetscFunctionBeginUser;
  PetscCall(FlowDestroy(scene, &flow));
  *memory = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first of the stage's conditions stands for all of them. */
static PetscErrorCode applied(const TermView *v, PetscInt load, PetscReal *f)
{
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (!FlowActs(v->scene, v->stage, &carrier) || carrier != load) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  FlowForces(v->memory, v->scene, v->m, v->state->u + 3 * v->m->n_bodies, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  FlowTrapForces(memory, at->m, at->u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode bound(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  PetscFunctionBeginUser;
  (void)anywhere; // what comes about as bodies move holds no water
  FlowTrapBound(memory, at->m, k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode energy(const void *memory, const Instant *at, PetscReal *sum)
{
  PetscFunctionBeginUser;
  *sum += FlowTrapEnergy(memory, at->m, at->u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Until water and openings agree, what a round has opened or slid is forgotten: else the answer would hang on
   the rounds. */
static PetscBool tries(const TermView *v)
{
  PetscInt carrier;
  return (PetscBool)(FlowActs(v->scene, v->stage, &carrier) && v->scene->flow.coupling == FLOW_TWO_WAY &&
                     v->stage->kind != STAGE_DYNAMIC);
}

/* ---- memory */

static PetscErrorCode copy_rows(PetscInt n, const FlowRow *from, FlowRow **to)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(*to));
  PetscCall(PetscMalloc1(n, to));
  PetscCall(PetscArraycpy(*to, from, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode copy_reals(PetscInt n, const PetscReal *from, PetscReal **to)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(*to));
  PetscCall(PetscMalloc1(n, to));
  PetscCall(PetscArraycpy(*to, from, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode keep_stable(Flow *flow)
{
  PetscFunctionBeginUser;
  flow->n_stable = flow->net.n_rows, flow->n_acting_stable = flow->net.n_nodes,
  flow->rounds_stable = flow->rounds;
  flow->change_stable = flow->change;
  PetscCall(copy_rows(flow->net.n_rows, flow->net.row, &flow->row_stable));
  PetscCall(copy_reals(flow->net.n_nodes, flow->acting, &flow->acting_stable));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes rows and pressures; the network follows from them when it is asked for. */
static PetscErrorCode put_back(Flow *flow, PetscInt n_rows, const FlowRow *rows, PetscInt n,
                               const PetscReal *acting)
{
  PetscFunctionBeginUser;
  PetscCall(copy_rows(n_rows, rows, &flow->net.row));
  PetscCall(copy_reals(n, acting, &flow->acting));
  PetscCall(copy_reals(n, acting, &flow->reference));
  flow->net.n_rows = n_rows, flow->net.n_nodes = n;
  flow->stale = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode history(const TermView *v, TermHistory what)
{
  Flow *flow = v->memory;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (!FlowActs(v->scene, v->stage, &carrier)) PetscFunctionReturn(PETSC_SUCCESS);
  if (what == KEEP_STABLE) PetscCall(keep_stable(flow));
  if (what == BACK_TO_STABLE) {
    PetscCall(put_back(flow, flow->n_stable, flow->row_stable, flow->n_acting_stable, flow->acting_stable));
    PetscCall(FlowFresh(v)); // with the levels of the trial
    flow->rounds = flow->rounds_stable, flow->change = flow->change_stable;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows in either direction. n: read before. */
static PetscErrorCode archive_rows(Archive *a, const char *name, PetscInt n, FlowRow **rows)
{
  char label[NAME_LENGTH];
  PetscInt *ints;
  PetscReal *reals;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n * ROW_INTS, &ints, n * ROW_REALS, &reals));
  if (a->reading) {
    PetscCall(PetscFree(*rows));
    PetscCall(PetscCalloc1(n, rows));
  }
  for (int pass = 0; pass < 2; pass++) { // into the lists, then, read anew, out of them
    for (PetscInt i = 0; i < n && pass == (a->reading ? 1 : 0); i++) {
      FlowRow *row = *rows + i;
      PetscInt *in = ints + ROW_INTS * i, *const at[ROW_INTS] = {
                                              &row->key[0],       &row->key[1],       &row->joint,
                                              &row->parted,       &row->shut,         &row->failed[0],
                                              &row->failed[1],    &row->vertex[0][0], &row->vertex[0][1],
                                              &row->vertex[1][0], &row->vertex[1][1]};
      PetscReal *re = reals + ROW_REALS * i, *const to[ROW_REALS] = {
                                                 &row->x[0][0],    &row->x[0][1],   &row->x[1][0],
                                                 &row->x[1][1],    &row->t[0][0],   &row->t[0][1],
                                                 &row->t[1][0],    &row->t[1][1],   &row->length,
                                                 &row->opening[0], &row->opening[1]};
      for (int k = 0; k < ROW_INTS; k++) pass ? (*at[k] = in[k]) : (in[k] = *at[k]);
      for (int k = 0; k < ROW_REALS; k++) pass ? (*to[k] = re[k]) : (re[k] = *to[k]);
    }
    if (pass) break;
    PetscCall(PetscSNPrintf(label, sizeof(label), "%s_rows", name));
    PetscCall(ArchiveInts(a, label, n * ROW_INTS, ints));
    PetscCall(PetscSNPrintf(label, sizeof(label), "%s_places", name));
    PetscCall(ArchiveReals(a, label, n * ROW_REALS, reals));
  }
  PetscCall(PetscFree2(ints, reals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* (n,) numbers in either direction. */
static PetscErrorCode archive_list(Archive *a, const char *name, PetscInt n, PetscReal **list)
{
  PetscFunctionBeginUser;
  if (a->reading) {
    PetscCall(PetscFree(*list));
    PetscCall(PetscCalloc1(n, list));
  }
  PetscCall(ArchiveReals(a, name, n, *list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_mixer(Archive *a, Mixer *mixer, PetscInt n, PetscInt n_old)
{
  char label[NAME_LENGTH];
  PetscFunctionBeginUser;
  if (a->reading) PetscCall(MixerReset(mixer));
  mixer->n = n_old ? n : mixer->n, mixer->n_old = n_old;
  for (int k = 0; k < n_old; k++) {
    PetscCall(PetscSNPrintf(label, sizeof(label), "flow_x_%d", k));
    PetscCall(archive_list(a, label, n, mixer->x + k));
    PetscCall(PetscSNPrintf(label, sizeof(label), "flow_g_%d", k));
    PetscCall(archive_list(a, label, n, mixer->g + k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water at ends of pieces, in either direction. */
static PetscErrorCode archive_water(Archive *a, const char *name, PetscInt *count, FlowWater **list)
{
  char label[NAME_LENGTH];
  PetscInt *ints, n = *count;
  PetscReal *reals;
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_count", name));
  PetscCall(ArchiveInts(a, label, 1, &n));
  if (a->reading) {
    *count = n = (PetscInt)ArchiveWithin(a, "ends of the flow", n, 0, PETSC_MAX_INT / 64);
    PetscCall(PetscFree(*list));
    PetscCall(PetscCalloc1(n, list));
  }
  PetscCall(PetscMalloc2(3 * n, &ints, 6 * n, &reals));
  for (PetscInt i = 0; i < n && !a->reading; i++) {
    const FlowWater *w = *list + i;
    ints[3 * i] = w->key[0], ints[3 * i + 1] = w->key[1], ints[3 * i + 2] = w->side;
    const PetscReal numbers[6] = {w->s, w->a, w->psi, w->chi, w->length, w->held};
    PetscCall(PetscArraycpy(reals + 6 * i, numbers, 6));
  }
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_faces", name));
  PetscCall(ArchiveInts(a, label, 3 * n, ints));
  PetscCall(ArchiveReals(a, name, 6 * n, reals));
  for (PetscInt i = 0; i < n && a->reading; i++) {
    const PetscInt *in = ints + 3 * i;
    const PetscReal *re = reals + 6 * i;
    (*list)[i] = (FlowWater){{in[0], in[1]}, re[0], re[1], re[2],
                             re[3],          re[4], re[5], (FlowSide)in[2]}; // in its order
  }
  PetscCall(PetscFree2(ints, reals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  Flow *flow = v->memory;
  PetscInt counts[5] = {flow->net.n_rows, flow->net.n_nodes, flow->mixer.n_old, flow->rounds, flow->frozen};
  PetscFunctionBeginUser;
  if (!FlowEverActs(v->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveInts(a, "flow_counts", 5, counts));
  for (int i = 0; i < 3 && a->reading; i++)
    counts[i] = (PetscInt)ArchiveWithin(a, "sizes of the flow", counts[i], 0,
                                        i == 2 ? MIXED : PETSC_MAX_INT / 64);
  flow->net.n_rows = counts[0], flow->net.n_nodes = counts[1], flow->rounds = counts[3];
  flow->frozen = (PetscBool)counts[4], flow->stale = (PetscBool)(flow->stale || a->reading);
  enum { REALS = 11 };
  PetscReal reals[REALS], *const of[REALS] = {&flow->change,       &flow->volume,      &flow->volume_0,
                                              &flow->taken,        &flow->entered,     &flow->early,
                                              &flow->first,        &flow->first_taken, &flow->first_entered,
                                              &flow->first_change, &flow->within};
  for (int i = 0; i < REALS; i++) reals[i] = *of[i];
  PetscCall(ArchiveReals(a, "flow_change_volumes", REALS, reals));
  for (int i = 0; i < REALS; i++) *of[i] = reals[i];
  PetscCall(archive_water(a, "flow_past", &flow->n_past, &flow->past));
  PetscCall(archive_water(a, "flow_present", &flow->n_present, &flow->present));
  PetscCall(archive_rows(a, "flow", counts[0], &flow->net.row));
  PetscCall(archive_list(a, "flow_acting", counts[1], &flow->acting));
  PetscCall(archive_list(a, "flow_reference", counts[1], &flow->reference));
  PetscCall(archive_mixer(a, &flow->mixer, counts[1], counts[2]));
  PetscCall(FlowTrapsArchive(a, v->m, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_stable(Archive *a, const TermView *v)
{
  Flow *flow = v->memory;
  PetscInt counts[3] = {flow->n_stable, flow->n_acting_stable, flow->rounds_stable};
  PetscFunctionBeginUser;
  if (!FlowEverActs(v->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveInts(a, "flow_stable_counts", 3, counts));
  for (int i = 0; i < 2 && a->reading; i++)
    counts[i] = (PetscInt)ArchiveWithin(a, "sizes of the flow", counts[i], 0, PETSC_MAX_INT / 64);
  flow->n_stable = counts[0], flow->n_acting_stable = counts[1], flow->rounds_stable = counts[2];
  PetscCall(ArchiveReals(a, "flow_stable_change", 1, &flow->change_stable));
  PetscCall(archive_rows(a, "flow_stable", flow->n_stable, &flow->row_stable));
  PetscCall(archive_list(a, "flow_stable_acting", flow->n_acting_stable, &flow->acting_stable));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- answers */

static void put_conditions(FILE *f, const TermView *v)
{
  const Flow *flow = v->memory;
  const char *before = "";
  fprintf(f, "        \"conditions\": {");
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const PetscInt l = v->stage->loads[i];
    const Load *load = v->scene->loads + l;
    PetscInt n;
    if (load->kind != LOAD_HEAD && load->kind != LOAD_DRAIN && load->kind != LOAD_INFLOW) continue;
    const PetscReal q = FlowDischarge(flow, l, &n);
    fprintf(f, "%s\n          \"%s\": {", before, load->name);
    JsonCount(f, "nodes", n, ", ");
    JsonNumber(f, "discharge", q, ", ");
    JsonNumber(f, "litres_per_minute", 6e4 * q, "}");
    before = ",";
  }
  fprintf(f, "\n        },\n");
}

/* What water does in the pieces of a joint. */
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
  if (!flow->n_traps)
    sum->reynolds = PetscMax(sum->reynolds,
                             2. * water->density * PetscAbsReal(flow->now.discharge[i]) / water->viscosity);
}

static void put_joints(FILE *f, const TermView *v, PetscReal *reynolds)
{
  const Flow *flow = v->memory;
  const char *before = "";
  fprintf(f, "        \"joints\": {");
  for (PetscInt j = 0; j < v->scene->n_joints; j++) {
    JointWaterSum sum = {0};
    for (PetscInt i = 0; i < flow->net.n_pieces; i++)
      if (flow->net.row[flow->net.piece[i].row].joint == j)
        add_piece(flow, v->scene, v->stage->joints + j, i, &sum);
    *reynolds = PetscMax(*reynolds, sum.reynolds);
    if (!sum.n) continue;
    fprintf(f, "%s\n          \"%s\": {", before, v->scene->joints[j].name);
    JsonNumber(f, "length", sum.length, ", ");
    JsonNumber(f, "uplift", sum.force * v->m->thickness, ", ");
    JsonNumber(f, "centre_x", sum.force > 0. ? sum.centre[0] / sum.force : 0., ", ");
    JsonNumber(f, "centre_y", sum.force > 0. ? sum.centre[1] / sum.force : 0., ", ");
    JsonNumber(f, "at_residual", sum.residual / sum.length, ", ");
    JsonNumber(f, "at_max", sum.largest / sum.length, ", ");
    JsonNumber(f, "widest", sum.widest, ", ");
    JsonNumber(f, "reynolds", sum.reynolds, "}");
    before = ",";
  }
  fprintf(f, "\n        },\n");
}

static void summary(FILE *f, const TermView *v)
{
  const Flow *flow = v->memory;
  PetscReal reynolds = 0., length = 0.;
  PetscInt carrier;
  if (!FlowActs(v->scene, v->stage, &carrier) || !flow->net.n_rows) return;
  PetscCallAbort(PETSC_COMM_SELF, FlowFresh(v));
  for (PetscInt i = 0; i < flow->net.n_pieces; i++)
    if (flow->now.cut_off[flow->net.piece[i].node[0]]) length += flow->net.piece[i].length;
  fprintf(f, "      \"flow\": {\n        ");
  JsonText(f, "state",
           flow->n_traps         ? "undrained"
           : flow->frozen        ? "frozen"
           : flow->net.step > 0. ? "transient"
                                 : "steady",
           ", ");
  JsonCount(f, "rounds", flow->rounds, ", ");
  JsonNumber(f, "change", flow->change, ", ");
  JsonCount(f, "nodes", flow->net.n_nodes, ", ");
  JsonCount(f, "pieces", flow->net.n_pieces, ", ");
  JsonNumber(f, "inflow", flow->n_traps ? 0. : flow->now.inflow, ", ");
  JsonNumber(f, "error", flow->now.error, ", ");
  JsonNumber(f, "volume", flow->volume, ", ");
  if (flow->net.step > 0.) {
    JsonNumber(f, "step", flow->net.step, ", ");
    JsonNumber(f, "taken", flow->taken, ", ");
    JsonNumber(f, "volume_error", FlowVolumeError(flow), ", ");
  }
  JsonNumber(f, "cut_off_length", length, ",\n");
  put_conditions(f, v);
  put_joints(f, v, &reynolds);
  fprintf(f, "        ");
  JsonNumber(f, "reynolds", reynolds, "\n      },\n");
}

/* Rank 0. Warns of a flow that is not that of the cubic law, and of a drain that feeds the joints. */
static void warn(const TermView *v)
{
  enum { FAST = 500, TURBULENT = 2000 };
  const Flow *flow = v->memory;
  const FlowSettings *water = &v->scene->flow;
  PetscReal most = 0.;
  PetscInt n;
  if (flow->net.step > 0.) FlowTellVolume(v);
  for (PetscInt i = 0; i < flow->net.n_pieces; i++)
    most = PetscMax(most, 2. * water->density * PetscAbsReal(flow->now.discharge[i]) / water->viscosity);
  if (most > FAST)
    fprintf(stderr,
            "quoin: warning: stage %s: the largest Reynolds number of the water in joints is %.3g: %s\n",
            v->stage->name, (double)most,
            most > TURBULENT ? "it is not laminar, and less water flows than the cubic law says"
                             : "it is laminar up to some 500 to 2000");
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const Load *load = v->scene->loads + v->stage->loads[i];
    const PetscReal q = load->kind == LOAD_DRAIN ? FlowDischarge(flow, v->stage->loads[i], &n) : 0.;
    if (-q > 1e-6 * flow->now.inflow)
      fprintf(
          stderr,
          "quoin: warning: stage %s: the drain %s gives %.3g m2/s to the joints: its gallery stands higher\n",
          v->stage->name, load->name, (double)-q);
  }
  fflush(stderr);
}

static PetscErrorCode survey(const TermView *v, PetscBool tell)
{
  const Flow *flow = v->memory;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (flow->n_traps) PetscCall(FlowTrapsLook(v));
  if (!tell || v->m->rank || !FlowActs(v->scene, v->stage, &carrier) || !flow->net.n_rows || flow->frozen ||
      v->stage->kind == STAGE_DYNAMIC) // in time nothing is discharged
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  warn(v);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A row of results for each piece, a column each: see results_format.md. */
static PetscErrorCode table(const TermView *v, PetscInt which, TermTable *t)
{
  enum { POINT, HEAD, PRESSURE, APERTURE, SATURATION, DISCHARGE, LENGTH, JOINT };
  static const struct {
    const char *name;
    PetscInt width;
  } columns[TERM_COLUMNS] = {[POINT] = {"point", 4},           [HEAD] = {"head", 2},
                             [PRESSURE] = {"pressure", 2},     [APERTURE] = {"aperture", 2},
                             [SATURATION] = {"saturation", 2}, [DISCHARGE] = {"discharge", 1},
                             [LENGTH] = {"length", 1},         [JOINT] = {"joint", 1}};
  const Flow *flow = v->memory;
  const FlowNetwork *net = &flow->net;
  const PetscReal rho_g = v->scene->flow.density * v->scene->gravity;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (which || !FlowActs(v->scene, v->stage, &carrier)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FlowFresh(v));
  t->name = "flow";
  t->n_rows = net->n_pieces, t->n_columns = t->n_rows ? TERM_COLUMNS : 0;
  for (PetscInt c = 0; c < t->n_columns; c++) {
    t->columns[c].name = columns[c].name, t->columns[c].width = columns[c].width;
    PetscCall(PetscMalloc1(t->n_rows * columns[c].width, &t->columns[c].values));
  }
  for (PetscInt i = 0; i < net->n_pieces; i++) {
    const FlowPiece *piece = net->piece + i;
    for (int k = 0; k < 2; k++) {
      const PetscInt node = piece->node[k];
      const PetscReal p = FlowPressure(flow, v->scene, i, k);
      for (int x = 0; x < 2; x++) t->columns[POINT].values[4 * i + 2 * k + x] = net->node[node].x[x];
      t->columns[HEAD].values[2 * i + k] = net->node[node].x[1] +
                                           (flow->n_traps ? p / rho_g : flow->now.pressure[node]);
      t->columns[PRESSURE].values[2 * i + k] = p;
      t->columns[APERTURE].values[2 * i + k] = piece->a[k];
      t->columns[SATURATION].values[2 * i + k] = flow->now.saturation[node];
    }
    t->columns[DISCHARGE].values[i] = flow->n_traps ? 0. : flow->now.discharge[i];
    t->columns[LENGTH].values[i] = piece->length;
    t->columns[JOINT].values[i] = (PetscReal)net->row[piece->row].joint;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Flow_term = {.name = "flow",
                            .loads = 1u << LOAD_HEAD | 1u << LOAD_DRAIN | 1u << LOAD_CURTAIN |
                                     1u << LOAD_INFLOW,
                            .presses = PETSC_TRUE,
                            .create = create,
                            .destroy = destroy,
                            .forces = forces,
                            .bound = bound,
                            .energy = energy,
                            .applied = applied,
                            .begin = FlowBegin,
                            .settle = FlowSettle,
                            .tries = tries,
                            .survey = survey,
                            .history = history,
                            .archive = archive,
                            .archive_stable = archive_stable,
                            .step_over = FlowStepOver,
                            .table = table,
                            .summary = summary};

/* flow.c: computes the flow of water in joints, the acting pressures, and their coupling with openings.

   Acting pressures are constant during relaxation. At equilibrium the openings give new apertures, the
   apertures a new flow, and the flow the pressures of the next round (coupling.c), until pressures no
   longer change. A dynamic stage keeps the pressures of the stage before. */
#include "seepage/flow.h"

static const PetscReal NEAR = 1e-3; /* unbalanced ratio per change of pressure: near_enough */

/* ---- forces */

/* Lists the faces of this rank on which pieces press, in the order of pieces. */
static PetscErrorCode find_pushes(const Model *m, Flow *flow)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(flow->push));
  PetscCall(PetscMalloc1(2 * flow->net.n_pieces, &flow->push));
  flow->n_push = 0;
  for (PetscInt i = 0; i < flow->net.n_pieces; i++)
    for (int side = 0; side < 2; side++) {
      const PetscInt face = FaceRow(m, flow->net.row[flow->net.piece[i].row].key[side]);
      if (face >= 0 && face < m->faces.n_local) flow->push[flow->n_push++] = (FlowPush){i, side, face};
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void FlowForces(const Flow *flow, const Scene *scene, const Model *m, const PetscReal *u, PetscReal *f)
{
  const PetscReal rho_g = scene->flow.density * scene->gravity;
  for (const FlowPush *push = flow->push; push < flow->push + flow->n_push; push++) {
    const FlowPiece *piece = flow->net.piece + push->piece;
    const PetscReal *ends = flow->net.row[piece->row].t[push->side];
    const PetscInt *v = m->faces.vertex + 2 * push->face;
    PetscReal x[4], t[2], p[2], f_face[4] = {0., 0., 0., 0.};
    for (int k = 0; k < 2; k++) {
      t[k] = ends[0] + piece->s[k] * (ends[1] - ends[0]);
      p[k] = rho_g * flow->acting[piece->node[k]];
    }
    FaceCoordinates(m, m->materials.strain == STRAIN_LARGE ? u : NULL, push->face, x);
    PushAlongFace(t, p, x, m->materials.thickness, f_face);
    for (int k = 0; k < 4; k++)
      if (v[k / 2] < m->mesh.n_owned) f[2 * v[k / 2] + k % 2] += f_face[k];
  }
}

PetscReal FlowPressure(const Flow *flow, const Scene *scene, PetscInt piece, int end)
{
  return scene->flow.density * scene->gravity * flow->acting[flow->net.piece[piece].node[end]];
}

/* ---- the present flow */

/* Sets the reference pressures of a new network to those at the start of the time step. */
static void take_past(Flow *flow)
{
  for (PetscInt e = 0; e < 2 * flow->net.n_pieces; e++) {
    const FlowPiece *piece = flow->net.piece + e / 2;
    FlowWater water;
    if (FlowWaterAt(flow->past, flow->n_past, flow->net.row[piece->row].key, piece->s[e % 2],
                    piece->s[1 - e % 2], &water))
      flow->reference[piece->node[e % 2]] = water.psi;
  }
}

/* Stores the present water at ends of pieces, and computes its volume [m2]. */
static PetscErrorCode store_present(const TermView *v)
{
  Flow *flow = v->memory;
  const PetscReal rho_g = v->scene->flow.density * v->scene->gravity;
  PetscFunctionBeginUser;
  flow->n_present = 2 * flow->net.n_pieces, flow->sums.volume = 0.;
  PetscCall(PetscFree(flow->present));
  PetscCall(PetscMalloc1(flow->n_present, &flow->present));
  for (PetscInt e = 0; e < flow->n_present; e++) {
    const FlowPiece *piece = flow->net.piece + e / 2;
    const FlowRow *row = flow->net.row + piece->row;
    const int k = e % 2;
    const PetscInt node = piece->node[k];
    FlowWater *water = flow->present + e;
    *water = (FlowWater){.key = {row->key[0], row->key[1]},
                         .s = piece->s[k],
                         .a = piece->a[k],
                         .psi = flow->now.pressure[node],
                         .chi = flow->now.saturation[node],
                         .length = piece->length,
                         .wetness = flow->now.wetness[node]};
    if (water->chi >= 1.)
      water->a += FlowCompliance(v->scene, v->stage, &flow->net, e / 2, k) * rho_g *
                  (water->psi - flow->reference[node]);
    const PetscReal wide = v->scene->flow.coupling == FLOW_ONE_WAY ? piece->a[k] : water->a;
    water->volume = water->a * water->chi + wide * rho_g * water->psi / v->scene->flow.bulk_modulus;
    flow->sums.volume += 0.5 * piece->length * water->volume;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the reference pressures of the openings just measured: the acting pressures, or, in a changed
   network, those at the start of the time step. */
static PetscErrorCode set_reference(Flow *flow, PetscBool same)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(flow->reference));
  PetscCall(PetscCalloc1(flow->net.n_nodes, &flow->reference));
  if (same)
    PetscCall(PetscArraycpy(flow->reference, flow->acting, flow->net.n_nodes));
  else
    take_past(flow);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the acting pressures at the ends of pieces. */
static PetscErrorCode list_acting(const Flow *flow, PetscInt *n, FlowWater **list)
{
  PetscFunctionBeginUser;
  *n = 2 * flow->net.n_pieces;
  PetscCall(PetscCalloc1(*n + 1, list));
  for (PetscInt e = 0; e < *n; e++) {
    const FlowPiece *piece = flow->net.piece + e / 2;
    const PetscInt *key = flow->net.row[piece->row].key;
    (*list)[e] = (FlowWater){
        .key = {key[0], key[1]}, .s = piece->s[e % 2], .psi = flow->acting[piece->node[e % 2]]};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transfers the earlier acting pressures, (n,) at ends of pieces, to the present network. New pieces get
   0. same receives whether the pieces are unchanged. */
static PetscErrorCode keep_acting(Flow *flow, PetscInt n, const FlowWater *before, PetscBool *same)
{
  const PetscReal tolerance = 0.01; // of a contact: a drain keeps its distance while its contact strains
  PetscFunctionBeginUser;
  PetscCall(PetscFree(flow->acting));
  PetscCall(PetscCalloc1(flow->net.n_nodes, &flow->acting));
  *same = (PetscBool)(n == 2 * flow->net.n_pieces);
  for (PetscInt e = 0; e < 2 * flow->net.n_pieces; e++) {
    const FlowPiece *piece = flow->net.piece + e / 2;
    const PetscInt *key = flow->net.row[piece->row].key;
    const PetscReal s = piece->s[e % 2];
    FlowWater water;
    if (FlowWaterAt(before, n, key, s, piece->s[1 - e % 2], &water))
      flow->acting[piece->node[e % 2]] = water.psi;
    *same = (PetscBool)(*same && before[e].key[0] == key[0] && before[e].key[1] == key[1] &&
                        PetscAbsReal(before[e].s - s) < tolerance);
  }
  if (!*same) PetscCall(MixerReset(&flow->mixer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether this is the first step of the water in the stage; steady stages have only one. */
static PetscBool is_first(const Stage *stage)
{
  return (PetscBool)(stage->water_time <= stage->water_step);
}

/* Starts the search for the free surface from the node states of the last flow. After a restart these are
   the states with which that search had ended. */
static void begin_as_found(Flow *flow)
{
  // in this time step of the water, else in the last
  const PetscBool has_present = (PetscBool)(flow->n_present > 0);
  const PetscInt n = has_present ? flow->n_present : flow->n_past;
  const FlowWater *last = has_present ? flow->present : flow->past;
  for (PetscInt e = 0; e < 2 * flow->net.n_pieces; e++) {
    const FlowPiece *piece = flow->net.piece + e / 2;
    FlowWater water;
    if (FlowWaterAt(last, n, flow->net.row[piece->row].key, piece->s[e % 2], piece->s[1 - e % 2], &water))
      flow->net.node[piece->node[e % 2]].first = water.wetness;
  }
}

/* Rebuilds network, pushes and flow from net.row. n, before: acting pressures as for keep_acting; NULL:
   keep them while the network stays the same. measured: the rows are new. */
static PetscErrorCode renew(const TermView *v, PetscBool measured, PetscInt n, const FlowWater *before,
                            char message[MESSAGE_LENGTH])
{
  Flow *flow = v->memory;
  const PetscInt n_before = flow->net.n_nodes;
  PetscFunctionBeginUser;
  PetscCall(FlowNetworkBuild(v->scene, v->stage, flow->target, FlowReach(v->scene, v->m), &flow->net,
                             flow->unmet, message));
  PetscBool same = (PetscBool)(flow->net.n_nodes == n_before && flow->acting);
  flow->net.step = v->stage->water_step * flow->sums.within;
  if (before) PetscCall(keep_acting(flow, n, before, &same));
  if (measured || !same) PetscCall(set_reference(flow, (PetscBool)(same || before)));
  FlowStore(v->scene, v->stage, flow->past, flow->n_past, flow->reference, &flow->net);
  if (flow->n_present || !is_first(v->stage))
    begin_as_found(flow);
  else
    PetscCall(FlowGuess(&flow->net));
  PetscCall(FlowSolve(&flow->net, &flow->now, message));
  if (!same && !before) {
    PetscCall(PetscFree(flow->acting));
    PetscCall(PetscMalloc1(flow->net.n_nodes, &flow->acting));
    PetscCall(PetscArraycpy(flow->acting, flow->now.pressure, flow->net.n_nodes));
    PetscCall(MixerReset(&flow->mixer));
  }
  PetscCall(find_pushes(v->m, flow));
  flow->stale = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowFresh(const TermView *v)
{
  const Flow *flow = v->memory;
  const PetscInt n = flow->net.n_nodes;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (!flow->stale) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(renew(v, PETSC_FALSE, 0, NULL, message));
  PetscCheck(!message[0] && n == flow->net.n_nodes, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "the network of water is another than before: %s", message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Gathers the present contacts and solves the flow through them. keep: the acting pressures
   stay; otherwise the pressures of this flow act. */
static PetscErrorCode update_flow(const TermView *v, PetscBool keep, char message[MESSAGE_LENGTH])
{
  Flow *flow = v->memory;
  PetscInt n, n_acting = 0;
  FlowRow *rows;
  FlowWater *acting = NULL;
  PetscFunctionBeginUser;
  if (keep) {
    PetscCall(FlowFresh(v));
    PetscCall(list_acting(flow, &n_acting, &acting));
  }
  const PetscReal *u = v->state->u + 3 * v->m->rigid.n;
  PetscCall(FlowRowsGather(v->m, v->contacts, v->stage->joints, u, &n, &rows));
  PetscCall(FlowRowsFollow(v->m, v->stage->joints, u, flow->net.n_rows, flow->net.row, &n, &rows));
  PetscCall(PetscFree(flow->net.row));
  flow->net.row = rows, flow->net.n_rows = n;
  PetscCall(renew(v, PETSC_TRUE, n_acting, acting, message));
  PetscCall(PetscFree(acting));
  PetscCall(store_present(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees all water of the joints. */
static PetscErrorCode forget_water(Flow *flow)
{
  PetscFunctionBeginUser;
  PetscCall(FlowNetworkDestroy(&flow->net));
  PetscCall(FlowSolutionDestroy(&flow->now));
  PetscCall(MixerReset(&flow->mixer));
  PetscCall(PetscFree(flow->net.row));
  PetscCall(PetscFree(flow->acting));
  PetscCall(PetscFree(flow->reference));
  PetscCall(PetscFree(flow->past));
  PetscCall(PetscFree(flow->present));
  flow->net.n_rows = flow->n_push = flow->n_past = flow->n_present = 0;
  flow->sums.volume = 0.;
  flow->stale = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins a time step of the water from the present water; the second step of a pair begins from an
   extrapolation (FlowAhead). */
static PetscErrorCode begin_step(const TermView *v)
{
  const PetscReal rounding = 1e-5; // relative, of the step length
  Flow *flow = v->memory;
  const PetscReal second = FLOW_SECOND * flow->sums.first;
  const PetscBool pairs = (PetscBool)(flow->sums.first > 0. && !is_first(v->stage) &&
                                      PetscAbsReal(v->stage->water_step - second) <= rounding * second);
  PetscFunctionBeginUser;
  flow->sums.within = pairs ? 1. / FLOW_SECOND : 1.;
  if (pairs) FlowAhead(flow->past, flow->n_past, flow->present, flow->n_present);
  if (!pairs) flow->sums.first = 0.;
  PetscCall(PetscFree(flow->past));
  if (v->stage->water_step == 0.) {
    PetscCall(PetscFree(flow->present));
    flow->n_present = 0;
  } else if (is_first(v->stage)) {
    flow->sums.taken = flow->sums.entered = 0.;
    flow->sums.volume_0 = flow->sums.volume;
  }
  flow->past = flow->present, flow->n_past = flow->n_present;
  flow->present = NULL, flow->n_present = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves the flow for the apertures measured last. */
static PetscErrorCode solve_again(const TermView *v, char message[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  PetscCall(renew(v, PETSC_FALSE, 0, NULL, message));
  PetscCall(store_present(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether all joints were full at the start of the step and are full now. */
static PetscBool is_full(const Flow *flow)
{
  if (flow->n_past != flow->n_present) return PETSC_FALSE;
  for (PetscInt e = 0; e < flow->n_present; e++)
    if (flow->past[e].chi < 1. || flow->present[e].chi < 1.) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns the largest change of pressure in the time step of the water, over the largest pressure [-]. */
static PetscReal change_in_step(const Flow *flow)
{
  PetscReal most = 0., top = PETSC_SMALL;
  for (PetscInt e = 0; e < flow->n_present; e++) {
    FlowWater was = {.psi = 0., .chi = 0.};
    const FlowWater *is = flow->present + e;
    FlowWaterAt(flow->past, flow->n_past, is->key, is->s, (e % 2 ? is - 1 : is + 1)->s, &was);
    most = PetscMax(most, PetscAbsReal(is->psi - was.psi));
    top = PetscMax(top, PetscMax(is->psi, was.psi));
  }
  return most / top;
}

/* Returns the factor [-] for the length of the next step, such that it changes pressures by 1 / parts of
   the largest. */
static PetscReal growth(PetscReal change, PetscReal parts)
{
  return PetscClipInterval(1. / (parts * PetscMax(change, 1e-12)), 0.5, 1.5);
}

PetscErrorCode FlowStepDone(const TermView *v, StageResult *result, PetscReal *grow)
{
  enum { OF_PAIR = 20, SINGLE = 100 }; /* fractions of the largest pressure; both leave an error of 1 % */
  Flow *flow = v->memory;
  const PetscBool second = (PetscBool)(flow->sums.within < 1.);
  const PetscReal taken = flow->net.step * flow->now.taken, entered = flow->net.step * flow->now.inflow;
  PetscFunctionBeginUser;
  flow->step_change = change_in_step(flow);
  if (is_first(v->stage) && v->scene->flow.coupling == FLOW_ONE_WAY)
    flow->sums.volume_0 = flow->sums.volume - taken;
  flow->sums.taken += taken, flow->sums.entered += entered;
  if (second) { // in the second step of a pair, a part of the first flow continues
    flow->sums.taken += (FLOW_SECOND - 1.) * flow->sums.first_taken;
    flow->sums.entered += (FLOW_SECOND - 1.) * flow->sums.first_entered;
    *grow = growth(flow->step_change + flow->sums.first_change, OF_PAIR) / FLOW_SECOND;
    flow->sums.first = 0.;
  } else if (PetscIsNanReal(v->stage->time_step) && is_full(flow) && flow->step_change < 1. / OF_PAIR) {
    flow->sums.first = flow->net.step, flow->sums.first_taken = taken, flow->sums.first_entered = entered;
    flow->sums.first_change = flow->step_change;
    *grow = FLOW_SECOND;
  } else {
    flow->sums.first = 0.;
    *grow = growth(flow->step_change, SINGLE);
  }
  PetscCall(FlowJudgeVolume(flow, result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of a condition that meets no joint any more because blocks have moved. */
static PetscErrorCode warn_unmet(const TermView *v)
{
  const Flow *flow = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < flow->net.n_rows; i++)
    if (flow->net.row[i].shut) PetscFunctionReturn(PETSC_SUCCESS); // it may still fail
  if (flow->unmet[0])
    PetscCall(WarnAll(v->m->comm, "stage %s: %s%s", v->stage->name, v->scene->file, flow->unmet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowBegin(const TermView *v)
{
  Flow *flow = v->memory;
  char message[MESSAGE_LENGTH] = "";
  PetscInt carrier;
  PetscFunctionBeginUser;
  flow->rounds = 0, flow->sums.change = 0.;
  flow->sums.early = 0.1 * NEAR; // as if the first round changed pressures by a tenth
  if (!FlowActs(v->scene, v->stage, &carrier)) {
    PetscCall(forget_water(flow));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscBool keeps = (PetscBool)(StageInTime(v->stage) && flow->net.n_rows);
  flow->frozen = StageInTime(v->stage);
  if (flow->frozen)
    PetscCall(PetscPrintf(v->m->comm, "stage %-12s water in joints keeps the pressures %s\n", v->stage->name,
                          keeps ? "of the stage before" : "that it has at the start"));
  if (keeps) flow->stale = PETSC_TRUE; // the flow uses the levels of this stage, as after a restart
  if (keeps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(begin_step(v));
  if (v->scene->flow.coupling == FLOW_ONE_WAY && !is_first(v->stage))
    PetscCall(solve_again(v, message));
  else
    PetscCall(update_flow(v, PETSC_FALSE, message));
  PetscCall(FlowRefuse(v, v->stage, message));
  PetscCall(warn_unmet(v));
  PetscCall(PetscArraycpy(flow->acting, flow->now.pressure, flow->net.n_nodes));
  PetscCall(MixerReset(&flow->mixer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest difference [-] between acting pressures and the pressures of the flow, over the largest
   pressure of the flow. */
static PetscReal change_of(const Flow *flow)
{
  PetscReal most = 0., top = PETSC_SMALL;
  for (PetscInt i = 0; i < flow->net.n_nodes; i++) {
    most = PetscMax(most, PetscAbsReal(flow->now.pressure[i] - flow->acting[i]));
    top = PetscMax(top, flow->now.pressure[i]);
  }
  return most / top;
}

/* Returns the unbalanced ratio [-] below which openings are accurate enough for the next round, in
   proportion to the last change of pressure. Returns 0 if the round must wait for equilibrium: where
   changes do not shrink, the state is far from equilibrium, and failures on the way would stay. */
static PetscReal near_enough(const Flow *flow, PetscReal before, PetscReal tolerance)
{
  const PetscReal shrinks = 0.5;
  if (flow->sums.change <= tolerance || (flow->rounds > 1 && flow->sums.change > shrinks * before)) return 0.;
  for (PetscInt i = 0; i < flow->net.n_rows; i++)
    if (flow->net.row[i].shut) return 0.;
  return NEAR * flow->sums.change;
}

PetscErrorCode FlowSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again)
{
  Flow *flow = v->memory;
  const PetscReal tolerance = v->scene->flow.tolerance, before = flow->sums.change;
  char message[MESSAGE_LENGTH] = "";
  PetscInt carrier;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  if (when != AT_EQUILIBRIUM && !(result->ratio <= flow->sums.early)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!FlowActs(v->scene, v->stage, &carrier) || v->scene->flow.coupling == FLOW_ONE_WAY)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(update_flow(v, PETSC_TRUE, message));
  PetscCall(FlowRefuse(v, v->stage, message));
  flow->sums.change = change_of(flow);
  flow->rounds++;
  flow->sums.early = near_enough(flow, before, tolerance);
  if (flow->sums.change <= tolerance) PetscFunctionReturn(PETSC_SUCCESS);
  if (flow->rounds >= v->scene->flow.rounds) {
    result->verdict = VERDICT_UNDECIDED;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "water and openings do not agree: after %" PetscInt_FMT
                            " rounds pressures still change by %.3g of the largest, flow.tolerance %.3g; "
                            "raise flow.rounds",
                            flow->rounds, (double)flow->sums.change, (double)tolerance));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FlowNextRound(flow));
  *again = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

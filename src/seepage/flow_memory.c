/* flow_memory.c: stores and restores the state of water in joints: of the last stable trial or step, and
   in checkpoints. */
#include "seepage/flow.h"

/* Replaces a list by a copy of another, of `bytes` bytes. to: address of the list. */
static PetscErrorCode copy_list(size_t bytes, const void *from, void *to)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(*(void **)to));
  PetscCall(PetscMalloc(bytes, (void **)to));
  PetscCall(PetscMemcpy(*(void **)to, from, bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores water and scalars of the step before in a transient stage. */
static PetscErrorCode restore_water(Flow *flow)
{
  PetscFunctionBeginUser;
  flow->n_present = flow->n_present_stable;
  PetscCall(copy_list(flow->n_present * sizeof(FlowWater), flow->present_stable, &flow->present));
  flow->sums = flow->sums_stable;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode keep_stable(Flow *flow)
{
  PetscFunctionBeginUser;
  flow->n_stable = flow->net.n_rows, flow->n_acting_stable = flow->net.n_nodes,
  flow->rounds_stable = flow->rounds;
  PetscCall(copy_list(flow->net.n_rows * sizeof(FlowRow), flow->net.row, &flow->row_stable));
  PetscCall(copy_list(flow->net.n_nodes * sizeof(PetscReal), flow->acting, &flow->acting_stable));
  flow->n_present_stable = flow->n_present;
  PetscCall(copy_list(flow->n_present * sizeof(FlowWater), flow->present, &flow->present_stable));
  flow->sums_stable = flow->sums;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores rows and pressures; FlowFresh rebuilds the network from them. */
static PetscErrorCode restore(Flow *flow, PetscInt n_rows, const FlowRow *rows, PetscInt n,
                              const PetscReal *acting)
{
  PetscFunctionBeginUser;
  PetscCall(copy_list(n_rows * sizeof(FlowRow), rows, &flow->net.row));
  PetscCall(copy_list(n * sizeof(PetscReal), acting, &flow->acting));
  PetscCall(copy_list(n * sizeof(PetscReal), acting, &flow->reference));
  flow->net.n_rows = n_rows, flow->net.n_nodes = n;
  flow->stale = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowHistory(const TermView *v, TermHistory what)
{
  Flow *flow = v->memory;
  PetscInt carrier;
  PetscFunctionBeginUser;
  if (!FlowActs(v->scene, v->stage, &carrier)) PetscFunctionReturn(PETSC_SUCCESS);
  if (what == KEEP_STABLE) PetscCall(keep_stable(flow));
  if (what == BACK_TO_STABLE) {
    PetscCall(restore(flow, flow->n_stable, flow->row_stable, flow->n_acting_stable, flow->acting_stable));
    if (v->stage->kind == STAGE_TRANSIENT)
      PetscCall(restore_water(flow));
    else
      PetscCall(FlowFresh(v)); // with the levels of the trial
    flow->rounds = flow->rounds_stable, flow->sums.change = flow->sums_stable.change;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads rows. n was read before. */
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
  for (int pass = 0; pass < 2; pass++) { // pass 0 fills the lists; pass 1, when reading, copies out of them
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

/* Writes or reads n numbers. */
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

/* Writes or reads the water at ends of pieces. */
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
    ints[3 * i] = w->key[0], ints[3 * i + 1] = w->key[1], ints[3 * i + 2] = w->wetness;
    const PetscReal numbers[6] = {w->s, w->a, w->psi, w->chi, w->length, w->volume};
    PetscCall(PetscArraycpy(reals + 6 * i, numbers, 6));
  }
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_faces", name));
  PetscCall(ArchiveInts(a, label, 3 * n, ints));
  PetscCall(ArchiveReals(a, name, 6 * n, reals));
  for (PetscInt i = 0; i < n && a->reading; i++) {
    const PetscInt *in = ints + 3 * i;
    const PetscReal *re = reals + 6 * i;
    (*list)[i] = (FlowWater){{in[0], in[1]}, re[0], re[1], re[2],
                             re[3],          re[4], re[5], (FlowWetness)in[2]}; // in the order of the struct
  }
  PetscCall(PetscFree2(ints, reals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowArchive(Archive *a, const TermView *v)
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
  PetscCall(ArchiveReals(a, "flow_change_volumes", FLOW_SUMS, (PetscReal *)&flow->sums));
  PetscCall(archive_water(a, "flow_past", &flow->n_past, &flow->past));
  PetscCall(archive_water(a, "flow_present", &flow->n_present, &flow->present));
  PetscCall(archive_rows(a, "flow", counts[0], &flow->net.row));
  PetscCall(archive_list(a, "flow_acting", counts[1], &flow->acting));
  PetscCall(archive_list(a, "flow_reference", counts[1], &flow->reference));
  PetscCall(archive_mixer(a, &flow->mixer, counts[1], counts[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowArchiveStable(Archive *a, const TermView *v)
{
  Flow *flow = v->memory;
  PetscInt counts[3] = {flow->n_stable, flow->n_acting_stable, flow->rounds_stable};
  PetscFunctionBeginUser;
  if (!FlowEverActs(v->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveInts(a, "flow_stable_counts", 3, counts));
  for (int i = 0; i < 2 && a->reading; i++)
    counts[i] = (PetscInt)ArchiveWithin(a, "sizes of the flow", counts[i], 0, PETSC_MAX_INT / 64);
  flow->n_stable = counts[0], flow->n_acting_stable = counts[1], flow->rounds_stable = counts[2];
  PetscCall(ArchiveReals(a, "flow_stable_change", 1, &flow->sums_stable.change));
  PetscCall(archive_rows(a, "flow_stable", flow->n_stable, &flow->row_stable));
  PetscCall(archive_list(a, "flow_stable_acting", flow->n_acting_stable, &flow->acting_stable));
  PetscCall(archive_water(a, "flow_stable_present", &flow->n_present_stable, &flow->present_stable));
  PetscCall(ArchiveReals(a, "flow_stable_sums", FLOW_SUMS, (PetscReal *)&flow->sums_stable));
  PetscFunctionReturn(PETSC_SUCCESS);
}

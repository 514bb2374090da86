/* anchors_term.c: makes anchors a force term. */
#include "anchors/line.h"

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  Anchors *all = memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; all && i < all->n; i++) {
    Line *line = all->line + i;
    if (!line->here) continue;
    LineEvaluate(line, at->m, at->u);
    PetscCheck(!line->unsolved, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED,
               "anchor %s: no slips in the grout balance the bar", line->of->entry.name);
    if (all->in_time) LineCommit(line);
    if (line->now.phase != LINE_BROKEN) LineResist(line, 1., f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bounds the row sums of the stiffness. Along the line, the row sums of k (w e)(w e)' are at most 2 |w| k (1
   + sqrt(2))/2 for any direction e; across it, T/l replaces k. */
static PetscErrorCode bound(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  const PetscReal oblique = 0.5 * (1. + PetscSqrtReal(2.));
  const Anchors *all = memory;
  PetscFunctionBeginUser;
  (void)at, (void)anywhere;
  for (PetscInt i = 0; all && i < all->n; i++) {
    const Line *line = all->line + i;
    if (line->here && line->chain && (line->now.phase == LINE_LOCKED || line->now.phase == LINE_STRESSED))
      ChainBound(line->chain, line->per_slice, k);
    if (!line->here || line->chain || line->now.phase != LINE_LOCKED) continue;
    const PetscReal both = line->per_slice * (line->stiffness + PetscAbsReal(line->T) / line->span);
    for (PetscInt p = 0; p < line->n; p++)
      k[line->vertex[p]] += 2. * oblique * both * PetscAbsReal(line->weight[p]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode energy(const void *memory, const Instant *at, PetscReal *sum)
{
  const Anchors *all = memory;
  PetscFunctionBeginUser;
  (void)at;
  for (PetscInt i = 0; all && i < all->n; i++)
    if (all->line[i].mine) *sum += all->line[i].per_slice * LineStored(all->line + i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void lost(const void *memory, PetscReal *sum)
{
  const Anchors *all = memory;
  for (PetscInt i = 0; all && i < all->n; i++)
    if (all->line[i].mine) *sum += all->line[i].per_slice * all->line[i].now.lost;
}

/* Computes k e e' along the line, and T/l across it where it may rotate, at each pair of vertices. */
static void stiffness_of(const Line *line, const PetscReal e[2], PetscReal along, PetscReal across,
                         PetscReal *k)
{
  const PetscInt n = 2 * line->n;
  for (PetscInt p = 0; p < n; p++)
    for (PetscInt q = 0; q < n; q++) {
      const PetscReal ee = e[p % 2] * e[q % 2], one = p % 2 == q % 2 ? 1. : 0.;
      k[n * p + q] = line->per_slice * line->weight[p / 2] * line->weight[q / 2] *
                     (along * ee + across * (one - ee));
    }
}

static PetscErrorCode add_line(const Line *line, const Model *m, TangentKind kind, TermAdd add, void *context)
{
  const PetscBool turned = (PetscBool)(kind != TANGENT_ELASTIC && m->materials.strain == STRAIN_LARGE);
  const PetscReal e0[2] = {line->reference[0] / line->length, line->reference[1] / line->length};
  const PetscReal along = kind == TANGENT_ELASTIC ? line->stiffness : LineTangent(line),
                  across = turned ? line->T / line->span : 0.;
  PetscReal k[4 * LINE_VERTICES * LINE_VERTICES], force[2 * LINE_VERTICES];
  PetscFunctionBeginUser;
  stiffness_of(line, kind == TANGENT_ELASTIC ? e0 : line->e, along, across, k);
  for (PetscInt p = 0; p < 2 * line->n; p++)
    force[p] = line->per_slice * line->T * line->weight[p / 2] * line->e[p % 2];
  PetscCall(add(line->n, line->vertex, k, kind == TANGENT_TURNED && turned ? force : NULL, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work space for a window of a bonded bar. */
typedef struct {
  PetscInt *at, *vertex; /* (4 places,) rows of Chain.vertex; local vertices */
  PetscReal *f, *force;  /* (2 n_vertices,) forces of the bar; of the window */
} WindowRoom;

static PetscErrorCode add_window(const Line *line, PetscInt window, TangentKind kind, const WindowRoom *room,
                                 TermAdd add, void *context)
{
  Chain *c = line->chain;
  const PetscBool there = (PetscBool)(line->now.phase == LINE_LOCKED || line->now.phase == LINE_STRESSED),
                  carried = (PetscBool)(kind == TANGENT_TURNED && c->turns),
                  small = (PetscBool)(kind == TANGENT_ELASTIC || kind == TANGENT_SMALL);
  PetscInt n;
  PetscReal *k = NULL;
  PetscFunctionBeginUser;
  PetscCall(ChainWindow(c, window, &n, room->at));
  for (PetscInt i = 0; i < n; i++) room->vertex[i] = c->vertex[room->at[i]];
  if (kind != TANGENT_PATTERN) PetscCall(PetscCalloc1(4 * n * n, &k));
  if (k && (kind == TANGENT_ELASTIC || there))
    PetscCall(ChainTangent(c, window, small, kind != TANGENT_ELASTIC, line->per_slice, n, room->at, k));
  if (carried) {
    PetscCall(PetscArrayzero(room->f, 2 * c->n_vertices));
    ChainCarried(c, window, line->per_slice, room->f);
    for (PetscInt p = 0; p < 2 * n; p++) room->force[p] = room->f[2 * room->at[p / 2] + p % 2];
  }
  PetscCall(add(n, room->vertex, k, carried ? room->force : NULL, context));
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode add_chain(const Line *line, TangentKind kind, TermAdd add, void *context)
{
  const Chain *c = line->chain;
  const PetscInt places = PLACE_VERTICES * c->n + 10 * c->n_dowels;
  WindowRoom room;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(places, &room.at, places, &room.vertex, 2 * c->n_vertices, &room.f,
                         2 * c->n_vertices, &room.force));
  for (PetscInt window = 0; window < ChainWindows(c); window++)
    PetscCall(add_window(line, window, kind, &room, add, context));
  PetscCall(PetscFree4(room.at, room.vertex, room.f, room.force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  const Anchors *all = memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; all && i < all->n; i++) {
    const Line *line = all->line + i;
    if (kind == TANGENT_PATTERN ? !line->here : !line->mine) continue;
    if (line->chain)
      PetscCall(add_chain(line, kind, add, context));
    else if (kind == TANGENT_PATTERN)
      PetscCall(add(line->n, line->vertex, NULL, NULL, context));
    else
      PetscCall(add_line(line, at->m, kind, add, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode history(const TermView *v, TermHistory what)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; all && i < all->n; i++) {
    Line *line = all->line + i;
    if (what == COMMIT) line->now.most = PetscMax(line->now.most, LineLargest(line));
    if (what == COMMIT) LineKeep(line, CHAIN_NOW, CHAIN_COMMITTED);
    if (what == GO_BACK) LineKeep(line, CHAIN_COMMITTED, CHAIN_NOW);
    if (what == KEEP_STABLE) LineKeep(line, CHAIN_NOW, CHAIN_STABLE);
    if (what != BACK_TO_STABLE) continue;
    LineKeep(line, CHAIN_STABLE, CHAIN_COMMITTED);
    LineKeep(line, CHAIN_STABLE, CHAIN_NOW);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Anchors_term = {.name = "anchors",
                               .tangent_varies = PETSC_TRUE,
                               .reads = AnchorsReads,
                               .create = AnchorsCreate,
                               .destroy = AnchorsDestroy,
                               .forces = forces,
                               .bound = bound,
                               .energy = energy,
                               .dissipated = lost,
                               .tangent = tangent,
                               .begin = AnchorsBegin,
                               .settle = AnchorsSettle,
                               .before_summary = AnchorsBeforeSummary,
                               .history = history,
                               .archive = AnchorsArchive,
                               .archive_stable = AnchorsArchiveStable,
                               .table = AnchorsTable,
                               .summary = AnchorsSummary};

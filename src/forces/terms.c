/* terms.c: holds the table of force terms, and calls their functions row by row. */
#include "forces/forces.h"

/* Resisting forces at a vertex are summed phase by phase, within a phase in the order of the table. Row
   sums and stiffnesses are summed in reverse order. Another order changes bits. */
// clang-format off
static const TermKind *const Terms[] = {
    &Contacts_term,
    &Supports_term,
    &Quiet_term,
    &Free_field_term,
    &Loads_term,
    &Temperature_term,
    &Push_term,
    &Reservoir_term,
    &Wave_term,
    &Pressure_term,
    &Pseudo_static_term,
    &Added_mass_term,
    &Uplift_term,
    &Flow_term,
    &Dry_term,
    &Anchors_term,
    &Condensed_term,
    &Block_damping_term,
    &Laws_term,
    &Blocks_term,
};
// clang-format on
enum { TERMS = sizeof(Terms) / sizeof(Terms[0]) };

static TermView view_of(const TermView *view, int t)
{
  TermView of = *view;
  of.memory = view->state->terms[t];
  return of;
}

/* Returns the row of a term that alone has an answer, so that no row of the table needs a function for it. */
static int row_of(const TermKind *kind)
{
  int t = 0;
  while (Terms[t] != kind) t++;
  return t;
}

Push *PushOf(const State *state)
{
  return state->terms[row_of(&Push_term)];
}

/* Calls row->FUNCTION(...) of every row that has it; `of` is the view of the row. */
#define EACH(FUNCTION, ...)                                                                                  \
  for (int t = 0; t < TERMS; t++) {                                                                          \
    TermView of = view_of(view, t);                                                                          \
    if (Terms[t]->FUNCTION) PetscCall(Terms[t]->FUNCTION(__VA_ARGS__));                                      \
  }

/* Groups collected so far: the size of each, and all their vertices. */
typedef struct {
  PetscSegBuffer sizes, gids;
} Groups;

static PetscErrorCode add_group(PetscInt n, const PetscInt *gids, void *context)
{
  Groups *groups = context;
  PetscInt *to;
  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferGetInts(groups->sizes, 1, &to));
  *to = n;
  PetscCall(PetscSegBufferGetInts(groups->gids, n, &to));
  PetscCall(PetscArraycpy(to, gids, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsReads(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh, Couplings *c)
{
  Groups groups;
  SegmentCount n, n_gids;
  PetscInt counts[2], *sizes;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 64, &groups.sizes));
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 128, &groups.gids));
  for (int t = 0; t < TERMS && !rank; t++)
    if (Terms[t]->reads) PetscCall(Terms[t]->reads(scene, mesh, add_group, &groups));
  PetscCall(PetscSegBufferGetSize(groups.sizes, &n));
  PetscCall(PetscSegBufferGetSize(groups.gids, &n_gids));
  counts[0] = (PetscInt)n, counts[1] = (PetscInt)n_gids;
  PetscCallMPI(MPI_Bcast(counts, 2, MPIU_INT, 0, comm));
  c->n = counts[0];
  PetscCall(PetscCalloc2(c->n + 1, &c->start, counts[1], &c->gid));
  PetscCall(PetscSegBufferExtractInPlace(groups.sizes, &sizes));
  for (PetscInt i = 0; i < c->n && !rank; i++) c->start[i + 1] = c->start[i] + sizes[i];
  if (!rank) PetscCall(PetscSegBufferExtractTo(groups.gids, c->gid));
  PetscCallMPI(MPI_Bcast(c->start, c->n + 1, MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(c->gid, counts[1], MPIU_INT, 0, comm));
  PetscCall(PetscSegBufferDestroy(&groups.sizes));
  PetscCall(PetscSegBufferDestroy(&groups.gids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CouplingsDestroy(Couplings *c)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(c->start, c->gid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsCreate(const Scene *scene, const Model *m, Contacts *contacts, State *state)
{
  const TermView v = {.scene = scene, .m = m, .contacts = contacts, .state = state};
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(TERMS, &state->terms));
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->create) PetscCall(Terms[t]->create(&v, state->terms + t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsDestroy(const Scene *scene, State *state)
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TERMS && state->terms; t++)
    if (Terms[t]->destroy && state->terms[t]) PetscCall(Terms[t]->destroy(scene, state->terms + t));
  PetscCall(PetscFree(state->terms));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- each evaluation */

PetscErrorCode TermsForces(TermPhase phase, const State *state, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->forces && Terms[t]->phase == phase) PetscCall(Terms[t]->forces(state->terms[t], at, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermsAdvance(const Model *m, State *state)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->advance) Terms[t]->advance(state->terms[t], m, state);
}

void TermsAfterStep(const Model *m, const State *state, const PetscReal *v_before)
{
  AddedMassRecord(state->terms[row_of(&Added_mass_term)], m, state, v_before);
}

PetscErrorCode TermsInertia(const TermView *view, TermInertia add, void *context)
{
  PetscFunctionBeginUser;
  EACH(inertia, &of, add, context);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermsIncoming(const Model *m, const State *state, Incoming *in)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->incoming) Terms[t]->incoming(state->terms[t], m, state, in);
}

PetscErrorCode TermsBound(const State *state, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  PetscFunctionBeginUser;
  for (int t = TERMS; t-- > 0;)
    if (Terms[t]->bound) PetscCall(Terms[t]->bound(state->terms[t], at, anywhere, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsDrag(const State *state, const Instant *at, PetscBool anywhere, PetscReal *c)
{
  PetscFunctionBeginUser;
  for (int t = TERMS; t-- > 0;)
    if (Terms[t]->drag) PetscCall(Terms[t]->drag(state->terms[t], at, anywhere, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal TermsDamped(const State *state)
{
  return BlockDampingWork(state->terms[row_of(&Block_damping_term)]);
}

PetscErrorCode TermsEnergy(TermPhase phase, const State *state, const Instant *at, PetscReal *sum)
{
  PetscFunctionBeginUser;
  *sum = 0.;
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->energy && Terms[t]->phase == phase) PetscCall(Terms[t]->energy(state->terms[t], at, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal TermsDissipated(const State *state)
{
  PetscReal sum = 0.;
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->dissipated) Terms[t]->dissipated(state->terms[t], &sum);
  return sum;
}

PetscErrorCode TermsTangent(TermPhase phase, const State *state, const Instant *at, TangentKind kind,
                            TermAdd add, void *context)
{
  PetscFunctionBeginUser;
  for (int t = TERMS; t-- > 0;)
    if (Terms[t]->tangent && (Terms[t]->tangent_varies ? PHASE_JOINTS : Terms[t]->phase) == phase)
      PetscCall(Terms[t]->tangent(state->terms[t], at, kind, add, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- loads */

static int term_of(LoadKind kind)
{
  for (int t = 0; t < TERMS; t++)
    if (Terms[t]->loads & 1u << kind) return t;
  return -1;
}

PetscBool TermPresses(const Scene *scene, const Load *load)
{
  const int t = term_of(load->kind);
  const PetscBool acts = (PetscBool)(load->target[0] || load->kind == LOAD_TEMPERATURE);
  const PetscBool follows = (PetscBool)(t >= 0 && Terms[t]->presses && acts && scene->strain == STRAIN_LARGE);
  return (PetscBool)(follows || load->history[0]);
}

PetscErrorCode TermApplied(const TermView *view, PetscInt load, PetscReal *f)
{
  const int t = term_of(view->scene->loads[load].kind);
  PetscFunctionBeginUser;
  PetscCheck(t >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no force term has loads of kind %d",
             (int)view->scene->loads[load].kind);
  const TermView of = view_of(view, t);
  PetscCall(Terms[t]->applied(&of, load, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsApplyWithoutLoad(const TermView *view, PetscBool *any, PetscReal *f)
{
  const TermView of = view_of(view, row_of(&Anchors_term));
  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  PetscCall(AnchorsPull(&of, any, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

PetscErrorCode TermsBegin(const TermView *view)
{
  PetscFunctionBeginUser;
  EACH(begin, &of);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsSettle(const TermView *view, TermMoment when, StageResult *result, PetscBool *again,
                           PetscBool *commit)
{
  PetscFunctionBeginUser;
  *again = *commit = PETSC_FALSE;
  for (int t = 0; t < TERMS; t++) {
    const Verdict before = result->verdict;
    const TermView of = view_of(view, t);
    PetscBool one = PETSC_FALSE;
    if (!Terms[t]->settle) continue;
    PetscCall(Terms[t]->settle(&of, when, result, &one));
    *again = (PetscBool)(*again || one);
    *commit = (PetscBool)(*commit || (one && !(Terms[t] == &Flow_term && FlowIsTrial(&of))));
    if (result->verdict == before) continue;
    *again = PETSC_FALSE; // the row has set a verdict
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool TermsHaveTrial(const TermView *view)
{
  return FlowIsTrial(view);
}

PetscErrorCode TermsStepDone(const TermView *view, StageResult *result, PetscReal *grow)
{
  const TermView of = view_of(view, row_of(&Flow_term));
  PetscFunctionBeginUser;
  *grow = PETSC_INFINITY;
  PetscCall(FlowStepDone(&of, result, grow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsBeforeSummary(const TermView *view, PetscBool report)
{
  PetscFunctionBeginUser;
  EACH(before_summary, &of, report);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsHistory(const TermView *view, TermHistory what)
{
  PetscFunctionBeginUser;
  EACH(history, &of, what);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsPrestressed(const TermView *view, PetscReal *sum)
{
  const TermView of = view_of(view, row_of(&Anchors_term));
  PetscFunctionBeginUser;
  *sum = 0.;
  PetscCall(AnchorsPrestressed(&of, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- archive and results */

PetscErrorCode TermsOfBlocks(const TermView *view, const Elements *list, BlockAnswers *answers)
{
  const TermView of = view_of(view, row_of(&Temperature_term));
  PetscFunctionBeginUser;
  PetscCall(TemperatureCorrects(&of, list, answers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsArchive(Archive *a, const TermView *view)
{
  PetscFunctionBeginUser;
  EACH(archive, a, &of);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsDigest(const TermView *view, uint64_t *digest)
{
  Archive a;
  PetscFunctionBeginUser;
  PetscCall(ArchiveCreate(view->m->comm, &a));
  a.digest = PETSC_TRUE;
  for (int t = 0; t < TERMS; t++) {
    TermView of = view_of(view, t);
    if (!Terms[t]->archive || Terms[t] == &Contacts_term) continue;
    PetscCall(PetscStrncpy(a.part, Terms[t]->name, sizeof(a.part)));
    PetscCall(Terms[t]->archive(&a, &of));
  }
  *digest = ArchiveDigest(&a);
  PetscCallMPI(MPI_Bcast(digest, 1, MPI_UINT64_T, 0, view->m->comm));
  PetscCall(ArchiveDestroy(&a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsArchiveStable(Archive *a, const TermView *view)
{
  PetscFunctionBeginUser;
  EACH(archive_stable, a, &of);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsRecord(const TermView *view, AnchorRecord *all)
{
  const TermView of = view_of(view, row_of(&Anchors_term));
  PetscFunctionBeginUser;
  *all = (AnchorRecord){.n_rows = 0};
  PetscCall(AnchorsRecord(&of, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsTables(const TermView *view, TermTable *other, PetscInt *n, TermTable **tables)
{
  PetscFunctionBeginUser;
  *n = 0;
  PetscCall(PetscCalloc1(TERMS * TERM_TABLES + 1, tables));
  for (int t = 0; t < TERMS; t++) {
    TermView of = view_of(view, t);
    for (PetscInt which = 0; Terms[t]->table && which < TERM_TABLES; which++) {
      TermTable *table = *tables + *n;
      PetscCall(Terms[t]->table(&of, which, table));
      if (table->n_rows) ++*n;
    }
  }
  if (other && other->n_rows) (*tables)[(*n)++] = *other, *other = (TermTable){.name = NULL};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TermsTablesDestroy(PetscInt *n, TermTable **tables)
{
  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < *n; t++)
    for (PetscInt c = 0; c < (*tables)[t].n_columns; c++)
      PetscCall(PetscFree((*tables)[t].columns[c].values));
  PetscCall(PetscFree(*tables));
  *n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermsSummary(Json *json, const TermView *view)
{
  for (int t = 0; t < TERMS; t++) {
    TermView of = view_of(view, t);
    if (Terms[t]->summary) Terms[t]->summary(json, &of);
  }
}

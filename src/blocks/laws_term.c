/* laws_term.c: makes blocks with a material law a force term: their forces, tangent and history. Masses,
   row sums, stress and stored energy are computed together with the other blocks (element.c). */
#include "blocks/law_point.h"

typedef struct {
  const Model *m;       /* its lists have the histories */
  LawReported *reports; /* work space for the longest list */
} Laws;

/* Returns the next list after e of blocks with a history, the first for e = NULL; NULL: none. */
static const Elements *next_list(const Model *m, const Elements *e)
{
  e = e ? e + 1 : m->mesh.elements + ELASTIC_LISTS;
  while (e < m->mesh.elements + DEFORMABLE_LISTS && !e->history) e++;
  return e < m->mesh.elements + DEFORMABLE_LISTS ? e : NULL;
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  PetscInt most = 0;
  Laws *laws;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&laws));
  laws->m = v->m;
  for (const Elements *e = next_list(v->m, NULL); e; e = next_list(v->m, e)) most = PetscMax(most, e->n);
  PetscCall(PetscMalloc1(most, &laws->reports));
  *memory = laws;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  PetscFunctionBeginUser;
  (void)scene;
  if (*memory) PetscCall(PetscFree(((Laws *)*memory)->reports));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)memory;
  for (const Elements *e = next_list(at->m, NULL); e; e = next_list(at->m, e))
    LawForces(at->m, e, at->results, at->u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void lost(const void *memory, PetscReal *sum)
{
  const Laws *laws = memory;
  for (const Elements *e = next_list(laws->m, NULL); e; e = next_list(laws->m, e)) {
    LawReport(laws->m, e, laws->m->mesh.X, laws->reports);
    for (PetscInt i = 0; i < e->n; i++)
      if (e->owned[i]) *sum += laws->reports[i].lost;
  }
}

/* ---- the tangent */

static PetscErrorCode add_list(const Instant *at, const Elements *e, TangentKind kind, TermAdd add,
                               void *context)
{
  const PetscBool elastic = (PetscBool)(kind == TANGENT_ELASTIC || kind == TANGENT_SMALL);
  PetscReal k[4][64];
  PetscInt vertices[4];
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < e->n; i++) {
    if (kind != TANGENT_PATTERN && i % 4 == 0) {
      if (elastic)
        ElementMatrices(at->m, e, e->n_nodes, i, NULL, k);
      else
        LawMatrices(at->m, e, i, at->u, k);
    }
    if (kind != TANGENT_PATTERN && !e->owned[i]) continue; // another rank adds it
    for (int v = 0; v < e->n_nodes; v++) vertices[v] = VertexOf(e, i, v);
    PetscCall(add(e->n_nodes, vertices, kind == TANGENT_PATTERN ? NULL : k[i % 4], NULL, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  PetscFunctionBeginUser;
  (void)memory;
  for (const Elements *e = next_list(at->m, NULL); e; e = next_list(at->m, e))
    PetscCall(add_list(at, e, kind, add, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the history */

static PetscErrorCode begin(const TermView *v)
{
  PetscFunctionBeginUser;
  for (const Elements *e = next_list(v->m, NULL); e; e = next_list(v->m, e))
    e->history->in_time = StageInTime(v->stage);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode history(const TermView *v, TermHistory what)
{
  PetscFunctionBeginUser;
  for (const Elements *e = next_list(v->m, NULL); e; e = next_list(v->m, e)) {
    LawHistory *h = e->history;
    switch (what) {
    case COMMIT:
      PetscCall(PetscArraycpy(h->committed, h->now, h->n));
      break;
    case GO_BACK:
      PetscCall(PetscArraycpy(h->now, h->committed, h->n));
      break;
    case KEEP_STABLE:
      PetscCall(PetscArraycpy(h->stable, h->now, h->n));
      break;
    case BACK_TO_STABLE:
      PetscCall(PetscArraycpy(h->now, h->stable, h->n));
      PetscCall(PetscArraycpy(h->committed, h->stable, h->n));
      break;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- archive */

/* Returns the place of number i of a point of block b in a history. */
static PetscInt place_of(const LawHistory *h, PetscInt b, PetscInt number)
{
  return (b / 4 * h->points * h->width + number) * 4 + b % 4;
}

/* Writes or reads one history of a list: a row of numbers per block. Ranks that do not own a block read it
   too. */
static PetscErrorCode archive_numbers(Archive *a, const Model *m, const Elements *e, const char *name,
                                      PetscReal *numbers)
{
  const PetscInt width = e->history->points * e->history->width;
  PetscInt n = 0, *gid;
  PetscReal *rows;
  char full[NAME_LENGTH];
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(full, sizeof(full), "%s_%d_%s", LawKinds[e->law].name, e->n_nodes, name));
  PetscCall(PetscMalloc2(e->n, &gid, e->n * width, &rows));
  for (PetscInt b = 0; b < e->n; b++) {
    if (!a->reading && !e->owned[b]) continue;
    for (PetscInt i = 0; i < width; i++) rows[n * width + i] = numbers[place_of(e->history, b, i)];
    gid[n++] = e->gid[b];
  }
  PetscCall(ArchiveBlocks(a, m, full, n, gid, width, rows));
  for (PetscInt b = 0; b < e->n && a->reading; b++)
    for (PetscInt i = 0; i < width; i++) numbers[place_of(e->history, b, i)] = rows[b * width + i];
  PetscCall(PetscFree2(gid, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  PetscFunctionBeginUser;
  for (const Elements *e = next_list(v->m, NULL); e; e = next_list(v->m, e)) {
    PetscInt in_time = e->history->in_time;
    char name[NAME_LENGTH];
    PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%d_in_time", LawKinds[e->law].name, e->n_nodes));
    PetscCall(ArchiveInts(a, name, 1, &in_time));
    e->history->in_time = (PetscBool)in_time;
    PetscCall(archive_numbers(a, v->m, e, "held", e->history->committed));
    PetscCall(archive_numbers(a, v->m, e, "now", e->history->now));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_stable(Archive *a, const TermView *v)
{
  PetscFunctionBeginUser;
  for (const Elements *e = next_list(v->m, NULL); e; e = next_list(v->m, e))
    PetscCall(archive_numbers(a, v->m, e, "stable", e->history->stable));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Laws_term = {.name = "laws",
                            .create = create,
                            .destroy = destroy,
                            .forces = forces,
                            .dissipated = lost,
                            .tangent = tangent,
                            .tangent_varies = PETSC_TRUE,
                            .begin = begin,
                            .history = history,
                            .archive = archive,
                            .archive_stable = archive_stable};

/* envelope.c: samples the envelopes of a dynamic stage: largest s1, least s2, least safety factor of each
   block with their times; largest and least sigma, largest opening and slip of each end of a contact. They
   are sampled every envelope_every steps, each rank for its own blocks and contacts. Other scenes need no
   memory for them.

   Contacts come and go, and change ranks; so their rows go by the keys of contacts. Rows of one contact on
   several ranks are combined to their extremes. */
#include "result/result.h"

static const EnvelopeEnd Nothing = {PETSC_NINFINITY, PETSC_INFINITY, PETSC_NINFINITY, 0.};
static const EnvelopeBlock NoStress = {NAN, NAN, NAN, NAN, NAN, NAN, NAN};
enum {
  BLOCK_REALS = sizeof(EnvelopeBlock) / sizeof(PetscReal),
  ROW = sizeof(EnvelopeRow) / sizeof(PetscReal)
};

/* ---- life */

/* Lists the owned blocks of all element lists in their order, and counts the deformable ones. */
static PetscErrorCode find_blocks(const Model *m, Envelope *e)
{
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (int l = 0; l < ELEMENT_LISTS; l++) n += m->mesh.elements[l].n;
  PetscCall(PetscMalloc2(n, &e->gid, n, &e->file));
  PetscCall(PetscMalloc1(n, &e->block));
  for (PetscInt i = 0; i < n; i++) e->block[i] = NoStress;
  e->n_blocks = 0;
  for (int l = 0; l < ELEMENT_LISTS; l++)
    for (PetscInt i = 0; i < m->mesh.elements[l].n; i++) {
      if (!m->mesh.elements[l].owned[i]) continue;
      e->gid[e->n_blocks] = m->mesh.elements[l].gid[i];
      e->file[e->n_blocks++] = m->mesh.elements[l].file[i];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvelopeCreate(const Problem *p, Envelope *e)
{
  PetscFunctionBeginUser;
  PetscCall(EnvelopeDestroy(e));
  e->every = p->stage->envelope_every;
  if (e->every) PetscCall(find_blocks(p->m, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvelopeDestroy(Envelope *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(e->gid, e->file));
  PetscCall(PetscFree(e->block));
  PetscCall(PetscFree(e->row));
  PetscCall(PetscFree(e->at));
  *e = (Envelope){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvelopeContactsChanged(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(p->found->envelope.at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of contacts */

static int by_key(const void *a, const void *b)
{
  const EnvelopeRow *p = a, *q = b;
  for (int i = 0; i < 2; i++)
    if (p->key[i] != q->key[i]) return p->key[i] < q->key[i] ? -1 : 1;
  return 0;
}

static void widen(EnvelopeEnd *end, const EnvelopeEnd *other)
{
  end->sigma_max = PetscMax(end->sigma_max, other->sigma_max);
  end->sigma_min = PetscMin(end->sigma_min, other->sigma_min);
  end->opening = PetscMax(end->opening, other->opening);
  end->slip = PetscMax(end->slip, other->slip);
}

/* Sorts rows and combines rows of one contact; returns their number. */
static PetscInt unite(PetscInt n, EnvelopeRow *row)
{
  PetscInt kept = 0;
  if (n) qsort(row, (size_t)n, sizeof *row, by_key);
  for (PetscInt i = 0; i < n; i++) {
    if (!kept || by_key(row + kept - 1, row + i))
      row[kept++] = row[i];
    else
      for (int k = 0; k < 2; k++) widen(row[kept - 1].end + k, row[i].end + k);
  }
  return kept;
}

/* Finds the row of each contact of this rank, and makes rows for new contacts. */
static PetscErrorCode find_rows(const Contacts *c, Envelope *e)
{
  EnvelopeRow *more;
  PetscInt n = e->n_rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n + c->n + 1, &more));
  PetscCall(PetscArraycpy(more, e->row, n));
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0 && c->owned[i])
      more[n++] = (EnvelopeRow){{(PetscReal)c->key[2 * i], (PetscReal)c->key[2 * i + 1]}, {Nothing, Nothing}};
  PetscCall(PetscFree(e->row));
  e->row = more, e->n_rows = unite(n, more);
  PetscCall(PetscMalloc1(c->n_padded, &e->at));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const EnvelopeRow wanted = {.key = {(PetscReal)c->key[2 * i], (PetscReal)c->key[2 * i + 1]}};
    e->at[i] = -1;
    if (c->key[2 * i] < 0 || !c->owned[i]) continue;
    const EnvelopeRow *found = bsearch(&wanted, e->row, (size_t)e->n_rows, sizeof *more, by_key);
    e->at[i] = (PetscInt)(found - e->row);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a sample */

static void take_contacts(const Contacts *c, Envelope *e)
{
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && e->at[i] >= 0; k++) {
      const PetscInt at = SUB(i, c->klass[i] == VERTEX_FACE ? 0 : k);
      widen(e->row[e->at[i]].end + k,
            &(EnvelopeEnd){c->sigma[at], c->sigma[at], c->u_n[at], PetscAbsReal(c->slip[at])});
    }
}

/* Keeps a value and its time if it exceeds the kept one; NaN never does. */
static void take(PetscReal value, PetscReal sign, PetscReal time, PetscReal *kept, PetscReal *kept_time)
{
  if (!PetscIsNanReal(value) && !(sign * value <= sign * *kept)) *kept = value, *kept_time = time;
}

static void take_block(const Material *material, const PetscReal stress[3], PetscReal time,
                       EnvelopeBlock *block)
{
  const PetscReal before = block->factor;
  PetscReal principal[2], angle, factor;
  PrincipalStress(stress, principal, &angle);
  take(principal[0], 1., time, &block->s1, &block->s1_time);
  take(principal[1], -1., time, &block->s2, &block->s2_time);
  if (!MaterialHasStrengths(material)) return;
  const SafetyMode mode = SafetyFactor(material, principal[0], principal[1], &factor);
  take(factor, -1., time, &block->factor, &block->factor_time);
  if (factor < before || PetscIsNanReal(before)) block->mode = mode;
}

/* Finds the present displacements of all vertices of this rank, also inside condensed bodies, as a vertex
   array. */
static PetscErrorCode displacements_now(const Problem *p, PetscReal *u)
{
  const Model *m = p->m;
  const PetscInt at = 3 * m->rigid.n;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(u, p->state->u + at, 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  PetscCall(CondensedInner(m, p->state->f_ext + at, u));
  CondensedAddModes(m, p->state->modes[MODE_PLACE], u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Samples blocks in the order of find_blocks. Rigid blocks have no stress. */
static PetscErrorCode take_blocks(const Problem *p, Envelope *e)
{
  const Model *m = p->m;
  const TermView view = {.m = m, .state = p->state};
  PetscInt n = 0;
  PetscReal *u;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &u));
  PetscCall(displacements_now(p, u));
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++) {
    PetscReal *stress = NULL;
    if (!ListIsRigid(m, list)) {
      PetscCall(PetscMalloc1(3 * list->n_padded, &stress));
      PetscCall(ElementStress(m, list, list->n_nodes, u, stress));
      PetscCall(TermsOfBlocks(&view, list, &(BlockAnswers){.centre = stress}));
    }
    for (PetscInt i = 0; i < list->n; i++) {
      EnvelopeBlock *block = e->block + n;
      if (!list->owned[i]) continue;
      if (stress) take_block(p->scene->materials + list->group[i], stress + 3 * i, p->state->time, block);
      n++;
    }
    PetscCall(PetscFree(stress));
  }
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvelopeTake(const Problem *p)
{
  Envelope *e = &p->found->envelope;
  PetscFunctionBeginUser;
  if (!e->at) PetscCall(find_rows(p->contacts, e));
  take_contacts(p->contacts, e);
  PetscCall(take_blocks(p, e));
  e->samples++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- memory */

static PetscErrorCode archive_rows(Archive *a, Envelope *e)
{
  char name[2 * NAME_LENGTH];
  PetscInt n = 0;
  EnvelopeRow *rows = NULL;
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s/envelope_contacts", a->part));
  if (!a->reading) {
    PetscCall(GatherBytes(a->comm, e->n_rows, sizeof *rows, e->row, &n, (void **)&rows));
    if (!a->rank) n = unite(n, rows);
    if (!a->rank) PetscCall(ArchiveAdd(a, name, ARCHIVE_REAL, (size_t)n, ROW, rows));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const ArchiveEntry *entry = a->rank ? NULL : ArchiveFind(a, name);
  const PetscBool fits = (PetscBool)(entry && entry->kind == ARCHIVE_REAL && entry->columns == ROW);
  if (!a->rank && !fits && !a->message[0]) snprintf(a->message, MESSAGE_LENGTH, "%s is missing", name);
  PetscCall(PetscFree(e->row));
  PetscCall(PetscFree(e->at));
  PetscCall(GatherToAll(a->comm, fits ? (PetscInt)entry->rows : 0, sizeof *rows, fits ? entry->data : NULL,
                        &e->n_rows, (void **)&e->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvelopeArchive(Archive *a, const Problem *p)
{
  Envelope *e = &p->found->envelope;
  PetscFunctionBeginUser;
  if (!e->every) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveCounts(a, "envelope_samples", 1, &e->samples));
  PetscCall(
      ArchiveBlocks(a, p->m, "envelope_blocks", e->n_blocks, e->gid, BLOCK_REALS, (PetscReal *)e->block));
  PetscCall(archive_rows(a, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- to rank 0 */

PetscErrorCode EnvelopeGather(const Problem *p, StageFields *fields)
{
  const Contacts *c = p->contacts;
  Envelope *e = &p->found->envelope;
  PetscInt n = 0;
  EnvelopeEnd(*rows)[2], (*all)[2];
  PetscFunctionBeginUser;
  if (!e->samples) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GatherPlaced(p->m->comm, e->n_blocks, e->file, sizeof(*e->block), e->block,
                         p->m->mesh.n_blocks_global, &fields->envelope_block));
  if (!e->at) PetscCall(find_rows(c, e));
  PetscCall(PetscMalloc((size_t)(c->n + 1) * sizeof *rows, &rows));
  for (int kind = 0; kind < STRESS_MODELS; kind++) // in the order of GatherContacts
    for (PetscInt i = c->model_start[kind]; i < c->model_start[kind + 1]; i++)
      if (e->at[i] >= 0) PetscCall(PetscMemcpy(rows[n++], e->row[e->at[i]].end, sizeof *rows));
  PetscCall(GatherAndFree(p->m->comm, n, sizeof *rows, rows, &n, (void **)&all));
  if (!p->m->rank) PetscCall(PetscMalloc1(n + 1, &fields->envelope_contact));
  for (PetscInt i = 0; i < fields->n_contacts && !p->m->rank; i++)
    PetscCall(PetscMemcpy(fields->envelope_contact + i, all[fields->contact[i].gathered], sizeof *all));
  PetscCall(PetscFree(all));
  fields->envelope_every = e->every, fields->envelope_samples = e->samples;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* archive.c: stores named arrays on rank 0, gathered from all ranks and scattered to them; see archive.h. */
#include "archive/archive.h"

PetscErrorCode ArchiveCreate(MPI_Comm comm, Archive *a)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(a, sizeof(*a)));
  a->comm = comm;
  PetscCallMPI(MPI_Comm_rank(comm, &a->rank));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveDestroy(Archive *a)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < a->n; i++) PetscCall(PetscFree(a->entries[i].data));
  PetscCall(PetscFree(a->entries));
  a->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

ArchiveEntry *ArchiveFind(const Archive *a, const char *name)
{
  for (PetscInt i = 0; i < a->n; i++)
    if (!strcmp(a->entries[i].name, name)) return a->entries + i;
  return NULL;
}

PetscErrorCode ArchiveAdd(Archive *a, const char *name, ArchiveKind kind, size_t rows, size_t columns,
                          void *data)
{
  ArchiveEntry *e;
  PetscFunctionBeginUser;
  PetscCheck(!ArchiveFind(a, name), PETSC_COMM_SELF, PETSC_ERR_PLIB, "archive: %s twice", name);
  if (a->n % 16 == 0) PetscCall(PetscRealloc((size_t)(a->n + 16) * sizeof(ArchiveEntry), &a->entries));
  e = a->entries + a->n++;
  PetscCall(PetscSNPrintf(e->name, sizeof(e->name), "%s", name));
  e->kind = kind, e->rows = rows, e->columns = columns, e->data = data;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveHasPart(const Archive *a, const char *part, PetscBool *has)
{
  const size_t n = strlen(part);
  PetscFunctionBeginUser;
  *has = PETSC_FALSE;
  for (PetscInt i = 0; i < a->n; i++)
    if (!strncmp(a->entries[i].name, part, n) && a->entries[i].name[n] == '/') *has = PETSC_TRUE;
  PetscCallMPI(MPI_Bcast(has, 1, MPI_PETSC_BOOL, 0, a->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rank 0: one entry, written or read */

static size_t size_of(ArchiveKind kind)
{
  return kind == ARCHIVE_TEXT ? 1 : 8;
}

static void full_name(const Archive *a, const char *name, char full[2 * NAME_LENGTH])
{
  snprintf(full, 2 * NAME_LENGTH, "%s%s%s", a->part, a->part[0] ? "/" : "", name);
}

/* Returns the entry of a name if it has the kind and size that the reader expects (rows -1: any).
   Otherwise returns NULL and sets a message. */
static const ArchiveEntry *wanted(Archive *a, const char *name, ArchiveKind kind, PetscInt rows,
                                  PetscInt columns)
{
  char full[2 * NAME_LENGTH];
  full_name(a, name, full);
  const ArchiveEntry *e = ArchiveFind(a, full);
  if (e && e->kind == kind && (rows < 0 || e->rows == (size_t)rows) && e->columns == (size_t)columns)
    return e;
  if (!a->message[0])
    snprintf(a->message, MESSAGE_LENGTH, "%s is %s", full, e ? "of another size" : "missing");
  return NULL;
}

PetscInt64 ArchiveWithin(Archive *a, const char *what, PetscInt64 x, PetscInt64 low, PetscInt64 high)
{
  char full[2 * NAME_LENGTH];
  if (x >= low && x <= high) return x;
  full_name(a, what, full);
  if (!a->rank && !a->message[0])
    snprintf(a->message, MESSAGE_LENGTH, "%s: %lld is not from %lld to %lld", full, (long long)x,
             (long long)low, (long long)high);
  return low;
}

/* Adds an entry with a copy of data. */
static PetscErrorCode put(Archive *a, const char *name, ArchiveKind kind, size_t rows, size_t columns,
                          const void *data)
{
  const size_t bytes = rows * columns * size_of(kind);
  char full[2 * NAME_LENGTH];
  void *copy;
  PetscFunctionBeginUser;
  full_name(a, name, full);
  PetscCall(PetscMalloc(bytes + 1, &copy));
  PetscCall(PetscMemcpy(copy, data, bytes));
  PetscCall(ArchiveAdd(a, full, kind, rows, columns, copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

uint64_t ArchiveDigest(const Archive *a)
{
  uint64_t sum = 0, bits;
  for (PetscInt i = 0; i < a->n; i++) {
    const ArchiveEntry *e = a->entries + i;
    uint64_t h = HashBytes(0, e->name, strlen(e->name));
    PetscBool any = PETSC_FALSE;
    for (size_t k = 0; k < e->rows * e->columns && e->kind != ARCHIVE_TEXT; k++) {
      memcpy(&bits, (const char *)e->data + 8 * k, sizeof(bits));
      if (e->kind == ARCHIVE_REAL && ((const PetscReal *)e->data)[k] == 0.) bits = 0; // -0 and +0 are equal
      any = (PetscBool)(any || bits);
      h = HashWord(h ^ bits);
    }
    if (any) sum += h;
  }
  return sum;
}

/* ---- values that are the same on all ranks */

/* Writes or reads n values of one kind: rank 0 writes them, or reads them for all. */
static PetscErrorCode common(Archive *a, const char *name, ArchiveKind kind, MPI_Datatype type, PetscInt n,
                             void *x)
{
  PetscFunctionBeginUser;
  if (!a->reading) {
    if (!a->rank) PetscCall(put(a, name, kind, (size_t)n, 1, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const ArchiveEntry *e = a->rank ? NULL : wanted(a, name, kind, n, 1);
  if (e) PetscCall(PetscMemcpy(x, e->data, (size_t)n * size_of(kind)));
  PetscCallMPI(MPI_Bcast(x, (PetscMPIInt)n, type, 0, a->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveReals(Archive *a, const char *name, PetscInt n, PetscReal *x)
{
  return common(a, name, ARCHIVE_REAL, MPIU_REAL, n, x);
}

PetscErrorCode ArchiveCounts(Archive *a, const char *name, PetscInt n, PetscInt64 *x)
{
  return common(a, name, ARCHIVE_COUNT, MPIU_INT64, n, x);
}

PetscErrorCode ArchiveInts(Archive *a, const char *name, PetscInt n, PetscInt *x)
{
  PetscInt64 *wide;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &wide));
  for (PetscInt i = 0; i < n; i++) wide[i] = x[i];
  PetscCall(ArchiveCounts(a, name, n, wide));
  for (PetscInt i = 0; i < n; i++) x[i] = (PetscInt)wide[i];
  PetscCall(PetscFree(wide));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveRealsAt(Archive *a, const char *name, size_t n, PetscReal *const members[])
{
  PetscReal *x;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &x));
  for (size_t i = 0; i < n; i++) x[i] = *members[i];
  PetscCall(ArchiveReals(a, name, (PetscInt)n, x));
  for (size_t i = 0; i < n; i++) *members[i] = x[i];
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveIntsAt(Archive *a, const char *name, size_t n, const IntMember *members)
{
  PetscInt64 *wide;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(n, &wide));
  for (size_t i = 0; i < n; i++) {
    const IntMember *m = members + i;
    if (m->size == sizeof(PetscInt64))
      wide[i] = *(const PetscInt64 *)m->at;
    else if (m->size == sizeof(int))
      wide[i] = *(const int *)m->at;
    else
      wide[i] = *(const bool *)m->at;
  }
  PetscCall(ArchiveCounts(a, name, (PetscInt)n, wide));
  for (size_t i = 0; i < n; i++) {
    const IntMember *m = members + i;
    if (m->size == sizeof(PetscInt64))
      *(PetscInt64 *)m->at = wide[i];
    else if (m->size == sizeof(int))
      *(int *)m->at = (int)ArchiveWithin(a, name, wide[i], INT_MIN, INT_MAX);
    else
      *(bool *)m->at = wide[i];
  }
  PetscCall(PetscFree(wide));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveTally(Archive *a, const char *name, PetscInt n, PetscInt *x)
{
  PetscFunctionBeginUser;
  if (!a->digest) PetscCall(ArchiveInts(a, name, n, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveSums(Archive *a, const char *name, PetscInt n, PetscReal *x)
{
  PetscReal *sum;
  PetscFunctionBeginUser;
  if (a->digest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &sum));
  if (!a->reading) PetscCallMPI(MPI_Reduce(x, sum, (PetscMPIInt)n, MPIU_REAL, MPI_SUM, 0, a->comm));
  PetscCall(ArchiveReals(a, name, n, sum));
  for (PetscInt i = 0; i < n && a->reading; i++) x[i] = a->rank ? 0. : sum[i];
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Returns the partial sums of all ranks, and their counts; NULL: none that fit. */
static const PetscReal *summands_of(const Archive *a, const char *name, PetscMPIInt size,
                                    const PetscMPIInt *counts)
{
  char full[2 * NAME_LENGTH], label[NAME_LENGTH];
  snprintf(label, sizeof(label), "%.32s_n", name);
  full_name(a, label, full);
  const ArchiveEntry *n = ArchiveFind(a, full);
  full_name(a, name, full);
  const ArchiveEntry *e = ArchiveFind(a, full);
  size_t total = 0;
  if (!n || !e || n->rows != (size_t)size) return NULL;
  for (PetscMPIInt r = 0; r < size; r++) {
    if (((const PetscInt64 *)n->data)[r] != counts[r]) return NULL;
    total += (size_t)counts[r];
  }
  return e->kind == ARCHIVE_REAL && e->rows == total ? e->data : NULL;
}

PetscErrorCode ArchiveSummands(Archive *a, const char *name, PetscInt n, PetscReal *x, PetscBool *mine)
{
  char label[NAME_LENGTH];
  PetscMPIInt size, count, *counts, *starts;
  PetscInt total;
  PetscReal *all = NULL;
  PetscInt64 *wide;
  PetscFunctionBeginUser;
  if (a->digest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(a->comm, &size));
  PetscCall(PetscMPIIntCast(n, &count));
  PetscCall(PetscMalloc3(size, &counts, size, &starts, size, &wide));
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts, 1, MPI_INT, a->comm));
  starts[0] = 0;
  for (PetscMPIInt r = 1; r < size; r++) starts[r] = starts[r - 1] + counts[r - 1];
  for (PetscMPIInt r = 0; r < size; r++) wide[r] = counts[r];
  if (!a->reading) {
    snprintf(label, sizeof(label), "%.32s_n", name);
    PetscCall(ArchiveCounts(a, label, size, wide));
    PetscCall(GatherBytes(a->comm, n, sizeof(*x), x, &total, (void **)&all));
    if (!a->rank) PetscCall(put(a, name, ARCHIVE_REAL, (size_t)total, 1, all));
    PetscCall(PetscFree(all));
  } else {
    const PetscReal *known = a->rank ? NULL : summands_of(a, name, size, counts);
    *mine = (PetscBool)(known != NULL);
    PetscCallMPI(MPI_Bcast(mine, 1, MPI_PETSC_BOOL, 0, a->comm));
    if (*mine) PetscCallMPI(MPI_Scatterv(known, counts, starts, MPIU_REAL, x, count, MPIU_REAL, 0, a->comm));
  }
  PetscCall(PetscFree3(counts, starts, wide));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveText(Archive *a, const char *name, char **text)
{
  PetscFunctionBeginUser;
  if (a->rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (!a->reading) {
    PetscCall(put(a, name, ARCHIVE_TEXT, *text ? strlen(*text) : 0, 1, *text ? *text : ""));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const ArchiveEntry *e = wanted(a, name, ARCHIVE_TEXT, -1, 1);
  free(*text);
  *text = NULL;
  if (e && e->rows) *text = calloc(e->rows + 1, 1);
  if (*text) memcpy(*text, e->data, e->rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- by the gid of vertices and bodies */

/* Writes or reads rows of `width` numbers, each with its place among n_all. */
static PetscErrorCode placed(Archive *a, const char *name, PetscInt n, const PetscInt *place, PetscInt width,
                             PetscInt n_all, PetscReal *x)
{
  PetscReal *all;
  char full[2 * NAME_LENGTH];
  PetscMPIInt size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(a->comm, &size));
  if (!n_all) PetscFunctionReturn(PETSC_SUCCESS);
  full_name(a, name, full);
  if (!a->reading) {
    PetscCall(GatherPlaced(a->comm, n, place, width * sizeof(*x), x, n_all, &all));
    if (!a->rank) PetscCall(ArchiveAdd(a, full, ARCHIVE_REAL, (size_t)n_all, (size_t)width, all));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const ArchiveEntry *e = a->rank ? NULL : wanted(a, name, ARCHIVE_REAL, n_all, width);
  PetscBool there = (PetscBool)(e != NULL);
  PetscCallMPI(MPI_Bcast(&there, 1, MPI_PETSC_BOOL, 0, a->comm));
  if (!there) PetscFunctionReturn(PETSC_SUCCESS);
  if (size == 1 && e)
    all = e->data;
  else { // for the other ranks
    PetscCall(PetscMalloc1((size_t)n_all * width, &all));
    if (e) PetscCall(PetscMemcpy(all, e->data, (size_t)n_all * width * sizeof(PetscReal)));
    PetscCallMPI(MPI_Bcast(all, (PetscMPIInt)(n_all * width), MPIU_REAL, 0, a->comm));
  }
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt k = 0; k < width; k++) x[width * i + k] = all[width * place[i] + k];
  if (size > 1) PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveVertices(Archive *a, const Model *m, const char *name, PetscReal *x)
{
  PetscFunctionBeginUser;
  PetscCall(placed(a, name, m->mesh.n_owned, m->mesh.vertex_gid, 2, m->mesh.n_vertices_global, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveBlocks(Archive *a, const Model *m, const char *name, PetscInt n, const PetscInt *gid,
                             PetscInt width, PetscReal *x)
{
  PetscFunctionBeginUser;
  PetscCall(placed(a, name, n, gid, width, m->mesh.n_blocks_global, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_bodies(Archive *a, const Model *m, const char *name, PetscReal *x)
{
  char label[NAME_LENGTH];
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_bodies", name));
  PetscCall(placed(a, label, m->rigid.n, m->rigid.gid, 3, m->mesh.n_rigid_global, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveDofs(Archive *a, const Model *m, const char *name, PetscReal *x)
{
  const PetscBool rigid = (PetscBool)(m->mesh.n_rigid_global == m->mesh.n_bodies_global);
  PetscFunctionBeginUser;
  PetscCall(archive_bodies(a, m, name, x));
  PetscCall(placed(a, name, m->mesh.n_deformable, m->mesh.vertex_gid, 2,
                   rigid ? 0 : m->mesh.n_vertices_global, x + 3 * m->rigid.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveApplied(Archive *a, const Model *m, const char *name, PetscReal *x)
{
  PetscFunctionBeginUser;
  PetscCall(archive_bodies(a, m, name, x));
  PetscCall(ArchiveVertices(a, m, name, x + 3 * m->rigid.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveVec(Archive *a, const Model *m, const char *name, PetscBool inner, Vec vec)
{
  PetscReal *x;
  PetscFunctionBeginUser;
  PetscCall(VecGetArray(vec, &x));
  if (inner)
    PetscCall(ArchiveApplied(a, m, name, x));
  else
    PetscCall(ArchiveDofs(a, m, name, x));
  PetscCall(VecRestoreArray(vec, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveEffort(Archive *a, Effort *e)
{
  MethodChoice *c = &e->choice;
  PetscFunctionBeginUser;
  PetscCall(ArchiveIntMembers(a, "effort", INT_MEMBER(e->evaluations), INT_MEMBER(e->solves),
                              INT_MEMBER(e->factorisations), INT_MEMBER(e->preconditioned),
                              INT_MEMBER(e->stiffness_mass), INT_MEMBER(e->explicit), INT_MEMBER(e->fixed),
                              INT_MEMBER(e->variable), INT_MEMBER(e->wanted), INT_MEMBER(e->available)));
  PetscCall(ArchiveReals(a, "effort_outgrown", 3, e->outgrown));
  PetscCall(ArchiveIntMembers(a, "choice", INT_MEMBER(c->reason), INT_MEMBER(c->dofs), INT_MEMBER(c->bodies),
                              INT_MEMBER(c->limit), INT_MEMBER(c->given_up), INT_MEMBER(c->spent),
                              INT_MEMBER(c->left[0]), INT_MEMBER(c->left[1]), INT_MEMBER(c->left[2]),
                              INT_MEMBER(c->crept), INT_MEMBER(c->stalled)));
  PetscCall(ArchiveReals(a, "choice_order", 1, &c->order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveResult(Archive *a, const char *name, StageResult *r)
{
  Energies *e = &r->energy;
  char label[NAME_LENGTH], *evidence = a->rank ? NULL : strdup(r->evidence);
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_reals", name));
  PetscCall(ArchiveRealMembers(a, label, &r->ratio, &r->increment, &r->kinetic, &r->wall, &r->displacement,
                               &r->time, &r->deepest, &e->kinetic, &e->strain, &e->joints, &e->outside,
                               &e->supports, &e->friction, &e->damping, &e->detection, &e->balance));
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_counts", name));
  PetscCall(ArchiveIntMembers(a, label, INT_MEMBER(r->verdict), INT_MEMBER(r->cycles),
                              INT_MEMBER(r->worst_body), INT_MEMBER(r->finite), INT_MEMBER(r->verifications),
                              INT_MEMBER(r->contacts_made), INT_MEMBER(r->contacts_lost)));
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s_evidence", name));
  PetscCall(ArchiveText(a, label, &evidence));
  if (a->reading) {
    r->verdict = (Verdict)ArchiveWithin(a, "verdict", r->verdict, VERDICT_NONE, VERDICT_COMPLETED);
    snprintf(r->evidence, sizeof(r->evidence), "%s", evidence ? evidence : "");
    PetscCallMPI(MPI_Bcast(r->evidence, sizeof(r->evidence), MPI_CHAR, 0, a->comm));
  }
  free(evidence);
  PetscFunctionReturn(PETSC_SUCCESS);
}

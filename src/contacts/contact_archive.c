/* contact_archive.c: writes and reads contacts by key, as rows of two tables; see archive.h. */
#include "contacts/contacts.h"
#include "contacts/find.h"

enum { COUNTS = 7, REALS = 1 + 2 * END_ARRAYS, UNCRUSHED = REALS - 2 * CRUSHES_ARRAYS };

/* One contact as a row of the archive. count: model, key (2), class, joint, states of the ends (2). real:
   length, then the reals of each end in the order of CONTACT_FIELDS, the arrays of FIELD_CRUSHES last. These
   are not written when no contact is crushed. */
typedef struct {
  PetscInt64 count[COUNTS];
  PetscReal real[REALS];
} Row;

static int row_order(const void *a, const void *b)
{
  const Row *p = a, *q = b;
  for (int i = 0; i < 3; i++)
    if (p->count[i] != q->count[i]) return p->count[i] < q->count[i] ? -1 : 1;
  return 0;
}

/* Copies a contact from its place in the arrays to a row, or, when reading, from the row to the arrays. */
static void move_row(const Contacts *c, PetscInt at, PetscBool reading, Row *row)
{
  PetscReal *array[END_ARRAYS], *x = row->real;
  const int n = ContactsEndArrays(c, FIELD_ANY, array), uncrushed = n - CRUSHES_ARRAYS;
#define MOVE(here, there) (reading ? ((here) = (there)) : ((there) = (here)))
  MOVE(c->length[at], *x), x++;
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < uncrushed; i++, x++) MOVE(array[i][SUB(at, k)], *x);
  for (int k = 0; k < 2; k++) {
    for (int i = uncrushed; i < n; i++, x++) MOVE(array[i][SUB(at, k)], *x);
    if (reading)
      c->state[SUB(at, k)] = (uint8_t)row->count[5 + k];
    else
      row->count[5 + k] = c->state[SUB(at, k)];
  }
#undef MOVE
}

/* Collective. Gathers the owned contacts of all ranks on rank 0, in the order of contacts. */
static PetscErrorCode gather_rows(const Model *m, const Contacts *c, PetscInt *n_all, Row **all)
{
  PetscInt n = 0;
  Row *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(c->n, &rows));
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt at = c->model_start[s]; at < c->model_start[s + 1]; at++) {
      if (!c->owned[at]) continue;
      Row *row = rows + n++;
      row->count[0] = s, row->count[1] = c->key[2 * at], row->count[2] = c->key[2 * at + 1];
      row->count[3] = c->klass[at], row->count[4] = c->joint[at];
      move_row(c, at, PETSC_FALSE, row);
    }
  PetscCall(GatherAndFree(m->comm, n, sizeof(Row), rows, n_all, (void **)all));
  if (*n_all) qsort(*all, (size_t)*n_all, sizeof(Row), row_order);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- which contacts a rank has */

/* A vertex of a face: gid of the vertex, row of the face, and its place on the face (0 or 1). */
typedef struct {
  PetscInt gid, face, corner;
} VertexOfFace;

/* Lists the vertices of all faces, ascending. list: (2 faces.n,). */
static PetscErrorCode vertices_of_faces(const Model *m, VertexOfFace **list)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * m->faces.n, list));
  for (PetscInt i = 0; i < 2 * m->faces.n; i++)
    (*list)[i] = (VertexOfFace){m->mesh.vertex_gid[m->faces.vertex[i]], i / 2, i % 2};
  if (m->faces.n) qsort(*list, 2 * (size_t)m->faces.n, sizeof(VertexOfFace), OrderByPair);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool at_owned_vertex(const Model *m, PetscInt f)
{
  return (PetscBool)(m->faces.vertex[2 * f] < m->mesh.n_owned ||
                     m->faces.vertex[2 * f + 1] < m->mesh.n_owned);
}

/* Decides whether this rank has the contact of a row: it knows both faces and owns a vertex of the contact.
   Sets the faces of the candidate, and the vertex of a vertex on a face. */
static PetscBool faces_of_row(const Model *m, const VertexOfFace *list, const Row *row, Candidate *c)
{
  const PetscInt key[2] = {(PetscInt)row->count[1], (PetscInt)row->count[2]};
  const PetscInt g = FaceRow(m, key[0]);
  if (g < 0) return PETSC_FALSE;
  if (key[1] >= 0) { // two faces
    const PetscInt f = FaceRow(m, key[1]);
    c->face[0] = g, c->face[1] = f;
    return (PetscBool)(f >= 0 && (at_owned_vertex(m, f) || at_owned_vertex(m, g)));
  }
  const VertexOfFace wanted = {-2 - key[1], -1, 0};
  const PetscInt low = LowerBound(&wanted, list, 2 * m->faces.n, sizeof(list[0]), OrderByPair);
  if (low == 2 * m->faces.n || list[low].gid != wanted.gid) return PETSC_FALSE;
  c->face[0] = list[low].face, c->face[1] = g;
  c->vertex = m->faces.vertex[2 * list[low].face + list[low].corner];
  return (PetscBool)(c->vertex < m->mesh.n_owned || at_owned_vertex(m, g));
}

/* Moves the rows of contacts that this rank has to the front. list: the candidates of these contacts. */
static PetscErrorCode keep_rows(const Model *m, PetscInt *n, Row *rows, Candidate **list)
{
  VertexOfFace *vertices;
  PetscInt kept = 0;
  PetscFunctionBeginUser;
  PetscCall(vertices_of_faces(m, &vertices));
  PetscCall(PetscMalloc1(*n, list));
  for (PetscInt i = 0; i < *n; i++) {
    const PetscInt64 *count = rows[i].count;
    Candidate *c = *list + kept;
    *c = (Candidate){.model = (StressModelKind)count[0],
                     .key = {(PetscInt)count[1], (PetscInt)count[2]},
                     .joint = (PetscInt)count[4],
                     .before = -1};
    c->pair.klass = (ContactClass)count[3], c->pair.length = rows[i].real[0];
    if (!faces_of_row(m, vertices, rows + i, c)) continue;
    for (int k = 0; k < 2 && c->pair.klass != VERTEX_FACE; k++)
      c->pair.source[k] = END_SOURCE[c->pair.klass][k], c->pair.corner[k] = END_CORNER[c->pair.klass][k];
    rows[kept++] = rows[i];
  }
  *n = kept;
  PetscCall(PetscFree(vertices));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- both directions */

static PetscErrorCode write_rows(Archive *a, const Model *m, const char *const name[2], const Contacts *c)
{
  PetscInt n;
  size_t columns = UNCRUSHED;
  PetscInt64 *counts;
  PetscReal *reals;
  Row *rows;
  PetscFunctionBeginUser;
  PetscCall(gather_rows(m, c, &n, &rows));
  if (a->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((size_t)n * COUNTS, &counts));
  PetscCall(PetscMalloc1((size_t)n * REALS, &reals));
  for (PetscInt i = 0; i < n && columns < REALS; i++)
    for (int k = UNCRUSHED; k < REALS; k++)
      if (rows[i].real[k] != 0.) columns = REALS;
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(PetscArraycpy(counts + (size_t)i * COUNTS, rows[i].count, COUNTS));
    PetscCall(PetscArraycpy(reals + (size_t)i * columns, rows[i].real, columns));
  }
  PetscCall(PetscFree(rows));
  PetscCall(ArchiveAdd(a, name[0], ARCHIVE_COUNT, (size_t)n, COUNTS, counts));
  PetscCall(ArchiveAdd(a, name[1], ARCHIVE_REAL, (size_t)n, columns, reals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the name of a number in a row that cannot belong to a contact of this model; NULL: all can. Numbers
   that lead to places in memory are tested although the file has a checksum: a checksum shows damage, but not
   who has written the file. before: the row before it, or NULL. */
static const char *fault_of_row(const Scene *scene, const Model *m, const Row *row, const Row *before)
{
  const PetscInt64 *n = row->count, most_states = CONTACT_OPEN | CONTACT_SLIPPING | CONTACT_CRUSHING,
                   faces = 4 * (PetscInt64)m->mesh.n_blocks_global,
                   lowest = -2 - (PetscInt64)(m->mesh.n_vertices_global - 1);
  if (n[0] < 0 || n[0] >= STRESS_MODELS) return "stress model";
  if (n[1] < 0 || n[1] >= faces || n[2] < lowest || n[2] == -1 || n[2] >= faces) return "face";
  if (n[3] < 0 || n[3] > VERTEX_FACE || (n[3] == VERTEX_FACE) != (n[2] < 0)) return "class";
  if (n[4] < 0 || n[4] >= scene->n_joints) return "joint";
  for (int k = 5; k < COUNTS; k++)
    if (n[k] < 0 || n[k] > most_states) return "state";
  if (!(row->real[0] >= 0.) || PetscIsInfReal(row->real[0])) return "length";
  return before && row_order(before, row) >= 0 ? "place" : NULL;
}

/* Collective. Gives all rows to all ranks; no rows if one of them is no contact of this model. */
static PetscErrorCode read_rows(Archive *a, const Scene *scene, const Model *m, const char *const name[2],
                                PetscInt *n, Row **rows)
{
  const ArchiveEntry *e[2] = {a->rank ? NULL : ArchiveFind(a, name[0]),
                              a->rank ? NULL : ArchiveFind(a, name[1])};
  PetscMPIInt bytes;
  PetscFunctionBeginUser;
  const size_t columns = e[1] ? e[1]->columns : 0;
  *n = e[0] && e[1] && e[0]->columns == COUNTS && (columns == REALS || columns == UNCRUSHED) &&
               e[0]->rows == e[1]->rows
           ? (PetscInt)e[0]->rows
           : -1;
  if (!a->rank && *n < 0) snprintf(a->message, MESSAGE_LENGTH, "%s is missing", name[0]);
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, a->comm));
  *n = PetscMax(*n, 0);
  PetscCall(PetscCalloc1(*n, rows));
  for (PetscInt i = 0; i < *n && !a->rank; i++) {
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): rows were counted in the entry itself
    PetscCall(PetscArraycpy((*rows)[i].count, (PetscInt64 *)e[0]->data + (size_t)i * COUNTS, COUNTS));
    PetscCall(PetscArraycpy((*rows)[i].real, (PetscReal *)e[1]->data + (size_t)i * columns, columns));
  }
  for (PetscInt i = 0; i < *n; i++) {
    const char *fault = a->rank ? NULL : fault_of_row(scene, m, *rows + i, i ? *rows + i - 1 : NULL);
    if (!fault) continue;
    if (!a->message[0])
      snprintf(a->message, MESSAGE_LENGTH, "%s: the %s of row %" PetscInt_FMT " is none of this model",
               name[0], fault, i);
    *n = 0;
  }
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, a->comm));
  enum { CHUNK = 1 << 20 };
  for (PetscInt i = 0; i < *n; i += CHUNK) {
    PetscCall(PetscMPIIntCast(PetscMin(CHUNK, *n - i) * (PetscInt)sizeof(Row), &bytes));
    PetscCallMPI(MPI_Bcast(*rows + i, bytes, MPI_BYTE, 0, a->comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ArchiveContacts(Archive *a, const Scene *scene, const Model *m, const char *name, Contacts *c)
{
  char label[2][2 * NAME_LENGTH];
  const char *const names[2] = {label[0], label[1]};
  PetscInt n, wanted, owned = 0;
  Row *rows;
  Candidate *list;
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(label[0], sizeof(label[0]), "%s/%s_key", a->part, name));
  PetscCall(PetscSNPrintf(label[1], sizeof(label[1]), "%s/%s", a->part, name));
  if (!a->reading) {
    PetscCall(write_rows(a, m, names, c));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(read_rows(a, scene, m, names, &n, &rows));
  wanted = n;
  PetscCall(keep_rows(m, &n, rows, &list));
  PetscCall(ContactsDestroy(c));
  PetscCall(ContactsStore(scene, m, &(CandidateList){.n = n, .item = list}, NULL, NULL, c));
  for (PetscInt at = 0, i = 0; at < c->n_padded; at++) // rows, candidates and contacts have one order
    if (c->key[2 * at] >= 0) move_row(c, at, PETSC_TRUE, rows + i++), owned += c->owned[at];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &owned, 1, MPIU_INT, MPI_SUM, a->comm));
  if (!a->rank && owned != wanted && !a->message[0])
    snprintf(a->message, MESSAGE_LENGTH,
             "%s: %" PetscInt_FMT " of its %" PetscInt_FMT " contacts join no faces of this model", names[0],
             wanted - owned, wanted);
  ContactsSetTraits(m, c);
  PetscCall(PetscFree(list));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

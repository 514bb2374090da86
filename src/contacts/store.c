/* store.c: stores contacts, and checks whether bodies in contact are supported. Every rank keeps the contacts
   that touch a vertex it owns, in ascending (stress model, face, face). */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* Collective. Refuses a scene in which the joint of a contact has no properties. */
static PetscErrorCode check_joints(const Scene *scene, const Model *m, PetscInt n, const Candidate *list)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n && !message[0]; i++) {
    if (list[i].joint || list[i].kept || scene->joints[0].k_n > 0.) continue;
    const char *a = m->materials.names[m->faces.group[list[i].face[0]]],
               *b = m->materials.names[m->faces.group[list[i].face[1]]];
    PetscCall(PetscSNPrintf(
        message, MESSAGE_LENGTH,
        "%s: joints: blocks of groups %s and %s touch, but no joint names a face set between them, the pair "
        "%s+%s or default",
        scene->file, a, b, a, b));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores a padding lane: a contact of length 0 between dummy vertices, with closed ends. */
static void store_padding(const Model *m, PetscInt at, PetscInt joint, Contacts *c)
{
  c->key[2 * at] = c->key[2 * at + 1] = -1;
  c->joint[at] = joint;
  for (int i = 0; i < CONTACT_ROWS; i++) c->vertex[CONTACT_ROW(at, i)] = m->mesh.n_vertices + (i == ROW_B);
}

static void store(const Scene *scene, const Model *m, const Candidate *p, PetscInt at, Contacts *c)
{
  const PetscBool on_vertex = (PetscBool)(p->pair.klass == VERTEX_FACE);
  c->key[2 * at] = p->key[0], c->key[2 * at + 1] = p->key[1];
  c->klass[at] = (uint8_t)p->pair.klass;
  c->joint[at] = p->joint;
  c->length[at] = p->pair.length;
  c->owned[at] = (on_vertex ? p->vertex : m->faces.vertex[2 * p->face[0]]) < m->mesh.n_owned;

  const PetscInt source = p->pair.source[0], *from = m->faces.vertex + 2 * p->face[source],
                 *destination = m->faces.vertex + 2 * p->face[1 - source];
  const int corner = p->pair.corner[0];
  c->vertex[CONTACT_ROW(at, ROW_P)] = on_vertex ? p->vertex : from[corner];
  c->vertex[CONTACT_ROW(at, ROW_A)] = destination[0], c->vertex[CONTACT_ROW(at, ROW_B)] = destination[1];
  c->vertex[CONTACT_ROW(at, ROW_Q)] = !on_vertex                ? from[1 - corner]
                                      : p->model == STRESS_TPTM ? p->vertex
                                                                : destination[0];
  for (int k = 0; k < 2; k++) {
    c->t[SUB(at, k)] = p->pair.t[k];
    const PetscReal gap = p->pair.gap[k];
    if (gap < 0. || (gap > 0. && scene->initial_gaps == GAPS_CLOSED)) c->rest[SUB(at, k)] = gap;
  }
}

/* Copies a contact that stays as it was to its new place. */
static void store_kept(const Candidate *p, const Contacts *old, const PetscInt *vertex_now, PetscInt at,
                       Contacts *c)
{
  ContactsCopyOne(old, p->before, c, at);
  for (int i = 0; i < CONTACT_ROWS; i++)
    c->vertex[CONTACT_ROW(at, i)] = vertex_now[old->vertex[CONTACT_ROW(p->before, i)]];
}

PetscErrorCode ContactsStore(const Scene *scene, const Model *m, const CandidateList *list,
                             const Contacts *before, const PetscInt *vertex_now, Contacts *c)
{
  PetscInt count[STRESS_MODELS] = {0}, first[STRESS_MODELS] = {0};
  const Candidate *item = list->item;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(c, sizeof(*c)));
  PetscCall(check_joints(scene, m, list->n, item));
  for (PetscInt i = 0; i < list->n; i++) count[item[i].model]++;
  for (int s = 0; s < STRESS_MODELS; s++) {
    first[s] = s ? first[s - 1] + count[s - 1] : 0;
    c->model_start[s + 1] = c->model_start[s] + (count[s] + BATCH - 1) / BATCH * BATCH;
  }
  c->n = list->n;
  c->n_padded = c->model_start[STRESS_MODELS];
  PetscCall(ContactsAllocate(c));
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt at = c->model_start[s]; at < c->model_start[s + 1]; at++) {
      const PetscInt i = at - c->model_start[s];
      if (i >= count[s])
        store_padding(m, at, item[first[s]].joint, c);
      else if (item[first[s] + i].kept)
        store_kept(item + first[s] + i, before, vertex_now, at, c);
      else
        store(scene, m, item + first[s] + i, at, c);
    }
  ContactsSetTraits(m, c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsCreate(const Scene *scene, const Model *m, Contacts *c)
{
  CandidateList list = {0};
  FaceTable table;
  PetscFunctionBeginUser;
  PetscCall(FaceTableCreate(m, NULL, PETSC_FALSE, &table));
  PetscCall(ContactsFind(scene, m, NULL, &table, &list));
  PetscCall(CornersHide(scene, m, &table, &list));
  PetscCall(FaceTableDestroy(&table));
  PetscCall(CandidatesSort(m, &list));
  PetscCall(ContactsStore(scene, m, &list, NULL, NULL, c));
  PetscCall(PetscFree(list.item));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { SUPPORT_COLUMNS = 5 };

/* Collective. Collects the supports of each union of bodies that touch, at its root. support:
   (n_bodies_global, SUPPORT_COLUMNS); -infinity: none. The columns are the largest y and -y of supports in x,
   the largest x and -x of supports in y, and 1 where a support prescribes a rotation. */
static PetscErrorCode collect_supports(const Model *m, PetscInt *parent, PetscReal *support)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < SUPPORT_COLUMNS * m->mesh.n_bodies_global; i++) support[i] = -PETSC_INFINITY;
  for (PetscInt d = 0; d < ModelApplied(m); d++) {
    if (!Held(m, d)) continue;
    const PetscInt rigid = 3 * m->rigid.n, i = d < rigid ? d % 3 : (d - rigid) % 2;
    PetscReal *h = support + SUPPORT_COLUMNS * UnionRoot(parent, DofBody(m, d));
    const PetscReal *x = d < rigid ? m->rigid.X + 2 * (d / 3) : m->mesh.X + 2 * ((d - rigid) / 2);
    if (i == 2) {
      h[4] = 1.;
    } else {
      h[2 * i] = PetscMax(h[2 * i], x[1 - i]);
      h[2 * i + 1] = PetscMax(h[2 * i + 1], -x[1 - i]);
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, support, SUPPORT_COLUMNS * m->mesh.n_bodies_global, MPIU_REAL,
                             MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the motion that no support prevents; NULL when all are prevented. Two supports in one direction
   prevent the rotation when they are apart across this direction. */
static const char *free_motion(const PetscReal *h, PetscReal diameter)
{
  const PetscReal apart = 1e-9 * diameter;
  const PetscBool x = (PetscBool)(h[0] > -PETSC_INFINITY), y = (PetscBool)(h[2] > -PETSC_INFINITY);
  if (!x && !y) return "has no support: it touches no supported block";
  if (!x) return "is not held in x, nor is any block it touches";
  if (!y) return "is not held in y, nor is any block it touches";
  if (!(h[4] > 0. || h[0] + h[1] > apart || h[2] + h[3] > apart))
    return "can turn about its supports, which are all in one place";
  return NULL;
}

/* Joins on every rank the bodies that its own contacts link. The ranks then exchange the roots of their
   unions, until all have the same unions. */
PetscErrorCode ContactsCheckSupport(const Scene *scene, const Model *m, const Contacts *c)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscInt *parent, *all, changed = 1;
  PetscReal *support;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (scene->allow_floating || m->lifts) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc3(n, &parent, n, &all, SUPPORT_COLUMNS * n, &support));
  for (PetscInt b = 0; b < n; b++) parent[b] = b;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0) continue;
    const PetscInt a = m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_P)]],
                   b = m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_A)]];
    parent[PetscMax(UnionRoot(parent, a), UnionRoot(parent, b))] = PetscMin(UnionRoot(parent, a),
                                                                            UnionRoot(parent, b));
  }
  while (changed) { // a rank takes over the links of others until nothing changes, after a few rounds
    for (PetscInt b = 0; b < n; b++) all[b] = UnionRoot(parent, b);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, n, MPIU_INT, MPI_MIN, m->comm));
    changed = 0;
    for (PetscInt b = 0; b < n; b++) {
      const PetscInt p = UnionRoot(parent, b), q = UnionRoot(parent, all[b]);
      if (p != q) parent[PetscMax(p, q)] = PetscMin(p, q), changed = 1;
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPIU_INT, MPI_MAX, m->comm));
  }
  PetscCall(collect_supports(m, parent, support));
  for (PetscInt b = 0, e; b < n && !message[0]; b++) {
    const char *problem = free_motion(support + SUPPORT_COLUMNS * UnionRoot(parent, b), m->mesh.diameter);
    if (!problem) continue;
    for (e = 0; e < m->mesh.n_owned && m->mesh.vertex_body[e] != b;)
      e++; // a vertex of body b, if this rank owns one
    if (e < m->mesh.n_owned)
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: supports: macroblock %" PetscInt_FMT " (at vertex %" PetscInt_FMT
                              ", x = %.6g m, y = %.6g m) %s; add a support, or set relaxation.allow_floating",
                              scene->file, b, m->mesh.vertex_file[e], (double)m->mesh.X[2 * e],
                              (double)m->mesh.X[2 * e + 1], problem));
  }
  PetscCall(PetscFree3(parent, all, support));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

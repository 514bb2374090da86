/* find.c: finds face-to-face contacts (sections 2.1-2.2), at set-up and again when blocks have moved. The
   steps are envelopes and grid, near faces, candidates, and the order of candidates. All is local to the
   rank, and its time is linear in the faces of the rank. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* ---- faces as they stand */

typedef struct {
  const Model *m;
  PetscBool verifying;
} TouchContext;

/* Decides whether two faces may touch at all: they belong to different blocks, not to one rigid body, and one
   of them is at an owned vertex. */
static PetscBool may_touch(PetscInt f, PetscInt g, const void *context)
{
  const TouchContext *c = context;
  const Faces *faces = &c->m->faces;
  const PetscInt *vf = faces->vertex + 2 * f, *vg = faces->vertex + 2 * g, n_owned = c->m->mesh.n_owned;
  if (faces->gid[f] / 4 == faces->gid[g] / 4) return PETSC_FALSE;
  if (FaceAbsent(c->m, f) || FaceAbsent(c->m, g)) return PETSC_FALSE;
  if (faces->rigid[f] >= 0 && faces->rigid[f] == faces->rigid[g]) return PETSC_FALSE;
  if (c->verifying && !c->m->materials.upgradeable[faces->group[f]] &&
      !c->m->materials.upgradeable[faces->group[g]])
    return PETSC_FALSE;
  return (PetscBool)(vf[0] < n_owned || vf[1] < n_owned || vg[0] < n_owned || vg[1] < n_owned);
}

/* Lists the rows of the faces at each vertex, in table->vertex_row. */
static PetscErrorCode faces_of_vertices(const Model *m, FaceTable *table)
{
  PetscInt *s, *r;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + 2, &s));
  PetscCall(PetscMalloc1(2 * m->faces.n, &r));
  for (PetscInt i = 0; i < 2 * m->faces.n; i++) s[m->faces.vertex[i] + 2]++;
  for (PetscInt v = 0; v < m->mesh.n_vertices; v++) s[v + 2] += s[v + 1];
  for (PetscInt i = 0; i < 2 * m->faces.n; i++) r[s[m->faces.vertex[i] + 1]++] = i / 2;
  table->vertex_start = s, table->vertex_row = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FaceTableCreate(const Model *m, const PetscReal *u, PetscBool verifying, FaceTable *table)
{
  const PetscInt n = m->faces.n;
  const TouchContext context = {m, verifying};
  PetscReal *box;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * n, &box));
  PetscCall(PetscMalloc2(4 * n, &table->x, n, &table->length));
  for (PetscInt f = 0; f < n; f++) {
    PetscReal *x = table->x + 4 * f;
    FaceCoordinates(m, u, f, x);
    FaceBox(x, x + 2, m->contact_margin + m->contact_depth, box + 4 * f);
    table->length[f] = FaceLength(x);
  }
  PetscCall(GridRows(n, box, may_touch, &context, &table->start, &table->near));
  PetscCall(PetscFree(box));
  PetscCall(PetscCalloc1(table->start[n], &table->touch));
  PetscCall(faces_of_vertices(m, table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FaceTableDestroy(FaceTable *table)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(table->x, table->length));
  PetscCall(PetscFree(table->start));
  PetscCall(PetscFree(table->near));
  PetscCall(PetscFree(table->touch));
  PetscCall(PetscFree(table->vertex_start));
  PetscCall(PetscFree(table->vertex_row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the old contacts */

PetscErrorCode OldContactsCreate(const Contacts *c, OldContacts *old)
{
  PetscFunctionBeginUser;
  *old = (OldContacts){.contacts = c, .mask = 15};
  while (old->mask < 2 * (unsigned)c->n) old->mask = 2 * old->mask + 1;
  PetscCall(PetscMalloc1(3 * ((size_t)old->mask + 1), &old->slot));
  for (size_t i = 0; i <= old->mask; i++) old->slot[3 * i + 2] = -1;
  for (PetscInt at = 0; at < c->n_padded; at++) {
    const PetscInt *key = c->key + 2 * at;
    if (key[0] < 0) continue;
    unsigned i = OldContactsSlot(old, key[0], key[1]);
    while (old->slot[3 * (size_t)i + 2] >= 0) i = (i + 1) & old->mask;
    old->slot[3 * (size_t)i] = key[0], old->slot[3 * (size_t)i + 1] = key[1],
                  old->slot[3 * (size_t)i + 2] = at;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OldContactsDestroy(OldContacts *old)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(old->slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- finding */

static const PetscReal STALE = 0.1; /* [-] of its length; a contact that has slid or opened farther is
                                       stale */

PetscErrorCode CandidatesPush(CandidateList *list, const Candidate *candidate)
{
  PetscFunctionBeginUser;
  PetscCall(MakeRoom(sizeof(Candidate), list->n, &list->capacity, &list->item));
  list->item[list->n++] = *candidate;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether one end is open and the faces lie opposite each other over half the shorter one. This is so
   where a block turns down onto a face, not where it passes an edge. */
static PetscBool half_open(const FacePair *pair, PetscReal shorter)
{
  return (PetscBool)(PetscMax(pair->gap[0], pair->gap[1]) > 0. && pair->length >= 0.5 * shorter);
}

/* Decides whether a contact keeps its ends and length. Measuring it again would give other ends and another
   length, because blocks have strained and slipped, and so another answer. Therefore a contact stays until it
   has slid by the tolerance, or by a tenth of its length. In time it stays only until it has slid by FLUSH
   tolerances, because measuring it again changes its stored energy by the slide squared. */
static PetscBool contact_stays(const Scene *scene, const Contacts *before, PetscInt at)
{
  const PetscReal length = before->length[at];
  const PetscReal tolerance = scene->contact_tolerance * (scene->contact_relative ? length : 1.);
  const PetscReal most = PetscMin((before->rate != 0. ? FLUSH : 1.) * tolerance, STALE * length);
  return (PetscBool)(PetscMax(PetscAbsReal(before->u_s[SUB(at, 0)]), PetscAbsReal(before->u_s[SUB(at, 1)])) <=
                     most);
}

PetscReal ContactLossGap(const Scene *scene, const Contacts *before, PetscInt at, PetscReal tolerance)
{
  const PetscBool whole = (PetscBool)(before->broken_0[SUB(at, 0)] + before->broken_0[SUB(at, 1)] < 1.),
                  on_way = (PetscBool)(ContactsFromCommitted(before) &&
                                       JointBreaks(scene->joints + before->joint[at]));
  return PetscMax(tolerance, (whole && on_way ? 0.5 : STALE) * before->length[at]);
}

/* Completes the candidate of faces f and g, where f has the lower gid. Returns whether they touch. */
static PetscBool make_candidate(const Scene *scene, const Model *m, const OldContacts *old,
                                const FaceTable *table, PetscInt f, PetscInt g, Candidate *c)
{
  const PetscReal *a = table->x + 4 * f, *b = table->x + 4 * g, la = table->length[f], lb = table->length[g];
  const PetscReal shorter = PetscMin(la, lb);
  const PetscReal tolerance = scene->contact_tolerance * (scene->contact_relative ? shorter : 1.);
  // an old contact may be pressed in deep, though never as deep as the back of its block; a new one may not,
  // because until then its corners carry it as vertices on a face
  const PetscBool was = (PetscBool)(c->before >= 0);
  const PetscReal thin = FACE_DEPTH * PetscMin(m->faces.thick[f], m->faces.thick[g]);
  const PetscBool in_motion = (PetscBool)(old && old->contacts->rate != 0.);
  const PetscReal overlap = PetscMin(scene->overlap_tolerance, thin);
  PetscReal depth = was ? thin : overlap, deepest;
  // in statics a block may be pressed in deeper when it slides on to the next face
  if (!was && old && !in_motion) depth = PetscMax(depth, PetscMin(thin, m->contact_pressed));
  // two faces of one body can touch only across a slit; an overlap there is the thickness of the body itself
  if (m->faces.body[f] == m->faces.body[g] && !was) depth = FACE_MIN_OVERLAP * shorter;
  // in motion one near end suffices: a partly open face contact has a potential (tptm), but a change from a
  // loaded vertex on a face has none; so a vertex that is pressed in deep may land as well
  deepest = in_motion && depth == overlap ? thin : depth;
  if (FacePairClassify(a, b, was || old ? PETSC_MAX_REAL : tolerance, deepest, &c->pair) == FACES_APART)
    return PETSC_FALSE;
  if (PetscMin(c->pair.gap[0], c->pair.gap[1]) < -depth && !half_open(&c->pair, shorter)) return PETSC_FALSE;
  if (!was && c->pair.length < 0.5 * shorter && PetscMax(c->pair.gap[0], c->pair.gap[1]) > tolerance)
    return PETSC_FALSE;
  const PetscReal loss_gap = was ? ContactLossGap(scene, old->contacts, c->before, tolerance) : tolerance;
  if (PetscMin(c->pair.gap[0], c->pair.gap[1]) > loss_gap) return PETSC_FALSE;
  // two corners that meet as blocks move have two pairs of faces; a pair shorter than the tolerance that is
  // deeper than long is the side of a block that slides over the edge; so is an old pair shorter than FLUSH
  // tolerances that is deeper than the tolerance
  const PetscBool corners = (PetscBool)(c->pair.klass == FF2_I || c->pair.klass == FF2_F);
  const PetscReal distance = PetscMax(PetscAbsReal(c->pair.gap[0]), PetscAbsReal(c->pair.gap[1]));
  const PetscReal low = was ? FLUSH * tolerance : tolerance, deep = was ? tolerance : c->pair.length;
  if (old && corners && c->pair.length < low && distance > deep) return PETSC_FALSE;
  c->joint = was ? old->contacts->joint[c->before] : JointOfPair(scene, m, f, g);
  c->model = scene->joints[c->joint].stress_model;
  c->kept = (PetscBool)(was && contact_stays(scene, old->contacts, c->before));
  return PETSC_TRUE;
}

/* Decides whether two faces are near anti-parallel. FacePairClassify would refuse the others too, at more
   cost. */
static PetscBool face_each_other(const FaceTable *table, PetscInt f, PetscInt g)
{
  const PetscReal *a = table->x + 4 * f, *b = table->x + 4 * g;
  const PetscReal scalar = (a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1]);
  return (PetscBool)(scalar < -0.8 * table->length[f] * table->length[g]);
}

PetscErrorCode ContactsFind(const Scene *scene, const Model *m, const OldContacts *old, FaceTable *table,
                            CandidateList *list)
{
  const PetscInt *gid = m->faces.gid;
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < m->faces.n; f++)
    for (PetscInt p = table->start[f]; p < table->start[f + 1]; p++) {
      const PetscInt g = table->near[p];
      if (gid[g] < gid[f] || !face_each_other(table, f, g)) continue;
      Candidate c = {
          .key = {gid[f], gid[g]}, .face = {f, g}, .before = old ? OldContactFind(old, gid[f], gid[g]) : -1};
      char touch = c.before >= 0 ? TOUCHED : 0;
      if (make_candidate(scene, m, old, table, f, g, &c)) {
        touch |= TOUCHES | (c.kept ? STAYS : 0);
        PetscCall(CandidatesPush(list, &c));
      }
      if (!touch) continue;
      table->touch[p] = touch;
      for (PetscInt q = table->start[g]; q < table->start[g + 1]; q++)
        if (table->near[q] == f) table->touch[q] = touch;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- order */

static int candidate_order(const Candidate *p, const Candidate *q)
{
  if (p->model != q->model) return (p->model > q->model) - (p->model < q->model);
  return OrderInts(2, p->key, q->key);
}

/* Finds the place of each face in ascending order of gids. The local rows ascend already, and so do the far
   rows, so they are only merged. place: (faces.n,). */
static void place_faces(const Model *m, PetscInt *place)
{
  const PetscInt n = m->faces.n_local, *gid = m->faces.gid;
  for (PetscInt at = 0, near = 0, far = n; at < m->faces.n; at++)
    place[near < n && (far == m->faces.n || gid[near] < gid[far]) ? near++ : far++] = at;
}

/* Sorts the few candidates of one face by key[1]. */
static void sort_row(const Candidate *item, PetscInt n, PetscInt *order)
{
  for (PetscInt i = 1; i < n; i++) {
    const PetscInt this = order[i];
    PetscInt at = i;
    for (; at > 0 && item[order[at - 1]].key[1] > item[this].key[1]; at--) order[at] = order[at - 1];
    order[at] = this;
  }
}

/* Sorts in three steps, linear in all: a counting sort by the face of key[0], an insertion sort by key[1]
   among the few candidates of one face, and a counting sort by model. */
PetscErrorCode CandidatesSort(const Model *m, CandidateList *list)
{
  PetscInt *place, *start, *order, first[STRESS_MODELS + 1] = {0};
  Candidate *sorted, *item = list->item;
  PetscBool is_sorted = PETSC_TRUE;
  PetscFunctionBeginUser;
  for (PetscInt i = 1; i < list->n && is_sorted; i++)
    is_sorted = (PetscBool)(candidate_order(item + i - 1, item + i) < 0);
  if (is_sorted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(m->faces.n, &place, list->n, &order));
  PetscCall(PetscCalloc1(m->faces.n + 2, &start));
  place_faces(m, place);
#define ROW(c) ((c)->face[(c)->pair.klass == VERTEX_FACE && !(c)->kept]) /* row of the face of key[0] */
  for (PetscInt i = 0; i < list->n; i++) start[place[ROW(item + i)] + 2]++, first[item[i].model + 1]++;
  for (PetscInt f = 0; f < m->faces.n; f++) start[f + 2] += start[f + 1];
  for (int s = 0; s < STRESS_MODELS; s++) first[s + 1] += first[s];
  for (PetscInt i = 0; i < list->n; i++) order[start[place[ROW(item + i)] + 1]++] = i;
#undef ROW
  for (PetscInt f = 0; f < m->faces.n; f++) sort_row(item, start[f + 1] - start[f], order + start[f]);
  PetscCall(PetscMalloc1(list->n, &sorted));
  for (PetscInt i = 0; i < list->n; i++) sorted[first[item[order[i]].model]++] = item[order[i]];
  PetscCall(PetscFree(list->item));
  list->item = sorted, list->capacity = list->n;
  PetscCall(PetscFree2(place, order));
  PetscCall(PetscFree(start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

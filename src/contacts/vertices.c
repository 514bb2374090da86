/* vertices.c: finds contacts of vertices on faces (Fig. 5b), when connectivity is variable.

   A face-to-face contact one end of which opens beyond the tolerance, and a corner that comes down on a face,
   become contacts of one vertex. Such a contact has the point model at P with an influence length of its own.
   In a joint with tptm it has the diagram of a face with all its force at P; the diagram is carried over when
   a face contact degenerates, so that force and energy are kept. The length is never below vertex_length
   times the shorter face. A vertex has at most one contact with a face, and none beside a face contact of one
   of its own faces. Of the two faces at a convex corner it takes the nearer. Where a corner slides over a
   joint of two flush faces it is pressed in, and must not catch on the side of the next block. So within
   FLUSH tolerances of a corner only an old contact stays a contact.

   The rank that owns the vertex decides, because it alone is sure to know all faces of the vertex, all faces
   near it, and their old contacts. It sends the contact to the owners of the face's ends. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* A vertex near a face. */
typedef struct {
  PetscInt face, on; /* rows of faces: the face of the vertex (of two, the lower gid), and the face that it is
                        near */
  PetscInt body;     /* macroblock of `on` */
  PetscReal t, gap;  /* [-], [m] position of the vertex relative to `on`, see face_project */
  PetscBool blocked; /* the vertex cannot be a contact with this face */
  PetscBool flat;    /* the two faces are nearly parallel */
  PetscBool was;     /* the vertex and the face, or the two faces, were in contact before */
  PetscReal flush;   /* [m] a lower step between faces counts as none */
  PetscInt before;   /* place among the old contacts, -1: none */
} VertexNear;

/* All faces near one vertex. None is left out, however many slivers meet in one place: ranks find them in
   different orders. */
typedef struct {
  PetscInt n, capacity;
  VertexNear *item; /* (n,) */
} NearList;

/* Input of the search at every vertex. */
typedef struct {
  const Scene *scene;
  const Model *m;
  const OldContacts *old;
  const FaceTable *table;
  char *stood; /* (n_owned,) 1: the vertex stood on a face before; only these are looked up in `old` */
} Search;

/* Decides whether the body of vertex v itself lies between v and face g: all faces of v run the same way as
   g, and none lies opposite g. A side that leans by less than 20 degrees opens no way to g. */
static PetscBool is_behind_itself(const FaceTable *table, PetscInt v, PetscInt g)
{
  const PetscReal *b = table->x + 4 * g;
  PetscReal least = 1., most = -1.;
  for (PetscInt r = table->vertex_start[v]; r < table->vertex_start[v + 1]; r++) {
    const PetscInt f = table->vertex_row[r];
    const PetscReal *a = table->x + 4 * f;
    const PetscReal cosine = ((a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1])) /
                             (table->length[f] * table->length[g]);
    least = PetscMin(least, cosine), most = PetscMax(most, cosine);
  }
  return (PetscBool)(least > (most > 0.5 ? -SIN_LIMIT : -FACE_TIE));
}

/* Decides whether an old contact was pressed in at vertex v. */
static PetscBool is_pressed_at(const Contacts *before, PetscInt at, PetscInt v)
{
  const PetscReal tie = 1e-6; // [-] of the face: two vertices this near are at the same end
  for (int k = 0; at >= 0 && k < ContactEnds(before, at); k++) {
    const PetscReal t = before->t[SUB(at, k)];
    PetscInt end[3];
    ContactEndVertices(before, at, k, end);
    if (end[0] != v && (end[1] != v || t > tie) && (end[2] != v || t < 1. - tie)) continue;
    if (before->u_n[SUB(at, k)] < 0.) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Decides whether the owned vertex v was pressed into the body before. */
static PetscBool was_pressed(const Search *s, PetscInt v, PetscInt body)
{
  const FaceTable *table = s->table;
  const PetscInt *gid = s->m->faces.gid;
  for (PetscInt r = table->vertex_start[v]; r < table->vertex_start[v + 1]; r++) {
    const PetscInt f = table->vertex_row[r];
    for (PetscInt p = table->start[f]; p < table->start[f + 1]; p++) {
      const PetscInt g = table->near[p], a = PetscMin(gid[f], gid[g]), b = PetscMax(gid[f], gid[g]);
      if (s->m->faces.body[g] != body) continue;
      if (is_pressed_at(s->old->contacts, OldContactFind(s->old, a, b), v)) return PETSC_TRUE;
      const PetscInt own = OldContactFind(s->old, gid[g], VertexKey(s->m->mesh.vertex_gid[v]));
      if (is_pressed_at(s->old->contacts, own, v)) return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* Returns the gap [m] of vertex v over face g as drawn, if a face of v and g were in contact as drawn; 0
   elsewhere. */
static PetscReal gap_as_drawn(const Search *s, PetscInt v, PetscInt g)
{
  for (PetscInt r = s->table->vertex_start[v]; r < s->table->vertex_start[v + 1]; r++) {
    const PetscReal gap = GapAsDrawn(s->scene, s->m, s->table->vertex_row[r], g, v);
    if (gap != 0.) return gap;
  }
  return 0.;
}

/* Decides whether vertex v of face f, at P, is near face g, also a little beyond the ends of g. p: the place
   of g among the faces near f. near: describes the two, when they are near. */
static PetscBool is_near(const Search *s, PetscInt v, const PetscReal *P, PetscInt f, PetscInt p,
                         VertexNear *near)
{
  const Faces *faces = &s->m->faces;
  const PetscInt g = s->table->near[p];
  const PetscReal *xf = s->table->x + 4 * f, *xg = s->table->x + 4 * g;
  const PetscReal lf = s->table->length[f], lg = s->table->length[g], shorter = PetscMin(lf, lg);
  const PetscReal tolerance = s->scene->contact_tolerance * (s->scene->contact_relative ? shorter : 1.);
  PetscReal t, gap;
  face_project(xg, xg + 2, P, &t, &gap);
  if (PetscMin(t, 1. - t) * lg < -tolerance || gap > tolerance) return PETSC_FALSE;
  if (gap < -FACE_DEPTH * PetscMin(faces->thick[f], faces->thick[g])) return PETSC_FALSE;
  if (v == faces->vertex[2 * g] || v == faces->vertex[2 * g + 1]) return PETSC_FALSE; // g is a face of v
  const PetscInt before = s->stood[v]
                              ? OldContactFind(s->old, faces->gid[g], VertexKey(s->m->mesh.vertex_gid[v]))
                              : -1;
  // a vertex behind a face of its own body is inside the body, unless it has come there across a slit
  if (faces->body[f] == faces->body[g] && before < 0 && gap < -FACE_MIN_OVERLAP * shorter) return PETSC_FALSE;
  if (before < 0 && is_behind_itself(s->table, v, g)) return PETSC_FALSE;
  // a vertex comes into a body through its surface: one that is deep behind a face and has not been pressed
  // in before stands in front of another face of the body, beyond a corner of less than 90 degrees
  const PetscReal fresh = PetscMax(tolerance, 2. * s->old->moved);
  if (before < 0 && !(s->table->touch[p] & TOUCHED) && gap < -fresh && !was_pressed(s, v, faces->body[g]))
    return PETSC_FALSE;
  const PetscReal scalar = (xf[2] - xf[0]) * (xg[2] - xg[0]) + (xf[3] - xf[1]) * (xg[3] - xg[1]);
  *near = (VertexNear){.face = f,
                       .on = g,
                       .body = faces->body[g],
                       .t = t,
                       .gap = gap,
                       .blocked = (PetscBool)((s->table->touch[p] & TOUCHES) || t < 0. || t >= 1.),
                       .flat = (PetscBool)(scalar < -FACE_COS_LIMIT * lf * lg),
                       .was = (PetscBool)(before >= 0 || (s->table->touch[p] & TOUCHED)),
                       .flush = FLUSH * tolerance,
                       .before = before};
  return PETSC_TRUE;
}

static PetscErrorCode near_push(NearList *list, const VertexNear *near)
{
  PetscFunctionBeginUser;
  PetscCall(MakeRoom(sizeof(VertexNear), list->n, &list->capacity, &list->item));
  list->item[list->n++] = *near;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists all faces near a vertex, each once, even if several faces of the vertex are near it. */
static PetscErrorCode faces_near(const Search *s, PetscInt v, NearList *list)
{
  const FaceTable *table = s->table;
  const PetscInt *gid = s->m->faces.gid;
  PetscFunctionBeginUser;
  list->n = 0;
  for (PetscInt r = table->vertex_start[v]; r < table->vertex_start[v + 1]; r++) {
    const PetscInt f = table->vertex_row[r];
    const PetscReal *P = table->x + 4 * f + 2 * (s->m->faces.vertex[2 * f] != v);
    for (PetscInt p = table->start[f]; p < table->start[f + 1]; p++) {
      VertexNear now;
      PetscInt i = 0;
      if (!is_near(s, v, P, f, p, &now)) continue;
      while (i < list->n && list->item[i].on != now.on) i++;
      if (i == list->n) {
        PetscCall(near_push(list, &now));
        continue;
      }
      VertexNear *same = list->item + i;
      if (gid[f] < gid[same->face]) same->face = f, same->flush = now.flush;
      same->blocked = (PetscBool)(same->blocked || now.blocked);
      same->flat = (PetscBool)(same->flat || now.flat);
      same->was = (PetscBool)(same->was || now.was);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether two faces meet in a convex corner of their body. */
static PetscBool convex_corner(const Search *s, PetscInt f, PetscInt g)
{
  const PetscInt *vf = s->m->faces.vertex + 2 * f, *vg = s->m->faces.vertex + 2 * g;
  const PetscReal *a = s->table->x + 4 * f, *b = s->table->x + 4 * g;
  if (vf[1] != vg[0]) return vg[1] == vf[0] ? convex_corner(s, g, f) : PETSC_FALSE;
  return (PetscBool)((a[2] - a[0]) * (b[3] - b[1]) - (a[3] - a[1]) * (b[2] - b[0]) > 0.);
}

/* Decides, for a vertex near two faces of one body that meet in a convex corner, whether it belongs to face j
   rather than to face i. The first rule that applies decides. 1: A vertex in front of one face is not in the
   body, so it makes no new contact with the other face, behind which it lies. 2: A vertex inside both belongs
   to the face of its old contact, not to a face in which it is deep without one: a contact there would store
   energy that no motion has given. 3: It belongs to the face that one of its own faces is nearly parallel to.
   4: Close to flush faces it belongs to the face of its old contact, or to none. 5: It belongs to the nearer
   face; at a tie to the face of the lower gid. */
static PetscBool belongs_to_other(const Search *s, const VertexNear *i, const VertexNear *j)
{
  if (!convex_corner(s, i->on, j->on)) return PETSC_FALSE;
  const PetscBool over = (PetscBool)(j->t >= 0. && j->t < 1.);
  if (!i->was && over && j->gap > j->flush && i->gap < -i->flush) return PETSC_TRUE;
  if (i->was && !j->was && j->gap < -j->flush && i->gap < 0.) return PETSC_FALSE;
  if (j->was && !i->was && i->gap < -i->flush && j->gap < 0. && over) return PETSC_TRUE;
  if (j->flat != i->flat) return j->flat;
  if (j->flat && j->gap > -j->flush && i->gap > -i->flush && !(over && i->was && j->was))
    return (PetscBool)!i->was;
  if (!over) return PETSC_FALSE;
  return (PetscBool)(j->gap > i->gap ||
                     (j->gap == i->gap && s->m->faces.gid[j->on] < s->m->faces.gid[i->on]));
}

/* ---- candidates */

/* A contact as the owner of the vertex sends it to the owners of the face's ends. */
typedef struct {
  PetscInt key[2], face_gid, joint, model, index; /* index: local number of the vertex on its owner */
  PetscReal t, gap, length, drawn; /* drawn: [m] gap in the mesh of faces that were in contact as drawn */
} VertexRecord;

static PetscErrorCode push_vertex(const OldContacts *old, const VertexRecord *r, PetscInt vertex,
                                  PetscInt face, PetscInt on, CandidateList *list)
{
  PetscFunctionBeginUser;
  PetscCheck(face >= 0 && on >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "a vertex on a face not known here");
  // with tptm both ends stand at the vertex; with pt end 1 is idle
  const PetscBool both = (PetscBool)(r->model == STRESS_TPTM);
  Candidate c = {.model = (StressModelKind)r->model,
                 .key = {r->key[0], r->key[1]},
                 .face = {face, on},
                 .vertex = vertex,
                 .joint = r->joint,
                 .drawn = r->drawn,
                 .before = OldContactFind(old, r->key[0], r->key[1])};
  c.pair = (FacePair){.klass = VERTEX_FACE,
                      .t = {r->t, both ? r->t : 0.},
                      .gap = {r->gap, both ? r->gap : 0.},
                      .length = r->length};
  PetscCall(CandidatesPush(list, &c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt n, capacity;
  PetscMPIInt *to; /* (n,) */
  VertexRecord *record;
} Outbox;

/* Posts a contact to the other ranks that own an end of the face `on`. */
static PetscErrorCode post(const Model *m, PetscInt on, const VertexRecord *r, Outbox *box)
{
  PetscMPIInt last = m->rank;
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    const PetscInt v = m->faces.vertex[2 * on + k];
    const PetscMPIInt owner = v < m->mesh.n_owned ? m->rank
                                                  : (PetscMPIInt)m->ghosts.record[v - m->mesh.n_owned].owner;
    if (owner == m->rank || owner == last) continue;
    if (box->n == box->capacity) {
      box->capacity = 2 * box->capacity + 64;
      PetscCall(PetscRealloc((size_t)box->capacity * sizeof(*box->to), &box->to));
      PetscCall(PetscRealloc((size_t)box->capacity * sizeof(*box->record), &box->record));
    }
    box->to[box->n] = last = owner;
    box->record[box->n++] = *r;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides which of the near faces an owned vertex is in contact with. */
static PetscErrorCode decide(const Search *s, PetscInt v, const NearList *faces, Outbox *box,
                             CandidateList *list)
{
  const Model *m = s->m;
  const PetscInt n = faces->n;
  VertexNear *near = faces->item;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n && !near[i].blocked; j++)
      if (near[j].body == near[i].body && j != i && belongs_to_other(s, near + i, near + j))
        near[i].blocked = PETSC_TRUE;
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt f = near[i].face, g = near[i].on;
    const PetscReal *P = s->table->x + 4 * f + 2 * (m->faces.vertex[2 * f] != v);
    for (PetscInt j = 0; j < n && !near[i].blocked && !near[i].was; j++)
      if (j != i && PointIsScreened(s->table, P, g, near[j].on)) near[i].blocked = PETSC_TRUE;
    if (near[i].blocked || (!near[i].was && CornerIsHidden(s->scene, s->table, v, P, -1, g))) continue;
    // a first touch has the influence length of an end of a whole face contact, so that two corners that land
    // flat have together the length of that contact
    const PetscInt joint = near[i].before >= 0 ? s->old->contacts->joint[near[i].before]
                                               : JointOfPair(s->scene, m, f, g);
    const PetscBool moving = (PetscBool)(s->scene->joints[joint].stress_model == STRESS_TPTM);
    // pt, which puts half the length at each end, stands for all models with fixed control points
    const VertexRecord r = {.key = {m->faces.gid[g], VertexKey(m->mesh.vertex_gid[v])},
                            .face_gid = m->faces.gid[f],
                            .joint = joint,
                            .model = moving ? STRESS_TPTM : STRESS_PT,
                            .index = v,
                            .t = near[i].t,
                            .gap = near[i].gap,
                            .drawn = near[i].before < 0 ? gap_as_drawn(s, v, g) : 0.,
                            .length = PetscMin(s->table->length[f], s->table->length[g])};
    PetscCall(push_vertex(s->old, &r, v, f, g, list));
    if (m->size > 1) PetscCall(post(m, g, &r, box));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Delivers the posted contacts; every rank adds the contacts it receives to its candidates. */
static PetscErrorCode deliver(const Model *m, const OldContacts *old, const Outbox *box, CandidateList *list)
{
  const PetscMPIInt unit = (PetscMPIInt)sizeof(VertexRecord);
  PetscMPIInt *n_send, *n_receive, *at_send, *at_receive, *fill;
  VertexRecord *send, *received;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc5(m->size, &n_send, m->size, &n_receive, m->size + 1, &at_send, m->size + 1,
                         &at_receive, m->size, &fill));
  for (PetscInt i = 0; i < box->n; i++) n_send[box->to[i]] += unit;
  for (PetscMPIInt p = 0; p < m->size; p++) at_send[p + 1] = at_send[p] + n_send[p];
  PetscCall(PetscMalloc1(box->n, &send));
  for (PetscInt i = 0; i < box->n; i++)
    send[at_send[box->to[i]] / unit + fill[box->to[i]]++] = box->record[i];
  PetscCallMPI(MPI_Alltoall(n_send, 1, MPI_INT, n_receive, 1, MPI_INT, m->comm));
  for (PetscMPIInt p = 0; p < m->size; p++) at_receive[p + 1] = at_receive[p] + n_receive[p];
  PetscCall(PetscMalloc1(at_receive[m->size] / unit, &received));
  PetscCallMPI(
      MPI_Alltoallv(send, n_send, at_send, MPI_BYTE, received, n_receive, at_receive, MPI_BYTE, m->comm));
  for (PetscMPIInt p = 0; p < m->size; p++)
    for (PetscInt i = at_receive[p] / unit; i < at_receive[p + 1] / unit; i++) {
      const VertexRecord *r = received + i;
      PetscCall(push_vertex(old, r, LocalVertex(m, VertexKey(r->key[1]), p, r->index),
                            FaceRow(m, r->face_gid), FaceRow(m, r->key[0]), list));
    }
  PetscCall(PetscFree(send));
  PetscCall(PetscFree(received));
  PetscCall(PetscFree5(n_send, n_receive, at_send, at_receive, fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks the owned vertices that stood on faces. */
static void mark_stood(const Model *m, const Contacts *c, char *stood)
{
  for (PetscInt at = 0; at < c->n_padded; at++) {
    const PetscInt v = c->vertex[CONTACT_ROW(at, ROW_P)];
    if (c->key[2 * at] >= 0 && c->key[2 * at + 1] < 0 && v < m->mesh.n_owned) stood[v] = 1;
  }
}

PetscErrorCode VerticesFind(const Scene *scene, const Model *m, const OldContacts *old,
                            const FaceTable *table, CandidateList *list)
{
  Search search = {scene, m, old, table, NULL};
  NearList near = {0};
  Outbox box = {0};
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_owned, &search.stood));
  mark_stood(m, old->contacts, search.stood);
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    PetscCall(faces_near(&search, v, &near));
    PetscCall(decide(&search, v, &near, &box, list));
  }
  if (m->size > 1) PetscCall(deliver(m, old, &box, list));
  PetscCall(PetscFree(near.item));
  PetscCall(PetscFree(search.stood));
  PetscCall(PetscFree(box.to));
  PetscCall(PetscFree(box.record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* contact_verify.c: variable connectivity (sections 2.3-2.4). When blocks have moved, contacts are found anew
   in the present state; what was a contact before keeps its history.

   Vertex on a face (Fig. 5b). A face-to-face contact one end of which opens beyond the tolerance, and a
   corner that comes down on a face, are contacts of one vertex: the point model at P with an influence length
   of its own, carried over when a face contact degenerates so that the force stays, never less than
   vertex_length times the shorter face. One vertex has one contact with a face, none beside a face contact of
   one of its faces; of the two faces at a convex corner it takes the nearer. Where a corner slides over a
   joint of two flush faces it is pressed in, and must not catch on the side of the next block: within FLUSH
   tolerances of a corner only what was a contact before is one. */
#include "internal.h"
#include "contact_geometry.h"

static const PetscReal FLUSH = 0.1; /* of the contact tolerance: lower steps are not seen */

/* ---- the contacts that were */

static PetscErrorCode list_old(const Contacts *c, OldContacts *old)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(c->n, &old->list));
  old->n = 0;
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt at = c->model_start[s]; at < c->model_start[s + 1]; at++) {
      if (c->key[2 * at] < 0) continue;
      Candidate *o = old->list + old->n++;
      *o = (Candidate){.model = (StressModelKind)s,
                       .key = {c->key[2 * at], c->key[2 * at + 1]},
                       .joint = c->joint[at],
                       .vertex = at};
      o->pair.klass = c->klass[at], o->pair.length = c->length[at];
      for (int k = 0; k < 2; k++) o->pair.t[k] = c->t[SUB(at, k)];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- vertices on faces */

/* A vertex near a face. */
typedef struct {
  PetscInt key[2], face, on, vertex; /* rows of faces: that of the vertex, that it stands on */
  PetscInt gid;                      /* of `face`: rows differ from rank to rank */
  PetscReal t, gap, edge;            /* edge: [m] from the nearer end of the face, negative beyond it */
  PetscBool blocked;                 /* it cannot be a contact */
  PetscBool flat;                    /* the two faces are nearly parallel */
  PetscBool was;                     /* it, or the two faces, were a contact before */
  PetscReal flush;                   /* [m] lower steps are not seen */
} VertexNear;

/* By vertex, then face. */
static int vertex_order(const void *a, const void *b)
{
  const VertexNear *p = a, *q = b;
  if (p->key[1] != q->key[1]) return (p->key[1] > q->key[1]) - (p->key[1] < q->key[1]);
  if (p->key[0] != q->key[0]) return (p->key[0] > q->key[0]) - (p->key[0] < q->key[0]);
  return (p->gid > q->gid) - (p->gid < q->gid);
}

/* How deep a vertex may be behind a face. Behind a face of its own body it is inside, unless it has come
   there across a slit. */
static PetscReal depth_allowed(const Model *m, const OldContacts *old, PetscInt v, PetscInt f, PetscInt g,
                               PetscReal shorter)
{
  const Candidate wanted = {.model = STRESS_PT, .key = {m->faces.gid[g], -2 - m->vertex_gid[v]}};
  if (m->faces.body[f] == m->faces.body[g] && !OldContactFind(old, &wanted))
    return FACE_MIN_OVERLAP * shorter;
  return FACE_DEPTH * PetscMin(m->faces.thick[f], m->faces.thick[g]);
}

static PetscBool was_contact(const Scene *scene, const Model *m, const OldContacts *old, PetscInt v,
                             PetscInt f, PetscInt g)
{
  const Candidate wanted = {.model = STRESS_PT, .key = {m->faces.gid[g], -2 - m->vertex_gid[v]}};
  const PetscInt gid[2] = {m->faces.gid[f], m->faces.gid[g]};
  const Candidate faces = {.model = scene->joints[JointOfPair(scene, m, f, g)].stress_model,
                           .key = {PetscMin(gid[0], gid[1]), PetscMax(gid[0], gid[1])}};
  return (PetscBool)(OldContactFind(old, &wanted) || OldContactFind(old, &faces));
}

/* Both vertices of face f against face g, also a little beyond its ends. */
static PetscInt vertices_of(const Scene *scene, const Model *m, const PetscReal *u, const OldContacts *old,
                            PetscInt f, PetscInt g, PetscBool face_contact, VertexNear *list)
{
  PetscReal xf[4], xg[4], t[2], gap[2];
  PetscInt n = 0;
  FaceCoordinates(m, u, f, xf);
  FaceCoordinates(m, u, g, xg);
  for (int k = 0; k < 2; k++) face_project(xg, xg + 2, xf + 2 * k, &t[k], &gap[k]);
  const PetscReal lf = FaceLength(xf), lg = FaceLength(xg), shorter = PetscMin(lf, lg);
  const PetscReal cosine = ((xf[2] - xf[0]) * (xg[2] - xg[0]) + (xf[3] - xf[1]) * (xg[3] - xg[1])) /
                           (lf * lg);
  const PetscReal tolerance = scene->contact_tolerance * (scene->contact_relative ? shorter : 1.);
  for (int k = 0; k < 2; k++) {
    const PetscInt v = m->faces.vertex[2 * f + k];
    const PetscReal edge = PetscMin(t[k], 1. - t[k]) * lg;
    if (v == m->faces.vertex[2 * g] || v == m->faces.vertex[2 * g + 1]) continue; // its own neighbour
    if (edge < -tolerance || gap[k] > tolerance || gap[k] < -depth_allowed(m, old, v, f, g, shorter))
      continue;
    const PetscBool aside = (PetscBool)(t[k] < 0. || t[k] >= 1.);
    list[n++] = (VertexNear){.key = {m->faces.gid[g], -2 - m->vertex_gid[v]},
                             .face = f,
                             .gid = m->faces.gid[f],
                             .on = g,
                             .vertex = v,
                             .t = t[k],
                             .gap = gap[k],
                             .edge = edge,
                             .blocked = (PetscBool)(face_contact || aside),
                             .flat = (PetscBool)(cosine < -FACE_COS_LIMIT),
                             .was = was_contact(scene, m, old, v, f, g),
                             .flush = FLUSH * tolerance};
  }
  return n;
}

/* Whether two faces meet in a convex corner of their body. */
static PetscBool convex_corner(const Model *m, const PetscReal *u, PetscInt f, PetscInt g)
{
  const PetscInt *vf = m->faces.vertex + 2 * f, *vg = m->faces.vertex + 2 * g;
  PetscReal a[4], b[4];
  if (vf[1] != vg[0]) return vg[1] == vf[0] ? convex_corner(m, u, g, f) : PETSC_FALSE;
  FaceCoordinates(m, u, f, a);
  FaceCoordinates(m, u, g, b);
  return (PetscBool)((a[2] - a[0]) * (b[3] - b[1]) - (a[3] - a[1]) * (b[2] - b[0]) > 0.);
}

/* At a convex corner of the other body, whether the vertex belongs to face j rather than to face i: to the
   face that one of its own faces is nearly parallel to; close to the corner of flush faces to what was a
   contact before, or to none; else to the nearer; at a tie to that of the lower gid. */
static PetscBool belongs_to_other(const Model *m, const PetscReal *u, const VertexNear *i,
                                  const VertexNear *j)
{
  if (m->faces.body[j->on] != m->faces.body[i->on] || !convex_corner(m, u, i->on, j->on)) return PETSC_FALSE;
  if (j->flat != i->flat) return j->flat;
  const PetscBool over = (PetscBool)(j->t >= 0. && j->t < 1.);
  if (j->flat && j->gap > -j->flush && i->gap > -i->flush && !(over && i->was && j->was))
    return (PetscBool)!i->was;
  if (!over) return PETSC_FALSE;
  return (PetscBool)(j->gap > i->gap || (j->gap == i->gap && j->key[0] < i->key[0]));
}

/* Joins the entries of one vertex and face, which come from the two faces of the vertex. */
static PetscInt join_entries(PetscInt n, VertexNear *list)
{
  PetscInt kept = 0;
  if (n) qsort(list, n, sizeof(VertexNear), vertex_order);
  for (PetscInt i = 0; i < n; i++) {
    VertexNear *last = kept ? list + kept - 1 : NULL;
    if (last && last->key[0] == list[i].key[0] && last->key[1] == list[i].key[1]) {
      last->blocked = (PetscBool)(last->blocked || list[i].blocked);
      last->flat = (PetscBool)(last->flat || list[i].flat);
      last->was = (PetscBool)(last->was || list[i].was);
    } else {
      list[kept++] = list[i];
    }
  }
  return kept;
}

/* Keeps one entry per vertex and face, none that is blocked, one of the two faces at a convex corner. */
static PetscInt choose_vertices(const Model *m, const PetscReal *u, PetscInt n, VertexNear *list)
{
  PetscInt kept = 0;
  n = join_entries(n, list);
  for (PetscInt first = 0, end; first < n; first = end) { // the entries of one vertex stand together
    for (end = first; end < n && list[end].key[1] == list[first].key[1];) end++;
    for (PetscInt i = first; i < end; i++)
      for (PetscInt j = first; j < end; j++)
        if (j != i && belongs_to_other(m, u, list + i, list + j)) list[i].blocked = PETSC_TRUE;
  }
  for (PetscInt i = 0; i < n; i++)
    if (!list[i].blocked) list[kept++] = list[i];
  return kept;
}

static void vertex_candidate(const Scene *scene, const Model *m, const PetscReal *u, const VertexNear *v,
                             Candidate *c)
{
  PetscReal xf[4], xg[4];
  FaceCoordinates(m, u, v->face, xf);
  FaceCoordinates(m, u, v->on, xg);
  // the point model puts half its length at each end; the far end is idle. A first touch has the influence
  // length of an end of a whole face contact, so that two corners landing flat are one already
  *c = (Candidate){.model = STRESS_PT,
                   .key = {v->key[0], v->key[1]},
                   .face = {v->face, v->on},
                   .vertex = v->vertex,
                   .joint = JointOfPair(scene, m, v->face, v->on)};
  c->pair = (FacePair){.klass = VERTEX_FACE,
                       .t = {v->t, 0.},
                       .gap = {v->gap, 0.},
                       .length = PetscMin(FaceLength(xf), FaceLength(xg))};
}

/* ---- the whole */

/* Adds the contacts of vertices on faces to the face contacts found. */
static PetscErrorCode find_vertices(const Scene *scene, const Model *m, const PetscReal *u,
                                    const OldContacts *old, PetscInt n_near, const PetscInt *near,
                                    PetscInt *n, Candidate **list)
{
  PetscInt n_vertices = 0, n_faces = *n;
  VertexNear *v;
  PetscFunctionBeginUser;
  if (n_faces) qsort(*list, n_faces, sizeof(Candidate), CandidateOrder);
  PetscCall(PetscMalloc1(4 * n_near, &v));
  for (PetscInt p = 0; p < n_near; p++) {
    const PetscInt f = near[2 * p], g = near[2 * p + 1], a = m->faces.gid[f], b = m->faces.gid[g];
    const Candidate wanted = {.model = scene->joints[JointOfPair(scene, m, f, g)].stress_model,
                              .key = {PetscMin(a, b), PetscMax(a, b)}};
    const PetscBool face_contact = (PetscBool)(n_faces && bsearch(&wanted, *list, n_faces, sizeof(Candidate),
                                                                  CandidateOrder) != NULL);
    n_vertices += vertices_of(scene, m, u, old, f, g, face_contact, v + n_vertices);
    n_vertices += vertices_of(scene, m, u, old, g, f, face_contact, v + n_vertices);
  }
  n_vertices = choose_vertices(m, u, n_vertices, v);
  PetscCall(PetscRealloc((n_faces + n_vertices) * sizeof(Candidate), list));
  for (PetscInt i = 0; i < n_vertices; i++) vertex_candidate(scene, m, u, v + i, *list + (*n)++);
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Contacts between groups that are not upgradeable stay as they are. */
static void keep_not_upgradeable(const Scene *scene, const Model *m, const OldContacts *old, PetscInt *n,
                                 Candidate *list)
{
  PetscInt kept = 0;
  for (PetscInt i = 0; i < *n; i++) {
    const Material *a = scene->materials + m->faces.group[list[i].face[0]],
                   *b = scene->materials + m->faces.group[list[i].face[1]];
    if (!a->upgradeable && !b->upgradeable) {
      const Candidate *o = OldContactFind(old, list + i);
      if (!o) continue;
      list[i].pair.klass = o->pair.klass, list[i].pair.length = o->pair.length;
      for (int k = 0; k < 2 && o->pair.klass != VERTEX_FACE; k++) {
        list[i].pair.t[k] = o->pair.t[k];
        list[i].pair.source[k] = END_SOURCE[o->pair.klass][k],
        list[i].pair.corner[k] = END_CORNER[o->pair.klass][k];
      }
    }
    list[kept++] = list[i];
  }
  *n = kept;
}

/* Depth of a contact over its shorter face. */
static PetscReal depth_of(const Model *m, const PetscReal *u, const Candidate *n)
{
  PetscReal a[4], b[4];
  FaceCoordinates(m, u, n->face[0], a);
  FaceCoordinates(m, u, n->face[1], b);
  const PetscReal gap = n->pair.klass == VERTEX_FACE ? n->pair.gap[0]
                                                     : PetscMin(n->pair.gap[0], n->pair.gap[1]);
  return -PetscMin(gap, 0.) / PetscMin(FaceLength(a), FaceLength(b));
}

PetscErrorCode ContactsVerify(const Scene *scene, const Joint *joints, Model *m, State *state, Contacts *c,
                              StageResult *result)
{
  const PetscReal *u;
  Contacts before = *c;
  OldContacts old;
  Candidate *list, *next;
  PetscInt n, n_near, *near, count[2] = {0, 0};
  PetscReal deepest = 0.;
  PetscFunctionBeginUser;
  PetscCall(PartBegin(PART_VERIFICATION));
  PetscCall(list_old(c, &old));
  PetscCall(NeighboursUpdate(m, state));
  u = state->u + 3 * m->n_bodies;
  PetscCall(ContactsFind(scene, m, u, &old, &n, &list, &n_near, &near));
  PetscCall(find_vertices(scene, m, u, &old, n_near, near, &n, &list));
  keep_not_upgradeable(scene, m, &old, &n, list);
  PetscCall(ContactsStore(scene, m, n, list, c));
  c->rate = before.rate;
  PetscCall(ContactsInherit(scene, m, joints, u, &before, &old, list, c));
  next = list;
  for (PetscInt at = 0; at < c->n_padded; at++) {
    if (c->key[2 * at] < 0) continue;
    const Candidate *this = next++; // contacts and candidates run in one order
    const PetscBool is_new = (PetscBool)!OldContactFind(&old, this);
    deepest = PetscMax(deepest, depth_of(m, u, this));
    if (c->owned[at]) count[0] += is_new, count[1]++;
  }
  for (PetscInt i = 0; i < old.n; i++) count[1] -= before.owned[old.list[i].vertex];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPIU_REAL, MPI_MAX, m->comm));
  result->verifications++;
  result->contacts_made += count[0];
  result->contacts_lost += count[0] - count[1]; // made less the growth in number
  result->deepest = deepest;
  for (PetscInt d = 0; d < m->n_dof; d++) state->u_verified[d] = state->u[d];
  PetscCall(ContactsDestroy(&before));
  PetscCall(PetscFree(old.list));
  PetscCall(PetscFree(list));
  PetscCall(PetscFree(near));
  PetscCall(PartEnd(PART_VERIFICATION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a vertex has moved verify_after tolerances since contacts were last verified: a bound for bodies by
   their reach. far [m]: how far it has, NULL: not asked for. */
PetscErrorCode ContactsNeedVerify(const Scene *scene, const Model *m, const State *state, PetscBool *need,
                                  PetscReal *far)
{
  PetscReal moved = 0.;
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    const PetscReal *C = m->body_X + 2 * b, *u = state->u + 3 * b, *w = state->u_verified + 3 * b;
    PetscReal reach = 0.;
    for (PetscInt v = m->body_start[b]; v < m->body_start[b + 1]; v++)
      reach = PetscMax(reach, PetscHypotReal(m->X[2 * v] - C[0], m->X[2 * v + 1] - C[1]));
    moved = PetscMax(moved, PetscHypotReal(u[0] - w[0], u[1] - w[1]) + PetscAbsReal(u[2] - w[2]) * reach);
  }
  for (PetscInt d = 3 * m->n_bodies; d < m->n_dof; d += 2)
    moved = PetscMax(moved, PetscHypotReal(state->u[d] - state->u_verified[d],
                                           state->u[d + 1] - state->u_verified[d + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPIU_REAL, MPI_MAX, m->comm));
  if (far) *far = moved;
  *need = (PetscBool)(moved > scene->verify_after * m->contact_margin);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* contact_verify.c: variable connectivity (sections 2.3-2.4). When blocks have moved, contacts are found anew
   in the present state; what was a contact before keeps its history.

   What is carried over. The normal law needs nothing: u_n is the distance itself. Shear: u_e = u_s - slip,
   the elastic part at the two old ends, is a linear field along the contact; its values at the new ends are
   the new contact's (at a new end u_s = 0, since P is projected afresh, so slip = -u_e). The paper copies u_n
   and u_s from old ends to new by the table of Fig. 5; here the class only says which vertices are the ends,
   and the field does the rest: a block that slides across an edge then feels no jump. A part of a contact
   that is new has no strength left from before: it is broken.

   Vertex on a face (Fig. 5b). A face-to-face contact one end of which opens beyond the tolerance, and a
   corner that comes down on a face, are contacts of one vertex: the point model at P with an influence length
   of its own, carried over when a face contact degenerates so that the force stays, never less than
   vertex_length times the shorter face. One vertex has one contact with a face, none beside a face contact of
   one of its faces; of the two faces at a convex corner it takes the nearer. */
#include "internal.h"
#include "contact_geometry.h"

static const int SOURCE[4][2] = {
    {1, 1}, {0, 0}, {0, 1}, {1, 0}}; /* by class: face of the vertex at each end, */
static const int CORNER[4][2] = {
    {1, 0}, {0, 1}, {0, 0}, {1, 1}}; /* and which vertex; as FacePairClassify sets them */

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

static PetscReal elastic_slip(const Contacts *c, PetscInt at, int k)
{
  return c->u_s[SUB(at, k)] - c->slip[SUB(at, k)];
}

/* The old face-to-face contact of two faces (rows of faces), NULL: none. */
static const Candidate *old_face_contact(const Scene *scene, const Model *m, const OldContacts *old,
                                         PetscInt f, PetscInt g)
{
  const PetscInt a = m->faces.gid[f], b = m->faces.gid[g];
  const Candidate wanted = {.model = scene->joints[JointOfPair(scene, m, f, g)].stress_model,
                            .key = {PetscMin(a, b), PetscMax(a, b)}};
  return OldContactFind(old, &wanted);
}

/* ---- vertices on faces */

static PetscReal face_length(const PetscReal x[4])
{
  return PetscHypotReal(x[2] - x[0], x[3] - x[1]);
}

/* A vertex near a face. */
typedef struct {
  PetscInt key[2], face, on, vertex; /* rows of faces: that of the vertex, that it stands on */
  PetscReal t, gap, edge;            /* edge: [m] from the nearer end of the face, negative beyond it */
  PetscBool blocked;                 /* it cannot be a contact */
  PetscBool flat;                    /* the two faces are nearly parallel */
} VertexNear;

/* By vertex, then face. */
static int vertex_order(const void *a, const void *b)
{
  const VertexNear *p = a, *q = b;
  if (p->key[1] != q->key[1]) return (p->key[1] > q->key[1]) - (p->key[1] < q->key[1]);
  if (p->key[0] != q->key[0]) return (p->key[0] > q->key[0]) - (p->key[0] < q->key[0]);
  return (p->face > q->face) - (p->face < q->face);
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

/* Both vertices of face f against face g, also a little beyond its ends. */
static PetscInt vertices_of(const Scene *scene, const Model *m, const PetscReal *u, const OldContacts *old,
                            PetscInt f, PetscInt g, PetscBool face_contact, VertexNear *list)
{
  PetscReal xf[4], xg[4], t[2], gap[2];
  PetscInt n = 0;
  FaceCoordinates(m, u, f, xf);
  FaceCoordinates(m, u, g, xg);
  for (int k = 0; k < 2; k++) face_project(xg, xg + 2, xf + 2 * k, &t[k], &gap[k]);
  const PetscReal lf = face_length(xf), lg = face_length(xg), shorter = PetscMin(lf, lg);
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
                             .on = g,
                             .vertex = v,
                             .t = t[k],
                             .gap = gap[k],
                             .edge = edge,
                             .blocked = (PetscBool)(face_contact || aside),
                             .flat = (PetscBool)(cosine < -FACE_COS_LIMIT)};
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
   face that one of its own faces is nearly parallel to, else to the nearer; at a tie to that of the lower
   gid. Never both ways. */
static PetscBool belongs_to_other(const Model *m, const PetscReal *u, const VertexNear *i,
                                  const VertexNear *j)
{
  if (m->faces.body[j->on] != m->faces.body[i->on] || !convex_corner(m, u, i->on, j->on)) return PETSC_FALSE;
  if (j->flat != i->flat) return j->flat;
  if (j->t < 0. || j->t >= 1.) return PETSC_FALSE;
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

/* What a vertex contact takes over from before: influence length and elastic slip; 0 if there was
   nothing. */
static void vertex_history(const Scene *scene, const Model *m, const Contacts *c, const OldContacts *old,
                           const VertexNear *v, PetscReal *length, PetscReal *u_e)
{
  const Candidate wanted = {.model = STRESS_PT, .key = {v->key[0], v->key[1]}},
                  *o = OldContactFind(old, &wanted);
  if (o) {
    *length = o->pair.length;
    *u_e = elastic_slip(c, o->vertex, 0);
    return;
  }
  for (PetscInt f = 0; f < m->faces.n;
       f++) { // a face contact of one of the vertex' faces that has degenerated
    if (m->faces.vertex[2 * f] != v->vertex && m->faces.vertex[2 * f + 1] != v->vertex) continue;
    o = old_face_contact(scene, m, old, f, v->on);
    if (!o || o->pair.klass == VERTEX_FACE) continue;
    const PetscInt a = m->faces.gid[f] < m->faces.gid[v->on] ? f : v->on, b = a == f ? v->on : f;
    for (int k = 0; k < 2; k++) {
      const PetscInt row = SOURCE[o->pair.klass][k] ? b : a;
      if (m->faces.vertex[2 * row + CORNER[o->pair.klass][k]] != v->vertex) continue;
      const PetscInt at = o->vertex;
      const PetscReal N = c->F_n[SUB(at, 0)] + c->F_n[SUB(at, 1)], sigma = c->sigma[SUB(at, k)];
      *length = sigma < 0. && N < 0. ? PetscMin(2. * N / sigma, o->pair.length) : 0.;
      *u_e = elastic_slip(c, at, k);
      return;
    }
  }
  for (PetscInt i = 0; i < old->n; i++) { // it stood on the next face before
    if (old->list[i].key[1] != v->key[1]) continue;
    *length = old->list[i].pair.length;
    *u_e = elastic_slip(c, old->list[i].vertex, 0);
    return;
  }
  *length = *u_e = 0.;
}

static void vertex_candidate(const Scene *scene, const Model *m, const PetscReal *u, const VertexNear *v,
                             PetscReal length, Candidate *c)
{
  PetscReal xf[4], xg[4];
  FaceCoordinates(m, u, v->face, xf);
  FaceCoordinates(m, u, v->on, xg);
  // the point model puts half its length at each end; the far end is idle. A first touch has the influence
  // length of an end of a whole face contact, so that two corners landing flat are one already
  const PetscReal shorter = PetscMin(face_length(xf), face_length(xg));
  const PetscReal own = length > 0. ? PetscMax(length, 2. * scene->vertex_length * shorter) : shorter;
  *c = (Candidate){.model = STRESS_PT,
                   .key = {v->key[0], v->key[1]},
                   .face = {v->face, v->on},
                   .vertex = v->vertex,
                   .joint = JointOfPair(scene, m, v->face, v->on)};
  c->pair = (FacePair){.klass = VERTEX_FACE, .t = {v->t, 0.}, .gap = {v->gap, 0.}, .length = own};
}

/* ---- history of the new contacts */

static PetscBool has_strength(const Joint *j)
{
  return (PetscBool)(j->law == LAW_MOHR_COULOMB &&
                     (j->tension[0] > j->tension[1] || j->cohesion[0] > j->cohesion[1] ||
                      j->friction[0] > j->friction[1]));
}

static PetscReal along(const PetscReal a[4], const PetscReal *P)
{
  PetscReal t, gap;
  face_project(a, a + 2, P, &t, &gap);
  return t * face_length(a);
}

/* Elastic slip, rest and broken parts of a face contact, from those of the same pair before. */
static void carry_over(const Model *m, const PetscReal *u, const Contacts *before, const Candidate *o,
                       const Candidate *n, PetscInt at, const Joint *joint, Contacts *c)
{
  PetscReal x[2][4], s_old[2], s_new[2];
  for (int i = 0; i < 2; i++) FaceCoordinates(m, u, n->face[i], x[i]);
  for (int k = 0; k < 2; k++) {
    s_old[k] = along(x[0], x[SOURCE[o->pair.klass][k]] + 2 * CORNER[o->pair.klass][k]);
    s_new[k] = along(x[0], x[SOURCE[n->pair.klass][k]] + 2 * CORNER[n->pair.klass][k]);
  }
  const PetscReal span = s_old[1] - s_old[0],
                  old = (PetscReal)(PetscAbsReal(span) > 1e-9 * face_length(x[0]));
  for (int k = 0; k < 2; k++) {
    const PetscReal w = old > 0. ? PetscMax(-1., PetscMin(2., (s_new[k] - s_old[0]) / span)) : 0.5;
    const PetscReal u_e = (1. - w) * elastic_slip(before, o->vertex, 0) +
                          w * elastic_slip(before, o->vertex, 1);
    c->slip[SUB(at, k)] = -u_e;
    c->rest[SUB(at, k)] = PetscMin(0., (1. - w) * before->rest[SUB(o->vertex, 0)] +
                                           w * before->rest[SUB(o->vertex, 1)]);
    // broken up to where it was broken from this end, and wherever the contact did not reach before
    const PetscReal reach = k ? s_new[1] - s_old[1]
                              : s_old[0] - s_new[0]; // how far the contact has grown at this end
    const PetscReal part = PetscMax(0., reach) + before->broken[SUB(o->vertex, k)] * o->pair.length;
    c->broken[SUB(at, k)] = has_strength(joint) && (part > 1e-6 * n->pair.length)
                                ? PetscMin(1., part / n->pair.length)
                                : 0.;
  }
}

/* History of contact `at`, which is candidate n. */
static void give_history(const Model *m, const PetscReal *u, const Joint *joints, const Contacts *before,
                         const OldContacts *old, const Candidate *n, PetscReal vertex_slip, PetscInt at,
                         Contacts *c)
{
  const Candidate *o = OldContactFind(old, n);
  const Joint *joint = joints + n->joint;
  if (n->pair.klass == VERTEX_FACE) {
    c->slip[SUB(at, 0)] = -vertex_slip;
    c->broken[SUB(at, 0)] = has_strength(joint) ? 1. : 0.;
    c->rest[SUB(at, 0)] = 0.;
  } else if (o) {
    carry_over(m, u, before, o, n, at, joint, c);
  } else {
    for (int k = 0; k < 2; k++) {
      c->rest[SUB(at, k)] = 0.; // what met in motion has no stress-free overlap
      c->slip[SUB(at, k)] = -vertex_slip;
      c->broken[SUB(at, k)] = has_strength(joint) ? 0.5 : 0.;
    }
  }
  for (int k = 0; k < 2; k++) c->u_n[SUB(at, k)] = n->pair.gap[k] - c->rest[SUB(at, k)];
}

/* Elastic slip of an old vertex contact that a new face contact takes the place of; 0: none. */
static PetscReal slip_of_vertex(const Model *m, const Contacts *before, const OldContacts *old,
                                const Candidate *n)
{
  for (int k = 0; k < 2; k++) {
    const int source = SOURCE[n->pair.klass][k];
    const PetscInt v = m->faces.vertex[2 * n->face[source] + CORNER[n->pair.klass][k]];
    const Candidate wanted = {.model = STRESS_PT, .key = {n->key[1 - source], -2 - m->vertex_gid[v]}},
                    *o = OldContactFind(old, &wanted);
    if (o) return elastic_slip(before, o->vertex, 0);
  }
  return 0.;
}

/* ---- the whole */

/* Adds the contacts of vertices on faces to the face contacts found. slip: (n,) elastic slip by candidate. */
static PetscErrorCode find_vertices(const Scene *scene, const Model *m, const PetscReal *u,
                                    const Contacts *before, const OldContacts *old, PetscInt n_near,
                                    const PetscInt *near, PetscInt *n, Candidate **list)
{
  PetscInt n_vertices = 0, n_faces = *n;
  VertexNear *v;
  PetscReal length, u_e;
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
  for (PetscInt i = 0; i < n_vertices; i++) {
    vertex_history(scene, m, before, old, v + i, &length, &u_e);
    vertex_candidate(scene, m, u, v + i, length, *list + *n);
    (*list)[(*n)++].pair.gap[1] = u_e; // the idle end lends its place to the slip, see ContactsVerify
  }
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
        list[i].pair.source[k] = SOURCE[o->pair.klass][k], list[i].pair.corner[k] = CORNER[o->pair.klass][k];
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
  return -PetscMin(gap, 0.) / PetscMin(face_length(a), face_length(b));
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
  PetscCall(find_vertices(scene, m, u, &before, &old, n_near, near, &n, &list));
  keep_not_upgradeable(scene, m, &old, &n, list);
  PetscCall(ContactsStore(scene, m, n, list, c));
  c->rate = before.rate;
  next = list;
  for (PetscInt at = 0; at < c->n_padded; at++) {
    if (c->key[2 * at] < 0) continue;
    const Candidate *this = next++; // contacts and candidates run in one order
    const PetscBool on_vertex = (PetscBool)(this->pair.klass == VERTEX_FACE),
                    is_new = (PetscBool)!OldContactFind(&old, this);
    const PetscReal slip = on_vertex ? this->pair.gap[1]
                           : is_new  ? slip_of_vertex(m, &before, &old, this)
                                     : 0.;
    give_history(m, u, joints, &before, &old, this, slip, at, c);
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
 * their reach. */
PetscErrorCode ContactsNeedVerify(const Scene *scene, const Model *m, const State *state, PetscBool *need)
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
  *need = (PetscBool)(moved > scene->verify_after * m->contact_margin);
  PetscFunctionReturn(PETSC_SUCCESS);
}

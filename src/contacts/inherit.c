/* inherit.c: gives new contacts the history of old ones when contacts are found again (sections 2.3-2.4).

   What is carried over. The normal law needs nothing, because u_n is the distance itself. In shear the
   elastic part at the two old ends, u_e = u_s - slip, is a linear field along the contact, and the new ends
   take its values at their places. At a new end u_s = 0, since P is projected afresh, so slip = -u_e. The
   paper copies u_n and u_s from old ends to new ones by the table of Fig. 5. Here the class only says which
   vertices are the ends, and the field does the rest, so that a block that slides across an edge feels no
   jump. A new stretch of a contact has no strength left from before, so it is broken. The speed of opening,
   for dashpots, is carried over like u_e. What has not failed keeps its peak strength, also where a face
   contact becomes a vertex on a face and where this vertex lands again.

   Other sources. A new contact may follow an old one of another kind or on another face: a vertex on a face
   after a face contact that has degenerated, a vertex that has gone on to the next face, a face contact after
   a vertex that has landed flat. A rank may know the new contact but not the old one, so ranks send each
   other what their contacts inherit. Of several sources all ranks take the first by kind and key. */
#include "contacts/contacts.h"
#include "contacts/find.h"
#include "contacts/heirs.h"

static PetscReal *slip_of(const Contacts *c, int history)
{
  return history == COMMITTED ? c->slip_0 : c->slip;
}

static PetscReal *broken_of(const Contacts *c, int history)
{
  return history == COMMITTED ? c->broken_0 : c->broken;
}

static PetscReal elastic_slip(const Contacts *c, int history, PetscInt at, int k)
{
  return c->u_s[SUB(at, k)] - slip_of(c, history)[SUB(at, k)];
}

static PetscReal *closure_of(const Contacts *c, int history)
{
  return history == COMMITTED ? c->closure_0 : c->closure;
}

static PetscReal *far_of(const Contacts *c, int history)
{
  return history == COMMITTED ? c->closure_far_0 : c->closure_far;
}

static PetscReal *speeds_of(const Contacts *c, int i)
{
  return i == 0 ? c->speed : i == 1 ? c->speed_old : c->speed_now;
}

/* Carries over the plastic closure between the same faces; its lines keep their slopes. w: places of the new
   ends, on a scale where 0 and 1 are the old ends. Nothing was crushed beyond the old ends; an end that moves
   outwards keeps its own closure. */
static void carry_closure(const Contacts *before, PetscInt from, const PetscReal w[2], PetscInt at,
                          Contacts *c)
{
  for (int h = 0; h < HISTORIES; h++)
    for (int k = 0; k < 2; k++) {
      const PetscReal own = closure_of(before, h)[SUB(from, k)],
                      slope = far_of(before, h)[SUB(from, k)] - own,
                      now = own + slope * PetscMax(0., k ? 1. - w[1] : w[0]);
      if (!(own < 0. && now < 0.)) continue;
      closure_of(c, h)[SUB(at, k)] = now;
      far_of(c, h)[SUB(at, k)] = now + slope * (w[1] - w[0]);
    }
}

/* Returns the place [m] of P along the face a of this length. */
static PetscReal along(const PetscReal a[4], PetscReal length, const PetscReal *P)
{
  PetscReal t, gap;
  face_project(a, a + 2, P, &t, &gap);
  return t * length;
}

/* Returns the failed part of the end of a joint that softens. broken: before; reach: [m] by which the contact
   has grown at this end to the length `length`. The new part of the half that the end owns has no strength
   left. */
static PetscReal grown_softened(PetscReal broken, PetscReal reach, PetscReal length)
{
  const PetscReal old = PetscMin(0.5, broken);
  return reach > 1e-6 * length ? old + (0.5 - old) * PetscMin(1., 2. * reach / length) : old;
}

/* Carries over elastic slip, rest, broken parts, speed and closure of a face contact, from the old contact of
   the same pair of faces. */
static void carry_over(const FaceTable *table, const Contacts *before, const Candidate *n, PetscInt at,
                       const Joint *joint, Contacts *c)
{
  const PetscReal *x[2] = {table->x + 4 * n->face[0], table->x + 4 * n->face[1]},
                  length = table->length[n->face[0]];
  const PetscInt from = n->before, was = (PetscInt)before->klass[from], is = (PetscInt)n->pair.klass;
  const PetscReal most = PetscMax(0., PetscMax(before->rest[SUB(from, 0)], before->rest[SUB(from, 1)]));
  PetscReal s_old[2], s_new[2], place[2];
  for (int k = 0; k < 2; k++) {
    s_old[k] = along(x[0], length, x[END_SOURCE[was][k]] + 2 * END_CORNER[was][k]);
    s_new[k] = along(x[0], length, x[END_SOURCE[is][k]] + 2 * END_CORNER[is][k]);
  }
  const PetscReal span = s_old[1] - s_old[0], old = (PetscReal)(PetscAbsReal(span) > 1e-9 * length);
  for (int k = 0; k < 2; k++) {
    const PetscReal w = old > 0. ? PetscMax(-1., PetscMin(2., (s_new[k] - s_old[0]) / span)) : 0.5;
    place[k] = old > 0. ? w : k;
    for (int i = 0; i < SPEEDS; i++)
      speeds_of(c, i)[SUB(at, k)] = (1. - w) * speeds_of(before, i)[SUB(from, 0)] +
                                    w * speeds_of(before, i)[SUB(from, 1)];
    const PetscReal rest = (1. - w) * before->rest[SUB(from, 0)] + w * before->rest[SUB(from, 1)];
    c->rest[SUB(at, k)] = PetscMin(most, rest);
    // broken is what was broken from this end on, and all that the contact did not reach before
    const PetscReal reach = k ? s_new[1] - s_old[1] : s_old[0] - s_new[0]; // [m] by which it has grown here
    for (int h = 0; h < HISTORIES; h++) {
      const PetscReal u_e = (1. - w) * elastic_slip(before, h, from, 0) +
                            w * elastic_slip(before, h, from, 1);
      const PetscReal length_broken = PetscMax(0., reach) +
                                      broken_of(before, h)[SUB(from, k)] * before->length[from];
      slip_of(c, h)[SUB(at, k)] = -u_e;
      broken_of(c, h)[SUB(at, k)] = broken_of(before, h)[SUB(from, k)] >= LOOSE ? LOOSE
                                    : JointSoftens(joint) ? grown_softened(broken_of(before, h)[SUB(from, k)],
                                                                           reach, n->pair.length)
                                    : JointBreaks(joint) && (length_broken > 1e-6 * n->pair.length)
                                        ? PetscMin(1., length_broken / n->pair.length)
                                        : 0.;
    }
  }
  carry_closure(before, from, place, at, c);
}

/* ---- the same contact as before, or a new one */

/* Sets the history of a new contact that was made by an impact and inherits nothing. */
static void first_history(const Joint *joint, const Candidate *n, PetscInt at, Contacts *c)
{
  // with tptm a vertex has the diagram of a face at 20 degrees, where a face contact ends
  const PetscBool turns = (PetscBool)(n->pair.klass == VERTEX_FACE && n->model == STRESS_TPTM);
  const PetscReal open = turns ? TAN_LIMIT * n->pair.length : 0.;
  for (int k = 0; k < 2; k++) {
    c->rest[SUB(at, k)] = k ? -open : 0.; // an impact leaves no stress-free overlap
    for (int h = 0; h < HISTORIES; h++) {
      slip_of(c, h)[SUB(at, k)] = 0.;
      broken_of(c, h)[SUB(at, k)] = JointHoldsTogether(joint)      ? LOOSE
                                    : !JointBreaks(joint)          ? 0.
                                    : n->pair.klass == VERTEX_FACE ? 1.
                                                                   : 0.5;
    }
  }
}

/* Returns the number of ends that stand at the vertex on a face: two with tptm, one with pt. */
static int vertex_ends(const Candidate *n)
{
  return n->model == STRESS_TPTM ? 2 : 1;
}

/* Carries over the history of a vertex on the same face. A stress-free overlap that it inherited is removed
   when the vertex leaves the face, because this costs nothing at no force. */
static void same_vertex(const Contacts *before, const Candidate *n, const Joint *joint, PetscInt at,
                        Contacts *c)
{
  const PetscInt from = n->before;
  const PetscReal rest = before->rest[SUB(from, 0)],
                  freed = PetscMax(0., PetscMin(0., n->pair.gap[0]) - rest);
  c->length[at] = before->length[from];
  carry_closure(before, from, (const PetscReal[]){0., 1.}, at, c);
  c->rest[SUB(at, 0)] = c->rest[SUB(at, 1)] = 0.;
  for (int k = 0; k < vertex_ends(n); k++) {
    for (int i = 0; i < SPEEDS; i++) speeds_of(c, i)[SUB(at, k)] = speeds_of(before, i)[SUB(from, k)];
    c->rest[SUB(at, k)] = before->rest[SUB(from, k)] + freed;
    for (int h = 0; h < HISTORIES; h++) {
      slip_of(c, h)[SUB(at, k)] = -elastic_slip(before, h, from, k);
      broken_of(c, h)[SUB(at, k)] = broken_of(before, h)[SUB(from, k)] >= LOOSE ? LOOSE
                                    : JointBreaks(joint) ? broken_of(before, h)[SUB(from, k)]
                                                         : 0.;
    }
  }
}

/* ---- what a new contact inherits from another */

/* Makes an heir of the old contact at `from`, whose end[k] becomes end k. rest stays zero. */
static Heir heir_from(const Candidate *n, PetscInt kind, const Contacts *before, PetscInt from,
                      const int end[2])
{
  Heir heir = {.model = (PetscInt)n->model,
               .key = {n->key[0], n->key[1]},
               .kind = kind,
               .source = {before->key[2 * from], before->key[2 * from + 1]}};
  for (int k = 0; k < 2; k++) {
    for (int h = 0; h < HISTORIES; h++) {
      heir.u_e[h][k] = elastic_slip(before, h, from, end[k]);
      heir.broken[h][k] = broken_of(before, h)[SUB(from, end[k])];
      heir.closure[h][k] = closure_of(before, h)[SUB(from, end[k])];
      heir.far[h][k] = far_of(before, h)[SUB(from, end[k])];
    }
    for (int i = 0; i < SPEEDS; i++) heir.speed[i][k] = speeds_of(before, i)[SUB(from, end[k])];
  }
  return heir;
}

static PetscBool is_moving(const Contacts *c, PetscInt at)
{
  return (PetscBool)(at >= c->model_start[STRESS_TPTM]);
}

/* Decides whether the stress model derives from a potential, as pt and tptm do. */
static PetscBool has_potential(const Contacts *c, PetscInt at)
{
  return (PetscBool)(at < c->model_start[STRESS_PT + 1] || is_moving(c, at));
}

/* Returns the energy [m3] of the normal springs of a contact of pt or tptm over k_n and thickness: int u_n^2
   / 2 over the closed stretch. It follows from openings alone, for contacts that do not exist yet; stored.c
   uses the forces of existing contacts. */
static PetscReal stored_in(PetscBool moving, PetscReal length, PetscReal u_0, PetscReal u_1)
{
  const PetscReal a = PetscMax(-u_0, -u_1), b = PetscMin(-u_0, -u_1); // depth of the overlap
  if (!(a > 0.)) return 0.;
  if (!moving) return 0.25 * length * (a * a + PetscSqr(PetscMax(b, 0.)));
  return length * (b < 0. ? a * a * (a / (a - b)) : a * a + a * b + b * b) / 6.;
}

/* Adjusts broken of a tptm contact that becomes `longer` times as long; the part added at end 1 is broken. */
static void stretch_broken(PetscReal longer, PetscReal broken[2])
{
  if (broken[0] + broken[1] >= 1.) return;
  broken[0] /= longer, broken[1] = 1. - (1. - broken[1]) / longer;
}

/* Gives the vertex of end k the diagram of an old face contact of tptm, with the same force, energy and
   friction. A length below `least` is extended into what is open, at no force. Where nothing is open the
   vertex is set back so that the force stays, which takes energy. */
static void hand_diagram(const Contacts *before, PetscInt at, int k, PetscReal least, Heir *heir)
{
  const PetscReal L = before->length[at], u_n = before->u_n[SUB(at, k)], longer = PetscMax(1., least / L);
  const PetscReal delta = -u_n,
                  h = before->u_n[SUB(at, 1 - k)] - u_n; // depth at this end; excess over the other end
  PetscReal pressed = delta;
  if (longer > 1. && h < delta) {
    const PetscReal twice = 2. * delta - h; // 2 N / k_n L
    pressed = twice <= longer * longer * h ? PetscSqrtReal(h * twice) : 0.5 * (twice / longer + longer * h);
    pressed = PetscMin(pressed, delta);
  }
  heir->length = longer * L;
  heir->rest[0] = before->rest[SUB(at, k)] - (delta - pressed);
  heir->rest[1] = heir->rest[0] - longer * h;
  for (int i = 0; i < HISTORIES; i++) {
    for (int end = 0; end < 2; end++) heir->u_e[i][end] /= longer;
    stretch_broken(longer, heir->broken[i]);
  }
}

/* Does the same as hand_diagram for the other stress models: gives the vertex the length that keeps the
   force; with pt this is the force of end k alone. softens: kappa stays (softening.h). Where the length is
   below `least` the vertex is set back so that the force stays. */
static void hand_force(const Contacts *before, PetscInt at, int k, PetscReal least, PetscBool softens,
                       Heir *heir)
{
  const PetscReal sigma = before->sigma[SUB(at, k)], other = before->sigma[SUB(at, 1 - k)];
  const PetscReal fraction = at < before->model_start[STRESS_PT + 1] ? 1. : PetscMax(0., 1. + other / sigma);
  const PetscReal length = PetscMin(1., fraction) * before->length[at];
  for (int i = 0; i < HISTORIES && !softens; i++)
    heir->broken[i][0] = heir->broken[i][0] > 0. || heir->broken[i][1] >= 1. ? 1. : 0.;
  heir->length = PetscMax(length, least);
  heir->rest[0] = before->rest[SUB(at, k)] + before->u_n[SUB(at, k)] * (1. - length / heir->length);
}

/* Makes the heir of a vertex on a face from an old contact of this face with face f of the vertex. Returns
   whether there is one; so do the next functions. */
static PetscBool from_faces(const Model *m, const Joint *joints, const OldContacts *old,
                            PetscReal vertex_length, const Candidate *n, PetscInt f, Heir *heir)
{
  const Contacts *before = old->contacts;
  const PetscInt g = n->face[1], a = m->faces.gid[f] < m->faces.gid[g] ? f : g, b = a == f ? g : f;
  const PetscInt at = OldContactFind(old, m->faces.gid[a], m->faces.gid[b]);
  if (at < 0 || is_moving(before, at) != (n->model == STRESS_TPTM)) return PETSC_FALSE;
  for (int k = 0; k < 2; k++) {
    const PetscInt row = END_SOURCE[before->klass[at]][k] ? b : a;
    if (m->faces.vertex[2 * row + END_CORNER[before->klass[at]][k]] != n->vertex) continue;
    const PetscReal least = vertex_length * n->pair.length;
    const PetscReal deeper = before->u_n[SUB(at, 1 - k)] - before->u_n[SUB(at, k)];
    *heir = heir_from(n, 0, before, at, (const int[]){k, 1 - k});
    if (!(before->sigma[SUB(at, k)] < 0.)) return PETSC_FALSE;
    if (!is_moving(before, at))
      hand_force(before, at, k, 2. * least, JointSoftens(joints + n->joint), heir);
    else if (deeper > 0. || (deeper == 0. && k == 0))
      hand_diagram(before, at, k, least, heir);
    else // the other end has the whole diagram
      heir->rest[0] = heir->rest[1] = PetscMin(0., n->pair.gap[0]);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Makes the heir of a vertex on a face from the same vertex on face g of the body; it is pressed in no more
   than before. */
static PetscBool from_vertex(const Model *m, const OldContacts *old, const Candidate *n, PetscInt g,
                             Heir *heir)
{
  const Contacts *before = old->contacts;
  const PetscInt from = OldContactFind(old, m->faces.gid[g], n->key[1]);
  if (from < 0 || is_moving(before, from) != (n->model == STRESS_TPTM)) return PETSC_FALSE;
  *heir = heir_from(n, 1, before, from, (const int[]){0, 1});
  heir->length = before->length[from];
  const PetscReal *rest = before->rest, u_n = before->u_n[SUB(from, 0)];
  heir->rest[0] = PetscMin(PetscMax(0., rest[SUB(from, 0)]), n->pair.gap[0] - u_n);
  heir->rest[1] = heir->rest[0] + rest[SUB(from, 1)] - rest[SUB(from, 0)];
  return PETSC_TRUE;
}

/* Converts the broken part of a vertex that lands. broken: in, of the vertex of end k; out, of both ends of
   the face contact of this length. What the vertex of tptm does not reach is broken. A vertex of pt knows
   nothing of the other end, which has opened. softens: kappa of the vertex stays. */
static void land_broken(PetscBool moving, PetscBool softens, PetscReal length_before, PetscReal length, int k,
                        PetscReal broken[2])
{
  if (broken[k] >= LOOSE || (moving && broken[0] + broken[1] >= 1.)) return;
  if (!moving) {
    const PetscReal failed = softens ? PetscMin(0.5, broken[k]) : 0.5;
    broken[k] = broken[k] > 0. ? failed : 0., broken[1 - k] = 0.5;
    return;
  }
  const PetscReal longer = length / length_before, far = (longer - 1.) / longer + broken[1 - k] / longer;
  broken[k] = PetscMin(1., broken[k] / longer);
  broken[1 - k] = far > 1e-6 ? PetscMin(1., far) : 0.;
}

/* Makes the heir of a face contact from the vertex of its end k, which stood on the other face. */
static PetscBool from_landing(const Model *m, const Joint *joints, const OldContacts *old, const Candidate *n,
                              int k, Heir *heir)
{
  const Contacts *before = old->contacts;
  const int source = END_SOURCE[n->pair.klass][k];
  const PetscInt v = m->faces.vertex[2 * n->face[source] + END_CORNER[n->pair.klass][k]];
  const PetscInt from = OldContactFind(old, n->key[1 - source], VertexKey(m->mesh.vertex_gid[v]));
  if (from < 0) return PETSC_FALSE;
  const PetscBool moving = is_moving(before, from); // pt has one end, whose slip both ends take over
  *heir = heir_from(n, 0, before, from, (const int[]){moving ? k : 0, moving ? 1 - k : 0});
  for (int h = 0; h < HISTORIES && !moving; h++) heir->closure[h][1 - k] = heir->far[h][1 - k] = 0.;
  for (int h = 0; h < HISTORIES; h++)
    land_broken(moving, JointSoftens(joints + n->joint), before->length[from], n->pair.length, k,
                heir->broken[h]);
  heir->rest[k] = before->rest[SUB(from, 0)];
  if (moving) heir->rest[1 - k] = heir->rest[k];
  heir->stored = stored_in(moving, before->length[from], before->u_n[SUB(from, 0)],
                           moving ? before->u_n[SUB(from, 1)] : 0.);
  return PETSC_TRUE;
}

/* Returns how far [m] a face contact with openings u must be set back to store no more than `stored`. */
static PetscReal set_back(PetscBool moving, PetscReal length, const PetscReal u[2], PetscReal stored)
{
  PetscReal low = 0., high = PetscMax(0., PetscMax(-u[0], -u[1]));
  if (stored_in(moving, length, u[0], u[1]) <= stored) return 0.;
  for (int i = 0; i < 60; i++) {
    const PetscReal middle = 0.5 * (low + high);
    if (stored_in(moving, length, u[0] + middle, u[1] + middle) > stored)
      low = middle;
    else
      high = middle;
  }
  return high;
}

/* Sets back a face contact that would start under load in motion, so that it makes no energy: it stores no
   more than the vertices that have landed did. heir: the first heir of the contact, NULL: none; end: the end
   of all heirs. */
static void land(const Heir *heir, const Heir *end, const Candidate *now, PetscInt at, Contacts *c)
{
  PetscReal stored = 0.;
  for (const Heir *h = heir;
       h && h < end && h->model == heir->model && h->key[0] == heir->key[0] && h->key[1] == heir->key[1]; h++)
    if (h == heir || HeirOrder(h - 1, h)) stored += h->stored; // several ranks may send the same heir
  const PetscReal u[2] = {now->pair.gap[0] - c->rest[SUB(at, 0)], now->pair.gap[1] - c->rest[SUB(at, 1)]};
  const PetscReal back = set_back(is_moving(c, at), c->length[at], u, stored);
  for (int k = 0; k < 2; k++) c->rest[SUB(at, k)] -= back;
}

/* Gives a contact the history of its heir. A joint that has tension after failure stays loose
   (first_history): it must not pull. */
static void inherit(const Heir *heir, const Joint *joint, PetscInt at, Contacts *c)
{
  const PetscBool breaks = (PetscBool)(JointBreaks(joint) && !JointHoldsTogether(joint));
  if (heir->length > 0.) c->length[at] = heir->length;
  for (int k = 0; k < 2; k++) {
    if (c->klass[at] == VERTEX_FACE && k && !is_moving(c, at)) continue;
    for (int h = 0; h < HISTORIES; h++) {
      slip_of(c, h)[SUB(at, k)] = -heir->u_e[h][k];
      if (breaks && heir->broken[h][k] < LOOSE) broken_of(c, h)[SUB(at, k)] = heir->broken[h][k];
      if (!(heir->closure[h][k] < 0.)) continue;
      closure_of(c, h)[SUB(at, k)] = heir->closure[h][k];
      far_of(c, h)[SUB(at, k)] = heir->far[h][k];
    }
    for (int i = 0; i < SPEEDS; i++) speeds_of(c, i)[SUB(at, k)] = heir->speed[i][k];
    c->rest[SUB(at, k)] = heir->rest[k];
  }
}

/* Adds the heirs of a vertex that is new on a face: from every face of the vertex, and from every face that
   shares a vertex with the one it stands on. */
static PetscErrorCode heirs_of_vertex(const Model *m, const Joint *joints, const FaceTable *table,
                                      const OldContacts *old, PetscReal vertex_length, const Candidate *now,
                                      HeirList *heirs)
{
  const PetscInt *start = table->vertex_start, *row = table->vertex_row, v = now->vertex,
                 *ends = m->faces.vertex + 2 * now->face[1];
  Heir heir;
  PetscFunctionBeginUser;
  for (PetscInt r = start[v]; r < start[v + 1]; r++)
    if (from_faces(m, joints, old, vertex_length, now, row[r], &heir)) PetscCall(HeirsPush(heirs, &heir));
  for (int i = 0; i < 2; i++)
    for (PetscInt r = start[ends[i]]; r < start[ends[i] + 1]; r++)
      if (from_vertex(m, old, now, row[r], &heir)) PetscCall(HeirsPush(heirs, &heir));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists all that the new contacts of this rank could inherit from the old contacts that it knows. The list
   must be complete: the first heir is known only when the heirs of all ranks are there. */
static PetscErrorCode find_heirs(const Model *m, const Joint *joints, const FaceTable *table,
                                 const OldContacts *old, PetscReal vertex_length, const CandidateList *list,
                                 HeirList *heirs)
{
  Heir heir;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < list->n; i++) {
    const Candidate *now = list->item + i;
    if (now->before >= 0) continue;
    if (now->pair.klass == VERTEX_FACE) {
      PetscCall(heirs_of_vertex(m, joints, table, old, vertex_length, now, heirs));
      continue;
    }
    for (int k = 0; k < 2; k++)
      if (from_landing(m, joints, old, now, k, &heir)) PetscCall(HeirsPush(heirs, &heir));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsInherit(const Scene *scene, const Model *m, const Joint *joints,
                               const FaceTable *table, const OldContacts *old, const CandidateList *list,
                               Contacts *c)
{
  const Contacts *before = old->contacts;
  const Candidate *next = list->item;
  const PetscReal dt = before->rate > 0. ? 1. / before->rate : 0.;
  HeirList heirs = {0};
  PetscFunctionBeginUser;
  PetscCall(find_heirs(m, joints, table, old, scene->vertex_length, list, &heirs));
  PetscCall(HeirsShare(m->comm, &heirs));
  for (PetscInt at = 0; at < c->n_padded; at++) {
    if (c->key[2 * at] < 0) continue;
    const Candidate *now = next++; // contacts and candidates have one order
    const Joint *joint = joints + now->joint;
    if (now->kept) continue;
    if (now->before >= 0 && now->pair.klass == VERTEX_FACE) {
      same_vertex(before, now, joint, at, c);
    } else if (now->before >= 0) {
      carry_over(table, before, now, at, joint, c);
    } else {
      const Heir *heir = HeirOf(&heirs, now);
      first_history(joint, now, at, c);
      ContactRestAsDrawn(scene, m, now, at, c);
      if (heir) inherit(heir, joint, at, c);
      // a shorter contact is left as it is: it takes over from its neighbour as a block slides across the end
      // of a face
      if (now->pair.klass != VERTEX_FACE && before->rate != 0. && has_potential(c, at) &&
          (heir || now->pair.length > m->contact_margin))
        land(heir, heirs.item + heirs.n, now, at, c);
    }
    // u_n is the opening a step ago, from which the next evaluation of a dynamic stage finds the speed
    for (int k = 0; k < 2; k++)
      c->u_n[SUB(at, k)] = now->pair.gap[k] - c->rest[SUB(at, k)] - c->speed[SUB(at, k)] * dt;
  }
  ContactsSetTraits(m, c);
  PetscCall(PetscFree(heirs.item));
  PetscFunctionReturn(PETSC_SUCCESS);
}

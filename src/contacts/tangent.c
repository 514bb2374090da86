/* tangent.c: computes the tangent stiffness of contacts.

   With b = (P: 1, A: -(1-t), B: -t) an end opens by u_n = n.(b u) and slides by u_s = s.(b u); the
   stiffness is B' D B with D = d(F_n0, F_n1, F_s0, F_s1)/d(u_n0, u_n1, u_s0, u_s1), 4 by 4, of the stress
   model. D is unsymmetric where a joint slips by friction. D is found by differences of the stress model, so
   that no model needs a tangent of its own. At a kink (a place that is just about to slip or to open) the
   difference is taken on the softer side: slipping on, or open.

   Faces turn under the forces they carry. This is a part u/L of the stiffness. It is left out unless the
   caller asks for it: a mechanism has no other stiffness. Then joints have

     d2 u_n = -(s.dd) a' - (s.dd') a - d_n a a' - d_s a'',
     d2 u_s =  (n.dd) a' + (n.dd') a - d_s a a' + d_n a''

   times F_n and F_s, and B with

     du_n = n.dd - d_s a,   du_s = s.dd + d_n a;
     d = P - (1-t) A - t B,   e = B - A,
     a = n.de/|e|  (by which n and s turn),   a'' = -((s.de)(n.de') + (n.de)(s.de'))/|e|^2. */
#include "contacts/contacts.h"

enum { END_VERTICES = 6 }; /* P A B of both ends of a contact */

/* Computes D of joints without limits. */
static void elastic_tangent(const Joint *joint, StressModelKind model, PetscReal length, PetscReal D[16])
{
  PetscReal a, b;
  StressModelElastic(model, &a, &b);
  for (int row = 0; row < 4; row++)
    for (int column = 0; column < 4; column++)
      D[4 * row + column] = row / 2 != column / 2
                                ? 0.
                                : (row / 2 ? joint->k_s : joint->k_n) * length * (row == column ? a : b);
}

/* Returns the point from which an evaluation of contact i starts: the committed history, or the history of
   the last evaluation. */
static ContactPoint point_of(const Contacts *c, PetscInt i, PetscBool committed)
{
  ContactPoint p = {.margin = c->margin,
                    .in_time = (PetscBool)(c->rate != 0. || c->friction == FRICTION_SPRINGS)};
  for (int k = 0; k < 2; k++) {
    const PetscInt at = SUB(i, k);
    p.u_n[k] = c->u_n[at], p.u_s[k] = c->u_s[at];
    p.slip[k] = committed ? c->slip_0[at] : c->slip[at];
    p.broken[k] = committed ? c->broken_0[at] : c->broken[at];
    p.closure[k] = committed ? c->closure_0[at] : c->closure[at];
    p.closure_far[k] = committed ? c->closure_far_0[at] : c->closure_far[at];
  }
  return p;
}

/* Computes D by differences of the end forces of a contact, one column for each of u_n0, u_n1, u_s0, u_s1.
   opens: 1 where the ends open on, -1 where they close. */
static void tangent_at(const Joint *joint, StressModelKind model, PetscReal length, const ContactPoint *from,
                       PetscReal opens, PetscReal D[16])
{
  ContactPoint p = *from, q[4] = {*from, *from, *from, *from};
  PetscReal size = 0., h[4];
  for (int k = 0; k < 2; k++)
    size = PetscMax(size, PetscMax(PetscAbsReal(p.u_n[k]), PetscAbsReal(p.u_s[k] - p.slip[k])));
  const PetscReal step = PetscMax(1e-7 * size, 1e-18);
  StressModelRespond(model, joint, length, &p);
  for (int column = 0; column < 4; column++) {
    const int end = column % 2;
    h[column] = column / 2 ? p.tau[end] < 0. ? -step : step : opens * step;
    if (column / 2)
      q[column].u_s[end] += h[column];
    else
      q[column].u_n[end] += h[column];
  }
  StressModelRespondAll(model, joint, length, 4, q);
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++)
      D[4 * row + column] = (row / 2 ? q[column].F_s[row % 2] - p.F_s[row % 2]
                                     : q[column].F_n[row] - p.F_n[row]) /
                            h[column];
}

/* Decides whether the joint of a contact holds elastically and is not broken or crushed. */
static PetscBool is_elastic(const Joint *joint, const ContactPoint *p)
{
  PetscReal sigma[2], tau[2];
  for (int k = 0; k < 2; k++)
    sigma[k] = joint->k_n * p->u_n[k], tau[k] = joint->k_s * (p->u_s[k] - p->slip[k]);
  return (PetscBool)JointIsElastic(joint, p->margin, sigma, tau, p->broken, p->closure);
}

/* Computes D of motions so small that closed places stick and open places stay open: the joint has unlimited
   shear strength, and its springs start at the present slip. The change of the shear force with the closed
   length is left out, because it is not symmetric. */
static void small_tangent(const Joint *joint, StressModelKind model, const Contacts *c, PetscInt i,
                          PetscReal D[16])
{
  static const PetscReal most = 1e20; // [Pa], [-]
  ContactPoint p = point_of(c, i, PETSC_FALSE);
  Joint sticks = *joint;
  for (int k = 0; k < 2; k++) {
    sticks.cohesion[k] = sticks.tan_phi[k] = most;
    if (ContactTouches(c, i, k)) p.u_n[k] = 0.;
  }
  if (is_elastic(&sticks, &p)) {
    elastic_tangent(joint, model, c->length[i], D);
    return;
  }
  // a joint that softens does so no further: a crack that pulls has the stiffness with which it closes
  tangent_at(&sticks, model, c->length[i], &p, JointSoftens(joint) ? -1. : 1., D);
  for (int row = 0; row < 4; row++)
    for (int column = 0; column <= row; column++) {
      const PetscReal mean = 0.5 * (D[4 * row + column] + D[4 * column + row]);
      D[4 * row + column] = D[4 * column + row] = row / 2 == column / 2 ? mean : 0.;
    }
}

static void tangent_of(const Joint *joint, StressModelKind model, const Contacts *c, PetscInt i,
                       TangentKind kind, PetscReal D[16])
{
  const ContactPoint p = point_of(c, i, PETSC_TRUE);
  if (kind == TANGENT_SMALL)
    small_tangent(joint, model, c, i, D);
  else if (kind == TANGENT_ELASTIC || is_elastic(joint, &p))
    elastic_tangent(joint, model, c->length[i], D);
  else
    tangent_at(joint, model, c->length[i], &p, 1., D);
}

/* Adds the effect of the rotation of the destination edge of one end (head of this file). Adds to its rows of
   B, which have n.dd and s.dd so far, and to k, 6 by 6 on P A B in rows of 2 END_VERTICES. inverse: 1/|e|. */
static void add_turning(const Model *m, const Contacts *c, PetscInt at, const PetscReal n[2],
                        const PetscReal s[2], PetscReal inverse, PetscReal B_n[6], PetscReal B_s[6],
                        PetscReal *k)
{
  const PetscReal d_n = c->u_n[at] + c->rest[at], d_s = c->u_s[at], F_n = m->materials.thickness * c->F_n[at],
                  F_s = m->materials.thickness * c->F_s[at];
  PetscReal a[6] = {0.}, stretch[6] = {0.}; // n.de/|e|, s.de/|e|
  for (int x = 0; x < 2; x++) {
    a[2 + x] = -n[x] * inverse, a[4 + x] = n[x] * inverse;
    stretch[2 + x] = -s[x] * inverse, stretch[4 + x] = s[x] * inverse;
  }
  for (int p = 0; p < 6; p++)
    for (int q = 0; q < 6; q++) {
      const PetscReal aa = a[p] * a[q], twist = -(stretch[p] * a[q] + a[p] * stretch[q]);
      k[2 * END_VERTICES * p + q] += F_n * (-B_s[p] * a[q] - B_s[q] * a[p] - d_n * aa - d_s * twist) +
                                     F_s * (B_n[p] * a[q] + B_n[q] * a[p] - d_s * aa + d_n * twist);
    }
  for (int p = 0; p < 6; p++) B_n[p] -= d_s * a[p], B_s[p] += d_n * a[p];
}

/* Computes B' D B of contact i: 12 by 12 on its six vertices P0 A0 B0 P1 A1 B1. force: [N] on these vertices.
   u: NULL: faces stand as in the reference state. */
static void contact_stiffness(const Model *m, const Contacts *c, PetscInt i, const PetscReal *u,
                              PetscBool turns, const PetscReal D[16], PetscInt vertices[END_VERTICES],
                              PetscReal force[2 * END_VERTICES], PetscReal k[4 * END_VERTICES * END_VERTICES])
{
  PetscReal B[4][2 * END_VERTICES] = {{0.}}; // rows u_n0, u_n1, u_s0, u_s1
  PetscArrayzero(k, 4 * END_VERTICES * END_VERTICES);
  for (int e = 0; e < 2; e++) {
    PetscInt *v = vertices + 3 * e;
    ContactEndVertices(c, i, e, v);
    if (v[0] == v[1]) continue;        // nothing at the other end of a vertex on a face
    const PetscInt P = v[1], Q = v[2]; // of the destination edge
    const PetscReal t = c->t[SUB(i, e)], b[3] = {1., -(1. - t), -t};
    PetscReal d[2];
    for (int x = 0; x < 2; x++)
      d[x] = m->mesh.X[2 * Q + x] - m->mesh.X[2 * P + x] + (u ? u[2 * Q + x] - u[2 * P + x] : 0.);
    const PetscReal inverse = 1. / PetscHypotReal(d[0], d[1]), along[2] = {d[0] * inverse, d[1] * inverse},
                    normal[2] = {along[1], -along[0]};
    for (int a = 0; a < 3; a++)
      for (int x = 0; x < 2; x++) {
        B[e][2 * (3 * e + a) + x] = b[a] * normal[x];
        B[2 + e][2 * (3 * e + a) + x] = b[a] * along[x];
      }
    if (turns)
      add_turning(m, c, SUB(i, e), normal, along, inverse, B[e] + 6 * e, B[2 + e] + 6 * e,
                  k + 6 * e * (2 * END_VERTICES + 1));
  }
  for (int p = 0; p < 2 * END_VERTICES; p++) {
    force[p] = 0.;
    for (int e = 0; e < 2; e++)
      force[p] += m->materials.thickness * (B[e][p] * c->F_n[SUB(i, e)] + B[2 + e][p] * c->F_s[SUB(i, e)]);
    const int e = p / 6;          // the other end has nothing in its columns of B
    for (int f = 0; f < 2; f++) { // B D, columns u_n and u_s of end f
      const PetscReal *D_n = D + 4 * e + f, *D_s = D_n + 8, *B_n = B[f] + 6 * f, *B_s = B[2 + f] + 6 * f;
      const PetscReal w[4] = {B[e][p] * D_n[0], B[e][p] * D_n[2], B[2 + e][p] * D_s[0], B[2 + e][p] * D_s[2]};
      PetscReal *row = k + 2 * END_VERTICES * p + 6 * f;
      for (int q = 0; q < 6; q++)
        row[q] += m->materials.thickness * (w[0] * B_n[q] + w[1] * B_s[q] + w[2] * B_n[q] + w[3] * B_s[q]);
    }
  }
}

/* Adds the couplings of the rows P A B Q of all contacts, on every rank that has the contact. */
static PetscErrorCode couplings(const Contacts *c, TermAdd add, void *context)
{
  PetscInt vertices[CONTACT_ROWS];
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0) continue; // padding
    for (int row = 0; row < CONTACT_ROWS; row++) vertices[row] = c->vertex[CONTACT_ROW(i, row)];
    PetscCall(add(CONTACT_ROWS, vertices, NULL, NULL, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode add_contact(const Instant *at, TangentKind kind, StressModelKind model, PetscInt i,
                                  TermAdd add, void *context)
{
  const Model *m = at->m;
  const Contacts *c = at->contacts;
  const Joint *joint = at->joints + c->joint[i];
  const PetscBool moved = (PetscBool)(kind != TANGENT_ELASTIC && m->materials.strain == STRAIN_LARGE),
                  turns = (PetscBool)((kind == TANGENT_TURNED || kind == TANGENT_SMALL) && moved);
  PetscInt vertices[END_VERTICES];
  PetscReal D[16], force[2 * END_VERTICES], k[4 * END_VERTICES * END_VERTICES];
  PetscFunctionBeginUser;
  tangent_of(joint, model, c, i, kind, D);
  contact_stiffness(m, c, i, moved ? at->u : NULL, turns, D, vertices, force, k);
  PetscCall(add(END_VERTICES, vertices, k, turns ? force : NULL, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsTangent(const Instant *at, TangentKind kind, TermAdd add, void *context)
{
  const Contacts *c = at->contacts;
  PetscFunctionBeginUser;
  if (kind == TANGENT_PATTERN) {
    PetscCall(couplings(c, add, context));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int model = 0; model < STRESS_MODELS; model++)
    for (PetscInt i = c->model_start[model]; i < c->model_start[model + 1]; i++)
      if (c->key[2 * i] >= 0 && c->owned[i]) // not padding; another rank adds the others
        PetscCall(add_contact(at, kind, (StressModelKind)model, i, add, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* body_motion.c: finds which macroblocks overturn, fall or slide out of their place in a dynamic stage, and
   when. Bodies that supports hold are not judged. All numbers have the same bits on any number of ranks. */
#include "result/result.h"
#include "base/reproducible.h"

static const PetscReal SLID =
    0.1; /* fraction of the width of a body by which each of its vertices has moved */
static const PetscReal REAL_TURN = 0.25; /* fraction of the rotation from lying flat to balance */
static const PetscReal FALLEN =
    0.5; /* fraction of the height of a body by which its mass centre has fallen */

/* ---- centres and rotations, by sums over vertices and rigid bodies */

/* Computes the first moment [kg m] of the mass of a degree of freedom along its axis. u NULL: in the
   reference state. Returns FALSE for a rotation. */
static PetscBool moment_of_dof(const Model *m, const PetscReal *u, PetscInt d, int *axis, PetscReal *moment)
{
  const PetscInt at = 3 * m->rigid.n;
  *axis = (int)(d < at ? d % 3 : (d - at) % 2);
  if (*axis == 2) return PETSC_FALSE;
  *moment = DofMass(m, d) *
            ((d < at ? m->rigid.X[2 * (d / 3) + *axis] : m->mesh.X[d - at]) + (u ? u[d] : 0.));
  return PETSC_TRUE;
}

/* Returns whether a degree of freedom counts by itself. Vertices of a rigid body count with the body. */
static PetscBool counts(const Model *m, PetscInt d)
{
  return (PetscBool)(d < m->n_dof || d >= 3 * m->rigid.n + 2 * m->mesh.n_moving);
}

/* Collective. Finds the mass centre of each macroblock from the first n degrees of freedom: n_dof, or with
   the inside of condensed bodies. mass: (n_bodies_global,) [kg]; NULL: not wanted. */
static PetscErrorCode find_centres(const Model *m, const PetscReal *u, PetscInt n, PetscReal *centre,
                                   PetscReal *mass)
{
  const PetscInt nb = m->mesh.n_bodies_global;
  PetscReal *sum, moment, top[2] = {1e-290, 1e-290};
  int axis;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(6 * nb, &sum)); // by body: moments x, y, mass; two bins each
  for (PetscInt d = 0; d < n; d++)
    if (counts(m, d) && moment_of_dof(m, u, d, &axis, &moment)) {
      top[0] = PetscMax(top[0], PetscAbsReal(moment));
      top[1] = PetscMax(top[1], DofMass(m, d));
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 2, MPIU_REAL, MPI_MAX, m->comm));
  const Bins moments = BinsFor(top[0]), masses = BinsFor(top[1]);
  for (PetscInt d = 0; d < n; d++)
    if (counts(m, d) && moment_of_dof(m, u, d, &axis, &moment)) {
      PetscReal *body = sum + 6 * DofBody(m, d);
      BinAdd(&moments, moment, body + 2 * axis);
      if (axis == 0) BinAdd(&masses, DofMass(m, d), body + 4);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(6 * nb), MPIU_REAL, MPI_SUM, m->comm));
  for (PetscInt i = 0; i < 2 * nb; i++) {
    const PetscReal *body = sum + 6 * (i / 2), M = body[4] + body[5];
    centre[i] = M > 0. ? (body[2 * (i % 2)] + body[2 * (i % 2) + 1]) / M : 0.;
  }
  for (PetscInt b = 0; b < nb && mass; b++) mass[b] = sum[6 * b + 4] + sum[6 * b + 5];
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BodyCentres(const Model *m, const PetscReal *u, PetscReal *centre)
{
  PetscFunctionBeginUser;
  PetscCall(find_centres(m, u, m->n_dof, centre, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the terms of rigid body or deformable vertex i in the sums of m r x (r + d) and m r . (r + d). r
   is its place from the mass centre of its macroblock in the reference state, d its displacement. Returns the
   macroblock. */
static PetscInt turn_terms(const Model *m, const PetscReal *u, const PetscReal *centre, PetscInt i,
                           PetscReal term[2])
{
  const PetscBool rigid = (PetscBool)(i < m->rigid.n);
  const PetscInt v = i - m->rigid.n, body = rigid ? m->rigid.body[i] : m->mesh.vertex_body[v];
  const PetscReal *X = rigid ? m->rigid.X + 2 * i : m->mesh.X + 2 * v;
  const PetscReal *d = rigid ? u + 3 * i : u + 3 * m->rigid.n + 2 * v;
  const PetscReal r[2] = {X[0] - centre[2 * body], X[1] - centre[2 * body + 1]};
  const PetscReal mass = rigid ? m->rigid.mass[2 * i] : m->vertex_mass[v];
  const PetscReal inertia = rigid ? m->rigid.mass[2 * i + 1] : 0., angle = rigid ? d[2] : 0.;
  term[0] = mass * (r[0] * d[1] - r[1] * d[0]) + inertia * sin(angle);
  term[1] = mass * (r[0] * (r[0] + d[0]) + r[1] * (r[1] + d[1])) + inertia * cos(angle);
  return body;
}

/* Collective. Finds the rotation [rad] (n_bodies_global,) of each macroblock since the mesh that fits its
   vertices best. */
static PetscErrorCode body_turns(const Model *m, const PetscReal *u, const PetscReal *centre, PetscReal *turn)
{
  const PetscInt nb = m->mesh.n_bodies_global, n = m->rigid.n + m->mesh.n_deformable;
  PetscReal *sum, term[2], top = 1e-290;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(4 * nb, &sum));
  for (PetscInt i = 0; i < n; i++) {
    turn_terms(m, u, centre, i, term);
    top = PetscMax(top, PetscMax(PetscAbsReal(term[0]), PetscAbsReal(term[1])));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPIU_REAL, MPI_MAX, m->comm));
  const Bins bins = BinsFor(top);
  for (PetscInt i = 0; i < n; i++) {
    PetscReal *of_body = sum + 4 * turn_terms(m, u, centre, i, term);
    for (int k = 0; k < 2; k++) BinAdd(&bins, term[k], of_body + 2 * k);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(4 * nb), MPIU_REAL, MPI_SUM, m->comm));
  for (PetscInt b = 0; b < nb; b++)
    turn[b] = atan2(sum[4 * b] + sum[4 * b + 1], sum[4 * b + 2] + sum[4 * b + 3]);
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the angle of balance */

typedef struct {
  PetscInt body, group;
  PetscReal X[2];
} Corner;

static int compare_corners(const void *left, const void *right)
{
  const Corner *a = left, *b = right;
  if (a->body != b->body) return a->body < b->body ? -1 : 1;
  for (int k = 0; k < 2; k++)
    if (a->X[k] != b->X[k]) return a->X[k] < b->X[k] ? -1 : 1;
  return 0;
}

static PetscReal turn_of(const PetscReal *a, const PetscReal *b, const PetscReal *c)
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Finds the convex hull of n corners that are in order of x, then y. hull: room for 2 n, receives its
   corners counter-clockwise. Returns their number. */
static PetscInt convex_hull(PetscInt n, const Corner *corner, const PetscReal **hull)
{
  PetscInt h = 0;
  for (PetscInt i = 0; i < n; i++) { // lower side
    while (h > 1 && turn_of(hull[h - 2], hull[h - 1], corner[i].X) <= 0.) h--;
    hull[h++] = corner[i].X;
  }
  for (PetscInt i = n - 2, least = h + 1; i >= 0; i--) { // upper side
    while (h >= least && turn_of(hull[h - 2], hull[h - 1], corner[i].X) <= 0.) h--;
    hull[h++] = corner[i].X;
  }
  return PetscMax(h - 1, 1);
}

/* Returns the rotation [rad] between the two balances that lays a body flat, on the side that bears it. */
static PetscReal flat_rotation(PetscInt n, const PetscReal *const *hull, const PetscReal C[2],
                               const PetscReal balance[2])
{
  PetscReal flat = 0., lowest = PETSC_INFINITY;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *a = hull[i], *b = hull[(i + 1) % n], e[2] = {b[0] - a[0], b[1] - a[1]};
    const PetscReal height = turn_of(a, b, C) / PetscSqrtReal(e[0] * e[0] + e[1] * e[1]);
    PetscReal angle = -atan2(e[1], e[0]); // the hull runs anticlockwise: its lowest side to the right
    if (angle >= balance[0]) angle -= 2. * PETSC_PI;
    if (angle <= -balance[1]) angle += 2. * PETSC_PI;
    if (angle < balance[0] && angle > -balance[1] && height < lowest) lowest = height, flat = angle;
  }
  return flat;
}

/* Finds the rotations [rad] of a body, anticlockwise and clockwise, to its first balance. A body that turns
   on level ground stands highest where its mass centre is right above a corner of its hull; beyond that place
   it falls on another side. A body that others hold, such as a stone of an arch, may be close to such a place
   in the mesh. So a rotation is at least REAL_TURN of the rotation from the place where the body would lie
   flat. */
static void find_balance(PetscInt n, const PetscReal *const *hull, const PetscReal C[2], PetscReal balance[2])
{
  const PetscReal least = 1e-6;
  balance[0] = balance[1] = 2. * PETSC_PI;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal r[2] = {hull[i][0] - C[0], hull[i][1] - C[1]}, square = r[0] * r[0] + r[1] * r[1];
    PetscBool peak = PETSC_TRUE;
    for (int k = -1; k < 2; k += 2) { // its neighbours stand clear of the ground then
      const PetscReal *w = hull[(i + k + n) % n];
      if ((w[0] - C[0]) * r[0] + (w[1] - C[1]) * r[1] >= square * (1. - 1e-9)) peak = PETSC_FALSE;
    }
    PetscReal angle = -0.5 * PETSC_PI - atan2(r[1], r[0]); // the rotation that points r downwards
    if (angle < 0.) angle += 2. * PETSC_PI;
    if (!peak || angle < least || angle > 2. * PETSC_PI - least) continue;
    balance[0] = PetscMin(balance[0], angle);
    balance[1] = PetscMin(balance[1], 2. * PETSC_PI - angle);
  }
  const PetscReal flat = n > 1 ? flat_rotation(n, hull, C, balance) : 0.;
  balance[0] = PetscMax(balance[0], REAL_TURN * (balance[0] - flat));
  balance[1] = PetscMax(balance[1], REAL_TURN * (balance[1] + flat));
}

/* Collective. Finds the angles of balance, on rank 0, from the outer corners of the bodies that are judged,
   and gives them to all ranks. */
static PetscErrorCode find_balances(const Model *m, BodyMotion *b)
{
  Corner *mine, *all;
  PetscReal *centre;
  const PetscReal **hull;
  PetscInt n = 0, n_all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * b->n, &centre));
  PetscCall(find_centres(m, NULL, ModelApplied(m), centre, b->mass));
  PetscCall(PetscMalloc1(m->faces.n_local, &mine));
  for (PetscInt f = 0; f < m->faces.n_local; f++) { // a face begins at each outer vertex
    const PetscInt v = m->faces.vertex[2 * f];
    if (v < m->mesh.n_owned && b->size[2 * m->faces.body[f]] > 0.)
      mine[n++] = (Corner){m->faces.body[f], m->faces.group[f], {m->mesh.X[2 * v], m->mesh.X[2 * v + 1]}};
  }
  PetscCall(GatherAndFree(m->comm, n, sizeof(Corner), mine, &n_all, (void **)&all));
  if (!m->rank) {
    PetscCall(PetscMalloc1(2 * n_all, &hull));
    qsort(all, (size_t)n_all, sizeof(Corner), compare_corners);
    for (PetscInt first = 0, end; first < n_all; first = end) {
      const PetscInt body = all[first].body;
      for (end = first; end < n_all && all[end].body == body; end++) continue;
      const PetscInt h = convex_hull(end - first, all + first, hull);
      find_balance(h, hull, centre + 2 * body, b->balance + 2 * body);
      b->group[body] = all[first].group;
    }
    PetscCall(PetscFree(hull));
    PetscCall(PetscFree(all));
  }
  PetscCall(PetscFree(centre));
  PetscCallMPI(MPI_Bcast(b->balance, (PetscMPIInt)(2 * b->n), MPIU_REAL, 0, m->comm));
  PetscCallMPI(MPI_Bcast(b->group, (PetscMPIInt)b->n, MPIU_INT, 0, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sizes and displacements */

/* Collective. Finds the width and height [m] of each macroblock in the mesh; 0 for a body that a support
   holds. */
static PetscErrorCode find_sizes(const Model *m, BodyMotion *b)
{
  PetscReal *far; // (n,5) - low x, y, high x, y, whether a support holds it
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(5 * b->n, &far));
  for (PetscInt i = 0; i < 5 * b->n; i++) far[i] = i % 5 == 4 ? 0. : -INFINITY;
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    for (int k = 0; k < 2; k++) {
      PetscReal *low = far + 5 * m->mesh.vertex_body[v] + k;
      low[0] = PetscMax(low[0], -m->mesh.X[2 * v + k]), low[2] = PetscMax(low[2], m->mesh.X[2 * v + k]);
    }
  for (PetscInt d = 0; d < ModelApplied(m); d++)
    if (Held(m, d)) far[5 * DofBody(m, d) + 4] = 1.;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, far, (PetscMPIInt)(5 * b->n), MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < 2 * b->n; i++) {
    const PetscReal *of_body = far + 5 * (i / 2);
    b->size[i] = of_body[4] > 0. ? 0. : of_body[i % 2] + of_body[2 + i % 2];
  }
  PetscCall(PetscFree(far));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds how far [m] supports have moved the ground along x and y: the middle between the least
   and the largest displacement of the degrees of freedom they hold. */
static PetscErrorCode find_ground_motion(const Model *m, const PetscReal *u, PetscReal carried[2])
{
  const PetscInt at = 3 * m->rigid.n;
  PetscReal far[4] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY}; // - least, largest
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscInt k = d < at ? d % 3 : (d - at) % 2;
    if (k == 2 || !Held(m, d)) continue;
    far[k] = PetscMax(far[k], -u[d]), far[2 + k] = PetscMax(far[2 + k], u[d]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, far, 4, MPIU_REAL, MPI_MAX, m->comm));
  for (int k = 0; k < 2; k++) carried[k] = far[k] > -INFINITY ? 0.5 * (far[2 + k] - far[k]) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds for each macroblock the distance [m] (n,) over the ground of its vertex that has moved
   least. */
static PetscErrorCode least_moved(const Model *m, const PetscReal *u, const PetscReal carried[2], PetscInt n,
                                  PetscReal *least)
{
  const PetscReal *of_vertex = u + 3 * m->rigid.n;
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < n; b++) least[b] = INFINITY;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++) {
    const PetscReal d[2] = {of_vertex[2 * v] - carried[0], of_vertex[2 * v + 1] - carried[1]};
    const PetscInt b = m->mesh.vertex_body[v];
    least[b] = PetscMin(least[b], PetscSqrtReal(d[0] * d[0] + d[1] * d[1]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, least, (PetscMPIInt)n, MPIU_REAL, MPI_MIN, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life */

PetscErrorCode BodyMotionCreate(const Model *m, BodyMotion *b)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(BodyMotionDestroy(b));
  b->n = n;
  PetscCall(PetscMalloc1(2 * n, &b->centre));
  PetscCall(PetscCalloc1(2 * n, &b->balance));
  PetscCall(PetscMalloc1(n, &b->mass));
  PetscCall(PetscMalloc1(2 * n, &b->size));
  PetscCall(PetscMalloc1(BODY_FATES * n, &b->since));
  PetscCall(PetscCalloc1(2 * n, &b->moved));
  PetscCall(PetscCalloc1(n, &b->turned));
  PetscCall(PetscCalloc1(n, &b->group));
  for (PetscInt i = 0; i < BODY_FATES * n; i++) b->since[i] = INFINITY;
  PetscCall(BodyCentres(m, NULL, b->centre));
  PetscCall(find_sizes(m, b));
  PetscCall(find_balances(m, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BodyMotionDestroy(BodyMotion *b)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(b->centre));
  PetscCall(PetscFree(b->balance));
  PetscCall(PetscFree(b->mass));
  PetscCall(PetscFree(b->size));
  PetscCall(PetscFree(b->since));
  PetscCall(PetscFree(b->moved));
  PetscCall(PetscFree(b->turned));
  PetscCall(PetscFree(b->group));
  b->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BodyMotionSample(const Model *m, const State *s, BodyMotion *b)
{
  PetscReal *least, carried[2];
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->n, &least));
  PetscCall(find_ground_motion(m, s->u, carried));
  PetscCall(least_moved(m, s->u, carried, b->n, least));
  PetscCall(BodyCentres(m, s->u, b->moved));
  PetscCall(body_turns(m, s->u, b->centre, b->turned));
  for (PetscInt i = 0; i < b->n; i++) {
    PetscReal *moved = b->moved + 2 * i, *since = b->since + BODY_FATES * i;
    for (int k = 0; k < 2; k++) moved[k] -= b->centre[2 * i + k] + carried[k];
    if (!(b->size[2 * i] > 0.)) continue;
    const PetscBool left = (PetscBool)(least[i] > SLID * b->size[2 * i]);
    const PetscBool down = (PetscBool)(left && -moved[1] > FALLEN * b->size[2 * i + 1]);
    const PetscBool over = (PetscBool)(b->turned[i] > b->balance[2 * i] ||
                                       -b->turned[i] > b->balance[2 * i + 1]);
    if (left && since[BODY_SLID] > s->time) since[BODY_SLID] = s->time;
    if (down && since[BODY_FALLEN] > s->time) since[BODY_FALLEN] = s->time;
    if (over && since[BODY_OVERTURNED] > s->time) since[BODY_OVERTURNED] = s->time;
  }
  PetscCall(PetscFree(least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the first macroblock with this fate, or -1. n receives how many have it. */
static PetscInt first_with(const BodyMotion *b, BodyFate fate, PetscInt *n)
{
  PetscInt first = -1;
  *n = 0;
  for (PetscInt i = 0; i < b->n; i++) {
    const PetscReal since = b->since[BODY_FATES * i + fate];
    if (!(since < INFINITY)) continue;
    (*n)++;
    if (first < 0 || since < b->since[BODY_FATES * first + fate]) first = i;
  }
  return first;
}

/* ---- bodies that pass through each other, because their contacts stay as they were at the start */

PetscErrorCode BodiesLoose(const Problem *p)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const BodyMotion *b = &p->found->bodies;
  PetscInt *touches, first = -1, n = 0, vertex[3];
  PetscFunctionBeginUser;
  if (b->n < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(b->n, &touches));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] == -1) continue; // a padding lane
    ContactEndVertices(c, i, 0, vertex);
    for (int k = 0; k < 2; k++) touches[m->mesh.vertex_body[vertex[k]]] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, touches, (PetscMPIInt)b->n, MPIU_INT, MPI_MAX, m->comm));
  for (PetscInt i = b->n - 1; i >= 0; i--)
    if (!touches[i] && b->size[2 * i] > 0.) first = i, n++;
  PetscCall(PetscFree(touches));
  if (n)
    PetscCall(WarnAll(m->comm,
                      "stage %s: connectivity is fixed, and %" PetscInt_FMT
                      " macroblock%s with no contact will pass through whatever %s (first %" PetscInt_FMT
                      ", %s): use contact.connectivity: variable",
                      p->stage->name, n, Plural(n), n == 1 ? "it meets" : "they meet", first,
                      m->materials.names[b->group[first]]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the deepest closure [m] of a contact. */
static PetscErrorCode deepest_closure(const Problem *p, PetscReal *closure)
{
  const Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  *closure = 0.;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && c->key[2 * i] != -1; k++) *closure = PetscMax(*closure, -c->u_n[SUB(i, k)]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, closure, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BodiesPassed(const Problem *p, char message[MESSAGE_LENGTH])
{
  const Model *m = p->m;
  MeshFields mesh;
  PetscReal closure, *u = NULL;
  PetscFunctionBeginUser;
  message[0] = '\0';
  if (p->found->bodies.n < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(deepest_closure(p, &closure));
  PetscCall(GatherMesh(m, &mesh));
  PetscCall(GatherVertices(m, 2, p->state->u + 3 * m->rigid.n, &u));
  if (!m->rank) {
    BlockMesh moved = {.n_vertices = mesh.n_vertices, .n_blocks = mesh.n_blocks, .blocks = mesh.blocks};
    moved.body = mesh.macroblock, moved.n_bodies = m->mesh.n_bodies_global;
    PetscCall(PetscMalloc1(2 * (size_t)mesh.n_vertices, &moved.X));
    PetscCall(PetscMalloc1(mesh.n_blocks, &moved.block_file));
    for (PetscInt i = 0; i < mesh.n_blocks; i++) moved.block_file[i] = i;
    for (PetscInt i = 0; i < 2 * mesh.n_vertices; i++) moved.X[i] = mesh.X[i] + u[i];
    PetscCall(MeshOverlap(&moved, p->scene->overlap_tolerance + 2. * closure, message));
    PetscCall(PetscFree(moved.X));
    PetscCall(PetscFree(moved.block_file));
  }
  PetscCallMPI(MPI_Bcast(message, MESSAGE_LENGTH, MPI_CHAR, 0, m->comm));
  PetscCall(PetscFree(u));
  PetscCall(GatherMeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- in words */

const char *const FateWords[] = {"overturned", "fallen", "slid"};

/* Writes "overturned: macroblock 3 (block) at 0.52 s; "; of several bodies the first. */
PetscErrorCode BodyMotionReport(const Model *m, const BodyMotion *b, size_t size, char *text)
{
  PetscFunctionBeginUser;
  text[0] = '\0';
  for (int fate = 0; fate < BODY_FATES; fate++) {
    PetscInt n;
    const PetscInt first = first_with(b, (BodyFate)fate, &n);
    const size_t used = strlen(text);
    if (!n) continue;
    PetscCall(PetscSNPrintf(text + used, size - used,
                            "%s: ", fate == BODY_SLID ? "slid out of its place" : FateWords[fate]));
    if (n > 1)
      PetscCall(PetscSNPrintf(text + strlen(text), size - strlen(text),
                              "%" PetscInt_FMT " macroblocks, first ", n));
    PetscCall(PetscSNPrintf(text + strlen(text), size - strlen(text), "%s%" PetscInt_FMT " (%s) at %.6g s; ",
                            n > 1 ? "" : "macroblock ", first, m->materials.names[b->group[first]],
                            (double)b->since[BODY_FATES * first + fate]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* load_path.c: finds whether contacts and supports carry the loads on each body, measured by these loads
   themselves.

   The unbalanced ratio measures a body by all forces on it. Where contacts press a body much harder than it
   is loaded, all of its load may be missing from the balance and the ratio does not show it: a block of 1 N
   between frictionless jaws that are pressed with 1 MN has a ratio of 1e-6 as it falls. So an equilibrium is
   also checked for motions that nothing resists. A rigid motion q = (x, y, turn) of one body alone is
   resisted by

     A = sum L_i (g_n g_n' + g_s g_s'),   g_n = (n, r x n), g_s = (s, r x s).

   The sum runs over the ends of its contacts, with g_n where the end is closed and g_s where it also sticks;
   a support adds a row for each degree of freedom that it holds. F is the resultant of the unbalanced forces
   on the body. Its component that drives free motions is

     w = delta (A + delta I)^-1 F,   delta -> 0.

   w must be small against the body's own loads. Bodies that stick to each other along a whole contact form a
   cluster, and clusters are checked in the same way. A contact whose ends slip in opposite directions sticks
   in between. Rotations are measured in radii of gyration of the vertices. Stiffness does not enter: a
   contact holds however soft it is.

   A body without loads whose motion nothing resists may be anywhere. The tangent of Newton's method is
   singular for this motion, and an iteration once moved such a body by centimetres. FreeBodies finds the
   body, and newton_step.c holds it by a little stiffness. */
#include "verdict/verdict.h"
#include "base/reproducible.h"

enum { X, Y, SQUARES, COUNT, PLACES };
enum { FORCE = 0, LOAD = 3, PRESSED, LENGTH, RESISTS, FORCES = RESISTS + 6 };

/* Sums over clusters, with the same bits on any number of ranks. The first pass finds the largest terms, the
   second one adds the terms to bins. */
typedef struct {
  const PetscInt *cluster; /* (n_bodies_global,) cluster of each macroblock: the lowest macroblock in it */
  int per;                 /* quantities of a cluster */
  PetscBool adds;          /* TRUE in the second pass */
  PetscReal top[FORCES];
  Bins bins[FORCES];
  PetscReal *sum; /* (n_bodies_global, per, 2) */
} Tally;

/* Adds a term x to a quantity of the cluster of a body. */
static void tally(Tally *t, PetscInt body, int quantity, PetscReal x)
{
  if (t->adds)
    BinAdd(t->bins + quantity, x, t->sum + 2 * (t->per * t->cluster[body] + quantity));
  else
    t->top[quantity] = PetscMax(t->top[quantity], PetscAbsReal(x));
}

/* Returns a quantity of a cluster, after the second pass. */
static PetscReal tallied(const Tally *t, PetscInt cluster, int quantity)
{
  const PetscReal *bins = t->sum + 2 * (t->per * cluster + quantity);
  return bins[0] + bins[1];
}

/* The place of a cluster. */
typedef struct {
  PetscReal x[2], radius; /* [m] mean of its vertices, their radius of gyration about it */
} Place;

typedef void (*Terms)(const Problem *p, const Place *places, Tally *t);

/* Collective. Sums the quantities of all clusters from the terms that `terms` tallies. */
static PetscErrorCode sum_over_ranks(const Problem *p, const Place *places, Terms terms, Tally *t)
{
  const Model *m = p->m;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(t->top, FORCES));
  PetscCall(PetscArrayzero(t->sum, 2 * t->per * m->mesh.n_bodies_global));
  t->adds = PETSC_FALSE;
  terms(p, places, t);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->top, t->per, MPIU_REAL, MPI_MAX, m->comm));
  for (int i = 0; i < t->per; i++) t->bins[i] = BinsFor(PetscMax(t->top[i], 1e-290));
  t->adds = PETSC_TRUE;
  terms(p, places, t);
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, t->sum, 2 * t->per * m->mesh.n_bodies_global, MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tallies the positions of the vertices of each cluster. */
static void add_places(const Problem *p, const Place *places, Tally *t)
{
  const Model *m = p->m;
  const PetscReal *u = p->state->u + 3 * m->rigid.n;
  (void)places;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++) {
    const PetscReal x = m->mesh.X[2 * v] + u[2 * v], y = m->mesh.X[2 * v + 1] + u[2 * v + 1];
    tally(t, m->mesh.vertex_body[v], X, x), tally(t, m->mesh.vertex_body[v], Y, y);
    tally(t, m->mesh.vertex_body[v], SQUARES, x * x + y * y), tally(t, m->mesh.vertex_body[v], COUNT, 1.);
  }
}

/* Collective. Finds the place of each cluster. */
static PetscErrorCode find_places(const Problem *p, Tally *t, Place *places)
{
  PetscFunctionBeginUser;
  t->per = PLACES;
  PetscCall(sum_over_ranks(p, NULL, add_places, t));
  for (PetscInt b = 0; b < p->m->mesh.n_bodies_global; b++) {
    const PetscReal n = PetscMax(tallied(t, b, COUNT), 1.), x = tallied(t, b, X) / n,
                    y = tallied(t, b, Y) / n;
    const PetscReal square = tallied(t, b, SQUARES) / n - x * x - y * y;
    places[b] = (Place){{x, y}, PetscSqrtReal(PetscMax(square, 1e-20))};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what resists */

/* Finds whether end k of contact i is closed, and whether it sticks. */
static void end_holds(const Joint *joint, const Contacts *c, PetscInt i, int k, PetscBool *closed,
                      PetscBool *sticks)
{
  const PetscInt at = SUB(i, k), other = SUB(i, 1 - k);
  const PetscReal limit = JointLimitAt(joint, c->broken[at], c->broken[other], c->sigma[at]);
  const PetscBool elastic = (PetscBool)(joint->law == LAW_ELASTIC),
                  opposite = (PetscBool)(ContactEnds(c, i) == 2 && c->tau[at] * c->tau[other] < 0.);
  *closed = (PetscBool)(elastic || !(c->state[at] & CONTACT_OPEN));
  *sticks = (PetscBool)(elastic || (*closed && opposite) ||
                        (*closed && !(c->state[at] & CONTACT_SLIPPING) &&
                         PetscAbsReal(c->tau[at]) < (1. - NEAR_SLIP) * limit));
}

/* Computes g: the motion along the direction `along` at a point by the three rigid motions of its cluster. */
static void add_motion(const Place *place, const PetscReal point[2], const PetscReal along[2], PetscReal g[3])
{
  g[0] = along[0], g[1] = along[1];
  g[2] = ((point[0] - place->x[0]) * along[1] - (point[1] - place->x[1]) * along[0]) / place->radius;
}

/* Tallies the resistance `length` [m] to the motion g. */
static void add_resistance(Tally *t, PetscInt body, const PetscReal g[3], PetscReal length)
{
  for (int i = 0, at = RESISTS; i < 3; i++)
    for (int j = 0; j <= i; j++, at++) tally(t, body, at, length * g[i] * g[j]);
}

/* Tallies the force of end k of contact i, and its resistance, for the two clusters it lies between. */
static void add_contact(const Problem *p, const Place *places, PetscInt i, int k, Tally *t)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const PetscReal *u = p->state->u + 3 * m->rigid.n, half = 0.5 * c->length[i];
  const PetscReal force = m->materials.thickness *
                          (PetscAbsReal(c->F_n[SUB(i, k)]) + PetscAbsReal(c->F_s[SUB(i, k)]));
  PetscBool closed, sticks;
  PetscInt v[3];
  PetscReal P[2], e[2];
  ContactEndVertices(c, i, k, v);
  end_holds(p->stage->joints + c->joint[i], c, i, k, &closed, &sticks);
  for (int x = 0; x < 2; x++) {
    P[x] = m->mesh.X[2 * v[0] + x] + u[2 * v[0] + x];
    e[x] = m->mesh.X[2 * v[2] + x] + u[2 * v[2] + x] - m->mesh.X[2 * v[1] + x] - u[2 * v[1] + x];
  }
  const PetscReal size = PetscHypotReal(e[0], e[1]), s[2] = {e[0] / size, e[1] / size}, n[2] = {s[1], -s[0]};
  const PetscInt bodies[2] = {m->mesh.vertex_body[v[0]], m->mesh.vertex_body[v[1]]};
  for (int b = 0; b < 2 && t->cluster[bodies[0]] != t->cluster[bodies[1]]; b++) {
    const Place *place = places + t->cluster[bodies[b]];
    PetscReal g[3];
    tally(t, bodies[b], LENGTH, half), tally(t, bodies[b], PRESSED, force);
    add_motion(place, P, n, g);
    if (closed) add_resistance(t, bodies[b], g, half);
    add_motion(place, P, s, g);
    if (sticks) add_resistance(t, bodies[b], g, half);
  }
}

/* Tallies the unbalanced and applied forces of clusters, and the resistance to their motions. */
static void add_forces(const Problem *p, const Place *places, Tally *t)
{
  static const PetscReal along[2][2] = {{1., 0.}, {0., 1.}};
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const State *s = p->state;
  const PetscInt rigid = 3 * m->rigid.n;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscInt body = DofBody(m, d), axis = d < rigid ? d % 3 : (d - rigid) % 2;
    const PetscReal *X0 = d < rigid ? m->rigid.X + 2 * (d / 3) : m->mesh.X + 2 * ((d - rigid) / 2),
                    *moved = d < rigid ? s->u + 3 * (d / 3) : s->u + d - axis;
    const Place *place = places + t->cluster[body];
    const PetscReal point[2] = {X0[0] + moved[0], X0[1] + moved[1]};
    PetscReal g[3] = {0., 0., 1. / place->radius};
    if (axis < 2) add_motion(place, point, along[axis], g);
    for (int i = 0; i < 3 && !Held(m, d); i++) tally(t, body, FORCE + i, g[i] * (s->f_ext[d] - s->f[d]));
    tally(t, body, LOAD, PetscAbsReal(s->f_ext[d]) * (axis < 2 ? 1. : g[2]));
    if (Held(m, d)) tally(t, body, LENGTH, place->radius), add_resistance(t, body, g, place->radius);
  }
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < ContactEnds(c, i) && c->key[2 * i] >= 0 && c->owned[i]; k++)
      add_contact(p, places, i, k, t);
}

/* ---- what drives */

/* Returns |w| = |delta (A + delta I)^-1 F|, by the Cholesky factor of A + delta I. A is stored as its lower
   triangle, row after row. */
static PetscReal free_component(const Tally *t, PetscInt cluster, const PetscReal F[3])
{
  const PetscReal delta = FREE_RESISTANCE * tallied(t, cluster, LENGTH) + 1e-30;
  PetscReal L[3][3], w[3], square = 0.;
  for (int i = 0, at = RESISTS; i < 3; i++)
    for (int j = 0; j <= i; j++, at++) {
      L[i][j] = tallied(t, cluster, at) + (i == j ? delta : 0.);
      for (int k = 0; k < j; k++) L[i][j] -= L[i][k] * L[j][k];
      L[i][j] = i == j ? PetscSqrtReal(PetscMax(L[i][i], 0.5 * delta)) : L[i][j] / L[j][j];
    }
  for (int i = 0; i < 3; i++) {
    w[i] = delta * F[i];
    for (int k = 0; k < i; k++) w[i] -= L[i][k] * w[k];
    w[i] /= L[i][i];
  }
  for (int i = 2; i >= 0; i--) {
    for (int k = i + 1; k < 3; k++) w[i] -= L[k][i] * w[k];
    w[i] /= L[i][i], square += w[i] * w[i];
  }
  return PetscSqrtReal(square);
}

/* Returns |w| [N] of the unbalanced force on a cluster. */
static PetscReal free_force(const Tally *t, PetscInt cluster)
{
  const PetscReal F[3] = {tallied(t, cluster, FORCE), tallied(t, cluster, FORCE + 1),
                          tallied(t, cluster, FORCE + 2)};
  return free_component(t, cluster, F);
}

/* A cluster whose own loads nothing carries. */
typedef struct {
  PetscInt cluster;       /* -1: none */
  PetscReal drives, load; /* [N] |w|; sum of its applied forces */
  Place place;
} Loose;

/* Finds the cluster with the largest fraction of its loads not carried. */
static PetscErrorCode find_loose(const Problem *p, PetscReal allowed, const PetscInt *cluster, Place *places,
                                 PetscReal *sum, Loose *loose)
{
  Tally t = {.cluster = cluster, .sum = sum};
  PetscReal most = 0.;
  PetscFunctionBeginUser;
  PetscCall(find_places(p, &t, places));
  t.per = FORCES;
  PetscCall(sum_over_ranks(p, places, add_forces, &t));
  for (PetscInt b = 0; b < p->m->mesh.n_bodies_global; b++)
    most = PetscMax(most, tallied(&t, b, LOAD) + tallied(&t, b, PRESSED));
  for (PetscInt b = 0; b < p->m->mesh.n_bodies_global; b++) {
    const PetscReal load = tallied(&t, b, LOAD),
                    least = PetscMax(FORCE_ROUNDING * (load + tallied(&t, b, PRESSED)),
                                     LARGEST_ROUNDING * most);
    if (cluster[b] != b || !(load > 0.)) continue;
    const PetscReal drives = free_force(&t, b);
    if (!(drives > PetscMax(allowed * load, least))) continue;
    if (loose->cluster >= 0 && drives * loose->load <= loose->drives * load) continue;
    *loose = (Loose){b, drives, load, places[b]};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts bodies that stick to each other at both ends of a contact into one cluster, numbered as the lowest of
   these bodies. joined: there are such bodies. */
static PetscErrorCode find_clusters(const Problem *p, PetscInt *cluster, PetscBool *joined)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  PetscBool again = PETSC_TRUE;
  PetscFunctionBeginUser;
  *joined = PETSC_FALSE;
  while (again) {
    PetscBool changed = PETSC_FALSE;
    for (PetscInt i = 0; i < c->n_padded; i++) {
      PetscBool closed, sticks = (PetscBool)(c->key[2 * i] >= 0 && c->owned[i] && ContactEnds(c, i) == 2);
      for (int k = 0; k < 2 && sticks; k++)
        end_holds(p->stage->joints + c->joint[i], c, i, k, &closed, &sticks);
      if (!sticks) continue;
      PetscInt *a = cluster + m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_P)]],
               *b = cluster + m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_A)]];
      const PetscInt lowest = PetscMin(cluster[*a], cluster[*b]);
      changed = (PetscBool)(changed || *a != lowest || *b != lowest);
      cluster[*a] = PetscMin(cluster[*a], lowest), cluster[*b] = PetscMin(cluster[*b], lowest);
      *a = *b = lowest;
    }
    PetscCallMPI(MPI_Allreduce(&changed, &again, 1, MPI_PETSC_BOOL, MPI_LOR, m->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cluster, m->mesh.n_bodies_global, MPIU_INT, MPI_MIN, m->comm));
    *joined = (PetscBool)(*joined || again);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the bodies one by one; where all are carried, also the clusters that they form. */
static PetscErrorCode find_unsupported(const Problem *p, PetscReal allowed, Loose *loose)
{
  const PetscInt n = p->m->mesh.n_bodies_global;
  PetscInt *cluster;
  PetscReal *sum;
  Place *places;
  PetscBool joined;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(n, &cluster, n, &places, 2 * FORCES * n, &sum));
  for (PetscInt b = 0; b < n; b++) cluster[b] = b;
  loose->cluster = -1;
  PetscCall(find_loose(p, allowed, cluster, places, sum, loose));
  if (loose->cluster < 0) PetscCall(find_clusters(p, cluster, &joined));
  if (loose->cluster < 0 && joined) PetscCall(find_loose(p, allowed, cluster, places, sum, loose));
  PetscCall(PetscFree3(cluster, places, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the bodies that have neither a load nor a support. */
static PetscErrorCode find_bare(const Problem *p, PetscInt *bare, PetscInt *n_bare)
{
  const Model *m = p->m;
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->mesh.n_bodies_global; b++) bare[b] = 1;
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (Held(m, d) || p->state->f_ext[d] != 0.) bare[DofBody(m, d)] = 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bare, m->mesh.n_bodies_global, MPIU_INT, MPI_MIN, m->comm));
  *n_bare = 0;
  for (PetscInt b = 0; b < m->mesh.n_bodies_global; b++) *n_bare += bare[b];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a body can move along x or y, or turn, against next to no resistance. */
static PetscBool can_move(const Tally *t, PetscInt body)
{
  static const PetscReal axes[3][3] = {{1., 0., 0.}, {0., 1., 0.}, {0., 0., 1.}};
  for (int i = 0; i < 3; i++)
    if (free_component(t, body, axes[i]) > FREE_PART) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode FreeBodies(const Problem *p, PetscInt *free_body, PetscInt *n_free)
{
  const PetscInt n = p->m->mesh.n_bodies_global;
  PetscInt *cluster;
  PetscReal *sum, most = 0.;
  Place *places;
  PetscFunctionBeginUser;
  PetscCall(find_bare(p, free_body, n_free));
  if (!*n_free) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc3(n, &cluster, n, &places, 2 * FORCES * n, &sum));
  for (PetscInt b = 0; b < n; b++) cluster[b] = b;
  Tally t = {.cluster = cluster, .sum = sum};
  PetscCall(find_places(p, &t, places));
  t.per = FORCES;
  PetscCall(sum_over_ranks(p, places, add_forces, &t));
  for (PetscInt b = 0; b < n; b++) most = PetscMax(most, tallied(&t, b, LOAD) + tallied(&t, b, PRESSED));
  *n_free = 0;
  for (PetscInt b = 0; b < n; b++) {
    free_body[b] = free_body[b] && free_force(&t, b) <= DRIVES_NOTHING * most && can_move(&t, b);
    *n_free += free_body[b];
  }
  PetscCall(PetscFree3(cluster, places, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BodiesAreSupported(const Problem *p, PetscReal allowed, PetscBool *carried)
{
  Loose loose;
  PetscFunctionBeginUser;
  PetscCall(find_unsupported(p, allowed, &loose));
  *carried = (PetscBool)(loose.cluster < 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UnsupportedReport(const Problem *p)
{
  StageResult *result = p->result;
  Loose loose;
  char text[192];
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_COLLAPSED && result->verdict != VERDICT_UNDECIDED)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!(result->ratio <= p->stage->tolerance)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_unsupported(p, LOAD_MISSING, &loose));
  if (loose.cluster < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(text, sizeof(text),
                          "; macroblock %" PetscInt_FMT
                          " and what sticks to it, at x = %.4g m, y = %.4g m, are "
                          "not held against %.3g N of the %.3g N that they are loaded with",
                          loose.cluster, (double)loose.place.x[0], (double)loose.place.x[1],
                          (double)loose.drives, (double)loose.load));
  PetscCall(PetscStrlcat(result->evidence, text, sizeof(result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

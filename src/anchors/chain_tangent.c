/* chain_tangent.c: computes the tangent stiffness of a bonded bar.

   k_j are the tangents of the pieces, c_i those of the bonds, and G s the differences of the slips. The
   slips caused by elongations dg are ds = -H^-1 G' k dg, H = G' k G + c tridiagonal, and

     dN = A dg,   A = k - k G H^-1 G' k.

   Where a piece and its dowel yield together, n = N/T_y, v = V/V_y, and m is the root of the sum of
   squares of the trial forces over their limits:

     dN = v^2/m k dx - n v T_y/(V_y m) K dd,   dV = n^2/m K dd - n v V_y/(T_y m) k dx,

   where x is the elongation of the steel and d the slip of the joint. So dd changes the slips s as dg
   does, and the stiffness is not symmetric.

   A decays along the bar: over ChainReach pieces to a millionth while the bond is elastic. A slipping bond
   extends this by no more than the length that carries the strength of the bar. So the stiffness is
   computed in windows of two reaches, and the matrix of the scene stays sparse. */
#include "anchors/chain.h"
#include "anchors/pair.h"

static const PetscReal NEGLIGIBLE = 1e-6; /* of the force of a piece: less in another is neglected */

/* Gradient of an elongation or slip: its direction at each of its places. */
enum { SLOPE_PLACES = 3 };
typedef struct {
  PetscInt n;
  const Place *place[SLOPE_PLACES];
  Pair by[SLOPE_PLACES];
} Slope;

/* Work space of a window. */
typedef struct {
  PetscReal *k;       /* (width, width) stiffness by columns */
  PetscReal *z;       /* (width,) forces of one column */
  const PetscInt *in; /* (n_vertices,) rows of the chain's vertices in the window */
  PetscInt width;
} Window;

/* ---- windows */

PetscInt ChainReach(const Chain *c, PetscReal strongest)
{
  PetscReal k = 0., bond = PETSC_MAX_REAL, slips = 0., most = (PetscReal)c->n;
  for (PetscInt j = 0; j + 1 < c->n; j++) k = PetscMax(k, c->k[j]);
  for (PetscInt i = c->head; i < c->n; i++) {
    bond = PetscMin(bond, c->c[i]);
    if (c->B[i] < PETSC_INFINITY) slips = PetscMax(slips, 2. * strongest / c->B[i]);
  }
  const PetscReal each = 2. * PetscAsinhReal(0.5 * PetscSqrtReal(bond / k));
  most = PetscMin(most, PetscCeilReal(-PetscLogReal(NEGLIGIBLE) / each + slips) + 1.);
  return (PetscInt)most;
}

PetscInt ChainWindows(const Chain *c)
{
  return (c->n - 1 + c->reach - 1) / c->reach;
}

/* Computes the pieces of a window: [from, to). Pairs whose first piece is below `own` belong to this
   window. */
static void pieces_of(const Chain *c, PetscInt window, PetscInt *from, PetscInt *own, PetscInt *to)
{
  *from = window * c->reach;
  *own = PetscMin(c->n - 1, *from + c->reach);
  *to = PetscMin(c->n - 1, *own + c->reach);
}

static PetscInt take(const Place *place, PetscInt n, PetscInt *at)
{
  for (PetscInt k = 0; k < place->n; k++) at[n++] = place->at[k];
  return n;
}

PetscErrorCode ChainWindow(const Chain *c, PetscInt window, PetscInt *n, PetscInt *at)
{
  PetscInt from, own, to;
  PetscFunctionBeginUser;
  pieces_of(c, window, &from, &own, &to);
  *n = 0;
  for (PetscInt i = from; i <= to; i++) *n = take(c->place + i, *n, at);
  for (const Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++) {
    if (d->piece < from || d->piece >= to) continue;
    *n = take(&d->face, take(&d->on[1], take(&d->on[0], *n, at), at), at);
  }
  PetscCall(PetscSortRemoveDupsInt(n, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- slopes */

static Slope of_piece(const Chain *c, PetscInt j, Pair e)
{
  return (Slope){.n = 2, .place = {c->place + j + 1, c->place + j}, .by = {e, -e}};
}

static Pair across(Pair t)
{
  return (Pair){-t[1], t[0]};
}

/* Returns the gradient of the relative displacement of the sides of a joint along t. */
static Slope of_sides(const Dowel *d, Pair t)
{
  return (Slope){.n = 2, .place = {&d->on[1], &d->on[0]}, .by = {t, -t}};
}

static Slope of_face(const Dowel *d, Pair t)
{
  return (Slope){.n = 1, .place = {&d->face}, .by = {t / d->length}};
}

/* Returns the gradient of the slip of a joint, which also changes with the rotation of its face. */
static Slope of_dowel(const Dowel *d, PetscBool turned, PetscBool turns)
{
  const Pair t = LoadPair(turned ? d->t : d->along);
  Slope slope = of_sides(d, t);
  if (!turned || !turns) return slope;
  slope.n = 3, slope.place[2] = &d->face, slope.by[2] = d->across / d->length * across(t);
  return slope;
}

static inline void add_place(const Place *place, Pair force, const Window *w)
{
  for (PetscInt v = 0; v < place->n; v++) {
    PetscReal *z = w->z + 2 * w->in[place->at[v]];
    StorePair(z, LoadPair(z) + place->weight[v] * force);
  }
}

/* Adds `times` times the slope to the vector z of the window. */
static void add_row(const Slope *slope, PetscReal times, const Window *w)
{
  for (PetscInt i = 0; i < slope->n; i++) add_place(slope->place[i], times * slope->by[i], w);
}

/* Adds z slope' to the stiffness k of the window, and clears z. */
static void add_column(const Slope *slope, const Window *w)
{
  for (PetscInt i = 0; i < slope->n; i++)
    for (PetscInt v = 0; v < slope->place[i]->n; v++)
      for (int x = 0; x < 2; x++) {
        const PetscReal one = slope->place[i]->weight[v] * slope->by[i][x];
        PetscReal *k = w->k + w->width * (2 * w->in[slope->place[i]->at[v]] + x);
        for (PetscInt p = 0; p < w->width; p += 2)
          StorePair(k + p, LoadPair(k + p) + one * LoadPair(w->z + p));
      }
  memset(w->z, 0, w->width * sizeof *w->z);
}

static void add_pair(const Slope *first, const Slope *second, PetscReal times, const Window *w)
{
  add_row(first, times, w);
  add_column(second, w);
}

/* ---- along the bar */

/* Sets the tangents: of the last evaluation, or elastic ones. */
static void set_slopes(Chain *c, PetscBool elastic)
{
  for (PetscInt j = 0; j + 1 < c->n && elastic; j++)
    c->k_now[j] = c->branch[j] == IS_PULLED || c->branch[j] == IS_SLACK ? 0. : c->k[j];
  for (PetscInt i = 0; i < c->n && elastic; i++) c->c_now[i] = c->c[i];
  ChainFactor(c);
}

/* Coupling of piece and dowel; elastic: none. */
typedef struct {
  PetscReal N_by_d, V_by_x, V_by_d; /* [N/m] */
} Joined;

static Joined join(const Chain *c, const Dowel *d, PetscBool elastic)
{
  const PetscBool yields = (PetscBool)(!elastic && d->beyond > 1. && d->V_y < PETSC_INFINITY);
  if (!yields) return (Joined){0., 0., d->K};
  if (c->T_y == PETSC_INFINITY) return (Joined){0., 0., 0.};
  const PetscReal n = c->N[d->piece] / c->T_y, v = d->V / d->V_y, both = -n * v / d->beyond;
  return (Joined){both * c->T_y / d->V_y * d->K, both * d->V_y / c->T_y * c->k[d->piece],
                  n * n / d->beyond * d->K};
}

/* Computes y, minus d(slip)/d(force in piece j) times force, for the places within reach. */
static void respond(const Chain *c, PetscInt j, PetscReal force, PetscReal *y)
{
  const PetscInt low = PetscMax(0, j - c->reach), high = PetscMin(c->n - 1, j + 1 + c->reach);
  for (PetscInt i = low; i <= high; i++) y[i] = 0.;
  y[j] = -force, y[j + 1] = force;
  for (PetscInt i = j + 1; i <= high; i++) y[i] += c->k_now[i - 1] * c->pivot[i - 1] * y[i - 1];
  y[high] *= c->pivot[high];
  for (PetscInt i = high; i-- > low;) y[i] = c->pivot[i] * (y[i] + c->k_now[i] * y[i + 1]);
}

/* Adds a column: the forces of all pieces and dowels within reach, caused by an elongation of piece j, or
   (`dowel`) by a slip of its joint. */
static void add_response(Chain *c, PetscInt j, PetscBool dowel, PetscBool elastic, PetscBool turned,
                         PetscReal times, const PetscInt pieces[3], const Window *w)
{
  const PetscInt from = pieces[0], own = pieces[1], low = PetscMax(from, j - c->reach),
                 high = j < own ? PetscMin(pieces[2], j + c->reach + 1) : own;
  const Joined here = dowel ? join(c, c->dowel + c->crossing[j], elastic) : (Joined){0., 0., 0.};
  const PetscReal force = dowel ? here.N_by_d : c->k_now[j], *e = turned ? c->e : c->towards;
  PetscReal *y = c->step;
  Pair before = {0., 0.};
  respond(c, j, force, y);
  for (PetscInt i = low; i < high; i++) {
    const PetscReal slips = y[i + 1] - y[i], N = (i == j ? force : 0.) - c->k_now[i] * slips;
    const Pair behind = times * N * LoadPair(e + 2 * i);
    add_place(c->place + i, before - behind, w);
    before = behind;
    if (c->crossing[i] < 0) continue;
    const Dowel *d = c->dowel + c->crossing[i];
    const Joined there = join(c, d, elastic);
    const Slope slip = of_dowel(d, turned, c->turns);
    const PetscReal x = (i == j && !dowel ? 1. : 0.) - slips, own_part = i == j && dowel ? there.V_by_d : 0.;
    add_row(&slip, times * (there.V_by_x * x + own_part), w);
  }
  add_place(c->place + high, before, w);
  const Slope one = dowel ? of_dowel(c->dowel + c->crossing[j], turned, c->turns)
                          : of_piece(c, j, LoadPair(e + 2 * j));
  add_column(&one, w);
}

/* ---- geometric stiffness */

/* Adds V times the second derivative of the slip. With w the relative displacement of the face ends, theta
   = n.w/l and tau = t.w/l, it is 2 theta n.dd - slip theta^2 - 2 across theta tau. */
static void turn_dowel(const Dowel *d, PetscReal times, const Window *w)
{
  const Pair t = LoadPair(d->t), n = across(t);
  const Slope sides = of_sides(d, n), theta = of_face(d, n), tau = of_face(d, t);
  const PetscReal V = times * d->V;
  add_pair(&theta, &sides, V, w);
  add_pair(&sides, &theta, V, w);
  add_pair(&theta, &theta, -V * d->slip, w);
  add_pair(&theta, &tau, -V * d->across, w);
  add_pair(&tau, &theta, -V * d->across, w);
}

static void turn(const Chain *c, PetscReal times, const PetscInt pieces[3], const Window *w)
{
  for (PetscInt j = pieces[0]; j < pieces[1]; j++) {
    const Slope normal = of_piece(c, j, across(LoadPair(c->e + 2 * j)));
    add_pair(&normal, &normal, times * c->N[j] / c->span[j], w);
    if (c->crossing[j] >= 0) turn_dowel(c->dowel + c->crossing[j], times, w);
  }
}

PetscErrorCode ChainTangent(Chain *c, PetscInt window, PetscBool elastic, PetscBool turned, PetscReal times,
                            PetscInt n, const PetscInt *at, PetscReal *k)
{
  PetscInt *in, pieces[3];
  Window w = {.width = 2 * n};
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(c->n_vertices, &in));
  PetscCall(PetscCalloc2(w.width, &w.z, w.width * w.width, &w.k));
  for (PetscInt i = 0; i < n; i++) in[at[i]] = i;
  w.in = in;
  pieces_of(c, window, pieces, pieces + 1, pieces + 2);
  set_slopes(c, elastic);
  for (PetscInt j = pieces[0]; j < pieces[2]; j++) {
    add_response(c, j, PETSC_FALSE, elastic, turned, times, pieces, &w);
    if (c->crossing[j] >= 0) add_response(c, j, PETSC_TRUE, elastic, turned, times, pieces, &w);
  }
  if (turned && c->turns) turn(c, times, pieces, &w);
  for (PetscInt p = 0; p < w.width; p++)
    for (PetscInt q = 0; q < w.width; q++) k[w.width * p + q] += w.k[w.width * q + p];
  PetscCall(PetscFree(in));
  PetscCall(PetscFree2(w.z, w.k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ChainCarried(const Chain *c, PetscInt window, PetscReal times, PetscReal *f)
{
  PetscInt from, own, to;
  pieces_of(c, window, &from, &own, &to);
  ChainPullAt(c, from, own, times, f);
}

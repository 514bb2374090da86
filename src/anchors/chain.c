/* chain.c: computes geometry, forces and energies of a bonded bar. */
#include "anchors/chain.h"
#include "anchors/pair.h"

/* Returns the displacement of a place. */
static inline Pair move_of(const Place *place, const PetscReal *u)
{
  return WeighedSum(PLACE_VERTICES, place->vertex, place->weight, u);
}

/* Computes elongation g and direction e of a vector after a displacement `by`; small strain: along its
   original direction. */
static inline void stretch(const PetscReal e0[2], PetscReal length, Pair by, bool small, PetscReal e[2],
                           PetscReal *span, PetscReal *g)
{
  const Pair before = LoadPair(e0), each = before * by, square = by * by;
  const PetscReal along = each[0] + each[1];
  if (small) {
    *span = length, *g = along;
    StorePair(e, before);
    return;
  }
  const Pair now = length * before + by, squares = now * now;
  *span = PetscSqrtReal(squares[0] + squares[1]);
  // |l| - |l_0|, without cancellation
  *g = (2. * length * along + square[0] + square[1]) / (*span + length);
  StorePair(e, now / *span);
}

static void place_dowel(const Chain *c, Dowel *d, const PetscReal *u)
{
  const ChainMemory *committed = &c->memory[CHAIN_COMMITTED];
  const PetscInt i = (PetscInt)(d - c->dowel);
  const Pair by = LoadPair(d->gap) + move_of(&d->on[1], u) - move_of(&d->on[0], u);
  PetscReal longer;
  stretch(d->along, d->face_length, move_of(&d->face, u), !c->turns, d->t, &d->length, &longer);
  d->slip = by[0] * d->t[0] + by[1] * d->t[1];
  d->across = by[1] * d->t[0] - by[0] * d->t[1];
  d->trial = d->K * (d->slip - committed->upright[i] - committed->sheared[i]);
}

static void place(Chain *c, const PetscReal *u)
{
  const PetscBool small = (PetscBool)!c->turns;
  Pair before = move_of(c->place, u);
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    const Pair behind = move_of(c->place + j + 1, u);
    stretch(c->towards + 2 * j, c->length[j], behind - before, small, c->e + 2 * j, c->span + j, c->g + j);
    before = behind;
  }
  for (Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++) place_dowel(c, d, u);
}

/* Computes the history after the evaluation: plastic strain and slip are added to the committed history. */
static void update_history(Chain *c)
{
  const ChainMemory *committed = &c->memory[CHAIN_COMMITTED], *now = &c->memory[CHAIN_NOW];
  if (c->is_elastic) {
    const size_t before = (size_t)(now->slip - c->numbers[CHAIN_NOW]), behind = before + (size_t)c->n;
    memcpy(c->numbers[CHAIN_NOW], c->numbers[CHAIN_COMMITTED], before * sizeof(PetscReal));
    memcpy(now->upright, committed->upright, ((size_t)c->n_numbers - behind) * sizeof(PetscReal));
    for (PetscInt i = 0; i < c->n_dowels; i++) c->dowel[i].V = c->dowel[i].trial;
    return;
  }
  for (int i = 0; i < CHAIN_LOSSES; i++) now->lost[i] = committed->lost[i];
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    const PetscReal x = c->g[j] + now->slip[j + 1] - now->slip[j] - committed->natural[j] -
                        committed->plastic[j];
    const PetscBool yields = (PetscBool)(c->branch[j] >= YIELDS && c->branch[j] <= WITH_DOWEL);
    const PetscReal more = yields ? x - c->N[j] / c->k[j] : 0.;
    now->natural[j] = committed->natural[j], now->plastic[j] = committed->plastic[j] + more;
    now->lost[LOST_IN_YIELD] += c->N[j] * more;
  }
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal more = c->branch[c->n - 1 + i] ? now->slip[i] - committed->slid[i] - c->b[i] / c->c[i]
                                                   : 0.;
    now->slid[i] = committed->slid[i] + more;
    now->lost[LOST_IN_BOND] += c->b[i] * more;
  }
  for (PetscInt i = 0; i < c->n_dowels; i++) {
    Dowel *d = c->dowel + i;
    d->V = d->V_y < PETSC_INFINITY ? d->trial / PetscMax(1., d->beyond) : d->trial;
    const PetscReal more = (d->trial - d->V) / d->K;
    now->upright[i] = committed->upright[i], now->sheared[i] = committed->sheared[i] + more;
    now->lost[LOST_IN_DOWELS] += d->V * more;
  }
}

/* Sets all forces to zero. */
static void empty(Chain *c)
{
  memset(c->N, 0, (c->n - 1) * sizeof *c->N);
  memset(c->b, 0, c->n * sizeof *c->b);
  for (PetscInt i = 0; i < c->n_dowels; i++) c->dowel[i].V = 0.;
}

void ChainPlace(Chain *c, const PetscReal *u)
{
  place(c, u);
  empty(c);
}

PetscBool ChainEvaluate(Chain *c, const PetscReal *u)
{
  place(c, u);
  const PetscBool found = ChainSolve(c);
  update_history(c);
  return found;
}

void ChainComes(Chain *c)
{
  const ChainMemory *now = &c->memory[CHAIN_NOW];
  for (PetscInt j = 0; j + 1 < c->n; j++) now->natural[j] = c->g[j], now->plastic[j] = 0.;
  for (PetscInt i = 0; i < c->n; i++) now->slid[i] = now->slip[i] = 0.;
  for (PetscInt i = 0; i < c->n_dowels; i++) {
    const ChainMemory *committed = &c->memory[CHAIN_COMMITTED];
    now->upright[i] = c->dowel[i].trial / c->dowel[i].K + committed->upright[i] + committed->sheared[i];
    now->sheared[i] = 0.;
  }
  empty(c);
}

/* Adds a force to the vertices of a place. own: f has the vertices of the chain in its order. */
static inline void put(const Place *place, Pair force, PetscBool own, PetscReal *f)
{
  AddWeighed(PLACE_VERTICES, own ? place->at : place->vertex, place->weight, force, f);
}

/* Adds the forces of a dowel: the derivatives V t of its energy K (d.t)^2/2. Where the joint has opened by
   `across`, a rotation of the face changes the slip: V across/length along its normal keeps the sum of
   moments zero. */
static void pull_dowel(const Dowel *d, PetscBool turns, PetscReal times, PetscBool own, PetscReal *f)
{
  const PetscReal turn = turns ? d->V * d->across / d->length : 0.;
  const Pair shear = times * d->V * LoadPair(d->t), couple = times * turn * (Pair){-d->t[1], d->t[0]};
  put(&d->on[1], shear, own, f);
  put(&d->on[0], -shear, own, f);
  if (turn != 0.) put(&d->face, couple, own, f);
}

/* Adds the forces of pieces `from` to before `to`. Each place gets the force of the piece before it minus the
   force of the piece after it. A jack is a load and is left out. */
static void pull(const Chain *c, PetscInt from, PetscInt to, PetscReal times, PetscBool own, PetscReal *f)
{
  Pair before = {0., 0.};
  for (PetscInt i = from; i <= to; i++) {
    const PetscBool any = (PetscBool)(i < to && c->branch[i] != IS_PULLED);
    const Pair behind = any ? times * c->N[i] * LoadPair(c->e + 2 * i) : (Pair){0., 0.};
    put(c->place + i, before - behind, own, f);
    before = behind;
  }
  for (const Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++)
    if (d->V != 0. && d->piece >= from && d->piece < to) pull_dowel(d, c->turns, times, own, f);
}

void ChainPull(const Chain *c, PetscReal times, PetscReal *f)
{
  pull(c, 0, c->n - 1, times, PETSC_FALSE, f);
}

void ChainPullAt(const Chain *c, PetscInt from, PetscInt to, PetscReal times, PetscReal *f)
{
  pull(c, from, to, times, PETSC_TRUE, f);
}

PetscReal ChainStored(const Chain *c)
{
  PetscReal sum = 0.;
  for (PetscInt j = 0; j + 1 < c->n; j++) sum += 0.5 * c->N[j] * c->N[j] / c->k[j];
  for (PetscInt i = c->head; i < c->n; i++) sum += 0.5 * c->b[i] * c->b[i] / c->c[i];
  for (const Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++) sum += 0.5 * d->V * d->V / d->K;
  return sum;
}

PetscReal ChainTension(const Chain *c)
{
  PetscReal high = c->N[0];
  for (PetscInt j = 1; j + 1 < c->n; j++) high = c->N[j] > high ? c->N[j] : high;
  return high;
}

PetscReal ChainLargest(const Chain *c)
{
  const PetscReal high = ChainTension(c);
  PetscReal low = c->N[0];
  for (PetscInt j = 1; j + 1 < c->n; j++) low = c->N[j] < low ? c->N[j] : low;
  return -low > high ? low : high;
}

PetscReal ChainElongation(const Chain *c)
{
  const PetscReal *slip = c->memory[CHAIN_NOW].slip;
  return c->g[0] + slip[1] - slip[0];
}

PetscReal ChainPlastic(const Chain *c)
{
  const PetscReal *plastic = c->memory[CHAIN_NOW].plastic;
  PetscReal sum = 0.;
  for (PetscInt j = 0; j + 1 < c->n; j++) sum += plastic[j];
  return sum;
}

PetscReal ChainLost(const Chain *c)
{
  const PetscReal *lost = c->memory[CHAIN_NOW].lost;
  return lost[LOST_IN_YIELD] + lost[LOST_IN_BOND] + lost[LOST_IN_DOWELS];
}

void ChainCopy(Chain *c, ChainState from, ChainState to)
{
  memcpy(c->numbers[to], c->numbers[from], c->n_numbers * sizeof(PetscReal));
}

/* ---- row sums */

/* Adds to k at the vertices of a place a bound for the row sums of k_at e e', for any e. The weights of
   its vertices sum to 1. */
static void bound_at(const Place *place, PetscReal k_at, PetscReal *k)
{
  const PetscReal oblique = 0.5 * (1. + PetscSqrtReal(2.));
  for (PetscInt i = 0; i < place->n; i++)
    k[place->vertex[i]] += oblique * k_at * PetscAbsReal(place->weight[i]);
}

/* Bounds the stiffness. The energy is the least over all slips, so it is at most the energy of a bar that
   rests while the blocks move. Then only the bond stretches, c_i at each place, and the first piece at a
   head. Rotating steel adds N/l, a dowel K, between two places each. */
void ChainBound(const Chain *c, PetscReal times, PetscReal *k)
{
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal bond = i || !c->head ? c->c[i] : c->k[0];
    bound_at(c->place + i, times * bond, k);
  }
  for (PetscInt j = 0; j + 1 < c->n && c->turns; j++)
    for (PetscInt i = j; i < j + 2; i++)
      bound_at(c->place + i, 2. * times * PetscAbsReal(c->N[j]) / c->length[j], k);
  for (const Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++)
    for (int i = 0; i < 2; i++) bound_at(&d->on[i], 2. * times * d->K, k);
}

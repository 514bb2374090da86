/* chain_solve.c: computes the slips of a bonded bar, which minimise its energy.

   The energy is convex and consists of parabolas and straight lines. So Newton's method with a line search
   ends: a step that does not change what yields, slips or goes slack has solved exactly. The method starts
   from the slips of the evaluation before, so one step mostly suffices.

   Where most of the bond slips at once, the tangent stiffness nearly vanishes, and steps are too long and
   oscillate. So after a shortened step a fraction of the elastic stiffness is added, until full steps
   succeed again (Levenberg and Marquardt). */
#include "anchors/chain.h"

enum { MOST_STEPS = 2000, MOST_CUTS = 40 };
static const PetscReal LEAST_MORE = 1e-7, MOST_MORE = 1e-3, MORE_BY = 10.; /* of the elastic stiffness */
static const PetscReal LOOSE = 1e-9;     /* of the elastic stiffness: smaller pivots are zero */
static const PetscReal ROUNDED = 1e-13;  /* of the largest force: smaller residuals are rounding */
static const PetscReal NOT_FOUND = 1e-6; /* of the largest force: a larger residual is a failure */

/* Computes force and tangent of piece j at its elastic elongation x [m]. */
static void pull(Chain *c, PetscInt j, PetscReal x)
{
  const PetscReal k = c->k[j], trial = k * x;
  Dowel *d = c->crossing[j] >= 0 ? c->dowel + c->crossing[j] : NULL;
  c->N[j] = trial, c->k_now[j] = k, c->branch[j] = ELASTIC;
  if (!j && c->jack >= 0.) {
    c->N[j] = c->jack, c->k_now[j] = 0., c->branch[j] = IS_PULLED;
  } else if (!j && c->slack && x < 0.) {
    c->N[j] = c->k_now[j] = 0., c->branch[j] = IS_SLACK;
  } else if (d) {
    const PetscReal V = d->trial / d->V_y; // 0 where the limit is infinite
    d->beyond = PetscHypotReal(trial / c->T_y, V);
    if (d->beyond <= 1.) return;
    c->branch[j] = WITH_DOWEL;
    if (c->T_y == PETSC_INFINITY) return;
    c->N[j] = trial / d->beyond, c->k_now[j] = k * V * V / (d->beyond * d->beyond * d->beyond);
  } else if (PetscAbsReal(trial) > c->T_y) {
    c->N[j] = trial > 0. ? c->T_y : -c->T_y, c->k_now[j] = 0.,
    c->branch[j] = trial > 0. ? YIELDS : YIELDS_BACK;
  }
}

/* Computes force and tangent of the bond at place i for a slip s [m]. */
static inline void bond(Chain *c, PetscInt i, PetscReal s, PetscReal slid)
{
  const PetscReal k = c->c[i], B = c->B[i], trial = k * (s - slid);
  const PetscBool slips = (PetscBool)(PetscAbsReal(trial) > B);
  c->c_now[i] = slips ? 0. : k;
  c->b[i] = !slips ? trial : trial > 0. ? B : -B;
  c->branch[c->n - 1 + i] = !slips ? ELASTIC : trial > 0. ? YIELDS : YIELDS_BACK;
}

/* Computes forces, tangents and branches at the slips s. r: (n,) receives the gradient of the energy.
   Returns whether all is elastic. */
static PetscBool evaluate(Chain *c, const PetscReal *s, PetscReal *r)
{
  const ChainMemory committed = c->memory[CHAIN_COMMITTED];
  const PetscInt n = c->n;
  PetscReal before = 0.;
  c->b[0] = 0.;
  for (PetscInt i = 0; i < n; i++) {
    if (i || !c->head) bond(c, i, s[i], committed.slid[i]);
    if (i + 1 < n) pull(c, i, c->g[i] + s[i + 1] - s[i] - committed.natural[i] - committed.plastic[i]);
    const PetscReal behind = i + 1 < n ? c->N[i] : 0.;
    r[i] = c->b[i] - behind + before;
    before = behind;
  }
  if (c->head) r[0] = 0.;
  PetscInt branches = 0;
  for (PetscInt i = 0; i < 2 * n - 1; i++) branches |= c->branch[i];
  return (PetscBool)(branches == ELASTIC);
}

/* Factors the tangent matrix. more: fraction of the elastic stiffness that is added. Returns whether the
   matrix is exact, with nothing added. */
static PetscBool factor(Chain *c, PetscReal more)
{
  PetscBool exact = (PetscBool)(more == 0.);
  for (PetscInt i = 0; i < c->n; i++) {
    const PetscReal left = i ? c->k_now[i - 1] : 0., right = i + 1 < c->n ? c->k_now[i] : 0.,
                    elastic = (i ? c->k[i - 1] : 0.) + (i + 1 < c->n ? c->k[i] : 0.) + c->c[i];
    PetscReal pivot = left + right + c->c_now[i] + more * elastic;
    if (i > (PetscInt)c->head) pivot -= left * left * c->pivot[i - 1];
    exact = (PetscBool)(exact && pivot >= LOOSE * elastic);
    c->pivot[i] = 1. / PetscMax(pivot, LOOSE * elastic);
  }
  if (c->head) c->pivot[0] = 0.;
  return exact;
}

void ChainFactor(Chain *c)
{
  (void)factor(c, 0.);
}

/* Solves the factored tangent matrix for the right side x. */
static void solve_back(const Chain *c, PetscReal *x)
{
  if (c->head) x[0] = 0.;
  for (PetscInt i = c->head + 1; i < c->n; i++) x[i] += c->k_now[i - 1] * c->pivot[i - 1] * x[i - 1];
  x[c->n - 1] *= c->pivot[c->n - 1];
  for (PetscInt i = c->n - 1; i-- > (PetscInt)c->head;) x[i] = c->pivot[i] * (x[i] + c->k_now[i] * x[i + 1]);
}

static PetscReal product(const Chain *c, const PetscReal *a, const PetscReal *b)
{
  PetscReal sum = 0.;
  for (PetscInt i = c->head; i < c->n; i++) sum += a[i] * b[i];
  return sum;
}

/* Returns the largest residual [N] at the slips s. rounding receives the part that may be rounding, of
   forces and of slips. */
static PetscReal residual(const Chain *c, const PetscReal *s, PetscReal part, PetscReal *rounding)
{
  PetscReal most = 0., way = 0., rest = 0.;
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    most = PetscMax(most, PetscAbsReal(c->N[j]));
    way = PetscMax(way, c->k[j] * (PetscAbsReal(s[j]) + PetscAbsReal(s[j + 1]) + PetscAbsReal(c->g[j])));
  }
  for (PetscInt i = c->head; i < c->n; i++) rest = PetscMax(rest, PetscAbsReal(c->r[i]));
  *rounding = part * most + 4. * PETSC_MACHINE_EPSILON * way;
  return rest;
}

static PetscBool balanced(const Chain *c, const PetscReal *s)
{
  PetscReal rounding;
  const PetscReal rest = residual(c, s, ROUNDED, &rounding);
  return (PetscBool)(rest <= rounding);
}

/* Moves along the step as far as the energy decreases. whole receives whether the full step was taken. */
static void advance(Chain *c, PetscReal *s, PetscBool *whole)
{
  PetscReal low = 0., high = 1., at = 1.;
  PetscReal slope = product(c, c->r, c->step);
  const PetscReal start = PetscAbsReal(slope);
  *whole = PETSC_TRUE;
  for (int cut = 0; cut < MOST_CUTS; cut++) {
    for (PetscInt i = c->head; i < c->n; i++) c->try[i] = s[i] + at * c->step[i];
    (void)evaluate(c, c->try, c->r);
    slope = product(c, c->r, c->step);
    if ((slope <= 0.1 * start && (at == 1. || slope >= -0.5 * start)) || balanced(c, c->try)) break;
    *whole = PETSC_FALSE;
    if (slope > 0.)
      high = at;
    else
      low = at;
    at = 0.5 * (low + high);
  }
  for (PetscInt i = c->head; i < c->n; i++) s[i] = c->try[i];
}

static PetscBool same_branches(const Chain *c, const PetscReal *s)
{
  PetscBool smooth = PETSC_TRUE;
  for (PetscInt i = 0; i < 2 * c->n - 1; i++) {
    if (c->branch[i] != c->before[i]) return PETSC_FALSE;
    smooth = (PetscBool)(smooth && c->branch[i] != WITH_DOWEL);
  }
  return smooth || balanced(c, s);
}

/* ---- elastic bar, the usual case in dynamic stages: one solve with the elastic factors */

void ChainPrepare(Chain *c)
{
  for (PetscInt j = 0; j + 1 < c->n; j++) c->k_now[j] = c->k[j];
  for (PetscInt i = 0; i < c->n; i++) c->c_now[i] = c->c[i];
  ChainFactor(c);
  memcpy(c->elastic, c->pivot, c->n * sizeof *c->pivot);
}

/* Computes the slips s of an elastic bar. Returns whether the bar is elastic. */
static PetscBool elastic(Chain *c, PetscReal *s)
{
  const ChainMemory committed = c->memory[CHAIN_COMMITTED];
  const PetscInt n = c->n, last = n - 1;
  PetscReal *x = c->try, N = 0., before = 0.;
  if (c->jack >= 0.) return PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) { // forces without slip, eliminated from the head on
    const PetscReal behind = i < last ? c->k[i] * (c->g[i] - committed.natural[i] - committed.plastic[i])
                                      : 0.;
    x[i] = c->elastic[i] * (c->c[i] * committed.slid[i] + behind - N + before);
    before = i < last ? c->k[i] * x[i] : 0.;
    N = behind;
  }
  for (PetscInt i = last; i-- > 0;) x[i] += c->elastic[i] * c->k[i] * x[i + 1];
  if (!evaluate(c, x, c->r)) return PETSC_FALSE;
  memcpy(s, x, n * sizeof *s);
  return PETSC_TRUE;
}

PetscBool ChainSolve(Chain *c)
{
  PetscReal *s = c->memory[CHAIN_NOW].slip, more = 0., rounding;
  PetscBool whole = PETSC_FALSE;
  c->is_elastic = elastic(c, s);
  if (c->is_elastic) return PETSC_TRUE;
  (void)evaluate(c, s, c->r);
  for (int step = 0; step < MOST_STEPS; step++) {
    if (step && balanced(c, s)) return PETSC_TRUE;
    memcpy(c->before, c->branch, (2 * c->n - 1) * sizeof *c->before);
    const PetscBool exact = factor(c, more);
    for (PetscInt i = 0; i < c->n; i++) c->step[i] = -c->r[i];
    solve_back(c, c->step);
    advance(c, s, &whole);
    if (exact && whole && same_branches(c, s)) return PETSC_TRUE;
    more = whole ? more / MORE_BY : PetscMin(MOST_MORE, PetscMax(LEAST_MORE, MORE_BY * more));
    if (more < LEAST_MORE) more = 0.;
  }
  return (PetscBool)(residual(c, s, NOT_FOUND, &rounding) <= rounding);
}

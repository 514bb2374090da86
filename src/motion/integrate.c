/* integrate.c: moves all degrees of freedom by the central difference (11)-(20). One loop moves them, LANES
   at once: displacements of deformable vertices as well as translations and rotations of rigid bodies. It
   can, because (7) and (14) have one form. */
#include "motion/motion.h"
#include "base/lanes_sums.h"

/* State of the loop: constants of the step, and the sums of (37) lane by lane. */
typedef struct {
  PetscReal dt, d1, d2,
      beta;        /* d1, d2: (12), (13); beta: stiffness-proportional damping, see friction_mode.c */
  PetscReal local; /* [-] fraction of the unbalanced force that opposes the velocity */
  Bins num_bins, den_bins;
  Lanes num[2], den[2], num_max, den_max;
} Sweep;

/* Terms of (37) of LANES degrees of freedom. */
typedef struct {
  Lanes num, den;
} Terms;

KERNEL void AddTerms(Sweep *w, Terms t)
{
  w->num_max = Larger(Absolute(t.num), w->num_max);
  w->den_max = Larger(t.den, w->den_max);
  BinAddLanes(&w->num_bins, t.num, w->num);
  BinAddLanes(&w->den_bins, t.den, w->den);
}

/* Moves LANES degrees of freedom. in_q: NULL when all enter the quotient. This is the last reader of f_old,
   so it clears f_old for the forces of the next cycle while the values are in the cache. local: whether local
   non-viscous damping acts; its force is proportional to the unbalanced force and opposes the velocity, so
   its work is never positive. */
KERNEL Terms MoveLanes(const Sweep *w, int local, const PetscReal *f_now, PetscReal *f_old,
                       const PetscReal *f_ext, const PetscReal *mass, const PetscReal *m_inv,
                       const PetscReal *in_q, PetscReal *v_at, PetscReal *u_at)
{
  const Lanes f = LoadLanes(f_now), df = f - LoadLanes(f_old), v = LoadLanes(v_at);
  StoreLanes(f_old, LanesOf(0.));
  // terms of (37), v.(f - f_old) and v.m v, with the velocity that led here; see damping.c
  Lanes num = v * df, den = LoadLanes(mass) * v * v;
  if (in_q) num *= LoadLanes(in_q), den *= LoadLanes(in_q);
  // (11), (16): the new velocity at the half step; (17)-(20): the displacement at the step
  Lanes r = LoadLanes(f_ext) - f - w->beta * df;
  if (local) {
    const Lanes against = w->local * Absolute(r);
    r -= Keep(v > 0., against) - Keep(v < 0., against);
  }
  const Lanes v_new = (v * w->d1 + LoadLanes(m_inv) * r * w->dt) * w->d2;
  StoreLanes(v_at, v_new);
  StoreLanes(u_at, LoadLanes(u_at) + v_new * w->dt);
  return (Terms){num, den};
}

/* Returns one term of each vertex: the sum of its x and its y. The term does not depend on the place of the
   vertex on its rank, and there are half as many terms to put into bins as degrees of freedom. */
KERNEL Lanes ByVertex(Lanes p, Lanes q)
{
  return __builtin_shufflevector(p, q, 0, 4, 2, 6) + __builtin_shufflevector(p, q, 1, 5, 3, 7);
}

KERNEL void AddVertices(Sweep *w, Terms p, Terms q)
{
  AddTerms(w, (Terms){ByVertex(p.num, q.num), ByVertex(p.den, q.den)});
}

/* Moves LANES degrees of freedom from d on, in the arrays of the state. */
KERNEL Terms MoveAt(const Sweep *w, int local, const State *s, const PetscReal *q, PetscInt d)
{
  return MoveLanes(w, local, s->f + d, s->f_old + d, s->f_ext + d, s->m + d, s->m_inv + d, q ? q + d : NULL,
                   s->v + d, s->u + d);
}

/* Moves the last n < LANES degrees of freedom, in copies padded with zeros. */
static Terms move_rest(const Sweep *w, const State *s, const PetscReal *q, PetscInt d, PetscInt n)
{
  const PetscReal *const in[8] = {s->f + d,     s->f_old + d,     s->f_ext + d, s->m + d,
                                  s->m_inv + d, q ? q + d : NULL, s->v + d,     s->u + d};
  const size_t bytes = n * sizeof(PetscReal);
  PetscReal copy[8][LANES] = {{0.}};
  for (int i = 0; i < 8; i++)
    if (in[i]) memcpy(copy[i], in[i], bytes);
  const Terms t = MoveLanes(w, w->local > 0., copy[0], copy[1], copy[2], copy[3], copy[4], q ? copy[5] : NULL,
                            copy[6], copy[7]);
  memset(s->f_old + d, 0, bytes);
  memcpy(s->v + d, copy[6], bytes);
  memcpy(s->u + d, copy[7], bytes);
  return t;
}

/* Moves a range. vertices: whether it contains whole vertices; otherwise it contains rigid bodies. */
KERNEL void MoveLoop(Sweep *w, int local, const State *s, const PetscReal *q, int vertices, PetscInt from,
                     PetscInt to)
{
  const Terms none = {LanesOf(0.), LanesOf(0.)};
  PetscInt d = from;
  for (; vertices && d + 2 * LANES <= to; d += 2 * LANES) {
    const Terms first = MoveAt(w, local, s, q, d);
    AddVertices(w, first, MoveAt(w, local, s, q, d + LANES));
  }
  for (; d < to; d += LANES) {
    const Terms t = d + LANES <= to ? MoveAt(w, local, s, q, d) : move_rest(w, s, q, d, to - d);
    if (vertices)
      AddVertices(w, t, none);
    else
      AddTerms(w, t);
  }
}

KERNEL void Move_code(const Model *m, State *state, PetscInt from, PetscInt to, Sweep *w)
{
  const State s = *state; // a copy shows the compiler that no store changes these pointers
  Sweep sums = *w;        // a copy stays in registers
  const PetscInt at = 3 * m->rigid.n;
  const PetscReal *q = m->in_quotient;
  if (sums.local > 0.) {
    MoveLoop(&sums, 1, &s, q, 0, from, PetscMin(to, at));
    MoveLoop(&sums, 1, &s, q, 1, PetscMax(from, at), to);
    *w = sums;
    return;
  }
  if (from < at) MoveLoop(&sums, 0, &s, q, 0, from, PetscMin(to, at));
  from = PetscMax(from, at);
  if (q)
    MoveLoop(&sums, 0, &s, q, 1, from, to);
  else
    MoveLoop(&sums, 0, &s, NULL, 1, from, to);
  *w = sums;
}

VARIANTS(Move, (const Model *m, State *s, PetscInt from, PetscInt to, Sweep *w), (m, s, from, to, w))

Ahead IntegrateAhead(const State *s, PetscInt from)
{
  return (Ahead){{s->v + from, s->f_old + from, s->f_ext + from, s->m + from, s->m_inv + from}};
}

void IntegrateRange(const Model *m, State *state, const QuotientSums *last, PetscInt from, PetscInt to,
                    QuotientSums *sums)
{
  const PetscReal half = 0.5 * state->alpha * state->dt, least = PETSC_MACHINE_EPSILON * PETSC_SMALL;
  Sweep w = {.dt = state->dt,
             .d1 = 1. - half,
             .d2 = 1. / (1. + half),
             .beta = state->beta,
             .local = state->local,
             .num_bins = BinsFor(PetscMax(last->num_max * SUMS_GROWTH, least)),
             .den_bins = BinsFor(PetscMax(last->den_max * SUMS_GROWTH, least))};
  Move(m, state, from, to, &w);
  for (int lane = 0; lane < LANES; lane++) {
    for (int k = 0; k < 2; k++) sums->num[k] += w.num[k][lane], sums->den[k] += w.den[k][lane];
    sums->num_max = PetscMax(sums->num_max, w.num_max[lane]);
    sums->den_max = PetscMax(sums->den_max, w.den_max[lane]);
  }
}

/* time_step.c: makes the central-difference step (11)-(20) in time and finds its works, in two sweeps over
   all degrees of freedom. Masses are true masses; alpha is constant and damps against the ground. The first
   sweep moves; the second follows when supports and coupled inertia have moved too. Each lane sums for
   itself: works decide nothing. */
#include "motion/motion.h"
#include "base/lanes.h"

typedef struct {
  PetscReal dt, d1, d2;                /* d1, d2: (12), (13) */
  PetscReal carried;                   /* [-] part of the ground's velocity that alpha gives in a step */
  const PetscReal *ground;             /* [m/s] (2,) */
  PetscReal *v_before, *f_ext_before;  /* see MoveInTime */
  Lanes outside, supports;             /* of MoveInTime */
  Lanes kinetic, damped, damped_ahead; /* of WorksInTime, the last two over alpha dt */
} Sweep;

static Sweep sweep_of(const State *s, const PetscReal ground[2], PetscReal *v_before, PetscReal *f_ext_before)
{
  const Lanes none = LanesOf(0.);
  const PetscReal half = 0.5 * s->alpha * s->dt;
  const PetscBool rests = (PetscBool)(ground[0] == 0. && ground[1] == 0.);
  return (Sweep){.dt = s->dt,
                 .d1 = 1. - half,
                 .d2 = 1. / (1. + half),
                 .carried = rests ? 0. : s->alpha * s->dt / (1. + half),
                 .ground = ground,
                 .v_before = v_before,
                 .f_ext_before = f_ext_before,
                 .outside = none,
                 .supports = none,
                 .kinetic = none,
                 .damped = none,
                 .damped_ahead = none};
}

/* Loads n <= LANES numbers, and 0 in the other lanes. */
KERNEL Lanes LoadSome(const PetscReal *x, PetscInt n)
{
  PetscReal some[LANES] = {0.};
  if (n == LANES) return LoadLanes(x);
  for (PetscInt k = 0; k < n; k++) some[k] = x[k];
  return LoadLanes(some);
}

KERNEL void StoreSome(PetscReal *x, Lanes value, PetscInt n)
{
  if (n == LANES)
    StoreLanes(x, value);
  else
    for (PetscInt k = 0; k < n; k++) x[k] = value[k];
}

/* Function of a sweep for n <= LANES degrees of freedom from d on. ground: its velocity along them. Held ones
   have inverse mass 0. */
typedef void Visit(Sweep *w, const State *s, PetscInt d, PetscInt n, Lanes ground);

KERNEL void MoveSome(Sweep *w, const State *s, PetscInt d, PetscInt n, Lanes ground)
{
  const Lanes v = LoadSome(s->v + d, n), f = LoadSome(s->f + d, n), load = LoadSome(s->f_ext + d, n),
              m_inv = LoadSome(s->m_inv + d, n), half = 0.5 * w->dt * v;
  const Mask held = m_inv == 0.;
  w->outside += half * (load + LoadSome(w->f_ext_before + d, n));
  w->supports += Keep(held, half * ((f - load) + (LoadSome(s->f_old + d, n) - load)));
  StoreSome(w->v_before + d, v, n);
  StoreSome(w->f_ext_before + d, load, n);
  Lanes v_new = (v * w->d1 + m_inv * (load - f) * w->dt) * w->d2; // (11), (16)
  Lanes u_new = LoadSome(s->u + d, n) + v_new * w->dt;            // (17)-(20)
  if (w->carried != 0.) {
    const Lanes more = Keep(~held, w->carried * ground);
    v_new += more, u_new += more * w->dt;
  }
  StoreSome(s->v + d, v_new, n);
  StoreSome(s->u + d, u_new, n);
}

KERNEL void WorkSome(Sweep *w, const State *s, PetscInt d, PetscInt n, Lanes ground)
{
  const Lanes v = LoadSome(s->v + d, n), before = LoadSome(w->v_before + d, n), middle = 0.5 * (before + v);
  const Lanes mass = Keep(LoadSome(s->m_inv + d, n) != 0., LoadSome(s->m + d, n));
  w->kinetic += 0.5 * mass * before * v;
  w->damped += mass * (middle - ground) * middle;
  w->damped_ahead += 0.5 * mass * (middle - ground) * v;
}

/* Visits `from` to `to` - 1; the velocity of the ground repeats every `period`. */
KERNEL void VisitRange(Visit *visit, Sweep *sweep, const State *s, PetscInt from, PetscInt to, int period)
{
  const PetscReal x = sweep->ground[0], y = sweep->ground[1];
  const PetscReal bodies[] = {x, y, 0., x, y, 0.}, vertices[] = {x, y, x, y};
  const PetscReal *ground = period == 3 ? bodies : vertices;
  Sweep w = *sweep; // a copy stays in registers
  PetscInt d = from;
  for (; d + LANES <= to; d += LANES) visit(&w, s, d, LANES, LoadLanes(ground + (d - from) % period));
  if (d < to) visit(&w, s, d, to - d, LoadLanes(ground + (d - from) % period));
  *sweep = w;
}

/* Visits all. Rigid bodies also turn: they have three degrees of freedom, vertices have two. */
KERNEL void VisitAll(Visit *visit, const Model *m, const State *state, Sweep *w)
{
  const State s = *state; // a copy shows the compiler that no store changes these pointers
  VisitRange(visit, w, &s, 0, 3 * m->rigid.n, 3);
  VisitRange(visit, w, &s, 3 * m->rigid.n, m->n_dof, 2);
}

KERNEL void Move_code(const Model *m, const State *s, Sweep *w)
{
  VisitAll(MoveSome, m, s, w);
}

KERNEL void Work_code(const Model *m, const State *s, Sweep *w)
{
  VisitAll(WorkSome, m, s, w);
}

VARIANTS(Move, (const Model *m, const State *s, Sweep *w), (m, s, w))
VARIANTS(Work, (const Model *m, const State *s, Sweep *w), (m, s, w))

static PetscReal total(Lanes sum)
{
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void MoveInTime(const Model *m, State *s, const PetscReal ground[2], PetscReal *v_before,
                PetscReal *f_ext_before, StepWorks *works)
{
  Sweep w = sweep_of(s, ground, v_before, f_ext_before);
  Move(m, s, &w);
  works->outside = total(w.outside);
  works->supports = total(w.supports);
}

void WorksInTime(const Model *m, const State *s, const PetscReal ground[2], PetscReal *v_before,
                 StepWorks *works)
{
  Sweep w = sweep_of(s, ground, v_before, NULL);
  Work(m, s, &w);
  works->kinetic = total(w.kinetic);
  works->damping = s->alpha * s->dt * total(w.damped);
  works->damping_ahead = s->alpha * s->dt * total(w.damped_ahead);
}

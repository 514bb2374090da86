/* coupled_inertia.c: moves vertices and rigid bodies whose inertia and dashpots are a matrix: water that
   moves with a face, ground that lets waves out. With v- and v+ half a step before and behind this time,

   (M + dt/2 D) v+ = (M - dt/2 D) v- + dt (f_ext - f + C w + p),   M = m + added mass,   D = alpha m + C,

   where a dashpot C holds against the velocity w, and p acts beside it. It is solved vertex by vertex, or
   body by body. Dashpots are centred, so they do not shorten the step; nor does added mass. alpha damps
   the blocks, not the water.

   An incoming wave has a velocity of its own, g = w/2 where it comes in through the ground. The rest of the
   motion goes out, with the power (v - g).C (v - g). This and the work of the dashpot on the model are equal
   to the power that comes in, (w/2).C (w/2) of such a wave. */
#include "motion/coupled_inertia.h"

static int size_of(const CoupledPoint *p)
{
  return p->rigid ? DOFS : 2;
}

/* ---- from what terms add */

/* Finds the row of the point to which vertex v of this rank belongs. */
static PetscErrorCode point_of(CoupledInertia *l, PetscInt v, CoupledPoint **point)
{
  const Model *m = l->m;
  const PetscInt body = v < m->mesh.n_deformable ? -1 : RigidOfVertex(m, v);
  PetscInt *row = l->row + (body < 0 ? m->rigid.n + v : body);
  PetscFunctionBeginUser;
  if (*row < 0) {
    PetscCall(MakeRoom(sizeof(CoupledPoint), l->n, &l->capacity, &l->point));
    l->point[l->n] = (CoupledPoint){.dof = body < 0 ? 3 * m->rigid.n + 2 * v : 3 * body,
                                    .rigid = (PetscBool)(body >= 0)};
    *row = l->n++;
  }
  *point = l->point + *row;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the motion of a vertex by the degrees of freedom of its body, (2,3): about the mass centre of the
   reference state. For a deformable vertex it is the unit matrix. */
static void arms(const Model *m, PetscInt v, PetscReal T[2][DOFS])
{
  const PetscInt body = v < m->mesh.n_deformable ? -1 : RigidOfVertex(m, v);
  T[0][0] = T[1][1] = 1.;
  T[0][1] = T[1][0] = T[0][2] = T[1][2] = 0.;
  if (body < 0) return;
  T[0][2] = -(m->mesh.X[2 * v + 1] - m->rigid.X[2 * body + 1]);
  T[1][2] = m->mesh.X[2 * v] - m->rigid.X[2 * body];
}

/* Adds T_i' block T_j to sum. block: the rows of vertex i and the columns of vertex j of k, (2n,2n). */
static void add_block(const Model *m, PetscInt n, const PetscReal *k, PetscInt i, PetscInt j,
                      const PetscInt *vertices, Square sum)
{
  PetscReal Ti[2][DOFS], Tj[2][DOFS];
  arms(m, vertices[i], Ti);
  arms(m, vertices[j], Tj);
  for (int a = 0; a < DOFS; a++)
    for (int b = 0; b < DOFS; b++)
      for (int x = 0; x < 2; x++)
        for (int y = 0; y < 2; y++) sum[a][b] += Ti[x][a] * k[(2 * i + x) * 2 * n + 2 * j + y] * Tj[y][b];
}

/* Adds a matrix of mass and dashpots. Vertices of a rigid body take the whole matrix; a deformable one takes
   the sum of its row of blocks, as masses of blocks are lumped. */
static PetscErrorCode add(PetscInt n, const PetscInt *vertices, const PetscReal *mass,
                          const PetscReal *dashpot, void *context)
{
  CoupledInertia *l = context;
  const Model *m = l->m;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt v = vertices[i];
    CoupledPoint *point = NULL;
    if (v >= m->mesh.n_moving) continue;
    PetscCall(point_of(l, v, &point));
    for (PetscInt j = 0; j < n && mass; j++) {
      const PetscBool lumps = (PetscBool)(v < m->mesh.n_deformable);
      if (lumps)
        for (int a = 0; a < 2; a++)
          for (int b = 0; b < 2; b++) point->mass[a][b] += mass[(2 * i + a) * 2 * n + 2 * j + b];
      else
        add_block(m, n, mass, i, j, vertices, point->mass);
    }
    for (int a = 0; a < 2 && dashpot && v < m->mesh.n_deformable; a++)
      for (int b = 0; b < 2; b++) point->dashpot[a][b] += dashpot[(2 * i + a) * 2 * n + 2 * i + b];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int by_dof(const void *a, const void *b)
{
  const CoupledPoint *p = a, *q = b;
  return (p->dof > q->dof) - (p->dof < q->dof);
}

PetscErrorCode CoupledCreate(const TermView *view, const PetscReal *u_start, CoupledInertia **local)
{
  const Model *m = view->m;
  const PetscInt n = m->rigid.n + m->mesh.n_deformable;
  CoupledInertia *l;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&l));
  l->m = m;
  PetscCall(PetscMalloc1(n, &l->row));
  for (PetscInt i = 0; i < n; i++) l->row[i] = -1;
  PetscCall(TermsInertia(view, add, l));
  PetscCall(PetscFree(l->row));
  if (l->n) {
    qsort(l->point, l->n, sizeof(CoupledPoint), by_dof);
    PetscCall(PetscCalloc3(2 * m->mesh.n_deformable, &l->in.w, 2 * m->mesh.n_deformable, &l->in.wave,
                           2 * m->mesh.n_deformable, &l->in.push));
  }
  if (u_start) PetscCall(CoupledBodiesCreate(view, u_start, l));
  *local = l;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledDestroy(CoupledInertia **local)
{
  PetscFunctionBeginUser;
  if (!*local) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CoupledBodiesDestroy(*local));
  PetscCall(PetscFree((*local)->point));
  PetscCall(PetscFree3((*local)->in.w, (*local)->in.wave, (*local)->in.push));
  PetscCall(PetscFree(*local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledMasses(const CoupledInertia *l, CoupledTake take, void *context)
{
  PetscFunctionBeginUser;
  for (const CoupledPoint *p = l->point; p < l->point + l->n; p++)
    PetscCall(take(p->dof, size_of(p), p->mass, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step */

/* Solves a x = b; x is known where a degree of freedom is held. Overwrites a and b. Needs no pivots: the rest
   of a is positive definite. */
static void solve(const CoupledPoint *p, const Model *m, Square a, PetscReal *b, PetscReal *x)
{
  for (int i = 0; i < size_of(p); i++) {
    if (!Held(m, p->dof + i)) continue;
    for (int j = 0; j < size_of(p); j++) {
      if (j != i) b[j] -= a[j][i] * x[i];
      a[i][j] = a[j][i] = 0.;
    }
    a[i][i] = 1., b[i] = x[i];
  }
  for (int k = 0; k < size_of(p); k++)
    for (int i = k + 1; i < size_of(p); i++) {
      const PetscReal factor = a[i][k] / a[k][k];
      for (int j = k; j < size_of(p); j++) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  for (int i = size_of(p) - 1; i >= 0; i--) {
    x[i] = b[i];
    for (int j = i + 1; j < size_of(p); j++) x[i] -= a[i][j] * x[j];
    x[i] /= a[i][i];
  }
}

/* Returns the velocity [m/s] against which alpha damps along degree of freedom i of a point. */
static PetscReal of_ground(const PetscReal ground[2], int i)
{
  return i < 2 ? ground[i] : 0.;
}

/* Collects the incoming velocities. Entries of vertices without a point are never read, so they are not
   cleared. */
static void find_incoming(CoupledInertia *l, const State *s, PetscReal part)
{
  const PetscInt at = 3 * l->m->rigid.n;
  const Pair none = {0., 0.};
  for (const CoupledPoint *p = l->point; p < l->point + l->n; p++) {
    if (p->rigid) continue;
    StorePair(l->in.w + p->dof - at, none);
    StorePair(l->in.wave + p->dof - at, none);
    StorePair(l->in.push + p->dof - at, none);
  }
  l->in.part = part;
  TermsIncoming(l->m, s, &l->in);
}

/* Inverts the matrices of the points for the step and alpha of the state. */
static PetscErrorCode find_inverses(CoupledInertia *l, const State *s)
{
  PetscFunctionBeginUser;
  if (l->dt == s->dt && l->alpha == s->alpha) PetscFunctionReturn(PETSC_SUCCESS);
  l->dt = s->dt, l->alpha = s->alpha;
  PetscCall(CoupledBodiesInvert(l, s));
  for (CoupledPoint *p = l->point; p < l->point + l->n; p++) {
    p->heavy = p->damped = p->held = PETSC_FALSE;
    for (int i = 0; i < size_of(p); i++) {
      if (p->mass[i][i] != 0.) p->heavy = PETSC_TRUE;
      if (p->dashpot[i][i] != 0.) p->damped = PETSC_TRUE;
      if (Held(l->m, p->dof + i)) p->held = PETSC_TRUE;
    }
    for (int column = 0; column < size_of(p); column++) {
      PetscReal b[DOFS] = {0.}, x[DOFS] = {0.};
      Square a = {{0.}};
      for (int i = 0; i < size_of(p); i++) {
        for (int j = 0; j < size_of(p); j++) a[i][j] = p->mass[i][j] + 0.5 * s->dt * p->dashpot[i][j];
        a[i][i] += s->m[p->dof + i] * (1. + 0.5 * s->dt * s->alpha);
      }
      b[column] = 1.;
      solve(p, l->m, a, b, x);
      for (int i = 0; i < size_of(p); i++) p->inverse[i][column] = Held(l->m, p->dof + column) ? 0. : x[i];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds v_1 - v_0 = dt (M + dt/2 D)^-1 (f_ext - f + C (w - v_0) + p - alpha m (v_0 - ground)). Where a degree
   of freedom is held it is known, and its inertia is a force on the others. */
KERNEL void accelerate(const CoupledInertia *l, const CoupledPoint *p, int n, const State *s,
                       const PetscReal *v_0, const PetscReal ground[2], PetscReal *v_1)
{
  const PetscReal *w = CoupledEntries(l, p, l->in.w), *push = CoupledEntries(l, p, l->in.push),
                  *v = s->v + p->dof;
  PetscReal less[DOFS], force[DOFS] = {0.}, change[DOFS];
  for (int i = 0; i < n; i++) less[i] = w[i] - v_0[i];
  if (p->damped) CoupledTimes(n, p->dashpot, less, force);
  for (int i = 0; i < n; i++) {
    const PetscInt d = p->dof + i;
    force[i] += push[i] + s->f_ext[d] - s->f[d] - s->alpha * s->m[d] * (v_0[i] - of_ground(ground, i));
    for (int j = 0; j < n && p->held; j++)
      if (Held(l->m, p->dof + j))
        force[i] -= (p->mass[i][j] + 0.5 * s->dt * p->dashpot[i][j]) * (v[j] - v_0[j]) / s->dt;
  }
  CoupledTimes(n, p->inverse, force, change);
  for (int i = 0; i < n; i++) v_1[i] = p->held && Held(l->m, p->dof + i) ? v[i] : v_0[i] + s->dt * change[i];
}

KERNEL void move_point(const CoupledInertia *l, const CoupledPoint *p, int n, State *s, const PetscReal *v_0,
                       const PetscReal ground[2], PetscReal works[COUPLED_WORKS])
{
  PetscReal v_1[DOFS], *v = s->v + p->dof, *u = s->u + p->dof;
  accelerate(l, p, n, s, v_0, ground, v_1);
  for (int i = 0; i < n; i++) {
    u[i] += (v_1[i] - v[i]) * s->dt; // the step has moved it as if it had its own mass only
    v[i] = v_1[i];
  }
  CoupledBookWork(l, p, n, s->dt, v_0, v_1, works);
}

/* Returns a x, (2,2). */
KERNEL Pair by(const Square a, Pair x)
{
  const Pair first = {a[0][0], a[1][0]}, second = {a[0][1], a[1][1]};
  return first * x[0] + second * x[1];
}

/* Moves a vertex that is not held, x and y at once: ground has many such vertices. */
KERNEL void move_vertex(const CoupledInertia *l, const CoupledPoint *p, const State *s,
                        const PetscReal *v_before, Pair ground, Pair works[COUPLED_WORKS])
{
  const PetscInt d = p->dof, at = d - 3 * l->m->rigid.n;
  const Pair v_0 = LoadPair(v_before + d), push = LoadPair(l->in.push + at), w = LoadPair(l->in.w + at);
  const Pair of_alpha = s->alpha * LoadPair(s->m + d) * (v_0 - ground);
  Pair force = push + LoadPair(s->f_ext + d) - LoadPair(s->f + d) - of_alpha;
  if (p->damped) force = by(p->dashpot, w - v_0) + force;
  const Pair v_1 = v_0 + s->dt * by(p->inverse, force), mean = 0.5 * (v_0 + v_1), way = s->dt * mean;
  StorePair(s->u + d, LoadPair(s->u + d) + (v_1 - LoadPair(s->v + d)) * s->dt);
  StorePair(s->v + d, v_1);
  if (p->heavy) works[COUPLED_KINETIC] += 0.5 * v_1 * by(p->mass, v_0);
  works[COUPLED_SUPPORTS] += push * way, works[COUPLED_SUPPORTS_AHEAD] += push * v_1;
  if (!p->damped) return;
  const Pair dashpot = by(p->dashpot, w - mean), rest = mean - LoadPair(l->in.wave + at);
  works[COUPLED_INCOMING] += dashpot * mean + rest * by(p->dashpot, rest);
  works[COUPLED_DASHPOTS] += dashpot * way, works[COUPLED_DASHPOTS_AHEAD] += dashpot * v_1;
}

/* Moves all such vertices. Their works are sums over x and y, some of them without dt. */
KERNEL void MoveVertices_code(const CoupledInertia *l, const State *state, const PetscReal *v_before,
                              const PetscReal *ground, PetscReal *works)
{
  const State s = *state; // a copy shows the compiler that no store changes these pointers
  const Pair against = {ground[0], ground[1]};
  const PetscReal unit[COUPLED_WORKS] = {[COUPLED_KINETIC] = 1.,  [COUPLED_INCOMING] = s.dt,
                                         [COUPLED_DASHPOTS] = 1., [COUPLED_DASHPOTS_AHEAD] = 0.5 * s.dt,
                                         [COUPLED_SUPPORTS] = 1., [COUPLED_SUPPORTS_AHEAD] = 0.5 * s.dt};
  Pair sum[COUPLED_WORKS] = {{0.}};
  for (const CoupledPoint *p = l->point; p < l->point + l->n; p++)
    if (!p->rigid && !p->held && !p->condensed) move_vertex(l, p, &s, v_before, against, sum);
  for (int k = 0; k < COUPLED_WORKS; k++) works[k] += unit[k] * (sum[k][0] + sum[k][1]);
}

VARIANTS(MoveVertices,
         (const CoupledInertia *l, const State *state, const PetscReal *v_before, const PetscReal *ground,
          PetscReal *works),
         (l, state, v_before, ground, works))

PetscErrorCode CoupledStep(CoupledInertia *l, State *s, const PetscReal *v_before, const PetscReal ground[2],
                           PetscReal part, PetscReal works[COUPLED_WORKS])
{
  PetscFunctionBeginUser;
  works[COUPLED_KINETIC] = works[COUPLED_SUPPORTS_AHEAD] = works[COUPLED_DASHPOTS_AHEAD] = 0.;
  works[COUPLED_INSIDE] = works[COUPLED_STRAIN] = works[COUPLED_DRAG_AHEAD] = 0.;
  find_incoming(l, s, part);
  if (!l->n && !l->n_bodies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_inverses(l, s));
  for (const CoupledPoint *p = l->point; p < l->point + l->n; p++) {
    if (p->rigid) move_point(l, p, DOFS, s, v_before + p->dof, ground, works);
    if (!p->rigid && p->held && !p->condensed) move_point(l, p, 2, s, v_before + p->dof, ground, works);
  }
  MoveVertices(l, s, v_before, ground, works);
  CoupledBodiesStep(l, s, v_before, ground, works);
  for (CoupledBody *b = l->body; b < l->body + l->n_bodies && part == 0.; b++) b->known = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledHalfStep(CoupledInertia *l, State *s, const PetscReal *v_before,
                               const PetscReal ground[2], PetscReal sign)
{
  PetscFunctionBeginUser;
  find_incoming(l, s, 0.5 * sign);
  PetscCall(CoupledBodiesHalfStep(l, s, v_before, ground, sign));
  for (const CoupledPoint *p = l->point; p < l->point + l->n; p++) {
    if (p->condensed) continue;
    const PetscReal *w = CoupledEntries(l, p, l->in.w), *push = CoupledEntries(l, p, l->in.push),
                    *v_0 = v_before + p->dof;
    PetscReal less[DOFS] = {0.}, b[DOFS] = {0.}, change[DOFS] = {0.};
    Square a = {{0.}};
    for (int i = 0; i < size_of(p); i++) less[i] = w[i] - v_0[i];
    CoupledTimes(size_of(p), p->dashpot, less, b);
    for (int i = 0; i < size_of(p); i++) {
      const PetscInt d = p->dof + i;
      b[i] += push[i] + s->f_ext[d] - s->f[d] - s->alpha * s->m[d] * (v_0[i] - of_ground(ground, i));
      for (int j = 0; j < size_of(p); j++) a[i][j] = p->mass[i][j];
      a[i][i] += s->m[d];
    }
    solve(p, l->m, a, b, change);
    for (int i = 0; i < size_of(p); i++)
      if (!Held(l->m, p->dof + i)) s->v[p->dof + i] = v_0[i] + sign * 0.5 * s->dt * change[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

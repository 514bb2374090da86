/* coupled_bodies.c: moves condensed bodies in time (condense_in_time.c). With x = (u_B, q), the inertia M of
   (d) beside the lumped masses and added masses of kept vertices, and D = alpha M + C, a step is that of
   coupled_inertia.c,

   (M + dt/2 D) (v+ - v-) = dt (f_ext - f - Omega^2 q + C (w - v-) + p - alpha M (v- - ground)),

   solved with the inverse, which is as constant as the step. f has S u_B (condense.c). Modes have no
   inertia in common, so they are eliminated, and only the matrix of kept vertices is inverted: with
   H = Psi' M Phi and w = 1 + alpha dt/2

   a_q = y (f_q / w - H' a_B),   (M_BB + dt/2 D_BB - w H y H') a_B = f_B - H y f_q,   y = w / (w + dt/2 c),

   where c are the dashpots of gathered modes (condense_left_out.c), centred as the dashpots of points.

   Damping by stiffness is a force, of the velocity before: among f, and -beta Omega^2 q'- beside -Omega^2 q.
   A body that lacks modes has it centred besides, so that it does not shorten the step: beta S is in D_BB and
   beta Omega^2 in c. Its effect beside the force of the velocity before is dt/2 beta (v- + v+)/2 .
   S (v+ - v-) in a step. Its sum is dt/4 beta v-.S v+, which needs no account.

   The body belongs to one rank, and its sums run in one order, so bits do not depend on the ranks.

   Vertices that one support holds move alike: along each direction they are one degree of freedom of known
   motion. The force on it does the work of the support. */
#include "motion/coupled_inertia.h"
#include <petscblaslapack.h>

/* ---- set-up */

static PetscInt padded(PetscInt n)
{
  return (n + BATCH - 1) / BATCH * BATCH;
}

/* Returns the kept degree of freedom of component x of a point at a vertex of the body. */
static PetscInt kept_of(const CoupledInertia *l, const CoupledBody *b, const CoupledPoint *p, int x)
{
  const PetscInt entry = p->dof - 3 * l->m->rigid.n + x;
  PetscInt low = 0, high = b->of->n_kept; // kept[low] <= entry < kept[high]
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;
    if (b->of->kept[middle] <= entry)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* Decides whether calm vertices may move by shapes: not where contacts may come anywhere, nor beside free
   ground, which pushes at their sides with waves faster than the shapes allow. */
static PetscBool may_be_calm(const TermView *view)
{
  PetscBool calm = (PetscBool)!ContactsVary(view->contacts, view->stage);
  for (PetscInt i = 0; i < view->scene->n_supports; i++)
    if (view->scene->supports[i].boundary == BOUNDARY_FREE_FIELD) calm = PETSC_FALSE;
  return calm;
}

/* Numbers the rows. */
static PetscErrorCode find_rows(const CoupledInertia *l, const TermView *view, const PetscReal *u_start,
                                CoupledBody *b)
{
  const Model *m = l->m;
  Condensed *c = m->condensed.body + (b - l->body);
  PetscReal *mass;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n_kept * c->n_kept, &mass));
  for (PetscInt i = 0; i < c->n_kept; i++) mass[i * c->n_kept + i] = m->vertex_mass[c->kept[i] / 2];
  for (PetscInt k = 0; k < b->n_points; k++) {
    const CoupledPoint *p = l->point + b->point[k];
    for (int x = 0; x < 2; x++)
      for (int y = 0; y < 2; y++)
        mass[kept_of(l, b, p, x) * c->n_kept + kept_of(l, b, p, y)] += p->mass[x][y];
  }
  PetscCall(CondensedRowsCreate(m, may_be_calm(view), mass, u_start + 3 * m->rigid.n, c));
  PetscCall(PetscFree(mass));
  b->rows = c->rows;
  b->n_free = c->rows->n_firm + c->rows->n_shapes, b->n = c->rows->n_rows;
  b->free_slots = c->rows->n_firm + c->rows->n_calm, b->n_slots = c->rows->n_slots;
  b->stride = padded(b->n), b->width = padded(c->n_modes);
  for (PetscInt k = 0; k < b->n_points; k++)
    for (int x = 0; x < 2; x++) b->slot[2 * k + x] = c->rows->slot[kept_of(l, b, l->point + b->point[k], x)];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers the inertia by rows of the body. */
static PetscErrorCode gather_inertia(CoupledBody *b)
{
  const Condensed *c = b->of;
  PetscReal *inertia, *couples, *truncated;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc7(b->stride * b->stride, &b->inertia, b->stride * b->width, &b->couples,
                         b->stride * b->width, &b->coupled, 2 * b->n, &b->along, b->width, &b->yields,
                         b->stride * b->stride, &b->inverse, b->stride * b->stride, &b->truncated));
  PetscCall(PetscCalloc3(b->n * b->n, &inertia, b->n * c->n_modes, &couples, b->n * b->n, &truncated));
  PetscCall(CondensedFoldBoth(b->rows, c->n_kept, c->size, c->inertia, inertia));
  PetscCall(CondensedFold(b->rows, c->n_kept, c->n_modes, c->size, c->inertia + c->n_kept, couples));
  PetscCall(CondensedFold(b->rows, c->n_kept, 2, 2, c->along, b->along));
  if (c->truncated) PetscCall(CondensedFoldBoth(b->rows, c->n_kept, c->stride, c->truncated, truncated));
  for (PetscInt i = 0; i < b->n; i++) {
    PetscCall(PetscArraycpy(b->inertia + i * b->stride, inertia + i * b->n, b->n));
    PetscCall(PetscArraycpy(b->truncated + i * b->stride, truncated + i * b->n, b->n));
    for (PetscInt k = 0; k < c->n_modes; k++)
      b->couples[k * b->stride + i] = b->coupled[i * b->width + k] = couples[i * c->n_modes + k];
  }
  PetscCall(PetscFree3(inertia, couples, truncated));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledBodiesCreate(const TermView *view, const PetscReal *u_start, CoupledInertia *l)
{
  const Model *m = l->m;
  PetscFunctionBeginUser;
  l->n_bodies = m->condensed.n;
  PetscCall(PetscCalloc1(l->n_bodies, &l->body));
  for (PetscInt i = 0; i < l->n_bodies; i++) {
    CoupledBody *b = l->body + i;
    b->of = m->condensed.body + i;
    PetscCall(PetscMalloc2(l->n, &b->point, 2 * l->n, &b->slot));
    for (PetscInt p = 0; p < l->n; p++)
      if (IsCondensed(m, l->point[p].dof) && !l->point[p].rigid &&
          m->mesh.vertex_condensed[(l->point[p].dof - 3 * m->rigid.n) / 2] == b->of->number)
        l->point[p].condensed = PETSC_TRUE, b->point[b->n_points++] = p;
    PetscCall(find_rows(l, view, u_start, b));
    PetscCall(gather_inertia(b));
    for (int k = 0; k < BODY_VECTORS; k++)
      PetscCall(PetscCalloc2(b->stride, &b->kept[k], b->width, &b->modes[k]));
    for (int k = 0; k < SLOT_VECTORS; k++) PetscCall(PetscCalloc1(b->n_slots, &b->slots[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledBodiesDestroy(CoupledInertia *l)
{
  PetscFunctionBeginUser;
  for (CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) {
    PetscCall(CondensedRowsDestroy(l->m->condensed.body + (b - l->body)));
    PetscCall(PetscFree7(b->inertia, b->couples, b->coupled, b->along, b->yields, b->inverse, b->truncated));
    for (int k = 0; k < BODY_VECTORS; k++) PetscCall(PetscFree2(b->kept[k], b->modes[k]));
    for (int k = 0; k < SLOT_VECTORS; k++) PetscCall(PetscFree(b->slots[k]));
    PetscCall(PetscFree2(b->point, b->slot));
  }
  PetscCall(PetscFree(l->body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the damper [1/s] of mode k in the middle of the step. */
static PetscReal centred_damper(const CoupledBody *b, PetscInt k)
{
  return b->of->damper[k] + CondensedCentred(b->of) * b->of->omega2[k];
}

/* Returns the factor on mass by damping over a step. */
static PetscReal damped_mass(const State *s, PetscReal step)
{
  return 1. + 0.5 * step * s->alpha;
}

/* Adds the added masses and dashpots of the points. */
static PetscErrorCode add_points_to(const CoupledInertia *l, const CoupledBody *b, PetscReal step,
                                    PetscReal *A)
{
  PetscReal *row[2];
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(b->n, &row[0], b->n, &row[1]));
  for (PetscInt k = 0; k < b->n_points; k++) {
    const CoupledPoint *p = l->point + b->point[k];
    for (int x = 0; x < 2; x++) CondensedRowOf(b->rows, b->slot[2 * k + x], 1., row[x]);
    for (int x = 0; x < 2; x++)
      for (int y = 0; y < 2; y++) {
        const PetscReal value = p->mass[x][y] + 0.5 * step * p->dashpot[x][y];
        for (PetscInt i = 0; i < b->n_free && value != 0.; i++)
          for (PetscInt j = 0; j < b->n_free && row[x][i] != 0.; j++)
            A[i * b->stride + j] += row[x][i] * value * row[y][j];
      }
  }
  PetscCall(PetscFree2(row[0], row[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Inverts the matrix of the kept degrees of freedom that are not held. step 0: of their inertia alone. */
static PetscErrorCode invert(const CoupledInertia *l, const CoupledBody *b, const State *s, PetscReal step)
{
  const PetscReal whole = damped_mass(s, step), minus = -whole, one = 1.;
  const PetscBLASInt n = (PetscBLASInt)b->n_free, stride = (PetscBLASInt)b->stride,
                     k = (PetscBLASInt)b->of->n_modes;
  PetscReal *A = b->inverse, *left;
  PetscBLASInt info = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < b->of->n_modes; i++)
    b->yields[i] = whole / (whole + 0.5 * step * centred_damper(b, i));
  PetscCall(PetscArrayzero(A, b->stride * b->stride));
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < b->n_free; i++) {
    for (PetscInt j = 0; j < b->n_free; j++)
      A[i * b->stride + j] = whole * b->inertia[i * b->stride + j] +
                             0.5 * step * CondensedCentred(b->of) * b->rows->S[i * b->stride + j];
    A[i * b->stride + i] += whole * (i < b->rows->n_firm ? b->rows->mass[i] : 1.);
  }
  PetscCall(add_points_to(l, b, step, A));
  PetscCall(PetscMalloc1(b->stride * b->width, &left));
  for (PetscInt i = 0; i < b->stride * b->of->n_modes; i++)
    left[i] = b->yields[i / b->stride] * b->couples[i];
  if (k)
    PetscCallBLAS("BLASgemm", BLASgemm_("N", "T", &n, &n, &k, &minus, left, &stride, b->couples, &stride,
                                        &one, A, &stride));
  PetscCall(PetscFree(left));
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &n, A, &stride, &info));
  if (!info) PetscCallBLAS("LAPACKpotri", LAPACKpotri_("L", &n, A, &stride, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "the inertia of a condensed body has no inverse: %d",
             (int)info);
  for (PetscInt i = 0; i < b->n_free; i++) // the lower triangle by columns
    for (PetscInt j = 0; j < i; j++) A[i * b->stride + j] = A[j * b->stride + i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CoupledBodiesInvert(CoupledInertia *l, const State *s)
{
  PetscFunctionBeginUser;
  for (const CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) PetscCall(invert(l, b, s, s->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step */

/* Finds the motion of rows that modes feel (CARRIED), from the vector v into the vector carried. */
static void find_carried(const CoupledBody *b, int v, int carried)
{
  DenseTimes(b->width, b->stride, b->coupled, b->kept[v], b->modes[carried]);
}

/* Finds the momenta that belong to velocities, likewise. */
static void find_momentum(const CoupledBody *b, int v, int carried, int momentum)
{
  PetscReal *kept = b->kept[momentum], *modes = b->modes[momentum];
  DenseTimes(b->stride, b->stride, b->inertia, b->kept[v], kept);
  DenseTimes(b->stride, b->width, b->couples, b->modes[v], b->kept[ROOM]);
  for (PetscInt i = 0; i < b->n; i++) kept[i] += b->kept[ROOM][i];
  for (PetscInt k = 0; k < b->of->n_modes; k++) modes[k] = b->modes[carried][k] + b->modes[v][k];
}

/* Makes the vectors after the last step those before this one. */
static void hand_on(CoupledBody *b)
{
  static const int pairs[][2] = {
      {V_BEFORE, V_BEHIND}, {CARRIED, CARRIED_BEHIND}, {MOMENTUM, MOMENTUM_BEHIND}};
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(pairs); i++) {
    const int before = pairs[i][0], behind = pairs[i][1];
    PetscReal *const spare[2] = {b->kept[before], b->modes[before]};
    b->kept[before] = b->kept[behind], b->kept[behind] = spare[0];
    b->modes[before] = b->modes[behind], b->modes[behind] = spare[1];
  }
}

/* Finds the velocities before the step, from the velocities of the degrees of freedom, v, and of the modes,
   and their momenta. */
static void gather(const CoupledInertia *l, CoupledBody *b, const State *s, const PetscReal *v)
{
  const PetscInt at = 3 * l->m->rigid.n;
  for (PetscInt i = 0; i < b->n_slots; i++)
    b->slots[SLOT_BEFORE][i] = b->slots[SLOT_FORCE][i] = v[at + b->rows->dof[i]];
  if (b->known) {
    hand_on(b);
    return;
  }
  CondensedFind(b->rows, b->slots[SLOT_FORCE], b->kept[V_BEFORE]);
  memcpy(b->modes[V_BEFORE], s->modes[MODE_SPEED] + b->of->first_mode, b->of->n_modes * sizeof(PetscReal));
  find_carried(b, V_BEFORE, CARRIED);
  find_momentum(b, V_BEFORE, CARRIED, MOMENTUM);
}

/* Returns the force of damping by mass beside the force of lumped masses. along: [kg] (2,) mass that the
   ground moves. */
static PetscReal drag_of(const State *s, PetscReal momentum, const PetscReal *along,
                         const PetscReal ground[2])
{
  return s->alpha * (momentum - along[0] * ground[0] - along[1] * ground[1]);
}

/* Returns the mass of mode k that moves along with the ground. */
static const PetscReal *along_mode(const CoupledBody *b, PetscInt k)
{
  return b->of->along + 2 * (b->of->n_kept + k);
}

/* Adds the forces of added mass and dashpots of the points. */
static void add_points(const CoupledInertia *l, const CoupledBody *b, PetscReal step)
{
  const PetscReal *v_0 = b->slots[SLOT_BEFORE], *v_1 = b->slots[SLOT_BEHIND];
  for (PetscInt k = 0; k < b->n_points; k++) {
    const CoupledPoint *p = l->point + b->point[k];
    const PetscReal *w = CoupledEntries(l, p, l->in.w), *push = CoupledEntries(l, p, l->in.push);
    const PetscInt *slot = b->slot + 2 * k;
    for (int x = 0; x < 2; x++) {
      if (slot[x] >= b->free_slots) continue;
      PetscReal *force = b->slots[SLOT_FORCE] + slot[x];
      *force += push[x];
      for (int y = 0; y < 2; y++) {
        *force += p->dashpot[x][y] * (w[y] - v_0[slot[y]]);
        if (slot[y] >= b->free_slots && step > 0.)
          *force -= (p->mass[x][y] + 0.5 * step * p->dashpot[x][y]) * (v_1[slot[y]] - v_0[slot[y]]) / step;
      }
    }
  }
}

/* Subtracts the inertia forces of moving supports. */
static void add_supports(const CoupledBody *b, const State *s, PetscReal step)
{
  const PetscReal damped = 0.5 * CondensedCentred(b->of);
  for (PetscInt j = b->n_free; j < b->n && step > 0.; j++) {
    const PetscReal dv = b->kept[V_BEHIND][j] - b->kept[V_BEFORE][j], a = damped_mass(s, step) * dv / step;
    if (a == 0.) continue;
    for (PetscInt i = 0; i < b->n_free; i++)
      b->kept[FORCE][i] -= b->inertia[j * b->stride + i] * a + damped * b->rows->S[j * b->stride + i] * dv;
    for (PetscInt k = 0; k < b->of->n_modes; k++) b->modes[FORCE][k] -= b->coupled[j * b->width + k] * a;
  }
}

static void find_forces(const CoupledInertia *l, const CoupledBody *b, const State *s,
                        const PetscReal ground[2], PetscReal step)
{
  const PetscReal *q = s->modes[MODE_PLACE] + b->of->first_mode, *v = b->slots[SLOT_BEFORE];
  const PetscInt at = 3 * l->m->rigid.n;
  PetscReal *kept = b->kept[FORCE], *modes = b->modes[FORCE];
  for (PetscInt i = 0; i < b->free_slots; i++) {
    const PetscInt d = b->rows->dof[i];
    b->slots[SLOT_FORCE][i] = s->f_ext[at + d] - s->f[at + d] -
                              s->alpha * s->m[at + d] * (v[i] - ground[d % 2]);
  }
  add_points(l, b, step);
  CondensedSum(b->rows, b->slots[SLOT_FORCE], kept);
  for (PetscInt k = 0; k < b->of->n_modes; k++)
    modes[k] = -b->of->omega2[k] * q[k] - CondensedDamper(b->of, k) * b->modes[V_BEFORE][k];
  if (s->alpha != 0.) {
    for (PetscInt i = 0; i < b->n_free; i++)
      kept[i] -= drag_of(s, b->kept[MOMENTUM][i], b->along + 2 * i, ground);
    for (PetscInt k = 0; k < b->of->n_modes; k++)
      modes[k] -= drag_of(s, b->modes[MOMENTUM][k], along_mode(b, k), ground);
  }
  add_supports(b, s, step);
}

/* Finds the acceleration of rows over the step, and the acceleration of modes by forces alone, times `whole`.
   step 0: at once, with supports at constant velocity. V_BEFORE, and V_BEHIND of held rows, are known. */
static void accelerate(const CoupledInertia *l, CoupledBody *b, const State *s, const PetscReal ground[2],
                       PetscReal step)
{
  find_forces(l, b, s, ground, step);
  for (PetscInt k = 0; k < b->of->n_modes; k++) b->modes[FORCE][k] *= b->yields[k];
  DenseTimes(b->stride, b->width, b->couples, b->modes[FORCE], b->kept[ROOM]);
  for (PetscInt i = 0; i < b->n_free; i++) b->kept[FORCE][i] -= b->kept[ROOM][i];
  DenseTimes(b->stride, b->stride, b->inverse, b->kept[FORCE], b->kept[ACCELERATION]);
}

/* Finds the velocities of modes after the step, when the velocities of rows are known. The forces on modes
   include the supports already. */
static void accelerate_modes(const CoupledBody *b, const State *s)
{
  const PetscReal whole = damped_mass(s, s->dt), *carried[2] = {b->modes[CARRIED], b->modes[CARRIED_BEHIND]};
  PetscReal *by_rows = b->modes[ROOM], *v_1 = b->modes[V_BEHIND];
  for (PetscInt k = 0; k < b->of->n_modes; k++) by_rows[k] = carried[1][k] - carried[0][k];
  for (PetscInt j = b->n_free; j < b->n; j++) {
    const PetscReal dv = b->kept[V_BEHIND][j] - b->kept[V_BEFORE][j];
    for (PetscInt k = 0; k < b->of->n_modes && dv != 0.; k++) by_rows[k] -= b->coupled[j * b->width + k] * dv;
  }
  for (PetscInt k = 0; k < b->of->n_modes; k++)
    v_1[k] = b->modes[V_BEFORE][k] + s->dt * b->modes[FORCE][k] / whole - b->yields[k] * by_rows[k];
}

/* Books the works of the step at one degree of freedom: velocities and momenta before and after it. damper:
   [N] its own damper. Returns the force that moves it along. */
static PetscReal book_one(const State *s, PetscReal *const x[BODY_VECTORS], PetscInt i, PetscReal damper,
                          const PetscReal *along, const PetscReal ground[2], PetscReal works[COUPLED_WORKS])
{
  const PetscReal before = x[MOMENTUM][i], behind = x[MOMENTUM_BEHIND][i], v_0 = x[V_BEFORE][i],
                  v_1 = x[V_BEHIND][i], drag = drag_of(s, 0.5 * (before + behind), along, ground) + damper;
  works[COUPLED_INSIDE] += 0.5 * v_0 * behind;
  works[COUPLED_DRAG] += 0.5 * s->dt * (v_0 + v_1) * drag;
  works[COUPLED_DRAG_AHEAD] += 0.5 * s->dt * v_1 * drag;
  return (behind - before) / s->dt + drag;
}

/* Returns the damping force [N] of mode k over the step. */
static PetscReal damper_of(const CoupledBody *b, PetscInt k)
{
  const PetscReal v_0 = b->modes[V_BEFORE][k], v_1 = b->modes[V_BEHIND][k];
  return CondensedDamper(b->of, k) * v_0 + 0.5 * centred_damper(b, k) * (v_1 - v_0);
}

/* Returns the force [N] of centred damping on row i beside the force of the velocity before. */
static PetscReal centred_force(const CoupledBody *b, PetscInt i)
{
  PetscReal sum = 0.;
  for (PetscInt j = 0; j < b->n; j++)
    sum += b->rows->S[i * b->stride + j] * (b->kept[V_BEHIND][j] - b->kept[V_BEFORE][j]);
  return 0.5 * CondensedCentred(b->of) * sum;
}

static void book_body(const CoupledInertia *l, const CoupledBody *b, const State *s,
                      const PetscReal ground[2], PetscReal works[COUPLED_WORKS])
{
  const PetscReal *v_0 = b->kept[V_BEFORE], *v_1 = b->kept[V_BEHIND];
  for (PetscInt i = 0; i < b->n; i++) {
    PetscReal force = book_one(s, b->kept, i, 0., b->along + 2 * i, ground, works);
    if (i < b->n_free || (v_0[i] == 0. && v_1[i] == 0.)) continue;
    force += centred_force(b, i);
    works[COUPLED_SUPPORTS] += 0.5 * s->dt * (v_0[i] + v_1[i]) *
                               force; // its support carries the damping force
    works[COUPLED_SUPPORTS_AHEAD] += 0.5 * s->dt * v_1[i] * force;
  }
  for (PetscInt k = 0; k < b->of->n_modes; k++)
    (void)book_one(s, b->modes, k, damper_of(b, k), along_mode(b, k), ground, works);
  for (PetscInt k = 0; k < b->n_points; k++) {
    const PetscInt *slot = b->slot + 2 * k;
    const PetscReal *w_0 = b->slots[SLOT_BEFORE], *w_1 = b->slots[SLOT_BEHIND];
    const PetscReal v[2][2] = {{w_0[slot[0]], w_0[slot[1]]}, {w_1[slot[0]], w_1[slot[1]]}};
    CoupledBookWork(l, l->point + b->point[k], 2, s->dt, v[0], v[1], works);
  }
}

/* Moves the modes, and books the work of loads inside since the step before, and the strain energy of
   modes. */
static void move_modes(const CoupledBody *b, const State *s, PetscReal works[COUPLED_WORKS])
{
  const PetscInt first = b->of->first_mode;
  for (PetscInt k = 0; k < b->of->n_modes; k++) {
    PetscReal *q = s->modes[MODE_PLACE] + first + k, *speed = s->modes[MODE_SPEED] + first + k;
    const PetscReal load = s->modes[MODE_LOAD][first + k];
    works[COUPLED_STRAIN] += *q * (0.5 * b->of->omega2[k] * *q + load);
    works[COUPLED_LOADS] += load * *speed * s->dt;
    *speed = b->modes[V_BEHIND][k];
    *q += *speed * s->dt;
  }
}

void CoupledBodiesStep(CoupledInertia *l, State *s, const PetscReal *v_before, const PetscReal ground[2],
                       PetscReal works[COUPLED_WORKS])
{
  const PetscInt at = 3 * l->m->rigid.n;
  for (CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) {
    PetscReal *behind = b->slots[SLOT_BEHIND];
    gather(l, b, s, v_before);
    for (PetscInt i = b->free_slots; i < b->n_slots; i++)
      behind[i] = b->kept[V_BEHIND][i - b->free_slots + b->n_free] = s->v[at + b->rows->dof[i]];
    accelerate(l, b, s, ground, s->dt);
    for (PetscInt i = 0; i < b->n_free; i++)
      b->kept[V_BEHIND][i] = b->kept[V_BEFORE][i] + s->dt * b->kept[ACCELERATION][i];
    CondensedSpread(b->rows, b->kept[V_BEHIND], behind);
    memcpy(b->slots[SLOT_FORCE], behind, b->n_slots * sizeof *behind);
    CondensedFind(b->rows, b->slots[SLOT_FORCE], b->kept[V_BEHIND]); // to the bits that a restart finds
    for (PetscInt i = 0; i < b->free_slots; i++) {
      const PetscInt d = at + b->rows->dof[i];
      s->u[d] += (behind[i] - s->v[d]) * s->dt; // the step has moved it as if it had its own mass only
      s->v[d] = behind[i];
    }
    find_carried(b, V_BEHIND, CARRIED_BEHIND);
    accelerate_modes(b, s);
    find_momentum(b, V_BEHIND, CARRIED_BEHIND, MOMENTUM_BEHIND);
    book_body(l, b, s, ground, works);
    move_modes(b, s, works);
    b->known = PETSC_TRUE;
  }
}

PetscErrorCode CoupledBodiesHalfStep(CoupledInertia *l, State *s, const PetscReal *v_before,
                                     const PetscReal ground[2], PetscReal sign)
{
  const PetscReal half = sign * 0.5 * s->dt;
  const PetscInt at = 3 * l->m->rigid.n;
  PetscFunctionBeginUser;
  for (CoupledBody *b = l->body; b < l->body + l->n_bodies; b++) {
    PetscCall(invert(l, b, s, 0.));
    b->known = PETSC_FALSE;
    gather(l, b, s, v_before);
    accelerate(l, b, s, ground, 0.);
    find_carried(b, ACCELERATION, CARRIED);
    for (PetscInt i = 0; i < b->n_free; i++)
      b->kept[V_BEHIND][i] = b->kept[V_BEFORE][i] + half * b->kept[ACCELERATION][i];
    CondensedSpread(b->rows, b->kept[V_BEHIND], b->slots[SLOT_BEHIND]);
    for (PetscInt i = 0; i < b->free_slots; i++) s->v[at + b->rows->dof[i]] = b->slots[SLOT_BEHIND][i];
    for (PetscInt k = 0; k < b->of->n_modes; k++)
      s->modes[MODE_SPEED][b->of->first_mode + k] += half * (b->modes[FORCE][k] -
                                                             b->yields[k] * b->modes[CARRIED][k]);
  }
  l->dt = 0.; // the inverses are not those of a step
  PetscFunctionReturn(PETSC_SUCCESS);
}

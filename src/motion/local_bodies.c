/* local_bodies.c: condensed bodies in time (condense_in_time.c). With x = (u_B, q), the inertia M of (d)
   beside the lumped masses and added masses of kept vertices, and D = alpha M + C, a step is that of
   local.c,

   (M + dt/2 D) (v+ - v-) = dt (f_ext - f - Omega^2 q + C (w - v-) + p - alpha M (v- - ground)),

   solved with the inverse, which is as constant as the step. f has S u_B (condense.c). Modes have no
   inertia in common, so they are eliminated, and the inverse is that of the kept degrees of freedom: with
   H = Psi' M Phi and w = 1 + alpha dt/2

   a_q = y (f_q / w - H' a_B),   (M_BB + dt/2 D_BB - w H y H') a_B = f_B - H y f_q,   y = w / (w + dt/2 c),

   where c are the dashpots of gathered modes (condense_left_out.c), centred as those of points.

   Damping by stiffness is a force, of the velocity before: among f, and -beta Omega^2 q'- beside -Omega^2 q.

   The body belongs to one rank, and its sums run in one order, so bits do not depend on the ranks.

   Vertices that one support holds move alike: along each direction they are one degree of freedom, of
   known motion. The force that this takes is the support's work. */
#include "motion/local.h"
#include <petscblaslapack.h>

/* ---- set-up */

static PetscInt padded(PetscInt n)
{
  return (n + BATCH - 1) / BATCH * BATCH;
}

/* The kept degree of freedom of component x of a point at a vertex of the body. */
static PetscInt kept_of(const Local *l, const LocalBody *b, const LocalPoint *p, int x)
{
  const PetscInt entry = p->dof - 3 * l->m->n_bodies + x;
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

/* Whether calm vertices may move by shapes: not where contacts may come anywhere, nor beside free ground,
   which pushes at its sides with faster waves than shapes know. */
static PetscBool may_be_calm(const TermView *view)
{
  PetscBool calm = (PetscBool)!view->stage->variable;
  for (PetscInt i = 0; i < view->scene->n_supports; i++)
    if (view->scene->supports[i].boundary == BOUNDARY_FREE_FIELD) calm = PETSC_FALSE;
  return calm;
}

/* Numbers the rows. */
static PetscErrorCode find_rows(const Local *l, const TermView *view, const PetscReal *u_start, LocalBody *b)
{
  const Model *m = l->m;
  Condensed *c = m->condensed + (b - l->body);
  PetscReal *mass;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n_kept * c->n_kept, &mass));
  for (PetscInt i = 0; i < c->n_kept; i++) mass[i * c->n_kept + i] = m->vertex_mass[c->kept[i] / 2];
  for (PetscInt k = 0; k < b->n_points; k++) {
    const LocalPoint *p = l->point + b->point[k];
    for (int x = 0; x < 2; x++)
      for (int y = 0; y < 2; y++)
        mass[kept_of(l, b, p, x) * c->n_kept + kept_of(l, b, p, y)] += p->mass[x][y];
  }
  PetscCall(CondensedRowsCreate(m, may_be_calm(view), mass, u_start + 3 * m->n_bodies, c));
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
static PetscErrorCode gather_inertia(LocalBody *b)
{
  const Condensed *c = b->of;
  PetscReal *inertia, *couples;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc6(b->stride * b->stride, &b->inertia, b->stride * b->width, &b->couples,
                         b->stride * b->width, &b->coupled, 2 * b->n, &b->along, b->width, &b->yields,
                         b->stride * b->stride, &b->inverse));
  PetscCall(PetscMalloc2(b->n * b->n, &inertia, b->n * c->n_modes, &couples));
  PetscCall(CondensedFoldBoth(b->rows, c->n_kept, c->size, c->inertia, inertia));
  PetscCall(CondensedFold(b->rows, c->n_kept, c->n_modes, c->size, c->inertia + c->n_kept, couples));
  PetscCall(CondensedFold(b->rows, c->n_kept, 2, 2, c->along, b->along));
  for (PetscInt i = 0; i < b->n; i++) {
    PetscCall(PetscArraycpy(b->inertia + i * b->stride, inertia + i * b->n, b->n));
    for (PetscInt k = 0; k < c->n_modes; k++)
      b->couples[k * b->stride + i] = b->coupled[i * b->width + k] = couples[i * c->n_modes + k];
  }
  PetscCall(PetscFree2(inertia, couples));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LocalBodiesCreate(const TermView *view, const PetscReal *u_start, Local *l)
{
  const Model *m = l->m;
  PetscFunctionBeginUser;
  l->n_bodies = m->n_condensed;
  PetscCall(PetscCalloc1(l->n_bodies, &l->body));
  for (PetscInt i = 0; i < l->n_bodies; i++) {
    LocalBody *b = l->body + i;
    b->of = m->condensed + i;
    PetscCall(PetscMalloc2(l->n, &b->point, 2 * l->n, &b->slot));
    for (PetscInt p = 0; p < l->n; p++)
      if (IsCondensed(m, l->point[p].dof) && !l->point[p].rigid &&
          m->vertex_condensed[(l->point[p].dof - 3 * m->n_bodies) / 2] == b->of->number)
        l->point[p].condensed = PETSC_TRUE, b->point[b->n_points++] = p;
    PetscCall(find_rows(l, view, u_start, b));
    PetscCall(gather_inertia(b));
    for (int k = 0; k < BODY_VECTORS; k++)
      PetscCall(PetscCalloc2(b->stride, &b->kept[k], b->width, &b->modes[k]));
    for (int k = 0; k < SLOT_VECTORS; k++) PetscCall(PetscCalloc1(b->n_slots, &b->slots[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LocalBodiesDestroy(Local *l)
{
  PetscFunctionBeginUser;
  for (LocalBody *b = l->body; b < l->body + l->n_bodies; b++) {
    PetscCall(CondensedRowsDestroy(l->m->condensed + (b - l->body)));
    PetscCall(PetscFree6(b->inertia, b->couples, b->coupled, b->along, b->yields, b->inverse));
    for (int k = 0; k < BODY_VECTORS; k++) PetscCall(PetscFree2(b->kept[k], b->modes[k]));
    for (int k = 0; k < SLOT_VECTORS; k++) PetscCall(PetscFree(b->slots[k]));
    PetscCall(PetscFree2(b->point, b->slot));
  }
  PetscCall(PetscFree(l->body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What damping by mass over a step adds to 1. */
static PetscReal damped_mass(const State *s, PetscReal step)
{
  return 1. + 0.5 * step * s->alpha;
}

/* Adds the added masses and dashpots of the points. */
static PetscErrorCode add_points_to(const Local *l, const LocalBody *b, PetscReal step, PetscReal *A)
{
  PetscReal *row[2];
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(b->n, &row[0], b->n, &row[1]));
  for (PetscInt k = 0; k < b->n_points; k++) {
    const LocalPoint *p = l->point + b->point[k];
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

/* Finds the inverse of the kept degrees of freedom that nothing holds; step 0: of their inertia alone. */
static PetscErrorCode invert(const Local *l, const LocalBody *b, const State *s, PetscReal step)
{
  const PetscReal whole = damped_mass(s, step), minus = -whole, one = 1.;
  const PetscBLASInt n = (PetscBLASInt)b->n_free, stride = (PetscBLASInt)b->stride,
                     k = (PetscBLASInt)b->of->n_modes;
  PetscReal *A = b->inverse, *left;
  PetscBLASInt info = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < b->of->n_modes; i++)
    b->yields[i] = whole / (whole + 0.5 * step * b->of->damper[i]);
  PetscCall(PetscArrayzero(A, b->stride * b->stride));
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < b->n_free; i++) {
    for (PetscInt j = 0; j < b->n_free; j++) A[i * b->stride + j] = whole * b->inertia[i * b->stride + j];
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

PetscErrorCode LocalBodiesInvert(Local *l, const State *s)
{
  PetscFunctionBeginUser;
  for (const LocalBody *b = l->body; b < l->body + l->n_bodies; b++) PetscCall(invert(l, b, s, s->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step */

/* The velocities before the step, from those of the degrees of freedom, v, and of the modes. */
static void gather(const Local *l, const LocalBody *b, const State *s, const PetscReal *v)
{
  const PetscInt at = 3 * l->m->n_bodies;
  for (PetscInt i = 0; i < b->n_slots; i++)
    b->slots[SLOT_BEFORE][i] = b->slots[SLOT_FORCE][i] = v[at + b->rows->dof[i]];
  CondensedFind(b->rows, b->slots[SLOT_FORCE], b->kept[V_BEFORE]);
  memcpy(b->modes[V_BEFORE], s->modes[MODE_SPEED] + b->of->first_mode, b->of->n_modes * sizeof(PetscReal));
}

/* What inertia makes of velocities: both by number. */
static void find_momentum(const LocalBody *b, int v, int momentum)
{
  PetscReal *kept = b->kept[momentum], *modes = b->modes[momentum];
  DenseTimes(b->stride, b->stride, b->inertia, b->kept[v], kept);
  DenseTimes(b->stride, b->width, b->couples, b->modes[v], b->kept[ROOM]);
  DenseTimes(b->width, b->stride, b->coupled, b->kept[v], modes);
  for (PetscInt i = 0; i < b->n; i++) kept[i] += b->kept[ROOM][i];
  for (PetscInt k = 0; k < b->of->n_modes; k++) modes[k] += b->modes[v][k];
}

/* What damping by mass takes beside that of lumped masses. along: [kg] (2,) what the ground moves. */
static PetscReal drag_of(const State *s, PetscReal momentum, const PetscReal *along,
                         const PetscReal ground[2])
{
  return s->alpha * (momentum - along[0] * ground[0] - along[1] * ground[1]);
}

/* What moves along with the ground of mode k. */
static const PetscReal *along_mode(const LocalBody *b, PetscInt k)
{
  return b->of->along + 2 * (b->of->n_kept + k);
}

/* What added mass and dashpots of the points add to the force. */
static void add_points(const Local *l, const LocalBody *b, PetscReal step)
{
  const PetscReal *v_0 = b->slots[SLOT_BEFORE], *v_1 = b->slots[SLOT_BEHIND];
  for (PetscInt k = 0; k < b->n_points; k++) {
    const LocalPoint *p = l->point + b->point[k];
    const PetscReal *w = LocalEntries(l, p, l->in.w), *push = LocalEntries(l, p, l->in.push);
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

/* What the acceleration of the supports takes from the forces. */
static void add_supports(const LocalBody *b, const State *s, PetscReal step)
{
  for (PetscInt j = b->n_free; j < b->n && step > 0.; j++) {
    const PetscReal a = damped_mass(s, step) * (b->kept[V_BEHIND][j] - b->kept[V_BEFORE][j]) / step;
    if (a == 0.) continue;
    for (PetscInt i = 0; i < b->n_free; i++) b->kept[FORCE][i] -= b->inertia[j * b->stride + i] * a;
    for (PetscInt k = 0; k < b->of->n_modes; k++) b->modes[FORCE][k] -= b->coupled[j * b->width + k] * a;
  }
}

static void find_forces(const Local *l, const LocalBody *b, const State *s, const PetscReal ground[2],
                        PetscReal step)
{
  const PetscReal *q = s->modes[MODE_PLACE] + b->of->first_mode, *v = b->slots[SLOT_BEFORE];
  const PetscInt at = 3 * l->m->n_bodies;
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

/* Finds the acceleration over the step; 0: at once, with what supports hold at constant velocity.
   V_BEFORE, and of what is held V_BEHIND, are known. */
static void accelerate(const Local *l, LocalBody *b, const State *s, const PetscReal ground[2],
                       PetscReal step)
{
  const PetscReal whole = damped_mass(s, step);
  if (!b->known) find_momentum(b, V_BEFORE, MOMENTUM);
  find_forces(l, b, s, ground, step);
  for (PetscInt k = 0; k < b->of->n_modes; k++) b->modes[FORCE][k] *= b->yields[k];
  DenseTimes(b->stride, b->width, b->couples, b->modes[FORCE], b->kept[ROOM]);
  for (PetscInt i = 0; i < b->n_free; i++) b->kept[FORCE][i] -= b->kept[ROOM][i];
  DenseTimes(b->stride, b->stride, b->inverse, b->kept[FORCE], b->kept[ACCELERATION]);
  DenseTimes(b->width, b->stride, b->coupled, b->kept[ACCELERATION], b->modes[ROOM]);
  for (PetscInt k = 0; k < b->of->n_modes; k++)
    b->modes[ACCELERATION][k] = b->modes[FORCE][k] / whole - b->yields[k] * b->modes[ROOM][k];
}

/* Books the works of the step at one degree of freedom: velocities and momenta before and behind it. damper:
   [N] of its own. The force that takes it along. */
static PetscReal book_one(const State *s, PetscReal *const x[BODY_VECTORS], PetscInt i, PetscReal damper,
                          const PetscReal *along, const PetscReal ground[2], PetscReal works[LOCAL_WORKS])
{
  const PetscReal before = x[MOMENTUM][i], behind = x[MOMENTUM_BEHIND][i], v_0 = x[V_BEFORE][i],
                  v_1 = x[V_BEHIND][i], drag = drag_of(s, 0.5 * (before + behind), along, ground) + damper;
  works[LOCAL_INSIDE] += 0.5 * v_0 * behind;
  works[LOCAL_DRAG] += 0.5 * s->dt * (v_0 + v_1) * drag;
  works[LOCAL_DRAG_AHEAD] += 0.5 * s->dt * v_1 * drag;
  return (behind - before) / s->dt + drag;
}

/* [N] What damps mode k over the step: its dashpot in the middle, beta by the velocity before. */
static PetscReal damper_of(const LocalBody *b, PetscInt k)
{
  const PetscReal v_0 = b->modes[V_BEFORE][k], v_1 = b->modes[V_BEHIND][k];
  return CondensedDamper(b->of, k) * v_0 + 0.5 * b->of->damper[k] * (v_1 - v_0);
}

static void book_body(const Local *l, const LocalBody *b, const State *s, const PetscReal ground[2],
                      PetscReal works[LOCAL_WORKS])
{
  const PetscReal *v_0 = b->kept[V_BEFORE], *v_1 = b->kept[V_BEHIND];
  for (PetscInt i = 0; i < b->n; i++) {
    const PetscReal force = book_one(s, b->kept, i, 0., b->along + 2 * i, ground, works);
    if (i < b->n_free) continue;
    works[LOCAL_SUPPORTS] += 0.5 * s->dt * (v_0[i] + v_1[i]) * force; // its support bears that
    works[LOCAL_SUPPORTS_AHEAD] += 0.5 * s->dt * v_1[i] * force;
  }
  for (PetscInt k = 0; k < b->of->n_modes; k++)
    (void)book_one(s, b->modes, k, damper_of(b, k), along_mode(b, k), ground, works);
  for (PetscInt k = 0; k < b->n_points; k++) {
    const PetscInt *slot = b->slot + 2 * k;
    const PetscReal *w_0 = b->slots[SLOT_BEFORE], *w_1 = b->slots[SLOT_BEHIND];
    const PetscReal v[2][2] = {{w_0[slot[0]], w_0[slot[1]]}, {w_1[slot[0]], w_1[slot[1]]}};
    LocalBook(l, l->point + b->point[k], 2, s->dt, v[0], v[1], works);
  }
}

/* Moves the modes on, and books what loads inside have done since the step before, and what modes store. */
static void move_modes(const LocalBody *b, const State *s, PetscReal works[LOCAL_WORKS])
{
  const PetscInt first = b->of->first_mode;
  for (PetscInt k = 0; k < b->of->n_modes; k++) {
    PetscReal *q = s->modes[MODE_PLACE] + first + k, *speed = s->modes[MODE_SPEED] + first + k;
    const PetscReal load = s->modes[MODE_LOAD][first + k];
    works[LOCAL_STRAIN] += *q * (0.5 * b->of->omega2[k] * *q + load);
    works[LOCAL_LOADS] += load * *speed * s->dt;
    *speed = b->modes[V_BEHIND][k];
    *q += *speed * s->dt;
  }
}

/* What is behind the step is before the next one. */
static void hand_on(LocalBody *b)
{
  PetscReal *const spare[2] = {b->kept[MOMENTUM], b->modes[MOMENTUM]};
  b->kept[MOMENTUM] = b->kept[MOMENTUM_BEHIND], b->kept[MOMENTUM_BEHIND] = spare[0];
  b->modes[MOMENTUM] = b->modes[MOMENTUM_BEHIND], b->modes[MOMENTUM_BEHIND] = spare[1];
  b->known = PETSC_TRUE;
}

void LocalBodiesStep(Local *l, State *s, const PetscReal *v_before, const PetscReal ground[2],
                     PetscReal works[LOCAL_WORKS])
{
  const PetscInt at = 3 * l->m->n_bodies;
  for (LocalBody *b = l->body; b < l->body + l->n_bodies; b++) {
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
    for (PetscInt k = 0; k < b->of->n_modes; k++)
      b->modes[V_BEHIND][k] = b->modes[V_BEFORE][k] + s->dt * b->modes[ACCELERATION][k];
    find_momentum(b, V_BEHIND, MOMENTUM_BEHIND);
    book_body(l, b, s, ground, works);
    move_modes(b, s, works);
    hand_on(b);
  }
}

PetscErrorCode LocalBodiesHalfStep(Local *l, State *s, const PetscReal *v_before, const PetscReal ground[2],
                                   PetscReal sign)
{
  const PetscReal half = sign * 0.5 * s->dt;
  const PetscInt at = 3 * l->m->n_bodies;
  PetscFunctionBeginUser;
  for (LocalBody *b = l->body; b < l->body + l->n_bodies; b++) {
    PetscCall(invert(l, b, s, 0.));
    gather(l, b, s, v_before);
    b->known = PETSC_FALSE;
    accelerate(l, b, s, ground, 0.);
    for (PetscInt i = 0; i < b->n_free; i++)
      b->kept[V_BEHIND][i] = b->kept[V_BEFORE][i] + half * b->kept[ACCELERATION][i];
    CondensedSpread(b->rows, b->kept[V_BEHIND], b->slots[SLOT_BEHIND]);
    for (PetscInt i = 0; i < b->free_slots; i++) s->v[at + b->rows->dof[i]] = b->slots[SLOT_BEHIND][i];
    for (PetscInt k = 0; k < b->of->n_modes; k++)
      s->modes[MODE_SPEED][b->of->first_mode + k] += half * b->modes[ACCELERATION][k];
  }
  l->dt = 0.; // the inverses are not those of a step
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is lacking */

/* 1/2 u.A u, with u in the room of the body. */
static PetscReal half_product(const Condensed *c, const PetscReal *A)
{
  PetscReal sum = 0.;
  DenseTimes(c->stride, c->stride, A, c->u, c->f);
  for (PetscInt i = 0; i < c->n_kept; i++) sum += 0.5 * c->u[i] * c->f[i];
  return sum;
}

static void find_acceleration(const LocalBody *b, PetscReal dt)
{
  for (PetscInt i = 0; i < b->of->n_kept; i++) {
    const PetscInt slot = b->rows->slot[i];
    b->of->u[i] = (b->slots[SLOT_BEHIND][slot] - b->slots[SLOT_BEFORE][slot]) / dt;
  }
}

/* Adds those of one body. */
static void add_lacking(const Model *m, const LocalBody *b, const State *s, const PetscReal *start,
                        PetscReal works[LOCAL_WORKS])
{
  const Condensed *c = b->of;
  const PetscInt at = 3 * m->n_bodies;
  const PetscReal *q = s->modes[MODE_PLACE] + c->first_mode, next = 2. * PETSC_PI * c->next;
  for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = s->u[at + c->kept[i]] - start[at + c->kept[i]];
  works[LOCAL_SHAKEN] += half_product(c, c->S);
  for (PetscInt k = 0; k < c->n_modes; k++) works[LOCAL_SHAKEN] += 0.5 * c->omega2[k] * q[k] * q[k];
  if (!c->lacking) return;
  find_acceleration(b, s->dt);
  works[LOCAL_LACKING] += half_product(c, c->lacking);
  works[LOCAL_HASTE] += half_product(c, c->S) / (next * next);
  for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = b->slots[SLOT_BEHIND][b->rows->slot[i]];
  works[LOCAL_SPEED] += half_product(c, c->S);
}

void LocalLacking(const Local *l, const State *s, const PetscReal *start, PetscReal works[LOCAL_WORKS])
{
  for (const LocalBody *b = l->body; b < l->body + l->n_bodies; b++) add_lacking(l->m, b, s, start, works);
}

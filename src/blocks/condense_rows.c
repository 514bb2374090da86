/* condense_rows.c: chooses the coordinates by which a condensed body moves in dynamic stages
   (condense_in_time.c).

   Its kept degrees of freedom are of three kinds. Firm ones, at joints, anchors and other blocks, move one
   by one. Held ones move with their support, all of one support and direction together. Calm vertices are
   kept because water, a support or a probe acts there. They have no impacts, so they move by a few shapes,

   du = Q e,   Q' m Q = 1   (m: lumped masses),

   counted from the displacements at the start of the stage. Q spans the rigid motions of the calm vertices
   and their motion in the vibrations of the body up to SPAN times the first frequency that its modes leave
   out, with firm vertices free, and held. A row is a firm degree of freedom, a shape or a support; a slot
   is a degree of freedom, or a support. With T from rows to kept degrees of freedom the body has T'S T and
   T'M T, which are far smaller. The force S u at calm vertices is m Q (T'S T x) beside the force of the
   start: of all forces with the same work on the shapes, this one moves them by shapes. */
#include "blocks/blocks.h"
#include <petscblaslapack.h>

static const PetscReal SPAN = 1.5; /* [-] */
static const PetscReal NEW = 0.1;  /* [-] least new part of a shape, over its size, beside those before it */
static const PetscReal FEW = 0.75; /* [-] of the calm degrees of freedom: more shapes are not worth it */

static PetscInt padded(PetscInt n)
{
  return (n + BATCH - 1) / BATCH * BATCH;
}

/* ---- slots */

static PetscBool is_held(const Model *m, const Condensed *c, PetscInt i)
{
  return Held(m, 3 * m->rigid.n + c->kept[i]);
}

/* Returns the slot of a held degree of freedom: the slot of its support along x or y, made at first use. */
static PetscInt support_slot(const Model *m, const Condensed *c, CondensedRows *r, PetscInt i)
{
  const PetscInt at = 3 * m->rigid.n, d = c->kept[i];
  PetscInt s = r->n_firm + r->n_calm;
  for (; s < r->n_slots; s++)
    if (m->support[at + r->dof[s]] == m->support[at + d] && (r->dof[s] - d) % 2 == 0) break;
  if (s == r->n_slots) r->dof[r->n_slots++] = d;
  return s;
}

/* Numbers the slots. calms: calm vertices move by shapes. */
static void number(const Model *m, const Condensed *c, PetscBool calms, CondensedRows *r)
{
  r->n_slots = 0;
  for (int calm = 0; calm < 2; calm++) {
    for (PetscInt i = 0; i < c->n_kept; i++) {
      if (is_held(m, c, i) || (calms && m->mesh.vertex_calm[c->kept[i] / 2]) != calm) continue;
      r->slot[i] = r->n_slots;
      r->dof[r->n_slots++] = c->kept[i];
    }
    if (!calm) r->n_firm = r->n_slots;
  }
  r->n_calm = r->n_slots - r->n_firm;
  for (PetscInt i = 0; i < c->n_kept; i++)
    if (is_held(m, c, i)) r->slot[i] = support_slot(m, c, r, i);
  for (PetscInt s = 0; s < r->n_slots; s++) r->mass[s] = m->vertex_mass[r->dof[s] / 2];
}

/* ---- shapes */

/* Candidates for shapes, by rows. */
typedef struct {
  PetscInt n, capacity;
  PetscReal *row; /* (capacity, n_calm) */
} Candidates;

static PetscErrorCode room_for(PetscInt more, PetscInt width, Candidates *x)
{
  PetscFunctionBeginUser;
  x->capacity = x->n + more;
  PetscCall(PetscRealloc(x->capacity * width * sizeof(PetscReal), &x->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the translations, and the rotation about the first calm vertex. */
static PetscErrorCode add_rigid(const Model *m, const CondensedRows *r, Candidates *x)
{
  const PetscInt *dof = r->dof + r->n_firm;
  const PetscReal *centre = m->mesh.X + dof[0] / 2 * 2;
  PetscFunctionBeginUser;
  PetscCall(room_for(3, r->n_calm, x));
  PetscReal *row = x->row + x->n * r->n_calm;
  for (PetscInt i = 0; i < r->n_calm; i++) {
    const PetscInt along = dof[i] % 2, across = dof[i] + 1 - 2 * along;
    row[i] = !along, row[r->n_calm + i] = along;
    row[2 * r->n_calm + i] = (along ? 1. : -1.) * (m->mesh.X[across] - centre[!along]);
  }
  x->n += 3;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the motion of calm vertices in the modes of the body below omega2. mass: (n_kept, n_kept) of kept
   vertices without the inner mass; free: firm vertices move. */
static PetscErrorCode add_vibrations(const Model *m, const Condensed *c, const CondensedRows *r,
                                     const PetscReal *mass, PetscBool free, PetscReal omega2, Candidates *x)
{
  const PetscBLASInt type = 1, room = 35 * (PetscBLASInt)c->size, none = 0;
  const PetscReal low = -omega2, tolerance = 0.;
  PetscBLASInt n = 0, found, info, *integers, *failed;
  PetscInt *at;
  PetscReal *K, *M, *values, *vectors, *work;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(c->size, &at));
  for (PetscInt i = 0; i < c->size; i++)
    if (i >= c->n_kept || (!is_held(m, c, i) && (free || r->slot[i] >= r->n_firm))) at[n++] = i;
  PetscCall(PetscCalloc7(n * n, &K, n * n, &M, n, &values, n * n, &vectors, room, &work, 5 * n, &integers, n,
                         &failed));
  for (PetscInt a = 0; a < n; a++)
    for (PetscInt b = 0; b < n; b++) {
      const PetscInt i = at[a], j = at[b];
      M[a * n + b] = c->inertia[i * c->size + j];
      if (i < c->n_kept && j < c->n_kept)
        K[a * n + b] = c->S[i * c->stride + j], M[a * n + b] += mass[i * c->n_kept + j];
      else if (i == j)
        K[a * n + b] = c->omega2[i - c->n_kept];
    }
  PetscCallBLAS("LAPACKsygvx",
                LAPACKsygvx_(&type, "V", "V", "U", &n, K, &n, M, &n, &low, &omega2, &none, &none, &tolerance,
                             &found, values, vectors, &n, work, &room, integers, failed, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "the vibrations of a condensed body were not found: %d", (int)info);
  PetscCall(room_for(found, r->n_calm, x));
  for (PetscInt k = 0; k < found; k++, x->n++)
    for (PetscInt a = 0; a < n && at[a] < c->n_kept; a++)
      if (r->slot[at[a]] >= r->n_firm)
        x->row[x->n * r->n_calm + r->slot[at[a]] - r->n_firm] = vectors[k * n + a];
  PetscCall(PetscFree7(K, M, values, vectors, work, integers, failed));
  PetscCall(PetscFree(at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal product(PetscInt n, const PetscReal *m, const PetscReal *x, const PetscReal *y)
{
  PetscReal sum = 0.;
  for (PetscInt i = 0; i < n; i++) sum += m[i] * x[i] * y[i];
  return sum;
}

/* Makes the candidates orthonormal one after the other, and drops those that add nothing new. */
static void make_orthonormal(const CondensedRows *r, Candidates *x)
{
  const PetscInt n = r->n_calm, all = x->n;
  const PetscReal *m = r->mass + r->n_firm;
  x->n = 0;
  for (PetscInt k = 0; k < all; k++) {
    PetscReal *y = x->row + k * n, *to = x->row + x->n * n;
    const PetscReal before = product(n, m, y, y);
    for (int again = 0; again < 2; again++)
      for (PetscInt i = 0; i < x->n; i++) {
        const PetscReal *q = x->row + i * n, by = product(n, m, q, y);
        for (PetscInt d = 0; d < n; d++) y[d] -= by * q[d];
      }
    const PetscReal left = product(n, m, y, y);
    if (!(left > NEW * NEW * before)) continue;
    for (PetscInt d = 0; d < n; d++) to[d] = y[d] / PetscSqrtReal(left);
    x->n++;
  }
}

static PetscErrorCode find_shapes(const Model *m, const Condensed *c, const PetscReal *mass, CondensedRows *r)
{
  const PetscReal omega = 2. * PETSC_PI * SPAN * c->next;
  Candidates x = {0};
  PetscFunctionBeginUser;
  PetscCall(add_rigid(m, r, &x));
  PetscCall(add_vibrations(m, c, r, mass, PETSC_FALSE, omega * omega, &x));
  PetscCall(add_vibrations(m, c, r, mass, PETSC_TRUE, omega * omega, &x));
  make_orthonormal(r, &x);
  if ((PetscReal)x.n > FEW * (PetscReal)r->n_calm) {
    number(m, c, PETSC_FALSE, r);
    x.n = 0;
  }
  r->n_shapes = x.n, r->calm_width = padded(r->n_calm), r->shape_width = padded(x.n);
  PetscCall(
      PetscCalloc2(r->calm_width * r->shape_width, &r->shapes, r->calm_width * r->shape_width, &r->across));
  for (PetscInt k = 0; k < x.n; k++)
    for (PetscInt i = 0; i < r->n_calm; i++)
      r->shapes[k * r->calm_width + i] = r->across[i * r->shape_width + k] = x.row[k * r->n_calm + i];
  PetscCall(PetscFree(x.row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- from slots to rows and back */

void CondensedSum(const CondensedRows *r, const PetscReal *slots, PetscReal *rows)
{
  memcpy(rows, slots, r->n_firm * sizeof *rows);
  if (r->n_calm) {
    memcpy(r->calm, slots + r->n_firm, r->n_calm * sizeof *r->calm);
    DenseTimes(r->shape_width, r->calm_width, r->across, r->calm, r->by_shape);
    memcpy(rows + r->n_firm, r->by_shape, r->n_shapes * sizeof *rows);
  }
  memcpy(rows + r->n_firm + r->n_shapes, slots + r->n_firm + r->n_calm,
         (r->n_slots - r->n_firm - r->n_calm) * sizeof *rows);
}

void CondensedFind(const CondensedRows *r, PetscReal *slots, PetscReal *rows)
{
  for (PetscInt i = r->n_firm; i < r->n_firm + r->n_calm; i++) slots[i] *= r->mass[i];
  CondensedSum(r, slots, rows);
}

void CondensedSpread(const CondensedRows *r, const PetscReal *rows, PetscReal *slots)
{
  memcpy(slots, rows, r->n_firm * sizeof *rows);
  if (r->n_calm) {
    memcpy(r->by_shape, rows + r->n_firm, r->n_shapes * sizeof *rows);
    DenseTimes(r->calm_width, r->shape_width, r->shapes, r->by_shape, r->calm);
    memcpy(slots + r->n_firm, r->calm, r->n_calm * sizeof *r->calm);
  }
  memcpy(slots + r->n_firm + r->n_calm, rows + r->n_firm + r->n_shapes,
         (r->n_slots - r->n_firm - r->n_calm) * sizeof *rows);
}

void CondensedRowOf(const CondensedRows *r, PetscInt slot, PetscReal scale, PetscReal *row)
{
  memset(row, 0, r->n_rows * sizeof *row);
  if (slot < r->n_firm)
    row[slot] = scale;
  else if (slot >= r->n_firm + r->n_calm)
    row[slot - r->n_calm + r->n_shapes] = scale;
  else
    for (PetscInt k = 0; k < r->n_shapes; k++)
      row[r->n_firm + k] = scale * r->shapes[k * r->calm_width + slot - r->n_firm];
}

/* Adds T' A to rows, (n_rows, width). A: (n_kept, width) in rows of length `apart`. */
static void fold(const CondensedRows *r, PetscInt n_kept, PetscInt width, PetscInt apart, const PetscReal *A,
                 PetscReal *rows)
{
  for (PetscInt i = 0; i < n_kept; i++) {
    const PetscReal *from = A + i * apart;
    const PetscInt s = r->slot[i], calm = s - r->n_firm;
    const PetscBool shaped = (PetscBool)(calm >= 0 && calm < r->n_calm);
    const PetscInt first = shaped ? r->n_firm : s < r->n_firm ? s : s - r->n_calm + r->n_shapes;
    for (PetscInt k = 0; k < (shaped ? r->n_shapes : 1); k++) {
      const PetscReal by = shaped ? r->shapes[k * r->calm_width + calm] : 1.;
      for (PetscInt j = 0; j < width; j++) rows[(first + k) * width + j] += by * from[j];
    }
  }
}

PetscErrorCode CondensedFold(const CondensedRows *r, PetscInt n_kept, PetscInt width, PetscInt apart,
                             const PetscReal *A, PetscReal *rows)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(rows, r->n_rows * width));
  fold(r, n_kept, width, apart, A, rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedFoldBoth(const CondensedRows *r, PetscInt n_kept, PetscInt apart, const PetscReal *A,
                                 PetscReal *square)
{
  PetscReal *half, *turned;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(r->n_rows * n_kept, &half, r->n_rows * n_kept, &turned));
  PetscCall(CondensedFold(r, n_kept, n_kept, apart, A, half));
  for (PetscInt i = 0; i < r->n_rows; i++)
    for (PetscInt j = 0; j < n_kept; j++) turned[j * r->n_rows + i] = half[i * n_kept + j];
  PetscCall(CondensedFold(r, n_kept, r->n_rows, r->n_rows, turned, square));
  PetscCall(PetscFree2(half, turned));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up and forces */

/* Computes the share of a kept degree of freedom in the force on its row. The degrees of freedom of one
   support share equally, so the work is exact; CondensedInertial computes the individual reactions. */
static void find_shares(const Condensed *c, CondensedRows *r)
{
  for (PetscInt i = 0; i < c->n_kept; i++) {
    PetscInt alike = 0;
    const PetscInt s = r->slot[i];
    for (PetscInt j = 0; j < c->n_kept && s >= r->n_firm + r->n_calm; j++) alike += r->slot[j] == s;
    r->share[i] = alike ? 1. / (PetscReal)alike : s < r->n_firm ? 1. : r->mass[s];
  }
}

PetscErrorCode CondensedRowsCreate(const Model *m, PetscBool calms, const PetscReal *mass,
                                   const PetscReal *u_start, Condensed *c)
{
  CondensedRows *r;
  PetscReal *S;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&r));
  PetscCall(PetscCalloc6(c->n_kept, &r->slot, c->n_kept, &r->dof, c->n_kept, &r->mass, c->n_kept, &r->share,
                         c->n_kept, &r->u_start, c->n_kept, &r->f_start));
  number(m, c, (PetscBool)(calms && c->next < PETSC_INFINITY), r);
  if (r->n_calm) PetscCall(find_shapes(m, c, mass, r));
  r->n_rows = r->n_slots - r->n_calm + r->n_shapes, r->width = padded(r->n_rows);
  PetscCall(PetscCalloc6(r->calm_width, &r->calm, r->shape_width, &r->by_shape, r->n_slots, &r->at_slots,
                         r->width, &r->x, r->width, &r->f, r->width * r->width, &r->S));
  c->rows = r;
  PetscCall(PetscMalloc1(r->n_rows * r->n_rows, &S));
  PetscCall(CondensedFoldBoth(r, c->n_kept, c->stride, c->S, S));
  for (PetscInt i = 0; i < r->n_rows; i++)
    PetscCall(PetscArraycpy(r->S + i * r->width, S + i * r->n_rows, r->n_rows));
  PetscCall(PetscFree(S));
  if (!r->n_calm) PetscFunctionReturn(PETSC_SUCCESS);
  find_shares(c, r);
  for (PetscInt i = 0; i < c->n_kept; i++) r->u_start[i] = c->u[i] = u_start[c->kept[i]];
  DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
  PetscCall(PetscArraycpy(r->f_start, c->f, c->n_kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedRowsDestroy(Condensed *c)
{
  CondensedRows *r = c->rows;
  PetscFunctionBeginUser;
  if (!r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree6(r->slot, r->dof, r->mass, r->share, r->u_start, r->f_start));
  PetscCall(PetscFree6(r->calm, r->by_shape, r->at_slots, r->x, r->f, r->S));
  PetscCall(PetscFree2(r->shapes, r->across));
  PetscCall(PetscFree(c->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void CondensedForces(const Condensed *c, const PetscReal *u, PetscReal *f)
{
  const CondensedRows *r = c->rows;
  if (!r || !r->n_calm) {
    for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = u[c->kept[i]];
    DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
    memcpy(f, c->f, c->n_kept * sizeof *f);
    return;
  }
  for (PetscInt i = 0; i < c->n_kept; i++) r->at_slots[r->slot[i]] = u[c->kept[i]] - r->u_start[i];
  CondensedFind(r, r->at_slots, r->x);
  DenseTimes(r->width, r->width, r->S, r->x, r->f);
  CondensedSpread(r, r->f, r->at_slots);
  for (PetscInt i = 0; i < c->n_kept; i++) f[i] = r->f_start[i] + r->share[i] * r->at_slots[r->slot[i]];
}

/* Counts the multiplications of CondensedForces and of coupled_bodies.c: stiffness, inertia and inverse of
   rows; coupling of rows and modes, three times; shapes, five times. */
PetscReal CondensedProducts(const Condensed *c)
{
  const CondensedRows *r = c->rows;
  const PetscReal n = (PetscReal)r->n_rows;
  return 3. * n * (n + (PetscReal)c->n_modes) + 5. * (PetscReal)r->n_calm * (PetscReal)r->n_shapes;
}

PetscErrorCode CondensedReportRows(const Model *m)
{
  PetscInt n[2] = {0, 0};
  PetscFunctionBeginUser;
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    if (c->rows) n[0] += c->rows->n_calm, n[1] += c->rows->n_shapes;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, m->comm));
  if (n[0])
    PetscCall(PetscPrintf(m->comm,
                          "  condensed bodies: %" PetscInt_FMT
                          " degrees of freedom under water, at supports and "
                          "probes move by %" PetscInt_FMT " shapes\n",
                          n[0], n[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* condense_left_out.c: gathers the modes of condensed bodies that are left out (condense_in_time.c) into a
   few.

   The kept modes leave out the mass W = Psi' M Psi - H H', with H = Psi' M Phi. Fixed to the kept
   vertices, this mass would reflect every impact at a joint, which in the body itself travels away as a
   wave. A joint between two such bodies would rattle, and blocks on it would slide by another distance.

   So W = sum h_i h_i', by its eigenvectors relative to the lumped masses of kept vertices. Eigenvectors
   with more than LEAST of these masses are taken; the rest stays fixed to the vertices. The inner motion
   of such a vector is phi_i, the part of Psi that the kept modes do not contain, of modal mass 1. It
   vibrates as one mode, at

   1 / omega_i^2 = phi_i' M K_II^-1 M phi_i,

   the mean of the modes left out, each weighed by its mass in phi_i. Its shape is omega_i^2 K_II^-1 M
   phi_i, which stores omega_i^2 / 2 and is orthogonal in K to all others: it is the deflection under the
   inertia of phi_i, so slow motion is accurate to one order in (omega / omega_i)^2 more than with fixed
   masses.

   It is damped by the ratio zeta = pi / (4 sqrt(3)). A column of density rho, speed of waves c and length
   L, with n modes kept, n large, has W = 2 rho L / (pi^2 n) and omega_i = sqrt(3) n pi c / L. A kept end
   that moves fast then feels 2 zeta omega_i W = rho c a unit of velocity, as of a column without an end. */
#include "blocks/blocks.h"
#include <petscblaslapack.h>

static const PetscReal LEAST = 0.5;           /* [-] of the lumped masses of kept vertices */
static const PetscReal ENDLESS = 0.453449841; /* [-] pi / (4 sqrt(3)) */

/* Work space of one body; rows of matrices belong to kept degrees of freedom or to modes. */
typedef struct {
  const Condensed *c;
  PetscReal *root; /* [kg^1/2] (n_inner,) roots of the masses */
  PetscReal *own;  /* [kg^1/2] (n_kept,) likewise */
  PetscInt n;      /* gathered modes */
  PetscReal *W;    /* (n_kept, n_kept) scaled by `own`; then its vectors, by rows */
  PetscReal *part; /* (n_kept,) its eigenvalues, ascending */
  PetscReal *phi;  /* (n, n_inner) times `root` */
  PetscReal *x;    /* (n, n_inner) K_II^-1 M phi */
  PetscReal *T;    /* (n, n) phi' M x; then its vectors, by rows */
  PetscReal *slow; /* (n,) 1/omega^2, ascending */
} Rest;

/* Computes the eigenvalues of a symmetric matrix, ascending, and replaces its rows by the eigenvectors. */
static PetscErrorCode split(PetscInt size, PetscReal *A, PetscReal *value)
{
  const PetscBLASInt n = (PetscBLASInt)size, room = 35 * n;
  PetscBLASInt info = 0;
  PetscReal *work;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(room, &work));
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &n, A, &n, value, work, &room, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "the modes of a condensed body were not gathered: %d",
             (int)info);
  PetscCall(PetscFree(work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes C = a C + b A B, by rows: A (n,k), B (k,width). */
static PetscErrorCode multiply(PetscInt rows, PetscInt inner, PetscInt columns, PetscReal b,
                               const PetscReal *A, const PetscReal *B, PetscReal a, PetscReal *C)
{
  const PetscBLASInt n = (PetscBLASInt)rows, k = (PetscBLASInt)inner, width = (PetscBLASInt)columns;
  PetscFunctionBeginUser;
  if (n && k && width)
    PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &width, &n, &k, &b, B, &width, A, &k, &a, C, &width));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes W, and selects its eigenvectors. */
static PetscErrorCode find_rest(const Model *m, Rest *r)
{
  const Condensed *c = r->c;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_inner; i++) r->root[i] = PetscSqrtReal(m->vertex_mass[c->inner[i] / 2]);
  for (PetscInt i = 0; i < c->n_kept; i++) r->own[i] = PetscSqrtReal(m->vertex_mass[c->kept[i] / 2]);
  for (PetscInt i = 0; i < c->n_kept; i++)
    for (PetscInt j = 0; j < c->n_kept; j++) {
      const PetscReal *of_i = c->inertia + i * c->size, *of_j = c->inertia + j * c->size;
      PetscReal rest = of_i[j];
      for (PetscInt k = c->n_kept; k < c->size; k++) rest -= of_i[k] * of_j[k];
      r->W[i * c->n_kept + j] = rest / (r->own[i] * r->own[j]);
    }
  PetscCall(split(c->n_kept, r->W, r->part));
  while (r->n < c->n_kept && r->part[c->n_kept - 1 - r->n] > LEAST) r->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the eigenvector of W with the i-th largest eigenvalue. */
static const PetscReal *shape_of(const Rest *r, PetscInt i)
{
  return r->W + (r->c->n_kept - 1 - i) * r->c->n_kept;
}

static PetscReal part_of(const Rest *r, PetscInt i)
{
  return r->part[r->c->n_kept - 1 - i];
}

/* Computes phi and its products. rows: (size, n_inner) Psi', then Phi', times `root`; the rows of Psi are
   overwritten. */
static PetscErrorCode find_modes(Rest *r, PetscReal *rows)
{
  const Condensed *c = r->c;
  const PetscInt n_modes = c->size - c->n_kept;
  PetscReal *H, *weights;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(c->n_kept * n_modes, &H, r->n * c->n_kept, &weights));
  for (PetscInt i = 0; i < c->n_kept; i++)
    PetscCall(PetscArraycpy(H + i * n_modes, c->inertia + i * c->size + c->n_kept, n_modes));
  PetscCall(multiply(c->n_kept, n_modes, c->n_inner, -1., H, rows + c->n_kept * c->n_inner, 1., rows));
  for (PetscInt i = 0; i < r->n; i++)
    for (PetscInt j = 0; j < c->n_kept; j++)
      weights[i * c->n_kept + j] = shape_of(r, i)[j] / (r->own[j] * PetscSqrtReal(part_of(r, i)));
  PetscCall(multiply(r->n, c->n_kept, c->n_inner, 1., weights, rows, 0., r->phi));
  PetscCall(PetscFree2(H, weights));
  for (PetscInt i = 0; i < r->n; i++) {
    PetscReal *x = r->x + i * c->n_inner;
    for (PetscInt d = 0; d < c->n_inner; d++) x[d] = r->root[d] * r->phi[i * c->n_inner + d];
    PetscCall(CondensedSolve(c, NULL, x, x));
  }
  for (PetscInt i = 0; i < r->n; i++)
    for (PetscInt j = 0; j < r->n; j++)
      for (PetscInt d = 0; d < c->n_inner; d++)
        r->T[i * r->n + j] += r->phi[i * c->n_inner + d] * r->root[d] * r->x[j * c->n_inner + d];
  PetscCall(split(r->n, r->T, r->slow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes row i of rotated rows: the part of the gathered mode i. */
static void turn(const Rest *r, PetscInt i, PetscInt width, const PetscReal *rows, PetscReal *row)
{
  const PetscReal *by = r->T + (r->n - 1 - i) * r->n; // the slowest first
  for (PetscInt j = 0; j < r->n; j++)
    for (PetscInt d = 0; d < width; d++) row[d] += by[j] * rows[j * width + d];
}

/* Allocates n more modes in the body, after its own. */
static PetscErrorCode widen(PetscInt n, Condensed *c)
{
  const PetscInt before = c->size, size = before + n, modes = c->n_modes;
  PetscReal *omega2, *shapes, *inertia, *along, *damper;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(modes + n, &omega2, (modes + n) * c->n_inner, &shapes, modes + n, &damper));
  PetscCall(PetscCalloc2(size * size, &inertia, 2 * size, &along));
  PetscCall(PetscArraycpy(omega2, c->omega2, modes));
  PetscCall(PetscArraycpy(shapes, c->shapes, modes * c->n_inner));
  PetscCall(PetscArraycpy(along, c->along, 2 * before));
  for (PetscInt i = 0; i < before; i++)
    PetscCall(PetscArraycpy(inertia + i * size, c->inertia + i * before, before));
  for (PetscInt i = before; i < size; i++) inertia[i * size + i] = 1.;
  PetscCall(PetscFree3(c->omega2, c->shapes, c->damper));
  PetscCall(PetscFree2(c->inertia, c->along));
  c->omega2 = omega2, c->shapes = shapes, c->damper = damper, c->inertia = inertia, c->along = along;
  c->n_modes += n, c->size = size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the gathered modes after the modes of the body. */
static PetscErrorCode append(const Rest *r, Condensed *c)
{
  const PetscInt first = c->n_modes;
  PetscReal *h, *row;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(r->n * c->n_kept, &h, PetscMax(c->n_kept, c->n_inner), &row));
  for (PetscInt i = 0; i < r->n; i++)
    for (PetscInt j = 0; j < c->n_kept; j++)
      h[i * c->n_kept + j] = PetscSqrtReal(part_of(r, i)) * r->own[j] * shape_of(r, i)[j];
  PetscCall(widen(r->n, c));
  for (PetscInt i = 0; i < r->n; i++) {
    const PetscInt mode = c->n_kept + first + i;
    PetscReal *shape = c->shapes + (first + i) * c->n_inner;
    const PetscReal omega2 = 1. / r->slow[r->n - 1 - i];
    c->omega2[first + i] = omega2, c->damper[first + i] = 2. * ENDLESS * PetscSqrtReal(omega2);
    PetscCall(PetscArrayzero(row, c->n_kept));
    turn(r, i, c->n_kept, h, row);
    for (PetscInt j = 0; j < c->n_kept; j++)
      c->inertia[mode * c->size + j] = c->inertia[j * c->size + mode] = row[j];
    turn(r, i, c->n_inner, r->x, shape);
    for (PetscInt d = 0; d < c->n_inner; d++) shape[d] *= omega2;
    PetscCall(PetscArrayzero(row, c->n_inner));
    turn(r, i, c->n_inner, r->phi, row);
    for (PetscInt d = 0; d < c->n_inner; d++) c->along[2 * mode + c->inner[d] % 2] += r->root[d] * row[d];
  }
  PetscCall(PetscFree2(h, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedGather(const Model *m, PetscReal *rows, Condensed *c)
{
  Rest r = {.c = c};
  PetscFunctionBeginUser;
  if (!(c->next < PETSC_INFINITY) || !c->n_kept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      PetscMalloc4(c->n_inner, &r.root, c->n_kept, &r.own, c->n_kept * c->n_kept, &r.W, c->n_kept, &r.part));
  PetscCall(find_rest(m, &r));
  PetscCall(PetscCalloc4(r.n * c->n_inner, &r.phi, r.n * c->n_inner, &r.x, r.n * r.n, &r.T, r.n, &r.slow));
  if (r.n) {
    PetscCall(find_modes(&r, rows));
    PetscCall(append(&r, c));
    c->n_gathered = r.n;
  }
  PetscCall(PetscFree4(r.root, r.own, r.W, r.part));
  PetscCall(PetscFree4(r.phi, r.x, r.T, r.slow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

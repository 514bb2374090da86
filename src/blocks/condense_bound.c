/* condense_bound.c: computes the stable time step of condensed bodies (condense_in_time.c) from their rows
   (condense_rows.c) and modes. Springs and dampers of contacts count by their row sums, to the ground, so
   each body has its own bound.

   Dampers C act on the velocity before, v- = (v- + v+)/2 - (v+ - v-)/2. So they act as centred dampers
   with a mass reduced by dt/2 C: the step is stable where 4 (M - dt/2 C) - dt^2 K has no negative
   eigenvalue. Centred dampers (CondensedCentred) do not change the step. */
#include "blocks/blocks.h"
#include <petscblaslapack.h>

/* The free part of a body: n rows and modes, the rows first; matrices (n,n). */
typedef struct {
  PetscInt n, n_rows;
  PetscReal *K, *M; /* of the body alone */
  PetscReal *k, *c; /* springs and dampers */
} Moving;

/* Computes T' A T between free rows: of a matrix `of` of kept degrees of freedom in rows of length
   `apart`, plus `more` times a vertex array; either may be NULL. */
static PetscErrorCode of_rows(const Condensed *c, const PetscReal *of, PetscInt apart, const PetscReal *more,
                              PetscInt n, PetscReal *to)
{
  const CondensedRows *r = c->rows;
  const PetscInt free = r->n_firm + r->n_shapes;
  PetscReal *A, *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(c->n_kept * c->n_kept, &A, r->n_rows * r->n_rows, &rows));
  for (PetscInt i = 0; i < c->n_kept; i++) {
    if (of) PetscCall(PetscArraycpy(A + i * c->n_kept, of + i * apart, c->n_kept));
    if (more) A[i * c->n_kept + i] += more[c->kept[i] / 2];
  }
  PetscCall(CondensedFoldBoth(r, c->n_kept, c->n_kept, A, rows));
  for (PetscInt i = 0; i < free; i++) PetscCall(PetscArraycpy(to + i * n, rows + i * r->n_rows, free));
  PetscCall(PetscFree2(A, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode moving_create(const Model *m, const Condensed *c, const PetscReal *springs,
                                    const PetscReal *dampers, Moving *x)
{
  const CondensedRows *r = c->rows;
  const PetscInt rows = r->n_firm + r->n_shapes, n = rows + c->n_modes;
  PetscReal *H;
  PetscFunctionBeginUser;
  x->n = n, x->n_rows = rows;
  PetscCall(PetscCalloc4(n * n, &x->K, n * n, &x->M, n * n, &x->k, n * n, &x->c));
  PetscCall(of_rows(c, c->S, c->stride, NULL, n, x->K));
  PetscCall(of_rows(c, c->inertia, c->size, m->vertex_mass, n, x->M));
  PetscCall(of_rows(c, NULL, 0, springs, n, x->k));
  PetscCall(of_rows(c, NULL, 0, dampers, n, x->c));
  PetscCall(PetscMalloc1(r->n_rows * c->n_modes, &H));
  PetscCall(CondensedFold(r, c->n_kept, c->n_modes, c->size, c->inertia + c->n_kept, H));
  for (PetscInt k = 0; k < c->n_modes; k++) {
    const PetscInt row = rows + k;
    x->K[row * n + row] = c->omega2[k], x->M[row * n + row] = 1.;
    for (PetscInt i = 0; i < rows; i++) x->M[row * n + i] = x->M[i * n + row] = H[i * c->n_modes + k];
  }
  PetscCall(PetscFree(H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode moving_destroy(Moving *x)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(x->K, x->M, x->k, x->c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether 4 M - dt^2 (K + k) - 2 dt (beta K + c) is positive definite. room: (n,n). */
static PetscErrorCode is_stable(const Moving *x, PetscReal beta, PetscReal dt, PetscReal *room,
                                PetscBool *yes)
{
  const PetscBLASInt n = (PetscBLASInt)x->n;
  PetscBLASInt info;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < x->n * x->n; i++)
    room[i] = 4. * x->M[i] - dt * ((dt + 2. * beta) * x->K[i] + dt * x->k[i] + 2. * x->c[i]);
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("U", &n, room, &n, &info));
  *yes = (PetscBool)(info == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the largest omega^2 of K x = omega^2 M x, both dense and (n,n), which are overwritten, and its
   x of modal mass 1. */
static PetscErrorCode largest_of(PetscInt n, PetscReal *K, PetscReal *M, PetscReal *omega2, PetscReal *x)
{
  const PetscBLASInt type = 1, size = (PetscBLASInt)n, room = 35 * size;
  const PetscReal none = 0.;
  PetscBLASInt found, info, *integers, *failed;
  PetscReal *work, *all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(n, &all, room, &work, 5 * n, &integers, n, &failed));
  PetscCallBLAS("LAPACKsygvx",
                LAPACKsygvx_(&type, "V", "I", "U", &size, K, &size, M, &size, &none, &none, &size, &size,
                             &none, &found, all, x, &size, work, &room, integers, failed, &info));
  PetscCheck(info == 0 && found == 1, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "the fastest vibration of a condensed body was not found: %d", (int)info);
  *omega2 = all[0];
  PetscCall(PetscFree4(all, work, integers, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the largest stable step [s] from below, to 1e-6. */
static PetscErrorCode find_step(const Moving *x, PetscReal beta, PetscReal *dt)
{
  PetscReal low = 0., high = 1., *room;
  PetscBool yes;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(x->n * x->n, &room));
  PetscCall(is_stable(x, beta, high, room, &yes));
  while (yes && high < 1e6) {
    low = high, high *= 2.;
    PetscCall(is_stable(x, beta, high, room, &yes));
  }
  while (high - low > 1e-6 * high) {
    const PetscReal middle = low > 0. ? 0.5 * (low + high) : 0.5 * high;
    PetscCall(is_stable(x, beta, middle, room, &yes));
    if (yes)
      low = middle;
    else
      high = middle;
  }
  *dt = low;
  PetscCall(PetscFree(room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal form(PetscInt n, const PetscReal *A, const PetscReal *x)
{
  PetscReal sum = 0.;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) sum += x[i] * A[i * n + j] * x[j];
  return sum;
}

/* Finds the motion that limits the step: that of the largest dt^2 K + 2 dt C over M. beta: [s] of the
   body, on the velocity before. */
static PetscErrorCode find_culprit(const Model *m, const Condensed *c, const Moving *x, PetscReal beta,
                                   PetscBool damped, PetscReal dt, CondensedStep *step)
{
  const PetscReal by = damped ? dt * (dt + 2. * beta) : 1.;
  PetscReal *K, *M, *v, omega2 = 0., most = -1.;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(x->n * x->n, &K, x->n * x->n, &M, x->n, &v));
  PetscCall(PetscArraycpy(M, x->M, x->n * x->n));
  for (PetscInt i = 0; i < x->n * x->n; i++)
    K[i] = by * x->K[i] + (damped ? dt * (dt * x->k[i] + 2. * x->c[i]) : x->k[i]);
  PetscCall(largest_of(x->n, K, M, &omega2, v));
  const PetscReal dampers = form(x->n, x->c, v), springs = form(x->n, x->k, v), own = form(x->n, x->K, v);
  step->dt = damped ? dt : 2. / PetscSqrtReal(omega2);
  step->joints = !damped ? springs / omega2 : beta > 0. ? dampers / (dampers + beta * own) : NAN;
  for (PetscInt i = 0; i < x->n_rows; i++)
    if (PetscAbsReal(v[i]) > most)
      most = PetscAbsReal(v[i]), step->dof = 3 * m->rigid.n + c->rows->dof[PetscMin(i, c->rows->n_firm)];
  PetscCall(PetscFree3(K, M, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedBound(const Model *m, const Condensed *c, const PetscReal *springs,
                              const PetscReal *dampers, CondensedStep step[2])
{
  const PetscReal beta = c->beta - CondensedCentred(c);
  Moving x;
  PetscReal most = beta, dt = 0.;
  PetscFunctionBeginUser;
  for (int i = 0; i < 2; i++) step[i] = (CondensedStep){PETSC_INFINITY, -1, 0.};
  if (c->rows->n_firm + c->rows->n_shapes + c->n_modes == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(moving_create(m, c, springs, dampers, &x));
  PetscCall(find_culprit(m, c, &x, 0., PETSC_FALSE, 0., step));
  for (PetscInt i = 0; i < c->n_kept; i++) most = PetscMax(most, dampers[c->kept[i] / 2]);
  if (most > 0.) {
    PetscCall(find_step(&x, beta, &dt));
    PetscCall(find_culprit(m, c, &x, beta, PETSC_TRUE, dt, step + 1));
  }
  PetscCall(moving_destroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

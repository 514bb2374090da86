/* vibration_bodies.c: adds the inside of condensed bodies to small free vibrations of the whole model. With
   x = (u_B, q) a body has the stiffness and inertia (d) of condense_in_time.c, so each of its modes is a
   row of its own.

   The modes of a body that are left out would respond to the part of the inertia load that no other mode
   takes,

   r = omega^2 M_II u_I - K_II u_I - K_IB u_B,

   to which the kept modes are orthogonal. By second-order perturbation they lower omega^2 by the sum of
   (phi_j . r)^2/(Omega_j^2 - omega^2) over them, where r.K_II^-1 r is the sum of (phi_j . r)^2/Omega_j^2.
   With Omega the first one, the error of omega^2 is therefore about r.K_II^-1 r, and at most r.K_II^-1 r/(1
   - omega^2/Omega^2). */
#include "solve/vibration.h"

/* ---- rows */

/* Returns the global row in the larger matrix for row i of the smaller one. smaller, larger: (size + 1,)
   first rows of the ranks. */
static PetscInt larger_row(PetscMPIInt size, const PetscInt *smaller, const PetscInt *larger, PetscInt i)
{
  PetscMPIInt low = 0, high = size; // smaller[low] <= i < smaller[high]
  while (high - low > 1) {
    const PetscMPIInt middle = (low + high) / 2;
    if (smaller[middle] <= i)
      low = middle;
    else
      high = middle;
  }
  return larger[low] + i - smaller[low];
}

/* Copies the rows of the tangent into K. only_count: counts their entries instead, in and out of the own
   columns of the rank. */
static PetscErrorCode copy_rows(Mat tangent, Mat K, PetscMPIInt size, PetscBool only_count, PetscInt *own,
                                PetscInt *other)
{
  const PetscInt *smaller, *larger, *column;
  const PetscScalar *value;
  PetscInt first, end, n;
  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(tangent, &first, &end));
  PetscCall(MatGetOwnershipRanges(tangent, &smaller));
  if (!only_count) PetscCall(MatGetOwnershipRanges(K, &larger));
  for (PetscInt i = first; i < end; i++) {
    PetscCall(MatGetRow(tangent, i, &n, &column, &value));
    for (PetscInt j = 0; j < n; j++) {
      if (only_count)
        ++*(column[j] >= first && column[j] < end ? own + i - first : other + i - first);
      else
        PetscCall(MatSetValue(K, larger_row(size, smaller, larger, i),
                              larger_row(size, smaller, larger, column[j]), value[j], INSERT_VALUES));
    }
    PetscCall(MatRestoreRow(tangent, i, &n, &column, &value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InsideStiffness(const Model *m, Mat tangent, Mat *K)
{
  const PetscInt rows = m->n_dof + m->condensed.n_modes;
  PetscInt *own, *other, first;
  PetscFunctionBeginUser;
  if (!m->condensed.mode_start) {
    PetscCall(PetscObjectReference((PetscObject)tangent));
    *K = tangent;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscCalloc2(rows, &own, rows, &other));
  PetscCall(copy_rows(tangent, NULL, m->size, PETSC_TRUE, own, other));
  for (PetscInt k = 0; k < m->condensed.n_modes; k++) own[m->n_dof + k] = 1;
  PetscCall(MatCreateAIJ(m->comm, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, 0, own, 0, other, K));
  PetscCall(PetscFree2(own, other));
  PetscCall(copy_rows(tangent, *K, m->size, PETSC_FALSE, NULL, NULL));
  PetscCall(MatGetOwnershipRange(*K, &first, NULL));
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt k = 0; k < c->n_modes; k++) {
      const PetscInt row = first + m->n_dof + c->first_mode + k;
      PetscCall(MatSetValue(*K, row, row, c->omega2[k], INSERT_VALUES));
    }
  PetscCall(MatAssemblyBegin(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*K, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- mass */

/* Returns the row on this rank of degree of freedom or mode i of a body; -1: it is held, or it gathers
   modes that are left out, which swing in dynamic stages only. */
static PetscInt row_of(const Model *m, const Condensed *c, PetscInt i)
{
  if (i >= c->size - c->n_gathered) return -1;
  if (i >= c->n_kept) return m->n_dof + c->first_mode + i - c->n_kept;
  const PetscInt d = 3 * m->rigid.n + c->kept[i];
  return Held(m, d) ? -1 : d;
}

PetscErrorCode InsideRoom(const Model *m, PetscInt *diagonal)
{
  PetscFunctionBeginUser;
  for (const Condensed *c = m->condensed.body;
       c < m->condensed.body + m->condensed.n && m->condensed.mode_start; c++)
    for (PetscInt i = 0; i < c->size; i++)
      if (row_of(m, c, i) >= 0) diagonal[row_of(m, c, i)] = c->size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InsideMass(Mass *mass, PetscReal moving[2])
{
  const Model *m = mass->m;
  PetscFunctionBeginUser;
  for (const Condensed *c = m->condensed.body;
       c < m->condensed.body + m->condensed.n && m->condensed.mode_start; c++) {
    for (PetscInt i = 0; i < c->size; i++) {
      const PetscInt row = row_of(m, c, i);
      for (PetscInt j = 0; j < c->size && row >= 0; j++)
        if (row_of(m, c, j) >= 0)
          PetscCall(MatSetValue(mass->M, mass->first + row, mass->first + row_of(m, c, j),
                                c->inertia[i * c->size + j], ADD_VALUES));
      for (int x = 0; x < 2 && row >= 0; x++) mass->pull[x * mass->rows + row] += c->along[2 * i + x];
    }
    for (PetscInt k = c->n_modes - c->n_gathered; k < c->n_modes; k++) { // a row without mass
      const PetscInt row = mass->first + m->n_dof + c->first_mode + k;
      PetscCall(MatSetValue(mass->M, row, row, 0., ADD_VALUES));
    }
    for (int x = 0; x < 2; x++) moving[x] += c->inside[x];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- shapes */

PetscErrorCode InsideShape(const Model *m, const PetscReal *phi, PetscReal *u)
{
  PetscFunctionBeginUser;
  if (!m->condensed.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CondensedInner(m, NULL, u));
  CondensedAddModes(m, phi + m->n_dof, u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to error the amount [1/s2] by which the modes left out of one body lower omega^2. r: vertex array;
   x: work array of the same size. */
static PetscErrorCode error_of(const Condensed *c, const PetscReal *r, PetscReal omega2, PetscReal *x,
                               PetscReal *error)
{
  const PetscReal next = 2. * PETSC_PI * c->next, share = omega2 / (next * next);
  PetscReal sum = 0.;
  PetscFunctionBeginUser;
  if (c->next == PETSC_INFINITY) PetscFunctionReturn(PETSC_SUCCESS); // none is left out
  PetscCall(CondensedSolve(c, c->inner, r, x));
  for (PetscInt i = 0; i < c->n_inner; i++) sum += r[c->inner[i]] * x[c->inner[i]];
  *error += share < 1. ? sum / (1. - share) : NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InsideError(const Model *m, const PetscReal *u, PetscReal omega2, PetscReal *error)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *r, *x;
  PetscFunctionBeginUser;
  *error = 0.;
  PetscCall(PetscCalloc2(n, &r, n, &x));
  if (m->condensed.n) ElementForcesCondensed(m, u, r);
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++)
    r[d] = omega2 * m->vertex_mass[d / 2] * u[d] - r[d];
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    PetscCall(error_of(c, r, omega2, x, error));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, error, 1, MPIU_REAL, MPI_SUM, m->comm));
  *error = omega2 > 0. ? 0.5 * *error / omega2 : NAN;
  PetscCall(PetscFree2(r, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

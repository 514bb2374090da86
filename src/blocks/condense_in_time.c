/* condense_in_time.c: computes the modes and inertia of condensed bodies in dynamic stages, by the
   reduction of Craig and Bampton (1968).

   Inner vertices of a condensed body (condense.c) follow its kept vertices statically, and vibrate about
   this position in the modes of the body with kept vertices fixed:

   u_I = Psi u_B + K_II^-1 f_I + Phi q,   Psi = -K_II^-1 K_IB,   K_II Phi = M_II Phi Omega^2.
   (c)

   q is counted from the equilibrium of the loads inside, so a body that rests has q = 0. With modal masses
   of 1 the body has in (u_B, q)

     the stiffness [ S       0 ]      and beside the lumped masses of    [ Psi' M Psi   Psi' M Phi ]
                   [ 0  Omega^2 ]     its kept vertices the inertia      [ Phi' M Psi        1     ].      (d)

   With all modes it is the whole mesh in other coordinates. The modes left out are gathered into a few,
   which are damped (condense_left_out.c). The set-up reports which are left out.

   Mass-proportional damping acts on the same matrix. Ground that moves by g moves all of the body by g, so
   the damping is relative to M (1, 1, ...) g, whose reduced form is `along`. */
#include "blocks/blocks.h"
#include "base/eigen.h"
#include <petscblaslapack.h>

static const PetscReal SEARCHED = 1.2; /* times the highest frequency: the first mode left out may be found */
enum { SMALL = 400 }; /* inner degrees of freedom; in smaller bodies all modes are found at once */
static const PetscReal SAME = 1e-6; /* modes whose marks differ by more are different */

/* ---- set-up */

/* Returns the highest frequency [rad/s] requested by the groups of a body. */
static PetscReal highest_of(const Scene *scene, const Model *m, const Condensed *c)
{
  PetscReal highest = 0.;
  for (const Elements *list = m->mesh.elements + MOVING_LISTS; list < m->mesh.elements + ELEMENT_LISTS;
       list++)
    for (PetscInt e = 0; e < list->n; e++)
      if (m->mesh.vertex_condensed[VertexOf(list, e, 0)] == c->number)
        highest = PetscMax(highest, scene->materials[list->group[e]].highest_frequency);
  return 2. * PETSC_PI * highest;
}

static PetscReal mass_of(const Model *m, const Condensed *c, PetscInt i)
{
  return m->vertex_mass[c->inner[i] / 2];
}

/* Keeps the modes up to the highest frequency, of n that were found: all slower than `searched`. */
static PetscErrorCode take_modes(PetscInt n, const PetscReal *omega2, const PetscReal *shapes,
                                 PetscReal highest, PetscReal searched, Condensed *c)
{
  PetscFunctionBeginUser;
  while (c->n_modes < n && omega2[c->n_modes] <= highest * highest) c->n_modes++;
  PetscCall(
      PetscCalloc3(c->n_modes, &c->omega2, c->n_modes * c->n_inner, &c->shapes, c->n_modes, &c->damper));
  PetscCall(PetscArraycpy(c->omega2, omega2, c->n_modes));
  PetscCall(PetscArraycpy(c->shapes, shapes, c->n_modes * c->n_inner));
  const PetscReal next = c->n_modes < n ? PetscSqrtReal(omega2[c->n_modes]) : searched;
  c->next = c->n_modes < c->n_inner ? next / (2. * PETSC_PI) : PETSC_INFINITY;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds all modes of a small body, from M^-1/2 K M^-1/2. */
static PetscErrorCode all_modes(const Model *m, Mat K, PetscReal highest, Condensed *c)
{
  const PetscBLASInt n = (PetscBLASInt)c->n_inner, room = 35 * n;
  PetscBLASInt info;
  PetscReal *A, *omega2, *work;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(c->n_inner * c->n_inner, &A, n, &omega2, room, &work));
  for (PetscInt i = 0; i < c->n_inner; i++) {
    const PetscInt *column;
    const PetscScalar *value;
    PetscInt entries;
    PetscCall(MatGetRow(K, i, &entries, &column, &value));
    for (PetscInt j = 0; j < entries; j++)
      if (column[j] < c->n_inner)
        A[i * c->n_inner + column[j]] = value[j] / PetscSqrtReal(mass_of(m, c, i) * mass_of(m, c, column[j]));
    PetscCall(MatRestoreRow(K, i, &entries, &column, &value));
  }
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &n, A, &n, omega2, work, &room, &info));
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "the modes of a condensed body were not found: %d",
             (int)info);
  for (PetscInt i = 0; i < c->n_inner * c->n_inner; i++) A[i] /= PetscSqrtReal(mass_of(m, c, i % c->n_inner));
  PetscCall(take_modes(c->n_inner, omega2, A, highest, highest, c));
  PetscCall(PetscFree3(A, omega2, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the slowest modes of a large body. wants: MUMPS has too little memory. */
static PetscErrorCode slowest_modes(const Model *m, Mat K, PetscReal highest, Condensed *c, PetscBool *wants)
{
  Mat K_II, M_II;
  IS inner;
  Modes modes;
  PetscFunctionBeginUser;
  PetscCall(ISCreateStride(PETSC_COMM_SELF, c->n_inner, 0, 1, &inner));
  PetscCall(MatCreateSubMatrix(K, inner, inner, MAT_INITIAL_MATRIX, &K_II));
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, c->n_inner, c->n_inner, 1, NULL, &M_II));
  for (PetscInt i = 0; i < c->n_inner; i++)
    PetscCall(MatSetValue(M_II, i, i, mass_of(m, c, i), INSERT_VALUES));
  PetscCall(MatAssemblyBegin(M_II, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(M_II, MAT_FINAL_ASSEMBLY));
  PetscCall(LowestModes(K_II, M_II, SEARCHED * highest, 0, &modes));
  *wants = modes.wants;
  if (!*wants) {
    PetscCheck(modes.missed == 0, PETSC_COMM_SELF, PETSC_ERR_LIB,
               "%" PetscInt_FMT " modes of a condensed body were not found", modes.missed);
    PetscCall(take_modes(modes.n, modes.omega2, modes.shapes, highest, SEARCHED * highest, c));
  }
  PetscCall(ModesDestroy(&modes));
  PetscCall(MatDestroy(&K_II));
  PetscCall(MatDestroy(&M_II));
  PetscCall(ISDestroy(&inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes row i of Psi': inner displacements for a unit displacement of kept degree of freedom i. */
static PetscErrorCode follow(Mat K, Condensed *c, PetscInt i, PetscReal *row)
{
  const PetscInt *column;
  const PetscScalar *value;
  PetscInt n;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(row, c->n_inner));
  PetscCall(MatGetRow(K, c->n_inner + i, &n, &column, &value));
  for (PetscInt j = 0; j < n; j++)
    if (column[j] < c->n_inner) row[column[j]] = -value[j];
  PetscCall(MatRestoreRow(K, c->n_inner + i, &n, &column, &value));
  PetscCall(CondensedSolve(c, NULL, row, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes rows: (size, n_inner) Psi', then Phi', each times the roots of the masses. */
static PetscErrorCode weigh(const Model *m, Mat K, Condensed *c, PetscReal *rows)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_kept && c->n_inner; i++) PetscCall(follow(K, c, i, rows + i * c->n_inner));
  PetscCall(PetscArraycpy(rows + c->n_kept * c->n_inner, c->shapes, c->n_modes * c->n_inner));
  for (PetscInt i = 0; i < c->size * c->n_inner; i++) rows[i] *= PetscSqrtReal(mass_of(m, c, i % c->n_inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the inertia of (d), and its product with rigid motions along x and y. */
static PetscErrorCode find_inertia(const Model *m, const PetscReal *rows, Condensed *c)
{
  const PetscBLASInt n = (PetscBLASInt)c->size, k = (PetscBLASInt)c->n_inner;
  const PetscReal one = 1., zero = 0.;
  PetscFunctionBeginUser;
  if (k && n)
    PetscCallBLAS("BLASgemm",
                  BLASgemm_("T", "N", &n, &n, &k, &one, rows, &k, rows, &k, &zero, c->inertia, &n));
  for (PetscInt i = 0; i < c->size; i++)
    for (PetscInt j = 0; j <= i; j++) {
      PetscReal *entry = c->inertia + i * c->size + j;
      if (j >= c->n_kept) *entry = i == j; // modal masses
      c->inertia[j * c->size + i] = *entry;
    }
  for (PetscInt i = 0; i < c->size; i++)
    for (PetscInt d = 0; d < c->n_inner; d++)
      c->along[2 * i + c->inner[d] % 2] += rows[i * c->n_inner + d] * PetscSqrtReal(mass_of(m, c, d));
  for (PetscInt d = 0; d < c->n_inner; d++) c->inside[c->inner[d] % 2] += mass_of(m, c, d);
  for (int x = 0; x < 2; x++) {
    c->left_out[x] = c->inside[x];
    for (PetscInt i = c->n_kept; i < c->size; i++)
      c->left_out[x] -= c->along[2 * i + x] * c->along[2 * i + x];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums h h'/Omega^2 over the modes left out, with h = Psi' M phi: the sum over all modes minus that over
   the kept ones. rows: as for find_inertia. */
static PetscErrorCode find_truncated(const Model *m, const PetscReal *rows, Condensed *c)
{
  const PetscBLASInt n = (PetscBLASInt)c->n_kept, k = (PetscBLASInt)c->n_inner,
                     stride = (PetscBLASInt)c->stride;
  const PetscReal one = 1., zero = 0.;
  PetscReal *load, *x;
  PetscFunctionBeginUser;
  if (c->next == PETSC_INFINITY || !n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(c->stride * c->stride, &c->truncated));
  PetscCall(PetscMalloc2(c->n_kept * c->n_inner, &load, c->n_kept * c->n_inner, &x));
  for (PetscInt i = 0; i < c->n_kept * c->n_inner; i++)
    load[i] = rows[i] * PetscSqrtReal(mass_of(m, c, i % c->n_inner));
  PetscCall(CondensedSolveMany(c, c->n_kept, load, x));
  PetscCallBLAS("BLASgemm",
                BLASgemm_("T", "N", &n, &n, &k, &one, load, &k, x, &k, &zero, c->truncated, &stride));
  for (PetscInt i = 0; i < c->n_kept; i++)
    for (PetscInt j = 0; j < c->n_kept; j++) {
      const PetscReal *H_i = c->inertia + i * c->size + c->n_kept,
                      *H_j = c->inertia + j * c->size + c->n_kept;
      for (PetscInt mode = 0; mode < c->n_modes; mode++)
        c->truncated[i * c->stride + j] -= H_i[mode] * H_j[mode] / c->omega2[mode];
    }
  PetscCall(PetscFree2(load, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedModes(const Scene *scene, const Model *m, Mat K, Condensed *c, PetscBool *wants)
{
  PetscReal *rows;
  PetscFunctionBeginUser;
  c->next = PETSC_INFINITY;
  if (c->n_inner > SMALL)
    PetscCall(slowest_modes(m, K, highest_of(scene, m, c), c, wants));
  else if (c->n_inner)
    PetscCall(all_modes(m, K, highest_of(scene, m, c), c));
  if (*wants) PetscFunctionReturn(PETSC_SUCCESS);
  c->size = c->n_kept + c->n_modes;
  PetscCall(PetscCalloc2(c->size * c->size, &c->inertia, 2 * c->size, &c->along));
  PetscCall(PetscMalloc1(c->size * c->n_inner, &rows));
  PetscCall(weigh(m, K, c, rows));
  PetscCall(find_inertia(m, rows, c));
  if (SceneInTime(scene)) PetscCall(find_truncated(m, rows, c));
  if (SceneInTime(scene)) PetscCall(CondensedGather(m, rows, c));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedModesDestroy(Condensed *c)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(c->omega2, c->shapes, c->damper));
  PetscCall(PetscFree2(c->inertia, c->along));
  PetscCall(PetscFree(c->truncated));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses bodies whose kept vertices belong to rigid ones. */
static PetscErrorCode check_kept(const Scene *scene, const Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->condensed.n && !message[0]; b++) {
    const Condensed *c = m->condensed.body + b;
    for (PetscInt i = 0; i < c->n_kept && !message[0]; i++) {
      const PetscInt v = c->kept[i] / 2;
      if (v < m->mesh.n_deformable) continue;
      PetscCall(
          PetscSNPrintf(message, MESSAGE_LENGTH,
                        "%s: materials: a condensed body shares the vertex at x = %.6g m, y = %.6g m "
                        "with a rigid one, and a stage is dynamic or of type modes: do not condense its "
                        "group",
                        scene->file, (double)m->mesh.X[2 * v], (double)m->mesh.X[2 * v + 1]));
    }
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedModesNumber(const Scene *scene, Model *m)
{
  CondensedBodies *bodies = &m->condensed;
  PetscFunctionBeginUser;
  PetscCall(check_kept(scene, m));
  PetscCall(PetscCalloc1(m->mesh.n_condensed_global + 1, &bodies->mode_start));
  for (PetscInt b = 0; b < bodies->n; b++) {
    Condensed *c = bodies->body + b;
    bodies->mode_start[c->number + 1] = c->n_modes;
    c->first_mode = bodies->n_modes;
    bodies->n_modes += c->n_modes;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bodies->mode_start, (PetscMPIInt)(m->mesh.n_condensed_global + 1),
                             MPIU_INT, MPI_SUM, m->comm));
  for (PetscInt b = 0; b < m->mesh.n_condensed_global; b++)
    bodies->mode_start[b + 1] += bodies->mode_start[b];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedReport(const Model *m)
{
  PetscReal sum[5] = {0.}, next = PETSC_INFINITY, share[2];
  PetscFunctionBeginUser;
  if (!m->condensed.mode_start) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < m->condensed.n; b++) {
    const Condensed *c = m->condensed.body + b;
    for (int x = 0; x < 2; x++) sum[x] += c->left_out[x], sum[2 + x] += c->inside[x];
    sum[4] += (PetscReal)c->n_gathered;
    next = PetscMin(next, c->next);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 5, MPIU_REAL, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &next, 1, MPIU_REAL, MPI_MIN, m->comm));
  for (int x = 0; x < 2; x++) share[x] = sum[2 + x] > 0. ? 100. * PetscMax(sum[x], 0.) / sum[2 + x] : 0.;
  PetscCall(PetscPrintf(m->comm, "vibrations within condensed bodies: %" PetscInt_FMT " modes",
                        m->condensed.mode_start[m->mesh.n_condensed_global] - (PetscInt)sum[4]));
  if (next < PETSC_INFINITY)
    PetscCall(PetscPrintf(m->comm,
                          ", none from %.4g Hz on: %.2g %% of the mass inside along x, %.2g %% along y, has "
                          "no modes and %s",
                          (double)next, (double)share[0], (double)share[1],
                          sum[4] > 0. ? "" : "follows as if at rest\n"));
  if (sum[4] > 0.)
    PetscCall(PetscPrintf(m->comm, "is gathered into %g more, which are damped\n", (double)sum[4]));
  if (next == PETSC_INFINITY) PetscCall(PetscPrintf(m->comm, ", all there are\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- dynamic stages */

/* Returns the load of forces f on inner vertices in mode k; f: vertex array. */
static PetscReal modal_load(const Condensed *c, PetscInt k, const PetscReal *f)
{
  PetscReal p = 0.;
  for (PetscInt i = 0; i < c->n_inner; i++) p += c->shapes[k * c->n_inner + i] * f[c->inner[i]];
  return p;
}

void CondensedRest(const Model *m, const State *s)
{
  for (int i = MODE_PLACE; i <= MODE_SPEED; i++)
    for (PetscInt k = 0; k < m->condensed.n_modes; k++) s->modes[i][k] = 0.;
}

/* Changes q with the loads on inner vertices, whose positions stay. */
void CondensedLoaded(const Model *m, State *s)
{
  for (PetscInt b = 0; b < m->condensed.n && m->condensed.n_modes; b++) {
    const Condensed *c = m->condensed.body + b;
    for (PetscInt k = 0; k < c->n_modes; k++) {
      const PetscReal p = modal_load(c, k, s->f_ext + 3 * m->rigid.n);
      PetscReal *before = s->modes[MODE_LOAD] + c->first_mode + k;
      s->modes[MODE_PLACE][c->first_mode + k] += (*before - p) / c->omega2[k];
      *before = p;
    }
  }
}

/* Adds, at held degrees of freedom, S u minus the part already applied (condense_rows.c). */
static void add_not_given(const Model *m, const Condensed *c, const State *s)
{
  const PetscReal *u = s->u + 3 * m->rigid.n;
  if (!c->rows || !c->rows->n_calm) return;
  for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = u[c->kept[i]];
  DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
  CondensedForces(c, u, c->u);
  for (PetscInt i = 0; i < c->n_kept; i++)
    if (c->rows->slot[i] >= c->rows->n_firm + c->rows->n_calm)
      s->inertial[3 * m->rigid.n + c->kept[i]] += c->f[i] - c->u[i];
}

/* Computes the force of the modes from K_BI Phi = -H Omega^2, which holds because K_II Phi = M_II Phi
   Omega^2. */
void CondensedInertial(const Model *m, const State *s)
{
  for (PetscInt b = 0; b < m->condensed.n && m->condensed.mode_start; b++) {
    const Condensed *c = m->condensed.body + b;
    const PetscReal *q = s->modes[MODE_PLACE] + c->first_mode, *speed = s->modes[MODE_SPEED] + c->first_mode;
    memset(c->u, 0, c->n_kept * sizeof *c->u);
    for (PetscInt k = 0; k < c->n_modes; k++) {
      const PetscReal *H = c->inertia + (c->n_kept + k) * c->size,
                      force = c->omega2[k] * q[k] + CondensedDamper(c, k) * speed[k];
      for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] -= H[i] * force;
    }
    for (PetscInt i = 0; i < c->n_kept; i++) s->inertial[3 * m->rigid.n + c->kept[i]] = c->u[i];
    add_not_given(m, c, s);
  }
}

void CondensedAddModes(const Model *m, const PetscReal *places, PetscReal *u)
{
  for (PetscInt b = 0; b < m->condensed.n && m->condensed.n_modes; b++) {
    const Condensed *c = m->condensed.body + b;
    const PetscReal *q = places + c->first_mode;
    for (PetscInt k = 0; k < c->n_modes; k++)
      for (PetscInt i = 0; i < c->n_inner; i++) u[c->inner[i]] += c->shapes[k * c->n_inner + i] * q[k];
  }
}

/* ---- archive */

/* Returns a number that distinguishes a mode, with its sign, from others: its product with a pattern
   without symmetry. */
static PetscReal signature_of(const Model *m, const Condensed *c, PetscInt k)
{
  PetscReal mark = 0.;
  for (PetscInt i = 0; i < c->n_inner; i++) {
    const uint64_t name = 2 * (uint64_t)m->mesh.vertex_gid[c->inner[i] / 2] + (uint64_t)(c->inner[i] % 2);
    mark += c->shapes[k * c->n_inner + i] * (PetscReal)(HashWord(name) >> 11) * 0x1p-53;
  }
  return mark;
}

PetscErrorCode CondensedArchive(Archive *a, const Model *m, State *s)
{
  enum { COLUMNS = MODE_ARRAYS + 1 };
  const PetscInt n = m->condensed.mode_start ? m->condensed.mode_start[m->mesh.n_condensed_global] : 0;
  PetscReal *all, *marks;
  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(COLUMNS * n, &all, n, &marks));
  for (PetscInt b = 0; b < m->condensed.n; b++)
    for (PetscInt k = 0; k < m->condensed.body[b].n_modes; k++) {
      const PetscInt row = m->condensed.mode_start[m->condensed.body[b].number] + k;
      marks[row] = all[COLUMNS * row + MODE_ARRAYS] = signature_of(m, m->condensed.body + b, k);
      for (int i = 0; i < MODE_ARRAYS; i++)
        all[COLUMNS * row + i] = s->modes[i][m->condensed.body[b].first_mode + k];
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, (PetscMPIInt)(COLUMNS * n), MPIU_REAL, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, marks, (PetscMPIInt)n, MPIU_REAL, MPI_SUM, m->comm));
  PetscCall(ArchiveReals(a, "modes", COLUMNS * n, all));
  for (PetscInt row = 0; row < n && a->reading; row++)
    if (!(PetscAbsReal(all[COLUMNS * row + MODE_ARRAYS] - marks[row]) <= SAME * PetscAbsReal(marks[row])) &&
        !a->message[0])
      PetscCall(PetscSNPrintf(a->message, MESSAGE_LENGTH,
                              "the modes of its condensed bodies are not those found now: it was written on "
                              "another machine, or by another program"));
  for (PetscInt b = 0; b < m->condensed.n && a->reading; b++)
    for (PetscInt k = 0; k < m->condensed.body[b].n_modes; k++)
      for (int i = 0; i < MODE_ARRAYS; i++)
        s->modes[i][m->condensed.body[b].first_mode + k] =
            all[COLUMNS * (m->condensed.mode_start[m->condensed.body[b].number] + k) + i];
  PetscCall(PetscFree2(all, marks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

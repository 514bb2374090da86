/* stiffness.c: assembles the stiffness of all force terms into a PETSc matrix.

   Terms give the stiffness between vertices (term.h: tangent); this file adds it to the rows of the degrees
   of freedom. A vertex of a rigid body moves with the centre by T = [1 0 -r_y; 0 1 r_x], so its stiffness
   is T' k T. */
#include "solve/stiffness.h"

enum { MOST = STIFFNESS_VERTICES };

/* ---- rows */

/* Computes the arms [m] of vertices of rigid bodies at displacements u (NULL: undeformed). An exchange
   gives ghosts the centre of their body. */
static PetscErrorCode set_arms(const Model *m, const PetscReal *u, Stiffness *s)
{
  PetscReal *arm = s->arm;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(arm, 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  for (PetscInt v = m->mesh.n_deformable; v < m->mesh.n_moving; v++)
    for (int x = 0; x < 2; x++) {
      const PetscInt body = RigidOfVertex(m, v);
      arm[2 * v + x] = m->rigid.X[2 * body + x] + (u ? u[3 * body + x] : 0.);
    }
  PetscCall(GhostBegin(m, arm));
  PetscCall(GhostEnd(m, arm));
  for (PetscInt i = 0; i < 2 * m->mesh.n_vertices; i++)
    arm[i] = m->mesh.vertex_rigid[i / 2] < 0 ? 0. : m->mesh.X[i] + (u ? u[3 * m->rigid.n + i] : 0.) - arm[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the rows of all vertices. Two exchanges of pairs of numbers (exact as reals) give ghosts their
   rows. */
static PetscErrorCode number_rows(const Model *m, Stiffness *s)
{
  const PetscInt at = 3 * m->rigid.n, n = m->mesh.n_vertices + DUMMY_VERTICES;
  PetscReal *pair;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n, &pair));
  for (PetscInt i = 0; i < 3 * n; i++) s->row[i] = -1;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++) { // inner vertices of condensed bodies have none
    const PetscInt body = v < m->mesh.n_deformable ? -1 : RigidOfVertex(m, v),
                   dof = body < 0 ? at + 2 * v : 3 * body;
    for (int i = 0; i < (body < 0 ? 2 : 3); i++)
      s->row[3 * v + i] = Held(m, dof + i) ? -1 : s->first + dof + i;
  }
  for (int part = 0; part < 2; part++) {
    for (PetscInt v = 0; v < n; v++) {
      const PetscInt *row = s->row + 3 * v;
      pair[2 * v] = (PetscReal)row[part ? 2 : 0], pair[2 * v + 1] = (PetscReal)row[1];
    }
    PetscCall(GhostBegin(m, pair));
    PetscCall(GhostEnd(m, pair));
    for (PetscInt v = m->mesh.n_owned; v < m->mesh.n_vertices; v++) {
      if (part == 0) s->row[3 * v] = (PetscInt)pair[2 * v], s->row[3 * v + 1] = (PetscInt)pair[2 * v + 1];
      if (part == 1) s->row[3 * v + 2] = (PetscInt)pair[2 * v];
    }
  }
  PetscCall(PetscFree(pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessAdd(const Model *m, const Stiffness *s, Mat matrix, PetscInt n,
                            const PetscInt *vertices, const PetscReal *k)
{
  PetscReal small[9 * MOST * MOST], *full = small;
  PetscInt rows[3 * MOST], *row = rows;
  PetscFunctionBeginUser;
  if (n > MOST) PetscCall(PetscMalloc2(9 * n * n, &full, 3 * n, &row));
  PetscCall(PetscArrayzero(full, 9 * n * n));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) {
      PetscReal arm[2][2] = {{0., 0.}, {0., 0.}}; // d(x, y)/d(rotation) of the two vertices
      for (int e = 0; e < 2; e++) {
        const PetscInt v = vertices[e ? j : i];
        if (v >= m->mesh.n_vertices || m->mesh.vertex_rigid[v] < 0) continue;
        arm[e][0] = -s->arm[2 * v + 1], arm[e][1] = s->arm[2 * v];
      }
      for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++) {
          const PetscReal value = k[(2 * i + a) * 2 * n + 2 * j + b];
          full[(3 * i + a) * 3 * n + 3 * j + b] += value;
          full[(3 * i + 2) * 3 * n + 3 * j + b] += arm[0][a] * value;
          full[(3 * i + a) * 3 * n + 3 * j + 2] += value * arm[1][b];
          full[(3 * i + 2) * 3 * n + 3 * j + 2] += arm[0][a] * value * arm[1][b];
        }
    }
  for (PetscInt i = 0; i < 3 * n; i++) row[i] = s->row[3 * vertices[i / 3] + i % 3];
  PetscCall(MatSetValues(matrix, 3 * n, row, 3 * n, row, full, ADD_VALUES));
  if (n > MOST) PetscCall(PetscFree2(full, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- blocks, joints and what else there is */

/* The matrix that force terms add their stiffness to. */
typedef struct {
  const Model *m;
  const Stiffness *s;
  Mat matrix;
  Stiffness *places; /* s, where it keeps places; NULL: each value is searched for in its row */
  PetscInt next;     /* number of the next place */
  PetscReal *values; /* (entries,) values of the matrix */
} TermMatrix;

/* Finds the places of the values of a coupling in the matrix. */
static PetscErrorCode find_place(const TermMatrix *to, PetscInt n, const PetscInt *vertices,
                                 StiffnessPlace *p)
{
  const PetscInt *start, *columns;
  PetscInt n_rows;
  PetscBool done;
  PetscFunctionBeginUser;
  PetscCall(MatGetRowIJ(to->matrix, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &start, &columns, &done));
  PetscCheck(done, PETSC_COMM_SELF, PETSC_ERR_LIB, "no rows of the tangent");
  p->n = n;
  PetscCall(PetscArraycpy(p->vertices, vertices, n));
  for (PetscInt i = 0; i < 4 * n * n; i++) {
    const PetscInt a = i / (2 * n), b = i % (2 * n), row = to->s->row[3 * vertices[a / 2] + a % 2],
                   column = to->s->row[3 * vertices[b / 2] + b % 2];
    p->at[i] = -1;
    if (row < 0 || column < 0) continue;
    PetscCall(PetscFindInt(column, start[row + 1] - start[row], columns + start[row], p->at + i));
    PetscCheck(p->at[i] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "a coupling that the pattern lacks");
    p->at[i] += start[row];
  }
  PetscCall(MatRestoreRowIJ(to->matrix, 0, PETSC_FALSE, PETSC_FALSE, &n_rows, &start, &columns, &done));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the same values as StiffnessAdd, in its order, without the search for rows. Where all bodies are
   condensed, that search took a third of the time of a sample that fails. */
static PetscErrorCode add_in_place(TermMatrix *to, PetscInt n, const PetscInt *vertices, const PetscReal *k)
{
  Stiffness *s = to->places;
  PetscBool same = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (to->next == s->n_places) {
    const PetscInt room = 2 * s->n_places + 64;
    PetscCall(PetscRealloc(sizeof(*s->places) * room, &s->places));
    PetscCall(PetscArrayzero(s->places + s->n_places, room - s->n_places));
    s->n_places = room;
  }
  StiffnessPlace *p = s->places + to->next++;
  if (p->n == n) PetscCall(PetscArraycmp(p->vertices, vertices, n, &same));
  if (!same) PetscCall(find_place(to, n, vertices, p));
  for (PetscInt i = 0; i < 4 * n * n; i++)
    if (p->at[i] >= 0) to->values[p->at[i]] += k[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stiffness k of a coupling, and the effect of forces that it carries on a rigid body. A force F
   at an arm r from the centre has the moment r x F; a rotation turns r, which changes the moment by -r.F. */
static PetscErrorCode add_of_term(PetscInt n, const PetscInt *vertices, const PetscReal *k,
                                  const PetscReal *carried, void *context)
{
  TermMatrix *to = context;
  PetscFunctionBeginUser;
  if (to->places && n <= MOST) { // no body is rigid, so there is no moment
    PetscCall(add_in_place(to, n, vertices, k));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(StiffnessAdd(to->m, to->s, to->matrix, n, vertices, k));
  for (PetscInt i = 0; i < n && carried; i++) {
    const PetscReal *arm = to->s->arm + 2 * vertices[i];
    const PetscInt row = to->s->row[3 * vertices[i] + 2];
    PetscCall(MatSetValue(to->matrix, row, row, -carried[2 * i] * arm[0] - carried[2 * i + 1] * arm[1],
                          ADD_VALUES));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a diagonal of about the size of the others where a degree of freedom is held. */
static PetscErrorCode add_held(const Model *m, const Stiffness *s, Mat matrix)
{
  PetscReal stiffest = 1.;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups; g++)
    if (!m->materials.rigid[g])
      stiffest = PetscMax(stiffest, m->materials.lame[g].mu * m->materials.thickness);
  for (PetscInt d = 0; d < m->n_dof; d++)
    PetscCall(MatSetValue(matrix, s->first + d, s->first + d, Held(m, d) ? stiffest : 0., ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessBodies(const Model *m, const State *state, PetscBool turned, Stiffness *s)
{
  const Instant at = {.m = m, .u = state->u + 3 * m->rigid.n};
  const TangentKind kind = turned ? TANGENT_TURNED : TANGENT_ELASTIC;
  TermMatrix to = {.m = m, .s = s, .matrix = s->bodies};
  PetscFunctionBeginUser;
  s->turned = turned;
  if (s->fixed && s->made) PetscFunctionReturn(PETSC_SUCCESS);
  s->made = PETSC_TRUE;
  PetscCall(set_arms(m, turned && m->materials.strain == STRAIN_LARGE ? state->u : NULL, s));
  PetscCall(MatZeroEntries(s->bodies));
  PetscCall(add_held(m, s, s->bodies));
  PetscCall(TermsTangent(PHASE_BLOCKS, state, &at, kind, add_of_term, &to));
  PetscCall(TermsTangent(PHASE_BODIES, state, &at, kind, add_of_term, &to));
  PetscCall(MatAssemblyBegin(s->bodies, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->bodies, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessTangent(const Model *m, const State *state, const Joint *joints, Contacts *contacts,
                                PetscBool elastic, Stiffness *s)
{
  const Instant at = {.m = m, .joints = joints, .contacts = contacts, .u = state->u + 3 * m->rigid.n};
  const TangentKind kind = elastic     ? TANGENT_ELASTIC
                           : s->small  ? TANGENT_SMALL
                           : s->turned ? TANGENT_TURNED
                                       : TANGENT_NOW;
  TermMatrix to = {.m = m, .s = s, .matrix = s->tangent, .places = s->fixed && m->size == 1 ? s : NULL};
  PetscFunctionBeginUser;
  PetscCall(MatCopy(s->bodies, s->tangent, SAME_NONZERO_PATTERN));
  if (to.places) PetscCall(MatSeqAIJGetArray(s->tangent, &to.values));
  PetscCall(TermsTangent(PHASE_JOINTS, state, &at, kind, add_of_term, &to));
  if (to.places) PetscCall(MatSeqAIJRestoreArray(s->tangent, &to.values));
  PetscCall(MatAssemblyBegin(s->tangent, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->tangent, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life */

/* Collective. Finds whether all blocks of all ranks are within condensed bodies. */
static PetscErrorCode all_condensed(const Model *m, PetscBool *all)
{
  PetscBool mine = (PetscBool)!m->mesh.n_rigid_global;
  PetscFunctionBeginUser;
  for (const Elements *e = m->mesh.elements; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    mine = (PetscBool)(mine && !e->n);
  PetscCallMPI(MPI_Allreduce(&mine, all, 1, MPI_PETSC_BOOL, MPI_LAND, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessRows(const Model *m, Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  s->n_vertices = m->mesh.n_vertices;
  PetscCallMPI(MPI_Exscan(&m->n_dof, &s->first, 1, MPIU_INT, MPI_SUM, m->comm));
  if (m->rank == 0) s->first = 0;
  PetscCall(PetscMalloc2(3 * (m->mesh.n_vertices + DUMMY_VERTICES), &s->row,
                         2 * (m->mesh.n_vertices + DUMMY_VERTICES), &s->arm));
  PetscCall(number_rows(m, s));
  PetscCall(set_arms(m, NULL, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessCreate(const Model *m, const State *state, Contacts *contacts, Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(StiffnessRows(m, s));
  PetscCall(all_condensed(m, &s->fixed));
  PetscCall(MatCreate(m->comm, &s->bodies));
  PetscCall(MatSetSizes(s->bodies, m->n_dof, m->n_dof, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(s->bodies, MATAIJ));
  PetscCall(StiffnessPattern(m, state, contacts, s, s->bodies));
  PetscCall(MatDuplicate(s->bodies, MAT_DO_NOT_COPY_VALUES, &s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessDestroy(Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(s->row, s->arm));
  PetscCall(PetscFree(s->places));
  PetscCall(MatDestroy(&s->bodies));
  PetscCall(MatDestroy(&s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

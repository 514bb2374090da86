/* stiffness.c: the assembled stiffness of blocks and joints, a matrix of PETSc's.

   Blocks: that of the reference state in small strain (element.c: ElementMatrices), also when strain is
   large: rotations and strains of a dam are 1e-3 of one and less, and so is the error. Condensed bodies:
   their Schur complement on the vertices they keep.

   Joints: with b = (P: 1, A: -(1-t), B: -t) an end opens by u_n = n.(b u) and slides by u_s = s.(b u); the
   stiffness is B' D B with D = d(F_n0, F_n1, F_s0, F_s1)/d(u_n0, u_n1, u_s0, u_s1), 4 by 4, of the stress
   model. D is unsymmetric where a joint slips by friction. D comes by differences of the stress model, so
   that no model brings a tangent of its own. At a kink (a place that is just about to slip or to open) the
   step goes where the joint gives way: on with the slip, and open.

   That bodies and faces turn under the forces they carry is a part u/L of the stiffness, and left out, but
   for a mechanism, which has no other: then blocks are those of large strain at u, and joints have

     d2 u_n = -(s.dd) a' - (s.dd') a - d_n a a' - d_s a'',
     d2 u_s =  (n.dd) a' + (n.dd') a - d_s a a' + d_n a''

   times F_n and F_s, and B with

     du_n = n.dd - d_s a,   du_s = s.dd + d_n a;
     d = P - (1-t) A - t B,   e = B - A,
     a = n.de/|e|  (by which n and s turn),   a'' = -((s.de)(n.de') + (n.de)(s.de'))/|e|^2.

   Rigid bodies: a vertex moves with the centre by T = [1 0 -r_y; 0 1 r_x], the stiffness is T' k T. */
#include "solve/stiffness.h"

enum { MOST = 6 }; /* vertices of a contact; an element has four */

/* ---- rows */

/* Arms of vertices of rigid bodies at displacements u, NULL: undeformed. An exchange
   tells ghosts the centre. */
static PetscErrorCode set_arms(const Model *m, const PetscReal *u, Stiffness *s)
{
  PetscReal *arm = s->arm;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(arm, 2 * (m->n_vertices + DUMMY_VERTICES)));
  for (PetscInt v = m->n_deformable; v < m->n_moving; v++)
    for (int x = 0; x < 2; x++) {
      const PetscInt body = RigidOfVertex(m, v);
      arm[2 * v + x] = m->body_X[2 * body + x] + (u ? u[3 * body + x] : 0.);
    }
  PetscCall(GhostBegin(m, arm));
  PetscCall(GhostEnd(m, arm));
  for (PetscInt i = 0; i < 2 * m->n_vertices; i++)
    arm[i] = m->vertex_rigid[i / 2] < 0 ? 0. : m->X[i] + (u ? u[3 * m->n_bodies + i] : 0.) - arm[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two exchanges of pairs of numbers (exact as reals) tell ghosts their rows. */
static PetscErrorCode number_rows(const Model *m, Stiffness *s)
{
  const PetscInt at = 3 * m->n_bodies, n = m->n_vertices + DUMMY_VERTICES;
  PetscReal *pair;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n, &pair));
  for (PetscInt i = 0; i < 3 * n; i++) s->row[i] = -1;
  for (PetscInt v = 0; v < m->n_moving; v++) { // inner vertices of condensed bodies have none
    const PetscInt body = v < m->n_deformable ? -1 : RigidOfVertex(m, v),
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
    for (PetscInt v = m->n_owned; v < m->n_vertices; v++) {
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
        if (v >= m->n_vertices || m->vertex_rigid[v] < 0) continue;
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

/* ---- blocks */

static PetscErrorCode add_elements(const Model *m, const Elements *e, const PetscReal *u_vertex,
                                   const Stiffness *s, Mat matrix)
{
  PetscReal k[4][64];
  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < e->n; first += 4) {
    ElementMatrices(m, e, e->n_nodes, first, u_vertex, k);
    for (PetscInt i = first; i < PetscMin(first + 4, e->n); i++) {
      PetscInt vertices[4];
      if (!e->owned[i]) continue; // another rank adds it
      for (int v = 0; v < e->n_nodes; v++) vertices[v] = VertexOf(e, i, v);
      PetscCall(StiffnessAdd(m, s, matrix, e->n_nodes, vertices, k[i - first]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where a force term puts its stiffness. */
typedef struct {
  const Model *m;
  const Stiffness *s;
  Mat matrix;
} TermMatrix;

static PetscErrorCode add_of_term(PetscInt n, const PetscInt *vertices, const PetscReal *k, void *context)
{
  const TermMatrix *to = context;
  PetscFunctionBeginUser;
  PetscCall(StiffnessAdd(to->m, to->s, to->matrix, n, vertices, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks and force terms, and a diagonal of about their size where a dof is held. */
static PetscErrorCode add_bodies(const Model *m, const State *state, const PetscReal *u_vertex,
                                 const Stiffness *s, Mat matrix)
{
  PetscReal stiffest = 1.;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->n_groups; g++)
    if (!m->group_rigid[g]) stiffest = PetscMax(stiffest, m->lame[g].mu * m->thickness);
  for (PetscInt d = 0; d < m->n_dof; d++)
    PetscCall(MatSetValue(matrix, s->first + d, s->first + d, Held(m, d) ? stiffest : 0., ADD_VALUES));
  PetscCall(add_elements(m, &m->q4, u_vertex, s, matrix));
  PetscCall(add_elements(m, &m->t3, u_vertex, s, matrix));
  PetscCall(TermsTangent(m, state, u_vertex, add_of_term, &(TermMatrix){m, s, matrix}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessBodies(const Model *m, const State *state, PetscBool now, Stiffness *s)
{
  const PetscReal *u = now ? state->u : NULL;
  PetscFunctionBeginUser;
  s->turns = (PetscBool)(u != NULL);
  PetscCall(set_arms(m, m->strain == STRAIN_LARGE ? u : NULL, s));
  PetscCall(MatZeroEntries(s->bodies));
  PetscCall(add_bodies(m, state, u && m->strain == STRAIN_LARGE ? u + 3 * m->n_bodies : NULL, s, s->bodies));
  PetscCall(MatAssemblyBegin(s->bodies, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->bodies, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- joints */

void StiffnessJointsElastic(const Joint *joints, const Contacts *c, Stiffness *s)
{
  for (int model = 0; model < STRESS_MODELS; model++) {
    PetscReal a, b;
    StressModelElastic((StressModelKind)model, &a, &b);
    for (PetscInt i = c->model_start[model]; i < c->model_start[model + 1]; i++) {
      const Joint *j = joints + c->joint[i];
      PetscReal *D = s->joint + 16 * i;
      for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++)
          D[4 * row + column] = row / 2 != column / 2
                                    ? 0.
                                    : (row / 2 ? j->k_s : j->k_n) * c->length[i] * (row == column ? a : b);
    }
  }
}

/* Differences of the end forces of contact i, one column of D for each of u_n0, u_n1, u_s0, u_s1. */
static void joint_tangent(const Joint *joint, StressModelKind model, const Contacts *c, PetscInt i,
                          PetscReal D[16])
{
  ContactPoint base = {.in_time = (PetscBool)(c->rate != 0. || c->springs)}, p;
  PetscReal size = 0.;
  for (int k = 0; k < 2; k++) {
    const PetscInt at = SUB(i, k);
    base.u_n[k] = c->u_n[at], base.u_s[k] = c->u_s[at];
    base.slip[k] = c->slip_0[at], base.broken[k] = c->broken_0[at];
    base.closure[k] = c->closure_0[at], base.closure_far[k] = c->closure_far_0[at];
    size = PetscMax(size, PetscMax(PetscAbsReal(c->u_n[at]), PetscAbsReal(c->u_s[at] - c->slip_0[at])));
  }
  const PetscReal step = PetscMax(1e-7 * size, 1e-18);
  p = base;
  StressModelRespond(model, joint, c->length[i], &p);
  for (int column = 0; column < 4; column++) {
    const int end = column % 2;
    ContactPoint q = base;
    const PetscReal h = column / 2 && p.tau[end] < 0. ? -step : step;
    if (column / 2)
      q.u_s[end] += h;
    else
      q.u_n[end] += h;
    StressModelRespond(model, joint, c->length[i], &q);
    for (int row = 0; row < 4; row++)
      D[4 * row + column] = row / 2 ? (q.F_s[row % 2] - p.F_s[row % 2]) / h : (q.F_n[row] - p.F_n[row]) / h;
  }
}

void StiffnessJoints(const Joint *joints, const Contacts *c, Stiffness *s)
{
  StiffnessJointsElastic(joints, c, s);
  for (int model = 0; model < STRESS_MODELS; model++)
    for (PetscInt i = c->model_start[model]; i < c->model_start[model + 1]; i++) {
      const Joint *joint = joints + c->joint[i];
      PetscReal sigma[2], tau[2], was[2], closure[2];
      for (int k = 0; k < 2; k++) {
        const PetscInt at = SUB(i, k);
        sigma[k] = joint->k_n * c->u_n[at], tau[k] = joint->k_s * (c->u_s[at] - c->slip_0[at]);
        was[k] = c->broken_0[at], closure[k] = c->closure_0[at];
      }
      if (c->key[2 * i] < 0 || JointIsElastic(joint, sigma, tau, was, closure)) continue;
      joint_tangent(joint, (StressModelKind)model, c, i, s->joint + 16 * i);
    }
}

/* What comes of the turning of the destination edge of one end (head of this file): to its rows of B, n.dd
   and s.dd so far, and to k, 6 by 6 on P A B in rows of 2 MOST. inverse: 1/|e|. */
static void add_turning(const Model *m, const Contacts *c, PetscInt at, const PetscReal n[2],
                        const PetscReal s[2], PetscReal inverse, PetscReal B_n[6], PetscReal B_s[6],
                        PetscReal *k)
{
  const PetscReal d_n = c->u_n[at] + c->rest[at], d_s = c->u_s[at], F_n = m->thickness * c->F_n[at],
                  F_s = m->thickness * c->F_s[at];
  PetscReal a[6] = {0.}, stretch[6] = {0.}; // n.de/|e|, s.de/|e|
  for (int x = 0; x < 2; x++) {
    a[2 + x] = -n[x] * inverse, a[4 + x] = n[x] * inverse;
    stretch[2 + x] = -s[x] * inverse, stretch[4 + x] = s[x] * inverse;
  }
  for (int p = 0; p < 6; p++)
    for (int q = 0; q < 6; q++) {
      const PetscReal aa = a[p] * a[q], twist = -(stretch[p] * a[q] + a[p] * stretch[q]);
      k[2 * MOST * p + q] += F_n * (-B_s[p] * a[q] - B_s[q] * a[p] - d_n * aa - d_s * twist) +
                             F_s * (B_n[p] * a[q] + B_n[q] * a[p] - d_s * aa + d_n * twist);
    }
  for (int p = 0; p < 6; p++) B_n[p] -= d_s * a[p], B_s[p] += d_n * a[p];
}

/* B' D B of contact i: 12 by 12 on its six vertices P0 A0 B0 P1 A1 B1; force: on them [N]. */
static void contact_stiffness(const Model *m, const Contacts *c, PetscInt i, const PetscReal *u_vertex,
                              PetscBool turns, const PetscReal D[16], PetscInt vertices[MOST],
                              PetscReal force[2 * MOST], PetscReal k[4 * MOST * MOST])
{
  const PetscReal moving = m->strain == STRAIN_LARGE ? 1. : 0.;
  PetscReal B[4][2 * MOST] = {{0.}}; // rows u_n0, u_n1, u_s0, u_s1
  PetscArrayzero(k, 4 * MOST * MOST);
  for (int e = 0; e < 2; e++) {
    PetscInt *v = vertices + 3 * e;
    ContactEndVertices(c, i, e, v);
    if (v[0] == v[1]) continue;        // nothing at the other end of a vertex on a face
    const PetscInt P = v[1], Q = v[2]; // of the destination edge
    const PetscReal t = c->t[SUB(i, e)], b[3] = {1., -(1. - t), -t};
    PetscReal d[2];
    for (int x = 0; x < 2; x++)
      d[x] = m->X[2 * Q + x] - m->X[2 * P + x] + moving * (u_vertex[2 * Q + x] - u_vertex[2 * P + x]);
    const PetscReal inverse = 1. / PetscHypotReal(d[0], d[1]), along[2] = {d[0] * inverse, d[1] * inverse},
                    normal[2] = {along[1], -along[0]};
    for (int a = 0; a < 3; a++)
      for (int x = 0; x < 2; x++) {
        B[e][2 * (3 * e + a) + x] = b[a] * normal[x];
        B[2 + e][2 * (3 * e + a) + x] = b[a] * along[x];
      }
    if (turns)
      add_turning(m, c, SUB(i, e), normal, along, inverse, B[e] + 6 * e, B[2 + e] + 6 * e,
                  k + 6 * e * (2 * MOST + 1));
  }
  for (int p = 0; p < 2 * MOST; p++) {
    force[p] = 0.;
    for (int e = 0; e < 2; e++)
      force[p] += m->thickness * (B[e][p] * c->F_n[SUB(i, e)] + B[2 + e][p] * c->F_s[SUB(i, e)]);
    for (int q = 0; q < 2 * MOST; q++) {
      PetscReal sum = 0.;
      for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) sum += B[row][p] * D[4 * row + column] * B[column][q];
      k[2 * MOST * p + q] += m->thickness * sum;
    }
  }
}

static PetscErrorCode add_joints(const Model *m, const Contacts *c, const PetscReal *u_vertex,
                                 const Stiffness *s, Mat matrix)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    PetscInt vertices[MOST];
    PetscReal force[2 * MOST], k[4 * MOST * MOST];
    if (c->key[2 * i] < 0 || !c->owned[i]) continue; // padding; another rank adds it
    contact_stiffness(m, c, i, u_vertex, (PetscBool)(s->turns && m->strain == STRAIN_LARGE),
                      s->joint + 16 * i, vertices, force, k);
    PetscCall(StiffnessAdd(m, s, matrix, MOST, vertices, k));
    for (int a = 0; a < MOST && s->turns && m->strain == STRAIN_LARGE;
         a++) { // arms of rigid bodies turn, too
      const PetscReal *arm = s->arm + 2 * vertices[a];
      const PetscInt row = s->row[3 * vertices[a] + 2];
      PetscCall(
          MatSetValue(matrix, row, row, -force[2 * a] * arm[0] - force[2 * a + 1] * arm[1], ADD_VALUES));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessTangent(const Model *m, const Contacts *c, const PetscReal *u, Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(MatCopy(s->bodies, s->tangent, SAME_NONZERO_PATTERN));
  PetscCall(add_joints(m, c, u + 3 * m->n_bodies, s, s->tangent));
  PetscCall(MatAssemblyBegin(s->tangent, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->tangent, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life */

PetscErrorCode StiffnessCreate(const Model *m, const State *state, const Contacts *c, Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  s->n_vertices = m->n_vertices;
  PetscCallMPI(MPI_Exscan(&m->n_dof, &s->first, 1, MPIU_INT, MPI_SUM, m->comm));
  if (m->rank == 0) s->first = 0;
  PetscCall(PetscMalloc3(3 * (m->n_vertices + DUMMY_VERTICES), &s->row, 2 * (m->n_vertices + DUMMY_VERTICES),
                         &s->arm, 16 * c->n_padded, &s->joint));
  PetscCall(PetscArrayzero(s->joint, 16 * c->n_padded));
  PetscCall(number_rows(m, s));
  PetscCall(set_arms(m, NULL, s));
  PetscCall(MatCreate(m->comm, &s->bodies));
  PetscCall(MatSetSizes(s->bodies, m->n_dof, m->n_dof, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(s->bodies, MATAIJ));
  PetscCall(StiffnessPattern(m, state, c, s, s->bodies));
  PetscCall(MatDuplicate(s->bodies, MAT_DO_NOT_COPY_VALUES, &s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessDestroy(Stiffness *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(s->row, s->arm, s->joint));
  PetscCall(MatDestroy(&s->bodies));
  PetscCall(MatDestroy(&s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

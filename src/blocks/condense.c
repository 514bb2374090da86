/* condense.c: reduces the stiffness of condensed bodies to their kept vertices. An elastic body in small
   strain acts on the rest only through these: those at contacts, other blocks and named points. With kept
   degrees of freedom B and inner ones I (without those held by supports), its equilibrium is

     [ K_BB  K_BI ] [ u_B ]   [ f_B ]
     [ K_IB  K_II ] [ u_I ] = [ f_I ].

   The second row gives

     u_I = K_II^-1 (f_I - K_IB u_B)                                                                     (a)

   and the first row with (a)

     S u_B = f_B - g,   S = K_BB - K_BI K_II^-1 K_IB,   g = K_BI K_II^-1 f_I.                           (b)

   Nothing is approximated. A cycle adds the resisting force S u_B in place of the forces of the blocks.
   The applied force is f_B - g. (a) recovers the inside when results are wanted. S has the rigid motions of
   K, so a body that can float still can. K_II is regular when kept vertices and supports stop the body.

   MUMPS eliminates I from K and leaves S. One factorisation per body serves the whole run, because strengths
   and loads of stages and trials are not in K. A body belongs to one rank, and its K is summed in ascending
   order of its blocks, so bits do not depend on the number of ranks. The products K_IB u_B and K_BI w come
   from the blocks: they are the forces of the blocks for u_B alone, or for w alone.

   Time step: omega^2 of M^-1 S is at most the largest row sum of |S| over the mass (Gershgorin), as in (28)
   for blocks, and row sums of body and contacts add. S is symmetric and has no negative eigenvalue, because K
   has none, so this bound suffices for stability. */
#include "blocks/blocks.h"
#include "base/memory.h"
#include <petscksp.h>

/* ---- the bodies of this rank */

/* Lists the degrees of freedom of the owned vertices in [from, to) that belong to body `number`.
   free_only: without those that a support holds. */
static PetscErrorCode body_dofs(const Model *m, PetscInt number, PetscInt from, PetscInt to,
                                PetscBool free_only, PetscInt *n, PetscInt **dofs)
{
  PetscFunctionBeginUser;
  *n = 0;
  for (PetscInt v = from; v < to; v++) *n += 2 * (m->mesh.vertex_condensed[v] == number);
  PetscCall(PetscMalloc1(*n, dofs));
  *n = 0;
  for (PetscInt d = 2 * from; d < 2 * to; d++)
    if (m->mesh.vertex_condensed[d / 2] == number && !(free_only && Held(m, 3 * m->rigid.n + d)))
      (*dofs)[(*n)++] = d;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the bodies of this rank by number. local: (n_condensed_global,) row here of each body, -1: none. */
static PetscErrorCode find_bodies(Model *m, PetscInt *local)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < m->mesh.n_condensed_global; i++) local[i] = -1;
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    if (m->mesh.vertex_condensed[v] >= 0) local[m->mesh.vertex_condensed[v]] = 0;
  for (PetscInt i = 0; i < m->mesh.n_condensed_global; i++)
    if (!local[i]) local[i] = m->condensed.n++;
  PetscCall(PetscCalloc1(m->condensed.n, &m->condensed.body));
  for (PetscInt i = 0; i < m->mesh.n_condensed_global; i++) {
    if (local[i] < 0) continue;
    Condensed *c = m->condensed.body + local[i];
    c->number = i;
    PetscCall(body_dofs(m, i, 0, m->mesh.n_moving, PETSC_FALSE, &c->n_kept, &c->kept));
    PetscCall(body_dofs(m, i, m->mesh.n_moving, m->mesh.n_owned, PETSC_TRUE, &c->n_inner, &c->inner));
    c->stride = (c->n_kept + BATCH - 1) / BATCH * BATCH;
    PetscCall(PetscCalloc7(c->stride * c->stride, &c->S, c->stride, &c->u, c->stride, &c->f, c->n_inner,
                           &c->load, c->n_kept, &c->g, c->n_kept, &c->given, c->n_kept, &c->given_before));
    if (m->condensed.large) PetscCall(PetscCalloc1(c->n_kept, &c->corrects));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a body whose inside could move alone: K_II would be singular. Two kept vertices prevent this, or
   a support inside. */
static PetscErrorCode check_held(const Scene *scene, const Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < m->condensed.n && !message[0]; i++) {
    const Condensed *c = m->condensed.body + i;
    PetscInt n_inner = 0, v = m->mesh.n_moving;
    for (; v < m->mesh.n_owned; v++) n_inner += 2 * (m->mesh.vertex_condensed[v] == c->number);
    if (c->n_kept >= 4 || n_inner > c->n_inner) continue;
    for (v = 0; m->mesh.vertex_condensed[v] != c->number;) v++;
    PetscCall(PetscSNPrintf(
        message, MESSAGE_LENGTH,
        "%s: materials: a condensed body at x = %.6g m, y = %.6g m touches nothing and is not held: "
        "its group cannot be condensed",
        scene->file, (double)m->mesh.X[2 * v], (double)m->mesh.X[2 * v + 1]));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stiffness and factor */

/* Refuses the bodies for lack of memory, or only notes it where the program chose them. asked: the check
   before any allocation has failed; otherwise MUMPS has run out of memory. */
static PetscErrorCode refuse_memory(Model *m, PetscBool asked, const double memory[2])
{
  char message[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  m->condensed.lacks = m->condensed.chosen;
  if (m->condensed.lacks) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                          "%s %" PetscInt_FMT " condensed bod%s%s about %.3g GB of memory, %.3g GB %s: leave "
                          "`condensed` out of some groups, or take more machines",
                          asked ? "the factors of" : "MUMPS has no memory left for the factors of",
                          m->mesh.n_condensed_global, m->mesh.n_condensed_global == 1 ? "y" : "ies",
                          asked ? " take" : ", which were to take", 1e-9 * memory[0], 1e-9 * memory[1],
                          asked ? "are available" : "were available before"));
  PetscCall(Refuse(m->comm, ERROR_MEMORY, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses factors without enough memory, before any of it is allocated. */
static PetscErrorCode check_memory(Model *m, double memory[2])
{
  double mine = 0.;
  PetscBool fits;
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->condensed.n; b++)
    mine += MemoryOfBody((double)m->condensed.body[b].n_inner, (double)m->condensed.body[b].n_kept);
  PetscCall(MemoryFits(m->comm, mine, memory, &fits));
  if (!fits) PetscCall(refuse_memory(m, PETSC_TRUE, memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix K of each body. A row has at most its vertex's two dofs and those of its blocks. */
static PetscErrorCode create_matrices(const Model *m, const PetscInt *local, const PetscInt *row, Mat *K)
{
  PetscInt *width, *nnz;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(m->mesh.n_owned, &width, 2 * m->mesh.n_owned, &nnz));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) width[v] = 2;
  for (const Elements *list = m->mesh.elements + MOVING_LISTS; list < m->mesh.elements + ELEMENT_LISTS;
       list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt k = 0; k < list->n_nodes; k++) width[VertexOf(list, e, k)] += 2 * (list->n_nodes - 1);
  for (PetscInt i = 0; i < m->condensed.n; i++) {
    const Condensed *c = m->condensed.body + i;
    const PetscInt n = c->n_inner + c->n_kept;
    for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++)
      if (row[d] >= 0 && local[m->mesh.vertex_condensed[d / 2]] == i) nnz[row[d]] = PetscMin(n, width[d / 2]);
    PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 0, nnz, K + i));
    PetscCall(MatSetOption(K[i], MAT_SPD, PETSC_TRUE)); // K_II is, and only K_II is eliminated
  }
  PetscCall(PetscFree2(width, nnz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums the stiffness of all blocks, in ascending order, into the K of their bodies. */
static PetscErrorCode sum_stiffness(const Model *m, const PetscInt *local, const PetscInt *row, Mat *K)
{
  PetscFunctionBeginUser;
  for (const Elements *list = m->mesh.elements + MOVING_LISTS; list < m->mesh.elements + ELEMENT_LISTS;
       list++)
    for (PetscInt e = 0, n_nodes = list->n_nodes; e < list->n; e++) {
      PetscReal K_e[4][64];
      PetscInt rows[8];
      if (e % 4 == 0) ElementMatrices(m, list, list->n_nodes, e, NULL, K_e);
      for (PetscInt k = 0; k < 2 * n_nodes; k++) rows[k] = row[2 * VertexOf(list, e, k / 2) + k % 2];
      PetscCall(MatSetValues(K[local[m->mesh.vertex_condensed[VertexOf(list, e, 0)]]], 2 * n_nodes, rows,
                             2 * n_nodes, rows, K_e[e % 4], ADD_VALUES));
    }
  for (PetscInt i = 0; i < m->condensed.n; i++) {
    PetscCall(MatAssemblyBegin(K[i], MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(K[i], MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factors K as c->factor. more: [%] additional work space over the estimate of MUMPS, 0: default. wants
   receives whether MUMPS has too little memory. */
static PetscErrorCode factorise(Mat K, PetscInt more, Condensed *c, MatFactorError *error, PetscBool *wants)
{
  IS kept;
  MatFactorInfo info;
  PetscFunctionBeginUser;
  PetscCall(MatGetFactor(K, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &c->factor));
  PetscCall(ISCreateStride(PETSC_COMM_SELF, c->n_kept, c->n_inner, 1, &kept));
  if (c->n_kept) PetscCall(MatFactorSetSchurIS(c->factor, kept));
  PetscCall(ISDestroy(&kept));
  if (more) PetscCall(MatMumpsSetIcntl(c->factor, 14, more));
  PetscCall(MatFactorInfoInitialize(&info));
  PetscCall(MatCholeskyFactorSymbolic(c->factor, K, NULL, &info));
  PetscCall(MatCholeskyFactorNumeric(c->factor, K, &info));
  PetscCall(MatFactorGetError(c->factor, error));
  PetscCall(MumpsWants(c->factor, wants));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Eliminates the inner rows of K: makes c->factor, and S of the rest. wants receives whether MUMPS has too
   little memory. If a body has few inner rows, the estimate of MUMPS is too small for S. */
static PetscErrorCode eliminate(Mat K, Condensed *c, Mat *S, PetscBool *wants)
{
  MatFactorError error;
  PetscFunctionBeginUser;
  if (!c->n_inner) {
    PetscCall(MatConvert(K, MATSEQDENSE, MAT_INITIAL_MATRIX, S));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(factorise(K, 0, c, &error, wants));
  for (PetscInt more = 100; *wants && more <= 10000; more *= 10) {
    PetscCall(MatDestroy(&c->factor));
    PetscCall(factorise(K, more, c, &error, wants));
  }
  if (*wants) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(error == MAT_FACTOR_NOERROR, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "MUMPS cannot factor the stiffness of a condensed body with %" PetscInt_FMT
             " inner dofs: error %d",
             c->n_inner, (int)error);
  PetscCall(MatMumpsSetIcntl(c->factor, 26, 0)); // solves are with K_II alone
  if (c->n_kept) PetscCall(MatFactorCreateSchurComplement(c->factor, S, NULL));
  PetscCall(MatCreateVecs(K, &c->x, &c->b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the lower triangle of S into both. MUMPS fills only one triangle, or both with different
   rounding. */
static PetscErrorCode store_schur(Mat S, Condensed *c)
{
  const PetscScalar *s;
  PetscInt lda;
  PetscFunctionBeginUser;
  PetscCall(MatDenseGetLDA(S, &lda));
  PetscCall(MatDenseGetArrayRead(S, &s));
  for (PetscInt j = 0; j < c->n_kept; j++)
    for (PetscInt i = j; i < c->n_kept; i++)
      c->S[i * c->stride + j] = c->S[j * c->stride + i] = s[i + j * lda];
  PetscCall(MatDenseRestoreArrayRead(S, &s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode factor_bodies(const Scene *scene, Model *m, const PetscInt *local,
                                    const double memory[2])
{
  PetscBool wants = PETSC_FALSE, any;
  PetscInt *row;
  Mat *K, S = NULL;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(2 * m->mesh.n_owned, &row, m->condensed.n, &K));
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++) row[d] = -1;
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    for (PetscInt i = 0; i < c->n_inner; i++) row[c->inner[i]] = i;
    for (PetscInt i = 0; i < c->n_kept; i++) row[c->kept[i]] = c->n_inner + i;
  }
  PetscCall(create_matrices(m, local, row, K));
  PetscCall(sum_stiffness(m, local, row, K));
  for (PetscInt b = 0; b < m->condensed.n; b++) {
    if (!wants) PetscCall(eliminate(K[b], m->condensed.body + b, &S, &wants));
    if (S) PetscCall(store_schur(S, m->condensed.body + b));
    if (!wants && SceneVibrates(scene))
      PetscCall(CondensedModes(scene, m, K[b], m->condensed.body + b, &wants));
    PetscCall(MatDestroy(&S));
    PetscCall(MatDestroy(K + b));
  }
  PetscCall(PetscFree2(row, K));
  PetscCallMPI(MPI_Allreduce(&wants, &any, 1, MPI_PETSC_BOOL, MPI_LOR, m->comm));
  if (any) PetscCall(refuse_memory(m, PETSC_FALSE, memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedCreate(const Scene *scene, Model *m)
{
  const double start = MPI_Wtime(), worked = ProcessorSeconds();
  double memory[2];
  CondensedBodies *bodies = &m->condensed;
  PetscInt *local;
  PetscFunctionBeginUser;
  if (!m->mesh.n_condensed_global) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(m->mesh.n_condensed_global, &local));
  PetscCall(find_bodies(m, local));
  PetscCall(check_held(scene, m));
  PetscCall(check_memory(m, memory));
  if (!bodies->lacks) PetscCall(factor_bodies(scene, m, local, memory));
  if (SceneVibrates(scene)) PetscCall(CondensedModesNumber(scene, m));
  PetscCall(PetscFree(local));
  for (PetscInt b = 0; b < bodies->n; b++) {
    bodies->dofs[0] += bodies->body[b].n_kept;
    bodies->dofs[1] += bodies->body[b].n_inner;
  }
  bodies->wall = MPI_Wtime() - start;
  bodies->processor = ProcessorSeconds() - worked;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bodies->dofs, 2, MPIU_INT, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bodies->wall, 1, MPI_DOUBLE, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bodies->processor, 1, MPI_DOUBLE, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedDestroy(Model *m)
{
  PetscFunctionBeginUser;
  for (Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    PetscCall(PetscFree(c->kept));
    PetscCall(PetscFree(c->inner));
    PetscCall(PetscFree7(c->S, c->u, c->f, c->load, c->g, c->given, c->given_before));
    PetscCall(PetscFree(c->turn));
    PetscCall(PetscFree(c->corrects));
    PetscCall(CondensedRowsDestroy(c));
    PetscCall(CondensedModesDestroy(c));
    PetscCall(MatDestroy(&c->factor));
    PetscCall(VecDestroy(&c->x));
    PetscCall(VecDestroy(&c->b));
  }
  PetscCall(PetscFree(m->condensed.body));
  PetscCall(PetscFree(m->condensed.mode_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- every cycle */

void CondensedAddForces(const Model *m, const PetscReal *u, PetscReal *f)
{
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = u[c->kept[i]];
    DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
    for (PetscInt i = 0; i < c->n_kept; i++) f[c->kept[i]] += c->f[i];
    for (PetscInt i = 0; i < c->n_kept && c->corrects; i++) f[c->kept[i]] += c->corrects[i];
  }
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)memory; // the bodies are in the model
  for (const Condensed *c = at->m->condensed.body; c < at->m->condensed.body + at->m->condensed.n; c++) {
    CondensedForces(c, at->u, c->given);
    for (PetscInt i = 0; i < c->n_kept; i++) f[c->kept[i]] += c->given[i];
    for (PetscInt i = 0; i < c->n_kept && c->corrects; i++) f[c->kept[i]] += c->corrects[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode bound(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  const Model *m = at->m;
  PetscFunctionBeginUser;
  (void)memory, (void)anywhere;
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    if (c->rows) continue;                        // dynamic stage: CondensedBound
    for (PetscInt i = 0; i < c->n_kept; i += 2) { // x and y of one vertex
      PetscReal row[2] = {0., 0.};
      for (PetscInt j = 0; j < 2 * c->stride; j++)
        row[j / c->stride] += PetscAbsReal(c->S[i * c->stride + j]);
      k[c->kept[i] / 2] += PetscMax(row[0], row[1]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a dense matrix for the kept vertices of each body. */
static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  const Model *m = at->m;
  (void)memory, (void)kind; // S does not depend on u, because the strain is small
  PetscFunctionBeginUser;
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    const PetscInt n = c->n_kept;
    PetscInt *vertices;
    PetscReal *k;
    PetscCall(PetscMalloc2(n / 2, &vertices, n * n, &k));
    for (PetscInt i = 0; i < n / 2; i++) vertices[i] = c->kept[2 * i] / 2;
    for (PetscInt i = 0; i < n; i++) PetscCall(PetscArraycpy(k + i * n, c->S + i * c->stride, n));
    PetscCall(add(n / 2, vertices, k, NULL, context));
    PetscCall(PetscFree2(vertices, k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stored energy without the energy of modes, which is added with their motion. */
static PetscErrorCode energy(const void *memory, const Instant *at, PetscReal *sum)
{
  PetscFunctionBeginUser;
  (void)memory;
  for (PetscInt b = 0; b < at->m->condensed.n; b++) {
    const Condensed *c = at->m->condensed.body + b;
    for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = at->u[c->kept[i]];
    DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
    for (PetscInt i = 0; i < c->n_kept; i++) *sum += 0.5 * c->u[i] * c->f[i];
    for (PetscInt i = 0; i < c->n_kept && c->corrects; i++) *sum += c->u[i] * c->corrects[i];
    *sum += c->stored;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode begin(const TermView *v)
{
  PetscFunctionBeginUser;
  if (!StageInTime(v->stage)) CondensedRest(v->m, v->state);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Condensed_term = {.name = "condensed bodies",
                                 .forces = forces,
                                 .bound = bound,
                                 .energy = energy,
                                 .tangent = tangent,
                                 .begin = begin};

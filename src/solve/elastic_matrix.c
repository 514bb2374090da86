/* elastic_matrix.c: adds up the elastic stiffness K0 of the whole model on rank 0, with the same bits on any
   number of ranks.

   Ranks add the stiffness of blocks and contacts in different orders. So each contribution to an entry (i, j)
   is rounded to a multiple of a unit, of which a double holds all sums exactly, in any order:
   unit = 2^-44 sqrt(d_i d_j), d the largest contribution to the diagonal, rounded up to a power of two. */
#include "solve/nested.h"
#include <math.h>

enum { MOST = 3 * STIFFNESS_VERTICES };
enum { UNIT_BITS = 44 }; /* 2^9 contributions of the largest size fit */

/* ---- numbers */

PetscErrorCode ElasticNumbers(const Model *m, PetscInt **number)
{
  PetscMPIInt *count, *from, n = (PetscMPIInt)m->n_dof;
  PetscInt *key, *mine, *order, all = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(m->size, &count, m->size, &from));
  PetscCallMPI(MPI_Allgather(&n, 1, MPI_INT, count, 1, MPI_INT, m->comm));
  for (PetscMPIInt r = 0; r < m->size; r++) from[r] = (PetscMPIInt)all, all += count[r];
  PetscCall(PetscMalloc3(all, &key, all, &order, n, &mine));
  PetscCall(PetscMalloc1(all, number));
  for (PetscInt b = 0; b < m->rigid.n; b++)
    for (PetscInt i = 0; i < 3; i++) mine[3 * b + i] = 3 * m->rigid.gid[b] + i;
  for (PetscInt i = 0; i < 2 * m->mesh.n_deformable; i++)
    mine[3 * m->rigid.n + i] = 3 * m->mesh.n_rigid_global + 2 * m->mesh.vertex_gid[i / 2] + i % 2;
  PetscCallMPI(MPI_Allgatherv(mine, n, MPIU_INT, key, count, from, MPIU_INT, m->comm));
  for (PetscInt i = 0; i < all; i++) order[i] = i;
  PetscCall(PetscSortIntWithArray(all, key, order));
  for (PetscInt i = 0; i < all; i++) (*number)[order[i]] = i;
  PetscCall(PetscFree3(key, order, mine));
  PetscCall(PetscFree2(count, from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- contributions of this rank */

typedef struct {
  PetscInt row, column;
  PetscReal value;
} Entry;

typedef struct {
  const Instant *at;
  const State *state;
  const Stiffness *s;
  const PetscInt *number;
  PetscInt n; /* rows */
  PetscSegBuffer found;
  size_t n_entries, n_all;
  Entry *entry, *all; /* (n_entries,) those of this rank; (n_all,) of all ranks, on rank 0 */
  PetscReal *largest; /* (n,) largest contribution to the diagonal */
  ElasticMatrix *x;
} Contributions;

static PetscErrorCode add_entry(Contributions *to, PetscInt row, PetscInt column, PetscReal value)
{
  Entry *entry;
  PetscFunctionBeginUser;
  if (row > column || value == 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSegBufferGet(to->found, 1, &entry));
  *entry = (Entry){row, column, value};
  if (row == column) to->largest[row] = PetscMax(to->largest[row], value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a coupling in the rows of its vertices: T' k T, as StiffnessAdd does. The rows of a rigid body are
   summed over its vertices in the order of the coupling, which is the same on any rank. */
static PetscErrorCode add_of_term(PetscInt n, const PetscInt *vertices, const PetscReal *k,
                                  const PetscReal *carried, void *context)
{
  Contributions *to = context;
  const Model *m = to->at->m;
  PetscReal small[MOST * MOST], *sum = small;
  PetscInt rows[MOST], *row = rows, at_rows[MOST], *at = at_rows, n_rows = 0;
  PetscFunctionBeginUser;
  if (3 * n > MOST) PetscCall(PetscMalloc3(9 * n * n, &sum, 3 * n, &row, 3 * n, &at));
  for (PetscInt i = 0; i < 3 * n; i++) {
    const PetscInt global = to->s->row[3 * vertices[i / 3] + i % 3],
                   now = global < 0 ? -1 : to->number[global];
    PetscInt j = 0;
    while (j < n_rows && row[j] != now) j++;
    if (now >= 0 && j == n_rows) row[n_rows++] = now;
    at[i] = now < 0 ? -1 : j;
  }
  PetscCall(PetscArrayzero(sum, n_rows * n_rows));
  for (PetscInt i = 0; i < 3 * n; i++)
    for (PetscInt j = 0; j < 3 * n; j++) {
      PetscReal t[2][2] = {{0., 0.}, {0., 0.}}, value = 0.; // d(x, y)/d(row) of the two vertices
      if (at[i] < 0 || at[j] < 0) continue;
      for (int e = 0; e < 2; e++) {
        const PetscInt d = (e ? j : i) % 3, v = vertices[(e ? j : i) / 3];
        if (d < 2) t[e][d] = 1.;
        if (d < 2 || v >= m->mesh.n_vertices || m->mesh.vertex_rigid[v] < 0) continue;
        t[e][0] = -to->s->arm[2 * v + 1], t[e][1] = to->s->arm[2 * v];
      }
      for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++)
          value += t[0][a] * k[(2 * (i / 3) + a) * 2 * n + 2 * (j / 3) + b] * t[1][b];
      sum[at[i] * n_rows + at[j]] += value;
    }
  for (PetscInt i = 0; i < n && carried; i++) {
    const PetscReal *arm = to->s->arm + 2 * vertices[i];
    if (at[3 * i + 2] >= 0)
      sum[at[3 * i + 2] * (n_rows + 1)] -= carried[2 * i] * arm[0] + carried[2 * i + 1] * arm[1];
  }
  for (PetscInt i = 0; i < n_rows; i++)
    for (PetscInt j = 0; j < n_rows; j++) PetscCall(add_entry(to, row[i], row[j], sum[i * n_rows + j]));
  if (3 * n > MOST) PetscCall(PetscFree3(sum, row, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collects the contributions of this rank. context: Contributions. */
static PetscErrorCode collect(void *context)
{
  Contributions *to = context;
  const Model *m = to->at->m;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(to->n, &to->largest));
  PetscCall(PetscSegBufferCreate(sizeof(Entry), 4096, &to->found));
  PetscCall(TermsTangent(PHASE_BLOCKS, to->state, to->at, TANGENT_ELASTIC, add_of_term, to));
  PetscCall(TermsTangent(PHASE_BODIES, to->state, to->at, TANGENT_ELASTIC, add_of_term, to));
  PetscCall(TermsTangent(PHASE_JOINTS, to->state, to->at, TANGENT_ELASTIC, add_of_term, to));
  for (PetscInt d = 0; d < m->n_dof; d++) { // a held degree of freedom does not move
    const PetscInt row = to->number[to->s->first + d];
    if (Held(m, d)) PetscCall(add_entry(to, row, row, 1.));
  }
  PetscCall(PetscSegBufferGetSize(to->found, &to->n_entries));
  PetscCall(PetscSegBufferExtractAlloc(to->found, &to->entry));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rounds the contributions of this rank to their units. */
static PetscErrorCode round_entries(Contributions *to)
{
  const Model *m = to->at->m;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, to->largest, (PetscMPIInt)to->n, MPIU_REAL, MPI_MAX, m->comm));
  for (Entry *entry = to->entry; entry < to->entry + to->n_entries; entry++) {
    int e[2];
    (void)frexp(to->largest[entry->row], e), (void)frexp(to->largest[entry->column], e + 1);
    const PetscReal round = ldexp(1.5, 52 - UNIT_BITS + (e[0] + e[1] + 1) / 2);
    entry->value = (entry->value + round) - round;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix */

/* Makes room for the contributions of all ranks. context: Contributions. */
static PetscErrorCode make_room(void *context)
{
  Contributions *to = context;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(to->n_all, &to->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the contributions of all ranks to rank 0. wants: there is no memory for them. */
static PetscErrorCode gather(Contributions *mine, PetscBool *wants)
{
  const Model *m = mine->at->m;
  PetscMPIInt *count, *from, own;
  MPI_Datatype type;
  PetscFunctionBeginUser;
  mine->n_all = mine->n_entries, mine->all = mine->entry;
  if (m->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)sizeof(Entry), MPI_BYTE, &type));
  PetscCallMPI(MPI_Type_commit(&type));
  PetscCall(PetscMPIIntCast((PetscInt)mine->n_entries, &own));
  PetscCall(PetscMalloc2(m->size, &count, m->size, &from));
  PetscCallMPI(MPI_Gather(&own, 1, MPI_INT, count, 1, MPI_INT, 0, m->comm));
  mine->n_all = 0, mine->all = NULL;
  for (PetscMPIInt r = 0; r < m->size && !m->rank; r++)
    from[r] = (PetscMPIInt)mine->n_all, mine->n_all += (size_t)count[r];
  PetscCall(TryForMemory(m->comm, make_room, mine, wants));
  if (!*wants) PetscCallMPI(MPI_Gatherv(mine->entry, own, type, mine->all, count, from, type, 0, m->comm));
  PetscCallMPI(MPI_Type_free(&type));
  PetscCall(PetscFree2(count, from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts the contributions by row and column, and adds those to the same entry. The sums are exact. */
static PetscErrorCode add_up(size_t n_entries, const Entry *entry, ElasticMatrix *x)
{
  const PetscInt n = x->n;
  PetscInt kept = 0, *filled;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(n + 2, &filled)); // filled[row + 1]: where the next entry of a row goes
  for (size_t i = 0; i < n_entries; i++) filled[entry[i].row + 2]++;
  for (PetscInt i = 0; i < n; i++) filled[i + 2] += filled[i + 1];
  PetscCall(PetscMalloc2(n_entries, &x->column, n_entries, &x->value));
  for (size_t i = 0; i < n_entries; i++) {
    const PetscInt at = filled[entry[i].row + 1]++;
    x->column[at] = entry[i].column, x->value[at] = entry[i].value;
  }
  for (PetscInt row = 0; row < n; row++) {
    const PetscInt from = filled[row], to = filled[row + 1];
    PetscCall(PetscSortIntWithScalarArray(to - from, x->column + from, x->value + from));
    x->start[row] = kept;
    for (PetscInt i = from; i < to; i++) {
      const PetscBool same = (PetscBool)(kept > x->start[row] && x->column[kept - 1] == x->column[i]);
      if (same)
        x->value[kept - 1] += x->value[i];
      else
        x->column[kept] = x->column[i], x->value[kept++] = x->value[i];
    }
  }
  x->start[n] = kept;
  PetscCall(PetscFree(filled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the first row of each node. Rigid bodies come first. */
static PetscErrorCode find_nodes(const Model *m, ElasticMatrix *x)
{
  const PetscInt n_rigid = m->mesh.n_rigid_global;
  PetscFunctionBeginUser;
  x->n_nodes = n_rigid + (x->n - 3 * n_rigid) / 2;
  PetscCall(PetscMalloc1(x->n_nodes + 1, &x->node_start));
  for (PetscInt i = 0; i <= x->n_nodes; i++)
    x->node_start[i] = i <= n_rigid ? 3 * i : 3 * n_rigid + 2 * (i - n_rigid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the matrix on rank 0. context: Contributions. */
static PetscErrorCode make_matrix(void *context)
{
  const Contributions *from = context;
  ElasticMatrix *x = from->x;
  PetscFunctionBeginUser;
  if (from->at->m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  x->n = from->n;
  PetscCall(PetscMalloc1(x->n + 1, &x->start));
  PetscCall(find_nodes(from->at->m, x));
  PetscCall(add_up(from->n_all, from->all, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElasticMatrixCreate(const Instant *at, const State *state, const Stiffness *s,
                                   const PetscInt *number, ElasticMatrix *x, PetscBool *wants)
{
  const MPI_Comm comm = at->m->comm;
  Contributions mine = {.at = at, .state = state, .s = s, .number = number, .x = x};
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(x, sizeof(*x)));
  PetscCallMPI(MPI_Allreduce(&at->m->n_dof, &mine.n, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(TryForMemory(comm, collect, &mine, wants));
  PetscCall(PetscSegBufferDestroy(&mine.found));
  if (!*wants) PetscCall(round_entries(&mine));
  if (!*wants) PetscCall(gather(&mine, wants));
  PetscCall(PetscFree(mine.largest));
  if (mine.all != mine.entry) PetscCall(PetscFree(mine.entry));
  if (!*wants) PetscCall(TryForMemory(comm, make_matrix, &mine, wants));
  PetscCall(PetscFree(mine.all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElasticMatrixDestroy(ElasticMatrix *x)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(x->node_start));
  PetscCall(PetscFree(x->start));
  PetscCall(PetscFree2(x->column, x->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

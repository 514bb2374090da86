/* nested_share.c: makes the factor of the elastic stiffness on rank 0 and deals it out to the ranks. */
#include "solve/nested.h"

/* ---- parts of ranks */

/* Gives each part to a rank: the largest first, to the rank that owns most of its degrees of freedom of those
   with little work so far. */
static PetscErrorCode deal(const Model *m, const NestedOrder *o, Nested f)
{
  const PetscMPIInt n = PetscMin(f->size, NESTED_PARTS); // more ranks have no part
  PetscReal load[NESTED_PARTS] = {0.}, work[NESTED_PARTS] = {0.};
  PetscInt shared[NESTED_PARTS * NESTED_PARTS] = {0};
  PetscBool done[NESTED_PARTS] = {PETSC_FALSE};
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    for (PetscInt s = o->part[k]; s < o->part[k + 1]; s++)
      work[k] += (PetscReal)(o->first[s + 1] - o->first[s]) *
                 (PetscReal)(o->first[s + 1] - o->first[s] + o->row_start[s + 1] - o->row_start[s]);
    for (PetscInt d = 0; d < f->n_dof && m->rank < n; d++)
      if (f->place[d] >= o->first[o->part[k]] && f->place[d] < o->first[o->part[k + 1]])
        shared[k * n + m->rank]++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, shared, NESTED_PARTS * n, MPIU_INT, MPI_SUM, m->comm));
  for (PetscInt turn = 0; turn < NESTED_PARTS; turn++) {
    PetscInt k = -1;
    PetscMPIInt best = 0, least = 0;
    for (PetscInt i = 0; i < NESTED_PARTS; i++)
      if (!done[i] && (k < 0 || work[i] > work[k])) k = i;
    for (PetscMPIInt r = 1; r < n; r++)
      if (load[r] < load[least]) least = r;
    best = least;
    for (PetscMPIInt r = 0; r < n; r++)
      if (load[r] <= load[least] + 0.1 * work[k] && shared[k * n + r] > shared[k * n + best]) best = r;
    f->owner[k] = best, load[best] += work[k], done[k] = PETSC_TRUE;
  }
  for (PetscInt k = 0; k < NESTED_PARTS; k++) f->count[f->owner[k]] += (PetscMPIInt)f->n_top;
  for (PetscMPIInt r = 1; r < f->size; r++) f->from[r] = f->from[r - 1] + f->count[r - 1];
  for (PetscMPIInt r = 0, slot = 0; r < f->size; r++)
    for (PetscInt k = 0; k < NESTED_PARTS; k++)
      if (f->owner[k] == r) f->slot[k] = slot++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the order of elimination from rank 0 to all. */
static PetscErrorCode share_order(const Model *m, NestedOrder *o)
{
  PetscInt n[3] = {o->n, o->n_supers, m->rank ? 0 : o->row_start[o->n_supers]};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(n, 3, MPIU_INT, 0, m->comm));
  if (m->rank) {
    o->n = n[0], o->n_supers = n[1];
    PetscCall(PetscMalloc5(n[0], &o->place, n[1] + 1, &o->first, n[1] + 1, &o->row_start, n[2], &o->row, n[1],
                           &o->parent));
  }
  PetscCallMPI(MPI_Bcast(o->place, (PetscMPIInt)n[0], MPIU_INT, 0, m->comm));
  PetscCallMPI(MPI_Bcast(o->first, (PetscMPIInt)n[1] + 1, MPIU_INT, 0, m->comm));
  PetscCallMPI(MPI_Bcast(o->row_start, (PetscMPIInt)n[1] + 1, MPIU_INT, 0, m->comm));
  PetscCallMPI(MPI_Bcast(o->row, (PetscMPIInt)n[2], MPIU_INT, 0, m->comm));
  PetscCallMPI(MPI_Bcast(o->part, NESTED_PARTS + 1, MPIU_INT, 0, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lays out the supernodes `from` to `to` - 1 with places in x. copy: where the top is for them. */
static PetscErrorCode lay_out(Nested f, const NestedOrder *o, PetscInt from, PetscInt to, PetscInt copy,
                              NestedPiece *p, size_t *size)
{
  PetscInt n_rows = 0;
  PetscFunctionBeginUser;
  p->n = to - from, *size = 0;
  for (PetscInt s = from; s < to; s++)
    n_rows += o->first[s + 1] - o->first[s] + o->row_start[s + 1] - o->row_start[s] + NESTED_LANES;
  PetscCall(PetscMalloc3(p->n + 1, &p->first, p->n + 1, &p->row_start, n_rows, &p->row));
  n_rows = 0;
  for (PetscInt s = from; s < to; s++) {
    p->first[s - from] = o->first[s], p->row_start[s - from] = n_rows;
    for (PetscInt c = o->first[s]; c < o->first[s + 1]; c++) p->row[n_rows++] = c;
    for (PetscInt i = o->row_start[s]; i < o->row_start[s + 1]; i++)
      p->row[n_rows++] = o->row[i] < f->n_below ? o->row[i] : o->row[i] - f->n_below + copy;
    *size += NestedSize(o->first[s + 1] - o->first[s], n_rows - p->row_start[s - from]);
    while (n_rows % NESTED_LANES) p->row[n_rows++] = f->n; // the dummy
  }
  p->first[p->n] = o->first[to], p->row_start[p->n] = n_rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lays out the pieces of this rank, and sends the values of each from rank 0. values: on rank 0; freed. */
static PetscErrorCode share_values(const Model *m, const NestedOrder *o, NestedReal *values, Nested f)
{
  enum { TAG = 17 };
  NestedReal *from = values;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    const PetscBool top = (PetscBool)(k == NESTED_PARTS);
    const PetscInt end = top ? o->n_supers : o->part[k + 1];
    PetscMPIInt n;
    size_t size;
    const PetscBool mine = (PetscBool)(top || f->owner[k] == m->rank);
    if (mine || !m->rank) {
      NestedPiece other;
      PetscCall(lay_out(f, o, o->part[k], end, top ? f->n_below : NestedCopy(f, k),
                        mine ? f->piece + k : &other, &size));
      if (!mine) PetscCall(PetscFree3(other.first, other.row_start, other.row));
    } else
      continue;
    PetscCall(PetscMPIIntCast((PetscInt)size, &n));
    if (f->size == 1) {
      f->piece[k].B = from, from += size;
      continue;
    }
    if (mine) PetscCall(PetscMalloc1(size, &f->piece[k].B));
    if (!m->rank && mine) PetscCall(PetscArraycpy(f->piece[k].B, from, size));
    if (top)
      PetscCallMPI(MPI_Bcast(f->piece[k].B, n, MPI_FLOAT, 0, m->comm));
    else if (!m->rank && !mine)
      PetscCallMPI(MPI_Send(from, n, MPI_FLOAT, f->owner[k], TAG, m->comm));
    else if (m->rank)
      PetscCallMPI(MPI_Recv(f->piece[k].B, n, MPI_FLOAT, 0, TAG, m->comm, MPI_STATUS_IGNORE));
    if (!m->rank) from += size;
  }
  if (f->size == 1)
    f->values = values;
  else
    PetscCall(PetscFree(values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts b, sums and x where the other ranks of the machine see them, if all ranks are on one. at, remote: (n,)
   places of the right-hand sides that this rank needs, and their owners; back: (n_dof,) who has solutions. */
static PetscErrorCode show(const Model *m, PetscInt n, const PetscInt *at, const PetscSFNode *remote,
                           const PetscSFNode *back, Nested f)
{
  const PetscInt mine = f->n_dof + f->count[f->rank];
  PetscInt *skip; // values before x, of each rank
  PetscFunctionBeginUser;
  if (!m->one_machine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      SharedCreate(m->comm, sizeof(NestedShown) + sizeof(PetscReal) * (size_t)(mine + f->room), &f->memory));
  if (!f->memory.mine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(f->size, &f->near));
  PetscCall(PetscMalloc1(f->size, &skip));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPIU_INT, skip, 1, MPIU_INT, m->comm));
  for (PetscMPIInt r = 0; r < f->size; r++) PetscCall(SharedOf(&f->memory, r, &f->near[r]));
  PetscCall(PetscFree(f->x));
  f->x = f->near[f->rank]->values + mine, f->n_given = n;
  PetscCall(PetscMalloc3(n, &f->given_to, n, &f->given, f->n_dof, &f->solved));
  for (PetscInt i = 0; i < n; i++)
    f->given_to[i] = at[i], f->given[i] = f->near[remote[i].rank]->values + remote[i].index;
  for (PetscInt d = 0; d < f->n_dof; d++)
    f->solved[d] = f->near[back[d].rank]->values + skip[back[d].rank] + back[d].index;
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    const PetscMPIInt r = f->owner[k];
    f->sums[k] = f->near[r]->values + skip[r] - f->count[r] + f->slot[k] * f->n_top - f->from[r];
  }
  PetscCall(PetscFree(skip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares the exchanges: of right-hand sides from the owners of degrees of freedom to the ranks of parts,
   and of solutions back. row_of: (n,) degree of freedom, in PETSc's order, at each place. */
static PetscErrorCode prepare_exchanges(const Model *m, const NestedOrder *o, const PetscInt *row_of,
                                        Nested f)
{
  PetscInt *start, *at, n = 0;
  PetscSFNode *remote, *back;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(f->size + 1, &start));
  PetscCallMPI(MPI_Allgather(&m->n_dof, 1, MPIU_INT, start + 1, 1, MPIU_INT, m->comm));
  start[0] = 0;
  for (PetscMPIInt r = 0; r < f->size; r++) start[r + 1] += start[r];
  PetscCall(PetscMalloc1(f->n, &at));
  PetscCall(PetscMalloc1(f->n, &remote));
  PetscCall(PetscMalloc1(f->n_dof, &back));
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    const PetscInt from = o->first[o->part[k]], to = k < NESTED_PARTS ? o->first[o->part[k + 1]] : f->n;
    const PetscMPIInt owner = k < NESTED_PARTS ? f->owner[k] : f->rank;
    for (PetscInt i = from; i < to && owner == f->rank; i++) {
      PetscMPIInt r = 0;
      while (row_of[i] >= start[r + 1]) r++;
      at[n] = i, remote[n++] = (PetscSFNode){r, row_of[i] - start[r]};
    }
    for (PetscInt d = 0; d < f->n_dof; d++)
      if (f->place[d] >= from && f->place[d] < to) back[d] = (PetscSFNode){owner, f->place[d]};
  }
  PetscCall(show(m, n, at, remote, back, f));
  if (!f->memory.mine) {
    PetscCall(PetscSFCreate(m->comm, &f->give));
    PetscCall(PetscSFSetGraph(f->give, f->n_dof, n, at, PETSC_COPY_VALUES, remote, PETSC_COPY_VALUES));
    PetscCall(PetscSFSetUp(f->give));
    PetscCall(PetscSFCreate(m->comm, &f->take));
    PetscCall(PetscSFSetGraph(f->take, f->n, f->n_dof, NULL, PETSC_COPY_VALUES, back, PETSC_COPY_VALUES));
    PetscCall(PetscSFSetUp(f->take));
  }
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(at));
  PetscCall(PetscFree(remote));
  PetscCall(PetscFree(back));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes PETSc's objects for K0 and its factor. */
static PetscErrorCode wrap(const Model *m, Nested f)
{
  Vec all;
  PetscFunctionBeginUser;
  PetscCall(MatCreateShell(m->comm, f->n_dof, f->n_dof, f->n, f->n, f, &f->matrix));
  PetscCall(MatShellSetOperation(f->matrix, MATOP_MULT, (void (*)(void))NestedMultiply));
  PetscCall(MatCreateVecs(f->matrix, &all, NULL));
  PetscCall(VecScatterCreateToZero(all, &f->to_first, &f->on_first));
  PetscCall(VecDuplicate(f->on_first, &f->product));
  PetscCall(VecDestroy(&all));
  PetscCall(PCCreate(m->comm, &f->pc));
  PetscCall(PCSetType(f->pc, PCSHELL));
  PetscCall(PCSetOperators(f->pc, f->matrix, f->matrix));
  PetscCall(PCShellSetContext(f->pc, f));
  PetscCall(PCShellSetApply(f->pc, NestedSolve));
  PetscCall(PCSetUp(f->pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Makes the order of elimination and the factor. wants: the memory ran out. */
static PetscErrorCode factorise(const ElasticMatrix *x, NestedOrder *o, NestedReal **values,
                                PetscBool *positive, PetscBool *wants)
{
  PetscFunctionBeginUser;
  PetscCall(NestedOrderCreate(x, o));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  const PetscErrorCode code = NestedFactorise(x, o, values, positive);
  PetscCall(PetscPopErrorHandler());
  *wants = (PetscBool)(code == PETSC_ERR_MEM);
  if (*wants)
    *positive = PETSC_FALSE;
  else
    PetscCall(code);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedCreate(const Problem *p, const Stiffness *s, Nested *nested, PetscBool *fails,
                            PetscBool *wants)
{
  const Model *m = p->m;
  NestedOrder o = {0};
  NestedReal *values = NULL;
  PetscInt *row_of;
  PetscBool positive = PETSC_TRUE;
  Nested f;
  PetscFunctionBeginUser;
  *wants = PETSC_FALSE;
  PetscCall(PetscNew(nested));
  f = *nested, f->comm = m->comm, f->rank = m->rank, f->size = m->size, f->n_dof = m->n_dof;
  PetscCall(ElasticNumbers(m, &f->number));
  PetscCall(ElasticMatrixCreate(m, p->state, p->stage->joints, p->contacts, s, f->number, &f->whole));
  if (!m->rank) PetscCall(factorise(&f->whole, &o, &values, &positive, wants));
  PetscCallMPI(MPI_Bcast(&positive, 1, MPI_PETSC_BOOL, 0, m->comm));
  PetscCallMPI(MPI_Bcast(wants, 1, MPI_PETSC_BOOL, 0, m->comm));
  *fails = (PetscBool)!positive;
  PetscCall(share_order(m, &o));
  f->n = o.n, f->n_below = o.first[o.part[NESTED_PARTS]], f->n_top = f->n - f->n_below;
  f->room = f->n + 1 + NESTED_PARTS * f->n_top;
  PetscCall(PetscCalloc1(f->room, &f->x));
  PetscCall(PetscCalloc2(m->size, &f->count, m->size, &f->from));
  PetscCall(PetscMalloc1(f->n_dof, &f->place));
  PetscCall(PetscMalloc1(f->n, &row_of));
  for (PetscInt i = 0; i < f->n; i++) row_of[o.place[f->number[i]]] = i;
  for (PetscInt d = 0; d < f->n_dof; d++) f->place[d] = o.place[f->number[s->first + d]];
  PetscCall(deal(m, &o, f));
  if (positive)
    PetscCall(share_values(m, &o, values, f));
  else
    PetscCall(PetscFree(values));
  if (m->size > 1) PetscCall(prepare_exchanges(m, &o, row_of, f));
  PetscCall(wrap(m, f));
  PetscCall(PetscFree(row_of));
  PetscCall(NestedOrderDestroy(&o));
  if (m->rank) PetscCall(PetscFree(f->number));
  if (!m->rank) PetscCall(PetscMalloc1(2 * f->n, &f->product_work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedDestroy(Nested *nested)
{
  Nested f = *nested;
  PetscFunctionBeginUser;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    PetscCall(PetscFree3(f->piece[k].first, f->piece[k].row_start, f->piece[k].row));
    if (f->size > 1) PetscCall(PetscFree(f->piece[k].B));
  }
  PetscCall(PetscFree(f->values));
  if (f->memory.mine) {
    PetscCall(SharedDestroy(&f->memory));
    PetscCall(PetscFree(f->near));
    PetscCall(PetscFree3(f->given_to, f->given, f->solved));
  } else
    PetscCall(PetscFree(f->x));
  PetscCall(PetscFree(f->product_work));
  PetscCall(PetscFree(f->number));
  PetscCall(PetscFree(f->place));
  PetscCall(PetscFree2(f->count, f->from));
  PetscCall(ElasticMatrixDestroy(&f->whole));
  PetscCall(PetscSFDestroy(&f->give));
  PetscCall(PetscSFDestroy(&f->take));
  PetscCall(VecScatterDestroy(&f->to_first));
  PetscCall(VecDestroy(&f->on_first));
  PetscCall(VecDestroy(&f->product));
  PetscCall(MatDestroy(&f->matrix));
  PetscCall(PCDestroy(&f->pc));
  PetscCall(PetscFree(*nested));
  PetscFunctionReturn(PETSC_SUCCESS);
}

Mat NestedMatrix(Nested nested)
{
  return nested->matrix;
}

PC NestedSolver(Nested nested)
{
  return nested->pc;
}

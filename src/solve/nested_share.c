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

/* A factor while it is made. */
typedef struct {
  const Model *m;
  Nested f;
  NestedOrder o;
  PetscInt n_rows;    /* in o.row */
  NestedReal *values; /* on rank 0, of all pieces */
  PetscInt *row_of;   /* (n,) degree of freedom, in PETSc's order, at each place */
  PetscBool positive;
  // of the exchanges of several ranks
  PetscInt n_given;    /* number of right-hand sides that this rank needs */
  PetscInt *start;     /* (size + 1,) a number of each rank */
  PetscInt *at;        /* (n_given,) places of these right-hand sides */
  PetscSFNode *remote; /* (n_given,) who has them */
  PetscSFNode *back;   /* (n_dof,) who has solutions */
} Making;

/* Makes the order of elimination and the factor, on rank 0. context: Making. */
static PetscErrorCode factorise(void *context)
{
  Making *to = context;
  PetscFunctionBeginUser;
  to->positive = PETSC_TRUE;
  if (to->f->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(NestedOrderCreate(&to->f->whole, &to->o));
  PetscCall(NestedFactorise(&to->f->whole, &to->o, &to->values, &to->positive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for the order of elimination, and for all that does not depend on who has which part. context:
   Making. */
static PetscErrorCode make_room(void *context)
{
  Making *to = context;
  NestedOrder *o = &to->o;
  Nested f = to->f;
  PetscFunctionBeginUser;
  if (f->rank)
    PetscCall(PetscMalloc5(o->n, &o->place, o->n_supers + 1, &o->first, o->n_supers + 1, &o->row_start,
                           to->n_rows, &o->row, o->n_supers, &o->parent));
  PetscCall(PetscCalloc1(f->room, &f->x));
  PetscCall(PetscCalloc2(f->size, &f->count, f->size, &f->from));
  PetscCall(PetscMalloc1(f->n_dof, &f->place));
  PetscCall(PetscMalloc1(f->n, &to->row_of));
  if (!f->rank) PetscCall(PetscMalloc1(2 * f->n, &f->product_work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the order of elimination from rank 0 to all. wants: there is no memory for it. */
static PetscErrorCode share_order(Making *to, PetscBool *wants)
{
  NestedOrder *o = &to->o;
  Nested f = to->f;
  PetscInt n[4] = {o->n, o->n_supers, 0, 0};
  PetscFunctionBeginUser;
  if (!f->rank) n[2] = o->row_start[o->n_supers], n[3] = o->first[o->part[NESTED_PARTS]];
  PetscCallMPI(MPI_Bcast(n, 4, MPIU_INT, 0, f->comm));
  o->n = f->n = n[0], o->n_supers = n[1], to->n_rows = n[2];
  f->n_below = n[3], f->n_top = f->n - f->n_below, f->room = f->n + 1 + NESTED_PARTS * f->n_top;
  PetscCall(TryForMemory(f->comm, make_room, to, wants));
  if (*wants) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(o->place, (PetscMPIInt)n[0], MPIU_INT, 0, f->comm));
  PetscCallMPI(MPI_Bcast(o->first, (PetscMPIInt)n[1] + 1, MPIU_INT, 0, f->comm));
  PetscCallMPI(MPI_Bcast(o->row_start, (PetscMPIInt)n[1] + 1, MPIU_INT, 0, f->comm));
  PetscCallMPI(MPI_Bcast(o->row, (PetscMPIInt)n[2], MPIU_INT, 0, f->comm));
  PetscCallMPI(MPI_Bcast(o->part, NESTED_PARTS + 1, MPIU_INT, 0, f->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the supernode behind the last one of a piece; NESTED_PARTS: the top. */
static PetscInt end_of(const NestedOrder *o, PetscInt piece)
{
  return piece == NESTED_PARTS ? o->n_supers : o->part[piece + 1];
}

/* Returns the number of values of a piece. */
static size_t size_of(const NestedOrder *o, PetscInt piece)
{
  size_t size = 0;
  for (PetscInt s = o->part[piece]; s < end_of(o, piece); s++) {
    const PetscInt width = o->first[s + 1] - o->first[s];
    size += NestedSize(width, width + o->row_start[s + 1] - o->row_start[s]);
  }
  return size;
}

/* Lays out a piece with places in x. copy: where the top is for it. */
static PetscErrorCode lay_out(Nested f, const NestedOrder *o, PetscInt piece, PetscInt copy)
{
  const PetscInt from = o->part[piece], to = end_of(o, piece);
  NestedPiece *p = f->piece + piece;
  PetscInt n_rows = 0;
  PetscFunctionBeginUser;
  p->n = to - from, p->n_values = size_of(o, piece);
  for (PetscInt s = from; s < to; s++)
    n_rows += o->first[s + 1] - o->first[s] + o->row_start[s + 1] - o->row_start[s] + NESTED_LANES;
  PetscCall(PetscMalloc3(p->n + 1, &p->first, p->n + 1, &p->row_start, n_rows, &p->row));
  n_rows = 0;
  for (PetscInt s = from; s < to; s++) {
    p->first[s - from] = o->first[s], p->row_start[s - from] = n_rows;
    for (PetscInt c = o->first[s]; c < o->first[s + 1]; c++) p->row[n_rows++] = c;
    for (PetscInt i = o->row_start[s]; i < o->row_start[s + 1]; i++)
      p->row[n_rows++] = o->row[i] < f->n_below ? o->row[i] : o->row[i] - f->n_below + copy;
    while (n_rows % NESTED_LANES) p->row[n_rows++] = f->n; // the dummy
  }
  p->first[p->n] = o->first[to], p->row_start[p->n] = n_rows;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether this rank has a piece; all have the top. */
static PetscBool has_piece(Nested f, PetscInt piece)
{
  return (PetscBool)(piece == NESTED_PARTS || f->owner[piece] == f->rank);
}

/* Makes room for the exchanges. */
static PetscErrorCode make_exchanges(Making *to)
{
  const NestedOrder *o = &to->o;
  Nested f = to->f;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= NESTED_PARTS; k++)
    if (has_piece(f, k)) to->n_given += o->first[end_of(o, k)] - o->first[o->part[k]];
  PetscCall(PetscMalloc4(f->size + 1, &to->start, to->n_given, &to->at, to->n_given, &to->remote, f->n_dof,
                         &to->back));
  if (!to->m->one_machine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc4(f->size, &f->near, to->n_given, &f->given_to, to->n_given, &f->given, f->n_dof,
                         &f->solved));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for the pieces of this rank and for the exchanges, and lays out the pieces. context: Making. */
static PetscErrorCode make_pieces(void *context)
{
  Making *to = context;
  Nested f = to->f;
  PetscFunctionBeginUser;
  if (f->size > 1) PetscCall(make_exchanges(to));
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    if (!has_piece(f, k)) continue;
    PetscCall(lay_out(f, &to->o, k, k == NESTED_PARTS ? f->n_below : NestedCopy(f, k)));
    if (f->size > 1) PetscCall(PetscMalloc1(size_of(&to->o, k), &f->piece[k].B));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the values of each piece from rank 0. */
static PetscErrorCode share_values(Making *making)
{
  enum { TAG = 17 };
  const NestedOrder *o = &making->o;
  Nested f = making->f;
  NestedReal *from = making->values;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    const PetscBool top = (PetscBool)(k == NESTED_PARTS), mine = has_piece(f, k);
    const size_t size = size_of(o, k);
    PetscMPIInt n;
    if (!mine && f->rank) continue;
    PetscCall(PetscMPIIntCast((PetscInt)size, &n));
    if (f->size == 1) {
      f->piece[k].B = from, from += size;
      continue;
    }
    if (!f->rank && mine) PetscCall(PetscArraycpy(f->piece[k].B, from, size));
    if (top)
      PetscCallMPI(MPI_Bcast(f->piece[k].B, n, MPI_FLOAT, 0, f->comm));
    else if (!f->rank && !mine)
      PetscCallMPI(MPI_Send(from, n, MPI_FLOAT, f->owner[k], TAG, f->comm));
    else if (f->rank)
      PetscCallMPI(MPI_Recv(f->piece[k].B, n, MPI_FLOAT, 0, TAG, f->comm, MPI_STATUS_IGNORE));
    if (!f->rank) from += size;
  }
  if (f->size == 1) f->values = making->values, making->values = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts b, sums and x where the other ranks of the machine see them, if all ranks are on one and have memory
   to share. making: has the places. */
static PetscErrorCode show(Making *making)
{
  Nested f = making->f;
  const PetscInt mine = f->n_dof + f->count[f->rank];
  PetscInt *skip = making->start; // values before x, of each rank
  PetscFunctionBeginUser;
  if (!making->m->one_machine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      SharedCreate(f->comm, sizeof(NestedShown) + sizeof(PetscReal) * (size_t)(mine + f->room), &f->memory));
  if (!f->memory.mine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allgather(&mine, 1, MPIU_INT, skip, 1, MPIU_INT, f->comm));
  for (PetscMPIInt r = 0; r < f->size; r++) PetscCall(SharedOf(&f->memory, r, &f->near[r]));
  PetscCall(PetscFree(f->x));
  f->x = f->near[f->rank]->values + mine, f->n_given = making->n_given;
  for (PetscInt i = 0; i < f->n_given; i++) {
    const PetscSFNode *from = making->remote + i;
    f->given_to[i] = making->at[i], f->given[i] = f->near[from->rank]->values + from->index;
  }
  for (PetscInt d = 0; d < f->n_dof; d++) {
    const PetscSFNode *from = making->back + d;
    f->solved[d] = f->near[from->rank]->values + skip[from->rank] + from->index;
  }
  for (PetscInt k = 0; k < NESTED_PARTS; k++) {
    const PetscMPIInt r = f->owner[k];
    f->sums[k] = f->near[r]->values + skip[r] - f->count[r] + f->slot[k] * f->n_top - f->from[r];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares the exchanges: of right-hand sides from the owners of degrees of freedom to the ranks of parts,
   and of solutions back. */
static PetscErrorCode prepare_exchanges(Making *making)
{
  const NestedOrder *o = &making->o;
  Nested f = making->f;
  PetscInt *start = making->start, n = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allgather(&f->n_dof, 1, MPIU_INT, start + 1, 1, MPIU_INT, f->comm));
  start[0] = 0;
  for (PetscMPIInt r = 0; r < f->size; r++) start[r + 1] += start[r];
  for (PetscInt k = 0; k <= NESTED_PARTS; k++) {
    const PetscInt from = o->first[o->part[k]], to = o->first[end_of(o, k)];
    const PetscMPIInt owner = k < NESTED_PARTS ? f->owner[k] : f->rank;
    for (PetscInt i = from; i < to && owner == f->rank; i++) {
      PetscMPIInt r = 0;
      while (making->row_of[i] >= start[r + 1]) r++;
      making->at[n] = i, making->remote[n++] = (PetscSFNode){r, making->row_of[i] - start[r]};
    }
    for (PetscInt d = 0; d < f->n_dof; d++)
      if (f->place[d] >= from && f->place[d] < to) making->back[d] = (PetscSFNode){owner, f->place[d]};
  }
  PetscCall(show(making));
  if (f->memory.mine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFCreate(f->comm, &f->give));
  PetscCall(PetscSFSetGraph(f->give, f->n_dof, n, making->at, PETSC_COPY_VALUES, making->remote,
                            PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(f->give));
  PetscCall(PetscSFCreate(f->comm, &f->take));
  PetscCall(
      PetscSFSetGraph(f->take, f->n, f->n_dof, NULL, PETSC_COPY_VALUES, making->back, PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(f->take));
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

/* Deals a positive factor out to the ranks. s: its rows are numbered. */
static PetscErrorCode share(const Model *m, const Stiffness *s, Making *making, PetscBool *wants)
{
  const NestedOrder *o = &making->o;
  Nested f = making->f;
  PetscFunctionBeginUser;
  PetscCall(share_order(making, wants));
  if (*wants) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < f->n; i++) making->row_of[o->place[f->number[i]]] = i;
  for (PetscInt d = 0; d < f->n_dof; d++) f->place[d] = o->place[f->number[s->first + d]];
  PetscCall(deal(m, o, f));
  PetscCall(TryForMemory(f->comm, make_pieces, making, wants));
  if (*wants) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(share_values(making));
  if (f->size > 1) PetscCall(prepare_exchanges(making));
  PetscCall(wrap(m, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NestedCreate(const Problem *p, const Stiffness *s, Nested *nested, PetscBool *fails,
                            PetscBool *wants)
{
  const Model *m = p->m;
  const Instant at = {
      .m = m, .joints = p->stage->joints, .contacts = p->contacts, .u = p->state->u + 3 * m->rigid.n};
  Making making = {.m = m};
  Nested f;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(nested));
  f = making.f = *nested, f->comm = m->comm, f->rank = m->rank, f->size = m->size, f->n_dof = m->n_dof;
  PetscCall(ElasticNumbers(m, &f->number));
  PetscCall(ElasticMatrixCreate(&at, p->state, s, f->number, &f->whole, wants));
  if (!*wants) PetscCall(TryForMemory(m->comm, factorise, &making, wants));
  PetscCallMPI(MPI_Bcast(&making.positive, 1, MPI_PETSC_BOOL, 0, m->comm));
  if (!*wants && making.positive) PetscCall(share(m, s, &making, wants));
  *fails = (PetscBool)(*wants || !making.positive);
  PetscCall(PetscFree(making.values));
  PetscCall(PetscFree(making.row_of));
  PetscCall(PetscFree4(making.start, making.at, making.remote, making.back));
  PetscCall(NestedOrderDestroy(&making.o));
  if (m->rank) PetscCall(PetscFree(f->number));
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
  PetscCall(PetscFree4(f->near, f->given_to, f->given, f->solved));
  if (f->memory.mine)
    PetscCall(SharedDestroy(&f->memory));
  else
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

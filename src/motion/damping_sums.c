/* damping_sums.c: sums the damping (37) over all ranks, the one reduction of a cycle. The sums are
   binned (reproducible.h), so any order gives the same bits.

   On one machine the sums go through shared memory, by recursive doubling: in round k a rank and the rank
   whose number differs in bit k send each other their sums so far. With two ranks that is one cache line
   each way and takes 0.06 us, where MPI_Allreduce takes 0.3 to 0.45; with n ranks it takes log2(n) times as
   long. Ranks beyond the largest power of two send their sums first and receive the result at the end. */
#include "motion/motion.h"
#include "base/shared.h"

/* Sums that a rank sends in one round; two copies take turns. */
typedef struct {
  _Alignas(SHARED_LINE) Count count;
  QuotientSums sums;
} Line;

enum { ROUNDS = 33 };

typedef struct _p_DampingSums {
  MPI_Op op; /* op and type are for messages, used without shared memory */
  MPI_Datatype type;
  Shared memory;       /* memory.mine is NULL where there is none */
  uint64_t count;      /* reductions so far */
  QuotientSums so_far; /* of this rank and of the ranks received in this reduction */
  PetscInt n;          /* number of rounds */
  struct {
    Line *mine, *theirs;     /* two copies each; NULL: this rank sends, or receives, nothing in this round */
    PetscBool lower, result; /* theirs comes from lower ranks; theirs is the result of all ranks */
  } round[ROUNDS];
} DampingSums;

static void MPIAPI reduce(void *in, void *inout, PetscMPIInt *n, MPI_Datatype *type)
{
  const QuotientSums *lower = in;
  QuotientSums *higher = inout;
  (void)type;
  for (PetscMPIInt i = 0; i < *n; i++) higher[i] = QuotientSumsOf(lower + i, higher + i);
}

/* Adds a round in which this rank exchanges sums with the rank `with`. sends, receives: the directions.
   place: place of the round in the memory of every rank. */
static PetscErrorCode add_round(DampingSums *s, PetscMPIInt rank, PetscMPIInt with, PetscInt place,
                                PetscBool send, PetscBool receive)
{
  Line *theirs;
  PetscFunctionBeginUser;
  PetscCall(SharedOf(&s->memory, with, &theirs));
  s->round[s->n].mine = send ? (Line *)s->memory.mine + 2 * place : NULL;
  s->round[s->n].theirs = receive ? theirs + 2 * place : NULL;
  s->round[s->n].lower = (PetscBool)(with < rank);
  s->round[s->n++].result = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode plan(DampingSums *s, PetscMPIInt rank, PetscMPIInt size)
{
  PetscMPIInt whole = 1;
  PetscInt place = 1;
  PetscFunctionBeginUser;
  while (2 * whole <= size) whole *= 2;
  if (rank >= whole) {
    PetscCall(add_round(s, rank, rank - whole, 0, PETSC_TRUE, PETSC_FALSE));
    PetscCall(add_round(s, rank, rank - whole, ROUNDS - 1, PETSC_FALSE, PETSC_TRUE));
    s->round[1].result = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscBool given = (PetscBool)(rank + whole < size);
  if (given) PetscCall(add_round(s, rank, rank + whole, 0, PETSC_FALSE, PETSC_TRUE));
  for (PetscMPIInt bit = 1; bit < whole; bit *= 2)
    PetscCall(add_round(s, rank, rank ^ bit, place++, PETSC_TRUE, PETSC_TRUE));
  if (given) PetscCall(add_round(s, rank, rank + whole, ROUNDS - 1, PETSC_TRUE, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingSumsCreate(const Model *m, DampingSums **sums)
{
  DampingSums *s;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  *sums = s;
  PetscCallMPI(MPI_Op_create(reduce, 1, &s->op));
  PetscCallMPI(MPI_Type_contiguous(sizeof(QuotientSums) / sizeof(PetscReal), MPIU_REAL, &s->type));
  PetscCallMPI(MPI_Type_commit(&s->type));
  if (m->size == 1 || !m->one_machine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SharedCreate(m->comm, 2 * ROUNDS * sizeof(Line), &s->memory));
  if (s->memory.mine) PetscCall(plan(s, m->rank, m->size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingSumsDestroy(DampingSums **s)
{
  PetscFunctionBeginUser;
  if (!*s) PetscFunctionReturn(PETSC_SUCCESS);
  if ((*s)->memory.mine) PetscCall(SharedDestroy(&(*s)->memory));
  PetscCallMPI(MPI_Op_free(&(*s)->op));
  PetscCallMPI(MPI_Type_free(&(*s)->type));
  PetscCall(PetscFree(*s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the reduction */

static void send_sums(const DampingSums *s, PetscInt k)
{
  if (!s->round[k].mine) return;
  Line *mine = s->round[k].mine + s->count % 2;
  mine->sums = s->so_far;
  SharedPublish(&mine->count, s->count);
}

static PetscErrorCode receive_sums(const Model *m, DampingSums *s, PetscInt k)
{
  PetscFunctionBeginUser;
  if (!s->round[k].theirs) PetscFunctionReturn(PETSC_SUCCESS);
  const Line *theirs = s->round[k].theirs + s->count % 2;
  PetscCall(SharedWait(m->comm, &theirs->count, s->count));
  const QuotientSums other = theirs->sums, mine = s->so_far;
  s->so_far = s->round[k].result  ? other
              : s->round[k].lower ? QuotientSumsOf(&other, &mine)
                                  : QuotientSumsOf(&mine, &other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Starts the reduction. With messages it only stores the sums: MPI_Iallreduce, started here, took 0.7 us
   longer than the MPI_Allreduce in DampingSumsEnd. */
void DampingSumsBegin(const Model *m, DampingSums *s, const QuotientSums *mine)
{
  s->so_far = *mine;
  if (m->size == 1 || !s->memory.mine) return;
  s->count++;
  send_sums(s, 0);
}

PetscErrorCode DampingSumsEnd(const Model *m, DampingSums *s, QuotientSums *all)
{
  PetscFunctionBeginUser;
  if (m->size > 1 && !s->memory.mine)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s->so_far, 1, s->type, s->op, m->comm));
  for (PetscInt k = 0; k < s->n; k++) {
    if (k) send_sums(s, k);
    PetscCall(receive_sums(m, s, k));
  }
  *all = s->so_far;
  PetscFunctionReturn(PETSC_SUCCESS);
}

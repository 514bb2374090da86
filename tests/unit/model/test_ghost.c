/* The exchange of a cycle, through shared memory and by messages: whoever reads whose vertices, and however
   late a rank comes, ghosts have what their owner held when it called.
   ranks: 1 2 3 4 */
#include "motion/motion.h"
#include "base/shared.h"
#include "check.h"
#include <unistd.h>

enum { OWNED = 40, EXCHANGES = 60 };
typedef enum { NEXT_RANK, ALL_RANKS, NOBODY, MORE, PATTERNS } Pattern;

static Model Alone(PetscBool one_machine)
{
  Model m = {.comm = PETSC_COMM_WORLD, .one_machine = one_machine, .mesh.n_owned = OWNED};
  MPI_Comm_rank(m.comm, &m.rank);
  MPI_Comm_size(m.comm, &m.size);
  return m;
}

/* Ghosts of a rank: 1 of the next one, which does not read this one's when there are more than two; 3 of
   each other; none; more and more of the one before, but of rank 0 nothing. */
static void MakeGhosts(Model *m, Pattern pattern, GhostRecord *ghost)
{
  m->ghosts.record = ghost;
  m->ghosts.n = 0;
  for (PetscMPIInt other = 0; other < m->size; other++) {
    PetscInt n = pattern == ALL_RANKS ? 3 : 0;
    if (pattern == NEXT_RANK && other == (m->rank + 1) % m->size) n = 1;
    if (pattern == MORE && other && other == m->rank - 1) n = OWNED;
    for (PetscInt i = 0; i < n && other != m->rank; i++)
      ghost[m->ghosts.n++] = (GhostRecord){.owner = other, .index = (7 * m->rank + 11 * i) % OWNED};
  }
  m->mesh.n_vertices = m->mesh.n_owned + m->ghosts.n;
}

static PetscReal HeldBy(PetscMPIInt owner, PetscInt index, int exchange, int x)
{
  return 1e6 * owner + 1e4 * x + 100. * index + exchange / 1024.;
}

/* On the way each rank sleeps now and then, so that each is once ahead of the others and once behind. */
static PetscErrorCode Exchanges(const Model *m, int n)
{
  PetscReal *u;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * m->mesh.n_vertices, &u));
  for (int e = 0; e < n; e++) {
    for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) u[i] = HeldBy(m->rank, i / 2, e, i % 2);
    if ((e * 5 + m->rank) % 13 == 0) usleep(100);
    PetscCall(GhostBegin(m, u));
    PetscCall(GhostEnd(m, u));
    if ((e * 3 + m->rank) % 17 == 0) usleep(100);
    for (PetscInt i = 0; i < 2 * m->ghosts.n; i++)
      ENSURE(u[2 * m->mesh.n_owned + i] ==
             HeldBy(m->ghosts.record[i / 2].owner, m->ghosts.record[i / 2].index, e, i % 2));
    for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) ENSURE(u[i] == HeldBy(m->rank, i / 2, e, i % 2));
  }
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(PetscBool one_machine)
{
  Model m = Alone(one_machine);
  GhostRecord *ghost;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(OWNED * m.size, &ghost));
  for (int again = 0; again < 2; again++) // one exchange after the other in the same Model, as blocks move
    for (Pattern pattern = 0; pattern < PATTERNS; pattern++) {
      MakeGhosts(&m, pattern, ghost);
      PetscCall(GhostConnect(&m));
      PetscCall(Exchanges(&m, CheckDraws(EXCHANGES)));
    }
  PetscCall(GhostDestroy(&m));
  PetscCall(PetscFree(ghost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GhostsHaveWhatTheirOwnersHeldThroughSharedMemory(void)
{
  PetscMPIInt here, size;
  PetscFunctionBeginUser;
  PetscCall(SharedRanks(PETSC_COMM_WORLD, &here));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  ENSURE(here == size);
  if (here == size) PetscCall(Run(PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GhostsHaveWhatTheirOwnersHeldByMessages(void)
{
  PetscFunctionBeginUser;
  PetscCall(Run(PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(GhostsHaveWhatTheirOwnersHeldThroughSharedMemory);
  RUN_TEST(GhostsHaveWhatTheirOwnersHeldByMessages);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

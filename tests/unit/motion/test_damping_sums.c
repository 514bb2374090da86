/* The reduction of a cycle, through shared memory and by messages: sums add up, maxima are the larger, and
   all ranks get the same bits, even where something is not a number. ranks: 1 2 3 4 7 */
#include "stages/stages.h"
#include "check.h"
#include <unistd.h>

enum { CALLS = 100 };

/* Small whole numbers: their sums are exact. */
static QuotientSums OfRank(PetscMPIInt rank, int call)
{
  const PetscReal x = (rank * 37 + call * 11) % 101 - 30;
  return (QuotientSums){{x, 3. * call}, {x * x, rank}, PetscAbsReal(x), (rank * 53 + call * 7) % 97};
}

static void SameOnAllRanks(const Model *m, const QuotientSums *x)
{
  QuotientSums first = *x;
  MPI_Bcast(&first, sizeof first, MPI_BYTE, 0, m->comm);
  ENSURE(!memcmp(&first, x, sizeof first));
}

static PetscErrorCode Run(PetscBool one_machine)
{
  Model m = {.comm = PETSC_COMM_WORLD, .one_machine = one_machine};
  DampingSums *sums;
  PetscFunctionBeginUser;
  MPI_Comm_rank(m.comm, &m.rank);
  MPI_Comm_size(m.comm, &m.size);
  PetscCall(DampingSumsCreate(&m, &sums));
  for (int call = 0; call < CheckDraws(CALLS); call++) {
    QuotientSums x = OfRank(m.rank, call), expected = OfRank(0, call);
    for (PetscMPIInt r = 1; r < m.size; r++) {
      const QuotientSums other = OfRank(r, call);
      for (int k = 0; k < 2; k++) expected.num[k] += other.num[k], expected.den[k] += other.den[k];
      expected.num_max = PetscMax(expected.num_max, other.num_max);
      expected.den_max = PetscMax(expected.den_max, other.den_max);
    }
    if ((call * 5 + m.rank) % 13 == 0) usleep(100); // each is once ahead of the others and once behind
    DampingSumsBegin(&m, sums, &x);
    if ((call * 3 + m.rank) % 17 == 0) usleep(100);
    PetscCall(DampingSumsEnd(&m, sums, &x));
    ENSURE(!memcmp(&x, &expected, sizeof x));
  }
  for (PetscMPIInt bad = 0; bad < m.size; bad++) {
    QuotientSums x = OfRank(m.rank, bad);
    if (m.rank == bad) x.num[0] = x.num_max = NAN;
    DampingSumsBegin(&m, sums, &x);
    PetscCall(DampingSumsEnd(&m, sums, &x));
    ENSURE(PetscIsNanReal(x.num[0]));
    if (one_machine) SameOnAllRanks(&m, &x);
  }
  PetscCall(DampingSumsDestroy(&sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SumsAndMaximaOfAllRanksThroughSharedMemory(void)
{
  PetscFunctionBeginUser;
  PetscCall(Run(PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SumsAndMaximaOfAllRanksByMessages(void)
{
  PetscFunctionBeginUser;
  PetscCall(Run(PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(SumsAndMaximaOfAllRanksThroughSharedMemory);
  RUN_TEST(SumsAndMaximaOfAllRanksByMessages);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

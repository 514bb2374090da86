/* Binned sums: the same bits in any order and grouping, and as accurate as the bins promise.
   ranks: 1 2 4 */
#include "scene_fixture.h"
#include "base/reproducible.h"

enum { TERMS = 20000 };
static PetscReal term[TERMS];

/* Terms of all sizes and signs below `bound`. */
static void Terms(double bound)
{
  for (int i = 0; i < TERMS; i++) term[i] = bound * Uniform(-1, 1) * pow(2, -floor(Uniform(0, 60)));
}

static void Shuffle(void)
{
  for (int i = TERMS - 1; i > 0; i--) {
    const int j = (int)Uniform(0, i + 1);
    const PetscReal swap = term[i];
    term[i] = term[j], term[j] = swap;
  }
}

static void Sum(const Bins *bins, int from, int to, PetscReal sum[2])
{
  sum[0] = sum[1] = 0;
  for (int i = from; i < to; i++) BinAdd(bins, term[i], sum);
}

static void SumHasTheSameBitsInAnyOrder(void)
{
  for (double bound = 1e-250; bound < 1e260; bound *= 1e50) {
    PetscReal first[2], again[2];
    int naive = 0;
    double plain = 0;
    Terms(bound);
    const Bins bins = BinsFor(bound);
    Sum(&bins, 0, TERMS, first);
    for (int i = 0; i < TERMS; i++) plain += term[i];
    for (int trial = 0; trial < 10; trial++) {
      double other = 0;
      Shuffle();
      Sum(&bins, 0, TERMS, again);
      ENSURE(again[0] == first[0] && again[1] == first[1]);
      for (int i = 0; i < TERMS; i++) other += term[i];
      naive += other != plain;
    }
    ENSURE(naive > 0); // what the bins are for
  }
}

static void SumHasTheSameBitsInAnyGroups(void)
{
  PetscReal whole[2], group[2];
  Terms(1);
  const Bins bins = BinsFor(1);
  Sum(&bins, 0, TERMS, whole);
  for (int n = 2; n < 100; n *= 3) {
    PetscReal sum[2] = {0, 0};
    for (int i = 0; i < n; i++) {
      Sum(&bins, i * TERMS / n, (i + 1) * TERMS / n, group);
      for (int k = 0; k < 2; k++) sum[k] += group[k];
    }
    ENSURE(sum[0] == whole[0] && sum[1] == whole[1]);
  }
}

static PetscErrorCode SumHasTheSameBitsOnAnyNumberOfRanks(void)
{
  PetscReal whole[2], mine[2];
  PetscMPIInt rank, size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  Terms(1e6);
  const Bins bins = BinsFor(1e6);
  Sum(&bins, 0, TERMS, whole);
  Sum(&bins, rank * TERMS / size, (rank + 1) * TERMS / size, mine);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, mine, 2, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD));
  ENSURE(mine[0] == whole[0] && mine[1] == whole[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Each term loses at most half a unit of the second bin: 2^-54 of the bound, rounded up to a power of two. */
static void SumIsAccurateToTheSecondBin(void)
{
  for (int trial = 0; trial < 50; trial++) {
    const double bound = pow(10, Uniform(-200, 200));
    long double exact = 0;
    PetscReal sum[2];
    int exponent;
    Terms(bound);
    const Bins bins = BinsFor(bound);
    frexp(bound, &exponent);
    Sum(&bins, 0, TERMS, sum);
    for (int i = 0; i < TERMS; i++) exact += term[i];
    ENSURE_NEAR((double)((long double)sum[0] + sum[1] - exact), 0,
                TERMS * ldexp(1, exponent - 2 * BIN_BITS - 1));
  }
}

/* The bound may be far from tight: a bound 2^20 too large leaves 34 bits, and the bits stay
   the same in any order. */
static void LooseBoundCostsOnlyDigits(void)
{
  PetscReal first[2], again[2];
  long double exact = 0;
  Terms(1);
  const Bins bins = BinsFor(1048576);
  Sum(&bins, 0, TERMS, first);
  for (int i = 0; i < TERMS; i++) exact += term[i];
  Shuffle();
  Sum(&bins, 0, TERMS, again);
  ENSURE(first[0] == again[0] && first[1] == again[1]);
  ENSURE_NEAR((double)((long double)first[0] + first[1] - exact), 0, TERMS * ldexp(1, 21 - 2 * BIN_BITS - 1));
}

static void ZeroTermsAndTinyBoundsAreNoTrouble(void)
{
  PetscReal sum[2] = {0, 0};
  Bins bins = BinsFor(1e-300);
  for (int i = 0; i < 10; i++) BinAdd(&bins, 0, sum);
  ENSURE(sum[0] == 0 && sum[1] == 0);
  bins = BinsFor(1);
  for (int i = 0; i < 10; i++) BinAdd(&bins, i % 2 ? 0.1 : -0.1, sum);
  ENSURE(sum[0] + sum[1] == 0);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(SumHasTheSameBitsInAnyOrder);
  RUN_TEST(SumHasTheSameBitsInAnyGroups);
  RUN_TEST(SumHasTheSameBitsOnAnyNumberOfRanks);
  RUN_TEST(SumIsAccurateToTheSecondBin);
  RUN_TEST(LooseBoundCostsOnlyDigits);
  RUN_TEST(ZeroTermsAndTinyBoundsAreNoTrouble);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

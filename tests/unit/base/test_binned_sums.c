/* Sums of terms in slots: the same bits in any order and on any number of ranks, and accurate.
   ranks: 1 2 4 */
#include "scene_fixture.h"

enum { TERMS = 3000, SLOTS = 7 };
static PetscInt slot[TERMS];
static PetscReal term[TERMS];

static void Terms(void)
{
  for (int i = 0; i < TERMS; i++)
    slot[i] = (PetscInt)Uniform(0, SLOTS - 1), term[i] = Uniform(-1, 1) * pow(10, Uniform(-8, 8));
}

static void Shuffle(void)
{
  for (int i = TERMS - 1; i > 0; i--) {
    const int j = (int)Uniform(0, i + 1);
    const PetscReal x = term[i];
    const PetscInt s = slot[i];
    term[i] = term[j], term[j] = x;
    slot[i] = slot[j], slot[j] = s;
  }
}

static PetscErrorCode SumsAreExactAndAlike(void)
{
  PetscReal first[SLOTS], again[SLOTS];
  long double exact[SLOTS] = {0};
  PetscMPIInt rank, size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  Terms(); // alike on all ranks
  for (int i = 0; i < TERMS; i++) exact[slot[i]] += term[i];
  PetscCall(BinnedSums(PETSC_COMM_SELF, TERMS, slot, term, SLOTS, first));
  for (int trial = 0; trial < 5; trial++) { // each rank has a part of them
    const int from = rank * TERMS / size, to = (rank + 1) * TERMS / size;
    Shuffle();
    PetscCall(BinnedSums(PETSC_COMM_WORLD, to - from, slot + from, term + from, SLOTS, again));
    for (int s = 0; s < SLOTS; s++) ENSURE(again[s] == first[s]);
  }
  for (int s = 0; s < SLOTS; s++) ENSURE_NEAR((double)(first[s] - exact[s]), 0, TERMS * 1e8 * ldexp(1, -53));
  ENSURE(first[SLOTS - 1] == 0.); // no term is in the last slot
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WhatIsNotFiniteIsSeen(void)
{
  const PetscInt at[] = {0, 0, 1, 2};
  const PetscReal x[] = {1., NAN, 2., INFINITY};
  PetscReal sum[3];
  PetscFunctionBeginUser;
  PetscCall(BinnedSums(PETSC_COMM_SELF, 4, at, x, 3, sum));
  ENSURE(isnan(sum[0]) && sum[1] == 2. && isnan(sum[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(SumsAreExactAndAlike);
  RUN_TEST(WhatIsNotFiniteIsSeen);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* GridRows against brute force on boxes of all kinds, and its cost on many. */
#include "motion/motion.h"
#include "check.h"
#include <stdlib.h>
#include <string.h>
#include <time.h>

static PetscBool Touch(const PetscReal *a, const PetscReal *b)
{
  return a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3] ? PETSC_TRUE : PETSC_FALSE;
}

/* Rows of both directions, one box after the other. */
static PetscErrorCode CompareWithBruteForce(const char *what, PetscInt n, const PetscReal *box)
{
  PetscInt *start, *near, p = 0, wrong = 0;

  PetscFunctionBegin;
  PetscCall(GridRows(n, box, NULL, NULL, &start, &near));
  for (PetscInt i = 0; i < n; i++) {
    if (start[i] != p) wrong++;
    for (PetscInt j = 0; j < n; j++) {
      if (j == i || !Touch(box + 4 * i, box + 4 * j)) continue;
      if (p >= start[n] || near[p] != j) wrong++;
      p++;
    }
  }
  if (wrong || p != start[n])
    fprintf(stderr, "%s: %d of %d neighbours wrong, %d found\n", what, (int)wrong, (int)p, (int)start[n]);
  ENSURE(wrong == 0);
  ENSURE(p == start[n]);
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Uniform(void)
{
  /* the same numbers everywhere: not rand() */
  static uint64_t state = 1;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (PetscReal)(state >> 11) / 9007199254740992.0;
}

static void SetBox(PetscReal *box, PetscReal x, PetscReal y, PetscReal w, PetscReal h)
{
  box[0] = x;
  box[1] = y;
  box[2] = x + w;
  box[3] = y + h;
}

static PetscErrorCode TestFewBoxes(void)
{
  const PetscReal apart[8] = {0, 0, 1, 1, 2, 0, 3, 1}, corner[8] = {0, 0, 1, 1, 1, 1, 2, 2};

  PetscFunctionBegin;
  for (PetscInt n = 0; n < 3; n++) PetscCall(CompareWithBruteForce("apart", n, apart));
  PetscCall(CompareWithBruteForce("corner", 2, corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool BothEven(PetscInt i, PetscInt j, const void *context)
{
  (void)context;
  return i < j && i % 2 == 0 && j % 2 == 0 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode TestFilter(void)
{
  PetscReal box[4 * 9];
  PetscInt *start, *near;

  PetscFunctionBegin;
  for (int i = 0; i < 9; i++) memcpy(box + 4 * i, (PetscReal[4]){0, 0, 1, 1}, 4 * sizeof *box);
  PetscCall(GridRows(9, box, BothEven, NULL, &start, &near));
  ENSURE(start[9] == 5 * 4);
  for (int i = 0; i < 9; i++) ENSURE(start[i + 1] - start[i] == (i % 2 ? 0 : 4));
  ENSURE(near[start[4]] == 0 && near[start[4] + 2] == 6);
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { N = 600 };

static PetscErrorCode TestRandomBoxes(void)
{
  PetscReal box[4 * N];

  PetscFunctionBegin;
  for (int round = 0; round < 12; round++) {
    const PetscReal aspect = pow(10, round % 5 - 2.0), origin = round % 2 ? 1e6 : 0;
    /* of one size */
    for (int i = 0; i < N; i++)
      SetBox(box + 4 * i, origin + Uniform(), Uniform() / aspect, 0.03, 0.03 / aspect);
    PetscCall(CompareWithBruteForce("one size", N, box));
    /* sizes over twelve powers of ten */
    for (int i = 0; i < N; i++)
      SetBox(box + 4 * i, origin + Uniform(), Uniform(), pow(10, -12 * Uniform()), pow(10, -12 * Uniform()));
    PetscCall(CompareWithBruteForce("all sizes", N, box));
    /* faces: lines along x or y, and a few that are neither */
    for (int i = 0; i < N; i++) {
      const PetscReal length = 0.1 * Uniform();
      SetBox(box + 4 * i, Uniform(), Uniform(), i % 2 ? length : 0, i % 2 && i % 7 ? 0 : length);
    }
    PetscCall(CompareWithBruteForce("lines", N, box));
    /* small ones and one that is huge */
    for (int i = 0; i < N; i++) SetBox(box + 4 * i, Uniform(), Uniform(), 1e-3 * Uniform(), 1e-3 * Uniform());
    SetBox(box + 4 * (round * 50), -1e9, -1e9, 2e9, 2e9);
    PetscCall(CompareWithBruteForce("one huge", N, box));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestRegularBoxes(void)
{
  PetscReal box[4 * N];
  const PetscReal sizes[] = {1, 0.1, 1.0 / 3, 4e-9, 1e7};

  PetscFunctionBegin;
  for (int s = 0; s < 5; s++) {
    const PetscReal h = sizes[s];
    /* a wall: each touches its eight neighbours; corners are products, so that touching is exact */
    for (int i = 0; i < N; i++) {
      const int column = i % 25, row = i / 25;
      const PetscReal wall[4] = {column * h, row * h, (column + 1) * h, (row + 1) * h};
      memcpy(box + 4 * i, wall, sizeof wall);
    }
    PetscCall(CompareWithBruteForce("wall", N, box));
    /* a row along x, along y, and slabs upon each other */
    for (int i = 0; i < N; i++) SetBox(box + 4 * i, 0.9 * h * i, 0, h, 0);
    PetscCall(CompareWithBruteForce("along x", N, box));
    for (int i = 0; i < N; i++) SetBox(box + 4 * i, 5, -0.6 * h * i, 0, h);
    PetscCall(CompareWithBruteForce("along y", N, box));
    for (int i = 0; i < N; i++) SetBox(box + 4 * i, 0, h * i, 1000 * h, 0.999 * h);
    PetscCall(CompareWithBruteForce("slabs", N, box));
  }
  /* identical boxes, identical points */
  for (int i = 0; i < 50; i++) SetBox(box + 4 * i, 3, 4, 1, 2);
  PetscCall(CompareWithBruteForce("identical", 50, box));
  for (int i = 0; i < 50; i++) SetBox(box + 4 * i, 3, 4, 0, 0);
  PetscCall(CompareWithBruteForce("one point", 50, box));
  for (int i = 0; i < N; i++) SetBox(box + 4 * i, Uniform() < 0.5 ? 0 : Uniform(), i % 3, 0, 0);
  PetscCall(CompareWithBruteForce("points", N, box));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CountThree(PetscInt i, PetscInt j, PetscBool *stop, void *context)
{
  PetscFunctionBegin;
  ENSURE(i < j);
  if (++*(PetscInt *)context == 3) *stop = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestVisitorStops(void)
{
  PetscReal box[4 * 20];
  PetscInt count = 0;

  PetscFunctionBegin;
  for (int i = 0; i < 20; i++) SetBox(box + 4 * i, 0, 0, 1, 1);
  PetscCall(GridVisit(20, box, CountThree, &count));
  ENSURE(count == 3);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Far from quadratic: 2e5 boxes of very mixed sizes, of which one covers all. n^2 would be 4e10. */
static PetscErrorCode TestManyBoxes(void)
{
  const PetscInt n = 200000;
  PetscInt *start, *near, descents = 0;
  PetscReal *box;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(4 * n, &box));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = 1e-3 * pow(10, -4 * Uniform());
    SetBox(box + 4 * i, Uniform(), Uniform(), size, size);
  }
  SetBox(box + 4 * (n / 2), -1, -1, 3, 3);
  const clock_t begun = clock(); // of this process: others may have the processor too
  PetscCall(GridRows(n, box, NULL, NULL, &start, &near));
  ENSURE((double)(clock() - begun) / CLOCKS_PER_SEC < 10);
  ENSURE(start[n / 2 + 1] - start[n / 2] == n - 1);
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt p = start[i] + 1; p < start[i + 1]; p++) descents += near[p] <= near[p - 1];
  ENSURE(descents == 0);
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscCall(PetscFree(box));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestFewBoxes);
  RUN_TEST(TestFilter);
  RUN_TEST(TestRandomBoxes);
  RUN_TEST(TestRegularBoxes);
  RUN_TEST(TestVisitorStops);
  RUN_TEST(TestManyBoxes);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* The four-fold order of stones: 1 for courses of blocks turned by any angle, the sum over joints by hand for
   rhombs, the same bits on any number of ranks. ranks: 1 2 4 */
#include "scene_fixture.h"

static Sketch sketch;

/* Finds the order of the stones of the sketch, and that of the same stones on this rank alone. */
static PetscErrorCode OrderOfSketch(PetscReal *order, PetscReal *alone)
{
  PetscFunctionBeginUser;
  for (int i = 0; i < 2; i++) {
    Fixture f;
    PetscCall(FixtureOpen(i ? PETSC_COMM_SELF : PETSC_COMM_WORLD, &sketch, &f,
                          "materials: {stone: {density: 2400, young: 1e9, poisson: 0.2}}\n"
                          "relaxation: {allow_floating: true}\n"
                          "joints: {default: {k_n: 1e9, k_s: 4e8, friction: 35}}\n"
                          "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
    PetscCall(ContactsOrder(f.model, f.contacts, i ? alone : order));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Courses of bricks of several bonds: every second course is shifted by a part of a brick. */
static PetscErrorCode CoursesHaveOrderOne(void)
{
  enum { COURSES = 6, BRICKS = 7 };
  static const double shift[] = {0.5, 0.3, 0.}, turn[] = {0., 0.1, 0.4, 0.785398, 2.};
  PetscFunctionBeginUser;
  for (size_t s = 0; s < sizeof shift / sizeof shift[0]; s++)
    for (size_t t = 0; t < sizeof turn / sizeof turn[0]; t++) {
      PetscReal order, alone;
      memset(&sketch, 0, sizeof sketch);
      const int stone = SketchGroup(&sketch, "stone", 0);
      for (int j = 0; j < COURSES; j++)
        for (int i = 0; i < BRICKS; i++) SketchBox(&sketch, stone, i + j % 2 * shift[s], 0.4 * j, 1, 0.4);
      SketchMove(&sketch, 0, turn[t], 3, -2);
      PetscCall(OrderOfSketch(&order, &alone));
      ENSURE_NEAR(order, 1, 1e-9);
      ENSURE(order == alone);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n by n rhombs of sides 1 that meet at an angle a. A stone with p joints along one side and q along the
   other has the order |p + q exp(4 i a)| / (p + q). */
static PetscErrorCode RhombsHaveThatOfTheirAngle(void)
{
  enum { N = 6 };
  static const double angle[] = {60, 75, 90, 45};
  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof angle / sizeof angle[0]; k++) {
    const double a = angle[k] * PETSC_PI / 180, x = cos(a), y = sin(a);
    PetscReal order, alone;
    double parts = 0, whole = 0;
    memset(&sketch, 0, sizeof sketch);
    const int stone = SketchGroup(&sketch, "stone", 0);
    for (int j = 0; j < N; j++)
      for (int i = 0; i < N; i++) {
        const double corner[8] = {i + j * x,           j * y,       i + 1 + j * x,   j * y,
                                  i + 1 + (j + 1) * x, (j + 1) * y, i + (j + 1) * x, (j + 1) * y};
        const int p = 2 - (j == 0 || j == N - 1), q = 2 - (i == 0 || i == N - 1);
        SketchGrid(&sketch, stone, corner, 1, 1, QUADS);
        parts += hypot(p + q * cos(4 * a), q * sin(4 * a)), whole += p + q;
      }
    SketchMove(&sketch, 0, 0.3, 1, 1);
    PetscCall(OrderOfSketch(&order, &alone));
    ENSURE_NEAR(order, parts / whole, 1e-9);
    ENSURE(order == alone);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(CoursesHaveOrderOne);
  RUN_TEST(RhombsHaveThatOfTheirAngle);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

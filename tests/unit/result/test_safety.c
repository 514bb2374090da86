/* Local failure factors (39)-(41) against closed forms. */
#include "result/result.h"
#include "check.h"

/* The paper's first material: uniaxial compression of 0.86 MPa has 2.93 in shear (f_c / 0.86 is 11.6). */
static void FactorsOfThePaper(void)
{
  const Material m = {.tension = 1e6, .compression = 10e6, .cohesion = 1.58e6, .friction = 55};
  PetscReal factor;
  ENSURE(SafetyFactor(&m, 0., -0.86e6, &factor) == SAFETY_SHEAR);
  ENSURE_NEAR(factor, 2.93, 0.005);
  ENSURE(SafetyFactor(&m, 0.5e6, 0., &factor) == SAFETY_TENSION);
  ENSURE_NEAR(factor, 2., 1e-12);
  ENSURE(SafetyFactor(&m, -1e6, -1e6, &factor) == SAFETY_COMPRESSION);
  ENSURE_NEAR(factor, 10., 1e-12);
  ENSURE(SafetyFactor(&m, 0., 0., &factor) == SAFETY_NONE && factor == PETSC_INFINITY);
}

/* A strength that is not given cannot fail; beyond the apex of the cone nothing is left. */
static void FactorsWithoutStrength(void)
{
  const Material none = {.tension = NAN, .compression = NAN, .cohesion = NAN, .friction = NAN},
                 shear = {.tension = NAN, .compression = NAN, .cohesion = 1e5, .friction = 45};
  PetscReal factor;
  ENSURE(SafetyFactor(&none, 1e6, -1e6, &factor) == SAFETY_NONE && factor == PETSC_INFINITY);
  ENSURE(SafetyFactor(&shear, 2e6, 1e6, &factor) == SAFETY_SHEAR && factor == 0.);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(FactorsOfThePaper);
  RUN_TEST(FactorsWithoutStrength);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* The motion of the ground between the rows of a file: against polynomials, and at rest outside the file. */
#include "check.h"
#include "boundary/boundary.h"

/* Along x 0 to 1 m/s2 in 4 s, along y a step from 2 to -2 m/s2 at 1 s, then nothing. */
static PetscReal times[] = {0., 1., 1., 2., 2., 4.};
static PetscReal accelerations[] = {0., 2., .25, 2., .25, -2., .5, -2., .5, 0., 1., 0.};

static PetscErrorCode TestAccelerationIsIntegratedExactly(void)
{
  const GroundMotion quake = {.quantity = MOTION_ACCELERATION, .record = {6, 2, times, accelerations}};
  const Support support = {.along = {&quake, &quake}};
  Motion motion;
  PetscFunctionBeginUser;
  PetscCall(MotionCreate(&support, &motion));
  ENSURE(MotionMoves(&motion) && MotionIsFinite(&motion));
  for (int i = 0; i < 80; i++) {
    const PetscReal t = 0.05 * i, back = 2. - PetscMin(t, 2.);
    ENSURE_NEAR(MotionPlace(&motion, t, 0), t * t * t / 24., 1e-14);
    ENSURE_NEAR(MotionVelocity(&motion, t, 0), t * t / 8., 1e-14);
    ENSURE_NEAR(MotionPlace(&motion, t, 1), t < 1. ? t * t : 2. - back * back, 1e-14);
    ENSURE_NEAR(MotionVelocity(&motion, t, 1), t < 1. ? 2. * t : 2. * back, 1e-14);
  }
  ENSURE_NEAR(MotionPlace(&motion, 9., 0), 64. / 24., 1e-14); // it rests where the file ends
  ENSURE_NEAR(MotionVelocity(&motion, 4., 0), 0., 0.);
  ENSURE_NEAR(MotionPlace(&motion, -1., 0), 0., 0.);
  ENSURE_NEAR(MotionVelocity(&motion, -1., 0), 0., 0.);
  PetscCall(MotionDestroy(&motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestVelocityIsIntegratedExactly(void)
{
  PetscReal t[] = {1., 3., 3., 4.}, v[] = {2., 0., 2., 1., 0., 0., 0., 0.};
  const GroundMotion quake = {.quantity = MOTION_VELOCITY, .record = {4, 2, t, v}};
  const Support support = {.along = {&quake, &quake}};
  Motion motion;
  PetscFunctionBeginUser;
  PetscCall(MotionCreate(&support, &motion));
  ENSURE_NEAR(MotionVelocity(&motion, 0.999, 0), 0., 0.);
  ENSURE_NEAR(MotionVelocity(&motion, 1., 0), 2., 0.); // a step of velocity counts from its time on
  ENSURE_NEAR(MotionVelocity(&motion, 3., 0), 0., 0.);
  ENSURE_NEAR(MotionVelocity(&motion, 2., 1), .5, 1e-15);
  ENSURE_NEAR(MotionPlace(&motion, 2., 0), 2., 1e-15);
  ENSURE_NEAR(MotionPlace(&motion, 2., 1), .25, 1e-15);
  ENSURE_NEAR(MotionPlace(&motion, 5., 0), 4., 1e-15);
  PetscCall(MotionDestroy(&motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestWhatIsNotInAFileRests(void)
{
  const Support support = {0};
  PetscReal t[] = {0., 1e200, 1e308}, far[] = {1e300, 0., 1e300, 0., 1e300, 0.};
  const GroundMotion quake = {.quantity = MOTION_ACCELERATION, .record = {3, 2, t, far}};
  const Support too_far = {.along = {&quake, NULL}};
  Motion motion;
  PetscFunctionBeginUser;
  PetscCall(MotionCreate(&support, &motion));
  ENSURE(!MotionMoves(&motion));
  ENSURE_NEAR(MotionPlace(&motion, 1., 0), 0., 0.);
  ENSURE_NEAR(MotionVelocity(&motion, 1., 1), 0., 0.);
  PetscCall(MotionDestroy(&motion));
  PetscCall(MotionCreate(&too_far, &motion));
  ENSURE(!MotionIsFinite(&motion));
  PetscCall(MotionDestroy(&motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Along x nothing, along y a record of one component. */
static PetscErrorCode TestAMotionAlongOneDirection(void)
{
  PetscReal t[] = {0., 2.}, a[] = {3., 3.};
  const GroundMotion quake = {.quantity = MOTION_ACCELERATION, .record = {2, 1, t, a}};
  const Support support = {.along = {NULL, &quake}};
  Motion motion;
  PetscFunctionBeginUser;
  PetscCall(MotionCreate(&support, &motion));
  ENSURE(MotionMoves(&motion));
  ENSURE_NEAR(MotionPlace(&motion, 1., 0), 0., 0.);
  ENSURE_NEAR(MotionPlace(&motion, 1., 1), 1.5, 1e-15);
  ENSURE_NEAR(MotionVelocity(&motion, 1., 1), 3., 1e-15);
  PetscCall(MotionDestroy(&motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestAccelerationIsIntegratedExactly);
  RUN_TEST(TestVelocityIsIntegratedExactly);
  RUN_TEST(TestWhatIsNotInAFileRests);
  RUN_TEST(TestAMotionAlongOneDirection);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

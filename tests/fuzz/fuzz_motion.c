/* fuzz_motion.c: the bytes are a file of support motion; the first says whether of velocities or
   accelerations. */
#include "fuzz.h"
#include "stages/stages.h"

static Support support = {.name = "base", .fix = {PETSC_TRUE, PETSC_TRUE}};
static Scene scene = {.file = "scene.yaml", .n_supports = 1, .supports = &support};

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("motion.csv");
  snprintf(support.motion, sizeof support.motion, "%s", FuzzPath);
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  SupportMotion *motion = NULL;
  support.quantity = size && data[0] % 2 ? MOTION_VELOCITY : MOTION_ACCELERATION;
  FuzzFile(NULL, 0, data + !!size, size - !!size);
  const PetscErrorCode code = SupportMotionsRead(&scene, PETSC_COMM_SELF, &motion);
  FuzzCheck(code);
  for (PetscInt i = 0; !code && i < motion->n; i++)
    for (int k = 0; k < 8; k++)
      if (!isfinite(motion->row[8 * i + k])) abort();
  if (SupportMotionsDestroy(&scene, &motion)) abort();
  return 0;
}

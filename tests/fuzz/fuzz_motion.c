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
  const Model model = {.comm = PETSC_COMM_SELF, .size = 1};
  const TermView view = {.scene = &scene, .m = &model};
  void *motions = NULL;
  support.quantity = size && data[0] % 2 ? MOTION_VELOCITY : MOTION_ACCELERATION;
  FuzzFile(NULL, 0, data + !!size, size - !!size);
  PetscErrorCode code = SceneReadMotions(PETSC_COMM_SELF, &scene);
  if (!code) code = Supports_term.create(&view, &motions);
  FuzzCheck(code);
  if (Supports_term.destroy(&scene, &motions)) abort();
  if (PetscFree(support.t) || PetscFree(support.xy)) abort();
  support.n_rows = 0;
  return 0;
}

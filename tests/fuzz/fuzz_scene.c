/* fuzz_scene.c: the bytes are the YAML scene; the block mesh is one that the tests use
   (corpus/hdf5/two_bodies.h5, named by QUOIN_FUZZ_MODEL). */
#include "fuzz.h"

static const char *model;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  model = getenv("QUOIN_FUZZ_MODEL");
  if (!model) abort();
  FuzzStart();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  FuzzFile("yaml", data, size, path);
  FuzzSetUp(path, model);
  return 0;
}

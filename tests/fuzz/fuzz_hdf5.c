/* fuzz_hdf5.c: the bytes are model.h5 itself. What breaks inside the HDF5 library is that library's;
   fuzz_mesh.c looks at our reader with files that are whole. */
#include "fuzz.h"

static char scene[64];

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  static const char text[] =
      "relaxation: {allow_floating: true}\nmaterials: {lower: {density: 2400, young: 1e10, poisson: 0.2}, "
      "upper: {density: 2400, young: 1e10, poisson: 0.2}}\n"
      "joints: {default: {k_n: 1e10, k_s: 3e9, friction: 35}}\n"
      "loads: {weight: {type: self_weight}}\nstages: [{rest: {loads: [weight]}}]\n";
  (void)argc, (void)argv;
  FuzzStart();
  FuzzFile("yaml", text, sizeof text - 1, scene);
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char path[64];
  FuzzFile("h5", data, size, path);
  FuzzMesh(scene, path);
  return 0;
}

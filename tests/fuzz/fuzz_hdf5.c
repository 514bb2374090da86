/* fuzz_hdf5.c: the bytes are model.h5 itself. What breaks inside the HDF5 library is that library's;
   fuzz_mesh.c checks at our reader with files that are whole. */
#include "fuzz.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("model.h5");
  FuzzHdf5();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzFile(NULL, 0, data, size);
  FuzzMesh();
  FuzzClosed();
  return 0;
}

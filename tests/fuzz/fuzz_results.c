/* fuzz_results.c: the bytes are what stands in results.h5 behind its head; length and checksum in the head
   are made to fit. A restart checks whether they hold the stages up to its checkpoint, and whose they are. */
#include "fuzz.h"
#include "output/hdf5_disk.h"
#include "output/output.h"
#include <zlib.h>

static Stage stages[2] = {{.name = "rest"}, {.name = "push"}};
static Scene scene = {.n_stages = 2, .stages = stages, .restart = "auto"};
static StageGrids grids[2] = {{.stage = 0}, {.stage = 1}}; /* stages it should have */
static ResultsFile results = {.scene = &scene, .run = 1, .n_grids = 2, .grids = grids};

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("results.h5");
  results.folder = FuzzFolder;
  FuzzHdf5();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char head[DISK_HEADER] = "", message[MESSAGE_LENGTH] = "";
  snprintf(head, sizeof head, "quoin-results\nbytes %zu\ncrc32 %08lx\n", size,
           (unsigned long)crc32(crc32(0, NULL, 0), data, (uInt)size));
  FuzzFile(head, sizeof head, data, size);
  PetscCallAbort(PETSC_COMM_SELF, ResultsFileCheck(&results, 2, message));
  if (message[0]) FuzzLine(message);
  FuzzClosed();
  return 0;
}

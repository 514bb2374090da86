/* fuzz_checkpoint.c: the bytes are the HDF5 part of a checkpoint; length and checksum before it are made to
   fit, as nobody but a forger would. It is read, its options are held against those of the scene, and a run
   takes back what the part "run" has: names of joints and stages, and what the last stage has come to. */
#include "fuzz.h"
#include "archive/archive.h"

static Scene scene = {.options = "model model.h5\nrelaxation.ramp 10\n"};

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("checkpoint_000001.h5");
  FuzzRefusal = ERROR_CHECKPOINT;
  snprintf(scene.restart, sizeof scene.restart, "%s", FuzzPath);
  snprintf(scene.model, sizeof scene.model, "model.h5");
  FuzzHdf5();
  if (!getenv("QUOIN_FUZZ_SAY") && !freopen("/dev/null", "w", stdout))
    abort(); // it says which options have changed
  return 0;
}

static PetscErrorCode take_run(Archive *a, void *context)
{
  PetscInt stage = 0;
  StageResult last = {.verdict = VERDICT_NONE};
  char *text = NULL;
  PetscFunctionBeginUser;
  (void)context;
  PetscCall(ArchiveInts(a, "stage", 1, &stage));
  PetscCall(ArchiveResult(a, "last", &last));
  PetscCall(ArchiveText(a, "joints", &text));
  free(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char head[ARCHIVE_HEADER];
  PetscBool resumed;
  Checkpoint c = {.comm = PETSC_COMM_SELF, .scene = &scene};
  ArchiveHeader(size, HashBytes(0, data, size), QUOIN_VERSION, head);
  FuzzFile(head, sizeof head, data, size);
  PetscErrorCode code = CheckpointRestart(&c);
  if (!code) code = CheckpointAttach(&c, "run", take_run, NULL, &resumed);
  FuzzCheck(code);
  if (CheckpointDestroy(&c)) abort();
  FuzzClosed();
  return 0;
}

/* fuzz.h: what the fuzz targets share. A target hands bytes to one reader, on one rank, in a process that
   starts PETSc once: an execution is the reader and nothing else. Whatever the bytes: no report of a
   sanitizer, no memory left behind, no hang, and either something that was read or PETSC_ERR_USER_INPUT with
   one line of message. Any other error code is a finding. With QUOIN_FUZZ_SAY in the environment messages are
   shown. Built with -DQUOIN_FUZZ=ON and clang; run by tests/fuzz/run.py. */
#pragma once
#include "run/run.h"
#include <fcntl.h>
#include <hdf5.h>
#include <sanitizer/lsan_interface.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* For the sanitizers. A request for more than 1 GB fails: no input here is worth that. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
  return "allocator_may_return_null=1:max_allocation_size_mb=1000:handle_abort=1:quarantine_size_mb=16:"
         "malloc_context_size=4:max_malloc_fill_size=512";
}

const char *__ubsan_default_options(void);
const char *__ubsan_default_options(void)
{
  return "print_stacktrace=1";
}

/* HDF5 1.10 forgets memory when a file is damaged. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
  return "leak:libhdf5\nleak:libmpi\nleak:libopen-\n";
}

enum { FUZZ_PATH = 64 };
static char FuzzFolder[FUZZ_PATH];   /* in memory (tmpfs), of this process; removed when it ends in peace */
static char FuzzPath[2 * FUZZ_PATH]; /* the one file in it that a target writes anew each time */
static int FuzzDescriptor = -1;

static inline void FuzzLeave(void)
{
  unlink(FuzzPath);
  rmdir(FuzzFolder);
}

/* The file that the reader is going to open: head, then data. */
static inline void FuzzFile(const void *head, size_t head_size, const void *data, size_t size)
{
  if ((head_size && pwrite(FuzzDescriptor, head, head_size, 0) != (ssize_t)head_size) ||
      (size && pwrite(FuzzDescriptor, data, size, (off_t)head_size) != (ssize_t)size) ||
      ftruncate(FuzzDescriptor, (off_t)(head_size + size)))
    abort();
}

/* What is refused must be said in one line that says something. */
static inline void FuzzLine(const char *message)
{
  if (strchr(message, '\n') || strlen(message) < 8) abort();
  if (getenv("QUOIN_FUZZ_SAY")) fprintf(stderr, "%s\n", message);
}

/* The one error that a reader may end with. */
static PetscErrorCode FuzzRefusal = PETSC_ERR_USER_INPUT;

static inline void FuzzCheck(PetscErrorCode code)
{
  if (code && code != FuzzRefusal) abort();
}

static inline PetscErrorCode FuzzQuiet(MPI_Comm comm, int line, const char *function, const char *file,
                                       PetscErrorCode code, PetscErrorType type, const char *message,
                                       void *context)
{
  (void)comm, (void)context;
  if (type == PETSC_ERROR_INITIAL && code == FuzzRefusal) FuzzLine(message);
  if (code != FuzzRefusal) fprintf(stderr, "%s:%d: %s: error %d: %s\n", file, line, function, code, message);
  return code;
}

/* Once; name: of the file that the target writes. */
static inline void FuzzStart(const char *name)
{
  static char *words[] = {"fuzz", "-no_signal_handler", NULL};
  char **argv = words;
  int argc = 2;
  setenv("OMPI_MCA_opal_signal", "11", 1);           // aborts are for the sanitizer to report
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 1); // no second process to look after this one
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  __lsan_disable(); // what MPI keeps is its own
  if (PetscInitialize(&argc, &argv, NULL, NULL)) abort();
  __lsan_enable();
  if (PetscPushErrorHandler(FuzzQuiet, NULL)) abort();
  snprintf(FuzzFolder, sizeof FuzzFolder, "/dev/shm/quoin-fuzz-%ld", (long)getpid());
  snprintf(FuzzPath, sizeof FuzzPath, "%s/%s", FuzzFolder, name);
  if (mkdir(FuzzFolder, 0700)) abort();
  FuzzDescriptor = open(FuzzPath, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (FuzzDescriptor < 0) abort();
  atexit(FuzzLeave);
}

/* HDF5 keeps what it asks for anew with every file, 1 MB at a time. */
static inline void FuzzHdf5(void)
{
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  H5set_free_list_limits(-1, -1, 0, 0, 64 << 20, 4 << 20);
}

/* Nothing of a file may be open when a reader is done with it. */
static inline void FuzzClosed(void)
{
  if (H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL) > 0) {
    fprintf(stderr, "left open: %d files, %d datasets, %d groups, %d types, %d attributes\n",
            (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_FILE),
            (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_DATASET),
            (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_GROUP),
            (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_DATATYPE),
            (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ATTR));
    abort();
  }
}

/* The block mesh that tests use. */
#define FUZZ_MODEL QUOIN_SOURCE "/tests/fuzz/corpus/hdf5/two_bodies.h5"

/* From files to a model that is ready to run. */
static inline void FuzzSetUp(const char *scene, const char *model)
{
  char *argv[] = {"quoin", "-model", (char *)(uintptr_t)model, NULL};
  Quoin q = NULL;
  PetscErrorCode code = QuoinCreate(PETSC_COMM_SELF, &q);
  if (!code) code = QuoinSetFromOptions(q, scene, 3, argv);
  if (!code) code = QuoinSetUp(q);
  FuzzCheck(code);
  if (QuoinDestroy(&q)) abort();
}

/* A block mesh with all checks and its new numbers. */
static inline void FuzzMesh(void)
{
  const PetscReal tolerance = 1e-6;
  char message[MESSAGE_LENGTH] = "";
  BlockMesh mesh;
  const PetscErrorCode code = MeshRead(PETSC_COMM_SELF, FuzzPath, &mesh);
  FuzzCheck(code);
  if (code) return;
  if (MeshCheck(&mesh, tolerance, message)) abort();
  if (message[0]) FuzzLine(message);
  if (!message[0] && MeshReorder(&mesh)) abort();
  if (!message[0]) MeshChecksum(&mesh);
  if (MeshDestroy(&mesh)) abort();
}

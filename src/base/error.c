/* error.c: ends a run that fails: a refusal is one line on stderr, a fault of the program keeps PETSc's
   trace. */
#include "base/base.h"
#include "quoin.h"
#include <stdarg.h>

/* the error with which all ranks have given up together; PETSC_SUCCESS: none */
static PetscErrorCode refused = PETSC_SUCCESS;

/* Decides whether an error is of malloc. PETSC 3.18 passes the line of the call instead of the error code,
   and its function instead of the message. */
static PetscBool is_of_malloc(const char *function)
{
  return (PetscBool)(function &&
                     (!strcmp(function, "PetscMallocAlign") || !strcmp(function, "PetscReallocAlign")));
}

/* Prints a refusal as one line on rank 0, and a lack of memory as one line of the rank that meets it. Any
   other error is a fault of the program and keeps PETSc's trace. */
static PetscErrorCode on_error(MPI_Comm comm, int line, const char *function, const char *file,
                               PetscErrorCode code, PetscErrorType type, const char *message, void *context)
{
  PetscMPIInt rank = 0;
  if (type == PETSC_ERROR_INITIAL && is_of_malloc(function)) code = ERROR_MEMORY;
  if (code == ERROR_MEMORY && code != refused) {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (type == PETSC_ERROR_INITIAL)
      fprintf(stderr,
              "quoin: error: rank %d has no memory left in %s: %s; take more machines or a smaller mesh\n",
              rank, function, message);
    return code;
  }
  if (code != refused)
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, context);
  if (type == PETSC_ERROR_INITIAL) {
    MPI_Comm_rank(comm, &rank);
    if (rank == 0) {
      fprintf(stderr, "quoin: error: %s\n", message);
      fflush(stderr);
    }
  }
  return code;
}

/* Keeps silent about a lack of memory, and treats any other error as on_error does. context: PetscBool,
   memory was short. */
static PetscErrorCode note_memory(MPI_Comm comm, int line, const char *function, const char *file,
                                  PetscErrorCode code, PetscErrorType type, const char *message,
                                  void *context)
{
  PetscBool *wants = context;
  if (type == PETSC_ERROR_INITIAL && (is_of_malloc(function) || code == ERROR_MEMORY)) *wants = PETSC_TRUE;
  return *wants ? code : on_error(comm, line, function, file, code, type, message, NULL);
}

PetscErrorCode TryForMemory(MPI_Comm comm, PetscErrorCode (*work)(void *context), void *context,
                            PetscBool *wants)
{
  PetscFunctionBeginUser;
  *wants = PETSC_FALSE;
  PetscCall(PetscPushErrorHandler(note_memory, wants));
  const PetscErrorCode code = work(context);
  PetscCall(PetscPopErrorHandler());
  if (!*wants) PetscCall(code);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, wants, 1, MPI_PETSC_BOOL, MPI_LOR, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode QuoinErrorHandlerPush(void)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPushErrorHandler(on_error, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Refuse(MPI_Comm comm, PetscErrorCode code, const char *message)
{
  char text[MESSAGE_LENGTH];
  PetscMPIInt rank, size, first;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  first = message[0] ? rank : size;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first == size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(text, message, sizeof(text)));
  PetscCallMPI(MPI_Bcast(text, MESSAGE_LENGTH, MPI_CHAR, first, comm));
  refused = code;
  SETERRQ(comm, code, "%s", text);
}

static PetscInt runs = 1; /* runs begun by this process */

PetscBool AlreadyWarned(PetscInt *last_run)
{
  const PetscBool before = (PetscBool)(*last_run == runs);
  *last_run = runs;
  return before;
}

void WarningsReset(void)
{
  runs++;
}

static void (*take)(const char *text, void *context); /* takes warnings; NULL: they are printed */
static void *take_context;

void WarningsTo(void (*function)(const char *text, void *context), void *context)
{
  take = function, take_context = context;
}

/* Hands a warning on, or prints it. */
static void warn(FILE *f, const char *before, const char *format, va_list words)
{
  char text[NAMES_LENGTH];
  vsnprintf(text, sizeof(text), format, words);
  if (take)
    take(text, take_context);
  else
    fprintf(f, "%swarning: %s\n", before, text), fflush(f);
}

void Warn(const char *format, ...)
{
  va_list words;
  va_start(words, format);
  warn(stderr, "quoin: ", format, words);
  va_end(words);
}

PetscErrorCode WarnAll(MPI_Comm comm, const char *format, ...)
{
  PetscMPIInt rank;
  va_list words;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  va_start(words, format);
  if (!rank) warn(PETSC_STDOUT, "", format, words);
  va_end(words);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void AddName(const char *name, char names[NAMES_LENGTH])
{
  const size_t n = strlen(names);
  snprintf(names + n, NAMES_LENGTH - n, "%s %s", n ? "," : "", name);
}

PetscErrorCode CheckMessage(MPI_Comm comm, const char *message)
{
  PetscFunctionBeginUser;
  PetscCall(Refuse(comm, PETSC_ERR_USER_INPUT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode KeepMessage(MPI_Comm comm, int line, const char *function, const char *file,
                           PetscErrorCode code, PetscErrorType type, const char *message, void *context)
{
  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_INITIAL) snprintf(context, MESSAGE_LENGTH, "%s", message);
  return code;
}

PetscBool QuoinErrorIsShared(PetscErrorCode error)
{
  return (PetscBool)(error == refused);
}

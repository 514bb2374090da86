/* base.h: declares errors, names, checksums, timers and files for every room, and includes PETSc.

   Functions return a PETSc error code. "Collective" marks those that all ranks must call together.

   Conventions, stated once (tests/unit/test_conventions.c holds them):
   - SI units: m, N, Pa, kg, s; two dimensions, loads per metre of thickness times `thickness`.
   - Stress: tension positive. Contact opening u_n: positive when the faces part; sigma = k_n u_n.
   - Blocks run counter-clockwise; face k of a block runs from its vertex k to vertex k+1; its outward normal
     is to the right of that direction.
   - f is the RESISTING nodal force, with which the model pushes back (f = +int B'sigma dA for blocks), so the
     unbalanced force is r = f_ext - f. The paper's (8) and (10) use opposite signs; Quoin uses this one.
   - gid: number of a vertex, block or face in Quoin's own global order: of small bandwidth, the same for
     every number of ranks. Every sum over elements, contacts and bodies runs in ascending gid, so results
     have the same bits on any number of ranks. "file id": the number in model.h5. */
#pragma once
#include <petscsf.h>
#include <petscvec.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE)
#error "Quoin needs a PETSc with real double-precision scalars"
#endif
/* PETSc 3.18, and names that later versions have changed */
#if !defined(PETSC_SUCCESS) && PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#endif
#if PETSC_VERSION_LT(3, 22, 0)
typedef size_t SegmentCount; /* number of entries of a PetscSegBuffer */
#else
typedef PetscCount SegmentCount;
#endif
#if PETSC_VERSION_LT(3, 24, 0)
#define MPI_PETSC_BOOL MPIU_BOOL
#else
#define MPI_PETSC_BOOL MPI_C_BOOL
#endif

enum { BATCH = 8 }; /* elements and contacts are padded to whole batches of this many */

enum {
  NAME_LENGTH = 64, /* of groups, sets, points, joints, loads, stages; 63 characters and the closing zero */
  MESSAGE_LENGTH = 1024, /* length of one error line */
  NAMES_LENGTH = 8192    /* length of a warning, which may list names */
};

typedef enum { ISA_WIDEST, ISA_BASE, ISA_V3, ISA_V4 } InstructionSet; /* instruction sets of x86-64 */

/* ---- error.c */
/* Collective. Ends all ranks with the message of the lowest rank that has found a fault, if any has.
   message: the fault of this rank, "": none. */
PetscErrorCode CheckMessage(MPI_Comm comm, const char *message);
/* Error codes for faults other than the bad input of CheckMessage; each has its own exit code. */
#define ERROR_OUTPUT PETSC_ERR_FILE_WRITE          /* an output file cannot be written */
#define ERROR_LOCKED PETSC_ERR_FILE_OPEN           /* another run writes into the output folder */
#define ERROR_CHECKPOINT PETSC_ERR_FILE_UNEXPECTED /* a restart is not possible */
#define ERROR_MEMORY PETSC_ERR_MEM                 /* the model needs more memory than there is */
PetscErrorCode Refuse(MPI_Comm comm, PetscErrorCode code, const char *message);
/* Keeps the line that an error would print: an error handler of PETSc. context: the line,
   char[MESSAGE_LENGTH]. */
PetscErrorCode KeepMessage(MPI_Comm comm, int line, const char *function, const char *file,
                           PetscErrorCode code, PetscErrorType type, const char *message, void *context);
/* Collective. Calls work(context), which must not be collective, on every rank. wants: receives whether
   memory ran out on any rank, which then is no error. What work has allocated, its caller frees. */
PetscErrorCode TryForMemory(MPI_Comm comm, PetscErrorCode (*work)(void *context), void *context,
                            PetscBool *wants);
/* Returns whether this run has given its warnings already; true from the second call on. last_run: a
   static variable of the caller. */
PetscBool AlreadyWarned(PetscInt *last_run);
/* Begins a run without warnings given: each sample of a scene counts as a run. */
void WarningsReset(void);
/* One rank. Prints "quoin: warning: " and a line on stderr. */
void Warn(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Collective. Prints "warning: " and a line on the terminal, where lines of stages stand. */
PetscErrorCode WarnAll(MPI_Comm comm, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Hands warnings to a function, without their first words, and prints none; NULL: prints them again. */
void WarningsTo(void (*function)(const char *text, void *context), void *context);
/* Appends a name to a list for a warning. */
void AddName(const char *name, char names[NAMES_LENGTH]);
/* Decides whether all ranks return this error, so that the program can end in order instead of aborting. */
PetscBool QuoinErrorIsShared(PetscErrorCode error);

/* ---- names.c */
/* Returns the row of a name in a list, or -1. */
PetscInt NameRow(PetscInt n, char (*names)[NAME_LENGTH], const char *name);
/* Compares two rows of n integers for qsort: the first pair that differs decides. */
static inline int OrderInts(int n, const PetscInt *p, const PetscInt *q)
{
  for (int i = 0; i < n; i++)
    if (p[i] != q[i]) return p[i] < q[i] ? -1 : 1;
  return 0;
}
/* Compare two structs for qsort by the integer, or the two integers, that they begin with. */
static inline int OrderByFirst(const void *a, const void *b)
{
  return OrderInts(1, a, b);
}
static inline int OrderByPair(const void *a, const void *b)
{
  return OrderInts(2, a, b);
}
/* Makes room for one more item of `size` bytes behind the n items of a list: a full one doubles. array: the
   address of a pointer from PetscMalloc, or to NULL. */
static inline PetscErrorCode MakeRoom(size_t size, PetscInt n, PetscInt *capacity, void *array)
{
  PetscFunctionBeginUser;
  if (n < *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = 2 * *capacity + 64;
  PetscCall(PetscRealloc((size_t)*capacity * size, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}
/* Returns the ending of a noun after a count of n: "" or "s". */
static inline const char *Plural(PetscInt64 n)
{
  return n == 1 ? "" : "s";
}

/* ---- isa.c */
/* Collective. Sets instruction_set, by which hot loops choose their variant. Refuses a set that the
   processor lacks. file: name of the scene, for messages. */
PetscErrorCode IsaSelect(MPI_Comm comm, InstructionSet asked, const char *file);
const char *IsaName(void);                  /* of the set in use: base, v3 or v4 */
extern const char *const InstructionSets[]; /* PetscEnum-style names: widest base v3 v4 */

/* Returns the root of i in a forest of parents (union-find), and halves the path on the way. */
static inline PetscInt UnionRoot(PetscInt *parent, PetscInt i)
{
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/* Returns the first entry of a sorted array that does not come before `key`; n: all come before it. */
static inline PetscInt LowerBound(const void *key, const void *array, PetscInt n, size_t size,
                                  int (*order)(const void *, const void *))
{
  PetscInt low = 0, high = n;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;
    if (order((const char *)array + (size_t)middle * size, key) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* ---- hash.c */
/* Returns a hash in which every bit of x affects the whole word. */
uint64_t HashWord(uint64_t x);
/* Returns a checksum of the bytes. */
uint64_t HashBytes(uint64_t seed, const void *data, size_t bytes);

/* ---- timers.c */
/* Returns the processor time [s] of this thread; other programs on the machine do not count. */
double ProcessorSeconds(void);
/* Timers for -log_view and for the line about cost under each stage. The first ones belong to a cycle and
   run only in some cycles, chosen by TimerSample. */
typedef enum {
  TIMER_EXCHANGE,
  TIMER_CONTACTS,
  TIMER_BLOCKS,
  TIMER_RIGID,
  TIMER_SOLVES, /* with the factor, and the motion by it */
  TIMER_INTEGRATION,
  TIMER_DAMPING,
  TIMER_VERIFICATION, /* this timer and the following ones run every time; the next five are within it */
  TIMER_FAR_FACES,
  TIMER_NEAR_FACES,
  TIMER_FACE_CONTACTS,
  TIMER_VERTEX_CONTACTS,
  TIMER_HISTORY,
  TIMER_READING, /* this timer and the following ones belong to the set-up */
  TIMER_CHECKS,
  TIMER_ORDER,
  TIMER_PARTITION,
  TIMER_DISTRIBUTION,
  TIMER_MODEL,
  TIMER_FIRST_CONTACTS,
  TIMER_OUTPUT_START,
  TIMERS
} Timer;
PetscErrorCode TimerBegin(Timer part);
PetscErrorCode TimerEnd(Timer part);
void TimerSample(PetscInt64 cycle);
/* Prints the shares on rank 0 since the last report, then sets them to zero. */
PetscErrorCode TimerReport(MPI_Comm comm, PetscInt64 cycles);
/* Prints the shares of the set-up until the first cycle, as TimerReport. */
PetscErrorCode TimerReportSetUp(MPI_Comm comm);

/* ---- rows.c */
/* Collective. Gathers rows of all ranks on rank 0, in the order of ranks; NULL elsewhere. unit: bytes of a
   row. */
PetscErrorCode GatherBytes(MPI_Comm comm, PetscInt n, size_t unit, const void *rows, PetscInt *n_all,
                           void **all);
/* Does the same, and frees the rows, which are from PetscMalloc; one rank keeps them where they are. */
PetscErrorCode GatherAndFree(MPI_Comm comm, PetscInt n, size_t unit, void *rows, PetscInt *n_all, void **all);
/* Collective. Gathers the rows of all ranks on every rank. *all is from PetscMalloc. */
PetscErrorCode GatherToAll(MPI_Comm comm, PetscInt n, size_t unit, const void *rows, PetscInt *n_all,
                           void **all);
/* Collective. Gathers the rows of all ranks on every rank, in the given order, and frees `rows`. rows, *all:
   from PetscMalloc. */
PetscErrorCode GatherSorted(MPI_Comm comm, PetscInt n, size_t unit, void *rows,
                            int (*order)(const void *, const void *), PetscInt *n_all, void **all);
/* Collective. Gathers rows on rank 0 into given places. place: (n,) row of the result for each of the n rows;
   rows that no rank has are zero. unit: bytes of a row. *all: (n_all,) on rank 0, from PetscMalloc. */
PetscErrorCode GatherPlaced(MPI_Comm comm, PetscInt n, const PetscInt *place, size_t unit, const void *rows,
                            PetscInt n_all, void *all);

/* ---- binned_sums.c */
/* Collective. Sums terms by slot, with the same bits in any order and on any number of ranks. slot, term:
   (n,). sum: (n_slots,) the same on all ranks; NaN if a term is not finite. */
PetscErrorCode BinnedSums(MPI_Comm comm, PetscInt n, const PetscInt *slot, const PetscReal *term,
                          PetscInt n_slots, PetscReal *sum);

/* ---- files.c */
/* Makes a folder and its parents, as mkdir -p. Returns 0, or -1 and sets a message. */
int FolderMake(const char *path, char message[MESSAGE_LENGTH]);
/* Locks a folder against other runs until FolderUnlock or the end of the process. Returns 0; FOLDER_TAKEN
   if another run has the lock, -1 if the folder cannot be written, both with a message. */
enum { FOLDER_TAKEN = -2 };
int FolderLock(const char *folder, char message[MESSAGE_LENGTH]);
void FolderUnlock(const char *folder, int lock);
/* Opens folder/name.part for writing. */
FILE *PartOpen(const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* Closes folder/name.part and renames it to folder/name once it is on the disk and no message is set. */
void PartFinish(FILE *f, const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* Writes folder/name with this text, then the CRC-32 of the text between `before` and `after`. */
void PartText(const char *folder, const char *name, const char *text, size_t size, const char *before,
              const char *after, char message[MESSAGE_LENGTH]);
/* Renames a .part file that is already on the disk. */
void PartRename(const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* Flushes a folder to the disk, so that a renaming survives a loss of power. Returns 0 or errno. */
int FolderSync(const char *path);
/* Decides, after a failed read with errno `why`, whether the file exists all the same. Sets a message
   then: an unreadable file must not be replaced. */
PetscBool FileUnreadable(const char *path, int why, char message[MESSAGE_LENGTH]);
/* Copies a file. Returns 0 or -1. */
int FileCopy(const char *from, const char *to);
/* Computes the CRC-32 (of zlib) of the first bytes of a file. Returns 0, or -1: the file is shorter (errno
   0) or cannot be read (errno). */
int FileChecksum(const char *path, size_t bytes, uint64_t *checksum);

/* ---- json.c */
enum { JSON_LEVELS = 16, JSON_PATH = 1024 };

/* JSON that is being written. Paths begin in the object that is opened first. */
typedef struct {
  FILE *file;              /* NULL: nothing is written, and questions are answered */
  size_t size;             /* [byte] of the text in memory */
  int level, lists;        /* number of objects and lists that are open; of lists */
  char last[JSON_LEVELS];  /* last character of each */
  size_t end[JSON_LEVELS]; /* length of the path of each */
  PetscBool has_member;    /* the object or list that was opened last has a member */
  const char *waiting;     /* name of the object that JsonOpenLater has announced, or NULL */
  PetscInt n_asked;        /* number of questions */
  char *const *asked;      /* (n_asked,) path of a number; numbers in lists have none */
  PetscReal *answers;      /* (n_asked,) receives the number; unchanged: there is none. NaN: null */
  char path[JSON_PATH];    /* of the last member, while there are questions */
} Json;
/* Starts a text in memory, which JsonEnd completes; free it with free(). level: of the first member. */
PetscErrorCode JsonToMemory(Json *json, int level, char **text);
PetscErrorCode JsonEnd(Json *json);
/* Begins an object or a list (JsonList), which JsonClose ends. name: NULL in a list. An object of
   JsonOpenLater is left out if it has no member. */
void JsonOpen(Json *json, const char *name);
void JsonOpenLater(Json *json, const char *name);
void JsonList(Json *json, const char *name);
void JsonClose(Json *json);
/* Writes a member: a value that is JSON; JsonText: a text; JsonHex: hexadecimal digits as a text;
   JsonNumber: a number, null if it is not finite. */
void JsonValue(Json *json, const char *name, const char *value);
void JsonText(Json *json, const char *name, const char *value);
void JsonHex(Json *json, const char *name, int digits, uint64_t value);
void JsonNumber(Json *json, const char *name, PetscReal value);
/* Write numbers as members, or an object that has these alone: JsonNumbers(json, {"x", x}, {"y", y}). */
typedef struct {
  const char *name;
  PetscReal value;
} JsonPair;
void JsonPairs(Json *json, size_t n, const JsonPair *pairs);
#define JsonNumbers(json, ...)                                                                               \
  JsonPairs(json, sizeof((JsonPair[]){__VA_ARGS__}) / sizeof(JsonPair), (const JsonPair[]){__VA_ARGS__})
#define JsonObject(json, name, ...) (JsonOpen(json, name), JsonNumbers(json, __VA_ARGS__), JsonClose(json))

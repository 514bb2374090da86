/* archive.h: declares archives, which store the whole state of a run independently of the number of ranks.

   An archive is a list of named arrays on rank 0. One function describes each part of the program's state
   for both directions: it gathers while the archive is written and scatters while it is read. So the
   program reads exactly what it writes. Whoever adds a member to a struct adds one line to its function.
   Degrees of freedom are stored by the gid of their vertex or body, contacts by their key, so an archive
   may be read on any number of ranks and on any partition. */
#pragma once
#include "model/model.h"
#include "result/stage/stage_result.h"

/* ---- archive.c */
typedef enum { ARCHIVE_REAL, ARCHIVE_COUNT, ARCHIVE_TEXT } ArchiveKind; /* double, int64, char */
typedef struct {
  char name[2 * NAME_LENGTH]; /* checkpoint part/name */
  ArchiveKind kind;
  size_t rows, columns;
  void *data; /* (rows, columns) */
} ArchiveEntry;
typedef struct _p_Archive {
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool reading;
  PetscBool digest;       /* written for a checksum: omits what is no state of the structure (sums over ranks,
                       whose last digits depend on the number of ranks, and tallies) */
  char part[NAME_LENGTH]; /* checkpoint part to which names belong */
  PetscInt n;             /* rank 0 */
  ArchiveEntry *entries;  /* (n,) rank 0 */
  uint64_t checksum;      /* of the file that was read; rank 0 */
  char message[MESSAGE_LENGTH]; /* rank 0: the first entry that is missing or has another size */
} Archive;
/* Collective. Creates an empty archive for writing. */
PetscErrorCode ArchiveCreate(MPI_Comm comm, Archive *archive);
PetscErrorCode ArchiveDestroy(Archive *archive);
/* Rank 0. Returns the entry of a name in the current part, or NULL. */
ArchiveEntry *ArchiveFind(const Archive *archive, const char *name);
/* Rank 0. Adds an entry and takes over data, which is from PetscMalloc. */
PetscErrorCode ArchiveAdd(Archive *archive, const char *name, ArchiveKind kind, size_t rows, size_t columns,
                          void *data);
/* Collective. Decides whether the archive has entries of a checkpoint part. */
PetscErrorCode ArchiveHasPart(const Archive *archive, const char *part, PetscBool *has);
/* Writes or reads (n,) values that are the same on all ranks; so do the next two functions. All functions
   from here to ArchiveResult but ArchiveDigest and ArchiveWithin are collective; the archive decides whether
   they write or read. */
PetscErrorCode ArchiveReals(Archive *archive, const char *name, PetscInt n, PetscReal *x);
PetscErrorCode ArchiveInts(Archive *archive, const char *name, PetscInt n, PetscInt *x);
PetscErrorCode ArchiveCounts(Archive *archive, const char *name, PetscInt n, PetscInt64 *x);
/* Write or read members of structs as one array: ArchiveRealMembers(a, "reals", &s->dt, &s->alpha), and
   ArchiveIntMembers(a, "counts", INT_MEMBER(s->cycle), INT_MEMBER(s->turn)) for integers of any length. */
PetscErrorCode ArchiveRealsAt(Archive *archive, const char *name, size_t n, PetscReal *const members[]);
#define ArchiveRealMembers(archive, name, ...)                                                               \
  ArchiveRealsAt(archive, name, sizeof((PetscReal *[]){__VA_ARGS__}) / sizeof(PetscReal *),                  \
                 (PetscReal *const[]){__VA_ARGS__})
typedef struct {
  void *at;
  size_t size; /* [bytes] */
} IntMember;
PetscErrorCode ArchiveIntsAt(Archive *archive, const char *name, size_t n, const IntMember *members);
#define INT_MEMBER(x)                                                                                        \
  {                                                                                                          \
    &(x), sizeof(x)                                                                                          \
  }
#define ArchiveIntMembers(archive, name, ...)                                                                \
  ArchiveIntsAt(archive, name, sizeof((IntMember[]){__VA_ARGS__}) / sizeof(IntMember),                       \
                (const IntMember[]){__VA_ARGS__})
/* Writes or reads integers that count the work of a solver. They are not part of the digest. */
PetscErrorCode ArchiveTally(Archive *archive, const char *name, PetscInt n, PetscInt *x);
/* Rank 0. Returns the sum of a hash of (name, bits) over all entries. Entries with zeros only do not
   count. */
uint64_t ArchiveDigest(const Archive *archive);
/* Returns a number just read, the same on all ranks. Outside low .. high it sets a message and returns
   low. */
PetscInt64 ArchiveWithin(Archive *archive, const char *what, PetscInt64 x, PetscInt64 low, PetscInt64 high);
/* Sums over ranks: rank 0 reads the sum, the others read 0. */
PetscErrorCode ArchiveSums(Archive *archive, const char *name, PetscInt n, PetscReal *x);
/* Writes or reads partial sums of each rank, (n,). On the same number of ranks with as many numbers each,
   every rank reads its own back (mine is set), so later sums have the same bits. Otherwise x keeps the
   values of ArchiveSums, which agree but for rounding. */
PetscErrorCode ArchiveSummands(Archive *archive, const char *name, PetscInt n, PetscReal *x, PetscBool *mine);
/* Writes or reads a text of rank 0, from malloc (NULL elsewhere, and when empty). Reading frees the old
   text. */
PetscErrorCode ArchiveText(Archive *archive, const char *name, char **text);
/* Writes or reads (n_dof,) values at this rank's degrees of freedom. */
PetscErrorCode ArchiveDofs(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* Writes or reads (3 rigid.n + 2 n_owned,) values at the degrees of freedom of all owned vertices, inner
   ones included. */
PetscErrorCode ArchiveApplied(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* Writes or reads a Vec of the state (call StateGive before). inner: followed by the entries of all owned
   vertices. */
PetscErrorCode ArchiveVec(Archive *archive, const Model *model, const char *name, PetscBool inner, Vec vec);
/* Writes or reads (n_owned,2) values at owned vertices. */
PetscErrorCode ArchiveVertices(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* Writes or reads (n,width) values of owned blocks with these gids. */
PetscErrorCode ArchiveBlocks(Archive *archive, const Model *model, const char *name, PetscInt n,
                             const PetscInt *gid, PetscInt width, PetscReal *x);
PetscErrorCode ArchiveEffort(Archive *archive, Effort *effort);
/* Writes or reads the result of the current stage. */
PetscErrorCode ArchiveResult(Archive *archive, const char *name, StageResult *result);

/* ---- archive_file.c */
/* Rank 0. Writes path.part in the folder, reads it back, compares, and renames it to path. Makes the folder
   where it is missing, again if it was removed meanwhile. Frees the data of the entries. */
PetscErrorCode ArchiveWriteFile(Archive *archive, const char *folder, const char *path,
                                char message[MESSAGE_LENGTH]);
/* Reads a file whose checksum is right; refuses any other file. */
PetscErrorCode ArchiveReadFile(Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* Writes the header of a file, the bytes before its HDF5 image. bytes, checksum: length and HashBytes of
   the image. */
enum { ARCHIVE_HEADER = 512 };
void ArchiveHeader(uint64_t bytes, uint64_t checksum, const char *version, char header[ARCHIVE_HEADER]);

/* ---- checkpoint.c: writing checkpoints, and restarting from them.

   The owner of a state attaches it as a part, with the function that describes it (archive.h), while the
   state exists. A checkpoint consists of all attached parts. After a restart a part is read back when it
   is attached: the program passes through stages and trials as usual, and each part with `resumed` set
   continues where it was. */
typedef PetscErrorCode (*ArchiveFunction)(Archive *archive, void *context);
typedef struct {
  char name[NAME_LENGTH];
  ArchiveFunction function;
  void *context;
} CheckpointPart;
enum { MOST_PARTS = 8 };
typedef struct _p_Checkpoint {
  MPI_Comm comm;
  PetscMPIInt rank;
  const Scene *scene;
  uint64_t mesh;                   /* checksum of the block mesh; rank 0 */
  char folder[PETSC_MAX_PATH_LEN]; /* <output>/checkpoints */
  char last[PETSC_MAX_PATH_LEN];   /* newest good checkpoint of this run; "": none */
  PetscInt number;                 /* number of the newest checkpoint, -1: none; rank 0 */
  PetscInt n_parts;
  CheckpointPart parts[MOST_PARTS];
  Archive resume; /* entries of the restart that no part has read back yet */
  PetscBool resuming;
  uint64_t branch;       /* checksum of changed options and checkpoint, for a restart with other options;
                            0: unchanged; rank 0 */
  PetscInt64 last_cycle; /* time of the last checkpoint: [cycles], and [s] of MPI_Wtime */
  double last_wall, start_wall, poll_wall;
  PetscBool limit_near; /* the limit of wall time is near */
  double write_wall;    /* [s] duration of the last writing */
} Checkpoint;
/* Catches signals until the next check of the run (CheckpointPoll). Call again after a library has
   replaced the handlers. */
void SignalsCatch(void);
/* Restores the default signals, which end the program; for runs that write nothing. */
void SignalsRelease(void);
/* Collective. Creates the checkpoints of a run after the scene has been read. mesh: its checksum, on rank
   0. */
PetscErrorCode CheckpointCreate(MPI_Comm comm, const Scene *scene, uint64_t mesh, Checkpoint *checkpoint);
/* Rank 0. Returns the identity of a run: a checksum of its block mesh and its options, without those that
   change no result. */
uint64_t CheckpointRun(const Checkpoint *checkpoint);
/* Rank 0. Returns the identity of a run that restarts from a checkpoint of `run`: `run` itself, or, if
   options that change results differ, a checksum of this checkpoint and these options. */
uint64_t CheckpointGoesOn(const Checkpoint *checkpoint, uint64_t run);
PetscErrorCode CheckpointDestroy(Checkpoint *checkpoint);
/* Collective. Reads the checkpoint that scene->restart names; does nothing if it is empty. Refuses a
   damaged file, another mesh and another version; reports changed options. */
PetscErrorCode CheckpointRestart(Checkpoint *checkpoint);
/* Collective. Refuses like Refuse, and names the last good checkpoint. */
PetscErrorCode CheckpointRefuse(const Checkpoint *checkpoint, PetscErrorCode code, const char *message);
/* Collective. Attaches a part. resumed receives whether its state was read back. */
PetscErrorCode CheckpointAttach(Checkpoint *checkpoint, const char *name, ArchiveFunction function,
                                void *context, PetscBool *resumed);
/* Removes the part attached last. */
PetscErrorCode CheckpointDetach(Checkpoint *checkpoint);
/* Collective. Writes all parts to a new file and removes the oldest files. */
PetscErrorCode CheckpointWrite(Checkpoint *checkpoint, PetscInt64 cycle);
/* Collective, between two cycles. Writes a checkpoint when it is due or a signal asks for one. If a signal
   or the limit of wall time asks for a stop, sets the verdict to stopped after the checkpoint. */
PetscErrorCode CheckpointPoll(Checkpoint *checkpoint, PetscInt64 cycle, StageResult *result);
/* Collective. Decides whether the next CheckpointPoll will stop the run; for places where nothing can be
   written, as within an increment of Newton's method. */
PetscErrorCode CheckpointStop(Checkpoint *checkpoint, PetscBool *stop);
/* Collective. Writes a checkpoint where the scene has any during a stage: a method that costs little hands
   over to one that costs much. */
PetscErrorCode CheckpointNow(Checkpoint *checkpoint, PetscInt64 cycle);

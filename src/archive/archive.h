/* archive.h: everything a run must remember, by numbers that do not depend on the ranks.

   An archive is a list of named arrays on rank 0. One function describes each part of the program's memory,
   for both directions: while the archive is written it gathers, while the archive is read it scatters. So the
   program reads exactly what it writes, and whoever adds memory to a struct adds one line to its function.
   Degrees of freedom go by the gid of their vertex or body, contacts by their key, so an archive may be read
   on any number of ranks and on any partition. */
#pragma once
#include "model/model.h"

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
  PetscBool anew;   /* reading goes on in the same run, on another partition: arrays of the size of a rank's
                     model must be made anew, and clocks go on */
  PetscBool digest; /* written for a checksum: what is no state of the structure is left out (sums over ranks,
                       whose last digits hang on their number, and tallies) */
  char part[NAME_LENGTH];       /* checkpoint part below which names are taken */
  PetscInt n;                   /* rank 0 */
  ArchiveEntry *entries;        /* (n,) rank 0 */
  uint64_t checksum;            /* checksum of the file that the archive was read from; rank 0 */
  char message[MESSAGE_LENGTH]; /* rank 0: the first entry to be read that is missing or of another size */
} Archive;
/* Collective. Makes an empty archive for writing. */
PetscErrorCode ArchiveCreate(MPI_Comm comm, Archive *archive);
PetscErrorCode ArchiveDestroy(Archive *archive);
/* Rank 0. The entry of a name (with its checkpoint part), NULL: there is none. */
ArchiveEntry *ArchiveFind(const Archive *archive, const char *name);
/* Rank 0. Adds an entry, which takes over data, from PetscMalloc. */
PetscErrorCode ArchiveAdd(Archive *archive, const char *name, ArchiveKind kind, size_t rows, size_t columns,
                          void *data);
/* Collective. Whether the archive has entries of a checkpoint part. */
PetscErrorCode ArchiveHasPart(const Archive *archive, const char *part, PetscBool *has);
/* These functions are collective and go in either direction. Values that all ranks share: (n,). */
PetscErrorCode ArchiveReals(Archive *archive, const char *name, PetscInt n, PetscReal *x);
PetscErrorCode ArchiveInts(Archive *archive, const char *name, PetscInt n, PetscInt *x);
PetscErrorCode ArchiveCounts(Archive *archive, const char *name, PetscInt n, PetscInt64 *x);
/* Ints that count what a solver has done. */
PetscErrorCode ArchiveTally(Archive *archive, const char *name, PetscInt n, PetscInt *x);
/* Rank 0. Sum of a hash of (name, bits) of all entries; one without a number but 0 does not count. */
uint64_t ArchiveDigest(const Archive *archive);
/* A number that has just been read, alike on all ranks; where it is not one of low .. high that is told and
   it is low. */
PetscInt64 ArchiveWithin(Archive *archive, const char *what, PetscInt64 x, PetscInt64 low, PetscInt64 high);
/* Sums over ranks: rank 0 reads the sum, the other ranks read 0. */
PetscErrorCode ArchiveSums(Archive *archive, const char *name, PetscInt n, PetscReal *x);
/* What each rank has added up so far, (n,). On the same number of ranks, each with as many numbers, every
   rank reads its own back (mine), so later sums have the same bits. Otherwise x keeps what ArchiveSums has
   read, which is right but for rounding. */
PetscErrorCode ArchiveSummands(Archive *archive, const char *name, PetscInt n, PetscReal *x, PetscBool *mine);
/* Text of rank 0, from malloc (NULL elsewhere, and when empty). Reading frees the old text. */
PetscErrorCode ArchiveText(Archive *archive, const char *name, char **text);
/* (n_dof,) values at this rank's degrees of freedom. */
PetscErrorCode ArchiveDofs(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* (3 n_bodies + 2 n_owned,) values at the degrees of freedom of all owned vertices, inner ones included. */
PetscErrorCode ArchiveApplied(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* A Vec of the state (StateGive before); inner: with the entries of all owned vertices, behind its own. */
PetscErrorCode ArchiveVec(Archive *archive, const Model *model, const char *name, PetscBool inner, Vec vec);
/* (n_owned,2) values at owned vertices. */
PetscErrorCode ArchiveVertices(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* (n,width) values at blocks of these gids: all that the ranks own. */
PetscErrorCode ArchiveBlocks(Archive *archive, const Model *model, const char *name, PetscInt n,
                             const PetscInt *gid, PetscInt width, PetscReal *x);
PetscErrorCode ArchiveEffort(Archive *archive, Effort *effort);
/* The result of a stage so far. */
PetscErrorCode ArchiveResult(Archive *archive, const char *name, StageResult *result);

/* ---- archive_file.c */
/* Writes path.part, reads it back, compares, and renames it to path. */
PetscErrorCode ArchiveWriteFile(const Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* Reads a file whose checksum is right; refuses any other file. */
PetscErrorCode ArchiveReadFile(Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* The bytes before the HDF5 image of such a file. bytes, checksum: length and HashBytes of the image. */
enum { ARCHIVE_HEADER = 512 };
void ArchiveHeader(uint64_t bytes, uint64_t checksum, const char *version, char header[ARCHIVE_HEADER]);

/* ---- checkpoint.c: when the run is written down, and how it goes on from there.

   Whoever holds memory of the run on its way attaches it as a part, with the function that describes it
   (archive.h), for as long as it lives. A checkpoint is all parts that are attached. After a restart the part
   finds its memory again the moment it is attached: the program takes its usual way through stages and
   trials, and each part that is told `resumed` goes on where it was instead of starting anew. */
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
  PetscInt number;                 /* number of that checkpoint, -1: none is written yet; rank 0 */
  PetscInt n_parts;
  CheckpointPart parts[MOST_PARTS];
  Archive resume; /* what a restart has read and the run has not taken back yet */
  PetscBool resuming;
  uint64_t branch;       /* a restart with other options: of these and of its checkpoint; 0: none; rank 0 */
  PetscInt64 last_cycle; /* when the last one was written: [cycles], and [s] of MPI_Wtime */
  double last_wall, start_wall, poll_wall;
  PetscBool limit_near;               /* the run has seen that the limit of wall time comes */
  double write_wall;                  /* [s] that writing took */
  struct _p_Repartition *repartition; /* stages.h; NULL: none */
} Checkpoint;
/* From now on signals wait for the next look of the run (CheckpointPoll). Call again after a library has
   taken them. */
void SignalsCatch(void);
/* From now on signals end the program; for runs that write nothing. */
void SignalsLetGo(void);
/* Collective. Call when the scene has been read. mesh: its checksum, on rank 0. */
PetscErrorCode CheckpointCreate(MPI_Comm comm, const Scene *scene, uint64_t mesh, Checkpoint *checkpoint);
/* Rank 0. The number of a run, by its block mesh and its options, without options that change no result. */
uint64_t CheckpointRun(const Checkpoint *checkpoint);
/* Rank 0. The number of the run that goes on from a checkpoint of `run`: `run` itself, or, where options that
   change results differ from the checkpoint's, a number for this checkpoint with these options. */
uint64_t CheckpointGoesOn(const Checkpoint *checkpoint, uint64_t run);
PetscErrorCode CheckpointDestroy(Checkpoint *checkpoint);
/* Collective. Reads what scene->restart names, and does nothing if that is empty. Refuses a damaged file,
   another mesh and another version; says which options have changed. */
PetscErrorCode CheckpointRestart(Checkpoint *checkpoint);
/* Collective. As Refuse, but the line also names the last good checkpoint. */
PetscErrorCode CheckpointRefuse(const Checkpoint *checkpoint, PetscErrorCode code, const char *message);
/* Collective. Adds a checkpoint part. resumed: the part's memory has been read back. */
PetscErrorCode CheckpointAttach(Checkpoint *checkpoint, const char *name, ArchiveFunction function,
                                void *context, PetscBool *resumed);
/* Removes the part that was attached last. */
PetscErrorCode CheckpointDetach(Checkpoint *checkpoint);
/* Collective. Writes all parts to a new file and removes the oldest files. */
PetscErrorCode CheckpointWrite(Checkpoint *checkpoint, PetscInt64 cycle);
/* Collective. Writes all parts into memory, calls renew, and reads all parts back. renew may build anew what
   has the size of a rank's model; archive->anew tells the parts so. */
PetscErrorCode CheckpointThrough(Checkpoint *checkpoint, PetscErrorCode (*renew)(void *context),
                                 void *context);
/* Collective, between two cycles. Writes a checkpoint when it is time or a signal asks for one. When a signal
   or the limit of wall time asks for a stop, the stop becomes the verdict, after the checkpoint. */
PetscErrorCode CheckpointPoll(Checkpoint *checkpoint, PetscInt64 cycle, StageResult *result);
/* Collective. Whether the next CheckpointPoll will stop the run; for places where nothing can be written, as
   within an increment of Newton's method. */
PetscErrorCode CheckpointStop(Checkpoint *checkpoint, PetscBool *stop);

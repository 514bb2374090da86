/* archive.h: everything a run must remember, by numbers that do not depend on the ranks.

   An archive is a list of named arrays on rank 0. One function describes each part of the program's memory,
   for both directions: called while the archive is being written it gathers, while it is being read it
   scatters. So what is written is what is read, and whoever adds memory to a struct adds one line to its
   function. Degrees of freedom go by the gid of their vertex or body, contacts by key: an archive may be read
   on any number of ranks and on any partition. */
#pragma once
#include "model/model.h"

/* ---- archive.c */
typedef enum { ARCHIVE_REAL, ARCHIVE_COUNT, ARCHIVE_TEXT } ArchiveKind; /* double, int64, char */
typedef struct {
  char name[2 * NAME_LENGTH]; /* part/name */
  ArchiveKind kind;
  size_t rows, columns;
  void *data; /* (rows, columns) */
} ArchiveEntry;
typedef struct _p_Archive {
  MPI_Comm comm;
  PetscMPIInt rank;
  PetscBool reading;
  PetscBool anew; /* reading in the same run, onto another partition: arrays that a rank's model measures must
                     be made anew; clocks go on */
  char part[NAME_LENGTH]; /* names are taken below it */
  PetscInt n;             /* rank 0 */
  ArchiveEntry *entries;  /* (n,) rank 0 */
  uint64_t checksum;      /* of the file it was read from; rank 0 */
  char
      message[MESSAGE_LENGTH]; /* rank 0: first thing that was to be read and is missing or of another size */
} Archive;
/* Collective. An empty archive, to be written. */
PetscErrorCode ArchiveCreate(MPI_Comm comm, Archive *archive);
PetscErrorCode ArchiveDestroy(Archive *archive);
/* Rank 0. The entry of a name (with its part), NULL: there is none. */
ArchiveEntry *ArchiveFind(const Archive *archive, const char *name);
/* Rank 0. Adds an entry; takes data, from PetscMalloc. */
PetscErrorCode ArchiveAdd(Archive *archive, const char *name, ArchiveKind kind, size_t rows, size_t columns,
                          void *data);
/* Collective. Whether the archive holds anything of a part. */
PetscErrorCode ArchiveHasPart(const Archive *archive, const char *part, PetscBool *has);
/* All collective, in either direction. Values that are alike on all ranks: (n,). */
PetscErrorCode ArchiveReals(Archive *archive, const char *name, PetscInt n, PetscReal *x);
PetscErrorCode ArchiveInts(Archive *archive, const char *name, PetscInt n, PetscInt *x);
PetscErrorCode ArchiveCounts(Archive *archive, const char *name, PetscInt n, PetscInt64 *x);
/* Sums over ranks: what is read goes to rank 0, the others get 0. */
PetscErrorCode ArchiveSums(Archive *archive, const char *name, PetscInt n, PetscReal *x);
/* What each rank has added up so far (n,). Read on as many ranks, each with as many numbers, it is as it was
   (mine), and later sums have the same bits; else x stays: what ArchiveSums has read is right but for
   rounding. */
PetscErrorCode ArchiveSummands(Archive *archive, const char *name, PetscInt n, PetscReal *x, PetscBool *mine);
/* Text of rank 0, from malloc (NULL elsewhere and when empty); what was there before is freed. */
PetscErrorCode ArchiveText(Archive *archive, const char *name, char **text);
/* (n_dof,) of this rank's degrees of freedom. */
PetscErrorCode ArchiveDofs(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* (3 n_bodies + 2 n_owned,): likewise, with all owned vertices. */
PetscErrorCode ArchiveApplied(Archive *archive, const Model *model, const char *name, PetscReal *x);
/* (n_owned,2) of owned vertices. */
PetscErrorCode ArchiveVertices(Archive *archive, const Model *model, const char *name, PetscReal *x);
PetscErrorCode ArchiveEffort(Archive *archive, Effort *effort);
/* What a stage has come to so far. */
PetscErrorCode ArchiveResult(Archive *archive, const char *name, StageResult *result);

/* ---- archive_file.c */
/* Writes path.part, reads it back, compares, and gives it its name. */
PetscErrorCode ArchiveWriteFile(const Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* Reads a file whose checksum is right; refuses every other. */
PetscErrorCode ArchiveReadFile(Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* The bytes before the HDF5 part of such a file, which has this length and HashBytes. */
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
  char last[PETSC_MAX_PATH_LEN];   /* newest good checkpoint of this run, "": none */
  PetscInt number;                 /* of that checkpoint, -1: none written yet; rank 0 */
  PetscInt n_parts;
  CheckpointPart parts[MOST_PARTS];
  Archive resume; /* what a restart has not taken back yet */
  PetscBool resuming;
  uint64_t branch;       /* a restart with other options: of these and of its checkpoint; 0: none; rank 0 */
  PetscInt64 last_cycle; /* when the last was written: [cycles], and [s] of MPI_Wtime */
  double last_wall, start_wall, poll_wall;
  PetscBool limit_near;               /* the limit of wall time has been seen to come */
  double write_wall;                  /* [s] that it took */
  struct _p_Repartition *repartition; /* stages.h; NULL: none */
} Checkpoint;
/* From now on signals wait for the next look of the run (CheckpointPoll). Again after a library has taken
   them. */
void SignalsCatch(void);
/* They end the program, where nothing is written. */
void SignalsLetGo(void);
/* Collective. Call when the scene is read. mesh: checksum, on rank 0. */
PetscErrorCode CheckpointCreate(MPI_Comm comm, const Scene *scene, uint64_t mesh, Checkpoint *checkpoint);
/* Rank 0. The same for runs of the same block mesh and options, those that change no result left out. */
uint64_t CheckpointRun(const Checkpoint *checkpoint);
/* Rank 0. The run that goes on from the checkpoint of `run` that was read: `run` itself; or, where options
   that change results are others than in it, one of its own, the same only from this checkpoint with them. */
uint64_t CheckpointGoesOn(const Checkpoint *checkpoint, uint64_t run);
PetscErrorCode CheckpointDestroy(Checkpoint *checkpoint);
/* Collective. Reads what scene->restart names; refuses what is damaged, of another mesh or of another
   version; says which options have changed. Nothing happens when it is empty. */
PetscErrorCode CheckpointRestart(Checkpoint *checkpoint);
/* Collective. As Refuse, with the last good checkpoint named. */
PetscErrorCode CheckpointRefuse(const Checkpoint *checkpoint, PetscErrorCode code, const char *message);
/* Collective. Adds a part; resumed: its memory has been read back. */
PetscErrorCode CheckpointAttach(Checkpoint *checkpoint, const char *name, ArchiveFunction function,
                                void *context, PetscBool *resumed);
/* The part attached last is over. */
PetscErrorCode CheckpointDetach(Checkpoint *checkpoint);
/* Collective. Writes all parts to a new file, the oldest files give way. */
PetscErrorCode CheckpointWrite(Checkpoint *checkpoint, PetscInt64 cycle);
/* Collective. All parts into memory; renew, which may build anew what has the size of a rank's model; all
   parts back. Parts are told by archive->anew. */
PetscErrorCode CheckpointThrough(Checkpoint *checkpoint, PetscErrorCode (*renew)(void *context),
                                 void *context);
/* Collective. Between two cycles: writes a checkpoint when it is time, or when a signal asks for it; a stop
   that a signal or the limit of wall time asks for becomes the verdict, after the checkpoint. */
PetscErrorCode CheckpointPoll(Checkpoint *checkpoint, PetscInt64 cycle, StageResult *result);
/* Collective. Where nothing can be written down, as within an increment of Newton's method: whether the next
   CheckpointPoll is going to stop the run. */
PetscErrorCode CheckpointStop(Checkpoint *checkpoint, PetscBool *stop);

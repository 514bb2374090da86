/* checkpoint.h: when the run is written down, and how it goes on from there.

   Whoever holds memory of the run on its way attaches it as a part, with the function that describes it
   (archive.h), for as long as it lives. A checkpoint is all parts that are attached. After a restart the part
   finds its memory again the moment it is attached: the program takes its usual way through stages and
   trials, and each part that is told `resumed` goes on where it was instead of starting anew. */
#pragma once
#include "archive/archive.h"

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
  struct _p_Repartition *repartition; /* repartition.h; NULL: none */
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

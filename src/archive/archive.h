/* archive.h: everything a run must remember, by numbers that do not depend on the ranks.

   An archive is a list of named arrays on rank 0. One function describes each part of the program's memory,
   for both directions: called while the archive is being written it gathers, while it is being read it
   scatters. So what is written is what is read, and whoever adds memory to a struct adds one line to its
   function. Degrees of freedom go by the gid of their vertex or body, contacts by key: an archive may be read
   on any number of ranks and on any partition. */
#pragma once
#include "internal.h"

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
/* Contacts with their history and last evaluation. Reading replaces those there are; model->faces must be
   those of the displacements where contacts were last verified (StateArchive sees to it). */
PetscErrorCode ArchiveContacts(Archive *archive, const Scene *scene, const Model *model, const char *name,
                               Contacts *contacts);
PetscErrorCode ArchiveEffort(Archive *archive, Effort *effort);
/* What a stage has come to so far. */
PetscErrorCode ArchiveResult(Archive *archive, const char *name, StageResult *result);

/* Collective. Faces and ghosts of model as they are where the dofs have displacements u (n_dof,); the state
   keeps its own. Local numbers of vertices in contacts hold where the contacts were found. */
PetscErrorCode NeighboursAt(Model *model, State *state, const PetscReal *u);
/* The state of a run: State, Contacts, and what of Model follows the motion. */
PetscErrorCode StateArchive(Archive *archive, const Scene *scene, Model *model, State *state,
                            Contacts *contacts);

/* ---- checkpoint_file.c: rank 0; message receives the first fault */
/* Writes path.part, reads it back, compares, and gives it its name. */
PetscErrorCode ArchiveWriteFile(const Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* Reads a file whose checksum is right; refuses every other. */
PetscErrorCode ArchiveReadFile(Archive *archive, const char *path, char message[MESSAGE_LENGTH]);
/* The bytes before the HDF5 part of such a file, which has this length and HashBytes. */
enum { ARCHIVE_HEADER = 512 };
void ArchiveHeader(uint64_t bytes, uint64_t checksum, const char *version, char header[ARCHIVE_HEADER]);

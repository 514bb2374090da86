/* base.h: what every room uses: PETSc as it is here, errors, names, checksums, timers, files.

   Functions return a PETSc error code. "Collective" is said where it holds; all else is local to the rank.

   Conventions, stated once (tests/unit/test_conventions.c holds them):
   - SI units: m, N, Pa, kg, s; two dimensions, loads per metre of thickness times `thickness`.
   - Stress: tension positive. Contact opening u_n: positive when the faces part; sigma = k_n u_n.
   - Blocks run counter-clockwise; face k of a block runs from its vertex k to vertex k+1; its outward normal
     is to the right of that direction.
   - f is the RESISTING nodal force (what the model pushes back with: f = +int B'sigma dA for blocks), so the
     unbalanced force is r = f_ext - f. The paper's (8) and (10) use opposite signs; this is ours everywhere.
   - gid: number of a vertex, block or face in Quoin's own global order (bandwidth-reducing, the same for
     every number of ranks). Every sum over elements, contacts and bodies runs in ascending gid, so that
     results have the same bits on any number of ranks. "file id": the number in model.h5. */
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
/* PETSc 3.18 and what has changed since */
#if !defined(PETSC_SUCCESS) && PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#endif
#if PETSC_VERSION_LT(3, 22, 0)
typedef size_t SegmentCount; /* of a PetscSegBuffer */
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
  MESSAGE_LENGTH = 1024 /* of one error line */
};

typedef enum { ISA_WIDEST, ISA_BASE, ISA_V3, ISA_V4 } InstructionSet; /* of x86-64 */

/* ---- error.c */
/* Collective. message: what is wrong, as found by rank 0 or any rank ("" where nothing is); fails on all
   ranks with the message of the lowest rank that has one. */
PetscErrorCode CheckMessage(MPI_Comm comm, const char *message);
/* The same for reasons of other kinds, each with an exit code of its own. */
#define ERROR_OUTPUT PETSC_ERR_FILE_WRITE          /* what the run is to write cannot be written */
#define ERROR_LOCKED PETSC_ERR_FILE_OPEN           /* another run writes into the output folder */
#define ERROR_CHECKPOINT PETSC_ERR_FILE_UNEXPECTED /* a restart is not possible */
#define ERROR_MEMORY PETSC_ERR_MEM                 /* the model needs more memory than there is */
PetscErrorCode Refuse(MPI_Comm comm, PetscErrorCode code, const char *message);
PetscErrorCode QuoinErrorHandlerPush(void);
/* Whether all ranks return this error, so that the program can end in order. */
PetscBool QuoinErrorIsShared(PetscErrorCode error);

/* ---- names.c */
/* Row of a name in a list, -1: it is not there. */
PetscInt NameRow(PetscInt n, char (*names)[NAME_LENGTH], const char *name);
/* What follows a noun after a count of n. */
static inline const char *Plural(PetscInt64 n)
{
  return n == 1 ? "" : "s";
}

/* ---- isa.c */
/* Collective. Sets instruction_set, on which hot loops branch; refuses one that the processor has not.
   file: of the scene, for messages. */
PetscErrorCode IsaSelect(MPI_Comm comm, InstructionSet asked, const char *file);
const char *IsaName(void);                  /* of what is set: base, v3 or v4 */
extern const char *const InstructionSets[]; /* PetscEnum-style names: widest base v3 v4 */

/* ---- hash.c */
/* Spreads every bit of a number over the word. */
uint64_t HashWord(uint64_t x);
/* Any change of a bit changes it. */
uint64_t HashBytes(uint64_t seed, const void *data, size_t bytes);

/* ---- parts.c */
/* Parts of a cycle, for -log_view and for the line about cost under each stage. Sampled:
   PartSample says which cycles. */
typedef enum {
  PART_EXCHANGE,
  PART_CONTACTS,
  PART_BLOCKS,
  PART_RIGID,
  PART_INTEGRATION,
  PART_DAMPING,
  PART_REPARTITION,  /* from here on timed whole */
  PART_VERIFICATION, /* the next five are parts of it */
  PART_FAR_FACES,
  PART_NEAR_FACES,
  PART_FACE_CONTACTS,
  PART_VERTEX_CONTACTS,
  PART_HISTORY,
  PART_READING, /* from here on set-up */
  PART_CHECKS,
  PART_ORDER,
  PART_PARTITION,
  PART_DISTRIBUTION,
  PART_MODEL,
  PART_FIRST_CONTACTS,
  PART_OUTPUT_START,
  PARTS
} Part;
PetscErrorCode PartBegin(Part part);
PetscErrorCode PartEnd(Part part);
void PartSample(PetscInt64 cycle);
/* Prints the shares since the last report (those of rank 0) and forgets them. */
PetscErrorCode PartReport(MPI_Comm comm, PetscInt64 cycles);
/* Likewise of the set-up, until the first cycle. */
PetscErrorCode PartReportSetUp(MPI_Comm comm);

/* ---- rows.c */
/* Collective. Rows of all ranks one after the other on rank 0 (NULL elsewhere). unit: bytes of a row. */
PetscErrorCode GatherBytes(MPI_Comm comm, PetscInt n, size_t unit, const void *rows, PetscInt *n_all,
                           void **all);
/* Collective. place: (n,) row of the result for each of the n rows; frees place and rows. all: (n_all, width)
   on rank 0, from PetscMalloc. */
PetscErrorCode GatherPlaced(MPI_Comm comm, PetscInt n, PetscInt *place, PetscInt width, PetscReal *rows,
                            PetscInt n_all, PetscReal **all);

/* ---- files.c */
/* mkdir -p; 0, or -1 and a message. */
int FolderMake(const char *path, char message[MESSAGE_LENGTH]);
/* Keeps other runs out of a folder until FolderUnlock or the end of the process. With a message: FOLDER_TAKEN
   when another run is there, -1 when the folder cannot be written. */
enum { FOLDER_TAKEN = -2 };
int FolderLock(const char *folder, char message[MESSAGE_LENGTH]);
void FolderUnlock(const char *folder, int lock);
/* folder/name.part, opened for writing. */
FILE *PartOpen(const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* Closes it; when all of it is on the disk it becomes folder/name, unless there is a message. */
void PartFinish(FILE *f, const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* folder/name with this text, and behind it its CRC-32 between `before` and `after`. */
void PartText(const char *folder, const char *name, const char *text, size_t size, const char *before,
              const char *after, char message[MESSAGE_LENGTH]);
/* What PartFinish does, for a .part that is on the disk already. */
void PartRename(const char *folder, const char *name, char message[MESSAGE_LENGTH]);
/* Makes the renaming of a file outlast a loss of power; 0 or errno. */
int FolderSync(const char *path);
/* 0 or -1 */
int FileCopy(const char *from, const char *to);
/* CRC-32 (that of zlib) of the first bytes of a file; 0, or -1: it has fewer, or cannot be read (errno). */
int FileChecksum(const char *path, size_t bytes, uint64_t *checksum);

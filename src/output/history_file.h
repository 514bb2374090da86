/* history_file.h: declares CSV files that grow while the run goes on. */
#pragma once
#include "archive/archive.h"

typedef struct {
  const char *name;  /* history.csv; NULL: the run has none */
  FILE *file;        /* NULL: closed */
  PetscInt64 bytes;  /* [bytes] length of the file when it was last read or written */
  uint64_t checksum; /* FileChecksum at that length */
} HistoryFile;
/* Rank 0. Opens the file, and returns whether it is new and needs a header. named: the file has its final
   name, without .part. The other functions do nothing while the file is closed. */
PetscBool HistoryOpen(HistoryFile *history, const char *folder, PetscBool named, PetscBool resumed,
                      char message[MESSAGE_LENGTH]);
void HistoryName(const HistoryFile *history, const char *folder, char message[MESSAGE_LENGTH]);
/* Checks that the file of this name has the rows. */
void HistoryCheck(const HistoryFile *history, const char *folder, PetscBool named,
                  char message[MESSAGE_LENGTH]);
/* Flushes the file to the disk. */
void HistorySettle(HistoryFile *history, const char *folder, PetscBool named, char message[MESSAGE_LENGTH]);
/* Writes the member of summary.json with the file's length and checksum. */
void HistorySummary(Json *json, const HistoryFile *history, const char *member);
void HistoryClose(HistoryFile *history, const char *folder, char message[MESSAGE_LENGTH]);

/* The files of a run: history.csv, joint_history.csv, anchor_history.csv. */
enum { HISTORY, JOINT_HISTORY, TERM_HISTORY, HISTORY_FILES };
/* Names the files that the scene asks for. */
void HistoriesName(const Scene *scene, HistoryFile *files);
/* Rank 0. Removes files of an older run that this run does not have. */
void HistoriesDrop(const HistoryFile *files, const char *folder);
/* Collective. Archives the sizes of the files, see archive.h. */
PetscErrorCode HistoryFilesArchive(Archive *archive, HistoryFile *files);

/* history_file.h: CSV files that grow while the run goes on. */
#pragma once
#include "archive/archive.h"

typedef struct {
  const char *name;  /* history.csv; NULL: the run has none */
  FILE *file;        /* NULL: closed */
  PetscInt64 bytes;  /* length of the file at the last look */
  uint64_t checksum; /* FileChecksum at that length */
} HistoryFile;
/* Rank 0. named: it has its final name, without .part. All do nothing while it is closed, but HistoryOpen.
   HistoryOpen says whether it is new and wants its header. */
PetscBool HistoryOpen(HistoryFile *history, const char *folder, PetscBool named, PetscBool resumed,
                      char message[MESSAGE_LENGTH]);
void HistoryName(const HistoryFile *history, const char *folder, char message[MESSAGE_LENGTH]);
/* Checks that the file of that name has the rows. */
void HistoryCheck(const HistoryFile *history, const char *folder, PetscBool named,
                  char message[MESSAGE_LENGTH]);
/* Puts the file as far as it goes on the disk. */
void HistorySettle(HistoryFile *history, const char *folder, PetscBool named, char message[MESSAGE_LENGTH]);
/* Writes the member of summary.json that tells the file's length and checksum. */
void HistorySummary(FILE *f, const HistoryFile *history, const char *member);
void HistoryClose(HistoryFile *history, const char *folder, char message[MESSAGE_LENGTH]);

/* The files of a run: history.csv, joint_history.csv, anchor_history.csv. */
enum { HISTORY, JOINT_HISTORY, TERM_HISTORY, HISTORY_FILES };
/* Gives a name to those that the scene asks for. */
void HistoriesName(const Scene *scene, HistoryFile *files);
/* Rank 0. Removes those that an older run has left and this one does not have. */
void HistoriesDrop(const HistoryFile *files, const char *folder);
/* Collective, see archive.h. */
PetscErrorCode HistoryFilesArchive(Archive *archive, HistoryFile *files);

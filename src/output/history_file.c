/* history_file.c: writes CSV files that grow while the run goes on: history.csv, joint_history.csv,
   anchor_history.csv. It is called <name>.part until the first stage is whole, its checksum stands in
   summary.json and in the checkpoint, and a restart cuts it back to the rows of its checkpoint. Rank 0
   only. */
#include "output/output.h"
#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PATH_LENGTH = PETSC_MAX_PATH_LEN + 64 };
static const char *const FileNames[HISTORY_FILES] = {"history.csv", "joint_history.csv",
                                                     "anchor_history.csv"};

void HistoriesName(const Scene *scene, HistoryFile *files)
{
  PetscInt n_anchors;
  (void)SceneEntries(scene, "anchors", &n_anchors);
  const PetscBool has[HISTORY_FILES] = {PETSC_TRUE, SceneInTime(scene), (PetscBool)(n_anchors > 0)};
  for (int i = 0; i < HISTORY_FILES; i++) files[i].name = has[i] ? FileNames[i] : NULL;
}

void HistoriesDrop(const HistoryFile *files, const char *folder)
{
  char path[PATH_LENGTH];
  for (int i = 0; i < HISTORY_FILES; i++) {
    snprintf(path, sizeof(path), "%s/%s", folder, FileNames[i]);
    if (!files[i].name) (void)unlink(path);
  }
}

PetscErrorCode HistoryFilesArchive(Archive *a, HistoryFile *files)
{
  PetscInt64 counts[2 * HISTORY_FILES];
  PetscFunctionBeginUser;
  for (int i = 0; i < HISTORY_FILES; i++)
    counts[2 * i] = files[i].bytes, counts[2 * i + 1] = (PetscInt64)files[i].checksum;
  PetscCall(ArchiveCounts(a, "histories", 2 * HISTORY_FILES, counts));
  for (int i = 0; i < HISTORY_FILES && a->reading; i++) {
    files[i].bytes = ArchiveWithin(a, FileNames[i], counts[2 * i], 0, INT64_MAX);
    files[i].checksum = (uint64_t)counts[2 * i + 1];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the path of the file. named: it has its final name. */
static void path_of(const HistoryFile *h, const char *folder, PetscBool named, char path[PATH_LENGTH])
{
  snprintf(path, PATH_LENGTH, "%s/%s%s", folder, h->name, named ? "" : ".part");
}

void HistoryName(const HistoryFile *h, const char *folder, char message[MESSAGE_LENGTH])
{
  if (h->file) PartRename(folder, h->name, message);
}

void HistoryCheck(const HistoryFile *h, const char *folder, PetscBool named, char message[MESSAGE_LENGTH])
{
  char path[PATH_LENGTH];
  struct stat mine, there;
  if (!h->file || message[0]) return;
  path_of(h, folder, named, path);
  if (fflush(h->file) || ferror(h->file) || fstat(fileno(h->file), &mine))
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.700s' (is the disk full?)", path);
  else if (stat(path, &there) || there.st_ino != mine.st_ino)
    snprintf(message, MESSAGE_LENGTH, "output: somebody has removed '%.700s', or moved it", path);
}

void HistorySettle(HistoryFile *h, const char *folder, PetscBool named, char message[MESSAGE_LENGTH])
{
  char path[PATH_LENGTH];
  if (!h->file) return;
  path_of(h, folder, named, path);
  int error = fflush(h->file) || fsync(fileno(h->file));
  h->bytes = ftell(h->file);
  error = error || h->bytes < 0 || FileChecksum(path, (size_t)h->bytes, &h->checksum);
  if (error && !message[0])
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(errno));
}

/* Continues the file that has the rows of this run up to the checkpoint, without later rows. The file may
   have its final name already. */
static void go_on(HistoryFile *h, const char *folder, PetscBool named, char message[MESSAGE_LENGTH])
{
  char path[2][PATH_LENGTH];
  const size_t bytes = (size_t)h->bytes;
  uint64_t sum;
  path_of(h, folder, PETSC_FALSE, path[0]);
  path_of(h, folder, PETSC_TRUE, path[1]);
  const int wanted = named;
  for (int i = 0; i < 2 && !h->file; i++) {
    const int which = i ? !wanted : wanted;
    const int unread = FileChecksum(path[which], bytes, &sum);
    if (unread && FileUnreadable(path[which], errno, message)) return;
    if (unread || sum != h->checksum) continue;
    if (which != wanted && rename(path[which], path[wanted])) continue;
    if (!truncate(path[wanted], (off_t)bytes)) h->file = fopen(path[wanted], "ae");
    if (!h->file)
      snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path[wanted], strerror(errno));
    return;
  }
}

PetscBool HistoryOpen(HistoryFile *h, const char *folder, PetscBool named, PetscBool resumed,
                      char message[MESSAGE_LENGTH])
{
  const PetscBool has_rows = (PetscBool)(resumed && h->bytes > 0);
  if (message[0]) return PETSC_FALSE;
  if (has_rows) go_on(h, folder, named, message);
  if (h->file || message[0]) return PETSC_FALSE;
  if (has_rows)
    Warn("restart: '%s/%s' does not hold the rows up to the checkpoint: it starts again", folder, h->name);
  h->file = PartOpen(folder, h->name, message);
  if (h->file && named) PartRename(folder, h->name, message);
  return (PetscBool)(h->file != NULL);
}

void HistoryClose(HistoryFile *h, const char *folder, char message[MESSAGE_LENGTH])
{
  if (h->file && fclose(h->file) && !message[0])
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s/%s': %s", folder, h->name,
             strerror(errno));
  h->file = NULL;
}

void HistorySummary(Json *json, const HistoryFile *h, const char *member)
{
  if (!h->file) return;
  JsonOpen(json, member);
  JsonNumber(json, "bytes", h->bytes);
  JsonHex(json, "crc32", 8, h->checksum);
  JsonClose(json);
}

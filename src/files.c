/* files.c: whole files in the output folder: written as <name>.part and renamed when they are on the disk;
   and the lock that keeps a second run out of it. Rank 0 only. */
#include "output.h"
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

int FolderMake(const char *path, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN];
  struct stat status;
  int why = 0; // stat() has a reason of its own
  snprintf(part, sizeof(part), "%s", path);
  for (char *end = part + 1;; end++) {
    if (*end && *end != '/') continue;
    const char kept = *end;
    *end = 0;
    why = mkdir(part, 0777) ? errno : 0;
    if (why && why != EEXIST) break;
    *end = kept;
    if (!kept) break;
  }
  if (!stat(path, &status) && S_ISDIR(status.st_mode)) return 0;
  snprintf(message, MESSAGE_LENGTH, "output: cannot make the folder '%.800s': %s", path,
           strerror(why == EEXIST ? ENOTDIR : why));
  return -1;
}

/* ---- the lock: the system lets go of it when the process ends, however it ends */

static void lock_path(const char *folder, char path[PETSC_MAX_PATH_LEN + 64])
{
  snprintf(path, PETSC_MAX_PATH_LEN + 64, "%s/quoin.lock", folder);
}

/* The locked file must still be the one of that name: its owner may have removed it meanwhile. */
static PetscBool is_still(int file, const char *path)
{
  struct stat mine, there;
  return (PetscBool)(!fstat(file, &mine) && !stat(path, &there) && mine.st_ino == there.st_ino);
}

int FolderLock(const char *folder, char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN + 64], host[256] = "", holder[320] = "";
  lock_path(folder, path);
  for (;;) {
    const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) {
      snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(errno));
      return -1;
    }
    if (flock(file, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) {
      const ssize_t n = pread(file, holder, sizeof(holder) - 1, 0);
      holder[PetscMax(n, 0)] = 0;
      holder[strcspn(holder, "\n")] = 0;
      snprintf(message, MESSAGE_LENGTH, "output: another run writes into '%.600s' (%.300s)", folder, holder);
      close(file);
      return FOLDER_TAKEN;
    }
    if (!is_still(file, path)) {
      close(file);
      continue;
    }
    gethostname(host, sizeof(host) - 1);
    const int n = snprintf(holder, sizeof(holder), "process %d on %s\n", (int)getpid(), host);
    if (ftruncate(file, 0) || pwrite(file, holder, (size_t)n, 0) != n) {
      snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(errno));
      close(file);
      return -1;
    }
    return file;
  }
}

void FolderUnlock(const char *folder, int lock)
{
  char path[PETSC_MAX_PATH_LEN + 64];
  lock_path(folder, path);
  if (is_still(lock, path)) unlink(path);
  close(lock);
}

/* ---- <name>.part, then <name> */

FILE *PartOpen(const char *folder, const char *name, char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN + 64];
  snprintf(path, sizeof(path), "%s/%s.part", folder, name);
  FILE *f = fopen(path, "w");
  if (!f) snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(errno));
  return f;
}

void PartRename(const char *folder, const char *name, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN + 64], path[PETSC_MAX_PATH_LEN + 64];
  if (message[0]) return;
  snprintf(part, sizeof(part), "%s/%s.part", folder, name);
  snprintf(path, sizeof(path), "%s/%s", folder, name);
  const int file = open(part, O_RDWR | O_CLOEXEC);
  int error = file < 0 || fsync(file) ? errno : 0; // a full disk may show only here
  if (file >= 0) close(file);
  if (!error && rename(part, path)) error = errno;
  if (error) snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(error));
}

int FileCopy(const char *from, const char *to)
{
  FILE *in = fopen(from, "rb"), *out = in ? fopen(to, "wb") : NULL;
  int error = !in || !out;
  enum { CHUNK = 1 << 20 };
  char *chunk = malloc(CHUNK);
  for (size_t n = 1; !error && chunk && n;) {
    n = fread(chunk, 1, CHUNK, in);
    error = ferror(in) || fwrite(chunk, 1, n, out) != n;
  }
  free(chunk);
  if (in) fclose(in);
  if (out) error = fclose(out) || error;
  return -(error || !chunk);
}

uint64_t FileChecksum(const char *path, size_t bytes)
{
  FILE *f = fopen(path, "rb");
  char *data = f ? malloc(bytes + 1) : NULL;
  const uint64_t checksum = data && fread(data, 1, bytes, f) == bytes ? HashBytes(1, data, bytes) : 0;
  free(data);
  if (f) fclose(f);
  return checksum;
}

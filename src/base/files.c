/* files.c: writes whole files into the output folder, and locks the folder against a second run. Each file
   is <name>.part first and is renamed once it is on the disk. Rank 0 only. */
#include "base/base.h"
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

int FolderMake(const char *path, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN];
  struct stat status;
  int why = 0; // stat() sets another errno
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

/* ---- the lock: the system releases it when the process ends, however it ends */

static void lock_path(const char *folder, char path[PETSC_MAX_PATH_LEN + 64])
{
  snprintf(path, PETSC_MAX_PATH_LEN + 64, "%s/quoin.lock", folder);
}

/* Decides whether the locked file still has its name: its owner may have removed it meanwhile. */
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
    const int refused = flock(file, LOCK_EX | LOCK_NB) ? errno : 0;
    if (refused && refused != EWOULDBLOCK) {
      snprintf(message, MESSAGE_LENGTH, "output: cannot lock '%.800s': %s", path, strerror(refused));
      close(file);
      return -1;
    }
    if (refused) {
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

/* Refuses a symbolic link of that name, because its target belongs to somebody else. */
FILE *PartOpen(const char *folder, const char *name, char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN + 64];
  snprintf(path, sizeof(path), "%s/%s.part", folder, name);
  const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  FILE *f = file < 0 ? NULL : fdopen(file, "w");
  if (!f) snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(errno));
  return f;
}

int FolderSync(const char *path)
{
  char folder[PETSC_MAX_PATH_LEN + 64];
  snprintf(folder, sizeof(folder), "%s", path);
  char *slash = strrchr(folder, '/');
  if (slash) *slash = 0;
  const int file = open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const int error = file < 0 || fsync(file) ? errno : 0;
  if (file >= 0) close(file);
  return error;
}

void PartRename(const char *folder, const char *name, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN + 64], path[PETSC_MAX_PATH_LEN + 64];
  if (message[0]) return;
  snprintf(part, sizeof(part), "%s/%s.part", folder, name);
  snprintf(path, sizeof(path), "%s/%s", folder, name);
  int error = rename(part, path) ? errno : 0;
  if (!error) error = FolderSync(path);
  if (error) snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.800s': %s", path, strerror(error));
}

void PartFinish(FILE *f, const char *folder, const char *name, char message[MESSAGE_LENGTH])
{
  // any of these calls may be the first to see a full disk
  const int before = ferror(f) && errno ? errno : EIO; // of an earlier write that failed
  errno = 0;
  int error = fflush(f) || ferror(f) || fsync(fileno(f)) ? (errno ? errno : before) : 0;
  if (fclose(f) && !error) error = errno;
  if (error && !message[0])
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.700s/%s': %s", folder, name, strerror(error));
  PartRename(folder, name, message);
}

void PartText(const char *folder, const char *name, const char *text, size_t size, const char *before,
              const char *after, char message[MESSAGE_LENGTH])
{
  FILE *f = message[0] ? NULL : PartOpen(folder, name, message);
  if (!f) return;
  fwrite(text, 1, size, f);
  fprintf(f, "%s%08lx%s", before, crc32(0, (const Bytef *)text, (uInt)size), after);
  PartFinish(f, folder, name, message);
}

PetscBool FileUnreadable(const char *path, int why, char message[MESSAGE_LENGTH])
{
  if (!why || why == ENOENT || why == ENOTDIR) return PETSC_FALSE;
  if (!message[0]) snprintf(message, MESSAGE_LENGTH, "output: cannot read '%.800s': %s", path, strerror(why));
  return PETSC_TRUE;
}

int FileCopy(const char *from, const char *to)
{
  enum { CHUNK = 1 << 20 };
  const int in = open(from, O_RDONLY | O_CLOEXEC);
  int why = in < 0 ? errno : 0;
  const int out = why ? -1 : open(to, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  char *chunk = malloc(CHUNK);
  if (!why && (out < 0 || !chunk)) why = out < 0 ? errno : ENOMEM;
  for (ssize_t n = 1; !why && n;) {
    n = read(in, chunk, CHUNK);
    if (n < 0 && errno != EINTR) why = errno;
    if (n < 0) continue;
    for (ssize_t at = 0, put; !why && at < n; at += PetscMax(put, 0)) {
      put = write(out, chunk + at, (size_t)(n - at));
      if (!put || (put < 0 && errno != EINTR)) why = put ? errno : EIO;
    }
  }
  free(chunk);
  if (in >= 0) close(in);
  if (out >= 0 && close(out) && !why) why = errno;
  errno = why;
  return why ? -1 : 0;
}

int FileChecksum(const char *path, size_t bytes, uint64_t *checksum)
{
  enum { CHUNK = 1 << 20 };
  FILE *f = fopen(path, "rb");
  unsigned char *chunk = f ? malloc(CHUNK) : NULL;
  uLong crc = crc32(0, NULL, 0);
  errno = f && chunk ? 0 : errno;
  while (chunk && bytes) {
    const size_t n = fread(chunk, 1, PetscMin(bytes, CHUNK), f);
    if (!n) break;
    crc = crc32(crc, chunk, (uInt)n);
    bytes -= n;
  }
  const int error = !chunk || bytes, why = errno;
  if (f) fclose(f);
  free(chunk);
  errno = why;
  *checksum = (uint64_t)crc;
  return -error;
}

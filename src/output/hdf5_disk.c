/* hdf5_disk.c: writes HDF5 files through a driver of its own, which survives disk errors.

   HDF5 1.10 cannot go on from a write that has failed. It forgets data that stood in one of its buffers, so
   that zeros are read later, or it crashes when MPI ends. So HDF5 never sees a failure: the driver remembers
   the first one and tells HDF5 that all is well, and DiskFileClose tells the caller. Reads and writes are
   completed, also after a signal or a short write of the system.

   Checkpoints go through HDF5's core driver instead (archive_file.c): one image in memory, written at once.
   Results cannot. A file with 20 frames of 1e5 blocks has 613 MB. Built in memory and copied out it needs
   1280 MB and 4.4 s; on the disk 56 MB and 1.3 s (2026-11). results.h5 grows by a stage and its frames at a
   time, and memory holds none of it between them.

   The first 512 bytes, which HDF5 leaves to its users, are text: length and CRC-32 of the rest. */
#include "output/output.h"
#include "output/hdf5_disk.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <H5FDpublic.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

typedef struct {
  H5FD_t base; /* HDF5's own part comes first */
  int file, writes;
  haddr_t eoa, eof; /* end of the allocated part, end of the file */
} DiskFile;

/* The state of the file that is open. */
static int first_error; /* errno */
static char *open_path; /* from strdup */

static void failed(void)
{
  if (!first_error) first_error = errno ? errno : EIO;
}

static H5FD_t *disk_open(const char *path, unsigned flags, hid_t options, haddr_t most)
{
  const int how = (flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY) | (flags & H5F_ACC_CREAT ? O_CREAT : 0) |
                  (flags & H5F_ACC_TRUNC ? O_TRUNC : 0) | (flags & H5F_ACC_EXCL ? O_EXCL : 0);
  struct stat status;
  (void)options, (void)most;
  const int file = open(path, how | O_NOFOLLOW | O_CLOEXEC, 0666);
  DiskFile *disk = file < 0 || fstat(file, &status) ? NULL : calloc(1, sizeof(*disk));
  if (!disk) {
    failed();
    if (file >= 0) close(file);
    return NULL;
  }
  disk->file = file, disk->writes = (flags & H5F_ACC_RDWR) != 0, disk->eof = (haddr_t)status.st_size;
  return &disk->base;
}

static herr_t disk_close(H5FD_t *base)
{
  DiskFile *disk = (DiskFile *)base;
  if (disk->writes && fsync(disk->file)) failed();
  if (close(disk->file) && disk->writes) failed();
  free(disk);
  return 0;
}

static herr_t disk_query(const H5FD_t *base, unsigned long *features)
{
  (void)base;
  *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
              H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

static haddr_t get_eoa(const H5FD_t *base, H5FD_mem_t type)
{
  (void)type;
  return ((const DiskFile *)base)->eoa;
}

static herr_t set_eoa(H5FD_t *base, H5FD_mem_t type, haddr_t address)
{
  (void)type;
  ((DiskFile *)base)->eoa = address;
  return 0;
}

static haddr_t get_eof(const H5FD_t *base, H5FD_mem_t type)
{
  (void)type;
  return ((const DiskFile *)base)->eof;
}

/* Reads bytes; beyond the end of the file it reads zeros. */
static herr_t disk_read(H5FD_t *base, H5FD_mem_t type, hid_t options, haddr_t at, size_t size, void *buffer)
{
  const DiskFile *disk = (const DiskFile *)base;
  char *to = buffer;
  (void)type, (void)options;
  while (size) {
    const ssize_t n = pread(disk->file, to, size, (off_t)at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) failed();
    if (n <= 0) break;
    to += n, at += (haddr_t)n, size -= (size_t)n;
  }
  memset(to, 0, size);
  return 0;
}

static herr_t disk_write(H5FD_t *base, H5FD_mem_t type, hid_t options, haddr_t at, size_t size,
                         const void *buffer)
{
  DiskFile *disk = (DiskFile *)base;
  const char *from = buffer;
  (void)type, (void)options;
  disk->eof = at + size > disk->eof ? at + size : disk->eof;
  while (size && !first_error) { // after the first failure nothing counts
    const ssize_t n = pwrite(disk->file, from, size, (off_t)at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      failed();
      break;
    }
    from += n, at += (haddr_t)n, size -= (size_t)n;
  }
  return 0;
}

static herr_t disk_truncate(H5FD_t *base, hid_t options, hbool_t closing)
{
  DiskFile *disk = (DiskFile *)base;
  (void)options, (void)closing;
  if (disk->eoa != disk->eof && ftruncate(disk->file, (off_t)disk->eoa)) failed();
  disk->eof = disk->eoa;
  return 0;
}

static const H5FD_class_t DiskDriver = {
#if H5_VERSION_GE(1, 13, 0)
    .version = H5FD_CLASS_VERSION,
    .value = 512, /* numbers from here on are free for users */
#endif
    .name = "quoin_disk",
    .maxaddr = (haddr_t)INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG, /* also closes objects that a failure has left open */
    .open = disk_open,
    .close = disk_close,
    .query = disk_query,
    .get_eoa = get_eoa,
    .set_eoa = set_eoa,
    .get_eof = get_eof,
    .read = disk_read,
    .write = disk_write,
    .truncate = disk_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

/* Makes the access through the driver; negative: out of memory. */
static hid_t access_by_disk(void)
{
  static hid_t driver = -1;
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (driver < 0) driver = H5FDregister(&DiskDriver);
  if (access < 0 || H5Pset_driver(access, driver, NULL) < 0) return -1;
  return access;
}

static hid_t opened(hid_t file, const char *path)
{
  free(open_path);
  open_path = strdup(path);
  return open_path ? file : -1;
}

hid_t DiskFileRead(const char *path)
{
  const int before = first_error, whole = DiskFileIsWhole(path), why = errno;
  const hid_t access = whole ? access_by_disk() : -1;
  first_error = 0;
  const hid_t file = access < 0 ? -1 : H5Fopen(path, H5F_ACC_RDONLY, access);
  if (access >= 0) H5Pclose(access);
  const int opening = first_error;
  if (before) first_error = before;
  errno = file >= 0 ? 0 : whole ? opening : why;
  return file;
}

hid_t DiskFileCreate(const char *path)
{
  first_error = 0;
  const hid_t access = access_by_disk(), create = H5Pcreate(H5P_FILE_CREATE);
  hid_t file = -1;
  if (access >= 0 && create >= 0 && H5Pset_userblock(create, DISK_HEADER) >= 0)
    file = opened(H5Fcreate(path, H5F_ACC_TRUNC, create, access), path);
  if (create >= 0) H5Pclose(create);
  if (access >= 0) H5Pclose(access);
  return file;
}

hid_t DiskFileOpen(const char *path)
{
  first_error = 0;
  const hid_t access = access_by_disk();
  const hid_t file = access < 0 ? -1 : opened(H5Fopen(path, H5F_ACC_RDWR, access), path);
  if (access >= 0) H5Pclose(access);
  return file;
}

/* ---- header */

/* Computes the header of a file (length, CRC-32) from the bytes after it. Returns 0, or -1: not read. */
static int make_header(int file, char header[DISK_HEADER])
{
  enum { CHUNK = 1 << 16 };
  unsigned char *chunk = malloc(CHUNK);
  uLong crc = crc32(0, NULL, 0);
  off_t at = DISK_HEADER;
  ssize_t n = chunk ? 1 : -1;
  while (n > 0) {
    n = pread(file, chunk, CHUNK, at);
    if (n < 0 && errno == EINTR)
      n = 1;
    else if (n > 0)
      crc = crc32(crc, chunk, (uInt)n), at += n;
  }
  free(chunk);
  memset(header, 0, DISK_HEADER);
  snprintf(header, DISK_HEADER, "quoin-results\nbytes %lld\ncrc32 %08lx\n", (long long)at - DISK_HEADER,
           (unsigned long)crc);
  return n < 0 ? -1 : 0;
}

static void seal(const char *path)
{
  char header[DISK_HEADER];
  const int file = open(path, O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  errno = file < 0 ? errno : 0;
  if (file < 0 || make_header(file, header) || pwrite(file, header, DISK_HEADER, 0) != DISK_HEADER ||
      fsync(file))
    failed();
  if (file >= 0 && close(file)) failed();
}

int DiskFileClose(hid_t file)
{
  errno = 0;
  if (H5Fclose(file) < 0) failed();
  if (!first_error) seal(open_path);
  free(open_path), open_path = NULL;
  return first_error;
}

int DiskFileIsWhole(const char *path)
{
  char header[DISK_HEADER], wanted[DISK_HEADER];
  errno = 0;
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  const int read = file >= 0 && pread(file, header, DISK_HEADER, 0) == DISK_HEADER &&
                   !make_header(file, wanted),
            why = read ? 0 : errno;
  if (file >= 0) close(file);
  errno = why;
  return read && !memcmp(header, wanted, DISK_HEADER);
}

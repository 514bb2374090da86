/* archive_file.c: writes an archive to a file, and reads it. A header of 512 bytes of text, which h5dump
   and h5py skip, contains length and checksum of the HDF5 image after it. So a truncated or corrupt file
   is refused before HDF5 opens it. The image is made in memory and written by plain calls whose errors are
   all checked: a full disk gives a message, and no library is left with half a file. Rank 0 only. */
#include "archive/archive.h"
#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HEADER = ARCHIVE_HEADER, CHECKPOINT_FORMAT = 21 };
static const char *const MAGIC = "quoin-checkpoint";

void ArchiveHeader(uint64_t bytes, uint64_t checksum, const char *version, char header[HEADER])
{
  memset(header, 0, HEADER);
  snprintf(header, HEADER, "%s %d\nversion %s\nbytes %llu\nchecksum %016llx\n", MAGIC, CHECKPOINT_FORMAT,
           version, (unsigned long long)bytes, (unsigned long long)checksum);
}

/* ---- HDF5 in memory */

static hid_t open_core(void *image, size_t bytes)
{
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, 1 << 20, 0); // no file behind the image
  if (image) H5Pset_file_image(access, image, bytes);
  const hid_t file = image ? H5Fopen("checkpoint", H5F_ACC_RDONLY, access)
                           : H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  H5Pclose(access);
  return file;
}

static hid_t file_type(ArchiveKind kind)
{
  return kind == ARCHIVE_REAL ? H5T_IEEE_F64LE : kind == ARCHIVE_COUNT ? H5T_STD_I64LE : H5T_STD_U8LE;
}

static hid_t memory_type(ArchiveKind kind)
{
  return kind == ARCHIVE_REAL    ? H5T_NATIVE_DOUBLE
         : kind == ARCHIVE_COUNT ? H5T_NATIVE_INT64
                                 : H5T_NATIVE_UINT8;
}

static int write_entry(hid_t file, const ArchiveEntry *e)
{
  const hsize_t dims[2] = {e->rows, e->columns};
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), space = H5Screate_simple(2, dims, NULL);
  H5Pset_create_intermediate_group(links, 1);
  const hid_t set = H5Dcreate2(file, e->name, file_type(e->kind), space, links, H5P_DEFAULT, H5P_DEFAULT);
  int error = set < 0;
  if (!error && e->rows > 0 && e->columns > 0)
    error = H5Dwrite(set, memory_type(e->kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, e->data) < 0;
  if (set >= 0) H5Dclose(set);
  H5Sclose(space);
  H5Pclose(links);
  return -error;
}

/* Writes the list of contents: one line per entry with name, kind, rows and columns. */
static int write_contents(hid_t file, const Archive *a)
{
  ArchiveEntry contents = {.name = "contents", .kind = ARCHIVE_TEXT, .columns = 1};
  char *text = NULL;
  FILE *f = open_memstream(&text, &contents.rows);
  for (PetscInt i = 0; f && i < a->n; i++)
    fprintf(f, "%s %d %zu %zu\n", a->entries[i].name, (int)a->entries[i].kind, a->entries[i].rows,
            a->entries[i].columns);
  int error = !f || fclose(f);
  contents.data = text;
  error = error || write_entry(file, &contents);
  free(text);
  return -error;
}

/* Makes the HDF5 file of the archive in memory, and frees each entry when it is there. bytes, image: its
   content, which lives as long as the file; NULL: no memory. */
static PetscErrorCode make_image(Archive *a, hid_t *file, size_t *bytes, const char **image)
{
  void **memory = NULL; // where the core driver keeps the address of its memory
  PetscFunctionBeginUser;
  *file = open_core(NULL, 0);
  int error = *file < 0 || write_contents(*file, a);
  for (PetscInt i = 0; i < a->n; i++) {
    error = error || write_entry(*file, a->entries + i);
    PetscCall(PetscFree(a->entries[i].data));
  }
  error = error || H5Fflush(*file, H5F_SCOPE_GLOBAL) < 0 ||
          H5Fget_vfd_handle(*file, H5P_DEFAULT, (void **)&memory) < 0;
  const ssize_t size = error ? -1 : H5Fget_file_image(*file, NULL, 0);
  *image = size > 0 ? *memory : NULL, *bytes = (size_t)size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens a dataset of two dimensions; -1: not there. */
static hid_t open_set(hid_t file, const char *name, hsize_t dims[2])
{
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
  const int error = space < 0 || H5Sget_simple_extent_ndims(space) != 2 ||
                    H5Sget_simple_extent_dims(space, dims, NULL) < 0;
  if (space >= 0) H5Sclose(space);
  if (error && set >= 0) H5Dclose(set);
  return error ? -1 : set;
}

/* Reads one dataset of this kind and size into the archive. error: not 0 on failure. The dataset must be
   stored in the file before memory is allocated for it. */
static PetscErrorCode read_entry(hid_t file, const ArchiveEntry *wanted, Archive *a, int *error)
{
  const size_t bytes = wanted->rows * wanted->columns * (wanted->kind == ARCHIVE_TEXT ? 1 : 8);
  hsize_t dims[2], most = 0;
  void *data;
  PetscFunctionBeginUser;
  const hid_t set = open_set(file, wanted->name, dims);
  *error = set < 0 || dims[0] != wanted->rows || dims[1] != wanted->columns ||
           H5Fget_filesize(file, &most) < 0 || bytes > most || (bytes && H5Dget_storage_size(set) != bytes) ||
           ArchiveFind(a, wanted->name);
  if (!*error) {
    PetscCall(PetscMalloc(bytes + 1, &data));
    if (bytes) *error = H5Dread(set, memory_type(wanted->kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0;
    PetscCall(ArchiveAdd(a, wanted->name, wanted->kind, wanted->rows, wanted->columns, data));
  }
  if (set >= 0) H5Dclose(set);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads all datasets that the list of contents names. */
static PetscErrorCode read_image(hid_t file, Archive *a, int *error)
{
  ArchiveEntry contents = {.name = "contents", .kind = ARCHIVE_TEXT, .columns = 1}, e = {.rows = 0};
  hsize_t dims[2];
  int kind, used;
  PetscFunctionBeginUser;
  const hid_t set = open_set(file, contents.name, dims);
  *error = set < 0;
  if (!*error) contents.rows = dims[0];
  if (!*error) H5Dclose(set);
  if (!*error) PetscCall(read_entry(file, &contents, a, error));
  if (*error) PetscFunctionReturn(PETSC_SUCCESS);
  char *text = a->entries[0].data; // PetscMalloc left room for the closing zero
  text[contents.rows] = 0;
  while (!*error && sscanf(text, "%127s %d %zu %zu\n%n", e.name, &kind, &e.rows, &e.columns, &used) == 4) {
    e.kind = (ArchiveKind)kind;
    if (kind < 0 || kind > ARCHIVE_TEXT || (e.columns && e.rows > SIZE_MAX / 8 / e.columns)) *error = 1;
    if (*error) break;
    PetscCall(read_entry(file, &e, a, error));
    text += used;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- bytes */

static int write_all(int file, const char *data, size_t bytes)
{
  while (bytes) {
    const ssize_t n = write(file, data, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return -1;
    data += n, bytes -= (size_t)n;
  }
  return 0;
}

/* Reads the whole file into memory from malloc. */
static char *read_all(const char *path, size_t *bytes)
{
  struct stat status;
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  char *data = NULL;
  *bytes = 0;
  if (file < 0) return NULL;
  if (!fstat(file, &status) && S_ISREG(status.st_mode)) data = malloc((size_t)status.st_size + 1);
  while (data && *bytes < (size_t)status.st_size) {
    const ssize_t n = read(file, data + *bytes, (size_t)status.st_size - *bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    *bytes += (size_t)n;
  }
  close(file);
  return data;
}

/* Decides whether the next bytes of the file are these, by small pieces. */
static int reads_same(int file, const char *data, size_t bytes)
{
  char piece[1 << 14];
  while (bytes) {
    const ssize_t n = read(file, piece, bytes < sizeof(piece) ? bytes : sizeof(piece));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0 || memcmp(piece, data, (size_t)n)) return 0;
    data += n, bytes -= (size_t)n;
  }
  return 1;
}

/* Writes header and image, flushes the file, reads it back from the disk, not from the system's cache, and
   compares. */
static int write_verified(const char *part, const char header[HEADER], const char *image, size_t bytes)
{
  int file = open(part, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  int error = write_all(file, header, HEADER) || write_all(file, image, bytes) || fsync(file) ? errno : 0;
  if (close(file) && !error) error = errno;
  if (error) return error;
  file = open(part, O_RDONLY | O_CLOEXEC);
  if (file < 0) return EIO;
  posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  char end;
  if (!reads_same(file, header, HEADER) || !reads_same(file, image, bytes) || read(file, &end, 1))
    error = EIO;
  close(file);
  return error;
}

/* Writes the checkpoint. message: "" if it is there. */
static void write_checkpoint(const char *path, const char header[HEADER], const char *image, size_t bytes,
                             char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN + 8];
  snprintf(part, sizeof(part), "%s.part", path);
  int error = image ? write_verified(part, header, image, bytes) : ENOMEM;
  if (!error && rename(part, path)) error = errno;
  if (!error) error = FolderSync(path);
  if (!error) return;
  unlink(part); // half a checkpoint is useless
  snprintf(message, MESSAGE_LENGTH, "cannot write the checkpoint '%.700s': %s", path, strerror(error));
}

PetscErrorCode ArchiveWriteFile(Archive *a, const char *folder, const char *path,
                                char message[MESSAGE_LENGTH])
{
  char header[HEADER];
  const char *image = NULL;
  size_t bytes = 0;
  hid_t file = -1;
  PetscFunctionBeginUser;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  PetscCall(make_image(a, &file, &bytes, &image));
  if (image) ArchiveHeader(bytes, HashBytes(0, image, bytes), QUOIN_VERSION, header);
  for (int attempt = 0; attempt < 2; attempt++) {
    message[0] = '\0';
    if (!FolderMake(folder, message)) write_checkpoint(path, header, image, bytes, message);
    if (!message[0] || !access(folder, F_OK)) break;
  }
  if (file >= 0) H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks version and checksum of a file. message: "" if both are good. sum receives the checksum. */
static void check_header(const char *data, size_t size, uint64_t *sum, char message[MESSAGE_LENGTH])
{
  char text[HEADER] = "", version[64], header[HEADER];
  unsigned long long bytes, checksum;
  int format;
  if (size >= HEADER) memcpy(text, data, HEADER - 1);
  if (size < HEADER || sscanf(text, "quoin-checkpoint %d\nversion %63s\nbytes %llu\nchecksum %llx\n", &format,
                              version, &bytes, &checksum) != 4) {
    snprintf(message, MESSAGE_LENGTH, "it is no checkpoint, or its head is damaged");
    return;
  }
  if (size != HEADER + bytes) {
    snprintf(message, MESSAGE_LENGTH, "it is damaged: %llu bytes, expected %llu", (unsigned long long)size,
             HEADER + bytes);
    return;
  }
  *sum = HashBytes(0, data + HEADER, bytes);
  ArchiveHeader(bytes, *sum, version, header);
  if (format == CHECKPOINT_FORMAT && memcmp(header, data, HEADER))
    snprintf(message, MESSAGE_LENGTH, "it is damaged: its checksum is wrong");
  else if (format != CHECKPOINT_FORMAT || strcmp(version, QUOIN_VERSION))
    snprintf(message, MESSAGE_LENGTH, "it is of version %s (format %d), this is version %s (format %d)",
             version, format, QUOIN_VERSION, CHECKPOINT_FORMAT);
}

PetscErrorCode ArchiveReadFile(Archive *a, const char *path, char message[MESSAGE_LENGTH])
{
  size_t size;
  int error = 0;
  PetscFunctionBeginUser;
  errno = 0;
  char *data = read_all(path, &size);
  if (!data) {
    snprintf(message, MESSAGE_LENGTH, "cannot read it: %s", strerror(errno ? errno : ENOENT));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  check_header(data, size, &a->checksum, message);
  if (!message[0]) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = open_core(data + HEADER, size - HEADER);
    if (file >= 0) PetscCall(read_image(file, a, &error));
    if (file < 0 || error) snprintf(message, MESSAGE_LENGTH, "HDF5 cannot read it");
    if (file >= 0) H5Fclose(file);
  }
  free(data);
  PetscFunctionReturn(PETSC_SUCCESS);
}

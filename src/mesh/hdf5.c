/* hdf5.c: reads datasets of an HDF5 file that nobody has checked. The reader checks type and shape of
   everything before it allocates anything. It follows only what is stored in this file: hard links, no
   external or virtual data. The first fault ends the reading with one message. */
#include "mesh/mesh.h"
#include "mesh/hdf5.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const PetscInt MAX_ROWS = 1 << 28; /* 4 entries a row, and twice that for safety, fit into 31 bits */

/* ---- one fault, one message */

void ReaderFault(FileReader *r, const char *format, ...)
{
  /* of a very long path only the end is shown, so that the reason is never cut off */
  const size_t length = strlen(r->path), shown = PetscMin(length, 400);
  if (r->message[0]) return;
  const int used = snprintf(r->message, MESSAGE_LENGTH, "%s: ", r->path + length - shown);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(r->message + used, (size_t)(MESSAGE_LENGTH - used), format, arguments);
  va_end(arguments);
  /* names from the file may hold any bytes, but the message is one line of text */
  for (char *c = r->message; *c; c++)
    if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
}

static PetscBool is_name(const char *name)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
  const size_t length = strlen(name);
  if (length < 1 || length >= NAME_LENGTH || !strchr(letters, name[0])) return PETSC_FALSE;
  for (const char *c = name; *c; c++)
    if (!strchr(letters, *c) && !strchr("0123456789_-", *c)) return PETSC_FALSE;
  return PETSC_TRUE;
}

static void check_name(FileReader *r, const char *kind, const char *name)
{
  if (!is_name(name))
    ReaderFault(r, "%s '%.80s': a name is a letter, then letters, digits, _ or -, at most %d in all", kind,
                name, NAME_LENGTH - 1);
}

/* ---- what is in the file */

static const char *const ItemText[] = {"float64", "int32", "bytes of length 64"};

static hid_t memory_type(ItemKind kind)
{
  if (kind == ITEM_REAL) return H5T_NATIVE_DOUBLE;
  return sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
}

/* Finds whether there is an object of this type at the path, with a hard link at each step. *found false
   without a fault: nothing is there. */
static void find_object(FileReader *r, const char *path, H5O_type_t type, PetscBool *found)
{
  const char *const what = type == H5O_TYPE_GROUP ? "group" : "dataset";
  char part[2 * NAME_LENGTH];
  H5L_info_t link;
  H5O_info_t object;

  *found = PETSC_FALSE;
  for (const char *slash = path; slash && ReaderSound(r);) {
    slash = strchr(slash + 1, '/');
    snprintf(part, sizeof part, "%.*s", (int)(slash ? slash - path : (long)strlen(path)), path);
    const htri_t exists = H5Lexists(r->file, part, H5P_DEFAULT);
    if (exists == 0) return;
    if (exists < 0 || H5Lget_info(r->file, part, &link, H5P_DEFAULT) < 0)
      ReaderFault(r, "%s %s cannot be read: the file is damaged", what, path);
    else if (link.type != H5L_TYPE_HARD)
      ReaderFault(r, "%s %s: %s is a link, expected an object stored in this file", what, path, part);
  }
  if (!ReaderSound(r)) return;
  if (H5Oget_info_by_name(r->file, path, &object, H5P_DEFAULT) < 0)
    ReaderFault(r, "%s %s cannot be read: the file is damaged", what, path);
  else if (object.type != type)
    ReaderFault(r, "%s: expected a %s, found %s", path, what,
                object.type == H5O_TYPE_GROUP     ? "a group"
                : object.type == H5O_TYPE_DATASET ? "a dataset"
                                                  : "another object");
  *found = ReaderSound(r);
}

/* Describes type and shape, as "int64 (5,3)". */
static void describe(hid_t type, int rank, const hsize_t *size, char text[128])
{
  const size_t bytes = H5Tget_size(type);
  size_t used;
  switch (H5Tget_class(type)) {
  case H5T_INTEGER:
    snprintf(text, 64, "%sint%zu", H5Tget_sign(type) == H5T_SGN_NONE ? "u" : "", 8 * bytes);
    break;
  case H5T_FLOAT:
    snprintf(text, 64, "float%zu", 8 * bytes);
    break;
  case H5T_STRING:
    if (H5Tis_variable_str(type) > 0)
      snprintf(text, 64, "strings of variable length");
    else
      snprintf(text, 64, "bytes of length %zu", bytes);
    break;
  default:
    snprintf(text, 64, "another type");
  }
  used = strlen(text);
  used += (size_t)snprintf(text + used, 128 - used, " (");
  for (int i = 0; i < PetscMin(rank, 2); i++)
    used += (size_t)snprintf(text + used, 128 - used, "%s%llu", i ? "," : "", (unsigned long long)size[i]);
  snprintf(text + used, 128 - used, "%s", rank > 2 ? ",..)" : rank == 1 ? ",)" : ")");
}

static PetscBool type_is(hid_t type, ItemKind kind)
{
  const H5T_class_t class = H5Tget_class(type);
  const size_t bytes = H5Tget_size(type);
  switch (kind) {
  case ITEM_REAL:
    return class == H5T_FLOAT && bytes == 8;
  case ITEM_INT:
    return class == H5T_INTEGER && bytes == 4 && H5Tget_sign(type) == H5T_SGN_2;
  default:
    return class == H5T_STRING && H5Tis_variable_str(type) == 0 && bytes == NAME_LENGTH;
  }
}

/* Decides whether the file contains every number of a dataset, or only declares it. This keeps the reader
   from allocating memory for data that are not stored. */
static PetscBool is_stored(hid_t dataset, hid_t properties, hid_t type, hid_t space)
{
  hsize_t size[H5S_MAX_RANK], chunk[H5S_MAX_RANK], chunks = 1, there = 0;
  if (H5Pget_layout(properties) != H5D_CHUNKED)
    return (PetscBool)(H5Dget_storage_size(dataset) ==
                       (hsize_t)H5Sget_simple_extent_npoints(space) * H5Tget_size(type));
  const int rank = H5Sget_simple_extent_dims(space, size, NULL);
  if (H5Pget_chunk(properties, H5S_MAX_RANK, chunk) != rank) return PETSC_FALSE;
  for (int i = 0; i < rank; i++) chunks *= chunk[i] ? size[i] / chunk[i] + (size[i] % chunk[i] > 0) : 0;
  return (PetscBool)(H5Dget_num_chunks(dataset, space, &there) >= 0 && there == chunks);
}

/* Refuses data outside this file, and data that is declared and never written. */
static void check_storage(FileReader *r, hid_t dataset, hid_t type, hid_t space, const char *path)
{
  const hid_t properties = H5Dget_create_plist(dataset);
  hsize_t file_size = 0;
  H5Fget_filesize(r->file, &file_size);
  if (properties < 0)
    ReaderFault(r, "dataset %s cannot be read: the file is damaged", path);
  else if (H5Pget_layout(properties) == H5D_VIRTUAL || H5Pget_external_count(properties) > 0)
    ReaderFault(r, "dataset %s: its data are in other files, expected data stored in this file", path);
  else if (H5Dget_storage_size(dataset) > file_size || !is_stored(dataset, properties, type, space))
    ReaderFault(r, "dataset %s: its data are not in the file", path);
  if (properties >= 0) H5Pclose(properties);
}

/* Checks type and shape of a dataset: (n,columns), or (n,) when columns is 0. No data is read yet. */
void ReaderInspect(FileReader *r, const char *path, ItemKind kind, int columns, PetscInt *n)
{
  PetscBool found;
  hsize_t size[H5S_MAX_RANK] = {0};
  char text[128];

  *n = 0;
  find_object(r, path, H5O_TYPE_DATASET, &found);
  if (!ReaderSound(r)) return;
  if (!found) {
    ReaderFault(r, "dataset %s is missing", path);
    return;
  }
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT), type = H5Dget_type(dataset),
              space = H5Dget_space(dataset);
  const int rank = H5Sget_simple_extent_dims(space, size, NULL);
  if (dataset < 0 || type < 0 || space < 0 || rank < 0) {
    ReaderFault(r, "dataset %s cannot be read: the file is damaged", path);
  } else if (!type_is(type, kind) || rank != (columns ? 2 : 1) || (columns && size[1] != (hsize_t)columns)) {
    describe(type, rank, size, text);
    if (columns)
      ReaderFault(r, "dataset %s: expected %s (n,%d), found %s", path, ItemText[kind], columns, text);
    else
      ReaderFault(r, "dataset %s: expected %s (n,), found %s", path, ItemText[kind], text);
  } else if (size[0] > (hsize_t)MAX_ROWS) {
    ReaderFault(r, "dataset %s has %llu rows, more than the %" PetscInt_FMT " this version can number", path,
                (unsigned long long)size[0], MAX_ROWS);
  } else {
    check_storage(r, dataset, type, space, path);
    *n = (PetscInt)size[0];
  }
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
  if (dataset >= 0) H5Dclose(dataset);
}

/* Explains why a dataset cannot be read: this HDF5 lacks the filter (compression by a plugin), or the data
   are damaged. */
static void fault_of(FileReader *r, hid_t dataset, const char *path)
{
  unsigned flags, config;
  size_t values = 0;
  char name[64] = "";
  const hid_t plan = dataset < 0 ? -1 : H5Dget_create_plist(dataset);
  for (int i = 0; plan >= 0 && i < H5Pget_nfilters(plan); i++) {
    const H5Z_filter_t filter = H5Pget_filter2(plan, (unsigned)i, &flags, &values, NULL, sizeof name, name,
                                               &config);
    if (filter >= 0 && H5Zfilter_avail(filter) <= 0)
      ReaderFault(r, "dataset %s is written with filter %d (%s), which this HDF5 has not: write it without",
                  path, (int)filter, name[0] ? name : "without a name");
  }
  if (plan >= 0) H5Pclose(plan);
  ReaderFault(r, "dataset %s cannot be read: the file is damaged", path);
}

/* Reads a dataset that has passed ReaderInspect. */
void ReaderNumbers(FileReader *r, const char *path, ItemKind kind, void *data)
{
  if (!ReaderSound(r)) return;
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT);
  if (dataset < 0 || H5Dread(dataset, memory_type(kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    fault_of(r, dataset, path);
  if (dataset >= 0) H5Dclose(dataset);
}

/* Reads group names of 64 bytes each; the last byte must be free for the closing zero. */
PetscErrorCode ReaderNames(FileReader *r, const char *path, PetscInt n, char (*names)[NAME_LENGTH])
{
  char(*buffer)[NAME_LENGTH + 1] = NULL;

  PetscFunctionBegin;
  if (!ReaderSound(r)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &buffer));
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT), type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, sizeof *buffer);
  if (dataset < 0 || H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer) < 0)
    fault_of(r, dataset, path);
  for (PetscInt i = 0; i < n && ReaderSound(r); i++) {
    buffer[i][NAME_LENGTH] = 0;
    check_name(r, "group", buffer[i]);
    if (ReaderSound(r)) memcpy(names[i], buffer[i], NAME_LENGTH);
  }
  if (dataset >= 0) H5Dclose(dataset);
  H5Tclose(type);
  PetscCall(PetscFree(buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads one attribute of "/", which must be a single value of this class; *read false: it is not. */
PetscBool ReaderAttribute(FileReader *r, const char *name, H5T_class_t class, hid_t memory, void *value)
{
  PetscBool done = PETSC_FALSE;
  if (H5Aexists(r->file, name) <= 0) return PETSC_FALSE;
  const hid_t attribute = H5Aopen(r->file, name, H5P_DEFAULT);
  if (attribute < 0) return PETSC_FALSE;
  const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  if (type >= 0 && space >= 0 && H5Tget_class(type) == class && H5Sget_simple_extent_npoints(space) == 1 &&
      (class != H5T_STRING || H5Tis_variable_str(type) == 0))
    done = H5Aread(attribute, memory, value) >= 0 ? PETSC_TRUE : PETSC_FALSE;
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
  H5Aclose(attribute);
  return done;
}

/* ---- named sets */

typedef struct {
  FileReader *reader;
  const char *kind;
  PetscInt n, capacity;
  char (*name)[NAME_LENGTH];
} NameList;

static herr_t add_member(hid_t group, const char *name, const H5L_info_t *link, void *context)
{
  NameList *list = context;
  (void)group;
  (void)link;
  check_name(list->reader, list->kind, name);
  if (!ReaderSound(list->reader)) return 1; /* a number other than 0 ends the iteration */
  if (list->n == list->capacity) {
    list->capacity = 2 * list->capacity + 16;
    if (PetscRealloc(sizeof *list->name * (size_t)list->capacity, &list->name)) return -1;
  }
  memcpy(list->name[list->n++], name, strlen(name) + 1);
  return 0;
}

/* Lists the names in an optional group, in alphabetical order, and allocates names. */
void ReaderMembers(FileReader *r, const char *path, const char *kind, PetscInt *n,
                   char (**names)[NAME_LENGTH])
{
  NameList list = {.reader = r, .kind = kind};
  PetscBool found;

  find_object(r, path, H5O_TYPE_GROUP, &found);
  if (found &&
      H5Literate_by_name(r->file, path, H5_INDEX_NAME, H5_ITER_INC, NULL, add_member, &list, H5P_DEFAULT) < 0)
    ReaderFault(r, "group %s cannot be read: the file is damaged", path);
  *n = list.n;
  *names = list.name;
}

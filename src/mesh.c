/* mesh.c: reads model.h5 (docs/mesh_format.md). The only C file that knows the format.

   The file comes from outside: type and shape of everything are looked at before anything is allocated, only
   what is stored in this file is followed (hard links, no external or virtual data), and the first fault ends
   the reading with one message. Whether the content makes sense is for mesh_check.c. */
#include "internal.h"
#include <hdf5.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const PetscInt MAX_ROWS = 1 << 28; /* 4 entries a row, and twice that for safety, fit in 31 bits */

/* ---- one fault, one message */

typedef struct {
  hid_t file;
  const char *path;
  char *message; /* "" as long as all is well: then, and only then, the functions below do their work */
} Reader;

static void Fault(Reader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void Fault(Reader *r, const char *format, ...)
{
  /* of a very long path the end is shown, so that the reason is never cut off */
  const size_t length = strlen(r->path), shown = PetscMin(length, 400);
  if (r->message[0]) return;
  const int used = snprintf(r->message, MESSAGE_LENGTH, "%s: ", r->path + length - shown);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(r->message + used, (size_t)(MESSAGE_LENGTH - used), format, arguments);
  va_end(arguments);
  /* names from the file may hold anything, the message is one line of text */
  for (char *c = r->message; *c; c++)
    if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
}

static inline PetscBool Sound(const Reader *r)
{
  return r->message[0] ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NameIsValid(const char *name)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
  const size_t length = strlen(name);
  if (length < 1 || length >= NAME_LENGTH || !strchr(letters, name[0])) return PETSC_FALSE;
  for (const char *c = name; *c; c++)
    if (!strchr(letters, *c) && !strchr("0123456789_-", *c)) return PETSC_FALSE;
  return PETSC_TRUE;
}

static void CheckName(Reader *r, const char *kind, const char *name)
{
  if (!NameIsValid(name))
    Fault(r, "%s '%.80s': a name is a letter, then letters, digits, _ or -, at most %d in all", kind, name,
          NAME_LENGTH - 1);
}

/* ---- what is in the file */

typedef enum { ITEM_REAL, ITEM_INT, ITEM_NAME } ItemKind;

static const char *const ItemText[] = {"float64", "int32", "bytes of length 64"};

static hid_t MemoryType(ItemKind kind)
{
  if (kind == ITEM_REAL) return H5T_NATIVE_DOUBLE;
  return sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32;
}

/* Is there an object of this type at path, each step of it a hard link? *found false without a fault: nothing
 * there. */
static void FindObject(Reader *r, const char *path, H5O_type_t type, PetscBool *found)
{
  const char *const what = type == H5O_TYPE_GROUP ? "group" : "dataset";
  char part[2 * NAME_LENGTH];
  H5L_info_t link;
  H5O_info_t object;

  *found = PETSC_FALSE;
  for (const char *slash = path; slash && Sound(r);) {
    slash = strchr(slash + 1, '/');
    snprintf(part, sizeof part, "%.*s", (int)(slash ? slash - path : (long)strlen(path)), path);
    const htri_t exists = H5Lexists(r->file, part, H5P_DEFAULT);
    if (exists == 0) return;
    if (exists < 0 || H5Lget_info(r->file, part, &link, H5P_DEFAULT) < 0)
      Fault(r, "%s %s cannot be read: the file is damaged", what, path);
    else if (link.type != H5L_TYPE_HARD)
      Fault(r, "%s %s: %s is a link, expected an object stored in this file", what, path, part);
  }
  if (!Sound(r)) return;
  if (H5Oget_info_by_name(r->file, path, &object, H5P_DEFAULT) < 0)
    Fault(r, "%s %s cannot be read: the file is damaged", what, path);
  else if (object.type != type)
    Fault(r, "%s: expected a %s, found %s", path, what,
          object.type == H5O_TYPE_GROUP     ? "a group"
          : object.type == H5O_TYPE_DATASET ? "a dataset"
                                            : "another object");
  *found = Sound(r);
}

/* "int64 (5,3)" */
static void Describe(hid_t type, int rank, const hsize_t *size, char text[128])
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

static PetscBool TypeIs(hid_t type, ItemKind kind)
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

/* Data outside this file, or declared and never written? */
static void CheckStorage(Reader *r, hid_t dataset, const char *path, hsize_t rows)
{
  const hid_t properties = H5Dget_create_plist(dataset);
  hsize_t file_size = 0;
  H5Fget_filesize(r->file, &file_size);
  const hsize_t stored = H5Dget_storage_size(dataset);
  if (properties < 0)
    Fault(r, "dataset %s cannot be read: the file is damaged", path);
  else if (H5Pget_layout(properties) == H5D_VIRTUAL || H5Pget_external_count(properties) > 0)
    Fault(r, "dataset %s: its data are in other files, expected data stored in this file", path);
  else if ((rows > 0 && stored == 0) || stored > file_size)
    Fault(r, "dataset %s: its data are not in the file", path);
  if (properties >= 0) H5Pclose(properties);
}

/* Type and shape of a dataset: (n,columns), or (n,) when columns is 0. Nothing is read yet. */
static void InspectDataset(Reader *r, const char *path, ItemKind kind, int columns, PetscInt *n)
{
  PetscBool found;
  hsize_t size[H5S_MAX_RANK] = {0};
  char text[128];

  *n = 0;
  FindObject(r, path, H5O_TYPE_DATASET, &found);
  if (!Sound(r)) return;
  if (!found) {
    Fault(r, "dataset %s is missing", path);
    return;
  }
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT), type = H5Dget_type(dataset),
              space = H5Dget_space(dataset);
  const int rank = H5Sget_simple_extent_dims(space, size, NULL);
  if (dataset < 0 || type < 0 || space < 0 || rank < 0) {
    Fault(r, "dataset %s cannot be read: the file is damaged", path);
  } else if (!TypeIs(type, kind) || rank != (columns ? 2 : 1) || (columns && size[1] != (hsize_t)columns)) {
    Describe(type, rank, size, text);
    if (columns)
      Fault(r, "dataset %s: expected %s (n,%d), found %s", path, ItemText[kind], columns, text);
    else
      Fault(r, "dataset %s: expected %s (n,), found %s", path, ItemText[kind], text);
  } else if (size[0] > (hsize_t)MAX_ROWS) {
    Fault(r, "dataset %s has %llu rows, more than the %" PetscInt_FMT " this version can number", path,
          (unsigned long long)size[0], MAX_ROWS);
  } else {
    CheckStorage(r, dataset, path, size[0]);
    *n = (PetscInt)size[0];
  }
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
  if (dataset >= 0) H5Dclose(dataset);
}

/* Reads a dataset that InspectDataset has seen. */
static void ReadNumbers(Reader *r, const char *path, ItemKind kind, void *data)
{
  if (!Sound(r)) return;
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT);
  if (dataset < 0 || H5Dread(dataset, MemoryType(kind), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    Fault(r, "dataset %s cannot be read: the file is damaged", path);
  if (dataset >= 0) H5Dclose(dataset);
}

/* Group names: 64 bytes each, of which the last one must be free for the closing zero. */
static PetscErrorCode ReadNames(Reader *r, const char *path, PetscInt n, char (*names)[NAME_LENGTH])
{
  char(*buffer)[NAME_LENGTH + 1] = NULL;

  PetscFunctionBegin;
  if (!Sound(r)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &buffer));
  const hid_t dataset = H5Dopen2(r->file, path, H5P_DEFAULT), type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, sizeof *buffer);
  if (dataset < 0 || H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer) < 0)
    Fault(r, "dataset %s cannot be read: the file is damaged", path);
  for (PetscInt i = 0; i < n && Sound(r); i++) {
    buffer[i][NAME_LENGTH] = 0;
    CheckName(r, "group", buffer[i]);
    if (Sound(r)) memcpy(names[i], buffer[i], NAME_LENGTH);
  }
  if (dataset >= 0) H5Dclose(dataset);
  H5Tclose(type);
  PetscCall(PetscFree(buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads one attribute of "/" that must be a single value of this class; *read false: it is not. */
static PetscBool ReadAttribute(Reader *r, const char *name, H5T_class_t class, hid_t memory, void *value)
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

static void CheckHeader(Reader *r)
{
  char format[NAME_LENGTH] = "";
  int version = 0;

  if (!Sound(r)) return;
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, sizeof format);
  if (!ReadAttribute(r, "format", H5T_STRING, text, format))
    Fault(r, "attribute format is missing or not fixed-length bytes, expected 'quoin-mesh'");
  else if (strcmp(format, "quoin-mesh"))
    Fault(r, "attribute format is '%.63s', expected 'quoin-mesh'", format);
  else if (!ReadAttribute(r, "version", H5T_INTEGER, H5T_NATIVE_INT, &version))
    Fault(r, "attribute version is missing or not an integer, expected 1");
  else if (version != 1)
    Fault(r, "attribute version is %d, expected 1", version);
  H5Tclose(text);
}

/* ---- named sets */

typedef struct {
  Reader *reader;
  const char *kind;
  PetscInt n, capacity;
  char (*name)[NAME_LENGTH];
} NameList;

static herr_t AddMember(hid_t group, const char *name, const H5L_info_t *link, void *context)
{
  NameList *list = context;
  (void)group;
  (void)link;
  CheckName(list->reader, list->kind, name);
  if (!Sound(list->reader)) return 1; /* ends the iteration */
  if (list->n == list->capacity) {
    list->capacity = 2 * list->capacity + 16;
    if (PetscRealloc(sizeof *list->name * (size_t)list->capacity, &list->name)) return -1;
  }
  memcpy(list->name[list->n++], name, strlen(name) + 1);
  return 0;
}

/* Names in an optional group, in alphabetical order. names is allocated here. */
static void ListMembers(Reader *r, const char *path, const char *kind, PetscInt *n,
                        char (**names)[NAME_LENGTH])
{
  NameList list = {.reader = r, .kind = kind};
  PetscBool found;

  FindObject(r, path, H5O_TYPE_GROUP, &found);
  if (found &&
      H5Literate_by_name(r->file, path, H5_INDEX_NAME, H5_ITER_INC, NULL, AddMember, &list, H5P_DEFAULT) < 0)
    Fault(r, "group %s cannot be read: the file is damaged", path);
  *n = list.n;
  *names = list.name;
}

/* ---- the whole mesh */

/* Counts and names; every dataset is inspected. */
static PetscErrorCode InspectMesh(Reader *r, BlockMesh *mesh)
{
  PetscInt n_rows;
  char path[2 * NAME_LENGTH];

  PetscFunctionBegin;
  CheckHeader(r);
  InspectDataset(r, "/vertices", ITEM_REAL, 2, &mesh->n_vertices);
  InspectDataset(r, "/blocks", ITEM_INT, 4, &mesh->n_blocks);
  InspectDataset(r, "/block_group", ITEM_INT, 0, &n_rows);
  if (n_rows != mesh->n_blocks)
    Fault(r, "/block_group has %" PetscInt_FMT " rows, /blocks has %" PetscInt_FMT, n_rows, mesh->n_blocks);
  /* every vertex belongs to a block, so this many cannot be: better said before they are read */
  if (mesh->n_vertices / 4 > mesh->n_blocks)
    Fault(r,
          "%" PetscInt_FMT " vertices are too many for %" PetscInt_FMT " blocks: some vertex is in no block",
          mesh->n_vertices, mesh->n_blocks);
  InspectDataset(r, "/groups/name", ITEM_NAME, 0, &mesh->n_groups);
  InspectDataset(r, "/groups/rigid", ITEM_INT, 0, &n_rows);
  if (n_rows != mesh->n_groups)
    Fault(r, "/groups/rigid has %" PetscInt_FMT " rows, /groups/name has %" PetscInt_FMT, n_rows,
          mesh->n_groups);

  ListMembers(r, "/face_sets", "face set", &mesh->n_face_sets, &mesh->face_set_names);
  PetscCall(PetscCalloc1(mesh->n_face_sets, &mesh->face_sets));
  for (PetscInt s = 0; s < mesh->n_face_sets && Sound(r); s++) {
    memcpy(mesh->face_sets[s].name, mesh->face_set_names[s], NAME_LENGTH);
    snprintf(path, sizeof path, "/face_sets/%s", mesh->face_set_names[s]);
    InspectDataset(r, path, ITEM_INT, 2, &mesh->face_sets[s].n);
  }
  ListMembers(r, "/points", "point", &mesh->n_points, &mesh->point_names);
  for (PetscInt p = 0; p < mesh->n_points && Sound(r); p++) {
    snprintf(path, sizeof path, "/points/%s", mesh->point_names[p]);
    InspectDataset(r, path, ITEM_INT, 0, &n_rows);
    if (n_rows != 1) Fault(r, "dataset %s: expected int32 (1,), found (%" PetscInt_FMT ",)", path, n_rows);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates and reads what InspectMesh has found. */
static PetscErrorCode ReadArrays(Reader *r, BlockMesh *mesh)
{
  char path[2 * NAME_LENGTH];

  PetscFunctionBegin;
  if (!Sound(r)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(2 * (size_t)mesh->n_vertices, &mesh->X));
  ReadNumbers(r, "/vertices", ITEM_REAL, mesh->X);
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, &mesh->blocks));
  ReadNumbers(r, "/blocks", ITEM_INT, mesh->blocks);
  PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->block_group));
  ReadNumbers(r, "/block_group", ITEM_INT, mesh->block_group);
  PetscCall(PetscCalloc1(mesh->n_groups, &mesh->group_names));
  PetscCall(ReadNames(r, "/groups/name", mesh->n_groups, mesh->group_names));
  PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_rigid));
  ReadNumbers(r, "/groups/rigid", ITEM_INT, mesh->group_rigid);
  for (PetscInt g = 0; g < mesh->n_groups && Sound(r);
       g++) /* here: a scene may override the flags before MeshCheck */
    if (mesh->group_rigid[g] != 0 && mesh->group_rigid[g] != 1)
      Fault(r, "group '%s': rigid is %" PetscInt_FMT ", expected 0 or 1", mesh->group_names[g],
            mesh->group_rigid[g]);
  for (PetscInt s = 0; s < mesh->n_face_sets; s++) {
    PetscCall(PetscMalloc1(2 * (size_t)mesh->face_sets[s].n, &mesh->face_sets[s].faces));
    snprintf(path, sizeof path, "/face_sets/%s", mesh->face_set_names[s]);
    ReadNumbers(r, path, ITEM_INT, mesh->face_sets[s].faces);
  }
  PetscCall(PetscMalloc1(mesh->n_points, &mesh->point_vertex));
  for (PetscInt p = 0; p < mesh->n_points; p++) {
    snprintf(path, sizeof path, "/points/%s", mesh->point_names[p]);
    ReadNumbers(r, path, ITEM_INT, &mesh->point_vertex[p]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether the model fits into memory, before anything is allocated for it. */
static PetscBool Fits(Reader *r, const BlockMesh *mesh, PetscMPIInt size, PetscMPIInt local)
{
  const double needed = MemoryNeeded(mesh->n_vertices, size, local), available = MemoryAvailable();
  if (!Sound(r) || needed <= available) return PETSC_TRUE;
  Fault(r,
        "%" PetscInt_FMT " vertices and %" PetscInt_FMT " blocks on %d rank%s need about %.3g GB of memory, "
        "%.3g GB are available",
        mesh->n_vertices, mesh->n_blocks, size, size == 1 ? "" : "s", 1e-9 * needed, 1e-9 * available);
  return PETSC_FALSE;
}

static PetscErrorCode ReadFile(const char *file, PetscMPIInt size, PetscMPIInt local, BlockMesh *mesh,
                               PetscBool *fits, char *message)
{
  Reader r = {.path = file, .message = message};
  struct stat status;
  H5E_auto2_t print;
  void *print_data;

  PetscFunctionBegin;
  message[0] = 0;
  if (stat(file, &status))
    Fault(&r, "no such file");
  else if (!S_ISREG(status.st_mode))
    Fault(&r, "not a file");
  else if (access(file, R_OK))
    Fault(&r, "no permission to read it");
  if (!Sound(&r)) PetscFunctionReturn(PETSC_SUCCESS);

  /* HDF5's own report of an error is a page long and says nothing to the user */
  H5Eget_auto2(H5E_DEFAULT, &print, &print_data);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  r.file = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (r.file < 0) {
    Fault(&r, "not an HDF5 file, or cut off");
  } else {
    PetscCall(InspectMesh(&r, mesh));
    *fits = Fits(&r, mesh, size, local);
    if (*fits) PetscCall(ReadArrays(&r, mesh));
    H5Fclose(r.file);
  }
  H5Eset_auto2(H5E_DEFAULT, print, print_data);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetFileNumbers(BlockMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->block_file));
  PetscCall(PetscMalloc1(mesh->n_vertices, &mesh->vertex_file));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) mesh->block_file[b] = b;
  for (PetscInt v = 0; v < mesh->n_vertices; v++) mesh->vertex_file[v] = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts, names and the groups' rigid flags, which all ranks need to understand the scene. */
static PetscErrorCode ShareNames(MPI_Comm comm, PetscMPIInt rank, BlockMesh *mesh)
{
  PetscInt counts[4] = {mesh->n_groups, mesh->n_face_sets, mesh->n_points, mesh->n_bodies};

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(counts, 4, MPIU_INT, 0, comm));
  mesh->n_groups = counts[0];
  mesh->n_face_sets = counts[1];
  mesh->n_points = counts[2];
  mesh->n_bodies = counts[3];
  if (rank) {
    PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_names));
    PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_rigid));
    PetscCall(PetscMalloc1(mesh->n_face_sets, &mesh->face_set_names));
    PetscCall(PetscMalloc1(mesh->n_points, &mesh->point_names));
    PetscCall(PetscCalloc1(mesh->n_face_sets, &mesh->face_sets));
  }
  PetscCallMPI(MPI_Bcast(mesh->group_names, NAME_LENGTH * mesh->n_groups, MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->group_rigid, mesh->n_groups, MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->face_set_names, NAME_LENGTH * mesh->n_face_sets, MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->point_names, NAME_LENGTH * mesh->n_points, MPI_CHAR, 0, comm));
  if (rank)
    for (PetscInt s = 0; s < mesh->n_face_sets; s++)
      memcpy(mesh->face_sets[s].name, mesh->face_set_names[s], NAME_LENGTH);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshRead(MPI_Comm comm, const char *file, BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank, size, local;
  PetscBool fits = PETSC_TRUE;
  MPI_Comm machine;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(mesh, sizeof *mesh));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_size(machine, &local));
  PetscCallMPI(MPI_Comm_free(&machine));
  if (rank == 0) {
    PetscCall(ReadFile(file, size, local, mesh, &fits, message));
    if (message[0]) {
      PetscCall(MeshDestroy(mesh));
    } else {
      PetscCall(SetFileNumbers(mesh));
      PetscCall(MeshBodies(mesh));
    }
  }
  PetscCallMPI(MPI_Bcast(&fits, 1, MPI_PETSC_BOOL, 0, comm));
  PetscCall(Refuse(comm, fits ? PETSC_ERR_USER_INPUT : ERROR_MEMORY, message));
  PetscCall(ShareNames(comm, rank, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshDestroy(BlockMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->X));
  PetscCall(PetscFree(mesh->blocks));
  PetscCall(PetscFree(mesh->block_group));
  PetscCall(PetscFree(mesh->body));
  PetscCall(PetscFree(mesh->part));
  PetscCall(PetscFree(mesh->block_file));
  PetscCall(PetscFree(mesh->vertex_file));
  PetscCall(PetscFree(mesh->group_names));
  PetscCall(PetscFree(mesh->group_rigid));
  for (PetscInt s = 0; s < mesh->n_face_sets && mesh->face_sets; s++)
    PetscCall(PetscFree(mesh->face_sets[s].faces));
  PetscCall(PetscFree(mesh->face_sets));
  PetscCall(PetscFree(mesh->face_set_names));
  PetscCall(PetscFree(mesh->point_names));
  PetscCall(PetscFree(mesh->point_vertex));
  PetscCall(PetscMemzero(mesh, sizeof *mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

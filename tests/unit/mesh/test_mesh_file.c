/* Reading model.h5: what is read, what is refused and with which words, files that are cut off.
   ranks: 1 2 */
#include "small_mesh.h"
#include "check.h"
#include "quoin.h"
#include <fcntl.h>
#include <hdf5.h>
#include <stdlib.h>
#include <unistd.h>

static char folder[PETSC_MAX_PATH_LEN], model[PETSC_MAX_PATH_LEN + 16];
static PetscMPIInt rank;

/* ---- writing; rank 0 only */

typedef enum { NOTHING, REAL64, REAL32, INT32, INT64, UINT32, BYTES64, BYTES32, TEXT } Stored;

static hid_t FileType(Stored stored)
{
  const hid_t plain[] = {-1, H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I32LE, H5T_STD_I64LE, H5T_STD_U32LE};
  hid_t type = H5Tcopy(stored < BYTES64 ? plain[stored] : H5T_C_S1);
  if (stored == BYTES64) H5Tset_size(type, 64);
  if (stored == BYTES32) H5Tset_size(type, 32);
  if (stored == TEXT) H5Tset_size(type, H5T_VARIABLE);
  if (stored == BYTES64) H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

static hid_t MemoryType(Stored stored)
{
  if (stored == INT32) return H5Tcopy(sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32);
  return FileType(stored);
}

/* data NULL: zeros */
static void Put(hid_t file, const char *path, Stored stored, int n_dims, const hsize_t *size,
                const void *data)
{
  const hid_t type = FileType(stored), memory = MemoryType(stored), links = H5Pcreate(H5P_LINK_CREATE);
  const hid_t space = n_dims ? H5Screate_simple(n_dims, size, NULL) : H5Screate(H5S_SCALAR);
  void *zeros = calloc((size_t)H5Sget_simple_extent_npoints(space) + 1, 64);
  H5Pset_create_intermediate_group(links, 1);
  const hid_t dataset = H5Dcreate2(file, path, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
  if (stored != TEXT) H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data ? data : zeros);
  H5Dclose(dataset);
  H5Sclose(space);
  H5Pclose(links);
  H5Tclose(memory);
  H5Tclose(type);
  free(zeros);
}

static void PutAttribute(hid_t file, const char *name, hid_t type, const void *value)
{
  if (H5Aexists(file, name) > 0) H5Adelete(file, name);
  const hid_t space = H5Screate(H5S_SCALAR),
              attribute = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, type, value);
  H5Aclose(attribute);
  H5Sclose(space);
}

static void PutFormat(hid_t file, const char *format)
{
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, strlen(format));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  PutAttribute(file, "format", type, format);
  H5Tclose(type);
}

static hid_t WriteSmallMesh(void)
{
  const hid_t file = H5Fcreate(model, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const int version = 1;
  char names[SMALL_GROUPS][NAME_LENGTH] = {{0}}, path[128];
  PutFormat(file, "quoin-mesh");
  PutAttribute(file, "version", H5T_NATIVE_INT, &version);
  for (int g = 0; g < SMALL_GROUPS; g++) strcpy(names[g], small_groups[g]);
  Put(file, "/vertices", REAL64, 2, (hsize_t[]){SMALL_VERTICES, 2}, small_X);
  Put(file, "/blocks", INT32, 2, (hsize_t[]){SMALL_BLOCKS, 4}, small_blocks);
  Put(file, "/block_group", INT32, 1, (hsize_t[]){SMALL_BLOCKS}, small_block_group);
  Put(file, "/groups/name", BYTES64, 1, (hsize_t[]){SMALL_GROUPS}, names);
  Put(file, "/groups/rigid", INT32, 1, (hsize_t[]){SMALL_GROUPS}, small_rigid);
  /* last one first: the reader sorts */
  for (int s = SMALL_SETS - 1; s >= 0; s--) {
    snprintf(path, sizeof path, "/face_sets/%s", small_sets[s]);
    Put(file, path, INT32, 2, (hsize_t[]){(hsize_t)small_set_n[s], 2}, small_faces[s]);
  }
  for (int p = SMALL_POINTS - 1; p >= 0; p--) {
    snprintf(path, sizeof path, "/points/%s", small_points[p]);
    Put(file, path, INT32, 1, (hsize_t[]){1}, &small_point_vertex[p]);
  }
  /* a generator's own notes are ignored */
  Put(file, "/notes/author", INT64, 1, (hsize_t[]){7}, NULL);
  return file;
}

/* ---- reading */

static int saved_stderr;

/* What CheckMessage prints goes to a file meanwhile. */
static void CaptureBegin(void)
{
  char path[PETSC_MAX_PATH_LEN + 16];
  snprintf(path, sizeof path, "%s/stderr.%d", folder, rank);
  fflush(stderr);
  saved_stderr = dup(2);
  const int captured = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
  dup2(captured, 2);
  close(captured);
}

static void CaptureEnd(char *text, size_t size)
{
  char path[PETSC_MAX_PATH_LEN + 16];
  fflush(stderr);
  dup2(saved_stderr, 2);
  close(saved_stderr);
  snprintf(path, sizeof path, "%s/stderr.%d", folder, rank);
  FILE *file = fopen(path, "r");
  text[fread(text, 1, size - 1, file)] = 0;
  fclose(file);
  unlink(path);
}

/* The model is refused on all ranks, by a line of rank 0 with this fragment and the file's
   name, and nothing remains. */
static PetscErrorCode ExpectRefusal(const char *path, const char *fragment)
{
  char text[4 * MESSAGE_LENGTH];
  BlockMesh mesh;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  CaptureBegin();
  const PetscErrorCode code = MeshRead(PETSC_COMM_WORLD, path, &mesh);
  CaptureEnd(text, sizeof text);
  ENSURE(code == PETSC_ERR_USER_INPUT);
  ENSURE(mesh.X == NULL && mesh.n_blocks == 0 && mesh.n_groups == 0 && mesh.face_set_names == NULL);
  if (rank == 0 && (!strstr(text, fragment) || !strstr(text, path)))
    fprintf(stderr, "expected '%s', found '%s'\n", fragment, text);
  ENSURE(rank != 0 || (strstr(text, fragment) && strstr(text, path)));
  PetscCall(MeshDestroy(&mesh));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void CompareArrays(const BlockMesh *mesh)
{
  ENSURE(mesh->n_vertices == SMALL_VERTICES && mesh->n_blocks == SMALL_BLOCKS);
  ENSURE(!memcmp(mesh->X, small_X, sizeof small_X));
  ENSURE(!memcmp(mesh->blocks, small_blocks, sizeof small_blocks));
  ENSURE(!memcmp(mesh->block_group, small_block_group, sizeof small_block_group));
  ENSURE(!memcmp(mesh->point_vertex, small_point_vertex, sizeof small_point_vertex));
  for (int s = 0; s < SMALL_SETS; s++) {
    ENSURE(mesh->face_sets[s].n == small_set_n[s]);
    for (int i = 0; i < 2 * small_set_n[s]; i++) ENSURE(mesh->face_sets[s].faces[i] == small_faces[s][i]);
  }
  for (int b = 0; b < SMALL_BLOCKS; b++) ENSURE(mesh->block_file[b] == b && mesh->body[b] == (b == 2));
  for (int v = 0; v < SMALL_VERTICES; v++) ENSURE(mesh->vertex_file[v] == v);
}

static PetscErrorCode TestRead(void)
{
  BlockMesh mesh;

  PetscFunctionBegin;
  if (rank == 0) H5Fclose(WriteSmallMesh());
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscCall(MeshRead(PETSC_COMM_WORLD, model, &mesh));
  /* everywhere: names, flags, counts of named things and bodies */
  ENSURE(mesh.n_groups == SMALL_GROUPS && mesh.n_face_sets == SMALL_SETS && mesh.n_points == SMALL_POINTS);
  ENSURE(mesh.n_bodies == 2);
  for (int g = 0; g < SMALL_GROUPS; g++)
    ENSURE(!strcmp(mesh.group_names[g], small_groups[g]) && mesh.group_rigid[g] == small_rigid[g]);
  for (int s = 0; s < SMALL_SETS; s++)
    ENSURE(!strcmp(mesh.face_set_names[s], small_sets[s]) && !strcmp(mesh.face_sets[s].name, small_sets[s]));
  for (int p = 0; p < SMALL_POINTS; p++) ENSURE(!strcmp(mesh.point_names[p], small_points[p]));
  if (rank == 0)
    CompareArrays(&mesh);
  else
    ENSURE(mesh.n_vertices == 0 && mesh.n_blocks == 0 && mesh.face_sets[0].n == 0);
  PetscCall(MeshDestroy(&mesh));
  ENSURE(mesh.X == NULL && mesh.n_groups == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without the optional groups; the names' longest length. */
static PetscErrorCode TestReadBare(void)
{
  char names[SMALL_GROUPS][NAME_LENGTH] = {{0}};
  BlockMesh mesh;

  PetscFunctionBegin;
  memset(names[0], 'a', NAME_LENGTH - 1);
  names[1][0] = 'Z';
  if (rank == 0) {
    const hid_t file = WriteSmallMesh();
    H5Ldelete(file, "/face_sets", H5P_DEFAULT);
    H5Ldelete(file, "/points", H5P_DEFAULT);
    H5Ldelete(file, "/groups/name", H5P_DEFAULT);
    Put(file, "/groups/name", BYTES64, 1, (hsize_t[]){SMALL_GROUPS}, names);
    H5Fclose(file);
  }
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscCall(MeshRead(PETSC_COMM_WORLD, model, &mesh));
  ENSURE(mesh.n_face_sets == 0 && mesh.n_points == 0);
  ENSURE(!strcmp(mesh.group_names[0], names[0]) && !strcmp(mesh.group_names[1], "Z"));
  PetscCall(MeshDestroy(&mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- refusals: one dataset replaced by zeros of another type or shape, or taken away */

typedef struct {
  const char *path;
  Stored stored;
  int n_dims;
  hsize_t size[3];
  const char *fragment;
} Replacement;

static const Replacement replacements[] = {
    {"/vertices", NOTHING, 0, {0}, "dataset /vertices is missing"},
    {"/vertices", REAL32, 2, {9, 2}, "dataset /vertices: expected float64 (n,2), found float32 (9,2)"},
    {"/vertices", INT32, 2, {9, 2}, "dataset /vertices: expected float64 (n,2), found int32 (9,2)"},
    {"/vertices", REAL64, 2, {9, 3}, "dataset /vertices: expected float64 (n,2), found float64 (9,3)"},
    {"/vertices", REAL64, 1, {18}, "dataset /vertices: expected float64 (n,2), found float64 (18,)"},
    {"/vertices", REAL64, 2, {100, 2}, "100 vertices are too many for 3 blocks"},
    {"/blocks", NOTHING, 0, {0}, "dataset /blocks is missing"},
    {"/blocks", INT64, 2, {3, 4}, "dataset /blocks: expected int32 (n,4), found int64 (3,4)"},
    {"/blocks", UINT32, 2, {3, 4}, "dataset /blocks: expected int32 (n,4), found uint32 (3,4)"},
    {"/blocks", REAL64, 2, {3, 4}, "dataset /blocks: expected int32 (n,4), found float64 (3,4)"},
    {"/blocks", INT32, 2, {3, 3}, "dataset /blocks: expected int32 (n,4), found int32 (3,3)"},
    {"/blocks", INT32, 3, {3, 4, 1}, "dataset /blocks: expected int32 (n,4), found int32 (3,4,..)"},
    {"/blocks", INT32, 0, {0}, "dataset /blocks: expected int32 (n,4), found int32 ()"},
    {"/blocks", TEXT, 1, {3}, "dataset /blocks: expected int32 (n,4), found strings of variable length (3,)"},
    {"/block_group", NOTHING, 0, {0}, "dataset /block_group is missing"},
    {"/block_group", INT32, 1, {4}, "/block_group has 4 rows, /blocks has 3"},
    {"/block_group", INT32, 2, {3, 1}, "dataset /block_group: expected int32 (n,), found int32 (3,1)"},
    {"/groups", NOTHING, 0, {0}, "dataset /groups/name is missing"},
    {"/groups", INT32, 1, {1}, "dataset /groups/name cannot be read"},
    {"/groups/name",
     BYTES32,
     1,
     {2},
     "dataset /groups/name: expected bytes of length 64 (n,), found bytes of length 32"},
    {"/groups/name",
     TEXT,
     1,
     {2},
     "dataset /groups/name: expected bytes of length 64 (n,), found strings of variable"},
    {"/groups/name",
     BYTES64,
     1,
     {2},
     "group '': a name is a letter, then letters, digits, _ or -, at most 63"},
    {"/groups/rigid", NOTHING, 0, {0}, "dataset /groups/rigid is missing"},
    {"/groups/rigid", INT32, 1, {3}, "/groups/rigid has 3 rows, /groups/name has 2"},
    {"/face_sets", INT32, 1, {1}, "/face_sets: expected a group, found a dataset"},
    {"/face_sets/joint", INT32, 1, {4}, "dataset /face_sets/joint: expected int32 (n,2), found int32 (4,)"},
    {"/face_sets/joint",
     INT32,
     2,
     {4, 3},
     "dataset /face_sets/joint: expected int32 (n,2), found int32 (4,3)"},
    {"/face_sets/sub/x", INT32, 2, {1, 2}, "/face_sets/sub: expected a dataset, found a group"},
    {"/face_sets/2nd", INT32, 2, {1, 2}, "face set '2nd': a name is a letter"},
    {"/face_sets/no good", INT32, 2, {1, 2}, "face set 'no good': a name is a letter"},
    {"/face_sets/a\n\033b", INT32, 2, {1, 2}, "face set 'a??b': a name is a letter"},
    {"/face_sets/a_name_of_sixty_four_characters_is_one_too_many_for_this_format_",
     INT32,
     2,
     {1, 2},
     "at most 63"},
    {"/points/crest", INT32, 1, {2}, "dataset /points/crest: expected int32 (1,), found (2,)"},
    {"/points/crest", INT32, 0, {0}, "dataset /points/crest: expected int32 (n,), found int32 ()"},
    {"/points/crest", REAL64, 1, {1}, "dataset /points/crest: expected int32 (n,), found float64 (1,)"},
    {"/points/f\303\251", INT32, 1, {1}, "a name is a letter"},
};

static PetscErrorCode TestReplacements(void)
{
  PetscFunctionBegin;
  for (size_t i = 0; i < sizeof replacements / sizeof *replacements; i++) {
    const Replacement *r = &replacements[i];
    if (rank == 0) {
      const hid_t file = WriteSmallMesh();
      H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
      if (H5Lexists(file, r->path, H5P_DEFAULT) > 0) H5Ldelete(file, r->path, H5P_DEFAULT);
      if (r->stored != NOTHING) Put(file, r->path, r->stored, r->n_dims, r->size, NULL);
      H5Fclose(file);
    }
    PetscCall(ExpectRefusal(model, r->fragment));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- refusals: header, links, data elsewhere */

static void PutEmpty(hid_t file, const char *path, hsize_t rows, hid_t properties)
{
  const hid_t space = H5Screate_simple(2, (hsize_t[]){rows, 4}, NULL);
  H5Dclose(H5Dcreate2(file, path, H5T_STD_I32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  H5Sclose(space);
}

static const char *const spoilings[] = {
    "attribute format is missing",
    "attribute format is 'quoin-mush', expected 'quoin-mesh'",
    "attribute format is missing or not fixed-length bytes",
    "attribute version is missing",
    "attribute version is 2, expected 1",
    "attribute version is missing or not an integer",
    "dataset /blocks: /blocks is a link, expected an object stored in this file",
    "dataset /groups/name: /groups is a link",
    "dataset /face_sets/zz: /face_sets/zz is a link",
    "dataset /blocks: its data are not in the file",
    "dataset /blocks has 1000000000 rows, more than the 268435456",
    "dataset /blocks: its data are in other files",
    "dataset /blocks: its data are in other files",
    "group '1st': a name is a letter",
    "group 'bed-rock_2': rigid is 2, expected 0 or 1",
    "attribute version is 4294967297, expected 1",
    "dataset /blocks is written with filter 300 (of this test), which this HDF5 has not"};

static size_t Unchanged(unsigned flags, size_t n, const unsigned values[], size_t bytes, size_t *size,
                        void **buffer)
{
  (void)flags, (void)n, (void)values, (void)size, (void)buffer;
  return bytes;
}

/* Data behind a filter that is gone when they are read. */
static void PutFiltered(hid_t file)
{
  static const H5Z_class2_t filter = {H5Z_CLASS_T_VERS, 300, 1, 1, "of this test", NULL, NULL, Unchanged};
  const hsize_t size[2] = {3, 4};
  const hid_t space = H5Screate_simple(2, size, NULL), properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Zregister(&filter);
  H5Ldelete(file, "/blocks", H5P_DEFAULT);
  H5Pset_chunk(properties, 2, size);
  H5Pset_filter(properties, filter.id, H5Z_FLAG_MANDATORY, 0, NULL);
  const hid_t set = H5Dcreate2(file, "/blocks", H5T_STD_I32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  ENSURE(set >= 0 && H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, small_blocks) >= 0);
  H5Dclose(set);
  H5Sclose(space);
  H5Pclose(properties);
  ENSURE(H5Zunregister(filter.id) >= 0);
}

static void Spoil(int i, hid_t file)
{
  const double real = 1;
  const int two = 2;
  const long long lower_half_1 = (1LL << 32) + 1;
  const char *text = "quoin-mesh";
  const hid_t variable = H5Tcopy(H5T_C_S1), properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Tset_size(variable, H5T_VARIABLE);
  if (i == 0) H5Adelete(file, "format");
  if (i == 1) PutFormat(file, "quoin-mush");
  if (i == 2) PutAttribute(file, "format", variable, &text);
  if (i == 3) H5Adelete(file, "version");
  if (i == 4) PutAttribute(file, "version", H5T_NATIVE_INT, &two);
  if (i == 5) PutAttribute(file, "version", H5T_NATIVE_DOUBLE, &real);
  if (i == 6 || (i >= 9 && i <= 12))
    H5Lmove(file, "/blocks", file, "/other_blocks", H5P_DEFAULT, H5P_DEFAULT);
  if (i == 6) H5Lcreate_soft("/other_blocks", file, "/blocks", H5P_DEFAULT, H5P_DEFAULT);
  if (i == 7) {
    H5Lmove(file, "/groups", file, "/other_groups", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/other_groups", file, "/groups", H5P_DEFAULT, H5P_DEFAULT);
  }
  if (i == 8) H5Lcreate_external("elsewhere.h5", "/x", file, "/face_sets/zz", H5P_DEFAULT, H5P_DEFAULT);
  if (i == 9) PutEmpty(file, "/blocks", 3, H5P_DEFAULT);
  if (i == 10) PutEmpty(file, "/blocks", 1000000000, H5P_DEFAULT);
  if (i == 11) H5Pset_external(properties, "elsewhere.raw", 0, 48);
  if (i == 12) {
    const hid_t space = H5Screate_simple(2, (hsize_t[]){3, 4}, NULL);
    H5Pset_virtual(properties, space, "elsewhere.h5", "/blocks", space);
    H5Sclose(space);
  }
  if (i == 11 || i == 12) PutEmpty(file, "/blocks", 3, properties);
  if (i == 13) {
    char names[SMALL_GROUPS][NAME_LENGTH] = {"ok", "1st"};
    H5Ldelete(file, "/groups/name", H5P_DEFAULT);
    Put(file, "/groups/name", BYTES64, 1, (hsize_t[]){SMALL_GROUPS}, names);
  }
  if (i == 14) {
    H5Ldelete(file, "/groups/rigid", H5P_DEFAULT);
    Put(file, "/groups/rigid", INT32, 1, (hsize_t[]){SMALL_GROUPS}, (PetscInt[]){1, 2});
  }
  if (i == 15) PutAttribute(file, "version", H5T_NATIVE_LLONG, &lower_half_1);
  if (i == 16) PutFiltered(file);
  H5Pclose(properties);
  H5Tclose(variable);
}

static PetscErrorCode TestSpoilings(void)
{
  PetscFunctionBegin;
  for (int i = 0; i < (int)(sizeof spoilings / sizeof *spoilings); i++) {
    if (rank == 0) {
      const hid_t file = WriteSmallMesh();
      Spoil(i, file);
      H5Fclose(file);
    }
    PetscCall(ExpectRefusal(model, spoilings[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- files that are none, or not whole */

static void WriteBytes(const char *bytes, size_t n)
{
  FILE *file = fopen(model, "wb");
  fwrite(bytes, 1, n, file);
  fclose(file);
}

static PetscErrorCode TestNoMesh(void)
{
  char path[PETSC_MAX_PATH_LEN + 32];

  PetscFunctionBegin;
  snprintf(path, sizeof path, "%s/nowhere.h5", folder);
  PetscCall(ExpectRefusal(path, "nowhere.h5: no such file; a block mesh is written by the mesh.py"));
  PetscCall(ExpectRefusal(folder, "not a file"));
  if (rank == 0) WriteBytes("vertices: 3\n", 12);
  PetscCall(ExpectRefusal(model, "model.h5: not an HDF5 file, or cut off"));
  if (rank == 0) WriteBytes("", 0);
  PetscCall(ExpectRefusal(model, "model.h5: not an HDF5 file, or cut off"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestCutOff(void)
{
  static char bytes[1 << 16];
  long size = 0;

  PetscFunctionBegin;
  if (rank == 0) {
    H5Fclose(WriteSmallMesh());
    FILE *file = fopen(model, "rb");
    size = (long)fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    ENSURE(size > 1000 && size < (long)sizeof bytes);
  }
  PetscCallMPI(MPI_Bcast(&size, 1, MPI_LONG, 0, PETSC_COMM_WORLD));
  /* by single bytes at both ends, by steps of an odd length between */
  for (long n = 1; n < size; n += n < 100 || n > size - 50 ? 1 : 61) {
    if (rank == 0) WriteBytes(bytes, (size_t)n);
    PetscCall(ExpectRefusal(model, "cut off"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(QuoinErrorHandlerPush());
  snprintf(folder, sizeof folder, "/tmp/quoin-mesh-XXXXXX");
  if (rank == 0 && !mkdtemp(folder)) PetscCallMPI(MPI_Abort(PETSC_COMM_WORLD, 1));
  PetscCallMPI(MPI_Bcast(folder, sizeof folder, MPI_CHAR, 0, PETSC_COMM_WORLD));
  snprintf(model, sizeof model, "%s/model.h5", folder);
  RUN_TEST(TestRead);
  RUN_TEST(TestReadBare);
  RUN_TEST(TestReplacements);
  RUN_TEST(TestSpoilings);
  RUN_TEST(TestNoMesh);
  RUN_TEST(TestCutOff);
  ENSURE(H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL) ==
         0); /* nothing is left open, whatever went wrong */
  if (rank == 0) {
    unlink(model);
    rmdir(folder);
  }
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

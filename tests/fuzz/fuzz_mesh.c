/* fuzz_mesh.c: the bytes say what stands in model.h5, which the HDF5 library then writes: a whole file with
   any content. One byte before each dataset says whether it is as it should be, or missing, a link, of
   another type or shape. Coordinates are steps of 1/8 m, so that whole meshes are within reach. */
#include "fuzz.h"

typedef struct {
  const uint8_t *data;
  size_t size;
} Bytes;

static int take(Bytes *b)
{
  if (!b->size) return 0;
  b->size--;
  return *b->data++;
}

typedef enum {
  GOOD,
  MISSING,
  SOFT_LINK,
  LOOP,
  EXTERNAL_LINK,
  GROUP,
  WRONG_TYPE,
  WRONG_RANK,
  HUGE,
  EMPTY,
  FAULTS
} Fault;

/* Three bytes of four are good. */
static Fault take_fault(Bytes *b)
{
  const int byte = take(b);
  return byte < 192 ? GOOD : (Fault)(byte % FAULTS);
}

static void put(hid_t file, const char *path, hid_t type, int rank, hsize_t rows, hsize_t columns,
                const void *data, Fault fault)
{
  hsize_t size[3] = {rows, columns, 1};
  const hid_t create = H5Pcreate(H5P_DATASET_CREATE);
  hid_t stored = type, space, dataset;
  if (fault == SOFT_LINK) H5Lcreate_soft("/vertices", file, path, H5P_DEFAULT, H5P_DEFAULT);
  if (fault == LOOP) H5Lcreate_soft(path, file, path, H5P_DEFAULT, H5P_DEFAULT);
  if (fault == EXTERNAL_LINK) H5Lcreate_external("/dev/zero", "/x", file, path, H5P_DEFAULT, H5P_DEFAULT);
  if (fault == GROUP) H5Gclose(H5Gcreate2(file, path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (fault == WRONG_TYPE) stored = type == H5T_NATIVE_DOUBLE ? H5T_STD_I16BE : H5T_NATIVE_FLOAT;
  if (fault == WRONG_RANK) rank = rank % 3 + 1;
  if (fault == HUGE) {
    const hsize_t chunk[3] = {1, columns, 1};
    size[0] = (hsize_t)1 << 40;
    H5Pset_chunk(create, rank, chunk);
  }
  if (fault == GOOD || fault >= WRONG_TYPE) {
    space = fault == EMPTY ? H5Screate(H5S_NULL) : H5Screate_simple(rank, size, NULL);
    dataset = H5Dcreate2(file, path, stored, space, H5P_DEFAULT, create, H5P_DEFAULT);
    if (dataset >= 0 && fault == GOOD) H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    if (dataset >= 0) H5Dclose(dataset);
    H5Sclose(space);
  }
  H5Pclose(create);
}

static void put_header(hid_t file, Bytes *b)
{
  const int byte = take(b), version = byte < 192 ? 1 : byte;
  const hid_t space = H5Screate(H5S_SCALAR), text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, 16);
  char format[16] = "quoin-mesh";
  if (byte == 255) format[3] = '\n';
  const hid_t a = H5Acreate2(file, "format", text, space, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t v = H5Acreate2(file, "version", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(a, text, format);
  H5Awrite(v, H5T_NATIVE_INT, &version);
  H5Aclose(a), H5Aclose(v), H5Sclose(space), H5Tclose(text);
}

static void put_blocks(hid_t file, Bytes *b)
{
  double X[2 * 64];
  int blocks[4 * 64], group[64];
  const int nv = take(b) % 64, nb = take(b) % 64;
  Fault fault = take_fault(b);
  for (int i = 0; i < 2 * nv; i++) {
    X[i] = (take(b) - 128) / 8.;
    if (X[i] == 127 / 8.) X[i] = i % 2 ? NAN : 1e300;
  }
  put(file, "/vertices", H5T_NATIVE_DOUBLE, 2, (hsize_t)nv, 2, X, fault);
  fault = take_fault(b);
  for (int i = 0; i < 4 * nb; i++) {
    const int byte = take(b);
    blocks[i] = byte == 255 ? -1 : byte == 254 ? INT32_MAX : byte;
  }
  put(file, "/blocks", H5T_NATIVE_INT, 2, (hsize_t)nb, 4, blocks, fault);
  fault = take_fault(b);
  for (int i = 0; i < nb; i++) group[i] = (int8_t)take(b);
  put(file, "/block_group", H5T_NATIVE_INT, 1, (hsize_t)nb, 0, group, fault);
}

static void put_names(hid_t file, Bytes *b)
{
  const hid_t text = H5Tcopy(H5T_C_S1);
  char names[4][64] = {"a", "b", "c", "d"};
  int rigid[4];
  const int n = take(b) % 4 + 1, change = take(b);
  H5Tset_size(text, 64);
  if (change >= 128) names[change % 4][change / 4 % 8] = (char)take(b);
  for (int g = 0; g < n; g++) rigid[g] = (int8_t)take(b);
  H5Gclose(H5Gcreate2(file, "/groups", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  put(file, "/groups/name", text, 1, (hsize_t)n, 0, names, take_fault(b));
  put(file, "/groups/rigid", H5T_NATIVE_INT, 1, (hsize_t)n, 0, rigid, take_fault(b));
  H5Tclose(text);
}

static void put_sets(hid_t file, Bytes *b)
{
  char path[96];
  int values[2 * 16];
  H5Gclose(H5Gcreate2(file, "/face_sets", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  for (int s = take(b) % 4; s > 0; s--) {
    const int n = take(b) % 16;
    snprintf(path, sizeof path, "/face_sets/s%d%c", s, b->size && *b->data >= 250 ? *b->data : 'x');
    const Fault fault = take_fault(b);
    for (int i = 0; i < 2 * n; i++) values[i] = (int8_t)take(b);
    put(file, path, H5T_NATIVE_INT, 2, (hsize_t)n, 2, values, fault);
  }
  H5Gclose(H5Gcreate2(file, "/points", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  for (int p = take(b) % 3; p > 0; p--) {
    snprintf(path, sizeof path, "/points/p%d", p);
    values[0] = (int8_t)take(b);
    put(file, path, H5T_NATIVE_INT, 1, 1, 0, values, take_fault(b));
  }
}

/* The file as bytes in memory; free them. */
static void *image(Bytes *b, size_t *size)
{
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, 1 << 12, 0);
  const hid_t file = H5Fcreate("in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access);
  put_header(file, b);
  put_blocks(file, b);
  put_names(file, b);
  put_sets(file, b);
  H5Fflush(file, H5F_SCOPE_LOCAL);
  const ssize_t length = H5Fget_file_image(file, NULL, 0);
  void *buffer = malloc((size_t)length);
  if (!buffer || H5Fget_file_image(file, buffer, (size_t)length) != length) abort();
  H5Fclose(file);
  H5Pclose(access);
  *size = (size_t)length;
  return buffer;
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("model.h5");
  FuzzHdf5();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  Bytes bytes = {data, size};
  size_t length;
  void *buffer = image(&bytes, &length);
  FuzzFile(NULL, 0, buffer, length);
  free(buffer);
#ifdef QUOIN_FUZZ_SETUP
  BlockMesh mesh; // most have none that can be read, and the scene, always the same, would be read in vain
  const PetscErrorCode code = MeshRead(PETSC_COMM_SELF, FuzzPath, &mesh);
  FuzzCheck(code);
  if (!code && MeshDestroy(&mesh)) abort();
  if (!code) FuzzSetUp(QUOIN_SOURCE "/tests/fuzz/mesh_setup.yaml", FuzzPath);
#else
  FuzzMesh();
#endif
  FuzzClosed();
  return 0;
}

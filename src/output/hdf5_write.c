/* hdf5_write.c: writes datasets and attributes of an HDF5 file, each in one call; see hdf5_write.h. */
#include "output/output.h"
#include "output/hdf5_write.h"
#include <stdlib.h>
#include <string.h>

#define MEMORY_INT (sizeof(PetscInt) == 8 ? H5T_NATIVE_INT64 : H5T_NATIVE_INT32)

static int write_data(hid_t group, const char *name, hid_t file_type, hid_t memory_type, int rank,
                      const hsize_t *dims, const void *data)
{
  const hid_t space = H5Screate_simple(rank, dims, NULL);
  const hid_t set = H5Dcreate2(group, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int error = set < 0;
  hsize_t size = 1;
  for (int i = 0; i < rank; i++) size *= dims[i];
  if (!error && size) error = H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0;
  if (set >= 0) error |= H5Dclose(set) < 0;
  H5Sclose(space);
  return -error;
}

int Hdf5WriteReals(hid_t group, const char *name, int rank, const hsize_t *dims, const PetscReal *data)
{
  return write_data(group, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, rank, dims, data);
}

int Hdf5WriteInts(hid_t group, const char *name, hsize_t rows, hsize_t columns, const PetscInt *data)
{
  const hsize_t dims[2] = {rows, columns};
  return write_data(group, name, H5T_STD_I32LE, MEMORY_INT, columns ? 2 : 1, dims, data);
}

int Hdf5WriteNames(hid_t group, const char *name, PetscInt n, char (*names)[NAME_LENGTH])
{
  const hsize_t dims[1] = {(hsize_t)n};
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, NAME_LENGTH);
  const int error = write_data(group, name, type, type, 1, dims, names);
  H5Tclose(type);
  return error;
}

int Hdf5WriteAttribute(hid_t where, const char *name, hid_t type, hid_t memory_type, const void *value)
{
  const hid_t space = H5Screate(H5S_SCALAR);
  const hid_t attribute = H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  int error = attribute < 0 || H5Awrite(attribute, memory_type, value) < 0;
  if (attribute >= 0) error |= H5Aclose(attribute) < 0;
  H5Sclose(space);
  return -error;
}

int Hdf5WriteText(hid_t where, const char *name, const char *text)
{
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, strlen(text) + 1);
  const int error = Hdf5WriteAttribute(where, name, type, type, text);
  H5Tclose(type);
  return error;
}

int Hdf5WriteNumber(hid_t where, const char *name, double value)
{
  return Hdf5WriteAttribute(where, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

int Hdf5WriteCount(hid_t where, const char *name, long long value)
{
  return Hdf5WriteAttribute(where, name, H5T_STD_I64LE, H5T_NATIVE_LLONG, &value);
}

int Hdf5WriteMember(hid_t group, const char *name, int rank, const hsize_t *dims, const void *first,
                    size_t row, size_t part)
{
  const hsize_t parts = rank > 1 ? dims[1] : 1, width = rank > 2 ? dims[2] : 1;
  PetscReal *copy = malloc(((size_t)(dims[0] * parts * width) + 1) * sizeof(*copy)), *to = copy;
  if (!copy) return -1;
  for (hsize_t i = 0; i < dims[0]; i++)
    for (hsize_t k = 0; k < parts; k++, to += width)
      memcpy(to, (const char *)first + i * row + k * part, width * sizeof(*to));
  const int error = Hdf5WriteReals(group, name, rank, dims, copy);
  free(copy);
  return error;
}

/* results_tables.c: tables of force terms and shapes of modes in results.h5: a group each below the stage.
   Rank 0 only. */
#include "output/hdf5_write.h"

static int write_table(hid_t stage, const TermTable *table)
{
  const hid_t group = H5Gcreate2(stage, table->name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int error = group < 0;
  for (PetscInt c = 0; c < table->n_columns && !error; c++) {
    const TermColumn *column = table->columns + c;
    const hsize_t dims[2] = {table->n_rows, column->width};
    error = Hdf5WriteReals(group, column->name, column->width > 1 ? 2 : 1, dims, column->values);
  }
  if (group >= 0) H5Gclose(group);
  return -error;
}

static int write_shape(hid_t group, PetscInt n_vertices, const StageFields *fields, PetscInt mode)
{
  const hsize_t dims[2] = {n_vertices, 2};
  char name[32];
  PetscReal *shape = malloc((2 * (size_t)n_vertices + 1) * sizeof(*shape));
  if (!shape) return -1;
  for (PetscInt i = 0; i < 2 * n_vertices; i++)
    shape[i] = fields->modes[2 * (i / 2 * fields->n_modes + mode) + i % 2];
  snprintf(name, sizeof(name), "mode_%d", (int)mode + 1);
  const int error = Hdf5WriteReals(group, name, 2, dims, shape);
  free(shape);
  return error;
}

static int write_shapes(hid_t stage, PetscInt n_vertices, const StageFields *fields)
{
  const hid_t group = H5Gcreate2(stage, "modes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int error = group < 0;
  for (PetscInt mode = 0; mode < fields->n_modes && !error; mode++)
    error = write_shape(group, n_vertices, fields, mode);
  if (group >= 0) H5Gclose(group);
  return -error;
}

int ResultsTablesWrite(hid_t stage, PetscInt n_vertices, const StageFields *fields)
{
  int error = fields->modes ? write_shapes(stage, n_vertices, fields) : 0;
  for (PetscInt t = 0; t < fields->n_tables && !error; t++) error = write_table(stage, fields->tables + t);
  return error;
}

/* results_tables.c: tables of force terms in results.h5: a group each below the stage. Rank 0 only. */
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

int ResultsTablesWrite(hid_t stage, const StageFields *fields)
{
  int error = 0;
  for (PetscInt t = 0; t < fields->n_tables && !error; t++) error = write_table(stage, fields->tables + t);
  return error;
}

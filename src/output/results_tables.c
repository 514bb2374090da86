/* results_tables.c: writes tables of force terms, shapes of modes and envelopes into results.h5, each as a
   group below the stage. Rank 0 only. */
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

/* Writes a column of the first `rows` rows of a table. */
static int write_column(hid_t group, const char *name, int rank, const hsize_t *dims, const PetscReal *table,
                        int width, int column)
{
  const hsize_t n = rank > 1 ? dims[0] * dims[1] : dims[0];
  PetscReal *copy = malloc((n + 1) * sizeof *copy);
  if (!copy) return -1;
  for (hsize_t i = 0; i < n; i++) copy[i] = table[(hsize_t)width * i + (hsize_t)column];
  const int error = Hdf5WriteReals(group, name, rank, dims, copy);
  free(copy);
  return error;
}

static int write_modes(hid_t group, PetscInt n, const PetscReal *block)
{
  PetscInt *mode = malloc(((size_t)n + 1) * sizeof *mode);
  if (!mode) return -1;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal kept = block[ENVELOPE_BLOCK * i + ENVELOPE_MODE];
    mode[i] = PetscIsNanReal(kept) ? SAFETY_NONE : (PetscInt)kept;
  }
  const int error = Hdf5WriteInts(group, "safety_mode_min", (hsize_t)n, 0, mode);
  free(mode);
  return error;
}

static int write_block_envelopes(hid_t group, PetscInt n, const StageFields *fields)
{
  static const char *const names[] = {"s1_max",      "s1_max_time",       "s2_min",
                                      "s2_min_time", "safety_factor_min", "safety_factor_min_time"};
  const hsize_t rows = (hsize_t)n;
  const int columns = fields->safety ? 6 : 4;
  int error = 0;
  for (int k = 0; k < columns && !error; k++)
    error = write_column(group, names[k], 1, &rows, fields->envelope_block, ENVELOPE_BLOCK, k);
  return error || (fields->safety && write_modes(group, n, fields->envelope_block));
}

static int write_contact_envelopes(hid_t group, const StageFields *fields)
{
  static const char *const names[ENVELOPE_END] = {"sigma_max", "sigma_min", "opening_max", "slip_max"};
  const hsize_t dims[2] = {(hsize_t)fields->n_contacts, 2};
  const hid_t contacts = H5Gcreate2(group, "contacts", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int error = contacts < 0;
  for (int k = 0; k < ENVELOPE_END && !error; k++)
    error = write_column(contacts, names[k], 2, dims, fields->envelope_contact, ENVELOPE_END, k);
  if (contacts >= 0) H5Gclose(contacts);
  return error;
}

int ResultsEnvelopeWrite(hid_t stage, PetscInt n_blocks, const StageFields *fields)
{
  if (!fields->envelope_block) return 0;
  const hid_t group = H5Gcreate2(stage, "envelope", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const int error = group < 0 || Hdf5WriteCount(group, "every", fields->envelope_every) ||
                    Hdf5WriteCount(group, "samples", fields->envelope_samples) ||
                    write_block_envelopes(group, n_blocks, fields) || write_contact_envelopes(group, fields);
  if (group >= 0) H5Gclose(group);
  return -error;
}

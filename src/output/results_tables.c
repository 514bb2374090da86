/* results_tables.c: writes tables of force terms, shapes of modes and envelopes into results.h5, each as a
   group below the stage. Rank 0 only. */
#include "output/hdf5_write.h"

/* Writes the names of the loads: rows of the scene change where a restart adds loads. */
static int write_load_names(hid_t group, const Scene *scene)
{
  char(*names)[NAME_LENGTH] = calloc((size_t)scene->n_loads, sizeof *names);
  if (!names) return -1;
  for (PetscInt i = 0; i < scene->n_loads; i++) strcpy(names[i], scene->loads[i].name);
  const int error = Hdf5WriteNames(group, "names", scene->n_loads, names);
  free(names);
  return error;
}

static int write_table(hid_t stage, const Scene *scene, const TermTable *table)
{
  const hid_t group = H5Gcreate2(stage, table->name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int error = group < 0;
  for (PetscInt c = 0; c < table->n_columns && !error; c++) {
    const TermColumn *column = table->columns + c;
    const hsize_t dims[2] = {table->n_rows, column->width};
    error = Hdf5WriteReals(group, column->name, column->width > 1 ? 2 : 1, dims, column->values);
  }
  if (!error && !strcmp(table->name, "loads")) error = write_load_names(group, scene);
  if (group >= 0) H5Gclose(group);
  return -error;
}

static int write_shape(hid_t group, PetscInt n_vertices, const StageFields *fields, PetscInt mode)
{
  const hsize_t dims[2] = {n_vertices, 2};
  char name[32];
  snprintf(name, sizeof(name), "mode_%d", (int)mode + 1);
  return Hdf5WriteMember(group, name, 2, dims, fields->modes + 2 * mode,
                         2 * (size_t)fields->n_modes * sizeof(PetscReal), sizeof(PetscReal));
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

int ResultsTablesWrite(hid_t stage, const Scene *scene, PetscInt n_vertices, const StageFields *fields)
{
  int error = fields->modes ? write_shapes(stage, n_vertices, fields) : 0;
  for (PetscInt t = 0; t < fields->n_tables && !error; t++)
    error = write_table(stage, scene, fields->tables + t);
  return error;
}

static int write_modes(hid_t group, PetscInt n, const EnvelopeBlock *block)
{
  PetscInt *mode = malloc(((size_t)n + 1) * sizeof *mode);
  if (!mode) return -1;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal kept = block[i].mode;
    mode[i] = PetscIsNanReal(kept) ? SAFETY_NONE : (PetscInt)kept;
  }
  const int error = Hdf5WriteInts(group, "safety_mode_min", (hsize_t)n, 0, mode);
  free(mode);
  return error;
}

static int write_block_envelopes(hid_t group, PetscInt n, const StageFields *fields)
{
  const EnvelopeBlock *e = fields->envelope_block;
  const struct {
    const char *name;
    const PetscReal *first;
  } members[] = {{"s1_max", &e->s1},
                 {"s1_max_time", &e->s1_time},
                 {"s2_min", &e->s2},
                 {"s2_min_time", &e->s2_time},
                 {"safety_factor_min", &e->factor},
                 {"safety_factor_min_time", &e->factor_time}};
  const hsize_t rows = (hsize_t)n;
  int error = 0;
  for (int k = 0; k < (fields->safety ? 6 : 4) && !error; k++)
    error = Hdf5WriteMember(group, members[k].name, 1, &rows, members[k].first, sizeof(*e), 0);
  return error || (fields->safety && write_modes(group, n, e));
}

static int write_contact_envelopes(hid_t group, const StageFields *fields)
{
  const EnvelopeEnd *e = fields->envelope_contact[0];
  const hsize_t dims[2] = {(hsize_t)fields->n_contacts, 2};
  const hid_t contacts = H5Gcreate2(group, "contacts", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const int error =
      contacts < 0 ||
      Hdf5WriteMember(contacts, "sigma_max", 2, dims, &e->sigma_max, 2 * sizeof(*e), sizeof(*e)) ||
      Hdf5WriteMember(contacts, "sigma_min", 2, dims, &e->sigma_min, 2 * sizeof(*e), sizeof(*e)) ||
      Hdf5WriteMember(contacts, "opening_max", 2, dims, &e->opening, 2 * sizeof(*e), sizeof(*e)) ||
      Hdf5WriteMember(contacts, "slip_max", 2, dims, &e->slip, 2 * sizeof(*e), sizeof(*e));
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

/* xdmf.c: writes results.xdmf, which refers to results.h5. Rank 0 only. */
#include "output/output.h"

/* Returns the number of entries of the XDMF topology: each block has a cell type before its vertices. */
PetscInt XdmfTopologySize(const MeshFields *mesh)
{
  PetscInt size = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) size += mesh->blocks[4 * b + 3] < 0 ? 4 : 5;
  return size;
}

static void put_item(FILE *f, const char *dims, const char *type, int precision, const char *path)
{
  fprintf(f,
          "<DataItem Dimensions=\"%s\" NumberType=\"%s\" Precision=\"%d\" "
          "Format=\"HDF\">results.h5:%s</DataItem>",
          dims, type, precision, path);
}

static void put_attribute(FILE *f, const char *name, const char *kind, const char *centre, const char *dims,
                          const char *stage, const char *path)
{
  char full[256];
  const int is_int = !strcmp(name, "state") || !strcmp(name, "joint") || !strcmp(name, "safety_mode");
  snprintf(full, sizeof(full), "/stages/%s/%s", stage, path);
  fprintf(f, "      <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"%s\">", name, kind, centre);
  put_item(f, dims, is_int ? "Int" : "Float", is_int ? 4 : 8, full);
  fprintf(f, "</Attribute>\n");
}

/* Writes a column of stress (nb, 3) in results.h5. */
static void put_stress_column(FILE *f, PetscInt n_blocks, int column, const char *stage)
{
  char dims[64], path[256];
  snprintf(dims, sizeof(dims), "%d 3", (int)n_blocks);
  snprintf(path, sizeof(path), "/stages/%s/stress", stage);
  fprintf(f,
          "<DataItem ItemType=\"HyperSlab\" Dimensions=\"%d\"><DataItem Dimensions=\"3 2\" "
          "Format=\"XML\">0 %d 1 1 %d 1</DataItem>",
          (int)n_blocks, column, (int)n_blocks);
  put_item(f, dims, "Float", 8, path);
  fprintf(f, "</DataItem>");
}

/* Writes the stress in the plane as a tensor, xx xy xz yy yz zz, for glyphs and directions; components out of
   the plane are 0 (NaN in a rigid block, as the rest). */
static void put_stress_tensor(FILE *f, PetscInt n_blocks, const char *stage)
{
  fprintf(
      f,
      "      <Attribute Name=\"stress\" AttributeType=\"Tensor6\" Center=\"Cell\"><DataItem "
      "ItemType=\"Function\" Dimensions=\"%d 6\" Function=\"JOIN( $0 , $2 , (0 * $0) , $1 , (0 * $0) , (0 "
      "* $0) )\">",
      (int)n_blocks);
  for (int column = 0; column < 3; column++) put_stress_column(f, n_blocks, column, stage);
  fprintf(f, "</DataItem></Attribute>\n");
}

static void put_blocks(FILE *f, const MeshFields *mesh, const StageFields *fields, const char *stage)
{
  char nb[64], nv2[64], nb3[64], size[64];
  snprintf(nb, sizeof(nb), "%d", (int)mesh->n_blocks);
  snprintf(nb3, sizeof(nb3), "%d 3", (int)mesh->n_blocks);
  snprintf(nv2, sizeof(nv2), "%d 2", (int)mesh->n_vertices);
  snprintf(size, sizeof(size), "%d", (int)XdmfTopologySize(mesh));
  fprintf(f, "     <Grid Name=\"blocks\">\n      <Topology TopologyType=\"Mixed\" NumberOfElements=\"%s\">",
          nb);
  put_item(f, size, "Int", 4, "/mesh/xdmf_topology");
  fprintf(f, "</Topology>\n      <Geometry GeometryType=\"XY\">");
  put_item(f, nv2, "Float", 8, "/mesh/vertices");
  fprintf(f, "</Geometry>\n");
  put_attribute(f, "displacement", "Vector", "Node", nv2, stage, "displacement");
  put_attribute(f, "stress_xx_yy_xy", "Vector", "Cell", nb3, stage, "stress");
  put_stress_tensor(f, mesh->n_blocks, stage);
  put_attribute(f, "s1", "Scalar", "Cell", nb, stage, "s1");
  put_attribute(f, "s2", "Scalar", "Cell", nb, stage, "s2");
  put_attribute(f, "rotation", "Scalar", "Cell", nb, stage, "rotation");
  for (int k = 0; k <= LAW_MEASURES; k++) {
    const char *name = k == LAW_MEASURES ? "crack_width" : LawMeasure((MaterialLaw)(k + 1));
    const PetscReal *first = k == LAW_MEASURES ? &fields->block->crack_width : fields->block->measure + k;
    if (BlocksHave(mesh->n_blocks, first)) put_attribute(f, name, "Scalar", "Cell", nb, stage, name);
  }
  if (fields->mechanism) put_attribute(f, "mechanism", "Vector", "Node", nv2, stage, "mechanism");
  for (PetscInt mode = 1; mode <= (fields->modes ? fields->n_modes : 0); mode++) {
    char name[32], path[64];
    snprintf(name, sizeof(name), "mode_%d", (int)mode);
    snprintf(path, sizeof(path), "modes/%s", name);
    put_attribute(f, name, "Vector", "Node", nv2, stage, path);
  }
  if (fields->safety) {
    put_attribute(f, "safety_factor", "Scalar", "Cell", nb, stage, "safety_factor");
    put_attribute(f, "safety_mode", "Scalar", "Cell", nb, stage, "safety_mode");
  }
  if (fields->envelope_block) {
    put_attribute(f, "s1_max", "Scalar", "Cell", nb, stage, "envelope/s1_max");
    put_attribute(f, "s2_min", "Scalar", "Cell", nb, stage, "envelope/s2_min");
    if (fields->safety)
      put_attribute(f, "safety_factor_min", "Scalar", "Cell", nb, stage, "envelope/safety_factor_min");
  }
  fprintf(f, "      <Attribute Name=\"group\" AttributeType=\"Scalar\" Center=\"Cell\">");
  put_item(f, nb, "Int", 4, "/mesh/block_group");
  fprintf(f, "</Attribute>\n      <Attribute Name=\"macroblock\" AttributeType=\"Scalar\" Center=\"Cell\">");
  put_item(f, nb, "Int", 4, "/mesh/macroblock");
  fprintf(f, "</Attribute>\n      <Attribute Name=\"rank\" AttributeType=\"Scalar\" Center=\"Cell\">");
  put_item(f, nb, "Int", 4, "/mesh/rank");
  fprintf(f, "</Attribute>\n     </Grid>\n");
}

/* Writes lines between the two ends of each contact, with the values at the ends. */
static void put_contacts(FILE *f, const StageFields *fields, const char *stage)
{
  static const char *const envelopes[] = {"sigma_max", "sigma_min", "opening_max", "slip_max"};
  const PetscInt n = fields->n_contacts;
  static const char *const scalars[] = {"sigma", "tau", "opening", "sliding", "slip", "broken", "state"};
  char n_cells[64], n_ends[64], plane[64], path[256];
  if (!n) return;
  snprintf(n_cells, sizeof(n_cells), "%d", (int)n);
  snprintf(n_ends, sizeof(n_ends), "%d", (int)(2 * n));
  snprintf(plane, sizeof(plane), "%d 2", (int)(2 * n));
  fprintf(f,
          "     <Grid Name=\"contacts\">\n      <Topology TopologyType=\"Polyline\" NodesPerElement=\"2\" "
          "NumberOfElements=\"%s\"/>\n      <Geometry GeometryType=\"XY\">",
          n_cells);
  snprintf(path, sizeof(path), "/stages/%s/contacts/point", stage);
  put_item(f, plane, "Float", 8, path);
  fprintf(f, "</Geometry>\n");
  put_attribute(f, "displacement", "Vector", "Node", plane, stage, "contacts/displacement");
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(scalars); i++) {
    snprintf(path, sizeof(path), "contacts/%s", scalars[i]);
    put_attribute(f, scalars[i], "Scalar", "Node", n_ends, stage, path);
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(envelopes) && fields->envelope_contact; i++) {
    snprintf(path, sizeof(path), "envelope/contacts/%s", envelopes[i]);
    put_attribute(f, envelopes[i], "Scalar", "Node", n_ends, stage, path);
  }
  put_attribute(f, "joint", "Scalar", "Cell", n_cells, stage, "contacts/joint");
  fprintf(f, "     </Grid>\n");
}

/* Returns the row of results->grids with a stage or frame, or -1. */
static PetscInt row_of(const ResultsFile *results, PetscInt stage, PetscInt frame)
{
  for (PetscInt i = 0; i < results->n_grids; i++)
    if (results->grids[i].stage == stage && results->grids[i].frame == frame) return i;
  return -1;
}

PetscBool XdmfHas(const ResultsFile *results, PetscInt stage, PetscInt frame)
{
  return (PetscBool)(row_of(results, stage, frame) >= 0);
}

void XdmfDrop(ResultsFile *results, PetscInt stage, PetscInt frame)
{
  const PetscInt row = row_of(results, stage, frame);
  char *text = results->xdmf;
  if (row < 0) return;
  for (PetscInt i = 0; i < row; i++) text += results->grids[i].length;
  const char *end = text + results->grids[row].length;
  memmove(text, end, strlen(end) + 1);
  results->n_grids--;
  for (PetscInt i = row; i < results->n_grids; i++) results->grids[i] = results->grids[i + 1];
}

/* Appends the text of a stage or frame to results->xdmf and frees the text. */
static int append(ResultsFile *results, PetscInt stage, PetscInt frame, char *text, size_t size)
{
  const size_t before = results->xdmf ? strlen(results->xdmf) : 0;
  StageGrids *grids = realloc(results->grids, sizeof(*grids) * (size_t)(results->n_grids + 1));
  if (grids) results->grids = grids;
  char *longer = grids ? realloc(results->xdmf, before + size + 1) : NULL;
  if (longer) {
    memcpy(longer + before, text, size + 1);
    results->xdmf = longer;
    grids[results->n_grids++] = (StageGrids){stage, frame, (PetscInt64)size};
  }
  free(text);
  return longer ? 0 : -1;
}

/* Appends the grids of a stage to results->xdmf. The time counts the seconds of stages in time and of
   transient ones, and 1 for each other stage. */
int XdmfAddStage(ResultsFile *results, PetscInt stage, PetscInt frame, const char *name,
                 const StageFields *fields)
{
  char *text = NULL;
  size_t size = 0;
  PetscReal time = fields->time;
  for (PetscInt s = 0; s <= stage; s++) {
    const Stage *of = results->scene->stages + s;
    if (of->kind == STAGE_TRANSIENT)
      time += s < stage ? of->duration : 0.;
    else
      time += !StageInTime(of);
  }
  FILE *f = open_memstream(&text, &size);
  if (!f) return -1;
  fprintf(f,
          "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Spatial\">\n     <Time "
          "Value=\"%.10g\"/>\n",
          name, time);
  put_blocks(f, &results->written.mesh, fields, name);
  put_contacts(f, fields, name);
  fprintf(f, "    </Grid>\n");
  return fclose(f) || append(results, stage, frame, text, size) ? -1 : 0;
}

/* Writes the meaning of the numbers of a field as Information elements, which other readers ignore. */
static void put_meanings(FILE *f, const ResultsFile *results)
{
  const Scene *scene = results->scene;
  static const char *const states[] = {"elastic", "open", "slipping", NULL, "crushing"};
  for (PetscInt g = 0; g < results->model->materials.n_groups; g++)
    fprintf(f, "  <Information Name=\"group %d\" Value=\"%s\"/>\n", (int)g,
            results->model->materials.names[g]);
  for (PetscInt j = 0; j < scene->n_joints; j++)
    fprintf(f, "  <Information Name=\"joint %d\" Value=\"%s\"/>\n", (int)j, scene->joints[j].name);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(states); i++)
    if (states[i]) fprintf(f, "  <Information Name=\"state %d\" Value=\"%s\"/>\n", (int)i, states[i]);
}

void XdmfWrite(const ResultsFile *results, char message[MESSAGE_LENGTH])
{
  char *text = NULL;
  size_t size = 0;
  FILE *memory = open_memstream(&text, &size);
  if (memory) {
    fprintf(memory, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n <Domain>\n");
    put_meanings(memory, results);
    fprintf(memory,
            "  <Grid Name=\"stages\" GridType=\"Collection\" CollectionType=\"Temporal\">\n%s  </Grid>\n "
            "</Domain>\n</Xdmf>\n",
            results->xdmf);
  }
  const int error = !memory || fclose(memory);
  if (error && !message[0]) snprintf(message, MESSAGE_LENGTH, "output: no memory for results.xdmf");
  if (!error) PartText(results->folder, "results.xdmf", text, size, "<!-- crc32 ", " -->\n", message);
  free(text);
}

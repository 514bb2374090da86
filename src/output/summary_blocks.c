/* summary_blocks.c: writes the state of blocks into summary.json: largest stresses, temperatures, safety
   factors, and what has yielded or cracked. Rank 0 only, from the gathered fields. */
#include "output/output.h"
#include <math.h>

static const char *const ModeNames[] = {"none", "tension", "compression", "shear"};

static void block_centre(const MeshFields *mesh, PetscInt b, PetscReal centre[2])
{
  const PetscInt *v = mesh->blocks + 4 * b;
  const int n = v[3] < 0 ? 3 : 4;
  centre[0] = centre[1] = 0;
  for (int k = 0; k < n; k++) {
    for (int x = 0; x < 2; x++) centre[x] += mesh->X[2 * v[k] + x] / n;
  }
}

/* Writes the largest s1 (sign 1) or the smallest s2 (sign -1) at block centres of a group, or of all (-1); of
   equal values the first block's. */
static void put_extreme(FILE *f, const char *name, const MeshFields *mesh, const StageFields *s,
                        PetscInt group, int sign, const char *tail)
{
  PetscInt best = -1;
  PetscReal most = -INFINITY, centre[2];
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal value = sign > 0 ? s->block[b].s1 : -s->block[b].s2;
    if ((group < 0 || mesh->group[b] == group) && value > most) most = value, best = b;
  }
  if (best < 0) {
    fprintf(f, "\"%s\": null%s", name, tail);
    return;
  }
  block_centre(mesh, best, centre);
  fprintf(f, "\"%s\": {", name);
  JsonNumber(f, "value", sign * most, ", ");
  JsonCount(f, "block", best, ", ");
  JsonNumber(f, "x", centre[0], ", ");
  JsonNumber(f, "y", centre[1], "}");
  fputs(tail, f);
}

void SummaryStress(FILE *f, const Model *model, const MeshFields *mesh, const StageFields *s)
{
  fprintf(f, "      \"stress\": {");
  put_extreme(f, "s1_max", mesh, s, -1, 1, ", ");
  put_extreme(f, "s2_min", mesh, s, -1, -1, "},\n      \"stress_by_group\": {");
  for (PetscInt g = 0; g < model->n_groups; g++) {
    fprintf(f, "%s\n        ", g ? "," : "");
    JsonString(f, model->group_names[g]);
    fprintf(f, ": {");
    put_extreme(f, "s1_max", mesh, s, g, 1, ", ");
    put_extreme(f, "s2_min", mesh, s, g, -1, "}");
  }
  fprintf(f, "\n      },\n");
}

/* Writes how much colder and warmer the blocks are than in the state without stress, if a load has changed
   it. */
void SummaryTemperature(FILE *f, const MeshFields *mesh, const StageFields *s)
{
  PetscReal range[2] = {INFINITY, -INFINITY};
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal change = s->block[b].warmer;
    if (isnan(change)) continue; // rigid
    range[0] = PetscMin(range[0], change), range[1] = PetscMax(range[1], change);
  }
  fprintf(f, "      \"temperature\": {");
  JsonNumber(f, "min", range[0], ", ");
  JsonNumber(f, "max", range[1], "},\n");
}

/* Writes the least factor of a group with its place and mode, and the areas where each mode governs. */
static void put_safety(FILE *f, const MeshFields *mesh, const StageFields *s, PetscInt group)
{
  PetscReal area[4] = {0., 0., 0., 0.}, failing = 0., least = PETSC_INFINITY, centre[2], at[2] = {NAN, NAN};
  PetscInt best = -1;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    if (mesh->group[b] != group) continue;
    const PetscReal a = MeshBlockArea(mesh, b, centre);
    area[s->safety_mode[b]] += a;
    if (s->safety[b] < 1.) failing += a;
    if (s->safety[b] < least) least = s->safety[b], best = b, at[0] = centre[0], at[1] = centre[1];
  }
  JsonNumber(f, "value", least, ", ");
  JsonText(f, "mode", ModeNames[best < 0 ? SAFETY_NONE : s->safety_mode[best]], ", ");
  JsonCount(f, "block", best, ", ");
  JsonNumber(f, "x", at[0], ", ");
  JsonNumber(f, "y", at[1], ",\n          \"area\": {");
  for (int k = SAFETY_TENSION; k <= SAFETY_SHEAR; k++) JsonNumber(f, ModeNames[k], area[k], ", ");
  JsonNumber(f, "below_1", failing, "}}");
}

void SummarySafety(FILE *f, const Scene *scene, const MeshFields *mesh, const StageFields *s)
{
  const char *before = "      \"safety\": {\n";
  for (PetscInt g = 0; s->safety && g < scene->n_materials; g++) {
    if (!MaterialHasStrengths(scene->materials + g) || scene->materials[g].rigid) continue;
    fprintf(f, "%s        \"%s\": {", before, scene->materials[g].name);
    put_safety(f, mesh, s, g);
    before = ",\n";
  }
  if (before[0] == ',') fprintf(f, "\n      },\n");
}

/* Writes the state and place of the worst block of a group, the area that has yielded or cracked, the widest
   crack, and the energy lost. */
static void put_law(FILE *f, const Material *material, const MeshFields *mesh, const StageFields *s,
                    PetscInt group)
{
  PetscReal most = 0., area = 0., lost = 0., widest = 0., centre[2], at[2] = {NAN, NAN};
  PetscInt worst = -1, n = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const BlockRow *row = s->block + b;
    const PetscReal measure = row->measure[material->law - 1];
    if (mesh->group[b] != group || PetscIsNanReal(measure)) continue;
    lost += row->lost;
    if (!(measure > 0.)) continue;
    area += MeshBlockArea(mesh, b, centre);
    n++;
    if (row->crack_width > widest) widest = row->crack_width;
    if (measure > most) most = measure, worst = b, at[0] = centre[0], at[1] = centre[1];
  }
  fprintf(f, "        ");
  JsonString(f, material->name);
  fprintf(f, ": {");
  JsonNumber(f, LawMeasure(material->law), most, ", ");
  JsonCount(f, "block", worst, ", ");
  JsonNumber(f, "x", at[0], ", ");
  JsonNumber(f, "y", at[1], ", ");
  JsonCount(f, "blocks", n, ", ");
  JsonNumber(f, "area", area, ", ");
  if (material->law == MATERIAL_DAMAGE) JsonNumber(f, "crack_width", widest, ", ");
  JsonNumber(f, "lost", lost, "}");
}

void SummaryLaws(FILE *f, const Scene *scene, const MeshFields *mesh, const StageFields *s)
{
  const char *before = "      \"laws\": {\n";
  for (PetscInt g = 0; g < scene->n_materials; g++) {
    if (scene->materials[g].law == MATERIAL_ELASTIC) continue;
    fputs(before, f);
    put_law(f, scene->materials + g, mesh, s, g);
    before = ",\n";
  }
  if (before[0] == ',') fprintf(f, "\n      },\n");
}

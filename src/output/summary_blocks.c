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
static void put_extreme(Json *json, const char *name, const MeshFields *mesh, const StageFields *s,
                        PetscInt group, int sign)
{
  PetscInt best = -1;
  PetscReal most = -INFINITY, centre[2];
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal value = sign > 0 ? s->block[b].s1 : -s->block[b].s2;
    if ((group < 0 || mesh->group[b] == group) && value > most) most = value, best = b;
  }
  if (best < 0) {
    JsonValue(json, name, "null");
    return;
  }
  block_centre(mesh, best, centre);
  JsonObject(json, name, {"value", sign * most}, {"block", best}, {"x", centre[0]}, {"y", centre[1]});
}

void SummaryStress(Json *json, const Model *model, const MeshFields *mesh, const StageFields *s)
{
  JsonOpen(json, "stress");
  put_extreme(json, "s1_max", mesh, s, -1, 1);
  put_extreme(json, "s2_min", mesh, s, -1, -1);
  JsonClose(json);
  JsonOpen(json, "stress_by_group");
  for (PetscInt g = 0; g < model->materials.n_groups; g++) {
    JsonOpen(json, model->materials.names[g]);
    put_extreme(json, "s1_max", mesh, s, g, 1);
    put_extreme(json, "s2_min", mesh, s, g, -1);
    JsonClose(json);
  }
  JsonClose(json);
}

/* Writes how much colder and warmer the blocks are than in the state without stress, if a load has changed
   it. */
void SummaryTemperature(Json *json, const MeshFields *mesh, const StageFields *s)
{
  PetscReal range[2] = {INFINITY, -INFINITY};
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal change = s->block[b].warmer;
    if (isnan(change)) continue; // rigid
    range[0] = PetscMin(range[0], change), range[1] = PetscMax(range[1], change);
  }
  JsonObject(json, "temperature", {"min", range[0]}, {"max", range[1]});
}

/* Writes the least factor of a group with its place and mode, and the areas where each mode governs. */
static void put_safety(Json *json, const MeshFields *mesh, const StageFields *s, PetscInt group)
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
  JsonNumber(json, "value", least);
  JsonText(json, "mode", ModeNames[best < 0 ? SAFETY_NONE : s->safety_mode[best]]);
  JsonNumbers(json, {"block", best}, {"x", at[0]}, {"y", at[1]});
  JsonOpen(json, "area");
  for (int k = SAFETY_TENSION; k <= SAFETY_SHEAR; k++) JsonNumber(json, ModeNames[k], area[k]);
  JsonNumber(json, "below_1", failing);
  JsonClose(json);
  JsonClose(json);
}

void SummarySafety(Json *json, const Scene *scene, const MeshFields *mesh, const StageFields *s)
{
  JsonOpenLater(json, "safety");
  for (PetscInt g = 0; s->safety && g < scene->n_materials; g++) {
    if (!MaterialHasStrengths(scene->materials + g) || scene->materials[g].rigid) continue;
    JsonOpen(json, scene->materials[g].name);
    put_safety(json, mesh, s, g);
  }
  JsonClose(json);
}

/* Writes the state and place of the worst block of a group, the area that has yielded or cracked, the widest
   crack, and the energy lost. */
static void put_law(Json *json, const Material *material, const MeshFields *mesh, const StageFields *s,
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
  JsonOpen(json, material->name);
  JsonNumbers(json, {LawMeasure(material->law), most}, {"block", worst}, {"x", at[0]}, {"y", at[1]},
              {"blocks", n}, {"area", area});
  if (material->law == MATERIAL_DAMAGE) JsonNumber(json, "crack_width", widest);
  JsonNumber(json, "lost", lost);
  JsonClose(json);
}

void SummaryLaws(Json *json, const Scene *scene, const MeshFields *mesh, const StageFields *s)
{
  JsonOpenLater(json, "laws");
  for (PetscInt g = 0; g < scene->n_materials; g++) {
    if (scene->materials[g].law == MATERIAL_ELASTIC) continue;
    put_law(json, scene->materials + g, mesh, s, g);
  }
  JsonClose(json);
}

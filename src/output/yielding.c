/* yielding.c: writes the state of blocks that yield or crack, group by group. Rank 0 only, on the gathered
   fields. */
#include "output/output.h"

PetscBool BlockHas(PetscInt n, const PetscReal *block, int column)
{
  for (PetscInt b = 0; b < n; b++)
    if (!PetscIsNanReal(block[BLOCK_WIDTH * b + column])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Writes the state and place of the worst block of a group, the area that has yielded or cracked, the widest
   crack, and the energy lost. */
static void put_group(FILE *f, const Material *material, const MeshFields *mesh, const StageFields *s,
                      PetscInt group)
{
  const int measure = BLOCK_MEASURE + material->law - 1;
  PetscReal most = 0., area = 0., lost = 0., widest = 0., centre[2], at[2] = {NAN, NAN};
  PetscInt worst = -1, n = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscReal *row = s->block + BLOCK_WIDTH * b;
    if (mesh->group[b] != group || PetscIsNanReal(row[measure])) continue;
    lost += row[BLOCK_LOST];
    if (!(row[measure] > 0.)) continue;
    area += MeshBlockArea(mesh, b, centre);
    n++;
    if (row[BLOCK_OPENING] > widest) widest = row[BLOCK_OPENING];
    if (row[measure] > most) most = row[measure], worst = b, at[0] = centre[0], at[1] = centre[1];
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
    put_group(f, scene->materials + g, mesh, s, g);
    before = ",\n";
  }
  if (before[0] == ',') fprintf(f, "\n      },\n");
}

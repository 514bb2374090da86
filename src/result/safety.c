/* safety.c: computes local failure factors (39)-(41) at the centres of deformable blocks, from the principal
   stresses and the strengths of the block's material. Rank 0 only, on the gathered fields.

   The mean stress enters (41) with its sign, as c cos(phi) - s_m sin(phi). The paper prints |s_m|, which is
   the same under compression but would make tension a strength. */
#include "result/result.h"
#include <math.h>

SafetyMode SafetyFactor(const Material *material, PetscReal s1, PetscReal s2, PetscReal *factor)
{
  const PetscReal phi = material->friction * (PETSC_PI / 180.), mean = 0.5 * (s1 + s2),
                  radius = 0.5 * (s1 - s2);
  PetscReal strength = material->cohesion * cos(phi) - mean * sin(phi);
  if (strength < 0.) strength = 0.; // a NaN stays NaN
  const PetscReal by_mode[] = {NAN,
                               s1 > 0. ? material->tension / s1 : NAN,      // (39)
                               s2 < 0. ? material->compression / -s2 : NAN, // (40)
                               radius > 0. ? strength / radius : NAN};      // (41)
  SafetyMode mode = SAFETY_NONE;
  *factor = PETSC_INFINITY;
  for (int k = SAFETY_TENSION; k <= SAFETY_SHEAR; k++) // NaN: no such stress, or no such strength
    if (by_mode[k] < *factor) *factor = by_mode[k], mode = (SafetyMode)k;
  return mode;
}

PetscBool MaterialHasStrengths(const Material *m)
{
  return (PetscBool)(!isnan(m->tension) || !isnan(m->compression) || !isnan(m->cohesion));
}

PetscErrorCode SafetyFields(const Scene *scene, const MeshFields *mesh, StageFields *s)
{
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_materials; i++)
    any = (PetscBool)(any || MaterialHasStrengths(scene->materials + i));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(mesh->n_blocks + 1, &s->safety));
  PetscCall(PetscMalloc1(mesh->n_blocks + 1, &s->safety_mode));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const Material *material = scene->materials + mesh->group[b];
    const BlockRow *row = s->block + b;
    s->safety[b] = NAN, s->safety_mode[b] = SAFETY_NONE;
    if (MaterialHasStrengths(material) && !isnan(row->s1))
      s->safety_mode[b] = SafetyFactor(material, row->s1, row->s2, s->safety + b);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool BlocksHave(PetscInt n, const PetscReal *first)
{
  for (PetscInt b = 0; b < n; b++)
    if (!PetscIsNanReal(*(const PetscReal *)((const char *)first + (size_t)b * sizeof(BlockRow))))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscReal MeshBlockArea(const MeshFields *mesh, PetscInt b, PetscReal centre[2])
{
  const PetscInt *v = mesh->blocks + 4 * b, n = v[3] < 0 ? 3 : 4;
  PetscReal area = 0.;
  centre[0] = centre[1] = 0.;
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *p = mesh->X + 2 * v[k], *q = mesh->X + 2 * v[(k + 1) % n];
    area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
    for (int x = 0; x < 2; x++) centre[x] += p[x] / n;
  }
  return area;
}

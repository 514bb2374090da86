/* stage_keys.c: completes keys of stages: the stage from which a stage starts, its loads, and its damping in
   time. */
#include "stages/stages.h"
#include "scene/reader.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Finds the earlier stage from which a stage starts, and sets stage->skips. */
static PetscErrorCode complete_from(Reader *r, const char *path, Stage *stage)
{
  const Scene *scene = r->scene;
  const PetscInt number = (PetscInt)(stage - scene->stages);
  char known[512] = "none";
  PetscInt base = number - 1;
  size_t used = 0;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!stage->from[0]) PetscFunctionReturn(PETSC_SUCCESS);
  while (base >= 0 && strcmp(scene->stages[base].name, stage->from) != 0) base--;
  for (PetscInt s = 0; s < number && used < sizeof known; s++)
    used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", s ? ", " : "", scene->stages[s].name);
  PetscCall(IsGiven(r, path, "from", &given));
  if (base < 0)
    COMPLAIN_MISSING(r, "no stage named '%s' before it; stages before it: %s", stage->from, known);
  else
    stage->skips = number - 1 - base;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the loads of a stage against its kind. An empty list is right in three cases: the structure
   vibrates, follows its supports, or loses its earlier loads. */
static PetscErrorCode complete_loads(Reader *r, const char *path, const Stage *stage)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "loads", &given));
  for (PetscInt i = 0; i < stage->n_loads && stage->kind == STAGE_MODES; i++)
    if (stage->loads[i] >= 0 && r->scene->loads[stage->loads[i]].kind != LOAD_ADDED_MASS)
      COMPLAIN(
          r, "'%s' is not a mass: a stage of modes keeps the loads of the stage before; expected added_mass",
          r->scene->loads[stage->loads[i]].name);
  for (PetscInt i = 0; i < stage->n_loads && StageRelaxes(stage); i++)
    if (stage->loads[i] >= 0 && r->scene->loads[stage->loads[i]].history[0])
      COMPLAIN(r, "'%s' has a history, which is followed in dynamic stages only",
               r->scene->loads[stage->loads[i]].name);
  for (PetscInt i = 0; i < stage->n_loads && StageInTime(stage); i++) {
    const Load *load = stage->loads[i] < 0 ? NULL : r->scene->loads + stage->loads[i];
    if (load && load->kind == LOAD_PSEUDO_STATIC && load->target[0])
      COMPLAIN(
          r, "'%s' has the inertia of water as a static force: expected it without faces in a dynamic stage",
          load->name);
  }
  if (!given || stage->n_loads || !StageRelaxes(stage)) PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->kind == STAGE_STATIC && stage != r->scene->stages) PetscFunctionReturn(PETSC_SUCCESS);
  COMPLAIN(r, "no loads: only modes, a dynamic stage, or a static one behind another, need none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteStage(Reader *r, const char *path, Stage *stage)
{
  PetscFunctionBeginUser;
  PetscCall(complete_from(r, path, stage));
  PetscCall(complete_loads(r, path, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes alpha [1/s] and beta [s] from the damping ratio z at two circular frequencies w:
   alpha / (2 w) + beta w / 2 = z at both. */
PetscErrorCode CompleteDamping(Reader *r, const char *path, Stage *stage)
{
  const PetscReal *f = stage->damping_frequencies;
  const PetscBool ratio = (PetscBool)!isnan(stage->damping_ratio), frequencies = (PetscBool)!isnan(f[0]);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (int i = 0; i < 2 && ratio; i++) {
    PetscCall(IsGiven(r, path, i ? "beta" : "alpha", &given));
    if (given) COMPLAIN(r, "it follows from damping_ratio: give one of the two");
  }
  PetscCall(IsGiven(r, path, ratio ? "damping_frequencies" : "damping_ratio", &given));
  if (ratio != frequencies)
    COMPLAIN_MISSING(r, "missing: damping_ratio and damping_frequencies belong together");
  if (!ratio || !frequencies) PetscFunctionReturn(PETSC_SUCCESS);
  if (!(f[0] > 0. && f[1] > f[0] && f[1] < PETSC_INFINITY))
    COMPLAIN(r, "%g, %g: expected two frequencies [Hz] > 0, the lower one first", (double)f[0], (double)f[1]);
  const PetscReal w[2] = {2. * PETSC_PI * f[0], 2. * PETSC_PI * f[1]};
  stage->alpha = 2. * stage->damping_ratio * w[0] * w[1] / (w[0] + w[1]);
  stage->beta = 2. * stage->damping_ratio / (w[0] + w[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

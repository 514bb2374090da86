/* modal.c: computes frequencies and effective masses of small free vibrations. */
#include "result/result.h"

PetscErrorCode VibrationDestroy(Vibration *v)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(v->omega2, v->mass, v->factor, v->shape, v->error));
  PetscCall(PetscMemzero(v, sizeof(*v)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal VibrationHertz(const Vibration *v, PetscInt mode)
{
  return v->omega2[mode] < 0. ? NAN : PetscSqrtReal(v->omega2[mode]) / (2. * PETSC_PI);
}

PetscReal VibrationMass(const Vibration *v, PetscInt mode, int x)
{
  const PetscReal factor = v->factor[2 * mode + x];
  return factor * factor * v->mass[mode];
}

PetscReal VibrationPart(const Vibration *v, PetscInt mode, int x)
{
  PetscReal sum = 0.;
  for (PetscInt i = mode < 0 ? 0 : mode; i < (mode < 0 ? v->n : mode + 1); i++) sum += VibrationMass(v, i, x);
  return v->moving[x] > 0. ? sum / v->moving[x] : 0.;
}

/* joint_table.c: computes numbers that follow from a row of the joints table. */
#include "scene/scene.h"

const char *const StressModels[] = {"pt",      "r2pt", "r3pt", "t2pt", "t3pt", "tptm", "StressModelKind",
                                    "STRESS_", NULL};

void JointPrepare(Joint *joint)
{
  for (int i = 0; i < 2; i++) joint->tan_phi[i] = tan(joint->friction[i] * (PETSC_PI / 180));
}

PetscBool JointIsReduced(const Stage *stage, const Joint *joint)
{
  if (!joint->defined || joint->law == LAW_ELASTIC) return PETSC_FALSE;
  for (PetscInt i = 0; i < stage->n_reduce; i++)
    if (!strcmp(stage->reduce[i], joint->name)) return PETSC_TRUE;
  return (PetscBool)(stage->n_reduce == 0);
}

PetscReal ReducedFriction(const Scene *scene, const Stage *stage, const PetscInt *has)
{
  PetscReal most = NAN;
  for (PetscInt j = 0; j < scene->n_joints; j++)
    if (JointIsReduced(stage, stage->joints + j) && (!has || has[j]) &&
        !(most >= stage->joints[j].friction[0]))
      most = stage->joints[j].friction[0];
  return most;
}

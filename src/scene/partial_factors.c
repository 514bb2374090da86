/* partial_factors.c: applies partial factors of safety, of loads and of the strengths of joints in a stage,
   to a scene that is read.

   A factor on friction divides its tangent, so that the strength N tan(phi) + c L becomes
   N tan(phi) / F_phi + c L / F_c. */
#include "scene/scene.h"

void LoadScale(const Load *load, PetscReal factor, Load *scaled)
{
  for (int x = 0; x < 2; x++) scaled->coefficient[x] = factor * load->coefficient[x];
  for (int x = 0; x < 2; x++) scaled->traction[x] = factor * load->traction[x];
  scaled->heat.factor = factor * load->heat.factor;
  if (load->kind != LOAD_PSEUDO_STATIC) scaled->density = factor * load->density; // of water at rest
}

/* Divides the strengths of a joint by the partial factors of a stage. */
static void divide_strengths(const Stage *stage, Joint *joint)
{
  for (int i = 0; i < 2; i++) {
    const PetscReal tangent = tan(joint->friction[i] * (PETSC_PI / 180)) / stage->friction_factor;
    joint->friction[i] = atan(tangent) * (180 / PETSC_PI);
    joint->cohesion[i] /= stage->cohesion_factor;
    joint->tension[i] /= stage->cohesion_factor;
  }
  JointPrepare(joint);
}

void SceneApplyPartialFactors(Scene *scene)
{
  for (Load *load = scene->loads; load < scene->loads + scene->n_loads; load++)
    if (load->partial_factor != 1.) LoadScale(load, load->partial_factor, load);
  for (const Stage *stage = scene->stages; stage < scene->stages + scene->n_stages; stage++)
    for (PetscInt j = 0; j < scene->n_joints && StageHasDesignStrengths(stage); j++)
      if (stage->joints[j].defined && stage->joints[j].law != LAW_ELASTIC)
        divide_strengths(stage, stage->joints + j);
}

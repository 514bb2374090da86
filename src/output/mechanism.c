/* mechanism.c: writes how a model fails: the motion in which a trial or a static stage has collapsed, and the
   joints that open or slide in it. */
#include "output/output.h"

static const PetscReal TAKES_PART = 0.05; /* [-] of the fastest joint: slower joints only follow the others */

PetscBool MechanismHas(const Scene *scene, const Trials *trials, PetscInt joint, enum JointMotion motion)
{
  PetscReal most = 0.;
  if (!trials->joint_motion) return PETSC_FALSE;
  for (PetscInt j = 0; j < 2 * scene->n_joints; j++) most = PetscMax(most, trials->joint_motion[j]);
  return (PetscBool)(trials->joint_motion[2 * joint + (PetscInt)motion] > TAKES_PART * most);
}

void SummaryMechanism(FILE *f, const Scene *scene, const Trials *trials)
{
  const char *before = "";
  if (!trials->mechanism) return;
  fprintf(f, "      \"mechanism\": {");
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const PetscBool slides = MechanismHas(scene, trials, j, JOINT_SLIDES),
                    opens = MechanismHas(scene, trials, j, JOINT_OPENS);
    if (!slides && !opens) continue;
    fprintf(f, "%s\"%s\": {", before, scene->joints[j].name);
    JsonText(f, "moves", slides && opens ? "slides and opens" : slides ? "slides" : "opens", ", ");
    JsonNumber(f, "slides", trials->joint_motion[2 * j + JOINT_SLIDES], ", ");
    JsonNumber(f, "opens", trials->joint_motion[2 * j + JOINT_OPENS], "}");
    before = ", ";
  }
  fprintf(f, "},\n");
}

/* result_query.c: finds single numbers of a stage by their paths in its object in summary.json. The functions
   that write the object name each number to the writer, which writes nothing here and picks those numbers. */
#include "output/output.h"
#include <math.h>
#include <string.h>

PetscBool ResultQueryBeyondJoints(PetscInt n, char *const *paths)
{
  static const char joints[] = "joints.";
  for (PetscInt i = 0; i < n; i++)
    if (strncmp(paths[i], joints, sizeof(joints) - 1) != 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode ResultQuery(const Problem *p, PetscInt n, char *const *paths, PetscReal *values)
{
  const TermView view = ViewOf(p);
  StageFields fields = {0};
  Json json = {.n_asked = n, .asked = paths, .answers = values};
  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; i++) values[i] = NAN;
  if (ResultQueryBeyondJoints(n, paths)) {
    PetscCall(GatherStage(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
    PetscCall(TermsBeforeSummary(&view, PETSC_FALSE));
    PetscCall(SafetyFields(p->scene, &p->found->mesh, &fields));
    PetscCall(SummaryStage(&json, p, &fields, (const uint64_t[2]){0}));
  } else {
    PetscCall(GatherContacts(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
    SummaryJoints(&json, p, &fields);
  }
  PetscCall(GatherStageDestroy(&fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* result_query.c: finds single numbers of a stage by their paths in its object in summary.json. The object is
   written into memory and read, so a path means the same here and there. */
#include "output/output.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns the place after the JSON value that starts here. */
static const char *skip(const char *c)
{
  int depth = 0;
  PetscBool text = PETSC_FALSE;
  for (; *c; c++) {
    if (text) {
      if (*c == '\\' && c[1]) c++;
      text = (PetscBool)(text && *c != '"');
    } else if (*c == '"')
      text = PETSC_TRUE;
    else if (*c == '{' || *c == '[')
      depth++;
    else if ((*c == '}' || *c == ']' || *c == ',') && !depth)
      return c;
    else if (*c == '}' || *c == ']')
      depth--;
  }
  return c;
}

/* Returns the number at a path. c: the first member of an object. */
static PetscReal number_at(const char *c, const char *path)
{
  const size_t n = strcspn(path, ".");
  for (; c && *c; c = *c == ',' ? c + 1 : NULL) {
    c += strspn(c, " \n");
    if (*c != '"') return NAN;
    const char *name = c + 1;
    const size_t length = strcspn(name, "\"");
    c = name + length + 1;
    c += strspn(c, " \n:");
    if (length == n && !strncmp(name, path, n)) {
      if (path[n] && *c == '{') return number_at(c + 1, path + n + 1);
      return path[n] || strchr("\"{[ntf", *c) ? NAN : strtod(c, NULL);
    }
    c = skip(c);
  }
  return NAN;
}

/* Writes the members of the stage that the paths need, as text from malloc: joints alone, or all of them. */
static PetscErrorCode write_members(const Problem *p, PetscBool all, char **text)
{
  const TermView view = ViewOf(p);
  StageFields fields = {0};
  size_t size = 0;
  PetscFunctionBeginUser;
  if (all) {
    PetscCall(GatherStage(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
    PetscCall(TermsBeforeSummary(&view, PETSC_FALSE));
    PetscCall(SafetyFields(p->scene, &p->found->mesh, &fields));
    PetscCall(SummaryStage(p, &fields, (const uint64_t[2]){0}, text));
  } else {
    PetscCall(GatherContacts(p->m, p->state, p->contacts, p->stage, &p->found->mesh, &fields));
    FILE *f = open_memstream(text, &size);
    PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
    fputc('{', f);
    SummaryJoints(f, p, &fields);
    PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  }
  PetscCall(GatherStageDestroy(&fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool ResultQueryBeyondJoints(PetscInt n, char *const *paths)
{
  static const char joints[] = "joints.";
  for (PetscInt i = 0; i < n; i++)
    if (strncmp(paths[i], joints, sizeof(joints) - 1) != 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode ResultQuery(const Problem *p, PetscInt n, char *const *paths, PetscReal *values)
{
  char *text = NULL;
  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(write_members(p, ResultQueryBeyondJoints(n, paths), &text));
  const char *first = text ? strchr(text, '{') : NULL;
  for (PetscInt i = 0; i < n; i++) values[i] = first ? number_at(first + 1, paths[i]) : NAN;
  free(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

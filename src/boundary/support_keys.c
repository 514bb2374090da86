/* support_keys.c: checks the keys of motions and supports, and finds the motions that a support follows. */
#include "boundary/boundary.h"
#include "scene/reader.h"
#include <stdio.h>
#include <string.h>

PetscErrorCode CompleteMotion(Reader *r, const char *path, const GroundMotion *m)
{
  PetscBool scaled = PETSC_FALSE, given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "scale", &scaled));
  PetscCall(IsGiven(r, path, "pga", &given));
  if (given && scaled) COMPLAIN(r, "scale and pga exclude each other");
  if (given && m->quantity == MOTION_VELOCITY) COMPLAIN(r, "it is for a record of accelerations");
  PetscCall(IsGiven(r, path, "baseline", &given));
  if (m->baseline == BASELINE_LINEAR && m->quantity == MOTION_VELOCITY)
    COMPLAIN(r, "linear is for a record of accelerations");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a support follow a motion of the scene along the directions of the motion's record. */
static void follow(Reader *r, Support *s, const GroundMotion *m)
{
  for (int k = 0; k < 2; k++) {
    if (m->direction == (k ? MOTION_ALONG_X : MOTION_ALONG_Y)) continue;
    if (s->along[k])
      COMPLAIN(r, "%s and %s both move it along %c", s->along[k]->entry.name, m->entry.name, "xy"[k]);
    if (!s->fix[k] && m->direction != MOTION_ALONG_XY && s->boundary == BOUNDARY_FIXED)
      COMPLAIN(r, "%s moves along %c, in which supports.%s does not hold: expected fix: xy or %c",
               m->entry.name, "xy"[k], s -> name, "xy"[k]);
    s->along[k] = m;
  }
}

/* Finds the motion of a support: a list of motions of the scene, or otherwise the path of a file. */
PetscErrorCode CompleteSupport(Reader *r, const char *path, Support *s)
{
  const Scene *scene = r->scene;
  char item[LABEL_LENGTH], known[512] = "none";
  size_t used = 0;
  PetscInt named = 0, others = 0;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "quantity", &given));
  PetscBool with_quantity = given;
  PetscCall(IsGiven(r, path, "motion", &given));
  if (given && s->boundary == BOUNDARY_FREE_FIELD)
    COMPLAIN(r, "free ground beside a side has the motion of its base: expected it at the base alone");
  for (const char *rest = s->motion[0] ? s->motion : NULL; rest;) {
    PetscInt i = 0;
    rest = NextItem(rest, item);
    while (i < scene->n_motions && strcmp(scene->motions[i].entry.name, item) != 0) i++;
    if (i < scene->n_motions) follow(r, s, scene->motions + i);
    named += i < scene->n_motions, others += i == scene->n_motions;
  }
  for (PetscInt i = 0; i < scene->n_motions && used < sizeof known; i++)
    used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "",
                             scene->motions[i].entry.name);
  if (others && (named || others > 1)) COMPLAIN(r, "not all are motions of the scene, which are: %s", known);
  if (named && with_quantity) {
    PetscCall(IsGiven(r, path, "quantity", &given));
    COMPLAIN(r, "it is for a file: motions.%s.quantity says it",
             s->along[0] ? s->along[0]->entry.name : item);
  }
  PetscCall(IsGiven(r, path, "input", &given));
  if (s->input != INPUT_OUTCROP && s->boundary != BOUNDARY_QUIET)
    COMPLAIN(r, "it is for boundary: quiet, which lets waves in");
  PetscCall(IsGiven(r, path, "half_space", &given));
  if (given && s->boundary != BOUNDARY_QUIET)
    COMPLAIN(r, "it is for boundary: quiet, behind which ground goes on");
  if (!named && s->motion[0]) {
    PetscCall(PetscStrncpy(s->own.file, s->motion, sizeof(s->own.file)));
    PetscCall(PetscStrncpy(s->own.entry.name, s->name, NAME_LENGTH));
    s->own.scale = 1.;
    s->along[0] = s->along[1] = &s->own;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* varies.c: finds the keys that may change between runs that share mesh, contacts and condensed bodies:
   numbers of joints, loads, anchors and stages, and items of pairs of loads. */
#include "scene/scene.h"
#include "scene/keys.h"
#include <stdio.h>
#include <string.h>

/* Returns whether a key of this section is a number, or a list that may be one number, as prestress; or an
   item of a list, value[0]. Of pairs only those of loads count, since pairs of anchors are places in the
   mesh. */
static PetscBool is_number(Section section, const char *name)
{
  const size_t length = strcspn(name, "[");
  if (name[length]) {
    int place, end = 0;
    sscanf(name + length, "[%d]%n", &place, &end);
    if (!end || name[length + (size_t)end]) return PETSC_FALSE;
  }
  for (const Key *key = Keys; key < Keys + KEYS; key++)
    if (key->section == section && strlen(key->name) == length && !strncmp(key->name, name, length) &&
        (name[length] ? key->type == TYPE_NUMBERS || (key->type == TYPE_PAIR && section == SECTION_LOADS)
                      : key->type == TYPE_REAL || key->type == TYPE_LIMIT || key->type == TYPE_INT ||
                            key->type == TYPE_NUMBERS))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscInt stage_named(const Scene *scene, const char *name)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (!strcmp(scene->stages[s].name, name)) return s;
  return -1;
}

/* Returns the first stage that lists the load; n_stages: none does. Earthquake pressures at rest and flowing
   water use loads without listing them: these count from the start. */
static PetscInt first_with_load(const Scene *scene, const char *name)
{
  PetscBool checks = PETSC_FALSE;
  for (PetscInt l = 0; l < scene->n_loads; l++)
    checks = (PetscBool)(checks || scene->loads[l].kind >= LOAD_HEAD);
  for (PetscInt s = 0; s < scene->n_stages; s++)
    for (PetscInt i = 0; i < scene->stages[s].n_loads; i++)
      if (checks || !strcmp(scene->loads[scene->stages[s].loads[i]].name, name)) return checks ? 0 : s;
  return checks ? 0 : scene->n_stages;
}

PetscInt SceneVaries(const Scene *scene, const char *key)
{
  char path[LABEL_LENGTH], *part[5] = {path};
  int n = 1;
  snprintf(path, sizeof(path), "%s", key);
  for (char *dot = strchr(path, '.'); dot && n < 5; dot = strchr(dot + 1, '.'))
    *dot = '\0', part[n++] = dot + 1;
  if (n == 3 && !strcmp(part[0], "joints") && is_number(SECTION_JOINTS, part[2])) return 0;
  if (n == 3 && !strcmp(part[0], "anchors") && is_number(SECTION_ANCHORS, part[2])) return 0;
  if (n == 3 && !strcmp(part[0], "loads") && is_number(SECTION_LOADS, part[2]))
    return first_with_load(scene, part[1]);
  const PetscInt stage = n > 2 && !strcmp(part[0], "stages") ? stage_named(scene, part[1]) : -1;
  if (n == 3 && is_number(SECTION_STAGES, part[2])) return stage;
  if (n == 5 && !strcmp(part[2], "joints") && is_number(SECTION_JOINTS, part[4])) return stage;
  return -1;
}

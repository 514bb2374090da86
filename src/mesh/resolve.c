/* resolve.c: compares the names in a scene with those in the mesh. Every rank has all names, so every rank
   finds the same result. */
#include "mesh/mesh.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef char NameText[NAME_LENGTH];

static PetscInt find_name(const char *name, PetscInt n, const NameText *names)
{
  for (PetscInt i = 0; i < n; i++)
    if (!strcmp(names[i], name)) return i;
  return -1;
}

static PetscInt find_group(const BlockMesh *mesh, const char *name)
{
  return find_name(name, mesh->n_groups, (const NameText *)mesh->group_names);
}

static PetscInt find_face_set(const BlockMesh *mesh, const char *name)
{
  return find_name(name, mesh->n_face_sets, (const NameText *)mesh->face_set_names);
}

static PetscInt find_point(const BlockMesh *mesh, const char *name)
{
  return find_name(name, mesh->n_points, (const NameText *)mesh->point_names);
}

// Appends "; groups: a, b", as far as there is room.
static void append_names(char text[MESSAGE_LENGTH], const char *what, PetscInt n, const NameText *names)
{
  size_t used = strlen(text);
  used += snprintf(text + used, MESSAGE_LENGTH - used, "; %s: %s", what, n ? "" : "none");
  for (PetscInt i = 0; i < n && used < MESSAGE_LENGTH; i++) {
    PetscBool full = (PetscBool)(used > MESSAGE_LENGTH / 2);
    used += snprintf(text + used, MESSAGE_LENGTH - used, "%s%s", i ? ", " : "", full ? ".." : names[i]);
    if (full) break;
  }
}

enum { GROUPS = 1, FACE_SETS = 2, POINTS = 4 };

// Complains unless `name` names exactly one thing of the kinds asked for.
static void check_target(const Scene *scene, const BlockMesh *mesh, int kinds, const char *name, int line,
                         const char *key, char *message)
{
  static const char *const words[] = {
      "",      "group",          "face set",          "group or face set",
      "point", "group or point", "face set or point", "group, face set or point"};
  int found = (kinds & GROUPS && find_group(mesh, name) >= 0) +
              (kinds & FACE_SETS && find_face_set(mesh, name) >= 0) +
              (kinds & POINTS && find_point(mesh, name) >= 0);
  char text[MESSAGE_LENGTH];

  if (found == 1) return;
  if (found > 1) {
    Complain(message, scene->file, line, key,
             "'%s' names more than one of group, face set and point of the mesh: rename one", name);
    return;
  }
  snprintf(text, sizeof text, "the mesh has no %s '%s'", words[kinds], name);
  if (kinds & GROUPS) append_names(text, "groups", mesh->n_groups, (const NameText *)mesh->group_names);
  if (kinds & FACE_SETS)
    append_names(text, "face sets", mesh->n_face_sets, (const NameText *)mesh->face_set_names);
  if (kinds & POINTS) append_names(text, "points", mesh->n_points, (const NameText *)mesh->point_names);
  Complain(message, scene->file, line, key, "%s", text);
}

/* ------------------------------------------------------------------------------------------------------ */

// Checks the requirements of a condensed group in a scene with a dynamic stage or modes.
static void check_vibrating(const Scene *scene, const Material *m, const char *key, char *message)
{
  const Stage *stage = scene->stages;
  if (!SceneVibrates(scene)) return;
  while (StageRelaxes(stage)) stage++;
  const char *of = stage->kind == STAGE_MODES ? "of type modes" : "dynamic";
  if (PetscIsNanReal(m->highest_frequency))
    Complain(message, scene->file, m->line, key,
             "highest_frequency is missing [Hz]: condensed, and stage %s is %s: bodies keep their "
             "vibrations up to it",
             stage->name, of);
  if (!(m->density > 0.))
    Complain(message, scene->file, m->line, key,
             "density: condensed, and stage %s is %s: expected a density > 0", stage->name, of);
  if (SceneInTime(scene) && (m->velocity[0] != 0. || m->velocity[1] != 0. || m->spin != 0.))
    Complain(message, scene->file, m->line, key, "velocity: a condensed body starts at rest");
}

// Completes a material: a deformable group needs elastic constants, a rigid one has none.
static void complete_material(const Scene *scene, const BlockMesh *mesh, PetscInt group, Material *m,
                              char *message)
{
  char key[LABEL_LENGTH];

  snprintf(key, sizeof key, "materials.%s", m->name);
  if (m->rigid < 0) m->rigid = mesh->group_rigid[group] != 0;
  m->is_open = (PetscBool)(m->condensed < 0);
  if (m->rigid && m->condensed > 0)
    Complain(message, scene->file, m->line, key, "condensed, but rigid: choose one");
  if (m->rigid && m->beta > 0.)
    Complain(message, scene->file, m->line, key,
             "beta damps strain, and a rigid group has none: leave it out");
  if (m->condensed > 0 && !m->macroblocks)
    Complain(message, scene->file, m->line, key,
             "condensed, but macroblocks is false: a single block has no inside");
  if (m->condensed > 0) check_vibrating(scene, m, key, message);
  if (!m->rigid && PetscIsNanReal(m->young))
    Complain(message, scene->file, m->line, key, "young is missing [Pa] (or rigid: true)");
  if (!m->rigid && PetscIsNanReal(m->poisson))
    Complain(message, scene->file, m->line, key, "poisson is missing (or rigid: true)");
  if (PetscIsNanReal(m->young)) m->young = 0;
  if (PetscIsNanReal(m->poisson)) m->poisson = 0;
}

// Puts the materials into the order of the mesh's groups, one for each group.
static PetscErrorCode resolve_materials(Scene *scene, const BlockMesh *mesh, char *message)
{
  Material *ordered;
  char key[LABEL_LENGTH];

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_materials; i++) {
    snprintf(key, sizeof key, "materials.%s", scene->materials[i].name);
    check_target(scene, mesh, GROUPS, scene->materials[i].name, scene->materials[i].line, key, message);
  }
  PetscCall(PetscCalloc1(mesh->n_groups, &ordered));
  for (PetscInt g = 0; g < mesh->n_groups; g++) {
    const char *group = mesh->group_names[g];
    PetscInt i = 0;
    while (i < scene->n_materials && strcmp(scene->materials[i].name, group)) i++;
    if (i < scene->n_materials) {
      ordered[g] = scene->materials[i];
      complete_material(scene, mesh, g, &ordered[g], message);
    } else
      Complain(message, scene->file, -1, "materials", "no material for the group '%s' of the mesh", group);
  }
  PetscCall(PetscFree(scene->materials));
  scene->materials = ordered;
  scene->n_materials = mesh->n_groups;
  PetscBool any = PETSC_FALSE;
  for (PetscInt g = 0; g < mesh->n_groups; g++) any = (PetscBool)(any || ordered[g].output);
  if (!any)
    Complain(message, scene->file, -1, "materials",
             "output is false for every group: nothing is left to write");
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Checks the names of joints: "default", a face set, or two groups joined by +.
static void check_joints(const Scene *scene, const BlockMesh *mesh, char *message)
{
  char key[LABEL_LENGTH], reversed[2 * NAME_LENGTH];

  for (PetscInt j = 1; j < scene->n_joints; j++) {
    const Joint *joint = &scene->joints[j];
    NameText first;
    snprintf(key, sizeof key, "joints.%s", joint->name);
    const char *plus = strchr(joint->name, '+');
    if (!plus) {
      check_target(scene, mesh, FACE_SETS, joint->name, joint->line, key, message);
      continue;
    }
    snprintf(first, sizeof first, "%.*s", (int)(plus - joint->name), joint->name);
    check_target(scene, mesh, GROUPS, first, joint->line, key, message);
    check_target(scene, mesh, GROUPS, plus + 1, joint->line, key, message);
    snprintf(reversed, sizeof reversed, "%s+%s", plus + 1, first);
    for (PetscInt i = 1; i < j; i++)
      if (!strcmp(scene->joints[i].name, reversed))
        Complain(message, scene->file, joint->line, key, "the same pair of groups as %s", reversed);
  }
}

static void check_supports(const Scene *scene, const BlockMesh *mesh, char *message)
{
  char key[LABEL_LENGTH];

  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    snprintf(key, sizeof key, "supports.%s", s->name);
    check_target(scene, mesh, GROUPS | FACE_SETS | POINTS, s->target, s->line, key, message);
    if (s->half_space[0]) check_target(scene, mesh, GROUPS, s->half_space, s->line, key, message);
    const PetscInt group = find_group(mesh, s->target);
    if (SceneInTime(scene) && group >= 0 && scene->materials[group].condensed > 0)
      Complain(message, scene->file, s->line, key,
               "holds the condensed group %s as a whole, and a stage is dynamic: expected a face set of it",
               s->target);
  }
}

// Decides whether a load has groups: [none], to act on water alone, unless the mesh has a group of that name.
static PetscBool acts_on_none(const BlockMesh *mesh, const Load *load)
{
  return (PetscBool)(load->kind == LOAD_PSEUDO_STATIC && load->n_groups == 1 &&
                     !strcmp(load->groups[0], "none") && find_group(mesh, "none") < 0);
}

// Checks that a temperature has blocks that expand; a named group must be able to.
static void check_temperature(const Scene *scene, const BlockMesh *mesh, const Load *load, const char *key,
                              char *message)
{
  PetscBool any = PETSC_FALSE;

  for (PetscInt g = 0; g < mesh->n_groups; g++) {
    const Material *m = scene->materials + g;
    const PetscBool named = find_name(m->name, load->n_groups, (const NameText *)load->groups) >= 0;
    any = (PetscBool)(any || (!m->rigid && m->expansion > 0.));
    if (named && m->rigid)
      Complain(message, scene->file, load->line, key, "the group %s is rigid: it cannot expand", m->name);
    else if (named && !(m->expansion > 0.))
      Complain(message, scene->file, load->line, key, "materials.%s.expansion is missing [1/K]", m->name);
  }
  if (!any)
    Complain(message, scene->file, load->line, key,
             "nothing expands: expected materials.<group>.expansion [1/K] of a group that is not rigid");
}

static void check_loads(const Scene *scene, const BlockMesh *mesh, char *message)
{
  // kind of target of each kind of load, none: it acts on groups alone; TermKind.loads has room for 32
  static const int kinds[32] = {
      [LOAD_RESERVOIR] = FACE_SETS,   [LOAD_TRACTION] = FACE_SETS,      [LOAD_POINT_FORCE] = POINTS,
      [LOAD_UPLIFT] = FACE_SETS,      [LOAD_HEAD] = FACE_SETS,          [LOAD_DRAIN] = FACE_SETS,
      [LOAD_INFLOW] = FACE_SETS,      [LOAD_PSEUDO_STATIC] = FACE_SETS, [LOAD_ADDED_MASS] = FACE_SETS,
      [LOAD_TEMPERATURE] = FACE_SETS, [LOAD_SILT] = FACE_SETS,          [LOAD_ICE] = FACE_SETS,
      [LOAD_OVERFLOW] = FACE_SETS,    [LOAD_TAILWATER] = FACE_SETS,     [LOAD_WAVE] = FACE_SETS,
      [LOAD_CREST_LOAD] = FACE_SETS,  [LOAD_PRESSURE] = FACE_SETS};
  char key[LABEL_LENGTH];

  for (const Load *load = scene->loads; load < scene->loads + scene->n_loads; load++) {
    snprintf(key, sizeof key, "loads.%s", load->name);
    for (PetscInt g = 0; g < load->n_groups && !acts_on_none(mesh, load); g++)
      check_target(scene, mesh, GROUPS, load->groups[g], load->line, key, message);
    if (kinds[load->kind] && load->target[0])
      check_target(scene, mesh, kinds[load->kind], load->target, load->line, key, message);
    if (load->surface.crest[0])
      check_target(scene, mesh, FACE_SETS, load->surface.crest, load->line, key, message);
    if (load->kind == LOAD_TEMPERATURE) check_temperature(scene, mesh, load, key, message);
  }
}

static void check_pushed(const Scene *scene, const BlockMesh *mesh, char *message)
{
  char key[LABEL_LENGTH];

  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++) {
    const char *const names[] = {s->point, s->body, s->group}, *const keys[] = {"point", "body", "group"};
    for (int i = 0; i < 3; i++) {
      snprintf(key, sizeof key, "stages.%s.%s", s->name, keys[i]);
      if (names[i][0]) check_target(scene, mesh, i < 2 ? POINTS : GROUPS, names[i], s->line, key, message);
    }
  }
}

static void check_build(const Scene *scene, const BlockMesh *mesh, char *message)
{
  char key[LABEL_LENGTH];

  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (PetscInt i = 0; i < s->n_build; i++) {
      snprintf(key, sizeof key, "stages.%s.build", s->name);
      check_target(scene, mesh, GROUPS, s->build[i], s->line, key, message);
    }
}

// Refuses a stage that is named <stage>_<k>, because the results of frames have such names.
static void check_frames(const Scene *scene, char *message)
{
  char frame[NAME_LENGTH + 16], key[NAME_LENGTH + 16];

  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (const Stage *other = scene->stages; other < scene->stages + scene->n_stages; other++) {
      const size_t length = strlen(s->name);
      if (strncmp(other->name, s->name, length) || other->name[length] != '_') continue;
      const long k = strtol(other->name + length + 1, NULL, 10);
      snprintf(frame, sizeof frame, "%s_%ld", s->name, k);
      if (k < 1 || k > s->frames || strcmp(frame, other->name)) continue;
      snprintf(key, sizeof key, "stages.%s", other->name);
      Complain(message, scene->file, other->line, key, "is the name of a frame of stage %s: choose another",
               s->name);
    }
}

// Takes [all] as all groups, which is an empty list, unless the mesh has a group of that name.
static void take_all(const BlockMesh *mesh, PetscInt *n, const NameText *groups)
{
  if (*n == 1 && !strcmp(groups[0], "all") && find_group(mesh, "all") < 0) *n = 0;
}

PetscErrorCode SceneResolve(MPI_Comm comm, Scene *scene, const BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";

  PetscFunctionBeginUser;
  PetscCall(resolve_materials(scene, mesh, message));
  take_all(mesh, &scene->n_damping_groups, (const NameText *)scene->damping_groups);
  for (PetscInt l = 0; l < scene->n_loads; l++)
    take_all(mesh, &scene->loads[l].n_groups, (const NameText *)scene->loads[l].groups);
  check_joints(scene, mesh, message);
  check_supports(scene, mesh, message);
  check_loads(scene, mesh, message);
  for (PetscInt g = 0; g < scene->n_damping_groups; g++)
    check_target(scene, mesh, GROUPS, scene->damping_groups[g], -1, "relaxation.groups", message);
  check_build(scene, mesh, message);
  check_pushed(scene, mesh, message);
  check_frames(scene, message);
  for (PetscInt i = 0; i < scene->n_supports; i++) scene->supports[i].row = i;
  for (PetscInt i = 0; i < scene->n_stages && !message[0]; i++)
    if (scene->stages[i].connectivity == CONNECTIVITY_VARIABLE && scene->strain == STRAIN_SMALL)
      snprintf(message, MESSAGE_LENGTH,
               "%.500s: stages.%s: connectivity is variable but strain is small: blocks that move far need "
               "strain: large",
               scene->file, scene->stages[i].name);
  PetscCall(CheckMessage(comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

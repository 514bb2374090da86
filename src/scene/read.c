/* read.c: turns the YAML scene and the command line into a Scene. keys.h lists the keys; resolve.c
   checks names against the mesh. Every rank reads the same text and arguments, so every rank has the same
   Scene. */
#include "scene/scene.h"
#include "scene/keys.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>

PetscErrorCode IsGiven(Reader *r, const char *path, const char *name, PetscBool *given)
{
  Entry *entry;

  PetscFunctionBeginUser;
  PetscCall(Ask(r, path, name, &entry));
  *given = (PetscBool)(entry != NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a key of this name belongs to the type in another row, with another default or range. */
static PetscBool has_other_row(const Key *key, int type)
{
  for (const Key *k = Keys; k < Keys + KEYS; k++)
    if (k->section == key->section && (k->loads | k->stages) & BIT(type) && !strcmp(k->name, key->name))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

// Reads all keys of one section into the struct `base`. kind: the kind of a load or stage, which is its first
// key.
static PetscErrorCode read_section(Reader *r, Section section, const char *path, void *base, const void *kind)
{
  const PetscBool is_stage = (PetscBool)(section == SECTION_STAGES);
  Entry *entry;

  PetscFunctionBeginUser;
  for (const Key *key = Keys; key < Keys + KEYS && !r->message[0]; key++) {
    if (key->section != section || key->type == TYPE_CHANGES) continue;
    PetscCall(Ask(r, path, key->name, &entry));
    const int bits = is_stage ? key->stages : key->loads;
    const int type = kind ? *(const int *)kind : 0; // the first key has set it by now
    if (!bits || bits & BIT(type)) {
      PetscCall(ReadKey(r, key, entry, base));
      PetscCall(EchoKey(r, key, entry));
    } else if (entry && !has_other_row(key, type))
      COMPLAIN(r, "does not belong to a %s of type %s", is_stage ? "stage" : "load",
               (is_stage ? StageTypes : LoadTypes)[type]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the names of a section that is a list, and allocates its entries of `size` bytes, all zero. Without
   names the complaint is `missing`, NULL: none. Free names and entries with PetscFree. */
static PetscErrorCode begin_list(Reader *r, const char *section, size_t size, const char *missing,
                                 PetscInt *n, Name **names, void *entries)
{
  PetscFunctionBeginUser;
  PetscCall(AskNames(r, section, n, names));
  if (!*n && missing) COMPLAIN_MISSING(r, "%s", missing);
  PetscCall(PetscCalloc(*n * size, (void **)entries));
  if (*n) PetscCall(EchoSection(r, 0, section));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins an entry of a list: gives it its name and line, and path the path of its keys. */
static PetscErrorCode begin_entry(Reader *r, const char *section, const Name *from, char name[NAME_LENGTH],
                                  int *line, char path[LABEL_LENGTH])
{
  PetscFunctionBeginUser;
  memcpy(name, from->name, NAME_LENGTH);
  *line = from->line;
  PetscCall(AskSection(r, section, name, path));
  PetscCall(EchoSection(r, 2, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_materials(Reader *r, Scene *scene)
{
  char path[LABEL_LENGTH];
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(begin_list(r, "materials", sizeof(Material), "missing: every group of the mesh needs a material",
                       &scene->n_materials, &names, &scene->materials));
  for (PetscInt i = 0; i < scene->n_materials; i++) {
    Material *m = &scene->materials[i];
    PetscCall(begin_entry(r, "materials", names + i, m->name, &m->line, path));
    m->young = m->poisson = NAN; // NaN until SceneResolve knows whether the mesh says rigid
    m->tension = m->compression = m->cohesion = m->friction = NAN;
    m->highest_frequency = m->beta = m->fracture_energy = m->k0 = m->surface = NAN;
    m->rigid = m->condensed = -1;
    PetscCall(read_section(r, SECTION_MATERIALS, path, m, NULL));
    PetscCall(r->complete->material(r, path, m));
  }
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a section whose entries begin with a TermEntry. size: [byte] of an entry; free entries with
   PetscFree. */
static PetscErrorCode read_entries(Reader *r, Section section, const char *word, size_t size, PetscInt *n,
                                   void **entries)
{
  char path[LABEL_LENGTH];
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(begin_list(r, word, size, NULL, n, &names, entries));
  for (PetscInt i = 0; i < *n; i++) {
    TermEntry *entry = (TermEntry *)((char *)*entries + (size_t)i * size);
    PetscCall(begin_entry(r, word, names + i, entry->name, &entry->line, path));
    PetscCall(read_section(r, section, path, entry, NULL));
    if (section == SECTION_MOTIONS) PetscCall(r->complete->motion(r, path, (void *)entry));
  }
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_supports(Reader *r, Scene *scene)
{
  char path[LABEL_LENGTH];
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(begin_list(r, "supports", sizeof(Support), NULL, &scene->n_supports, &names, &scene->supports));
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    Support *s = &scene->supports[i];
    PetscCall(begin_entry(r, "supports", names + i, s->name, &s->line, path));
    memcpy(s->target, s->name, NAME_LENGTH);
    PetscCall(read_section(r, SECTION_SUPPORTS, path, s, NULL));
    PetscCall(r->complete->support(r, path, s));
  }
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_loads(Reader *r, Scene *scene)
{
  char path[LABEL_LENGTH];
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(begin_list(r, "loads", sizeof(Load), NULL, &scene->n_loads, &names, &scene->loads));
  for (PetscInt i = 0; i < scene->n_loads; i++) {
    Load *load = &scene->loads[i];
    PetscCall(begin_entry(r, "loads", names + i, load->name, &load->line, path));
    load->uplift.drain = load->uplift.gallery = load->uplift.tailwater = load->uplift.efficiency = NAN;
    load->flow.from[0] = load->flow.from[1] = load->flow.to[0] = load->flow.to[1] = NAN;
    load->flow.distance = load->flow.factor = load->flow.aperture = load->hydro.bottom = NAN;
    load->heat.change = load->heat.amplitude = load->lateral = load->rest_angle = NAN, load->heat.factor = 1.;
    load->surface.crest_pressure = load->surface.bottom = load->surface.height = load->surface.wind = NAN;
    load->surface.fetch = load->surface.length = NAN;
    load->coefficient[1] = -1.; // of self_weight, which has no such key
    load->partial_factor = 1.;
    PetscCall(read_section(r, SECTION_LOADS, path, load, &load->kind));
    if (r->complete->load[load->kind]) PetscCall(r->complete->load[load->kind](r, path, load));
  }
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_term_sections(Reader *r, Scene *scene)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(TERM_SECTION_ROWS, &scene->terms));
  for (int t = 0; TermSections[t].word; t++)
    PetscCall(read_entries(r, TermSections[t].section, TermSections[t].word, TermSections[t].size,
                           &scene->terms[t].n, &scene->terms[t].entries));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ------------------------------------------------------------------------------------------ joints */

// Finds where each joint's keys are given: given[j * KEYS + k] for key k of joint j, NULL: nowhere. Entries
// below `path` replace earlier ones.
static PetscErrorCode ask_joints(Reader *r, const char *path, PetscInt n, const Joint *joints,
                                 const Entry **given)
{
  char section[LABEL_LENGTH];
  Entry *entry;

  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < n; j++) {
    if (j == 0 && !joints[0].defined) continue;
    PetscCall(AskSection(r, path, joints[j].name, section));
    for (PetscInt k = 0; k < KEYS; k++) {
      if (Keys[k].section != SECTION_JOINTS) continue;
      PetscCall(Ask(r, section, Keys[k].name, &entry));
      if (entry) given[j * KEYS + k] = entry;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Returns where the key of a joint is given: at the joint itself, else at the default joint; NULL: nowhere.
static const Entry *joint_source(const Entry *const *given, PetscInt joint, PetscInt key)
{
  return given[joint * KEYS + key] ? given[joint * KEYS + key] : given[key];
}

/* Echoes the keys of all joints. before: where they were given in the stage before; NULL: this is the table
   of the scene, which is echoed whole. A stage echoes only keys that are given elsewhere than before. */
static PetscErrorCode echo_joints(Reader *r, PetscInt n, const Joint *joints, const Entry *const *given,
                                  const Entry *const *before)
{
  const int indent = before ? 4 : 0;
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < n; j++) {
    PetscBool named = PETSC_FALSE;
    for (PetscInt k = 0; k < KEYS && joints[j].defined; k++) {
      const Entry *source = joint_source(given, j, k);
      if (Keys[k].section != SECTION_JOINTS || (before && source == joint_source(before, j, k))) continue;
      if (!any) PetscCall(EchoSection(r, indent, "joints"));
      if (!named) PetscCall(EchoSection(r, indent + 2, joints[j].name));
      PetscCall(EchoKey(r, &Keys[k], source));
      any = named = PETSC_TRUE;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Reads the keys of a joint table; a key that is given nowhere keeps its value in the table.
static PetscErrorCode read_joint_table(Reader *r, const char *path, PetscInt n, Joint *joints,
                                       const Entry **given)
{
  char section[LABEL_LENGTH];
  Entry *entry;

  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < n; j++) {
    joints[j].friction[0] = joints[j].friction[1] = NAN;
    joints[j].aperture = joints[j].aperture_residual = NAN;
    if (!joints[j].defined) continue;
    PetscCall(AskSection(r, path, joints[j].name, section));
    for (PetscInt k = 0; k < KEYS; k++) {
      if (Keys[k].section != SECTION_JOINTS) continue;
      const Entry *source = joint_source(given, j, k);
      PetscCall(Ask(r, section, Keys[k].name, &entry));
      if (source) {
        snprintf(r->label, LABEL_LENGTH, "%s", source->key);
        r->line = source->line;
      }
      PetscCall(ReadKey(r, &Keys[k], source, &joints[j]));
    }
    PetscCall(AskSection(r, path, joints[j].name, section));
    PetscCall(r->complete->joint(r, &joints[j]));
    JointPrepare(&joints[j]);
  }
  if (!joints[0].defined) joints[0].friction[0] = joints[0].friction[1] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Reads the joints of the scene. Row 0 is "default", given or not. Free `given` with PetscFree.
static PetscErrorCode read_joints(Reader *r, Scene *scene, const Entry ***given)
{
  PetscInt n_names;
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(AskNames(r, "joints", &n_names, &names));
  for (PetscInt k = 0; k < KEYS; k++)
    if (Keys[k].section == SECTION_JOINTS) AddOptionNames(r, "joints", Keys[k].name, &n_names, names);
  PetscCall(PetscCalloc1(n_names + 1, &scene->joints));
  snprintf(scene->joints[0].name, NAME_LENGTH, "default");
  scene->n_joints = 1;
  for (PetscInt i = 0; i < n_names; i++) {
    Joint *joint = strcmp(names[i].name, "default") ? &scene->joints[scene->n_joints++] : &scene->joints[0];
    memcpy(joint->name, names[i].name, NAME_LENGTH);
    joint->line = names[i].line;
    joint->defined = PETSC_TRUE;
  }
  PetscCall(PetscFree(names));
  PetscCall(PetscCalloc1(scene->n_joints * KEYS, given));
  PetscCall(ask_joints(r, "joints", scene->n_joints, scene->joints, *given));
  PetscCall(read_joint_table(r, "joints", scene->n_joints, scene->joints, *given));
  PetscCall(echo_joints(r, scene->n_joints, scene->joints, *given, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ------------------------------------------------------------------------------------------ stages */

// Finds where keys of joints are given up to the end of a stage: in the section joints, `first`, and in the
// stages that it comes of.
static PetscErrorCode ask_joints_up_to(Reader *r, const Scene *scene, PetscInt stage,
                                       const Entry *const *first, const Entry **given)
{
  char path[LABEL_LENGTH];

  PetscFunctionBeginUser;
  if (stage < 0) {
    PetscCall(PetscArraycpy(given, first, scene->n_joints * KEYS));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ask_joints_up_to(r, scene, StageBase(scene, stage), first, given));
  PetscCall(AskSection(r, "stages", scene->stages[stage].name, path));
  PetscCall(AskSection(r, path, "joints", path));
  PetscCall(ask_joints(r, path, scene->n_joints, scene->joints, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// The joints of a stage are those at the end of the stage from which it starts, with its own changes. They
// are read again from where their keys are given. given: as the stage before has left it.
static PetscErrorCode read_stage_joints(Reader *r, const char *parent, const Scene *scene,
                                        const Entry *const *first, Stage *stage, const Entry **given)
{
  const PetscInt base = StageBase(scene, (PetscInt)(stage - scene->stages));
  const Joint *last = base < 0 ? scene->joints : scene->stages[base].joints;
  char path[LABEL_LENGTH];
  const Entry **before;
  PetscBool same;

  PetscFunctionBeginUser;
  if (stage->skips) PetscCall(ask_joints_up_to(r, scene, base, first, given));
  PetscCall(PetscMalloc1(scene->n_joints * KEYS, &before));
  PetscCall(PetscArraycpy(before, given, scene->n_joints * KEYS));
  PetscCall(PetscMalloc1(scene->n_joints, &stage->joints));
  PetscCall(PetscArraycpy(stage->joints, last, scene->n_joints));
  PetscCall(AskSection(r, parent, "joints", path));
  PetscCall(ask_joints(r, path, scene->n_joints, scene->joints, given));
  PetscCall(PetscArraycmp(given, before, scene->n_joints * KEYS, &same));
  if (!same) PetscCall(read_joint_table(r, path, scene->n_joints, stage->joints, given));
  PetscCall(echo_joints(r, scene->n_joints, scene->joints, given, before));
  PetscCall(PetscFree(before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_stages(Reader *r, Scene *scene, const Entry *const *first)
{
  char path[LABEL_LENGTH];
  const Entry **given;
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(scene->n_joints * KEYS, &given));
  PetscCall(PetscArraycpy(given, first, scene->n_joints * KEYS));
  PetscCall(begin_list(r, "stages", sizeof(Stage), "missing: at least one stage is needed", &scene->n_stages,
                       &names, &scene->stages));
  for (PetscInt i = 0; i < scene->n_stages && !r->message[0]; i++) {
    Stage *stage = &scene->stages[i];
    *stage = r->defaults;
    stage->connectivity = scene->connectivity;
    PetscCall(begin_entry(r, "stages", names + i, stage->name, &stage->line, path));
    stage->start = stage->step = stage->limit = stage->factor = stage->displacement_limit = NAN;
    stage->time_step = stage->damping_ratio = NAN;
    stage->friction_factor = stage->cohesion_factor = 1.;
    stage->damping_frequencies[0] = stage->damping_frequencies[1] = NAN;
    PetscCall(read_section(r, SECTION_STAGES, path, stage, &stage->kind));
    PetscCall(r->complete->any_stage(r, path, stage));
    PetscCall(read_stage_joints(r, path, scene, first, stage, given));
    if (r->complete->stage[stage->kind]) PetscCall(r->complete->stage[stage->kind](r, path, stage));
  }
  PetscCall(PetscFree(given));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ------------------------------------------------------------------------------------------- whole */

static PetscErrorCode read_all(Reader *r, Scene *scene)
{
  char path[LABEL_LENGTH];
  const Entry **given;
  void *motions;

  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferCreate(1, 1 << 15, &r->asked));
  PetscCall(PetscSegBufferCreate(1, 4096, &r->echo));
  PetscCall(read_section(r, SECTION_TOP, "", scene, NULL));
  PetscCall(AskSection(r, "", "contact", path));
  PetscCall(EchoSection(r, 0, "contact"));
  PetscCall(read_section(r, SECTION_CONTACT, path, scene, NULL));
  PetscCall(AskSection(r, "", "relaxation", path));
  PetscCall(EchoSection(r, 0, "relaxation"));
  PetscCall(read_section(r, SECTION_RELAXATION, path, scene, NULL));
  PetscCall(read_section(r, SECTION_STAGE_DEFAULTS, path, &r->defaults, NULL));
  PetscCall(AskSection(r, "", "checkpoint", path));
  PetscCall(EchoSection(r, 0, "checkpoint"));
  PetscCall(read_section(r, SECTION_CHECKPOINT, path, scene, NULL));
  PetscCall(AskSection(r, "", "flow", path));
  PetscCall(EchoSection(r, 0, "flow"));
  PetscCall(read_section(r, SECTION_FLOW, path, scene, NULL));
  PetscCall(read_materials(r, scene));
  PetscCall(read_joints(r, scene, &given));
  PetscCall(read_entries(r, SECTION_MOTIONS, "motions", sizeof(GroundMotion), &scene->n_motions, &motions));
  scene->motions = motions;
  PetscCall(read_supports(r, scene));
  PetscCall(read_term_sections(r, scene));
  PetscCall(read_loads(r, scene));
  PetscCall(read_stages(r, scene, given));
  if (!r->message[0]) SceneApplyPartialFactors(scene);
  for (const TermSection *of = TermSections; of->word; of++)
    if (r->complete->term[of->section]) PetscCall(r->complete->term[of->section](r));
  PetscCall(ReadWhatIf(r));
  PetscCall(ConcludeMessage(r));
  PetscCall(PetscFree(given));
  PetscCall(PetscSegBufferDestroy(&r->asked));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneRead(MPI_Comm comm, const char *file, int argc, char **argv, const Completions *complete,
                         Scene *scene)
{
  Reader r = {.scene = scene, .complete = complete};
  PetscInt length = 0;
  char *text = NULL;

  PetscFunctionBeginUser;
  memset(scene, 0, sizeof *scene);
  if (file) {
    snprintf(scene->file, sizeof scene->file, "%s", file);
    PetscCall(SceneText(comm, file, &text, &length, r.message));
  }
  if (!r.message[0] && text) PetscCall(EntriesReadYAML(&r.entries, file, text, length, r.message));
  if (!r.message[0]) PetscCall(EntriesReadArguments(&r.entries, argc, argv, r.message));
  if (!r.message[0]) PetscCall(EntriesCheckElsewhere(r.message));
  if (!r.message[0]) PetscCall(read_all(&r, scene));
  if (!r.message[0]) PetscCall(EntriesText(&r.entries, &scene->options));
  if (!r.message[0]) PetscCall(SceneNoteFiles(scene));
  PetscCall(PetscFree(text));
  PetscCall(EntriesDestroy(&r.entries));
  if (r.message[0]) PetscCall(PetscSegBufferDestroy(&r.echo));
  PetscCall(CheckMessage(comm, r.message));
  PetscCall(SceneFindModel(comm, scene));
  PetscCall(EchoEnd(&r, &scene->echo));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the lists that the keys of a section have filled in n entries of `size` bytes. */
static PetscErrorCode free_lists(Section section, PetscInt n, size_t size, void *entries)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; entries && i < n; i++)
    for (const Key *key = Keys; key < Keys + KEYS; key++) {
      void **list = (void **)((char *)entries + (size_t)i * size + key->offset);
      if (key->section == section && key->count) PetscCall(PetscFree(*list));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneDestroy(Scene *scene)
{
  PetscFunctionBeginUser;
  PetscCall(free_lists(SECTION_RELAXATION, 1, sizeof *scene, scene));
  PetscCall(free_lists(SECTION_LOADS, scene->n_loads, sizeof(Load), scene->loads));
  PetscCall(free_lists(SECTION_STAGES, scene->n_stages, sizeof(Stage), scene->stages));
  for (PetscInt i = 0; scene->stages && i < scene->n_stages; i++) {
    PetscCall(PetscFree(scene->stages[i].joints));
    PetscCall(PetscFree2(scene->stages[i].level_rises, scene->stages[i].tail_rises));
  }
  for (int t = 0; scene->terms && TermSections[t].word; t++) {
    const TermSection *row = TermSections + t;
    PetscCall(free_lists(row->section, scene->terms[t].n, row->size, scene->terms[t].entries));
    PetscCall(PetscFree(scene->terms[t].entries));
  }
  PetscCall(PetscFree(scene->terms));
  PetscCall(PetscFree(scene->echo));
  free(scene->options);
  free(scene->solvers);
  PetscCall(PetscFree(scene->materials));
  PetscCall(PetscFree(scene->joints));
  PetscCall(MotionsDestroy(scene));
  PetscCall(PetscFree(scene->supports));
  for (PetscInt i = 0; scene->loads && i < scene->n_loads; i++) {
    PetscCall(PetscFree(scene->loads[i].t));
    PetscCall(PetscFree(scene->loads[i].levels_at));
    PetscCall(PetscFree(scene->loads[i].heat.x));
    PetscCall(PetscFree(scene->loads[i].heat.at));
  }
  PetscCall(PetscFree(scene->loads));
  PetscCall(PetscFree(scene->stages));
  memset(scene, 0, sizeof *scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

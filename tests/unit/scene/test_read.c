/* Scene from YAML and command line: values, defaults, overrides, files that are no scene,
   names against a mesh, and the documents against -help. Refusals: verification/bad_input/catalogue.py.

   ranks: 1 2 */
#include "run/run.h"
#include "check.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[64];                  // temporary
static char message[2 * MESSAGE_LENGTH]; // of the last error, without the folder
static PetscMPIInt rank;

// line numbers matter: the tests below name them
// clang-format off
static const char good[] = "title: Wall, first\n"                                              // 1
                           "model: model.h5\n"                                                 // 2
                           "gravity: 9.81\n"                                                   // 3
                           "contact: {tolerance: 0.002, relative: yes}\n"                      // 4
                           "relaxation: {groups: [dam], ramp: 500, tolerance: 1e-7}\n"         // 5
                           "materials:\n"                                                      // 6
                           "  rock: {density: 0, young: 20e9, poisson: 0.25}\n"                // 7
                           "  dam: {density: 2400, young: 1.0e10, poisson: 0.2}\n"             // 8
                           "  ground: {density: 0, rigid: true}\n"                             // 9
                           "joints:\n"                                                         // 10
                           "  base: {friction: 45, cohesion: 1e5, compression: 5e6}\n"         // 11
                           "  default: {k_n: 10e9, k_s: 3e9, friction: 35, tension: 2e5}\n"    // 12
                           "  dam+rock: {law: elastic, stress_model: r2pt}\n"                  // 13
                           "supports:\n"                                                       // 14
                           "  sides: {fix: x}\n"                                               // 15
                           "  foot: {fix: xy, target: ground}\n"                               // 16
                           "loads:\n"                                                          // 17
                           "  weight: {type: self_weight, groups: [dam, rock]}\n"              // 18
                           "  water: {type: reservoir, faces: upstream, level: 33}\n"          // 19
                           "  push: {type: traction, faces: sides, value: [1e6, -2]}\n"        // 20
                           "  pull: {type: point_force, point: tip, value: [0, -1e3]}\n"       // 21
                           "stages:\n"                                                         // 22
                           "  - sw: {loads: [weight]}\n"                                       // 23
                           "  - hp: {loads: [weight, water], ramp: 0,\n"                       // 24
                           "         joints: {base: {friction: 30}, default: {k_s: 1e9}}}\n"   // 25
                           "  - last: {loads: [pull, push], joints: {base: {cohesion: 7}}}\n"; // 26
// clang-format on

static PetscErrorCode Catch(MPI_Comm comm, int line, const char *function, const char *file,
                            PetscErrorCode code, PetscErrorType type, const char *text, void *context)
{
  (void)comm, (void)line, (void)function, (void)file, (void)context;
  if (type != PETSC_ERROR_INITIAL) return code;
  size_t skip = strncmp(text, folder, strlen(folder)) ? 0 : strlen(folder) + 1;
  snprintf(message, sizeof message, "%s", text + skip);
  return code;
}

static void WritePath(const char *name, char path[PETSC_MAX_PATH_LEN])
{
  snprintf(path, PETSC_MAX_PATH_LEN, "%s/%s", folder, name);
}

static PetscErrorCode WriteFile(const char *name, const char *text)
{
  char path[PETSC_MAX_PATH_LEN];
  WritePath(name, path);
  if (rank) return 0;
  FILE *file = fopen(path, "w");
  if (!file) return PETSC_ERR_FILE_OPEN;
  fputs(text, file);
  return fclose(file);
}

// reads a scene text with options, given as one string with blanks; message: "" if all went well
static PetscErrorCode Read(const char *text, const char *options, Scene *scene)
{
  char path[PETSC_MAX_PATH_LEN], copy[512], *argv[32] = {"quoin"};
  int argc = 1;

  PetscCall(WriteFile("scene.yaml", text ? text : ""));
  WritePath("scene.yaml", path);
  snprintf(copy, sizeof copy, "%s", options);
  for (char *word = strtok(copy, " "); word && argc < 32; word = strtok(NULL, " ")) argv[argc++] = word;
  message[0] = '\0';
  PetscErrorCode code = SceneRead(PETSC_COMM_WORLD, text ? path : NULL, argc, argv, &SceneCompletions, scene);
  ENSURE(!code == !message[0]);
  ENSURE(!code || code == PETSC_ERR_USER_INPUT);
  return 0;
}

// the good scene with one piece of text replaced
static void Change(const char *from, const char *to, char text[4096])
{
  const char *at = strstr(good, from);
  ENSURE(at);
  snprintf(text, 4096, "%.*s%s%s", at ? (int)(at - good) : 0, good, to, at ? at + strlen(from) : "");
}

static void EnsureMessage(const char *expected, const char *what)
{
  if (strcmp(message, expected))
    printf("from:     %s\nexpected: %s\nbut was:  %s\n", what, expected, message);
  ENSURE(!strcmp(message, expected));
}

/* ---------------------------------------------------------------------------------------- good input */

static PetscErrorCode TestValues(void)
{
  Scene s;

  PetscCall(Read(good, "", &s));
  EnsureMessage("", "good");
  ENSURE(!strcmp(s.title, "Wall, first") && !strcmp(s.model, "model.h5") && !strcmp(s.output, "out"));
  ENSURE(s.plane == PLANE_STRAIN && s.strain == STRAIN_LARGE && s.damping == DAMPING_ADAPTIVE);
  ENSURE(s.thickness == 1 && s.gravity == 9.81 && s.contact_relative && !s.allow_floating);
  ENSURE(s.contact_tolerance == 0.002 && s.overlap_tolerance == 0.005 && s.safety == 0.9 &&
         s.alpha_dt == 0.1);
  ENSURE(s.check_every == 50 && s.history_every == 100);
  ENSURE(s.n_damping_groups == 1 && !strcmp(s.damping_groups[0], "dam"));
  ENSURE(s.n_materials == 3 && s.n_joints == 3 && s.n_supports == 2 && s.n_loads == 4 && s.n_stages == 3);
  ENSURE(s.materials[0].rigid == -1 && s.materials[2].rigid == 1 && s.materials[2].line == 9);
  ENSURE(s.materials[1].density == 2400 && s.materials[1].young == 1e10 && s.materials[1].poisson == 0.2);
  ENSURE(s.supports[0].fix[0] && !s.supports[0].fix[1] && !strcmp(s.supports[0].target, "sides"));
  ENSURE(s.supports[1].fix[0] && s.supports[1].fix[1] && !strcmp(s.supports[1].target, "ground"));
  ENSURE(s.loads[0].kind == LOAD_SELF_WEIGHT && s.loads[0].n_groups == 2 &&
         !strcmp(s.loads[0].groups[1], "rock"));
  ENSURE(s.loads[1].kind == LOAD_RESERVOIR && s.loads[1].level == 33 && s.loads[1].density == 1000);
  ENSURE(s.loads[2].traction[0] == 1e6 && s.loads[2].traction[1] == -2 &&
         !strcmp(s.loads[2].target, "sides"));
  ENSURE(s.loads[3].kind == LOAD_POINT_FORCE && !strcmp(s.loads[3].target, "tip") && s.loads[3].line == 21);
  ENSURE(s.stages[0].ramp == 500 && s.stages[1].ramp == 0 && s.stages[2].max_cycles == 1000000);
  ENSURE(s.stages[0].tolerance == 1e-7 && s.stages[0].velocity_tolerance == 1e-6);
  ENSURE(s.stages[2].n_loads == 2 && s.stages[2].loads[0] == 3 && s.stages[2].loads[1] == 2);
  PetscCall(SceneDestroy(&s));
  return 0;
}

static PetscErrorCode TestJoints(void)
{
  Scene s;

  // row 0 is the default; others inherit from it
  PetscCall(Read(good, "", &s));
  const Joint *fall = &s.joints[0], *base = &s.joints[1], *pair = &s.joints[2];
  ENSURE(!strcmp(fall->name, "default") && fall->defined && fall->line == 12 &&
         !strcmp(pair->name, "dam+rock"));
  ENSURE(fall->law == LAW_MOHR_COULOMB && fall->stress_model == STRESS_TPTM &&
         fall->compression == PETSC_INFINITY);
  ENSURE(base->k_n == 10e9 && base->k_s == 3e9 && base->tension[0] == 2e5 && base->tension[1] == 0);
  ENSURE(base->friction[0] == 45 && base->friction[1] == 45 && base->cohesion[0] == 1e5 &&
         base->cohesion[1] == 0);
  ENSURE(base->compression == 5e6 && pair->law == LAW_ELASTIC && pair->stress_model == STRESS_R2PT);

  // changes of a stage stay; what hangs on them follows
  ENSURE(s.stages[0].joints[1].friction[0] == 45 && s.stages[0].joints[1].k_s == 3e9);
  for (int i = 1; i < 3; i++) {
    base = &s.stages[i].joints[1];
    ENSURE(base->friction[0] == 30 && base->friction[1] == 30 && base->k_s == 1e9 && base->k_n == 10e9);
    ENSURE(s.stages[i].joints[0].k_s == 1e9 && s.stages[i].joints[0].friction[0] == 35);
    ENSURE(base->cohesion[0] == (i == 1 ? 1e5 : 7));
  }
  PetscCall(SceneDestroy(&s));

  // without default the row is marked
  PetscCall(Read("model: m.h5\nmaterials: {a: {density: 1}}\njoints: {b: {k_n: 1, k_s: 0, friction: 1}}\n"
                 "loads: {w: {type: self_weight}}\nstages: {one: {loads: [w]}}\n",
                 "", &s));
  EnsureMessage("", "no default");
  ENSURE(s.n_joints == 2 && !s.joints[0].defined && s.joints[1].defined && s.joints[0].k_n == 0);
  ENSURE(!s.stages[0].joints[0].defined && s.loads[0].n_groups == 0 && s.joints[1].k_n == 1);
  PetscCall(SceneDestroy(&s));
  return 0;
}

/* Values with units are those without, to the last bit. */
static PetscErrorCode TestUnits(void)
{
  static const char text[] = "model: m.h5\ngravity: %s\ncontact: {tolerance: %s}\nmaterials: {a: {density: "
                             "%s, young: %s, tension: %s}}\n"
                             "joints: {default: {k_n: %s, k_s: %s, friction: %s, cohesion: %s}}\n"
                             "loads: {w: {type: self_weight}, p: {type: point_force, point: x, value: %s}, "
                             "t: {type: traction, faces: f, "
                             "value: %s}}\nstages: {one: {loads: [w], type: dynamic, duration: %s}}\n";
  static const char *const plain[] = {"9.81", "0.0012", "2400", "12.3e9",     "1.1e6",      "1e10",
                                      "4e9",  "30",     "2e5",  "[-7000, 5]", "[1e3, 0.3]", "180"},
                           *const units[] = {"981 cm/s2", "1.2 mm",           "2.4 t/m3",     "12.3 GPa",
                                             "1.1N/mm2",  "10 GN/m3",         "4 MPa/mm",     "30 deg",
                                             "200 kN/m2", "[-7 kN/m, 5 N/m]", "[1 kPa, 0.3]", "3 min"};
  char a[1024], b[1024];
  Scene s[2];
#define WRITE(to, x)                                                                                         \
  snprintf(to, sizeof to, text, (x)[0], (x)[1], (x)[2], (x)[3], (x)[4], (x)[5], (x)[6], (x)[7], (x)[8],      \
           (x)[9], (x)[10], (x)[11])
  WRITE(a, plain), WRITE(b, units);
#undef WRITE
  PetscCall(Read(a, "", &s[0]));
  EnsureMessage("", "plain");
  PetscCall(Read(b, "", &s[1]));
  EnsureMessage("", "units");
  const Material *m = s[0].materials, *n = s[1].materials;
  ENSURE(s[0].gravity == s[1].gravity && s[0].contact_tolerance == s[1].contact_tolerance);
  ENSURE(m->density == n->density && m->young == n->young && m->tension == n->tension);
  ENSURE(s[0].joints->k_n == s[1].joints->k_n && s[0].joints->k_s == s[1].joints->k_s);
  ENSURE(s[0].joints->friction[0] == s[1].joints->friction[0] &&
         s[0].joints->cohesion[0] == s[1].joints->cohesion[0]);
  for (int l = 1; l < 3; l++)
    for (int x = 0; x < 2; x++) ENSURE(s[0].loads[l].traction[x] == s[1].loads[l].traction[x]);
  ENSURE(s[0].stages->duration == s[1].stages->duration);
  ENSURE(strstr(s[1].echo, "young: 12.3e9  # Pa\n"));
  PetscCall(SceneDestroy(&s[0]));
  PetscCall(SceneDestroy(&s[1]));

  PetscCall(Read("model: m.h5\nmaterials: {a: {density: 24 kN/m3}}\nloads: {w: {type: self_weight}}\n"
                 "joints: {default: {k_n: 1, k_s: 1, friction: 0.5 rad}}\nstages: {one: {loads: [w]}}\n",
                 "-materials_a_highest_frequency 1kHz", &s[0]));
  EnsureMessage("", "weight");
  ENSURE(s[0].materials->density == 24e3 / 9.81 && s[0].materials->highest_frequency == 1000);
  ENSURE(s[0].joints->friction[0] == 0.5 * (180. / PETSC_PI));
  PetscCall(SceneDestroy(&s[0]));
  return 0;
}

static PetscErrorCode TestCommandLine(void)
{
  Scene s;

  PetscCall(
      Read(good,
           "-materials_dam_density 2500 -contact_relative -contact_tolerance 1e-3 -log_view -malloc_dump no "
           "-loads_push_value -5,6 -joints_dam+rock_k_n 1e6 -joints_base_compression inf "
           "-stages_last_joints_dam+rock_k_s 4 -stages sw,last --gravity 1",
           &s));
  EnsureMessage("", "options");
  ENSURE(s.materials[1].density == 2500 && s.contact_tolerance == 1e-3 && s.contact_relative &&
         s.gravity == 1);
  ENSURE(s.loads[2].traction[0] == -5 && s.loads[2].traction[1] == 6 && s.joints[2].k_n == 1e6);
  ENSURE(s.n_stages == 2 && !strcmp(s.stages[1].name, "last") && s.stages[1].joints[2].k_s == 4);
  ENSURE(s.stages[1].joints[1].friction[0] == 45 && s.stages[1].joints[1].compression == PETSC_INFINITY);
  PetscCall(SceneDestroy(&s));

  // rows of joints that the file lacks; -joints names all there are
  PetscCall(
      Read(good, "-joints_rock+ground_k_n 3e9 -joints_new_friction 5 -joints_rock+ground_friction 7", &s));
  EnsureMessage("", "rows from the command line");
  ENSURE(s.n_joints == 5 && !strcmp(s.joints[3].name, "rock+ground") && !strcmp(s.joints[4].name, "new"));
  ENSURE(s.joints[3].k_n == 3e9 && s.joints[3].friction[0] == 7 && s.joints[3].k_s == s.joints[0].k_s);
  ENSURE(s.joints[4].friction[1] == 5 && s.stages[2].joints[4].friction[0] == 5);
  PetscCall(SceneDestroy(&s));
  LEAKS_ALLOWED();
  PetscCall(Read(good, "-joints default,base -joints_new_friction 5", &s));
  LEAKS_COUNT();
  EnsureMessage("command line: -joints_new_friction: unknown option (-help lists all keys)",
                "a list of joints");
  PetscCall(SceneDestroy(&s));

  // no file at all
  PetscCall(
      Read(NULL,
           "-model m.h5 -materials a,b -materials_a_density 1 -materials_b_density 2 -materials_b_rigid "
           "-loads w -loads_w_type self_weight -stages one -stages_one_loads w",
           &s));
  EnsureMessage("", "options only");
  ENSURE(s.n_materials == 2 && s.materials[1].density == 2 && s.materials[1].rigid == 1 && s.n_joints == 1);
  PetscCall(SceneDestroy(&s));
  return 0;
}

/* Names may hold what stands for a dot on the command line. */
static PetscErrorCode TestUnderscores(void)
{
  static const char text[] = "model: m.h5\n"
                             "materials: {dam: {density: 1}}\n"
                             "loads:\n"
                             "  a: {type: uplift, faces: b, level: 3, drain: 4, rule: npb}\n"
                             "  a_drain: {type: reservoir, faces: f, level: 5}\n"
                             "  a_level: {type: self_weight}\n"
                             "stages: [one: {loads: [a_level, a, a_drain]}]\n";
  Scene s;
  PetscCall(Read(text, "-loads_a_level 7", &s));
  EnsureMessage("", "a section is no value");
  ENSURE(s.loads[0].level == 7 && s.loads[1].level == 5 && s.loads[2].kind == LOAD_SELF_WEIGHT);
  PetscCall(SceneDestroy(&s));
  PetscCall(Read(text, "-loads_a_drain_level 8", &s));
  EnsureMessage("", "what the file has comes first");
  ENSURE(s.loads[1].level == 8);
  PetscCall(SceneDestroy(&s));
  return 0;
}

static void EnsureSameJoints(PetscInt n, const Joint *a, const Joint *b)
{
  for (PetscInt j = 0; j < n; j++) {
    Joint left = a[j], right = b[j];
    ENSURE(!strcmp(left.name, right.name));
    left.line = right.line = 0;
    memset(left.name, 0, sizeof left.name); // bytes behind the name
    memset(right.name, 0, sizeof right.name);
    ENSURE(!memcmp(&left, &right, sizeof left));
  }
}

static void EnsureSameStage(PetscInt n_joints, const Stage *a, const Stage *b)
{
  ENSURE(!strcmp(a->name, b->name) && a->kind == b->kind && a->n_loads == b->n_loads);
  ENSURE(!memcmp(a->loads, b->loads, a->n_loads * sizeof *a->loads));
  ENSURE(a->ramp == b->ramp && a->max_cycles == b->max_cycles && a->tolerance == b->tolerance &&
         a->velocity_tolerance == b->velocity_tolerance && a->connectivity == b->connectivity);
  EnsureSameJoints(n_joints, a->joints, b->joints);
}

// keys at their defaults may stand in the echo of any load, and what the command line says is text
static PetscErrorCode TestEchoIsAScene(void)
{
  static const char text[] = "model: m\nmaterials: {a: {density: 2400, rigid: true}}\n"
                             "loads: {under: {type: uplift, faces: f, level: 3}}\n"
                             "stages: [one: {loads: [under]}]\n";
  static const char *const odd[] = {"-title \xe9", "-title \xc3", "-title \xed\xa0\x80",
                                    "-title \xf8\x88\x80", "-title \xc0\xaf"};
  Scene a, b;
  PetscCall(Read(text, "-title d\xc3\xa9\xe2\x82\xac", &a));
  EnsureMessage("", "uplift without a crack");
  PetscCall(Read(a.echo, "", &b));
  EnsureMessage("", a.echo);
  ENSURE(!strcmp(a.title, b.title));
  PetscCall(SceneDestroy(&a));
  PetscCall(SceneDestroy(&b));
  for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
    PetscCall(Read(text, odd[i], &a));
    EnsureMessage("command line: -title: a value is no text in UTF-8", odd[i]);
    PetscCall(SceneDestroy(&a));
  }
  PetscCall(Read(text,
                 "-title a\xe2\x80\xa8"
                 "b",
                 &a));
  EnsureMessage("command line: -title: a value holds the control character U+2028; one line of text expected",
                "");
  PetscCall(SceneDestroy(&a));
  return 0;
}

// the echo of a scene, read as a scene, is the same scene, and its echo says the same values
static PetscErrorCode TestEcho(void)
{
  static const char *const options[] = {"", "-title a\"b\\#: -materials_dam_density 2500.125 "
                                            "-contact_relative -stages last,hp -loads_push_value -5,6 "
                                            "-joints_base_compression inf -stages_hp_joints_default_friction "
                                            "21 -stages_last_joints_dam+rock_k_s 4"};
  Scene a, b;

  for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
    PetscCall(Read(good, options[i], &a));
    EnsureMessage("", "scene");
    PetscCall(Read(a.echo, "", &b));
    EnsureMessage("", a.echo);
    ENSURE(!strcmp(a.title, b.title) && !strcmp(a.model, b.model) && !strcmp(a.output, b.output));
    ENSURE(a.contact_tolerance == b.contact_tolerance && a.contact_relative == b.contact_relative);
    ENSURE(a.n_damping_groups == 1 && b.n_damping_groups == 1 && !strcmp(b.damping_groups[0], "dam"));
    ENSURE(a.n_materials == b.n_materials && a.n_joints == b.n_joints && a.n_supports == b.n_supports &&
           a.n_loads == b.n_loads && a.n_stages == b.n_stages);
    for (PetscInt m = 0; m < a.n_materials; m++) {
      const Material *left = &a.materials[m], *right = &b.materials[m];
      const size_t values = offsetof(Material, density), after = offsetof(Material, line);
      ENSURE(!strcmp(left->name, right->name));
      ENSURE(!memcmp((const char *)left + values, (const char *)right + values, after - values));
    }
    ENSURE(!strcmp(b.supports[1].target, "ground") && b.supports[1].fix[0] && b.supports[1].fix[1]);
    for (PetscInt l = 0; l < a.n_loads; l++)
      ENSURE(!strcmp(a.loads[l].name, b.loads[l].name) && a.loads[l].kind == b.loads[l].kind &&
             !strcmp(a.loads[l].target, b.loads[l].target) && a.loads[l].n_groups == b.loads[l].n_groups &&
             !memcmp(a.loads[l].traction, b.loads[l].traction, sizeof a.loads[l].traction));
    EnsureSameJoints(a.n_joints, a.joints, b.joints);
    for (PetscInt s = 0; s < a.n_stages; s++) EnsureSameStage(a.n_joints, &a.stages[s], &b.stages[s]);
    ENSURE(strstr(a.echo, i ? "density: 2500.125  # kg/m3, command line\n" : "density: 2400  # kg/m3\n"));
    ENSURE(strstr(a.echo, "gravity: 9.81  # m/s2\n") && strstr(a.echo, "thickness: 1  # m, default\n"));
    PetscCall(SceneDestroy(&a));
    PetscCall(SceneDestroy(&b));
  }
  return 0;
}

// the model is looked for here, then beside the scene
// keys that earlier versions had: their presets, as an echo has them, change nothing; others are refused
static PetscErrorCode TestRemovedKeys(void)
{
  static const char old[] = "repartition: {when: auto, every: 10000, gain: %s}\nflow: {dynamic: frozen}\n%s";
  const char *gain[] = {"0.1", "0.2"};
  Scene s;
  for (int i = 0; i < 2; i++) {
    char text[sizeof(good) + sizeof(old)];
    snprintf(text, sizeof text, old, gain[i], good);
    PetscCall(Read(text, "", &s));
    EnsureMessage(
        i ? "scene.yaml:1: repartition.gain: removed: blocks stay on the rank that they have at the "
            "start; leave this key out"
          : "",
        "removed keys");
    PetscCall(SceneDestroy(&s));
  }
  return 0;
}

static PetscErrorCode TestModelPath(void)
{
  char path[PETSC_MAX_PATH_LEN];
  Scene s;

  WritePath("beside.h5", path);
  PetscCall(WriteFile("beside.h5", "x"));
  PetscCall(Read(good, "-model beside.h5", &s));
  ENSURE(!strcmp(s.model, path));
  PetscCall(SceneDestroy(&s));
  PetscCall(Read(good, "-model nowhere.h5", &s));
  ENSURE(!strcmp(s.model, "nowhere.h5"));
  PetscCall(SceneDestroy(&s));
  if (rank == 0) unlink(path);
  return 0;
}

/* ----------------------------------------------------------------------------------------- bad input */

static PetscErrorCode TestBadFiles(void)
{
  char path[PETSC_MAX_PATH_LEN], *argv[] = {"quoin"};
  Scene s;

  PetscCall(Read("", "", &s));
  EnsureMessage("scene.yaml: the scene is empty", "empty");
  PetscCall(SceneDestroy(&s));
  PetscCall(Read("- a\n- b\n", "", &s));
  EnsureMessage("scene.yaml:1: a scene is made of 'key: value' lines", "list");
  PetscCall(SceneDestroy(&s));
  PetscCall(Read("a: &a {b: *a}\n", "", &s));
  EnsureMessage("scene.yaml:1: a.b.b.b.b.b.b: nested too deeply", "circle");
  PetscCall(SceneDestroy(&s));
  PetscCall(Read("a:\n  [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[", "", &s));
  EnsureMessage("scene.yaml:2: nested too deeply", "brackets");
  PetscCall(SceneDestroy(&s));
  PetscCall(Read("title: \"a\\e[31mb\"\n", "", &s));
  EnsureMessage("scene.yaml:1: a value holds the control character U+001B; one line of text expected",
                "escape");
  PetscCall(SceneDestroy(&s));
  WritePath("none.yaml", path);
  ENSURE(SceneRead(PETSC_COMM_WORLD, path, 1, argv, &SceneCompletions, &s) == PETSC_ERR_USER_INPUT);
  EnsureMessage("none.yaml: cannot read the scene: No such file or directory", "no file");
  PetscCall(SceneDestroy(&s));
  return 0;
}

/* ---------------------------------------------------------------------------------------- the mesh */

static PetscErrorCode Resolve(const char *from, const char *to, Scene *s)
{
  char groups[3][NAME_LENGTH] = {"dam", "ground", "rock"},
       sets[4][NAME_LENGTH] = {"base", "upstream", "sides", "both"};
  char points[2][NAME_LENGTH] = {"tip", "both"}, text[4096];
  PetscInt rigid[3] = {0, 0, 1};
  BlockMesh mesh = {.n_groups = 3,
                    .n_face_sets = 4,
                    .n_points = 2,
                    .group_names = groups,
                    .group_rigid = rigid,
                    .face_set_names = sets,
                    .point_names = points};

  Change(from, to, text);
  PetscCall(Read(text, "", s));
  EnsureMessage("", to);
  PetscErrorCode code = SceneResolve(PETSC_COMM_WORLD, s, &mesh);
  ENSURE(!code == !message[0]);
  return 0;
}

static PetscErrorCode TestResolve(void)
{
  Scene s;

  PetscCall(Resolve("title", "title", &s));
  EnsureMessage("", "good");
  ENSURE(s.n_materials == 3 && !strcmp(s.materials[0].name, "dam") && !strcmp(s.materials[2].name, "rock"));
  ENSURE(s.materials[0].rigid == 0 && s.materials[1].rigid == 1 && s.materials[2].rigid == 1);
  ENSURE(s.materials[0].young == 1e10 && s.materials[1].young == 0 && s.materials[1].poisson == 0);
  PetscCall(SceneDestroy(&s));

  // rigid in the mesh only: no elastic constants needed; overridden: needed
  PetscCall(Resolve("rock: {density: 0, young: 20e9, poisson: 0.25}", "rock: {density: 3}", &s));
  EnsureMessage("", "rigid by mesh");
  PetscCall(SceneDestroy(&s));
  PetscCall(Resolve("  dam: {density: 2400, young: 1.0e10, poisson: 0.2}\n",
                    "  dam: {density: 2400, rigid: true}\n", &s));
  ENSURE(s.materials[0].rigid == 1);
  PetscCall(SceneDestroy(&s));
  return 0;
}

/* ------------------------------------------------------------------------------------------ the docs */

// a page of docs/, empty if it is not there
static char *ReadDocs(const char *page)
{
  enum { MOST = 1 << 17 };
  char path[PETSC_MAX_PATH_LEN];
  snprintf(path, sizeof path, "%s/docs/%s", QUOIN_SOURCE, page);
  FILE *file = fopen(path, "r");
  char *text = calloc(1, MOST);
  ENSURE(file != NULL);
  if (file) ENSURE(fread(text, 1, MOST - 1, file) > 0);
  if (file) fclose(file);
  return text;
}

// every line of -help stands in the table of keys, which has no more rows
static PetscErrorCode TestHelp(void)
{
  char *docs = ReadDocs("generated/keys.md"), line[1024];
  FILE *file = tmpfile(), *before = PETSC_STDOUT;
  int n_help = 0, n_docs = 0;

  PETSC_STDOUT = file;
  PetscCall(SceneHelp(PETSC_COMM_WORLD));
  PETSC_STDOUT = before;
  rewind(file);
  while (fgets(line, sizeof line, file)) {
    if (!strncmp(line, "| `", 3)) n_help++;
    if (!strstr(docs, line)) printf("not in docs/generated/keys.md: %s", line);
    ENSURE(strstr(docs, line));
  }
  for (const char *row = docs; (row = strstr(row, "\n| `")) != NULL; row++) n_docs++;
  ENSURE(rank > 0 || (n_help == n_docs && n_help > 40));
  fclose(file);
  free(docs);
  return 0;
}

static PetscErrorCode TestExample(void)
{
  char *docs = ReadDocs("scene.md"), *start = strstr(docs, "```yaml\n"),
       *end = start ? strstr(start + 8, "```") : NULL;
  Scene s;

  ENSURE(end != NULL);
  if (end) {
    *end = '\0';
    PetscCall(Read(start + 8, "", &s));
    EnsureMessage("", "example of docs/scene.md");
    ENSURE(s.n_stages == 4 && s.stages[3].joints[1].friction[0] == 30);
    PetscCall(SceneDestroy(&s));
  }
  free(docs);
  return 0;
}

int main(int argc, char **argv)
{
  char path[PETSC_MAX_PATH_LEN];

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(PetscPushErrorHandler(Catch, NULL));
  snprintf(folder, sizeof folder, "/tmp/quoin_scene_XXXXXX");
  if (rank == 0) ENSURE(mkdtemp(folder));
  PetscCallMPI(MPI_Bcast(folder, sizeof folder, MPI_CHAR, 0, PETSC_COMM_WORLD));
  RUN_TEST(TestValues);
  RUN_TEST(TestJoints);
  RUN_TEST(TestUnits);
  RUN_TEST(TestCommandLine);
  RUN_TEST(TestUnderscores);
  RUN_TEST(TestEchoIsAScene);
  RUN_TEST(TestEcho);
  RUN_TEST(TestRemovedKeys);
  RUN_TEST(TestModelPath);
  RUN_TEST(TestBadFiles);
  RUN_TEST(TestResolve);
  RUN_TEST(TestHelp);
  RUN_TEST(TestExample);
  WritePath("scene.yaml", path);
  if (rank == 0) unlink(path), rmdir(folder);
  PetscCall(PetscPopErrorHandler());
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* pseudo_static.c: applies an earthquake as a static load: k_h, k_v times the weight of blocks, and the
   inertia of the water at their faces. k_h > 0 acts along +x, as when the ground accelerates along -x. */
#include "loads/loads.h"
#include "water/hydrodynamic.h"
#include "scene/reader.h"

/* Finds the walls of the water. memory: (n_loads,), empty for other loads. */
static PetscErrorCode create(const TermView *v, void **memory)
{
  static PetscInt runs; // once, because advise.c sets up the same mesh many times
  const PetscBool warned = AlreadyWarned(&runs);
  const Scene *scene = v->scene;
  char message[MESSAGE_LENGTH] = "";
  WetWall *walls;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->n_loads, &walls));
  for (PetscInt l = 0; l < scene->n_loads && !message[0]; l++) {
    const Load *load = scene->loads + l;
    if (load->kind != LOAD_PSEUDO_STATIC || !load->target[0]) continue;
    PetscCall(WetWallFind(v->m, load, walls + l));
    WetWallRefuse(scene, load, walls + l, message);
    if (!v->m->rank && !warned && !message[0]) WetWallWarn(load, walls + l);
  }
  *memory = walls;
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  (void)scene;
  PetscFunctionBeginUser;
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water that accelerates with the ground. */
typedef struct {
  const WetWall *wall;
  PetscReal push, thickness; /* [N/m3] density times acceleration, [m] */
} Shaken;

static void press(const PetscReal x[4], const void *context, PetscReal f[4])
{
  const Shaken *water = context;
  HydrodynamicOnFace(x, water->wall, water->push, water->thickness, f);
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f_vertex)
{
  const Load *load = v->scene->loads + row;
  const PetscReal g = v->scene->gravity, a[2] = {load->coefficient[0] * g, load->coefficient[1] * g};
  const Shaken water = {(const WetWall *)v->memory + row, load->density * a[0], v->m->materials.thickness};
  PetscFunctionBeginUser;
  PetscCall(BodyForce(a, load, v->m, f_vertex));
  if (load->target[0]) PressOnFaces(v, load->target, press, &water, f_vertex);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal suction(const TermView *v, PetscInt load)
{
  return SuctionDepth((const WetWall *)v->memory + load, v->scene->loads[load].coefficient[0]);
}

/* Warns where suction exceeds the hydrostatic pressure: there the water would separate from the wall. */
static PetscErrorCode before_summary(const TermView *v, PetscBool report)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->stage->n_loads && report && !v->m->rank; i++) {
    const PetscInt l = v->stage->loads[i];
    const Load *load = v->scene->loads + l;
    if (load->kind != LOAD_PSEUDO_STATIC || !load->target[0]) continue;
    if (suction(v, l) <= 0.) continue;
    Warn("stage %s: loads.%s: down to %.3g m below the level its water pulls at the faces by "
         "more than it presses at rest",
         v->stage->name, load->name, (double)suction(v, l));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void summary(Json *json, const TermView *v)
{
  JsonOpenLater(json, "pseudo_static");
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const PetscInt l = v->stage->loads[i];
    const Load *load = v->scene->loads + l;
    const WetWall *wall = (const WetWall *)v->memory + l;
    if (load->kind != LOAD_PSEUDO_STATIC) continue;
    JsonOpen(json, load->name);
    JsonNumbers(json, {"k_h", load->coefficient[0]}, {"k_v", load->coefficient[1]});
    if (load->target[0]) {
      JsonNumbers(json, {"depth", wall->depth}, {"lean", wall->lean}, {"suction_depth", suction(v, l)});
    }
    JsonClose(json);
  }
  JsonClose(json);
}

/* ---- keys */

/* Checks that keys of water come with faces. Without faces a key may have its default, because
   scene_echo.yaml writes every key. */
PetscErrorCode CompletePseudoStatic(Reader *r, const char *path, Load *load)
{
  static const char *const keys[] = {"level", "rule", "density", "bottom"};
  const PetscBool on_faces = (PetscBool)(load->target[0] != '\0');
  PetscBool given[4];

  PetscFunctionBeginUser;
  for (int k = 3; k >= 0; k--) PetscCall(IsGiven(r, path, keys[k], given + k)); // the level is asked for last
  if (on_faces && !given[0]) COMPLAIN_MISSING(r, "missing [m]: the level of the water at the faces");
  for (int k = 0; k < 4 && !on_faces; k++) {
    const PetscBool same[] = {PETSC_FALSE, (PetscBool)(load->hydro.rule == HYDRO_WESTERGAARD),
                              (PetscBool)(load->density == 1000.), PETSC_FALSE};
    if (!given[k] || same[k]) continue;
    PetscCall(IsGiven(r, path, keys[k], given + k));
    COMPLAIN(r, "there is no water: give loads.%s.faces", load->name);
  }
  PetscCall(IsGiven(r, path, "bottom", given));
  if (on_faces && load->hydro.bottom >= load->level)
    COMPLAIN(r, "%g is not below the level %g [m]", (double)load->hydro.bottom, (double)load->level);
  PetscCall(IsGiven(r, path, "coefficient", given));
  if (r->scene->gravity == 0.) COMPLAIN(r, "it is a fraction of the weight, and gravity is 0 [m/s2]");
  PetscCall(IsGiven(r, path, "groups", given));
  if (!on_faces && load->n_groups == 1 && !strcmp(load->groups[0], "none"))
    COMPLAIN(r, "none, and no faces: it acts on nothing");
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Pseudo_static_term = {.name = "pseudo_static",
                                     .loads = 1u << LOAD_PSEUDO_STATIC,
                                     .presses = PETSC_TRUE,
                                     .create = create,
                                     .destroy = destroy,
                                     .applied = applied,
                                     .before_summary = before_summary,
                                     .summary = summary};

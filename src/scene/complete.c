/* complete.c: completes keys of materials, motions, supports, loads and stages that depend on other keys. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <math.h>
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

static PetscErrorCode complete_mohr_coulomb(Reader *r, const char *path, const Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "dilation", &given));
  if (given && m->dilation > m->friction)
    COMPLAIN(r, "larger than friction, %g degree: such plastic flow would create energy",
             (double)m->friction);
  PetscCall(IsGiven(r, path, "tension", &given));
  const double apex = m->cohesion / tan(m->friction * PETSC_PI / 180.);
  if (given && m->friction > 0. && m->tension > apex * (1. + 1e-12))
    COMPLAIN(r, "beyond the apex of the shear strength, cohesion / tan(friction) = %.6g Pa", apex);
  PetscCall(IsGiven(r, path, "law", &given));
  if (isnan(m->cohesion)) COMPLAIN(r, "mohr_coulomb needs cohesion [Pa] and friction [degree]");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the keys of a material law. Blocks of a law that is not elastic get one integration point, unless
   the scene chooses otherwise: blocks of four points lock. */
static PetscErrorCode complete_law(Reader *r, const char *path, Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "dilation", &given));
  if (m->dilation > 0. && m->law != MATERIAL_MOHR_COULOMB)
    COMPLAIN(r, "it is for a law that yields: law: mohr_coulomb");
  PetscCall(IsGiven(r, path, "fracture_energy", &given));
  if (given && m->law != MATERIAL_DAMAGE) COMPLAIN(r, "it is for a law that cracks: law: damage");
  PetscCall(IsGiven(r, path, "softening", &given));
  if (m->softening == SOFTENING_LINEAR && m->law != MATERIAL_DAMAGE)
    COMPLAIN(r, "it is for a law that cracks: law: damage");
  if (m->law == MATERIAL_ELASTIC) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(IsGiven(r, path, "element", &given));
  if (!given) m->element = ELEMENT_BENDING;
  if (m->law == MATERIAL_MOHR_COULOMB) PetscCall(complete_mohr_coulomb(r, path, m));
  PetscCall(IsGiven(r, path, "law", &given));
  if (m->law == MATERIAL_DAMAGE && !(m->tension > 0. && m->fracture_energy > 0.))
    COMPLAIN(r, "damage needs tension > 0 [Pa] and fracture_energy [N/m]");
  if (r->scene->plane == PLANE_STRESS) COMPLAIN(r, "in plane: stress all blocks must be elastic");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the keys of the stress at rest: the stress of the ground before anything is built. */
static PetscErrorCode complete_ground(Reader *r, const char *path, const Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "surface", &given));
  if (given && isnan(m->k0)) COMPLAIN(r, "it is for ground with k0");
  PetscCall(IsGiven(r, path, "k0", &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  if (isnan(m->surface)) COMPLAIN(r, "it needs surface [m]: the level up to which the ground stands");
  if (!(m->density > 0.)) COMPLAIN(r, "ground without density has no stress at rest");
  if (r->scene->plane == PLANE_STRESS) COMPLAIN(r, "k0 needs plane: strain");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteStrengths(Reader *r, const char *path, Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(complete_ground(r, path, m));
  PetscCall(IsGiven(r, path, "cohesion", &given));
  if (given && isnan(m->friction)) COMPLAIN(r, "the shear strength needs friction [degree] too");
  PetscCall(IsGiven(r, path, "friction", &given));
  if (given && isnan(m->cohesion)) COMPLAIN(r, "the shear strength needs cohesion [Pa] too");
  PetscCall(complete_law(r, path, m));
  PetscCall(IsGiven(r, path, "free_across", &given));
  if (m->free_across && !(m->expansion > 0.)) COMPLAIN(r, "it is for blocks that expand: expansion [1/K]");
  if (m->free_across && r->scene->plane == PLANE_STRESS)
    COMPLAIN(r, "in plane: stress blocks are free across the plane anyway");
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* Completes the keys of an uplift rule: npb and usbr reduce the head at the drain to one third; usace and
   ferc need the efficiency of the drain. */
PetscErrorCode CompleteUplift(Reader *r, const char *path, Load *load)
{
  const PetscBool fixed = (PetscBool)(load->uplift.rule == UPLIFT_NPB || load->uplift.rule == UPLIFT_USBR);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  load->uplift.drain_level = load->level;
  PetscCall(IsGiven(r, path, "gallery", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr know no gallery; usace and ferc do");
  PetscCall(IsGiven(r, path, "efficiency", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr fix it at 2/3; usace and ferc take a value");
  if (fixed) load->uplift.efficiency = 2. / 3.;
  if (load->uplift.rule != UPLIFT_LINEAR && !isnan(load->uplift.drain) && isnan(load->uplift.efficiency))
    COMPLAIN_MISSING(r, "missing [-]: the rules usace and ferc need it");
  PetscCall(IsGiven(r, path, "drain", &given));
  if (given && load->uplift.rule == UPLIFT_LINEAR)
    COMPLAIN(r, "the rule linear knows no drain: choose npb, usbr, usace or ferc");
  PetscCall(IsGiven(r, path, "reaches", &given));
  if (load->uplift.reaches == REACHES_ANY && !load->uplift.cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(IsGiven(r, path, "in_earthquake", &given));
  if (load->uplift.shaken != SHAKEN_RULE && !load->uplift.cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(IsGiven(r, path, "raise", &given));
  if (load->uplift.raise == RAISE_TO_DRAIN && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* Checks that a temperature is given in one of three ways, and that keys of the yearly wave come with its
   amplitude. Without an amplitude a key may have its default, because scene_echo.yaml writes every key. */
PetscErrorCode CompleteTemperature(Reader *r, const char *path, Load *load)
{
  static const char *const ways[] = {"change", "points", "amplitude"};
  static const char *const keys[] = {"faces", "mean", "day", "diffusivity"};
  const HeatKeys *heat = &load->heat;
  const PetscBool same[] = {PETSC_FALSE, (PetscBool)(heat->mean == 0.), (PetscBool)(heat->day == 0.),
                            (PetscBool)(heat->diffusivity == 1.1e-6)};
  PetscBool given = PETSC_FALSE;
  int n = 0;

  PetscFunctionBeginUser;
  for (int k = 2; k >= 0; k--) {
    PetscCall(IsGiven(r, path, ways[k], &given));
    n += given;
  }
  if (!n)
    COMPLAIN_MISSING(r, "a temperature needs change [K], points (a file) or amplitude [K], one of them");
  if (n > 1) COMPLAIN(r, "change, points and amplitude: a temperature has one of them");
  for (int k = 0; k < 4 && n == 1; k++) {
    PetscCall(IsGiven(r, path, keys[k], &given));
    if (isnan(heat->amplitude) && given && !same[k])
      COMPLAIN(r, "there is no yearly wave: give loads.%s.amplitude [K]", load->name);
    if (!k && !isnan(heat->amplitude) && !given)
      COMPLAIN_MISSING(r, "missing: the face set from which the yearly wave comes in");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the lateral pressure coefficient [-] of silt: given, or Rankine's active one from the friction
   [degree]. */
PetscErrorCode CompleteSilt(Reader *r, const char *path, Load *load)
{
  const PetscReal angle = load->rest_angle * PETSC_PI / 180.;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "lateral", &given));
  if (isnan(load->lateral) == isnan(load->rest_angle))
    COMPLAIN_MISSING(r, "silt needs lateral [-] or friction [degree], one of them");
  if (isnan(load->lateral)) load->lateral = (1. - sin(angle)) / (1. + sin(angle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the keys of drains and curtains: boundary conditions of water that flows in joints. */
PetscErrorCode CompleteFlow(Reader *r, const char *path, Load *load)
{
  const FlowKeys *flow = &load->flow;
  const PetscBool line = (PetscBool) !(isnan(flow->from[0]) || isnan(flow->to[0]));
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (load->kind == LOAD_CURTAIN) {
    PetscCall(IsGiven(r, path, "from", &given));
    if (!line) COMPLAIN_MISSING(r, "missing [m]: a curtain needs from and to, the ends of its axis");
    PetscCall(IsGiven(r, path, "factor", &given));
    if (isnan(flow->factor) == isnan(flow->aperture))
      COMPLAIN_MISSING(r, "a curtain needs a factor [-] or an aperture [m], one of them");
  }
  if (load->kind == LOAD_DRAIN) {
    PetscCall(IsGiven(r, path, "distance", &given));
    if ((PetscBool)!isnan(flow->distance) == line || (given && !load->target[0]))
      COMPLAIN_MISSING(r, "a drain needs joint and distance [m], or from and to [m], one of these pairs");
  }
  PetscCall(IsGiven(r, path, "joint", &given));
  if (load->kind == LOAD_DRAIN && given && line)
    COMPLAIN(r, "a drain with from and to meets every joint that it crosses: expected joint and distance [m] "
                "without them");
  PetscCall(IsGiven(r, path, "to", &given));
  if (line && hypot(flow->to[0] - flow->from[0], flow->to[1] - flow->from[1]) == 0.)
    COMPLAIN(r, "from and to are one point");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes alpha [1/s] and beta [s] from the damping ratio z at two circular frequencies w:
   alpha / (2 w) + beta w / 2 = z at both. */
PetscErrorCode CompleteDamping(Reader *r, const char *path, Stage *stage)
{
  const PetscReal *f = stage->damping_frequencies;
  const PetscBool ratio = (PetscBool)!isnan(stage->damping_ratio), frequencies = (PetscBool)!isnan(f[0]);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (int i = 0; i < 2 && ratio; i++) {
    PetscCall(IsGiven(r, path, i ? "beta" : "alpha", &given));
    if (given) COMPLAIN(r, "it follows from damping_ratio: give one of the two");
  }
  PetscCall(IsGiven(r, path, ratio ? "damping_frequencies" : "damping_ratio", &given));
  if (ratio != frequencies)
    COMPLAIN_MISSING(r, "missing: damping_ratio and damping_frequencies belong together");
  if (!ratio || !frequencies) PetscFunctionReturn(PETSC_SUCCESS);
  if (!(f[0] > 0. && f[1] > f[0] && f[1] < PETSC_INFINITY))
    COMPLAIN(r, "%g, %g: expected two frequencies [Hz] > 0, the lower one first", (double)f[0], (double)f[1]);
  const PetscReal w[2] = {2. * PETSC_PI * f[0], 2. * PETSC_PI * f[1]};
  stage->alpha = 2. * stage->damping_ratio * w[0] * w[1] / (w[0] + w[1]);
  stage->beta = 2. * stage->damping_ratio / (w[0] + w[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that a transient stage has water that flows and can be stored. */
PetscErrorCode CompleteTransient(Reader *r, const char *path, const Stage *stage)
{
  PetscBool given = PETSC_FALSE, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const LoadKind kind = stage->loads[i] < 0 ? LOAD_HEAD : r->scene->loads[stage->loads[i]].kind;
    flows = (PetscBool)(flows || kind == LOAD_HEAD || kind == LOAD_INFLOW || kind == LOAD_DRAIN);
  }
  PetscCall(IsGiven(r, path, "loads", &given));
  if (!flows)
    COMPLAIN(r, "a transient stage needs water that flows in joints: a load of type head, inflow or drain");
  PetscCall(IsGiven(r, path, "type", &given));
  if (r->scene->flow.bulk_modulus >= PETSC_INFINITY) // not the inf of C
    COMPLAIN(r, "a transient stage needs water that stores: flow.bulk_modulus is inf [Pa]");
  if (r->scene->flow.coupling == FLOW_ONE_WAY && stage->variable > 0)
    COMPLAIN(r, "flow.coupling one_way keeps the joints as they are, but connectivity is variable");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the earlier stage from which a stage starts, and sets stage->skips. */
PetscErrorCode CompleteFrom(Reader *r, const char *path, Stage *stage)
{
  const Scene *scene = r->scene;
  const PetscInt number = (PetscInt)(stage - scene->stages);
  char known[512] = "none";
  PetscInt base = number - 1;
  size_t used = 0;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!stage->from[0]) PetscFunctionReturn(PETSC_SUCCESS);
  while (base >= 0 && strcmp(scene->stages[base].name, stage->from) != 0) base--;
  for (PetscInt s = 0; s < number && used < sizeof known; s++)
    used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", s ? ", " : "", scene->stages[s].name);
  PetscCall(IsGiven(r, path, "from", &given));
  if (base < 0)
    COMPLAIN_MISSING(r, "no stage named '%s' before it; stages before it: %s", stage->from, known);
  else
    stage->skips = number - 1 - base;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the loads of a stage against its kind. An empty list is right in three cases: the structure
   vibrates, follows its supports, or loses its earlier loads. */
PetscErrorCode CompleteLoads(Reader *r, const char *path, const Stage *stage, PetscBool first)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "loads", &given));
  for (PetscInt i = 0; i < stage->n_loads && stage->kind == STAGE_MODES; i++)
    if (stage->loads[i] >= 0 && r->scene->loads[stage->loads[i]].kind != LOAD_ADDED_MASS)
      COMPLAIN(
          r, "'%s' is not a mass: a stage of modes keeps the loads of the stage before; expected added_mass",
          r->scene->loads[stage->loads[i]].name);
  for (PetscInt i = 0; i < stage->n_loads && StageRelaxes(stage); i++)
    if (stage->loads[i] >= 0 && r->scene->loads[stage->loads[i]].history[0])
      COMPLAIN(r, "'%s' has a history, which is followed in dynamic stages only",
               r->scene->loads[stage->loads[i]].name);
  for (PetscInt i = 0; i < stage->n_loads && StageInTime(stage); i++) {
    const Load *load = stage->loads[i] < 0 ? NULL : r->scene->loads + stage->loads[i];
    if (load && load->kind == LOAD_PSEUDO_STATIC && load->target[0])
      COMPLAIN(
          r, "'%s' has the inertia of water as a static force: expected it without faces in a dynamic stage",
          load->name);
  }
  if (!given || stage->n_loads || !StageRelaxes(stage)) PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->kind == STAGE_STATIC && !first) PetscFunctionReturn(PETSC_SUCCESS);
  COMPLAIN(r, "no loads: only modes, a dynamic stage, or a static one behind another, need none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

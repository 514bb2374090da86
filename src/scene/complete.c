/* complete.c: completes the keys of strengths, motions, supports, uplift, strength reduction and flood,
   which only make sense together. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

// The next complaint is about the key `name`; given: the user gave this key.
static PetscErrorCode is_given(Reader *r, const char *path, const char *name, PetscBool *given)
{
  Entry *entry;

  PetscFunctionBeginUser;
  PetscCall(Ask(r, path, name, &entry));
  *given = (PetscBool)(entry != NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteStrengths(Reader *r, const char *path, Material *m)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "cohesion", &given));
  if (given && isnan(m->friction)) COMPLAIN(r, "the shear strength needs friction [degree] too");
  PetscCall(is_given(r, path, "friction", &given));
  if (given && isnan(m->cohesion)) COMPLAIN(r, "the shear strength needs cohesion [Pa] too");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteMotion(Reader *r, const char *path, const GroundMotion *m)
{
  PetscBool scaled = PETSC_FALSE, given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "scale", &scaled));
  PetscCall(is_given(r, path, "pga", &given));
  if (given && scaled) COMPLAIN(r, "scale and pga exclude each other");
  if (given && m->quantity == MOTION_VELOCITY) COMPLAIN(r, "it is for a record of accelerations");
  PetscCall(is_given(r, path, "baseline", &given));
  if (m->baseline == BASELINE_LINEAR && m->quantity == MOTION_VELOCITY)
    COMPLAIN(r, "linear is for a record of accelerations");
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Has the support follow a motion of the scene in the directions of its record.
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

/* The motion of a support is a list of motions of the scene, or else the path of a file. */
PetscErrorCode CompleteSupport(Reader *r, const char *path, Support *s)
{
  const Scene *scene = r->scene;
  char item[LABEL_LENGTH], known[512] = "none";
  size_t used = 0;
  PetscInt named = 0, others = 0;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "quantity", &given));
  PetscBool with_quantity = given;
  PetscCall(is_given(r, path, "motion", &given));
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
    PetscCall(is_given(r, path, "quantity", &given));
    COMPLAIN(r, "it is for a file: motions.%s.quantity says it",
             s->along[0] ? s->along[0]->entry.name : item);
  }
  if (!named && s->motion[0]) {
    PetscCall(PetscStrncpy(s->own.file, s->motion, sizeof(s->own.file)));
    PetscCall(PetscStrncpy(s->own.entry.name, s->name, NAME_LENGTH));
    s->own.scale = 1.;
    s->along[0] = s->along[1] = &s->own;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* npb and usbr reduce the head at the drain to one third; usace and ferc need the efficiency of the drain. */
PetscErrorCode CompleteUplift(Reader *r, const char *path, Load *load)
{
  const PetscBool fixed = (PetscBool)(load->uplift.rule == UPLIFT_NPB || load->uplift.rule == UPLIFT_USBR);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  load->uplift.drain_level = load->level;
  PetscCall(is_given(r, path, "gallery", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr know no gallery; usace and ferc do");
  PetscCall(is_given(r, path, "efficiency", &given));
  if (given && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr fix it at 2/3; usace and ferc take a value");
  if (fixed) load->uplift.efficiency = 2. / 3.;
  if (load->uplift.rule != UPLIFT_LINEAR && !isnan(load->uplift.drain) && isnan(load->uplift.efficiency))
    COMPLAIN_MISSING(r, "missing [-]: the rules usace and ferc need it");
  PetscCall(is_given(r, path, "drain", &given));
  if (given && load->uplift.rule == UPLIFT_LINEAR)
    COMPLAIN(r, "the rule linear knows no drain: choose npb, usbr, usace or ferc");
  PetscCall(is_given(r, path, "reaches", &given));
  if (load->uplift.reaches == REACHES_ANY && !load->uplift.cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(is_given(r, path, "raise", &given));
  if (load->uplift.raise == RAISE_TO_DRAIN && isnan(load->uplift.drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions of water that flows in joints. */
PetscErrorCode CompleteFlow(Reader *r, const char *path, Load *load)
{
  const FlowKeys *flow = &load->flow;
  const PetscBool line = (PetscBool) !(isnan(flow->from[0]) || isnan(flow->to[0]));
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (load->kind == LOAD_CURTAIN) {
    PetscCall(is_given(r, path, "from", &given));
    if (!line) COMPLAIN_MISSING(r, "missing [m]: a curtain needs from and to, the ends of its axis");
    PetscCall(is_given(r, path, "factor", &given));
    if (isnan(flow->factor) == isnan(flow->aperture))
      COMPLAIN_MISSING(r, "a curtain needs a factor [-] or an aperture [m], one of them");
  }
  if (load->kind == LOAD_DRAIN) {
    PetscCall(is_given(r, path, "distance", &given));
    if ((PetscBool)!isnan(flow->distance) == line || (given && !load->target[0]))
      COMPLAIN_MISSING(r, "a drain needs joint and distance [m], or from and to [m], one of these pairs");
  }
  PetscCall(is_given(r, path, "joint", &given));
  if (load->kind == LOAD_DRAIN && given && line)
    COMPLAIN(r, "a drain with from and to meets every joint that it crosses: expected joint and distance [m] "
                "without them");
  PetscCall(is_given(r, path, "to", &given));
  if (line && hypot(flow->to[0] - flow->from[0], flow->to[1] - flow->from[1]) == 0.)
    COMPLAIN(r, "from and to are one point");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A transient stage needs water that flows, and that can be stored. */
PetscErrorCode CompleteTransient(Reader *r, const char *path, const Stage *stage)
{
  PetscBool given = PETSC_FALSE, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const LoadKind kind = stage->loads[i] < 0 ? LOAD_HEAD : r->scene->loads[stage->loads[i]].kind;
    flows = (PetscBool)(flows || kind == LOAD_HEAD || kind == LOAD_INFLOW || kind == LOAD_DRAIN);
  }
  PetscCall(is_given(r, path, "loads", &given));
  if (!flows)
    COMPLAIN(r, "a transient stage needs water that flows in joints: a load of type head, inflow or drain");
  PetscCall(is_given(r, path, "type", &given));
  if (r->scene->flow.bulk_modulus >= PETSC_INFINITY) // not the inf of C
    COMPLAIN(r, "a transient stage needs water that stores: flow.bulk_modulus is inf [Pa]");
  if (r->scene->flow.coupling == FLOW_ONE_WAY && stage->variable > 0)
    COMPLAIN(r, "flow.coupling one_way keeps the joints as they are, but connectivity is variable");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water that keeps its volume needs a dynamic stage with water in joints, and water that can be pressed
   together. */
PetscErrorCode CompleteDynamicWater(Reader *r)
{
  PetscBool given = PETSC_FALSE, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (r->scene->flow.dynamic != FLOW_UNDRAINED) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt s = 0; s < r->scene->n_stages; s++)
    for (PetscInt i = 0; i < r->scene->stages[s].n_loads; i++) {
      const Stage *stage = r->scene->stages + s;
      const LoadKind kind = stage->loads[i] < 0 ? LOAD_HEAD : r->scene->loads[stage->loads[i]].kind;
      flows = (PetscBool)(flows || (stage->kind == STAGE_DYNAMIC &&
                                    (kind == LOAD_HEAD || kind == LOAD_INFLOW || kind == LOAD_DRAIN)));
    }
  PetscCall(is_given(r, "flow", "dynamic", &given));
  if (!flows)
    COMPLAIN(r,
             "undrained is for water in joints: no dynamic stage has a load of type head, inflow or drain");
  else if (r->scene->flow.bulk_modulus >= PETSC_INFINITY)
    COMPLAIN(r, "undrained needs water that can be pressed together: flow.bulk_modulus is inf [Pa]");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An empty list of loads makes sense in three cases: a structure swings, follows its supports, or is relieved
   of the loads before. */
PetscErrorCode CompleteLoads(Reader *r, const char *path, const Stage *stage, PetscBool first)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "loads", &given));
  if (!given || stage->n_loads || stage->kind == STAGE_DYNAMIC) PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->kind == STAGE_STATIC && !first) PetscFunctionReturn(PETSC_SUCCESS);
  COMPLAIN(r, "no loads: only a dynamic stage, or a static one behind another, needs none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

// The joints that a reduction names must exist and have a strength.
static void check_reduced(Reader *r, const Stage *stage)
{
  for (PetscInt i = 0; i < stage->n_reduce; i++) {
    PetscInt j = 0;
    while (j < r->scene->n_joints && strcmp(r->scene->joints[j].name, stage->reduce[i])) j++;
    if (j == r->scene->n_joints || !stage->joints[j].defined)
      COMPLAIN(r, "no joint named '%s'", stage->reduce[i]);
    else if (stage->joints[j].law == LAW_ELASTIC)
      COMPLAIN(r, "the joint '%s' is elastic in this stage: it has no strength", stage->reduce[i]);
  }
}

PetscErrorCode CompleteReduction(Reader *r, const char *path, Stage *stage)
{
  const PetscBool friction = (PetscBool)(stage->what == REDUCE_FRICTION);
  const PetscReal nominal = ReducedFriction(r->scene, stage, NULL), most = friction ? nominal : 1;
  PetscBool given = PETSC_FALSE, step = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (isnan(stage->limit)) stage->limit = 0;
  PetscCall(is_given(r, path, "reduce", &given));
  check_reduced(r, stage);
  if (isnan(nominal) && !stage->n_reduce)
    COMPLAIN_MISSING(r, "all joints are elastic in this stage: there is no strength");
  if (isnan(nominal)) PetscFunctionReturn(PETSC_SUCCESS);
  if (friction && nominal == 0) {
    COMPLAIN(r, "no joint reduced has friction in this stage (friction: 0 [degree]): choose what: strengths");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(is_given(r, path, "factor", &given));
  if (given && friction) COMPLAIN(r, "friction goes by degrees: give step, or choose what: strengths");
  PetscCall(is_given(r, path, "step", &step));
  if (step && !friction) COMPLAIN(r, "strengths go by a factor, such as factor: 0.85");
  PetscCall(is_given(r, path, "start", &given));
  if (given && stage->start > most)
    COMPLAIN(r, "%.6g is out of range: the joints have %.6g%s", (double)stage->start, (double)most,
             friction ? " [degree]" : "");
  PetscCall(is_given(r, path, "limit", &given));
  if (stage->limit < 0 || stage->limit >= (isnan(stage->start) ? most : stage->start))
    COMPLAIN(r, "%.6g is out of range: must be >= 0 and less than start", (double)stage->limit);
  PetscCall(is_given(r, path, "bracket", &given));
  if (stage->bracket <= 0 && isnan(stage->step) && isnan(stage->factor))
    COMPLAIN_MISSING(r, "missing: give the width of the bracket, or a %s, or both",
                     friction ? "step" : "factor");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a flood raises */

static PetscBool one_level(PetscReal a, PetscReal b)
{
  return (PetscBool)(fabs(a - b) <= 1e-9 * PetscMax(1., fabs(a)));
}

/* Row of the highest load of this kind in the stage, -1: the stage has none. others: how many more stand as
   high. */
static PetscInt highest(const Scene *scene, const Stage *stage, LoadKind kind, PetscInt *others)
{
  PetscInt best = -1;

  *others = 0;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const PetscInt l = stage->loads[i];
    if (l < 0 || scene->loads[l].kind != kind) continue;
    const PetscReal above = best < 0 ? 1. : scene->loads[l].level - scene->loads[best].level;
    if (best >= 0 && one_level(scene->loads[l].level, scene->loads[best].level))
      ++*others;
    else if (above > 0.)
      best = l, *others = 0;
  }
  return best;
}

static PetscBool acts(const Stage *stage, PetscInt load)
{
  for (PetscInt i = 0; i < stage->n_loads; i++)
    if (stage->loads[i] == load) return PETSC_TRUE;
  return PETSC_FALSE;
}

// Chooses the waters that a flood raises by itself: those that the stage names, else the highest reservoir,
// else the highest uplifts, else the highest heads.
static PetscErrorCode choose_rising(Reader *r, const char *path, const Stage *stage)
{
  const Load *loads = r->scene->loads;
  PetscInt others, top = highest(r->scene, stage, LOAD_RESERVOIR, &others);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "rises", &given));
  for (PetscInt i = 0; i < stage->n_rises; i++) {
    const PetscInt l = stage->rises[i];
    if (l < 0) continue; // a complaint has said so
    const LoadKind kind = loads[l].kind;
    if (!acts(stage, l) || (kind != LOAD_RESERVOIR && kind != LOAD_UPLIFT && kind != LOAD_HEAD))
      COMPLAIN(r, "'%s' is no reservoir, uplift or head of this stage", loads[l].name);
    stage->level_rises[l] = true;
  }
  if (stage->n_rises) PetscFunctionReturn(PETSC_SUCCESS);
  if (top >= 0 && others)
    COMPLAIN_MISSING(r, "%d reservoirs stand at the highest level, %g m: name those that rise",
                     (int)others + 1, (double)loads[top].level);
  if (top >= 0) stage->level_rises[top] = true;
  if (top >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  top = highest(r->scene, stage, LOAD_UPLIFT, &others);
  if (top < 0) top = highest(r->scene, stage, LOAD_HEAD, &others);
  for (PetscInt l = 0; l < r->scene->n_loads && top >= 0; l++)
    stage->level_rises[l] = acts(stage, l) && loads[l].kind == loads[top].kind &&
                            one_level(loads[l].level, loads[top].level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the reservoirs of the stage that have the level and the density of an uplift: so many rise, so many
   stay. */
static void count_owners(const Scene *scene, const Stage *stage, const Load *uplift, PetscReal level,
                         PetscInt n[2])
{
  n[0] = n[1] = 0;
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    const Load *load = scene->loads + l;
    if (load->kind != LOAD_RESERVOIR || !acts(stage, l) || !one_level(load->level, level)) continue;
    if (uplift->kind == LOAD_HEAD || one_level(load->density, uplift->density))
      n[stage->level_rises[l] ? 0 : 1]++;
  }
}

// A head that no reservoir has stays, as that of the tailwater may; one of them has to rise.
static void check_heads(Reader *r, const Stage *stage)
{
  PetscInt head = -1;

  for (PetscInt l = 0; l < r->scene->n_loads; l++) {
    if (r->scene->loads[l].kind != LOAD_HEAD || !acts(stage, l)) continue;
    if (stage->level_rises[l]) return;
    head = l;
  }
  if (head >= 0)
    COMPLAIN_MISSING(r,
                     "water flows in joints (loads.%s), but no head has the level of a reservoir that rises: "
                     "name all that rise",
                     r->scene->loads[head].name);
}

// An uplift belongs to the reservoirs that have its level, at the heel and at the toe, and its density. A
// head belongs to those that have its level.
static PetscErrorCode follow_rising(Reader *r, const char *path, const Stage *stage)
{
  PetscInt n[2], others;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "rises", &given));
  for (PetscInt l = 0; l < r->scene->n_loads; l++) {
    const Load *load = r->scene->loads + l;
    if ((load->kind != LOAD_UPLIFT && load->kind != LOAD_HEAD) || !acts(stage, l)) continue;
    if (load->kind == LOAD_UPLIFT && !isnan(load->uplift.tailwater)) {
      count_owners(r->scene, stage, load, load->uplift.tailwater, n);
      if (n[0] && n[1])
        COMPLAIN_MISSING(r,
                         "the tailwater %g m of loads.%s is the level of a reservoir that rises and of one "
                         "that stays: expected another level",
                         (double)load->uplift.tailwater, load->name);
      stage->tail_rises[l] = n[0] > 0;
    }
    if (stage->level_rises[l]) continue;
    count_owners(r->scene, stage, load, load->level, n);
    if (n[0] && n[1])
      COMPLAIN_MISSING(
          r, "loads.%s has the level %g m of a reservoir that rises and of one that stays: name it too",
          load->name, (double)load->level);
    else if (load->kind == LOAD_UPLIFT && !n[0] && !n[1] && !given &&
             highest(r->scene, stage, LOAD_RESERVOIR, &others) >= 0)
      COMPLAIN_MISSING(
          r, "loads.%s has the level %g m, which no reservoir of this stage has: name all that rise",
          load->name, (double)load->level);
    stage->level_rises[l] = n[0] > 0;
  }
  check_heads(r, stage);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CompleteFlood(Reader *r, const char *path, Stage *stage)
{
  PetscReal level = -PETSC_INFINITY;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(r->scene->n_loads, &stage->level_rises, r->scene->n_loads, &stage->tail_rises));
  PetscCall(choose_rising(r, path, stage));
  for (PetscInt l = 0; l < r->scene->n_loads; l++)
    if (stage->level_rises[l]) level = PetscMax(level, r->scene->loads[l].level);
  PetscCall(follow_rising(r, path, stage));
  PetscCall(is_given(r, path, "loads", &given));
  if (level == -PETSC_INFINITY) COMPLAIN_MISSING(r, "a flood needs a load of type reservoir, uplift or head");
  stage->start = level;
  PetscCall(is_given(r, path, "limit", &given));
  if (!given)
    COMPLAIN_MISSING(r, "missing [m]: the highest level");
  else if (stage->limit <= level)
    COMPLAIN(r, "%g is not above the level %g of the loads [m]", (double)stage->limit, (double)level);
  PetscCall(is_given(r, path, "bracket", &given));
  if (stage->bracket <= 0 && isnan(stage->step))
    COMPLAIN_MISSING(r, "missing [m]: give the width of the bracket, or a step, or both");
  PetscFunctionReturn(PETSC_SUCCESS);
}

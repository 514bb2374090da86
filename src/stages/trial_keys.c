/* trial_keys.c: completes the keys of stages that try values: strength reduction, flood, load factor and
   anchor force. */
#include "stages/stages.h"
#include "scene/reader.h"
#include <math.h>
#include <string.h>

/* Checks that the joints of a reduction exist and have a strength. */
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
  PetscCall(IsGiven(r, path, "reduce", &given));
  check_reduced(r, stage);
  if (isnan(nominal) && !stage->n_reduce)
    COMPLAIN_MISSING(r, "all joints are elastic in this stage: there is no strength");
  if (isnan(nominal)) PetscFunctionReturn(PETSC_SUCCESS);
  if (friction && nominal == 0) {
    COMPLAIN(r, "no joint reduced has friction in this stage (friction: 0 [degree]): choose what: strengths");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(IsGiven(r, path, "factor", &given));
  if (given && friction) COMPLAIN(r, "friction goes by degrees: give step, or choose what: strengths");
  PetscCall(IsGiven(r, path, "step", &step));
  if (step && !friction) COMPLAIN(r, "strengths go by a factor, such as factor: 0.85");
  PetscCall(IsGiven(r, path, "start", &given));
  if (given && stage->start > most)
    COMPLAIN(r, "%.6g is out of range: the joints have %.6g%s", (double)stage->start, (double)most,
             friction ? " [degree]" : "");
  PetscCall(IsGiven(r, path, "limit", &given));
  if (stage->limit < 0 || stage->limit >= (isnan(stage->start) ? most : stage->start))
    COMPLAIN(r, "%.6g is out of range: must be >= 0 and less than start", (double)stage->limit);
  PetscCall(IsGiven(r, path, "bracket", &given));
  if (stage->bracket <= 0 && isnan(stage->step) && isnan(stage->factor))
    COMPLAIN_MISSING(r, "missing: give the width of the bracket, or a %s, or both",
                     friction ? "step" : "factor");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- flood */

static PetscBool one_level(PetscReal a, PetscReal b)
{
  return (PetscBool)(fabs(a - b) <= 1e-9 * PetscMax(1., fabs(a)));
}

/* Returns the row of the highest load of this kind in the stage, -1: none. LOAD_RESERVOIR stands for all
   waters before the dam. others: number of other loads as high. */
static PetscInt highest(const Scene *scene, const Stage *stage, LoadKind kind, PetscInt *others)
{
  PetscInt best = -1;

  *others = 0;
  for (PetscInt i = 0; i < stage->n_loads; i++) {
    const PetscInt l = stage->loads[i];
    const LoadKind its = l < 0 ? kind : scene->loads[l].kind;
    if (l < 0 || (its != kind && !(kind == LOAD_RESERVOIR && LoadIsReservoir(its)))) continue;
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

/* Chooses the waters that a flood raises: those that the stage names, otherwise the highest reservoir,
   otherwise the highest uplifts, otherwise the highest heads. */
static PetscErrorCode choose_rising(Reader *r, const char *path, const Stage *stage)
{
  const Load *loads = r->scene->loads;
  PetscInt others, top = highest(r->scene, stage, LOAD_RESERVOIR, &others);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "rises", &given));
  for (PetscInt i = 0; i < stage->n_rises; i++) {
    const PetscInt l = stage->rises[i];
    if (l < 0) continue; // a complaint has said so
    const LoadKind kind = loads[l].kind;
    if (kind == LOAD_WAVE)
      COMPLAIN(r, "'%s' is a wave: it rises with the water that has its level", loads[l].name);
    if (!acts(stage, l) || !LoadHasSurface(kind))
      COMPLAIN(r, "'%s' is no reservoir, overflow, tailwater, uplift or head of this stage", loads[l].name);
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

/* Counts the reservoirs and tailwaters of the stage that an uplift, a wave or a head belongs to; n[0]:
   they rise, n[1]: they stay. Such a water has the level [m] and, except for a head, the same density. If
   waters act on the faces of a wave, the wave belongs to these alone. */
static void count_owners(const Scene *scene, const Stage *stage, const Load *uplift, PetscReal level,
                         PetscInt n[2])
{
  PetscInt at_faces[2] = {0, 0};

  n[0] = n[1] = 0;
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    const Load *load = scene->loads + l;
    if (!LoadIsReservoir(load->kind) && load->kind != LOAD_TAILWATER) continue;
    if (!acts(stage, l) || !one_level(load->level, level)) continue;
    if (uplift->kind == LOAD_HEAD || one_level(load->density, uplift->density))
      n[stage->level_rises[l] ? 0 : 1]++,
          at_faces[stage->level_rises[l] ? 0 : 1] += !strcmp(load->target, uplift->target);
  }
  if (uplift->kind == LOAD_WAVE && at_faces[0] + at_faces[1] > 0) n[0] = at_faces[0], n[1] = at_faces[1];
}

/* Checks that one head rises, if there are heads. A head stays if no reservoir has its level, as at the
   tailwater. */
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

/* Refuses a velocity head of a load that rises, because a velocity head belongs to one level. */
static void check_overflow(Reader *r, const Stage *stage)
{
  for (PetscInt l = 0; l < r->scene->n_loads; l++) {
    const Load *load = r->scene->loads + l;
    if (load->kind == LOAD_OVERFLOW && stage->level_rises[l] && load->surface.velocity_head > 0.)
      COMPLAIN(r, "loads.%s rises, but its velocity_head is that of one level: leave it out", load->name);
  }
}

/* Makes uplifts, waves and heads rise with the waters that they belong to (count_owners); an uplift at its
   heel and at its toe. */
static PetscErrorCode follow_rising(Reader *r, const char *path, const Stage *stage)
{
  PetscInt n[2], others;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "rises", &given));
  for (PetscInt l = 0; l < r->scene->n_loads; l++) {
    const Load *load = r->scene->loads + l;
    const PetscBool wave = (PetscBool)(load->kind == LOAD_WAVE);
    if ((load->kind != LOAD_UPLIFT && load->kind != LOAD_HEAD && !wave) || !acts(stage, l)) continue;
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
    else if (wave && !n[0] && !n[1])
      COMPLAIN_MISSING(r, "loads.%s is a wave at the level %g m, which no water of this stage has",
                       load->name, (double)load->level);
    else if (load->kind == LOAD_UPLIFT && !n[0] && !n[1] && !given &&
             highest(r->scene, stage, LOAD_RESERVOIR, &others) >= 0)
      COMPLAIN_MISSING(
          r, "loads.%s has the level %g m, which no reservoir of this stage has: name all that rise",
          load->name, (double)load->level);
    stage->level_rises[l] = n[0] > 0;
  }
  check_heads(r, stage);
  check_overflow(r, stage);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that a bracket or a step is given: the value rises by steps, or bisection finds the limit. */
static PetscErrorCode check_width(Reader *r, const char *path, const Stage *stage, const char *unit)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "bracket", &given));
  if (stage->bracket <= 0 && isnan(stage->step))
    COMPLAIN_MISSING(r, "missing%s: give the width of the bracket, or a step, or both", unit);
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
  PetscCall(IsGiven(r, path, "loads", &given));
  if (level == -PETSC_INFINITY)
    COMPLAIN_MISSING(r, "a flood needs a load of type reservoir, overflow, uplift or head");
  stage->start = level;
  PetscCall(IsGiven(r, path, "limit", &given));
  if (!given)
    COMPLAIN_MISSING(r, "missing [m]: the highest level");
  else if (stage->limit <= level)
    COMPLAIN(r, "%g is not above the level %g of the loads [m]", (double)stage->limit, (double)level);
  PetscCall(check_width(r, path, stage, " [m]"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- load factor */

static PetscBool is_zero(const PetscReal xy[2])
{
  return (PetscBool)(xy[0] == 0. && xy[1] == 0.);
}

/* Checks that a raised load acts in the stage, has a force, and leaves the blocks their weight. */
static void check_raised(Reader *r, const Stage *stage, const Load *load)
{
  if (!acts(stage, (PetscInt)(load - r->scene->loads)))
    COMPLAIN(r, "'%s' is no load of this stage", load->name);
  else if (load->kind == LOAD_HEAD || load->kind == LOAD_DRAIN || load->kind == LOAD_CURTAIN ||
           load->kind == LOAD_INFLOW)
    COMPLAIN(r, "'%s' is a condition of water that flows, not a force: a flood raises its level", load->name);
  else if (load->kind == LOAD_ADDED_MASS)
    COMPLAIN(r, "'%s' is a mass of water, not a force", load->name);
  else if ((load->kind == LOAD_PSEUDO_STATIC && is_zero(load->coefficient)) ||
           ((load->kind == LOAD_TRACTION || load->kind == LOAD_PRESSURE || load->kind == LOAD_POINT_FORCE ||
             load->kind == LOAD_CREST_LOAD) &&
            is_zero(load->traction)))
    COMPLAIN(r, "'%s' is zero: no factor raises it", load->name);
  else if (load->kind == LOAD_SELF_WEIGHT && stage->start == 0.)
    COMPLAIN(r, "'%s' is a self_weight, which start: 0 would remove: expected a start > 0", load->name);
}

PetscErrorCode CompleteLoadFactor(Reader *r, const char *path, Stage *stage)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(IsGiven(r, path, "raises", &given));
  if (given && !stage->n_rises) COMPLAIN(r, "the list is empty");
  for (PetscInt i = 0; i < stage->n_rises; i++)
    if (stage->rises[i] >= 0) check_raised(r, stage, r->scene->loads + stage->rises[i]);
  PetscCall(IsGiven(r, path, "limit", &given));
  if (!given)
    COMPLAIN_MISSING(r, "missing [-]: the largest factor");
  else if (stage->limit <= stage->start)
    COMPLAIN(r, "%g is not above start, %g", (double)stage->limit, (double)stage->start);
  PetscCall(check_width(r, path, stage, ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- anchor force */

PetscErrorCode CompleteAnchorForce(Reader *r, const char *path, Stage *stage)
{
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (isnan(stage->limit)) stage->limit = 0.;
  stage->pull = stage->start;
  PetscCall(IsGiven(r, path, "anchors", &given));
  if (given && !stage->n_anchors) COMPLAIN(r, "the list is empty");
  for (PetscInt i = 0; i < stage->n_anchors; i++) {
    const Anchor *a = AnchorNamed(r->scene, stage->anchors[i]);
    const PetscReal pull = a && a->n_forces ? stage->start * AnchorPrestress(r->scene, stage, a) : 0.;
    if (!a)
      COMPLAIN(r, "no anchor named '%s'", stage->anchors[i]);
    else if (!a->n_forces)
      COMPLAIN(r, "'%s' is passive: expected an anchor with prestress", stage->anchors[i]);
    else if (pull >= AnchorMostPull(a))
      COMPLAIN(r, "'%s' begins with %g [N], not below the %g N at which it yields, breaks or slips",
               stage->anchors[i], (double)pull, (double)AnchorMostPull(a));
  }
  PetscCall(IsGiven(r, path, "reduce", &given));
  check_reduced(r, stage);
  PetscCall(IsGiven(r, path, "limit", &given));
  if (stage->limit < 0. || stage->limit >= stage->start)
    COMPLAIN(r, "%g is out of range: must be >= 0 and less than start", (double)stage->limit);
  PetscCall(check_width(r, path, stage, " [-], over prestress"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* scene_safety.c: keys of strengths, uplift, strength reduction and flood that only make sense together. */
#include "stages.h"
#include "scene_reader.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

// makes `name` the key that the next complaint is about; true: the user gave it
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

/* npb and usbr reduce the head at the drain to one third; usace and ferc ask for the efficiency. */
PetscErrorCode CompleteUplift(Reader *r, const char *path, Load *load)
{
  const PetscBool fixed = (PetscBool)(load->rule == UPLIFT_NPB || load->rule == UPLIFT_USBR);
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  load->drain_level = load->level;
  PetscCall(is_given(r, path, "gallery", &given));
  if (given && isnan(load->drain)) COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr know no gallery; usace and ferc do");
  PetscCall(is_given(r, path, "efficiency", &given));
  if (given && isnan(load->drain)) COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  if (given && fixed) COMPLAIN(r, "the rules npb and usbr fix it at 2/3; usace and ferc take a value");
  if (fixed) load->efficiency = 2. / 3.;
  if (load->rule != UPLIFT_LINEAR && !isnan(load->drain) && isnan(load->efficiency))
    COMPLAIN_MISSING(r, "missing [-]: the rules usace and ferc need it");
  PetscCall(is_given(r, path, "drain", &given));
  if (given && load->rule == UPLIFT_LINEAR)
    COMPLAIN(r, "the rule linear knows no drain: choose npb, usbr, usace or ferc");
  PetscCall(is_given(r, path, "reaches", &given));
  if (given && !load->cracked) COMPLAIN(r, "it is for cracked: true");
  PetscCall(is_given(r, path, "raise", &given));
  if (load->raise == RAISE_TO_DRAIN && isnan(load->drain))
    COMPLAIN(r, "there is no drain: give loads.%s.drain [m]", load->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without loads a structure can swing, follow its supports, or be relieved of what acted before. */
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

// the joints named exist and have a strength
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

PetscErrorCode CompleteFlood(Reader *r, const char *path, Stage *stage)
{
  PetscReal level = -PETSC_INFINITY;
  PetscBool given = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(is_given(r, path, "loads", &given));
  for (PetscInt l = 0; l < stage->n_loads; l++) {
    const Load *load = stage->loads[l] < 0 ? NULL : &r->scene->loads[stage->loads[l]];
    if (load && (load->kind == LOAD_RESERVOIR || load->kind == LOAD_UPLIFT))
      level = PetscMax(level, load->level);
  }
  if (level == -PETSC_INFINITY) COMPLAIN_MISSING(r, "a flood needs a load of type reservoir or uplift");
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

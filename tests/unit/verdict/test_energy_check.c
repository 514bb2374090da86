/* The energy guard leaves kinetic energy alone that loads and stored energy account for. More than that makes
   the stage start again, once; a collapse after a second time becomes a divergence. The scene is a block of
   2 m2 under its weight on a joint with friction. */
#include "scene_fixture.h"

static Sketch sketch;
static const double WEIGHT = 2 * 1000 * 9.81; /* [N] */

/* A block of 2 x 1 m on the ground; model: of the joint; anchors: a section of the scene. */
static PetscErrorCode OpenWith(const char *model, const char *anchors, Fixture *f, StageResult *result,
                               Problem *p)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  const int ground = SketchGroup(&sketch, "ground", 1), block = SketchGroup(&sketch, "block", 1);
  SketchBox(&sketch, ground, -1, -1, 4, 1);
  SketchBox(&sketch, block, 0, 0, 2, 1);
  SketchBox(&sketch, ground, 10, -1, 4, 1);
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "materials: {ground: {density: 0}, block: {density: 1000}}\n"
                        "joints: {default: {k_n: 1e6, k_s: 1e6, friction: 30, stress_model: %s}}\n"
                        "supports: {ground: {fix: xy}}\nloads: {weight: {type: self_weight}}\n"
                        "stages: [all: {loads: [weight], ramp: 0}, then: {loads: [weight], ramp: 0}]\n%s",
                        model, anchors));
  PetscCall(StageStart(f, 0));
  PetscCall(PetscMemzero(result, sizeof *result));
  *p = (Problem){.m = f->model,
                 .contacts = f->contacts,
                 .state = f->state,
                 .relax = f->relax,
                 .scene = f->scene,
                 .stage = f->scene->stages,
                 .result = result};
  ContactsCommit(f->contacts);
  PetscCall(Forces(f->scene, f->model, p->stage->joints, f->contacts, f->state, NULL));
  f->contacts->pull = PULL_CLOSE;
  f->relax->account.made_energy = 0;
  PetscCall(EnergyCheckStart(p));
  result->finite = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Open(const char *model, Fixture *f, StageResult *result, Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(OpenWith(model, "", f, result, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The block `down` below where the account was opened, with the kinetic energy `kinetic`. */
static PetscErrorCode Check(Fixture *f, const Problem *p, double down, double kinetic, PetscBool *restarts)
{
  const PetscInt y = DofOf(f->model, 4) + 1;
  PetscFunctionBeginUser;
  f->state->u[y] = p->relax->account.u[y] - down;
  p->result->kinetic = kinetic;
  PetscCall(EnergyCheck(p, restarts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Twice the work of the weight is allowed, and what was moving when the account was opened. */
static PetscErrorCode WhatLoadsDidIsAllowed(void)
{
  Fixture f;
  StageResult result;
  Problem p;
  PetscBool restarts;
  PetscFunctionBeginUser;
  PetscCall(Open("tptm", &f, &result, &p));
  PetscCall(Check(&f, &p, 0.01, 1.99 * 0.01 * WEIGHT, &restarts));
  ENSURE(!restarts && f.relax->account.made_energy == 0);
  ENSURE_NEAR(f.relax->account.most, 1.99 * 0.01 * WEIGHT, 1e-9);
  PetscCall(Check(&f, &p, 0.01, 2.01 * 0.01 * WEIGHT, &restarts)); // has not doubled: nothing is asked
  ENSURE(!restarts);
  result.kinetic = 50.;
  PetscCall(EnergyCheckStart(&p));
  PetscCall(Check(&f, &p, 0.01, 1.99 * (0.01 * WEIGHT + 50.), &restarts));
  ENSURE(!restarts);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At rest, where the account was opened, with half the step, beta 0.5 and a tenth of pull. */
static PetscErrorCode MoreRestartsOnce(void)
{
  Fixture f;
  StageResult result;
  Problem p;
  PetscBool restarts;
  PetscFunctionBeginUser;
  PetscCall(Open("tptm", &f, &result, &p));
  const PetscInt y = DofOf(f.model, 4) + 1;
  const PetscReal mass = f.state->m[y];
  f.state->v[y] = 3.;
  PetscCall(Check(&f, &p, 0.01, 2.01 * 0.01 * WEIGHT, &restarts));
  ENSURE(restarts && f.relax->account.made_energy == 1);
  ENSURE(f.state->u[y] == 0. && f.state->v[y] == 0. && result.kinetic == 0. && f.state->applied.ramp == 0.);
  ENSURE_NEAR(f.contacts->pull, 0.1 * PULL_CLOSE, 1e-15);
  ENSURE_NEAR(f.state->beta, 0.5, 1e-15);
  ENSURE(f.state->m[y] > 3.9 * mass); // (33): half the step
  PetscCall(LoadsTarget(f.scene, f.model, p.stage, f.state));
  LoadsApply(f.model, f.state, 1.);
  PetscCall(Check(&f, &p, -0.01, 1.,
                  &restarts)); // against the weight: not a joule; the second time is only counted
  ENSURE(!restarts && f.relax->account.made_energy == 2);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What has made energy twice has not collapsed, but where the stress model makes it itself. */
static PetscErrorCode WhatMakesEnergyIsNoCollapse(void)
{
  static const struct {
    const char *model;
    PetscInt times;
    Verdict verdict;
  } table[] = {{"tptm", 2, VERDICT_DIVERGED},
               {"pt", 2, VERDICT_DIVERGED},
               {"tptm", 1, VERDICT_COLLAPSED},
               {"t2pt", 2, VERDICT_COLLAPSED}};
  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    Fixture f;
    StageResult result;
    Problem p;
    PetscCall(Open(table[i].model, &f, &result, &p));
    result.verdict = VERDICT_COLLAPSED, f.relax->account.made_energy = table[i].times;
    PetscCall(EnergyCheckVerdict(&p));
    ENSURE(result.verdict == table[i].verdict);
    ENSURE((strstr(result.evidence, "make energy") != NULL) == (table[i].verdict == VERDICT_DIVERGED));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nothing falls upwards: with the weight a block can collapse, against it none can, whatever the stress
   model. */
static PetscErrorCode AgainstTheLoadsIsNoCollapse(void)
{
  static const char *models[] = {"t2pt", "tptm"};
  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    const double down = i % 2 ? -0.01 : 0.01;
    Fixture f;
    StageResult result;
    Problem p;
    PetscCall(Open(models[i / 2], &f, &result, &p));
    f.state->u[DofOf(f.model, 4) + 1] -= down;
    result.verdict = VERDICT_COLLAPSED;
    PetscCall(EnergyCheckVerdict(&p));
    ENSURE(result.verdict == (i < 3 ? VERDICT_COLLAPSED : VERDICT_DIVERGED));
    ENSURE((strstr(result.evidence, "against the loads") != NULL) == (down < 0.));
    ENSURE((strstr(result.evidence, "use pt or tptm") != NULL) == (i == 1));
    result.verdict = VERDICT_COLLAPSED, f.relax->account.start = 1.01 * 0.01 * WEIGHT; // there before
    PetscCall(EnergyCheckVerdict(&p));
    ENSURE(result.verdict == VERDICT_COLLAPSED);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Loads that the ramp has taken away have done work on the way: a ramp down to nothing, 4 mm along with the
   weight. */
static PetscErrorCode RampIsCounted(void)
{
  Fixture f;
  StageResult result;
  Problem p;
  PetscFunctionBeginUser;
  PetscCall(Open("tptm", &f, &result, &p));
  const PetscInt y = DofOf(f.model, 4) + 1;
  PetscCall(PetscArraycpy(f.state->applied.start, f.state->f_ext, ModelApplied(f.model)));
  PetscCall(PetscArrayzero(f.state->applied.target, ModelApplied(f.model)));
  LoadsApply(f.model, f.state, 1.);
  f.state->u[y] -= 0.004;
  PetscCall(EnergyCheckRampEnds(&p));
  ENSURE_NEAR(f.relax->account.ramp, 0.004 * WEIGHT, 1e-9);
  LoadsApply(f.model, f.state, 0.);
  f.state->applied.ramp = 1.;
  f.state->u[y] += 0.004 + 0.003; // 3 mm up
  result.verdict = VERDICT_COLLAPSED;
  PetscCall(EnergyCheckVerdict(&p));
  ENSURE(result.verdict == VERDICT_COLLAPSED); // -3 mm + 4 mm
  f.state->u[y] += 0.002;
  PetscCall(EnergyCheckVerdict(&p));
  ENSURE(result.verdict == VERDICT_DIVERGED); // -5 mm + 4 mm
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A tendon between two places of the ground stores T^2/2k = 5e12 J and keeps it: nothing moves by it. What it
   gives is counted. */
static PetscErrorCode PrestressThatStaysIsNotCounted(void)
{
  Fixture f;
  StageResult result;
  Problem p;
  PetscBool restarts;
  PetscReal stored;
  PetscFunctionBeginUser;
  PetscCall(
      OpenWith("tptm",
               "anchors: {a: {head: [2.5, -0.5], root: [12.5, -0.5], area: 5e-6, young: 2e11, prestress: "
               "1e9, lock: all}}\n",
               &f, &result, &p));
  TermView view = ViewOf(&p);
  PetscCall(TermsBegin(&view));
  view.stage = p.stage = f.scene->stages + 1; // at its start the tendon is locked
  PetscCall(TermsBegin(&view));
  PetscCall(Forces(f.scene, f.model, p.stage->joints, f.contacts, f.state, NULL));
  PetscCall(TermsPrestressed(&view, &stored));
  ENSURE_NEAR(stored, 5e12, 1.);
  PetscCall(EnergyCheckStart(&p));
  PetscCall(Check(&f, &p, 0.01, 1.99 * 0.01 * WEIGHT, &restarts));
  ENSURE(!restarts);
  f.relax->account.most = 0., f.relax->account.stored += 50.; // as if the tendon had given 50 J
  PetscCall(Check(&f, &p, 0.01, 1.99 * (0.01 * WEIGHT + 50.), &restarts));
  ENSURE(!restarts);
  f.relax->account.most = 0., f.relax->account.stored -= 50.;
  PetscCall(Check(&f, &p, 0.01, 2.01 * 0.01 * WEIGHT, &restarts));
  ENSURE(restarts);
  PetscCall(FixtureClose(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(WhatLoadsDidIsAllowed);
  RUN_TEST(MoreRestartsOnce);
  RUN_TEST(WhatMakesEnergyIsNoCollapse);
  RUN_TEST(AgainstTheLoadsIsNoCollapse);
  RUN_TEST(RampIsCounted);
  RUN_TEST(PrestressThatStaysIsNotCounted);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

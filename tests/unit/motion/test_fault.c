/* A force or displacement that is not a number is reported with a block of the body in which it arose, of
   whatever kind. ranks: 1 2 */
#include "scene_fixture.h"

static Sketch sketch;
static const char *const kind[] = {"soft", "hard", "stone"}; // deformable, rigid, condensed

/* A column of three bodies, one of each kind, of 2 by 2 blocks. Body i has the vertices from 9 i on. */
static PetscErrorCode OpenColumn(Fixture *f)
{
  PetscFunctionBeginUser;
  memset(&sketch, 0, sizeof sketch);
  for (int i = 0; i < 3; i++) {
    const double corner[8] = {0, i, 2, i, 2, i + 1, 0, i + 1};
    SketchGrid(&sketch, SketchGroup(&sketch, kind[i], i == 1), corner, 2, 2, QUADS);
  }
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "strain: small\nrelaxation: {allow_floating: true}\n"
                        "materials: {soft: {density: 2400, young: 1e10, poisson: 0.2},\n"
                        "  hard: {density: 2400, rigid: true},\n"
                        "  stone: {density: 2400, young: 1e10, poisson: 0.2, condensed: true}}\n"
                        "joints: {default: {law: elastic, k_n: 1e10, k_s: 3e9}}\n"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts a NaN at a corner of one body after the other. The corner of the condensed body is no vertex of any
   other block. */
static PetscErrorCode AFaultIsReportedWithItsBlock(void)
{
  static const int corner[] = {0, 9, 20};
  PetscFunctionBeginUser;
  for (int i = 0; i < 3; i++) {
    Fixture f;
    char text[128], words[32];
    PetscCall(OpenColumn(&f));
    PetscCall(FaultName(f.model, FaultFind(f.model, f.state), text));
    ENSURE(!strcmp(text, "no block"));
    const PetscInt v = LocalOfFile(f.model, corner[i]);
    if (v >= 0 && v < f.model->mesh.n_owned) f.state->f[3 * f.model->rigid.n + 2 * v] = NAN;
    PetscCall(FaultName(f.model, FaultFind(f.model, f.state), text));
    snprintf(words, sizeof words, "block %d of group %s", i < 2 ? 4 * i : 9, kind[i]);
    ENSURE(!strcmp(text, words));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(AFaultIsReportedWithItsBlock);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* Contacts of vertices on faces: however many faces are near a vertex, all of them are tested.
   ranks: 1 2 4 */
#include "scene_fixture.h"

static Sketch sketch;

/* ---- a tip over a comb of columns thinner than the contact tolerance */

enum { COLUMNS = 120 };
static const double WIDTH = 2e-3, HEIGHT = 0.1, GAP = 1e-2;
static const char comb[] = "materials: {comb: {density: 2400, upgradeable: false}, tip: {density: 2400}}\n"
                           "contact: {connectivity: variable, tolerance: 0.05}\n"
                           "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30}}\n"
                           "relaxation: {allow_floating: true}\n"
                           "loads: {weight: {type: self_weight}}\n"
                           "stages: [all: {loads: [weight]}]\n";

/* File id of the block and number of the face that a contact's vertex stands on, as 4 file + face. */
static PetscInt GroundOf(const Model *m, const Contacts *c, PetscInt at)
{
  const PetscInt block = c->key[2 * at] / 4;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      if (list->gid[e] == block) return 4 * list->file[e] + c->key[2 * at] % 4;
  return -1;
}

/* The tip stands over one column. It is near the tops and the sides of 50 columns, half of them on one rank
   and half on another: 100 faces, of which it must find the one below. */
static PetscErrorCode ATipFindsItsColumnAmongAHundredFaces(void)
{
  PetscFunctionBeginUser;
  for (int under = 0; under < COLUMNS; under += 17) {
    const double x = (under + 0.3) * WIDTH;
    StageResult result = {0};
    PetscInt found[2] = {0, -1};
    Fixture f;
    memset(&sketch, 0, sizeof sketch);
    const int comb_group = SketchGroup(&sketch, "comb", 1), tip_group = SketchGroup(&sketch, "tip", 1);
    for (int i = 0; i < COLUMNS; i++) SketchBox(&sketch, comb_group, i * WIDTH, -HEIGHT, WIDTH, HEIGHT);
    const int tip = SketchVertex(&sketch, x, GAP);
    SketchVertex(&sketch, x + 0.5, GAP + 0.5), SketchVertex(&sketch, x - 0.5, GAP + 0.5);
    SketchBlock(&sketch, tip_group, tip, tip + 1, tip + 2, -1);
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", comb));
    PetscCall(ContactsVerify(f.scene, f.scene->stages[0].joints, f.model, f.state, f.contacts, &result));
    const Contacts *c = f.contacts;
    for (PetscInt at = 0; at < c->n_padded; at++) {
      if (c->key[2 * at] < 0 || c->klass[at] != VERTEX_FACE || !c->owned[at]) continue;
      const PetscInt v = c->vertex[CONTACT_ROW(at, ROW_P)];
      if (f.model->mesh.vertex_file[v] != tip) continue;
      found[0]++, found[1] = PetscMax(found[1], GroundOf(f.model, c, at));
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, found, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, found + 1, 1, MPIU_INT, MPI_MAX, PETSC_COMM_WORLD));
    ENSURE(found[0] == 1);
    // a rank that owns the tip and not the column has no block of it: then no rank says which it is
    ENSURE(found[1] == 4 * under + 2 || (found[1] == -1 && f.model->size > 1));
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(ATipFindsItsColumnAmongAHundredFaces);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* What contacts inherit when they are found again: also where a vertex has many faces.
   ranks: 1 2 4 */
#include "scene_fixture.h"

static Sketch sketch;

/* ---- a fan of leaves that meet in one vertex, the hub, and stand on the ground with one leaf */

enum { LEAVES = 4 };
static const double DEGREE = PETSC_PI / 180, LEAF = 15, EVERY = 38, TURN = 25, SLIP = -2e-4;
static const char fan[] = "materials: {fan: {density: 2400, young: 1e9, poisson: 0},"
                          " ground: {density: 2400, young: 1e9, poisson: 0}}\n"
                          "contact: {connectivity: variable}\n"
                          "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30, stress_model: pt}}\n"
                          "relaxation: {allow_floating: true}\n"
                          "loads: {weight: {type: self_weight}}\n"
                          "stages: [all: {loads: [weight]}]\n";

/* Leaves of 15 degrees every 38 degrees, too far apart to touch each other. standing: the place of the one
   that lies on the ground among the blocks of the file. Returns the vertex of the hub, the first of the
   fan. */
static int Fan(int standing)
{
  const double corner[8] = {-3, -1, 3, -1, 3, 0, -3, 0};
  memset(&sketch, 0, sizeof sketch);
  const int group = SketchGroup(&sketch, "fan", 0), ground = SketchGroup(&sketch, "ground", 0);
  SketchGrid(&sketch, ground, corner, 1, 1, QUADS);
  const int hub = SketchVertex(&sketch, 0, 0);
  for (int i = 0; i < LEAVES; i++) {
    const double from = EVERY * ((i - standing + LEAVES) % LEAVES) * DEGREE, to = from + LEAF * DEGREE;
    const int a = SketchVertex(&sketch, cos(from), sin(from)), b = SketchVertex(&sketch, cos(to), sin(to));
    SketchBlock(&sketch, group, hub, a, b, -1);
  }
  return hub;
}

/* Gives every contact a pressed state with an elastic sliding of -SLIP. */
static void PressAndShear(Contacts *c)
{
  for (PetscInt at = 0; at < c->n_padded; at++)
    for (int k = 0; k < 2 && c->key[2 * at] >= 0; k++) {
      c->u_n[SUB(at, k)] = -1e-4, c->sigma[SUB(at, k)] = -1e5, c->u_s[SUB(at, k)] = 0;
      c->slip[SUB(at, k)] = c->slip_0[SUB(at, k)] = SLIP;
    }
}

/* The fan turns about its hub by more than 20 degrees, at which its contact with the ground degenerates to
   the hub on the ground. The hub has eight faces; it inherits the shear of the one that lay on the ground,
   whichever of the eight that is. */
static PetscErrorCode AHubOfManyFacesInheritsTheShearOfItsContact(void)
{
  PetscFunctionBeginUser;
  for (int standing = 0; standing < LEAVES; standing++) {
    const int hub = Fan(standing);
    StageResult result = {0};
    PetscInt n = 0;
    Fixture f;
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, "%s", fan));
    PressAndShear(f.contacts);
    for (PetscInt v = 0; v < f.model->n_vertices; v++) {
      const PetscReal *X = f.model->X + 2 * v, angle = TURN * DEGREE;
      if (f.model->vertex_file[v] < hub) continue;
      f.u_vertex[2 * v] = (cos(angle) - 1) * X[0] - sin(angle) * X[1];
      f.u_vertex[2 * v + 1] = sin(angle) * X[0] + (cos(angle) - 1) * X[1];
    }
    PetscCall(ContactsVerify(f.scene, f.scene->stages[0].joints, f.model, f.state, f.contacts, &result));
    const Contacts *c = f.contacts;
    for (PetscInt at = 0; at < c->n_padded; at++) {
      if (c->key[2 * at] < 0) continue;
      ENSURE(c->klass[at] == VERTEX_FACE && f.model->vertex_file[c->vertex[CONTACT_ROW(at, ROW_P)]] == hub);
      ENSURE_NEAR(c->slip[SUB(at, 0)], SLIP, 0);
      n += c->owned[at];
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    ENSURE(n == 1);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(AHubOfManyFacesInheritsTheShearOfItsContact);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

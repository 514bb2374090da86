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
    for (PetscInt v = 0; v < f.model->mesh.n_vertices; v++) {
      const PetscReal *X = f.model->mesh.X + 2 * v, angle = TURN * DEGREE;
      if (f.model->mesh.vertex_file[v] < hub) continue;
      f.u_vertex[2 * v] = (cos(angle) - 1) * X[0] - sin(angle) * X[1];
      f.u_vertex[2 * v + 1] = sin(angle) * X[0] + (cos(angle) - 1) * X[1];
    }
    PetscCall(ContactsVerify(f.scene, f.scene->stages[0].joints, f.model, f.state, f.contacts, &result));
    const Contacts *c = f.contacts;
    for (PetscInt at = 0; at < c->n_padded; at++) {
      if (c->key[2 * at] < 0) continue;
      ENSURE(c->klass[at] == VERTEX_FACE &&
             f.model->mesh.vertex_file[c->vertex[CONTACT_ROW(at, ROW_P)]] == hub);
      ENSURE_NEAR(c->slip[SUB(at, 0)], SLIP, 0);
      n += c->owned[at];
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    ENSURE(n == 1);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what has not failed stays whole */

static const char bonded[] = "materials: {fan: {density: 2400, young: 1e9, poisson: 0},"
                             " ground: {density: 2400, young: 1e9, poisson: 0}}\n"
                             "contact: {connectivity: variable}\n"
                             "joints: {default: {k_n: 1e9, k_s: 3e8, friction: 30, cohesion: 1e5,"
                             " stress_model: %s}}\n"
                             "relaxation: {allow_floating: true}\n"
                             "loads: {weight: {type: self_weight}}\n"
                             "stages: [all: {loads: [weight]}]\n";

/* Turns the fan about its hub, lifts it, and finds contacts again. */
static PetscErrorCode MoveFan(Fixture *f, int hub, PetscReal degrees, PetscReal up)
{
  StageResult result = {0};
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < f->model->mesh.n_vertices; v++) {
    const PetscReal *X = f->model->mesh.X + 2 * v, angle = degrees * DEGREE;
    if (f->model->mesh.vertex_file[v] < hub) continue;
    f->u_vertex[2 * v] = (cos(angle) - 1) * X[0] - sin(angle) * X[1];
    f->u_vertex[2 * v + 1] = sin(angle) * X[0] + (cos(angle) - 1) * X[1] + up;
  }
  PetscCall(ContactsVerify(f->scene, f->scene->stages[0].joints, f->model, f->state, f->contacts, &result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The one contact there is here, -1: this rank has none. */
static PetscInt OnlyContact(const Contacts *c)
{
  PetscInt found = -1;
  for (PetscInt at = 0; at < c->n_padded; at++)
    if (c->key[2 * at] >= 0) found = at;
  return found;
}

/* A leaf of 1 m turns to 25 degrees, so that its hub stands on the ground alone, and back to 10. Its joint
   failed over a part of its length at the far end, or nowhere, or all along: so it stays. */
static PetscErrorCode WhatHasNotFailedStaysWhole(void)
{
  static const PetscReal parts[] = {0, 0.375, 1};
  PetscFunctionBeginUser;
  for (int i = 0; i < 3; i++) {
    const int hub = Fan(0);
    Fixture f;
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, bonded, "tptm"));
    PressAndShear(f.contacts);
    PetscInt at = OnlyContact(f.contacts);
    for (int k = 0; at >= 0 && k < 2; k++) {
      const PetscBool at_hub =
          (PetscBool)(f.model->mesh.vertex_file[f.contacts->vertex[CONTACT_ROW(at, k ? ROW_Q : ROW_P)]] ==
                      hub);
      f.contacts->u_n[SUB(at, k)] = at_hub ? -1e-4 : 1e-3;
      f.contacts->broken[SUB(at, k)] = f.contacts->broken_0[SUB(at, k)] = parts[i] == 1 || !at_hub ? parts[i]
                                                                                                   : 0;
    }
    PetscCall(MoveFan(&f, hub, TURN, -1e-4));
    at = OnlyContact(f.contacts);
    if (at >= 0) {
      ENSURE(f.contacts->klass[at] == VERTEX_FACE);
      ENSURE_NEAR(f.contacts->broken[SUB(at, 0)], parts[i] == 1 ? 1 : 0, 0);
      ENSURE_NEAR(f.contacts->broken[SUB(at, 1)], parts[i], 1e-12);
    }
    PetscCall(MoveFan(&f, hub, 10, -1e-4));
    at = OnlyContact(f.contacts);
    if (at >= 0) {
      PetscReal sum = 0;
      ENSURE(f.contacts->klass[at] != VERTEX_FACE);
      for (int k = 0; k < 2; k++) sum += f.contacts->broken[SUB(at, k)];
      ENSURE_NEAR(PetscMin(1, sum), PetscMax(0, 1 - (1 - parts[i]) / f.contacts->length[at]), 1e-6);
    }
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* As above with fixed control points, of which a vertex has one end: nothing was broken at the hub, and the
   far end, which has parted, is broken when the leaf lies down again. */
static PetscErrorCode AnEndOfFixedPointsStaysWhole(void)
{
  static const char *const models[] = {"pt", "r2pt", "r3pt", "t2pt", "t3pt"};
  PetscFunctionBeginUser;
  for (int i = 0; i < 5; i++) {
    const int hub = Fan(0);
    Fixture f;
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, bonded, models[i]));
    PressAndShear(f.contacts);
    PetscCall(MoveFan(&f, hub, TURN, -1e-4));
    PetscInt at = OnlyContact(f.contacts);
    if (at >= 0) ENSURE_NEAR(f.contacts->broken[SUB(at, 0)], 0, 0);
    PetscCall(MoveFan(&f, hub, 10, -1e-4));
    at = OnlyContact(f.contacts);
    if (at >= 0) {
      const PetscReal *broken = f.contacts->broken;
      ENSURE_NEAR(PetscMin(broken[SUB(at, 0)], broken[SUB(at, 1)]), 0, 0);
      ENSURE_NEAR(PetscMax(broken[SUB(at, 0)], broken[SUB(at, 1)]), 0.5, 0);
    }
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On the way of a static stage a leaf of 1 m is lifted by 0.3 m and comes back: its contact is the same. In
   motion it has parted, and what meets again has no cohesion. */
static PetscErrorCode AFaceThatPartsOnTheWayStaysWhole(void)
{
  PetscFunctionBeginUser;
  for (int held = 0; held < 2; held++) {
    const int hub = Fan(0);
    Fixture f;
    PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, &f, bonded, "tptm"));
    PressAndShear(f.contacts);
    f.contacts->friction = held ? FRICTION_LAW : FRICTION_KEPT;
    for (int i = 0; i < 2; i++) {
      const PetscInt before = OnlyContact(f.contacts);
      for (int k = 0; i == 0 && before >= 0 && k < 2; k++) f.contacts->u_n[SUB(before, k)] = 0.3;
      PetscCall(MoveFan(&f, hub, 0, i == 0 ? 0.3 : -1e-4));
    }
    const PetscInt at = OnlyContact(f.contacts);
    if (at >= 0)
      ENSURE_NEAR(f.contacts->broken[SUB(at, 0)] + f.contacts->broken[SUB(at, 1)], held ? 0 : 1, 0);
    PetscCall(FixtureClose(&f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(AHubOfManyFacesInheritsTheShearOfItsContact);
  RUN_TEST(WhatHasNotFailedStaysWhole);
  RUN_TEST(AnEndOfFixedPointsStaysWhole);
  RUN_TEST(AFaceThatPartsOnTheWayStaysWhole);
  const int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

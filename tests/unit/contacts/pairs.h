/* pairs.h: pairs of blocks with one contact each, of all classes and in all directions. */
#pragma once
#include "scene_fixture.h"

enum { PAIRS = 24, MATCHES = 8, MAX_DOF = 2 * (8 * PAIRS + DUMMY_VERTICES) };

static Sketch sketch;
static double pair_angle[PAIRS], pair_at[PAIRS][2]; /* direction and place of the joint of each pair */

/* Makes pairs of blocks far apart, each with one contact, of all classes, in random directions. The faces of
   the first MATCHES pairs match; the others overlap or are apart by up to 3 mm. */
static inline void Pairs(void)
{
  memset(&sketch, 0, sizeof sketch);
  const int soft = SketchGroup(&sketch, "soft", 0);
  for (int p = 0; p < PAIRS; p++) {
    const PetscInt first = sketch.n_vertices;
    const double low[4] = {0, 0.3, -0.4, 0.4}, high[4] = {1, 0.8, 0.6, 1.5}; /* FF1 tie, inside, I, F */
    const int matches = p < MATCHES;
    const double a = matches ? 0 : low[p % 4], b = matches ? 1 : high[p % 4];
    const double gap = matches ? 0 : Uniform(-3e-3, 3e-3), tilt = matches ? 0 : Uniform(-1e-3, 1e-3);
    const double upper[8] = {a, gap, b, gap + tilt, b, 1, a, 1.1};
    SketchBox(&sketch, soft, 0, -1, 1, 1);
    SketchGrid(&sketch, soft, upper, 1, 1, QUADS);
    pair_angle[p] = Uniform(0, 2 * PETSC_PI), pair_at[p][0] = 5 * (p % 5), pair_at[p][1] = 5 * (p / 5);
    SketchMove(&sketch, first, pair_angle[p], pair_at[p][0], pair_at[p][1]);
  }
}

/* gaps: contact.initial_gaps. */
static inline PetscErrorCode OpenPairsOf(const char *gaps, const char *strain, const char *joint, Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(FixtureOpen(PETSC_COMM_WORLD, &sketch, f,
                        "strain: %s\nthickness: 1.3\nmaterials: {soft: {density: 2000, young: 1e9, poisson: "
                        "0.2}}\nrelaxation: {allow_floating: true}\ncontact: {initial_gaps: %s}\n"
                        "joints: {default: {k_n: 2.0, k_s: 0.7, %s}}\n"
                        "loads: {weight: {type: self_weight}}\nstages: [all: {loads: [weight]}]\n",
                        strain, gaps, joint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode OpenPairs(const char *strain, const char *joint, Fixture *f)
{
  PetscFunctionBeginUser;
  PetscCall(OpenPairsOf("real", strain, joint, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every vertex by chance up to `size`, on top of a rotation of each pair up to `turn`. */
static inline void Displace(const Model *m, double size, double turn, PetscReal *u)
{
  double angle[PAIRS];
  for (int p = 0; p < PAIRS; p++) angle[p] = Uniform(-turn, turn);
  for (PetscInt i = 0; i < 2 * (m->mesh.n_vertices + DUMMY_VERTICES); i++) u[i] = 0;
  for (PetscInt v = 0; v < m->mesh.n_vertices; v++) {
    const PetscInt p = m->mesh.vertex_file[v] / 8;
    const double x = m->mesh.X[2 * v] - pair_at[p][0], y = m->mesh.X[2 * v + 1] - pair_at[p][1];
    const double c = cos(angle[p]) - 1, s = sin(angle[p]);
    u[2 * v] = c * x - s * y + Uniform(-size, size), u[2 * v + 1] = s * x + c * y + Uniform(-size, size);
  }
}

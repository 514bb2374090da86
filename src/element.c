/* element.c: deformable blocks: gather, kernel of element_kernels.h, scatter. Quadrilaterals first, then triangles, each
   in ascending order, within an element vertex 0 to the last: every vertex sums in the same order on any number of
   ranks. */
#include "internal.h"
#include "element_kernels.h"

_Static_assert(BATCH % LANES == 0, "a batch is a whole number of vectors");

/* One copy of the hot loops per instruction set; the loader picks one. Sanitizers start after the loader. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                      \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define CLONES
#endif

/* Vertices of the LANES elements from element `first` on. */
KERNEL const PetscInt *LaneVertices(const Elements *e, int n_nodes, PetscInt first)
{
  return e->vertex + (first / BATCH) * n_nodes * BATCH + first % BATCH;
}

#if QUOIN_LANES == 4
#define EACH_LANE(value) ((Lanes){value(0), value(1), value(2), value(3)})
#else
#define EACH_LANE(value) ((Lanes){value(0), value(1), value(2), value(3), value(4), value(5), value(6), value(7)})
#endif

KERNEL LanesVector GatherVector(const PetscReal *x, const PetscInt *vertex)
{
#define X(lane) x[2 * vertex[lane]]
#define Y(lane) x[2 * vertex[lane] + 1]
  return (LanesVector){EACH_LANE(X), EACH_LANE(Y)};
#undef X
#undef Y
}

KERNEL void Gather(int n_nodes, const PetscReal *x, const PetscInt *vertex, LanesVector *p)
{
  for (int i = 0; i < n_nodes; i++) p[i] = GatherVector(x, vertex + i * BATCH);
}

KERNEL void Scatter(int n_nodes, const LanesVector *p, const PetscInt *vertex, PetscReal *f)
{
  for (int lane = 0; lane < LANES; lane++) {
    for (int i = 0; i < n_nodes; i++) {
      const PetscInt v = vertex[i * BATCH + lane];
      f[2 * v] += p[i].x[lane];
      f[2 * v + 1] += p[i].y[lane];
    }
  }
}

KERNEL LanesMaterial LoadMaterial(const Model *model, const PetscInt *group)
{
#define LAMBDA(lane) model->lambda[group[lane]]
#define MU(lane) model->mu[group[lane]]
  return (LanesMaterial){EACH_LANE(LAMBDA), EACH_LANE(MU)};
#undef LAMBDA
#undef MU
}

KERNEL void ForceLoop(const Model *model, const Elements *e, int n_nodes, int large, const PetscReal *restrict u,
                      PetscReal *restrict f)
{
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    LanesVector X[4], U[4], F[4];
    Gather(n_nodes, model->X, vertex, X);
    Gather(n_nodes, u, vertex, U);
    ElementForce(n_nodes, X, U, &material, model->thickness, large, F);
    Scatter(n_nodes, F, vertex, f);
  }
}

CLONES static void ForcesLarge(const Model *model, const PetscReal *u, PetscReal *f)
{
  ForceLoop(model, &model->q4, 4, 1, u, f);
  ForceLoop(model, &model->t3, 3, 1, u, f);
}

CLONES static void ForcesSmall(const Model *model, const PetscReal *u, PetscReal *f)
{
  ForceLoop(model, &model->q4, 4, 0, u, f);
  ForceLoop(model, &model->t3, 3, 0, u, f);
}

PetscErrorCode ElementForces(const Model *model, const PetscReal *u, PetscReal *f)
{
  PetscFunctionBeginUser;
  if (model->strain == STRAIN_LARGE) ForcesLarge(model, u, f);
  else ForcesSmall(model, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

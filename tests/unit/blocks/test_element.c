/* Deformable blocks: patch test (V01), objectivity, the force as derivative of the energy, row sums and
   limits of the time step (V-A2), masses, one-point blocks, and the same bits in every lane. The models are
   built by hand. */
#include "motion/motion.h"
#include "blocks/element_kernels.h"
#include "check.h"

enum { MAX_VERTICES = 64, MAX_ELEMENTS = 16 };

/* A model of one list of elements of one shape; group g is (g + 1) times as stiff as group 0. */
typedef struct {
  Model model;
  int n_nodes;
  PetscReal X[2 * (MAX_VERTICES + DUMMY_VERTICES)], u[2 * (MAX_VERTICES + DUMMY_VERTICES)];
  PetscReal f[2 * (MAX_VERTICES + DUMMY_VERTICES)], density[2], hourglass[6];
  Lame lame[2];
  PetscInt vertex[4 * MAX_ELEMENTS], group[MAX_ELEMENTS];
  bool owned[MAX_ELEMENTS];
} Patch;

static Elements *List(Patch *p)
{
  return p->n_nodes == 4 ? &p->model.mesh.q4 : &p->model.mesh.t3;
}

/* rows: (n, n_nodes) vertices of the elements, with 0-based numbers */
static void PatchCreate(Patch *p, int n_vertices, const PetscReal (*X)[2], int n_nodes, int n,
                        const int *rows)
{
  static const PetscReal dummy[8] = {0, 0, 1, 0, 1, 1, 0, 1};
  memset(p, 0, sizeof *p);
  p->n_nodes = n_nodes;
  p->model.mesh.n_vertices = p->model.mesh.n_owned = p->model.mesh.n_deformable = n_vertices;
  memcpy(p->X, X, sizeof(PetscReal) * 2 * n_vertices);
  memcpy(p->X + 2 * n_vertices, dummy, sizeof dummy);
  Elements *e = List(p);
  e->n = n, e->n_nodes = n_nodes;
  e->n_padded = (n + BATCH - 1) / BATCH * BATCH;
  e->vertex = p->vertex;
  e->group = p->group;
  e->owned = p->owned;
  for (int k = 0; k < e->n_padded; k++) {
    p->owned[k] = k < n;
    for (int i = 0; i < n_nodes; i++)
      p->vertex[(k / BATCH * n_nodes + i) * BATCH + k % BATCH] = k < n ? rows[k * n_nodes + i]
                                                                       : n_vertices + i;
  }
  p->model.mesh.X = p->X, p->model.materials.thickness = 1, p->model.materials.n_groups = 2;
  p->model.materials.lame = p->lame, p->model.materials.density = p->density;
}

/* of groups 0 and 1 of every patch */
static Formulation formulation[2] = {ELEMENT_FULL, ELEMENT_FULL};

static void PatchMaterial(Patch *p, PetscReal young, PetscReal poisson, PetscReal density, PlaneState plane)
{
  PetscReal mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  if (plane == PLANE_STRESS) lambda = 2 * lambda * mu / (lambda + 2 * mu);
  for (int g = 0; g < 2; g++) p->lame[g] = (Lame){(g + 1) * lambda, (g + 1) * mu}, p->density[g] = density;
  for (int g = 0; g < 2; g++) ElementHourglass(formulation[g], p->lame[g], 0.1, p->hourglass + 3 * g);
  p->model.materials.hourglass = formulation[0] || formulation[1] ? p->hourglass : NULL;
}

/* of the model and of its lists */
static void PatchStrain(Patch *p, StrainMeasure strain)
{
  p->model.materials.strain = p->model.mesh.q4.strain = p->model.mesh.t3.strain = strain;
}

static PetscErrorCode PatchForces(Patch *p)
{
  PetscFunctionBeginUser;
  memset(p->f, 0, sizeof p->f);
  PetscCall(ElementForces(&p->model, p->u, p->f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u = (H x) at all vertices but the dummies */
static void PatchDisplace(Patch *p, PetscReal H[2][2])
{
  for (int v = 0; v < p->model.mesh.n_vertices; v++)
    for (int d = 0; d < 2; d++) p->u[2 * v + d] = H[d][0] * p->X[2 * v] + H[d][1] * p->X[2 * v + 1];
}

/* the same numbers on every machine, in [-1, 1] */
static PetscReal Random(void)
{
  static uint32_t state = 1;
  state = state * 1664525u + 1013904223u;
  return state / 2147483648.0 - 1.0;
}

/* The patch of MacNeal and Harder, as 5 quadrilaterals or 10 triangles. */
static void MacNealPatch(Patch *p, int n_nodes)
{
  static const PetscReal X[8][2] = {{0, 0},     {.24, 0},   {.24, .12}, {0, .12},
                                    {.04, .02}, {.18, .03}, {.16, .08}, {.08, .08}};
  static const int q4[20] = {0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7, 4, 5, 6, 7};
  int t3[30];
  for (int k = 0; k < 5; k++) {
    const int *q = q4 + 4 * k, split[6] = {q[0], q[1], q[2], q[0], q[2], q[3]};
    memcpy(t3 + 6 * k, split, sizeof split);
  }
  if (n_nodes == 4)
    PatchCreate(p, 8, X, 4, 5, q4);
  else
    PatchCreate(p, 8, X, 3, 10, t3);
  PatchMaterial(p, 1e6, 0.25, 2400, PLANE_STRAIN);
}

/* every stress of the patch, at the centres and at the Gauss points */
static PetscErrorCode EnsureStress(Patch *p, const PetscReal expected[3], PetscReal tol)
{
  PetscReal s[MAX_ELEMENTS * 4 * 3];
  const int n_points = p->n_nodes == 4 ? 4 : 1;

  PetscFunctionBeginUser;
  PetscCall(ElementStress(&p->model, List(p), p->n_nodes, p->u, s));
  for (int k = 0; k < 3 * List(p)->n; k++) ENSURE_NEAR(s[k], expected[k % 3], tol);
  PetscCall(ElementStressGauss(&p->model, List(p), p->n_nodes, p->u, s));
  for (int k = 0; k < 3 * n_points * List(p)->n; k++) ENSURE_NEAR(s[k], expected[k % 3], tol);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* V01: a linear displacement field gives no force at the inner vertices 4..7 and the exact uniform stress. */
static PetscErrorCode TestPatch(void)
{
  PetscReal H[2][2] = {{1e-3, 0.5e-3}, {0.5e-3, 1e-3}};
  Patch p;

  PetscFunctionBeginUser;
  for (int n_nodes = 3; n_nodes <= 4; n_nodes++) {
    for (int plane = PLANE_STRAIN; plane <= PLANE_STRESS; plane++) {
      for (int strain = STRAIN_LARGE; strain <= STRAIN_SMALL; strain++) {
        MacNealPatch(&p, n_nodes);
        PatchMaterial(&p, 1e6, 0.25, 2400, plane);
        PatchDisplace(&p, H);
        PatchStrain(&p, strain);
        PetscCall(PatchForces(&p));
        for (int i = 8; i < 16; i++) ENSURE_NEAR(p.f[i], 0, 1e-12 * 400);
        ENSURE(PetscAbsReal(p.f[0]) > 10);
        const PetscReal normal = plane == PLANE_STRAIN ? 1600 : 4000. / 3, s[3] = {normal, normal, 400};
        if (strain == STRAIN_SMALL) PetscCall(EnsureStress(&p, s, 1e-12 * 1600));
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* F = R U: the Cauchy stress turns with R; R alone gives no force and no stress. U
   stretches by 1 + a along x. */
static PetscErrorCode TestRotation(void)
{
  static const PetscReal degrees[3] = {0, 90, 1000};
  Patch p;

  PetscFunctionBeginUser;
  for (int n_nodes = 3; n_nodes <= 4; n_nodes++) {
    for (int k = 0; k < 3; k++) {
      const PetscReal c = cos(degrees[k] * PETSC_PI / 180), s = sin(degrees[k] * PETSC_PI / 180), a = 0.1;
      MacNealPatch(&p, n_nodes);
      PatchDisplace(&p, (PetscReal[2][2]){{c - 1, -s}, {s, c - 1}});
      PetscCall(PatchForces(&p));
      for (int i = 0; i < 16; i++) ENSURE_NEAR(p.f[i], 0, 1e-14 * 1e6);
      PetscCall(EnsureStress(&p, (PetscReal[3]){0, 0, 0}, 1e-14 * 1e6));
      PatchDisplace(&p, (PetscReal[2][2]){{c * (1 + a) - 1, -s}, {s * (1 + a), c - 1}});
      PetscCall(PatchForces(&p));
      for (int i = 8; i < 16; i++) ENSURE_NEAR(p.f[i], 0, 1e-14 * 1e6);
      /* E_xx = a + a^2/2, S = lambda tr E + 2 mu E, sigma_xx = F_xx^2 S_xx / F_xx, sigma_yy = S_yy / F_xx */
      const PetscReal E = a + a * a / 2, sx = (1 + a) * (p.lame[0].lambda + 2 * p.lame[0].mu) * E,
                      sy = p.lame[0].lambda * E / (1 + a);
      PetscCall(EnsureStress(
          &p, (PetscReal[3]){c * c * sx + s * s * sy, s * s * sx + c * c * sy, c * s * (sx - sy)},
          1e-14 * 1e6));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PatchEnergy(Patch *p, PetscReal *sum)
{
  PetscReal energy[MAX_ELEMENTS];

  PetscFunctionBeginUser;
  *sum = 0;
  PetscCall(ElementEnergy(&p->model, List(p), p->n_nodes, p->u, energy));
  for (int k = 0; k < List(p)->n; k++) *sum += energy[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* f = d(energy)/du by central differences, strains of some 10 %, two materials, thickness 0.7. */
static PetscErrorCode TestEnergy(void)
{
  const PetscReal h = 1e-6;
  Patch p;

  PetscFunctionBeginUser;
  for (int n_nodes = 3; n_nodes <= 4; n_nodes++) {
    for (int strain = STRAIN_LARGE; strain <= STRAIN_SMALL; strain++) {
      PetscReal largest = 0, plus, minus;
      MacNealPatch(&p, n_nodes);
      PatchStrain(&p, strain), p.model.materials.thickness = 0.7, p.group[1] = p.group[4] = 1;
      for (int i = 0; i < 16; i++) p.u[i] = 0.005 * Random();
      PetscCall(PatchForces(&p));
      for (int i = 0; i < 16; i++) largest = PetscMax(largest, PetscAbsReal(p.f[i]));
      for (int i = 0; i < 16; i++) {
        const PetscReal u = p.u[i];
        p.u[i] = u + h;
        PetscCall(PatchEnergy(&p, &plus));
        p.u[i] = u - h;
        PetscCall(PatchEnergy(&p, &minus));
        p.u[i] = u;
        ENSURE_NEAR((plus - minus) / (2 * h), p.f[i], 1e-7 * largest);
      }
      p.owned[0] = PETSC_FALSE; /* another rank counts it */
      PetscCall(PatchEnergy(&p, &plus));
      p.owned[0] = PETSC_TRUE;
      PetscCall(PatchEnergy(&p, &minus));
      ENSURE(plus < minus);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K[i][j] = d f_i / d u_j about u = 0, of one element */
static PetscErrorCode FiniteStiffness(Patch *p, PetscReal h, PetscReal K[8][8])
{
  const int n = 2 * p->n_nodes;

  PetscFunctionBeginUser;
  for (int j = 0; j < n; j++) {
    p->u[j] = h;
    PetscCall(PatchForces(p));
    for (int i = 0; i < n; i++) K[i][j] = p->f[i] / (2 * h);
    p->u[j] = -h;
    PetscCall(PatchForces(p));
    for (int i = 0; i < n; i++) K[i][j] -= p->f[i] / (2 * h);
    p->u[j] = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* largest eigenvalue of M^-1 K by power iteration and the Rayleigh quotient */
static PetscReal LargestEigenvalue(int n, PetscReal K[8][8], const PetscReal *m)
{
  PetscReal x[8], y[8], quotient = 0;
  for (int i = 0; i < n; i++) x[i] = Random();
  for (int step = 0; step < 5000; step++) {
    PetscReal xKx = 0, xMx = 0, size = 0;
    for (int i = 0; i < n; i++) {
      y[i] = 0;
      for (int j = 0; j < n; j++) y[i] += K[i][j] * x[j];
      xKx += x[i] * y[i];
      xMx += m[i / 2] * x[i] * x[i];
      y[i] /= m[i / 2];
      size = PetscMax(size, PetscAbsReal(y[i]));
    }
    quotient = xKx / xMx;
    for (int i = 0; i < n; i++) x[i] = y[i] / size;
  }
  return quotient;
}

/* Table of V-A2: E = 10 GPa, nu = 0.2, rho = 2400, plane strain: exact limit 2/omega [s] and the ratio to it
   of the bound (25) with (28), which must stay below 1. Small strain is linear: steps of 1 m give K to
   rounding; the large-strain kernel has the same tangent at rest. */
static PetscErrorCode TestStiffness(void)
{
  static const PetscReal X[4][4][2] = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                                       {{0, 0}, {4, 0}, {4, 1}, {0, 1}},
                                       {{0, 0}, {1, 0}, {2, 1}, {1, 1}},
                                       {{0, 0}, {1, 0}, {0, 1}}};
  static const PetscReal limit[4] = {4.157e-4, 4.638e-4, 2.857e-4, 3.053e-4},
                         ratio[4] = {0.953, 0.958, 0.875, 0.879};
  static const int row[4] = {0, 1, 2, 3};
  Patch p;

  PetscFunctionBeginUser;
  for (int c = 0; c < 4; c++) {
    PetscReal K[8][8], large[8][8], m[8] = {0}, k[8] = {0}, bound = PETSC_INFINITY;
    PatchCreate(&p, c < 3 ? 4 : 3, X[c], c < 3 ? 4 : 3, 1, row);
    PatchMaterial(&p, 1e10, 0.2, 2400, PLANE_STRAIN);
    PatchStrain(&p, STRAIN_LARGE);
    PetscCall(FiniteStiffness(&p, 1e-6, large));
    PatchStrain(&p, STRAIN_SMALL);
    PetscCall(FiniteStiffness(&p, 1, K));
    PetscCall(ElementStiffness(&p.model, k));
    PetscCall(ElementMasses(&p.model, m));
    for (int i = 0; i < p.n_nodes; i++) {
      PetscReal x = 0, y = 0;
      for (int j = 0; j < 2 * p.n_nodes; j++) {
        x += PetscAbsReal(K[2 * i][j]), y += PetscAbsReal(K[2 * i + 1][j]);
        ENSURE_NEAR(K[2 * i][j], K[j][2 * i], 1e-14 * 1e10);
        ENSURE_NEAR(K[2 * i + 1][j], K[j][2 * i + 1], 1e-14 * 1e10);
        ENSURE_NEAR(K[2 * i][j], large[2 * i][j], 1e-9 * 1e10);
      }
      ENSURE_NEAR(k[i], PetscMax(x, y), 1e-14 * 1e11);
      bound = PetscMin(bound, 2 * sqrt(m[i] / k[i]));
    }
    const PetscReal exact = 2 / sqrt(LargestEigenvalue(2 * p.n_nodes, K, m));
    ENSURE_NEAR(exact, limit[c], 0.0006e-4);
    ENSURE_NEAR(bound / exact, ratio[c], 0.0006);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One-point blocks: patch test, rotation and energy as the full block, alone and mixed with it in a batch;
   the bound of the time step; energy of a rectangle in pure bending u_x = kappa x y, exactly E kappa^2 int
   y^2 dA / 2 for ELEMENT_BENDING, (1 + (1 - nu)/2 (a/b)^2)/(1 - nu^2) times as much for the full one. */
static PetscErrorCode TestOnePoint(void)
{
  static const PetscReal X[3][4][2] = {
      {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 0}, {4, 0}, {4, 1}, {0, 1}}, {{0, 0}, {1, 0}, {2, 1}, {1, 1}}};
  static const int row[4] = {0, 1, 2, 3};
  static const Formulation of[4][2] = {{ELEMENT_BENDING, ELEMENT_BENDING},
                                       {ELEMENT_REDUCED, ELEMENT_REDUCED},
                                       {ELEMENT_FULL, ELEMENT_BENDING},
                                       {ELEMENT_REDUCED, ELEMENT_FULL}};
  Patch p;

  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    formulation[0] = of[i][0], formulation[1] = of[i][1];
    PetscCall(TestPatch());
    PetscCall(TestRotation());
    PetscCall(TestEnergy());
  }
  for (int i = ELEMENT_FULL; i <= ELEMENT_REDUCED; i++) {
    const PetscReal nu = 0.2, E = 1e10, kappa = 1e-3, b = 0.5, a = 2;
    PetscReal energy;
    formulation[0] = formulation[1] = (Formulation)i;
    for (int c = 0; c < 3; c++) {
      PetscReal K[8][8], m[8] = {0}, k[8] = {0}, bound = PETSC_INFINITY;
      PatchCreate(&p, 4, X[c], 4, 1, row);
      PatchMaterial(&p, E, nu, 2400, PLANE_STRESS);
      PatchStrain(&p, STRAIN_SMALL);
      PetscCall(FiniteStiffness(&p, 1, K));
      PetscCall(ElementStiffness(&p.model, k));
      PetscCall(ElementMasses(&p.model, m));
      for (int v = 0; v < 4; v++) bound = PetscMin(bound, 2 * sqrt(m[v] / k[v]));
      ENSURE(bound < 2 / sqrt(LargestEigenvalue(8, K, m)));
    }
    PatchCreate(&p, 4, X[1], 4, 1, row);
    PatchMaterial(&p, E, nu, 2400, PLANE_STRESS);
    PatchStrain(&p, STRAIN_SMALL);
    for (int v = 0; v < 4; v++) p.u[2 * v] = kappa * (X[1][v][0] - a) * (X[1][v][1] - b);
    PetscCall(PatchEnergy(&p, &energy));
    const PetscReal exact = 0.5 * E * kappa * kappa * 4 * a * b * b * b / 3;
    if (i == ELEMENT_BENDING) ENSURE_NEAR(energy / exact, 1, 1e-12);
    if (i == ELEMENT_FULL)
      ENSURE_NEAR(energy / exact, (1 + 0.5 * (1 - nu) * (a / b) * (a / b)) / (1 - nu * nu), 1e-12);
    ENSURE(energy > 0);
  }
  formulation[0] = formulation[1] = ELEMENT_FULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* (26)-(27) by 2x2 Gauss with shape functions as in books, on a distorted quadrilateral; their sums. */
static PetscErrorCode TestMasses(void)
{
  static const PetscReal X[4][2] = {{0, 0}, {3, 0.5}, {2, 2.5}, {-0.5, 1}},
                         s[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  static const int row[4] = {0, 1, 2, 3};
  PetscReal m[16] = {0}, expected[4] = {0}, area, centroid[2], polar, sum = 0;
  Patch p;

  PetscFunctionBeginUser;
  PatchCreate(&p, 4, X, 4, 1, row);
  PatchMaterial(&p, 1e10, 0.2, 2400, PLANE_STRAIN);
  p.model.materials.thickness = 0.7;
  for (int g = 0; g < 4; g++) {
    const PetscReal xi = s[g][0] / sqrt(3), eta = s[g][1] / sqrt(3);
    PetscReal J[2][2] = {{0}}, N[4];
    for (int i = 0; i < 4; i++) {
      N[i] = (1 + s[i][0] * xi) * (1 + s[i][1] * eta) / 4;
      for (int d = 0; d < 2; d++) {
        J[0][d] += s[i][0] * (1 + s[i][1] * eta) / 4 * X[i][d];
        J[1][d] += s[i][1] * (1 + s[i][0] * xi) / 4 * X[i][d];
      }
    }
    for (int i = 0; i < 4; i++) expected[i] += 2400 * 0.7 * N[i] * (J[0][0] * J[1][1] - J[0][1] * J[1][0]);
  }
  PetscCall(ElementMasses(&p.model, m));
  for (int i = 0; i < 4; i++) ENSURE_NEAR(m[i], expected[i], 1e-14 * 1e4);
  for (int n_nodes = 3; n_nodes <= 4; n_nodes++) {
    MacNealPatch(&p, n_nodes);
    memset(m, 0, sizeof m);
    PetscCall(ElementMasses(&p.model, m));
    sum = 0;
    for (int i = 0; i < 8; i++) sum += m[i];
    ENSURE_NEAR(sum, 2400 * .24 * .12, 1e-14 * 100);
  }
  BlockGeometry(&X[0][0], (PetscInt[4]){0, 1, 2, 3}, 4, &area, centroid, &polar);
  ENSURE_NEAR(area, (expected[0] + expected[1] + expected[2] + expected[3]) / (2400 * 0.7), 1e-14 * 10);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* n separate distorted quadrilaterals in the given order: element k has vertices 4 order[k] .. + 3 */
static void Quadrilaterals(Patch *p, int n, const int *order, const PetscReal (*X)[2], const PetscReal *u)
{
  int rows[4 * MAX_ELEMENTS] = {0};
  for (int k = 0; k < n; k++)
    for (int i = 0; i < 4; i++) rows[4 * k + i] = 4 * order[k] + i;
  PatchCreate(p, 4 * MAX_ELEMENTS, X, 4, n, rows);
  PatchMaterial(p, 1e10, 0.2, 2400, PLANE_STRAIN);
  for (int k = 0; k < n; k++) p->group[k] = order[k] % 2;
  memcpy(p->u, u, sizeof(PetscReal) * 8 * MAX_ELEMENTS);
}

/* An element has the same bits in any lane and batch, beside any others, and in the kernel compiled for this
   file: no contraction, no difference between instruction sets. */
static PetscErrorCode TestLanes(void)
{
  static const PetscReal corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  static const int order[2][11] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, {7, 2, 10, 0, 5, 9, 1, 8, 3, 6, 4}};
  PetscReal X[MAX_VERTICES][2], u[2 * MAX_VERTICES], f[2 * MAX_VERTICES];
  Patch p;

  PetscFunctionBeginUser;
  for (int i = 0; i < 2 * MAX_VERTICES; i++) {
    X[i / 2][i % 2] = 3 * (i / 8) + corner[i / 2 % 4][i % 2] + 0.2 * Random();
    u[i] = 0.1 * Random();
  }
  for (int strain = STRAIN_LARGE; strain <= STRAIN_SMALL; strain++) {
    Quadrilaterals(&p, 11, order[0], X, u);
    PatchStrain(&p, strain);
    PetscCall(PatchForces(&p));
    memcpy(f, p.f, sizeof f);
    for (int n = 1; n <= 11; n++) { /* batches of all fillings */
      Quadrilaterals(&p, n, order[1], X, u);
      PatchStrain(&p, strain);
      PetscCall(PatchForces(&p));
      for (int k = 0; k < n; k++)
        ENSURE(memcmp(p.f + 8 * order[1][k], f + 8 * order[1][k], 8 * sizeof *f) == 0);
      for (int i = 0; i < 8; i++) ENSURE(p.f[2 * p.model.mesh.n_vertices + i] == 0);
    }
    for (int k = 0; k < 11; k++) {
      LanesVector x[4], d[4], F[4];
      const Lanes zero = {0};
      const LanesMaterial material = {.lambda = zero + p.lame[k % 2].lambda, .mu = zero + p.lame[k % 2].mu};
      for (int i = 0; i < 4; i++) {
        x[i] = (LanesVector){zero + X[4 * k + i][0], zero + X[4 * k + i][1]};
        d[i] = (LanesVector){zero + u[8 * k + 2 * i], zero + u[8 * k + 2 * i + 1]};
      }
      ElementForce(4, x, d, &material, 1, strain == STRAIN_LARGE, F);
      for (int i = 0; i < 4; i++)
        for (int lane = 0; lane < LANES; lane++)
          ENSURE(F[i].x[lane] == f[8 * k + 2 * i] && F[i].y[lane] == f[8 * k + 2 * i + 1]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forces, row sums and masses are added to what is there; group 1 is twice as stiff. */
static PetscErrorCode TestAccumulate(void)
{
  Patch p;
  PetscReal once[16];

  PetscFunctionBeginUser;
  MacNealPatch(&p, 3);
  for (int i = 0; i < 16; i++) p.u[i] = 0.001 * Random();
  PetscCall(PatchForces(&p));
  memcpy(once, p.f, sizeof once);
  PetscCall(ElementForces(&p.model, p.u, p.f));
  for (int i = 0; i < 16; i++) ENSURE_NEAR(p.f[i], 2 * once[i], 1e-14 * 1e5);
  for (int k = 0; k < 10; k++) p.group[k] = 1;
  PetscCall(PatchForces(&p));
  for (int i = 0; i < 16; i++) ENSURE_NEAR(p.f[i], 2 * once[i], 1e-14 * 1e5);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rectangle b h, turned and far away: A = b h, I = b h (b^2 + h^2)/12. Triangle: I = A (sum
   of squared sides)/36. */
static void TestGeometry(void)
{
  const PetscReal b = 3, h = 2, c = 0.6, s = 0.8, x = 1000, y = -500;
  const PetscReal X[5][2] = {
      {9, 9}, {x, y}, {x + b * c, y + b * s}, {x + b * c - h * s, y + b * s + h * c}, {x - h * s, y + h * c}};
  PetscReal area, centroid[2], polar;
  BlockGeometry(&X[0][0], (PetscInt[4]){1, 2, 3, 4}, 4, &area, centroid, &polar);
  ENSURE_NEAR(area, 6, 1e-12);
  ENSURE_NEAR(centroid[0], x + (b * c - h * s) / 2, 1e-12);
  ENSURE_NEAR(centroid[1], y + (b * s + h * c) / 2, 1e-12);
  ENSURE_NEAR(polar, 6.5, 1e-11);
  BlockGeometry(&X[0][0], (PetscInt[3]){3, 1, 2}, 3, &area, centroid, &polar);
  ENSURE_NEAR(area, 3, 1e-12);
  ENSURE_NEAR(centroid[0], (X[1][0] + X[2][0] + X[3][0]) / 3, 1e-12);
  ENSURE_NEAR(polar, 3 * (2 * (b * b + h * h)) / 36, 1e-11);
}

static void TestPrincipal(void)
{
  PetscReal principal[2], angle;
  PrincipalStress((PetscReal[3]){0, 0, 5}, principal, &angle);
  ENSURE_NEAR(principal[0], 5, 1e-14);
  ENSURE_NEAR(principal[1], -5, 1e-14);
  ENSURE_NEAR(angle, PETSC_PI / 4, 1e-14);
  PrincipalStress((PetscReal[3]){-3, 1, 0}, principal, &angle);
  ENSURE_NEAR(principal[0], 1, 1e-14);
  ENSURE_NEAR(principal[1], -3, 1e-14);
  ENSURE_NEAR(PetscAbsReal(angle), PETSC_PI / 2, 1e-14);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestPatch);
  RUN_TEST(TestRotation);
  RUN_TEST(TestEnergy);
  RUN_TEST(TestStiffness);
  RUN_TEST(TestOnePoint);
  RUN_TEST(TestMasses);
  RUN_TEST(TestLanes);
  RUN_TEST(TestAccumulate);
  RUN_TEST(TestGeometry);
  RUN_TEST(TestPrincipal);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

/* element.c: computes forces, stiffness, stresses and energies of deformable blocks. Each loop gathers
   vertices, calls a kernel of element_kernels.h, and scatters its result. Quadrilaterals come first, then
   triangles, each in ascending order, and within an element vertex 0 to the last. So every vertex sums in
   the same order on any number of ranks. */
#include "blocks/element_loop.h"
#include "blocks/law_point.h"

static const PetscReal Q4_POINTS[4][2] = {{-GAUSS, -GAUSS}, {GAUSS, -GAUSS}, {GAUSS, GAUSS}, {-GAUSS, GAUSS}};

/* Takes E and nu of the plane problem: 4 mu (lambda + mu)/(lambda + 2 mu) and lambda/(lambda + 2 mu). */
void ElementHourglass(Formulation element, Lame lame, PetscReal coefficient, PetscReal hourglass[3])
{
  const PetscReal lambda = lame.lambda, mu = lame.mu;
  const PetscReal nu = lambda / (lambda + 2. * mu), E = 4. * mu * (lambda + mu) / (lambda + 2. * mu);
  for (int i = 0; i < 3; i++) hourglass[i] = 0.;
  if (element == ELEMENT_BENDING) hourglass[0] = E, hourglass[2] = -nu * E;
  if (element == ELEMENT_REDUCED) hourglass[0] = hourglass[1] = 0.5 * coefficient * E;
}

/* ---- forces (10) */

/* Elements are taken in chunks of CHUNK elements of one shape. After each chunk some vertices have all their
   forces, and can move while they are still in the cache. */
enum { CHUNK = 512 };
static const PetscReal STEP = 1e-5; /* step of central differences, as a fraction of a side */

static PetscInt chunks_of(const Elements *e)
{
  return (e->n_padded + CHUNK - 1) / CHUNK;
}

PetscInt ElementChunks(const Model *model)
{
  return chunks_of(&model->mesh.q4) + chunks_of(&model->mesh.t3);
}

KERNEL void NarrowForces_code(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                              PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f)
{
  if (n_nodes == 4 && model->materials.hourglass)
    ForceLoop(model, model->materials.hourglass, e, 4, large, 0, from, to, ahead, u, f);
  else
    ForceCases(model, e, n_nodes, large, from, to, ahead, u, f);
}

VARIANTS(NarrowForces,
         (const Model *model, const Elements *e, int n_nodes, int large, PetscInt from, PetscInt to,
          const Ahead *ahead, const PetscReal *u, PetscReal *f),
         (model, e, n_nodes, large, from, to, ahead, u, f))

static void range_forces(const Model *model, const Elements *e, int n_nodes, int large, PetscInt from,
                         PetscInt to, const Ahead *ahead, const PetscReal *u, PetscReal *f)
{
  if (instruction_set == ISA_V4 && !model->materials.hourglass)
    ElementForcesWide(model, e, n_nodes, large, from, to, ahead, u, f);
  else
    NarrowForces(model, e, n_nodes, large, from, to, ahead, u, f);
}

/* Computes the forces of blocks that may have been placed later; a separate function, or the loops above
   become slower. */
KERNEL void PlacedForces_code(const Model *model, const Elements *e, PetscInt from, PetscInt to,
                              const Ahead *ahead, const PetscReal *u, PetscReal *f)
{
  const int large = e->strain == STRAIN_LARGE;
  if (e->n_nodes == 4)
    ForceLoop(model, model->materials.hourglass, e, 4, large, 1, from, to, ahead, u, f);
  else
    ForceLoop(model, NULL, e, 3, large, 1, from, to, ahead, u, f);
}

VARIANTS(PlacedForces,
         (const Model *model, const Elements *e, PetscInt from, PetscInt to, const Ahead *ahead,
          const PetscReal *u, PetscReal *f),
         (model, e, from, to, ahead, u, f))

void ElementForcesOfChunk(const Model *model, PetscInt chunk, const Ahead *ahead, const PetscReal *u,
                          PetscReal *f)
{
  const PetscInt n_q4 = chunks_of(&model->mesh.q4), local = chunk < n_q4 ? chunk : chunk - n_q4;
  const Elements *e = chunk < n_q4 ? &model->mesh.q4 : &model->mesh.t3;
  const PetscInt from = local * CHUNK, to = (local + 1) * CHUNK;
  if (e->placed)
    PlacedForces(model, e, from, to, ahead, u, f);
  else
    range_forces(model, e, chunk < n_q4 ? 4 : 3, model->materials.strain == STRAIN_LARGE, from, to, ahead, u,
                 f);
}

PetscErrorCode ElementForces(const Model *model, const PetscReal *u, PetscReal *f)
{
  PetscFunctionBeginUser;
  for (PetscInt chunk = 0; chunk < ElementChunks(model); chunk++)
    ElementForcesOfChunk(model, chunk, NULL, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElementForcesCondensed(const Model *model, const PetscReal *u, PetscReal *f)
{
  range_forces(model, &model->mesh.condensed_q4, 4, 0, 0, PETSC_MAX_INT, NULL, u, f);
  range_forces(model, &model->mesh.condensed_t3, 3, 0, 0, PETSC_MAX_INT, NULL, u, f);
}

void ElementForcesTurned(const Model *model, const PetscReal *u, PetscReal *f)
{
  range_forces(model, &model->mesh.condensed_q4, 4, 1, 0, PETSC_MAX_INT, NULL, u, f);
  range_forces(model, &model->mesh.condensed_t3, 3, 1, 0, PETSC_MAX_INT, NULL, u, f);
}

/* Finds for each chunk the lowest vertex of all later chunks, in a loop that runs backwards. After a chunk
   the vertices below that vertex have their forces. */
PetscErrorCode ElementChunksDone(Model *model)
{
  PetscInt lowest = model->mesh.n_deformable;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ElementChunks(model), &model->mesh.chunk_done));
  for (PetscInt chunk = ElementChunks(model) - 1; chunk >= 0; chunk--) {
    const PetscInt of_t3 = chunk - chunks_of(&model->mesh.q4), local = of_t3 < 0 ? chunk : of_t3;
    const Elements *e = of_t3 < 0 ? &model->mesh.q4 : &model->mesh.t3;
    model->mesh.chunk_done[chunk] = lowest;
    for (PetscInt i = local * CHUNK; i < PetscMin(e->n, (local + 1) * CHUNK); i++)
      for (int k = 0, n_nodes = of_t3 < 0 ? 4 : 3; k < n_nodes; k++)
        lowest = PetscMin(lowest, LaneVertices(e, n_nodes, i)[k * BATCH]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- row sums (28) and masses (27) */

/* Computes column (j, direction) of the reference stiffness as the small-strain force of a unit displacement
   there, so K is by construction the tangent of the force kernel. In large strain forces are cubic in u. The
   error of central differences is then STEP^2 and the rounding of forces over STEP, together 1e-10 of K. */
void ElementMatrices(const Model *model, const Elements *e, int n_nodes, PetscInt first, const PetscReal *u,
                     PetscReal K[][64])
{
  const PetscInt *vertex = LaneVertices(e, n_nodes, first);
  const LanesMaterial material = LoadMaterial(model, e->group + first);
  LanesVector X[4], U[4] = {{{0}, {0}}, {{0}, {0}}, {{0}, {0}}, {{0}, {0}}}, F[2][4] = {{{{0}, {0}}}};
  if (u)
    GatherBlocks(model, e, n_nodes, first, 1, u, X, U);
  else
    Gather(n_nodes, model->mesh.X, vertex, X);
  const LanesVector side = VectorSubtract(X[1], X[0]);
  const Lanes h = u ? STEP * SquareRoot(VectorDot(side, side)) : LanesOf(1.), width = u ? h + h : h;
  for (int column = 0; column < 2 * n_nodes; column++) {
    for (int k = 0; k < (u ? 2 : 1); k++) {
      LanesVector moved[4];
      memcpy(moved, U, sizeof moved);
      Lanes *x = column % 2 ? &moved[column / 2].y : &moved[column / 2].x;
      *x = k ? *x - h : *x + h;
      ElementForce(n_nodes, X, moved, &material, model->materials.thickness, u != NULL, F[k]);
    }
    for (int i = 0; i < n_nodes; i++) {
      const LanesVector d = VectorSubtract(F[0][i], F[1][i]);
      for (int lane = 0; lane < LANES; lane++) {
        K[lane][(2 * i) * 2 * n_nodes + column] = d.x[lane] / width[lane];
        K[lane][(2 * i + 1) * 2 * n_nodes + column] = d.y[lane] / width[lane];
      }
    }
  }
}

/* Computes (28), which is an upper bound of the eigenvalues for two reasons. With any masses m_i, omega^2 is
   an eigenvalue of M^-1 K, hence (Gershgorin) at most the largest row sum of |K| over m_i. And the row sum
   of the assembled |sum K_e| is at most the sum of the row sums of |K_e|. A vertex has one number, the
   larger of the two directions, because a block that has turned by 90 degrees has its x and y rows
   exchanged, and because masses must be isotropic. */
static void stiffness_loop(const Model *model, const Elements *e, int n_nodes, PetscReal *k)
{
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const int n = 2 * n_nodes;
    PetscReal K[LANES][64];
    ElementMatrices(model, e, n_nodes, first, NULL, K);
    for (int lane = 0; lane < LANES; lane++)
      for (int i = 0; i < n_nodes; i++) {
        PetscReal row[2] = {0., 0.};
        for (int j = 0; j < 2 * n; j++) row[j / n] += PetscAbsReal(K[lane][2 * i * n + j]);
        k[vertex[i * BATCH + lane]] += PetscMax(row[0], row[1]);
      }
  }
}

PetscErrorCode ElementStiffnessCondensed(const Model *model, PetscReal *k)
{
  PetscFunctionBeginUser;
  stiffness_loop(model, &model->mesh.condensed_q4, 4, k);
  stiffness_loop(model, &model->mesh.condensed_t3, 3, k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void weighted_loop(const Model *model, const Elements *e, int n_nodes, const PetscReal *x,
                          PetscReal *rows)
{
  const int n = 2 * n_nodes;
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    PetscReal K[LANES][64];
    ElementMatrices(model, e, n_nodes, first, NULL, K);
    for (int lane = 0; lane < LANES; lane++) {
      PetscReal weight[8];
      for (int j = 0; j < n; j++) weight[j] = x[2 * vertex[j / 2 * BATCH + lane] + j % 2];
      for (int i = 0; i < n; i++) {
        PetscReal row = 0.;
        for (int j = 0; j < n; j++) row += PetscAbsReal(K[lane][i * n + j]) * weight[j];
        rows[2 * vertex[i / 2 * BATCH + lane] + i % 2] += row;
      }
    }
  }
}

void ElementWeightedRows(const Model *model, const PetscReal *x, PetscReal *rows)
{
  for (int l = 0; l < DEFORMABLE_LISTS; l++)
    weighted_loop(model, model->mesh.elements + l, l % 2 ? 3 : 4, x, rows);
}

PetscErrorCode ElementStiffness(const Model *model, PetscReal *k)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < DEFORMABLE_LISTS; l++)
    stiffness_loop(model, model->mesh.elements + l, l % 2 ? 3 : 4, k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void mass_loop(const Model *model, const Elements *e, int n_nodes, PetscReal *m)
{
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    LanesVector X[4];
    Lanes area[4];
    Gather(n_nodes, model->mesh.X, vertex, X);
    ElementAreas(n_nodes, X, area);
    for (int lane = 0; lane < LANES; lane++) {
      const PetscReal density = model->materials.density[e->group[first + lane]] * model->materials.thickness;
      for (int i = 0; i < n_nodes; i++) m[vertex[i * BATCH + lane]] += density * area[i][lane];
    }
  }
}

PetscErrorCode ElementMasses(const Model *model, PetscReal *m)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < DEFORMABLE_LISTS; l++) mass_loop(model, model->mesh.elements + l, l % 2 ? 3 : 4, m);
  mass_loop(model, &model->mesh.condensed_q4, 4, m);
  mass_loop(model, &model->mesh.condensed_t3, 3, m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stresses and energies */

/* Gathers the modes of LANES elements: XM of the reference coordinates, uM of the displacements. */
static void gather_modes(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                         PetscInt first, LanesModes *XM, LanesModes *uM)
{
  LanesVector X[4], U[4];
  GatherBlocks(model, e, n_nodes, first, e->strain == STRAIN_LARGE, u, X, U);
  *XM = ElementModes(n_nodes, X);
  *uM = ElementModes(n_nodes, U);
}

/* Computes S at a point, for a block with a history at one of its points. */
static LanesTensor stress_at(const Elements *e, PetscInt first, int point, const LanesMaterial *m,
                             const LanesTensor *E)
{
  LanesTensor S;
  if (!e->history) return BlockStress(m, E);
  LawPointStress(e, first, point, E, &S);
  return S;
}

/* Computes the Cauchy stress at points of each element. stress: (n, n_points, 3). */
static void stress_loop(const Model *model, const Elements *e, int n_nodes, const PetscReal *u, int n_points,
                        const PetscReal points[][2], PetscReal *stress)
{
  const int large = e->strain == STRAIN_LARGE;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    LanesModes X, U;
    gather_modes(model, e, n_nodes, u, first, &X, &U);
    for (int p = 0; p < n_points; p++) {
      Lanes J;
      LanesGradient G;
      LanesTensor E;
      PointStrain(&X, &U, points[p][0], points[p][1], large, &J, &G, &E);
      const LanesTensor S = stress_at(e, first, p, &material, &E);
      LanesTensor sigma = CauchyStress(&G, &S, large);
      if (Any(material.one_point)) { // a block of one point has the stress of its centre everywhere
        PointStrain(&X, &U, 0., 0., large, &J, &G, &E);
        const LanesTensor S_c = stress_at(e, first, 0, &material, &E), centre = CauchyStress(&G, &S_c, large);
        sigma = (LanesTensor){Select(material.one_point, centre.xx, sigma.xx),
                              Select(material.one_point, centre.yy, sigma.yy),
                              Select(material.one_point, centre.xy, sigma.xy)};
      }
      for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++) {
        PetscReal *s = stress + 3 * ((first + lane) * n_points + p);
        s[0] = sigma.xx[lane], s[1] = sigma.yy[lane], s[2] = sigma.xy[lane];
      }
    }
  }
}

/* Computes the stress at the centre of blocks with a history: the mean of their points. */
static PetscErrorCode mean_stress(const Model *model, const Elements *e, const PetscReal *u,
                                  PetscReal *stress)
{
  PetscReal *points;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(12 * e->n, &points));
  stress_loop(model, e, 4, u, 4, Q4_POINTS, points);
  for (PetscInt i = 0; i < 3 * e->n; i++) {
    const PetscReal *s = points + 12 * (i / 3) + i % 3;
    stress[i] = 0.25 * ((s[0] + s[3]) + (s[6] + s[9]));
  }
  PetscCall(PetscFree(points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementStress(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *stress)
{
  /* (0, 0) is the centre of a quadrilateral; a triangle has the same strain everywhere */
  static const PetscReal centre[1][2] = {{0.0, 0.0}};

  PetscFunctionBeginUser;
  if (e->history && n_nodes == 4)
    PetscCall(mean_stress(model, e, u, stress));
  else
    stress_loop(model, e, n_nodes, u, 1, centre, stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementStressGauss(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                                  PetscReal *stress)
{
  PetscFunctionBeginUser;
  stress_loop(model, e, n_nodes, u, n_nodes == 4 ? 4 : 1, Q4_POINTS, stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementEnergy(const Model *model, const Elements *e, int n_nodes, const PetscReal *u,
                             PetscReal *energy)
{
  const int large = e->strain == STRAIN_LARGE;

  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    LanesModes X, U;
    Lanes sum, J;
    LanesGradient G;
    LanesTensor E;
    gather_modes(model, e, n_nodes, u, first, &X, &U);
    PointStrain(&X, &U, 0., 0., large, &J, &G, &E);
    if (e->history)
      LawEnergy(e, first, &X, &U, &sum);
    else
      sum = n_nodes == 4 ? Q4Energy(&X, &U, &material, large) : 0.5 * J * BlockEnergy(&material, &E);
    sum *= model->materials.thickness;
    for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++)
      energy[first + lane] = e->owned[first + lane] ? sum[lane] : 0.0; /* another rank counts it */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PrincipalStress(const PetscReal s[3], PetscReal principal[2], PetscReal *angle)
{
  const PetscReal mean = 0.5 * (s[0] + s[1]), half = 0.5 * (s[0] - s[1]), radius = hypot(half, s[2]);
  principal[0] = mean + radius;
  principal[1] = mean - radius;
  *angle = 0.5 * atan2(s[2], half);
}

/* ---- geometry */

/* Sums over the triangles (x_0, p, q) of the ring. A triangle whose third vertex is the origin has, with s =
   p + q and c = p x q, int dA = c/2, int x dA = c s/6, int x.x dA = c (p.p + p.q + q.q)/12. Vertex 0 of the
   block is taken as the origin, so that blocks far from 0, 0 lose no digits. */
void BlockGeometry(const PetscReal *X, const PetscInt *vertices, int n_nodes, PetscReal *area,
                   PetscReal centroid[2], PetscReal *polar)
{
  const PetscReal *origin = X + 2 * vertices[0];
  PetscReal A = 0, S[2] = {0, 0}, moment = 0;
  for (int i = 1; i + 1 < n_nodes; i++) {
    const PetscReal *P = X + 2 * vertices[i], *Q = X + 2 * vertices[i + 1];
    const PetscReal p[2] = {P[0] - origin[0], P[1] - origin[1]}, q[2] = {Q[0] - origin[0], Q[1] - origin[1]};
    const PetscReal c = p[0] * q[1] - p[1] * q[0];
    A += c / 2;
    for (int d = 0; d < 2; d++) {
      S[d] += c * (p[d] + q[d]) / 6;
      moment += c * (p[d] * p[d] + p[d] * q[d] + q[d] * q[d]) / 12;
    }
  }
  for (int d = 0; d < 2; d++) {
    moment -= S[d] * S[d] / A; /* Steiner's theorem: from vertex 0 to the centroid */
    centroid[d] = origin[d] + S[d] / A;
  }
  *area = A;
  *polar = moment;
}

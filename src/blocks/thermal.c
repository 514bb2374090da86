/* thermal.c: computes the forces of blocks with thermal expansion, and corrects their stresses. The stress
   of a block is S = C (E - E_t) = C E - s I, with the thermal strain E_t = expansion times change in the
   directions of the material. So the forces of the total strain are unchanged, and s adds

   f_i = int s F grad N_i dA,   F = I in small strain,

   to the applied forces. In bending, a block of one point stores p.C p/2 - P.p, where P comes of the
   change along the block: with sigma = E' h,x p_x for each of its two ways to bend (element_kernels.h),

   P = int E' alpha' change grad h dA = (1 - nu') int s grad h dA. */
#include "blocks/blocks.h"
#include "blocks/thermal_kernels.h"

/* Returns the field of a number at vertices times a number per group. */
static LanesScalar scalar_of(int n_nodes, const PetscReal *by_group, const PetscInt *group,
                             const PetscReal *at)
{
  const Lanes of = {by_group[group[0]], by_group[group[1]], by_group[group[2]], by_group[group[3]]};
  Lanes x[4] = {{0.}};
  for (int i = 0; i < n_nodes; i++) x[i] = of * LoadLanes(at + i * BATCH);
  return ScalarOf(n_nodes, x);
}

/* Returns the natural stress of s I: J s g_a . g_b. */
static LanesTensor isotropic(LanesVector X1, LanesVector X2, Lanes s)
{
  const Lanes r = s / VectorCross(X1, X2);
  return (LanesTensor){r * VectorDot(X2, X2), r * VectorDot(X1, X1), -r * VectorDot(X1, X2)};
}

static void full_force(const LanesVector X[4], const LanesVector u[4], const LanesScalar *s,
                       PetscReal thickness, int large, LanesVector f[4])
{
  const PetscReal w = 0.0625 * thickness; // as Q4Force
  const LanesModes XM = Q4FourModes(X), uM = Q4FourModes(u), x = large ? ModesAdd(&XM, &uM) : XM;
  LanesTensor T[4];
  for (int p = 0; p < 4; p++) {
    const PetscReal xi = p == 0 || p == 3 ? -GAUSS : GAUSS, eta = p < 2 ? -GAUSS : GAUSS;
    T[p] = isotropic(TangentXi(&XM, eta), TangentEta(&XM, xi), w * ScalarAt(s, xi, eta));
  }
  Q4Sum(T, x.a, x.b, VectorScale(GAUSS, x.h), f);
}

static void one_point_force(const LanesVector X[4], const LanesVector u[4], const LanesScalar *s,
                            const LanesMaterial *m, PetscReal thickness, int large, LanesVector f[4])
{
  const LanesModes XM = Q4Modes(X), uM = Q4Modes(u), x = large ? ModesAdd(&XM, &uM) : XM;
  const LanesTensor T = isotropic(XM.a, XM.b, s->mean);
  LanesHourglass o = Hourglass(&XM, &uM, &x, m);
  o.c = ThermalBending(s, &o, m);
  Q4OnePointSum(&XM, &x, &o, &T, thickness, large, f);
}

static void force(int n_nodes, const LanesVector *X, const LanesVector *u, const LanesScalar *s,
                  const LanesMaterial *m, PetscReal thickness, int large, LanesVector *f)
{
  LanesVector one[4];
  if (n_nodes == 3) {
    const LanesModes XM = T3Modes(X), uM = T3Modes(u), x = large ? ModesAdd(&XM, &uM) : XM;
    const LanesTensor T = isotropic(XM.a, XM.b, s->mean);
    T3Sum(&T, x.a, x.b, thickness, f);
    return;
  }
  full_force(X, u, s, thickness, large, f);
  if (!Any(m->one_point)) return;
  one_point_force(X, u, s, m, thickness, large, one);
  for (int i = 0; i < 4; i++)
    f[i] = (LanesVector){Select(m->one_point, one[i].x, f[i].x), Select(m->one_point, one[i].y, f[i].y)};
}

void ThermalForces(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   PetscReal factor, const PetscReal *u, PetscReal *f)
{
  const int n_nodes = e->n_nodes, large = e->strain == STRAIN_LARGE;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    const LanesScalar s = scalar_of(n_nodes, s_1, e->group + first, change + (vertex - e->vertex));
    LanesVector X[4], U[4], F[4];
    GatherBlocks(model, e, n_nodes, first, large, u, X, U);
    force(n_nodes, X, U, &s, &material, factor * model->materials.thickness, large, F);
    for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++)
      for (int i = 0; i < n_nodes; i++) {
        const PetscInt v = vertex[i * BATCH + lane];
        if (v >= model->mesh.n_owned ||
            (model->materials.absent && model->materials.absent[e->group[first + lane]]))
          continue;
        f[2 * v] += F[i].x[lane], f[2 * v + 1] += F[i].y[lane];
      }
  }
}

/* ---- corrections of results */

static void modes_of(const Model *model, const Elements *e, const PetscReal *u, PetscInt first, LanesModes *X,
                     LanesModes *U)
{
  LanesVector x[4], v[4];
  GatherBlocks(model, e, e->n_nodes, first, e->strain == STRAIN_LARGE, u, x, v);
  *X = ElementModes(e->n_nodes, x);
  *U = ElementModes(e->n_nodes, v);
}

void ThermalStress(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *change,
                   const PetscReal *u, int n_points, PetscReal *stress)
{
  const int large = e->strain == STRAIN_LARGE;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    const LanesScalar s = scalar_of(e->n_nodes, s_1, e->group + first,
                                    change + (LaneVertices(e, e->n_nodes, first) - e->vertex));
    LanesModes X, U;
    modes_of(model, e, u, first, &X, &U);
    for (int p = 0; p < n_points; p++) {
      const PetscReal xi = n_points == 1      ? 0.
                           : p == 0 || p == 3 ? -GAUSS
                                              : GAUSS,
                      eta = n_points == 1 ? 0.
                            : p < 2       ? -GAUSS
                                          : GAUSS;
      Lanes J;
      LanesGradient G, G_c;
      LanesTensor E;
      PointStrain(&X, &U, xi, eta, large, &J, &G, &E);
      PointStrain(&X, &U, 0., 0., large, &J, &G_c, &E);
      const Lanes full = ScalarAt(&s, xi, eta);
      const LanesTensor S = {full, full, {0.}}, S_c = {s.mean, s.mean, {0.}};
      const LanesTensor here = CauchyStress(&G, &S, large), centre = CauchyStress(&G_c, &S_c, large);
      for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++) {
        PetscReal *at = stress + 3 * ((first + lane) * n_points + p);
        const LanesTensor *t = material.one_point[lane] ? &centre : &here;
        at[0] -= t->xx[lane], at[1] -= t->yy[lane], at[2] -= t->xy[lane];
      }
    }
  }
}

/* Corrects the energy: W(E - E_t) = W(E) - s tr E + E_t : C E_t / 2, and E_t : C E_t is s times own_1
   change. */
void ThermalEnergy(const Model *model, const Elements *e, const PetscReal *s_1, const PetscReal *own_1,
                   const PetscReal *change, const PetscReal *u, PetscReal *energy)
{
  const int large = e->strain == STRAIN_LARGE, n_nodes = e->n_nodes, n_points = n_nodes == 4 ? 4 : 1;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first), *group = e->group + first;
    const PetscReal *at = change + (vertex - e->vertex);
    const LanesMaterial material = LoadMaterial(model, group);
    const LanesScalar s = scalar_of(n_nodes, s_1, group, at), t = scalar_of(n_nodes, own_1, group, at);
    LanesModes X, U;
    Lanes sum[2] = {{0.}, {0.}}, J;
    LanesGradient G;
    LanesTensor E;
    modes_of(model, e, u, first, &X, &U);
    for (int p = 0; p < n_points; p++) {
      const PetscReal xi = n_nodes == 3       ? 0.
                           : p == 0 || p == 3 ? -GAUSS
                                              : GAUSS,
                      eta = n_nodes == 3 ? 0.
                            : p < 2      ? -GAUSS
                                         : GAUSS;
      const Lanes s_p = ScalarAt(&s, xi, eta), t_p = ScalarAt(&t, xi, eta);
      PointStrain(&X, &U, xi, eta, large, &J, &G, &E);
      sum[0] += (n_nodes == 3 ? 0.5 : 1.) * J * (0.5 * s_p * t_p - s_p * (E.xx + E.yy));
    }
    const Mask one_point = n_nodes == 4 ? material.one_point : (Mask){0};
    if (Any(one_point)) {
      const LanesModes x = large ? ModesAdd(&X, &U) : X;
      const LanesHourglass o = Hourglass(&X, &U, &x, &material);
      PointStrain(&X, &U, 0., 0., large, &J, &G, &E);
      sum[1] = 4. * J * (0.5 * s.mean * t.mean - s.mean * (E.xx + E.yy)) +
               ThermalBendingEnergy(&s, &o, &material);
    }
    for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++)
      if (e->owned[first + lane])
        energy[first + lane] += model->materials.thickness * sum[one_point[lane] ? 1 : 0][lane];
  }
}

void ThermalMean(const Elements *e, const PetscReal *change, PetscReal *mean)
{
  for (PetscInt i = 0; i < e->n; i++) {
    mean[i] = 0.;
    for (int k = 0; k < e->n_nodes; k++) mean[i] += change[VertexPlace(e, i, k)] / e->n_nodes;
  }
}

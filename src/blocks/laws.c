/* laws.c: holds the table of material laws with a history, and loops over their blocks. */
#include "blocks/law_kernels.h"

/* ---- the table */

/* Computes the constants of mohr_coulomb.h. Edge s1 = s2 = x, s3 = slope x - step: the plastic strain
   C^-1 (t - s) has (e1 + e2)(1 - sin psi) + e3 (1 + sin psi) = 0, which is linear in x; likewise the
   other edge. */
static void mohr_coulomb(const Material *m, Lame lame, PetscReal c[LAW_CONSTANTS])
{
  const PetscReal degree = PETSC_PI / 180., sin_phi = sin(m->friction * degree),
                  sin_psi = sin(m->dilation * degree), nu = m->poisson, two_mu = 2. * lame.mu;
  const PetscReal plus = 1. + sin_phi, minus = 1. - sin_phi, out = 1. + sin_psi, in = 1. - sin_psi;
  const PetscReal shear = 2. * m->cohesion * cos(m->friction * degree),
                  apex = sin_phi > 0. ? shear / (2. * sin_phi) : PETSC_INFINITY;
  const PetscReal pressure = 2. * sin_psi * lame.lambda,
                  flow[3] = {two_mu * out + pressure, pressure, pressure - two_mu * in};
  const PetscReal stiff = plus * flow[0] - minus * flow[2], slope = plus / minus;
  const PetscReal p = (1. - nu) * in - nu * out, q = out - 2. * nu * in, r = (1. - nu) * out - nu * in,
                  s = in - 2. * nu * out;
  c[MC_PLUS] = plus, c[MC_MINUS] = minus, c[MC_SHEAR] = shear;
  c[MC_CUT] = PetscMin(isnan(m->tension) ? apex : m->tension, apex);
  for (int i = 0; i < 3; i++) c[MC_FLOW1 + i] = flow[i] / stiff;
  c[MC_SLOPE] = slope, c[MC_STEP] = shear / minus;
  c[MC_A12] = p / (2. * p + q * slope), c[MC_A3] = q / (2. * p + q * slope);
  c[MC_B23] = r / (2. * slope * r + s), c[MC_B1] = s / (2. * slope * r + s);
  c[MC_NU] = nu, c[MC_SIDE] = nu / (1. - nu), c[MC_SOFT] = 1. / m->young;
}

/* Computes the constants of damage.h. */
static void damage(const Material *m, Lame lame, PetscReal c[LAW_CONSTANTS])
{
  const PetscReal nu = m->poisson;
  c[DM_ONSET] = m->tension / m->young, c[DM_STRENGTH] = m->tension;
  c[DM_BAND] = m->fracture_energy * (lame.lambda + 2. * lame.mu) / (m->young * m->tension);
  c[DM_LINEAR] = m->softening == SOFTENING_LINEAR;
  c[DM_YOUNG] = m->young, c[DM_SOFT] = 1. / m->young, c[DM_NU] = nu, c[DM_SIDE] = nu / (1. - nu);
}

/* Returns the width at which B of damage.h is 0. */
static PetscReal damage_widest(const PetscReal c[LAW_CONSTANTS])
{
  return 2. * c[DM_BAND] / c[DM_ONSET];
}

const LawKind LawKinds[MATERIAL_LAWS] = {
    [MATERIAL_MOHR_COULOMB] = {"mohr_coulomb", "plastic_strain", MC_WIDTH, mohr_coulomb, NULL},
    [MATERIAL_DAMAGE] = {"damage", "damage", DM_NUMBERS, damage, damage_widest},
};

const char *LawMeasure(MaterialLaw law)
{
  return LawKinds[law].measure;
}

/* ---- forces */

/* Loads the history of LANES blocks, of the last equilibrium or of now. */
KERNEL LanesHistory LoadHistory(const LawHistory *h, PetscInt first, int width, int now, int keep)
{
  const PetscInt at = first * h->points * width;
  return (LanesHistory){(now ? h->now : h->committed) + at, keep ? h->now + at : NULL, ~(Mask){0}};
}

/* Returns E_t of LANES blocks in the plane. share: of each row of the scene. */
KERNEL LanesScalar WarmthOf(const Elements *e, int n_nodes, const LanesLaw *c, PetscInt first,
                            const PetscReal *share)
{
  const LawHeat *heat = &e->history->heat;
  const Lanes expansion = LawConstant(c, LAW_EXPANSION);
  const ptrdiff_t at = LaneVertices(e, n_nodes, first) - e->vertex;
  Lanes x[4] = {{0.}};
  for (PetscInt k = 0; k < heat->n; k++)
    for (int i = 0; i < n_nodes; i++)
      x[i] += share[heat->load[k]] * LoadLanes(heat->change[k] + at + i * BATCH);
  for (int i = 0; i < n_nodes; i++) x[i] *= expansion;
  return ScalarOf(n_nodes, x);
}

/* Returns the present E_t; NULL: these blocks have no temperatures. */
KERNEL const LanesScalar *WarmthNow(const Elements *e, int n_nodes, const LanesLaw *c, PetscInt first,
                                    LanesScalar *room)
{
  if (!e->history->heat.n) return NULL;
  *room = WarmthOf(e, n_nodes, c, first, e->history->heat.share[SHARE_NOW]);
  return room;
}

KERNEL void LawLoop(int law, int warmed, const Model *model, const Elements *e, int n_nodes, int large,
                    int keep, const PetscReal *restrict u, PetscReal *restrict f)
{
  const LawHistory *h = e->history;
  PetscReal mixed[LAW_CONSTANTS * LANES];
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesLaw c = LoadLaw(h, e->group + first, mixed);
    const LanesMaterial material = MaterialOf(&c);
    LanesHistory history = LoadHistory(h, first, LawWidth(law), h->in_time, keep);
    LanesVector X[4], U[4], F[4];
    LanesScalar warm;
    GatherBlocks(model, e, n_nodes, first, large, u, X, U);
    LawBlock(law, n_nodes, &c, &material, X, U, model->materials.thickness, large,
             warmed ? WarmthNow(e, n_nodes, &c, first, &warm) : NULL, &history, F);
    ScatterAdd(n_nodes, F, vertex, f);
  }
}

/* Passes law, shape and the presence of temperatures as constants to LawLoop. */
KERNEL void EachLaw(int warmed, const Model *model, const Elements *e, int keep, const PetscReal *u,
                    PetscReal *f)
{
  const int large = e->strain == STRAIN_LARGE;
  if (e->law == MATERIAL_MOHR_COULOMB && e->n_nodes == 4)
    LawLoop(MATERIAL_MOHR_COULOMB, warmed, model, e, 4, large, keep, u, f);
  else if (e->law == MATERIAL_MOHR_COULOMB)
    LawLoop(MATERIAL_MOHR_COULOMB, warmed, model, e, 3, large, keep, u, f);
  else if (e->law == MATERIAL_DAMAGE && e->n_nodes == 4)
    LawLoop(MATERIAL_DAMAGE, warmed, model, e, 4, large, keep, u, f);
  else if (e->law == MATERIAL_DAMAGE)
    LawLoop(MATERIAL_DAMAGE, warmed, model, e, 3, large, keep, u, f);
}

KERNEL void LawsLoop_code(const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f)
{
  EachLaw(0, model, e, keep, u, f);
}

KERNEL void WarmLaws_code(const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f)
{
  EachLaw(1, model, e, keep, u, f);
}

VARIANTS(LawsLoop, (const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f),
         (model, e, keep, u, f))
VARIANTS(WarmLaws, (const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f),
         (model, e, keep, u, f))

void LawForces(const Model *model, const Elements *e, PetscBool keep, const PetscReal *u, PetscReal *f)
{
  const int kept = keep || e->history->in_time;
  if (e->history->heat.n)
    WarmLaws(model, e, kept, u, f);
  else
    LawsLoop(model, e, kept, u, f);
}

/* ---- the tangent */

static const PetscReal STEP = 1e-7; /* of central differences, as a fraction of a side */

/* Gathers LANES blocks. share: of temperatures. */
static void block_of(const Model *model, const Elements *e, PetscInt first, const PetscReal *share,
                     LanesHistory history, const LanesVector X[4], const LanesVector U[4], LanesVector F[4])
{
  PetscReal mixed[LAW_CONSTANTS * LANES];
  const LanesLaw c = LoadLaw(e->history, e->group + first, mixed);
  const LanesMaterial material = MaterialOf(&c);
  const int large = e->strain == STRAIN_LARGE, n_nodes = e->n_nodes;
  LanesScalar room;
  const LanesScalar *warm = NULL;
  if (e->history->heat.n) room = WarmthOf(e, n_nodes, &c, first, share), warm = &room;
  if (e->law == MATERIAL_MOHR_COULOMB)
    LawBlock(MATERIAL_MOHR_COULOMB, n_nodes, &c, &material, X, U, model->materials.thickness, large, warm,
             &history, F);
  if (e->law == MATERIAL_DAMAGE)
    LawBlock(MATERIAL_DAMAGE, n_nodes, &c, &material, X, U, model->materials.thickness, large, warm, &history,
             F);
}

/* Returns the history for the stiffness of cracking blocks: damage as at U, without further growth. This
   secant is never below the tangent, so an iteration with it finds only stable equilibria; with the
   tangent it would find others too. frozen: work space. */
static LanesHistory freeze(const Model *model, const Elements *e, PetscInt first, const PetscReal *share,
                           LanesHistory committed, const LanesVector X[4], const LanesVector U[4],
                           PetscReal *frozen)
{
  const int width = LawKinds[e->law].width, points = e->history->points;
  LanesVector F[4];
  committed.to = frozen;
  block_of(model, e, first, share, committed, X, U, F);
  for (int k = 0; k < points; k++)
    for (int lane = 0; lane < LANES; lane++)
      frozen[LANES * (width * k + DM_KAPPA) + lane] = 0.5 * PETSC_MAX_REAL;
  return (LanesHistory){frozen, NULL, committed.here};
}

void LawMatrices(const Model *model, const Elements *e, PetscInt first, const PetscReal *u, PetscReal K[][64])
{
  const int n_nodes = e->n_nodes;
  LanesVector X[4], U[4], F[2][4];
  GatherBlocks(model, e, n_nodes, first, e->strain == STRAIN_LARGE, u, X, U);
  PetscReal frozen[4 * HISTORY_MOST * LANES];
  const PetscReal *share = e->history->heat.n ? e->history->heat.share[SHARE_NOW] : NULL;
  LanesHistory history = LoadHistory(e->history, first, LawKinds[e->law].width, e->history->in_time, 0);
  if (e->law == MATERIAL_DAMAGE) history = freeze(model, e, first, share, history, X, U, frozen);
  const LanesVector side = VectorSubtract(X[1], X[0]);
  const Lanes h = STEP * SquareRoot(VectorDot(side, side));
  for (int column = 0; column < 2 * n_nodes; column++) {
    for (int k = 0; k < 2; k++) {
      LanesVector moved[4];
      memcpy(moved, U, sizeof moved);
      Lanes *x = column % 2 ? &moved[column / 2].y : &moved[column / 2].x;
      *x = k ? *x - h : *x + h;
      block_of(model, e, first, share, history, X, moved, F[k]);
    }
    for (int i = 0; i < n_nodes; i++) {
      const LanesVector d = VectorSubtract(F[0][i], F[1][i]);
      for (int lane = 0; lane < LANES; lane++) {
        K[lane][(2 * i) * 2 * n_nodes + column] = d.x[lane] / (2. * h[lane]);
        K[lane][(2 * i + 1) * 2 * n_nodes + column] = d.y[lane] / (2. * h[lane]);
      }
    }
  }
}

/* ---- the path of a step */

/* Returns the place of a number of a point of a block in a history. */
static PetscInt place_of(const LawHistory *h, PetscInt block, int point, int number)
{
  return ((block / LANES * h->points + point) * h->width + number) * LANES + block % LANES;
}

/* Decides whether a block has dissipated since the last equilibrium. */
static PetscBool has_lost(const LawHistory *h, PetscInt block)
{
  for (int k = 0; k < h->points; k++) {
    const PetscInt at = place_of(h, block, k, HISTORY_LOST);
    if (h->now[at] > h->committed[at]) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscReal most_measure(const LawHistory *h, PetscInt block)
{
  PetscReal most = 0.;
  for (int k = 0; k < h->points; k++) most = PetscMax(most, h->now[place_of(h, block, k, HISTORY_MEASURE)]);
  return most;
}

/* Computes forces of LANES blocks at the end of n equal steps from U_0 to U, and from the temperatures
   share_0 to the present ones, from the committed history. */
static void in_steps(const Model *model, const Elements *e, PetscInt first, int n, const LawSteps *from,
                     const LanesVector X[4], const LanesVector U_0[4], const LanesVector U[4],
                     LanesVector F[4])
{
  const LawHeat *heat = &e->history->heat;
  PetscReal way[2][4 * HISTORY_MOST * LANES];
  LanesHistory h = LoadHistory(e->history, first, LawKinds[e->law].width, 0, 0);
  for (int step = 1; step <= n; step++) {
    const PetscReal part = (PetscReal)step / n;
    LanesVector at[4];
    for (int i = 0; i < e->n_nodes; i++)
      at[i] = (LanesVector){U_0[i].x + part * (U[i].x - U_0[i].x), U_0[i].y + part * (U[i].y - U_0[i].y)};
    for (PetscInt k = 0; k < heat->n; k++) {
      const PetscReal begins = from->share_0[heat->load[k]], ends = heat->share[SHARE_NOW][heat->load[k]];
      from->share[heat->load[k]] = begins + part * (ends - begins);
    }
    h.to = way[step % 2];
    memcpy(h.to, h.from, LANES * e->history->points * LawKinds[e->law].width * sizeof *h.to);
    block_of(model, e, first, from->share, h, X, at, F);
    h.from = h.to;
  }
}

static void compare(const Elements *e, PetscInt b, const LanesVector *one, const LanesVector *more,
                    LawSteps *steps)
{
  const int lane = (int)(b % LANES);
  PetscReal most = 0., apart = 0.;
  for (int i = 0; i < e->n_nodes; i++) {
    most = PetscMax(most, hypot(one[i].x[lane], one[i].y[lane]));
    apart = PetscMax(apart, hypot(more[i].x[lane] - one[i].x[lane], more[i].y[lane] - one[i].y[lane]));
  }
  const PetscReal fraction = most > 0. ? apart / most : 0.;
  steps->n[0]++, steps->n[1] += fraction > steps->warns;
  if (fraction > steps->fraction || (fraction == steps->fraction && e->file[b] > steps->block))
    steps->fraction = fraction, steps->block = e->file[b];
}

void LawsInSteps(const Model *model, const PetscReal *u_0, const PetscReal *u, LawSteps *steps)
{
  for (const Elements *e = model->mesh.elements + ELASTIC_LISTS; e < model->mesh.elements + DEFORMABLE_LISTS;
       e++)
    for (PetscInt b = 0; b < e->n && e->history; b++) {
      if (!e->owned[b] || !has_lost(e->history, b)) continue;
      if (e->law == MATERIAL_MOHR_COULOMB)
        steps->plastic = PetscMax(steps->plastic, most_measure(e->history, b));
      const PetscInt first = b - b % LANES;
      const int large = e->strain == STRAIN_LARGE;
      LanesVector X[4], U_0[4], U[4], one[4], more[4];
      GatherBlocks(model, e, e->n_nodes, first, large, u_0, X, U_0);
      GatherBlocks(model, e, e->n_nodes, first, large, u, X, U);
      in_steps(model, e, first, 1, steps, X, U_0, U, one);
      in_steps(model, e, first, LAW_STEPS, steps, X, U_0, U, more);
      compare(e, b, one, more, steps);
    }
}

PetscBool LawsCrack(const Model *model)
{
  for (const Elements *e = model->mesh.elements + ELASTIC_LISTS; e < model->mesh.elements + DEFORMABLE_LISTS;
       e++)
    for (PetscInt b = 0; b < e->n && e->history && e->law == MATERIAL_DAMAGE; b++)
      if (has_lost(e->history, b)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- stresses and energies of the present history */

/* State of a point of LANES blocks without its strain. warm: NULL: none. */
typedef struct {
  PetscReal mixed[LAW_CONSTANTS * LANES];
  LanesLaw law;
  LanesMaterial material;
  Lanes from[HISTORY_MOST];
  LanesScalar room;
  const LanesScalar *warm;
  LanesThermal thermal;
} SeenPoint;

/* Decides per lane whether the point is at the centre of the block. */
KERNEL Mask AtCentre(const Elements *e, const LanesMaterial *m)
{
  return e->n_nodes == 3 ? ~(Mask){0} : m->one_point;
}

static const PetscReal POINTS[4][2] = {{-GAUSS, -GAUSS}, {GAUSS, -GAUSS}, {GAUSS, GAUSS}, {-GAUSS, GAUSS}};

KERNEL void SeeAt(const Elements *e, PetscInt first, int point, SeenPoint *p)
{
  const int width = LawKinds[e->law].width;
  const LanesHistory block = LoadHistory(e->history, first, width, 1, 0);
  p->law = LoadLaw(e->history, e->group + first, p->mixed);
  p->material = MaterialOf(&p->law);
  for (int i = 0; i < HISTORY_MOST; i++)
    p->from[i] = i < width ? LoadLanes(block.from + LANES * (width * point + i)) : LanesOf(0.);
  p->warm = WarmthNow(e, e->n_nodes, &p->law, first, &p->room);
  if (!p->warm) return;
  const Lanes at = ScalarAt(p->warm, POINTS[point][0], POINTS[point][1]);
  p->thermal = ThermalOf(&p->law, Select(AtCentre(e, &p->material), p->warm->mean, at));
}

KERNEL LanesStress StrainSeen(const SeenPoint *p, const LanesTensor *E)
{
  return StrainOfLaw(E, p->warm ? &p->thermal : NULL);
}

KERNEL LanesStress StressSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E, Lanes *whole)
{
  const LanesStress e = StrainSeen(p, E);
  *whole = LanesOf(1.);
  if (law == MATERIAL_MOHR_COULOMB)
    return LawStress(MATERIAL_MOHR_COULOMB, &p->law, &e, NULL, p->from, NULL, whole);
  if (law == MATERIAL_DAMAGE) return LawStress(MATERIAL_DAMAGE, &p->law, &e, NULL, p->from, NULL, whole);
  return (LanesStress){{0.}, {0.}, {0.}, {0.}};
}

KERNEL Lanes StoredSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E, Lanes *opening)
{
  const LanesStress e = StrainSeen(p, E);
  *opening = LanesOf(0.);
  if (law == MATERIAL_MOHR_COULOMB) return LawStored(MATERIAL_MOHR_COULOMB, &p->law, &e, p->from, opening);
  if (law == MATERIAL_DAMAGE) return LawStored(MATERIAL_DAMAGE, &p->law, &e, p->from, opening);
  return LanesOf(0.);
}

void LawPointStress(const Elements *e, PetscInt first, int point, const LanesTensor *E, LanesTensor *S)
{
  SeenPoint p;
  SeeAt(e, first, point < e->history->points ? point : 0, &p);
  Lanes whole;
  const LanesStress s = StressSeen(e->law, &p, E, &whole);
  const Lanes thermal = p.warm ? p.thermal.s : LanesOf(0.);
  *S = (LanesTensor){s.xx + thermal, s.yy + thermal, s.xy};
}

/* Returns the area of a point at the centre: the whole block. */
KERNEL Lanes AreaOfCentre(const Elements *e, Lanes J, int point)
{
  return e->n_nodes == 3 ? 0.5 * J : point ? LanesOf(0.) : 4. * J;
}

/* Computes the area of a point, and the strain there. */
KERNEL Lanes AreaAt(const Elements *e, const LanesMaterial *m, const LanesModes *X, const LanesModes *u,
                    int k, LanesTensor *E)
{
  const int large = e->strain == STRAIN_LARGE;
  const Mask centre = AtCentre(e, m);
  Lanes J, J_c;
  LanesGradient G;
  LanesTensor E_c;
  PointStrain(X, u, POINTS[k][0], POINTS[k][1], large, &J, &G, E);
  PointStrain(X, u, 0., 0., large, &J_c, &G, &E_c);
  *E = (LanesTensor){Select(centre, E_c.xx, E->xx), Select(centre, E_c.yy, E->yy),
                     Select(centre, E_c.xy, E->xy)};
  return Select(centre, AreaOfCentre(e, J_c, k), J);
}

void LawEnergy(const Elements *e, PetscInt first, const LanesModes *X, const LanesModes *u, Lanes *stored)
{
  *stored = LanesOf(0.);
  for (int k = 0; k < e->history->points; k++) {
    SeenPoint p;
    SeeAt(e, first, k, &p);
    Lanes whole, opening;
    LanesTensor E;
    const Lanes area = AreaAt(e, &p.material, X, u, k, &E);
    *stored += area * StoredSeen(e->law, &p, &E, &opening);
    if (p.warm) *stored += area * ThermalStored(&E, &p.thermal);
    if (k || e->n_nodes == 3 || !Any(p.material.one_point)) continue;
    const LanesModes x = e->strain == STRAIN_LARGE ? ModesAdd(X, u) : *X;
    const LanesHourglass o = Hourglass(X, u, &x, &p.material);
    (void)StressSeen(e->law, &p, &E, &whole);
    const Lanes all = BendingStored(&p.law, &p.material, p.warm, &o), applied = all - VectorDot(o.p, o.c);
    *stored += Keep(p.material.one_point, 0.5 * (whole * all - applied));
  }
}

void LawReport(const Model *model, const Elements *e, const PetscReal *u, LawReported *reports)
{
  for (PetscInt i = 0; i < e->n; i++) reports[i] = (LawReported){0., -1., 0.};
  for (PetscInt first = 0; first < e->n; first += LANES) {
    LanesVector V[4], U[4];
    GatherBlocks(model, e, e->n_nodes, first, e->strain == STRAIN_LARGE, u, V, U);
    const LanesModes X = ElementModes(e->n_nodes, V), uM = ElementModes(e->n_nodes, U);
    for (int k = 0; k < e->history->points; k++) {
      SeenPoint p;
      SeeAt(e, first, k, &p);
      Lanes opening;
      LanesTensor E;
      const Lanes lost = model->materials.thickness * AreaAt(e, &p.material, &X, &uM, k, &E) *
                         p.from[HISTORY_LOST];
      (void)StoredSeen(e->law, &p, &E, &opening);
      for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++) {
        LawReported *t = reports + first + lane;
        t->lost += lost[lane];
        t->measure = PetscMax(t->measure, p.from[HISTORY_MEASURE][lane]);
        t->opening = PetscMax(t->opening, opening[lane]);
      }
    }
  }
}

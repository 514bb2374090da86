/* laws.c: the table of material laws with a history, and the loops over their blocks. */
#include "forces/blocks/law_kernels.h"

/* ---- the table */

/* See mohr_coulomb.h. Edge s1 = s2 = x, s3 = slope x - step: the plastic strain C^-1 (t - s) has
   (e1 + e2)(1 - sin psi) + e3 (1 + sin psi) = 0, which is linear in x; likewise the other edge. */
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

/* See damage.h. */
static void damage(const Material *m, Lame lame, PetscReal c[LAW_CONSTANTS])
{
  const PetscReal nu = m->poisson;
  c[DM_ONSET] = m->tension / m->young, c[DM_STRENGTH] = m->tension;
  c[DM_BAND] = m->fracture_energy * (lame.lambda + 2. * lame.mu) / (m->young * m->tension);
  c[DM_LINEAR] = m->softening == SOFTENING_LINEAR;
  c[DM_YOUNG] = m->young, c[DM_SOFT] = 1. / m->young, c[DM_NU] = nu, c[DM_SIDE] = nu / (1. - nu);
}

/* B of damage.h is 0 there. */
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

/* The history of LANES blocks, from the last equilibrium or from now. */
KERNEL LanesHistory LoadHistory(const LawHistory *h, PetscInt first, int width, int now, int keep)
{
  const PetscInt at = first * h->points * width;
  return (LanesHistory){(now ? h->now : h->held) + at, keep ? h->now + at : NULL, ~(Mask){0}};
}

KERNEL void LawLoop(int law, const Model *model, const Elements *e, int n_nodes, int large, int keep,
                    const PetscReal *restrict u, PetscReal *restrict f)
{
  const LawHistory *h = e->history;
  PetscReal mixed[LAW_CONSTANTS * LANES];
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesLaw c = LoadLaw(h, e->group + first, mixed);
    const LanesMaterial material = MaterialOf(&c);
    LanesHistory history = LoadHistory(h, first, LawWidth(law), h->in_time, keep);
    LanesVector X[4], U[4], F[4];
    GatherBlocks(model, e, n_nodes, first, large, u, X, U);
    LawBlock(law, n_nodes, &c, &material, X, U, model->thickness, large, &history, F);
    ScatterAdd(n_nodes, F, vertex, f);
  }
}

/* Gives LawLoop law and shape as constants. */
KERNEL void LawsLoop_code(const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f)
{
  const int large = e->strain == STRAIN_LARGE;
  if (e->law == MATERIAL_MOHR_COULOMB && e->n_nodes == 4)
    LawLoop(MATERIAL_MOHR_COULOMB, model, e, 4, large, keep, u, f);
  else if (e->law == MATERIAL_MOHR_COULOMB)
    LawLoop(MATERIAL_MOHR_COULOMB, model, e, 3, large, keep, u, f);
  else if (e->law == MATERIAL_DAMAGE && e->n_nodes == 4)
    LawLoop(MATERIAL_DAMAGE, model, e, 4, large, keep, u, f);
  else if (e->law == MATERIAL_DAMAGE)
    LawLoop(MATERIAL_DAMAGE, model, e, 3, large, keep, u, f);
}

VARIANTS(LawsLoop, (const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f),
         (model, e, keep, u, f))

void LawForces(const Model *model, const Elements *e, PetscBool keep, const PetscReal *u, PetscReal *f)
{
  LawsLoop(model, e, keep || e->history->in_time, u, f);
}

/* ---- the tangent */

static const PetscReal STEP = 1e-7; /* of central differences, as a fraction of a side */

static void block_of(const Model *model, const Elements *e, PetscInt first, LanesHistory history,
                     const LanesVector X[4], const LanesVector U[4], LanesVector F[4])
{
  PetscReal mixed[LAW_CONSTANTS * LANES];
  const LanesLaw c = LoadLaw(e->history, e->group + first, mixed);
  const LanesMaterial material = MaterialOf(&c);
  const int large = e->strain == STRAIN_LARGE;
  if (e->law == MATERIAL_MOHR_COULOMB)
    LawBlock(MATERIAL_MOHR_COULOMB, e->n_nodes, &c, &material, X, U, model->thickness, large, &history, F);
  if (e->law == MATERIAL_DAMAGE)
    LawBlock(MATERIAL_DAMAGE, e->n_nodes, &c, &material, X, U, model->thickness, large, &history, F);
}

/* The history from which the stiffness of blocks that crack is taken: damage as it is at U, and so that it
   does not grow. This secant is never below the tangent, so an iteration with it comes only to equilibria
   that are stable; with the tangent it would come to others too. frozen: room for it. */
static LanesHistory freeze(const Model *model, const Elements *e, PetscInt first, LanesHistory held,
                           const LanesVector X[4], const LanesVector U[4], PetscReal *frozen)
{
  const int width = LawKinds[e->law].width, points = e->history->points;
  LanesVector F[4];
  held.to = frozen;
  block_of(model, e, first, held, X, U, F);
  for (int k = 0; k < points; k++)
    for (int lane = 0; lane < LANES; lane++)
      frozen[LANES * (width * k + DM_KAPPA) + lane] = 0.5 * PETSC_MAX_REAL;
  return (LanesHistory){frozen, NULL, held.here};
}

void LawMatrices(const Model *model, const Elements *e, PetscInt first, const PetscReal *u, PetscReal K[][64])
{
  const int n_nodes = e->n_nodes;
  LanesVector X[4], U[4], F[2][4];
  GatherBlocks(model, e, n_nodes, first, e->strain == STRAIN_LARGE, u, X, U);
  PetscReal frozen[4 * HISTORY_MOST * LANES];
  LanesHistory history = LoadHistory(e->history, first, LawKinds[e->law].width, e->history->in_time, 0);
  if (e->law == MATERIAL_DAMAGE) history = freeze(model, e, first, history, X, U, frozen);
  const LanesVector side = VectorSubtract(X[1], X[0]);
  const Lanes h = STEP * SquareRoot(VectorDot(side, side));
  for (int column = 0; column < 2 * n_nodes; column++) {
    for (int k = 0; k < 2; k++) {
      LanesVector moved[4];
      memcpy(moved, U, sizeof moved);
      Lanes *x = column % 2 ? &moved[column / 2].y : &moved[column / 2].x;
      *x = k ? *x - h : *x + h;
      block_of(model, e, first, history, X, moved, F[k]);
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

/* ---- the way of a step */

/* Where a number of a point of a block stands in a history. */
static PetscInt place_of(const LawHistory *h, PetscInt block, int point, int number)
{
  return ((block / LANES * h->points + point) * h->width + number) * LANES + block % LANES;
}

/* Whether a block has lost more than at the last equilibrium. */
static PetscBool has_lost(const LawHistory *h, PetscInt block)
{
  for (int k = 0; k < h->points; k++) {
    const PetscInt at = place_of(h, block, k, HISTORY_LOST);
    if (h->now[at] > h->held[at]) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscReal most_measure(const LawHistory *h, PetscInt block)
{
  PetscReal most = 0.;
  for (int k = 0; k < h->points; k++) most = PetscMax(most, h->now[place_of(h, block, k, HISTORY_MEASURE)]);
  return most;
}

/* Forces of LANES blocks at the end of n even steps from U_0 to U, from the held history. */
static void in_steps(const Model *model, const Elements *e, PetscInt first, int n, const LanesVector X[4],
                     const LanesVector U_0[4], const LanesVector U[4], LanesVector F[4])
{
  PetscReal way[2][4 * HISTORY_MOST * LANES];
  LanesHistory h = LoadHistory(e->history, first, LawKinds[e->law].width, 0, 0);
  for (int step = 1; step <= n; step++) {
    const PetscReal part = (PetscReal)step / n;
    LanesVector at[4];
    for (int i = 0; i < e->n_nodes; i++)
      at[i] = (LanesVector){U_0[i].x + part * (U[i].x - U_0[i].x), U_0[i].y + part * (U[i].y - U_0[i].y)};
    h.to = way[step % 2];
    memcpy(h.to, h.from, LANES * e->history->points * LawKinds[e->law].width * sizeof *h.to);
    block_of(model, e, first, h, X, at, F);
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
  for (const Elements *e = model->elements + ELASTIC_LISTS; e < model->elements + DEFORMABLE_LISTS; e++)
    for (PetscInt b = 0; b < e->n && e->history; b++) {
      if (!e->owned[b] || !has_lost(e->history, b)) continue;
      if (e->law == MATERIAL_MOHR_COULOMB)
        steps->plastic = PetscMax(steps->plastic, most_measure(e->history, b));
      const PetscInt first = b - b % LANES;
      const int large = e->strain == STRAIN_LARGE;
      LanesVector X[4], U_0[4], U[4], one[4], more[4];
      GatherBlocks(model, e, e->n_nodes, first, large, u_0, X, U_0);
      GatherBlocks(model, e, e->n_nodes, first, large, u, X, U);
      in_steps(model, e, first, 1, X, U_0, U, one);
      in_steps(model, e, first, LAW_STEPS, X, U_0, U, more);
      compare(e, b, one, more, steps);
    }
}

PetscBool LawsCrack(const Model *model)
{
  for (const Elements *e = model->elements + ELASTIC_LISTS; e < model->elements + DEFORMABLE_LISTS; e++)
    for (PetscInt b = 0; b < e->n && e->history && e->law == MATERIAL_DAMAGE; b++)
      if (has_lost(e->history, b)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- stresses and energies, of the history now */

/* What is known of a point of LANES blocks beside its strain. */
typedef struct {
  PetscReal mixed[LAW_CONSTANTS * LANES];
  LanesLaw law;
  LanesMaterial material;
  Lanes from[HISTORY_MOST];
} SeenPoint;

KERNEL void SeeAt(const Elements *e, PetscInt first, int point, SeenPoint *p)
{
  const int width = LawKinds[e->law].width;
  const LanesHistory block = LoadHistory(e->history, first, width, 1, 0);
  p->law = LoadLaw(e->history, e->group + first, p->mixed);
  p->material = MaterialOf(&p->law);
  for (int i = 0; i < HISTORY_MOST; i++)
    p->from[i] = i < width ? LoadLanes(block.from + LANES * (width * point + i)) : LanesOf(0.);
}

KERNEL LanesStress StressSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E, Lanes *whole)
{
  *whole = LanesOf(1.);
  if (law == MATERIAL_MOHR_COULOMB)
    return LawStress(MATERIAL_MOHR_COULOMB, &p->law, E, NULL, p->from, NULL, whole);
  if (law == MATERIAL_DAMAGE) return LawStress(MATERIAL_DAMAGE, &p->law, E, NULL, p->from, NULL, whole);
  return (LanesStress){{0.}, {0.}, {0.}, {0.}};
}

KERNEL Lanes StoredSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E, Lanes *opening)
{
  *opening = LanesOf(0.);
  if (law == MATERIAL_MOHR_COULOMB) return LawStored(MATERIAL_MOHR_COULOMB, &p->law, E, p->from, opening);
  if (law == MATERIAL_DAMAGE) return LawStored(MATERIAL_DAMAGE, &p->law, E, p->from, opening);
  return LanesOf(0.);
}

void LawPointStress(const Elements *e, PetscInt first, int point, const LanesTensor *E, LanesTensor *S)
{
  SeenPoint p;
  SeeAt(e, first, point < e->history->points ? point : 0, &p);
  Lanes whole;
  const LanesStress s = StressSeen(e->law, &p, E, &whole);
  *S = (LanesTensor){s.xx, s.yy, s.xy};
}

/* Area of which a point at the centre has the stress: all of it. */
KERNEL Lanes AreaOfCentre(const Elements *e, Lanes J, int point)
{
  return e->n_nodes == 3 ? 0.5 * J : point ? LanesOf(0.) : 4. * J;
}

/* Whether a lane has its point at the centre of the block. */
KERNEL Mask AtCentre(const Elements *e, const LanesMaterial *m)
{
  return e->n_nodes == 3 ? ~(Mask){0} : m->one_point;
}

/* Area that a point stands for, and the strain there. */
KERNEL Lanes AreaAt(const Elements *e, const LanesMaterial *m, const LanesModes *X, const LanesModes *u,
                    int k, LanesTensor *E)
{
  const int large = e->strain == STRAIN_LARGE;
  const PetscReal xi = k == 0 || k == 3 ? -GAUSS : GAUSS, eta = k < 2 ? -GAUSS : GAUSS;
  const Mask centre = AtCentre(e, m);
  Lanes J, J_c;
  LanesGradient G;
  LanesTensor E_c;
  PointStrain(X, u, xi, eta, large, &J, &G, E);
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
    if (k || e->n_nodes == 3 || !Any(p.material.one_point)) continue;
    const LanesModes x = e->strain == STRAIN_LARGE ? ModesAdd(X, u) : *X;
    const LanesHourglass o = Hourglass(X, u, &x, &p.material);
    (void)StressSeen(e->law, &p, &E, &whole);
    *stored += Keep(p.material.one_point, 0.5 * whole * VectorDot(o.p, o.c));
  }
}

void LawTell(const Model *model, const Elements *e, const PetscReal *u, LawTold *told)
{
  for (PetscInt i = 0; i < e->n; i++) told[i] = (LawTold){0., -1., 0.};
  for (PetscInt first = 0; first < e->n; first += LANES) {
    LanesVector V[4], U[4];
    GatherBlocks(model, e, e->n_nodes, first, e->strain == STRAIN_LARGE, u, V, U);
    const LanesModes X = ElementModes(e->n_nodes, V), uM = ElementModes(e->n_nodes, U);
    for (int k = 0; k < e->history->points; k++) {
      SeenPoint p;
      SeeAt(e, first, k, &p);
      Lanes opening;
      LanesTensor E;
      const Lanes lost = model->thickness * AreaAt(e, &p.material, &X, &uM, k, &E) * p.from[HISTORY_LOST];
      (void)StoredSeen(e->law, &p, &E, &opening);
      for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++) {
        LawTold *t = told + first + lane;
        t->lost += lost[lane];
        t->measure = PetscMax(t->measure, p.from[HISTORY_MEASURE][lane]);
        t->opening = PetscMax(t->opening, opening[lane]);
      }
    }
  }
}

/* ---- life */

/* Refuses a group that has a law and never deforms by itself. */
static PetscErrorCode check_group(const Scene *scene, const Material *material, char *message)
{
  PetscFunctionBeginUser;
  if (material->law == MATERIAL_ELASTIC || !(material->rigid || material->condensed))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(
      message, MESSAGE_LENGTH,
      "%s: materials.%s.law: %s is for blocks that deform by themselves, and these are %s: expected elastic",
      scene->file, material->name, LawKinds[material->law].name, material->rigid ? "rigid" : "condensed"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LawsPresent(const Model *m)
{
  for (const Elements *e = m->elements + ELASTIC_LISTS; e < m->elements + DEFORMABLE_LISTS; e++)
    for (PetscInt g = 0; g < m->n_groups && e->history; g++) {
      PetscReal *c = e->history->constants + g * LAW_CONSTANTS * LANES;
      for (int lane = 0; lane < LANES; lane++) {
        c[LANES * LAW_LAMBDA + lane] = m->lame[g].lambda, c[LANES * LAW_MU + lane] = m->lame[g].mu;
        for (int i = 0; i < 3 && m->hourglass; i++)
          c[LANES * (LAW_HOURGLASS + i) + lane] = m->hourglass[3 * g + i];
      }
    }
}

static void fill_constants(const Material *material, const Model *m, PetscInt g, PetscReal *constants)
{
  PetscReal c[LAW_CONSTANTS] = {m->lame[g].lambda, m->lame[g].mu};
  for (int i = 0; i < 3 && m->hourglass; i++) c[LAW_HOURGLASS + i] = m->hourglass[3 * g + i];
  LawKinds[material->law].constants(material, m->lame[g], c);
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++) constants[g * LAW_CONSTANTS * LANES + i] = c[i / LANES];
}

/* [m] How wide a block is at most across a crack: by its least extent, which is square to one of its
   sides; see WidthAcross. */
static PetscReal widest_across(const Model *m, const Elements *e, PetscInt block)
{
  const PetscReal *first = m->X + 2 * VertexOf(e, block, 0);
  PetscReal twice = 0., least = 0.5 * PETSC_MAX_REAL;
  for (int k = 0; k < e->n_nodes; k++) {
    const PetscReal *A = m->X + 2 * VertexOf(e, block, k),
                    *B = m->X + 2 * VertexOf(e, block, (k + 1) % e->n_nodes);
    const PetscReal side[2] = {B[0] - A[0], B[1] - A[1]};
    PetscReal most = 0.;
    for (int i = 0; i < e->n_nodes; i++) {
      const PetscReal *C = m->X + 2 * VertexOf(e, block, i);
      most = PetscMax(most, side[0] * (C[1] - A[1]) - side[1] * (C[0] - A[0]));
    }
    twice += (A[0] - first[0]) * side[1] - (A[1] - first[1]) * side[0];
    least = PetscMin(least, most / hypot(side[0], side[1]));
  }
  return (e->n_nodes == 3 ? 1. : 0.5) * twice / least;
}

/* Refuses blocks that would give back more energy than the crack takes. */
static PetscErrorCode check_widths(const Scene *scene, const Model *m, const Elements *e, char *message)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < e->n && LawKinds[e->law].widest && !message[0]; i++) {
    const PetscReal *c = e->history->constants + e->group[i] * LAW_CONSTANTS * LANES;
    PetscReal own[LAW_CONSTANTS];
    for (int k = 0; k < LAW_CONSTANTS; k++) own[k] = c[LANES * k];
    const PetscReal most = LawKinds[e->law].widest(own), width = widest_across(m, e, i);
    if (width < most) continue;
    PetscCall(PetscSNPrintf(
        message, MESSAGE_LENGTH,
        "%s: materials.%s.fracture_energy: block %" PetscInt_FMT
        " is %.4g m wide across a crack, and as it breaks it would give back more energy than "
        "the crack takes: expected blocks of less than %.6g m, or more energy",
        scene->file, scene->materials[e->group[i]].name, e->file[i], (double)width, (double)most));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of one list, on all ranks alike, also where a rank has no block of it. */
static PetscErrorCode create_history(const Scene *scene, const Model *m, Elements *e)
{
  PetscBool any = PETSC_FALSE, full = PETSC_FALSE;
  LawHistory *h;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->n_groups; g++) {
    if (scene->materials[g].law != e->law) continue;
    any = PETSC_TRUE;
    full = (PetscBool)(full || scene->materials[g].element == ELEMENT_FULL);
  }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&h));
  h->points = full && e->n_nodes == 4 ? 4 : 1, h->width = LawKinds[e->law].width;
  h->n = e->n_padded * h->points * h->width;
  for (PetscInt i = e->n; i < e->n_padded; i++)
    e->group[i] = e->group[e->n - 1]; // padding has as many points
  PetscCall(PetscCalloc3(h->n, &h->held, h->n, &h->now, h->n, &h->stable));
  PetscCall(PetscCalloc1(m->n_groups * LAW_CONSTANTS * LANES, &h->constants));
  for (PetscInt g = 0; g < m->n_groups; g++)
    if (scene->materials[g].law == e->law) fill_constants(scene->materials + g, m, g, h->constants);
  e->history = h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LawsCreate(const Scene *scene, Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->n_groups && !message[0]; g++)
    PetscCall(check_group(scene, scene->materials + g, message));
  PetscCall(CheckMessage(m->comm, message));
  for (Elements *e = m->elements + ELASTIC_LISTS; e < m->elements + DEFORMABLE_LISTS; e++)
    PetscCall(create_history(scene, m, e));
  for (Elements *e = m->elements + ELASTIC_LISTS; e < m->elements + DEFORMABLE_LISTS; e++)
    if (e->history) PetscCall(check_widths(scene, m, e, message));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LawsDestroy(Model *m)
{
  PetscFunctionBeginUser;
  for (Elements *e = m->elements + ELASTIC_LISTS; e < m->elements + DEFORMABLE_LISTS; e++) {
    if (!e->history) continue;
    PetscCall(PetscFree3(e->history->held, e->history->now, e->history->stable));
    PetscCall(PetscFree(e->history->constants));
    PetscCall(PetscFree(e->history));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

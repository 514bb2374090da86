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

const LawKind LawKinds[MATERIAL_LAWS] = {
    [MATERIAL_MOHR_COULOMB] = {"mohr_coulomb", MC_WIDTH, mohr_coulomb},
};

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
    Gather(n_nodes, model->X, vertex, X);
    Gather(n_nodes, u, vertex, U);
    LawBlock(law, n_nodes, &c, &material, X, U, model->thickness, large, &history, F);
    ScatterAdd(n_nodes, F, vertex, f);
  }
}

KERNEL void LawsLoop_code(const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f)
{
  const int large = e->strain == STRAIN_LARGE;
  if (e->law == MATERIAL_MOHR_COULOMB && e->n_nodes == 4)
    LawLoop(MATERIAL_MOHR_COULOMB, model, e, 4, large, keep, u, f);
  else if (e->law == MATERIAL_MOHR_COULOMB)
    LawLoop(MATERIAL_MOHR_COULOMB, model, e, 3, large, keep, u, f);
}

VARIANTS(LawsLoop, (const Model *model, const Elements *e, int keep, const PetscReal *u, PetscReal *f),
         (model, e, keep, u, f))

void LawForces(const Model *model, const Elements *e, PetscBool keep, const PetscReal *u, PetscReal *f)
{
  LawsLoop(model, e, keep || e->history->in_time, u, f);
}

/* ---- the tangent */

static const PetscReal STEP = 1e-7; /* of central differences, as a fraction of a side */

static void block_of(const Model *model, const Elements *e, PetscInt first, const LanesVector X[4],
                     const LanesVector U[4], LanesVector F[4])
{
  PetscReal mixed[LAW_CONSTANTS * LANES];
  const LanesLaw c = LoadLaw(e->history, e->group + first, mixed);
  const LanesMaterial material = MaterialOf(&c);
  const int large = e->strain == STRAIN_LARGE;
  LanesHistory history = LoadHistory(e->history, first, LawKinds[e->law].width, e->history->in_time, 0);
  if (e->law == MATERIAL_MOHR_COULOMB)
    LawBlock(MATERIAL_MOHR_COULOMB, e->n_nodes, &c, &material, X, U, model->thickness, large, &history, F);
}

void LawMatrices(const Model *model, const Elements *e, PetscInt first, const PetscReal *u, PetscReal K[][64])
{
  const int n_nodes = e->n_nodes;
  const PetscInt *vertex = LaneVertices(e, n_nodes, first);
  LanesVector X[4], U[4], F[2][4];
  Gather(n_nodes, model->X, vertex, X);
  Gather(n_nodes, u, vertex, U);
  const LanesVector side = VectorSubtract(X[1], X[0]);
  const Lanes h = STEP * SquareRoot(VectorDot(side, side));
  for (int column = 0; column < 2 * n_nodes; column++) {
    for (int k = 0; k < 2; k++) {
      LanesVector moved[4];
      memcpy(moved, U, sizeof moved);
      Lanes *x = column % 2 ? &moved[column / 2].y : &moved[column / 2].x;
      *x = k ? *x - h : *x + h;
      block_of(model, e, first, X, moved, F[k]);
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
  for (int i = 0; i < width; i++) p->from[i] = LoadLanes(block.from + LANES * (width * point + i));
}

KERNEL LanesStress StressSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E, Lanes *whole)
{
  *whole = LanesOf(1.);
  if (law == MATERIAL_MOHR_COULOMB) return LawStress(MATERIAL_MOHR_COULOMB, &p->law, E, p->from, NULL, whole);
  return (LanesStress){{0.}, {0.}, {0.}, {0.}};
}

KERNEL Lanes StoredSeen(MaterialLaw law, const SeenPoint *p, const LanesTensor *E)
{
  if (law == MATERIAL_MOHR_COULOMB) return LawStored(MATERIAL_MOHR_COULOMB, &p->law, E, p->from);
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
    Lanes whole;
    LanesTensor E;
    const Lanes area = AreaAt(e, &p.material, X, u, k, &E);
    *stored += area * StoredSeen(e->law, &p, &E);
    if (k || e->n_nodes == 3 || !Any(p.material.one_point)) continue;
    const LanesModes x = e->strain == STRAIN_LARGE ? ModesAdd(X, u) : *X;
    const LanesHourglass o = Hourglass(X, u, &x, &p.material);
    (void)StressSeen(e->law, &p, &E, &whole);
    *stored += Keep(p.material.one_point, 0.5 * whole * VectorDot(o.p, o.c));
  }
}

PetscReal LawLost(const Model *model, const Elements *e)
{
  PetscReal sum = 0.;
  for (PetscInt first = 0; first < e->n; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, e->n_nodes, first);
    LanesVector V[4];
    Gather(e->n_nodes, model->X, vertex, V);
    const LanesModes X = ElementModes(e->n_nodes, V);
    for (int k = 0; k < e->history->points; k++) {
      SeenPoint p;
      SeeAt(e, first, k, &p);
      LanesTensor E;
      const Lanes lost = AreaAt(e, &p.material, &X, &X, k, &E) * p.from[HISTORY_LOST];
      for (PetscInt lane = 0; lane < PetscMin(LANES, e->n - first); lane++)
        if (e->owned[first + lane]) sum += model->thickness * lost[lane];
    }
  }
  return sum;
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

static void fill_constants(const Material *material, const Model *m, PetscInt g, PetscReal *constants)
{
  PetscReal c[LAW_CONSTANTS] = {m->lame[g].lambda, m->lame[g].mu};
  for (int i = 0; i < 3 && m->hourglass; i++) c[LAW_HOURGLASS + i] = m->hourglass[3 * g + i];
  LawKinds[material->law].constants(material, m->lame[g], c);
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++) constants[g * LAW_CONSTANTS * LANES + i] = c[i / LANES];
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

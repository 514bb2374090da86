/* A bonded bar: its forces are the slope of what it stores and loses, its stiffness that of its forces, in
   small and in large strain, elastic and beyond; the row sums are above its eigenvalues; its slips
   balance. */
#include "check.h"
#include "anchors/chain.h"

enum {
  PLACES = 6,
  VERTICES = 4 * (PLACES + 3),
  DOFS = 2 * VERTICES,
  NUMBERS = 4 * PLACES + 2 + CHAIN_LOSSES
};

/* A chain with room for its arrays. */
typedef struct {
  Chain chain;
  Place place[PLACES];
  Dowel dowel;
  PetscInt vertex[VERTICES], crossing[PLACES], branch[2 * PLACES], before[2 * PLACES];
  PetscReal from[PLACES], bonded[PLACES], c[PLACES], B[PLACES], length[PLACES], k[PLACES],
      towards[2 * PLACES], numbers[CHAIN_STATES][NUMBERS], g[PLACES], e[2 * PLACES], span[PLACES], N[PLACES],
      b[PLACES], k_now[PLACES], c_now[PLACES], r[PLACES], step[PLACES], pivot[PLACES], try[PLACES],
      elastic[PLACES];
} Drawn;

static PetscReal Random(PetscReal low, PetscReal high)
{
  return low + (high - low) * ((PetscReal)rand() / (PetscReal)RAND_MAX);
}

static Place PlaceAt(PetscInt number)
{
  Place place = {.n = 4};
  PetscReal sum = 0.;
  for (int i = 0; i < 4; i++) sum += place.weight[i] = Random(0.1, 1.);
  for (int i = 0; i < 4; i++) {
    place.weight[i] /= sum;
    place.vertex[i] = place.at[i] = 4 * number + i;
  }
  return place;
}

/* A bar of pieces of half a metre, with a dowel across the third. */
static void Draw(PetscBool head, PetscBool turns, PetscReal T_y, PetscReal bond, PetscReal V_y, Drawn *d)
{
  const PetscReal angle = Random(0., 6.28), across = angle + Random(0.7, 2.2);
  *d = (Drawn){.dowel = {.piece = 2, .K = 3e7, .V_y = V_y, .face_length = 1.5}};
  d->chain = (Chain){.n = PLACES,
                     .n_dowels = 1,
                     .n_vertices = VERTICES,
                     .head = head,
                     .turns = turns,
                     .slack = head,
                     .T_y = T_y,
                     .EA = 1.6e8,
                     .vertex = d->vertex,
                     .place = d->place,
                     .from = d->from,
                     .bonded = d->bonded,
                     .c = d->c,
                     .B = d->B,
                     .length = d->length,
                     .k = d->k,
                     .towards = d->towards,
                     .dowel = &d->dowel,
                     .crossing = d->crossing,
                     .n_numbers = NUMBERS,
                     .jack = -1.,
                     .g = d->g,
                     .e = d->e,
                     .span = d->span,
                     .N = d->N,
                     .b = d->b,
                     .k_now = d->k_now,
                     .c_now = d->c_now,
                     .branch = d->branch,
                     .before = d->before,
                     .r = d->r,
                     .step = d->step,
                     .pivot = d->pivot,
                     .try = d->try,
                     .elastic = d->elastic};
  for (int i = 0; i < VERTICES; i++) d->vertex[i] = i;
  for (int i = 0; i < PLACES; i++) {
    d->place[i] = PlaceAt(i);
    d->length[i] = 0.5, d->k[i] = 1.6e8 / 0.5, d->crossing[i] = i == 2 ? 0 : -1;
    d->c[i] = head && !i ? 0. : 4e8, d->B[i] = bond;
    d->towards[2 * i] = cos(angle), d->towards[2 * i + 1] = sin(angle);
  }
  for (int i = 0; i < 2; i++) d->dowel.on[i] = PlaceAt(PLACES + i);
  d->dowel.face = (Place){.n = 2,
                          .vertex = {VERTICES - 1, VERTICES - 2, VERTICES - 1, VERTICES - 1},
                          .at = {VERTICES - 1, VERTICES - 2, VERTICES - 1, VERTICES - 1},
                          .weight = {1., -1.}};
  d->dowel.along[0] = cos(across), d->dowel.along[1] = sin(across);
  for (int i = 0; i < CHAIN_STATES; i++) {
    PetscReal *x = d->numbers[i];
    d->chain.numbers[i] = x;
    d->chain.memory[i] = (ChainMemory){x,
                                       x + PLACES - 1,
                                       x + 2 * PLACES - 2,
                                       x + 3 * PLACES - 2,
                                       x + 4 * PLACES - 2,
                                       x + 4 * PLACES - 1,
                                       x + 4 * PLACES};
  }
  ChainPrepare(&d->chain);
  d->chain.reach = PLACES;
}

static PetscReal EnergyAt(Chain *c, const PetscReal *u)
{
  ChainEvaluate(c, u);
  return ChainStored(c) + ChainLost(c);
}

static void ForceAt(Chain *c, const PetscReal *u, PetscReal *f)
{
  for (int i = 0; i < DOFS; i++) f[i] = 0.;
  ChainEvaluate(c, u);
  ChainPull(c, 1., f);
}

/* Force on each place along the bar, of the bonds: what the pieces leave. */
static void CheckBalance(const Chain *c)
{
  for (PetscInt i = c->head; i < c->n; i++) {
    const PetscReal left = i ? c->N[i - 1] : 0., right = i + 1 < c->n ? c->N[i] : 0.;
    ENSURE_NEAR(right - left, c->b[i], 1e-7 * (1. + PetscAbsReal(c->b[i])));
    ENSURE(PetscAbsReal(c->b[i]) <= c->B[i] * (1. + 1e-12));
    ENSURE(PetscAbsReal(right) <= c->T_y * (1. + 1e-12));
  }
}

/* The stiffness now, the sum of its windows: (DOFS, DOFS). */
static PetscErrorCode Tangent(Chain *c, PetscReal *k)
{
  PetscInt n, at[4 * (PLACES + 3)];
  PetscReal *part;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(DOFS * DOFS, &part));
  for (PetscInt window = 0; window < ChainWindows(c); window++) {
    PetscCall(ChainWindow(c, window, &n, at));
    PetscCall(PetscArrayzero(part, DOFS * DOFS));
    PetscCall(ChainTangent(c, window, PETSC_FALSE, PETSC_TRUE, 1., n, at, part));
    for (PetscInt p = 0; p < 2 * n; p++)
      for (PetscInt q = 0; q < 2 * n; q++)
        k[DOFS * (2 * at[p / 2] + p % 2) + 2 * at[q / 2] + q % 2] += part[2 * n * p + q];
  }
  PetscCall(PetscFree(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckAt(Drawn *d, const PetscReal *at, PetscReal size, PetscReal forces,
                              PetscBool potential, PetscReal *most)
{
  const PetscReal h = 1e-8;
  Chain *c = &d->chain;
  PetscReal u[DOFS], f[DOFS], less[DOFS], more[DOFS], *k, bound[VERTICES] = {0.};
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(DOFS * DOFS, &k));
  for (int i = 0; i < DOFS; i++) u[i] = size * at[i];
  ForceAt(c, u, f);
  CheckBalance(c);
  PetscCall(Tangent(c, k));
  ChainBound(c, 1., bound);
  *most = 0.;
  for (int i = 0; i < DOFS; i++) {
    PetscReal row = 0.;
    u[i] = size * at[i] + h;
    ForceAt(c, u, more);
    const PetscReal above = EnergyAt(c, u);
    u[i] = size * at[i] - h;
    ForceAt(c, u, less);
    if (potential) ENSURE_NEAR((above - EnergyAt(c, u)) / (2. * h), f[i], 1e-4 * forces);
    u[i] = size * at[i];
    for (int j = 0; j < DOFS; j++) {
      ENSURE_NEAR((more[j] - less[j]) / (2. * h), k[DOFS * j + i], 1e-8 * 3e8);
      row += PetscAbsReal(k[DOFS * i + j]);
    }
    *most = PetscMax(*most, row / bound[i / 2]);
  }
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TestForceAndStiffness(void)
{
  const PetscReal inf = PETSC_INFINITY;
  int joined = 0;
  PetscFunctionBeginUser;
  for (int draw = 0; draw < 80; draw++) {
    const PetscBool head = (PetscBool)(draw / 2 % 2), turns = (PetscBool)(draw % 2);
    // elastic; bar and bond beyond their strength; the dowel; all of them, bar and dowel together
    const int what = draw / 4 % 4;
    PetscReal at[DOFS], most = 0.;
    Drawn d;
    for (int i = 0; i < DOFS; i++) at[i] = Random(-1e-3, 1e-3);
    Draw(head, turns, what % 2 ? 8e4 : inf, what % 2 ? 3e4 : inf,
         what == 2   ? 1e4
         : what == 3 ? 5e3
                     : inf,
         &d);
    PetscCall(CheckAt(&d, at, 1., 1e5, (PetscBool)(what < 3), &most));
    joined += d.dowel.beyond > 1. && PetscAbsReal(d.N[2]) > 0.1 * d.chain.T_y;
    ENSURE(what || turns || (most <= 2. && most > 0.1));
  }
  ENSURE(joined > 5);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stiff bond, so that pieces feel their neighbours alone: windows of two reaches have all of the
   stiffness. */
static PetscErrorCode TestWindows(void)
{
  PetscReal most = 0.;
  PetscFunctionBeginUser;
  for (int draw = 0; draw < 20; draw++) {
    PetscReal u[DOFS], *whole, *windows;
    Drawn d;
    Draw((PetscBool)(draw % 2), (PetscBool)(draw / 2 % 2), PETSC_INFINITY, PETSC_INFINITY, PETSC_INFINITY,
         &d);
    for (int i = d.chain.head; i < PLACES; i++) d.c[i] = 1e6 * d.k[0];
    for (int i = 0; i < DOFS; i++) u[i] = Random(-1e-3, 1e-3);
    ChainPrepare(&d.chain);
    ChainEvaluate(&d.chain, u);
    PetscCall(PetscCalloc2(DOFS * DOFS, &whole, DOFS * DOFS, &windows));
    PetscCall(Tangent(&d.chain, whole));
    d.chain.reach = ChainReach(&d.chain, PETSC_INFINITY);
    ENSURE(d.chain.reach == 2 && ChainWindows(&d.chain) == 3);
    PetscCall(Tangent(&d.chain, windows));
    for (int i = 0; i < DOFS * DOFS; i++) {
      ENSURE_NEAR(windows[i], whole[i], 1e-6 * d.k[0]);
      most = PetscMax(most, PetscAbsReal(whole[i]));
    }
    PetscCall(PetscFree2(whole, windows));
  }
  ENSURE(most > 0.1 * 1.6e8 / 0.5);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends free, a bond that slips nearly everywhere while the bar yields: slips are found all the same. */
static PetscErrorCode TestSlides(void)
{
  int slides = 0, yields = 0;
  PetscFunctionBeginUser;
  for (int draw = 0; draw < 3000; draw++) {
    PetscReal u[DOFS];
    Drawn d;
    const PetscReal way = pow(10., Random(-5., -0.5)), strength = pow(10., Random(1.5, 5.));
    Draw((PetscBool)(draw % 3 == 0), (PetscBool)(draw % 2),
         draw % 4 ? Random(1., 8.) * strength : PETSC_INFINITY, strength, draw % 5 ? 1e4 : PETSC_INFINITY,
         &d);
    for (int i = 0; i < DOFS; i++) u[i] = Random(-way, way);
    for (int step = 0; step < 2; step++) { // from no slips, then from those
      for (int i = 0; i < DOFS; i++) u[i] *= Random(-1., 1.);
      ENSURE(ChainEvaluate(&d.chain, u));
      CheckBalance(&d.chain);
    }
    for (int i = 0; i < PLACES; i++) slides += PetscAbsReal(d.b[i]) == d.B[i];
    for (int j = 0; j + 1 < PLACES; j++) yields += PetscAbsReal(d.N[j]) == d.chain.T_y;
  }
  ENSURE(slides > 3000 && yields > 100);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Row sums of a stiffness are no more than its bound; those of the eliminated bar may be, its eigenvalues are
   not: x'kx <= x' diag(bound) x for random x. */
static PetscErrorCode TestBound(void)
{
  PetscReal most = 0.;
  PetscFunctionBeginUser;
  for (int draw = 0; draw < 40; draw++) {
    PetscReal u[DOFS] = {0.}, bound[VERTICES] = {0.}, *matrix;
    Drawn d;
    Draw((PetscBool)(draw % 2), PETSC_FALSE, PETSC_INFINITY, PETSC_INFINITY, PETSC_INFINITY, &d);
    if (draw % 3 == 0) // soft bond, stiff steel: the bar rests
      for (int j = 0; j < PLACES; j++) d.k[j] *= 1e3;
    PetscCall(PetscCalloc1(DOFS * DOFS, &matrix));
    ChainEvaluate(&d.chain, u);
    PetscCall(Tangent(&d.chain, matrix));
    ChainBound(&d.chain, 1., bound);
    PetscReal x[DOFS], y[DOFS];
    for (int i = 0; i < DOFS; i++) x[i] = Random(-1., 1.);
    for (int sweep = 0; sweep < 300; sweep++) { // largest eigenvalue of k over the bounds
      PetscReal top = 0.;
      for (int i = 0; i < DOFS; i++) {
        y[i] = 0.;
        for (int j = 0; j < DOFS; j++) y[i] += matrix[DOFS * i + j] * x[j];
        y[i] = bound[i / 2] > 0. ? y[i] / bound[i / 2] : 0.;
        top = PetscMax(top, PetscAbsReal(y[i]));
      }
      for (int i = 0; i < DOFS; i++) x[i] = y[i] / top;
      if (sweep == 299) most = PetscMax(most, top);
    }
    ENSURE(most <= 1. + 1e-9);
    PetscCall(PetscFree(matrix));
  }
  ENSURE(most > 0.6);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The dowel with force along the bar: on the ellipse; both fall back elastically. */
static void TestEllipse(void)
{
  PetscReal u[DOFS] = {0.};
  Drawn d;
  Draw(PETSC_FALSE, PETSC_FALSE, 8e4, PETSC_INFINITY, 1e4, &d);
  Chain *c = &d.chain;
  const Place *behind = &d.dowel.on[1];
  for (int step = 1; step <= 3; step++) {
    for (int i = 3; i < PLACES; i++) // the bar opens
      for (int v = 0; v < 4; v++)
        for (int x = 0; x < 2; x++) u[2 * (4 * i + v) + x] = 1e-3 * step * d.towards[x];
    for (int v = 0; v < 4; v++) // the joint slips
      for (int x = 0; x < 2; x++) u[2 * behind->vertex[v] + x] = 2e-4 * step * d.dowel.along[x];
    ChainEvaluate(c, u);
    CheckBalance(c);
    const PetscReal T = c->N[2] / 8e4, V = d.dowel.V / 1e4;
    if (step == 1) ENSURE_NEAR(V, d.dowel.trial / 1e4 / PetscMax(1., d.dowel.beyond), 1e-12);
    if (step > 1) ENSURE_NEAR(T * T + V * V, 1., 1e-9);
    ChainCopy(c, CHAIN_NOW, CHAIN_COMMITTED);
  }
  const PetscReal V = d.dowel.V, lost = c->memory[CHAIN_COMMITTED].lost[LOST_IN_DOWELS];
  ENSURE(lost > 0.);
  for (int v = 0; v < 4; v++)
    for (int x = 0; x < 2; x++) u[2 * behind->vertex[v] + x] -= 1e-4 * d.dowel.along[x];
  ChainEvaluate(c, u);
  ENSURE_NEAR(d.dowel.V, V - 1e-4 * 3e7, 1e-6);
  ENSURE_NEAR(c->memory[CHAIN_NOW].lost[LOST_IN_DOWELS], lost, 1e-12);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(TestForceAndStiffness);
  RUN_TEST(TestWindows);
  RUN_TEST(TestSlides);
  RUN_TEST(TestBound);
  RUN_TEST(TestEllipse);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

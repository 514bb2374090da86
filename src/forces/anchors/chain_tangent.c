/* chain_tangent.c: the stiffness of a bonded bar.

   With the slopes k_j of the pieces, c_i of the bonds and the differences G s of the slips, the slips that
   follow elongations dg are ds = -H^-1 G' k dg, H = G' k G + c tridiagonal, and

     dN = A dg,   A = k - k G H^-1 G' k. */
#include "forces/anchors/chain.h"

/* Places and their direction: how an elongation depends on displacements. */
typedef struct {
  const Place *a, *b; /* from, to */
  const PetscReal *e;
} Slope;

/* Adds times x first' second to k, first and second the slopes. */
static void add_pair(const Chain *c, const Slope *first, const Slope *second, PetscReal times, PetscReal *k)
{
  const PetscInt width = 2 * c->n_vertices;
  for (int one = 0; one < 4; one++) {
    const Place *p = one / 2 ? first->a : first->b, *q = one % 2 ? second->a : second->b;
    const PetscReal sign = (one / 2 ? -times : times) * (one % 2 ? -1. : 1.);
    for (PetscInt i = 0; i < p->n; i++)
      for (PetscInt l = 0; l < q->n; l++) {
        const PetscReal weight = sign * p->weight[i] * q->weight[l];
        PetscReal *to = k + width * 2 * p->at[i] + 2 * q->at[l];
        for (int x = 0; x < 2; x++)
          for (int y = 0; y < 2; y++) to[width * x + y] += weight * first->e[x] * second->e[y];
      }
  }
}

/* Slopes of the last evaluation, or elastic ones. */
static void set_slopes(Chain *c, PetscBool elastic)
{
  for (PetscInt j = 0; j + 1 < c->n && elastic; j++)
    c->k_now[j] = c->branch[j] == IS_PULLED || c->branch[j] == IS_SLACK ? 0. : c->k[j];
  for (PetscInt i = 0; i < c->n && elastic; i++) c->c_now[i] = c->c[i];
  ChainFactor(c);
}

static void add_column(Chain *c, PetscInt j, const Slope *slopes, PetscReal times, PetscReal *k)
{
  PetscReal *y = c->step;
  if (c->k_now[j] == 0.) return;
  memset(y, 0, c->n * sizeof *y);
  y[j] = -c->k_now[j], y[j + 1] = c->k_now[j];
  ChainBack(c, y);
  for (PetscInt i = 0; i + 1 < c->n; i++) {
    const PetscReal A = (i == j ? c->k_now[j] : 0.) - c->k_now[i] * (y[i + 1] - y[i]);
    if (PetscAbsReal(A) > 1e-12 * c->k[j]) add_pair(c, slopes + i, slopes + j, times * A, k);
  }
}

PetscErrorCode ChainTangent(Chain *c, PetscBool elastic, PetscBool turned, PetscReal times, PetscReal *k)
{
  Slope *slopes;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(c->n, &slopes));
  for (PetscInt j = 0; j + 1 < c->n; j++)
    slopes[j] = (Slope){c->place + j, c->place + j + 1, (turned ? c->e : c->towards) + 2 * j};
  set_slopes(c, elastic);
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    const PetscReal normal[2] = {-slopes[j].e[1], slopes[j].e[0]};
    const Slope across = {slopes[j].a, slopes[j].b, normal};
    add_column(c, j, slopes, times, k);
    if (turned && c->turns) add_pair(c, &across, &across, times * c->N[j] / c->span[j], k);
  }
  for (const Dowel *d = c->dowel; d < c->dowel + c->n_dowels; d++) {
    const Slope along = {&d->on[0], &d->on[1], turned ? d->t : d->along};
    const PetscReal N = c->T_y < PETSC_INFINITY ? c->N[d->piece] / c->T_y : 0.;
    const PetscBool yields = (PetscBool)(!elastic && d->beyond > 1. && d->V_y < PETSC_INFINITY);
    add_pair(c, &along, &along, times * d->K * (yields ? N * N / d->beyond : 1.), k);
  }
  PetscCall(PetscFree(slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

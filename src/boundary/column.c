/* column.c: computes the motion of free ground beside the model as a column one metre wide. All points of
   a level move together, so each level has an x and a y. The column is linear elastic, starts at rest and
   carries no weight, only what the earthquake adds. Its levels, masses and forces are the levels, masses and
   forces of blocks between the levels in such a motion, and its steps are the steps of the model. So ground
   without a structure moves as its column does. */
#include "boundary/boundary.h"

/* Returns the mass [kg/m2] of level j. */
static PetscReal mass_of(const Column *c, PetscInt j)
{
  PetscReal mass = 0.;
  if (j > 0) mass += 0.5 * c->layer[j - 1].density * (c->y[j] - c->y[j - 1]);
  if (j + 1 < c->n) mass += 0.5 * c->layer[j].density * (c->y[j + 1] - c->y[j]);
  return mass;
}

/* Decides whether the step is a full one. Part 0 is a full step that the model takes back. */
static PetscBool is_whole(PetscReal part)
{
  return (PetscBool)(part == 1. || part == 0.);
}

/* Computes the stresses of the layers. Stiffness-proportional damping acts as in blocks (block_damping.c):
   by the velocity of the step before. So it is zero in the first step of a stage and in the half steps at
   its ends. */
static void find_stresses(Column *c, PetscReal part)
{
  for (PetscInt j = 0; j + 1 < c->n; j++) {
    const PetscReal *u = c->u + 2 * j, *v = c->v + 2 * j, h = c->y[j + 1] - c->y[j];
    const PetscReal own = c->layer[j].beta, of_group = PetscIsNanReal(own) ? c->beta : own;
    const PetscReal beta = is_whole(part) && c->moved ? of_group : 0.;
    const PetscReal shear = (u[2] - u[0] + beta * (v[2] - v[0])) / h,
                    strain = (u[3] - u[1] + beta * (v[3] - v[1])) / h;
    const Lame lame = c->layer[j].lame;
    c->stress[3 * j] = lame.lambda * strain;
    c->stress[3 * j + 1] = (lame.lambda + 2. * lame.mu) * strain;
    c->stress[3 * j + 2] = lame.mu * shear;
  }
}

/* Returns the resisting force [Pa] of level j along x (k = 0) or y (1). */
static PetscReal force_of(const Column *c, PetscInt j, int k)
{
  const int entry = k ? 1 : 2;
  const PetscReal below = j > 0 ? c->stress[3 * (j - 1) + entry] : 0.,
                  above = j + 1 < c->n ? c->stress[3 * j + entry] : 0.;
  return below - above;
}

/* Returns the dashpots [N s/m3] of the base. */
static PetscReal dashpot_of(const Column *c, int k)
{
  const Layer *rock = c->half_space.density > 0. ? &c->half_space : c->layer;
  return PetscSqrtReal(rock->density * (k ? rock->lame.lambda + 2. * rock->lame.mu : rock->lame.mu));
}

static void move_level(Column *c, const ColumnStep *s, PetscInt j, int k)
{
  const PetscInt d = 2 * j + k;
  const PetscBool whole = is_whole(s->part);
  const PetscReal mass = mass_of(c, j), v = c->v[d], step = (whole ? 1. : s->part) * s->dt;
  const PetscReal dashpot = j || !c->quiet ? 0. : dashpot_of(c, k);
  const PetscReal force = dashpot * (s->base[k] - v) - force_of(c, j, k) -
                          s->alpha * mass * (v - s->ground[k]);
  const PetscReal centred = whole ? 0.5 * s->dt * (s->alpha * mass + dashpot) : 0.;
  PetscReal change = step * force / (mass + centred);
  if (!j && !c->quiet) change = whole ? s->base[k] - v : 0.;
  c->mean[d] = whole ? v + 0.5 * change : v;
  c->drive[d] = change / step + s->alpha * (c->mean[d] - s->ground[k]);
  if (s->part != 0.) c->v[d] = v + change;
}

void ColumnMove(Column *c, const ColumnStep *s)
{
  find_stresses(c, s->part);
  for (PetscInt j = 0; j < c->n; j++)
    for (int k = 0; k < 2; k++) move_level(c, s, j, k);
  if (s->part != 1.) return;
  c->moved = 1;
  for (PetscInt d = 0; d < 2 * c->n; d++) c->u[d] += s->dt * c->v[d];
  for (int k = 0; k < 2; k++) c->peak[k] = PetscMax(c->peak[k], PetscAbsReal(c->v[2 * (c->n - 1) + k]));
}

PetscErrorCode ColumnCreate(PetscInt n, Column *c)
{
  PetscFunctionBeginUser;
  *c = (Column){.n = n, .base = -1};
  PetscCall(PetscMalloc2(n, &c->y, n - 1, &c->layer));
  PetscCall(PetscMalloc1(n, &c->gid));
  PetscCall(
      PetscCalloc5(2 * n, &c->u, 2 * n, &c->v, 2 * n, &c->mean, 2 * n, &c->drive, 3 * (n - 1), &c->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ColumnDestroy(Column *c)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(c->y, c->layer));
  PetscCall(PetscFree(c->gid));
  PetscCall(PetscFree5(c->u, c->v, c->mean, c->drive, c->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* storage.c: what joints hold while water flows in time.

   An end of a piece holds a (chi + p / K_w) over half the piece's length, which changes over a step by
   what it takes in, with

   a = a_r + (p - p_r) c where it is wet.

   a_r is the aperture that the openings had while p_r pressed, and c the compliance of the joint: the rest
   of the change of aperture comes from the next equilibrium (fixed-stress split: with c = 1/k_n
   independent blocks take one round; at the end of the rounds p = p_r, whatever c is). */
#include "forces/water/flow.h"

PetscReal FlowCompliance(const Scene *scene, const Stage *stage, const FlowNetwork *net, PetscInt i, int k)
{
  const FlowPiece *piece = net->piece + i;
  const FlowRow *row = net->row + piece->row;
  const Joint *joint = stage->joints + row->joint;
  const PetscReal opening = row->opening[0] + piece->s[k] * (row->opening[1] - row->opening[0]),
                  a = joint->aperture + opening;
  (void)scene;
  if (row->parted || a <= joint->aperture_residual || a >= joint->aperture_max) return 0.;
  return piece->a[k] / a / joint->k_n; // a curtain leaves a part of the aperture
}

static int water_order(const FlowWater *w, const PetscInt key[2])
{
  for (int i = 0; i < 2; i++)
    if (w->key[i] != key[i]) return w->key[i] < key[i] ? -1 : 1;
  return 0;
}

PetscBool FlowWaterAt(const FlowWater *past, PetscInt n, const PetscInt key[2], PetscReal s, FlowWater *water)
{
  PetscInt low = 0, high = n;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;
    if (water_order(past + middle, key) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  for (; low + 1 < n && !water_order(past + low + 1, key) && !water_order(past + low, key);
       low += 2) { // a piece
    const FlowWater *a = past + low, *b = a + 1;
    const PetscReal at = b->s > a->s ? (s - a->s) / (b->s - a->s) : 0.;
    if (at > 1. + 1e-9) continue;
    *water = at > 0.5 ? *b : *a;
    water->a = (1. - at) * a->a + at * b->a; // exact at the ends
    water->psi = (1. - at) * a->psi + at * b->psi, water->chi = (1. - at) * a->chi + at * b->chi;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

void FlowStore(const Scene *scene, const Stage *stage, const FlowWater *past, PetscInt n,
               const PetscReal *reference, FlowNetwork *net)
{
  // joints that keep their openings: a stage begins with these, whatever the stage before had
  const PetscBool fixed = (PetscBool)(scene->flow.coupling == FLOW_ONE_WAY),
                  as_measured = (PetscBool)(fixed && stage->water_time <= stage->water_step);
  const PetscReal rho_g = scene->flow.density * scene->gravity, K_w = scene->flow.bulk_modulus;
  for (PetscInt e = 0; e < 2 * net->n_pieces && net->step > 0.; e++) {
    const FlowPiece *piece = net->piece + e / 2;
    const int k = e % 2;
    FlowNode *node = net->node + piece->node[k];
    FlowWater was = {.psi = 0., .chi = 0., .a = 0.};
    FlowWaterAt(past, n, net->row[piece->row].key, piece->s[k], &was);
    if (as_measured) was.a = piece->a[k];
    const PetscReal w = 0.5 * piece->length / net->step, a = piece->a[k],
                    c = FlowCompliance(scene, stage, net, e / 2, k);
    const PetscReal before = was.a * was.chi + (fixed ? a : was.a) * rho_g * was.psi / K_w;
    node->wet[0] += w * rho_g * (c + a / K_w);
    node->wet[1] += w * (a - c * rho_g * reference[piece->node[k]] - before);
    node->part[0] += w * a;
    node->part[1] -= w * before;
  }
}

/* profile.c: gathers the contacts of a joint, in the same order on all ranks. */
#include "water/uplift.h"

PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows)
{
  PetscInt n_mine = 0, side[2];
  ProfileRow *mine;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n, &mine));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0 || !c->owned[i]) continue;
    for (int k = 0; k < 2; k++) PetscCall(PetscFindInt(c->key[2 * i + k], n_gids, gids, side + k));
    if (side[0] < 0 && side[1] < 0) continue;
    ProfileRow *row = mine + n_mine++;
    for (int k = 0; k < 2; k++) {
      PetscInt v[3];
      ContactEndVertices(c, i, k, v);
      row->key[k] = c->key[2 * i + k];
      row->u_n[k] = c->u_n[SUB(i, k)];
      row->open[k] = !!(c->state[SUB(i, k)] & CONTACT_OPEN);
      for (int x = 0; x < 2; x++) row->point[k][x] = m->mesh.X[2 * v[0] + x];
    }
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(ProfileRow), mine, OrderByPair, n, (void **)rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

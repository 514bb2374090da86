/* profile.c: the contacts of a joint, the same on all ranks. */
#include "forces/water/uplift.h"

static int row_order(const void *a, const void *b)
{
  const ProfileRow *p = a, *q = b;
  for (int i = 0; i < 2; i++)
    if (p->key[i] != q->key[i]) return p->key[i] < q->key[i] ? -1 : 1;
  return 0;
}

/* Collective. All ranks' rows one after the other, on all ranks; free with PetscFree. */
PetscErrorCode GatherAll(MPI_Comm comm, PetscInt n, size_t unit, const void *mine, PetscInt *n_all, void *all)
{
  PetscMPIInt size, bytes, *counts, *starts;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &counts, size + 1, &starts));
  PetscCall(PetscMPIIntCast(n * (PetscInt)unit, &bytes));
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts, 1, MPI_INT, comm));
  starts[0] = 0;
  for (PetscMPIInt r = 0; r < size; r++) starts[r + 1] = starts[r] + counts[r];
  PetscCall(PetscMalloc((size_t)PetscMax(starts[size], 1), (char **)all));
  PetscCallMPI(MPI_Allgatherv(mine, bytes, MPI_BYTE, *(char **)all, counts, starts, MPI_BYTE, comm));
  *n_all = starts[size] / (PetscInt)unit;
  PetscCall(PetscFree2(counts, starts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool ProfileHas(PetscInt n, const PetscInt *sorted, PetscInt gid)
{
  PetscInt low = 0, high = n;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;
    if (sorted[middle] < gid)
      low = middle + 1;
    else
      high = middle;
  }
  return (PetscBool)(low < n && sorted[low] == gid);
}

/* Contacts with a face in the list of gids, by their faces. */
PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows)
{
  PetscInt n_mine = 0;
  ProfileRow *mine;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n, &mine));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || c->key[2 * i + 1] < 0 || !c->owned[i]) continue;
    if (!ProfileHas(n_gids, gids, c->key[2 * i]) && !ProfileHas(n_gids, gids, c->key[2 * i + 1])) continue;
    ProfileRow *row = mine + n_mine++;
    for (int k = 0; k < 2; k++) {
      PetscInt v[3];
      ContactEndVertices(c, i, k, v);
      row->key[k] = c->key[2 * i + k];
      row->u_n[k] = c->u_n[SUB(i, k)];
      row->open[k] = !!(c->state[SUB(i, k)] & CONTACT_OPEN);
      for (int x = 0; x < 2; x++) row->point[k][x] = m->X[2 * v[0] + x];
    }
  }
  PetscCall(GatherAll(m->comm, n_mine, sizeof(ProfileRow), mine, n, rows));
  qsort(*rows, *n, sizeof(ProfileRow), row_order);
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* heirs.c: keeps the list of what new contacts can inherit, the same on all ranks. Of several heirs of a
   contact all ranks take the first by kind and key. */
#include "contacts/heirs.h"

PetscErrorCode HeirsPush(HeirList *list, const Heir *heir)
{
  PetscFunctionBeginUser;
  PetscCall(MakeRoom(sizeof(Heir), list->n, &list->capacity, &list->item));
  list->item[list->n++] = *heir;
  PetscFunctionReturn(PETSC_SUCCESS);
}

int HeirOrder(const void *a, const void *b)
{
  return OrderInts(6, &((const Heir *)a)->model, &((const Heir *)b)->model);
}

PetscErrorCode HeirsShare(MPI_Comm comm, HeirList *heirs)
{
  return GatherSorted(comm, heirs->n, sizeof(Heir), heirs->item, HeirOrder, &heirs->n, (void **)&heirs->item);
}

const Heir *HeirOf(const HeirList *list, const Candidate *now)
{
  const Heir *heirs = list->item;
  const Heir wanted = {.model = (PetscInt)now->model, .key = {now->key[0], now->key[1]}, .kind = -1};
  const PetscInt low = LowerBound(&wanted, heirs, list->n, sizeof(heirs[0]), HeirOrder);
  const PetscBool is_mine = (PetscBool)(low < list->n && heirs[low].model == wanted.model &&
                                        heirs[low].key[0] == now->key[0] && heirs[low].key[1] == now->key[1]);
  return is_mine ? heirs + low : NULL;
}

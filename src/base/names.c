/* names.c: finds names in lists. */
#include "base/base.h"

PetscInt NameRow(PetscInt n, char (*names)[NAME_LENGTH], const char *name)
{
  for (PetscInt i = 0; i < n; i++)
    if (!strcmp(names[i], name)) return i;
  return -1;
}

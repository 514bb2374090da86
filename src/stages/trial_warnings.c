/* trial_warnings.c: warns where the limit that trials have found depends on more than their loads.

   Where several bodies slip on each other, friction without dilation leaves several equilibria under one
   load, and the path of a search decides which of them it reaches. Columns on a stepped base fell at
   k_h = 0.594 by trials, at 0.609 by stages of 0.0015, and at 0.612 by Newton's method. One body on its base
   has one limit. */
#include "stages/stages.h"

enum { SEVERAL = 2 };
/* [-] Displacement over the size of the bodies that shifts a limit by up to half a percent under fixed
   connectivity. */
static const PetscReal SHIFTS = 0.003;

/* Collective. Counts the slipping contacts between two bodies that no support holds. */
static PetscErrorCode count_slipping(const Problem *p, PetscInt *n)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  PetscInt *held, mine = 0;
  PetscFunctionBeginUser;
  PetscCall(HeldBodies(m, &held));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || !c->owned[i]) continue;
    const PetscInt *vertex = c->vertex + CONTACT_ROW(i, 0);
    if (held[m->mesh.vertex_body[vertex[ROW_P]]] || held[m->mesh.vertex_body[vertex[ROW_A]]]) continue;
    mine += ((c->state[SUB(i, 0)] | c->state[SUB(i, 1)]) & CONTACT_SLIPPING) != 0;
  }
  PetscCall(PetscFree(held));
  PetscCallMPI(MPI_Allreduce(&mine, n, 1, MPIU_INT, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode WarnOfPaths(const Problem *p)
{
  PetscInt n;
  PetscFunctionBeginUser;
  PetscCall(count_slipping(p, &n));
  if (n < SEVERAL || p->m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: at the last stable value %d contacts between bodies that may move slip: "
       "friction has several equilibria there, and the limit depends on the path of the load, often by some "
       "percent; compare it with another step, relaxation.method or contact.connectivity",
       p->stage->name, (int)n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void WarnOfShift(const Problem *p, PetscReal moved, PetscReal size)
{
  if (p->m->rank || ContactsVary(p->contacts, p->stage) || !(moved > SHIFTS * size)) return;
  Warn("stage %s: at the last stable value bodies have moved by %.3g m (%.2g %% of their "
       "size), and fixed connectivity leaves contacts where they were: the limit is off by about as much; "
       "use contact.connectivity: variable",
       p->stage->name, (double)moved, (double)(100. * moved / size));
}

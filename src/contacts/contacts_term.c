/* contacts_term.c: makes contacts a force term. The run owns the contacts; the memory of the term is a copy
   of the contacts of the last stable trial. */
#include "contacts/contacts.h"

static PetscErrorCode create(const TermView *v, void **memory)
{
  PetscFunctionBeginUser;
  (void)v;
  PetscCall(PetscCalloc(sizeof(Contacts), memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  PetscFunctionBeginUser;
  (void)scene;
  if (*memory) PetscCall(ContactsDestroy(*memory));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)memory;
  if (at->results)
    PetscCall(ContactForces(at->m, at->joints, at->contacts, at->u, f)); // (1)-(6)
  else
    PetscCall(ContactForcesOnly(at->m, at->joints, at->contacts, at->u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode add_rows(const Instant *at, PetscBool anywhere, PetscBool drag, PetscReal *k)
{
  PetscFunctionBeginUser;
  if (anywhere)
    PetscCall(ContactStiffnessAnywhere(at->scene, at->m, at->joints, drag, k));
  else
    PetscCall(ContactStiffness(at->joints, at->contacts, at->m->materials.thickness, drag, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode bound(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  PetscFunctionBeginUser;
  (void)memory;
  PetscCall(add_rows(at, anywhere, PETSC_FALSE, k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode drag(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *c)
{
  PetscFunctionBeginUser;
  (void)memory;
  PetscCall(add_rows(at, anywhere, PETSC_TRUE, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode energy(const void *memory, const Instant *at, PetscReal *sum)
{
  PetscFunctionBeginUser;
  (void)memory;
  *sum += EnergyInJoints(at->m, at->joints, at->contacts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  PetscFunctionBeginUser;
  (void)memory;
  PetscCall(ContactsTangent(at, kind, add, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode history(const TermView *v, TermHistory what)
{
  Contacts *stable = v->memory;
  PetscBool counted;
  PetscFunctionBeginUser;
  switch (what) {
  case COMMIT:
    ContactsCommit(v->contacts);
    break;
  case GO_BACK:
    ContactsGoBack(v->contacts);
    break;
  case KEEP_STABLE:
    PetscCall(ContactsDestroy(stable));
    PetscCall(ContactsCopy(v->contacts, stable));
    break;
  case BACK_TO_STABLE:
    counted = v->contacts->counted; // belongs to the run, not to the stable trial
    PetscCall(ContactsDestroy(v->contacts));
    PetscCall(ContactsCopy(stable, v->contacts));
    v->contacts->counted = counted;
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  PetscFunctionBeginUser;
  PetscCall(ArchiveContacts(a, v->scene, v->m, "contacts", v->contacts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive_stable(Archive *a, const TermView *v)
{
  Contacts *stable = v->memory;
  PetscInt outgrown = stable->outgrown;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "outgrown", 1, &outgrown));
  PetscCall(ArchiveContacts(a, v->scene, v->m, "contacts", stable));
  stable->outgrown = (PetscBool)outgrown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Contacts_term = {.name = "contacts",
                                .phase = PHASE_JOINTS,
                                .create = create,
                                .destroy = destroy,
                                .forces = forces,
                                .bound = bound,
                                .drag = drag,
                                .energy = energy,
                                .tangent = tangent,
                                .history = history,
                                .archive = archive,
                                .archive_stable = archive_stable};

/* place.c: finds the contacts of blocks that a lift places on others. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* Makes a contact closed, without slip and stress, at the openings and slidings that it has in `now`. */
static void close_here(const Contacts *now, PetscInt at, Contacts *c)
{
  for (int k = 0; k < 2; k++) {
    const PetscInt j = SUB(at, k);
    c->rest[j] = now->u_n[j];
    c->slip[j] = c->slip_0[j] = c->u_s_0[j] = now->u_s[j];
    c->u_n_0[j] = PETSC_MAX_REAL; // it has not carried a force yet
  }
}

PetscErrorCode ContactsPlace(const Scene *scene, const Model *m, const Joint *joints, const PetscReal *u,
                             Contacts *c)
{
  Contacts all, probe;
  OldContacts old;
  PetscReal *f;
  bool *is_new;
  PetscFunctionBeginUser;
  PetscCall(ContactsCreate(scene, m, &all));
  PetscCall(OldContactsCreate(c, &old));
  PetscCall(PetscCalloc1(all.n_padded, &is_new));
  for (PetscInt at = 0; at < all.n_padded; at++) {
    if (all.key[2 * at] < 0) continue;
    const PetscInt from = OldContactFind(&old, all.key[2 * at], all.key[2 * at + 1]);
    is_new[at] = from < 0;
    if (from >= 0) ContactsCopyOne(c, from, &all, at);
    for (int k = 0; k < 2 && from < 0; k++) all.rest[SUB(at, k)] = 0.;
  }
  PetscCall(OldContactsDestroy(&old));
  ContactsSetTraits(m, &all);
  PetscCall(ContactsCopy(&all, &probe));
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &f));
  PetscCall(ContactForces(m, joints, &probe, u, f));
  for (PetscInt at = 0; at < all.n_padded; at++)
    if (is_new[at]) close_here(&probe, at, &all);
  PetscCall(PetscFree(f));
  PetscCall(PetscFree(is_new));
  PetscCall(ContactsDestroy(&probe));
  ContactsSetTraits(m, &all);
  all.friction = c->friction, all.pull = c->pull, all.counted = c->counted;
  all.rate = c->rate, all.lead = c->lead, all.repeats = c->repeats, all.margin = c->margin;
  PetscCall(ContactsDestroy(c));
  *c = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* stone_order.c: measures how regular the stones are: courses of blocks, or rubble.

   A joint of length L has the direction theta. The four-fold order of a stone is

     |sum L exp(4 i theta)| / sum L

   over its joints: 1 where all its joints are parallel or square to each other, whichever way the stone is
   turned, about 0.4 for the polygon of a Voronoi pattern. The sums are binned (reproducible.h), so the number
   has the same bits on any number of ranks. */
#include "contacts/contacts.h"
#include "base/reproducible.h"

/* Sums of a stone, two bins each: L cos(4 theta), L sin(4 theta), L. */
enum { SUMS = 3, BINNED = 2 * SUMS };

/* Adds the owned contacts of this rank to the sums (n_bodies_global, BINNED) of their stones. */
static void add_contacts(const Model *m, const Contacts *c, const Bins *bins, PetscReal *sum)
{
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0 || !c->owned[i]) continue;
    const PetscInt a = c->vertex[CONTACT_ROW(i, ROW_A)], b = c->vertex[CONTACT_ROW(i, ROW_B)];
    const PetscReal x = m->mesh.X[2 * b] - m->mesh.X[2 * a], y = m->mesh.X[2 * b + 1] - m->mesh.X[2 * a + 1],
                    square = x * x + y * y, c2 = (x * x - y * y) / square, s2 = 2. * x * y / square,
                    L = c->length[i];
    const PetscReal term[SUMS] = {L * (c2 * c2 - s2 * s2), 2. * L * c2 * s2, L};
    const PetscInt stone[2] = {m->mesh.vertex_body[a], m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_P)]]};
    for (int side = 0; side < 2; side++)
      for (int k = 0; k < SUMS; k++) BinAdd(bins, term[k], sum + BINNED * stone[side] + 2 * k);
  }
}

PetscErrorCode ContactsOrder(const Model *m, const Contacts *c, PetscReal *order)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscReal longest = 0., *sum, parts = 0., whole = 0.;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0) longest = PetscMax(longest, c->length[i]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &longest, 1, MPIU_REAL, MPI_MAX, m->comm));
  const Bins bins = BinsFor(PetscMax(longest, 1e-290));
  PetscCall(PetscCalloc1(BINNED * n, &sum));
  add_contacts(m, c, &bins, sum);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(BINNED * n), MPIU_REAL, MPI_SUM, m->comm));
  for (const PetscReal *s = sum; s < sum + BINNED * n; s += BINNED) {
    parts += PetscSqrtReal((s[0] + s[1]) * (s[0] + s[1]) + (s[2] + s[3]) * (s[2] + s[3]));
    whole += s[4] + s[5];
  }
  *order = whole > 0. ? parts / whole : 1.;
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

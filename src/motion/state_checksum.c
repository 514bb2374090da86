/* state_checksum.c: proofs that the parallel run is the serial one. */
#include "motion/motion.h"

static uint64_t hash_reals(uint64_t number, PetscInt n, const PetscReal *x)
{
  uint64_t h = HashWord(number);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal value = x[i] + 0.; // -0 and +0 are the same state
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    h = HashWord(h ^ bits);
  }
  return h;
}

PetscErrorCode StateChecksum(const Model *m, const State *state, const Contacts *c, uint64_t *checksum)
{
  const PetscInt at = 3 * m->n_bodies;
  uint64_t sum = 0;
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < m->n_owned; v++)
    sum += hash_reals((uint64_t)m->vertex_gid[v], 2, state->u + at + 2 * v);
  for (PetscInt v = 0; v < m->n_deformable; v++)
    sum += hash_reals((uint64_t)m->vertex_gid[v] + (1ull << 40), 2, state->v + at + 2 * v);
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    sum += hash_reals((uint64_t)m->body_gid[b] + (2ull << 40), 3, state->u + 3 * b);
    sum += hash_reals((uint64_t)m->body_gid[b] + (3ull << 40), 3, state->v + 3 * b);
  }
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (!c->owned[i]) continue;
    const PetscReal history[4] = {c->slip[SUB(i, 0)], c->slip[SUB(i, 1)], c->broken[SUB(i, 0)],
                                  c->broken[SUB(i, 1)]};
    const PetscReal crushed[4] = {c->closure[SUB(i, 0)], c->closure[SUB(i, 1)], c->closure_far[SUB(i, 0)],
                                  c->closure_far[SUB(i, 1)]};
    const uint64_t name = HashWord((uint64_t)c->key[2 * i]) ^ (uint64_t)c->key[2 * i + 1];
    sum += hash_reals(name, 4, history);
    if (crushed[0] < 0. || crushed[1] < 0.) sum += hash_reals(HashWord(name), 4, crushed);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, m->comm));
  *checksum = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

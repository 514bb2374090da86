/* checksum.c: proofs that the parallel run is the serial one. */
#include "internal.h"

/* splitmix64: spreads every bit of a number over the word. */
static uint64_t spread(uint64_t x)
{
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

uint64_t HashBytes(uint64_t seed, const void *data, size_t bytes)
{
  const char *at = data;
  uint64_t h = spread(seed ^ bytes), word;
  for (size_t i = 0; i < bytes; i += sizeof(word)) {
    word = 0;
    memcpy(&word, at + i, PetscMin(sizeof(word), bytes - i));
    h = spread(h ^ word);
  }
  return h;
}

uint64_t MeshChecksum(const BlockMesh *b)
{
  uint64_t h = HashBytes(0, b->X, 2 * (size_t)b->n_vertices * sizeof(PetscReal));
  const PetscInt nb = b->n_blocks;
  h = HashBytes(h, b->blocks, 4 * (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->block_group, (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->block_file, (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->group_rigid, (size_t)b->n_groups * sizeof(PetscInt));
  for (PetscInt g = 0; g < b->n_groups; g++) h = HashBytes(h, b->group_names[g], strlen(b->group_names[g]));
  for (PetscInt s = 0; s < b->n_face_sets; s++) {
    h = HashBytes(h, b->face_sets[s].name, strlen(b->face_sets[s].name));
    h = HashBytes(h, b->face_sets[s].faces, 2 * (size_t)b->face_sets[s].n * sizeof(PetscInt));
  }
  return HashBytes(h, b->point_vertex, (size_t)b->n_points * sizeof(PetscInt));
}

static uint64_t hash_reals(uint64_t number, PetscInt n, const PetscReal *x)
{
  uint64_t h = spread(number);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal value = x[i] + 0.; // -0 and +0 are the same state
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    h = spread(h ^ bits);
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
    const uint64_t name = spread((uint64_t)c->key[2 * i]) ^ (uint64_t)c->key[2 * i + 1];
    sum += hash_reals(name, 4, history);
    if (crushed[0] < 0. || crushed[1] < 0.) sum += hash_reals(spread(name), 4, crushed);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, m->comm));
  *checksum = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every vertex, block and rigid body is owned once; element lists ascend; indices stay inside; ghosts carry
   their owner's coordinates. */
PetscErrorCode ModelIsValid(const Model *m, PetscBool *valid)
{
  const Elements *list[6] = {&m->q4, &m->t3, &m->rigid_q4, &m->rigid_t3, &m->condensed_q4, &m->condensed_t3};
  PetscInt count[4] = {m->n_owned, 0, m->n_bodies, 0};
  PetscReal *X;
  PetscFunctionBeginUser;
  for (int l = 0; l < 6; l++)
    for (PetscInt e = 0, n_nodes = l % 2 ? 3 : 4; e < list[l]->n; e++) {
      count[1] += list[l]->owned[e];
      count[3] += e && list[l]->gid[e] <= list[l]->gid[e - 1];
      for (PetscInt k = 0; k < n_nodes; k++) {
        const PetscInt v = list[l]->vertex[((e / BATCH) * n_nodes + k) * BATCH + e % BATCH];
        count[3] += v < 0 || v >= m->n_vertices;
      }
    }
  PetscCall(PetscMalloc1(2 * m->n_vertices, &X));
  for (PetscInt i = 0; i < 2 * m->n_vertices; i++) X[i] = i < 2 * m->n_owned ? m->X[i] : PETSC_INFINITY;
  PetscCall(GhostBegin(m, X));
  PetscCall(GhostEnd(m, X));
  for (PetscInt i = 0; i < 2 * m->n_vertices; i++) count[3] += X[i] != m->X[i];
  PetscCall(PetscFree(X));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 4, MPIU_INT, MPI_SUM, m->comm));
  *valid = (PetscBool)(count[0] == m->n_vertices_global && count[1] == m->n_blocks_global &&
                       count[2] == m->n_rigid_global && count[3] == 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

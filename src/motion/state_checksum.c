/* state_checksum.c: computes the checksum of a state, which shows that runs on any number of ranks agree. */
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

/* Collects the values of contact i from n arrays into x, both ends of an array after each other. Returns
   their number. */
static PetscInt history_of(PetscInt i, int n, PetscReal *const array[], PetscReal x[2 * END_ARRAYS])
{
  for (int a = 0; a < n; a++)
    for (int k = 0; k < 2; k++) x[2 * a + k] = array[a][SUB(i, k)];
  return 2 * n;
}

/* Adds up the hashes. n_vertices: number of owned vertices that count, the first ones. */
static PetscErrorCode checksum_of(const Model *m, PetscInt n_vertices, const State *state, const Contacts *c,
                                  uint64_t *checksum)
{
  const PetscInt at = 3 * m->rigid.n;
  uint64_t sum = 0;
  PetscReal *history[END_ARRAYS], *crushed[END_ARRAYS], x[2 * END_ARRAYS] = {0.};
  const int n_history = ContactsEndArrays(c, FIELD_HISTORY, history),
            n_crushed = ContactsEndArrays(c, FIELD_CRUSHED, crushed);
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < n_vertices; v++)
    sum += hash_reals((uint64_t)m->mesh.vertex_gid[v], 2, state->u + at + 2 * v);
  for (PetscInt v = 0; v < m->mesh.n_deformable; v++)
    sum += hash_reals((uint64_t)m->mesh.vertex_gid[v] + (1ull << 40), 2, state->v + at + 2 * v);
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    sum += hash_reals((uint64_t)m->rigid.gid[b] + (2ull << 40), 3, state->u + 3 * b);
    sum += hash_reals((uint64_t)m->rigid.gid[b] + (3ull << 40), 3, state->v + 3 * b);
  }
  for (PetscInt b = 0; b < m->condensed.n && m->condensed.mode_start; b++)
    for (PetscInt k = 0; k < m->condensed.body[b].n_modes; k++) {
      const PetscInt row = m->condensed.body[b].first_mode + k;
      const PetscReal mode[2] = {state->modes[MODE_PLACE][row], state->modes[MODE_SPEED][row]};
      if (mode[0] == 0. && mode[1] == 0.) continue; // at rest it adds nothing, whatever the number of modes
      sum += hash_reals((uint64_t)(m->condensed.mode_start[m->condensed.body[b].number] + k) + (4ull << 40),
                        2, mode);
    }
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (!c->owned[i]) continue;
    const uint64_t name = HashWord((uint64_t)c->key[2 * i]) ^ (uint64_t)c->key[2 * i + 1];
    PetscInt n = history_of(i, n_history, history, x);
    sum += hash_reals(name, n, x);
    if (!(c->closure[SUB(i, 0)] < 0. || c->closure[SUB(i, 1)] < 0.)) continue;
    n = history_of(i, n_crushed, crushed, x);
    sum += hash_reals(HashWord(name), n, x);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, m->comm));
  *checksum = sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateChecksum(const Model *m, const State *state, const Contacts *c, uint64_t *checksum)
{
  PetscFunctionBeginUser;
  PetscCall(checksum_of(m, m->mesh.n_owned, state, c, checksum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateChecksumKept(const Model *m, const State *state, const Contacts *c, uint64_t *checksum)
{
  PetscFunctionBeginUser;
  PetscCall(checksum_of(m, m->mesh.n_moving, state, c, checksum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Adds the temperature of the blocks: the mean of each, and the stresses from it at its
   points. */
static PetscErrorCode add_warmth(const TermView *view, uint64_t *checksum)
{
  const Model *m = view->m;
  uint64_t sum = 0;
  PetscFunctionBeginUser;
  for (int l = 0; l < ELEMENT_LISTS; l++) {
    const Elements *e = m->mesh.elements + l;
    PetscReal *change;
    PetscCall(PetscCalloc1(e->n_padded + 1, &change));
    PetscCall(TermsOfBlocks(view, e, &(BlockAnswers){.change = change}));
    for (PetscInt b = 0; b < e->n; b++)
      if (e->owned[b] && change[b] != 0.)
        sum += hash_reals((uint64_t)e->gid[b] + (5ull << 40), 1, change + b);
    PetscCall(PetscFree(change));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, m->comm));
  *checksum += sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateChecksumTerms(const Scene *scene, const Model *m, const State *state, Contacts *c,
                                  uint64_t *checksum)
{
  const TermView view = {.scene = scene, .m = m, .contacts = c, .state = state};
  PetscFunctionBeginUser;
  PetscCall(TermsDigest(&view, checksum));
  if (state->applied.n_loads) PetscCall(add_warmth(&view, checksum)); // a load of the scene is a temperature
  PetscFunctionReturn(PETSC_SUCCESS);
}

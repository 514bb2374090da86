/* The arrays of contacts. Their memory does not overlap, copies are deep, and their list CONTACT_FIELDS says
   which of them a checkpoint and the checksum contain. */
#include "motion/motion.h"
#include "check.h"

enum { CONTACTS = 3 * BATCH };
static const size_t Numbers[] = {[PER_CONTACT] = 1, [PER_FACE] = 2, [PER_ROW] = CONTACT_ROWS, [PER_END] = 2};

/* A byte for this array, place and copy. It is never zero, and reals made of such bytes are never NaN. */
static int byte_of(int array, size_t i, int copy)
{
  return 1 + (int)((31 * (size_t)array + 7 * i + 3 * (size_t)copy) % 60);
}

/* Writes every byte of every array; has_all tells whether they are all there. */
static void write_all(Contacts *c, int copy)
{
  int array = 0;
#define WRITE(type, name, shape, kind, room)                                                                 \
  for (size_t i = 0; i < Numbers[shape] * CONTACTS * sizeof(type); i++)                                      \
    ((char *)c->name)[i] = (char)byte_of(array, i, copy);                                                    \
  array++;
  CONTACT_FIELDS(WRITE)
#undef WRITE
}

static int has_all(const Contacts *c, int copy)
{
  int array = 0, same = 1;
#define HAS(type, name, shape, kind, room)                                                                   \
  for (size_t i = 0; i < Numbers[shape] * CONTACTS * sizeof(type); i++)                                      \
    same &= ((const char *)c->name)[i] == (char)byte_of(array, i, copy);                                     \
  array++;
  CONTACT_FIELDS(HAS)
#undef HAS
  return same;
}

static PetscErrorCode CopiesAreDeep(void)
{
  Contacts c = {.n = CONTACTS, .n_padded = CONTACTS, .rate = 3.}, copy;
  PetscFunctionBeginUser;
  PetscCall(ContactsAllocate(&c));
  for (PetscInt i = 0; i < 2 * CONTACTS; i++) ENSURE(c.t[i] == 0. && c.slip[i] == 0. && !c.state[i]);
  write_all(&c, 0);
  ENSURE(has_all(&c, 0));
  PetscCall(ContactsCopy(&c, &copy));
  ENSURE(has_all(&copy, 0));
  ENSURE(copy.n == CONTACTS && copy.rate == 3.);
  write_all(&c, 1);
  ENSURE(has_all(&c, 1));
  ENSURE(has_all(&copy, 0));
  PetscCall(ContactsDestroy(&c));
  ENSURE(!c.key && !c.t && !c.closure_far_0);
  ENSURE(has_all(&copy, 0));
  PetscCall(ContactsDestroy(&copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One contact goes to another place of another batch, with all that is its own, and nothing beside it. */
static PetscErrorCode OneContactIsCopied(void)
{
  enum { FROM = 3, AT = BATCH + 5 };
  Contacts c = {.n_padded = CONTACTS}, other = {.n_padded = CONTACTS};
  PetscFunctionBeginUser;
  PetscCall(ContactsAllocate(&c));
  PetscCall(ContactsAllocate(&other));
  write_all(&c, 0);
  for (PetscInt i = 0; i < CONTACTS; i++) c.owned[i] = i % 2 == 1; // read as what it is
  ContactsCopyOne(&c, FROM, &other, AT);
  ENSURE(other.key[2 * AT] == c.key[2 * FROM] && other.key[2 * AT + 1] == c.key[2 * FROM + 1]);
  ENSURE(other.klass[AT] == c.klass[FROM] && other.joint[AT] == c.joint[FROM]);
  ENSURE(other.length[AT] == c.length[FROM] && other.owned[AT] == c.owned[FROM]);
  for (int row = 0; row < CONTACT_ROWS; row++)
    ENSURE(other.vertex[CONTACT_ROW(AT, row)] == c.vertex[CONTACT_ROW(FROM, row)]);
  PetscReal *from[END_ARRAYS], *to[END_ARRAYS];
  const int n = ContactsEndArrays(&c, FIELD_ANY, from);
  ContactsEndArrays(&other, FIELD_ANY, to);
  for (int k = 0; k < 2; k++) {
    ENSURE(other.state[SUB(AT, k)] == c.state[SUB(FROM, k)]);
    for (int i = 0; i < n; i++) ENSURE(to[i][SUB(AT, k)] == from[i][SUB(FROM, k)]);
  }
  for (PetscInt j = 0; j < 2 * CONTACTS; j++)
    for (int i = 0; i < n && j != SUB(AT, 0) && j != SUB(AT, 1); i++) ENSURE(to[i][j] == 0.);
  PetscCall(ContactsDestroy(&c));
  PetscCall(ContactsDestroy(&other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A checkpoint has no names of columns: this order is the format. Who must change it here raises the
   version of checkpoints. */
static PetscErrorCode ColumnsOfCheckpointsAreThose(void)
{
  Contacts c = {.n_padded = CONTACTS};
  PetscReal *array[END_ARRAYS];
  PetscFunctionBeginUser;
  PetscCall(ContactsAllocate(&c));
  PetscReal *const expected[] = {c.t,       c.rest,        c.slip,      c.broken,       c.u_n,   c.u_s,
                                 c.speed,   c.speed_old,   c.speed_now, c.sigma,        c.tau,   c.F_n,
                                 c.F_s,     c.slip_0,      c.broken_0,  c.u_n_0,        c.u_s_0, c.moved,
                                 c.closure, c.closure_far, c.closure_0, c.closure_far_0};
  ENSURE(sizeof(expected) == sizeof(array));
  ENSURE(ContactsEndArrays(&c, FIELD_ANY, array) == END_ARRAYS);
  for (int i = 0; i < END_ARRAYS; i++) ENSURE(array[i] == expected[i]);
  ENSURE(ContactsEndArrays(&c, FIELD_CRUSHES, array) == CRUSHES_ARRAYS);
  for (int i = 0; i < CRUSHES_ARRAYS; i++) ENSURE(array[i] == expected[END_ARRAYS - CRUSHES_ARRAYS + i]);
  PetscCall(ContactsDestroy(&c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Slip, broken part and both ends of what was crushed; nothing else that ends have. */
static PetscErrorCode ChecksumTakesTheHistory(void)
{
  Contacts c = {.n_padded = CONTACTS};
  const Model m = {.comm = PETSC_COMM_SELF};
  const State state = {.dt = 1.};
  PetscReal *array[END_ARRAYS], *history[END_ARRAYS];
  uint64_t before, after;
  PetscFunctionBeginUser;
  PetscCall(ContactsAllocate(&c));
  const int n = ContactsEndArrays(&c, FIELD_ANY, array),
            n_history = ContactsEndArrays(&c, FIELD_HISTORY | FIELD_CRUSHED, history);
  ENSURE(n_history == 4 && history[0] == c.slip && history[1] == c.broken && history[2] == c.closure &&
         history[3] == c.closure_far);
  for (PetscInt i = 0; i < CONTACTS; i++)
    c.owned[i] = true, c.key[2 * i + 1] = i, c.closure[SUB(i, 0)] = c.closure[SUB(i, 1)] = -1.;
  PetscCall(StateChecksum(&m, &state, &c, &before));
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 2; k++) {
      int is_history = 0;
      const PetscReal kept = array[i][SUB(9, k)];
      for (int h = 0; h < n_history; h++) is_history |= array[i] == history[h];
      array[i][SUB(9, k)] = -2.;
      PetscCall(StateChecksum(&m, &state, &c, &after));
      ENSURE((after != before) == is_history);
      array[i][SUB(9, k)] = kept;
    }
  PetscCall(ContactsDestroy(&c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  RUN_TEST(CopiesAreDeep);
  RUN_TEST(OneContactIsCopied);
  RUN_TEST(ColumnsOfCheckpointsAreThose);
  RUN_TEST(ChecksumTakesTheHistory);
  int failed = CheckSummary();
  PetscCall(PetscFinalize());
  return failed;
}

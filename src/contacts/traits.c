/* traits.c: finds what LANES contacts have in common, decides which stresses are only rounding, and commits
   the history. */
#include "contacts/contacts.h"
#include "contacts/traits.h"
#include "base/reproducible.h"

/* Decides whether both ends of LANES contacts have +0. The bits are compared, because a -0 that is not read
   would change the sign of a zero in the answer. */
static int are_zero(PetscInt first, const PetscReal *x)
{
  uint64_t bits[2 * LANES], any = 0;
  memcpy(bits, x + SUB(first, 0), LANES * sizeof *x);
  memcpy(bits + LANES, x + SUB(first, 1), LANES * sizeof *x);
  for (int i = 0; i < 2 * LANES; i++) any |= bits[i];
  return !any;
}

static int same_place(const PetscReal *x, const PetscReal *y)
{
  return x[0] == y[0] && x[1] == y[1];
}

/* Decides whether the faces of contact i match: in the reference state their vertices stand in the same
   places. */
static int faces_match(const PetscReal *X, const Contacts *c, PetscInt i)
{
  const PetscReal *x[CONTACT_ROWS];
  for (int row = 0; row < CONTACT_ROWS; row++) x[row] = X + 2 * c->vertex[CONTACT_ROW(i, row)];
  return c->klass[i] == FF1_12 && c->t[SUB(i, 0)] == 1. && c->t[SUB(i, 1)] == 0. &&
         same_place(x[ROW_P], x[ROW_B]) && same_place(x[ROW_Q], x[ROW_A]);
}

void ContactsSetTraits(const Model *m, Contacts *c)
{
  for (PetscInt first = 0; first < c->n_padded; first += LANES) {
    const PetscInt *joint = c->joint + first;
    int traits = !first || memcmp(joint - LANES, joint, LANES * sizeof *joint) ? JOINTS : 0;
    int match = 1;
    for (int lane = 0; lane < LANES; lane++) {
      const int klass = c->klass[first + lane];
      match &= faces_match(m->mesh.X, c, first + lane);
      if (klass == FF2_I || klass == FF2_F) traits |= CROSSED << lane;
      if (klass == FF2_F) traits |= LAST << lane;
    }
    if (match) traits |= MATCH;
    if (!are_zero(first, c->rest)) traits |= RESTS;
    if (!are_zero(first, c->slip) || !are_zero(first, c->broken) || !are_zero(first, c->slip_0) ||
        !are_zero(first, c->broken_0))
      traits |= HISTORY;
    if (!are_zero(first, c->closure) || !are_zero(first, c->closure_0)) traits |= HISTORY | CRUSHED;
    c->traits[first / LANES] = (uint16_t)traits;
  }
}

/* ---- when a stress is more than rounding */

static const PetscReal TOLERANCES = 10.;  /* [-] in tolerances of a stage: its unbalanced forces are
                                             smaller */
static const PetscReal ROUNDING = 1e-9;   /* [-] least margin over the stresses around; in stages in time
                                             too */
static const PetscReal DIGITS = 8.;       /* [-] error of coordinates, in units of the last digit */
static const PetscReal NEGLIGIBLE = 1e-5; /* [-] largest margin: a strength so small does not matter */

PetscErrorCode ContactsSetMargin(const Model *m, const Joint *joints, const State *state, PetscReal tolerance,
                                 Contacts *c)
{
  enum { LOAD, STRESS, PLACE, STIFFNESS, ALL };
  const PetscReal *f = state->applied.target;
  PetscReal most[ALL] = {0.}, sum[2] = {0., 0.};
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (d >= 3 * m->rigid.n || d % 3 < 2) most[LOAD] = PetscMax(most[LOAD], PetscAbsReal(f[d]));
  for (PetscInt i = 0; i < 2 * c->n_padded; i++)
    if (PetscAbsReal(c->sigma[i]) < PETSC_MAX_REAL)
      most[STRESS] = PetscMax(most[STRESS], PetscAbsReal(c->sigma[i]));
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++)
    most[PLACE] = PetscMax(most[PLACE], PetscAbsReal(m->mesh.X[i]));
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0) most[STIFFNESS] = PetscMax(most[STIFFNESS], joints[c->joint[i]].k_n);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, ALL, MPIU_REAL, MPI_MAX, m->comm));
  const Bins bins = BinsFor(PetscMax(most[LOAD], 1e-290));
  for (PetscInt d = 0; d < m->n_dof && most[LOAD] < PETSC_MAX_REAL / 4.; d++)
    if (d >= 3 * m->rigid.n || d % 3 < 2) BinAdd(&bins, PetscAbsReal(f[d]), sum);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, m->comm));
  const PetscReal stress = PetscMax(most[STRESS],
                                    (sum[0] + sum[1]) / (m->mesh.diameter * m->materials.thickness)),
                  part = PetscMin(NEGLIGIBLE, PetscMax(ROUNDING, TOLERANCES * tolerance)),
                  drawn = DIGITS * PETSC_MACHINE_EPSILON * most[PLACE] * most[STIFFNESS];
  c->margin = stress < PETSC_MAX_REAL ? PetscMax(part * stress, drawn) : drawn;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history */

/* Copies a history. Contacts without the trait HISTORY are left out, because both histories are zero
   there. */
static void copy_history(const Contacts *c, History from, History to)
{
  for (PetscInt first = 0; first < c->n_padded; first += LANES)
    for (int k = 0; k < 2 && c->traits[first / LANES] & HISTORY; k++) {
      const PetscInt at = SUB(first, k);
      memcpy(to.slip + at, from.slip + at, LANES * sizeof *to.slip);
      memcpy(to.broken + at, from.broken + at, LANES * sizeof *to.broken);
      if (!(c->traits[first / LANES] & CRUSHED)) continue;
      memcpy(to.closure + at, from.closure + at, LANES * sizeof *to.closure);
      memcpy(to.far + at, from.far + at, LANES * sizeof *to.far);
    }
}

void ContactsCommit(Contacts *c)
{
  copy_history(c, HistoryNow(c), HistoryCommitted(c));
  if (!ContactsFromCommitted(c)) c->friction = FRICTION_LAW;
}

void ContactsGoBack(Contacts *c)
{
  copy_history(c, HistoryCommitted(c), HistoryNow(c));
}

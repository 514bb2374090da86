/* condense_large.c: corrects condensed bodies for large strain, where the program has chosen them.

   In large strain the blocks of a body have the forces F(u) = K u + N(u), with the K of condense.c. N is
   about the turn and the strain times K u. The body keeps its factor and its S, and takes N of the last
   correction as a force that does not change:

     S u_B + e = f_B - g,   e = N_B - K_BI K_II^-1 N_I,                                                   (c)

   and (a) with f_I - N_I. At an equilibrium of (c) the inside is recovered, and N is found there. Where e has
   changed, the stage goes on to the equilibrium with the new e. This is Newton's method with K in place of
   the tangent: each round multiplies the error by about the turn of the body, and it ends in the equilibrium
   of the blocks. Loads on faces act where these were at the last correction. */
#include "blocks/blocks.h"
#include <float.h>

/* Change of e over the forces at kept vertices, in tolerances of the stage, that needs another round. A
   residual as large as the tolerance is out of balance anyway. */
static const PetscReal LEAST_CHANGE = 3.;
/* Rounds in which bodies that turn little have come to an end. */
enum { MOST_ROUNDS = 8 };

/* Computes e of a force N (vertex array) into the kept entries of e (vertex array). */
static PetscErrorCode pass_on(const Model *m, const PetscReal *N, PetscReal *e)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *w, *K_w;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(n, &w, n, &K_w));
  for (PetscInt b = 0; b < m->condensed.n; b++)
    PetscCall(CondensedSolve(m->condensed.body + b, m->condensed.body[b].inner, N, w));
  ElementForcesCondensed(m, w, K_w);
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt i = 0; i < c->n_kept; i++) e[c->kept[i]] = N[c->kept[i]] - K_w[c->kept[i]];
  PetscCall(PetscFree2(w, K_w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void take(const Model *m, const PetscReal *e)
{
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt i = 0; i < c->n_kept; i++) c->corrects[i] = e[c->kept[i]];
}

PetscErrorCode CondensedTakeNonlinear(const Model *m, const State *s)
{
  const PetscInt at = 3 * m->rigid.n, n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *N, *e;
  PetscFunctionBeginUser;
  if (!s->nonlinear || !m->condensed.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(n, &N, n, &e));
  PetscCall(PetscArraycpy(N, s->nonlinear + at, ModelApplied(m) - at));
  PetscCall(pass_on(m, N, e));
  take(m, e);
  PetscCall(PetscFree2(N, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes N and e of the recovered state, and the change of e over the forces at kept vertices of all
   ranks. */
static PetscErrorCode measure(const Model *m, const State *s, PetscReal *N, PetscReal *e, PetscReal *change)
{
  const PetscInt at = 3 * m->rigid.n, n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal sum[2] = {0., 0.}, *K_u, *f;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(n, &K_u, n, &f));
  ElementForcesTurned(m, s->u + at, N);
  ElementForcesCondensed(m, s->u + at, K_u);
  for (PetscInt d = 0; d < n; d++) N[d] -= K_u[d];
  PetscCall(pass_on(m, N, e));
  CondensedAddForces(m, s->u + at, f);
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt i = 0; i < c->n_kept; i++) {
      sum[0] += PetscAbsReal(e[c->kept[i]] - c->corrects[i]);
      sum[1] += PetscAbsReal(f[c->kept[i]]);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, m->comm));
  *change = sum[0] > 0. ? sum[0] / PetscMax(sum[1], DBL_MIN) : sum[0]; // NaN stays
  PetscCall(PetscFree2(K_u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedCorrect(Model *m, State *s, PetscReal tolerance, PetscBool *again)
{
  const PetscInt at = 3 * m->rigid.n, n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *N, *e, change;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  if (!m->condensed.large) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CondensedRecover(m, s));
  PetscCall(PetscCalloc2(n, &N, n, &e));
  PetscCall(measure(m, s, N, e, &change));
  *again = (PetscBool) !(change <= LEAST_CHANGE * tolerance);
  if (*again && ++m->condensed.rounds > MOST_ROUNDS) m->condensed.leave = "a body turns or strains too far";
  if (*again) {
    PetscCall(PetscArraycpy(s->nonlinear + at, N, ModelApplied(m) - at));
    PetscCall(PetscArraycpy(s->corrected, s->u, ModelApplied(m)));
    take(m, e);
  }
  PetscCall(PetscFree2(N, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedLack(const Model *m, const State *s, PetscReal *lack)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *N, *e, change;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(n, &N, n, &e));
  PetscCall(measure(m, s, N, e, &change));
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt i = 0; i < c->n_kept; i++) lack[c->kept[i]] += e[c->kept[i]] - c->corrects[i];
  PetscCall(PetscFree2(N, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

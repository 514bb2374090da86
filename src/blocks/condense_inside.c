/* condense_inside.c: passes loads inside condensed bodies on to their kept vertices, and recovers their
   inside (condense.c: (a) and (b)). */
#include "blocks/blocks.h"

PetscErrorCode CondensedLoads(const Model *m, PetscReal *f)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *w = NULL, *f_w;
  PetscBool *is_changed;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->condensed.n, &is_changed));
  for (PetscInt b = 0; b < m->condensed.n; b++) {
    Condensed *c = m->condensed.body + b;
    PetscBool changed = PETSC_FALSE;
    for (PetscInt i = 0; i < c->n_inner; i++) {
      if (c->load[i] != f[c->inner[i]]) changed = PETSC_TRUE;
      c->load[i] = f[c->inner[i]];
    }
    is_changed[b] = changed;
    if (changed && !w) PetscCall(PetscCalloc2(n, &w, n, &f_w));
  }
  if (w) { // g of (b)
    for (PetscInt b = 0; b < m->condensed.n; b++)
      if (is_changed[b]) PetscCall(CondensedSolve(m->condensed.body + b, m->condensed.body[b].inner, f, w));
    ElementForcesCondensed(m, w, f_w);
    for (PetscInt b = 0; b < m->condensed.n; b++) {
      Condensed *c = m->condensed.body + b;
      if (!is_changed[b]) continue;
      for (PetscInt i = 0; i < c->n_kept; i++) c->g[i] = f_w[c->kept[i]];
      c->stored = 0.;
      for (PetscInt i = 0; i < c->n_inner; i++) c->stored += 0.5 * c->load[i] * w[c->inner[i]];
    }
    PetscCall(PetscFree2(w, f_w));
  }
  PetscCall(PetscFree(is_changed));
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++)
    for (PetscInt i = 0; i < c->n_kept; i++) f[c->kept[i]] -= c->g[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedLoadsFind(const Model *m, const PetscReal *target)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *f;
  PetscFunctionBeginUser;
  if (!m->condensed.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n, &f));
  PetscCall(PetscArraycpy(f, target, n));
  PetscCall(CondensedLoads(m, f));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedInner(const Model *m, const PetscReal *f, PetscReal *u)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *u_kept, *r;
  PetscFunctionBeginUser;
  if (!m->condensed.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(n, &u_kept, n, &r));
  PetscCall(PetscArraycpy(u_kept, u, 2 * m->mesh.n_moving));
  ElementForcesCondensed(m, u_kept, r);
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++)
    r[d] = (f ? f[d] : 0.) - r[d], u[d] = 0.;
  for (PetscInt b = 0; b < m->condensed.n; b++)
    PetscCall(CondensedSolve(m->condensed.body + b, m->condensed.body[b].inner, r, u)); // (a)
  PetscCall(PetscFree2(u_kept, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the modes to inner displacements and forces. */
static PetscErrorCode add_vibrations(const Model *m, State *state)
{
  const PetscInt at = 3 * m->rigid.n, n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *y, *f;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(n, &y, n, &f));
  CondensedAddModes(m, state->modes[MODE_PLACE], y);
  ElementForcesCondensed(m, y, f);
  for (PetscInt d = 2 * m->mesh.n_moving; d < 2 * m->mesh.n_owned; d++)
    state->u[at + d] += y[d], state->f[at + d] += f[d];
  PetscCall(PetscFree2(y, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedRecover(const Model *m, State *state)
{
  const PetscInt at = 3 * m->rigid.n, n = at + 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  PetscReal *f, *Su, *u = state->u + at;
  PetscFunctionBeginUser;
  if (!m->condensed.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(n, &f, n, &Su));
  for (PetscInt d = at; d < ModelApplied(m); d++)
    f[d] = state->f_ext[d] - (state->nonlinear ? state->nonlinear[d] : 0.);
  PetscCall(CondensedInner(m, f + at, u));
  PetscCall(PetscArrayzero(f, n));
  (m->condensed.large ? ElementForcesTurned : ElementForcesCondensed)(m, u, f + at);
  CondensedAddForces(m, u, Su + at);
  for (PetscInt d = at + 2 * m->mesh.n_moving; d < ModelApplied(m); d++) state->f[d] = f[d];
  for (PetscInt d = at; d < at + 2 * m->mesh.n_moving; d++) f[d] -= Su[d]; // g of (b)
  RigidForces(m, state->u, f);
  PetscCall(PetscArraycpy(state->passed, f, at + 2 * m->mesh.n_moving));
  PetscCall(PetscFree2(f, Su));
  if (m->condensed.n_modes) PetscCall(add_vibrations(m, state));
  CondensedInertial(m, state);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* state.c: what a step changes: room for it, lengths of its degrees of freedom. */
#include "model/model.h"

/* Keeps the first `old` entries of an array, zeros behind them. */
PetscErrorCode ArrayGrow(size_t size, PetscInt old, PetscInt new, void *array)
{
  void **a = array, *grown;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(size * new, (char **)&grown));
  if (*a) PetscCall(PetscMemcpy(grown, *a, size * old));
  PetscCall(PetscFree(*a));
  *a = grown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateCreate(const Scene *scene, const Model *m, State *s)
{
  PetscBool variable = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  PetscCall(StateResize(m, s));
  PetscCall(PetscCalloc3(m->n_dof, &s->v, m->n_dof, &s->m, m->n_dof, &s->m_inv));
  for (PetscInt i = 0; i < scene->n_stages; i++)
    variable = (PetscBool)(variable || scene->stages[i].variable);
  if (variable) PetscCall(PetscCalloc1(PetscMax(1, m->n_dof), &s->u_verified));
  PetscCall(VecCreateMPIWithArray(m->comm, 1, m->n_dof, PETSC_DECIDE, s->u, &s->u_vec));
  PetscCall(VecCreateMPIWithArray(m->comm, 1, m->n_dof, PETSC_DECIDE, s->v, &s->v_vec));
  if (m->n_condensed_global) PetscCall(PetscCalloc1(ModelApplied(m), &s->passed));
  s->dt = s->caution = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateDestroy(State *s)
{
  PetscReal **array[6] = {&s->u, &s->f, &s->f_old, &s->f_ext, &s->f_start, &s->f_target};
  PetscFunctionBeginUser;
  PetscCall(VecDestroy(&s->u_vec));
  PetscCall(VecDestroy(&s->v_vec));
  for (int i = 0; i < 6; i++) PetscCall(PetscFree(*array[i]));
  PetscCall(PetscFree3(s->v, s->m, s->m_inv));
  PetscCall(PetscFree(s->u_verified));
  PetscCall(PetscFree(s->passed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateResize(const Model *m, State *s)
{
  const PetscInt old = s->capacity, new = 3 * m->n_bodies + 2 * m->vertex_capacity;
  PetscFunctionBeginUser;
  if (new <= old) PetscFunctionReturn(PETSC_SUCCESS);
  PetscReal **array[6] = {&s->u, &s->f, &s->f_old, &s->f_ext, &s->f_start, &s->f_target};
  for (int i = 0; i < 6; i++) PetscCall(ArrayGrow(sizeof(PetscReal), old, new, array[i]));
  s->capacity = new;
  // this rank's arrays may grow when another's do not: nothing collective here
  if (s->u_vec) {
    PetscCall(VecResetArray(s->u_vec));
    PetscCall(VecPlaceArray(s->u_vec, s->u));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal DofLength(const Model *m, const State *state, PetscInt d)
{
  return d < 3 * m->n_bodies && d % 3 == 2 ? PetscSqrtReal(state->m[d] / state->m[d - 2]) : 1.;
}

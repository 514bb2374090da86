/* state.c: creates and destroys the state, which each step changes: its Vecs and their arrays, its memory,
   the lengths of its degrees of freedom. */
#include "model/model.h"

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

/* ---- Vecs and their arrays */

enum { STATE_VECS = 6, VECS_WITH_VERTICES = 4 };

/* Lists the Vecs of the state, their arrays and their names. Vecs with vertices behind their degrees of
   freedom come first. force_old has the name of force too, because the two change places every cycle. */
static void vecs_of(State *s, Vec *vec[STATE_VECS], PetscReal **array[STATE_VECS],
                    const char *name[STATE_VECS])
{
  Vec *const vecs[STATE_VECS] = {&s->displacement, &s->force, &s->force_old,
                                 &s->load,         &s->mass,  &s->velocity};
  PetscReal **const arrays[STATE_VECS] = {&s->u, &s->f, &s->f_old, &s->f_ext, &s->m, &s->v};
  static const StateVec names[STATE_VECS] = {STATE_DISPLACEMENT, STATE_FORCE, STATE_FORCE,
                                             STATE_LOAD,         STATE_MASS,  STATE_VELOCITY};
  for (int i = 0; i < STATE_VECS; i++)
    vec[i] = vecs[i], array[i] = arrays[i], name[i] = StateVecNames[names[i]];
}

/* Calls VecGetArray or VecRestoreArray for all Vecs. */
static PetscErrorCode each_array(State *s, PetscErrorCode (*move)(Vec, PetscReal **))
{
  Vec *vec[STATE_VECS];
  PetscReal **array[STATE_VECS];
  const char *name[STATE_VECS];
  PetscFunctionBeginUser;
  vecs_of(s, vec, array, name);
  for (int i = 0; i < STATE_VECS; i++) PetscCall(move(*vec[i], array[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateTake(State *s)
{
  return each_array(s, VecGetArray);
}

PetscErrorCode StateGive(State *s)
{
  return each_array(s, VecRestoreArray);
}

PetscErrorCode StateView(State *s)
{
  const Vec viewed[STATE_VEC_NAMES] = {s->displacement, s->velocity, s->force, s->load, s->mass};
  char option[NAME_LENGTH];
  PetscFunctionBeginUser;
  PetscCall(StateGive(s));
  for (int i = 0; i < STATE_VEC_NAMES; i++) {
    PetscCall(PetscSNPrintf(option, sizeof(option), "-%s_view", StateVecNames[i]));
    PetscCall(VecViewFromOptions(viewed[i], NULL, option));
  }
  PetscCall(StateTake(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for `new` numbers in the memory of a Vec. Its entries are the first n_dof of them, but it owns
   them all. */
static PetscErrorCode grow_vec(PetscInt old, PetscInt new, Vec vec, PetscReal **array)
{
  PetscReal *grown;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(new, &grown));
  PetscCall(PetscArraycpy(grown, *array, old));
  PetscCall(VecRestoreArray(vec, array));
  PetscCall(VecReplaceArray(vec, grown)); // frees the one it had
  PetscCall(VecGetArray(vec, array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode create_vecs(const Model *m, State *s)
{
  Vec *vec[STATE_VECS];
  PetscReal **array[STATE_VECS];
  const char *name[STATE_VECS];
  PetscFunctionBeginUser;
  vecs_of(s, vec, array, name);
  for (int i = 0; i < STATE_VECS; i++) {
    PetscCall(VecCreate(m->comm, vec[i]));
    PetscCall(VecSetSizes(*vec[i], m->n_dof, PETSC_DECIDE));
    PetscCall(VecSetType(*vec[i], VECSTANDARD)); // as MatCreateVecs makes them
    PetscCall(VecSet(*vec[i], 0.));
    PetscCall(PetscObjectSetName((PetscObject)*vec[i], name[i]));
  }
  PetscCall(StateTake(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life */

PetscErrorCode StateCreate(const Scene *scene, const Model *m, State *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(s, sizeof(*s)));
  PetscCall(create_vecs(m, s));
  PetscCall(StateResize(m, s));
  PetscCall(PetscCalloc1(m->n_dof, &s->m_inv));
  if (SceneFindsAnew(scene)) PetscCall(StateVerifies(m, s));
  if (m->mesh.n_condensed_global) PetscCall(PetscCalloc1(ModelApplied(m), &s->passed));
  if (m->mesh.n_condensed_global) PetscCall(PetscCalloc1(m->n_dof, &s->inertial));
  if (m->condensed.large)
    PetscCall(PetscCalloc2(ModelApplied(m), &s->nonlinear, ModelApplied(m), &s->corrected));
  for (int i = 0; i < MODE_ARRAYS; i++) PetscCall(PetscCalloc1(m->condensed.n_modes, &s->modes[i]));
  if (SceneHasHeat(scene)) s->applied.n_loads = scene->n_loads;
  for (int i = 0; i < SHARES; i++) PetscCall(PetscCalloc1(s->applied.n_loads, &s->applied.share[i]));
  s->dt = s->step_divisor = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateVerifies(const Model *m, State *s)
{
  PetscFunctionBeginUser;
  if (!s->u_verified) PetscCall(PetscCalloc1(PetscMax(1, m->n_dof), &s->u_verified));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateDestroy(State *s)
{
  Vec *vec[STATE_VECS];
  PetscReal **array[STATE_VECS];
  const char *name[STATE_VECS];
  PetscFunctionBeginUser;
  vecs_of(s, vec, array, name);
  for (int i = 0; i < STATE_VECS; i++) PetscCall(VecDestroy(vec[i]));
  PetscCall(PetscFree(s->applied.start));
  PetscCall(PetscFree(s->applied.target));
  for (int i = 0; i < SHARES; i++) PetscCall(PetscFree(s->applied.share[i]));
  PetscCall(PetscFree(s->m_inv));
  PetscCall(PetscFree(s->u_verified));
  PetscCall(PetscFree(s->passed));
  PetscCall(PetscFree2(s->nonlinear, s->corrected));
  PetscCall(PetscFree(s->reset));
  PetscCall(PetscFree(s->inertial));
  for (int i = 0; i < MODE_ARRAYS; i++) PetscCall(PetscFree(s->modes[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateResize(const Model *m, State *s)
{
  const PetscInt old = s->capacity, new = 3 * m->rigid.n + 2 * m->mesh.vertex_capacity;
  Vec *vec[STATE_VECS];
  PetscReal **array[STATE_VECS];
  const char *name[STATE_VECS];
  PetscFunctionBeginUser;
  if (new <= old) PetscFunctionReturn(PETSC_SUCCESS);
  // the arrays of this rank may grow when those of others do not, so nothing here may be collective
  vecs_of(s, vec, array, name);
  for (int i = 0; i < VECS_WITH_VERTICES; i++) PetscCall(grow_vec(old, new, *vec[i], array[i]));
  PetscCall(ArrayGrow(sizeof(PetscReal), old, new, &s->applied.start));
  PetscCall(ArrayGrow(sizeof(PetscReal), old, new, &s->applied.target));
  s->capacity = new;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal DofLength(const Model *m, const State *state, PetscInt d)
{
  return d < 3 * m->rigid.n && d % 3 == 2 ? PetscSqrtReal(state->m[d] / state->m[d - 2]) : 1.;
}

/* applied.c: computes the applied forces of a stage, the sum of its loads. f: dof array, f_vertex: its
   vertex part. */
#include "forces/forces.h"

static const PetscReal CENTRED = 1e-12; /* moment over force times arm: smaller ones are rounding */

PetscBool LoadsTurn(const Model *m, const PetscReal *u, PetscReal *f)
{
  const PetscReal *f_vertex = f + 3 * m->rigid.n;
  PetscBool any = PETSC_FALSE;
  RigidForces(m, u, f);
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    PetscReal across = 0., along = 0., size = 0.; // sums of r x F and r . F in the reference position
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
      const PetscReal rx = m->mesh.X[2 * v] - m->rigid.X[2 * b],
                      ry = m->mesh.X[2 * v + 1] - m->rigid.X[2 * b + 1];
      across += rx * f_vertex[2 * v + 1] - ry * f_vertex[2 * v];
      along += rx * f_vertex[2 * v] + ry * f_vertex[2 * v + 1];
      size += PetscHypotReal(rx, ry) * PetscHypotReal(f_vertex[2 * v], f_vertex[2 * v + 1]);
    }
    if (PetscAbsReal(across) + PetscAbsReal(along) <= CENTRED * size)
      f[3 * b + 2] = 0.;
    else if (m->materials.strain == STRAIN_LARGE && !Held(m, 3 * b + 2))
      any = PETSC_TRUE;
  }
  return any;
}

PetscBool LoadsPress(const Scene *scene, const Stage *stage)
{
  for (PetscInt l = 0; l < stage->n_loads; l++)
    if (TermPresses(scene, scene->loads + stage->loads[l])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Adds the stage's loads at the present displacements to f_vertex: dead loads, pressing loads, or both. */
static PetscErrorCode add_loads(const Scene *scene, const Model *m, const Stage *stage, const State *state,
                                PetscBool dead, PetscBool pressing, PetscReal *f_vertex)
{
  const TermView view = {.scene = scene, .stage = stage, .m = m, .state = state};
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < stage->n_loads; l++) {
    const PetscInt load = stage->loads[l];
    if (TermPresses(scene, scene->loads + load) ? !pressing : !dead) continue;
    PetscCall(TermApplied(&view, load, f_vertex));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces that terms apply without a load. any receives whether there are some. f_vertex NULL:
   only decides this. */
static PetscErrorCode add_without_load(const Scene *scene, const Model *m, const Stage *stage,
                                       const State *state, PetscBool *any, PetscReal *f_vertex)
{
  const TermView view = {.scene = scene, .stage = stage, .m = m, .state = state};
  PetscFunctionBeginUser;
  PetscCall(TermsApplyWithoutLoad(&view, any, f_vertex));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool LoadsChange(const Scene *scene, const Model *m, const Stage *stage, const State *state)
{
  PetscBool change = LoadsPress(scene, stage), pulls = PETSC_FALSE;
  if (add_without_load(scene, m, stage, state, &pulls, NULL)) return PETSC_TRUE;
  if (pulls && m->materials.strain == STRAIN_LARGE) change = PETSC_TRUE;
  for (PetscInt l = 0; l < stage->n_loads && m->mesh.n_rigid_global > 0; l++)
    if (scene->loads[stage->loads[l]].kind != LOAD_SELF_WEIGHT) change = PETSC_TRUE;
  return change;
}

PetscErrorCode LoadsTarget(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscReal *f = state->applied.target;
  PetscBool pulls;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(f, at + 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  PetscCall(add_loads(scene, m, stage, state, PETSC_TRUE, PETSC_TRUE, f + at));
  PetscCall(add_without_load(scene, m, stage, state, &pulls, f + at));
  PetscCall(CondensedLoads(m, f + at));
  PetscCall(PetscArrayzero(state->applied.share[SHARE_TARGET], state->applied.n_loads));
  for (PetscInt l = 0; l < stage->n_loads && state->applied.n_loads; l++)
    state->applied.share[SHARE_TARGET][stage->loads[l]] = scene->loads[stage->loads[l]].heat.factor;
  state->applied.turn = LoadsTurn(m, state->u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsDead(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(state->applied.start, at + 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  PetscCall(add_loads(scene, m, stage, state, PETSC_TRUE, PETSC_FALSE, state->applied.start + at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsFollow(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(state->applied.target, state->applied.start, ModelApplied(m)));
  PetscCall(
      add_loads(scene, m, stage, state, PETSC_FALSE, PETSC_TRUE, state->applied.target + 3 * m->rigid.n));
  PetscCall(CondensedLoads(m, state->applied.target + 3 * m->rigid.n)); // inner loads are constant
  state->applied.turn = LoadsTurn(m, state->u, state->applied.target);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsFromNow(const Model *m, State *state)
{
  PetscReal *const *share = state->applied.share;
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(state->applied.start, state->f_ext, ModelApplied(m)));
  PetscCall(PetscArraycpy(share[SHARE_START], share[SHARE_NOW], state->applied.n_loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LoadsApply(const Model *m, State *state, PetscReal ramp)
{
  PetscReal *const *share = state->applied.share;
  state->applied.ramp = ramp;
  for (PetscInt d = 0; d < ModelApplied(m); d++)
    state->f_ext[d] = (1. - ramp) * state->applied.start[d] + ramp * state->applied.target[d];
  for (PetscInt l = 0; l < state->applied.n_loads; l++)
    share[SHARE_NOW][l] = (1. - ramp) * share[SHARE_START][l] + ramp * share[SHARE_TARGET][l];
}

PetscErrorCode LoadsRenew(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  PetscFunctionBeginUser;
  if (!LoadsChange(scene, m, stage, state)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LoadsTarget(scene, m, stage, state));
  LoadsApply(m, state, state->applied.ramp);
  PetscFunctionReturn(PETSC_SUCCESS);
}

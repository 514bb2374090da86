/* velocities.c: shifts the velocities of a stage in time, which stand half a step before its displacements.
   At the start of a stage they go back by half a step of the forces there, at its end forward. Where the step
   changes they do both: v(t) = (v- + v+)/2 stays the same, where v+ is the velocity after the old step.

   The kinetic energy of the account, v-.M v+ / 2 = v.M v / 2 - dt^2/8 a.M a, depends on the step. Its change
   with the step is booked beside the account, so `balance` stays the error of the steps. */
#include "stages/stages.h"

PetscErrorCode VelocitiesHalfStep(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                  PetscReal sign, EnergyAccount *e)
{
  const Model *m = p->m;
  State *s = p->state;
  PetscFunctionBeginUser;
  memcpy(e->v_before, s->v, m->n_dof * sizeof *s->v);
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (!Held(m, d))
      s->v[d] += sign * 0.5 * s->dt *
                 (s->m_inv[d] * (s->f_ext[d] - s->f[d]) - s->alpha * (s->v[d] - DofGround(m, d, ground)));
  PetscCall(CoupledHalfStep(local, s, e->v_before, ground, sign));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VelocitiesAccount(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                 PetscBool last, PetscReal *behind, EnergyAccount *e)
{
  const Model *m = p->m;
  State *s = p->state;
  PetscReal *u, *modes[2];
  StepWorks works;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(m->n_dof, &u, m->condensed.n_modes, &modes[0], m->condensed.n_modes, &modes[1]));
  PetscCall(PetscArraycpy(u, s->u, m->n_dof));
  PetscCall(PetscArraycpy(modes[0], s->modes[MODE_PLACE], m->condensed.n_modes));
  PetscCall(PetscArraycpy(modes[1], s->modes[MODE_SPEED], m->condensed.n_modes));
  MoveInTime(m, s, ground, e->v_before, e->f_ext_before, &works);
  if (last) TermsAdvance(m, s); // books the work of the dampers of terms
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (Held(m, d)) s->v[d] = e->v_before[d];
  PetscCall(CoupledStep(local, s, e->v_before, ground, 0., e->local));
  WorksInTime(m, s, ground, e->v_before, &works);
  EnergyOfStep(&works, e);
  if (behind) PetscCall(PetscArraycpy(behind, s->v, m->n_dof));
  PetscCall(PetscArraycpy(s->v, e->v_before, m->n_dof));
  PetscCall(PetscArraycpy(s->u, u, m->n_dof));
  PetscCall(PetscArraycpy(s->modes[MODE_PLACE], modes[0], m->condensed.n_modes));
  PetscCall(PetscArraycpy(s->modes[MODE_SPEED], modes[1], m->condensed.n_modes));
  PetscCall(PetscFree3(u, modes[0], modes[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VelocitiesChange(const Problem *p, CoupledInertia *local, const PetscReal ground[2],
                                PetscReal dt, EnergyAccount *e)
{
  const EnergyAccount before = *e;
  const Model *m = p->m;
  State *s = p->state;
  PetscReal *behind;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_dof, &behind));
  PetscCall(VelocitiesAccount(p, local, ground, PETSC_FALSE, behind, e));
  const EnergyAccount closed = *e;
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (!Held(m, d)) s->v[d] = 0.5 * (s->v[d] + behind[d]);
  s->dt = dt;
  p->contacts->rate = 1. / dt;
  PetscCall(VelocitiesHalfStep(p, local, ground, -1., e));
  PetscCall(VelocitiesAccount(p, local, ground, PETSC_FALSE, NULL, e)); // as the next step will book itself
  EnergyHandOver(&before, &closed, e);
  PetscCall(PetscFree(behind));
  PetscFunctionReturn(PETSC_SUCCESS);
}

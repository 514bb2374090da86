/* step.c: one cycle. */
#include "internal.h"

static PetscLogEvent event_ghost, event_element, event_contact, event_rigid, event_integrate, event_damping;
static PetscBool events_registered = PETSC_FALSE;

static PetscErrorCode register_events(void)
{
  PetscClassId id;
  PetscFunctionBeginUser;
  if (events_registered) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscClassIdRegister("Quoin", &id));
  PetscCall(PetscLogEventRegister("GhostExchange", id, &event_ghost));
  PetscCall(PetscLogEventRegister("ElementForces", id, &event_element));
  PetscCall(PetscLogEventRegister("ContactForces", id, &event_contact));
  PetscCall(PetscLogEventRegister("RigidBodies", id, &event_rigid));
  PetscCall(PetscLogEventRegister("Integrate", id, &event_integrate));
  PetscCall(PetscLogEventRegister("Damping", id, &event_damping));
  events_registered = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |contact force| per dof: what the unbalanced force of a body is compared with. f holds contact forces only.
 */
static void scale_of_contacts(const Model *m, const PetscReal *f, PetscReal *scale)
{
  const PetscReal *f_vertex = f + 3 * m->n_bodies;
  for (PetscInt d = 0; d < 2 * m->n_deformable; d++) scale[3 * m->n_bodies + d] = PetscAbsReal(f_vertex[d]);
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    scale[3 * b] = scale[3 * b + 1] = scale[3 * b + 2] = 0.;
    for (PetscInt v = m->body_start[b]; v < m->body_start[b + 1]; v++)
      for (int i = 0; i < 2; i++) scale[3 * b + i] += PetscAbsReal(f_vertex[2 * v + i]);
  }
}

PetscErrorCode Forces(const Model *m, const Joint *joints, Contacts *contacts, State *state,
                      PetscReal *contact_scale)
{
  const PetscInt at = 3 * m->n_bodies, n = at + 2 * (m->n_vertices + DUMMY_VERTICES);
  PetscFunctionBeginUser;
  // what the other ranks' vertices did
  PetscCall(PetscLogEventBegin(event_ghost, 0, 0, 0, 0));
  PetscCall(GhostBegin(m, state->u + at));
  PetscCall(GhostEnd(m, state->u + at));
  PetscCall(PetscLogEventEnd(event_ghost, 0, 0, 0, 0));
  PetscCall(PetscArrayzero(state->f, n));
  PetscCall(PetscLogEventBegin(event_contact, 0, 0, 0, 0));
  PetscCall(ContactForces(m, joints, contacts, state->u + at, state->f + at)); // (1)-(6)
  PetscCall(PetscLogEventEnd(event_contact, 0, 0, 0, 0));
  if (contact_scale) scale_of_contacts(m, state->f, contact_scale);
  PetscCall(PetscLogEventBegin(event_element, 0, 0, 0, 0));
  PetscCall(ElementForces(m, state->u + at, state->f + at)); // (10)
  PetscCall(PetscLogEventEnd(event_element, 0, 0, 0, 0));
  PetscCall(PetscLogEventBegin(event_rigid, 0, 0, 0, 0));
  RigidForces(m, state->u, state->f); // (15)
  PetscCall(PetscLogEventEnd(event_rigid, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Step(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts, State *state,
                    Relaxation *relax, PetscReal *contact_scale)
{
  PetscReal *swap = state->f_old;
  QuotientSums local;
  PetscFunctionBeginUser;
  PetscCall(register_events());
  state->f_old = state->f;
  state->f = swap;
  PetscCall(Forces(m, joints, contacts, state, contact_scale));
  PetscCall(PetscLogEventBegin(event_integrate, 0, 0, 0, 0));
  Integrate(m, state, &relax->sums, &local); // (11)-(20)
  RigidMotion(m, state->u);                  // (21)-(22)
  PetscCall(PetscLogEventEnd(event_integrate, 0, 0, 0, 0));
  PetscCall(PetscLogEventBegin(event_damping, 0, 0, 0, 0));
  PetscCall(Damping(scene, m, state, relax, &local)); // (35)-(38), for the next cycle
  PetscCall(PetscLogEventEnd(event_damping, 0, 0, 0, 0));
  state->cycle++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* cycle.c: makes one cycle: forces, motion, damping. */
#include "motion/motion.h"

/* Finds |contact force| per dof, with which the unbalanced force of a body is compared. f holds contact
   forces only. */
static void scale_of_contacts(const Model *m, const PetscReal *f, PetscReal *scale)
{
  const PetscReal *f_vertex = f + 3 * m->rigid.n;
  for (PetscInt d = 0; d < 2 * m->mesh.n_deformable; d++)
    scale[3 * m->rigid.n + d] = PetscAbsReal(f_vertex[d]);
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    scale[3 * b] = scale[3 * b + 1] = scale[3 * b + 2] = 0.;
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++)
      for (int i = 0; i < 2; i++) scale[3 * b + i] += PetscAbsReal(f_vertex[2 * v + i]);
  }
}

/* Sets f to zero before forces are added to it; inner vertices of condensed bodies keep theirs. dofs: at
   degrees of freedom too. */
static void clear_forces(const Model *m, PetscBool dofs, PetscReal *f)
{
  PetscReal *f_vertex = f + 3 * m->rigid.n;
  if (dofs) memset(f, 0, m->n_dof * sizeof *f);
  memset(f_vertex + 2 * m->mesh.n_deformable, 0, 2 * (m->mesh.n_moving - m->mesh.n_deformable) * sizeof *f);
  memset(f_vertex + 2 * m->mesh.n_owned, 0,
         2 * (m->mesh.n_vertices - m->mesh.n_owned + DUMMY_VERTICES) * sizeof *f);
}

/* Adds the forces between bodies, which come first at every vertex. */
static PetscErrorCode forces_of_joints(const Instant *at, State *state, PetscReal *contact_scale)
{
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_CONTACTS));
  PetscCall(TermsForces(PHASE_JOINTS, state, at, state->f + 3 * at->m->rigid.n)); // (1)-(6)
  PetscCall(TimerEnd(TIMER_CONTACTS));
  if (contact_scale) scale_of_contacts(at->m, state->f, contact_scale);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Forces(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts,
                      State *state, PetscReal *contact_scale)
{
  const PetscInt at = 3 * m->rigid.n;
  const Instant now = {scene, m, joints, contacts, state->u + at, PETSC_TRUE};
  PetscFunctionBeginUser;
  // motion of the vertices of other ranks
  PetscCall(TimerBegin(TIMER_EXCHANGE));
  PetscCall(GhostBegin(m, state->u + at));
  clear_forces(m, PETSC_TRUE, state->f);
  PetscCall(GhostEnd(m, state->u + at));
  PetscCall(TimerEnd(TIMER_EXCHANGE));
  PetscCall(forces_of_joints(&now, state, contact_scale));
  PetscCall(TimerBegin(TIMER_BLOCKS));
  PetscCall(TermsForces(PHASE_BODIES, state, &now, state->f + at));
  PetscCall(TermsForces(PHASE_BLOCKS, state, &now, state->f + at)); // (10)
  PetscCall(TimerEnd(TIMER_BLOCKS));
  PetscCall(TimerBegin(TIMER_RIGID));
  RigidForces(m, state->u, state->f); // (15)
  PetscCall(TimerEnd(TIMER_RIGID));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the forces of deformable blocks, chunk by chunk, and moves the vertices whose forces are complete: no
   later block reads their displacement. Vertices move in even numbers, so that only the last sweep ends
   within a vector. */
static void move_vertices(const Model *m, State *state, const QuotientSums *last, QuotientSums *sums)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscInt moved = 0;
  for (PetscInt chunk = 0; chunk < ElementChunks(m); chunk++) {
    const PetscInt done = m->mesh.chunk_done[chunk] / 2 * 2, from = at + 2 * moved, to = at + 2 * done;
    const Ahead ahead = IntegrateAhead(state, from);
    ElementForcesOfChunk(m, chunk, &ahead, state->u + at, state->f + at); // (10)
    IntegrateRange(m, state, last, from, to, sums);                       // (11)-(20)
    moved = done;
  }
  IntegrateRange(m, state, last, at + 2 * moved, at + 2 * m->mesh.n_deformable, sums);
}

/* Exchanges the data of ranks at the end of a cycle. Each rank sends everything before it waits: the last
   rank finds all data there. */
static PetscErrorCode exchange(const Scene *scene, const Model *m, State *state, Damping *damping,
                               const QuotientSums *local)
{
  PetscReal *u = state->u + 3 * m->rigid.n;
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_EXCHANGE));
  DampingBegin(scene, m, damping, local);
  PetscCall(GhostBegin(m, u));
  PetscCall(TimerEnd(TIMER_EXCHANGE));
  PetscCall(TimerBegin(TIMER_DAMPING));
  PetscCall(DampingEnd(scene, m, state, damping)); // (35)-(38), for the next cycle
  PetscCall(TimerEnd(TIMER_DAMPING));
  PetscCall(TimerBegin(TIMER_EXCHANGE));
  PetscCall(GhostEnd(m, u));
  PetscCall(TimerEnd(TIMER_EXCHANGE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Step(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts, State *state,
                    Damping *damping, PetscReal *contact_scale)
{
  const PetscBool clear = state->f_old_clear; // whether f_old is zero since the cycle before
  const Instant now = {
      scene, m, joints, contacts, state->u + 3 * m->rigid.n, (PetscBool)(contact_scale != NULL)};
  QuotientSums local = {{0., 0.}, {0., 0.}, 0., 0.};
  PetscFunctionBeginUser;
  TimerSample(state->cycle);
  state->local = scene->damping == DAMPING_LOCAL ? scene->local : 0.;
  if (PushWalks(state)) state->alpha = 0., state->local = PUSH_LOCAL;
  StateSwapForces(state);
  state->f_old_clear = PETSC_FALSE;
  clear_forces(m, (PetscBool)!clear, state->f);
  PetscCall(forces_of_joints(&now, state, contact_scale));
  PetscCall(TimerBegin(TIMER_BLOCKS));
  PetscCall(TermsForces(PHASE_BODIES, state, &now, state->f + 3 * m->rigid.n));
  if (state->stiffness_mass) {
    PetscCall(TermsForces(PHASE_BLOCKS, state, &now, state->f + 3 * m->rigid.n));
  } else
    move_vertices(m, state, &damping->sums, &local);
  PetscCall(TimerEnd(TIMER_BLOCKS));
  const Timer moves = state->stiffness_mass ? TIMER_SOLVES : TIMER_RIGID;
  PetscCall(TimerBegin(moves));
  RigidForces(m, state->u, state->f); // (15)
  if (state->stiffness_mass) {
    PetscCall(StiffnessMassMove(m, state, &damping->sums, &local));
  } else {
    IntegrateRange(m, state, &damping->sums, 0, 3 * m->rigid.n, &local); // (11)-(20)
    state->f_old_clear = PETSC_TRUE;
  }
  RigidMotion(m, state->u); // (21)-(22)
  PetscCall(TimerEnd(moves));
  PetscCall(exchange(scene, m, state, damping, &local));
  state->cycle++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

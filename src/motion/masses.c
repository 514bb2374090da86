/* masses.c: bounds of the stiffness and the masses that go with them (sections 3.1-3.2).

   Force terms add the stiffness at vertices (term.h: bound).

   Rigid bodies. With D = diag(k_i) a bound of the vertex stiffness, T'D T bounds that of the body:
     [ K 0 -c_y; 0 K c_x; . . K_rot ],  K = sum k_i, K_rot = sum k_i r_i^2 (31), c = sum k_i r_i,
   whose eigenvalues, with rotation in units of l = sqrt(K_rot / K), are K and K +- |c|/l: K + |c|/l bounds
   the translations, K_rot + |c| l the rotation. */
#include "motion/motion.h"

/* Row bounds of the three dofs of body b; k: (vertices,). */
static void body_stiffness(const Model *m, PetscInt b, const PetscReal *k, PetscReal row[3])
{
  const PetscReal *C = m->body_X + 2 * b;
  PetscReal K = 0., K_rot = 0., cx = 0., cy = 0.;
  for (PetscInt v = m->body_start[b]; v < m->body_start[b + 1]; v++) {
    const PetscReal rx = m->X[2 * v] - C[0], ry = m->X[2 * v + 1] - C[1];
    K += k[v], K_rot += k[v] * (rx * rx + ry * ry); // (31)
    cx += k[v] * rx, cy += k[v] * ry;
  }
  if (K == 0.) { // touches nothing: any mass is stable
    row[0] = row[1] = row[2] = 0.;
    return;
  }
  const PetscReal l = PetscSqrtReal(K_rot / K), c = PetscHypotReal(cx, cy);
  row[0] = row[1] = K + c / l;
  row[2] = K_rot + c * l;
}

/* The bodies that touch nothing now have the masses of contacts that may come: with true ones, in steps of
   1 s, they would fall by 10 m a cycle, and through everything. */
static PetscErrorCode loose_masses(const Scene *scene, const Model *m, const Joint *joints, PetscReal factor,
                                   State *state)
{
  const Instant at = {.scene = scene, .m = m, .joints = joints};
  PetscReal *mass = state->m, *k;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &k));
  PetscCall(TermsBound(state, &at, PETSC_TRUE, k));
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    PetscReal row[3];
    if (mass[3 * b] > 0.) continue;
    body_stiffness(m, b, k, row);
    for (int i = 0; i < 3; i++)
      mass[3 * b + i] = row[i] > 0. ? factor * row[i] : PetscMax(DofMass(m, 3 * b + i), 1.);
  }
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ScaledMasses(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts,
                            State *state)
{
  const PetscInt at = 3 * m->n_bodies;
  const Instant now = {.scene = scene, .m = m, .joints = joints, .contacts = contacts};
  const PetscBool may_land = (PetscBool)(state->u_verified != NULL); // contacts are looked for
  PetscBool loose = PETSC_FALSE;
  PetscReal *k;
  PetscFunctionBeginUser;
  state->dt = 1.;
  // (33), dt/safety for dt; damping by beta takes (1 + 2 beta) (omega dt)^2 <= 4, local damping can add its
  // part of the unbalanced force
  const PetscReal pushed = scene->damping == DAMPING_LOCAL ? 1. + scene->local : 1.;
  const PetscReal factor = 0.25 * state->dt * state->dt * (1. + 2. * state->beta) * pushed /
                           (scene->safety * scene->safety) * (state->caution * state->caution);
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &k));
  PetscCall(TermsBound(state, &now, PETSC_FALSE, k));
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    PetscReal row[3];
    body_stiffness(m, b, k, row);
    loose = (PetscBool)(loose || !(row[0] > 0.));
    for (int i = 0; i < 3; i++)
      state->m[3 * b + i] = row[i] > 0. ? factor * row[i]
                            : may_land  ? 0.
                                        : PetscMax(DofMass(m, 3 * b + i), 1.);
  }
  if (loose && may_land) PetscCall(loose_masses(scene, m, joints, factor, state));
  for (PetscInt d = 0; d < 2 * m->n_deformable; d++) state->m[at + d] = factor * k[d / 2];
  for (PetscInt d = 0; d < m->n_dof; d++) state->m_inv[d] = Held(m, d) ? 0. : 1. / state->m[d];
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DynamicTimeStep(const Scene *scene, const Model *m, const Stage *stage, State *state,
                               PetscReal *limit)
{
  const PetscInt at = 3 * m->n_bodies;
  const Instant now = {.scene = scene, .m = m, .joints = stage->joints};
  char message[MESSAGE_LENGTH] = "";
  PetscReal *k, least = PETSC_INFINITY;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &k));
  PetscCall(TermsBound(state, &now, PETSC_TRUE, k));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    PetscReal row[3] = {k[d < at ? 0 : (d - at) / 2], 0., 0.};
    if (d < at) body_stiffness(m, d / 3, k, row);
    const PetscReal stiffness = d < at ? row[d % 3] : row[0];
    state->m[d] = DofMass(m, d);
    state->m_inv[d] = Held(m, d) ? 0. : 1. / DofMass(m, d);
    if (Held(m, d) || IsCondensed(m, d)) continue;
    if (!(DofMass(m, d) > 0.) && !message[0]) {
      const PetscInt v = d < at ? m->body_start[d / 3] : (d - at) / 2;
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: stages.%s: vertex %" PetscInt_FMT
                              " has no mass: a dynamic stage needs density > 0 in every group "
                              "that is not held",
                              scene->file, stage->name, m->vertex_file[v]));
    }
    if (stiffness > 0.) least = PetscMin(least, 2. * PetscSqrtReal(DofMass(m, d) / stiffness)); // (25), (32)
  }
  for (PetscInt b = 0; b < m->n_condensed; b++) {
    PetscReal omega2;
    PetscCall(CondensedFastest(m, m->condensed + b, k, &omega2));
    if (omega2 > 0.) least = PetscMin(least, 2. / PetscSqrtReal(omega2));
  }
  PetscCall(PetscFree(k));
  PetscCall(CheckMessage(m->comm, message));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_REAL, MPI_MIN, m->comm));
  *limit = least < PETSC_INFINITY ? least : stage->duration;
  PetscFunctionReturn(PETSC_SUCCESS);
}

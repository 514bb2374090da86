/* timestep.c: bounds of the stiffness and the masses that go with them (sections 3.1-3.2).

   Contacts. The paper's (29), (k_n + k_s) L_i, counts one side of the spring only and is no bound. Here every
   spring of a sub-contact, b = (P: 1, A: -(1-t), B: -t) in direction n or s, gives vertex i a Gershgorin row
   sum of at most 2 k_max L_i |b_i|,   k_max = (k_n + k_s)/2 + |k_n - k_s|/sqrt(2), the factor 2 being the sum
   of |b|, k_max the largest row sum of k_n n n' + k_s s s' over all orientations; the coupling of the two
   ends is inside, because the rows of every stress model sum to L_i.

   Rigid bodies. With D = diag(k_i) a bound of the vertex stiffness, T'D T bounds that of the body:
     [ K 0 -c_y; 0 K c_x; . . K_rot ],  K = sum k_i, K_rot = sum k_i r_i^2 (31), c = sum k_i r_i,
   and scaled row sums (rotation in units of l = sqrt(K_rot / K)) bound that by K + |c|/l and K_rot + sqrt(2)
   |c| l. */
#include "internal.h"

PetscErrorCode ContactStiffness(const Joint *joints, const Contacts *c, PetscReal thickness, PetscReal *k)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const Joint *j = joints + c->joint[i];
    const PetscReal k_max = 0.5 * (j->k_n + j->k_s) + PetscAbsReal(j->k_n - j->k_s) / PETSC_SQRT2;
    for (int s = 0; s < 2; s++) {
      const PetscInt *v = c->vertex + ((i / BATCH) * 6 + 3 * s) * BATCH + i % BATCH;
      const PetscReal row = 2. * k_max * 0.5 * c->length[i] * thickness, t = c->t[SUB(i, s)];
      k[v[0]] += row;
      k[v[BATCH]] += row * PetscAbsReal(1. - t);
      k[v[2 * BATCH]] += row * PetscAbsReal(t);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  row[2] = K_rot + PETSC_SQRT2 * c * l;
}

PetscErrorCode ScaledMasses(const Scene *scene, const Model *m, const Joint *joints, const Contacts *c,
                            State *state)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscReal *k;
  PetscFunctionBeginUser;
  state->dt = 1.;
  const PetscReal factor = 0.25 * state->dt * state->dt /
                           (scene->safety * scene->safety); // (33), dt/safety for dt
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &k));
  PetscCall(ElementStiffness(m, k));
  PetscCall(ContactStiffness(joints, c, m->thickness, k));
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    PetscReal row[3];
    body_stiffness(m, b, k, row);
    for (int i = 0; i < 3; i++)
      state->m[3 * b + i] = row[i] > 0. ? factor * row[i] : PetscMax(m->mass[3 * b + i], 1.);
  }
  for (PetscInt d = 0; d < 2 * m->n_deformable; d++) state->m[at + d] = factor * k[d / 2];
  for (PetscInt d = 0; d < m->n_dof; d++) state->m_inv[d] = m->fixed[d] ? 0. : 1. / state->m[d];
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

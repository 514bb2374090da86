/* bound.c: computes an upper bound of the stiffness of contacts, for the time step.

   Contacts. The paper's (29), (k_n + k_s) L_i, counts one side of the spring only and is no bound. Here the
   springs of a sub-contact act through b = (P: 1, A: -(1-t), B: -t), sum |b| = 2: its stiffness is bb' (x) C,
   C = k_n nn' + k_s ss', and bb' <= 2 diag|b| (0 <= t <= 1), C <= max(k_n, k_s) in every direction, so that
   vertex i is bounded by 2 max(k_n, k_s) L_i |b_i|. The coupling of the two ends is inside, because the rows
   of every stress model sum to L_i. */
#include "contacts/contacts.h"

static PetscReal stiffness_of(const Joint *j, PetscBool drag)
{
  return drag ? j->damping * j->k_n : PetscMax(j->k_n, j->k_s);
}

PetscErrorCode ContactStiffness(const Joint *joints, const Contacts *c, PetscReal thickness, PetscBool drag,
                                PetscReal *k)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const Joint *j = joints + c->joint[i];
    const PetscReal k_max = stiffness_of(j, drag);
    for (int s = 0; s < ContactEnds(c, i); s++) {
      PetscInt v[3];
      ContactEndVertices(c, i, s, v);
      const PetscReal row = 2. * k_max * 0.5 * c->length[i] * thickness, t = c->t[SUB(i, s)];
      k[v[0]] += row;
      k[v[1]] += row * PetscAbsReal(1. - t);
      k[v[2]] += row * PetscAbsReal(t);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bounds the stiffness of contacts that a vertex may get later along all of its faces. The bound takes the
   stiffest joint over their half lengths, once for the vertex of a contact and once for an end of the face
   under another vertex. */
PetscErrorCode ContactStiffnessAnywhere(const Scene *scene, const Model *m, const Joint *joints,
                                        PetscBool drag, PetscReal *k)
{
  PetscReal stiffest = 0.;
  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const Joint *joint = joints + j;
    stiffest = PetscMax(stiffest, stiffness_of(joint, drag));
  }
  for (PetscInt f = 0; f < m->faces.n_local; f++) {
    const PetscInt *v = m->faces.vertex + 2 * f;
    const PetscReal length = PetscHypotReal(m->mesh.X[2 * v[1]] - m->mesh.X[2 * v[0]],
                                            m->mesh.X[2 * v[1] + 1] - m->mesh.X[2 * v[0] + 1]);
    for (int i = 0; i < 2; i++) k[v[i]] += 2. * 2. * stiffest * 0.5 * length * m->materials.thickness;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* method.c: chooses the method by which a stage finds its equilibrium (relaxation.method). */
#include "solve/solve.h"

/* Newton's method pays from this many degrees of freedom on where all joints are elastic: the dam of Fig. 6
   takes a second of explicit cycles there, others less (docs/performance.md, tests/benchmark/method.py). With
   fewer, explicit cycles are as good, and their bits do not depend on the number of ranks. */
enum { MANY_DOFS = 8000 };

/* Returns whether a block of this rank can yield. */
static PetscBool any_can_yield(const Model *m)
{
  for (const Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    if (e->n) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether a contact of this rank can slip or open. A contact can where its joint has a strength, or
   where its faces met in motion and were never bonded. */
static PetscBool any_can_fail(const Contacts *c, const Joint *joints)
{
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (c->key[2 * i] < 0) continue;
    if (joints[c->joint[i]].law != LAW_ELASTIC || c->broken[SUB(i, 0)] > 0. || c->broken[SUB(i, 1)] > 0.)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode StageMethod(const Scene *scene, const Model *m, const Contacts *contacts, const Stage *stage,
                           MethodKind *method)
{
  PetscInt64 sum[2] = {m->n_dof, any_can_yield(m) || any_can_fail(contacts, stage->joints)};
  PetscFunctionBeginUser;
  *method = scene->method;
  // Newton's method keeps its contacts; local damping opposes each degree of freedom on its own
  if (*method == METHOD_STIFFNESS_MASS ? scene->damping == DAMPING_LOCAL : stage->variable)
    *method = METHOD_EXPLICIT;
  if (*method != METHOD_AUTO) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_INT64, MPI_SUM, m->comm));
  const PetscBool newton = (PetscBool)(stage->kind == STAGE_STATIC && scene->damping == DAMPING_ADAPTIVE &&
                                       !sum[1] && sum[0] >= MANY_DOFS);
  *method = newton ? METHOD_PRECONDITIONED : METHOD_EXPLICIT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

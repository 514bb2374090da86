/* method.c: chooses the method by which a stage finds its equilibrium (relaxation.method). */
#include "solve/solve.h"

/* Newton's method pays from this many degrees of freedom on where all joints are elastic: the dam of Fig. 6
   takes a second of explicit cycles there, others less (docs/performance.md, tests/benchmark/method.py). With
   fewer, explicit cycles are as good, and their bits do not depend on the number of ranks. */
enum { MANY_DOFS = 8000 };
/* Numbers of rigid stones between which cycles with the stiffness as mass pay: 597 and 2003 took half of the
   time, 150 as long, and 17 299 found no end in 12 000 cycles (docs/performance.md, "Many stones that
   slide"). */
enum { MANY_STONES = 500, MOST_STONES = 2500 };

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

/* Returns whether cycles with the stiffness as mass pay: for MANY_STONES rigid stones with friction alone, on
   one rank. On several ranks each solves for all. Nothing else has been measured: no anchors, no joints that
   break, no stress model without a potential, no water that flows. */
static PetscBool stiffness_mass_pays(const Scene *scene, const Model *m, const Stage *stage)
{
  PetscInt n_anchors;
  SceneEntries(scene, "anchors", &n_anchors);
  if (m->size > 1 || m->rigid.n < MANY_STONES || m->rigid.n > MOST_STONES || m->n_dof > 3 * m->rigid.n)
    return PETSC_FALSE;
  if (n_anchors || scene->damping != DAMPING_ADAPTIVE) return PETSC_FALSE;
  if (stage->variable || stage->kind == STAGE_TRANSIENT) return PETSC_FALSE;
  for (const Joint *j = stage->joints; j < stage->joints + scene->n_joints; j++)
    if (j->defined && (j->cohesion[0] > 0. || j->tension[0] > 0. || j->compression < PETSC_INFINITY ||
                       (j->stress_model >= STRESS_R2PT && j->stress_model < STRESS_TPTM)))
      return PETSC_FALSE;
  return PETSC_TRUE;
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
  *method = newton                                           ? METHOD_PRECONDITIONED
            : sum[1] && stiffness_mass_pays(scene, m, stage) ? METHOD_STIFFNESS_MASS
                                                             : METHOD_EXPLICIT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* result.c: manages what a stage finds, and finds the displacements of the named points. */
#include "result/result.h"
#include <math.h>

PetscErrorCode ResultCreate(const Model *model, Result *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(model->mesh.n_points + 1, &r->probes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultReset(Result *r)
{
  PetscFunctionBeginUser;
  PetscCall(TrialsReset(&r->trials));
  PetscCall(VibrationDestroy(&r->vibration));
  PetscCall(BodyMotionDestroy(&r->bodies));
  PetscCall(HistoriesDestroy(&r->histories));
  PetscCall(EnvelopeDestroy(&r->envelope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultDestroy(Result *r)
{
  PetscFunctionBeginUser;
  PetscCall(ResultReset(r));
  PetscCall(PetscFree(r->probes));
  PetscCall(GatherMeshDestroy(&r->mesh));
  PetscCall(GroundDestroy(&r->ground));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the displacements of the named points. Each point has one owner; the other ranks give -infinity. */
PetscErrorCode ResultProbes(const Problem *p, PetscReal *u_max)
{
  const Model *m = p->m;
  const PetscInt n = m->mesh.n_points, width = sizeof(Probe) / sizeof(PetscReal);
  Probe *probes = p->found->probes;
  PetscFunctionBeginUser;
  *u_max = 0.;
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt v = m->mesh.point_vertex[i];
    const PetscBool own = (PetscBool)(v >= 0 && v < m->mesh.n_owned);
    for (int x = 0; x < 2; x++) {
      probes[i].X[x] = own ? m->mesh.X[2 * v + x] : -INFINITY;
      probes[i].u[x] = own ? Shown(p->state, 3 * m->rigid.n + 2 * v + x) : -INFINITY;
    }
  }
  for (PetscInt i = 0; i < m->mesh.n_owned; i++) {
    const PetscInt d = 3 * m->rigid.n + 2 * i;
    const PetscReal square = PetscSqr(Shown(p->state, d)) + PetscSqr(Shown(p->state, d + 1));
    if (!(square <= *u_max)) *u_max = square; // the condition lets NaN through
  }
  probes[n].u[0] = *u_max; // one message for all
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, probes, (PetscMPIInt)((n + 1) * width), MPIU_REAL, MPI_MAX, m->comm));
  *u_max = PetscSqrtReal(probes[n].u[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

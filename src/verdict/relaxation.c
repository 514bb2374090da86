/* relaxation.c: creates, starts and archives the memory of the static stages of a run. */
#include "verdict/judge.h"

PetscErrorCode RelaxationCreate(const Scene *scene, const Model *m, Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  PetscCall(DampingCreate(m, &r->damping));
  r->evidence.max_ratios = CHUNK_MAX / scene->check_every + 2;
  PetscCall(PetscCalloc3(m->n_dof, &r->evidence.u_0, m->n_dof, &r->account.u, m->n_dof, &r->account.f));
  PetscCall(PetscCalloc4(m->n_dof, &r->evidence.u_chunk, m->n_dof, &r->evidence.du_chunk, m->n_dof,
                         &r->evidence.r_chunk, r->evidence.max_ratios, &r->evidence.ratios));
  PetscCall(RestPointCreate(scene, m, &r->evidence.rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationDestroy(Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(DampingDestroy(&r->damping));
  PetscCall(RestPointDestroy(&r->evidence.rest));
  PetscCall(PetscFree4(r->evidence.u_chunk, r->evidence.du_chunk, r->evidence.r_chunk, r->evidence.ratios));
  PetscCall(PetscFree3(r->evidence.u_0, r->account.u, r->account.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationArchive(Archive *a, const Model *m, Relaxation *r)
{
  QuotientSums *q = &r->damping.sums;
  PetscFunctionBeginUser;
  PetscCall(ArchiveRealMembers(
      a, "reals", &q->num[0], &q->num[1], &q->den[0], &q->den[1], &q->num_max, &q->den_max,
      &r->damping.q_secant, &r->damping.best_ratio, &r->damping.q_ray, &r->evidence.median[0],
      &r->evidence.median[1], &r->evidence.median[2], &r->evidence.median[3], &r->evidence.rate[0],
      &r->evidence.rate[1], &r->evidence.rate[2], &r->evidence.rate[3], &r->evidence.alpha_sum,
      &r->evidence.settled_alpha, &r->evidence.longest, &r->follow.half_ratio, &r->reached, &r->step,
      &r->work_before, &r->evidence.ahead[0], &r->evidence.ahead[1], &r->evidence.ahead[2], &r->account.start,
      &r->account.stored, &r->account.most, &r->account.ramp, &r->account.lost));
  PetscCall(ArchiveIntMembers(a, "counts", INT_MEMBER(r->damping.tangent_only),
                              INT_MEMBER(r->damping.best_cycle), INT_MEMBER(r->evidence.n_ratios),
                              INT_MEMBER(r->evidence.steady), INT_MEMBER(r->evidence.chunk_start),
                              INT_MEMBER(r->evidence.chunk_length), INT_MEMBER(r->evidence.n_alpha),
                              INT_MEMBER(r->account.made_energy), INT_MEMBER(r->follow.half_cycle),
                              INT_MEMBER(r->follow.stalls), INT_MEMBER(r->begun)));
  const PetscInt64 n_ratios = ArchiveWithin(a, "ratios", r->evidence.n_ratios, 0, PETSC_MAX_INT);
  r->evidence.n_ratios = (PetscInt)PetscMin(n_ratios, r->evidence.max_ratios);
  PetscCall(ArchiveReals(a, "ratios", r->evidence.n_ratios, r->evidence.ratios));
  PetscCall(ArchiveDofs(a, m, "u_0", r->evidence.u_0));
  PetscCall(ArchiveDofs(a, m, "u_secant", r->damping.u_secant));
  PetscCall(ArchiveDofs(a, m, "f_secant", r->damping.f_secant));
  PetscCall(ArchiveDofs(a, m, "account_u", r->account.u));
  PetscCall(ArchiveDofs(a, m, "account_f", r->account.f));
  PetscCall(ArchiveDofs(a, m, "u_chunk", r->evidence.u_chunk));
  PetscCall(ArchiveDofs(a, m, "du_chunk", r->evidence.du_chunk));
  PetscCall(ArchiveDofs(a, m, "r_chunk", r->evidence.r_chunk));
  PetscCall(RestPointArchive(a, m, &r->evidence.rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationStart(const Model *m, const Contacts *c, const State *state, Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(DampingStart(m, state, &r->damping));
  PetscCall(PetscArraycpy(r->evidence.u_0, state->u, m->n_dof));
  r->evidence.longest = 0.;
  for (PetscInt i = 0; i < c->n_padded; i++)
    r->evidence.longest = PetscMax(r->evidence.longest, c->length[i]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &r->evidence.longest, 1, MPIU_REAL, MPI_MAX, m->comm));
  r->account.made_energy = 0;
  r->follow.half_ratio = PETSC_MAX_REAL, r->follow.half_cycle = state->cycle, r->follow.stalls = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* snapshot.c: keeps the stable state from which a trial starts, or a step of the water that is repeated. */
#include "stages/stages.h"

PetscErrorCode SnapshotCreate(const Problem *p, Snapshot *s)
{
  const Model *m = p->m;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(ModelApplied(m), &s->u, m->n_dof, &s->u_verified, ModelApplied(m), &s->f_ext,
                         p->state->applied.n_loads, &s->share));
  PetscCall(PetscArrayzero(s->u_verified, m->n_dof));
  s->nonlinear = s->corrected = NULL;
  if (p->state->nonlinear)
    PetscCall(PetscMalloc2(ModelApplied(m), &s->nonlinear, ModelApplied(m), &s->corrected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SnapshotDestroy(Snapshot *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(s->nonlinear, s->corrected));
  PetscCall(PetscFree4(s->u, s->u_verified, s->f_ext, s->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SnapshotTake(const Problem *p, Snapshot *s)
{
  const TermView view = ViewOf(p);
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(s->u, p->state->u, ModelApplied(p->m)));
  s->contact_depth = p->m->contact_depth;
  if (p->state->u_verified) PetscCall(PetscArraycpy(s->u_verified, p->state->u_verified, p->m->n_dof));
  PetscCall(PetscArraycpy(s->f_ext, p->state->f_ext, ModelApplied(p->m)));
  PetscCall(PetscArraycpy(s->share, p->state->applied.share[SHARE_NOW], p->state->applied.n_loads));
  if (s->nonlinear) PetscCall(PetscArraycpy(s->nonlinear, p->state->nonlinear, ModelApplied(p->m)));
  if (s->nonlinear) PetscCall(PetscArraycpy(s->corrected, p->state->corrected, ModelApplied(p->m)));
  PetscCall(TermsHistory(&view, KEEP_STABLE));
  s->alpha = p->state->alpha, s->q_ray = p->relax->damping.q_ray;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SnapshotRestore(const Problem *p, const Snapshot *s)
{
  const TermView view = ViewOf(p);
  PetscFunctionBeginUser;
  if (ContactsVary(p->contacts,
                   p->stage)) { // the local numbers in the contacts are valid where the contacts were found
    PetscCall(PetscArraycpy(p->state->u_verified, s->u_verified, p->m->n_dof));
    p->m->contact_depth = s->contact_depth;
    PetscCall(NeighboursAt(p->m, p->state, s->u_verified));
  }
  PetscReal *u = p->state->u;
  PetscCall(PetscArraycpy(u, s->u, ModelApplied(p->m)));
  PetscCall(PetscArrayzero(p->state->v, p->m->n_dof));
  PetscCall(PetscArraycpy(p->state->f_ext, s->f_ext, ModelApplied(p->m)));
  PetscCall(PetscArraycpy(p->state->applied.share[SHARE_NOW], s->share, p->state->applied.n_loads));
  if (s->nonlinear) PetscCall(PetscArraycpy(p->state->nonlinear, s->nonlinear, ModelApplied(p->m)));
  if (s->nonlinear) PetscCall(PetscArraycpy(p->state->corrected, s->corrected, ModelApplied(p->m)));
  PetscCall(CondensedTakeNonlinear(p->m, p->state));
  PetscCall(TermsHistory(&view, BACK_TO_STABLE));
  p->state->alpha = s->alpha, p->relax->damping.q_ray = s->q_ray;
  PetscCall(GhostBegin(p->m, u + 3 * p->m->rigid.n));
  PetscCall(GhostEnd(p->m, u + 3 * p->m->rigid.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SnapshotArchive(Archive *a, const Problem *p, Snapshot *s)
{
  const TermView view = ViewOf(p);
  const PetscBool moves = (PetscBool)(a->reading && p->state->u_verified);
  PetscFunctionBeginUser;
  PetscCall(ArchiveApplied(a, p->m, "u", s->u));
  PetscCall(ArchiveDofs(a, p->m, "u_verified", s->u_verified));
  PetscCall(ArchiveApplied(a, p->m, "f_ext", s->f_ext));
  if (p->state->applied.n_loads) PetscCall(ArchiveReals(a, "share", p->state->applied.n_loads, s->share));
  if (p->m->condensed.large) PetscCall(ArchiveApplied(a, p->m, "nonlinear", s->nonlinear));
  if (p->m->condensed.large) PetscCall(ArchiveApplied(a, p->m, "corrected", s->corrected));
  if (a->reading) RigidMotion(p->m, s->u);
  if (moves) PetscCall(NeighboursAt(p->m, p->state, s->u_verified));
  PetscCall(TermsArchiveStable(a, &view));
  if (moves) PetscCall(NeighboursAt(p->m, p->state, p->state->u_verified));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* state_archive.c: writes and reads the state of a run, by gid; see archive.h. */
#include "motion/motion.h"

PetscErrorCode NeighboursAt(Model *m, State *s, const PetscReal *u)
{
  PetscReal *kept;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_dof, &kept));
  PetscCall(PetscArraycpy(kept, s->u, m->n_dof));
  PetscCall(PetscArraycpy(s->u, u, m->n_dof));
  PetscCall(DisplacementsComplete(m, s->u));
  PetscCall(NeighboursUpdate(m, s));
  PetscCall(PetscArraycpy(s->u, kept, m->n_dof));
  PetscCall(DisplacementsComplete(m, s->u));
  PetscCall(PetscFree(kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Archives the displacements at the last verification. In a run that never verifies, contacts belong to the
   reference state, so zeros are written. */
static PetscErrorCode archive_verified(Archive *a, Model *m, State *s)
{
  PetscReal *reference = NULL;
  PetscFunctionBeginUser;
  if (!s->u_verified) PetscCall(PetscCalloc1(m->n_dof, &reference));
  PetscCall(ArchiveReals(a, "contact_depth", 1, &m->contact_depth));
  PetscCall(ArchiveDofs(a, m, "u_verified", reference ? reference : s->u_verified));
  PetscCall(PetscFree(reference));
  if (a->reading && s->u_verified) PetscCall(NeighboursAt(m, s, s->u_verified));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateArchive(Archive *a, const Scene *scene, Model *m, State *s, Contacts *c)
{
  PetscReal reals[] = {s->dt,
                       s->alpha,
                       s->beta,
                       s->time,
                       s->applied.ramp,
                       c->rate,
                       (PetscReal)c->friction,
                       (PetscReal)c->counted,
                       c->pull,
                       s->step_divisor,
                       c->lead,
                       c->margin,
                       (PetscReal)c->outgrown};
  const TermView view = {.scene = scene, .m = m, .contacts = c, .state = s};
  PetscInt turn = s->applied.turn;
  PetscFunctionBeginUser;
  PetscCall(ArchiveCounts(a, "cycle", 1, &s->cycle));
  PetscCall(ArchiveReals(a, "dt_alpha_beta_time_ramp_rate_friction_counted_pull_caution_lead_margin_outgrown",
                         13, reals));
  if (a->reading && reals[12] > 0.)
    PetscCall(ContactsOutgrow(scene, m, s, c)); // of the contacts of the start
  PetscCall(archive_verified(a, m, s));
  PetscCall(StateGive(s));
  PetscCall(ArchiveVec(a, m, "u", PETSC_TRUE, s->displacement));
  PetscCall(ArchiveVec(a, m, "v", PETSC_FALSE, s->velocity));
  PetscCall(ArchiveVec(a, m, "f", PETSC_FALSE, s->force));
  PetscCall(ArchiveVec(a, m, "f_ext", PETSC_TRUE, s->load));
  PetscCall(ArchiveVec(a, m, "m", PETSC_FALSE, s->mass));
  PetscCall(StateTake(s));
  PetscCall(ArchiveApplied(a, m, "f_start", s->applied.start));
  PetscCall(ArchiveApplied(a, m, "f_target", s->applied.target));
  static const char *const shares[] = {"share_start", "share_target", "share_now"};
  for (int i = 0; i < SHARES && s->applied.n_loads; i++)
    PetscCall(ArchiveReals(a, shares[i], s->applied.n_loads, s->applied.share[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &turn, 1, MPIU_INT, MPI_MAX, m->comm));
  PetscCall(ArchiveInts(a, "loads_turn", 1, &turn));
  PetscCall(ArchiveDofs(a, m, "m_inv", s->m_inv));
  PetscCall(TermsArchive(a, &view));
  PetscCall(CondensedArchive(a, m, s));
  // the arrays are NULL on a rank without vertices, which takes part all the same
  if (m->condensed.large) PetscCall(ArchiveApplied(a, m, "nonlinear", s->nonlinear));
  if (m->condensed.large) PetscCall(ArchiveApplied(a, m, "corrected", s->corrected));
  if (!a->reading) PetscFunctionReturn(PETSC_SUCCESS);
  s->applied.turn = (PetscBool)turn; // on a rank without such loads LoadsTurn turns none
  s->dt = reals[0], s->alpha = reals[1], s->beta = reals[2];
  s->time = reals[3], s->applied.ramp = reals[4], c->rate = reals[5], c->friction = (FrictionMode)reals[6];
  c->counted = (PetscBool)(reals[7] > 0.), c->pull = reals[8], s->step_divisor = reals[9];
  c->lead = reals[10], c->margin = reals[11], c->outgrown = (PetscBool)(reals[12] > 0.);
  PetscCall(CondensedTakeNonlinear(m, s));
  PetscCall(CondensedLoadsFind(m, s->applied.target + 3 * m->rigid.n));
  PetscCall(DisplacementsComplete(m, s->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

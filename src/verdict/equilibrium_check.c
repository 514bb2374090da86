/* equilibrium_check.c: checks how near a stage that has converged is to its equilibrium.

   The law. Friction that still follows the law, or that has kept slip as it came, gives other forces than the
   law. So the forces of the law itself, with friction from the committed history, are evaluated. Their
   unbalanced ratio says little near a limit load, where a tiny force makes a large displacement. So they are
   evaluated a second time, at u - BACK du, where du is the displacement since the stage began. The fraction
   of du by which du is wrong is then the Newton step along it,

     fraction = du.r / du.K du,   K du = (f(u) - f(u - BACK du))/BACK.

   Where a body slips along all its contacts by the law, nothing holds it in place, and its error is not known
   (load_path.c).

   The stage's own change. The unbalanced ratio is relative to all forces on a body. A stage that changes
   these forces little converges while its own change is still out of balance, by the fraction du.r / du.(f -
   f_0) along du. */
#include "verdict/verdict.h"

/* Copy of the history of contacts and of their friction mode, while forces of the law are evaluated. */
typedef struct {
  PetscReal *history;
  FrictionMode friction;
} Kept;

/* Makes contacts use the law, from the committed history. kept: receives the copy for restore_contacts. */
static PetscErrorCode use_law(Contacts *c, Kept *kept)
{
  PetscReal *history[END_ARRAYS];
  const int arrays = ContactsEndArrays(c, FIELD_HISTORY | FIELD_CRUSHED, history);
  const PetscInt n = 2 * c->n_padded;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(arrays * n, &kept->history));
  for (int i = 0; i < arrays; i++) PetscCall(PetscArraycpy(kept->history + i * n, history[i], n));
  kept->friction = c->friction;
  c->friction = FRICTION_LAW;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restores the history and the friction mode of the stage. */
static PetscErrorCode restore_contacts(Contacts *c, const Kept *kept)
{
  PetscReal *history[END_ARRAYS];
  const int arrays = ContactsEndArrays(c, FIELD_HISTORY | FIELD_CRUSHED, history);
  const PetscInt n = 2 * c->n_padded;
  PetscFunctionBeginUser;
  c->friction = kept->friction;
  for (int i = 0; i < arrays; i++) PetscCall(PetscArraycpy(history[i], kept->history + i * n, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Evaluates forces, and finds the unbalanced ratio. contact_scale: as in Unbalanced. */
static PetscErrorCode unbalanced(const Problem *p, PetscReal *contact_scale, PetscReal *ratio)
{
  StageResult law = {.ratio = 0.};
  PetscFunctionBeginUser;
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, p->state, contact_scale));
  PetscCall(Unbalanced(p->m, p->state, contact_scale, p->relax->evidence.u_0, &law));
  *ratio = law.ratio;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckFrictionLaw(const Problem *p, PetscReal *contact_scale)
{
  PetscReal ratio;
  Kept kept;
  PetscFunctionBeginUser;
  if (p->result->verdict != VERDICT_CONVERGED || p->contacts->friction != FRICTION_PULLED)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(use_law(p->contacts, &kept));
  PetscCall(unbalanced(p, contact_scale, &ratio));
  if (!(ratio <= p->stage->tolerance)) {
    p->result->verdict = VERDICT_NONE;
    PetscCall(restore_contacts(p->contacts, &kept));
  }
  PetscCall(PetscFree(kept.history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sums r.du, f.du and (f - f_0).du into work [J], where du is the displacement from where the
   account was opened (energy_check.c) to u (n_dof,). most [m]: the largest entries of du and of u. */
static PetscErrorCode work_along(const Problem *p, const PetscReal *u, PetscReal work[3], PetscReal most[2])
{
  const State *s = p->state;
  const Relaxation *r = p->relax;
  PetscFunctionBeginUser;
  work[0] = work[1] = work[2] = most[0] = most[1] = 0.;
  for (PetscInt d = 0; d < p->m->n_dof; d++) {
    const PetscReal du = u[d] - r->account.u[d], length = DofLength(p->m, s, d);
    most[0] = PetscMax(most[0], PetscAbsReal(du) * length);
    most[1] = PetscMax(most[1], PetscAbsReal(u[d]) * length);
    if (Held(p->m, d)) continue;
    work[0] += du * (s->f_ext[d] - s->f[d]), work[1] += du * s->f[d],
        work[2] += du * (s->f[d] - r->account.f[d]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 3, MPIU_REAL, MPI_SUM, p->m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 2, MPIU_REAL, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Estimates the fraction of du by which du is wrong by the law, as the head of this file says.
   The forces of the law must have been evaluated last. */
static PetscErrorCode wrong_fraction(const Problem *p, PetscReal *fraction)
{
  const PetscInt n = p->m->n_dof;
  PetscReal here[3], behind[3], most[2], *u;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &u));
  PetscCall(PetscArraycpy(u, p->state->u, n));
  PetscCall(work_along(p, u, here, most));
  for (PetscInt d = 0; d < n; d++) p->state->u[d] = u[d] - BACK * (u[d] - p->relax->account.u[d]);
  PetscCall(DisplacementsComplete(p->m, p->state->u));
  PetscCall(Forces(p->scene, p->m, p->stage->joints, p->contacts, p->state, NULL));
  PetscCall(work_along(p, u, behind, most));
  PetscCall(PetscArraycpy(p->state->u, u, n));
  PetscCall(DisplacementsComplete(p->m, p->state->u));
  const PetscReal drives = PetscAbsReal(here[0]), holds = (here[1] - behind[1]) / BACK;
  *fraction = drives < holds ? drives / holds : drives > 0. ? 1. : 0.;
  if (most[0] < CHANGE_LEAST * most[1]) *fraction = 0.;
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the ratio and the error by the law to the evidence. */
static PetscErrorCode report_path(PetscReal ratio, const char *off, StageResult *result)
{
  char text[128];
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(text, sizeof(text),
                          "; slip kept as it came: by the law a ratio of %.2g, the way off by %s",
                          (double)ratio, off));
  PetscCall(PetscStrlcat(result->evidence, text, sizeof(result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of local damping where a contact has slipped. Local damping lets blocks run past their equilibrium,
   and slip keeps them there. That place is an equilibrium by the law too, so no check of balance can find
   it. */
static PetscErrorCode warn_of_overshoot(const Problem *p)
{
  const Contacts *c = p->contacts;
  PetscBool slipped = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * c->n_padded && !slipped; i++) slipped = (PetscBool)(c->slip[i] != 0.);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &slipped, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  if (!slipped) PetscFunctionReturn(PETSC_SUCCESS);
  p->relax->path_warned = PETSC_TRUE;
  if (p->m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  Warn(
      "stage %s: damping: local lets blocks run past their place, and slip keeps that: near "
      "a limit load displacements can be several times too large, and no balance shows it; damping: adaptive "
      "has no such slip",
      p->stage->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckPathDependence(const Problem *p, PetscReal *contact_scale)
{
  const Scene *scene = p->scene;
  const PetscReal least = PATH_TIMES * p->stage->tolerance;
  PetscReal ratio, fraction = 0.;
  PetscBool carried = PETSC_TRUE;
  Kept kept;
  PetscFunctionBeginUser;
  PetscCall(use_law(p->contacts, &kept));
  PetscCall(unbalanced(p, contact_scale, &ratio));
  if (ratio > least) PetscCall(BodiesAreSupported(p, least, &carried));
  if (ratio > least) PetscCall(wrong_fraction(p, &fraction));
  PetscCall(restore_contacts(p->contacts, &kept));
  PetscCall(PetscFree(kept.history));
  char off[32] = "an unknown part";
  if (carried && fraction < 1.)
    PetscCall(PetscSNPrintf(off, sizeof(off), "about %.2g %%", (double)(100. * fraction)));
  if (scene->damping == DAMPING_ADAPTIVE) PetscCall(report_path(ratio, off, p->result));
  const PetscBool warns = (PetscBool)(!p->relax->path_warned &&
                                      (ratio > PATH_RATIO || fraction > PATH_WAY || !carried));
  if (scene->damping == DAMPING_LOCAL && !warns && !p->relax->path_warned) PetscCall(warn_of_overshoot(p));
  if (warns) p->relax->path_warned = PETSC_TRUE; // one warning is enough for a stage with many trials
  if (p->m->rank || !warns) PetscFunctionReturn(PETSC_SUCCESS);
  Warn(
      "stage %s: slip was kept as it came and depends on how the loads were applied: "
      "counted from the last equilibrium it leaves an unbalanced ratio of %.2g, and displacements are off by "
      "%s of the way since the stage began, which later stages inherit; use %s%sa longer ramp",
      p->stage->name, (double)ratio, off, scene->damping == DAMPING_ADAPTIVE ? "" : "damping: adaptive, or ",
      ContactsVary(p->contacts, p->stage) || scene->method == METHOD_PRECONDITIONED
          ? ""
          : "method: preconditioned, or ");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckRound(const Problem *p)
{
  PetscReal work[3], most[2];
  PetscFunctionBeginUser;
  PetscCall(work_along(p, p->state->u, work, most));
  p->relax->account.rounds = PetscMax(p->relax->account.rounds, PetscAbsReal(work[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlippedContacts(const Problem *p, PetscReal part, PetscInt n[2])
{
  const Contacts *c = p->contacts;
  PetscReal most = 0.;
  PetscFunctionBeginUser;
  for (PetscInt at = 0; at < SUB(c->n_padded, 0); at++) most = PetscMax(most, -c->sigma[at]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  n[0] = n[1] = 0;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    PetscBool slipped = PETSC_FALSE;
    if (c->key[2 * i] < 0 || !c->owned[i]) continue;
    for (int k = 0; k < 2; k++)
      if (c->slip[SUB(i, k)] != 0. && (part < 0. || -c->sigma[SUB(i, k)] > part * most)) slipped = PETSC_TRUE;
    n[0]++, n[1] += slipped;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2, MPIU_INT, MPI_SUM, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckManySlips(const Problem *p)
{
  PetscInt n[2];
  PetscReal order;
  PetscFunctionBeginUser;
  if (p->relax->path_warned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlippedContacts(p, -1., n));
  if (n[0] < RUBBLE_LEAST || (PetscReal)n[1] < MANY_SLIP * (PetscReal)n[0])
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ContactsOrder(p->m, p->contacts, &order));
  if (order >= RUBBLE_ORDER) PetscFunctionReturn(PETSC_SUCCESS);
  p->relax->path_warned = PETSC_TRUE;
  if (p->m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: %" PetscInt_FMT " of %" PetscInt_FMT " contacts have slipped. Where so many slip in rubble "
       "there may be several equilibria: in half of such dams displacements by another ramp or method "
       "differ by more than 0.5 %%; compare runs with other ramps",
       p->stage->name, n[1], n[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckStageIncrement(const Problem *p)
{
  PetscReal work[3], most[2];
  PetscFunctionBeginUser;
  if (p->stage->kind != STAGE_STATIC) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(work_along(p, p->state->u, work, most));
  const PetscReal whole = PetscMax(work[2], p->relax->account.rounds),
                  fraction = work[2] > 0. ? PetscAbsReal(work[0]) / whole : 0.;
  if (p->m->rank || !(fraction > CHANGE_UNBALANCED) || most[0] < CHANGE_LEAST * most[1])
    PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: its loads change the forces little, and about %.2g %% of this change is still out of "
       "balance, so its displacements are off by as much: use the "
       "key tolerance: %.1g of the stage or of relaxation",
       p->stage->name, (double)(100. * fraction),
       (double)(p->stage->tolerance * 0.1 * CHANGE_UNBALANCED / fraction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sums over all condensed bodies the moment that a body lacks times its turn since the account
   was opened, into work [J]. A condensed body is linear, so forces act on it where it was before it moved;
   the missing moment is the sum of u x f. The turn is the rotation that fits the displacements of the kept
   vertices best. */
static PetscErrorCode turning_work(const Problem *p, PetscReal *work)
{
  enum { COUNT, X, Y, U, V, DU, DV, TURN, ARM, MOMENT, SUMS };
  const Model *m = p->m;
  const LocalMesh *mesh = &m->mesh;
  const PetscInt at = 3 * m->rigid.n;
  const PetscReal *u = p->state->u + at, *u_0 = p->relax->account.u + at;
  PetscReal *f, (*sum)[SUMS];
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * (mesh->n_vertices + DUMMY_VERTICES), &f));
  PetscCall(PetscCalloc1(mesh->n_condensed_global, &sum));
  ElementForcesCondensed(m, u, f);
  for (PetscInt v = 0; v < mesh->n_owned; v++) {
    if (mesh->vertex_condensed[v] < 0) continue;
    PetscReal *s = sum[mesh->vertex_condensed[v]];
    s[MOMENT] += u[2 * v] * f[2 * v + 1] - u[2 * v + 1] * f[2 * v];
    if (v >= mesh->n_moving) continue;
    s[COUNT] += 1., s[X] += mesh->X[2 * v], s[Y] += mesh->X[2 * v + 1];
    s[DU] += u[2 * v] - u_0[2 * v], s[DV] += u[2 * v + 1] - u_0[2 * v + 1];
  }
  for (PetscInt v = 0; v < mesh->n_moving; v++) {
    if (mesh->vertex_condensed[v] < 0) continue;
    PetscReal *s = sum[mesh->vertex_condensed[v]];
    const PetscReal x = mesh->X[2 * v] - s[X] / s[COUNT], y = mesh->X[2 * v + 1] - s[Y] / s[COUNT];
    s[TURN] += x * (u[2 * v + 1] - u_0[2 * v + 1] - s[DV] / s[COUNT]) -
               y * (u[2 * v] - u_0[2 * v] - s[DU] / s[COUNT]);
    s[ARM] += x * x + y * y;
  }
  *work = 0.;
  for (PetscInt b = 0; b < mesh->n_condensed_global; b++)
    if (sum[b][ARM] > 0.) *work += sum[b][MOMENT] * sum[b][TURN] / sum[b][ARM];
  PetscCall(PetscFree(f));
  PetscCall(PetscFree(sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 1, MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckCondensedRotation(const Problem *p)
{
  PetscReal work[3], most[2], turning;
  PetscFunctionBeginUser;
  if (!p->m->mesh.n_condensed_global || p->scene->strain == STRAIN_SMALL) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(work_along(p, p->state->u, work, most));
  PetscCall(turning_work(p, &turning));
  const PetscReal fraction = work[2] > 0. ? PetscAbsReal(turning) / work[2] : 0.;
  if (p->m->rank || !(fraction > MOMENTS_LACK) || most[0] < CHANGE_LEAST * most[1])
    PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: forces act on condensed bodies where these were before they moved: "
       "displacements are off by about %.2g %% of the way since the stage began; do not condense slender "
       "bodies under strain: large",
       p->stage->name, (double)(100. * fraction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

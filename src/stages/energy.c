/* energy.c: keeps the energy account of a dynamic stage. The scheme (11) conserves

     1/2 v(t - dt/2).m v(t + dt/2) + potential energy(t)

   exactly in a linear system, so kinetic energy is taken as that product and works are sums of
   1/2 (F(t) + F(t - dt)).(u(t) - u(t - dt)). The remaining imbalance is the error of the time step.

   Joints: the work of a contact is the work of its end forces on d.n and d.s (force.c), to which they are
   conjugate. When contacts are found again at time t, the scheme uses the new forces at t: their difference
   from the old forces has worked over the half step before t (EnergyOfExchange). The energy that joints store
   is 1/2 sigma^2/k_n + 1/2 tau^2/k_s over their length; work less storage is lost in friction, crushing and
   dashpots. */
#include "stages/stages.h"
#include "base/lanes.h"

enum { ENERGY_SUMS = 8, ALL_SUMS = ENERGY_SUMS + COUPLED_WORKS }; /* number of sums of a rank */

static const PetscReal UNBALANCED = 0.01; /* [-] of the energy moved: a larger imbalance of the account is
                                             reported */
static const PetscReal FOLLOWS_TO = 0.3;  /* [-] above it the modes left out do not follow kept vertices at
                                             once */
static const PetscReal ROUNDING = 1e-6;   /* [-] of the energy stored at the start: a smaller imbalance is
                                             rounding */
static const PetscReal EXACT = 1e-12;     /* [-] as ROUNDING, for the energy of tendons, which no contact can
                                             change */
static const PetscReal DISOWNED = 0.1;    /* [-] of the energy moved: if more is made from nothing, the stage
                                             has diverged */

PetscErrorCode EnergyCreate(const Model *m, EnergyAccount *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(e, sizeof(*e)));
  PetscCall(PetscMalloc1(m->n_dof, &e->v_before));
  PetscCall(PetscMalloc1(m->n_dof, &e->f_before));
  PetscCall(PetscCalloc1(m->n_dof, &e->f_ext_before));
  if (m->mesh.n_condensed_global) PetscCall(PetscCalloc1(m->n_dof, &e->u_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyDestroy(EnergyAccount *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(e->v_before));
  PetscCall(PetscFree(e->f_before));
  PetscCall(PetscFree(e->f_ext_before));
  PetscCall(PetscFree(e->u_start));
  PetscCall(PetscFree5(e->F_n, e->F_s, e->d_n, e->d_s, e->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyContactsChanged(const Contacts *c, EnergyAccount *e)
{
  const PetscInt n = 2 * c->n_padded;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < e->n_contacts; i++) e->work_before += e->work[i];
  PetscCall(PetscFree5(e->F_n, e->F_s, e->d_n, e->d_s, e->work));
  PetscCall(PetscMalloc5(n, &e->F_n, n, &e->F_s, n, &e->d_n, n, &e->d_s, c->n_padded, &e->work));
  PetscCall(PetscArraycpy(e->F_n, c->F_n, n));
  PetscCall(PetscArraycpy(e->F_s, c->F_s, n));
  PetscCall(PetscArraycpy(e->d_n, c->u_n, n)); // `rest` is constant: changes are those of d.n
  PetscCall(PetscArraycpy(e->d_s, c->u_s, n));
  PetscCall(PetscArrayzero(e->work, c->n_padded));
  e->n_contacts = c->n_padded;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Archives the sums of this rank, then the work of each contact so far. The works stay separate, so that
   later sums are rounded as if there had been no restart. */
static PetscErrorCode archive_summands(Archive *a, EnergyAccount *e, PetscReal sums[ALL_SUMS])
{
  const PetscInt n = ALL_SUMS + e->n_contacts;
  PetscBool mine = PETSC_FALSE;
  PetscReal *x;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &x));
  PetscCall(PetscArraycpy(x, sums, ALL_SUMS));
  PetscCall(PetscArraycpy(x + ALL_SUMS, e->work, e->n_contacts));
  PetscCall(ArchiveSummands(a, "summands", n, x, &mine));
  if (mine) {
    PetscCall(PetscArraycpy(sums, x, ALL_SUMS));
    PetscCall(PetscArraycpy(e->work, x + ALL_SUMS, e->n_contacts));
  }
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyArchive(Archive *a, const Model *m, const Contacts *c, EnergyAccount *e)
{
  PetscReal sums[ALL_SUMS] = {e->kinetic, e->strain,        e->outside,     e->supports,
                              e->damping, e->damping_ahead, e->work_before, e->handed};
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(sums + ENERGY_SUMS, e->local, COUPLED_WORKS));
  if (!a->reading) PetscCall(archive_summands(a, e, sums));
  for (PetscInt i = 0; i < e->n_contacts && !a->reading; i++) sums[6] += e->work[i];
  PetscCall(ArchiveSums(a, "energies", ALL_SUMS, sums));
  PetscCall(ArchiveRealMembers(a, "energies_at_start", &e->detection, &e->kinetic_0, &e->strain_0,
                               &e->joints_0, &e->prestress_0, &e->given[0], &e->given[1]));
  PetscCall(ArchiveDofs(a, m, "f_ext_before", e->f_ext_before));
  if (m->mesh.n_condensed_global) PetscCall(ArchiveDofs(a, m, "u_start", e->u_start));
  if (!a->reading) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EnergyContactsChanged(c, e)); // forces and openings of the cycle before belong to c
  PetscCall(archive_summands(a, e, sums));
  e->kinetic = sums[0], e->strain = sums[1], e->outside = sums[2], e->supports = sums[3];
  e->damping = sums[4], e->damping_ahead = sums[5], e->work_before = sums[6], e->handed = sums[7];
  PetscCall(PetscArraycpy(e->local, sums + ENERGY_SUMS, COUPLED_WORKS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the work of LANES ends: the mean force over the step times the motion in the step. Keeps the end of
   the step for the next. */
KERNEL Lanes WorkOfEnds(const PetscReal *F, const PetscReal *d, PetscReal *F_before, PetscReal *d_before)
{
  const Lanes force = LoadLanes(F), way = LoadLanes(d),
              work = 0.5 * (force + LoadLanes(F_before)) * (way - LoadLanes(d_before));
  StoreLanes(F_before, force);
  StoreLanes(d_before, way);
  return work;
}

KERNEL void OfContacts_code(PetscReal thickness, const Contacts *c, EnergyAccount *e)
{
  for (PetscInt i = 0; i < c->n_padded; i += LANES) {
    const bool *o = c->owned + i;
    const Mask owned = {-o[0], -o[1], -o[2], -o[3]};
    Lanes w = LanesOf(0.);
    for (int k = 0; k < 2; k++) {
      const PetscInt at = SUB(i, k);
      w += WorkOfEnds(c->F_n + at, c->u_n + at, e->F_n + at, e->d_n + at) +
           WorkOfEnds(c->F_s + at, c->u_s + at, e->F_s + at, e->d_s + at);
    }
    StoreLanes(e->work + i, LoadLanes(e->work + i) + Keep(owned, thickness * w));
  }
}

VARIANTS(OfContacts, (PetscReal thickness, const Contacts *c, EnergyAccount *e), (thickness, c, e))

void EnergyOfContacts(const Model *m, const Contacts *c, EnergyAccount *e)
{
  OfContacts(m->materials.thickness, c, e);
}

void EnergyOfExchange(const Model *m, const State *s, EnergyAccount *e)
{
  for (PetscInt d = 0; d < m->n_dof; d++)
    e->work_before += 0.5 * (s->f[d] - e->f_before[d]) * s->v[d] * s->dt;
}

void EnergyOfStep(const StepWorks *works, EnergyAccount *e)
{
  e->outside += works->outside, e->supports += works->supports;
  e->kinetic = works->kinetic;
  e->damping += works->damping, e->damping_ahead = works->damping_ahead;
}

/* Returns the kinetic energy that exists at the present time alone, without the half step ahead. */
static PetscReal kinetic_of(const EnergyAccount *e)
{
  return e->kinetic + e->local[COUPLED_KINETIC] + e->local[COUPLED_INSIDE];
}

/* Returns a sum for the new step. The sum up to this time belongs to the old step, and the half step ahead
   to the new one. The new step will book all of itself, from the time before on; this is subtracted in
   advance. */
static PetscReal handed_over(PetscReal closed, PetscReal closed_ahead, PetscReal opened,
                             PetscReal opened_ahead)
{
  return closed - closed_ahead + opened_ahead - (opened - closed);
}

void EnergyHandOver(const EnergyAccount *before, const EnergyAccount *closed, EnergyAccount *e)
{
  static const int sums[][2] = {{COUPLED_DASHPOTS, COUPLED_DASHPOTS_AHEAD},
                                {COUPLED_SUPPORTS, COUPLED_SUPPORTS_AHEAD},
                                {COUPLED_DRAG, COUPLED_DRAG_AHEAD}};
  e->handed += kinetic_of(e) - kinetic_of(closed);
  e->outside = handed_over(closed->outside, 0., e->outside, 0.);
  e->supports = handed_over(closed->supports, 0., e->supports, 0.);
  e->damping = handed_over(closed->damping, closed->damping_ahead, e->damping, e->damping_ahead);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(sums); i++)
    e->local[sums[i][0]] = handed_over(closed->local[sums[i][0]], closed->local[sums[i][1]],
                                       e->local[sums[i][0]], e->local[sums[i][1]]);
  // waves come in over half of either step
  const PetscReal in[2] = {closed->local[COUPLED_INCOMING] - before->local[COUPLED_INCOMING],
                           e->local[COUPLED_INCOMING] - closed->local[COUPLED_INCOMING]};
  e->local[COUPLED_INCOMING] = closed->local[COUPLED_INCOMING] - 0.5 * (in[0] + in[1]);
}

PetscErrorCode EnergyOfBlocks(const Problem *p, EnergyAccount *e)
{
  const Instant now = InstantOf(p);
  PetscReal within, on;
  PetscFunctionBeginUser;
  PetscCall(TermsEnergy(PHASE_BLOCKS, p->state, &now, &within));
  PetscCall(TermsEnergy(PHASE_BODIES, p->state, &now, &on));
  e->lost = TermsDissipated(p->state);
  e->strain = within + on + e->lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyOfJoints(const Problem *p, PetscReal *stored)
{
  const Instant now = InstantOf(p);
  PetscFunctionBeginUser;
  PetscCall(TermsEnergy(PHASE_JOINTS, p->state, &now, stored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error of a motion by the modes that condensed bodies lack. The estimate takes the mass of
   these modes as fixed to kept vertices; gathered modes (condense_left_out.c) make the error smaller. Modes
   left out that follow accelerations at once store the part `share` of the energy of the bodies: stresses, of
   which energy is the square, are wrong by its root. In a free vibration omega^2 is too high by `share`, the
   frequency by half as much. ratio: mean square of the frequency of kept vertices over the square of the
   first frequency left out. */
static void find_truncation(PetscReal share, PetscReal ratio, Energies *out)
{
  const PetscBool follows = (PetscBool)(ratio <= FOLLOWS_TO * FOLLOWS_TO);
  out->frequency_ratio = PetscSqrtReal(ratio);
  out->truncation[0] = follows ? PetscSqrtReal(PetscMax(share, 0.)) : NAN;
  out->truncation[1] = follows ? 0.5 * PetscMax(share, 0.) : NAN;
}

/* Returns the energy moved [J]. Of the energy stored at the start only the part given away counts: prestress
   and weight that stay the same move nothing. */
static PetscReal moved_in(const EnergyAccount *start, const Energies *e)
{
  const PetscReal stored = PetscAbsReal(start->strain_0 - start->prestress_0) + start->joints_0;
  const PetscReal judged = ROUNDING * stored + EXACT * start->prestress_0;
  return PetscAbsReal(e->outside) + PetscAbsReal(e->supports) + PetscAbsReal(e->incoming) + start->kinetic_0 +
         PetscMax(start->given[0] + start->given[1], judged);
}

PetscErrorCode EnergyReport(const Problem *p, EnergyAccount *e, PetscBool first, Energies *out)
{
  PetscReal in_joints;
  PetscFunctionBeginUser;
  PetscCall(EnergyOfJoints(p, &in_joints));
  if (first) { // the account starts at this time
    e->outside = e->supports = 0., e->damping = e->damping_ahead;
    e->local[COUPLED_DASHPOTS] = e->local[COUPLED_DASHPOTS_AHEAD], e->local[COUPLED_INCOMING] = 0.;
    e->local[COUPLED_SUPPORTS] = e->local[COUPLED_SUPPORTS_AHEAD];
    e->local[COUPLED_DRAG] = e->local[COUPLED_DRAG_AHEAD], e->local[COUPLED_LOADS] = 0.;
  }
  PetscReal sum[16] = {e->kinetic + e->local[COUPLED_KINETIC] + e->local[COUPLED_INSIDE],
                       e->strain + e->local[COUPLED_STRAIN],
                       in_joints,
                       e->outside + e->local[COUPLED_LOADS],
                       e->supports + e->local[COUPLED_SUPPORTS] - e->local[COUPLED_SUPPORTS_AHEAD],
                       e->damping - e->damping_ahead + TermsDamped(p->state) + e->local[COUPLED_DRAG] -
                           e->local[COUPLED_DRAG_AHEAD],
                       e->work_before,
                       e->local[COUPLED_INCOMING],
                       e->local[COUPLED_DASHPOTS] - e->local[COUPLED_DASHPOTS_AHEAD],
                       e->local[COUPLED_KINETIC],
                       e->lost,
                       e->handed,
                       e->local[COUPLED_TRUNCATED],
                       e->local[COUPLED_STORED],
                       e->local[COUPLED_ACCELERATION],
                       e->local[COUPLED_VELOCITY]};
  for (PetscInt i = 0; i < e->n_contacts; i++) sum[6] += e->work[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 16, MPIU_REAL, MPI_SUM, p->m->comm));
  if (first) {
    const TermView view = ViewOf(p);
    e->kinetic_0 = sum[0], e->strain_0 = sum[1], e->joints_0 = sum[2], e->given[0] = e->given[1] = 0.;
    PetscCall(TermsPrestressed(&view, &e->prestress_0));
  }
  e->given[0] = PetscMax(e->given[0], PetscMin(e->strain_0 - sum[1], PetscAbsReal(e->strain_0)));
  e->given[1] = PetscMax(e->given[1], PetscMin(e->joints_0 - sum[2], e->joints_0));
  out->kinetic = sum[0], out->strain = sum[1] - sum[10], out->yielded = sum[10], out->joints = sum[2],
  out->outside = sum[3], out->supports = sum[4], out->damping = sum[5];
  out->incoming = sum[7], out->radiated = sum[7] - sum[8], out->water = sum[9];
  out->detection = e->detection;
  out->reduced = (PetscBool)(sum[15] > 0.);
  if (out->reduced) find_truncation(sum[12] / sum[13], sum[14] / sum[15], out);
  out->friction = sum[6] - (sum[2] - e->joints_0 - e->detection);
  out->balance = sum[3] + sum[4] + sum[8] - (sum[0] - e->kinetic_0 - sum[11]) - (sum[1] - e->strain_0) -
                 sum[6] - sum[5];
  out->moved = moved_in(e, out);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the advice that reduces the largest of three energies made from nothing: balance of the steps,
   contacts found again, joints that gave energy. */
static const char *remedy(PetscReal balance, PetscReal detection, PetscReal given)
{
  if (balance >= PetscMax(detection, given)) return "";
  if (given >= detection) return "change the stress model to pt, or ";
  return "raise k_n, so that blocks overlap less (docs/deviations.md, v), or ";
}

/* Describes how far the account is out of balance, and why. */
static PetscErrorCode describe_account(const Stage *stage, const Energies *e, PetscReal out, PetscReal moved,
                                       char words[static 512])
{
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
      words, 512,
      "the energy account is out by %.2g of the %.3g J moved (balance %.2g J, finding contacts again %.2g J, "
      "loss in joints %.2g J): %s%s",
      (double)(out / moved), (double)moved, (double)e->balance, (double)e->detection, (double)e->friction,
      remedy(PetscAbsReal(e->balance), PetscAbsReal(e->detection), PetscMax(0., -e->friction)),
      StepControlRemedy(stage)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode report_truncation(const Problem *p, const Energies *e)
{
  PetscFunctionBeginUser;
  if (!e->reduced) PetscFunctionReturn(PETSC_SUCCESS);
  if (PetscIsNanReal(e->truncation[0]))
    PetscCall(PetscPrintf(p->m->comm,
                          "stage %s: the error by the modes that condensed bodies lack is not known: their "
                          "kept vertices move at %.2g times the first frequency left out: raise "
                          "highest_frequency, or compare with the whole mesh\n",
                          p->stage->name, (double)e->frequency_ratio));
  else
    PetscCall(PetscPrintf(p->m->comm,
                          "stage %s: for the modes that condensed bodies lack stresses of the motion are off "
                          "by up to some %.2g %%, root mean square, its frequencies by up to some %.2g %%\n",
                          p->stage->name, 100. * (double)e->truncation[0], 100. * (double)e->truncation[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Judges the account. Reports an imbalance: of the steps, of contacts found again, of joints that gave energy
   rather than lost it. Where a tenth of the energy comes from nothing, the motion is not a motion of the
   model. */
PetscErrorCode EnergyJudge(const Problem *p)
{
  StageResult *r = p->result;
  const Energies *e = &r->energy;
  const PetscReal moved = e->moved;
  const PetscReal made = PetscAbsReal(e->balance) + PetscMax(0., e->detection) + PetscMax(0., -e->friction);
  const PetscReal out = made + PetscMax(0., -e->detection);
  char words[512];
  PetscFunctionBeginUser;
  PetscCall(describe_account(p->stage, e, out, moved, words));
  if (made > DISOWNED * moved) {
    r->verdict = VERDICT_DIVERGED;
    PetscCall(PetscStrncpy(r->evidence, words, sizeof(r->evidence)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (out > UNBALANCED * moved) PetscCall(WarnAll(p->m->comm, "stage %s: %s", p->stage->name, words));
  PetscCall(report_truncation(p, e));
  r->verdict = VERDICT_COMPLETED;
  PetscCall(BodyMotionReport(p->m, &p->found->bodies, sizeof(words), words));
  PetscCall(PetscSNPrintf(
      r->evidence, sizeof(r->evidence),
      "%s%.6g s in %" PetscInt64_FMT " steps; energy balance %.2g J, finding contacts again %.2g J of %.3g J "
      "moved; contacts verified %" PetscInt64_FMT " times, %" PetscInt64_FMT " made, %" PetscInt64_FMT
      " lost",
      words, (double)p->stage->duration, r->cycles, (double)e->balance, (double)e->detection, (double)moved,
      r->verifications, r->contacts_made, r->contacts_lost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

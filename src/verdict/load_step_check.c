/* load_step_check.c: checks whether yielding and cracking of blocks depend on how the load was applied.

   The step. A static stage goes from one equilibrium to the next in one step, with one return to the
   strength. Where a point reaches one limit first and then another, several steps along the same path end
   elsewhere. So the path is repeated in each block that has yielded, alone, in several equal steps of its
   displacements.

   The ramp. A load that rises faster than its structure swings overshoots. A block that has yielded recovers,
   because its history is committed at the equilibrium. A crack does not recover: beyond its peak it bears
   less, and it grows on.

   The flow. With dilation below friction flow is not associated, so the force of a block has a curl, as
   friction of joints has (friction_mode.c). Cycles on fine meshes may swing about an equilibrium for ever,
   which Newton's method finds in a few iterations. */
#include "verdict/verdict.h"

/* Makes the vertex array of displacements u (n_dof,), ghosts included. Vertices of rigid bodies keep their
   present displacements `now`. */
static PetscErrorCode at_vertices(const Model *m, const PetscReal *u, const PetscReal *now, PetscReal **at)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), at));
  PetscCall(PetscArraycpy(*at, now, 2 * (m->mesh.n_vertices + DUMMY_VERTICES)));
  PetscCall(PetscArraycpy(*at, u + 3 * m->rigid.n, 2 * m->mesh.n_deformable));
  PetscCall(GhostBegin(m, *at));
  PetscCall(GhostEnd(m, *at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Warns of small strain where blocks have yielded too far for it: the equilibrium belongs to
   shapes that no longer exist. */
static PetscErrorCode warn_of_strain(const Problem *p, PetscReal plastic)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &plastic, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  if (p->m->materials.strain == STRAIN_LARGE || !(plastic > MOST_PLASTIC)) PetscFunctionReturn(PETSC_SUCCESS);
  p->relax->step_warned = p->number + 1;
  if (p->m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: a block has a plastic strain of %.2g, and strain: small neglects the change of shape: this "
       "is rather a mechanism than an equilibrium; compare with strain: large",
       p->stage->name, (double)plastic);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the fraction of each load that acted at this fraction of the ramp. share: (2 n_loads,) these
   fractions, then room for as many. */
static PetscErrorCode shares_at(const Applied *a, PetscReal ramp, PetscReal **share)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * a->n_loads, share));
  for (PetscInt l = 0; l < a->n_loads; l++)
    (*share)[l] = (1. - ramp) * a->share[SHARE_START][l] + ramp * a->share[SHARE_TARGET][l];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckLoadStep(const Problem *p, PetscReal ramp_0, const PetscReal *u_0)
{
  const Model *m = p->m;
  const Applied *applied = &p->state->applied;
  LawSteps mine = {.block = -1, .warns = STEP_WARNS}, all;
  PetscReal *from, *share;
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (p->relax->step_warned == p->number + 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    any = (PetscBool)(any || e->history);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(at_vertices(m, u_0, p->state->u + 3 * m->rigid.n, &from));
  PetscCall(shares_at(applied, ramp_0, &share));
  mine.share_0 = share, mine.share = share + applied->n_loads;
  LawsInSteps(m, from, p->state->u + 3 * m->rigid.n, &mine);
  PetscCall(PetscFree(share));
  PetscCall(PetscFree(from));
  PetscCall(warn_of_strain(p, mine.plastic));
  all = mine;
  PetscCallMPI(MPI_Allreduce(&mine.fraction, &all.fraction, 1, MPIU_REAL, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(mine.n, all.n, 2, MPIU_INT, MPI_SUM, m->comm));
  if (!(all.fraction > STEP_WARNS)) PetscFunctionReturn(PETSC_SUCCESS);
  if (mine.fraction < all.fraction) mine.block = -1;
  PetscCallMPI(MPI_Allreduce(&mine.block, &all.block, 1, MPIU_INT, MPI_MAX, m->comm));
  p->relax->step_warned = p->number + 1;
  if (m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  Warn("stage %s: its load is applied in one step, and yielding depends on the path: in %d steps the forces "
       "of block %d would differ by %.2g %% (%d of %d blocks that have yielded differ by more than %g %%); "
       "load it by more stages, or by method: preconditioned with increments",
       p->stage->name, LAW_STEPS, (int)all.block, (double)(100. * all.fraction), (int)all.n[1], (int)all.n[0],
       (double)(100. * STEP_WARNS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the period [cycles] of the slowest motion, as damping has found it in this stage or in an earlier
   one that converged; 0: not known. */
static PetscReal slowest_period(const Problem *p)
{
  const PetscReal alpha = p->relax->evidence.settled_alpha;
  return alpha > 0. ? 4. * PETSC_PI / (alpha * p->state->dt) : 0.;
}

/* Returns the cycles of the ramp that one may have counted for where blocks crack (static.c: set_pace). */
static PetscReal hurry(const Problem *p)
{
  const PetscBool hurries = (PetscBool)(p->relax->effort.stiffness_mass && !p->relax->effort.explicit);
  return hurries ? (PetscReal)PetscMax(1, p->stage->ramp / RAMP_CRACKED) : 1.;
}

PetscErrorCode CheckRampLength(const Problem *p)
{
  const PetscReal period = hurry(p) * slowest_period(p);
  const PetscReal slow = period > 0. ? SLOW_PERIODS * period : SLOW_CYCLES;
  char known[64] = "";
  PetscBool cracks = LawsCrack(p->m);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cracks, 1, MPI_PETSC_BOOL, MPI_LOR, p->m->comm));
  if (p->m->rank || !cracks || (PetscReal)p->stage->ramp >= slow) PetscFunctionReturn(PETSC_SUCCESS);
  if (period > 0.)
    snprintf(known, sizeof(known), ", less than two periods of the slowest motion (%.3g each)",
             (double)period);
  Warn("stage %s: blocks crack while loads rise in %d cycles%s: so fast a load overshoots, and cracks that "
       "it opens stay open; use ramp: %.2g",
       p->stage->name, (int)p->stage->ramp, known, (double)(1.1 * slow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the end of a joint that softens has lost its strength at once, not along a slope. */
static PetscBool fell_at_once(const Contacts *c, const Joint *joint, PetscInt at)
{
  if (c->broken[at] < 0.5) return PETSC_FALSE;
  return (PetscBool)(c->state[at] & CONTACT_OPEN ? !(joint->fracture_energy[0] > 0.)
                                                 : PetscMax(0., -c->sigma[at]) >= JointSteepPressure(joint));
}

/* Returns whether an end has failed and lost stress at once. An open end whose residual tensile strength
   equals its strength bears no less than a joint that does not break. */
static PetscBool has_lost_stress(const Contacts *c, const Joint *joint, PetscInt at)
{
  const PetscBool opened = (PetscBool)(c->state[at] & CONTACT_OPEN && joint->tension[0] == joint->tension[1]);
  return (PetscBool)(c->broken[at] - c->broken_0[at] > FAILED && !opened &&
                     (!JointSoftens(joint) || fell_at_once(c, joint, at)));
}

enum { BROKEN, BROKEN_ENDS, SLIPPING, COUNTS };

/* Collective. Counts the contacts that have lost stress so, their ends, and the contacts that slip. */
static PetscErrorCode count(const Problem *p, PetscInt n[COUNTS])
{
  const Contacts *c = p->contacts;
  PetscInt mine[COUNTS] = {0};
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const Joint *joint = p->stage->joints + c->joint[i];
    if (c->key[2 * i] < 0 || !c->owned[i]) continue;
    const PetscInt ends = has_lost_stress(c, joint, SUB(i, 0)) + has_lost_stress(c, joint, SUB(i, 1));
    const int states = c->state[SUB(i, 0)] | c->state[SUB(i, 1)];
    mine[BROKEN] += ends > 0, mine[BROKEN_ENDS] += ends, mine[SLIPPING] += (states & CONTACT_SLIPPING) != 0;
  }
  PetscCallMPI(MPI_Allreduce(mine, n, COUNTS, MPIU_INT, MPI_SUM, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CountFailedContacts(const Problem *p, PetscInt *n_broken, PetscInt *n_slipping)
{
  PetscInt n[COUNTS];
  PetscFunctionBeginUser;
  PetscCall(count(p, n));
  *n_broken = n[BROKEN], *n_slipping = n[SLIPPING];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CountBrokenEnds(const Problem *p, PetscInt *n_ends)
{
  PetscInt n[COUNTS];
  PetscFunctionBeginUser;
  PetscCall(count(p, n));
  *n_ends = n[BROKEN_ENDS];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckSteepSlope(const Problem *p)
{
  static PetscInt warned; // number of the stage, from 1
  const Contacts *c = p->contacts;
  PetscReal *most;
  PetscFunctionBeginUser;
  if (warned == p->number + 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(p->scene->n_joints, &most));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && c->key[2 * i] >= 0; k++) {
      const PetscReal broken = c->broken[SUB(i, k)]; // above 0.5: it never had a strength to lose
      if (broken > 0. && broken <= 0.5) most[c->joint[i]] = PetscMax(most[c->joint[i]], -c->sigma[SUB(i, k)]);
    }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, most, (PetscMPIInt)p->scene->n_joints, MPIU_REAL, MPI_MAX, p->m->comm));
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    const Joint *joint = p->stage->joints + j;
    const PetscReal steep = JointSteepPressure(joint), lost = joint->cohesion[0] - joint->cohesion[1],
                    all = lost + most[j] * (joint->tan_phi[0] - joint->tan_phi[1]);
    if (!(joint->fracture_energy[1] > 0. && most[j] > 0. && most[j] >= steep)) continue;
    warned = p->number + 1;
    if (p->m->rank) continue;
    Warn("stage %s: joints.%s softens under a pressure of up to %.4g Pa; from %.4g Pa on it loses its shear "
         "strength at once, because friction falls too: give fracture_energy_shear above %.4g N/m, or raise "
         "k_s",
         p->stage->name, joint->name, (double)most[j], (double)steep,
         (double)(lost * all / (2. * joint->k_s)));
  }
  PetscCall(PetscFree(most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SlowFlowWarn(const Problem *p)
{
  static PetscInt warned; // number of the stage, from 1
  const Model *m = p->m;
  if (p->relax->follow.stalls < STALLS_TO_LET_GO || ContactsVary(p->contacts, p->stage) ||
      warned == p->number + 1)
    return;
  warned = p->number + 1;
  for (PetscInt g = 0; g < m->materials.n_groups && !m->rank; g++) {
    const Material *material = p->scene->materials + g;
    if (material->law != MATERIAL_MOHR_COULOMB || !(material->dilation < material->friction)) continue;
    Warn("stage %s: after %" PetscInt64_FMT " cycles the unbalanced ratio, %.2g, hardly "
         "falls, and blocks of group %s yield with dilation %.3g below friction %.3g degrees: cycles may "
         "oscillate about an equilibrium without end; try relaxation.method: preconditioned",
         p->stage->name, p->result->cycles, (double)p->result->ratio, m->materials.names[g],
         (double)material->dilation, (double)material->friction);
    return;
  }
}

/* search_energy.c: finds the energy that a search for contacts makes or loses, body by body. The account of a
   stage counts all bodies together. There the energy that one pair of bodies gains from nothing is lost
   beside a heavy body that falls. So each search is judged by itself: new contacts must not start with energy
   that their bodies do not have. */
#include "stages/stages.h"

/* Sums of each macroblock: kinetic energy and energy of its joints before the search [J]; energy of its
   joints after it [J]; weight [N]; number of degrees of freedom that are held. */
enum { KINETIC, BEFORE, AFTER, WEIGHT, HELD, SUMS };
/* [-] of the energy of two bodies: if one search makes more, the stage has diverged */
static const PetscReal DISOWNED = 0.1;

/* Adds the energy of the springs of each owned contact to both of its bodies. */
static void add_stored(const Problem *p, int column, PetscReal *sum)
{
  const Contacts *c = p->contacts;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; c->owned[i] && k < ContactEnds(c, i); k++) {
      const PetscInt at = SUB(i, k);
      const PetscReal stored = 0.5 * p->m->materials.thickness *
                               (c->F_n[at] * c->sigma[at] / p->stage->joints[c->joint[i]].k_n +
                                c->F_s[at] * (c->u_s[at] - c->slip[at]));
      PetscInt vertex[3];
      ContactEndVertices(c, i, k, vertex);
      for (int side = 0; side < 2; side++)
        sum[SUMS * p->m->mesh.vertex_body[vertex[side]] + column] += stored;
    }
}

PetscErrorCode SearchEnergyBegin(const Problem *p, SearchEnergy *made)
{
  const Model *m = p->m;
  PetscFunctionBeginUser;
  PetscCall(EnergyOfJoints(p, made->stored));
  PetscCall(PetscCalloc1(SUMS * m->mesh.n_bodies_global, &made->sum));
  add_stored(p, BEFORE, made->sum);
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscInt at = 3 * m->rigid.n, along = d < at ? d % 3 : (d - at) % 2;
    PetscReal *sum = made->sum + SUMS * DofBody(m, d);
    sum[KINETIC] += 0.5 * DofMass(m, d) * PetscSqr(p->state->v[d]);
    if (!along) sum[WEIGHT] += p->scene->gravity * DofMass(m, d);
    sum[HELD] += Held(m, d);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the energy [J] of a body: of its motion, of its joints, and of its weight over the displacement
   between two searches. */
static PetscReal has(const Model *m, const PetscReal *sum)
{
  return sum[HELD] > 0. ? 0. : sum[KINETIC] + sum[BEFORE] + sum[WEIGHT] * m->contact_margin;
}

PetscErrorCode SearchEnergyEnd(const Problem *p, SearchEnergy *made, PetscReal *detection)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  StageResult *r = p->result;
  const PetscInt n = m->mesh.n_bodies_global;
  PetscReal *sum = made->sum, *partner;
  PetscFunctionBeginUser;
  PetscCall(EnergyOfJoints(p, made->stored + 1));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, made->stored, 2, MPIU_REAL, MPI_SUM, m->comm));
  *detection += made->stored[1] - made->stored[0];
  add_stored(p, AFTER, sum);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(SUMS * n), MPIU_REAL, MPI_SUM, m->comm));
  PetscCall(PetscCalloc1(n, &partner));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    PetscInt vertex[3];
    if (!c->owned[i]) continue;
    ContactEndVertices(c, i, 0, vertex);
    for (int side = 0; side < 2; side++) {
      const PetscInt b = m->mesh.vertex_body[vertex[side]], other = m->mesh.vertex_body[vertex[1 - side]];
      partner[b] = PetscMax(partner[b], has(m, sum + SUMS * other));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, partner, (PetscMPIInt)n, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt b = 0; b < n && r->verdict != VERDICT_DIVERGED; b++) {
    const PetscReal *s = sum + SUMS * b, from_nothing = s[AFTER] - s[BEFORE];
    const PetscReal there = has(m, s) + partner[b];
    if (s[HELD] > 0. || from_nothing <= DISOWNED * there + 1e-12 * made->stored[1]) continue;
    r->verdict = VERDICT_DIVERGED;
    PetscCall(PetscSNPrintf(
        r->evidence, sizeof(r->evidence),
        "t = %.6g s: contacts of macroblock %" PetscInt_FMT
        " begin with %.3g J from nothing where it and what it meets have %.3g J: the step is too large "
        "(%s) or k_n too low",
        (double)p->state->time, b, (double)from_nothing, (double)there, StepControlRemedy(p->stage)));
  }
  PetscCall(PetscFree(partner));
  PetscCall(PetscFree(made->sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* blows.c: what contacts that close and open ask of the step.

   A contact that closes at speed v within a step has been pressed in by p at its end, and was open by g at
   its start, p + g = v dt. The scheme takes the mean force, so the contact has worked k A p (p + g)/2 and
   stores k A p^2/2: k A p g/2, at most k A (v dt)^2/8, is lost, and as much is made where it opens. The
   account does not see that, because it books the work. So the error is foreseen: ends that open or close
   within the next few steps, at the speed they have, are summed body by body,

   sum k_n A (v dt)^2 / 8  over  M V^2 / 2,

   M the mass of the body, V the largest speed at which contacts of the stage have opened or closed so far.
   For one blow of a body at V it is (omega dt)^2/4, omega its frequency on the contacts that it meets:
   quick blows ask for short steps, and blows that are slow beside others, or of a few vertices of a large
   body, for none. The dashpot of a joint acts at once where a contact closes, somewhere within a step:
   damping k_n A v^2 dt/2 over M V^2/2 in the mean.

   Sums are of whole numbers and all else are largest values, so every rank comes to the same answer. */
#include "stages/stages.h"

enum { HORIZON = 8 };                     /* steps within which a contact must not surprise */
static const PetscReal TOLERATED = 0.002; /* [-] of a body's energy at the largest speed */
static const PetscReal STILL = 1e-6;      /* [-] of the model in the stage: slower contacts rest */
static const PetscReal UNIT = 1073741824; /* 2^30: whole numbers in the error 1 */
static const PetscReal MOST = 1024;       /* errors beyond are not told apart */

/* ---- masses of bodies */

PetscErrorCode BlowsCreate(const Model *m, Pace *pace)
{
  const PetscReal grains = 68719476736.; /* 2^36 in the largest mass of a degree of freedom */
  const PetscInt at = 3 * m->n_bodies, n = m->n_bodies_global;
  PetscReal largest = 0.;
  PetscInt64 *sum;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &pace->mass, RUNGS * n, &pace->errors));
  PetscCall(PetscCalloc1(2 * n, &sum));
  for (PetscInt d = 0; d < m->n_dof; d++) largest = PetscMax(largest, DofMass(m, d));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt d = 0; d < m->n_dof && largest > 0.; d++) {
    const PetscInt along = d < at ? d % 3 : (d - at) % 2;
    if (!along) sum[2 * DofBody(m, d)] += (PetscInt64)(grains * (DofMass(m, d) / largest));
    if (Held(m, d)) sum[2 * DofBody(m, d) + 1]++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2 * n, MPIU_INT64, MPI_SUM, m->comm));
  for (PetscInt b = 0; b < n; b++)
    pace->mass[b] = sum[2 * b + 1] ? PETSC_INFINITY : largest * ((PetscReal)sum[2 * b] / grains);
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BlowsDestroy(Pace *pace)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(pace->mass, pace->errors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ends that open and close */

/* An end of a contact: its speed of opening [m/s], and in which time [s] it opens or closes at that speed. */
typedef struct {
  PetscReal speed, time;
} Meeting;

/* at: place of the end; rate: 1/dt. */
static Meeting meeting_of(const Contacts *c, const EnergyAccount *before, PetscInt at, PetscReal rate)
{
  const PetscReal u = c->u_n[at], speed = (u - before->d_n[at]) * rate;
  const PetscBool towards = (PetscBool)((u >= 0. && speed < 0.) || (u <= 0. && speed > 0.));
  return (Meeting){speed, towards ? -u / speed : PETSC_INFINITY};
}

/* Joints that hold whatever comes never open, but for contacts that have met in motion. */
static PetscBool opens(const Contacts *c, const Joint *joints, PetscInt i)
{
  return (PetscBool)(c->owned[i] &&
                     (joints[c->joint[i]].law != LAW_ELASTIC || c->broken[SUB(i, 0)] >= LOOSE));
}

/* The largest speed at which ends open or close; the least time in which one opens or closes. */
static PetscErrorCode survey(const Problem *p, const EnergyAccount *e, PetscReal *fastest, PetscReal *soonest)
{
  const Contacts *c = p->contacts;
  PetscReal all[2] = {*fastest, -PETSC_INFINITY}; // the least time is the largest of those with a minus
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && opens(c, p->stage->joints, i); k++) {
      const PetscInt at = SUB(i, k);
      const Meeting m = meeting_of(c, e, at, c->rate);
      all[0] = PetscMax(all[0], PetscAbsReal(m.speed));
      all[1] = PetscMax(all[1], -m.time);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 2, MPIU_REAL, MPI_MAX, p->m->comm));
  *fastest = all[0], *soonest = -all[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the error of an end, with the longest step, to those of both bodies, for all rungs that it
   surprises. */
static void add_end(const Problem *p, Pace *pace, PetscInt i, int k, const Meeting *meets)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const Joint *joint = p->stage->joints + c->joint[i];
  const PetscReal part = meets->speed / pace->fastest, dt = pace->longest,
                  stiffness = joint->k_n * 0.5 * c->length[i] * m->thickness,
                  of_spring = 0.25 * stiffness * PetscSqr(part * dt),
                  of_dashpot = c->u_n[SUB(i, k)] >= 0. ? joint->damping * stiffness * PetscSqr(part) * dt
                                                       : 0.;
  PetscInt vertex[3];
  ContactEndVertices(c, i, k, vertex);
  for (int side = 0; side < 2; side++) {
    const PetscInt body = m->vertex_body[vertex[side]];
    for (int rung = 0; rung < RUNGS && meets->time <= HORIZON * ldexp(dt, -rung); rung++) {
      const PetscReal error = (ldexp(of_spring, -2 * rung) + ldexp(of_dashpot, -rung)) / pace->mass[body];
      pace->errors[RUNGS * body + rung] += (PetscInt64)(UNIT * PetscMin(error, MOST));
    }
  }
}

PetscErrorCode BlowsLook(const Problem *p, const EnergyAccount *e, Pace *pace)
{
  const Contacts *c = p->contacts;
  const PetscInt n = RUNGS * p->m->n_bodies_global;
  PetscReal soonest = PETSC_INFINITY;
  PetscInt64 worst[RUNGS] = {0};
  PetscFunctionBeginUser;
  pace->fastest = PetscMax(pace->fastest, STILL * p->m->diameter / p->stage->duration);
  PetscCall(survey(p, e, &pace->fastest, &soonest));
  pace->wanted = 0;
  if (soonest > HORIZON * pace->longest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(pace->errors, n));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && opens(c, p->stage->joints, i); k++) {
      const Meeting meets = meeting_of(c, e, SUB(i, k), c->rate);
      if (meets.time <= HORIZON * pace->longest) add_end(p, pace, i, k, &meets);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, pace->errors, n, MPIU_INT64, MPI_SUM, p->m->comm));
  for (PetscInt i = 0; i < n; i++) worst[i % RUNGS] = PetscMax(worst[i % RUNGS], pace->errors[i]);
  while (pace->wanted < RUNGS - 1 && (PetscReal)worst[pace->wanted] > TOLERATED * UNIT) pace->wanted++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

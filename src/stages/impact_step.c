/* impact_step.c: what contacts that close and open ask of the step.

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

   Then the dashpot draws on the speeds of steps before, and of a speed that swings at omega it takes
   7/12 (omega dt)^2 too much. Half a swing loses 2 pi zeta of its energy, so of that it loses too much by
   2 pi zeta 7/12 (omega dt)^2. The swing after a blow dies out as exp(-2 zeta omega t). With the sums K of
   k_n A and D of damping k_n A over what is pressed, omega^2 = K/M and 2 zeta omega = D/M. So a body that has
   met another asks for a step, for the time t after that, by

   7 pi/12 (D/M) sqrt(K/M) dt^2 exp(-D/M t).

   Two free bodies swing against each other by 1/M_1 + 1/M_2, which the lighter one asks for. What is pressed
   and never opens has no blow, and asks for nothing.

   Sums are of whole numbers and all else are largest values, so every rank comes to the same answer. */
#include "stages/stages.h"

enum { HORIZON = 8 };                     /* steps within which a contact must not surprise */
static const PetscReal TOLERATED = 0.002; /* [-] of a body's energy at the largest speed */
static const PetscReal SMALL = 0.02;      /* [-] of that energy: blows of less keep no short step */
static const PetscReal STILL = 1e-6;      /* [-] of the model in the stage: slower contacts rest */
static const PetscReal UNIT = 1073741824; /* 2^30: whole numbers in the error 1 */
static const PetscReal MOST = 1024;       /* errors beyond are not told apart */

/* Columns of the table of bodies behind the errors of all rungs, with the longest step: K/M dt^2, D/M dt, how
   many ends meet on dashpots. */
enum { PRESSED = STEP_LEVELS, DAMPED, MET, COLUMNS };

/* ---- masses of bodies */

PetscErrorCode ImpactStepCreate(const Model *m, StepControl *pace)
{
  const PetscReal grains = 68719476736.; /* 2^36 in the largest mass of a degree of freedom */
  const PetscInt at = 3 * m->n_bodies, n = m->n_bodies_global;
  PetscReal largest = 0.;
  PetscInt64 *sum;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(n, &pace->mass, COLUMNS * n, &pace->table, n, &pace->met));
  PetscCall(PetscArrayzero(pace->met, n));
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

PetscErrorCode ImpactStepDestroy(StepControl *pace)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(pace->mass, pace->table, pace->met));
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

/* Whole numbers, so that sums are the same in every order. */
static PetscInt64 whole(PetscReal error)
{
  return (PetscInt64)(UNIT * PetscMin(error, MOST));
}

/* Adds an end to both bodies: its error with all rungs that it surprises, and how it is pressed. */
static void add_end(const Problem *p, StepControl *pace, PetscInt i, int k, const Meeting *meets)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const Joint *joint = p->stage->joints + c->joint[i];
  const PetscBool open = (PetscBool)(c->u_n[SUB(i, k)] >= 0.);
  const PetscReal part = meets->speed / pace->fastest, dt = pace->longest,
                  stiffness = joint->k_n * 0.5 * c->length[i] * m->thickness,
                  of_spring = 0.25 * stiffness * PetscSqr(part * dt),
                  of_dashpot = open ? joint->damping * stiffness * PetscSqr(part) * dt : 0.;
  PetscInt vertex[3];
  ContactEndVertices(c, i, k, vertex);
  for (int side = 0; side < 2; side++) {
    const PetscInt body = m->vertex_body[vertex[side]], other = m->vertex_body[vertex[1 - side]];
    // a lighter one asks for itself
    const PetscReal mobility = 1. / pace->mass[body] + 1. / PetscMax(pace->mass[body], pace->mass[other]);
    PetscInt64 *row = pace->table + COLUMNS * body;
    if (PetscIsInfReal(pace->mass[body])) continue;
    for (int rung = 0; rung < STEP_LEVELS && meets->time <= HORIZON * ldexp(dt, -rung); rung++)
      row[rung] += whole((ldexp(of_spring, -2 * rung) + ldexp(of_dashpot, -rung)) / pace->mass[body]);
    if (!(joint->damping > 0.)) continue;
    row[MET] += open && meets->time <= HORIZON * dt && PetscSqr(part) > SMALL;
    if (open) continue;
    row[PRESSED] += whole(stiffness * mobility * PetscSqr(dt));
    row[DAMPED] += whole(joint->damping * stiffness * mobility * dt);
  }
}

/* [-] what dashpots take too much from the swing of a body with the longest step, over the energy of the blow
   before. */
static PetscReal too_much(const StepControl *pace, PetscInt body)
{
  const PetscInt64 *row = pace->table + COLUMNS * body;
  const PetscReal damped = (PetscReal)row[DAMPED] / UNIT,
                  since = (PetscReal)(pace->done - pace->met[body]) / (PetscReal)StepControlTicks(pace, 0);
  return 7. * PETSC_PI / 12. * damped * PetscSqrtReal((PetscReal)row[PRESSED] / UNIT) *
         PetscExpReal(-damped * since);
}

static PetscErrorCode fill_table(const Problem *p, const EnergyAccount *e, StepControl *pace)
{
  const Contacts *c = p->contacts;
  const PetscInt n = COLUMNS * p->m->n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(pace->table, n));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && opens(c, p->stage->joints, i); k++) {
      const Meeting meets = meeting_of(c, e, SUB(i, k), c->rate);
      add_end(p, pace, i, k, &meets);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, pace->table, n, MPIU_INT64, MPI_SUM, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ImpactStepCheck(const Problem *p, const EnergyAccount *e, StepControl *pace)
{
  const PetscInt n = p->m->n_bodies_global;
  PetscReal soonest = PETSC_INFINITY;
  PetscFunctionBeginUser;
  pace->fastest = PetscMax(pace->fastest, STILL * p->m->diameter / p->stage->duration);
  PetscCall(survey(p, e, &pace->fastest, &soonest));
  pace->wanted = 0;
  if (soonest > HORIZON * pace->longest && !pace->swings) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(fill_table(p, e, pace));
  pace->swings = PETSC_FALSE;
  for (PetscInt b = 0; b < n; b++) {
    const PetscInt64 *row = pace->table + COLUMNS * b;
    if (row[MET]) pace->met[b] = pace->done;
    const PetscReal swing = too_much(pace, b);
    if (row[MET] || swing > TOLERATED) pace->swings = PETSC_TRUE;
    while (pace->wanted < STEP_LEVELS - 1 && ((PetscReal)row[pace->wanted] > TOLERATED * UNIT ||
                                              ldexp(swing, -2 * (int)pace->wanted) > TOLERATED))
      pace->wanted++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

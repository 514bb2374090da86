/* impact_step.c: finds the time step that contacts need as they close and open.

   A contact that closes at speed v within a step has been pressed in by p at its end, and was open by g at
   its start, p + g = v dt. The scheme takes the mean force, so the contact has worked k A p (p + g)/2 and
   stores k A p^2/2: k A p g/2, at most k A (v dt)^2/8, is lost, and as much is made where it opens. The
   account does not see this error, because it books the work. So the error is predicted: ends that open or
   close within the next few steps, at their present speed, are summed body by body,

   sum k_n A (v dt)^2 / 8  over  M V^2 / 2,

   M the mass of the body, V the largest speed at which contacts of the stage have opened or closed so far.
   For one impact of a body at V the sum is (omega dt)^2/4, where omega is its frequency on the contacts that
   it meets. Quick impacts need short steps. Impacts that are slow beside others, or of a few vertices of a
   large body, need none. The dashpot of a joint acts at once where a contact closes, somewhere within a step:
   damping k_n A v^2 dt/2 over M V^2/2 in the mean.

   Then the dashpot extrapolates from the speeds of earlier steps. At a speed that oscillates at omega it
   loses 7/12 (omega dt)^2 too much. Half an oscillation loses 2 pi zeta of its energy, so the excess is 2 pi
   zeta 7/12 (omega dt)^2 of it. The oscillation after an impact dies out as exp(-2 zeta omega t). With the
   sums K of k_n A and D of damping k_n A over pressed ends, omega^2 = K/M and 2 zeta omega = D/M. So a body
   that has met another limits the step for a time t after the impact by

   7 pi/12 (D/M) sqrt(K/M) dt^2 exp(-D/M t).

   Two free bodies swing against each other by 1/M_1 + 1/M_2, which limits the step of the lighter one. An end
   that is pressed and never opens has no impact, and sets no limit.

   Sums are of integers and all other values are maxima, so every rank finds the same answer. */
#include "stages/stages.h"

enum { HORIZON = 8 };                     /* steps within which a contact must not close or open unforeseen */
static const PetscReal TOLERATED = 0.002; /* [-] of a body's energy at the largest speed */
static const PetscReal SMALL = 0.02;      /* [-] of that energy: a smaller error keeps no short step */
static const PetscReal UNIT = 1073741824; /* 2^30: the integer that stands for an error of 1 */
static const PetscReal MOST = 1024;       /* larger errors count as this one */

/* Columns of the table of bodies, after the errors of all levels. With the longest step: K/M dt^2, D/M dt;
   number of ends that meet on dashpots. */
enum { PRESSED = STEP_LEVELS, DAMPED, MET, COLUMNS };

PetscErrorCode ImpactStepCreate(const Model *m, StepControl *control)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(COLUMNS * n, &control->table, n, &control->met));
  PetscCall(PetscArrayzero(control->met, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ImpactStepDestroy(StepControl *control)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(control->table, control->met));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ends that open and close */

/* An end of a contact: its speed of opening [m/s], and the time [s] until it opens or closes at this
   speed. */
typedef struct {
  PetscReal speed, time;
} Meeting;

/* Predicts the opening or closing of an end. at: place of the end; rate: 1/dt. */
static Meeting meeting_of(const Contacts *c, const EnergyAccount *before, PetscInt at, PetscReal rate)
{
  const PetscReal u = c->u_n[at], speed = (u - before->d_n[at]) * rate;
  const PetscBool towards = (PetscBool)((u >= 0. && speed < 0.) || (u <= 0. && speed > 0.));
  return (Meeting){speed, towards ? -u / speed : PETSC_INFINITY};
}

/* Decides whether a contact can open. Joints that carry any tension never open, except loose contacts. */
static PetscBool opens(const Contacts *c, const Joint *joints, PetscInt i)
{
  return (PetscBool)(c->owned[i] &&
                     (joints[c->joint[i]].law != LAW_ELASTIC || c->broken[SUB(i, 0)] >= LOOSE));
}

/* Collective. Finds the largest speed at which ends open or close, and the least time until one does. */
static PetscErrorCode find_impacts(const Problem *p, const EnergyAccount *e, PetscReal *fastest,
                                   PetscReal *soonest)
{
  const Contacts *c = p->contacts;
  PetscReal all[2] = {*fastest, -PETSC_INFINITY}; // the least time is minus the largest of the negative times
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

/* Converts an error to an integer, so that sums are the same in every order. */
static PetscInt64 to_integer(PetscReal error)
{
  return (PetscInt64)(UNIT * PetscMin(error, MOST));
}

/* Adds an end to both bodies: its error at every level whose step it falls into, and the stiffness of a
   pressed end. */
static void add_end(const Problem *p, StepControl *control, PetscInt i, int k, const Meeting *meets)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const Joint *joint = p->stage->joints + c->joint[i];
  const PetscBool open = (PetscBool)(c->u_n[SUB(i, k)] >= 0.);
  const PetscReal part = meets->speed / control->fastest, dt = control->longest,
                  stiffness = joint->k_n * 0.5 * c->length[i] * m->materials.thickness,
                  of_spring = 0.25 * stiffness * PetscSqr(part * dt),
                  of_dashpot = open ? joint->damping * stiffness * PetscSqr(part) * dt : 0.;
  PetscInt vertex[3];
  ContactEndVertices(c, i, k, vertex);
  for (int side = 0; side < 2; side++) {
    const PetscInt body = m->mesh.vertex_body[vertex[side]], other = m->mesh.vertex_body[vertex[1 - side]];
    // the lighter body limits the step itself
    const PetscReal mobility = 1. / control->mass[body] +
                               1. / PetscMax(control->mass[body], control->mass[other]);
    PetscInt64 *row = control->table + COLUMNS * body;
    if (PetscIsInfReal(control->mass[body])) continue;
    for (int level = 0; level < STEP_LEVELS && meets->time <= HORIZON * ldexp(dt, -level); level++)
      row[level] += to_integer((ldexp(of_spring, -2 * level) + ldexp(of_dashpot, -level)) /
                               control->mass[body]);
    if (!(joint->damping > 0.)) continue;
    row[MET] += open && meets->time <= HORIZON * dt && PetscSqr(part) > SMALL;
    if (open) continue;
    row[PRESSED] += to_integer(stiffness * mobility * PetscSqr(dt));
    row[DAMPED] += to_integer(joint->damping * stiffness * mobility * dt);
  }
}

/* Returns [-] the energy that dashpots take too much from the oscillation of a body with the longest step,
   over the energy of the last impact. */
static PetscReal dashpot_excess(const StepControl *control, PetscInt body)
{
  const PetscInt64 *row = control->table + COLUMNS * body;
  const PetscReal damped = (PetscReal)row[DAMPED] / UNIT,
                  since = (PetscReal)(control->done - control->met[body]) /
                          (PetscReal)StepControlTicks(control, 0);
  return 7. * PETSC_PI / 12. * damped * PetscSqrtReal((PetscReal)row[PRESSED] / UNIT) *
         PetscExpReal(-damped * since);
}

static PetscErrorCode fill_table(const Problem *p, const EnergyAccount *e, StepControl *control)
{
  const Contacts *c = p->contacts;
  const PetscInt n = COLUMNS * p->m->mesh.n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(control->table, n));
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && opens(c, p->stage->joints, i); k++) {
      const Meeting meets = meeting_of(c, e, SUB(i, k), c->rate);
      add_end(p, control, i, k, &meets);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, control->table, n, MPIU_INT64, MPI_SUM, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ImpactStepCheck(const Problem *p, const EnergyAccount *e, StepControl *control)
{
  const PetscInt n = p->m->mesh.n_bodies_global;
  PetscReal soonest = PETSC_INFINITY;
  PetscFunctionBeginUser;
  PetscCall(find_impacts(p, e, &control->fastest, &soonest));
  control->wanted = 0;
  if (soonest > HORIZON * control->longest && !control->swings) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(fill_table(p, e, control));
  control->swings = PETSC_FALSE;
  for (PetscInt b = 0; b < n; b++) {
    const PetscInt64 *row = control->table + COLUMNS * b;
    if (row[MET]) control->met[b] = control->done;
    const PetscReal swing = dashpot_excess(control, b);
    if (row[MET] || swing > TOLERATED) control->swings = PETSC_TRUE;
    while (control->wanted < STEP_LEVELS - 1 && ((PetscReal)row[control->wanted] > TOLERATED * UNIT ||
                                                 ldexp(swing, -2 * (int)control->wanted) > TOLERATED))
      control->wanted++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

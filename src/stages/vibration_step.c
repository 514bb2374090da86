/* vibration_step.c: finds the time step that vibrations need.

   The central difference makes a vibration of frequency omega too quick by (omega dt)^2/24 of itself. Slip
   depends on the phase of the vibrations on the way, so this error moves a block that slides. An acceleration
   that changes by da in a step dt has, for one vibration of speed v, dt |da| = (omega dt)^2 |v|. So for each
   body

     r = dt |da| / (sqrt(M) V),   |da|^2 = sum m da^2 over its degrees of freedom,

   M the mass of the body. V is the largest speed of a body so far, root mean square over its mass, and at
   least that of the ground in the whole stage. r is (omega dt)^2 of a vibration that moves the whole body at
   V, and less for one that is slower or moves a part of it.

   A body that its contacts hold comes back to its place. A body that has slid keeps what its vibrations have
   made of its way, so r is held smaller for the rest of the stage. Both limits were measured: deviations.md,
   x2.

   A check keeps what vibrations needed a short while ago, so that the step does not follow each swing.

   Where contacts are found again as blocks move, no block may move by the margin within which contacts are
   found before they are found again.

   Sums are of integers and all other values are maxima, so every rank finds the same answer. */
#include "stages/stages.h"

static const PetscReal HELD = 1e-3; /* [-] largest r of a body that its contacts hold */
/* [-] largest r of a body that has slid, or parted from others, at half of the ends of its contacts */
static const PetscReal AFTER_SLIDING = 4e-5;
static const PetscReal KEPT = 0.97; /* [-] part of what vibrations need that is kept from check to check */
enum { SEEN = 16 }; /* steps in which no block may move by the margin within which contacts are found */

/* Columns of the table of bodies: m da^2 and m v^2 in units of their largest summands, over 2^UNITS; ends of
   its contacts; of these, ends that are open or slip. */
enum { CHANGES, MOVES, ENDS, LOOSE_ENDS, COLUMNS, UNITS = 36 };

PetscErrorCode VibrationStepBegin(const Problem *p, StepControl *control)
{
  enum { SAMPLES = 2000 }; /* times of the stage at which records are looked at */
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < p->scene->n_supports; i++) {
    const Support *support = p->scene->supports + i;
    const PetscReal part2 = PetscSqr(GroundPart(support));
    Motion motion;
    PetscCall(MotionCreate(support, &motion));
    for (PetscInt k = 0; k <= SAMPLES && MotionMoves(&motion); k++) {
      const PetscReal t = p->state->time + p->stage->duration * (PetscReal)k / SAMPLES,
                      v[2] = {MotionVelocity(&motion, t, 0), MotionVelocity(&motion, t, 1)};
      control->speed2 = PetscMax(control->speed2, part2 * (v[0] * v[0] + v[1] * v[1]));
    }
    PetscCall(MotionDestroy(&motion));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VibrationStepCreate(const Model *m, StepControl *control)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(COLUMNS * n, &control->sums, n, &control->loose));
  PetscCall(PetscArrayzero(control->loose, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VibrationStepDestroy(StepControl *control)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(control->sums, control->loose));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums of bodies */

/* Computes m da^2 [kg m^2/s^4] and m v^2 [J] of a degree of freedom. */
static void summands_of(const Model *m, const State *s, PetscInt d, PetscReal summand[2])
{
  const PetscReal change = s->f[d] - s->f_old[d];
  summand[0] = s->m_inv[d] * change * change;
  summand[1] = Held(m, d) ? 0. : DofMass(m, d) * s->v[d] * s->v[d];
}

/* Counts the ends of contact i that bound its two bodies, and those that are open or slip. */
static void count_ends(const Model *m, const Contacts *c, PetscInt i, PetscInt64 *sums)
{
  for (int k = 0; k < ContactEnds(c, i); k++) {
    const PetscBool loose = (PetscBool)(c->state[SUB(i, k)] & (CONTACT_OPEN | CONTACT_SLIPPING));
    PetscInt vertex[3];
    ContactEndVertices(c, i, k, vertex);
    for (int side = 0; side < 2; side++) {
      PetscInt64 *row = sums + COLUMNS * m->mesh.vertex_body[vertex[side]];
      row[ENDS]++, row[LOOSE_ENDS] += loose;
    }
  }
}

/* What the degrees of freedom have at most. */
enum { OF_CHANGES, OF_MOVES, OF_SPEED, MAXIMA };

/* Collective. Finds the largest summands, and the largest speed [m/s] of a vertex or centre. */
static PetscErrorCode find_maxima(const Problem *p, PetscReal most[MAXIMA])
{
  const Model *m = p->m;
  const PetscReal *v = p->state->v;
  const PetscInt at = 3 * m->rigid.n;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(most, MAXIMA));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    PetscReal summand[2];
    summands_of(m, p->state, d, summand);
    most[OF_CHANGES] = PetscMax(most[OF_CHANGES], summand[0]);
    most[OF_MOVES] = PetscMax(most[OF_MOVES], summand[1]);
    if (d < at ? d % 3 == 0 : (d - at) % 2 == 0)
      most[OF_SPEED] = PetscMax(most[OF_SPEED], v[d] * v[d] + v[d + 1] * v[d + 1]);
  }
  most[OF_SPEED] = PetscSqrtReal(most[OF_SPEED]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, MAXIMA, MPIU_REAL, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of units of the table in a summand of 1, when the largest one is `most`. */
static PetscReal units_per(PetscReal most)
{
  static const PetscReal NOTHING = 1e-200;
  return most > NOTHING ? ldexp(1., UNITS) / most : 0.;
}

/* Collective. Fills the table of bodies. most: of find_maxima, finite. */
static PetscErrorCode fill_sums(const Problem *p, const PetscReal most[MAXIMA], StepControl *control)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  const PetscInt n = COLUMNS * m->mesh.n_bodies_global;
  const PetscReal scale[2] = {units_per(most[OF_CHANGES]), units_per(most[OF_MOVES])};
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(control->sums, n));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    PetscInt64 *row = control->sums + COLUMNS * DofBody(m, d);
    PetscReal summand[2];
    summands_of(m, p->state, d, summand);
    for (int i = 0; i < 2; i++)
      if (summand[i] > 0.) row[CHANGES + i] += (PetscInt64)(summand[i] * scale[i]);
  }
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->owned[i]) count_ends(m, c, i, control->sums);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, control->sums, n, MPIU_INT64, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the step */

/* Finds the largest mean square of the speed [m^2/s^2] of a body so far. */
static void note_speeds(const Problem *p, PetscReal unit, StepControl *control)
{
  for (PetscInt b = 0; b < p->m->mesh.n_bodies_global; b++) {
    const PetscReal moves = unit * ldexp((PetscReal)control->sums[COLUMNS * b + MOVES], -UNITS);
    if (control->free_mass[b] > 0.)
      control->speed2 = PetscMax(control->speed2, moves / control->free_mass[b]);
  }
}

/* Returns the largest r of a body over what it may be, with the present step. unit: [kg m^2/s^4] of the sums
   of changes. */
static PetscReal largest_ratio(const Problem *p, PetscReal unit, StepControl *control)
{
  PetscReal ratio = 0.;
  for (PetscInt b = 0; b < p->m->mesh.n_bodies_global; b++) {
    const PetscInt64 *row = control->sums + COLUMNS * b;
    if (!(control->free_mass[b] > 0.)) continue;
    if (row[ENDS] > 0 && 2 * row[LOOSE_ENDS] >= row[ENDS]) control->loose[b] = 1;
    const PetscReal change2 = unit * ldexp((PetscReal)row[CHANGES], -UNITS) / control->free_mass[b],
                    r = p->state->dt * PetscSqrtReal(change2 / control->speed2);
    ratio = PetscMax(ratio, r / (control->loose[b] ? AFTER_SLIDING : HELD));
  }
  return ratio;
}

PetscErrorCode VibrationStepCheck(const Problem *p, StepControl *control)
{
  PetscReal most[MAXIMA];
  PetscInt level = 0;
  PetscFunctionBeginUser;
  PetscCall(find_maxima(p, most));
  for (int i = 0; i < MAXIMA; i++)
    if (!(most[i] < PETSC_MAX_REAL)) PetscFunctionReturn(PETSC_SUCCESS); // the stage ends as diverged
  PetscCall(fill_sums(p, most, control));
  note_speeds(p, most[OF_MOVES], control);
  const PetscReal now = largest_ratio(p, most[OF_CHANGES], control) / PetscSqr(p->state->dt),
                  far = ContactsVary(p->contacts, p->stage) ? SEEN * most[OF_SPEED] : 0.;
  control->vibration = PetscMax(now, KEPT * control->vibration);
  for (PetscReal dt = control->longest; level < control->levels - 1; level++, dt *= 0.5)
    if (control->vibration * dt * dt <= 1. && far * dt <= p->m->contact_margin) break;
  control->wanted = PetscMax(control->wanted, level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

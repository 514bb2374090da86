/* step_control.c: chooses the step of a stage in time, a part of the stability bound, and reports it.

   With dt_factor: auto the step is at most 0.9 of the bound, and goes down a ladder of halves for as long as
   contacts that open and close (impact_step.c) or vibrations (vibration_step.c) need a shorter one.

   Condensed bodies and columns of free ground have velocities of their own, which do not change the step. In
   condensed bodies no vibration is quicker than their highest frequency, so 0.9 is right to 0.2 % there. A
   rigid body on its joints, blocks that fall on others, and joints that slide beside free ground vibrate
   within a few steps of the bound. There 0.1 of it leaves an error of some (omega dt)^2/6 of the energy of an
   impact, 1 %. */
#include "stages/stages.h"

static const PetscReal LONGEST = 0.9, CONSTANT = 0.1; /* dt_factor: auto; see above */
static const PetscReal STILL = 1e-6; /* [-] of the size of the model over the duration: slower bodies and
                                        contacts rest */
static const PetscReal SAMPLED =
    0.05; /* part of the bound that history_every and envelope_every count then */

/* Collective. Finds whether a rigid body moves freely. Where it hits others the bound is the bound of its
   joints, so its impacts are as quick as the step. Blocks that deform are stiffer than their joints are to
   the body as a whole. */
static PetscErrorCode any_rigid_moves(const Model *m, PetscBool *any)
{
  *any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3 * m->rigid.n; d++) *any = (PetscBool)(*any || !Held(m, d));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPIU_BOOL, MPI_LOR, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether some joint of the stage can slide or open. */
static PetscBool any_joint_fails(const Problem *p)
{
  for (PetscInt j = 0; j < p->scene->n_joints; j++)
    if (p->stage->joints[j].law != LAW_ELASTIC) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether the motion of free ground is found beside the model. */
static PetscBool free_ground(const Scene *scene)
{
  for (PetscInt i = 0; i < scene->n_supports; i++)
    if (scene->supports[i].boundary == BOUNDARY_FREE_FIELD) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns the name of a feature that has velocities of its own, and so keeps one step; NULL: none. */
static const char *constant_step_reason(const Problem *p)
{
  if (free_ground(p->scene)) return "free ground beside the model";
  return p->m->mesh.n_condensed_global ? "condensed bodies" : NULL;
}

PetscErrorCode StepControlFactor(const Problem *p, PetscReal *factor, PetscInt *levels)
{
  const Stage *stage = p->stage;
  PetscBool rigid;
  PetscFunctionBeginUser;
  *factor = stage->dt_factor, *levels = 1;
  if (!PetscIsNanReal(*factor)) PetscFunctionReturn(PETSC_SUCCESS);
  *factor = LONGEST, *levels = STEP_LEVELS;
  if (!constant_step_reason(p)) PetscFunctionReturn(PETSC_SUCCESS);
  *levels = 1;
  PetscCall(any_rigid_moves(p->m, &rigid));
  if (rigid || ContactsVary(p->contacts, stage) || (free_ground(p->scene) && any_joint_fails(p)))
    *factor = CONSTANT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal StepControlExpected(const Problem *p, PetscReal longest, PetscInt levels)
{
  return levels > 1 && any_joint_fails(p) ? ldexp(longest, (int)(levels - 1) / 2) : longest;
}

/* ---- the ladder */

PetscErrorCode StepControlBegin(const Problem *p, PetscReal dt, PetscInt levels, StepControl *control)
{
  const PetscReal duration = p->stage->duration, steps = PetscCeilReal(duration / dt * (1. - 1e-12));
  Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  control->levels = levels, control->level = control->next = control->wanted = levels - 1;
  control->longest = duration / steps;
  control->total = (PetscInt64)steps * StepControlTicks(control, 0);
  control->fastest = STILL * p->m->mesh.diameter / duration, control->speed2 = PetscSqr(control->fastest);
  PetscCall(VibrationStepBegin(p, control));
  PetscCall(PetscArrayzero(c->speed, 2 * c->n_padded)); // dashpots know no motion before the stage
  PetscCall(PetscArrayzero(c->speed_old, 2 * c->n_padded));
  p->state->dt = control->before[0] = control->before[1] = ldexp(control->longest, -(int)control->level);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the masses of bodies. Sums are of integers, so every rank finds the same ones. */
static PetscErrorCode body_masses(const Model *m, StepControl *control)
{
  enum { UNITS = 36 }; /* 2^36 units in the largest mass of a degree of freedom */
  const PetscInt at = 3 * m->rigid.n, n = m->mesh.n_bodies_global;
  PetscReal largest = 0.;
  PetscInt64 *sum; // of free masses; number of degrees of freedom that are held
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * n, &sum));
  for (PetscInt d = 0; d < m->n_dof; d++) largest = PetscMax(largest, DofMass(m, d));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt d = 0; d < m->n_dof && largest > 0.; d++) {
    PetscInt64 *of = sum + 2 * DofBody(m, d);
    const PetscInt along = d < at ? d % 3 : (d - at) % 2;
    if (Held(m, d))
      of[1]++;
    else if (!along)
      of[0] += (PetscInt64)ldexp(DofMass(m, d) / largest, UNITS);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2 * n, MPIU_INT64, MPI_SUM, m->comm));
  for (PetscInt b = 0; b < n; b++) {
    control->free_mass[b] = largest * ldexp((PetscReal)sum[2 * b], -UNITS);
    control->mass[b] = sum[2 * b + 1] ? PETSC_INFINITY : control->free_mass[b];
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Makes what the checks need, unless it is there. */
static PetscErrorCode create_tables(const Model *m, StepControl *control)
{
  PetscFunctionBeginUser;
  if (control->mass) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      PetscMalloc2(m->mesh.n_bodies_global, &control->mass, m->mesh.n_bodies_global, &control->free_mass));
  PetscCall(body_masses(m, control));
  PetscCall(ImpactStepCreate(m, control));
  PetscCall(VibrationStepCreate(m, control));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlDestroy(StepControl *control)
{
  PetscFunctionBeginUser;
  PetscCall(ImpactStepDestroy(control));
  PetscCall(VibrationStepDestroy(control));
  PetscCall(PetscFree2(control->mass, control->free_mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlCheck(const Problem *p, const EnergyAccount *e, StepControl *control)
{
  enum {
    EVERY = 4,
    BEHIND = 1
  }; /* steps between checks; step after a check in which contacts are found
                                     again */
  PetscFunctionBeginUser;
  if (control->levels == 1 || p->contacts->rate < 0. || p->result->cycles % EVERY != BEHIND)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(create_tables(p->m, control));
  PetscCall(ImpactStepCheck(p, e, control));
  PetscCall(VibrationStepCheck(p, control));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void StepControlAdvance(const Problem *p, StepControl *control)
{
  enum { CALM = 8 }; /* steps at a level before a longer one */
  const PetscReal dt = p->state->dt, *before = control->before,
                  apart = 0.5 * dt + before[0] +
                          0.5 *
                              before[1]; // distance between the middles of this step and of the step two ago
  p->contacts->lead = 0.5 * dt / apart;
  control->before[1] = before[0], control->before[0] = dt;
  control->done += StepControlTicks(control, control->level);
  control->stayed++;
  if (control->wanted > control->level)
    control->next = control->wanted;
  else if (control->wanted < control->level && control->stayed >= CALM &&
           control->done % StepControlTicks(control, control->level - 1) == 0)
    control->next = control->level - 1;
}

PetscErrorCode StepControlArchive(Archive *a, const Problem *p, StepControl *control)
{
  PetscFunctionBeginUser;
  PetscCall(ArchiveIntMembers(a, "rungs", INT_MEMBER(control->levels), INT_MEMBER(control->level),
                              INT_MEMBER(control->next), INT_MEMBER(control->wanted),
                              INT_MEMBER(control->swings)));
  PetscCall(ArchiveIntMembers(a, "steps", INT_MEMBER(control->total), INT_MEMBER(control->done),
                              INT_MEMBER(control->stayed), INT_MEMBER(control->changes)));
  PetscCall(ArchiveRealMembers(a, "longest_fastest_before", &control->longest, &control->fastest,
                               &control->before[0], &control->before[1]));
  PetscCall(ArchiveRealMembers(a, "speed2_vibration", &control->speed2, &control->vibration));
  if (control->levels == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(create_tables(p->m, control));
  PetscCall(ArchiveCounts(a, "met", p->m->mesh.n_bodies_global, control->met));
  PetscCall(ArchiveCounts(a, "loose", p->m->mesh.n_bodies_global, control->loose));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- reports of a run */

const char *StepControlRemedy(const Stage *stage)
{
  return PetscIsNanReal(stage->dt_factor) ? "give dt_factor a small number" : "lower dt_factor";
}

/* Warns where condensing does not pay. */
static PetscErrorCode warn_worth(const Problem *p, const TimeStep *step, const StepControl *control)
{
  static const PetscReal MORE = 1.1; // [-] ratio of costs above which condensing surely costs more
  const PetscReal steps = step->mesh / control->longest, cost = step->work * steps;
  PetscFunctionBeginUser;
  if (!(step->mesh > 0.))
    PetscFunctionReturn(PETSC_SUCCESS); // nothing is condensed, or the run was restarted
  PetscCall(
      PetscPrintf(p->m->comm,
                  "  condensed bodies: %.2g of the steps that their blocks would need, each some %.2g of the "
                  "work: %.2g of the time\n",
                  (double)steps, (double)step->work, (double)cost));
  if (cost > MORE)
    PetscCall(WarnAll(p->m->comm,
                      "stage %s: condensed bodies take some %.2g times as long as their blocks would: "
                      "leave condensed out, or lower highest_frequency",
                      p->stage->name, (double)cost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of longest steps between samples that are `every` steps apart by the scene. */
static PetscInt64 longest_between(const Stage *stage, PetscReal factor, PetscInt every)
{
  if (!every || !PetscIsNanReal(stage->dt_factor)) return every;
  return PetscMax(1, (PetscInt64)(0.5 + (PetscReal)every * SAMPLED / factor));
}

PetscErrorCode StepControlDescribe(const Problem *p, const TimeStep *step, StepControl *control)
{
  const PetscInt64 steps = control->total / StepControlTicks(control, 0);
  PetscReal factor;
  PetscInt levels;
  PetscFunctionBeginUser;
  PetscCall(MotionWarnings(p));
  PetscCall(StepControlFactor(p, &factor, &levels));
  control->rows_every = longest_between(p->stage, factor, p->scene->history_every);
  control->envelope_every = longest_between(p->stage, factor, p->stage->envelope_every);
  p->found->histories.every = (PetscReal)control->rows_every * control->longest;
  PetscCall(PetscPrintf(p->m->comm,
                        "stage %-12s %" PetscInt64_FMT " steps of %.4g s (%.3g of the stability bound",
                        p->stage->name, steps, (double)control->longest, (double)factor));
  if (factor * step->limit > step->dt)
    PetscCall(PetscPrintf(p->m->comm, ", %.3g s, less by dampers", (double)step->limit));
  PetscCall(PetscPrintf(p->m->comm, "%s%s)\n", step->words[0] ? "; set by " : "", step->words));
  if (PetscIsNanReal(p->stage->dt_factor)) {
    const char *what = constant_step_reason(p);
    if (what)
      PetscCall(PetscPrintf(p->m->comm, "  dt_factor auto keeps this step: there are %s\n", what));
    else
      PetscCall(PetscPrintf(
          p->m->comm, "  dt_factor auto: down to 1/%d of it where blocks hit each other, slide or vibrate\n",
          1 << (STEP_LEVELS - 1)));
  }
  PetscCall(warn_worth(p, step, control));
  if (!PetscIsNanReal(p->stage->damping_ratio))
    PetscCall(PetscPrintf(p->m->comm, "  damping %.3g at %.4g and %.4g Hz: alpha %.6g 1/s, beta %.6g s\n",
                          (double)p->stage->damping_ratio, (double)p->stage->damping_frequencies[0],
                          (double)p->stage->damping_frequencies[1], (double)p->stage->alpha,
                          (double)p->stage->beta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlReport(const Problem *p, const StepControl *control)
{
  const PetscReal longest = (PetscReal)control->done / (PetscReal)StepControlTicks(control, 0);
  PetscFunctionBeginUser;
  if (control->levels > 1)
    PetscCall(PetscPrintf(p->m->comm,
                          "stage %-12s the step has changed %" PetscInt64_FMT " times; %" PetscInt64_FMT
                          " steps for %.0f of the longest\n",
                          p->stage->name, control->changes, p->result->cycles,
                          (double)PetscCeilReal(longest)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

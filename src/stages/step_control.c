/* step_control.c: the step of a stage in time: which part of the stability bound it takes, and what a run
   says of it.

   Blocks that deform, with contacts that stay, form a system in which the bound is that of single vertices.
   The motion of bodies on their joints is many steps long then, so contacts that open, close and slide on the
   way need no smaller step: the cracked base of a dam is right to 0.3 % at 0.9 of the bound. A rigid body on
   its joints, and blocks that fall on others, meet within a few steps of the bound; there 0.1 of it leaves an
   error of some (omega dt)^2 / 6 of the energy of a blow, 1 %. */
#include "stages/stages.h"

static const PetscReal STAYING = 0.9, BLOWS = 0.1; /* dt_factor: auto */

/* Whether a rigid body moves freely: where it hits others the bound is that of its joints, so its blows are
   as quick as the step. Blocks that deform are stiffer than their joints are to the body as a whole. */
static PetscErrorCode any_rigid_moves(const Model *m, PetscBool *any)
{
  *any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3 * m->n_bodies; d++) *any = (PetscBool)(*any || !Held(m, d));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPIU_BOOL, MPI_LOR, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What has velocities of its own, and so keeps one step; NULL: nothing. */
static const char *keeps_step(const Problem *p)
{
  const char *what = p->m->n_condensed_global ? "condensed bodies" : NULL;
  for (PetscInt i = 0; i < p->scene->n_supports; i++)
    if (p->scene->supports[i].boundary == BOUNDARY_FREE_FIELD) what = "free ground beside the model";
  return what;
}

PetscErrorCode StepControlFactor(const Problem *p, PetscReal *factor, PetscInt *rungs)
{
  const Stage *stage = p->stage;
  const char *what = keeps_step(p);
  PetscBool rigid;
  PetscFunctionBeginUser;
  *factor = stage->dt_factor, *rungs = 1;
  if (!PetscIsNanReal(*factor)) PetscFunctionReturn(PETSC_SUCCESS);
  *factor = STAYING, *rungs = STEP_LEVELS;
  if (!what) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(any_rigid_moves(p->m, &rigid));
  *factor = rigid || stage->variable ? BLOWS : STAYING, *rungs = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the ladder */

PetscErrorCode StepControlBegin(const Problem *p, PetscReal dt, PetscInt rungs, StepControl *pace)
{
  const PetscReal duration = p->stage->duration, steps = PetscCeilReal(duration / dt * (1. - 1e-12));
  Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  pace->rungs = rungs, pace->rung = pace->next = pace->wanted = rungs - 1;
  pace->longest = duration / steps;
  pace->total = (PetscInt64)steps * StepControlTicks(pace, 0);
  PetscCall(PetscArrayzero(c->speed, 2 * c->n_padded)); // dashpots know no motion before the stage
  PetscCall(PetscArrayzero(c->speed_old, 2 * c->n_padded));
  p->state->dt = pace->before[0] = pace->before[1] = ldexp(pace->longest, -(int)pace->rung);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlCheck(const Problem *p, const EnergyAccount *e, StepControl *pace)
{
  enum { EVERY = 4, BEHIND = 1 }; /* steps; behind that in which contacts are found anew */
  PetscFunctionBeginUser;
  if (pace->rungs == 1 || p->contacts->rate < 0. || p->result->cycles % EVERY != BEHIND)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!pace->mass) PetscCall(ImpactStepCreate(p->m, pace));
  PetscCall(ImpactStepCheck(p, e, pace));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void StepControlAdvance(const Problem *p, StepControl *pace)
{
  enum { CALM = 8 }; /* steps before a longer one */
  const PetscReal dt = p->state->dt, *before = pace->before,
                  apart = 0.5 * dt + before[0] + 0.5 * before[1]; // the middles of this step and that two ago
  p->contacts->lead = 0.5 * dt / apart;
  pace->before[1] = before[0], pace->before[0] = dt;
  pace->done += StepControlTicks(pace, pace->rung);
  pace->stayed++;
  if (pace->wanted > pace->rung)
    pace->next = pace->wanted;
  else if (pace->wanted < pace->rung && pace->stayed >= CALM &&
           pace->done % StepControlTicks(pace, pace->rung - 1) == 0)
    pace->next = pace->rung - 1;
}

PetscErrorCode StepControlArchive(Archive *a, const Problem *p, StepControl *pace)
{
  PetscInt is[] = {pace->rungs, pace->rung, pace->next, pace->wanted, pace->swings};
  PetscInt64 counts[] = {pace->total, pace->done, pace->stayed, pace->changes};
  PetscReal reals[] = {pace->longest, pace->fastest, pace->before[0], pace->before[1]};
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "rungs", 5, is));
  PetscCall(ArchiveCounts(a, "steps", 4, counts));
  PetscCall(ArchiveReals(a, "longest_fastest_before", 4, reals));
  pace->rungs = is[0], pace->rung = is[1], pace->next = is[2], pace->wanted = is[3],
  pace->swings = (PetscBool)is[4];
  pace->total = counts[0], pace->done = counts[1], pace->stayed = counts[2], pace->changes = counts[3];
  pace->longest = reals[0], pace->fastest = reals[1];
  pace->before[0] = reals[2], pace->before[1] = reals[3];
  if (pace->rungs == 1) PetscFunctionReturn(PETSC_SUCCESS);
  if (!pace->mass) PetscCall(ImpactStepCreate(p->m, pace));
  PetscCall(ArchiveCounts(a, "met", p->m->n_bodies_global, pace->met));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a run says */

const char *StepControlRemedy(const Stage *stage)
{
  return PetscIsNanReal(stage->dt_factor) ? "give dt_factor a small number" : "lower dt_factor";
}

/* Whether condensing pays. */
static PetscErrorCode tell_worth(const Problem *p, const TimeStep *step, const StepControl *pace)
{
  static const PetscReal MORE = 1.1; // that it is surely
  const PetscReal steps = step->mesh / pace->longest, cost = step->work * steps;
  PetscFunctionBeginUser;
  if (!(step->mesh > 0.)) PetscFunctionReturn(PETSC_SUCCESS); // nothing is condensed, or after a restart
  PetscCall(
      PetscPrintf(p->m->comm,
                  "  condensed bodies: %.2g of the steps that their blocks would need, each some %.2g of the "
                  "work: %.2g of the time\n",
                  (double)steps, (double)step->work, (double)cost));
  if (cost > MORE)
    PetscCall(
        PetscPrintf(p->m->comm,
                    "warning: stage %s: condensed bodies take some %.2g times as long as their blocks would: "
                    "leave condensed out, or lower highest_frequency\n",
                    p->stage->name, (double)cost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlDescribe(const Problem *p, const TimeStep *step, const StepControl *pace)
{
  const PetscInt64 steps = pace->total / StepControlTicks(pace, 0);
  PetscReal factor;
  PetscInt rungs;
  PetscFunctionBeginUser;
  PetscCall(MotionWarnings(p));
  p->output->histories.every = (PetscReal)p->scene->history_every * pace->longest;
  PetscCall(StepControlFactor(p, &factor, &rungs));
  PetscCall(PetscPrintf(p->m->comm,
                        "stage %-12s %" PetscInt64_FMT " steps of %.4g s (%.3g of the stability bound",
                        p->stage->name, steps, (double)pace->longest, (double)factor));
  if (factor * step->limit > step->dt)
    PetscCall(PetscPrintf(p->m->comm, ", %.3g s, less by dampers", (double)step->limit));
  PetscCall(PetscPrintf(p->m->comm, "%s%s)\n", step->words[0] ? "; set by " : "", step->words));
  if (PetscIsNanReal(p->stage->dt_factor)) {
    const char *what = keeps_step(p);
    if (what)
      PetscCall(PetscPrintf(p->m->comm, "  dt_factor auto keeps this step: there are %s\n", what));
    else
      PetscCall(PetscPrintf(p->m->comm, "  dt_factor auto: down to 1/%d of it where blocks hit each other\n",
                            1 << (STEP_LEVELS - 1)));
  }
  PetscCall(tell_worth(p, step, pace));
  if (!PetscIsNanReal(p->stage->damping_ratio))
    PetscCall(PetscPrintf(p->m->comm, "  damping %.3g at %.4g and %.4g Hz: alpha %.6g 1/s, beta %.6g s\n",
                          (double)p->stage->damping_ratio, (double)p->stage->damping_frequencies[0],
                          (double)p->stage->damping_frequencies[1], (double)p->stage->alpha,
                          (double)p->stage->beta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StepControlReport(const Problem *p, const StepControl *pace)
{
  const PetscReal longest = (PetscReal)pace->done / (PetscReal)StepControlTicks(pace, 0);
  PetscFunctionBeginUser;
  if (pace->rungs > 1)
    PetscCall(PetscPrintf(p->m->comm,
                          "stage %-12s the step has changed %" PetscInt64_FMT " times; %" PetscInt64_FMT
                          " steps for %.0f of the longest\n",
                          p->stage->name, pace->changes, p->result->cycles, (double)PetscCeilReal(longest)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

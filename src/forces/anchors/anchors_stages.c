/* anchors_stages.c: anchors from stage to stage: stressed, locked, there from now on, broken. What an anchor
   carries changes hands without a jump: as it is locked, what the jack pulled with is no load any more; as
   it is stressed again, or breaks, what it carried becomes a load that the ramp takes to what follows. */
#include "forces/anchors/line.h"
#include "forces/blocks/blocks.h"

/* The force of a jack on an anchor that is stressed. */
static PetscReal jack_force(const Line *line)
{
  return line->of->prestress[line->now.stressings - 1];
}

/* Adds the tension T to the applied forces, and to those that a ramp starts from. f: room, a dof array with
   the vertex array behind it. */
static void apply(const Model *m, const State *state, const Line *line, PetscReal T, PetscReal *f)
{
  memset(f, 0, (3 * m->n_bodies + 2 * (m->n_vertices + DUMMY_VERTICES)) * sizeof *f);
  LinePull(line, -T, f + 3 * m->n_bodies);
  RigidForces(m, state->u, f);
  for (PetscInt d = 0; d < ModelApplied(m); d++) state->applied.start[d] += f[d], state->f_ext[d] += f[d];
}

/* Which of its stressings a stage is, -1: none. */
static PetscInt stressing_of(const Anchor *a, const Stage *stage)
{
  for (PetscInt i = 0; i < a->n_locks; i++)
    if (!strcmp(a->lock[i], stage->name)) return i;
  return -1;
}

static void begin_line(const TermView *v, Line *line, PetscReal *f)
{
  const Anchor *of = line->of;
  LineHistory *h = &line->now;
  const PetscInt stressing = stressing_of(of, v->stage);
  const PetscBool comes = (PetscBool)(!of->n_locks && (!of->from[0] || !strcmp(of->from, v->stage->name)));
  if (h->phase == LINE_STRESSED && stressing < h->stressings - 1) {
    const PetscReal T = jack_force(line);
    apply(v->m, v->state, line, -T, f);
    h->phase = LINE_HELD;
    h->natural = line->s - T / line->stiffness - h->plastic + of->draw_in;
    h->jack += T * (h->since - line->s);
    line->T = T - line->stiffness * of->draw_in;
  }
  if (stressing >= h->stressings && h->phase != LINE_BROKEN) {
    if (h->phase == LINE_HELD) apply(v->m, v->state, line, line->T, f);
    h->phase = LINE_STRESSED, h->stressings = stressing + 1, h->since = line->s;
    line->T = 0.;
  }
  if (h->phase == LINE_ABSENT && comes) h->phase = LINE_HELD, h->natural = line->s;
  line->held = *h;
}

PetscErrorCode AnchorsBegin(const TermView *v)
{
  const Model *m = v->m;
  Anchors *all = v->memory;
  PetscReal *f;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  all->in_time = (PetscBool)(v->stage->kind == STAGE_DYNAMIC);
  PetscCall(PetscMalloc1(3 * m->n_bodies + 2 * (m->n_vertices + DUMMY_VERTICES), &f));
  for (Line *line = all->line; line < all->line + all->n; line++) {
    if (!line->here) continue;
    LineEvaluate(line, m, v->state->u + 3 * m->n_bodies);
    begin_line(v, line, f);
  }
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsPull(const TermView *v, PetscBool *any, PetscReal *f)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; all && i < all->n; i++) {
    Line *line = all->line + i;
    // ranks agree, whether they know its vertices or not
    if (stressing_of(line->of, v->stage) >= 0) *any = PETSC_TRUE;
    if (!f || !line->here || line->now.phase != LINE_STRESSED) continue;
    LinePlace(line, v->m, v->state->u + 3 * v->m->n_bodies);
    LinePull(line, -jack_force(line), f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets an anchor break; its force becomes a load, which the ramp takes away. */
static void break_line(const TermView *v, Line *line, PetscReal *f)
{
  LineHistory *h = &line->now;
  apply(v->m, v->state, line, line->T, f);
  h->most = PetscMax(h->most, line->T);
  h->lost += LineStored(line);
  h->phase = LINE_BROKEN;
  line->held = *h, line->T = 0.;
}

PetscErrorCode AnchorsSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again)
{
  const Model *m = v->m;
  Anchors *all = v->memory;
  PetscReal *f, *T;
  PetscFunctionBeginUser;
  (void)result;
  if (!all || when != AT_EQUILIBRIUM) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(3 * m->n_bodies + 2 * (m->n_vertices + DUMMY_VERTICES), &f));
  PetscCall(PetscCalloc1(all->n, &T));
  for (PetscInt i = 0; i < all->n; i++) {
    Line *line = all->line + i;
    if (!line->here || !LineBreaks(line)) continue;
    T[i] = line->T;
    break_line(v, line, f);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, T, (PetscMPIInt)all->n, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < all->n; i++) {
    if (T[i] == 0.) continue;
    *again = PETSC_TRUE;
    PetscCall(PetscPrintf(m->comm, "stage %-12s anchor %s breaks at %.6g kN\n", v->stage->name,
                          all->line[i].of->entry.name, (double)(1e-3 * T[i])));
  }
  PetscCall(PetscFree(T));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* anchors_stages.c: stresses, locks, installs and breaks anchors from stage to stage. The force of an
   anchor is always balanced without a jump. When it is locked, the load of the jack ends. When it is
   stressed again or breaks, its force becomes a load, which the ramp changes to the new load. */
#include "anchors/line.h"
#include "blocks/blocks.h"

/* Adds the tension T [N] to the applied forces and to the forces from which a ramp starts. `all`: adds all
   forces of the anchor instead. f: work space, a dof array followed by the vertex array. */
static void apply(const Model *m, const State *state, const Line *line, PetscReal T, PetscBool all,
                  PetscReal *f)
{
  memset(f, 0, (3 * m->rigid.n + 2 * (m->mesh.n_vertices + DUMMY_VERTICES)) * sizeof *f);
  if (all)
    LineResist(line, -1., f + 3 * m->rigid.n);
  else
    LinePull(line, -T, f + 3 * m->rigid.n);
  RigidForces(m, state->u, f);
  for (PetscInt d = 0; d < ModelApplied(m); d++) state->applied.start[d] += f[d], state->f_ext[d] += f[d];
}

/* Returns which stressing of the anchor a stage is, -1: none. */
static PetscInt stressing_of(const Anchor *a, const Stage *stage)
{
  for (PetscInt i = 0; i < a->n_locks; i++)
    if (!strcmp(a->lock[i], stage->name)) return i;
  return -1;
}

/* Returns the force [N] of the jack in a stage, < 0: no jack. */
static PetscReal jack_of(const TermView *v, const Anchor *a)
{
  const PetscInt stressing = stressing_of(a, v->stage);
  if (AnchorIsPulled(v->stage, a)) return v->stage->pull * AnchorPrestress(v->scene, v->stage, a);
  return stressing < 0 ? -1. : a->prestress[stressing];
}

/* Locks the anchor with tension T [N], less the loss by the draw-in of its head. */
static void lock_at(Line *line, PetscReal T)
{
  LineHistory *h = &line->now;
  const PetscReal k = line->stiffness,
                  plastic = line->chain ? line->chain->memory[CHAIN_NOW].plastic[0] : h->plastic;
  h->natural = line->s - T / k - plastic + line->of->draw_in;
  line->T = T - k * line->of->draw_in;
  if (!line->chain) return;
  line->chain->memory[CHAIN_NOW].natural[0] = h->natural;
  line->chain->N[0] = line->T;
}

static void begin_line(const TermView *v, Line *line, PetscReal *f)
{
  const Anchor *of = line->of;
  LineHistory *h = &line->now;
  const PetscReal jack = jack_of(v, of);
  const PetscBool is_installed = (PetscBool)(!of->n_forces &&
                                             (!of->from[0] || !strcmp(of->from, v->stage->name)));
  if (h->phase == LINE_STRESSED) {
    h->jack += h->pulls * (h->since - line->s);
    h->since = line->s;
  }
  if (h->phase == LINE_STRESSED && jack < 0.) {
    const PetscReal T = h->pulls;
    apply(v->m, v->state, line, -T, PETSC_FALSE, f);
    h->phase = LINE_LOCKED;
    lock_at(line, T);
  }
  if (jack >= 0. && h->phase != LINE_BROKEN) {
    if (h->phase == LINE_LOCKED) apply(v->m, v->state, line, line->T, PETSC_FALSE, f);
    if (h->phase == LINE_ABSENT && line->chain) ChainComes(line->chain);
    h->phase = LINE_STRESSED, h->since = line->s, h->pulls = jack;
    line->T = 0.;
  }
  if (h->phase == LINE_ABSENT && is_installed) {
    if (line->chain) ChainComes(line->chain);
    h->phase = LINE_LOCKED, h->natural = line->s;
  }
  LineKeep(line, CHAIN_NOW, CHAIN_COMMITTED);
}

/* Collective. Warns of a jack on a broken anchor. Refuses it if the force of the anchor is the answer of
   the stage. */
static PetscErrorCode check_jacks(const TermView *v, const Anchors *all)
{
  char message[MESSAGE_LENGTH] = "", key[LABEL_LENGTH];
  PetscInt *broken;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(all->n, &broken));
  for (PetscInt i = 0; i < all->n; i++)
    broken[i] = all->line[i].mine && all->line[i].now.phase == LINE_BROKEN &&
                jack_of(v, all->line[i].of) >= 0.;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, broken, (PetscMPIInt)all->n, MPIU_INT, MPI_MAX, v->m->comm));
  snprintf(key, sizeof key, "stages.%s.anchors", v->stage->name);
  for (PetscInt i = 0; i < all->n; i++) {
    const char *name = all->line[i].of->entry.name;
    if (broken[i] && v->stage->kind == STAGE_ANCHOR_FORCE)
      Complain(message, v->scene->file, v->stage->line, key, "'%s' has broken before: no jack can pull it",
               name);
    else if (broken[i] && !v->m->rank)
      Warn("stage %s: anchor %s has broken before: it is not stressed again", v->stage->name, name);
  }
  PetscCall(PetscFree(broken));
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsBegin(const TermView *v)
{
  const Model *m = v->m;
  Anchors *all = v->memory;
  PetscReal *f;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  all->in_time = StageInTime(v->stage);
  PetscCall(check_jacks(v, all));
  PetscCall(PetscMalloc1(3 * m->rigid.n + 2 * (m->mesh.n_vertices + DUMMY_VERTICES), &f));
  for (Line *line = all->line; line < all->line + all->n; line++) {
    if (!line->here) continue;
    LineEvaluate(line, m, v->state->u + 3 * m->rigid.n);
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
    // all ranks decide alike, whether they know its vertices or not
    if (jack_of(v, line->of) >= 0.) *any = PETSC_TRUE;
    if (!f || !line->here || line->now.phase != LINE_STRESSED) continue;
    LinePlace(line, v->m, v->state->u + 3 * v->m->rigid.n);
    LinePull(line, -line->now.pulls, f);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Breaks an anchor. Its force becomes a load, which the ramp removes. */
static void break_line(const TermView *v, Line *line, PetscReal *f)
{
  LineHistory *h = &line->now;
  apply(v->m, v->state, line, line->T, PETSC_TRUE, f);
  h->most = PetscMax(h->most, LineLargest(line));
  h->lost += LineStored(line);
  h->phase = LINE_BROKEN;
  LineKeep(line, CHAIN_NOW, CHAIN_COMMITTED);
  line->T = 0.;
}

PetscErrorCode AnchorsSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again)
{
  const Model *m = v->m;
  Anchors *all = v->memory;
  PetscReal *f, *T;
  PetscFunctionBeginUser;
  (void)result;
  if (!all || when != AT_EQUILIBRIUM) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(3 * m->rigid.n + 2 * (m->mesh.n_vertices + DUMMY_VERTICES), &f));
  PetscCall(PetscCalloc1(all->n, &T));
  for (PetscInt i = 0; i < all->n; i++) {
    Line *line = all->line + i;
    if (!line->here || !LineBreaks(line)) continue;
    T[i] = LineLargest(line);
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

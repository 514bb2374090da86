/* pushover.c: runs a pushover: moves a point, a body, a group or the vertices on which loads act along a
   given path, from equilibrium to equilibrium, and stores the force at each equilibrium (push.c).

   The stage first comes to rest under its loads. The path is counted from there. Each leg of the path has
   equal increments of at most `step`. An increment is a relaxation, over whose ramp the displacement goes to
   its new value while the loads stay. The displacement is prescribed, so an equilibrium is found beyond the
   largest force too. An increment that finds no equilibrium within max_cycles counts as open, and the next
   one starts where it ended. Blocks that fall end the stage. */
#include "stages/stages.h"
#include "scene/reader.h"
#include <math.h>
#include <string.h>

enum { STEPS_OF_WAY = 100, MOST_INCREMENTS = 100000 };
static const PetscReal INERTIA = 0.01;  /* [-] of the forces, at most, in the ramp of an increment */
static const PetscReal MOST_RAMP = 0.5; /* [-] of max_cycles */

typedef struct {
  Problem p;
  Stage stage; /* copy of the stage, without a limit of displacements */
  Push *push;
  PetscInt least_ramp;     /* [cycles] of an increment */
  PetscInt n, begun, done; /* increments of the path; begun; ended */
  PetscInt open;           /* increments that ended without an equilibrium */
  PetscReal worst[2];      /* [-] largest unbalanced ratio of the open ones, and its displacement [m] */
  PetscInt frame;
  PetscInt64 first_cycle;
  double start; /* [s] of MPI_Wtime */
} Walk;

/* ---- the path */

/* Returns the length of the path [m], all legs together. */
static PetscReal way_of(const Stage *s)
{
  PetscReal way = 0.;
  for (PetscInt i = 0; i < s->n_path; i++) way += PetscAbsReal(s->path[i] - (i ? s->path[i - 1] : 0.));
  return way;
}

/* Returns the number of increments up to the end of leg `leg`, each leg from the displacement before to
   path[leg]. */
static PetscReal increments_to(const Stage *s, PetscInt leg)
{
  const PetscReal step = PetscIsNanReal(s->step) ? way_of(s) / STEPS_OF_WAY : s->step;
  PetscReal n = 0.;
  for (PetscInt i = 0; i <= leg; i++)
    n += PetscCeilReal(PetscAbsReal(s->path[i] - (i ? s->path[i - 1] : 0.)) / step * (1. - 1e-9));
  return n;
}

/* Returns the displacement at the end of increment k, from 1. */
static PetscReal place_at(const Stage *s, PetscInt k)
{
  PetscInt leg = 0;
  while (increments_to(s, leg) < (PetscReal)k) leg++;
  const PetscReal from = leg ? s->path[leg - 1] : 0., before = leg ? increments_to(s, leg - 1) : 0.,
                  n = increments_to(s, leg) - before, part = ((PetscReal)k - before) / n;
  return part < 1. ? from + (s->path[leg] - from) * part : s->path[leg];
}

/* ---- weights */

/* Sets f to the area at the vertices of a group, or with group NULL of all groups, times the direction. */
static PetscErrorCode area_of(const Model *m, const char *group, const PetscReal direction[2], PetscReal *f)
{
  Load load = {.n_groups = group ? 1 : 0};
  Model even = *m; // a copy of the model in which all groups have density 1
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->materials.n_groups, &even.materials.density));
  for (PetscInt g = 0; g < m->materials.n_groups; g++) even.materials.density[g] = 1.;
  PetscCall(PetscMalloc1(1, &load.groups));
  if (group) PetscCall(PetscStrncpy(load.groups[0], group, NAME_LENGTH));
  PetscCall(BodyForce(direction, &load, &even, f));
  PetscCall(PetscFree(load.groups));
  PetscCall(PetscFree(even.materials.density));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sets f to zero outside the body that has a vertex; v < 0: another rank owns this vertex. */
static PetscErrorCode keep_body(const Model *m, PetscInt v, PetscReal *f)
{
  PetscInt body = v >= 0 && v < m->mesh.n_owned ? m->mesh.vertex_body[v] : -1;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &body, 1, MPIU_INT, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++)
    if (m->mesh.vertex_body[i / 2] != body) f[i] = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sets f to the sum of the loads that push, direction to the direction of their resultant, and
   size to its magnitude [N]. */
static PetscErrorCode forces_of(const Problem *p, PetscReal *f, PetscReal direction[2], PetscReal *size)
{
  const TermView view = ViewOf(p);
  const PetscInt n = 2 * p->m->mesh.n_owned;
  PetscInt *slot;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < p->stage->n_rises; i++) PetscCall(TermApplied(&view, p->stage->rises[i], f));
  PetscCall(PetscMalloc1(n, &slot));
  for (PetscInt i = 0; i < n; i++) slot[i] = i % 2;
  PetscCall(BinnedSums(p->m->comm, n, slot, f, 2, direction));
  PetscCall(PetscFree(slot));
  *size = PetscHypotReal(direction[0], direction[1]);
  for (int k = 0; k < 2 && *size > 0.; k++) direction[k] /= *size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sets the weights from the keys of the stage: point, body, group or pushes. */
static PetscErrorCode choose(const Problem *p, PetscInt rows, Push *push)
{
  const Stage *s = p->stage;
  const Model *m = p->m;
  const PetscReal length = PetscHypotReal(s->direction[0], s->direction[1]);
  const char *const at = s->point[0] ? s->point : s->body, *const key = s->point[0]   ? "point"
                                                                        : s->body[0]  ? "body"
                                                                        : s->group[0] ? "group"
                                                                                      : "pushes";
  const PetscInt v = at[0] ? m->mesh.point_vertex[NameRow(m->mesh.n_points, m->mesh.point_names, at)] : -1;
  PetscReal direction[2] = {s->direction[0] / length, s->direction[1] / length}, size = 0., *f;
  char fault[MESSAGE_LENGTH] = "", message[MESSAGE_LENGTH] = "", label[LABEL_LENGTH];
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &f));
  if (s->n_rises)
    PetscCall(forces_of(p, f, direction, &size));
  else if (!s->point[0])
    PetscCall(area_of(m, s->group[0] ? s->group : NULL, direction, f));
  if (s->body[0]) PetscCall(keep_body(m, v, f));
  for (int k = 0; k < 2 && s->point[0] && v >= 0 && v < m->mesh.n_owned; k++) f[2 * v + k] = direction[k];
  PetscCall(PushBegin(p->scene, m, p->state, f, direction, rows, push, fault));
  push->load = size;
  PetscCall(PetscFree(f));
  PetscCall(PetscSNPrintf(label, sizeof(label), "stages.%s.%s", s->name, key));
  if (m->mesh.n_condensed_global)
    PetscCall(PetscSNPrintf(fault, MESSAGE_LENGTH, "condensed bodies cannot be pushed: leave condensed out"));
  if (s->n_rises && !(size > 0.))
    PetscCall(PetscSNPrintf(fault, MESSAGE_LENGTH, "these loads have no resultant"));
  if (fault[0]) Complain(message, p->scene->file, s->line, label, "%s", fault);
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushoverCheck(const Scene *scene, Model *m, Contacts *contacts, State *state)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_stages; i++) {
    const Problem p = {
        .scene = scene, .m = m, .contacts = contacts, .state = state, .stage = scene->stages + i};
    if (p.stage->kind != STAGE_PUSHOVER) continue;
    PetscCall(choose(&p, 1, PushOf(state)));
    PetscCall(PushEnd(PushOf(state)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- increments */

static PetscErrorCode archive_walk(Archive *a, void *context)
{
  Walk *w = context;
  Push *push = w->push;
  PetscReal *const kept[] = {&push->start, &push->force, &push->from,  &push->to,    &push->aim,  &push->ramp,
                             &push->work,  &push->mass,  &push->scale, &w->worst[0], &w->worst[1]};
  PetscReal wall = MPI_Wtime() - w->start;
  PetscFunctionBeginUser;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(kept); i++) {
    char name[16];
    PetscCall(PetscSNPrintf(name, sizeof(name), "real_%d", (int)i));
    PetscCall(ArchiveReals(a, name, 1, kept[i]));
  }
  PetscCall(ArchiveReals(a, "wall", 1, &wall));
  PetscCall(ArchiveIntMembers(a, "counts", INT_MEMBER(w->done), INT_MEMBER(w->open), INT_MEMBER(w->frame),
                              INT_MEMBER(w->first_cycle), INT_MEMBER(push->acts), INT_MEMBER(push->n_rows),
                              INT_MEMBER(w->stage.ramp), INT_MEMBER(w->begun)));
  w->start = MPI_Wtime() - wall;
  w->done = (PetscInt)ArchiveWithin(a, "done", w->done, -1, w->n);
  push->n_rows = (PetscInt)ArchiveWithin(a, "rows", push->n_rows, 0, w->n + 1);
  PetscCall(ArchiveReals(a, "rows", PUSH_COLUMNS * push->n_rows, push->rows));
  PetscCall(ArchiveEffort(a, &w->p.relax->effort));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the row of an increment that has ended, with an equilibrium or without, and prints it. */
static PetscErrorCode keep(Walk *w)
{
  const StageResult *r = w->p.result;
  Push *push = w->push;
  PetscReal *row = push->rows + PUSH_COLUMNS * push->n_rows++;
  const PetscBool rests = (PetscBool)(r->verdict == VERDICT_CONVERGED);
  PetscFunctionBeginUser;
  row[PUSH_MOVED] = push->acts ? push->aim : 0., row[PUSH_FORCE] = push->force;
  row[PUSH_RATIO] = r->ratio, row[PUSH_RESTS] = rests;
  if (!rests) {
    w->open++;
    if (r->ratio > w->worst[0]) w->worst[0] = r->ratio, w->worst[1] = row[PUSH_MOVED];
  }
  StageShowEnd(&w->p);
  PetscCall(PetscPrintf(w->p.m->comm,
                        "stage %-12s %.6g m: %.6g N%s after %" PetscInt64_FMT " cycle%s, %.2f s\n",
                        w->stage.name, (double)row[PUSH_MOVED], (double)row[PUSH_FORCE],
                        rests ? "" : ", no equilibrium", r->cycles, Plural(r->cycles), r->wall));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes frames at equal parts of the path, each after the increment that passes its place. */
static PetscErrorCode write_frames(Walk *w)
{
  const PetscInt due = PetscMin(w->stage.frames, w->done * (w->stage.frames + 1) / w->n);
  PetscFunctionBeginUser;
  if (w->done < 1 || w->done == w->n || w->frame >= due) PetscFunctionReturn(PETSC_SUCCESS);
  w->frame = due;
  PetscCall(OutputFrame(&w->p, w->frame));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the end of the next increment, and a ramp of so many cycles that inertia stays below the part INERTIA
   of the forces. The aim accelerates by at most 6 length / ramp^2, and the mass is the scaled one. */
static void aim(Walk *w)
{
  Push *push = w->push;
  const PetscReal force = INERTIA * PetscMax(push->scale, PetscAbsReal(push->force)),
                  before = w->done ? place_at(&w->stage, w->done) : 0.;
  push->to = place_at(&w->stage, ++w->begun);
  const PetscReal cycles = force > 0.
                               ? PetscSqrtReal(6. * PetscAbsReal(push->to - before) * push->mass / force)
                               : 0.;
  w->stage.ramp = (PetscInt)PetscMax(
      (PetscReal)w->least_ramp, PetscMin(PetscCeilReal(cycles), MOST_RAMP * (PetscReal)w->stage.max_cycles));
}

/* Runs the next increment. The first one moves nothing: it brings the stage to rest under its loads. */
static PetscErrorCode run_increment(Walk *w)
{
  StageResult *r = w->p.result;
  PetscFunctionBeginUser;
  if (w->begun == w->done) aim(w); // else a checkpoint has restored the aim
  PetscCall(StageRelax(&w->p));
  if (r->verdict != VERDICT_CONVERGED && (w->done < 0 || r->verdict != VERDICT_UNDECIDED))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(keep(w));
  if (++w->done == 0) PetscCall(PushFromHere(w->p.m, w->p.state, w->push));
  PetscCall(write_frames(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets verdict and evidence of the stage from its increments. */
static PetscErrorCode conclude(const Walk *w)
{
  const Push *push = w->push;
  StageResult *r = w->p.result;
  const PetscReal *last = push->rows + PUSH_COLUMNS * (push->n_rows - 1), *most = PushPeak(push);
  char why[sizeof(r->evidence)] = "", factor[80] = "";
  PetscFunctionBeginUser;
  r->cycles = w->p.state->cycle - w->first_cycle, r->wall = MPI_Wtime() - w->start;
  if (w->done < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (w->done < w->n) PetscCall(PetscSNPrintf(why, sizeof(why), "; %.300s", r->evidence));
  if (w->done == w->n && w->open) {
    r->verdict = VERDICT_UNDECIDED;
    PetscCall(PetscSNPrintf(why, sizeof(why),
                            "; increments without equilibrium: %" PetscInt_FMT
                            ", ratio up to %.3g at %.6g m; raise max_cycles to know more",
                            w->open, (double)w->worst[0], (double)w->worst[1]));
  }
  if (push->load > 0.)
    PetscCall(PetscSNPrintf(factor, sizeof(factor), "; largest factor %.6g, at the end %.6g",
                            (double)(most[PUSH_FORCE] / push->load),
                            (double)(last[PUSH_FORCE] / push->load)));
  PetscCall(PetscSNPrintf(r->evidence, sizeof(r->evidence),
                          "%" PetscInt_FMT " of %" PetscInt_FMT
                          " increments; largest force %.6g N at %.6g m; "
                          "at the end %.6g N at %.6g m%s%s",
                          w->done, w->n, (double)most[PUSH_FORCE], (double)most[PUSH_MOVED],
                          (double)last[PUSH_FORCE], (double)last[PUSH_MOVED], factor, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushoverRun(const Problem *p)
{
  Walk w = {.p = *p, .stage = *p->stage, .push = PushOf(p->state), .least_ramp = p->stage->ramp, .done = -1};
  PetscBool resumed, goes_on = PETSC_TRUE;
  PetscFunctionBeginUser;
  w.stage.displacement_limit = PETSC_INFINITY; // the path prescribes how far
  w.p.stage = &w.stage;
  w.n = (PetscInt)increments_to(&w.stage, w.stage.n_path - 1);
  w.first_cycle = p->state->cycle, w.start = MPI_Wtime();
  PetscCall(choose(&w.p, w.n + 1, w.push));
  PetscCall(CheckpointAttach(p->checkpoint, "pushover", archive_walk, &w, &resumed));
  while (goes_on && w.done < w.n) {
    const PetscInt before = w.done;
    StageResult between = {.verdict = VERDICT_NONE};
    PetscCall(run_increment(&w));
    goes_on = (PetscBool)(w.done > before);
    if (!goes_on || w.done == w.n) continue;
    PetscCall(CheckpointPoll(p->checkpoint, p->state->cycle, &between));
    goes_on = (PetscBool)(between.verdict == VERDICT_NONE);
    if (!goes_on) *p->result = between;
  }
  PetscCall(CheckpointDetach(p->checkpoint));
  PetscCall(conclude(&w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

/* Refuses a load that is no dead load, or acts already. */
static void check_pushing(Reader *r, const Stage *stage, PetscInt row)
{
  const Load *load = r->scene->loads + row;
  const PetscBool dead = (PetscBool)(load->kind == LOAD_SELF_WEIGHT || load->kind == LOAD_TRACTION ||
                                     load->kind == LOAD_POINT_FORCE || load->kind == LOAD_ICE ||
                                     load->kind == LOAD_CREST_LOAD || load->kind == LOAD_PSEUDO_STATIC);
  if (!dead || load->history[0])
    COMPLAIN(r, "'%s' %s: expected self_weight, pseudo_static, traction, point_force, ice or crest_load",
             load->name, dead ? "changes with time" : "is no dead load");
  for (PetscInt i = 0; i < stage->n_loads; i++)
    if (stage->loads[i] == row)
      COMPLAIN(r, "'%s' is one of loads too: expected it in one of the two", load->name);
}

PetscErrorCode CompletePushover(Reader *r, const char *path, Stage *stage)
{
  static const char *const keys[] = {"group", "body", "point", "pushes"};
  const PetscReal *d = stage->direction;
  PetscBool given[4], any = PETSC_FALSE;
  PetscInt n = 0;

  PetscFunctionBeginUser;
  for (int i = 0; i < 4; i++) {
    PetscCall(IsGiven(r, path, keys[i], given + i));
    n += given[i];
    if (n > 1 && given[i]) COMPLAIN(r, "expected exactly one of point, body, group, pushes");
  }
  if (given[3] && !stage->n_rises) COMPLAIN(r, "the list is empty");
  for (PetscInt i = 0; i < stage->n_rises; i++)
    if (stage->rises[i] >= 0) check_pushing(r, stage, stage->rises[i]);
  if (!n) {
    PetscCall(IsGiven(r, path, "point", &any));
    COMPLAIN_MISSING(r, "missing: what is moved, one of point, body, group, pushes");
  }
  PetscCall(IsGiven(r, path, "direction", &any));
  if (any && given[3]) COMPLAIN(r, "loads push along their resultant: leave it out");
  if (d[0] == 0. && d[1] == 0.) COMPLAIN(r, "it has no length");
  PetscCall(IsGiven(r, path, "path", &any));
  if (any && !(way_of(stage) > 0.)) COMPLAIN(r, "it moves nothing: all displacements are 0");
  PetscCall(IsGiven(r, path, "step", &any));
  if (stage->n_path && way_of(stage) > 0. && increments_to(stage, stage->n_path - 1) > MOST_INCREMENTS)
    COMPLAIN(r, "%g [m] makes %.3g increments: expected at most %d", (double)stage->step,
             (double)increments_to(stage, stage->n_path - 1), MOST_INCREMENTS);
  PetscCall(IsGiven(r, path, "ramp", &any));
  if (!stage->ramp) COMPLAIN(r, "0 cycles: a displacement that jumps shakes the blocks: expected >= 1");
  PetscFunctionReturn(PETSC_SUCCESS);
}

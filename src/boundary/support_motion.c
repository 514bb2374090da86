/* support_motion.c: prescribes the motion of supports in dynamic stages, as a force term. Its memory is
   the motion of each support of the scene. */
#include "boundary/boundary.h"

typedef struct {
  Motion motion;
  PetscReal now[3]; /* [m/s] in this step along x and y; 0 about the centre */
} SupportMotion;

typedef struct {
  PetscInt n;        /* supports of the scene */
  SupportMotion *of; /* (n,) */
  PetscInt n_held;
  PetscInt *held; /* (n_moved,) degrees of freedom held by moving supports in the stage */
} Motions;

static PetscErrorCode create(const TermView *v, void **memory)
{
  const Scene *scene = v->scene;
  char message[MESSAGE_LENGTH] = "";
  Motions *motions;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&motions));
  PetscCall(PetscCalloc1(scene->n_supports, &motions->of));
  motions->n = scene->n_supports;
  *memory = motions;
  for (PetscInt i = 0; i < motions->n; i++) {
    const Support *s = scene->supports + i;
    Motion *motion = &motions->of[i].motion;
    PetscCall(MotionCreate(s, motion));
    if (!MotionIsFinite(motion) && !message[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: supports.%s.motion: %s: moves too far for a number", scene->file, s->name,
                              s->motion));
  }
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  Motions *motions = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  for (PetscInt i = 0; motions && i < motions->n; i++) PetscCall(MotionDestroy(&motions->of[i].motion));
  if (motions) PetscCall(PetscFree(motions->of));
  if (motions) PetscCall(PetscFree(motions->held));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the support moves along k, or lets waves in that do. */
static PetscBool moves(const Support *s, int k)
{
  return (PetscBool)(s->along[k] && (s->fix[k] || s->boundary != BOUNDARY_FIXED));
}

/* Decides whether support i is the first that moves along k by its motion, so that the motion is reported
   once. */
static PetscBool is_reported(const Scene *scene, PetscInt i, int k)
{
  PetscBool first = moves(scene->supports + i, k);
  for (const Support *s = scene->supports; first && s < scene->supports + i; s++)
    if (moves(s, k) && s->along[k] == scene->supports[i].along[k]) first = PETSC_FALSE;
  return first;
}

/* Warns of a record that ends with a velocity before the stage ends: the ground then stops at once, which
   is an impact. This happens to accelerograms without baseline correction. */
static PetscErrorCode warn_of_end(const TermView *v, const Support *s, const GroundMotion *m,
                                  const char *name, const MotionFacts *facts)
{
  const PetscBool accelerations = (PetscBool)(m->quantity == MOTION_ACCELERATION);
  const PetscReal negligible = 0.01, suspicious = 0.05; // of the largest velocity; [m/s]
  const PetscReal last = PetscAbsReal(facts->end[1]);
  PetscFunctionBeginUser;
  if (!(last > negligible * facts->largest[1])) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WarnAll(
      v->m->comm,
      "%s: %s ends at %.6g s with %.3g m/s: the %s stops there at once; end it at rest%s, or let it "
      "go on "
      "past the stage%s",
      name, m->file, (double)facts->t_end, (double)last, s->boundary == BOUNDARY_FIXED ? "support" : "wave",
      accelerations ? " (baseline: linear of a motion does)" : "",
      accelerations && last > suspicious ? "; if the file gives velocities, say quantity: velocity" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of motions far beyond the strongest records, about 4 m/s and 40 m/s2. They have another unit, or a
   time step in milliseconds read as seconds; slips and openings would be wrong by powers of ten. */
static PetscErrorCode warn_of_size(const TermView *v, const GroundMotion *m, const char *name,
                                   const MotionFacts *facts)
{
  const PetscReal fastest = 8., strongest = 80.; // [m/s], [m/s2]
  PetscFunctionBeginUser;
  if (facts->largest[1] <= fastest && facts->largest[2] <= strongest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WarnAll(v->m->comm,
                    "%s: %s gives %.4g m/s2 and %.4g m/s over %.6g s; expected at most 80 m/s2 "
                    "and 8 m/s of a shaken ground: look at its unit, quantity and time step",
                    name, m->file, (double)facts->largest[2], (double)facts->largest[1],
                    (double)facts->t_end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the largest values and the end of a motion. */
static PetscErrorCode report_motion(const TermView *v, const Support *s, int k, const MotionTrack *track)
{
  const GroundMotion *m = s->along[k];
  const PetscBool named = (PetscBool)(m != &s->own);
  const PetscReal t = v->state->time, t_end = t + v->stage->duration, rounding = 1e-9 * t_end;
  const MotionFacts facts = MotionSample(track);
  const char axis = k ? 'y' : 'x';
  char name[2 * NAME_LENGTH];
  PetscFunctionBeginUser;
  if (facts.t_end < t - rounding || facts.largest[1] == 0.) PetscFunctionReturn(PETSC_SUCCESS); // at rest
  PetscCall(PetscSNPrintf(name, sizeof(name), named ? "motions.%s" : "supports.%s.motion",
                          named ? m->entry.name : s->name));
  PetscCall(PetscPrintf(
      v->m->comm,
      "%s along %c: %s: to %.6g s, largest %.4g m/s2 and %.4g m/s; it ends with %.3g m/s, moved by "
      "%.3g m\n",
      name, axis, m->file, (double)facts.t_end, (double)facts.largest[2], (double)facts.largest[1],
      (double)facts.end[1], (double)facts.end[0]));
  PetscCall(warn_of_size(v, m, name, &facts));
  if (facts.t_end <= t_end - rounding) PetscCall(warn_of_end(v, s, m, name, &facts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode begin(const TermView *view)
{
  const Motions *motions = view->memory;
  PetscFunctionBeginUser;
  if (!StageInTime(view->stage)) PetscFunctionReturn(PETSC_SUCCESS); // supports do not move
  for (PetscInt i = 0; i < motions->n; i++)
    for (int k = 0; k < 2; k++)
      if (is_reported(view->scene, i, k))
        PetscCall(report_motion(view, view->scene->supports + i, k, motions->of[i].motion.along + k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the motion of each support and its end. */
static void summary(Json *json, const TermView *v)
{
  const Motions *motions = v->memory;
  char name[NAME_LENGTH + 2];
  if (!StageInTime(v->stage)) return;
  JsonOpenLater(json, "motion");
  for (PetscInt i = 0; i < motions->n; i++) {
    const Support *s = v->scene->supports + i;
    for (int k = 0; k < 2; k++) {
      if (!moves(s, k)) continue;
      const MotionFacts facts = MotionSample(motions->of[i].motion.along + k);
      snprintf(name, sizeof(name), "%s_%c", s->name, k ? 'y' : 'x');
      JsonObject(json, name, {"largest_acceleration", facts.largest[2]},
                 {"largest_velocity", facts.largest[1]}, {"largest_displacement", facts.largest[0]},
                 {"end_time", facts.t_end}, {"end_velocity", facts.end[1]},
                 {"end_displacement", facts.end[0]});
    }
  }
  JsonClose(json);
}

/* Lists the degrees of freedom that moving supports hold. Supports add no inertia, but a dynamic stage
   calls this function where it starts and after a restart. */
static PetscErrorCode inertia(const TermView *v, TermInertia add, void *context)
{
  Motions *motions = v->memory;
  const Model *m = v->m;
  PetscFunctionBeginUser;
  (void)add, (void)context;
  PetscCall(PetscFree(motions->held));
  PetscCall(PetscMalloc1(m->n_dof, &motions->held));
  motions->n_held = 0;
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (SupportRow(m, d) >= 0 && MotionMoves(&motions->of[m->support[d]].motion))
      motions->held[motions->n_held++] = d;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves the held degrees of freedom over a step. Their velocity carries the support from its place at the
   start of the step to that at its end. So displacements follow the record whatever the step, and a step
   may contain several rows. */
static void advance(void *memory, const Model *m, State *s)
{
  Motions *motions = memory;
  if (!motions->n_held) return;
  for (PetscInt i = 0; i < motions->n; i++) {
    SupportMotion *of = motions->of + i;
    for (int k = 0; k < 2; k++) of->now[k] = MotionMean(&of->motion, s->time, s->time + s->dt, s->dt, k);
  }
  for (const PetscInt *d = motions->held; d < motions->held + motions->n_held; d++) {
    const PetscInt at = 3 * m->rigid.n;
    const PetscReal v = motions->of[m->support[*d]].now[*d < at ? *d % 3 : (*d - at) % 2];
    s->u[*d] += (v - s->v[*d]) * s->dt; // the step has already moved it by its own v
    s->v[*d] = v;
  }
}

const TermKind Supports_term = {.name = "supports",
                                .create = create,
                                .destroy = destroy,
                                .begin = begin,
                                .inertia = inertia,
                                .advance = advance,
                                .summary = summary};

/* support_motion.c: supports that move in time, as a force term: they prescribe the motion of what they hold.
   Its memory: the motion of each support of the scene. */
#include "forces/boundary/boundary.h"

typedef struct {
  Motion motion;
  PetscReal now[3]; /* [m/s] in this step, along x and y; none about the centre */
} SupportMotion;

typedef struct {
  PetscInt n;        /* supports of the scene */
  SupportMotion *of; /* (n,) */
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
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The file of a support may end in motion before the stage does: then the support stops at once there, which
   is a blow. An accelerogram without base line correction does so. t_end: of the stage. */
static PetscBool ends_in_motion(const MotionTrack *track, PetscReal t, PetscReal t_end, PetscReal *v)
{
  const PetscReal rounding = 1e-9 * t_end, negligible = 0.01; // of the largest velocity
  const PetscReal last = track->n ? track->t[track->n - 1] : PETSC_INFINITY;
  PetscReal most = 0.;
  if (last < t - rounding || last > t_end - rounding) return PETSC_FALSE;
  for (PetscInt i = 0; i < track->n; i++) most = PetscMax(most, PetscAbsReal(track->row[4 * i + 1]));
  *v = PetscAbsReal(track->row[4 * (track->n - 1) + 1]);
  return (PetscBool)(*v > negligible * most);
}

static PetscErrorCode begin(const TermView *view)
{
  const Motions *motions = view->memory;
  const PetscReal t = view->state->time;
  PetscFunctionBeginUser;
  if (view->stage->kind != STAGE_DYNAMIC) PetscFunctionReturn(PETSC_SUCCESS); // supports rest
  for (PetscInt i = 0; i < motions->n; i++) {
    const Support *s = view->scene->supports + i;
    for (int k = 0; k < 2; k++) {
      const MotionTrack *track = motions->of[i].motion.along + k;
      PetscReal v;
      if (!s->fix[k] || !ends_in_motion(track, t, t + view->stage->duration, &v)) continue;
      PetscCall(PetscPrintf(view->m->comm,
                            "warning: supports.%s.motion: %s ends at %.6g s with %.3g m/s: the support stops "
                            "there at once; end it at rest, or let it go on past the stage\n",
                            s->name, s->motion, (double)track->t[track->n - 1], (double)v));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The velocity of a step is what carries the support from its place at the start of the step to that at its
   end: displacements are those of the file whatever the step, and a step may hold several rows. */
static void advance(void *memory, const Model *m, State *s)
{
  Motions *motions = memory;
  for (PetscInt i = 0; i < motions->n; i++) {
    SupportMotion *of = motions->of + i;
    for (int k = 0; k < 2; k++)
      of->now[k] = (MotionPlace(&of->motion, s->time + s->dt, k) - MotionPlace(&of->motion, s->time, k)) /
                   s->dt;
  }
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const SupportMotion *of = m->support[d] < 0 ? NULL : motions->of + m->support[d];
    if (!of || !MotionMoves(&of->motion)) continue;
    const PetscReal v = of->now[d < 3 * m->n_bodies ? d % 3 : (d - 3 * m->n_bodies) % 2];
    s->u[d] += (v - s->v[d]) * s->dt; // integrate.c has moved it by its own v
    s->v[d] = v;
  }
}

const TermKind Supports_term = {
    .name = "supports", .create = create, .destroy = destroy, .begin = begin, .advance = advance};

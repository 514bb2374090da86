/* support_motion.c: supports that move in time, as a force term: they prescribe the motion of what they hold.
   Its memory: the motion of each support of the scene. */
#include "forces/boundary/boundary.h"

typedef struct {
  PetscInt n;         /* rows of the file; 0: the support does not move */
  const PetscReal *t; /* (n,) [s]; the scene's */
  PetscReal
      *row; /* (n,2,4) along x, y: displacement [m] at a row and, just behind it, its three derivatives */
  PetscReal now[3]; /* [m/s] in this step, along x and y; none about the centre */
} SupportMotion;

typedef struct {
  PetscInt n;        /* supports of the scene */
  SupportMotion *of; /* (n,) */
} Motions;

/* Displacement [m], or of order 1 velocity [m/s], h [s] behind a row. */
static PetscReal behind_row(const PetscReal p[4], int order, PetscReal h)
{
  if (order) return p[1] + h * (p[2] + h * 0.5 * p[3]);
  return p[0] + h * (p[1] + h * (0.5 * p[2] + h / 6. * p[3]));
}

/* Between rows what the file gives is linear, so displacement is a polynomial of the second degree (velocity)
   or the third (acceleration): its coefficients from row to row, along k. */
static void integrate_rows(const Support *s, SupportMotion *motion, int k)
{
  PetscReal u = 0., v = 0.;
  for (PetscInt i = 0; i < motion->n; i++) {
    PetscReal *p = motion->row + 8 * i + 4 * k;
    const PetscReal x = s->xy[2 * i + k];
    const PetscReal h = i + 1 < motion->n ? motion->t[i + 1] - motion->t[i] : 0.;
    const PetscReal slope = h > 0. ? (s->xy[2 * i + 2 + k] - x) / h : 0.;
    if (s->quantity == MOTION_VELOCITY)
      p[0] = u, p[1] = x, p[2] = slope, p[3] = 0.;
    else
      p[0] = u, p[1] = v, p[2] = x, p[3] = slope;
    u = behind_row(p, 0, h), v = behind_row(p, 1, h);
  }
}

/* Numbers that are finite may still add up to more than there are numbers. */
static PetscBool is_finite(const SupportMotion *motion)
{
  for (PetscInt i = 0; i < 8 * motion->n; i++)
    if (!isfinite(motion->row[i])) return PETSC_FALSE;
  return PETSC_TRUE;
}

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
    SupportMotion *motion = motions->of + i;
    motion->n = s->n_rows, motion->t = s->t;
    PetscCall(PetscMalloc1(8 * s->n_rows, &motion->row));
    for (int k = 0; k < 2; k++) integrate_rows(s, motion, k);
    if (!is_finite(motion) && !message[0])
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
  for (PetscInt i = 0; motions && i < motions->n; i++) PetscCall(PetscFree(motions->of[i].row));
  if (motions) PetscCall(PetscFree(motions->of));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The file of a support may end in motion before the stage does: then the support stops at once there, which
   is a blow. An accelerogram without base line correction does so. */
static PetscErrorCode begin(const TermView *view)
{
  const Scene *scene = view->scene;
  const Motions *motions = view->memory;
  const PetscReal t = view->state->time, t_end = t + view->stage->duration;
  const PetscReal rounding = 1e-9 * t_end, negligible = 0.01; // of the largest velocity
  PetscFunctionBeginUser;
  if (view->stage->kind != STAGE_DYNAMIC) PetscFunctionReturn(PETSC_SUCCESS); // supports rest
  for (PetscInt i = 0; i < motions->n; i++) {
    const SupportMotion *motion = motions->of + i;
    PetscReal most = 0., last = 0.;
    if (!motion->n || motion->t[motion->n - 1] < t - rounding || motion->t[motion->n - 1] > t_end - rounding)
      continue;
    for (PetscInt j = 0; j < motion->n; j++)
      for (int k = 0; k < 2; k++) {
        if (!scene->supports[i].fix[k]) continue;
        const PetscReal v = PetscAbsReal(motion->row[8 * j + 4 * k + 1]);
        if (j == motion->n - 1) last = PetscMax(last, v);
        most = PetscMax(most, v);
      }
    if (last > negligible * most)
      PetscCall(PetscPrintf(view->m->comm,
                            "warning: supports.%s.motion: %s ends at %.6g s with %.3g m/s: the support stops "
                            "there at once; end it at rest, or let it go on past the stage\n",
                            scene->supports[i].name, scene->supports[i].motion,
                            (double)motion->t[motion->n - 1], (double)last));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Displacement [m] at time t since the start of the file; at rest before the first row and after the last. */
static PetscReal motion_at(const SupportMotion *motion, PetscReal t, int k)
{
  PetscInt low = 0, high = motion->n - 1;
  if (t <= motion->t[0]) return 0.;
  if (t >= motion->t[high]) return motion->row[8 * high + 4 * k];
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;
    if (motion->t[middle] <= t)
      low = middle;
    else
      high = middle;
  }
  return behind_row(motion->row + 8 * low + 4 * k, 0, t - motion->t[low]);
}

/* The velocity of a step is what carries the support from its place at the start of the step to that at its
   end: displacements are those of the file whatever the step, and a step may hold several rows. */
static void advance(void *memory, const Model *m, State *s)
{
  Motions *motions = memory;
  for (PetscInt i = 0; i < motions->n; i++) {
    SupportMotion *motion = motions->of + i;
    for (int k = 0; k < 2 && motion->n; k++)
      motion->now[k] = (motion_at(motion, s->time + s->dt, k) - motion_at(motion, s->time, k)) / s->dt;
  }
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const SupportMotion *motion = m->support[d] < 0 ? NULL : motions->of + m->support[d];
    if (!motion || !motion->n) continue;
    const PetscReal v = motion->now[d < 3 * m->n_bodies ? d % 3 : (d - 3 * m->n_bodies) % 2];
    s->u[d] += (v - s->v[d]) * s->dt; // integrate.c has moved it by its own v
    s->v[d] = v;
  }
}

const TermKind Supports_term = {
    .name = "supports", .create = create, .destroy = destroy, .begin = begin, .advance = advance};

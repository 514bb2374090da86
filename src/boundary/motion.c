/* motion.c: integrates the records of ground motion exactly. Records are linear between rows, so
   displacement is a polynomial of degree 2 (velocity records) or 3 (acceleration records). */
#include "boundary/boundary.h"

/* Returns the displacement [m], or for order 1 the velocity [m/s], h [s] after a row. */
static PetscReal behind_row(const PetscReal p[4], int order, PetscReal h)
{
  if (order) return p[1] + h * (p[2] + h * 0.5 * p[3]);
  return p[0] + h * (p[1] + h * (0.5 * p[2] + h / 6. * p[3]));
}

/* Computes the coefficients from row to row. x: column of the record. */
static void integrate_rows(const Record *record, PetscInt x, MotionQuantity quantity, MotionTrack *track)
{
  PetscReal u = 0., v = 0.;
  for (PetscInt i = 0; i < track->n; i++) {
    PetscReal *p = track->row + 4 * i;
    const PetscReal here = record->x[record->width * i + x];
    const PetscReal h = i + 1 < track->n ? track->t[i + 1] - track->t[i] : 0.;
    const PetscReal slope = h > 0. ? (record->x[record->width * (i + 1) + x] - here) / h : 0.;
    if (quantity == MOTION_VELOCITY)
      p[0] = u, p[1] = here, p[2] = slope, p[3] = 0.;
    else
      p[0] = u, p[1] = v, p[2] = here, p[3] = slope;
    u = behind_row(p, 0, h), v = behind_row(p, 1, h);
  }
}

PetscErrorCode MotionCreate(const Support *s, Motion *motion)
{
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    MotionTrack *track = motion->along + k;
    const GroundMotion *m = s->along[k];
    *track = (MotionTrack){.n = m ? m->record.n : 0, .t = m ? m->record.t : NULL};
    PetscCall(PetscMalloc1(4 * track->n, &track->row));
    if (m) integrate_rows(&m->record, m->record.width == 2 ? k : 0, m->quantity, track);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MotionDestroy(Motion *motion)
{
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) PetscCall(PetscFree(motion->along[k].row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MotionMoves(const Motion *motion)
{
  return (PetscBool)(motion->along[0].n || motion->along[1].n);
}

PetscBool MotionIsFinite(const Motion *motion)
{
  for (int k = 0; k < 2; k++)
    for (PetscInt i = 0; i < 4 * motion->along[k].n; i++)
      if (!isfinite(motion->along[k].row[i])) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns the last row at or before time t, which is no earlier than the first row. */
static PetscInt row_before(const MotionTrack *track, PetscReal t)
{
  PetscInt low = 0, high = track->n - 1;
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;
    if (track->t[middle] <= t)
      low = middle;
    else
      high = middle;
  }
  return low;
}

PetscReal MotionPlace(const Motion *motion, PetscReal t, int k)
{
  const MotionTrack *track = motion->along + k;
  const PetscInt last = track->n - 1;
  if (!track->n || t <= track->t[0]) return 0.;
  if (t >= track->t[last]) return track->row[4 * last];
  const PetscInt i = row_before(track, t);
  return behind_row(track->row + 4 * i, 0, t - track->t[i]);
}

PetscReal MotionMean(const Motion *motion, PetscReal from, PetscReal to, PetscReal dt, int k)
{
  return (MotionPlace(motion, to, k) - MotionPlace(motion, from, k)) / dt;
}

PetscReal MotionVelocity(const Motion *motion, PetscReal t, int k)
{
  const MotionTrack *track = motion->along + k;
  if (!track->n || t < track->t[0] || t >= track->t[track->n - 1]) return 0.;
  const PetscInt i = row_before(track, t);
  return behind_row(track->row + 4 * i, 1, t - track->t[i]);
}

/* Updates the largest values between a row and the next, h [s] later. Velocity may be largest where
   acceleration passes zero between rows; displacement is checked at rows only. */
static void update_largest(const PetscReal p[4], PetscReal h, PetscReal largest[3])
{
  const PetscReal at = p[3] != 0. ? -p[2] / p[3] : 0.;
  largest[0] = PetscMax(largest[0], PetscAbsReal(p[0]));
  largest[1] = PetscMax(largest[1], PetscMax(PetscAbsReal(p[1]), PetscAbsReal(behind_row(p, 1, h))));
  if (at > 0. && at < h) largest[1] = PetscMax(largest[1], PetscAbsReal(behind_row(p, 1, at)));
  largest[2] = PetscMax(largest[2], PetscAbsReal(p[2]));
}

MotionFacts MotionSample(const MotionTrack *track)
{
  MotionFacts facts = {{0., 0., 0.}, {0., 0.}, 0.};
  if (!track->n) return facts;
  for (PetscInt i = 0; i < track->n; i++)
    update_largest(track->row + 4 * i, i + 1 < track->n ? track->t[i + 1] - track->t[i] : 0., facts.largest);
  for (int d = 0; d < 2; d++) facts.end[d] = track->row[4 * (track->n - 1) + d];
  facts.t_end = track->t[track->n - 1];
  return facts;
}

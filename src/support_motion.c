/* support_motion.c: supports that move in time by a file of velocities or accelerations. */
#include "stages.h"

/* 1: a row; 0: the end; -1: neither. */
static int read_row(FILE *file, double row[3])
{
  char *line = NULL;
  size_t size = 0;
  int status = 0;
  while (!status && getline(&line, &size, file) >= 0) {
    if (line[0] == '#' || line[strspn(line, " \t\r\n")] == 0) continue;
    const int n = sscanf(line, " %lf , %lf , %lf", row, row + 1, row + 2);
    status = n == 3 && isfinite(row[0]) && isfinite(row[1]) && isfinite(row[2]) ? 1 : -1;
  }
  free(line);
  return status;
}

/* Reads t, x, y rows on rank 0; an acceleration is integrated by the trapezoidal rule. */
static PetscErrorCode motion_read(const Scene *scene, const Support *s, MPI_Comm comm, SupportMotion *motion)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank;
  double row[3];
  PetscInt capacity = 0;
  int status = 1;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  motion->n = 0, motion->t = motion->v = NULL;
  FILE *file = rank ? NULL : fopen(s->motion, "r");
  if (!rank && !file)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: supports.%s.motion: %s: no such file", scene->file,
                            s->name, s->motion));
  while (file && (status = read_row(file, row)) > 0) {
    if (motion->n && row[0] <= motion->t[motion->n - 1]) status = -1;
    if (status < 0) break;
    if (motion->n == capacity) {
      capacity = capacity ? 2 * capacity : 64;
      PetscCall(PetscRealloc(capacity * sizeof(PetscReal), &motion->t));
      PetscCall(PetscRealloc(2 * capacity * sizeof(PetscReal), &motion->v));
    }
    motion->t[motion->n] = row[0], motion->v[2 * motion->n] = row[1], motion->v[2 * motion->n + 1] = row[2];
    motion->n++;
  }
  if (file) fclose(file);
  if (!rank && !message[0] && (status < 0 || motion->n < 2))
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: supports.%s.motion: %s: row %" PetscInt_FMT
                            ": expected t, x, y, numbers with t ascending, in two rows or more",
                            scene->file, s->name, s->motion, motion->n + 1));
  PetscCall(CheckMessage(comm, message));
  PetscCallMPI(MPI_Bcast(&motion->n, 1, MPIU_INT, 0, comm));
  if (rank) {
    PetscCall(PetscMalloc1(motion->n, &motion->t));
    PetscCall(PetscMalloc1(2 * motion->n, &motion->v));
  }
  PetscCallMPI(MPI_Bcast(motion->t, motion->n, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(motion->v, 2 * motion->n, MPIU_REAL, 0, comm));
  if (s->quantity == MOTION_ACCELERATION) {
    PetscReal before[2] = {motion->v[0], motion->v[1]};
    motion->v[0] = motion->v[1] = 0.;
    for (PetscInt i = 1; i < motion->n; i++)
      for (int k = 0; k < 2; k++) {
        const PetscReal a = motion->v[2 * i + k];
        motion->v[2 * i + k] = motion->v[2 * i - 2 + k] +
                               0.5 * (a + before[k]) * (motion->t[i] - motion->t[i - 1]);
        before[k] = a;
      }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportMotionsRead(const Scene *scene, MPI_Comm comm, SupportMotion **motions)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->n_supports, motions));
  for (PetscInt i = 0; i < scene->n_supports; i++)
    if (scene->supports[i].motion[0]) PetscCall(motion_read(scene, scene->supports + i, comm, *motions + i));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportMotionsDestroy(const Scene *scene, SupportMotion **motions)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    PetscCall(PetscFree((*motions)[i].t));
    PetscCall(PetscFree((*motions)[i].v));
  }
  PetscCall(PetscFree(*motions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportMotionsWarn(const Problem *p, const SupportMotion *motions)
{
  const Scene *scene = p->scene;
  const PetscReal t = p->state->time, t_end = t + p->stage->duration;
  const PetscReal rounding = 1e-9 * t_end, negligible = 0.01; // of the largest velocity
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    const SupportMotion *motion = motions + i;
    PetscReal most = 0., last = 0.;
    if (!motion->n || motion->t[motion->n - 1] < t - rounding || motion->t[motion->n - 1] > t_end - rounding)
      continue;
    for (PetscInt j = 0; j < motion->n; j++)
      for (int k = 0; k < 2; k++) {
        if (!scene->supports[i].fix[k]) continue;
        if (j == motion->n - 1) last = PetscMax(last, PetscAbsReal(motion->v[2 * j + k]));
        most = PetscMax(most, PetscAbsReal(motion->v[2 * j + k]));
      }
    if (last > negligible * most)
      PetscCall(PetscPrintf(p->m->comm,
                            "warning: supports.%s.motion: %s ends at %.6g s with %.3g m/s: the support stops "
                            "there at once; end it at rest, or let it go on past the stage\n",
                            scene->supports[i].name, scene->supports[i].motion,
                            (double)motion->t[motion->n - 1], (double)last));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Velocity at time t: linear between rows, at rest before the first and after the last. */
static PetscReal motion_at(const SupportMotion *motion, PetscReal t, int k)
{
  PetscInt low = 0, high = motion->n - 1;
  if (t < motion->t[0] || t > motion->t[high]) return 0.;
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;
    if (motion->t[middle] <= t)
      low = middle;
    else
      high = middle;
  }
  const PetscReal w = (t - motion->t[low]) / (motion->t[high] - motion->t[low]);
  return (1. - w) * motion->v[2 * low + k] + w * motion->v[2 * high + k];
}

void SupportsMove(const Scene *scene, const Model *m, SupportMotion *motions, State *s)
{
  const PetscReal t = s->time + 0.5 * s->dt;
  for (PetscInt i = 0; i < scene->n_supports; i++)
    for (int k = 0; k < 2 && motions[i].n; k++) motions[i].now[k] = motion_at(motions + i, t, k);
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscInt support = m->support[d];
    if (support < 0 || !motions[support].n) continue;
    const PetscInt axis = d < 3 * m->n_bodies ? d % 3 : (d - 3 * m->n_bodies) % 2;
    s->u[d] += (motions[support].now[axis] - s->v[d]) * s->dt; // integrate.c has moved it by its own v
    s->v[d] = motions[support].now[axis];
  }
}

/* support_motion.c: supports that move in time by a file of velocities or accelerations. */
#include "forces/boundary/boundary.h"
#include <ctype.h>

/* 1: a row; 0: the end; -1: neither. may_name: a line of names ("t, x, y") may come before the first row. The
   mark that spreadsheets put before UTF-8 is passed over. */
static int read_row(FILE *file, PetscInt64 *n_lines, PetscBool *may_name, double row[3])
{
  char *line = NULL;
  size_t size = 0;
  int status = 0;
  while (!status && getline(&line, &size, file) >= 0) {
    const char *text = line + (!(*n_lines)++ && !strncmp(line, "\xEF\xBB\xBF", 3) ? 3 : 0);
    int behind = 0;
    text += strspn(text, " \t\r\n");
    if (!*text || *text == '#') continue;
    const PetscBool names = (PetscBool)(*may_name && (isalpha((unsigned char)*text) || *text == '"'));
    *may_name = PETSC_FALSE;
    if (names && sscanf(text, "%lf", row) != 1) continue;
    const int n = sscanf(text, "%lf , %lf , %lf %n", row, row + 1, row + 2, &behind);
    const PetscBool whole = (PetscBool)(n == 3 && (!text[behind] || text[behind] == '#'));
    status = whole && isfinite(row[0]) && isfinite(row[1]) && isfinite(row[2]) ? 1 : -1;
  }
  free(line);
  return status;
}

/* Whether a row at time t may follow the first n: later, or at the time of the last one, once, which makes a
   step. */
static PetscBool may_follow(PetscInt n, const PetscReal *t, PetscReal next)
{
  if (!n || next > t[n - 1]) return PETSC_TRUE;
  return (PetscBool)(next == t[n - 1] && (n == 1 || t[n - 1] > t[n - 2]));
}

/* Rank 0. Rows t and x, y of the file; the last are at a later time than the first. */
static PetscErrorCode read_rows(const Scene *scene, const Support *s, SupportMotion *motion,
                                PetscReal **given, char message[MESSAGE_LENGTH])
{
  double row[3];
  PetscInt capacity = 0;
  PetscInt64 n_lines = 0;
  PetscBool may_name = PETSC_TRUE;
  int status;
  FILE *file = fopen(s->motion, "r");
  PetscFunctionBeginUser;
  if (!file) {
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: supports.%s.motion: %s: no such file", scene->file,
                            s->name, s->motion));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  while ((status = read_row(file, &n_lines, &may_name, row)) > 0) {
    if (!may_follow(motion->n, motion->t, row[0])) status = -1;
    if (status < 0) break;
    if (motion->n == capacity) {
      capacity = capacity ? 2 * capacity : 64;
      PetscCall(PetscRealloc(capacity * sizeof(PetscReal), &motion->t));
      PetscCall(PetscRealloc(2 * capacity * sizeof(PetscReal), given));
    }
    motion->t[motion->n] = row[0];
    (*given)[2 * motion->n] = row[1], (*given)[2 * motion->n + 1] = row[2];
    motion->n++;
  }
  fclose(file);
  if (status < 0 || motion->n < 2 || motion->t[motion->n - 1] <= motion->t[0])
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: supports.%s.motion: %s: line %" PetscInt64_FMT
                            ": expected t, x, y, numbers in two rows or "
                            "more, t ascending, or twice the same for a step",
                            scene->file, s->name, s->motion, n_lines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Displacement [m], or of order 1 velocity [m/s], h [s] behind a row. */
static PetscReal behind_row(const PetscReal p[4], int order, PetscReal h)
{
  if (order) return p[1] + h * (p[2] + h * 0.5 * p[3]);
  return p[0] + h * (p[1] + h * (0.5 * p[2] + h / 6. * p[3]));
}

/* Between rows what the file gives is linear, so displacement is a polynomial of the second degree (velocity)
   or the third (acceleration): its coefficients from row to row, along k. */
static void integrate_rows(SupportMotion *motion, MotionQuantity quantity, const PetscReal *given, int k)
{
  PetscReal u = 0., v = 0.;
  for (PetscInt i = 0; i < motion->n; i++) {
    PetscReal *p = motion->row + 8 * i + 4 * k;
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a file without rows has been refused
    const PetscReal x = given[2 * i + k];
    const PetscReal h = i + 1 < motion->n ? motion->t[i + 1] - motion->t[i] : 0.;
    const PetscReal slope = h > 0. ? (given[2 * i + 2 + k] - x) / h : 0.;
    if (quantity == MOTION_VELOCITY)
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

static PetscErrorCode motion_read(const Scene *scene, const Support *s, MPI_Comm comm, SupportMotion *motion)
{
  char message[MESSAGE_LENGTH] = "";
  PetscReal *given = NULL; // (n,2) x, y of the file
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  motion->n = 0, motion->t = motion->row = NULL;
  if (!rank) PetscCall(read_rows(scene, s, motion, &given, message));
  if (message[0]) PetscCall(PetscFree(given));
  PetscCall(CheckMessage(comm, message));
  PetscCallMPI(MPI_Bcast(&motion->n, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(motion->n, &motion->t));
  if (rank) PetscCall(PetscMalloc1(2 * motion->n, &given));
  PetscCallMPI(MPI_Bcast(motion->t, motion->n, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(given, 2 * motion->n, MPIU_REAL, 0, comm));
  PetscCall(PetscMalloc1(8 * motion->n, &motion->row));
  for (int k = 0; k < 2; k++) integrate_rows(motion, s->quantity, given, k);
  PetscCall(PetscFree(given));
  if (!is_finite(motion))
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: supports.%s.motion: %s: moves too far for a number",
                            scene->file, s->name, s->motion));
  PetscCall(CheckMessage(comm, message));
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
    PetscCall(PetscFree((*motions)[i].row));
  }
  PetscCall(PetscFree(*motions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportMotionsWarn(const Scene *scene, const Stage *stage, MPI_Comm comm, PetscReal t,
                                  const SupportMotion *motions)
{
  const PetscReal t_end = t + stage->duration;
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
        const PetscReal v = PetscAbsReal(motion->row[8 * j + 4 * k + 1]);
        if (j == motion->n - 1) last = PetscMax(last, v);
        most = PetscMax(most, v);
      }
    if (last > negligible * most)
      PetscCall(PetscPrintf(comm,
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
void SupportsMove(const Scene *scene, const Model *m, SupportMotion *motions, State *s)
{
  for (PetscInt i = 0; i < scene->n_supports; i++)
    for (int k = 0; k < 2 && motions[i].n; k++)
      motions[i].now[k] = (motion_at(motions + i, s->time + s->dt, k) - motion_at(motions + i, s->time, k)) /
                          s->dt;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscInt support = m->support[d];
    if (support < 0 || !motions[support].n) continue;
    const PetscInt axis = d < 3 * m->n_bodies ? d % 3 : (d - 3 * m->n_bodies) % 2;
    s->u[d] += (motions[support].now[axis] - s->v[d]) * s->dt; // integrate.c has moved it by its own v
    s->v[d] = motions[support].now[axis];
  }
}

/* motion_file.c: reads files of motions, of levels of water and of temperatures on rank 0, and scales and
   corrects them there, so that all ranks have the same bits. */
#include "scene/record.h"
#include <inttypes.h>
#include <sys/stat.h>

/* ---- baseline */

/* Finds the final velocity and displacement of accelerations, linear between rows, from rest. */
static void end_of(PetscInt n, const PetscReal *t, const PetscReal *a, PetscInt stride, PetscReal end[2])
{
  end[0] = end[1] = 0.;
  for (PetscInt i = 1; i < n; i++) {
    const PetscReal h = t[i] - t[i - 1], a0 = a[(i - 1) * stride], a1 = a[i * stride];
    end[1] += h * (end[0] + h * (2. * a0 + a1) / 6.);
    end[0] += h * (a0 + a1) / 2.;
  }
}

/* Subtracts sin^2(pi s) (c1 + c2 s) from each component, s = 0..1 over the record, so that it ends at rest
   where it began. PETSC_FALSE: it has too few rows. */
static PetscErrorCode correct_baseline(Record *r, PetscBool *corrected)
{
  PetscReal *shape[2], end[3][2];
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(r->n, shape, r->n, shape + 1));
  for (PetscInt i = 0; i < r->n; i++) {
    const PetscReal s = (r->t[i] - r->t[0]) / (r->t[r->n - 1] - r->t[0]), sine = PetscSinReal(PETSC_PI * s);
    shape[0][i] = sine * sine, shape[1][i] = s * sine * sine;
  }
  for (int j = 0; j < 2; j++) end_of(r->n, r->t, shape[j], 1, end[j]);
  const PetscReal both[2] = {end[0][0] * end[1][1], end[1][0] * end[0][1]}, determinant = both[0] - both[1];
  *corrected = (PetscBool)(PetscAbsReal(determinant) >
                           1e-9 * (PetscAbsReal(both[0]) + PetscAbsReal(both[1])));
  for (PetscInt k = 0; k < r->width && *corrected; k++) {
    end_of(r->n, r->t, r->x + k, r->width, end[2]);
    const PetscReal c1 = (end[2][0] * end[1][1] - end[1][0] * end[2][1]) / determinant,
                    c2 = (end[0][0] * end[2][1] - end[2][0] * end[0][1]) / determinant;
    for (PetscInt i = 0; i < r->n; i++) r->x[r->width * i + k] -= c1 * shape[0][i] + c2 * shape[1][i];
  }
  PetscCall(PetscFree2(shape[0], shape[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one motion */

/* Corrects the baseline, and scales both components by one factor. fault: description of a fault. */
static PetscErrorCode correct(GroundMotion *m, const char **fault)
{
  Record *r = &m->record;
  PetscReal peak = 0., scale = m->scale;
  PetscBool corrected = PETSC_TRUE;
  PetscFunctionBeginUser;
  if (m->baseline == BASELINE_LINEAR) PetscCall(correct_baseline(r, &corrected));
  if (!corrected) *fault = "baseline: linear: expected at least two times between the first and the last";
  for (PetscInt i = 0; i < r->n * r->width; i++) peak = PetscMax(peak, PetscAbsReal(r->x[i]));
  if (m->pga > 0. && peak == 0.) *fault = "pga: every acceleration is 0: none to scale";
  if (m->pga > 0. && peak > 0.) scale = m->pga / peak;
  if (scale != 1.)
    for (PetscInt i = 0; i < r->n * r->width; i++) r->x[i] *= scale;
  for (PetscInt i = 0; i < r->n * r->width; i++)
    if (!isfinite(r->x[i])) *fault = "too large for a number";
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MotionIsChanged(const GroundMotion *m)
{
  return (PetscBool)(m->scale != 1. || m->pga > 0. || m->baseline != BASELINE_NONE);
}

/* Rank 0. Reads a motion, corrects and scales it. */
static PetscErrorCode read_motion(GroundMotion *m, PetscBool named, char message[MESSAGE_LENGTH])
{
  static const RecordShape shape = {2, 3, "t, x, y, or t and one component", PETSC_FALSE},
                           unnamed = {2, 3, "t, x, y", PETSC_FALSE};
  MotionQuantity quantity = m->quantity;
  const char *fault = NULL;
  PetscFunctionBeginUser;
  PetscCall(RecordRead(m->file, named ? &shape : &unnamed, &m->record, &quantity, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (m->record.width == 1 && !named)
    fault = "it has one component: name it in motions, with its direction, and have the support follow that";
  else if (m->record.width == 1 && m->direction == MOTION_ALONG_XY)
    fault = "it has one component: expected direction: x or y";
  else if (m->record.width == 2 && m->direction != MOTION_ALONG_XY)
    fault = "it has both components: expected no direction";
  else if (quantity != m->quantity)
    fault = quantity == MOTION_VELOCITY ? "it gives velocities: expected quantity: velocity"
                                        : "it gives accelerations: expected quantity: acceleration";
  else
    PetscCall(correct(m, &fault));
  if (fault) PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s", fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all ranks */

/* Rank 0. Puts the place of a fault before its description. */
static PetscErrorCode place_fault(const Scene *scene, const char *key, const char *path,
                                  char message[MESSAGE_LENGTH])
{
  char fault[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  if (!message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(fault, message, MESSAGE_LENGTH));
  PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: %s: %s: %s", scene->file, key, path, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Sends the record of rank 0 to all ranks. */
static PetscErrorCode share(MPI_Comm comm, Record *r, char message[MESSAGE_LENGTH])
{
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCall(CheckMessage(comm, message));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(&r->n, 1, MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(&r->width, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(r->n, &r->t));
  if (rank) PetscCall(PetscMalloc1(r->width * r->n, &r->x));
  PetscCallMPI(MPI_Bcast(r->t, r->n, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(r->x, r->width * r->n, MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Shares a motion. key: of the scene; named: the motion has a name there. */
static PetscErrorCode share_motion(MPI_Comm comm, const Scene *scene, const char *key, PetscBool named,
                                   GroundMotion *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) PetscCall(read_motion(m, named, message));
  if (!rank) PetscCall(place_fault(scene, key, m->file, message));
  PetscCall(share(comm, &m->record, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneReadMotions(MPI_Comm comm, Scene *scene)
{
  char key[LABEL_LENGTH];
  PetscFunctionBeginUser;
  for (GroundMotion *m = scene->motions; m < scene->motions + scene->n_motions; m++) {
    PetscCall(PetscSNPrintf(key, sizeof(key), "motions.%s.file", m->entry.name));
    PetscCall(share_motion(comm, scene, key, PETSC_TRUE, m));
  }
  for (Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!s->own.file[0]) continue;
    PetscCall(PetscSNPrintf(key, sizeof(key), "supports.%s.motion", s->name));
    PetscCall(share_motion(comm, scene, key, PETSC_FALSE, &s->own));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MotionsDestroy(Scene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; scene->motions && i < scene->n_motions; i++)
    PetscCall(RecordDestroy(&scene->motions[i].record));
  for (PetscInt i = 0; scene->supports && i < scene->n_supports; i++)
    PetscCall(RecordDestroy(&scene->supports[i].own.record));
  PetscCall(PetscFree(scene->motions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Reads and shares the file of a key of a load. */
static PetscErrorCode read_load_file(MPI_Comm comm, const Scene *scene, const Load *load, const char *key,
                                     const char *path, const RecordShape *shape, Record *record)
{
  char label[LABEL_LENGTH], message[MESSAGE_LENGTH] = "";
  MotionQuantity none;
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscSNPrintf(label, sizeof(label), "loads.%s.%s", load->name, key));
  if (!rank) PetscCall(RecordRead(path, shape, record, &none, message));
  if (!rank) PetscCall(place_fault(scene, label, path, message));
  if (message[0]) PetscCall(RecordDestroy(record));
  PetscCall(share(comm, record, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneReadLevels(MPI_Comm comm, Scene *scene)
{
  static const RecordShape levels = {2, 2, "t, level", PETSC_FALSE},
                           factors = {2, 2, "t, factor", PETSC_FALSE},
                           points = {3, 3, "x, y, change", PETSC_TRUE};
  PetscFunctionBeginUser;
  for (Load *l = scene->loads; l < scene->loads + scene->n_loads; l++) {
    Record record = {0};
    if (l->levels[0] || l->history[0]) {
      PetscCall(l->levels[0] ? read_load_file(comm, scene, l, "levels", l->levels, &levels, &record)
                             : read_load_file(comm, scene, l, "history", l->history, &factors, &record));
      l->n_levels = record.n, l->t = record.t, l->levels_at = record.x;
    }
    if (l->heat.points[0]) {
      PetscCall(read_load_file(comm, scene, l, "points", l->heat.points, &points, &record));
      l->heat.n_points = record.n, l->heat.x = record.t, l->heat.at = record.x;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal LoadSeries(const Load *load, PetscReal t)
{
  PetscInt i = 0;
  while (i < load->n_levels && load->t[i] <= t) i++;
  if (!i) return load->levels_at[0];
  if (i == load->n_levels) return load->levels_at[i - 1];
  const PetscReal part = (t - load->t[i - 1]) / (load->t[i] - load->t[i - 1]);
  return load->levels_at[i - 1] + part * (load->levels_at[i] - load->levels_at[i - 1]);
}

/* Writes a line with the checksum of the file of a key. */
static void note_file(FILE *f, const char *section, const char *name, const char *key, const char *path)
{
  struct stat file = {0};
  uint64_t sum;
  if (!path[0] || stat(path, &file) || !S_ISREG(file.st_mode)) return;
  if (FileChecksum(path, (size_t)file.st_size, &sum)) return; // the reader of the file reports the reason
  fprintf(f, "%s_%s_%s_checksum %08" PRIx64 "\n", section, name, key, sum);
}

/* Adds a line with the checksum of each file of motion, levels or temperatures to the options, so that a
   restart detects a changed file. */
PetscErrorCode SceneNoteFiles(Scene *scene)
{
  char *text = NULL;
  size_t size;

  PetscFunctionBeginUser;
  FILE *f = open_memstream(&text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  fputs(scene->options, f);
  for (const GroundMotion *m = scene->motions; m < scene->motions + scene->n_motions; m++)
    note_file(f, "motions", m->entry.name, "file", m->file);
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++)
    note_file(f, "supports", s->name, "motion", s->own.file);
  for (const Load *l = scene->loads; l < scene->loads + scene->n_loads; l++)
    note_file(f, "loads", l->name, "levels", l->levels),
        note_file(f, "loads", l->name, "history", l->history),
        note_file(f, "loads", l->name, "points", l->heat.points);
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  free(scene->options);
  scene->options = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

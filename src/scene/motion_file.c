/* motion_file.c: files of support motion: CSV rows of t, x, y. */
#include "scene/scene.h"
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

/* Rank 0. Rows of the file; the last is at a later time than the first. */
static PetscErrorCode read_rows(const Scene *scene, Support *s, char message[MESSAGE_LENGTH])
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
    if (!may_follow(s->n_rows, s->t, row[0])) status = -1;
    if (status < 0) break;
    if (s->n_rows == capacity) {
      capacity = capacity ? 2 * capacity : 64;
      PetscCall(PetscRealloc(capacity * sizeof(PetscReal), &s->t));
      PetscCall(PetscRealloc(2 * capacity * sizeof(PetscReal), &s->xy));
    }
    s->t[s->n_rows] = row[0];
    s->xy[2 * s->n_rows] = row[1], s->xy[2 * s->n_rows + 1] = row[2];
    s->n_rows++;
  }
  fclose(file);
  if (status < 0 || s->n_rows < 2 || s->t[s->n_rows - 1] <= s->t[0])
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: supports.%s.motion: %s: line %" PetscInt64_FMT
                            ": expected t, x, y, numbers in two rows or "
                            "more, t ascending, or twice the same for a step",
                            scene->file, s->name, s->motion, n_lines));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneReadMotions(MPI_Comm comm, Scene *scene)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!s->motion[0]) continue;
    if (!rank) PetscCall(read_rows(scene, s, message));
    PetscCall(CheckMessage(comm, message));
    PetscCallMPI(MPI_Bcast(&s->n_rows, 1, MPIU_INT, 0, comm));
    if (rank) PetscCall(PetscMalloc1(s->n_rows, &s->t));
    if (rank) PetscCall(PetscMalloc1(2 * s->n_rows, &s->xy));
    PetscCallMPI(MPI_Bcast(s->t, s->n_rows, MPIU_REAL, 0, comm));
    PetscCallMPI(MPI_Bcast(s->xy, 2 * s->n_rows, MPIU_REAL, 0, comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* motion_file.c: CSV files of numbers in time: support motion (t, x, y) and levels of water (t, level). */
#include "scene/scene.h"
#include <ctype.h>
#include <inttypes.h>
#include <sys/stat.h>

/* 1: a row of `width` numbers; 0: the end; -1: neither. may_name: a line of names ("t, x, y") may come before
   the first row. The mark that spreadsheets put before UTF-8 is passed over. */
static int read_row(FILE *file, PetscInt64 *n_lines, PetscBool *may_name, int width, double row[3])
{
  char *line = NULL;
  size_t size = 0;
  int status = 0;
  row[2] = 0.;
  while (!status && getline(&line, &size, file) >= 0) {
    const char *text = line + (!(*n_lines)++ && !strncmp(line, "\xEF\xBB\xBF", 3) ? 3 : 0);
    int behind = 0;
    text += strspn(text, " \t\r\n");
    if (!*text || *text == '#') continue;
    const PetscBool names = (PetscBool)(*may_name && (isalpha((unsigned char)*text) || *text == '"'));
    *may_name = PETSC_FALSE;
    if (names && sscanf(text, "%lf", row) != 1) continue;
    const int n = width == 3 ? sscanf(text, "%lf , %lf , %lf %n", row, row + 1, row + 2, &behind)
                             : sscanf(text, "%lf , %lf %n", row, row + 1, &behind);
    const PetscBool whole = (PetscBool)(n == width && (!text[behind] || text[behind] == '#'));
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

/* Rank 0. Rows of a file: times, and width - 1 numbers each; the last is at a later time than the first. key:
   of the scene, for messages; names: of the columns. */
static PetscErrorCode read_rows(const Scene *scene, const char *key, const char *path, const char *names,
                                int width, PetscInt *n, PetscReal **t, PetscReal **values,
                                char message[MESSAGE_LENGTH])
{
  double row[3];
  PetscInt capacity = 0;
  PetscInt64 n_lines = 0;
  PetscBool may_name = PETSC_TRUE;
  int status;
  FILE *file = fopen(path, "r");
  PetscFunctionBeginUser;
  if (!file) {
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: %s: %s: no such file", scene->file, key, path));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  while ((status = read_row(file, &n_lines, &may_name, width, row)) > 0) {
    if (!may_follow(*n, *t, row[0])) status = -1;
    if (status < 0) break;
    if (*n == capacity) {
      capacity = capacity ? 2 * capacity : 64;
      PetscCall(PetscRealloc(capacity * sizeof(PetscReal), t));
      PetscCall(PetscRealloc((width - 1) * capacity * sizeof(PetscReal), values));
    }
    (*t)[*n] = row[0];
    for (int k = 1; k < width; k++) (*values)[(width - 1) * *n + k - 1] = row[k];
    ++*n;
  }
  fclose(file);
  if (status < 0 || *n < 2 || (*t)[*n - 1] <= (*t)[0])
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: %s: %s: line %" PetscInt64_FMT ": expected %s, numbers in two rows or "
                            "more, t ascending, or twice the same for a step",
                            scene->file, key, path, n_lines, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. read_rows on rank 0, and what it has read on all ranks. */
static PetscErrorCode share_rows(MPI_Comm comm, const Scene *scene, const char *key, const char *path,
                                 const char *names, int width, PetscInt *n, PetscReal **t, PetscReal **values)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (!rank) PetscCall(read_rows(scene, key, path, names, width, n, t, values, message));
  PetscCall(CheckMessage(comm, message));
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(*n, t));
  if (rank) PetscCall(PetscMalloc1((width - 1) * *n, values));
  PetscCallMPI(MPI_Bcast(*t, *n, MPIU_REAL, 0, comm));
  PetscCallMPI(MPI_Bcast(*values, (width - 1) * *n, MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneReadMotions(MPI_Comm comm, Scene *scene)
{
  char key[LABEL_LENGTH];
  PetscFunctionBeginUser;
  for (Support *s = scene->supports; s < scene->supports + scene->n_supports; s++) {
    if (!s->motion[0]) continue;
    PetscCall(PetscSNPrintf(key, sizeof(key), "supports.%s.motion", s->name));
    PetscCall(share_rows(comm, scene, key, s->motion, "t, x, y", 3, &s->n_rows, &s->t, &s->xy));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneReadLevels(MPI_Comm comm, Scene *scene)
{
  char key[LABEL_LENGTH];
  PetscFunctionBeginUser;
  for (Load *l = scene->loads; l < scene->loads + scene->n_loads; l++) {
    if (!l->levels[0]) continue;
    PetscCall(PetscSNPrintf(key, sizeof(key), "loads.%s.levels", l->name));
    PetscCall(share_rows(comm, scene, key, l->levels, "t, level", 2, &l->n_levels, &l->t, &l->levels_at));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a line with the checksum of a file that a key names. */
static void note_file(FILE *f, const char *section, const char *name, const char *key, const char *path)
{
  struct stat file = {0};
  uint64_t sum;
  if (!path[0] || stat(path, &file) || !S_ISREG(file.st_mode)) return;
  if (FileChecksum(path, (size_t)file.st_size, &sum)) return; // the reader of the file says why
  fprintf(f, "%s_%s_%s_checksum %08" PRIx64 "\n", section, name, key, sum);
}

/* Adds a line with the checksum of each file of motion or levels to the options, so that a restart tells when
   a file has changed. */
PetscErrorCode SceneNoteFiles(Scene *scene)
{
  char *text = NULL;
  size_t size;

  PetscFunctionBeginUser;
  FILE *f = open_memstream(&text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  fputs(scene->options, f);
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++)
    note_file(f, "supports", s->name, "motion", s->motion);
  for (const Load *l = scene->loads; l < scene->loads + scene->n_loads; l++)
    note_file(f, "loads", l->name, "levels", l->levels);
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  free(scene->options);
  scene->options = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

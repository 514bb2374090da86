/* sample_table.c: reads the table of samples and writes the table of their results, row by row. A row of
   results is the row of the sample, followed by its results. It leaves the process as soon as the sample
   ends, and is on the disk a second later at most. A row that a kill has cut is dropped, and its sample runs
   again. */
#include "study/samples.h"
#include <errno.h>
#include <search.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char RESULTS[] = "samples.csv", STDIN[] = "/dev/stdin";
static const char *const Heads[] = {[COLUMN_NUMBER] = "",
                                    [COLUMN_ASK] = "tell:",
                                    [COLUMN_UNTIL] = "until:",
                                    [COLUMN_LOADS] = "loads",
                                    [COLUMN_RISE] = "rise"}; /* of names of columns */
static const char COLUMNS[] = "outcome,stage,stable,failing,undecided,factor_stable,factor_failing,"
                              "evaluations,seconds,checksum";

/* Cuts a line at its commas; the pieces stay in text. Returns their number, most + 1 if there are more. */
static int cut(char *text, int most, char **piece)
{
  int n = 0;
  for (char *rest = text; rest && n <= most;) {
    char *comma = strchr(rest, ',');
    if (comma) *comma = '\0';
    rest += strspn(rest, " ");
    for (size_t end = strlen(rest); end && rest[end - 1] == ' ';) rest[--end] = '\0';
    if (n < most) piece[n] = rest;
    n++, rest = comma ? comma + 1 : NULL;
  }
  return n;
}

/* Reads a line without its end. Returns 0 at the end of the file, -1 if it is too long or incomplete. */
static int take_line(FILE *f, char line[MOST_LINE])
{
  if (!fgets(line, MOST_LINE, f)) return 0;
  size_t n = strlen(line);
  const int whole = n && line[n - 1] == '\n';
  while (n && (line[n - 1] == '\n' || line[n - 1] == '\r')) line[--n] = '\0';
  return whole || (feof(f) && n + 1 < MOST_LINE) ? 1 : -1;
}

static PetscBool begins(const char *text, const char *word)
{
  return (PetscBool)!strncmp(text, word, strlen(word));
}

static ColumnKind kind_of(const char *name)
{
  for (ColumnKind kind = COLUMN_ASK; kind <= COLUMN_UNTIL; kind++)
    if (begins(name, Heads[kind])) return kind;
  for (ColumnKind kind = COLUMN_LOADS; kind <= COLUMN_RISE; kind++)
    if (!strcmp(name, Heads[kind])) return kind;
  return COLUMN_NUMBER;
}

/* Interprets a name of the header: the result that the column asks for, or the number that it sets. */
static void take_column(const Scene *scene, int i, char *name, SampleTable *t, char *message)
{
  t->kind[i] = kind_of(name);
  t->column[i] = name + strlen(Heads[t->kind[i]]);
  for (int k = 0; k < i; k++)
    if (!strcmp(t->column[i], t->column[k]) && t->kind[i] == t->kind[k])
      snprintf(message, MESSAGE_LENGTH, "%.500s: column %.200s twice", t->name, name);
  if (t->kind[i] == COLUMN_NUMBER) t->numbers = PETSC_TRUE;
  if (t->kind[i] == COLUMN_LOADS) t->loads = i;
  if (t->kind[i] == COLUMN_RISE) t->rise = i;
  if (t->kind[i] == COLUMN_UNTIL) {
    while (t->last >= 0 && strcmp(scene->stages[t->last].name, t->column[i]) != 0) t->last--;
    if (t->last < 0) snprintf(message, MESSAGE_LENGTH, "%.500s: %.200s: no such stage", t->name, name);
  } else if (t->kind[i] == COLUMN_NUMBER && !message[0] && SceneVaries(scene, t->column[i]) < 0)
    snprintf(message, MESSAGE_LENGTH,
             "%.500s: %.200s: expected a number of joints, loads, anchors or stages of the scene, such as "
             "joints.base.friction: others change mesh, contacts or blocks and need a run each",
             t->name, t->column[i]);
}

static PetscErrorCode check_header(const Scene *scene, SampleTable *t, char *message)
{
  char *piece[MOST_COLUMNS + 1] = {NULL};
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(t->names, t->header, sizeof(t->names)));
  const int n = cut(t->names, MOST_COLUMNS + 1, piece);
  if (n > MOST_COLUMNS + 1 || n < 2 || strcmp(piece[0], "sample") != 0) {
    snprintf(message, MESSAGE_LENGTH,
             "%.500s: expected a header sample,<key>,.. of up to %d columns, such as "
             "sample,joints.base.friction",
             t->name, MOST_COLUMNS);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  t->n_columns = n - 1, t->last = scene->n_stages - 1, t->loads = t->rise = -1;
  for (int i = 0; i < t->n_columns && !message[0]; i++) take_column(scene, i, piece[i + 1], t, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results that are there */

/* Compares names of samples: lines up to their first comma. */
static int order_of_names(const void *a, const void *b)
{
  const size_t m = strcspn(a, ","), n = strcspn(b, ",");
  const int differ = strncmp(a, b, PetscMin(m, n));
  return differ ? differ : (m > n) - (m < n);
}

/* Adds a line to the known ones. */
static PetscErrorCode add_known(SampleTable *t, const char *line)
{
  PetscFunctionBeginUser;
  char *kept = strdup(line);
  PetscCheck(kept && tsearch(kept, &t->known, order_of_names), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the head of the results: a line with the run they belong to, a line of columns. */
static void head_of(const SampleTable *t, uint64_t run, char head[2 * MOST_LINE])
{
  char asked[MOST_LINE] = "";
  size_t n = 0;
  for (int i = 0; i < t->n_columns; i++)
    if (t->kind[i] == COLUMN_ASK && n < sizeof(asked))
      n += (size_t)snprintf(asked + n, sizeof(asked) - n, ",%s", t->column[i]);
  snprintf(head, 2 * MOST_LINE, "# quoin samples %016llx\n%s,%s%s%s,why,warnings,warned\n",
           (unsigned long long)run, t->header, COLUMNS, asked, t->loads < 0 ? "" : ",on_faces,flood");
}

/* Reads the present rows. good: [byte] end of the last complete row. */
static PetscErrorCode read_known(SampleTable *t, FILE *f, const char *head, long *good, char *message)
{
  char line[4 * MOST_LINE], start[2 * MOST_LINE]; // a row, and its results
  PetscFunctionBeginUser;
  const size_t n = fread(start, 1, strlen(head), f);
  *good = 0;
  if (n < strlen(head) && !strncmp(start, head, n)) PetscFunctionReturn(PETSC_SUCCESS); // cut in the head
  if (n < strlen(head) || strncmp(start, head, n) != 0) {
    snprintf(message, MESSAGE_LENGTH,
             "%.500s/%s: results of another table, scene or mesh: take another output, or remove it",
             t->folder, RESULTS);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (*good = ftell(f); fgets(line, sizeof(line), f) && strchr(line, '\n'); *good = ftell(f)) {
    char *end = line; // the cells of the sample are the row as the table has it
    for (int i = 0; i <= t->n_columns && end; i++) end = strchr(end + (i > 0), ',');
    if (end) *end = '\0';
    PetscCall(add_known(t, line));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode open_results(const Scene *scene, uint64_t run, SampleTable *t, char *message)
{
  char path[PETSC_MAX_PATH_LEN + 16], head[2 * MOST_LINE];
  long good = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(t->folder, scene->output, sizeof(t->folder)));
  if (FolderMake(t->folder, message)) PetscFunctionReturn(PETSC_SUCCESS);
  t->lock = FolderLock(t->folder, message);
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  snprintf(path, sizeof(path), "%s/%s", t->folder, RESULTS);
  head_of(t, run, head);
  t->results = fopen(path, "r+");
  if (t->results)
    PetscCall(read_known(t, t->results, head, &good, message));
  else
    t->results = fopen(path, "w");
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (!t->results || fseek(t->results, good, SEEK_SET) || ftruncate(fileno(t->results), good) ||
      (!good && fputs(head, t->results) < 0) || fflush(t->results))
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.500s': %s", path, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- */

PetscErrorCode SampleTableOpen(const Scene *scene, uint64_t run, const char *why, SampleTable *t,
                               char message[MESSAGE_LENGTH])
{
  const PetscBool streams = (PetscBool)!strcmp(scene->samples, STDIN);
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  t->lock = -1, t->n_loads = scene->n_loads;
  PetscCall(PetscStrncpy(t->name, scene->samples, sizeof(t->name)));
  t->rows = streams ? stdin : fopen(scene->samples, "r");
  if (!t->rows || take_line(t->rows, t->header) != 1)
    snprintf(message, MESSAGE_LENGTH, "samples: %.500s: %s", t->name,
             t->rows ? "expected a header sample,<key>,.." : strerror(errno));
  t->line = 1;
  if (!message[0]) PetscCall(check_header(scene, t, message));
  if (!message[0] && why && t->loads < 0)
    snprintf(message, MESSAGE_LENGTH, "%.500s: samples: %s", scene->file, why);
  if (!message[0] && t->loads < 0 && t->rise >= 0)
    snprintf(message, MESSAGE_LENGTH, "%.500s: column rise without a column loads", t->name);
  if (!message[0] && t->loads >= 0 && !streams)
    snprintf(message, MESSAGE_LENGTH, "%.500s: loads come through a pipe alone: -samples %s", t->name, STDIN);
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (!streams) {
    PetscCall(open_results(scene, run, t, message));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  char head[2 * MOST_LINE];
  head_of(t, run, head);
  t->results = stdout;
  fputs(head, stdout);
  if (fflush(stdout) || ferror(stdout))
    snprintf(message, MESSAGE_LENGTH, "output: samples: results cannot be written: %s", strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the sample of the present row has results; it must be the same sample. */
static PetscBool is_known(const SampleTable *t, char *message)
{
  char *const *found = tfind(t->row, &t->known, order_of_names);
  if (found && strcmp(*found, t->row) != 0)
    snprintf(
        message, MESSAGE_LENGTH,
        "%.300s:%d: sample %.100s has other numbers than in %.300s/%s: take another output, or remove it",
        t->name, t->line, t->cell[0], t->folder, RESULTS);
  return (PetscBool)(found != NULL);
}

PetscErrorCode SampleTableNext(SampleTable *t, PetscBool *more, char message[MESSAGE_LENGTH])
{
  int got;
  PetscFunctionBeginUser;
  *more = PETSC_FALSE;
  while (!message[0] && (got = take_line(t->rows, t->row)) != 0) {
    t->line++;
    if (got > 0 && !t->row[0]) continue;
    PetscCall(PetscStrncpy(t->cells, t->row, sizeof(t->cells)));
    const int n = got < 0 ? 0 : cut(t->cells, t->n_columns + 1, t->cell);
    if (n != t->n_columns + 1 || !t->cell[0][0]) {
      snprintf(message, MESSAGE_LENGTH, "%.500s:%d: expected the name of a sample and %d cells", t->name,
               t->line, t->n_columns);
      break;
    }
    if (t->lock >= 0 && begins(t->cell[0], PIVOT))
      snprintf(message, MESSAGE_LENGTH, "%.500s:%d: %.100s: pivots come through a pipe alone: -samples %s",
               t->name, t->line, t->cell[0], STDIN);
    if (message[0] || is_known(t, message) || message[0]) continue;
    *more = PETSC_TRUE;
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void put(FILE *f, PetscReal value)
{
  if (isfinite(value))
    fprintf(f, ",%.17g", (double)value);
  else
    fputc(',', f);
}

/* Writes a cell, without commas and line ends. */
static void put_text(FILE *f, const char *text)
{
  for (fputc(',', f); *text; text++) fputc(*text == ',' ? ';' : *text == '\n' ? ' ' : *text, f);
}

/* Writes two cells of numbers with blanks between them: of each row of the loads on faces the columns of
   LoadsTable; of a flood its start [m] and the rows of the loads that rise. */
static void put_loads(FILE *f, const SampleTable *t, const SampleResult *r)
{
  fputc(',', f);
  for (PetscInt i = 0; i < r->loads.n_rows; i++)
    for (const TermColumn *c = r->loads.columns; c < r->loads.columns + r->loads.n_columns; c++)
      for (PetscInt k = 0; k < c->width; k++) fprintf(f, "%.17g ", (double)c->values[i * c->width + k]);
  fputc(',', f);
  if (r->flood) fprintf(f, "%.17g", (double)r->flood->start);
  for (PetscInt l = 0; r->flood && l < t->n_loads; l++)
    if (r->flood->level_rises[l]) fprintf(f, " %d", (int)l);
}

PetscErrorCode SampleTableAdd(SampleTable *t, const SampleResult *r, char message[MESSAGE_LENGTH])
{
  FILE *f = t->results;
  PetscFunctionBeginUser;
  fprintf(f, "%s,%s,%s", t->row, r->outcome, r->stage);
  put(f, r->stable), put(f, r->failing), put(f, r->open), put(f, r->factor[0]), put(f, r->factor[1]);
  fprintf(f, ",%lld,%.6f,%016llx", (long long)r->evaluations, r->seconds, (unsigned long long)r->checksum);
  for (int i = 0; i < t->n_columns; i++)
    if (t->kind[i] == COLUMN_ASK) put(f, r->asked[i]);
  if (t->loads >= 0) put_loads(f, t, r);
  put_text(f, r->why);
  fprintf(f, ",%" PetscInt_FMT, r->warnings);
  put_text(f, r->warned);
  fputc('\n', f);
  const PetscBool sync = (PetscBool)(f != stdout && MPI_Wtime() > t->synced + 1.);
  if (fflush(f) || ferror(f) || (sync && fdatasync(fileno(f))))
    snprintf(message, MESSAGE_LENGTH, "samples: a row of results cannot be written: %s", strerror(errno));
  if (sync) t->synced = MPI_Wtime();
  if (f != stdout) PetscCall(add_known(t, t->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SampleTableClose(SampleTable *t, char message[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  if (t->rows && t->rows != stdin) fclose(t->rows);
  if (t->results && t->results != stdout) {
    int why = fflush(t->results) || fdatasync(fileno(t->results)) ? errno : 0;
    if (fclose(t->results) && !why) why = errno;
    if (why && !message[0])
      snprintf(message, MESSAGE_LENGTH, "samples: results cannot be written: %s", strerror(why));
  }
  if (t->lock >= 0) FolderUnlock(t->folder, t->lock);
  while (t->known) {
    char *line = *(char **)t->known;
    tdelete(line, &t->known, order_of_names);
    free(line);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

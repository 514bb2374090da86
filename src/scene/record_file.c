/* record_file.c: reads numbers in time: rows of a table, or an accelerogram as PEER writes it (AT2): a
   head with the units, the number of values NPTS and their step DT, then the values. */
#include "scene/record.h"
#include <ctype.h>
#include <inttypes.h>
#include <stdarg.h>
#include <strings.h>

typedef struct {
  FILE *file;
  char *line;
  size_t capacity;
  const char *text;  /* of the line, without blanks before it */
  PetscInt64 number; /* of the line */
  char *message;     /* the first fault */
} Lines;

static void fault(Lines *l, const char *format, ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
static void fault(Lines *l, const char *format, ...)
{
  va_list arguments;
  if (l->message[0]) return;
  const int n = snprintf(l->message, MESSAGE_LENGTH, "line %" PetscInt64_FMT ": ", l->number);
  va_start(arguments, format);
  vsnprintf(l->message + n, (size_t)(MESSAGE_LENGTH - n), format, arguments);
  va_end(arguments);
}

/* Returns whether there is another line. Skips the byte-order mark of spreadsheets before UTF-8. */
static PetscBool next_line(Lines *l)
{
  const ssize_t length = l->message[0] ? -1 : getline(&l->line, &l->capacity, l->file);
  if (length < 0) return PETSC_FALSE;
  l->text = l->line + (!l->number++ && !strncmp(l->line, "\xEF\xBB\xBF", 3) ? 3 : 0);
  l->text += strspn(l->text, " \t\r\n");
  if (strlen(l->line) == (size_t)length) return PETSC_TRUE;
  fault(l, "it has a zero byte");
  return PETSC_FALSE;
}

/* Returns the first word of the text, for a message. */
static const char *word_of(const char *text, char word[32])
{
  size_t n = 0;
  for (; text[n] && !strchr(" \t\r\n,", text[n]) && n < 31; n++)
    word[n] = (char)(isgraph((unsigned char)text[n]) ? text[n] : '?');
  word[n] = '\0';
  return word;
}

/* Reads the next number of the line and the separator after it: blanks, or a comma. */
static void take_number(Lines *l, const char *expected, double *x)
{
  char *end, word[32];
  const size_t digits = strspn(l->text, "0123456789+-.eE");
  *x = strtod(l->text, &end);
  if (!digits || end != l->text + digits || !isfinite(*x) || !strchr(" \t\r\n,#", *end)) {
    fault(l, "'%s': expected a finite number (%s)", word_of(l->text, word), expected);
    return;
  }
  l->text = end + strspn(end, " \t\r\n");
  if (*l->text != ',') return;
  l->text += 1 + strspn(l->text + 1, " \t\r\n");
  if (!*l->text) fault(l, "it ends with a comma: expected a number (%s)", expected);
}

static PetscBool over(const Lines *l)
{
  return (PetscBool)(l->message[0] || !*l->text || *l->text == '#');
}

static PetscErrorCode add_row(Record *r, PetscReal t, const PetscReal *x)
{
  PetscFunctionBeginUser;
  if (r->n == 0 || (r->n >= 64 && (r->n & (r->n - 1)) == 0)) { // room for twice as many
    const PetscInt capacity = r->n ? 2 * r->n : 64;
    PetscCall(PetscRealloc(capacity * sizeof(PetscReal), &r->t));
    PetscCall(PetscRealloc(r->width * capacity * sizeof(PetscReal), &r->x));
  }
  r->t[r->n] = t;
  for (PetscInt k = 0; k < r->width; k++) r->x[r->width * r->n + k] = x[k];
  r->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- tables */

/* Decides whether a row at this time may follow: later, or once at the same time, which makes a jump. */
static PetscBool may_follow(const Record *r, PetscReal t)
{
  if (!r->n || t > r->t[r->n - 1]) return PETSC_TRUE;
  return (PetscBool)(t == r->t[r->n - 1] && (r->n == 1 || t > r->t[r->n - 2]));
}

/* Decides whether the line names columns ("t, x, y"); a number is no name. */
static PetscBool has_names(const char *text)
{
  char *end;
  if (!isalpha((unsigned char)*text) && *text != '"') return PETSC_FALSE;
  (void)strtod(text, &end);
  return (PetscBool)(end == text);
}

static PetscErrorCode read_table(Lines *l, const RecordShape *shape, Record *record)
{
  PetscBool may_name = PETSC_TRUE;
  double row[RECORD_WIDEST] = {0.};
  PetscFunctionBeginUser;
  while (next_line(l)) {
    int n = 0;
    if (over(l)) continue;
    const PetscBool names = (PetscBool)(may_name && has_names(l->text));
    may_name = PETSC_FALSE;
    if (names) continue;
    for (; !over(l) && n < shape->most; n++) take_number(l, shape->names, row + n);
    if (!over(l)) fault(l, "more than %d numbers: expected %s", shape->most, shape->names);
    if (n < shape->least) fault(l, "%d number%s: expected %s", n, Plural(n), shape->names);
    if (!record->n) record->width = n - 1;
    if (n != record->width + 1)
      fault(l, "%d numbers, those before it %" PetscInt_FMT ": expected %s", n, record->width + 1,
            shape->names);
    if (!l->message[0] && !shape->places && !may_follow(record, row[0]))
      fault(l, "t = %.10g after %.10g: expected times that ascend, or twice the same for a step", row[0],
            (double)record->t[record->n - 1]);
    if (!l->message[0]) PetscCall(add_row(record, row[0], row + 1));
  }
  if (!l->message[0] && shape->places && !record->n)
    fault(l, "the end, and no row: expected %s", shape->names);
  if (!l->message[0] && !shape->places && (record->n < 2 || record->t[record->n - 1] <= record->t[0]))
    fault(l, "the end after %" PetscInt_FMT " row%s: expected %s at two times or more", record->n,
          Plural(record->n), shape->names);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- files of PEER */

static const struct {
  const char *word;
  MotionQuantity quantity;
  double factor; /* [m/s2] or [m/s] of one of it; g is the standard one */
} Units[] = {{"G", MOTION_ACCELERATION, 9.80665},       {"CM/S/S", MOTION_ACCELERATION, 0.01},
             {"CM/SEC/SEC", MOTION_ACCELERATION, 0.01}, {"CM/S2", MOTION_ACCELERATION, 0.01},
             {"CM/S**2", MOTION_ACCELERATION, 0.01},    {"CM/SEC**2", MOTION_ACCELERATION, 0.01},
             {"GAL", MOTION_ACCELERATION, 0.01},        {"M/S2", MOTION_ACCELERATION, 1.},
             {"M/S/S", MOTION_ACCELERATION, 1.},        {"CM/S", MOTION_VELOCITY, 0.01},
             {"CM/SEC", MOTION_VELOCITY, 0.01},         {"M/S", MOTION_VELOCITY, 1.}};

typedef struct {
  double factor; /* 0: the units are not known yet */
  double n, dt;  /* [-], [s]; n 0: not known yet */
  MotionQuantity quantity;
} Head;

static void take_units(Lines *l, Head *head)
{
  static const char before[] = "UNITS OF ";
  char word[32];
  const char *at = strstr(l->text, before);
  if (!at || head->factor > 0.) return;
  word_of(at + strlen(before) + strspn(at + strlen(before), " "), word);
  for (size_t n = strlen(word); n && strchr(".;:)", word[n - 1]);) word[--n] = '\0';
  for (size_t i = 0; i < sizeof Units / sizeof *Units; i++)
    if (!strcmp(word, Units[i].word)) head->factor = Units[i].factor, head->quantity = Units[i].quantity;
  if (!(head->factor > 0.))
    fault(l, "units of '%s': expected G, CM/S2 or M/S2, or of a velocity CM/S or M/S", word);
}

/* Returns the unit [s] of the step of a file; seconds if it has none. */
static double second_of(Lines *l, const char *text)
{
  static const struct {
    const char *word;
    double seconds;
  } units[] = {{"", 1.},        {"S", 1.},    {"SEC", 1.},    {"SECS", 1.},          {"SECOND", 1.},
               {"SECONDS", 1.}, {"MS", 1e-3}, {"MSEC", 1e-3}, {"MILLISECONDS", 1e-3}};
  char word[32];
  word_of(text + strspn(text, " "), word);
  for (size_t n = strlen(word); n && strchr(".;:)", word[n - 1]);) word[--n] = '\0';
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (!strcmp(word, units[i].word)) return units[i].seconds;
  fault(l, "DT in '%s': expected SEC or MSEC", word);
  return NAN;
}

/* Reads "NPTS= 4000, DT= .0050 SEC", or in older files "4000 .0050 NPTS, DT". */
static void take_size(Lines *l, Head *head)
{
  const char *points = strstr(l->text, "NPTS"), *step = points ? strstr(points, "DT") : NULL;
  int behind = 0;
  if (!points) return;
  head->dt = NAN;
  if (sscanf(points, "NPTS = %lf", &head->n) != 1)
    (void)sscanf(l->text, "%lf %lf", &head->n, &head->dt);
  else if (step && sscanf(step, "DT = %lf%n", &head->dt, &behind) == 1)
    head->dt *= second_of(l, step + behind);
  if (!(head->n >= 2.) || head->n > 1e9 || head->n != rint(head->n))
    fault(l, "NPTS %g: expected the number of values, 2 or more", head->n);
  if (!(head->dt > 0.) || !isfinite(head->dt * head->n))
    fault(l, "DT %g: expected the step between two values, > 0 [s]", head->dt);
}

static PetscErrorCode read_peer(Lines *l, Record *record, MotionQuantity *quantity)
{
  enum { LONGEST_HEAD = 10 };
  Head head = {0};
  double x;
  PetscFunctionBeginUser;
  record->width = 1;
  for (int i = 0; i < LONGEST_HEAD && head.n == 0. && next_line(l); i++) {
    for (char *c = l->line; *c; c++) *c = (char)toupper((unsigned char)*c);
    take_units(l, &head);
    take_size(l, &head);
  }
  if (head.n == 0.)
    fault(l, "no 'NPTS= ..., DT= ...' down to here: expected it in the head of a file of PEER");
  if (!(head.factor > 0.))
    fault(l, "no 'UNITS OF G' down to here: expected it in the head of a file of PEER");
  *quantity = head.quantity;
  while (next_line(l))
    while (!over(l)) {
      if ((double)record->n >= head.n) fault(l, "more values than NPTS says: %.0f", head.n);
      take_number(l, "a value", &x);
      x *= head.factor;
      if (!l->message[0]) PetscCall(add_row(record, (double)record->n * head.dt, &x));
    }
  if ((double)record->n < head.n)
    fault(l, "the end after %" PetscInt_FMT " values: NPTS says %.0f", record->n, head.n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- both */

static PetscBool ends_with(const char *path, const char *ending)
{
  const size_t n = strlen(path), m = strlen(ending);
  return (PetscBool)(n > m && !strcasecmp(path + n - m, ending));
}

PetscErrorCode RecordRead(const char *path, const RecordShape *shape, Record *record,
                          MotionQuantity *quantity, char message[MESSAGE_LENGTH])
{
  Lines l = {.file = fopen(path, "r"), .message = message};
  PetscFunctionBeginUser;
  *record = (Record){0};
  if (!l.file) {
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "no such file"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (ends_with(path, ".at2") || ends_with(path, ".vt2"))
    PetscCall(read_peer(&l, record, quantity));
  else
    PetscCall(read_table(&l, shape, record));
  free(l.line);
  fclose(l.file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RecordDestroy(Record *record)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(record->t));
  PetscCall(PetscFree(record->x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

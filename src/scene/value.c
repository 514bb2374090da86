/* value.c: finds the entries of keys and turns their text into checked values. Every complaint names the
   key and its line. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------------- asking */

/* Gives the entry of a key from the command line the dotted name `label`. Refuses a word that may mean two
   keys. */
static PetscErrorCode name_entry(Reader *r, const char *label, Entry *entry)
{
  PetscFunctionBeginUser;
  if (strcmp(entry->key, label)) {
    r->line = 0;
    if (entry->used) COMPLAIN(r, "may be %s too: change the scene file instead", entry->key);
    PetscCall(PetscFree(entry->key));
    PetscCall(PetscStrallocpy(label, &entry->key));
  }
  entry->used = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes "parent.name" to label. Every key needs it, so it does without snprintf, which is slow where a
   library has added conversions to it (libquadmath). */
static void join(const char *parent, const char *name, char label[LABEL_LENGTH])
{
  const char *const part[3] = {parent, parent[0] ? "." : "", name};
  size_t used = 0;
  for (int i = 0; i < 3; i++) {
    const size_t n = PetscMin(strlen(part[i]), LABEL_LENGTH - 1 - used);
    memcpy(label + used, part[i], n);
    used += n;
  }
  label[used] = '\0';
}

PetscErrorCode Ask(Reader *r, const char *parent, const char *name, Entry **entry)
{
  char *known, label[LABEL_LENGTH];

  PetscFunctionBeginUser;
  join(parent, name, label);
  const size_t length = strlen(label) + 1;
  PetscCall(PetscSegBufferGet(r->asked, length, &known));
  memcpy(known, label, length);
  memcpy(r->label, label, length);
  *entry = EntriesFind(&r->entries, label);
  if (*entry) PetscCall(name_entry(r, label, *entry));
  const Entry *holder = *entry ? *entry : EntriesFind(&r->entries, parent);
  r->line = holder ? holder->line : -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AskSection(Reader *r, const char *parent, const char *name, char path[LABEL_LENGTH])
{
  Entry *entry;

  PetscFunctionBeginUser;
  PetscCall(Ask(r, parent, name, &entry));
  if (entry && entry->kind != ENTRY_SECTION)
    COMPLAIN(r, "keys below it expected ({key: value, ..}), not a value");
  memcpy(path, r->label, LABEL_LENGTH);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void add_name(Reader *r, Name *names, PetscInt *n, const char *name, int line)
{
  r->line = line;
  if (!NameIsValid(name)) COMPLAIN(r, "'%.80s' is not a name", name);
  for (PetscInt i = 0; i < *n; i++)
    if (!strcmp(names[i].name, name)) COMPLAIN(r, "'%s' twice", name);
  snprintf(names[*n].name, NAME_LENGTH, "%.*s", NAME_LENGTH - 1, name);
  names[(*n)++].line = line;
}

PetscErrorCode AskNames(Reader *r, const char *section, PetscInt *n, Name **names)
{
  char path[LABEL_LENGTH], item[LABEL_LENGTH];
  Entry *list;

  PetscFunctionBeginUser;
  PetscCall(Ask(r, "", section, &list));
  *n = 0;
  PetscCall(PetscMalloc1(r->entries.n + (list ? strlen(list->value) : 0) + 1, names));
  if (list && list->kind == ENTRY_SECTION) {
    for (const Entry *e = r->entries.entries; e < r->entries.entries + r->entries.n; e++) {
      size_t length = strlen(section);
      if (strncmp(e->key, section, length) || e->key[length] != '.') continue;
      if (!strchr(e->key + length + 1, '.')) add_name(r, *names, n, e->key + length + 1, e->line);
    }
  } else if (list && list->line == 0) {
    for (const char *rest = list->value; rest;) {
      rest = NextItem(rest, item);
      add_name(r, *names, n, item, 0);
    }
  } else if (list)
    COMPLAIN(r, "names with keys below them expected ({name: {key: value, ..}, ..})");
  for (PetscInt i = 0; i < *n; i++) PetscCall(AskSection(r, section, (*names)[i].name, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void AddOptionNames(Reader *r, const char *section, const char *key, PetscInt *n, Name *names)
{
  const Entry *list = EntriesFind(&r->entries, section);
  const size_t head = strlen(section) + 1, tail = strlen(key) + 1;
  char name[NAME_LENGTH];

  if (list && !list->line) return; // -joints a,b means exactly these
  for (const Entry *e = r->entries.entries; e < r->entries.entries + r->entries.n; e++) {
    const size_t length = strlen(e->key), middle = length - head - tail;
    if (e->line || length <= head + tail || middle >= sizeof name) continue;
    if (strncmp(e->key, section, head - 1) || e->key[head - 1] != '_') continue;
    if (strcmp(e->key + length - tail + 1, key) || e->key[length - tail] != '_') continue;
    snprintf(name, sizeof name, "%.*s", (int)middle, e->key + head);
    PetscBool there = (PetscBool)!NameIsValid(name);
    for (PetscInt i = 0; i < *n && !there; i++) there = (PetscBool)!strcmp(names[i].name, name);
    if (!there) add_name(r, names, n, name, 0);
  }
}

/* --------------------------------------------------------------------------------------- one value */

static PetscBool in_range(const char *range, double x)
{
  while (range && *range) {
    char side = *range++;
    PetscBool equal = (PetscBool)(*range == '=');
    char *end;
    double bound = strtod(range + equal, &end);
    if (!(side == '>' ? x > bound : x < bound) && !(equal && x == bound)) return PETSC_FALSE;
    range = end + strspn(end, ", ");
  }
  return PETSC_TRUE;
}

// Makes " [Pa]", for the end of a message.
static void describe_unit(const Key *key, char text[32])
{
  PetscBool plain = (PetscBool)(!key->unit[0] || !strcmp(key->unit, "-"));
  snprintf(text, 32, "%s%s%s", plain ? "" : " [", plain ? "" : key->unit, plain ? "" : "]");
}

static double convert_number(Reader *r, const Key *key, const char *text)
{
  char *end, unit[32];
  double x = strtod(text, &end);

  if (key->type == TYPE_LIMIT && (!strcmp(text, "inf") || !strcmp(text, ".inf"))) return PETSC_INFINITY;
  describe_unit(key, unit);
  if (end == text || *end || text[strspn(text, "0123456789+-.eE")])
    COMPLAIN(r, "'%.60s' is not a number%s", text, unit);
  if (!isfinite(x)) COMPLAIN(r, "%.60s is too large for a number", text);
  if (key->type == TYPE_INT && (x != rint(x) || fabs(x) > 1e9))
    COMPLAIN(r, "%.60s is not a whole number up to 1e9%s", text, unit);
  if (!in_range(key->range, x)) COMPLAIN(r, "%.60s is out of range: must be %s%s", text, key->range, unit);
  return x;
}

static PetscBool convert_bool(Reader *r, const char *text)
{
  static const char *const words[] = {"false", "true", "no", "yes", "off", "on", "0", "1"};
  for (int i = 0; i < 8; i++)
    if (!strcmp(text, words[i])) return (PetscBool)(i % 2);
  if (text[0]) COMPLAIN(r, "'%.60s' is neither true nor false", text);
  return PETSC_TRUE; // a key without a value
}

void DescribeChoices(const char *const *choices, char text[256])
{
  size_t used = 0;
  text[0] = '\0';
  for (int i = 0; choices[i + 2] && used < 256; i++) // the last two are names of the enum itself
    used += snprintf(text + used, 256 - used, "%s%s", i ? ", " : "", choices[i]);
}

static int convert_choice(Reader *r, const char *const *choices, const char *text)
{
  char known[256];
  for (int i = 0; choices[i + 2]; i++)
    if (!strcmp(text, choices[i])) return i;
  DescribeChoices(choices, known);
  COMPLAIN(r, "'%.60s' is not one of: %s", text, known);
  return 0;
}

static void convert_text(Reader *r, const Key *key, const char *text, char *value)
{
  size_t size = key->type == TYPE_TITLE ? sizeof r->scene->title : PETSC_MAX_PATH_LEN;
  if (key->type == TYPE_NAME) size = NAME_LENGTH;
  if (strlen(text) >= size) COMPLAIN(r, "longer than %d characters", (int)size - 1);
  if (key->type == TYPE_NAME && !NameIsValid(text)) COMPLAIN(r, "'%.80s' is not a name", text);
  snprintf(value, size, "%s", text);
}

static void convert_fix(Reader *r, const char *text, PetscBool fix[2])
{
  fix[0] = (PetscBool)(strchr(text, 'x') != NULL);
  fix[1] = (PetscBool)(strchr(text, 'y') != NULL);
  if (strcmp(text, "x") && strcmp(text, "y") && strcmp(text, "xy"))
    COMPLAIN(r, "'%.60s' is not one of: x, y, xy", text);
}

static void convert_pair(Reader *r, const Key *key, const char *text, PetscReal value[2])
{
  char item[LABEL_LENGTH];
  int n = 0;
  for (const char *rest = text; rest; n++) {
    rest = NextItem(rest, item);
    double x = convert_number(r, key, item);
    if (n < 2) value[n] = x;
  }
  if (n != 2) COMPLAIN(r, "two numbers expected: [x, y]");
}

static PetscErrorCode convert_numbers(Reader *r, const Key *key, const char *text, PetscInt *n,
                                      PetscReal **values)
{
  char item[LABEL_LENGTH];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(strlen(text) + 1, values));
  *n = 0;
  if (!text[0]) COMPLAIN(r, "the list is empty");
  for (const char *rest = text[0] ? text : NULL; rest; ++*n) {
    rest = NextItem(rest, item);
    (*values)[*n] = convert_number(r, key, item);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode convert_names(Reader *r, const char *text, PetscInt *n, char (**names)[NAME_LENGTH])
{
  char item[LABEL_LENGTH];
  Name *found;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(strlen(text) + 1, &found));
  *n = 0;
  if (!text[0]) COMPLAIN(r, "the list is empty");
  for (const char *rest = text; rest;) {
    rest = NextItem(rest, item);
    add_name(r, found, n, item, r->line);
  }
  PetscCall(PetscMalloc1(*n, names));
  for (PetscInt i = 0; i < *n; i++) memcpy((*names)[i], found[i].name, NAME_LENGTH);
  PetscCall(PetscFree(found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode convert_loads(Reader *r, const char *text, PetscInt *n, PetscInt **loads)
{
  char(*names)[NAME_LENGTH], known[512] = "none";
  size_t used = 0;

  PetscFunctionBeginUser;
  *n = 0;
  if (!text[0]) PetscFunctionReturn(PETSC_SUCCESS); // stage_keys.c says whether an empty list is allowed
  for (PetscInt l = 0; l < r->scene->n_loads && used < sizeof known; l++)
    used += snprintf(known + used, sizeof known - used, "%s%s", l ? ", " : "", r->scene->loads[l].name);
  PetscCall(convert_names(r, text, n, &names));
  PetscCall(PetscMalloc1(*n, loads));
  for (PetscInt i = 0; i < *n; i++) {
    (*loads)[i] = -1;
    for (PetscInt l = 0; l < r->scene->n_loads; l++)
      if (!strcmp(names[i], r->scene->loads[l].name)) (*loads)[i] = l;
    if ((*loads)[i] < 0) COMPLAIN_MISSING(r, "no load named '%s'; loads: %s", names[i], known);
  }
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Writes the value of one key into its field of `base`.
static PetscErrorCode convert(Reader *r, const Key *key, const char *text, void *base)
{
  void *field = (char *)base + key->offset, *count = (char *)base + key->count;

  PetscFunctionBeginUser;
  switch (key->type) {
  case TYPE_TITLE:
  case TYPE_PATH:
  case TYPE_MOTION:
  case TYPE_NAME:
    convert_text(r, key, text, field);
    break;
  case TYPE_REAL:
  case TYPE_LIMIT:
    *(PetscReal *)field = key->word && !strcmp(text, key->word) ? NAN : convert_number(r, key, text);
    break;
  case TYPE_INT:
    *(PetscInt *)field = (PetscInt)PetscClipInterval(convert_number(r, key, text), -1e9, 1e9);
    break;
  case TYPE_BOOL:
    *(PetscBool *)field = convert_bool(r, text);
    break;
  case TYPE_TRISTATE:
    *(PetscInt *)field = convert_bool(r, text);
    break;
  case TYPE_CHOICE:
    *(int *)field = convert_choice(r, key->choices, text);
    break;
  case TYPE_FIX:
    convert_fix(r, text, field);
    break;
  case TYPE_PAIR:
    convert_pair(r, key, text, field);
    break;
  case TYPE_NUMBERS:
    PetscCall(convert_numbers(r, key, text, count, field));
    break;
  case TYPE_NAMES:
    PetscCall(convert_names(r, text, count, field));
    break;
  case TYPE_LOADS:
    PetscCall(convert_loads(r, text, count, field));
    break;
  case TYPE_CHANGES:
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---------------------------------------------------------------------------------------- sections */

/* Writes items that the command line gives by their place, -loads_push_value[0], into a list of numbers. */
static PetscErrorCode take_items(Reader *r, Entry *entry)
{
  char label[LABEL_LENGTH], name[LABEL_LENGTH + 16], item[LABEL_LENGTH], *text;
  PetscBool any = PETSC_FALSE;
  size_t size;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  memcpy(label, r->label, sizeof(label));
  const int line = r->line;
  FILE *f = open_memstream(&text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for a list");
  for (const char *rest = entry->value; rest; n++) {
    Entry *given = NULL;
    rest = NextItem(rest, item);
    snprintf(name, sizeof(name), "%s[%d]", label, (int)n);
    if (strlen(name) < LABEL_LENGTH && EntriesFind(&r->entries, name)) PetscCall(Ask(r, "", name, &given));
    any = (PetscBool)(any || given);
    fprintf(f, "%s%s", n ? "," : "", given ? given->value : item);
  }
  fclose(f);
  memcpy(r->label, label, sizeof(label)), r->line = any ? 0 : line;
  if (any) {
    PetscCall(PetscFree(entry->value));
    PetscCall(PetscStrallocpy(text, &entry->value));
    entry->line = 0;
  }
  free(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadKey(Reader *r, const Key *key, const Entry *given, void *base)
{
  PetscBool is_list = (PetscBool)(key->type == TYPE_PAIR || key->type == TYPE_NUMBERS ||
                                  key->type == TYPE_NAMES || key->type == TYPE_LOADS ||
                                  key->type == TYPE_MOTION);
  PetscBool may_be_bare = (PetscBool)(key->type == TYPE_TITLE || (given && given->kind == ENTRY_LIST));
  char unit[32];

  PetscFunctionBeginUser;
  Entry *entry = given ? r->entries.entries + (given - r->entries.entries) : NULL;
  if (entry && entry->kind != ENTRY_SECTION && (key->type == TYPE_PAIR || key->type == TYPE_NUMBERS))
    PetscCall(take_items(r, entry));
  if (entry) PetscCall(TakeUnits(r, key, entry));
  const char *text = entry ? entry->value : key->preset;
  describe_unit(key, unit);
  if (entry && !entry->line && (key->type == TYPE_BOOL || key->type == TYPE_TRISTATE))
    may_be_bare = PETSC_TRUE;
  if (entry && entry->kind == ENTRY_SECTION)
    COMPLAIN(r, "a value expected, not keys below it");
  else if (entry && entry->kind == ENTRY_LIST && !is_list)
    COMPLAIN(r, "a single value expected, not a list");
  else if (!text)
    COMPLAIN_MISSING(r, "missing%s", unit);
  else if (entry && !text[0] && !may_be_bare)
    COMPLAIN(r, "no value given");
  else if (text[0] != '=' || entry)
    PetscCall(convert(r, key, text, base));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ------------------------------------------------------------------------------------ unknown keys */

static char plain_letter(char c)
{
  return c == '.' ? '_' : c;
}

// Returns the number of letters to change, drop or add to turn one key into the other, counted up to `most`.
// It is also 0 when b only has more letters at its end.
static size_t key_distance(const char *a, const char *b, size_t most)
{
  const size_t m = strlen(a), n = strlen(b);
  size_t same = 0, row[LABEL_LENGTH + 1];

  while (a[same] && plain_letter(a[same]) == plain_letter(b[same])) same++;
  if (!a[same] && !strchr(b + same, '.')) return 0;
  if (m >= n + most || n >= m + most) return most;
  for (size_t j = 0; j <= n; j++) row[j] = j;
  for (size_t i = 1; i <= m; i++) {
    size_t diagonal = row[0], least = i;
    row[0] = i;
    for (size_t j = 1; j <= n; j++) {
      size_t change = diagonal + (plain_letter(a[i - 1]) != plain_letter(b[j - 1]));
      diagonal = row[j];
      row[j] = PetscMin(change, PetscMin(row[j], row[j - 1]) + 1);
      least = PetscMin(least, row[j]);
    }
    if (least >= most) return most;
  }
  return row[n];
}

// The known key nearest to that of an entry, as it would be written there; "" if none is near.
/* Finds the known key that is most like the key of an unknown entry. */
static PetscErrorCode nearest_key(Reader *r, const Entry *e, char nearest[LABEL_LENGTH + 1])
{
  SegmentCount n;
  size_t best = 3 + strlen(e->key) / 16;
  char *known;

  PetscFunctionBeginUser;
  nearest[0] = '\0';
  if (strlen(e->key) >= LABEL_LENGTH) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSegBufferGetSize(r->asked, &n));
  PetscCall(PetscSegBufferExtractInPlace(r->asked, &known));
  for (char *k = known; k < known + n; k += strlen(k) + 1) {
    size_t distance = key_distance(e->key, k, best);
    if (distance >= best) continue;
    best = distance;
    snprintf(nearest, LABEL_LENGTH + 1, "%s%s", e->line ? "" : "-", k);
  }
  for (char *c = nearest; !e->line && *c; c++) *c = plain_letter(*c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keys that earlier versions had. */
static const struct {
  const char *key, *preset,
      *advice; /* value that a scene of then has where nobody gave one; what to do now */
} Removed[] = {
    {"repartition", "", "blocks stay on the rank that they have at the start; leave this section out"},
    {"repartition.when", "auto", "blocks stay on the rank that they have at the start; leave this key out"},
    {"repartition.every", "10000", "blocks stay on the rank that they have at the start; leave this key out"},
    {"repartition.gain", "0.1", "blocks stay on the rank that they have at the start; leave this key out"},
    {"contact.verify_after", "0.2",
     "contacts are found again after 0.2 of contact.tolerance; leave this key out"},
    {"flow.dynamic", "frozen",
     "a dynamic stage keeps the pressures of the water in joints; leave this key out"},
};

/* Returns the row of a key that was removed; -1: no version had it. */
static int removed_row(const char *key)
{
  for (int i = 0; i < (int)(sizeof(Removed) / sizeof(Removed[0])); i++) {
    const char *a = Removed[i].key, *b = key;
    while (*a && plain_letter(*a) == plain_letter(*b)) a++, b++;
    if (!*a && !*b) return i;
  }
  return -1;
}

/* Returns whether an entry is a removed key with its preset, as the scene_echo.yaml of an earlier version has
   it. */
static PetscBool has_removed_preset(const Entry *e)
{
  const int row = removed_row(e->key);
  return (PetscBool)(row >= 0 && !strcmp(e->value ? e->value : "", Removed[row].preset));
}

PetscErrorCode ConcludeMessage(Reader *r)
{
  static const char no_scene[] = "; no scene file is given: -options_file scene.yaml (-help lists all keys)";
  const Entry *e = r->entries.entries, *end = e + r->entries.n;
  char nearest[LABEL_LENGTH + 1];

  PetscFunctionBeginUser;
  while (e < end && (e->used || has_removed_preset(e))) e++;
  if (e < end && e->loose && EntriesFindSection(&r->entries, e->key)) {
    Complain(r->message, r->scene->file, e->line, e->key,
             "keys below it expected ({key: value, ..}), not a value");
  } else if (e < end && removed_row(e->key) >= 0) {
    Complain(r->message, r->scene->file, e->line, e->key, "removed: %s", Removed[removed_row(e->key)].advice);
  } else if (e < end) {
    PetscCall(nearest_key(r, e, nearest));
    Complain(r->message, r->scene->file, e->line, e->key, "unknown %s%s%s%s", e->line ? "key" : "option",
             nearest[0] ? "; did you mean " : " (-help lists all keys)", nearest, nearest[0] ? "?" : "");
  }
  if (!r->message[0] && r->missing[0])
    snprintf(r->message, MESSAGE_LENGTH, "%.900s%s", r->missing, r->scene->file[0] ? "" : no_scene);
  PetscFunctionReturn(PETSC_SUCCESS);
}

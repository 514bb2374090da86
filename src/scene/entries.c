/* entries.c: turns YAML text and the command line into Entries; see entries.h. Local to the rank. */
#include "scene/scene.h"
#include "scene/entries.h"
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

enum {
  MOST_ENTRIES = 20000, /* YAML aliases can multiply a small text, or form a circle */
  MOST_SCALARS = 2 * MOST_ENTRIES,
  DEEPEST = 6,               /* keys within keys */
  DEEPEST_TEXT = 4 * DEEPEST /* brackets within brackets: libyaml needs time with their square */
};

#define CONTROL "a value holds the control character U+%04X; one line of text expected"

void Complain(char *message, const char *file, int line, const char *key, const char *format, ...)
{
  if (message[0]) return;

  // where the fault is
  PetscBool from_file = (PetscBool)(line != 0 && file[0]);
  char label[LABEL_LENGTH + 2];
  snprintf(label, sizeof label, "%s%.*s", from_file || !key[0] ? "" : "-", LABEL_LENGTH, key);
  for (char *c = label; !from_file && *c; c++)
    if (*c == '.') *c = '_';
  int used = 0;
  if (!from_file)
    used = snprintf(message, MESSAGE_LENGTH, "command line: ");
  else if (line > 0)
    used = snprintf(message, MESSAGE_LENGTH, "%.400s:%d: ", file, line);
  else
    used = snprintf(message, MESSAGE_LENGTH, "%.400s: ", file);
  if (label[0]) used += snprintf(message + used, MESSAGE_LENGTH - used, "%s: ", label);

  // what the fault is
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message + used, MESSAGE_LENGTH - used, format, arguments);
  va_end(arguments);
  for (char *c = message; *c; c++)
    if (iscntrl((unsigned char)*c)) *c = ' ';
}

enum { NOT_UTF8 = 0x110000 };

/* Returns the place of the first character that text for a terminal, a report or YAML must not have: a
   control, an end of line, U+FEFF, U+FFFE, U+FFFF. NOT_UTF8: the bytes are no UTF-8; -1: the text is good. */
static int odd_character(const char *text, size_t length)
{
  static const int least[] = {0, 0, 0x80, 0x800, 0x10000};
  const unsigned char *c = (const unsigned char *)text;
  for (size_t at = 0, n; at < length; at += n) {
    n = c[at] < 0x80 ? 1 : c[at] < 0xc0 ? 0 : c[at] < 0xe0 ? 2 : c[at] < 0xf0 ? 3 : c[at] < 0xf8 ? 4 : 0;
    int code = n > 1 ? c[at] & 0x7f >> n : c[at];
    for (size_t i = 1; i < n && code != NOT_UTF8; i++)
      code = at + i < length && (c[at + i] & 0xc0) == 0x80 ? code << 6 | (c[at + i] & 0x3f) : NOT_UTF8;
    if (!n || code < least[n] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return NOT_UTF8;
    if (code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x2028 || code == 0x2029 || code == 0xfeff ||
        code == 0xfffe || code == 0xffff)
      return code;
  }
  return -1;
}

static void complain_odd(char *message, const char *file, int line, const char *key, int c)
{
  if (c == NOT_UTF8) Complain(message, file, line, key, "a value is no text in UTF-8");
  if (c >= 0) Complain(message, file, line, key, CONTROL, c);
}

const char *NextItem(const char *list, char item[LABEL_LENGTH])
{
  const char *comma = strchr(list, ',');
  const char *end = comma ? comma : list + strlen(list);
  while (list < end && isspace((unsigned char)*list)) list++;
  while (end > list && isspace((unsigned char)end[-1])) end--;
  snprintf(item, LABEL_LENGTH, "%.*s", (int)(end - list), list);
  return comma ? comma + 1 : NULL;
}

/* Returns the character that the command line writes for c: an underscore for a dot. Names may hold
   underscores too, so one word there may mean several dotted keys (`loads.water.level`, and a load
   `water_level`). */
static char plain(char c)
{
  return c == '.' ? '_' : c;
}

static PetscBool may_be_equal(const char *a, const char *b)
{
  for (; *a && *b; a++, b++)
    if (plain(*a) != plain(*b)) return PETSC_FALSE;
  return (PetscBool)(*a == *b);
}

static PetscInt slot_of(const Entries *list, const char *key)
{
  uint32_t h = 2166136261u; // FNV-1a
  for (; *key; key++) h = (h ^ (unsigned char)plain(*key)) * 16777619u;
  return (PetscInt)(h & (uint32_t)(list->n_slots - 1));
}

static void put_in_slot(Entries *list, PetscInt i)
{
  PetscInt *slot = list->slot + slot_of(list, list->entries[i].key);
  list->entries[i].next = *slot, *slot = i;
}

static Entry *find_exactly(const Entries *list, const char *key)
{
  for (PetscInt i = list->n ? list->slot[slot_of(list, key)] : -1; i >= 0; i = list->entries[i].next)
    if (!strcmp(list->entries[i].key, key)) return list->entries + i;
  return NULL;
}

Entry *EntriesFind(const Entries *list, const char *key)
{
  Entry *loose = NULL;
  for (PetscInt i = list->n ? list->slot[slot_of(list, key)] : -1; i >= 0; i = list->entries[i].next) {
    Entry *e = list->entries + i;
    if (!strcmp(e->key, key)) return e;
    if (!loose && e->loose && may_be_equal(e->key, key)) loose = e;
  }
  return loose;
}

Entry *EntriesFindSection(const Entries *list, const char *key)
{
  for (PetscInt i = list->n ? list->slot[slot_of(list, key)] : -1; i >= 0; i = list->entries[i].next)
    if (list->entries[i].kind == ENTRY_SECTION && may_be_equal(list->entries[i].key, key))
      return list->entries + i;
  return NULL;
}

static PetscErrorCode entries_add(Entries *list, const char *key, const char *value, EntryKind kind, int line)
{
  PetscFunctionBeginUser;
  if (list->n == list->capacity) {
    list->capacity = 2 * list->capacity + 64;
    PetscCall(PetscRealloc(list->capacity * sizeof(Entry), &list->entries));
    for (list->n_slots = 64; list->n_slots < list->capacity;) list->n_slots *= 2;
    PetscCall(PetscRealloc(list->n_slots * sizeof(PetscInt), &list->slot));
    for (PetscInt s = 0; s < list->n_slots; s++) list->slot[s] = -1;
    for (PetscInt i = 0; i < list->n; i++) put_in_slot(list, i);
  }
  Entry *entry = &list->entries[list->n++];
  *entry = (Entry){.kind = kind, .line = line};
  PetscCall(PetscStrallocpy(key, &entry->key));
  PetscCall(PetscStrallocpy(value, &entry->value));
  put_in_slot(list, list->n - 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EntriesText(const Entries *list, char **text)
{
  size_t size;
  PetscFunctionBeginUser;
  FILE *f = open_memstream(text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  for (PetscInt i = 0; i < list->n; i++) {
    const Entry *e = list->entries + i;
    if (e->kind != ENTRY_SECTION) fprintf(f, "%s %s\n", e->key, e->value);
  }
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EntriesDestroy(Entries *list)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < list->n; i++) {
    PetscCall(PetscFree(list->entries[i].key));
    PetscCall(PetscFree(list->entries[i].value));
  }
  PetscCall(PetscFree(list->entries));
  PetscCall(PetscFree(list->slot));
  list->n = list->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ------------------------------------------------------------------------------------------------ YAML */

typedef struct {
  yaml_document_t document;
  const char *file;
  Entries *list;
  char *message;
} Walk;

static PetscErrorCode walk_node(Walk *w, int id, const char *key, int line, int depth);

static PetscErrorCode walk_pair(Walk *w, yaml_node_pair_t pair, const char *parent, int depth)
{
  yaml_node_t *name = yaml_document_get_node(&w->document, pair.key);
  int line = (int)name->start_mark.line + 1;
  char key[LABEL_LENGTH];

  PetscFunctionBeginUser;
  PetscBool (*valid)(const char *) = strncmp(parent, "what_if.", 8) ? NameIsValid : PathIsValid;
  if (name->type != YAML_SCALAR_NODE || !valid((const char *)name->data.scalar.value)) {
    Complain(w->message, w->file, line, parent,
             "'%.80s' is not a name: a letter, then letters, digits, _ + -, %d at most",
             name->type == YAML_SCALAR_NODE ? (const char *)name->data.scalar.value : "[..]",
             NAME_LENGTH - 1);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  snprintf(key, sizeof key, "%s%s%s", parent, parent[0] ? "." : "", (const char *)name->data.scalar.value);
  Entry *twin = find_exactly(w->list, key);
  if (twin) Complain(w->message, w->file, line, key, "duplicate key, given in line %d already", twin->line);
  if (depth > DEEPEST) Complain(w->message, w->file, line, key, "nested too deeply");
  if (w->list->n > MOST_ENTRIES) Complain(w->message, w->file, line, key, "more than %d keys", MOST_ENTRIES);
  if (!w->message[0]) PetscCall(walk_node(w, pair.value, key, line, depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode walk_mapping(Walk *w, yaml_node_t *node, const char *key, int line, int depth)
{
  PetscFunctionBeginUser;
  if (key[0]) PetscCall(entries_add(w->list, key, "", ENTRY_SECTION, line));
  yaml_node_pair_t *pair = node->data.mapping.pairs.start;
  for (; pair < node->data.mapping.pairs.top && !w->message[0]; pair++)
    PetscCall(walk_pair(w, *pair, key, depth + 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Walks through a list: of values, or of mappings with one key each, which are an ordered section.
static PetscErrorCode walk_sequence(Walk *w, yaml_node_t *node, const char *key, int line, int depth)
{
  yaml_node_item_t *first = node->data.sequence.items.start, *end = node->data.sequence.items.top;
  size_t length = 1;
  int n_values = 0, n_pairs = 0;
  char *value;

  PetscFunctionBeginUser;
  for (yaml_node_item_t *i = first; i < end; i++) {
    yaml_node_t *item = yaml_document_get_node(&w->document, *i);
    if (item->type == YAML_SCALAR_NODE) n_values++, length += item->data.scalar.length + 1;
    if (item->type == YAML_MAPPING_NODE)
      n_pairs += item->data.mapping.pairs.top - item->data.mapping.pairs.start == 1;
  }
  if (n_values < end - first && n_pairs < end - first) {
    Complain(w->message, w->file, line, key,
             "a list must hold plain values only, or items with one name each ('- name: {..}')");
  } else if (n_pairs) {
    PetscCall(entries_add(w->list, key, "", ENTRY_SECTION, line));
    for (yaml_node_item_t *i = first; i < end && !w->message[0]; i++)
      PetscCall(
          walk_pair(w, *yaml_document_get_node(&w->document, *i)->data.mapping.pairs.start, key, depth + 1));
  } else {
    PetscCall(PetscCalloc1(length, &value));
    char *at = value;
    for (yaml_node_item_t *i = first; i < end; i++) {
      if (i > first) *at++ = ',';
      at = stpcpy(at, (const char *)yaml_document_get_node(&w->document, *i)->data.scalar.value);
    }
    PetscCall(entries_add(w->list, key, value, ENTRY_LIST, line));
    PetscCall(PetscFree(value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode walk_node(Walk *w, int id, const char *key, int line, int depth)
{
  yaml_node_t *node = yaml_document_get_node(&w->document, id);

  PetscFunctionBeginUser;
  if (node->type == YAML_SCALAR_NODE)
    PetscCall(entries_add(w->list, key, (const char *)node->data.scalar.value, ENTRY_VALUE, line));
  else if (node->type == YAML_MAPPING_NODE)
    PetscCall(walk_mapping(w, node, key, line, depth));
  else
    PetscCall(walk_sequence(w, node, key, line, depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Complains with libyaml's message and line. Tabs are the usual cause.
static void complain_syntax(Walk *w, const yaml_parser_t *parser, const char *text, size_t length)
{
  size_t line = parser->problem_mark.line, at = 0;
  for (size_t n = 0; at < length && n < line; at++) n += text[at] == '\n';
  while (at < length && text[at] == ' ') at++;
  PetscBool tab = (PetscBool)(at < length && text[at] == '\t');
  if (parser->error == YAML_MEMORY_ERROR) {
    Complain(w->message, w->file, -1, "", "no memory is left to read it");
    return;
  }
  Complain(w->message, w->file, (int)line + 1, "", "YAML syntax: %s%s%s%s",
           parser->context ? parser->context : "", parser->context ? ": " : "",
           parser->problem ? parser->problem : "unreadable",
           tab ? " (this line is indented by a tab; use spaces)" : "");
}

// Complains about text that no scene holds, whatever its keys; else updates how deep the text stands after
// this event.
static void check_event(Walk *w, const yaml_event_t *event, PetscInt *depth, PetscInt *n)
{
  const int line = (int)event->start_mark.line + 1;
  switch (event->type) {
  case YAML_DOCUMENT_START_EVENT:
    if (*n > 0) Complain(w->message, w->file, line, "", "a second YAML document");
    break;
  case YAML_MAPPING_START_EVENT:
  case YAML_SEQUENCE_START_EVENT:
    if (++*depth > DEEPEST_TEXT) Complain(w->message, w->file, line, "", "nested too deeply");
    break;
  case YAML_MAPPING_END_EVENT:
  case YAML_SEQUENCE_END_EVENT:
    --*depth;
    break;
  case YAML_SCALAR_EVENT:
    complain_odd(w->message, w->file, line, "",
                 odd_character((const char *)event->data.scalar.value, event->data.scalar.length));
  // fall through
  case YAML_ALIAS_EVENT:
    if (++*n > MOST_SCALARS) Complain(w->message, w->file, line, "", "more than %d values", MOST_SCALARS);
    break;
  default:
    break;
  }
}

// Checks the text event by event before a tree is made of it, in time and memory proportional to the text.
static PetscErrorCode check_text(Walk *w, const char *text, size_t length)
{
  yaml_parser_t parser;
  yaml_event_t event;
  PetscInt depth = 0, n = 0;
  PetscBool ended = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCheck(yaml_parser_initialize(&parser), PETSC_COMM_SELF, PETSC_ERR_MEM, "libyaml cannot start");
  yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
  while (!ended && !w->message[0]) {
    if (!yaml_parser_parse(&parser, &event)) {
      complain_syntax(w, &parser, text, length);
      break;
    }
    check_event(w, &event, &depth, &n);
    ended = (PetscBool)(event.type == YAML_STREAM_END_EVENT);
    yaml_event_delete(&event);
  }
  yaml_parser_delete(&parser);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EntriesReadYAML(Entries *list, const char *file, const char *text, size_t length,
                               char *message)
{
  Walk w = {.file = file, .list = list, .message = message};
  yaml_parser_t parser;

  PetscFunctionBeginUser;
  PetscCall(check_text(&w, text, length));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(yaml_parser_initialize(&parser), PETSC_COMM_SELF, PETSC_ERR_MEM, "libyaml cannot start");
  yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
  if (!yaml_parser_load(&parser, &w.document)) { // the alias names no anchor
    complain_syntax(&w, &parser, text, length);
    yaml_parser_delete(&parser);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  yaml_node_t *root = yaml_document_get_root_node(&w.document);
  if (!root)
    Complain(message, file, -1, "", "the scene is empty");
  else if (root->type != YAML_MAPPING_NODE)
    Complain(message, file, 1, "", "a scene is made of 'key: value' lines");
  else
    PetscCall(walk_mapping(&w, root, "", 1, 0));
  yaml_document_delete(&w.document);
  yaml_parser_delete(&parser);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---------------------------------------------------------------------------------------- command line */

// options that PETSc itself reads: those that end in _ by their beginning, the others whole
// clang-format off
static const char *const PetscOwn[] = {
    "blas_", "check_pointer_intensity", "checkstack", "debug_terminal", "debugger_", "display", "dm_",
    "error_output_stdout", "get_total_flops", "help", "info", "info_", "is_", "ksp_", "log_",
    "malloc", "malloc_", "mat_", "memory_view", "no_signal_handler", "nox", "objects_dump", "on_error_",
    "options_", "pc_", "petscpartitioner_", "petscsection_", "python", "sf_", "shared_tmp",
    "skip_petscrc", "snes_", "start_in_debugger", "stop_for_debugger", "sub_", "tao_", "ts_", "vec_",
    "vecscatter_", "version", "viewer_", NULL};
// clang-format on

static PetscBool is_petsc_own(const char *key)
{
  for (const char *const *own = PetscOwn; *own; own++) {
    size_t n = strlen(*own);
    if ((*own)[n - 1] == '_' ? !strncmp(key, *own, n) : !strcmp(key, *own)) return PETSC_TRUE;
  }
  return IsStateView(key);
}

// Returns the key of "-key" or "--key"; NULL for a negative number, which is no option.
static const char *option_key(const char *argument)
{
  if (argument[0] != '-') return NULL;
  argument += argument[1] == '-' ? 2 : 1;
  return isalpha((unsigned char)argument[0]) ? argument : NULL;
}

// Drops sections that the command line leaves out: `-stages sw` leaves the other stages of the file unread.
static void drop_others(Entries *list, const Entry *section)
{
  size_t n = strlen(section->key);
  for (Entry *e = list->entries; e < list->entries + list->n; e++) {
    if (strncmp(e->key, section->key, n) != 0 || e->key[n] != '.') continue;
    size_t length = strcspn(e->key + n + 1, ".");
    PetscBool named = PETSC_FALSE;
    char item[LABEL_LENGTH];
    for (const char *rest = section->value; rest && !named;) {
      rest = NextItem(rest, item);
      named = (PetscBool)(strlen(item) == length && !strncmp(item, e->key + n + 1, length));
    }
    if (!named) e->used = PETSC_TRUE;
  }
}

/* Returns the entry of the file that a key of the command line means: the one value, list or section of the
   first level. NULL: there is none. */
static Entry *find_meant(const Entries *list, const char *key, char *message)
{
  Entry *meant = NULL;
  for (PetscInt i = list->n ? list->slot[slot_of(list, key)] : -1; i >= 0; i = list->entries[i].next) {
    Entry *e = list->entries + i;
    if (!may_be_equal(e->key, key) || (e->kind == ENTRY_SECTION && strchr(e->key, '.'))) continue;
    if (meant)
      Complain(message, "", 0, key, "may be %s or %s: change the scene file instead", meant->key, e->key);
    meant = e;
  }
  return meant;
}

PetscErrorCode EntriesReadArguments(Entries *list, int argc, char **argv, char *message)
{
  PetscBool known_to_petsc;

  PetscFunctionBeginUser;
  for (int i = 1; i < argc; i++) {
    const char *option = argv[i], *key = option_key(option);
    if (!key) {
      Complain(
          message, "", 0, "",
          "'%.200s' is not an option; options are -key value (see -help), a scene -options_file scene.yaml",
          option);
      break;
    }
    const char *value = i + 1 < argc && !option_key(argv[i + 1]) ? argv[++i] : "";
    if (is_petsc_own(key)) continue;
    if (!strcmp(key, "fp_trap"))
      Complain(message, "", 0, key,
               "lanes whose results are thrown away may divide by zero: NaN is looked for instead");
    complain_odd(message, "", 0, key, odd_character(value, strlen(value)));
    Entry *entry = find_meant(list, key, message);
    if (entry) {
      PetscCall(PetscFree(entry->value));
      PetscCall(PetscStrallocpy(value, &entry->value));
      if (entry->kind == ENTRY_SECTION) drop_others(list, entry);
      entry->kind = ENTRY_VALUE;
      entry->line = 0;
    } else {
      PetscCall(entries_add(list, key, value, ENTRY_VALUE, 0));
      list->entries[list->n - 1].loose = PETSC_TRUE;
    }
    PetscCall(PetscOptionsHasName(NULL, NULL, option, &known_to_petsc)); // so that PETSc does not report it
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EntriesCheckElsewhere(char *message)
{
  PetscInt n;
  char **names, **values;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt i = 0; i < n; i++)
    if (!is_petsc_own(names[i]))
      Complain(message, "PETSC_OPTIONS", -1, "",
               "'-%.200s' is no option of PETSc: keys belong in the scene file or on the command line",
               names[i]);
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

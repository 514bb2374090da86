/* entries.h: declares a scene as a flat, ordered list of keys and values, from YAML text and from the command
   line. `materials: {dam: {density: 2400}}` gives the entries "materials", "materials.dam" (sections) and
   "materials.dam.density" = "2400". The command line writes _ for every dot of a key. */
#pragma once
#include "scene/scene.h"

typedef enum { ENTRY_VALUE, ENTRY_LIST, ENTRY_SECTION } EntryKind; /* commas join the items of a list */

typedef struct {
  char *key;
  char *value;
  EntryKind kind;
  int line;        /* in the scene file; 0: command line */
  PetscInt next;   /* next entry of the same slot, -1: none */
  PetscBool used;  /* whether the reader has asked for it */
  PetscBool loose; /* a word of the command line, no key of the file: it may mean several dotted keys */
} Entry;

typedef struct {
  PetscInt n, capacity, n_slots;
  Entry *entries;
  PetscInt *slot; /* (n_slots,) first entry by hash of its key, -1: none */
} Entries;

/* Reads the entries from YAML text; EntriesReadArguments reads them from arguments. message: receives the
   first fault. file: name for messages. */
PetscErrorCode EntriesReadYAML(Entries *list, const char *file, const char *text, size_t length,
                               char *message);
PetscErrorCode EntriesReadArguments(Entries *list, int argc, char **argv, char *message);
/* Checks, after the other two, the options that PETSc took from elsewhere (PETSC_OPTIONS,
   PETSC_OPTIONS_YAML, -options_file_yaml). They may only be options of PETSc, because a scene consists of its
   file and its command line. */
PetscErrorCode EntriesCheckElsewhere(char *message);
/* Returns the entry with this dotted key, else one of the command line that may mean it, else NULL. Does not
   mark the entry as used. */
Entry *EntriesFind(const Entries *list, const char *key);
/* Returns the section of the file that a key of the command line may mean; NULL: none. */
Entry *EntriesFindSection(const Entries *list, const char *key);
/* Makes a line "key value" of each value and list, with dotted keys; free the text with free(). */
PetscErrorCode EntriesText(const Entries *list, char **text);
PetscErrorCode EntriesDestroy(Entries *list);

/* ---- key_paths.c */
/* Returns whether a name is [A-Za-z][A-Za-z0-9_+-]*, at most 63 characters. */
PetscBool NameIsValid(const char *name);
/* Returns whether a text is names with dots between them. */
PetscBool PathIsValid(const char *path);
/* ---- entries.c */
/* Copies the next item of a comma list into `item`, without blanks around it. Returns the rest of the list,
   NULL after the last item. */
const char *NextItem(const char *list, char item[LABEL_LENGTH]);

/* entries.h: a scene as a flat, ordered list of keys and values, from YAML text and from the command line.
   `materials: {dam: {density: 2400}}` gives the entries "materials", "materials.dam" (sections) and
   "materials.dam.density" = "2400". On the command line a key is written with _ for every dot. */
#pragma once
#include "scene/scene.h"

typedef enum { ENTRY_VALUE, ENTRY_LIST, ENTRY_SECTION } EntryKind; /* a list is joined by commas */

typedef struct {
  char *key;
  char *value;
  EntryKind kind;
  int line;        /* in the scene file; 0: command line */
  PetscInt next;   /* entry of the same slot, -1: none */
  PetscBool used;  /* somebody asked for it */
  PetscBool loose; /* of the command line, and no key of the file: it may mean several dotted keys */
} Entry;

typedef struct {
  PetscInt n, capacity, n_slots;
  Entry *entries;
  PetscInt *slot; /* (n_slots,) first entry by hash of its key, -1: none */
} Entries;

/* message: receives the first fault found in the text or among the arguments; file: for messages */
PetscErrorCode EntriesReadYAML(Entries *list, const char *file, const char *text, size_t length,
                               char *message);
PetscErrorCode EntriesReadArguments(Entries *list, int argc, char **argv, char *message);
/* After these: options that PETSc took from elsewhere (PETSC_OPTIONS, PETSC_OPTIONS_YAML,
   -options_file_yaml) may be its own only. A scene is what its file and its command line say. */
PetscErrorCode EntriesCheckElsewhere(char *message);
/* The entry with this dotted key, else one of the command line that may mean it; NULL if there is none. Does
   not mark it as used. */
Entry *EntriesFind(const Entries *list, const char *key);
/* The section of the file that a key of the command line may mean; NULL: none. */
Entry *EntriesFindSection(const Entries *list, const char *key);
/* A line "key value" for each value and list, with dotted keys; free with free(). */
PetscErrorCode EntriesText(const Entries *list, char **text);
PetscErrorCode EntriesDestroy(Entries *list);

/* True for [A-Za-z][A-Za-z0-9_+-]*, at most 63 characters. */
PetscBool NameIsValid(const char *name);
/* Copies the next item of a comma list into `item`, without blanks around it; returns the
   rest, NULL after the last. */
const char *NextItem(const char *list, char item[LABEL_LENGTH]);

/* what_if.c: reads the section `what_if`, whose items change keys of the scene, for the sheet alone. The
   solver checks that the keys are there and echoes the changes; quoin report makes a scene of each item and
   runs it. Local to the rank. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <string.h>

#define DEFAULT_JOINT "joints.default."

/* Returns a copy of the keys that the reader has asked for, which are those that the scene can have: n bytes,
   a zero behind each. Free it with PetscFree. */
static PetscErrorCode known_keys(Reader *r, SegmentCount *n, char **known)
{
  char *again;

  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferGetSize(r->asked, n));
  PetscCall(PetscSegBufferExtractAlloc(r->asked, known));
  PetscCall(PetscSegBufferGet(r->asked, *n, &again));
  PetscCall(PetscArraycpy(again, *known, *n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool is_known(const char *known, SegmentCount n, const char *key)
{
  for (const char *k = known; k < known + n; k += strlen(k) + 1)
    if (!strcmp(k, key)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Echoes a change of a key of joints.default for the joints too that have this key from there, as the echo
   gives it in each of their rows. path: what_if.<name>; key: of joints.default. */
static PetscErrorCode echo_heirs(Reader *r, const char *path, const char *key, const Entry *change)
{
  char row[LABEL_LENGTH], own[2 * LABEL_LENGTH];

  PetscFunctionBeginUser;
  for (PetscInt j = 1; j < r->scene->n_joints; j++) {
    snprintf(row, sizeof row, "joints.%s.%s", r->scene->joints[j].name, key);
    snprintf(own, sizeof own, "%s.%s", path, row);
    if (!EntriesFind(&r->entries, row) && !EntriesFind(&r->entries, own))
      PetscCall(EchoChange(r, row, change));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the changes of an item. path: what_if.<name>; known: n bytes of known_keys. */
static PetscErrorCode read_changes(Reader *r, const char *path, const char *known, SegmentCount n)
{
  const size_t length = strlen(path);
  const int line = r->line;
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (Entry *e = r->entries.entries; e < r->entries.entries + r->entries.n; e++) {
    if (strncmp(e->key, path, length) || e->key[length] != '.') continue;
    const char *key = e->key + length + 1;
    e->used = PETSC_TRUE;
    if (e->kind == ENTRY_SECTION) continue;
    snprintf(r->label, sizeof r->label, "%s", e->key);
    r->line = e->line;
    if (!is_known(known, n, key)) COMPLAIN(r, "the scene has no key or row %s", key);
    if (!e->value[0]) COMPLAIN(r, "no value given");
    PetscCall(EchoChange(r, key, e));
    if (!strncmp(key, DEFAULT_JOINT, strlen(DEFAULT_JOINT)))
      PetscCall(echo_heirs(r, path, key + strlen(DEFAULT_JOINT), e));
    any = PETSC_TRUE;
  }
  snprintf(r->label, sizeof r->label, "%s", path);
  r->line = line;
  if (!any)
    COMPLAIN(
        r,
        "changes no key; expected keys of the scene and their values, such as joints.base.cohesion: x 0.5");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ReadWhatIf(Reader *r)
{
  char path[LABEL_LENGTH], *known;
  SegmentCount bytes;
  PetscInt n;
  Name *names;

  PetscFunctionBeginUser;
  PetscCall(AskNames(r, "what_if", &n, &names));
  PetscCall(known_keys(r, &bytes, &known));
  if (n) PetscCall(EchoSection(r, 0, "what_if"));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(AskSection(r, "what_if", names[i].name, path));
    PetscCall(EchoSection(r, 2, names[i].name));
    PetscCall(read_changes(r, path, known, bytes));
  }
  PetscCall(PetscFree(known));
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* echo.c: writes the scene with the value of every key, scene_echo.yaml in the output folder, which is a
   scene itself. Values are copied as the user wrote them, so they read back to the same bits. A default that
   the table of keys says in words ("= none") becomes a comment. Local to the rank. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// Appends text to the echo, as printf does.
static PetscErrorCode append(Reader *r, const char *format, ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
static PetscErrorCode append(Reader *r, const char *format, ...)
{
  va_list arguments;
  char some[256], *text = some, *kept;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  const int length = vsnprintf(some, sizeof some, format, arguments);
  va_end(arguments);
  if (length >= (int)sizeof some) {
    PetscCall(PetscMalloc1(length + 1, &text));
    va_start(arguments, format);
    vsnprintf(text, length + 1, format, arguments);
    va_end(arguments);
  }
  PetscCall(PetscSegBufferGet(r->echo, length, &kept));
  PetscCall(PetscArraycpy(kept, text, length));
  if (text != some) PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

// Appends text between double quotes, by the rules of YAML.
static PetscErrorCode append_quoted(Reader *r, const char *text)
{
  PetscFunctionBeginUser;
  PetscCall(append(r, "\""));
  for (const char *c = text; *c; c++) {
    if (iscntrl((unsigned char)*c))
      PetscCall(append(r, "\\x%02x", (unsigned char)*c));
    else
      PetscCall(append(r, "%s%c", *c == '"' || *c == '\\' ? "\\" : "", *c));
  }
  PetscCall(append(r, "\""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode append_value(Reader *r, KeyType type, const char *text)
{
  PetscFunctionBeginUser;
  switch (type) {
  case TYPE_TITLE:
  case TYPE_PATH:
  case TYPE_MOTION:
    PetscCall(append_quoted(r, text));
    break;
  case TYPE_PAIR:
  case TYPE_NUMBERS:
  case TYPE_NAMES:
  case TYPE_LOADS:
    PetscCall(append(r, "[%s]", text));
    break;
  case TYPE_BOOL:
  case TYPE_TRISTATE:
    PetscCall(append(r, "%s", text[0] ? text : "true")); // the key was given without a value
    break;
  default:
    PetscCall(append(r, "%s", text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EchoSection(Reader *r, int indent, const char *name)
{
  PetscFunctionBeginUser;
  PetscCall(append(r, "%*s%s:\n", indent, "", name));
  r->echo_indent = indent + 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EchoKey(Reader *r, const Key *key, const Entry *entry)
{
  const PetscBool is_apart = (PetscBool)(key->section == SECTION_TOP &&
                                         (!strcmp(key->name, "model") || !strcmp(key->name, "restart")));
  const char *text = entry ? entry->value : key->preset;
  const char *unit = strcmp(key->unit, "-") ? key->unit : "";
  const char *source = !entry ? "default" : !entry->line ? "command line" : "";

  PetscFunctionBeginUser;
  // Some keys are left out. A required key without a value has been complained about; EchoEnd writes where
  // the model lies, which is known later; and a restart does not belong to the scene.
  if (!text || is_apart) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(append(r, "%*s", r->echo_indent, ""));
  if (!entry && (!text[0] || text[0] == '=')) {
    PetscCall(append(r, "# %s: %s\n", key->name, text[0] ? text + 2 : "none"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(append(r, "%s: ", key->name));
  PetscCall(append_value(r, key->type, text));
  if (unit[0] || source[0])
    PetscCall(append(r, "  # %s%s%s", unit, unit[0] && source[0] ? ", " : "", source));
  PetscCall(append(r, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EchoChange(Reader *r, const char *key, const Entry *entry)
{
  PetscFunctionBeginUser;
  PetscCall(append(r, "%*s%s: ", r->echo_indent, "", key));
  if (entry->kind == ENTRY_LIST)
    PetscCall(append(r, "[%s]", entry->value));
  else
    PetscCall(append_quoted(r, entry->value));
  PetscCall(append(r, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EchoEnd(Reader *r, char **text)
{
  PetscSegBuffer keys = r->echo;
  SegmentCount head, length;

  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferGetSize(keys, &length));
  PetscCall(PetscSegBufferCreate(1, 4096, &r->echo));
  PetscCall(append(r, "# Quoin %s: the scene of a run, every key in force, from the file ", QUOIN_VERSION));
  PetscCall(append_quoted(r, r->scene->file));
  PetscCall(append(r, " and the command line.\n# It is a scene again. \"default\", and keys in comments: "
                      "given by nobody.\nmodel: "));
  PetscCall(append_quoted(r, r->scene->model));
  PetscCall(append(r, "\n"));
  PetscCall(PetscSegBufferGetSize(r->echo, &head));
  PetscCall(PetscMalloc1(head + length + 1, text));
  PetscCall(PetscSegBufferExtractTo(r->echo, *text));
  PetscCall(PetscSegBufferExtractTo(keys, *text + head));
  (*text)[head + length] = '\0';
  PetscCall(PetscSegBufferDestroy(&r->echo));
  PetscCall(PetscSegBufferDestroy(&keys));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* json.c: writes JSON with its commas and line ends, and answers questions for single numbers by their paths
   while it writes, such as joints.base.N. */
#include "base/base.h"
#include <stdlib.h>
#include <string.h>

enum { LINES = 3 }; /* up to this level each member has a line; below it only objects and lists have one */

PetscErrorCode JsonToMemory(Json *json, int level, char **text)
{
  PetscFunctionBeginUser;
  *json = (Json){.level = level};
  json->file = open_memstream(text, &json->size);
  PetscCheck(json->file, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JsonEnd(Json *json)
{
  PetscFunctionBeginUser;
  PetscCheck(!fclose(json->file), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void new_line(const Json *json)
{
  fprintf(json->file, "\n%*s", 2 * json->level, "");
}

static void put_string(FILE *f, const char *text)
{
  fputc('"', f);
  for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
    if (*c == '"' || *c == '\\')
      fprintf(f, "\\%c", *c);
    else if (*c < 0x20)
      fprintf(f, "\\u%04x", *c);
    else
      fputc(*c, f);
  }
  fputc('"', f);
}

static void open_with(Json *json, const char *name, char first, char last);

/* Writes everything before the value of a member, and notes its path. Returns whether to write the value. */
static PetscBool begin(Json *json, const char *name, PetscBool has_line)
{
  const char *waiting = json->waiting;
  json->waiting = NULL;
  if (waiting) open_with(json, waiting, '{', '}');
  if (json->n_asked && name) {
    const size_t end = json->end[json->level];
    snprintf(json->path + end, sizeof(json->path) - end, "%s%s", end ? "." : "", name);
  }
  if (!json->file) return PETSC_FALSE;
  if (json->has_member) fputc(',', json->file);
  if (json->last[json->level] && (has_line || json->level <= LINES))
    new_line(json);
  else if (json->has_member)
    fputc(' ', json->file);
  if (name) put_string(json->file, name), fputs(": ", json->file);
  json->has_member = PETSC_TRUE;
  return PETSC_TRUE;
}

static void open_with(Json *json, const char *name, char first, char last)
{
  if (begin(json, name, PETSC_TRUE)) fputc(first, json->file);
  json->last[++json->level] = last;
  json->end[json->level] = json->n_asked ? strlen(json->path) : 0;
  json->lists += last == ']';
  json->has_member = PETSC_FALSE;
}

void JsonOpen(Json *json, const char *name)
{
  open_with(json, name, '{', '}');
}

void JsonOpenLater(Json *json, const char *name)
{
  json->waiting = name;
}

void JsonList(Json *json, const char *name)
{
  open_with(json, name, '[', ']');
}

void JsonClose(Json *json)
{
  if (json->waiting) {
    json->waiting = NULL;
    return;
  }
  const char last = json->last[json->level--];
  json->lists -= last == ']';
  if (json->file && json->has_member && json->level <= LINES) new_line(json);
  if (json->file) fputc(last, json->file);
  json->has_member = PETSC_TRUE;
}

void JsonValue(Json *json, const char *name, const char *value)
{
  if (begin(json, name, (PetscBool)(value[0] == '{'))) fputs(value, json->file);
}

void JsonText(Json *json, const char *name, const char *value)
{
  if (begin(json, name, PETSC_FALSE)) put_string(json->file, value);
}

void JsonHex(Json *json, const char *name, int digits, uint64_t value)
{
  if (begin(json, name, PETSC_FALSE)) fprintf(json->file, "\"%0*llx\"", digits, (unsigned long long)value);
}

/* Answers the questions for this number. */
static void answer(const Json *json, PetscReal value)
{
  for (PetscInt i = 0; i < json->n_asked && !json->lists; i++)
    if (!strcmp(json->asked[i], json->path)) json->answers[i] = value;
}

void JsonNumber(Json *json, const char *name, PetscReal value)
{
  const PetscBool writes = begin(json, name, PETSC_FALSE);
  answer(json, isfinite(value) ? value : NAN);
  if (writes && isfinite(value))
    fprintf(json->file, "%.17g", value);
  else if (writes)
    fputs("null", json->file);
}

void JsonPairs(Json *json, size_t n, const JsonPair *pairs)
{
  for (size_t i = 0; i < n; i++) JsonNumber(json, pairs[i].name, pairs[i].value);
}

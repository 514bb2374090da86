/* schema.c: prints the table of keys as a JSON Schema (draft 7) for -schema, by which editors complete and
   check a scene. A value with a unit is text in YAML: its unit is checked, its range is not. */
#include "scene/scene.h"
#include "scene/keys.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAME_PATTERN "[A-Za-z][A-Za-z0-9_+-]{0,62}"
#define LARGEST "1.7976931348623157e308"

static void put_text(FILE *f, const char *text)
{
  fputc('"', f);
  for (const char *c = text; *c; c++) fprintf(f, *c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
  fputc('"', f);
}

/* ---- one value */

/* Writes "minimum": 0, ...: the range, and that a number is finite. */
static void put_range(FILE *f, const Key *key)
{
  const char *range = key->range;
  PetscBool low = PETSC_FALSE, high = (PetscBool)(key->type == TYPE_LIMIT);
  while (range && *range) {
    const char side = *range++;
    const PetscBool equal = (PetscBool)(*range == '=');
    range += equal;
    range += strspn(range, " ");
    const size_t length = strcspn(range, ", ");
    fprintf(f, ", \"%s%s\": %.*s", equal ? "m" : "exclusiveM", side == '>' ? "inimum" : "aximum", (int)length,
            range);
    *(side == '>' ? &low : &high) = PETSC_TRUE;
    range += length;
    range += strspn(range, ", ");
  }
  if (!low) fprintf(f, ", \"minimum\": %s", key->type == TYPE_INT ? "-1e9" : "-" LARGEST);
  if (!high) fprintf(f, ", \"maximum\": %s", key->type == TYPE_INT ? "1e9" : LARGEST);
}

/* Writes that a value is a number, or text that is one with a unit of the key. */
static void put_number(FILE *f, const Key *key)
{
  const PetscBool positive = (PetscBool)(key->range && key->range[0] == '>' &&
                                         strtod(key->range + 1 + strspn(key->range + 1, "= "), NULL) >= 0.);
  const char *before = "( *(";
  fprintf(f, "{\"anyOf\": [{\"type\": \"%s\"", key->type == TYPE_INT ? "integer" : "number");
  put_range(f, key);
  fprintf(f, "}, {\"type\": \"string\", \"pattern\": \"^%s([0-9]+\\\\.?[0-9]*|\\\\.[0-9]+)([eE][-+]?[0-9]+)?",
          positive ? "\\\\+?" : "[-+]?");
  for (int i = 0; UnitOf(key, i); i++, before = "|") fprintf(f, "%s%s", before, UnitOf(key, i));
  fprintf(f, "%s$\"}", UnitOf(key, 0) ? "))?" : "");
  if (key->type == TYPE_LIMIT) fprintf(f, ", {\"enum\": [\"inf\", \".inf\"]}");
  if (key->word) fprintf(f, ", {\"const\": \"%s\"}", key->word);
  fprintf(f, "]}");
}

/* Writes that a value is a list of `least` to `most` items, or text with commas between them. */
static void put_list(FILE *f, const Key *key, int least, int most)
{
  const PetscBool names = (PetscBool)(key->type == TYPE_NAMES || key->type == TYPE_LOADS);
  fprintf(f, "{\"anyOf\": [{\"type\": \"array\", \"minItems\": %d", least);
  if (most) fprintf(f, ", \"maxItems\": %d", most);
  if (names) fprintf(f, ", \"uniqueItems\": true");
  fprintf(f, ", \"items\": ");
  if (names)
    fprintf(f, "{\"type\": \"string\", \"pattern\": \"^" NAME_PATTERN "$\"}");
  else
    put_number(f, key);
  fprintf(f, "}, ");
  if (names)
    fprintf(f, "{\"type\": \"string\", \"pattern\": \"^" NAME_PATTERN "( *, *" NAME_PATTERN ")*$\"}");
  else if (most)
    fprintf(f, "{\"type\": \"string\", \"pattern\": \"^[^,]+,[^,]+$\"}");
  else
    put_number(f, key);
  fprintf(f, "]}");
}

static PetscBool is_truth(const char *text)
{
  return (PetscBool)(!strcmp(text, "true") || !strcmp(text, "false"));
}

/* Writes the words of a choice; true and false among them are no text. */
static void put_choices(FILE *f, const char *const *choices)
{
  fprintf(f, "{\"enum\": [");
  for (int i = 0; choices[i + 2]; i++) {
    const char *quote = is_truth(choices[i]) ? "" : "\"";
    fprintf(f, "%s%s%s%s", i ? ", " : "", quote, choices[i], quote);
  }
  fprintf(f, "]}");
}

static void put_type(FILE *f, const Key *key)
{
  switch (key->type) {
  case TYPE_TITLE:
    fprintf(f, "{\"type\": [\"string\", \"number\", \"boolean\", \"null\"], \"maxLength\": %d}",
            (int)sizeof(((Scene *)NULL)->title) - 1);
    break;
  case TYPE_PATH:
    fprintf(f, "{\"type\": [\"string\", \"number\", \"boolean\"], \"minLength\": 1, \"maxLength\": %d}",
            PETSC_MAX_PATH_LEN - 1);
    break;
  case TYPE_MOTION:
    fprintf(f, "{\"type\": [\"string\", \"array\"], \"minLength\": 1, \"items\": {\"type\": \"string\"}}");
    break;
  case TYPE_NAME:
    fprintf(f, "{\"type\": \"string\", \"pattern\": \"^" NAME_PATTERN "$\"}");
    break;
  case TYPE_REAL:
  case TYPE_LIMIT:
  case TYPE_INT:
    put_number(f, key);
    break;
  case TYPE_BOOL:
  case TYPE_TRISTATE:
    fprintf(f, "{\"enum\": [true, false, \"yes\", \"no\", \"on\", \"off\", 1, 0]}");
    break;
  case TYPE_CHOICE:
    put_choices(f, key->choices);
    break;
  case TYPE_FIX:
    fprintf(f, "{\"enum\": [\"x\", \"y\", \"xy\"]}");
    break;
  case TYPE_PAIR:
    put_list(f, key, 2, 2);
    break;
  case TYPE_NUMBERS:
  case TYPE_NAMES:
    put_list(f, key, 1, 0);
    break;
  case TYPE_LOADS:
    put_list(f, key, 0, 0);
    break;
  case TYPE_CHANGES:
    if (key->section == SECTION_TOP) {
      fprintf(f, "{\"type\": [\"object\", \"array\"], \"propertyNames\": {\"pattern\": \"^" NAME_PATTERN
                 "$\"}, \"additionalProperties\": {\"type\": \"object\", \"minProperties\": 1}}");
      break;
    }
    fprintf(f, "{\"$ref\": \"#/definitions/names of joints\"}");
    break;
  }
}

/* Writes a default as JSON has it: numbers and words of truth are no text. */
static void put_default(FILE *f, const char *preset)
{
  char *end;
  (void)strtod(preset, &end);
  const PetscBool number = (PetscBool)(!*end && strspn(preset, "-0123456789") > 0);
  if (number || is_truth(preset))
    fputs(preset, f);
  else
    put_text(f, preset);
}

/* Writes "key": {what it may be, what it means}. */
static void put_key(FILE *f, const Key *key)
{
  char name[LABEL_LENGTH], help[2 * MESSAGE_LENGTH];
  snprintf(name, sizeof name, "%.*s", (int)strcspn(key->name, "."),
           key->name); // of joints.<name> its section
  snprintf(help, sizeof help, "%s%s%s%s", key->help, key->unit[0] ? " [" : "", key->unit,
           key->unit[0] ? "]" : "");
  put_text(f, name);
  fprintf(f, ": {\"description\": ");
  put_text(f, help);
  if (key->preset && key->preset[0] && key->preset[0] != '=') {
    fprintf(f, ", \"default\": ");
    put_default(f, key->preset);
  }
  fprintf(f, ", \"allOf\": [");
  put_type(f, key);
  fprintf(f, "]}");
}

/* ---- keys that belong together */

/* Returns whether a row belongs to the section, and there to the type; type -1: of sections without types. */
static PetscBool is_row(const Key *key, Section section, int type)
{
  const int bits = section == SECTION_STAGES ? key->stages : key->loads;
  return (PetscBool)(key->section == section && (type < 0 || !bits || bits & BIT(type)));
}

/* Writes the members of an object that has the keys of some sections and no others. required: say which must
   be there. */
static void put_keys(FILE *f, int n, const Section *sections, int type, PetscBool required)
{
  const char *before = "";
  fprintf(f, "\"properties\": {");
  for (int s = 0; s < n; s++)
    for (const Key *key = Keys; key < Keys + KEYS; key++) {
      if (!is_row(key, sections[s], type)) continue;
      fprintf(f, "%s\n  ", before);
      put_key(f, key);
      before = ",";
    }
  fprintf(f, "}, \"additionalProperties\": false");
  before = ", \"required\": [";
  for (const Key *key = Keys; key < Keys + KEYS && required; key++)
    if (is_row(key, sections[0], type) && !key->preset)
      fprintf(f, "%s\"%s\"", before, key->name), before = ", ";
  if (before[2] != '"') fprintf(f, "]");
}

/* Writes the keys of a load or a stage: which ones depends on its type. A stage without type is static. */
static void put_typed(FILE *f, Section section, const char *const *types)
{
  fprintf(f, "{\"type\": \"object\", \"properties\": {\"type\": ");
  put_choices(f, types);
  fprintf(f, "}%s, \"allOf\": [", section == SECTION_LOADS ? ", \"required\": [\"type\"]" : "");
  for (int type = 0; types[type + 2]; type++) {
    fprintf(f, "%s\n {\"if\": {\"properties\": {\"type\": {\"const\": \"%s\"}}%s}, \"then\": {",
            type ? "," : "", types[type],
            section == SECTION_STAGES && type == STAGE_STATIC ? "" : ", \"required\": [\"type\"]");
    put_keys(f, 1, &section, type, PETSC_TRUE);
    fprintf(f, "}}");
  }
  fprintf(f, "]}");
}

/* Returns the word of a section: of "materials.<name>." it is materials. */
static const char *word_of(Section section, char word[NAME_LENGTH])
{
  snprintf(word, NAME_LENGTH, "%.*s", (int)strcspn(SectionPaths[section], "."), SectionPaths[section]);
  return word;
}

static PetscBool has_names(Section section)
{
  return (PetscBool)(strstr(SectionPaths[section], "<name>") != NULL);
}

/* Writes the definitions of the entries of sections with names, and of these sections: a mapping, or a list
   in order. */
static void put_definitions(FILE *f)
{
  char word[NAME_LENGTH];
  const char *before = "";
  fprintf(f, "\"definitions\": {");
  for (Section s = SECTION_TOP; s < SECTIONS; s++) {
    if (!has_names(s)) continue;
    fprintf(f, "%s\n\"%s\": ", before, word_of(s, word));
    if (s == SECTION_LOADS)
      put_typed(f, s, LoadTypes);
    else if (s == SECTION_STAGES)
      put_typed(f, s, StageTypes);
    else {
      fprintf(f, "{\"type\": \"object\", ");
      put_keys(f, 1, &s, -1, (PetscBool)(s != SECTION_JOINTS)); // another row, or the mesh, may have them
      fprintf(f, "}");
    }
    fprintf(
        f,
        ",\n\"names of %s\": {\"anyOf\": [{\"type\": \"object\", \"propertyNames\": {\"pattern\": "
        "\"^" NAME_PATTERN "$\"}, \"additionalProperties\": {\"$ref\": \"#/definitions/%s\"}}, "
        "{\"type\": \"array\", \"items\": {\"type\": \"object\", \"minProperties\": 1, \"maxProperties\": 1, "
        "\"propertyNames\": {\"pattern\": \"^" NAME_PATTERN "$\"}, \"additionalProperties\": "
        "{\"$ref\": \"#/definitions/%s\"}}}]}",
        word, word, word);
    before = ",";
  }
  fprintf(f, "\n}");
}

/* Writes the sections without names: a member each; of two with one word the keys of both. */
static void put_sections(FILE *f)
{
  char word[NAME_LENGTH];
  for (Section s = SECTION_CONTACT; s < SECTIONS; s++) {
    if (s == SECTION_STAGE_DEFAULTS) continue; // with SECTION_RELAXATION
    fprintf(f, ",\n\"%s\": ", word_of(s, word));
    if (has_names(s)) {
      fprintf(f, "{\"$ref\": \"#/definitions/names of %s\"}", word);
      continue;
    }
    const Section both[2] = {s, SECTION_STAGE_DEFAULTS};
    fprintf(f, "{\"type\": \"object\", ");
    put_keys(f, s == SECTION_RELAXATION ? 2 : 1, both, -1, PETSC_FALSE);
    fprintf(f, "}");
  }
}

PetscErrorCode SceneSchema(MPI_Comm comm)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  FILE *f = stdout;
  fprintf(f, "{\"$schema\": \"http://json-schema.org/draft-07/schema#\",\n\"title\": \"Scene of Quoin\",\n"
             "\"type\": \"object\", \"required\": [\"model\", \"materials\", \"stages\"], "
             "\"additionalProperties\": false,\n\"properties\": {");
  const char *before = "";
  for (const Key *key = Keys; key < Keys + KEYS; key++) {
    if (key->section != SECTION_TOP) continue;
    fprintf(f, "%s\n", before);
    put_key(f, key);
    before = ",";
  }
  put_sections(f);
  fprintf(f, "},\n");
  put_definitions(f);
  fprintf(f, "}\n");
  fflush(f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

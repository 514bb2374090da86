/* units.c: reads values with units. A number with a unit becomes a number in the unit of the key, in the list
   of entries and before anything else reads it, so that all later text, also scene_echo.yaml, has plain
   numbers. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WEIGHT = -1 }; /* in place of a factor: of gravity */

/* text 1 = factor 10^power of a key in the unit `of`. Powers of ten move the decimal point, so that 12 GPa
   has the bits of 12e9. */
static const struct {
  const char *text, *of;
  int power;
  double factor;
} Units[] = {{"kPa", "Pa", 3, 1.},
             {"MPa", "Pa", 6, 1.},
             {"GPa", "Pa", 9, 1.},
             {"N/m2", "Pa", 0, 1.},
             {"kN/m2", "Pa", 3, 1.},
             {"MN/m2", "Pa", 6, 1.},
             {"N/mm2", "Pa", 6, 1.},
             {"bar", "Pa", 5, 1.},
             {"kPa/m", "Pa/m", 3, 1.},
             {"MPa/m", "Pa/m", 6, 1.},
             {"GPa/m", "Pa/m", 9, 1.},
             {"MPa/mm", "Pa/m", 9, 1.},
             {"N/m3", "Pa/m", 0, 1.},
             {"kN/m3", "Pa/m", 3, 1.},
             {"MN/m3", "Pa/m", 6, 1.},
             {"GN/m3", "Pa/m", 9, 1.},
             {"N/mm3", "Pa/m", 9, 1.},
             {"t/m3", "kg/m3", 3, 1.},
             {"g/cm3", "kg/m3", 3, 1.},
             {"N/m3", "kg/m3", 0, WEIGHT},
             {"kN/m3", "kg/m3", 3, WEIGHT},
             {"kN", "N", 3, 1.},
             {"MN", "N", 6, 1.},
             {"kN/m", "N/m", 3, 1.},
             {"MN/m", "N/m", 6, 1.},
             {"N/mm", "N/m", 3, 1.},
             {"J/m2", "N/m", 0, 1.},
             {"kN/m2", "N/m2", 3, 1.},
             {"MN/m2", "N/m2", 6, 1.},
             {"GN/m2", "N/m2", 9, 1.},
             {"Pa", "N/m2", 0, 1.},
             {"MPa", "N/m2", 6, 1.},
             {"GPa", "N/m2", 9, 1.},
             {"um", "m", -6, 1.},
             {"mm", "m", -3, 1.},
             {"cm", "m", -2, 1.},
             {"km", "m", 3, 1.},
             {"mm2", "m2", -6, 1.},
             {"cm2", "m2", -4, 1.},
             {"deg", "degree", 0, 1.},
             {"degrees", "degree", 0, 1.},
             {"°", "degree", 0, 1.},
             {"rad", "degree", 0, 180. / PETSC_PI},
             {"ms", "s", -3, 1.},
             {"min", "s", 0, 60.},
             {"h", "s", 0, 3600.},
             {"d", "s", 0, 86400.},
             {"h", "min", 0, 60.},
             {"kHz", "Hz", 3, 1.},
             {"mm/s", "m/s", -3, 1.},
             {"cm/s", "m/s", -2, 1.},
             {"km/h", "m/s", 0, 1. / 3.6},
             {"cm/s2", "m/s2", -2, 1.},
             {"g", "m/s2", 0, 9.80665},
             {"C", "K", 0, 1.},
             {"°C", "K", 0, 1.},
             {"1/C", "1/K", 0, 1.},
             {"1/°C", "1/K", 0, 1.},
             {"mPa s", "Pa s", -3, 1.},
             {"%", "-", -2, 1.},
             {"MB", "GB", -3, 1.}};
enum { UNITS = sizeof Units / sizeof Units[0] };

/* Decides whether a text is a unit of any key. */
static PetscBool is_unit(const char *text)
{
  for (int i = 0; i < UNITS; i++)
    if (!strcmp(text, Units[i].text) || !strcmp(text, Units[i].of)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Whether values of these keys may carry units. */
static const PetscBool Takes[TYPE_CHANGES + 1] = {[TYPE_REAL] = PETSC_TRUE,
                                                  [TYPE_LIMIT] = PETSC_TRUE,
                                                  [TYPE_INT] = PETSC_TRUE,
                                                  [TYPE_PAIR] = PETSC_TRUE,
                                                  [TYPE_NUMBERS] = PETSC_TRUE};

const char *UnitOf(const Key *key, int i)
{
  if (!Takes[key->type]) return NULL;
  if (is_unit(key->unit) && i-- == 0) return key->unit;
  for (int u = 0; u < UNITS; u++)
    if (!strcmp(key->unit, Units[u].of) && i-- == 0) return Units[u].text;
  return NULL;
}

/* Complains about a unit, and names the allowed units. */
static void complain(Reader *r, const Key *key, const char *item)
{
  char known[256];
  size_t used = (size_t)snprintf(known, sizeof known, "%s", key->unit);
  for (int i = 0; i < UNITS && used < sizeof known; i++)
    if (!strcmp(key->unit, Units[i].of))
      used += (size_t)snprintf(known + used, sizeof known - used, ", %s", Units[i].text);
  if (strstr(key->unit, " or "))
    COMPLAIN(r, "'%.60s': what it is depends on other keys, so it takes no unit: expected a number in %s",
             item, key->unit);
  else if (!key->unit[0] || !strcmp(key->unit, "cycles"))
    COMPLAIN(r, "'%.60s': it has no unit: expected a number", item);
  else
    COMPLAIN(r, "'%.60s' has another unit than this key: expected one of: %s", item, known);
}

/* Converts a number of a unit into the unit of the key. out: "" where there is no such unit. */
static void in_unit_of(Reader *r, const Key *key, const char *number, const char *unit,
                       char out[LABEL_LENGTH])
{
  const double g = (double)r->scene->gravity;
  const char *exponent = number + strcspn(number, "eE");
  int i = 0;
  out[0] = '\0';
  if (!strcmp(unit, key->unit)) snprintf(out, LABEL_LENGTH, "%s", number);
  while (i < UNITS && (strcmp(unit, Units[i].text) != 0 || strcmp(key->unit, Units[i].of) != 0)) i++;
  if (i == UNITS) return;
  if (Units[i].factor == WEIGHT && g == 0.)
    COMPLAIN(r, "a weight is no density where gravity is 0 [m/s2]: expected kg/m3 or t/m3");
  const long ten = exponent[0] ? strtol(exponent + 1, NULL, 10) : 0;
  const int power = Units[i].power + (int)PetscClipInterval(ten, -9999, 9999); // no number goes as far
  snprintf(out, LABEL_LENGTH, "%.*se%d", (int)(exponent - number), number, power);
  if (Units[i].factor == WEIGHT && g > 0.) snprintf(out, LABEL_LENGTH, "%.17g", strtod(out, NULL) / g);
  if (Units[i].factor > 0. && Units[i].factor != 1.)
    snprintf(out, LABEL_LENGTH, "%.17g", strtod(out, NULL) * Units[i].factor);
}

/* Splits a number with a unit of this key, of other keys, or with an unknown word: '12 gpa'. Returns the
   unit, NULL: the text has another form. */
static const char *unit_of(const Key *key, const char *item, char number[LABEL_LENGTH])
{
  size_t n = strspn(item, "0123456789+-.");
  char *end;
  if (n && (item[n] == 'e' || item[n] == 'E') && strspn(item + n + 1, "0123456789+-"))
    n += 1 + strspn(item + n + 1, "0123456789+-");
  const size_t blanks = strspn(item + n, " ");
  const char *unit = item + n + blanks;
  const PetscBool word = (PetscBool)(blanks && isalpha((unsigned char)unit[0]) && UnitOf(key, 0));
  snprintf(number, LABEL_LENGTH, "%.*s", (int)n, item);
  (void)strtod(number, &end);
  return n && !*end && (word || is_unit(unit)) ? unit : NULL;
}

static PetscBool any_unit(const Key *key, const char *value)
{
  char item[LABEL_LENGTH], number[LABEL_LENGTH];
  for (const char *rest = value; rest;) {
    rest = NextItem(rest, item);
    if (unit_of(key, item, number)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode TakeUnits(Reader *r, const Key *key, Entry *entry)
{
  char item[LABEL_LENGTH], number[LABEL_LENGTH], out[LABEL_LENGTH], *text;
  size_t used = 0, room = LABEL_LENGTH;

  PetscFunctionBeginUser;
  if (!Takes[key->type] || entry->kind == ENTRY_SECTION || !any_unit(key, entry->value))
    PetscFunctionReturn(PETSC_SUCCESS);
  for (const char *c = entry->value; *c; c++) room += *c == ',' ? LABEL_LENGTH : 0;
  PetscCall(PetscCalloc1(room, &text));
  for (const char *rest = entry->value; rest;) {
    rest = NextItem(rest, item);
    const char *unit = unit_of(key, item, number);
    snprintf(out, sizeof out, "%s", item);
    if (unit) in_unit_of(r, key, number, unit, out);
    if (!out[0]) complain(r, key, item);
    used += (size_t)snprintf(text + used, room - used, "%s%s", used ? "," : "", out[0] ? out : "0");
  }
  PetscCall(PetscFree(entry->value));
  entry->value = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

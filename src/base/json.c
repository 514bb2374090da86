/* json.c: writes members of a JSON object: a name, a value, and a tail. */
#include "base/base.h"

void JsonString(FILE *f, const char *text)
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

void JsonText(FILE *f, const char *name, const char *value, const char *tail)
{
  fprintf(f, "\"%s\": ", name);
  JsonString(f, value);
  fputs(tail, f);
}

void JsonNumber(FILE *f, const char *name, PetscReal value, const char *tail)
{
  if (isfinite(value))
    fprintf(f, "\"%s\": %.17g%s", name, value, tail);
  else
    fprintf(f, "\"%s\": null%s", name, tail);
}

void JsonCount(FILE *f, const char *name, long long value, const char *tail)
{
  fprintf(f, "\"%s\": %lld%s", name, value, tail);
}

/* peaks.c: keeps extremes of time series, and writes them into summary.json. */
#include "output/output.h"

void PeakTake(Peak *p, PetscReal value, PetscReal time)
{
  if (PetscIsNanReal(value)) return;
  if (PetscIsNanReal(p->first)) *p = (Peak){value, value, value, value, time, time};
  p->last = value;
  if (value < p->least) p->least = value, p->least_at = time;
  if (value > p->largest) p->largest = value, p->largest_at = time;
}

void PeakRange(FILE *f, const char *name, const Peak *p, const char *tail)
{
  fprintf(f, "\"%s\": {", name);
  JsonNumber(f, "least", p->least, ", ");
  JsonNumber(f, "time_least", p->least_at, ", ");
  JsonNumber(f, "largest", p->largest, ", ");
  JsonNumber(f, "time_largest", p->largest_at, "}");
  fputs(tail, f);
}

void PeakLargest(FILE *f, const char *name, const Peak *p, PetscBool ends, const char *tail)
{
  const PetscBool below = (PetscBool)(ends && -p->least > p->largest);
  fprintf(f, "\"%s\": {", name);
  if (ends) JsonNumber(f, "start", p->first, ", ");
  if (ends) JsonNumber(f, "end", p->last, ", ");
  JsonNumber(f, "largest", below ? p->least : p->largest, ", ");
  JsonNumber(f, "time", below ? p->least_at : p->largest_at, "}");
  fputs(tail, f);
}

void PeakLeast(FILE *f, const char *name, const Peak *p, const char *tail)
{
  fprintf(f, "\"%s\": {", name);
  JsonNumber(f, "least", p->least, ", ");
  JsonNumber(f, "time", p->least_at, "}");
  fputs(tail, f);
}

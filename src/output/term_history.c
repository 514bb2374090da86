/* term_history.c: writes the forces of anchors at the checks of a dynamic stage, and at the end of each
   other stage, into anchor_history.csv. The term decides on the columns (TermRecord): a row for each named
   object. */
#include "output/output.h"

PetscErrorCode TermHistorySample(const Problem *p)
{
  const TermView view = ViewOf(p);
  Histories *h = &p->output->histories;
  TermRecord *look = &h->things;
  PetscFunctionBeginUser;
  PetscCall(TermsRecord(&view, look));
  h->things_time = look->n_rows ? p->state->time : NAN;
  for (PetscInt i = 0; i < look->n_rows * look->n_columns && p->stage->kind == STAGE_DYNAMIC; i++)
    if (!PetscIsNanReal(look->values[i - i % look->n_columns]))
      PeakTake(h->things_peak + i, look->values[i], h->things_time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TermHistoryHeader(FILE *f)
{
  fprintf(f, "time_s,stage,anchor,force_N,largest_so_far_N,elongation_m,plastic_m,lost_J\n");
}

void TermHistoryRows(const Problem *p)
{
  Histories *h = &p->output->histories;
  const TermRecord *look = &h->things;
  FILE *f = p->output->files[TERM_HISTORY].file;
  if (!f || PetscIsNanReal(h->things_time)) return;
  for (PetscInt i = 0; i < look->n_rows; i++) {
    const PetscReal *row = look->values + i * look->n_columns;
    if (PetscIsNanReal(row[0])) continue;
    fprintf(f, "%.10g,%s,%s", h->things_time, p->stage->name, look->names[i]);
    for (PetscInt c = 0; c < look->n_columns; c++) fprintf(f, ",%.10g", row[c]);
    fprintf(f, "\n");
  }
  fflush(f);
  h->things_time = NAN;
}

void TermHistoryPeaks(FILE *f, const Problem *p)
{
  const Histories *h = &p->output->histories;
  const TermRecord *look = &h->things;
  const char *before = "";
  if (!look->n_rows) return;
  fprintf(f, "        \"anchors\": {");
  for (PetscInt i = 0; i < look->n_rows; i++) {
    const Peak *peak = h->things_peak + i * look->n_columns;
    if (PetscIsNanReal(peak->first)) continue;
    fprintf(f, "%s\n          ", before);
    JsonString(f, look->names[i]);
    fprintf(f, ": {");
    PeakRange(f, "force", peak, ", ");
    PeakRange(f, "elongation", peak + 2, "}");
    before = ",";
  }
  fprintf(f, "\n        },\n");
}

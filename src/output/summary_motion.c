/* summary_motion.c: writes how a model moves into summary.json: peaks of histories in time, bodies that left
   their places, hinges, and modes of vibration. Rank 0 only. */
#include "output/output.h"

/* ---- peaks

   Each function writes "name": {...} and what follows: the least and largest value with their times; the largest,
   where `ends` is true in size, beside the first and last value; the least alone. */

static void put_range(FILE *f, const char *name, const Peak *p, const char *tail)
{
  fprintf(f, "\"%s\": {", name);
  JsonNumber(f, "least", p->least, ", ");
  JsonNumber(f, "time_least", p->least_at, ", ");
  JsonNumber(f, "largest", p->largest, ", ");
  JsonNumber(f, "time_largest", p->largest_at, "}");
  fputs(tail, f);
}

static void put_largest(FILE *f, const char *name, const Peak *p, PetscBool ends, const char *tail)
{
  const PetscBool below = (PetscBool)(ends && -p->least > p->largest);
  fprintf(f, "\"%s\": {", name);
  if (ends) JsonNumber(f, "start", p->first, ", ");
  if (ends) JsonNumber(f, "end", p->last, ", ");
  JsonNumber(f, "largest", below ? p->least : p->largest, ", ");
  JsonNumber(f, "time", below ? p->least_at : p->largest_at, "}");
  fputs(tail, f);
}

static void put_least(FILE *f, const char *name, const Peak *p, const char *tail)
{
  fprintf(f, "\"%s\": {", name);
  JsonNumber(f, "least", p->least, ", ");
  JsonNumber(f, "time", p->least_at, "}");
  fputs(tail, f);
}

static void put_name(FILE *f, const char *name, PetscInt before)
{
  fprintf(f, "%s\n          ", before ? "," : "");
  JsonString(f, name);
  fprintf(f, ": {");
}

static void put_joints(FILE *f, const Problem *p)
{
  PetscInt n = 0;
  fprintf(f, "        \"joints\": {");
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    const Peak *peak = p->found->histories.joint_peak + CHECK_COLUMNS * j;
    if (PetscIsNanReal(peak[LOOK_LENGTH].first)) continue;
    put_name(f, p->scene->joints[j].name, n++);
    put_largest(f, "slip", peak + LOOK_SLIP, PETSC_TRUE, ",\n            ");
    put_largest(f, "slip_largest", peak + LOOK_SLIP_LARGEST, PETSC_TRUE, ",\n            ");
    put_largest(f, "opening", peak + LOOK_OPENING, PETSC_FALSE, ",\n            ");
    put_largest(f, "open_length", peak + LOOK_OPEN, PETSC_FALSE, ",\n            ");
    put_least(f, "factor_peak", peak + LOOK_FACTOR_PEAK, ",\n            ");
    put_least(f, "factor_residual", peak + LOOK_FACTOR_RESIDUAL, ",\n            ");
    put_range(f, "N", peak + LOOK_N, ",\n            ");
    put_range(f, "T", peak + LOOK_T, "}");
  }
  fprintf(f, "\n        },\n");
}

static void put_supports(FILE *f, const Problem *p)
{
  const Histories *h = &p->found->histories;
  fprintf(f, "        \"supports\": {");
  for (PetscInt i = 0; i < h->n_supports; i++) {
    put_name(f, p->scene->supports[i].name, i);
    for (int x = 0; x < 2; x++) put_range(f, x ? "y" : "x", h->support_peak + 2 * i + x, x ? "}" : ", ");
  }
  fprintf(f, "\n        },\n        \"base_shear\": {");
  for (int x = 0; x < 2; x++)
    put_range(f, x ? "y" : "x", h->support_peak + 2 * h->n_supports + x, x ? "},\n" : ", ");
}

static void put_probes(FILE *f, const Problem *p)
{
  static const char *const names[] = {"u_x", "u_y", "relative_x", "relative_y"};
  const Histories *h = &p->found->histories;
  const int n = p->found->ground_moves ? 4 : 2;
  fprintf(f, "        \"probes\": {");
  for (PetscInt i = 0; i < h->n_points; i++) {
    put_name(f, p->m->point_names[i], i);
    for (int k = 0; k < n; k++)
      put_range(f, names[k], h->probe_peak + 4 * i + k, k + 1 < n ? ",\n            " : "}");
  }
  fprintf(f, "\n        }\n");
}

static void put_anchors(FILE *f, const Problem *p)
{
  const Histories *h = &p->found->histories;
  const AnchorRecord *record = &h->things;
  const char *before = "";
  if (!record->n_rows) return;
  fprintf(f, "        \"anchors\": {");
  for (PetscInt i = 0; i < record->n_rows; i++) {
    const Peak *peak = h->things_peak + i * record->n_columns;
    if (PetscIsNanReal(peak->first)) continue;
    fprintf(f, "%s\n          ", before);
    JsonString(f, record->names[i]);
    fprintf(f, ": {");
    put_range(f, "force", peak, ", ");
    put_range(f, "elongation", peak + 2, "}");
    before = ",";
  }
  fprintf(f, "\n        },\n");
}

void SummaryPeaks(FILE *f, const Problem *p)
{
  if (!p->found->histories.support) return;
  fprintf(f, "      \"peaks\": {\n        "); // peaks at the checks; larger values between them are not seen
  JsonNumber(f, "sampled_every", p->found->histories.every, ",\n");
  put_joints(f, p);
  put_supports(f, p);
  put_anchors(f, p);
  put_probes(f, p);
  fprintf(f, "      },\n");
}

/* ---- bodies, hinges, modes */

void SummaryBodies(FILE *f, const Model *m, const BodyMotion *b)
{
  PetscBool any = PETSC_FALSE;
  fprintf(f, "      \"bodies\": [");
  for (PetscInt i = 0; i < b->n; i++) {
    const PetscReal *since = b->since + BODY_FATES * i;
    PetscReal first = INFINITY;
    for (int fate = 0; fate < BODY_FATES; fate++) first = PetscMin(first, since[fate]);
    if (!(first < INFINITY)) continue;
    fprintf(f, "%s\n        {", any ? "," : "");
    JsonCount(f, "macroblock", i, ", ");
    JsonText(f, "group", m->group_names[b->group[i]], ", ");
    JsonNumber(f, "x", b->centre[2 * i], ", ");
    JsonNumber(f, "y", b->centre[2 * i + 1], ", ");
    for (int fate = 0; fate < BODY_FATES; fate++) JsonNumber(f, FateWords[fate], since[fate], ", ");
    JsonNumber(f, "moved_x", b->moved[2 * i], ", ");
    JsonNumber(f, "moved_y", b->moved[2 * i + 1], ", ");
    JsonNumber(f, "turned", b->turned[i], "}");
    any = PETSC_TRUE;
  }
  fprintf(f, "%s],\n", any ? "\n      " : "");
}

void SummaryRocking(FILE *f, const RockingHinge *h)
{
  if (!h->n) return;
  fprintf(f, "      \"rocking_hinge\": {");
  JsonNumber(f, "missing", h->part, ", ");
  JsonCount(f, "macroblocks", h->n, ", ");
  JsonCount(f, "macroblock", h->body, ", ");
  JsonNumber(f, "x", h->point[0], ", ");
  JsonNumber(f, "y", h->point[1], "},\n");
}

void SummaryHinges(FILE *f, const Hinges *h)
{
  if (!h->n) return;
  fprintf(f, "\"hinges\": {");
  JsonCount(f, "n", h->n, ", ");
  JsonNumber(f, "least", h->least, ", ");
  if (!PetscIsNanReal(h->governing)) JsonNumber(f, "governing", h->governing, ", ");
  JsonNumber(f, "x", h->point[0], ", ");
  JsonNumber(f, "y", h->point[1], "},\n      ");
}

void SummaryVibration(FILE *f, const Vibration *v)
{
  fprintf(f, "      \"modes\": {");
  JsonNumber(f, "mass_x", v->moving[0], ", ");
  JsonNumber(f, "mass_y", v->moving[1], ", ");
  JsonNumber(f, "sum_x", VibrationPart(v, -1, 0), ", ");
  JsonNumber(f, "sum_y", VibrationPart(v, -1, 1), ", ");
  JsonCount(f, "missed", v->missed, ", ");
  JsonCount(f, "contacts", v->contacts[0], ", ");
  JsonCount(f, "open", v->contacts[1], ", ");
  JsonCount(f, "slipping", v->contacts[2], ", ");
  fprintf(f, "\"list\": [");
  for (PetscInt i = 0; i < v->n; i++) {
    const PetscReal hertz = VibrationHertz(v, i);
    fprintf(f, "%s\n        {", i ? "," : "");
    JsonNumber(f, "f", hertz, ", ");
    JsonNumber(f, "period", hertz > 0. ? 1. / hertz : NAN, ", ");
    JsonNumber(f, "omega2", v->omega2[i], ", ");
    JsonNumber(f, "modal_mass", v->mass[i], ", ");
    JsonNumber(f, "factor_x", v->factor[2 * i], ", ");
    JsonNumber(f, "factor_y", v->factor[2 * i + 1], ", ");
    JsonNumber(f, "mass_x", VibrationMass(v, i, 0), ", ");
    JsonNumber(f, "mass_y", VibrationMass(v, i, 1), v->reduced ? ", " : "}");
    if (v->reduced) JsonNumber(f, "too_high", v->error[i], "}");
  }
  fprintf(f, "]},\n");
}

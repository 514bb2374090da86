/* summary_motion.c: writes how a model moves into summary.json: peaks of histories in time, bodies that left
   their places, hinges, and modes of vibration. Rank 0 only. */
#include "output/output.h"

/* ---- peaks

   Each function writes an object: the least and largest value with their times; the largest, where `ends` is
   true in size, beside the first and last value; the least alone. */

static void put_range(Json *json, const char *name, const Peak *p)
{
  JsonObject(json, name, {"least", p->least}, {"time_least", p->least_at}, {"largest", p->largest},
             {"time_largest", p->largest_at});
}

static void put_largest(Json *json, const char *name, const Peak *p, PetscBool ends)
{
  const PetscBool below = (PetscBool)(ends && -p->least > p->largest);
  JsonOpen(json, name);
  if (ends) JsonNumber(json, "start", p->first);
  if (ends) JsonNumber(json, "end", p->last);
  JsonNumbers(json, {"largest", below ? p->least : p->largest},
              {"time", below ? p->least_at : p->largest_at});
  JsonClose(json);
}

static void put_least(Json *json, const char *name, const Peak *p)
{
  JsonObject(json, name, {"least", p->least}, {"time", p->least_at});
}

static void put_joints(Json *json, const Problem *p)
{
  JsonOpen(json, "joints");
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    const Peak *peak = p->found->histories.joint_peak + CHECK_COLUMNS * j;
    if (PetscIsNanReal(peak[CHECK_LENGTH].first)) continue;
    JsonOpen(json, p->scene->joints[j].name);
    put_largest(json, "slip", peak + CHECK_SLIP, PETSC_TRUE);
    put_largest(json, "slip_largest", peak + CHECK_SLIP_LARGEST, PETSC_TRUE);
    put_largest(json, "opening", peak + CHECK_OPENING, PETSC_FALSE);
    put_largest(json, "open_length", peak + CHECK_OPEN, PETSC_FALSE);
    put_least(json, "factor_peak", peak + CHECK_FACTOR_PEAK);
    put_least(json, "factor_residual", peak + CHECK_FACTOR_RESIDUAL);
    put_range(json, "N", peak + CHECK_N);
    put_range(json, "T", peak + CHECK_T);
    JsonClose(json);
  }
  JsonClose(json);
}

static void put_supports(Json *json, const Problem *p)
{
  const Histories *h = &p->found->histories;
  JsonOpen(json, "supports");
  for (PetscInt i = 0; i < h->n_supports; i++) {
    JsonOpen(json, p->scene->supports[i].name);
    for (int x = 0; x < 2; x++) put_range(json, x ? "y" : "x", h->support_peak + 2 * i + x);
    JsonClose(json);
  }
  JsonClose(json);
  JsonOpen(json, "base_shear");
  for (int x = 0; x < 2; x++) put_range(json, x ? "y" : "x", h->support_peak + 2 * h->n_supports + x);
  JsonClose(json);
}

static void put_probes(Json *json, const Problem *p)
{
  static const char *const names[] = {"u_x", "u_y", "relative_x", "relative_y"};
  const Histories *h = &p->found->histories;
  const int n = p->found->ground_moves ? 4 : 2;
  JsonOpen(json, "probes");
  for (PetscInt i = 0; i < h->n_points; i++) {
    JsonOpen(json, p->m->mesh.point_names[i]);
    for (int k = 0; k < n; k++) put_range(json, names[k], h->probe_peak + 4 * i + k);
    JsonClose(json);
  }
  JsonClose(json);
}

static void put_anchors(Json *json, const Problem *p)
{
  const Histories *h = &p->found->histories;
  const AnchorRecord *record = &h->things;
  if (!record->n_rows) return;
  JsonOpen(json, "anchors");
  for (PetscInt i = 0; i < record->n_rows; i++) {
    const Peak *peak = h->things_peak + i * record->n_columns;
    if (PetscIsNanReal(peak->first)) continue;
    JsonOpen(json, record->names[i]);
    put_range(json, "force", peak);
    put_range(json, "elongation", peak + 2);
    JsonClose(json);
  }
  JsonClose(json);
}

void SummaryPeaks(Json *json, const Problem *p)
{
  if (!p->found->histories.support) return;
  JsonOpen(json, "peaks"); // peaks at the checks; larger values between them are not seen
  JsonNumber(json, "sampled_every", p->found->histories.every);
  put_joints(json, p);
  put_supports(json, p);
  put_anchors(json, p);
  put_probes(json, p);
  JsonClose(json);
}

/* ---- bodies, hinges, modes */

void SummaryBodies(Json *json, const Model *m, const BodyMotion *b)
{
  JsonList(json, "bodies");
  for (PetscInt i = 0; i < b->n; i++) {
    const PetscReal *since = b->since + BODY_FATES * i;
    PetscReal first = INFINITY;
    for (int fate = 0; fate < BODY_FATES; fate++) first = PetscMin(first, since[fate]);
    if (!(first < INFINITY)) continue;
    JsonOpen(json, NULL);
    JsonNumber(json, "macroblock", i);
    JsonText(json, "group", m->materials.names[b->group[i]]);
    JsonNumbers(json, {"x", b->centre[2 * i]}, {"y", b->centre[2 * i + 1]});
    for (int fate = 0; fate < BODY_FATES; fate++) JsonNumber(json, FateWords[fate], since[fate]);
    JsonNumbers(json, {"moved_x", b->moved[2 * i]}, {"moved_y", b->moved[2 * i + 1]},
                {"turned", b->turned[i]});
    JsonClose(json);
  }
  JsonClose(json);
}

void SummaryRocking(Json *json, const RockingHinge *h)
{
  if (!h->n) return;
  JsonObject(json, "rocking_hinge", {"missing", h->part}, {"macroblocks", h->n}, {"macroblock", h->body},
             {"x", h->point[0]}, {"y", h->point[1]});
}

void SummaryHinges(Json *json, const Hinges *h)
{
  if (!h->n) return;
  JsonOpen(json, "hinges");
  JsonNumbers(json, {"n", h->n}, {"least", h->least});
  if (!PetscIsNanReal(h->governing)) JsonNumber(json, "governing", h->governing);
  JsonNumbers(json, {"x", h->point[0]}, {"y", h->point[1]});
  JsonClose(json);
}

void SummaryVibration(Json *json, const Vibration *v)
{
  JsonOpen(json, "modes");
  JsonNumbers(json, {"mass_x", v->moving[0]}, {"mass_y", v->moving[1]}, {"sum_x", VibrationPart(v, -1, 0)},
              {"sum_y", VibrationPart(v, -1, 1)}, {"missed", v->missed}, {"contacts", v->contacts[0]},
              {"open", v->contacts[1]}, {"slipping", v->contacts[2]});
  JsonList(json, "list");
  for (PetscInt i = 0; i < v->n; i++) {
    const PetscReal hertz = VibrationHertz(v, i);
    JsonOpen(json, NULL);
    JsonNumbers(json, {"f", hertz}, {"period", hertz > 0. ? 1. / hertz : NAN}, {"omega2", v->omega2[i]},
                {"modal_mass", v->mass[i]}, {"factor_x", v->factor[2 * i]},
                {"factor_y", v->factor[2 * i + 1]}, {"mass_x", VibrationMass(v, i, 0)},
                {"mass_y", VibrationMass(v, i, 1)});
    if (v->reduced) JsonNumber(json, "too_high", v->error[i]);
    JsonClose(json);
  }
  JsonClose(json);
  JsonClose(json);
}

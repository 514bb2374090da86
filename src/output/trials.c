/* trials.c: writes the results of the trials of a strength reduction, a flood, a load factor or a search for
   the force of anchors: an object per trial in summary.json (probes, open lengths, joints), the bracket, and
   the velocity field of the mechanism. */
#include "output/output.h"
#include <math.h>

static const char *const TrialWords[] = {"undecided", "stable", "fails", "fails", "undecided", "interrupted"};

/* Writes the displacements of the named points, from the gathered vertices. */
static void put_probes(FILE *f, const Model *m, const PetscReal *probes)
{
  fprintf(f, "\"probes\": {");
  for (PetscInt p = 0; p < m->n_points; p++) {
    fprintf(f, "%s\"%s\": {", p ? ", " : "", m->point_names[p]);
    JsonNumber(f, "u_x", probes[2 * p], ", ");
    JsonNumber(f, "u_y", probes[2 * p + 1], "}");
  }
  fprintf(f, "},\n");
}

/* Collective. Finds the displacements of the named points, (n_points,2) on all ranks; each point has one
   owner. */
static PetscErrorCode find_probes(const Model *m, const State *state, PetscReal *probes)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * m->n_points; i++) {
    const PetscInt v = m->point_vertex[i / 2];
    probes[i] = v >= 0 && v < m->n_owned ? Shown(state, 3 * m->n_bodies + 2 * v + i % 2) : PETSC_NINFINITY;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, probes, (PetscMPIInt)(2 * m->n_points), MPIU_REAL, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the levels of all waters of a flood [m]. */
static void put_waters(FILE *f, const Problem *p)
{
  const char *before = "";
  fprintf(f, "\"waters\": {");
  for (PetscInt i = 0; i < p->stage->n_loads; i++) {
    const Load *load = p->scene->loads + p->stage->loads[i];
    if (!LoadHasSurface(load->kind)) continue;
    fprintf(f, "%s\"%s\": {", before, load->name);
    JsonNumber(f, "level", load->level, load->kind == LOAD_UPLIFT ? ", " : "}");
    if (load->kind == LOAD_UPLIFT) JsonNumber(f, "tailwater", load->uplift.tailwater, "}");
    before = ", ";
  }
  fprintf(f, "},\n      ");
}

static PetscErrorCode write_trial(const Problem *p, const StageFields *fields, const Hinges *hinges,
                                  const PetscReal *probes, PetscReal value, PetscReal moved, char **json)
{
  const StageResult *r = p->result;
  const TermView view = ViewOf(p);
  size_t size = 0;
  FILE *f;
  PetscFunctionBeginUser;
  *json = NULL;
  f = open_memstream(json, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  fprintf(f, "        {");
  JsonNumber(f, "value", value, ", ");
  JsonText(f, "outcome", TrialWords[r->verdict], ", ");
  JsonCount(f, "cycles", r->cycles, ", ");
  JsonNumber(f, "wall_s", r->wall, ", ");
  JsonText(f, "evidence", r->evidence, ",\n      ");
  if (p->stage->kind == STAGE_FLOOD || p->stage->kind == STAGE_TRANSIENT) put_waters(f, p);
  JsonNumber(f, "moved", moved, ", ");
  JsonNumber(f, "max_displacement", r->displacement, ", ");
  SummaryHinges(f, hinges);
  TermsSummary(f, &view);
  put_probes(f, p->m, probes);
  PetscCall(SummaryJoints(f, p, fields));
  fprintf(f, "        }");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrialsAdd(const Problem *p, PetscReal value, PetscReal moved)
{
  static const char *const units[] = {" degree", " of the strengths"};
  const TermView view = ViewOf(p);
  const char *unit = p->stage->kind == STAGE_FLOOD          ? " m"
                     : p->stage->kind == STAGE_TRANSIENT    ? " s"
                     : p->stage->kind == STAGE_LOAD_FACTOR  ? " times the loads raised"
                     : p->stage->kind == STAGE_ANCHOR_FORCE ? " of the prestress"
                                                            : units[p->stage->what];
  const Model *m = p->m;
  const StageResult *result = p->result;
  Trials *trials = &p->output->trials;
  StageFields fields = {0};
  MeshFields mesh;
  PetscReal *probes;
  Hinges hinges = {.n = 0};
  char words[80] = "";
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * m->n_points, &probes));
  PetscCall(find_probes(m, p->state, probes));
  const MeshFields *kept = p->output->mesh.blocks ? &p->output->mesh : &mesh;
  if (kept == &mesh) PetscCall(GatherMesh(m, &mesh));
  PetscCall(GatherContacts(m, p->state, p->contacts, p->stage, kept, &fields));
  if (kept == &mesh) PetscCall(GatherMeshDestroy(&mesh));
  PetscCall(TermsBeforeSummary(&view, PETSC_FALSE));
  if (!m->rank) {
    PetscCall(PetscRealloc((size_t)(trials->n + 1) * sizeof(char *), &trials->json));
    hinges = HingesOf(p, &fields);
    PetscCall(write_trial(p, &fields, &hinges, probes, value, moved, trials->json + trials->n));
  }
  if (hinges.n && result->verdict == VERDICT_CONVERGED) // hinges of a mechanism exist only for a moment
    PetscCall(
        PetscSNPrintf(words, sizeof(words), ", hinges pressed over %.2g of the face", (double)hinges.least));
  StageShowEnd(p);
  PetscCall(PetscPrintf(m->comm, "stage %-12s %.8g%s: %s after %" PetscInt64_FMT " cycle%s, %.2f s%s\n",
                        p->stage->name, (double)value, unit, TrialWords[result->verdict], result->cycles,
                        Plural(result->cycles), result->wall, words));
  trials->n++;
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(PetscFree(probes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrialsReset(Trials *trials)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; trials->json && i < trials->n; i++) free(trials->json[i]);
  PetscCall(PetscFree(trials->json));
  PetscCall(PetscFree(trials->mechanism));
  PetscCall(PetscFree(trials->joint_motion));
  PetscCall(PetscFree(trials->joints));
  for (PetscInt c = 0; c < trials->loads.n_columns; c++)
    PetscCall(PetscFree(trials->loads.columns[c].values));
  *trials = (Trials){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- factors of a reduction of friction

   A trial leaves every joint an angle of at most its value, so each joint has a factor of its own. That of
   the stage is that of the joints which slide in the mechanism: a joint that stands still, or one that is
   open, has no part in the limit. Where these had different angles no single number says what friction could
   be divided by. Before anything fails all joints that are reduced count. */

static PetscReal tangent(PetscReal degrees)
{
  return tan(degrees * (PETSC_PI / 180.));
}

static PetscReal joint_factor(const Joint *joint, PetscReal value)
{
  if (PetscIsNanReal(value)) return NAN; // there is no such trial
  return tangent(joint->friction[0]) / tangent(PetscMin(joint->friction[0], value));
}

/* Decides whether two joints have the same angles of friction, or one joint before and after it has
   failed. */
static PetscBool one_angle(const Joint *a, const Joint *b)
{
  const PetscReal far = PetscMax(PetscAbsReal(a->friction[0] - b->friction[0]),
                                 PetscAbsReal(a->friction[0] - b->friction[1]));
  return (PetscBool)(far < 1e-9);
}

PetscErrorCode TrialsFactors(const Problem *p, const Joint *full, const PetscInt *has)
{
  Trials *t = &p->output->trials;
  PetscBool slides = PETSC_FALSE, alike = PETSC_TRUE;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(p->scene->n_joints, &t->joints));
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    t->joints[j] = (JointFactor){full[j].friction[0], joint_factor(full + j, t->stable),
                                 joint_factor(full + j, t->failing),
                                 (PetscBool)(has[j] && full[j].friction[0] > 0.)};
    slides = (PetscBool)(slides || (t->joints[j].reduced && MechanismHas(p->scene, t, j, JOINT_SLIDES)));
  }
  t->one = -1;
  for (PetscInt j = 0; j < p->scene->n_joints; j++) {
    if (!t->joints[j].reduced || (slides && !MechanismHas(p->scene, t, j, JOINT_SLIDES))) continue;
    if (t->one < 0) t->one = j;
    alike = (PetscBool)(alike && one_angle(full + t->one, full + j));
  }
  if (!alike) t->one = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Describes the coefficients of the first pseudo-static load that is raised. */
static void describe_coefficient(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->output->trials;
  for (PetscInt i = 0; i < p->stage->n_rises; i++) {
    const Load *load = p->scene->loads + p->stage->rises[i];
    if (load->kind != LOAD_PSEUDO_STATIC || PetscIsNanReal(t->failing)) continue;
    const int x = load->coefficient[0] == 0.;
    const double k = (double)load->coefficient[x];
    snprintf(text, size, "; k_%c of %s %.6g to %.6g", x ? 'v' : 'h', load->name, k * (double)t->stable,
             k * (double)t->failing);
    return;
  }
}

/* Describes the two forces between which each anchor is needed, as far as the text has room. */
static void describe_forces(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->output->trials;
  for (PetscInt i = 0; i < p->stage->n_anchors; i++) {
    const Anchor *a = AnchorNamed(p->scene, p->stage->anchors[i]);
    const double full = 1e-3 * (double)AnchorPrestress(p->scene, p->stage, a);
    const size_t used = strlen(text);
    char more[LABEL_LENGTH];
    if (PetscIsNanReal(t->failing))
      snprintf(more, sizeof(more), "; %s needs no more than %.6g kN", a->entry.name,
               full * (double)t->stable);
    else
      snprintf(more, sizeof(more), "; %s needs %.6g to %.6g kN", a->entry.name, full * (double)t->failing,
               full * (double)t->stable);
    if (used + strlen(more) < size) snprintf(text + used, size - used, "%s", more);
  }
}

void TrialsReport(const Problem *p, size_t size, char *text)
{
  const Trials *t = &p->output->trials;
  text[0] = '\0';
  if (p->stage->kind == STAGE_LOAD_FACTOR) describe_coefficient(p, size, text);
  if (p->stage->kind == STAGE_ANCHOR_FORCE) describe_forces(p, size, text);
  if (!t->joints || PetscIsNanReal(t->failing)) return;
  if (t->one < 0)
    snprintf(text, size,
             "; no single factor: the joints that slide had different angles, use what: strengths");
  else
    snprintf(text, size, "; factor %.4g to %.4g", t->joints[t->one].stable, t->joints[t->one].failing);
}

/* ---- members of a stage in summary.json */

static void put_factors(FILE *f, const Scene *scene, const Trials *t)
{
  const char *before = "";
  const JointFactor none = {NAN, NAN, NAN, PETSC_FALSE}, *one = t->one < 0 ? &none : t->joints + t->one;
  JsonNumber(f, "friction", one->friction, ", ");
  JsonNumber(f, "safety_factor_stable", one->stable, ", ");
  JsonNumber(f, "safety_factor_failing", one->failing, ",\n        \"factors\": {");
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    if (!t->joints[j].reduced) continue;
    fprintf(f, "%s\"%s\": {", before, scene->joints[j].name);
    JsonNumber(f, "friction", t->joints[j].friction, ", ");
    JsonNumber(f, "factor_stable", t->joints[j].stable, ", ");
    JsonNumber(f, "factor_failing", t->joints[j].failing, "}");
    before = ", ";
  }
  fprintf(f, "},\n        ");
}

/* Writes the loads that were raised, and the coefficients of pseudo-static ones. */
static void put_raised(FILE *f, const Scene *scene, const Stage *stage, const Trials *t)
{
  fprintf(f, "\"raises\": {");
  for (PetscInt i = 0; i < stage->n_rises; i++) {
    const Load *load = scene->loads + stage->rises[i];
    fprintf(f, "%s\"%s\": {", i ? ", " : "", load->name);
    for (int x = 0; x < 2 && load->kind == LOAD_PSEUDO_STATIC; x++) {
      JsonNumber(f, x ? "k_v_stable" : "k_h_stable", load->coefficient[x] * t->stable, ", ");
      JsonNumber(f, x ? "k_v_failing" : "k_h_failing", load->coefficient[x] * t->failing, x ? "" : ", ");
    }
    fprintf(f, "}");
  }
  fprintf(f, "},\n        ");
}

/* Writes the forces of the jacks, for each anchor. */
static void put_forces(FILE *f, const Scene *scene, const Stage *stage, const Trials *t)
{
  JsonNumber(f, "required", stage->required, ", ");
  fprintf(f, "\"forces\": {");
  for (PetscInt i = 0; i < stage->n_anchors; i++) {
    const Anchor *a = AnchorNamed(scene, stage->anchors[i]);
    const PetscReal full = AnchorPrestress(scene, stage, a);
    fprintf(f, "%s\"%s\": {", i ? ", " : "", a->entry.name);
    JsonNumber(f, "prestress", full, ", ");
    JsonNumber(f, "stable", full * t->stable, ", ");
    JsonNumber(f, "failing", full * t->failing, ", ");
    JsonNumber(f, "stable_per_metre", full * t->stable / a->spacing, ", ");
    JsonNumber(f, "failing_per_metre", full * t->failing / a->spacing, "}");
  }
  fprintf(f, "},\n        ");
}

static void put_list(FILE *f, const Trials *trials)
{
  fprintf(f, "[\n");
  for (PetscInt i = 0; i < trials->n; i++)
    fprintf(f, "%s%s\n", trials->json[i], i + 1 < trials->n ? "," : "");
  fprintf(f, "        ]");
}

void SummaryTrials(FILE *f, const Scene *scene, const Stage *stage, const Trials *trials)
{
  if (stage->kind == STAGE_TRANSIENT) {
    fprintf(f, "      \"steps\": ");
    put_list(f, trials);
    fprintf(f, ",\n");
    return;
  }
  const PetscBool reduces = (PetscBool)(stage->kind == STAGE_STRENGTH_REDUCTION),
                  flood = (PetscBool)(stage->kind == STAGE_FLOOD),
                  pulls = (PetscBool)(stage->kind == STAGE_ANCHOR_FORCE);
  const char *const unit = flood ? "m" : reduces && stage->what == REDUCE_FRICTION ? "degree" : "-";
  const char *const name = flood     ? "flood"
                           : reduces ? "strength_reduction"
                           : pulls   ? "anchor_force"
                                     : "load_factor";
  fprintf(f, "      \"%s\": {\n        ", name);
  JsonText(f, "unit", unit, ", ");
  if (stage->kind == STAGE_LOAD_FACTOR) put_raised(f, scene, stage, trials);
  if (pulls) put_forces(f, scene, stage, trials);
  if (reduces) JsonText(f, "what", stage->what == REDUCE_FRICTION ? "friction" : "strengths", ", ");
  JsonNumber(f, "stable", trials->stable, ", ");
  JsonNumber(f, "failing", trials->failing, ", ");
  JsonNumber(f, "width", fabs(trials->failing - trials->stable), ", ");
  JsonNumber(f, "undecided", trials->open, ",\n        ");
  JsonNumber(f, "moved", trials->moved, ", ");
  JsonNumber(f, "displacement_limit", trials->most, ",\n        ");
  if (trials->joints) put_factors(f, scene, trials);
  if (reduces && stage->what == REDUCE_STRENGTHS) {
    JsonNumber(f, "safety_factor_stable", 1. / trials->stable, ", ");
    JsonNumber(f, "safety_factor_failing", 1. / trials->failing, ",\n        ");
  }
  fprintf(f, "\"trials\": ");
  put_list(f, trials);
  fprintf(f, "\n      },\n");
}

/* summary_trials.c: writes the trials of a stage into summary.json: an object of each (probes, open lengths,
   joints), their bracket, and the joints that move in the mechanism. */
#include "output/output.h"
#include <math.h>

static const char *const TrialWords[] = {"undecided", "stable", "fails", "fails", "undecided", "interrupted"};

/* Writes the displacements of the named points, at the last ResultProbes. */
static void put_probes(FILE *f, const Model *m, const Probe *probes)
{
  fprintf(f, "\"probes\": {");
  for (PetscInt p = 0; p < m->n_points; p++) {
    fprintf(f, "%s\"%s\": {", p ? ", " : "", m->point_names[p]);
    JsonNumber(f, "u_x", probes[p].u[0], ", ");
    JsonNumber(f, "u_y", probes[p].u[1], "}");
  }
  fprintf(f, "},\n");
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
                                  PetscReal value, PetscReal moved, char **json)
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
  put_probes(f, p->m, p->found->probes);
  SummaryJoints(f, p, fields);
  fprintf(f, "        }");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputTrial(const Problem *p, PetscReal value, PetscReal moved)
{
  static const char *const units[] = {" degree", " of the strengths"};
  const TermView view = ViewOf(p);
  const char *unit = p->stage->kind == STAGE_FLOOD          ? " m"
                     : p->stage->kind == STAGE_TRANSIENT    ? " s"
                     : p->stage->kind == STAGE_LOAD_FACTOR  ? " times the loads raised"
                     : p->stage->kind == STAGE_ANCHOR_FORCE ? " of the prestress"
                                                            : units[p->stage->what];
  const Model *m = p->m;
  Output *o = p->output;
  const StageResult *result = p->result;
  Trials *trials = &p->found->trials;
  StageFields fields = {0};
  MeshFields mesh;
  PetscReal u_max;
  Hinges hinges = {.n = 0};
  char words[80] = "";
  PetscFunctionBeginUser;
  PetscCall(ResultProbes(p, &u_max));
  if (!trials->n) PetscCall(OutputDropTrials(o));
  const MeshFields *kept = p->found->mesh.blocks ? &p->found->mesh : &mesh;
  if (kept == &mesh) PetscCall(GatherMesh(m, &mesh));
  PetscCall(GatherContacts(m, p->state, p->contacts, p->stage, kept, &fields));
  if (kept == &mesh) PetscCall(GatherMeshDestroy(&mesh));
  PetscCall(TermsBeforeSummary(&view, PETSC_FALSE));
  if (!m->rank) {
    PetscCall(PetscRealloc((size_t)(o->n_trials + 1) * sizeof(char *), &o->trials));
    hinges = HingesOf(p, &fields);
    PetscCall(write_trial(p, &fields, &hinges, value, moved, o->trials + o->n_trials++));
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputDropTrials(Output *o)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < o->n_trials; i++) free(o->trials[i]);
  PetscCall(PetscFree(o->trials));
  o->n_trials = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- members of a stage */

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

static void put_list(FILE *f, const Output *o)
{
  fprintf(f, "[\n");
  for (PetscInt i = 0; i < o->n_trials; i++)
    fprintf(f, "%s%s\n", o->trials[i], i + 1 < o->n_trials ? "," : "");
  fprintf(f, "        ]");
}

void SummaryTrials(FILE *f, const Problem *p)
{
  const Scene *scene = p->scene;
  const Stage *stage = p->stage;
  const Trials *trials = &p->found->trials;
  if (stage->kind == STAGE_TRANSIENT) {
    fprintf(f, "      \"steps\": ");
    put_list(f, p->output);
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
  put_list(f, p->output);
  fprintf(f, "\n      },\n");
}

void SummaryMechanism(FILE *f, const Scene *scene, const Trials *trials)
{
  const char *before = "";
  if (!trials->mechanism) return;
  fprintf(f, "      \"mechanism\": {");
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const PetscBool slides = MechanismHas(scene, trials, j, JOINT_SLIDES),
                    opens = MechanismHas(scene, trials, j, JOINT_OPENS);
    if (!slides && !opens) continue;
    fprintf(f, "%s\"%s\": {", before, scene->joints[j].name);
    JsonText(f, "moves", slides && opens ? "slides and opens" : slides ? "slides" : "opens", ", ");
    JsonNumber(f, "slides", trials->joint_motion[2 * j + JOINT_SLIDES], ", ");
    JsonNumber(f, "opens", trials->joint_motion[2 * j + JOINT_OPENS], "}");
    before = ", ";
  }
  fprintf(f, "},\n");
}

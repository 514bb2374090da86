/* summary_trials.c: writes the trials of a stage into summary.json: an object of each (probes, open lengths,
   joints), their bracket, and the joints that move in the mechanism. */
#include "output/output.h"
#include <math.h>

static const char *const TrialWords[] = {"undecided", "stable", "fails", "fails", "undecided", "interrupted"};

/* Writes the displacements of the named points, at the last ResultProbes. */
static void put_probes(Json *json, const Model *m, const Probe *probes)
{
  JsonOpen(json, "probes");
  for (PetscInt p = 0; p < m->mesh.n_points; p++) {
    JsonObject(json, m->mesh.point_names[p], {"u_x", probes[p].u[0]}, {"u_y", probes[p].u[1]});
  }
  JsonClose(json);
}

/* Writes the levels of all waters of a flood [m]. */
static void put_waters(Json *json, const Problem *p)
{
  JsonOpen(json, "waters");
  for (PetscInt i = 0; i < p->stage->n_loads; i++) {
    const Load *load = p->scene->loads + p->stage->loads[i];
    if (!LoadHasSurface(load->kind)) continue;
    JsonOpen(json, load->name);
    JsonNumber(json, "level", load->level);
    if (load->kind == LOAD_UPLIFT) JsonNumber(json, "tailwater", load->uplift.tailwater);
    JsonClose(json);
  }
  JsonClose(json);
}

static PetscErrorCode write_trial(const Problem *p, const StageFields *fields, const Hinges *hinges,
                                  PetscReal value, PetscReal moved, char **text)
{
  const StageResult *r = p->result;
  const TermView view = ViewOf(p);
  Json trial, *json = &trial;
  PetscFunctionBeginUser;
  PetscCall(JsonToMemory(json, 5, text));
  JsonOpen(json, NULL);
  JsonNumber(json, "value", value);
  JsonText(json, "outcome", TrialWords[r->verdict]);
  JsonNumbers(json, {"cycles", r->cycles}, {"wall_s", r->wall});
  JsonText(json, "evidence", r->evidence);
  if (p->stage->kind == STAGE_FLOOD || p->stage->kind == STAGE_TRANSIENT) put_waters(json, p);
  JsonNumbers(json, {"moved", moved}, {"max_displacement", r->displacement});
  SummaryHinges(json, hinges);
  TermsSummary(json, &view);
  put_probes(json, p->m, p->found->probes);
  SummaryJoints(json, p, fields);
  JsonClose(json);
  PetscCall(JsonEnd(json));
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

static void put_factors(Json *json, const Scene *scene, const Trials *t)
{
  const JointFactor none = {NAN, NAN, NAN, PETSC_FALSE}, *one = t->one < 0 ? &none : t->joints + t->one;
  JsonNumbers(json, {"friction", one->friction}, {"safety_factor_stable", one->stable},
              {"safety_factor_failing", one->failing});
  JsonOpen(json, "factors");
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    if (!t->joints[j].reduced) continue;
    JsonObject(json, scene->joints[j].name, {"friction", t->joints[j].friction},
               {"factor_stable", t->joints[j].stable}, {"factor_failing", t->joints[j].failing});
  }
  JsonClose(json);
}

/* Writes the loads that were raised, and the coefficients of pseudo-static ones. */
static void put_raised(Json *json, const Scene *scene, const Stage *stage, const Trials *t)
{
  JsonOpen(json, "raises");
  for (PetscInt i = 0; i < stage->n_rises; i++) {
    const Load *load = scene->loads + stage->rises[i];
    JsonOpen(json, load->name);
    for (int x = 0; x < 2 && load->kind == LOAD_PSEUDO_STATIC; x++) {
      JsonNumbers(json, {x ? "k_v_stable" : "k_h_stable", load->coefficient[x] * t->stable},
                  {x ? "k_v_failing" : "k_h_failing", load->coefficient[x] * t->failing});
    }
    JsonClose(json);
  }
  JsonClose(json);
}

/* Writes the forces of the jacks, for each anchor. */
static void put_forces(Json *json, const Scene *scene, const Stage *stage, const Trials *t)
{
  JsonNumber(json, "required", stage->required);
  JsonOpen(json, "forces");
  for (PetscInt i = 0; i < stage->n_anchors; i++) {
    const Anchor *a = AnchorNamed(scene, stage->anchors[i]);
    const PetscReal full = AnchorPrestress(scene, stage, a);
    JsonObject(json, a->entry.name, {"prestress", full}, {"stable", full * t->stable},
               {"failing", full * t->failing}, {"stable_per_metre", full * t->stable / a->spacing},
               {"failing_per_metre", full * t->failing / a->spacing});
  }
  JsonClose(json);
}

static void put_list(Json *json, const char *name, const Output *o)
{
  JsonList(json, name);
  for (PetscInt i = 0; i < o->n_trials; i++) JsonValue(json, NULL, o->trials[i]);
  JsonClose(json);
}

void SummaryTrials(Json *json, const Problem *p)
{
  const Scene *scene = p->scene;
  const Stage *stage = p->stage;
  const Trials *trials = &p->found->trials;
  if (stage->kind == STAGE_TRANSIENT) {
    put_list(json, "steps", p->output);
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
  JsonOpen(json, name);
  JsonText(json, "unit", unit);
  if (stage->kind == STAGE_LOAD_FACTOR) put_raised(json, scene, stage, trials);
  if (pulls) put_forces(json, scene, stage, trials);
  if (reduces) JsonText(json, "what", stage->what == REDUCE_FRICTION ? "friction" : "strengths");
  JsonNumbers(json, {"stable", trials->stable}, {"failing", trials->failing},
              {"width", fabs(trials->failing - trials->stable)}, {"undecided", trials->open},
              {"moved", trials->moved}, {"displacement_limit", trials->most});
  if (trials->joints) put_factors(json, scene, trials);
  if (reduces && stage->what == REDUCE_STRENGTHS) {
    JsonNumbers(json, {"safety_factor_stable", 1. / trials->stable},
                {"safety_factor_failing", 1. / trials->failing});
  }
  put_list(json, "trials", p->output);
  JsonClose(json);
}

void SummaryMechanism(Json *json, const Scene *scene, const Trials *trials)
{
  if (!trials->mechanism) return;
  JsonOpen(json, "mechanism");
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const PetscBool slides = MechanismHas(scene, trials, j, JOINT_SLIDES),
                    opens = MechanismHas(scene, trials, j, JOINT_OPENS);
    if (!slides && !opens) continue;
    JsonOpen(json, scene->joints[j].name);
    JsonText(json, "moves", slides && opens ? "slides and opens" : slides ? "slides" : "opens");
    JsonNumbers(json, {"slides", trials->joint_motion[2 * j + JOINT_SLIDES]},
                {"opens", trials->joint_motion[2 * j + JOINT_OPENS]});
    JsonClose(json);
  }
  JsonClose(json);
}

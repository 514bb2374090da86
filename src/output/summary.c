/* summary.c: writes summary.json (docs/results_format.md). Rank 0 only; sums run over the gathered arrays in
   their order. */
#include "output/output.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- energies, forces, displacements */

/* Sums applied forces or reactions: members of VertexRow and BodyRow with these offsets. */
static void put_forces(Json *json, const char *name, const MeshFields *mesh, const StageFields *s,
                       size_t of_vertex, size_t of_body)
{
  PetscReal sum[2] = {0, 0};
  for (int x = 0; x < 2; x++) {
    for (PetscInt i = 0; i < mesh->n_vertices; i++)
      sum[x] += ((const PetscReal *)((const char *)(s->vertex + i) + of_vertex))[x];
    for (PetscInt i = 0; i < s->n_bodies; i++)
      sum[x] += ((const PetscReal *)((const char *)(s->body + i) + of_body))[x];
  }
  JsonObject(json, name, {"x", sum[0]}, {"y", sum[1]});
}

/* Writes the share of each support in the reaction. */
static PetscErrorCode put_supports(Json *json, const Scene *scene, const MeshFields *mesh,
                                   const StageFields *s)
{
  PetscReal *sum; // (n_supports,2) [N]
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * scene->n_supports, &sum));
  for (int x = 0; x < 2; x++) {
    for (PetscInt i = 0; i < mesh->n_vertices; i++) {
      const VertexRow *row = s->vertex + i;
      if (row->support[x] >= 0) sum[2 * row->support[x] + x] += row->reaction[x];
    }
    for (PetscInt i = 0; i < s->n_bodies; i++) {
      const BodyRow *row = s->body + i;
      if (row->support[x] >= 0) sum[2 * row->support[x] + x] += row->reaction[x];
    }
  }
  JsonOpen(json, "supports");
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    JsonObject(json, scene->supports[i].name, {"x", sum[2 * i]}, {"y", sum[2 * i + 1]});
  }
  JsonClose(json);
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes sums over gathered values, in file order, so that they have the same bits on any number of ranks.
   stored.c sums on each rank, for the account of a motion in time. */
static void put_energies(Json *json, const MeshFields *mesh, const StageFields *s, const StageResult *result)
{
  PetscReal strain = 0, joints = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) strain += s->block[b].energy;
  for (PetscInt i = 0; i < s->n_contacts; i++) {
    for (int k = 0; k < 2; k++) {
      const ContactEnd *end = &s->contact[i].end[k];
      joints += 0.5 *
                (end->force[0] * (end->opening - end->closure) + end->force[1] * (end->sliding - end->slip));
    }
  }
  JsonObject(json, "energy", {"strain", strain}, {"joints", joints}, {"kinetic", result->kinetic});
}

/* Writes the account of a dynamic stage. */
static void put_account(Json *json, const Energies *e)
{
  JsonObject(json, "energy", {"strain", e->strain}, {"joints", e->joints}, {"kinetic", e->kinetic},
             {"outside", e->outside}, {"supports", e->supports}, {"friction", e->friction},
             {"damping", e->damping}, {"incoming", e->incoming}, {"radiated", e->radiated},
             {"detection", e->detection}, {"balance", e->balance}, {"moved", e->moved});
  if (e->reduced) {
    JsonObject(json, "lacking", {"stress", e->truncation[0]}, {"frequency", e->truncation[1]},
               {"haste", e->frequency_ratio});
  }
  if (e->water != 0.) JsonNumber(json, "kinetic_water", e->water);
  if (e->yielded != 0.) JsonNumber(json, "yielded", e->yielded);
}

static void put_displacement(Json *json, const MeshFields *mesh, const StageFields *s)
{
  PetscInt best = 0;
  PetscReal most = -1;
  for (PetscInt i = 0; i < mesh->n_vertices; i++) {
    const PetscReal *u = s->vertex[i].u, size = hypot(u[0], u[1]);
    if (!(size <= most)) most = size, best = i;
  }
  JsonObject(json, "max_displacement", {"value", most}, {"vertex", best}, {"x", mesh->X[2 * best]},
             {"y", mesh->X[2 * best + 1]});
}

static void put_probes(Json *json, const Model *model, const Probe *probes)
{
  JsonOpen(json, "probes");
  for (PetscInt p = 0; p < model->mesh.n_points; p++) {
    JsonObject(json, model->mesh.point_names[p], {"x", probes[p].X[0]}, {"y", probes[p].X[1]},
               {"u_x", probes[p].u[0]}, {"u_y", probes[p].u[1]});
  }
  JsonClose(json);
}

/* ---- a stage and the file */

PetscInt SummaryByFactor(const Problem *p)
{
  const PetscInt base = StageBase(p->scene, p->number), *earlier = p->output->by_factor;
  const Effort *effort = &p->result->effort;
  return p->scene->method == METHOD_PRECONDITIONED || effort->preconditioned ||
         (earlier && base >= 0 && earlier[base]);
}

PetscErrorCode SummaryStage(Json *json, const Problem *p, const StageFields *fields,
                            const uint64_t checksum[2])
{
  const Scene *scene = p->scene;
  const StageResult *result = p->result;
  const MeshFields *mesh = &p->found->mesh;
  const TermView view = ViewOf(p);
  char why[512];
  PetscFunctionBeginUser;
  JsonOpen(json, NULL);
  JsonText(json, "name", p->stage->name);
  if (p->stage->from[0]) JsonText(json, "from", p->stage->from);
  JsonText(json, "verdict", VerdictNames[result->verdict]);
  JsonText(json, "evidence", result->evidence);
  JsonNumber(json, "cycles", result->cycles);
  JsonText(json, "method", EffortMethod(&result->effort));
  MethodSentence(&result->effort.choice, sizeof(why), why);
  if (why[0]) JsonText(json, "method_choice", why);
  JsonNumbers(json, {"force_evaluations", result->effort.evaluations}, {"solves", result->effort.solves},
              {"factorisations", result->effort.factorisations});
  if (EffortConnectivity(&result->effort))
    JsonText(json, "connectivity", EffortConnectivity(&result->effort));
  if (result->effort.outgrown[2] > 0.) {
    JsonObject(json, "outgrown", {"x", result->effort.outgrown[0]}, {"y", result->effort.outgrown[1]},
               {"moved", result->effort.outgrown[2]});
  }
  JsonText(json, "ranks_agree", SummaryByFactor(p) ? "to the tolerance" : "bit for bit");
  JsonNumbers(json, {"wall_s", result->wall}, {"ratio", result->ratio},
              {"worst_macroblock", result->worst_body}, {"increment", result->increment},
              {"alpha", p->state->alpha}, {"dt", p->state->dt}, {"time", fields->time},
              {"verifications", result->verifications}, {"contacts_made", result->contacts_made},
              {"contacts_lost", result->contacts_lost});
  JsonHex(json, "checksum", 16, checksum[0]);
  if (p->m->mesh.n_condensed_global) JsonHex(json, "checksum_kept", 16, checksum[1]);
  put_probes(json, p->m, p->found->probes);
  const Hinges hinges = HingesOf(p, fields);
  SummaryHinges(json, &hinges);
  if (p->stage->kind != STAGE_FLOOD && p->stage->kind != STAGE_LOAD_FACTOR) TermsSummary(json, &view);
  if (p->stage->kind == STAGE_MODES) SummaryVibration(json, &p->found->vibration);
  put_displacement(json, mesh, fields);
  put_forces(json, "applied", mesh, fields, offsetof(VertexRow, applied), offsetof(BodyRow, applied));
  put_forces(json, "reaction", mesh, fields, offsetof(VertexRow, reaction), offsetof(BodyRow, reaction));
  PetscCall(put_supports(json, scene, mesh, fields));
  if (StageInTime(p->stage)) {
    SummaryRocking(json, &p->found->rocking);
    SummaryBodies(json, p->m, &p->found->bodies);
    SummaryPeaks(json, p);
    put_account(json, &result->energy);
  } else
    put_energies(json, mesh, fields, result);
  if (SceneHasHeat(scene)) SummaryTemperature(json, mesh, fields);
  SummaryStress(json, p->m, mesh, fields);
  SummarySafety(json, scene, mesh, fields);
  SummaryLaws(json, scene, mesh, fields);
  if (p->found->trials.n) SummaryTrials(json, p);
  SummaryMechanism(json, scene, &p->found->trials);
  SummaryJoints(json, p, fields);
  JsonClose(json);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the stages that were run, the names of those that were skipped, and of those that results.h5 lost
   before a restart. */
static void put_stages(Json *json, const Scene *scene, const Output *o)
{
  JsonList(json, "stages");
  for (PetscInt s = 0; s < o->n_stages; s++)
    if (o->stages[s]) JsonValue(json, NULL, o->stages[s]);
  JsonClose(json);
  for (int lost = 0; lost < 2; lost++) {
    PetscInt n = 0;
    for (PetscInt s = 0; s < o->n_stages; s++) {
      if (lost == !o->stages[s] || (lost && XdmfHas(&o->results, s, 0))) continue;
      if (!n++) JsonList(json, lost ? "not_in_results" : "not_run");
      JsonText(json, NULL, scene->stages[s].name);
    }
    if (n) JsonClose(json);
  }
}

PetscErrorCode SummaryWrite(const Scene *scene, const Model *model, const Output *o,
                            char message[MESSAGE_LENGTH])
{
  static const char units[] =
      "SI: m, N, Pa, J, s, rad, angles of friction in degrees; tension positive, N of "
      "joints compression positive";
  char *text = NULL;
  Json file, *json = &file;
  PetscFunctionBeginUser;
  PetscCall(JsonToMemory(json, 0, &text));
  JsonOpen(json, NULL);
  JsonText(json, "format", "quoin-summary");
  JsonNumber(json, "version", 2);
  JsonText(json, "quoin", QUOIN_VERSION);
  JsonHex(json, "program", 8, o->program_checksum);
  JsonHex(json, "run", 16, o->results.run);
  JsonText(json, "title", scene->title);
  JsonText(json, "scene", scene->file);
  JsonText(json, "model", scene->model);
  JsonText(json, "units", units);
  JsonNumber(json, "ranks", model->size);
  JsonText(json, "isa", IsaName());
  if (scene->solvers) JsonText(json, "petsc_options", scene->solvers);
  JsonNumbers(json, {"thickness", scene->thickness}, {"n_blocks", model->mesh.n_blocks_global},
              {"n_vertices", model->mesh.n_vertices_global}, {"n_macroblocks", model->mesh.n_bodies_global},
              {"n_rigid", model->mesh.n_rigid_global}, {"n_contacts", o->n_contacts}, {"n_dofs", o->n_dofs});
  if (model->mesh.n_condensed_global) {
    JsonObject(json, "condensed", {"bodies", model->mesh.n_condensed_global},
               {"kept_dofs", model->condensed.dofs[0]}, {"inner_dofs", model->condensed.dofs[1]},
               {"factors", model->mesh.n_condensed_global}, {"factor_wall_s", model->condensed.wall},
               {"large_strain", model->condensed.large});
    JsonList(json, "condensed_groups");
    for (PetscInt g = 0; g < model->materials.n_groups; g++)
      if (model->materials.condensed[g]) JsonText(json, NULL, model->materials.names[g]);
    JsonClose(json);
  }
  if (model->condensed.why[0]) JsonText(json, "condensed_choice", model->condensed.why);
  put_stages(json, scene, o);
  HistorySummary(json, o->files + HISTORY, "history");
  HistorySummary(json, o->files + JOINT_HISTORY, "joint_history");
  HistorySummary(json, o->files + TERM_HISTORY, "anchor_history");
  fputs(",\n", json->file);
  PetscCall(JsonEnd(json));
  PartText(o->folder, "summary.json", text, json->size, "  \"crc32\": \"", "\"\n}\n", message);
  free(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

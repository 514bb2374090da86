/* summary.c: writes summary.json (docs/results_format.md). Rank 0 only; sums run over the gathered arrays in
   their order. */
#include "output/output.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- energies, forces, displacements */

/* Sums applied forces or reactions: members of VertexRow and BodyRow with these offsets. */
static void put_forces(FILE *f, const char *name, const MeshFields *mesh, const StageFields *s,
                       size_t of_vertex, size_t of_body)
{
  PetscReal sum[2] = {0, 0};
  for (int x = 0; x < 2; x++) {
    for (PetscInt i = 0; i < mesh->n_vertices; i++)
      sum[x] += ((const PetscReal *)((const char *)(s->vertex + i) + of_vertex))[x];
    for (PetscInt i = 0; i < s->n_bodies; i++)
      sum[x] += ((const PetscReal *)((const char *)(s->body + i) + of_body))[x];
  }
  fprintf(f, "      \"%s\": {", name);
  JsonNumber(f, "x", sum[0], ", ");
  JsonNumber(f, "y", sum[1], "},\n");
}

/* Writes the share of each support in the reaction. */
static PetscErrorCode put_supports(FILE *f, const Scene *scene, const MeshFields *mesh, const StageFields *s)
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
  fprintf(f, "      \"supports\": {");
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    fprintf(f, "%s\n        ", i ? "," : "");
    JsonString(f, scene->supports[i].name);
    fprintf(f, ": {");
    JsonNumber(f, "x", sum[2 * i], ", ");
    JsonNumber(f, "y", sum[2 * i + 1], "}");
  }
  fprintf(f, "\n      },\n");
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes sums over gathered values, in file order, so that they have the same bits on any number of ranks.
   stored.c sums on each rank, for the account of a motion in time. */
static void put_energies(FILE *f, const MeshFields *mesh, const StageFields *s, const StageResult *result)
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
  fprintf(f, "      \"energy\": {");
  JsonNumber(f, "strain", strain, ", ");
  JsonNumber(f, "joints", joints, ", ");
  JsonNumber(f, "kinetic", result->kinetic, "},\n");
}

/* Writes the account of a dynamic stage. */
static void put_account(FILE *f, const Energies *e)
{
  fprintf(f, "      \"energy\": {");
  JsonNumber(f, "strain", e->strain, ", ");
  JsonNumber(f, "joints", e->joints, ", ");
  JsonNumber(f, "kinetic", e->kinetic, ", ");
  JsonNumber(f, "outside", e->outside, ", ");
  JsonNumber(f, "supports", e->supports, ", ");
  JsonNumber(f, "friction", e->friction, ", ");
  JsonNumber(f, "damping", e->damping, ", ");
  JsonNumber(f, "incoming", e->incoming, ", ");
  JsonNumber(f, "radiated", e->radiated, ", ");
  JsonNumber(f, "detection", e->detection, ", ");
  JsonNumber(f, "balance", e->balance, ", ");
  JsonNumber(f, "moved", e->moved, "},\n");
  if (e->reduced) {
    fprintf(f, "      \"lacking\": {");
    JsonNumber(f, "stress", e->lacking[0], ", ");
    JsonNumber(f, "frequency", e->lacking[1], ", ");
    JsonNumber(f, "haste", e->haste, "},\n");
  }
  if (e->water != 0.) fprintf(f, "      "), JsonNumber(f, "kinetic_water", e->water, ",\n");
  if (e->yielded != 0.) fprintf(f, "      "), JsonNumber(f, "yielded", e->yielded, ",\n");
}

static void put_displacement(FILE *f, const MeshFields *mesh, const StageFields *s)
{
  PetscInt best = 0;
  PetscReal most = -1;
  for (PetscInt i = 0; i < mesh->n_vertices; i++) {
    const PetscReal *u = s->vertex[i].u, size = hypot(u[0], u[1]);
    if (!(size <= most)) most = size, best = i;
  }
  fprintf(f, "      \"max_displacement\": {");
  JsonNumber(f, "value", most, ", ");
  JsonCount(f, "vertex", best, ", ");
  JsonNumber(f, "x", mesh->X[2 * best], ", ");
  JsonNumber(f, "y", mesh->X[2 * best + 1], "},\n");
}

static void put_probes(FILE *f, const Model *model, const Probe *probes)
{
  fprintf(f, "      \"probes\": {");
  for (PetscInt p = 0; p < model->n_points; p++) {
    fprintf(f, "%s\n        ", p ? "," : "");
    JsonString(f, model->point_names[p]);
    fprintf(f, ": {");
    JsonNumber(f, "x", probes[p].X[0], ", ");
    JsonNumber(f, "y", probes[p].X[1], ", ");
    JsonNumber(f, "u_x", probes[p].u[0], ", ");
    JsonNumber(f, "u_y", probes[p].u[1], "}");
  }
  fprintf(f, "\n      },\n");
}

/* ---- a stage and the file */

PetscInt SummaryByFactor(const Problem *p)
{
  const PetscInt base = StageBase(p->scene, p->number), *earlier = p->output->by_factor;
  return p->scene->method == METHOD_PRECONDITIONED || p->result->effort.preconditioned ||
         (earlier && base >= 0 && earlier[base]);
}

PetscErrorCode SummaryStage(const Problem *p, const StageFields *fields, const uint64_t checksum[2],
                            char **json)
{
  const Scene *scene = p->scene;
  const StageResult *result = p->result;
  const MeshFields *mesh = &p->found->mesh;
  const TermView view = ViewOf(p);
  char hex[2][32];
  size_t size = 0;
  FILE *f;
  PetscFunctionBeginUser;
  *json = NULL;
  f = open_memstream(json, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  for (int i = 0; i < 2; i++) snprintf(hex[i], sizeof(hex[i]), "%016llx", (unsigned long long)checksum[i]);
  fprintf(f, "    {\n      ");
  JsonText(f, "name", p->stage->name, ",\n      ");
  if (p->stage->from[0]) JsonText(f, "from", p->stage->from, ",\n      ");
  JsonText(f, "verdict", VerdictNames[result->verdict], ",\n      ");
  JsonText(f, "evidence", result->evidence, ",\n      ");
  JsonCount(f, "cycles", result->cycles, ",\n      ");
  JsonText(f, "method", EffortMethod(&result->effort), ",\n      ");
  JsonCount(f, "force_evaluations", result->effort.evaluations, ",\n      ");
  JsonCount(f, "solves", result->effort.solves, ",\n      ");
  JsonCount(f, "factorisations", result->effort.factorisations, ",\n      ");
  JsonText(f, "ranks_agree", SummaryByFactor(p) ? "to the tolerance" : "bit for bit", ",\n      ");
  JsonNumber(f, "wall_s", result->wall, ",\n      ");
  JsonNumber(f, "ratio", result->ratio, ",\n      ");
  JsonCount(f, "worst_macroblock", result->worst_body, ",\n      ");
  JsonNumber(f, "increment", result->increment, ",\n      ");
  JsonNumber(f, "alpha", p->state->alpha, ",\n      ");
  JsonNumber(f, "dt", p->state->dt, ",\n      ");
  JsonNumber(f, "time", fields->time, ",\n      ");
  JsonCount(f, "verifications", result->verifications, ",\n      ");
  JsonCount(f, "contacts_made", result->contacts_made, ",\n      ");
  JsonCount(f, "contacts_lost", result->contacts_lost, ",\n      ");
  JsonText(f, "checksum", hex[0], ",\n");
  if (p->m->n_condensed_global) fprintf(f, "      \"checksum_kept\": \"%s\",\n", hex[1]);
  put_probes(f, p->m, p->found->probes);
  const Hinges hinges = HingesOf(p, fields);
  SummaryHinges(f, &hinges);
  if (p->stage->kind != STAGE_FLOOD && p->stage->kind != STAGE_LOAD_FACTOR) TermsSummary(f, &view);
  if (p->stage->kind == STAGE_MODES) SummaryVibration(f, &p->found->vibration);
  put_displacement(f, mesh, fields);
  put_forces(f, "applied", mesh, fields, offsetof(VertexRow, applied), offsetof(BodyRow, applied));
  put_forces(f, "reaction", mesh, fields, offsetof(VertexRow, reaction), offsetof(BodyRow, reaction));
  PetscCall(put_supports(f, scene, mesh, fields));
  if (p->stage->kind == STAGE_DYNAMIC)
    SummaryRocking(f, &p->found->rocking), SummaryBodies(f, p->m, &p->found->bodies), SummaryPeaks(f, p),
        put_account(f, &result->energy);
  else
    put_energies(f, mesh, fields, result);
  if (SceneHasHeat(scene)) SummaryTemperature(f, mesh, fields);
  SummaryStress(f, p->m, mesh, fields);
  SummarySafety(f, scene, mesh, fields);
  SummaryLaws(f, scene, mesh, fields);
  if (p->found->trials.n) SummaryTrials(f, p);
  SummaryMechanism(f, scene, &p->found->trials);
  SummaryJoints(f, p, fields);
  fprintf(f, "    }");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the stages that were run, the names of those that were skipped, and of those that results.h5 lost
   before a restart. */
static void put_stages(FILE *f, const Scene *scene, const Output *o)
{
  PetscInt n = 0, passed = 0;
  for (PetscInt s = 0; s < o->n_stages; s++)
    if (o->stages[s]) fprintf(f, "%s%s", n++ ? ",\n" : "", o->stages[s]);
  fprintf(f, "\n  ],\n");
  for (PetscInt s = 0; s < o->n_stages; s++) {
    if (o->stages[s]) continue;
    fprintf(f, passed++ ? ", " : "  \"not_run\": [");
    JsonString(f, scene->stages[s].name);
  }
  if (passed) fprintf(f, "],\n");
  const char *from = NULL;
  for (PetscInt s = passed = 0; s < o->n_stages; s++) {
    if (!o->stages[s] || XdmfHas(&o->results, scene->stages[s].name, &from)) continue;
    fprintf(f, passed++ ? ", " : "  \"not_in_results\": [");
    JsonString(f, scene->stages[s].name);
  }
  if (passed) fprintf(f, "],\n");
}

PetscErrorCode SummaryWrite(const Scene *scene, const Model *model, const Output *o,
                            char message[MESSAGE_LENGTH])
{
  char *text = NULL;
  size_t size = 0;
  PetscFunctionBeginUser;
  FILE *f = open_memstream(&text, &size);
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  fprintf(f, "{\n  ");
  JsonText(f, "format", "quoin-summary", ",\n  ");
  JsonCount(f, "version", 2, ",\n  ");
  JsonText(f, "quoin", QUOIN_VERSION, ",\n  ");
  fprintf(f, "\"program\": \"%08llx\",\n  \"run\": \"%016llx\",\n  ", (unsigned long long)o->program_checksum,
          (unsigned long long)o->results.run);
  JsonText(f, "title", scene->title, ",\n  ");
  JsonText(f, "scene", scene->file, ",\n  ");
  JsonText(f, "model", scene->model, ",\n  ");
  JsonText(
      f, "units",
      "SI: m, N, Pa, J, s, rad, angles of friction in degrees; tension positive, N of joints compression "
      "positive",
      ",\n  ");
  JsonCount(f, "ranks", model->size, ",\n  ");
  JsonText(f, "isa", IsaName(), ",\n  ");
  if (scene->solvers) JsonText(f, "petsc_options", scene->solvers, ",\n  ");
  JsonNumber(f, "thickness", scene->thickness, ",\n  ");
  JsonCount(f, "n_blocks", model->n_blocks_global, ",\n  ");
  JsonCount(f, "n_vertices", model->n_vertices_global, ",\n  ");
  JsonCount(f, "n_macroblocks", model->n_bodies_global, ",\n  ");
  JsonCount(f, "n_rigid", model->n_rigid_global, ",\n  ");
  JsonCount(f, "n_contacts", o->n_contacts, ",\n  ");
  JsonCount(f, "n_dofs", o->n_dofs, ",\n");
  if (model->n_condensed_global) {
    fprintf(f, "  \"condensed\": {");
    JsonCount(f, "bodies", model->n_condensed_global, ", ");
    JsonCount(f, "kept_dofs", model->condensed_dofs[0], ", ");
    JsonCount(f, "inner_dofs", model->condensed_dofs[1], ", ");
    JsonCount(f, "factors", model->n_condensed_global, ", ");
    JsonNumber(f, "factor_wall_s", model->condensed_wall, "},\n");
  }
  fprintf(f, "  \"stages\": [\n");
  put_stages(f, scene, o);
  HistorySummary(f, o->files + HISTORY, "history");
  HistorySummary(f, o->files + JOINT_HISTORY, "joint_history");
  HistorySummary(f, o->files + TERM_HISTORY, "anchor_history");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PartText(o->folder, "summary.json", text, size, "  \"crc32\": \"", "\"\n}\n", message);
  free(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

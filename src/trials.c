/* trials.c: what the trials of a strength reduction or a flood leave: an object per trial in summary.json
   (probes, open lengths, joints), the bracket, and the velocity field of the mechanism. */
#include "output.h"
#include <math.h>

static const char *const TrialWords[] = {"undecided", "stable", "fails", "fails", "undecided", "interrupted"};

/* Displacements of the named points, from the gathered vertices. */
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

/* Collective. (n_points,2) on all ranks; each point has one owner. */
static PetscErrorCode find_probes(const Model *m, const State *state, PetscReal *probes)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 2 * m->n_points; i++) {
    const PetscInt v = m->point_vertex[i / 2];
    probes[i] = v >= 0 && v < m->n_owned ? state->u[3 * m->n_bodies + 2 * v + i % 2] : PETSC_NINFINITY;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, probes, (PetscMPIInt)(2 * m->n_points), MPIU_REAL, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode write_trial(const Problem *p, const StageFields *fields, const PetscReal *probes,
                                  PetscReal value, char **json)
{
  const StageResult *r = p->result;
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
  JsonNumber(f, "max_displacement", r->displacement, ", ");
  SummaryUplift(f, p);
  put_probes(f, p->m, probes);
  PetscCall(SummaryJoints(f, p->scene, p->stage->joints, fields));
  fprintf(f, "        }");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the summary");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrialsAdd(const Problem *p, PetscReal value)
{
  static const char *const units[] = {" m", " degree", " of the strengths"};
  const char *unit = units[p->stage->kind == STAGE_FLOOD ? 0 : p->stage->what == REDUCE_FRICTION ? 1 : 2];
  const Model *m = p->m;
  const StageResult *result = p->result;
  Trials *trials = &p->output->trials;
  StageFields fields = {0};
  MeshFields mesh;
  PetscReal *probes;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(m->comm, "stage %-12s %.8g%s: %s after %" PetscInt64_FMT " cycle%s, %.2f s\n",
                        p->stage->name, (double)value, unit, TrialWords[result->verdict], result->cycles,
                        Plural(result->cycles), result->wall));
  PetscCall(PetscMalloc1(2 * m->n_points, &probes));
  PetscCall(find_probes(m, p->state, probes));
  PetscCall(GatherMesh(m, &mesh));
  PetscCall(GatherContacts(m, p->state, p->contacts, p->stage, &mesh, &fields));
  PetscCall(GatherMeshDestroy(&mesh));
  if (!m->rank) {
    PetscCall(PetscRealloc((size_t)(trials->n + 1) * sizeof(char *), &trials->json));
    PetscCall(write_trial(p, &fields, probes, value, trials->json + trials->n));
  }
  trials->n++;
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(PetscFree(probes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The motion over the last chunk of cycles: single velocities still carry what vibrates in the blocks. */
PetscErrorCode TrialsMechanism(const Problem *p)
{
  const Model *m = p->m;
  const State *state = p->state;
  const Relaxation *r = p->relax;
  Trials *trials = &p->output->trials;
  const PetscInt at = 3 * m->n_bodies;
  const PetscBool chunk_ended = (PetscBool)(r->chunk_start == state->cycle);
  const PetscReal *u = state->u + at;
  PetscReal most = 0., *du;
  PetscFunctionBeginUser;
  // never NULL: that says "none", to all ranks
  if (!trials->mechanism) PetscCall(PetscMalloc1(PetscMax(1, 2 * m->n_owned), &trials->mechanism));
  PetscCall(PetscMalloc1(m->n_dof, &du));
  for (PetscInt d = 0; d < m->n_dof; d++) du[d] = chunk_ended ? r->du_chunk[d] : state->u[d] - r->u_chunk[d];
  PetscReal *v = trials->mechanism;
  for (PetscInt i = 0; i < 2 * m->n_deformable; i++) v[i] = du[at + i];
  for (PetscInt b = 0; b < m->n_bodies; b++)
    for (PetscInt i = m->body_start[b]; i < m->body_start[b + 1]; i++) {
      const PetscReal rx = m->X[2 * i] + u[2 * i] - m->body_X[2 * b] - state->u[3 * b],
                      ry = m->X[2 * i + 1] + u[2 * i + 1] - m->body_X[2 * b + 1] - state->u[3 * b + 1];
      v[2 * i] = du[3 * b] - ry * du[3 * b + 2];         // (21)
      v[2 * i + 1] = du[3 * b + 1] + rx * du[3 * b + 2]; // (22)
    }
  PetscCall(CondensedInner(m, NULL, v));
  PetscCall(PetscFree(du));
  for (PetscInt i = 0; i < m->n_owned; i++) most = PetscMax(most, PetscHypotReal(v[2 * i], v[2 * i + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt i = 0; most > 0. && i < 2 * m->n_owned; i++) v[i] /= most; // time is fictitious
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrialsReset(Trials *trials)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; trials->json && i < trials->n; i++) free(trials->json[i]);
  PetscCall(PetscFree(trials->json));
  PetscCall(PetscFree(trials->mechanism));
  *trials = (Trials){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- members of a stage in summary.json */

static PetscReal tangent(PetscReal degrees)
{
  return tan(degrees * (PETSC_PI / 180.));
}

/* Of the strengths: what they may be divided by. */
static PetscReal safety_factor(const Stage *stage, const Trials *trials, PetscReal value)
{
  return stage->what == REDUCE_FRICTION ? tangent(trials->nominal) / tangent(value) : 1. / value;
}

void SummaryTrials(FILE *f, const Stage *stage, const Trials *trials)
{
  const PetscBool flood = (PetscBool)(stage->kind == STAGE_FLOOD);
  const char *const unit = flood ? "m" : stage->what == REDUCE_FRICTION ? "degree" : "-";
  fprintf(f, "      \"%s\": {\n        ", flood ? "flood" : "strength_reduction");
  JsonText(f, "unit", unit, ", ");
  if (!flood) JsonText(f, "what", stage->what == REDUCE_FRICTION ? "friction" : "strengths", ", ");
  JsonNumber(f, "stable", trials->stable, ", ");
  JsonNumber(f, "failing", trials->failing, ", ");
  JsonNumber(f, "width", fabs(trials->failing - trials->stable), ",\n        ");
  if (!flood && stage->what == REDUCE_FRICTION) JsonNumber(f, "friction", trials->nominal, ", ");
  if (!flood) {
    JsonNumber(f, "safety_factor_stable", safety_factor(stage, trials, trials->stable), ", ");
    JsonNumber(f, "safety_factor_failing", safety_factor(stage, trials, trials->failing), ",\n        ");
  }
  fprintf(f, "\"trials\": [\n");
  for (PetscInt i = 0; i < trials->n; i++)
    fprintf(f, "%s%s\n", trials->json[i], i + 1 < trials->n ? "," : "");
  fprintf(f, "        ]\n      },\n");
}

/* Of each uplift load that acts: open length, and the diagram with its resultants on
   both sides of the drain. */
void SummaryUplift(FILE *f, const Problem *p)
{
  const Scene *scene = p->scene;
  const char *before = "      \"uplift\": {\n";
  for (PetscInt i = 0; i < p->stage->n_loads; i++) {
    const Load *load = scene->loads + p->stage->loads[i];
    const Uplift *u = p->state->uplift + p->stage->loads[i];
    UpliftDiagram d;
    PetscReal part[2] = {0., 0.};
    if (load->kind != LOAD_UPLIFT) continue;
    UpliftPressure(load, u, scene->gravity, &d);
    for (PetscInt k = 0; k + 1 < d.n; k++)
      part[d.s[k] >= load->drain] += 0.5 * (d.p[k] + d.p[k + 1]) * (d.s[k + 1] - d.s[k]) * scene->thickness;
    fprintf(f, "%s        \"%s\": {", before, load->name);
    JsonNumber(f, "open_length", u->crack, ", ");
    JsonCount(f, "rounds", u->rounds, ", ");
    JsonNumber(f, "length", u->length, ", ");
    JsonNumber(f, "to_drain", part[0], ", ");
    JsonNumber(f, "beyond_drain", part[1], ", \"diagram\": [");
    for (PetscInt k = 0; k < d.n; k++) fprintf(f, "%s[%.17g, %.17g]", k ? ", " : "", d.s[k], d.p[k]);
    fprintf(f, "]}");
    before = ",\n";
  }
  if (before[0] == ',') fprintf(f, "\n      },\n");
}

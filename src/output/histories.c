/* histories.c: keeps the values of joints, supports and points at the checks of a dynamic stage until the
   stage ends: the rows of joint_history.csv and anchor_history.csv, columns of history.csv, the peaks of
   summary.json. */
#include "output/output.h"

static const Peak None = {NAN, NAN, NAN, NAN, NAN, NAN};

static PetscInt peaks_of(const Histories *h)
{
  return h->n_joints * LOOK_COLUMNS + 2 * (h->n_supports + 1) + 4 * h->n_points + h->n_things;
}

PetscErrorCode HistoriesCreate(const Problem *p, Histories *h)
{
  const TermView view = ViewOf(p);
  TermRecord things;
  PetscFunctionBeginUser;
  PetscCall(HistoriesDestroy(h));
  PetscCall(TermsRecord(&view, &things));
  *h = (Histories){.n_joints = p->scene->n_joints,
                   .n_supports = p->scene->n_supports,
                   .n_points = p->m->n_points,
                   .n_things = things.n_rows * things.n_columns,
                   .joint_time = NAN,
                   .things_time = NAN};
  PetscCall(PetscCalloc1(2 * h->n_joints + 1, &h->direction));
  PetscCall(PetscCalloc1(h->n_joints + 1, &h->carried));
  PetscCall(PetscCalloc1(LOOK_COLUMNS * h->n_joints + 1, &h->joint));
  PetscCall(PetscCalloc1(2 * h->n_supports + 1, &h->support));
  PetscCall(PetscMalloc1(peaks_of(h), &h->joint_peak)); // one memory for all
  for (PetscInt i = 0; i < peaks_of(h); i++) h->joint_peak[i] = None;
  h->support_peak = h->joint_peak + h->n_joints * LOOK_COLUMNS;
  h->probe_peak = h->support_peak + 2 * (h->n_supports + 1);
  h->things_peak = h->probe_peak + 4 * h->n_points;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HistoriesDestroy(Histories *h)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(h->direction));
  PetscCall(PetscFree(h->carried));
  PetscCall(PetscFree(h->joint));
  PetscCall(PetscFree(h->support));
  PetscCall(PetscFree(h->lets_through));
  PetscCall(PetscFree(h->joint_peak));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HistoriesBegin(const Problem *p)
{
  Histories *h = &p->output->histories;
  MeshFields mesh;
  StageFields fields;
  PetscMPIInt n;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(&fields, sizeof(fields)));
  PetscCall(GatherMesh(p->m, &mesh));
  PetscCall(GatherContacts(p->m, p->state, p->contacts, p->stage, &mesh, &fields));
  if (!p->m->rank) JointDirections(h->n_joints, &fields, h->direction);
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(GatherMeshDestroy(&mesh));
  PetscCall(PetscMPIIntCast(2 * h->n_joints, &n));
  PetscCallMPI(MPI_Bcast(h->direction, n, MPIU_REAL, 0, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HistoriesArchive(Archive *a, const Problem *p)
{
  Histories *h = &p->output->histories;
  PetscFunctionBeginUser;
  PetscCall(ArchiveReals(a, "joint_directions", 2 * h->n_joints, h->direction));
  PetscCall(ArchiveReals(a, "slips_carried", h->n_joints, h->carried));
  PetscCall(ArchiveReals(a, "peaks", PEAK_REALS * peaks_of(h), &h->joint_peak->first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void HistoriesOfProbes(const Problem *p)
{
  const Output *o = p->output;
  const Histories *h = &o->histories;
  PetscReal ground[2] = {NAN, NAN};
  if (p->stage->kind != STAGE_DYNAMIC) return;
  if (o->ground_moves) GroundPlace(&o->ground, p->state->time, ground);
  for (PetscInt i = 0; i < h->n_points; i++)
    for (int x = 0; x < 2; x++) {
      const PetscReal u = o->probes[4 * i + 2 + x];
      PeakTake(h->probe_peak + 4 * i + x, u, p->state->time);
      PeakTake(h->probe_peak + 4 * i + 2 + x, u - ground[x], p->state->time);
    }
}

PetscErrorCode HistoriesSample(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(JointHistorySample(p));
  PetscCall(TermHistorySample(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void HistoriesRows(const Problem *p)
{
  JointHistoryRows(p);
  TermHistoryRows(p);
}

/* ---- summary.json */

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
    const Peak *peak = p->output->histories.joint_peak + LOOK_COLUMNS * j;
    if (PetscIsNanReal(peak[LOOK_LENGTH].first)) continue;
    put_name(f, p->scene->joints[j].name, n++);
    PeakLargest(f, "slip", peak + LOOK_SLIP, PETSC_TRUE, ",\n            ");
    PeakLargest(f, "slip_largest", peak + LOOK_SLIP_LARGEST, PETSC_TRUE, ",\n            ");
    PeakLargest(f, "opening", peak + LOOK_OPENING, PETSC_FALSE, ",\n            ");
    PeakLargest(f, "open_length", peak + LOOK_OPEN, PETSC_FALSE, ",\n            ");
    PeakLeast(f, "factor_peak", peak + LOOK_FACTOR_PEAK, ",\n            ");
    PeakLeast(f, "factor_residual", peak + LOOK_FACTOR_RESIDUAL, ",\n            ");
    PeakRange(f, "N", peak + LOOK_N, ",\n            ");
    PeakRange(f, "T", peak + LOOK_T, "}");
  }
  fprintf(f, "\n        },\n");
}

static void put_supports(FILE *f, const Problem *p)
{
  const Histories *h = &p->output->histories;
  fprintf(f, "        \"supports\": {");
  for (PetscInt i = 0; i < h->n_supports; i++) {
    put_name(f, p->scene->supports[i].name, i);
    for (int x = 0; x < 2; x++) PeakRange(f, x ? "y" : "x", h->support_peak + 2 * i + x, x ? "}" : ", ");
  }
  fprintf(f, "\n        },\n        \"base_shear\": {");
  for (int x = 0; x < 2; x++)
    PeakRange(f, x ? "y" : "x", h->support_peak + 2 * h->n_supports + x, x ? "},\n" : ", ");
}

static void put_probes(FILE *f, const Problem *p)
{
  static const char *const names[] = {"u_x", "u_y", "relative_x", "relative_y"};
  const Histories *h = &p->output->histories;
  const int n = p->output->ground_moves ? 4 : 2;
  fprintf(f, "        \"probes\": {");
  for (PetscInt i = 0; i < h->n_points; i++) {
    put_name(f, p->m->point_names[i], i);
    for (int k = 0; k < n; k++)
      PeakRange(f, names[k], h->probe_peak + 4 * i + k, k + 1 < n ? ",\n            " : "}");
  }
  fprintf(f, "\n        }\n");
}

void SummaryPeaks(FILE *f, const Problem *p)
{
  if (!p->output->histories.support) return;
  fprintf(f, "      \"peaks\": {\n        "); // peaks at the checks; larger values between them are not seen
  JsonNumber(f, "sampled_every", p->output->histories.every, ",\n");
  put_joints(f, p);
  put_supports(f, p);
  TermHistoryPeaks(f, p);
  put_probes(f, p);
  fprintf(f, "      },\n");
}

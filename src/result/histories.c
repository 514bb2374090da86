/* histories.c: keeps the values of joints, supports and points at the checks of a dynamic stage until the
   stage ends: the rows of joint_history.csv and anchor_history.csv, columns of history.csv, the peaks of
   summary.json. */
#include "result/result.h"

static const Peak None = {NAN, NAN, NAN, NAN, NAN, NAN};

static PetscInt peaks_of(const Histories *h)
{
  return h->n_joints * CHECK_COLUMNS + 2 * (h->n_supports + 1) + 4 * h->n_points + h->n_things;
}

PetscErrorCode HistoriesCreate(const Problem *p, Histories *h)
{
  const TermView view = ViewOf(p);
  AnchorRecord things;
  PetscFunctionBeginUser;
  PetscCall(HistoriesDestroy(h));
  PetscCall(TermsRecord(&view, &things));
  *h = (Histories){.n_joints = p->scene->n_joints,
                   .n_supports = p->scene->n_supports,
                   .n_points = p->m->mesh.n_points,
                   .n_things = things.n_rows * things.n_columns,
                   .joint_time = NAN,
                   .things_time = NAN};
  PetscCall(PetscCalloc1(2 * h->n_joints + 1, &h->direction));
  PetscCall(PetscCalloc1(h->n_joints + 1, &h->carried));
  PetscCall(PetscCalloc1(CHECK_COLUMNS * h->n_joints + 1, &h->joint));
  PetscCall(PetscCalloc1(2 * h->n_supports + 1, &h->support));
  PetscCall(PetscMalloc1(peaks_of(h), &h->joint_peak)); // one memory for all
  for (PetscInt i = 0; i < peaks_of(h); i++) h->joint_peak[i] = None;
  h->support_peak = h->joint_peak + h->n_joints * CHECK_COLUMNS;
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
  Histories *h = &p->found->histories;
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
  Histories *h = &p->found->histories;
  PetscFunctionBeginUser;
  PetscCall(ArchiveReals(a, "joint_directions", 2 * h->n_joints, h->direction));
  PetscCall(ArchiveReals(a, "slips_carried", h->n_joints, h->carried));
  PetscCall(ArchiveReals(a, "peaks", PEAK_REALS * peaks_of(h), &h->joint_peak->first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void HistoriesOfProbes(const Problem *p)
{
  const Result *r = p->found;
  const Histories *h = &r->histories;
  PetscReal ground[2] = {NAN, NAN};
  if (!StageInTime(p->stage)) return;
  if (r->ground_moves) GroundPlace(&r->ground, p->state->time, ground);
  for (PetscInt i = 0; i < h->n_points; i++)
    for (int x = 0; x < 2; x++) {
      const PetscReal u = r->probes[i].u[x];
      PeakTake(h->probe_peak + 4 * i + x, u, p->state->time);
      PeakTake(h->probe_peak + 4 * i + 2 + x, u - ground[x], p->state->time);
    }
}

PetscErrorCode TermHistorySample(const Problem *p)
{
  const TermView view = ViewOf(p);
  Histories *h = &p->found->histories;
  AnchorRecord *record = &h->things;
  PetscFunctionBeginUser;
  PetscCall(TermsRecord(&view, record));
  h->things_time = record->n_rows ? p->state->time : NAN;
  for (PetscInt i = 0; i < record->n_rows * record->n_columns && StageInTime(p->stage); i++)
    if (!PetscIsNanReal(record->values[i - i % record->n_columns]))
      PeakTake(h->things_peak + i, record->values[i], h->things_time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HistoriesSample(const Problem *p)
{
  PetscFunctionBeginUser;
  PetscCall(JointHistorySample(p));
  PetscCall(TermHistorySample(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* joint_history.c: finds forces, slip and opening of each joint at the checks of a dynamic stage, for
   joint_history.csv.

   Each rank reads its own contacts; the sums have the same bits on any number of ranks. A joint that
   was a line when the stage began has resultants, with the signs of summary_joints.c; for other joints the
   magnitudes are summed. Forces are those that act across the joint at that time, dashpots included.

   Slip is the mean over the length, summed up over time. A new contact counts its slip from its start, so the
   slip that the mean loses as contacts change is added again. */
#include "result/result.h"

enum { SUM_N, SUM_T, SUM_SLIP, SUM_OPEN, SUM_LENGTH, SUMS };
enum { MOST_OPENING, MOST_SLIP, MOST_BACK, MOSTS }; /* slip forwards, backwards */

/* Data found by a rank. */
typedef struct {
  PetscInt n, *slot; /* (n,) row of a term: SUMS joint + which */
  PetscReal *term;   /* (n,) */
  PetscReal *most;   /* (n_joints, MOSTS) */
} Found;

static void add(Found *found, PetscInt joint, int which, PetscReal value)
{
  found->slot[found->n] = SUMS * joint + which;
  found->term[found->n++] = value;
}

/* Finds the normal force [N], compression positive, and the shear force of an end, as in summary_joints.c. */
static void end_forces(const PetscReal e[2], const PetscReal n[2], PetscReal F_n, PetscReal F_s,
                       PetscReal f[2])
{
  const PetscReal side = n[1] * e[0] - n[0] * e[1] >= 0. ? 1.
                                                         : -1.; // 1: the force acts on side b, the lower one
  const PetscReal R[2] = {side * (F_n * n[0] - F_s * n[1]), side * (F_n * n[1] + F_s * n[0])};
  f[0] = R[0] * e[1] - R[1] * e[0];
  f[1] = R[0] * e[0] + R[1] * e[1];
}

/* Returns the signed slip at end k along the joint; its magnitude if the joint is not a straight line. */
static PetscReal slip_of(const Problem *p, PetscInt i, int k)
{
  const Contacts *c = p->contacts;
  const PetscReal *e = p->found->histories.direction + 2 * c->joint[i], slip = c->slip[SUB(i, k)];
  return e[0] != 0. || e[1] != 0. ? -slip : PetscAbsReal(slip);
}

static void add_contact_extremes(const Problem *p, PetscInt i, StressModelKind kind, Found *found)
{
  const Contacts *c = p->contacts;
  const PetscInt j = c->joint[i];
  const PetscReal *e = p->found->histories.direction + 2 * j, *u = p->state->u + 3 * p->m->rigid.n;
  const PetscBool line = (PetscBool)(e[0] != 0. || e[1] != 0.);
  const int ends = ContactEnds(c, i);
  PetscReal *most = found->most + MOSTS * j, force[2] = {0., 0.}, slip = 0., length, open, n[2];
  ContactLengths(p, i, kind, &length, &open);
  for (int k = 0; k < 2; k++) { // both ends of a vertex on a face are at the vertex
    const PetscInt at = SUB(i, k);
    const PetscReal F_n = p->m->materials.thickness * c->F_n[at],
                    F_s = p->m->materials.thickness * c->F_s[at];
    PetscReal f[2] = {-F_n, PetscAbsReal(F_s)};
    if (line) {
      ContactNormal(p->m, u, c, i, k < ends ? k : 0, n);
      end_forces(e, n, F_n, F_s, f);
    }
    force[0] += f[0], force[1] += f[1];
    if (k >= ends) continue;
    const PetscReal way = slip_of(p, i, k);
    slip += way / ends;
    most[MOST_OPENING] = PetscMax(most[MOST_OPENING], c->u_n[at]);
    most[MOST_SLIP] = PetscMax(most[MOST_SLIP], way);
    most[MOST_BACK] = PetscMax(most[MOST_BACK], -way);
  }
  add(found, j, SUM_N, force[0]);
  add(found, j, SUM_T, force[1]);
  add(found, j, SUM_SLIP, slip * length);
  add(found, j, SUM_OPEN, open);
  add(found, j, SUM_LENGTH, length);
}

static PetscReal mean(PetscReal sum, PetscReal length)
{
  return length > 0. ? sum / length : 0.;
}

/* Computes the numbers of a joint from the data of all ranks; NaN: it has no contacts. */
static void numbers(const Joint *joint, PetscReal thickness, PetscReal carried, const PetscReal sum[SUMS],
                    const PetscReal most[MOSTS], PetscReal row[CHECK_COLUMNS])
{
  const PetscReal on = most[MOST_SLIP] + carried, back = carried - most[MOST_BACK];
  const PetscReal closed = PetscMax(0., sum[SUM_LENGTH] - sum[SUM_OPEN]);
  for (int k = 0; k < CHECK_COLUMNS; k++) row[k] = NAN;
  if (most[MOST_OPENING] == PETSC_NINFINITY) return;
  row[CHECK_N] = sum[SUM_N], row[CHECK_T] = sum[SUM_T];
  row[CHECK_FACTOR_PEAK] = SlidingFactor(joint, sum[SUM_N], sum[SUM_T], closed, thickness, 0);
  row[CHECK_FACTOR_RESIDUAL] = SlidingFactor(joint, sum[SUM_N], sum[SUM_T], closed, thickness, 1);
  row[CHECK_SLIP] = carried + mean(sum[SUM_SLIP], sum[SUM_LENGTH]);
  row[CHECK_SLIP_LARGEST] = -back > on ? back : on;
  row[CHECK_OPENING] = most[MOST_OPENING];
  row[CHECK_OPEN] = sum[SUM_OPEN], row[CHECK_LENGTH] = sum[SUM_LENGTH];
}

static void take_peaks(Histories *h, PetscReal time)
{
  for (PetscInt i = 0; i < CHECK_COLUMNS * h->n_joints; i++) PeakTake(h->joint_peak + i, h->joint[i], time);
}

PetscErrorCode JointHistorySample(const Problem *p)
{
  const Contacts *c = p->contacts;
  Histories *h = &p->found->histories;
  const PetscInt n_joints = h->n_joints;
  Found found = {.n = 0};
  PetscReal *sum;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(SUMS * c->n, &found.slot, SUMS * c->n, &found.term));
  PetscCall(PetscMalloc2(MOSTS * n_joints, &found.most, SUMS * n_joints, &sum));
  for (PetscInt i = 0; i < MOSTS * n_joints; i++) found.most[i] = PETSC_NINFINITY;
  for (int kind = 0; kind < STRESS_MODELS; kind++)
    for (PetscInt i = c->model_start[kind]; i < c->model_start[kind + 1]; i++)
      if (c->key[2 * i] >= 0 && c->owned[i]) add_contact_extremes(p, i, (StressModelKind)kind, &found);
  PetscCall(BinnedSums(p->m->comm, found.n, found.slot, found.term, SUMS * n_joints, sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, found.most, (PetscMPIInt)(MOSTS * n_joints), MPIU_REAL, MPI_MAX,
                             p->m->comm));
  for (PetscInt j = 0; j < n_joints; j++)
    numbers(p->stage->joints + j, p->m->materials.thickness, h->carried[j], sum + SUMS * j,
            found.most + MOSTS * j, h->joint + CHECK_COLUMNS * j);
  h->joint_time = p->state->time;
  take_peaks(h, h->joint_time);
  PetscCall(PetscFree2(found.slot, found.term));
  PetscCall(PetscFree2(found.most, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JointSlipsCarry(const Problem *p, PetscReal sign)
{
  const Contacts *c = p->contacts;
  Histories *h = &p->found->histories;
  PetscInt n = 0, *slot;
  PetscReal *term, *sum, length, open;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(2 * c->n, &slot, 2 * c->n, &term, 2 * h->n_joints, &sum));
  for (int kind = 0; kind < STRESS_MODELS; kind++)
    for (PetscInt i = c->model_start[kind]; i < c->model_start[kind + 1]; i++) {
      if (c->key[2 * i] < 0 || !c->owned[i]) continue;
      ContactLengths(p, i, (StressModelKind)kind, &length, &open);
      const int ends = ContactEnds(c, i);
      PetscReal slip = 0.;
      for (int k = 0; k < ends; k++) slip += slip_of(p, i, k) / ends;
      slot[n] = 2 * c->joint[i], term[n++] = slip * length;
      slot[n] = 2 * c->joint[i] + 1, term[n++] = length;
    }
  PetscCall(BinnedSums(p->m->comm, n, slot, term, 2 * h->n_joints, sum));
  for (PetscInt j = 0; j < h->n_joints; j++) h->carried[j] += sign * mean(sum[2 * j], sum[2 * j + 1]);
  PetscCall(PetscFree3(slot, term, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

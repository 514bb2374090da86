/* contact_force.c: every cycle, for every contact: opening and slip of its two sub-contacts (1)-(4), stresses
   (5)-(6) by its stress model and joint law, forces to the vertices of both faces; LANES contacts at once.

   Kinematics in total form. With q = (1-t) A + t B the point of the destination face under P (t = L_d /
   length) and d = P - q, u_n = d.n,  u_s = d.s,   s = (B - A)/|B - A|,  n = s turned clockwise: out of the
   destination block, in the present positions: the sum of the increments (3)-(4), but exact under rotation
   and free of drift. The forces are the derivatives of int sigma du_n + int tau du_s with respect to the
   vertices. n and s turn with A-B by d(theta) = -n.(dB - dA)/|B - A|, which adds a couple C = F_n u_s - F_s
   u_n on the destination face: with it contacts keep angular momentum and energy. (Small strain: n, s of the
   reference state, no couple.) */
#include "internal.h"
#include "stress_models.h"

/* One sub-contact of LANES contacts. */
typedef struct {
  LanesVector s, n;    /* along the destination face, and out of it */
  Lanes inv_length, t; /* of the destination face; place of P on it */
  Lanes d_n, d_s;      /* d.n, d.s before `rest` */
} LanesEnd;

/* vertex: rows P A B; t, gap: rows of this sub-contact. */
KERNEL LanesEnd Kinematics(const PetscReal *X, const PetscReal *u, const PetscInt *vertex, const PetscReal *t,
                           const PetscReal *gap, PetscReal moving)
{
  const LanesVector uP = GatherVertex(u, vertex), uA = GatherVertex(u, vertex + BATCH),
                    uB = GatherVertex(u, vertex + 2 * BATCH);
  const LanesVector XA = GatherVertex(X, vertex + BATCH), XB = GatherVertex(X, vertex + 2 * BATCH);
  const Lanes tk = LoadLanes(t);
  const LanesVector q = {(1. - tk) * uA.x + tk * uB.x, (1. - tk) * uA.y + tk * uB.y};
  const LanesVector d = {LoadLanes(gap) + (uP.x - q.x), LoadLanes(gap + BATCH) + (uP.y - q.y)};
  const LanesVector e = VectorAdd(VectorSubtract(XB, XA), VectorScale(moving, VectorSubtract(uB, uA)));
  const Lanes inv = 1. / SquareRoot(VectorDot(e, e));
  const LanesVector s = {e.x * inv, e.y * inv}, n = {s.y, -s.x};
  return (LanesEnd){s, n, inv, tk, VectorDot(d, n), VectorDot(d, s)}; /* (3), (4) */
}

/* Dashpots of closed ends in time: damping * k_n * d(u_n)/dt over the end's half of the contact; a joint
   never pulls. at: first lane of end 0. */
static void dashpots(PetscInt at, Contacts *c, const Joint *joints, const PetscInt *joint, LanesContact *now)
{
  for (int lane = 0; lane < LANES; lane++) {
    const Joint *j = joints + joint[lane];
    for (int k = 0; k < 2 && j->damping > 0.; k++) {
      const PetscInt i = at + k * BATCH + lane;
      c->speed[i] = (now->u_n[k][lane] - c->u_n[i]) * c->rate;
      if (now->sigma[k][lane] >= 0.) continue;
      now->F_n[k][lane] = PetscMin(0., now->F_n[k][lane] +
                                           0.5 * now->length[lane] * j->damping * j->k_n * c->speed[i]);
    }
  }
}

/* End forces to P and, by L_d, to A and B. */
KERNEL void EndForces(const LanesEnd *end, Lanes F_n, Lanes F_s, PetscReal moving, LanesVector force[3])
{
  const Lanes couple = moving * (F_n * end->d_s - F_s * end->d_n) * end->inv_length;
  const LanesVector F = {F_n * end->n.x + F_s * end->s.x, F_n * end->n.y + F_s * end->s.y};
  const LanesVector turn = {couple * end->n.x, couple * end->n.y};
  const Lanes a = 1. - end->t, b = end->t;
  force[0] = F;
  force[1] = (LanesVector){turn.x - a * F.x, turn.y - a * F.y};
  force[2] = (LanesVector){-turn.x - b * F.x, -turn.y - b * F.y};
}

/* at: first lane of end 0 in the arrays (.., 2, BATCH). */
KERNEL void StoreResults(PetscInt at, const LanesEnd *end, const LanesContact *now, Contacts *c)
{
  for (int k = 0; k < 2; k++) {
    const PetscInt i = at + k * BATCH;
    StoreLanes(c->u_n + i, now->u_n[k]), StoreLanes(c->u_s + i, end[k].d_s);
    StoreLanes(c->sigma + i, now->sigma[k]), StoreLanes(c->tau + i, now->tau[k]);
    StoreLanes(c->F_n + i, now->F_n[k]), StoreLanes(c->F_s + i, now->F_s[k]);
    for (int lane = 0; lane < LANES; lane++) c->state[i + lane] = (PetscInt)now->state[k][lane];
  }
}

/* LANES contacts from `first` on; J: their joints. */
KERNEL void LanesForces(const Model *m, const Joint *joints, const LanesModel *model, const LanesJoint *J,
                        PetscInt first, int keep, Contacts *c, const PetscReal *u, PetscReal *f)
{
  const PetscReal moving = m->strain == STRAIN_LARGE ? 1. : 0., thickness = m->thickness;
  const PetscInt batch = first / BATCH, lane = first % BATCH, at = batch * 2 * BATCH + lane;
  const PetscInt *vertex = c->vertex + batch * 6 * BATCH + lane;
  const PetscReal *gap = c->gap + batch * 4 * BATCH + lane;
  const PetscReal *slip = c->held ? c->slip_0 : c->slip, *broken = c->held ? c->broken_0 : c->broken;
  LanesContact now = {.length = LoadLanes(c->length + first)};
  LanesEnd end[2];
  LanesVector force[6];

  for (int k = 0; k < 2; k++) {
    const PetscInt i = at + k * BATCH;
    end[k] = Kinematics(m->X, u, vertex + 3 * k * BATCH, c->t + i, gap + 2 * k * BATCH, moving);
    now.u_n[k] = end[k].d_n - LoadLanes(c->rest + i), now.u_s[k] = end[k].d_s;
    now.slip[k] = LoadLanes(slip + i), now.broken[k] = LoadLanes(broken + i);
  }
  const int changed = RespondContacts(J, model, c->rate != 0., &now);
  if (c->held ? keep : changed)
    for (int k = 0; k < 2; k++)
      StoreLanes(c->slip + at + k * BATCH, now.slip[k]),
          StoreLanes(c->broken + at + k * BATCH, now.broken[k]);
  if (keep && c->rate > 0.) dashpots(at, c, joints, c->joint + first, &now);
  if (keep) StoreResults(at, end, &now, c);
  for (int k = 0; k < 2; k++)
    EndForces(end + k, thickness * now.F_n[k], thickness * now.F_s[k], moving, force + 3 * k);
  ScatterAdd(6, force, vertex, f);
}

/* All contacts, in ascending order. Joints change seldom from one batch to the next. */
KERNEL void ForceLoop(const Model *m, const Joint *joints, int keep, Contacts *c, const PetscReal *u,
                      PetscReal *f)
{
  PetscInt loaded[LANES] = {-1, -1, -1, -1};
  LanesJoint J;
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt first = c->model_start[s]; first < c->model_start[s + 1]; first += LANES) {
      if (memcmp(loaded, c->joint + first, sizeof loaded)) {
        memcpy(loaded, c->joint + first, sizeof loaded);
        LoadJoints(joints, loaded, &J);
      }
      LanesForces(m, joints, LanesModels + s, &J, first, keep, c, u, f);
    }
}

KERNEL void AndResults_code(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                            PetscReal *f)
{
  ForceLoop(m, joints, 1, c, u, f);
}

KERNEL void ForcesAlone_code(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                             PetscReal *f)
{
  ForceLoop(m, joints, 0, c, u, f);
}

VARIANTS(AndResults, (const Model *m, const Joint *joints, Contacts *c, const PetscReal *u, PetscReal *f),
         (m, joints, c, u, f))
VARIANTS(ForcesAlone, (const Model *m, const Joint *joints, Contacts *c, const PetscReal *u, PetscReal *f),
         (m, joints, c, u, f))

PetscErrorCode ContactForces(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                             PetscReal *f)
{
  PetscFunctionBeginUser;
  AndResults(m, joints, c, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactForcesOnly(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                                 PetscReal *f)
{
  PetscFunctionBeginUser;
  ForcesAlone(m, joints, c, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

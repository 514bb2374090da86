/* contact_force.c: every cycle, for every contact: opening and slip of its two sub-contacts (1)-(4), stresses
   (5)-(6) by its stress model and joint law, forces to the vertices of both faces; LANES contacts at once.

   Kinematics in total form. With q = A + t (B - A) the point of the destination face under P (t = L_d /
   length) and d = P - q, u_n = d.n,  u_s = d.s,   s = (B - A)/|B - A|,  n = s turned clockwise: out of the
   destination block, in the present positions: the sum of the increments (3)-(4), but exact under rotation
   and free of drift; d adds that of the reference state and that of the displacements, so that a joint that
   moves by 1e-9 m loses no digits to coordinates of 100 m. The forces are the derivatives of int sigma du_n +
   int tau du_s with respect to the vertices. n and s turn with A-B by d(theta) = -n.(dB - dA)/|B - A|, which
   adds a couple C = F_n u_s - F_s u_n on the destination face: with it contacts keep angular momentum and
   energy. (Small strain: n, s of the reference state, no couple.)

   What a cycle reads, not what it computes, is half of its time; so LANES contacts read four vertices once
   for both ends, and by their traits leave out what they do not need: where both ends stand on one face (FF1,
   all of a mesh whose faces match) its direction is found once; initial overlap and history that are all zero
   are not read. An answer has the same bits with and without. */
#include "internal.h"
#include "stress_models.h"

/* Traits of LANES contacts: by lane, whether end 1 stands on the other face than end 0 (FF2), and then
   whether the ends are the last vertices of both faces (FF2_F); of any lane. */
enum {
  CROSSED = 1,      /* << lane */
  LAST = 1 << 4,    /* << lane */
  RESTS = 1 << 8,   /* rest is not zero */
  HISTORY = 1 << 9, /* slip or broken, present or held, is not zero; the force loop adds it */
  JOINTS = 1 << 10, /* joints are not those of the LANES contacts before */
};
static const int IS_CROSSED = CROSSED * 15;

/* By their bits: -0 leaves another sign of zero behind. */
static int are_zero(PetscInt first, const PetscReal *x)
{
  uint64_t bits[2 * LANES], any = 0;
  memcpy(bits, x + SUB(first, 0), LANES * sizeof *x);
  memcpy(bits + LANES, x + SUB(first, 1), LANES * sizeof *x);
  for (int i = 0; i < 2 * LANES; i++) any |= bits[i];
  return !any;
}

void ContactsSetTraits(Contacts *c)
{
  for (PetscInt first = 0; first < c->n_padded; first += LANES) {
    const PetscInt *joint = c->joint + first;
    int traits = !first || memcmp(joint - LANES, joint, LANES * sizeof *joint) ? JOINTS : 0;
    for (int lane = 0; lane < LANES; lane++) {
      const int klass = c->klass[first + lane];
      if (klass == FF2_I || klass == FF2_F) traits |= CROSSED << lane;
      if (klass == FF2_F) traits |= LAST << lane;
    }
    if (!are_zero(first, c->rest)) traits |= RESTS;
    if (!are_zero(first, c->slip) || !are_zero(first, c->broken) || !are_zero(first, c->slip_0) ||
        !are_zero(first, c->broken_0))
      traits |= HISTORY;
    c->traits[first / LANES] = (uint16_t)traits;
  }
}

/* Where no history is, both are zero. */
static void copy_history(const Contacts *c, const PetscReal *slip, const PetscReal *broken,
                         PetscReal *slip_to, PetscReal *broken_to)
{
  for (PetscInt first = 0; first < c->n_padded; first += LANES)
    for (int k = 0; k < 2 && c->traits[first / LANES] & HISTORY; k++) {
      const PetscInt at = SUB(first, k);
      memcpy(slip_to + at, slip + at, LANES * sizeof *slip);
      memcpy(broken_to + at, broken + at, LANES * sizeof *broken);
    }
}

void ContactsHold(Contacts *c)
{
  copy_history(c, c->slip, c->broken, c->slip_0, c->broken_0);
  c->held = PETSC_TRUE;
}

void ContactsGoBack(Contacts *c)
{
  copy_history(c, c->slip_0, c->broken_0, c->slip, c->broken);
}

/* Masks of lanes: ends on one face, FF2_I; the others are FF2_F. */
typedef struct {
  Mask one, first;
} Classes;

KERNEL Classes ClassesOf(int traits)
{
  const Mask bit = {1, 2, 4, 8}, all = {traits, traits, traits, traits};
  const Mask crossed = (all & bit) != 0, last = (all & (bit * LAST)) != 0;
  return (Classes){~crossed, ~last};
}

/* In the lanes of each class its own. */
KERNEL LanesVector VectorByClass(const Classes *is, LanesVector one, LanesVector first, LanesVector last)
{
  return (LanesVector){Select(is->one, one.x, Select(is->first, first.x, last.x)),
                       Select(is->one, one.y, Select(is->first, first.y, last.y))};
}

/* A vector between vertices of LANES contacts: in the reference state, and by how much it has changed. */
typedef struct {
  LanesVector X, u;
} Reach;

KERNEL Reach ReachSubtract(Reach p, Reach q)
{
  return (Reach){VectorSubtract(p.X, q.X), VectorSubtract(p.u, q.u)};
}

/* In the lanes of each class its own. */
KERNEL Reach ReachByClass(const Classes *is, Reach one, Reach first, Reach last)
{
  return (Reach){VectorByClass(is, one.X, first.X, last.X), VectorByClass(is, one.u, first.u, last.u)};
}

/* A destination face of LANES contacts. */
typedef struct {
  LanesVector s, n; /* along it, and out of it */
  Lanes inv_length;
} LanesFace;

/* AB: B - A */
KERNEL LanesFace FaceAlong(Reach AB, PetscReal moving)
{
  const LanesVector e = VectorAdd(AB.X, VectorScale(moving, AB.u));
  const Lanes inv = 1. / SquareRoot(VectorDot(e, e));
  const LanesVector s = {e.x * inv, e.y * inv};
  return (LanesFace){s, {s.y, -s.x}, inv};
}

/* One sub-contact of LANES contacts. */
typedef struct {
  LanesFace face;
  Lanes t;        /* place of P on it */
  Lanes d_n, d_s; /* d.n, d.s before `rest` */
} LanesEnd;

/* AP, AB: P - A, B - A */
KERNEL LanesEnd EndOn(const LanesFace *f, Reach AP, Reach AB, Lanes t)
{
  const LanesVector d = {(AP.X.x - t * AB.X.x) + (AP.u.x - t * AB.u.x),
                         (AP.X.y - t * AB.X.y) + (AP.u.y - t * AB.u.y)};
  return (LanesEnd){*f, t, VectorDot(d, f->n), VectorDot(d, f->s)}; /* (3), (4) */
}

/* vertex: rows P A B Q; t: of end 0. All vectors from A. crossed: some lane is. */
KERNEL void Kinematics(const PetscReal *X, const PetscReal *u, const PetscInt *vertex, const PetscReal *t,
                       PetscReal moving, int crossed, int traits, LanesEnd end[2])
{
  const PetscInt *row[] = {vertex + ROW_P * BATCH, vertex + ROW_B * BATCH, vertex + ROW_Q * BATCH};
  const LanesVector X_A = GatherVertex(X, vertex + ROW_A * BATCH),
                    u_A = GatherVertex(u, vertex + ROW_A * BATCH);
  Reach to[3];
  for (int i = 0; i < 3; i++)
    to[i] = (Reach){VectorSubtract(GatherVertex(X, row[i]), X_A),
                    VectorSubtract(GatherVertex(u, row[i]), u_A)};
  const Reach P = to[0], B = to[1], Q = to[2], A = {{{0.}, {0.}}, {{0.}, {0.}}};
  const LanesFace face = FaceAlong(B, moving);
  end[0] = EndOn(&face, P, B, LoadLanes(t));
  if (!crossed) {
    end[1] = EndOn(&face, Q, B, LoadLanes(t + BATCH));
  } else {
    const Classes is = ClassesOf(traits);
    const Reach from = ReachByClass(&is, A, P, Q), along = ReachSubtract(ReachByClass(&is, B, Q, P), from),
                over = ReachSubtract(ReachByClass(&is, Q, A, B), from);
    const LanesFace other = FaceAlong(along, moving);
    end[1] = EndOn(&other, over, along, LoadLanes(t + BATCH));
  }
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
  const LanesVector n = end->face.n, s = end->face.s;
  const Lanes couple = moving * (F_n * end->d_s - F_s * end->d_n) * end->face.inv_length;
  const LanesVector F = {F_n * n.x + F_s * s.x, F_n * n.y + F_s * s.y};
  const LanesVector turn = {couple * n.x, couple * n.y};
  const Lanes a = 1. - end->t, b = end->t;
  force[0] = F;
  force[1] = (LanesVector){turn.x - a * F.x, turn.y - a * F.y};
  force[2] = (LanesVector){-turn.x - b * F.x, -turn.y - b * F.y};
}

/* Forces of both ends, on the rows P A B Q: where the vertices of Kinematics came from. */
KERNEL void RowForces(const LanesEnd end[2], const LanesContact *now, PetscReal thickness, PetscReal moving,
                      int crossed, int traits, LanesVector force[CONTACT_ROWS])
{
  const LanesVector none = {{0.}, {0.}};
  LanesVector to[3];
  EndForces(end, thickness * now->F_n[0], thickness * now->F_s[0], moving, force);
  EndForces(end + 1, thickness * now->F_n[1], thickness * now->F_s[1], moving, to);
  const LanesVector P = to[0], A = to[1], B = to[2];
  if (!crossed) {
    force[ROW_A] = VectorAdd(force[ROW_A], A), force[ROW_B] = VectorAdd(force[ROW_B], B);
    force[ROW_Q] = P;
  } else {
    const Classes is = ClassesOf(traits);
    force[ROW_P] = VectorAdd(force[ROW_P], VectorByClass(&is, none, A, B));
    force[ROW_A] = VectorAdd(force[ROW_A], VectorByClass(&is, A, P, none));
    force[ROW_B] = VectorAdd(force[ROW_B], VectorByClass(&is, B, none, P));
    force[ROW_Q] = VectorByClass(&is, P, B, A);
  }
}

/* at: first lane of end 0 in the arrays (.., 2, BATCH). */
KERNEL void StoreResults(PetscInt at, const LanesEnd *end, const LanesContact *now, Contacts *c)
{
  for (int k = 0; k < 2; k++) {
    const PetscInt i = at + k * BATCH;
    StoreLanes(c->u_n + i, now->u_n[k]), StoreLanes(c->u_s + i, end[k].d_s);
    StoreLanes(c->sigma + i, now->sigma[k]), StoreLanes(c->tau + i, now->tau[k]);
    StoreLanes(c->F_n + i, now->F_n[k]), StoreLanes(c->F_s + i, now->F_s[k]);
    for (int lane = 0; lane < LANES; lane++) c->state[i + lane] = (uint8_t)now->state[k][lane];
  }
}

/* What all contacts share. */
typedef struct {
  const PetscReal *X, *u;
  const PetscReal *slip, *broken; /* history that an evaluation starts from */
  PetscReal moving, thickness;    /* moving: 1 with large strain, 0 */
  PetscReal *f;
} Shared;

/* Contacts from `first` on; J: their joints. */
KERNEL void LanesForces(const Shared *all, const Joint *joints, const LanesModel *model, const LanesJoint *J,
                        size_t first, int keep, Contacts *c)
{
  const size_t at = SUB(first, 0);
  const PetscInt *vertex = c->vertex + CONTACT_ROW(first, 0);
  const int traits = c->traits[first / LANES];
  LanesContact now = {.length = LoadLanes(c->length + first)};
  LanesVector force[CONTACT_ROWS];
  LanesEnd end[2];

  if (traits & IS_CROSSED)
    Kinematics(all->X, all->u, vertex, c->t + at, all->moving, 1, traits, end);
  else
    Kinematics(all->X, all->u, vertex, c->t + at, all->moving, 0, traits, end);
  for (int k = 0; k < 2; k++) {
    const size_t i = at + (size_t)k * BATCH;
    now.u_n[k] = end[k].d_n, now.u_s[k] = end[k].d_s;
    if (traits & RESTS) now.u_n[k] -= LoadLanes(c->rest + i);
    if (traits & HISTORY) now.slip[k] = LoadLanes(all->slip + i), now.broken[k] = LoadLanes(all->broken + i);
  }
  const int changed = RespondContacts(J, model, c->rate != 0., &now);
  if (c->held ? keep && (changed || traits & HISTORY) : changed) {
    for (int k = 0; k < 2; k++)
      StoreLanes(c->slip + at + k * BATCH, now.slip[k]),
          StoreLanes(c->broken + at + k * BATCH, now.broken[k]);
    c->traits[first / LANES] = (uint16_t)(traits | HISTORY);
  }
  if (keep && c->rate > 0.) dashpots((PetscInt)at, c, joints, c->joint + first, &now);
  if (keep) StoreResults((PetscInt)at, end, &now, c);
  if (traits & IS_CROSSED)
    RowForces(end, &now, all->thickness, all->moving, 1, traits, force);
  else
    RowForces(end, &now, all->thickness, all->moving, 0, traits, force);
  ScatterAdd(CONTACT_ROWS, force, vertex, all->f);
}

/* All contacts, in ascending order. */
KERNEL void ForceLoop(const Model *m, const Joint *joints, int keep, Contacts *c, const PetscReal *u,
                      PetscReal *f)
{
  const Shared all = {.X = m->X,
                      .u = u,
                      .slip = c->held ? c->slip_0 : c->slip,
                      .broken = c->held ? c->broken_0 : c->broken,
                      .moving = m->strain == STRAIN_LARGE ? 1. : 0.,
                      .thickness = m->thickness,
                      .f = f};
  LanesJoint J;
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt first = c->model_start[s]; first < c->model_start[s + 1]; first += LANES) {
      if (c->traits[first / LANES] & JOINTS) LoadJoints(joints, c->joint + first, &J);
      LanesForces(&all, joints, LanesModels + s, &J, (size_t)first, keep, c);
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

/* force.c: computes the forces of all contacts in every cycle, LANES contacts at once: opening and slip of
   the two sub-contacts (1)-(4), stresses (5)-(6) by the stress model and the joint law, forces on the
   vertices of both faces.

   Kinematics in total form. With q = A + t (B - A) the point of the destination face under P (t = L_d /
   length) and d = P - q, u_n = d.n,  u_s = d.s,   s = (B - A)/|B - A|,  n = s turned clockwise, out of the
   destination block, all in the present positions. This is the sum of the increments (3)-(4), but exact under
   rotation and free of drift. d is the sum of its value in the reference state and its change by the
   displacements, so that a joint that moves by 1e-9 m loses no digits to coordinates of 100 m. The forces are
   the derivatives of int sigma du_n + int tau du_s with respect to the vertices. n and s turn with A-B by
   d(theta) = -n.(dB - dA)/|B - A|, which adds a couple C = F_n u_s - F_s u_n on the destination face. With
   the couple contacts keep angular momentum and energy. (In small strain n and s are those of the reference
   state, and there is no couple.)

   Speed. LANES contacts read four vertices once for both ends, and by their traits leave out what they do not
   need. Where both ends stand on one face (FF1) its direction is found once. Where the faces match, as most
   do in meshes of blocks, P and Q start where B and A do, and d is their displacement relative to B and A.
   Initial overlap and history that are all zero are not read. A square root and a division stand between the
   vertices and the forces; in a single pass the next contacts would wait for them, a quarter of the time. So
   the loop goes over STRETCH contacts twice, first to find where they are (Place), then to find their forces.
   Contacts without history whose law holds elastically, nearly all, take a short way. The long ways are
   functions of their own, so that they take no registers from it. Contacts that slip in part are collected
   where nothing but their slip is kept (sorted.c). An answer has the same bits with and without any of
   this. */
#include "contacts/evaluation.h"

/* Returns the share of the time step in which ends are pressed that met within the last step: half a step and
   the time since they met. u, u_n: openings a step ago and now. moving: the closed part grows from an end
   that meets alone. */
KERNEL void SharesPressed(int moving, const Lanes u[2], const Lanes u_n[2], Lanes share[2])
{
  const Mask meets[2] = {(u[0] > 0.) & (u_n[0] < 0.), (u[1] > 0.) & (u_n[1] < 0.)};
  for (int k = 0; k < 2 && Any(meets[0] | meets[1]); k++) {
    const Mask counts = moving ? meets[0] & meets[1] : meets[k];
    share[k] = Select(counts, 0.5 + u_n[k] / Select(counts, u_n[k] - u[k], share[k]), share[k]);
  }
}

/* Computes the stress of dashpots: damping * k_n * d(u_n)/dt. The speed over the last step is the speed of
   half a step ago. Its change over two steps extrapolates it to now. This change vanishes where the speed
   alternates every other step, so the bound of the time step remains valid. An end without speed two steps
   ago is not extrapolated. at: place of the first lane of end 0. */
KERNEL void Dashpots(size_t at, const LanesJoint *J, int moving, LanesContact *now, Contacts *c)
{
  const Mask has = J->damping > 0.;
  const Lanes u[2] = {LoadLanes(c->u_n + at), LoadLanes(c->u_n + at + BATCH)};
  Lanes share[2] = {LanesOf(1.), LanesOf(1.)};
  if (!c->repeats) SharesPressed(moving, u, now->u_n, share);
  for (int k = 0; k < 2; k++) {
    const size_t i = at + (size_t)k * BATCH;
    Lanes speed_now = LoadLanes(c->speed_now + i);
    if (!c->repeats) {
      const Lanes speed = (now->u_n[k] - u[k]) * c->rate, before = LoadLanes(c->speed + i),
                  old = LoadLanes(c->speed_old + i);
      speed_now = Keep(has, share[k] * (speed + Keep(old != 0., c->lead * (speed - old))));
      StoreLanes(c->speed + i, Select(has, speed, before)), StoreLanes(c->speed_old + i, before);
      StoreLanes(c->speed_now + i, speed_now);
    }
    now->dashpot[k] = Keep(has, J->k_n * J->damping * speed_now);
  }
}

/* F: force of an end. turn: force that the couple on the face gives A; it gives B the opposite force. */
typedef struct {
  LanesVector F, turn;
} EndForce;

KERNEL EndForce EndForceOf(int k, const Place *p, const LanesFace *face, Lanes F_n, Lanes F_s)
{
  const LanesVector s = face->s, n = NormalTo(s);
  const Lanes couple = (F_n * p->d_s[k] - F_s * p->d_n[k]) * face->turns;
  return (EndForce){{F_n * n.x + F_s * s.x, F_n * n.y + F_s * s.y}, {couple * n.x, couple * n.y}};
}

/* Computes the forces on A and B: the share of F by L_d, and the couple. */
KERNEL LanesVector OnA(const EndForce *end, Lanes t)
{
  const Lanes a = 1. - t;
  return (LanesVector){end->turn.x - a * end->F.x, end->turn.y - a * end->F.y};
}

KERNEL LanesVector OnB(const EndForce *end, Lanes t)
{
  return (LanesVector){-end->turn.x - t * end->F.x, -end->turn.y - t * end->F.y};
}

/* Computes the forces of both ends on the vertices. force: in the rows P A B Q. */
KERNEL void RowForces(const Place *p, const PetscReal *t, const LanesContact *now, PetscReal thickness,
                      int traits, LanesVector force[CONTACT_ROWS])
{
  const int crossed = (traits & IS_CROSSED) != 0;
  const LanesVector none = {{0.}, {0.}};
  EndForce end[2];
  for (int k = 0; k < 2; k++)
    end[k] = EndForceOf(k, p, p->face + (k && crossed), thickness * now->F_n[k], thickness * now->F_s[k]);
  force[ROW_P] = VectorScale(1., end[0].F); // by component: a copy of 64 bytes waits for both halves
  if (traits & MATCH) {                     // t is 1 at end 0 and 0 at end 1
    force[ROW_A] = VectorAdd(end[0].turn, VectorSubtract(end[1].turn, end[1].F));
    force[ROW_B] = VectorSubtract(none, VectorAdd(VectorAdd(end[0].turn, end[0].F), end[1].turn));
    force[ROW_Q] = VectorScale(1., end[1].F);
    return;
  }
  const Lanes t_0 = LoadLanes(t), t_1 = LoadLanes(t + BATCH);
  force[ROW_A] = OnA(end, t_0), force[ROW_B] = OnB(end, t_0);
  const LanesVector P = end[1].F, A = OnA(end + 1, t_1), B = OnB(end + 1, t_1);
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

/* Writes the arrays of the last evaluation. at: place of the first lane of end 0, in (.., 2, BATCH). */
KERNEL void StoreResults(PetscInt at, const Place *p, const LanesContact *now, Contacts *c)
{
  for (int k = 0; k < 2; k++) {
    const PetscInt i = at + k * BATCH;
    StoreLanes(c->u_n + i, now->u_n[k]), StoreLanes(c->u_s + i, p->d_s[k]);
    StoreLanes(c->sigma + i, now->sigma[k]), StoreLanes(c->tau + i, now->tau[k]);
    StoreLanes(c->F_n + i, now->F_n[k]), StoreLanes(c->F_s + i, now->F_s[k]);
    for (int lane = 0; lane < LANES; lane++) c->state[i + lane] = (uint8_t)now->state[k][lane];
  }
}

enum { NOT_PLAIN = CROSSED * 15 | RESTS | HISTORY };

/* Adds the forces of LANES plain contacts from `first` on, and returns 1, when the law holds elastically in
   all of them. Otherwise changes nothing and returns 0. match: MATCH or 0, a constant, and so is keep. */
KERNEL int ElasticForces(const Evaluation *of, const LanesModel *model, const LanesJoint *J, int keep,
                         size_t first, const Place *p, int match)
{
  Contacts *c = of->c;
  LanesContact now;
  LanesVector force[CONTACT_ROWS];

  now.length = LoadLanes(c->length + first);
  for (int k = 0; k < 2; k++)
    now.u_n[k] = p->d_n[k], now.u_s[k] = p->d_s[k], now.slip[k] = now.broken[k] = LanesOf(0.);
  if (!RespondElastically(J, model, &now)) return 0;
  if (keep) StoreResults((PetscInt)SUB(first, 0), p, &now, c);
  RowForces(p, c->t + SUB(first, 0), &now, of->thickness, match, force);
  ScatterAdd(CONTACT_ROWS, force, c->vertex + CONTACT_ROW(first, 0), of->f);
  return 1;
}

/* Does the same as ElasticForces for any contacts: returns 0 also when they are not plain. */
KERNEL int PlainForces(const Evaluation *of, const LanesModel *model, const LanesJoint *J, int keep,
                       size_t first, const Place *p)
{
  const int traits = of->c->traits[first / LANES];
  if (traits & NOT_PLAIN) return 0;
  return traits & MATCH ? ElasticForces(of, model, J, keep, first, p, MATCH)
                        : ElasticForces(of, model, J, keep, first, p, 0);
}

KERNEL void StoreClosure(size_t first, const LanesContact *now, Contacts *c)
{
  for (int k = 0; k < 2; k++) {
    StoreLanes(c->closure + SUB(first, k), now->closure[k]);
    StoreLanes(c->closure_far + SUB(first, k), now->far[k]);
  }
  if (Any((now->closure[0] < 0.) | (now->closure[1] < 0.))) c->traits[first / LANES] |= CRUSHED;
}

/* Computes the response of LANES contacts from `first` on, whose friction is drawn towards the law. */
KERNEL void Follow(const Evaluation *of, const LanesModel *model, const LanesJoint *J, int closes,
                   size_t first, LanesContact *now)
{
  Contacts *c = of->c;
  const size_t at = SUB(first, 0);
  const int traits = c->traits[first / LANES];
  Lanes own[2] = {LanesOf(0.), LanesOf(0.)};
  for (int k = 0; k < 2 && traits & HISTORY; k++) own[k] = LoadLanes(c->slip + at + (size_t)k * BATCH);
  const int changed = RespondFollowing(J, model, of->pull, closes, own, now);
  if (closes) StoreClosure(first, now, c);
  if (!changed) return;
  for (int k = 0; k < 2; k++) {
    StoreLanes(c->slip + at + k * BATCH, own[k]);
    StoreLanes(c->broken + at + k * BATCH, now->broken[k]);
  }
  c->traits[first / LANES] |= HISTORY;
}

/* Adds the forces of LANES contacts from `first` on, in any state. closes, damped: constants, see
   RespondJoint; follow: a constant, whether of->pull > 0. */
KERNEL void WholeForces(const Evaluation *of, const LanesModel *model, const LanesJoint *J, int keep,
                        int closes, int damped, int follow, size_t first, const Place *p)
{
  Contacts *c = of->c;
  const size_t at = SUB(first, 0);
  const int traits = c->traits[first / LANES];
  LanesContact now;
  LanesVector force[CONTACT_ROWS];

  now.length = LoadLanes(c->length + first);
  for (int k = 0; k < 2; k++) {
    const size_t i = at + (size_t)k * BATCH;
    now.u_n[k] = p->d_n[k], now.u_s[k] = p->d_s[k], now.slip[k] = now.broken[k] = LanesOf(0.);
    if (traits & RESTS) now.u_n[k] -= LoadLanes(c->rest + i);
    if (traits & HISTORY)
      now.slip[k] = LoadLanes(of->from.slip + i), now.broken[k] = LoadLanes(of->from.broken + i);
    if (closes) now.closure[k] = LoadLanes(of->from.closure + i), now.far[k] = LoadLanes(of->from.far + i);
  }
  if (damped) Dashpots(at, J, model->moving, &now, c);
  const int changed = follow ? 0 : RespondContacts(J, model, c->rate != 0., closes, damped, &now);
  if (follow) {
    Follow(of, model, J, closes, first, &now);
  } else if (ContactsFromCommitted(c) ? keep && (changed || traits & HISTORY) : changed) {
    for (int k = 0; k < 2; k++)
      StoreLanes(c->slip + at + k * BATCH, now.slip[k]),
          StoreLanes(c->broken + at + k * BATCH, now.broken[k]);
    c->traits[first / LANES] = (uint16_t)(traits | HISTORY);
    if (closes) StoreClosure(first, &now, c);
  }
  if (keep) StoreResults((PetscInt)at, p, &now, c);
  RowForces(p, c->t + at, &now, of->thickness, traits, force);
  ScatterAdd(CONTACT_ROWS, force, c->vertex + CONTACT_ROW(first, 0), of->f);
}

KERNEL void AndResults_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                            const Place *p)
{
  if (!PlainForces(of, model, J, 1, first, p)) WholeForces(of, model, J, 1, 0, 0, 0, first, p);
}

KERNEL void ForcesAlone_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                             const Place *p)
{
  WholeForces(of, model, J, 0, 0, 0, 0, first, p);
}

/* Adds the forces of joints that soften. */
KERNEL void Softenable_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                            const Place *p)
{
  if (of->keep && J->damps && of->c->rate > 0.)
    WholeForces(of, model, J, 1, CLOSES | SOFTENS, 1, 0, first, p);
  else if (of->pull > 0.)
    WholeForces(of, model, J, of->keep, CLOSES | SOFTENS, 0, 1, first, p);
  else
    WholeForces(of, model, J, of->keep, CLOSES | SOFTENS, 0, 0, first, p);
}

#define PARAMETERS                                                                                           \
  (const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first, const Place *p)
VARIANTS(Softenable, PARAMETERS, (of, model, J, first, p))

/* Adds the forces of joints that can crush, and of contacts that were crushed. */
KERNEL void Crushable_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                           const Place *p)
{
  if (J->softens)
    Softenable(of, model, J, first, p);
  else if (of->pull > 0.)
    WholeForces(of, model, J, of->keep, CLOSES, 0, 1, first, p);
  else
    WholeForces(of, model, J, of->keep, CLOSES, 0, 0, first, p);
}

/* Adds the forces of joints with dashpots, in time. */
KERNEL void Damped_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                        const Place *p)
{
  if (J->softens)
    Softenable(of, model, J, first, p);
  else
    WholeForces(of, model, J, 1, CLOSES, 1, 0, first, p);
}

KERNEL void Following_code(const Evaluation *of, const LanesModel *model, const LanesJoint *J, size_t first,
                           const Place *p)
{
  WholeForces(of, model, J, of->keep, 0, 0, 1, first, p);
}

VARIANTS(AndResults, PARAMETERS, (of, model, J, first, p))
VARIANTS(ForcesAlone, PARAMETERS, (of, model, J, first, p))
VARIANTS(Crushable, PARAMETERS, (of, model, J, first, p))
VARIANTS(Damped, PARAMETERS, (of, model, J, first, p))
VARIANTS(Following, PARAMETERS, (of, model, J, first, p))

/* Finds the positions of LANES contacts from `first` on. */
KERNEL void Locate(const Evaluation *of, size_t first, Place *place)
{
  const Contacts *c = of->c;
  const PetscInt *vertex = c->vertex + CONTACT_ROW(first, 0);
  const PetscReal *t = c->t + SUB(first, 0);
  const int traits = c->traits[first / LANES];
  if (traits & MATCH) {
    const Place p = PlaceOfMatch(of->X, of->u, vertex, of->moving);
    StorePlace(&p, 0, place);
  } else if (traits & IS_CROSSED) {
    const Place p = PlaceOf(of->X, of->u, vertex, t, of->moving, traits);
    StorePlace(&p, 1, place);
  } else {
    const Place p = PlaceOf(of->X, of->u, vertex, t, of->moving, 0);
    StorePlace(&p, 0, place);
  }
}

/* Adds the end forces of the contacts from `first` on, which SortedForces has found. */
KERNEL void AddSorted(const Evaluation *of, size_t first, const Place *p, const StretchForces *found,
                      PetscInt at)
{
  const Contacts *c = of->c;
  LanesContact now;
  LanesVector force[CONTACT_ROWS];
  for (int k = 0; k < 2; k++)
    now.F_n[k] = LoadLanes(found->F_n[k] + at), now.F_s[k] = LoadLanes(found->F_s[k] + at);
  RowForces(p, c->t + SUB(first, 0), &now, of->thickness, c->traits[first / LANES], force);
  ScatterAdd(CONTACT_ROWS, force, c->vertex + CONTACT_ROW(first, 0), of->f);
}

/* Adds the forces of all contacts, in ascending order. */
KERNEL void AllForces_code(const Evaluation *evaluation)
{
  const Evaluation of = *evaluation; /* a copy shows the compiler that no force overwrites it */
  const Contacts *c = of.c;
  void(*const respond) PARAMETERS = of.pull > 0. ? Following : of.keep ? AndResults : ForcesAlone;
  const int sorts = !of.keep && (of.pull > 0. || c->rate < 0.);
  Place places[STRETCH / LANES];
  StretchForces found;
  LanesJoint J;
  J.crushes = J.damps = J.softens = 0; // the first contacts load their joints
  for (int s = 0; s < STRESS_MODELS; s++)
    for (PetscInt from = c->model_start[s]; from < c->model_start[s + 1]; from += STRETCH) {
      const PetscInt to = PetscMin(from + STRETCH, c->model_start[s + 1]);
      for (PetscInt i = from; i < to; i += LANES) Locate(&of, (size_t)i, places + (i - from) / LANES);
      for (PetscInt i = from; i < to; i += LANES) {
        if (sorts) {
          const PetscInt end = SortedForces(&of, s, i, to, places + (i - from) / LANES, &J, &found);
          for (const PetscInt first = i; i < end; i += LANES)
            AddSorted(&of, (size_t)i, places + (i - from) / LANES, &found, i - first);
          if (i == to) break;
        }
        const Place *p = places + (i - from) / LANES;
        if (c->traits[i / LANES] & JOINTS) LoadJoints(of.joints, c->joint + i, c->margin, &J);
        const int closes = J.crushes || c->traits[i / LANES] & CRUSHED;
        if (!of.keep && PlainForces(&of, LanesModels + s, &J, 0, (size_t)i, p)) continue;
        if (of.keep && J.damps && c->rate > 0.)
          Damped(&of, LanesModels + s, &J, (size_t)i, p);
        else if (closes)
          Crushable(&of, LanesModels + s, &J, (size_t)i, p);
        else
          respond(&of, LanesModels + s, &J, (size_t)i, p);
      }
    }
}

VARIANTS(AllForces, (const Evaluation *of), (of))

static void evaluate(const Model *m, const Joint *joints, int keep, Contacts *c, const PetscReal *u,
                     PetscReal *f)
{
  const Evaluation of = {.X = m->mesh.X,
                         .u = u,
                         .from = ContactsFromCommitted(c) ? HistoryCommitted(c) : HistoryNow(c),
                         .pull = c->friction == FRICTION_PULLED ? c->pull : 0.,
                         .moving = m->materials.strain == STRAIN_LARGE ? 1. : 0.,
                         .thickness = m->materials.thickness,
                         .joints = joints,
                         .c = c,
                         .keep = keep,
                         .f = f};
  const PetscReal rate = c->rate;
  if (c->friction == FRICTION_SPRINGS && rate == 0.) c->rate = -1.; // as in time, but without dashpots
  AllForces(&of);
  c->rate = rate;
}

PetscErrorCode ContactForces(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                             PetscReal *f)
{
  PetscFunctionBeginUser;
  evaluate(m, joints, 1, c, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactForcesOnly(const Model *m, const Joint *joints, Contacts *c, const PetscReal *u,
                                 PetscReal *f)
{
  PetscFunctionBeginUser;
  evaluate(m, joints, 0, c, u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

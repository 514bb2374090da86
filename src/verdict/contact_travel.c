/* contact_travel.c: measures how far the faces of each contact have moved against each other, and decides
   "collapsed" where that is too far.

   What counts. Openings and slidings count from the start of the run or the end of the last motion in time,
   which may have carried blocks anywhere. Static stages in a row count together: a face that slides a little
   in each of them has slid far. A contact across a gap counts from where it first bears, because before that
   its faces may part freely. Joints of `law: elastic` cannot fail, so verdicts leave them out. */
#include "verdict/judge.h"
#include "base/reproducible.h"
#include <float.h>

/* Decides whether contact i has borne force before, so that its travel counts. */
static PetscBool counts(const Contacts *c, PetscInt i)
{
  return (PetscBool)(c->key[2 * i] >= 0 && c->u_n_0[SUB(i, 0)] < PETSC_MAX_REAL);
}

/* Starts the travel of contact i from this state; from_here FALSE: from where it first bears. */
static void count_from_here(Contacts *c, PetscInt i, PetscBool from_here)
{
  for (int k = 0; k < 2; k++) {
    c->u_n_0[SUB(i, k)] = from_here ? c->u_n[SUB(i, k)] : PETSC_MAX_REAL;
    c->u_s_0[SUB(i, k)] = from_here ? c->u_s[SUB(i, k)] : 0.;
  }
}

void ContactTravelStart(const Problem *p)
{
  Contacts *c = p->contacts;
  if (ContactsVary(p->contacts, p->stage) || c->counted) return;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscReal gap = PetscMin(c->u_n[SUB(i, 0)], c->u_n[SUB(i, 1)]);
    if (c->key[2 * i] >= 0) count_from_here(c, i, (PetscBool)(gap <= TOUCHING * c->length[i]));
  }
  c->counted = PETSC_TRUE;
}

void ContactTravelStartBearing(Contacts *c)
{
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0 && !counts(c, i) && (c->sigma[SUB(i, 0)] < 0. || c->sigma[SUB(i, 1)] < 0.))
      count_from_here(c, i, PETSC_TRUE);
}

/* Returns the length [m] of the shorter of the two faces of contact i. Unless the faces are staggered, that
   is the length of the contact. */
static PetscReal shorter_face(const Model *m, const Contacts *c, PetscInt i)
{
  PetscReal shorter = PETSC_INFINITY;
  if (c->klass[i] != FF2_I && c->klass[i] != FF2_F) return c->length[i];
  for (int k = 0; k < 2; k++) {
    PetscInt v[3];
    ContactEndVertices(c, i, k, v);
    const PetscReal *A = m->mesh.X + 2 * v[1], *B = m->mesh.X + 2 * v[2];
    shorter = PetscMin(shorter, PetscHypotReal(B[0] - A[0], B[1] - A[1]));
  }
  return shorter;
}

/* Returns the travel [-] of contact i at its end k: how far its faces have parted or slid, over the shorter
   face. */
static PetscReal travel_at(const Model *m, const Contacts *c, PetscInt i, int k)
{
  const PetscReal opened = c->u_n[SUB(i, k)] - c->u_n_0[SUB(i, k)],
                  slid = PetscAbsReal(c->u_s[SUB(i, k)] - c->u_s_0[SUB(i, k)]);
  return PetscMax(slid, opened) / shorter_face(m, c, i);
}

/* Decides whether verdicts count the travel of contact i. */
static PetscBool may_fail(const Problem *p, PetscInt i)
{
  return (PetscBool)(counts(p->contacts, i) && p->stage->joints[p->contacts->joint[i]].law != LAW_ELASTIC);
}

/* A contact, and how far its faces have moved against each other. */
typedef struct {
  PetscReal moved;      /* [-] way / length */
  PetscReal way;        /* [m] opened or slid, the larger */
  PetscReal length;     /* [m] */
  PetscReal place[2];   /* [m] a vertex at its end, as drawn */
  PetscReal slid;       /* 1: it has slid, 0: parted */
  PetscReal grows;      /* 1: it has moved farther since the chunk of cycles began (largest_travel), else 0 */
  PetscReal body, over; /* macroblock that has moved farther here, and the other one */
} Travel;
enum { TRAVEL_REALS = sizeof(Travel) / sizeof(PetscReal) };

/* Returns the displacement [m] of vertex v since the start of the run. */
static PetscReal displacement_of(const Problem *p, PetscInt v)
{
  const PetscReal *u = p->state->u + 3 * p->m->rigid.n + 2 * v;
  return PetscHypotReal(u[0], u[1]);
}

/* Collective. Replaces the contact of each rank by the one of all ranks that has moved farthest; of several
   such contacts by the one of the first rank. */
static PetscErrorCode farthest(const Model *m, Travel *travel)
{
  struct {
    double moved;
    int rank;
  } worst = {travel->moved, m->rank}; // in the layout of MPI_MAXLOC
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, m->comm));
  PetscCallMPI(MPI_Bcast(travel, TRAVEL_REALS, MPIU_REAL, worst.rank, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores contact i in `travel` if it has moved farther than the contact there. opened, slid: its motion [m],
   divided by `length` [m]. v: vertex at its place. */
static void note_travel(const Problem *p, PetscInt i, PetscInt v, PetscReal opened, PetscReal slid,
                        PetscReal length, Travel *travel)
{
  const Model *m = p->m;
  const PetscReal way = PetscMax(slid, opened), moved = way / length, *X = m->mesh.X + 2 * v;
  if (moved <= travel->moved) return;
  const PetscInt P = p->contacts->vertex[CONTACT_ROW(i, ROW_P)],
                 A = p->contacts->vertex[CONTACT_ROW(i, ROW_A)];
  const PetscBool turned = (PetscBool)(displacement_of(p, A) > displacement_of(p, P));
  *travel = (Travel){.moved = moved,
                     .way = way,
                     .length = length,
                     .place = {X[0], X[1]},
                     .slid = slid >= opened,
                     .body = m->mesh.vertex_body[turned ? A : P],
                     .over = m->mesh.vertex_body[turned ? P : A]};
}

/* Collective. Finds the width of each macroblock [m], the least thickness behind one of its faces. width:
   (n_bodies_global,); the caller frees it. */
static PetscErrorCode body_widths(const Model *m, PetscReal **width)
{
  const PetscInt n = m->mesh.n_bodies_global;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, width));
  for (PetscInt b = 0; b < n; b++) (*width)[b] = PETSC_MAX_REAL;
  for (PetscInt f = 0; f < m->faces.n; f++) {
    PetscReal *of = *width + m->faces.body[f];
    *of = PetscMin(*of, m->faces.thick[f]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, *width, (PetscMPIInt)n, MPIU_REAL, MPI_MIN, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the contact with the largest travel, among joints that can fail. width: [m] of each
   macroblock; a face then counts as at least half as long as the narrower macroblock is wide. NULL: faces
   count with their length. */
static PetscErrorCode largest_travel(const Problem *p, const PetscReal *width, Travel *travel)
{
  const Contacts *c = p->contacts;
  const PetscInt *body = p->m->mesh.vertex_body;
  *travel = (Travel){.moved = 0.};
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && may_fail(p, i); k++) {
      PetscReal length = shorter_face(p->m, c, i);
      PetscInt v[3];
      ContactEndVertices(c, i, k, v);
      if (width)
        length = PetscMax(length, 0.5 * PetscMin(width[body[c->vertex[CONTACT_ROW(i, ROW_P)]]],
                                                 width[body[c->vertex[CONTACT_ROW(i, ROW_A)]]]));
      const PetscReal before = travel->moved;
      note_travel(p, i, v[0], c->u_n[SUB(i, k)] - c->u_n_0[SUB(i, k)],
                  PetscAbsReal(c->u_s[SUB(i, k)] - c->u_s_0[SUB(i, k)]), length, travel);
      if (travel->moved > before) travel->grows = travel_at(p->m, c, i, k) > c->moved[SUB(i, k)];
    }
  PetscCall(farthest(p->m, travel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTravel(const Problem *p, PetscReal *fraction)
{
  Travel travel;
  PetscFunctionBeginUser;
  PetscCall(largest_travel(p, NULL, &travel));
  *fraction = travel.moved;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTravelOfChunk(const Problem *p, PetscReal *gain)
{
  Contacts *c = p->contacts;
  PetscReal most = -1.;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && may_fail(p, i); k++) {
      const PetscReal moved = travel_at(p->m, c, i, k);
      most = PetscMax(most, PetscMax(0., moved - c->moved[SUB(i, k)]));
      c->moved[SUB(i, k)] = moved;
    }
  PetscCallMPI(MPI_Allreduce(&most, gain, 1, MPIU_REAL, MPI_MAX, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the range in which a contact may be kept */

/* Collective. Finds the contact that has moved farthest from where it was found, over its length. elastic:
   joints of law elastic count too.

   ContactTravel measures whether blocks have moved away. This travel measures whether a contact still stands
   where its faces are. So it takes the slip since the contact was found, not since the static stages began,
   and divides by the length of the contact, not of the face. */
static PetscErrorCode out_of_place(const Problem *p, PetscBool elastic, Travel *travel)
{
  const Contacts *c = p->contacts;
  *travel = (Travel){.moved = 0.};
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++)
    for (int k = 0; k < 2 && (elastic ? counts(c, i) : may_fail(p, i)); k++)
      note_travel(p, i, c->vertex[CONTACT_ROW(i, ROW_P)], c->u_n[SUB(i, k)] - c->u_n_0[SUB(i, k)],
                  PetscAbsReal(c->u_s[SUB(i, k)]), c->length[i], travel);
  PetscCall(farthest(p->m, travel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether contacts may be found again at an equilibrium of the stage, as far as the scene shows it. A
   trial judges the blocks in the places where they stand when it begins. */
static PetscBool may_find_anew(const Problem *p)
{
  const PetscBool water = (PetscBool)(p->stage->kind == STAGE_TRANSIENT &&
                                      p->scene->flow.coupling == FLOW_ONE_WAY);
  return (PetscBool)(p->stage->connectivity == CONNECTIVITY_AUTO && !StageTries(p->stage) &&
                     p->scene->strain == STRAIN_LARGE && !SceneBuilds(p->scene) && !water);
}

/* Collective. Sets relax->outgrown where a contact has left its range, at an equilibrium whose contacts can
   be found again. */
static PetscErrorCode judge_range(const Problem *p)
{
  Relaxation *r = p->relax;
  char missing[MESSAGE_LENGTH];
  Travel travel;
  PetscFunctionBeginUser;
  if (!may_find_anew(p)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(out_of_place(p, PETSC_FALSE, &travel));
  if (travel.moved <= TRAVEL_LIMIT) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LaterJoints(p->scene, p->contacts, p->m, missing));
  r->outgrown = (PetscBool)(missing[0] == '\0');
  r->outgrown_at[0] = travel.place[0], r->outgrown_at[1] = travel.place[1];
  r->outgrown_at[2] = travel.moved;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FarthestBody(const Problem *p, PetscInt *body, PetscReal *way)
{
  const PetscReal *u = p->state->u, *u_0 = p->relax->evidence.u_0;
  const PetscInt rigid = 3 * p->m->rigid.n;
  struct {
    double way;
    int body;
  } most = {0., 0}; // in the layout of MPI_MAXLOC: of several bodies the first
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < p->m->n_dof; d += d < rigid ? 3 : 2) {
    const PetscReal moved = PetscHypotReal(u[d] - u_0[d], u[d + 1] - u_0[d + 1]);
    const int of = (int)DofBody(p->m, d);
    if (moved > most.way || (moved == most.way && of < most.body)) most.way = moved, most.body = of;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, p->m->comm));
  *body = most.body, *way = most.way;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FarthestBodyAdd(const Problem *p)
{
  char more[128];
  PetscInt body;
  PetscReal way;
  PetscFunctionBeginUser;
  PetscCall(FarthestBody(p, &body, &way));
  PetscCall(PetscSNPrintf(more, sizeof(more),
                          "; macroblock %" PetscInt_FMT " has moved most, by %.3g m since the %s began", body,
                          (double)way, StageTries(p->stage) ? "trial" : "stage"));
  PetscCall(PetscStrlcat(p->result->evidence, more, sizeof(p->result->evidence)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a contact moves on under the full load in cycles of stiffness_mass, which have no waves to
   carry it back. crept: such cycles go on from where the waves of explicit ones have carried the stones. */
static PetscBool moves_on(const Problem *p, const Travel *travel)
{
  const PetscInt64 since = p->state->cycle - p->relax->evidence.chunk_start; // or since the ramp has ended
  return (PetscBool)(p->state->stiffness_mass && p->relax->effort.choice.crept == 0 &&
                     p->state->applied.ramp >= 1. && since >= SETTLED_CYCLES && travel->grows > 0.);
}

/* Returns the travel [-] beyond which the stage has collapsed. At rest a contact that has moved beyond
   TRAVEL_LIMIT means nothing. While the load of a static stage rises, and as long again, cycles may carry a
   contact beyond it and back, because the wave of the load shakes small stones. Creep has no waves. */
static PetscReal allowed_travel(const Problem *p, PetscBool rests, const Travel *travel)
{
  const PetscBool shaken = (PetscBool)(p->stage->kind == STAGE_STATIC && !(p->relax->step > 0.) &&
                                       p->result->cycles - p->relax->begun <= 2 * p->stage->ramp);
  return !rests && shaken && may_find_anew(p) && !moves_on(p, travel) ? SLID_AWAY : TRAVEL_LIMIT;
}

PetscErrorCode JudgeContactTravel(const Problem *p, PetscBool rests)
{
  StageResult *result = p->result;
  PetscReal allowed;
  Travel travel;
  PetscFunctionBeginUser;
  PetscCall(largest_travel(p, NULL, &travel));
  allowed = allowed_travel(p, rests, &travel);
  if (travel.moved > allowed && p->stage->connectivity == CONNECTIVITY_AUTO && !StageTries(p->stage)) {
    PetscReal *width;
    PetscCall(body_widths(p->m, &width));
    PetscCall(largest_travel(p, width, &travel));
    PetscCall(PetscFree(width));
    allowed = allowed_travel(p, rests, &travel); // another contact may be the farthest now
  }
  if (rests && !(travel.moved > allowed)) PetscCall(judge_range(p));
  if (!(travel.moved > allowed)) PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_COLLAPSED;
  PetscCall(PetscSNPrintf(
      result->evidence, sizeof(result->evidence),
      travel.slid > 0.
          ? "macroblock %d has slid along macroblock %d by %.3g m, %.3g of a length of %.3g m, at "
            "x = %.4g m, y = %.4g m"
          : "macroblock %d has parted from macroblock %d by %.3g m, %.3g of a length of %.3g m, at "
            "x = %.4g m, y = %.4g m",
      (int)travel.body, (int)travel.over, (double)travel.way, (double)travel.moved, (double)travel.length,
      (double)travel.place[0], (double)travel.place[1]));
  PetscCall(FarthestBodyAdd(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FixedConnectivityWarn(const Problem *p)
{
  Travel travel;
  PetscFunctionBeginUser;
  PetscCall(out_of_place(p, PETSC_TRUE, &travel));
  if (travel.moved > TRAVEL_LIMIT && !p->m->rank)
    Warn("stage %s: contacts are beyond the range of fixed connectivity: a contact at x = %.4g m, y = %.4g m "
         "has %s by %.3g of its length; its place and length were kept: use contact.connectivity: variable",
         p->stage->name, (double)travel.place[0], (double)travel.place[1],
         travel.slid > 0. ? "slid" : "parted", (double)travel.moved);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- bodies that nothing holds any more */

/* Finds the macroblocks that a support or a contact holds. tied: (n_bodies_global,) 1 for each of them; zeros
   on entry. */
static PetscErrorCode find_tied(const Problem *p, PetscInt *tied)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < ModelApplied(m); d++)
    if (Held(m, d)) tied[DofBody(m, d)] = 1;
  for (PetscInt i = 0; i < c->n_padded; i++)
    if (c->key[2 * i] >= 0)
      tied[m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_P)]]] =
          tied[m->mesh.vertex_body[c->vertex[CONTACT_ROW(i, ROW_A)]]] = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, tied, m->mesh.n_bodies_global, MPIU_INT, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FarthestMoved(const Problem *p, const PetscReal *from, PetscReal *most)
{
  const Model *m = p->m;
  const PetscReal *u = p->state->u + 3 * m->rigid.n;
  PetscFunctionBeginUser;
  *most = 0., from += 3 * m->rigid.n;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++)
    *most = PetscMax(*most, PetscHypotReal(u[2 * v] - from[2 * v], u[2 * v + 1] - from[2 * v + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HeldBodies(const Model *m, PetscInt **held)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_bodies_global, held));
  for (PetscInt d = 0; d < ModelApplied(m); d++)
    if (Held(m, d)) (*held)[DofBody(m, d)] = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, *held, m->mesh.n_bodies_global, MPIU_INT, MPI_MAX, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FreeSize(const Problem *p, PetscReal *size)
{
  const Model *m = p->m;
  PetscReal far[4] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY}; // - low x, y, high x, y
  PetscInt *held;
  PetscFunctionBeginUser;
  PetscCall(HeldBodies(m, &held));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    for (int k = 0; k < 2 && !held[m->mesh.vertex_body[v]]; k++)
      far[k] = PetscMax(far[k], -m->mesh.X[2 * v + k]),
      far[2 + k] = PetscMax(far[2 + k], m->mesh.X[2 * v + k]);
  PetscCall(PetscFree(held));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, far, 4, MPIU_REAL, MPI_MAX, m->comm));
  *size = far[0] > -INFINITY ? PetscHypotReal(far[2] + far[0], far[3] + far[1]) : m->mesh.diameter;
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { FALLS = 4 };

/* Finds for the loads on each macroblock: their work [J] since the start of the stage, their present power,
   their sums [N] along x and along y. sum: (n_bodies_global, FALLS, 2) bins, zeros on entry. */
static PetscErrorCode find_falls(const Problem *p, PetscReal *sum)
{
  const Model *m = p->m;
  const State *s = p->state;
  PetscReal top[FALLS] = {0.};
  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { // largest terms, then the binned sums
    Bins bins[FALLS];
    for (int i = 0; i < FALLS; i++) bins[i] = BinsFor(PetscMax(top[i], 1e-290));
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscInt rigid = 3 * m->rigid.n, along = d < rigid ? d % 3 : (d - rigid) % 2;
      const PetscReal f = s->f_ext[d], term[FALLS] = {f * (s->u[d] - p->relax->evidence.u_0[d]), f * s->v[d],
                                                      along == 0 ? f : 0., along == 1 ? f : 0.};
      if (along == 2) continue;
      for (int i = 0; i < FALLS && pass; i++)
        BinAdd(bins + i, term[i], sum + 2 * (FALLS * DofBody(m, d) + i));
      for (int i = 0; i < FALLS && !pass; i++) top[i] = PetscMax(top[i], PetscAbsReal(term[i]));
    }
    if (pass)
      PetscCallMPI(
          MPI_Allreduce(MPI_IN_PLACE, sum, 2 * FALLS * m->mesh.n_bodies_global, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, FALLS, MPIU_REAL, MPI_MAX, m->comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides "collapsed" where a body has moved by GONE of its size since the stage began: with contacts
   that are found again, what has fallen comes to rest somewhere, but it no longer stands. Trials with a
   displacement_limit have a limit of their own. */
static PetscErrorCode judge_gone(const Problem *p)
{
  enum { BOX = 4, NUMBERS };
  const Model *m = p->m;
  const PetscReal *u = p->state->u, *u_0 = p->relax->evidence.u_0;
  const PetscInt n = m->mesh.n_bodies_global, rigid = 3 * m->rigid.n;
  PetscReal *far, worst = GONE; // - low x, y, high x, y; displacement
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(NUMBERS * n, &far));
  for (PetscInt i = 0; i < NUMBERS * n; i++) far[i] = -PETSC_MAX_REAL;
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    for (int k = 0; k < 2; k++) {
      PetscReal *of = far + NUMBERS * m->mesh.vertex_body[v];
      of[k] = PetscMax(of[k], -m->mesh.X[2 * v + k]), of[2 + k] = PetscMax(of[2 + k], m->mesh.X[2 * v + k]);
    }
  for (PetscInt d = 0; d < m->n_dof; d += d < rigid ? 3 : 2) {
    PetscReal *moved = far + NUMBERS * DofBody(m, d) + BOX;
    *moved = PetscMax(*moved, PetscHypotReal(u[d] - u_0[d], u[d + 1] - u_0[d + 1]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, far, (PetscMPIInt)(NUMBERS * n), MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt b = 0; b < n; b++) {
    const PetscReal *of = far + NUMBERS * b, size = PetscHypotReal(of[0] + of[2], of[1] + of[3]);
    if (!(of[BOX] > worst * size)) continue;
    worst = of[BOX] / size, p->result->verdict = VERDICT_COLLAPSED;
    PetscCall(PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                            "macroblock %" PetscInt_FMT
                            " has moved %.3g m since the stage began, more than half its size of %.3g m",
                            b, (double)of[BOX], (double)size));
  }
  PetscCall(PetscFree(far));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JudgeLoose(const Problem *p)
{
  const Model *m = p->m;
  const PetscInt n = m->mesh.n_bodies_global;
  PetscInt *tied, loose = 0;
  PetscReal *sum;
  PetscFunctionBeginUser;
  if (p->scene->allow_floating) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(n, &tied, 2 * FALLS * n, &sum));
  PetscCall(find_tied(p, tied));
  for (PetscInt b = 0; b < n; b++) loose += !tied[b];
  if (loose) PetscCall(find_falls(p, sum));
  for (PetscInt b = 0; b < n && p->result->verdict == VERDICT_NONE; b++) {
    PetscReal f[FALLS];
    for (int i = 0; i < FALLS; i++) f[i] = sum[2 * (FALLS * b + i)] + sum[2 * (FALLS * b + i) + 1];
    const PetscReal fallen = f[0] / PetscMax(PetscHypotReal(f[2], f[3]), DBL_MIN);
    if (tied[b] || !(fallen > TRAVEL_LIMIT * p->relax->evidence.longest) || !(f[1] > 0.)) continue;
    p->result->verdict = VERDICT_COLLAPSED;
    PetscCall(
        PetscSNPrintf(p->result->evidence, sizeof(p->result->evidence),
                      "macroblock %" PetscInt_FMT
                      " has lost its last contact and falls: %.3g m along its loads since the stage began",
                      b, (double)fallen));
  }
  PetscCall(PetscFree2(tied, sum));
  if (p->result->verdict == VERDICT_NONE && p->stage->connectivity == CONNECTIVITY_AUTO &&
      PetscIsNanReal(p->stage->displacement_limit))
    PetscCall(judge_gone(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rocking.c: computes how much earlier a free-standing column turns over in time than about a rigid edge,
   because tptm presses its hinge over a length.

   Bodies that no support holds are added one by one, the highest centre first. Each body that is added
   makes a group with all bodies that it carries. The group stands on the contacts below it (its bed). It
   turns about an end of its bed, unless a contact at that side props it. Its hinge is pressed over a = (12
   W h / k_n)^(1/3), W its weight per metre and h the height of its centre above the edge
   (docs/rigid_blocks.md). So a/2 is missing of the arm c of its weight about the edge, and it turns over
   at a horizontal acceleration of (c - a/2)/h g. In a column of several stones that joint opens where this
   acceleration is least: it governs all groups above it and all groups that stand on those below it. */
#include "result/result.h"
#include <math.h>
#include <stdlib.h>

static const PetscReal STEEP = 0.7; /* [-] least vertical part of the push of a bed */
static const PetscReal NEAR = 1e-3; /* [-] gap over the length of a contact, up to which bodies touch */

/* An end of a contact between two macroblocks. */
typedef struct {
  PetscInt body[2];
  PetscReal push[2];  /* [-] direction in which the contact pushes body[0] */
  PetscReal point[2]; /* [m] in the mesh */
  PetscReal k_n;      /* [Pa/m]; 0: the joint has no tptm */
  PetscBool glued;    /* its law is elastic, so it never opens */
} Touch;

/* An end of the bed of a group. */
typedef struct {
  PetscReal x, y, k_n; /* [m], [m], [Pa/m] */
  PetscInt body;       /* macroblock of the group that stands there, -1: no bed */
  PetscBool propped;   /* a contact at this side keeps the group from turning about the end */
} Edge;

/* The group that a body makes with bodies above it; its number is the number of the body. */
typedef struct {
  PetscInt over;             /* the next larger group, -1: none */
  PetscInt leads;            /* a body of a larger group, itself: it leads its own */
  PetscInt first, last;      /* of the group that the body leads: list of ends of touches, -1: none */
  PetscInt n;                /* bodies of the group that the body leads */
  PetscReal mass, moment[2]; /* [kg], [kg m] likewise */
  PetscReal limit;           /* [-] horizontal acceleration over g at which the group turns over */
  PetscReal least[2];        /* [-] least limit of the groups in it, of those that it is in */
  RockingHinge hinge;
} Group;

static int by_bodies_and_place(const void *a, const void *b)
{
  const Touch *p = a, *q = b;
  for (int i = 0; i < 2; i++)
    if (p->body[i] != q->body[i]) return p->body[i] < q->body[i] ? -1 : 1;
  for (int i = 0; i < 2; i++)
    if (p->point[i] != q->point[i]) return p->point[i] < q->point[i] ? -1 : 1;
  return p->k_n < q->k_n ? -1 : p->k_n > q->k_n;
}

/* A body and the height of its centre [m]. */
typedef struct {
  PetscInt body;
  PetscReal y;
} Height;

static int highest_first(const void *a, const void *b)
{
  const Height *p = a, *q = b;
  if (p->y != q->y) return p->y > q->y ? -1 : 1;
  return p->body < q->body ? -1 : p->body > q->body;
}

/* Collective. Gathers on rank 0 the ends of all contacts between two macroblocks that touch. */
static PetscErrorCode gather_touches(const Problem *p, PetscInt *n, Touch **touches)
{
  const Model *m = p->m;
  const Contacts *c = p->contacts;
  PetscInt mine = 0;
  Touch *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * c->n + 1, &rows));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscReal gap = PetscMin(c->u_n[SUB(i, 0)], c->u_n[SUB(i, 1)]);
    if (!c->owned[i] || c->key[2 * i] < 0 || gap > NEAR * c->length[i]) continue;
    for (int k = 0; k < (c->klass[i] == VERTEX_FACE ? 1 : 2); k++) {
      PetscInt v[3]; // P A B
      ContactEndVertices(c, i, k, v);
      const PetscReal *P = m->mesh.X + 2 * v[0], *A = m->mesh.X + 2 * v[1], *B = m->mesh.X + 2 * v[2],
                      L = PetscHypotReal(B[0] - A[0], B[1] - A[1]);
      const PetscInt body[2] = {m->mesh.vertex_body[v[0]], m->mesh.vertex_body[v[1]]};
      if (body[0] == body[1]) continue;
      const Joint *joint = p->stage->joints + c->joint[i];
      rows[mine++] = (Touch){.body = {body[0], body[1]}, // faces run anticlockwise: outwards of AB
                             .push = {(B[1] - A[1]) / L, -(B[0] - A[0]) / L},
                             .point = {P[0], P[1]},
                             .k_n = i < c->model_start[STRESS_TPTM] ? 0. : joint->k_n,
                             .glued = (PetscBool)(joint->law == LAW_ELASTIC)};
    }
  }
  PetscCall(GatherAndFree(m->comm, mine, sizeof(*rows), rows, n, (void **)touches));
  if (*n) qsort(*touches, (size_t)*n, sizeof(**touches), by_bodies_and_place);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt leader(Group *g, PetscInt b)
{
  while (g[b].leads != b) b = g[b].leads = g[g[b].leads].leads;
  return b;
}

/* Joins the group that `a` leads to the group of `b`, which has just been added. */
static void join(Group *g, PetscInt next[], PetscInt b, PetscInt a)
{
  g[a].over = g[a].leads = b;
  g[b].n += g[a].n, g[b].mass += g[a].mass;
  for (int x = 0; x < 2; x++) g[b].moment[x] += g[a].moment[x];
  if (g[a].first < 0) return;
  if (g[b].first < 0)
    g[b].first = g[a].first;
  else
    next[g[b].last] = g[a].first;
  g[b].last = g[a].last;
}

/* Takes an end of a bed into the edge of side -1 or 1: the farthest, of these the softest. */
static void extend(Edge *edge, int side, PetscInt body, const Touch *t)
{
  const PetscReal x = t->point[0];
  if (edge->body >= 0 && (x - edge->x) * side < 0.) return;
  if (edge->body >= 0 && x == edge->x && !(t->k_n < edge->k_n)) return;
  *edge = (Edge){x, t->point[1], t->k_n, body, edge->propped};
}

/* Finds the ends of the bed of the group that b leads; false: a body lies on the group, or a
   joint that never opens holds it, so it cannot turn.
   Drops touches that are now inside the group from its list. */
static PetscBool find_bed(Group *g, PetscInt next[], const Touch *touch, PetscInt b, Edge edge[2])
{
  PetscInt *link = &g[b].first;
  PetscBool free = PETSC_TRUE;
  for (int k = 0; k < 2; k++) edge[k] = (Edge){.body = -1};
  g[b].last = -1;
  while (*link >= 0) {
    const Touch *t = touch + *link / 2;
    const int mine = (int)(*link % 2);
    const PetscInt other = t->body[1 - mine];
    const PetscReal x = mine ? -t->push[0] : t->push[0], y = mine ? -t->push[1] : t->push[1];
    if (g[other].leads >= 0 && leader(g, other) == b) {
      *link = next[*link];
      continue;
    }
    if (t->glued || y < -STEEP)
      free = PETSC_FALSE;
    else if (y > STEEP)
      for (int k = 0; k < 2; k++) extend(edge + k, 2 * k - 1, t->body[mine], t);
    else
      edge[x < 0.].propped = PETSC_TRUE; // what pushes to the left stands at the right
    g[b].last = *link;
    link = next + *link;
  }
  return free;
}

/* Finds the limit of the group that b leads, and what is missing of its arm. */
static void judge_group(Group *g, PetscInt b, const Edge edge[2], PetscReal gravity, PetscReal thickness)
{
  const PetscReal weight = g[b].mass * gravity / thickness; // [N/m]
  for (int k = 0; k < 2; k++) {
    const Edge *e = edge + k;
    const PetscReal arm = (2 * k - 1) * (e->x - g[b].moment[0] / g[b].mass),
                    h = g[b].moment[1] / g[b].mass - e->y;
    if (e->body < 0 || e->propped || !(arm > 0.) || !(h > arm)) continue;
    const PetscReal part = e->k_n > 0. ? PetscMin(1., 0.5 * cbrt(12. * weight * h / e->k_n) / arm) : 0.,
                    limit = (1. - part) * arm / h;
    if (!(limit < g[b].limit)) continue;
    g[b].limit = limit;
    g[b].hinge = (RockingHinge){part, e->body, g[b].n, {e->x, e->y}};
  }
}

/* Makes the groups, the highest body first. next: (2 n_touches,) entry 2 i + k belongs to touch i in the list
   of its body[k]. */
static void make_groups(const Problem *p, const Touch *touch, PetscInt n_touches, const Height *order,
                        PetscInt n_order, Group *g, PetscInt next[])
{
  Edge edge[2];
  for (PetscInt i = 0; i < 2 * n_touches; i++) { // every body has the list of its own
    Group *own = g + touch[i / 2].body[i % 2];
    next[i] = -1;
    if (own->first < 0)
      own->first = i;
    else
      next[own->last] = i;
    own->last = i;
  }
  for (PetscInt o = 0; o < n_order; o++) {
    const PetscInt b = order[o].body;
    g[b].leads = b;
    for (PetscInt t = g[b].first, end = g[b].last; t >= 0; t = t == end ? -1 : next[t]) {
      const PetscInt other = touch[t / 2].body[1 - t % 2];
      if (g[other].leads < 0 || PetscAbsReal(touch[t / 2].push[1]) < STEEP) continue;
      const PetscInt a = leader(g, other);
      if (a != b) join(g, next, b, a);
    }
    if (find_bed(g, next, touch, b, edge))
      judge_group(g, b, edge, p->scene->gravity, p->m->materials.thickness);
  }
}

/* Returns the hinge of which most is missing, among groups of which none inside or around turns earlier. */
static RockingHinge worst_of(const Height *order, PetscInt n, Group *g)
{
  RockingHinge worst = {.part = 0.};
  for (PetscInt b = 0; b < n; b++)
    for (int k = 0; k < 2; k++) g[order[b].body].least[k] = g[order[b].body].limit;
  for (PetscInt b = 0; b < n; b++) {
    const Group *in = g + order[b].body;
    if (in->over >= 0) g[in->over].least[0] = PetscMin(g[in->over].least[0], in->least[0]);
  }
  for (PetscInt b = n - 1; b >= 0; b--) {
    Group *in = g + order[b].body;
    if (in->over >= 0) in->least[1] = PetscMin(in->least[1], g[in->over].least[1]);
    if (in->limit <= PetscMin(in->least[0], in->least[1]) && in->hinge.part > worst.part) worst = in->hinge;
  }
  return worst;
}

PetscErrorCode RockingHingeFind(const Problem *p, RockingHinge *hinge)
{
  const BodyMotion *b = &p->found->bodies;
  PetscInt n, n_order = 0, *next;
  Touch *touch = NULL;
  Height *order;
  Group *g;
  PetscFunctionBeginUser;
  *hinge = (RockingHinge){.part = 0.};
  PetscCall(gather_touches(p, &n, &touch));
  if (!p->m->rank) {
    PetscCall(PetscMalloc1(2 * n + 1, &next));
    PetscCall(PetscMalloc1(b->n, &order));
    PetscCall(PetscMalloc1(b->n, &g));
    for (PetscInt i = 0; i < b->n; i++) {
      const PetscReal mass = b->mass[i], *C = b->centre + 2 * i;
      g[i] = (Group){.over = -1,
                     .leads = -1,
                     .first = -1,
                     .last = -1,
                     .n = 1,
                     .mass = mass,
                     .moment = {mass * C[0], mass * C[1]},
                     .limit = INFINITY};
      if (b->size[2 * i] > 0. && mass > 0.) order[n_order++] = (Height){i, C[1]};
    }
    qsort(order, (size_t)n_order, sizeof(*order), highest_first);
    make_groups(p, touch, n, order, n_order, g, next);
    *hinge = worst_of(order, n_order, g);
    PetscCall(PetscFree(next));
    PetscCall(PetscFree(order));
    PetscCall(PetscFree(g));
    PetscCall(PetscFree(touch));
  }
  PetscCallMPI(MPI_Bcast(hinge, (PetscMPIInt)sizeof(*hinge), MPI_BYTE, 0, p->m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RockingHingeArchive(Archive *archive, RockingHinge *h)
{
  PetscFunctionBeginUser;
  if (archive->digest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveRealMembers(archive, "rocking", &h->part, &h->point[0], &h->point[1]));
  PetscCall(ArchiveIntMembers(archive, "rocking_bodies", INT_MEMBER(h->body), INT_MEMBER(h->n)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

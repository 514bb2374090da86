/* verify.c: finds contacts again when blocks have moved, with variable connectivity (sections 2.3-2.4).
   Contacts that existed before keep their history. The time of every step is linear in the faces and contacts
   of the rank. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* ---- contacts that stay as they are: between groups that are not upgradeable */

/* Maps old local numbers of vertices to present ones. The numbers of the ghosts of contacts and of the
   dummies may change. */
typedef struct {
  PetscInt n;         /* number of old vertices and dummies */
  PetscInt n_ghosts;  /* number of old ghosts of contacts, which stand before the dummies */
  GhostRecord *ghost; /* (n_ghosts,) */
  PetscInt *now;      /* (n,) present numbers */
} VertexMap;

static PetscErrorCode vertices_before(const Model *m, VertexMap *map)
{
  PetscFunctionBeginUser;
  map->n = m->mesh.n_vertices + DUMMY_VERTICES;
  map->n_ghosts = m->ghosts.n - m->ghosts.n_element;
  PetscCall(PetscMalloc2(map->n_ghosts, &map->ghost, map->n, &map->now));
  PetscCall(PetscArraycpy(map->ghost, m->ghosts.record + m->ghosts.n_element, map->n_ghosts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the present numbers. Ghosts that are gone get -1. Kept contacts do not need them, because their faces
   are remembered. */
static void vertices_now(const Model *m, VertexMap *map)
{
  const PetscInt stay = m->mesh.n_owned + m->ghosts.n_element;
  for (PetscInt v = 0; v < stay; v++) map->now[v] = v;
  for (PetscInt g = 0; g < map->n_ghosts; g++)
    map->now[stay + g] = LocalVertex(m, map->ghost[g].gid, (PetscMPIInt)map->ghost[g].owner,
                                     map->ghost[g].index);
  for (int k = 0; k < DUMMY_VERTICES; k++) map->now[map->n - DUMMY_VERTICES + k] = m->mesh.n_vertices + k;
}

/* Decides whether the group of a face is upgradeable; true where this rank does not know the face. */
static PetscBool is_upgradeable(const Model *m, PetscInt gid)
{
  const PetscInt f = FaceRow(m, gid);
  return (PetscBool)(f < 0 || m->materials.upgradeable[m->faces.group[f]]);
}

/* Adds the contacts between groups that are not upgradeable. */
static PetscErrorCode keep(const Model *m, const Contacts *before, CandidateList *list)
{
  PetscBool all = PETSC_TRUE;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups; g++) all = (PetscBool)(all && m->materials.upgradeable[g]);
  for (int s = 0; s < STRESS_MODELS && !all; s++)
    for (PetscInt at = before->model_start[s]; at < before->model_start[s + 1]; at++) {
      const PetscInt *key = before->key + 2 * at;
      if (key[0] < 0 || key[1] < 0) continue; // a vertex on a face is never between such groups
      if (is_upgradeable(m, key[0]) || is_upgradeable(m, key[1])) continue;
      Candidate next = {.model = (StressModelKind)s,
                        .key = {key[0], key[1]},
                        .face = {FaceRow(m, key[0]), -1},
                        .joint = before->joint[at],
                        .before = at,
                        .kept = PETSC_TRUE};
      next.pair.klass = before->klass[at];
      PetscCall(CandidatesPush(list, &next));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole */

/* Returns the depth of a contact over its shorter face, or over its length between groups that are not
   upgradeable. Where the blocks behind the faces are thin, returns the depth over THIN times the thinner one,
   where a contact is pressed through sooner. */
static PetscReal depth_of(const Model *m, const FaceTable *table, const Candidate *n, const Contacts *before)
{
  static const PetscReal THIN = 2.5; // a tenth of the face is a quarter of a block as thick

  PetscReal gap, length;
  if (n->kept) {
    length = n->face[1] < 0 ? before->length[n->before]
                            : PetscMin(table->length[n->face[0]], table->length[n->face[1]]);
    gap = PetscMin(before->u_n[SUB(n->before, 0)] + before->rest[SUB(n->before, 0)],
                   before->u_n[SUB(n->before, 1)] + before->rest[SUB(n->before, 1)]);
  } else {
    length = PetscMin(table->length[n->face[0]], table->length[n->face[1]]);
    gap = n->pair.klass == VERTEX_FACE ? n->pair.gap[0] : PetscMin(n->pair.gap[0], n->pair.gap[1]);
  }
  for (int k = 0; k < 2; k++)
    if (n->face[k] >= 0) length = PetscMin(length, THIN * m->faces.thick[n->face[k]]);
  return -PetscMin(gap, 0.) / length;
}

/* Collective. Counts the contacts made and lost, and finds the deepest contact, for the result of the
   stage. */
static PetscErrorCode count(const Model *m, const FaceTable *table, const Contacts *before,
                            const CandidateList *list, const Contacts *c, StageResult *result)
{
  const Candidate *next = list->item;
  PetscInt number[2] = {0, 0}; // made, growth
  PetscReal deepest = 0.;
  PetscFunctionBeginUser;
  for (PetscInt at = 0; at < c->n_padded; at++) {
    if (c->key[2 * at] < 0) continue;
    const Candidate *this = next++; // contacts and candidates have one order
    deepest = PetscMax(deepest, depth_of(m, table, this, before));
    if (c->owned[at]) number[0] += this->before < 0, number[1]++;
  }
  for (PetscInt at = 0; at < before->n_padded; at++)
    number[1] -= before->key[2 * at] >= 0 && before->owned[at];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, number, 2, MPIU_INT, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPIU_REAL, MPI_MAX, m->comm));
  result->verifications++;
  result->contacts_made += number[0];
  result->contacts_lost += number[0] - number[1];
  result->deepest = deepest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds how deep contacts overlap now [m], or how far they are open; this widens the boxes of the
   search. The boxes of two flat faces farther apart than the margin would not meet, but faces in contact must
   be found as long as they may be a contact. */
static PetscErrorCode measure_depth(const Scene *scene, const Contacts *c, Model *m)
{
  PetscReal depth = 0., pressed = 0.;
  PetscFunctionBeginUser;
  for (PetscInt at = 0; at < c->n_padded; at++) {
    if (c->key[2 * at] < 0) continue;
    const PetscReal gap[2] = {c->u_n[SUB(at, 0)] + c->rest[SUB(at, 0)],
                              c->u_n[SUB(at, 1)] + c->rest[SUB(at, 1)]};
    const PetscReal deep = -PetscMin(gap[0], gap[1]), open = -deep;
    if (open > depth && open <= ContactLossGap(scene, c, at, m->contact_margin) &&
        c->klass[at] != VERTEX_FACE)
      depth = open;
    if (!(deep > PetscMax(pressed, m->contact_margin))) continue;
    const PetscInt f = FaceRow(m, c->key[2 * at]);
    if (f >= 0 && deep <= FACE_DEPTH * m->faces.thick[f]) pressed = deep;
  }
  depth = PetscMax(depth, pressed);
  PetscReal both[2] = {depth <= m->contact_margin ? 0. : depth, pressed};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, both, 2, MPIU_REAL, MPI_MAX, m->comm));
  m->contact_depth = both[0], m->contact_pressed = both[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds far faces and ghosts, then the candidates of faces and of vertices. */
static PetscErrorCode find(const Scene *scene, Model *m, State *state, const OldContacts *old,
                           FaceTable *table, CandidateList *list)
{
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_FAR_FACES));
  PetscCall(NeighboursUpdate(m, state));
  PetscCall(TimerEnd(TIMER_FAR_FACES));
  PetscCall(TimerBegin(TIMER_NEAR_FACES));
  PetscCall(FaceTableCreate(m, state->u + 3 * m->rigid.n, PETSC_TRUE, table));
  PetscCall(TimerEnd(TIMER_NEAR_FACES));
  PetscCall(TimerBegin(TIMER_FACE_CONTACTS));
  PetscCall(ContactsFind(scene, m, old, table, list));
  PetscCall(CornersHide(scene, m, table, list));
  PetscCall(TimerEnd(TIMER_FACE_CONTACTS));
  PetscCall(TimerBegin(TIMER_VERTEX_CONTACTS));
  PetscCall(VerticesFind(scene, m, old, table, list));
  PetscCall(TimerEnd(TIMER_VERTEX_CONTACTS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsVerify(const Scene *scene, const Joint *joints, Model *m, State *state, Contacts *c,
                              StageResult *result)
{
  Contacts before = *c;
  VertexMap map;
  OldContacts old;
  FaceTable table;
  CandidateList list = {0};
  PetscBool need;
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_VERIFICATION));
  PetscCall(OldContactsCreate(&before, &old));
  PetscCall(ContactsNeedVerify(m, state, &need, &old.moved));
  PetscCall(vertices_before(m, &map));
  PetscCall(measure_depth(scene, &before, m));
  PetscCall(find(scene, m, state, &old, &table, &list));
  vertices_now(m, &map);
  PetscCall(TimerBegin(TIMER_HISTORY));
  PetscCall(keep(m, &before, &list));
  PetscCall(CandidatesSort(m, &list));
  PetscCall(ContactsStore(scene, m, &list, &before, map.now, c));
  c->rate = before.rate, c->lead = before.lead, c->friction = before.friction, c->pull = before.pull;
  c->margin = before.margin, c->outgrown = before.outgrown;
  PetscCall(ContactsInherit(scene, m, joints, &table, &old, &list, c));
  PetscCall(count(m, &table, &before, &list, c, result));
  PetscCall(PetscArraycpy(state->u_verified, state->u, m->n_dof));
  PetscCall(ContactsDestroy(&before));
  PetscCall(OldContactsDestroy(&old));
  PetscCall(FaceTableDestroy(&table));
  PetscCall(PetscFree2(map.ghost, map.now));
  PetscCall(PetscFree(list.item));
  PetscCall(TimerEnd(TIMER_HISTORY));
  PetscCall(TimerEnd(TIMER_VERIFICATION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsOutgrow(const Scene *scene, Model *m, State *state, Contacts *c)
{
  char missing[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  PetscCall(LaterJoints(scene, c, m, missing));
  PetscCheck(!missing[0], PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s", missing);
  PetscCall(StateVerifies(m, state));
  c->outgrown = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a vertex has moved more than VERIFY_AFTER margins since the last verification. For a
   rigid body its translation and its rotation times its reach bound the motion of its vertices. far: [m]
   largest motion of a vertex; NULL: not asked for. */
PetscErrorCode ContactsNeedVerify(const Model *m, const State *state, PetscBool *need, PetscReal *far)
{
  PetscReal moved = 0.;
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    const PetscReal *C = m->rigid.X + 2 * b, *u = state->u + 3 * b, *w = state->u_verified + 3 * b;
    PetscReal reach = 0.;
    for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++)
      reach = PetscMax(reach, PetscSqr(m->mesh.X[2 * v] - C[0]) + PetscSqr(m->mesh.X[2 * v + 1] - C[1]));
    moved = PetscMax(moved, PetscHypotReal(u[0] - w[0], u[1] - w[1]) +
                                PetscAbsReal(u[2] - w[2]) * PetscSqrtReal(reach));
  }
  for (PetscInt d = 3 * m->rigid.n; d < m->n_dof; d += 2)
    moved = PetscMax(moved, PetscHypotReal(state->u[d] - state->u_verified[d],
                                           state->u[d + 1] - state->u_verified[d + 1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPIU_REAL, MPI_MAX, m->comm));
  if (far) *far = moved;
  *need = (PetscBool)(moved > VERIFY_AFTER * m->contact_margin);
  PetscFunctionReturn(PETSC_SUCCESS);
}

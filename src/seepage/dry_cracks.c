/* dry_cracks.c: finds open joints that reach water but have no water pressure in them. A reservoir presses
   on the faces of its set, an uplift on the faces of its joint. A crack that opens beside these faces, at
   the bottom of the reservoir or at the heel, stays dry. Water would enter from a vertex of the
   reservoir's faces below its level and follow the open joints. Its force is reported and written; it acts
   on nothing. */
#include "contacts/contacts.h"
#include "seepage/flow.h"

static const PetscReal DRY_LEAST = 0.01; // [m] of a joint: shorter lengths are not reported

/* An open contact to which no load of the stage applies water. */
typedef struct {
  PetscInt key[2], joint, open[2];
  PetscInt gid[2][2]; /* vertices at each end, -1: none */
  PetscReal x[2][2];  /* [m] places of its ends in the mesh */
  PetscReal u_n[2];   /* [m] openings */
  PetscBool reached;
} DryRow;

/* A vertex of the faces of a reservoir, below its level. */
typedef struct {
  PetscInt gid, load;
} WetPlace;

/* Dry open length of a joint. */
typedef struct {
  PetscReal length, force; /* [m], [N] missing water force on each side */
  PetscInt load;           /* the water that would enter */
} DryJoint;

static PetscBool is_free_water(const Load *load)
{
  return (PetscBool)(load->kind == LOAD_RESERVOIR || load->kind == LOAD_OVERFLOW ||
                     load->kind == LOAD_TAILWATER);
}

/* Collective. Gathers the vertices of faces below free water, ascending, and the faces on which a load
   (free water or uplift) applies water pressure. */
static PetscErrorCode gather_water(const TermView *v, PetscInt *n_wet, WetPlace **wet, PetscInt *n_gids,
                                   PetscInt **gids)
{
  const Model *m = v->m;
  PetscInt n = 0, n_faces = 0, n_set, room = 0, *mine;
  WetPlace *places;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const Load *load = v->scene->loads + v->stage->loads[i];
    if (!is_free_water(load) && load->kind != LOAD_UPLIFT) continue;
    (void)FacesOfSet(m, load->target, &n_set);
    room += n_set;
  }
  PetscCall(PetscMalloc2(room + 1, &mine, 2 * room + 1, &places));
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const PetscInt l = v->stage->loads[i];
    const Load *load = v->scene->loads + l;
    if (!is_free_water(load) && load->kind != LOAD_UPLIFT) continue;
    const PetscInt *faces = FacesOfSet(m, load->target, &n_set);
    for (PetscInt f = 0; f < n_set; f++) {
      const PetscInt face = faces[f];
      mine[n_faces++] = m->faces.gid[face];
      for (int k = 0; k < 2 && load->kind != LOAD_UPLIFT; k++) {
        const PetscInt vertex = m->faces.vertex[2 * face + k];
        if (m->mesh.X[2 * vertex + 1] < load->level) places[n++] = (WetPlace){m->mesh.vertex_gid[vertex], l};
      }
    }
  }
  PetscCall(GatherToAll(m->comm, n_faces, sizeof(PetscInt), mine, n_gids, (void **)gids));
  PetscCall(PetscSortRemoveDupsInt(n_gids, *gids));
  PetscCall(GatherToAll(m->comm, n, sizeof(WetPlace), places, n_wet, (void **)wet));
  qsort(*wet, *n_wet, sizeof(WetPlace), OrderByPair);
  PetscCall(PetscFree2(mine, places));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether a face is in the ascending list. */
static PetscBool is_among(PetscInt gid, PetscInt n, const PetscInt *gids)
{
  PetscInt at = -1;
  PetscCallAbort(PETSC_COMM_SELF, PetscFindInt(gid, n, gids, &at));
  return (PetscBool)(at >= 0);
}

static PetscBool is_open(const Contacts *c, PetscInt i, int k)
{
  return (PetscBool)(c->key[2 * i] >= 0 && c->key[2 * i + 1] >= 0 && c->owned[i] &&
                     (c->state[SUB(i, k)] & CONTACT_OPEN));
}

/* Collective. Gathers the open contacts without water pressure, the same on all ranks. */
static PetscErrorCode gather_open(const TermView *v, PetscInt n_gids, const PetscInt *gids, PetscInt *n,
                                  DryRow **rows)
{
  const Model *m = v->m;
  const Contacts *c = v->contacts;
  const PetscReal tie = 1e-6;
  PetscInt n_mine = 0, carrier;
  const PetscBool flows = FlowActs(v->scene, v->stage, &carrier);
  DryRow *mine;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < c->n_padded; i++) n_mine += is_open(c, i, 0) || is_open(c, i, 1);
  PetscCall(PetscCalloc1(n_mine + 1, &mine));
  n_mine = 0;
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscInt *key = c->key + 2 * i;
    if (!is_open(c, i, 0) && !is_open(c, i, 1)) continue;
    const Joint *joint = v->stage->joints + c->joint[i];
    if (is_among(key[0], n_gids, gids) || is_among(key[1], n_gids, gids)) continue;
    if (flows && !PetscIsNanReal(joint->aperture) && joint->water != LETS_NONE_IN) continue;
    DryRow *row = mine + n_mine++;
    row->joint = c->joint[i];
    for (int k = 0; k < 2; k++) {
      const PetscReal t = c->t[SUB(i, k)];
      PetscInt at[3];
      ContactEndVertices(c, i, k, at);
      row->key[k] = key[k], row->open[k] = is_open(c, i, k), row->u_n[k] = c->u_n[SUB(i, k)];
      row->gid[k][0] = m->mesh.vertex_gid[at[0]];
      row->gid[k][1] = t < tie ? m->mesh.vertex_gid[at[1]] : t > 1. - tie ? m->mesh.vertex_gid[at[2]] : -1;
      for (int x = 0; x < 2; x++) row->x[k][x] = m->mesh.X[2 * at[0] + x];
    }
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(DryRow), mine, OrderByPair, n, (void **)rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- how far water would get */

/* An end of a row, for finding the ends at one place. */
typedef struct {
  PetscReal x;
  PetscInt end;
} EndPlace;

static int place_order(const void *a, const void *b)
{
  const EndPlace *p = a, *q = b;
  if (p->x != q->x) return p->x < q->x ? -1 : 1;
  return (p->end > q->end) - (p->end < q->end);
}

/* Adds the force of water that enters at end k of a row. Returns whether the water reaches the other end. */
static PetscBool fill(const Scene *scene, PetscInt load, DryRow *row, int k, DryJoint *joints)
{
  const Load *water = scene->loads + load;
  const PetscReal *u_n = row->u_n,
                  length = PetscHypotReal(row->x[1][0] - row->x[0][0], row->x[1][1] - row->x[0][1]);
  const PetscBool whole = (PetscBool)(row->open[0] && row->open[1]);
  const PetscReal part = whole ? 1. : u_n[k] > 0. && u_n[1 - k] < 0. ? u_n[k] / (u_n[k] - u_n[1 - k]) : 0.5;
  const PetscReal from = water->level - row->x[k][1], to = from + part * (row->x[k][1] - row->x[1 - k][1]);
  DryJoint *joint = joints + row->joint;
  row->reached = PETSC_TRUE;
  joint->length += part * length;
  joint->force += 0.5 * (PetscMax(0., from) + PetscMax(0., to)) * part * length * water->density *
                  scene->gravity * scene->thickness;
  if (joint->load < 0 || water->level > scene->loads[joint->load].level) joint->load = load;
  return whole;
}

/* Lets the water of a load enter at its vertices and follows it through open joints. */
static PetscErrorCode follow(const TermView *v, PetscInt load, PetscInt n_wet, const WetPlace *wet,
                             PetscInt n, DryRow *rows, const EndPlace *places, DryJoint *joints)
{
  const PetscReal near = PetscMax(1e-9, v->scene->contact_relative ? 0. : v->scene->contact_tolerance);
  PetscInt *stack, n_stack = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * n + 1, &stack));
  for (PetscInt e = 0; e < 2 * n; e++)
    for (int k = 0; k < 2 && rows[e / 2].open[e % 2]; k++) {
      const WetPlace key = {rows[e / 2].gid[e % 2][k], load};
      if (rows[e / 2].reached || !bsearch(&key, wet, (size_t)n_wet, sizeof(WetPlace), OrderByPair)) continue;
      if (fill(v->scene, load, rows + e / 2, (int)(e % 2), joints)) stack[n_stack++] = e ^ 1;
    }
  while (n_stack) {
    const PetscInt at = stack[--n_stack];
    const PetscReal *x = rows[at / 2].x[at % 2];
    const EndPlace from = {x[0] - near, -1};
    PetscInt i = LowerBound(&from, places, 2 * n, sizeof(EndPlace), place_order);
    for (; i < 2 * n && places[i].x <= x[0] + near; i++) {
      const PetscInt e = places[i].end;
      DryRow *row = rows + e / 2;
      if (row->reached || !row->open[e % 2] || PetscAbsReal(row->x[e % 2][1] - x[1]) > near) continue;
      if (fill(v->scene, load, row, (int)(e % 2), joints)) stack[n_stack++] = e ^ 1;
    }
  }
  PetscCall(PetscFree(stack));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the term */

static PetscErrorCode create(const TermView *v, void **memory)
{
  DryJoint *joints;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(v->scene->n_joints + 1, &joints));
  *memory = joints;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  PetscFunctionBeginUser;
  (void)scene;
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void warn_dry(const TermView *v, const DryJoint *joints)
{
  for (PetscInt j = 0; j < v->scene->n_joints; j++) {
    if (!(joints[j].length > DRY_LEAST)) continue;
    Warn(
        "stage %s: joint %s is open over %.4g m from where it comes out under the water of "
        "loads.%s, and has no water in it: that would press with %.4g kN on each side: a load of type uplift "
        "on "
        "it lets it in",
        v->stage->name, v->scene->joints[j].name, (double)joints[j].length,
        v->scene->loads[joints[j].load].name, (double)joints[j].force / 1e3);
  }
}

/* Collective. Finds the dry open joints. */
static PetscErrorCode find_dry(const TermView *v, PetscBool report)
{
  DryJoint *joints = v->memory;
  PetscInt n_wet = 0, n_gids = 0, n = 0, *gids, n_open = 0;
  WetPlace *wet;
  DryRow *rows;
  EndPlace *places;
  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < v->scene->n_joints; j++) joints[j] = (DryJoint){.load = -1};
  for (PetscInt i = 0; i < v->contacts->n_padded; i++)
    n_open += is_open(v->contacts, i, 0) || is_open(v->contacts, i, 1);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n_open, 1, MPIU_INT, MPI_SUM, v->m->comm));
  if (!n_open) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(gather_water(v, &n_wet, &wet, &n_gids, &gids));
  PetscCall(gather_open(v, n_gids, gids, &n, &rows));
  PetscCall(PetscMalloc1(2 * n + 1, &places));
  for (PetscInt e = 0; e < 2 * n; e++) places[e] = (EndPlace){rows[e / 2].x[e % 2][0], e};
  qsort(places, 2 * n, sizeof(EndPlace), place_order);
  for (PetscInt done = 0; n_wet;) { // the highest water first
    PetscInt load = -1;
    for (PetscInt i = 0; i < v->stage->n_loads; i++) {
      const Load *other = v->scene->loads + v->stage->loads[i];
      PetscInt above = 0;
      for (PetscInt k = 0; k < v->stage->n_loads; k++) {
        const Load *one = v->scene->loads + v->stage->loads[k];
        above += is_free_water(one) && (one->level > other->level || (one->level == other->level && k < i));
      }
      if (is_free_water(other) && above == done) load = v->stage->loads[i];
    }
    if (load < 0) break;
    PetscCall(follow(v, load, n_wet, wet, n, rows, places, joints));
    done++;
  }
  if (report && !v->m->rank && !StageInTime(v->stage)) warn_dry(v, joints);
  PetscCall(PetscFree(places));
  PetscCall(PetscFree(rows));
  PetscCall(PetscFree(wet));
  PetscCall(PetscFree(gids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void summary(Json *json, const TermView *v)
{
  const DryJoint *joints = v->memory;
  JsonOpenLater(json, "dry_joints");
  for (PetscInt j = 0; j < v->scene->n_joints; j++) {
    if (!(joints[j].length > DRY_LEAST)) continue;
    JsonOpen(json, v->scene->joints[j].name);
    JsonNumbers(json, {"length", joints[j].length}, {"force", joints[j].force});
    JsonText(json, "water", v->scene->loads[joints[j].load].name);
    JsonClose(json);
  }
  JsonClose(json);
}

const TermKind Dry_term = {
    .name = "dry", .create = create, .destroy = destroy, .before_summary = find_dry, .summary = summary};

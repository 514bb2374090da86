/* flow_rows.c: gathers the contacts in which water may flow, on all ranks in one order. */
#include "seepage/flow.h"

/* Returns the opening [m] of an end, as force.c computes it: distance of P from line AB, in the current
   configuration or, in small strain, with the normal of the undeformed line. */
static PetscReal opening_of(const Model *m, const Contacts *c, PetscInt i, int k, const PetscReal *u)
{
  const PetscReal t = c->t[SUB(i, k)], moving = m->materials.strain == STRAIN_LARGE ? 1. : 0.;
  PetscInt v[3];
  PetscReal d[2], s[2];
  ContactEndVertices(c, i, k, v);
  for (int x = 0; x < 2; x++) {
    const PetscInt P = 2 * v[0] + x, A = 2 * v[1] + x, B = 2 * v[2] + x;
    d[x] = (m->mesh.X[P] - m->mesh.X[A] - t * (m->mesh.X[B] - m->mesh.X[A])) +
           (u[P] - u[A] - t * (u[B] - u[A]));
    s[x] = (m->mesh.X[B] - m->mesh.X[A]) + moving * (u[B] - u[A]);
  }
  return (d[0] * s[1] - d[1] * s[0]) / PetscHypotReal(s[0], s[1]) - c->rest[SUB(i, k)];
}

/* Returns which end of a face a vertex is: 0 or 1. */
static int corner_of(const Model *m, PetscInt face, PetscInt vertex)
{
  return m->faces.vertex[2 * face] == vertex ? 0 : 1;
}

/* Returns the vertex of a face at position t, or -1 if neither end is there. */
static PetscInt vertex_near(PetscReal t, const PetscInt vertex[2])
{
  const PetscReal tie = 1e-6;
  return t < tie ? vertex[0] : t > 1. - tie ? vertex[1] : -1;
}

static const PetscReal ROUNDED = 1e-12; /* of the mesh's diameter: smaller openings are rounding */

static void fill_end(const Model *m, const Contacts *c, const Joint *joint, PetscInt i, int k,
                     const PetscReal *u, const PetscInt face[2], FlowRow *row)
{
  const int side = ContactSideOfVertex(c, i, k);
  const PetscReal t = c->t[SUB(i, k)], moving = m->materials.strain == STRAIN_LARGE ? 1. : 0.;
  PetscInt v[3];
  ContactEndVertices(c, i, k, v);
  row->t[side][k] = corner_of(m, face[side], v[0]);
  row->t[1 - side][k] = corner_of(m, face[1 - side], v[1]) ? 1. - t : t;
  row->vertex[k][0] = m->mesh.vertex_gid[v[0]];
  row->vertex[k][1] = vertex_near(t, (const PetscInt[]){m->mesh.vertex_gid[v[1]], m->mesh.vertex_gid[v[2]]});
  for (int x = 0; x < 2; x++) row->x[k][x] = m->mesh.X[2 * v[0] + x] + moving * u[2 * v[0] + x];
  row->opening[k] = opening_of(m, c, i, k, u);
  row->failed[k] = c->broken[SUB(i, k)] != 0. || joint->k_s * PetscAbsReal(c->slip[SUB(i, k)]) > c->margin ||
                   joint->k_n * (row->opening[k] - ROUNDED * m->mesh.diameter) > c->margin;
}

PetscErrorCode FlowRowsGather(const Model *m, const Contacts *c, const Joint *joints, const PetscReal *u,
                              PetscInt *n, FlowRow **rows)
{
  PetscInt n_mine = 0;
  FlowRow *mine;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(PetscMax(1, c->n), &mine));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    const PetscInt *key = c->key + 2 * i;
    if (key[0] < 0 || key[1] < 0 || !c->owned[i])
      continue; // padding, or a vertex-face contact, which has no area
    const Joint *joint = joints + c->joint[i];
    if (PetscIsNanReal(joint->aperture) || joint->water == LETS_NONE_IN) continue;
    const PetscInt face[2] = {FaceRow(m, key[0]), FaceRow(m, key[1])};
    FlowRow *row = mine + n_mine;
    for (int k = 0; k < 2; k++) row->key[k] = key[k];
    row->joint = c->joint[i], row->length = c->length[i];
    for (int k = 0; k < 2; k++) fill_end(m, c, joint, i, k, u, face, row);
    row->shut = joint->water == LETS_IN_AFTER_FAILURE && !row->failed[0] && !row->failed[1];
    n_mine++;
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(FlowRow), mine, OrderByPair, n, (void **)rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- parted faces */

/* A face in its current configuration. */
typedef struct {
  PetscInt gid, vertex[2]; /* vertex: gids */
  PetscReal x[4];          /* [m] */
} FlowFace;

/* Collective. Gathers the faces with these gids, ascending. The owner of the first vertex sends a face. */
static PetscErrorCode gather_faces(const Model *m, const PetscReal *u, PetscInt n_gids, const PetscInt *gids,
                                   PetscInt *n, FlowFace **faces)
{
  PetscInt n_mine = 0;
  FlowFace *mine;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n_gids + 1, &mine));
  for (PetscInt f = 0; f < m->faces.n_local; f++) {
    const PetscInt *v = m->faces.vertex + 2 * f;
    PetscInt at;
    if (v[0] >= m->mesh.n_owned) continue;
    PetscCall(PetscFindInt(m->faces.gid[f], n_gids, gids, &at));
    if (at < 0) continue;
    FlowFace *face = mine + n_mine++;
    face->gid = m->faces.gid[f];
    for (int k = 0; k < 2; k++) face->vertex[k] = m->mesh.vertex_gid[v[k]];
    FaceCoordinates(m, u, f, face->x);
  }
  PetscCall(GatherSorted(m->comm, n_mine, sizeof(FlowFace), mine, OrderByFirst, n, (void **)faces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Projects P onto a face: t along it, gap towards its outer side. */
static void stand_beside(const FlowFace *face, const PetscReal P[2], PetscReal *t, PetscReal *gap)
{
  const PetscReal *x = face->x, e[2] = {x[2] - x[0], x[3] - x[1]}, d[2] = {P[0] - x[0], P[1] - x[1]},
                  length = PetscHypotReal(e[0], e[1]);
  *t = (d[0] * e[0] + d[1] * e[1]) / (length * length);
  *gap = (d[0] * e[1] - d[1] * e[0]) / length;
}

/* Makes a row of the void between two faces. Returns false if the faces do not lie opposite each other (a
   block has slid off or rotated away), or if they are not apart. */
static PetscBool open_void(const FlowFace *const face[2], FlowRow *row)
{
  const PetscReal turned = 0.5, *a = face[0]->x, *b = face[1]->x; // cosine of 60 degrees
  PetscReal first, second, gap, length[2];
  int side[2], corner[2]; // face and corner of the vertex at each end; ends follow each other along face 0
  for (int k = 0; k < 2; k++)
    length[k] = PetscHypotReal(face[k]->x[2] - face[k]->x[0], face[k]->x[3] - face[k]->x[1]);
  if ((a[2] - a[0]) * (b[2] - b[0]) + (a[3] - a[1]) * (b[3] - b[1]) > -turned * length[0] * length[1])
    return PETSC_FALSE;
  stand_beside(face[0], b, &first, &gap);
  stand_beside(face[0], b + 2, &second, &gap); // face 1 runs backwards
  row->length = (PetscMin(1., first) - PetscMax(0., second)) * length[0];
  if (row->length <= 1e-6 * PetscMin(length[0], length[1])) return PETSC_FALSE;
  side[0] = second > 0., corner[0] = second > 0. ? 1 : 0;
  side[1] = first < 1., corner[1] = first < 1. ? 0 : 1;
  for (int k = 0; k < 2; k++) {
    const PetscReal *P = face[side[k]]->x + 2 * corner[k];
    const FlowFace *other = face[1 - side[k]];
    PetscReal t;
    stand_beside(other, P, &t, &row->opening[k]);
    row->t[side[k]][k] = corner[k], row->t[1 - side[k]][k] = t;
    row->vertex[k][0] = face[side[k]]->vertex[corner[k]], row->vertex[k][1] = vertex_near(t, other->vertex);
    row->x[k][0] = P[0], row->x[k][1] = P[1];
    row->failed[k] = 1;
  }
  row->parted = 1, row->shut = 0;
  return (PetscBool)(PetscMax(row->opening[0], row->opening[1]) > 0.);
}

/* Collective. Drops the n lost rows but for rows whose faces have a void between them now. */
static PetscErrorCode keep_voids(const Model *m, const PetscReal *u, PetscInt *n, FlowRow *lost)
{
  PetscInt *gids, n_gids = 2 * *n, n_faces, kept = 0;
  FlowFace *faces;
  PetscFunctionBeginUser;
  if (!*n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n_gids, &gids));
  for (PetscInt i = 0; i < n_gids; i++) gids[i] = lost[i / 2].key[i % 2];
  PetscCall(PetscSortRemoveDupsInt(&n_gids, gids));
  PetscCall(gather_faces(m, u, n_gids, gids, &n_faces, &faces));
  for (PetscInt i = 0; i < *n; i++) {
    const FlowFace *face[2];
    for (int k = 0; k < 2; k++)
      face[k] = bsearch(&(FlowFace){.gid = lost[i].key[k]}, faces, n_faces, sizeof(FlowFace), OrderByFirst);
    if (face[0] && face[1] && open_void(face, lost + i)) lost[kept++] = lost[i];
  }
  *n = kept;
  PetscCall(PetscFree(gids));
  PetscCall(PetscFree(faces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- history of rows */

PetscErrorCode FlowRowsFollow(const Model *m, const Joint *joints, const PetscReal *u, PetscInt n_before,
                              const FlowRow *before, PetscInt *n, FlowRow **rows)
{
  PetscInt n_lost = 0;
  FlowRow *all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(*n + n_before + 1, &all));
  PetscCall(PetscArraycpy(all, *rows, *n));
  for (PetscInt i = 0; i < n_before; i++) {
    const Joint *joint = joints + before[i].joint;
    const FlowRow *now = bsearch(before + i, *rows, *n, sizeof(FlowRow), OrderByPair);
    if (!now && !PetscIsNanReal(joint->aperture) && joint->water != LETS_NONE_IN)
      all[*n + n_lost++] = before[i];
    if (!now) continue;
    FlowRow *row = all + (now - *rows);
    for (int k = 0; k < 2; k++) row->failed[k] = row->failed[k] || before[i].failed[k];
    if (row->failed[0] || row->failed[1]) row->shut = 0;
  }
  PetscCall(keep_voids(m, u, &n_lost, all + *n));
  *n += n_lost;
  if (n_lost) qsort(all, *n, sizeof(FlowRow), OrderByPair);
  PetscCall(PetscFree(*rows));
  *rows = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

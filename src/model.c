/* model.c: from the distributed Plex to the flat arrays of types.h. Order of work: owned vertices get their numbers; faces
   near other ranks travel; ghosts are what elements and contacts at owned vertices still need; then the arrays. */
#include "internal.h"
#include <petscdmplex.h>

/* An outer face on its way to another rank; also the form in which all faces are gathered before numbering. */
typedef struct {
  PetscInt gid, group, body, rigid, joint, local;    /* local: Plex point, -1: came from another rank */
  PetscInt v_gid[2], v_file[2], v_owner[2], v_index[2]; /* of its two vertices: owner rank and local index there */
  PetscReal x[4];
} FaceRecord;

/* A vertex this rank reads but does not own. */
typedef struct {
  PetscInt gid, file, body, rigid, owner, index;
  PetscReal x[2];
} GhostRecord;

typedef struct {
  DM dm;
  PointRecord *record;
  PetscInt c_start, c_end, v_start, v_end, e_start, e_end;
  PetscInt *owner; /* (points,) rank that owns the point */
  PetscInt *index; /* (vertices,) index of the vertex on its owner */
  PetscReal *x;    /* (vertices,2) */
  FaceRecord *face;
  PetscInt n_faces, n_faces_local;
  GhostRecord *ghost;
  PetscInt n_ghosts;
} Builder;

/* ---- owned vertices */

static PetscErrorCode find_owners(Builder *b, PetscMPIInt rank)
{
  PetscSF sf;
  PetscInt n_points, n_leaves, n_roots;
  const PetscInt *leaves;
  const PetscSFNode *remote;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetHeightStratum(b->dm, 0, &b->c_start, &b->c_end));
  PetscCall(DMPlexGetDepthStratum(b->dm, 0, &b->v_start, &b->v_end));
  PetscCall(DMPlexGetDepthStratum(b->dm, 1, &b->e_start, &b->e_end));
  PetscCall(DMPlexGetChart(b->dm, NULL, &n_points));
  PetscCall(PetscMalloc1(n_points, &b->owner));
  for (PetscInt p = 0; p < n_points; p++) b->owner[p] = rank;
  PetscCall(DMGetPointSF(b->dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &n_roots, &n_leaves, &leaves, &remote));
  for (PetscInt i = 0; n_roots >= 0 && i < n_leaves; i++) b->owner[leaves ? leaves[i] : i] = remote[i].rank;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode read_coordinates(Builder *b)
{
  Vec coordinates;
  PetscSection section;
  const PetscScalar *x;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * (b->v_end - b->v_start), &b->x));
  PetscCall(DMGetCoordinatesLocal(b->dm, &coordinates));
  PetscCall(DMGetCoordinateSection(b->dm, &section));
  PetscCall(VecGetArrayRead(coordinates, &x));
  for (PetscInt v = b->v_start; v < b->v_end; v++) {
    PetscInt offset;
    PetscCall(PetscSectionGetOffset(section, v, &offset));
    PetscCall(PetscArraycpy(b->x + 2 * (v - b->v_start), x + offset, 2));
  }
  PetscCall(VecRestoreArrayRead(coordinates, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  PetscInt rigid, gid, point;
} OwnedVertex;

static int owned_order(const void *a, const void *b)
{
  const OwnedVertex *f = a, *g = b;
  return f->rigid != g->rigid ? (f->rigid > g->rigid) - (f->rigid < g->rigid) : (f->gid > g->gid) - (f->gid < g->gid);
}

/* Numbers owned vertices: deformable (rigid = -1) by gid, then rigid by body and gid; tells every rank the index at the
   owner. */
static PetscErrorCode number_owned(Builder *b, Model *m)
{
  const PetscInt nv = b->v_end - b->v_start;
  OwnedVertex *owned;
  PetscInt n_points, *all, n_roots;
  PetscSF sf;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(nv, &owned));
  PetscCall(PetscMalloc1(nv, &b->index));
  m->n_owned = m->n_deformable = 0;
  for (PetscInt v = b->v_start; v < b->v_end; v++) {
    b->index[v - b->v_start] = -1;
    if (b->owner[v] != m->rank) continue;
    owned[m->n_owned++] = (OwnedVertex){b->record[v].rigid, b->record[v].gid, v};
    if (b->record[v].rigid < 0) m->n_deformable++;
  }
  qsort(owned, m->n_owned, sizeof(OwnedVertex), owned_order);
  for (PetscInt i = 0; i < m->n_owned; i++) b->index[owned[i].point - b->v_start] = i;
  PetscCall(PetscFree(owned));

  PetscCall(DMGetPointSF(b->dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &n_roots, NULL, NULL, NULL));
  PetscCall(DMPlexGetChart(b->dm, NULL, &n_points));
  if (n_roots >= 0) {
    PetscCall(PetscMalloc1(n_points, &all));
    for (PetscInt p = 0; p < n_points; p++) all[p] = p >= b->v_start && p < b->v_end ? b->index[p - b->v_start] : -1;
    PetscCall(PetscSFBcastBegin(sf, MPIU_INT, all, all, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(sf, MPIU_INT, all, all, MPI_REPLACE));
    for (PetscInt v = b->v_start; v < b->v_end; v++) b->index[v - b->v_start] = all[v];
    PetscCall(PetscFree(all));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- faces */

/* First joint of the scene whose face set holds the face, -1: none. */
static PetscErrorCode joint_of_face(const Builder *b, const Scene *scene, PetscInt point, PetscInt *joint)
{
  PetscFunctionBeginUser;
  *joint = -1;
  for (PetscInt j = 1; j < scene->n_joints && *joint < 0; j++) {
    PetscBool is_set;
    PetscInt value;
    PetscCall(DMHasLabel(b->dm, scene->joints[j].name, &is_set));
    if (!is_set) continue;
    PetscCall(DMGetLabelValue(b->dm, scene->joints[j].name, point, &value));
    if (value == 1) *joint = j;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Outer faces of local blocks. */
static PetscErrorCode local_faces(Builder *b, const Scene *scene)
{
  PetscFunctionBeginUser;
  b->n_faces = 0;
  PetscCall(PetscMalloc1(b->e_end - b->e_start, &b->face));
  for (PetscInt e = b->e_start; e < b->e_end; e++) {
    const PetscInt *cone, *support;
    PetscInt n_support;
    if (b->record[e].gid < 0) continue;
    PetscCall(DMPlexGetSupportSize(b->dm, e, &n_support));
    if (!n_support) continue;
    PetscCall(DMPlexGetSupport(b->dm, e, &support));
    PetscCall(DMPlexGetCone(b->dm, e, &cone));
    const PointRecord *block = b->record + support[0];
    FaceRecord *f = b->face + b->n_faces++;
    *f = (FaceRecord){.gid = b->record[e].gid, .group = block->group, .body = block->body, .rigid = block->rigid, .local = e};
    PetscCall(joint_of_face(b, scene, e, &f->joint));
    for (int k = 0; k < 2; k++) {
      const PetscInt v = cone[k];
      f->v_gid[k] = b->record[v].gid, f->v_file[k] = b->record[v].file;
      f->v_owner[k] = b->owner[v], f->v_index[k] = b->index[v - b->v_start];
      PetscCall(PetscArraycpy(f->x + 2 * k, b->x + 2 * (v - b->v_start), 2));
    }
  }
  b->n_faces_local = b->n_faces;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int face_order(const void *a, const void *b)
{
  const FaceRecord *f = a, *g = b;
  const int fl = f->local < 0, gl = g->local < 0;
  return fl != gl ? fl - gl : (f->gid > g->gid) - (f->gid < g->gid);
}

static PetscBool touches_owned(const FaceRecord *f, PetscMPIInt rank)
{
  return (PetscBool)(f->v_owner[0] == rank || f->v_owner[1] == rank);
}

/* Sends the faces of owned blocks to every rank whose box (of faces at its owned vertices) they meet. */
static PetscErrorCode exchange_faces(Builder *b, MPI_Comm comm, PetscMPIInt rank, PetscMPIInt size, PetscReal margin)
{
  PetscReal mine[4] = {PETSC_INFINITY, PETSC_INFINITY, PETSC_NINFINITY, PETSC_NINFINITY}, *boxes, box[4];
  PetscMPIInt *n_send, *n_receive, *at_send, *at_receive;
  FaceRecord *send = NULL, *received;
  PetscInt total = 0, fetched = 0;
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < b->n_faces; f++) {
    if (!touches_owned(b->face + f, rank)) continue;
    FaceBox(b->face[f].x, b->face[f].x + 2, margin, box);
    for (int i = 0; i < 2; i++) mine[i] = PetscMin(mine[i], box[i]), mine[i + 2] = PetscMax(mine[i + 2], box[i + 2]);
  }
  PetscCall(PetscMalloc1(4 * size, &boxes));
  PetscCallMPI(MPI_Allgather(mine, 4, MPIU_REAL, boxes, 4, MPIU_REAL, comm));
  PetscCall(PetscCalloc4(size, &n_send, size, &n_receive, size + 1, &at_send, size + 1, &at_receive));
  for (int pass = 0; pass < 2; pass++) { // count, then fill
    if (pass) PetscCall(PetscMalloc1(total, &send));
    total = 0;
    for (PetscMPIInt p = 0; p < size; p++) {
      at_send[p] = (PetscMPIInt)(total * sizeof(FaceRecord));
      for (PetscInt f = 0; p != rank && f < b->n_faces; f++) {
        const PetscInt *support;
        const PetscReal *other = boxes + 4 * p;
        PetscCall(DMPlexGetSupport(b->dm, b->face[f].local, &support));
        if (b->owner[support[0]] != rank) continue;
        FaceBox(b->face[f].x, b->face[f].x + 2, margin, box);
        if (box[0] > other[2] || box[2] < other[0] || box[1] > other[3] || box[3] < other[1]) continue;
        if (pass) send[total] = b->face[f], send[total].local = -1;
        total++;
      }
      n_send[p] = (PetscMPIInt)(total * sizeof(FaceRecord)) - at_send[p];
    }
  }
  PetscCallMPI(MPI_Alltoall(n_send, 1, MPI_INT, n_receive, 1, MPI_INT, comm));
  for (PetscMPIInt p = 0; p < size; p++) at_receive[p + 1] = at_receive[p] + n_receive[p];
  fetched = at_receive[size] / (PetscInt)sizeof(FaceRecord);
  PetscCall(PetscMalloc1(b->n_faces + fetched, &received));
  PetscCall(PetscArraycpy(received, b->face, b->n_faces));
  PetscCallMPI(MPI_Alltoallv(send, n_send, at_send, MPI_BYTE, received + b->n_faces, n_receive, at_receive, MPI_BYTE, comm));
  PetscCall(PetscFree(b->face));
  b->face = received;
  b->n_faces += fetched;
  PetscCall(PetscFree(send));
  PetscCall(PetscFree(boxes));
  PetscCall(PetscFree4(n_send, n_receive, at_send, at_receive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps faces at owned vertices and their near partners of other bodies; sorts local before remote, each by gid. */
static PetscErrorCode keep_faces(Builder *b, PetscMPIInt rank, PetscReal margin)
{
  PetscInt n_pairs, *pairs, n = 0;
  PetscReal *box;
  PetscBool *keep;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(4 * b->n_faces, &box, b->n_faces, &keep));
  for (PetscInt f = 0; f < b->n_faces; f++) {
    FaceBox(b->face[f].x, b->face[f].x + 2, margin, box + 4 * f);
    keep[f] = touches_owned(b->face + f, rank);
  }
  PetscCall(GridPairs(b->n_faces, box, &n_pairs, &pairs));
  for (PetscInt p = 0; p < n_pairs; p++) {
    const FaceRecord *f = b->face + pairs[2 * p], *g = b->face + pairs[2 * p + 1];
    const PetscBool here = (PetscBool)(touches_owned(f, rank) || touches_owned(g, rank));
    if (here && f->gid != g->gid) keep[pairs[2 * p]] = keep[pairs[2 * p + 1]] = PETSC_TRUE;
  }
  for (PetscInt f = 0; f < b->n_faces; f++)
    if (keep[f]) b->face[n++] = b->face[f];
  qsort(b->face, n, sizeof(FaceRecord), face_order);

  // a face that is local and was also received counts once
  for (b->n_faces_local = 0; b->n_faces_local < n && b->face[b->n_faces_local].local >= 0;) b->n_faces_local++;
  b->n_faces = b->n_faces_local;
  for (PetscInt f = b->n_faces_local; f < n; f++) {
    const FaceRecord wanted = {.gid = b->face[f].gid, .local = 0};
    if (!bsearch(&wanted, b->face, b->n_faces_local, sizeof(FaceRecord), face_order)) b->face[b->n_faces++] = b->face[f];
  }
  PetscCall(PetscFree(pairs));
  PetscCall(PetscFree2(box, keep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ghosts */

static int ghost_order(const void *a, const void *b)
{
  const GhostRecord *f = a, *g = b;
  return (f->gid > g->gid) - (f->gid < g->gid);
}

/* The vertices of a block in ring order (Plex points); returns 3 or 4. */
static PetscErrorCode block_vertices(DM dm, PetscInt c, PetscInt vertices[4], PetscInt *n)
{
  const PetscInt *cone, *orientation, *ends;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetConeSize(dm, c, n));
  PetscCall(DMPlexGetCone(dm, c, &cone));
  PetscCall(DMPlexGetConeOrientation(dm, c, &orientation));
  for (PetscInt k = 0; k < *n; k++) {
    PetscCall(DMPlexGetCone(dm, cone[k], &ends));
    vertices[k] = ends[orientation[k] >= 0 ? 0 : 1];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode is_needed(const Builder *b, PetscInt c, PetscMPIInt rank, PetscInt v[4], PetscInt *n, PetscBool *needed)
{
  PetscFunctionBeginUser;
  PetscCall(block_vertices(b->dm, c, v, n));
  *needed = PETSC_FALSE;
  for (PetscInt k = 0; k < *n; k++) *needed = (PetscBool)(*needed || b->owner[v[k]] == rank);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ghosts: vertices of needed elements and kept faces that other ranks own; ascending gid, each once. */
static PetscErrorCode find_ghosts(Builder *b, PetscMPIInt rank)
{
  PetscInt n = 0, v[4], k_max = 0;
  PetscBool needed = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * (b->c_end - b->c_start) + 2 * b->n_faces, &b->ghost));
  for (PetscInt c = b->c_start; c < b->c_end; c++) {
    PetscCall(is_needed(b, c, rank, v, &k_max, &needed));
    for (PetscInt k = 0; needed && k < k_max; k++) {
      const PetscInt i = v[k] - b->v_start;
      if (b->owner[v[k]] == rank) continue;
      const PointRecord *p = b->record + v[k];
      b->ghost[n++] = (GhostRecord){p->gid, p->file, p->body, p->rigid, b->owner[v[k]], b->index[i], {b->x[2 * i], b->x[2 * i + 1]}};
    }
  }
  for (PetscInt f = 0; f < b->n_faces; f++)
    for (int k = 0; k < 2; k++) {
      const FaceRecord *r = b->face + f;
      if (r->v_owner[k] == rank) continue;
      b->ghost[n++] = (GhostRecord){r->v_gid[k], r->v_file[k], r->body, r->rigid, r->v_owner[k], r->v_index[k], {r->x[2 * k], r->x[2 * k + 1]}};
    }
  qsort(b->ghost, n, sizeof(GhostRecord), ghost_order);
  b->n_ghosts = 0;
  for (PetscInt i = 0; i < n; i++)
    if (!i || b->ghost[i].gid != b->ghost[b->n_ghosts - 1].gid) b->ghost[b->n_ghosts++] = b->ghost[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Local index of a vertex by owner and index there, or by gid among the ghosts. */
static PetscInt local_vertex(const Builder *b, const Model *m, PetscInt gid, PetscInt owner, PetscInt index)
{
  if (owner == m->rank) return index;
  const GhostRecord wanted = {.gid = gid};
  const GhostRecord *found = bsearch(&wanted, b->ghost, b->n_ghosts, sizeof(GhostRecord), ghost_order);
  return m->n_owned + (PetscInt)(found - b->ghost);
}

/* ---- the arrays */

static PetscErrorCode fill_vertices(const Builder *b, Model *m)
{
  static const PetscReal square[8] = {0., 0., 1., 0., 1., 1., 0., 1.};
  PetscFunctionBeginUser;
  m->n_vertices = m->n_owned + b->n_ghosts;
  PetscCall(PetscMalloc5(2 * (m->n_vertices + DUMMY_VERTICES), &m->X, m->n_vertices, &m->vertex_gid, m->n_vertices,
                         &m->vertex_file, m->n_vertices, &m->vertex_body, m->n_vertices, &m->vertex_rigid));
  for (PetscInt v = b->v_start; v < b->v_end; v++) {
    if (b->owner[v] != m->rank) continue;
    const PetscInt i = b->index[v - b->v_start];
    PetscCall(PetscArraycpy(m->X + 2 * i, b->x + 2 * (v - b->v_start), 2));
    m->vertex_gid[i] = b->record[v].gid, m->vertex_file[i] = b->record[v].file;
    m->vertex_body[i] = b->record[v].body, m->vertex_rigid[i] = b->record[v].rigid;
  }
  for (PetscInt g = 0, i = m->n_owned; g < b->n_ghosts; g++, i++) {
    PetscCall(PetscArraycpy(m->X + 2 * i, b->ghost[g].x, 2));
    m->vertex_gid[i] = b->ghost[g].gid, m->vertex_file[i] = b->ghost[g].file;
    m->vertex_body[i] = b->ghost[g].body, m->vertex_rigid[i] = b->ghost[g].rigid;
  }
  PetscCall(PetscArraycpy(m->X + 2 * m->n_vertices, square, 8));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One list of elements: n_nodes 3 or 4, deformable or rigid. */
static PetscErrorCode fill_elements(const Builder *b, const Model *m, int n_nodes, PetscBool rigid, Elements *e)
{
  PetscInt *point, v[4], k_max = 0, n = 0;
  PetscBool needed = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->c_end - b->c_start, &point));
  PetscCall(PetscMalloc1(b->c_end - b->c_start, &e->gid));
  for (PetscInt c = b->c_start; c < b->c_end; c++) {
    PetscCall(is_needed(b, c, m->rank, v, &k_max, &needed));
    if (needed && k_max == n_nodes && (b->record[c].rigid >= 0) == rigid) e->gid[n] = b->record[c].gid, point[n++] = c;
  }
  PetscCall(PetscSortIntWithArray(n, e->gid, point));
  e->n = n;
  e->n_padded = (n + BATCH - 1) / BATCH * BATCH;
  PetscCall(PetscCalloc2(n_nodes * e->n_padded, &e->vertex, e->n_padded, &e->group));
  PetscCall(PetscMalloc3(n, &e->file, n, &e->body, n, &e->owned));
  for (PetscInt i = 0; i < e->n_padded; i++)
    for (int k = 0; k < n_nodes; k++) e->vertex[((i / BATCH) * n_nodes + k) * BATCH + i % BATCH] = m->n_vertices + k;
  for (PetscInt i = 0; i < n; i++) {
    const PointRecord *r = b->record + point[i];
    PetscInt lowest = PETSC_MAX_INT;
    e->group[i] = r->group, e->file[i] = r->file, e->body[i] = r->body;
    PetscCall(block_vertices(b->dm, point[i], v, &k_max));
    for (int k = 0; k < n_nodes; k++) {
      const PetscInt gid = b->record[v[k]].gid;
      e->vertex[((i / BATCH) * n_nodes + k) * BATCH + i % BATCH] = local_vertex(b, m, gid, b->owner[v[k]], b->index[v[k] - b->v_start]);
      if (gid < lowest) lowest = gid, e->owned[i] = (PetscBool)(b->owner[v[k]] == m->rank);
    }
  }
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode fill_faces(const Builder *b, Model *m)
{
  Faces *f = &m->faces;
  PetscFunctionBeginUser;
  f->n = b->n_faces;
  m->n_faces_local = b->n_faces_local;
  PetscCall(PetscMalloc6(2 * f->n, &f->vertex, f->n, &f->gid, f->n, &f->group, f->n, &f->body, f->n, &f->rigid, f->n, &f->joint));
  for (PetscInt i = 0; i < f->n; i++) {
    const FaceRecord *r = b->face + i;
    for (int k = 0; k < 2; k++) f->vertex[2 * i + k] = local_vertex(b, m, r->v_gid[k], r->v_owner[k], r->v_index[k]);
    f->gid[i] = r->gid, f->group[i] = r->group, f->body[i] = r->body, f->rigid[i] = r->rigid, f->joint[i] = r->joint;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Named sets: rows of local faces, ascending gid; points on this rank. */
static PetscErrorCode fill_sets(const Builder *b, const BlockMesh *mesh, Model *m)
{
  PetscInt n = 0, *row, *vertex_of_point;
  PetscFunctionBeginUser;
  m->n_face_sets = mesh->n_face_sets, m->n_points = mesh->n_points;
  PetscCall(PetscMalloc2(m->n_face_sets, &m->face_set_names, m->n_points, &m->point_names));
  PetscCall(PetscArraycpy(m->face_set_names, mesh->face_set_names, m->n_face_sets));
  PetscCall(PetscArraycpy(m->point_names, mesh->point_names, m->n_points));
  PetscCall(PetscMalloc3(m->n_face_sets + 1, &m->face_set_start, m->n_face_sets * m->n_faces_local, &row, m->n_points, &m->point_vertex));
  m->face_set_faces = row;
  m->face_set_start[0] = 0;
  for (PetscInt s = 0; s < m->n_face_sets; s++) {
    for (PetscInt f = 0; f < m->n_faces_local; f++) {
      PetscInt value;
      PetscCall(DMGetLabelValue(b->dm, m->face_set_names[s], b->face[f].local, &value));
      if (value == 1) row[n++] = f;
    }
    m->face_set_start[s + 1] = n;
  }
  PetscCall(PetscMalloc1(m->n_points, &vertex_of_point));
  if (m->rank == 0) PetscCall(PetscArraycpy(vertex_of_point, mesh->point_vertex, mesh->n_points));
  PetscCallMPI(MPI_Bcast(vertex_of_point, m->n_points, MPIU_INT, 0, m->comm));
  for (PetscInt i = 0; i < m->n_points; i++) {
    m->point_vertex[i] = -1;
    for (PetscInt v = 0; v < m->n_vertices; v++)
      if (m->vertex_gid[v] == vertex_of_point[i]) m->point_vertex[i] = v;
  }
  PetscCall(PetscFree(vertex_of_point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode fill_materials(const Scene *scene, const BlockMesh *mesh, Model *m)
{
  PetscFunctionBeginUser;
  m->n_groups = mesh->n_groups;
  m->thickness = scene->thickness;
  m->strain = scene->strain;
  PetscCall(PetscMalloc5(m->n_groups, &m->group_names, m->n_groups, &m->group_rigid, m->n_groups, &m->lambda, m->n_groups, &m->mu,
                         m->n_groups, &m->density));
  for (PetscInt g = 0; g < m->n_groups; g++) {
    const Material *material = scene->materials + g;
    const PetscReal E = material->young, nu = material->poisson;
    PetscCall(PetscArraycpy(m->group_names + g, mesh->group_names + g, 1));
    m->group_rigid[g] = mesh->group_rigid[g];
    m->density[g] = material->density;
    m->mu[g] = E / (2. * (1. + nu));
    m->lambda[g] = scene->plane == PLANE_STRAIN ? E * nu / ((1. + nu) * (1. - 2. * nu)) : E * nu / (1. - nu * nu);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ghost_sf(const Builder *b, Model *m)
{
  PetscInt *leaves;
  PetscSFNode *roots;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->n_ghosts, &leaves));
  PetscCall(PetscMalloc1(b->n_ghosts, &roots));
  for (PetscInt g = 0; g < b->n_ghosts; g++) {
    leaves[g] = m->n_owned + g;
    roots[g].rank = b->ghost[g].owner;
    roots[g].index = b->ghost[g].index;
  }
  PetscCall(PetscSFCreate(m->comm, &m->ghost));
  PetscCall(PetscSFSetGraph(m->ghost, m->n_owned, b->n_ghosts, leaves, PETSC_OWN_POINTER, roots, PETSC_OWN_POINTER));
  PetscCall(PetscSFSetUp(m->ghost));
  PetscCallMPI(MPI_Type_contiguous(2, MPIU_REAL, &m->pair));
  PetscCallMPI(MPI_Type_commit(&m->pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks the dofs of the groups that enter the Rayleigh quotient (all when none is named). */
static PetscErrorCode damping_groups(const Scene *scene, Model *m)
{
  const Elements *list[4] = {&m->q4, &m->t3, &m->rigid_q4, &m->rigid_t3};
  const PetscInt at = 3 * m->n_bodies;
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) m->in_quotient[d] = scene->n_damping_groups ? 0. : 1.;
  for (PetscInt g = 0; g < scene->n_damping_groups; g++)
    for (int l = 0; l < 4; l++)
      for (PetscInt e = 0, n_nodes = l % 2 ? 3 : 4; e < list[l]->n; e++) {
        if (strcmp(m->group_names[list[l]->group[e]], scene->damping_groups[g])) continue;
        for (PetscInt k = 0; k < n_nodes; k++) {
          const PetscInt v = list[l]->vertex[((e / BATCH) * n_nodes + k) * BATCH + e % BATCH];
          if (v < m->n_deformable) m->in_quotient[at + 2 * v] = m->in_quotient[at + 2 * v + 1] = 1.;
          if (v < m->n_deformable || v >= m->n_owned) continue;
          for (int i = 0; i < 3; i++) m->in_quotient[3 * RigidOfVertex(m, v) + i] = 1.;
        }
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True masses, macroblock and share in the damping quotient of every dof; supports come later (loads.c). */
static PetscErrorCode fill_dofs(const Scene *scene, Model *m)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscReal *vertex_mass;
  PetscFunctionBeginUser;
  m->n_dof = at + 2 * m->n_deformable;
  PetscCall(PetscMalloc4(m->n_dof, &m->mass, m->n_dof, &m->fixed, m->n_dof, &m->in_quotient, m->n_dof, &m->dof_body));
  PetscCall(PetscArrayzero(m->fixed, m->n_dof));
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &vertex_mass));
  PetscCall(ElementMasses(m, vertex_mass));
  for (PetscInt b = 0; b < m->n_bodies; b++)
    for (int i = 0; i < 3; i++) {
      m->mass[3 * b + i] = m->body_mass[2 * b + (i == 2)];
      m->dof_body[3 * b + i] = m->body_body[b];
    }
  for (PetscInt d = 0; d < 2 * m->n_deformable; d++) {
    m->mass[at + d] = vertex_mass[d / 2];
    m->dof_body[at + d] = m->vertex_body[d / 2];
  }
  PetscCall(PetscFree(vertex_mass));
  PetscCall(damping_groups(scene, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers that describe the whole mesh, from rank 0. */
static PetscErrorCode broadcast_sizes(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh, PetscInt n_rigid, Model *m)
{
  PetscReal measure[2] = {0., 0.}; // longest face, diameter
  PetscInt n[4] = {mesh->n_vertices, mesh->n_blocks, mesh->n_bodies, n_rigid};
  PetscReal low[2] = {PETSC_INFINITY, PETSC_INFINITY}, high[2] = {PETSC_NINFINITY, PETSC_NINFINITY};
  PetscFunctionBeginUser;
  m->comm = comm;
  PetscCallMPI(MPI_Comm_rank(comm, &m->rank));
  PetscCallMPI(MPI_Comm_size(comm, &m->size));
  PetscCallMPI(MPI_Bcast(n, 4, MPIU_INT, 0, comm));
  m->n_vertices_global = n[0], m->n_blocks_global = n[1], m->n_bodies_global = n[2], m->n_rigid_global = n[3];
  for (PetscInt i = 0; i < 2 * mesh->n_vertices; i++) low[i % 2] = PetscMin(low[i % 2], mesh->X[i]), high[i % 2] = PetscMax(high[i % 2], mesh->X[i]);
  measure[1] = PetscSqrtReal((high[0] - low[0]) * (high[0] - low[0]) + (high[1] - low[1]) * (high[1] - low[1]));
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    for (int k = 0, nk = mesh->blocks[4 * b + 3] < 0 ? 3 : 4; k < nk; k++) {
      const PetscReal *p = mesh->X + 2 * mesh->blocks[4 * b + k], *q = mesh->X + 2 * mesh->blocks[4 * b + (k + 1) % nk];
      measure[0] = PetscMax(measure[0], PetscSqrtReal((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1])));
    }
  PetscCallMPI(MPI_Bcast(measure, 2, MPIU_REAL, 0, comm));
  m->diameter = measure[1];
  m->contact_margin = scene->contact_tolerance * (scene->contact_relative ? measure[0] : 1.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, Model *m)
{
  Builder b = {0};
  PetscInt *rigid = NULL, n_rigid = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(m, sizeof(*m)));
  PetscCallMPI(MPI_Comm_rank(comm, &m->rank));
  if (m->rank == 0) PetscCall(MeshRigidBodies(mesh, &n_rigid, &rigid));
  PetscCall(broadcast_sizes(comm, scene, mesh, n_rigid, m));
  const PetscReal margin = m->contact_margin;
  PetscCall(MeshDistribute(comm, mesh, rigid, margin, &b.dm, &b.record));
  PetscCall(PetscFree(rigid));
  PetscCall(find_owners(&b, m->rank));
  PetscCall(read_coordinates(&b));
  PetscCall(number_owned(&b, m));
  PetscCall(local_faces(&b, scene));
  PetscCall(exchange_faces(&b, comm, m->rank, m->size, margin));
  PetscCall(keep_faces(&b, m->rank, margin));
  PetscCall(find_ghosts(&b, m->rank));
  PetscCall(fill_materials(scene, mesh, m));
  PetscCall(fill_vertices(&b, m));
  PetscCall(fill_elements(&b, m, 4, PETSC_FALSE, &m->q4));
  PetscCall(fill_elements(&b, m, 3, PETSC_FALSE, &m->t3));
  PetscCall(fill_elements(&b, m, 4, PETSC_TRUE, &m->rigid_q4));
  PetscCall(fill_elements(&b, m, 3, PETSC_TRUE, &m->rigid_t3));
  PetscCall(fill_faces(&b, m));
  PetscCall(fill_sets(&b, mesh, m));
  PetscCall(ghost_sf(&b, m));
  PetscCall(RigidBodiesCreate(m));
  PetscCall(fill_dofs(scene, m));
  PetscCall(DMDestroy(&b.dm));
  PetscCall(PetscFree(b.record));
  PetscCall(PetscFree(b.owner));
  PetscCall(PetscFree(b.index));
  PetscCall(PetscFree(b.x));
  PetscCall(PetscFree(b.face));
  PetscCall(PetscFree(b.ghost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode elements_destroy(Elements *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(e->gid));
  PetscCall(PetscFree2(e->vertex, e->group));
  PetscCall(PetscFree3(e->file, e->body, e->owned));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelDestroy(Model *m)
{
  Faces *f = &m->faces;
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(m->X, m->vertex_gid, m->vertex_file, m->vertex_body, m->vertex_rigid));
  PetscCall(PetscFree5(m->body_gid, m->body_start, m->body_X, m->body_mass, m->body_body));
  PetscCall(PetscFree4(m->mass, m->fixed, m->in_quotient, m->dof_body));
  PetscCall(elements_destroy(&m->q4));
  PetscCall(elements_destroy(&m->t3));
  PetscCall(elements_destroy(&m->rigid_q4));
  PetscCall(elements_destroy(&m->rigid_t3));
  PetscCall(PetscFree6(f->vertex, f->gid, f->group, f->body, f->rigid, f->joint));
  PetscCall(PetscFree5(m->group_names, m->group_rigid, m->lambda, m->mu, m->density));
  PetscCall(PetscFree2(m->face_set_names, m->point_names));
  PetscCall(PetscFree3(m->face_set_start, m->face_set_faces, m->point_vertex));
  PetscCall(PetscSFDestroy(&m->ghost));
  PetscCallMPI(MPI_Type_free(&m->pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

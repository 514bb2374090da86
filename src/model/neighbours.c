/* neighbours.c: finds the outer faces of other ranks near this rank's faces, and the vertices of these
   faces that it must read. Faces of other bodies within the contact margin are near. Called at set-up and
   at each search for contacts. */
#include "model/model.h"

/* ---- order */

PetscInt GhostsUnique(PetscInt n, GhostRecord *ghosts)
{
  PetscInt kept = 0;
  if (n) qsort(ghosts, n, sizeof(GhostRecord), OrderByFirst); // qsort and bsearch need an array even for none
  for (PetscInt i = 0; i < n; i++)
    if (!i || ghosts[i].gid != ghosts[kept - 1].gid) ghosts[kept++] = ghosts[i];
  return kept;
}

PetscInt LocalVertex(const Model *m, PetscInt gid, PetscMPIInt owner, PetscInt index)
{
  const GhostRecord wanted = {.gid = gid}, *all = m->ghosts.record, *found;
  const PetscInt ne = m->ghosts.n_element;
  if (owner == m->rank) return index;
  if (!m->ghosts.n) return -1; // there is no array to search
  found = bsearch(&wanted, all, ne, sizeof(GhostRecord), OrderByFirst);
  if (!found) found = bsearch(&wanted, all + ne, m->ghosts.n - ne, sizeof(GhostRecord), OrderByFirst);
  return found ? m->mesh.n_owned + (PetscInt)(found - all) : -1;
}

/* ---- faces */

static PetscBool touches_owned(const Model *m, PetscInt f)
{
  const PetscInt *v = m->faces.vertex + 2 * f;
  return (PetscBool)(v[0] < m->mesh.n_owned || v[1] < m->mesh.n_owned);
}

/* A raster shows where the faces of a rank are: the plane has RASTER x RASTER cells, and a bit says whether a
   cell contains a face. */
enum { RASTER = 64 };
typedef struct {
  PetscReal origin[2], per_cell[2];
} RasterFrame;

static void raster_range(const RasterFrame *frame, const PetscReal box[4], int range[4])
{
  for (int i = 0; i < 4; i++) {
    const PetscReal cell = (box[i] - frame->origin[i % 2]) * frame->per_cell[i % 2];
    range[i] = (int)PetscMax(0., PetscMin(RASTER - 1., cell));
  }
}

/* Returns the bits of the columns of a range. */
static uint64_t raster_columns(const int range[4])
{
  return (~(uint64_t)0 >> (RASTER - 1 - range[2])) & (~(uint64_t)0 << range[0]);
}

static PetscBool raster_meets(const uint64_t *raster, const int range[4])
{
  uint64_t found = 0;
  for (int row = range[1]; row <= range[3]; row++) found |= raster[row] & raster_columns(range);
  return (PetscBool)(found != 0);
}

static void present_box(const Model *m, const PetscReal *u, PetscInt f, PetscReal box[4])
{
  PetscReal x[4];
  FaceCoordinates(m, u, f, x);
  FaceBox(x, x + 2, m->contact_margin + m->contact_depth, box);
}

/* Gathers the raster of each rank, over one frame, of the faces at its owned vertices. all: (size,
   RASTER). */
static PetscErrorCode share_rasters(const Model *m, const PetscReal *u, RasterFrame *frame, uint64_t **all)
{
  PetscReal box[4], hull[4] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL};
  uint64_t mine[RASTER] = {0};
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < m->faces.n_local; f++) {
    present_box(m, u, f, box);
    for (int i = 0; i < 4; i++) hull[i] = PetscMin(hull[i], i < 2 ? box[i] : -box[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, hull, 4, MPIU_REAL, MPI_MIN, m->comm));
  for (int i = 0; i < 2; i++) {
    const PetscReal extent = -hull[2 + i] - hull[i];
    frame->origin[i] = hull[i], frame->per_cell[i] = extent > 0. ? RASTER / extent : 0.;
  }
  for (PetscInt f = 0; f < m->faces.n_local; f++) {
    int range[4];
    if (!touches_owned(m, f)) continue;
    present_box(m, u, f, box);
    raster_range(frame, box, range);
    for (int row = range[1]; row <= range[3]; row++) mine[row] |= raster_columns(range);
  }
  PetscCall(PetscMalloc1(RASTER * m->size, all));
  PetscCallMPI(MPI_Allgather(mine, RASTER, MPI_UINT64_T, *all, RASTER, MPI_UINT64_T, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the record of a local face. */
static FaceRecord record_of(const Model *m, const PetscReal *u, PetscInt f)
{
  const Faces *faces = &m->faces;
  FaceRecord r = {.gid = faces->gid[f],
                  .group = faces->group[f],
                  .body = faces->body[f],
                  .rigid = faces->rigid[f],
                  .joint = faces->joint[f],
                  .thick = faces->thick[f]};
  for (int k = 0; k < 2; k++) {
    const PetscInt v = faces->vertex[2 * f + k];
    const GhostRecord *ghost = v < m->mesh.n_owned ? NULL : m->ghosts.record + (v - m->mesh.n_owned);
    r.v_gid[k] = m->mesh.vertex_gid[v], r.v_file[k] = m->mesh.vertex_file[v];
    r.v_owner[k] = ghost ? ghost->owner : m->rank, r.v_index[k] = ghost ? ghost->index : v;
    for (int i = 0; i < 2; i++) r.X[2 * k + i] = m->mesh.X[2 * v + i];
  }
  FaceCoordinates(m, u, f, r.x);
  return r;
}

/* Sends each face, from the rank that owns its first vertex, to every rank that has faces in the same cells
   of the raster. near: (n_local,) whether another rank has faces in the
   cells of this face. */
static PetscErrorCode exchange_faces(const Model *m, const PetscReal *u, PetscBool *near, PetscInt *n,
                                     FaceRecord **received)
{
  const PetscMPIInt unit = (PetscMPIInt)sizeof(FaceRecord);
  RasterFrame frame = {{0., 0.}, {0., 0.}};
  uint64_t *raster;
  PetscMPIInt *n_send, *n_receive, *at_send, *at_receive;
  FaceRecord *send = NULL;
  PetscFunctionBeginUser;
  PetscCall(share_rasters(m, u, &frame, &raster));
  PetscCall(
      PetscCalloc4(m->size, &n_send, m->size, &n_receive, m->size + 1, &at_send, m->size + 1, &at_receive));
  for (int pass = 0; pass < 2; pass++) { // counts, then fills
    for (PetscInt f = 0; f < m->faces.n_local; f++) {
      PetscReal box[4];
      int range[4];
      present_box(m, u, f, box);
      raster_range(&frame, box, range);
      near[f] = PETSC_FALSE;
      for (PetscMPIInt p = 0; p < m->size; p++) {
        if (p == m->rank || !raster_meets(raster + RASTER * p, range)) continue;
        near[f] = PETSC_TRUE;
        if (m->faces.vertex[2 * f] >= m->mesh.n_owned) continue;
        if (pass) send[at_send[p] / unit + n_send[p] / unit] = record_of(m, u, f);
        n_send[p] += unit;
      }
    }
    if (pass) break;
    for (PetscMPIInt p = 0; p < m->size; p++) at_send[p + 1] = at_send[p] + n_send[p], n_send[p] = 0;
    PetscCall(PetscMalloc1(at_send[m->size] / unit, &send));
  }
  PetscCallMPI(MPI_Alltoall(n_send, 1, MPI_INT, n_receive, 1, MPI_INT, m->comm));
  for (PetscMPIInt p = 0; p < m->size; p++) at_receive[p + 1] = at_receive[p] + n_receive[p];
  *n = at_receive[m->size] / unit;
  PetscCall(PetscMalloc1(*n, received));
  PetscCallMPI(
      MPI_Alltoallv(send, n_send, at_send, MPI_BYTE, *received, n_receive, at_receive, MPI_BYTE, m->comm));
  PetscCall(PetscFree(send));
  PetscCall(PetscFree(raster));
  PetscCall(PetscFree4(n_send, n_receive, at_send, at_receive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether f is a received face and g a face of this rank; the received faces come first. */
static PetscBool received_and_ours(PetscInt f, PetscInt g, const void *context)
{
  const PetscInt n_received = *(const PetscInt *)context;
  return (PetscBool)(f < n_received && g >= n_received);
}

/* Keeps the received faces near a face at an owned vertex, and drops faces that this rank already has. */
static PetscErrorCode keep_faces(const Model *m, const PetscReal *u, const PetscBool *near_others,
                                 PetscInt *n, FaceRecord *face)
{
  PetscInt n_boxes = *n, *start, *near, kept = 0, at;
  PetscReal *box;
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < m->faces.n_local; f++) n_boxes += near_others[f] && touches_owned(m, f);
  PetscCall(PetscMalloc1(4 * n_boxes, &box));
  for (at = 0; at < *n; at++)
    FaceBox(face[at].x, face[at].x + 2, m->contact_margin + m->contact_depth, box + 4 * at);
  for (PetscInt f = 0; f < m->faces.n_local; f++)
    if (near_others[f] && touches_owned(m, f)) present_box(m, u, f, box + 4 * at++);
  PetscCall(GridRows(n_boxes, box, received_and_ours, n, &start, &near));
  for (PetscInt f = 0; f < *n; f++) {
    PetscInt row;
    if (start[f] == start[f + 1]) continue;
    PetscCall(PetscFindInt(face[f].gid, m->faces.n_local, m->faces.gid, &row));
    if (row < 0) face[kept++] = face[f];
  }
  *n = kept;
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscCall(PetscFree(box));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Remembers, at set-up, the far faces of groups that are not upgradeable, because their contacts always
   stay. */
static PetscErrorCode remember_faces(Model *m, PetscInt n, const FaceRecord *face)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &m->faces.remembered));
  for (PetscInt f = 0; f < n; f++)
    if (!m->materials.upgradeable[face[f].group]) m->faces.remembered[m->faces.n_remembered++] = face[f];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the faces of other ranks that this rank needs, in ascending gid: faces near its own, and remembered
   ones. */
static PetscErrorCode far_faces(Model *m, const PetscReal *u, PetscInt *n, FaceRecord **far)
{
  PetscBool *near;
  PetscInt n_received, kept = 0;
  FaceRecord *face;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->faces.n_local, &near));
  PetscCall(exchange_faces(m, u, near, &n_received, &face));
  PetscCall(keep_faces(m, u, near, &n_received, face));
  PetscCall(PetscFree(near));
  if (!u) PetscCall(remember_faces(m, n_received, face));
  PetscCall(PetscRealloc((n_received + m->faces.n_remembered) * sizeof(FaceRecord), &face));
  PetscCall(PetscArraycpy(face + n_received, m->faces.remembered, m->faces.n_remembered));
  *n = n_received + m->faces.n_remembered;
  if (*n) qsort(face, *n, sizeof(FaceRecord), OrderByFirst);
  for (PetscInt f = 0; f < *n; f++)
    if (!f || face[f].gid != face[kept - 1].gid) face[kept++] = face[f];
  *n = kept;
  *far = face;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ghosts */

/* Finds the ghosts of contacts: vertices of far faces that this rank does not own and no element here uses.
   They come after the ghosts of elements. */
static PetscErrorCode contact_ghosts(Model *m, PetscInt n, const FaceRecord *face, PetscBool *changed)
{
  Ghosts *ghosts = &m->ghosts;
  const PetscInt n_before = ghosts->n;
  const PetscInt ne = ghosts->n_element;
  PetscInt more = 0;
  GhostRecord *all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ne + 2 * n, &all));
  PetscCall(PetscArraycpy(all, ghosts->record, ne));
  for (PetscInt f = 0; f < n; f++)
    for (int k = 0; k < 2; k++) {
      const GhostRecord g = {face[f].v_gid[k],
                             face[f].v_file[k],
                             face[f].body,
                             face[f].rigid,
                             face[f].v_owner[k],
                             face[f].v_index[k],
                             {face[f].X[2 * k], face[f].X[2 * k + 1]}};
      if (g.owner == m->rank || (ne && bsearch(&g, all, ne, sizeof(GhostRecord), OrderByFirst))) continue;
      all[ne + more++] = g;
    }
  ghosts->n = ne + GhostsUnique(more, all + ne);
  *changed = (PetscBool)(ghosts->n != n_before || !ghosts->exchange);
  for (PetscInt g = ne; g < ghosts->n && !*changed; g++)
    *changed = (PetscBool)(all[g].gid != ghosts->record[g].gid);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, changed, 1, MPI_PETSC_BOOL, MPI_LOR, m->comm));
  PetscCall(PetscFree(ghosts->record));
  ghosts->record = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points the padding lanes of a list of elements to the dummy vertices, which may have moved. */
static void point_padding(const Model *m, Elements *e)
{
  for (PetscInt i = e->n; i < e->n_padded; i++)
    for (int k = 0; k < e->n_nodes; k++) e->vertex[VertexPlace(e, i, k)] = m->mesh.n_vertices + k;
}

static PetscErrorCode append_ghosts(Model *m)
{
  LocalMesh *mesh = &m->mesh;
  static const PetscReal square[8] = {0., 0., 1., 0., 1., 1., 0., 1.};
  PetscFunctionBeginUser;
  PetscCall(VerticesResize(m));
  for (PetscInt g = 0, i = mesh->n_owned; g < m->ghosts.n; g++, i++) {
    const GhostRecord *ghost = m->ghosts.record + g;
    PetscCall(PetscArraycpy(mesh->X + 2 * i, ghost->X, 2));
    mesh->vertex_gid[i] = ghost->gid, mesh->vertex_file[i] = ghost->file;
    mesh->vertex_body[i] = ghost->body, mesh->vertex_rigid[i] = ghost->rigid;
  }
  PetscCall(PetscArraycpy(mesh->X + 2 * mesh->n_vertices, square, 8));
  for (int l = 0; l < ELEMENT_LISTS; l++) point_padding(m, mesh->elements + l);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode free_faces(Faces *f)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree7(f->vertex, f->gid, f->group, f->body, f->rigid, f->joint, f->thick));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for n rows; the first n_local keep their values. */
static PetscErrorCode resize_faces(Model *m, PetscInt n)
{
  Faces f = m->faces, *old = &m->faces;
  PetscFunctionBeginUser;
  if (n <= old->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  f.capacity = old->capacity ? n + n / 16 : n;
  PetscCall(PetscMalloc7(2 * f.capacity, &f.vertex, f.capacity, &f.gid, f.capacity, &f.group, f.capacity,
                         &f.body, f.capacity, &f.rigid, f.capacity, &f.joint, f.capacity, &f.thick));
  const PetscInt stay = old->capacity ? old->n_local : 0;
  PetscCall(PetscArraycpy(f.vertex, old->vertex, 2 * stay));
  PetscCall(PetscArraycpy(f.gid, old->gid, stay));
  PetscCall(PetscArraycpy(f.group, old->group, stay));
  PetscCall(PetscArraycpy(f.body, old->body, stay));
  PetscCall(PetscArraycpy(f.rigid, old->rigid, stay));
  PetscCall(PetscArraycpy(f.joint, old->joint, stay));
  PetscCall(PetscArraycpy(f.thick, old->thick, stay));
  PetscCall(free_faces(old));
  *old = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the last n rows, from row `at` on. */
static PetscErrorCode fill_faces(Model *m, PetscInt at, PetscInt n, const FaceRecord *face)
{
  PetscFunctionBeginUser;
  PetscCall(resize_faces(m, at + n));
  Faces *f = &m->faces;
  f->n = at + n;
  for (PetscInt i = at; i < f->n; i++) {
    const FaceRecord *r = face + (i - at);
    for (int k = 0; k < 2; k++)
      f->vertex[2 * i + k] = LocalVertex(m, r->v_gid[k], (PetscMPIInt)r->v_owner[k], r->v_index[k]);
    f->gid[i] = r->gid, f->group[i] = r->group, f->body[i] = r->body, f->rigid[i] = r->rigid,
    f->joint[i] = r->joint, f->thick[i] = r->thick;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FacesCreate(Model *m, PetscInt n, const FaceRecord *face)
{
  PetscFunctionBeginUser;
  m->faces.n_local = n;
  PetscCall(fill_faces(m, 0, n, face));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FacesDestroy(Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(free_faces(&m->faces));
  PetscCall(PetscFree(m->faces.remembered));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NeighboursUpdate(Model *m, State *state)
{
  FaceRecord *far = NULL;
  PetscInt n = 0;
  PetscBool changed;
  PetscFunctionBeginUser;
  if (!state) PetscCall(append_ghosts(m)); // set-up: ghosts of elements
  if (m->size > 1) PetscCall(far_faces(m, state ? state->u + 3 * m->rigid.n : NULL, &n, &far));
  PetscCall(contact_ghosts(m, n, far, &changed));
  PetscCall(append_ghosts(m));
  PetscCall(fill_faces(m, m->faces.n_local, n, far));
  if (changed) PetscCall(GhostConnect(m)); // the exchange stands as long as no rank reads other vertices
  PetscCall(PetscFree(far));
  if (state) {
    PetscCall(StateResize(m, state));
    // a dummy may stand where a ghost was, so dummies are cleared
    PetscCall(PetscArrayzero(state->u + 3 * m->rigid.n + 2 * m->mesh.n_vertices, 2 * DUMMY_VERTICES));
    PetscCall(GhostBegin(m, state->u + 3 * m->rigid.n));
    PetscCall(GhostEnd(m, state->u + 3 * m->rigid.n));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- room for vertices */

PetscErrorCode VerticesResize(Model *m)
{
  LocalMesh *mesh = &m->mesh;
  const PetscInt old = mesh->vertex_capacity, need = mesh->n_owned + m->ghosts.n + DUMMY_VERTICES;
  PetscFunctionBeginUser;
  mesh->n_vertices = mesh->n_owned + m->ghosts.n;
  if (need <= old) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscInt new = old ? need + need / 4 : need; // leaves room to grow when blocks move
  PetscCall(ArrayGrow(2 * sizeof(PetscReal), old, new, &mesh->X));
  PetscCall(ArrayGrow(sizeof(PetscInt), old, new, &mesh->vertex_gid));
  PetscCall(ArrayGrow(sizeof(PetscInt), old, new, &mesh->vertex_file));
  PetscCall(ArrayGrow(sizeof(PetscInt), old, new, &mesh->vertex_body));
  PetscCall(ArrayGrow(sizeof(PetscInt), old, new, &mesh->vertex_rigid));
  mesh->vertex_capacity = new;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VerticesFree(Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(m->mesh.X));
  PetscCall(PetscFree(m->mesh.vertex_gid));
  PetscCall(PetscFree(m->mesh.vertex_file));
  PetscCall(PetscFree(m->mesh.vertex_body));
  PetscCall(PetscFree(m->mesh.vertex_rigid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt FaceRow(const Model *m, PetscInt gid)
{
  const PetscInt n = m->faces.n_local;
  PetscInt near, far;
  PetscCallAbort(PETSC_COMM_SELF, PetscFindInt(gid, n, m->faces.gid, &near));
  if (near >= 0) return near;
  PetscCallAbort(PETSC_COMM_SELF, PetscFindInt(gid, m->faces.n - n, m->faces.gid + n, &far));
  return far < 0 ? -1 : n + far;
}

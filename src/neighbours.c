/* neighbours.c: which outer faces of other ranks are near ours, which of their vertices we must read, and the
   exchange that brings them. Called at set-up and whenever contacts are looked for again; faces of other
   bodies within the contact margin are neighbours. */
#include "internal.h"

/* ---- order */

static int face_order(const void *a, const void *b)
{
  const FaceRecord *f = a, *g = b;
  return (f->gid > g->gid) - (f->gid < g->gid);
}

static int ghost_order(const void *a, const void *b)
{
  const GhostRecord *f = a, *g = b;
  return (f->gid > g->gid) - (f->gid < g->gid);
}

PetscInt GhostsUnique(PetscInt n, GhostRecord *ghosts)
{
  PetscInt kept = 0;
  if (n) qsort(ghosts, n, sizeof(GhostRecord), ghost_order); // qsort and bsearch want an array even for none
  for (PetscInt i = 0; i < n; i++)
    if (!i || ghosts[i].gid != ghosts[kept - 1].gid) ghosts[kept++] = ghosts[i];
  return kept;
}

PetscInt LocalVertex(const Model *m, PetscInt gid, PetscMPIInt owner, PetscInt index)
{
  const GhostRecord wanted = {.gid = gid}, *all = m->ghosts, *found;
  const PetscInt ne = m->n_element_ghosts;
  if (owner == m->rank) return index;
  found = bsearch(&wanted, all, ne, sizeof(GhostRecord), ghost_order);
  if (!found) found = bsearch(&wanted, all + ne, m->n_ghosts - ne, sizeof(GhostRecord), ghost_order);
  return m->n_owned + (PetscInt)(found - all);
}

/* ---- faces */

static PetscBool touches_owned(const FaceRecord *f, PetscMPIInt rank)
{
  return (PetscBool)(f->v_owner[0] == rank || f->v_owner[1] == rank);
}

/* Present coordinates of the faces we hold. */
static void move_faces(const Model *m, const State *state, FaceRecord *face)
{
  const PetscReal *u = state ? state->u + 3 * m->n_bodies : NULL;
  for (PetscInt f = 0; f < m->n_faces_local; f++)
    for (int k = 0; k < 2; k++) {
      const PetscInt v = u ? LocalVertex(m, face[f].v_gid[k], (PetscMPIInt)face[f].v_owner[k],
                                         face[f].v_index[k])
                           : 0;
      for (int i = 0; i < 2; i++) face[f].x[2 * k + i] = face[f].X[2 * k + i] + (u ? u[2 * v + i] : 0.);
    }
}

static PetscBool boxes_meet(const PetscReal a[4], const PetscReal b[4])
{
  return (PetscBool)(a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]);
}

/* Sends each face, from the rank that owns its first vertex, to every rank whose box (of faces at its owned
   vertices) it meets. received: (n_local + n_received,) ours first. */
static PetscErrorCode exchange_faces(const Model *m, PetscInt *n, FaceRecord **faces)
{
  PetscReal mine[4] = {PETSC_INFINITY, PETSC_INFINITY, PETSC_NINFINITY, PETSC_NINFINITY}, *boxes, box[4];
  PetscMPIInt *n_send, *n_receive, *at_send, *at_receive;
  FaceRecord *send = NULL, *received;
  PetscInt total = 0;
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < m->n_faces_local; f++) {
    if (!touches_owned(m->face_local + f, m->rank)) continue;
    FaceBox(m->face_local[f].x, m->face_local[f].x + 2, m->contact_margin, box);
    for (int i = 0; i < 2; i++)
      mine[i] = PetscMin(mine[i], box[i]), mine[i + 2] = PetscMax(mine[i + 2], box[i + 2]);
  }
  PetscCall(PetscMalloc1(4 * m->size, &boxes));
  PetscCallMPI(MPI_Allgather(mine, 4, MPIU_REAL, boxes, 4, MPIU_REAL, m->comm));
  PetscCall(
      PetscCalloc4(m->size, &n_send, m->size, &n_receive, m->size + 1, &at_send, m->size + 1, &at_receive));
  for (int pass = 0; pass < 2; pass++) { // count, then fill
    if (pass) PetscCall(PetscMalloc1(total, &send));
    total = 0;
    for (PetscMPIInt p = 0; p < m->size; p++) {
      at_send[p] = (PetscMPIInt)(total * (PetscInt)sizeof(FaceRecord));
      for (PetscInt f = 0; p != m->rank && f < m->n_faces_local; f++) {
        if (m->face_local[f].v_owner[0] != m->rank) continue;
        FaceBox(m->face_local[f].x, m->face_local[f].x + 2, m->contact_margin, box);
        if (!boxes_meet(box, boxes + 4 * p)) continue;
        if (pass) send[total] = m->face_local[f], send[total].local = 0;
        total++;
      }
      n_send[p] = (PetscMPIInt)(total * (PetscInt)sizeof(FaceRecord)) - at_send[p];
    }
  }
  PetscCallMPI(MPI_Alltoall(n_send, 1, MPI_INT, n_receive, 1, MPI_INT, m->comm));
  for (PetscMPIInt p = 0; p < m->size; p++) at_receive[p + 1] = at_receive[p] + n_receive[p];
  *n = m->n_faces_local + at_receive[m->size] / (PetscInt)sizeof(FaceRecord);
  PetscCall(PetscMalloc1(*n, &received));
  PetscCall(PetscArraycpy(received, m->face_local, m->n_faces_local));
  PetscCallMPI(MPI_Alltoallv(send, n_send, at_send, MPI_BYTE, received + m->n_faces_local, n_receive,
                             at_receive, MPI_BYTE, m->comm));
  PetscCall(PetscFree(send));
  PetscCall(PetscFree(boxes));
  PetscCall(PetscFree4(n_send, n_receive, at_send, at_receive));
  *faces = received;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the received faces keeps those near one of ours at an owned vertex, or near which lies an owned vertex;
   each once and none that is ours anyway; by ascending gid behind ours. */
static PetscErrorCode keep_faces(const Model *m, PetscInt *n, FaceRecord *face)
{
  const PetscInt n_local = m->n_faces_local;
  PetscInt n_pairs, *pairs, kept = n_local;
  PetscReal *box;
  PetscBool *keep;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(4 * *n, &box, *n, &keep));
  for (PetscInt f = 0; f < *n; f++) {
    FaceBox(face[f].x, face[f].x + 2, m->contact_margin, box + 4 * f);
    keep[f] = PETSC_FALSE;
  }
  PetscCall(GridPairs(*n, box, &n_pairs, &pairs));
  for (PetscInt p = 0; p < n_pairs; p++) {
    const PetscInt f = pairs[2 * p], g = pairs[2 * p + 1];
    if (touches_owned(face + f, m->rank) || touches_owned(face + g, m->rank)) keep[f] = keep[g] = PETSC_TRUE;
  }
  for (PetscInt f = n_local; f < *n; f++)
    if (keep[f] && !(n_local && bsearch(face + f, face, n_local, sizeof(FaceRecord), face_order)))
      face[kept++] = face[f];
  if (kept > n_local) qsort(face + n_local, kept - n_local, sizeof(FaceRecord), face_order);
  *n = kept;
  PetscCall(PetscFree(pairs));
  PetscCall(PetscFree2(box, keep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ghosts */

/* Vertices of the kept faces that neither this rank owns nor an element here uses, behind the ghosts of
 * elements. */
static PetscErrorCode contact_ghosts(Model *m, PetscInt n, const FaceRecord *face, PetscBool *changed)
{
  const PetscInt n_before = m->n_ghosts;
  const PetscInt ne = m->n_element_ghosts;
  PetscInt more = 0;
  GhostRecord *all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(ne + 2 * (n - m->n_faces_local), &all));
  PetscCall(PetscArraycpy(all, m->ghosts, ne));
  for (PetscInt f = m->n_faces_local; f < n; f++)
    for (int k = 0; k < 2; k++) {
      const GhostRecord g = {face[f].v_gid[k],
                             face[f].v_file[k],
                             face[f].body,
                             face[f].rigid,
                             face[f].v_owner[k],
                             face[f].v_index[k],
                             {face[f].X[2 * k], face[f].X[2 * k + 1]}};
      if (g.owner == m->rank || (ne && bsearch(&g, all, ne, sizeof(GhostRecord), ghost_order))) continue;
      all[ne + more++] = g;
    }
  m->n_ghosts = ne + GhostsUnique(more, all + ne);
  *changed = (PetscBool)(m->n_ghosts != n_before || !m->ghost);
  for (PetscInt g = ne; g < m->n_ghosts && !*changed; g++)
    *changed = (PetscBool)(all[g].gid != m->ghosts[g].gid);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, changed, 1, MPIU_BOOL, MPI_LOR, m->comm));
  PetscCall(PetscFree(m->ghosts));
  m->ghosts = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Padding lanes of a list of elements point to the dummy vertices, wherever these stand now. */
static void point_padding(const Model *m, int n_nodes, Elements *e)
{
  for (PetscInt i = e->n; i < e->n_padded; i++)
    for (int k = 0; k < n_nodes; k++)
      e->vertex[((i / BATCH) * n_nodes + k) * BATCH + i % BATCH] = m->n_vertices + k;
}

static PetscErrorCode append_ghosts(Model *m)
{
  static const PetscReal square[8] = {0., 0., 1., 0., 1., 1., 0., 1.};
  PetscFunctionBeginUser;
  PetscCall(VerticesResize(m));
  for (PetscInt g = 0, i = m->n_owned; g < m->n_ghosts; g++, i++) {
    const GhostRecord *ghost = m->ghosts + g;
    PetscCall(PetscArraycpy(m->X + 2 * i, ghost->X, 2));
    m->vertex_gid[i] = ghost->gid, m->vertex_file[i] = ghost->file;
    m->vertex_body[i] = ghost->body, m->vertex_rigid[i] = ghost->rigid;
  }
  PetscCall(PetscArraycpy(m->X + 2 * m->n_vertices, square, 8));
  point_padding(m, 4, &m->q4);
  point_padding(m, 3, &m->t3);
  point_padding(m, 4, &m->rigid_q4);
  point_padding(m, 3, &m->rigid_t3);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode fill_faces(Model *m, PetscInt n, const FaceRecord *face)
{
  Faces *f = &m->faces;
  PetscFunctionBeginUser;
  PetscCall(PetscFree7(f->vertex, f->gid, f->group, f->body, f->rigid, f->joint, f->thick));
  f->n = n;
  PetscCall(PetscMalloc7(2 * n, &f->vertex, n, &f->gid, n, &f->group, n, &f->body, n, &f->rigid, n, &f->joint,
                         n, &f->thick));
  for (PetscInt i = 0; i < n; i++) {
    const FaceRecord *r = face + i;
    for (int k = 0; k < 2; k++)
      f->vertex[2 * i + k] = LocalVertex(m, r->v_gid[k], (PetscMPIInt)r->v_owner[k], r->v_index[k]);
    f->gid[i] = r->gid, f->group[i] = r->group, f->body[i] = r->body, f->rigid[i] = r->rigid,
    f->joint[i] = r->joint, f->thick[i] = r->thick;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Leaves: ghost vertices; roots: owned vertices of their owners. */
static PetscErrorCode connect(Model *m)
{
  PetscInt *leaves;
  PetscSFNode *roots;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_ghosts, &leaves));
  PetscCall(PetscMalloc1(m->n_ghosts, &roots));
  for (PetscInt g = 0; g < m->n_ghosts; g++) {
    leaves[g] = m->n_owned + g;
    roots[g].rank = m->ghosts[g].owner;
    roots[g].index = m->ghosts[g].index;
  }
  if (m->ghost) {
    PetscCall(PetscSFReset(m->ghost));
  } else {
    PetscCall(PetscSFCreate(m->comm, &m->ghost));
    PetscCallMPI(MPI_Type_contiguous(2, MPIU_REAL, &m->pair));
    PetscCallMPI(MPI_Type_commit(&m->pair));
  }
  PetscCall(PetscSFSetGraph(m->ghost, m->n_owned, m->n_ghosts, leaves, PETSC_OWN_POINTER, roots,
                            PETSC_OWN_POINTER));
  PetscCall(PetscSFSetUp(m->ghost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode NeighboursUpdate(Model *m, State *state)
{
  FaceRecord *face;
  PetscInt n;
  PetscBool changed;
  PetscFunctionBeginUser;
  move_faces(m, state, m->face_local);
  PetscCall(exchange_faces(m, &n, &face));
  PetscCall(keep_faces(m, &n, face));
  PetscCall(contact_ghosts(m, n, face, &changed));
  PetscCall(append_ghosts(m));
  PetscCall(fill_faces(m, n, face));
  if (changed) PetscCall(connect(m)); // the exchange stands as long as no rank reads other vertices
  PetscCall(PetscFree(face));
  if (state) {
    PetscCall(StateResize(m, state));
    // the dummies may stand where a ghost was
    PetscCall(PetscArrayzero(state->u + 3 * m->n_bodies + 2 * m->n_vertices, 2 * DUMMY_VERTICES));
    PetscCall(GhostBegin(m, state->u + 3 * m->n_bodies));
    PetscCall(GhostEnd(m, state->u + 3 * m->n_bodies));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- room for vertices */

static PetscErrorCode grow(size_t size, PetscInt old, PetscInt new, void *array)
{
  void **a = array, *grown;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(size * new, (char **)&grown));
  if (*a) PetscCall(PetscMemcpy(grown, *a, size * old));
  PetscCall(PetscFree(*a));
  *a = grown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VerticesResize(Model *m)
{
  const PetscInt old = m->vertex_capacity, need = m->n_owned + m->n_ghosts + DUMMY_VERTICES;
  PetscFunctionBeginUser;
  m->n_vertices = m->n_owned + m->n_ghosts;
  if (need <= old) PetscFunctionReturn(PETSC_SUCCESS);
  const PetscInt new = old ? need + need / 4 : need; // room to grow when blocks move
  PetscCall(grow(2 * sizeof(PetscReal), old, new, &m->X));
  PetscCall(grow(sizeof(PetscInt), old, new, &m->vertex_gid));
  PetscCall(grow(sizeof(PetscInt), old, new, &m->vertex_file));
  PetscCall(grow(sizeof(PetscInt), old, new, &m->vertex_body));
  PetscCall(grow(sizeof(PetscInt), old, new, &m->vertex_rigid));
  m->vertex_capacity = new;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode VerticesFree(Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(m->X));
  PetscCall(PetscFree(m->vertex_gid));
  PetscCall(PetscFree(m->vertex_file));
  PetscCall(PetscFree(m->vertex_body));
  PetscCall(PetscFree(m->vertex_rigid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateResize(const Model *m, State *s)
{
  const PetscInt old = s->capacity, new = 3 * m->n_bodies + 2 * m->vertex_capacity;
  PetscFunctionBeginUser;
  if (new <= old) PetscFunctionReturn(PETSC_SUCCESS);
  PetscReal **array[6] = {&s->u, &s->f, &s->f_old, &s->f_ext, &s->f_start, &s->f_target};
  for (int i = 0; i < 6; i++) PetscCall(grow(sizeof(PetscReal), old, new, array[i]));
  s->capacity = new;
  // this rank's arrays may grow when another's do not: nothing collective here
  if (s->u_vec) {
    PetscCall(VecResetArray(s->u_vec));
    PetscCall(VecPlaceArray(s->u_vec, s->u));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* model.c: turns the Plex of a rank into the flat arrays of model.h. Owned vertices get their numbers first,
   then the other vertices and the outer faces of blocks; then the arrays are filled. neighbours.c adds the
   faces and vertices of other ranks that contacts need. */
#include "model/model.h"
#include <petscdmplex.h>

typedef struct {
  DealtMesh d;
  PetscInt *index; /* (points,) index of a vertex on its owner; -1 for a block */
} Builder;

/* ---- owned vertices */

typedef struct {
  PetscInt inner, body, gid, point; /* condensed body of an inner vertex, else -1; rigid body, else -1 */
} OwnedVertex;

static int owned_order(const void *a, const void *b)
{
  const OwnedVertex *f = a, *g = b;
  if (f->inner != g->inner) return (f->inner > g->inner) - (f->inner < g->inner);
  if (f->body != g->body) return (f->body > g->body) - (f->body < g->body);
  return (f->gid > g->gid) - (f->gid < g->gid);
}

/* Gives every rank the index of each vertex on its owner, through rank 0. */
static PetscErrorCode share_index(Builder *b)
{
  PetscInt n, *whole;
  PetscFunctionBeginUser;
  PetscCall(PetscSFGetGraph(b->d.migration, &n, NULL, NULL, NULL));
  PetscCall(PetscMalloc1(n, &whole));
  for (PetscInt p = 0; p < n; p++) whole[p] = -1;
  PetscCall(PetscSFReduceBegin(b->d.migration, MPIU_INT, b->index, whole, MPI_MAX));
  PetscCall(PetscSFReduceEnd(b->d.migration, MPIU_INT, b->index, whole, MPI_MAX));
  PetscCall(PetscSFBcastBegin(b->d.migration, MPIU_INT, whole, b->index, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(b->d.migration, MPIU_INT, whole, b->index, MPI_REPLACE));
  PetscCall(PetscFree(whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the owned vertices: deformable ones by gid, then rigid ones by body and gid, then inner ones of
   condensed bodies by body and gid. */
static PetscErrorCode number_owned(Builder *b, Model *m)
{
  LocalMesh *mesh = &m->mesh;
  OwnedVertex *owned;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->d.n_points - b->d.n_blocks, &owned));
  PetscCall(PetscMalloc1(b->d.n_points, &b->index));
  mesh->n_owned = mesh->n_deformable = mesh->n_moving = 0;
  for (PetscInt p = 0; p < b->d.n_points; p++) b->index[p] = -1;
  for (PetscInt v = b->d.n_blocks; v < b->d.n_points; v++) {
    const PointRecord *r = b->d.record + v;
    if (r->owner != m->rank) continue;
    owned[mesh->n_owned++] = (OwnedVertex){r->inner ? r->condensed : -1, r->rigid, r->gid, v};
    mesh->n_moving += !r->inner;
    mesh->n_deformable += !r->inner && r->rigid < 0;
  }
  if (mesh->n_owned) qsort(owned, mesh->n_owned, sizeof(OwnedVertex), owned_order);
  for (PetscInt i = 0; i < mesh->n_owned; i++) b->index[owned[i].point] = i;
  PetscCall(PetscFree(owned));
  if (b->d.migration) PetscCall(share_index(b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- faces */

/* Finds the vertices of a block in ring order, as Plex points; n: 3 or 4. */
static PetscErrorCode block_vertices(const Builder *b, PetscInt block, const PetscInt **vertices, PetscInt *n)
{
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetConeSize(b->d.dm, block, n));
  PetscCall(DMPlexGetCone(b->d.dm, block, vertices));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the record of face k of a block with n vertices v. */
static FaceRecord face_of(const Builder *b, PetscInt block, const PetscInt *v, PetscInt n, PetscInt k)
{
  const PointRecord *r = b->d.record + block;
  FaceRecord f = {.gid = 4 * r->gid + k, .group = r->group, .body = r->body, .rigid = r->rigid, .joint = -1};
  for (int i = 0; i < 2; i++) {
    const PetscInt end = v[(k + i) % n];
    const PointRecord *vertex = b->d.record + end;
    f.v_gid[i] = vertex->gid, f.v_file[i] = vertex->file;
    f.v_owner[i] = vertex->owner, f.v_index[i] = b->index[end];
    f.X[2 * i] = vertex->X[0], f.X[2 * i + 1] = vertex->X[1];
  }
  for (PetscInt i = 0; i < n; i++) { // finds how far the block reaches behind the face
    const PetscReal *P = b->d.record[v[i]].X, ex = f.X[2] - f.X[0], ey = f.X[3] - f.X[1];
    f.thick = PetscMax(f.thick, ((P[1] - f.X[1]) * ex - (P[0] - f.X[0]) * ey) / PetscHypotReal(ex, ey));
  }
  return f;
}

/* Makes the outer faces of local blocks, in ascending gid; fill_joints sets their joints. */
static PetscErrorCode local_faces(const Builder *b, Model *m)
{
  FaceRecord *face;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < b->d.n_blocks; c++)
    for (PetscInt k = 0; k < 4; k++) n += b->d.record[c].outer >> k & 1;
  PetscCall(PetscMalloc1(n, &face));
  n = 0;
  for (PetscInt c = 0; c < b->d.n_blocks; c++) {
    const PetscInt *v;
    PetscInt n_vertices;
    PetscCall(block_vertices(b, c, &v, &n_vertices));
    for (PetscInt k = 0; k < n_vertices; k++)
      if (b->d.record[c].outer >> k & 1) face[n++] = face_of(b, c, v, n_vertices, k);
  }
  PetscCall(FacesCreate(m, n, face));
  PetscCall(PetscFree(face));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ghosts */

/* Finds the ghosts of elements, by ascending gid: vertices of this rank's blocks that other ranks own. */
static PetscErrorCode element_ghosts(const Builder *b, Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->d.n_points - b->d.n_blocks - m->mesh.n_owned, &m->ghosts.record));
  m->ghosts.n = 0;
  for (PetscInt v = b->d.n_blocks; v < b->d.n_points; v++) {
    const PointRecord *r = b->d.record + v;
    if (r->owner == m->rank) continue;
    m->ghosts.record[m->ghosts.n++] = (GhostRecord){r->gid,   r->file,     r->body,           r->rigid,
                                                    r->owner, b->index[v], {r->X[0], r->X[1]}};
  }
  m->ghosts.n_element = m->ghosts.n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether this rank owns a vertex of the group. own: (vertices in couplings,) whether it owns each of
   them. */
static PetscBool takes_part(const Couplings *c, const PetscBool *own, PetscInt group)
{
  for (PetscInt i = c->start[group]; i < c->start[group + 1]; i++)
    if (own[i]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Describes the vertices of all couplings: their owners send the records to the other ranks. */
static PetscErrorCode describe_coupled(const Builder *b, const Model *m, PetscInt n, const PetscInt *gid,
                                       GhostRecord *all, PetscBool *own)
{
  enum { INTS = 5 };
  PetscInt *of;
  PetscReal *X;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(INTS * n, &of, 2 * n, &X));
  for (PetscInt i = 0; i < INTS * n; i++) of[i] = -1;
  for (PetscInt i = 0; i < 2 * n; i++) X[i] = -PETSC_MAX_REAL;
  for (PetscInt i = 0; i < n; i++) own[i] = PETSC_FALSE;
  for (PetscInt v = b->d.n_blocks; v < b->d.n_points; v++) {
    const PointRecord *r = b->d.record + v;
    for (PetscInt i = 0; i < n && r->owner == m->rank; i++) {
      if (gid[i] != r->gid) continue;
      const PetscInt ints[INTS] = {r->file, r->body, r->rigid, r->owner, b->index[v]};
      PetscCall(PetscArraycpy(of + INTS * i, ints, INTS));
      PetscCall(PetscArraycpy(X + 2 * i, r->X, 2));
      own[i] = PETSC_TRUE;
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of, (PetscMPIInt)(INTS * n), MPIU_INT, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, X, (PetscMPIInt)(2 * n), MPIU_REAL, MPI_MAX, m->comm));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt *p = of + INTS * i;
    all[i] = (GhostRecord){gid[i], p[0], p[1], p[2], p[3], p[4], {X[2 * i], X[2 * i + 1]}};
  }
  PetscCall(PetscFree2(of, X));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the ghosts that force terms need to the ghosts of elements. */
static PetscErrorCode coupled_ghosts(const Builder *b, const Couplings *c, Model *m)
{
  const PetscInt n = c->n ? c->start[c->n] : 0;
  GhostRecord *all;
  PetscBool *own;
  PetscFunctionBeginUser;
  if (!n || m->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(n, &all, n, &own));
  PetscCall(describe_coupled(b, m, n, c->gid, all, own));
  PetscCall(PetscRealloc((m->ghosts.n + n) * sizeof(GhostRecord), &m->ghosts.record));
  for (PetscInt group = 0; group < c->n; group++)
    for (PetscInt i = c->start[group]; i < c->start[group + 1] && takes_part(c, own, group); i++)
      if (!own[i]) m->ghosts.record[m->ghosts.n++] = all[i];
  m->ghosts.n_element = m->ghosts.n = GhostsUnique(m->ghosts.n, m->ghosts.record);
  PetscCall(PetscFree2(all, own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the arrays */

/* Fills the arrays of owned vertices; neighbours.c appends the ghosts. */
static PetscErrorCode fill_vertices(const Builder *b, Model *m)
{
  LocalMesh *mesh = &m->mesh;
  PetscFunctionBeginUser;
  PetscCall(VerticesResize(m));
  if (mesh->n_condensed_global)
    PetscCall(PetscMalloc2(mesh->n_owned, &mesh->vertex_condensed, mesh->n_owned, &mesh->vertex_calm));
  for (PetscInt v = b->d.n_blocks; v < b->d.n_points; v++) {
    const PointRecord *r = b->d.record + v;
    const PetscInt i = b->index[v];
    if (r->owner != m->rank) continue;
    PetscCall(PetscArraycpy(mesh->X + 2 * i, r->X, 2));
    mesh->vertex_gid[i] = r->gid, mesh->vertex_file[i] = r->file;
    mesh->vertex_body[i] = r->body, mesh->vertex_rigid[i] = r->rigid;
    if (!mesh->vertex_condensed) continue;
    mesh->vertex_condensed[i] = r->condensed, mesh->vertex_calm[i] = (PetscBool)r->calm;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Kinds of lists in LocalMesh.elements: a deformable block is of the kind of its law. */
enum { KIND_RIGID = MATERIAL_LAWS, KIND_CONDENSED };

static int block_kind(const Scene *scene, const PointRecord *r)
{
  return r->rigid >= 0       ? KIND_RIGID
         : r->condensed >= 0 ? KIND_CONDENSED
                             : (int)scene->materials[r->group].law;
}

/* Fills one list of elements of one kind; n_nodes is 3 or 4. */
static PetscErrorCode fill_elements(const Builder *b, const Scene *scene, const Model *m, int n_nodes,
                                    int kind, Elements *e)
{
  const PointRecord *record = b->d.record;
  const PetscInt *v;
  PetscInt *point, n_vertices, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->d.n_blocks, &point));
  for (PetscInt c = 0; c < b->d.n_blocks; c++) {
    PetscCall(block_vertices(b, c, &v, &n_vertices));
    if (n_vertices == n_nodes && block_kind(scene, record + c) == kind) point[n++] = c;
  }
  e->n = n, e->n_nodes = n_nodes;
  e->law = kind < KIND_RIGID ? (MaterialLaw)kind : MATERIAL_ELASTIC;
  e->n_padded = (n + BATCH - 1) / BATCH * BATCH;
  e->strain = kind == KIND_CONDENSED && !SceneCorrects(scene) ? STRAIN_SMALL : m->materials.strain;
  PetscCall(PetscCalloc2(n_nodes * e->n_padded, &e->vertex, e->n_padded, &e->group));
  PetscCall(PetscMalloc1(n, &e->gid));
  PetscCall(PetscMalloc2(n, &e->file, n, &e->owned));
  for (PetscInt i = 0; i < n; i++) {
    PetscInt lowest = PETSC_MAX_INT;
    e->gid[i] = record[point[i]].gid, e->group[i] = record[point[i]].group,
    e->file[i] = record[point[i]].file;
    PetscCall(block_vertices(b, point[i], &v, &n_vertices));
    for (PetscInt k = 0; k < n_nodes; k++) {
      const PointRecord *r = record + v[k];
      e->vertex[VertexPlace(e, i, k)] = LocalVertex(m, r->gid, (PetscMPIInt)r->owner, b->index[v[k]]);
      if (r->gid < lowest) lowest = r->gid, e->owned[i] = r->owner == m->rank;
    }
  }
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives all ranks the face set s of the whole mesh: gids of faces, ascending. */
static PetscErrorCode share_set(const BlockMesh *mesh, const Model *m, PetscInt s, PetscInt *n,
                                PetscInt **gids)
{
  const PetscInt *face = mesh->face_sets[s].faces;
  PetscFunctionBeginUser;
  *n = m->rank ? 0 : mesh->face_sets[s].n;
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, m->comm));
  PetscCall(PetscMalloc1(*n, gids));
  for (PetscInt i = 0; i < *n && !m->rank; i++) (*gids)[i] = 4 * face[2 * i] + face[2 * i + 1];
  if (!m->rank) PetscCall(PetscSortInt(*n, *gids));
  PetscCallMPI(MPI_Bcast(*gids, *n, MPIU_INT, 0, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the named face sets with rows of local faces, in ascending gid. */
static PetscErrorCode fill_face_sets(const BlockMesh *mesh, Model *m)
{
  LocalMesh *local = &m->mesh;
  PetscInt n = 0, n_set, *gid, at;
  PetscFunctionBeginUser;
  local->n_face_sets = mesh->n_face_sets;
  PetscCall(PetscMalloc2(local->n_face_sets, &local->face_set_names, local->n_face_sets + 1,
                         &local->face_set_start));
  PetscCall(PetscArraycpy(local->face_set_names, mesh->face_set_names, local->n_face_sets));
  local->face_set_start[0] = 0;
  for (PetscInt s = 0; s < local->n_face_sets; s++) {
    PetscCall(share_set(mesh, m, s, &n_set, &gid));
    PetscCall(
        PetscRealloc((n + PetscMin(n_set, m->faces.n_local)) * sizeof(PetscInt), &local->face_set_faces));
    for (PetscInt i = 0; i < n_set; i++) {
      PetscCall(PetscFindInt(gid[i], m->faces.n_local, m->faces.gid, &at));
      if (at >= 0) local->face_set_faces[n++] = at;
    }
    PetscCall(PetscFree(gid));
    local->face_set_start[s + 1] = n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the joint of each face: the row that has the name of a face set with this face. Of several rows the
   one with the lowest turn counts. */
static PetscErrorCode fill_joints(const Scene *scene, const BlockMesh *mesh, Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(JointTurns(scene, mesh, m));
  for (PetscInt j = 1; j < scene->n_joints; j++)
    for (PetscInt s = 0; s < m->mesh.n_face_sets; s++) {
      if (strcmp(scene->joints[j].name, m->mesh.face_set_names[s])) continue;
      for (PetscInt i = m->mesh.face_set_start[s]; i < m->mesh.face_set_start[s + 1]; i++) {
        PetscInt *row = m->faces.joint + m->mesh.face_set_faces[i];
        if (*row < 0 || m->materials.joint_turn[j] < m->materials.joint_turn[*row]) *row = j;
      }
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the named points on this rank. */
static PetscErrorCode fill_points(const BlockMesh *mesh, Model *m)
{
  LocalMesh *local = &m->mesh;
  PetscInt *vertex_of_point;
  PetscFunctionBeginUser;
  local->n_points = mesh->n_points;
  PetscCall(PetscMalloc2(local->n_points, &local->point_names, local->n_points, &local->point_vertex));
  PetscCall(PetscArraycpy(local->point_names, mesh->point_names, local->n_points));
  PetscCall(PetscMalloc1(local->n_points, &vertex_of_point));
  if (m->rank == 0) PetscCall(PetscArraycpy(vertex_of_point, mesh->point_vertex, mesh->n_points));
  PetscCallMPI(MPI_Bcast(vertex_of_point, local->n_points, MPIU_INT, 0, m->comm));
  for (PetscInt i = 0; i < local->n_points; i++) {
    local->point_vertex[i] = -1;
    for (PetscInt v = 0; v < local->n_owned; v++)
      if (local->vertex_gid[v] == vertex_of_point[i]) local->point_vertex[i] = v;
    for (PetscInt g = 0; g < m->ghosts.n_element; g++)
      if (m->ghosts.record[g].gid == vertex_of_point[i]) local->point_vertex[i] = local->n_owned + g;
  }
  PetscCall(PetscFree(vertex_of_point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the constants of each group from the scene. */
static PetscErrorCode fill_materials(const Scene *scene, const BlockMesh *mesh, Model *m)
{
  const PetscInt n = mesh->n_groups;
  Materials *materials = &m->materials;
  PetscFunctionBeginUser;
  materials->n_groups = n;
  materials->thickness = scene->thickness;
  materials->strain = scene->strain;
  PetscCall(PetscMalloc6(n, &materials->names, n, &materials->rigid, n, &materials->condensed, n,
                         &materials->lame, n, &materials->density, n, &materials->upgradeable));
  for (PetscInt g = 0; g < n; g++) {
    const Material *material = scene->materials + g;
    const PetscReal E = material->young, nu = material->poisson;
    PetscCall(PetscArraycpy(materials->names + g, mesh->group_names + g, 1));
    materials->rigid[g] = mesh->group_rigid[g];
    materials->condensed[g] = (PetscBool)(material->condensed > 0);
    materials->density[g] = material->density;
    materials->upgradeable[g] = material->upgradeable;
    materials->lame[g].mu = E / (2. * (1. + nu));
    materials->lame[g].lambda = scene->plane == PLANE_STRAIN ? E * nu / ((1. + nu) * (1. - 2. * nu))
                                                             : E * nu / (1. - nu * nu);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, const Couplings *couplings,
                           Model *m)
{
  Builder b = {0};
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(m, sizeof(*m)));
  m->comm = comm;
  PetscCall(TimerBegin(TIMER_DISTRIBUTION));
  PetscCall(MeshDistribute(scene, mesh, m, &b.d));
  PetscCall(TimerEnd(TIMER_DISTRIBUTION));
  PetscCall(TimerBegin(TIMER_MODEL));
  PetscCall(number_owned(&b, m));
  PetscCall(element_ghosts(&b, m));
  PetscCall(coupled_ghosts(&b, couplings, m));
  PetscCall(local_faces(&b, m));
  PetscCall(fill_face_sets(mesh, m));
  PetscCall(fill_joints(scene, mesh, m));
  PetscCall(fill_materials(scene, mesh, m));
  PetscCall(fill_vertices(&b, m));
  PetscCall(fill_points(mesh, m));
  for (int l = 0; l < ELEMENT_LISTS; l++)
    PetscCall(fill_elements(&b, scene, m, l % 2 ? 3 : 4, l / 2, m->mesh.elements + l));
  PetscCall(DMDestroy(&b.d.dm));
  PetscCall(PetscSFDestroy(&b.d.migration));
  PetscCall(PetscFree(b.d.record));
  PetscCall(PetscFree(b.index));
  PetscCall(NeighboursUpdate(m, NULL));
  PetscCall(TimerEnd(TIMER_MODEL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelDestroy(Model *m)
{
  LocalMesh *mesh = &m->mesh;
  Materials *materials = &m->materials;
  PetscFunctionBeginUser;
  PetscCall(VerticesFree(m));
  PetscCall(PetscFree5(m->rigid.gid, m->rigid.start, m->rigid.X, m->rigid.mass, m->rigid.body));
  PetscCall(PetscFree2(m->vertex_mass, m->support));
  PetscCall(PetscFree(m->in_quotient));
  PetscCall(PetscFree(mesh->chunk_done));
  PetscCall(PetscFree(materials->hourglass));
  for (Elements *list = mesh->elements; list < mesh->elements + ELEMENT_LISTS; list++) {
    PetscCall(PetscFree(list->gid));
    PetscCall(PetscFree2(list->vertex, list->group));
    PetscCall(PetscFree2(list->file, list->owned));
  }
  PetscCall(PetscFree2(mesh->vertex_condensed, mesh->vertex_calm));
  PetscCall(FacesDestroy(m));
  PetscCall(PetscFree(m->ghosts.record));
  PetscCall(PetscFree6(materials->names, materials->rigid, materials->condensed, materials->lame,
                       materials->density, materials->upgradeable));
  PetscCall(PetscFree(materials->later_joint));
  PetscCall(PetscFree(materials->joint_turn));
  PetscCall(PetscFree2(mesh->face_set_names, mesh->face_set_start));
  PetscCall(PetscFree(mesh->face_set_faces));
  PetscCall(PetscFree2(mesh->point_names, mesh->point_vertex));
  PetscCall(GhostDestroy(m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt RigidOfVertex(const Model *m, PetscInt v)
{
  PetscInt low = 0, high = m->rigid.n; // rigid.start[low] <= v < rigid.start[high]
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;
    if (m->rigid.start[middle] <= v)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* model.c: from the distributed Plex to the flat arrays of types.h. Order of work: owned vertices get their
   numbers; then the other vertices and outer faces of blocks at owned vertices; then the arrays. What
   contacts need from other ranks comes from neighbours.c. */
#include "internal.h"
#include <petscdmplex.h>

typedef struct {
  DM dm;
  PointRecord *record;
  PetscInt c_start, c_end, v_start, v_end, e_start, e_end;
  PetscInt *owner; /* (points,) rank that owns the point */
  PetscInt *index; /* (vertices,) index of the vertex on its owner */
  PetscReal *x;    /* (vertices,2) */
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
  PetscInt inner, body, gid, point; /* inner: condensed body of an inner vertex, -1; body: rigid one, -1 */
} OwnedVertex;

static int owned_order(const void *a, const void *b)
{
  const OwnedVertex *f = a, *g = b;
  if (f->inner != g->inner) return (f->inner > g->inner) - (f->inner < g->inner);
  if (f->body != g->body) return (f->body > g->body) - (f->body < g->body);
  return (f->gid > g->gid) - (f->gid < g->gid);
}

/* Numbers owned vertices: deformable by gid, then rigid by body and gid, then inner ones of condensed bodies
   likewise; tells every rank the index at the owner. */
static PetscErrorCode number_owned(Builder *b, Model *m)
{
  const PetscInt nv = b->v_end - b->v_start;
  OwnedVertex *owned;
  PetscInt n_points, *all, n_roots;
  PetscSF sf;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(nv, &owned));
  PetscCall(PetscMalloc1(nv, &b->index));
  m->n_owned = m->n_deformable = m->n_moving = 0;
  for (PetscInt v = b->v_start; v < b->v_end; v++) {
    b->index[v - b->v_start] = -1;
    if (b->owner[v] != m->rank) continue;
    const PointRecord *r = b->record + v;
    owned[m->n_owned++] = (OwnedVertex){r->inner ? r->condensed : -1, r->rigid, r->gid, v};
    m->n_moving += !r->inner;
    m->n_deformable += !r->inner && r->rigid < 0;
  }
  if (m->n_owned) qsort(owned, m->n_owned, sizeof(OwnedVertex), owned_order);
  for (PetscInt i = 0; i < m->n_owned; i++) b->index[owned[i].point - b->v_start] = i;
  PetscCall(PetscFree(owned));

  PetscCall(DMGetPointSF(b->dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &n_roots, NULL, NULL, NULL));
  PetscCall(DMPlexGetChart(b->dm, NULL, &n_points));
  if (n_roots >= 0) {
    PetscCall(PetscMalloc1(n_points, &all));
    for (PetscInt p = 0; p < n_points; p++)
      all[p] = p >= b->v_start && p < b->v_end ? b->index[p - b->v_start] : -1;
    PetscCall(PetscSFBcastBegin(sf, MPIU_INT, all, all, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(sf, MPIU_INT, all, all, MPI_REPLACE));
    for (PetscInt v = b->v_start; v < b->v_end; v++) b->index[v - b->v_start] = all[v];
    PetscCall(PetscFree(all));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- faces */

/* The vertices of a block in ring order (Plex points); n: 3 or 4. */
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

/* A block is needed here when it touches an owned vertex. */
static PetscErrorCode is_needed(const Builder *b, PetscInt c, PetscMPIInt rank, PetscInt v[4], PetscInt *n,
                                PetscBool *needed)
{
  PetscFunctionBeginUser;
  PetscCall(block_vertices(b->dm, c, v, n));
  *needed = PETSC_FALSE;
  for (PetscInt k = 0; k < *n; k++) *needed = (PetscBool)(*needed || b->owner[v[k]] == rank);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Faces by ascending gid, their Plex points along. */
static PetscErrorCode sort_faces(PetscInt n, FaceRecord *face, PetscInt *point)
{
  PetscInt *gid, *order, *points;
  FaceRecord *sorted;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(n, &gid, n, &order, n, &points, n, &sorted));
  for (PetscInt f = 0; f < n; f++) gid[f] = face[f].gid, order[f] = f;
  PetscCall(PetscSortIntWithArray(n, gid, order));
  for (PetscInt f = 0; f < n; f++) sorted[f] = face[order[f]], points[f] = point[order[f]];
  PetscCall(PetscArraycpy(face, sorted, n));
  PetscCall(PetscArraycpy(point, points, n));
  PetscCall(PetscFree4(gid, order, points, sorted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* Outer faces of local blocks at owned vertices; face_point: their Plex points. */
static PetscErrorCode local_faces(const Builder *b, const Scene *scene, Model *m, PetscInt **face_point)
{
  FaceRecord *face;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->e_end - b->e_start, &face));
  PetscCall(PetscMalloc1(b->e_end - b->e_start, face_point));
  for (PetscInt e = b->e_start; e < b->e_end; e++) {
    const PetscInt *cone, *support;
    PetscInt n_support, v[4], k_max = 0;
    PetscBool needed = PETSC_FALSE;
    if (b->record[e].gid < 0) continue;
    PetscCall(DMPlexGetSupportSize(b->dm, e, &n_support));
    if (!n_support) continue;
    PetscCall(DMPlexGetSupport(b->dm, e, &support));
    PetscCall(is_needed(b, support[0], m->rank, v, &k_max, &needed));
    if (!needed) continue;
    PetscCall(DMPlexGetCone(b->dm, e, &cone));
    const PointRecord *block = b->record + support[0];
    FaceRecord *f = face + n;
    (*face_point)[n++] = e;
    *f = (FaceRecord){
        .gid = b->record[e].gid, .group = block->group, .body = block->body, .rigid = block->rigid};
    PetscCall(joint_of_face(b, scene, e, &f->joint));
    for (int k = 0; k < 2; k++) {
      f->v_gid[k] = b->record[cone[k]].gid, f->v_file[k] = b->record[cone[k]].file;
      f->v_owner[k] = b->owner[cone[k]], f->v_index[k] = b->index[cone[k] - b->v_start];
      PetscCall(PetscArraycpy(f->X + 2 * k, b->x + 2 * (cone[k] - b->v_start), 2));
    }
    for (PetscInt k = 0; k < k_max; k++) { // how far the block reaches behind the face
      const PetscReal *P = b->x + 2 * (v[k] - b->v_start), ex = f->X[2] - f->X[0], ey = f->X[3] - f->X[1];
      f->thick = PetscMax(f->thick, ((P[1] - f->X[1]) * ex - (P[0] - f->X[0]) * ey) / PetscHypotReal(ex, ey));
    }
  }
  PetscCall(sort_faces(n, face, *face_point));
  PetscCall(FacesCreate(m, n, face));
  PetscCall(PetscFree(face));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- ghosts */

/* Ghosts of elements: vertices of needed blocks that other ranks own; ascending gid, each once. */
static PetscErrorCode element_ghosts(const Builder *b, Model *m)
{
  PetscInt n = 0, v[4], k_max = 0;
  PetscBool needed = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * (b->c_end - b->c_start), &m->ghosts));
  for (PetscInt c = b->c_start; c < b->c_end; c++) {
    PetscCall(is_needed(b, c, m->rank, v, &k_max, &needed));
    for (PetscInt k = 0; needed && k < k_max; k++) {
      const PetscInt i = v[k] - b->v_start;
      const PointRecord *p = b->record + v[k];
      if (b->owner[v[k]] == m->rank) continue;
      m->ghosts[n++] = (GhostRecord){
          p->gid, p->file, p->body, p->rigid, b->owner[v[k]], b->index[i], {b->x[2 * i], b->x[2 * i + 1]}};
    }
  }
  m->n_element_ghosts = m->n_ghosts = GhostsUnique(n, m->ghosts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the arrays */

/* Owned vertices; neighbours.c appends the ghosts. */
static PetscErrorCode fill_vertices(const Builder *b, Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(VerticesResize(m));
  if (m->n_condensed_global) PetscCall(PetscMalloc1(m->n_owned, &m->vertex_condensed));
  for (PetscInt v = b->v_start; v < b->v_end; v++) {
    if (b->owner[v] != m->rank) continue;
    const PetscInt i = b->index[v - b->v_start];
    PetscCall(PetscArraycpy(m->X + 2 * i, b->x + 2 * (v - b->v_start), 2));
    m->vertex_gid[i] = b->record[v].gid, m->vertex_file[i] = b->record[v].file;
    m->vertex_body[i] = b->record[v].body, m->vertex_rigid[i] = b->record[v].rigid;
    if (m->vertex_condensed) m->vertex_condensed[i] = b->record[v].condensed;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef enum { KIND_DEFORMABLE, KIND_RIGID, KIND_CONDENSED, KINDS } BlockKind;

/* Quadrilaterals and triangles of each kind in turn. */
static void element_lists(Model *m, Elements *list[2 * KINDS])
{
  Elements *const all[] = {&m->q4, &m->t3, &m->rigid_q4, &m->rigid_t3, &m->condensed_q4, &m->condensed_t3};
  memcpy(list, all, sizeof(all));
}

static BlockKind block_kind(const PointRecord *r)
{
  return r->rigid >= 0 ? KIND_RIGID : r->condensed >= 0 ? KIND_CONDENSED : KIND_DEFORMABLE;
}

/* One list of elements: n_nodes 3 or 4, of one kind. */
static PetscErrorCode fill_elements(const Builder *b, const Model *m, int n_nodes, BlockKind kind,
                                    Elements *e)
{
  PetscInt *point, v[4], k_max = 0, n = 0;
  PetscBool needed = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(b->c_end - b->c_start, &point));
  PetscCall(PetscMalloc1(b->c_end - b->c_start, &e->gid));
  for (PetscInt c = b->c_start; c < b->c_end; c++) {
    PetscCall(is_needed(b, c, m->rank, v, &k_max, &needed));
    if (needed && k_max == n_nodes && block_kind(b->record + c) == kind)
      e->gid[n] = b->record[c].gid, point[n++] = c;
  }
  PetscCall(PetscSortIntWithArray(n, e->gid, point));
  e->n = n;
  e->n_padded = (n + BATCH - 1) / BATCH * BATCH;
  e->strain = kind == KIND_CONDENSED ? STRAIN_SMALL : m->strain;
  PetscCall(PetscCalloc2(n_nodes * e->n_padded, &e->vertex, e->n_padded, &e->group));
  PetscCall(PetscRealloc(n * sizeof(PetscInt), &e->gid));
  PetscCall(PetscMalloc2(n, &e->file, n, &e->owned));
  for (PetscInt i = 0; i < n; i++) {
    const PointRecord *r = b->record + point[i];
    PetscInt lowest = PETSC_MAX_INT;
    e->group[i] = r->group, e->file[i] = r->file;
    PetscCall(block_vertices(b->dm, point[i], v, &k_max));
    for (int k = 0; k < n_nodes; k++) {
      const PetscInt gid = b->record[v[k]].gid;
      e->vertex[((i / BATCH) * n_nodes + k) * BATCH + i % BATCH] = LocalVertex(
          m, gid, (PetscMPIInt)b->owner[v[k]], b->index[v[k] - b->v_start]);
      if (gid < lowest) lowest = gid, e->owned[i] = b->owner[v[k]] == m->rank;
    }
  }
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Named sets: rows of local faces, ascending gid; points on this rank. */
static PetscErrorCode fill_sets(const Builder *b, const PetscInt *face_point, const BlockMesh *mesh, Model *m)
{
  PetscInt n = 0, *row, *vertex_of_point;
  PetscFunctionBeginUser;
  m->n_face_sets = mesh->n_face_sets, m->n_points = mesh->n_points;
  PetscCall(PetscMalloc2(m->n_face_sets, &m->face_set_names, m->n_points, &m->point_names));
  PetscCall(PetscArraycpy(m->face_set_names, mesh->face_set_names, m->n_face_sets));
  PetscCall(PetscArraycpy(m->point_names, mesh->point_names, m->n_points));
  PetscCall(PetscMalloc3(m->n_face_sets + 1, &m->face_set_start, m->n_face_sets * m->n_faces_local, &row,
                         m->n_points, &m->point_vertex));
  m->face_set_faces = row;
  m->face_set_start[0] = 0;
  for (PetscInt s = 0; s < m->n_face_sets; s++) {
    for (PetscInt f = 0; f < m->n_faces_local; f++) {
      PetscInt value;
      PetscCall(DMGetLabelValue(b->dm, m->face_set_names[s], face_point[f], &value));
      if (value == 1) row[n++] = f;
    }
    m->face_set_start[s + 1] = n;
  }
  PetscCall(PetscMalloc1(m->n_points, &vertex_of_point));
  if (m->rank == 0) PetscCall(PetscArraycpy(vertex_of_point, mesh->point_vertex, mesh->n_points));
  PetscCallMPI(MPI_Bcast(vertex_of_point, m->n_points, MPIU_INT, 0, m->comm));
  for (PetscInt i = 0; i < m->n_points; i++) {
    m->point_vertex[i] = -1;
    for (PetscInt v = 0; v < m->n_owned; v++)
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
  PetscCall(PetscMalloc7(m->n_groups, &m->group_names, m->n_groups, &m->group_rigid, m->n_groups,
                         &m->group_condensed, m->n_groups, &m->lambda, m->n_groups, &m->mu, m->n_groups,
                         &m->density, m->n_groups, &m->group_upgradeable));
  for (PetscInt g = 0; g < m->n_groups; g++) {
    const Material *material = scene->materials + g;
    const PetscReal E = material->young, nu = material->poisson;
    PetscCall(PetscArraycpy(m->group_names + g, mesh->group_names + g, 1));
    m->group_rigid[g] = mesh->group_rigid[g];
    m->group_condensed[g] = material->condensed;
    m->density[g] = material->density;
    m->group_upgradeable[g] = material->upgradeable;
    m->mu[g] = E / (2. * (1. + nu));
    m->lambda[g] = scene->plane == PLANE_STRAIN ? E * nu / ((1. + nu) * (1. - 2. * nu))
                                                : E * nu / (1. - nu * nu);
    if (material->element != ELEMENT_FULL && !m->hourglass)
      PetscCall(PetscCalloc1(3 * m->n_groups, &m->hourglass));
    if (material->element != ELEMENT_FULL)
      ElementHourglass(material->element, m->lambda[g], m->mu[g], material->hourglass, m->hourglass + 3 * g);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks the dofs of the groups that enter the Rayleigh quotient (all when none is named). */
static PetscErrorCode damping_groups(const Scene *scene, Model *m)
{
  const PetscInt at = 3 * m->n_bodies;
  Elements *list[2 * KINDS];
  PetscFunctionBeginUser;
  if (!scene->n_damping_groups) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(m->n_dof, &m->in_quotient));
  element_lists(m, list);
  for (PetscInt g = 0; g < scene->n_damping_groups; g++)
    for (int l = 0; l < 2 * KINDS; l++)
      for (PetscInt e = 0, n_nodes = l % 2 ? 3 : 4; e < list[l]->n; e++) {
        if (strcmp(m->group_names[list[l]->group[e]], scene->damping_groups[g])) continue;
        for (PetscInt k = 0; k < n_nodes; k++) {
          const PetscInt v = list[l]->vertex[((e / BATCH) * n_nodes + k) * BATCH + e % BATCH];
          if (v < m->n_deformable) m->in_quotient[at + 2 * v] = m->in_quotient[at + 2 * v + 1] = 1.;
          if (v < m->n_deformable || v >= m->n_moving) continue;
          for (int i = 0; i < 3; i++) m->in_quotient[3 * RigidOfVertex(m, v) + i] = 1.;
        }
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True masses and share in the damping quotient; supports come later (loads.c). */
static PetscErrorCode fill_dofs(const Scene *scene, Model *m)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscReal *vertex_mass;
  PetscFunctionBeginUser;
  m->n_dof = at + 2 * m->n_deformable;
  const PetscInt n_held = at + 2 * m->n_owned;
  PetscCall(PetscMalloc2(m->n_deformable, &m->vertex_mass, n_held, &m->support));
  for (PetscInt d = 0; d < n_held; d++) m->support[d] = -1;
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &vertex_mass));
  PetscCall(ElementMasses(m, vertex_mass));
  PetscCall(PetscArraycpy(m->vertex_mass, vertex_mass, m->n_deformable));
  PetscCall(PetscFree(vertex_mass));
  PetscCall(damping_groups(scene, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelCreate(MPI_Comm comm, const Scene *scene, BlockMesh *mesh, Model *m)
{
  Builder b = {0};
  Elements *list[2 * KINDS];
  PetscInt *face_point;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(m, sizeof(*m)));
  m->comm = comm;
  PetscCall(PartBegin(PART_DISTRIBUTION));
  PetscCall(MeshDistribute(scene, mesh, m, &b.dm, &b.record));
  PetscCall(PartEnd(PART_DISTRIBUTION));
  PetscCall(PartBegin(PART_MODEL));
  PetscCall(find_owners(&b, m->rank));
  PetscCall(read_coordinates(&b));
  PetscCall(number_owned(&b, m));
  PetscCall(element_ghosts(&b, m));
  PetscCall(local_faces(&b, scene, m, &face_point));
  PetscCall(fill_materials(scene, mesh, m));
  PetscCall(fill_vertices(&b, m));
  element_lists(m, list);
  for (int l = 0; l < 2 * KINDS; l++)
    PetscCall(fill_elements(&b, m, l % 2 ? 3 : 4, (BlockKind)(l / 2), list[l]));
  PetscCall(fill_sets(&b, face_point, mesh, m));
  PetscCall(NeighboursUpdate(m, NULL));
  PetscCall(RigidBodiesCreate(m));
  PetscCall(fill_dofs(scene, m));
  PetscCall(ElementChunksDone(m));
  PetscCall(DMDestroy(&b.dm));
  PetscCall(PetscFree(b.record));
  PetscCall(PetscFree(b.owner));
  PetscCall(PetscFree(b.index));
  PetscCall(PetscFree(b.x));
  PetscCall(PetscFree(face_point));
  PetscCall(PartEnd(PART_MODEL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModelDestroy(Model *m)
{
  Elements *list[2 * KINDS];
  PetscFunctionBeginUser;
  PetscCall(VerticesFree(m));
  PetscCall(PetscFree5(m->body_gid, m->body_start, m->body_X, m->body_mass, m->body_body));
  PetscCall(PetscFree2(m->vertex_mass, m->support));
  PetscCall(PetscFree(m->in_quotient));
  PetscCall(PetscFree(m->chunk_done));
  PetscCall(PetscFree(m->hourglass));
  element_lists(m, list);
  for (int l = 0; l < 2 * KINDS; l++) {
    PetscCall(PetscFree(list[l]->gid));
    PetscCall(PetscFree2(list[l]->vertex, list[l]->group));
    PetscCall(PetscFree2(list[l]->file, list[l]->owned));
  }
  PetscCall(PetscFree(m->vertex_condensed));
  PetscCall(FacesDestroy(m));
  PetscCall(PetscFree(m->ghosts));
  PetscCall(PetscFree7(m->group_names, m->group_rigid, m->group_condensed, m->lambda, m->mu, m->density,
                       m->group_upgradeable));
  PetscCall(PetscFree2(m->face_set_names, m->point_names));
  PetscCall(PetscFree3(m->face_set_start, m->face_set_faces, m->point_vertex));
  PetscCall(GhostDestroy(m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

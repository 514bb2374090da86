/* distribute.c: distributes the mesh to the ranks. The BlockMesh on rank 0 gets bodies and a partition and
   becomes a DMPlex; then each rank gets the DMPlex of the blocks that touch a vertex it owns, and a
   PointRecord for each of its points. Rank 0 knows the whole mesh, so it decides which points go where,
   including the layer of overlap, and the Plex is sent once. No file but this one and model.c uses the
   Plex. */
#include "model/model.h"
#include "base/shared.h"
#include <petscdmplex.h>

/* Makes the cones of the Plex. Its points are blocks, then vertices; a cone runs along the block's ring.
   Faces need no points, because an outer face is known by its block and its place there. */
static PetscErrorCode plex_cones(DM dm, const BlockMesh *mesh)
{
  const PetscInt nb = mesh->n_blocks;
  PetscInt *cone, at = 0;
  PetscFunctionBeginUser;
  PetscCall(DMPlexSetChart(dm, 0, nb + mesh->n_vertices));
  for (PetscInt b = 0; b < nb; b++) PetscCall(DMPlexSetConeSize(dm, b, mesh->blocks[4 * b + 3] < 0 ? 3 : 4));
  PetscCall(DMSetUp(dm));
  PetscCall(DMPlexGetCones(dm, &cone));
  for (PetscInt i = 0; i < 4 * nb; i++)
    if (mesh->blocks[i] >= 0) cone[at++] = nb + mesh->blocks[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the record of each point of the whole mesh, on rank 0. A vertex where parts of the partition meet
   belongs to the last of them. */
static PetscErrorCode fill_records(const BlockMesh *mesh, const BodyNumbers *bodies, PointRecord *r)
{
  const PetscInt nb = mesh->n_blocks;
  PetscInt n_outer, *outer;
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < mesh->n_vertices; v++)
    r[nb + v] = (PointRecord){.gid = v,
                              .file = mesh->vertex_file[v],
                              .rigid = -1,
                              .condensed = -1,
                              .inner = bodies->inner[v],
                              .calm = bodies->calm[v],
                              .X = {mesh->X[2 * v], mesh->X[2 * v + 1]}};
  for (PetscInt b = 0; b < nb; b++) {
    r[b] = (PointRecord){.gid = b,
                         .file = mesh->block_file[b],
                         .owner = mesh->part[b],
                         .group = mesh->block_group[b],
                         .body = mesh->body[b],
                         .rigid = bodies->rigid[b],
                         .condensed = bodies->condensed[b]};
    for (PetscInt k = 0; k < 4 && mesh->blocks[4 * b + k] >= 0; k++) {
      PointRecord *vertex = r + nb + mesh->blocks[4 * b + k];
      vertex->body = mesh->body[b];
      vertex->owner = PetscMax(vertex->owner, mesh->part[b]);
      if (bodies->rigid[b] >= 0) vertex->rigid = bodies->rigid[b];
      if (bodies->condensed[b] >= 0) vertex->condensed = bodies->condensed[b];
    }
  }
  PetscCall(MeshOuterFaces(mesh, &n_outer, &outer));
  for (PetscInt f = 0; f < n_outer; f++) r[outer[2 * f]].outer |= 1 << outer[2 * f + 1];
  PetscCall(PetscFree(outer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points that each rank needs: blocks that touch a vertex it owns, and all vertices of these blocks. */
typedef struct {
  PetscMPIInt *n_blocks, *n_points, *start; /* (size,) counts of each rank; where its points start */
  PetscInt *points;                         /* rank after rank: blocks, then vertices, ascending */
  PetscInt *last;                           /* (size,) the point that was last added for each rank */
} Needs;

static void add_point(Needs *needs, PetscInt point, PetscInt rank)
{
  if (needs->last[rank] == point) return;
  needs->last[rank] = point;
  if (needs->points) needs->points[needs->start[rank] + needs->n_points[rank]] = point;
  needs->n_points[rank]++;
}

/* Sweeps over the whole mesh: counts while needs->points is NULL, fills afterwards. vertex: records of the
   vertices; start, blocks: the blocks at each vertex. */
static PetscErrorCode sweep_needs(const BlockMesh *mesh, const PointRecord *vertex, const PetscInt *start,
                                  const PetscInt *blocks, PetscMPIInt size, Needs *needs)
{
  PetscFunctionBeginUser;
  for (PetscMPIInt p = 0; p < size; p++) needs->n_points[p] = 0, needs->last[p] = -1;
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) add_point(needs, i / 4, vertex[mesh->blocks[i]].owner);
  PetscCall(PetscArraycpy(needs->n_blocks, needs->n_points, size));
  for (PetscInt v = 0; v < mesh->n_vertices; v++)
    for (PetscInt i = start[v]; i < start[v + 1]; i++)
      for (const PetscInt *at = mesh->blocks + 4 * blocks[i], *end = at + 4; at < end && *at >= 0; at++)
        add_point(needs, mesh->n_blocks + v, vertex[*at].owner);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode find_needs(const BlockMesh *mesh, const PointRecord *record, PetscMPIInt size,
                                 Needs *needs)
{
  PetscInt *start, *blocks;
  PetscFunctionBeginUser;
  PetscCall(MeshVertexBlocks(mesh, &start, &blocks));
  PetscCall(sweep_needs(mesh, record + mesh->n_blocks, start, blocks, size, needs));
  for (PetscMPIInt p = 0; p < size; p++) needs->start[p + 1] = needs->start[p] + needs->n_points[p];
  PetscCall(PetscMalloc1(needs->start[size], &needs->points));
  PetscCall(sweep_needs(mesh, record + mesh->n_blocks, start, blocks, size, needs));
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(blocks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the star forest from the points of the whole mesh on rank 0 to the points that each rank needs. */
static PetscErrorCode migration_sf(const BlockMesh *mesh, const PointRecord *record, const Model *m,
                                   DealtMesh *dealt)
{
  Needs needs = {0};
  PetscMPIInt n[2];
  PetscInt *points;
  PetscSFNode *remote;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc4(m->size, &needs.n_blocks, m->size, &needs.n_points, m->size + 1, &needs.start,
                         m->size, &needs.last));
  if (!m->rank) PetscCall(find_needs(mesh, record, m->size, &needs));
  PetscCallMPI(MPI_Scatter(needs.n_blocks, 1, MPI_INT, &n[0], 1, MPI_INT, 0, m->comm));
  PetscCallMPI(MPI_Scatter(needs.n_points, 1, MPI_INT, &n[1], 1, MPI_INT, 0, m->comm));
  PetscCall(PetscMalloc1(n[1], &points));
  PetscCall(PetscMalloc1(n[1], &remote));
  PetscCallMPI(
      MPI_Scatterv(needs.points, needs.n_points, needs.start, MPIU_INT, points, n[1], MPIU_INT, 0, m->comm));
  for (PetscMPIInt i = 0; i < n[1]; i++) remote[i] = (PetscSFNode){0, points[i]};
  PetscCall(PetscSFCreate(m->comm, &dealt->migration));
  PetscCall(PetscSFSetGraph(dealt->migration, mesh->n_blocks + mesh->n_vertices, n[1], NULL,
                            PETSC_OWN_POINTER, remote, PETSC_OWN_POINTER));
  dealt->n_blocks = n[0], dealt->n_points = n[1];
  PetscCall(PetscFree(points));
  PetscCall(PetscFree(needs.points));
  PetscCall(PetscFree4(needs.n_blocks, needs.n_points, needs.start, needs.last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends Plex and records along the migration star forest. */
static PetscErrorCode migrate(DealtMesh *dealt)
{
  MPI_Datatype unit;
  PointRecord *record;
  DM dm;
  PetscFunctionBeginUser;
  PetscCall(DMCreate(PetscObjectComm((PetscObject)dealt->dm), &dm));
  PetscCall(DMSetType(dm, DMPLEX));
  PetscCall(DMPlexMigrate(dealt->dm, dealt->migration, dm));
  PetscCall(DMDestroy(&dealt->dm));
  dealt->dm = dm;
  PetscCall(PetscMalloc1(dealt->n_points, &record));
  PetscCallMPI(MPI_Type_contiguous(sizeof(PointRecord), MPI_BYTE, &unit));
  PetscCallMPI(MPI_Type_commit(&unit));
  PetscCall(PetscSFBcastBegin(dealt->migration, unit, dealt->record, record, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(dealt->migration, unit, dealt->record, record, MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&unit));
  PetscCall(PetscFree(dealt->record));
  dealt->record = record;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Distributes the mesh as mesh->part says. */
static PetscErrorCode distribute(const BlockMesh *mesh, const BodyNumbers *bodies, const Model *m,
                                 DealtMesh *dealt)
{
  PetscFunctionBeginUser;
  *dealt = (DealtMesh){.n_blocks = mesh->n_blocks, .n_points = mesh->n_blocks + mesh->n_vertices};
  PetscCall(DMCreate(m->comm, &dealt->dm));
  PetscCall(DMSetType(dealt->dm, DMPLEX));
  PetscCall(DMSetDimension(dealt->dm, 2));
  PetscCall(plex_cones(dealt->dm, mesh));
  PetscCall(PetscMalloc1(dealt->n_points, &dealt->record));
  if (!m->rank) PetscCall(fill_records(mesh, bodies, dealt->record));
  if (m->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(migration_sf(mesh, dealt->record, m, dealt));
  PetscCall(migrate(dealt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives all ranks the numbers that describe the whole mesh, from rank 0, which numbers the bodies here. */
static PetscErrorCode describe_mesh(const Scene *scene, const BlockMesh *mesh, BodyNumbers *bodies, Model *m)
{
  PetscReal longest, measure[2];
  PetscMPIInt here;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(m->comm, &m->rank));
  PetscCallMPI(MPI_Comm_size(m->comm, &m->size));
  PetscCall(SharedRanks(m->comm, &here));
  m->one_machine = (PetscBool)(here == m->size && scene->exchange == EXCHANGE_AUTO);
  MeshMeasures(mesh, &longest, &measure[0]);
  measure[1] = scene->contact_tolerance * (scene->contact_relative ? longest : 1.);
  PetscCallMPI(MPI_Bcast(measure, 2, MPIU_REAL, 0, m->comm));
  m->mesh.diameter = measure[0], m->contact_margin = measure[1];
  if (!m->rank) {
    PetscCall(MeshConnected(mesh, mesh->group_rigid, &bodies->n_rigid, &bodies->rigid));
    PetscCall(MeshCondensed(scene, mesh, m->contact_margin, bodies));
  }
  PetscInt n[5] = {mesh->n_vertices, mesh->n_blocks, mesh->n_bodies, bodies->n_rigid, bodies->n_condensed};
  PetscCallMPI(MPI_Bcast(n, 5, MPIU_INT, 0, m->comm));
  m->mesh.n_vertices_global = n[0], m->mesh.n_blocks_global = n[1], m->mesh.n_bodies_global = n[2];
  m->mesh.n_rigid_global = n[3], m->mesh.n_condensed_global = n[4];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshDistribute(const Scene *scene, BlockMesh *mesh, Model *m, DealtMesh *dealt)
{
  BodyNumbers bodies = {0};
  PetscFunctionBeginUser;
  PetscCall(describe_mesh(scene, mesh, &bodies, m));
  PetscCall(TimerBegin(TIMER_PARTITION));
  if (!m->rank && !mesh->part) {
    PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->part));
    PetscCall(PartitionBlocks(mesh, &bodies, scene->partition, m->contact_margin, m->size, mesh->part));
  }
  PetscCall(TimerEnd(TIMER_PARTITION));
  PetscCall(distribute(mesh, &bodies, m, dealt));
  PetscCall(PetscFree(bodies.rigid));
  PetscCall(PetscFree(bodies.condensed));
  PetscCall(PetscFree(bodies.inner));
  PetscCall(PetscFree(bodies.calm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* distribute.c: BlockMesh on rank 0 -> bodies, partition -> DMPlex -> distributed DMPlex with one layer of
   overlap, and what each point of it is (PointRecord). After this file and model.c nobody asks the Plex. */
#include "internal.h"
#include "shared.h"
#include <petscdmplex.h>

/* Plex points are numbered blocks, vertices, faces. Cones run along the block's ring;
   orientation -1 turns a face. */
static PetscErrorCode plex_cones(DM dm, const BlockMesh *mesh, PetscInt n_edges,
                                 const PetscInt *edge_vertices, const PetscInt *block_edges)
{
  const PetscInt nb = mesh->n_blocks, nv = mesh->n_vertices;
  PetscInt *cone, *orientation, at = 0;
  PetscFunctionBeginUser;
  PetscCall(DMPlexSetChart(dm, 0, nb + nv + n_edges));
  for (PetscInt b = 0; b < nb; b++) PetscCall(DMPlexSetConeSize(dm, b, mesh->blocks[4 * b + 3] < 0 ? 3 : 4));
  for (PetscInt e = 0; e < n_edges; e++) PetscCall(DMPlexSetConeSize(dm, nb + nv + e, 2));
  PetscCall(DMSetUp(dm));
  PetscCall(DMPlexGetCones(dm, &cone));
  PetscCall(DMPlexGetConeOrientations(dm, &orientation));
  for (PetscInt b = 0; b < nb; b++) {
    for (PetscInt k = 0; k < (mesh->blocks[4 * b + 3] < 0 ? 3 : 4); k++, at++) {
      // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): with blocks there are edges
      const PetscInt e = block_edges[4 * b + k];
      cone[at] = nb + nv + (e >= 0 ? e : -(e + 1));
      orientation[at] = e >= 0 ? 0 : -1;
    }
  }
  for (PetscInt i = 0; i < 2 * n_edges; i++, at++) {
    cone[at] = nb + edge_vertices[i];
    orientation[at] = 0;
  }
  PetscCall(DMPlexSymmetrize(dm));
  PetscCall(DMPlexStratify(dm));
  for (PetscInt b = 0; b < nb; b++)
    PetscCall(DMPlexSetCellType(
        dm, b, mesh->blocks[4 * b + 3] < 0 ? DM_POLYTOPE_TRIANGLE : DM_POLYTOPE_QUADRILATERAL));
  for (PetscInt v = 0; v < nv; v++) PetscCall(DMPlexSetCellType(dm, nb + v, DM_POLYTOPE_POINT));
  for (PetscInt e = 0; e < n_edges; e++) PetscCall(DMPlexSetCellType(dm, nb + nv + e, DM_POLYTOPE_SEGMENT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode plex_coordinates(DM dm, const BlockMesh *mesh)
{
  const PetscInt nb = mesh->n_blocks, nv = mesh->n_vertices;
  PetscSection section;
  DM cdm;
  Vec coordinates;
  PetscReal *x;
  PetscFunctionBeginUser;
  PetscCall(DMSetCoordinateDim(dm, 2));
  PetscCall(DMGetCoordinateDM(dm, &cdm));
  PetscCall(DMGetCoordinateSection(dm, &section));
  PetscCall(PetscSectionSetNumFields(section, 1));
  PetscCall(PetscSectionSetFieldComponents(section, 0, 2));
  PetscCall(PetscSectionSetChart(section, nb, nb + nv));
  for (PetscInt v = nb; v < nb + nv; v++) {
    PetscCall(PetscSectionSetDof(section, v, 2));
    PetscCall(PetscSectionSetFieldDof(section, v, 0, 2));
  }
  PetscCall(PetscSectionSetUp(section));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2 * nv, &coordinates));
  PetscCall(PetscObjectSetName((PetscObject)coordinates, "coordinates"));
  PetscCall(VecSetBlockSize(coordinates, 2));
  PetscCall(VecGetArray(coordinates, &x));
  PetscCall(PetscArraycpy(x, mesh->X, 2 * nv));
  PetscCall(VecRestoreArray(coordinates, &x));
  PetscCall(DMSetCoordinatesLocal(dm, coordinates));
  PetscCall(VecDestroy(&coordinates));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One label per face set, made on all ranks in the same order. */
static PetscErrorCode plex_labels(DM dm, const BlockMesh *mesh, const PetscInt *block_edges)
{
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < mesh->n_face_sets; s++) {
    DMLabel label;
    PetscCall(DMCreateLabel(dm, mesh->face_set_names[s]));
    PetscCall(DMGetLabel(dm, mesh->face_set_names[s], &label));
    for (PetscInt i = 0; mesh->n_blocks && i < mesh->face_sets[s].n; i++) {
      const PetscInt *face = mesh->face_sets[s].faces + 2 * i;
      // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): with blocks there are edges
      const PetscInt e = block_edges[4 * face[0] + face[1]];
      PetscCall(DMLabelSetValue(label, mesh->n_blocks + mesh->n_vertices + (e >= 0 ? e : -(e + 1)), 1));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What each point of the whole mesh is (rank 0). */
static PetscErrorCode fill_records(const BlockMesh *mesh, const BodyNumbers *bodies, PetscInt n_edges,
                                   const PetscInt *block_edges, PointRecord *r)
{
  const PetscInt nb = mesh->n_blocks, nv = mesh->n_vertices;
  PetscInt *uses;
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < nv; v++)
    r[nb + v] = (PointRecord){
        .gid = v, .file = mesh->vertex_file[v], .rigid = -1, .condensed = -1, .inner = bodies->inner[v]};
  PetscCall(PetscCalloc1(n_edges, &uses));
  for (PetscInt e = 0; e < n_edges; e++) r[nb + nv + e] = (PointRecord){.gid = -1, .file = -1};
  for (PetscInt b = 0; b < nb; b++) {
    r[b] = (PointRecord){.gid = b,
                         .file = mesh->block_file[b],
                         .group = mesh->block_group[b],
                         .body = mesh->body[b],
                         .rigid = bodies->rigid[b],
                         .condensed = bodies->condensed[b]};
    for (PetscInt k = 0; k < 4 && mesh->blocks[4 * b + k] >= 0; k++) {
      PointRecord *vertex = r + nb + mesh->blocks[4 * b + k];
      const PetscInt e = block_edges[4 * b + k], edge = e >= 0 ? e : -(e + 1);
      vertex->body = mesh->body[b];
      if (bodies->rigid[b] >= 0) vertex->rigid = bodies->rigid[b];
      if (bodies->condensed[b] >= 0) vertex->condensed = bodies->condensed[b];
      uses[edge]++;
      // an outer face is known by its block and its place in it; an inner one has no number
      r[nb + nv + edge].gid = uses[edge] == 1 ? 4 * b + k : -1;
    }
  }
  PetscCall(PetscFree(uses));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives DMPlex our parts. */
static PetscErrorCode set_partition(DM dm, const BlockMesh *mesh)
{
  PetscPartitioner partitioner;
  PetscMPIInt size;
  PetscInt *sizes, *points, *offset;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)dm), &size));
  PetscCall(PetscCalloc3(size, &sizes, size + 1, &offset, mesh->n_blocks, &points));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) sizes[mesh->part[b]]++;
  for (PetscMPIInt p = 0; p < size; p++) offset[p + 1] = offset[p] + sizes[p];
  for (PetscInt b = 0; b < mesh->n_blocks; b++) points[offset[mesh->part[b]]++] = b;
  PetscCall(DMPlexGetPartitioner(dm, &partitioner));
  PetscCall(PetscPartitionerSetType(partitioner, PETSCPARTITIONERSHELL));
  PetscCall(PetscPartitionerShellSetPartition(partitioner, size, sizes, points));
  PetscCall(PetscFree3(sizes, offset, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends records along the migration SF of the distribution. */
static PetscErrorCode migrate_records(PetscSF migration, PetscInt n_new, const PointRecord *old,
                                      PointRecord **records)
{
  MPI_Datatype unit;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n_new, records));
  PetscCallMPI(MPI_Type_contiguous(sizeof(PointRecord) / sizeof(PetscInt), MPIU_INT, &unit));
  PetscCallMPI(MPI_Type_commit(&unit));
  PetscCall(PetscSFBcastBegin(migration, unit, old, *records, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(migration, unit, old, *records, MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mesh as mesh->part says, with one layer of overlap. */
static PetscErrorCode distribute(MPI_Comm comm, const BlockMesh *mesh, const BodyNumbers *bodies, DM *plex,
                                 PointRecord **records)
{
  PetscInt n_edges = 0, *edge_vertices = NULL, *block_edges = NULL, p_end;
  PointRecord *old;
  PetscMPIInt rank;
  PetscSF migration = NULL;
  DM dm, distributed = NULL;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(DMCreate(comm, &dm));
  PetscCall(DMSetType(dm, DMPLEX));
  PetscCall(DMPlexDistributeSetDefault(dm, PETSC_FALSE));
  PetscCall(DMSetDimension(dm, 2));
  if (rank == 0) PetscCall(MeshEdges(mesh, &n_edges, &edge_vertices, &block_edges));
  PetscCall(plex_cones(dm, mesh, n_edges, edge_vertices, block_edges));
  PetscCall(plex_coordinates(dm, mesh));
  PetscCall(plex_labels(dm, mesh, block_edges));
  PetscCall(PetscMalloc1(mesh->n_blocks + mesh->n_vertices + n_edges, &old));
  if (rank == 0) PetscCall(fill_records(mesh, bodies, n_edges, block_edges, old));

  // vertex adjacency, one layer: every element that touches an owned vertex
  PetscCall(DMSetBasicAdjacency(dm, PETSC_FALSE, PETSC_TRUE));
  PetscCall(set_partition(dm, mesh));
  PetscCall(DMPlexDistribute(dm, 1, &migration, &distributed));
  if (distributed) {
    PetscCall(DMPlexGetChart(distributed, NULL, &p_end));
    PetscCall(migrate_records(migration, p_end, old, records));
    PetscCall(PetscSFDestroy(&migration));
    PetscCall(PetscFree(old));
    PetscCall(DMDestroy(&dm));
    *plex = distributed;
  } else {
    *records = old;
    *plex = dm;
  }
  PetscCall(PetscFree(edge_vertices));
  PetscCall(PetscFree(block_edges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers that describe the whole mesh, from rank 0; bodies are numbered there on the way. */
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
  m->diameter = measure[0], m->contact_margin = measure[1];
  if (!m->rank) {
    PetscCall(MeshConnected(mesh, mesh->group_rigid, &bodies->n_rigid, &bodies->rigid));
    PetscCall(MeshCondensed(scene, mesh, m->contact_margin, bodies));
  }
  PetscInt n[5] = {mesh->n_vertices, mesh->n_blocks, mesh->n_bodies, bodies->n_rigid, bodies->n_condensed};
  PetscCallMPI(MPI_Bcast(n, 5, MPIU_INT, 0, m->comm));
  m->n_vertices_global = n[0], m->n_blocks_global = n[1], m->n_bodies_global = n[2];
  m->n_rigid_global = n[3], m->n_condensed_global = n[4];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshDistribute(const Scene *scene, BlockMesh *mesh, Model *m, DM *plex, PointRecord **records)
{
  BodyNumbers bodies = {0};
  PetscFunctionBeginUser;
  PetscCall(describe_mesh(scene, mesh, &bodies, m));
  PetscCall(PartBegin(PART_PARTITION));
  if (!m->rank && !mesh->part) {
    PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->part));
    PetscCall(PartitionBlocks(mesh, &bodies, scene->partition, m->contact_margin, m->size, mesh->part, NULL));
  }
  PetscCall(PartEnd(PART_PARTITION));
  PetscCall(distribute(m->comm, mesh, &bodies, plex, records));
  PetscCall(PetscFree(bodies.rigid));
  PetscCall(PetscFree(bodies.condensed));
  PetscCall(PetscFree(bodies.inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

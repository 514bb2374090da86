/* mesh_checksum.c: computes one number from all data of a renumbered mesh. */
#include "mesh/mesh.h"

uint64_t MeshChecksum(const BlockMesh *b)
{
  uint64_t h = HashBytes(0, b->X, 2 * (size_t)b->n_vertices * sizeof(PetscReal));
  const PetscInt nb = b->n_blocks;
  h = HashBytes(h, b->blocks, 4 * (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->block_group, (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->block_file, (size_t)nb * sizeof(PetscInt));
  h = HashBytes(h, b->group_rigid, (size_t)b->n_groups * sizeof(PetscInt));
  for (PetscInt g = 0; g < b->n_groups; g++) h = HashBytes(h, b->group_names[g], strlen(b->group_names[g]));
  for (PetscInt s = 0; s < b->n_face_sets; s++) {
    h = HashBytes(h, b->face_sets[s].name, strlen(b->face_sets[s].name));
    h = HashBytes(h, b->face_sets[s].faces, 2 * (size_t)b->face_sets[s].n * sizeof(PetscInt));
  }
  return HashBytes(h, b->point_vertex, (size_t)b->n_points * sizeof(PetscInt));
}

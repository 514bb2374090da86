/* A small mesh with one of everything: body 0 of a quadrilateral and a triangle, body 1 of one quadrilateral.

         4
        / \         blocks 0: 0 1 2 3   1: 3 2 4   2: 5 6 7 8
      3-----2 8---7
      |  0  | | 2 |     vertices 1 and 5, 2 and 8 are at the same places
      0-----1 5---6 */
#pragma once
#include "motion/motion.h"
#include <string.h>

enum { SMALL_VERTICES = 9, SMALL_BLOCKS = 3, SMALL_GROUPS = 2, SMALL_SETS = 2, SMALL_POINTS = 2 };

static const PetscReal small_X[2 * SMALL_VERTICES] = {0, 0, 1, 0, 1, 1, 0, 1, 0.5, 2, 1, 0, 2, 0, 2, 1, 1, 1};
static const PetscInt small_blocks[4 * SMALL_BLOCKS] = {0, 1, 2, 3, 3, 2, 4, -1, 5, 6, 7, 8};
static const PetscInt small_block_group[SMALL_BLOCKS] = {0, 0, 1};
static const char *const small_groups[SMALL_GROUPS] = {"stone", "bed-rock_2"};
static const PetscInt small_rigid[SMALL_GROUPS] = {0, 1};
/* alphabetical, as a file gives them */
static const char *const small_sets[SMALL_SETS] = {"base", "joint"};
static const PetscInt small_set_n[SMALL_SETS] = {3, 2};
static const PetscInt small_faces[SMALL_SETS][6] = {{2, 0, 0, 0, 1, 2}, {0, 1, 2, 3}};
static const char *const small_points[SMALL_POINTS] = {"corner", "crest"};
static const PetscInt small_point_vertex[SMALL_POINTS] = {6, 4};

static inline PetscErrorCode CopyInts(PetscInt n, const PetscInt *from, PetscInt **to)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, to));
  PetscCall(PetscArraycpy(*to, from, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode CopyNames(PetscInt n, const char *const *from, char (**to)[NAME_LENGTH])
{
  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, to));
  for (PetscInt i = 0; i < n; i++) PetscCall(PetscStrncpy((*to)[i], from[i], NAME_LENGTH));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertices and blocks only: no groups, sets or points. */
static inline PetscErrorCode BareMesh(PetscInt n_vertices, const PetscReal *X, PetscInt n_blocks,
                                      const PetscInt *blocks, BlockMesh *mesh)
{
  PetscFunctionBegin;
  *mesh = (BlockMesh){.n_vertices = n_vertices, .n_blocks = n_blocks};
  PetscCall(PetscMalloc1(2 * n_vertices, &mesh->X));
  PetscCall(PetscArraycpy(mesh->X, X, 2 * n_vertices));
  PetscCall(CopyInts(4 * n_blocks, blocks, &mesh->blocks));
  PetscCall(PetscCalloc1(n_blocks, &mesh->block_group));
  PetscCall(PetscMalloc1(n_blocks, &mesh->block_file));
  PetscCall(PetscMalloc1(n_vertices, &mesh->vertex_file));
  for (PetscInt b = 0; b < n_blocks; b++) mesh->block_file[b] = b;
  for (PetscInt v = 0; v < n_vertices; v++) mesh->vertex_file[v] = v;
  PetscCall(MeshBodies(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode SmallMesh(BlockMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(BareMesh(SMALL_VERTICES, small_X, SMALL_BLOCKS, small_blocks, mesh));
  PetscCall(PetscArraycpy(mesh->block_group, small_block_group, SMALL_BLOCKS));
  mesh->n_groups = SMALL_GROUPS;
  mesh->n_face_sets = SMALL_SETS;
  mesh->n_points = SMALL_POINTS;
  PetscCall(CopyNames(SMALL_GROUPS, small_groups, &mesh->group_names));
  PetscCall(CopyNames(SMALL_SETS, small_sets, &mesh->face_set_names));
  PetscCall(CopyNames(SMALL_POINTS, small_points, &mesh->point_names));
  PetscCall(CopyInts(SMALL_GROUPS, small_rigid, &mesh->group_rigid));
  PetscCall(CopyInts(SMALL_POINTS, small_point_vertex, &mesh->point_vertex));
  PetscCall(PetscCalloc1(SMALL_SETS, &mesh->face_sets));
  for (PetscInt s = 0; s < SMALL_SETS; s++) {
    PetscCall(PetscStrncpy(mesh->face_sets[s].name, small_sets[s], NAME_LENGTH));
    mesh->face_sets[s].n = small_set_n[s];
    PetscCall(CopyInts(2 * small_set_n[s], small_faces[s], &mesh->face_sets[s].faces));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

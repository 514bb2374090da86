/* joint_turns.c: decides which row of the joints table counts where face sets of several rows share a face. A
   set within another one counts before it, as lift_3 does before lift; else the order of the scene counts. */
#include "model/model.h"
#include <string.h>

/* The face set of a row of the joints table: numbers of faces (4 * block + k), ascending; n = 0: no face
   set. */
typedef struct {
  PetscInt n, *face;
} RowFaces;

/* Finds whether all faces of a are faces of b, which has more. */
static PetscErrorCode is_within(const RowFaces *a, const RowFaces *b, PetscBool *within)
{
  PetscInt at = 0;
  PetscFunctionBeginUser;
  *within = (PetscBool)(a->n > 0 && a->n < b->n);
  for (PetscInt i = 0; i < a->n && *within; i++) {
    PetscCall(PetscFindInt(a->face[i], b->n, b->face, &at));
    *within = (PetscBool)(at >= 0);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Fills the faces of a row from the face set that has its name. */
static PetscErrorCode fill_row(const BlockMesh *mesh, const char *name, RowFaces *row)
{
  PetscFunctionBeginUser;
  for (const FaceSet *set = mesh->face_sets; set < mesh->face_sets + mesh->n_face_sets; set++) {
    if (strcmp(set->name, name) != 0) continue;
    row->n = set->n;
    PetscCall(PetscMalloc1(row->n, &row->face));
    for (PetscInt i = 0; i < row->n; i++) row->face[i] = 4 * set->faces[2 * i] + set->faces[2 * i + 1];
    PetscCall(PetscSortInt(row->n, row->face));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JointTurns(const Scene *scene, const BlockMesh *mesh, Model *m)
{
  const PetscInt n = scene->n_joints;
  PetscInt *order; // rows by their turn
  RowFaces *row;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(n, &m->materials.joint_turn));
  PetscCall(PetscCalloc2(n, &order, n, &row));
  for (PetscInt j = 1; j < n && !m->rank; j++) {
    PetscInt at = 1;
    PetscBool within = PETSC_FALSE;
    PetscCall(fill_row(mesh, scene->joints[j].name, row + j));
    for (; at < j && !within; at += !within) PetscCall(is_within(row + j, row + order[at], &within));
    for (PetscInt k = j; k > at; k--) order[k] = order[k - 1];
    order[at] = j;
  }
  for (PetscInt t = 0; t < n && !m->rank; t++) m->materials.joint_turn[order[t]] = t;
  for (PetscInt j = 1; j < n; j++) PetscCall(PetscFree(row[j].face));
  PetscCall(PetscFree2(order, row));
  PetscCallMPI(MPI_Bcast(m->materials.joint_turn, (PetscMPIInt)n, MPIU_INT, 0, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* bodies.c: finds which rigid or condensed body a block belongs to, and which vertices of a condensed body
   are kept. Rank 0. */
#include "mesh/mesh.h"

PetscErrorCode MeshConnected(const BlockMesh *mesh, const PetscInt *chosen, PetscInt *n_bodies,
                             PetscInt **body)
{
  PetscInt *start, *blocks, *stack, *id;
  PetscFunctionBeginUser;
  PetscCall(MeshVertexBlocks(mesh, &start, &blocks));
  PetscCall(PetscMalloc1(mesh->n_blocks, &stack));
  PetscCall(PetscMalloc1(mesh->n_blocks, &id));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) id[b] = -1;
  *n_bodies = 0;
  for (PetscInt first = 0; first < mesh->n_blocks; first++) {
    PetscInt depth = 0;
    if (id[first] >= 0 || !chosen[mesh->block_group[first]]) continue;
    stack[depth++] = first;
    id[first] = (*n_bodies)++;
    while (depth) { // takes in all chosen blocks that are connected by vertices
      const PetscInt *ring = mesh->blocks + 4 * stack[--depth];
      for (int k = 0; k < 4 && ring[k] >= 0; k++)
        for (PetscInt i = start[ring[k]]; i < start[ring[k] + 1]; i++) {
          const PetscInt other = blocks[i];
          if (id[other] >= 0 || !chosen[mesh->block_group[other]]) continue;
          id[other] = id[first];
          stack[depth++] = other;
        }
    }
  }
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(blocks));
  PetscCall(PetscFree(stack));
  *body = id;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void keep_face(const BlockMesh *mesh, PetscInt b, PetscInt k, PetscBool *inner)
{
  const PetscInt *block = mesh->blocks + 4 * b, n = block[3] < 0 ? 3 : 4;
  inner[block[k]] = inner[block[(k + 1) % n]] = PETSC_FALSE;
}

typedef struct {
  const BlockMesh *mesh;
  const PetscInt *faces; /* (n,2) block, k */
} NearContext;

static PetscBool share_no_vertex(PetscInt f, PetscInt g, const void *context)
{
  const NearContext *near = context;
  const PetscInt *face[2] = {near->faces + 2 * f, near->faces + 2 * g};
  PetscInt end[2][2];
  for (int i = 0; i < 2; i++) {
    const PetscInt *block = near->mesh->blocks + 4 * face[i][0];
    for (int k = 0; k < 2; k++) end[i][k] = block[(face[i][1] + k) % (block[3] < 0 ? 3 : 4)];
  }
  return (PetscBool)(end[0][0] != end[1][0] && end[0][0] != end[1][1] && end[0][1] != end[1][0] &&
                     end[0][1] != end[1][1]);
}

/* Keeps the vertices of faces near each other, where contacts may be, and of face sets that are joints, where
   contacts may come. */
static PetscErrorCode keep_joints(const Scene *scene, const BlockMesh *mesh, PetscReal margin,
                                  PetscBool *inner)
{
  PetscInt n_faces, *faces, *start, *near;
  PetscReal *box;
  PetscFunctionBeginUser;
  PetscCall(MeshOuterBoxes(mesh, margin, &n_faces, &faces, &box));
  PetscCall(GridRows(n_faces, box, share_no_vertex, &(NearContext){mesh, faces}, &start, &near));
  for (PetscInt f = 0; f < n_faces; f++)
    if (start[f + 1] > start[f]) keep_face(mesh, faces[2 * f], faces[2 * f + 1], inner);
  PetscCall(PetscFree(box));
  PetscCall(PetscFree(start));
  PetscCall(PetscFree(near));
  PetscCall(PetscFree(faces));
  for (PetscInt s = 0; s < mesh->n_face_sets; s++)
    for (PetscInt j = 1; j < scene->n_joints; j++)
      for (PetscInt i = 0;
           !strcmp(scene->joints[j].name, mesh->face_sets[s].name) && i < mesh->face_sets[s].n; i++)
        keep_face(mesh, mesh->face_sets[s].faces[2 * i], mesh->face_sets[s].faces[2 * i + 1], inner);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode keep_block(const BlockMesh *mesh, PetscInt b, void *context)
{
  PetscBool *inner = context;
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < BlockCorners(mesh->blocks + 4 * b); k++)
    inner[mesh->blocks[4 * b + k]] = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the vertices of the blocks on which anchors act. */
static PetscErrorCode keep_anchors(const Scene *scene, const BlockMesh *mesh, PetscBool *inner)
{
  PetscInt n;
  const Anchor *anchors = SceneEntries(scene, "anchors", &n);
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) PetscCall(LocateAnchor(mesh, anchors + i, keep_block, inner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void keep_set(const BlockMesh *mesh, const char *name, PetscBool *inner)
{
  for (const FaceSet *set = mesh->face_sets; set < mesh->face_sets + mesh->n_face_sets; set++)
    for (PetscInt i = 0; !strcmp(set->name, name) && i < set->n; i++)
      keep_face(mesh, set->faces[2 * i], set->faces[2 * i + 1], inner);
}

/* Keeps vertices that have dashpots, a prescribed motion, a force in histories, or added mass in time: at
   supports, and at faces under water that moves. */
static void keep_in_time(const Scene *scene, const BlockMesh *mesh, PetscBool *inner)
{
  for (const Support *s = scene->supports; s < scene->supports + scene->n_supports; s++)
    keep_set(mesh, s->target, inner);
  for (const Load *load = scene->loads; load < scene->loads + scene->n_loads; load++)
    if (load->kind == LOAD_ADDED_MASS) keep_set(mesh, load->target, inner);
}

PetscErrorCode MeshCondensed(const Scene *scene, const BlockMesh *mesh, PetscReal margin, BodyNumbers *bodies)
{
  PetscInt *chosen;
  PetscBool *inner, *calm;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(mesh->n_groups, &chosen));
  for (PetscInt g = 0; g < mesh->n_groups; g++) chosen[g] = scene->materials[g].condensed > 0;
  PetscCall(MeshConnected(mesh, chosen, &bodies->n_condensed, &bodies->condensed));
  PetscCall(PetscFree(chosen));
  PetscCall(PetscCalloc1(mesh->n_vertices, &inner));
  for (int pass = 0; pass < 2; pass++) // a vertex that other blocks share is kept
    for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
      if (mesh->blocks[i] >= 0 && (bodies->condensed[i / 4] < 0) == pass)
        inner[mesh->blocks[i]] = (PetscBool)!pass;
  if (bodies->n_condensed) PetscCall(keep_joints(scene, mesh, margin, inner));
  if (bodies->n_condensed) PetscCall(keep_anchors(scene, mesh, inner));
  PetscCall(PetscMalloc1(mesh->n_vertices, &calm));
  PetscCall(PetscArraycpy(calm, inner, mesh->n_vertices)); // vertices kept from here on touch no contact
  if (bodies->n_condensed && SceneVibrates(scene)) keep_in_time(scene, mesh, inner);
  for (PetscInt p = 0; p < mesh->n_points; p++) inner[mesh->point_vertex[p]] = PETSC_FALSE;
  bodies->inner = inner, bodies->calm = calm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* supports.c: finds the degrees of freedom that supports hold. */
#include "boundary/boundary.h"

typedef struct {
  PetscInt count[2];         /* number of vertices held in x, in y */
  PetscReal low[2], high[2]; /* range of the other coordinate, for x and y */
} BodyHold;

static void hold_vertex(const Support *s, Model *m, PetscInt v, BodyHold *body)
{
  if (v < 0 || v >= m->mesh.n_owned) return;
  for (int i = 0; i < 2; i++) {
    if (!s->fix[i]) continue;
    if (v < m->mesh.n_deformable || v >= m->mesh.n_moving) {
      m->support[3 * m->rigid.n + 2 * v + i] = (int16_t)s->row;
    } else {
      BodyHold *h = body + RigidOfVertex(m, v);
      const PetscReal across = m->mesh.X[2 * v + 1 - i];
      h->low[i] = h->count[i] ? PetscMin(h->low[i], across) : across;
      h->high[i] = h->count[i] ? PetscMax(h->high[i], across) : across;
      h->count[i]++;
    }
  }
}

static void hold_target(const Support *s, Model *m, BodyHold *body)
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, s->target, &n),
                 point = NameRow(m->mesh.n_points, m->mesh.point_names, s->target);
  if (NameRow(m->mesh.n_face_sets, m->mesh.face_set_names, s->target) >= 0) {
    for (PetscInt i = 0; i < n; i++)
      for (int k = 0; k < 2; k++) hold_vertex(s, m, m->faces.vertex[2 * faces[i] + k], body);
  } else if (point >= 0) {
    hold_vertex(s, m, m->mesh.point_vertex[point], body);
  } else {
    for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
      for (PetscInt e = 0; e < list->n; e++) {
        if (strcmp(m->materials.names[list->group[e]], s->target)) continue;
        for (PetscInt k = 0; k < list->n_nodes; k++) hold_vertex(s, m, VertexOf(list, e, k), body);
      }
  }
}

/* Holds rigid bodies. Only the range of the held places counts, since a vertex may be in several faces of
   a set. A body whose held vertices lie apart across the direction cannot rotate. A body held at one place
   could rotate about it, which three dofs at the centroid cannot express, so it is refused. */
static PetscErrorCode hold_bodies(const Scene *scene, const Support *s, Model *m, const BodyHold *body)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    PetscBool turns = PETSC_TRUE, any = PETSC_FALSE;
    for (int i = 0; i < 2; i++) {
      if (!body[b].count[i]) continue;
      any = PETSC_TRUE;
      m->support[3 * b + i] = (int16_t)s->row;
      if (body[b].high[i] - body[b].low[i] > 1e-9 * m->mesh.diameter) turns = PETSC_FALSE;
    }
    if (any && !turns) m->support[3 * b + 2] = (int16_t)s->row;
    if (any && turns && !message[0])
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s: supports.%s.target: \"%s\" holds the rigid body with block vertex %" PetscInt_FMT
          " at one place only, about which it could turn: expected its group, or faces that span it",
          scene->file, s->name, s->target, m->mesh.vertex_file[m->rigid.start[b]]));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Holds vertices without a block that is built. */
static PetscErrorCode hold_absent(Model *m)
{
  bool *there;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &there));
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt k = 0; k < list->n_nodes && !m->materials.absent[list->group[e]]; k++)
        there[VertexOf(list, e, k)] = true;
  for (PetscInt d = 0; d < 2 * m->mesh.n_owned; d++)
    if (!there[d / 2]) m->support[3 * m->rigid.n + d] = NOT_BUILT;
  PetscCall(PetscFree(there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportsApply(const Scene *scene, PetscBool in_time, Model *m)
{
  const PetscInt n = 3 * m->rigid.n + 2 * m->mesh.n_owned;
  BodyHold *body;
  PetscFunctionBeginUser;
  PetscCheck(scene->n_supports < NOT_BUILT, m->comm, PETSC_ERR_SUP, "more than %d supports", NOT_BUILT - 1);
  PetscCall(PetscMalloc1(m->rigid.n, &body));
  for (PetscInt d = 0; d < n; d++) m->support[d] = -1;
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    if (in_time && scene->supports[i].boundary != BOUNDARY_FIXED) continue;
    PetscCall(PetscArrayzero(body, m->rigid.n));
    hold_target(scene->supports + i, m, body);
    PetscCall(hold_bodies(scene, scene->supports + i, m, body));
  }
  PetscCall(PetscFree(body));
  if (m->materials.absent) PetscCall(hold_absent(m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportsCheckMotion(const Scene *scene, const Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  const char *stage = NULL;
  PetscBool moves = (PetscBool)(m->mesh.n_condensed_global > 0); // condensed bodies vibrate inside
  PetscFunctionBeginUser;
  for (PetscInt i = scene->n_stages; i-- > 0;)
    if (StageInTime(scene->stages + i)) stage = scene->stages[i].name;
  for (PetscInt i = 0; i < scene->n_supports; i++)
    if (scene->supports[i].boundary != BOUNDARY_FIXED || scene->supports[i].motion[0]) moves = PETSC_TRUE;
  for (PetscInt d = 0; d < m->n_dof && !moves; d++) moves = (PetscBool)!Held(m, d);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPIU_BOOL, MPI_LOR, m->comm));
  if (stage && !moves)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: stages.%s: supports hold all blocks, so nothing sets its time step: "
                            "expected something that moves",
                            scene->file, stage));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

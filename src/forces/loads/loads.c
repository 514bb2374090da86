/* loads.c: dead loads: self-weight, tractions, point forces, ice. */
#include "forces/loads/loads.h"

/* A rigid block counts as one or two triangles, each with a third of its weight at each vertex, so that the
   resultant stays at the centroid of the block however the body turns. */
PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex)
{
  Model chosen = *m; // the same model, in which the other groups weigh nothing
  PetscReal *mass;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_groups, &chosen.density));
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &mass));
  for (PetscInt g = 0; g < m->n_groups; g++)
    chosen.density[g] = load->n_groups && NameRow(load->n_groups, load->groups, m->group_names[g]) < 0
                            ? 0.
                            : m->density[g];
  PetscCall(ElementMasses(&chosen, mass));
  for (const Elements *list = m->elements + DEFORMABLE_LISTS; list < m->elements + MOVING_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt triangle = 0; triangle < list->n_nodes - 2; triangle++) {
        PetscInt vertex[3];
        PetscReal area, centroid[2], polar;
        for (PetscInt k = 0; k < 3; k++) vertex[k] = VertexOf(list, e, k ? k + triangle : 0);
        BlockGeometry(m->X, vertex, 3, &area, centroid, &polar);
        for (int k = 0; k < 3; k++)
          mass[vertex[k]] += chosen.density[list->group[e]] * m->thickness * area / 3.;
      }
  for (PetscInt d = 0; d < 2 * m->n_owned; d++) f_vertex[d] += a[d % 2] * mass[d / 2];
  PetscCall(PetscFree(mass));
  PetscCall(PetscFree(chosen.density));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void traction(const Load *load, const Model *m, PetscReal *f_vertex)
{
  const PetscInt set = NameRow(m->n_face_sets, m->face_set_names, load->target);
  for (PetscInt i = m->face_set_start[set]; i < m->face_set_start[set + 1]; i++) {
    const PetscInt *v = m->faces.vertex + 2 * m->face_set_faces[i];
    PetscReal x[4], f[4];
    for (int k = 0; k < 4; k++) x[k] = m->X[2 * v[k / 2] + k % 2];
    const PetscReal half = 0.5 * m->thickness * PetscHypotReal(x[2] - x[0], x[3] - x[1]);
    for (int k = 0; k < 4; k++) f[k] = half * load->traction[k % 2];
    for (int k = 0; k < 4; k++)
      if (v[k / 2] < m->n_owned) f_vertex[2 * v[k / 2] + k % 2] += f[k];
  }
}

/* Which part of the way along a face of ice is the level, in the reference position, NaN: none. A face has
   its lower end, not its upper one: so one of the faces of a wall has the level, whatever its vertices. */
static PetscReal ice_at(const Load *load, const PetscReal x[4])
{
  const PetscReal low = PetscMin(x[1], x[3]), high = PetscMax(x[1], x[3]);
  return load->level >= low && load->level < high ? (load->level - x[1]) / (x[3] - x[1]) : NAN;
}

/* The force of the ice stays horizontal, at the point of the face where the ice was. Returns how many
   faces are at the level, of those whose first vertex this rank owns. f_vertex: NULL: only counts. */
static PetscInt ice(const Load *load, const Model *m, PetscReal *f_vertex)
{
  const PetscInt set = NameRow(m->n_face_sets, m->face_set_names, load->target);
  PetscInt n = 0;
  for (PetscInt i = m->face_set_start[set]; i < m->face_set_start[set + 1]; i++) {
    const PetscInt *v = m->faces.vertex + 2 * m->face_set_faces[i];
    PetscReal x[4];
    for (int k = 0; k < 4; k++) x[k] = m->X[2 * v[k / 2] + k % 2];
    const PetscReal at = ice_at(load, x), push = m->thickness * (x[3] < x[1] ? 1. : -1.) * load->traction[0];
    if (PetscIsNanReal(at)) continue;
    n += v[0] < m->n_owned;
    for (int k = 0; k < 2 && f_vertex; k++)
      if (v[k] < m->n_owned) f_vertex[2 * v[k]] += (k ? at : 1. - at) * push;
  }
  return n;
}

/* Refuses ice that meets no face, or more than one. */
static PetscErrorCode create(const TermView *v, void **memory)
{
  char message[MESSAGE_LENGTH] = "", key[LABEL_LENGTH];
  PetscFunctionBeginUser;
  *memory = NULL;
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *load = v->scene->loads + l;
    if (load->kind != LOAD_ICE) continue;
    PetscInt n = ice(load, v->m, NULL);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, v->m->comm));
    PetscCall(PetscSNPrintf(key, sizeof(key), "loads.%s.level", load->name));
    if (n != 1)
      Complain(message, v->scene->file, load->line, key,
               "%d faces of %s are at %g m: expected one, where the ice is below their upper end", (int)n,
               load->target, (double)load->level);
  }
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void point_force(const Load *load, const Model *m, PetscReal *f_vertex)
{
  const PetscInt v = m->point_vertex[NameRow(m->n_points, m->point_names, load->target)];
  for (int i = 0; i < 2 && v >= 0 && v < m->n_owned; i++)
    f_vertex[2 * v + i] += m->thickness * load->traction[i];
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f)
{
  const Load *load = v->scene->loads + row;
  const PetscReal g = v->scene->gravity, a[2] = {load->coefficient[0] * g, load->coefficient[1] * g};
  PetscFunctionBeginUser;
  if (load->kind == LOAD_SELF_WEIGHT) PetscCall(BodyForce(a, load, v->m, f));
  if (load->kind == LOAD_TRACTION) traction(load, v->m, f);
  if (load->kind == LOAD_POINT_FORCE) point_force(load, v->m, f);
  if (load->kind == LOAD_ICE) (void)ice(load, v->m, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Loads_term = {.name = "loads",
                             .create = create,
                             .loads = 1u << LOAD_SELF_WEIGHT | 1u << LOAD_TRACTION | 1u << LOAD_POINT_FORCE |
                                      1u << LOAD_ICE,
                             .applied = applied};

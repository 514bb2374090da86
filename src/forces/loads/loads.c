/* loads.c: dead loads: self-weight, tractions, point forces. */
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Loads_term = {.name = "loads",
                             .loads = 1u << LOAD_SELF_WEIGHT | 1u << LOAD_TRACTION | 1u << LOAD_POINT_FORCE,
                             .applied = applied};

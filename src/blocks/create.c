/* create.c: sets up what follows from blocks and materials: stiffness against hourglass modes, rigid
   bodies, true masses. */
#include "blocks/blocks.h"

static PetscErrorCode hourglass(const Scene *scene, Model *m)
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups; g++) {
    const Material *material = scene->materials + g;
    if (material->element == ELEMENT_FULL) continue;
    if (!m->materials.hourglass) PetscCall(PetscCalloc1(3 * m->materials.n_groups, &m->materials.hourglass));
    ElementHourglass(material->element, m->materials.lame[g], material->hourglass,
                     m->materials.hourglass + 3 * g);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks the dofs of the named groups, which enter the Rayleigh quotient of damping. If no group is named,
   in_quotient stays NULL and all dofs enter. */
static PetscErrorCode damping_groups(const Scene *scene, Model *m)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscFunctionBeginUser;
  if (!scene->n_damping_groups) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(m->n_dof, &m->in_quotient));
  for (PetscInt g = 0; g < scene->n_damping_groups; g++)
    for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
      for (PetscInt e = 0; e < list->n; e++) {
        if (strcmp(m->materials.names[list->group[e]], scene->damping_groups[g])) continue;
        for (PetscInt k = 0; k < list->n_nodes; k++) {
          const PetscInt v = VertexOf(list, e, k);
          if (v < m->mesh.n_deformable) m->in_quotient[at + 2 * v] = m->in_quotient[at + 2 * v + 1] = 1.;
          if (v < m->mesh.n_deformable || v >= m->mesh.n_moving) continue;
          for (int i = 0; i < 3; i++) m->in_quotient[3 * RigidOfVertex(m, v) + i] = 1.;
        }
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates and fills arrays of degrees of freedom: true mass, part in the damping quotient, and support.
   Supports are set later by supports.c. */
static PetscErrorCode fill_dofs(const Scene *scene, Model *m)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscReal *vertex_mass;
  PetscFunctionBeginUser;
  m->n_dof = at + 2 * m->mesh.n_deformable;
  const PetscInt n_entries = at + 2 * m->mesh.n_owned;
  PetscCall(PetscMalloc2(m->mesh.n_owned, &m->vertex_mass, n_entries, &m->support));
  for (PetscInt d = 0; d < n_entries; d++) m->support[d] = -1;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &vertex_mass));
  PetscCall(ElementMasses(m, vertex_mass));
  PetscCall(PetscArraycpy(m->vertex_mass, vertex_mass, m->mesh.n_owned));
  PetscCall(PetscFree(vertex_mass));
  PetscCall(damping_groups(scene, m));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BlocksCreate(const Scene *scene, Model *m)
{
  PetscFunctionBeginUser;
  PetscCall(TimerBegin(TIMER_MODEL));
  PetscCall(hourglass(scene, m));
  PetscCall(LawsCreate(scene, m));
  PetscCall(AtRestCreate(scene, m));
  PetscCall(RigidBodiesCreate(m));
  PetscCall(fill_dofs(scene, m));
  PetscCall(ElementChunksDone(m));
  PetscCall(TimerEnd(TIMER_MODEL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

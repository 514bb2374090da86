/* blocks_term.c: makes deformable blocks a force term. In a static stage their forces are computed chunk
   by chunk with the motion (cycle.c), not by this row. Rigid bodies are no term: no forces act within
   them. */
#include "blocks/blocks.h"

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)memory;
  PetscCall(ElementForces(at->m, at->u, f)); // (10)
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode bound(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k)
{
  PetscFunctionBeginUser;
  (void)memory, (void)anywhere;
  PetscCall(ElementStiffness(at->m, k)); // (28)
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode energy(const void *memory, const Instant *at, PetscReal *sum)
{
  const Model *m = at->m;
  PetscFunctionBeginUser;
  (void)memory;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + DEFORMABLE_LISTS; list++) {
    PetscReal *of_elements;
    PetscCall(PetscMalloc1(list->n, &of_elements));
    PetscCall(ElementEnergy(m, list, list->n_nodes, at->u, of_elements));
    for (PetscInt i = 0; i < list->n; i++) *sum += of_elements[i];
    PetscCall(PetscFree(of_elements));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the couplings of all elements, owned or not. */
static PetscErrorCode couplings(const Elements *e, TermAdd add, void *context)
{
  PetscInt vertices[4];
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < e->n; i++) {
    for (int v = 0; v < e->n_nodes; v++) vertices[v] = VertexOf(e, i, v);
    PetscCall(add(e->n_nodes, vertices, NULL, NULL, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stiffness of elements at u; NULL: in the reference configuration. */
static PetscErrorCode add_elements(const Model *m, const Elements *e, const PetscReal *u, TermAdd add,
                                   void *context)
{
  PetscReal k[4][64];
  PetscInt vertices[4];
  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < e->n; first += 4) {
    ElementMatrices(m, e, e->n_nodes, first, u, k);
    for (PetscInt i = first; i < PetscMin(first + 4, e->n); i++) {
      if (!e->owned[i]) continue; // another rank adds it
      for (int v = 0; v < e->n_nodes; v++) vertices[v] = VertexOf(e, i, v);
      PetscCall(add(e->n_nodes, vertices, k[i - first], NULL, context));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stiffness of the reference configuration in small strain, also in large strain: rotations and
   strains of a dam are below 1e-3, and so is the error. For a mechanism, which has only the stiffness from
   its rotation, and for modes it adds the tangent of large strain at u. */
static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  const Model *m = at->m;
  const PetscBool turns = (PetscBool)(kind == TANGENT_TURNED || kind == TANGENT_SMALL);
  const PetscReal *u = turns && m->materials.strain == STRAIN_LARGE ? at->u : NULL;
  PetscFunctionBeginUser;
  (void)memory;
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELASTIC_LISTS; list++) {
    if (kind == TANGENT_PATTERN)
      PetscCall(couplings(list, add, context));
    else
      PetscCall(add_elements(m, list, u, add, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Blocks_term = {.name = "blocks",
                              .phase = PHASE_BLOCKS,
                              .forces = forces,
                              .bound = bound,
                              .energy = energy,
                              .tangent = tangent};

/* blocks_term.c: deformable blocks as a force term. In a static stage their forces come chunk by chunk with
   the motion (cycle.c), and not through the row. Rigid bodies are no term: nothing acts within them. */
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
  for (const Elements *list = m->elements; list < m->elements + DEFORMABLE_LISTS; list++) {
    PetscReal *of_elements;
    PetscCall(PetscMalloc1(list->n, &of_elements));
    PetscCall(ElementEnergy(m, list, list->n_nodes, at->u, of_elements));
    for (PetscInt i = 0; i < list->n; i++) *sum += of_elements[i];
    PetscCall(PetscFree(of_elements));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Those of all elements, whichever rank adds them. */
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

/* u: NULL, the reference state. */
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

/* The stiffness is that of the reference state in small strain, also when strain is large: rotations and
   strains of a dam are 1e-3 of one and less, and so is the error. A mechanism has no other stiffness than
   that of what has turned, so there it is the one of large strain at u, and so it is for modes. */
static PetscErrorCode tangent(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                              void *context)
{
  const Model *m = at->m;
  const PetscBool turns = (PetscBool)(kind == TANGENT_TURNED || kind == TANGENT_SMALL);
  const PetscReal *u = turns && m->strain == STRAIN_LARGE ? at->u : NULL;
  PetscFunctionBeginUser;
  (void)memory;
  for (const Elements *list = m->elements; list < m->elements + ELASTIC_LISTS; list++) {
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

/* pressure.c: applies a uniform pressure normal to faces: of gas, a jack, grout or earth. */
#include "water/water.h"

/* Computes the forces on one face. context: [N/m] pressure times thickness, > 0: into the blocks. */
static void press(const PetscReal x[4], const void *context, PetscReal f[4])
{
  const PetscReal *push = context;
  for (int i = 0; i < 4; i++) f[i] = 0.;
  PushOnFace(x, 0.5, *push, f);
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f_vertex)
{
  const Load *load = v->scene->loads + row;
  const PetscReal factor = load->history[0] ? LoadSeries(load, v->state->time) : 1.;
  const PetscReal push = factor * load->traction[0] * v->m->materials.thickness;
  PetscFunctionBeginUser;
  PressOnFaces(v, load->target, press, &push, f_vertex);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Pressure_term = {
    .name = "pressure", .loads = 1u << LOAD_PRESSURE, .presses = PETSC_TRUE, .applied = applied};

/* at_rest.c: computes the initial strain of ground that is under stress before anything is built on it.

   Ground at rest under a level surface has the vertical stress s_v = -rho g (surface - y) and the
   horizontal stress k0 s_v. Weight alone, on elastic ground whose sides are held, gives nu/(1 - nu) s_v
   horizontally. The rest, d = (k0 - nu/(1 - nu)) s_v, acts from the start, as an initial strain of each
   block that is not in its displacements,

   e_xx = (1 - nu^2) d/E,   e_yy = -nu (1 + nu) d/E,

   which in plane strain is a stress d along x and none along y. So strain is computed from displacements
   relative to -e (x - x_c) of the block's vertices, as for blocks that were placed later (lifts.c). */
#include "blocks/blocks.h"

/* Computes the initial strain along x and y at a height y. */
static void strain_at(const Scene *scene, const Material *m, PetscReal y, PetscReal strain[2])
{
  const PetscReal nu = m->poisson, weight = -m->density * scene->gravity * PetscMax(m->surface - y, 0.),
                  d = (m->k0 - nu / (1. - nu)) * weight / m->young;
  strain[0] = (1. - nu * nu) * d, strain[1] = -nu * (1. + nu) * d;
}

PetscErrorCode AtRestCreate(const Scene *scene, Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups && !message[0]; g++) {
    const Material *material = scene->materials + g;
    if (PetscIsNanReal(material->k0)) continue;
    any = PETSC_TRUE;
    if (MaterialBody(material))
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s: materials.%s.k0: stress at rest is of blocks that deform by themselves, and these are %s",
          scene->file, material->name, MaterialBody(material)));
  }
  PetscCall(CheckMessage(m->comm, message));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  for (Elements *e = m->mesh.elements; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    PetscCall(PetscCalloc1(2 * (size_t)e->n_nodes * (size_t)e->n_padded, &e->placed));
  AtRest(scene, m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void AtRest(const Scene *scene, Model *m)
{
  for (Elements *e = m->mesh.elements; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    for (PetscInt b = 0; b < e->n; b++) {
      const Material *material = scene->materials + e->group[b];
      PetscReal strain[2], area, centre[2], polar;
      PetscInt vertices[4];
      if (PetscIsNanReal(material->k0)) continue;
      for (int k = 0; k < e->n_nodes; k++) vertices[k] = VertexOf(e, b, k);
      BlockGeometry(m->mesh.X, vertices, e->n_nodes, &area, centre, &polar);
      strain_at(scene, material, centre[1], strain);
      for (int k = 0; k < e->n_nodes; k++)
        for (int x = 0; x < 2; x++)
          e->placed[(size_t)x * (size_t)e->n_nodes * (size_t)e->n_padded + (size_t)VertexPlace(e, b, k)] -=
              strain[x] * (m->mesh.X[2 * vertices[k] + x] - centre[x]);
    }
}

PetscErrorCode AtRestDestroy(Model *m)
{
  PetscFunctionBeginUser;
  for (Elements *e = m->mesh.elements; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    PetscCall(PetscFree(e->placed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

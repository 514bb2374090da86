/* laws_setup.c: creates the histories of blocks with a material law, and refuses unsuitable blocks. */
#include "blocks/law_point.h"

/* Refuses a group that has a law and never deforms by itself. */
static PetscErrorCode check_group(const Scene *scene, const Material *material, char *message)
{
  const char *body = MaterialBody(material);
  PetscFunctionBeginUser;
  if (material->law == MATERIAL_ELASTIC || !body) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(
      message, MESSAGE_LENGTH,
      "%s: materials.%s.law: %s is for blocks that deform by themselves, and these are %s: expected elastic",
      scene->file, material->name, LawKinds[material->law].name, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* [Pa] stiffness against bending of absent blocks: negligible, but not 0, which would mean ELEMENT_FULL */
static const PetscReal NO_STIFFNESS = 1e-200;

void LawsPresent(const Model *m)
{
  for (const Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    for (PetscInt g = 0; g < m->materials.n_groups && e->history; g++) {
      PetscReal *c = e->history->constants + g * LAW_CONSTANTS * LANES;
      for (int lane = 0; lane < LANES; lane++) {
        c[LANES * LAW_LAMBDA + lane] = m->materials.lame[g].lambda,
                               c[LANES * LAW_MU + lane] = m->materials.lame[g].mu;
        for (int i = 0; i < 3 && m->materials.hourglass; i++) {
          PetscReal *at = c + LANES * (LAW_HOURGLASS + i) + lane;
          *at = i || m->materials.hourglass[3 * g] > 0. || !(*at > 0.) ? m->materials.hourglass[3 * g + i]
                                                                       : NO_STIFFNESS;
        }
      }
    }
}

static void fill_constants(const Material *material, const Model *m, PetscInt g, PetscReal *constants)
{
  PetscReal c[LAW_CONSTANTS] = {m->materials.lame[g].lambda, m->materials.lame[g].mu};
  for (int i = 0; i < 3 && m->materials.hourglass; i++)
    c[LAW_HOURGLASS + i] = m->materials.hourglass[3 * g + i];
  c[LAW_EXPANSION] = material->expansion, c[LAW_ACROSS] = material->free_across ? 0. : 1.;
  LawKinds[material->law].constants(material, m->materials.lame[g], c);
  for (int i = 0; i < LAW_CONSTANTS * LANES; i++) constants[g * LAW_CONSTANTS * LANES + i] = c[i / LANES];
}

/* Returns the largest width [m] of a block across a crack: from its least extent, which is normal to one
   of its sides; see WidthAcross. */
static PetscReal widest_across(const Model *m, const Elements *e, PetscInt block)
{
  const PetscReal *first = m->mesh.X + 2 * VertexOf(e, block, 0);
  PetscReal twice = 0., least = 0.5 * PETSC_MAX_REAL;
  for (int k = 0; k < e->n_nodes; k++) {
    const PetscReal *A = m->mesh.X + 2 * VertexOf(e, block, k),
                    *B = m->mesh.X + 2 * VertexOf(e, block, (k + 1) % e->n_nodes);
    const PetscReal side[2] = {B[0] - A[0], B[1] - A[1]};
    PetscReal most = 0.;
    for (int i = 0; i < e->n_nodes; i++) {
      const PetscReal *C = m->mesh.X + 2 * VertexOf(e, block, i);
      most = PetscMax(most, side[0] * (C[1] - A[1]) - side[1] * (C[0] - A[0]));
    }
    twice += (A[0] - first[0]) * side[1] - (A[1] - first[1]) * side[0];
    least = PetscMin(least, most / hypot(side[0], side[1]));
  }
  return (e->n_nodes == 3 ? 1. : 0.5) * twice / least;
}

/* Refuses blocks so wide that they would release more energy than the crack dissipates. */
static PetscErrorCode check_widths(const Scene *scene, const Model *m, const Elements *e, char *message)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < e->n && LawKinds[e->law].widest && !message[0]; i++) {
    const PetscReal *c = e->history->constants + e->group[i] * LAW_CONSTANTS * LANES;
    PetscReal own[LAW_CONSTANTS];
    for (int k = 0; k < LAW_CONSTANTS; k++) own[k] = c[LANES * k];
    const PetscReal most = LawKinds[e->law].widest(own), width = widest_across(m, e, i);
    if (width < most) continue;
    PetscCall(PetscSNPrintf(
        message, MESSAGE_LENGTH,
        "%s: materials.%s.fracture_energy: block %" PetscInt_FMT
        " is %.4g m wide across a crack, and as it breaks it would give back more energy than "
        "the crack takes: expected blocks of less than %.6g m, or more energy",
        scene->file, scene->materials[e->group[i]].name, e->file[i], (double)width, (double)most));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the history of one list, on all ranks, also where a rank has no block of it. */
static PetscErrorCode create_history(const Scene *scene, const Model *m, Elements *e)
{
  PetscBool any = PETSC_FALSE, full = PETSC_FALSE;
  LawHistory *h;
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups; g++) {
    if (scene->materials[g].law != e->law) continue;
    any = PETSC_TRUE;
    full = (PetscBool)(full || scene->materials[g].element == ELEMENT_FULL);
  }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&h));
  h->points = full && e->n_nodes == 4 ? 4 : 1, h->width = LawKinds[e->law].width;
  h->n = e->n_padded * h->points * h->width;
  for (PetscInt i = e->n; i < e->n_padded; i++)
    e->group[i] = e->group[e->n - 1]; // so padding has as many points
  PetscCall(PetscCalloc3(h->n, &h->committed, h->n, &h->now, h->n, &h->stable));
  PetscCall(PetscCalloc1(m->materials.n_groups * LAW_CONSTANTS * LANES, &h->constants));
  for (PetscInt g = 0; g < m->materials.n_groups; g++)
    if (scene->materials[g].law == e->law) fill_constants(scene->materials + g, m, g, h->constants);
  e->history = h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LawsCreate(const Scene *scene, Model *m)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < m->materials.n_groups && !message[0]; g++)
    PetscCall(check_group(scene, scene->materials + g, message));
  PetscCall(CheckMessage(m->comm, message));
  for (Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    PetscCall(create_history(scene, m, e));
  for (Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++)
    if (e->history) PetscCall(check_widths(scene, m, e, message));
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LawsFeel(const Elements *e, PetscInt load, const PetscReal *change, PetscReal *const *share)
{
  PetscFunctionBeginUser;
  if (!e->history) PetscFunctionReturn(PETSC_SUCCESS);
  LawHeat *heat = &e->history->heat;
  PetscCall(PetscRealloc((size_t)(heat->n + 1) * sizeof(*heat->change), &heat->change));
  PetscCall(PetscRealloc((size_t)(heat->n + 1) * sizeof(*heat->load), &heat->load));
  heat->change[heat->n] = change, heat->load[heat->n++] = load, heat->share = share;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LawsDestroy(Model *m)
{
  PetscFunctionBeginUser;
  for (Elements *e = m->mesh.elements + ELASTIC_LISTS; e < m->mesh.elements + DEFORMABLE_LISTS; e++) {
    if (!e->history) continue;
    PetscCall(PetscFree3(e->history->committed, e->history->now, e->history->stable));
    PetscCall(PetscFree(e->history->constants));
    PetscCall(PetscFree(e->history->heat.change));
    PetscCall(PetscFree(e->history->heat.load));
    PetscCall(PetscFree(e->history));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* loads.c: applies dead loads: self-weight, tractions, point forces, ice, loads on a crest. */
#include "loads/loads.h"

/* Computes the masses at vertices. A rigid block counts as one or two triangles, each with a third of its
   weight at each vertex, so that the resultant stays at the centroid of the block in any rotation. */
static PetscErrorCode mass_of(const Load *load, const Model *m, PetscReal *mass)
{
  Model chosen = *m; // a copy of the model in which other groups weigh nothing
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->materials.n_groups, &chosen.materials.density));
  for (PetscInt g = 0; g < m->materials.n_groups; g++)
    chosen.materials.density[g] = load->n_groups &&
                                          NameRow(load->n_groups, load->groups, m->materials.names[g]) < 0
                                      ? 0.
                                      : m->materials.density[g];
  PetscCall(ElementMasses(&chosen, mass));
  for (const Elements *list = m->mesh.elements + DEFORMABLE_LISTS; list < m->mesh.elements + MOVING_LISTS;
       list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (PetscInt triangle = 0; triangle < list->n_nodes - 2; triangle++) {
        PetscInt vertex[3];
        PetscReal area, centroid[2], polar;
        for (PetscInt k = 0; k < 3; k++) vertex[k] = VertexOf(list, e, k ? k + triangle : 0);
        BlockGeometry(m->mesh.X, vertex, 3, &area, centroid, &polar);
        for (int k = 0; k < 3; k++)
          mass[vertex[k]] += chosen.materials.density[list->group[e]] * m->materials.thickness * area / 3.;
      }
  PetscCall(PetscFree(chosen.materials.density));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void add_force(const PetscReal a[2], const PetscReal *mass, const Model *m, PetscReal *f_vertex)
{
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    f_vertex[2 * v] += a[0] * mass[v];
    f_vertex[2 * v + 1] += a[1] * mass[v];
  }
}

PetscErrorCode BodyForce(const PetscReal a[2], const Load *load, const Model *m, PetscReal *f_vertex)
{
  PetscReal *mass;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &mass));
  PetscCall(mass_of(load, m, mass));
  add_force(a, mass, m, f_vertex);
  PetscCall(PetscFree(mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the weight. memory: NULL, or (n_loads,) masses at vertices, computed at first use. Scenes with
   condensed bodies keep them: with follower water pressure all loads are summed again in each iteration of
   Newton's method, and the weight of the inner blocks would take longer than the rest. */
static PetscErrorCode weigh(const TermView *v, PetscInt row, const PetscReal a[2], PetscReal *f)
{
  PetscReal **kept = v->memory;
  PetscFunctionBeginUser;
  if (!kept) {
    PetscCall(BodyForce(a, v->scene->loads + row, v->m, f));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!kept[row]) {
    PetscCall(PetscCalloc1(v->m->mesh.n_vertices + DUMMY_VERTICES, kept + row));
    PetscCall(mass_of(v->scene->loads + row, v->m, kept[row]));
  }
  add_force(a, kept[row], v->m, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void traction(const TermView *v, const Load *load, PetscReal factor, PetscReal *f_vertex)
{
  const Model *m = v->m;
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, load->target, &n);
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt *at = m->faces.vertex + 2 * faces[i];
    PetscReal x[4], f[4];
    FaceCoordinates(m, NULL, faces[i], x);
    const PetscReal half = 0.5 * m->materials.thickness * PetscHypotReal(x[2] - x[0], x[3] - x[1]);
    for (int k = 0; k < 4; k++) f[k] = factor * half * load->traction[k % 2];
    LoadOnFaceKeep(v, faces[i], x, f);
    for (int k = 0; k < 4; k++)
      if (at[k / 2] < m->mesh.n_owned) f_vertex[2 * at[k / 2] + k % 2] += f[k];
  }
}

/* Returns the position along a face, in the reference configuration, of a line load: the level of ice, or
   the x of a load on a crest; NaN: not on this face. A face includes its lower or left end and excludes
   the other, so that exactly one face of a wall has the load. */
static PetscReal place_on(const Load *load, const PetscReal x[4])
{
  const int along = load->kind == LOAD_ICE ? 1 : 0;
  const PetscReal at = along ? load->level : load->at;
  const PetscReal low = PetscMin(x[along], x[2 + along]), high = PetscMax(x[along], x[2 + along]);
  return at >= low && at < high ? (at - x[along]) / (x[2 + along] - x[along]) : NAN;
}

/* Computes the force of a line load. Ice pushes horizontally into the face. */
static void line_force(const Load *load, const PetscReal x[4], PetscReal thickness, PetscReal force[2])
{
  force[0] = thickness * load->traction[0], force[1] = thickness * load->traction[1];
  if (load->kind == LOAD_ICE) force[0] *= x[3] < x[1] ? 1. : -1., force[1] = 0.;
}

/* Distributes the force to the ends of a face by the lever rule. Adds a couple across the face for the
   moment of a horizontal force above it. */
static void share_out(const Load *load, const PetscReal x[4], PetscReal thickness, PetscReal f[4])
{
  const PetscReal at = place_on(load, x), ex = x[2] - x[0], ey = x[3] - x[1];
  PetscReal force[2];
  line_force(load, x, thickness, force);
  const PetscReal pair = load->kind == LOAD_ICE ? 0. : -load->lever * force[0] / (ex * ex + ey * ey);
  for (int k = 0; k < 4; k++) f[k] = (k / 2 ? at : 1. - at) * force[k % 2];
  f[0] += pair * ey, f[1] -= pair * ex;
  f[2] -= pair * ey, f[3] += pair * ex;
}

/* Keeps a line load as a single force. */
static void keep_line(const TermView *v, const Load *load, PetscInt face, const PetscReal x[4])
{
  const PetscReal at = place_on(load, x), P[2] = {x[0] + at * (x[2] - x[0]), x[1] + at * (x[3] - x[1])},
                  lever = load->kind == LOAD_ICE ? 0. : load->lever;
  PetscReal force[4] = {0.};
  line_force(load, x, v->m->materials.thickness, force + 2);
  LoadOnFaceKeep(v, face, (PetscReal[4]){P[0], P[1], P[0], P[1] + lever}, force);
}

/* Adds a line load, which keeps its direction, at its material point of the face. Returns the number of
   faces with the load among those whose first vertex this rank owns. f_vertex NULL: only counts. */
static PetscInt line_load(const TermView *view, const Load *load, PetscReal *f_vertex)
{
  const Model *m = view->m;
  PetscInt n = 0, n_faces;
  const PetscInt *faces = FacesOfSet(m, load->target, &n_faces);
  for (PetscInt i = 0; i < n_faces; i++) {
    const PetscInt *v = m->faces.vertex + 2 * faces[i];
    PetscReal x[4], f[4];
    FaceCoordinates(m, NULL, faces[i], x);
    if (PetscIsNanReal(place_on(load, x))) continue;
    n += v[0] < m->mesh.n_owned;
    keep_line(view, load, faces[i], x);
    share_out(load, x, m->materials.thickness, f);
    for (int k = 0; k < 4 && f_vertex; k++)
      if (v[k / 2] < m->mesh.n_owned) f_vertex[2 * v[k / 2] + k % 2] += f[k];
  }
  return n;
}

/* Refuses a line load that meets no face, or more than one. */
static PetscErrorCode create(const TermView *v, void **memory)
{
  char message[MESSAGE_LENGTH] = "", key[LABEL_LENGTH];
  PetscFunctionBeginUser;
  *memory = NULL;
  if (v->m->mesh.n_condensed_global && !SceneBuilds(v->scene)) {
    PetscReal **kept;
    PetscCall(PetscCalloc1(v->scene->n_loads, &kept));
    *memory = kept;
  }
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    const Load *load = v->scene->loads + l;
    const PetscBool is_ice = (PetscBool)(load->kind == LOAD_ICE);
    if (!is_ice && load->kind != LOAD_CREST_LOAD) continue;
    PetscInt n = line_load(v, load, NULL);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, v->m->comm));
    PetscCall(PetscSNPrintf(key, sizeof(key), "loads.%s.%s", load->name, is_ice ? "level" : "at"));
    if (n != 1)
      Complain(message, v->scene->file, load->line, key,
               "%d faces of %s are at %g m: expected one, where the %s their %s end", (int)n, load->target,
               (double)(is_ice ? load->level : load->at), is_ice ? "ice is below" : "load is left of",
               is_ice ? "upper" : "right");
  }
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  PetscReal **kept = *memory;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; kept && l < scene->n_loads; l++) PetscCall(PetscFree(kept[l]));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void point_force(const Load *load, const Model *m, PetscReal factor, PetscReal *f_vertex)
{
  const PetscInt v = m->mesh.point_vertex[NameRow(m->mesh.n_points, m->mesh.point_names, load->target)];
  for (int i = 0; i < 2 && v >= 0 && v < m->mesh.n_owned; i++)
    f_vertex[2 * v + i] += factor * m->materials.thickness * load->traction[i];
}

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f)
{
  const Load *load = v->scene->loads + row;
  const PetscReal g = v->scene->gravity, a[2] = {load->coefficient[0] * g, load->coefficient[1] * g};
  const PetscReal factor = load->history[0] ? LoadSeries(load, v->state->time) : 1.;
  PetscFunctionBeginUser;
  if (load->kind == LOAD_SELF_WEIGHT) PetscCall(weigh(v, row, a, f));
  if (load->kind == LOAD_TRACTION) traction(v, load, factor, f);
  if (load->kind == LOAD_POINT_FORCE) point_force(load, v->m, factor, f);
  if (load->kind == LOAD_ICE || load->kind == LOAD_CREST_LOAD) (void)line_load(v, load, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Loads_term = {.name = "loads",
                             .create = create,
                             .destroy = destroy,
                             .loads = 1u << LOAD_SELF_WEIGHT | 1u << LOAD_TRACTION | 1u << LOAD_POINT_FORCE |
                                      1u << LOAD_ICE | 1u << LOAD_CREST_LOAD,
                             .applied = applied};

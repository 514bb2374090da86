/* added_mass.c: water that moves with the faces of a dam in dynamic stages, as a mass that they carry.

   The pressure is p = rho q(z) a_n, a_n the total acceleration of the face along its normal n, so a face has
   the mass matrix int N_i N_j rho q dl n n' (hydrodynamic.c). It acts along n whether the face moves to the
   water or from it, and it has no weight. It belongs to the faces of the reference state throughout. */
#include "forces/water/hydrodynamic.h"

/* The water of one load, all faces together. */
typedef struct {
  WetWall wall;
  PetscReal mass[2];   /* [kg] against accelerations along x and y */
  PetscReal elevation; /* [m] where that against x acts */
} MovedWater;

typedef struct {
  PetscBool told;    /* that it does nothing in static stages */
  MovedWater *water; /* (n_loads,); empty for other loads */
} AddedMass;

static PetscBool is_added_mass(const Scene *scene, PetscInt load)
{
  return (PetscBool)(scene->loads[load].kind == LOAD_ADDED_MASS);
}

/* ---- set-up */

/* Adds up the water at faces whose first vertex is this rank's. */
static PetscErrorCode add_up(const Model *m, const Load *load, MovedWater *water)
{
  const PetscInt set = NameRow(m->n_face_sets, m->face_set_names, load->target);
  PetscReal sum[3] = {0.};
  PetscFunctionBeginUser;
  for (PetscInt i = m->face_set_start[set]; i < m->face_set_start[set + 1]; i++) {
    const PetscInt *v = m->faces.vertex + 2 * m->face_set_faces[i];
    PetscReal x[4], k[16];
    if (v[0] >= m->n_owned) continue;
    for (int a = 0; a < 4; a++) x[a] = m->X[2 * v[a / 2] + a % 2];
    HydrodynamicMass(x, &water->wall, load->density * m->thickness, k);
    for (int row = 0; row < 4; row++)
      for (int column = row % 2; column < 4; column += 2) {
        sum[row % 2] += k[4 * row + column];
        if (row % 2 == 0) sum[2] += k[4 * row + column] * x[row + 1];
      }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPI_SUM, m->comm));
  water->mass[0] = sum[0], water->mass[1] = sum[1], water->elevation = sum[2] / sum[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A load that stages list, but none in time, would do nothing. */
static void check_stages(const Scene *scene, PetscInt load, char message[MESSAGE_LENGTH])
{
  PetscBool listed = PETSC_FALSE;
  char key[LABEL_LENGTH];
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    for (PetscInt i = 0; i < s->n_loads; i++) {
      if (s->loads[i] != load) continue;
      if (!StageRelaxes(s)) return;
      listed = PETSC_TRUE;
    }
  if (!listed) return;
  PetscCallAbort(PETSC_COMM_SELF, PetscSNPrintf(key, sizeof(key), "loads.%s", scene->loads[load].name));
  Complain(message, scene->file, scene->loads[load].line, key,
           "added_mass acts in dynamic stages and modes only, and none of these lists it");
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  static PetscBool told = PETSC_FALSE; // once, because advise.c sets up the same mesh many times
  const Scene *scene = v->scene;
  char message[MESSAGE_LENGTH] = "";
  AddedMass *a;
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < scene->n_loads; l++) any = (PetscBool)(any || is_added_mass(scene, l));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&a));
  PetscCall(PetscCalloc1(scene->n_loads, &a->water));
  *memory = a;
  for (PetscInt l = 0; l < scene->n_loads && !message[0]; l++) {
    if (!is_added_mass(scene, l)) continue;
    PetscCall(WetWallFind(v->m, scene->loads + l, &a->water[l].wall));
    WetWallRefuse(scene, scene->loads + l, &a->water[l].wall, message);
    if (!message[0]) check_stages(scene, l, message);
    if (!v->m->rank && !told && !message[0]) WetWallWarn(scene->loads + l, &a->water[l].wall);
    PetscCall(add_up(v->m, scene->loads + l, a->water + l));
  }
  told = PETSC_TRUE;
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  AddedMass *a = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  if (!a) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(a->water));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

/* Whether both ends of a face move with one rigid body of this rank. */
static PetscBool on_one_body(const Model *m, const PetscInt v[2])
{
  for (int k = 0; k < 2; k++)
    if (v[k] < m->n_deformable || v[k] >= m->n_moving) return PETSC_FALSE;
  return (PetscBool)(RigidOfVertex(m, v[0]) == RigidOfVertex(m, v[1]));
}

/* A rigid body takes the whole matrix of its face; elsewhere each vertex takes its row, as masses of blocks
   are lumped. */
static PetscErrorCode add_face(const Model *m, const PetscInt v[2], const PetscReal k[16], TermInertia add,
                               void *context)
{
  PetscFunctionBeginUser;
  if (on_one_body(m, v)) {
    PetscCall(add(2, v, k, NULL, context));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int i = 0; i < 2; i++) {
    PetscReal row[4];
    for (int a = 0; a < 2; a++)
      for (int b = 0; b < 2; b++) row[2 * a + b] = k[4 * (2 * i + a) + b] + k[4 * (2 * i + a) + 2 + b];
    PetscCall(add(1, v + i, row, NULL, context));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode inertia(const TermView *view, TermInertia add, void *context)
{
  const AddedMass *mass = view->memory;
  const Model *m = view->m;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < view->stage->n_loads; i++) {
    const PetscInt l = view->stage->loads[i];
    const Load *load = view->scene->loads + l;
    if (!is_added_mass(view->scene, l)) continue;
    const PetscInt set = NameRow(m->n_face_sets, m->face_set_names, load->target);
    for (PetscInt f = m->face_set_start[set]; f < m->face_set_start[set + 1]; f++) {
      const PetscInt *v = m->faces.vertex + 2 * m->face_set_faces[f];
      PetscReal x[4], k[16];
      for (int a = 0; a < 4; a++) x[a] = m->X[2 * v[a / 2] + a % 2];
      if (PetscMin(x[1], x[3]) >= load->level) continue;
      HydrodynamicMass(x, &mass->water[l].wall, load->density * m->thickness, k);
      PetscCall(add_face(m, v, k, add, context));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Static stages may list it, so that all stages can have the same loads. */
static PetscErrorCode begin(const TermView *v)
{
  AddedMass *mass = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->stage->n_loads && StageRelaxes(v->stage); i++) {
    const PetscInt l = v->stage->loads[i];
    if (!is_added_mass(v->scene, l) || mass->told) continue;
    mass->told = PETSC_TRUE;
    PetscCall(PetscPrintf(v->m->comm,
                          "warning: stage %s: loads.%s: added_mass has no effect where nothing accelerates; "
                          "it acts in dynamic stages and modes\n",
                          v->stage->name, v->scene->loads[l].name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water that moves is no force. */
static PetscErrorCode applied(const TermView *v, PetscInt load, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)v, (void)load, (void)f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void summary(FILE *f, const TermView *v)
{
  const AddedMass *mass = v->memory;
  const char *before = "      \"added_mass\": {\n";
  for (PetscInt i = 0; i < v->stage->n_loads && !StageRelaxes(v->stage); i++) {
    const PetscInt l = v->stage->loads[i];
    if (!is_added_mass(v->scene, l)) continue;
    const MovedWater *water = mass->water + l;
    fprintf(f, "%s        ", before);
    JsonString(f, v->scene->loads[l].name);
    fprintf(f, ": {");
    JsonNumber(f, "depth", water->wall.depth, ", ");
    JsonNumber(f, "lean", water->wall.lean, ", ");
    JsonNumber(f, "mass_x", water->mass[0], ", ");
    JsonNumber(f, "mass_y", water->mass[1], ", ");
    JsonNumber(f, "elevation", water->elevation, "}");
    before = ",\n";
  }
  if (before[0] == ',') fprintf(f, "\n      },\n");
}

const TermKind Added_mass_term = {.name = "added_mass",
                                  .loads = 1u << LOAD_ADDED_MASS,
                                  .create = create,
                                  .destroy = destroy,
                                  .inertia = inertia,
                                  .applied = applied,
                                  .begin = begin,
                                  .summary = summary};

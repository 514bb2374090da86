/* added_mass.c: adds the mass of the water that moves with the faces of a dam in dynamic stages.

   The pressure is p = rho q(z) a_n, a_n the total acceleration of the face along its normal n, so a face
   has the mass matrix int N_i N_j rho q dl n n' (hydrodynamic.c). The mass acts along n in both directions
   and has no weight. It is computed once, on the reference configuration. Where its suction exceeds the
   hydrostatic pressure, the water would separate from the face. A warning reports this, from the largest
   acceleration away from the water of each half of a face, taken at its vertex. */
#include "water/hydrodynamic.h"

/* Suction at all faces of one load. */
typedef struct {
  PetscReal pressure;    /* [Pa] least total pressure, hydrostatic plus hydrodynamic; 0: never negative */
  PetscReal at[2], time; /* [m], [s] place and time of the least pressure */
  PetscReal length;      /* [m] length with negative pressure at some time */
} Suction;
typedef struct {
  PetscReal *least; /* [m/s2] (n_owned,2) least acceleration towards the water at a vertex, as the first and
                      as the second end of a face; infinite: none yet */
  PetscReal *time;  /* [s] (n_owned,2) times of the least accelerations */
  Suction suction;  /* rank 0: suction at the last summary */
  WetWall wall;
  PetscReal mass[2];   /* [kg] for accelerations along x and y */
  PetscReal elevation; /* [m] centre of the mass for x */
} MovedWater;

/* The half of a wet face at an owned vertex. */
typedef struct {
  PetscInt load, vertex, end; /* end: 0: first end of the face, 1: second */
  PetscReal normal[2];        /* [-] towards the water */
  PetscReal x[2], middle[2];  /* [m] */
} HalfFace;

typedef struct {
  PetscInt n, capacity;
  HalfFace *half;    /* (n,) of the current dynamic stage */
  PetscBool warned;  /* warned that it has no effect in static stages */
  MovedWater *water; /* (n_loads,); empty for other loads */
} AddedMass;

static PetscBool is_added_mass(const Scene *scene, PetscInt load)
{
  return (PetscBool)(scene->loads[load].kind == LOAD_ADDED_MASS);
}

/* ---- set-up */

/* Sums the mass of the water over faces whose first vertex is owned. */
static PetscErrorCode add_up(const Model *m, const Load *load, MovedWater *water)
{
  PetscInt n;
  const PetscInt *faces = FacesOfSet(m, load->target, &n);
  PetscReal sum[3] = {0.};
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    PetscReal x[4], k[16];
    if (m->faces.vertex[2 * faces[i]] >= m->mesh.n_owned) continue;
    FaceCoordinates(m, NULL, faces[i], x);
    HydrodynamicMass(x, &water->wall, load->density * m->materials.thickness, k);
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

/* Refuses a load that is listed only by static stages: it would do nothing. */
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

static void forget(const Model *m, MovedWater *water)
{
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) water->least[i] = PETSC_INFINITY, water->time[i] = 0.;
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  static PetscInt runs; // only once, because advise.c sets up the same mesh many times
  const PetscBool warned = AlreadyWarned(&runs);
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
    if (!v->m->rank && !warned && !message[0]) WetWallWarn(scene->loads + l, &a->water[l].wall);
    PetscCall(add_up(v->m, scene->loads + l, a->water + l));
    PetscCall(
        PetscMalloc2(2 * v->m->mesh.n_owned, &a->water[l].least, 2 * v->m->mesh.n_owned, &a->water[l].time));
    forget(v->m, a->water + l);
  }
  PetscCall(CheckMessage(v->m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  AddedMass *a = *memory;
  PetscFunctionBeginUser;
  if (!a) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < scene->n_loads; l++) PetscCall(PetscFree2(a->water[l].least, a->water[l].time));
  PetscCall(PetscFree(a->half));
  PetscCall(PetscFree(a->water));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- stages */

/* Decides whether both ends of a face belong to one owned rigid body. */
static PetscBool on_one_body(const Model *m, const PetscInt v[2])
{
  for (int k = 0; k < 2; k++)
    if (v[k] < m->mesh.n_deformable || v[k] >= m->mesh.n_moving) return PETSC_FALSE;
  return (PetscBool)(RigidOfVertex(m, v[0]) == RigidOfVertex(m, v[1]));
}

/* Adds the mass of one face. A rigid body takes the whole matrix; otherwise each vertex takes its row sum,
   as the masses of blocks are lumped. */
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

/* Lists the halves of a face at owned, moving vertices. x: (4) ends of the face. */
static PetscErrorCode add_halves(const Model *m, PetscInt load, const PetscInt v[2], const PetscReal x[4],
                                 AddedMass *mass)
{
  const PetscReal length = PetscHypotReal(x[2] - x[0], x[3] - x[1]);
  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    if (v[k] >= m->mesh.n_moving) continue;
    PetscCall(MakeRoom(sizeof(HalfFace), mass->n, &mass->capacity, &mass->half));
    mass->half[mass->n++] = (HalfFace){.load = load,
                                       .vertex = v[k],
                                       .end = k,
                                       .normal = {(x[3] - x[1]) / length, (x[0] - x[2]) / length},
                                       .x = {x[2 * k], x[2 * k + 1]},
                                       .middle = {0.5 * (x[0] + x[2]), 0.5 * (x[1] + x[3])}};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode inertia(const TermView *view, TermInertia add, void *context)
{
  AddedMass *mass = view->memory;
  const Model *m = view->m;
  PetscFunctionBeginUser;
  if (!mass) PetscFunctionReturn(PETSC_SUCCESS); // the scene has no added mass
  mass->n = 0;
  for (PetscInt i = 0; i < view->stage->n_loads; i++) {
    const PetscInt l = view->stage->loads[i];
    const Load *load = view->scene->loads + l;
    if (!is_added_mass(view->scene, l)) continue;
    PetscInt n;
    const PetscInt *faces = FacesOfSet(m, load->target, &n);
    for (PetscInt f = 0; f < n; f++) {
      const PetscInt *v = m->faces.vertex + 2 * faces[f];
      PetscReal x[4], k[16];
      FaceCoordinates(m, NULL, faces[f], x);
      if (PetscMin(x[1], x[3]) >= load->level) continue;
      HydrodynamicMass(x, &mass->water[l].wall, load->density * m->materials.thickness, k);
      PetscCall(add_face(m, v, k, add, context));
      PetscCall(add_halves(m, l, v, x, mass));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the change of velocity [m/s] of a vertex along n over a step. */
static PetscReal change_along(const Model *m, const State *s, const PetscReal *v_before, PetscInt v,
                              const PetscReal n[2])
{
  const PetscInt body = v < m->mesh.n_deformable ? -1 : RigidOfVertex(m, v),
                 d = body < 0 ? 3 * m->rigid.n + 2 * v : 3 * body;
  PetscReal x = s->v[d] - v_before[d], y = s->v[d + 1] - v_before[d + 1];
  if (body >= 0) {
    const PetscReal turn = s->v[d + 2] - v_before[d + 2];
    x -= turn * (m->mesh.X[2 * v + 1] - m->rigid.X[2 * body + 1]);
    y += turn * (m->mesh.X[2 * v] - m->rigid.X[2 * body]);
  }
  return n[0] * x + n[1] * y;
}

void AddedMassRecord(void *memory, const Model *m, const State *s, const PetscReal *v_before)
{
  const AddedMass *mass = memory;
  for (const HalfFace *h = mass ? mass->half : NULL; mass && h < mass->half + mass->n; h++) {
    MovedWater *water = mass->water + h->load;
    const PetscInt at = 2 * h->vertex + h->end;
    const PetscReal a_n = change_along(m, s, v_before, h->vertex, h->normal) / s->dt;
    if (a_n < water->least[at]) water->least[at] = a_n, water->time[at] = s->time;
  }
}

/* Finds the largest suction of one load. */
static PetscErrorCode find_suction(const TermView *v, PetscInt load, MovedWater *water)
{
  const AddedMass *mass = v->memory;
  const Load *l = v->scene->loads + load;
  PetscInt n = 0, n_all, *slot;
  PetscReal *length;
  Suction mine = {.pressure = 0.}, *all;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(mass->n, &slot, mass->n, &length));
  for (const HalfFace *h = mass->half; h < mass->half + mass->n; h++) {
    const PetscInt at = 2 * h->vertex + h->end;
    PetscReal place[2];
    if (h->load != load || water->least[at] >= 0.) continue;
    const PetscReal p = PressureOfHalf(h->x, h->middle, &water->wall, l->density, v->scene->gravity,
                                       water->least[at], place, length + n);
    n++;
    if (p < mine.pressure) mine = (Suction){p, {place[0], place[1]}, water->time[at], 0.};
  }
  PetscCall(BinnedSums(v->m->comm, n, slot, length, 1, &water->suction.length));
  const PetscReal total = water->suction.length;
  PetscCall(GatherBytes(v->m->comm, 1, sizeof mine, &mine, &n_all, (void **)&all));
  for (PetscInt r = 0; r < n_all && !v->m->rank; r++) // of equal ones the highest
    if (!r || all[r].pressure < water->suction.pressure ||
        (all[r].pressure == water->suction.pressure && all[r].at[1] > water->suction.at[1]))
      water->suction = all[r];
  water->suction.length = total;
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(slot, length));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode before_summary(const TermView *v, PetscBool report)
{
  AddedMass *mass = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->stage->n_loads && StageInTime(v->stage); i++) {
    const PetscInt l = v->stage->loads[i];
    if (!is_added_mass(v->scene, l)) continue;
    const Suction *suction = &mass->water[l].suction;
    PetscCall(find_suction(v, l, mass->water + l));
    if (!report || !(suction->length > 0.)) continue;
    PetscCall(WarnAll(
        v->m->comm,
        "stage %s: loads.%s: over %.3g m of its faces the water has pulled more than it presses at "
        "rest, most "
        "at (%.4g, %.4g) at %.4g s, to %.3g kPa: there it would part from them, which is not followed",
        v->stage->name, v->scene->loads[l].name, (double)suction->length, (double)suction->at[0],
        (double)suction->at[1], (double)suction->time, 1e-3 * (double)suction->pressure));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  AddedMass *mass = v->memory;
  char name[NAME_LENGTH];
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < v->scene->n_loads; l++) {
    if (!is_added_mass(v->scene, l)) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "off_water_%" PetscInt_FMT, l));
    PetscCall(ArchiveVertices(a, v->m, name, mass->water[l].least));
    PetscCall(PetscSNPrintf(name, sizeof(name), "off_water_%" PetscInt_FMT "_time", l));
    PetscCall(ArchiveVertices(a, v->m, name, mass->water[l].time));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once that the load has no effect in static stages. These may list it, so that all stages can have
   the same loads. */
static PetscErrorCode begin(const TermView *v)
{
  AddedMass *mass = v->memory;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->stage->n_loads; i++) {
    const PetscInt l = v->stage->loads[i];
    if (!is_added_mass(v->scene, l)) continue;
    if (StageInTime(v->stage)) forget(v->m, mass->water + l);
    if (!StageRelaxes(v->stage) || mass->warned) continue;
    mass->warned = PETSC_TRUE;
    PetscCall(WarnAll(v->m->comm,
                      "stage %s: loads.%s: added_mass has no effect where nothing accelerates; "
                      "it acts in dynamic stages and modes",
                      v->stage->name, v->scene->loads[l].name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds nothing: the moving water is a mass, not a force. */
static PetscErrorCode applied(const TermView *v, PetscInt load, PetscReal *f)
{
  PetscFunctionBeginUser;
  (void)v, (void)load, (void)f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void put_suction(Json *json, const Suction *s)
{
  const PetscBool any = (PetscBool)(s->pressure < 0.);
  JsonObject(json, "suction", {"pressure", s->pressure}, {"x", any ? s->at[0] : NAN},
             {"y", any ? s->at[1] : NAN}, {"time", any ? s->time : NAN}, {"length", s->length});
}

static void summary(Json *json, const TermView *v)
{
  const AddedMass *mass = v->memory;
  JsonOpenLater(json, "added_mass");
  for (PetscInt i = 0; i < v->stage->n_loads && !StageRelaxes(v->stage); i++) {
    const PetscInt l = v->stage->loads[i];
    if (!is_added_mass(v->scene, l)) continue;
    const MovedWater *water = mass->water + l;
    JsonOpen(json, v->scene->loads[l].name);
    JsonNumbers(json, {"depth", water->wall.depth}, {"lean", water->wall.lean}, {"mass_x", water->mass[0]},
                {"mass_y", water->mass[1]}, {"elevation", water->elevation});
    put_suction(json, &water->suction);
    JsonClose(json);
  }
  JsonClose(json);
}

const TermKind Added_mass_term = {.name = "added_mass",
                                  .loads = 1u << LOAD_ADDED_MASS,
                                  .create = create,
                                  .destroy = destroy,
                                  .inertia = inertia,
                                  .applied = applied,
                                  .begin = begin,
                                  .before_summary = before_summary,
                                  .archive = archive,
                                  .summary = summary};

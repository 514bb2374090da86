/* temperature.c: computes the change of temperature of blocks from the scene, and its forces and stresses
   (thermal.c). Changes belong to blocks, so two groups that share vertices may have different changes.
   Within a block they are linear between its vertices. */
#include "loads/loads.h"
#include "scene/reader.h"

static const PetscReal YEAR = 365.25 * 86400.; /* [s] */

/* Change of one load [K] at the vertices of all blocks, without the load's factor. */
typedef struct {
  PetscReal *change[ELEMENT_LISTS]; /* in the lanes of Elements.vertex; NULL: no load of this type */
} Heat;

typedef struct {
  PetscInt n_loads;
  Heat *heat;          /* (n_loads,) */
  PetscReal *s_1;      /* [Pa/K] (n_groups,) isotropic stress of a fully restrained block */
  PetscReal *own_1;    /* [1/K] (n_groups,) see ThermalEnergy */
  PetscReal *across_1; /* [Pa/K] (n_groups,) E alpha: stress across the plane of a block that is free in
                          the plane */
} Temperature;

/* ---- changes of temperature */

/* Returns the value at X of the plane that fits the points best, with weights 1/d^4. It meets every point,
   and is exact if all points are on one plane. It is constant across a row of points. Beyond the points it
   is limited to their range. */
static PetscReal between_points(const HeatKeys *heat, const PetscReal X[2])
{
  PetscReal sum = 0., mean[3] = {0.}, C[3] = {0.}, c[2] = {0.}, low = PETSC_INFINITY, high = -PETSC_INFINITY,
            near = PETSC_INFINITY;
  for (PetscInt i = 0; i < heat->n_points; i++) {
    const PetscReal dx = heat->x[i] - X[0], dy = heat->at[2 * i] - X[1], T = heat->at[2 * i + 1];
    near = PetscMin(near, dx * dx + dy * dy);
    low = PetscMin(low, T), high = PetscMax(high, T);
    if (dx == 0. && dy == 0.) return T;
  }
  for (int round = 0; round < 2; round++) {
    for (PetscInt i = 0; i < heat->n_points; i++) {
      const PetscReal d[3] = {heat->x[i] - X[0], heat->at[2 * i] - X[1], heat->at[2 * i + 1]};
      const PetscReal part = near / (d[0] * d[0] + d[1] * d[1]), w = part * part;
      const PetscReal e[3] = {d[0] - mean[0], d[1] - mean[1], d[2] - mean[2]};
      if (round)
        C[0] += w * e[0] * e[0], C[1] += w * e[1] * e[1], C[2] += w * e[0] * e[1], c[0] += w * e[0] * e[2],
            c[1] += w * e[1] * e[2];
      else
        sum += w;
    }
    for (PetscInt i = 0; i < heat->n_points && !round; i++) {
      const PetscReal d[3] = {heat->x[i] - X[0], heat->at[2 * i] - X[1], heat->at[2 * i + 1]};
      const PetscReal part = near / (d[0] * d[0] + d[1] * d[1]), w = part * part / sum;
      for (int k = 0; k < 3; k++) mean[k] += w * d[k];
    }
  }
  // the slope b = C^+ c, by the principal directions of C
  const PetscReal half = 0.5 * (C[0] - C[1]), radius = PetscHypotReal(half, C[2]),
                  most = 0.5 * (C[0] + C[1]) + radius;
  const PetscReal angle = 0.5 * PetscAtan2Real(C[2], half), e[2] = {PetscCosReal(angle), PetscSinReal(angle)};
  const PetscReal least = 0.5 * (C[0] + C[1]) - radius;
  PetscReal T = mean[2];
  if (most > 0.) T -= (c[0] * e[0] + c[1] * e[1]) / most * (mean[0] * e[0] + mean[1] * e[1]);
  if (least > 1e-9 * most) T -= (c[1] * e[0] - c[0] * e[1]) / least * (mean[1] * e[0] - mean[0] * e[1]);
  return PetscMax(low, PetscMin(high, T));
}

/* Returns the distance of X from n straight faces x (n,4). */
static PetscReal depth_below(PetscInt n, const PetscReal *x, const PetscReal X[2])
{
  PetscReal least = PETSC_INFINITY;
  for (PetscInt i = 0; i < n; i++, x += 4) {
    const PetscReal e[2] = {x[2] - x[0], x[3] - x[1]}, d[2] = {X[0] - x[0], X[1] - x[1]};
    const PetscReal t = PetscMax(0., PetscMin(1., (d[0] * e[0] + d[1] * e[1]) / (e[0] * e[0] + e[1] * e[1])));
    least = PetscMin(least, PetscHypotReal(d[0] - t * e[0], d[1] - t * e[1]));
  }
  return least;
}

/* Returns the annual wave in a half space, which decays and lags with depth. */
static PetscReal wave(const HeatKeys *heat, PetscReal depth)
{
  const PetscReal d = depth / PetscSqrtReal(heat->diffusivity * YEAR / PETSC_PI);
  return heat->mean +
         heat->amplitude * PetscExpReal(-d) * PetscCosReal(2. * PETSC_PI * heat->day * 86400. / YEAR - d);
}

/* Collective. Gathers the ends of all faces of a set in the reference configuration. x: (n,4) [m] from
   PetscMalloc. */
static PetscErrorCode faces_of(const Model *m, const char *name, PetscInt *n, PetscReal **x)
{
  PetscReal *own;
  PetscInt at = 0, mine;
  const PetscInt *faces = FacesOfSet(m, name, &mine);
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(4 * mine, &own));
  for (PetscInt i = 0; i < mine; i++) FaceCoordinates(m, NULL, faces[i], own + 4 * i);
  PetscCallMPI(MPI_Allreduce(&mine, n, 1, MPIU_INT, MPI_SUM, m->comm));
  PetscCall(PetscMalloc1(4 * *n, x));
  for (PetscMPIInt rank = 0; rank < m->size; rank++) {
    PetscInt theirs = mine;
    PetscCallMPI(MPI_Bcast(&theirs, 1, MPIU_INT, rank, m->comm));
    if (rank == m->rank) PetscCall(PetscArraycpy(*x + 4 * at, own, 4 * mine));
    PetscCallMPI(MPI_Bcast(*x + 4 * at, (PetscMPIInt)(4 * theirs), MPIU_REAL, rank, m->comm));
    at += theirs;
  }
  PetscCall(PetscFree(own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up */

static PetscErrorCode fill(const Model *m, const Load *load, PetscInt n_faces, const PetscReal *faces,
                           Heat *heat)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < ELEMENT_LISTS; l++) {
    const Elements *e = m->mesh.elements + l;
    if (l >= DEFORMABLE_LISTS && l < MOVING_LISTS) continue; // rigid
    PetscCall(PetscCalloc1(e->n_nodes * e->n_padded, &heat->change[l]));
    for (PetscInt i = 0; i < e->n; i++) {
      if (load->n_groups && NameRow(load->n_groups, load->groups, m->materials.names[e->group[i]]) < 0)
        continue;
      for (int k = 0; k < e->n_nodes; k++) {
        const PetscReal *X = m->mesh.X + 2 * VertexOf(e, i, k);
        heat->change[l][VertexPlace(e, i, k)] = !PetscIsNanReal(load->heat.change) ? load->heat.change
                                                : load->heat.n_points
                                                    ? between_points(&load->heat, X)
                                                    : wave(&load->heat, depth_below(n_faces, faces, X));
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  const Scene *scene = v->scene;
  const Model *m = v->m;
  Temperature *t;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&t));
  *memory = t;
  t->n_loads = v->state->applied.n_loads;
  PetscCall(PetscCalloc1(t->n_loads, &t->heat));
  if (!t->n_loads) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc3(m->materials.n_groups, &t->s_1, m->materials.n_groups, &t->own_1,
                         m->materials.n_groups, &t->across_1));
  for (PetscInt g = 0; g < m->materials.n_groups; g++) {
    const Material *material = scene->materials + g;
    const PetscReal E = material->young, nu = material->poisson, alpha = material->expansion;
    const PetscBool strain = (PetscBool)(scene->plane == PLANE_STRAIN),
                    held = (PetscBool)(strain && !material->free_across);
    t->s_1[g] = E * alpha / (1. - (strain ? 2. : 1.) * nu);
    if (strain && !held) t->s_1[g] /= 1. + nu; // C acts on the strain alpha in the plane alone
    t->own_1[g] = (held ? 3. : 2.) * alpha;
    t->across_1[g] = held ? E * alpha : 0.;
  }
  for (PetscInt l = 0; l < t->n_loads; l++) {
    const Load *load = scene->loads + l;
    PetscReal *faces = NULL;
    PetscInt n = 0;
    if (load->kind != LOAD_TEMPERATURE) continue;
    if (load->target[0]) PetscCall(faces_of(m, load->target, &n, &faces));
    PetscCall(fill(m, load, n, faces, t->heat + l));
    PetscCall(PetscFree(faces));
  }
  for (PetscInt l = 0; l < t->n_loads; l++)
    for (int list = 0; list < DEFORMABLE_LISTS; list++)
      if (t->heat[l].change[list])
        PetscCall(LawsFeel(m->mesh.elements + list, l, t->heat[l].change[list], v->state->applied.share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  Temperature *t = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  if (!t) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < t->n_loads; l++)
    for (int list = 0; list < ELEMENT_LISTS; list++) PetscCall(PetscFree(t->heat[l].change[list]));
  PetscCall(PetscFree(t->heat));
  PetscCall(PetscFree3(t->s_1, t->own_1, t->across_1));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- forces and stresses */

static PetscErrorCode applied(const TermView *v, PetscInt row, PetscReal *f)
{
  const Temperature *t = v->memory;
  const Model *m = v->m;
  PetscFunctionBeginUser;
  for (int l = 0; l < ELEMENT_LISTS; l++)
    if (t->heat[row].change[l])
      ThermalForces(m, m->mesh.elements + l, t->s_1, t->heat[row].change[l], v->scene->loads[row].heat.factor,
                    v->state->u + 3 * m->rigid.n, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TemperatureCorrects(const TermView *v, const Elements *e, BlockAnswers *a)
{
  const Temperature *t = v->memory;
  const Model *m = v->m;
  const PetscReal *share = v->state->applied.share[SHARE_NOW], *u = v->state->u + 3 * m->rigid.n;
  const ptrdiff_t list = e - m->mesh.elements;
  PetscReal *change;
  PetscFunctionBeginUser;
  if (!t->n_loads) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(e->n_nodes * e->n_padded, &change));
  for (PetscInt l = 0; l < t->n_loads; l++)
    for (PetscInt i = 0; i < e->n_nodes * e->n_padded && t->heat[l].change[list]; i++)
      change[i] += share[l] * t->heat[l].change[list][i];
  if (a->centre) ThermalStress(m, e, t->s_1, change, u, 1, a->centre);
  if (a->gauss) ThermalStress(m, e, t->s_1, change, u, e->n_nodes == 4 ? 4 : 1, a->gauss);
  if (a->energy) ThermalEnergy(m, e, t->s_1, t->own_1, change, u, a->energy);
  if (a->change) ThermalMean(e, change, a->change);
  for (PetscInt i = 0; i < e->n && a->change && a->across; i++)
    a->across[i] = -t->across_1[e->group[i]] * a->change[i];
  PetscCall(PetscFree(change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- keys */

/* Checks that a temperature is given in one of three ways, and that keys of the yearly wave come with its
   amplitude. Without an amplitude a key may have its default, because scene_echo.yaml writes every key. */
PetscErrorCode CompleteTemperature(Reader *r, const char *path, Load *load)
{
  static const char *const ways[] = {"change", "points", "amplitude"};
  static const char *const keys[] = {"faces", "mean", "day", "diffusivity"};
  const HeatKeys *heat = &load->heat;
  const PetscBool same[] = {PETSC_FALSE, (PetscBool)(heat->mean == 0.), (PetscBool)(heat->day == 0.),
                            (PetscBool)(heat->diffusivity == 1.1e-6)};
  PetscBool given = PETSC_FALSE;
  int n = 0;

  PetscFunctionBeginUser;
  for (int k = 2; k >= 0; k--) {
    PetscCall(IsGiven(r, path, ways[k], &given));
    n += given;
  }
  if (!n)
    COMPLAIN_MISSING(r, "a temperature needs change [K], points (a file) or amplitude [K], one of them");
  if (n > 1) COMPLAIN(r, "change, points and amplitude: a temperature has one of them");
  for (int k = 0; k < 4 && n == 1; k++) {
    PetscCall(IsGiven(r, path, keys[k], &given));
    if (isnan(heat->amplitude) && given && !same[k])
      COMPLAIN(r, "there is no yearly wave: give loads.%s.amplitude [K]", load->name);
    if (!k && !isnan(heat->amplitude) && !given)
      COMPLAIN_MISSING(r, "missing: the face set from which the yearly wave comes in");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Temperature_term = {.name = "temperature",
                                   .loads = 1u << LOAD_TEMPERATURE,
                                   .presses = PETSC_TRUE,
                                   .create = create,
                                   .destroy = destroy,
                                   .applied = applied};

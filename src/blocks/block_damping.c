/* block_damping.c: adds stiffness-proportional damping of deformable blocks in dynamic stages.

   The damping stress follows from the block's law with beta dE/dt in place of the strain E (Kelvin and
   Voigt), so rigid rotation is not damped. The rate belongs to the step before: with du = u - u_before the
   strain has changed by m_a . du_b in its natural components, where m_a are the tangents half-way (in small
   strain the tangents of the reference configuration). Ranks know displacements of other ranks' vertices but
   no velocities, so du is computed from displacements on all ranks.

   A condensed body is damped by beta times its reduced stiffness: its kept vertices here, its modes in
   coupled_bodies.c. So it has one beta for all its groups.

   The force lags by half a step, which shortens the step (masses.c). Its work is summed by the same
   trapezoidal rule as the work of all forces. The first step of a stage has no motion before it, and is
   not damped. */
#include "blocks/blocks.h"
#include "blocks/element_kernels.h"

typedef struct {
  Elements list[DEFORMABLE_LISTS];   /* damped blocks: n, n_nodes, n_padded, vertex, group */
  PetscReal *beta[DEFORMABLE_LISTS]; /* [s] (n_padded,) per block; 0 in padding */
  PetscReal *of_group;               /* [s] (n_groups,) */
  PetscInt n;                        /* number of vertices of blocks of this rank */
  PetscReal *now, *before;           /* [m] (n,2) displacements at the last evaluation; one step before */
  PetscReal *f, *f_before;           /* [N] (n,2) damping forces at these times */
  PetscReal lost;                    /* [J] dissipated in this stage, on this rank */
  PetscBool active, moved;           /* some block is damped; a step of the stage has been made */
} BlockDamping;

/* ---- kernels */

/* Modes of a damped block: reference, present and half-way coordinates, and du. */
typedef struct {
  LanesModes X, x, middle, du;
} LanesDamped;

KERNEL LanesModes Halfway(const LanesModes *x, const LanesModes *du)
{
  const LanesModes less = {VectorScale(-0.5, du->a), VectorScale(-0.5, du->b), VectorScale(-0.5, du->h)};
  return ModesAdd(x, &less);
}

/* Returns the modes that the rate of strain needs, from the modes X of the reference coordinates, u of the
   displacements and du of their change in the step. */
KERNEL LanesDamped DampedOf(const LanesModes *X, const LanesModes *u, const LanesModes *du, int large)
{
  if (!large) return (LanesDamped){*X, *X, *X, *du};
  const LanesModes x = ModesAdd(X, u);
  return (LanesDamped){*X, x, Halfway(&x, du), *du};
}

/* Computes a tangent as TangentOf, with D = 2 m . du. */
KERNEL LanesTangent DampedTangent(LanesVector X, LanesVector m, LanesVector du, Lanes mu)
{
  const Lanes half = VectorDot(m, du), D = half + half;
  return (LanesTangent){X, du, m, VectorDot(X, X), D, mu * D};
}

KERNEL LanesTensor DampedStress(const LanesTangent *p, const LanesTangent *q, Lanes modulus, Lanes mu)
{
  return NaturalStressOf(p, q, VectorDot(p->x, q->u) + VectorDot(p->u, q->x), modulus, mu);
}

/* Returns x + by h: the tangent of a mode at a row or column of points. */
KERNEL LanesVector Along(LanesVector x, PetscReal by, LanesVector h)
{
  return (LanesVector){x.x + by * h.x, x.y + by * h.y};
}

KERNEL void DampedQ4(const LanesDamped *b, Lanes modulus, Lanes mu, LanesVector f[4])
{
  LanesTangent p[2], q[2]; // along xi below and above, along eta left and right
  for (int k = 0; k < 2; k++) {
    const PetscReal g = k ? GAUSS : -GAUSS;
    p[k] = DampedTangent(Along(b->X.a, g, b->X.h), Along(b->middle.a, g, b->middle.h),
                         Along(b->du.a, g, b->du.h), mu);
    q[k] = DampedTangent(Along(b->X.b, g, b->X.h), Along(b->middle.b, g, b->middle.h),
                         Along(b->du.b, g, b->du.h), mu);
  }
  const LanesTensor T[4] = {DampedStress(p, q, modulus, mu), DampedStress(p, q + 1, modulus, mu),
                            DampedStress(p + 1, q + 1, modulus, mu), DampedStress(p + 1, q, modulus, mu)};
  Q4Sum(T, b->x.a, b->x.b, VectorScale(GAUSS, b->x.h), f);
}

/* Computes the damping stress at the centre of a block. */
KERNEL LanesTensor DampedCentre(const LanesDamped *b, Lanes modulus, Lanes mu)
{
  const LanesTangent p = DampedTangent(b->X.a, b->middle.a, b->du.a, mu),
                     q = DampedTangent(b->X.b, b->middle.b, b->du.b, mu);
  return DampedStress(&p, &q, modulus, mu);
}

KERNEL void DampedOnePoint(const LanesVector X[4], const LanesVector u[4], const LanesVector du[4],
                           const LanesMaterial *m, Lanes rate, PetscReal thickness, int large,
                           LanesVector f[4])
{
  const LanesModes XM = Q4Modes(X), uM = Q4Modes(u), dM = Q4Modes(du), back = Halfway(&uM, &dM),
                   before = Halfway(&back, &dM);
  const LanesDamped b = DampedOf(&XM, &uM, &dM, large);
  const LanesModes x_before = large ? ModesAdd(&XM, &before) : XM;
  LanesHourglass o = Hourglass(&XM, &uM, &b.x, m);
  const LanesHourglass o_before = Hourglass(&XM, &before, &x_before, m);
  o.c = (LanesVector){rate * (o.c.x - o_before.c.x), rate * (o.c.y - o_before.c.y)};
  const LanesTensor T = DampedCentre(&b, rate * (0.5 * m->lambda + m->mu), rate * m->mu);
  Q4OnePointSum(&XM, &b.x, &o, &T, thickness, large, f);
}

/* Computes the damping forces on the vertices. rate: beta over the time step [-]. */
KERNEL void DampedForce(int n_nodes, const LanesVector *X, const LanesVector *u, const LanesVector *du,
                        const LanesMaterial *m, Lanes rate, PetscReal thickness, int large, LanesVector *f)
{
  if (n_nodes == 3) {
    const LanesModes XM = T3Modes(X), uM = T3Modes(u), dM = T3Modes(du);
    const LanesDamped b = DampedOf(&XM, &uM, &dM, large);
    const LanesTensor T = DampedCentre(&b, rate * (0.5 * m->lambda + m->mu), rate * m->mu);
    T3Sum(&T, b.x.a, b.x.b, thickness, f);
    return;
  }
  const LanesModes XM = Q4FourModes(X), uM = Q4FourModes(u), dM = Q4FourModes(du);
  const LanesDamped b = DampedOf(&XM, &uM, &dM, large);
  const Lanes mu = 0.0625 * thickness * rate * m->mu, modulus = 0.03125 * thickness * rate * m->lambda + mu;
  DampedQ4(&b, modulus, mu, f);
  if (!Any(m->one_point)) return;
  LanesVector one[4];
  DampedOnePoint(X, u, du, m, rate, thickness, large, one);
  for (int i = 0; i < 4; i++)
    f[i] = (LanesVector){Select(m->one_point, one[i].x, f[i].x), Select(m->one_point, one[i].y, f[i].y)};
}

KERNEL void DampedLoop(const Model *model, const BlockDamping *d, int l, int n_nodes, int large,
                       PetscReal rate)
{
  const Elements *e = d->list + l;
  for (PetscInt first = 0; first < e->n_padded; first += LANES) {
    const PetscInt *vertex = LaneVertices(e, n_nodes, first);
    const LanesMaterial material = LoadMaterial(model, e->group + first);
    LanesVector X[4], U[4], B[4], F[4];
    Gather(n_nodes, model->mesh.X, vertex, X);
    Gather(n_nodes, d->now, vertex, U);
    Gather(n_nodes, d->before, vertex, B);
    for (int i = 0; i < n_nodes; i++) B[i] = VectorSubtract(U[i], B[i]);
    DampedForce(n_nodes, X, U, B, &material, rate * LoadLanes(d->beta[l] + first), model->materials.thickness,
                large, F);
    ScatterAdd(n_nodes, F, vertex, d->f);
  }
}

KERNEL void DampedForces_code(const Model *model, const BlockDamping *d, PetscReal rate)
{
  if (model->materials.strain == STRAIN_LARGE) {
    DampedLoop(model, d, 0, 4, 1, rate);
    DampedLoop(model, d, 1, 3, 1, rate);
  } else {
    DampedLoop(model, d, 0, 4, 0, rate);
    DampedLoop(model, d, 1, 3, 0, rate);
  }
}

VARIANTS(DampedForces, (const Model *model, const BlockDamping *d, PetscReal rate), (model, d, rate))

/* ---- set-up */

static PetscErrorCode clear(BlockDamping *d)
{
  PetscFunctionBeginUser;
  for (int l = 0; l < DEFORMABLE_LISTS; l++)
    PetscCall(PetscFree3(d->list[l].vertex, d->list[l].group, d->beta[l]));
  PetscCall(PetscFree(d->now)); // one by one, because they are swapped
  PetscCall(PetscFree(d->before));
  PetscCall(PetscFree(d->f));
  PetscCall(PetscFree(d->f_before));
  d->active = d->moved = PETSC_FALSE;
  d->lost = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the group of the first block of a condensed body with another beta; -1: none. */
static PetscInt find_other(const Model *m, const Condensed *c, const PetscReal *of_group, PetscReal beta)
{
  for (const Elements *list = m->mesh.elements + MOVING_LISTS; list < m->mesh.elements + ELEMENT_LISTS;
       list++)
    for (PetscInt e = 0; e < list->n; e++)
      if (m->mesh.vertex_condensed[VertexOf(list, e, 0)] == c->number && of_group[list->group[e]] != beta)
        return list->group[e];
  return -1;
}

static void find_betas(const Scene *scene, const Stage *stage, const Model *m, PetscReal *of_group)
{
  const PetscBool in_time = StageInTime(stage);
  for (PetscInt g = 0; g < m->materials.n_groups; g++) {
    const Material *material = scene->materials + g;
    of_group[g] = in_time && !material->rigid ? BetaOf(material, stage) : 0.;
  }
}

/* Refuses condensed bodies with several betas before anything runs. */
static PetscErrorCode check_condensed(const TermView *v, PetscReal *of_group)
{
  const Scene *scene = v->scene;
  const Model *m = v->m;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++) {
    find_betas(scene, s, m, of_group);
    PetscBool differ = PETSC_FALSE;
    for (PetscInt g = 1; g < m->materials.n_groups; g++)
      differ = (PetscBool)(differ || of_group[g] != of_group[0]);
    for (const Condensed *c = m->condensed.body;
         differ && c < m->condensed.body + m->condensed.n && !message[0]; c++) {
      const PetscInt one = find_other(m, c, of_group, -1.), other = find_other(m, c, of_group, of_group[one]);
      if (other < 0) continue;
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                              "%s: stages.%s: groups %s and %s are one condensed body and have beta %.4g and "
                              "%.4g s: expected one beta, or one of them not condensed",
                              scene->file, s->name, m->materials.names[one], m->materials.names[other],
                              (double)of_group[one], (double)of_group[other]));
    }
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode create(const TermView *v, void **memory)
{
  BlockDamping *d;
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&d));
  PetscCall(PetscCalloc1(v->m->materials.n_groups, &d->of_group));
  PetscCall(check_condensed(v, d->of_group));
  *memory = d;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  BlockDamping *d = *memory;
  PetscFunctionBeginUser;
  (void)scene;
  if (d) {
    PetscCall(clear(d));
    PetscCall(PetscFree(d->of_group));
  }
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the damped blocks of a list. */
static PetscErrorCode list_damped(const Elements *all, const PetscReal *of_group, Elements *list,
                                  PetscReal **beta)
{
  PetscFunctionBeginUser;
  *list = (Elements){.n_nodes = all->n_nodes, .strain = all->strain};
  for (PetscInt i = 0; i < all->n; i++) list->n += of_group[all->group[i]] > 0.;
  list->n_padded = (list->n + BATCH - 1) / BATCH * BATCH;
  PetscCall(PetscMalloc3(list->n_padded * list->n_nodes, &list->vertex, list->n_padded, &list->group,
                         list->n_padded, beta));
  for (PetscInt i = 0, to = 0, last = 0; to < list->n_padded; i++) {
    const PetscBool pads = (PetscBool)(i >= all->n);
    if (!pads && !(of_group[all->group[i]] > 0.)) continue;
    if (!pads) last = i;
    for (int k = 0; k < list->n_nodes; k++) list->vertex[VertexPlace(list, to, k)] = VertexOf(all, last, k);
    list->group[to] = all->group[last];
    (*beta)[to++] = pads ? 0. : of_group[all->group[last]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares a dynamic stage, from the betas of the groups. */
static PetscErrorCode prepare(const Model *m, BlockDamping *d)
{
  PetscBool any = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(clear(d));
  for (PetscInt g = 0; g < m->materials.n_groups; g++) any = (PetscBool)(any || d->of_group[g] > 0.);
  for (PetscInt b = 0; b < m->condensed.n; b++)
    m->condensed.body[b].beta = d->of_group[find_other(m, m->condensed.body + b, d->of_group, -1.)],
    m->condensed.body[b].given_known = PETSC_FALSE;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  d->active = PETSC_TRUE;
  for (int l = 0; l < DEFORMABLE_LISTS; l++)
    PetscCall(list_damped(m->mesh.elements + l, d->of_group, d->list + l, d->beta + l));
  d->n = m->mesh.n_owned + m->ghosts.n_element;
  PetscCall(PetscCalloc1(2 * d->n, &d->now));
  PetscCall(PetscCalloc1(2 * d->n, &d->before));
  PetscCall(PetscCalloc1(2 * d->n, &d->f));
  PetscCall(PetscCalloc1(2 * d->n, &d->f_before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode begin(const TermView *v)
{
  BlockDamping *d = v->memory;
  PetscFunctionBeginUser;
  find_betas(v->scene, v->stage, v->m, d->of_group);
  PetscCall(prepare(v->m, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- dynamic stages */

/* Adds beta S du / dt at kept vertices, from the forces S u that the bodies have just computed. */
static void add_condensed(const Model *m, const BlockDamping *d, PetscReal rate)
{
  for (Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    if (c->beta_now == 0.) continue;
    if (!c->given_known) CondensedForces(c, d->before, c->given_before);
    c->given_known = PETSC_TRUE;
    for (PetscInt i = 0; i < c->n_kept; i++)
      d->f[c->kept[i]] += rate * c->beta_now * (c->given[i] - c->given_before[i]);
  }
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  BlockDamping *d = memory;
  const PetscBool damps = (PetscBool)(at->contacts->rate > 0. && d->moved);
  PetscFunctionBeginUser;
  if (!d->active) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < at->m->condensed.n; b++)
    at->m->condensed.body[b].beta_now = damps ? at->m->condensed.body[b].beta : 0.;
  memcpy(d->now, at->u, 2 * d->n * sizeof *d->now);
  memset(d->f, 0, 2 * d->n * sizeof *d->f);
  if (!damps) PetscFunctionReturn(PETSC_SUCCESS);
  DampedForces(at->m, d, at->contacts->rate);
  add_condensed(at->m, d, at->contacts->rate);
  for (PetscInt i = 0; i < 2 * at->m->mesh.n_moving; i++) f[i] += d->f[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void advance(void *memory, const Model *m, State *state)
{
  BlockDamping *d = memory;
  (void)state;
  if (!d->active) return;
  for (PetscInt i = 0; i < 2 * m->mesh.n_moving && d->moved; i++)
    d->lost += 0.5 * (d->f[i] + d->f_before[i]) * (d->now[i] - d->before[i]);
  PetscReal *const now = d->now, *const f = d->f;
  d->now = d->before, d->before = now;
  d->f = d->f_before, d->f_before = f;
  for (Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    PetscReal *const given = c->given;
    c->given = c->given_before, c->given_before = given;
    c->given_known = PETSC_TRUE;
  }
  d->moved = PETSC_TRUE;
}

/* Adds the row sums (28), each block times its beta. */
static PetscErrorCode drag(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *c)
{
  const BlockDamping *d = memory;
  PetscReal K[LANES][64];
  PetscFunctionBeginUser;
  (void)anywhere;
  for (int l = 0; l < DEFORMABLE_LISTS && d->active; l++)
    for (PetscInt first = 0, n = 2 * d->list[l].n_nodes; first < d->list[l].n_padded; first += LANES) {
      ElementMatrices(at->m, d->list + l, d->list[l].n_nodes, first, NULL, K);
      for (PetscInt i = first; i < PetscMin(first + LANES, d->list[l].n); i++)
        for (PetscInt v = 0; v < n / 2; v++) {
          PetscReal row[2] = {0., 0.};
          for (PetscInt j = 0; j < 2 * n; j++) row[j / n] += PetscAbsReal(K[i - first][2 * v * n + j]);
          c[VertexOf(d->list + l, i, v)] += d->beta[l][i] * PetscMax(row[0], row[1]);
        }
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal BlockDampingWork(const void *memory)
{
  return ((const BlockDamping *)memory)->lost;
}

/* ---- archive */

/* Sends the displacements one step before to other ranks: each rank has read only the displacements of its
   own vertices. */
static PetscErrorCode send_before(const Model *m, BlockDamping *d)
{
  PetscReal *u;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &u));
  PetscCall(PetscArraycpy(u, d->before, 2 * m->mesh.n_owned));
  PetscCall(GhostBegin(m, u));
  PetscCall(GhostEnd(m, u));
  PetscCall(PetscArraycpy(d->before, u, 2 * d->n));
  PetscCall(PetscFree(u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode archive(Archive *a, const TermView *v)
{
  BlockDamping *d = v->memory;
  PetscInt is[2] = {d->active, d->moved};
  PetscReal sum = d->lost;
  PetscBool mine = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "block_damping", 2, is));
  if (!is[0]) {
    if (a->reading) PetscCall(clear(d));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ArchiveReals(a, "block_damping_beta", v->m->materials.n_groups, d->of_group));
  if (a->reading) PetscCall(prepare(v->m, d));
  PetscCall(ArchiveVertices(a, v->m, "block_damping_u", d->before));
  PetscCall(ArchiveVertices(a, v->m, "block_damping_f", d->f_before));
  PetscReal summand = sum;
  PetscCall(ArchiveSums(a, "block_damping_lost", 1, &sum));
  PetscCall(ArchiveSummands(a, "block_damping_lost_by_rank", 1, &summand, &mine));
  if (!a->reading) PetscFunctionReturn(PETSC_SUCCESS);
  d->lost = mine ? summand : sum, d->moved = (PetscBool)is[1];
  PetscCall(send_before(v->m, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const TermKind Block_damping_term = {.name = "block_damping",
                                     .phase = PHASE_BODIES,
                                     .create = create,
                                     .destroy = destroy,
                                     .begin = begin,
                                     .forces = forces,
                                     .advance = advance,
                                     .drag = drag,
                                     .archive = archive};

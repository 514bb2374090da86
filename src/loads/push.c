/* push.c: prescribes the displacement of a point, a body, a group or the vertices on which loads act, and
   computes the force that keeps them there, as a force term.

   With weights w at vertices, the prescribed displacement is c = sum w . (u - u_start), and the force is R w:
   R does the work R dc. The weight of a point is the direction. The weights of a body or a group are the
   shares of its vertices in its area times the direction, those of loads their forces over their resultant.
   So the weights along the direction add up to 1, and R is the resultant. Only c is prescribed: the body may
   turn and strain.

   Cycles (11)-(20) move a degree of freedom d with the mass m_d. Each cycle makes its step with the R of the
   cycle before, and c misses its aim by e. Then R has lacked

     dR = e / (dt^2 d2 sum g_d^2 / m_d),

   where g = dc/du_d (of a rigid body the force and moment of its w). The displacement by dR is added to u and
   v. The force f takes over dR, which then does not look like stiffness to the damping. Local damping moves a
   degree of freedom by up to 1 + local times what its force alone does. So R takes over dR/(1 + local): more
   would overshoot, and the cycles would make energy where a joint breaks. This is the motion of a constraint:
   it adds no stiffness, so the step stays stable. In large strain g turns with a rigid body;
   its second-order error is gone in the next cycle. Over the cycles of a ramp the aim goes by s^2 (3 - 2 s),
   so that it starts and ends at rest. */
#include "loads/loads.h"
#include "base/reproducible.h"

static PetscErrorCode create(const TermView *v, void **memory)
{
  Push *push = NULL;
  PetscFunctionBeginUser;
  if (ScenePushes(v->scene)) PetscCall(PetscNew(&push));
  *memory = push;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushEnd(Push *push)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(push->vertex, push->w, push->slot, push->term));
  PetscCall(PetscFree(push->rows));
  *push = (Push){.n = 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode destroy(const Scene *scene, void **memory)
{
  PetscFunctionBeginUser;
  (void)scene;
  if (*memory) PetscCall(PushEnd(*memory));
  PetscCall(PetscFree(*memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes the force that an earlier pushover has left, unless this stage is one too. */
static PetscErrorCode begin(const TermView *v)
{
  Push *push = v->memory;
  PetscFunctionBeginUser;
  if (push && v->stage->kind != STAGE_PUSHOVER) PetscCall(PushEnd(push));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode forces(void *memory, const Instant *at, PetscReal *f)
{
  const Push *push = memory;
  PetscFunctionBeginUser;
  (void)at;
  for (PetscInt i = 0; push && push->acts && i < 2 * push->n; i++)
    f[2 * push->vertex[i / 2] + i % 2] -= push->force * push->w[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes dc/du for the three degrees of freedom of the rigid body with vertices from place i of the list
   on. Returns the place behind them. */
static PetscInt of_body(const Model *m, const State *s, const Push *push, PetscInt i, PetscInt *body,
                        PetscReal g[3])
{
  const PetscReal *u = s->u + 3 * m->rigid.n, moving = m->materials.strain == STRAIN_LARGE ? 1. : 0.;
  const PetscInt b = RigidOfVertex(m, push->vertex[i]);
  g[0] = g[1] = g[2] = 0., *body = b;
  for (; i < push->n && push->vertex[i] < m->rigid.start[b + 1]; i++) {
    const PetscInt v = push->vertex[i];
    PetscReal r[2];
    for (int k = 0; k < 2; k++)
      r[k] = m->mesh.X[2 * v + k] - m->rigid.X[2 * b + k] + moving * (u[2 * v + k] - s->u[3 * b + k]);
    g[0] += push->w[2 * i], g[1] += push->w[2 * i + 1];
    g[2] += r[0] * push->w[2 * i + 1] - r[1] * push->w[2 * i];
  }
  return i;
}

/* Collective. Finds sum[0] = sum w . u [m] and sum[1] = sum g^2 / m. */
static PetscErrorCode find_sums(const Model *m, const State *s, const Push *push, PetscReal sum[2])
{
  const PetscInt at = 3 * m->rigid.n;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < push->n; i++) {
    const PetscInt d = at + 2 * push->vertex[i];
    push->slot[n] = 0;
    push->term[n++] = push->w[2 * i] * s->u[d] + push->w[2 * i + 1] * s->u[d + 1];
    if (push->vertex[i] >= m->mesh.n_deformable) continue;
    push->slot[n] = 1;
    push->term[n++] = PetscSqr(push->w[2 * i]) * s->m_inv[d] + PetscSqr(push->w[2 * i + 1]) * s->m_inv[d + 1];
  }
  PetscInt i = 0;
  while (i < push->n && push->vertex[i] < m->mesh.n_deformable) i++;
  while (i < push->n) {
    PetscReal g[3];
    PetscInt b;
    i = of_body(m, s, push, i, &b, g);
    push->slot[n] = 1, push->term[n] = 0.;
    for (int k = 0; k < 3; k++) push->term[n] += PetscSqr(g[k]) * s->m_inv[3 * b + k];
    n++;
  }
  PetscCall(BinnedSums(m->comm, n, push->slot, push->term, 2, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether a support holds a displacement along which w acts. row: the support, -1: none. free: some
   displacement or rotation is not held. */
static void find_held(const Model *m, const State *s, const Push *push, PetscInt *row, PetscInt *free)
{
  PetscInt i = 0, b;
  PetscReal g[3];
  for (; i < push->n && push->vertex[i] < m->mesh.n_deformable; i++)
    for (int k = 0; k < 2; k++) {
      const PetscInt d = 3 * m->rigid.n + 2 * push->vertex[i] + k;
      if (push->w[2 * i + k] == 0.) continue;
      if (Held(m, d)) *row = PetscMax(*row, SupportRow(m, d));
      *free |= !Held(m, d);
    }
  while (i < push->n) {
    i = of_body(m, s, push, i, &b, g);
    for (int k = 0; k < 3; k++) {
      if (g[k] == 0.) continue;
      if (Held(m, 3 * b + k) && k < 2) *row = PetscMax(*row, SupportRow(m, 3 * b + k));
      *free |= !Held(m, 3 * b + k);
    }
  }
}

/* Collective. Stores the owned vertices at which f is not zero, with their weights f / size. */
static PetscErrorCode take_vertices(const Model *m, const PetscReal *f, PetscReal size, Push *push)
{
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < m->mesh.n_moving; v++) n += f[2 * v] != 0. || f[2 * v + 1] != 0.;
  PetscCall(PetscMalloc4(n, &push->vertex, 2 * n, &push->w, 2 * n, &push->slot, 2 * n, &push->term));
  for (PetscInt v = 0; v < m->mesh.n_moving; v++) {
    if (f[2 * v] == 0. && f[2 * v + 1] == 0.) continue;
    for (int k = 0; k < 2; k++) push->w[2 * push->n + k] = f[2 * v + k] / size;
    push->vertex[push->n++] = v;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushBegin(const Scene *scene, const Model *m, const State *state, const PetscReal *f,
                         const PetscReal direction[2], PetscInt rows, Push *push,
                         char message[MESSAGE_LENGTH])
{
  PetscInt *slot, held[3] = {-1, 0, 0}; // a support that holds; whether something is free; vertices
  PetscReal *term, size;
  PetscFunctionBeginUser;
  PetscCall(PushEnd(push));
  PetscCall(PetscCalloc2(m->mesh.n_owned, &slot, m->mesh.n_owned, &term));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    term[v] = f[2 * v] * direction[0] + f[2 * v + 1] * direction[1];
  PetscCall(BinnedSums(m->comm, m->mesh.n_owned, slot, term, 1, &size));
  PetscCall(PetscFree2(slot, term));
  PetscCall(take_vertices(m, f, size, push));
  PetscCall(PetscCalloc1(rows * PUSH_COLUMNS, &push->rows));
  find_held(m, state, push, held, held + 1);
  held[2] = push->n;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, held, 3, MPIU_INT, MPI_MAX, m->comm));
  if (!(size > 0.))
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "nothing is there to be moved"));
  else if (!held[1] || (held[2] == 1 && held[0] >= 0)) // nothing is free, or the one point is held
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "supports.%s holds what is to be moved",
                            held[0] < 0 ? "?" : scene->supports[held[0]].name));
  push->ramp = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushFromHere(const Model *m, const State *state, Push *push)
{
  PetscReal sum[2], *term;
  PetscInt *slot;
  PetscFunctionBeginUser;
  PetscCall(find_sums(m, state, push, sum));
  push->start = sum[0], push->mass = 1. / sum[1], push->acts = PETSC_TRUE;
  PetscCall(PetscCalloc2(m->n_dof, &slot, m->n_dof, &term));
  for (PetscInt d = 0; d < m->n_dof; d++)
    if (!Held(m, d) && !(d < 3 * m->rigid.n && d % 3 == 2)) term[d] = PetscAbsReal(state->f_ext[d]);
  PetscCall(BinnedSums(m->comm, m->n_dof, slot, term, 1, &push->scale));
  PetscCall(PetscFree2(slot, term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushAim(const Model *m, const State *state, PetscReal ramp, Push *push)
{
  const PetscReal before = push->aim;
  PetscReal sum[2];
  PetscFunctionBeginUser;
  if (!push->acts) PetscFunctionReturn(PETSC_SUCCESS);
  if (ramp < push->ramp) { // an increment begins, or begins again
    PetscCall(find_sums(m, state, push, sum));
    push->from = sum[0] - push->start, push->work = 0.;
  }
  push->ramp = ramp;
  push->aim = ramp < 1. ? push->from + (push->to - push->from) * ramp * ramp * (3. - 2. * ramp) : push->to;
  push->work += PetscAbsReal(push->force * (push->aim - before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PushHold(const Model *m, State *s, Push *push)
{
  const PetscReal d2 = (1. + s->local) / (1. + 0.5 * s->alpha * s->dt);
  const PetscInt at = 3 * m->rigid.n;
  PetscReal sum[2], g[3];
  PetscInt i = 0, b;
  PetscFunctionBeginUser;
  if (!push->acts) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_sums(m, s, push, sum));
  push->mass = 1. / sum[1];
  const PetscReal lacks = (push->aim - (sum[0] - push->start)) / sum[1]; // [N s2]
  const PetscReal more = lacks / (s->dt * s->dt * d2);
  push->force += more;
  for (; i < push->n && push->vertex[i] < m->mesh.n_deformable; i++)
    for (int k = 0; k < 2; k++) {
      const PetscInt d = at + 2 * push->vertex[i] + k;
      const PetscReal du = push->w[2 * i + k] * s->m_inv[d] * lacks;
      s->u[d] += du, s->v[d] += du / s->dt, s->f[d] -= more * push->w[2 * i + k];
    }
  const PetscBool rigid = (PetscBool)(i < push->n);
  while (i < push->n) {
    i = of_body(m, s, push, i, &b, g);
    for (int k = 0; k < 3; k++) {
      const PetscReal du = g[k] * s->m_inv[3 * b + k] * lacks;
      s->u[3 * b + k] += du, s->v[3 * b + k] += du / s->dt, s->f[3 * b + k] -= more * g[k];
    }
  }
  if (rigid) RigidMotion(m, s->u);
  PetscCall(GhostBegin(m, s->u + at));
  PetscCall(GhostEnd(m, s->u + at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PetscReal *PushPeak(const Push *push)
{
  const PetscReal *most = push->rows, *end = most + PUSH_COLUMNS * push->n_rows;
  for (const PetscReal *row = most; row < end; row += PUSH_COLUMNS)
    if (row[PUSH_RESTS] > 0. && PetscAbsReal(row[PUSH_FORCE]) > PetscAbsReal(most[PUSH_FORCE])) most = row;
  return most;
}

/* Writes the path, its largest force, and its equilibria. */
static void summary(Json *json, const TermView *v)
{
  static const char *const names[] = {"displacement", "force", "ratio", "equilibrium"};
  const Push *push = v->memory;
  if (!push || !push->n_rows || v->stage->kind != STAGE_PUSHOVER) return;
  const PetscReal *most = PushPeak(push);
  JsonOpen(json, "pushover");
  JsonNumbers(json, {"peak_force", most[PUSH_FORCE]}, {"peak_displacement", most[PUSH_MOVED]});
  if (push->load > 0.)
    JsonNumbers(json, {"load", push->load}, {"peak_factor", most[PUSH_FORCE] / push->load});
  for (int c = 0; c < PUSH_COLUMNS; c++) {
    JsonList(json, names[c]);
    for (PetscInt i = 0; i < push->n_rows; i++) JsonNumber(json, NULL, push->rows[PUSH_COLUMNS * i + c]);
    JsonClose(json);
  }
  JsonClose(json);
}

const TermKind Push_term = {.name = "push",
                            .create = create,
                            .destroy = destroy,
                            .begin = begin,
                            .forces = forces,
                            .summary = summary};

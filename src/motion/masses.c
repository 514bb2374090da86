/* masses.c: finds bounds of the stiffness, and the scaled masses and time steps for them (sections 3.1-3.2).

   Force terms add the stiffness at vertices (term.h: bound).

   Rigid bodies. With D = diag(k_i) a bound of the vertex stiffness, T'D T bounds the stiffness of the body:
     [ K 0 -c_y; 0 K c_x; . . K_rot ],  K = sum k_i, K_rot = sum k_i r_i^2 (31), c = sum k_i r_i,
   whose eigenvalues, with rotation in units of l = sqrt(K_rot / K), are K and K +- |c|/l: K + |c|/l bounds
   the translations, K_rot + |c| l the rotation. */
#include "motion/motion.h"
#include "blocks/blocks.h"

/* [-] The mass of stiffness_mass.c over its least for a stable step of elastic motions, because a tangent of
   joints that slide is not symmetric. Choice: 1, 2, 4 and 8 take nearly as many cycles. */
static const PetscReal MASS_MARGIN = 2.;

/* Finds the row bounds of the three dofs of body b. k: (vertices,). */
static void body_stiffness(const Model *m, PetscInt b, const PetscReal *k, PetscReal row[3])
{
  const PetscReal *C = m->rigid.X + 2 * b;
  PetscReal K = 0., K_rot = 0., cx = 0., cy = 0.;
  for (PetscInt v = m->rigid.start[b]; v < m->rigid.start[b + 1]; v++) {
    const PetscReal rx = m->mesh.X[2 * v] - C[0], ry = m->mesh.X[2 * v + 1] - C[1];
    K += k[v], K_rot += k[v] * (rx * rx + ry * ry); // (31)
    cx += k[v] * rx, cy += k[v] * ry;
  }
  if (K == 0.) { // touches nothing: any mass is stable
    row[0] = row[1] = row[2] = 0.;
    return;
  }
  const PetscReal l = PetscSqrtReal(K_rot / K), c = PetscHypotReal(cx, cy);
  row[0] = row[1] = K + c / l;
  row[2] = K_rot + c * l;
}

/* Gives bodies without contact the masses of contacts that may come. With true masses, in steps of 1 s, they
   would fall by 10 m a cycle, and through everything. */
static PetscErrorCode loose_masses(const Scene *scene, const Model *m, const Joint *joints, PetscReal factor,
                                   State *state)
{
  const Instant at = {.scene = scene, .m = m, .joints = joints};
  PetscReal *mass = state->m, *k;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &k));
  PetscCall(TermsBound(state, &at, PETSC_TRUE, k));
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    PetscReal row[3];
    if (mass[3 * b] > 0.) continue;
    body_stiffness(m, b, k, row);
    for (int i = 0; i < 3; i++)
      mass[3 * b + i] = row[i] > 0. ? factor * row[i] : PetscMax(DofMass(m, 3 * b + i), 1.);
  }
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ScaledMasses(const Scene *scene, const Model *m, const Joint *joints, Contacts *contacts,
                            State *state)
{
  const PetscInt at = 3 * m->rigid.n;
  const Instant now = {.scene = scene, .m = m, .joints = joints, .contacts = contacts};
  const PetscBool may_land = (PetscBool)(contacts->outgrown ||
                                         SceneFindsAnew(scene)); // contacts may come later
  PetscBool loose = PETSC_FALSE;
  PetscReal *k;
  PetscFunctionBeginUser;
  state->dt = 1.;
  // (33), dt/safety for dt; damping by beta takes (1 + 2 beta) (omega dt)^2 <= 4, local damping, which what a
  // pushover moves has on its way, can add its part of the unbalanced force
  const Push *push = PushOf(state);
  const PetscReal walks = push && push->acts ? PUSH_LOCAL : 0.;
  const PetscReal pushed = 1. + PetscMax(walks, scene->damping == DAMPING_LOCAL ? scene->local : 0.);
  const PetscReal factor = 0.25 * state->dt * state->dt * (1. + 2. * state->beta) * pushed /
                           (scene->safety * scene->safety) * (state->step_divisor * state->step_divisor);
  if (state->stiffness_mass) state->stiffness_mass->scale = MASS_MARGIN * factor;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &k));
  PetscCall(TermsBound(state, &now, PETSC_FALSE, k));
  for (PetscInt b = 0; b < m->rigid.n; b++) {
    PetscReal row[3];
    body_stiffness(m, b, k, row);
    loose = (PetscBool)(loose || !(row[0] > 0.));
    for (int i = 0; i < 3; i++)
      state->m[3 * b + i] = row[i] > 0. ? factor * row[i]
                            : may_land  ? 0.
                                        : PetscMax(DofMass(m, 3 * b + i), 1.);
  }
  if (loose && may_land) PetscCall(loose_masses(scene, m, joints, factor, state));
  for (PetscInt d = 0; d < 2 * m->mesh.n_deformable; d++) state->m[at + d] = factor * k[d / 2];
  for (PetscInt d = 0; d < m->n_dof; d++) state->m_inv[d] = Held(m, d) ? 0. : 1. / state->m[d];
  PetscCall(PetscFree(k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the step of a stage in time */

/* Returns the largest step [s] of a degree of freedom of mass m, with row sums k of stiffness and c of
   dampers that use the velocity of half a step before: dt^2 k + 2 dt c <= 4 m. */
static PetscReal step_of(PetscReal m, PetscReal k, PetscReal c)
{
  if (c > 0.) return 4. * m / (c + PetscSqrtReal(c * c + 4. * k * m));
  return k > 0. ? 2. * PetscSqrtReal(m / k) : PETSC_INFINITY; // (25), (32)
}

/* The degree of freedom with the least step so far. */
typedef struct {
  PetscReal dt;     /* [s] */
  PetscInt dof;     /* -1: none */
  PetscReal joints; /* [-] part of the stiffness or damping that joints give; NaN: the rows show it */
} Least;

static void take_least(PetscReal dt, PetscInt dof, PetscReal joints, Least *least)
{
  if (dt < least->dt) *least = (Least){dt, dof, joints};
}

static PetscErrorCode step_of_condensed(const Model *m, const Condensed *body, const PetscReal *k,
                                        const PetscReal *c, Least least[2])
{
  CondensedStep step[2];
  PetscFunctionBeginUser;
  PetscCall(CondensedBound(m, body, k, c, step));
  for (int i = 0; i < 2; i++) take_least(step[i].dt, step[i].dof, step[i].joints, least + i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the value of a vertex array at degree of freedom d; of a rigid body the row of body_stiffness. */
static PetscReal row_of(const Model *m, PetscInt d, const PetscReal *at_vertices)
{
  const PetscInt at = 3 * m->rigid.n;
  PetscReal row[3];
  if (d >= at) return at_vertices[(d - at) / 2];
  body_stiffness(m, d / 3, at_vertices, row);
  return row[d % 3];
}

/* Returns the first vertex of degree of freedom d. */
static PetscInt vertex_of(const Model *m, PetscInt d)
{
  const PetscInt at = 3 * m->rigid.n;
  return d < at ? m->rigid.start[d / 3] : (d - at) / 2;
}

/* Decides whether a degree of freedom has the stiffness of blocks alone: no other term adds stiffness or
   damping there. */
static PetscBool blocks_alone(const Model *m, PetscInt d, const PetscReal *k, const PetscReal *of_blocks,
                              const PetscReal *c)
{
  const PetscInt v = (d - 3 * m->rigid.n) / 2;
  return (PetscBool)(!Held(m, d) && k[v] > 0. && k[v] == of_blocks[v] && c[v] == 0.);
}

/* Finds better row sums by weights. By Collatz and Wielandt every eigenvalue of M^-1 K is at most the largest
   sum_j |K_ij| x_j / (m_i x_i), for any positive weights x. All weights 1 give Gershgorin's bound (28).
   Weights that follow the fastest vibration give nearly its square. They are found by the power method and
   are at least 1, so that they spread only about fast blocks. Weights stay 1 where another term is stiff or
   damps, because its bound has no weights; at held degrees of freedom they are 0. This requires a K that does
   not turn: small strain. Rigid and condensed bodies have bounds of their own without weights, which weighted
   neighbours would falsify: scenes with such bodies keep (28). Writes the rows of the best weights,
   (n_vertices, 2), at degrees of freedom of deformable vertices. */
static PetscErrorCode weigh_rows(const Instant *now, const PetscReal *k, const PetscReal *c, PetscReal *best)
{
  enum { SWEEPS = 20 };
  // [-] SPREAD: part of the bound from which weights grow; WORTH: least gain of a sweep
  static const PetscReal SPREAD = 0.6, WORTH = 1e-3;
  const Model *m = now->m;
  const PetscInt at = 3 * m->rigid.n, n = m->mesh.n_vertices + DUMMY_VERTICES,
                 n_dof = 2 * m->mesh.n_deformable;
  PetscReal *of_blocks, *x, *rows, least = PETSC_INFINITY, first = 0.;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(n, &of_blocks, 2 * n, &x, 2 * n, &rows));
  PetscCall(ElementStiffness(m, of_blocks));
  for (PetscInt i = 0; i < 2 * n; i++) x[i] = 1.;
  for (PetscInt i = 0; i < n_dof; i++) x[i] = !Held(m, at + i);
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    PetscReal most = 0.;
    PetscCall(GhostBegin(m, x));
    PetscCall(GhostEnd(m, x));
    PetscCall(PetscArrayzero(rows, 2 * n));
    ElementWeightedRows(m, x, rows);
    for (PetscInt i = 0; i < n_dof; i++) {
      if (!(x[i] > 0.)) continue;
      rows[i] = rows[i] / x[i] + (k[i / 2] - of_blocks[i / 2]);
      if (!IsCondensed(m, at + i)) most = PetscMax(most, rows[i] / DofMass(m, at + i));
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, m->comm));
    if (most < least) PetscCall(PetscArraycpy(best, rows, n_dof));
    if (!(most < (1. - WORTH) * least)) break;
    least = most, first = sweep ? first : most;
    for (PetscInt i = 0; i < n_dof; i++)
      if (blocks_alone(m, at + i, k, of_blocks, c))
        x[i] = PetscMax(1., rows[i] * x[i] / (SPREAD * first * DofMass(m, at + i)));
  }
  PetscCall(PetscFree3(of_blocks, x, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the steps that vertices of condensed bodies would have without condensing. */
static PetscErrorCode steps_of_blocks(const Instant *now, PetscBool anywhere, Least least[2])
{
  const Model *m = now->m;
  const PetscInt n = m->mesh.n_vertices + DUMMY_VERTICES;
  PetscReal *blocks, *springs, *dampers, *beta;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc4(n, &blocks, n, &springs, n, &dampers, m->mesh.n_condensed_global, &beta));
  for (PetscInt b = 0; b < m->condensed.n; b++) beta[m->condensed.body[b].number] = m->condensed.body[b].beta;
  PetscCall(ElementStiffnessCondensed(m, blocks));
  PetscCall(Contacts_term.bound(NULL, now, anywhere, springs));
  PetscCall(Contacts_term.drag(NULL, now, anywhere, dampers));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    const PetscInt d = 3 * m->rigid.n + 2 * v;
    if (m->mesh.vertex_condensed[v] < 0 || !(m->vertex_mass[v] > 0.) || (Held(m, d) && Held(m, d + 1)))
      continue;
    dampers[v] += beta[m->mesh.vertex_condensed[v]] * blocks[v];
    for (int i = 0; i < 2; i++)
      if (!i || dampers[v] > 0.)
        take_least(step_of(m->vertex_mass[v], blocks[v] + springs[v], i ? dampers[v] : 0.), -1, NAN,
                   least + i);
  }
  PetscCall(PetscFree4(blocks, springs, dampers, beta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the step and the cost of a step with the step and the cost of the blocks without condensing.
   least: of the parts not condensed. */
static PetscErrorCode compare_with_blocks(const Instant *now, PetscBool anywhere, PetscReal factor,
                                          Least least[2], TimeStep *step)
{
  // [-] measured time of a block with its vertices over the time of a product; with beta, computed twice
  static const PetscReal BLOCK = 55., DAMPED_BLOCK = 120.;
  const Model *m = now->m;
  PetscBool damped = PETSC_FALSE;
  PetscReal work[2] = {0., 0.}, dt[2]; // of bodies, of their blocks
  PetscFunctionBeginUser;
  PetscCall(steps_of_blocks(now, anywhere, least));
  for (int i = 0; i < 2; i++) dt[i] = least[i].dt;
  for (const Condensed *c = m->condensed.body; c < m->condensed.body + m->condensed.n; c++) {
    work[0] += CondensedProducts(c);
    damped = (PetscBool)(damped || c->beta > 0.);
  }
  work[1] = (damped ? DAMPED_BLOCK : BLOCK) * (PetscReal)(m->mesh.condensed_q4.n + m->mesh.condensed_t3.n);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 2, MPIU_REAL, MPI_SUM, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, dt, 2, MPIU_REAL, MPI_MIN, m->comm));
  step->mesh = PetscMin(factor * dt[0], PetscMax(factor, DAMPED_FACTOR) * dt[1]);
  step->work = work[0] / work[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the true masses of all degrees of freedom; free ones must have a mass. */
static PetscErrorCode true_masses(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    state->m[d] = DofMass(m, d);
    state->m_inv[d] = Held(m, d) ? 0. : 1. / DofMass(m, d);
    if (Held(m, d) || IsCondensed(m, d) || DofMass(m, d) > 0. || message[0]) continue;
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "%s: stages.%s: vertex %" PetscInt_FMT
                            " has no mass: a dynamic stage needs density > 0 in every group "
                            "that is not held",
                            scene->file, stage->name, m->mesh.vertex_file[vertex_of(m, d)]));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the group of the first block at a local vertex. */
static PetscInt group_at(const Model *m, PetscInt v)
{
  for (const Elements *list = m->mesh.elements; list < m->mesh.elements + ELEMENT_LISTS; list++)
    for (PetscInt e = 0; e < list->n; e++)
      for (int k = 0; k < list->n_nodes; k++)
        if (VertexOf(list, e, k) == v) return list->group[e];
  return 0;
}

/* Returns the joint of largest stiffness, or largest dashpot stiffness. */
static PetscInt stiffest_joint(const Scene *scene, const Joint *joints, PetscBool dashpots)
{
  PetscInt stiffest = 0;
  PetscReal most = -1.;
  for (PetscInt j = 0; j < scene->n_joints; j++) {
    const PetscReal k = dashpots ? joints[j].damping * joints[j].k_n : PetscMax(joints[j].k_n, joints[j].k_s);
    if (k > most) most = k, stiffest = j;
  }
  return stiffest;
}

/* Describes what limits the step: blocks, joints, or their dampers. all: rows of all terms at vertices. */
static PetscErrorCode describe_limit(const Instant *now, const Stage *stage, PetscBool anywhere,
                                     const Least *least, const PetscReal *all, PetscBool damped, char words[])
{
  const Model *m = now->m;
  const PetscInt d = least->dof, v = vertex_of(m, d), at = 3 * m->rigid.n;
  const PetscReal *X = d < at ? m->rigid.X + 2 * (d / 3) : m->mesh.X + 2 * v;
  const char *group = m->materials.names[group_at(m, v)];
  PetscReal *joints;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_vertices + DUMMY_VERTICES, &joints));
  PetscCall((damped ? Contacts_term.drag : Contacts_term.bound)(NULL, now, anywhere, joints));
  const PetscReal of_joints = PetscIsNanReal(least->joints) ? row_of(m, d, joints) / row_of(m, d, all)
                                                            : least->joints;
  if (of_joints < 0.5)
    PetscCall(PetscSNPrintf(words, STEP_WORDS, "%s group %s at x = %.4g m, y = %.4g m",
                            damped ? "beta of" : "blocks of", group, (double)X[0], (double)X[1]));
  else
    PetscCall(PetscSNPrintf(words, STEP_WORDS, "%s joint %s at group %s, x = %.4g m, y = %.4g m",
                            damped ? "damping of" : "stiffness of",
                            now->scene->joints[stiffest_joint(now->scene, stage->joints, damped)].name, group,
                            (double)X[0], (double)X[1]));
  PetscCall(PetscFree(joints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shares the words of the rank with the least step; of several ranks, the one with the lowest vertex. */
static PetscErrorCode share_words(const Model *m, PetscReal mine, PetscReal least, PetscInt gid, char words[])
{
  PetscInt first = mine == least ? gid : PETSC_MAX_INT;
  PetscMPIInt rank, from = m->size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPIU_INT, MPI_MIN, m->comm));
  rank = mine == least && gid == first ? m->rank : m->size;
  PetscCallMPI(MPI_Allreduce(&rank, &from, 1, MPI_INT, MPI_MIN, m->comm));
  if (from < m->size) PetscCallMPI(MPI_Bcast(words, STEP_WORDS, MPI_CHAR, from, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DynamicTimeStep(const Scene *scene, const Model *m, const Stage *stage, Contacts *contacts,
                               PetscReal factor, State *state, TimeStep *step)
{
  const Instant now = {.scene = scene, .m = m, .joints = stage->joints, .contacts = contacts};
  // contacts that never change need no reserve for others
  const PetscBool anywhere = (PetscBool)(!PetscIsNanReal(stage->dt_factor) || ContactsVary(contacts, stage));
  Least least[2] = {{PETSC_INFINITY, -1, NAN}, {PETSC_INFINITY, -1, NAN}}, others[2];
  PetscReal *k, *c, *rows, of_all[2];
  PetscFunctionBeginUser;
  PetscCall(true_masses(scene, m, stage, state));
  PetscCall(PetscCalloc3(m->mesh.n_vertices + DUMMY_VERTICES, &k, m->mesh.n_vertices + DUMMY_VERTICES, &c,
                         2 * m->mesh.n_deformable, &rows));
  PetscCall(TermsBound(state, &now, anywhere, k));
  PetscCall(TermsDrag(state, &now, anywhere, c));
  for (PetscInt i = 0; i < 2 * m->mesh.n_deformable; i++) rows[i] = k[i / 2];
  if (!anywhere && m->materials.strain == STRAIN_SMALL && !m->mesh.n_rigid_global &&
      !m->mesh.n_condensed_global)
    PetscCall(weigh_rows(&now, k, c, rows));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal row = d < 3 * m->rigid.n ? row_of(m, d, k) : rows[d - 3 * m->rigid.n],
                    drag = row_of(m, d, c), mass = DofMass(m, d);
    const PetscReal dt[2] = {step_of(mass, row, 0.), drag > 0. ? step_of(mass, row, drag) : PETSC_INFINITY};
    for (int i = 0; i < 2 && !Held(m, d) && !IsCondensed(m, d); i++) take_least(dt[i], d, NAN, least + i);
  }
  PetscCall(PetscArraycpy(others, least, 2));
  for (PetscInt b = 0; b < m->condensed.n; b++)
    PetscCall(step_of_condensed(m, m->condensed.body + b, k, c, least));
  step->mesh = 0.;
  if (m->mesh.n_condensed_global) PetscCall(compare_with_blocks(&now, anywhere, factor, others, step));
  for (int i = 0; i < 2; i++) of_all[i] = least[i].dt;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of_all, 2, MPIU_REAL, MPI_MIN, m->comm));
  step->limit = of_all[0] < PETSC_INFINITY ? of_all[0] : stage->duration;
  step->damped = of_all[1];
  step->dt = PetscMin(factor * step->limit, PetscMax(factor, DAMPED_FACTOR) * step->damped);
  const int which = factor * step->limit > step->dt;
  const Least *mine = least + which;
  step->words[0] = '\0';
  if (mine->dof >= 0 && mine->dt == of_all[which])
    PetscCall(describe_limit(&now, stage, anywhere, mine, which ? c : k, (PetscBool)which, step->words));
  PetscCall(share_words(m, mine->dof < 0 ? PETSC_INFINITY : mine->dt, of_all[which],
                        mine->dof < 0 ? PETSC_MAX_INT : m->mesh.vertex_gid[vertex_of(m, mine->dof)],
                        step->words));
  PetscCall(PetscFree3(k, c, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

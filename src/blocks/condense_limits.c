/* condense_limits.c: tests whether the assumptions of condensed bodies (condense.c) still hold. They fail
   at contacts on faces that are not kept, and at large rotation. */
#include "blocks/blocks.h"

/* Limits of the strain error of linear rotation over the strain in the body. Above the first a run warns,
   above the second it refuses the stage. */
static const PetscReal ROTATION_WARN = 1e-3, ROTATION_REFUSED = 1e-2;

PetscErrorCode CondensedCheckContacts(const Scene *scene, const Model *m, const Contacts *c)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (!m->mesh.n_condensed_global) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < c->n_padded && !message[0]; i++)
    for (int k = 0; k < CONTACT_ROWS && c->key[2 * i] >= 0; k++) {
      const PetscInt v = c->vertex[CONTACT_ROW(i, k)];
      if (v < m->mesh.n_moving || v >= m->mesh.n_owned) continue;
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s: materials: a contact has come to x = %.6g m, y = %.6g m, on a face that its condensed "
          "body does not keep: name the face in a set of a joint, or do not condense its group",
          scene->file, (double)m->mesh.X[2 * v], (double)m->mesh.X[2 * v + 1]));
    }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums over a condensed body: for its mean rotation about its mean vertex, the stored energy, and int E'
   dA with E' = lambda + 2 mu. */
typedef struct {
  PetscReal n, X, Y, u, v, turn, arm, energy, modulus;
} BodyMotion;

static void add_vertices(const Model *m, const PetscReal *u, BodyMotion *motion)
{
  for (int pass = 0; pass < 2; pass++)
    for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
      if (m->mesh.vertex_condensed[v] < 0) continue;
      BodyMotion *b = motion + m->mesh.vertex_condensed[v];
      const PetscReal *X = m->mesh.X + 2 * v;
      if (!pass) {
        b->n += 1., b->X += X[0], b->Y += X[1], b->u += u[2 * v], b->v += u[2 * v + 1];
        continue;
      }
      const PetscReal x = X[0] - b->X / b->n, y = X[1] - b->Y / b->n;
      b->turn += x * (u[2 * v + 1] - b->v / b->n) - y * (u[2 * v] - b->u / b->n);
      b->arm += x * x + y * y;
    }
}

static PetscErrorCode add_elements(const Model *m, const Elements *e, const PetscReal *u, BodyMotion *motion)
{
  PetscReal *energy;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(e->n_padded, &energy));
  PetscCall(ElementEnergy(m, e, e->n_nodes, u, energy));
  for (PetscInt i = 0; i < e->n; i++) {
    PetscInt vertex[4] = {VertexOf(e, i, 0)};
    PetscReal area, centroid[2], polar;
    for (int k = 1; k < e->n_nodes; k++) vertex[k] = VertexOf(e, i, k);
    BodyMotion *b = motion + m->mesh.vertex_condensed[vertex[0]];
    BlockGeometry(m->mesh.X, vertex, e->n_nodes, &area, centroid, &polar);
    b->energy += energy[i];
    const Lame lame = m->materials.lame[e->group[i]];
    b->modulus += (lame.lambda + 2. * lame.mu) * area * m->materials.thickness;
  }
  PetscCall(PetscFree(energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the false strain of a rotation theta, which linear kinematics makes 1 - cos(theta) = theta^2/2 in
   both directions, with the root mean square of the strain in the body, weighted by its modulus, which is
   sqrt(2 W / int E' dA). */
PetscErrorCode CondensedCheckRotation(const Scene *scene, const Model *m, const Stage *stage,
                                      const State *state)
{
  const PetscReal *u = state->u + 3 * m->rigid.n;
  char message[MESSAGE_LENGTH] = "";
  BodyMotion *motion;
  PetscReal worst = 0.;
  PetscFunctionBeginUser;
  if (!m->mesh.n_condensed_global || scene->strain == STRAIN_SMALL) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(m->mesh.n_condensed_global, &motion));
  add_vertices(m, u, motion);
  PetscCall(add_elements(m, &m->mesh.condensed_q4, u, motion));
  PetscCall(add_elements(m, &m->mesh.condensed_t3, u, motion));
  for (PetscInt i = 0; i < m->condensed.n; i++) {
    const BodyMotion *b = motion + m->condensed.body[i].number;
    const PetscReal theta = b->turn / b->arm, strain = PetscSqrtReal(2. * b->energy / b->modulus);
    const PetscReal share = strain > 0. ? 0.5 * theta * theta / strain : 0.;
    if (share <= ROTATION_WARN || share <= worst) continue;
    worst = share;
    PetscCall(PetscSNPrintf(
        message, MESSAGE_LENGTH,
        "%s: stages.%s: the condensed body about x = %.4g m, y = %.4g m has turned by %.3g rad: "
        "linear rotation falsifies its strain by %.2g %%",
        scene->file, stage->name, (double)(b->X / b->n), (double)(b->Y / b->n), (double)theta,
        (double)(100. * share)));
  }
  PetscCall(PetscFree(motion));
  if (worst > ROTATION_REFUSED)
    PetscCall(PetscStrlcat(message,
                           ", more than 1 %: nothing of this stage is kept; do not condense its group",
                           MESSAGE_LENGTH));
  if (worst > ROTATION_WARN && worst <= ROTATION_REFUSED) {
    Warn("%s", message);
    message[0] = 0;
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the same without the inside

   With (a) of condense.c the mean rotation, which is a sum c.u over all vertices, is

     theta = c_B.u_B + c_I.u_I = (c_B - K_BI z).u_B + z.f_I,   z = K_II^-1 c_I,

   and the energy is that of the kept vertices, u_B.S u_B / 2, plus what the loads inside store. So one solve
   a body, once, serves all states: both numbers are the numbers of CondensedCheckRotation but for rounding.
   The energy counts less what rounding may add to it (n eps |u_B|^2 sum |S|), and nothing for loads other
   than those whose energy is known: a smaller energy makes a larger share. Rounding of theta is 1e-10 of
   |u_B| over the size of the body, which matters for no strain above 1e-20. */

static const PetscReal MARGIN = 0.5; /* of ROTATION_REFUSED: beyond it the inside is checked */

/* Computes turn, modulus and sum_S of all bodies. */
static PetscErrorCode prepare_turns(const Model *m)
{
  const PetscInt n = 2 * (m->mesh.n_vertices + DUMMY_VERTICES);
  BodyMotion *motion;
  PetscReal *c_all, *z, *Kz;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(m->mesh.n_condensed_global, &motion));
  PetscCall(PetscCalloc3(n, &c_all, n, &z, n, &Kz));
  add_vertices(m, c_all, motion); // with zero displacements: places and lever arms
  PetscCall(add_elements(m, &m->mesh.condensed_q4, c_all, motion));
  PetscCall(add_elements(m, &m->mesh.condensed_t3, c_all, motion));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) {
    if (m->mesh.vertex_condensed[v] < 0) continue;
    const BodyMotion *b = motion + m->mesh.vertex_condensed[v];
    c_all[2 * v] = -(m->mesh.X[2 * v + 1] - b->Y / b->n) / b->arm;
    c_all[2 * v + 1] = (m->mesh.X[2 * v] - b->X / b->n) / b->arm;
  }
  for (PetscInt i = 0; i < m->condensed.n; i++)
    PetscCall(CondensedSolve(m->condensed.body + i, m->condensed.body[i].inner, c_all, z));
  ElementForcesCondensed(m, z, Kz);
  for (PetscInt i = 0; i < m->condensed.n; i++) {
    Condensed *c = m->condensed.body + i;
    PetscCall(PetscMalloc1(c->n_kept + c->n_inner, &c->turn));
    for (PetscInt k = 0; k < c->n_kept; k++) c->turn[k] = c_all[c->kept[k]] - Kz[c->kept[k]];
    for (PetscInt k = 0; k < c->n_inner; k++) c->turn[c->n_kept + k] = z[c->inner[k]];
    c->modulus = motion[c->number].modulus, c->sum_S = 0.;
    for (PetscInt k = 0; k < c->stride * c->stride; k++) c->sum_S += PetscAbsReal(c->S[k]);
  }
  PetscCall(PetscFree3(c_all, z, Kz));
  PetscCall(PetscFree(motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensedMayTurn(const Scene *scene, const Model *m, const State *state, PetscBool *may)
{
  const PetscReal *u = state->u + 3 * m->rigid.n, *f = state->f_ext + 3 * m->rigid.n;
  PetscFunctionBeginUser;
  *may = PETSC_FALSE;
  if (!m->condensed.n || scene->strain == STRAIN_SMALL) PetscFunctionReturn(PETSC_SUCCESS);
  if (!m->condensed.body->turn) PetscCall(prepare_turns(m));
  for (PetscInt b = 0; b < m->condensed.n; b++) {
    const Condensed *c = m->condensed.body + b;
    PetscReal theta = 0., energy = 0., most = 0.;
    PetscBool known = PETSC_TRUE;
    for (PetscInt i = 0; i < c->n_kept; i++) c->u[i] = u[c->kept[i]];
    DenseTimes(c->stride, c->stride, c->S, c->u, c->f);
    // NOLINTBEGIN(clang-analyzer-core.NullDereference): prepare_turns makes the turns of all bodies
    for (PetscInt i = 0; i < c->n_kept; i++) {
      theta += c->turn[i] * c->u[i];
      energy += 0.5 * c->u[i] * c->f[i];
      most = PetscMax(most, PetscAbsReal(c->u[i]));
    }
    for (PetscInt i = 0; i < c->n_inner; i++) {
      theta += c->turn[c->n_kept + i] * f[c->inner[i]];
      known = (PetscBool)(known && c->load[i] == f[c->inner[i]]);
    }
    // NOLINTEND(clang-analyzer-core.NullDereference)
    energy += (known ? c->stored : 0.) -
              (PetscReal)c->stride * PETSC_MACHINE_EPSILON * most * most * c->sum_S;
    // also true if a number is NaN
    if (!(0.5 * theta * theta <=
          MARGIN * ROTATION_REFUSED * PetscSqrtReal(2. * PetscMax(energy, 0.) / c->modulus)))
      *may = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* loads.c: supports, and applied forces: self-weight, water of a reservoir, tractions, point forces. */
#include "internal.h"

static const PetscReal CENTRED = 1e-12; /* moment over force times arm: the loads stand at the mass centre */

/* ---- supports */

typedef struct {
  PetscInt count[2];         /* vertices held in x, in y */
  PetscReal low[2], high[2]; /* of the coordinate across: y of those held in x, x of those held in y */
} BodyHold;

static PetscInt find_name(PetscInt n, char (*names)[NAME_LENGTH], const char *name)
{
  for (PetscInt i = 0; i < n; i++)
    if (!strcmp(names[i], name)) return i;
  return -1;
}

static void hold_vertex(const Support *s, Model *m, PetscInt v, BodyHold *body)
{
  if (v < 0 || v >= m->n_owned) return;
  for (int i = 0; i < 2; i++) {
    if (!s->fix[i]) continue;
    if (v < m->n_deformable || v >= m->n_moving) {
      m->support[3 * m->n_bodies + 2 * v + i] = (int16_t)s->row;
    } else {
      BodyHold *h = body + RigidOfVertex(m, v);
      const PetscReal across = m->X[2 * v + 1 - i];
      h->low[i] = h->count[i] ? PetscMin(h->low[i], across) : across;
      h->high[i] = h->count[i] ? PetscMax(h->high[i], across) : across;
      h->count[i]++;
    }
  }
}

static void hold_target(const Support *s, Model *m, BodyHold *body)
{
  const Elements *list[6] = {&m->q4, &m->t3, &m->rigid_q4, &m->rigid_t3, &m->condensed_q4, &m->condensed_t3};
  const PetscInt set = find_name(m->n_face_sets, m->face_set_names, s->target),
                 point = find_name(m->n_points, m->point_names, s->target);
  if (set >= 0) {
    for (PetscInt i = m->face_set_start[set]; i < m->face_set_start[set + 1]; i++)
      for (int k = 0; k < 2; k++) hold_vertex(s, m, m->faces.vertex[2 * m->face_set_faces[i] + k], body);
  } else if (point >= 0) {
    hold_vertex(s, m, m->point_vertex[point], body);
  } else {
    for (int l = 0; l < 6; l++)
      for (PetscInt e = 0, n_nodes = l % 2 ? 3 : 4; e < list[l]->n; e++) {
        if (strcmp(m->group_names[list[l]->group[e]], s->target)) continue;
        for (PetscInt k = 0; k < n_nodes; k++)
          hold_vertex(s, m, list[l]->vertex[((e / BATCH) * n_nodes + k) * BATCH + e % BATCH], body);
      }
  }
}

/* A vertex may stand in several faces of a set: only the span of the held places counts. A rigid body whose
   held vertices lie apart across the direction cannot turn; held at one place it could turn about it, which
   three dofs at the centroid cannot express, so that is refused. */
static PetscErrorCode hold_bodies(const Scene *scene, const Support *s, Model *m, const BodyHold *body)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    PetscBool turns = PETSC_TRUE, any = PETSC_FALSE;
    for (int i = 0; i < 2; i++) {
      if (!body[b].count[i]) continue;
      any = PETSC_TRUE;
      m->support[3 * b + i] = (int16_t)s->row;
      if (body[b].high[i] - body[b].low[i] > 1e-9 * m->diameter) turns = PETSC_FALSE;
    }
    if (any && !turns) m->support[3 * b + 2] = (int16_t)s->row;
    if (any && turns && !message[0])
      PetscCall(PetscSNPrintf(
          message, MESSAGE_LENGTH,
          "%s: supports.%s.target: \"%s\" holds the rigid body with block vertex %" PetscInt_FMT
          " at one place only, about which it could turn: expected its group, or faces that span it",
          scene->file, s->name, s->target, m->vertex_file[m->body_start[b]]));
  }
  PetscCall(CheckMessage(m->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SupportsApply(const Scene *scene, Model *m)
{
  BodyHold *body;
  PetscFunctionBeginUser;
  PetscCheck(scene->n_supports <= INT16_MAX, m->comm, PETSC_ERR_SUP, "more than %d supports", INT16_MAX);
  PetscCall(PetscMalloc1(m->n_bodies, &body));
  for (PetscInt i = 0; i < scene->n_supports; i++) {
    PetscCall(PetscArrayzero(body, m->n_bodies));
    hold_target(scene->supports + i, m, body);
    PetscCall(hold_bodies(scene, scene->supports + i, m, body));
  }
  PetscCall(PetscFree(body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- loads: forces at vertices; f: dof array, f_vertex: its vertex part */

/* Weight of the groups the load names: the lumped masses (27) times g downwards. A rigid block is one or two
   triangles, each with a third of its weight at each vertex: the resultant stays at the block's centroid
   however the body turns. */
static PetscErrorCode self_weight(const Scene *scene, const Load *load, const Model *m, PetscReal *f_vertex)
{
  Model chosen = *m; // the same model where the other groups weigh nothing
  const Elements *list[2] = {&m->rigid_q4, &m->rigid_t3};
  PetscReal *mass;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_groups, &chosen.density));
  PetscCall(PetscCalloc1(m->n_vertices + DUMMY_VERTICES, &mass));
  for (PetscInt g = 0; g < m->n_groups; g++)
    chosen.density[g] = load->n_groups && find_name(load->n_groups, load->groups, m->group_names[g]) < 0
                            ? 0.
                            : m->density[g];
  PetscCall(ElementMasses(&chosen, mass));
  for (int l = 0; l < 2; l++)
    for (PetscInt e = 0, n_nodes = l ? 3 : 4; e < list[l]->n; e++)
      for (PetscInt triangle = 0; triangle < n_nodes - 2; triangle++) {
        PetscInt vertex[3];
        PetscReal area, centroid[2], polar;
        for (PetscInt k = 0; k < 3; k++)
          vertex[k] = list[l]->vertex[((e / BATCH) * n_nodes + (k ? k + triangle : 0)) * BATCH + e % BATCH];
        BlockGeometry(m->X, vertex, 3, &area, centroid, &polar);
        for (int k = 0; k < 3; k++)
          mass[vertex[k]] += chosen.density[list[l]->group[e]] * m->thickness * area / 3.;
      }
  for (PetscInt v = 0; v < m->n_owned; v++) f_vertex[2 * v + 1] -= scene->gravity * mass[v];
  PetscCall(PetscFree(mass));
  PetscCall(PetscFree(chosen.density));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Water pressure rho g (level - y) into the face from a to b, exact for the linear pressure and
   linear shape functions: two Gauss points on the wet part. x: (4) present ends of the face; f: (4)
   forces at the two ends [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4])
{
  const PetscReal ex = x[2] - x[0], ey = x[3] - x[1], za = level - x[1], zb = level - x[3];
  PetscReal from = 0., to = 1.;
  for (int i = 0; i < 4; i++) f[i] = 0.;
  if (za <= 0. && zb <= 0.) return;
  if (za < 0.) from = za / (za - zb);
  if (zb < 0.) to = za / (za - zb);
  for (int g = -1; g <= 1; g += 2) {
    const PetscReal at = 0.5 * (from + to) + g * 0.5 * (to - from) / PetscSqrtReal(3.);
    const PetscReal push = 0.5 * (to - from) * rho_g * (za + at * (zb - za)) *
                           thickness; // times face length in ex, ey
    const PetscReal N[2] = {1. - at, at};
    for (int k = 0; k < 2; k++) {
      f[2 * k] -= N[k] * push * ey; // the outward normal times length is (ey, -ex)
      f[2 * k + 1] += N[k] * push * ex;
    }
  }
}

static void face_load(const Scene *scene, const Load *load, const Model *m, const PetscReal *u_vertex,
                      PetscReal *f_vertex)
{
  const PetscInt set = find_name(m->n_face_sets, m->face_set_names, load->target);
  for (PetscInt i = m->face_set_start[set]; i < m->face_set_start[set + 1]; i++) {
    const PetscInt *v = m->faces.vertex + 2 * m->face_set_faces[i];
    const PetscBool small = m->group_condensed[m->faces.group[m->face_set_faces[i]]];
    const PetscReal moving = m->strain == STRAIN_LARGE && !small ? 1. : 0.;
    PetscReal x[4], f[4];
    for (int k = 0; k < 4; k++)
      x[k] = m->X[2 * v[k / 2] + k % 2] +
             (load->kind == LOAD_RESERVOIR ? moving * u_vertex[2 * v[k / 2] + k % 2] : 0.);
    if (load->kind == LOAD_RESERVOIR) {
      WaterOnFace(x, load->level, load->density * scene->gravity, m->thickness, f);
    } else { // a dead traction on the undeformed face
      const PetscReal half = 0.5 * m->thickness * PetscHypotReal(x[2] - x[0], x[3] - x[1]);
      for (int k = 0; k < 4; k++) f[k] = half * load->traction[k % 2];
    }
    for (int k = 0; k < 4; k++)
      if (v[k / 2] < m->n_owned) f_vertex[2 * v[k / 2] + k % 2] += f[k];
  }
}

static void point_force(const Load *load, const Model *m, PetscReal *f_vertex)
{
  const PetscInt v = m->point_vertex[find_name(m->n_points, m->point_names, load->target)];
  for (int i = 0; i < 2 && v >= 0 && v < m->n_owned; i++)
    f_vertex[2 * v + i] += m->thickness * load->traction[i];
}

PetscBool LoadsTurn(const Model *m, const PetscReal *u, PetscReal *f)
{
  const PetscReal *f_vertex = f + 3 * m->n_bodies;
  PetscBool any = PETSC_FALSE;
  RigidForces(m, u, f);
  for (PetscInt b = 0; b < m->n_bodies; b++) {
    PetscReal across = 0., along = 0., size = 0.; // sums of r x F and r . F in the reference position
    for (PetscInt v = m->body_start[b]; v < m->body_start[b + 1]; v++) {
      const PetscReal rx = m->X[2 * v] - m->body_X[2 * b], ry = m->X[2 * v + 1] - m->body_X[2 * b + 1];
      across += rx * f_vertex[2 * v + 1] - ry * f_vertex[2 * v];
      along += rx * f_vertex[2 * v] + ry * f_vertex[2 * v + 1];
      size += PetscHypotReal(rx, ry) * PetscHypotReal(f_vertex[2 * v], f_vertex[2 * v + 1]);
    }
    if (PetscAbsReal(across) + PetscAbsReal(along) <= CENTRED * size)
      f[3 * b + 2] = 0.;
    else if (m->strain == STRAIN_LARGE && !Held(m, 3 * b + 2))
      any = PETSC_TRUE;
  }
  return any;
}

/* Whether water presses on faces that move. */
static PetscBool presses(const Scene *scene, const Load *load)
{
  return (PetscBool)(scene->strain == STRAIN_LARGE &&
                     (load->kind == LOAD_RESERVOIR || load->kind == LOAD_UPLIFT));
}

PetscBool LoadsPress(const Scene *scene, const Stage *stage)
{
  for (PetscInt l = 0; l < stage->n_loads; l++)
    if (presses(scene, scene->loads + stage->loads[l])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Adds the stage's loads at present displacements to f_vertex: dead ones, pressing ones, or both. */
static PetscErrorCode add_loads(const Scene *scene, const Model *m, const Stage *stage, const State *state,
                                PetscBool dead, PetscBool pressing, PetscReal *f_vertex)
{
  const PetscReal *u_vertex = state->u + 3 * m->n_bodies;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < stage->n_loads; l++) {
    const Load *load = scene->loads + stage->loads[l];
    if (presses(scene, load) ? !pressing : !dead) continue;
    switch (load->kind) {
    case LOAD_SELF_WEIGHT:
      PetscCall(self_weight(scene, load, m, f_vertex));
      break;
    case LOAD_POINT_FORCE:
      point_force(load, m, f_vertex);
      break;
    case LOAD_UPLIFT:
      UpliftForces(scene, load, state->uplift + stage->loads[l], m, u_vertex, f_vertex);
      break;
    case LOAD_TRACTION:
    case LOAD_RESERVOIR:
      face_load(scene, load, m, u_vertex, f_vertex);
      break;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool LoadsChange(const Scene *scene, const Model *m, const Stage *stage)
{
  PetscBool change = LoadsPress(scene, stage);
  for (PetscInt l = 0; l < stage->n_loads && m->n_rigid_global > 0; l++)
    if (scene->loads[stage->loads[l]].kind != LOAD_SELF_WEIGHT) change = PETSC_TRUE;
  return change;
}

PetscErrorCode LoadsTarget(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscReal *f = state->f_target;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(f, at + 2 * (m->n_vertices + DUMMY_VERTICES)));
  PetscCall(add_loads(scene, m, stage, state, PETSC_TRUE, PETSC_TRUE, f + at));
  PetscCall(CondensedLoads(m, f + at));
  state->loads_turn = LoadsTurn(m, state->u, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsDead(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  const PetscInt at = 3 * m->n_bodies;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(state->f_start, at + 2 * (m->n_vertices + DUMMY_VERTICES)));
  PetscCall(add_loads(scene, m, stage, state, PETSC_TRUE, PETSC_FALSE, state->f_start + at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsFollow(const Scene *scene, const Model *m, const Stage *stage, State *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(state->f_target, state->f_start, ModelApplied(m)));
  PetscCall(add_loads(scene, m, stage, state, PETSC_FALSE, PETSC_TRUE, state->f_target + 3 * m->n_bodies));
  state->loads_turn = LoadsTurn(m, state->u, state->f_target);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LoadsApply(const Model *m, State *state, PetscReal ramp)
{
  state->ramp = ramp;
  for (PetscInt d = 0; d < ModelApplied(m); d++)
    state->f_ext[d] = (1. - ramp) * state->f_start[d] + ramp * state->f_target[d];
}

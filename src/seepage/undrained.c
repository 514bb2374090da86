/* undrained.c: water that keeps its volume in joints during a dynamic stage.

   A trap is the water about one of two Gauss points of each piece. Its pressure is a function of the distance
   w of the two faces there alone, so it makes and takes no energy over a cycle:

   p = max(0, p_0 - K (A(w) - chi A_0)),  A(w) = max(a + w - w_0, a_r),  K = K_w / A_0.

   a is the aperture at the start, A_0 no less than a_r, aperture_residual, below which a joint that closes
   squeezes no water. There is no largest aperture: aperture_max limits what flows, not what a crack holds. A
   trap that presses at the start is full, chi = 1; another has its saturation, and presses once the void has
   closed on its water. A curtain takes a part of the aperture and of its change alike.

   Faces that have slid by the length of their contact hold no water between them, nor, under variable
   connectivity, those that have parted by the contact margin. They are near enough otherwise to be known to
   each rank that moves a vertex of either. A crack that is wider than the margin there when the stage begins
   keeps its pressure (FlowForces). */
#include "seepage/flow.h"

/* ---- where faces stand */

/* The two faces at a trap. */
typedef struct {
  PetscInt v[4];      /* local vertices: of face 0, then of face 1 */
  PetscReal N[4];     /* [-] by how much the distance grows as a vertex moves along n: -(1-t), -t; 1-t, t */
  PetscReal n[2];     /* out of the block of face 0 */
  PetscReal d_n, d_s; /* [m] distance of the faces, and by how much they have slid */
  PetscReal turns; /* [1/m] as in force.c: by how much n turns per displacement of an end; 0: small strain */
} Stand;

/* The row of a face, -1: this rank does not know it. guess: where it was last. */
static PetscInt row_of(const Model *m, PetscInt gid, PetscInt guess)
{
  return guess >= 0 && guess < m->faces.n && m->faces.gid[guess] == gid ? guess : FaceRow(m, gid);
}

/* Whether this rank knows both faces; then how they stand. rows: where they were last; NULL: anywhere. u
   NULL: in the reference state. */
static PetscBool stand_of(const Model *m, const FlowTrap *trap, const PetscReal *u, PetscInt rows[2],
                          Stand *s)
{
  const PetscReal moving = m->strain == STRAIN_LARGE && u ? 1. : 0.;
  PetscReal d[2] = {0., 0.}, e[2];
  for (int side = 0; side < 2; side++) {
    const PetscInt face = row_of(m, trap->key[side], rows ? rows[side] : -1);
    if (face < 0) return PETSC_FALSE;
    if (rows) rows[side] = face;
    for (int k = 0; k < 2; k++) {
      s->v[2 * side + k] = m->faces.vertex[2 * face + k];
      s->N[2 * side + k] = (side ? 1. : -1.) * (k ? trap->t[side] : 1. - trap->t[side]);
    }
  }
  for (int x = 0; x < 2; x++) {
    PetscReal moved = 0.;
    for (int k = 0; k < 4; k++) {
      d[x] += s->N[k] * m->X[2 * s->v[k] + x];
      if (u) moved += s->N[k] * u[2 * s->v[k] + x];
    }
    d[x] += moved;
    e[x] = m->X[2 * s->v[1] + x] - m->X[2 * s->v[0] + x];
    if (u) e[x] += moving * (u[2 * s->v[1] + x] - u[2 * s->v[0] + x]);
  }
  const PetscReal length = PetscHypotReal(e[0], e[1]);
  s->n[0] = e[1] / length, s->n[1] = -e[0] / length;
  s->d_n = d[0] * s->n[0] + d[1] * s->n[1];
  s->d_s = (d[0] * e[0] + d[1] * e[1]) / length;
  s->turns = moving / length;
  return PETSC_TRUE;
}

/* ---- the law */

static PetscBool hold_water(const FlowTrap *trap, const Stand *s)
{
  return (PetscBool)(s->d_n <= trap->apart && PetscAbsReal(s->d_s - trap->slid) <= trap->reach);
}

/* [Pa] */
static PetscReal pressure_at(const FlowTrap *trap, PetscReal d_n)
{
  const PetscReal opened = PetscMax(d_n, trap->least) - trap->full;
  return PetscMax(0., trap->pressure - trap->stiffness * opened);
}

/* [J/m2] What presses less has given, counted from where the water is just full: the integral of -p. */
static PetscReal energy_at(const FlowTrap *trap, PetscReal d_n)
{
  const PetscReal empty = trap->pressure / trap->stiffness, // opening at which nothing presses
      opened = PetscMin(PetscMax(d_n, trap->least) - trap->full, empty);
  const PetscReal squeezed = PetscMax(0., trap->least - d_n);
  return opened * (0.5 * trap->stiffness * opened - trap->pressure) + squeezed * pressure_at(trap, d_n);
}

static PetscReal pressure_of(const FlowTrap *trap, const Stand *s)
{
  return hold_water(trap, s) ? pressure_at(trap, s->d_n) : 0.;
}

/* ---- each evaluation */

void FlowTrapForces(Flow *flow, const Model *m, const PetscReal *u, PetscReal *f)
{
  for (FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Stand s;
    if (!stand_of(m, trap, u, here->face, &s)) continue;
    const PetscReal F = -pressure_of(trap, &s) * trap->length * m->thickness, couple = F * s.d_s * s.turns;
    if (F == 0.) continue;
    for (int k = 0; k < 4; k++) {
      const PetscReal push = s.N[k] * F + (k == 0 ? couple : k == 1 ? -couple : 0.);
      if (s.v[k] >= m->n_owned) continue;
      for (int x = 0; x < 2; x++) f[2 * s.v[k] + x] += push * s.n[x];
    }
  }
}

/* As contacts (bound.c): sum |N| = 2 of a point, so its stiffness is no more than 2 |N| at each vertex. */
void FlowTrapBound(const Flow *flow, const Model *m, PetscReal *k)
{
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Stand s;
    if (!stand_of(m, trap, NULL, NULL, &s)) continue;
    for (int i = 0; i < 4; i++)
      k[s.v[i]] += 2. * trap->stiffness * trap->length * m->thickness * PetscAbsReal(s.N[i]);
  }
}

PetscReal FlowTrapEnergy(const Flow *flow, const Model *m, const PetscReal *u)
{
  PetscReal sum = 0.;
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Stand s;
    if (!here->first) continue;
    const PetscBool water = (PetscBool)(stand_of(m, trap, u, NULL, &s) && hold_water(trap, &s));
    sum += energy_at(trap, water ? s.d_n : PETSC_MAX_REAL) * trap->length * m->thickness;
  }
  return sum;
}

/* ---- of a stage */

/* Gauss points of a piece, 0..1 along it. */
static PetscReal gauss(int g)
{
  return 0.5 + (g ? 0.5 : -0.5) / PetscSqrtReal(3.);
}

/* Lists the traps of this rank. */
static PetscErrorCode list_here(const Model *m, Flow *flow)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(flow->here));
  PetscCall(PetscMalloc1(flow->n_traps + 1, &flow->here));
  flow->n_here = 0;
  for (PetscInt i = 0; i < flow->n_traps; i++) {
    FlowTrapHere here = {.trap = i};
    PetscBool mine = PETSC_FALSE;
    if (!(flow->trap[i].length > 0.)) continue;
    for (int side = 0; side < 2; side++) {
      here.face[side] = FaceRow(m, flow->trap[i].key[side]);
      if (here.face[side] < 0) continue;
      const PetscInt *v = m->faces.vertex + 2 * here.face[side];
      mine = (PetscBool)(mine || v[0] < m->n_owned || v[1] < m->n_owned);
      if (!side) here.first = (PetscBool)(v[0] < m->n_owned);
    }
    if (mine) flow->here[flow->n_here++] = here;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. What the rank that moves the first vertex of face 0 tells of each trap; (n_traps, 2). */
static PetscErrorCode share_stands(const Model *m, const Flow *flow, const PetscReal *u, PetscReal *stand)
{
  PetscFunctionBeginUser;
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    Stand s;
    if (!here->first) continue;
    if (!stand_of(m, flow->trap + here->trap, u, NULL, &s)) s.d_n = PETSC_MAX_REAL, s.d_s = 0.;
    stand[2 * here->trap] = s.d_n, stand[2 * here->trap + 1] = s.d_s;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, stand, (PetscMPIInt)(2 * flow->n_traps), MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The water at a Gauss point of a piece, but for where the faces stand. */
static FlowTrap trap_of(const TermView *v, const Flow *flow, PetscInt i, int g)
{
  const FlowPiece *piece = flow->net.piece + i;
  const FlowRow *row = flow->net.row + piece->row;
  const PetscReal at = gauss(g), s = piece->s[0] + at * (piece->s[1] - piece->s[0]),
                  rho_g = v->scene->flow.density * v->scene->gravity;
  FlowTrap trap = {.key = {row->key[0], row->key[1]}, .length = 0.5 * piece->length, .reach = row->length};
  FlowWater water;
  for (int side = 0; side < 2; side++)
    trap.t[side] = row->t[side][0] + s * (row->t[side][1] - row->t[side][0]);
  trap.pressure = rho_g * ((1. - at) * flow->acting[piece->node[0]] + at * flow->acting[piece->node[1]]);
  if (FlowWaterAt(flow->present, flow->n_present, row->key, s, s, &water))
    trap.chi = water.chi;
  else
    trap.chi = (1. - at) * flow->now.saturation[piece->node[0]] + at * flow->now.saturation[piece->node[1]];
  if (trap.pressure > 0.) trap.chi = 1.;
  return trap;
}

/* [m] How far apart faces may be: where contacts are looked for, as far as ranks are sure to know them. */
static PetscReal widest(const TermView *v)
{
  return v->state->u_verified ? v->m->contact_margin : PETSC_MAX_REAL;
}

/* Sets where the water of a trap is just full, from the opening and the distance of its faces now. */
static void close_trap(const TermView *v, const FlowRow *row, PetscReal s, const PetscReal stand[2],
                       FlowTrap *trap)
{
  const Joint *joint = v->stage->joints + row->joint;
  const PetscReal a = joint->aperture + row->opening[0] + s * (row->opening[1] - row->opening[0]),
                  a_0 = PetscMax(a, joint->aperture_residual);
  trap->stiffness = v->scene->flow.bulk_modulus / a_0;
  trap->least = stand[0] + (joint->aperture_residual - a);
  trap->full = PetscMax(stand[0], trap->least) - (1. - trap->chi) * a_0;
  trap->apart = stand[0] + widest(v), trap->slid = stand[1];
  if (trap->pressure <= 0. && trap->full <= trap->least) trap->length = 0.; // it never closes on its water
}

PetscBool FlowTrapped(const Flow *flow, PetscInt piece)
{
  return (PetscBool)(flow->n_traps && flow->trap[2 * piece].stiffness > 0.);
}

PetscErrorCode FlowTrapAll(const TermView *v)
{
  Flow *flow = v->memory;
  PetscReal *stand;
  PetscFunctionBeginUser;
  flow->n_traps = 2 * flow->net.n_pieces;
  PetscCall(PetscFree(flow->trap));
  PetscCall(PetscMalloc1(flow->n_traps + 1, &flow->trap));
  PetscCall(PetscCalloc1(2 * flow->n_traps + 1, &stand));
  for (PetscInt i = 0; i < flow->n_traps; i++) flow->trap[i] = trap_of(v, flow, i / 2, i % 2);
  PetscCall(list_here(v->m, flow));
  PetscCall(share_stands(v->m, flow, v->state->u + 3 * v->m->n_bodies, stand));
  for (PetscInt i = 0; i < flow->n_traps; i++) {
    const FlowPiece *piece = flow->net.piece + i / 2;
    const FlowRow *row = flow->net.row + piece->row;
    close_trap(v, row, piece->s[0] + gauss(i % 2) * (piece->s[1] - piece->s[0]), stand + 2 * i,
               flow->trap + i);
    if (row->parted || PetscMax(row->opening[0], row->opening[1]) > widest(v))
      flow->trap[i].length = flow->trap[i].stiffness = 0.;
  }
  PetscCall(PetscFree(stand));
  PetscCall(list_here(v->m, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowTrapsFree(Flow *flow)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(flow->trap));
  PetscCall(PetscFree(flow->here));
  PetscCall(PetscFree(flow->trapped));
  flow->n_traps = flow->n_here = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowTrapsRecord(const TermView *v)
{
  Flow *flow = v->memory;
  PetscReal *stand;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * flow->n_traps + 1, &stand));
  PetscCall(share_stands(v->m, flow, v->state->u + 3 * v->m->n_bodies, stand));
  PetscCall(PetscFree(flow->trapped));
  PetscCall(PetscMalloc1(flow->n_traps + 1, &flow->trapped));
  for (PetscInt i = 0; i < flow->n_traps; i += 2) {
    PetscReal p[2] = {0., 0.};
    for (int g = 0; g < 2; g++)
      if (flow->trap[i + g].length > 0.)
        p[g] = pressure_of(flow->trap + i + g,
                           &(Stand){.d_n = stand[2 * (i + g)], .d_s = stand[2 * (i + g) + 1]});
    // a line through both points has their force and its place, where it stays above zero
    const PetscReal slope = (p[1] - p[0]) / (gauss(1) - gauss(0));
    flow->trapped[i] = PetscMax(0., p[0] - slope * gauss(0));
    flow->trapped[i + 1] = PetscMax(0., p[1] + slope * gauss(0));
  }
  PetscCall(PetscFree(stand));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FlowTrapsArchive(Archive *a, const Model *m, Flow *flow)
{
  PetscInt *ints, n = flow->n_traps;
  PetscReal *reals;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "flow_traps", 1, &n));
  if (a->reading) {
    PetscCall(FlowTrapsFree(flow));
    flow->n_traps = n = (PetscInt)ArchiveWithin(a, "traps of the flow", n, 0, PETSC_MAX_INT / 64);
    if (n) PetscCall(PetscCalloc1(n, &flow->trap));
  }
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(n * TRAP_INTS, &ints, n * TRAP_REALS, &reals));
  for (int pass = 0; pass < 2; pass++) { // into the lists, then, read anew, out of them
    for (PetscInt i = 0; i < n && pass == (a->reading ? 1 : 0); i++) {
      FlowTrap *trap = flow->trap + i;
      PetscInt *in = ints + TRAP_INTS * i;
      PetscReal *re = reals + TRAP_REALS * i, *const to[TRAP_REALS] = {&trap->t[0],     &trap->t[1],
                                                                       &trap->length,   &trap->slid,
                                                                       &trap->reach,    &trap->apart,
                                                                       &trap->least,    &trap->full,
                                                                       &trap->pressure, &trap->stiffness};
      for (int k = 0; k < TRAP_INTS; k++) pass ? (trap->key[k] = in[k]) : (in[k] = trap->key[k]);
      for (int k = 0; k < TRAP_REALS; k++) pass ? (*to[k] = re[k]) : (re[k] = *to[k]);
    }
    if (pass) break;
    PetscCall(ArchiveInts(a, "flow_trap_faces", n * TRAP_INTS, ints));
    PetscCall(ArchiveReals(a, "flow_trap_water", n * TRAP_REALS, reals));
  }
  PetscCall(PetscFree2(ints, reals));
  if (a->reading) PetscCall(list_here(m, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

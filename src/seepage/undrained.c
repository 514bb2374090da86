/* undrained.c: computes the pressures of water that keeps its volume in joints during a dynamic stage.

   A trap is the water about one of two Gauss points of each piece. Its pressure is a function of the
   distance w of the two faces there alone, so it neither makes nor loses energy over a cycle:

   p = max(0, p_0 - K (A(w) - chi A_0)),  A(w) = max(a + w - w_0, a_r),  K = K_w / A_0.

   a is the aperture at the start, and a_r is aperture_residual: a joint that closes further squeezes no
   water. A_0 = max(a, a_r). There is no largest aperture: aperture_max limits the discharge, not the
   volume of a crack. A trap with pressure at the start is full, chi = 1. Any other trap has its
   saturation, and presses once the void has closed on its water. A curtain reduces the aperture and its
   change in the same ratio.

   A trap loses its water when its faces have slid by the length of their contact, or, under variable
   connectivity, parted by the contact margin. Nearer faces are known to each rank that owns a vertex of
   either. A crack that is wider than the margin when the stage begins keeps its pressure (FlowForces). */
#include "seepage/flow.h"

/* ---- distance of the faces */

/* Relative position of the two faces at a trap. */
typedef struct {
  PetscInt v[4];      /* local vertices: of face 0, then of face 1 */
  PetscReal N[4];     /* [-] d(distance)/d(displacement of a vertex along n): -(1-t), -t; 1-t, t */
  PetscReal n[2];     /* unit normal, out of the block of face 0 */
  PetscReal d_n, d_s; /* [m] distance and slip of the faces */
  PetscReal turns;    /* [1/m] rotation of n per displacement of an end, as in force.c; 0: small strain */
} Gap;

/* Returns the row of a face, or -1 if this rank does not know it. guess: its last row. */
static PetscInt row_of(const Model *m, PetscInt gid, PetscInt guess)
{
  return guess >= 0 && guess < m->faces.n && m->faces.gid[guess] == gid ? guess : FaceRow(m, gid);
}

/* Computes the relative position of the faces at a trap. Returns false if this rank does not know both
   faces. rows: their last rows, NULL: unknown. u NULL: reference configuration. */
static PetscBool gap_of(const Model *m, const FlowTrap *trap, const PetscReal *u, PetscInt rows[2], Gap *s)
{
  const PetscReal moving = m->materials.strain == STRAIN_LARGE && u ? 1. : 0.;
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
    PetscReal displacement = 0.;
    for (int k = 0; k < 4; k++) {
      d[x] += s->N[k] * m->mesh.X[2 * s->v[k] + x];
      if (u) displacement += s->N[k] * u[2 * s->v[k] + x];
    }
    d[x] += displacement;
    e[x] = m->mesh.X[2 * s->v[1] + x] - m->mesh.X[2 * s->v[0] + x];
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

static PetscBool holds_water(const FlowTrap *trap, const Gap *s)
{
  return (PetscBool)(s->d_n <= trap->apart && PetscAbsReal(s->d_s - trap->slid) <= trap->reach);
}

/* Returns the pressure [Pa] at distance d_n. */
static PetscReal pressure_at(const FlowTrap *trap, PetscReal d_n)
{
  const PetscReal opened = PetscMax(d_n, trap->least) - trap->full;
  return PetscMax(0., trap->pressure - trap->stiffness * opened);
}

/* Returns the energy [J/m2] stored in the water, zero where it is just full: the integral of -p over the
   distance. */
static PetscReal energy_at(const FlowTrap *trap, PetscReal d_n)
{
  const PetscReal empty = trap->pressure / trap->stiffness, // opening from which the pressure is zero
      opened = PetscMin(PetscMax(d_n, trap->least) - trap->full, empty);
  const PetscReal squeezed = PetscMax(0., trap->least - d_n);
  return opened * (0.5 * trap->stiffness * opened - trap->pressure) + squeezed * pressure_at(trap, d_n);
}

static PetscReal pressure_of(const FlowTrap *trap, const Gap *s)
{
  return holds_water(trap, s) ? pressure_at(trap, s->d_n) : 0.;
}

/* ---- each evaluation */

void FlowTrapForces(Flow *flow, const Model *m, const PetscReal *u, PetscReal *f)
{
  for (FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Gap s;
    if (!gap_of(m, trap, u, here->face, &s)) continue;
    const PetscReal F = -pressure_of(trap, &s) * trap->length * m->materials.thickness,
                    couple = F * s.d_s * s.turns;
    if (F == 0.) continue;
    for (int k = 0; k < 4; k++) {
      const PetscReal push = s.N[k] * F + (k == 0 ? couple : k == 1 ? -couple : 0.);
      if (s.v[k] >= m->mesh.n_owned) continue;
      for (int x = 0; x < 2; x++) f[2 * s.v[k] + x] += push * s.n[x];
    }
  }
}

/* Bounds the stiffness as for contacts (bound.c): since sum |N| = 2, a point contributes at most 2 |N| at
   each vertex. */
void FlowTrapBound(const Flow *flow, const Model *m, PetscReal *k)
{
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Gap s;
    if (!gap_of(m, trap, NULL, NULL, &s)) continue;
    for (int i = 0; i < 4; i++)
      k[s.v[i]] += 2. * trap->stiffness * trap->length * m->materials.thickness * PetscAbsReal(s.N[i]);
  }
}

PetscReal FlowTrapEnergy(const Flow *flow, const Model *m, const PetscReal *u)
{
  PetscReal sum = 0.;
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    const FlowTrap *trap = flow->trap + here->trap;
    Gap s;
    if (!here->first) continue;
    const PetscBool water = (PetscBool)(gap_of(m, trap, u, NULL, &s) && holds_water(trap, &s));
    sum += energy_at(trap, water ? s.d_n : PETSC_MAX_REAL) * trap->length * m->materials.thickness;
  }
  return sum;
}

/* ---- traps of a stage */

/* Returns the position of Gauss point g on a piece, 0..1. */
static PetscReal gauss(int g)
{
  return 0.5 + (g ? 0.5 : -0.5) / PetscSqrtReal(3.);
}

/* Lists the traps that act on vertices of this rank. */
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
      mine = (PetscBool)(mine || v[0] < m->mesh.n_owned || v[1] < m->mesh.n_owned);
      if (!side) here.first = (PetscBool)(v[0] < m->mesh.n_owned);
    }
    if (mine) flow->here[flow->n_here++] = here;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Broadcasts distance and slip of each trap from the rank that owns the first vertex of face
   0; (n_traps, 2). */
static PetscErrorCode share_gaps(const Model *m, const Flow *flow, const PetscReal *u, PetscReal *gap)
{
  PetscFunctionBeginUser;
  for (const FlowTrapHere *here = flow->here; here < flow->here + flow->n_here; here++) {
    Gap s;
    if (!here->first) continue;
    if (!gap_of(m, flow->trap + here->trap, u, NULL, &s)) s.d_n = PETSC_MAX_REAL, s.d_s = 0.;
    gap[2 * here->trap] = s.d_n, gap[2 * here->trap + 1] = s.d_s;
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, gap, (PetscMPIInt)(2 * flow->n_traps), MPIU_REAL, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the trap at a Gauss point of a piece; close_trap adds its distances. */
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

/* Returns the largest distance [m] of faces that hold water: the contact margin, within which ranks are
   sure to know both faces. */
static PetscReal widest(const TermView *v)
{
  return v->state->u_verified ? v->m->contact_margin : PETSC_MAX_REAL;
}

/* Sets the distance at which a trap is just full, from the present opening and distance of its faces. */
static void close_trap(const TermView *v, const FlowRow *row, PetscReal s, const PetscReal gap[2],
                       FlowTrap *trap)
{
  const Joint *joint = v->stage->joints + row->joint;
  const PetscReal a = joint->aperture + row->opening[0] + s * (row->opening[1] - row->opening[0]),
                  a_0 = PetscMax(a, joint->aperture_residual);
  trap->stiffness = v->scene->flow.bulk_modulus / a_0;
  trap->least = gap[0] + (joint->aperture_residual - a);
  trap->full = PetscMax(gap[0], trap->least) - (1. - trap->chi) * a_0;
  trap->apart = gap[0] + widest(v), trap->slid = gap[1];
  if (trap->pressure <= 0. && trap->full <= trap->least) trap->length = 0.; // it never closes on its water
}

PetscBool FlowTrapped(const Flow *flow, PetscInt piece)
{
  return (PetscBool)(flow->n_traps && flow->trap[2 * piece].stiffness > 0.);
}

PetscErrorCode FlowTrapAll(const TermView *v)
{
  Flow *flow = v->memory;
  PetscReal *gap;
  PetscFunctionBeginUser;
  flow->n_traps = 2 * flow->net.n_pieces;
  PetscCall(PetscFree(flow->trap));
  PetscCall(PetscMalloc1(flow->n_traps + 1, &flow->trap));
  PetscCall(PetscCalloc1(2 * flow->n_traps + 1, &gap));
  for (PetscInt i = 0; i < flow->n_traps; i++) flow->trap[i] = trap_of(v, flow, i / 2, i % 2);
  PetscCall(list_here(v->m, flow));
  PetscCall(share_gaps(v->m, flow, v->state->u + 3 * v->m->rigid.n, gap));
  for (PetscInt i = 0; i < flow->n_traps; i++) {
    const FlowPiece *piece = flow->net.piece + i / 2;
    const FlowRow *row = flow->net.row + piece->row;
    close_trap(v, row, piece->s[0] + gauss(i % 2) * (piece->s[1] - piece->s[0]), gap + 2 * i, flow->trap + i);
    if (row->parted || PetscMax(row->opening[0], row->opening[1]) > widest(v))
      flow->trap[i].length = flow->trap[i].stiffness = 0.;
  }
  PetscCall(PetscFree(gap));
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
  PetscReal *gap;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(2 * flow->n_traps + 1, &gap));
  PetscCall(share_gaps(v->m, flow, v->state->u + 3 * v->m->rigid.n, gap));
  PetscCall(PetscFree(flow->trapped));
  PetscCall(PetscMalloc1(flow->n_traps + 1, &flow->trapped));
  for (PetscInt i = 0; i < flow->n_traps; i += 2) {
    PetscReal p[2] = {0., 0.};
    for (int g = 0; g < 2; g++)
      if (flow->trap[i + g].length > 0.)
        p[g] = pressure_of(flow->trap + i + g, &(Gap){.d_n = gap[2 * (i + g)], .d_s = gap[2 * (i + g) + 1]});
    // A line through both points has their resultant force at its place, where it stays above zero.
    const PetscReal slope = (p[1] - p[0]) / (gauss(1) - gauss(0));
    flow->trapped[i] = PetscMax(0., p[0] - slope * gauss(0));
    flow->trapped[i + 1] = PetscMax(0., p[1] + slope * gauss(0));
  }
  PetscCall(PetscFree(gap));
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
  for (int pass = 0; pass < 2; pass++) { // pass 0 fills the lists; pass 1, when reading, copies out of them
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

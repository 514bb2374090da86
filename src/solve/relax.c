/* relax.c: adaptive Rayleigh damping (35)-(38), and how a static stage ends.

   Damping. With du = v dt the products k_tan du^2 of (37) are df.du, df the change of the RESISTING force
   over the step, so

   Q = sum(df.du) / sum(m du.du) = sum(v.(f - f_old)) / (dt sum(v.m v)), alpha = 2 sqrt(Q),

   the value of (35)-(37) without a division per dof (0/0 for dofs at rest). Applied loads are not in f:
   their ramp must not look like stiffness. Q <= 0 happens when contacts open: the last positive value stays.
   alpha dt is capped at 1.9.

   Where joints slip and open, a few sub-contacts that chatter raise that tangent quotient and overdamp the
   slow modes, 2 to 5 times. The secant over the stage,

   (u - u_0).(f - f_0) / (u - u_0).m (u - u_0),

   looks at the motion that matters: the smaller of the two is taken. Once slip is kept as it comes (below) it
   counts from where the ratio last halved or stalled: what still moves then is slower than what has moved.

   Friction flutter. Slip by a rule that is not associated makes the tangent stiffness unsymmetric: fast
   oscillations along a sliding joint grow by some 1e-3 a cycle and never let it rest, for mass-proportional
   damping hardly touches them, and they carry the joint along as shaking would. So adaptive damping has a
   part proportional to stiffness too where joints can slip, a force beta (f - f_old): a quarter of critical
   at the highest frequency, nothing at the lowest. When the unbalanced ratio has not halved in two periods
   it is doubled and the secant left alone: only what moves on then is a collapse.

   Friction on the way. A static stage has the history of its last equilibrium (false slip: theory.md, ab),
   so its friction is a force that depends on place alone, tau = f(slip held, u). Where a contact slides,

   d(sigma, tau)/d(u_n, u_s) = [k_n 0; -+ k_n tan(phi) 0],

   pressure drives shear and not the other way round: that force has a curl, and a closed path of opening and
   sliding gains work k_n tan(phi) times its area. With an elastic surrounding that couples the two the
   eigenvalues of the tangent are complex, and motions grow by up to a few tenths a cycle. So contacts do not
   have that force on the way: they have elastic-plastic springs that keep their slip and take energy, which
   each cycle draws by `pull` (types.h: Contacts) towards the force of the law. What is faster than 1/pull
   cycles meets springs; what is slow, and every equilibrium, meets the law (stress_models.h:
   RespondFollowing, confirm.c: ConfirmByLaw). */
#include "stages/stages.h"
#include "archive/archive.h"
#include "base/reproducible.h"
#include <float.h>

static const PetscReal ALPHA_DT_MAX = 1.9, GROWTH = 1048576.; /* GROWTH: see integrate.c */
static const PetscReal BETA_STILL = 0.5, CHUNK_GROWTH = 1.25, FOLLOW_FAR = 0.05;
static const PetscReal FLOATS = 1e7; /* chunks: no elastic structure is so slow */
enum { STALL_CYCLES = 2500, STALLS_TO_LET_GO = 4 };
enum { CHUNK_MIN = 500, CHUNK_MAX = 50000, CHUNKS_TO_COLLAPSE = 2 };

PetscErrorCode RelaxationCreate(const Scene *scene, const Model *m, Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  PetscCall(SumsCreate(m, &r->over_ranks));
  r->max_ratios = CHUNK_MAX / scene->check_every + 2;
  PetscCall(PetscCalloc5(m->n_dof, &r->u_0, m->n_dof, &r->u_secant, m->n_dof, &r->f_secant, m->n_dof,
                         &r->account.u, m->n_dof, &r->account.f));
  PetscCall(PetscCalloc4(m->n_dof, &r->u_chunk, m->n_dof, &r->du_chunk, m->n_dof, &r->r_chunk, r->max_ratios,
                         &r->ratios));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationDestroy(Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(NewtonDestroy(&r->newton));
  PetscCall(SumsDestroy(&r->over_ranks));
  PetscCall(PetscFree4(r->u_chunk, r->du_chunk, r->r_chunk, r->ratios));
  PetscCall(PetscFree5(r->u_0, r->u_secant, r->f_secant, r->account.u, r->account.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationArchive(Archive *a, const Model *m, Relaxation *r)
{
  QuotientSums *q = &r->sums;
  PetscReal *const reals[] = {
      q->num,         q->num + 1,        q->den,           q->den + 1,        &q->num_max,
      &q->den_max,    &r->q_secant,      &r->best_ratio,   &r->q_ray,         r->median,
      r->median + 1,  r->median + 2,     r->median + 3,    r->rate,           r->rate + 1,
      r->rate + 2,    r->rate + 3,       &r->alpha_sum,    &r->settled_alpha, &r->longest,
      &r->half_ratio, &r->reached,       &r->step,         r->ahead,          r->ahead + 1,
      r->ahead + 2,   &r->account.start, &r->account.most, &r->account.ramp};
  enum { REALS = sizeof(reals) / sizeof(reals[0]), COUNTS = 10 };
  PetscReal x[REALS];
  PetscInt64 n[COUNTS] = {r->tangent_only, r->best_cycle, r->n_ratios,    r->steady,     r->chunk_start,
                          r->chunk_length, r->n_alpha,    r->made_energy, r->half_cycle, r->stalls};
  PetscFunctionBeginUser;
  for (int i = 0; i < REALS; i++) x[i] = *reals[i];
  PetscCall(ArchiveReals(a, "reals", REALS, x));
  PetscCall(ArchiveCounts(a, "counts", COUNTS, n));
  if (a->reading) {
    for (int i = 0; i < REALS; i++) *reals[i] = x[i];
    r->tangent_only = (PetscBool)n[0], r->best_cycle = n[1];
    r->n_ratios = (PetscInt)PetscMin(n[2], r->max_ratios), r->steady = (PetscInt)n[3];
    r->chunk_start = n[4], r->chunk_length = n[5], r->n_alpha = (PetscInt)n[6],
    r->made_energy = (PetscInt)n[7], r->half_cycle = n[8], r->stalls = (PetscInt)n[9];
  }
  PetscCall(ArchiveReals(a, "ratios", r->n_ratios, r->ratios));
  PetscCall(ArchiveDofs(a, m, "u_0", r->u_0));
  PetscCall(ArchiveDofs(a, m, "u_secant", r->u_secant));
  PetscCall(ArchiveDofs(a, m, "f_secant", r->f_secant));
  PetscCall(ArchiveDofs(a, m, "account_u", r->account.u));
  PetscCall(ArchiveDofs(a, m, "account_f", r->account.f));
  PetscCall(ArchiveDofs(a, m, "u_chunk", r->u_chunk));
  PetscCall(ArchiveDofs(a, m, "du_chunk", r->du_chunk));
  PetscCall(ArchiveDofs(a, m, "r_chunk", r->r_chunk));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool is_adaptive(const Scene *scene)
{
  return (PetscBool)(scene->damping == DAMPING_ADAPTIVE || scene->damping == DAMPING_PAPER);
}

void DampingBegin(const Scene *scene, const Model *m, Relaxation *r, const QuotientSums *local)
{
  if (is_adaptive(scene)) SumsBegin(m, r->over_ranks, local);
}

PetscErrorCode DampingEnd(const Scene *scene, const Model *m, State *state, Relaxation *r)
{
  QuotientSums total;
  PetscFunctionBeginUser;
  if (scene->damping == DAMPING_FIXED) state->alpha = scene->alpha_dt / state->dt;
  if (!is_adaptive(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SumsEnd(m, r->over_ranks, &total));
  const PetscReal num = total.num[0] + total.num[1], den = total.den[0] + total.den[1];
  r->fault = (PetscBool) !(PetscAbsReal(num) + den < PETSC_MAX_REAL);
  const PetscBool fits = (PetscBool)(total.num_max <= GROWTH * r->sums.num_max &&
                                     total.den_max <= GROWTH * r->sums.den_max);
  if (fits && num > 0. && den > 0.) r->q_ray = num / (den * state->dt); // (37)
  const PetscReal q = r->q_secant > 0. && scene->damping == DAMPING_ADAPTIVE ? PetscMin(r->q_ray, r->q_secant)
                                                                             : r->q_ray;
  state->alpha = PetscMin(2. * PetscSqrtReal(q), ALPHA_DT_MAX / state->dt); // (38)
  r->sums = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SecantStart(const Model *m, const Contacts *c, const State *state, Relaxation *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(r->u_0, state->u, m->n_dof));
  PetscCall(PetscArraycpy(r->u_secant, state->u, m->n_dof));
  PetscCall(PetscArraycpy(r->f_secant, state->f, m->n_dof));
  r->q_secant = r->longest = 0.;
  for (PetscInt i = 0; i < c->n_padded; i++) r->longest = PetscMax(r->longest, c->length[i]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &r->longest, 1, MPIU_REAL, MPI_MAX, m->comm));
  r->tangent_only = PETSC_FALSE;
  r->best_ratio = PETSC_MAX_REAL;
  r->best_cycle = state->cycle;
  r->made_energy = 0;
  r->half_ratio = PETSC_MAX_REAL, r->half_cycle = state->cycle, r->stalls = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Friction can feed an oscillation that the smaller damping does not still: when the unbalanced ratio has not
   fallen by a tenth over STALL_CYCLES, the stage goes on with the tangent alone; not where slip is kept as it
   comes, for springs feed nothing. */
static void guard_secant(const State *state, PetscReal ratio, Relaxation *r)
{
  if (state->ramp < 1. || ratio < 0.9 * r->best_ratio) r->best_ratio = ratio, r->best_cycle = state->cycle;
  if (state->cycle - r->best_cycle > STALL_CYCLES && r->stalls < STALLS_TO_LET_GO)
    r->tangent_only = PETSC_TRUE;
}

/* f belongs to the displacements before this cycle's step. */
static void secant_from(const Model *m, const State *state, Relaxation *r)
{
  for (PetscInt d = 0; d < m->n_dof; d++) {
    r->u_secant[d] = state->u[d] - state->v[d] * state->dt;
    r->f_secant[d] = state->f[d];
  }
}

/* Friction that follows the law closely chatters sooner; one that follows from afar is slow to lose the slip
   that the way has left behind. Where the unbalanced ratio has not halved in three halves of a period of the
   slowest mode, the other is tried. Near a limit load, and where hundreds of stones slide, neither comes to
   rest soon: after STALLS_TO_LET_GO of these slip is kept as it comes for the rest of the stage, by springs
   as in time, which take energy from whatever moves (tptm would make some with its diagram: theory.md, m).
   They feed no oscillation, so the secant damps again, not the tangent, which is tenfold too much where a
   few contacts chatter. */
void FollowElse(const Model *m, const State *state, PetscReal ratio, Relaxation *r, Contacts *contacts)
{
  const PetscReal wait = 3. * PetscMax(CHUNK_MIN, 2. * PETSC_PI / (state->alpha * state->dt));
  const PetscBool halved = (PetscBool)(state->ramp < 1. || ratio < 0.5 * r->half_ratio),
                  stalls = (PetscBool)(!halved && (PetscReal)(state->cycle - r->half_cycle) > wait);
  if (halved || stalls) r->half_ratio = ratio, r->half_cycle = state->cycle;
  if ((halved || stalls) && r->stalls >= STALLS_TO_LET_GO) secant_from(m, state, r);
  if (!stalls || !contacts->held || contacts->pull == 0.) return;
  contacts->pull = contacts->pull == FOLLOW_CLOSELY ? FOLLOW_FAR : FOLLOW_CLOSELY;
  if (++r->stalls < STALLS_TO_LET_GO) return;
  contacts->held = PETSC_FALSE, contacts->pull = 0., contacts->springs = PETSC_TRUE;
  r->tangent_only = PETSC_FALSE, r->best_ratio = PETSC_MAX_REAL;
}

PetscErrorCode Secant(const Model *m, const State *state, PetscReal ratio, Relaxation *r)
{
  PetscReal top[2] = {0., 0.}, sum[4] = {0., 0., 0., 0.};
  PetscFunctionBeginUser;
  guard_secant(state, ratio, r);
  if (r->tangent_only) {
    r->q_secant = 0.;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int pass = 0; pass < 2; pass++) { // largest terms, then the binned sums
    const Bins num_bins = BinsFor(PetscMax(top[0], 1e-290)), den_bins = BinsFor(PetscMax(top[1], 1e-290));
    for (PetscInt d = 0; d < m->n_dof; d++) {
      // f belongs to the displacements before this cycle's step
      const PetscReal du = state->u[d] - state->v[d] * state->dt - r->u_secant[d];
      const PetscReal num = du * (state->f[d] - r->f_secant[d]), den = state->m[d] * du * du;
      if (Held(m, d) || (m->in_quotient && m->in_quotient[d] == 0.)) continue;
      if (pass) {
        BinAdd(&num_bins, num, sum);
        BinAdd(&den_bins, den, sum + 2);
      } else {
        top[0] = PetscMax(top[0], PetscAbsReal(num));
        top[1] = PetscMax(top[1], den);
      }
    }
    if (pass)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 2, MPIU_REAL, MPI_MAX, m->comm));
  }
  const PetscReal num = sum[0] + sum[1], den = sum[2] + sum[3];
  r->q_secant = num > 0. && den > 0. ? num / den : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal DofLength(const Model *m, const State *state, PetscInt d)
{
  return d < 3 * m->n_bodies && d % 3 == 2 ? PetscSqrtReal(state->m[d] / state->m[d - 2]) : 1.;
}

/* Largest terms over all ranks, so that the sums can be binned; not finite: "bad" > 0. */
typedef struct {
  PetscReal unbalanced, scale, kinetic, displacement, increment, bad;
} Largest;

static Largest largest_terms(const Model *m, const State *state, const PetscReal *contact_scale)
{
  Largest l = {0., 0., 0., 0., 0., 0.};
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    const PetscReal u = PetscAbsReal(state->u[d]) * length,
                    du = PetscAbsReal(state->v[d]) * state->dt * length;
    l.unbalanced = PetscMax(l.unbalanced, r);
    l.scale = PetscMax(l.scale, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + r);
    l.kinetic = PetscMax(l.kinetic, 0.5 * state->m[d] * state->v[d] * state->v[d]);
    l.displacement = PetscMax(l.displacement, u);
    l.increment = PetscMax(l.increment, du);
    if (!(r < PETSC_MAX_REAL / 4. && u < PETSC_MAX_REAL / 4.)) l.bad = 1.;
  }
  return l;
}

PetscErrorCode Unbalanced(const Model *m, const State *state, const PetscReal *contact_scale,
                          StageResult *result)
{
  const PetscInt nb = m->n_bodies_global;
  Largest l = largest_terms(m, state, contact_scale);
  PetscReal *sum, floor = 0.;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &l, sizeof(l) / sizeof(PetscReal), MPIU_REAL, MPI_MAX, m->comm));
  result->increment = l.increment / PetscMax(l.displacement, DBL_MIN);
  result->displacement = l.displacement;
  result->finite = (PetscBool)(l.bad == 0.);
  if (!result->finite) PetscFunctionReturn(PETSC_SUCCESS);

  // per macroblock: sum |unbalanced| over free dofs, sum |applied| + |contact| + |reaction|; two bins each
  const Bins r_bins = BinsFor(PetscMax(l.unbalanced, 1e-290)), s_bins = BinsFor(PetscMax(l.scale, 1e-290)),
             k_bins = BinsFor(PetscMax(l.kinetic, 1e-290));
  PetscCall(PetscCalloc1(4 * nb + 2, &sum));
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), r = PetscAbsReal(state->f_ext[d] - state->f[d]) / length;
    PetscReal *s = sum + 4 * DofBody(m, d);
    BinAdd(&k_bins, 0.5 * state->m[d] * state->v[d] * state->v[d], sum + 4 * nb);
    if (!Held(m, d)) BinAdd(&r_bins, r, s);
    BinAdd(&s_bins, PetscAbsReal(state->f_ext[d]) / length + contact_scale[d] + (Held(m, d) ? r : 0.), s + 2);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 4 * nb + 2, MPIU_REAL, MPI_SUM, m->comm));
  // a body that carries next to nothing is not judged by rounding noise
  for (PetscInt b = 0; b < nb; b++) floor = PetscMax(floor, 1e-6 * (sum[4 * b + 2] + sum[4 * b + 3]));
  result->ratio = 0.;
  result->worst_body = -1;
  for (PetscInt b = 0; b < nb; b++) {
    const PetscReal unbalanced = sum[4 * b] + sum[4 * b + 1],
                    scale = PetscMax(sum[4 * b + 2] + sum[4 * b + 3], floor);
    if (unbalanced <= 0.) continue;
    if (unbalanced / scale > result->ratio) result->ratio = unbalanced / scale, result->worst_body = b;
  }
  result->kinetic = sum[4 * nb] + sum[4 * nb + 1];
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- verdicts */

/* A chunk lasts about one period of the slowest mode: omega_min = alpha/2 at the right damping. Where the
   last equilibrium shows what is right, it counts: slipping contacts drive alpha up and down by factors. The
   longer nothing is decided, the longer the chunks: a slow creep shows that it slows down. */
static void start_chunk(const Model *m, const State *state, Relaxation *r)
{
  const PetscReal alpha = r->settled_alpha > 0. ? r->settled_alpha / PetscSqrtReal(1. + 2. * state->beta)
                                                : state->alpha,
                  period = alpha > 0. ? 4. * PETSC_PI / (alpha * state->dt) : CHUNK_MIN;
  const PetscReal least = PetscMax(CHUNK_MIN, CHUNK_GROWTH * r->chunk_length);
  r->chunk_length = (PetscInt64)PetscMin(PetscMax(period, least), CHUNK_MAX);
  r->chunk_start = state->cycle;
  r->n_ratios = 0;
  for (PetscInt d = 0; d < m->n_dof; d++) r->u_chunk[d] = state->u[d];
  for (PetscInt d = 0; d < m->n_dof; d++) r->r_chunk[d] = state->f_ext[d] - state->f[d];
}

PetscErrorCode RelaxationReset(const Problem *p)
{
  const Model *m = p->m;
  Relaxation *r = p->relax;
  PetscReal gain;
  PetscFunctionBeginUser;
  r->steady = r->n_alpha = 0;
  r->still = PETSC_FALSE;
  r->alpha_sum = 0.;
  r->chunk_length = 0;
  for (int i = 0; i < 4; i++) r->median[i] = r->rate[i] = PETSC_INFINITY;
  for (int i = 0; i < 3; i++) r->ahead[i] = PETSC_INFINITY;
  PetscCall(PetscArrayzero(r->du_chunk, m->n_dof));
  PetscCall(PartingOfChunk(p, &gain));
  start_chunk(m, p->state, r);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RelaxationStill(const Problem *p)
{
  PetscFunctionBeginUser;
  p->state->beta = BETA_STILL;
  p->relax->tangent_only = (PetscBool)(p->relax->stalls < STALLS_TO_LET_GO);
  p->relax->q_secant = 0.;
  PetscCall(ScaledMasses(p->scene, p->m, p->stage->joints, p->contacts, p->state));
  PetscCall(RelaxationReset(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What moved in the chunk just ended. */
typedef struct {
  PetscReal norm;   /* [m] of the displacement */
  PetscReal most;   /* [m] largest component of it */
  PetscReal cosine; /* between it and that of the chunk before */
  PetscReal away;   /* its product with the displacement since the start of the stage, in units; > 0: away */
  PetscReal gain;   /* [-] largest part of its length that a contact has parted or slid by; -1: none can */
  PetscReal rest;   /* chunks like it to where the unbalanced force along it is nothing */
  PetscReal omega;  /* [1/cycle] frequency of the stiffness along it, 0: it has none */
  PetscReal way;    /* [m] largest displacement since the start of the stage or trial */
} ChunkMotion;

static PetscErrorCode chunk_motion(const Model *m, const State *state, Relaxation *r, ChunkMotion *motion)
{
  PetscReal top[3] = {0., 0., 0.}, sum[8] = {0., 0., 0., 0., 0., 0., 0., 0.};
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d);
    top[0] = PetscMax(top[0], PetscAbsReal(state->u[d] - r->u_chunk[d]) * length);
    top[1] = PetscMax(top[1], PetscAbsReal(r->du_chunk[d]) * length);
    top[2] = PetscMax(top[2], PetscAbsReal(state->u[d] - r->u_0[d]) * length);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, m->comm));
  // in units of the largest, so that one set of bins serves
  const PetscReal tiny = DBL_MIN * 1e20, unit = PetscMax(PetscMax(top[0], top[1]), tiny),
                  far = PetscMax(top[2], tiny);
  const Bins bins = BinsFor(1.);
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d), now = (state->u[d] - r->u_chunk[d]) * length / unit,
                    before = r->du_chunk[d] * length / unit, all = (state->u[d] - r->u_0[d]) * length / far;
    BinAdd(&bins, now * now, sum);
    BinAdd(&bins, now * before, sum + 2);
    BinAdd(&bins, before * before, sum + 4);
    BinAdd(&bins, now * all, sum + 6);
    r->du_chunk[d] = state->u[d] - r->u_chunk[d];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 8, MPIU_REAL, MPI_SUM, m->comm));
  const PetscReal nn = sum[0] + sum[1], nb = sum[2] + sum[3], bb = sum[4] + sum[5];
  motion->norm = unit * PetscSqrtReal(nn), motion->most = top[0], motion->way = top[2];
  motion->cosine = nn > 0. && bb > 0. ? nb / PetscSqrtReal(nn * bb) : 0.;
  motion->away = sum[6] + sum[7];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stiffness along the motion of the chunk, du: the unbalanced force R changes by dR over it, so du has
   the frequency omega^2 = -dR.du / du.m du, and R.du / -dR.du times du lead to where nothing drives it. */
static PetscErrorCode stiffness_along(const Model *m, const State *state, const Relaxation *r,
                                      ChunkMotion *motion)
{
  PetscReal top[3] = {0., 0., 0.}, sum[6] = {0., 0., 0., 0., 0., 0.};
  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { // largest terms, then the binned sums
    const Bins bins[3] = {BinsFor(PetscMax(top[0], 1e-290)), BinsFor(PetscMax(top[1], 1e-290)),
                          BinsFor(PetscMax(top[2], 1e-290))};
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscReal du = state->u[d] - r->u_chunk[d], R = state->f_ext[d] - state->f[d],
                      term[3] = {R * du, (r->r_chunk[d] - R) * du, state->m[d] * du * du};
      if (Held(m, d)) continue;
      for (int i = 0; i < 3 && pass; i++) BinAdd(bins + i, term[i], sum + 2 * i);
      for (int i = 0; i < 3 && !pass; i++) top[i] = PetscMax(top[i], PetscAbsReal(term[i]));
    }
    if (pass)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 6, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, m->comm));
  }
  const PetscReal drives = sum[0] + sum[1], holds = sum[2] + sum[3], inertia = sum[4] + sum[5];
  motion->rest = drives <= 0. ? 0. : holds > 0. ? drives / holds : PETSC_INFINITY;
  motion->omega = holds > 0. && inertia > 0. ? PetscSqrtReal(holds / inertia) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chunks like the last to where the motion ends: by the stiffness along it, or by how it slowed down over
   three chunks, whichever is sooner; infinite where it neither meets stiffness nor slows down. Where damping
   rules the motion, what it heads for has to come nearer: a body that turns over about a corner meets
   stiffness all the way, and less and less of it. */
static PetscReal chunks_to_go(const State *state, Relaxation *r, const ChunkMotion *motion)
{
  const PetscReal decay = PetscLogReal(r->rate[2] / r->rate[0]) / 2.; // per chunk
  for (int i = 2; i > 0; i--) r->ahead[i] = r->ahead[i - 1];
  r->ahead[0] = motion->rest * motion->norm;
  const PetscBool damped = (PetscBool)(state->alpha * state->dt * (PetscReal)r->chunk_length > 2.),
                  recedes = (PetscBool)(damped && r->ahead[0] > r->ahead[2]);
  return PetscMin(decay > 0. ? 1. / decay : PETSC_INFINITY, recedes ? PETSC_INFINITY : motion->rest);
}

/* Whether the motion would carry faces as far as contacts do not bear. What meets no stiffness at all does:
   it floats; nothing else where no joint can fail. */
static PetscBool goes_far(const Problem *p, const ChunkMotion *motion, PetscReal to_go)
{
  const PetscReal way = to_go * motion->most;
  if (p->stage->variable) return (PetscBool)(way > OUTGROWN * p->relax->longest);
  if (motion->gain < 0. || to_go > FLOATS) return (PetscBool)(to_go > FLOATS);
  return (PetscBool)(way > OUTGROWN * p->relax->longest && to_go * motion->gain > OUTGROWN);
}

static PetscErrorCode collapsed(const Relaxation *r, const ChunkMotion *motion, PetscReal way,
                                PetscReal diameter, StageResult *result)
{
  char end[32] = "no end";
  PetscFunctionBeginUser;
  if (way < 1e3 * diameter) PetscCall(PetscSNPrintf(end, sizeof(end), "%.3g m to go", (double)way));
  result->verdict = VERDICT_COLLAPSED;
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                          "over 3 chunks of %" PetscInt64_FMT " cycles: median ratio from %.3g to %.3g, "
                          "motion from %.3g to %.3g m a cycle, cosine %.4f, %s",
                          r->chunk_length, (double)r->median[2], (double)r->median[0], (double)r->rate[2],
                          (double)r->rate[0], (double)motion->cosine, end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A trial that is this far beyond what the scene allows, and goes on, need not come to rest to have failed:
   where it began is no farther than the limit from the start of the stage. */
static PetscErrorCode judge_limit(const Problem *p, const ChunkMotion *motion)
{
  const PetscReal limit = p->stage->displacement_limit; // NaN: none
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_NONE || p->relax->steady < 1 || !(motion->way > 2. * limit))
    PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_COLLAPSED;
  PetscCall(PetscSNPrintf(
      result->evidence, sizeof(result->evidence),
      "%.3g m from where the trial began, and it goes on: more than twice the displacement_limit, "
      "%.3g m",
      (double)motion->way, (double)limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collapse. Below the limit unbalanced ratio and motion fall together, by a factor of 500 in a period at the
   right damping, of 1.1 at ten times too much. Past it a mechanism moves on: over three periods neither
   falls by 5 %, and the motion keeps its direction (or turns with a body that speeds up), away from where
   the stage began: a block that has overshot and finds its way back through the air moves as steadily. And
   it meets no stiffness that would end it: what swings or creeps to an equilibrium nearer than OUTGROWN
   contact lengths is waited for, and so is an open joint that the motion closes on such a way: a loose stone
   that crosses a gap moves as steadily as one that falls, until it bears. */
static PetscErrorCode judge_chunk(const Problem *p)
{
  const Model *m = p->m;
  const State *state = p->state;
  Relaxation *r = p->relax;
  ChunkMotion motion = {.norm = 0.};
  PetscFunctionBeginUser;
  for (int i = 3; i > 0; i--) r->median[i] = r->median[i - 1], r->rate[i] = r->rate[i - 1];
  PetscCall(PetscRealSortSemiOrdered(r->n_ratios, r->ratios));
  r->median[0] = r->ratios[r->n_ratios / 2];
  PetscCall(chunk_motion(m, state, r, &motion));
  PetscCall(stiffness_along(m, state, r, &motion));
  PetscCall(PartingOfChunk(p, &motion.gain));
  r->rate[0] = motion.norm / (state->cycle - r->chunk_start);
  const PetscBool steady = (PetscBool)(motion.cosine > 0.98 ||
                                       (motion.cosine > 0.9 && r->rate[0] > 1.5 * r->rate[1]));
  r->steady = steady && motion.away > 0. ? r->steady + 1 : 0;
  const PetscReal to_go = chunks_to_go(state, r, &motion);
  const PetscBool far = goes_far(p, &motion, to_go);
  // what swings more slowly than two chunks had no time to halve
  const PetscBool slow = (PetscBool)(!far && motion.omega * r->chunk_length < PETSC_PI);
  if (state->beta > 0. && state->beta < BETA_STILL && r->median[2] < PETSC_INFINITY &&
      r->median[0] > 0.5 * r->median[2] && !slow) {
    r->still = PETSC_TRUE; // evidence begins anew
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscBool holds = (PetscBool)(r->median[0] > 0.95 * r->median[2] && r->rate[0] > 0.95 * r->rate[2]);
  if (r->steady >= CHUNKS_TO_COLLAPSE && holds && far) {
    PetscReal gap;
    PetscCall(MotionCloses(m, state, p->contacts, r->du_chunk, OUTGROWN * r->longest / motion.most, &gap));
    if (gap == 0.) PetscCall(collapsed(r, &motion, to_go * motion.most, m->diameter, p->result));
  }
  PetscCall(judge_limit(p, &motion));
  start_chunk(m, state, r);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Judge(const Problem *p)
{
  const Stage *stage = p->stage;
  const State *state = p->state;
  Relaxation *r = p->relax;
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  if (!result->finite || result->displacement > 1e3 * p->m->diameter) {
    char where[128];
    result->verdict = VERDICT_DIVERGED;
    PetscCall(FaultName(p->m, FaultFind(p->m, state), where));
    if (result->finite)
      PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                              "displacement %.6g m is a thousand times the model",
                              (double)result->displacement));
    else
      PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                              "a force or displacement is not a finite number, first in %s", where));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (state->ramp < 1.) PetscFunctionReturn(PETSC_SUCCESS);
  r->alpha_sum += state->alpha, r->n_alpha++;
  PetscBool rests = (PetscBool)(result->ratio <= stage->tolerance &&
                                result->increment <= stage->velocity_tolerance);
  if (rests) PetscCall(LoadsCarried(p, CARRIED, &rests));
  if (rests) {
    result->verdict = VERDICT_CONVERGED;
    r->settled_alpha = PetscSqrtReal(1. + 2. * state->beta) * r->alpha_sum / r->n_alpha;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "unbalanced ratio %.3g <= %.3g, increment %.3g <= %.3g", (double)result->ratio,
                            (double)stage->tolerance, (double)result->increment,
                            (double)stage->velocity_tolerance));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (r->n_ratios < r->max_ratios) r->ratios[r->n_ratios++] = result->ratio;
  if (state->cycle - r->chunk_start >= r->chunk_length) PetscCall(judge_chunk(p));
  if (result->verdict == VERDICT_NONE && result->cycles >= stage->max_cycles) {
    result->verdict = VERDICT_UNDECIDED;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "%" PetscInt64_FMT " cycles: ratio %.3g > %.3g or increment %.3g > %.3g",
                            result->cycles, (double)result->ratio, (double)stage->tolerance,
                            (double)result->increment, (double)stage->velocity_tolerance));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* judge.c: decides the verdict of a static stage from the evidence of its cycles. */
#include "verdict/judge.h"
#include "base/reproducible.h"
#include <float.h>

/* Starts a chunk of about one period of the slowest mode, whose frequency is alpha/2 at the right damping.
   The damping of the last equilibrium is preferred to the present alpha, which slipping contacts change by
   factors. Each chunk is longer than the one before, so that a slow creep shows that it slows down. */
static void start_chunk(const Model *m, const State *state, Relaxation *r)
{
  const PetscReal alpha = r->evidence.settled_alpha > 0.
                              ? r->evidence.settled_alpha / PetscSqrtReal(1. + 2. * state->beta)
                              : state->alpha,
                  period = alpha > 0. ? 4. * PETSC_PI / (alpha * state->dt) : ShortestChunk(state);
  const PetscReal least = PetscMax(ShortestChunk(state), CHUNK_GROWTH * r->evidence.chunk_length);
  r->evidence.chunk_length = (PetscInt64)PetscMin(PetscMax(period, least), CHUNK_MAX);
  r->evidence.chunk_start = state->cycle;
  r->evidence.n_ratios = 0;
  for (PetscInt d = 0; d < m->n_dof; d++) r->evidence.u_chunk[d] = state->u[d];
  for (PetscInt d = 0; d < m->n_dof; d++) r->evidence.r_chunk[d] = state->f_ext[d] - state->f[d];
}

PetscErrorCode RelaxationReset(const Problem *p)
{
  const Model *m = p->m;
  Relaxation *r = p->relax;
  PetscReal gain;
  PetscFunctionBeginUser;
  r->evidence.steady = r->evidence.n_alpha = 0;
  r->evidence.still = PETSC_FALSE;
  r->evidence.alpha_sum = 0.;
  r->evidence.chunk_length = 0;
  for (int i = 0; i < 4; i++) r->evidence.median[i] = r->evidence.rate[i] = PETSC_INFINITY;
  for (int i = 0; i < 3; i++) r->evidence.ahead[i] = PETSC_INFINITY;
  PetscCall(PetscArrayzero(r->evidence.du_chunk, m->n_dof));
  PetscCall(RestPointForget(m, &r->evidence.rest));
  PetscCall(ContactTravelOfChunk(p, &gain));
  start_chunk(m, p->state, r);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The displacement du over the chunk just ended. */
typedef struct {
  PetscReal norm;   /* [m] of du */
  PetscReal most;   /* [m] largest component of du */
  PetscReal cosine; /* [-] cosine between du and the displacement over the chunk before */
  PetscReal away;   /* [-] scaled product of du and the displacement since the stage began; > 0: away */
  PetscReal gain;  /* [-] largest gain of travel of a contact (ContactTravelOfChunk); -1: no joint can fail */
  PetscReal rest;  /* [chunks] distance, in units of du, to where nothing drives it any more */
  PetscReal omega; /* [1/cycle] frequency of the stiffness along du; 0: no stiffness */
  PetscReal way;   /* [m] largest displacement since the start of the stage or trial */
} ChunkMotion;

/* Collective. Measures du, and keeps it in du_chunk. Sets norm, most, cosine, away and way. */
static PetscErrorCode chunk_motion(const Model *m, const State *state, Relaxation *r, ChunkMotion *motion)
{
  PetscReal top[3] = {0., 0., 0.}, sum[8] = {0., 0., 0., 0., 0., 0., 0., 0.};
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d);
    top[0] = PetscMax(top[0], PetscAbsReal(state->u[d] - r->evidence.u_chunk[d]) * length);
    top[1] = PetscMax(top[1], PetscAbsReal(r->evidence.du_chunk[d]) * length);
    top[2] = PetscMax(top[2], PetscAbsReal(state->u[d] - r->evidence.u_0[d]) * length);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, m->comm));
  // all terms are taken in units of the largest displacement, so that one set of bins serves
  const PetscReal tiny = DBL_MIN * 1e20, unit = PetscMax(PetscMax(top[0], top[1]), tiny),
                  far = PetscMax(top[2], tiny);
  const Bins bins = BinsFor(1.);
  for (PetscInt d = 0; d < m->n_dof; d++) {
    const PetscReal length = DofLength(m, state, d),
                    now = (state->u[d] - r->evidence.u_chunk[d]) * length / unit,
                    before = r->evidence.du_chunk[d] * length / unit,
                    all = (state->u[d] - r->evidence.u_0[d]) * length / far;
    BinAdd(&bins, now * now, sum);
    BinAdd(&bins, now * before, sum + 2);
    BinAdd(&bins, before * before, sum + 4);
    BinAdd(&bins, now * all, sum + 6);
    r->evidence.du_chunk[d] = state->u[d] - r->evidence.u_chunk[d];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 8, MPIU_REAL, MPI_SUM, m->comm));
  const PetscReal nn = sum[0] + sum[1], nb = sum[2] + sum[3], bb = sum[4] + sum[5];
  motion->norm = unit * PetscSqrtReal(nn), motion->most = top[0], motion->way = top[2];
  motion->cosine = nn > 0. && bb > 0. ? nb / PetscSqrtReal(nn * bb) : 0.;
  motion->away = sum[6] + sum[7];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Finds the stiffness along the motion of the chunk, du. The unbalanced force R changes by dR
   over the chunk, so du has the frequency omega^2 = -dR.du / du.m du, and R.du / -dR.du times du leads to
   where nothing drives the motion. */
static PetscErrorCode stiffness_along(const Model *m, const State *state, const Relaxation *r,
                                      ChunkMotion *motion)
{
  PetscReal top[3] = {0., 0., 0.}, sum[6] = {0., 0., 0., 0., 0., 0.}, *mass_way;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_dof, &mass_way));
  PetscCall(MassProduct(m, state, r->evidence.du_chunk, mass_way)); // chunk_motion has set du_chunk
  for (int pass = 0; pass < 2; pass++) {                            // largest terms, then the binned sums
    const Bins bins[3] = {BinsFor(PetscMax(top[0], 1e-290)), BinsFor(PetscMax(top[1], 1e-290)),
                          BinsFor(PetscMax(top[2], 1e-290))};
    for (PetscInt d = 0; d < m->n_dof; d++) {
      const PetscReal du = state->u[d] - r->evidence.u_chunk[d], R = state->f_ext[d] - state->f[d],
                      term[3] = {R * du, (r->evidence.r_chunk[d] - R) * du, mass_way[d] * du};
      if (Held(m, d)) continue;
      for (int i = 0; i < 3 && pass; i++) BinAdd(bins + i, term[i], sum + 2 * i);
      for (int i = 0; i < 3 && !pass; i++) top[i] = PetscMax(top[i], PetscAbsReal(term[i]));
    }
    if (pass)
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 6, MPIU_REAL, MPI_SUM, m->comm));
    else
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, top, 3, MPIU_REAL, MPI_MAX, m->comm));
  }
  PetscCall(PetscFree(mass_way));
  const PetscReal drives = sum[0] + sum[1], holds = sum[2] + sum[3], inertia = sum[4] + sum[5];
  motion->rest = drives <= 0. ? 0. : holds > 0. ? drives / holds : PETSC_INFINITY;
  motion->omega = holds > 0. && inertia > 0. ? PetscSqrtReal(holds / inertia) : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates how many chunks like the last one lead to the end of the motion: from the stiffness along du,
   or from the fall of the pace over three chunks, whichever is sooner. The number is infinite where the
   motion neither meets stiffness nor slows down. Where damping rules the motion, the stiffness counts only
   if the end comes nearer from chunk to chunk: a body that turns over about a corner meets stiffness all
   the way, but less and less. */
static PetscReal chunks_to_go(const State *state, Relaxation *r, const ChunkMotion *motion)
{
  const PetscReal decay = PetscLogReal(r->evidence.rate[2] / r->evidence.rate[0]) / 2.; // per chunk
  for (int i = 2; i > 0; i--) r->evidence.ahead[i] = r->evidence.ahead[i - 1];
  r->evidence.ahead[0] = motion->rest * motion->norm;
  const PetscBool damped = (PetscBool)(state->alpha * state->dt * (PetscReal)r->evidence.chunk_length >
                                       DAMPED_CHUNK),
                  recedes = (PetscBool)(damped && r->evidence.ahead[0] > r->evidence.ahead[2]);
  return PetscMin(decay > 0. ? 1. / decay : PETSC_INFINITY, recedes ? PETSC_INFINITY : motion->rest);
}

/* Returns whether the motion would carry faces so far that their contacts no longer bear. A motion that meets
   no stiffness at all does so: the body floats. Where no joint can fail, no other motion does so. */
static PetscBool goes_far(const Problem *p, const ChunkMotion *motion, PetscReal to_go)
{
  const PetscReal way = to_go * motion->most;
  if (ContactsVary(p->contacts, p->stage))
    return (PetscBool)(way > TRAVEL_LIMIT * p->relax->evidence.longest);
  if (motion->gain < 0. || to_go > FLOATS) return (PetscBool)(to_go > FLOATS);
  return (PetscBool)(way > TRAVEL_LIMIT * p->relax->evidence.longest && to_go * motion->gain > TRAVEL_LIMIT);
}

/* Sets the verdict "collapsed" with its evidence. way: [m] distance to the end of the motion. */
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
                          r->evidence.chunk_length, (double)r->evidence.median[2],
                          (double)r->evidence.median[0], (double)r->evidence.rate[2],
                          (double)r->evidence.rate[0], (double)motion->cosine, end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides "collapsed" for a trial that has moved on by more than LIMIT_TIMES displacement_limit, even before
   it comes to rest. It began no farther than the limit from the start of the stage, so it is now beyond the
   limit. */
static PetscErrorCode judge_limit(const Problem *p, const ChunkMotion *motion)
{
  const PetscReal limit = p->stage->displacement_limit; // NaN: none
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_NONE || p->relax->evidence.steady < 1 ||
      !(motion->way > LIMIT_TIMES * limit))
    PetscFunctionReturn(PETSC_SUCCESS);
  result->verdict = VERDICT_COLLAPSED;
  PetscCall(PetscSNPrintf(
      result->evidence, sizeof(result->evidence),
      "%.3g m from where the trial began, and it goes on: more than twice the displacement_limit, "
      "%.3g m",
      (double)motion->way, (double)limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Judges the chunk that ends here, and starts the next one.

   Below the limit load the unbalanced ratio and the motion fall together: by a factor of 500 in a period at
   the right damping. At ten times too much damping a chunk is a tenth of the period, and three chunks still
   bring a factor of 1.1. Past the limit load a mechanism moves on. Where the ratio does not halve, flutter is
   excluded first, by more damping (friction_mode.c). The stage has collapsed when all of the following hold.
   - Over three chunks neither the ratio nor the motion falls by 5 %.
   - The motion keeps its direction, or turns with a body that speeds up.
   - The motion leads away from where the stage began. A block that has overshot and comes back through the
     air moves as steadily.
   - No stiffness would end the motion within TRAVEL_LIMIT contact lengths, neither by the forces at the
     ends of the last chunk nor by the means of three chunks. A motion that swings or creeps to a nearer
     equilibrium is waited for.
   - No open joint would close within that distance. A loose stone that crosses a gap moves as steadily as one
     that falls, until it bears. */
static PetscErrorCode judge_chunk(const Problem *p)
{
  const Model *m = p->m;
  const State *state = p->state;
  Relaxation *r = p->relax;
  ChunkMotion motion = {.norm = 0.};
  PetscFunctionBeginUser;
  for (int i = 3; i > 0; i--)
    r->evidence.median[i] = r->evidence.median[i - 1], r->evidence.rate[i] = r->evidence.rate[i - 1];
  PetscCall(PetscRealSortSemiOrdered(r->evidence.n_ratios, r->evidence.ratios));
  r->evidence.median[0] = r->evidence.ratios[r->evidence.n_ratios / 2];
  PetscCall(chunk_motion(m, state, r, &motion));
  PetscCall(stiffness_along(m, state, r, &motion));
  PetscCall(RestPointOfChunk(m, state, &r->evidence.rest));
  PetscCall(ContactTravelOfChunk(p, &motion.gain));
  r->evidence.rate[0] = motion.norm / (state->cycle - r->evidence.chunk_start);
  const PetscBool steady = (PetscBool)(motion.cosine > SAME_DIRECTION ||
                                       (motion.cosine > SAME_ARC &&
                                        r->evidence.rate[0] > SPEEDS_UP * r->evidence.rate[1]));
  r->evidence.steady = steady && motion.away > 0. ? r->evidence.steady + 1 : 0;
  const PetscReal to_go = chunks_to_go(state, r, &motion);
  const PetscBool far = goes_far(p, &motion, to_go);
  // a motion with a period longer than two chunks had no time to halve the ratio
  const PetscBool slow = (PetscBool)(!far && motion.omega * r->evidence.chunk_length < PETSC_PI);
  if (state->beta > 0. && state->beta < BETA_STILL && r->evidence.median[2] < PETSC_INFINITY &&
      r->evidence.median[0] > HALVED * r->evidence.median[2] && !slow) {
    r->evidence.still = PETSC_TRUE; // RelaxationStill forgets the evidence and starts the next chunk
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const PetscBool holds = (PetscBool)(r->evidence.median[0] > HOLDS * r->evidence.median[2] &&
                                      r->evidence.rate[0] > HOLDS * r->evidence.rate[2]);
  if (r->evidence.steady >= CHUNKS_TO_COLLAPSE && holds && far && p->stage->kind != STAGE_PUSHOVER &&
      RestPointAhead(&r->evidence.rest) > TRAVEL_LIMIT * r->evidence.longest) {
    PetscReal gap;
    PetscCall(MotionCloses(m, state, p->contacts, r->evidence.du_chunk,
                           TRAVEL_LIMIT * r->evidence.longest / motion.most, &gap));
    if (gap == 0.) PetscCall(collapsed(r, &motion, to_go * motion.most, m->mesh.diameter, p->result));
  }
  PetscCall(judge_limit(p, &motion));
  start_chunk(m, state, r);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns what a user may try where a stage runs out of cycles. The ratio still falls where the last chunk
   has halved it. */
static const char *remedy(const Problem *p)
{
  const PetscReal *median = p->relax->evidence.median;
  const PetscBool falls = (PetscBool)(median[0] < HALVED * median[2]);
  if (!p->result->loaded)
    return "; no load acts or has acted: the unbalanced force has nothing to be compared with";
  if (ContactsVary(p->contacts, p->stage) || p->relax->effort.preconditioned)
    return "; raise max_cycles to know more";
  return falls ? "; it falls: raise max_cycles, or try relaxation.method: preconditioned"
               : "; the ratio no longer falls: try relaxation.method: preconditioned";
}

PetscErrorCode Judge(const Problem *p)
{
  const Stage *stage = p->stage;
  const State *state = p->state;
  Relaxation *r = p->relax;
  StageResult *result = p->result;
  PetscFunctionBeginUser;
  if (!result->finite || result->displacement > DIVERGED * p->m->mesh.diameter) {
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
  if (state->applied.ramp < 1.) PetscFunctionReturn(PETSC_SUCCESS);
  r->evidence.alpha_sum += state->alpha, r->evidence.n_alpha++;
  PetscBool rests = (PetscBool)(result->ratio <= stage->tolerance &&
                                result->increment <= stage->velocity_tolerance);
  if (rests) PetscCall(BodiesAreSupported(p, LOAD_MISSING, &rests));
  if (rests) {
    result->verdict = VERDICT_CONVERGED;
    r->evidence.settled_alpha = PetscSqrtReal(1. + 2. * state->beta) * r->evidence.alpha_sum /
                                r->evidence.n_alpha;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "unbalanced ratio %.3g <= %.3g, increment %.3g <= %.3g", (double)result->ratio,
                            (double)stage->tolerance, (double)result->increment,
                            (double)stage->velocity_tolerance));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  RestPointAdd(p->m, state, &r->evidence.rest);
  if (r->evidence.n_ratios < r->evidence.max_ratios)
    r->evidence.ratios[r->evidence.n_ratios++] = result->ratio;
  if (state->cycle - r->evidence.chunk_start >= r->evidence.chunk_length) PetscCall(judge_chunk(p));
  const PetscInt64 cycles = result->cycles - r->begun;
  if (result->verdict == VERDICT_NONE && cycles >= stage->max_cycles) {
    result->verdict = VERDICT_UNDECIDED;
    PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                            "%" PetscInt64_FMT " cycles: ratio %.3g > %.3g or increment %.3g > %.3g%s",
                            cycles, (double)result->ratio, (double)stage->tolerance,
                            (double)result->increment, (double)stage->velocity_tolerance, remedy(p)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

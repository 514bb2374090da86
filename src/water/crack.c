/* crack.c: iterates the open length of a joint under uplift with a cracked base. The open length decides
   the pressure in the joint, the pressure the equilibrium, and the equilibrium the open length.
   UpliftCrack makes one round of this iteration.

   A round begins only from an equilibrium. Blocks in motion open the joint farther than their equilibrium
   does, and the full head over that length may leave no equilibrium where statics has one. From an
   equilibrium the open length grows in each round, up to the least length with a static equilibrium. */
#include "water/uplift.h"

/* A contact along the joint, its two ends in the order of s (the place along the chord from the heel). */
typedef struct {
  PetscReal s[2], u_n[2];
  PetscInt open[2];
} Span;

static int span_order(const void *a, const void *b)
{
  const Span *p = a, *q = b;
  return (p->s[0] > q->s[0]) - (p->s[0] < q->s[0]);
}

/* Sorts the contacts along the joint. spans: (n,) by their distance from the heel. */
static PetscErrorCode spans_along(const Uplift *u, PetscInt n, const ProfileRow *rows, Span **spans)
{
  Span *span;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(1, n), &span));
  for (PetscInt i = 0; i < n; i++) {
    const int turned = UpliftPlace(u, rows[i].point[1]) < UpliftPlace(u, rows[i].point[0]);
    for (int k = 0; k < 2; k++) {
      const int from = turned ? 1 - k : k;
      span[i].s[k] = UpliftPlace(u, rows[i].point[from]);
      span[i].u_n[k] = rows[i].u_n[from], span[i].open[k] = rows[i].open[from];
    }
  }
  qsort(span, n, sizeof(Span), span_order);
  *spans = span;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An open stretch of the joint. closure: [m] largest closure between the stretch before (or the heel) and
   this one. */
typedef struct {
  PetscReal from, to, closure;
} Stretch;

/* Appends an open stretch, or joins it to the last one if the gap is at most tie. */
static void add_open(PetscReal tie, PetscReal from, PetscReal to, PetscReal *closure, PetscInt *n,
                     Stretch *open)
{
  if (*n && from <= open[*n - 1].to + tie) {
    open[*n - 1].to = PetscMax(open[*n - 1].to, to);
  } else {
    open[(*n)++] = (Stretch){from, to, *closure};
    *closure = 0.;
  }
}

/* Returns the distance [m] below which positions along the joint count as one. */
static PetscReal tie_of(const Uplift *u)
{
  return 1e-6 * u->length;
}

/* Finds the open stretches, (n_open of 3 n + 1,), from heel to toe. A place without a contact is open,
   because its faces have parted. */
static PetscErrorCode open_stretches(const Uplift *u, PetscInt n, const ProfileRow *rows, PetscInt *n_open,
                                     Stretch *open)
{
  PetscReal reached = 0., closure = 0.;
  Span *span;
  PetscFunctionBeginUser;
  PetscCall(spans_along(u, n, rows, &span));
  *n_open = 0;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *s = span[i].s, *u_n = span[i].u_n;
    if (s[0] > reached + tie_of(u)) add_open(tie_of(u), reached, s[0], &closure, n_open, open);
    reached = PetscMax(reached, s[1]);
    const int first = !!span[i].open[0], last = !!span[i].open[1];
    const PetscReal out = u_n[!first], in = u_n[first],
                    part = first == last         ? first
                           : out > 0. && in < 0. ? out / (out - in)
                                                 : 0.5;
    if (first) add_open(tie_of(u), s[0], s[0] + part * (s[1] - s[0]), &closure, n_open, open);
    for (int k = 0; k < 2; k++)
      if (!span[i].open[k]) closure = PetscMax(closure, -u_n[k]);
    if (last && !first) add_open(tie_of(u), s[1] - part * (s[1] - s[0]), s[1], &closure, n_open, open);
  }
  if (reached < u->length - tie_of(u)) add_open(tie_of(u), reached, u->length, &closure, n_open, open);
  PetscCall(PetscFree(span));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the length [m] with the full head: as far as the joint is open from the heel. With the key
   `reaches: any` it ends at the last open stretch that does not reach the toe; a stretch at the toe has
   the tailwater. */
static PetscReal wet_length(const Load *load, const Uplift *u, PetscInt n, const Stretch *open)
{
  PetscReal wet = 0.;
  for (PetscInt i = 0; i < n; i++) {
    const PetscBool from_heel = (PetscBool)(open[i].from <= tie_of(u)),
                    inside = (PetscBool)(open[i].to < u->length - tie_of(u) &&
                                         open[i].to - open[i].from > load->uplift.crack_tolerance);
    if (from_heel || (inside && load->uplift.reaches == REACHES_ANY)) wet = open[i].to;
  }
  return wet > u->length - tie_of(u) ? u->length : wet;
}

/* Stores in u->dry the open stretches without the full head. */
static void store_dry(const Load *load, PetscReal wet, PetscInt n, const Stretch *open, Uplift *u)
{
  u->n_dry = 0;
  for (PetscInt i = 0; i < n && u->n_dry < UPLIFT_MOST_DRY; i++) {
    if (open[i].from < wet || open[i].to - open[i].from <= load->uplift.crack_tolerance ||
        open[i].from <= tie_of(u))
      continue;
    u->dry[u->n_dry++] = (UpliftDry){.from = open[i].from,
                                     .to = open[i].to,
                                     .closed_from = i ? open[i - 1].to : 0.,
                                     .closure = open[i].closure,
                                     .at_toe = (PetscBool)(open[i].to >= u->length - tie_of(u))};
  }
}

/* Collective. Measures the present joint of a cracked load. wet receives the length [m] with the full
   head. */
static PetscErrorCode measure(const Model *m, const Contacts *c, const Load *load, Uplift *u, PetscReal *wet)
{
  PetscInt n, n_open = 0;
  ProfileRow *rows;
  Stretch *open;
  PetscFunctionBeginUser;
  PetscCall(GatherProfile(m, c, u->n_gids, u->gids, &n, &rows));
  PetscCall(PetscMalloc1(3 * n + 1, &open));
  PetscCall(open_stretches(u, n, rows, &n_open, open));
  *wet = wet_length(load, u, n_open, open);
  store_dry(load, *wet, n_open, open, u);
  PetscCall(PetscFree(open));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftFindDry(const TermView *v, PetscBool report)
{
  const Scene *scene = v->scene;
  const Stage *stage = v->stage;
  const Model *m = v->m;
  PetscReal wet;
  PetscFunctionBeginUser;
  for (PetscInt l = 0; l < stage->n_loads; l++) {
    const Load *load = scene->loads + stage->loads[l];
    Uplift *u = (Uplift *)v->memory + stage->loads[l];
    if (load->kind != LOAD_UPLIFT || !load->uplift.cracked) continue;
    PetscCall(measure(m, v->contacts, load, u, &wet));
    for (PetscInt i = 0; i < u->n_dry && report && !m->rank && !StageInTime(v->stage); i++) {
      const UpliftDry *d = u->dry + i;
      if (d->at_toe) continue; // it has the tailwater
      Warn("stage %s: %s: the joint is open over %.4g m, from %.4g to %.4g m from the heel, "
           "and "
           "has no full head there: %.3g m before it are closed, by %.3g m at most; reaches: any lets it in",
           stage->name, load->name, (double)(d->to - d->from), (double)d->from, (double)d->to,
           (double)(d->from - d->closed_from), (double)d->closure);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the pressure is zero in the crack that the earthquake of the stage opens. */
static PetscBool has_no_pressure(const TermView *v, const Load *load)
{
  return (PetscBool)(load->uplift.cracked && UpliftInEarthquake(v->scene, v->stage, load) == SHAKEN_ZERO);
}

PetscErrorCode UpliftStart(const TermView *v)
{
  const Scene *scene = v->scene;
  const Stage *stage = v->stage;
  Uplift *all = v->memory;
  PetscFunctionBeginUser;
  if (StageInTime(stage)) PetscFunctionReturn(PETSC_SUCCESS); // cracks stay as they are
  for (PetscInt l = 0; l < scene->n_loads; l++) {
    PetscBool acts = PETSC_FALSE;
    for (PetscInt i = 0; i < stage->n_loads; i++) acts = (PetscBool)(acts || stage->loads[i] == l);
    all[l].rounds = 0;
    if (!acts) all[l].crack = 0.;
    if (!acts || !has_no_pressure(v, scene->loads + l)) all[l].opened = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Removes the pressure from the crack that an earthquake opens beyond the state before. Less
   pressure closes the crack, so each round makes half of the change and the iteration settles. It also
   runs before equilibrium, because with the full pressure there may be none. */
static PetscErrorCode follow_earthquake(const TermView *v, const Load *load, TermMoment when, Uplift *u,
                                        PetscBool *again)
{
  PetscReal open;
  PetscFunctionBeginUser;
  PetscCall(measure(v->m, v->contacts, load, u, &open));
  const PetscReal wanted = open > u->crack + load->uplift.crack_tolerance ? open : 0.,
                  least = PetscMax(u->opened, u->crack), change = PetscMax(wanted, u->crack) - least;
  if (PetscAbsReal(change) <= load->uplift.crack_tolerance) PetscFunctionReturn(PETSC_SUCCESS);
  u->opened = least + 0.5 * change;
  if (when == AT_EQUILIBRIUM) u->rounds++;
  *again = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode UpliftCrack(const TermView *v, TermMoment when, StageResult *result, PetscBool *again)
{
  const Stage *stage = v->stage;
  enum { MOST_ROUNDS = 200 };
  const PetscReal through = 0.9999; // of the joint's length: the rest would be crushed earlier
  PetscReal crack = 0.;
  PetscFunctionBeginUser;
  *again = PETSC_FALSE;
  if (when == AT_CHECK) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < stage->n_loads; l++) {
    const Load *load = v->scene->loads + stage->loads[l];
    Uplift *u = (Uplift *)v->memory + stage->loads[l];
    if (load->kind != LOAD_UPLIFT || !load->uplift.cracked) continue;
    if (UpliftInEarthquake(v->scene, stage, load) == SHAKEN_UNCHANGED) continue;
    if (has_no_pressure(v, load)) {
      if (u->rounds < MOST_ROUNDS) PetscCall(follow_earthquake(v, load, when, u, again));
      continue;
    }
    if (when != AT_EQUILIBRIUM) continue;
    PetscCall(measure(v->m, v->contacts, load, u, &crack));
    const PetscBool through_joint = (PetscBool)(crack > through * u->length);
    if (!through_joint && PetscAbsReal(crack - u->crack) <= load->uplift.crack_tolerance) continue;
    if (through_joint || u->rounds >= MOST_ROUNDS) {
      result->verdict = through_joint ? VERDICT_COLLAPSED : VERDICT_UNDECIDED;
      PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                              "cracked base of %s %s: open over %.4g m of %.4g m, %.4g m before, after "
                              "%" PetscInt_FMT " rounds%s",
                              load->name, through_joint ? "runs away" : "still changes", (double)crack,
                              (double)u->length, (double)u->crack, u->rounds,
                              through_joint ? "" : "; raise crack_tolerance of this load"));
      *again = PETSC_FALSE;
      break;
    }
    u->crack = crack, u->rounds++;
    *again = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* stress_models.c: holds the table of the six stress models, and computes the response of one contact on its
   own. The models themselves are in stress_models.h and tptm.h, for LANES contacts at once. */
#include "contacts/law/law.h"
#include "contacts/law/stress_models.h"

_Static_assert((int)LANES >= (int)MOST_POINTS, "points of a contact fill lanes");

/* Each row has the shares c1, cm, c2 of end 0 in the stresses s0, sm, s1.
   pt:   forces s L/2 act at the ends themselves.
   r2pt: forces s L/2 act at L/4 and 3L/4, and the lever shares them: 1/2 (3/4, 1/4).
   r3pt: forces s L/4, s L/2, s L/4 act at L/8, L/2, 7L/8: (1/4 7/8, 1/2 1/2, 1/4 1/8).
   t2pt: the shares are the integrals of (1-x)(1-x) and x (1-x).
   t3pt: two trapezoids of L/2; c1 is the integral of (1-2x)(1-x) over the first half, cm is 1/4 by symmetry,
         and c2 is the rest of 1/2.
   tptm: as t2pt where nothing is violated. */
const LanesModel LanesModels[STRESS_MODELS] = {
    [STRESS_PT] = {{1. / 2, 0, 0}, {1. / 2, 0}, 0},
    [STRESS_R2PT] = {{3. / 8, 0, 1. / 8}, {3. / 8, 1. / 8}, 0},
    [STRESS_R3PT] = {{7. / 32, 8. / 32, 1. / 32}, {11. / 32, 5. / 32}, 0},
    [STRESS_T2PT] = {{2. / 6, 0, 1. / 6}, {2. / 6, 1. / 6}, 0},
    [STRESS_T3PT] = {{5. / 24, 6. / 24, 1. / 24}, {5. / 24 + 3. / 24, 1. / 24 + 3. / 24}, 0},
    [STRESS_TPTM] = {{2. / 6, 0, 1. / 6}, {2. / 6, 1. / 6}, 1},
};

void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b)
{
  *a = LanesModels[model].elastic[0];
  *b = LanesModels[model].elastic[1];
}

PetscBool JointIsElastic(const Joint *joint, PetscReal margin, const PetscReal sigma[2],
                         const PetscReal tau[2], const PetscReal broken[2], const PetscReal closure[2])
{
  const PetscInt same[LANES] = {0};
  LanesContact c;
  LanesJoint J;

  LoadJoints(joint, same, margin, &J);
  for (int k = 0; k < 2; k++)
    c.sigma[k] = LanesOf(sigma[k]), c.tau[k] = LanesOf(tau[k]), c.broken[k] = LanesOf(broken[k]),
    c.closure[k] = LanesOf(closure[k]);
  if (broken[0] >= LOOSE) J = LooseJoint(&J, c.broken[0] >= LOOSE);
  return (PetscBool)(IsElastic(&J, 1, &c)[0] != 0);
}

KERNEL void Respond_code(const LanesJoint *J, const LanesModel *model, int in_time, int crushed,
                         LanesContact *c)
{
  if (in_time && J->damps && J->softens)
    RespondContacts(J, model, 1, CLOSES | SOFTENS, 1, c);
  else if (in_time && J->damps)
    RespondContacts(J, model, 1, CLOSES, 1, c);
  else if (J->softens)
    RespondContacts(J, model, in_time, CLOSES | SOFTENS, 0, c);
  else if (crushed || J->crushes)
    RespondContacts(J, model, in_time, CLOSES, 0, c);
  else
    RespondContacts(J, model, in_time, 0, 0, c);
}

VARIANTS(Respond, (const LanesJoint *J, const LanesModel *model, int in_time, int crushed, LanesContact *c),
         (J, model, in_time, crushed, c))

/* Fills the lanes with points. Lanes do not mix, so the answer of each point has the bits of a batch,
   whatever the other lanes contain. */
void StressModelRespondAll(StressModelKind model, const Joint *joint, PetscReal length, int n,
                           ContactPoint *p)
{
  const PetscInt same[LANES] = {0};
  LanesJoint J;
  LanesContact c = {.length = LanesOf(length)};
  int crushed = 0;

  LoadJoints(joint, same, p->margin, &J);
  for (int k = 0; k < 2; k++) {
    for (int i = 0; i < LANES; i++) { // the last point fills the remaining lanes
      const ContactPoint *one = p + PetscMin(i, n - 1);
      c.u_n[k][i] = one->u_n[k], c.u_s[k][i] = one->u_s[k];
    }
    c.slip[k] = LanesOf(p->slip[k]), c.broken[k] = LanesOf(p->broken[k]);
    c.closure[k] = LanesOf(p->closure[k]), c.far[k] = LanesOf(p->closure_far[k]);
    c.dashpot[k] = J.k_n * J.damping * LanesOf(p->speed[k]);
    crushed |= p->closure[k] < 0.;
  }
  Respond(&J, LanesModels + model, p->in_time, crushed, &c);
  for (int i = 0; i < n; i++)
    for (int k = 0; k < 2; k++) {
      p[i].slip[k] = c.slip[k][i], p[i].broken[k] = c.broken[k][i];
      p[i].closure[k] = c.closure[k][i], p[i].closure_far[k] = c.far[k][i];
      p[i].sigma[k] = c.sigma[k][i], p[i].tau[k] = c.tau[k][i];
      p[i].F_n[k] = c.F_n[k][i], p[i].F_s[k] = c.F_s[k][i];
      p[i].state[k] = (PetscInt)c.state[k][i];
    }
}

void StressModelRespond(StressModelKind model, const Joint *joint, PetscReal length, ContactPoint *p)
{
  StressModelRespondAll(model, joint, length, 1, p);
}

static void load_history(const ContactPoint *p, LanesContact *c)
{
  for (int k = 0; k < 2; k++) {
    c->u_n[k] = LanesOf(p->u_n[k]);
    c->closure[k] = LanesOf(p->closure[k]), c->far[k] = LanesOf(p->closure_far[k]);
  }
}

PetscReal StressModelClosure(const ContactPoint *p, int k)
{
  LanesContact c;
  load_history(p, &c);
  return ClosureOfEnd(&c, k)[0];
}

/* A piece of a contact of tptm on which the trial stress is linear. from, to: fractions of the length of the
   contact. sigma: trial stress at the two ends of the piece. */
typedef struct {
  PetscReal from, to, sigma[2];
} Piece;

static void pieces_of(const Joint *joint, const ContactPoint *p, Piece piece[3])
{
  const PetscInt same[LANES] = {0};
  LanesJoint J;
  LanesContact c;
  LoadJoints(joint, same, p->margin, &J);
  load_history(p, &c);
  const Pieces pieces = PiecesOf(&J, &c);
  for (int i = 0; i < 3; i++) {
    piece[i].from = 0.5 * (1. + pieces.cut[i][0]);
    piece[i].to = PetscMax(piece[i].from, 0.5 * (1. + pieces.cut[i + 1][0]));
    for (int k = 0; k < 2; k++) piece[i].sigma[k] = Line(pieces.sigma[i], pieces.cut[i + k])[0];
  }
}

/* Returns the fraction of a line from a to b that is above the limit. */
static PetscReal fraction_above(PetscReal a, PetscReal b, PetscReal limit)
{
  if ((a > limit) == (b > limit)) return (PetscReal)(a > limit);
  return a > limit ? (a - limit) / (a - b) : (b - limit) / (b - a);
}

/* Returns the length, as a fraction of the contact, that is above the limit between two places on a piece. */
static PetscReal length_above(const Piece *piece, PetscReal from, PetscReal to, PetscReal limit)
{
  const PetscReal a = PetscMax(from, piece->from), b = PetscMin(to, piece->to),
                  part = piece->to - piece->from;
  PetscReal s[2];
  if (!(b > a)) return 0.;
  for (int k = 0; k < 2; k++)
    s[k] = piece->sigma[0] + ((k ? b : a) - piece->from) / part * (piece->sigma[1] - piece->sigma[0]);
  return (b - a) * fraction_above(s[0], s[1], limit);
}

/* Finds the parts [-] of the length that are open and that crush. A place is open where its trial stress is
   above the tensile strength: the peak strength between the fronts of failure, the residual strength beyond
   them. A loose contact has no tensile strength. */
void StressModelParts(const Joint *joint, const ContactPoint *p, PetscReal *open, PetscReal *crushing)
{
  const PetscBool loose = (PetscBool)(p->broken[0] >= LOOSE),
                  through = (PetscBool)(p->broken[0] + p->broken[1] >= 1.);
  const PetscReal more = JointBreaks(joint) ? p->margin : 0.;
  const PetscReal front[2] = {through ? 1. : p->broken[0], through ? 1. : 1. - p->broken[1]},
                  peak = loose ? 0. : joint->tension[0] + more, residual = loose ? 0. : joint->tension[1];
  Piece piece[3];
  *open = *crushing = 0.;
  pieces_of(joint, p, piece);
  for (int i = 0; i < 3; i++) {
    *open += length_above(piece + i, 0., front[0], residual) +
             length_above(piece + i, front[0], front[1], peak) +
             length_above(piece + i, front[1], 1., residual);
    *crushing += (piece[i].to - piece[i].from) *
                 fraction_above(-piece[i].sigma[0], -piece[i].sigma[1], (1. - 1e-9) * joint->compression);
  }
}

/* Returns 2 k_n times the energy density of a trial stress s: s^2, and T^2 beyond T. Beyond -C, crushing that
   the closure does not contain comes back, so the energy is the work done. */
static PetscReal twice_stored(PetscReal s, PetscReal C, PetscReal T)
{
  return s < -C ? -C * (2. * s + C) : PetscSqr(PetscMin(T, s));
}

/* Returns the integral of twice_stored from 0 to s. */
static PetscReal twice_stored_to(PetscReal s, PetscReal C, PetscReal T)
{
  const PetscReal in = PetscMax(-C, PetscMin(T, s));
  return in * in * in / 3. + (s < -C ? -C * (s - in) * (s + in + C) : in * in * (s - in));
}

PetscReal StressModelStored(const Joint *joint, PetscReal length, const ContactPoint *p)
{
  const int residual = p->broken[0] > 0. || p->broken[1] > 0.;
  const PetscReal C = joint->compression, T = joint->tension[residual];
  PetscReal sum = 0.;
  Piece piece[3];
  pieces_of(joint, p, piece);
  for (int i = 0; i < 3; i++) {
    const PetscReal a = piece[i].sigma[0], b = piece[i].sigma[1], middle = 0.5 * (a + b);
    const PetscReal mean = PetscAbsReal(b - a) > 1e-6 * (PetscAbsReal(a) + PetscAbsReal(b))
                               ? (twice_stored_to(b, C, T) - twice_stored_to(a, C, T)) / (b - a)
                               : twice_stored(middle, C, T);
    sum += (piece[i].to - piece[i].from) * mean;
  }
  return 0.5 * length * sum / joint->k_n;
}

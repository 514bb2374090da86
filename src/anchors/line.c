/* line.c: computes geometry and force of one anchor. */
#include "anchors/line.h"
#include "anchors/pair.h"

void LinePlace(Line *line, const Model *m, const PetscReal *u)
{
  const Pair d0 = LoadPair(line->reference), du = WeighedSum(LINE_VERTICES, line->vertex, line->weight, u),
             each = d0 * du, square = du * du;
  const PetscReal along = each[0] + each[1];
  if (m->materials.strain == STRAIN_SMALL) {
    line->span = line->length, line->s = along / line->length;
    StorePair(line->e, d0 / line->length);
    return;
  }
  const Pair d = d0 + du, squares = d * d;
  line->span = PetscSqrtReal(squares[0] + squares[1]);
  // |d| - |d0|, without cancellation
  line->s = (2. * along + square[0] + square[1]) / (line->span + line->length);
  StorePair(line->e, d / line->span);
}

PetscReal LineForce(const Line *line, PetscReal s, LineHistory *now)
{
  const LineHistory *committed = &line->committed;
  *now = *committed;
  if (committed->phase != LINE_LOCKED) return 0.;
  const PetscReal T = line->stiffness * (s - committed->natural - committed->plastic), T_y = line->T_y;
  if (T < 0. && !line->of->compression) return 0.;
  if (PetscAbsReal(T) <= T_y) return T;
  const PetscReal yields = (PetscAbsReal(T) - T_y) / line->stiffness;
  now->plastic += T > 0. ? yields : -yields;
  now->lost += T_y * yields;
  return T > 0. ? T_y : -T_y;
}

PetscReal LineLargest(const Line *line)
{
  return line->chain ? ChainTension(line->chain) : line->T;
}

/* Evaluates a bonded bar. The force of the line is the force of the free length, or the largest force if
   there is no free length. */
static void evaluate_chain(Line *line, const PetscReal *u)
{
  Chain *c = line->chain;
  line->now = line->committed;
  c->jack = line->committed.phase == LINE_STRESSED ? line->committed.pulls : -1.;
  if (line->committed.phase == LINE_STRESSED || line->committed.phase == LINE_LOCKED) {
    line->unsolved = (PetscBool)!ChainEvaluate(c, u);
    line->now.plastic = ChainPlastic(c), line->now.lost = ChainLost(c);
  } else {
    ChainPlace(c, u);
  }
  line->s = ChainElongation(c);
  line->T = line->committed.phase != LINE_LOCKED ? 0.
            : line->of->free_length > 0.         ? c->N[0]
                                                 : ChainLargest(c);
}

void LineEvaluate(Line *line, const Model *m, const PetscReal *u)
{
  LinePlace(line, m, u);
  if (line->chain) {
    evaluate_chain(line, u);
    return;
  }
  line->T = LineForce(line, line->s, &line->now);
}

PetscReal LineTangent(const Line *line)
{
  if (line->now.phase != LINE_LOCKED || line->now.plastic != line->committed.plastic) return 0.;
  return line->T == 0. && !line->of->compression && line->s < line->now.natural + line->now.plastic
             ? 0.
             : line->stiffness;
}

/* Decides whether the anchor breaks. largest: [N] its largest tension. */
static PetscBool breaks(const Line *line, PetscReal largest)
{
  const Anchor *of = line->of;
  if (line->now.phase != LINE_LOCKED) return PETSC_FALSE;
  if (line->chain) return (PetscBool)(largest > of->breaking_force);
  const PetscReal strain = (line->now.plastic + line->T / line->stiffness) * line->stiffness /
                           (of->young * of->area);
  return (PetscBool)(line->T > of->breaking_force || strain > of->strain_limit);
}

PetscBool LineBreaks(const Line *line)
{
  return breaks(line, LineLargest(line));
}

void LineCommit(Line *line)
{
  LineHistory *h = &line->now;
  const PetscReal largest = LineLargest(line);
  h->most = PetscMax(h->most, largest);
  if (breaks(line, largest)) {
    h->lost += LineStored(line);
    h->phase = LINE_BROKEN, line->T = 0.;
  }
  LineKeep(line, CHAIN_NOW, CHAIN_COMMITTED);
}

static LineHistory *history_of(Line *line, ChainState when)
{
  return when == CHAIN_COMMITTED ? &line->committed : when == CHAIN_NOW ? &line->now : &line->stable;
}

void LineKeep(Line *line, ChainState from, ChainState to)
{
  *history_of(line, to) = *history_of(line, from);
  if (line->chain) ChainCopy(line->chain, from, to);
}

void LineResist(const Line *line, PetscReal times, PetscReal *f)
{
  if (line->chain)
    ChainPull(line->chain, line->per_slice * times, f);
  else if (line->T != 0.)
    LinePull(line, times * line->T, f);
}

void LinePull(const Line *line, PetscReal T, PetscReal *f)
{
  const PetscReal pull = line->per_slice * T;
  AddWeighed(LINE_VERTICES, line->vertex, line->weight, pull * LoadPair(line->e), f);
}

PetscReal LineStored(const Line *line)
{
  if (line->chain) return ChainStored(line->chain);
  return line->now.phase == LINE_LOCKED ? 0.5 * line->T * line->T / line->stiffness : 0.;
}

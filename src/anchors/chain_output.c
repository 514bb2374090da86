/* chain_output.c: writes the results of a bonded bar: along it, and of its dowels. */
#include "anchors/chain.h"

/* Views of the results in Chain.report. */
typedef struct {
  PetscReal *N, *plastic;              /* (n - 1,) forces and plastic elongations of pieces */
  PetscReal *b, *slip, *slid;          /* (n,) bond forces, slips, plastic slips */
  PetscReal *V, *sheared, *dowel_slip; /* (n_dowels,) forces, plastic slips, slips */
  PetscReal *lost;                     /* (CHAIN_LOSSES,) dissipated energies */
} BarReport;

static PetscInt size_of(const Chain *c)
{
  return 2 * (c->n - 1) + 3 * c->n + 3 * c->n_dowels + CHAIN_LOSSES;
}

static BarReport report_of(const Chain *c)
{
  BarReport t;
  PetscReal *x = c->report;
  t.N = x, t.plastic = x += c->n - 1;
  t.b = x += c->n - 1, t.slip = x += c->n, t.slid = x += c->n;
  t.V = x += c->n, t.sheared = x += c->n_dowels, t.dowel_slip = x += c->n_dowels, t.lost = x + c->n_dowels;
  return t;
}

PetscErrorCode ChainGather(MPI_Comm comm, PetscBool mine, Chain *c)
{
  const ChainMemory *now = &c->memory[CHAIN_NOW];
  PetscFunctionBeginUser;
  if (!c->report) PetscCall(PetscMalloc1(size_of(c), &c->report));
  PetscCall(PetscArrayzero(c->report, size_of(c)));
  const BarReport t = report_of(c);
  if (mine) {
    PetscCall(PetscArraycpy(t.N, c->N, c->n - 1));
    PetscCall(PetscArraycpy(t.plastic, now->plastic, c->n - 1));
    PetscCall(PetscArraycpy(t.b, c->b, c->n));
    PetscCall(PetscArraycpy(t.slip, now->slip, c->n));
    PetscCall(PetscArraycpy(t.slid, now->slid, c->n));
    PetscCall(PetscArraycpy(t.sheared, now->sheared, c->n_dowels));
    PetscCall(PetscArraycpy(t.lost, now->lost, CHAIN_LOSSES));
    for (PetscInt i = 0; i < c->n_dowels; i++) {
      t.V[i] = c->dowel[i].V;
      t.dowel_slip[i] = c->dowel[i].V / c->dowel[i].K + now->sheared[i];
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->report, (PetscMPIInt)size_of(c), MPIU_REAL, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns by how much [m] one end of long bonded steel is pulled out of its grout by T: the bond slips
   near the end and is elastic behind. */
static PetscReal pull_out(const Chain *c, const Anchor *of, PetscReal T)
{
  const PetscReal lambda = PetscSqrtReal(of->bond_stiffness / c->EA),
                  slips = of->bond_strength / of->bond_stiffness, T_slips = c->EA * lambda * slips;
  if (T <= T_slips) return T / (c->EA * lambda);
  const PetscReal length = (T - T_slips) / of->bond_strength;
  return slips + (T_slips + 0.5 * of->bond_strength * length) * length / c->EA;
}

PetscReal ChainReserve(const Chain *c, const Anchor *of, PetscReal T, PetscReal most)
{
  const PetscReal sides = c->head ? 1. : 2., force = PetscClipInterval(T, 0., most);
  return sides * (pull_out(c, of, most) - pull_out(c, of, force)) + (most - force) * of->free_length / c->EA;
}

PetscReal ChainStiffness(const Chain *c, const Anchor *of)
{
  const PetscReal lambda = PetscSqrtReal(of->bond_stiffness / c->EA);
  return c->EA / ((c->head ? 1. : 2.) / lambda + of->free_length);
}

/* ---- the summary */

static void dowel_summary(Json *json, const Chain *c, const Anchor *of, const BarReport *t, PetscInt i)
{
  const Dowel *d = c->dowel + i;
  const PetscReal length = AnchorLength(of),
                  at = 0.5 * (c->from[d->piece] + 0.5 * c->bonded[d->piece] + c->from[d->piece + 1] -
                              0.5 * c->bonded[d->piece + 1]);
  JsonOpen(json, NULL);
  JsonNumber(json, "from_head", at);
  JsonList(json, "place");
  for (int x = 0; x < 2; x++) JsonNumber(json, NULL, of->head[x] + at / length * (of->root[x] - of->head[x]));
  JsonClose(json);
  JsonNumbers(json, {"force", t->V[i]}, {"slip", t->dowel_slip[i]}, {"plastic", t->sheared[i]},
              {"stiffness", d->K}, {"use", PetscHypotReal(t->N[d->piece] / c->T_y, t->V[i] / d->V_y)});
  JsonClose(json);
}

void ChainSummary(Json *json, const Chain *c, const Anchor *of)
{
  const BarReport t = report_of(c);
  PetscReal use = 0., slip = 0., slipped = 0., yielded = 0.;
  for (PetscInt i = c->head; i < c->n; i++) {
    use = PetscMax(use, PetscAbsReal(t.b[i]) / c->B[i]);
    slip = PetscMax(slip, PetscAbsReal(t.slip[i]));
    if (t.slid[i] != 0.) slipped += c->bonded[i];
  }
  for (PetscInt j = 0; j + 1 < c->n; j++)
    if (t.plastic[j] != 0.) yielded += c->length[j];
  JsonNumbers(json, {"bond_use", use}, {"slip", slip}, {"slipped_length", slipped},
              {"yielded_length", yielded}, {"lost_yield", t.lost[LOST_IN_YIELD]},
              {"lost_bond", t.lost[LOST_IN_BOND]});
  if (!c->n_dowels) return;
  JsonNumber(json, "lost_dowel", t.lost[LOST_IN_DOWELS]);
  JsonList(json, "dowels");
  for (PetscInt i = 0; i < c->n_dowels; i++) dowel_summary(json, c, of, &t, i);
  JsonClose(json);
}

/* ---- the table */

PetscInt ChainRows(const Chain *c)
{
  return c->n + 1;
}

/* Writes a row: of the near end of the bonded length of a place, or of the head; the last row of the far
   end of the bar. x: distance from the head, place (2), force; bond force over length and over strength,
   slip, plastic slip, plastic elongation of the piece before. */
void ChainRow(const Chain *c, const Anchor *of, PetscInt row, PetscReal *x)
{
  const BarReport t = report_of(c);
  const PetscBool last = (PetscBool)(row == c->n);
  const PetscReal at = last ? c->from[row - 1] + 0.5 * c->bonded[row - 1]
                            : c->from[row] - 0.5 * c->bonded[row],
                  part = at / AnchorLength(of);
  memset(x, 0, BAR_NUMBERS * sizeof *x);
  x[0] = at;
  for (int i = 0; i < 2; i++) x[1 + i] = of->head[i] + part * (of->root[i] - of->head[i]);
  if (row) x[8] = last ? 0. : t.plastic[row - 1];
  if (c->head && !row) x[3] = t.N[0];
  if (last || (c->head && !row)) return;
  x[3] = row ? t.N[row - 1] : 0.;
  x[4] = t.b[row] / c->bonded[row], x[5] = PetscAbsReal(t.b[row]) / c->B[row];
  x[6] = t.slip[row], x[7] = t.slid[row];
}

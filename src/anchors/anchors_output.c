/* anchors_output.c: writes the results of anchors: members of the summary, and tables in results.h5. */
#include "anchors/line.h"

typedef enum {
  STATE_ABSENT,
  STATE_STRESSED,
  STATE_SLACK,
  STATE_ELASTIC,
  STATE_YIELDED,
  STATE_BROKEN,
  STATE_SLIPPED
} AnchorState;
static const char *const AnchorStates[] = {"absent",  "stressed", "slack",  "elastic",
                                           "yielded", "broken",   "slipped"};

/* Results of an anchor. */
typedef struct {
  AnchorState state;
  PetscReal force, elongation; /* [N] force of one anchor, [m] elongation since it was without force */
  PetscReal reserve;           /* [m] further elongation until it yields or breaks */
  PetscReal stored;            /* [J] stored energy */
} AnchorReport;

static AnchorState state_of(const Line *line, const PetscReal *x)
{
  switch ((LinePhase)x[LINE_PHASE]) {
  case LINE_ABSENT:
    return STATE_ABSENT;
  case LINE_STRESSED:
    return STATE_STRESSED;
  case LINE_BROKEN:
    return STATE_BROKEN;
  case LINE_LOCKED:
    break;
  }
  const PetscBool tendon = line->chain ? line->chain->slack : !line->of->compression;
  if (tendon && x[LINE_S] < x[LINE_NATURAL] + (line->chain ? 0. : x[LINE_PLASTIC])) return STATE_SLACK;
  if (x[LINE_PLASTIC] != 0.) return STATE_YIELDED;
  return line->chain && x[LINE_LOST] > 0. ? STATE_SLIPPED : STATE_ELASTIC;
}

static PetscBool breaks_or_yields(const Anchor *of)
{
  return (PetscBool)(of->yield < PETSC_INFINITY || of->breaking_force < PETSC_INFINITY ||
                     of->strain_limit < PETSC_INFINITY);
}

static AnchorReport report_of(const Line *line, const PetscReal *x)
{
  const Anchor *of = line->of;
  const PetscReal most = PetscMin(PetscMin(line->T_y, of->breaking_force),
                                  of->strain_limit * of->young * of->area);
  AnchorReport t = {.state = state_of(line, x), .force = x[LINE_T]};
  if (t.state == STATE_STRESSED) t.force = x[LINE_PULLS];
  if (t.state == STATE_STRESSED) t.elongation = t.force / line->stiffness;
  if (t.state >= STATE_SLACK && t.state != STATE_BROKEN) {
    t.elongation = x[LINE_S] - x[LINE_NATURAL];
    t.reserve = line->chain ? ChainReserve(line->chain, of, t.force, most)
                            : most / line->stiffness - (t.elongation - x[LINE_PLASTIC]);
    t.stored = x[LINE_STORED];
  }
  return t;
}

PetscErrorCode AnchorsBeforeSummary(const TermView *v, PetscBool report)
{
  PetscFunctionBeginUser;
  (void)report;
  if (v->memory) PetscCall(AnchorsGather(v->m->comm, v->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the members of the summary. Forces, works and energies are per anchor; the force per metre is
   beside the force. */
void AnchorsSummary(Json *json, const TermView *v)
{
  const Anchors *all = v->memory;
  if (!all || !all->report) return;
  JsonOpen(json, "anchors");
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->report + i * LINE_NUMBERS;
    const AnchorReport t = report_of(line, x);
    JsonOpen(json, line->of->entry.name);
    JsonText(json, "state", AnchorStates[t.state]);
    JsonNumbers(json, {"force", t.force}, {"force_per_metre", t.force / line->of->spacing},
                {"largest", PetscMax(x[LINE_MOST], t.force)}, {"elongation", t.elongation},
                {"plastic", x[LINE_PLASTIC]});
    if (breaks_or_yields(line->of)) JsonNumber(json, "reserve", t.reserve);
    if (line->chain) ChainSummary(json, line->chain, line->of);
    JsonNumbers(json, {"stiffness", line->chain ? ChainStiffness(line->chain, line->of) : line->stiffness},
                {"stored", t.stored}, {"lost", x[LINE_LOST]}, {"work", x[LINE_JACK]});
    JsonClose(json);
  }
  JsonClose(json);
}

/* ---- histories over the cycles */

static const char *const Checked[] = {"force_N", "largest_so_far_N", "elongation_m", "plastic_m", "lost_J"};
enum { CHECKED = sizeof Checked / sizeof *Checked };

PetscErrorCode AnchorsRecord(const TermView *v, AnchorRecord *record)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AnchorsGather(v->m->comm, all));
  if (!all->name) PetscCall(PetscMalloc1(all->n, &all->name));
  if (!all->checked) PetscCall(PetscMalloc1(all->n * CHECKED, &all->checked));
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->report + i * LINE_NUMBERS;
    const AnchorReport t = report_of(line, x);
    const PetscReal row[CHECKED] = {t.state == STATE_ABSENT ? NAN : t.force, PetscMax(x[LINE_MOST], t.force),
                                    t.elongation, x[LINE_PLASTIC], x[LINE_LOST]};
    all->name[i] = line->of->entry.name;
    PetscCall(PetscArraycpy(all->checked + i * CHECKED, row, CHECKED));
  }
  *record = (AnchorRecord){all->n, CHECKED, all->name, Checked, all->checked};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void put_row(TermTable *table, PetscInt row, const PetscReal *x)
{
  for (PetscInt c = 0; c < table->n_columns; c++)
    for (PetscInt k = 0; k < table->columns[c].width; k++)
      table->columns[c].values[row * table->columns[c].width + k] = *x++;
}

static PetscErrorCode anchors_table(const Anchors *all, TermTable *table)
{
  static const TermColumn columns[] = {{"head", 2, NULL},    {"root", 2, NULL},  {"spacing", 1, NULL},
                                       {"force", 1, NULL},   {"state", 1, NULL}, {"elongation", 1, NULL},
                                       {"plastic", 1, NULL}, {"lost", 1, NULL}};
  PetscFunctionBeginUser;
  PetscCall(TermTableCreate("anchors", all->n, sizeof columns / sizeof *columns, columns, table));
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->report + i * LINE_NUMBERS;
    const AnchorReport t = report_of(line, x);
    const PetscReal row[] = {line->of->head[0], line->of->head[1], line->of->root[0],  line->of->root[1],
                             line->of->spacing, t.force,           (PetscReal)t.state, t.elongation,
                             x[LINE_PLASTIC],   x[LINE_LOST]};
    put_row(table, i, row);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the table of all bonded bars, one after the other. */
static PetscErrorCode bars_table(const Anchors *all, TermTable *table)
{
  static const TermColumn columns[] = {{"anchor", 1, NULL}, {"from_head", 1, NULL}, {"place", 2, NULL},
                                       {"force", 1, NULL},  {"bond", 1, NULL},      {"bond_use", 1, NULL},
                                       {"slip", 2, NULL},   {"plastic", 1, NULL}};
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < all->n; i++) n += all->line[i].chain ? ChainRows(all->line[i].chain) : 0;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TermTableCreate("bars", n, sizeof columns / sizeof *columns, columns, table));
  n = 0;
  for (PetscInt i = 0; i < all->n; i++)
    for (PetscInt row = 0; all->line[i].chain && row < ChainRows(all->line[i].chain); row++) {
      PetscReal x[1 + BAR_NUMBERS] = {(PetscReal)i};
      ChainRow(all->line[i].chain, all->line[i].of, row, x + 1);
      put_row(table, n++, x);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsTable(const TermView *v, PetscInt which, TermTable *table)
{
  const Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all || !all->report) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(which ? bars_table(all, table) : anchors_table(all, table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

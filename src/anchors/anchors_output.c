/* anchors_output.c: what is told of anchors: members of the summary, a table in results.h5. */
#include "anchors/line.h"

typedef enum {
  TOLD_ABSENT,
  TOLD_STRESSED,
  TOLD_SLACK,
  TOLD_ELASTIC,
  TOLD_YIELDED,
  TOLD_BROKEN,
  TOLD_SLIPPED
} ToldState;
static const char *const ToldStates[] = {"absent",  "stressed", "slack",  "elastic",
                                         "yielded", "broken",   "slipped"};

/* An anchor as it is told. */
typedef struct {
  ToldState state;
  PetscReal force, elongation; /* [N] of one anchor, [m] since it was without force */
  PetscReal reserve;           /* [m] by which it may stretch until it yields or breaks */
  PetscReal stored;            /* [J] */
} Told;

static ToldState state_of(const Line *line, const PetscReal *x)
{
  switch ((LinePhase)x[LINE_PHASE]) {
  case LINE_ABSENT:
    return TOLD_ABSENT;
  case LINE_STRESSED:
    return TOLD_STRESSED;
  case LINE_BROKEN:
    return TOLD_BROKEN;
  case LINE_HELD:
    break;
  }
  const PetscBool tendon = line->chain ? line->chain->slack : !line->of->compression;
  if (tendon && x[LINE_S] < x[LINE_NATURAL] + (line->chain ? 0. : x[LINE_PLASTIC])) return TOLD_SLACK;
  if (x[LINE_PLASTIC] != 0.) return TOLD_YIELDED;
  return line->chain && x[LINE_LOST] > 0. ? TOLD_SLIPPED : TOLD_ELASTIC;
}

static PetscBool breaks_or_yields(const Anchor *of)
{
  return (PetscBool)(of->yield < PETSC_INFINITY || of->breaking_force < PETSC_INFINITY ||
                     of->strain_limit < PETSC_INFINITY);
}

static Told tell(const Line *line, const PetscReal *x)
{
  const Anchor *of = line->of;
  const PetscReal most = PetscMin(PetscMin(line->T_y, of->breaking_force),
                                  of->strain_limit * of->young * of->area);
  Told t = {.state = state_of(line, x), .force = x[LINE_T]};
  if (t.state == TOLD_STRESSED) t.force = x[LINE_PULLS];
  if (t.state == TOLD_STRESSED) t.elongation = t.force / line->stiffness;
  if (t.state >= TOLD_SLACK && t.state != TOLD_BROKEN) {
    t.elongation = x[LINE_S] - x[LINE_NATURAL];
    t.reserve = line->chain ? ChainReserve(line->chain, of, t.force, most)
                            : most / line->stiffness - (t.elongation - x[LINE_PLASTIC]);
    t.stored = x[LINE_STORED];
  }
  return t;
}

PetscErrorCode AnchorsSurvey(const TermView *v, PetscBool tell_it)
{
  PetscFunctionBeginUser;
  (void)tell_it;
  if (v->memory) PetscCall(AnchorsGather(v->m->comm, v->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forces, works and energies are those of one anchor; per metre stands beside the force. */
void AnchorsSummary(FILE *f, const TermView *v)
{
  const Anchors *all = v->memory;
  if (!all || !all->told) return;
  fprintf(f, "      \"anchors\": {\n");
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->told + i * LINE_NUMBERS;
    const Told t = tell(line, x);
    fprintf(f, "        \"%s\": {", line->of->entry.name);
    JsonText(f, "state", ToldStates[t.state], ", ");
    JsonNumber(f, "force", t.force, ", ");
    JsonNumber(f, "force_per_metre", t.force / line->of->spacing, ", ");
    JsonNumber(f, "largest", PetscMax(x[LINE_MOST], t.force), ", ");
    JsonNumber(f, "elongation", t.elongation, ", ");
    JsonNumber(f, "plastic", x[LINE_PLASTIC], ", ");
    if (breaks_or_yields(line->of)) JsonNumber(f, "reserve", t.reserve, ", ");
    if (line->chain) ChainSummary(f, line->chain, line->of);
    JsonNumber(f, "stiffness", line->chain ? ChainStiffness(line->chain, line->of) : line->stiffness, ", ");
    JsonNumber(f, "stored", t.stored, ", ");
    JsonNumber(f, "lost", x[LINE_LOST], ", ");
    JsonNumber(f, "work", x[LINE_JACK], "}");
    fprintf(f, "%s", i + 1 < all->n ? ",\n" : "\n      },\n");
  }
}

/* ---- as time goes on */

static const char *const Seen[] = {"force_N", "largest_so_far_N", "elongation_m", "plastic_m", "lost_J"};
enum { SEEN = sizeof Seen / sizeof *Seen };

PetscErrorCode AnchorsRecord(const TermView *v, TermRecord *look)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AnchorsGather(v->m->comm, all));
  if (!all->name) PetscCall(PetscMalloc1(all->n, &all->name));
  if (!all->seen) PetscCall(PetscMalloc1(all->n * SEEN, &all->seen));
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->told + i * LINE_NUMBERS;
    const Told t = tell(line, x);
    const PetscReal row[SEEN] = {t.state == TOLD_ABSENT ? NAN : t.force, PetscMax(x[LINE_MOST], t.force),
                                 t.elongation, x[LINE_PLASTIC], x[LINE_LOST]};
    all->name[i] = line->of->entry.name;
    PetscCall(PetscArraycpy(all->seen + i * SEEN, row, SEEN));
  }
  *look = (TermRecord){all->n, SEEN, all->name, Seen, all->seen};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Room for rows of columns of these widths. */
typedef struct {
  const char *name;
  PetscInt width;
} Column;

static PetscErrorCode open_table(const char *name, PetscInt n_rows, PetscInt n_columns, const Column *columns,
                                 TermTable *table)
{
  PetscFunctionBeginUser;
  table->name = name, table->n_rows = n_rows, table->n_columns = n_columns;
  for (PetscInt c = 0; c < n_columns; c++) {
    table->columns[c] = (TermColumn){.name = columns[c].name, .width = columns[c].width};
    PetscCall(PetscMalloc1(n_rows * columns[c].width, &table->columns[c].values));
  }
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
  static const Column columns[] = {{"head", 2},  {"root", 2},       {"spacing", 1}, {"force", 1},
                                   {"state", 1}, {"elongation", 1}, {"plastic", 1}, {"lost", 1}};
  PetscFunctionBeginUser;
  PetscCall(open_table("anchors", all->n, sizeof columns / sizeof *columns, columns, table));
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->told + i * LINE_NUMBERS;
    const Told t = tell(line, x);
    const PetscReal row[] = {line->of->head[0], line->of->head[1], line->of->root[0],  line->of->root[1],
                             line->of->spacing, t.force,           (PetscReal)t.state, t.elongation,
                             x[LINE_PLASTIC],   x[LINE_LOST]};
    put_row(table, i, row);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Along all bonded bars, one after the other. */
static PetscErrorCode bars_table(const Anchors *all, TermTable *table)
{
  static const Column columns[] = {{"anchor", 1}, {"from_head", 1}, {"place", 2}, {"force", 1},
                                   {"bond", 1},   {"bond_use", 1},  {"slip", 2},  {"plastic", 1}};
  PetscInt n = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < all->n; i++) n += all->line[i].chain ? ChainRows(all->line[i].chain) : 0;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(open_table("bars", n, sizeof columns / sizeof *columns, columns, table));
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
  if (!all || !all->told) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(which ? bars_table(all, table) : anchors_table(all, table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

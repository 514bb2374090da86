/* anchors_output.c: what is told of anchors: members of the summary, a table in results.h5. */
#include "forces/anchors/line.h"

typedef enum { TOLD_ABSENT, TOLD_STRESSED, TOLD_SLACK, TOLD_ELASTIC, TOLD_YIELDED, TOLD_BROKEN } ToldState;
static const char *const ToldStates[] = {"absent", "stressed", "slack", "elastic", "yielded", "broken"};

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
  if (x[LINE_S] < x[LINE_NATURAL] + x[LINE_PLASTIC] && !line->of->compression) return TOLD_SLACK;
  return x[LINE_PLASTIC] != 0. ? TOLD_YIELDED : TOLD_ELASTIC;
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
  if (t.state == TOLD_STRESSED) t.force = of->prestress[(PetscInt)x[LINE_STRESSINGS] - 1];
  if (t.state == TOLD_STRESSED) t.elongation = t.force / line->stiffness;
  if (t.state >= TOLD_SLACK && t.state <= TOLD_YIELDED) {
    t.elongation = x[LINE_S] - x[LINE_NATURAL];
    t.reserve = most / line->stiffness - (t.elongation - x[LINE_PLASTIC]);
    t.stored = 0.5 * t.force * t.force / line->stiffness;
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
    JsonNumber(f, "stiffness", line->stiffness, ", ");
    JsonNumber(f, "stored", t.stored, ", ");
    JsonNumber(f, "lost", x[LINE_LOST], ", ");
    JsonNumber(f, "work", x[LINE_JACK], "}");
    fprintf(f, "%s", i + 1 < all->n ? ",\n" : "\n      },\n");
  }
}

PetscErrorCode AnchorsTable(const TermView *v, TermTable *table)
{
  static const struct {
    const char *name;
    PetscInt width;
  } columns[TERM_COLUMNS] = {{"head", 2},  {"root", 2},       {"spacing", 1}, {"force", 1},
                             {"state", 1}, {"elongation", 1}, {"plastic", 1}, {"lost", 1}};
  const Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all || !all->told) PetscFunctionReturn(PETSC_SUCCESS);
  table->n_rows = all->n, table->n_columns = TERM_COLUMNS;
  for (int c = 0; c < TERM_COLUMNS; c++) {
    table->columns[c] = (TermColumn){.name = columns[c].name, .width = columns[c].width};
    PetscCall(PetscMalloc1(all->n * columns[c].width, &table->columns[c].values));
  }
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    const PetscReal *x = all->told + i * LINE_NUMBERS;
    const Told t = tell(line, x);
    const PetscReal row[] = {line->of->head[0], line->of->head[1], line->of->root[0],  line->of->root[1],
                             line->of->spacing, t.force,           (PetscReal)t.state, t.elongation,
                             x[LINE_PLASTIC],   x[LINE_LOST]};
    for (int c = 0, at = 0; c < TERM_COLUMNS; c++)
      for (PetscInt k = 0; k < columns[c].width; k++)
        table->columns[c].values[i * columns[c].width + k] = row[at++];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

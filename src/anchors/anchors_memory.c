/* anchors_memory.c: gathers the state of anchors on all ranks, for archives, summaries and results. */
#include "anchors/line.h"

/* Writes history and last evaluation of an anchor to a row of numbers. */
static void to_numbers(const Line *line, const LineHistory *h, PetscReal *x)
{
  x[LINE_PHASE] = h->phase;
  x[LINE_NATURAL] = h->natural, x[LINE_PLASTIC] = h->plastic, x[LINE_LOST] = h->lost;
  x[LINE_JACK] = h->jack, x[LINE_SINCE] = h->since, x[LINE_MOST] = h->most;
  x[LINE_PULLS] = h->pulls, x[LINE_STORED] = LineStored(line);
  x[LINE_S] = line->s, x[LINE_T] = line->T;
}

static void from_numbers(const PetscReal *x, LineHistory *h)
{
  h->phase = (LinePhase)x[LINE_PHASE];
  h->natural = x[LINE_NATURAL], h->plastic = x[LINE_PLASTIC], h->lost = x[LINE_LOST];
  h->jack = x[LINE_JACK], h->since = x[LINE_SINCE], h->most = x[LINE_MOST];
  h->pulls = x[LINE_PULLS];
}

/* Collective. Gathers one history of all anchors: the owner writes its numbers, other ranks add 0. */
static PetscErrorCode gather(MPI_Comm comm, const Anchors *all, size_t history, PetscReal *x)
{
  const PetscInt n = all->n * LINE_NUMBERS;
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(x, n));
  for (PetscInt i = 0; i < all->n; i++) {
    const Line *line = all->line + i;
    if (line->mine)
      to_numbers(line, (const LineHistory *)((const char *)line + history), x + i * LINE_NUMBERS);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, x, (PetscMPIInt)n, MPIU_REAL, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsGather(MPI_Comm comm, Anchors *all)
{
  PetscFunctionBeginUser;
  if (!all->report) PetscCall(PetscMalloc1(all->n * LINE_NUMBERS, &all->report));
  PetscCall(gather(comm, all, offsetof(Line, now), all->report));
  for (PetscInt i = 0; i < all->n; i++)
    if (all->line[i].chain) PetscCall(ChainGather(comm, all->line[i].mine, all->line[i].chain));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsPrestressed(const TermView *v, PetscReal *sum)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AnchorsGather(v->m->comm, all));
  for (PetscInt i = 0; i < all->n; i++) {
    const PetscReal *x = all->report + i * LINE_NUMBERS;
    *sum += all->line[i].per_slice * x[LINE_STORED];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads one history of a bonded bar. */
static PetscErrorCode archive_chain(Archive *a, Line *line, const char *name, ChainState when)
{
  Chain *c = line->chain;
  char label[2 * LABEL_LENGTH];
  PetscFunctionBeginUser;
  snprintf(label, sizeof label, "%s_%s", name, line->of->entry.name);
  if (!a->reading) {
    PetscReal *x;
    PetscCall(PetscCalloc1(c->n_numbers, &x));
    if (line->mine) PetscCall(PetscArraycpy(x, c->numbers[when], c->n_numbers));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, x, (PetscMPIInt)c->n_numbers, MPIU_REAL, MPI_SUM, a->comm));
    PetscCall(PetscArraycpy(c->numbers[when], x, c->n_numbers));
    PetscCall(PetscFree(x));
  }
  PetscCall(ArchiveReals(a, label, c->n_numbers, c->numbers[when]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads one history of all anchors. */
static PetscErrorCode archive_histories(Archive *a, Anchors *all, const char *name, ChainState when)
{
  static const size_t histories[CHAIN_STATES] = {offsetof(Line, committed), offsetof(Line, now),
                                                 offsetof(Line, stable)};
  const size_t history = histories[when];
  PetscReal *x;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(all->n * LINE_NUMBERS, &x));
  if (!a->reading) PetscCall(gather(a->comm, all, history, x));
  PetscCall(ArchiveReals(a, name, all->n * LINE_NUMBERS, x));
  for (PetscInt i = 0; i < all->n && a->reading; i++) {
    Line *line = all->line + i;
    from_numbers(x + i * LINE_NUMBERS, (LineHistory *)((char *)line + history));
    line->s = x[i * LINE_NUMBERS + LINE_S], line->T = x[i * LINE_NUMBERS + LINE_T];
  }
  PetscCall(PetscFree(x));
  for (PetscInt i = 0; i < all->n; i++)
    if (all->line[i].chain) PetscCall(archive_chain(a, all->line + i, name, when));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsArchive(Archive *a, const TermView *v)
{
  Anchors *all = v->memory;
  PetscFunctionBeginUser;
  if (!all) PetscFunctionReturn(PETSC_SUCCESS);
  PetscInt in_time = all->in_time;
  PetscCall(ArchiveInts(a, "anchors_in_time", 1, &in_time));
  all->in_time = (PetscBool)in_time;
  PetscCall(archive_histories(a, all, "anchors_held", CHAIN_COMMITTED));
  PetscCall(archive_histories(a, all, "anchors_now", CHAIN_NOW));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode AnchorsArchiveStable(Archive *a, const TermView *v)
{
  PetscFunctionBeginUser;
  if (v->memory) PetscCall(archive_histories(a, v->memory, "anchors_stable", CHAIN_STABLE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* terminal.c: prints what a user sees while a stage runs, and at its end. */
#include "output/output.h"
#include <unistd.h>

enum { SHOWN = 79 }; /* columns of a line of progress on a terminal */

/* Decides whether a person watches: output goes to a terminal, and so does the output of the parent process.
   The parent matters because mpirun puts a terminal of its own between its ranks and its output. All lines go
   to PETSC_STDOUT, because samples redirect it: their rows are the output. */
static PetscBool on_terminal(void)
{
  char link[64], target[PETSC_MAX_PATH_LEN];
  ssize_t n;
  if (!isatty(fileno(PETSC_STDOUT))) return PETSC_FALSE;
  snprintf(link, sizeof(link), "/proc/%d/fd/1", (int)getppid());
  n = readlink(link, target, sizeof(target) - 1);
  if (n < 0) return PETSC_TRUE;
  target[n] = 0;
  return (PetscBool)(!strncmp(target, "/dev/pts/", 9) || !strncmp(target, "/dev/tty", 8));
}

PetscBool StageShows(const Problem *p)
{
  static const double EVERY = 10., EVERY_ON_TERMINAL = 0.5; /* [s] */
  static double last = -1.;
  if (p->m->rank) return PETSC_FALSE;
  if (last < 0.) last = MPI_Wtime(); // the first line comes one interval after the start
  if (MPI_Wtime() - last < (on_terminal() ? EVERY_ON_TERMINAL : EVERY)) return PETSC_FALSE;
  last = MPI_Wtime();
  return PETSC_TRUE;
}

void StageShow(const Problem *p, const char *what)
{
  // A line wider than the terminal would go on in the next row, and the next line would not overwrite it. The
  // cursor goes back, because warnings may come next.
  const int rest = SHOWN - 1 - PetscMax(12, (int)strlen(p->stage->name));
  if (on_terminal())
    fprintf(PETSC_STDOUT, "\r%-12s %-*.*s\r", p->stage->name, rest, rest, what);
  else
    fprintf(PETSC_STDOUT, "  %s: %s\n", p->stage->name, what);
  fflush(PETSC_STDOUT);
}

void StageShowEnd(const Problem *p)
{
  if (p->m->rank || !on_terminal()) return;
  fprintf(PETSC_STDOUT, "\r%*s\r", SHOWN, "");
  fflush(PETSC_STDOUT);
}

void StageShowTime(const Problem *p, PetscReal part)
{
  const StageResult *now = p->result;
  char text[128], left[64] = "";
  if (!StageShows(p)) return;
  const double speed = now->wall > 0. ? (double)now->cycles / now->wall : 0.;
  const long seconds = part > 0. ? lrint(now->wall * (double)((1. - part) / part)) : 0;
  if (seconds >= 60)
    snprintf(left, sizeof(left), ", %ld min %ld s left", seconds / 60, seconds % 60);
  else if (speed > 0.)
    snprintf(left, sizeof(left), ", %ld s left", seconds);
  snprintf(text, sizeof(text), "%5.1f %%  %.4g of %.4g s, %.3g steps/s%s", 100. * (double)part,
           (double)(part * p->stage->duration), (double)p->stage->duration, speed, left);
  StageShow(p, text);
}

PetscErrorCode StageReport(const Problem *p)
{
  const MPI_Comm comm = p->m->comm;
  const StageResult *r = p->result;
  PetscFunctionBeginUser;
  StageShowEnd(p);
  PetscCall(PetscPrintf(comm, "stage %-12s %s after %" PetscInt64_FMT " cycle%s, %.2f s: %s\n",
                        p->stage->name, VerdictNames[r->verdict], r->cycles, Plural(r->cycles), r->wall,
                        r->evidence));
  if (r->effort.preconditioned)
    PetscCall(PetscPrintf(
        comm,
        "  %s%s: %" PetscInt64_FMT " force evaluations, %" PetscInt64_FMT " solves, %" PetscInt64_FMT
        " factorisation%s\n",
        EffortMethod(&r->effort), p->scene->method == METHOD_AUTO ? " (auto: large, all joints elastic)" : "",
        r->effort.evaluations, r->effort.solves, r->effort.factorisations, Plural(r->effort.factorisations)));
  if (p->stage->kind == STAGE_MODES) VibrationReport(p);
  PetscCall(TimerReport(comm, r->cycles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* ---- end of a stage */

enum { MOST_SHOWN = 12 }; /* largest number of modes on the terminal */

/* Prints the state to which the modes belong, and the effects that they leave out. */
static void report_state(const Problem *p)
{
  const Vibration *v = &p->found->vibration;
  const Stage *before = StageBefore(p->scene, p->scene->stages + p->number);
  PetscBool lets_go = PETSC_FALSE;
  for (PetscInt i = 0; i < p->scene->n_supports; i++)
    lets_go = (PetscBool)(lets_go || p->scene->supports[i].boundary != BOUNDARY_FIXED);
  printf("  about %s%s: %" PetscInt_FMT " of %" PetscInt_FMT " contacts open in part or whole stay so",
         before ? "the end of stage " : "the undeformed state", before ? before->name : "", v->contacts[1],
         v->contacts[0]);
  if (v->contacts[2]) printf(", %" PetscInt_FMT " that slip stick", v->contacts[2]);
  printf("; water in joints is drained%s\n", lets_go ? "; boundaries that let waves out are held" : "");
}

static void report_modes(const Problem *p)
{
  const Vibration *v = &p->found->vibration;
  if (p->m->rank) return;
  printf("  %4s %11s %11s %14s %14s%s\n", "mode", "f [Hz]", "period [s]", "mass x [%]", "mass y [%]",
         v->reduced ? "  too high by [%]" : "");
  for (PetscInt i = 0; i < PetscMin(v->n, MOST_SHOWN); i++) {
    const PetscReal f = VibrationHertz(v, i);
    char period[32] = "-";
    if (f > 0.) snprintf(period, sizeof(period), "%.5g", (double)(1. / f));
    printf("  %4d %11.5g %11s %14.2f %14.2f", (int)i + 1, (double)f, period,
           100. * (double)VibrationPart(v, i, 0), 100. * (double)VibrationPart(v, i, 1));
    if (v->reduced && PetscIsNanReal(v->error[i]))
      printf(" %16s", "not known");
    else if (v->reduced)
      printf(" %16.2g", 100. * (double)v->error[i]);
    printf("\n");
  }
  if (v->n > MOST_SHOWN) printf("  %4s and %d more in summary.json\n", "", (int)(v->n - MOST_SHOWN));
  printf("  %4s %11s %11s %14.2f %14.2f\n", "all", "", "", 100. * (double)VibrationPart(v, -1, 0),
         100. * (double)VibrationPart(v, -1, 1));
  report_state(p);
  fflush(stdout);
}

PetscErrorCode StageReport(const Problem *p)
{
  const MPI_Comm comm = p->m->comm;
  const StageResult *r = p->result;
  char why[512];
  PetscFunctionBeginUser;
  StageShowEnd(p);
  PetscCall(PetscPrintf(comm, "stage %-12s %s after %" PetscInt64_FMT " cycle%s, %.2f s: %s\n",
                        p->stage->name, VerdictNames[r->verdict], r->cycles, Plural(r->cycles), r->wall,
                        r->evidence));
  if (r->effort.preconditioned || r->effort.stiffness_mass)
    PetscCall(PetscPrintf(comm,
                          "  %s: %" PetscInt64_FMT " force evaluations, %" PetscInt64_FMT
                          " solves, %" PetscInt64_FMT " factorisation%s\n",
                          EffortMethod(&r->effort), r->effort.evaluations, r->effort.solves,
                          r->effort.factorisations, Plural(r->effort.factorisations)));
  MethodSentence(&r->effort.choice, sizeof(why), why);
  if (why[0] && (r->effort.preconditioned || r->effort.stiffness_mass))
    PetscCall(PetscPrintf(comm, "  chosen: %s\n", why));
  if (p->stage->kind == STAGE_MODES) report_modes(p);
  PetscCall(TimerReport(comm, r->cycles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

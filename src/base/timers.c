/* timers.c: measures the cost of the parts of a run. Every timer is a PETSc event for -log_view, and a
   clock for the reports of set-up and stages. The timers of a cycle run in one cycle of SAMPLE_EVERY, all
   others every time. */
#include "base/base.h"
#include <time.h>

double ProcessorSeconds(void)
{
  struct timespec now = {0, 0};
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

enum { SAMPLE_EVERY = 64 };
static const struct {
  const char *event, *words; /* words NULL: this timer is within another one */
} parts[TIMERS] = {[TIMER_EXCHANGE] = {"GhostExchange", "exchange"},
                   [TIMER_CONTACTS] = {"ContactForces", "contacts"},
                   [TIMER_BLOCKS] = {"ElementForces", "blocks"},
                   [TIMER_RIGID] = {"RigidBodies", "rigid bodies"},
                   [TIMER_SOLVES] = {"Solves", "solves"},
                   [TIMER_INTEGRATION] = {"Integrate", "integration"},
                   [TIMER_DAMPING] = {"Damping", "damping"},
                   [TIMER_VERIFICATION] = {"Verification", "verification"},
                   [TIMER_FAR_FACES] = {"VerifyFarFaces", NULL},
                   [TIMER_NEAR_FACES] = {"VerifyNearFaces", NULL},
                   [TIMER_FACE_CONTACTS] = {"VerifyFaces", NULL},
                   [TIMER_VERTEX_CONTACTS] = {"VerifyVertices", NULL},
                   [TIMER_HISTORY] = {"VerifyHistory", NULL},
                   [TIMER_READING] = {"SetUpReading", "reading"},
                   [TIMER_CHECKS] = {"SetUpChecks", "checks"},
                   [TIMER_ORDER] = {"SetUpOrder", "order"},
                   [TIMER_PARTITION] = {"SetUpPartition", "partition"},
                   [TIMER_DISTRIBUTION] = {"SetUpDistribution", "distribution"},
                   [TIMER_MODEL] = {"SetUpModel", "model"},
                   [TIMER_FIRST_CONTACTS] = {"SetUpContacts", "contacts"},
                   [TIMER_OUTPUT_START] = {"SetUpOutput", "output"}};
static PetscLogEvent part_event[TIMERS];
static double part_start[TIMERS], part_time[TIMERS], sampled_cycles;
static PetscBool part_registered = PETSC_FALSE, sampling = PETSC_FALSE;

PetscErrorCode TimerBegin(Timer part)
{
  PetscClassId id;
  PetscFunctionBeginUser;
  if (!part_registered) {
    PetscCall(PetscClassIdRegister("Quoin", &id));
    for (int p = 0; p < TIMERS; p++) PetscCall(PetscLogEventRegister(parts[p].event, id, &part_event[p]));
    part_registered = PETSC_TRUE;
  }
  PetscCall(PetscLogEventBegin(part_event[part], 0, 0, 0, 0));
  if (sampling || part >= TIMER_VERIFICATION) part_start[part] = MPI_Wtime();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimerEnd(Timer part)
{
  PetscFunctionBeginUser;
  if (sampling || part >= TIMER_VERIFICATION) part_time[part] += MPI_Wtime() - part_start[part];
  PetscCall(PetscLogEventEnd(part_event[part], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void TimerSample(PetscInt64 cycle)
{
  sampling = (PetscBool)(cycle % SAMPLE_EVERY == 0);
  sampled_cycles += sampling;
}

/* Prints the shares of the timers first .. last, then resets them. */
static PetscErrorCode print_shares(MPI_Comm comm, Timer first, Timer last, double sum)
{
  PetscFunctionBeginUser;
  for (Timer p = first; p <= last; p++) {
    if (parts[p].words && part_time[p] > 0.005 * sum)
      PetscCall(PetscPrintf(comm, " %s %.0f %%", parts[p].words, 100. * part_time[p] / sum));
    part_time[p] = 0.;
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimerReport(MPI_Comm comm, PetscInt64 cycles)
{
  double sum = part_time[TIMER_VERIFICATION];
  PetscFunctionBeginUser;
  for (Timer p = 0; p < TIMER_VERIFICATION; p++) {
    part_time[p] *= sampled_cycles > 0. ? (double)cycles / sampled_cycles : 0.;
    sum += part_time[p];
  }
  if (sum > 0. && cycles) {
    PetscCall(PetscPrintf(comm, "  %.3g us a cycle:", 1e6 * sum / (double)cycles));
    PetscCall(print_shares(comm, 0, TIMER_VERIFICATION, sum));
  }
  sampled_cycles = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimerReportSetUp(MPI_Comm comm)
{
  double sum = 0.;
  PetscFunctionBeginUser;
  for (Timer p = TIMER_READING; p < TIMERS; p++) sum += part_time[p];
  PetscCall(PetscPrintf(comm, "set-up %.2f s:", sum));
  PetscCall(print_shares(comm, TIMER_READING, TIMERS - 1, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

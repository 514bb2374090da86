/* parts.c: what each part of a run costs. Every part is a PETSc event for -log_view, and has a clock for the
   reports of set-up and stages. The parts of a cycle are timed in one cycle of SAMPLE_EVERY, all other parts
   every time. */
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
  const char *event, *words; /* words NULL: this part is within another one */
} parts[PARTS] = {[PART_EXCHANGE] = {"GhostExchange", "exchange"},
                  [PART_CONTACTS] = {"ContactForces", "contacts"},
                  [PART_BLOCKS] = {"ElementForces", "blocks"},
                  [PART_RIGID] = {"RigidBodies", "rigid bodies"},
                  [PART_INTEGRATION] = {"Integrate", "integration"},
                  [PART_DAMPING] = {"Damping", "damping"},
                  [PART_REPARTITION] = {"Repartition", "re-partition"},
                  [PART_VERIFICATION] = {"Verification", "verification"},
                  [PART_FAR_FACES] = {"VerifyFarFaces", NULL},
                  [PART_NEAR_FACES] = {"VerifyNearFaces", NULL},
                  [PART_FACE_CONTACTS] = {"VerifyFaces", NULL},
                  [PART_VERTEX_CONTACTS] = {"VerifyVertices", NULL},
                  [PART_HISTORY] = {"VerifyHistory", NULL},
                  [PART_READING] = {"SetUpReading", "reading"},
                  [PART_CHECKS] = {"SetUpChecks", "checks"},
                  [PART_ORDER] = {"SetUpOrder", "order"},
                  [PART_PARTITION] = {"SetUpPartition", "partition"},
                  [PART_DISTRIBUTION] = {"SetUpDistribution", "distribution"},
                  [PART_MODEL] = {"SetUpModel", "model"},
                  [PART_FIRST_CONTACTS] = {"SetUpContacts", "contacts"},
                  [PART_OUTPUT_START] = {"SetUpOutput", "output"}};
static PetscLogEvent part_event[PARTS];
static double part_start[PARTS], part_time[PARTS], sampled_cycles;
static PetscBool part_registered = PETSC_FALSE, sampling = PETSC_FALSE;

PetscErrorCode PartBegin(Part part)
{
  PetscClassId id;
  PetscFunctionBeginUser;
  if (!part_registered) {
    PetscCall(PetscClassIdRegister("Quoin", &id));
    for (int p = 0; p < PARTS; p++) PetscCall(PetscLogEventRegister(parts[p].event, id, &part_event[p]));
    part_registered = PETSC_TRUE;
  }
  PetscCall(PetscLogEventBegin(part_event[part], 0, 0, 0, 0));
  if (sampling || part >= PART_REPARTITION) part_start[part] = MPI_Wtime();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartEnd(Part part)
{
  PetscFunctionBeginUser;
  if (sampling || part >= PART_REPARTITION) part_time[part] += MPI_Wtime() - part_start[part];
  PetscCall(PetscLogEventEnd(part_event[part], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PartSample(PetscInt64 cycle)
{
  sampling = (PetscBool)(cycle % SAMPLE_EVERY == 0);
  sampled_cycles += sampling;
}

/* Prints the shares of the parts first .. last, then sets them to zero. */
static PetscErrorCode print_shares(MPI_Comm comm, Part first, Part last, double sum)
{
  PetscFunctionBeginUser;
  for (Part p = first; p <= last; p++) {
    if (parts[p].words && part_time[p] > 0.005 * sum)
      PetscCall(PetscPrintf(comm, " %s %.0f %%", parts[p].words, 100. * part_time[p] / sum));
    part_time[p] = 0.;
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartReport(MPI_Comm comm, PetscInt64 cycles)
{
  double sum = part_time[PART_REPARTITION] + part_time[PART_VERIFICATION];
  PetscFunctionBeginUser;
  for (Part p = 0; p < PART_REPARTITION; p++) {
    part_time[p] *= sampled_cycles > 0. ? (double)cycles / sampled_cycles : 0.;
    sum += part_time[p];
  }
  if (sum > 0. && cycles) {
    PetscCall(PetscPrintf(comm, "  %.3g us a cycle:", 1e6 * sum / (double)cycles));
    PetscCall(print_shares(comm, 0, PART_VERIFICATION, sum));
  }
  sampled_cycles = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PartReportSetUp(MPI_Comm comm)
{
  double sum = 0.;
  PetscFunctionBeginUser;
  for (Part p = PART_READING; p < PARTS; p++) sum += part_time[p];
  PetscCall(PetscPrintf(comm, "set-up %.2f s:", sum));
  PetscCall(print_shares(comm, PART_READING, PARTS - 1, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

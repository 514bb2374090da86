/* modes.c: runs a stage of type modes: finds periods and shapes of small free vibrations about the present
   state. Nothing moves, and later stages have the same bits with and without it. */
#include "stages/stages.h"

/* Adds to the text the error of condensed bodies. */
static PetscErrorCode append_error(const Vibration *v, char *text, size_t size)
{
  const size_t used = strlen(text);
  PetscInt worst = 0, unknown = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < v->n; i++) {
    if (v->error[i] > v->error[worst] || PetscIsNanReal(v->error[worst])) worst = i;
    unknown += v->omega2[i] > 0. && PetscIsNanReal(v->error[i]);
  }
  if (!v->reduced || !v->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(text + used, size - used,
                          "; by the modes that condensed bodies lack, frequencies are too high by up to %.2g "
                          "%% (mode %" PetscInt_FMT ")",
                          100. * (double)v->error[worst], worst + 1));
  const size_t now = strlen(text);
  if (unknown)
    PetscCall(PetscSNPrintf(text + now, size - now,
                            ", of %" PetscInt_FMT " it is not known: raise highest_frequency", unknown));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ModesRun(const Problem *p)
{
  const double start = MPI_Wtime();
  StageResult *result = p->result;
  Vibration *v = &p->found->vibration;
  PetscInt growing = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(result, sizeof(*result)));
  PetscCall(VibrationFind(p, v));
  while (growing < v->n && v->omega2[growing] < 0.) growing++;
  result->verdict = VERDICT_COMPLETED, result->ratio = NAN;
  result->wall = MPI_Wtime() - start;
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence), "%" PetscInt_FMT " mode%s", v->n,
                          Plural(v->n)));
  const size_t used = strlen(result->evidence), left = sizeof(result->evidence) - used;
  if (growing)
    PetscCall(PetscSNPrintf(result->evidence + used, left, "; %" PetscInt_FMT " grow%s: no stable state",
                            growing, growing == 1 ? "s" : ""));
  else if (v->missed)
    PetscCall(PetscSNPrintf(result->evidence + used, left, "; slower ones may be missing"));
  else
    PetscCall(PetscSNPrintf(result->evidence + used, left, ", and none is missing among them"));
  PetscCall(append_error(v, result->evidence, sizeof(result->evidence)));
  if (v->missed && !p->m->rank)
    Warn(v->missed > 0
             ? "stage %s: %" PetscInt_FMT " mode(s) that are slower than the last one were not found"
             : "stage %s: the modes could not be counted (%" PetscInt_FMT "): slower ones may be missing",
         p->stage->name, v->missed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* isa.c: selects the instruction set of the hot loops (lanes.h: VARIANTS). All sets give the same bits.
   The choice is for measuring; it also shows that the processor is not the reason when two machines
   differ. */
#include "base/base.h"
#include "base/lanes.h"

InstructionSet instruction_set = ISA_BASE;
const char *const InstructionSets[] = {"widest", "base", "v3", "v4", "InstructionSet", "ISA_", NULL};

/* Returns the widest set that this processor and system have. */
static InstructionSet widest(void)
{
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd"))
    return ISA_V4;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    return ISA_V3;
#endif
  return ISA_BASE;
}

const char *IsaName(void)
{
  return InstructionSets[instruction_set];
}

PetscErrorCode IsaSelect(MPI_Comm comm, InstructionSet asked, const char *file)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  instruction_set = asked == ISA_WIDEST ? widest() : asked;
  if (instruction_set > widest())
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "%s: isa: %s: this processor has no more than %s", file,
                            InstructionSets[instruction_set], InstructionSets[widest()]));
  PetscCall(CheckMessage(comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

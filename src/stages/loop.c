/* loop.c: runs a stage that moves, or a trial, from its start to its verdict. This loop handles checkpoints,
   signals and the clock for every kind of stage. */
#include "stages/loop.h"

static PetscErrorCode archive_loop(Archive *a, void *context)
{
  Loop *loop = context;
  StageResult *result = loop->p->result;
  PetscFunctionBeginUser;
  result->wall = MPI_Wtime() - loop->start;
  PetscCall(ArchiveResult(a, "result", result));
  PetscCall(loop->kind->archive(a, loop));
  loop->start = MPI_Wtime() - result->wall;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool goes_on(const Loop *loop)
{
  if (loop->p->result->verdict != VERDICT_NONE) return PETSC_FALSE;
  return (PetscBool)(!loop->kind->over || !loop->kind->over(loop));
}

/* Judges the stage at a check, settles what depends on it, and writes the check. */
static PetscErrorCode check(Loop *loop)
{
  const LoopKind *kind = loop->kind;
  PetscFunctionBeginUser;
  loop->restarted = PETSC_FALSE;
  PetscCall(kind->judge(loop));
  if (loop->restarted) PetscFunctionReturn(PETSC_SUCCESS);
  if (kind->settle) PetscCall(kind->settle(loop));
  PetscCall(kind->report(loop));
  if (kind->follow) PetscCall(kind->follow(loop));
  PetscCall(CheckpointPoll(loop->p->checkpoint, loop->p->state->cycle, loop->p->result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StageLoop(const Problem *p, const LoopKind *kind, void *memory)
{
  Loop loop = {.p = p, .kind = kind, .memory = memory, .start = MPI_Wtime()};
  PetscBool resumed;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(p->result, sizeof(*p->result)));
  PetscCall(CheckpointAttach(p->checkpoint, "stage", archive_loop, &loop, &resumed));
  PetscCall(resumed ? kind->resume(&loop) : kind->begin(&loop));
  while (goes_on(&loop)) {
    loop.checks = kind->checks(&loop);
    if (kind->load) PetscCall(kind->load(&loop));
    PetscCall(kind->cycle(&loop));
    p->result->cycles++;
    if (!loop.checks && !(kind->fault && kind->fault(&loop))) continue;
    p->result->wall = MPI_Wtime() - loop.start;
    PetscCall(check(&loop));
  }
  PetscCall(CheckpointDetach(p->checkpoint));
  PetscCall(kind->end(&loop));
  p->result->wall = MPI_Wtime() - loop.start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

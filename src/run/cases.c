/* cases.c: runs stages that start from another stage than the one before them: independent load cases.

   What a checkpoint keeps of the state at the end of a stage is kept in memory, on rank 0, until the last
   stage that starts from it has begun. To go back is a restart without a file: quoin.c builds the model
   again, and the archive is read. So the whole memory of a run comes back, on any number of ranks, and a
   case ends with the same bits as in a scene without other cases. */
#include "run/run.h"

enum { NOWHERE = -2 };
static const char *const Parts[] = {"state", "relaxation"}; /* parts of a checkpoint that are kept */

PetscErrorCode CasesCreate(MPI_Comm comm, const Scene *scene, const PetscInt *stage, Cases *c)
{
  PetscFunctionBeginUser;
  *c = (Cases){.scene = scene, .stage = stage, .at = -1};
  PetscCall(PetscCalloc2(scene->n_stages, &c->verdict, scene->n_stages, &c->kept));
  for (PetscInt s = 0; s < scene->n_stages; s++) PetscCall(ArchiveCreate(comm, c->kept + s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CasesDestroy(Cases *c)
{
  PetscFunctionBeginUser;
  for (PetscInt s = 0; c->kept && s < c->scene->n_stages; s++) PetscCall(ArchiveDestroy(c->kept + s));
  PetscCall(PetscFree2(c->verdict, c->kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool stands(Verdict verdict)
{
  return (PetscBool)(verdict == VERDICT_CONVERGED || verdict == VERDICT_COMPLETED);
}

PetscBool CaseCanRun(const Cases *c, PetscInt stage)
{
  const PetscInt base = StageBase(c->scene, stage);
  return (PetscBool)(base < 0 || stands((Verdict)c->verdict[base]));
}

PetscBool CaseIsElsewhere(const Cases *c, PetscInt stage)
{
  return (PetscBool)(c->at != StageBase(c->scene, stage));
}

/* Decides whether a stage from row `first` on starts from the end of this one. */
static PetscBool is_base(const Scene *scene, PetscInt stage, PetscInt first)
{
  for (PetscInt s = first; s < scene->n_stages; s++)
    if (StageBase(scene, s) == stage) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- keeping and going back */

/* Writes these parts of the checkpoint into memory, or reads them back. */
static PetscErrorCode archive_state(const Checkpoint *checkpoint, Archive *kept)
{
  PetscFunctionBeginUser;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Parts); i++)
    for (const CheckpointPart *p = checkpoint->parts; p < checkpoint->parts + checkpoint->n_parts; p++) {
      if (strcmp(p->name, Parts[i]) != 0) continue;
      PetscCall(PetscStrncpy(kept->part, p->name, sizeof(kept->part)));
      PetscCall(p->function(kept, p->context));
    }
  PetscCall(CheckpointRefuse(checkpoint, ERROR_OUTPUT, kept->message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CaseKeep(Cases *c, const Checkpoint *checkpoint)
{
  PetscFunctionBeginUser;
  // the next stage may start from the present state
  if (c->at < 0 || !is_base(c->scene, c->at, *c->stage + 1)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveDestroy(c->kept + c->at));
  c->kept[c->at].reading = PETSC_FALSE;
  PetscCall(archive_state(checkpoint, c->kept + c->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CaseEnd(Cases *c, Verdict verdict)
{
  const PetscInt stage = *c->stage - 1;
  PetscFunctionBeginUser;
  c->verdict[stage] = verdict;
  c->at = stands(verdict) ? stage : NOWHERE;
  for (PetscInt s = 0; s < stage; s++)
    if (!is_base(c->scene, s, stage + 1)) PetscCall(ArchiveDestroy(c->kept + s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CaseGoBack(Cases *c, const Checkpoint *checkpoint)
{
  PetscFunctionBeginUser;
  c->at = StageBase(c->scene, *c->stage);
  c->kept[c->at].reading = PETSC_TRUE;
  PetscCall(archive_state(checkpoint, c->kept + c->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a checkpoint keeps of it, see archive.h */

/* Rank 0. Copies the kept data of a stage into the archive, below its number, or from there. */
static PetscErrorCode copy_kept(Archive *a, PetscInt stage, Archive *kept)
{
  char head[NAME_LENGTH], name[2 * NAME_LENGTH];
  Archive *from = a->reading ? a : kept, *to = a->reading ? kept : a;
  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(head, sizeof(head), "%s/%" PetscInt_FMT "/", a->part, stage));
  for (PetscInt i = 0, n = from->n; i < n; i++) {
    const ArchiveEntry *e = from->entries + i;
    const size_t bytes = e->rows * e->columns * (e->kind == ARCHIVE_TEXT ? 1 : 8), skip = strlen(head);
    void *data;
    if (a->reading && strncmp(e->name, head, skip) != 0) continue;
    PetscCall(
        PetscSNPrintf(name, sizeof(name), "%s%s", a->reading ? "" : head, e->name + (a->reading ? skip : 0)));
    PetscCall(PetscMalloc(bytes + 1, &data));
    PetscCall(PetscMemcpy(data, e->data, bytes));
    PetscCall(ArchiveAdd(to, name, e->kind, e->rows, e->columns, data));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CasesArchive(Archive *a, void *context)
{
  Cases *c = context;
  const PetscInt done = *c->stage;
  PetscFunctionBeginUser;
  PetscCall(ArchiveInts(a, "at", 1, &c->at));
  PetscCall(ArchiveInts(a, "verdicts", done, c->verdict));
  c->at = (PetscInt)ArchiveWithin(a, "at", c->at, NOWHERE, done - 1);
  for (PetscInt s = 0; s < done; s++) {
    c->verdict[s] = (PetscInt)ArchiveWithin(a, "verdicts", c->verdict[s], VERDICT_NONE, VERDICT_COMPLETED);
    if (!a->rank) PetscCall(copy_kept(a, s, c->kept + s));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CasesResume(Cases *c, const Checkpoint *checkpoint, PetscBool resumed, PetscBool begun)
{
  const Scene *scene = c->scene;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (!resumed) { // the checkpoint belongs to a run without cases: all stages up to it stand
    for (PetscInt s = 0; s < *c->stage; s++) c->verdict[s] = VERDICT_CONVERGED;
    c->at = *c->stage - 1;
  }
  if (!begun && c->at == *c->stage - 1 && !(c->at >= 0 && c->kept[c->at].n))
    PetscCall(CaseKeep(c, checkpoint));
  for (PetscInt s = *c->stage + (PetscInt)begun; s < scene->n_stages && !checkpoint->rank; s++) {
    const PetscInt base = StageBase(scene, s);
    if (base < 0 || base >= *c->stage || !stands((Verdict)c->verdict[base]) || c->kept[base].n) continue;
    if (s == *c->stage && base == c->at) continue;
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "restart: '%.500s' has not kept the end of stage %s, from which stage %s starts: "
                            "run the scene from its start",
                            checkpoint->last, scene->stages[base].name, scene->stages[s].name));
    break;
  }
  PetscCall(Refuse(c->kept->comm, ERROR_CHECKPOINT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- report */

Verdict CasesVerdict(const Cases *c, Verdict last)
{
  if (last == VERDICT_INTERRUPTED || !c->verdict) return last;
  for (PetscInt s = 0; s < *c->stage; s++)
    if (c->verdict[s] != VERDICT_NONE && !stands((Verdict)c->verdict[s])) return (Verdict)c->verdict[s];
  return last;
}

PetscErrorCode CasesReport(const Cases *c, MPI_Comm comm)
{
  const Scene *scene = c->scene;
  PetscInt failed = 0;
  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < *c->stage; s++) {
    if (stands((Verdict)c->verdict[s])) continue;
    PetscCall(PetscPrintf(comm, "%s %s %s",
                          failed++ ? "," : "cases that do not stand:", scene->stages[s].name,
                          c->verdict[s] == VERDICT_NONE ? "not run" : VerdictNames[c->verdict[s]]));
  }
  if (failed)
    PetscCall(PetscPrintf(comm, "; %" PetscInt_FMT " of %" PetscInt_FMT " stages stand\n", *c->stage - failed,
                          scene->n_stages));
  PetscFunctionReturn(PETSC_SUCCESS);
}

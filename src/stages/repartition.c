/* repartition.c: gives a run a new partition when blocks have moved so far that the old one has become bad.
   All memory of the run is written into an archive, which knows no ranks. Then the model is built from the
   mesh with another partition, and the archive is read back. That is a restart without a file. */
#include "stages/stages.h"

PetscErrorCode RepartitionCreate(const Scene *scene, const Model *m, BlockMesh *mesh, Repartition *r)
{
  PetscBool moves = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  for (PetscInt s = 0; s < scene->n_stages; s++)
    moves = (PetscBool)(moves || (scene->stages[s].variable &&
                                  (scene->stages[s].kind == STAGE_STATIC || StageInTime(scene->stages + s))));
  r->possible = (PetscBool)(moves && scene->repartition == REPARTITION_AUTO && m->size > 1 &&
                            !m->mesh.n_condensed_global);
  r->keeps = (PetscBool)(r->possible || SceneBranches(scene));
  if (!r->keeps) PetscFunctionReturn(PETSC_SUCCESS);
  r->scene = scene, r->model = m;
  r->mesh = *mesh;
  PetscCall(PetscMemzero(mesh, sizeof(*mesh)));
  if (m->rank || !r->possible) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshConnected(&r->mesh, r->mesh.group_rigid, &r->bodies.n_rigid, &r->bodies.rigid));
  PetscCall(MeshCondensed(scene, &r->mesh, m->contact_margin, &r->bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RepartitionDestroy(Repartition *r)
{
  PetscFunctionBeginUser;
  if (!r->keeps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshDestroy(&r->mesh));
  PetscCall(PetscFree(r->bodies.rigid));
  PetscCall(PetscFree(r->bodies.condensed));
  PetscCall(PetscFree(r->bodies.inner));
  PetscCall(PetscFree(r->bodies.calm));
  r->possible = r->keeps = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Gathers the present coordinates x [m] of all vertices on rank 0, (n_vertices_global,2) by
   gid. */
static PetscErrorCode present_places(const Model *m, const State *s, PetscReal **x)
{
  const PetscReal *u = s->u + 3 * m->rigid.n;
  PetscReal *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * m->mesh.n_owned, &rows));
  for (PetscInt i = 0; i < 2 * m->mesh.n_owned; i++) rows[i] = m->mesh.X[i] + u[i];
  PetscCall(GatherPlaced(m->comm, m->mesh.n_owned, m->mesh.vertex_gid, 2 * sizeof(*rows), rows,
                         m->mesh.n_vertices_global, x));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0, puts a partition for blocks with vertices at x into mesh.part, if it is better by more than
   repartition_gain. *old gets the old partition, or NULL if the old one stays. */
static PetscErrorCode find_partition(Repartition *r, PetscReal *x, PetscInt **old)
{
  BlockMesh there = r->mesh;
  PetscReal work[2], size = 0.;
  PetscFunctionBeginUser;
  *old = NULL;
  for (PetscInt i = 0; i < 2 * there.n_vertices; i++) size += PetscAbsReal(x[i]);
  // where a coordinate is not finite, the next check will end the stage
  if (!(size < PETSC_MAX_REAL)) PetscFunctionReturn(PETSC_SUCCESS);
  there.X = x;
  PetscCall(PetscMalloc1(there.n_blocks, &there.part));
  PetscCall(PetscArraycpy(there.part, r->mesh.part, there.n_blocks));
  PetscCall(PartitionBlocks(&there, &r->bodies, r->scene->partition, r->model->contact_margin, r->model->size,
                            there.part, work));
  if (work[1] < (1. - r->scene->repartition_gain) * work[0])
    *old = r->mesh.part, r->mesh.part = there.part;
  else
    PetscCall(PetscFree(there.part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Measures a partition. imbalance: blocks and contacts of the rank with most of them, over the
   mean; ghosts: vertices that ranks read of others. */
static PetscErrorCode measure(const Model *m, const Contacts *c, PetscReal *imbalance, PetscInt64 *ghosts)
{
  PetscInt64 most = m->mesh.q4.n + m->mesh.t3.n + c->n, sum[2] = {most, m->ghosts.n};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT64, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_INT64, MPI_SUM, m->comm));
  *imbalance = sum[0] ? (PetscReal)most * m->size / (PetscReal)sum[0] : 1.;
  *ghosts = sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a new partition if it pays, and reports the gain. */
static PetscErrorCode try_partition(Repartition *r, Checkpoint *checkpoint, PetscInt64 cycle)
{
  const double start = MPI_Wtime();
  PetscReal *x, imbalance[2];
  PetscInt64 ghosts[2];
  PetscInt *old = NULL;
  PetscFunctionBeginUser;
  PetscCall(present_places(r->model, r->state, &x));
  if (!r->model->rank) PetscCall(find_partition(r, x, &old));
  PetscCall(PetscFree(x));
  int better = old != NULL;
  PetscCall(PetscFree(old));
  PetscCallMPI(MPI_Bcast(&better, 1, MPI_INT, 0, r->model->comm));
  if (!better) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(measure(r->model, r->contacts, &imbalance[0], &ghosts[0]));
  PetscCall(CheckpointThrough(checkpoint, r->renew, r->context));
  PetscCall(measure(r->model, r->contacts, &imbalance[1], &ghosts[1]));
  PetscCall(PetscPrintf(r->model->comm,
                        "re-partitioned at cycle %" PetscInt64_FMT
                        ": most blocks and contacts of a rank over the mean %.3f -> %.3f, ghost vertices "
                        "%" PetscInt64_FMT " -> %" PetscInt64_FMT ", %.2g s\n",
                        cycle, (double)imbalance[0], (double)imbalance[1], ghosts[0], ghosts[1],
                        MPI_Wtime() - start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RepartitionPoll(const Problem *p)
{
  const Stage *stage = p->stage;
  const PetscInt64 cycle = p->state->cycle;
  Repartition *r = p->checkpoint->repartition;
  PetscFunctionBeginUser;
  if (!r || !r->possible || !stage->variable || p->result->verdict != VERDICT_NONE ||
      (stage->kind != STAGE_STATIC && !StageInTime(stage)) ||
      cycle - r->last_try < r->scene->repartition_every)
    PetscFunctionReturn(PETSC_SUCCESS);
  r->last_try = cycle;
  PetscCall(TimerBegin(TIMER_REPARTITION));
  PetscCall(try_partition(r, p->checkpoint, cycle));
  PetscCall(TimerEnd(TIMER_REPARTITION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

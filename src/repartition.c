/* repartition.c: a run is dealt out to the ranks anew when blocks have moved so far that the old partition
   has become bad: all memory of the run is written into an archive, which knows no ranks, the model is built
   from the mesh with another partition, and the archive is read back. As a restart, but without a file. */
#include "output.h"
#include "repartition.h"

PetscErrorCode RepartitionCreate(const Scene *scene, const Model *m, BlockMesh *mesh, Repartition *r)
{
  PetscBool moves = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  for (PetscInt s = 0; s < scene->n_stages; s++)
    moves = (PetscBool)(moves || (scene->stages[s].variable && (scene->stages[s].kind == STAGE_STATIC ||
                                                                scene->stages[s].kind == STAGE_DYNAMIC)));
  r->possible = (PetscBool)(moves && scene->repartition == REPARTITION_AUTO && m->size > 1 &&
                            !m->n_condensed_global);
  if (!r->possible) PetscFunctionReturn(PETSC_SUCCESS);
  r->scene = scene, r->model = m;
  r->mesh = *mesh;
  PetscCall(PetscMemzero(mesh, sizeof(*mesh)));
  if (m->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshConnected(&r->mesh, r->mesh.group_rigid, &r->bodies.n_rigid, &r->bodies.rigid));
  PetscCall(MeshCondensed(scene, &r->mesh, m->contact_margin, &r->bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RepartitionDestroy(Repartition *r)
{
  PetscFunctionBeginUser;
  if (!r->possible) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshDestroy(&r->mesh));
  PetscCall(PetscFree(r->bodies.rigid));
  PetscCall(PetscFree(r->bodies.condensed));
  PetscCall(PetscFree(r->bodies.inner));
  r->possible = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Coordinates of all vertices on rank 0 (n_vertices,2), by gid [m]. */
static PetscErrorCode present_places(const Model *m, const State *s, PetscReal **x)
{
  const PetscReal *u = s->u + 3 * m->n_bodies;
  PetscInt *gid;
  PetscReal *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->n_owned, &gid));
  PetscCall(PetscMalloc1(2 * m->n_owned, &rows));
  PetscCall(PetscArraycpy(gid, m->vertex_gid, m->n_owned));
  for (PetscInt i = 0; i < 2 * m->n_owned; i++) rows[i] = m->X[i] + u[i];
  PetscCall(GatherPlaced(m->comm, m->n_owned, gid, 2, rows, m->n_vertices_global, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vertices P A B Q (n,4) of all contacts on rank 0, by gid. */
static PetscErrorCode present_contacts(const Model *m, const Contacts *c, PetscInt *n, PetscInt **vertex)
{
  PetscInt mine = 0, *rows;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(CONTACT_ROWS * c->n, &rows));
  for (PetscInt i = 0; i < c->n_padded; i++) {
    if (!c->owned[i] || c->key[2 * i] < 0) continue;
    for (int k = 0; k < CONTACT_ROWS; k++)
      rows[CONTACT_ROWS * mine + k] = m->vertex_gid[c->vertex[CONTACT_ROW(i, k)]];
    mine++;
  }
  PetscCall(GatherBytes(m->comm, mine, CONTACT_ROWS * sizeof(PetscInt), rows, n, (void **)vertex));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One more for every rank that owns one of four vertices, -1: there is none. */
static void count_ranks(const PetscInt *owner, const PetscInt *vertex, PetscInt64 *work)
{
  PetscInt seen[4];
  for (int k = 0; k < 4; k++) {
    seen[k] = vertex[k] < 0 ? -1 : owner[vertex[k]];
    PetscBool again = (PetscBool)(seen[k] < 0);
    for (int l = 0; l < k; l++) again = (PetscBool)(again || seen[l] == seen[k]);
    if (!again) work[seen[k]]++;
  }
}

/* Rank 0: deformable blocks and contacts that the busiest rank computes with a partition: all that touch a
   vertex it owns, and a vertex belongs to the highest rank of its blocks (distribute.c). */
static PetscErrorCode busiest(const Repartition *r, const PetscInt *part, PetscInt n_contacts,
                              const PetscInt *contacts, PetscInt64 *most)
{
  const BlockMesh *mesh = &r->mesh;
  PetscInt *owner;
  PetscInt64 *work;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(mesh->n_vertices, &owner));
  PetscCall(PetscCalloc1(r->model->size, &work));
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0) owner[mesh->blocks[i]] = PetscMax(owner[mesh->blocks[i]], part[i / 4]);
  for (PetscInt b = 0; b < mesh->n_blocks; b++)
    if (r->bodies.rigid[b] < 0) count_ranks(owner, mesh->blocks + 4 * b, work);
  for (PetscInt i = 0; i < n_contacts; i++) count_ranks(owner, contacts + CONTACT_ROWS * i, work);
  *most = 0;
  for (PetscMPIInt rank = 0; rank < r->model->size; rank++) *most = PetscMax(*most, work[rank]);
  PetscCall(PetscFree(owner));
  PetscCall(PetscFree(work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: a partition for blocks with vertices at x into mesh.part, when it leaves the busiest rank less to
   compute, by more than is asked for; then the one before is in *old. */
static PetscErrorCode deal_out(Repartition *r, PetscReal *x, PetscInt n_contacts, const PetscInt *contacts,
                               PetscInt **old)
{
  BlockMesh there = r->mesh;
  PetscInt64 work[2];
  PetscReal size = 0.;
  PetscFunctionBeginUser;
  *old = NULL;
  for (PetscInt i = 0; i < 2 * there.n_vertices; i++) size += PetscAbsReal(x[i]);
  if (!(size < PETSC_MAX_REAL)) PetscFunctionReturn(PETSC_SUCCESS); // the run is about to be told so
  there.X = x;
  PetscCall(PetscMalloc1(there.n_blocks, &there.part));
  PetscCall(PartitionBlocks(&there, &r->bodies, r->scene->partition, r->model->contact_margin, r->model->size,
                            there.part));
  PetscCall(busiest(r, r->mesh.part, n_contacts, contacts, &work[0]));
  PetscCall(busiest(r, there.part, n_contacts, contacts, &work[1]));
  if ((PetscReal)work[1] < (1. - r->scene->repartition_gain) * (PetscReal)work[0])
    *old = r->mesh.part, r->mesh.part = there.part;
  else
    PetscCall(PetscFree(there.part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective. Deformable blocks and contacts that the busiest rank computes; vertices that ranks read of
   others. */
static PetscErrorCode measure(const Model *m, const Contacts *c, PetscInt64 *most, PetscInt64 *ghosts)
{
  PetscFunctionBeginUser;
  *most = m->q4.n + m->t3.n + c->n, *ghosts = m->n_ghosts;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_INT64, MPI_MAX, m->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ghosts, 1, MPIU_INT64, MPI_SUM, m->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode look(Repartition *r, Checkpoint *checkpoint, PetscInt64 cycle)
{
  const double start = MPI_Wtime();
  PetscReal *x;
  PetscInt64 most[2], ghosts[2];
  PetscInt n_contacts, *contacts, *old = NULL;
  PetscFunctionBeginUser;
  PetscCall(present_places(r->model, r->state, &x));
  PetscCall(present_contacts(r->model, r->contacts, &n_contacts, &contacts));
  if (!r->model->rank) PetscCall(deal_out(r, x, n_contacts, contacts, &old));
  PetscCall(PetscFree(contacts));
  PetscCall(PetscFree(x));
  int better = old != NULL;
  PetscCall(PetscFree(old));
  PetscCallMPI(MPI_Bcast(&better, 1, MPI_INT, 0, r->model->comm));
  if (!better) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(measure(r->model, r->contacts, &most[0], &ghosts[0]));
  PetscCall(CheckpointThrough(checkpoint, r->renew, r->context));
  PetscCall(measure(r->model, r->contacts, &most[1], &ghosts[1]));
  PetscCall(PetscPrintf(r->model->comm,
                        "re-partitioned at cycle %" PetscInt64_FMT
                        ": blocks and contacts of the busiest rank %" PetscInt64_FMT " -> %" PetscInt64_FMT
                        ", ghost vertices %" PetscInt64_FMT " -> %" PetscInt64_FMT ", %.2g s\n",
                        cycle, most[0], most[1], ghosts[0], ghosts[1], MPI_Wtime() - start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RepartitionPoll(const Problem *p)
{
  const Stage *stage = p->stage;
  const PetscInt64 cycle = p->state->cycle;
  Repartition *r = p->output->checkpoint->repartition;
  PetscFunctionBeginUser;
  if (!r || !r->possible || !stage->variable || p->result->verdict != VERDICT_NONE ||
      (stage->kind != STAGE_STATIC && stage->kind != STAGE_DYNAMIC) ||
      cycle - r->looked < r->scene->repartition_every)
    PetscFunctionReturn(PETSC_SUCCESS);
  r->looked = cycle;
  PetscCall(PartBegin(PART_REPARTITION));
  PetscCall(look(r, p->output->checkpoint, cycle));
  PetscCall(PartEnd(PART_REPARTITION));
  PetscFunctionReturn(PETSC_SUCCESS);
}

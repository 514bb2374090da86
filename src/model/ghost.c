/* ghost.c: exchanges the displacements of a cycle: it sends the displacements of owned vertices to the ranks
   that compute elements or contacts with them. Forces are never sent, because every rank computes all that
   touches its own vertices.

   On one machine the exchange goes through shared memory: 33 vertices each way take 0.15 us there, 0.4 us by
   MPI's messages and 1.5 us by PetscSF, while a rank with 500 blocks computes for 6 us. A rank writes each
   vertex that others read once, into a slot; the others know the slots of their ghosts. Elsewhere the
   exchange goes through PetscSF, which also knows who reads what. */
#include "model/model.h"
#include "base/shared.h"

/* The start of a rank's shared memory. Two copies of the displacements in its slots follow; they take
   turns. */
typedef struct {
  Count count;    /* number of exchanges published so far */
  PetscInt slots; /* number of slots of a copy */
  _Alignas(SHARED_LINE) PetscReal pair[];
} Published;

typedef struct _p_Ghost {
  PetscSF sf;                 /* leaves: ghost vertices; roots: their owners' vertices */
  MPI_Datatype pair;          /* the unit of sf: 2 doubles */
  Shared memory;              /* mine is NULL where there is none */
  Published *published;       /* the start of this rank's memory */
  uint64_t count;             /* exchanges since there is shared memory */
  PetscInt n_published;       /* number of owned vertices that others read */
  PetscInt *vertex_published; /* (n_published,) by slot */
  PetscInt n_near;            /* number of ranks whose vertices this one reads, or that read its own */
  Published **near;           /* (n_near,) the starts of their memory */
  PetscInt *start;            /* (n_near + 1,) into the next two */
  PetscInt *vertex, *slot;    /* (n_ghosts,) by owner: place of a ghost here, its slot there */
} Ghost;

/* ---- who reads what from whom */

static PetscErrorCode connect_sf(const Model *m, Ghost *g)
{
  PetscInt *leaves;
  PetscSFNode *roots;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(m->ghosts.n, &leaves));
  PetscCall(PetscMalloc1(m->ghosts.n, &roots));
  for (PetscInt i = 0; i < m->ghosts.n; i++) {
    leaves[i] = m->mesh.n_owned + i;
    roots[i].rank = m->ghosts.record[i].owner;
    roots[i].index = m->ghosts.record[i].index;
  }
  PetscCall(PetscSFReset(g->sf));
  PetscCall(PetscSFSetGraph(g->sf, m->mesh.n_owned, m->ghosts.n, leaves, PETSC_OWN_POINTER, roots,
                            PETSC_OWN_POINTER));
  PetscCall(PetscSFSetUp(g->sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the slots of the owned vertices that others read. slot: (n_vertices,); for a ghost the slot at its
   owner. */
static PetscErrorCode number_slots(const Model *m, Ghost *g, PetscInt *slot)
{
  const PetscInt *readers;
  PetscFunctionBeginUser;
  PetscCall(PetscSFComputeDegreeBegin(g->sf, &readers));
  PetscCall(PetscSFComputeDegreeEnd(g->sf, &readers));
  g->n_published = 0;
  for (PetscInt v = 0; v < m->mesh.n_owned; v++) slot[v] = readers[v] ? g->n_published++ : -1;
  PetscCall(PetscMalloc1(g->n_published, &g->vertex_published));
  for (PetscInt v = 0; v < m->mesh.n_owned; v++)
    if (slot[v] >= 0) g->vertex_published[slot[v]] = v;
  PetscCall(PetscSFBcastBegin(g->sf, MPIU_INT, slot, slot, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(g->sf, MPIU_INT, slot, slot, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes shared memory for the slots of all ranks. The reduction also ensures that all ranks have read the
   last exchange. */
static PetscErrorCode make_room(const Model *m, Ghost *g)
{
  const size_t need = sizeof(Published) + 4 * (size_t)g->n_published * sizeof(PetscReal);
  int grow = !g->memory.mine || need > g->memory.bytes;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &grow, 1, MPI_INT, MPI_MAX, m->comm));
  if (grow) {
    if (g->memory.mine) PetscCall(SharedDestroy(&g->memory));
    PetscCall(SharedCreate(m->comm, need + need / 4, &g->memory));
    g->published = g->memory.mine;
    g->count = 0;
  }
  if (g->published) g->published->slots = g->n_published;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts the ghosts by owner and finds the near ranks. Ranks that only read count as near too, because this
   rank must wait for them; see shared.h. */
static PetscErrorCode find_near(const Model *m, Ghost *g, const PetscInt *slot)
{
  PetscInt *n_read, *n_reading, *at, n = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(m->size, &n_read, m->size, &n_reading, m->size, &at));
  for (PetscInt i = 0; i < m->ghosts.n; i++) n_read[m->ghosts.record[i].owner]++;
  PetscCallMPI(MPI_Alltoall(n_read, 1, MPIU_INT, n_reading, 1, MPIU_INT, m->comm));
  g->n_near = 0;
  for (PetscMPIInt r = 0; r < m->size; r++) g->n_near += n_read[r] || n_reading[r];
  PetscCall(PetscMalloc4(g->n_near, &g->near, g->n_near + 1, &g->start, m->ghosts.n, &g->vertex, m->ghosts.n,
                         &g->slot));
  g->start[0] = 0;
  for (PetscMPIInt r = 0; r < m->size; r++) {
    if (!n_read[r] && !n_reading[r]) continue;
    PetscCall(SharedOf(&g->memory, r, &g->near[n]));
    at[r] = g->start[n];
    g->start[n + 1] = g->start[n] + n_read[r], n++;
  }
  for (PetscInt i = 0; i < m->ghosts.n; i++) {
    const PetscInt to = at[m->ghosts.record[i].owner]++;
    g->vertex[to] = m->mesh.n_owned + i, g->slot[to] = slot[m->mesh.n_owned + i];
  }
  PetscCall(PetscFree3(n_read, n_reading, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode forget(Ghost *g)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(g->vertex_published));
  PetscCall(PetscFree4(g->near, g->start, g->vertex, g->slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GhostConnect(Model *m)
{
  Ghost *g = m->ghosts.exchange;
  PetscInt *slot;
  PetscFunctionBeginUser;
  if (m->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  if (!g) {
    PetscCall(PetscNew(&g));
    PetscCall(PetscSFCreate(m->comm, &g->sf));
    PetscCallMPI(MPI_Type_contiguous(2, MPIU_REAL, &g->pair));
    PetscCallMPI(MPI_Type_commit(&g->pair));
    m->ghosts.exchange = g;
  }
  PetscCall(connect_sf(m, g));
  if (!m->one_machine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(forget(g));
  PetscCall(PetscMalloc1(m->mesh.n_vertices, &slot));
  PetscCall(number_slots(m, g, slot));
  PetscCall(make_room(m, g));
  if (g->published)
    PetscCall(find_near(m, g, slot));
  else
    m->one_machine = PETSC_FALSE; // messages are used from now on
  PetscCall(PetscFree(slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GhostDestroy(Model *m)
{
  Ghost *g = m->ghosts.exchange;
  PetscFunctionBeginUser;
  if (!g) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(forget(g));
  if (g->memory.mine) PetscCall(SharedDestroy(&g->memory));
  PetscCall(PetscSFDestroy(&g->sf));
  PetscCallMPI(MPI_Type_free(&g->pair));
  PetscCall(PetscFree(m->ghosts.exchange));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the exchange */

PetscErrorCode GhostBegin(const Model *m, PetscReal *u)
{
  Ghost *g = m->ghosts.exchange;
  PetscFunctionBeginUser;
  if (!g) PetscFunctionReturn(PETSC_SUCCESS);
  if (!g->memory.mine) {
    PetscCall(PetscSFBcastBegin(g->sf, g->pair, u, u, MPI_REPLACE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const uint64_t count = ++g->count;
  PetscReal *pair = g->published->pair + 2 * g->n_published * (count % 2);
  for (PetscInt i = 0; i < g->n_published; i++)
    for (int x = 0; x < 2; x++) pair[2 * i + x] = u[2 * g->vertex_published[i] + x];
  SharedPublish(&g->published->count, count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode GhostEnd(const Model *m, PetscReal *u)
{
  const Ghost *g = m->ghosts.exchange;
  PetscFunctionBeginUser;
  if (!g) PetscFunctionReturn(PETSC_SUCCESS);
  if (!g->memory.mine) {
    PetscCall(PetscSFBcastEnd(g->sf, g->pair, u, u, MPI_REPLACE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt n = 0; n < g->n_near; n++) {
    const Published *theirs = g->near[n];
    PetscCall(SharedWait(m->comm, &theirs->count, g->count));
    const PetscReal *pair = theirs->pair + 2 * theirs->slots * (PetscInt)(g->count % 2);
    for (PetscInt i = g->start[n]; i < g->start[n + 1]; i++)
      for (int x = 0; x < 2; x++) u[2 * g->vertex[i] + x] = pair[2 * g->slot[i] + x];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

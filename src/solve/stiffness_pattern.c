/* stiffness_pattern.c: finds which entries the stiffness has, before there are any numbers.

   Vertices that meet in a force term (a block, a contact, ...) couple with each other. A rank knows all of
   these meetings that one of its own vertices takes part in, so it finds its own rows exactly without data
   of other ranks. A node owns rows: it is a deformable vertex, or a rigid body with all its vertices. */
#include "solve/stiffness.h"

typedef struct {
  PetscInt n, *start; /* (n + 1,) meeting i is vertex[start[i]] .. vertex[start[i + 1] - 1], local vertices */
  PetscInt *vertex;
} Meetings;

/* The meetings as force terms give them: the size of each, and all vertices. */
typedef struct {
  PetscSegBuffer sizes, vertices;
} TermMeetings;

static PetscErrorCode add_of_term(PetscInt n, const PetscInt *vertices, const PetscReal *k,
                                  const PetscReal *carried, void *context)
{
  TermMeetings *of = context;
  PetscInt *to;
  PetscFunctionBeginUser;
  (void)k, (void)carried; // only the entries matter, not their values
  PetscCall(PetscSegBufferGetInts(of->sizes, 1, &to));
  *to = n;
  PetscCall(PetscSegBufferGetInts(of->vertices, n, &to));
  PetscCall(PetscArraycpy(to, vertices, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collects the meetings of all force terms. */
static PetscErrorCode meetings_create(const Model *m, const State *state, Contacts *contacts, Meetings *x)
{
  static const TermPhase phases[] = {PHASE_BLOCKS, PHASE_BODIES, PHASE_JOINTS};
  const Instant at = {.m = m, .contacts = contacts};
  TermMeetings of;
  SegmentCount n;
  PetscInt *sizes;
  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 1024, &of.sizes));
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 1024, &of.vertices));
  for (int i = 0; i < 3; i++)
    PetscCall(TermsTangent(phases[i], state, &at, TANGENT_PATTERN, add_of_term, &of));
  PetscCall(PetscSegBufferGetSize(of.sizes, &n));
  PetscCall(PetscSegBufferExtractInPlace(of.sizes, &sizes));
  PetscCall(PetscSegBufferExtractAlloc(of.vertices, &x->vertex));
  PetscCall(PetscMalloc1((PetscInt)n + 1, &x->start));
  x->n = (PetscInt)n, x->start[0] = 0;
  for (PetscInt i = 0; i < x->n; i++) x->start[i + 1] = x->start[i] + sizes[i];
  PetscCall(PetscSegBufferDestroy(&of.sizes));
  PetscCall(PetscSegBufferDestroy(&of.vertices));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the node of an own vertex that moves; else -1. */
static PetscInt node_of(const Model *m, PetscInt v)
{
  return v < m->mesh.n_deformable ? v
         : v < m->mesh.n_moving   ? m->mesh.n_deformable + RigidOfVertex(m, v)
                                  : -1;
}

/* Finds the meetings of each node: meeting[start[node]] .. meeting[start[node + 1] - 1]. most: the largest
   number of vertices in the meetings of one node. */
static PetscErrorCode meetings_of_nodes(const Model *m, const Meetings *x, PetscInt **start,
                                        PetscInt **meeting, PetscInt *most)
{
  const PetscInt n = m->mesh.n_deformable + m->rigid.n;
  PetscInt *next;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n + 1, start, x->start[x->n], meeting));
  PetscCall(PetscCalloc1(n + 1, &next));
  for (PetscInt k = 0; k < x->start[x->n]; k++) next[node_of(m, x->vertex[k]) + 1]++; // next[0]: others'
  for (PetscInt i = 0, sum = 0; i <= n; i++) {
    const PetscInt of_node = i < n ? next[i + 1] : 0;
    (*start)[i] = next[i] = sum;
    sum += of_node;
  }
  for (PetscInt i = 0; i < x->n; i++)
    for (PetscInt k = x->start[i]; k < x->start[i + 1]; k++) {
      const PetscInt node = node_of(m, x->vertex[k]);
      if (node >= 0) (*meeting)[next[node]++] = i;
    }
  *most = 0;
  for (PetscInt node = 0; node < n; node++) {
    PetscInt vertices = 0;
    for (PetscInt k = (*start)[node]; k < (*start)[node + 1]; k++)
      vertices += x->start[(*meeting)[k] + 1] - x->start[(*meeting)[k]];
    *most = PetscMax(*most, vertices);
  }
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the columns of the rows of a node, ascending, from the n meetings it takes part in. */
static PetscErrorCode node_columns(const Stiffness *s, const Meetings *x, PetscInt n, const PetscInt *meeting,
                                   PetscInt *n_columns, PetscInt *column)
{
  PetscInt found = 0;
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt k = x->start[meeting[i]]; k < x->start[meeting[i] + 1]; k++)
      for (int a = 0; a < 3; a++) {
        const PetscInt row = s->row[3 * x->vertex[k] + a];
        if (row >= 0) column[found++] = row;
      }
  PetscCall(PetscSortRemoveDupsInt(&found, column));
  *n_columns = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the columns of a row. A held row, and a row without meetings, has its diagonal alone. */
static PetscErrorCode add_row(const Model *m, const Stiffness *s, PetscInt dof, PetscInt n,
                              const PetscInt *column, PetscInt *row_start, PetscSegBuffer columns)
{
  const PetscInt diagonal = s->first + dof;
  const PetscBool alone = (PetscBool)(Held(m, dof) || n == 0);
  PetscInt *to;
  PetscFunctionBeginUser;
  PetscCall(PetscSegBufferGetInts(columns, alone ? 1 : n, &to));
  PetscCall(PetscArraycpy(to, alone ? &diagonal : column, alone ? 1 : n));
  row_start[dof + 1] = row_start[dof] + (alone ? 1 : n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StiffnessPattern(const Model *m, const State *state, Contacts *contacts, const Stiffness *s,
                                Mat matrix)
{
  const PetscInt at = 3 * m->rigid.n;
  Meetings x;
  PetscInt *start, *meeting, most, *column, *row_start, *all;
  PetscSegBuffer columns;
  PetscFunctionBeginUser;
  PetscCall(meetings_create(m, state, contacts, &x));
  PetscCall(meetings_of_nodes(m, &x, &start, &meeting, &most));
  PetscCall(PetscMalloc2(3 * most, &column, m->n_dof + 1, &row_start));
  PetscCall(PetscSegBufferCreate(sizeof(PetscInt), 64 * 1024, &columns));
  row_start[0] = 0;
  for (PetscInt i = 0; i < m->rigid.n + m->mesh.n_deformable; i++) { // in the order of the rows
    const PetscBool rigid = (PetscBool)(i < m->rigid.n);
    const PetscInt node = rigid ? m->mesh.n_deformable + i : i - m->rigid.n,
                   dof = rigid ? 3 * i : at + 2 * node;
    PetscInt n = 0;
    PetscCall(node_columns(s, &x, start[node + 1] - start[node], meeting + start[node], &n, column));
    for (PetscInt a = 0; a < (rigid ? 3 : 2); a++)
      PetscCall(add_row(m, s, dof + a, n, column, row_start, columns));
  }
  PetscCall(PetscSegBufferExtractInPlace(columns, &all));
  PetscCall(MatSeqAIJSetPreallocationCSR(matrix, row_start, all, NULL));
  PetscCall(MatMPIAIJSetPreallocationCSR(matrix, row_start, all, NULL));
  PetscCall(PetscSegBufferDestroy(&columns));
  PetscCall(PetscFree2(column, row_start));
  PetscCall(PetscFree2(start, meeting));
  PetscCall(PetscFree(x.start));
  PetscCall(PetscFree(x.vertex));
  PetscFunctionReturn(PETSC_SUCCESS);
}

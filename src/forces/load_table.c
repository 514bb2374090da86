/* load_table.c: lists the force of each load of a stage on each face, for results.h5. */
#include "forces/forces.h"

static int compare_rows(const void *a, const void *b)
{
  const LoadOnFace *p = a, *q = b;
  if (p->load != q->load) return p->load < q->load ? -1 : 1;
  if (p->face != q->face) return p->face < q->face ? -1 : 1;
  return (p->place > q->place) - (p->place < q->place);
}

/* Lists the rows of this rank. f: vertex array for forces that nobody reads. */
static PetscErrorCode list_rows(const TermView *view, PetscReal *f)
{
  PetscFunctionBeginUser;
  view->faces->n = 0;
  for (PetscInt i = 0; i < view->stage->n_loads; i++) {
    view->faces->load = view->stage->loads[i];
    PetscCall(TermApplied(view, view->faces->load, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode fill(PetscInt n, const LoadOnFace *rows, TermTable *table)
{
  static const TermColumn columns[] = {
      {"load", 1, NULL}, {"face", 2, NULL}, {"point", 4, NULL}, {"force", 4, NULL}};
  PetscFunctionBeginUser;
  PetscCall(TermTableCreate("loads", n, sizeof columns / sizeof *columns, columns, table));
  for (PetscInt i = 0; i < n; i++) {
    table->columns[0].values[i] = rows[i].load;
    for (PetscInt k = 0; k < 2; k++)
      table->columns[1].values[2 * i + k] = k ? rows[i].face % 4 : rows[i].face / 4;
    for (PetscInt k = 0; k < 4; k++) table->columns[2].values[4 * i + k] = rows[i].point[k];
    for (PetscInt k = 0; k < 4; k++) table->columns[3].values[4 * i + k] = rows[i].force[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadsTable(const TermView *view, TermTable *table)
{
  const Model *m = view->m;
  LoadsOnFaces mine = {.n = 0};
  TermView of = *view;
  LoadOnFace *all;
  PetscReal *f;
  PetscInt n;
  PetscFunctionBeginUser;
  of.faces = &mine;
  PetscCall(PetscCalloc1(2 * (m->mesh.n_vertices + DUMMY_VERTICES), &f));
  PetscCall(list_rows(&of, f));
  PetscCall(PetscMalloc1(mine.n + 1, &mine.rows));
  PetscCall(list_rows(&of, f));
  PetscCall(GatherBytes(m->comm, mine.n, sizeof(LoadOnFace), mine.rows, &n, (void **)&all));
  *table = (TermTable){.name = "loads"};
  if (!m->rank && n) {
    qsort(all, n, sizeof(LoadOnFace), compare_rows);
    PetscCall(fill(n, all, table));
  }
  PetscCall(PetscFree(all));
  PetscCall(PetscFree(mine.rows));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

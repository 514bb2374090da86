/* tables.c: creates the tables of terms in results.h5, and keeps the force of a load on a face for one. */
#include "term/term.h"

PetscErrorCode TermTableCreate(const char *name, PetscInt n_rows, PetscInt n_columns,
                               const TermColumn *columns, TermTable *table)
{
  PetscFunctionBeginUser;
  *table = (TermTable){.name = name, .n_rows = n_rows, .n_columns = n_columns};
  for (PetscInt c = 0; c < n_columns; c++) {
    table->columns[c] = columns[c];
    PetscCall(PetscMalloc1(n_rows * columns[c].width, &table->columns[c].values));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void LoadOnFaceKeep(const TermView *v, PetscInt face, const PetscReal point[4], const PetscReal force[4])
{
  const Model *m = v->m;
  const PetscReal *f = force;
  if (!v->faces || m->faces.vertex[2 * face] >= m->mesh.n_owned || FaceAbsent(m, face)) return;
  if (f[0] == 0. && f[1] == 0. && f[2] == 0. && f[3] == 0.) return; // a dry face
  if (v->faces->rows) {
    LoadOnFace *row = v->faces->rows + v->faces->n;
    row->load = v->faces->load, row->face = m->faces.gid[face], row->place = v->faces->n;
    for (int k = 0; k < 4; k++) row->point[k] = point[k], row->force[k] = force[k];
  }
  v->faces->n++;
}

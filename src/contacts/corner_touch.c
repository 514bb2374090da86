/* corner_touch.c: warns of corners that touch a slanted face at the start. Faces are in contact within 20
   degrees of each other; a corner on a face is a contact with variable connectivity only. */
#include "contacts/contacts.h"
#include "contacts/find.h"

/* Returns the first stage with fixed connectivity, NULL: none. */
static const Stage *fixed_stage(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].connectivity != CONNECTIVITY_VARIABLE) return scene->stages + s;
  return NULL;
}

/* Collective. Finds the contacts of vertices that a search would find now, beside the contacts of faces. */
static PetscErrorCode find_corners(const Scene *scene, const Model *m, CandidateList *corners)
{
  const Contacts none = {0};
  CandidateList faces = {0};
  OldContacts old;
  FaceTable table;
  PetscFunctionBeginUser;
  PetscCall(FaceTableCreate(m, NULL, PETSC_FALSE, &table));
  PetscCall(ContactsFind(scene, m, NULL, &table, &faces));
  PetscCall(CornersHide(scene, m, &table, &faces));
  for (PetscInt p = 0; p < table.start[m->faces.n]; p++)
    if (table.touch[p] & TOUCHES) table.touch[p] |= TOUCHED; // they carry the corners at their ends
  PetscCall(OldContactsCreate(&none, &old));
  PetscCall(VerticesFind(scene, m, &old, &table, corners));
  PetscCall(OldContactsDestroy(&old));
  PetscCall(FaceTableDestroy(&table));
  PetscCall(PetscFree(faces.item));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A corner as the warning reports it. */
typedef struct {
  PetscInt vertex, body[2]; /* number in the file; macroblocks */
  PetscReal X[2];           /* [m] */
} Corner;

PetscErrorCode CornersReport(const Scene *scene, const Model *m)
{
  static PetscInt warned;
  const Stage *stage = fixed_stage(scene);
  CandidateList list = {0};
  Corner *mine, *all;
  PetscInt n = 0, first = 0;
  PetscFunctionBeginUser;
  if (AlreadyWarned(&warned) || !stage) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_corners(scene, m, &list));
  PetscCall(PetscMalloc1(list.n, &mine));
  for (PetscInt i = 0; i < list.n; i++) {
    const PetscInt v = list.item[i].vertex;
    if (v < m->mesh.n_owned)
      mine[n++] = (Corner){m->mesh.vertex_file[v],
                           {m->mesh.vertex_body[v], m->faces.body[list.item[i].face[1]]},
                           {m->mesh.X[2 * v], m->mesh.X[2 * v + 1]}};
  }
  PetscCall(GatherToAll(m->comm, n, sizeof(Corner), mine, &n, (void **)&all));
  for (PetscInt i = 1; i < n; i++)
    if (all[i].vertex < all[first].vertex) first = i;
  if (n && !m->rank) {
    Warn("%s: %" PetscInt_FMT " corner%s of blocks touch%s a face that no face of the corner "
         "is parallel to, first vertex %" PetscInt_FMT " at (%.6g, %.6g) m, of macroblock %" PetscInt_FMT
         ", on macroblock %" PetscInt_FMT ": with fixed connectivity (stage %s) that is no contact and bears "
         "nothing: expected contact.connectivity: variable",
         scene->file, n, Plural(n), n == 1 ? "es" : "", all[first].vertex, (double)all[first].X[0],
         (double)all[first].X[1], all[first].body[0], all[first].body[1], stage->name);
  }
  PetscCall(PetscFree(mine));
  PetscCall(PetscFree(all));
  PetscCall(PetscFree(list.item));
  PetscFunctionReturn(PETSC_SUCCESS);
}

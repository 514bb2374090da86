/* output_selection.c: selects the gathered results that are written: all but blocks of groups with `output:
   false`, vertices of only such blocks, and contacts between such blocks. Rank 0 only. Everything else
   (history, probes, summary, checksum, checkpoints) is of the whole model. */
#include "output/output.h"

/* Numbers the selected rows in their order. from: (kept,) the old rows. */
static PetscErrorCode keep_rows(PetscInt n, const PetscBool *stays, PetscInt *kept, PetscInt **from,
                                PetscInt **row)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n + 1, from));
  PetscCall(PetscMalloc1(n + 1, row));
  *kept = 0;
  for (PetscInt i = 0; i < n; i++) {
    (*row)[i] = stays[i] ? *kept : -1;
    if (stays[i]) (*from)[(*kept)++] = i;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputSelectionCreate(const Scene *scene, const MeshFields *all, OutputSelection *w)
{
  MeshFields *some = &w->mesh;
  PetscBool *block, *vertex;
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(w, sizeof(*w)));
  *some = *all;
  for (PetscInt g = 0; g < scene->n_materials; g++)
    w->partly = (PetscBool)(w->partly || !scene->materials[g].output);
  if (!w->partly) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc2(all->n_blocks, &block, all->n_vertices, &vertex));
  for (PetscInt b = 0; b < all->n_blocks; b++) {
    block[b] = scene->materials[all->group[b]].output;
    for (int k = 0; k < 4 && block[b]; k++)
      if (all->blocks[4 * b + k] >= 0) vertex[all->blocks[4 * b + k]] = PETSC_TRUE;
  }
  PetscCall(keep_rows(all->n_blocks, block, &some->n_blocks, &w->block, &w->block_row));
  PetscCall(keep_rows(all->n_vertices, vertex, &some->n_vertices, &w->vertex, &w->vertex_row));
  PetscCall(PetscFree2(block, vertex));

  PetscCall(PetscMalloc1(2 * some->n_vertices, &some->X));
  PetscCall(PetscMalloc4(4 * some->n_blocks, &some->blocks, some->n_blocks, &some->group, some->n_blocks,
                         &some->macroblock, some->n_blocks, &some->rank));
  for (PetscInt i = 0; i < some->n_vertices; i++)
    PetscCall(PetscArraycpy(some->X + 2 * i, all->X + 2 * w->vertex[i], 2));
  for (PetscInt i = 0; i < some->n_blocks; i++) {
    const PetscInt b = w->block[i];
    some->group[i] = all->group[b], some->macroblock[i] = all->macroblock[b], some->rank[i] = all->rank[b];
    for (int k = 0; k < 4; k++) {
      const PetscInt v = all->blocks[4 * b + k];
      some->blocks[4 * i + k] = v < 0 ? -1 : w->vertex_row[v];
    }
  }
  some->file = NULL; // is ordered by gid, for the whole mesh only
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputSelectionDestroy(OutputSelection *w)
{
  PetscFunctionBeginUser;
  if (!w->partly) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(w->mesh.X));
  PetscCall(PetscFree4(w->mesh.blocks, w->mesh.group, w->mesh.macroblock, w->mesh.rank));
  PetscCall(PetscFree(w->block));
  PetscCall(PetscFree(w->block_row));
  PetscCall(PetscFree(w->vertex));
  PetscCall(PetscFree(w->vertex_row));
  w->partly = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Picks the rows `from` of a table with rows of `unit` bytes; NULL stays NULL. some: the
   pointer to the table. */
static PetscErrorCode pick(PetscInt n, const PetscInt *from, size_t unit, const void *all, void *some)
{
  char *picked = NULL;
  PetscFunctionBeginUser;
  if (all) PetscCall(PetscMalloc1((size_t)n * unit + 1, &picked));
  for (PetscInt i = 0; i < n && all; i++)
    PetscCall(PetscMemcpy(picked + (size_t)i * unit, (const char *)all + (size_t)from[i] * unit, unit));
  *(void **)some = picked;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Selects the contacts with a selected face or vertex, with the numbers of the selection. */
static PetscErrorCode pick_contacts(const OutputSelection *w, const StageFields *all, StageFields *some)
{
  PetscFunctionBeginUser;
  some->n_contacts = 0;
  PetscCall(PetscMalloc1(all->n_contacts + 1, &some->contact));
  some->envelope_contact = NULL;
  if (all->envelope_contact) PetscCall(PetscMalloc1(all->n_contacts + 1, &some->envelope_contact));
  for (PetscInt i = 0; i < all->n_contacts; i++) {
    ContactRow *row = some->contact + some->n_contacts;
    *row = all->contact[i];
    for (int k = 0; k < 2; k++) {
      const PetscInt face = row->face[k], at = face < 0 ? w->vertex_row[-2 - face] : w->block_row[face / 4];
      row->face[k] = at < 0 ? FACE_NOT_WRITTEN : face < 0 ? -2 - at : 4 * at + face % 4;
    }
    if (some->envelope_contact)
      PetscCall(PetscArraycpy(some->envelope_contact + some->n_contacts, all->envelope_contact + i, 1));
    some->n_contacts += row->face[0] != FACE_NOT_WRITTEN || row->face[1] != FACE_NOT_WRITTEN;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SelectedStage(const OutputSelection *w, const StageFields *all, StageFields *some)
{
  const PetscInt nb = w->mesh.n_blocks, nv = w->mesh.n_vertices;
  PetscFunctionBeginUser;
  *some = *all;
  if (!w->partly) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(pick(nv, w->vertex, sizeof(*all->vertex), all->vertex, &some->vertex));
  PetscCall(pick(nv, w->vertex, 2 * sizeof(*all->mechanism), all->mechanism, &some->mechanism));
  PetscCall(pick(nv, w->vertex, 2 * (size_t)all->n_modes * sizeof(*all->modes), all->modes, &some->modes));
  PetscCall(pick(nb, w->block, sizeof(*all->block), all->block, &some->block));
  PetscCall(pick(nb, w->block, sizeof(*all->safety), all->safety, &some->safety));
  PetscCall(pick(nb, w->block, sizeof(*all->envelope_block), all->envelope_block, &some->envelope_block));
  PetscCall(pick(nb, w->block, sizeof(*all->safety_mode), all->safety_mode, &some->safety_mode));
  PetscCall(pick_contacts(w, all, some));
  some->body = NULL; // no written result needs it
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SelectedStageDestroy(const OutputSelection *w, StageFields *some)
{
  PetscFunctionBeginUser;
  if (w->partly) PetscCall(GatherStageDestroy(some));
  PetscFunctionReturn(PETSC_SUCCESS);
}

uint64_t OutputSelectionChecksum(const OutputSelection *w)
{
  return w->partly ? HashBytes(1, w->block, (size_t)w->mesh.n_blocks * sizeof(PetscInt)) : 0;
}

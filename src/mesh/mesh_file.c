/* mesh_file.c: reads model.h5 (docs/mesh_format.md). It is the only C file that knows the format. hdf5.c
   reads the content and trusts nothing; check.c decides whether it makes sense. */
#include "mesh/mesh.h"
#include "base/memory.h"
#include "mesh/hdf5.h"
#include "base/shared.h"
#include <sys/stat.h>
#include <unistd.h>

static void check_header(FileReader *r)
{
  char format[NAME_LENGTH] = "";
  long long version = 0;

  if (!ReaderSound(r)) return;
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, sizeof format);
  if (!ReaderAttribute(r, "format", H5T_STRING, text, format))
    ReaderFault(r, "attribute format is missing or not fixed-length bytes, expected 'quoin-mesh'");
  else if (strcmp(format, "quoin-mesh"))
    ReaderFault(r, "attribute format is '%.63s', expected 'quoin-mesh'", format);
  else if (!ReaderAttribute(r, "version", H5T_INTEGER, H5T_NATIVE_LLONG, &version))
    ReaderFault(r, "attribute version is missing or not an integer, expected 1");
  else if (version != 1)
    ReaderFault(r, "attribute version is %lld, expected 1", version);
  H5Tclose(text);
}

/* ---- the whole mesh */

/* Finds counts and names; every dataset is inspected. */
static PetscErrorCode inspect(FileReader *r, BlockMesh *mesh)
{
  PetscInt n_rows;
  char path[2 * NAME_LENGTH];

  PetscFunctionBegin;
  check_header(r);
  ReaderInspect(r, "/vertices", ITEM_REAL, 2, &mesh->n_vertices);
  ReaderInspect(r, "/blocks", ITEM_INT, 4, &mesh->n_blocks);
  ReaderInspect(r, "/block_group", ITEM_INT, 0, &n_rows);
  if (n_rows != mesh->n_blocks)
    ReaderFault(r, "/block_group has %" PetscInt_FMT " rows, /blocks has %" PetscInt_FMT, n_rows,
                mesh->n_blocks);
  /* every vertex belongs to a block, so there are too many vertices: the message is better before they are
     read */
  if (mesh->n_vertices / 4 > mesh->n_blocks)
    ReaderFault(
        r, "%" PetscInt_FMT " vertices are too many for %" PetscInt_FMT " blocks: some vertex is in no block",
        mesh->n_vertices, mesh->n_blocks);
  ReaderInspect(r, "/groups/name", ITEM_NAME, 0, &mesh->n_groups);
  ReaderInspect(r, "/groups/rigid", ITEM_INT, 0, &n_rows);
  if (n_rows != mesh->n_groups)
    ReaderFault(r, "/groups/rigid has %" PetscInt_FMT " rows, /groups/name has %" PetscInt_FMT, n_rows,
                mesh->n_groups);

  ReaderMembers(r, "/face_sets", "face set", &mesh->n_face_sets, &mesh->face_set_names);
  PetscCall(PetscCalloc1(mesh->n_face_sets, &mesh->face_sets));
  for (PetscInt s = 0; s < mesh->n_face_sets && ReaderSound(r); s++) {
    memcpy(mesh->face_sets[s].name, mesh->face_set_names[s], NAME_LENGTH);
    snprintf(path, sizeof path, "/face_sets/%s", mesh->face_set_names[s]);
    ReaderInspect(r, path, ITEM_INT, 2, &mesh->face_sets[s].n);
  }
  ReaderMembers(r, "/points", "point", &mesh->n_points, &mesh->point_names);
  for (PetscInt p = 0; p < mesh->n_points && ReaderSound(r); p++) {
    snprintf(path, sizeof path, "/points/%s", mesh->point_names[p]);
    ReaderInspect(r, path, ITEM_INT, 0, &n_rows);
    if (n_rows != 1)
      ReaderFault(r, "dataset %s: expected int32 (1,), found (%" PetscInt_FMT ",)", path, n_rows);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates and reads what inspect has found. */
static PetscErrorCode read_arrays(FileReader *r, BlockMesh *mesh)
{
  char path[2 * NAME_LENGTH];

  PetscFunctionBegin;
  if (!ReaderSound(r)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(2 * (size_t)mesh->n_vertices, &mesh->X));
  ReaderNumbers(r, "/vertices", ITEM_REAL, mesh->X);
  PetscCall(PetscMalloc1(4 * (size_t)mesh->n_blocks, &mesh->blocks));
  ReaderNumbers(r, "/blocks", ITEM_INT, mesh->blocks);
  PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->block_group));
  ReaderNumbers(r, "/block_group", ITEM_INT, mesh->block_group);
  PetscCall(PetscCalloc1(mesh->n_groups, &mesh->group_names));
  PetscCall(ReaderNames(r, "/groups/name", mesh->n_groups, mesh->group_names));
  PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_rigid));
  ReaderNumbers(r, "/groups/rigid", ITEM_INT, mesh->group_rigid);
  for (PetscInt g = 0; g < mesh->n_groups && ReaderSound(r);
       g++) /* checked here, because a scene may override the flags before MeshCheck */
    if (mesh->group_rigid[g] != 0 && mesh->group_rigid[g] != 1)
      ReaderFault(r, "group '%s': rigid is %" PetscInt_FMT ", expected 0 or 1", mesh->group_names[g],
                  mesh->group_rigid[g]);
  for (PetscInt s = 0; s < mesh->n_face_sets; s++) {
    PetscCall(PetscMalloc1(2 * (size_t)mesh->face_sets[s].n, &mesh->face_sets[s].faces));
    snprintf(path, sizeof path, "/face_sets/%s", mesh->face_set_names[s]);
    ReaderNumbers(r, path, ITEM_INT, mesh->face_sets[s].faces);
  }
  PetscCall(PetscMalloc1(mesh->n_points, &mesh->point_vertex));
  for (PetscInt p = 0; p < mesh->n_points; p++) {
    snprintf(path, sizeof path, "/points/%s", mesh->point_names[p]);
    ReaderNumbers(r, path, ITEM_INT, &mesh->point_vertex[p]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides whether the model fits into memory; asked before anything is allocated for it. */
static PetscBool fits_memory(FileReader *r, const BlockMesh *mesh, PetscMPIInt size, PetscMPIInt local)
{
  const double needed = MemoryNeeded(mesh->n_vertices, mesh->n_blocks, size, local),
               available = MemoryAvailable();
  if (!ReaderSound(r) || needed <= available) return PETSC_TRUE;
  ReaderFault(r,
              "%" PetscInt_FMT " vertices and %" PetscInt_FMT
              " blocks on %d rank%s need about %.3g GB of memory, "
              "%.3g GB are available",
              mesh->n_vertices, mesh->n_blocks, size, Plural(size), 1e-9 * needed, 1e-9 * available);
  return PETSC_FALSE;
}

static PetscErrorCode read_file(const char *file, PetscMPIInt size, PetscMPIInt local, BlockMesh *mesh,
                                PetscBool *fits, char *message)
{
  FileReader r = {.path = file, .message = message};
  struct stat status;
  H5E_auto2_t print;
  void *print_data;

  PetscFunctionBegin;
  message[0] = 0;
  if (stat(file, &status))
    ReaderFault(&r,
                "no such file%s; a block mesh is written by the mesh.py of an example or by a generator "
                "(docs/generators.md)",
                file[0] == '/' ? "" : " in the working directory or beside the scene");
  else if (!S_ISREG(status.st_mode))
    ReaderFault(&r, "not a file");
  else if (access(file, R_OK))
    ReaderFault(&r, "no permission to read it");
  if (!ReaderSound(&r)) PetscFunctionReturn(PETSC_SUCCESS);

  /* HDF5's own report of an error is a page long and tells the user nothing */
  H5Eget_auto2(H5E_DEFAULT, &print, &print_data);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  r.file = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (r.file < 0) {
    ReaderFault(&r, "not an HDF5 file, or cut off");
  } else {
    PetscCall(inspect(&r, mesh));
    *fits = fits_memory(&r, mesh, size, local);
    if (*fits) PetscCall(read_arrays(&r, mesh));
    H5Fclose(r.file);
  }
  H5Eset_auto2(H5E_DEFAULT, print, print_data);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode set_file_numbers(BlockMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->n_blocks, &mesh->block_file));
  PetscCall(PetscMalloc1(mesh->n_vertices, &mesh->vertex_file));
  for (PetscInt b = 0; b < mesh->n_blocks; b++) mesh->block_file[b] = b;
  for (PetscInt v = 0; v < mesh->n_vertices; v++) mesh->vertex_file[v] = v;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shares counts, names and the groups' rigid flags, which all ranks need to understand the scene. */
static PetscErrorCode share_names(MPI_Comm comm, PetscMPIInt rank, BlockMesh *mesh)
{
  PetscInt counts[4] = {mesh->n_groups, mesh->n_face_sets, mesh->n_points, mesh->n_bodies};

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(counts, 4, MPIU_INT, 0, comm));
  mesh->n_groups = counts[0];
  mesh->n_face_sets = counts[1];
  mesh->n_points = counts[2];
  mesh->n_bodies = counts[3];
  if (rank) {
    PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_names));
    PetscCall(PetscMalloc1(mesh->n_groups, &mesh->group_rigid));
    PetscCall(PetscMalloc1(mesh->n_face_sets, &mesh->face_set_names));
    PetscCall(PetscMalloc1(mesh->n_points, &mesh->point_names));
    PetscCall(PetscCalloc1(mesh->n_face_sets, &mesh->face_sets));
  }
  PetscCallMPI(MPI_Bcast(mesh->group_names, NAME_LENGTH * mesh->n_groups, MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->group_rigid, mesh->n_groups, MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->face_set_names, NAME_LENGTH * mesh->n_face_sets, MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(mesh->point_names, NAME_LENGTH * mesh->n_points, MPI_CHAR, 0, comm));
  if (rank)
    for (PetscInt s = 0; s < mesh->n_face_sets; s++)
      memcpy(mesh->face_sets[s].name, mesh->face_set_names[s], NAME_LENGTH);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshRead(MPI_Comm comm, const char *file, BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";
  PetscMPIInt rank, size, local;
  PetscBool fits = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(mesh, sizeof *mesh));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(SharedRanks(comm, &local));
  if (rank == 0) {
    PetscCall(read_file(file, size, local, mesh, &fits, message));
    if (message[0]) {
      PetscCall(MeshDestroy(mesh));
    } else {
      PetscCall(set_file_numbers(mesh));
      PetscCall(MeshBodies(mesh));
    }
  }
  PetscCallMPI(MPI_Bcast(&fits, 1, MPI_PETSC_BOOL, 0, comm));
  PetscCall(Refuse(comm, fits ? PETSC_ERR_USER_INPUT : ERROR_MEMORY, message));
  PetscCall(share_names(comm, rank, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the memory again, because separated blocks need more of it than the mesh in the file. */
PetscErrorCode MeshTakeApart(MPI_Comm comm, const Scene *scene, BlockMesh *mesh)
{
  char message[MESSAGE_LENGTH] = "";
  FileReader r = {.path = scene->model, .message = message};
  PetscMPIInt rank, size, local;
  PetscBool *separate, any = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc1(mesh->n_groups, &separate));
  for (PetscInt g = 0; g < mesh->n_groups; g++) {
    separate[g] = (PetscBool)!scene->materials[g].macroblocks;
    any = (PetscBool)(any || separate[g]);
  }
  if (any) {
    PetscCall(SharedRanks(comm, &local));
    if (rank == 0) PetscCall(MeshSeparate(mesh, separate));
    if (rank == 0) fits_memory(&r, mesh, size, local);
    PetscCall(Refuse(comm, ERROR_MEMORY, message));
  }
  PetscCall(PetscFree(separate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MeshDestroy(BlockMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->X));
  PetscCall(PetscFree(mesh->blocks));
  PetscCall(PetscFree(mesh->block_group));
  PetscCall(PetscFree(mesh->body));
  PetscCall(PetscFree(mesh->part));
  PetscCall(PetscFree(mesh->block_file));
  PetscCall(PetscFree(mesh->vertex_file));
  PetscCall(PetscFree(mesh->group_names));
  PetscCall(PetscFree(mesh->group_rigid));
  for (PetscInt s = 0; s < mesh->n_face_sets && mesh->face_sets; s++)
    PetscCall(PetscFree(mesh->face_sets[s].faces));
  PetscCall(PetscFree(mesh->face_sets));
  PetscCall(PetscFree(mesh->face_set_names));
  PetscCall(PetscFree(mesh->point_names));
  PetscCall(PetscFree(mesh->point_vertex));
  PetscCall(PetscMemzero(mesh, sizeof *mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

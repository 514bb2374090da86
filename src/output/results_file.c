/* results_file.c: writes results.h5 (docs/results_format.md). This is the only C file that knows the format.
   Rank 0 only, through the serial HDF5 interface. */
#include "output/output.h"
#include "output/hdf5_disk.h"
#include "output/hdf5_write.h"
#include "output/results_there.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { REPLACED = -1 }; /* instead of an errno: results.h5 is not the file that the run has written */

/* ---- the mesh part */

static int write_topology(hid_t group, const MeshFields *mesh)
{
  enum { XDMF_TRIANGLE = 4, XDMF_QUADRILATERAL = 5 };
  PetscInt n = 0, *topology = malloc((XdmfTopologySize(mesh) + 1) * sizeof(*topology));
  if (!topology) return -1;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt *v = mesh->blocks + 4 * b;
    topology[n++] = v[3] < 0 ? XDMF_TRIANGLE : XDMF_QUADRILATERAL;
    for (int k = 0; k < 4; k++) {
      if (v[k] >= 0) topology[n++] = v[k];
    }
  }
  const int error = Hdf5WriteInts(group, "xdmf_topology", n, 0, topology);
  free(topology);
  return error;
}

static int write_mesh(hid_t file, const ResultsFile *results)
{
  const Scene *scene = results->scene;
  const Model *model = results->model;
  const MeshFields *mesh = &results->written.mesh;
  const hsize_t dims[2] = {mesh->n_vertices, 2};
  const hid_t group = H5Gcreate2(file, "mesh", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  char(*joints)[NAME_LENGTH] = calloc(scene->n_joints + 1, NAME_LENGTH);
  int error = group < 0 || !joints;
  for (PetscInt j = 0; !error && j < scene->n_joints; j++) strcpy(joints[j], scene->joints[j].name);
  error = error || Hdf5WriteReals(group, "vertices", 2, dims, mesh->X) ||
          Hdf5WriteInts(group, "blocks", mesh->n_blocks, 4, mesh->blocks) ||
          Hdf5WriteInts(group, "block_group", mesh->n_blocks, 0, mesh->group) ||
          Hdf5WriteInts(group, "macroblock", mesh->n_blocks, 0, mesh->macroblock) ||
          Hdf5WriteInts(group, "rank", mesh->n_blocks, 0, mesh->rank) ||
          Hdf5WriteNames(group, "group_names", model->materials.n_groups, model->materials.names) ||
          Hdf5WriteInts(group, "group_rigid", model->materials.n_groups, 0, model->materials.rigid) ||
          Hdf5WriteNames(group, "joint_names", scene->n_joints, joints) || write_topology(group, mesh);
  if (!error && results->written.partly)
    error = Hdf5WriteInts(group, "block_file", mesh->n_blocks, 0, results->written.block) ||
            Hdf5WriteInts(group, "vertex_file", mesh->n_vertices, 0, results->written.vertex);
  free(joints);
  if (group >= 0) H5Gclose(group);
  return -error;
}

/* ---- a stage */

static int write_stage_attributes(hid_t group, PetscInt stage, PetscInt frame, PetscReal time,
                                  const StageResult *result)
{
  return Hdf5WriteCount(group, "index", stage) || Hdf5WriteCount(group, "frame", frame) ||
         Hdf5WriteNumber(group, "time", time) ||
         Hdf5WriteText(group, "verdict", frame ? "running" : VerdictNames[result->verdict]) ||
         Hdf5WriteText(group, "evidence", frame ? "" : result->evidence) ||
         Hdf5WriteCount(group, "cycles", result->cycles) || Hdf5WriteNumber(group, "ratio", result->ratio);
}

/* Writes a member of VertexRow, (n_vertices, 2). */
static int write_vertex(hid_t group, const char *name, hsize_t nv, const PetscReal first[2])
{
  const hsize_t dims[2] = {nv, 2};
  return Hdf5WriteMember(group, name, 2, dims, first, sizeof(VertexRow), sizeof(PetscReal));
}

/* Writes a member of BlockRow, (n_blocks,) or (n_blocks, parts). */
static int write_block(hid_t group, const char *name, hsize_t nb, hsize_t parts, const PetscReal *first)
{
  const hsize_t dims[2] = {nb, parts};
  return Hdf5WriteMember(group, name, parts > 1 ? 2 : 1, dims, first, sizeof(BlockRow), sizeof(PetscReal));
}

/* Writes a result of material laws, if some block has it. */
static int write_law(hid_t group, const char *name, hsize_t nb, const PetscReal *first)
{
  return BlocksHave((PetscInt)nb, first) ? write_block(group, name, nb, 1, first) : 0;
}

static int write_laws(hid_t group, hsize_t nb, const BlockRow *block)
{
  int error = 0;
  for (int k = 0; k < LAW_MEASURES && !error; k++)
    error = write_law(group, LawMeasure((MaterialLaw)(k + 1)), nb, block->measure + k);
  return error || write_law(group, "crack_width", nb, &block->crack_width) ||
         write_law(group, "lost", nb, &block->lost);
}

static int write_body_fields(hid_t group, const Scene *scene, const MeshFields *mesh,
                             const StageFields *fields)
{
  const hsize_t nv = mesh->n_vertices, nb = mesh->n_blocks, plane[2] = {nv, 2}, gauss[3] = {nb, 4, 3};
  const BlockRow *block = fields->block;
  return write_vertex(group, "displacement", nv, fields->vertex->u) ||
         write_block(group, "stress", nb, 3, block->stress) || write_block(group, "s1", nb, 1, &block->s1) ||
         write_block(group, "s2", nb, 1, &block->s2) || write_block(group, "angle", nb, 1, &block->angle) ||
         write_block(group, "rotation", nb, 1, &block->rotation) ||
         Hdf5WriteMember(group, "gauss_stress", 3, gauss, block->gauss, sizeof(*block),
                         sizeof(block->gauss[0])) ||
         (SceneBuilds(scene) && write_block(group, "built", nb, 1, &block->built)) ||
         (SceneHasHeat(scene) && write_block(group, "temperature", nb, 1, &block->warmer)) ||
         (SceneHasHeat(scene) && scene->plane == PLANE_STRAIN &&
          write_block(group, "stress_z", nb, 1, &block->stress_z)) ||
         write_laws(group, nb, block) ||
         (fields->safety && (Hdf5WriteReals(group, "safety_factor", 1, &nb, fields->safety) ||
                             Hdf5WriteInts(group, "safety_mode", nb, 0, fields->safety_mode))) ||
         (fields->mechanism && Hdf5WriteReals(group, "mechanism", 2, plane, fields->mechanism));
}

/* Writes a dataset (n_contacts,) or (n_contacts, 2 ends) of a member of ContactRow or ContactEnd. */
static int write_contact_ints(hid_t group, const char *name, const StageFields *fields, int columns,
                              size_t offset, size_t stride)
{
  const PetscInt n = fields->n_contacts;
  PetscInt *copy = malloc((columns * (size_t)n + 1) * sizeof(*copy));
  if (!copy) return -1;
  for (PetscInt i = 0; i < n; i++) {
    const char *row = (const char *)&fields->contact[i] + offset;
    for (int k = 0; k < columns; k++) copy[columns * i + k] = *(const PetscInt *)(row + k * stride);
  }
  const int error = Hdf5WriteInts(group, name, n, columns > 1 ? columns : 0, copy);
  free(copy);
  return error;
}

/* Writes a member of ContactEnd. width: its reals; 1 makes (n_contacts, 2 ends), 2 makes (n_contacts, 2 ends,
   2). */
static int write_end_reals(hid_t group, const char *name, const StageFields *fields, int width, size_t offset)
{
  const hsize_t dims[3] = {fields->n_contacts, 2, 2};
  const char *first = (const char *)fields->contact + offsetof(ContactRow, end) + offset;
  return Hdf5WriteMember(group, name, 1 + width, dims, first, sizeof(ContactRow), sizeof(ContactEnd));
}

static int write_faces_lengths(hid_t group, const StageFields *fields)
{
  const hsize_t n = fields->n_contacts;
  PetscInt *face = malloc((4 * n + 1) * sizeof(*face));
  int error = !face;
  for (hsize_t i = 0; !error && i < n; i++) {
    for (int k = 0; k < 2; k++) {
      const PetscInt number = fields->contact[i].face[k]; // -2 - vertex where a vertex stands on a face
      face[4 * i + 2 * k] = number >= 0 ? number / 4 : number == FACE_NOT_WRITTEN ? -2 : -1;
      face[4 * i + 2 * k + 1] = number >= 0 ? number % 4 : number == FACE_NOT_WRITTEN ? -2 : -2 - number;
    }
  }
  error = error || Hdf5WriteInts(group, "face", n, 4, face) ||
          Hdf5WriteMember(group, "length", 1, &n, &fields->contact->length, sizeof(ContactRow), 0) ||
          Hdf5WriteMember(group, "open", 1, &n, &fields->contact->open, sizeof(ContactRow), 0);
  free(face);
  return -error;
}

static int any_closure(const StageFields *fields)
{
  for (PetscInt i = 0; i < fields->n_contacts; i++)
    if (fields->contact[i].end[0].closure < 0. || fields->contact[i].end[1].closure < 0.) return 1;
  return 0;
}

static int write_contacts(hid_t stage, const StageFields *fields)
{
  const size_t ends = offsetof(ContactRow, end);
  const hid_t group = H5Gcreate2(stage, "contacts", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (group < 0) return -1;
  const int error = write_faces_lengths(group, fields) ||
                    write_contact_ints(group, "joint", fields, 1, offsetof(ContactRow, joint), 0) ||
                    write_contact_ints(group, "class", fields, 1, offsetof(ContactRow, klass), 0) ||
                    write_contact_ints(group, "macroblock", fields, 2, offsetof(ContactRow, body),
                                       sizeof(PetscInt)) ||
                    write_contact_ints(group, "state", fields, 2, ends + offsetof(ContactEnd, state),
                                       sizeof(ContactEnd)) ||
                    write_end_reals(group, "point", fields, 2, offsetof(ContactEnd, point)) ||
                    write_end_reals(group, "displacement", fields, 2, offsetof(ContactEnd, displacement)) ||
                    write_end_reals(group, "normal", fields, 2, offsetof(ContactEnd, normal)) ||
                    write_end_reals(group, "opening", fields, 1, offsetof(ContactEnd, opening)) ||
                    write_end_reals(group, "sliding", fields, 1, offsetof(ContactEnd, sliding)) ||
                    write_end_reals(group, "slip", fields, 1, offsetof(ContactEnd, slip)) ||
                    write_end_reals(group, "broken", fields, 1, offsetof(ContactEnd, broken)) ||
                    write_end_reals(group, "sigma", fields, 1, offsetof(ContactEnd, sigma)) ||
                    write_end_reals(group, "tau", fields, 1, offsetof(ContactEnd, tau)) ||
                    write_end_reals(group, "force", fields, 2, offsetof(ContactEnd, force));
  const int last = error || !any_closure(fields)
                       ? error
                       : write_end_reals(group, "closure", fields, 1, offsetof(ContactEnd, closure));
  H5Gclose(group);
  return last;
}

/* ---- whose a file is */

/* Writes the number of the run, also into a file that a branch has taken over. */
static int write_run(hid_t file, const ResultsFile *results)
{
  if (H5Aexists(file, "run") > 0 && H5Adelete(file, "run") < 0) return -1;
  return Hdf5WriteAttribute(file, "run", H5T_STD_U64LE, H5T_NATIVE_UINT64, &results->run);
}

/* ---- whole files */

/* Closes a file. error: an earlier write has failed. */
static void close_written(hid_t file, int error, const char *path, char message[MESSAGE_LENGTH])
{
  const int why = file < 0 ? errno : DiskFileClose(file);
  if ((error || why) && !message[0])
    snprintf(message, MESSAGE_LENGTH, "output: cannot write '%.700s': %s", path,
             why ? strerror(why) : "HDF5 refuses");
}

PetscErrorCode ResultsFileCreate(ResultsFile *results, char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN + 64];
  hid_t file;
  PetscFunctionBeginUser;
  snprintf(path, sizeof(path), "%s/results.h5.part", results->folder);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  file = DiskFileCreate(path);
  int error = file < 0 || Hdf5WriteText(file, "format", "quoin-results") ||
              Hdf5WriteCount(file, "version", 2) || Hdf5WriteText(file, "title", results->scene->title) ||
              Hdf5WriteText(file, "scene", results->scene->file) ||
              Hdf5WriteText(file, "model", results->scene->model) || write_run(file, results) ||
              Hdf5WriteNumber(file, "thickness", results->scene->thickness) || write_mesh(file, results);
  const hid_t stages = error ? -1 : H5Gcreate2(file, "stages", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  error = error || stages < 0;
  if (stages >= 0) H5Gclose(stages);
  close_written(file, error, path, message);
  results->has_part = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forgets the grids of stages that results.h5 does not have. Returns whether it has any. */
static PetscErrorCode forget_stages(ResultsFile *results, PetscInt n, PetscBool *holds,
                                    char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN + 64];
  PetscBool *lost;
  PetscFunctionBeginUser;
  snprintf(path, sizeof(path), "%s/results.h5", results->folder);
  PetscCall(PetscCalloc1(n + 1, &lost));
  const hid_t file = n ? DiskFileRead(path) : -1;
  if (n && file < 0) (void)FileUnreadable(path, errno, message);
  const PetscInt n_lost = ResultsStagesLost(results, file, n, lost);
  if (file >= 0) H5Fclose(file);
  *holds = PETSC_FALSE;
  for (PetscInt s = 0; s < n && !message[0]; s++) {
    if (!lost[s] && file >= 0 && XdmfHas(results, s, 0)) *holds = PETSC_TRUE;
    for (PetscInt frame = 0; frame <= results->scene->stages[s].frames && lost[s]; frame++)
      XdmfDrop(results, s, frame);
  }
  if (n_lost && !message[0])
    Warn("restart: '%s' does not hold the stages up to the checkpoint, or is damaged: "
         "%" PetscInt_FMT " are lost; it %s",
         path, n_lost, *holds ? "goes on with the others" : "starts again");
  PetscCall(PetscFree(lost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forgets the grids of frames whose files are missing. */
static PetscErrorCode forget_frames(ResultsFile *results, PetscInt stage, char message[MESSAGE_LENGTH])
{
  PetscBool *lost;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(results->n_frames + 1, &lost));
  const PetscInt n_lost = ResultsFramesLost(results, stage, lost, message);
  for (PetscInt frame = 1; frame <= results->n_frames && !message[0]; frame++)
    if (lost[frame - 1]) XdmfDrop(results, stage, frame);
  if (n_lost && !message[0])
    Warn("restart: '%s' does not hold %" PetscInt_FMT " of the %" PetscInt_FMT
         " frames of stage %s up to the checkpoint: results.h5 goes on without them",
         results->folder, n_lost, results->n_frames, results->scene->stages[stage].name);
  PetscCall(PetscFree(lost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultsFileResume(ResultsFile *results, PetscInt n, char message[MESSAGE_LENGTH])
{
  PetscBool holds;
  PetscFunctionBeginUser;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  PetscCall(forget_stages(results, n, &holds, message));
  if (!message[0]) PetscCall(forget_frames(results, n, message));
  if (!message[0] && !holds) PetscCall(ResultsFileCreate(results, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes stages from this one on, which a run before a restart has written. */
static int drop_stages(const ResultsFile *results, hid_t stages, PetscInt stage)
{
  char name[NAME_LENGTH + 16];
  int error = 0;
  for (; stage < results->scene->n_stages; stage++)
    for (PetscInt frame = 0; frame <= results->scene->stages[stage].frames; frame++) {
      ResultsGroupName(results, stage, frame, name);
      if (H5Lexists(stages, name, H5P_DEFAULT) > 0) error = H5Ldelete(stages, name, H5P_DEFAULT) < 0 || error;
    }
  return -error;
}

/* Moves frames to their stage, except those that a restart has not found. */
static int copy_frames(const ResultsFile *results, hid_t stages, PetscInt stage)
{
  char name[NAME_LENGTH + 16], within[2 * NAME_LENGTH], message[MESSAGE_LENGTH] = "";
  int error = 0;
  for (PetscInt frame = 1; frame <= results->n_frames && !error; frame++) {
    if (!XdmfHas(results, stage, frame)) continue;
    ResultsGroupName(results, stage, frame, name);
    const hid_t file = ResultsOpenFrame(results, name, within, message);
    error = file < 0 || H5Ocopy(file, within, stages, name, H5P_DEFAULT, H5P_DEFAULT) < 0;
    if (file >= 0) H5Fclose(file);
  }
  return -error;
}

static void remove_frames(ResultsFile *results, PetscInt stage)
{
  char name[NAME_LENGTH + 16], path[PETSC_MAX_PATH_LEN + 2 * NAME_LENGTH];
  for (PetscInt frame = 1; frame <= results->n_frames; frame++) {
    ResultsGroupName(results, stage, frame, name);
    snprintf(path, sizeof(path), "%s/%s.h5", results->folder, name);
    unlink(path);
  }
  results->n_frames = 0;
}

/* Checks whether the copy is the file of this run, with all stages before this one. */
static PetscErrorCode check_copy(const ResultsFile *results, hid_t file, PetscInt stage, PetscBool *good)
{
  PetscBool *lost;
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(stage + 1, &lost));
  *good = (PetscBool)(ResultsOfThisRun(file, results) && !ResultsStagesLost(results, file, stage, lost));
  PetscCall(PetscFree(lost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens a copy of the finished file as the .part of the next stages, so that results.h5 is complete at any
   time. It stays open until ResultsFileFinish. */
static PetscErrorCode open_unfinished(ResultsFile *results, PetscInt stage, int *error)
{
  char path[PETSC_MAX_PATH_LEN + 64], part[PETSC_MAX_PATH_LEN + 64];
  PetscBool good = PETSC_TRUE;
  const PetscBool copied = (PetscBool)!results->has_part;
  PetscFunctionBeginUser;
  snprintf(path, sizeof(path), "%s/results.h5", results->folder);
  snprintf(part, sizeof(part), "%s/results.h5.part", results->folder);
  *error = copied && FileCopy(path, part);
  if (*error) PetscFunctionReturn(PETSC_SUCCESS);
  errno = 0;
  good = (PetscBool)(!copied || DiskFileIsWhole(part));
  const int why = errno;
  results->has_part = good;
  results->part = good ? DiskFileOpen(part) : 0;
  if (copied && results->part > 0) PetscCall(check_copy(results, results->part, stage, &good));
  if (!good) results->failed = why ? why : REPLACED;
  *error = !good || results->part < 0 || write_run(results->part, results);
  const hid_t stages = *error ? -1 : H5Gopen2(results->part, "stages", H5P_DEFAULT);
  *error = stages < 0 || drop_stages(results, stages, stage);
  if (stages >= 0) H5Gclose(stages);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the group of a stage or frame below `stages`, with its grids; returns 0 or -1. */
static PetscErrorCode write_stage(ResultsFile *results, hid_t stages, PetscInt stage, PetscInt frame,
                                  const StageResult *result, const StageFields *fields, int *error)
{
  char name[NAME_LENGTH + 16];
  StageFields some;
  PetscFunctionBeginUser;
  PetscCall(SelectedStage(&results->written, fields, &some));
  ResultsGroupName(results, stage, frame, name);
  const hid_t group = stages < 0 ? -1 : H5Gcreate2(stages, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  *error = group < 0 || write_stage_attributes(group, stage, frame, fields->time, result) ||
           write_body_fields(group, results->scene, &results->written.mesh, &some) ||
           write_contacts(group, &some) ||
           ResultsTablesWrite(group, results->scene, results->written.mesh.n_vertices, &some) ||
           ResultsEnvelopeWrite(group, results->written.mesh.n_blocks, &some) ||
           XdmfAddStage(results, stage, frame, name, &some);
  if (group >= 0) H5Gclose(group);
  PetscCall(SelectedStageDestroy(&results->written, &some));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultsFileFrame(ResultsFile *results, PetscInt stage, PetscInt frame,
                                const StageResult *result, const StageFields *fields,
                                char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN + 2 * NAME_LENGTH], name[NAME_LENGTH + 16], file_name[NAME_LENGTH + 32];
  int error;
  PetscFunctionBeginUser;
  ResultsGroupName(results, stage, frame, name);
  snprintf(file_name, sizeof(file_name), "%s.h5", name);
  snprintf(part, sizeof(part), "%s/%s.part", results->folder, file_name);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  const hid_t file = DiskFileCreate(part);
  const hid_t root = file < 0 || write_run(file, results) ? -1 : H5Gopen2(file, "/", H5P_DEFAULT);
  PetscCall(write_stage(results, root, stage, frame, result, fields, &error));
  if (root >= 0) H5Gclose(root);
  close_written(file, error, part, message);
  PartRename(results->folder, file_name, message);
  results->n_frames = frame;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the checksum of the state at the end of a stage, by which summary.json is compared with the file. */
static int write_checksum(const ResultsFile *results, hid_t stages, PetscInt stage, uint64_t checksum)
{
  char hex[32];
  const hid_t group = H5Gopen2(stages, results->scene->stages[stage].name, H5P_DEFAULT);
  snprintf(hex, sizeof(hex), "%016llx", (unsigned long long)checksum);
  const int error = group < 0 || Hdf5WriteText(group, "checksum", hex);
  if (group >= 0) H5Gclose(group);
  return -error;
}

PetscErrorCode ResultsFileStage(ResultsFile *results, PetscInt stage, const StageResult *result,
                                uint64_t checksum, const StageFields *fields)
{
  PetscFunctionBeginUser;
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  errno = 0;
  int error = 0;
  if (results->part <= 0) PetscCall(open_unfinished(results, stage, &error));
  const hid_t stages = error ? -1 : H5Gopen2(results->part, "stages", H5P_DEFAULT);
  if (!results->failed && (stages < 0 || copy_frames(results, stages, stage)))
    results->failed = errno ? errno : EIO;
  PetscCall(write_stage(results, stages, stage, 0, result, fields, &error));
  if (!error) error = write_checksum(results, stages, stage, checksum);
  if (error && !results->failed) results->failed = errno ? errno : EIO;
  if (stages >= 0) H5Gclose(stages);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ResultsFileFinish(ResultsFile *results, PetscInt stage, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN + 64];
  if (!results->part && !results->failed) return; // stages that were skipped have added nothing
  snprintf(part, sizeof(part), "%s/results.h5.part", results->folder);
  if (results->failed == REPLACED && !message[0])
    snprintf(
        message, MESSAGE_LENGTH,
        "output: '%.700s/results.h5' is not what this run has written: somebody has replaced or damaged it",
        results->folder);
  errno = results->failed;
  close_written(results->part > 0 ? results->part : -1, results->failed, part, message);
  results->part = 0, results->failed = 0;
  PartRename(results->folder, "results.h5", message);
  if (message[0]) return;
  remove_frames(results, stage);
  results->has_part = PETSC_FALSE;
  XdmfWrite(results, message);
}

PetscErrorCode ResultsFileDestroy(ResultsFile *results)
{
  PetscFunctionBeginUser;
  if (results->part > 0) DiskFileClose(results->part);
  free(results->xdmf);
  free(results->grids);
  results->xdmf = NULL, results->grids = NULL, results->n_grids = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

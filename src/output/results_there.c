/* results_there.c: finds the stages in results.h5 and in the files of frames, for a run that continues them.
   Rank 0 only. */
#include "output/output.h"
#include "output/hdf5_disk.h"
#include "output/results_there.h"
#include <errno.h>

enum { PATH_LENGTH = PETSC_MAX_PATH_LEN + 2 * NAME_LENGTH };

void ResultsGroupName(const ResultsFile *results, PetscInt stage, PetscInt frame, char name[NAME_LENGTH + 16])
{
  snprintf(name, NAME_LENGTH, "%s", results->scene->stages[stage].name);
  if (frame) snprintf(name + strlen(name), 16, "_%d", (int)frame);
}

/* Decides whether the file belongs to this run. Many scenes have the same names of stages, so the checksum of
   mesh and options decides. A run that continues with other options takes over the file of its checkpoint's
   run. */
PetscBool ResultsOfThisRun(hid_t file, const ResultsFile *results)
{
  uint64_t run = 0;
  const hid_t attribute = H5Aexists(file, "run") > 0 ? H5Aopen(file, "run", H5P_DEFAULT) : -1;
  const hid_t space = attribute < 0 ? -1 : H5Aget_space(attribute);
  const int error = space < 0 || H5Sget_simple_extent_npoints(space) != 1 ||
                    H5Aread(attribute, H5T_NATIVE_UINT64, &run) < 0;
  if (space >= 0) H5Sclose(space);
  if (attribute >= 0) H5Aclose(attribute);
  return (PetscBool)(!error && (run == results->run || run == results->origin));
}

PetscInt ResultsStagesLost(const ResultsFile *results, hid_t file, PetscInt n, PetscBool *lost)
{
  const hid_t stages = file < 0 ? -1 : H5Gopen2(file, "stages", H5P_DEFAULT);
  PetscInt n_lost = 0;
  for (PetscInt s = 0; s < n; s++) {
    const char *name = results->scene->stages[s].name;
    if (results->stages && !results->stages[s]) continue; // the stage was skipped
    lost[s] = (PetscBool)(XdmfHas(results, s, 0) &&
                          (stages < 0 || H5Lexists(stages, name, H5P_DEFAULT) <= 0));
    n_lost += lost[s];
  }
  if (stages >= 0) H5Gclose(stages);
  return n_lost;
}

static hid_t open_with(const ResultsFile *results, const char *path, const char *group,
                       char message[MESSAGE_LENGTH])
{
  hid_t file = DiskFileRead(path);
  if (file < 0) (void)FileUnreadable(path, errno, message);
  if (file >= 0 && (!ResultsOfThisRun(file, results) || H5Lexists(file, group, H5P_DEFAULT) <= 0)) {
    H5Fclose(file);
    file = -1;
  }
  return file;
}

hid_t ResultsOpenFrame(const ResultsFile *results, const char *name, char within[2 * NAME_LENGTH],
                       char message[MESSAGE_LENGTH])
{
  char path[PATH_LENGTH];
  snprintf(path, sizeof(path), "%s/%s.h5", results->folder, name);
  snprintf(within, 2 * NAME_LENGTH, "/%s", name);
  const hid_t file = open_with(results, path, within, message);
  if (file >= 0 || message[0]) return file;
  snprintf(path, sizeof(path), "%s/results.h5", results->folder);
  snprintf(within, 2 * NAME_LENGTH, "/stages/%s", name);
  return open_with(results, path, within, message);
}

PetscInt ResultsFramesLost(const ResultsFile *results, PetscInt stage, PetscBool *lost,
                           char message[MESSAGE_LENGTH])
{
  char name[NAME_LENGTH + 16], within[2 * NAME_LENGTH];
  PetscInt n_lost = 0;
  for (PetscInt frame = 1; frame <= results->n_frames && !message[0]; frame++) {
    lost[frame - 1] = PETSC_FALSE;
    if (!XdmfHas(results, stage, frame)) continue;
    ResultsGroupName(results, stage, frame, name);
    const hid_t file = ResultsOpenFrame(results, name, within, message);
    if (file >= 0) H5Fclose(file);
    lost[frame - 1] = (PetscBool)(file < 0);
    n_lost += file < 0;
  }
  return n_lost;
}

/* Refuses a restart by `auto` that would lose stages or frames that the run has written. A user who names the
   checkpoint has seen the folder. */
static PetscErrorCode check_lost(const ResultsFile *results, hid_t file, PetscInt n,
                                 char message[MESSAGE_LENGTH])
{
  PetscBool *lost;
  PetscFunctionBeginUser;
  if (strcmp(results->scene->restart, "auto")) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(PetscMax(n, results->n_frames) + 1, &lost));
  const PetscInt n_stages = ResultsStagesLost(results, file, n, lost);
  const PetscInt n_frames = n_stages ? 0 : ResultsFramesLost(results, n, lost, message);
  if (!message[0] && n_stages + n_frames)
    snprintf(message, MESSAGE_LENGTH,
             "restart: '%.400s' does not hold %" PetscInt_FMT " of the %s that the run had written up to its "
             "checkpoint (results.h5 is damaged, removed or older): put back what is missing; or name the "
             "checkpoint instead of auto, to go on without; or remove checkpoints/, to begin at the start",
             results->folder, n_stages + n_frames, n_stages ? "stages" : "frames");
  PetscCall(PetscFree(lost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultsFileCheck(const ResultsFile *results, PetscInt n, char message[MESSAGE_LENGTH])
{
  char path[PATH_LENGTH];
  PetscFunctionBeginUser;
  snprintf(path, sizeof(path), "%s/results.h5", results->folder);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  const hid_t file = n ? DiskFileRead(path) : -1;
  if (n && file < 0) (void)FileUnreadable(path, errno, message);
  if (file >= 0 && !ResultsOfThisRun(file, results))
    snprintf(message, MESSAGE_LENGTH,
             "restart: '%.800s' is of another run than the checkpoint: give another folder as output", path);
  if (!message[0]) PetscCall(check_lost(results, file, n, message));
  if (file >= 0) H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

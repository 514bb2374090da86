/* output.c: the output folder: history.csv while the run goes on; results.h5, results.xdmf and summary.json
   at the end of each stage. Files are written as <name>.part and take their name when they are whole. */
#include "internal.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* mkdir -p. */
static int make_folder(const char *path, char message[MESSAGE_LENGTH])
{
  char part[PETSC_MAX_PATH_LEN];
  struct stat status;
  snprintf(part, sizeof(part), "%s", path);
  for (char *end = part + 1;; end++) {
    if (*end && *end != '/') continue;
    const char kept = *end;
    *end = 0;
    if (mkdir(part, 0777) && errno != EEXIST) break;
    *end = kept;
    if (!kept) break;
  }
  if (!stat(path, &status) && S_ISDIR(status.st_mode)) return 0;
  snprintf(message, MESSAGE_LENGTH, "output: cannot make the folder '%.800s': %s", path,
           strerror(errno == EEXIST ? ENOTDIR : errno));
  return -1;
}

/* The input beside the results: scene_echo.yaml. */
static void write_echo(const char *folder, const Scene *scene, char message[MESSAGE_LENGTH])
{
  FILE *f = PartOpen(folder, "scene_echo.yaml", message);
  if (!f) return;
  fputs(scene->echo, f);
  const PetscBool failed = (PetscBool)(ferror(f) != 0);
  if (fclose(f) || failed)
    snprintf(message, MESSAGE_LENGTH, "output: cannot write scene_echo.yaml (is the disk full?)");
  else
    PartRename(folder, "scene_echo.yaml", message);
}

/* Collective. Values of the named points into output->probes, and the largest displacement [m]. */
static PetscErrorCode update_probes(const Model *model, const State *state, Output *output, PetscReal *u_max)
{
  const PetscReal *u = state->u + 3 * model->n_bodies;
  const PetscInt n = 4 * model->n_points;
  PetscReal *all;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n + 1, &all));
  for (PetscInt i = 0; i < n; i++) all[i] = -INFINITY;
  for (PetscInt p = 0; p < model->n_points; p++) {
    const PetscInt v = model->point_vertex[p];
    if (v < 0 || v >= model->n_owned) continue;
    for (int x = 0; x < 2; x++) {
      all[4 * p + x] = model->X[2 * v + x];
      all[4 * p + 2 + x] = u[2 * v + x];
    }
  }
  all[n] = 0;
  for (PetscInt i = 0; i < model->n_owned; i++) {
    const PetscReal square = u[2 * i] * u[2 * i] + u[2 * i + 1] * u[2 * i + 1];
    if (!(square <= all[n])) all[n] = square; // NaN shows
  }
  // one owner per point: the largest is its value
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, (PetscMPIInt)n + 1, MPIU_REAL, MPI_MAX, model->comm));
  PetscCall(PetscArraycpy(output->probes, all, n));
  *u_max = PetscSqrtReal(all[n]);
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a stage runs in time: then history.csv has columns of time and energies. */
static PetscBool in_time(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].kind == STAGE_DYNAMIC) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Energies of a static stage are not accounted for: nan. */
static void history_energies(FILE *f, const Stage *stage, const State *state, const Energies *e)
{
  const PetscReal value[] = {e->strain,   e->joints,  e->outside,   e->supports,
                             e->friction, e->damping, e->detection, e->balance};
  fprintf(f, ",%.10g", state->time);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(value); i++)
    fprintf(f, ",%.10g", stage->kind == STAGE_DYNAMIC ? value[i] : NAN);
}

static void history_header(FILE *f, const Scene *scene, const Model *model)
{
  fprintf(f, "cycle,stage,ramp,ratio,kinetic_J,alpha_per_s,dt_s,alpha_dt,u_max_m");
  if (in_time(scene))
    fprintf(f, ",time_s,strain_J,joints_J,outside_J,supports_J,friction_J,damping_J,detection_J,balance_J");
  for (PetscInt p = 0; p < model->n_points; p++) {
    fprintf(f, ",%s_ux_m,%s_uy_m", model->point_names[p], model->point_names[p]);
  }
  fprintf(f, "\n");
}

PetscErrorCode OutputOpen(const Scene *scene, const Model *model, Output *output)
{
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(output, sizeof(*output)));
  PetscCall(PetscStrncpy(output->folder, scene->output, sizeof(output->folder)));
  PetscCall(PetscCalloc1(4 * model->n_points + 1, &output->probes));
  PetscCall(GatherMesh(model, &output->mesh));
  if (!model->rank) {
    PetscCall(PetscCalloc1(PetscMax(1, scene->n_stages), &output->stages));
    output->results = (ResultsFile){
        .folder = output->folder, .scene = scene, .model = model, .mesh = &output->mesh};
    if (!make_folder(output->folder, message)) write_echo(output->folder, scene, message);
    if (!message[0]) output->history = PartOpen(output->folder, "history.csv", message);
    if (output->history) {
      history_header(output->history, scene, model);
      PetscCall(ResultsFileCreate(&output->results, message));
    }
  }
  PetscCall(CheckMessage(model->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputHistory(Output *output, const Scene *scene, const Model *model, const State *state,
                             PetscInt stage, PetscReal ramp, const StageResult *result)
{
  FILE *f = output->history;
  PetscReal u_max;
  PetscFunctionBeginUser;
  PetscCall(update_probes(model, state, output, &u_max));
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(f, "%lld,%s,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g,%.10g", (long long)state->cycle,
          scene->stages[stage].name, ramp, result->ratio, result->kinetic, state->alpha, state->dt,
          state->alpha * state->dt, u_max);
  if (in_time(scene)) history_energies(f, scene->stages + stage, state, &result->energy);
  for (PetscInt p = 0; p < model->n_points; p++) {
    fprintf(f, ",%.10g,%.10g", output->probes[4 * p + 2], output->probes[4 * p + 3]);
  }
  fprintf(f, "\n");
  fflush(f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputFrame(Output *output, const Scene *scene, const Model *model, const State *state,
                           const Contacts *contacts, PetscInt stage, PetscInt frame,
                           const StageResult *result)
{
  char message[MESSAGE_LENGTH] = "";
  StageFields fields;
  PetscFunctionBeginUser;
  PetscCall(GatherStage(model, state, contacts, &scene->stages[stage], &output->mesh, &fields));
  if (!model->rank) PetscCall(ResultsFileStage(&output->results, stage, frame, result, &fields, message));
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(CheckMessage(model->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputStage(Output *output, const Scene *scene, const Model *model, const State *state,
                           const Contacts *contacts, PetscInt stage, const StageResult *result)
{
  char message[MESSAGE_LENGTH] = "";
  StageFields fields;
  PetscReal u_max;
  uint64_t checksum;
  PetscFunctionBeginUser;
  PetscCall(update_probes(model, state, output, &u_max));
  PetscCall(StateChecksum(model, state, contacts, &checksum));
  PetscCall(GatherStage(model, state, contacts, &scene->stages[stage], &output->mesh, &fields));
  PetscCall(GatherMechanism(model, output->trials.mechanism, &fields));
  if (!model->rank) {
    const PetscInt first = !output->n_stages;
    PetscCall(SafetyFields(scene, &output->mesh, &fields));
    PetscCall(ResultsFileStage(&output->results, stage, 0, result, &fields, message));
    PetscCall(SummaryStage(scene, model, state, &output->mesh, &fields, stage, result, output->probes,
                           checksum, &output->trials, &output->stages[output->n_stages++]));
    PetscCall(SummaryWrite(output->folder, scene, model, &output->mesh, &fields, output->n_stages,
                           output->stages, message));
    if (ferror(output->history) && !message[0])
      snprintf(message, MESSAGE_LENGTH, "output: cannot write history.csv (is the disk full?)");
    if (first) PartRename(output->folder, "history.csv", message);
  }
  PetscCall(GatherStageDestroy(&fields));
  PetscCall(TrialsReset(&output->trials));
  PetscCall(CheckMessage(model->comm, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OutputClose(Output *output)
{
  PetscFunctionBeginUser;
  if (output->history) fclose(output->history);
  for (PetscInt s = 0; s < output->n_stages && output->stages; s++) free(output->stages[s]);
  PetscCall(PetscFree(output->stages));
  PetscCall(PetscFree(output->probes));
  PetscCall(ResultsFileDestroy(&output->results));
  PetscCall(GatherMeshDestroy(&output->mesh));
  output->history = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* condensing.c: chooses which groups are condensed, where the scene leaves materials.<name>.condensed out. A
   condensed body has the answer of its blocks: in small strain to rounding, in large strain to the tolerance
   of the stage (condense_large.c). Where it cannot, the run begins again with the blocks (quoin.c). Every
   bound is from a measurement: docs/performance.md, "Which bodies are condensed".

   The choice depends on the scene and the mesh alone, and on memory, which a checkpoint carries on. */
#include "run/run.h"
#include "base/memory.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Inner degrees of freedom from which a factor and a dense matrix pay: in a scene with trials, which relaxes
   some twenty times, and in one of static stages alone. With fewer there a run takes a tenth of a second. */
enum { LEAST_INNER = 400, LEAST_STATIC = 1500 };
/* Inner degrees of freedom of the bodies of a group over their kept ones. With 2.5 stones gained a third,
   with 0.9 a quarter; with fewer a cycle of the dense matrix costs more than a cycle of the blocks. */
enum { LEAST_SHARE = 2 };
/* Entries of the dense matrices of a group over its inner degrees of freedom. Two slabs on each other, 60 to
   500 blocks long, took 0.6 to 1.0 of the time of their blocks with 14 and 16, 1.2 to 1.4 with 32, 1.9 to 2.2
   with 64, 4 to 7 with 255. Dams on rock have 1 to 2. Matrices that stay in the cache pay anyway. */
enum { MOST_FULL = 20, IN_CACHE = 30000 };
/* Kept degrees of freedom of a body that hold its inside: two vertices. */
enum { HOLDING_DOFS = 4 };

/* Degrees of freedom of a body, or of several. */
typedef struct {
  PetscInt64 kept, inner;
} Size;

/* Returns whether blocks of the group may be condensed. */
static PetscBool can_be(const Material *m)
{
  return (PetscBool)(m->is_open && !m->rigid && m->macroblocks && m->law == MATERIAL_ELASTIC &&
                     PetscIsNanReal(m->k0));
}

/* Finds what forbids large strain, in which a run may have to begin again with the blocks. Temperatures, and
   bodies that stay as in small strain beside those that are corrected, have not been tried. */
static void large_forbids(const Scene *scene, char why[CONDENSING_LENGTH / 2])
{
  const char *what = scene->samples[0] || scene->advise > 0. ? "samples and advice share bodies"
                     : SceneHasHeat(scene)                   ? "temperatures"
                                                             : "";
  for (PetscInt g = 0; g < scene->n_materials; g++)
    if (!scene->materials[g].is_open && scene->materials[g].condensed > 0)
      what = "a group has condensed: true";
  if (what[0]) snprintf(why, CONDENSING_LENGTH / 2, "strain is large: %s", what);
}

/* Finds what in the scene needs the blocks themselves; why receives it. */
static PetscBool scene_forbids(const Scene *scene, char why[CONDENSING_LENGTH / 2])
{
  why[0] = '\0';
  if (scene->strain != STRAIN_SMALL) large_forbids(scene, why);
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages && !why[0]; s++) {
    if (!StageRelaxes(s) || s->kind == STAGE_TRANSIENT || s->kind == STAGE_PUSHOVER)
      snprintf(why, CONDENSING_LENGTH / 2, "stage %s is neither static nor of trials", s->name);
    else if (s->n_build)
      snprintf(why, CONDENSING_LENGTH / 2, "stage %s builds groups", s->name);
    else if (s->connectivity == CONNECTIVITY_VARIABLE)
      snprintf(why, CONDENSING_LENGTH / 2, "stage %s may find contacts again", s->name);
  }
  return (PetscBool)(why[0] != '\0');
}

/* Returns the inner degrees of freedom from which condensing pays for the stages that run. */
static PetscInt least_inner(const Scene *scene)
{
  for (const Stage *s = scene->stages; s < scene->stages + scene->n_stages; s++)
    if (s->kind != STAGE_STATIC) return LEAST_INNER;
  return LEAST_STATIC;
}

/* ---- bodies, on rank 0 */

/* Counts the degrees of freedom of each condensed body. */
static PetscErrorCode measure_bodies(const BlockMesh *mesh, const BodyNumbers *bodies, Size *size)
{
  PetscInt *body_of;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(mesh->n_vertices, &body_of));
  for (PetscInt v = 0; v < mesh->n_vertices; v++) body_of[v] = -1;
  for (PetscInt i = 0; i < 4 * mesh->n_blocks; i++)
    if (mesh->blocks[i] >= 0 && bodies->condensed[i / 4] >= 0)
      body_of[mesh->blocks[i]] = bodies->condensed[i / 4];
  for (PetscInt v = 0; v < mesh->n_vertices; v++)
    if (body_of[v] >= 0) *(bodies->inner[v] ? &size[body_of[v]].inner : &size[body_of[v]].kept) += 2;
  PetscCall(PetscFree(body_of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the bodies of a group pay together, and two kept vertices hold each. counted:
   (n_condensed,) 1 + the last group for which a body was counted. */
static PetscBool pays(const BlockMesh *mesh, const BodyNumbers *bodies, const Size *size, PetscInt g,
                      PetscInt *counted)
{
  Size sum = {0, 0};
  PetscInt64 entries = 0;
  for (PetscInt b = 0; b < mesh->n_blocks; b++) {
    const PetscInt body = bodies->condensed[b];
    if (mesh->block_group[b] != g || body < 0 || counted[body] == g + 1) continue;
    if (size[body].kept < HOLDING_DOFS) return PETSC_FALSE;
    sum.kept += size[body].kept, sum.inner += size[body].inner, counted[body] = g + 1;
    entries += size[body].kept * size[body].kept;
  }
  return (PetscBool)(sum.inner >= LEAST_SHARE * sum.kept &&
                     entries <= PetscMax(MOST_FULL * sum.inner, IN_CACHE));
}

/* Leaves those groups out whose bodies do not pay. open: (n_groups,) groups that are left to the
   program; sum: of all bodies; left_out: whether a group was left out, and sum is out of date. */
static PetscErrorCode leave_out(const BlockMesh *mesh, PetscReal margin, const PetscBool *open, Scene *trial,
                                Size *sum, double *memory, PetscBool *left_out)
{
  BodyNumbers bodies = {0};
  PetscInt *counted;
  Size *size;
  PetscFunctionBeginUser;
  *sum = (Size){0, 0}, *memory = 0., *left_out = PETSC_FALSE;
  PetscCall(MeshCondensed(trial, mesh, margin, &bodies));
  PetscCall(PetscCalloc2(bodies.n_condensed, &size, bodies.n_condensed, &counted));
  PetscCall(measure_bodies(mesh, &bodies, size));
  for (PetscInt g = 0; g < trial->n_materials; g++) {
    if (!open[g] || !trial->materials[g].condensed || pays(mesh, &bodies, size, g, counted)) continue;
    trial->materials[g].condensed = 0, *left_out = PETSC_TRUE;
  }
  for (PetscInt i = 0; i < bodies.n_condensed; i++) {
    sum->kept += size[i].kept, sum->inner += size[i].inner;
    *memory += MemoryOfBody((double)size[i].inner, (double)size[i].kept);
  }
  PetscCall(PetscFree2(size, counted));
  PetscCall(PetscFree(bodies.condensed));
  PetscCall(PetscFree(bodies.inner));
  PetscCall(PetscFree(bodies.calm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses in the copy `trial`, in which every group that may be condensed is. */
static PetscErrorCode choose_groups(const BlockMesh *mesh, const PetscBool *open, Scene *trial, Size *sum,
                                    double *memory)
{
  PetscReal longest, diameter;
  PetscBool left_out = PETSC_TRUE;
  PetscFunctionBeginUser;
  MeshMeasures(mesh, &longest, &diameter);
  const PetscReal margin = trial->contact_tolerance * (trial->contact_relative ? longest : 1.);
  while (left_out) PetscCall(leave_out(mesh, margin, open, trial, sum, memory, &left_out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the choice */

/* Returns whether the program has chosen to condense a group. */
static PetscBool chose(const Scene *scene)
{
  for (PetscInt g = 0; g < scene->n_materials; g++)
    if (scene->materials[g].is_open && scene->materials[g].condensed > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

void CondensingUndo(Condensing *c, const char *why)
{
  for (PetscInt g = 0; g < c->scene->n_materials; g++)
    if (c->scene->materials[g].is_open) c->scene->materials[g].condensed = 0;
  snprintf(c->why, sizeof(c->why), "not condensed: %s; materials.<name>.condensed fixes it", why);
}

void CondensingJoints(Condensing *c)
{
  for (PetscInt s = 0; s < c->scene->n_stages && c->joints; s++)
    memcpy(c->scene->stages[s].joints, c->joints + s * c->scene->n_joints,
           c->scene->n_joints * sizeof(*c->joints));
}

/* Keeps the joints of all stages. */
static PetscErrorCode keep_joints(Condensing *c)
{
  const PetscInt n = c->scene->n_joints;
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n * c->scene->n_stages, &c->joints));
  for (PetscInt s = 0; s < c->scene->n_stages; s++)
    PetscCall(PetscArraycpy(c->joints + s * n, c->scene->stages[s].joints, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void CondensingNote(const Condensing *c, Model *m)
{
  m->condensed.chosen = chose(c->scene), m->condensed.large = SceneCorrects(c->scene);
  memcpy(m->condensed.why, c->why, sizeof(c->why));
}

void CondensingCopy(const Scene *from, Scene *scene)
{
  for (PetscInt g = 0; g < scene->n_materials; g++)
    if (scene->materials[g].is_open) scene->materials[g].condensed = from->materials[g].condensed;
}

/* Writes which groups are condensed, or why none is. */
static void describe(const Scene *scene, const PetscBool *open, const Size *sum, const char *forbids,
                     char why[CONDENSING_LENGTH])
{
  char names[CONDENSING_LENGTH / 2] = "";
  size_t used = 0;
  for (PetscInt g = 0; g < scene->n_materials; g++) {
    if (!open[g] || !scene->materials[g].condensed || used >= sizeof(names)) continue;
    used += snprintf(names + used, sizeof(names) - used, "%s%s", used ? ", " : "", scene->materials[g].name);
  }
  if (used)
    snprintf(why, CONDENSING_LENGTH,
             "condensed: %s, %lld inner degrees of freedom onto %lld; materials.<name>.condensed fixes it",
             names, (long long)sum->inner, (long long)sum->kept);
  else
    snprintf(why, CONDENSING_LENGTH, "not condensed: %s; materials.<name>.condensed fixes it", forbids);
}

PetscErrorCode CondensingChoose(MPI_Comm comm, Scene *scene, const BlockMesh *mesh, Condensing *condensing)
{
  const PetscInt n = scene->n_materials;
  char forbids[CONDENSING_LENGTH / 2] = "";
  double memory = 0., asked[2];
  PetscBool *open, fits, any = PETSC_FALSE, lacks = PETSC_FALSE;
  PetscInt *chosen;
  const PetscInt least = least_inner(scene);
  PetscMPIInt rank, ranks;
  Scene trial = *scene;
  Size sum = {0, 0};
  PetscFunctionBeginUser;
  *condensing = (Condensing){.scene = scene};
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(PetscMalloc3(n, &open, n, &chosen, n, &trial.materials));
  PetscCall(PetscArraycpy(trial.materials, scene->materials, n));
  for (PetscInt g = 0; g < n; g++) {
    open[g] = can_be(scene->materials + g), any = (PetscBool)(any || open[g]);
    if (open[g]) trial.materials[g].condensed = 1;
  }
  if (any && !scene_forbids(scene, forbids)) {
    if (!rank) PetscCall(choose_groups(mesh, open, &trial, &sum, &memory));
    if (!sum.inner)
      snprintf(forbids, sizeof(forbids),
               "no group whose bodies have %d inner degrees of freedom for a kept one, "
               "and one for %d entries of their matrices",
               LEAST_SHARE, MOST_FULL);
    else if (sum.inner < least)
      snprintf(forbids, sizeof(forbids), "%lld inner degrees of freedom, fewer than %d", (long long)sum.inner,
               (int)least);
    PetscCallMPI(MPI_Bcast(&memory, 1, MPI_DOUBLE, 0, comm));
    PetscCall(MemoryFits(comm, memory / ranks, asked, &fits));
    lacks = (PetscBool)!fits;
    if (lacks)
      snprintf(forbids, sizeof(forbids), "their factors take about %.3g GB, %.3g GB are available",
               1e-9 * asked[0], 1e-9 * asked[1]);
  }
  for (PetscInt g = 0; g < n; g++)
    chosen[g] = forbids[0] ? PetscMax(0, scene->materials[g].condensed) : trial.materials[g].condensed > 0;
  PetscCallMPI(MPI_Bcast(chosen, (PetscMPIInt)n, MPIU_INT, 0, comm));
  for (PetscInt g = 0; g < n; g++) scene->materials[g].condensed = chosen[g];
  if (any) describe(scene, open, &sum, forbids, condensing->why);
  PetscCallMPI(MPI_Bcast(condensing->why, CONDENSING_LENGTH, MPI_CHAR, 0, comm));
  if (any) PetscCall(keep_joints(condensing));
  condensing->shown = (PetscBool)(chose(scene) || lacks);
  PetscCall(PetscFree3(open, chosen, trial.materials));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints */

static PetscErrorCode archive(Archive *a, void *context)
{
  Condensing *c = context;
  const PetscInt n = c->scene->n_materials;
  PetscInt *groups;
  char *why = strdup(c->why);
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, &groups));
  for (PetscInt g = 0; g < n; g++) groups[g] = c->scene->materials[g].condensed;
  PetscCall(ArchiveInts(a, "groups", n, groups));
  PetscCall(ArchiveText(a, "why", &why));
  for (PetscInt g = 0; g < n && a->reading; g++) {
    Material *m = c->scene->materials + g;
    if (!m->is_open || m->condensed == (groups[g] > 0)) continue;
    m->condensed = groups[g] > 0, c->changed = PETSC_TRUE;
  }
  if (a->reading && why) PetscCall(PetscStrncpy(c->why, why, sizeof(c->why)));
  free(why);
  PetscCall(PetscFree(groups));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CondensingResume(Condensing *c, Checkpoint *checkpoint)
{
  PetscBool kept;
  PetscFunctionBeginUser;
  if (!c->why[0]) PetscFunctionReturn(PETSC_SUCCESS); // nothing is left open
  PetscCall(CheckpointAttach(checkpoint, "condensing", archive, c, &kept));
  if (!checkpoint->resuming || kept || !chose(c->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  CondensingUndo(c, "the run was begun without");
  c->changed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

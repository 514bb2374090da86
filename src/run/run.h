/* run.h: declares what quoin.c, warnings.c and study/ share of a run; all others use include/quoin.h. */
#pragma once
#include "quoin.h"
#include "stages/stages.h"

/* Gives access to the inside of a Quoin, for studies and for the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             struct _p_Relaxation **relax);

/* Keeps the state in memory, with all data of a checkpoint; QuoinGoBack goes back to it. The archive is from
   ArchiveCreate. Both are called before QuoinRun, and only with contacts that stay, no groups that are
   built, no stages that branch. */
PetscErrorCode QuoinKeep(Quoin q, Archive *kept);
PetscErrorCode QuoinGoBack(Quoin q, Archive *kept);
/* Rank 0. Returns the number of a run of this scene and mesh, see CheckpointRun. */
uint64_t QuoinNumber(Quoin q);
/* Reads the scene again with the "-key value" options of argv. They may change numbers that neither mesh,
   contacts nor condensed bodies depend on (SceneVaries). The state then belongs to no scene: go back to a
   kept state. A refused scene leaves everything as it was. */
PetscErrorCode QuoinTakeNumbers(Quoin q, const char *scene_file, int argc, char **argv);

/* ---- condensing.c */
/* Which groups are condensed, of those where the scene leaves it open. */
typedef struct {
  Scene *scene;
  PetscBool shown;   /* a user should know: groups are condensed, or would be if there were memory */
  PetscBool changed; /* a checkpoint has brought in other condensed groups */
  Joint *
      joints; /* (n_stages, n_joints) of the stages as read, where groups are condensed; trials change them */
  char why[CONDENSING_LENGTH]; /* the groups, or what forbids it; empty: no group could be condensed */
} Condensing;
/* Collective. Chooses the groups, and completes the materials of the scene. */
PetscErrorCode CondensingChoose(MPI_Comm comm, Scene *scene, const BlockMesh *mesh, Condensing *condensing);
/* Takes the choice back: the groups stay as they are. */
void CondensingUndo(Condensing *condensing, const char *why);
/* Takes back the joints of the stages as read. */
void CondensingJoints(Condensing *condensing);
/* Notes the choice in a new model. */
void CondensingNote(const Condensing *condensing, Model *model);
/* Takes the choice of the same scene with other numbers. */
void CondensingCopy(const Scene *from, Scene *scene);
/* Collective. Keeps the choice in checkpoints, and takes the choice of the checkpoint of a restart; one of an
   earlier version condenses nothing by itself. */
PetscErrorCode CondensingResume(Condensing *condensing, Checkpoint *checkpoint);

/* ---- check_run.c */
/* Collective. Refuses a faulty mesh, and one with fewer blocks than ranks; gives the warnings of mesh and
   scene. mesh: on rank 0. */
PetscErrorCode MeshCheckRun(MPI_Comm comm, const Scene *scene, const BlockMesh *mesh);

/* ---- completions.c: for SceneRead */
extern const Completions SceneCompletions;

/* ---- cases.c: stages that start from another one than the one before them */
typedef struct {
  const Scene *scene;
  const PetscInt *stage; /* the present stage, or the next one */
  PetscInt at;           /* stage at whose end the state is, or was when the present stage started; -1: the
                            start; -2: no stage from which later ones could start */
  PetscInt *verdict;     /* (n_stages,) Verdict of earlier stages; VERDICT_NONE: not run */
  Archive *kept;         /* (n_stages,) states at the ends of stages from which later ones start; on rank 0 */
} Cases;
PetscErrorCode CasesCreate(MPI_Comm comm, const Scene *scene, const PetscInt *stage, Cases *cases);
PetscErrorCode CasesDestroy(Cases *cases);
/* Archives the cases, for scenes that branch; a checkpoint part after the parts of the run and the state. */
PetscErrorCode CasesArchive(Archive *archive, void *context);
/* Collective. Completes the cases after a restart, with or without this part in the checkpoint. begun: the
   present stage has started. Refuses a checkpoint without the states from which later stages start. */
PetscErrorCode CasesResume(Cases *cases, const Checkpoint *checkpoint, PetscBool resumed, PetscBool begun);
/* Returns whether the stage from which this one starts has ended, without interruption or failure. */
PetscBool CaseCanRun(const Cases *cases, PetscInt stage);
/* Returns whether the state differs from the one from which this stage starts. */
PetscBool CaseIsElsewhere(const Cases *cases, PetscInt stage);
/* Ends the present stage. */
PetscErrorCode CaseEnd(Cases *cases, Verdict verdict);
/* Collective. Keeps the present state, if a later stage starts from it. */
PetscErrorCode CaseKeep(Cases *cases, const Checkpoint *checkpoint);
/* Collective. Reads the state from which the present stage starts into a model built again. */
PetscErrorCode CaseGoBack(Cases *cases, const Checkpoint *checkpoint);
/* Returns the verdict of the run: of the first case that failed. last: verdict of the last stage. */
Verdict CasesVerdict(const Cases *cases, Verdict last);
/* Prints which cases have failed, and which were not run. */
PetscErrorCode CasesReport(const Cases *cases, MPI_Comm comm);

/* ---- warnings.c: rank 0; each warning is given once */
/* Warns of slender blocks: they set the time step and are stiff in bending. mesh NULL: the last mesh. */
void WarnSlender(const BlockMesh *mesh);
/* Warns of full blocks near incompressibility. */
void WarnLocking(const Scene *scene);
/* Warns of stages that the chosen method does not serve. */
void WarnExplicit(const Scene *scene);
/* Warns of joints that have a strength, but no law that uses it. */
void WarnElastic(const Scene *scene);
/* Warns of joints with strength in shear but no stiffness in it. */
void WarnShear(const Scene *scene);
/* Warns of numbers that are likely to be in another unit, and of loads that no stage lists. */
void WarnDoubtful(const Scene *scene);
/* Rank 0. Warns of ice on the wrong side, of water downstream, of galleries above the water, of levels beside
   their faces, and of a mesh of the size of mountains. */
void WarnImplausible(const Scene *scene, const BlockMesh *mesh);
/* Warns of joints that keep a tensile strength beyond the apex of their shear strength. */
void WarnApex(const Scene *scene);
/* Warns of stages in which a material law has no part, and of blocks that cold alone cracks across the
   plane. */
void WarnLaws(const Scene *scene);
/* Gives all these warnings for a scene with other numbers and the same mesh. */
void WarnAgain(const Scene *scene);

/* run.h: what quoin.c, warnings.c and study/ share of a run; everybody else uses include/quoin.h. */
#pragma once
#include "quoin.h"
#include "stages/stages.h"

/* Gives access to the insides of a Quoin, for studies and for the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             struct _p_Relaxation **relax);

/* Keep what a checkpoint keeps of the state, in memory, and go back to it. The archive is from
   ArchiveCreate. Before QuoinRun, and with contacts that stay, no groups that are built, no stages that
   branch. */
PetscErrorCode QuoinKeep(Quoin q, Archive *kept);
PetscErrorCode QuoinGoBack(Quoin q, Archive *kept);
/* Rank 0. The number of a run of this scene and mesh, see CheckpointRun. */
uint64_t QuoinNumber(Quoin q);
/* Reads the scene again with the "-key value" options of argv, which may change numbers that neither mesh,
   contacts nor condensed bodies depend on (SceneVaries). The state is that of no scene then: go back to one
   that was kept. A scene that is refused leaves all as it was. */
PetscErrorCode QuoinTakeNumbers(Quoin q, const char *scene_file, int argc, char **argv);

/* ---- cases.c: stages that start from another one than the one before them */
typedef struct {
  const Scene *scene;
  const PetscInt *stage; /* the stage that runs, or comes next */
  PetscInt at;           /* stage at whose end the state is, or was as the present stage began; -1: the start;
                            -2: at none that later stages could start from */
  PetscInt *verdict;     /* (n_stages,) Verdict of the stages before; VERDICT_NONE: it was not run */
  Archive *kept;         /* (n_stages,) states at the ends of stages that later ones start from; on rank 0 */
} Cases;
PetscErrorCode CasesCreate(MPI_Comm comm, const Scene *scene, const PetscInt *stage, Cases *cases);
PetscErrorCode CasesDestroy(Cases *cases);
/* A checkpoint part, of scenes that branch; behind the parts of the run and the state. */
PetscErrorCode CasesArchive(Archive *archive, void *context);
/* Collective. After a restart, with this part of its checkpoint or without; begun: the present stage has
   begun. Refuses one that lacks what later stages start from. */
PetscErrorCode CasesResume(Cases *cases, const Checkpoint *checkpoint, PetscBool resumed, PetscBool begun);
/* Whether the stage from which this one starts has come to its end, and is not interrupted or failed. */
PetscBool CaseCanRun(const Cases *cases, PetscInt stage);
/* Whether the state is not the one that this stage starts from. */
PetscBool CaseIsElsewhere(const Cases *cases, PetscInt stage);
/* The stage before the present one is over. */
PetscErrorCode CaseEnd(Cases *cases, Verdict verdict);
/* Collective. Keeps the state as it is, where a stage behind the present one starts from it. */
PetscErrorCode CaseKeep(Cases *cases, const Checkpoint *checkpoint);
/* Collective. The state from which the present stage starts is read back into a model built anew. */
PetscErrorCode CaseGoBack(Cases *cases, const Checkpoint *checkpoint);
/* That of the run: of the first case that failed. last: of the last stage. */
Verdict CasesVerdict(const Cases *cases, Verdict last);
/* Says which cases have failed, and which were not run. */
PetscErrorCode CasesReport(const Cases *cases, MPI_Comm comm);

/* ---- warnings.c: rank 0; each is told once */
/* Warns of slender blocks: they set the time step and are stiff in bending. mesh NULL: as of the mesh before.
 */
void WarnSlender(const BlockMesh *mesh);
/* Warns of full blocks near incompressibility. */
void WarnLocking(const Scene *scene);
/* Warns of stages that the chosen method does not serve. */
void WarnExplicit(const Scene *scene);
/* Warns of joints that have a strength, but no law that uses it. */
void WarnElastic(const Scene *scene);
/* Warns of joints with strength in shear but no stiffness in it. */
void WarnShear(const Scene *scene);
/* Warns of numbers that are likely to be in another unit, and tells which loads no stage lists. */
void WarnDoubtful(const Scene *scene);
/* Rank 0. Warns of ice on the wrong side, of water downstream, of galleries above the water, of levels beside
   their faces, and of a mesh of the size of mountains. */
void WarnImplausible(const Scene *scene, const BlockMesh *mesh);
/* Warns of joints that keep a tensile strength beyond the apex of their shear strength. */
void WarnApex(const Scene *scene);
/* Warns of stages in which a material law has no part, and of blocks that cold alone cracks across the
   plane. */
void WarnLaws(const Scene *scene);
/* All of these, of a scene with other numbers and the same mesh. */
void WarnAgain(const Scene *scene);

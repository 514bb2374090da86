/* repartition.h: a run with variable connectivity that is dealt out to the ranks anew
   when blocks have moved. */
#pragma once
#include "archive/checkpoint.h"
#include "stages/stages.h"

typedef struct _p_Repartition {
  PetscBool possible; /* more than one rank, a static or dynamic stage with variable connectivity, no
                         condensed bodies */
  const Scene *scene;
  const Model *model;
  const State *state;
  const Contacts *contacts;
  BlockMesh mesh;                         /* as it was read; rank 0 has blocks and part */
  BodyNumbers bodies;                     /* rank 0 */
  PetscErrorCode (*renew)(void *context); /* builds the model and all that hangs on it from mesh */
  void *context;
  PetscInt64 looked; /* cycle of the last look */
} Repartition;

/* Collective. Keeps the mesh (*mesh is empty then) when the run may be dealt out anew. */
PetscErrorCode RepartitionCreate(const Scene *scene, const Model *model, BlockMesh *mesh,
                                 Repartition *repartition);
PetscErrorCode RepartitionDestroy(Repartition *repartition);
/* Collective, between two cycles, where checkpoints may be written. When scene->repartition_every cycles have
   passed since the last look: a partition for where the blocks are now; if it leaves the busiest rank less to
   do by more than scene->repartition_gain, the run goes on on it, with the same bits. What stages allocate by
   the size of the model must be attached to the checkpoint. */
PetscErrorCode RepartitionPoll(const Problem *p);

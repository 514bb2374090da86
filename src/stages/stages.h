/* stages.h: what a stage is, from begin to verdict. */
#pragma once
#include "solve/solve.h"

/* ---- energy.c */
typedef struct {
  PetscReal *v_before;              /* (n_dof,) velocity before the step */
  PetscReal *f_before;              /* (n_dof,) resisting force with the contacts before a verification */
  PetscReal *f_ext_before;          /* (n_dof,) loads of the step before */
  PetscReal *F_n, *F_s, *d_n, *d_s; /* (contacts as in Contacts) of the cycle before */
  PetscReal *work;                  /* (n_contacts,) [J] of each contact since it is there */
  PetscInt n_contacts;
  PetscReal work_before; /* [J] of contacts that are no more */
  PetscReal kinetic, strain, outside, supports, damping, damping_ahead,
      detection;                           /* [J]; detection is of all ranks */
  PetscReal kinetic_0, strain_0, joints_0; /* [J] at the start, of all ranks */
} EnergyAccount;
PetscErrorCode EnergyCreate(const Model *model, EnergyAccount *e);
PetscErrorCode EnergyDestroy(EnergyAccount *e);
/* Collective, see archive.h. Contacts must have been read back before. */
PetscErrorCode EnergyArchive(struct _p_Archive *archive, const Model *model, const Contacts *contacts,
                             EnergyAccount *e);
/* Works of the contacts over the step that led to the forces just evaluated. */
void EnergyOfContacts(const Model *model, const Contacts *contacts, EnergyAccount *e);
/* Contacts were found anew: half a step's work of what the forces have changed by, from f_before. */
void EnergyOfExchange(const Model *model, const State *state, EnergyAccount *e);
/* Around Integrate: works of loads and supports of the step before; kinetic energy and
   damping at this time. */
void EnergyBeforeStep(const Model *model, const State *state, EnergyAccount *e);
void EnergyAfterStep(const Model *model, const State *state, EnergyAccount *e);
/* The contact arrays are new (forces evaluated): starts their works afresh. */
PetscErrorCode EnergyContactsChanged(const Contacts *contacts, EnergyAccount *e);
/* Strain energy of owned blocks, at the forces just evaluated: before Integrate, when a report follows. */
PetscErrorCode EnergyOfBlocks(const Model *model, const State *state, EnergyAccount *e);
/* Collective. The account at the time of the forces last evaluated. first: the start of the stage. */
PetscErrorCode EnergyReport(const Model *model, const Joint *joints, const Contacts *contacts,
                            EnergyAccount *e, PetscBool first, Energies *out);

/* ---- dynamic.c */
/* Collective. Runs a dynamic stage for its duration. */
PetscErrorCode DynamicRun(const Problem *p);

/* ---- stages.c */
/* Collective. Runs a stage of any kind to its verdict, and tells it. */
PetscErrorCode StageRun(const Problem *p);

/* ---- static.c */
/* Collective. Relaxes under the stage's loads and joints, to a verdict that nobody is told yet: a static
   stage, or one trial of another. */
PetscErrorCode StageRelax(const Problem *p);

/* ---- trial_stage.c */
/* Collective. p->stage->joints are left as in the last stable trial. */
PetscErrorCode ReductionRun(const Problem *p);
PetscErrorCode FloodRun(const Problem *p);

/* ---- repartition.c: a run with variable connectivity that is dealt out to the ranks anew when blocks
   have moved. */
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

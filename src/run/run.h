/* run.h: what quoin.c, warnings.c and study/ share of one run; include/quoin.h is for everybody. */
#pragma once
#include "quoin.h"
#include "stages/stages.h"

/* The insides of a Quoin, for studies, the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             struct _p_Relaxation **relax);

/* ---- warnings.c: rank 0; each is told once */
/* Slender blocks: they set the time step and are stiff in bending. */
void WarnSlender(const BlockMesh *mesh);
/* Full blocks near incompressibility. */
void WarnLocking(const Scene *scene);
/* Stages that the method asked for does not serve. */
void WarnExplicit(const Scene *scene);

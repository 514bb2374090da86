/* run.h: what quoin.c, warnings.c and study/ share of a run; everybody else uses include/quoin.h. */
#pragma once
#include "quoin.h"
#include "stages/stages.h"

/* Gives access to the insides of a Quoin, for studies and for the project's own tests and benchmarks. */
PetscErrorCode QuoinGetParts(Quoin q, Scene **scene, Model **model, State **state, Contacts **contacts,
                             struct _p_Relaxation **relax);

/* ---- warnings.c: rank 0; each is told once */
/* Warns of slender blocks: they set the time step and are stiff in bending. */
void WarnSlender(const BlockMesh *mesh);
/* Warns of full blocks near incompressibility. */
void WarnLocking(const Scene *scene);
/* Warns of stages that the chosen method does not serve. */
void WarnExplicit(const Scene *scene);
/* Warns of joints that have a strength, but no law that uses it. */
void WarnElastic(const Scene *scene);
/* Warns of stages in which a material law has no part. */
void WarnLaws(const Scene *scene);

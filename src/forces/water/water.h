/* water.h: water on faces and in joints. */
#pragma once
#include "forces/blocks/blocks.h"

/* ---- reservoir.c */
void ReservoirForces(const Scene *scene, const Load *load, const Model *model, const PetscReal *u_vertex,
                     PetscReal *f_vertex);
/* Water pressure on one face, see reservoir.c. x: (4) its ends, f: (4) forces at them [N]. */
void WaterOnFace(const PetscReal x[4], PetscReal level, PetscReal rho_g, PetscReal thickness, PetscReal f[4]);

/* ---- uplift.c */
/* Water pressure along a joint: straight lines between points, s[0] = 0 at the heel. */
typedef struct {
  PetscInt n;
  PetscReal s[4], p[4]; /* [m] from the heel, [Pa] */
} UpliftDiagram;
/* A stretch that is open without the full head; from closed_from to it the joint is closed, by `closure` at
   most. */
typedef struct {
  PetscReal from, to, closed_from, closure; /* [m] */
  PetscBool at_toe;
} UpliftDry;
enum { UPLIFT_MOST_DRY = 8 };
typedef struct _p_Uplift {
  PetscReal heel[2], toe[2], length; /* [m] reference; length 0: the load is no uplift */
  PetscReal crack;                   /* [m] from the heel, where the full head acts */
  PetscInt rounds;                   /* of the iteration for it, in this stage */
  PetscInt n_dry;                    /* the first of them; of the last measurement */
  UpliftDry dry[UPLIFT_MOST_DRY];
  PetscInt n_gids, *gids;   /* outer faces in the joint, ascending; the same on all ranks */
  PetscInt n_faces, *faces; /* rows of model->faces, local blocks only, ascending gid */
} Uplift;
/* Collective. Finds the joint lines of the uplift loads; refuses sets that are no
   joint and drains outside. */
PetscErrorCode UpliftCreate(const Scene *scene, const Model *model, const Contacts *contacts, State *state);
PetscErrorCode UpliftDestroy(const Scene *scene, State *state);
/* The diagram of a load whose joint is open from the heel over uplift->crack. */
void UpliftPressure(const Load *load, const Uplift *uplift, PetscReal gravity, UpliftDiagram *diagram);
/* Pressure on one face: s: (2) place of its ends along the joint, x: (4) their
   coordinates, f: (4) forces [N]. */
void UpliftOnFace(const UpliftDiagram *diagram, const PetscReal s[2], const PetscReal x[4],
                  PetscReal thickness, PetscReal f[4]);
/* Start of a stage: the iterations begin anew; cracks of loads that do not act in it close. */
PetscErrorCode UpliftStart(const Scene *scene, const Stage *stage, State *state);
/* Adds the forces of the load to f. u, f: vertex arrays. */
void UpliftForces(const Scene *scene, const Load *load, const Uplift *uplift, const Model *model,
                  const PetscReal *u, PetscReal *f);
/* Collective. Measures the open lengths of the stage's cracked uplift loads. again: one has changed (before
   equilibrium, grown), so the stage must go on; a crack through the joint sets the verdict. */
PetscErrorCode UpliftCrack(const Scene *scene, const Stage *stage, const Model *model,
                           const Contacts *contacts, State *state, StageResult *result, PetscBool *again);
/* Collective. Finds the open stretches of cracked uplift loads that the full head does not reach as joints
   are now; tell: warns of them. */
PetscErrorCode UpliftSurvey(const Scene *scene, const Stage *stage, const Model *model,
                            const Contacts *contacts, State *state, PetscBool tell);

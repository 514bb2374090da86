/* uplift.h: what uplift.c, crack.c, profile.c and uplift_term.c share. */
#pragma once
#include "forces/water/water.h"

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
  PetscReal crack_stable;            /* [m] of the last stable trial */
  PetscInt rounds;                   /* of the iteration for it, in this stage */
  PetscInt n_dry;                    /* the first of them; of the last measurement */
  UpliftDry dry[UPLIFT_MOST_DRY];
  PetscInt n_gids, *gids;   /* outer faces in the joint, ascending; the same on all ranks */
  PetscInt n_faces, *faces; /* rows of model->faces, local blocks only, ascending gid */
} Uplift;
/* Collective. Finds the joint lines of the uplift loads; refuses sets that are no
   joint and drains outside. */
PetscErrorCode UpliftCreate(const Scene *scene, const Model *model, const Contacts *contacts, Uplift **all);
PetscErrorCode UpliftDestroy(const Scene *scene, Uplift **all);
/* The diagram of a load whose joint is open from the heel over uplift->crack. */
void UpliftPressure(const Load *load, const Uplift *uplift, PetscReal gravity, UpliftDiagram *diagram);
/* Pressure on one face: s: (2) place of its ends along the joint, x: (4) their
   coordinates, f: (4) forces [N]. */
void UpliftOnFace(const UpliftDiagram *diagram, const PetscReal s[2], const PetscReal x[4],
                  PetscReal thickness, PetscReal f[4]);
/* Start of a stage: the iterations begin anew; cracks of loads that do not act in it close. */
PetscErrorCode UpliftStart(const TermView *v);
/* Adds the forces of the load to f. u, f: vertex arrays. */
void UpliftForces(const Scene *scene, const Load *load, const Uplift *uplift, const Model *model,
                  const PetscReal *u, PetscReal *f);
/* Collective. Measures the open lengths of the stage's cracked uplift loads. again: one has changed (before
   equilibrium, grown), so the stage must go on; a crack through the joint sets the verdict. */
PetscErrorCode UpliftCrack(const TermView *v, StageResult *result, PetscBool *again);
/* Collective. Finds the open stretches of cracked uplift loads that the full head does not reach as joints
   are now; tell: warns of them. */
PetscErrorCode UpliftSurvey(const TermView *v, PetscBool tell);

/* ---- profile.c */
/* A contact of the joint. */
typedef struct {
  PetscInt key[2];
  PetscReal point[2][2]; /* [m] reference place of its ends */
  PetscReal u_n[2];      /* [m] */
  PetscInt open[2];
} ProfileRow;

/* Collective. Contacts with a face in the ascending list of gids, by their faces; the same on all ranks.
   Free with PetscFree. */
PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows);
/* [m] Place of a point along the chord from the heel. */
PetscReal UpliftPlace(const Uplift *u, const PetscReal X[2]);

/* uplift.h: what uplift.c, crack.c, profile.c and uplift_term.c share. */
#pragma once
#include "water/water.h"

/* ---- uplift.c */
/* Water pressure along a joint: straight lines between n points, the first of them at the heel. */
typedef struct {
  PetscInt n;
  PetscReal s[7], p[7]; /* [m] from the heel, [Pa]; two points at one place: the pressure jumps there */
} UpliftDiagram;
/* A stretch of the joint that is open but does not have the full head. The joint is closed from closed_from
   to `from`, by `closure` at most. */
typedef struct {
  PetscReal from, to, closed_from, closure; /* [m] */
  PetscBool at_toe;
} UpliftDry;
enum { UPLIFT_MOST_DRY = 8 };
typedef struct _p_Uplift {
  PetscReal heel[2], toe[2], length; /* [m] in the reference state; length 0: the load is no uplift */
  PetscBool at_end;                  /* the heel is the end of the joint, not its start */
  PetscReal crack;                   /* [m] length from the heel over which the full head acts */
  PetscReal opened;                  /* [m] how far from the heel an earthquake has opened the joint, where
                                        the rule has no pressure from the crack to there; else 0 */
  PetscReal crack_stable, opened_stable; /* [m] those of the last stable trial */
  PetscInt rounds;                       /* rounds of the iteration for crack in this stage */
  PetscInt n_dry;                        /* dry stretches that the last measurement noted, from the heel on */
  UpliftDry dry[UPLIFT_MOST_DRY];
  PetscInt n_gids, *gids;   /* outer faces in the joint, ascending; the same on all ranks */
  PetscInt n_faces, *faces; /* rows of model->faces, local blocks only, ascending gid */
} Uplift;
/* Collective. Finds the joint line of each uplift load. Refuses face sets that are no joint or no line, and
   drains outside the joint. */
PetscErrorCode UpliftCreate(const Scene *scene, const Model *model, const Contacts *contacts, Uplift **all);
PetscErrorCode UpliftDestroy(const Scene *scene, Uplift **all);
/* The diagram of a load whose joint is open from the heel over uplift->crack. */
void UpliftPressure(const Load *load, const Uplift *uplift, PetscReal gravity, UpliftDiagram *diagram);
/* Finds the forces of the pressure on one face. s: (2) places of its ends along the joint, x: (4) their
   coordinates, f: (4) forces at them [N]. */
void UpliftOnFace(const UpliftDiagram *diagram, const PetscReal s[2], const PetscReal x[4],
                  PetscReal thickness, PetscReal f[4]);
/* At the start of a stage: counts the rounds from zero, and closes the cracks of loads that do not act in the
   stage. */
PetscErrorCode UpliftStart(const TermView *v);
/* What becomes of the pressure in a crack that the earthquake of the stage opens; SHAKEN_FULL: there is no
   earthquake, or the full head follows it. */
UpliftShaken UpliftInEarthquake(const Scene *scene, const Stage *stage, const Load *load);
/* Adds the forces of the load to f. u, f: vertex arrays. */
void UpliftForces(const Scene *scene, const Load *load, const Uplift *uplift, const Model *model,
                  const PetscReal *u, PetscReal *f);
/* Collective. Measures the open lengths of the stage's cracked uplift loads. again: one has changed (before
   equilibrium: one has grown), so the stage must go on. A crack through the joint, or too many rounds, sets
   the verdict. */
PetscErrorCode UpliftCrack(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
/* Collective. Finds the open stretches that the full head does not reach, for the cracked uplift loads and
   joints as they are now. tell: whether to warn of them. */
PetscErrorCode UpliftSurvey(const TermView *v, PetscBool tell);

/* ---- profile.c */
/* A contact of the joint, with both its ends. */
typedef struct {
  PetscInt key[2];
  PetscReal point[2][2]; /* [m] where the ends stand in the reference state */
  PetscReal u_n[2];      /* [m] */
  PetscInt open[2];
} ProfileRow;

/* Collective. Gathers the contacts with a face in the ascending list of gids, in the order of their faces;
   the rows are the same on all ranks. The caller frees them with PetscFree. */
PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows);
/* [m] Distance of a reference point from the heel, along the chord. */
PetscReal UpliftPlace(const Uplift *u, const PetscReal X[2]);

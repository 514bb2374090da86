/* uplift.h: declares uplift pressure in joints, for uplift.c, crack.c, profile.c and uplift_term.c. */
#pragma once
#include "water/water.h"

/* ---- uplift.c */
/* Water pressure along a joint, linear between n points; the first point is the heel. */
typedef struct {
  PetscInt n;
  PetscReal s[7], p[7]; /* [m] from the heel, [Pa]; two points at one place: a jump */
} UpliftDiagram;
/* An open stretch of the joint without the full head. The joint is closed from closed_from to `from`, by
   at most `closure`. */
typedef struct {
  PetscReal from, to, closed_from, closure; /* [m] */
  PetscBool at_toe;
} UpliftDry;
enum { UPLIFT_MOST_DRY = 8 };
typedef struct _p_Uplift {
  PetscReal heel[2], toe[2], length; /* [m] in the reference configuration; length 0: the load is no uplift */
  PetscBool at_end;                  /* the heel is the end of the joint, not its start */
  PetscReal crack;                   /* [m] length from the heel with the full head */
  PetscReal opened;                  /* [m] length that an earthquake has opened, without pressure beyond
                                        the crack; 0: none */
  PetscReal crack_stable, opened_stable; /* [m] values of the last stable trial */
  PetscInt rounds;                       /* rounds of the crack iteration in this stage */
  PetscInt n_dry;                        /* dry stretches of the last measurement, from the heel on */
  UpliftDry dry[UPLIFT_MOST_DRY];
  PetscInt n_gids, *gids;   /* outer faces in the joint, ascending; the same on all ranks */
  PetscInt n_faces, *faces; /* rows of model->faces, local blocks only, ascending gid */
} Uplift;
/* Collective. Finds the joint line of each uplift load. Refuses face sets that are not a joint or not
   straight, and drains outside the joint. */
PetscErrorCode UpliftCreate(const Scene *scene, const Model *model, const Contacts *contacts, Uplift **all);
PetscErrorCode UpliftDestroy(const Scene *scene, Uplift **all);
/* Returns the full head [m] in the crack at the place s [m] of the chord: H1 of the rules, and more where the
   joint falls towards the toe; 0: the level is below the heel, so no water gets in. */
PetscReal UpliftFullHead(const Load *load, const Uplift *uplift, PetscReal s);
/* Computes the pressure diagram of a load whose joint is open from the heel over uplift->crack. */
void UpliftPressure(const Load *load, const Uplift *uplift, PetscReal gravity, UpliftDiagram *diagram);
/* Computes the forces of the pressure on one face. s: (2) positions of its ends along the joint, x: (4)
   their coordinates, f: (4) receives the forces [N]. */
void UpliftOnFace(const UpliftDiagram *diagram, const PetscReal s[2], const PetscReal x[4],
                  PetscReal thickness, PetscReal f[4]);
/* Begins a stage: resets the rounds, and closes the cracks of loads that do not act in the stage. */
PetscErrorCode UpliftStart(const TermView *v);
/* Returns the rule for the pressure in a crack that the earthquake of the stage opens. SHAKEN_FULL: there
   is no earthquake, or the full head enters the crack. */
UpliftShaken UpliftInEarthquake(const Scene *scene, const Stage *stage, const Load *load);
/* Adds the forces [N] of the load to f, a vertex array. */
void UpliftForces(const TermView *v, const Load *load, const Uplift *uplift, PetscReal *f);
/* Collective. Measures the open lengths of the stage's cracked uplift loads. again receives whether one
   has changed (before equilibrium: has grown), so that the stage must go on. Sets the verdict if a crack
   runs through the joint, or after too many rounds. */
PetscErrorCode UpliftCrack(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
/* Collective. Finds the open stretches without the full head, for cracked uplift loads in the present
   state. report: warn of them. */
PetscErrorCode UpliftFindDry(const TermView *v, PetscBool report);

/* ---- profile.c */
/* A contact of the joint with its two ends. */
typedef struct {
  PetscInt key[2];
  PetscReal point[2][2]; /* [m] places of the ends in the reference configuration */
  PetscReal u_n[2];      /* [m] normal displacement, positive: open */
  PetscInt open[2];
} ProfileRow;

/* Collective. Gathers the contacts that have a face in the ascending list of gids, sorted by their faces.
   The rows are the same on all ranks. The caller frees them with PetscFree. */
PetscErrorCode GatherProfile(const Model *m, const Contacts *c, PetscInt n_gids, const PetscInt *gids,
                             PetscInt *n, ProfileRow **rows);
/* Returns the distance [m] of a reference point from the heel, along the chord. */
PetscReal UpliftPlace(const Uplift *u, const PetscReal X[2]);

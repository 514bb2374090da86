/* evaluation.h: declares what force.c and sorted.c share: one evaluation of all contacts. */
#pragma once
#include "contacts/kinematics.h"
#include "contacts/law/stress_models.h"

/* Input and output of one evaluation of all contacts. */
typedef struct {
  const PetscReal *X, *u;
  History from;                /* the history from which it starts */
  PetscReal pull;              /* Contacts.pull; 0 unless it starts from the committed history */
  PetscReal moving, thickness; /* moving: 1 with large strain, 0 with small strain */
  const Joint *joints;
  Contacts *c;
  int keep; /* whether to write the arrays of results */
  PetscReal *f;
} Evaluation;

/* The loop goes over so many contacts at once. Their positions, 5 kB, stay in the first-level cache. */
enum { STRETCH = 64 };

/* End forces of the contacts of a stretch, [N/m] per metre of thickness; [k]: of end k. */
typedef struct {
  PetscReal F_n[2][STRETCH], F_s[2][STRETCH];
} StretchForces;

/* ---- sorted.c */
/* Finds the end forces of contacts of stress model `model` from contact `from` on, and updates their slip;
   friction is drawn towards the law or is springs. Stops before contacts that crush, soften or lose strength,
   at `to` at the latest. places: of the contacts from `from` on; J: joints of the contacts before, and then
   of the last ones looked at; found: its first place is contact `from`. Returns where it stopped. */
PetscInt SortedForces(const Evaluation *of, int model, PetscInt from, PetscInt to, const Place *places,
                      LanesJoint *J, StretchForces *found);

/* stage_result.h: declares the result of one stage or trial: verdict, evidence, effort, and energies. The
   rooms from model/ up fill a StageResult while the stage runs. */
#pragma once
#include "base/base.h"

typedef enum {
  VERDICT_NONE,
  VERDICT_CONVERGED,
  VERDICT_COLLAPSED,
  VERDICT_DIVERGED,
  VERDICT_UNDECIDED,
  VERDICT_INTERRUPTED,
  VERDICT_COMPLETED /* a dynamic stage has run for its whole duration */
} Verdict;

/* Energy account of a dynamic stage [J]. The first four are present values; the others except `yielded` are
   sums since its start. */
typedef struct {
  PetscReal kinetic, strain, joints; /* present values */
  PetscReal water;                   /* kinetic energy of added mass, a part of kinetic */
  PetscReal yielded;                 /* dissipated in anchors that yield or break, since the start of the
                                        run */
  PetscReal outside;                 /* work of applied forces, weight included */
  PetscReal supports;                /* work of moving supports */
  PetscReal incoming, radiated;      /* energy that waves bring in and take out through quiet boundaries */
  PetscReal friction;                /* dissipated in joints, dashpots included: their work less their stored
                                        energy */
  PetscReal damping;                 /* dissipated by alpha and beta */
  PetscReal detection;               /* change of stored joint energy when contacts were verified */
  PetscBool reduced;                 /* condensed bodies lack modes */
  PetscReal truncation[2];           /* [-] error of stresses and of frequencies by these modes; NaN: not
                                        known */
  PetscReal frequency_ratio;         /* [-] mean frequency of kept vertices over the first one left out */
  PetscReal balance;                 /* energy that came in, less the energy present or lost; 0 is exact */
  PetscReal moved; /* scale of the balance: energy that came in, was in motion, or was given by stored
                        energy */
} Energies;

/* Why a stage took its method, where relaxation.method is auto; method.c. */
typedef enum {
  CHOICE_GIVEN, /* the user has chosen the method */
  CHOICE_ELASTIC,
  CHOICE_FEW_BODIES,
  CHOICE_SMALL,
  CHOICE_MANY_BODIES,
  CHOICE_MANY_STONES,
  CHOICE_RUBBLE,
  CHOICE_CRACKS,
  CHOICE_VARIABLE,
  CHOICE_DAMPING,
  CHOICE_YIELDS,
  CHOICE_BREAKS,
  CHOICE_WATER,
  CHOICE_HANDED_OVER,
  CHOICE_PUSHED,
  CHOICE_LEFT
} MethodReason;
/* Why explicit cycles did a stage of stiffness_mass again: no end, a jump of blocks, a divergence. */
typedef enum { LEFT_ENDLESS, LEFT_JUMPED, LEFT_DIVERGED, LEFT_REASONS } LeftFor;
typedef struct {
  PetscInt64 reason;             /* a MethodReason */
  PetscInt64 dofs, bodies;       /* degrees of freedom; bodies at contacts that can fail */
  PetscInt64 limit;              /* what dofs or bodies was compared with */
  PetscInt64 given_up, spent;    /* times that Newton's method handed over; [cycles] its work the last time,
                                 0: it had no factor */
  PetscInt64 left[LEFT_REASONS]; /* times that explicit cycles did it again, by LeftFor */
  PetscInt64 crept;              /* [cycles] explicit ones of the stage, after which stiffness_mass went on;
                                    0: it did not, -1: it had no factor */
  PetscInt64 stalled; /* [cycles] those of stiffness_mass, at whose first stall explicit ones went on;
                                    0: they did not */
  PetscReal order;    /* [-] four-fold order of the stones, contacts/stone_order.c; 0: not asked */
} MethodChoice;

/* The effort of a stage, with all its trials. */
typedef struct {
  PetscInt64 evaluations; /* number of evaluations of all forces of the model */
  PetscInt64 solves;      /* number of solves with a factor of the stiffness */
  PetscInt64 factorisations;
  PetscBool preconditioned, stiffness_mass, explicit; /* which methods ran */
  PetscBool fixed, variable;                          /* whether contacts were kept, and found again */
  PetscReal outgrown[3]; /* x, y [m] and travel [-] of the first contact that left its range; 0 [-]: none */
  PetscInt64 wanted, available; /* [byte] memory of a factor that was not made for lack of memory: needed,
                                   available; 0: none */
  MethodChoice choice;
} Effort;

enum { EVIDENCE_LENGTH = PETSC_MAX_PATH_LEN + 256 }; /* the evidence may name a checkpoint */

typedef struct {
  Verdict verdict;
  char evidence[EVIDENCE_LENGTH]; /* the reason for the verdict, in one line of numbers */
  PetscInt64 cycles;              /* of this stage: force evaluations of its explicit loop, and iterations */
  Effort effort;                  /* what the stage cost */
  PetscReal ratio;                /* [-] largest unbalanced ratio over bodies */
  PetscInt worst_body;            /* macroblock with that ratio */
  PetscReal increment;    /* [-] largest displacement increment of a cycle over largest displacement */
  PetscReal kinetic;      /* [J] with the scaled masses */
  double wall;            /* [s] */
  PetscReal displacement; /* [m] largest displacement */
  PetscBool finite;       /* forces and displacements have no NaN and no infinity */
  PetscBool loaded;       /* a load acts, or did when the ramp started */
  PetscReal time;         /* [s] since the start of the first dynamic stage */
  PetscInt64 verifications, contacts_made, contacts_lost; /* with variable connectivity */
  PetscReal deepest; /* [-] deepest overlap of a contact over its shorter face, see verify.c */
  Energies energy;
} StageResult;

/* ---- stage_result.c */
extern const char *const VerdictNames[];
/* Returns "explicit", "preconditioned", "stiffness_mass", or one of the last two and then explicit. */
const char *EffortMethod(const Effort *effort);
/* Writes in one sentence why the stage took its method, and which key fixes it; "": the user has chosen. */
void MethodSentence(const MethodChoice *choice, size_t size, char *text);
/* Returns "fixed", "variable", or the first and then the second; NULL: the stage moves nothing. */
const char *EffortConnectivity(const Effort *effort);
/* Returns whether cycles in fictitious time ran, with whatever mass. */
PetscBool EffortHasCycles(const Effort *effort);
/* Returns the effort [solves], counted in solves of Newton's method. */
PetscReal EffortWork(const Effort *effort);

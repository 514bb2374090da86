/* term.h: what acts on the blocks. A force term is a row of the table in terms.c, a TermKind; loads/ is the
   one to copy, docs/extend.md the way to do it.

   Every rank computes a term at all of its own vertices, from the same displacements: no term sends forces.
   A row fills in what its term does; NULL: nothing to do. */
#pragma once
#include "archive/archive.h"

struct _p_Contacts;

/* What a term sees of the run. */
typedef struct {
  const Scene *scene; /* of the stage: a trial of a flood has levels of its own */
  const Stage *stage; /* that runs; NULL at set-up */
  const Model *m;
  struct _p_Contacts *contacts;
  const State *state;
  void *memory; /* the term's own, from create */
} TermView;

/* What an evaluation starts from. */
typedef struct {
  const Scene *scene;
  const Model *m;
  const Joint *joints; /* of the stage */
  struct _p_Contacts *contacts;
  const PetscReal *u; /* [m] vertex array */
  PetscBool results;  /* somebody will look at what the evaluation came by, so the term keeps it */
} Instant;

/* The phases of a cycle. The unbalanced force of a body is compared with the forces of PHASE_JOINTS, so these
   come first and alone. The forces of PHASE_BLOCKS come last, and in a static stage chunk by chunk with the
   motion (cycle.c). */
typedef enum {
  PHASE_BODIES, /* what acts on bodies: loads, water, anchors, condensed bodies */
  PHASE_JOINTS, /* what acts between them: the tangent is that of the last evaluation */
  PHASE_BLOCKS  /* what acts within them */
} TermPhase;

typedef enum {
  COMMIT,        /* an equilibrium: every evaluation starts from its history until the next one */
  GO_BACK,       /* to the history last committed */
  KEEP_STABLE,   /* the state of a trial that is stable */
  BACK_TO_STABLE /* the next trial starts from it */
} TermHistory;

/* When `settle` is called: in a static stage with its loads in full. */
typedef enum {
  AT_CHECK, /* on the way to equilibrium */
  AT_EQUILIBRIUM
} TermMoment;

typedef enum {
  TANGENT_PATTERN, /* which vertices couple, with all that meet one of this rank; k: NULL */
  TANGENT_ELASTIC, /* of the reference state, joints whole */
  TANGENT_NOW,     /* of the last evaluation */
  TANGENT_TURNED,  /* of the last evaluation, with what comes of bodies and faces that turn under the forces
                      they carry */
  TANGENT_SMALL    /* as TURNED, of motions so small that no joint slips, closes or opens; symmetric */
} TangentKind;

/* Takes a dense stiffness k [N/m] (2n,2n) that couples x and y of n local vertices. carried: NULL, or (2n,)
   forces [N] on them: where they stand on rigid bodies these turn, and so do the arms of the forces. */
typedef PetscErrorCode (*TermAdd)(PetscInt n, const PetscInt *vertices, const PetscReal *k,
                                  const PetscReal *carried, void *context);

/* Takes a group of vertices whose owners must know each other's. */
typedef PetscErrorCode (*TermCouple)(PetscInt n, const PetscInt *gids, void *context);

/* Takes what a term adds to the inertia of n local vertices: mass [kg] and dashpots [N s/m], (2n,2n) each
   in x and y of the vertices; NULL: none. Dashpots couple x and y of one vertex only. */
typedef PetscErrorCode (*TermInertia)(PetscInt n, const PetscInt *vertices, const PetscReal *mass,
                                      const PetscReal *dashpot, void *context);

/* What comes in where vertices have inertia of their own: vertex arrays of the deformable. */
typedef struct {
  PetscReal *w;    /* [m/s] what dashpots hold against */
  PetscReal *wave; /* [m/s] of it, the velocity of what comes in; the rest of the motion goes out */
  PetscReal *push; /* [N] what acts beside dashpots */
  PetscReal
      part; /* [-] of a step, by which velocities go on: 1; -1/2 at the start of a stage, 1/2 at its end; 0:
               as 1, but what terms have of their own stays, because the caller takes the step back */
} Incoming;

/* A table of a term's own in results.h5: a group of its name below the stage, a dataset a column. */
enum { TERM_COLUMNS = 8, TERM_TABLES = 2 /* of a term */ };
typedef struct {
  const char *name;
  PetscInt width;    /* numbers in a row */
  PetscReal *values; /* (n_rows, width) from PetscMalloc */
} TermColumn;
typedef struct {
  const char *name;
  PetscInt n_rows, n_columns;
  TermColumn columns[TERM_COLUMNS];
} TermTable;

/* What a term tells of things that have names, as time goes on: a row each, alike on all ranks. The memory is
   the term's, until it is asked again. */
typedef struct {
  PetscInt n_rows, n_columns;
  const char *const *names, *const *columns; /* of rows, of columns */
  const PetscReal *values;                   /* (n_rows, n_columns); NaN: it is not there */
} TermRecord;

/* What results say of the blocks of a list, by their total strain until terms have corrected it. NULL: not
   asked for. */
typedef struct {
  PetscReal *centre, *gauss; /* [Pa] (n, 3), (n, 1 or 4, 3) Cauchy stress, as ElementStress and -Gauss */
  PetscReal *energy;         /* [J] (n,) */
  PetscReal *change;         /* [K] (n,) mean change of temperature */
  PetscReal *across;         /* [Pa] (n,) what that adds to the stress across the plane, at the centre */
} BlockAnswers;

typedef struct {
  const char *name;
  TermPhase phase;
  unsigned loads;    /* bit of each LoadKind that is its own */
  PetscBool presses; /* these press on faces, and follow them in large strain */

  /* Rank 0, before the mesh is dealt out: gives `couple` the vertices that it couples, by their numbers in
     the mesh, which are the gids. Blocks and contacts need not: ranks know the vertices of theirs. */
  PetscErrorCode (*reads)(const Scene *scene, const BlockMesh *mesh, TermCouple couple, void *context);
  /* set-up; collective; create refuses what the scene gets wrong */
  PetscErrorCode (*create)(const TermView *v, void **memory);
  PetscErrorCode (*destroy)(const Scene *scene, void **memory);

  /* each evaluation: no messages, no allocation. f, k: vertex arrays [N], [N/m] */
  PetscErrorCode (*forces)(void *memory, const Instant *at, PetscReal *f); /* adds resisting forces */
  /* In a dynamic stage, after each step: what the term prescribes or has of its own moves on to the new
     time. */
  void (*advance)(void *memory, const Model *m, State *state);
  /* Then, when all velocities are those behind the step: checks at them. v_before: (n_dof,) those before. */
  void (*after_step)(void *memory, const Model *m, const State *state, const PetscReal *v_before);
  /* In a dynamic stage, at its start or where it goes on: adds mass and dashpots, every rank at all of its
     vertices. */
  PetscErrorCode (*inertia)(const TermView *v, TermInertia add, void *context);
  /* Then in each step, on all ranks: adds what comes in at vertices with such inertia. */
  void (*incoming)(void *memory, const Model *m, const State *state, Incoming *in);
  /* [J] Collective. Adds what it stores however little it has been displaced (prestress); alike on all
     ranks. */
  PetscErrorCode (*prestressed)(const TermView *v, PetscReal *sum);
  /* [J] Adds what has been lost in it so far, for good; this rank. */
  void (*dissipated)(const void *memory, PetscReal *sum);
  /* Adds row sums (28)-(29): the time step. anywhere: also for what may come about as bodies move. */
  PetscErrorCode (*bound)(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k);
  /* In a dynamic stage: adds row sums [N s/m] of dampers among its forces, which know the velocity of half a
     step before; they shorten the time step. */
  PetscErrorCode (*drag)(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *c);
  PetscReal (*damped)(const void *memory); /* [J] work of such dampers in blocks, of the stage; this rank */
  PetscErrorCode (*energy)(const void *memory, const Instant *at, PetscReal *sum); /* [J] stored; this rank */
  /* Adds its stiffness, which Newton's method needs of every term with `forces`. One rank adds each
     coupling. */
  PetscErrorCode (*tangent)(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                            void *context);
  PetscBool tangent_varies; /* its tangent changes as that of joints does, whatever its phase */

  /* Adds to f the forces that it applies in a stage without a load of the scene (jacks); any: there are
     some; f: NULL: only asks. They follow the motion in large strain. */
  PetscErrorCode (*applied_without_load)(const TermView *v, PetscBool *any, PetscReal *f);
  /* applied forces of one load of the stage, a row of scene->loads; f: vertex array, adds to it */
  PetscErrorCode (*applied)(const TermView *v, PetscInt load, PetscReal *f);

  /* of stages; collective */
  PetscErrorCode (*begin)(const TermView *v); /* a stage or trial begins */
  /* again: something has changed, the stage goes on; or a verdict. */
  PetscErrorCode (*settle)(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
  /* Whether what settle changes in this stage is a try, so joints do not remember the equilibrium before. */
  PetscBool (*is_trial)(const TermView *v);
  /* A step of a transient stage is over, after which the stage goes on unless `result` gets another verdict;
     grow: [-] by how much longer the next one may be. */
  PetscErrorCode (*step_done)(const TermView *v, StageResult *result, PetscReal *grow);
  PetscErrorCode (*before_summary)(const TermView *v, PetscBool tell); /* before a summary; tell: warns */
  PetscErrorCode (*history)(const TermView *v, TermHistory what);      /* not collective */

  /* memory and answers */
  PetscErrorCode (*record)(const TermView *v, TermRecord *look); /* collective; one row of the table has it */
  PetscErrorCode (*of_blocks)(const TermView *v, const Elements *list, BlockAnswers *answers);
  PetscErrorCode (*archive)(Archive *archive, const TermView *v);
  PetscErrorCode (*archive_stable)(Archive *archive, const TermView *v); /* what KEEP_STABLE has kept */
  /* rank 0; which: 0 to TERM_TABLES - 1; no rows: there is none. It gives the table its name. */
  PetscErrorCode (*table)(const TermView *v, PetscInt which, TermTable *table);
  void (*summary)(FILE *f, const TermView *v); /* members of a stage or trial in summary.json; rank 0 */
} TermKind;

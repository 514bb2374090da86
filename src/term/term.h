/* term.h: declares the interface of force terms, which act on the blocks. A force term is a row of the
   table in terms.c, a TermKind; loads/ is the one to copy, docs/extend.md the way to do it.

   Every rank computes a term at all of its own vertices, from the same displacements: no term sends
   forces. NULL in a row: nothing to do. */
#pragma once
#include "archive/archive.h"

struct _p_Contacts;

/* Force of a load on a face of the mesh as drawn, or on a piece of it: linear between two points, of which
   these are the shares of the ends, with its resultant and moment. A single force has its place on the face
   as the first point, with share 0, and the point where it acts as the second. */
typedef struct {
  PetscInt load, face, place;   /* row of Scene.loads; gid; order of its pieces */
  PetscReal point[4], force[4]; /* [m], [N]: x, y of the first, x, y of the second */
} LoadOnFace;

typedef struct {
  PetscInt load, n; /* row that is added; number of rows so far */
  LoadOnFace *rows; /* NULL: they are counted */
} LoadsOnFaces;

/* The part of a run that a term sees. */
typedef struct {
  const Scene *scene; /* of the stage: a trial of a flood has its own levels */
  const Stage *stage; /* the current stage; NULL at set-up */
  const Model *m;
  struct _p_Contacts *contacts;
  const State *state;
  void *memory;        /* of the term, from create */
  LoadsOnFaces *faces; /* NULL, or receives what `applied` puts on faces of the mesh as drawn */
} TermView;

/* Keeps the force of a load on a face, on the rank that owns its first vertex. */
void LoadOnFaceKeep(const TermView *v, PetscInt face, const PetscReal point[4], const PetscReal force[4]);

/* Input of an evaluation. */
typedef struct {
  const Scene *scene;
  const Model *m;
  const Joint *joints; /* of the stage */
  struct _p_Contacts *contacts;
  const PetscReal *u; /* [m] vertex array */
  PetscBool results;  /* the result of the evaluation will be read, so the term stores it */
} Instant;

/* Phases of a cycle. The unbalanced force of a body is compared with the forces of PHASE_JOINTS, so these
   are computed separately. The forces of PHASE_BLOCKS come last, and in a static stage chunk by chunk with
   the motion (cycle.c). */
typedef enum {
  PHASE_BODIES, /* forces on bodies: loads, water, anchors, condensed bodies */
  PHASE_JOINTS, /* forces between bodies; the tangent is that of the last evaluation */
  PHASE_BLOCKS  /* forces within bodies */
} TermPhase;

typedef enum {
  COMMIT,        /* an equilibrium: evaluations start from its history until the next one */
  GO_BACK,       /* to the committed history */
  KEEP_STABLE,   /* store the state of a stable trial */
  BACK_TO_STABLE /* the next trial starts from it */
} TermHistory;

/* Moments of `settle` in a static stage, after the loads have reached their full values. */
typedef enum {
  AT_CHECK, /* on the way to equilibrium */
  AT_EQUILIBRIUM
} TermMoment;

typedef enum {
  TANGENT_PATTERN, /* which vertices couple, including all couplings with owned vertices; k: NULL */
  TANGENT_ELASTIC, /* of the reference configuration, joints intact */
  TANGENT_NOW,     /* of the last evaluation */
  TANGENT_TURNED,  /* of the last evaluation, with the geometric stiffness of bodies and faces that rotate
                      under load */
  TANGENT_SMALL    /* as TURNED, for motions so small that no joint slips, closes or opens; symmetric */
} TangentKind;

/* Adds a dense stiffness k [N/m] (2n,2n) that couples x and y of n local vertices. carried: NULL, or (2n,)
   forces [N] on them. On rigid bodies the lever arms of these forces rotate. */
typedef PetscErrorCode (*TermAdd)(PetscInt n, const PetscInt *vertices, const PetscReal *k,
                                  const PetscReal *carried, void *context);

/* Adds a group of vertices whose owners must know each other's vertices. */
typedef PetscErrorCode (*TermCouple)(PetscInt n, const PetscInt *gids, void *context);

/* Adds the inertia of a term at n local vertices: mass [kg] and dashpots [N s/m], (2n,2n) each in x and y
   of the vertices; NULL: none. Dashpots couple x and y of one vertex only. */
typedef PetscErrorCode (*TermInertia)(PetscInt n, const PetscInt *vertices, const PetscReal *mass,
                                      const PetscReal *dashpot, void *context);

/* Incoming motion at vertices with inertia of terms: vertex arrays of deformable blocks. */
typedef struct {
  PetscReal *w;    /* [m/s] velocity in the dashpots */
  PetscReal *wave; /* [m/s] velocity of the incoming wave in w; the rest of the motion radiates outwards */
  PetscReal *push; /* [N] other forces */
  PetscReal
      part; /* [-] fraction of the step for velocities: 1; -1/2 at the start of a stage, 1/2 at its end; 0:
               as 1, but terms keep their own state, because the caller takes the step back */
} Incoming;

/* A table of a term in results.h5: a group with its name below the stage, one dataset per column. */
enum { TERM_COLUMNS = 8, TERM_TABLES = 2 /* of a term */ };
typedef struct {
  const char *name;
  PetscInt width;    /* numbers per row */
  PetscReal *values; /* (n_rows, width) from PetscMalloc */
} TermColumn;
typedef struct {
  const char *name;
  PetscInt n_rows, n_columns;
  TermColumn columns[TERM_COLUMNS];
} TermTable;
/* Sets name and columns of a table and allocates its values. columns: (n_columns,) names and widths. */
PetscErrorCode TermTableCreate(const char *name, PetscInt n_rows, PetscInt n_columns,
                               const TermColumn *columns, TermTable *table);

typedef struct {
  const char *name;
  TermPhase phase;
  unsigned loads;    /* bit of each LoadKind of the term */
  PetscBool presses; /* these loads press on faces, and follow them in large strain */

  /* Rank 0, before the mesh is distributed: passes to `couple` the vertices that the term couples, by
     their gids. Blocks and contacts need not: ranks know the vertices of theirs. */
  PetscErrorCode (*reads)(const Scene *scene, const BlockMesh *mesh, TermCouple couple, void *context);
  /* set-up; collective; create refuses faults of the scene */
  PetscErrorCode (*create)(const TermView *v, void **memory);
  PetscErrorCode (*destroy)(const Scene *scene, void **memory);

  /* each evaluation: no messages, no allocation. f, k: vertex arrays [N], [N/m] */
  PetscErrorCode (*forces)(void *memory, const Instant *at, PetscReal *f); /* adds resisting forces */
  /* In a dynamic stage, after each step: advances prescribed motions and the term's own state to the new
     time. */
  void (*advance)(void *memory, const Model *m, State *state);
  /* In a dynamic stage, at its start or after a restart: adds mass and dashpots, every rank at all of its
     vertices. */
  PetscErrorCode (*inertia)(const TermView *v, TermInertia add, void *context);
  /* Then in each step, on all ranks: adds incoming motion at vertices with such inertia. */
  void (*incoming)(void *memory, const Model *m, const State *state, Incoming *in);
  /* Adds the energy [J] dissipated so far on this rank. */
  void (*dissipated)(const void *memory, PetscReal *sum);
  /* Adds row sums (28)-(29) for the time step. anywhere: also for contacts that may form as bodies move. */
  PetscErrorCode (*bound)(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *k);
  /* In a dynamic stage: adds row sums [N s/m] of dampers among the term's forces. They act on the velocity
     of half a step before, so they shorten the time step. */
  PetscErrorCode (*drag)(const void *memory, const Instant *at, PetscBool anywhere, PetscReal *c);
  PetscErrorCode (*energy)(const void *memory, const Instant *at, PetscReal *sum); /* [J] stored; this rank */
  /* Adds the tangent stiffness, which Newton's method needs of every term with `forces`. One rank adds
     each coupling. */
  PetscErrorCode (*tangent)(const void *memory, const Instant *at, TangentKind kind, TermAdd add,
                            void *context);
  PetscBool tangent_varies; /* the tangent changes as that of joints, whatever the phase */

  /* applied forces of one load of the stage, a row of scene->loads; f: vertex array, adds to it */
  PetscErrorCode (*applied)(const TermView *v, PetscInt load, PetscReal *f);

  /* of stages; collective */
  PetscErrorCode (*begin)(const TermView *v); /* a stage or trial begins */
  /* Updates the term at an equilibrium or a check. again: something has changed, so the stage goes on; or
     sets a verdict. */
  PetscErrorCode (*settle)(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
  PetscErrorCode (*before_summary)(const TermView *v, PetscBool report); /* report: with warnings */
  PetscErrorCode (*history)(const TermView *v, TermHistory what);        /* not collective */

  /* archive and results */
  PetscErrorCode (*archive)(Archive *archive, const TermView *v);
  PetscErrorCode (*archive_stable)(Archive *archive, const TermView *v); /* state of KEEP_STABLE */
  /* Rank 0. Fills a table; which: 0 to TERM_TABLES - 1. No rows: there is no table. The term sets the
     name. */
  PetscErrorCode (*table)(const TermView *v, PetscInt which, TermTable *table);
  void (*summary)(Json *json, const TermView *v); /* members of a stage or trial in summary.json; rank 0 */
} TermKind;

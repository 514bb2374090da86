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
  const struct _p_Contacts *contacts;
  const State *state;
  void *memory; /* the term's own, from create */
} TermView;

typedef enum { KEEP_STABLE, BACK_TO_STABLE } TermHistory;

/* Takes a dense stiffness k [N/m] (2n,2n) that couples x and y of n local vertices. */
typedef PetscErrorCode (*TermAdd)(PetscInt n, const PetscInt *vertices, const PetscReal *k, void *context);

typedef struct {
  const char *name;
  unsigned loads;    /* bit of each LoadKind that is its own */
  PetscBool presses; /* these press on faces, and follow them in large strain */

  /* set-up; collective; create refuses what the scene gets wrong */
  PetscErrorCode (*create)(const TermView *v, void **memory);
  PetscErrorCode (*destroy)(const Scene *scene, void **memory);

  /* each evaluation: no messages, no allocation. u, f, k: vertex arrays [m], [N], [N/m] */
  void (*forces)(const void *memory, const Model *m, const PetscReal *u,
                 PetscReal *f); /* adds resisting forces */
  void (*bound)(const void *memory, const Model *m,
                PetscReal *k); /* adds row sums (28)-(29): the time step */
  PetscReal (*energy)(const void *memory, const Model *m, const PetscReal *u); /* [J] stored, of this rank */
  /* adds its stiffness, which Newton's method needs of every term with `forces`. u: NULL, the reference
     state. It tells the entries of the matrix, too: each coupling belongs to one rank. */
  PetscErrorCode (*tangent)(const void *memory, const Model *m, const PetscReal *u, TermAdd add,
                            void *context);

  /* applied forces of one load of the stage, a row of scene->loads; f: vertex array, adds to it */
  PetscErrorCode (*applied)(const TermView *v, PetscInt load, PetscReal *f);

  /* of stages; collective */
  PetscErrorCode (*begin)(const TermView *v); /* a static stage or trial begins */
  /* At an equilibrium, and after each chunk of cycles without one. again: something has changed, the stage
     goes on; or a verdict. */
  PetscErrorCode (*settle)(const TermView *v, StageResult *result, PetscBool *again);
  PetscErrorCode (*survey)(const TermView *v, PetscBool tell); /* before a summary; tell: warns */
  void (*history)(const TermView *v, TermHistory what);        /* of trials */

  /* memory and answers */
  PetscErrorCode (*archive)(Archive *archive, const TermView *v);
  PetscErrorCode (*archive_stable)(Archive *archive, const TermView *v); /* what KEEP_STABLE has kept */
  void (*summary)(FILE *f, const TermView *v); /* members of a stage or trial in summary.json; rank 0 */
} TermKind;

/* line.h: declares an anchor as a line between two places in blocks, for the files of this room.

   With the elongation s since the reference state a tendon carries

     T = k (s - natural - plastic),  0 <= T <= T_y,  k = E A / free length,

   along the line from root to head: the present one in large strain, that of the reference state in small
   strain. `natural` is the elongation without force. While the anchor is stressed, a jack pulls with the
   prestress at any s; this is a load that follows the line. When the anchor is locked, natural = s - T_0/k
   + draw-in, so only the draw-in of the head is lost.

   A bonded anchor is a chain (chain.h). Its free length, if any, is the first piece of the chain. The root
   of the line is the end of this piece: there the jack pulls. */
#pragma once
#include "anchors/anchors.h"
#include "anchors/chain.h"

enum { LINE_VERTICES = 8 }; /* of the block at the head, then of the block at the root */

typedef enum {
  LINE_ABSENT,   /* not installed yet */
  LINE_STRESSED, /* a jack pulls */
  LINE_LOCKED,   /* locked: it stretches with the blocks */
  LINE_BROKEN
} LinePhase;

/* History of an anchor. */
typedef struct {
  LinePhase phase;
  PetscReal natural, plastic; /* [m] elongation without force; plastic elongation */
  PetscReal lost;             /* [J] energy dissipated by one anchor in yield and rupture */
  PetscReal jack;             /* [J] work of the jacks on the anchor and on what it ties together */
  PetscReal since;            /* [m] elongation at the start of stressing */
  PetscReal most;             /* [N] largest tension so far, at equilibria and in dynamic stages */
  PetscReal pulls;            /* [N] force of the jack while the anchor is stressed */
} LineHistory;

/* Row of numbers of an anchor: history and last evaluation. */
enum {
  LINE_PHASE,
  LINE_NATURAL,
  LINE_PLASTIC,
  LINE_LOST,
  LINE_JACK,
  LINE_SINCE,
  LINE_MOST,
  LINE_PULLS,
  LINE_STORED,
  LINE_S,
  LINE_T,
  LINE_NUMBERS
};

typedef struct {
  const Anchor *of;
  PetscBool here;                    /* this rank has a vertex of it; the members below are known only then */
  PetscBool mine;                    /* this rank owns it and adds what is added once */
  PetscInt n, vertex[LINE_VERTICES]; /* local vertices at the head, then at the root; then the first again */
  PetscReal weight[LINE_VERTICES];   /* sum 1 at the head, -1 at the root; 0 from n on */
  PetscReal reference[2], length;    /* [m] from root to head in the reference configuration, its length */
  PetscReal stiffness, T_y;          /* [N/m], [N] stiffness and yield force of one anchor */
  PetscReal per_slice;               /* [-] number of anchors in the thickness of the model */
  LineHistory committed, now, stable; /* histories: last equilibrium, last evaluation, last stable trial */
  PetscReal s, T;                     /* [m], [N] elongation and tension of the last evaluation */
  PetscReal e[2], span; /* [-], [m] direction from root to head and length in the last evaluation */
  Chain *chain;         /* NULL: not bonded */
  PetscBool unsolved;   /* the slips of the chain have not been found */
} Line;

typedef struct {
  PetscInt n;
  Line *line;         /* (n,) in the order of the scene */
  PetscBool in_time;  /* dynamic stage: every evaluation commits the history */
  PetscReal *report;  /* (n, LINE_NUMBERS) gathered on all ranks by AnchorsGather: anchors_memory.c */
  const char **name;  /* (n,) names */
  PetscReal *checked; /* (n, numbers) values at the last check, see anchors_output.c */
} Anchors;

/* ---- line.c */
/* Computes elongation and direction at displacements u, a vertex array. */
void LinePlace(Line *line, const Model *m, const PetscReal *u);
/* Returns the force [N] at elongation s [m] from the committed history. now receives the new history. */
PetscReal LineForce(const Line *line, PetscReal s, LineHistory *now);
/* Computes geometry and force of the anchor. */
void LineEvaluate(Line *line, const Model *m, const PetscReal *u);
/* Returns the largest tension [N] along the anchor. */
PetscReal LineLargest(const Line *line);
/* Returns the tangent stiffness dT/ds [N/m] of the last evaluation. */
PetscReal LineTangent(const Line *line);
/* Commits the history in a dynamic stage, and breaks an anchor beyond its limits. */
void LineCommit(Line *line);
/* Decides whether the anchor breaks at the forces of the last evaluation. */
PetscBool LineBreaks(const Line *line);
/* Adds to f the forces by which a tension T [N] resists elongation: against the line at the head, along it
   at the root. f: vertex array. */
void LinePull(const Line *line, PetscReal T, PetscReal *f);
/* Adds to f all forces of the anchor, also of a bonded bar, times `times`. */
void LineResist(const Line *line, PetscReal times, PetscReal *f);
/* Copies the history of one moment to another. */
void LineKeep(Line *line, ChainState from, ChainState to);
/* Returns the energy [J] stored in one anchor. */
PetscReal LineStored(const Line *line);

/* ---- anchors_setup.c */
PetscErrorCode AnchorsReads(const Scene *scene, const BlockMesh *mesh, TermCouple couple, void *context);
PetscErrorCode AnchorsCreate(const TermView *v, void **memory);
PetscErrorCode AnchorsDestroy(const Scene *scene, void **memory);

/* ---- anchors_memory.c */
/* Collective. Gathers all->report on all ranks. */
PetscErrorCode AnchorsGather(MPI_Comm comm, Anchors *all);
PetscErrorCode AnchorsArchive(Archive *archive, const TermView *v);
PetscErrorCode AnchorsArchiveStable(Archive *archive, const TermView *v);

/* ---- anchors_stages.c */
/* Begins a stage: stresses, locks and installs anchors. */
PetscErrorCode AnchorsBegin(const TermView *v);
/* Breaks the anchors that are beyond their limits at an equilibrium. */
PetscErrorCode AnchorsSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);

/* ---- anchors_output.c */
PetscErrorCode AnchorsBeforeSummary(const TermView *v, PetscBool report);
void AnchorsSummary(Json *json, const TermView *v);
PetscErrorCode AnchorsTable(const TermView *v, PetscInt which, TermTable *table);

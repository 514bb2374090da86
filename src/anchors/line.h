/* line.h: what the files of anchors share: an anchor as a line between two places in blocks.

   With the elongation s since the reference state a tendon carries

     T = k (s - natural - plastic),  0 <= T <= T_y,  k = E A / free length,

   along the line from root to head: the present one in large strain, that of the reference state in small
   strain. `natural` is the elongation at which it has no force. While it is stressed a jack pulls with the
   prestress, whatever s is; that is a load, which follows the line. As it is locked, natural = s - T_0/k +
   draw-in, so nothing is lost but what the head slips.

   A bonded one is a chain (chain.h); its free length, if any, is the first piece of that, and the root of the
   line is where that piece ends: there the jack pulls. */
#pragma once
#include "anchors/anchors.h"
#include "anchors/chain.h"

enum { LINE_VERTICES = 8 }; /* those of the block at the head, then those at the root */

typedef enum {
  LINE_ABSENT,   /* not there yet */
  LINE_STRESSED, /* a jack pulls */
  LINE_HELD,     /* it stretches with the blocks */
  LINE_BROKEN
} LinePhase;

/* What an anchor remembers. */
typedef struct {
  LinePhase phase;
  PetscReal natural, plastic; /* [m] */
  PetscReal lost;             /* [J] of one anchor, as it yielded and broke */
  PetscReal jack;             /* [J] work that jacks have done on it, and on what it ties together */
  PetscReal since;            /* [m] elongation at which the jack began */
  PetscReal most;             /* [N] largest tension so far, at equilibria and in time */
  PetscReal pulls;            /* [N] of the jack, while it is stressed */
} LineHistory;

/* A history and the last evaluation as numbers. */
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
  PetscBool here; /* this rank has a vertex of it; the members below are known here alone */
  PetscBool mine; /* this rank adds what is added once */
  PetscInt n, vertex[LINE_VERTICES]; /* local vertices, of the head, then of the root; then the first again */
  PetscReal weight[LINE_VERTICES];   /* positive at the head, negative at the root: each sum to 1 and -1; 0 */
  PetscReal reference[2], length;    /* [m] from root to head in the reference state */
  PetscReal stiffness, T_y;          /* [N/m], [N] of one anchor */
  PetscReal per_slice;               /* [-] anchors in the thickness of the model */
  LineHistory held, now,
      stable;           /* of the last equilibrium, of the last evaluation, of the last stable trial */
  PetscReal s, T;       /* [m], [N] of the last evaluation */
  PetscReal e[2], span; /* [-], [m] its direction from root to head, and length, then */
  Chain *chain;         /* NULL: it is not bonded */
  PetscBool unsolved;   /* the slips of that have not been found */
} Line;

typedef struct {
  PetscInt n;
  Line *line;        /* (n,) in the order of the scene */
  PetscBool in_time; /* a dynamic stage: history goes on with every evaluation */
  PetscReal *told;   /* (n, LINE_NUMBERS) on all ranks, after AnchorsGather; anchors_memory.c */
  const char **name; /* (n,) */
  PetscReal *seen;   /* (n, numbers) at the last look, see anchors_output.c */
} Anchors;

/* ---- line.c */
/* Elongation and direction at displacements u, a vertex array. */
void LinePlace(Line *line, const Model *m, const PetscReal *u);
/* [N] Force at the present elongation, from the history held; now: what it leaves. */
PetscReal LineForce(const Line *line, PetscReal s, LineHistory *now);
/* Places it and finds its force. */
void LineEvaluate(Line *line, const Model *m, const PetscReal *u);
/* [N] Largest tension along it. */
PetscReal LineLargest(const Line *line);
/* [N/m] dT/ds of the last evaluation. */
PetscReal LineTangent(const Line *line);
/* In time: breaks it where it is beyond its limits; the next evaluation starts from this one. */
void LineGoesOn(Line *line);
/* Whether it breaks at what the last evaluation found. */
PetscBool LineBreaks(const Line *line);
/* Adds to f the forces by which a tension T resists its elongation: out of its line at the head, back at the
   root. f: vertex array. */
void LinePull(const Line *line, PetscReal T, PetscReal *f);
/* Adds to f all forces by which it resists, also those of a bonded bar, times `times`. */
void LineResist(const Line *line, PetscReal times, PetscReal *f);
/* The history of one moment becomes that of another. */
void LineKeep(Line *line, ChainState from, ChainState to);
/* [J] stored in one anchor. */
PetscReal LineStored(const Line *line);

/* ---- anchors_setup.c */
PetscErrorCode AnchorsReads(const Scene *scene, const BlockMesh *mesh, TermCouple couple, void *context);
PetscErrorCode AnchorsCreate(const TermView *v, void **memory);
PetscErrorCode AnchorsDestroy(const Scene *scene, void **memory);

/* ---- anchors_memory.c */
/* Collective. Writes all->told. */
PetscErrorCode AnchorsGather(MPI_Comm comm, Anchors *all);
/* Collective. What all anchors store. */
PetscErrorCode AnchorsPrestressed(const TermView *v, PetscReal *sum);
PetscErrorCode AnchorsArchive(Archive *archive, const TermView *v);
PetscErrorCode AnchorsArchiveStable(Archive *archive, const TermView *v);

/* ---- anchors_stages.c */
/* At the start of a stage: anchors are stressed, locked, or come. */
PetscErrorCode AnchorsBegin(const TermView *v);
/* Adds what jacks pull with. any: whether one pulls; f: NULL: only asks. */
PetscErrorCode AnchorsPull(const TermView *v, PetscBool *any, PetscReal *f);
/* At an equilibrium: anchors that are beyond their limits break. */
PetscErrorCode AnchorsSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);

/* ---- anchors_output.c */
PetscErrorCode AnchorsSurvey(const TermView *v, PetscBool tell);
void AnchorsSummary(FILE *f, const TermView *v);
PetscErrorCode AnchorsRecord(const TermView *v, TermRecord *look);
PetscErrorCode AnchorsTable(const TermView *v, PetscInt which, TermTable *table);

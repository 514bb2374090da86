/* flow.h: what rows.c to flow_term.c share: water that flows in joints, and presses on their faces.

   The water of a joint flows between plates (cubic law). A contact is a stretch of such a joint. Along it
   aperture + opening runs linearly, and the width for water is that, between aperture_residual and
   aperture_max. A node of the network is a void: ends of contacts that meet in it. Drains and the edges of
   curtains cut contacts into pieces, with a node at each cut. The unknowns are heads; pressure acts on the
   blocks as an external force, as uplift does, so the stress of a joint is its effective stress. */
#pragma once
#include "seepage/seepage.h"

/* ---- flow_rows.c */
/* A contact as the network sees it, the same on all ranks. Ends are numbered as sub-contacts. */
typedef struct {
  PetscInt key[2];       /* gids of its faces */
  PetscInt joint;        /* row of the joints table */
  PetscInt parted;       /* its faces have parted: it is in the list of contacts no more */
  PetscInt shut;         /* it lets no water in until it fails */
  PetscInt failed[2];    /* an end has opened, slipped or broken, now or before */
  PetscInt vertex[2][2]; /* of an end: gids of the vertices that stand in its void; -1: only one does */
  PetscReal x[2][2];     /* [m] where the ends stand */
  PetscReal t[2][2];     /* [-] place of end k along face s: t[s][k] */
  PetscReal opening[2];  /* [m] of the ends, 0 where the joint just bears */
  PetscReal length;      /* [m] */
} FlowRow;
enum { ROW_INTS = 11, ROW_REALS = 11 };

/* Collective. Gathers the contacts of joints with an aperture, by ascending key. */
PetscErrorCode FlowRowsGather(const Model *m, const Contacts *c, const Joint *joints, const PetscReal *u,
                              PetscInt *n, FlowRow **rows);
/* Collective. Carries over what rows remember from `before`: what has failed stays failed, and contacts whose
   faces have parted since stay, as wide open as the faces are now: replaces *rows by both lists. */
PetscErrorCode FlowRowsFollow(const Model *m, const Joint *joints, const PetscReal *u, PetscInt n_before,
                              const FlowRow *before, PetscInt *n, FlowRow **rows);

/* ---- network.c */
/* A stretch of a contact between two nodes. */
typedef struct {
  PetscInt row;          /* its contact */
  PetscInt node[2];      /* the void at either end */
  PetscReal s[2];        /* [-] where it begins and ends along the contact */
  PetscReal length;      /* [m] */
  PetscReal a[2];        /* [m] apertures at its ends */
  PetscReal conductance; /* [m2/s] discharge per metre of head between its ends */
} FlowPiece;

typedef enum {
  NODE_FREE,
  NODE_HEAD, /* under water: the head is given */
  NODE_SEEP  /* at a face above the water, or at a drain that runs freely: water leaves it without pressure */
} FlowNodeKind;
/* What a node has come to: heads.c. */
typedef enum { WET, PARTLY, DRY } FlowSide;
typedef struct {
  FlowNodeKind kind;
  PetscInt load;         /* row of the scene's loads that gives its condition, -1: none */
  PetscReal x[2];        /* [m] */
  PetscReal head;        /* [m] of NODE_HEAD, or outside a drain that resists */
  PetscReal conductance; /* [m2/s] of a drain that resists, 0: none */
  PetscReal inflow;      /* [m2/s] */
  FlowSide first;        /* the side with which the search for the free surface begins */
  /* what it takes in while water flows in time, [m2/s]: wet[0] psi + wet[1], or part[0] chi + part[1] */
  PetscReal wet[2], part[2];
} FlowNode;

/* A drain that resists. Several may act at a node, which has the sum of their conductances and the head
   outside that gives their sum of discharges. */
typedef struct {
  PetscInt node, load;
  PetscReal head, conductance; /* [m] outside; [m2/s] */
} FlowDrain;

/* What a condition of the scene names in the mesh, the same on all ranks. */
typedef struct {
  PetscInt n_faces, *faces, n_vertices, *vertices; /* gids, ascending */
  PetscBool from_end; /* a drain at a distance: the water stands at the end of its joint */
} FlowTarget;

typedef struct {
  PetscInt n_rows, n_pieces, n_nodes;
  FlowRow *row;     /* (n_rows,) */
  FlowPiece *piece; /* (n_pieces,) in the order of rows */
  FlowNode *node;   /* (n_nodes,) */
  PetscInt n_drains;
  FlowDrain *drain; /* (n_drains,) */
  PetscReal step;   /* [s] of the water, 0: it flows steadily */
} FlowNetwork;

/* Builds nodes and pieces from net->row, with the conditions of the stage's loads. target: (n_loads,). unmet:
   the first condition that meets no joint; message: conditions that contradict each other; "": none. Both
   follow the name of the scene's file. */
PetscErrorCode FlowNetworkBuild(const Scene *scene, const Stage *stage, const FlowTarget *target,
                                PetscReal reach, FlowNetwork *net, char unmet[MESSAGE_LENGTH],
                                char message[MESSAGE_LENGTH]);
PetscErrorCode FlowNetworkDestroy(FlowNetwork *net);
/* Sets apertures and conductances from the rows. */
void FlowConduct(const Scene *scene, const Stage *stage, FlowNetwork *net);

/* ---- storage.c */
/* The water at an end of a piece. */
typedef struct {
  PetscInt key[2];
  PetscReal s;        /* [-] along the contact */
  PetscReal a;        /* [m] aperture that holds it */
  PetscReal psi, chi; /* [m], [-] pressure head and saturation */
  PetscReal length;   /* [m] of the piece, of which it fills the half at this end */
  PetscReal held;     /* [m] volume over that half: a (chi + p / K_w) */
  FlowSide side;
} FlowWater;
/* What an end of a piece does when pressure rises: [m/Pa] change of its aperture at once, by the stiffness of
   the joint; 0 where the aperture is at its least or largest. */
PetscReal FlowCompliance(const Scene *scene, const Stage *stage, const FlowNetwork *net, PetscInt piece,
                         int end);
/* A pair of steps of the water is one of second order (storage.c): the second lasts SECOND times the
   first, and its own flow acts over 1 / SECOND of it. */
static const PetscReal FLOW_SECOND = 2.4142135623730951; /* 1 + sqrt(2) */
/* Makes what was there in the middle of a pair, (n_middle,) as FlowStore takes it, where its second step
   begins. start: (n_start,) what was there when the pair began. */
void FlowAhead(const FlowWater *start, PetscInt n_start, FlowWater *middle, PetscInt n_middle);
/* Sets what nodes take in over net->step since `past`, (n,) in the order of pieces; where it has no water the
   joint was empty. reference: (n_nodes,) [m] pressure heads to which the apertures belong. */
void FlowStore(const Scene *scene, const Stage *stage, const FlowWater *past, PetscInt n,
               const PetscReal *reference, FlowNetwork *net);
/* The water at the place s along a contact, from a list as FlowStore has; false: it was empty. within: a
   place of the same piece beside s. Where two pieces meet at s, this says which of them is meant. */
PetscBool FlowWaterAt(const FlowWater *past, PetscInt n, const PetscInt key[2], PetscReal s, PetscReal within,
                      FlowWater *water);

/* ---- heads.c */
/* Flow of a network. Arrays are (n_nodes,), but for those marked. */
typedef struct {
  PetscReal *pressure;   /* [m] of water, >= 0 */
  PetscReal *saturation; /* [-] 0..1, 1 under the free surface */
  PetscReal *stream;     /* [-] 0..1, what falls from a node over what falls from a full one */
  PetscReal *stored;     /* [m2/s] that a node takes in while water flows in time */
  PetscReal *drained;    /* [m2/s] that drains that resist take */
  PetscReal *outflow;    /* [m2/s] that leaves the joints at a node with a condition */
  PetscReal *discharge;  /* [m2/s] (n_pieces,) from its first node to its second */
  FlowSide *side;        /* on which the search ended: begun with these it ends at once, with the same bits */
  PetscBool *cut_off;    /* no way leads to a head, an inflow or a drain under water: it is dry */
  PetscReal error; /* [-] largest imbalance of a node over the inflow of all; heads may be out by as much */
  PetscReal inflow, taken; /* [m2/s] of all nodes together: entering; stored */
  PetscInt rounds;         /* of the free surface */
} FlowSolution;
PetscErrorCode FlowSolve(const FlowNetwork *net, FlowSolution *flow, char message[MESSAGE_LENGTH]);
/* Finds what is cut off, (n_nodes,). message: an inflow without an outlet. */
PetscErrorCode FlowFindCutOff(const FlowNetwork *net, PetscBool *cut_off, char message[MESSAGE_LENGTH]);
PetscErrorCode FlowSolutionDestroy(FlowSolution *flow);

/* ---- coarse.c */
/* Guesses the sides with which the search in a large network begins. */
PetscErrorCode FlowGuess(FlowNetwork *net);

/* ---- coupling.c */
enum { MIXED = 3 }; /* old rounds that Anderson's method checks at */
/* The fixed-point iteration x = g(x) between pressures that act and those that flow leads to. */
typedef struct {
  PetscInt n, n_old;              /* unknowns; rounds kept, the last one first */
  PetscReal *x[MIXED], *g[MIXED]; /* (n,) each */
} Mixer;
/* Makes x, (n,), the next try from x and g(x), both >= 0. */
PetscErrorCode MixerNext(Mixer *mixer, PetscInt n, const PetscReal *g, PetscReal *x);
PetscErrorCode MixerReset(Mixer *mixer);

/* ---- undrained.c */
/* The water about a Gauss point of a piece, of which there are two, while it keeps its volume. Distances are
   of the faces there. */
typedef struct {
  PetscInt key[2];     /* gids of the faces */
  PetscReal t[2];      /* [-] where it presses on each */
  PetscReal length;    /* [m] of the joint, 0: it never presses, or its pressure stays */
  PetscReal slid;      /* [m] by how much the faces had slid at the start */
  PetscReal reach;     /* [m] by how much more they may */
  PetscReal apart;     /* [m] distance from which on it is lost */
  PetscReal least;     /* [m] distance below which the aperture is residual */
  PetscReal full;      /* [m] distance at which the void is just full */
  PetscReal pressure;  /* [Pa] there */
  PetscReal stiffness; /* [Pa/m] 0: so wide a crack that its pressure stays */
  PetscReal chi;       /* [-] saturation at the start; only then */
} FlowTrap;
enum { TRAP_INTS = 2, TRAP_REALS = 10 };
/* One that presses on vertices of this rank. */
typedef struct {
  PetscInt trap, face[2]; /* face: rows of model->faces */
  PetscBool first;        /* this rank moves the first vertex of face 0 */
} FlowTrapHere;

/* ---- the memory of the term */
enum { FLOW_SUMS = 11 }; /* numbers of the term that go on from step to step: flow_memory.c */
/* A face of this rank on which a piece presses. */
typedef struct {
  PetscInt piece, side, face; /* face: row of model->faces */
} FlowPush;
typedef struct _p_Flow {
  FlowTarget *target; /* (n_loads,) */
  FlowNetwork net;
  FlowSolution now;  /* the flow that the last openings lead to */
  PetscReal *acting; /* (n_nodes,) [m] pressure heads that press on the blocks */
  PetscInt n_push;
  FlowPush *push; /* (n_push,) in the order of pieces */
  Mixer mixer;
  PetscInt rounds;            /* of this stage */
  PetscReal change;           /* [-] of pressure in the last round */
  PetscReal early;            /* [-] unbalanced ratio at which the next round begins before equilibrium */
  char unmet[MESSAGE_LENGTH]; /* a condition that meets no joint of net, "": none */
  PetscReal *reference;       /* (n_nodes,) [m] what pressed when the apertures were measured */
  PetscInt n_past, n_present;
  FlowWater *past, *present; /* ends of pieces: when the step of the water began, and now */
  PetscReal volume, volume_0, taken,
      entered;           /* [m2] of water in joints, when the stage began, taken in since, and
                                                 of that what came in */
  PetscReal step_change; /* [-] of pressure in the step of the water, over the largest */
  PetscReal first; /* [s] length of the step just done, if it was the first of a pair (storage.c); else 0 */
  PetscReal first_taken, first_entered, first_change; /* [m2], [m2], [-] in it */
  PetscReal within; /* [-] step of the water over that of the stage: less than 1 in the second of a pair */
  PetscBool stale;  /* net and now are still to be made from net.row, whose acting holds n_nodes */
  PetscBool frozen; /* the stage is in time: no water flows */
  PetscInt n_traps, n_here;
  FlowTrap *trap; /* (n_traps,) two a piece while the stage is in time and undrained; the same on all ranks */
  FlowTrapHere *here; /* (n_here,) in the order of traps */
  PetscReal *trapped; /* [Pa] (n_traps,) at ends of pieces, when FlowTrapsRecord looked */
  PetscInt n_stable;  /* rows of the last stable trial, and what pressed then */
  FlowRow *row_stable;
  PetscReal *acting_stable;
  PetscInt n_acting_stable, rounds_stable;
  PetscInt n_present_stable; /* the water at the end of the last step of a transient stage, and its sums */
  FlowWater *present_stable;
  PetscReal sums_stable[FLOW_SUMS];
  PetscReal change_stable;
} Flow;
/* ---- storage.c */
/* [-] Since a transient stage began: the change of the volume in joints less what they have taken in, over
   the water that has moved. */
PetscReal FlowVolumeError(const Flow *flow);
static const PetscReal FLOW_VOLUME_TOLD = 1e-6, FLOW_VOLUME_WRONG = 1e-3; /* of which a run warns; ends */
/* A stage that makes or loses water is no answer. */
PetscErrorCode FlowJudgeVolume(const Flow *flow, StageResult *result);
/* [m2/s] What leaves the joints by the nodes of a load; negative: it enters. n: how many nodes these are. */
PetscReal FlowDischarge(const Flow *flow, PetscInt load, PetscInt *n);
/* Rank 0. Prints the balance of a transient stage, and warns where water is made or lost. */
void FlowReportVolume(const TermView *v);
/* ---- flow_setup.c */
/* [m] How far apart ends of contacts may be and share a void. */
PetscReal FlowReach(const Scene *scene, const Model *m);
/* Collective. Refuses a stage. message: what follows the name of the scene's file, "": nothing is wrong. */
PetscErrorCode FlowRefuse(const TermView *v, const Stage *stage, const char *message);
/* Whether water flows in the stage, and the row of its loads that stands for it in the list of loads. */
PetscBool FlowActs(const Scene *scene, const Stage *stage, PetscInt *carrier);
/* Whether it does in any stage. */
PetscBool FlowEverActs(const Scene *scene);
/* Collective. Names in the mesh that conditions ask for; refuses what cannot be. */
PetscErrorCode FlowCreate(const TermView *v, Flow **flow);
PetscErrorCode FlowDestroy(const Scene *scene, Flow **flow);
/* ---- flow.c */
/* Collective. A stage begins: the flow through the joints as they are. */
PetscErrorCode FlowBegin(const TermView *v);
/* Collective. At equilibrium, and on the way to it where that is near enough for a round: the flow through
   the joints as they have become. again: pressures change. */
PetscErrorCode FlowSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
/* Adds the forces of the pressures that act and stay; what keeps its volume acts by FlowTrapForces. u, f:
   vertex arrays. */
void FlowForces(const Flow *flow, const Scene *scene, const Model *m, const PetscReal *u, PetscReal *f);
/* Collective. What remains to be done when a step of the water is over, and whether water was made or
   lost; grow: [-] by how much longer the next one may be. */
PetscErrorCode FlowStepOver(const TermView *v, StageResult *result, PetscReal *grow);
/* Makes what has been put back whole: network, pushes and flow from its rows. */
PetscErrorCode FlowFresh(const TermView *v);
/* [Pa] What presses at an end of a piece. */
PetscReal FlowPressure(const Flow *flow, const Scene *scene, PetscInt piece, int end);

/* ---- coupling.c */
/* Sets the pressures that act in the next round. */
PetscErrorCode FlowNextRound(Flow *flow);

/* ---- flow_memory.c: as rows of the table of terms have them */
PetscErrorCode FlowHistory(const TermView *v, TermHistory what);
PetscErrorCode FlowArchive(Archive *a, const TermView *v);
PetscErrorCode FlowArchiveStable(Archive *a, const TermView *v);

/* ---- undrained.c */
/* Collective. From now on the water of all pieces keeps its volume. */
PetscErrorCode FlowTrapAll(const TermView *v);
PetscErrorCode FlowTrapsFree(Flow *flow);
/* Whether the water of a piece keeps its volume. */
PetscBool FlowTrapped(const Flow *flow, PetscInt piece);
/* Traps in either direction. */
PetscErrorCode FlowTrapsArchive(Archive *a, const Model *m, Flow *flow);
/* Collective. Notes the pressures at ends of pieces as they are now. */
PetscErrorCode FlowTrapsRecord(const TermView *v);
/* Adds resisting forces [N], and bounds of the stiffness [N/m]. u, f, k: vertex arrays. */
void FlowTrapForces(Flow *flow, const Model *m, const PetscReal *u, PetscReal *f);
void FlowTrapBound(const Flow *flow, const Model *m, PetscReal *k);
/* [J] Stored, on this rank. */
PetscReal FlowTrapEnergy(const Flow *flow, const Model *m, const PetscReal *u);

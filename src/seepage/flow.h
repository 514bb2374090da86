/* flow.h: declares the flow of water in joints and its pressure on the faces, for the files of this room.

   The water of a joint flows between plates (cubic law). A contact is a stretch of such a joint. Along it
   aperture + opening varies linearly. The hydraulic width is this sum, limited to aperture_residual and
   aperture_max. A node of the network is a void: ends of contacts that meet in it. Drains and the edges of
   curtains cut contacts into pieces, with a node at each cut. The unknowns are heads; pressure acts on the
   blocks as an external force, as uplift does, so the stress of a joint is its effective stress. */
#pragma once
#include "seepage/seepage.h"

/* ---- flow_rows.c */
/* A contact in which water may flow, the same on all ranks. Ends are numbered as sub-contacts. */
typedef struct {
  PetscInt key[2];       /* gids of its faces */
  PetscInt joint;        /* row of the joints table */
  PetscInt parted;       /* its faces have parted: the contact is no longer in the list of contacts */
  PetscInt shut;         /* it lets no water in until it fails */
  PetscInt failed[2];    /* an end has opened, slipped or broken at any time so far */
  PetscInt vertex[2][2]; /* gids of the vertices in the void of each end; -1: only one vertex stands there */
  PetscReal x[2][2];     /* [m] places of the ends */
  PetscReal t[2][2];     /* [-] t[s][k]: position of end k along face s */
  PetscReal opening[2];  /* [m] openings of the ends, 0: the joint just bears */
  PetscReal length;      /* [m] */
} FlowRow;
enum { ROW_INTS = 11, ROW_REALS = 11 };

/* Collective. Gathers the contacts of joints with an aperture, sorted by key. */
PetscErrorCode FlowRowsGather(const Model *m, const Contacts *c, const Joint *joints, const PetscReal *u,
                              PetscInt *n, FlowRow **rows);
/* Collective. Copies the history of the rows in `before` to *rows: an end that has failed stays failed.
   Appends the contacts whose faces have parted since, with the present gap of their faces as opening. */
PetscErrorCode FlowRowsFollow(const Model *m, const Joint *joints, const PetscReal *u, PetscInt n_before,
                              const FlowRow *before, PetscInt *n, FlowRow **rows);

/* ---- network.c */
/* A stretch of a contact between two nodes. */
typedef struct {
  PetscInt row;          /* its contact */
  PetscInt node[2];      /* the voids at its ends */
  PetscReal s[2];        /* [-] positions of its ends along the contact */
  PetscReal length;      /* [m] */
  PetscReal a[2];        /* [m] apertures at its ends */
  PetscReal conductance; /* [m2/s] discharge per metre of head difference */
} FlowPiece;

typedef enum {
  NODE_FREE,
  NODE_HEAD, /* under water: the head is prescribed */
  NODE_SEEP  /* at a face above the water or at a freely running drain: water leaves without pressure */
} FlowNodeKind;
/* State of a node: heads.c. */
typedef enum { WET, PARTLY, DRY } FlowWetness;
typedef struct {
  FlowNodeKind kind;
  PetscInt load;         /* row of the scene's loads that prescribes its condition, -1: none */
  PetscReal x[2];        /* [m] */
  PetscReal head;        /* [m] head of NODE_HEAD, or outside a drain with resistance */
  PetscReal conductance; /* [m2/s] conductance of a drain with resistance, 0: none */
  PetscReal inflow;      /* [m2/s] */
  FlowWetness first;     /* state with which the search for the free surface begins */
  /* [m2/s] rate of storage in transient flow: wet[0] psi + wet[1] if wet, part[0] chi + part[1] if partly
     filled */
  PetscReal wet[2], part[2];
} FlowNode;

/* A drain with resistance. A node with several drains has the sum of their conductances, and the outside
   head that gives the sum of their discharges. */
typedef struct {
  PetscInt node, load;
  PetscReal head, conductance; /* [m] outside head; [m2/s] */
} FlowDrain;

/* The mesh entities that a condition of the scene names, the same on all ranks. */
typedef struct {
  PetscInt n_faces, *faces, n_vertices, *vertices; /* gids, ascending */
  PetscBool from_end; /* a drain at a distance: the upstream side (heel) is at the end of the drain's joint */
} FlowTarget;

typedef struct {
  PetscInt n_rows, n_pieces, n_nodes;
  FlowRow *row;     /* (n_rows,) */
  FlowPiece *piece; /* (n_pieces,) in the order of rows */
  FlowNode *node;   /* (n_nodes,) */
  PetscInt n_drains;
  FlowDrain *drain; /* (n_drains,) */
  PetscReal step;   /* [s] time step of the water, 0: steady flow */
} FlowNetwork;

/* Builds nodes and pieces from net->row and the conditions of the stage's loads. target: (n_loads,). unmet
   receives the first condition that meets no joint, message the first contradiction between conditions
   ("": none). Both texts follow the name of the scene's file. */
PetscErrorCode FlowNetworkBuild(const Scene *scene, const Stage *stage, const FlowTarget *target,
                                PetscReal reach, FlowNetwork *net, char unmet[MESSAGE_LENGTH],
                                char message[MESSAGE_LENGTH]);
PetscErrorCode FlowNetworkDestroy(FlowNetwork *net);
/* Computes apertures and conductances of the pieces from the rows. */
void FlowConduct(const Scene *scene, const Stage *stage, FlowNetwork *net);

/* ---- storage.c */
/* The water at an end of a piece. */
typedef struct {
  PetscInt key[2];
  PetscReal s;        /* [-] position along the contact */
  PetscReal a;        /* [m] aperture that stores the water */
  PetscReal psi, chi; /* [m], [-] pressure head and saturation */
  PetscReal length;   /* [m] length of the piece; the water fills the half at this end */
  PetscReal volume;   /* [m] volume per length of that half: a (chi + p / K_w) */
  FlowWetness wetness;
} FlowWater;
/* Returns the compliance [m/Pa] of the aperture at an end of a piece, from the normal stiffness of the
   joint. Returns 0 where the aperture is at its least or largest value. */
PetscReal FlowCompliance(const Scene *scene, const Stage *stage, const FlowNetwork *net, PetscInt piece,
                         int end);
/* Two steps of the water form a second-order pair (storage.c). The second step is FLOW_SECOND times as
   long as the first; its own flow acts over 1 / FLOW_SECOND of it. */
static const PetscReal FLOW_SECOND = 2.4142135623730951; /* 1 + sqrt(2) */
/* Extrapolates the volumes in the middle of a pair, (n_middle,), to the state from which its second step
   begins. start: (n_start,) the water when the pair began. */
void FlowAhead(const FlowWater *start, PetscInt n_start, FlowWater *middle, PetscInt n_middle);
/* Computes the storage coefficients of all nodes for the step net->step from the earlier water `past`,
   (n,) in the order of pieces. A contact without an entry in `past` was empty. reference: (n_nodes,) [m]
   pressure heads at which the apertures were measured. */
void FlowStore(const Scene *scene, const Stage *stage, const FlowWater *past, PetscInt n,
               const PetscReal *reference, FlowNetwork *net);
/* Interpolates the water at position s of a contact from a list in the order of pieces. Returns false if
   the contact was empty there. within: another position on the same piece; it selects the piece where two
   meet at s. */
PetscBool FlowWaterAt(const FlowWater *past, PetscInt n, const PetscInt key[2], PetscReal s, PetscReal within,
                      FlowWater *water);

/* ---- heads.c */
/* Flow of a network. Arrays are (n_nodes,) unless marked. */
typedef struct {
  PetscReal *pressure;   /* [m] of water, >= 0 */
  PetscReal *saturation; /* [-] 0..1, 1 below the free surface */
  PetscReal *stream;     /* [-] 0..1, stream that falls from a node over the stream of a full node */
  PetscReal *stored;     /* [m2/s] rate of storage at each node in transient flow */
  PetscReal *drained;    /* [m2/s] discharge into drains with resistance */
  PetscReal *outflow;    /* [m2/s] discharge out of the joints at a node with a condition */
  PetscReal *discharge;  /* [m2/s] (n_pieces,) from the first node of a piece to its second */
  FlowWetness *wetness;  /* final states; a search that begins with them ends at once, with the same bits */
  PetscBool *cut_off;    /* dry: no path leads to a head, an inflow or a drain under water */
  PetscReal error; /* [-] largest imbalance of a node over the total inflow; also bounds the relative error
                      of heads */
  PetscReal inflow, taken; /* [m2/s] sums over all nodes: inflow; rate of storage */
  PetscInt rounds;         /* iterations of the free surface */
} FlowSolution;
PetscErrorCode FlowSolve(const FlowNetwork *net, FlowSolution *flow, char message[MESSAGE_LENGTH]);
/* Finds the nodes without a connection to water, (n_nodes,). message receives the first inflow without an
   outlet. */
PetscErrorCode FlowFindCutOff(const FlowNetwork *net, PetscBool *cut_off, char message[MESSAGE_LENGTH]);
PetscErrorCode FlowSolutionDestroy(FlowSolution *flow);

/* ---- coarse.c */
/* Estimates the node states with which the search in a large network begins. */
PetscErrorCode FlowGuess(FlowNetwork *net);

/* ---- coupling.c */
enum { MIXED = 3 }; /* earlier rounds that Anderson's method uses */
/* The fixed-point iteration x = g(x), where x are the acting pressures and g(x) the pressures of the flow
   that they cause. */
typedef struct {
  PetscInt n, n_old;              /* unknowns; stored rounds, the newest first */
  PetscReal *x[MIXED], *g[MIXED]; /* (n,) each */
} Mixer;
/* Replaces x, (n,), by the next trial values, computed from x and g(x); both are >= 0. */
PetscErrorCode MixerNext(Mixer *mixer, PetscInt n, const PetscReal *g, PetscReal *x);
PetscErrorCode MixerReset(Mixer *mixer);

/* ---- the memory of the term */
/* Scalars that continue from step to step. Checkpoints hold them in this order. */
typedef struct {
  PetscReal change; /* [-] relative change of pressure in the last round */
  PetscReal volume, volume_0, taken,
      entered;     /* [m2] water in joints: now, at the start of the stage; stored since then, and inflow
                      since then */
  PetscReal early; /* [-] unbalanced ratio below which the next round begins before equilibrium */
  PetscReal first; /* [s] length of the last step if it was the first of a pair (storage.c), else 0 */
  PetscReal first_taken, first_entered, first_change; /* [m2], [m2], [-] its storage, inflow and change */
  PetscReal within; /* [-] acting step of the water over the step of the stage: below 1 in the second step
                       of a pair */
} FlowSums;
enum { FLOW_SUMS = sizeof(FlowSums) / sizeof(PetscReal) };
/* A face of this rank on which a piece presses. */
typedef struct {
  PetscInt piece, side, face; /* face: row of model->faces */
} FlowPush;
typedef struct _p_Flow {
  FlowTarget *target; /* (n_loads,) */
  FlowNetwork net;
  FlowSolution now;  /* flow for the last measured openings */
  PetscReal *acting; /* (n_nodes,) [m] pressure heads that press on the blocks */
  PetscInt n_push;
  FlowPush *push; /* (n_push,) in the order of pieces */
  Mixer mixer;
  PetscInt rounds; /* coupling rounds of this stage */
  FlowSums sums;
  char unmet[MESSAGE_LENGTH]; /* first condition that meets no joint of net, "": none */
  PetscReal *reference;       /* (n_nodes,) [m] pressure heads at which the apertures were measured */
  PetscInt n_past, n_present;
  FlowWater *past, *present; /* water at ends of pieces: at the start of its step; now */
  PetscReal step_change; /* [-] change of pressure in the time step of the water, over the largest pressure */
  PetscBool stale;       /* net and now must be rebuilt from net.row; acting has n_nodes entries */
  PetscBool frozen;      /* dynamic stage: no water flows */
  PetscInt n_stable;     /* rows of the last stable trial, and the pressures that acted then */
  FlowRow *row_stable;
  PetscReal *acting_stable;
  PetscInt n_acting_stable, rounds_stable;
  PetscInt n_present_stable; /* water and scalars at the end of the last step of a transient stage */
  FlowWater *present_stable;
  FlowSums sums_stable;
} Flow;
/* ---- storage.c */
/* Returns the volume error [-] since the start of a transient stage: change of volume minus storage, over
   the water that has moved. */
PetscReal FlowVolumeError(const Flow *flow);
static const PetscReal FLOW_VOLUME_WARN = 1e-6, FLOW_VOLUME_WRONG = 1e-3; /* a run warns; it ends */
/* Sets the verdict to undecided if the volume error of the water is too large. */
PetscErrorCode FlowJudgeVolume(const Flow *flow, StageResult *result);
/* Returns the discharge [m2/s] out of the joints at the nodes of a load; negative: inflow. n receives the
   number of these nodes. */
PetscReal FlowDischarge(const Flow *flow, PetscInt load, PetscInt *n);
/* Rank 0. Prints the water balance of a transient stage. Warns if it does not close. */
void FlowReportVolume(const TermView *v);
/* ---- flow_setup.c */
/* Returns the distance [m] within which ends of contacts share a void. */
PetscReal FlowReach(const Scene *scene, const Model *m);
/* Collective. Refuses a stage. message follows the name of the scene's file; "": nothing is wrong. */
PetscErrorCode FlowRefuse(const TermView *v, const Stage *stage, const char *message);
/* Decides whether water flows in a stage. carrier receives the row of the load that represents the flow in
   the list of loads. */
PetscBool FlowActs(const Scene *scene, const Stage *stage, PetscInt *carrier);
/* Decides whether water flows in any stage. */
PetscBool FlowEverActs(const Scene *scene);
/* Collective. Finds the mesh entities that conditions name; refuses conditions that cannot act. */
PetscErrorCode FlowCreate(const TermView *v, void **memory);
PetscErrorCode FlowDestroy(const Scene *scene, void **memory);
/* ---- flow.c */
/* Collective. Begins a stage: solves the flow for the present openings. */
PetscErrorCode FlowBegin(const TermView *v);
/* Collective. Recomputes the flow for the present openings: at equilibrium, and before it where the
   unbalanced ratio is small enough for a round. again receives whether pressures change. */
PetscErrorCode FlowSettle(const TermView *v, TermMoment when, StageResult *result, PetscBool *again);
/* Adds the forces [N] of the acting pressures. u, f: vertex arrays. */
void FlowForces(const Flow *flow, const Scene *scene, const Model *m, const PetscReal *u, PetscReal *f);
/* Rebuilds network, pushes and flow from the rows after they were restored. */
PetscErrorCode FlowFresh(const TermView *v);
/* Returns the pressure [Pa] at an end of a piece. */
PetscReal FlowPressure(const Flow *flow, const Scene *scene, PetscInt piece, int end);

/* ---- coupling.c */
/* Computes the acting pressures of the next coupling round. */
PetscErrorCode FlowNextRound(Flow *flow);

/* ---- flow_memory.c: entries of the table of terms */
PetscErrorCode FlowHistory(const TermView *v, TermHistory what);
PetscErrorCode FlowArchive(Archive *a, const TermView *v);
PetscErrorCode FlowArchiveStable(Archive *a, const TermView *v);

/* scene.h: what the user asked for. read.c fills it from the YAML scene and the command line; it is constant
   afterwards. Units and signs are those of base.h. */
#pragma once
#include "base/base.h"

enum { LABEL_LENGTH = 6 * NAME_LENGTH }; /* length of a dotted key */

typedef enum { PLANE_STRAIN, PLANE_STRESS } PlaneState;
typedef enum { STRAIN_LARGE, STRAIN_SMALL } StrainMeasure;
typedef enum { ELEMENT_FULL, ELEMENT_BENDING, ELEMENT_REDUCED } Formulation; /* of blocks of 4 vertices */
typedef enum { LAW_MOHR_COULOMB, LAW_ELASTIC } JointLawKind;
typedef enum {
  STRESS_PT,   /* of fixed control points; those before STRESS_R2PT have a potential */
  STRESS_R2PT, /* from here on they have none */
  STRESS_R3PT,
  STRESS_T2PT,
  STRESS_T3PT,
  STRESS_TPTM, /* from here on control points move; contacts are sorted by model */
  STRESS_MODELS
} StressModelKind;
typedef enum { LOAD_SELF_WEIGHT, LOAD_RESERVOIR, LOAD_TRACTION, LOAD_POINT_FORCE, LOAD_UPLIFT } LoadKind;
typedef enum { UPLIFT_LINEAR, UPLIFT_NPB, UPLIFT_USBR, UPLIFT_USACE, UPLIFT_FERC } UpliftRule;
typedef enum { UPLIFT_BOTH, UPLIFT_VERTICAL } UpliftComponent;
typedef enum { HEEL_START, HEEL_END } UpliftHeel;
typedef enum { RAISE_WHOLE, RAISE_TO_DRAIN } UpliftRaise;
typedef enum { REACHES_HEEL, REACHES_ANY } UpliftReach;
typedef enum { METHOD_EXPLICIT, METHOD_PRECONDITIONED, METHOD_AUTO } MethodKind;
typedef enum { DAMPING_ADAPTIVE, DAMPING_PAPER, DAMPING_FIXED, DAMPING_LOCAL, DAMPING_NONE } DampingKind;
typedef enum { STAGE_STATIC, STAGE_DYNAMIC, STAGE_STRENGTH_REDUCTION, STAGE_FLOOD } StageKind;
typedef enum { REDUCE_FRICTION, REDUCE_STRENGTHS } ReductionKind;
typedef enum { CONNECTIVITY_FIXED, CONNECTIVITY_VARIABLE } Connectivity;
typedef enum { PARTITION_METIS, PARTITION_STRIPES } PartitionKind;
typedef enum { EXCHANGE_AUTO, EXCHANGE_MESSAGES } ExchangeKind;
typedef enum { REPARTITION_AUTO, REPARTITION_NEVER } RepartitionKind;
typedef enum { MOTION_VELOCITY, MOTION_ACCELERATION } MotionQuantity;

typedef struct {
  char name[NAME_LENGTH];   /* name of a group of the mesh */
  PetscReal density;        /* [kg/m3] >= 0 (0: weightless; a static stage scales masses anyway) */
  PetscReal young, poisson; /* [Pa], [-]; not needed for a rigid group */
  Formulation element;      /* see element_kernels.h */
  PetscReal hourglass;      /* [-] ELEMENT_REDUCED: stiffness against hourglass modes */
  PetscInt rigid;           /* -1: as the mesh says, 0: deformable, 1: rigid; 0 or 1 after SceneResolve */
  PetscBool macroblocks;    /* blocks that share a vertex are one body; false: each block is one of its own */
  PetscBool condensed;      /* deformable, and reduced onto the vertices where it meets others: condense.c */
  PetscReal velocity[2];    /* [m/s] at the start of the first dynamic stage */
  PetscReal spin;           /* [rad/s] at that start, about each body's mass centre */
  PetscBool upgradeable;    /* its contacts are verified and searched for under variable connectivity */
  PetscBool output;         /* its blocks are written into results.h5 */
  PetscReal tension, compression, cohesion, friction; /* [Pa], [Pa], [Pa], [degree] strengths for the local
                                                         failure factors (39)-(41); NaN: not given */
  int line; /* line in the scene file, for messages, here and below; 0: command line */
} Material;

/* Properties of a joint, of a pair of groups, or of the default. Index [0]: peak, [1]: residual, after the
   joint has failed there in tension or shear. */
typedef struct {
  char name[NAME_LENGTH]; /* face set of the mesh, or "groupA+groupB", or "default" */
  JointLawKind law;
  StressModelKind stress_model;
  PetscReal k_n, k_s;    /* [Pa/m] */
  PetscReal friction[2]; /* [degree] */
  PetscReal tan_phi[2];  /* [-] of friction; JointPrepare writes it */
  PetscReal cohesion[2]; /* [Pa] */
  PetscReal tension[2];  /* [Pa] tensile strength, >= 0 */
  PetscReal compression; /* [Pa] compressive strength, > 0, PETSC_INFINITY: none */
  PetscReal damping;     /* [s] dynamic stages: normal dashpot, damping * k_n per unit area, while closed */
  PetscBool defined;     /* false only for row 0 when the scene gives no "default": then all else is 0 */
  int line;
} Joint;

typedef struct {
  char name[NAME_LENGTH];
  char target[NAME_LENGTH]; /* face set, group or point of the mesh; by default the support's own name */
  PetscBool fix[2];         /* x, y: whether the support fixes it */
  char motion[PETSC_MAX_PATH_LEN]; /* dynamic stages: CSV file of t [s], x, y; "": it does not move */
  PetscInt row;                    /* row of the support in Scene.supports */
  MotionQuantity quantity;         /* what x, y in the file are: [m/s] or [m/s2] */
  PetscInt n_rows;                 /* of the file; SceneReadMotions */
  PetscReal *t;                    /* [s] (n_rows,) ascending, at most two the same */
  PetscReal *xy;                   /* (n_rows,2) */
  int line;
} Support;

/* What an uplift has besides the keys of a reservoir; see uplift.c. */
typedef struct {
  UpliftRule rule;
  UpliftComponent component;
  UpliftHeel heel;           /* which end of the joint is upstream */
  UpliftRaise raise;         /* what a flood stage raises: the whole diagram, or only up to the drain */
  PetscBool cracked;         /* the full head acts along the open part of the joint */
  UpliftReach reaches;       /* cracked: which open stretches the full head reaches */
  PetscReal crack_tolerance; /* [m] tolerance of the iteration for the open length */
  PetscReal tailwater;       /* [m] elevation of the water downstream, NaN: none */
  PetscReal drain;           /* [m] distance of the drain from the heel along the joint, NaN: none */
  PetscReal gallery;         /* [m] elevation where the drain opens, NaN: none */
  PetscReal efficiency;      /* [-] efficiency of the drain, NaN until the rule has set it */
  PetscReal drain_level;     /* [m] level for the pressure at the drain; the same as level except in floods */
} UpliftKeys;

typedef struct {
  char name[NAME_LENGTH];
  LoadKind kind;
  PetscInt n_groups; /* self_weight: number of groups it acts on; 0: all */
  char (*groups)[NAME_LENGTH];
  char target[NAME_LENGTH]; /* reservoir, traction: face set; point_force: point */
  PetscReal level;          /* [m] reservoir: elevation of the water surface */
  PetscReal density;        /* [kg/m3] reservoir: density of the water */
  PetscReal traction[2];    /* [Pa] traction x, y; point_force: [N/m of thickness] */
  UpliftKeys uplift;        /* of an uplift; target, level and density as of a reservoir */
  int line;
} Load;

typedef struct {
  char name[NAME_LENGTH];
  StageKind kind;
  PetscInt n_loads;    /* loads that act at its end; a load of the stage before that is not among them goes */
  PetscInt *loads;     /* (n_loads,) rows of Scene.loads */
  PetscInt ramp;       /* [cycles] over which loads change linearly from the last stage's to this one's */
  PetscInt max_cycles; /* [cycles] after which the verdict is "undecided" */
  PetscReal tolerance; /* [-] unbalanced ratio, largest over bodies, below which the stage has converged */
  PetscReal velocity_tolerance; /* [-] largest displacement increment of a cycle over largest displacement, as
                                   the ratio */
  PetscInt variable;   /* 1: connectivity is variable in this stage, 0: fixed, -1: as Scene.connectivity */
  PetscReal duration;  /* [s] of a dynamic stage */
  PetscReal dt_factor; /* [-] dynamic: time step over its stability bound */
  PetscReal alpha;     /* [1/s] dynamic: mass-proportional damping */
  PetscInt frames;     /* dynamic: number of results on the way, at equal intervals */
  Joint *joints;       /* (n_joints,) joints table of this stage: Scene.joints with all changes so far; a
                          strength reduction leaves the strengths of its last stable trial here */
  /* strength_reduction, flood: trials go from start towards limit; see trial_stage.c */
  ReductionKind what;
  PetscInt n_reduce; /* number of joints that are reduced; 0: all */
  char (*reduce)[NAME_LENGTH];
  PetscReal start, step, limit; /* [degree], [-] or [m]; NaN: not given */
  PetscReal factor;  /* [-] strengths: each trial has this part of the strengths of the trial before */
  PetscReal bracket; /* [degree], [-] or [m] width at which bisection ends; 0: none */
  PetscReal
      displacement_limit; /* [m] a trial fails that has moved farther since the stage began; NaN: no limit */
  PetscInt n_rises;       /* flood: number of loads named; 0: the highest reservoir rises */
  PetscInt *rises;        /* (n_rises,) rows of Scene.loads */
  bool *level_rises, *tail_rises; /* flood: (Scene.n_loads,) loads whose level, whose tailwater rises */
  int line;
} Stage;

/* What an entry of a section begins with that a force term has of its own. */
typedef struct {
  char name[NAME_LENGTH];
  int line;
} TermEntry;
#define TERM_STRUCTS
#include "scene/term_sections.h"
#undef TERM_STRUCTS

typedef struct {
  char file[PETSC_MAX_PATH_LEN];   /* the YAML file, for messages; "" when there is none */
  char model[PETSC_MAX_PATH_LEN];  /* path of model.h5 */
  char output[PETSC_MAX_PATH_LEN]; /* folder for results */
  char title[256];
  PetscReal advise; /* [-] accuracy for which advise.c looks for simplifications, 0: the scene is run */
  PlaneState plane;
  StrainMeasure strain;
  PartitionKind partition;
  ExchangeKind exchange;
  InstructionSet isa;  /* the user's choice; instruction_set of lanes.h is in use */
  PetscReal thickness; /* [m] */
  PetscReal gravity;   /* [m/s2] in direction -y */
  /* contacts */
  PetscReal contact_tolerance; /* [m] activation tolerance on the opening of both sub-contacts */
  PetscBool contact_relative;  /* contact_tolerance is a fraction of the smaller face instead */
  Connectivity connectivity;   /* for stages that give none */
  PetscReal verify_after;      /* [-] verify when a vertex has moved this part of the contact tolerance */
  PetscReal vertex_length;     /* [-] least influence length of a vertex on a face, over the shorter face */
  PetscReal overlap_tolerance; /* [m] depth to which two macroblocks of the mesh may overlap */
  /* relaxation */
  MethodKind method;   /* method of static stages */
  PetscReal effort;    /* preconditioned: limit of solves times degrees of freedom between equilibria */
  PetscInt increments; /* preconditioned: steps in which ramped loads are applied */
  DampingKind damping;
  PetscReal alpha_dt;        /* [-] fixed damping: alpha dt */
  PetscReal local;           /* [-] local damping: State.local */
  PetscReal beta;            /* [-] adaptive damping: State.beta */
  PetscInt n_damping_groups; /* number of groups in the Rayleigh quotient; 0: all */
  char (*damping_groups)[NAME_LENGTH];
  PetscReal safety;         /* [-] of the time step: masses belong to a step that is 1/safety times longer */
  PetscBool allow_floating; /* accept bodies that no support holds */
  PetscInt check_every;     /* [cycles] between tests of convergence */
  PetscInt history_every;   /* [cycles] between rows of history.csv */
  RepartitionKind repartition;
  PetscInt repartition_every; /* [cycles] between looks for a better partition */
  PetscReal repartition_gain; /* [-] part of the busiest rank's work that a new partition must save */
  /* checkpoints */
  char restart[PETSC_MAX_PATH_LEN]; /* file, folder or "auto"; "": a run from the start */
  PetscReal checkpoint_minutes;     /* [min] of wall time between checkpoints, 0: none by time */
  PetscInt checkpoint_every;        /* [cycles] between checkpoints, 0: none by cycles */
  PetscInt checkpoint_keep;         /* number of newest files kept */
  PetscReal memory_limit;           /* [GB] for each machine, 0: what is free there */
  PetscReal wall_limit;             /* [min] of wall time, 0: no limit */
  char *options;                    /* lines "key value": all that the scene and the command line say */
  /* tables */
  PetscInt n_materials, n_joints, n_supports, n_loads, n_stages;
  Material *materials;
  Joint *joints; /* row 0 is "default" */
  Support *supports;
  Load *loads;
  Stage *stages;
  struct {
    PetscInt n;
    void *entries;
  } * terms;     /* a row for each of TERM_SECTIONS */
  char *echo;    /* every key in force, as YAML: scene_echo.yaml */
  char *solvers; /* options for PETSc's solvers, NULL: none; petsc_options.c */
} Scene;

/* ---- petsc_options.c */
/* Collects options of solvers into scene->solvers and, if there are any, as a line of scene->options. */
PetscErrorCode SolverOptionsTake(Scene *scene);
/* Vecs of the state (model.h) that PETSc's viewers show, and their names there: option -name_view. */
typedef enum {
  STATE_DISPLACEMENT,
  STATE_VELOCITY,
  STATE_FORCE,
  STATE_LOAD,
  STATE_MASS,
  STATE_VEC_NAMES
} StateVec;
extern const char *const StateVecNames[];
/* Whether an option, less its dash, asks for such a viewer. */
PetscBool IsStateView(const char *option);
/* Refuses viewers that PETSc does not have, and, with files, those whose file cannot be written: a stage
   that comes to them may take hours. Files may lie in the output folder, so they are looked at behind it. */
PetscErrorCode StateViewsCheck(MPI_Comm comm, PetscBool files);
/* Warns of options that nothing has read: they are misspelt, belong to a solver that did not run, or name
   a view that no stage came to. */
PetscErrorCode SolverOptionsTellUnread(MPI_Comm comm);

/* ---- read.c */
/* Collective. file: YAML scene or NULL; argv: "-key value" pairs that override it. Refuses unknown keys. */
PetscErrorCode SceneRead(MPI_Comm comm, const char *file, int argc, char **argv, Scene *scene);
/* Prints every key with meaning, unit and default (what -help shows and docs/scene.md contains). */
PetscErrorCode SceneHelp(MPI_Comm comm);
PetscErrorCode SceneDestroy(Scene *scene);
/* ---- motion_file.c */
/* Collective. The rows of files of support motion, into scene->supports; refuses a file that is none. */
PetscErrorCode SceneReadMotions(MPI_Comm comm, Scene *scene);
/* The entries of a section that a force term has of its own, as the struct of its file of keys. */
const void *SceneEntries(const Scene *scene, const char *section, PetscInt *n);

/* ---- joint_table.c */
extern const char *const StressModels[]; /* PetscEnum-style list of names: pt r2pt r3pt t2pt t3pt tptm,
                                            "StressModelKind", "STRESS_" , NULL */
/* The elastic row of a stress model: F_end0 = L (a s0 + b s1), F_end1 = L (b s0 + a s1). */
void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b);
/* [degree] Largest friction of the joints that the stage reduces; has: (n_joints,) counts only those it
   marks, NULL: all. NaN: the stage reduces none. */
PetscReal ReducedFriction(const Scene *scene, const Stage *stage, const PetscInt *has);
/* Computes tan_phi from friction. */
void JointPrepare(Joint *joint);
/* Whether a strength reduction reduces this joint. */
PetscBool JointIsReduced(const Stage *stage, const Joint *joint);

/* ---- entries.c */
/* Writes "file:line: key: text" in one line, unless message already holds an earlier fault. line 0 gives
   "command line: -key_with_underscores: text"; line -1 means the file as a whole. */
void Complain(char *message, const char *file, int line, const char *key, const char *format, ...)
    PETSC_ATTRIBUTE_FORMAT(5, 6);

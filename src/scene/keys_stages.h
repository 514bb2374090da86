/* keys_stages.h: lists the keys of stages: section stages. */
#ifdef KEY_STRUCTS
typedef enum {
  STAGE_STATIC,
  STAGE_DYNAMIC,
  STAGE_STRENGTH_REDUCTION,
  STAGE_FLOOD,
  STAGE_TRANSIENT,
  STAGE_LOAD_FACTOR,
  STAGE_ANCHOR_FORCE,
  STAGE_MODES,
  STAGE_PUSHOVER,
  STAGE_KINDS
} StageKind;
typedef enum { REDUCE_FRICTION, REDUCE_STRENGTHS } ReductionKind;

typedef enum { DISPLACEMENTS_KEEP, DISPLACEMENTS_RESET } DisplacementsKind;
typedef enum {
  CONDITION_AUTO,
  CONDITION_NONE,
  CONDITION_USUAL,
  CONDITION_UNUSUAL,
  CONDITION_EXTREME,
  CONDITION_EARTHQUAKE,
  CONDITION_AFTER_EARTHQUAKE,
  CONDITION_QUASI_PERMANENT,
  CONDITION_FREQUENT,
  CONDITION_RARE
} ConditionKind;                                         /* as Conditions */
typedef enum { FRAME_GROUND, FRAME_ABSOLUTE } FrameKind; /* as Frames */
typedef struct {
  char name[NAME_LENGTH];
  StageKind kind;
  PetscInt n_loads;       /* loads that act at its end; another load of the stage before is taken away */
  PetscInt *loads;        /* (n_loads,) rows of Scene.loads */
  char from[NAME_LENGTH]; /* as the scene gives it; "": the stage before */
  PetscInt skips;         /* stages between it and the one from whose end it starts */
  PetscInt n_build; /* groups that are placed as it begins; a group that no stage builds is always there */
  char (*build)[NAME_LENGTH];
  DisplacementsKind
      displacements;   /* from here on results have all displacements, or those since this stage began */
  PetscInt ramp;       /* [cycles] over which loads change linearly from the last stage's to this one's */
  PetscInt max_cycles; /* [cycles] after which the verdict is "undecided" */
  PetscReal tolerance; /* [-] unbalanced ratio, largest over bodies, below which the stage has converged */
  PetscReal velocity_tolerance; /* [-] largest displacement increment of a cycle over largest displacement, as
                                   the ratio */
  PetscInt connectivity;        /* a Connectivity */
  PetscReal duration;           /* [s] of a dynamic or transient stage */
  PetscReal time_step;          /* [s] transient: of the water, NaN: from the change of pressure */
  PetscReal water_time, water_step; /* [s] transient, while it runs: end and length of the present step of the
                                       water; 0: water flows steadily */
  PetscReal dt_factor;              /* [-] dynamic: time step over its stability bound; NaN: auto */
  PetscReal alpha;                  /* [1/s] dynamic: mass-proportional damping */
  PetscReal beta;                   /* [s] dynamic: stiffness-proportional damping of blocks */
  PetscReal damping_ratio,
      damping_frequencies
          [2];     /* [-], [Hz] dynamic: alpha and beta follow from these; ratio NaN: they are given */
  FrameKind frame; /* dynamic: what alpha damps against */
  PetscInt frames; /* dynamic: number of results on the way, at equal intervals */
  PetscInt envelope_every; /* [cycles] dynamic: steps between samples of the envelopes; 0: none */
  Joint *joints;           /* (n_joints,) joints table of this stage: Scene.joints with all changes so far; a
                          strength reduction leaves the strengths of its last stable trial here */
  /* strength_reduction, flood, load_factor, anchor_force: trials go from start towards limit; see
     trial_stage.c */
  ReductionKind what;
  PetscInt n_reduce; /* number of joints that are reduced; 0: all */
  char (*reduce)[NAME_LENGTH];
  PetscReal start, step, limit; /* [degree], [-] or [m]; NaN: not given */
  PetscReal factor;  /* [-] strengths: each trial has this part of the strengths of the trial before */
  PetscReal bracket; /* [degree], [-] or [m] width at which bisection ends; 0: none */
  PetscReal displacement_limit; /* [m] a trial fails that has moved farther; NaN: not given */
  PetscInt n_rises; /* flood, load_factor: number of loads named; 0: the highest reservoir rises */
  PetscInt *rises;  /* (n_rises,) rows of Scene.loads */
  bool *level_rises, *tail_rises; /* flood: (Scene.n_loads,) loads whose level, whose tailwater rises */
  PetscInt n_anchors;             /* anchor_force: those that jacks pull */
  char (*anchors)[NAME_LENGTH];   /* (n_anchors,) */
  PetscReal required;             /* [-] anchor_force: by which strengths are divided */
  PetscReal friction_factor, cohesion_factor; /* [-] partial factors, by which strengths are divided */
  PetscReal pull;          /* [-] anchor_force, while it runs: what jacks pull with, over prestress */
  PetscInt count;          /* modes: how many, 0: not given */
  PetscReal up_to;         /* [Hz] modes: all up to it; infinite: no limit */
  ConditionKind condition; /* as what the sheet judges it; the solver does not ask */
  /* pushover: exactly one of point, body, group is given, or n_rises loads whose common factor is sought */
  char point[NAME_LENGTH], body[NAME_LENGTH], group[NAME_LENGTH]; /* "": not given */
  PetscReal direction[2];                                         /* [-] of the way */
  PetscInt n_path;
  PetscReal *path; /* (n_path,) [m] displacements that follow one another */
  int line;
} Stage;
#endif
#ifdef KEY_WORDS
static const char *const StageTypes[] = {
    "static",       "dynamic", "strength_reduction", "flood",     "transient", "load_factor",
    "anchor_force", "modes",   "pushover",           "StageKind", "STAGE_",    NULL};
#define TRIALS                                                                                               \
  (BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_FLOOD) | BIT(STAGE_LOAD_FACTOR) | BIT(STAGE_ANCHOR_FORCE))
#define WITH_DESIGN_STRENGTHS                                                                                \
  (BIT(STAGE_STATIC) | BIT(STAGE_DYNAMIC) | BIT(STAGE_FLOOD) | BIT(STAGE_LOAD_FACTOR) | BIT(STAGE_PUSHOVER))
static const char *const Displacements[] = {"keep", "reset", "DisplacementsKind", "DISPLACEMENTS_", NULL};
static const char *const Conditions[] = {"auto",
                                         "none",
                                         "usual",
                                         "unusual",
                                         "extreme",
                                         "earthquake",
                                         "after_earthquake",
                                         "quasi_permanent",
                                         "frequent",
                                         "rare",
                                         "ConditionKind",
                                         "CONDITION_",
                                         NULL};
static const char *const Frames[] = {"ground", "absolute", "FrameKind", "FRAME_", NULL};
static const char *const Reductions[] = {"friction", "strengths", "ReductionKind", "REDUCE_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(STAGES, "type", CHOICE, Stage, kind, "static", NULL, "",
      "static: to equilibrium; dynamic: in time; strength_reduction, flood, load_factor: trials until something fails; anchor_force: trials of less and less pull of anchors; transient: equilibria while water in joints flows in time; modes: periods and shapes of small free vibrations; pushover: equilibria along a given displacement, with the force that it takes",
      .choices = StageTypes),
  KEY(STAGES, "loads", LOADS, Stage, loads, NULL, NULL, "",
      "loads that act at the end of the stage; all others are removed", .count = offsetof(Stage, n_loads),
      .stages = ~BIT(STAGE_MODES)),
  KEY(STAGES, "loads", LOADS, Stage, loads, "= none", NULL, "",
      "modes: loads of type added_mass; all other loads stay what they are", .count = offsetof(Stage, n_loads),
      .stages = BIT(STAGE_MODES)),
  KEY(STAGES, "from", NAME, Stage, from, "= the stage before", NULL, "",
      "earlier stage from whose end it starts, with its joints: a case of its own, which runs whatever becomes of other cases"),
  KEY(STAGES, "condition", CHOICE, Stage, condition, "auto", NULL, "",
      "as what quoin report judges the stage; auto: the last static stage of a case, by its loads and its name; none: it is not judged",
      .choices = Conditions),
  KEY(STAGES, "build", NAMES, Stage, build, "= none", NULL, "",
      "static: groups that are built as the stage begins: without stress, on the deformed structure; before it they are absent",
      .count = offsetof(Stage, n_build), .stages = BIT(STAGE_STATIC)),
  KEY(STAGES, "displacements", CHOICE, Stage, displacements, "keep", NULL, "",
      "reset: displacements that are written count from the start of this stage on; stresses stay",
      .choices = Displacements),
  KEY(STAGES, "ramp", INT, Stage, ramp, "= relaxation.ramp", ">= 0", "cycles",
      "cycles over which the loads change from those of the stage before to those of this stage"),
  KEY(STAGES, "max_cycles", INT, Stage, max_cycles, "= relaxation.max_cycles", ">= 1", "cycles",
      "cycles after which the stage ends undecided; of a method that another one replaces, and whose cycles it takes back, they do not count"),
  KEY(STAGES, "tolerance", REAL, Stage, tolerance, "= relaxation.tolerance", "> 0", "-",
      "unbalanced ratio of the worst body at which the stage has converged"),
  KEY(STAGES, "velocity_tolerance", REAL, Stage, velocity_tolerance, "= relaxation.velocity_tolerance", "> 0",
      "-", "largest displacement increment of a cycle, over the largest displacement, at which the stage has converged"),
  KEY(STAGES, "variable", TRISTATE, Stage, connectivity, "= contact.connectivity", NULL, "",
      "true: variable connectivity in this stage, false: fixed"),
  KEY(STAGES, "duration", REAL, Stage, duration, "1", "> 0", "s", "dynamic, transient: duration",
      .stages = BIT(STAGE_DYNAMIC) | BIT(STAGE_TRANSIENT)),
  KEY(STAGES, "time_step", REAL, Stage, time_step, "= from the change of pressure", "> 0", "s",
      "transient: length of the steps of the water", .stages = BIT(STAGE_TRANSIENT)),
  KEY(STAGES, "dt_factor", REAL, Stage, dt_factor, "auto", "> 0, <= 1", "-",
      "dynamic: time step over the stability bound; auto: 0.9 at most, down to 1/16 of that as motion asks",
      .word = "auto", .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "alpha", REAL, Stage, alpha, "0", ">= 0", "1/s", "dynamic: mass-proportional damping",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "beta", REAL, Stage, beta, "0", ">= 0", "s",
      "dynamic: stiffness-proportional damping of the deformable groups that have no beta of their own",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "damping_ratio", REAL, Stage, damping_ratio, "= none", "> 0, < 1", "-",
      "dynamic: fraction of critical damping at two frequencies, from which alpha and beta follow",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "damping_frequencies", PAIR, Stage, damping_frequencies, "= none", NULL, "Hz",
      "dynamic: the two frequencies of damping_ratio; between them there is less damping, outside more", .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "frame", CHOICE, Stage, frame, "ground", NULL, "",
      "dynamic: reference of the velocity that alpha damps. ground: the moving supports; absolute: at rest",
      .choices = Frames, .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "frames", INT, Stage, frames, "0", ">= 0", "",
      "dynamic, transient: number of results that are written at equal intervals of time; pushover: of the way", .stages = BIT(STAGE_DYNAMIC) | BIT(STAGE_TRANSIENT) | BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "count", INT, Stage, count, "= 6, or all up to up_to", ">= 1", "",
      "modes: number of modes, the lowest frequency first", .stages = BIT(STAGE_MODES)),
  KEY(STAGES, "up_to", LIMIT, Stage, up_to, "inf", "> 0", "Hz", "modes: highest frequency",
      .stages = BIT(STAGE_MODES)),
  KEY(STAGES, "envelope_every", INT, Stage, envelope_every, "0", ">= 0", "cycles",
      "dynamic: steps between samples of the extremes of stress, safety factor, opening and slip of each block and contact; 0: none",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "what", CHOICE, Stage, what, "friction", NULL, "",
      "strength_reduction: what is reduced: the angle of friction, or all strengths by one factor", .choices = Reductions,
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "reduce", NAMES, Stage, reduce, "= all that are not elastic", NULL, "",
      "strength_reduction: joints that are reduced; anchor_force: those whose strengths are divided by required",
      .count = offsetof(Stage, n_reduce), .stages = BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_ANCHOR_FORCE)),
  KEY(STAGES, "anchors", NAMES, Stage, anchors, NULL, NULL, "",
      "anchor_force: prestressed anchors; jacks pull all of them with the same fraction of their prestress", .count = offsetof(Stage, n_anchors),
      .stages = BIT(STAGE_ANCHOR_FORCE)),
  KEY(STAGES, "required", REAL, Stage, required, "1", "> 0", "-",
      "anchor_force: factor by which friction, cohesion, tensile and compressive strength of joints are divided",
      .stages = BIT(STAGE_ANCHOR_FORCE)),
  KEY(STAGES, "start", REAL, Stage, start, "1", "> 0", "-",
      "anchor_force: force of the jacks over prestress in the first trial, with which it must stand",
      .stages = BIT(STAGE_ANCHOR_FORCE)),
  KEY(STAGES, "rises", LOADS, Stage, rises, "= the highest reservoir", NULL, "",
      "flood: waters that rise; an uplift or a wave at the level of such a reservoir follows; all others stay",
      .count = offsetof(Stage, n_rises), .stages = BIT(STAGE_FLOOD)),
  KEY(STAGES, "raises", LOADS, Stage, rises, NULL, NULL, "",
      "load_factor: loads whose forces are multiplied by one factor; all others stay",
      .count = offsetof(Stage, n_rises), .stages = BIT(STAGE_LOAD_FACTOR)),
  KEY(STAGES, "point", NAME, Stage, point, "= none", NULL, "",
      "pushover: named point of the mesh that is moved; give exactly one of point, body, group, pushes",
      .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "body", NAME, Stage, body, "= none", NULL, "",
      "pushover: named point of the body whose centroid is moved; it may turn", .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "group", NAME, Stage, group, "= none", NULL, "",
      "pushover: group whose mean displacement is prescribed", .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "pushes", LOADS, Stage, rises, "= none", NULL, "",
      "pushover: loads that push by one factor, which is sought; they move the points where they act by the path, in the mean weighted by their forces",
      .count = offsetof(Stage, n_rises), .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "direction", PAIR, Stage, direction, "1, 0", NULL, "-",
      "pushover: direction (x, y) of path and force; of any length; of pushes that of their resultant",
      .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "path", NUMBERS, Stage, path, NULL, NULL, "m",
      "pushover: displacements, one after another, counted from the equilibrium under the loads of the stage",
      .count = offsetof(Stage, n_path), .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "step", REAL, Stage, step, "= a hundredth of the way", "> 0", "m",
      "pushover: longest increment of the displacement; each ends at an equilibrium and a row of history.csv",
      .stages = BIT(STAGE_PUSHOVER)),
  KEY(STAGES, "start", REAL, Stage, start, "1", ">= 0", "-",
      "load_factor: first factor; 0: without these loads", .stages = BIT(STAGE_LOAD_FACTOR)),
  KEY(STAGES, "start", REAL, Stage, start, "= as the joints are", "> 0", "degree or -",
      "strength_reduction: first angle of friction, or part of the strengths that is left",
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "step", REAL, Stage, step, "= none: bisection only", "> 0", "degree, m or -",
      "change of the angle of friction or of the pull, or rise of the level or factor, from trial to trial",
      .stages = TRIALS),
  KEY(STAGES, "factor", REAL, Stage, factor, "= none: bisection only", "> 0, < 1", "-",
      "strength_reduction, strengths: part of them that a trial leaves (0.85: 15 % less)",
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "limit", REAL, Stage, limit, "= 0 for a reduction and for anchors", NULL, "degree, - or m",
      "value at which the trials end", .stages = TRIALS),
  KEY(STAGES, "bracket", REAL, Stage, bracket, "0", ">= 0", "degree, - or m",
      "bisection between the last stable and the first unstable trial down to this width; 0: none",
      .stages = TRIALS),
  KEY(STAGES, "displacement_limit", LIMIT, Stage, displacement_limit, "= by the size", "> 0", "m",
      "trials: a trial fails that comes to rest after it has moved farther since the stage began; if not given, 1 % of the diagonal of the box around all bodies that no support holds; inf: no limit",
      .stages = TRIALS),
  KEY(STAGES, "friction_factor", REAL, Stage, friction_factor, "1", "> 0", "-",
      "partial factor on friction: tan(friction) of all joints is divided by it in this stage; a stage that starts from it has full strengths again",
      .stages = WITH_DESIGN_STRENGTHS),
  KEY(STAGES, "cohesion_factor", REAL, Stage, cohesion_factor, "1", "> 0", "-",
      "partial factor on cohesion and tensile strength, as friction_factor", .stages = WITH_DESIGN_STRENGTHS),
  KEY(STAGES, "joints.<name>", CHANGES, Stage, joints, "= as before", NULL, "",
      "any key of this joint, changed from this stage on"),
#endif
    // clang-format on

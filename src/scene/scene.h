/* scene.h: declares the scene, the input of the user. read.c fills it from the YAML scene and the command
   line; it is constant afterwards. Units and signs are those of base.h. */
#pragma once
#include "base/base.h"

enum { LABEL_LENGTH = 6 * NAME_LENGTH }; /* length of a dotted key */

typedef enum { PLANE_STRAIN, PLANE_STRESS } PlaneState;
typedef enum { STRAIN_LARGE, STRAIN_SMALL } StrainMeasure;
typedef enum { METHOD_EXPLICIT, METHOD_PRECONDITIONED, METHOD_STIFFNESS_MASS, METHOD_AUTO } MethodKind;
typedef enum { DAMPING_ADAPTIVE, DAMPING_PAPER, DAMPING_FIXED, DAMPING_LOCAL, DAMPING_NONE } DampingKind;
/* Whether contacts stay as they are; CONNECTIVITY_AUTO: until they are outgrown (contact_travel.c). */
typedef enum { CONNECTIVITY_FIXED, CONNECTIVITY_VARIABLE, CONNECTIVITY_AUTO } Connectivity;
typedef enum { GAPS_CLOSED, GAPS_REAL } InitialGaps;
typedef enum { PARTITION_METIS, PARTITION_STRIPES } PartitionKind;
typedef enum { EXCHANGE_AUTO, EXCHANGE_MESSAGES } ExchangeKind;

/* First member of an entry of a section of a force term. */
typedef struct {
  char name[NAME_LENGTH];
  int line;
} TermEntry;
#define KEY_STRUCTS
#include "scene/sections.h"
#undef KEY_STRUCTS

typedef struct {
  char file[PETSC_MAX_PATH_LEN];   /* the YAML file, for messages; "" when there is none */
  char model[PETSC_MAX_PATH_LEN];  /* path of model.h5 */
  char output[PETSC_MAX_PATH_LEN]; /* folder for results */
  char title[256];
  PetscReal advise; /* [-] accuracy for which advise.c looks for simplifications, 0: the scene is run */
  char guidelines[PETSC_MAX_PATH_LEN]; /* limits of guidelines for the sheet, "": those of Quoin */
  char samples[PETSC_MAX_PATH_LEN];    /* table of runs with other numbers, "": the scene is run */
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
  Connectivity connectivity;   /* for stages without a choice of their own */
  PetscReal vertex_length;     /* [-] least influence length of a vertex on a face, over the shorter face */
  PetscReal overlap_tolerance; /* [m] depth to which two macroblocks of the mesh may overlap */
  InitialGaps initial_gaps;    /* meaning of a gap of the mesh within contact_tolerance */
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
  PetscInt check_every;     /* [cycles] between checks of convergence */
  PetscInt history_every;   /* [cycles] between rows of history.csv */
  FlowSettings flow;        /* water in joints */
  /* checkpoints */
  char restart[PETSC_MAX_PATH_LEN]; /* file, folder or "auto"; "": a run from the start */
  PetscReal checkpoint_minutes;     /* [min] of wall time between checkpoints, 0: none by time */
  PetscInt checkpoint_every;        /* [cycles] between checkpoints, 0: none by cycles */
  PetscInt checkpoint_keep;         /* number of newest files kept */
  PetscReal memory_limit;           /* [GB] for each machine, 0: what is free there */
  PetscReal wall_limit;             /* [min] of wall time, 0: no limit */
  char *options;                    /* lines "key value" of all keys of the scene and the command line */
  /* tables */
  PetscInt n_materials, n_joints, n_motions, n_supports, n_loads, n_stages;
  Material *materials;
  Joint *joints; /* row 0 is "default" */
  GroundMotion *motions;
  Support *supports;
  Load *loads;
  Stage *stages;
  struct {
    PetscInt n;
    void *entries;
  } * terms;     /* a row for each of TERM_SECTIONS */
  char *echo;    /* value of every key, as YAML: scene_echo.yaml */
  char *solvers; /* options for PETSc's solvers, NULL: none; petsc_options.c */
} Scene;

/* Returns the row of the stage from whose end a stage starts, -1: none. */
static inline PetscInt StageBase(const Scene *scene, PetscInt stage)
{
  return stage - 1 - scene->stages[stage].skips;
}
/* What the kinds of stages do: they seek equilibria, move in true time with true masses, or only evaluate the
   state. A new kind gets a row here and one in stages.c. */
typedef enum { STAGE_RELAXES, STAGE_MOVES_IN_TIME, STAGE_EVALUATES } StageMotion;
static inline StageMotion StageMotionOf(StageKind kind)
{
  switch (kind) {
  case STAGE_DYNAMIC:
    return STAGE_MOVES_IN_TIME;
  case STAGE_MODES:
    return STAGE_EVALUATES;
  default:
    return STAGE_RELAXES;
  }
}
/* Returns whether a stage seeks equilibria. */
static inline PetscBool StageRelaxes(const Stage *stage)
{
  return (PetscBool)(StageMotionOf(stage->kind) == STAGE_RELAXES);
}
/* Returns whether a stage is made of trials. */
static inline PetscBool StageTries(const Stage *stage)
{
  return (PetscBool)(stage->kind == STAGE_STRENGTH_REDUCTION || stage->kind == STAGE_FLOOD ||
                     stage->kind == STAGE_LOAD_FACTOR || stage->kind == STAGE_ANCHOR_FORCE);
}
/* Returns whether a stage moves in true time. */
static inline PetscBool StageInTime(const Stage *stage)
{
  return (PetscBool)(StageMotionOf(stage->kind) == STAGE_MOVES_IN_TIME);
}
/* Returns whether a stage only evaluates the state, which stays as it is. */
static inline PetscBool StageEvaluates(const Stage *stage)
{
  return (PetscBool)(StageMotionOf(stage->kind) == STAGE_EVALUATES);
}
/* Returns the stage from whose end another one starts, without those in between that change nothing.
   NULL: none. */
static inline const Stage *StageBefore(const Scene *scene, const Stage *stage)
{
  PetscInt s = (PetscInt)(stage - scene->stages);
  while ((s = StageBase(scene, s)) >= 0)
    if (!StageEvaluates(scene->stages + s)) return scene->stages + s;
  return NULL;
}
/* Returns whether a stage starts from another one than the one before it. */
static inline PetscBool SceneBranches(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].skips) return PETSC_TRUE;
  return PETSC_FALSE;
}
/* Returns the damping by stiffness [s] of a group in a stage in time. */
static inline PetscReal BetaOf(const Material *material, const Stage *stage)
{
  return PetscIsNanReal(material->beta) ? stage->beta : material->beta;
}
/* Returns the word for bodies of a group that move as wholes, "rigid" or "condensed"; NULL: its blocks deform
   by themselves. */
static inline const char *MaterialBody(const Material *material)
{
  return material->rigid ? "rigid" : material->condensed > 0 ? "condensed" : NULL;
}

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
/* Returns whether an option, without its dash, asks for such a viewer. */
PetscBool IsStateView(const char *option);
/* Refuses viewers that PETSc does not have and, with files, those whose file cannot be written: a stage
   may take hours before it uses them. Files may lie in the output folder, so this check comes after its
   creation. */
PetscErrorCode StateViewsCheck(MPI_Comm comm, PetscBool files);
/* Warns of options that nothing has read: they are misspelt, belong to a solver that did not run, or name a
   view that no stage used. */
PetscErrorCode SolverOptionsWarnUnread(MPI_Comm comm);

/* ---- read.c */
/* Functions of the rooms above that complete or refuse keys that depend on other keys, by the reader of
   reader.h. path: the section of the entry. */
typedef struct _p_Reader Reader;
typedef struct _p_Completions Completions;
typedef PetscErrorCode LoadCompletion(Reader *r, const char *path, Load *load);
typedef PetscErrorCode StageCompletion(Reader *r, const char *path, Stage *stage);
/* Collective. Reads the scene. file: YAML scene or NULL; argv: "-key value" pairs that override it;
   complete: the functions above, see reader.h. Refuses unknown keys. */
PetscErrorCode SceneRead(MPI_Comm comm, const char *file, int argc, char **argv, const Completions *complete,
                         Scene *scene);
PetscErrorCode SceneDestroy(Scene *scene);
/* ---- varies.c */
/* Returns the first stage whose end changes with the number of a key, "joints.base.friction"; -1: mesh,
   contacts, condensed bodies or blocks may change with it, or it is no number. */
PetscInt SceneVaries(const Scene *scene, const char *key);
/* ---- help.c */
/* Prints every key with meaning, unit and default (what -help shows and docs/generated/keys.md contains). */
PetscErrorCode SceneHelp(MPI_Comm comm);
/* ---- schema.c */
/* Prints the same as a JSON Schema (what -schema shows). */
PetscErrorCode SceneSchema(MPI_Comm comm);
/* ---- motion_file.c */
/* Collective. Reads the records of motions and of files that supports follow, scales them and corrects their
   baseline; refuses an invalid file. */
PetscErrorCode SceneReadMotions(MPI_Comm comm, Scene *scene);
PetscErrorCode MotionsDestroy(Scene *scene);
/* Returns whether the record differs from its file: it is scaled, or its baseline corrected. */
PetscBool MotionIsChanged(const GroundMotion *motion);
/* Collective. Reads the rows of files of levels and of temperatures into scene->loads; refuses an invalid
   file. */
PetscErrorCode SceneReadLevels(MPI_Comm comm, Scene *scene);
/* Returns the value in the file of a load at time t [s]: level [m], or factor [-]. It is linear between rows,
   constant beyond them; of two rows at one time the second holds from there on. The load must have a file. */
PetscReal LoadSeries(const Load *load, PetscReal t);
/* Adds to scene->options the checksums of these files. */
PetscErrorCode SceneNoteFiles(Scene *scene);
/* Returns whether a stage has CONNECTIVITY_VARIABLE. */
static inline PetscBool SceneFindsAnew(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].connectivity == CONNECTIVITY_VARIABLE) return PETSC_TRUE;
  return PETSC_FALSE;
}
/* Returns whether a stage builds groups. */
static inline PetscBool SceneBuilds(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].n_build) return PETSC_TRUE;
  return PETSC_FALSE;
}
/* Whether a load of the scene is a temperature. */
/* Returns whether a load is the water before the dam, which a flood raises by itself. */
static inline PetscBool LoadIsReservoir(LoadKind kind)
{
  return (PetscBool)(kind == LOAD_RESERVOIR || kind == LOAD_OVERFLOW);
}

/* Returns whether a load has a surface of water at its level, which can rise. */
static inline PetscBool LoadHasSurface(LoadKind kind)
{
  return (PetscBool)(LoadIsReservoir(kind) || kind == LOAD_TAILWATER || kind == LOAD_WAVE ||
                     kind == LOAD_UPLIFT || kind == LOAD_HEAD);
}

static inline PetscBool SceneHasHeat(const Scene *scene)
{
  for (PetscInt l = 0; l < scene->n_loads; l++)
    if (scene->loads[l].kind == LOAD_TEMPERATURE) return PETSC_TRUE;
  return PETSC_FALSE;
}
/* Returns whether a stage of the scene runs in time. */
static inline PetscBool SceneInTime(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (StageInTime(scene->stages + s)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether a stage of the scene is a pushover. */
static inline PetscBool ScenePushes(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].kind == STAGE_PUSHOVER) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether condensed bodies need their inner vibrations: in time, and for modes. */
static inline PetscBool SceneVibrates(const Scene *scene)
{
  for (PetscInt s = 0; s < scene->n_stages; s++)
    if (scene->stages[s].kind == STAGE_MODES) return PETSC_TRUE;
  return SceneInTime(scene);
}

/* Returns whether condensed bodies, which the program has chosen, are corrected for large strain. */
static inline PetscBool SceneCorrects(const Scene *scene)
{
  for (PetscInt g = 0; g < scene->n_materials && scene->strain == STRAIN_LARGE; g++)
    if (scene->materials[g].is_open && scene->materials[g].condensed > 0) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- term_sections.c */
/* Returns the entries of a section of a force term, as the struct of its file of keys. */
const void *SceneEntries(const Scene *scene, const char *section, PetscInt *n);

/* ---- joint_table.c */
extern const char *const StressModels[]; /* PetscEnum-style list of names: pt r2pt r3pt t2pt t3pt tptm,
                                            "StressModelKind", "STRESS_" , NULL */
/* Finds the elastic row of a stress model: F_end0 = L (a s0 + b s1), F_end1 = L (b s0 + a s1). */
void StressModelElastic(StressModelKind model, PetscReal *a, PetscReal *b);
/* Returns the largest friction [degree] of the joints that the stage reduces. has: (n_joints,) counts only
   marked joints, NULL: all. NaN: the stage reduces none. */
PetscReal ReducedFriction(const Scene *scene, const Stage *stage, const PetscInt *has);
/* Computes tan_phi from friction. */
void JointPrepare(Joint *joint);
/* Returns whether a strength reduction, or a search for the force of anchors, reduces this joint. */
PetscBool JointIsReduced(const Stage *stage, const Joint *joint);

/* ---- partial_factors.c */
/* Writes into `scaled`, a copy of `load`, the numbers to which its force is proportional, times a factor. */
void LoadScale(const Load *load, PetscReal factor, Load *scaled);
/* Multiplies loads and divides strengths of joints by their partial factors; once, when all is read. */
void SceneApplyPartialFactors(Scene *scene);
static inline PetscBool StageHasDesignStrengths(const Stage *stage)
{
  return (PetscBool)(stage->friction_factor != 1. || stage->cohesion_factor != 1.);
}

/* ---- entries.c */
/* Writes "file:line: key: text" in one line, unless message already holds an earlier fault. line 0 gives
   "command line: -key_with_underscores: text"; line -1 means the file as a whole. */
void Complain(char *message, const char *file, int line, const char *key, const char *format, ...)
    PETSC_ATTRIBUTE_FORMAT(5, 6);

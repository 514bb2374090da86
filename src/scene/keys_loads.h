/* keys_loads.h: lists the keys of loads: section loads. Water in joints has a file of its own. */
#ifdef KEY_STRUCTS
#include "scene/keys_seismic.h"
#include "scene/keys_surface.h"
#include "scene/keys_temperature.h"
#include "scene/keys_water.h"
typedef enum {
  LOAD_SELF_WEIGHT,
  LOAD_RESERVOIR,
  LOAD_TRACTION,
  LOAD_POINT_FORCE,
  LOAD_UPLIFT,
  LOAD_HEAD, /* the four conditions of water that flows in joints */
  LOAD_DRAIN,
  LOAD_CURTAIN,
  LOAD_INFLOW,
  LOAD_PSEUDO_STATIC,
  LOAD_ADDED_MASS,
  LOAD_TEMPERATURE,
  LOAD_SILT,
  LOAD_ICE,
  LOAD_OVERFLOW,
  LOAD_TAILWATER,
  LOAD_WAVE,
  LOAD_CREST_LOAD,
  LOAD_PRESSURE,
  LOAD_KINDS
} LoadKind;

typedef struct {
  char name[NAME_LENGTH];
  LoadKind kind;
  PetscInt n_groups; /* self_weight, pseudo_static, temperature: number of groups it acts on; 0: all */
  char (*groups)[NAME_LENGTH];
  char target[NAME_LENGTH];         /* reservoir, traction, temperature: face set; point_force: point */
  PetscReal level;                  /* [m] reservoir: elevation of the water surface */
  PetscReal at, lever;              /* [m] crest_load: x of its place on the faces, height above them */
  PetscReal density;                /* [kg/m3] reservoir: density of the water */
  PetscReal coefficient[2];         /* [-] force over weight, x, y: pseudo_static; self_weight: 0, -1 */
  PetscReal partial_factor;         /* [-] of the force; the other numbers have it once the scene is read */
  HydroKeys hydro;                  /* pseudo_static, added_mass: the water's inertia */
  HeatKeys heat;                    /* temperature */
  SurfaceKeys surface;              /* overflow, tailwater, wave */
  PetscReal lateral;                /* [-] silt: horizontal over vertical pressure */
  PetscReal rest_angle;             /* [degree] silt: its friction, NaN: not given */
  PetscReal traction[2];            /* [Pa] traction x, y; pressure; point_force: [N/m of thickness] */
  UpliftKeys uplift;                /* of an uplift; target, level and density as of a reservoir */
  char levels[PETSC_MAX_PATH_LEN];  /* head, reservoir: CSV file of t [s], level [m]; "": none */
  char history[PETSC_MAX_PATH_LEN]; /* traction, pressure, point_force: CSV of t [s], factor; "": none */
  PetscInt n_levels;                /* rows of either file; SceneReadLevels */
  PetscReal *t, *levels_at; /* (n_levels,) levels: [s] since the transient stage began, [m]; history: [s]
                                      of the run, [-] */
  FlowKeys flow;            /* of head, drain, curtain, inflow; heel and gallery of a drain are in uplift */
  int line;
} Load;
#endif
#ifdef KEY_WORDS
#include "scene/keys_seismic.h"
#include "scene/keys_surface.h"
#include "scene/keys_water.h"
static const char *const LoadTypes[] = {
    "self_weight", "reservoir",     "traction",   "point_force", "uplift", "head", "drain",    "curtain",
    "inflow",      "pseudo_static", "added_mass", "temperature", "silt",   "ice",  "overflow", "tailwater",
    "wave",        "crest_load",    "pressure",   "LoadKind",    "LOAD_",  NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "type", CHOICE, Load, kind, NULL, NULL, "", "kind of load; it decides which other keys the load has",
      .choices = LoadTypes),
  KEY(LOADS, "groups", NAMES, Load, groups, "= all", NULL, "",
      "self_weight: groups that get their weight; pseudo_static: groups on whose mass it acts, none: on the water only; temperature: groups that expand",
      .count = offsetof(Load, n_groups),
      .loads = BIT(LOAD_SELF_WEIGHT) | BIT(LOAD_PSEUDO_STATIC) | BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "faces", NAME, Load, target, NULL, NULL, "",
      "reservoir, overflow, tailwater, wave, added_mass, traction, pressure, silt, ice, crest_load: face set on which it acts; uplift: face set of a joint; head, inflow: face set at which joints end",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_TRACTION) | BIT(LOAD_PRESSURE) | BIT(LOAD_UPLIFT) |
               BIT(LOAD_HEAD) | BIT(LOAD_INFLOW) | BIT(LOAD_ADDED_MASS) | BIT(LOAD_SILT) | BIT(LOAD_ICE) |
               BIT(LOAD_OVERFLOW) | BIT(LOAD_TAILWATER) | BIT(LOAD_WAVE) | BIT(LOAD_CREST_LOAD)),
  KEY(LOADS, "joint", NAME, Load, target, "= none", NULL, "", "drain: face set of the joint that it meets",
      .loads = BIT(LOAD_DRAIN)),
  KEY(LOADS, "level", REAL, Load, level, NULL, NULL, "m",
      "reservoir, tailwater, added_mass, uplift, head: elevation of the water surface; a face above that of a head can seep; overflow: elevation far upstream; wave: of the still water; silt: of its top; ice: of the ice",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_UPLIFT) | BIT(LOAD_HEAD) | BIT(LOAD_ADDED_MASS) |
               BIT(LOAD_SILT) | BIT(LOAD_ICE) | BIT(LOAD_OVERFLOW) | BIT(LOAD_TAILWATER) | BIT(LOAD_WAVE)),
  KEY(LOADS, "levels", PATH, Load, levels, "", NULL, "",
      "reservoir, head: CSV file of t [s] since the start of a transient stage, level [m], in place of level there",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_HEAD)),
  KEY(LOADS, "density", REAL, Load, density, "1000", "> 0", "kg/m3", "reservoir, overflow, tailwater, wave, uplift, pseudo_static, added_mass: density of the water",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_UPLIFT) | BIT(LOAD_PSEUDO_STATIC) | BIT(LOAD_ADDED_MASS) |
               BIT(LOAD_OVERFLOW) | BIT(LOAD_TAILWATER) | BIT(LOAD_WAVE)),
  KEY(LOADS, "density", REAL, Load, density, NULL, "> 0", "kg/m3", "silt: submerged density", .loads = BIT(LOAD_SILT)),
  KEY(LOADS, "lateral", REAL, Load, lateral, "= from friction", "> 0", "-", "silt: coefficient of lateral pressure",
      .loads = BIT(LOAD_SILT)),
  KEY(LOADS, "friction", REAL, Load, rest_angle, "= none", ">= 0, < 90", "degree",
      "silt: angle of friction, in place of lateral, which is then (1 - sin) / (1 + sin)", .loads = BIT(LOAD_SILT)),
  KEY(LOADS, "force", REAL, Load, traction, NULL, "> 0", "N/m", "ice: horizontal force into the face, per metre of thickness",
      .loads = BIT(LOAD_ICE)),
  KEY(LOADS, "partial_factor", REAL, Load, partial_factor, "1", "> 0", "-",
      "partial factor of the action: its force is multiplied by it",
      .loads = (BIT(LOAD_KINDS) - 1) & ~(BIT(LOAD_HEAD) | BIT(LOAD_DRAIN) | BIT(LOAD_CURTAIN) |
               BIT(LOAD_INFLOW) | BIT(LOAD_ADDED_MASS))),
#include "scene/keys_water.h"
#include "scene/keys_seismic.h"
#include "scene/keys_surface.h"
#include "scene/keys_temperature.h"
  KEY(LOADS, "point", NAME, Load, target, NULL, NULL, "", "point_force: point on which it acts",
      .loads = BIT(LOAD_POINT_FORCE)),
  KEY(LOADS, "value", PAIR, Load, traction, NULL, NULL, "Pa", "traction: force (x, y) per area of the face", .loads = BIT(LOAD_TRACTION)),
  KEY(LOADS, "pressure", REAL, Load, traction, NULL, NULL, "Pa",
      "pressure: normal to the faces; > 0 presses into the blocks; in large strain it turns with the faces", .loads = BIT(LOAD_PRESSURE)),
  KEY(LOADS, "value", PAIR, Load, traction, NULL, NULL, "N/m", "point_force, crest_load: force (x, y) per metre of thickness",
      .loads = BIT(LOAD_POINT_FORCE) | BIT(LOAD_CREST_LOAD)),
  KEY(LOADS, "history", PATH, Load, history, "", NULL, "",
      "traction, pressure, point_force: CSV file of t [s] of the run and the factor on value or pressure, for a load that changes in dynamic stages",
      .loads = BIT(LOAD_TRACTION) | BIT(LOAD_PRESSURE) | BIT(LOAD_POINT_FORCE)),
  KEY(LOADS, "at", REAL, Load, at, NULL, NULL, "m", "crest_load: x of the point of the faces where it acts",
      .loads = BIT(LOAD_CREST_LOAD)),
  KEY(LOADS, "lever", REAL, Load, lever, "0", ">= 0", "m", "crest_load: height of its horizontal component above that point",
      .loads = BIT(LOAD_CREST_LOAD)),
#endif
    // clang-format on

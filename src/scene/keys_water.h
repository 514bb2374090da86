/* keys_water.h: lists the keys of water in joints: loads of the types uplift, head, drain, curtain and
   inflow, and the section flow. Only keys_loads.h includes it. */
#ifdef KEY_STRUCTS
typedef enum { UPLIFT_LINEAR, UPLIFT_NPB, UPLIFT_USBR, UPLIFT_USACE, UPLIFT_FERC } UpliftRule;
typedef enum { UPLIFT_BOTH, UPLIFT_VERTICAL } UpliftComponent;
typedef enum { HEEL_AUTO, HEEL_START, HEEL_END } UpliftHeel;
typedef enum { RAISE_WHOLE, RAISE_TO_DRAIN } UpliftRaise;
typedef enum { REACHES_HEEL, REACHES_ANY } UpliftReach;
typedef enum { SHAKEN_RULE, SHAKEN_UNCHANGED, SHAKEN_ZERO, SHAKEN_FULL } UpliftShaken;

/* What an uplift has besides the keys of a reservoir; see uplift.c. */
typedef struct {
  UpliftRule rule;
  UpliftComponent component;
  UpliftHeel heel;           /* which end of the joint is upstream */
  UpliftRaise raise;         /* what a flood stage raises: the whole diagram, or only up to the drain */
  PetscBool cracked;         /* the full head acts along the open part of the joint */
  UpliftReach reaches;       /* cracked: which open stretches the full head reaches */
  UpliftShaken shaken;       /* cracked: what becomes of the pressure in a crack that an earthquake opens */
  PetscReal crack_tolerance; /* [m] tolerance of the iteration for the open length */
  PetscReal tailwater;       /* [m] elevation of the water at the toe, NaN: none */
  PetscReal drain;           /* [m] distance of the drain from the heel along the joint, NaN: none */
  PetscReal gallery;         /* [m] elevation where the drain opens, NaN: none */
  PetscReal efficiency;      /* [-] efficiency of the drain, NaN until the rule has set it */
  PetscReal drain_level;     /* [m] level for the pressure at the drain; the same as level except in floods */
} UpliftKeys;

/* What heads, drains, curtains and inflows have besides faces, level, heel and gallery; see flow.h. */
typedef struct {
  PetscReal from[2], to[2]; /* [m] line of a drain, or axis of a curtain; NaN: none */
  PetscReal distance;       /* [m] drain: from the heel of its joint, NaN: it goes by its line */
  PetscReal conductance;    /* [m2/s] drain: discharge per metre of head and of thickness */
  PetscReal width;          /* [m] curtain, across its axis */
  PetscReal factor;         /* [-] curtain: on the apertures, NaN: none */
  PetscReal aperture;       /* [m] curtain: in place of the joint's, NaN: none */
  PetscReal discharge;      /* [m2/s] inflow, per metre of thickness */
} FlowKeys;

typedef enum { FLOW_TWO_WAY, FLOW_ONE_WAY } FlowCoupling;
/* The water in the joints: section flow. */
typedef struct {
  FlowCoupling coupling;
  PetscReal viscosity;    /* [Pa s] */
  PetscReal density;      /* [kg/m3] */
  PetscReal bulk_modulus; /* [Pa] transient stages, PETSC_INFINITY: none */
  PetscReal tolerance;    /* [-] change of pressure between two rounds, over the largest pressure */
  PetscInt rounds;        /* most rounds of a stage */
} FlowSettings;
#endif
#ifdef KEY_WORDS
static const char *const Rules[] = {"linear", "npb", "usbr", "usace", "ferc", "UpliftRule", "UPLIFT_", NULL};
static const char *const Components[] = {"both", "vertical", "UpliftComponent", "UPLIFT_", NULL};
static const char *const Heels[] = {"auto", "start", "end", "UpliftHeel", "HEEL_", NULL};
static const char *const ShakenCracks[] = {"rule",         "unchanged", "zero", "full",
                                           "UpliftShaken", "SHAKEN_",   NULL};
static const char *const Reaches[] = {"heel", "any", "UpliftReach", "REACHES_", NULL};
static const char *const FlowCouplings[] = {"two_way", "one_way", "FlowCoupling", "FLOW_", NULL};
static const char *const Raises[] = {"whole", "to_drain", "UpliftRaise", "RAISE_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "rule", CHOICE, Load, uplift.rule, "linear", NULL, "", "uplift: guideline for drain and crack",
      .choices = Rules, .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "drain", REAL, Load, uplift.drain, "= none", "> 0", "m", "uplift: distance of the drain from the heel, along the joint",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "efficiency", REAL, Load, uplift.efficiency, "= 2/3 for npb, usbr", ">= 0, <= 1", "-",
      "uplift: efficiency of the drain; required for usace and ferc", .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "gallery", REAL, Load, uplift.gallery, "= none", NULL, "m",
      "uplift, drain: elevation of the water where the drain opens; none: a drain runs freely",
      .loads = BIT(LOAD_UPLIFT) | BIT(LOAD_DRAIN)),
  KEY(LOADS, "tailwater", REAL, Load, uplift.tailwater, "= none", NULL, "m",
      "uplift: elevation of the water at the toe, the other end of the joint; none: no pressure there",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "heel", CHOICE, Load, uplift.heel, "auto", NULL, "",
      "uplift, drain: upstream end of the joint; auto: where the water stands, without one the start; start: its left, or lower, end", .choices = Heels,
      .loads = BIT(LOAD_UPLIFT) | BIT(LOAD_DRAIN)),
  KEY(LOADS, "component", CHOICE, Load, uplift.component, "both", NULL, "",
      "uplift: both: pressure normal to the faces; vertical: its vertical component only", .choices = Components,
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "cracked", BOOL, Load, uplift.cracked, "false", NULL, "", "uplift: full head along the open part of the joint",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "reaches", CHOICE, Load, uplift.reaches, "heel", NULL, "",
      "uplift, cracked: the full head gets into the crack from the heel only, or into any open stretch",
      .choices = Reaches, .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "in_earthquake", CHOICE, Load, uplift.shaken, "rule", NULL, "",
      "uplift, cracked: in a stage with a pseudo_static load the crack that it opens changes no pressure, has none, or has the full head; rule: none for usbr, else unchanged",
      .choices = ShakenCracks, .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "crack_tolerance", REAL, Load, uplift.crack_tolerance, "0.01", "> 0", "m",
      "uplift: change of the open length at which its iteration ends", .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "raise", CHOICE, Load, uplift.raise, "whole", NULL, "",
      "uplift: what a flood raises: the whole pressure, or only its part from heel to drain", .choices = Raises,
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "distance", REAL, Load, flow.distance, "= none", ">= 0", "m",
      "drain: distance from the heel along `joint`, in place of from and to", .loads = BIT(LOAD_DRAIN)),
  KEY(LOADS, "from", PAIR, Load, flow.from, "= none", NULL, "m",
      "drain: drains every joint that the line to `to` crosses; curtain: start of its axis",
      .loads = BIT(LOAD_DRAIN) | BIT(LOAD_CURTAIN)),
  KEY(LOADS, "to", PAIR, Load, flow.to, "= none", NULL, "m", "drain, curtain: end of the line that begins at `from`",
      .loads = BIT(LOAD_DRAIN) | BIT(LOAD_CURTAIN)),
  KEY(LOADS, "conductance", LIMIT, Load, flow.conductance, "inf", ">= 0", "m2/s",
      "drain: discharge per metre of head where it meets a joint; inf: clean, 0: clogged", .loads = BIT(LOAD_DRAIN)),
  KEY(LOADS, "width", REAL, Load, flow.width, NULL, "> 0", "m", "curtain: width across its axis",
      .loads = BIT(LOAD_CURTAIN)),
  KEY(LOADS, "factor", REAL, Load, flow.factor, "= none", ">= 1e-6, <= 1", "-",
      "curtain: factor on the apertures within it", .loads = BIT(LOAD_CURTAIN)),
  KEY(LOADS, "aperture", REAL, Load, flow.aperture, "= none", ">= 1e-9", "m",
      "curtain: aperture of all joints within it, in place of factor", .loads = BIT(LOAD_CURTAIN)),
  KEY(LOADS, "discharge", REAL, Load, flow.discharge, NULL, ">= 0", "m2/s",
      "inflow: discharge per metre of thickness, shared by the joints that end at its faces", .loads = BIT(LOAD_INFLOW)),
#endif
    // clang-format on

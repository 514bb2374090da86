/* keys_water.h: what a scene says of water in joints: keys of loads of the type uplift. Only keys_loads.h
   includes it. */
#ifdef KEY_STRUCTS
typedef enum { UPLIFT_LINEAR, UPLIFT_NPB, UPLIFT_USBR, UPLIFT_USACE, UPLIFT_FERC } UpliftRule;
typedef enum { UPLIFT_BOTH, UPLIFT_VERTICAL } UpliftComponent;
typedef enum { HEEL_START, HEEL_END } UpliftHeel;
typedef enum { RAISE_WHOLE, RAISE_TO_DRAIN } UpliftRaise;
typedef enum { REACHES_HEEL, REACHES_ANY } UpliftReach;

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
#endif
#ifdef KEY_WORDS
static const char *const Rules[] = {"linear", "npb", "usbr", "usace", "ferc", "UpliftRule", "UPLIFT_", NULL};
static const char *const Components[] = {"both", "vertical", "UpliftComponent", "UPLIFT_", NULL};
static const char *const Heels[] = {"start", "end", "UpliftHeel", "HEEL_", NULL};
static const char *const Reaches[] = {"heel", "any", "UpliftReach", "REACHES_", NULL};
static const char *const Raises[] = {"whole", "to_drain", "UpliftRaise", "RAISE_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "rule", CHOICE, Load, uplift.rule, "linear", NULL, "", "uplift: guideline for drain and crack",
      .choices = Rules, .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "drain", REAL, Load, uplift.drain, "= none", "> 0", "m", "uplift: drain, from the heel along the joint",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "efficiency", REAL, Load, uplift.efficiency, "= 2/3 for npb, usbr", ">= 0, <= 1", "-",
      "uplift: of the drain; required for usace and ferc", .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "gallery", REAL, Load, uplift.gallery, "= none", NULL, "m", "uplift: elevation where the drain opens",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "tailwater", REAL, Load, uplift.tailwater, "= none", NULL, "m", "uplift: elevation of the water downstream",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "heel", CHOICE, Load, uplift.heel, "start", NULL, "",
      "uplift: upstream end of the joint; start: its left, or lower, end", .choices = Heels,
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "component", CHOICE, Load, uplift.component, "both", NULL, "",
      "uplift: both: pressure normal to the faces; vertical: its vertical component only", .choices = Components,
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "cracked", BOOL, Load, uplift.cracked, "false", NULL, "", "uplift: full head along the open part of the joint",
      .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "reaches", CHOICE, Load, uplift.reaches, "heel", NULL, "",
      "uplift, cracked: the full head gets into the crack from the heel only, or into any open stretch",
      .choices = Reaches, .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "crack_tolerance", REAL, Load, uplift.crack_tolerance, "0.01", "> 0", "m",
      "uplift: change of the open length at which its iteration ends", .loads = BIT(LOAD_UPLIFT)),
  KEY(LOADS, "raise", CHOICE, Load, uplift.raise, "whole", NULL, "",
      "uplift: what a flood raises: the whole pressure, or only from heel to drain", .choices = Raises,
      .loads = BIT(LOAD_UPLIFT)),
#endif
    // clang-format on

/* keys_seismic.h: lists the keys of earthquakes as loads: the types pseudo_static and added_mass. Only
   keys_loads.h includes it. */
#ifdef KEY_STRUCTS
typedef enum { HYDRO_WESTERGAARD, HYDRO_ZANGAR } HydroRule;

/* Inertia of the water at faces; target, level and density as of a reservoir. */
typedef struct {
  HydroRule rule;   /* of the pressure over depth */
  PetscReal bottom; /* [m] elevation of the reservoir's bottom, NaN: the lowest point of the faces */
} HydroKeys;
#endif
#ifdef KEY_WORDS
static const char *const HydroRules[] = {"westergaard", "zangar", "HydroRule", "HYDRO_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "coefficient", PAIR, Load, coefficient, NULL, NULL, "-",
      "pseudo_static: [k_h, k_v], inertia over weight; k_h > 0 acts along +x, k_v > 0 lifts",
      .loads = BIT(LOAD_PSEUDO_STATIC)),
  KEY(LOADS, "faces", NAME, Load, target, "= none", NULL, "",
      "pseudo_static: face set of the dam that meets the water, whose inertia presses or pulls at it",
      .loads = BIT(LOAD_PSEUDO_STATIC)),
  KEY(LOADS, "level", REAL, Load, level, "= none", NULL, "m", "pseudo_static: elevation of the water surface at `faces`",
      .loads = BIT(LOAD_PSEUDO_STATIC)),
  KEY(LOADS, "rule", CHOICE, Load, hydro.rule, "westergaard", NULL, "",
      "pseudo_static, added_mass: pressure over depth; zangar knows faces that lean", .choices = HydroRules,
      .loads = BIT(LOAD_PSEUDO_STATIC) | BIT(LOAD_ADDED_MASS)),
  KEY(LOADS, "bottom", REAL, Load, hydro.bottom, "= lowest point of the faces", NULL, "m",
      "pseudo_static, added_mass: elevation of the reservoir's bottom",
      .loads = BIT(LOAD_PSEUDO_STATIC) | BIT(LOAD_ADDED_MASS)),
#endif
    // clang-format on

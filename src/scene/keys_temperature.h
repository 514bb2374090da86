/* keys_temperature.h: lists the keys of temperature as a load: type temperature. Only keys_loads.h includes
   it. */
#ifdef KEY_STRUCTS
typedef struct {
  PetscReal change;                /* [K] everywhere; NaN: not given */
  char points[PETSC_MAX_PATH_LEN]; /* CSV file of x, y [m], change [K]; "": none */
  PetscInt n_points;               /* its rows; SceneReadLevels */
  PetscReal *x, *at;               /* (n_points,) [m] x; (n_points, 2) y [m], change [K] */
  PetscReal mean, amplitude;       /* [K] of the year's wave below faces; amplitude NaN: there is none */
  PetscReal day, diffusivity;      /* [day] since the faces were warmest; [m2/s] */
  PetscReal factor;                /* [-] of all changes: 1, or the factor of a trial */
} HeatKeys;
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "change", REAL, Load, heat.change, "= none", NULL, "K",
      "temperature: change from the temperature without stress, the same in all blocks of its groups",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "points", PATH, Load, heat.points, "", NULL, "",
      "temperature, in place of change: CSV file of x [m], y [m], change [K]; linear fields are met exactly",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "amplitude", REAL, Load, heat.amplitude, "= none", "> 0", "K",
      "temperature, in place of change: amplitude of the yearly wave at the faces; it decays with the depth below them",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "faces", NAME, Load, target, "= none", NULL, "", "temperature: face set from which the yearly wave enters",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "mean", REAL, Load, heat.mean, "0", NULL, "K", "temperature: change about which the yearly wave swings",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "day", REAL, Load, heat.day, "0", NULL, "day", "temperature: days since the faces were warmest; 182.6: they are coldest",
      .loads = BIT(LOAD_TEMPERATURE)),
  KEY(LOADS, "diffusivity", REAL, Load, heat.diffusivity, "1.1e-6", "> 0", "m2/s", "temperature: thermal diffusivity of the blocks, for the yearly wave",
      .loads = BIT(LOAD_TEMPERATURE)),
#endif
    // clang-format on

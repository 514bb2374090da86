/* keys_surface.h: lists the keys of water that moves at the faces of a dam: loads of the types overflow,
   tailwater and wave. Only keys_loads.h includes it. */
#ifdef KEY_STRUCTS
typedef enum { WAVE_MOLITOR, WAVE_SAINFLOU } WaveFormula;

/* Target, level and density as of a reservoir. */
typedef struct {
  char crest[NAME_LENGTH];  /* overflow: face set over which the water runs; "": none */
  PetscReal crest_pressure; /* [-] overflow: of the static pressure on it, NaN: not given */
  PetscReal velocity_head;  /* [m] overflow: by which the surface at the dam is below the level */
  PetscReal effective;      /* [-] tailwater: of its depth, what presses on the dam */
  PetscReal bottom;         /* [m] tailwater, wave: elevation of the ground, NaN: not given */
  WaveFormula formula;
  PetscReal height;      /* [m] wave: from trough to crest, as it comes; NaN until wind has given it */
  PetscReal wind, fetch; /* [m/s], [m] wave: in place of height, NaN: not given */
  PetscReal length;      /* [m] wave: from crest to crest, NaN: not given */
} SurfaceKeys;
#endif
#ifdef KEY_WORDS
static const char *const WaveFormulas[] = {"molitor", "sainflou", "WaveFormula", "WAVE_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(LOADS, "crest", NAME, Load, surface.crest, "= none", NULL, "",
      "overflow: face set of the crest, over which the water runs; none: nothing presses there",
      .loads = BIT(LOAD_OVERFLOW)),
  KEY(LOADS, "crest_pressure", REAL, Load, surface.crest_pressure, "= required with crest", ">= -1, <= 1", "-",
      "overflow: pressure on the crest over that of water at rest: 1 no loss, 0.667 critical depth on a broad crest, 0 a crest shaped for this head, < 0 suction",
      .loads = BIT(LOAD_OVERFLOW)),
  KEY(LOADS, "velocity_head", REAL, Load, surface.velocity_head, "0", ">= 0", "m",
      "overflow: by how much the surface at the dam is lower than `level`, which is that of the water at rest far upstream",
      .loads = BIT(LOAD_OVERFLOW)),
  KEY(LOADS, "effective", REAL, Load, surface.effective, "1", "> 0, <= 1", "-",
      "tailwater: fraction of its depth that presses on the dam; less than 1 where an overflow pushes the water away",
      .loads = BIT(LOAD_TAILWATER)),
  KEY(LOADS, "bottom", REAL, Load, surface.bottom, "= none", NULL, "m",
      "tailwater with effective < 1, wave by sainflou: elevation of the ground below the water",
      .loads = BIT(LOAD_TAILWATER) | BIT(LOAD_WAVE)),
  KEY(LOADS, "formula", CHOICE, Load, surface.formula, "molitor", NULL, "",
      "wave: formula of its pressure. molitor: thrust 2 rho g height^2; sainflou: standing wave before an upright wall",
      .choices = WaveFormulas, .loads = BIT(LOAD_WAVE)),
  KEY(LOADS, "height", REAL, Load, surface.height, "= by wind and fetch", "> 0", "m",
      "wave: height from trough to crest of the incoming wave", .loads = BIT(LOAD_WAVE)),
  KEY(LOADS, "wind", REAL, Load, surface.wind, "= none", "> 0", "m/s", "wave: speed of the wind, in place of height",
      .loads = BIT(LOAD_WAVE)),
  KEY(LOADS, "fetch", REAL, Load, surface.fetch, "= none", "> 0", "m",
      "wave: length of open water before the dam, with wind", .loads = BIT(LOAD_WAVE)),
  KEY(LOADS, "length", REAL, Load, surface.length, "= none", "> 0", "m", "wave by sainflou: wave length, from crest to crest",
      .loads = BIT(LOAD_WAVE)),
#endif
    // clang-format on

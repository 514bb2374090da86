/* keys_supports.h: lists the keys of supports: section supports. */
#ifdef KEY_STRUCTS
typedef enum { BOUNDARY_FIXED, BOUNDARY_QUIET, BOUNDARY_FREE_FIELD } BoundaryKind;
typedef enum { INPUT_OUTCROP, INPUT_INCIDENT } WaveInput;

typedef struct {
  char name[NAME_LENGTH];
  char target[NAME_LENGTH]; /* face set, group or point of the mesh; by default the support's own name */
  PetscBool fix[2];         /* x, y: whether the support fixes it */
  char motion[PETSC_MAX_PATH_LEN]; /* dynamic stages: motions of the scene, or a file; "": it does not move */
  PetscInt row;                    /* row of the support in Scene.supports */
  BoundaryKind boundary;           /* what it does in dynamic stages */
  WaveInput input;                 /* what its motion is, when waves come through it */
  char
      half_space[NAME_LENGTH]; /* group whose material the ground behind it has; "": the group of each face */
  GroundMotion own;            /* ground motion read from the support's own file, not listed in `motions` */
  const GroundMotion *along[2]; /* motion that it follows along x and y; NULL: none */
  int line;
} Support;
#endif
#ifdef KEY_WORDS
static const char *const Boundaries[] = {"fixed", "quiet", "free_field", "BoundaryKind", "BOUNDARY_", NULL};
static const char *const WaveInputs[] = {"outcrop", "incident", "WaveInput", "INPUT_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(SUPPORTS, "fix", FIX, Support, fix, NULL, NULL, "", "directions in which it is held: x, y or xy"),
  KEY(SUPPORTS, "target", NAME, Support, target, "= name of the support", NULL, "",
      "face set, group or point that it holds"),

  KEY(SUPPORTS, "motion", MOTION, Support, motion, "", NULL, "",
      "dynamic stages: ground motion of the support: one of the motions, or one along x and one along y; or a CSV file of t [s], x, y"),
  KEY(SUPPORTS, "quantity", CHOICE, Support, own.quantity, "velocity", NULL, "",
      "what the file of motion gives: velocity [m/s] or acceleration [m/s2]", .choices = Quantities),
  KEY(SUPPORTS, "boundary", CHOICE, Support, boundary, "fixed", NULL, "",
      "dynamic stages. fixed: moves as `motion` says; quiet: absorbs outgoing waves and lets those of `motion` in; free_field (vertical sides): absorbs waves beside a column of free ground that the motion of the base shakes",
      .choices = Boundaries),
  KEY(SUPPORTS, "input", CHOICE, Support, input, "outcrop", NULL, "",
      "quiet boundary: `motion` is the motion of free ground far away (outcrop), or that of the incoming wave, half as much (incident)", .choices = WaveInputs),
  KEY(SUPPORTS, "half_space", NAME, Support, half_space, "= that of each face", NULL, "",
      "quiet boundary: group whose ground continues behind it, and through which the waves of `motion` come"),
#endif
    // clang-format on

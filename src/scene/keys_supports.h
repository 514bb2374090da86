/* keys_supports.h: what a scene says of supports: section supports. */
#ifdef KEY_STRUCTS
typedef enum { MOTION_VELOCITY, MOTION_ACCELERATION } MotionQuantity;
typedef enum { BOUNDARY_FIXED, BOUNDARY_QUIET } BoundaryKind;
typedef enum { INPUT_OUTCROP, INPUT_INCIDENT } WaveInput;

typedef struct {
  char name[NAME_LENGTH];
  char target[NAME_LENGTH]; /* face set, group or point of the mesh; by default the support's own name */
  PetscBool fix[2];         /* x, y: whether the support fixes it */
  char motion[PETSC_MAX_PATH_LEN]; /* dynamic stages: CSV file of t [s], x, y; "": it does not move */
  PetscInt row;                    /* row of the support in Scene.supports */
  BoundaryKind boundary;           /* what it does in dynamic stages */
  WaveInput input;                 /* what its motion is, when waves come through it */
  MotionQuantity quantity;         /* what x, y in the file are: [m/s] or [m/s2] */
  PetscInt n_rows;                 /* of the file; SceneReadMotions */
  PetscReal *t;                    /* [s] (n_rows,) ascending, at most two the same */
  PetscReal *xy;                   /* (n_rows,2) */
  int line;
} Support;
#endif
#ifdef KEY_WORDS
static const char *const Quantities[] = {"velocity", "acceleration", "MotionQuantity", "MOTION_", NULL};
static const char *const Boundaries[] = {"fixed", "quiet", "BoundaryKind", "BOUNDARY_", NULL};
static const char *const WaveInputs[] = {"outcrop", "incident", "WaveInput", "INPUT_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(SUPPORTS, "fix", FIX, Support, fix, NULL, NULL, "", "directions held: x, y or xy"),
  KEY(SUPPORTS, "target", NAME, Support, target, "= name of the support", NULL, "",
      "face set, group or point held"),

  KEY(SUPPORTS, "motion", PATH, Support, motion, "", NULL, "",
      "dynamic stages: CSV file of t [s], x, y that the support follows"),
  KEY(SUPPORTS, "quantity", CHOICE, Support, quantity, "velocity", NULL, "",
      "what the file gives: velocity [m/s] or acceleration [m/s2]", .choices = Quantities),
  KEY(SUPPORTS, "boundary", CHOICE, Support, boundary, "fixed", NULL, "",
      "dynamic stages: fixed holds and moves by `motion`; quiet lets waves out, and those of `motion` in",
      .choices = Boundaries),
  KEY(SUPPORTS, "input", CHOICE, Support, input, "outcrop", NULL, "",
      "of a quiet boundary: `motion` is that of free ground far away (outcrop), or of the wave alone, half as much (incident)", .choices = WaveInputs),
#endif
    // clang-format on

/* keys_motions.h: lists the keys of motions of the ground: section motions. */
#ifdef KEY_STRUCTS
typedef enum { MOTION_VELOCITY, MOTION_ACCELERATION } MotionQuantity;
typedef enum { MOTION_ALONG_XY, MOTION_ALONG_X, MOTION_ALONG_Y } MotionDirection;
typedef enum { BASELINE_NONE, BASELINE_LINEAR } MotionBaseline;

/* Numbers in time, as a file has them. */
typedef struct {
  PetscInt n, width; /* rows, and numbers in a row besides the time */
  PetscReal *t;      /* (n,) [s] ascending, at most two the same */
  PetscReal *x;      /* (n,width) */
} Record;

typedef struct {
  TermEntry entry;
  char file[PETSC_MAX_PATH_LEN];
  MotionQuantity quantity;
  MotionDirection direction;
  PetscReal scale; /* [-] */
  PetscReal pga;   /* [m/s2] 0: none */
  MotionBaseline baseline;
  Record record; /* [m/s] or [m/s2] corrected and scaled; SceneReadMotions */
} GroundMotion;
#endif
#ifdef KEY_WORDS
static const char *const Quantities[] = {"velocity", "acceleration", "MotionQuantity", "MOTION_", NULL};
static const char *const Directions[] = {"xy", "x", "y", "MotionDirection", "MOTION_ALONG_", NULL};
static const char *const Baselines[] = {"none", "linear", "MotionBaseline", "BASELINE_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(MOTIONS, "file", PATH, GroundMotion, file, NULL, NULL, "",
      "file of the record: rows of t [s] and one or two components, or a file of PEER whose name ends with .AT2"),
  KEY(MOTIONS, "quantity", CHOICE, GroundMotion, quantity, "acceleration", NULL, "",
      "what the file gives: velocity [m/s] or acceleration [m/s2]; the head of a PEER file must agree", .choices = Quantities),
  KEY(MOTIONS, "direction", CHOICE, GroundMotion, direction, "xy", NULL, "",
      "direction of a record with one component: x or y; xy: the file has both components", .choices = Directions),
  KEY(MOTIONS, "scale", REAL, GroundMotion, scale, "1", NULL, "-", "factor on the record"),
  KEY(MOTIONS, "pga", REAL, GroundMotion, pga, "= none", "> 0", "m/s2",
      "in place of scale: the largest acceleration that the record is scaled to"),
  KEY(MOTIONS, "baseline", CHOICE, GroundMotion, baseline, "none", NULL, "",
      "linear: subtracts sin2(pi t/T) (c1 + c2 t) so that the ground ends at rest and where it was", .choices = Baselines),
#endif
    // clang-format on

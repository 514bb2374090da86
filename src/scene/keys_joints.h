/* keys_joints.h: lists the keys of joints: section joints. */
#ifdef KEY_STRUCTS
typedef enum { LAW_MOHR_COULOMB, LAW_ELASTIC } JointLawKind;
typedef enum { LETS_IN, LETS_NONE_IN, LETS_IN_AFTER_FAILURE } JointWater;
typedef enum {
  STRESS_PT,   /* of fixed control points; those before STRESS_R2PT have a potential */
  STRESS_R2PT, /* from here on they have none */
  STRESS_R3PT,
  STRESS_T2PT,
  STRESS_T3PT,
  STRESS_TPTM, /* from here on control points move; contacts are sorted by model */
  STRESS_MODELS
} StressModelKind;

/* Properties of a joint, of a pair of groups, or of the default. Index [0]: peak, [1]: residual, after the
   joint has failed there in tension or shear. */
typedef struct {
  char name[NAME_LENGTH]; /* face set of the mesh, or "groupA+groupB", or "default" */
  JointLawKind law;
  StressModelKind stress_model;
  PetscReal k_n, k_s;    /* [Pa/m] */
  PetscReal friction[2]; /* [degree] as the scene gives it */
  PetscReal tan_phi[2];  /* [-] its tangent, which the law uses; JointPrepare writes it, a trial lowers it */
  PetscReal cohesion[2]; /* [Pa] */
  PetscReal tension[2];  /* [Pa] tensile strength, >= 0 */
  PetscReal compression; /* [Pa] compressive strength, > 0, PETSC_INFINITY: none */
  PetscReal
      fracture_energy[2]; /* [N/m] of tension, of shear (law/softening.h); 0: strength is lost at once */
  PetscReal damping;      /* [s] dynamic stages: normal dashpot, damping * k_n per unit area, while closed */
  /* water that flows in it */
  JointWater water;
  PetscReal aperture;          /* [m] where its normal stress is zero; NaN: no water flows in it */
  PetscReal aperture_residual; /* [m] it never closes further */
  PetscReal aperture_max;      /* [m] nor opens further for the water, PETSC_INFINITY: no limit */
  PetscReal roughness;         /* [-] divides the conductance */
  PetscBool defined; /* false only for row 0 when the scene gives no "default": then all else is 0 */
  int line;
} Joint;
#endif
#ifdef KEY_WORDS
static const char *const JointWaters[] = {"true", "false", "after_failure", "JointWater", "LETS_", NULL};
static const char *const Laws[] = {"mohr_coulomb", "elastic", "JointLawKind", "LAW_", NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(JOINTS, "law", CHOICE, Joint, law, "mohr_coulomb", NULL, "", "elastic: no limits, tension included",
      .choices = Laws),
  KEY(JOINTS, "stress_model", CHOICE, Joint, stress_model, "tptm", NULL, "",
      "how stress is distributed along a contact", .choices = StressModels),
  KEY(JOINTS, "k_n", REAL, Joint, k_n, NULL, "> 0", "Pa/m", "normal stiffness"),
  KEY(JOINTS, "k_s", REAL, Joint, k_s, NULL, ">= 0", "Pa/m", "shear stiffness"),
  KEY(JOINTS, "friction", REAL, Joint, friction[0], "= required unless elastic", ">= 0, < 90", "degree",
      "angle of friction"),
  KEY(JOINTS, "cohesion", REAL, Joint, cohesion[0], "0", ">= 0", "Pa",
      "shear strength without normal stress"),
  KEY(JOINTS, "tension", REAL, Joint, tension[0], "0", ">= 0", "Pa", "tensile strength"),
  KEY(JOINTS, "compression", LIMIT, Joint, compression, "inf", "> 0", "Pa",
      "compressive strength; past it the joint is crushed and stays so; inf: no limit"),
  KEY(JOINTS, "friction_residual", REAL, Joint, friction[1], "= friction", ">= 0, < 90", "degree",
      "angle of friction after the joint has failed"),
  KEY(JOINTS, "cohesion_residual", REAL, Joint, cohesion[1], "0", ">= 0", "Pa", "cohesion after the joint has failed"),
  KEY(JOINTS, "tension_residual", REAL, Joint, tension[1], "0", ">= 0", "Pa", "tensile strength after the joint has failed"),

  KEY(JOINTS, "fracture_energy", REAL, Joint, fracture_energy[0], "0", ">= 0", "N/m",
      "stress_model: pt: energy per area that opening takes until tension is lost, linearly; 0: at once"),
  KEY(JOINTS, "fracture_energy_shear", REAL, Joint, fracture_energy[1], "0", ">= 0", "N/m",
      "stress_model: pt: energy per area that slip takes beyond that of the residual strength, linearly; 0: at once"),

  KEY(JOINTS, "damping", REAL, Joint, damping, "0", ">= 0", "s",
      "dynamic stages: time constant of a dashpot damping * k_n that acts while the joint is closed"),

  KEY(JOINTS, "flow", CHOICE, Joint, water, "true", NULL, "",
      "whether water enters a joint with an aperture; after_failure: only where the joint has opened, slipped, broken or begun to soften",
      .choices = JointWaters),
  KEY(JOINTS, "aperture", REAL, Joint, aperture, "= none: dry", ">= 1e-9", "m",
      "hydraulic aperture where the normal stress is zero; it changes with the opening"),
  KEY(JOINTS, "aperture_residual", REAL, Joint, aperture_residual, "= required with aperture", ">= 1e-9", "m",
      "least hydraulic aperture, of the closed joint"),
  KEY(JOINTS, "aperture_max", LIMIT, Joint, aperture_max, "inf", "> 0", "m",
      "largest hydraulic aperture; inf: no limit"),
  KEY(JOINTS, "roughness", REAL, Joint, roughness, "1", ">= 1", "-",
      "divides the conductance of smooth plates"),
#endif
    // clang-format on

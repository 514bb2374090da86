/* keys_blocks.h: lists the keys of groups of blocks: section materials. */
#ifdef KEY_STRUCTS
typedef enum { ELEMENT_FULL, ELEMENT_BENDING, ELEMENT_REDUCED } Formulation; /* of blocks of 4 vertices */
typedef enum { SOFTENING_EXPONENTIAL, SOFTENING_LINEAR } Softening;
/* Of deformable blocks; the place is that of the row in laws.c. */
typedef enum { MATERIAL_ELASTIC, MATERIAL_MOHR_COULOMB, MATERIAL_DAMAGE, MATERIAL_LAWS } MaterialLaw;

typedef struct {
  char name[NAME_LENGTH];   /* name of a group of the mesh */
  PetscReal density;        /* [kg/m3] >= 0 (0: weightless; a static stage scales masses anyway) */
  PetscReal young, poisson; /* [Pa], [-]; not needed for a rigid group */
  PetscReal expansion;      /* [1/K] of a change of temperature */
  PetscBool free_across;    /* and across the plane nothing holds it */
  Formulation element;      /* see element_kernels.h */
  PetscReal hourglass;      /* [-] ELEMENT_REDUCED: stiffness against hourglass modes */
  PetscInt rigid;           /* -1: as the mesh says, 0: deformable, 1: rigid; 0 or 1 after SceneResolve */
  PetscBool macroblocks;    /* blocks that share a vertex are one body; false: each block is one of its own */
  PetscInt condensed;       /* -1: condensing.c chooses, 0: no, 1: deformable, and reduced onto the vertices
                               where it meets others (condense.c); 0 or 1 after QuoinSetUp */
  PetscBool is_open;        /* the scene leaves `condensed` out; after SceneResolve */
  PetscReal beta;           /* [s] stiffness-proportional damping in time; NaN: the value of the stage */
  PetscReal highest_frequency; /* [Hz] condensed: up to which it has modes; NaN: none given */
  PetscReal velocity[2];       /* [m/s] at the start of the first dynamic stage */
  PetscReal spin;              /* [rad/s] at that start, about each body's mass centre */
  PetscBool upgradeable;       /* its contacts are verified and searched for under variable connectivity */
  PetscBool output;            /* its blocks are written into results.h5 */
  PetscReal tension, compression, cohesion, friction; /* [Pa], [Pa], [Pa], [degree] strengths for the local
                                                         failure factors (39)-(41), and those of the law; NaN:
                                                         not given */
  MaterialLaw law;
  PetscReal dilation;        /* [degree] MATERIAL_MOHR_COULOMB */
  PetscReal fracture_energy; /* [N/m] MATERIAL_DAMAGE; NaN: not given */
  PetscReal k0, surface;     /* [-], [m] ground at rest: sideways over vertical stress, level; NaN: none */
  Softening softening;       /* MATERIAL_DAMAGE: how it falls with the opening */
  int line;                  /* line in the scene file, for messages, here and below; 0: command line */
} Material;
#endif
#ifdef KEY_WORDS
static const char *const Formulations[] = {"full", "bending", "reduced", "Formulation", "ELEMENT_", NULL};
static const char *const Softenings[] = {"exponential", "linear", "Softening", "SOFTENING_", NULL};
static const char *const MaterialLaws[] = {"elastic",     "mohr_coulomb", "damage",
                                           "MaterialLaw", "MATERIAL_",    NULL};
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(MATERIALS, "density", REAL, Material, density, NULL, ">= 0", "kg/m3", "density; 0: weightless"),
  KEY(MATERIALS, "young", REAL, Material, young, "= required unless rigid", "> 0", "Pa",
      "modulus of elasticity"),
  KEY(MATERIALS, "poisson", REAL, Material, poisson, "= required unless rigid", "> -1, < 0.5", "-",
      "Poisson's ratio"),
  KEY(MATERIALS, "expansion", REAL, Material, expansion, "0", ">= 0", "1/K",
      "strain of a free block by a change of temperature of 1 K"),
  KEY(MATERIALS, "free_across", BOOL, Material, free_across, "false", NULL, "",
      "expansion, plane: strain: its blocks are free to expand across the plane, as between contraction joints"),
  KEY(MATERIALS, "element", CHOICE, Material, element, "= full; bending where law is not elastic", NULL, "",
      "element of blocks of 4 vertices. full: 2x2 points; bending: one point and exact bending of rectangles; reduced: one point and hourglass control",
      .choices = Formulations),
  KEY(MATERIALS, "hourglass", REAL, Material, hourglass, "0.1", "> 0, <= 1", "-",
      "element: reduced: stiffness of the hourglass control"),
  KEY(MATERIALS, "rigid", TRISTATE, Material, rigid, "= as in the mesh", NULL, "",
      "bodies of this group are rigid"),
  KEY(MATERIALS, "macroblocks", BOOL, Material, macroblocks, "true", NULL, "",
      "blocks that share a vertex are one body; false: each block is a body of its own, with joints to its neighbours"),
  KEY(MATERIALS, "condensed", TRISTATE, Material, condensed, "= where it pays and changes nothing", NULL, "",
      "bodies of this group are reduced onto the vertices where they meet others: small strain"),
  KEY(MATERIALS, "highest_frequency", REAL, Material, highest_frequency, "= required in time", "> 0",
      "Hz", "condensed, dynamic stages and modes: vibrations within a body are kept up to this frequency"),
  KEY(MATERIALS, "tension", REAL, Material, tension, "= none", ">= 0", "Pa",
      "tensile strength f_t, for the local failure factor (39)"),
  KEY(MATERIALS, "compression", REAL, Material, compression, "= none", "> 0", "Pa",
      "compressive strength f_c, for (40)"),
  KEY(MATERIALS, "cohesion", REAL, Material, cohesion, "= none", ">= 0", "Pa", "cohesion c, for (41), with friction"),
  KEY(MATERIALS, "friction", REAL, Material, friction, "= none", ">= 0, < 90", "degree",
      "angle of friction phi, for (41), with cohesion"),
  KEY(MATERIALS, "k0", REAL, Material, k0, "= none", ">= 0", "-",
      "ground at rest: horizontal over vertical stress, with its weight and its sides held"),
  KEY(MATERIALS, "surface", REAL, Material, surface, "= none", NULL, "m", "k0: y of the ground's surface"),
  KEY(MATERIALS, "law", CHOICE, Material, law, "elastic", NULL, "",
      "law of its blocks. elastic: linear; mohr_coulomb: yields at cohesion, friction and tension; damage: cracks at tension", .choices = MaterialLaws),
  KEY(MATERIALS, "dilation", REAL, Material, dilation, "0", ">= 0, < 90", "degree",
      "law: mohr_coulomb: angle of the plastic flow, at most friction"),
  KEY(MATERIALS, "fracture_energy", REAL, Material, fracture_energy, "= none", "> 0", "N/m",
      "law: damage: energy that a crack takes, per area"),
  KEY(MATERIALS, "softening", CHOICE, Material, softening, "exponential", NULL, "",
      "law: damage: how the stress of a crack falls as it opens", .choices = Softenings),

  KEY(MATERIALS, "beta", REAL, Material, beta, "= that of the stage", ">= 0", "s",
      "dynamic stages: stiffness-proportional damping of its blocks"),
  KEY(MATERIALS, "velocity", PAIR, Material, velocity, "0, 0", NULL, "m/s",
      "velocity (x, y) at the start of the first dynamic stage"),
  KEY(MATERIALS, "spin", REAL, Material, spin, "0", NULL, "rad/s",
      "angular velocity at the start of the first dynamic stage, about the mass centre of each body"),
  KEY(MATERIALS, "upgradeable", BOOL, Material, upgradeable, "true", NULL, "",
      "its contacts are verified when connectivity is variable"),
  KEY(MATERIALS, "output", BOOL, Material, output, "true", NULL, "",
      "its blocks, and contacts between blocks without output, are in results.h5 and results.xdmf"),
#endif
    // clang-format on

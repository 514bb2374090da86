/* keys_anchors.h: lists the keys of anchors: section anchors. */
#ifdef KEY_STRUCTS
/* All numbers are those of one anchor; the model has 1/spacing of it in each metre of thickness. */
typedef struct {
  TermEntry entry;
  PetscReal head[2], root[2]; /* [m] in the reference state, in blocks */
  PetscReal area;             /* [m2] of steel */
  PetscReal young;            /* [Pa] */
  PetscReal free_length;      /* [m] over which it stretches; 0: from head to root */
  PetscReal spacing;          /* [m] from anchor to anchor, along the thickness */
  PetscReal yield;            /* [Pa] */
  PetscReal breaking_force;   /* [N] */
  PetscReal strain_limit;     /* [-] elongation over the free length at which it breaks */
  PetscBool compression;      /* it carries compression too */
  PetscInt n_forces, n_locks; /* number of times that it is stressed; 0: it is passive */
  PetscReal *prestress;       /* (n_forces,) [N] */
  char (*lock)[NAME_LENGTH];  /* (n_locks,) stages in which it is stressed, and at whose end it is locked */
  PetscReal draw_in;          /* [m] by which the head slips as it is locked */
  char from[NAME_LENGTH];     /* stage from which a passive one is there; "": from the first */
  PetscReal bond_stiffness;   /* [N/m2] of the grout around it, 0: it is held at its ends alone */
  PetscReal bond_strength;    /* [N/m] */
  PetscReal segment;          /* [m] longest bonded piece; 0: by the bond, see AnchorSegment */
  PetscBool plate;            /* a grouted bar without free_length is held at its head too */
  PetscReal dowel_stiffness;  /* [N/m] across its line, where it crosses a joint; 0: by dowel_foundation */
  PetscReal dowel_strength;   /* [N] */
  PetscReal dowel_foundation; /* [Pa] modulus of what the bar is bedded in; 0: none */
} Anchor;
#endif
// clang-format off
#ifdef KEY_ROWS
  KEY(ANCHORS, "head", PAIR, Anchor, head, NULL, NULL, "m", "point in a block that holds its first end"),
  KEY(ANCHORS, "root", PAIR, Anchor, root, NULL, NULL, "m", "point in a block that holds its other end"),
  KEY(ANCHORS, "area", REAL, Anchor, area, NULL, "> 0", "m2", "cross-section of its steel"),
  KEY(ANCHORS, "young", REAL, Anchor, young, NULL, "> 0", "Pa", "modulus of elasticity of its steel"),
  KEY(ANCHORS, "free_length", REAL, Anchor, free_length, "= from head to root", "> 0", "m",
      "length over which it stretches: its stiffness is young area / free_length"),
  KEY(ANCHORS, "spacing", REAL, Anchor, spacing, "1", "> 0", "m",
      "distance from anchor to anchor along the thickness; forces and areas are those of one anchor"),
  KEY(ANCHORS, "yield", LIMIT, Anchor, yield, "inf", "> 0", "Pa", "stress at which it yields"),
  KEY(ANCHORS, "breaking_force", LIMIT, Anchor, breaking_force, "inf", "> 0", "N",
      "force at which it breaks before it yields; in static stages it breaks at equilibria"),
  KEY(ANCHORS, "strain_limit", LIMIT, Anchor, strain_limit, "inf", "> 0", "-",
      "elongation over free_length, plastic and elastic, at which it breaks"),
  KEY(ANCHORS, "compression", BOOL, Anchor, compression, "false", NULL, "",
      "true: a bar, which carries compression too; false: a tendon, which goes slack"),
  KEY(ANCHORS, "prestress", NUMBERS, Anchor, prestress, "= none: it is passive", "> 0", "N",
      "force to which it is stressed; a list where it is stressed again", .count = offsetof(Anchor, n_forces)),
  KEY(ANCHORS, "lock", NAMES, Anchor, lock, "= none", NULL, "",
      "static stage in which it is stressed, and at whose end it is locked; a list as that of prestress",
      .count = offsetof(Anchor, n_locks)),
  KEY(ANCHORS, "draw_in", REAL, Anchor, draw_in, "0", ">= 0", "m", "length by which its head slips back as it is locked"),
  KEY(ANCHORS, "from", NAME, Anchor, from, "= the first stage", NULL, "",
      "stage from whose start a passive anchor acts, without force at first"),
  KEY(ANCHORS, "bond_stiffness", REAL, Anchor, bond_stiffness, "= none: ends alone hold it", "> 0", "N/m2",
      "shear stiffness of the grout, per metre of bar; the bar is bonded from the end of free_length (0 if not given) to its root"),
  KEY(ANCHORS, "bond_strength", LIMIT, Anchor, bond_strength, "inf", "> 0", "N/m",
      "shear strength of the grout, per metre of bar; beyond it the bar slips"),
  KEY(ANCHORS, "segment", REAL, Anchor, segment, "= 0.2 sqrt(young area/bond_stiffness)", "> 0", "m",
      "longest segment into which the bonded length is divided"),
  KEY(ANCHORS, "plate", BOOL, Anchor, plate, "false", NULL, "",
      "true: a bonded bar without free_length is held at its head too"),
  KEY(ANCHORS, "dowel_stiffness", REAL, Anchor, dowel_stiffness, "= by dowel_foundation", "> 0", "N/m",
      "stiffness of a bonded bar against slip of the joints that it crosses"),
  KEY(ANCHORS, "dowel_strength", LIMIT, Anchor, dowel_strength, "inf", "> 0", "N",
      "strength of the dowel; if inf and dowel_foundation is given: when its outer fibre yields"),
  KEY(ANCHORS, "dowel_foundation", REAL, Anchor, dowel_foundation, "= no dowel", "> 0", "Pa",
      "subgrade modulus of the grout and rock around the bar, which is round: it gives stiffness and strength of the dowel"),
#endif
    // clang-format on

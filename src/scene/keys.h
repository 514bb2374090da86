/* keys.h: the one table of all keys of a scene. It drives reading, defaults, range checks, -help and
   docs/scene.md. Only read.c includes it. */
#pragma once
#include "scene/scene.h"
#include "scene/reader.h"
#include <stddef.h>

// clang-format off
static const char *const SectionPaths[SECTIONS] = {
  "", "contact.", "relaxation.", "checkpoint.", "repartition.", "relaxation.", "materials.<name>.", "joints.<name>.", "supports.<name>.",
#define PATH_OF_TERM(SECTION, word, type) (word ".<name>."),
  "loads.<name>.", "stages.<name>.", TERM_SECTIONS(PATH_OF_TERM)};
// clang-format on

static const char *const Planes[] = {"strain", "stress", "PlaneState", "PLANE_", NULL};
static const char *const Partitions[] = {"metis", "stripes", "PartitionKind", "PARTITION_", NULL};
static const char *const Exchanges[] = {"auto", "messages", "ExchangeKind", "EXCHANGE_", NULL};
static const char *const Repartitions[] = {"auto", "never", "RepartitionKind", "REPARTITION_", NULL};
static const char *const Strains[] = {"large", "small", "StrainMeasure", "STRAIN_", NULL};
static const char *const Formulations[] = {"full", "bending", "reduced", "Formulation", "ELEMENT_", NULL};
static const char *const Laws[] = {"mohr_coulomb", "elastic", "JointLawKind", "LAW_", NULL};
static const char *const LoadTypes[] = {"self_weight", "reservoir", "traction", "point_force",
                                        "uplift",      "LoadKind",  "LOAD_",    NULL};
static const char *const Rules[] = {"linear", "npb", "usbr", "usace", "ferc", "UpliftRule", "UPLIFT_", NULL};
static const char *const Components[] = {"both", "vertical", "UpliftComponent", "UPLIFT_", NULL};
static const char *const Heels[] = {"start", "end", "UpliftHeel", "HEEL_", NULL};
static const char *const Reaches[] = {"heel", "any", "UpliftReach", "REACHES_", NULL};
static const char *const Raises[] = {"whole", "to_drain", "UpliftRaise", "RAISE_", NULL};
static const char *const Reductions[] = {"friction", "strengths", "ReductionKind", "REDUCE_", NULL};
static const char *const Methods[] = {"explicit", "preconditioned", "auto", "MethodKind", "METHOD_", NULL};
static const char *const Dampings[] = {"adaptive", "paper",       "fixed",    "local",
                                       "none",     "DampingKind", "DAMPING_", NULL};

static const char *const StageTypes[] = {"static", "dynamic", "strength_reduction", "flood", "StageKind",
                                         "STAGE_", NULL};
static const char *const Connectivities[] = {"fixed", "variable", "Connectivity", "CONNECTIVITY_", NULL};
static const char *const Quantities[] = {"velocity", "acceleration", "MotionQuantity", "MOTION_", NULL};

#define BIT(kind) (1 << (kind))
#define KEY(in, word, kind_of_value, holder, field, value, limits, si, text, ...)                            \
  {                                                                                                          \
    .section = SECTION_##in, .name = word, .type = TYPE_##kind_of_value, .offset = offsetof(holder, field),  \
    .preset = value, .range = limits, .unit = si, .help = text, __VA_ARGS__                                  \
  }

// section, key, type, where it goes, default, range, unit, meaning
// clang-format off
static const Key Keys[] = {
  KEY(TOP, "title", TITLE, Scene, title, "", NULL, "", "name of the run, for results"),
  KEY(TOP, "model", PATH, Scene, model, NULL, NULL, "",
      "block mesh (HDF5), in the working directory or else beside the scene file"),
  KEY(TOP, "output", PATH, Scene, output, "out", NULL, "", "folder for results, from the working directory"),
  KEY(TOP, "restart", PATH, Scene, restart, "", NULL, "",
      "checkpoint to go on from; a folder: its newest good one; auto: the newest good one of the output folder, if any"),
  KEY(TOP, "advise", REAL, Scene, advise, "0", ">= 0, < 1", "-",
      "> 0: a dry run prints what a run would cost and what could be left out at this accuracy; nothing is written"),
  KEY(TOP, "plane", CHOICE, Scene, plane, "strain", NULL, "", "plane strain or plane stress",
      .choices = Planes),
  KEY(TOP, "strain", CHOICE, Scene, strain, "large", NULL, "",
      "large: total Lagrangian, St Venant-Kirchhoff, exact under rotation; small: linear",
      .choices = Strains),
  KEY(TOP, "isa", CHOICE, Scene, isa, "widest", NULL, "",
      "x86-64 instruction set of the hot loops: base, v3 (AVX2), v4 (AVX-512); same results, other speed",
      .choices = InstructionSets),
  KEY(TOP, "partition", CHOICE, Scene, partition, "metis", NULL, "",
      "which rank owns which block. metis: least cut; stripes: from left to right, known beforehand; same results",
      .choices = Partitions),
  KEY(TOP, "exchange", CHOICE, Scene, exchange, "auto", NULL, "",
      "how ranks tell each other what moved. auto: on one machine through memory they share, else by messages; same results",
      .choices = Exchanges),
  KEY(TOP, "memory_limit", REAL, Scene, memory_limit, "0", ">= 0", "GB",
      "memory that all ranks on one machine may take together, asked for before it is taken; 0: what is free there"),
  KEY(TOP, "thickness", REAL, Scene, thickness, "1", "> 0", "m", "of the slice"),
  KEY(TOP, "gravity", REAL, Scene, gravity, "9.81", ">= 0", "m/s2", "acts downwards (-y)"),

  KEY(CONTACT, "tolerance", REAL, Scene, contact_tolerance, "0.005", ">= 0", "m",
      "faces no farther apart than this form a contact"),
  KEY(CONTACT, "relative", BOOL, Scene, contact_relative, "false", NULL, "",
      "contact.tolerance is a fraction of the smaller face instead"),
  KEY(CONTACT, "overlap", REAL, Scene, overlap_tolerance, "0.005", ">= 0", "m",
      "two bodies of the mesh may overlap this deep"),

  KEY(CONTACT, "connectivity", CHOICE, Scene, connectivity, "fixed", NULL, "",
      "fixed: the contacts found at the start stay; variable: contacts are verified and found again as blocks move",
      .choices = Connectivities),
  KEY(CONTACT, "verify_after", REAL, Scene, verify_after, "0.2", "> 0, <= 0.5", "-",
      "verify when a vertex has moved this part of contact.tolerance"),
  KEY(CONTACT, "vertex_length", REAL, Scene, vertex_length, "0.05", "> 0, <= 1", "-",
      "least influence length of a vertex on a face, over the shorter face"),

  KEY(RELAXATION, "method", CHOICE, Scene, method, "auto", NULL, "",
      "explicit: damped motion; preconditioned: Newton's method with one factor, for fixed connectivity; auto: preconditioned for large static stages of elastic joints, else explicit",
      .choices = Methods),
  KEY(RELAXATION, "increments", INT, Scene, increments, "1", ">= 1", "-",
      "preconditioned: steps in which the loads of a stage with a ramp are applied"),
  KEY(RELAXATION, "effort", REAL, Scene, effort, "1e8", "> 0", "-",
      "preconditioned: limit of solves times degrees of freedom between two equilibria; beyond it explicit cycles go on"),
  KEY(RELAXATION, "damping", CHOICE, Scene, damping, "adaptive", NULL, "",
      "how alpha is chosen; paper: (35)-(38) alone; local: no alpha, non-viscous; all but adaptive keep slip as it comes",
      .choices = Dampings),
  KEY(RELAXATION, "alpha_dt", REAL, Scene, alpha_dt, "0.1", ">= 0, < 2", "-",
      "alpha times the time step, for damping: fixed"),
  KEY(RELAXATION, "local", REAL, Scene, local, "0.8", "> 0, < 1", "-",
      "part of the unbalanced force of each degree of freedom that acts against its velocity, for damping: local"),
  KEY(RELAXATION, "beta", REAL, Scene, beta, "0.25", ">= 0, <= 0.5", "-",
      "stiffness-proportional damping over the time step where joints can slip, for damping: adaptive; stills flutter"),
  KEY(RELAXATION, "groups", NAMES, Scene, damping_groups, "= all", NULL, "",
      "groups of blocks that the adaptive damping looks at", .count = offsetof(Scene, n_damping_groups)),
  KEY(RELAXATION, "safety", REAL, Scene, safety, "0.9", "> 0, <= 1", "-",
      "time step over the stability bound (sets the scaled masses)"),
  KEY(RELAXATION, "check_every", INT, Scene, check_every, "50", ">= 1", "cycles",
      "between tests of convergence"),
  KEY(RELAXATION, "history_every", INT, Scene, history_every, "100", ">= 1", "cycles",
      "between rows of history.csv"),
  KEY(RELAXATION, "allow_floating", BOOL, Scene, allow_floating, "false", NULL, "",
      "accept bodies that nothing holds"),

  KEY(CHECKPOINT, "minutes", REAL, Scene, checkpoint_minutes, "10", ">= 0", "min",
      "of wall time between checkpoints; 0: not by time"),
  KEY(CHECKPOINT, "every", INT, Scene, checkpoint_every, "0", ">= 0", "cycles",
      "between checkpoints; 0: not by cycles"),
  KEY(CHECKPOINT, "keep", INT, Scene, checkpoint_keep, "2", ">= 1", "",
      "newest checkpoints that are kept"),
  KEY(CHECKPOINT, "wall_limit", REAL, Scene, wall_limit, "0", ">= 0", "min",
      "of wall time after which the run writes a checkpoint and stops; 0: none"),

  KEY(REPARTITION, "when", CHOICE, Scene, repartition, "auto", NULL, "",
      "static and dynamic stages with variable connectivity. auto: dealt out to the ranks anew when blocks have moved; same results",
      .choices = Repartitions),
  KEY(REPARTITION, "every", INT, Scene, repartition_every, "10000", ">= 1", "cycles",
      "between looks for a better partition"),
  KEY(REPARTITION, "gain", REAL, Scene, repartition_gain, "0.1", ">= 0, < 1", "-",
      "part of the busiest rank's work that it must save"),

  KEY(STAGE_DEFAULTS, "ramp", INT, Stage, ramp, "1000", ">= 0", "cycles", "for stages that give none"),
  KEY(STAGE_DEFAULTS, "max_cycles", INT, Stage, max_cycles, "1000000", ">= 1", "cycles",
      "for stages that give none"),
  KEY(STAGE_DEFAULTS, "tolerance", REAL, Stage, tolerance, "1e-6", "> 0", "-", "for stages that give none"),
  KEY(STAGE_DEFAULTS, "velocity_tolerance", REAL, Stage, velocity_tolerance, "1e-6", "> 0", "-",
      "for stages that give none"),

  KEY(MATERIALS, "density", REAL, Material, density, NULL, ">= 0", "kg/m3", "0: weightless"),
  KEY(MATERIALS, "young", REAL, Material, young, "= required unless rigid", "> 0", "Pa",
      "modulus of elasticity"),
  KEY(MATERIALS, "poisson", REAL, Material, poisson, "= required unless rigid", "> -1, < 0.5", "-",
      "Poisson's ratio"),
  KEY(MATERIALS, "element", CHOICE, Material, element, "full", NULL, "",
      "blocks of 4 vertices: 2x2 points; one point and exact bending of rectangles; one point and hourglass control",
      .choices = Formulations),
  KEY(MATERIALS, "hourglass", REAL, Material, hourglass, "0.1", "> 0, <= 1", "-",
      "element: reduced: stiffness of the hourglass control"),
  KEY(MATERIALS, "rigid", TRISTATE, Material, rigid, "= as in the mesh", NULL, "",
      "bodies of this group are rigid"),
  KEY(MATERIALS, "macroblocks", BOOL, Material, macroblocks, "true", NULL, "",
      "blocks that share a vertex are one body; false: each block is a body of its own, with joints to its neighbours"),
  KEY(MATERIALS, "condensed", BOOL, Material, condensed, "false", NULL, "",
      "bodies of this group are reduced onto the vertices where they meet others: small strain, static stages"),
  KEY(MATERIALS, "tension", REAL, Material, tension, "= none", ">= 0", "Pa",
      "tensile strength f_t, for the local failure factor (39)"),
  KEY(MATERIALS, "compression", REAL, Material, compression, "= none", "> 0", "Pa",
      "compressive strength f_c, for (40)"),
  KEY(MATERIALS, "cohesion", REAL, Material, cohesion, "= none", ">= 0", "Pa", "c, for (41), with friction"),
  KEY(MATERIALS, "friction", REAL, Material, friction, "= none", ">= 0, < 90", "degree",
      "angle of friction, for (41), with cohesion"),

  KEY(MATERIALS, "velocity", PAIR, Material, velocity, "0, 0", NULL, "m/s",
      "x, y at the start of the first dynamic stage"),
  KEY(MATERIALS, "spin", REAL, Material, spin, "0", NULL, "rad/s",
      "likewise, about the mass centre of each body"),
  KEY(MATERIALS, "upgradeable", BOOL, Material, upgradeable, "true", NULL, "",
      "its contacts are verified when connectivity is variable"),
  KEY(MATERIALS, "output", BOOL, Material, output, "true", NULL, "",
      "its blocks, and contacts between blocks without output, are in results.h5 and results.xdmf"),

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
      "once the joint has failed"),
  KEY(JOINTS, "cohesion_residual", REAL, Joint, cohesion[1], "0", ">= 0", "Pa", "once the joint has failed"),
  KEY(JOINTS, "tension_residual", REAL, Joint, tension[1], "0", ">= 0", "Pa", "once the joint has failed"),

  KEY(JOINTS, "damping", REAL, Joint, damping, "0", ">= 0", "s",
      "dynamic stages: dashpot of damping * k_n while closed"),

  KEY(SUPPORTS, "fix", FIX, Support, fix, NULL, NULL, "", "directions held: x, y or xy"),
  KEY(SUPPORTS, "target", NAME, Support, target, "= name of the support", NULL, "",
      "face set, group or point held"),

  KEY(SUPPORTS, "motion", PATH, Support, motion, "", NULL, "",
      "dynamic stages: CSV file of t [s], x, y that the support follows"),
  KEY(SUPPORTS, "quantity", CHOICE, Support, quantity, "velocity", NULL, "",
      "what the file gives: velocity [m/s] or acceleration [m/s2]", .choices = Quantities),

  KEY(LOADS, "type", CHOICE, Load, kind, NULL, NULL, "", "what it is; decides which keys follow",
      .choices = LoadTypes),
  KEY(LOADS, "groups", NAMES, Load, groups, "= all", NULL, "", "self_weight: groups that get their weight",
      .count = offsetof(Load, n_groups), .loads = BIT(LOAD_SELF_WEIGHT)),
  KEY(LOADS, "faces", NAME, Load, target, NULL, NULL, "",
      "reservoir, traction: face set it acts on; uplift: face set of a joint",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_TRACTION) | BIT(LOAD_UPLIFT)),
  KEY(LOADS, "level", REAL, Load, level, NULL, NULL, "m", "reservoir, uplift: elevation of the water surface",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_UPLIFT)),
  KEY(LOADS, "density", REAL, Load, density, "1000", "> 0", "kg/m3", "reservoir, uplift: of the water",
      .loads = BIT(LOAD_RESERVOIR) | BIT(LOAD_UPLIFT)),
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
  KEY(LOADS, "point", NAME, Load, target, NULL, NULL, "", "point_force: point it acts on",
      .loads = BIT(LOAD_POINT_FORCE)),
  KEY(LOADS, "value", PAIR, Load, traction, NULL, NULL, "Pa or N/m",
      "x, y of a traction [Pa] or of a point_force [N per m of thickness]",
      .loads = BIT(LOAD_TRACTION) | BIT(LOAD_POINT_FORCE)),

  KEY(STAGES, "type", CHOICE, Stage, kind, "static", NULL, "",
      "static: to equilibrium; dynamic: in time; strength_reduction, flood: trials until something fails",
      .choices = StageTypes),
  KEY(STAGES, "loads", LOADS, Stage, loads, NULL, NULL, "",
      "loads that act at its end; the others are taken off", .count = offsetof(Stage, n_loads)),
  KEY(STAGES, "ramp", INT, Stage, ramp, "= relaxation.ramp", ">= 0", "cycles",
      "over which the loads change from those of the stage before to those of this stage"),
  KEY(STAGES, "max_cycles", INT, Stage, max_cycles, "= relaxation.max_cycles", ">= 1", "cycles",
      "after them the stage ends undecided"),
  KEY(STAGES, "tolerance", REAL, Stage, tolerance, "= relaxation.tolerance", "> 0", "-",
      "unbalanced ratio of the worst body at which the stage has converged"),
  KEY(STAGES, "velocity_tolerance", REAL, Stage, velocity_tolerance, "= relaxation.velocity_tolerance", "> 0",
      "-", "largest displacement increment of a cycle, over the largest displacement, at which the stage has converged"),
  KEY(STAGES, "variable", TRISTATE, Stage, variable, "= contact.connectivity", NULL, "",
      "true: variable connectivity in this stage, false: fixed"),
  KEY(STAGES, "duration", REAL, Stage, duration, "1", "> 0", "s", "dynamic: how long it lasts",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "dt_factor", REAL, Stage, dt_factor, "0.05", "> 0, <= 1", "-",
      "dynamic: time step over the stability bound; smaller where contacts open and close",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "alpha", REAL, Stage, alpha, "0", ">= 0", "1/s", "dynamic: mass-proportional damping",
      .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "frames", INT, Stage, frames, "0", ">= 0", "",
      "dynamic: results written on the way, at equal intervals of time", .stages = BIT(STAGE_DYNAMIC)),
  KEY(STAGES, "what", CHOICE, Stage, what, "friction", NULL, "",
      "strength_reduction: the angle of friction, or all strengths by one factor", .choices = Reductions,
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "reduce", NAMES, Stage, reduce, "= all that are not elastic", NULL, "",
      "strength_reduction: joints that are reduced", .count = offsetof(Stage, n_reduce),
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "rises", LOADS, Stage, rises, "= the highest reservoir", NULL, "",
      "flood: reservoirs and uplifts that rise; an uplift at the level of such a reservoir follows; all others stay",
      .count = offsetof(Stage, n_rises), .stages = BIT(STAGE_FLOOD)),
  KEY(STAGES, "start", REAL, Stage, start, "= as the joints are", "> 0", "degree or -",
      "strength_reduction: first angle of friction, or part of the strengths that is left",
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "step", REAL, Stage, step, "= none: bisection only", "> 0", "degree or m",
      "change of the angle of friction, or rise of the level, from trial to trial",
      .stages = BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_FLOOD)),
  KEY(STAGES, "factor", REAL, Stage, factor, "= none: bisection only", "> 0, < 1", "-",
      "strength_reduction, strengths: part of them that a trial leaves (0.85: 15 % less)",
      .stages = BIT(STAGE_STRENGTH_REDUCTION)),
  KEY(STAGES, "limit", REAL, Stage, limit, "= 0 for a reduction", NULL, "degree, - or m",
      "value at which the trials end", .stages = BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_FLOOD)),
  KEY(STAGES, "bracket", REAL, Stage, bracket, "0", ">= 0", "degree, - or m",
      "bisection between the last stable and the first unstable trial down to this width; 0: none",
      .stages = BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_FLOOD)),
  KEY(STAGES, "displacement_limit", REAL, Stage, displacement_limit, "= none", "> 0", "m",
      "trials: a trial fails that comes to rest after it has moved farther since the stage began",
      .stages = BIT(STAGE_STRENGTH_REDUCTION) | BIT(STAGE_FLOOD)),
  KEY(STAGES, "joints.<name>", CHANGES, Stage, joints, "= as before", NULL, "",
      "any key of this joint, changed from this stage on"),
#define TERM_KEYS
#include "scene/term_sections.h"
#undef TERM_KEYS
};
// clang-format on

enum { KEYS = sizeof Keys / sizeof Keys[0] };

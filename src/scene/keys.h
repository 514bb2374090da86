/* keys.h: the one table of all keys of a scene. It drives reading, defaults, range checks, -help,
   docs/scene.md, and the schema for editors. Only read.c, help.c and schema.c include it. */
#pragma once
#include "scene/scene.h"
#include "scene/reader.h"
#include <stddef.h>

// clang-format off
static const char *const SectionPaths[SECTIONS] = {
  "", "contact.", "relaxation.", "checkpoint.", "repartition.", "flow.", "relaxation.", "materials.<name>.", "joints.<name>.", "motions.<name>.",
  "supports.<name>.",
#define PATH_OF_TERM(SECTION, word, type) (word ".<name>."),
  "loads.<name>.", "stages.<name>.", TERM_SECTIONS(PATH_OF_TERM)};
// clang-format on

static const char *const Planes[] = {"strain", "stress", "PlaneState", "PLANE_", NULL};
static const char *const Partitions[] = {"metis", "stripes", "PartitionKind", "PARTITION_", NULL};
static const char *const Exchanges[] = {"auto", "messages", "ExchangeKind", "EXCHANGE_", NULL};
static const char *const Repartitions[] = {"auto", "never", "RepartitionKind", "REPARTITION_", NULL};
static const char *const Strains[] = {"large", "small", "StrainMeasure", "STRAIN_", NULL};
static const char *const Methods[] = {"explicit", "preconditioned", "auto", "MethodKind", "METHOD_", NULL};
static const char *const Dampings[] = {"adaptive", "paper",       "fixed",    "local",
                                       "none",     "DampingKind", "DAMPING_", NULL};

static const char *const Gaps[] = {"closed", "real", "InitialGaps", "GAPS_", NULL};
static const char *const Connectivities[] = {"fixed", "variable", "Connectivity", "CONNECTIVITY_", NULL};

#define KEY_WORDS
#include "scene/sections.h"
#undef KEY_WORDS

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
  KEY(TOP, "samples", PATH, Scene, samples, "", NULL, "",
      "CSV table, a row for each run of the same mesh with other numbers: all are run in this process, and a row of results is written for each; /dev/stdin: rows as they come, results to the terminal"),
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
  KEY(CONTACT, "initial_gaps", CHOICE, Scene, initial_gaps, "closed", NULL, "",
      "gaps of the mesh up to contact.tolerance. closed: they are the mesh's rounding, and faces are in contact as drawn; real: faces meet when the gap has closed. Overlaps are always as drawn",
      .choices = Gaps),
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

  KEY(FLOW, "coupling", CHOICE, Scene, flow.coupling, "two_way", NULL, "",
      "two_way: water and openings agree at equilibrium; one_way: water flows through the joints as they are when a stage begins",
      .choices = FlowCouplings),
  KEY(FLOW, "dynamic", CHOICE, Scene, flow.dynamic, "frozen", NULL, "",
      "what water in joints keeps in dynamic stages. frozen: its pressures; undrained: its volume, so pressures change with the openings",
      .choices = FlowDynamics),
  KEY(FLOW, "viscosity", REAL, Scene, flow.viscosity, "1e-3", "> 0", "Pa s", "of the water in joints"),
  KEY(FLOW, "density", REAL, Scene, flow.density, "1000", "> 0", "kg/m3", "of the water in joints"),
  KEY(FLOW, "bulk_modulus", LIMIT, Scene, flow.bulk_modulus, "2.2e9", "> 0", "Pa",
      "of the water in joints, for transient stages and flow.dynamic undrained"),
  KEY(FLOW, "tolerance", REAL, Scene, flow.tolerance, "1e-4", "> 0", "-",
      "change of pressure between two rounds, over the largest pressure, at which water and openings agree"),
  KEY(FLOW, "rounds", INT, Scene, flow.rounds, "100", ">= 1", "", "of a stage, after which it ends undecided"),

  KEY(STAGE_DEFAULTS, "ramp", INT, Stage, ramp, "1000", ">= 0", "cycles", "for stages that give none"),
  KEY(STAGE_DEFAULTS, "max_cycles", INT, Stage, max_cycles, "1000000", ">= 1", "cycles",
      "for stages that give none"),
  KEY(STAGE_DEFAULTS, "tolerance", REAL, Stage, tolerance, "1e-6", "> 0", "-", "for stages that give none"),
  KEY(STAGE_DEFAULTS, "velocity_tolerance", REAL, Stage, velocity_tolerance, "1e-6", "> 0", "-",
      "for stages that give none"),

#define KEY_ROWS
#include "scene/sections.h"
#undef KEY_ROWS
};
// clang-format on

enum { KEYS = sizeof Keys / sizeof Keys[0] };

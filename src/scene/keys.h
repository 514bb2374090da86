/* keys.h: lists all keys of a scene in one table, which drives reading, defaults, range checks, -help,
   docs/generated/keys.md, and the schema for editors. Only read.c, help.c and schema.c include it. */
#pragma once
#include "scene/scene.h"
#include "scene/reader.h"
#include <stddef.h>

// clang-format off
static const char *const SectionPaths[SECTIONS] = {
  "", "contact.", "relaxation.", "checkpoint.", "flow.", "relaxation.", "materials.<name>.", "joints.<name>.", "motions.<name>.",
  "supports.<name>.",
#define PATH_OF_TERM(SECTION, word, type) (word ".<name>."),
  "loads.<name>.", "stages.<name>.", TERM_SECTIONS(PATH_OF_TERM)};
// clang-format on

static const char *const Planes[] = {"strain", "stress", "PlaneState", "PLANE_", NULL};
static const char *const Partitions[] = {"metis", "stripes", "PartitionKind", "PARTITION_", NULL};
static const char *const Exchanges[] = {"auto", "messages", "ExchangeKind", "EXCHANGE_", NULL};
static const char *const Strains[] = {"large", "small", "StrainMeasure", "STRAIN_", NULL};
static const char *const Methods[] = {
    "explicit", "preconditioned", "stiffness_mass", "auto", "MethodKind", "METHOD_", NULL};
static const char *const Dampings[] = {"adaptive", "paper",       "fixed",    "local",
                                       "none",     "DampingKind", "DAMPING_", NULL};

static const char *const Gaps[] = {"closed", "real", "InitialGaps", "GAPS_", NULL};
static const char *const Connectivities[] = {"fixed",        "variable",      "auto",
                                             "Connectivity", "CONNECTIVITY_", NULL};

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
      "file of the block mesh (HDF5), looked for in the working directory, then beside the scene file"),
  KEY(TOP, "output", PATH, Scene, output, "out", NULL, "", "folder for results, relative to the working directory"),
  KEY(TOP, "restart", PATH, Scene, restart, "", NULL, "",
      "checkpoint from which the run goes on; a folder: its newest good checkpoint; auto: the newest good one of the output folder, if there is one"),
  KEY(TOP, "advise", REAL, Scene, advise, "0", ">= 0, < 1", "-",
      "> 0: a dry run estimates the cost of a run, and what could be left out at this accuracy; it writes nothing"),
  KEY(TOP, "samples", PATH, Scene, samples, "", NULL, "",
      "CSV table with a row for each run of the same mesh with other numbers: one process does all runs and writes a row of results for each; /dev/stdin: rows as they come, results to the terminal"),
  KEY(TOP, "guidelines", PATH, Scene, guidelines, "", NULL, "",
      "YAML with limits of guidelines over those of Quoin, for the sheet alone: quoin report reads it, the solver does not"),
  KEY(TOP, "what_if.<name>", CHANGES, Scene, title, "= none", NULL, "",
      "changes for an item of the table of ageing, for the sheet alone: keys of the scene by their paths, and a value, x and a factor, or lost for an anchor or a load that is not there"),
  KEY(TOP, "plane", CHOICE, Scene, plane, "strain", NULL, "", "plane strain or plane stress",
      .choices = Planes),
  KEY(TOP, "strain", CHOICE, Scene, strain, "large", NULL, "",
      "large: total Lagrangian, St Venant-Kirchhoff, exact under rotation; small: linear",
      .choices = Strains),
  KEY(TOP, "isa", CHOICE, Scene, isa, "widest", NULL, "",
      "x86-64 instruction set of the inner loops: base, v3 (AVX2), v4 (AVX-512); results are the same, the speed differs",
      .choices = InstructionSets),
  KEY(TOP, "partition", CHOICE, Scene, partition, "metis", NULL, "",
      "how blocks are distributed to ranks. metis: least communication; stripes: from left to right; results are the same",
      .choices = Partitions),
  KEY(TOP, "exchange", CHOICE, Scene, exchange, "auto", NULL, "",
      "how ranks exchange displacements. auto: through shared memory on one machine, else by messages; results are the same",
      .choices = Exchanges),
  KEY(TOP, "memory_limit", REAL, Scene, memory_limit, "0", ">= 0", "GB",
      "memory that all ranks on one machine may use together; 0: what is free there"),
  KEY(TOP, "thickness", REAL, Scene, thickness, "1", "> 0", "m", "thickness of the slice"),
  KEY(TOP, "gravity", REAL, Scene, gravity, "9.81", ">= 0", "m/s2", "acts downwards (-y)"),

  KEY(CONTACT, "tolerance", REAL, Scene, contact_tolerance, "0.005", ">= 0", "m",
      "two faces form a contact if their distance is at most this"),
  KEY(CONTACT, "relative", BOOL, Scene, contact_relative, "false", NULL, "",
      "contact.tolerance is a fraction of the smaller face instead"),
  KEY(CONTACT, "overlap", REAL, Scene, overlap_tolerance, "0.005", ">= 0", "m",
      "largest overlap of two bodies that the mesh may have"),
  KEY(CONTACT, "initial_gaps", CHOICE, Scene, initial_gaps, "closed", NULL, "",
      "gaps of the mesh up to contact.tolerance. closed: they come from rounding, and the faces are in contact from the start; real: faces meet when the gap has closed. Overlaps never press at the start",
      .choices = Gaps),
  KEY(CONTACT, "connectivity", CHOICE, Scene, connectivity, "auto", NULL, "",
      "fixed: contacts found at the start stay; variable: contacts are found again as blocks move; auto: fixed, and in a static stage variable from the last equilibrium before a contact slides or parts by a tenth of its length; trials keep the contacts with which they begin",
      .choices = Connectivities),
  KEY(CONTACT, "vertex_length", REAL, Scene, vertex_length, "0.05", "> 0, <= 1", "-",
      "least influence length of a vertex on a face, over the length of the shorter face"),

  KEY(RELAXATION, "method", CHOICE, Scene, method, "auto", NULL, "",
      "explicit: damped motion; preconditioned: Newton's method with one factor, for fixed connectivity; stiffness_mass: damped motion whose mass is proportional to the elastic stiffness, a solve a cycle, for many stones that slide (explicit with damping: local); auto: preconditioned where few bodies can slip and the stage is not small, and explicit cycles where that finds no end as fast; stiffness_mass for 500 to 8000 rigid stones that can slip, in strength reductions for 50 or more stones, where a load is raised on 50 or more of rubble, in static stages of 200 or more stones of rubble that deform up to the first stall, for dams that crack, and in trials of arches and columns of 20 or more; else explicit, with stiffness_mass where slip was let go",
      .choices = Methods),
  KEY(RELAXATION, "increments", INT, Scene, increments, "1", ">= 1", "-",
      "preconditioned: number of increments of the loads of a stage with a ramp"),
  KEY(RELAXATION, "effort", REAL, Scene, effort, "1e8", "> 0", "-",
      "preconditioned: limit of solves times degrees of freedom between two equilibria; beyond it the stage goes on by explicit cycles"),
  KEY(RELAXATION, "damping", CHOICE, Scene, damping, "adaptive", NULL, "",
      "how alpha is chosen. adaptive: from the motion, and slip follows the law of friction at the end; paper: by (35)-(38) alone; fixed: by alpha_dt; local: no alpha, non-viscous damping; none: no damping",
      .choices = Dampings),
  KEY(RELAXATION, "alpha_dt", REAL, Scene, alpha_dt, "0.1", ">= 0, < 2", "-",
      "damping: fixed: alpha times the time step"),
  KEY(RELAXATION, "local", REAL, Scene, local, "0.8", "> 0, < 1", "-",
      "damping: local: fraction of the unbalanced force of each degree of freedom that acts against its velocity"),
  KEY(RELAXATION, "beta", REAL, Scene, beta, "0.25", ">= 0, <= 0.5", "-",
      "damping: adaptive: stiffness-proportional damping over the time step, where joints can slip; it damps flutter"),
  KEY(RELAXATION, "groups", NAMES, Scene, damping_groups, "= all", NULL, "",
      "groups of blocks from whose motion the adaptive damping is computed", .count = offsetof(Scene, n_damping_groups)),
  KEY(RELAXATION, "safety", REAL, Scene, safety, "0.9", "> 0, <= 1", "-",
      "time step over the stability bound; the scaled masses follow from it"),
  KEY(RELAXATION, "check_every", INT, Scene, check_every, "50", ">= 1", "cycles",
      "cycles between two checks of convergence"),
  KEY(RELAXATION, "history_every", INT, Scene, history_every, "100", ">= 1", "cycles",
      "cycles between two rows of history.csv"),
  KEY(RELAXATION, "allow_floating", BOOL, Scene, allow_floating, "false", NULL, "",
      "accept bodies that nothing holds"),

  KEY(CHECKPOINT, "minutes", REAL, Scene, checkpoint_minutes, "10", ">= 0", "min",
      "wall time between two checkpoints; 0: not by time"),
  KEY(CHECKPOINT, "every", INT, Scene, checkpoint_every, "0", ">= 0", "cycles",
      "cycles between two checkpoints; 0: not by cycles"),
  KEY(CHECKPOINT, "keep", INT, Scene, checkpoint_keep, "2", ">= 1", "",
      "number of newest checkpoints that are kept"),
  KEY(CHECKPOINT, "wall_limit", REAL, Scene, wall_limit, "0", ">= 0", "min",
      "wall time after which the run writes a checkpoint and stops; 0: no limit"),

  KEY(FLOW, "coupling", CHOICE, Scene, flow.coupling, "two_way", NULL, "",
      "two_way: pressures and openings of joints agree at equilibrium; one_way: pressures follow from the openings at the start of the stage",
      .choices = FlowCouplings),
  KEY(FLOW, "viscosity", REAL, Scene, flow.viscosity, "1e-3", "> 0", "Pa s", "dynamic viscosity of the water in joints"),
  KEY(FLOW, "density", REAL, Scene, flow.density, "1000", "> 0", "kg/m3", "density of the water in joints"),
  KEY(FLOW, "bulk_modulus", LIMIT, Scene, flow.bulk_modulus, "2.2e9", "> 0", "Pa",
      "bulk modulus of the water in joints, for transient stages"),
  KEY(FLOW, "tolerance", REAL, Scene, flow.tolerance, "1e-4", "> 0", "-",
      "change of pressure between two rounds, over the largest pressure, below which pressures and openings agree"),
  KEY(FLOW, "rounds", INT, Scene, flow.rounds, "100", ">= 1", "", "rounds of a stage after which it ends undecided"),

  KEY(STAGE_DEFAULTS, "ramp", INT, Stage, ramp, "1000", ">= 0", "cycles", "ramp of stages that give none"),
  KEY(STAGE_DEFAULTS, "max_cycles", INT, Stage, max_cycles, "1000000", ">= 1", "cycles",
      "max_cycles of stages that give none"),
  KEY(STAGE_DEFAULTS, "tolerance", REAL, Stage, tolerance, "1e-6", "> 0", "-", "tolerance of stages that give none"),
  KEY(STAGE_DEFAULTS, "velocity_tolerance", REAL, Stage, velocity_tolerance, "1e-6", "> 0", "-",
      "velocity_tolerance of stages that give none"),

#define KEY_ROWS
#include "scene/sections.h"
#undef KEY_ROWS
};
// clang-format on

enum { KEYS = sizeof Keys / sizeof Keys[0] };

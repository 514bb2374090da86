/* thresholds.h: lists all numbers by which a static stage decides, in the order of the decisions.

   Each comment says what the number decides, then why it has this value. "Choice" marks a value that no
   derivation or measurement stands behind. The table of docs/static_stage.md is made from this file by
   `python tests/python/test_docs.py --thresholds`. Numbers that a scene may change are keys (keys.h). */
#pragma once
#include <petscsys.h>

/* ---- balance: is there an unbalanced force? */
/* Fraction of the largest force, or displacement, below which a body is not measured by its own. The
   rounding of a stage that takes all loads off must not judge it. */
static const PetscReal SCALE_FLOOR = 1e-6;
/* Fraction of a body's own loads that may be missing at equilibrium. Loads are not known better. */
static const PetscReal LOAD_MISSING = 1e-3;
/* Rounding of a force, over all forces on the cluster. Choice: above the rounding of sums of forces. */
static const PetscReal FORCE_ROUNDING = 1e-11;
/* Rounding of a force, over the forces on the cluster that carries most. Choice: above the rounding of one
   large force. */
static const PetscReal LARGEST_ROUNDING = 1e-14;
/* Resistance over the length of contacts below which a rigid motion is free. The square of 0.01 rad: what
   a contact resists by turning so far. */
static const PetscReal FREE_RESISTANCE = 1e-4;
/* Part of a unit force along an axis that must find no resistance for a body to be free along it.
   Choice. */
static const PetscReal FREE_PART = 0.5;
/* Distance from the shear limit, over it, within which a contact slips. As exact as the equilibrium. */
static const PetscReal NEAR_SLIP = 1e-6;
/* Unbalanced force over all forces below which nothing drives a body without loads. As exact as the
   equilibrium. */
static const PetscReal DRIVES_NOTHING = 1e-6;

/* ---- energy: do the cycles make energy? */
/* Kinetic energy over the last that was in order, from which on it is checked again. A check then costs
   next to nothing. */
static const PetscReal ENERGY_AGAIN = 2.;
/* Kinetic energy over the bound by loads and stored energy. The bound of the stored energy is itself twice
   too large: only gross errors count. */
static const PetscReal ENERGY_ALLOWED = 2.;
/* beta after the restart. The largest that the key allows; no dam of nine chatters with it
   ([deviations](deviations.md#deviations-and-why), ab). */
static const PetscReal RESTART_BETA = 0.5;
/* Times by which the step is shorter after the restart. Choice: half the step. */
static const PetscReal RESTART_STEP_DIVISOR = 2.;
/* Factor on pull after the restart. Choice: the slower friction follows its law, the less energy it
   makes. */
static const PetscReal RESTART_PULL = 0.1;

/* ---- chunks: does a mechanism move on? */
/* [cycles] Shortest chunk. Ten checks at the default `check_every`. */
enum { CHUNK_MIN = 500 };
/* [cycles] The same with relaxation.method: stiffness_mass. An elastic motion takes 6 cycles there. */
enum { CHUNK_MIN_STIFFNESS = 100 };
/* [cycles] Longest chunk. Choice: bounds the wait. */
enum { CHUNK_MAX = 50000 };
/* Length of each chunk over the one before. A slow creep shows that it slows down. */
static const PetscReal CHUNK_GROWTH = 1.25;
/* Steady chunks in a row before a collapse. With the one before them three: two differences. */
enum { CHUNKS_TO_COLLAPSE = 2 };
/* Cosine between the motions of two chunks that count as one direction. 11 degrees; a swing turns
   round. */
static const PetscReal SAME_DIRECTION = 0.98;
/* The same for a body that speeds up. A body that overturns follows an arc. */
static const PetscReal SAME_ARC = 0.9;
/* Pace over the pace of the chunk before, of a body that speeds up. Choice: a body in free motion speeds up
   by more. */
static const PetscReal SPEEDS_UP = 1.5;
/* Ratio, and pace, over those two chunks before, above which they do not fall. Even ten times too much
   damping brings 10 %. */
static const PetscReal HOLDS = 0.95;
/* Ratio over that two chunks before, above which beta is raised first. Flutter must be excluded before a
   collapse. */
static const PetscReal HALVED = 0.5;
/* beta that is then taken. As `RESTART_BETA`. */
static const PetscReal BETA_STILL = 0.5;
/* [chunks] Time to the end of a motion beyond which a body floats. No elastic structure is so slow. */
static const PetscReal FLOATS = 1e7;
/* alpha times the length of a chunk from which on damping rules the motion. Velocity falls by exp(-2) in
   the chunk. */
static const PetscReal DAMPED_CHUNK = 2.;
/* Travel of a contact that is a collapse; and, over the longest contact, the distance within which a
   motion must end. A contact that was kept means nothing beyond it. */
static const PetscReal TRAVEL_LIMIT = 0.1;
/* Travel of a contact that is a collapse while the load of a static stage of connectivity `auto` rises, and
   as long again. A block that has slid by half of its face has its middle over the edge; the wave of the
   load carries small stones beyond a tenth. */
static const PetscReal SLID_AWAY = 0.5;
/* [cycles of `stiffness_mass`] Time under the full load after which a contact that moves on has collapsed
   beyond TRAVEL_LIMIT. An elastic motion takes 6 such cycles. */
enum { SETTLED_CYCLES = 50 };
/* Displacement of a body over its size, since the stage began, beyond which it has fallen where contacts are
   found again by `auto`. Choice: it no longer stands in its place. */
static const PetscReal GONE = 0.5;
/* Gap over length below which faces touch from the start. Mesh files round coordinates. */
static const PetscReal TOUCHING = 1e-6;
/* Steps between means of chunks through which the line to the rest point is drawn. Choice: three or four
   means; a standard error needs three. */
enum { REST_STEPS = 3 };
/* Standard errors by which that line is made steeper. A collapse must not rest on scatter. */
static const PetscReal SCATTER = 1.;
/* Slowest end, over the fastest, whose gap may close. Slower ends only follow the others. */
static const PetscReal CLOSES_FROM = 0.05;
/* Displacement over `displacement_limit` beyond which a moving trial has failed. It began at most one
   limit from the start, so it is beyond the limit. */
static const PetscReal LIMIT_TIMES = 2.;
/* `displacement_limit` over the size of what may move. Choice. */
static const PetscReal PART_OF_SIZE = 0.01;
/* Displacement over the diameter of the model that is a divergence. Choice. */
static const PetscReal DIVERGED = 1e3;

/* ---- friction: how fast does it follow its law? */
/* Fraction by which friction follows its law each cycle, as a stage begins. False slip is soon lost. */
static const PetscReal PULL_CLOSE = 0.5;
/* The same after a stall. Nothing chatters. */
static const PetscReal PULL_FAR = 0.05;
/* Ratio over that at the last halving, below which there is no stall. Below the limit load it falls by a
   factor of 500 in a period. */
static const PetscReal NO_STALL = 0.5;
/* [half periods, or shortest chunks] Time without halving that is a stall. One and a half periods of the
   slowest mode. */
static const PetscReal STALL_WAIT = 3.;
/* Ratio over that at the last halving that is a stall at once, where explicit cycles go on from a stall of
   `stiffness_mass`. Choice: it rises by 100 to 10 000 in the time of a stall where friction chatters. */
static const PetscReal CHATTERS = 10.;
/* Stalls after which slip is kept as it comes. Each pull has been tried twice. */
enum { STALLS_TO_LET_GO = 4 };

/* ---- relaxation.method: stiffness_mass */
/* Cycles of the ramp that one such cycle counts for while few contacts have slipped under pressure. An
   elastic motion takes 6 cycles here, and tens or hundreds of explicit ones. */
enum { RAMP_HURRIES = 5 };
/* Cycles of a ramp that hurries, where the key `ramp` gives more than as many times RAMP_HURRIES. Loads that
   rise in so many cycles overshoot by 1/500 of an elastic answer. */
enum { RAMP_HURRIED = 500 };
/* The same from where blocks have cracked on; a shorter ramp does not hurry there. One of 28 dams that crack
   came to another equilibrium with 800 and 1000 cycles, with 1400 to 20 000 to that of explicit ones. */
enum { RAMP_CRACKED = 2000 };
/* Fraction of contacts that have slipped so, from which on the ramp does not hurry. Choice: hardly any in
   walls that stand, 0.2 to 0.3 in dams of stones; a shorter ramp led one of five dams to another
   equilibrium. */
static const PetscReal FEW_SLIP = 0.05;
/* Pressure over the largest one above which slip counts for it. Choice: joints between the heads of bricks
   slip without any. */
static const PetscReal BEARS = 0.01;
/* Displacement of cycles with the mass of stiffness_mass.c, over that of the model with elastic joints under
   all loads, beyond which explicit cycles do the stage again. Columns that jump over their limit stop at 40
   to 75. */
static const PetscReal JUMP_FAR = 30.;
/* The same where damping also took more than JUMP_LOST of the work. Equilibria that explicit cycles confirm
   are at 0.03 to 4. */
static const PetscReal JUMP_TIMES = 5.;
/* Part of the work of the loads. Damping takes 0.001 to 0.04 where blocks follow the loads, 0.07 to 1 in a
   jump. */
static const PetscReal JUMP_LOST = 0.05;
/* [cycles] Such cycles after the ramp without a verdict, after which explicit cycles do the stage again. Dams
   of 150 to 2003 stones that come to rest without a jump take a third of it. */
enum { MOST_STIFFNESS_CYCLES = 20000 };
/* [cycles] The same of a trial. Of 60 strength reductions of 41 to 291 stones the trials that come to an end
   take 9350 at most, but for five that take 10 000 to 19 000. */
enum { MOST_TRIAL_CYCLES = 10000 };
/* [explicit cycles] Cost of such a cycle, so that those that go on where explicit ones crept take about as
   long as these at most. Measured: 2.6 to 4.2 with 150 to 2003 elastic stones. */
enum { STIFFNESS_CYCLE = 3 };

/* ---- warnings of an equilibrium */
/* Unbalanced ratio by the law, where slip was kept, that is warned of. Where the answer is right the ratio
   is within the tolerance; 0.015 was 10 % off ([deviations](deviations.md#deviations-and-why)). */
static const PetscReal PATH_RATIO = 5e-4;
/* Error of the displacement that is warned of. One per cent. */
static const PetscReal PATH_WAY = 0.01;
/* Fraction of contacts that have slipped, from which on a stage of rubble warns of other equilibria. Choice:
   0.2 to 0.3 in dams of 597 and 2003 stones whose displacements hang on the ramp, 0 in columns. */
static const PetscReal MANY_SLIP = 0.05;
/* Four-fold order of the stones (contacts/stone_order.c) below which they are rubble. Voronoi dams have 0.43
   to 0.67, walls and arches 0.99 or more. */
static const PetscReal RUBBLE_ORDER = 0.8;
/* Contacts with which stones are rubble. Choice: fewer joints are drawn one by one, as wedges and cracks. */
enum { RUBBLE_LEAST = 50 };
/* Ratio by the law over `tolerance` up to which the law counts as met. Choice. */
static const PetscReal PATH_TIMES = 10.;
/* Fraction of the stage's own change, out of balance, that is warned of. Half a per cent of a
   displacement. */
static const PetscReal CHANGE_UNBALANCED = 0.005;
/* Change of displacement over the largest displacement that is too small to be judged. Choice: above
   tolerance and rounding. */
static const PetscReal CHANGE_LEAST = 1e-5;
/* Fraction of the stage's displacement for the second evaluation of forces. Choice: a hundredth of the way
   gives its slope. */
static const PetscReal BACK = 0.01;
/* Work of the moments that condensed bodies lack, over the work of the stage: more is warned of. A quarter of
   a per cent of a displacement. */
static const PetscReal MOMENTS_LACK = 0.0025;
/* Change of a block's forces if the load came in 8 steps, that is warned of. Choice. */
static const PetscReal STEP_WARNS = 0.05;
/* Plastic strain in small strain that is warned of. Shapes are no longer what they were. */
static const PetscReal MOST_PLASTIC = 0.1;
/* [periods of the slowest motion] Time that a ramp must last where blocks crack. So slow a ramp does not
   overshoot. */
static const PetscReal SLOW_PERIODS = 2.;
/* [cycles] The same where the period is not known. Choice: the default of `ramp`. */
static const PetscReal SLOW_CYCLES = 1000.;
/* Fraction of a contact that counts as failed (increments of Newton's method). Choice: less is a front
   that moves through a joint. */
static const PetscReal FAILED = 0.1;

/* ---- Newton's method: when is no equilibrium expected? */
/* Unbalanced force over the least so far, beyond which no equilibrium is expected and creep begins. None of
   2200 increments of the verification cases that found an equilibrium rose so far; those that found none took
   most of their solves there. */
static const PetscReal NEWTON_RISEN = 30.;
/* Iterations of an increment before creep begins. Choice. */
enum { NEWTON_ITERATIONS = 40 };
/* Iterations without halving the unbalanced force before creep begins. Choice. */
enum { NEWTON_STALL = 8 };
/* Length of the shortest increment, over an increment of the scene. Choice: none is halved further. */
static const PetscReal INCREMENT_SHORTEST = 1. / 256.;

/* ---- creep: does a mechanism move on? */
/* Unbalanced force that a step of creep may leave, over that at its start. Choice: exact enough for r.du >
   0 along the step. */
static const PetscReal STEP_ERROR = 0.03;
/* Iterations of a step of creep. Choice: one that takes more is taken again, shorter. */
enum { STEP_ITERATIONS = 12 };
/* Iterations of a step without halving the unbalanced force. Choice. */
enum { STEP_STALL = 6 };
/* Travel of a contact in one step, and up to an equilibrium in large strain. Half of the travel that is a
   collapse. */
static const PetscReal STEP_TRAVEL = 0.05;
/* Travel after which a mechanism that turns back proves nothing. A tenth of the travel that is a collapse.
   */
static const PetscReal TURN_TRAVEL = 0.01;
/* Drag over the first one, from which on several ends may break in a step. Ends that break at one instant,
   as on a symmetric base, must not end creep. */
static const PetscReal FINE_DRAG = 1e4;
/* Drag over the first one at which creep gives up. Choice. */
static const PetscReal MOST_DRAG = 1e6;
/* Steps at which creep gives up. Choice. */
enum { MOST_STEPS = 200 };
/* Growth of the way over three steps of a mechanism. Three quarters of two steps of the usual growth,
   fourfold. */
static const PetscReal MECHANISM_GROWTH = 12.;
/* Cosine between steps of a mechanism. As `SAME_DIRECTION`. */
static const PetscReal MECHANISM_COSINE = 0.98;
/* Ratio, and pace, of a mechanism over those two steps before, above which they do not fall. As `HOLDS`. */
static const PetscReal MECHANISM_HOLDS = 0.95;
/* Travel of contacts in a mechanism so far. Columns that seat themselves 1.6 % of a face ahead lose less
   than a twentieth of the ratio over the first thousandth. */
static const PetscReal MECHANISM_TRAVEL = 1e-2;

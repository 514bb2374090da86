"""A row of blocks slides over another by its own length, cut in stripes from left to right at the start.

What stood on its own rank stands on another's in the end; the run is dealt out anew on the way, in a dynamic stage and in
a static one. Every frame has the same bits on 1 to 4 ranks, with and without, and after a restart on other ranks."""

import re

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "a run that is dealt out to the ranks anew goes on with the same bits, and with less to exchange"
SOURCE = "the run on one rank; without re-partition"

N, SPEED = 10, 10.0
SCENE = {
    "partition": "stripes",
    "contact": {"connectivity": "variable", "tolerance": 0.01},
    "relaxation": {"tolerance": 1e-6, "velocity_tolerance": 1e-6, "ramp": 0, "max_cycles": 400, "history_every": 50,
                   "check_every": 20},
    "repartition": {"every": 300, "gain": 0.03},
    "materials": {"ground": {"density": 0}, "low": {"density": 2400, "young": 3e7, "poisson": 0.2},
                  "high": {"density": 2400, "young": 3e7, "poisson": 0.2, "velocity": [SPEED, 0]},
                  "stones": {"density": 2400, "velocity": [SPEED, 0]}},
    "joints": {"default": {"k_n": 5e7, "k_s": 2e7, "friction": 5}},
    "supports": {"ground": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["low", "high", "stones"]}},
    "stages": [{"across": {"type": "dynamic", "loads": ["weight"], "duration": 0.5, "dt_factor": 0.2, "frames": 5}},
               {"rest": {"loads": ["weight"], "joints": {"default": {"friction": 60}}}}],
}


def rows():
    """Ground, one long body on it, short ones on that, and a stone on each; the last two move."""
    ground = rectangle(-1, -1, 2 * N + 2, 1, nx=N + 1, group="ground", rigid=True)
    low = rectangle(0, 0, 2 * N, 0.5, nx=4 * N, ny=2, group="low")
    high = [rectangle(i, 0.5, 0.98, 0.5, nx=3, ny=2, group="high") for i in range(N)]
    stones = [rectangle(i, 1, 0.98, 0.5, group="stones", rigid=True) for i in range(N)]
    return join([renamed(part, {}, {"first": "top_left"} if part is high[0] else {}) for part in (ground, low, *high, *stones)])


def dealt_out(run):
    """Of every re-partition: cycle, ghost vertices before and after."""
    return [tuple(map(int, found)) for found in re.findall(r"re-partitioned at cycle (\d+):.* ghost vertices (\d+) -> (\d+)", run.stdout)]


def same(a, b):
    """Whether checksums of stages and all fields of all frames have the same bits."""
    if [s["checksum"] for s in a.summary["stages"]] != [s["checksum"] for s in b.summary["stages"]]:
        return False
    names = [*a.stages, *a.frames("across")]
    fields = ("displacement", "stress", "rotation")
    of_contacts = ("face", "length", "opening", "sliding", "slip", "sigma", "tau", "force", "state")
    return names == [*b.stages, *b.frames("across")] and all(
        all(np.array_equal(getattr(a.stage(n), f), getattr(b.stage(n), f), equal_nan=True) for f in fields)
        and all(np.array_equal(getattr(a.stage(n).contacts, f), getattr(b.stage(n).contacts, f)) for f in of_contacts)
        for n in names)


def energies(run):
    energy = run.stage_summary("across")["energy"]
    return [energy[name] for name in ("kinetic", "strain", "joints", "outside", "friction")]


def run(case):
    one = case.run(rows(), SCENE)
    folder = case.prepare(rows(), changed(SCENE, ("checkpoint", {"every": 700, "keep": 20})))
    moved = one.probe("across", "first")[0]
    case.check("the upper rows have moved by a third of the lower one [m]", moved, SPEED * 0.5, relative=0.1)
    still = case.again(folder, "-repartition_when", "never", ranks=4)
    case.check("4 ranks, never: as on one", [same(one, still), len(dealt_out(still))], [True, 0])
    for ranks in case.ranks(2, 3, 4):
        run = case.again(folder, ranks=ranks)
        found = dealt_out(run)
        case.check(f"{ranks} ranks, auto: dealt out anew; every frame as on one", [len(found) > 0, same(one, run)], [True, True])
        case.check(f"{ranks} ranks, auto: ghost vertices after over before, at most", min(after / before for _, before, after in found), 0.0,
                   absolute=0.9)
        case.check(f"{ranks} ranks, auto: energies [J]", energies(run), energies(one), relative=1e-9)
    restarts(case, folder, one)
    often = case.again(folder, "-repartition_every", 50, "-repartition_gain", 0, ranks=3)
    case.check("3 ranks, a look every 50 cycles: more than five times, as on one", [len(dealt_out(often)) > 5, same(one, often)], [True, True])
    case.check("its share is in the line of costs", bool(re.search(r"us a cycle:.* re-partition \d+ %", often.stdout)), True)


def restarts(case, folder, one):
    """From 4 ranks, dealt out anew, on 2; and from the start of the static stage on 3, where it is dealt out within it."""
    case.again(folder, "-output", "kept", ranks=4)
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    for ranks, file, what in ((2, files[2], "within the dynamic stage"), (3, files[-2], "between the stages")):
        run = case.again(folder, "-restart", file, ranks=ranks)
        again = dealt_out(run)
        case.check(f"restart on {ranks} ranks {what}: as on one", [s["checksum"] for s in run.summary["stages"]] ==
                   [s["checksum"] for s in one.summary["stages"]], True)
        case.check(f"restart on {ranks} ranks {what}: dealt out anew", len(again) > 0, True)

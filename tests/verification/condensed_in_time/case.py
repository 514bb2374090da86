"""Condensed bodies in time against the same scene without `condensed`, step for step: with all modes they are the whole
mesh in other coordinates, so histories, energies, stresses and reactions are those of the whole mesh but for rounding."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles

WHAT = "condensed bodies in time: the whole mesh with all modes, near it with a few"
SOURCE = "the same scene without `condensed`"

T = np.arange(0, 0.4001, 1e-3)
SHAKE = 0.05 * np.sin(2 * np.pi * 6 * T) * np.sin(np.pi * T / 0.4) ** 2
ROCK, DAM = ({"density": rho, "young": e, "poisson": 0.2} for rho, e in ((2600, 2e9), (2400, 1e9)))
ALL = 1e5  # Hz
SHAKING = {"type": "dynamic", "loads": ["weight"], "duration": 0.4, "dt_factor": 0.5, "alpha": 2.0, "frames": 1}
WATER = {"hydro": {"type": "added_mass", "faces": "upstream", "level": 10}}
SCENE = {
    "strain": "small",
    "materials": {"rock": ROCK, "dam": DAM},
    "joints": {"default": {"law": "elastic", "k_n": 2e9, "k_s": 1e9}},
    "supports": {"bottom": {"fix": "xy", "motion": "quake.csv"}, "sides": {"fix": "y"}},
    "relaxation": {"history_every": 5, "tolerance": 1e-13, "velocity_tolerance": 1e-13},
    "loads": {"weight": {"type": "self_weight"}} | WATER,
    "stages": [{"shake": SHAKING}],
}
QUIET = [("supports", {"bottom": {"fix": "xy", "boundary": "quiet", "motion": "quake.csv"}, "sides": {"fix": "x", "boundary": "quiet"}}),
         ("loads", {"push": {"type": "traction", "faces": "crest", "value": [1e5, 0]}} | WATER),
         ("stages", [{"rest": {"loads": ["push"]}}, {"shake": SHAKING | {"loads": ["push", "hydro"]}}, {"after": {"loads": ["push"]}}])]


def mesh(n=1):
    rock = renamed(rectangle(-8, -6, 24, 6, 12 * n, 3 * n, group="rock"), {"bottom": "bottom", "sides": "left"}, {"free": "top_right"})
    dam = renamed(rectangle(0, 0, 8, 12, 4 * n, 4 * n, group="dam"), {"upstream": "left", "crest": "top"}, {"heel": "bottom_left", "top": "top_left"})
    return join([rock, dam])


def condensed(frequency, *groups):
    return [(f"materials.{g}", {"rock": ROCK, "dam": DAM}[g] | {"condensed": True, "highest_frequency": frequency}) for g in groups or ("rock", "dam")]


def prepared(case, mesh_, *changes):
    folder = case.prepare(mesh_, changed(SCENE, *changes))
    (folder / "quake.csv").write_text("".join(f"{t:.6g}, {v:.17g}, {-0.5 * v:.17g}\n" for t, v in zip(T, SHAKE, strict=True)))
    return folder


def shaken(case, mesh_, *changes, ranks=1):
    return case.again(prepared(case, mesh_, *changes), ranks=ranks)


def same_steps(case, mesh_, like, *changes, also=None):
    """A run with as many steps as another one, whose bound of the step is another."""
    folder, steps, factor = prepared(case, mesh_, *changes), like.stage_summary("shake")["cycles"], SHAKING["dt_factor"]
    for _ in range(6):
        result = case.again(folder, *(x for key in ("-stages_shake_dt_factor", also) if key for x in (key, f"{factor:.12g}")))
        found = result.stage_summary("shake")["cycles"]
        if found == steps:
            return result
        factor *= found / steps * (1 - 0.2 / steps)
    raise RuntimeError(f"{found} steps, not {steps}")


def apart(a, b, *names):
    """Largest difference of columns of the histories over the largest value of these columns."""
    found, wanted = ([r.history[n][np.array([stage == "shake" for stage in r.history["stage"]])] for n in names] for r in (a, b))
    return max(abs(x - y).max() for x, y in zip(found, wanted, strict=True)) / max(abs(y).max() for y in wanted)


PROBES = [f"{p}_u{x}_m" for p in ("top", "heel", "free") for x in "xy"]


def run(case):
    whole(case)
    quiet(case)
    few_modes(case)
    slides(case)
    stages(case)
    step(case)
    ranks(case)
    restart(case)
    refusals(case)


def compare(case, what, full, reduced):
    """All that two runs with the same steps write."""
    case.check(f"{what}: displacements of probes, over the largest", apart(reduced, full, *PROBES), 0.0, absolute=1e-9)
    for name in ("kinetic", "strain", "joints", "outside", "supports", "damping"):
        case.check(f"... {name} energy or work, over the largest", apart(reduced, full, f"{name}_J"), 0.0, absolute=1e-9)
    balance = [abs(r.stage_summary("shake")["energy"]["balance"]) / np.nanmax(r.history["strain_J"]) for r in (full, reduced)]
    case.check("... balance over the largest strain energy", balance, [0.0, 0.0], absolute=1e-11)
    for name in ("shake_1", "shake"):
        a, b = (r.stage(name) for r in (reduced, full))
        size = abs(b.displacement).max()
        case.check(f"... {name}: displacements of all vertices, over the largest", abs(a.displacement - b.displacement).max() / size, 0.0, absolute=1e-9)
        case.check("... stresses of all blocks, over the largest", abs(a.stress - b.stress).max() / abs(b.stress).max(), 0.0, absolute=1e-9)
    forces = [np.array([list(s.values()) for s in r.stage_summary("shake")["supports"].values()]) for r in (reduced, full)]
    case.check("... forces of the supports at the end, over the largest", abs(forces[0] - forces[1]).max() / max(abs(forces[1]).max(), 1.0), 0.0, absolute=1e-9)


def whole(case):
    """A base that moves in both directions, rollers inside, weight put on at once, damping by mass."""
    for what, mesh_ in (("quadrilaterals", mesh()), ("triangles", split_triangles(mesh()))):
        full = shaken(case, mesh_)
        compare(case, f"{what}, all modes", full, same_steps(case, mesh_, full, *condensed(ALL)))
    mesh_ = mesh()
    compare(case, "dam alone condensed, all modes", full := shaken(case, mesh_), same_steps(case, mesh_, full, *condensed(ALL, "dam")))


def quiet(case):
    """Quiet base and sides that let a wave in, water that moves, from a static stage."""
    full = shaken(case, mesh(), *QUIET)
    reduced = same_steps(case, mesh(), full, *condensed(ALL), *QUIET)
    compare(case, "quiet boundaries, added mass, all modes", full, reduced)
    for name in ("incoming", "radiated"):
        case.check(f"... {name}, over the largest", apart(reduced, full, f"{name}_J"), 0.0, absolute=1e-9)
    case.check("... then at rest: displacements of all vertices", reduced.stage("after").displacement, full.stage("after").displacement, absolute=1e-9)


def few_modes(case):
    """The fewer the modes, the larger the error. What a run tells of those left out."""
    smooth = ("stages", [{"shake": SHAKING | {"loads": []}}])
    full, found = shaken(case, mesh(), smooth), []
    for frequency in (20, 40, 80):
        result = same_steps(case, mesh(), full, smooth, *condensed(frequency))
        found.append(apart(result, full, "top_ux_m", "top_uy_m"))
    for frequency, error, most in zip((20, 40, 80), found, (0.06, 0.006, 2e-4), strict=True):
        case.check(f"modes to {frequency} Hz: error of the crest over the largest displacement", error, 0.0, absolute=most)
    case.check("... falls", found[0] > 5 * found[1] > 25 * found[2] > 0, True)
    case.check("... is told", ["none from" in result.stdout, "all there are" in shaken(case, mesh(), *condensed(ALL)).stdout], [True, True])
    waves = shaken(case, mesh(), *QUIET)
    case.check("quiet boundaries, modes to 80 Hz: error of the crest over the largest displacement", apart(same_steps(case, mesh(), waves, *condensed(80), *QUIET), waves, "top_ux_m"), 0.0, absolute=0.01)
    large = shaken(case, mesh(), ("strain", "large"))
    case.check("the same in large strain, all modes: error of the crest", apart(same_steps(case, mesh(), large, *condensed(ALL), ("strain", "large")), large, "top_ux_m"), 0.0, absolute=0.01)


SLIDING = [("joints.default", {"law": "mohr_coulomb", "k_n": 2e9, "k_s": 1e9, "friction": 4, "damping": 2e-4}),
           ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"frames": 0}}, {"after": {"loads": ["weight"]}}])]


def slides(case):
    """A dam that slides on its rock, both condensed; a little damping in the joint stops what would rattle for ever."""
    full = shaken(case, mesh(), *SLIDING)
    slip = [r.probe("after", "heel")[0] - r.probe("after", "free")[0] for r in (full, *(same_steps(case, mesh(), full, *SLIDING, *condensed(f)) for f in (80, ALL)))]
    case.check("friction of 4 degrees: the dam has slid by more than 0.5 mm", abs(slip[0]) > 5e-4, True)
    case.check("... modes to 80 Hz: by, over that of the whole mesh", slip[1] / slip[0], 1.0, absolute=0.03)
    case.check("... all modes", slip[2] / slip[0], 1.0, absolute=1e-6)


def stages(case):
    """Nothing moves at the start of a stage; what is inside stays where it is when loads go."""
    rest = [("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"alpha": 0}}]), ("supports.bottom", {"fix": "xy"})]
    still = shaken(case, mesh(), *condensed(40), *rest)
    u = [still.stage(s).displacement for s in ("rest", "shake")]
    case.check("weight at rest, then in time: all vertices move by, over the largest displacement", abs(u[1] - u[0]).max() / abs(u[0]).max(), 0.0, absolute=1e-11)
    case.check("... forces of the supports [N]", [sum(held["y"] for held in still.stage_summary(s)["supports"].values()) for s in ("rest", "shake")],
               [9.81 * (2600 * 144 + 2400 * 96)] * 2, relative=1e-9)
    gone = [("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"duration": 0.2}}, {"more": SHAKING | {"loads": [], "duration": 0.2}}, {"after": {"loads": ["weight"]}}])]
    full = shaken(case, mesh(), *gone)
    reduced = same_steps(case, mesh(), full, *condensed(ALL), *gone, also="-stages_more_dt_factor")
    for name in ("shake_1", "shake", "more_1", "more", "after"):
        a, b = (r.stage(name).displacement for r in (reduced, full))
        case.check(f"two stages in time, no weight in the second: {name}: displacements of all vertices, over the largest", abs(a - b).max() / abs(b).max(), 0.0, absolute=1e-9)
    case.check("... energies at the end of the second, over the largest", [(reduced.stage_summary("more")["energy"][e] - full.stage_summary("more")["energy"][e]) / full.stage_summary("more")["energy"]["strain"]
                                                                          for e in ("kinetic", "strain", "outside", "balance")], [0.0] * 4, absolute=1e-9)


def step(case):
    """The bound of the step is that of the fastest vibration: at it the motion still neither grows nor fades."""
    rock = renamed(rectangle(-8, -6, 24, 6, 12, 3, group="rock"), {"bottom": "bottom"}, {"free": "top_right"})
    for what, mesh_, keys in (("a body alone", rock, [("materials", {"rock": ROCK}), ("joints", {}), ("loads", {"weight": {"type": "self_weight"}})]), ("two bodies", mesh(), [])):
        stage = SHAKING | {"alpha": 0, "dt_factor": 1, "duration": 2, "frames": 0}
        keys = [*keys, ("supports", {"bottom": {"fix": "xy"}}), ("stages", [{"shake": stage}])]
        for frequency in (40, ALL):
            result = shaken(case, mesh_, *keys, *[k for k in condensed(frequency) if k[0] != "materials.dam" or mesh_ is not rock])
            energy = result.stage_summary("shake")["energy"]
            case.check(f"{what}, modes to {frequency:g} Hz: 2 s at the bound of the step: balance over the strain energy", energy["balance"] / np.nanmax(result.history["strain_J"]), 0.0, absolute=1e-10)
            early, late = (np.ptp(half) for half in np.array_split(result.history["free_uy_m"], 2))
            case.check("... displacement of the surface, largest in the second half over the first", late / early, 1.0, absolute=0.1)
        whole_mesh = shaken(case, mesh_, *keys)
        case.check("... the bound over that of the whole mesh is no less than 1", result.stage_summary("shake")["dt"] / whole_mesh.stage_summary("shake")["dt"] > 1 - 1e-6, True)


def ranks(case):
    """Three dams on rock."""
    rock = renamed(rectangle(-8, -6, 40, 6, 20, 3, group="rock"), {"bottom": "bottom", "sides": "left"}, {"free": "top_right"})
    dams = [renamed(rectangle(x, 0, 6, 6, 3, 3, group="dam"), {"upstream": "left", "crest": "top"}, {f"top{x}": "top_left"}) for x in (0, 10, 20)]
    keys = [*SLIDING, ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"loads": ["weight", "hydro"], "duration": 0.1}}])]
    for what, change in (("dams condensed", condensed(60, "dam")), ("dams and rock condensed", condensed(60))):
        sums = [shaken(case, join([rock, *dams]), *change, *keys, ranks=n).stage_summary("shake")["checksum"] for n in (1, 2, 3, 4)]
        case.check(f"{what}: checksums on 1 to 4 ranks", len(set(sums)), 1)


def restart(case):
    keys = [*condensed(60), *QUIET, ("checkpoint", {"every": 150, "keep": 100})]
    folder = prepared(case, mesh(), *keys)
    whole_run = case.again(folder)
    case.again(folder, "-output", "kept")
    files, same = sorted((folder / "kept" / "checkpoints").iterdir()), []
    for number, file in enumerate(files):
        again = case.again(folder, "-restart", file, ranks=2 if number % 3 == 0 else 1)
        same.append([again.stage_summary(s)["checksum"] == whole_run.stage_summary(s)["checksum"] for s in ("shake", "after")])
    case.check("restart from each checkpoint, on 1 and 2 ranks: same bits", [len(files) > 4, bool(np.all(same))], [True, True])


def refusals(case):
    body = ROCK | {"condensed": True}
    for what, changes, words in (
            ("no highest frequency", [("materials.rock", body)], "highest_frequency is missing [Hz]: condensed, and stage shake is dynamic"),
            ("no density", [("materials.rock", body | {"highest_frequency": 40, "density": 0})], "expected a density > 0"),
            ("a velocity at the start", [("materials.dam", body | {"highest_frequency": 40, "velocity": [1, 0]})], "a condensed body starts at rest"),
            ("a whole group that moves", [*condensed(40, "rock"), ("supports", {"rock": {"fix": "xy", "motion": "quake.csv"}})], "moves the condensed group rock as a whole"),
            ("a free field", [*condensed(40, "rock"), ("supports", {"bottom": {"fix": "xy", "motion": "quake.csv"}, "sides": {"fix": "x", "boundary": "free_field"}})], "which is condensed: expected faces of blocks that deform"),
            ("a vertex of a rigid body", [*condensed(40, "rock"), ("materials.lower", {"density": 2600, "rigid": True}), ("supports", {"lower": {"fix": "xy"}})], "with a rigid one")):
        mesh_ = mesh()
        if "materials.lower" in dict(changes):
            lower = mesh_.vertices[mesh_.blocks].mean(axis=1)[:, 1] < -4
            mesh_.group_names, mesh_.group_rigid = [*mesh_.group_names, "lower"], np.zeros(3, np.int32)
            mesh_.block_group = np.where(lower, 2, mesh_.block_group).astype(np.int32)
        result = shaken(case, mesh_, *changes)
        case.check(f"{what}: refused in one line", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])

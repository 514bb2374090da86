"""Condensed bodies in time against the same scene without `condensed`, step for step: with all modes they are the whole
mesh in other coordinates, so histories, energies, stresses and reactions are those of the whole mesh but for rounding."""

from copy import deepcopy

import numpy as np
from driver import changed, load
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles

WHAT = "condensed bodies in time: the whole mesh with all modes, near it with a few"
SOURCE = "the same scene without `condensed`"
BY = "Quoin itself, not condensed"

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


LONG = ("calm", "restart", "on_ground", "error_told")  # parts that the short form leaves out


def run(case):
    whole(case)
    stiffness_damping(case)
    quiet(case)
    few_modes(case)
    calm(case)
    error_told(case)
    slides(case)
    strikes(case)
    stages(case)
    step(case)
    ranks(case)
    restart(case)
    modes(case)
    dams(case)
    on_ground(case)
    refusals(case)


def compare(case, what, full, reduced):
    """All that two runs with the same steps write."""
    case.check(f"{what}: displacements of probes, over the largest", apart(reduced, full, *PROBES), 0.0, absolute=1e-9)
    for name in ("kinetic", "strain", "joints", "outside", "supports", "damping"):
        case.check(f"... {name} energy or work, over the largest", apart(reduced, full, f"{name}_J"), 0.0, absolute=1e-9)
    balance = [abs(r.stage_summary("shake")["energy"]["balance"]) / np.nanmax(r.history["strain_J"]) for r in (full, reduced)]
    case.check("... balance over the largest strain energy", balance, [0.0, 0.0], absolute=1e-11)
    for s in (n[:-5] for n in full.history if n.endswith("_fx_N")):
        case.check(f"... forces of {s} in time, over the largest", apart(reduced, full, f"{s}_fx_N", f"{s}_fy_N"), 0.0, absolute=1e-8)
    for name in ("shake_1", "shake"):
        a, b = (r.stage(name) for r in (reduced, full))
        size = abs(b.displacement).max()
        case.check(f"... {name}: displacements of all vertices, over the largest", abs(a.displacement - b.displacement).max() / size, 0.0, absolute=1e-9)
        case.check("... stresses of all blocks, over the largest", abs(a.stress - b.stress).max() / abs(b.stress).max(), 0.0, absolute=1e-9)
    a, b = (r.stage("shake").envelope for r in (reduced, full))
    if b:
        found = [(getattr(a, name) - getattr(b, name)) / abs(b.s2_min).max() for name in ("s1_max", "s2_min")]
        case.check("... envelopes of stresses of all blocks, over the largest", np.concatenate(found), np.zeros(2 * len(b.s1_max)), absolute=1e-9)
    forces = [np.array([list(s.values()) for s in r.stage_summary("shake")["supports"].values()]) for r in (reduced, full)]
    case.check("... forces of the supports at the end, over the largest", abs(forces[0] - forces[1]).max() / max(abs(forces[1]).max(), 1.0), 0.0, absolute=1e-9)


def whole(case):
    """A base that moves in both directions, rollers inside, weight put on at once, damping by mass."""
    for what, mesh_ in (("quadrilaterals", mesh()), ("triangles", split_triangles(mesh()))):
        full = shaken(case, mesh_)
        compare(case, f"{what}, all modes", full, same_steps(case, mesh_, full, *condensed(ALL)))
    mesh_ = mesh()
    compare(case, "dam alone condensed, all modes", full := shaken(case, mesh_), same_steps(case, mesh_, full, *condensed(ALL, "dam")))


DAMPED = ("stages", [{"shake": SHAKING | {"beta": 2e-3, "envelope_every": 20}}])


def stiffness_damping(case):
    """Damping by stiffness: of the whole stage; of one group, an elastic one between others; bodies that share vertices have one."""
    for what, mesh_ in (("quadrilaterals", mesh()), ("triangles", split_triangles(mesh()))):
        full = shaken(case, mesh_, DAMPED)
        compare(case, f"beta, {what}, all modes", full, same_steps(case, mesh_, full, *condensed(ALL), DAMPED))
    full = shaken(case, mesh(), ("materials.dam", DAM | {"beta": 4e-3}))
    rock, dam = condensed(ALL)
    compare(case, "beta of the dam alone", full, same_steps(case, mesh(), full, rock, (dam[0], dam[1] | {"beta": 4e-3})))
    compare(case, "... the rock not condensed", full, same_steps(case, mesh(), full, (dam[0], dam[1] | {"beta": 4e-3})))
    compare(case, "... the dam not condensed", full, same_steps(case, mesh(), full, rock, ("materials.dam", DAM | {"beta": 4e-3})))
    keys = [*SLIDING, ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"frames": 0, "beta": 1e-3}}, {"more": SHAKING | {"frames": 0, "alpha": 0, "duration": 0.1}}, {"after": {"loads": ["weight"]}}])]
    full = shaken(case, mesh(), *keys)
    reduced = same_steps(case, mesh(), full, *keys, *condensed(ALL), also="-stages_more_dt_factor")
    for stage in ("shake", "more", "after"):
        a, b = (r.stage(stage).displacement for r in (reduced, full))
        case.check(f"beta, friction, then a stage without: {stage}: all vertices, over the largest", abs(a - b).max() / abs(b).max(), 0.0, absolute=1e-6)
    still = [("supports.bottom", {"fix": "xy"}), ("joints.default.k_n", 2e8), ("joints.default.k_s", 1e8)]
    for beta in (1e-3, 1e-2):
        for frequency in (40, ALL):
            keys = [*still, *condensed(frequency), ("stages", [{"shake": SHAKING | {"alpha": 0, "beta": beta, "dt_factor": 1, "duration": 1}}])]
            result = shaken(case, mesh(), *keys)
            case.check(f"beta {beta:g} s, modes to {frequency:g} Hz, at the bound of the step: balance over the strain energy", result.stage_summary("shake")["energy"]["balance"] / np.nanmax(result.history["strain_J"]), 0.0, absolute=1e-9)
            case.check("... what sets it: beta, where the body has all modes", "beta of group " in result.stdout, frequency == ALL)
            if frequency != ALL:
                free = shaken(case, mesh(), *still, *condensed(frequency), ("stages", [{"shake": SHAKING | {"alpha": 0, "dt_factor": 1, "duration": 1}}]))
                case.check("... the step over that without beta", result.stage_summary("shake")["dt"] / free.stage_summary("shake")["dt"], 1.0, absolute=0.01)
            early, late = (np.ptp(half) for half in np.array_split(result.history["top_uy_m"], 2))
            case.check("... the motion fades: that of the second half over that of the first", 0 < late < 0.7 * early, True)


    smooth = ("stages", [{"shake": SHAKING | {"loads": [], "beta": 2e-3, "dt_factor": 0.1}}])
    full = shaken(case, mesh(), smooth)
    reduced = same_steps(case, mesh(), full, smooth, *condensed(80))
    case.check("beta, a base that moves, modes to 80 Hz: error of the crest over the largest displacement", apart(reduced, full, "top_ux_m", "top_uy_m"), 0.0, absolute=2e-4)
    for name, absolute in (("damping", 1e-3), ("supports", 1e-3), ("kinetic", 2e-3)):
        case.check(f"... {name} energy or work, over the largest", apart(reduced, full, f"{name}_J"), 0.0, absolute=absolute)
    case.check("... balance over the largest strain energy", reduced.stage_summary("shake")["energy"]["balance"] / np.nanmax(reduced.history["strain_J"]), 0.0, absolute=1e-11)


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
    for frequency, error, most in zip((20, 40, 80), found, (0.015, 0.0025, 1e-4), strict=True):
        case.check(f"modes to {frequency} Hz: error of the crest over the largest displacement", error, 0.0, absolute=most)
    case.check("... falls", found[0] > 5 * found[1] > 25 * found[2] > 0, True)
    case.check("... is reported", ["none from" in result.stdout, "all there are" in shaken(case, mesh(), *condensed(ALL)).stdout], [True, True])
    waves = shaken(case, mesh(), *QUIET)
    case.check("quiet boundaries, modes to 80 Hz: error of the crest over the largest displacement", apart(same_steps(case, mesh(), waves, *condensed(80), *QUIET), waves, "top_ux_m"), 0.0, absolute=0.01)
    large = shaken(case, mesh(), ("strain", "large"))
    case.check("the same in large strain, all modes: error of the crest", apart(same_steps(case, mesh(), large, *condensed(ALL), ("strain", "large")), large, "top_ux_m"), 0.0, absolute=0.01)


CALM = [("supports", {"bottom": {"fix": "xy", "boundary": "quiet", "motion": "quake.csv"}, "sides": {"fix": "y"}}), ("loads", {"weight": {"type": "self_weight"}} | WATER),
        ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"loads": ["weight", "hydro"], "envelope_every": 20}}, {"after": {"loads": ["weight"]}}])]


def calm(case):
    """Vertices under water and at supports that move by shapes: near the whole mesh, the nearer the more modes; what rollers bear; restarts and ranks."""
    fine, found = mesh(2), []
    full = shaken(case, fine, *CALM)
    for frequency in (20, 40, 80):
        result = same_steps(case, fine, full, *CALM, *condensed(frequency))
        moved = [[int(word) for word in line.split() if word.isdigit()] for line in result.stdout.splitlines() if "shapes" in line]
        case.check(f"calm vertices, modes to {frequency} Hz: said to move by shapes, fewer than they are", [len(moved), moved[0][1] < moved[0][0]], [1, True])
        swing = apart(result, full, "top_ux_m")
        bears = apart(result, full, "sides_fx_N", "sides_fy_N")
        found.append((swing, bears))
        energy = result.stage_summary("shake")["energy"]
        case.check("... balance over what came in", energy["balance"] / energy["incoming"], 0.0, absolute=1e-9)
    for i, what, most in ((0, "displacement of the crest", (0.05, 0.01, 0.002)), (1, "forces of rollers", (0.05, 0.01, 0.002))):
        for frequency, f, absolute in zip((20, 40, 80), found, most, strict=True):
            case.check(f"calm vertices, modes to {frequency} Hz: error of the {what}, over the largest", f[i], 0.0, absolute=absolute)
    sums = [shaken(case, fine, *CALM, *condensed(40), ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3)]
    case.check("calm vertices: checksums on 1 to 3 ranks", len(set(sums)), 1)
    folder = prepared(case, fine, *CALM, *condensed(40), ("checkpoint", {"every": 150, "keep": 100}))
    case.again(folder)
    case.again(folder, "-output", "kept")
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    shakes = [case.again(folder, "-restart", f).stage_summary("shake") for f in case.some(files, 3)]
    case.check("calm vertices: restart from each checkpoint: same bits", [len(files) > 1, {shake["checksum"] for shake in shakes}], [True, {sums[0]}])
    case.check("... balance over what came in", max(abs(shake["energy"]["balance"]) for shake in shakes) / energy["incoming"], 0.0, absolute=1e-9)


def scaled(young, hertz=None):
    """Both groups so many times as stiff, condensed to a frequency."""
    inside = {"condensed": True, "highest_frequency": hertz} if hertz else {}
    return [(f"materials.{g}", m | {"young": young * m["young"]} | inside) for g, m in (("rock", ROCK), ("dam", DAM))]


def error_told(case):
    """What a run says that bodies lack, against the whole mesh: smooth shaking of soft and stiff bodies, with water, on quiet ground; and where it cannot say it."""
    smooth = ("stages", [{"shake": SHAKING | {"loads": [], "frames": 20}}])
    wet = [QUIET[0], ("stages", [{"shake": SHAKING | {"loads": ["hydro"], "frames": 20}}])]
    for what, young, keys, frequencies in (("as it is", 1, [smooth], (20, 40, 80)), ("four times as stiff", 4, [smooth], (20, 80)), ("a fourth as stiff", 0.25, [smooth], (40,)), ("quiet ground, added mass", 1, wet, (20, 40))):
        full = shaken(case, mesh(), *scaled(young), *keys)
        for frequency in frequencies:
            reduced = same_steps(case, mesh(), full, *scaled(young, frequency), *keys)
            lacking = reduced.stage_summary("shake")["lacking"]
            stress = [np.array([r.stage(n).stress for n in full.frames("shake")]) for r in (reduced, full)]
            true = np.sqrt(((stress[0] - stress[1])**2).mean() / (stress[1]**2).mean())
            case.check(f"{what}, modes to {frequency} Hz: true error of stresses, root mean square over blocks and time, over the bound reported", true / lacking["stress"], 0.65, absolute=0.6)
            case.check("... true error of the crest over the largest displacement, over the bound reported of frequencies", apart(reduced, full, "top_ux_m", "top_uy_m") / lacking["frequency"], 1.75, absolute=1.75)
            case.check("... kept vertices are slower than modes left out", 0 < lacking["haste"] < 0.3, True)
            case.check("... said", "stresses of the motion are off by up to some" in reduced.stdout, True)
    blow = [("stages", [{"shake": SHAKING}])]
    for what, keys in (("weight put on at once", blow),):
        lacking = (reduced := shaken(case, mesh(), *scaled(1, 40), *keys)).stage_summary("shake")["lacking"]
        case.check(f"{what}: no error is reported", [lacking["stress"], lacking["haste"] > 0.3, "is not known: their kept vertices move at" in reduced.stdout], [None, True, True])
    case.check("all modes: nothing is lacking", "lacking" in shaken(case, mesh(), *scaled(1, ALL), smooth).stage_summary("shake"), False)


SLIDING = [("joints.default", {"law": "mohr_coulomb", "k_n": 2e9, "k_s": 1e9, "friction": 4, "damping": 2e-4}),
           ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"frames": 0}}, {"after": {"loads": ["weight"]}}])]


def slides(case):
    """A dam that slides on its rock, both condensed; a little damping in the joint stops what would rattle for ever."""
    full = shaken(case, mesh(), *SLIDING)
    slip = [r.probe("after", "heel")[0] - r.probe("after", "free")[0] for r in (full, *(same_steps(case, mesh(), full, *SLIDING, *condensed(f)) for f in (80, ALL)))]
    case.check("friction of 4 degrees: the dam has slid by more than 0.5 mm", abs(slip[0]) > 5e-4, True)
    case.check("... modes to 80 Hz: by, over that of the whole mesh", slip[1] / slip[0], 1.0, absolute=0.003)
    case.check("... all modes", slip[2] / slip[0], 1.0, absolute=1e-6)


def strikes(case):
    """A column that is struck at its end, by a load that comes at once: waves run off into what has no modes, and the account knows what they take."""
    column = renamed(rectangle(0, 0, 1, 64, 1, 64, group="rock"), {"bottom": "bottom", "end": "top"}, {"free": "top_right", "left": "top_left"})
    blow = [("materials", {"rock": ROCK | {"poisson": 0}}), ("joints", {}), ("supports", {"bottom": {"fix": "xy"}}), ("loads", {"blow": {"type": "traction", "faces": "end", "value": [0, -1e5]}}),
            ("stages", [{"shake": SHAKING | {"loads": ["blow"], "duration": 0.14, "alpha": 0, "frames": 0}}])]
    full = shaken(case, column, *blow)
    reduced = same_steps(case, column, full, *blow, ("materials", {"rock": ROCK | {"poisson": 0, "condensed": True, "highest_frequency": 60}}))
    speed = 1e5 / np.sqrt(ROCK["density"] * ROCK["young"])
    t, u = (reduced.history[name][reduced.history["stage"] == "shake"] for name in ("time_s", "free_uy_m"))
    case.check("struck column, modes to 60 Hz: velocity of its end until the wave is back, over p / (rho c)", -np.polyfit(t[t > 0.02], u[t > 0.02], 1)[0] / speed, 1.0, absolute=0.002)
    case.check("... displacement of its end against the whole mesh, over the largest", apart(reduced, full, "free_uy_m"), 0.0, absolute=0.008)
    energy = reduced.stage_summary("shake")["energy"]
    case.check("... something is lost to the modes left out, over the work", 0.005 < energy["damping"] / energy["outside"] < 0.2, True)
    case.check("... balance over the work", energy["balance"] / energy["outside"], 0.0, absolute=1e-11)


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
    """The bound of the step is that of the fastest vibration: at it the motion does not grow; nor does it fade where no modes are left out."""
    rock = renamed(rectangle(-8, -6, 24, 6, 12, 3, group="rock"), {"bottom": "bottom"}, {"free": "top_right"})
    for what, mesh_, keys in (("a body alone", rock, [("materials", {"rock": ROCK}), ("joints", {}), ("loads", {"weight": {"type": "self_weight"}})]), ("two bodies", mesh(), [])):
        stage = SHAKING | {"alpha": 0, "dt_factor": 1, "duration": 2, "frames": 0}
        keys, found = [*keys, ("supports", {"bottom": {"fix": "xy"}}), ("stages", [{"shake": stage}])], []
        for frequency in (40, ALL):
            result = shaken(case, mesh_, *deepcopy(keys), *[k for k in condensed(frequency) if k[0] != "materials.dam" or mesh_ is not rock])
            found.append(result)
            energy = result.stage_summary("shake")["energy"]
            case.check(f"{what}, modes to {frequency:g} Hz: 2 s at the bound of the step: balance over the strain energy", energy["balance"] / np.nanmax(result.history["strain_J"]), 0.0, absolute=1e-10)
            early, late = (np.ptp(half) for half in np.array_split(result.history["free_uy_m"], 2))
            case.check("... displacement of the surface, largest in the second half over the first", late / early if frequency == ALL else max(late / early, 1.0), 1.0, absolute=0.1)
        whole_mesh = shaken(case, mesh_, *keys)
        dt = [r.stage_summary("shake")["dt"] for r in (whole_mesh, *found)]
        told_ = [[float(line.split()[2]) for line in r.stdout.splitlines() if "of the steps that their blocks would need" in line] for r in found]
        case.check("... steps over those of the whole mesh, as reported", told_, [[dt[0] / dt[1]], [dt[0] / dt[2]]], relative=0.06)
        case.check("... a run warns where they take longer: the small two bodies with all modes", ["times as long as their blocks would" in r.stdout for r in found], [False, mesh_ is not rock])
        case.check("... the bound over that of the whole mesh is no less than 1", result.stage_summary("shake")["dt"] / whole_mesh.stage_summary("shake")["dt"] > 1 - 1e-6, True)


def ranks(case):
    """Three dams on rock."""
    rock = renamed(rectangle(-8, -6, 40, 6, 20, 3, group="rock"), {"bottom": "bottom", "sides": "left"}, {"free": "top_right"})
    dams = [renamed(rectangle(x, 0, 6, 6, 3, 3, group="dam"), {"upstream": "left", "crest": "top"}, {f"top{x}": "top_left"}) for x in (0, 10, 20)]
    keys = [*SLIDING, ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING | {"loads": ["weight", "hydro"], "duration": 0.1}}])]
    for what, change in (("dams condensed", condensed(60, "dam")), ("dams and rock condensed", condensed(60))):
        sums = [shaken(case, join([rock, *dams]), *change, *keys, ranks=n).stage_summary("shake")["checksum"] for n in case.ranks(1, 2, 3, 4)]
        case.check(f"{what}: checksums on 1 to 4 ranks", len(set(sums)), 1)


def restart(case):
    keys = [*condensed(60), *QUIET, ("stages", [QUIET[2][1][0], {"shake": SHAKING | {"loads": ["push", "hydro"], "beta": 1e-3}}, QUIET[2][1][2]]), ("checkpoint", {"every": 150, "keep": 100})]
    folder = prepared(case, mesh(), *keys)
    whole_run = case.again(folder)
    case.again(folder, "-output", "kept")
    files, same = sorted((folder / "kept" / "checkpoints").iterdir()), []
    told_ = []
    for number, file in enumerate(files):
        again = case.again(folder, "-restart", file, ranks=2 if number % 3 == 0 else 1)
        same.append([again.stage_summary(s)["checksum"] == whole_run.stage_summary(s)["checksum"] for s in ("shake", "after")])
        told_.append(list(again.stage_summary("shake")["lacking"].values()))
    case.check("restart from each checkpoint, on 1 and 2 ranks: same bits", [len(files) > 4, bool(np.all(same))], [True, True])
    case.check("... what bodies are reported to lack", told_, [list(whole_run.stage_summary("shake")["lacking"].values())] * len(files), relative=1e-9)


# ---- modes of the whole

BODIES = load("added_mass")
SWING = [("supports.bottom", {"fix": "xy"}), ("stages", [{"rest": {"loads": ["weight"]}}, {"dry": {"type": "modes"}}, {"wet": {"type": "modes", "loads": ["hydro"], "count": 8}}])]


def facts(result, stage):
    """Frequencies, effective masses, what a run says frequencies are too high by."""
    modes_ = result.stage_summary(stage)["modes"]
    return *(np.array([m[name] for m in modes_["list"]], float) for name in ("f", "mass_x", "mass_y")), np.array([m.get("too_high", 0) for m in modes_["list"]], float), modes_


def modes(case):
    """All modes inside: those of the whole mesh, with their shapes. A few: too high, by as much as the run says."""
    for what, mesh_, groups in (("quadrilaterals", mesh(), ()), ("triangles", split_triangles(mesh()), ()), ("dam alone condensed", mesh(), ("dam",))):
        for strain in ("small", "large"):
            keys = [*SWING, ("strain", strain)]
            full, reduced = (shaken(case, mesh_, *keys, *extra) for extra in ([], condensed(ALL, *groups)))
            for stage in ("dry", "wet"):
                (f, x, y, _, all_), (f_, x_, y_, error, found) = (facts(r, stage) for r in (full, reduced))
                near = {"absolute": 1e-9 if strain == "small" else 2e-3}  # in large strain the whole mesh swings about what its weight has turned
                case.check(f"{what}, {strain} strain, {stage}: frequencies over those of the whole mesh, less 1", f_ / f - 1, 0 * f, **near)
                if strain == "large":
                    continue
                case.check("... effective masses over the mass", [(x_ - x) / all_["mass_x"], (y_ - y) / all_["mass_y"]], [0 * f] * 2, absolute=1e-9)
                case.check("... mass that moves [kg]", [found["mass_x"], found["mass_y"]], [all_["mass_x"], all_["mass_y"]], relative=1e-12)
                case.check("... shapes at all vertices", abs(reduced.stage(stage).modes - full.stage(stage).modes).max(), 0.0, absolute=1e-7)
                case.check("... what is reported", error, 0 * f, absolute=1e-9)
    whole_mesh = shaken(case, mesh(), *SWING)
    for frequency in (20, 40, 80):
        few = shaken(case, mesh(), *SWING, *condensed(frequency))
        for stage in ("dry", "wet"):
            told("two bodies", case, whole_mesh, few, stage, frequency)
    sums = [facts(shaken(case, mesh(), *SWING, *condensed(40), ranks=n), "wet")[0] for n in case.ranks(1, 2, 3)]
    case.check("on several ranks: frequencies over those on one, less 1", [other / sums[0] - 1 for other in sums[1:]], [0 * sums[0]] * len(sums[1:]), absolute=1e-9)
    case.check("... checksums of what runs before them", len({shaken(case, mesh(), *keys, *condensed(40)).stage_summary("rest")["checksum"] for keys in (SWING, [SWING[0], ("stages", [{"rest": {"loads": ["weight"]}}, {"shake": SHAKING}])])}), 1)
    short = shaken(case, mesh(), *SWING, *condensed(3))
    case.check("modes above those that bodies lack: said to be not known", [bool(np.isnan(facts(short, "wet")[3]).any()), "it is not known: raise highest_frequency" in short.stdout], [True, True])


def told(what, case, full, reduced, stage, frequency):
    """True and reported errors of frequencies."""
    f, f_, error = facts(full, stage)[0], facts(reduced, stage)[0], facts(reduced, stage)[3]
    true, known = f_ / f - 1, np.isfinite(error) & (error < 0.03)
    case.check(f"{what}, {stage}, modes to {frequency} Hz: no frequency is too low", bool((true > -1e-9).all()), True)
    ratio = true[known] / error[known]
    case.check("... true errors over those reported, of those reported below 3 %: least, largest", [ratio.min(), ratio.max()], [0.96, 0.96], absolute=0.06)


def dams(case):
    """VS12, condensed: three frequencies, without water and with, against independent finite elements, and the error that is reported."""
    M = load("modes")
    for what, mesh_, young, level, dry, wet in (
            ("triangle", BODIES.triangle(16), 30e9, 100, (4.9159, 11.1635, 12.9404), (3.5386, 8.1289, 12.6064)),
            ("battered dam", BODIES.battered(), 30e9, 100, (4.8175, 11.3653, 12.2616), (3.8744, 9.1494, 12.0504)),
            ("section G1", BODIES.section_g1(), 10e9, 33, (7.3908, 18.1025, 21.2733), (5.8220, 14.3611, 21.0673))):
        scene = M.swinging(young, level, {"dry": {"type": "modes", "count": 3}}, {"wet": {"type": "modes", "loads": ["hydro"], "count": 3}})
        full = case.run(mesh_, scene)
        for frequency, relative in ((100, 5e-3), (400, 1e-3)):
            reduced = case.run(mesh_, changed(scene, ("materials.dam.condensed", True), ("materials.dam.highest_frequency", frequency)))
            for stage, expected in (("dry", dry), ("wet", wet)):
                case.check(f"{what}, {stage}, modes to {frequency} Hz: three frequencies [Hz]", facts(reduced, stage)[0], expected, relative=relative)
                told(what, case, full, reduced, stage, frequency)


def on_ground(case):
    """VS13, condensed and not: a dam on rock that lets waves out, one body, hit from below; complex mode of the dam, from its decay."""
    t = np.arange(201) * 0.001
    pulse = "".join(f"{a:.6g}, {b:.17g}, 0\n" for a, b in zip(t, np.sin(np.pi * np.minimum(t / 0.1, 1))**2, strict=True))
    for rock, loads, expected in ((20e9, [], (5.4281, 0.0795)), (20e9, ["hydro"], (4.4724, 0.0834)), (60e9, [], (6.4075, 0.0362)), (60e9, ["hydro"], (5.2769, 0.0410))):
        scene = changed(BODIES.on_rock(rock, loads), ("supports.bottom.motion", "pulse.csv"), ("materials.dam.velocity", [0, 0]))
        for what, keys in (("whole mesh", []), ("modes to 100 Hz", [(f"materials.{g}.{k}", v) for g in ("rock", "dam") for k, v in (("condensed", True), ("highest_frequency", 100))])):
            folder = case.prepare(BODIES.dam_on_rock(), changed(scene, *keys))
            (folder / "pulse.csv").write_text(pulse)
            result = case.again(folder)
            time, u = BODIES.shake(result, "crest")
            late = time > 0.45
            mode = min(BODIES.poles(time[late], u[late, 0], 10, 0.02), key=lambda s: abs(BODIES.hertz(s) - expected[0]))
            case.check(f"dam on rock of {rock / 1e9:.0f} GPa, {'wet' if loads else 'dry'}, {what}: frequency [Hz]", abs(mode) / (2 * np.pi), expected[0], relative=2e-3)
            case.check("... damping ratio", -mode.real / abs(mode), expected[1], absolute=5e-4)
            energy = result.stage_summary("shake")["energy"]
            case.check("... energy balance over what went out", energy["balance"] / energy["radiated"], 0.0, absolute=1e-10)


def refusals(case):
    body = ROCK | {"condensed": True}
    for what, changes, words in (
            ("no highest frequency", [("materials.rock", body)], "highest_frequency is missing [Hz]: condensed, and stage shake is dynamic"),
            ("no density", [("materials.rock", body | {"highest_frequency": 40, "density": 0})], "expected a density > 0"),
            ("a velocity at the start", [("materials.dam", body | {"highest_frequency": 40, "velocity": [1, 0]})], "a condensed body starts at rest"),
            ("a whole group that moves", [*condensed(40, "rock"), ("supports", {"rock": {"fix": "xy", "motion": "quake.csv"}})], "holds the condensed group rock as a whole"),
            ("several betas in one body", [*condensed(40, "rock"), ("materials.lower", ROCK | {"condensed": True, "highest_frequency": 40, "beta": 1e-3})], "groups rock and lower are one condensed body and have beta 0 and 0.001 s"),
            ("no highest frequency for modes", [("materials.rock", body), ("supports.bottom", {"fix": "xy"}), ("stages", [{"swing": {"type": "modes"}}])], "highest_frequency is missing [Hz]: condensed, and stage swing is of type modes"),
            ("a vertex of a rigid body", [*condensed(40, "rock"), ("materials.lower", {"density": 2600, "rigid": True}), ("supports", {"lower": {"fix": "xy"}})], "with a rigid one")):
        mesh_ = mesh()
        if "materials.lower" in dict(changes):
            lower = mesh_.vertices[mesh_.blocks].mean(axis=1)[:, 1] < -4
            mesh_.group_names, mesh_.group_rigid = [*mesh_.group_names, "lower"], np.zeros(3, np.int32)
            mesh_.block_group = np.where(lower, 2, mesh_.block_group).astype(np.int32)
        result = shaken(case, mesh_, *changes)
        case.check(f"{what}: refused in one line", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])

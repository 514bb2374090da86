"""Water that flows in joints in time: a step of pressure under free blocks, a level that swings, joints that fill and run empty.

Blocks that stand side by side on a joint, each free to rise, make of it a line with diffusivity D = (T / rho g) / (a / K_w + 1 / k_n): the
stiffness of the joint stores 500 times what the water does. Joints of fixed aperture fill and drain with a sharp front by Darcy's law."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.linalg import eigh
from scipy.special import erfc

WHAT = "water in joints in time: diffusion with the joint's stiffness, periodic level, filling, draining, curtains"
SOURCE = "closed forms (erfc, travelling wave, sharp fronts); nonlinear: finite differences, dx 0.25 m, dt 0.02 s (W05, W08)"
BY = "closed forms by hand; independent finite differences of this project"

G, RHO, MU, K_W, K_N = 9.81, 1000.0, 1e-3, 2e9, 20e9
APERTURE, HEIGHT, DENSITY = 2e-4, 20.0, 2400.0
DIFFUSIVITY = APERTURE**3 / (12 * MU) / (APERTURE / K_W + 1 / K_N)
PLACES = np.array([2.0, 5.0, 10.0, 20.0])
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "ramp": 0, "history_every": 100000},
    "materials": {"rock": {"density": DENSITY, "rigid": True}, "block": {"density": DENSITY, "rigid": True}},
    "joints": {"default": {"k_n": 1e3, "k_s": 1e3, "law": "elastic"},
               "block+rock": {"k_n": K_N, "k_s": K_N, "law": "elastic", "aperture": APERTURE + DENSITY * G * HEIGHT / K_N,
                              "aperture_residual": 1e-5}},
    "supports": {"rock": {"fix": "xy"}},
    "flow": {"bulk_modulus": K_W},
}  # fmt: skip


LONG = ("fronts",)  # parts that the short form leaves out


def run(case):
    step_of_pressure(case)
    periodic(case)
    fronts(case)
    curtain_within_a_contact(case)
    dying_away(case)
    near_overturning(case)
    at_once(case)


def line(length, dx):
    """Rigid blocks side by side on a rigid base."""
    n = round(length / dx)
    parts = [renamed(rectangle(0, -2, length, 2, n, 1, group="rock", rigid=True))]
    for i in range(n):
        ends = {"near_end": "left"} if i == 0 else {"far_end": "right"} if i == n - 1 else {}
        parts.append(renamed(rectangle(i * dx, 0, dx, HEIGHT, group="block", rigid=True), ends))
    return join(parts)


def scene_of(stage, pressure=0.0, **head):
    """The joint is full at rest, then the transient stage."""
    return changed(SCENE, ("loads", {"weight": {"type": "self_weight"}, "rest": {"type": "head", "faces": "near_end", "level": 0},
                                     "head": {"type": "head", "faces": "near_end", "level": pressure / (RHO * G), **head}}),
                   ("stages", [{"own": {"loads": ["weight", "rest"]}}, {"rise": {"type": "transient", "loads": ["weight", "head"], **stage}}]))  # fmt: skip


def along(result, stage, rho_g=RHO * G):
    """Places [m] and pressures [Pa] along the joint, at the end of a stage or in a frame."""
    flow = result.stage(stage).flow
    order = np.argsort(flow.point[:, 0, 0])
    return flow.point[order, 0, 0], flow.pressure[order, 0]


def step_of_pressure(case):
    mesh = line(60, 0.5)
    for name, pressure, coupling, expected, off in (
            ("1 kPa, two way", 1e3, "two_way", None, 0.01), ("1 kPa, one way", 1e3, "one_way", None, 0.01),
            ("100 kPa, two way", 1e5, "two_way", [0.8682, 0.6763, 0.3992, 0.0877], 0.01)):
        scene = changed(scene_of({"duration": 5, "time_step": 0.05}, pressure), ("flow.coupling", coupling))
        results = [case.run(mesh, scene, ranks=n) for n in ((1, 2) if not case.short or pressure == 1e5 else (1,))]
        flow = results[0].stage_summary("rise")["flow"]
        found = np.interp(PLACES, *along(results[0], "rise")) / pressure
        case.check(f"step of {name}, 5 s: p / p0 at 2, 5, 10, 20 m", found,
                   erfc(PLACES / (2 * np.sqrt(DIFFUSIVITY * 5))) if expected is None else expected, absolute=off * 0.5)
        if pressure == 1e3:
            case.check("... water taken in [m2/s]", flow["taken"], 4.611e-7, relative=0.02)
        case.check("... volume over what was taken in", flow["volume_error"], 0.0, absolute=1e-6)
        case.check("... balance of nodes", flow["error"], 0.0, absolute=1e-8)
        if len(results) > 1:
            case.check("... checksum on two ranks", results[1].stage_summary("rise")["checksum"], results[0].stage_summary("rise")["checksum"])
    by_itself = case.run(mesh, scene_of({"duration": 5}, 1e3))
    found = np.interp(PLACES, *along(by_itself, "rise")) / 1e3
    case.check("... steps by themselves", found, erfc(PLACES / (2 * np.sqrt(DIFFUSIVITY * 5))), absolute=0.01)
    case.report("... how many", len(by_itself.stage_summary("rise")["steps"]), 100)
    folder = case.prepare(mesh, scene_of({"duration": 5, "time_step": 0.25}, 1e5))
    whole = case.again(folder).stage_summary("rise")["checksum"]
    case.again(folder, "-output", "kept", "-checkpoint_every", 500, "-checkpoint_keep", 99)
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    sums = {case.again(folder, "-restart", file).stage_summary("rise")["checksum"] for file in files[2 :: max(1, len(files) // 4)]}
    case.check("restarts within the transient: the same bits", sorted(sums), [whole])


def periodic(case):
    """After some periods the swing at x is exp(-x / d) of that at the mouth, x / d later in phase; d = sqrt(period D / pi)."""
    period, depth = 60.0, np.sqrt(60 * DIFFUSIVITY / np.pi)
    mesh = line(60 if case.short else 120, 1.0)  # the mean gets 30 m far
    t = np.arange(0, 241, 0.5)
    folder = case.prepare(mesh, scene_of({"duration": 240, "time_step": 0.5, "frames": 479}, 1e3, levels="levels.csv"))
    mean, swing = 2e3 / (RHO * G), 1e3 / (RHO * G)
    np.savetxt(folder / "levels.csv", np.column_stack([t, mean + swing * np.sin(2 * np.pi * t / period)]), delimiter=",")
    result = case.again(folder)
    frames = result.frames("rise")[360:]
    rows = np.array([np.interp(PLACES, *along(result, name)) for name in frames])
    time = np.array([361 + i for i in range(len(frames))]) * 0.5
    phase = 2 * np.pi * time / period
    base = np.column_stack([np.sin(phase), -np.cos(phase), np.ones_like(time), time])  # the mean still seeps in
    parts = np.linalg.lstsq(base, rows, rcond=None)[0]
    swings = (parts[0] + 1j * parts[1]) / 1e3
    case.check("level that swings with 60 s: amplitude at 2, 5, 10, 20 m", np.abs(swings), np.exp(-PLACES / depth), absolute=0.02)
    case.check("... lag [s]", np.angle(swings) * period / (2 * np.pi), PLACES / depth * period / (2 * np.pi), absolute=0.6)


def fixed_joint(upright, n, length=10.0):
    """A joint of fixed walls, n contacts long, upright or level."""
    if upright:
        sides = rectangle(-1, 0, 1, length, 1, n, group="rock", rigid=True), rectangle(0, 0, 1, length, 1, n, group="block", rigid=True)
        return join([renamed(sides[0], {"start": "bottom", "finish": "top"}), renamed(sides[1])])
    sides = rectangle(0, -1, length, 1, n, 1, group="rock", rigid=True), rectangle(0, 0, length, 1, n, 1, group="block", rigid=True)
    return join([renamed(sides[0], {"start": "left", "finish": "right"}), renamed(sides[1])])


def fixed_scene(aperture, stage, full=()):
    joint = {"k_n": K_N, "k_s": K_N, "law": "elastic", "aperture": aperture, "aperture_residual": aperture, "aperture_max": aperture}
    loads = {"weight": {"type": "self_weight"}, "ten": {"type": "head", "faces": "start", "level": 10},
             "air": {"type": "head", "faces": "start", "level": 0}, "top": {"type": "head", "faces": "finish", "level": 10.0001}}
    return changed(SCENE, ("joints", {"default": joint}), ("supports", {"rock": {"fix": "xy"}, "block": {"fix": "xy"}}), ("loads", loads),
                   ("stages", [*full, {"go": {"type": "transient", **stage}}]))  # fmt: skip


def volumes(case, mesh, scene, aperture):
    """Times [s] and lengths of the joint that are full [m], step by step."""
    stage = case.run(mesh, scene).stage_summary("go")
    return (np.array([[step["value"], step["flow"]["volume"] / aperture] for step in stage["steps"]]).T, stage["flow"])


def fronts(case):
    head, wide, narrow = 10.0, 2e-4, 1e-4
    K = RHO * G * wide**2 / (12 * MU)
    (t, h), flow = volumes(case, fixed_joint(True, 40), fixed_scene(wide, {"loads": ["weight", "ten"], "duration": 700, "time_step": 1}), wide)
    levels = np.array([2, 5, 8, 9.5])
    exact = (-levels - head * np.log(1 - levels / head)) / K
    case.check("upright joint filled from below: level at 7.1, 59, 248, 626 s [m]", np.interp(exact, t, h), levels, relative=0.02)
    case.check("... volume over what was taken in", flow["volume_error"], 0.0, absolute=1e-6)
    for n in (20, 80):
        (t, h), _ = volumes(case, fixed_joint(True, n), fixed_scene(wide, {"loads": ["weight", "ten"], "duration": 300, "time_step": 1}), wide)
        case.report(f"... with {n} contacts", np.interp(exact[:3], t, h), levels[:3])
    (t, x), _ = volumes(case, fixed_joint(False, 60, 15.0), fixed_scene(wide, {"loads": ["weight", "ten"], "duration": 300, "time_step": 0.5}), wide)
    case.check("level joint: front at 10, 60, 300 s [m]", np.interp([10, 60, 300], t, x), np.sqrt(2 * K * head * np.array([10, 60, 300])), relative=0.03)
    K = RHO * G * narrow**2 / (12 * MU)
    full = [{"full": {"loads": ["weight", "air", "top"]}}]
    (t, h), flow = volumes(case, fixed_joint(True, 40), fixed_scene(narrow, {"loads": ["weight", "air"], "duration": 1300, "time_step": 5}, full), narrow)
    times = np.array([200, 500, 900, 1100])
    case.check("full joint that runs empty: level at 200, 500, 900, 1100 s [m]", np.interp(times, t, h), head - K * times, absolute=0.02)
    case.check("... pressure at the end [Pa]", flow["joints"]["default"]["uplift"], 0.0, absolute=1e-6)
    case.check("... volume over what was taken in", flow["volume_error"], 0.0, absolute=1e-6)


def dam(places, height=46.0):
    """A rigid block on rigid rock, with nodes at these places of its base."""
    n = len(places) - 1
    parts = rectangle(0, -5, n, 5, n, 1, group="rock", rigid=True), rectangle(0, 0, n, height, n, 1, group="block", rigid=True)
    for part in parts:
        part.vertices[:, 0] = np.interp(part.vertices[:, 0], np.arange(n + 1), places)
    return join([parts[0], renamed(parts[1], {"upstream": "left", "downstream": "right"})])


def curtain_within_a_contact(case):
    """The base of a rigid block opens in a straight line, so its water does not hang on where contacts end: a curtain that ends within contacts,
    where the aperture jumps, has the flow of one that ends at nodes. The water sinks by 24 m in 2 h; after 3 steps, and at the end."""
    edges, coarse = (1.45, 3.05), np.linspace(0.0, 33.0, 12)
    fitted = np.unique(np.concatenate([coarse, edges]))
    joint = {"k_n": 5e9, "k_s": 5e9, "friction": 60, "aperture": 4e-4, "aperture_residual": 1e-5, "aperture_max": 2e-3}
    loads = {"weight": {"type": "self_weight"}, "pool": {"type": "reservoir", "faces": "upstream", "level": 44},
             "head": {"type": "head", "faces": "upstream", "level": 44}, "toe": {"type": "head", "faces": "downstream", "level": 0},
             "sinks": {"type": "reservoir", "faces": "upstream", "level": 44, "levels": "levels.csv"},
             "head_sinks": {"type": "head", "faces": "upstream", "level": 44, "levels": "levels.csv"},
             "curtain": {"type": "curtain", "from": [2.25, -1], "to": [2.25, 1], "width": 1.6, "factor": 0.25}}  # fmt: skip
    scene = changed(SCENE, ("joints", {"default": joint}), ("loads", loads), ("stages", [
        {"full": {"loads": ["weight", "pool", "head", "toe", "curtain"]}},
        {"sinks": {"type": "transient", "duration": 7200, "time_step": 480, "loads": ["weight", "sinks", "head_sinks", "toe", "curtain"]}}]))  # fmt: skip
    uplifts = []
    for places in (fitted, coarse):
        folder = case.prepare(dam(places), scene)
        np.savetxt(folder / "levels.csv", [[0, 44], [7200, 20]], delimiter=",")
        result = case.again(folder)
        steps = result.stage_summary("sinks")["steps"]
        uplifts.append([steps[i]["flow"]["joints"]["default"]["uplift"] for i in (2, -1)])
        case.check("curtain " + ("at nodes" if places is fitted else "within contacts") + ": volume over what was taken in",
                   result.stage_summary("sinks")["flow"]["volume_error"], 0.0, absolute=1e-6)  # fmt: skip
        case.check("... the run prints its balance", "of what moved" in result.stdout and "does not balance" not in result.stderr, True)
    case.check("... uplift as with the curtain at nodes [N]", uplifts[1], uplifts[0], relative=1e-5)


def dying_away(case):
    """A level that falls at once from 10 to 0.1 m at the mouth of a joint that is closed behind: the pressures of its 20 pieces, of which each node
    stores what half of its pieces hold, by eigenvectors. Steps by themselves, until a hundredth is left; results on the way have their times."""
    n, dx, before, after = 20, 1.0, 10.0, 0.1
    aperture = APERTURE + RHO * G * before / K_N  # as the stage finds it: one way
    rate = aperture**3 / (12 * MU) / (aperture / K_W + 1 / K_N) / dx**2  # [1/s] between two nodes, over what one stores
    matrix = rate * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    matrix[-1, -1] = rate
    store = np.ones(n)
    store[-1] = 0.5  # [-] of a whole node: the last one has one piece
    values, vectors = eigh(matrix, np.diag(store))
    weights = vectors.T @ (store * (before - after))
    tau = 1 / values[0]
    folder = case.prepare(line(n * dx, dx), changed(scene_of({"duration": 4.6 * tau, "frames": 4}), ("flow.coupling", "one_way"),
                          ("loads.rest.level", before), ("loads.head.level", after)))  # fmt: skip
    result = case.again(folder)
    steps = [step for step in result.stage_summary("rise")["steps"] if step["value"] > 0.05 * tau]
    t = np.array([step["value"] for step in steps])
    heads = after + vectors @ (np.exp(-np.outer(values, t)) * weights[:, None])  # (n, steps) without the mouth
    mean = (0.5 * after + heads[:-1].sum(axis=0) + 0.5 * heads[-1]) / n
    found = np.array([step["flow"]["joints"]["block+rock"]["uplift"] for step in steps]) / (RHO * G * n * dx)
    case.check("pressures that die away, steps by themselves: uplift of every step, within 1 %", found, mean, relative=0.01)
    case.check("... of the last one", found[-1], mean[-1], relative=0.002)
    case.report("... how many steps", len(result.stage_summary("rise")["steps"]), 200)
    frames = [result.stage(name) for name in [*result.frames("rise"), "rise"]]
    every = np.array([step["value"] for step in result.stage_summary("rise")["steps"]])
    due = [every[np.searchsorted(every, 4.6 * tau * k / 5 * (1 - 1e-9))] for k in range(1, 6)]
    case.check("... times of the results on the way and at the end [s]", [frame.time for frame in frames], due, relative=1e-9)
    case.again(folder, "-output", "kept", "-checkpoint_every", 3000, "-checkpoint_keep", 99)
    files = sorted((folder / "kept" / "checkpoints").iterdir())
    sums = {case.again(folder, "-restart", file).stage_summary("rise")["checksum"] for file in (files[len(files) // 2], files[len(files) // 2 + 1])}
    case.check("... restarts within a pair of steps, or between two: the same bits", sorted(sums), [result.stage_summary("rise")["checksum"]])


def near_overturning(case):
    """Blocks of 45 m near overturning, whose level changes at once. 18 m of base do not bear 40 m of water at rest: collapsed, whichever step finds no equilibrium.
    Without its 38 m of water a block of 17 m stands, on its own (resultant in the middle) and with the water at rest (none): what rounds with trapped water do is no collapse, reported."""
    joint = {"k_n": 2e9, "k_s": 2e9, "friction": 60, "aperture": 4e-4, "aperture_residual": 1e-5, "aperture_max": 2e-3}
    blocks = ((14.0, 25, 38.5, "collapsed", "has parted from macroblock"), (18.0, 30, 40, "collapsed", "with the water at rest at its levels blocks fall"),
              (17.0, 38, 0, "undecided", "blocks stand without water in joints"), (18.0, 38, 20, "undecided", "blocks stand without water in joints"))  # fmt: skip
    for base, before, after, verdict, words in case.some(blocks, 2):  # in the short form one of each verdict
        loads = {"weight": {"type": "self_weight"}, "toe": {"type": "head", "faces": "downstream", "level": 0},
                 "curtain": {"type": "curtain", "from": [2.25, -1], "to": [2.25, 1], "width": 1.6, "factor": 0.25}}  # fmt: skip
        for when, level in (("before", before), ("after", after)):
            loads |= {f"pool_{when}": {"type": "reservoir", "faces": "upstream", "level": level}, f"head_{when}": {"type": "head", "faces": "upstream", "level": level}}
        stages = {when: ["weight", "toe", "curtain", f"pool_{when}", f"head_{when}"] for when in ("before", "after")}
        scene = changed(SCENE, ("relaxation", {"tolerance": 1e-7, "history_every": 100000}), ("joints", {"default": joint}), ("loads", loads), ("stages", [
            {"before": {"loads": stages["before"]}}, {"flows": {"type": "transient", "duration": 7200, "loads": stages["after"]}}]))  # fmt: skip
        found = [case.run(dam(np.linspace(0.0, base, 12), 45.0), scene, ranks=ranks).stage_summary("flows") for ranks in (1, 2)]
        case.check(f"base of {base:g} m, level from {before} to {after} m at once: verdict on 1 and 2 ranks", [one["verdict"] for one in found], [verdict] * 2)
        case.check(f"... it says: {words}", words in found[0]["evidence"], True)
        case.check("... the same bits", found[1]["checksum"], found[0]["checksum"])


def at_once(case):
    """Water that comes or goes at once under a block that stands near its limit. When it has come, uplift is that of steady flow at the new level;
    while it goes, a step that finds no equilibrium is tried again in a quarter of its length. Before, both blocks were thrown away."""
    joint = {"k_n": 2e9, "k_s": 2e9, "friction": 60, "aperture": 4e-4, "aperture_residual": 1e-5, "aperture_max": 2e-3}
    curtain = {"type": "curtain", "from": [2.25, -1], "to": [2.25, 1], "width": 1.6, "factor": 0.25}
    for before, after in ((30, 40), (40, 0)):
        loads = {"weight": {"type": "self_weight"}, "toe": {"type": "head", "faces": "downstream", "level": 0}, "curtain": curtain}
        for when, level in (("before", before), ("after", after)):
            loads |= {f"pool_{when}": {"type": "reservoir", "faces": "upstream", "level": level}, f"head_{when}": {"type": "head", "faces": "upstream", "level": level}}
        stages = {when: {"loads": ["weight", "toe", "curtain", f"pool_{when}", f"head_{when}"]} for when in ("before", "after")}
        scene = changed(SCENE, ("relaxation", {"tolerance": 1e-7, "history_every": 100000}), ("joints", {"default": joint}), ("loads", loads), ("stages", [
            {"before": stages["before"]}, {"flows": {"type": "transient", "duration": 7200, **stages["after"]}}, {"after": stages["after"]}]))  # fmt: skip
        folder = case.prepare(dam(np.linspace(0.0, 28.0, 12), 45.0), scene)
        result = case.again(folder)
        flows = result.stage_summary("flows")
        case.check(f"level from {before} to {after} m at once: verdict", flows["verdict"], "converged")
        case.check("... volume over what was taken in", flows["flow"]["volume_error"], 0.0, absolute=1e-6)
        if after > before:
            steady = result.stage_summary("after")["flow"]["joints"]["default"]["uplift"]
            case.check("... uplift after 2 h as in steady flow [N]", flows["flow"]["joints"]["default"]["uplift"], steady, relative=1e-3)
            continue
        case.check("... steps are tried again", result.stdout.count("again, ") > 0, True)
        case.again(folder, "-output", "kept", "-checkpoint_every", 20000, "-checkpoint_keep", 99)
        files = sorted((folder / "kept" / "checkpoints").iterdir())
        case.check("... a restart behind its first steps: the same bits", case.again(folder, "-restart", files[1]).stage_summary("flows")["checksum"], flows["checksum"])

"""Water that keeps its volume in joints while blocks move: a block on a full joint, and a dam on jointed rock that is shaken.

The water of a joint of aperture a is a spring K_w / a beside the joint's k_n, as long as it presses at all."""

import shutil

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, rectangle, renamed
from scipy.integrate import quad

WHAT = "undrained water in joints in dynamic stages: load step, frequency, joints that open and close, energy, ranks, restarts"
SOURCE = "closed forms: p / sigma = (K_w/a) / (K_w/a + k_n) (W05), omega^2 = (k_n + K_w/a) L / m, period of a spring of two stiffnesses"

G, RHO, K_W, K_N, APERTURE, LEVEL = 9.81, 2400.0, 2e9, 20e9, 2e-4, 5.0
P_0 = 1000 * G * LEVEL
REST = (P_0 - RHO * G) / K_N  # opening at rest under weight and water
WATER = ["weight", "left", "right"]
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-12, "velocity_tolerance": 1e-12, "ramp": 0, "history_every": 1},
    "materials": {"rock": {"density": RHO, "rigid": True}, "block": {"density": RHO, "rigid": True}},
    "joints": {"default": {"k_n": K_N, "k_s": K_N, "law": "elastic", "aperture": APERTURE - REST, "aperture_residual": 1e-5}},
    "supports": {"rock": {"fix": "xy"}},
    "flow": {"bulk_modulus": K_W, "dynamic": "undrained"},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "left": {"type": "head", "faces": "left", "level": LEVEL},
              "right": {"type": "head", "faces": "right", "level": LEVEL}, "press": {"type": "traction", "faces": "top", "value": [0, -1e6]}},
    "stages": [{"rest": {"loads": WATER}}, {"move": {"type": "dynamic", "loads": [*WATER, "press"], "duration": 8e-4, "alpha": 9e4}}],
}  # fmt: skip
MOVE = SCENE["stages"][1]["move"]


def run(case):
    load_step(case)
    frequency(case)
    opens_and_closes(case)
    residual(case)
    eccentric(case)
    dam(case)


def mesh(below=1, above=1):
    """A block of a cubic metre on a base; their faces match or not."""
    return join([renamed(rectangle(0, -1, 1, 1, below, 1, group="rock", rigid=True)),
                 renamed(rectangle(0, 0, 1, 1, above, 1, group="block", rigid=True), {"left": "left", "right": "right", "top": "top"},
                         {"corner": "top_left"})])


def with_stages(*stages, **changes):
    return changed(SCENE, ("stages", [{f"s{i}" if i else "rest": stage} for i, stage in enumerate(stages)]), *changes.items())


def move(loads=(), **keys):
    return MOVE | {"loads": [*WATER, *loads]} | keys


def history(result, stage):
    mine = (result.history["stage"] == stage) & np.isfinite(result.history["balance_J"])
    return {name: column[mine] for name, column in result.history.items() if name != "stage"}


def load_step(case):
    stiff = K_W / APERTURE
    for strain in ("small", "large"):
        result = case.run(mesh(), changed(SCENE, ("strain", strain)))
        rest, end = result.stage("rest"), result.stage("move")
        case.check(f"load on a full joint, {strain} strain: pressure over load", (end.flow.pressure - P_0) / 1e6, stiff / (stiff + K_N), relative=1e-9)
        case.check("... effective stress over load", (rest.contacts.sigma - end.contacts.sigma) / 1e6, K_N / (stiff + K_N), relative=1e-6)
        case.check("... uplift [N]", result.stage_summary("move")["flow"]["joints"]["default"]["uplift"], P_0 + 1e6 * stiff / (stiff + K_N), relative=1e-9)
    flow = result.stage_summary("move")["flow"]
    case.check("... state in the summary", flow["state"], "undrained")
    case.check("... nothing is discharged [m2/s]", [c["discharge"] for c in flow["conditions"].values()], 0.0, absolute=0.0)
    case.check("... a line says so", "water in joints keeps the volume of the stage before: undrained" in result.stdout, True)
    frozen = case.run(mesh(), changed(SCENE, ("flow.dynamic", "frozen"), ("stages", [SCENE["stages"][0], {"move": move(["press"], duration=8e-3)}])))
    case.check("frozen: pressures over those of the stage before", frozen.stage("move").flow.pressure / frozen.stage("rest").flow.pressure, 1.0, absolute=0.0)
    steps = [r.stage_summary("move")["cycles"] / t for r, t in ((result, 8e-4), (frozen, 8e-3))]
    case.check("... steps of undrained over those of frozen, no more than sqrt(1 + K_w / (a k_n))", bool(5 < steps[0] / steps[1] <= 22.4), True)
    after = case.run(mesh(), with_stages(SCENE["stages"][0]["rest"], move(["press"]), {"loads": [*WATER, "press"]}))
    case.check("a static stage after it: pressures of the flow over those at rest", after.stage("s2").flow.pressure / P_0, 1.0, relative=1e-9)
    for tolerance, share in ((1e-7, 0.0), (1e-3, stiff / (stiff + K_N))):
        scene = changed(SCENE, ("contact", {"connectivity": "variable", "tolerance": tolerance}), ("strain", "large"))
        case.check(f"variable connectivity, the joint {'wider' if share == 0 else 'narrower'} than the tolerance: pressure over load",
                   (case.run(mesh(2, 3), scene).stage("move").flow.pressure - P_0) / 1e6, share, absolute=1e-9)
    once = case.run(mesh(), with_stages(SCENE["stages"][0]["rest"], move(["press"], duration=6e-4, alpha=0)))
    twice = case.run(mesh(), with_stages(SCENE["stages"][0]["rest"], *2 * [move(["press"], duration=3e-4, alpha=0)]))
    case.check("two stages in time over one", twice.stage("s2").flow.pressure / once.stage("s1").flow.pressure, 1.0, relative=1e-9)


def crossings(t, y):
    """Times at which y goes up through its mean extreme."""
    y = y - 0.5 * (y.max() + y.min())
    at = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    return t[at] - y[at] * (t[at + 1] - t[at]) / (y[at + 1] - y[at])


def frequency(case):
    """A small load lets go: the kinetic energy has twice the frequency."""
    omega = np.sqrt((K_N + K_W / APERTURE) / RHO)
    errors = []
    for part in (0.1, 0.05):
        scene = with_stages(SCENE["stages"][0]["rest"], move(["press"], duration=4e-3, dt_factor=part, alpha=0), **{"loads.press.value": [0, -1e4]})
        h = history(case.run(mesh(), scene), "s1")
        times = crossings(h["time_s"], h["kinetic_J"])
        errors.append(np.pi * (len(times) - 1) / (times[-1] - times[0]) / omega - 1)
    case.check("frequency of a block on a full joint, at 0.05 of the bound", errors[1], 0.0, absolute=1e-4)
    case.check("... order in the time step", np.log2(errors[0] / errors[1]), 2.0, absolute=0.05)
    case.check("... energy balance over the kinetic energy", h["balance_J"] / h["kinetic_J"].max(), 0.0, absolute=1e-8)


def opens_and_closes(case):
    """Pulled by more than the water presses, the block swings over the opening where the water is empty: k_n alone, then both."""
    pull = 6e4
    empty = P_0 * APERTURE / K_W
    def potential(w):  # of what remains beyond rest, where all is in balance
        y = min(w, empty)
        return 0.5 * K_N * w**2 + 0.5 * K_W / APERTURE * y**2 + P_0 * max(0.0, w - empty) - pull * w
    top = 2 * (pull - P_0) / K_N + 2 * empty
    for _ in range(60):  # where the block turns
        top -= potential(top) / (K_N * top + min(P_0, K_W / APERTURE * top) - pull)
    slow = lambda s: top * np.sin(2 * s) / np.sqrt(max(1e-300, -2 * potential(top * np.sin(s) ** 2) / RHO))  # noqa: E731
    period = 2 * quad(slow, 1e-9, np.pi / 2 - 1e-9, points=[np.arcsin(np.sqrt(empty / top))], limit=400)[0]
    for strain in ("small", "large"):
        scene = with_stages(SCENE["stages"][0]["rest"], move(["press"], duration=50 * period, alpha=0),
                            **{"loads.press.value": [0, pull], "strain": strain, "relaxation.history_every": 4})
        h = history(case.run(mesh(), scene), "s1")
        times = crossings(h["time_s"], h["joints_J"])
        case.check(f"joint that runs empty and fills again, {strain} strain: period [s]", np.diff(times), period, relative=1e-4)
        case.check("... periods", len(times), 50)
        case.check("... energy balance over the kinetic energy", h["balance_J"] / h["kinetic_J"].max(), 0.0, absolute=5e-5)
    scene = changed(scene, ("relaxation.history_every", 100), ("stages", [scene["stages"][0], {"s1": move(["press"], duration=200 * period, alpha=0)}]))
    h = history(case.run(mesh(2, 3), scene), "s1")
    case.check("... on faces that do not match it begins to rock: energy balance", h["balance_J"] / h["kinetic_J"].max(), 0.0, absolute=1e-3)
    thrown = with_stages(SCENE["stages"][0]["rest"], move(duration=0.3, dt_factor=0.1, alpha=0), **{
        "materials.block.velocity": [0.0, 0.1], "relaxation.history_every": 100, "strain": "large",
        "loads.left.level": 1, "loads.right.level": 1, "joints.default": SCENE["joints"]["default"] | {"law": "mohr_coulomb", "friction": 40, "cohesion": 0, "tension": 0}})
    h = history(case.run(mesh(2, 3), thrown), "s1")
    case.check("block thrown up, that lands on its water: energy balance over its kinetic energy", h["balance_J"] / (0.5 * RHO * 0.1**2), 0.0, absolute=0.01)


def residual(case):
    """A joint at its residual aperture squeezes no more water; in a soft one the pressure stops at K_w (1 - a_r / a)."""
    soft, least = 1e7, 0.95 * APERTURE
    scene = changed(SCENE, ("flow.bulk_modulus", soft), ("joints.default.aperture_residual", least),
                    ("stages", [SCENE["stages"][0], {"move": move(["press"], duration=0.02, alpha=4000)}]))
    pressure = P_0 + soft * (1 - least / APERTURE)
    result = case.run(mesh(), scene)
    closed = (1e6 - (pressure - P_0)) / K_N
    case.check("joint that closes to its residual aperture: pressure", result.stage("move").flow.pressure, pressure, relative=1e-9)
    case.check("... closure since [m]", result.stage("rest").contacts.opening - result.stage("move").contacts.opening, closed, relative=1e-4)


def eccentric(case):
    """Faces that do not match, a load at a corner: pressures along a straight line."""
    level, load = 30.0, 1e5
    row = SCENE["joints"]["default"] | {"k_n": 1e7, "k_s": 1e5, "aperture": APERTURE}
    scene = changed(SCENE, ("joints.default", row), ("loads.left.level", level), ("loads.right.level", level),
                    ("loads.press", {"type": "point_force", "point": "corner", "value": [0, -load]}),
                    ("loads.hold", {"type": "traction", "faces": "top", "value": [0, RHO * G - 1000 * G * level]}),
                    ("stages", [{"rest": {"loads": [*WATER, "hold"]}}, {"move": move(["hold", "press"])}]))
    for strain in ("small", "large"):
        result = case.run(mesh(3, 2), changed(scene, ("strain", strain)))
        flow = result.stage("move").flow
        case.check(f"load at a corner, faces that do not match, {strain} strain: pressures", flow.pressure,
                   1000 * G * level + load * (1 - 6 * (flow.point[..., 0] - 0.5)), relative=1e-5)


def dam_mesh():
    parts = []
    def part(x, y, width, height, n, group, rigid, faces=(), points=()):
        parts.append(renamed(rectangle(x, y, width, height, *n, group=group, rigid=rigid), dict(faces), dict(points)))
    part(-3, -4, 20, 1, (4, 1), "bed", True)
    ends = [-3, 1.1, 5.3, 9.2, 13.1, 17]
    for i, (a, b) in enumerate(zip(ends, ends[1:])):
        part(a, -3, b - a, 3, (3, 2), "rock", False, {0: {"ground": "top", "sides": "left"}, 4: {"sides": "right"}}.get(i, {}))
    for j, end in enumerate((10.1, 9.0, 7.5, 6.0)):
        middle = 1.1 + (end - 1.1) * (0.45 if j % 2 else 0.6)
        part(1.1, 3.0 * j, middle - 1.1, 3, (2, 2), "dam", False, {"up": "left"}, {"crest": "top_left"} if j == 3 else {})
        part(middle, 3.0 * j, end - middle, 3, (2, 2), "dam", False, {"down": "right"})
    return join(parts)


def dam_scene(connectivity, k_n=5e9, level=7.0):
    row = {"k_n": k_n, "k_s": 0.4 * k_n, "friction": 38, "aperture": 3e-4, "aperture_residual": 3e-5, "stress_model": "tptm"}
    shaken = {"motion": "shake.csv", "quantity": "velocity"}
    loads = ["weight", "water", "on_rock", "up", "down"]
    return {
        "relaxation": {"tolerance": 1e-7, "velocity_tolerance": 1e-6, "history_every": 100, "method": "explicit"},
        "contact": {"connectivity": connectivity},
        "materials": {"bed": {"density": 2600, "rigid": True}, "rock": {"density": 2600, "young": 3e10, "poisson": 0.2},
                      "dam": {"density": 2400, "young": 1e10, "poisson": 0.2}},
        "joints": {"default": row}, "supports": {"bed": {"fix": "xy"} | shaken, "sides": {"fix": "x"} | shaken},
        "flow": {"dynamic": "undrained"},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "up", "level": level},
                  "on_rock": {"type": "reservoir", "faces": "ground", "level": level},
                  "up": {"type": "head", "faces": "up", "level": level}, "down": {"type": "head", "faces": "down", "level": 0}},
        "stages": [{"own": {"loads": ["weight"]}}, {"full": {"loads": loads}},
                   {"quake": {"type": "dynamic", "loads": loads, "duration": 0.03, "dt_factor": 0.5, "alpha": 2, "frames": 4}}, {"after": {"loads": loads}}],
    }  # fmt: skip


def short_steps(case, motion, connectivity):
    """What is out of balance is the error of the step: joints that slip, open and hit make it some 1e-3, either way, at half the bound."""
    scene = dam_scene(connectivity)
    scene["stages"][2]["quake"]["dt_factor"] = 0.1
    folder = case.prepare(dam_mesh(), scene)
    shutil.copy(motion, folder)
    energy = case.again(folder).stage_summary("quake")["energy"]
    case.check(f"dam shaken, {connectivity} connectivity: energy balance, at a tenth of the bound", energy["balance"] / energy["supports"], 0.0, absolute=3e-4)


def dam(case):
    """Jointed rock and a dam of two blocks a course, dry above the reservoir, whose joints open, slip and hit as they are shaken."""
    t = np.linspace(0, 0.06, 241)
    for connectivity in ("fixed", "variable"):
        folder = case.prepare(dam_mesh(), dam_scene(connectivity))
        np.savetxt(folder / "shake.csv", np.column_stack([t, 0.8 * np.sin(2 * np.pi * t / 0.03) * (t < 0.03), 0 * t]), delimiter=",")
        results = [case.again(folder, ranks=n) for n in case.ranks(*((1, 2, 3, 4) if connectivity == "variable" else (1, 2)))]
        sums = [[stage["checksum"] for stage in result.summary["stages"]] for result in results]
        result, before, after = results[0], results[0].stage("full").flow, results[0].stage("quake").flow
        energy = result.stage_summary("quake")["energy"]
        if connectivity == "fixed":
            case.check("dam shaken, fixed connectivity: energy balance over the work of the supports", energy["balance"] / energy["supports"], 0.0, absolute=5e-3)
        short_steps(case, folder / "shake.csv", connectivity)
        case.check("... joints that run empty", bool(((before.pressure > 0) & (after.pressure == 0)).sum() > 10), True)
        case.check("... dry joints are dry", after.pressure[(before.saturation.max(axis=1) == 0)], 0.0, absolute=0.0)
        case.check("... checksums on 1 and more ranks", {tuple(s) for s in sums} == {tuple(sums[0])}, True)
        case.check("... pressures in results.h5 on more ranks", results[-1].stage("quake").flow.pressure, after.pressure, absolute=0.0)
        case.check("... the static stage after it", result.stage_summary("after")["flow"]["state"], "steady")
        case.again(folder, "-output", "kept", "-checkpoint_every", 900, "-checkpoint_keep", 99)
        files = sorted((folder / "kept" / "checkpoints").iterdir())
        ends = [[s["checksum"] for s in case.again(folder, "-restart", file, ranks=1 + i % 2).summary["stages"]] for i, file in enumerate(files[1:6:2])]
        case.check("... restarts within the stage on 1, 2, 1 ranks: the same bits", [end == sums[0] for end in ends], [True] * 3)

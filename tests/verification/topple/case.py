"""A block on a slope stays, slides or topples (V13); a block rocks."""

import numpy as np
from driver import changed
from quoin_tools.base.results import VERTEX_FACE
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane

WHAT = "a block on a slope stays, slides or topples (V13); a rocking block comes down as Housner's"
SOURCE = "slides when phi < slope, topples when width / height < tan(slope); Housner: theta'' = -p^2 sin(alpha - theta), p^2 = 3 g / 4 R"
BY = "by hand; Housner; the verdicts of 3DEC's handbook"

G, RHO = 10.0, 2000.0
SCENE = {
    "gravity": G,
    "contact": {"connectivity": "variable", "tolerance": 0.05},
    "relaxation": {"ramp": 2000},
    "materials": {"block": {"density": RHO}, "base": {"density": RHO}},
    "joints": {"default": {"k_n": 10e6, "k_s": 10e6, "friction": 45}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


LONG = ("corner_with_dashpot",)  # parts that the short form leaves out


def run(case):
    slope_of_blocks(case)
    rocking(case)
    corner_with_dashpot(case)
    for least in case.some((0.005, 0.05)):  # shorter than N / sigma, and longer
        from_face_to_vertex(case, least)


def from_face_to_vertex(case, least):
    """A block tips over its corner: at 20 degrees its face contact becomes a vertex with its diagram, force and energy."""
    k_n = 1e8
    mesh = join([renamed(rectangle(-4, -1, 8, 1, group="base", rigid=True), {}),
                 renamed(rectangle(0, 0, 1, 2, group="block", rigid=True), {}, {"mark": "bottom_right"})])
    scene = changed(SCENE, ("gravity", 9.81), ("contact", {"connectivity": "variable", "vertex_length": least}), ("relaxation", {"history_every": 1}),
                    ("materials.block", {"density": 2400, "spin": -5.0}),
                    ("joints.default", {"k_n": k_n, "k_s": k_n, "friction": 60, "damping": 2e-2}),
                    ("stages", [{"rest": {"loads": ["weight"]}},
                                {"tip": {"type": "dynamic", "loads": ["weight"], "duration": 0.4, "dt_factor": 0.02, "frames": 1200}}]))
    result = case.run(mesh, scene)
    frames = [result.stage(name) for name in result.frames("tip")]
    at = next(i for i, frame in enumerate(frames) if frame.contacts.klass.tolist() == [VERTEX_FACE])
    before, after = frames[at - 1].contacts, frames[at].contacts
    delta, force = -before.opening.min(), -before.force[:, :, 0].sum()
    case.check(f"vertex_length {least:g}: becomes a vertex at [degree]", np.degrees(np.nanmin(frames[at].rotation)), -20.0, absolute=0.05)
    stays = after.force[:, :, 0].sum() / after.opening.min()**2 * (delta**2 / force)
    case.check("... N / delta^2 after the change over that before", -stays, 1.0, relative=0.002)
    case.check("... length N / sigma [m]", after.length[0], after.force[:, :, 0].sum() / after.sigma.min(), relative=1e-9)
    time, detection = (np.nan_to_num(result.history[name]) for name in ("time_s", "detection_J"))
    near = (time >= frames[at - 1].time - 1e-9) & (time <= frames[at].time + 1e-9)
    made = np.ptp(detection[near])
    case.check("... made by the change, over the N delta / 3 that are stored", made / (force * delta / 3), 0.0, absolute=1e-3)


def on_slope(height, slope, phi, joint):
    """4 s in time; at rest under its weight before, with much friction, unless it topples anyway."""
    mesh = block_on_plane(10.0, height, slope, plane_length=60.0, start=5.0)
    rest = [{"rest": {"loads": ["weight"], "joints": {"default": {"friction": 60}}}}] if height < 20 else []
    stages = rest + [{"go": {"type": "dynamic", "loads": ["weight"], "duration": 4.0, "dt_factor": 0.02, "alpha": 0.5,
                             "joints": {"default": {"friction": phi}}}}]
    return mesh, changed(SCENE, ("stages", stages), ("joints.default", SCENE["joints"]["default"] | joint))


def slope_of_blocks(case):
    """Width 10 m, k = 10 MPa/m with forces at the corners (pt), as in the handbook of 3DEC; tptm with stiff joints.

    On a joint of 10 MPa/m without tension the first block has no equilibrium: closed over 2.4 m it leans by 3 degrees, which
    moves its weight out by more than the joint can follow. The third slope is such that width / height < its tangent."""
    cases = [("height 10, slope 40, phi 40.1: stays", 10.0, 40.0, 40.1), ("height 5, slope 40, phi 20: slides", 5.0, 40.0, 20.0),
             ("height 25, slope 30, phi 40: topples", 25.0, 30.0, 40.0)]
    joints = {"pt": {"stress_model": "pt"}, "tptm, 1 GPa/m": {"k_n": 1e9, "k_s": 1e9}}
    for name, joint in joints.items():
        slope_of(case, name, cases, case.run_all([on_slope(*values, joint) for _, *values in cases]))


def slope_of(case, name, cases, results):
    for (what, _height, slope, _phi), result in zip(cases, results):
        down = np.array([np.cos(np.radians(slope)), -np.sin(np.radians(slope))])
        moved = np.array([result.probe("go", c) @ down for c in ("bottom_left", "bottom_right", "top_left", "top_right")])
        turned = np.degrees(np.nanmin(result.stage("go").rotation))
        did = "topples" if turned < -15 else "slides" if moved[:2].min() > 1 else "stays"
        case.check(f"{name}: {what}", did, what.split()[-1])
        if did == "stays":
            case.check("... turned [degree], moved down the slope at its base [m]", [turned, moved[:2].mean()], 0.0, absolute=1.0)


def rocking(case):
    """Let go from a lean of a third of its slenderness: free rotation about the corner until it comes upright. pt, whose force
    stands at the corner; that of tptm moves inwards as the joint closes."""
    width, height, part = 0.5, 2.0, 1 / 3
    alpha, R = np.arctan(width / height), np.hypot(width, height) / 2
    lean = part * alpha
    block = rectangle(0, 0, width, height, group="block", rigid=True)
    c, s = np.cos(lean), np.sin(lean)
    block.vertices = (block.vertices - [width, 0]) @ np.array([[c, -s], [s, c]]) + [width, 0]
    mesh = join([renamed(rectangle(-2, -1, 4.5, 1, group="base", rigid=True), {}), renamed(block, {}, {"top": "top_left"})])
    p = np.sqrt(3 * G / (4 * R))
    quarter = np.arccosh(1 / (1 - part)) / p
    stages = [{"rock": {"type": "dynamic", "loads": ["weight"], "duration": 0.98 * quarter, "dt_factor": 0.02}}]
    scene = changed(SCENE, ("stages", stages), ("joints.default", {"k_n": 1e10, "k_s": 1e10, "friction": 60, "stress_model": "pt"}),
                    ("contact.tolerance", 0.002), ("relaxation.allow_floating", True))
    result = case.run(mesh, scene)
    t = 0.98 * quarter
    # theta'' = -p^2 sin(alpha - theta), which for a slender block is theta = alpha - (alpha - theta_0) cosh(p t)
    theta, rate, n = lean, 0.0, 20000
    for _ in range(n):
        rate -= p**2 * np.sin(alpha - theta) * t / n
        theta += rate * t / n
    case.check("rocking: angle just before it is upright [rad]", lean - np.nanmax(result.stage("rock").rotation), theta, absolute=0.005 * lean)
    case.check("... energy balance over the work of the weight", result.stage_summary("rock")["energy"]["balance"]
               / result.stage_summary("rock")["energy"]["outside"], 0.0, absolute=1e-3)


def corner_with_dashpot(case):
    """A block of 1 by 4 m let go from a lean of a third comes down about its corner. What that needs of friction, T / N by Housner's
    rotation, is less than there is, so the corner stays where it is, however strong the dashpot of its joint. tptm."""
    b, h, g, lean = 1.0, 4.0, 9.81, 0.08
    alpha, R = np.arctan(b / h), np.hypot(b, h) / 2
    p, theta, rate, needed, n = np.sqrt(3 * g / (4 * R)), lean, 0.0, 0.0, 20000
    t = 0.95 * np.arccosh(alpha / (alpha - lean)) / p
    for _ in range(n):
        turn = -(p**2) * np.sin(alpha - theta)
        rate, at = rate + turn * t / n, alpha - theta  # the centre is at R (-sin at, cos at) from the corner
        across, up = turn * np.cos(at) + rate**2 * np.sin(at), turn * np.sin(at) - rate**2 * np.cos(at)
        needed, theta = max(needed, abs(R * across / (g + R * up))), theta + rate * t / n
    case.check("corner with a dashpot: T / N that rocking needs is below tan(45 degrees)", bool(needed < 0.95), True)
    block = rectangle(0, 0, b, h, group="block", rigid=True)
    c, s = np.cos(lean), np.sin(lean)
    block.vertices = (block.vertices - [b, 0]) @ np.array([[c, -s], [s, c]]) + [b, 0]
    mesh = join([renamed(rectangle(-3, -1, 8, 1, group="base", rigid=True), {}), renamed(block, {}, {"pivot": "bottom_right"})])
    stages = [{"rock": {"type": "dynamic", "loads": ["weight"], "duration": t, "frames": 40}}]
    for damping in (1e-2, 3e-2):
        scene = changed(SCENE, ("gravity", g), ("contact.tolerance", 0.005), ("materials.block.density", 2400), ("stages", stages),
                        ("joints.default", {"k_n": 1e9, "k_s": 1e9, "friction": 45, "damping": damping}), ("relaxation.allow_floating", True))
        result = case.run(mesh, scene)
        slid = [result.stage(frame).displacement[mesh.points["pivot"], 0] for frame in [*result.frames("rock"), "rock"]]
        case.check(f"... damping {damping:g} s: the corner slides by [mm]", 1e3 * np.abs(slid).max(), 0.0, absolute=0.25)

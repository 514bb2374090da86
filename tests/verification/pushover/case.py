"""Pushover: force over a given displacement, past the peak and back, of blocks by hand, a bar and a wall."""

import models
import numpy as np
import yaml
from driver import PUBLISHED, changed, check_restarts
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "pushover: a block that tips, a slider that breaks, a bar and an elastic joint, a wall under a part of its weight"
SOURCE = "statics of the turned block; k_s L u up to the strength; mean displacement q L^2 / 3 E; limits of explicit runs of the wall (problems.yaml)"
BY = "by hand; explicit runs of this project"

G, RHO = 10.0, 2000.0
SCENE = {
    "gravity": G,
    "contact": {"connectivity": "variable"},
    "materials": {"block": {"density": RHO}, "base": {"density": 0}},
    "joints": {"default": {"k_n": 1e11, "k_s": 1e11, "friction": 45}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def run(case):
    tips(case)
    slides(case)
    breaks_on_the_way(case)
    deforms_and_slides(case)
    elastic(case)
    bar(case)
    vacuum(case)
    wall(case)
    refused(case)


def curve(result, stage="push"):
    found = result.stage_summary(stage)["pushover"]
    return np.array(found["displacement"]), np.array(found["force"]), found


def block(width, height, rigid=True):
    return join([renamed(rectangle(-4, -1, 9, 1, group="base", rigid=True)),
                 renamed(rectangle(0, 0, width, height, group="block", rigid=rigid), {}, {"top": "top_left", "foot": "bottom_left"})])


def force_of_tilt(u, b, h, weight):
    """Force at the upper left corner that holds the block, turned about its right foot so that the corner has moved by u."""
    turn = np.arctan2(b, h) + np.arcsin((u - b) / np.hypot(b, h))  # u = b - b cos + h sin
    return weight * (b / 2 * np.cos(turn) - h / 2 * np.sin(turn)) / (h * np.cos(turn) + b * np.sin(turn))


def tips(case):
    """1 m by 2 m, there, half way back and on until it would fall by itself: one curve, which ends at 0 where the centre is above the foot."""
    path, weight = [0.6, 0.2, 1.0, 1.2], 2 * RHO * G
    scene = changed(SCENE, ("stages", [{"rest": {"loads": ["weight"]}},
                                       {"push": {"type": "pushover", "loads": ["weight"], "point": "top", "path": path, "step": 0.2, "frames": 2}}]))
    result = case.run(block(1.0, 2.0), scene)
    u, force, found = curve(result)
    case.check("a block tips: equilibria", found["equilibrium"], [1.0] * len(u))
    case.check("... F over the weight, there and back", force[1:] / weight, force_of_tilt(u[1:], 1.0, 2.0, weight) / weight, absolute=0.001)
    case.check("... F where its centre is above its foot, over the largest", force[np.isclose(u, 1.0)] / force.max(), 0.0, absolute=0.001)
    back = [force[np.flatnonzero(np.isclose(u, at))] for at in (0.2, 0.4, 0.6)]
    case.check("... F on the way back and on again over that on the way there", [f[-1] / f[0] for f in back], np.ones(3), absolute=2e-4)
    history = result.history
    rows = np.isfinite(history["push_N"])
    case.check("... rows of history.csv", [history["push_m"][rows], history["top_ux_m"][rows] - history["top_ux_m"][rows][0]], [u, u], absolute=1e-7)
    case.check("... frames", len(result.frames("push")), 2)
    turned = changed(scene, ("stages.1.push", {"type": "pushover", "loads": ["weight"], "point": "top", "direction": [-2, 0], "path": [-0.2, -0.1], "step": 0.2}),
                     ("checkpoint", {"every": 3000, "keep": 1000}))
    folder = case.prepare(block(1.0, 2.0), turned)
    reversed_ = case.again(folder)
    case.check("... direction and path reversed: -F", -curve(reversed_)[1][1], force[1], relative=1e-5)
    check_restarts(case, folder, reversed_)


def slides(case):
    """1 m by 0.2 m, pushed at its foot: elastic, breaks, slips, unloads by k_s, reloads to what is left; then it slips the other way."""
    weight, k_s, cohesion, slope, residual = 0.2 * RHO * G, 1e8, 8e3, np.tan(np.radians(35)), np.tan(np.radians(25))
    peak, left = cohesion + weight * slope, weight * residual
    path = np.array([0.9 * peak / k_s, 1.5 * peak / k_s, 1.5 * peak / k_s - 0.5 * left / k_s, 3 * peak / k_s, 3 * peak / k_s - 3 * left / k_s])
    scene = changed(SCENE, ("contact.connectivity", "fixed"), ("strain", "small"),
                    ("joints.default", {"k_n": 1e11, "k_s": k_s, "friction": 35, "cohesion": cohesion, "friction_residual": 25}),
                    ("stages", [{"push": {"type": "pushover", "loads": ["weight"], "point": "foot", "path": path.tolist(), "step": 1.0}}]))
    _, force, _ = curve(case.run(block(1.0, 0.2), scene))
    case.check("a slider: F / k_s u, peak less, residual, unloaded, residual, reversed [N]", force[1:], [0.9 * peak, left, 0.5 * left, left, -left], relative=2e-4)


def breaks_on_the_way(case):
    """A slider whose points break near the end of a step, at 0.9 of it: the force overshoots by no local damping of this walk."""
    weight, k_s, cohesion, slope = 0.2 * RHO * G, 1e8, 8e3, np.tan(np.radians(35))
    path = (cohesion + weight * slope) / k_s * np.array([1.11, 5.0])
    scene = changed(SCENE, ("contact.connectivity", "fixed"), ("strain", "small"), ("relaxation", {"tolerance": 1e-10, "velocity_tolerance": 1e-10}),
                    ("joints.default", {"stress_model": "pt", "k_n": 1e9, "k_s": k_s, "friction": 35, "cohesion": cohesion, "tension": 5e3}),
                    ("stages", [{"rest": {"loads": ["weight"]}}, {"push": {"type": "pushover", "loads": ["weight"], "point": "foot", "path": path.tolist(), "step": 1.0}}]))
    result = case.run(block(1.0, 0.2), scene)
    case.check("a slider that breaks on the way of a step: the cycles make no energy", [result.verdict, "kinetic energy" in result.stderr], ["converged", False])
    case.check("... F further on [N]", curve(result)[1][-1], weight * slope, relative=1e-7)


def deforms_and_slides(case):
    """A block of 4 by 4 elastic blocks that slides: local damping can add its part of the force, and the masses must bear it."""
    mesh = join([renamed(rectangle(-1, -1, 4, 1, group="base", rigid=True)), renamed(rectangle(0, 0, 1, 0.5, 4, 4, group="block"))])
    mesh.points = {}
    scene = changed(SCENE, ("contact.connectivity", "fixed"), ("strain", "small"), ("materials.block", {"density": RHO, "young": 1e10, "poisson": 0.2}),
                    ("joints.default", {"stress_model": "pt", "k_n": 1e10, "k_s": 1e10, "friction": 30}),
                    ("stages", [{"rest": {"loads": ["weight"]}}, {"push": {"type": "pushover", "loads": ["weight"], "group": "block", "path": [5e-4], "step": 1e-4}}]))
    result = case.run(mesh, scene)
    case.check("an elastic block that slides: the cycles make no energy", [result.verdict, "kinetic energy" in result.stderr], ["converged", False])
    case.check("... F once it slides [N]", curve(result)[1][1:], 0.5 * RHO * G * np.tan(np.radians(30)), relative=1e-4)


def elastic(case):
    """A block on an elastic joint, its centroid pushed: F / u by the joint's shear and rotation."""
    b, h, k_n, k_s = 1.0, 0.8, 1e9, 4e8
    scene = changed(SCENE, ("contact.connectivity", "fixed"), ("strain", "small"), ("joints.default", {"k_n": k_n, "k_s": k_s, "law": "elastic"}),
                    ("relaxation", {"tolerance": 1e-8}),
                    ("stages", [{"push": {"type": "pushover", "loads": ["weight"], "body": "top", "path": [1e-3, 2e-3], "step": 1.0}}]))
    flexible = 1 / (k_s * b) + (h / 2) ** 2 / (k_n * b**3 / 12)
    u, force, _ = curve(case.run(block(b, h), scene))
    case.check("an elastic joint: F / u [N/m]", force[1:] / u[1:], 1 / flexible, relative=1e-5)


def bar(case):
    """A bar that stands, its group pushed upwards: the mean of its displacement is q L^2 / 3 E; in kN, mm by units of the scene."""
    n, length, young = 20, 5.0, 1e9
    mesh = rectangle(0, 0, 1, length, 1, n, "bar")
    mesh.face_sets = {"foot": mesh.face_sets["bottom"]}
    scene = {"strain": "small", "relaxation": {"tolerance": 1e-8}, "materials": {"bar": {"density": RHO, "young": young, "poisson": 0.0}},
             "joints": {"default": {"k_n": 1e11, "k_s": 1e11, "friction": 45}}, "supports": {"foot": {"fix": "xy"}}, "loads": {"weight": {"type": "self_weight"}},
             "stages": [{"pull": {"type": "pushover", "loads": ["weight"], "group": "bar", "direction": [0, 1], "path": ["1 mm"], "step": "1 mm"}}]}
    u, force, _ = curve(case.run(mesh, scene), "pull")
    case.check("a bar, its group moved: F over 3 E u / L", force[-1] / (3 * young * u[-1] / length), 1.0, relative=0.005)


def vacuum(case):
    """A block without weight and contact moves freely: no force."""
    mesh = join([renamed(rectangle(0, 0, 1, 1, group="base", rigid=True)), renamed(rectangle(5, 5, 1, 1, group="block", rigid=True), {}, {"top": "top_left"})])
    scene = changed(SCENE, ("relaxation", {"allow_floating": True, "max_cycles": 2000}), ("gravity", 0.0), ("stages", [{"push": {"type": "pushover", "loads": ["weight"], "body": "top", "path": [0.5], "step": 0.25}}]))
    result = case.run(mesh, scene)
    u, force, _ = curve(result)
    case.check("a free block: places, forces over the weight it would have", [u, force / (RHO * 10.0)], [[0, 0.25, 0.5], [0, 0, 0]], absolute=1e-7)
    case.check("... its displacement", result.probe("push", "top"), [0.5, 0.0], absolute=1e-6)


def wall(case):
    """Wall 1 of Ferris and Tin-Loi under a factor of its weight: the largest factor in small displacement is where explicit runs stand and fail."""
    scene = yaml.safe_load((PUBLISHED / "wall_1.yaml").read_text(encoding="utf-8"))
    scene = changed(scene, ("relaxation", {"tolerance": 1e-4, "ramp": 1000}), ("joints.default.k_n", 1e10), ("joints.default.k_s", 1e10),
                    ("stages", [scene["stages"][0], {"push": {"type": "pushover", "loads": ["weight"], "pushes": ["push"], "path": [0.004], "step": 0.002}}]))
    _, _, found = curve(case.run(models.MESHES["wall_1"](), scene))
    case.check("wall 1: largest factor in small displacement; runs stand at 0.62875 and fail at 0.63", found["peak_factor"], 0.6294, relative=0.01)


def refused(case):
    """What a support holds, and loads without a resultant, are refused before the first stage."""
    push = {"type": "pushover", "loads": ["weight"], "path": [0.1]}
    loads = {"left": {"type": "point_force", "point": "top", "value": [-1, 0]}, "right": {"type": "point_force", "point": "foot", "value": [1, 0]}}
    for keys, words in (({"group": "base"}, "stages.push.group: supports.base holds what is to be moved"), ({"point": "ground"}, "stages.push.point: supports.base holds"),
                        ({"pushes": ["left", "right"]}, "stages.push.pushes: these loads have no resultant")):
        mesh = block(1.0, 2.0)
        mesh.points["ground"] = 0
        done = case.run(mesh, changed(SCENE, ("loads", SCENE["loads"] | loads), ("stages", [{"push": push | keys}])))
        case.check(f"refused: {words}", (done.exit_code, words in done.stderr), (2, True))

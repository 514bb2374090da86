"""Does a trial stand or fail? Mechanisms whose limit statics gives exactly, tried a hair on either side of it.

Sliding on a plane, overturning, a single block between two others, a small block on a large one, a block that pushes a
wedge, the dam of section G1. Small strain: the limit is that of the reference shape. All of them by explicit cycles and by
Newton's method with creep. `driver.py --full` adds S1 on G1 with two meshes, three stress models and two paths."""

import math

import numpy as np
from driver import REFERENCE, changed, load
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.mesh.stacks import block_on_plane
from reference_mesh import from_reference

WHAT = "trials just above and just below the limit: verdicts, and the cycles they take"
SOURCE = "statics: W tan(phi) on a plane, overturning about the toe, (N above + N below) tan(phi), biplanar wedge, S1 = atan(T/N)"
BY = "by hand"

G, RHO, HAIR = 9.81, 2400.0, 0.02
SCENE = {
    "strain": "small",
    "relaxation": {"tolerance": 1e-7, "velocity_tolerance": 1e-7},
    "materials": {"block": {"density": RHO, "young": 10e9, "poisson": 0.2}, "base": {"density": 0}},
    "joints": {"default": {"k_n": 10e9, "k_s": 5e9, "friction": 60}, "joint": {}},
    "supports": {"base": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
}


def friction_around(limit, loads, joints=("joint",)):
    """Two trials, HAIR degrees above and below the limit."""
    return {"trials": {"type": "strength_reduction", "loads": loads, "reduce": list(joints), "start": limit + HAIR,
                       "limit": limit - HAIR, "bracket": 3 * HAIR}}


def variants(scene):
    """Rigid and deformable blocks, the paper's model of stress, the one with forces at the corners, and one that has no potential."""
    for rigid in (True, False):
        for model in ("tptm", "pt", "t3pt"):
            yield rigid, changed(scene, ("joints.default.stress_model", model))


def plane():
    for k_n in (10e9, 1e8):
        stages = [{"rest": {"loads": ["weight"]}}, friction_around(30.0, ["weight"])]
        for rigid, scene in variants(changed(SCENE, ("stages", stages), ("joints.default.k_n", k_n), ("joints.default.k_s", k_n / 2))):
            yield block_on_plane(rigid=rigid), scene, 30.0


def overturning():
    """A block 3 m by 10 m; the water rises beside it to 1 % below and above the level that turns it over.

    Closer to it the block stands on less and less of its base: at 0.2 % on 2.7 cm of 3 m, which takes 1e6 cycles."""
    level = (6 * RHO * 3.0 * 10.0 * 1.5 / 1000.0) ** (1 / 3)
    water = {"type": "reservoir", "faces": "left", "level": 0.99 * level}
    flood = {"trials": {"type": "flood", "loads": ["weight", "water"], "step": 0.02 * level, "limit": 1.01 * level}}
    scene = changed(SCENE, ("loads.water", water), ("stages", [{"rest": {"loads": ["weight"]}}, flood]),
                    ("joints.default.k_n", 1e12), ("joints.default.k_s", 5e11))
    ground = renamed(rectangle(-3, -2, 9, 2, group="base", rigid=True), {})
    for rigid in (True, False):
        block = rectangle(0, 0, 3, 10, 3, 10, group="block", rigid=rigid)
        for model in ("tptm", "pt") if rigid else ("tptm",):
            mesh = join([ground, renamed(block, {"left": "left", "joint": "bottom"})])
            yield mesh, changed(scene, ("joints.default.stress_model", model)), level


def loose_block():
    """A block pushed out between the base and a lid that is held sideways; both joints slip, nothing else moves."""
    weight, lid, limit = RHO * G, 5 * RHO * G, 25.0
    push = (2 * lid + weight) * math.tan(math.radians(limit))
    loads = {"weight": {"type": "self_weight", "groups": ["block", "lid"]},
             "push": {"type": "point_force", "point": "corner", "value": [push, 0]}}
    scene = changed(SCENE, ("loads", loads), ("materials.lid", {"density": RHO}), ("supports.lid", {"fix": "x"}),
                    ("stages", [{"rest": {"loads": ["weight", "push"]}}, friction_around(limit, ["weight", "push"])]))
    for rigid, one in variants(scene):
        bodies = [renamed(rectangle(-1, -1, 3, 1, group="base", rigid=True), {}),
                  renamed(rectangle(0, 0, 1, 1, group="block", rigid=rigid), {"joint": "bottom"}, {"corner": "bottom_left"}),
                  renamed(rectangle(-2, 1, 5, 1, group="lid", rigid=True), {"joint": "bottom"})]
        yield join(bodies), one, limit


def small_on_large():
    """A block of 0.1 m by 0.05 m on the slope of one of 20 m, 1e5 times heavier."""
    slope = math.radians(20)
    down, up = np.array([math.cos(slope), -math.sin(slope)]), np.array([math.sin(slope), math.cos(slope)])
    a = np.array([10.0, 20.0 + 10.0 * math.tan(slope)])
    large = quad_patch((0, 0), (20, 0), (20, 20), (0, 20 + 20 * math.tan(slope)), 4, 4, "block", False)
    small = quad_patch(a, a + 0.1 * down, a + 0.1 * down + 0.05 * up, a + 0.05 * up, 1, 1, "block", True)
    small.group_names, small.group_rigid = ["chip"], np.array([1])
    bodies = [renamed(rectangle(-5, -5, 30, 5, group="base", rigid=True), {}), renamed(large, {}), renamed(small, {"joint": "bottom"})]
    scene = changed(SCENE, ("materials.chip", {"density": RHO}), ("loads.weight.groups", ["block", "chip"]),
                    ("stages", [{"rest": {"loads": ["weight"]}}, friction_around(20.0, ["weight"])]))
    return [(join(bodies), scene, 20.0)]


def wedge():
    case = load("wedge")
    limit = case.PHI
    thrust = case.W_BLOCK * case.tan(limit) + case.W_WEDGE * case.tan(case.SLOPE + limit)
    force = {"b_top_left": [thrust / 2, -case.W_BLOCK / 2], "b_top_right": [0, -case.W_BLOCK / 2], "b_bottom_left": [thrust / 2, 0],
             "w_top_left": [0, -case.W_WEDGE / 2], "w_top_right": [0, -case.W_WEDGE / 2]}
    loads = {name: {"type": "point_force", "point": name, "value": value} for name, value in force.items()}
    reduce = {"type": "strength_reduction", "loads": list(loads), "reduce": ["block+base", "wedge+base"], "start": limit + HAIR,
              "limit": limit - HAIR, "bracket": 3 * HAIR}
    rough = {"k_n": 10e9, "k_s": 10e9, "friction": 60}
    for model in ("tptm", "pt"):
        joints = {"default": rough | {"stress_model": model}, "block+base": {}, "wedge+base": {}, "block+wedge": {"friction": 0}}
        yield case.two_on_base(), changed(case.SCENE, ("strain", "small"), ("loads", loads), ("joints", joints),
                                          ("stages", [{"rest": {"loads": list(loads)}}, {"trials": reduce}])), limit


def dam(n=12, model="tptm", start=28.4):
    """S1 by bisection to a hundredth of a degree."""
    sliding = load("sliding")
    stage = sliding.SCENE["stages"][2]["s1"] | {"start": start, "limit": 26, "bracket": 0.01}
    scene = changed(sliding.SCENE, ("joints.base.stress_model", model), ("stages", sliding.SCENE["stages"][:2] + [{"trials": stage}]))
    normal, shear = sliding.plane_forces()
    return from_reference(REFERENCE / f"mesh_guilhofrei_g1_n{n}.json"), scene, math.degrees(math.atan2(shear, normal))


def every_dam():
    return [dam(n, model, start) for n in (12, 24) for model in ("tptm", "pt", "t3pt") for start in (45, 28.4)]


def stands(value, limit, flood):
    return value < limit if flood else value > limit


def run(case):
    mechanisms = {"a block on a plane, k_n 10 GPa/m and 100 MPa/m": plane(), "overturning": overturning(),
                  "a block between base and lid": loose_block(), "a small block on a large one": small_on_large(),
                  "block and wedge": wedge(), "section G1 on its base (S1)": every_dam() if case.full else [dam()]}
    mechanisms = {what: list(jobs) for what, jobs in mechanisms.items()}
    counted = judge(case, mechanisms, "explicit", "cycles")
    case.check("trials in all, at least 40", counted >= 40, True)
    judge(case, mechanisms, "preconditioned", "force evaluations")


def judge(case, mechanisms, method, unit):
    """Verdicts against statics; returns how many. By Newton's method none may be left to the explicit loop."""
    counted, explicit = 0, 0
    for what, jobs in mechanisms.items():
        results = case.run_all([(mesh, changed(scene, ("relaxation.method", method))) for mesh, scene, _ in jobs])
        trials = []
        for (_, _, limit), result in zip(jobs, results):
            stage = result.stage_summary("trials")
            rows = stage.get("flood") or stage["strength_reduction"]
            trials += [(trial["outcome"], "stable" if stands(trial["value"], limit, "flood" in stage) else "fails", trial["cycles"])
                       for trial in rows["trials"]]
            explicit += "explicit" in stage["method"]
        counted += len(trials)
        case.check(f"{what}, {method}: of {len(trials)} trials with a wrong verdict", sum(ours != exact for ours, exact, _ in trials), 0)
        for outcome in ("stable", "fails"):
            cycles = [n for ours, _, n in trials if ours == outcome]
            case.report(f"... {unit} until told {outcome}, the most; in the column before, the middle", max(cycles), np.median(cycles))
    if method == "preconditioned":
        case.check("preconditioned: runs with a trial that the explicit loop had to judge", explicit, 0)
    return counted

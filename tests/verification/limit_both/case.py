"""A limit held from both sides (quoin limit --both): walls of Ferris and Tin-Loi and three more, floods and reductions of dams; runs of the solver beside it may not stand above the upper end or fail below the lower one."""

import math
import os
from pathlib import Path

import assemblies as p
import models
import numpy as np
import scipy
import yaml
from driver import PUBLISHED, ROOT, changed
from quoin_tools.limit import LimitError
from quoin_tools.limit.both import BRACKET, LAST, both, way
from quoin_tools.limit.bounds import bound
from quoin_tools.limit.standing import standing
from quoin_tools.mesh.dam import G1, dam_mesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.mesh.voronoi import Options, voronoi_mesh
from quoin_tools.mesh.walls import wall
from quoin_tools.show import limit, limit_both

WHAT = "limit without dilation, held from both sides: walls, arch on piers, dam of polygons under water; floods and reductions of strength of dams; runs beside it; refusals"
SOURCE = "literature and explicit runs of another program for the walls (examples/published/problems.yaml); statics for the block under a ceiling, dams of one block and Guilhofrei; runs of the solver"
BY = "literature; independent explicit runs of this project; by hand"
GAP, RIGID_GAP = 0.03, 0.02  # goal
SIDEWAYS = {"push": {"type": "pseudo_static", "coefficient": [1, 0], "groups": ["block"]}}


def run(case):
    os.environ["QUOIN_SOLVER"] = str(Path(case.quoin).resolve())
    ceiling(case)
    refused(case)
    dams(case)
    two_limits(case)
    for number, stands, fails in () if case.short else ((1, 0.62875, 0.63), (3, 0.34875, 0.35), (2, 0.55, 0.55125)):
        scene = yaml.safe_load((PUBLISHED / f"wall_{number}.yaml").read_text(encoding="utf-8"))
        ends = held(case, f"wall {number}", models.MESHES[f"wall_{number}"](), scene)
        case.check("... no independent explicit run stands above", stands <= ends.upper, True)
        case.check("... none fails below", fails >= ends.lower, True)
    if not case.short:
        for name, (mesh, keys) in {"arch on piers": piers(), "dam of polygons": polygons(), "wall with two openings": openings()}.items():
            held(case, name, mesh, keys)
        at_once(case)


def held(case, name, mesh, keys):
    """Returns the ends of a scene. Beside them stand runs: as the scene is, with forces in corners (pt), softer in shear."""
    folder = case.prepare(mesh, {"model": "model.h5"} | keys)
    before = os.getcwd()
    os.chdir(folder)
    try:
        mesh, scene, _ = limit.inputs("scene.yaml")
    finally:
        os.chdir(before)
    ends = both(mesh, scene, bound(mesh, scene, "push"))
    case.check(f"{name}: gap of the ends", ends.gap, 0.0, absolute=GAP)
    case.check("... gap of rigid hinges", ends.gap_to(ends.rigid), 0.0, absolute=RIGID_GAP)
    case.check("... mechanisms and their forces hold to", max(one.mechanism.error for one in ends.ways if one.mechanism), 0.0, absolute=1e-6)
    case.check("... each path ends within the factors of its mechanism, or at the bound", all(one.fails == ends.raised.bound if one.mechanism is None else one.mechanism.least <= (1 + 1e-9) * one.fails and one.stands <= (1 + 1e-9) * one.mechanism.most for one in ends.ways), True)
    case.check("... forces of the runs hold to", max(found.error for found in ends.runs.values()), 0.0, absolute=2e-6)
    stage = keys["stages"][-1]["push"] | {"start": 0.8 * ends.lower, "step": 0.03 * ends.lower, "limit": 1.2 * ends.upper, "bracket": 1e-3 * ends.upper}
    for what, changes in (("as the scene is", {}), ("pt", {"stress_model": "pt"}), ("softer in shear", {"k_s": 0.3 * float(keys["joints"]["default"]["k_s"])})):
        trials = case.run(mesh, changed(keys, ("strain", "small"), ("joints.default", keys["joints"]["default"] | changes), ("stages", [*keys["stages"][:-1], {"push": stage}]))).stage_summary("push")["load_factor"]
        case.check(f"... a run {what} does not stand above", trials["stable"] <= ends.upper, True)
        case.check("... and does not fail below", (trials["failing"] or math.inf) >= ends.lower, True)
    return ends


def at_once(case):
    """A wall on which loads that come at once find forces that bear more than those of loads that grow step by step."""
    mesh, keys = irregular()
    ends = both(mesh, p.scene_of(keys), bound(mesh, p.scene_of(keys), "push"))
    stepped = max(found.measure for found in ends.runs.values())
    case.check("irregular wall: loads that come at once bear more than those that grow", ends.at_once is not None and ends.at_once.measure > 1.005 * stepped, True)
    for start in (0.575, 0.5775, 0.58):  # seen to stand before the upper end took them in, which was 0.5769
        stage = keys["stages"][-1]["push"] | {"start": start, "step": 5e-4, "limit": ends.raised.bound, "bracket": 5e-4}
        trials = case.run(mesh, changed(keys, ("strain", "small"), ("joints.default.stress_model", "pt"), ("stages", [*keys["stages"][:-1], {"push": stage}]))).stage_summary("push")["load_factor"]
        case.check(f"... a run that begins at {start:g} does not stand above the upper end", trials["stable"] <= ends.upper, True)


def two_limits(case):
    """Walls of four courses. Where a stone turns and slides, friction of the corner that parts is forgotten: of one wall only a path with friction at each corner ends where runs do, the other one has two true limits."""
    mesh, keys = courses(0.342, ((0, 0.51, 0.88, 1.49, 2), (0, 0.4, 0.9, 1.48, 2), (0, 0.49, 1, 1.44, 2), (0, 0.38, 1.04, 1.44, 2)), 0.66, 1e10)
    ends = both(mesh, p.scene_of(keys), bound(mesh, p.scene_of(keys), "push"))
    corners = ends.runs["corners"]
    case.check("wall of 16 stones: paths with friction at each corner end where the run with forces in corners does", [one.fails for one in ends.ways[:2]], [corners.fails] * 2, relative=2e-3)
    case.check("... gap of the ends", ends.gap, 0.0, absolute=GAP)
    for part in (0.7, 1.2):
        found = way(ends.bound.parts, ends.raised, 1.0, 2, near=part * corners.fails)
        case.check(f"... a path that is expected to end at {part:g} of that ends there too", found.fails, corners.fails, relative=2e-3)
    mesh, keys = courses(0.313, ((0, 0.42, 1.09, 1.5), (0, 0.31, 0.62, 1.37, 1.5), (0, 0.44, 1.05, 1.5), (0, 0.33, 0.65, 1.23, 1.5)), 0.599, 1e11)
    scene = p.scene_of(keys)
    ends = both(mesh, scene, bound(mesh, scene, "push"))
    corners, own = ends.runs["corners"], ends.runs[1.0]
    case.check("wall of 14 stones with two limits: forces in corners bear more than the joints of the scene", corners.measure > 1.1 * own.fails, True)
    case.check("... both by paths of rigid blocks", [ends.ways[0].fails, ends.ways[2].fails], [corners.fails, own.fails], relative=0.02)
    if not case.short:
        stiff = standing(mesh, scene, "push", ends.bound.parts, ends.raised, ends.raised.trials(ends.ways[2].fails, BRACKET, LAST), 8.0)
        case.check("... no hinge: joints of 8 times the stiffness bear as much as those of the scene", [stiff.measure, stiff.fails], [own.measure, own.fails], relative=5e-3)
    told = limit_both.both_true(ends)
    case.check("... the command tells both", told and told[:2], [corners.measure, own.fails], relative=1e-12)
    for model, method, least, most in (("pt", "explicit", corners.measure, ends.upper), ("tptm", "preconditioned", ends.lower, own.fails))[: 1 if case.short else 2]:
        stage = keys["stages"][-1]["push"] | {"start": 0.3, "step": 0.02, "limit": 0.6, "bracket": 1e-3}
        scene = changed(keys, ("strain", "small"), ("relaxation.method", method), ("joints.default.stress_model", model), ("stages", [{"push": stage}]))
        trials = case.run(mesh, scene).stage_summary("push")["load_factor"]
        case.check(f"... another run with {model} stands and fails there", [trials["stable"], trials["failing"]], [least, most], relative=0.01)


def ceiling(case):
    """A block under a ceiling, which dilation would wedge: no bound, and 0.5 without dilation by statics."""
    mesh, keys = p.ceiling()
    scene = p.scene_of(keys)
    ends = both(mesh, scene, bound(mesh, scene, "push"))
    case.check("L05 block under a ceiling: no bound, upper end without dilation", ends.upper, 0.5, relative=5e-3)
    case.check("... lower end", ends.lower, 0.5, relative=5e-3)
    mesh, keys = p.pier()  # the bound is 115.98; statics without dilation and independent rigid blocks have 108.5 to 109
    keys = changed(keys, ("joints.default.stress_model", "pt"))
    ends = both(mesh, p.scene_of(keys), bound(mesh, p.scene_of(keys), "push"))
    case.check("L04 pier: ends without dilation [kN]", [ends.lower, ends.upper], [108.5, 109.0], relative=8e-3)


def dams(case):
    """Floods and reductions of dams of one block whose limits are known by hand, and of Guilhofrei (S4, S1)."""
    drained = {"type": "uplift", "faces": "base", "level": 2.0, "rule": "npb", "drain": 0.75}  # a third of the head behind 0.75 m
    rows = (("flood, slides on its drained base", 3.0, 0.6, {"uplift": drained}, {"type": "flood"}), ("flood, tips on its drained base", 2.5, 0.9, {"uplift": drained}, {"type": "flood"}),
            ("strengths, slides", 3.0, 0.7, {}, {"type": "strength_reduction", "what": "strengths"}), ("friction, slides", 3.0, 0.7, {}, {"type": "strength_reduction"}))  # fmt: skip
    for what, width, friction, more, stage in case.some(rows, 2):
        water = 2.0 if stage["type"] == "flood" else 4.0
        mesh = join([renamed(rectangle(-5, -3, 15, 3, group="ground", rigid=True)), renamed(rectangle(0, 0, width, 6, 20, 1, "block", True), {"upstream": "left", "base": "bottom"})])
        keys = p.basic(2400, friction, {"push": {"type": "reservoir", "faces": "upstream", "level": water}} | more, [{"push": stage | {"loads": ["weight", "push", *more]}}])
        scene = p.scene_of(keys)
        ends = both(mesh, scene, bound(mesh, scene, "push"))
        exact = level_by_hand(width, friction) if water == 2.0 else 2.4 * width * 6 * friction / 8
        case.check(f"dam of one block, {what}: upper end by hand", ends.raised.bound, exact - (2 if water == 2.0 else 0), relative=1e-6)
        case.check("... the lower end is not above it", ends.lower <= ends.raised.bound, True)
        case.check("... gap of the ends", ends.gap, 0.0, absolute=0.012)
        case.check("... forces of the runs hold to", max(found.error for found in ends.runs.values()), 0.0, absolute=2e-6)
        if case.short:
            continue
        value = ends.raised.value(ends.lower)
        trials = {"limit": value, "step": value - water} if water == 2.0 else {"start": value, "limit": 0.9 * value} | ({"factor": 0.9} if "what" in stage else {"step": 0.1 * value})
        result = case.run(mesh, changed(keys, ("strain", "small"), ("stages", [{"push": keys["stages"][0]["push"] | trials}])), ranks=2)
        case.check("... a run on two ranks stands at the lower end", result.stage_summary("push")[stage["type"]]["stable"], value, relative=1e-9)
    for name, exact in () if case.short else (("s4", 46.266 - 33), ("s1", 1 / math.tan(math.radians(28.102)))):
        scene = yaml.safe_load((ROOT / "examples/guilhofrei_sliding/scene.yaml").read_text(encoding="utf-8"))
        scene["stages"] = [row for row in scene["stages"] if set(row) & {"sw", "swhp", "swhpu", name}]
        scene = p.scene_of(changed(scene, ("joints", {"base": scene["joints"]["base"]}), ("stages.2.swhpu.joints", {"base": {"law": "mohr_coulomb", "friction": 45}})))
        mesh = dam_mesh(G1, 15)
        ends = both(mesh, scene, bound(mesh, scene, name))
        case.check(f"Guilhofrei {name}: upper end, by statics", ends.upper, exact, relative=1e-4)
        case.check("... gap of the ends", ends.gap, 0.0, absolute=0.005)


def level_by_hand(width, friction, height=6.0, drain=0.75):
    """Level [m] at which a block of 2400 kg/m3 slides or tips on a base whose drain leaves a third of the head; water over its crest presses on its face alone. Forces over 1000 kg/m3 g."""
    weight = 2.4 * width * height

    def left(level):
        wet, left = min(level, height), level / 3
        thrust, moment = level * wet - wet**2 / 2, level * wet**2 / 2 - wet**3 / 3
        rows = ((left * drain, width - drain / 2), ((level - left) * drain / 2, width - drain / 3), (left * (width - drain) / 2, 2 / 3 * (width - drain)))
        up = np.array(rows)
        return min(friction * (weight - up[:, 0].sum()) - thrust, weight * width / 2 - moment - up.prod(axis=1).sum())

    return scipy.optimize.brentq(left, 1e-3, 3 * height)


def refused(case):
    mesh, keys = p.dam(0.75)
    crushed, static = changed(keys, ("joints.default.compression", 1e6)), changed(keys, ("stages", [{"push": {"loads": ["weight", "push"]}}]))
    for what, scene in (("compression", crushed), ("type static", static)):
        try:
            both(mesh, p.scene_of(scene), bound(mesh, p.scene_of(scene), "push"))
            said = ""
        except LimitError as error:
            said = str(error)
        case.check(f"refused: {what}", what in said, True)


def piers():
    """Half-circular arch of 11 stones, 0.4 m thick, inner radius 2 m, on piers of four stones; friction 0.4."""
    stones, angles = [renamed(rectangle(-3.5, -0.5, 7, 0.5, group="ground", rigid=True))], np.linspace(math.pi, 0, 12)
    for side in (-1, 1):
        stones += [renamed(rectangle(2.2 * side - 0.45, 0.4 * k, 0.9, 0.4, group="block", rigid=True)) for k in range(4)]
    for a, b in zip(angles[:-1], angles[1:]):
        (ax, ay), (bx, by) = ((math.cos(t), math.sin(t)) for t in (a, b))
        corners = [(2 * bx, 1.6 + 2 * by), (2.4 * bx, 1.6 + 2.4 * by), (2.4 * ax, 1.6 + 2.4 * ay), (2 * ax, 1.6 + 2 * ay)]
        stones.append(renamed(quad_patch(*corners, 1, 1, "block", True)))
    return join(stones), p.basic(2400, 0.4, SIDEWAYS)


def polygons():
    """Dam of random polygons, 10 m high, on a base, under water times a factor; friction 0.6."""
    dam = voronoi_mesh(np.array([(0, 0), (8, 0), (2, 10), (0, 10)], dtype=float), Options(side=1.2, seed=4, facing=(0.0, 0.0)))
    dam.group_names, dam.group_rigid = ["block"], np.ones(1, dtype=np.int32)
    dam.face_sets = {"upstream": dam.face_sets["upstream"]}
    return join([renamed(rectangle(-4, -2, 16, 2, group="ground", rigid=True)), dam]), p.basic(2400, 0.6, {"push": {"type": "reservoir", "faces": "upstream", "level": 10}})


def openings():
    """Wall of eight courses with a door and a window under lintels; friction 0.5."""
    mesh = wall(6, 8, 0.5, 0.25, openings=((2, 5, 0, 4), (7, 10, 2, 5)))
    mesh.group_names, mesh.face_sets, mesh.points = ["ground" if name == "base" else name for name in mesh.group_names], {}, {}
    keys = p.basic(2000, 0.5, {"push": SIDEWAYS["push"] | {"groups": ["block", "lintel"]}})
    keys["materials"]["lintel"], keys["loads"]["weight"] = keys["materials"]["block"], {"type": "self_weight", "groups": ["block", "lintel"]}
    return mesh, keys


def irregular():
    """Wall of eight courses of stones of 0.25 to 0.6 m; friction 0.65."""
    rows = ((0, 0.55, 1, 1.25, 1.6), (0, 0.4, 0.8, 1.3, 1.6), (0, 0.5, 1.1, 1.6), (0, 0.35, 0.75, 1.05, 1.6), (0, 0.55, 1.1, 1.6), (0, 0.6, 1, 1.6), (0, 0.55, 1.1, 1.6), (0, 0.3, 0.85, 1.35, 1.6))
    return courses(0.2, rows, 0.65, 1e11)


def courses(height, rows, friction, stiffness):
    """Wall of courses on the ground. rows: where vertical joints are [m]."""
    stones = [renamed(rectangle(-0.5, -height, rows[0][-1] + 1, height, group="ground", rigid=True))]
    stones += [renamed(rectangle(a, height * k, b - a, height, group="block", rigid=True)) for k, joints in enumerate(rows) for a, b in zip(joints[:-1], joints[1:])]
    keys = p.basic(2000, friction, SIDEWAYS)
    keys["joints"]["default"] |= {"k_n": stiffness, "k_s": stiffness}
    return join(stones), keys

"""Tendons and bars from block to block (anchors): stressing in order, a sliding block, a dam in a flood, yield, lift-off, failure.

By hand: springs in series and in parallel, a block on a plane with the force of a tendon, a rigid dam on a base without tension."""

import math
import sys
from pathlib import Path

import numpy as np
from driver import ROOT, changed
from quoin_tools.base.anchors import read_history
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles
from scipy.optimize import brentq

sys.path.append(str(ROOT / "examples" / "anchored_dam"))
from closed_form import anchored, overturns  # noqa: E402

WHAT = "anchors: stressing in order (VA06), block on a slope (VA04), dam in a flood (VA05), yield (VA07), lift-off (VA09), failure, ranks, restart"
SOURCE = "springs in series, statics of a block on a plane, of a rigid dam on a base without tension"
BY = "by hand"

G, RHO = 9.81, 2400.0


def base(left, right, depth=10.0):
    return renamed(rectangle(left, -depth, right - left, depth, group="base", rigid=True), {"joint": "top"})


def scene(anchors, stages, k_n=4e9, k_s=4e9, friction=45, **more):
    return {
        "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9},
        "materials": {"block": {"density": RHO, "rigid": True}, "base": {"density": RHO, "rigid": True}},
        "joints": {"default": {"k_n": k_n, "k_s": k_s, "friction": friction}}, "supports": {"base": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
        "anchors": anchors, "stages": stages,
    } | more  # fmt: skip


def tendon(head, root, k, **keys):
    """One whose stiffness is k [N/m]."""
    return {"head": list(head), "root": list(root), "area": k * math.dist(head, root) / 200e9, "young": 200e9} | keys


def under_weight(*names, **keys):
    return [{name: {"loads": ["weight"]} | keys.get(name, {})} for name in names]


def told(result, stage, name="a"):
    return result.stage_summary(stage)["anchors"][name]


def force(result, stage, name="a"):
    return told(result, stage, name)["force"]


LONG = ("ranks_and_restart",)  # parts that the short form leaves out


def run(case):
    stressing(case)
    stressing_keys(case)
    slope(case)
    force_needed(case)
    dam(case)
    slides_on_its_tendon(case)
    yields(case)
    lift_off(case)
    failure(case)
    spinning(case)
    ranks_and_restart(case)
    refused(case)
    doubtful(case)


def doubtful(case):
    """What holds no joint together, runs through air, or is cut into pieces that are too long, is reported."""
    lower, upper, other = base(0, 4, 2), *(renamed(rectangle(x, 0, width, 2, 2, 2, group="block", rigid=True), {}) for x, width in ((0, 2), (3, 1)))
    mesh = join([lower, upper, other])
    bar = {"area": 1e-3, "young": 200e9, "bond_stiffness": 1e7}  # takes its force over sqrt(E A / k) = 4.47 m
    for what, anchor, words in (("across a joint", tendon((1, 1.5), (1, -1.5), 1e8), None), ("in one body", tendon((0.5, 0.5), (1.5, 1.5), 1e8), "head and root lie in one body"),
                                ("through air", tendon((1.5, 1), (3.5, 1), 1e8), "1 of its 2 m run outside all blocks"),
                                ("a bar in pieces of 0.9 m", bar | {"head": [1, 1.9], "root": [1, -1.9], "segment": 0.9}, None),
                                ("in pieces of 1.9 m", bar | {"head": [1, 1.9], "root": [1, -1.9], "segment": 1.9}, "pieces of 1.9 m are 0.42 of the length")):  # fmt: skip
        for ranks in (1, 2):
            out = case.again(case.prepare(mesh, scene({"a": anchor}, [{"rest": {"loads": ["weight"]}}])), ranks=ranks)
            said = [line for line in out.stderr.splitlines() if "warning: anchors.a" in line]
            case.check(f"an anchor {what}, {ranks} ranks: reported", [len(said), words is None or any(words in line for line in said)], [int(words is not None), True])


# ---- VA06


def on_joint(rigid=True, triangles=False):
    block = rectangle(-1, 0, 2, 2, 4, 4, group="block", rigid=rigid)
    return join([base(-3, 3), renamed(split_triangles(block) if triangles else block, {"top": "top"}, {"mark": "bottom_left"})])


def stressing(case):
    """Two tendons, 800 kN each, one after the other: the second takes force from the first, by the closure of the joint of 8 GN/m."""
    k, k_joint, T = 40e6, 8e9, 800e3
    anchors = {name: tendon((0, 1.7), (0, -3.2), k, prestress=T, lock=stage) for name, stage in (("a", "first"), ("b", "second"))}
    stages = under_weight("own", "first", "second", "after")
    for method in ("explicit", "preconditioned"):
        for strain in ("small", "large"):
            result = case.run(on_joint(), scene(anchors, stages, strain=strain, relaxation={"tolerance": 1e-11, "velocity_tolerance": 1e-11, "method": method}))
            case.check(f"VA06, {method}, {strain} strain: forces as the second is stressed [N]", [force(result, "second", name) for name in "ab"],
                       [T - k * T / (k + k_joint), T], relative=1e-8)
            case.check("... behind it, at the end [N]", [force(result, "after", name) for name in "ab"], [T - k * T / (k + k_joint), T], relative=1e-8)
            closes = result.probe("after", "mark")[1] - result.probe("own", "mark")[1]
            case.check("... closure [m]", -closes, T / k_joint + T / (k + k_joint), relative=1e-7)
            case.check("... work of the jacks on the model [J]", [told(result, "after", name)["work"] for name in "ab"],
                       [T * T / k_joint, T * T / (k + k_joint)], relative=1e-7)
            case.check("... states", [told(result, stage)["state"] for stage in ("own", "first", "second")], ["absent", "stressed", "elastic"])
    for what, mesh, more in (("deformable", on_joint(False), {}), ("triangles", on_joint(False, True), {}), ("condensed", on_joint(False), {"condensed": True})):
        soft = {"density": RHO, "rigid": False, "young": 20e9, "poisson": 0.2} | more
        for method in ("explicit", "preconditioned"):
            result = case.run(mesh, changed(scene(anchors, stages, strain="small"), ("materials.block", soft), ("relaxation.method", method)))
            joint = result.stage_summary("after")["joints"]["default"]
            case.check(f"{what} block, {method}: the second tendon [N]", force(result, "after", "b"), T, relative=1e-7)
            case.check("... the joint bears weight and both [N]", joint["N"], 4 * RHO * G + force(result, "after") + T, relative=1e-6)


def stressing_keys(case):
    """Spacing, free length, draw-in, stressed again, a passive bar that comes later, slack and compression."""
    k, T, K = 40e6, 800e3, 8e9
    a = tendon((0, 1.7), (0, -3.2), k, prestress=T, lock="first")
    one = changed(scene({"a": a}, under_weight("own", "first", "after")), ("relaxation.tolerance", 1e-11))
    result = case.run(on_joint(), changed(one, ("anchors.a.spacing", 2.5), ("thickness", 3)))
    joint = result.stage_summary("first")["joints"]["default"]
    case.check("every 2.5 m, 3 m thick: the joint bears [N]", joint["N"], 3 * (4 * RHO * G + T / 2.5), relative=1e-8)
    case.check("... force per metre [N/m]", told(result, "after")["force_per_metre"], T / 2.5, relative=1e-8)
    result = case.run(on_joint(), changed(one, ("anchors.a.free_length", 2.0)))
    case.check("free length 2 m: stiffness [N/m]", told(result, "after")["stiffness"], k * 4.9 / 2, relative=1e-12)
    slip = 0.002
    result = case.run(on_joint(), changed(one, ("anchors.a.draw_in", slip)))
    case.check("head slips back by 2 mm as it is locked [N]", [force(result, "first"), force(result, "after")], [T, T - k * slip * K / (k + K)], relative=1e-8)
    again = changed(one, ("anchors.a.prestress", [T, 1.2 * T]), ("anchors.a.lock", ["first", "more"]),
                    ("stages", under_weight("own", "first", "after", "more", "last")))  # fmt: skip
    for strain in ("small", "large"):
        result = case.run(on_joint(), changed(again, ("strain", strain)))
        case.check(f"stressed again, {strain} strain [N]", [force(result, stage) for stage in ("first", "after", "more", "last")], [T, T, 1.2 * T, 1.2 * T], relative=1e-9)
        case.check("... the joint bears [N]", [result.stage_summary(stage)["joints"]["default"]["N"] for stage in ("after", "more", "last")],
                   [4 * RHO * G + T, 4 * RHO * G + 1.2 * T, 4 * RHO * G + 1.2 * T], relative=1e-8)
    row = changed(again, ("anchors.a.lock", ["first", "more"]), ("stages", under_weight("own", "first", "more", "last")))
    case.check("stressed in two stages in a row: work of the jacks [J]", told(case.run(on_joint(), row), "last")["work"], T * T / K + 1.2 * T * 0.2 * T / K, relative=1e-7)
    P = 1e6  # pushed down, then pulled up
    bars = {"from_first": tendon((0, 1.7), (0, -3.2), k), "later": tendon((0, 1.7), (0, -3.2), k, **{"from": "pulled"}),
            "bar": tendon((0, 1.7), (0, -3.2), k, compression=True)}
    loads = {"weight": {"type": "self_weight", "groups": ["block"]}} | {name: {"type": "traction", "faces": "top", "value": [0, p / 2]} for name, p in (("push", -P), ("pull", P))}
    stages = [*under_weight("own"), {"pushed": {"loads": ["weight", "push"]}}, {"pulled": {"loads": ["weight", "pull"]}}]
    for method in ("explicit", "preconditioned"):
        result = case.run(on_joint(), changed(scene(bars, stages, loads=loads, k_n=2e9), ("relaxation.method", method), ("joints.default.law", "elastic")))
        own, K = 4 * RHO * G, 4e9
        down = (own + P) / (K + k)  # the bar bears beside the joint
        up = (P - own + k * -down) / (K + 3 * k)  # the one that comes later starts from there
        case.check(f"pushed, {method}: slack tendon, absent one, bar [N]", [force(result, "pushed", name) for name in bars], [0, 0, -k * down], absolute=0.1)
        case.check("... pulled [N]", [force(result, "pulled", name) for name in bars], [k * up, k * (up + down), k * up], absolute=0.1)
        case.check("... states", [told(result, "pushed", name)["state"] for name in bars], ["slack", "absent", "elastic"])


# ---- VA04


def block_on_slope(slope=35.0):
    """10 m by 3 m, 2000 kN, on a plane that rises to the right; its base begins at 0 along the plane."""
    c, s = math.cos(math.radians(slope)), math.sin(math.radians(slope))
    def turned(mesh):
        mesh.vertices = np.array(mesh.vertices) @ [[c, s], [-s, c]]
        return mesh
    ground = renamed(turned(rectangle(-10, -12, 40, 12, group="base", rigid=True)), {"joint": "top"})
    return join([ground, renamed(turned(rectangle(0, 0, 10, 3, 2, 1, group="block", rigid=True)), {}, {"mark": "bottom_left"})]), np.array([c, s])


def slope(case):
    """A tendon that dips by d from the horizontal into the slope: its pull up the plane is T cos(d + 35), its pressure T sin(d + 35)."""
    W, T, alpha = 2e6, 600e3, math.radians(35)
    mesh, along = block_on_slope()
    normal = np.array([-along[1], along[0]])
    head = 5 * along + 0.3 * normal
    def holding(d, friction, pull):  # what is missing
        d = math.radians(d)
        return W * math.sin(alpha) - pull * math.cos(d + alpha) - (W * math.cos(alpha) + pull * math.sin(d + alpha)) * math.tan(math.radians(friction))
    dense = {"materials.block.density": W / (G * 30)}
    for d, wanted in ((0, 18.301), (20, 20.658), (40, 24.095)):
        a = tendon(head, head + 10 * np.array([math.cos(math.radians(d)), -math.sin(math.radians(d))]), 20e6, prestress=T, lock="lock")
        a["yield"] = T * (1 + 1e-6) / a["area"]  # so its force stays
        stages = [*under_weight("own", "lock"), {"less": {"type": "strength_reduction", "loads": ["weight"], "start": 30, "step": 2, "limit": 10, "bracket": 0.002}}]
        less = changed(scene({"a": a}, stages, 10e9, 10e9, 40), *dense.items(), ("strain", "small"), ("relaxation.tolerance", 1e-7))
        stage = case.run(mesh, less).stage_summary("less")
        exact = brentq(lambda friction, d=d: holding(d, friction, T), 1, 40)
        case.check(f"VA04, dip {d}: limit angle of friction, constant T (reference {wanted}) [degree]", [exact, np.mean([stage["strength_reduction"][key] for key in ("stable", "failing")])],
                   [wanted, exact], absolute=0.003)
        needed = brentq(lambda pull, d=d: holding(d, 30, pull), 0, T)
        passive = tendon(a["head"], a["root"], 20e6)
        slides = needed / 20e6 / math.cos(math.radians(d) + alpha)
        for method in ("explicit", "preconditioned"):
            held = changed(scene({"a": passive}, [*under_weight("own"), {"slides": {"loads": ["weight"], "joints": {"default": {"friction": 30}}}}], 10e9, 10e9, 40),
                           *dense.items(), ("strain", "small"), ("relaxation.method", method))  # fmt: skip
            result = case.run(mesh, held)
            case.check(f"... passive, {method}: it slides until the bar carries [N]", force(result, "slides"), needed, relative=0.02)
            moved = -(result.probe("slides", "mark") - result.probe("own", "mark")) @ along
            case.check("... by [m]", moved, slides, relative=0.02)
    case.check("T that a dip of 20 needs (reference) [N]", brentq(lambda pull: holding(20, 30, pull), 0, T), 192.33e3, relative=1e-4)


def force_needed(case):
    """The least pull with which the block stands: by hand, for factors 1 and 1.3, of one tendon and of two unlike ones, and what cannot be reached."""
    W, alpha, full = 2e6, math.radians(35), 800e3
    mesh, along = block_on_slope()
    head = 5 * along + 0.3 * np.array([-along[1], along[0]])
    def dipping(d):
        d = math.radians(d)
        return tendon(head, head + 10 * np.array([math.cos(d), -math.sin(d)]), 20e6, prestress=full)
    def least(factor, *dips):  # times full of each
        tan = math.tan(math.radians(30)) / factor
        held = sum(math.cos(math.radians(d) + alpha) + math.sin(math.radians(d) + alpha) * tan for d in dips)
        return W * (math.sin(alpha) - math.cos(alpha) * tan) / held
    def found(anchors, ranks=1, **keys):
        search = {"type": "anchor_force", "loads": ["weight"], "anchors": list(anchors), "bracket": 5e-4} | keys
        stages = [*under_weight("own"), {"less": search}, *under_weight("after")]
        stages[0]["own"]["joints"] = {"default": {"friction": 40}}
        search["joints"] = {"default": {"friction": 30}}
        whole = changed(scene(anchors, stages, 10e9, 10e9, 40), ("materials.block.density", W / (G * 30)), ("strain", "small"), ("relaxation.tolerance", 1e-7))
        return case.run(mesh, whole, ranks=ranks), whole
    for d, wanted in ((0, 174.98e3), (20, 192.33e3), (40, 246.51e3)):
        result, _ = found({"a": dipping(d)}, required=1.0)
        search = result.stage_summary("less")["anchor_force"]
        ends = [search["forces"]["a"][end] for end in ("failing", "stable")]
        case.check(f"VA04, dip {d}: force that it needs, by hand against the reference [N]", least(1, d), wanted, relative=1e-4)
        case.check("... between [N]", [ends[0] < least(1, d) * 1.0005, ends[1] > least(1, d) * 0.9995, ends[1] - ends[0] <= 5e-4 * full], [True] * 3)
        case.check("... it carries that, locked in the stage behind [N]", [force(result, "less"), force(result, "after")], [ends[1], ends[1]], relative=2e-3)
        case.check("... reported", f"a needs {ends[0] / 1e3:.6g} to {ends[1] / 1e3:.6g} kN" in result.stdout, True)
    two = {"a": dipping(0), "b": dipping(40) | {"prestress": 0.5 * full}}
    tan = math.tan(math.radians(30)) / 1.3
    pull = sum(part * (math.cos(math.radians(d) + alpha) + math.sin(math.radians(d) + alpha) * tan) for part, d in ((1, 0), (0.5, 40)))
    needed = W * (math.sin(alpha) - math.cos(alpha) * tan) / pull
    result, whole = found(two, required=1.3, step=0.3)
    search = result.stage_summary("less")["anchor_force"]
    case.check("two tendons, factor 1.3: parts of the prestress, by hand", np.mean([search["stable"], search["failing"]]), needed / full, relative=1e-3)
    case.check("... forces are these parts [N]", [search["forces"][name]["stable"] for name in "ab"], [search["stable"] * full, search["stable"] * full / 2], relative=1e-12)
    case.check("... trials go by steps of 0.3 first", [trial["value"] for trial in search["trials"][:5]], [1, 0.7, 0.4, 0.1, 0.25], absolute=1e-12)
    case.check("... the strengths are whole again behind it: sliding factor rises by 1.3",
               result.stage_summary("after")["joints"]["default"]["sliding_factor_peak"] / result.stage_summary("less")["joints"]["default"]["sliding_factor_peak"], 1.3, relative=0.02)
    for ranks in case.ranks(2, 3):
        case.check(f"... checksums on {ranks} ranks", checksums(case.run(mesh, whole, ranks=ranks)), checksums(result))
    folder = case.prepare(mesh, changed(whole, ("checkpoint", {"every": 500, "keep": 1000})))
    case.again(folder)
    case.again(folder, "-output", "kept")
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for at in (len(kept) // 3, 2 * len(kept) // 3):
        again = case.again(folder, "-restart", kept[at], ranks=1 + at % 2)
        case.check(f"... restart from checkpoint {at} of {len(kept)}: checksums", checksums(again), checksums(result))
        case.check("... forces, work of the jacks [N], [J]", [[told(again, "after", name)[key] for key in ("force", "work")] for name in "ab"],
                   [[told(result, "after", name)[key] for key in ("force", "work")] for name in "ab"])
    result, _ = found({"a": dipping(0)}, required=2.4)
    case.check("factor 2.4 is out of reach: one line", [result.exit_code, "it does not stand at its start (1 times the prestress)" in result.stderr, result.stderr.count("\n")], [2, True, 1])
    result, _ = found({"a": dipping(20)}, required=0.5)
    search = result.stage_summary("less")["anchor_force"]
    case.check("factor 0.5: it stands without a pull", [search["stable"], search["failing"], "the limit; nothing fails" in result.stdout], [0, None, True])


# ---- VA05

LEVELS = (36, 42, 46, 50, 54)


def rigid_dam():
    vertices = np.array([(0, 0), (24, 0), (4, 32), (0, 32), (4, 36), (0, 36)], dtype=float)
    body = BlockMesh(vertices, np.array([[0, 1, 2, 3], [3, 2, 4, 5]]), np.zeros(2), ["block"], [1], {"upstream": np.array([[0, 3], [1, 3]])})
    return join([base(-20, 50, 20), body])


def dam_scene(anchors, stages, **more):
    loads = {"weight": {"type": "self_weight", "groups": ["block"]}} | {f"water{h}": {"type": "reservoir", "faces": "upstream", "level": h} for h in LEVELS}
    return scene(anchors, stages, 10e9, 4e9, 85, loads=loads, **more) | {"joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 85, "stress_model": "tptm"}}}


def dam(case):
    """A heightened dam that rises above its reservoir, without an anchor, with one of constant force, an elastic one, a passive one."""
    reference = {"none": {36: (0, 792.0), 42: (7.3534, 1312.5), 46: (14.3362, 2260.9), 50: (21.3190, 8149.4)},
                 "constant": {36: (0, 690.4), 42: (1.2139, 1090.5), 46: (7.3536, 1492.7), 50: (13.4934, 2365.1), 54: (19.6331, 5690.3)},
                 "elastic": {36: (0, 690.3), 42: (1.2064, 1090.3), 46: (7.3407, 1492.0), 50: (13.4591, 2358.8), 54: (19.4079, 5430.6)},
                 "passive": {42: (7.2325, 1306.2), 46: (13.9602, 2190.5), 50: (19.2148, 4719.1), 54: (21.1663, 8561)}}  # fmt: skip
    forces = {"elastic": {36: 1501.4, 42: 1502.1, 46: 1503.2, 50: 1507.5, 54: 1544.5}, "passive": {42: 26.1, 46: 71.5, 50: 366.5, 54: 1205.4}}
    stressed = {"prestress": 1.5e6, "lock": "lock"}
    line = ((1.5, 36), (1.5, -14))
    constant = tendon(*line, 20e6, **stressed)
    constant["yield"] = 1.5e6 * (1 + 1e-7) / constant["area"]
    anchors = {"none": {}, "constant": {"a": constant}, "elastic": {"a": tendon(*line, 20e6, **stressed)}, "passive": {"a": tendon(*line, 200e6, **{"from": "lock"})}}
    stiffness = {"none": 0, "constant": 0, "elastic": 20e6, "passive": 200e6}
    for what, row in reference.items():
        levels = [h for h in LEVELS if h < 54 or what != "none"]
        stages = under_weight("own", "lock") + [{f"h{h}": {"loads": ["weight", f"water{h}"]}} for h in levels]
        methods = ("explicit", "preconditioned") if what in ("constant", "elastic") else ("preconditioned",)
        for method in methods:
            result = case.run(rigid_dam(), changed(dam_scene(anchors[what], stages, strain="small"), ("relaxation.method", method)))
            for h in levels:
                crack, toe, T = anchored(h, stiffness[what], 1.5e6 if what in ("constant", "elastic") else 0.0)
                if h in row:
                    case.check(f"VA05, {what}, level {h}: by hand against the reference: crack [m]", crack, row[h][0], absolute=2e-3)
                    case.check("... toe [Pa]", toe, 1e3 * row[h][1], relative=1e-3)
                joint = result.stage_summary(f"h{h}")["joints"]["default"]
                heel, end = (joint[at]["opening"] for at in ("start", "end"))  # of a straight line
                case.check(f"... {method}: open length [m]", 24 * max(heel, 0) / (heel - end), crack, absolute=1e-4 * max(crack, 1))
                case.check("... stress at the toe [Pa]", -joint["end"]["sigma"], toe, relative=1e-4)
                if what in forces:
                    case.check("... force [N]", force(result, f"h{h}"), T, absolute=1e-3 * T + 1)
                if h in forces.get(what, {}):
                    case.check("... force by hand against the reference [N]", T, 1e3 * forces[what][h], absolute=60)
    for what, T, wanted in (("none", 0.0, 51.536), ("constant", 1.5e6, 56.845)):
        stages = [*under_weight("own", "lock"), {"full": {"loads": ["weight", "water36"]}},
                  {"flood": {"type": "flood", "loads": ["weight", "water36"], "step": 4, "limit": 70, "bracket": 0.02, "displacement_limit": "inf"}}]  # fmt: skip
        result = case.run(rigid_dam(), changed(dam_scene(anchors[what], stages, strain="small"), ("relaxation.tolerance", 1e-7)))
        flood = result.stage_summary("flood")["flood"]
        case.check(f"VA05, {what}: overturns at level, by hand against the reference [m]", overturns(T), wanted, absolute=2e-3)
        case.check("... [m]", np.mean([flood["stable"], flood["failing"]]), wanted, relative=2e-3)


def slides_on_its_tendon(case):
    """A dam whose friction is lowered slides at T/N = tan(phi), as by hand; that its tendon holds it again some metres away does not count."""
    head, root = (1.5, 34.0), (11.5, -14.0)
    down, pull = np.array([head[0] - root[0], head[1] - root[1]]) / math.dist(head, root), 2e6
    water = 0.5 * 1000.0 * G * 36.0**2
    needed = (water - pull * down[0]) / (G * RHO * (0.5 * (24 + 4) * 32 + 4 * 4) + pull * down[1])
    anchors = {"a": tendon(head, root, 200 * pull / math.dist(head, root), prestress=pull, lock="lock")}
    stages = [*under_weight("own", "lock"), {"full": {"loads": ["weight", "water36"]}},
              {"less": {"type": "strength_reduction", "loads": ["weight", "water36"], "start": 45, "limit": 1, "bracket": 0.1}}]  # fmt: skip
    result = case.run(rigid_dam(), dam_scene(anchors, stages, contact={"connectivity": "variable"}, relaxation={}))
    found = result.stage_summary("less")["strength_reduction"]
    case.check("friction at which a dam slides on its tendon: stable, failing [degree]", [found["stable"], found["failing"]], math.degrees(math.atan(needed)), absolute=0.1)
    case.check("... moved, at most displacement_limit, 1 % of its size [m]", found["moved"] <= (found["displacement_limit"] or 0.0) < 0.01 * math.hypot(24, 36) + 1e-3, True)


# ---- VA07, VA09


def apart(gap=1.0):
    """Two blocks with a gap between, both held."""
    return join([renamed(rectangle(-1, -3, 2, 3, group="base", rigid=True), {}), renamed(rectangle(-1, gap, 2, 2, group="block", rigid=True), {}, {"mark": "bottom_left"})])


def moved(case, mesh, moving, path):
    """A folder of a scene whose motion is that of points (t, y) with straight lines between: velocities in steps."""
    folder = case.prepare(mesh, moving)
    rows = []
    for (t0, y0), (t1, y1) in zip(path, path[1:]):
        rows += [f"{t0:.17g},0,{(y1 - y0) / (t1 - t0):.17g}", f"{t1:.17g},0,{(y1 - y0) / (t1 - t0):.17g}"]
    (folder / "path.csv").write_text("t,x,y\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return folder


BAR = {"head": [0, 2], "root": [0, -2], "area": 8.0425e-4, "young": 200e9, "yield": 500e6}


def yields(case):
    """A bar of 4 m is opened to 20 mm, closed to 5 mm, opened to 12 mm, in time; each leg is a stage."""
    k, T_y = 8.0425e-4 * 200e9 / 4, 8.0425e-4 * 500e6
    path = [(0, 0), (0.1, 0.009), (0.2, 0.02), (0.3, 0.01), (0.4, 0.005), (0.5, 0.012)]
    stages = under_weight("own") + [{f"leg{i}": {"type": "dynamic", "loads": [], "duration": 0.1, "dt_factor": 0.05}} for i in range(1, 6)]
    moving = scene({"a": BAR}, stages, supports={"base": {"fix": "xy"}, "block": {"fix": "y", "motion": "path.csv"}},
                   relaxation={"history_every": 10, "allow_floating": True})
    for strain in ("small", "large"):
        result = case.again(moved(case, apart(), changed(moving, ("strain", strain)), path))
        case.check(f"VA07, {strain} strain: force at 9, 20, 10, 5 and 12 mm [N]", [force(result, f"leg{i}") for i in range(1, 6)],
                   [0.009 * k, T_y, 0, 0, 0.002 * k], absolute=1e-6 * T_y)
        case.check("... plastic elongation [m]", told(result, "leg5")["plastic"], 0.02 - T_y / k, relative=1e-6)
        case.check("... lost [J]", told(result, "leg5")["lost"], T_y * (0.02 - T_y / k), relative=1e-6)
        case.check("... states", [told(result, f"leg{i}")["state"] for i in (1, 2, 4, 5)], ["elastic", "yielded", "slack", "yielded"])
        seen = read_history(result.folder)["a"]
        wanted = np.array([0.0, *(min(y, T_y / k) if i < 3 else max(y - 0.02 + T_y / k, 0) for i, (_, y) in enumerate(path[1:], 1))])
        case.check("... anchor_history.csv: forces at the ends of the legs [N]", np.interp([t for t, _ in path], seen["time_s"], seen["force_N"])[1:], k * wanted[1:], absolute=2e-3 * T_y)
        peak = result.stage_summary("leg2")["peaks"]["anchors"]["a"]
        case.check("... peaks of leg 2: force, elongation [N], [m]", [peak["force"]["largest"], peak["elongation"]["largest"]], [T_y, 0.02], relative=1e-6)
        case.check("... when it yields first [s]", peak["force"]["time_largest"], 0.1 + 0.1 * (T_y / k - 0.009) / 0.011, absolute=2e-4)
        energy = result.stage_summary("leg2")["energy"]
        case.check("... work of the support in leg 2 [J]", energy["supports"], T_y * (0.01 + 0.5 * (0.01 - 0.009) * 1.9), relative=2e-3)
        case.check("... energy balance over it", energy["balance"] / energy["supports"], 0, absolute=2e-3)
        case.check("... lost, in the account [J]", result.stage_summary("leg2")["yielded"], T_y * (0.02 - T_y / k), relative=1e-3)


def lift_off(case):
    """A block on a joint of 20 GN/m with a tendon of 300 kN: the base falls ever faster, until the joint opens."""
    k, T, K, W = 32.17e6, 300e3, 20e9, 4 * RHO * G
    closure = (W + T) / K
    opens = (W + T + k * closure) / (4 * RHO)
    a = {"a": tendon((0, 1.7), (0, -3.2), k, prestress=T, lock="lock")}
    lifted = scene(a, under_weight("own", "lock"), K / 2, K / 2, relaxation={"tolerance": 1e-11})
    result = case.run(on_joint(), lifted)
    case.check("VA09: closure [m]", -result.probe("lock", "mark")[1], [closure, 0.019709e-3][0], relative=1e-6)
    case.check("... opens at (reference 41.126) [m/s2]", opens, 41.126, relative=1e-4)
    rate = 100.0  # m/s2 in a second
    for part, open_ in ((0.995, False), (1.005, True)):
        duration = part * opens / rate
        stages = [*under_weight("own", "lock"), {"falls": {"type": "dynamic", "loads": ["weight"], "duration": duration}}]
        falling = changed(lifted, ("stages", stages), ("supports.base", {"fix": "xy", "motion": "fall"}),
                          ("motions", {"fall": {"file": "fall.csv", "quantity": "acceleration"}}))
        folder = case.prepare(on_joint(), falling)
        (folder / "fall.csv").write_text(f"t,x,y\n0,0,0\n1,0,{-rate}\n", encoding="utf-8")
        result = case.again(folder)
        opening = result.stage("falls").contacts.opening.max()
        case.check(f"... base at {part} of it: open", bool(opening > 0), open_)
        case.check("... tendon [N] (reference 300.634e3 as it opens)", force(result, "falls"), T + k * (closure + opening), relative=1e-4)
        if not open_:
            case.check("... just before [N]", force(result, "falls"), 300.634e3, relative=1e-4)


# ---- failure


def failure(case):
    """A tendon that is pulled beyond its force breaks, and its load goes to the other one; one that is stretched beyond its strain breaks in time."""
    k = 40e6
    anchors = {"weak": tendon((-0.5, 1.7), (-0.5, -3.2), k, breaking_force=2e5), "strong": tendon((0.5, 1.7), (0.5, -3.2), k)}
    loads = {"weight": {"type": "self_weight", "groups": ["block"]}, "pull": {"type": "traction", "faces": "top", "value": [0, 4.5e5 / 2]}}
    stages = [{"own": {"loads": ["weight"]}}, {"pulled": {"loads": ["weight", "pull"]}}]
    for method in ("explicit", "preconditioned"):
        for pull, broken in ((4.5e5, False), (6e5, True)):
            pulled = changed(scene(anchors, stages, loads=loads, strain="small"), ("loads.pull.value", [0, pull / 2]), ("relaxation.method", method))
            pulled["supports"]["block"] = {"fix": "x"}
            result = case.run(on_joint(), pulled)
            lifts = pull - 4 * RHO * G
            wanted = [lifts / 2, lifts / 2]
            if broken:  # the block, held in x, does not turn
                case.check(f"breaks, {method}: reported", "anchor weak breaks at 2" in result.stdout, True)
                case.check("... state, lost [J]", [told(result, "pulled", "weak")["state"], round(told(result, "pulled", "weak")["lost"])],
                           ["broken", round((lifts / 2) ** 2 / 2 / k)])
                wanted = [0, lifts]
            case.check(f"pulled with {pull:g} N, {method}: forces [N]", [force(result, "pulled", name) for name in anchors], wanted, absolute=1)
    limit = 0.004
    stages = under_weight("own") + [{"opens": {"type": "dynamic", "loads": [], "duration": 0.1, "dt_factor": 0.05}}]
    moving = scene({"a": BAR | {"strain_limit": limit}}, stages, supports={"base": {"fix": "xy"}, "block": {"fix": "y", "motion": "path.csv"}},
                   relaxation={"history_every": 10, "allow_floating": True})
    for end, state in ((0.0159, "yielded"), (0.0165, "broken")):
        result = case.again(moved(case, apart(), moving, [(0, 0), (0.1, end)]))
        case.check(f"opened to {end} m of 0.016: state", told(result, "opens")["state"], state)
        T_y = 8.0425e-4 * 500e6
        case.check("... work of the support [J]", result.stage_summary("opens")["energy"]["supports"], T_y * (min(end, 0.016) - 0.005), relative=3e-3)
        case.check("... lost and stored [J]", told(result, "opens")["lost"] + told(result, "opens")["stored"], T_y * (min(end, 0.016) - 0.005), relative=3e-3)


# ---- large motion


def spinning(case):
    """Two blocks that fly past each other, tied by a bar: its force follows the line; the error of the account falls as the square of the step."""
    mesh = join([renamed(rectangle(x, 0, 1, 1, group=group, rigid=True), {}, {group: "bottom_left"}) for x, group in ((0, "block"), (4, "other"))])
    bar = tendon((0.8, 0.7), (4.3, 0.4), 1e6, compression=True)
    heavy = {"density": RHO, "rigid": True}
    balance = []
    for factor in (0.02, 0.01, 0.005):
        stages = [{"spins": {"type": "dynamic", "loads": [], "duration": 0.6, "dt_factor": factor}}]
        spun = scene({"a": bar}, stages, loads={}, strain="large", relaxation={"allow_floating": True, "history_every": 50},
                     materials={"block": heavy | {"velocity": [0, -5]}, "other": heavy | {"velocity": [0, 5]}})  # fmt: skip
        spun.pop("supports")
        result = case.run(mesh, spun)
        energy = result.stage_summary("spins")["energy"]
        balance.append(abs(energy["balance"]))
    apart_ = result.probe("spins", "other") - result.probe("spins", "block") + [4, 0]
    case.check("flying pair: the line has turned by more than a radian, the bar carries [N]", [math.atan2(apart_[1], apart_[0]) > 1, told(result, "spins")["largest"] > 3e4], [True, True])
    case.check("... error of the account by step, 0.02, 0.01, 0.005: order", np.log2(np.array(balance[:-1]) / balance[1:]), [2, 2], absolute=0.3)
    case.check("... error of the account over what moves", balance[-1] / energy["kinetic"], 0, absolute=1e-4)


# ---- ranks, restart, refusals


def checksums(result):
    return [stage["checksum"] for stage in result.summary["stages"]]


def seen_by(result):
    return (Path(result.folder) / "anchor_history.csv").read_text(encoding="utf-8")


def everything():
    """A deformable dam of two bodies on ground, tied by tendons that cross all of it: stressed, yielding, in trials, in time."""
    lower, upper = (renamed(quad_patch((0, y), (w0, y), (w1, y + 4), (0, y + 4), 6, 4, group="block"), {"upstream": "left"}, {}) for y, w0, w1 in ((0, 6, 4.5), (4, 4.5, 3)))
    mesh = join([renamed(rectangle(-6, -6, 18, 6, 9, 3, group="base"), {"bottom": "bottom"}), lower, upper])
    anchors = {"one": tendon((0.7, 7.6), (0.7, -5.3), 20e6, prestress=[2e5, 3e5], lock=["first", "again"], spacing=2.0, **{"yield": 1e12}),
               "two": tendon((1.3, 7.2), (3.1, -4.1), 30e6, prestress=2.5e5, lock="second", draw_in=1e-4), "bar": tendon((2.9, 5.5), (2.2, -2.2), 50e6, compression=True)}
    anchors["bar"]["yield"] = 1e4 / anchors["bar"]["area"]
    soft = {"density": RHO, "young": 5e9, "poisson": 0.2}
    stages = [{name: {"loads": ["weight"]}} for name in ("own", "first", "second", "again")]
    stages += [{"full": {"loads": ["weight", "water"]}}, {"flood": {"type": "flood", "loads": ["weight", "water"], "step": 4, "limit": 24, "bracket": 2}},
               {"less": {"type": "strength_reduction", "loads": ["weight", "water"], "start": 44, "step": 6, "limit": 25, "bracket": 2}},
               {"shake": {"type": "dynamic", "loads": ["weight", "water"], "duration": 0.02, "dt_factor": 0.3}}]  # fmt: skip
    return mesh, scene(anchors, stages, 10e9, 5e9, 45, strain="large", supports={"bottom": {"fix": "xy"}}, relaxation={"tolerance": 1e-5, "velocity_tolerance": 1e-5, "method": "explicit"},
                       materials={"block": soft, "base": soft | {"density": 2600}},
                       loads={"weight": {"type": "self_weight", "groups": ["block"]}, "water": {"type": "reservoir", "faces": "upstream", "level": 8}})  # fmt: skip


def ranks_and_restart(case):
    """The same bits on 1 to 4 ranks, and from checkpoints within stressing, trials and motion; what is reported too."""
    mesh, whole = everything()
    folder = case.prepare(mesh, changed(whole, ("checkpoint", {"every": 700, "keep": 1000})))
    first = case.again(folder)
    case.again(folder, "-output", "kept")
    names = [stage["name"] for stage in first.summary["stages"]]
    case.check("all stages run", [stage["verdict"] for stage in first.summary["stages"]], ["converged"] * (len(names) - 1) + ["completed"])
    case.check("the bar has yielded, the tendons are stressed [N]", [told(first, "less", "bar")["plastic"] != 0, force(first, "again", "one"), force(first, "second", "two")], [True, 3e5, 2.5e5])
    def anchors_of(result):
        of_stages = [result.stage_summary(name) for name in names if name != "flood"]
        of_stages += [trial for trial in result.stage_summary("flood")["flood"]["trials"] if trial["outcome"] == "stable"]
        return [[value for one in stage["anchors"].values() for value in one.values()] for stage in of_stages]
    def trials_of(result):
        return [trial["cycles"] for trial in result.stage_summary("flood")["flood"]["trials"]]
    for ranks in case.ranks(2, 3, 4):
        result = case.run(mesh, whole, ranks=ranks)
        case.check(f"checksums on {ranks} ranks", checksums(result), checksums(first))
        case.check("... the same numbers of all anchors", anchors_of(result) == anchors_of(first), True)
        case.check("... the same anchor_history.csv", seen_by(result) == seen_by(first), True)
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for i, at in enumerate((len(kept) // 8, len(kept) // 3, 2 * len(kept) // 3, len(kept) - 2)):
        again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
        case.check(f"restart from checkpoint {at} of {len(kept)}: checksums", checksums(again), checksums(first))
        case.check("... the same numbers of all anchors", anchors_of(again) == anchors_of(first), True)
        case.check("... the same anchor_history.csv", seen_by(again) == seen_by(first), True)
        case.check("... cycles of the trials of the flood", trials_of(again), trials_of(first))


def refused(case):
    """What only the mesh shows."""
    a = tendon((0, 1.7), (0, -3.2), 40e6)
    for keys, words in (({"head": [9, 9]}, "anchors.a.head: (9, 9) lies in no block of the mesh"), ({"root": [0, -30]}, "anchors.a.root: (0, -30) lies in no block"),
                        ({"head": [0.1, 0]}, "anchors.a.head: (0.1, 0) lies between two bodies"), ({"head": [0.1, 1.7], "root": [0.2, 1.6]}, "anchors.a.root: head and root lie in one block")):  # fmt: skip
        result = case.run(on_joint(), scene({"a": a | keys}, under_weight("own")))
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
    locked = tendon((0, 1.7), (0, -3.2), 40e6, prestress=1e5, lock="shake", draw_in=1e-4)
    for lock, words in (("shake", "anchors.a: lock: stage shake is not static"), ("own", "anchors.a: draw_in: stage shake in time begins as its head slips")):
        stages = under_weight("own") + [{"shake": {"type": "dynamic", "loads": ["weight"]}}]
        result = case.run(on_joint(), scene({"a": locked | {"lock": lock}}, stages))
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])

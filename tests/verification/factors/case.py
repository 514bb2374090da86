"""What a reduction of friction says of a stage whose joints have different angles: a factor of each joint that has contacts,
and of the stage where the joints that slide had one angle.

Rigid dam 80 m wide and 100 m high, water to the crest: tan(phi) N / T of the base, whatever angle a row without contacts has. A block
that slides beside one that stands: the factor of its plane. A block that pushes a wedge, on planes of different angles: none."""

import contextlib
import csv
import io
import json
import math
from pathlib import Path

import numpy as np
from driver import changed, load
from quoin_tools.base import results
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed
from quoin_tools.show import export, report

WHAT = "factors of a reduction of friction: dam 100 x 80 m with a default row, two planes, planes that slide together; collapse without factors; cohesion that breaks"
SOURCE = "statics: tan(phi) N / T on the base, tan(45) / tan(slope); where two angles slide there is no single factor; closed form of progressive failure"
BY = "by hand"

SCENE = {
    "relaxation": {"tolerance": 1e-8},
    "materials": {name: {"density": 2400, "rigid": True} for name in ("dam", "base")},
    "joints": {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 60}, "base": {"friction": 40}},
    "supports": {"base": {"target": "rock", "fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 100}},
}
REDUCTION = {"type": "strength_reduction", "what": "friction", "bracket": 0.02}


def dam():
    triangle = BlockMesh([(0, 0), (80, 0), (0, 100)], [(0, 1, 2, -1)], [0], ["dam"], [1], {"base": [(0, 0)], "upstream": [(0, 2)]}, {})
    return join([renamed(rectangle(-20, -10, 120, 10, group="base", rigid=True), {"base": "top", "rock": "bottom"}), triangle])


def plane(x, slope, name):
    """A block 1 m by 0.2 m on a plane that falls to the right."""
    angle = math.radians(slope)
    down, up = (math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))
    top = [(x + s * down[0], 3 + s * down[1]) for s in (0, 1, 2, 3)]
    ground = quad_patch((top[0][0], -1), (top[3][0], -1), top[3], top[0], 1, 1, "base", True)
    over = [(p[0] + 0.2 * up[0], p[1] + 0.2 * up[1]) for p in (top[2], top[1])]
    return [renamed(ground, {name: "top", "rock": "bottom"}), renamed(quad_patch(top[1], top[2], *over, 1, 1, "dam", True), {name: "bottom"})]


def reduced(case, mesh, scene, ranks=1):
    return case.run(mesh, changed(scene, ("stages", [{"all": {"loads": list(scene["loads"])}}, {"reduced": REDUCTION | {"loads": list(scene["loads"])}}])), ranks=ranks)


def found_in(result):
    return result.stage_summary("reduced")["strength_reduction"]


def run(case):
    single(case)
    two_planes(case)
    together(case)
    collapsed(case)
    another_seat(case)
    progressive(case)
    residual_friction(case)


def single(case):
    exact = math.tan(math.radians(40)) * (0.5 * 80 * 100 * 2400) / (0.5 * 1000 * 100**2)
    sums = []
    for other, ranks in ((60, 1), (60, 2), (75, 1)):
        result = reduced(case, dam(), changed(SCENE, ("joints.default.friction", other)), ranks)
        found = found_in(result)
        sums.append(json.dumps([found["factors"], result.stage_summary("reduced")["mechanism"]]))
        case.check(f"dam, default {other} degrees: factor, last stable", found["safety_factor_stable"], exact, relative=1.5e-3)
        case.check("... first failing", found["safety_factor_failing"], exact, relative=1.5e-3)
        case.check("... joints with a factor", list(found["factors"]), ["base"])
        case.check("... joints that move in the mechanism", list(result.stage_summary("reduced")["mechanism"]), ["base"])
        case.check("... first trial [degree]", found["trials"][0]["value"], 40.0, absolute=1e-9)
    case.check("... the same on 2 ranks, and whatever the default", len(set(sums)), 1)


def two_planes(case):
    scene = changed(SCENE, ("joints", {"default": SCENE["joints"]["default"], "rough": {"friction": 60}, "plane": {"friction": 45}}),
                    ("loads", {"weight": {"type": "self_weight", "groups": ["dam"]}}))
    result = reduced(case, join(plane(0, 30, "rough") + plane(10, 36.327, "plane")), scene)
    found, exact = found_in(result), 1 / math.tan(math.radians(36.327))
    case.check("planes of 60 and 45 degrees, the latter slides: factor, last stable", found["safety_factor_stable"], exact, relative=1e-3)
    case.check("... first failing", found["safety_factor_failing"], exact, relative=1e-3)
    case.check("... factor of the plane that stands", found["factors"]["rough"]["factor_failing"], math.tan(math.radians(60)) * exact, relative=1e-3)
    case.check("... the mechanism", list(result.stage_summary("reduced")["mechanism"]), ["plane"])
    row = exported(result, "plane")
    case.check("... exported", [row["friction [deg]"], row["factor failing"]], ["45", repr(found["safety_factor_failing"])])
    low = changed(scene, ("joints.rough.friction", 37), ("joints.plane.friction", 37))
    refused = case.run(result_mesh := join(plane(0, 30, "rough") + plane(10, 30, "plane")),
                       changed(low, ("stages", [{"reduced": REDUCTION | {"loads": ["weight"], "limit": 40}}])))
    case.check("limit between the friction of rows with and without contacts", [refused.exit_code, "limit: 40 is out of range" in refused.stderr], [2, True])
    refused = case.run(result_mesh, changed(low, ("stages", [{"reduced": REDUCTION | {"loads": ["weight"], "reduce": ["default"]}}])))
    case.check("a row without contacts reduced", [refused.exit_code, "has a contact" in refused.stderr], [2, True])


def together(case):
    wedge = load("wedge")
    loads = {"weight": {"type": "self_weight", "groups": ["block", "wedge"]},
             "push": {"type": "point_force", "point": "b_bottom_left", "value": [30e3, 0]}}
    scene = changed(SCENE, ("materials", {name: {"density": 2400, "rigid": True} for name in ("block", "wedge", "base")}), ("loads", loads),
                    ("supports", {"base": {"fix": "xy"}}),
                    ("joints", {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 0}, "block+base": {"friction": 50}, "wedge+base": {"friction": 40}}))
    found = found_in(result := reduced(case, wedge.two_on_base(), scene))
    case.check("planes of 50 and 40 degrees slide together: factor of the stage", found["safety_factor_failing"], None)
    case.check("... what the run says", "use what: strengths" in result.stage("reduced").evidence and "use what: strengths" in result.stdout, True)
    value = math.tan(math.radians(found["failing"]))
    texts = [results.report(result.summary), sheet(result)]
    case.check("... as do the table and the sheet", ["none: use strengths" in texts[0], "no single factor. Use what: strengths" in texts[1]], [True, True])
    case.check("... factor of each", [found["factors"][name]["factor_failing"] for name in ("block+base", "wedge+base")],
               [math.tan(math.radians(phi)) / value for phi in (50, 40)], relative=1e-9)


def sheet(result):
    with contextlib.redirect_stdout(io.StringIO()):
        report.main([result.folder])
    return (Path(result.folder) / "report.html").read_text()


def brittle(base, height, level, cohesion, friction):
    """Factors on all strengths of a rigid triangle whose cohesion breaks: closed form of deviations.md, l; of statics; whether the heel opens."""
    t, weight, thrust = math.tan(math.radians(friction)), 2400 * 9.81 * base * height / 2, 1000 * 9.81 * level**2 / 2
    moment = abs(thrust * level / 3 - weight * base / 6)  # about the middle of the base
    length, slope = base, 12 * moment / base**3
    opens = slope * base / 2 > weight / base
    if opens:
        length = 3 * (base / 2 - moment / weight)
        slope = 2 * weight / length**2
    q = cohesion / (slope * t)
    kept = cohesion * (q / 2 if q < length else length * (1 - length / (2 * q)))
    return (weight * t + kept) / thrust, (weight * t + cohesion * length) / thrust, opens


def progressive(case):
    """Rigid dams whose cohesion breaks part by part, all at once, and behind an open heel; and with cohesion that stays."""
    for base, height, level, cohesion, friction, parts in ((30, 42, 40, 0.2e6, 45, True), (24, 30, 27, 0.2e6, 45, False), (24, 42, 42, 0.1e6, 50, True)):
        edge = [(x, 0) for x in (0.0, 0.3 * base, base)]
        triangle = BlockMesh([*edge, (0, height)], [(0, 1, 3, -1), (1, 2, 3, -1)], [0, 0], ["dam"], [1], {"base": [(0, 0), (1, 0)], "upstream": [(0, 2)]}, {})
        rock = renamed(rectangle(-20, -10, base + 40, 10, group="base", rigid=True), {"rock": "bottom"})
        exact, statics, opens = brittle(base, height, level, cohesion, friction)
        what = f"dam {base} x {height} m, water {level} m, c = {cohesion / 1e6:g} MPa{', heel open' if opens else ''}"
        for residual in (0.0, cohesion) if parts and not opens else (0.0,):
            joint = SCENE["joints"]["default"] | {"friction": friction, "cohesion": cohesion, "cohesion_residual": residual}
            stages = [{"all": {"loads": ["weight", "water"]}}, {"reduced": {"type": "strength_reduction", "what": "strengths", "loads": ["weight", "water"], "bracket": 0.001}}]
            result = case.run(join([rock, triangle]), changed(SCENE, ("joints", {"default": joint}), ("loads.water.level", level), ("stages", stages)))
            found = found_in(result)
            case.check(f"{what}{', kept' if residual else ''}: factor on all strengths, last stable and first failing",
                       [found["safety_factor_stable"], found["safety_factor_failing"]], statics if residual else exact, relative=5e-3)
            case.check("... the sheet says that cohesion is lost part by part", "cohesion is lost where it is passed first" in sheet(result), not residual and statics > 1.1 * exact)


def pulled(height, peak, residual):
    """The largest pull over the weight of a rigid slab of 1 m on a joint whose friction falls to a residual where it is passed, at a height above
    the joint: progressive failure of deviations.md, with T linear in the pull, which also presses the far end. b: part that has failed."""
    t, t_r, most = math.tan(math.radians(peak)), math.tan(math.radians(residual)), 0.0
    for b in np.linspace(0.0, 1.0, 20001):
        # bears(F) = t_r int_0^b p + (1 - b) t p(b), p(x) = 1 + 12 F height (x - 1/2): linear in F, set equal to F
        fixed = t_r * b + (1 - b) * t
        slope = 12 * height * (t_r * (b**2 / 2 - b / 2) + (1 - b) * t * (b - 0.5))
        most = max(most, fixed / (1 - slope))
    return most


def residual_friction(case):
    """A slab pulled above its joint, whose friction of 45 degrees falls to 30: the end that is pressed least slips first, so the joint bears less than its
    peak friction; by fixed and variable connectivity, in one contact and in eight."""
    for height in (0.05, 0.1):
        exact = pulled(height, 45, 30)
        for n, connectivity in case.some(((1, "fixed"), (8, "fixed"), (1, "variable"), (8, "variable")), 2):
            slab = renamed(rectangle(0, 0, 1, 0.1, n, 2, group="dam", rigid=True), {})
            slab.points = {"hook": int(np.argmin(abs(slab.vertices - [1, height]).sum(axis=1)))}
            base = renamed(rectangle(-1, -0.5, 3, 0.5, 3, 1, group="base", rigid=True), {"rock": "bottom"})
            weight = 2400 * 9.81 * 0.1
            scene = changed(SCENE, ("joints", {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 45, "friction_residual": 30}}),
                            ("contact", {"connectivity": connectivity}),
                            ("loads", {"weight": {"type": "self_weight"}, "pull": {"type": "point_force", "point": "hook", "value": [weight, 0]}}),
                            ("stages", [{"all": {"loads": ["weight"]}},
                                        {"pulled": {"type": "load_factor", "raises": ["pull"], "loads": ["weight", "pull"], "start": 0.6 * exact, "step": 0.1, "limit": 1.5, "bracket": 0.002}}]))  # fmt: skip
            found = case.run(join([base, slab]), scene).stage_summary("pulled")["load_factor"]
            case.check(f"slab pulled {height:g} m above its joint, {n} blocks long, {connectivity}: pull over weight, last stable and first failing",
                       [found["stable"], found["failing"]], exact, relative=5e-3)


def exported(result, joint):
    """Row of a joint in factors.csv."""
    export.export(result)
    with open(Path(result.folder) / "factors.csv", encoding="utf-8", newline="") as file:
        return next(row for row in csv.DictReader(file) if row["joint"] == joint)


def collapsed(case):
    """Static stages whose friction is too small: no factor of a state that slides, and the mechanism instead."""
    stages = [{"sw": {"loads": ["weight"]}}, {"hp": {"loads": ["weight", "water"], "joints": {"base": {"friction": 26}}}}]
    result = case.run(dam(), changed(SCENE, ("stages", stages)))
    stage = result.stage_summary("hp")
    case.check("dam, base 26 degrees: verdict", stage["verdict"], "collapsed")
    case.check("... sliding factors", [stage["joints"]["base"][f"sliding_factor_{which}"] for which in ("peak", "residual")], [None, None])
    case.check("... joints that move in the mechanism", list(stage["mechanism"]), ["base"])
    text = sheet(result)
    case.check("... the sheet has the mechanism and its picture", ["Stage hp has collapsed: its mechanism" in text, "How it fails" in text], [True, True])
    case.check("... all of the dam moves along the base", result.stage("hp").mechanism[4:, 0], [1.0] * 3, absolute=0.02)


def another_seat(case):
    """A block on a plane of 30 degrees comes to rest 40 mm below, at a stop: stable at any friction, or failed where it has moved too far."""
    slope = math.radians(30)
    down, up = (math.cos(slope), -math.sin(slope)), (math.sin(slope), math.cos(slope))
    ends = [(2.04 * down[0], 3 + 2.04 * down[1]), (2.9 * down[0], 3 + 2.9 * down[1])]
    over = [(p[0] + 0.2 * up[0], p[1] + 0.2 * up[1]) for p in (ends[1], ends[0])]
    mesh = join([*plane(0, 30, "plane"), renamed(quad_patch(*ends, *over, 1, 1, "base", True), {"rock": "right"})])
    loads = {"weight": {"type": "self_weight", "groups": ["dam"]}}
    scene = changed(SCENE, ("joints", {"default": {"k_n": 10e9, "k_s": 10e9, "friction": 0}, "plane": {"friction": 45}}), ("loads", loads),
                    ("contact", {"tolerance": 0.1, "initial_gaps": "real"}))
    flat = {"type": "strength_reduction", "loads": ["weight"], "step": 5, "limit": 25, "bracket": 0.1}
    for limit in ("inf", 0.02):
        stage = flat | {"displacement_limit": limit}
        result = case.run(mesh, changed(scene, ("stages", [{"all": {"loads": ["weight"]}}, {"reduced": stage}])))
        found = found_in(result)
        if limit == "inf":
            case.check("block that comes to rest at a stop: stable, failing [degree]", [found["stable"], found["failing"]], [25.0, None])
            case.check("... way that every trial tells, the last one [m]", [found["moved"], found["trials"][-1]["moved"]], 0.04, absolute=1e-4)
            case.check("... evidence", "moved 0.04 m since the stage began" in result.stage("reduced").evidence, True)
        else:
            case.check("... displacement_limit 20 mm: stable, failing [degree]", [found["stable"], found["failing"]], 30.0, absolute=0.11)
            case.check("... it says that the block rests", "where it rests but beyond displacement_limit" in result.stage("reduced").evidence, True)
    size = 0.01 * math.hypot(*np.ptp(mesh.vertices[np.unique(mesh.blocks[mesh.block_group == mesh.group_names.index("dam")])], axis=0)[:2])
    for connectivity, limit in (("fixed", None), ("variable", None), ("variable", "inf")):
        stage = flat | ({} if limit is None else {"displacement_limit": limit})
        result = case.run(mesh, changed(scene, ("contact.connectivity", connectivity), ("stages", [{"all": {"loads": ["weight"]}}, {"reduced": stage}])))
        found = found_in(result)
        if limit:
            case.check("... variable connectivity, no limit: stable, failing [degree]", [found["stable"], found["failing"]], [25.0, None])
        else:
            case.check(f"... {connectivity} connectivity, 1 % of the size: stable, failing [degree]", [found["stable"], found["failing"]], 30.0, absolute=0.11)
            case.check("... displacement_limit [m]", found["displacement_limit"], size, absolute=1e-4)
            case.check("... in the evidence", "1 % of the size" in result.stdout, True)
